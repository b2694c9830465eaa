"""Draw the pictures of docs/support.md with the current code: takes some seconds.

A throw pulled by the same axial force under each support, as a section in its crank plane, and its
axial compliance over the angle to its neighbors.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

import crankfem as cf
from crankbase.diagrams import BLUE, GRAY, GREEN, ORANGE, RED, figure
from fem.fields import images
from fem.supports import end_motions
from geometry.mesh import six_node_triangles
from geometry.solid import CRANK_PLANE

Array = NDArray[np.float64]

HERE = Path(__file__).parent
ENGINE = "6chn25-34"
FORCE = 1e5  # N
MAGNIFIED = 250.0
CURVE = ((0, 3, 1), (1, 4, 2), (2, 5, 0))  # the sides of a six-node triangle
STEEL_COLOR, EDGE = "#c9dcee", "#17466f"


def section_loops(analysis: cf.ThrowAnalysis) -> list[NDArray[np.int64]]:
    """Return the closed lines of nodes around the meshed part's section in the crank plane."""
    mesh = analysis.mesh
    sides = six_node_triangles(mesh, mesh.surfaces[CRANK_PLANE])[:, np.array(CURVE)].reshape(-1, 3)
    _, place, count = np.unique(
        np.sort(sides[:, ::2], axis=1), axis=0, return_index=True, return_counts=True
    )
    border = sides[place[count == 1]]
    after: dict[int, list[NDArray[np.int64]]] = {}
    for side in border:
        after.setdefault(int(side[0]), []).append(side)
        after.setdefault(int(side[2]), []).append(side[::-1])
    loops, seen = [], set()
    for start in after:
        if start in seen:
            continue
        loop, here = [], start
        while True:
            seen.add(here)
            ways = [side for side in after[here] if int(side[2]) not in seen]
            if not ways:
                break
            loop += [here, int(ways[0][1])]
            here = int(ways[0][2])
        closing = next(side for side in after[here] if int(side[2]) == start)
        loops.append(np.array([*loop, here, int(closing[1]), start]))
    return loops


def draw_throw(axes: Any, analysis: cf.ThrowAnalysis, support: Any) -> None:
    """Draw the throw as it is and as the force pulls it."""
    motions = FORCE * end_motions(analysis.superelement, support)[:, 0]
    motions[[2, 8]] -= 0.5 * (motions[2] + motions[8])  # both ends move apart alike
    motions[[5, 11]] -= 0.5 * (motions[5] + motions[11])
    middle = 0.5 * analysis.throw.length
    for image in images(analysis.mesh, analysis.classes, motions):
        for loop in section_loops(analysis):
            still = image.points[loop]
            moved = still + MAGNIFIED * image.displacement[loop]
            inside = np.abs(still[:, 2] - middle) < 1e-9
            for points, style in (
                (still, {"color": GRAY, "linewidth": 0.9, "linestyle": (0, (4, 3))}),
                (moved, {"color": EDGE, "linewidth": 1.2}),
            ):
                shown = 1e3 * points[:, [2, 1]]
                if points is moved:
                    axes.add_patch(
                        Polygon(shown, facecolor=STEEL_COLOR, edgecolor="none", zorder=1)
                    )
                # The line between the two halves is no edge.
                left_out = np.flatnonzero(inside[:-1] & inside[1:]) + 1
                axes.plot(*np.insert(shown, left_out, np.nan, axis=0).T, zorder=2, **style)


def draw_pull(axes: Any, length: float) -> None:
    """Draw the force at both ends."""
    for end, sense in ((0.0, -1.0), (length, 1.0)):
        axes.annotate(
            "P",
            xy=(end + 95.0 * sense, 0.0),
            xytext=(end + 35.0 * sense, 0.0),
            ha="center",
            va="center",
            color=RED,
            fontsize=11,
            arrowprops={"arrowstyle": "-|>", "color": RED, "linewidth": 1.8},
            zorder=5,
        )


def draw_hinges(axes: Any, length: float) -> None:
    """Draw supports that keep the ends' middles on the axis and let them tilt and move along it."""
    for place in (0.0, length):
        triangle = [(place, 0.0), (place - 16.0, -30.0), (place + 16.0, -30.0)]
        axes.add_patch(
            Polygon(triangle, facecolor="white", edgecolor=ORANGE, linewidth=1.6, zorder=4)
        )
        axes.plot(
            [place - 22.0, place + 22.0], [-36.0, -36.0], color=ORANGE, linewidth=1.6, zorder=4
        )
        axes.plot([place], [0.0], "o", color=ORANGE, markersize=5, zorder=5)


def draw_guides(axes: Any, length: float, radius: float) -> None:
    """Draw sleeves that keep the end sections upright."""
    for place in (0.0, length):
        for side in (-1.0, 1.0):
            low = radius + 4.0 if side > 0 else -radius - 18.0
            axes.add_patch(
                Rectangle(
                    (place - 24.0, low),
                    48.0,
                    14.0,
                    facecolor="white",
                    edgecolor=ORANGE,
                    hatch="////",
                    linewidth=1.6,
                    zorder=4,
                )
            )
        axes.plot([place, place], [-radius, radius], color=ORANGE, linewidth=2.2, zorder=4)


