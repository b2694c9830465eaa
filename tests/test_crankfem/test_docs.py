"""Pages that are made from declarations, and the README."""

import doctest
import importlib
import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_page_of_engine_files_is_current():
    script = ROOT / "docs" / "build_engine_files.py"
    spec = importlib.util.spec_from_file_location("build_engine_files", script)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (ROOT / "docs" / "engine-files.md").read_text(encoding="utf-8") == module.page()


def test_readme_has_one_line_for_the_main_job_and_one_for_the_tests():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if "apt-get install" in line]
    assert len(lines) == 2
    assert lines[0].endswith("crankfem run data/engines/6chn25-34.toml")
    assert lines[1].endswith(".venv/bin/pytest")


def test_readme_installs_every_system_library_that_errors_name():
    from geometry.gmsh_session import DEBIAN_PACKAGES

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for needed in (
        "libglu1-mesa",
        "libgl1",
        "libxrender1",
        "libxcursor1",
        "libxft2",
        "libxinerama1",
    ):
        assert needed in DEBIAN_PACKAGES.values()
        assert len(re.findall(rf"\b{needed}\b", text)) == 2


README_ROOT = Path(__file__).resolve().parents[2]
# Their doctests mesh and solve.
SLOW = {"crankfem.compliance", "fem.analysis", "fem.fillet_stress", "fem.superelement"}


def modules():
    """Yield name and source file of every module."""
    for name in ("crankfem", "geometry", "fem", "regression", "dynamics", "crankbase"):
        for path in sorted((README_ROOT / name).rglob("*.py")):
            parts = path.relative_to(README_ROOT).with_suffix("").parts
            yield ".".join(parts).removesuffix(".__init__"), path


def has_examples(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return any(">>>" in line and "+SKIP" not in line for line in lines)


EXAMPLES = [name for name, path in modules() if has_examples(path)]


def test_every_module_can_be_imported():
    for name, _ in modules():
        importlib.import_module(name)


@pytest.mark.further
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in EXAMPLES],
)
def test_examples_in_docstrings(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.skipif(not (README_ROOT / "README.md").is_file(), reason="no README here")
def test_commands_and_names_in_the_readme_exist():
    import typer.main

    from crankfem.cli import app as cli

    text = (README_ROOT / "README.md").read_text(encoding="utf-8")
    commands = set(typer.main.get_command(cli.app).commands)
    named = set(re.findall(r"crankfem (?=[a-z])(\w+)(?= +[\w.\-/]+\.(?:toml|json|sqlite))", text))
    assert named
    assert named <= commands
    for target in re.findall(r"\]\(((?!http)[^)#]+)\)", text):
        assert (README_ROOT / target).exists() or target.endswith(".png"), target
