"""Mode shapes of a chain over its nodes, and of a whole shaft along it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import (
    BLUE,
    GREEN,
    ORANGE,
    Dash,
    Diagram,
    Dots,
    Limits,
    Line,
    draw_diagram,
    legend_above,
    order_line_style,
)
from crankbase.frames import Axes
from crankbase.quantity import format_number
from dynamics.plots.curves import MILLI


class ChainShapes(NamedTuple):
    """Mode shapes of a chain, as drawn.

    Attributes
    ----------
    shapes : ndarray of shape (n, m)
        One mode in each column.
    labels : sequence of m str
        For the legend.
    still : sequence of m tuples of float
        Positions on elements, as in `Modes.node_positions`.
    pairs : sequence of pairs of int
        Nodes that elements join.
    names : sequence of n str
        Of the nodes.
    """

    shapes: Array
    labels: Sequence[str]
    still: Sequence[tuple[float, ...]]
    pairs: Sequence[tuple[int, int]]
    names: Sequence[str]


def chain_shapes(
    drawn: ChainShapes,
    motion: str = "displacement",
    main: int | None = None,
    ticks: Sequence[str] = (),
) -> Diagram:
    """Describe mode shapes of a chain over its nodes, with a cross at each node of vibration.

    Parameters
    ----------
    motion : str, optional
        "twist" or "displacement".
    main : int, optional
        Number of those that a screen shows at first; all by default.
    ticks : sequence of n str, optional
        Names under the axis; by default those of the nodes.
    """
    shapes, labels, still, pairs, names = drawn
    places = chain_places(len(names), pairs)
    lines, dots = [], []
    for shown, (label, positions) in enumerate(zip(labels, still, strict=True)):
        color, dash, _ = order_line_style(shown)
        group, seen = f"mode {shown + 1}", main is None or shown < main
        # Chains may branch: each connection is a line of its own.
        along = [place for pair in pairs for place in (*places[list(pair)], np.nan)]
        moved = [part for pair in pairs for part in (*shapes[list(pair), shown], np.nan)]
        texts = [text for left, right in pairs for text in (names[left], names[right], "")]
        texts = [text.replace("\n", " ") for text in texts]
        hover = f"%{{text}}<br>relative {motion} %{{y:.3f}}<br>{label}"
        lines.append(Line(along, moved, label, color, hover, 1.5, dash, 3.0, texts, group, seen))
        if positions:
            crosses = crosses_on_axis(positions, pairs, places)
            hover = f"{label}<br>node at %{{text}}"
            numbers = [format_number(place, 3) for place in positions]
            zeros = np.zeros(len(crosses))
            dots.append(Dots(crosses, zeros, label, color, "x", None, hover, numbers, group, seen))
    ends = (float(places.min()) - 0.4, float(places.max()) + 0.4)
    return Diagram(
        Limits("", ends, dict(zip(places.tolist(), ticks or names, strict=True))),
        Limits(f"relative {motion} [1]", (-1.1, 1.1)),
        lines,
        dots,
        level=True,
    )


def draw_chain_shapes(axes: Axes, drawn: ChainShapes, motion: str = "displacement") -> None:
    """Draw `chain_shapes` on axes, with their legend."""
    draw_diagram(axes, chain_shapes(drawn, motion))
    legend_above(axes)


def shaft_shape(positions: Array, motion: Array, radius: float) -> Diagram:
    """Describe axial, torsional and lateral motion along a whole shaft in one mode, the largest as 1.

    Parameters
    ----------
    positions : ndarray of shape (s,)
        Of stations along the shaft [m], ascending.
    motion : ndarray of shape (s, 6)
        Displacements along x, y, z and rotations about them.
    radius : float
        Rotation about the shaft is shown as the displacement at this radius [m].
    """
    ux, uy, uz, rz = 0, 1, 2, 5
    curves: tuple[tuple[str, Array, str, Dash], ...] = (
        ("axial", motion[:, uz], BLUE, "solid"),
        ("torsional, at the crank radius", radius * motion[:, rz], ORANGE, "solid"),
        ("lateral, x", motion[:, ux], GREEN, "solid"),
        ("lateral, y", motion[:, uy], GREEN, "dash"),
    )
    every = np.concatenate([curve for _, curve, _, _ in curves])
    largest = float(every[np.argmax(np.abs(every))]) or 1.0
    values = "<br>%{y:.3f} of the largest<br>at %{x:.5g} mm"
    return Diagram(
        Limits("position along the shaft [mm]"),
        Limits("relative displacement [1]", (-1.1, 1.1)),
        [
            Line(MILLI * positions, curve / largest, name, color, name + values, 1.4, dash, 2.5)
            for name, curve, color, dash in curves
        ],
        level=True,
    )


def chain_places(count: int, pairs: Sequence[tuple[int, int]]) -> Array:
    """Return the positions of a chain's nodes on the axis of a diagram, from their numbers.

    Parameters
    ----------
    count : int
        Of nodes.
    pairs : sequence of pairs of int
        Nodes that elements join.

    Returns
    -------
    ndarray of shape (count,)
        A node that ends a branch, such as a damper's ring, is next to the node that carries it: before
        the first node if that carries it.

    Examples
    --------
    >>> chain_places(4, [(0, 1), (1, 2), (0, 3)]).tolist()
    [0.0, 1.0, 2.0, -1.0]
    """
    places = np.arange(float(count))
    # The node in which the line of nodes ends so far, and the place before the first.
    end, before = 0, 0.0
    for node in range(1, count):
        joined = [min(pair) for pair in pairs if max(pair) == node]
        if not joined or end in joined:
            end, places[node] = node, places[end] + 1.0
        elif joined[0] == 0:
            before -= 1.0
            places[node] = before
        else:
            places[node] = places[joined[0]] + 0.5
    return places


def crosses_on_axis(
    positions: tuple[float, ...], pairs: Sequence[tuple[int, int]], places: Array
) -> list[float]:
    """Return the positions on the axis of points on elements, from those of the nodes."""
    crossings = []
    for position in positions:
        number = min(int(position), len(pairs) - 1)
        left, right = pairs[number]
        crossings.append(float(places[left] + (position - number) * (places[right] - places[left])))
    return crossings
