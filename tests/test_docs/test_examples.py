"""Every example runs in an empty folder, answers on one screen, and is short enough to be read."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
WHOLE = ("crankshaft_against_chain", "study_and_equation")  # over 10 s


def marked(script):
    mark = pytest.mark.further if script.stem in WHOLE else pytest.mark.slow
    return pytest.param(script, marks=mark, id=script.stem)


@pytest.mark.parametrize("script", [marked(script) for script in SCRIPTS])
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


@pytest.mark.further
def test_the_lecture_runs(tmp_path, monkeypatch):
    nbformat, nbclient = (
        pytest.importorskip(name, reason="needs crankfem[dev]") for name in ("nbformat", "nbclient")
    )
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parent))
    notebook = nbformat.read(EXAMPLES / "lecture.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any(cell.get("outputs") for cell in notebook.cells)
