"""``pytest tests/snapshots -m "" --rewrite`` keeps what is printed now in place of what was kept."""

import re
from pathlib import Path

import pytest

from printed_text import difference

# Fixtures of tests of commands: pytest finds them by name.
from test_crankfem.conftest import (  # noqa: F401
    _own_folder,
    call,
    coarsely,
    finished_run,
    lightly,
    quick_six,
    six_cylinders,
    unseen,
)

FOLDER = Path(__file__).parent
# What differs from run to run, and what stands for it.
MARKS = (
    (re.compile(r"(?m)^.*━.*\n\n?"), ""),  # progress
    (re.compile(r"\bcrankfem \d+\.\d+\.\d+\S*"), "crankfem VERSION"),
    (re.compile(r"(?m)^(?:CPython )?\d+\.\d+\.\d+$"), "VERSION"),
    (re.compile(r"(?m)^Machine: .*"), "Machine: MACHINE"),
    (re.compile(r"\d+ \w+ \d{4}, \d\d:\d\d UTC"), "DATE"),
    (re.compile(r"(?m)\b(?:\d+ min )?\d+(?:\.\d+)? s$"), "TIME"),
    (re.compile(r"\d{4}-\d\d-\d\d(?:[ T]\d\d:\d\d(?::\d\d)?)?"), "DATE"),
)

# Their numbers rest on meshes at fillets, which differ within their error between processors: words alone
# are kept.
OF_FILLETS = ("stress-", "report-of-all")
NUMBER = re.compile(r"[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?")


def pytest_addoption(parser):
    parser.addoption("--rewrite", action="store_true", help="keep what is printed as snapshots")


def masked(text):
    """Text without times and versions, with marks in place of paths."""
    text = text.replace(str(Path.cwd()), "FOLDER").replace(str(FOLDER.parents[1]), "CHECKOUT")
    for pattern, mark in MARKS:
        text = pattern.sub(mark, text)
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())


@pytest.fixture
def compare(request):
    """Compare text with the snapshot of a name, or write that; a difference shows as a diff."""

    def compared(name, text):
        path, text = FOLDER / f"{name}.txt", masked(text)
        if name.startswith(OF_FILLETS):
            text = re.sub(" +", " ", NUMBER.sub("#", text))
        kept = path.read_text(encoding="utf-8") if path.is_file() else ""
        differs = difference(kept, text, path.name)
        if differs and request.config.getoption("--rewrite", default=False):
            path.write_text(text, encoding="utf-8")
        else:
            assert not differs, f"tests/snapshots: keep it with --rewrite if it is right\n{differs}"

    return compared
