"""Pictures of balance: hodographs of forces and moments, and the pistons' accelerations by order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.drawing.diagram_style import COLORS, figure
from crankbase.errors import InputError
from crankfem.analyses.titles import add_title
from dynamics.balance.balance import Balance, unbalanced
from dynamics.balance.hinged_rods import hinged_rod_effects
from dynamics.balance.hodograph import Hodograph
from dynamics.engine.layout import EngineLayout
from dynamics.engine.orders import acceleration_orders, checked_cylinder, piston_acceleration
from dynamics.plots.hodographs import (
    DASHES,
    FORCE_LABELS,
    MOMENT_LABELS,
    POINTS,
    draw_hodographs,
)


@dataclass(frozen=True)
class HodographPanel:
    """One diagram of hodographs.

    Parameters
    ----------
    title : str
    across, up : str
        Labels of its axes.
    curves : mapping of str to Hodograph
        By name [N or N m]; none leaves the panel empty, with `empty` in the middle.
    engine : EngineLayout, optional
        Whose cylinder axes are drawn as thin lines.
    empty : str, optional
    """

    title: str
    across: str
    up: str
    curves: Mapping[str, Hodograph]
    engine: EngineLayout | None = None
    empty: str = "balanced"


def plot_hodographs(path: Path, panels: Sequence[HodographPanel], title: str = "") -> None:
    """Plot hodographs as SVG, seen from the free end: y up, x to the left, the shaft clockwise.

    Parameters
    ----------
    path : Path
    panels : sequence of HodographPanel
        Side by side, each to its own scale.
    title : str, optional
        Above all of them.

    Raises
    ------
    InputError
        If there is no panel.

    Notes
    -----
    A dot marks each vector at shaft angle zero, an arrowhead the way that it goes.
    """
    if not panels:
        raise InputError(
            "panels: given none; allowed are one or more, because a picture shows some."
        )
    with figure(path, len(panels), width=4.6 * len(panels), height=5.6) as made:
        for axes, panel in zip(np.atleast_1d(made), panels, strict=True):
            _draw_panel(axes, panel)
        add_title(made, title)


def _draw_panel(axes: Any, panel: HodographPanel) -> None:
    cylinders = () if panel.engine is None else panel.engine.cylinders
    banks = [cylinder.bank_angle for cylinder in cylinders]
    labels = (panel.across, panel.up)
    draw_hodographs(axes, panel.curves, labels, banks=banks, empty=panel.empty)
    axes.set_title(panel.title)


def plot_balance(path: Path, found: Balance, *, title: str = "") -> None:
    """Plot the forces and moments that are left over, a curve for each order that is not balanced.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    found : Balance
    title : str, optional
        Above both panels.
    """
    forces, moments = unbalanced(found, "force"), unbalanced(found, "moment")
    empty = "balanced: orders " + ", ".join(str(row.order) for row in found.rows)
    about = f"its moment about z = {found.about:.4g} m"
    plot_hodographs(
        path,
        [
            HodographPanel("inertia force", *FORCE_LABELS, forces, found.engine, empty),
            HodographPanel(about, *MOMENT_LABELS, moments, empty=empty),
        ],
        title,
    )


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
    panels = []
    for effect in effects:
        panels.append(HodographPanel(f"order {effect.order}", *FORCE_LABELS, effect.curves, engine))
    plot_hodographs(path, panels, title)


def plot_accelerations(
    path: Path,
    engine: EngineLayout,
    speed: float,
    cylinders: Mapping[int, str],
    orders: Sequence[int] = (1, 2),
    *,
    title: str = "",
) -> None:
    """Plot pistons' accelerations over the crank angle, whole, by order, and what is left.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    engine : EngineLayout
    speed : float
        Of the shaft [rad/s].
    cylinders : mapping of int to str
        Numbers of the cylinders, each with a name for the legend.
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
    titles = ["whole", *(f"order {order}" for order in orders), "the other orders"]
    with figure(path, len(titles), width=3.3 * len(titles), height=3.6) as axes:
        for number, (cylinder, name) in enumerate(cylinders.items()):
            checked_cylinder(engine, cylinder)
            whole = piston_acceleration(engine, cylinder, angles, speed)
            found = acceleration_orders(engine, cylinder, speed, max(orders))
            parts = []
            for order in orders:
                place = found.index_of(order)
                parts.append(
                    found.cosine[place] * np.cos(order * angles)
                    + found.sine[place] * np.sin(order * angles)
                )
            for panel, curve in zip(axes, (whole, *parts, whole - sum(parts)), strict=True):
                panel.plot(
                    np.degrees(angles),
                    curve,
                    color=COLORS[number % len(COLORS)],
                    linestyle=DASHES[number % len(DASHES)],
                    label=name,
                )
        for panel, name in zip(axes, titles, strict=True):
            panel.set_title(name)
            panel.set_xlim(0.0, 360.0)
            panel.set_xticks(range(0, 361, 90))
            panel.set_xlabel("crank angle from own top [deg]")
        axes[0].set_ylabel("acceleration towards the shaft [m/s$^2$]")
        axes[0].legend(fontsize=8)
        add_title(axes, title)
