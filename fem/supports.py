"""A throw under each named support: compliances, influence coefficient, reactions, response to a pin load."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Integers
from crankbase.choices import is_number, whole_within
from crankbase.errors import InputError, quoted
from crankbase.results import Internal, Quantity, Result, result
from fem.end_reactions import LARGEST_LOAD, EndReaction, Reactions, motion_table
from fem.superelement import RX, RY, RZ, UX, UY, UZ, CondensedClass, Superelement, section_rotation
from fem.symmetry import (
    RADIAL,
    Distribution,
    NodalLoads,
    diagonal_blocks,
    pin_load,
    pin_surfaces,
)
from geometry.mesh import ThrowMesh

LONGEST_CHAIN = 64
# Softer than this share of the stiffest is a motion of a class that was not solved.
UNSOLVED = 1e-11
# Motions of an end section that a support holds at both ends; besides, the left end is held along and
# about the shaft.
HELD = {"pinned": (UX, UY), "guided": (UX, UY, RX, RY)}
# Differences of the two ends' motions: lengthening and twist. They are also the end loads of a unit
# force and a unit torque through the throw.
STRETCH = np.zeros(12)
STRETCH[[UZ, 6 + UZ]] = -1.0, 1.0
TWIST = np.zeros(12)
TWIST[[RZ, 6 + RZ]] = -1.0, 1.0


@dataclass(frozen=True)
class Neighbors:
    """Support by identical throws on both sides.

    The right neighbor's crank is turned by `right_deg` about +z, the left one's by ``-left_deg``;
    each side continues with its own step until the compliance no longer changes. All main journals are
    held laterally and tilt freely.

    Parameters
    ----------
    left_deg, right_deg : float
        Crank angle steps [deg]; equal values make a helix.
    """

    left_deg: float
    right_deg: float

    def __post_init__(self) -> None:
        for name in ("left_deg", "right_deg"):
            value = getattr(self, name)
            if not is_number(value):
                raise InputError(
                    f"Neighbors.{name}: given {quoted(value)}; allowed is a finite angle in degrees."
                )


Support = Literal["pinned", "guided"] | Neighbors
# Supports of the table of compliances, by the names it gives them.
TABLE_SUPPORTS: Mapping[str, Support] = {
    "pinned": "pinned",
    "guided": "guided",
    **{f"neighbors {step:g} deg": Neighbors(step, step) for step in (0.0, 90.0, 120.0, 180.0)},
}


@result("axial", "torsional", "influence")
class Compliances(Result):
    """Compliances of a throw under one support, or their errors."""

    axial: Annotated[float, Quantity("m/N", "e_n", key="axial_compliance")]
    torsional: Annotated[float, Quantity("rad/(N m)", key="torsional_compliance")]
    influence: Annotated[
        float,
        Quantity(
            "m/N",
            "coefficient c: lengthening per unit radial force on the first pin",
            key="influence_coefficient",
        ),
    ]


@result("axial", "torsional", "influence", eq=True)
class SupportedThrow(Compliances):
    """Compliances of a throw under one support, for loads on each pin.

    Attributes
    ----------
    stretches : (pins, 3) array
        Lengthening of the axially free throw per unit force on each pin along x, y, z [m/N]; under
        `Neighbors` all throws carry that force, each in its own frame.
    influences : (pins,) array
        Lengthening per unit radial force on each pin, towards the shaft [m/N].
    """

    stretches: Internal[Array]
    influences: Internal[Array]


def support_throw(throw: Superelement, support: Support) -> SupportedThrow:
    """Compliances of a throw under a support.

    Parameters
    ----------
    support : "pinned", "guided" or Neighbors

    Raises
    ------
    InputError
        If the support is unknown.
    """
    motions = end_motions(throw, support)
    stretches = (STRETCH @ motions[:, 2:]).reshape(-1, 6)[:, :3]
    influences = np.sum(stretches * throw.radials, axis=1)
    return SupportedThrow(
        axial=float(STRETCH @ motions[:, 0]),
        torsional=float(TWIST @ motions[:, 1]),
        influence=float(influences[:1].sum()),
        stretches=stretches,
        influences=influences,
    )


def reactions(throw: Superelement, support: Support, load: Array) -> Reactions:
    """End forces on a throw with a loaded pin and constant length.

    Parameters
    ----------
    support : "pinned", "guided" or Neighbors
        The left end takes the torque. Under `Neighbors` every throw carries the same pin load in its
        own frame, its left end takes its torque and axial push, and a force along the whole chain
        keeps the length of the middle throw.
    load : (m,) array
        End loads equivalent to the load on the pin, such as ``throw.joined.pin_loads[pin] @ p``.
    """
    motions = all_end_motions(throw, support, load[:, None])
    under_load = motions[:, 2]
    axial_force = -(STRETCH @ under_load[:12]) / (STRETCH @ motions[:12, 0])
    combined = under_load + axial_force * motions[:, 0]
    stiffness = throw.stiffness if len(combined) == 12 else throw.joined.stiffness
    forces = (stiffness @ combined)[:12] - load[:12]
    return Reactions(
        EndReaction(forces[0:3].copy(), forces[3:6].copy()),
        EndReaction(forces[6:9].copy(), forces[9:12].copy()),
    )


def free_motions(ends: Array, support: str) -> Integers:
    """Which of some motions of both end sections a support leaves free.

    Parameters
    ----------
    ends : (12, k) array
        The motions, each of one kind: those of a symmetry class, or all twelve unit motions.
    support : {"pinned", "guided"}

    Returns
    -------
    (f,) array
        Numbers of columns. Columns that move the left end alone along or about the shaft are left
        excluded, since a rigid motion of the throw keeps it in place; a class that mirrors the ends has
        columns that move both apart instead, which lengthen or twist the throw and stay.
    """
    both = np.abs(ends).reshape(2, 6, -1)
    held = both[:, HELD[support]].any(axis=(0, 1))
    rigid = (both[0, [UZ, RZ]] > both[1, [UZ, RZ]]).any(axis=0)
    return np.flatnonzero(~held & ~rigid)


FREE_ENDS = {support: free_motions(np.eye(12), support) for support in HELD}


def end_motions(throw: Superelement, support: Support, pin_loads: Array | None = None) -> Array:
    """Mean motions (12, 2 + m) of a throw's end sections under unit loads; see `all_end_motions`."""
    return all_end_motions(throw, support, pin_loads)[:12]