def draw_neighbors(axes: Any, length: float, radius: float) -> None:
    """Draw the beginning of the next throws, and bearings at the ends."""
    for place, sense in ((0.0, -1.0), (length, 1.0)):
        reach = place + 26.0 * sense
        corners = [(place, -radius), (reach, -radius), (reach, radius), (place, radius)]
        codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO]
        axes.add_patch(
            PathPatch(
                Outline(corners, codes),
                facecolor="#e7ebef",
                edgecolor=GRAY,
                linewidth=0.9,
                zorder=0,
            )
        )
        axes.plot([place, place], [-radius, radius], color=ORANGE, linewidth=1.2, zorder=4)
        axes.text(
            place + 20.0 * sense,
            radius + 14.0,
            "next throw",
            color=GRAY,
            fontsize=8,
            ha="right" if sense < 0 else "left",
        )
        for side in (-1.0, 1.0):
            low = radius if side > 0 else -radius
            triangle = [
                (place, low),
                (place - 11.0, low + 18.0 * side),
                (place + 11.0, low + 18.0 * side),
            ]
            axes.add_patch(
                Polygon(triangle, facecolor="white", edgecolor=ORANGE, linewidth=1.4, zorder=4)
            )


def draw_supports(analysis: cf.ThrowAnalysis, path: Path) -> None:
    """Draw the throw under three supports side by side."""
    throw = analysis.throw
    length, radius = 1e3 * throw.length, 0.5e3 * throw.main_journal_diameter
    between = cf.Neighbors(120.0, 120.0)
    panels = (
        ("pinned", "pinned: ends tilt freely", lambda axes: draw_hinges(axes, length)),
        ("guided", "guided: ends stay upright", lambda axes: draw_guides(axes, length, radius)),
        (between, "Neighbors(120, 120)", lambda axes: draw_neighbors(axes, length, radius)),
    )
    with figure(path, columns=3, width=11.5, height=4.2) as all_axes:
        for axes, (support, title, draw) in zip(all_axes, panels, strict=True):
            draw_throw(axes, analysis, support)
            draw(axes)
            draw_pull(axes, length)
            compliance = analysis.axial_compliance(support)
            axes.plot(
                [-60.0, length + 60.0], [0.0, 0.0], color=GRAY, linewidth=0.7, dashes=(12, 3, 2, 3)
            )
            axes.set_title(f"{title}\n$e_n$ = {1e9 * compliance:.2f} nm/N", loc="center")
            axes.set_aspect("equal")
            axes.set_xlim(-105.0, length + 105.0)
            axes.set_ylim(-185.0, 340.0)
            axes.axis("off")


def draw_angle(analysis: cf.ThrowAnalysis, path: Path) -> None:
    """Draw the axial compliance over the angle to the neighbors, and the throws of the real shaft."""
    angles = np.linspace(0.0, 180.0, 181)
    law = analysis.angle_law
    pinned = analysis.axial_compliance("pinned")
    engine = cf.load_engine(ENGINE)
    shaft = cf.compliance.shaft_compliances(
        [analysis.superelement] * 6, crank_angles_deg=np.degrees(engine.engine.crank_angles)
    )
    with figure(path, width=7.6, height=4.4) as axes:
        axes.plot(
            angles, 1e9 * law.axial(angles), color=BLUE, label="between neighbors, each turned by γ"
        )
        axes.axhline(
            1e9 * pinned,
            color=ORANGE,
            linestyle="--",
            label="pinned: the same as opposite neighbors",
        )
        axes.axhline(
            1e9 * analysis.axial_compliance("guided"),
            color=GREEN,
            linestyle="--",
            label="guided: the same as neighbors in line",
        )
        for number, value in enumerate(shaft.axial[:3], 1):
            axes.axhline(1e9 * value, xmin=0.92, color=RED, linewidth=2.0)
            axes.annotate(
                f"throws {number} and {7 - number}",
                (182.0, 1e9 * value),
                va="center",
                ha="left",
                fontsize=9,
                color=RED,
                annotation_clip=False,
            )
        axes.plot([], [], color=RED, linewidth=2.0, label="in the six-cylinder shaft")
        axes.set_xlim(0.0, 180.0)
        axes.set_ylim(0.0, None)
        axes.set_xticks(np.arange(0, 181, 30))
        axes.set_xlabel("angle γ from throw to throw [deg]")
        axes.set_ylabel("axial compliance $e_n$ [nm/N]")
        axes.set_title(f"Axial compliance of the throw of {engine.engine.name}")
        axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.9))


def main() -> None:
    """Draw both."""
    engine = cf.load_engine(ENGINE)
    analysis = cf.analyze_throw(engine.throw, engine.material)
    draw_supports(analysis, HERE / "support_throws.svg")
    draw_angle(analysis, HERE / "support_angle.svg")


if __name__ == "__main__":
    with cf.replacing_files():
        main()
