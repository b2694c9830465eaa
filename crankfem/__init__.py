"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

Everything a user needs has a name here; the packages behind it are internal. Names are loaded when
first used, so that looking a compliance up does not load a mesher. The stub beside this file declares
them all, once.
"""

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

PACKAGES = ("crankbase", "geometry", "fem", "regression", "dynamics")


def _check_packages() -> None:
    """Refuse to work beside a foreign package that has the name of one of ours.

    Raises
    ------
    ImportError
        Naming the foreign package and where it lies.
    """
    home = Path(__file__).resolve().parent.parent
    for name in PACKAGES:
        spec = find_spec(name)
        if spec is None:
            raise ImportError(
                f"crankfem is not completely installed: its package {name!r} is missing from {home}; "
                "install it again."
            )
        where = {Path(place).resolve() for place in spec.submodule_search_locations or ()}
        if home / name not in where:
            found = spec.origin or ", ".join(str(place) for place in where)
            raise ImportError(
                f"crankfem needs its own package {name!r} from {home}, but Python finds another one "
                f"first: {found}; rename that one, or start Python elsewhere."
            )


_check_packages()


@cache
def _homes() -> dict[str, tuple[str, str]]:
    """Return each public name with its home and its name there, as the stub says."""
    import ast

    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    return {
        alias.asname or alias.name: (str(statement.module), alias.name)
        for statement in stub.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return sorted(_homes())
    # Python asks for names of its own, such as __path__; the stub is not read for them.
    if name.startswith("__") or name not in _homes():
        raise AttributeError(f"module 'crankfem' has no attribute {name!r}")
    from importlib import import_module

    home, name_there = _homes()[name]
    value = getattr(import_module(home), name_there)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_homes()})
