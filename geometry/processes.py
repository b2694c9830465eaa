"""Processes of our own: how a new Python finds our packages."""

import os
from pathlib import Path


def package_environment() -> dict[str, str]:
    """Environment in which a new Python finds our packages, however this one did."""
    home = str(Path(__file__).resolve().parent.parent)
    paths = [home, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
