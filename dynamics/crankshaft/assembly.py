"""Stiffness, mass and damping of a whole crankshaft, and its rigid motions.

The frame rotates with the shaft and its bearings are alike in all directions, so the matrices are
constant. Coriolis and centrifugal forces of vibration in this frame are neglected: see
`rotation_ratio`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from crankbase.array_checks import Array, Flags, Integers, one_for_each
from crankbase.choices import whole_within
from crankbase.errors import InputError
from crankbase.results import result
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import Kind
from dynamics.chains.varying import Variation, VaryingSpring, varied
from dynamics.crankshaft.line_beam import PlaneBending
from dynamics.crankshaft.surroundings import RX, RY, RZ, UX, UY, UZ, ShaftSurroundings, ShaftThrow

# Of a node's motion about or along the shaft, behind its name, as those of the sections.
MOTION_OF = {"torsional": "rz", "axial": "uz"}


@dataclass(frozen=True, eq=False)
class JoinedLine:
    """A chain behind the crankshaft, in the unknowns of the whole shaft.

    Attributes
    ----------
    kind : {"torsional", "axial"}
    chain : Chain
        Its first node turns, or moves along the shaft, with the section.
    motions : (n, u) array
        Motions of its nodes per unknown, gears included.
    unknowns : (q - 1,) array of int
        Its own unknowns: of each group of nodes that gears couple, except that of the section, the
        motion of the first node.
    """

    kind: Kind
    chain: Chain
    motions: Array
    unknowns: Integers

    @property
    def names(self) -> tuple[str, ...]:
        """Of its nodes behind the section, such as "propeller rz"."""
        return tuple(f"{name} {MOTION_OF[self.kind]}" for name in self.chain.names[1:])

    def rigid_motions(self) -> tuple[Array | None, list[tuple[Array, str]]]:
        """Return the motions that no spring of the line resists.

        Returns
        -------
        with_section : (u,) array or None
            Of its own unknowns where the section moves by one; None where springs to ground hold it.
        alone : list of pairs of (u,) array and str
            Of parts that only dashpots join, with the names of their nodes.
        """
        leading = self.chain.leading_nodes[1:]
        with_section, alone = None, []
        for motion in self.chain.rigid_motions()[0].T:
            column = np.zeros(self.motions.shape[1])
            column[self.unknowns] = motion[leading]
            if motion[0]:
                with_section = column / motion[0]
            else:
                nodes = np.flatnonzero(motion).tolist()
                alone.append((column, ", ".join(self.chain.names[node] for node in nodes)))
        return with_section, alone


def join_lines(
    lines: Sequence[tuple[Kind, Chain, int]], first: int, size: int
) -> tuple[JoinedLine, ...]:
    """Give the nodes of lines their motions in the unknowns of a whole shaft.

    Parameters
    ----------
    lines : sequence of kind, Chain and int
        With the unknown of the section that the first node moves with.
    first, size : int
        First of the unknowns left for lines, and the number of all.
    """
    joined = []
    for kind, chain, section in lines:
        expand = chain.expansion()
        unknowns = np.arange(first, first + expand.shape[1] - 1)
        first += unknowns.size
        motions = np.zeros((len(expand), size))
        # Gears' groups are counted by their first nodes: the first one is the section's.
        motions[:, [section, *unknowns]] = expand
        joined.append(JoinedLine(kind, chain, motions, unknowns))
    return tuple(joined)


@dataclass(frozen=True, eq=False)
class JoinedBeam:
    """A line that bends, in the unknowns of the whole shaft.

    Attributes
    ----------
    bending : PlaneBending
    motions : (2, 2 n, u) array
        Its motions in the planes of x and of y per unknown; of its own ones each node behind the first
        has deflection and slope along x, then along y.
    places : (n,) array
        Of its nodes, from main bearing 1 [m].
    bearings : (b,) array
        Places of its bearings [m].
    """

    bending: PlaneBending
    motions: Array
    places: Array
    bearings: Array

    def rigid(self, across: float, tilt: float, pivot: float) -> Array:
        """Deflections and slopes (2 n,) of a rigid motion in a plane, which leaves the pivot [m] in place."""
        return np.column_stack(
            (across + tilt * (self.places - pivot), np.full(self.places.size, tilt))
        ).ravel()


def join_beam(
    around: ShaftSurroundings, starts: Array, first: int, size: int
) -> tuple[JoinedBeam, ...]:
    """Give a line that bends, if there is one, its motions: the only one, or none.

    Parameters
    ----------
    starts : ndarray of shape (n + 1,)
        Places of the sections [m].
    first, size : int
        First of the unknowns left for it, and the number of all.
    """
    if around.line_beam is None:
        return ()
    bending, last = around.line_beam.bending, 6 * (len(starts) - 1)
    arm = 0.0 if around.flywheel is None else around.flywheel.overhang
    moved = np.zeros((2, 2 * len(bending.places), size))
    inner = np.arange(2, 2 * len(bending.places))
    for plane, (across, tilt, sign) in enumerate(((UX, RY, 1.0), (UY, RX, -1.0))):
        moved[plane, 0, [last + across, last + tilt]] = 1.0, sign * arm
        moved[plane, 1, last + tilt] = sign
        moved[plane, inner, first + 2 * (inner - 2 - inner % 2) + 2 * plane + inner % 2] = 1.0
    held = [place for place, stiffness in around.line_beam.bearings if stiffness > 0.0]
    start = starts[-1] + arm
    return (JoinedBeam(bending, moved, start + bending.places, start + np.array(held)),)


CLASSES = ("axial", "torsional", "bending")
BENDING = CLASSES.index("bending")
# Of a throw's mass and inertia, the share of either end section; the pins have the rest. By Simpson's
# rule, which integrates the square of a motion that grows linearly from end to end exactly. Without pins the
# sections have all.
END_SHARE, WITHOUT_PINS = 1.0 / 6.0, 0.5


@dataclass(frozen=True, eq=False)
class Stations:
    """Slices at sections, pins and end bodies, each moving as a rigid disc.

    Attributes
    ----------
    motions : (s, 6, u) array
        Of each slice at the point where the shaft axis passes through it (of an end body: of its center),
        per unknown, in the shaft's frame.
    axial_mass, lateral_mass : (s,) array
        [kg]
    polar, diametral : (s,) array
        Moments of inertia about the shaft axis and about a diameter [kg m^2].
    positions : (s,) array
        Along the shaft, from main bearing 1 [m].
    """

    motions: Array
    axial_mass: Array
    lateral_mass: Array
    polar: Array
    diametral: Array
    positions: Array

    def of(self, kept: Array) -> "Stations":
        """Return the stations for some of the unknowns."""
        return replace(self, motions=self.motions[:, :, kept])

    def energy_shares(self, shapes: Array, added_mass: Array) -> Array:
        """Split the energy of motions (u, k) into axial, torsional and bending shares (3, k), with the sum 1.

        `added_mass` (3, u, u) is that of bodies that only move along the shaft, that only turn about it, and
        that only bend.

        Notes
        -----
        The kinetic energy of an eccentric throw has products of rotation and translation, which belong
        to neither. Therefore each slice is referred to the point where the shaft axis passes through it, u,
        with the rotation r, and its energy is that of the three uncoupled systems:

            axial      m u_z^2
            torsional  J r_z^2            J about the shaft axis
            bending    m (u_x^2 + u_y^2) + D (r_x^2 + r_y^2)

        A sixth of a throw's m and J is at either end, the rest at its pins, with their mean motion
        (u = u_pin - r x r_pin, so that rotation of a pin about the shaft is no lateral
        motion); D = J / 2 as of a disc, end bodies have their own. Rods add to m of lateral motion
        and to J. The terms are squares, and turning the frame about the shaft axis changes none, so
        the shares are nonnegative, independent of the frame, and sum to 1. Without coupling
        they are the shares of the kinetic energy itself.
        """
        moved = np.einsum("siu,uk->sik", self.motions, shapes) ** 2
        along, about, across = np.sum(shapes * (added_mass @ shapes), axis=1)
        axial = self.axial_mass @ moved[:, UZ] + along
        torsional = self.polar @ moved[:, RZ] + about
        bending = self.lateral_mass @ (moved[:, UX] + moved[:, UY])
        bending = bending + self.diametral @ (moved[:, RX] + moved[:, RY]) + across
        energies = np.vstack((axial, torsional, bending))
        return np.asarray(energies / energies.sum(axis=0))


def shaft_stations(
    throws: Sequence[ShaftThrow],
    around: ShaftSurroundings,
    pin_masses: Array,
    starts: Array,
    section_motions: Array,
    pin_slices: Sequence[Array],
) -> Stations:
    """Build the stations of an assembled shaft.

    With the mass of rods and pistons at each pin (p,) [kg], the positions of the sections (n + 1,) [m], their
    motions (6 (n + 1), u), and that of each pin's slice (6, u) at the axis, in the shaft's frame.
    """
    count = len(starts)
    sections, pins, pin_places = np.zeros((count, 2)), [], []
    for number, throw in enumerate(throws):
        inertia = np.array(throw.rigid_inertia())
        sections[number : number + 2] += (END_SHARE if len(throw.pins) else WITHOUT_PINS) * inertia
        share = (1.0 - 2.0 * END_SHARE) / max(len(throw.pins), 1)
        pins += [share * inertia] * len(throw.pins)
        pin_places += [float(starts[number] + center[2]) for center in throw.pins]
    axial, polar = np.vstack((sections, *pins)).T
    diametral = 0.5 * polar
    radii = np.concatenate([np.hypot(*throw.pins[:, :2].T) for throw in throws])
    rods = np.concatenate((np.zeros(count), pin_masses))
    turning_rods = np.concatenate((np.zeros(count), pin_masses * radii**2))
    motions = np.concatenate((section_motions.reshape(count, 6, -1), pin_slices))
    bodies = around.bodies(count)
    of_bodies = np.array([[each.mass, each.polar_inertia, each.diametral] for each, _, _ in bodies])
    mass, turning, tilting = of_bodies.reshape(-1, 3).T
    centers = [body.center_motion(outward) @ motions[section] for body, section, outward in bodies]
    places = [float(starts[section]) + outward * body.overhang for body, section, outward in bodies]
    return Stations(
        motions=np.concatenate((motions, centers)) if centers else motions,
        axial_mass=np.concatenate((axial, mass)),
        lateral_mass=np.concatenate((axial + rods, mass)),
        polar=np.concatenate((polar + turning_rods, turning)),
        diametral=np.concatenate((diametral, tilting)),
        positions=np.concatenate((starts, pin_places, places)),
    )


def on_axis(center: Array) -> Array:
    """Return the matrix (6, 6) from a pin's motion to that of its slice where the shaft axis passes.

    Parameters
    ----------
    center : ndarray of shape (3,)
        Of the pin in the throw frame [m].
    """
    x, y = center[:2]
    moved = np.eye(6)
    # u - phi x r with r = (x, y, 0).
    moved[:3, 3:] = -np.array([[0.0, 0.0, -y], [0.0, 0.0, x], [y, -x, 0.0]])
    return moved


MOST_THROWS = 100
PIN_MOTIONS = ("tangential", "radial", "axial")
SECTION_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
ROTATION, TRANSLATION = "rotation about the shaft axis", "axial translation"


@result("section_count", "mass", "rigid", "positions [m]")
class AssembledShaft:
    """A crankshaft by its matrices.

    The u unknowns are the motions of the n + 1 sections in the shaft's frame, six each, the amplitudes
    of the sections' bending, those of the throws' shapes, the rotations of damper ring and driven
    machine, the motions of shaft lines, and how they bend; those held by supports are left out.

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
    added_mass : (3, u, u) array
        Mass matrices of these, along the shaft and about it, and of a line that bends.
    added_springs : (b, u) array
        Rows whose squares are twice the strain energy of damper spring, coupling, and springs and bending of
        lines.
    spring_kinds : (b,) array of int
        0 for those along the shaft, 1 for those about it, 2 for those across it.
    damped_springs : (b,) array of bool
        Which of these have damping of their own.
    dashpots : (d, u) array
        Directions in which dashpots, and springs that vary, act.
    varying : tuple of VaryingSpring
        Springs that vary with frequency or speed, in the u unknowns.
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

    mass: Array
    stiffness: Array
    damping: Array
    loss: Array
    rigid: Array
    rigid_names: tuple[str, ...]
    sections: Array = field(repr=False)
    pins: Array = field(repr=False)
    stations: Stations = field(repr=False)
    added: Array = field(repr=False)
    added_mass: Array = field(repr=False)
    added_springs: Array = field(repr=False)
    spring_kinds: Integers
    damped_springs: Flags
    dashpots: Array = field(repr=False)
    varying: tuple[VaryingSpring, ...] = field(repr=False)
    positions: Array
    pin_throws: tuple[int, ...]
    names: tuple[str, ...]
    momenta: Array = field(repr=False)
    moments: Array = field(repr=False)

    @property
    def expand(self) -> Array:
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
    attached, first_line = around.lines(count), first_ring + len(rings)
    first_bent = first_line + sum(chain.expansion().shape[1] - 1 for _, chain, _ in attached)
    bent = 0 if around.line_beam is None else 4 * (len(around.line_beam.bending.places) - 1)
    size = first_bent + bent
    lines = join_lines(attached, first_line, size)
    starts = np.concatenate(([0.0], np.cumsum([throw.length for throw in throws])))
    beams = join_beam(around, starts, first_bent, size)
    mass, stiffness, damping, loss = np.zeros((4, size, size))
    pin_rows, pin_slices, pin_frames = [], [], []
    # Each throw turned by itself about the shaft axis, and what that moves.
    about, momenta = np.zeros((2, len(throws), size))
    place = first_shape
    for number, throw in enumerate(throws):
        beyond = 6 * count + bending * number
        unknowns = np.r_[
            6 * number : 6 * number + 12,
            beyond : beyond + 2 * bending,
            place : place + throw.shapes,
        ]
        place += throw.shapes
        turn = throw.turn
        mass[np.ix_(unknowns, unknowns)] += turn @ throw.mass @ turn.T
        about[number, [6 * number + RZ, 6 * number + 6 + RZ]] = 1.0
        momenta[number, unknowns] = turn @ throw.mass @ turn.T @ about[number, unknowns]
        stiffness[np.ix_(unknowns, unknowns)] += turn @ throw.stiffness @ turn.T
        for pin, center in zip(throw.pin_loads, throw.pins, strict=True):
            motion = np.zeros((6, size))
            motion[:, unknowns] = (turn @ pin).T
            x, y = center[:2] / np.hypot(*center[:2])
            # In the throw's frame: sense of rotation, towards the axis, along the shaft.
            ways = [[-turning_sense * y, turning_sense * x, 0.0], [-x, -y, 0.0], [0.0, 0.0, 1.0]]
            pin_rows.append(np.array(ways) @ motion[:3])
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
        unknowns = np.r_[6 * section : 6 * section + 6]
        mass[np.ix_(unknowns, unknowns)] += body.mass_matrix(outward)
        if outward < 0.0:
            beyond_first[unknowns] += body.mass_matrix(outward)[RZ]

    unit = np.eye(size)
    held, dashpots, varying = [], [], []

    def join(
        row: Array,
        spring: float,
        dashpot: float,
        loss_factor: float = 0.0,
        variation: Variation | None = None,
    ) -> None:
        both = np.outer(row, row)
        spring, loss_factor, dashpot, law = varied(variation, spring, loss_factor, dashpot)
        stiffness[:] += spring * both
        damping[:] += dashpot * both
        loss[:] += loss_factor * spring * both
        if law is not None:
            varying.append(VaryingSpring(row, law))
        if dashpot or loss_factor or law is not None:
            dashpots.append(row)

    for place, spring, dashpot, variation in _supports(around, count):
        if np.isinf(spring):
            held.append(place)
        else:
            join(unit[place], spring, dashpot, variation=variation)
    added_mass = np.zeros((3, size, size))
    added_springs = [np.zeros((0, size))]
    spring_kinds, damped_springs = [1] * len(rings), []
    for row, (_, ring, section) in enumerate(rings, start=first_ring):
        added_mass[1, row, row] += ring.inertia
        beyond_first[row] += ring.inertia if section == 0 else 0.0
        twist = unit[row] - unit[6 * section + RZ]
        join(twist, ring.stiffness, ring.damping, ring.loss_factor, ring.variation)
        spring, loss_factor, dashpot, _ = ring.connection
        added_springs.append(math.sqrt(spring) * twist[np.newaxis])
        damped_springs.append(dashpot > 0.0 or loss_factor > 0.0)
    for line in lines:
        chain, moved = line.chain, line.motions
        added_mass[int(line.kind == "torsional")] += moved.T @ chain.mass_matrix() @ moved
        stiffness += moved.T @ chain.stiffness_matrix() @ moved
        damping += moved.T @ chain.damping_matrix() @ moved
        loss += moved.T @ chain.loss_matrix() @ moved
        added_springs.append(chain.spring_rows() @ moved)
        damped_springs += chain.damped_springs.tolist()
        more = chain.varying_springs(moved)
        varying += more
        dashpots += [spring.row for spring in more]
        spring_kinds += [int(line.kind == "torsional")] * len(added_springs[-1])
    for beam in beams:
        for moved in beam.motions:
            added_mass[BENDING] += moved.T @ beam.bending.mass @ moved
            added_springs.append(beam.bending.springs @ moved)
            stiffness += added_springs[-1].T @ added_springs[-1]
            spring_kinds += [BENDING] * len(added_springs[-1])
            damped_springs += [False] * len(added_springs[-1])
    mass += added_mass.sum(axis=0)
    added = np.vstack((unit[first_ring:first_line], *(line.motions[1:] for line in lines)))

    kept = np.setdiff1d(np.arange(size), held)
    free = np.ix_(kept, kept)
    stations = shaft_stations(throws, around, masses, starts, unit[: 6 * count], pin_slices)
    section_names = [
        f"main bearing {number} {way}" for number in range(1, count + 1) for way in SECTION_MOTIONS
    ]
    pin_names = [
        f"pin {number} {way}" for number in range(1, masses.size + 1) for way in PIN_MOTIONS
    ]
    rigid, rigid_names = _rigid_motions(around, starts, first_ring, lines, beams, size)
    # Moments about the shaft axis of unit forces on the pins before each section.
    pins = np.vstack(pin_rows)
    levers = np.einsum("pku,pu->pk", pins.reshape(len(pin_throws), 3, -1), about[pin_throws])
    before = np.arange(count)[:, np.newaxis] > np.array(pin_throws)
    return AssembledShaft(
        mass=mass[free],
        stiffness=stiffness[free],
        damping=damping[free],
        loss=loss[free],
        rigid=rigid[kept],
        rigid_names=rigid_names,
        sections=unit[: 6 * count, kept],
        pins=pins[:, kept],
        stations=stations.of(kept),
        added=added[:, kept],
        added_mass=added_mass[:, kept][:, :, kept],
        added_springs=np.vstack(added_springs)[:, kept],
        spring_kinds=np.array(spring_kinds, dtype=np.int64),
        damped_springs=np.array(damped_springs, dtype=bool),
        dashpots=np.array(dashpots).reshape(-1, size)[:, kept],
        varying=tuple(replace(spring, row=spring.row[kept]) for spring in varying),
        positions=starts,
        pin_throws=tuple(pin_throws),
        names=(
            *section_names,
            *pin_names,
            *(name for name, _, _ in rings),
            *(name for line in lines for name in line.names),
        ),
        momenta=np.cumsum(np.vstack((beyond_first, momenta)), axis=0)[:, kept],
        moments=(before[:, :, np.newaxis] * levers).reshape(count, -1),
    )


