"""Every block of the documentation runs; pages for developers name what there is."""

import ast
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

LONG = ("gallery", "hinge", "slow-speed-plant", "v-engine")  # over 5 s
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


@pytest.mark.further
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

    blocks_of, _ = page_tools
    for block in blocks_of(page.read_text(encoding="utf-8")):
        if block.language == "toml" and "[throw]" in block.text and not block.not_run:
            path = tmp_path / "throw.toml"
            path.write_text(block.text, encoding="utf-8")
            throw, _ = load_throw(path)
            assert throw.volume > 0.0


GENERATED = re.compile(r"validation.*|engine-files")


def test_every_public_name_is_shown_to_a_reader():
    """In a page that somebody wrote, or in an example: a name that nobody is shown has no use."""
    written = [page for page in PAGES if not GENERATED.fullmatch(page.stem)]
    examples = [path for path in (ROOT / "examples").iterdir() if path.is_file()]
    text = "\n".join(path.read_text(encoding="utf-8") for path in (*written, *examples))
    shown = set(re.findall(r"\w+", text))
    stubs = sorted((ROOT / "crankfem").rglob("*.pyi"))
    names = {
        f"{stub.parent.name}.{alias.asname}"
        for stub in stubs
        for statement in ast.parse(stub.read_text(encoding="utf-8")).body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }
    assert len(names) > 300
    assert sorted(name for name in names if name.partition(".")[2] not in shown) == []


DEVELOPER_PAGES = [ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs" / "developers").glob("*.md"))]
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


@pytest.mark.parametrize("page", DEVELOPER_PAGES, ids=lambda page: page.name)
def test_files_that_a_page_names_are_there(page):
    named = PATH.findall(page.read_text(encoding="utf-8"))
    wrong = [name for name in named if not any(ROOT.glob(name.rstrip("/")))]
    # A folder of each package, and an engine of one's own.
    assert not [name for name in wrong if name != "plots/"]


@pytest.mark.slow
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


@pytest.fixture(scope="module")
def topics(root):
    path = root / "docs" / "hooks" / "api_topics.py"
    spec = importlib.util.spec_from_file_location("api_topics", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["api_topics"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    module.NAMES = module.public_names()
    yield module
    del sys.modules["api_topics"]


def test_every_public_name_has_one_place_and_a_line_in_the_index(topics, public):
    pages = topics.pages(topics.NAMES)
    index = pages.pop("api/index.md")
    placed = [name for text in pages.values() for name in re.findall(r"^::: ([\w.]+)$", text, re.M)]
    assert sorted(placed) == sorted(public)
    listed = re.findall(r"^\| \[`cf\.([\w.]+)`\]", index, re.M)
    assert sorted(f"crankfem.{name}" for name in listed) == sorted(public)


def test_every_name_and_topic_is_described(topics):
    assert [one.path for one in topics.NAMES if not one.summary] == []
    assert [one.package for one in topics.topics() if not one.summary] == []


def test_every_topic_shows_the_way_in_and_has_a_line_in_the_navigation(topics, root):
    pages = topics.pages(topics.NAMES)
    navigation = (root / "mkdocs.yml").read_text(encoding="utf-8")
    for topic in topics.topics():
        assert f": api/{topic.file}.md\n" in navigation
        if topic.file != "crankfem":
            assert "```pycon\n>>> " in pages[f"api/{topic.file}.md"]


EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
WHOLE = ("crankshaft_against_chain", "study_and_equation")  # over 10 s


def example_marked(script):
    mark = pytest.mark.further if script.stem in WHOLE else pytest.mark.slow
    return pytest.param(script, marks=mark, id=script.stem)


@pytest.mark.further
@pytest.mark.parametrize("script", [example_marked(script) for script in SCRIPTS])
def test_an_example_answers(script, tmp_path):
    paths = os.pathsep.join((str(EXAMPLES.parent), os.environ.get("PYTHONPATH", "")))
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": paths},
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert 2 <= len(done.stdout.splitlines()) <= 40
    assert "nan" not in done.stdout.lower().split()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_an_example_is_one_question_and_short(script):
    lines = script.read_text(encoding="utf-8").splitlines()
    assert len(lines) < 60
    assert lines[0].startswith('"""')
    assert lines[0].endswith('?"""')


@pytest.mark.further
def test_every_plot_of_a_notebook_is_shown(monkeypatch):
    nbformat, nbclient = (
        pytest.importorskip(name, reason="needs crankfem[dev]") for name in ("nbformat", "nbclient")
    )
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parent))
    made = "import crankfem as cf\nmodes = cf.Chain([0.1, 0.78], [9e5]).modes()"
    cells = [nbformat.v4.new_code_cell(code) for code in (made, *["modes.plot();"] * 3)]
    nbclient.NotebookClient(nbformat.v4.new_notebook(cells=cells)).execute()
    shown = [sum("image/png" in one.get("data", {}) for one in cell.outputs) for cell in cells]
    assert shown == [0, 1, 1, 1]


NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))


@pytest.mark.further
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(tmp_path, monkeypatch, path):
    nbformat, nbclient = (
        pytest.importorskip(name, reason="needs crankfem[dev]") for name in ("nbformat", "nbclient")
    )
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parent))
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any(cell.get("outputs") for cell in notebook.cells)
