"""Torque of an engine over its cycle, amplitudes of its harmonics, and star diagrams."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import figure
from crankfem.analyses.titles import add_title
from dynamics.harmonics import Harmonics, TorqueTable
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
from dynamics.torque.star import Star, same_stars, star_diagram
from dynamics.torque.torque import EngineTorque

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
    path: Path, found: Harmonics, stars: Sequence[Star], *, title: str = ""
) -> None:
    """Plot the amplitudes of the engine's torque by order, colored by the star of the order."""
    amplitude = np.where(_uncancelled(found), found.amplitude, 0.0)
    with figure(path, width=7.2, height=3.6) as axes:
        for kind, color in KIND_COLORS.items():
            orders = [star.order for star in stars if star.kind == kind]
            heights = [amplitude[found.index_of(order)] / 1000.0 for order in orders]
            if orders:
                axes.bar(orders, heights, width=0.6 * found.orders[0], color=color, label=kind)
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
            orders = ", ".join(f"{own.order:g}" for own in group)
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
    folder : Path
    table : TorqueTable
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


def plot_torque(path: Path, samples: FloatArray, found: Harmonics) -> None:
    """Plot torque samples with the sum of the harmonics, and the amplitudes by order."""
    whole = found.orders.size == found.samples // 2
    summed = "sum of all harmonics" if whole else f"sum up to order {found.orders[-1]:g}"
    with figure(path, 2, width=8.6, height=3.4) as (left, right):
        draw_samples(left, samples, found, summed=summed)
        draw_harmonics(
            right, found.orders, {"amplitude": found.amplitude}, r"amplitude $M_k$ [N m]"
        )


def _uncancelled(found: Harmonics) -> NDArray[np.bool_]:
    """Return which harmonics exceed the round-off of orders in which all cylinders cancel."""
    return found.amplitude >= CANCELLED * max(float(np.max(found.amplitude)), abs(found.mean))


def plot_single_harmonics(path: Path, found: Harmonics, *, title: str = "") -> None:
    """Plot harmonics of a torque, each in its own panel, the lowest if there are too many.

    Orders that cancel in the sum of several cylinders are left out.
    """
    left = np.flatnonzero(_uncancelled(found))[:MOST_PANELS]
    if not left.size:
        with figure(path, width=4.0, height=1.2) as axes:
            axes.set_axis_off()
            axes.set_title(f"All orders up to {found.orders[-1]:g} cancel.", fontsize=9)
            add_title(axes, title)
        return
    count = len(left)
    columns = min(PANELS_A_ROW, count)
    rows = math.ceil(count / columns)
    size = {"width": 2.9 * columns + 0.4, "height": 2.1 * rows + 0.3}
    with figure(path, columns, **size, rows=rows) as axes:
        panels = axes.ravel().tolist()
        top = 1.1 * float(np.max(found.amplitude[left]))
        for place, panel in enumerate(panels):
            if place >= count:
                panel.set_axis_off()
                continue
            draw_one_harmonic(panel, found, int(left[place]), "N m")
            panel.set_ylim(-top, top)
            if place % columns:
                panel.set_ylabel("")
                panel.tick_params(labelleft=False)
            if place + columns < count:
                panel.set_xlabel("")
                panel.tick_params(labelbottom=False)
        add_title(panels, title)
