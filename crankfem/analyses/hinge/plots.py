"""Single panels of an elastic hinge's diagrams, each drawn on given axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.diagrams import BLUE, COLORS, GRAY, GREEN, ORANGE, legend_inside, write_title
from crankbase.quantity import RPM, format_quantity
from dynamics.hinge.profile import HingeMoment, HingeProfile, SteadyHingeTurn
from dynamics.turning.speed_over_angle import SpeedOverAngle

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DASHES = ("-", "--", ":", "-.")


def draw_gas_force(axes: "Axes", points: Sequence[HingeMoment]) -> None:
    """Draw the gas force on the piston at operating points."""
    _draw_points(axes, [(point, point.gas) for point in points])
    write_title(axes, "Gas force on the piston")
    axes.set_ylabel("force [kN]")
    _turn_axis(axes)
    legend_inside(axes)


def draw_moments(
    axes: "Axes", points: Sequence[HingeMoment], given: Sequence[tuple[FloatArray, float] | None]
) -> None:
    """Draw the hinge moment for constant speed at operating points, and that of the guides.

    Parameters
    ----------
    given : sequence
        For each point the moment of the guides [N m] at a pressure [Pa]; None where the guides are designed
        for the moment.
    """
    _draw_points(axes, [(point, point.moment) for point in points])
    for place, (point, guides) in enumerate(zip(points, given, strict=True)):
        if guides is not None:
            moment, pressure = guides
            axes.plot(
                point.angles_deg,
                moment / 1e3,
                "--",
                color=COLORS[place % len(COLORS)],
                linewidth=1.2,
                label=f"given at {pressure / 1e6:.3g} MPa",
            )
    write_title(axes, "Hinge moment for constant speed")
    axes.set_ylabel("$M_h$ [kN m]")
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    _turn_axis(axes)
    legend_inside(axes)


def _draw_points(axes: "Axes", curves: Sequence[tuple[HingeMoment, FloatArray]]) -> None:
    """Draw values in thousands over a revolution for each operating point, labeled with its speed."""
    for place, (point, values) in enumerate(curves):
        label = format_quantity(point.speed, "rad/s", 5)
        color = COLORS[place % len(COLORS)]
        axes.plot(point.angles_deg, values / 1e3, color=color, label=label)


def draw_guides(
    axes: "Axes", height: float, start: float, compared: Sequence[tuple[float, HingeProfile | str]]
) -> None:
    """Draw the rollers' path for springs of one height from one initial radius [m], by pressure [Pa]."""
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361)) * start
    axes.plot(circle.real, circle.imag, color=GRAY, linewidth=0.8, label="start radius")
    for place, (pressure, guides) in enumerate(compared):
        label = f"{pressure / 1e6:g} MPa"
        color, dash = COLORS[place % len(COLORS)], DASHES[place % len(DASHES)]
        if isinstance(guides, str):
            axes.plot([], [], dash, color=color, label=f"{label}: not feasible")
            continue
        curve = guides.radius * np.exp(1j * np.radians(guides.angles_deg))
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
    axes: "Axes",
    without: SpeedOverAngle,
    wheel: SteadyHingeTurn,
    hinge: SpeedOverAngle,
    *,
    flywheel: float,
    from_speed: float,
) -> None:
    """Draw the speed over a revolution with the hinge, with a flywheel, and without either.

    Parameters
    ----------
    flywheel : float
        Its inertia [kg m^2].
    from_speed : float
        At the top dead center [rad/s].
    """
    for angles, speed, color, dash, label in (
        (np.radians(without.angle_deg), without.speed, ORANGE, "-", "without hinge and flywheel"),
        (
            np.radians(wheel.angles_deg),
            wheel.speed,
            GREEN,
            "--",
            f"flywheel of {flywheel:,.0f} kg m$^2$",
        ),
        (np.radians(hinge.angle_deg), hinge.speed, BLUE, "-", "hinge"),
    ):
        axes.plot(np.degrees(angles), speed * RPM, dash, color=color, label=label)
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
