"""Torque of an engine over its cycle, amplitudes of its harmonics, and star diagrams."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crankfem.pictures.titles import add_title
from dynamics.harmonics import Harmonics
from dynamics.torque.star import Star, same_stars, star_diagram
from dynamics.torque.torque import EngineTorque
from geometry.diagram_style import BLUE, COLORS, GRAY, ORANGE, figure

# Stars side by side, and the distance of their centers in lengths of one vector.
STARS_A_ROW, STAR_STEP = 4, 3.4
# Where numbers of cylinders stand, in lengths of a vector, and from which sine on to its side.
LABEL_START, SIDEWAYS = 1.2, 0.5
KIND_COLORS = {"major": ORANGE, "minor": BLUE, "balanced": GRAY}


def picture_torque(
    folder: Path, torque: EngineTorque, highest_order: float, *, title: str = ""
) -> list[Path]:
    """Write torque.svg, harmonics.svg and stars.svg into a folder and return their paths."""
    stars = star_diagram(torque.engine, highest_order)
    paths = [folder / name for name in ("torque.svg", "harmonics.svg", "stars.svg")]
    plot_engine_torque(paths[0], torque, title=title)
    plot_amplitudes(paths[1], torque.harmonics(), stars, title=title)
    plot_stars(paths[2], stars, title=title)
    return paths


def plot_engine_torque(path: Path, torque: EngineTorque, *, title: str = "") -> None:
    """Plot the torque of the whole engine and of one throw, apart by cause, over the cycle."""
    angles = np.rad2deg(torque.shaft_angles)
    first = [number - 1 for number in torque.throws[0]]
    with figure(path, 2, width=9.6, height=3.6) as (left, right):
        left.plot(angles, torque.total / 1000.0, color=BLUE, label="engine")
        left.axhline(
            torque.mean / 1000.0, color=ORANGE, linestyle="--", linewidth=1.2, label="mean"
        )
        left.set_title("Torque of the engine")
        left.set_ylabel("torque [kN m]")
        parts = (("gas", torque.gas), ("inertia", torque.inertia), ("both", torque.per_cylinder))
        for (label, values), color in zip(parts, (COLORS[1], COLORS[2], COLORS[0]), strict=True):
            own = values[first].sum(axis=0) / 1000.0
            right.plot(angles, own, color=color, label=label, linewidth=1.3)
        right.set_title("Torque of throw 1")
        for axes in (left, right):
            axes.set_xlabel("shaft angle [deg]")
            axes.set_xticks(np.arange(0, 180 * torque.engine.strokes + 1, 90))
            axes.set_xlim(0.0, 180.0 * torque.engine.strokes)
            # Above the curves, which fill the axes.
            axes.legend(fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        add_title((left, right), title)


def plot_amplitudes(
    path: Path, found: Harmonics, stars: Sequence[Star], *, title: str = ""
) -> None:
    """Plot the amplitudes of the engine's torque by order, colored by the star of the order."""
    with figure(path, width=7.2, height=3.6) as axes:
        for kind, color in KIND_COLORS.items():
            orders = [star.order for star in stars if star.kind == kind]
            heights = [found.amplitude[found.index_of(order)] / 1000.0 for order in orders]
            if orders:
                axes.bar(orders, heights, width=0.6 * found.orders[0], color=color, label=kind)
        axes.set_xlabel("harmonic order [cycles per revolution]")
        axes.set_ylabel(r"amplitude $M_k$ [kN m]")
        axes.set_title("Harmonics of the engine's torque")
        axes.legend(fontsize=8, title="star of the order", title_fontsize=8)
        add_title(axes, title)


def plot_stars(path: Path, stars: Sequence[Star], *, title: str = "") -> None:
    """Draw the star of each group of orders that look alike, with its resultant."""
    groups = same_stars(stars)
    columns = min(STARS_A_ROW, len(groups))
    rows = math.ceil(len(groups) / columns)
    with figure(path, width=2.3 * columns, height=2.6 * rows + 0.2) as axes:
        for place, group in enumerate(groups):
            row, column = divmod(place, columns)
            _draw_star(axes, group, (STAR_STEP * column, -1.15 * STAR_STEP * row))
        axes.set_aspect("equal")
        axes.set_axis_off()
        half = 0.5 * STAR_STEP
        axes.set_xlim(-half, STAR_STEP * columns - half)
        axes.set_ylim(-1.15 * STAR_STEP * (rows - 1) - half, half + 0.4)
        add_title(axes, f"Stars of the orders, all cylinders alike\n{title}".strip())


def _draw_star(axes: Any, group: tuple[Star, ...], center: tuple[float, float]) -> None:
    """Draw one star; firing at shaft angle zero points up, angles turn clockwise."""
    star = group[0]
    x, y = center
    longest = float(np.max(np.abs(star.weights)))
    axes.plot(
        x + np.cos(np.linspace(0.0, 2.0 * np.pi, 73)),
        y + np.sin(np.linspace(0.0, 2.0 * np.pi, 73)),
        color="#d5dae0",
        linewidth=0.8,
    )
    color = KIND_COLORS[star.kind]
    for tips in _by_direction(star):
        place = star.vectors[tips[0]] / longest
        _arrow(axes, center, place, color, 1.6)
        away = place / abs(place) if abs(place) > 0.0 else 1.0
        label = ", ".join(str(tip + 1) for tip in tips)
        at = LABEL_START * away
        side = "left" if away.imag > SIDEWAYS else "right" if away.imag < -SIDEWAYS else "center"
        # Set to a side, the label begins at the vector's end.
        shift = 0.0 if side == "center" else 0.1 * away.imag
        axes.text(x + at.imag - shift, y + at.real, label, fontsize=8, ha=side, va="center")
    if star.kind == "minor":
        _arrow(axes, center, star.vectors.sum() / star.largest, ORANGE, 2.6)
    orders = ", ".join(f"{own.order:g}" for own in group)
    said = star.kind if star.kind != "minor" else f"minor, {100.0 * star.share:.3g} %"
    axes.text(
        x,
        y + 0.5 * STAR_STEP + 0.02,
        f"{'orders' if len(group) > 1 else 'order'} {orders}\n{said}",
        fontsize=8,
        ha="center",
        va="center",
    )


def _by_direction(star: Star) -> list[list[int]]:
    """Return the cylinders, from 0, in groups of one direction."""
    groups: list[list[int]] = []
    units = np.exp(1j * star.directions)
    for place, unit in enumerate(units):
        home = next((group for group in groups if abs(units[group[0]] - unit) < 1e-6), None)
        if home is None:
            groups.append([place])
        else:
            home.append(place)
    return groups


def _arrow(
    axes: Any, center: tuple[float, float], vector: complex, color: str, width: float
) -> None:
    x, y = center
    axes.annotate(
        "",
        xy=(x + vector.imag, y + vector.real),
        xytext=center,
        arrowprops={
            "arrowstyle": "-|>",
            "color": color,
            "linewidth": width,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
