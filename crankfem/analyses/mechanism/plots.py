"""Diagrams of a crank mechanism: balance, loads, torque, and rod models compared."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.diagrams import (
    COLORS,
    GRAY,
    GREEN,
    RED,
    figure,
    legend_below,
    plain_text,
    write_title,
)
from crankbase.errors import InputError
from crankfem.analyses.mechanism.hinged_rods import motion_columns
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.mechanism.rod_models import ModelDifference
from crankfem.analyses.titles import add_title
from dynamics.balance import Balance, hinged_rod_effects
from dynamics.engine.forces import (
    LoadDiagram,
    acceleration_orders,
    checked_cylinder,
    order_part,
    piston_acceleration,
)
from dynamics.engine.layout import EngineLayout
from dynamics.harmonics import Harmonics, TorqueTable
from dynamics.plots.curves import KILO, draw_over_angle
from dynamics.plots.harmonics import (
    KIND_COLORS,
    STAR_STEP,
    draw_harmonics,
    draw_one_harmonic,
    draw_samples,
    draw_single_harmonics,
    draw_star,
    finish_stars,
)
from dynamics.plots.load_diagrams import (
    DASHES,
    FORCE_LABELS,
    POINTS,
    Frame,
    check_polar,
    draw_hodographs,
    draw_polar_loads,
)
from dynamics.torque import EngineTorque, Star, same_stars, star_diagram

MOST_IN_A_ROW = 4


def plot_balance(path: Path, balance: Balance, *, title: str = "") -> None:
    """Plot the residual forces and moments, a curve for each order that is not balanced.

    If all forces are balanced, or all moments, they have no panel.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    title : str, optional
        Above both panels.
    """
    shown: list[Literal["force", "moment"]] = []
    if not all(row.force_balanced for row in balance.rows):
        shown.append("force")
    if not all(row.moment_balanced for row in balance.rows) or not shown:
        shown.append("moment")
    with figure(path, len(shown), width=4.6 * len(shown), height=5.6) as panels:
        for axes, what in zip(np.atleast_1d(panels), shown, strict=True):
            balance.plot(axes, show=what)
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
    speed : float
        Of the shaft [rad/s].
    cylinders : mapping of int to str
        Numbers of the cylinders, each with a name for the legend. The first is the one whose
        difference from the others is drawn.
    orders : sequence of int, optional
        Orders that get a panel of their own.

    Raises
    ------
    InputError
        If there is no such cylinder, or an order is not a whole number of 1 or more.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, POINTS)
    panels: dict[str, dict[str, Array]] = {}
    wholes: list[Array] = []
    for cylinder, name in cylinders.items():
        checked_cylinder(engine, cylinder)
        wholes.append(piston_acceleration(engine, cylinder, speed, angles_deg=np.degrees(angles)))
        harmonics = acceleration_orders(engine, cylinder, speed, max(orders))
        parts = {f"order {order}": order_part(harmonics, order, angles) for order in orders}
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


def plot_polar_loads(
    path: Path,
    diagrams: Sequence[LoadDiagram],
    *,
    labels: Sequence[str] | None = None,
    frame: Frame = "crank",
    mark_step_deg: float = 30.0,
    title: str = "",
) -> None:
    """Plot the locus of a bearing's force vector, one curve for each diagram, as SVG.

    Parameters
    ----------
    diagrams : sequence of LoadDiagram
        Of one bearing with several models or at several operating points, to compare.
    labels : sequence of str, optional
        For the legend; by default the diagrams' names.
    frame : str, optional
        "crank": turning with the crank, which is upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": fixed, y up, seen from the free end, where the
        shaft turns clockwise and x points to the left.
    mark_step_deg : float, optional
        Interval of the dots on the first curve in shaft angle [deg], labeled with the angle where there
        is room.

    Raises
    ------
    InputError
        If there is no diagram, or labels, frame or step do not fit.
    """
    if not diagrams:
        raise InputError(
            "diagrams: given none; allowed are one or more, because a picture shows something."
        )
    names = [diagram.name for diagram in diagrams] if labels is None else list(labels)
    if len(names) != len(diagrams):
        raise InputError(
            f"labels: given {len(names)} for {len(diagrams)} diagrams; allowed is one for each, because "
            "every curve has its name."
        )
    loads = list(zip(names, diagrams, strict=True))
    check_polar(frame, mark_step_deg)
    with figure(path, width=6.4, height=6.4) as axes:
        draw_polar_loads(axes, loads, frame, mark_step_deg)
        if title:
            axes.set_title(plain_text(title))


def plot_model_difference(path: Path, difference: ModelDifference, *, title: str = "") -> None:
    """Plot the crankpin load by two rod models, and their difference over the shaft angle."""
    per_piston = 1e-6 / (KILO * difference.piston_area)  # MPa for each kN
    with figure(path, 3, width=17.4, height=6.4) as (polar, shares, forces):
        loads = list(zip(difference.models, (difference.first, difference.second), strict=True))
        draw_polar_loads(polar, loads, "crank", 30.0)
        scale = (lambda force: force * per_piston, lambda pressure: pressure / per_piston)
        for side, axis in (("top", "xaxis"), ("right", "yaxis")):
            second = getattr(polar, f"secondary_{axis}")(side, functions=scale)
            second.set(**{f"{axis[0]}label": "force over piston area [MPa]"})
        degrees = difference.first.angles_deg
        for values, color, name in (
            (difference.of_same_angle, RED, "of the size at the same angle"),
            (difference.of_mean, GREEN, "of the mean size"),
        ):
            shares.plot(degrees, 100.0 * values, color=color, linewidth=1.3, label=name)
        shares.axhline(0.0, color=GRAY, linewidth=0.8)
        shares.set_xlim(degrees[0], 2.0 * degrees[-1] - degrees[-2])
        shares.set_xticks(np.arange(0.0, degrees[-1] + 90.0, 90.0))
        shares.set_xlabel("shaft angle [deg]")
        shares.set_ylabel(f"force, {difference.models[1]} less {difference.models[0]} [%]")
        legend_below(shares, 2)
        changes = {name: KILO * change for name, change in difference.force_changes.items()}
        label = f"{difference.models[1]} less {difference.models[0]} [kN]"
        draw_over_angle(forces, np.radians(degrees), changes, f"force, {label}")
        forces.axhline(0.0, color=GRAY, linewidth=0.8)
        add_title((polar, shares, forces), title)


ENGINE_FILES = ("piston_motion.svg", "crankpins.svg")


def plot_engine(folder: Path, run: MechanismRun, *, title: str = "") -> list[Path]:
    """Write the pictures `ENGINE_FILES`: motion of the first piston and rod, loads of all crankpins."""
    motion, crankpins = (folder / name for name in ENGINE_FILES)
    angles = np.linspace(0.0, 2.0 * np.pi, POINTS)
    columns = motion_columns(run.layout, run.speed, (1,), angles)
    names = {
        "rod_center_acceleration_m_s2": "rod's center of mass, towards the shaft",
        "rod_center_acceleration_across_m_s2": "the same, across",
        "acceleration_m_s2": "piston, towards the shaft",
    }
    with figure(motion, 2, width=11.8, height=4.4) as (left, right):
        travel = {"piston": 1e3 * columns["cylinder_1_piston_travel_m"]}
        draw_over_angle(left, angles, travel, "piston travel from its top [mm]", cyclic=False)
        curves = {name: columns[f"cylinder_1_{column}"] for column, name in names.items()}
        draw_over_angle(right, angles, curves, "acceleration [m/s$^2$]", cyclic=False)
        add_title((left, right), f"cylinder 1, {title}")
    width = min(len(run.crankpins), MOST_IN_A_ROW)
    rows = math.ceil(len(run.crankpins) / width)
    with figure(crankpins, width, 4.6 * width, 4.8 * rows, rows=rows) as axes:
        for panel in axes.flat[len(run.crankpins) :]:
            panel.remove()
        for panel, load in zip(axes.flat, run.crankpins, strict=False):
            draw_polar_loads(panel, [(load.name, load)], "crank", 60.0)
            write_title(panel, load.name)
        add_title(axes.flat, title)
    return [motion, crankpins]


STARS_A_ROW = 4
PANELS_A_ROW, MOST_PANELS = 3, 24
# Smaller amplitudes, as shares of the largest or of the mean torque, are round-off of a sum that is zero.
CANCELLED = 1e-9
FILES = ("torque.svg", "harmonics.svg", "stars.svg", "single_harmonics.svg")


def picture_torque(
    folder: Path, torque: EngineTorque, highest_order: float, *, title: str = ""
) -> list[Path]:
    """Write the pictures `FILES` into a folder, up to a highest order, and return their paths."""
    stars = star_diagram(torque.engine, highest_order)
    paths = [folder / name for name in FILES]
    plot_engine_torque(paths[0], torque, title=title)
    plot_amplitudes(paths[1], torque.harmonics(), stars, title=title)
    plot_stars(paths[2], stars, title=title)
    plot_single_harmonics(paths[3], torque.harmonics().up_to(highest_order), title=title)
    return paths


def plot_engine_torque(path: Path, torque: EngineTorque, *, title: str = "") -> None:
    """Plot the torque of the whole engine and of one throw, separated by cause, over the cycle."""
    with figure(path, 2, width=9.6, height=3.6) as (left, right):
        torque.plot(left)
        torque.plot(right, throw=1)
        add_title((left, right), title)


def plot_amplitudes(
    path: Path, harmonics: Harmonics, stars: Sequence[Star], *, title: str = ""
) -> None:
    """Plot the amplitudes of the engine's torque by order, colored by the star of the order."""
    amplitude = np.where(_uncancelled(harmonics), harmonics.amplitude, 0.0)
    with figure(path, width=7.2, height=3.6) as axes:
        for kind, color in KIND_COLORS.items():
            orders = [star.order for star in stars if star.kind == kind]
            heights = [amplitude[harmonics.index_of(order)] / 1000.0 for order in orders]
            if orders:
                axes.bar(orders, heights, width=0.6 * harmonics.orders[0], color=color, label=kind)
        axes.set_xlabel("harmonic order [cycles per revolution]")
        axes.set_ylabel(r"amplitude $M_k$ [kN m]")
        axes.set_title("Harmonics of the engine's torque")
        axes.set_ylim(bottom=0.0)
        axes.legend(fontsize=8, title="star of the order", title_fontsize=8)
        add_title(axes, title)


