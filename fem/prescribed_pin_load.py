"""A load on a pin as it is given: numbers checked, and spread over the pin's surface."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError, quoted
from fem.condensation import CondensedClass
from fem.loads import Distribution, NodalLoads, pin_load, pin_surfaces
from fem.pin_response import equivalent_load
from fem.superelement import Superelement
from geometry.mesh import ThrowMesh

# Far beyond any real load, far below what overflows.
LARGEST_LOAD = 1e30


def checked_vector(name: str, given: ArrayLike, unit: str) -> NDArray[np.float64]:
    """Return three finite numbers.

    Raises
    ------
    InputError
        If they are not, or one is beyond `LARGEST_LOAD`.
    """
    try:
        vector = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.all(np.abs(vector) <= LARGEST_LOAD):
        raise InputError(
            f"{name}: given {quoted(given)}; allowed are three finite numbers [{unit}], none beyond "
            f"{LARGEST_LOAD:g}."
        )
    return vector


def checked_pin(pin: int, count: int) -> int:
    """Return the number of a pin, from 0, of a throw with so many.

    Raises
    ------
    InputError
        If there is no such pin.
    """
    pins = "one pin" if count == 1 else f"{count} pins"
    return whole_within("pin", pin, 0, count - 1, f"the throw has {pins}")


def spread_load(
    mesh: ThrowMesh,
    pin: int,
    force: ArrayLike,
    moment: ArrayLike,
    distribution: Distribution,
) -> NodalLoads:
    """Spread a force and a moment (3,) over a pin of the throw.

    Raises
    ------
    InputError
        If they are not three finite numbers each, there is no such pin, or the distribution is unknown.
    """
    given = checked_vector("force", force, "N"), checked_vector("moment", moment, "N m")
    return pin_load(pin_surfaces(mesh)[checked_pin(pin, len(mesh.pins))], *given, distribution)


def end_load(
    superelement: Superelement,
    classes: Sequence[CondensedClass],
    mesh: ThrowMesh,
    pin: int,
    force: ArrayLike,
    moment: ArrayLike,
    distribution: Distribution,
) -> NDArray[np.float64]:
    """End loads (12,) that a force and a moment (3,) on a pin are equivalent to; errors as above."""
    given = checked_vector("pin_force", force, "N"), checked_vector("pin_moment", moment, "N m")
    if distribution == "uniform":
        place = checked_pin(pin, len(mesh.pins))
        return np.asarray(superelement.pin_loads[place] @ np.concatenate(given))
    return equivalent_load(classes, spread_load(mesh, pin, *given, distribution))
