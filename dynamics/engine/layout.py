"""An engine's mechanism: cylinders in any arrangement on one crankshaft, and their firing angles."""

import cmath
import math
import re
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from crankbase.array_checks import (
    Array,
    finite_array,
    nonnegative_number,
    positive_number,
    refuse_crank_radians,
)
from crankbase.choices import check_kind, check_some, is_whole, whole_within
from crankbase.errors import InputError
from crankbase.results import Quantity, Result, result
from crankbase.sentences import in_si, kept
from crankbase.summaries import frozen
from dynamics.cycle import checked_strokes, cycle_degrees, even_angles
from dynamics.engine.rods import (
    ConnectingRod,
    PointMotion,
    carried_point,
    check_reach,
    crankpin_motion,
    rod_turn,
)

# Crank and cylinder axis count as in line within this angle [rad]; files give degrees.
IN_LINE = 1e-6
# Firings count as even, or as one, within this angle [rad], the digits of given angles.
EVEN = math.radians(0.5)
# Cylinders of a four-stroke engine of which all orders are tried: two tops in a cycle for each.
MOST_TRIED = 16
# No engine has more.
MOST_CYLINDERS = 48


def check_firing_order(firing_order: Sequence[int], cylinders: int) -> None:
    """Refuse an order that repeats or omits a cylinder."""
    order, fault = list(firing_order), ""
    for number in order:
        if not is_whole(number):
            fault = "cylinders have whole numbers"
        elif not 1 <= number <= cylinders:
            fault = f"the engine has no cylinder {number}"
        elif order.count(number) > 1:
            fault = f"it repeats cylinder {number}"
        if fault:
            break
    missing = [number for number in range(1, cylinders + 1) if number not in order]
    if missing and not fault:
        fault = f"it omits cylinder {missing[0]}"
    if fault:
        raise InputError(
            f"firing_order: given {order}; allowed is each cylinder number from 1 to {cylinders} "
            f"once, because {fault}."
        )


def firing_order_from_text(text: str, before: str = "firing_order: ") -> tuple[int, ...]:
    """Return the cylinders of a firing order written in the usual way.

    Parameters
    ----------
    before : str, optional
        What the message of the `InputError` begins with where the text is no order.

    Examples
    --------
    >>> firing_order_from_text("1-5-3-6-2-4")
    (1, 5, 3, 6, 2, 4)
    """
    parts = re.split(r"\s*[-,]\s*|\s+", text.strip())
    if not all(re.fullmatch("[0-9]{1,3}", part) for part in parts):
        raise InputError(
            f"{before}given {text!r}; allowed are cylinder numbers with dashes between them, like "
            '"1-5-3-6-2-4", or a list of them.'
        )
    return tuple(int(part) for part in parts)


def firing_angles_of_order(
    firing_order: Sequence[int], top_angles: Sequence[float], strokes: int
) -> tuple[float, ...]:
    """Return the shaft angle at which each cylinder fires, for even or uneven intervals.

    Parameters
    ----------
    top_angles : sequence of n float
        A shaft angle at which each cylinder's crank is along its axis, away from the shaft [rad].

    Returns
    -------
    tuple of n float
        Firing angles by cylinder [rad], from that of the first to fire, which is within the first
        revolution, to less than one cycle more. Each cylinder fires at the first of its tops after the
        preceding cylinder has fired.
    """
    tops = list(top_angles)
    check_firing_order(firing_order, len(tops))
    turn, cycle = 2.0 * math.pi, math.radians(cycle_degrees(strokes))
    angles = [0.0] * len(tops)
    first = _after(tops[firing_order[0] - 1], -IN_LINE, turn)
    last = first - IN_LINE
    for place, number in enumerate(firing_order):
        # After the first, the same angle means one turn later.
        last = _after(tops[number - 1], last if place == 0 else last + IN_LINE, turn)
        angles[number - 1] = last
        if last - first > cycle - IN_LINE:
            degrees = [round(math.degrees(angle % turn), 3) for angle in tops]
            raise InputError(
                f"firing_order: given {list(firing_order)}; allowed is an order whose cylinders reach "
                f"their tops (at {degrees} deg of the shaft, cylinder by cylinder) within one cycle of "
                f"{math.degrees(cycle):g} deg, because each fires at its top."
            )
    return tuple(angles)


