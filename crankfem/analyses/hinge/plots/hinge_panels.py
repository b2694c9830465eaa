"""Single panels of an elastic hinge's diagrams, each drawn on the axes it is given."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.units.quantity import format_quantity
from crankbase.units.units import RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DASHES = ("-", "--", ":", "-.")


@dataclass(frozen=True, eq=False)
class RunningPoint:
    """Forces over a turn at one running point.

    Attributes
    ----------
    speed : float
        [rad/s]
    angles : (m,) array
        From the top dead center [rad].
    gas : (m,) array
        On the piston [N].
    moment : (m,) array
        Of the hinge, for constant speed [N m].
    given : (m,) array or None
        What the guides give at a pressure; None where the moment is what they are made for.
    pressure : float
        [Pa]
    """

    speed: float
    angles: FloatArray
    gas: FloatArray
    moment: FloatArray
    given: FloatArray | None = None
    pressure: float = 0.0

    @property
    def label(self) -> str:
        """Its speed, as a legend says it."""
        return format_quantity(self.speed, "rad/s", 5)


@dataclass(frozen=True, eq=False)
class Turn:
    """Speed over a turn of the crank.

    Attributes
    ----------
    angles : (m,) array
        From the top dead center [rad].
    speed : (m,) array
        [rad/s]
    mean : float
        [rad/s]
    """

    angles: FloatArray
    speed: FloatArray
    mean: float


@dataclass(frozen=True, eq=False)
class RollerPath:
    """Path of the rollers for one spring.

    Attributes
    ----------
    pressure : float
        Of the spring [Pa].
    angles, radius : (m,) array or None
        [rad] and [m]; None where guides cannot be made.
    """

    pressure: float
    angles: FloatArray | None = None
    radius: FloatArray | None = None


def draw_gas_force(axes: "Axes", points: Sequence[RunningPoint]) -> None:
    """Draw the gas force on the piston at running points."""
    for place, point in enumerate(points):
        color = COLORS[place % len(COLORS)]
        axes.plot(np.degrees(point.angles), point.gas / 1e3, color=color, label=point.label)
    write_title(axes, "Gas force on the piston")
    axes.set_ylabel("force [kN]")
    _turn_axis(axes)
    legend_inside(axes)


def draw_moments(axes: "Axes", points: Sequence[RunningPoint]) -> None:
    """Draw the hinge moment for constant speed at running points, and what the guides give."""
    for place, point in enumerate(points):
        color = COLORS[place % len(COLORS)]
        axes.plot(np.degrees(point.angles), point.moment / 1e3, color=color, label=point.label)
    for place, point in enumerate(points):
        if point.given is None:
            continue
        axes.plot(
            np.degrees(point.angles),
            point.given / 1e3,
            "--",
            color=COLORS[place % len(COLORS)],
            linewidth=1.2,
            label=f"given at {point.pressure / 1e6:.3g} MPa",
        )
    write_title(axes, "Hinge moment for constant speed")
    axes.set_ylabel("$M_h$ [kN m]")
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    _turn_axis(axes)
    legend_inside(axes)


def draw_guides(axes: "Axes", height: float, start: float, paths: Sequence[RollerPath]) -> None:
    """Draw the rollers' path for springs of one height from one start radius [m]."""
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361)) * start
    axes.plot(circle.real, circle.imag, color=GRAY, linewidth=0.8, label="start radius")
    for place, path in enumerate(paths):
        label = f"{path.pressure / 1e6:g} MPa"
        color, dash = COLORS[place % len(COLORS)], DASHES[place % len(DASHES)]
        if path.angles is None or path.radius is None:
            axes.plot([], [], dash, color=color, label=f"{label}: cannot be made")
            continue
        curve = path.radius * np.exp(1j * path.angles)
        closed = np.append(curve, curve[0])
        axes.plot(closed.real, closed.imag, dash, color=color, label=label)
    axes.plot([0.0], [0.0], "+", color=GRAY)
    axes.set_aspect("equal")
    write_title(axes, f"H = {height:g} m, $\\rho_0$ = {start:g} m", mathematics=True)
    axes.set_xlabel("$\\rho\\,\\cos\\,\\varphi$ [m]")
    axes.set_ylabel("$\\rho\\,\\sin\\,\\varphi$ [m]")
    axes.set_ylim(-1.15 * start, 1.6 * start)
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")


def draw_speeds(
    axes: "Axes", without: Turn, wheel: Turn, hinge: Turn, *, flywheel: float, from_speed: float
) -> None:
    """Draw the speed over a turn with the hinge, with a flywheel, and without either.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    without, wheel, hinge : Turn
    flywheel : float
        Its inertia [kg m^2].
    from_speed : float
        At the top dead center [rad/s].
    """
    for turn, color, dash, label in (
        (without, ORANGE, "-", "without hinge and flywheel"),
        (wheel, GREEN, "--", f"flywheel of {flywheel:,.0f} kg m$^2$"),
        (hinge, BLUE, "-", "hinge"),
    ):
        axes.plot(np.degrees(turn.angles), turn.speed * RPM, dash, color=color, label=label)
    axes.set_ylim(0.0, 1.3 * float(without.speed.max()) * RPM)
    axes.set_ylabel("crank speed [1/min]")
    write_title(
        axes, f"Speed over a turn from {format_quantity(from_speed, 'rad/s', 5)} at the top"
    )
    _turn_axis(axes)
    axes.legend(frameon=False, fontsize=9, loc="upper right")


def _turn_axis(axes: "Axes") -> None:
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(np.arange(0.0, 361.0, 60.0))
    axes.set_xlabel("crank angle from the top [deg]")
