"""Cases that satellites add to the tests of the core."""

from importlib import import_module
from pathlib import Path

from crankfem.files.satellites import SATELLITES

FOLDER = Path(__file__).with_name("satellites")


def of_satellites(name):
    """Join the mappings of this name in `tests/satellites/NAME/cases.py`, of the satellites that have one."""
    joined = {}
    for satellite in SATELLITES:
        if (FOLDER / satellite / "cases.py").is_file():
            joined |= getattr(import_module(f"satellites.{satellite}.cases"), name, {})
    return joined
