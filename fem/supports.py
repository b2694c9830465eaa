"""What a throw does under each named support: compliances, influence coefficient, reactions."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.scalars import is_number
from crankbase.errors import InputError, quoted
from fem.end_reactions import EndReaction, Reactions
from fem.superelement import RX, RY, RZ, UX, UY, UZ, Superelement, section_rotation

Array = NDArray[np.float64]
LONGEST_CHAIN = 64
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
    each side goes on with its own step until the compliance no longer changes. All main journals are
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


@dataclass(frozen=True)
class SupportedThrow:
    """Answers of a throw under one support.

    Attributes
    ----------
    axial : float
        e_n [m/N].
    torsional : float
        [rad/(N m)]
    stretches : (pins, 3) array
        Lengthening of the axially free throw per unit force on each pin along x, y, z [m/N]; under
        `Neighbors` all throws carry that force, each in its own frame.
    influences : (pins,) array
        Lengthening per unit radial force on each pin, towards the shaft [m/N].
    """

    axial: float
    torsional: float
    stretches: Array
    influences: Array

    @property
    def influence(self) -> float:
        """Influence coefficient c: lengthening per unit radial force on the first pin [m/N]."""
        return float(self.influences[0])


def support_throw(throw: Superelement, support: Support) -> SupportedThrow:
    """Compliances of a throw under a support.

    Parameters
    ----------
    throw : Superelement
    support : "pinned", "guided" or Neighbors

    Raises
    ------
    InputError
        If the support is none of these.
    """
    motions = end_motions(throw, support)
    stretches = (STRETCH @ motions[:, 2:]).reshape(-1, 6)[:, :3]
    return SupportedThrow(
        axial=float(STRETCH @ motions[:, 0]),
        torsional=float(TWIST @ motions[:, 1]),
        stretches=stretches,
        influences=np.sum(stretches * throw.radials, axis=1),
    )


def reactions(throw: Superelement, support: Support, load: Array) -> Reactions:
    """End forces on a throw of which a pin is loaded and whose length is kept.

    Parameters
    ----------
    throw : Superelement
    support : "pinned", "guided" or Neighbors
        The left end takes the torque. Under `Neighbors` every throw carries the same pin load in its
        own frame, its left end takes its torque and axial push, and a force along the whole chain
        keeps the length of the middle throw.
    load : (12,) array
        End loads that the load on the pin is equivalent to, such as ``throw.pin_loads[pin] @ p``.

    Returns
    -------
    Reactions
    """
    motions = end_motions(throw, support, load[:, None])
    under_load = motions[:, 2]
    axial_force = -(STRETCH @ under_load) / (STRETCH @ motions[:, 0])
    combined = under_load + axial_force * motions[:, 0]
    forces = throw.stiffness @ combined - load
    return Reactions(
        EndReaction(forces[0:3].copy(), forces[3:6].copy()),
        EndReaction(forces[6:9].copy(), forces[9:12].copy()),
    )


def free_motions(ends: Array, support: str) -> NDArray[np.int64]:
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
        out, since a rigid motion of the throw keeps it in place; a class that mirrors the ends has
        columns that move both apart instead, which lengthen or twist the throw and stay.
    """
    both = np.abs(ends).reshape(2, 6, -1)
    held = both[:, HELD[support]].any(axis=(0, 1))
    rigid = (both[0, [UZ, RZ]] > both[1, [UZ, RZ]]).any(axis=0)
    return np.flatnonzero(~held & ~rigid)


def end_motions(throw: Superelement, support: Support, pin_loads: Array | None = None) -> Array:
    """Motions of a throw's end sections under unit loads.

    Parameters
    ----------
    throw : Superelement
    support : "pinned", "guided" or Neighbors
    pin_loads : (12, m) array, optional
        End loads that loads on the pins are equivalent to; by default those of the six unit loads on
        each pin.

    Returns
    -------
    (12, 2 + m) array
        Under a unit axial force, a unit torque, and the pin loads. The right end is free to move along
        the shaft, so these load cases carry any other.

    Raises
    ------
    InputError
        If the support is none of these.
    """
    if pin_loads is None:
        pin_loads = np.hstack(list(throw.pin_loads))
    if isinstance(support, Neighbors):
        return _between_neighbors(throw.stiffness, pin_loads, support)
    if not isinstance(support, str) or support not in HELD:
        raise InputError(
            f'support: given {support!r}; allowed are "pinned", "guided" or '
            "Neighbors(left_deg, right_deg), because the compliance depends on it severalfold."
        )
    loads = np.column_stack([STRETCH, TWIST, pin_loads])
    free = free_motions(np.eye(12), support)
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(throw.stiffness[np.ix_(free, free)], loads[free])
    return motions


def _between_neighbors(stiffness: Array, pin_loads: Array, support: Neighbors) -> Array:
    """The middle throw's motions in a chain long enough that its compliances no longer change."""
    reach, before = 4, np.full(2, np.inf)
    while True:
        motions = _chain_motions(stiffness, pin_loads, support, reach)
        answers = motions[[6 + UZ, 6 + RZ], [0, 1]]
        if np.all(np.abs(answers - before) <= 1e-10 * answers) or 2 * reach > LONGEST_CHAIN:
            return motions
        before, reach = answers, 2 * reach


def _chain_motions(throw: Array, pin_loads: Array, support: Neighbors, reach: int) -> Array:
    """Motions of the middle throw, its left end fixed axially and against rotation.

    Axial force and torque through the throws are known: those of the load case, and under a pin force
    none, since each throw's left end takes its own torque and axial push (otherwise they would add up
    along the chain). So only the tilts couple the throws, and solving for these alone stays accurate
    however long the chain.
    """
    tilts, through = [RX, RY, 6 + RX, 6 + RY], [6 + UZ, 6 + RZ]
    tilt_part, coupling, through_part = (
        throw[np.ix_(rows, columns)]
        for rows, columns in ((tilts, tilts), (tilts, through), (through, through))
    )
    forces = np.hstack([np.eye(2), pin_loads[through]])
    carried = np.linalg.solve(through_part, coupling.T).T
    condensed = tilt_part - carried @ coupling.T
    tilting = np.hstack([np.zeros((4, 2)), pin_loads[tilts]]) - carried @ forces
    places = np.arange(-reach, reach + 1)
    steps = np.where(places < 0, support.left_deg, support.right_deg)
    stiffness = np.zeros((2 * (len(places) + 1),) * 2)
    loads = np.zeros((len(stiffness), tilting.shape[1]))
    for place, angle in enumerate(np.deg2rad(steps * places)):
        turn = np.kron(np.eye(2), section_rotation(float(angle))[:2, :2])
        part = slice(2 * place, 2 * place + 4)
        stiffness[part, part] += turn @ condensed @ turn.T
        loads[part] += turn @ tilting
    motions = np.zeros((12, tilting.shape[1]))
    motions[tilts] = np.linalg.solve(stiffness, loads)[2 * reach : 2 * reach + 4]
    motions[through] = np.linalg.solve(through_part, forces - coupling.T @ motions[tilts])
    return motions
