import doctest
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# Their doctests mesh and solve.
SLOW = {"fem.analysis", "fem.fillet_stress", "fem.shaft"}


def modules():
    """Yield name and source file of every module."""
    for name in ("crankfem", "geometry", "fem", "regression", "dynamics"):
        for path in sorted((ROOT / name).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts).removesuffix(".__init__"), path


def has_examples(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return any(">>>" in line and "+SKIP" not in line for line in lines)


EXAMPLES = [name for name, path in modules() if has_examples(path)]


def test_every_module_can_be_imported():
    for name, _ in modules():
        importlib.import_module(name)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in EXAMPLES],
)
def test_examples_in_docstrings(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.skipif(not (ROOT / "README.md").is_file(), reason="no README here")
def test_commands_and_names_in_the_readme_exist():
    import typer.main

    from crankfem.cli import app as cli

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = set(typer.main.get_command(cli.app).commands)
    named = set(re.findall(r"crankfem (?=[a-z])(\w+)(?= +[\w.\-/]+\.(?:toml|json|sqlite))", text))
    assert named
    assert named <= commands
    assert f"[{'docs/method.md'}]" in text
    for target in re.findall(r"\]\(((?!http)[^)#]+)\)", text):
        assert (ROOT / target).exists() or target.endswith(".png"), target
