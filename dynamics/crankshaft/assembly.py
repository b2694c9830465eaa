"""Stiffness, mass and damping of a whole crankshaft, and the motions that nothing resists.

The frame turns with the shaft and its bearings are alike in all directions, so that the matrices are
constant. Coriolis' and the centrifugal forces of vibration in this frame are left out: see
`rotation_ratio`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from crankbase.checks.arrays import FloatArray, nonnegative_vector
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.crankshaft.rigid_motions import rigid_motions, rings_of
from dynamics.crankshaft.shaft_throw import RZ, UX, UY, UZ, ShaftThrow
from dynamics.crankshaft.stations import Stations, on_axis, shaft_stations
from dynamics.crankshaft.surroundings import AxialSupport, ShaftSurroundings

PIN_MOTIONS = ("tangential", "radial", "axial")
SECTION_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")


@summarized("section_count", "mass", "rigid", "positions [m]")
@dataclass(frozen=True, eq=False)
class AssembledShaft:
    """A crankshaft by its matrices.

    The u unknowns are the motions of the n + 1 sections in the shaft's frame, six each, the amplitudes
    of the throws' shapes, and the rotations of damper ring and driven machine; those that supports hold
    are left out.

    Attributes
    ----------
    mass, stiffness, damping, loss : (u, u) array
        `loss` is the imaginary part of the stiffness.
    rigid : (u, r) array
        Motions that no stiffness resists, as columns.
    rigid_names : tuple of r str
    sections : (6 (n + 1), u) array
        Motions of the sections per unknown, zero where they are held.
    pins : (3 p, u) array
        Mean motion of each pin along the force that turns the shaft, towards the shaft axis and along
        it.
    stations : Stations
        Slices of the shaft by which the energy of its motion is told apart.
    added : (a, u) array
        Rotation of damper ring and driven machine, as far as they are there.
    added_inertia : (a,) array
        [kg m^2]
    added_springs : (a, u) array
        Rows whose squares are twice the strain energy of damper spring and coupling.
    dashpots : (d, u) array
        Directions in which dashpots act.
    positions : (n + 1,) array
        Places of the sections along the shaft, from section 0 [m].
    pin_throws : (p,) array of int
        Throw of each pin.
    names : tuple of str
        Of `sections`, `pins` and `added`, row by row.
    """

    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    loss: FloatArray
    rigid: FloatArray
    rigid_names: tuple[str, ...]
    sections: FloatArray = field(repr=False)
    pins: FloatArray = field(repr=False)
    stations: Stations = field(repr=False)
    added: FloatArray = field(repr=False)
    added_inertia: FloatArray
    added_springs: FloatArray = field(repr=False)
    dashpots: FloatArray = field(repr=False)
    positions: FloatArray
    pin_throws: tuple[int, ...]
    names: tuple[str, ...]

    @property
    def expand(self) -> FloatArray:
        """Motions of sections, pins and added bodies per unknown, (points, u)."""
        return np.vstack((self.sections, self.pins, self.added))

    @property
    def section_count(self) -> int:
        """Number of sections, n + 1."""
        return len(self.sections) // 6


def assemble_crankshaft(
    throws: Sequence[ShaftThrow],
    around: ShaftSurroundings | None = None,
    *,
    turning_sense: int = 1,
) -> AssembledShaft:
    """Put throws, bearings, end bodies and dampers together.

    Parameters
    ----------
    throws : sequence of n ShaftThrow
        From the free end to the flywheel.
    around : ShaftSurroundings, optional
        By default nothing: the shaft is free in space.
    turning_sense : {1, -1}
        1 if the shaft turns about +z, else -1: tangential forces act in the sense of rotation.

    Returns
    -------
    AssembledShaft

    Raises
    ------
    InputError
        If there is no throw, or a support or a pin's mass has no place.
    """
    if not throws or not all(isinstance(throw, ShaftThrow) for throw in throws):
        raise InputError(
            "throws: given none, or what is no ShaftThrow; allowed is one of these or more, because a "
            "crankshaft has throws."
        )
    if turning_sense not in (1, -1):
        raise InputError(
            f"turning_sense: given {turning_sense!r}; allowed are 1 and -1, because the shaft turns about "
            "+z or against it."
        )
    around = ShaftSurroundings() if around is None else around
    count = len(throws) + 1
    rings = [each for each in (around.ring, around.machine) if each is not None]
    first_shape = 6 * count
    size = first_shape + sum(throw.shapes for throw in throws) + len(rings)
    mass, stiffness, damping, loss = np.zeros((4, size, size))
    pin_rows, pin_slices, pin_frames = [], [], []
    place = first_shape
    for number, throw in enumerate(throws):
        own = np.r_[6 * number : 6 * number + 12, place : place + throw.shapes]
        place += throw.shapes
        turn = throw.turn
        mass[np.ix_(own, own)] += turn @ throw.mass @ turn.T
        stiffness[np.ix_(own, own)] += turn @ throw.stiffness @ turn.T
        for pin, center in zip(throw.pin_loads, throw.pins, strict=True):
            motion = np.zeros((6, size))
            motion[:, own] = (turn @ pin).T
            pin_rows.append(_pin_directions(center, turning_sense) @ motion[:3])
            pin_slices.append(turn[:6, :6] @ on_axis(center) @ motion)
            pin_frames.append(motion[:2])
    loss += around.loss_factor * stiffness
    masses = _pin_masses(around.pin_masses, len(pin_rows))
    for value, rows in zip(masses.tolist(), pin_frames, strict=True):
        mass += value * rows.T @ rows
    last = 6 * (count - 1)
    for body, start, outward in ((around.free_end, 0, -1.0), (around.flywheel, last, 1.0)):
        if body is not None:
            mass[start : start + 6, start : start + 6] += body.mass_matrix(outward)

    unit = np.eye(size)
    springs = _Springs(stiffness, damping, loss)
    held = [
        *_hold_laterally(springs, around, count, unit),
        *_hold_axially(springs, around.axial_supports, count, unit),
    ]
    added_springs = np.zeros((len(rings), size))
    for number, (ring, section) in enumerate(rings_of(around, count)):
        row = size - len(rings) + number
        mass[row, row] += ring.inertia
        twist = unit[row] - unit[6 * section + RZ]
        springs.add(twist, ring.stiffness, ring.damping, ring.loss_factor)
        added_springs[number] = math.sqrt(ring.stiffness) * twist

    kept = np.setdiff1d(np.arange(size), held)
    free = np.ix_(kept, kept)
    starts = np.concatenate(([0.0], np.cumsum([throw.length for throw in throws])))
    stations = shaft_stations(throws, around, masses, starts, unit[: 6 * count], pin_slices)
    rigid, rigid_names = rigid_motions(around, starts, size)
    return AssembledShaft(
        mass=mass[free],
        stiffness=stiffness[free],
        damping=damping[free],
        loss=loss[free],
        rigid=rigid[kept],
        rigid_names=rigid_names,
        sections=unit[: 6 * count, kept],
        pins=np.vstack(pin_rows)[:, kept],
        stations=stations.of(kept),
        added=unit[size - len(rings) :, kept],
        added_inertia=np.array([ring.inertia for ring in rings]),
        added_springs=added_springs[:, kept],
        dashpots=np.array(springs.dashpots).reshape(-1, size)[:, kept],
        positions=starts,
        pin_throws=tuple(
            number for number, throw in enumerate(throws) for _ in range(len(throw.pins))
        ),
        names=_names(count, len(pin_rows), around),
    )


@dataclass(frozen=True, eq=False)
class _Springs:
    """Matrices to which springs and dashpots are added."""

    stiffness: FloatArray
    damping: FloatArray
    loss: FloatArray
    dashpots: list[FloatArray] = field(default_factory=list)

    def add(self, row: FloatArray, stiffness: float, damping: float, loss: float = 0.0) -> None:
        both = np.outer(row, row)
        self.stiffness[:] += stiffness * both
        self.damping[:] += damping * both
        self.loss[:] += loss * stiffness * both
        if damping or loss:
            self.dashpots.append(row)


def _hold_laterally(
    springs: _Springs, around: ShaftSurroundings, count: int, unit: FloatArray
) -> list[int]:
    if around.bearings is None:
        return []
    held = []
    for section, (stiffness, damping) in enumerate(
        zip(*(values.tolist() for values in around.bearings.at(count)), strict=True)
    ):
        for place in (6 * section + UX, 6 * section + UY):
            if np.isinf(stiffness):
                held.append(place)
            else:
                springs.add(unit[place], stiffness, damping)
    return held


def _hold_axially(
    springs: _Springs, supports: Sequence[AxialSupport], count: int, unit: FloatArray
) -> list[int]:
    held = []
    for support in supports:
        if support.section >= count:
            raise InputError(
                f"axial support section: given {support.section}; allowed is 0 to {count - 1}, because "
                f"the shaft has {count} sections."
            )
        place = 6 * support.section + UZ
        if np.isinf(support.stiffness):
            held.append(place)
        else:
            springs.add(unit[place], support.stiffness, support.damping)
    return held


def _pin_masses(given: Sequence[float], pins: int) -> FloatArray:
    if len(given) == 0:
        return np.zeros(pins)
    values = nonnegative_vector("pin_masses", given, "kg", "rods add to the shaft's inertia")
    if values.size != pins:
        raise InputError(
            f"pin_masses: given {values.size} values; allowed is one for each of the {pins} pins, because "
            "they are counted along the shaft."
        )
    return values


def _pin_directions(center: FloatArray, sense: int) -> FloatArray:
    """Rows (3, 3) of the throw frame: sense of rotation, towards the axis, along the shaft."""
    x, y = center[:2] / np.hypot(*center[:2])
    return np.array([[-sense * y, sense * x, 0.0], [-x, -y, 0.0], [0.0, 0.0, 1.0]])


def _names(count: int, pins: int, around: ShaftSurroundings) -> tuple[str, ...]:
    names = [f"section {number} {motion}" for number in range(count) for motion in SECTION_MOTIONS]
    names += [f"pin {number + 1} {motion}" for number in range(pins) for motion in PIN_MOTIONS]
    names += ["damper ring"] if around.ring is not None else []
    names += ["driven machine"] if around.machine is not None else []
    return tuple(names)