def firing_intervals(firing_angles: Sequence[float], strokes: int) -> tuple[float, ...]:
    """Return the shaft angles from each firing to the next, over one cycle.

    Parameters
    ----------
    firing_angles : sequence of n float
        In any order, all within one cycle [rad].

    Returns
    -------
    tuple of n float
        [rad]; their sum is one cycle.

    Examples
    --------
    >>> [round(math.degrees(step)) for step in firing_intervals([0.0, math.pi], 4)]
    [180, 540]
    """
    angles = sorted(firing_angles)
    cycle = math.radians(cycle_degrees(strokes))
    following = [*angles[1:], angles[0] + cycle]
    return tuple(after - before for before, after in zip(angles, following, strict=True))


def repeating_intervals(intervals_deg: Sequence[float]) -> tuple[float, ...]:
    """Return the intervals that repeat through a cycle, once.

    Parameters
    ----------
    intervals_deg : sequence of float
        Between all firings of a cycle [deg].

    Examples
    --------
    >>> repeating_intervals([90.0, 30.0, 90.0, 30.0])
    (90.0, 30.0)
    """
    steps = tuple(intervals_deg)
    for size in range(1, len(steps)):
        repeated = steps[:size] * (len(steps) // size)
        pairs = zip(steps, repeated, strict=False)
        if len(steps) % size == 0 and all(math.isclose(*pair, abs_tol=0.01) for pair in pairs):
            return steps[:size]
    return steps


def even_firing_order(firing_angles: Sequence[float], strokes: int) -> tuple[int, ...] | None:
    """Return a firing order with even intervals for the same cranks.

    In a four-stroke engine each cylinder may fire at its top or one turn later.

    Parameters
    ----------
    firing_angles : sequence of n float
        Shaft angle at which each cylinder fires now [rad].

    Returns
    -------
    tuple of int or None
        Cylinder numbers, beginning with the one that fires first now, the lowest number of several; None
        if no order is even.

    Examples
    --------
    >>> even_firing_order([0.0, 2.0 * math.pi, math.pi, 3.0 * math.pi], 4)
    (1, 3, 2, 4)
    """
    count, first = len(firing_angles), min(firing_angles)
    step = math.radians(cycle_degrees(strokes)) / count
    slots: dict[int, int] = {}
    for number in sorted(range(1, count + 1), key=lambda cylinder: firing_angles[cylinder - 1]):
        for turn in range(strokes // 2):
            place = (firing_angles[number - 1] - first + turn * 2.0 * math.pi) / step
            slot = round(place)
            if abs(place - slot) * step < EVEN and slot % count not in slots:
                slots[slot % count] = number
                break
        else:
            return None
    return tuple(slots[place] for place in range(count))


def least_uneven_order(
    firing_angles: Sequence[float], strokes: int
) -> tuple[tuple[int, ...], tuple[float, ...]] | None:
    """Return the firing order whose intervals differ least for the same cranks, and its intervals.

    Returns
    -------
    order : tuple of int
        Cylinder numbers, beginning with the one that fires first now. Of orders with the same difference
        between longest and shortest interval that which repeats most often in a cycle, then the most even.
    intervals : tuple of float
        [rad].
    None
        If no order fires each cylinder at the first of its tops after the preceding one, or the cylinders
        of a four-stroke engine are too many to try all (`MOST_TRIED`).

    Examples
    --------
    >>> order, steps = least_uneven_order([0.0, math.pi / 2, math.pi, 3 * math.pi / 2], 4)
    >>> order, [round(math.degrees(step)) for step in steps]
    ((1, 2, 4, 3), [90, 180, 270, 180])
    """
    count, cycle = len(firing_angles), math.radians(cycle_degrees(strokes))
    if strokes == 4 and count > MOST_TRIED:
        return None
    first = int(np.argmin(firing_angles))
    now = np.asarray(firing_angles) - firing_angles[first]
    free = [place for place in range(count) if place != first] if strokes == 4 else []
    later = np.zeros((2 ** len(free), count))
    later[:, free] = np.arange(len(later))[:, np.newaxis] >> np.arange(len(free)) & 1
    angles = (now + 2.0 * math.pi * later) % cycle
    angles[cycle - angles < IN_LINE] = 0.0
    ordered = np.sort(angles, axis=1)
    steps = np.diff(ordered, axis=1, append=ordered[:, :1] + cycle)
    spread = np.where(
        np.max(steps, axis=1) <= 2.0 * math.pi + IN_LINE, np.ptp(steps, axis=1), np.inf
    )
    if not np.isfinite(np.min(spread)):
        return None
    even = np.flatnonzero(spread <= np.min(spread) + EVEN)

    def rank(row: int) -> tuple[int, float, tuple[int, ...]]:
        repeated = repeating_intervals(
            [round(math.degrees(interval), 1) for interval in steps[row]]
        )
        return len(repeated), round(float(np.sum(steps[row] ** 2)), 6), _order_of(angles[row])

    best = min(even.tolist(), key=rank)
    return _order_of(angles[best]), tuple(steps[best].tolist())


def _order_of(angles: Array) -> tuple[int, ...]:
    return tuple((1 + np.argsort(np.round(angles, 9), kind="stable")).tolist())


def _after(angle: float, least: float, turn: float) -> float:
    """Return the first of angle + k turns that is above `least`."""
    return angle + turn * (math.floor((least - angle) / turn) + 1)


def check_order_of_angles(
    firing_order: Sequence[int], firing_angles: Sequence[float], strokes: int
) -> None:
    """Refuse a firing order that contradicts the firing angles.

    Cylinders that fire together may be in either order, and the order may begin with any
    cylinder, because the cycle repeats.

    Parameters
    ----------
    firing_angles : sequence of n float
        Shaft angle at which each cylinder fires, in any cycle [rad].
    """
    cycle = math.radians(cycle_degrees(strokes))
    angles = [firing_angles[number - 1] for number in firing_order]
    following = angles[1:] + angles[:1]
    once_round = sum(_angle_after(*ends, cycle) for ends in zip(angles, following, strict=True))
    # From each to the next and back to the first takes one cycle; none if all fire together.
    if once_round > 1.5 * cycle:
        allowed = list(firing_order_of_angles(firing_angles, strokes, firing_order[0]))
        raise InputError(
            f"firing_order: given {list(firing_order)}; allowed is {allowed}, because the firing "
            f"angles follow each other so in a cycle of {math.degrees(cycle):g} deg."
        )


def firing_order_of_angles(
    firing_angles: Sequence[float], strokes: int, first: int
) -> tuple[int, ...]:
    """Return the cylinder numbers in the order in which they fire."""
    later = [round(angle, 9) for angle in angles_after_first(firing_angles, strokes, first)]
    others = (number for number in range(1, len(firing_angles) + 1) if number != first)
    return (first, *sorted(others, key=lambda number: (later[number - 1], number)))


def angles_after_first(angles: Sequence[float], strokes: int, first: int = 1) -> tuple[float, ...]:
    """Return how much later in the cycle each cylinder's angle is than that of one of them [rad]."""
    cycle, start = math.radians(cycle_degrees(strokes)), angles[first - 1]
    return tuple(_angle_after(start, angle, cycle) for angle in angles)


def _angle_after(earlier: float, later: float, cycle: float) -> float:
    """Return how much later in the cycle the other angle is; zero within round-off if together."""
    apart = (later - earlier) % cycle
    return apart - cycle if cycle - apart < IN_LINE else apart


@dataclass(frozen=True)
class SlavePin:
    """The pin by which a rod is hinged to the rod of another cylinder on the same crankpin.

    Parameters
    ----------
    main_cylinder : int
        Number of the cylinder whose rod carries the pin, from 1.
    radius : float
        R_1 (r in some papers), from the crankpin's center [m].
    angle_deg : float
        From the main rod's axis, in the sense of rotation [deg]; equal to the angle between the
        cylinders' axes in most engines.
    """

    main_cylinder: int
    radius: float
    _: KW_ONLY
    angle_deg: float

    def __post_init__(self) -> None:
        if not is_whole(self.main_cylinder):
            raise InputError(
                f"slave pin main_cylinder: given {self.main_cylinder!r}; allowed is a whole number, "
                "because cylinders are counted from 1."
            )
        positive_number("slave pin radius", self.radius, "m", "it is a length")
        finite_array("slave pin angle_deg", self.angle_deg)

    @property
    def place(self) -> complex:
        """Position on the main rod, u + i v from the crankpin's center [m]."""
        return cmath.rect(self.radius, math.radians(self.angle_deg))


@frozen(
    "bore [m]",
    "piston_mass [kg]",
    "crank_angle_deg [deg]",
    "bank_angle_deg [deg]",
    "position [m]",
    "pin_offset [m]",
)
class EngineCylinder:
    """One cylinder with its piston and rod, and its position.

    Parameters
    ----------
    bore : float
        [m]
    piston_mass : float
        Piston with rings and pin, and crosshead and piston rod if present [kg].
    crank_angle_deg : float, optional
        Angle of its crankpin about +z, counted from +y, when the shaft angle is zero [deg].
    bank_angle_deg : float, optional
        Angle of its axis about +z, counted from +y [deg].
    position : float, optional
        Of its axis along the shaft [m].
    pin_offset : float, optional
        e: offset of its axis from the shaft axis, positive to the side to which the crankpin
        moves as it passes the top [m].
    slave_pin : SlavePin, optional
        Hinge of its rod, if not at the crankpin.
    """

    bore: float
    piston_mass: float
    rod: ConnectingRod
    _: KW_ONLY
    crank_angle_deg: float = 0.0
    bank_angle_deg: float = 0.0
    position: float = 0.0
    pin_offset: float = 0.0
    slave_pin: SlavePin | None = None

    def __post_init__(self) -> None:
        check_kind("rod", self.rod, ConnectingRod, "a ConnectingRod")
        positive_number("bore", self.bore, "m", "it is a length")
        positive_number("piston_mass", self.piston_mass, "kg", "it is a mass")
        for name in ("crank_angle_deg", "bank_angle_deg", "position", "pin_offset"):
            finite_array(name, getattr(self, name))

    @property
    def area(self) -> float:
        """Area of the piston [m^2]."""
        return 0.25 * math.pi * self.bore**2

    @property
    def top_shaft_angle_deg(self) -> float:
        """Shaft angle at which its crank is along its axis, away from the shaft [deg]."""
        return self.bank_angle_deg - self.crank_angle_deg


@result("static_moment", "angle_deg", "position", eq=True)
class RotatingMass(Result):
    """A mass that rotates with the shaft: a counterweight, or the unbalance of a throw.

    Parameters
    ----------
    static_moment : float
        Mass times radius [kg m].
    angle_deg : float
        Of its center of mass about +z, counted from +y, when the shaft angle is zero [deg].
    position : float
        Along the shaft [m].
    """

    static_moment: Annotated[float, Quantity("kg m")]
    _: KW_ONLY
    angle_deg: Annotated[float, Quantity("deg")]
    position: Annotated[float, Quantity("m")] = 0.0

    def __post_init__(self) -> None:
        nonnegative_number("static_moment", self.static_moment, "kg m", "it is mass times radius")
        finite_array("angle_deg", self.angle_deg)
        finite_array("position", self.position)


def cylinder_crankpin(
    cylinder: EngineCylinder, crank_radius: float, shaft_angles: Array
) -> PointMotion:
    """Return the motion of a crankpin in its cylinder's frame, shaft angles [rad] of shape (m,)."""
    return crankpin_motion(crank_radius, shaft_angles - math.radians(cylinder.top_shaft_angle_deg))


def hinged_foot(
    crank_radius: float, main: EngineCylinder, hinged: EngineCylinder, shaft_angles: Array
) -> PointMotion:
    """Return the motion of a slave pin in the frame of the hinged rod's cylinder.

    Parameters
    ----------
    crank_radius : float
        R [m].
    shaft_angles : ndarray of shape (m,)
        [rad]

    Notes
    -----
    P = R exp(i alpha) + R_1 exp(i gamma) exp(-i beta) in the main cylinder's frame. Turned to the
    other cylinder's frame, with gamma equal to the angle between the banks, it gives (2) and (4) of
    Mikhina, Vyalkov 2024, Politekhnicheskiy molodezhnyy zhurnal no. 05 (94).
    """
    if hinged.slave_pin is None:
        raise ValueError("the rod is not hinged")
    crank = cylinder_crankpin(main, crank_radius, shaft_angles)
    turn = rod_turn(crank, main.rod.length, main.pin_offset)
    pin = carried_point(crank, turn, hinged.slave_pin.place)
    return pin.turned(angle_deg=main.bank_angle_deg - hinged.bank_angle_deg)


# Crank angles at which a hinged rod is tried over a turn.
TRIED_ANGLES = 720
# Rods that share a crankpin stand in one place along the shaft, but for round-off [m].
SAME_PLACE = 1e-9


@frozen("cylinders", "crank_radius [m]", "firing_order", "strokes")
class EngineLayout:
    """The mechanism of a whole engine.

    The shaft turns about +z, which runs from the free end to the flywheel; y points up, and
    x = y cross z. In line, all bank angles are equal; in a V engine two cylinders share a throw,
    with rods side by side or one hinged to the other. Sequences are stored as tuples, so a layout
    cannot change after its check.

    Parameters
    ----------
    crank_radius : float
        R [m].
    cylinders : sequence of n EngineCylinder
        Cylinder 1 first.
    firing_order : sequence of n int, or str
        Cylinder numbers in the order of firing, or as text like ``"1-5-3-6-2-4"``; each fires at its top.
    firing_angles_deg : sequence of n float, optional
        Shaft angle at which each cylinder fires [deg], if the order does not determine it: cylinders
        that fire together, or a top skipped on purpose. In any cycle, in the firing order. This holds
        only given angles; `firing_deg` has the angles in all cases.
    rotating : sequence of RotatingMass, optional
        Counterweights and throws.
    shaft_inertia : float, optional
        Of all that rotates with the shaft, with the flywheel, without the rods [kg m^2].

    Raises
    ------
    InputError
        If the firing order repeats or omits a cylinder or does not fit cranks or firing angles, a
        crank cannot complete a revolution, or a rod is hinged to a rod that is not on its crankpin or is
        elsewhere along the shaft.
    """

    crank_radius: float
    cylinders: Sequence[EngineCylinder]
    firing_order: Sequence[int] | str
    strokes: int = 4
    _: KW_ONLY
    firing_angles_deg: Sequence[float] | None = None
    rotating: Sequence[RotatingMass] = ()
    shaft_inertia: float = 0.0

    def __post_init__(self) -> None:
        positive_number("crank_radius", self.crank_radius, "m", "it is a length")
        nonnegative_number("shaft_inertia", self.shaft_inertia, "kg m^2", "it is an inertia")
        checked_strokes(self.strokes)
        for name in ("cylinders", "rotating"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        check_some("cylinders", self.cylinders, "an engine has cylinders")
        for number, cylinder in enumerate(self.cylinders, start=1):
            self._check_rod(number, cylinder)
        refuse_crank_radians(
            "crank_angle_deg", [cylinder.crank_angle_deg for cylinder in self.cylinders]
        )
        order = self.firing_order
        order = firing_order_from_text(order) if isinstance(order, str) else tuple(order)
        check_firing_order(order, len(self.cylinders))
        object.__setattr__(self, "firing_order", tuple(int(number) for number in order))
        if self.firing_angles_deg is None:
            _ = self.firing_deg  # refuses an order that does not fit the cranks
        else:
            object.__setattr__(
                self, "firing_angles_deg", self._checked_angles(self.firing_angles_deg)
            )

    @cached_property
    def firing_deg(self) -> tuple[float, ...]:
        """Shaft angle at which each cylinder fires, cylinder by cylinder [deg].

        Those given as `firing_angles_deg`, or those that follow from the firing order.
        """
        if self.firing_angles_deg is not None:
            return tuple(self.firing_angles_deg)
        tops = [math.radians(cylinder.top_shaft_angle_deg) for cylinder in self.cylinders]
        firing_angles = firing_angles_of_order(
            tuple(map(int, self.firing_order)), tops, self.strokes
        )
        return tuple(math.degrees(angle) for angle in firing_angles)

    @property
    def cycle_deg(self) -> float:
        """Length of the working cycle in shaft angle [deg]."""
        return cycle_degrees(self.strokes)

    def main_of(self, number: int) -> int:
        """Return the number of the cylinder whose rod is on the crankpin: its own or the main one."""
        pin = self.cylinder(number).slave_pin
        return number if pin is None else pin.main_cylinder

    def cylinder(self, number: int) -> EngineCylinder:
        """Return a cylinder by its number, from 1."""
        why = "the cylinders are numbered from 1"
        return self.cylinders[whole_within("number", number, 1, len(self.cylinders), why) - 1]

    def _check_rod(self, number: int, cylinder: EngineCylinder) -> None:
        name = f"cylinder {number}: "
        if cylinder.slave_pin is None:
            check_reach(
                f"{name}crank_radius", self.crank_radius, cylinder.rod.length, cylinder.pin_offset
            )
            return
        main = cylinder.slave_pin.main_cylinder
        if main == number or not 1 <= main <= len(self.cylinders):
            raise InputError(
                f"{name}slave pin: given main cylinder {main}; allowed is another cylinder from 1 to "
                f"{len(self.cylinders)}, because the rod is hinged to that one's rod."
            )
        carrier = self.cylinders[main - 1]
        if carrier.slave_pin is not None:
            raise InputError(
                f"{name}slave pin: given main cylinder {main}, whose own rod is hinged; allowed is one "
                "whose rod is on the crankpin, because rods are hinged to main rods."
            )
        apart = math.remainder(
            math.radians(carrier.crank_angle_deg - cylinder.crank_angle_deg), 2.0 * math.pi
        )
        if abs(apart) > IN_LINE:
            raise InputError(
                f"{name}crank_angle_deg: given {cylinder.crank_angle_deg:g} deg; allowed is that of "
                f"cylinder {main}, {carrier.crank_angle_deg:g} deg, because they share a crankpin."
            )
        if abs(carrier.position - cylinder.position) > SAME_PLACE:
            raise InputError(
                f"{name}position: given {in_si(cylinder.position, 'm')}; allowed is that of cylinder {main}, "
                f"{in_si(carrier.position, 'm')}, because its rod is hinged to that one's."
            )
        if not cylinder.slave_pin.radius < carrier.rod.length:
            raise InputError(
                f"{name}slave pin radius: given {in_si(cylinder.slave_pin.radius, 'm')}; allowed is less "
                f"than the main rod's length of {in_si(carrier.rod.length, 'm')}, because the pin sits on "
                "that rod."
            )
        angles = even_angles(2.0 * math.pi, TRIED_ANGLES)
        foot = hinged_foot(self.crank_radius, carrier, cylinder, angles)
        try:
            rod_turn(foot, cylinder.rod.length, cylinder.pin_offset)
        except InputError as error:
            raise InputError(f"{name}{kept(str(error))}") from None

    def _checked_angles(self, firing_angles_deg: Sequence[float]) -> tuple[float, ...]:
        firing_angles = finite_array("firing_angles_deg", list(firing_angles_deg))
        refuse_crank_radians("firing_angles_deg", firing_angles)
        if firing_angles.shape != (len(self.cylinders),):
            raise InputError(
                f"firing_angles_deg: given {firing_angles.size} angles; allowed is one for each of the "
                f"{len(self.cylinders)} cylinders, because each fires at its own."
            )
        angles = tuple(math.radians(angle) for angle in firing_angles.tolist())
        for number, (angle, cylinder) in enumerate(
            zip(angles, self.cylinders, strict=True), start=1
        ):
            off = math.remainder(angle - math.radians(cylinder.top_shaft_angle_deg), 2.0 * math.pi)
            if abs(off) > IN_LINE:
                raise InputError(
                    f"firing_angles_deg: given {math.degrees(angle):g} deg for cylinder {number}; allowed is "
                    f"{cylinder.top_shaft_angle_deg:g} deg plus whole turns, because it fires "
                    "where its crank lies along its axis."
                )
        check_order_of_angles(tuple(map(int, self.firing_order)), angles, self.strokes)
        return tuple(firing_angles.tolist())


def check_distinct_positions(engine: EngineLayout) -> None:
    """Refuse cylinders of one bank at the same position, where moments and bearing loads are needed."""
    standing: list[tuple[int, EngineCylinder]] = []
    for number, cylinder in enumerate(engine.cylinders, start=1):
        for other, earlier in standing:
            apart = math.remainder(
                math.radians(cylinder.bank_angle_deg - earlier.bank_angle_deg), 2.0 * math.pi
            )
            if abs(apart) <= IN_LINE and abs(cylinder.position - earlier.position) <= SAME_PLACE:
                raise InputError(
                    f"cylinder {number}: position: given {in_si(cylinder.position, 'm')}, where cylinder "
                    f"{other} of the same bank stands; allowed are different positions along the shaft, "
                    "because moments and bearing loads follow from them."
                )
        standing.append((number, cylinder))
