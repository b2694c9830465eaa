"""Mode shapes of a chain over its nodes, and of a whole shaft along it."""

from collections.abc import Sequence

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.diagrams import BLUE, COLORS, GRAY, GREEN, ORANGE, legend_above
from crankbase.tables.frames import Axes
from dynamics.plots.quantities import MILLI

# Letters that stand side by side under the axis.
ROOM = 90


def draw_chain_shapes(
    axes: Axes,
    shapes: FloatArray,
    labels: Sequence[str],
    still: Sequence[tuple[float, ...]],
    pairs: Sequence[tuple[int, int]],
    names: Sequence[str],
    motion: str = "displacement",
) -> None:
    """Draw mode shapes of a chain over its nodes, with a cross at each node of vibration.

    Parameters
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
    motion : str, optional
        "twist" or "displacement".
    """
    places = chain_places(len(names), pairs)
    axes.axhline(0.0, color=GRAY, linewidth=1.0)
    for shown, (label, positions) in enumerate(zip(labels, still, strict=True)):
        shape, color = shapes[:, shown], COLORS[shown % len(COLORS)]
        for pair in pairs:
            axes.plot(places[list(pair)], shape[list(pair)], "-", color=color)
        axes.plot(places, shape, "o", color=color, markersize=4, label=label)
        crosses = crosses_on_axis(positions, pairs, places)
        axes.plot(crosses, np.zeros(len(crosses)), "x", color=color, markersize=7)
    crowded = sum(max(map(len, name.split("\n"))) for name in names) > ROOM
    axes.set_xticks(
        places,
        [name.replace("\n", " ") for name in names] if crowded else list(names),
        fontsize=8,
        rotation=40 if crowded else 0,
        ha="right" if crowded else "center",
    )
    axes.set_ylabel(f"relative {motion} [1]")
    legend_above(axes)


def shape_labels(
    frequencies: FloatArray, still: Sequence[tuple[float, ...]], numbered: bool = False
) -> list[str]:
    """Return the frequency of elastic modes and their number of nodes, for a legend.

    Parameters
    ----------
    frequencies : ndarray of shape (m,)
        From the first elastic mode on [Hz].
    still : sequence of m tuples of float
        Nodes of vibration, as in `Modes.node_positions`.
    numbered : bool, optional
        Whether each begins with its number.

    Examples
    --------
    >>> shape_labels(np.array([21.0, 54.32]), [(0.5,), (0.2, 1.4)], numbered=True)
    ['mode 1: 21.0 Hz, 1 node', 'mode 2: 54.3 Hz, 2 nodes']
    """
    labels = []
    for number, (frequency, positions) in enumerate(zip(frequencies, still, strict=True), start=1):
        nodes = f"{len(positions)} node{'s' if len(positions) != 1 else ''}"
        labels.append((f"mode {number}: " if numbered else "") + f"{frequency:.1f} Hz, {nodes}")
    return labels


def draw_shaft_shape(axes: Axes, positions: FloatArray, motion: FloatArray, radius: float) -> None:
    """Draw axial, torsional and lateral motion along a whole shaft in one mode.

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
    curves = {
        "axial": motion[:, uz],
        "torsional, at the crank radius": radius * motion[:, rz],
        "lateral, x": motion[:, ux],
        "lateral, y": motion[:, uy],
    }
    every = np.concatenate(list(curves.values()))
    largest = float(every[np.argmax(np.abs(every))])
    axes.axhline(0.0, color=GRAY, linewidth=1.0)
    for (name, curve), color, line in zip(
        curves.items(), (BLUE, ORANGE, GREEN, GREEN), ("-", "-", "-", "--"), strict=True
    ):
        axes.plot(
            MILLI * positions,
            curve / largest,
            line,
            color=color,
            marker="o",
            markersize=2.5,
            linewidth=1.4,
            label=name,
        )
    axes.set_ylim(-1.1, 1.1)
    axes.set_xlabel("position along the shaft [mm]")


def chain_places(count: int, pairs: Sequence[tuple[int, int]]) -> FloatArray:
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
    positions: tuple[float, ...], pairs: Sequence[tuple[int, int]], places: FloatArray
) -> list[float]:
    """Return the positions on the axis of points on elements, from those of the nodes."""
    crossings = []
    for position in positions:
        number = min(int(position), len(pairs) - 1)
        left, right = pairs[number]
        crossings.append(float(places[left] + (position - number) * (places[right] - places[left])))
    return crossings
