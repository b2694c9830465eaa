"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

What most work begins with has a name here, all else one in a topic, such as `cf.chains.with_damper`;
the packages behind them are internal. Names are loaded when first used, so that looking a compliance
up does not load a mesher. The stubs, here and in the topics' folders, declare them all, once.
"""

from importlib.util import find_spec
from pathlib import Path

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

# Only now is it sure that this is our own one.
from crankbase.public_names import lazy_exports  # noqa: E402

__getattr__, __dir__ = lazy_exports(__name__, __file__)
