"""Stiffness, mass and damping of a whole crankshaft, and its rigid motions.

The frame rotates with the shaft and its bearings are alike in all directions, so the matrices are
constant. Coriolis and centrifugal forces of vibration in this frame are neglected: see
`rotation_ratio`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray, one_for_each
from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.crankshaft.joined_lines import JoinedLine, join_lines
from dynamics.crankshaft.shaft_throw import RX, RY, RZ, UX, UY, UZ, ShaftThrow
from dynamics.crankshaft.stations import Stations, on_axis, shaft_stations
from dynamics.crankshaft.surroundings import ShaftSurroundings

MOST_THROWS = 100
PIN_MOTIONS = ("tangential", "radial", "axial")
SECTION_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
ROTATION, TRANSLATION = "rotation about the shaft axis", "axial translation"


@summarized("section_count", "mass", "rigid", "positions [m]")
@dataclass(frozen=True, eq=False)
class AssembledShaft:
    """A crankshaft by its matrices.

    The u unknowns are the motions of the n + 1 sections in the shaft's frame, six each, the amplitudes
    of the sections' bending, those of the throws' shapes, the rotations of damper ring and driven
    machine, and the motions of shaft lines; those held by supports are left out.

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
        Mean motion of each pin along the tangential force, along the radial force and along the shaft.
    stations : Stations
        Slices of the shaft for the classification of its energy of motion.
    added : (a, u) array
        Rotation of damper ring and driven machine, and motion of the nodes of shaft lines, if present.
    added_mass : (2, u, u) array
        Mass matrices of these, along the shaft and about it.
    added_springs : (b, u) array
        Rows whose squares are twice the strain energy of damper spring, coupling, and springs of lines.
    spring_kinds : (b,) array of int
        0 for those along the shaft, 1 for those about it.
    damped_springs : (b,) array of bool
        Which of these have damping of their own.
    dashpots : (d, u) array
        Directions in which dashpots act.
    positions : (n + 1,) array
        Positions of the sections along the shaft, from main bearing 1 [m].
    pin_throws : (p,) array of int
        Throw of each pin.
    names : tuple of str
        Of `sections`, `pins` and `added`, row by row.
    momenta : (n + 1, u) array
        Angular momentum about the shaft axis of all that lies between the free end and each section, per
        velocity of the unknowns.
    moments : (n + 1, 3 p) array
        Moment about the shaft axis of unit forces along the motions of `pins` that lie there [m].
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
    added_mass: FloatArray = field(repr=False)
    added_springs: FloatArray = field(repr=False)
    spring_kinds: NDArray[np.int64]
    damped_springs: NDArray[np.bool_]
    dashpots: FloatArray = field(repr=False)
    positions: FloatArray
    pin_throws: tuple[int, ...]
    names: tuple[str, ...]
    momenta: FloatArray = field(repr=False)
    moments: FloatArray = field(repr=False)

    @property
    def expand(self) -> FloatArray:
        """Motions of sections, pins and added bodies per unknown, (points, u)."""
        return np.vstack((self.sections, self.pins, self.added))

    @property
    def section_count(self) -> int:
        """Number of sections, n + 1."""
        return len(self.sections) // 6


