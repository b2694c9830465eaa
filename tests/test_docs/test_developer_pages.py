"""Pages for developers name files that there are, and the code overview shows the packages."""

import importlib.util
import re
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs" / "developers").glob("*.md"))]
PATH = re.compile(r"`([\w.*-]+/[\w./*-]*|[\w-]+\.(?:toml|md|cff)|\.[\w-]+\.yaml)`")
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def build_map():
    path = ROOT / "docs" / "build_map.py"
    spec = importlib.util.spec_from_file_location("build_map", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def drawn(build_map):
    return ElementTree.fromstring(build_map.drawing())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_a_page_names_are_there(page):
    named = PATH.findall(page.read_text(encoding="utf-8"))
    wrong = [name for name in named if not any(ROOT.glob(name.rstrip("/")))]
    # A folder of each package, and an engine of one's own.
    assert not [name for name in wrong if name != "plots/"]


def test_the_map_is_current(build_map):
    assert build_map.DRAWING.read_text(encoding="utf-8") == build_map.drawing()


def test_its_packages_and_layers_are_those_of_the_contracts(build_map, drawn):
    texts = list(drawn.iter(f"{SVG}text"))
    packages = [text.text for text in texts if text.get("class") == "package"]
    layers = build_map.contracts()
    assert set(packages) == {name for row in layers[""] for name in row}
    names = [text.text for text in texts if text.get("class") == "name"]
    for package in ("dynamics", "regression"):
        listed = [name for row in layers[package] for name in row]
        place = names.index(listed[0])
        assert names[place : place + len(listed)] == listed


def test_arrows_lead_down_and_pass_over_no_box(build_map, drawn):
    rows = [set(row) for row in build_map.contracts()[""]]
    place = {name: number for number, row in enumerate(rows) for name in row}
    arrows = build_map.arrows()
    assert {line.find(f"{SVG}title").text for line in drawn.iter(f"{SVG}line")} == {
        f"{one} imports {other}" for one, other in arrows
    }
    assert all(place[one] < place[other] for one, other in arrows)
    assert ("dynamics", "fem") not in arrows
    boxes = [
        [float(box.get(key)) for key in ("x", "y", "width", "height")]
        for box in drawn.iter(f"{SVG}rect")
        if box.get("rx") == "8"
    ]
    for line in drawn.iter(f"{SVG}line"):
        x, top, bottom = (float(line.get(key)) for key in ("x1", "y1", "y2"))
        assert bottom > top
        for left, up, width, height in boxes:
            assert not (left < x < left + width and top < up + height and bottom > up)


def test_nothing_of_the_map_is_cut_off(build_map, drawn):
    """Bands follow each other without overlap; letters of 11.5 px are some 6 px wide."""
    for text in drawn.iter(f"{SVG}text"):
        assert float(text.get("x")) + 6.0 * len(text.text) < build_map.WIDTH - build_map.MARGIN
    bands = {}
    for box in drawn.iter(f"{SVG}rect"):
        if box.get("rx") == "4":
            start = float(box.get("y"))
            bands.setdefault(box.get("x"), []).append((start, start + float(box.get("height"))))
    assert sum(len(column) for column in bands.values()) > 20
    for column in bands.values():
        assert all(one[1] <= other[0] for one, other in pairwise(sorted(column)))