def all_end_motions(throw: Superelement, support: Support, pin_loads: Array | None = None) -> Array:
    """Motions of a throw's end sections under unit loads.

    Parameters
    ----------
    support : "pinned", "guided" or Neighbors
    pin_loads : (12 or all, m) array, optional
        End loads equivalent to loads on the pins; by default those of the six unit loads on
        each pin. Those on other motions than the mean ones are zero by default.

    Returns
    -------
    (12 or all, 2 + m) array
        Under a unit axial force, a unit torque, and the pin loads; between neighbors all motions of the
        joined superelement. The right end is free to move along the shaft, so these load cases carry any
        other.

    Raises
    ------
    InputError
        If the support is unknown.
    """
    joined = throw.joined
    if pin_loads is None:
        pin_loads = joined.pin_loads.transpose(1, 0, 2).reshape(len(joined.stiffness), -1)
    if isinstance(support, Neighbors):
        loads = np.zeros((len(joined.stiffness), pin_loads.shape[1]))
        loads[: len(pin_loads)] = pin_loads
        return _between_neighbors(joined, loads, support)
    if not isinstance(support, str) or support not in HELD:
        raise InputError(
            f'support: given {support!r}; allowed are "pinned", "guided" or '
            "Neighbors(left_deg, right_deg), because the compliance depends on it severalfold."
        )
    loads = np.column_stack([STRETCH, TWIST, pin_loads[:12]])
    free = FREE_ENDS[support]
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(throw.stiffness[np.ix_(free, free)], loads[free])
    return motions


