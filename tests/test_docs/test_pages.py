"""Every block of the documentation runs, in the order of its page, in an empty folder.

Python blocks of a page share their names. Blocks of toml, csv, txt, text or json with a title are
written to the file of that name. Lines of sh blocks that begin with `crankfem` go through the command
line (`# exit code 2` at their end says that they shall end so, `> file` keeps what they print); other
lines, and console blocks, are for the reader. A text block that follows a Python block shows what that
prints. `<!-- not run: reason -->` leaves the next block out.
"""

import re
from pathlib import Path

import pytest

LONG = ("slow-speed-plant", "v-engine")  # over 5 s
ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def name(page):
    return page.relative_to(ROOT).as_posix()


def marked(page):
    """Return the page, among the further tests if it takes engines or studies through a run."""
    text = page.read_text(encoding="utf-8")
    whole = re.search(r"(?m)^ *crankfem (run|doe|stress|vibration)\b", text)
    marks = [pytest.mark.further] if whole or page.stem in LONG else [pytest.mark.slow]
    return pytest.param(page, marks=marks, id=name(page))


@pytest.mark.parametrize("page", [marked(page) for page in PAGES])
def test_blocks_of_the_page_run(page, run_page):
    run_page(page)


def throws():
    for page in PAGES:
        if "[throw]" in page.read_text(encoding="utf-8"):
            yield pytest.param(page, id=name(page))


@pytest.mark.parametrize("page", list(throws()))
def test_throws_of_the_page_can_be_built(page, page_tools, tmp_path):
    from crankfem.files.engine.throw_file import load_throw

    blocks_of, _, _ = page_tools
    for block in blocks_of(page.read_text(encoding="utf-8")):
        if block.language == "toml" and "[throw]" in block.text and not block.not_run:
            path = tmp_path / "throw.toml"
            path.write_text(block.text, encoding="utf-8")
            throw, _ = load_throw(path)
            assert throw.volume > 0.0