def assemble_crankshaft(
    throws: Sequence[ShaftThrow], around: ShaftSurroundings | None = None, *, turning_sense: int = 1
) -> AssembledShaft:
    """Assemble throws, bearings, end bodies and dampers.

    Parameters
    ----------
    throws : sequence of n ShaftThrow
        From the free end to the flywheel.
    around : ShaftSurroundings, optional
        By default none: the shaft is free in space.
    turning_sense : {1, -1}
        1 if the shaft turns about +z, else -1: tangential forces act in the sense of rotation.

    Returns
    -------
    AssembledShaft

    Raises
    ------
    InputError
        If there is no throw, their sections move differently, or a support or a pin's mass has no position.
    """
    if not throws or not all(isinstance(throw, ShaftThrow) for throw in throws):
        raise InputError(
            "throws: given none, or what is no ShaftThrow; allowed is one of these or more, because a "
            "crankshaft has throws."
        )
    if len(throws) > MOST_THROWS:
        raise InputError(
            f"throws: given {len(throws)}; allowed are at most {MOST_THROWS}, because no crankshaft has more."
        )
    if turning_sense not in (1, -1):
        raise InputError(
            f"turning_sense: given {turning_sense!r}; allowed are 1 and -1, because the shaft turns about "
            "+z or against it."
        )
    around = ShaftSurroundings() if around is None else around
    count = len(throws) + 1
    rings = around.rings(count)
    bending = throws[0].bending
    if any(throw.bending != bending for throw in throws):
        raise InputError(
            f"throws: given bending {sorted({throw.bending for throw in throws})}; allowed is one number, "
            "because throws side by side share the motions of a section."
        )
    first_shape = (6 + bending) * count
    first_ring = first_shape + sum(throw.shapes for throw in throws)
    given, first_line = around.lines(count), first_ring + len(rings)
    size = first_line + sum(chain.expansion().shape[1] - 1 for _, chain, _ in given)
    lines = join_lines(given, first_line, size)
    mass, stiffness, damping, loss = np.zeros((4, size, size))
    pin_rows, pin_slices, pin_frames = [], [], []
    # Each throw turned by itself about the shaft axis, and what that moves.
    about, momenta = np.zeros((2, len(throws), size))
    place = first_shape
    for number, throw in enumerate(throws):
        beyond = 6 * count + bending * number
        own = np.r_[
            6 * number : 6 * number + 12,
            beyond : beyond + 2 * bending,
            place : place + throw.shapes,
        ]
        place += throw.shapes
        turn = throw.turn
        mass[np.ix_(own, own)] += turn @ throw.mass @ turn.T
        about[number, [6 * number + RZ, 6 * number + 6 + RZ]] = 1.0
        momenta[number, own] = turn @ throw.mass @ turn.T @ about[number, own]
        stiffness[np.ix_(own, own)] += turn @ throw.stiffness @ turn.T
        for pin, center in zip(throw.pin_loads, throw.pins, strict=True):
            motion = np.zeros((6, size))
            motion[:, own] = (turn @ pin).T
            pin_rows.append(_pin_directions(center, turning_sense) @ motion[:3])
            pin_slices.append(turn[:6, :6] @ on_axis(center) @ motion)
            pin_frames.append(motion[:2])
    loss += around.loss_factor * stiffness
    pin_masses = around.pin_masses if len(around.pin_masses) else 0.0
    masses = one_for_each(
        "pin_masses", pin_masses, len(pin_rows), "pins", "kg", "rods add to the shaft's inertia"
    )
    pin_throws = [number for number, throw in enumerate(throws) for _ in throw.pins]
    for value, rows, number in zip(masses.tolist(), pin_frames, pin_throws, strict=True):
        mass += value * rows.T @ rows
        momenta[number] += value * rows.T @ (rows @ about[number])
    beyond_first = np.zeros(size)
    for body, section, outward in around.bodies(count):
        own = np.r_[6 * section : 6 * section + 6]
        mass[np.ix_(own, own)] += body.mass_matrix(outward)
        if outward < 0.0:
            beyond_first[own] += body.mass_matrix(outward)[RZ]

    unit = np.eye(size)
    held, dashpots = [], []

    def join(row: FloatArray, spring: float, dashpot: float, loss_factor: float = 0.0) -> None:
        both = np.outer(row, row)
        stiffness[:] += spring * both
        damping[:] += dashpot * both
        loss[:] += loss_factor * spring * both
        if dashpot or loss_factor:
            dashpots.append(row)

    for place, spring, dashpot in _supports(around, count):
        if np.isinf(spring):
            held.append(place)
        else:
            join(unit[place], spring, dashpot)
    added_mass = np.zeros((2, size, size))
    added_springs = [np.zeros((0, size))]
    spring_kinds, damped_springs = [1] * len(rings), []
    for row, (_, ring, section) in enumerate(rings, start=first_ring):
        added_mass[1, row, row] += ring.inertia
        beyond_first[row] += ring.inertia if section == 0 else 0.0
        twist = unit[row] - unit[6 * section + RZ]
        join(twist, ring.stiffness, ring.damping, ring.loss_factor)
        added_springs.append(math.sqrt(ring.stiffness) * twist[np.newaxis])
        damped_springs.append(ring.damping > 0.0 or ring.loss_factor > 0.0)
    for line in lines:
        chain, moved = line.chain, line.motions
        added_mass[int(line.kind == "torsional")] += moved.T @ chain.mass_matrix() @ moved
        stiffness += moved.T @ chain.stiffness_matrix() @ moved
        damping += moved.T @ chain.damping_matrix() @ moved
        loss += moved.T @ chain.loss_matrix() @ moved
        added_springs.append(chain.spring_rows() @ moved)
        damped_springs += chain.damped_springs.tolist()
        spring_kinds += [int(line.kind == "torsional")] * len(added_springs[-1])
    mass += added_mass.sum(axis=0)
    added = np.vstack((unit[first_ring:first_line], *(line.motions[1:] for line in lines)))

    kept = np.setdiff1d(np.arange(size), held)
    free = np.ix_(kept, kept)
    starts = np.concatenate(([0.0], np.cumsum([throw.length for throw in throws])))
    stations = shaft_stations(throws, around, masses, starts, unit[: 6 * count], pin_slices)
    section_names = [
        f"main bearing {number} {way}" for number in range(1, count + 1) for way in SECTION_MOTIONS
    ]
    pin_names = [
        f"pin {number} {way}" for number in range(1, masses.size + 1) for way in PIN_MOTIONS
    ]
    rigid, rigid_names = _rigid_motions(around, starts, first_ring, lines, size)
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
        added=added[:, kept],
        added_mass=added_mass[:, kept][:, :, kept],
        added_springs=np.vstack(added_springs)[:, kept],
        spring_kinds=np.array(spring_kinds, dtype=np.int64),
        damped_springs=np.array(damped_springs, dtype=bool),
        dashpots=np.array(dashpots).reshape(-1, size)[:, kept],
        positions=starts,
        pin_throws=tuple(pin_throws),
        names=(
            *section_names,
            *pin_names,
            *(name for name, _, _ in rings),
            *(name for line in lines for name in line.names),
        ),
        momenta=np.cumsum(np.vstack((beyond_first, momenta)), axis=0)[:, kept],
        moments=_pin_moments(np.vstack(pin_rows), about[pin_throws], pin_throws, count),
    )


