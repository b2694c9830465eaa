"""Effect of hinged rods on the inertia forces, compared with rods side by side on the crankpin."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from crankbase.checks.arrays import positive_number
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.balance.hodograph import Hodograph, hodograph_sum
from dynamics.balance.moving_masses import moving_masses, reciprocating_forces
from dynamics.engine.layout import EngineLayout
from dynamics.engine.orders import checked_cylinder, checked_orders
from dynamics.plots.load_diagrams import FORCE_LABELS, draw_hodographs


@dataclass(frozen=True)
class HodographChange:
    """The difference between two hodographs.

    Parameters
    ----------
    major, minor : float or None
        Change of the semi-axes as a share of the other's; none where the other's is zero.
    turn_deg : float or None
        Rotation of the major axis about +z [deg], -90 to 90; none where one has no major axis.
    """

    major: float | None
    minor: float | None
    turn_deg: float | None


def hodograph_change(hodograph: Hodograph, reference: Hodograph) -> HodographChange:
    """Return how a hodograph differs from a reference."""
    turn = (
        None
        if hodograph.angle_deg is None or reference.angle_deg is None
        else math.remainder(hodograph.angle_deg - reference.angle_deg, 180.0)
    )
    # The minor axis of a line is round-off.
    minor = hodograph.minor / reference.minor - 1.0 if reference.sense else None
    major = hodograph.major / reference.major - 1.0 if reference.major else None
    return HodographChange(major, minor, turn)


@summarized("order", "curves")
@dataclass(frozen=True)
class HingedRodEffects:
    """Inertia forces of one order [N], with rods side by side and hinged, and the separate effects.

    Parameters
    ----------
    order : int
        Cycles per revolution of the shaft.
    side_by_side : Hodograph
        Each hinged rod replaced by a copy of the main rod, and its reciprocating mass by that of
        the main rod's cylinder.
    kinematics : Hodograph
        Actual piston motion, masses of the main rods' cylinders.
    masses : Hodograph
        Piston motion of rods side by side, actual masses.
    hinged : Hodograph
        Actual motion and masses.
    """

    order: int
    side_by_side: Hodograph
    kinematics: Hodograph
    masses: Hodograph
    hinged: Hodograph

    @property
    def curves(self) -> dict[str, Hodograph]:
        """The four forces by name."""
        return {
            "rods side by side": self.side_by_side,
            "movement alone": self.kinematics,
            "masses alone": self.masses,
            "hinged rods": self.hinged,
        }

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the four forces as seen from the free end: y up, x to the left.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        return draw_hodographs(axes, self.curves, FORCE_LABELS, title=f"order {self.order}")

    def to_pandas(self) -> DataFrame:
        """Return one row for each of the four forces: semi-axes and amplitudes.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        own = list(self.curves.values())
        return table(
            {
                "case": (list(self.curves), ""),
                "order": ([self.order] * len(own), "1"),
                "major": ([one.major for one in own], "N"),
                "minor": ([one.minor for one in own], "N"),
                "x": ([one.x for one in own], "N"),
                "y": ([one.y for one in own], "N"),
            }
        )


def hinged_rod_effects(
    engine: EngineLayout,
    speed: float,
    orders: Sequence[int] = (1, 2),
    cylinders: Sequence[int] | None = None,
) -> tuple[HingedRodEffects, ...]:
    """Separate the effects of the hinged rods' kinematics and masses on the inertia forces.

    Parameters
    ----------
    engine : EngineLayout
        With at least one hinged rod.
    speed : float
        Of the shaft [rad/s].
    orders : sequence of int, optional
        Cycles per revolution of the shaft.
    cylinders : sequence of int, optional
        Numbers of the cylinders whose forces are added, such as the two of one throw; all by
        default.

    Returns
    -------
    tuple of HingedRodEffects
        One for each order. Reciprocating masses only, as `moving_masses` gives them.

    Raises
    ------
    InputError
        If none of the cylinders has a hinged rod, there is no such cylinder, an order is not a
        whole number of 1 or more, or the speed is not above zero.

    Notes
    -----
    After Mikhina, Vyalkov 2024, Politekhnicheskiy molodezhnyy zhurnal no. 05 (94).
    """
    positive_number("speed", speed, "rad/s", "the shaft turns")
    wanted = checked_orders(orders)
    count = len(engine.cylinders)
    chosen = range(1, count + 1) if cylinders is None else cylinders
    numbers = [checked_cylinder(engine, number) for number in chosen]
    if all(engine.main_of(number) == number for number in numbers):
        raise InputError(
            f"cylinders: given {numbers}, none of which has a hinged rod; allowed are cylinders with one, "
            "because their effect is calculated."
        )
    beside = _side_by_side(engine)
    own = [masses.reciprocating for masses in moving_masses(engine)]
    of_mains = [own[engine.main_of(number) - 1] for number in range(1, count + 1)]

    def forces(layout: EngineLayout, masses: Sequence[float]) -> list[Hodograph]:
        by_order = reciprocating_forces(layout, masses, speed, wanted)
        return [
            hodograph_sum(order, (by_order[order][number - 1][1] for number in numbers))
            for order in wanted
        ]

    cases = (
        forces(beside, of_mains),
        forces(engine, of_mains),
        forces(beside, own),
        forces(engine, own),
    )
    return tuple(
        HingedRodEffects(order, *each)
        for order, each in zip(wanted, zip(*cases, strict=True), strict=True)
    )


def _side_by_side(engine: EngineLayout) -> EngineLayout:
    """Return the engine with copies of the main rods in place of the hinged ones."""
    mains = [
        engine.cylinders[engine.main_of(number) - 1]
        for number in range(1, len(engine.cylinders) + 1)
    ]
    cylinders = [
        replace(cylinder, rod=main.rod, pin_offset=main.pin_offset, slave_pin=None)
        for cylinder, main in zip(engine.cylinders, mains, strict=True)
    ]
    return replace(engine, cylinders=cylinders)
