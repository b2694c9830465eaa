"""Pictures of balance: hodographs of forces and moments, and the pistons' accelerations by order."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import COLORS, figure
from crankbase.drawing.legends import write_title
from crankfem.analyses.titles import add_title
from dynamics.balance.balance import Balance, hinged_rod_effects
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import (
    acceleration_orders,
    checked_cylinder,
    order_part,
    piston_acceleration,
)
from dynamics.plots.load_diagrams import DASHES, FORCE_LABELS, POINTS, draw_hodographs

MOST_IN_A_ROW = 4


def plot_balance(path: Path, found: Balance, *, title: str = "") -> None:
    """Plot the residual forces and moments, a curve for each order that is not balanced.

    If all forces are balanced, or all moments, they have no panel.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    found : Balance
    title : str, optional
        Above both panels.
    """
    shown: list[Literal["force", "moment"]] = []
    if not all(row.force_balanced for row in found.rows):
        shown.append("force")
    if not all(row.moment_balanced for row in found.rows) or not shown:
        shown.append("moment")
    with figure(path, len(shown), width=4.6 * len(shown), height=5.6) as panels:
        for axes, what in zip(np.atleast_1d(panels), shown, strict=True):
            found.plot(axes, show=what)
        add_title(panels, title)


def plot_hinged_rods(
    path: Path,
    engine: EngineLayout,
    speed: float,
    orders: Sequence[int] = (1, 2),
    cylinders: Sequence[int] | None = None,
    *,
    title: str = "",
) -> None:
    """Plot the inertia forces of a V engine with hinged rods against rods side by side.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    engine, speed, orders, cylinders
        As in `hinged_rod_effects`.
    title : str, optional
        Above all panels.

    Raises
    ------
    InputError
        As `hinged_rod_effects`.
    """
    effects = hinged_rod_effects(engine, speed, orders, cylinders)
    banks = [math.radians(cylinder.bank_angle_deg) for cylinder in engine.cylinders]
    with figure(path, len(effects), width=4.6 * len(effects), height=5.6) as panels:
        for axes, effect in zip(np.atleast_1d(panels), effects, strict=True):
            draw_hodographs(axes, effect.curves, FORCE_LABELS, banks=banks)
            axes.set_title(f"order {effect.order}")
        add_title(panels, title)


def plot_accelerations(
    path: Path,
    engine: EngineLayout,
    speed: float,
    cylinders: Mapping[int, str],
    orders: Sequence[int] = (1, 2),
    *,
    title: str = "",
) -> None:
    """Plot pistons' accelerations over the crank angle: total, by order, remainder, differences.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    engine : EngineLayout
    speed : float
        Of the shaft [rad/s].
    cylinders : mapping of int to str
        Numbers of the cylinders, each with a name for the legend. The first is the one whose
        difference from the others is drawn.
    orders : sequence of int, optional
        Orders that get a panel of their own.
    title : str, optional
        Above all panels.

    Raises
    ------
    InputError
        If there is no such cylinder, or an order is not a whole number of 1 or more.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, POINTS)
    panels: dict[str, dict[str, FloatArray]] = {}
    wholes: list[FloatArray] = []
    for cylinder, name in cylinders.items():
        checked_cylinder(engine, cylinder)
        wholes.append(piston_acceleration(engine, cylinder, speed, angles_deg=np.degrees(angles)))
        found = acceleration_orders(engine, cylinder, speed, max(orders))
        parts = {f"order {order}": order_part(found, order, angles) for order in orders}
        left = wholes[-1] - sum(parts.values())
        for panel, curve in {"whole": wholes[-1], **parts, "the other orders": left}.items():
            panels.setdefault(panel, {})[name] = curve
    first, *others = cylinders.values()
    if others:
        panels[f"{first} less {others[0] if len(others) == 1 else 'the others'}"] = {
            name: wholes[0] - whole for name, whole in zip(others, wholes[1:], strict=True)
        }
    looks = {
        name: {"color": COLORS[number % len(COLORS)], "linestyle": DASHES[number % len(DASHES)]}
        for number, name in enumerate(cylinders.values())
    }
    columns = len(panels) if len(panels) <= MOST_IN_A_ROW else math.ceil(len(panels) / 2)
    rows = math.ceil(len(panels) / columns)
    with figure(path, columns, 3.3 * columns, 3.6 * rows, rows=rows) as axes:
        for cell in axes.flat[len(panels) :]:
            cell.remove()
        for cell, (panel, curves) in zip(axes.flat, panels.items(), strict=False):
            for name, curve in curves.items():
                cell.plot(np.degrees(angles), curve, label=name, **looks[name])
            write_title(cell, panel)
            cell.set_xlim(0.0, 360.0)
            cell.set_xticks(range(0, 361, 90))
            cell.set_xlabel("crank angle from own top [deg]")
        axes.flat[0].legend(fontsize=8)
        for cell in axes[:, 0]:
            cell.set_ylabel("acceleration towards the shaft [m/s$^2$]")
        add_title(axes.flat, title)
