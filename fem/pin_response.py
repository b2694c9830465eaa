"""Response to a load on a pin: motions of the end sections and of the pin, and reactions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError, quoted
from crankbase.summaries import summarized
from fem.condensation import CondensedClass
from fem.end_reactions import LARGEST_LOAD
from fem.loads import Distribution, NodalLoads, pin_load, pin_surfaces
from fem.superelement import Superelement
from fem.supports import STRETCH, Support, all_end_motions
from fem.throw_frames import motion_table
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]


@summarized("displacement", "rotation")
@dataclass(frozen=True)
class Motion:
    """Mean motion of a section or of a pin, in the throw frame.

    Attributes
    ----------
    displacement : (3,) array
        [m]
    rotation : (3,) array
        [rad]
    """

    displacement: Array
    rotation: Array


@summarized(
    "lengthening [m]",
    "left: left.displacement [m]",
    "right: right.displacement [m]",
    "pin: pin.displacement [m]",
)
@dataclass(frozen=True)
class PinResponse:
    """Response of an axially free throw to a load on a pin.

    Attributes
    ----------
    left, right : Motion
        Of the end sections' centers; the left one is held along and about the shaft.
    pin : Motion
        Mean motion of the loaded pin's surface about its center.
    lengthening : float
        Lengthening of the throw [m].
    """

    left: Motion
    right: Motion
    pin: Motion
    lengthening: float

    def to_pandas(self) -> Any:
        """Return a table of the motions ux to rz of left end, pin and right end.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        places = {"left": self.left, "pin": self.pin, "right": self.right}
        return motion_table(
            {name: np.concatenate([one.displacement, one.rotation]) for name, one in places.items()}
        )


def equivalent_load(classes: Sequence[CondensedClass], load: NodalLoads) -> Array:
    """End loads (2 n,) equivalent to a load on a pin: its work on the end motions of the classes.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the part.
    load : NodalLoads
        One load case.
    """
    found = np.zeros(2 * classes[0].sections.count)
    for part in classes:
        work = np.einsum("sa,sak->k", load.of_class(part.symmetry)[..., 0], part.fields[load.nodes])
        found += part.shares.T @ work
    return found


def local_motion(classes: Sequence[CondensedClass], load: NodalLoads, pins: int) -> Array:
    """Mean motions (6 pins,) of all pins under a load on one of them, the end sections held.

    By reciprocity it is the work of the load on the fields of unit loads on the pins.
    """
    found = np.zeros(6 * pins)
    for part in classes:
        work = np.einsum(
            "sa,sac->c", load.of_class(part.symmetry)[..., 0], part.pin_fields[load.nodes]
        )
        found[part.pin_components @ (6, 1)] += work
    return found


def pin_response(
    throw: Superelement, support: Support, load: Array, local: Array, pin: int
) -> PinResponse:
    """Response of the axially free throw.

    Parameters
    ----------
    throw : Superelement
    support : "pinned", "guided" or Neighbors
    load : (m,) array
        From `end_load`.
    local : (6,) array
        The loaded pin's part of `local_motion`.
    pin : int
        Which pin.
    """
    motions = all_end_motions(throw, support, load[:, None])[:, 2]
    moved = local + throw.joined.pin_loads[pin, : len(motions)].T @ motions
    return PinResponse(
        Motion(motions[0:3], motions[3:6]),
        Motion(motions[6:9], motions[9:12]),
        Motion(moved[:3], moved[3:]),
        float(STRETCH @ motions[:12]),
    )


def pin_compliance(throw: Superelement, support: Support, pin: int) -> Array:
    """Mean motions (6, 6) of a pin per unit force and moment on it, the throw axially free."""
    place = slice(6 * pin, 6 * pin + 6)
    loads = throw.joined.pin_loads[pin]
    motions = all_end_motions(throw, support, loads)[:, 2:]
    return np.asarray(throw.pin_flexibility[place, place] + loads[: len(motions)].T @ motions)


def checked_vector(name: str, given: ArrayLike, unit: str) -> Array:
    """Return three finite numbers.

    Raises
    ------
    InputError
        If they are not finite, or one is beyond `LARGEST_LOAD`.
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
    mesh: ThrowMesh, pin: int, force: ArrayLike, moment: ArrayLike, distribution: Distribution
) -> NodalLoads:
    """Distribute a force and a moment (3,) over a pin of the throw.

    Raises
    ------
    InputError
        If they are not three finite numbers each, there is no such pin, or the distribution is unknown.
    """
    given = checked_vector("force", force, "N"), checked_vector("moment", moment, "N m")
    return pin_load(pin_surfaces(mesh)[checked_pin(pin, len(mesh.pins))], *given, distribution)


def unevenness(
    mesh: ThrowMesh, pin: int, force: ArrayLike, moment: ArrayLike, distribution: Distribution
) -> NodalLoads:
    """Difference between a distributed load and the same uniform force and moment; errors as `spread_load`.

    Responses to uniform loads are corrected for discretization; those to the self-equilibrated rest
    are uncorrected.
    """
    spread = spread_load(mesh, pin, force, moment, distribution)
    even = spread_load(mesh, pin, force, moment, "uniform")
    return replace(spread, values=spread.values - even.values)


def end_load(
    superelement: Superelement,
    classes: Sequence[CondensedClass],
    mesh: ThrowMesh,
    pin: int,
    force: ArrayLike,
    moment: ArrayLike,
    distribution: Distribution,
) -> Array:
    """End loads (m,) equivalent to a force and a moment (3,) on a pin; errors as above.

    On the motions of the superelement where throws meet, the 12 of rigid sections first.
    """
    given = checked_vector("pin_force", force, "N"), checked_vector("pin_moment", moment, "N m")
    pins = superelement.joined.pin_loads
    uniform = pins[checked_pin(pin, len(mesh.pins))] @ np.concatenate(given)
    if distribution == "uniform":
        return np.asarray(uniform)
    return np.asarray(
        uniform + equivalent_load(classes, unevenness(mesh, pin, *given, distribution))
    )


def pin_motion(
    superelement: Superelement,
    classes: Sequence[CondensedClass],
    mesh: ThrowMesh,
    pin: int,
    force: Array,
    moment: Array,
    distribution: Distribution,
) -> Array:
    """Mean motion (6,) of a pin under a force and a moment (3,) on it, the end sections held."""
    place = slice(6 * pin, 6 * pin + 6)
    even = superelement.pin_flexibility[place, place] @ np.concatenate([force, moment])
    if distribution == "uniform":
        return np.asarray(even)
    uneven = unevenness(mesh, pin, force, moment, distribution)
    return np.asarray(even + local_motion(classes, uneven, len(mesh.pins))[place])