def plot_stars(path: Path, stars: Sequence[Star], *, title: str = "") -> None:
    """Draw the star of each group of orders of equal shape, with its resultant."""
    groups = same_stars(stars)
    columns = min(STARS_A_ROW, len(groups))
    rows = math.ceil(len(groups) / columns)
    with figure(path, width=2.3 * columns, height=2.6 * rows + 0.2) as axes:
        for place, group in enumerate(groups):
            row, column = divmod(place, columns)
            orders = ", ".join(f"{star.order:g}" for star in group)
            words = f"{'orders' if len(group) > 1 else 'order'} {orders}"
            draw_star(axes, group[0], words, (STAR_STEP * column, -1.15 * STAR_STEP * row))
        finish_stars(axes, rows, columns)
        add_title(axes, f"Stars of the orders, all cylinders alike\n{title}".strip())


def picture_torque_table(
    folder: Path, table: TorqueTable, shown: Harmonics, stars: Sequence[Star] = ()
) -> list[Path]:
    """Write torque.svg, harmonics.svg, single_harmonics.svg and, with stars, stars.svg into a folder.

    Parameters
    ----------
    shown : Harmonics
        Those of the table, up to the highest order to be drawn.
    stars : sequence of Star, optional
        Of the cylinders that have this torque.
    """
    paths = [folder / name for name in table_files(stars)]
    plot_torque(paths[0], table.torque, shown)
    with figure(paths[1], width=8.6, height=4.4) as axes:
        draw_single_harmonics(axes, shown, "N m", table.torque)
    plot_single_harmonics(paths[2], shown)
    if stars:
        plot_stars(paths[3], stars)
    return paths