def _between_neighbors(throw: Superelement, pin_loads: Array, support: Neighbors) -> Array:
    """Motions (all, 2 + m) of a throw between neighbors.

    Axial force and torque through the throws are known: those of the load case, and under a pin force
    none, since each throw's left end takes its own torque and axial push (otherwise they would add up
    along the chain). So only the tilts, and the bending of the sections, couple the
    throws, and solving for these alone stays accurate however long the chain.
    """
    bending = throw.sections.bending
    sides = [
        np.r_[6 * end + RX, 6 * end + RY, 12 + bending * end + np.arange(bending)] for end in (0, 1)
    ]
    coupled, through = np.concatenate(sides), np.array([6 + UZ, 6 + RZ])
    uncoupled, coupling, through_part = (
        throw.stiffness[np.ix_(rows, columns)]
        for rows, columns in ((coupled, coupled), (coupled, through), (through, through))
    )
    forces = np.hstack([np.eye(2), pin_loads[through]])
    carried = np.linalg.solve(through_part, coupling.T).T
    condensed = uncoupled - carried @ coupling.T
    loads = np.hstack([np.zeros((len(coupled), 2)), pin_loads[coupled]]) - carried @ forces

    @cache
    def turn(angle_deg: float) -> Array:
        angle = math.radians(angle_deg)
        return diagonal_blocks(section_rotation(angle)[:2, :2], throw.sections.turn(angle))

    if support.left_deg == support.right_deg:
        # An endless helix: the right section is the right neighbor's left one, which moves as this throw's
        # left one but turned. Motions that loads do not excite by symmetry may be without stiffness.
        turned = turn(support.right_deg)
        both = np.vstack([np.eye(len(turned)), turned])
        free = np.linalg.pinv(both.T @ condensed @ both, UNSOLVED, hermitian=True)
        moved = both @ free @ (both.T @ loads)
    else:
        moved = _chain_motions(condensed, loads, support, turn)
    motions = np.zeros((len(throw.stiffness), loads.shape[1]))
    motions[coupled] = moved
    motions[through] = np.linalg.solve(through_part, forces - coupling.T @ moved)
    return motions


def _chain_motions(
    throw: Array, loads: Array, support: Neighbors, turn: Callable[[float], Array]
) -> Array:
    """Coupled motions of the middle throw of a chain long enough that they no longer change."""
    reach, before = 4, np.full(loads.shape, np.inf)
    while True:
        motions = _middle_motions(throw, loads, support, turn, reach)
        change = np.abs(motions - before).max(axis=0)
        if np.all(change <= 1e-10 * np.abs(motions).max(axis=0)) or 2 * reach > LONGEST_CHAIN:
            return motions
        before, reach = motions, 2 * reach


def _middle_motions(
    throw: Array, loads: Array, support: Neighbors, turn: Callable[[float], Array], reach: int
) -> Array:
    """Coupled motions of the middle one of 2 reach + 1 throws."""
    from scipy.linalg import solve_banded  # here: a throw in a helix does without

    count = len(throw) // 2
    stiffness = np.zeros((count * (2 * reach + 2),) * 2)
    sides = np.zeros((len(stiffness), loads.shape[1]))
    # Each section moves in the frame of the throw on its right: the throws of a side are alike.
    to_left, to_right = (
        diagonal_blocks(np.eye(count), turn(angle))
        for angle in (support.left_deg, support.right_deg)
    )
    for places, both in ((range(reach), to_left), (range(reach, 2 * reach + 1), to_right)):
        own_stiffness, own_loads = both.T @ throw @ both, both.T @ loads
        for place in places:
            part = slice(count * place, count * place + 2 * count)
            stiffness[part, part] += own_stiffness
            sides[part] += own_loads
    middle = slice(count * reach, count * reach + 2 * count)
    # Only sections that one throw joins are coupled.
    width = 2 * count - 1
    banded = np.zeros((2 * width + 1, len(stiffness)))
    for off in range(-width, width + 1):
        diagonal = np.diagonal(stiffness, off)
        start = max(off, 0)
        banded[width - off, start : start + len(diagonal)] = diagonal
    return np.asarray(to_right @ solve_banded((width, width), banded, sides)[middle])


