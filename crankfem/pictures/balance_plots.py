"""Pictures of balance: hodographs of forces and moments, and the pistons' accelerations by order."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crankfem.pictures.titles import add_title
from dynamics.balance.balance import Balance
from dynamics.balance.hinged_rods import hinged_rod_effects
from dynamics.balance.hodograph import Hodograph
from dynamics.engine.layout import EngineLayout
from dynamics.engine.orders import acceleration_orders, checked_cylinder, piston_acceleration
from geometry.diagram_style import COLORS, GRAY, figure
from geometry.errors import InputError

KILO = 1e-3
DASHES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1.2)), (0, (6, 2, 1, 2, 1, 2)))
AXIS_LINE: Any = (0, (8, 3, 1, 3))
FORCE_LABELS = ("force to the right, $-F_x$ [kN]", "force upwards, $F_y$ [kN]")
MOMENT_LABELS = ("moment about $-x$ [kN m]", "moment about $y$ [kN m]")
MARGIN = 1.12
POINTS = 361


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
    reach = (
        MARGIN * KILO * max((curve.major for curve in panel.curves.values()), default=0.0) or 1.0
    )
    if panel.engine is not None and panel.curves:
        for angle in sorted({cylinder.bank_angle for cylinder in panel.engine.cylinders}):
            across, up = math.sin(angle), math.cos(angle)
            ends = np.array([-1.0, 1.0]) * reach / max(abs(across), abs(up))
            axes.plot(ends * across, ends * up, color=GRAY, linewidth=0.7, linestyle=AXIS_LINE)
    for number, (name, curve) in enumerate(panel.curves.items()):
        color = COLORS[number % len(COLORS)]
        left, upwards = (KILO * part for part in curve.points(POINTS))
        axes.plot(-left, upwards, color=color, linestyle=DASHES[number % len(DASHES)], label=name)
        axes.plot(-left[0], upwards[0], "o", color=color, markersize=4)
        _draw_arrow(axes, -left, upwards, color)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_title(panel.title)
    axes.set_xlabel(panel.across)
    axes.set_ylabel(panel.up)
    if panel.curves:
        axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    else:
        axes.text(0.5, 0.5, panel.empty, transform=axes.transAxes, ha="center", va="center")
        axes.set_xticks([])
        axes.set_yticks([])


def _draw_arrow(panel: Any, across: Any, up: Any, color: str) -> None:
    """Draw an arrowhead an eighth of the way along the curve, unless it is a point."""
    place = POINTS // 8
    tail, head = (across[place], up[place]), (across[place + 3], up[place + 3])
    if math.dist(tail, head) > 0.0:
        panel.annotate(
            "", head, tail, arrowprops={"arrowstyle": "-|>", "color": color, "mutation_scale": 11}
        )


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
    forces = {f"order {row.order}": row.force for row in found.rows if not row.force_balanced}
    moments = {f"order {row.order}": row.moment for row in found.rows if not row.moment_balanced}
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
        curves = {
            "rods side by side": effect.side_by_side,
            "movement alone": effect.kinematics,
            "masses alone": effect.masses,
            "hinged rods": effect.hinged,
        }
        panels.append(HodographPanel(f"order {effect.order}", *FORCE_LABELS, curves, engine))
    plot_hodographs(path, panels, title)


def plot_accelerations(
    path: Path,
    engine: EngineLayout,
    speed: float,
    cylinders: Mapping[int, str],
    orders: Sequence[int] = (1, 2),
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
        for panel, title in zip(axes, titles, strict=True):
            panel.set_title(title)
            panel.set_xlim(0.0, 360.0)
            panel.set_xticks(range(0, 361, 90))
            panel.set_xlabel("crank angle from own top [deg]")
        axes[0].set_ylabel("acceleration towards the shaft [m/s$^2$]")
        axes[0].legend(fontsize=8)
