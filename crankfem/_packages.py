"""Make sure that crankfem's own packages are the ones that Python finds."""

from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("geometry", "fem", "regression", "dynamics")


def check_packages() -> None:
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
