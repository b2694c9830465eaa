"""Single panels of an elastic hinge's diagrams, each drawn on the axes it is given."""

from typing import TYPE_CHECKING

import numpy as np

from crankfem.record import RPM
from geometry.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE
from geometry.plots.legends import legend_inside, write_title
from geometry.quantity import show_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from crankfem.hinge_run import HingeRun

DASHES = ("-", "--", ":", "-.")


def draw_gas_force(axes: "Axes", run: "HingeRun") -> None:
    """Draw the gas force on the piston at all running points."""
    for place, point in enumerate([run.moment, *(other.point for other in run.others)]):
        label = show_quantity(point.speed, "rad/s", 5)
        color = COLORS[place % len(COLORS)]
        axes.plot(np.degrees(point.angles), point.gas / 1e3, color=color, label=label)
    write_title(axes, "Gas force on the piston")
    axes.set_ylabel("force [kN]")
    _turn_axis(axes)
    legend_inside(axes)


def draw_moments(axes: "Axes", run: "HingeRun") -> None:
    """Draw the hinge moment for constant speed at all running points, and what the guides give."""
    for place, point in enumerate([run.moment, *(other.point for other in run.others)]):
        label = show_quantity(point.speed, "rad/s", 5)
        color = COLORS[place % len(COLORS)]
        axes.plot(np.degrees(point.angles), point.moment / 1e3, color=color, label=label)
    for place, other in enumerate(run.others, start=1):
        given = run.profile.moment_at(other.point.angles, other.best.pressure)
        axes.plot(
            np.degrees(other.point.angles),
            given / 1e3,
            "--",
            color=COLORS[place % len(COLORS)],
            linewidth=1.2,
            label=f"given at {other.best.pressure / 1e6:.3g} MPa",
        )
    write_title(axes, "Hinge moment for constant speed")
    axes.set_ylabel("$M_h$ [kN m]")
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    _turn_axis(axes)
    legend_inside(axes)


def spring_sizes(run: "HingeRun") -> list[tuple[float, float]]:
    """Return height of the spring and start radius of the compared guides, the largest first [m]."""
    return sorted({(spring.height, radius) for spring, radius, _ in run.compared}, reverse=True)


def draw_guides(axes: "Axes", run: "HingeRun", size: tuple[float, float]) -> None:
    """Draw the rollers' path for all compared springs of a size."""
    height, start = size
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361)) * start
    axes.plot(circle.real, circle.imag, color=GRAY, linewidth=0.8, label="start radius")
    made = [
        (spring, guides)
        for spring, radius, guides in run.compared
        if (spring.height, radius) == size
    ]
    for place, (spring, guides) in enumerate(made):
        label = f"{spring.pressure / 1e6:g} MPa"
        color, dash = COLORS[place % len(COLORS)], DASHES[place % len(DASHES)]
        if isinstance(guides, str):
            axes.plot([], [], dash, color=color, label=f"{label}: cannot be made")
            continue
        curve = guides.radius * np.exp(1j * guides.angles)
        closed = np.append(curve, curve[0])
        axes.plot(closed.real, closed.imag, dash, color=color, label=label)
    axes.plot([0.0], [0.0], "+", color=GRAY)
    axes.set_aspect("equal")
    write_title(axes, f"H = {height:g} m, $\\rho_0$ = {start:g} m", mathematics=True)
    axes.set_xlabel("$\\rho\\,\\cos\\,\\varphi$ [m]")
    axes.set_ylabel("$\\rho\\,\\sin\\,\\varphi$ [m]")
    axes.set_ylim(-1.15 * start, 1.6 * start)
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")


def draw_speeds(axes: "Axes", run: "HingeRun") -> None:
    """Draw the speed over a turn with the hinge, with a flywheel, and without either."""
    wheel, hinge = run.flywheel_turn, run.with_hinge
    for angles, speed, color, dash, label in (
        (run.without.angle, run.without.speed, ORANGE, "-", "without hinge and flywheel"),
        (wheel.angles, wheel.speed, GREEN, "--", f"flywheel of {run.flywheel:,.0f} kg m$^2$"),
        (hinge.angle, hinge.speed, BLUE, "-", "hinge"),
    ):
        axes.plot(np.degrees(angles), speed * RPM, dash, color=color, label=label)
    axes.set_ylim(0.0, 1.3 * float(run.without.speed.max()) * RPM)
    axes.set_ylabel("crank speed [1/min]")
    write_title(
        axes, f"Speed over a turn from {show_quantity(run.point.speed, 'rad/s', 5)} at the top"
    )
    _turn_axis(axes)
    axes.legend(frameon=False, fontsize=9, loc="upper right")


def draw_fluctuations(axes: "Axes", run: "HingeRun") -> None:
    """Draw how far the speed is above its mean with the hinge and with a flywheel."""
    wheel, hinge = run.flywheel_turn, run.with_hinge
    for angles, speed, mean, color, dash, name in (
        (wheel.angles, wheel.speed, wheel.mean_speed, GREEN, "--", "flywheel"),
        (hinge.angle, hinge.speed, hinge.mean_speed, BLUE, "-", "hinge"),
    ):
        share = 100.0 * (speed / mean - 1.0)
        label = f"{name}, fluctuation {float(np.ptp(speed)) / mean:.2g}"
        axes.plot(np.degrees(angles), share, dash, color=color, label=label)
    highest = 100.0 * (float(wheel.speed.max()) / wheel.mean_speed - 1.0)
    axes.set_ylim(top=1.6 * highest)
    axes.set_ylabel("speed above its mean [%]")
    write_title(axes, "With hinge or flywheel")
    _turn_axis(axes)
    axes.legend(frameon=False, fontsize=9, loc="upper right")


def _turn_axis(axes: "Axes") -> None:
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(np.arange(0.0, 361.0, 60.0))
    axes.set_xlabel("crank angle from the top [deg]")
