"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

The most used names are here, all others in topics, such as `cf.chains.with_damper`;
the packages behind them are internal. Names are loaded on first use, so that a compliance
lookup does not load a mesher. The stubs, here and in the topics' folders, declare all names.
"""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

PACKAGES = ("crankbase", "geometry", "fem", "regression", "dynamics")


def _check_packages() -> None:
    """Refuse to work with a foreign package that has the name of one of ours.

    Raises
    ------
    ImportError
        Naming the foreign package and its location.
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

# Only now is it sure that this is our own one.
from crankbase.public_names import lazy_exports  # noqa: E402

_public_name, __dir__ = lazy_exports(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name, or the version, which is the one that results record."""
    if name == "__version__":
        from crankfem.analyses.provenance import program_version

        return program_version()
    return _public_name(name)