def class_axial_compliances(part: CondensedClass, support: str) -> tuple[float, float]:
    """Axial compliance e_n and influence coefficient c of the first pin, both [m/N].

    Parameters
    ----------
    part : CondensedClass
        The meshed part's `fem.symmetry.axial_class`.
    support : {"pinned", "guided"}
    """
    pull = STRETCH @ part.symmetry.ends
    lengthening = axial_motion(part, support)
    # An end part of a crankshaft has no pin.
    radial = part.pin_loads[:1, :, :3].sum(axis=0) @ RADIAL
    return float(lengthening @ pull), float(lengthening @ radial)


def axial_motion(part: CondensedClass, support: str) -> Array:
    """Amplitudes (k,) of the class under a unit axial force; arguments as for `class_axial_compliances`."""
    return unit_response(part, support, STRETCH @ part.symmetry.ends)


def unit_response(part: CondensedClass, support: str, load: Array) -> Array:
    """Amplitudes (k,) of the supported class under a load (k,) that does work on its unit motions.

    Multiplied with a second load they are, by reciprocity, also the motion of the first one under that.
    """
    free = free_motions(part.symmetry.ends, support)
    stiffness = part.symmetry.copies * part.stiffness[np.ix_(free, free)]
    amplitudes = np.zeros(len(load))
    amplitudes[free] = np.linalg.solve(stiffness, load[free])
    return amplitudes


@result("displacement", "rotation", eq=True)
class Motion(Result):
    """Mean motion (3,) of a section or of a pin, in the throw frame."""

    displacement: Annotated[Array, Quantity("m")]
    rotation: Annotated[Array, Quantity("rad")]


@result(
    "lengthening",
    "left: left.displacement",
    "right: right.displacement",
    "pin: pin.displacement",
    eq=True,
)
class PinResponse(Result):
    """Response of an axially free throw to a load on a pin.

    Attributes
    ----------
    left, right : Motion
        Of the end sections' centers; the left one is held along and about the shaft.
    pin : Motion
        Mean motion of the loaded pin's surface about its center.
    """

    left: Motion
    right: Motion
    pin: Motion
    lengthening: Annotated[float, Quantity("m", "of the throw")]

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
            {
                name: np.concatenate([motion.displacement, motion.rotation])
                for name, motion in places.items()
            }
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
    end_loads = np.zeros(2 * classes[0].sections.count)
    for part in classes:
        work = np.einsum("sa,sak->k", load.of_class(part.symmetry)[..., 0], part.fields[load.nodes])
        end_loads += part.shares.T @ work
    return end_loads


def local_motion(classes: Sequence[CondensedClass], load: NodalLoads, pins: int) -> Array:
    """Mean motions (6 pins,) of all pins under a load on one of them, the end sections held.

    By reciprocity it is the work of the load on the fields of unit loads on the pins.
    """
    motion = np.zeros(6 * pins)
    for part in classes:
        work = np.einsum(
            "sa,sac->c", load.of_class(part.symmetry)[..., 0], part.pin_fields[load.nodes]
        )
        motion[part.pin_components @ (6, 1)] += work
    return motion


def pin_response(
    throw: Superelement, support: Support, load: Array, local: Array, pin: int
) -> PinResponse:
    """Response of the axially free throw.

    Parameters
    ----------
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


def checked_vector(name: str, value: ArrayLike, unit: str) -> Array:
    """Return three finite numbers.

    Raises
    ------
    InputError
        If they are not finite, or one is beyond `LARGEST_LOAD`.
    """
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.all(np.abs(vector) <= LARGEST_LOAD):
        raise InputError(
            f"{name}: given {quoted(value)}; allowed are three finite numbers [{unit}], none beyond "
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
    load = checked_vector("force", force, "N"), checked_vector("moment", moment, "N m")
    return pin_load(pin_surfaces(mesh)[checked_pin(pin, len(mesh.pins))], *load, distribution)


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
    load = checked_vector("pin_force", force, "N"), checked_vector("pin_moment", moment, "N m")
    pins = superelement.joined.pin_loads
    uniform = pins[checked_pin(pin, len(mesh.pins))] @ np.concatenate(load)
    if distribution == "uniform":
        return np.asarray(uniform)
    return np.asarray(
        uniform + equivalent_load(classes, unevenness(mesh, pin, *load, distribution))
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
