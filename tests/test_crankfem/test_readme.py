import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

from crankfem.throw_file import load_throw
from fem import fillet_stress

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
TOML_BLOCK = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
# Their doctests mesh and solve.
SLOW = {"fem.analysis", "fem.fillet_stress", "fem.shaft"}


def examples():
    """All blocks of a page together: later ones use names of earlier ones."""
    for page in PAGES:
        blocks = BLOCK.findall(page.read_text(encoding="utf-8"))
        # That page's examples ask a model that its own test makes (test_lookup_command.py).
        if blocks and page.name != "lookup.md":
            yield pytest.param("\n".join(blocks), id=page.name)


def throw_files():
    for page in PAGES:
        for number, block in enumerate(TOML_BLOCK.findall(page.read_text(encoding="utf-8")), 1):
            if "[throw]" in block:
                yield pytest.param(block, id=f"{page.name}-{number}")


@pytest.mark.parametrize("text", list(throw_files()))
def test_throws_in_the_documentation_can_be_built(text, tmp_path):
    path = tmp_path / "throw.toml"
    path.write_text(text, encoding="utf-8")
    throw, _ = load_throw(path)
    assert throw.volume > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("code", list(examples()))
def test_examples_in_the_documentation_run(monkeypatch, coarse_stresses, code):
    """With names of their own, and stresses on meshes as coarse as can be."""
    for name, value in coarse_stresses.items():
        monkeypatch.setattr(fillet_stress, name, value)
    exec(compile(code, "example", "exec"), {"__name__": "__main__"})


def modules():
    for name in ("crankfem", "geometry", "fem", "regression", "dynamics"):
        package = importlib.import_module(name)
        yield name
        for found in pkgutil.walk_packages(package.__path__, f"{name}."):
            yield found.name


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name
        for name in sorted(modules())
    ],
)
def test_examples_in_docstrings(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


@pytest.mark.skipif(not (ROOT / "README.md").is_file(), reason="no README here")
def test_commands_and_names_in_the_readme_exist():
    import typer.main

    from crankfem import cli

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = set(typer.main.get_command(cli.app).commands)
    named = set(re.findall(r"crankfem (?=[a-z])(\w+)(?= +[\w.\-/]+\.(?:toml|json|sqlite))", text))
    assert named
    assert named <= commands
    assert f"[{'docs/method.md'}]" in text
    for target in re.findall(r"\]\(((?!http)[^)#]+)\)", text):
        assert (ROOT / target).exists() or target.endswith(".png"), target
