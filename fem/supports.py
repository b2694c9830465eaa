"""What a throw does under each named support: compliances, influence coefficient, reactions."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fem.superelement import RX, RY, RZ, UX, UY, UZ, Superelement, section_rotation
from geometry.errors import InputError

Array = NDArray[np.float64]
RADIAL = np.array([0.0, -1.0, 0.0])
LONGEST_CHAIN = 64


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
            if not isinstance(value, int | float) or not math.isfinite(value):
                raise InputError(
                    f"Neighbors.{name}: given {value!r}; allowed is a finite angle in degrees."
                )


Support = Literal["pinned", "guided"] | Neighbors


@dataclass(frozen=True)
class EndReaction:
    """Force [N] and moment [N m] on one end section, each (3,), in the throw frame."""

    force: Array
    moment: Array


@dataclass(frozen=True)
class Reactions:
    """What supports (and under `Neighbors` the adjoining throws) exert on a throw's end sections."""

    left: EndReaction
    right: EndReaction


@dataclass(frozen=True)
class SupportedThrow:
    """Answers of a throw under one support.

    Attributes
    ----------
    axial : float
        e_n [m/N].
    torsional : float
        [rad/(N m)]
    stretch_per_force : (3,) array
        Lengthening of the axially free throw per unit pin force along x, y, z [m/N]; under
        `Neighbors` all throws carry that force, each in its own frame.
    """

    axial: float
    torsional: float
    stretch_per_force: Array

    @property
    def influence(self) -> float:
        """Influence coefficient c: lengthening per unit radial force Z towards the shaft [m/N]."""
        return float(self.stretch_per_force @ RADIAL)


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
    motions = _motions(throw, support)
    stretch = motions[6 + UZ] - motions[UZ]
    twist = motions[6 + RZ] - motions[RZ]
    return SupportedThrow(float(stretch[0]), float(twist[1]), stretch[2:])


def reactions(throw: Superelement, support: Support, pin_force: Array) -> Reactions:
    """End forces on a throw whose pin is loaded and whose length is kept.

    Parameters
    ----------
    throw : Superelement
    support : "pinned", "guided" or Neighbors
        The left end takes the torque. Under `Neighbors` every throw carries the same pin force in its
        own frame, its left end takes its torque and axial push, and a force along the whole chain
        keeps the length of the middle throw.
    pin_force : (3,) array
        Force on the pin in the throw frame [N], spread uniformly over its surface.

    Returns
    -------
    Reactions
    """
    motions = _motions(throw, support)
    stretch = motions[6 + UZ] - motions[UZ]
    axial_force = -(stretch[2:] @ pin_force) / stretch[0]
    combined = motions[:, 2:] @ pin_force + axial_force * motions[:, 0]
    forces = throw.stiffness @ combined - throw.pin_load @ pin_force
    return Reactions(
        EndReaction(forces[0:3].copy(), forces[3:6].copy()),
        EndReaction(forces[6:9].copy(), forces[9:12].copy()),
    )


def _motions(throw: Superelement, support: Support) -> Array:
    """End motions (12, 5) under unit axial force, unit torque, and unit pin forces along x, y, z.

    A motion along the shaft is left free at the right end, so these load cases carry any other.
    """
    if isinstance(support, Neighbors):
        return _between_neighbors(throw, support)
    if support == "pinned":
        blocked = [UX, UY, UZ, RZ, 6 + UX, 6 + UY]
    elif support == "guided":
        blocked = [UX, UY, UZ, RX, RY, RZ, 6 + UX, 6 + UY, 6 + RX, 6 + RY]
    else:
        raise InputError(
            f'support: given {support!r}; allowed are "pinned", "guided" or '
            "Neighbors(left_deg, right_deg), because the compliance depends on it severalfold."
        )
    free = np.setdiff1d(np.arange(12), blocked)
    loads = np.zeros((12, 5))
    loads[6 + UZ, 0] = 1.0
    loads[6 + RZ, 1] = 1.0
    loads[:, 2:] = throw.pin_load
    motions = np.zeros((12, 5))
    motions[free] = np.linalg.solve(throw.stiffness[np.ix_(free, free)], loads[free])
    return motions


def _between_neighbors(throw: Superelement, support: Neighbors) -> Array:
    """The middle throw's motions in a chain long enough that its compliances no longer change."""
    reach, before = 4, np.full(2, np.inf)
    while True:
        motions = _chain_motions(throw, support, reach)
        answers = motions[[6 + UZ, 6 + RZ], [0, 1]]
        if np.all(np.abs(answers - before) <= 1e-10 * answers) or 2 * reach > LONGEST_CHAIN:
            return motions
        before, reach = answers, 2 * reach


def _chain_motions(throw: Superelement, support: Neighbors, reach: int) -> Array:
    """Motions of the middle throw, its left end fixed axially and against rotation.

    Axial force and torque through the throws are known: those of the load case, and under a pin force
    none, since each throw's left end takes its own torque and axial push (otherwise they would add up
    along the chain). So only the tilts couple the throws, and solving for these alone stays accurate
    however long the chain.
    """
    tilts, through = [RX, RY, 6 + RX, 6 + RY], [6 + UZ, 6 + RZ]
    tilt_part, coupling, through_part = (
        throw.stiffness[np.ix_(rows, columns)]
        for rows, columns in ((tilts, tilts), (tilts, through), (through, through))
    )
    forces = np.column_stack([np.eye(2), throw.pin_load[through]])
    carried = np.linalg.solve(through_part, coupling.T).T
    condensed = tilt_part - carried @ coupling.T
    tilting = np.column_stack([np.zeros((4, 2)), throw.pin_load[tilts]]) - carried @ forces
    places = np.arange(-reach, reach + 1)
    steps = np.where(places < 0, support.left_deg, support.right_deg)
    stiffness = np.zeros((2 * (len(places) + 1),) * 2)
    loads = np.zeros((len(stiffness), 5))
    for place, angle in enumerate(np.deg2rad(steps * places)):
        turn = np.kron(np.eye(2), section_rotation(float(angle))[:2, :2])
        part = slice(2 * place, 2 * place + 4)
        stiffness[part, part] += turn @ condensed @ turn.T
        loads[part] += turn @ tilting
    motions = np.zeros((12, 5))
    motions[tilts] = np.linalg.solve(stiffness, loads)[2 * reach : 2 * reach + 4]
    motions[through] = np.linalg.solve(through_part, forces - coupling.T @ motions[tilts])
    return motions