def _pin_moments(
    pins: FloatArray, about: FloatArray, throws: Sequence[int], count: int
) -> FloatArray:
    """Return the moments about the shaft axis of unit forces on pins before each section, (n + 1, 3 p)."""
    levers = np.einsum("pku,pu->pk", pins.reshape(len(throws), 3, -1), about)
    before = np.arange(count)[:, np.newaxis] > np.array(throws)
    return np.asarray((before[:, :, np.newaxis] * levers).reshape(count, -1))


def _supports(around: ShaftSurroundings, count: int) -> list[tuple[int, float, float]]:
    """Return the unknowns that bearings and axial supports act on, their stiffness and damping."""
    found = []
    if around.bearings is not None:
        each = zip(*(values.tolist() for values in around.bearings.at(count)), strict=True)
        for section, (stiffness, damping) in enumerate(each):
            found += [(6 * section + motion, stiffness, damping) for motion in (UX, UY)]
    for support in around.axial_supports:
        section = whole_within(
            "axial support section",
            support.section,
            0,
            count - 1,
            f"the shaft has {count} sections",
        )
        found.append((6 * section + UZ, support.stiffness, support.damping))
    return found


def _rigid_motions(
    around: ShaftSurroundings,
    places: FloatArray,
    first_ring: int,
    lines: Sequence[JoinedLine],
    size: int,
) -> tuple[FloatArray, tuple[str, ...]]:
    """Find the motions that no stiffness resists.

    Parameters
    ----------
    around : ShaftSurroundings
    places : ndarray of shape (n + 1,)
        Of the sections along the shaft [m].
    first_ring, size : int
        Unknown of the first ring, and the number of all.
    lines : sequence of JoinedLine

    Returns
    -------
    motions : ndarray of shape (size, r)
        As columns; those of unit rotation or translation, exact.
    names : tuple of r str
    """
    unit, count = np.eye(size), len(places)

    def motion(values: dict[int, FloatArray | float]) -> FloatArray:
        column = np.zeros(size)
        for component, value in values.items():
            column[component : 6 * count : 6] = value
        return column

    found = {ROTATION: motion({RZ: 1.0})}
    for row, (name, ring, _) in enumerate(around.rings(count), start=first_ring):
        if ring.stiffness > 0.0:
            found[ROTATION][row] = 1.0
        else:
            found[f"rotation of the {name.removeprefix('damper ')} alone"] = unit[row]
    if not any(support.stiffness > 0.0 for support in around.axial_supports):
        found[TRANSLATION] = motion({UZ: 1.0})
    for line in lines:
        with_section, alone = line.rigid_motions()
        together = ROTATION if line.kind == "torsional" else TRANSLATION
        if with_section is None:
            found.pop(together, None)
        elif together in found:
            found[together] += with_section
        found |= {f"{together.partition(' ')[0]} of {names} alone": own for own, names in alone}
    bearings = np.array([])
    if around.bearings is not None:
        bearings = places[around.bearings.at(count)[0] > 0.0]
    if bearings.size == 0:
        found["translation along x"] = motion({UX: 1.0})
        found["translation along y"] = motion({UY: 1.0})
    if bearings.size <= 1:
        arms = places - (bearings[0] if bearings.size else places.mean())
        found["tilt about x"] = motion({RX: 1.0, UY: -arms})
        found["tilt about y"] = motion({RY: 1.0, UX: arms})
    return np.column_stack([np.zeros((size, 0)), *found.values()]), tuple(found)


def _pin_directions(center: FloatArray, sense: int) -> FloatArray:
    """Rows (3, 3) of the throw frame: sense of rotation, towards the axis, along the shaft."""
    x, y = center[:2] / np.hypot(*center[:2])
    return np.array([[-sense * y, sense * x, 0.0], [-x, -y, 0.0], [0.0, 0.0, 1.0]])
