"""An engine's mechanism: cylinders in any arrangement on one crankshaft."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from crankbase.checks.angles import refuse_crank_radians
from crankbase.checks.arrays import finite_array, nonnegative_number, positive_number
from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import checked_strokes, cycle_degrees, even_angles
from dynamics.engine.cylinder import EngineCylinder, RotatingMass, hinged_foot
from dynamics.engine.firing import (
    IN_LINE,
    check_firing_order,
    check_order_of_angles,
    firing_angles_of_order,
    firing_order_from_text,
)
from dynamics.mechanism.motion import rod_turn
from dynamics.mechanism.slider_crank import check_reach

# Crank angles at which a hinged rod is tried over a turn.
TRIED_ANGLES = 720
# Rods that share a crankpin stand in one place along the shaft, but for round-off [m].
SAME_PLACE = 1e-9


@summarized("cylinders", "crank_radius [m]", "firing_order", "strokes")
@dataclass(frozen=True)
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
    strokes : int, optional
        Strokes per cycle, 2 or 4.
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
        if not self.cylinders:
            raise InputError(
                "cylinders: given none; allowed are one or more, because an engine has cylinders."
            )
        for number, cylinder in enumerate(self.cylinders, start=1):
            self._check_rod(number, cylinder)
        refuse_crank_radians(
            "crank_angle_deg", [cylinder.crank_angle_deg for cylinder in self.cylinders]
        )
        given = self.firing_order
        order = firing_order_from_text(given) if isinstance(given, str) else tuple(given)
        check_firing_order(order, len(self.cylinders))
        object.__setattr__(self, "firing_order", tuple(int(number) for number in order))
        if self.firing_angles_deg is None:
            _ = self.firing_deg  # refuses an order that does not fit the cranks
        else:
            object.__setattr__(
                self, "firing_angles_deg", self._checked_angles(self.firing_angles_deg)
            )

    @property
    def firing_deg(self) -> tuple[float, ...]:
        """Shaft angle at which each cylinder fires, cylinder by cylinder [deg].

        Those given as `firing_angles_deg`, or those that follow from the firing order.
        """
        if self.firing_angles_deg is not None:
            return tuple(self.firing_angles_deg)
        tops = [math.radians(cylinder.top_shaft_angle_deg) for cylinder in self.cylinders]
        found = firing_angles_of_order(tuple(map(int, self.firing_order)), tops, self.strokes)
        return tuple(math.degrees(angle) for angle in found)

    @property
    def cycle_deg(self) -> float:
        """Length of the working cycle in shaft angle [deg]."""
        return cycle_degrees(self.strokes)

    def main_of(self, number: int) -> int:
        """Return the number of the cylinder whose rod is on the crankpin: its own or the main one.

        Raises
        ------
        InputError
            If there is no such cylinder.
        """
        pin = self.cylinder(number).slave_pin
        return number if pin is None else pin.main_cylinder

    def cylinder(self, number: int) -> EngineCylinder:
        """Return a cylinder by its number, from 1.

        Raises
        ------
        InputError
            If there is no such cylinder.
        """
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
                f"{name}position: given {cylinder.position:g} m; allowed is that of cylinder {main}, "
                f"{carrier.position:g} m, because its rod is hinged to that one's."
            )
        if not cylinder.slave_pin.radius < carrier.rod.length:
            raise InputError(
                f"{name}slave pin radius: given {cylinder.slave_pin.radius:g} m; allowed is less than the "
                f"main rod's length of {carrier.rod.length:g} m, because the pin sits on that rod."
            )
        angles = even_angles(2.0 * math.pi, TRIED_ANGLES)
        foot = hinged_foot(self.crank_radius, carrier, cylinder, angles)
        try:
            rod_turn(foot, cylinder.rod.length, cylinder.pin_offset)
        except InputError as error:
            raise InputError(f"{name}{error}") from None

    def _checked_angles(self, firing_angles_deg: Sequence[float]) -> tuple[float, ...]:
        given = finite_array("firing_angles_deg", list(firing_angles_deg))
        refuse_crank_radians("firing_angles_deg", given)
        if given.shape != (len(self.cylinders),):
            raise InputError(
                f"firing_angles_deg: given {given.size} angles; allowed is one for each of the "
                f"{len(self.cylinders)} cylinders, because each fires at its own."
            )
        angles = tuple(math.radians(angle) for angle in given.tolist())
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
        return tuple(given.tolist())


def check_distinct_positions(engine: EngineLayout) -> None:
    """Refuse cylinders of one bank at the same position, where moments and bearing loads are needed.

    Raises
    ------
    InputError
        Names two of them.
    """
    standing: list[tuple[int, EngineCylinder]] = []
    for number, cylinder in enumerate(engine.cylinders, start=1):
        for other, earlier in standing:
            apart = math.remainder(
                math.radians(cylinder.bank_angle_deg - earlier.bank_angle_deg), 2.0 * math.pi
            )
            if abs(apart) <= IN_LINE and abs(cylinder.position - earlier.position) <= SAME_PLACE:
                raise InputError(
                    f"cylinder {number}: position: given {cylinder.position:g} m, where cylinder {other} of "
                    "the same bank stands; allowed are different positions along the shaft, because moments "
                    "and bearing loads follow from them."
                )
        standing.append((number, cylinder))