def _supports(
    around: ShaftSurroundings, count: int
) -> list[tuple[int, float, float, Variation | None]]:
    """Return the unknowns that bearings and axial supports act on, stiffness, damping, variation."""
    springs = []
    if around.bearings is not None:
        variation = around.bearings.variation
        each = zip(*(values.tolist() for values in around.bearings.at(count)), strict=True)
        for section, (stiffness, damping) in enumerate(each):
            springs += [
                (6 * section + motion, stiffness, damping, variation) for motion in (UX, UY)
            ]
    for support in around.axial_supports:
        section = whole_within(
            "axial support section",
            support.section,
            0,
            count - 1,
            f"the shaft has {count} sections",
        )
        springs.append((6 * section + UZ, support.stiffness, support.damping, support.variation))
    return springs


def _rigid_motions(
    around: ShaftSurroundings,
    places: Array,
    first_ring: int,
    lines: Sequence[JoinedLine],
    beams: Sequence[JoinedBeam],
    size: int,
) -> tuple[Array, tuple[str, ...]]:
    """Return the unit motions (size, r) that no stiffness resists, as columns, and their names."""
    unit, count = np.eye(size), len(places)

    def motion(values: dict[int, Array | float]) -> Array:
        column = np.zeros(size)
        for component, value in values.items():
            column[component : 6 * count : 6] = value
        return column

    motions = {ROTATION: motion({RZ: 1.0})}
    for row, (name, ring, _) in enumerate(around.rings(count), start=first_ring):
        if ring.stiffness > 0.0:
            motions[ROTATION][row] = 1.0
        else:
            motions[f"rotation of the {name.removeprefix('damper ')} alone"] = unit[row]
    if not any(support.stiffness > 0.0 for support in around.axial_supports):
        motions[TRANSLATION] = motion({UZ: 1.0})
    for line in lines:
        with_section, alone = line.rigid_motions()
        together = ROTATION if line.kind == "torsional" else TRANSLATION
        if with_section is None:
            motions.pop(together, None)
        elif together in motions:
            motions[together] += with_section
        motions |= {
            f"{together.partition(' ')[0]} of {names} alone": column for column, names in alone
        }
    bearings = np.array([])
    if around.bearings is not None:
        bearings = places[around.bearings.at(count)[0] > 0.0]
    bearings = np.unique(np.concatenate((bearings, *(beam.bearings for beam in beams))))
    pivot = float(bearings[0]) if bearings.size else float(places.mean())
    arms = places - pivot

    def lateral(plane: int, values: dict[int, Array | float], across: float, tilt: float) -> Array:
        column = motion(values)
        for beam in beams:
            motions = beam.motions[plane, 2:]
            column += motions.T @ beam.rigid(across, tilt, pivot)[2:]
        return column

    if bearings.size == 0:
        motions["translation along x"] = lateral(0, {UX: 1.0}, 1.0, 0.0)
        motions["translation along y"] = lateral(1, {UY: 1.0}, 1.0, 0.0)
    if bearings.size <= 1:
        motions["tilt about x"] = lateral(1, {RX: 1.0, UY: -arms}, 0.0, -1.0)
        motions["tilt about y"] = lateral(0, {RY: 1.0, UX: arms}, 0.0, 1.0)
    return np.column_stack([np.zeros((size, 0)), *motions.values()]), tuple(motions)
