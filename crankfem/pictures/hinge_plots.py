"""Diagrams of an elastic hinge: its moment, its guides, and the speed over a turn."""

from pathlib import Path
from typing import Any

import numpy as np

from crankfem.hinge_run import HingeRun
from crankfem.record import RPM
from geometry.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE, figure, make_folder
from geometry.quantity import show_quantity

DASHES = ("-", "--", ":", "-.")


def plot_hinge(folder: Path, run: HingeRun) -> list[Path]:
    """Write all diagrams into a folder, which is made if it is not there.

    Parameters
    ----------
    folder : Path
    run : HingeRun

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    make_folder(folder)
    made = [folder / "hinge_moment.svg", folder / "hinge_speed.svg"]
    plot_moments(made[0], run)
    plot_speeds(made[1], run)
    if run.compared:
        made.append(folder / "hinge_guides.svg")
        plot_guides(made[-1], run)
    return made


def plot_moments(path: Path, run: HingeRun) -> None:
    """Plot gas force and hinge moment of all running points, and the moments of the same guides."""
    points = [run.moment, *(other.point for other in run.others)]
    with figure(path, columns=2, width=9.6, height=4.4) as (left, right):
        for place, point in enumerate(points):
            label = show_quantity(point.speed, "rad/s", 5)
            degrees = np.degrees(point.angles)
            left.plot(degrees, point.gas / 1e3, color=COLORS[place % len(COLORS)], label=label)
            right.plot(degrees, point.moment / 1e3, color=COLORS[place % len(COLORS)], label=label)
        for place, other in enumerate(run.others, start=1):
            given = run.profile.moment_at(other.point.angles, other.best.pressure)
            right.plot(
                np.degrees(other.point.angles),
                given / 1e3,
                "--",
                color=COLORS[place % len(COLORS)],
                linewidth=1.2,
                label=f"given at {other.best.pressure / 1e6:.3g} MPa",
            )
        left.set_title("Gas force on the piston")
        left.set_ylabel("force [kN]")
        right.set_title("Hinge moment for constant speed")
        right.set_ylabel("$M_h$ [kN m]")
        right.axhline(0.0, color=GRAY, linewidth=0.8)
        for axes in (left, right):
            _turn_axis(axes)
            axes.legend(fontsize=8)


def plot_guides(path: Path, run: HingeRun) -> None:
    """Plot the rollers' path for all compared springs, one panel for each size."""
    sizes = sorted({(spring.height, radius) for spring, radius, _ in run.compared}, reverse=True)
    with figure(path, columns=len(sizes), width=4.6 * len(sizes), height=4.9) as found:
        for panel, (height, start) in zip(np.atleast_1d(found), sizes, strict=True):
            circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361)) * start
            panel.plot(circle.real, circle.imag, color=GRAY, linewidth=0.8, label="start radius")
            made = [
                (spring, guides)
                for spring, radius, guides in run.compared
                if (spring.height, radius) == (height, start)
            ]
            for place, (spring, guides) in enumerate(made):
                label = f"{spring.pressure / 1e6:g} MPa"
                color, dash = COLORS[place % len(COLORS)], DASHES[place % len(DASHES)]
                if isinstance(guides, str):
                    panel.plot([], [], dash, color=color, label=f"{label}: cannot be made")
                    continue
                curve = guides.radius * np.exp(1j * guides.angles)
                closed = np.append(curve, curve[0])
                panel.plot(closed.real, closed.imag, dash, color=color, label=label)
            panel.plot([0.0], [0.0], "+", color=GRAY)
            panel.set_aspect("equal")
            panel.set_title(f"H = {height:g} m, $\\rho_0$ = {start:g} m")
            panel.set_xlabel("$\\rho\\,\\cos\\,\\varphi$ [m]")
            panel.set_ylabel("$\\rho\\,\\sin\\,\\varphi$ [m]")
            panel.set_ylim(-1.15 * start, 1.6 * start)
            panel.legend(fontsize=8, ncols=2, loc="upper center")


def plot_speeds(path: Path, run: HingeRun) -> None:
    """Plot the speed over a turn: with and without the hinge, and what hinge and flywheel leave."""
    wheel, hinge = run.flywheel_turn, run.with_hinge
    with figure(path, columns=2, width=9.6) as (left, right):
        for angles, speed, color, dash, label in (
            (run.without.angle, run.without.speed, ORANGE, "-", "without hinge and flywheel"),
            (wheel.angles, wheel.speed, GREEN, "--", f"flywheel of {run.flywheel:,.0f} kg m$^2$"),
            (hinge.angle, hinge.speed, BLUE, "-", "hinge"),
        ):
            left.plot(np.degrees(angles), speed * RPM, dash, color=color, label=label)
        left.set_ylim(0.0, 1.3 * float(run.without.speed.max()) * RPM)
        left.set_ylabel("crank speed [1/min]")
        left.set_title(
            f"Speed over a turn from {show_quantity(run.point.speed, 'rad/s', 5)} at the top"
        )
        for angles, speed, mean, color, dash, label in (
            (wheel.angles, wheel.speed, wheel.mean_speed, GREEN, "--", "flywheel"),
            (hinge.angle, hinge.speed, hinge.mean_speed, BLUE, "-", "hinge"),
        ):
            share = 100.0 * (speed / mean - 1.0)
            fluctuation = float(np.ptp(speed)) / mean
            label = f"{label}, fluctuation {fluctuation:.2g}"
            right.plot(np.degrees(angles), share, dash, color=color, label=label)
        highest = 100.0 * (float(wheel.speed.max()) / wheel.mean_speed - 1.0)
        right.set_ylim(top=1.6 * highest)
        right.set_ylabel("speed above its mean [%]")
        right.set_title("With hinge or flywheel")
        for axes in (left, right):
            _turn_axis(axes)
            axes.legend(fontsize=9, loc="upper right")


def _turn_axis(axes: Any) -> None:
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(np.arange(0.0, 361.0, 60.0))
    axes.set_xlabel("crank angle from the top [deg]")
