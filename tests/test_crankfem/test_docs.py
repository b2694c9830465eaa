"""Pages that are made from declarations are current, and the README keeps its promises."""

import importlib.util
import re
from pathlib import Path

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
