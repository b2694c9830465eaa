"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

Everything a user needs has a name here; the packages behind it are internal. Names are loaded when
first used, so that looking a compliance up does not load a mesher. The stub beside this file declares
them all, once.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

from crankfem._packages import check_packages

check_packages()


def _homes() -> dict[str, tuple[str, str]]:
    """Return each public name with its home and its name there, as the stub says."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    return {
        alias.asname or alias.name: (str(statement.module), alias.name)
        for statement in stub.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }


_HOMES = _homes()
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'crankfem' has no attribute {name!r}")
    home, name_there = _HOMES[name]
    value = getattr(import_module(home), name_there)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