def table_files(stars: Sequence[Star]) -> list[str]:
    """Return the names of the files that `picture_torque_table` writes."""
    return [
        "torque.svg",
        "harmonics.svg",
        "single_harmonics.svg",
        *(["stars.svg"] if stars else []),
    ]


def plot_torque(path: Path, samples: Array, harmonics: Harmonics) -> None:
    """Plot torque samples with the sum of the harmonics, and the amplitudes by order."""
    whole = harmonics.orders.size == harmonics.samples // 2
    summed = "sum of all harmonics" if whole else f"sum up to order {harmonics.orders[-1]:g}"
    with figure(path, 2, width=8.6, height=3.4) as (left, right):
        draw_samples(left, samples, harmonics, summed=summed)
        draw_harmonics(
            right, harmonics.orders, {"amplitude": harmonics.amplitude}, r"amplitude $M_k$ [N m]"
        )


def _uncancelled(harmonics: Harmonics) -> Flags:
    """Return which harmonics exceed the round-off of orders in which all cylinders cancel."""
    return harmonics.amplitude >= CANCELLED * max(
        float(np.max(harmonics.amplitude)), abs(harmonics.mean)
    )


def plot_single_harmonics(path: Path, harmonics: Harmonics, *, title: str = "") -> None:
    """Plot harmonics of a torque, each in its own panel, the lowest if there are too many.

    Orders that cancel in the sum of several cylinders are left out.
    """
    left = np.flatnonzero(_uncancelled(harmonics))[:MOST_PANELS]
    if not left.size:
        with figure(path, width=4.0, height=1.2) as axes:
            axes.set_axis_off()
            axes.set_title(f"All orders up to {harmonics.orders[-1]:g} cancel.", fontsize=9)
            add_title(axes, title)
        return
    count = len(left)
    columns = min(PANELS_A_ROW, count)
    rows = math.ceil(count / columns)
    size = {"width": 2.9 * columns + 0.4, "height": 2.1 * rows + 0.3}
    with figure(path, columns, **size, rows=rows) as axes:
        panels = axes.ravel().tolist()
        top = 1.1 * float(np.max(harmonics.amplitude[left]))
        for place, panel in enumerate(panels):
            if place >= count:
                panel.set_axis_off()
                continue
            draw_one_harmonic(panel, harmonics, int(left[place]), "N m")
            panel.set_ylim(-top, top)
            if place % columns:
                panel.set_ylabel("")
                panel.tick_params(labelleft=False)
            if place + columns < count:
                panel.set_xlabel("")
                panel.tick_params(labelbottom=False)
        add_title(panels, title)
