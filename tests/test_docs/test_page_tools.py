"""What makes the pages."""

import ast
import importlib.util
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from printed_text import difference

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
    ("kept", "printed", "same"),
    [
        ("e_n 1.302e-9 m/N", "e_n  1.303e-9 m/N", True),
        ("e_n 1.302e-9 m/N", "e_n 1.304e-9 m/N", False),
        ("497.8 1/min of 6chn25-34", "497.9 1/min of 6chn25-34", True),
        ("497.8 1/min of 6chn25-34", "497.8 1/min of 6chn25-35", False),
        ("cylinder 4, 1240 kN", "cylinder 4, 1241 kN", True),
        ("cylinder 4, 1240 kN", "cylinder 5, 1240 kN", False),
        ("residual 2e-15", "residual 7e-16", True),
        ("residual 2e-15", "residual 2e-9", False),
        ("stress of 21.2 MPa", "stress of 21.2 kPa", False),
        ("a\nb", "a", False),
    ],
)
def test_printed_text_is_compared_by_words_and_last_digits(kept, printed, same):
    assert (difference(kept, printed) == "") is same


ROOT = Path(__file__).resolve().parents[2]
VALIDATION = ROOT / "tests" / "validation"
FILES = sorted(path.stem for path in VALIDATION.glob("test_*.py"))


def loaded(path):
    spec = importlib.util.spec_from_file_location(f"read_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def build():
    return loaded(ROOT / "docs" / "build_validation.py")


@pytest.fixture(scope="module")
def recorder():
    return loaded(VALIDATION / "conftest.py")


@pytest.fixture(scope="module")
def figures(build):
    return json.loads(build.FIGURES.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_page_is_current(build):
    assert build.PAGE.read_text(encoding="utf-8") == build.page()


def test_table_has_a_line_for_each_case(build, figures):
    lines = re.findall(r'^\| <a id="(test_\w+)">', build.page(), flags=re.MULTILINE)
    assert sorted(lines) == FILES == sorted(figures)


def test_the_figures_that_the_table_shows_first_are_recorded_ones(build, figures):
    for files in build.GROUPS.values():
        for file, named in files.items():
            shown = [row["what"] for row in build.shown_rows(file, figures[file])]
            assert shown[: len(named)] == list(named)


@pytest.mark.parametrize("label", ["Source", "Tolerance"])
@pytest.mark.parametrize("file", FILES)
def test_source_and_tolerance_of_a_case_are_short(build, file, label):
    assert 1 <= len(build.paragraph(file, label).split()) <= 45


@pytest.mark.parametrize("file", FILES)
def test_figures_belong_to_tests_that_there_are(file, figures):
    """And no test that records one is without its figures."""
    recording = {
        node.name
        for node in ast.parse((VALIDATION / f"{file}.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
        and node.name.startswith("test_")
        and "figure" in {argument.arg for argument in node.args.args}
    }
    assert {test.partition("[")[0] for test in figures[file]["tests"]} == recording
    for found in figures[file]["tests"].values():
        assert all(row["deviation"] <= row["allowed"] for row in found)


# What the recorder takes for right and wrong.


def test_a_figure_within_what_is_allowed_is_recorded_at_its_worst(recorder):
    row = recorder.compared("frequencies", [10.0, 20.1], [10.0, 20.0], 0.01, "Hz")
    assert (row["found"], row["reference"], row["unit"]) == (20.1, 20.0, "Hz")
    assert row["deviation"] == close(0.005)


@pytest.mark.parametrize(
    ("found", "reference", "named"),
    [
        (1.02, 1.0, {}),
        ([1.0, 1.02], 1.0, {}),
        (-1.0, 1.0, {}),
        (math.nan, 1.0, {}),
        ([1.0, math.nan, 1.0], 1.0, {}),
        (math.inf, 1.0, {}),
        (1e-13, 0.0, {}),  # nothing is near zero by itself
        (1.0000002e-13, 1e-13, {"allowed": 1e-7}),  # nor are small numbers alike
        (5.02, 5.0, {"kind": "absolute"}),
        (5.3, 5.0, {"scale": 10.0}),
        (1j, 1.0, {}),
    ],
)
def test_a_wrong_figure_fails(recorder, found, reference, named):
    with pytest.raises(AssertionError, match="the thing: found"):
        recorder.compared("the thing", found, reference, **{"allowed": 0.01} | named)


def test_of_one_name_the_worst_stays_and_numbers_are_counted(recorder):
    rows = [recorder.compared("way", found, 1.0, 0.1) for found in ([1.0, 1.01], 1.05, 1.02)]
    kept = None
    for row in rows:
        kept = recorder.worse(kept, row)
    assert (kept["found"], kept["numbers"]) == (1.05, 4)


def test_what_is_infinite_or_zero_on_both_sides_is_alike(recorder):
    assert recorder.compared("limits", [1.0, np.inf, 0.0], [1.0, np.inf, 0.0], 1e-9)["found"] == 1.0


@pytest.mark.parametrize(
    ("row", "texts"),
    [
        (
            (1.2811e-9, 1.281e-9, 7.8e-5, 0.01, "relative", "m/N"),
            ("1.28e-9", "1.28e-9", "0.0078 %", "1 %"),
        ),
        ((942.9e3, 942.9e3, 12.0, 50.0, "absolute", "N"), ("942900", "942900", "12 N", "50 N")),
        (
            (279.683, 279.68, 0.003, 0.005, "absolute", "N m"),
            ("279.683", "279.68", "0.003 N m", "0.005 N m"),
        ),
        ((1.0, 1.0, 3.1e-7, 1e-5, "relative", ""), ("1", "1", "3.1e-5 %", "0.001 %")),
        ((0.5, 0.4, 0.01, 0.05, "scaled", "N"), ("0.5", "0.4", r"1 % \*", r"5 % \*")),
        ((4.2e-6, 0.0, 4.2e-6, 1e-5, "absolute", ""), ("4.2e-6", "0", "4.2e-6", "1e-5")),
    ],
)
def test_numbers_as_they_are_shown(build, row, texts):
    keys = ("found", "reference", "deviation", "allowed", "kind", "unit")
    shown = build.shown(dict(zip(keys, row, strict=True)))
    assert tuple(text.replace(build.NO_BREAK, " ") for text in shown) == texts


@pytest.mark.parametrize(
    ("found", "expected", "allowed", "same"),
    [
        (1.0000009e-9, 1e-9, {}, True),
        (1.000002e-9, 1e-9, {}, False),  # less than 1e-12 apart
        (1.0009e-9, 1e-9, {"rel": 1e-3}, True),
        (1e-13, 0.0, {}, False),  # nothing is near zero by itself
        (1e-13, 0.0, {"abs": 1e-12}, True),
        (1.0 + 1e-7, 1.0, {"abs": 1e-8}, False),  # beside `abs` nothing is allowed unasked
        (1.0 + 1e-7, 1.0, {"abs": 1e-8, "rel": 1e-6}, True),
        ([1.0, 2.0], [1.0, 2.1], {"rel": 0.01}, False),
        (math.nan, math.nan, {}, False),
        (math.nan, math.nan, {"nan_ok": True}, True),
    ],
)
def test_numbers_are_compared_however_small_they_are(found, expected, allowed, same):
    assert (found == close(expected, **allowed)) is same
