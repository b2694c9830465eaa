import re

import pytest

PAGE = """
# A page

```toml title="folder/mine.toml"
[throw]
```

1. An item

    ```python
    x = 1
    ```

<!-- not run: needs a cluster -->

```sh
crankfem doe study.toml --dask tcp://10.0.0.1:8786
```

```text
1
```
"""


@pytest.fixture
def blocks_of(page_tools):
    return page_tools[0]


def test_blocks_with_titles_indents_and_reasons(blocks_of):
    toml, python, sh, text = blocks_of(PAGE)
    assert (toml.title, toml.text, toml.line) == ("folder/mine.toml", "[throw]\n", 4)
    assert python.text == "x = 1\n"
    assert sh.not_run == "needs a cluster"
    assert text.not_run is None


@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("<!-- not run: -->\n```sh\n```\n", "needs a reason"),
        ("<!-- not run: why -->\nwords\n", "stands right before a block"),
        ("<!-- not run: why -->\n", "stands right before a block"),
        ("```python\nx = 1\n", "has no end"),
    ],
)
def test_marks_and_fences_that_cannot_be_meant(blocks_of, page, told):
    with pytest.raises(AssertionError, match=told):
        blocks_of(page)


def test_commands_with_comments_codes_and_files(page_tools):
    text = """
pip install crankfem
crankfem check mine.toml   # what is assumed
crankfem check bad.toml    # exit code 2
crankfem lookup model.json \\
    web_width=300mm --json > found.json
crankfem optimum model.json --limit "mass <= 100 kg"
"""
    assert list(page_tools[1](text)) == [
        (["check", "mine.toml"], 0, None),
        (["check", "bad.toml"], 2, None),
        (["lookup", "model.json", "web_width=300mm", "--json"], 0, "found.json"),
        (["optimum", "model.json", "--limit", "mass <= 100 kg"], 0, None),
    ]


def test_a_pipe_is_refused(page_tools):
    with pytest.raises(AssertionError, match="not run so"):
        list(page_tools[1]("crankfem check mine.toml | less"))


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("e_n = 1.23e-09 m/N", "e_n = 1.23e-09 m/N", True),
        ("e_n = 1.23e-09 m/N", "e_n = 1.24e-09 m/N", True),  # one unit of the last digit
        ("e_n = 1.23e-09 m/N", "e_n = 1.25e-09 m/N", False),
        ("e_n = 1.23e-09 m/N", "e_n = 1.23e-08 m/N", False),
        ("[1.5 2]", "[1.5  2]", True),
        ("41.8 Hz", "41.8 kHz", False),
        ("one", "one\ntwo", False),
    ],
)
def test_shown_and_printed(page_tools, shown, printed, same):
    assert (page_tools[2](shown, printed) is None) is same


def test_python_blocks_share_names_and_text_shows_what_they_print(run_page, tmp_path):
    page = tmp_path / "page.md"
    good = '```python\nx = 2\n```\n\n```python\nprint(f"{x / 3:.3f} m")\n```\n\n```text\n0.667 m\n```\n'
    page.write_text(good, encoding="utf-8")
    assert run_page(page) == 2
    page.write_text(good.replace("0.667", "0.670"), encoding="utf-8")
    with pytest.raises(AssertionError, match=re.escape("page.md, line 9 shows")):
        run_page(page)


def test_files_are_written_and_commands_have_their_codes(run_page, tmp_path):
    page = tmp_path / "page.md"
    good = '```toml title="bad.toml"\n[throw]\n```\n\n```sh\ncrankfem check bad.toml  # exit code 2\n```\n'
    page.write_text(good, encoding="utf-8")
    assert run_page(page) == 2
    assert (tmp_path / "bad.toml").read_text(encoding="utf-8") == "[throw]\n"
    page.write_text(good.replace("# exit code 2", ""), encoding="utf-8")
    with pytest.raises(AssertionError, match="ended with 2"):
        run_page(page)
