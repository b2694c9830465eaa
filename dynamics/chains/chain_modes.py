"""Natural frequencies and modes of a chain, accurate in every digit, and their energy shares."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.frames import Axes, DataFrame, Dataset, grid, table
from crankbase.summaries import frozen
from dynamics.plots.curves import name_axis
from dynamics.plots.mode_shapes import ChainShapes, draw_chain_shapes

# A displacement below this share of both next to it is zero.
ZERO_DISPLACEMENT = 1e-11
# Displacements within this share of the largest one count as equally large.
EQUAL_DISPLACEMENT = 1e-9


@frozen("frequencies [Hz]", "rigid", eq=False)
class Modes:
    """Natural frequencies and mode shapes of a chain of n inertias, ascending.

    q is n less what gears lead: one for each, and one more for each that has no inertia on either side.

    Parameters
    ----------
    angular_frequencies : ndarray of shape (q,)
        Natural frequencies [rad/s]; exactly 0 for a rigid-body mode.
    shapes : ndarray of shape (n, q)
        One mode per column, one node per row; the largest absolute displacement is +1, at the
        first node that reaches it.
    rigid : int
        Number of rigid-body modes, which come first: 1 for a free chain, 0 with any stiffness to
        ground; one more for each part held by dashpots only.
    node_positions : tuple of tuple of float
        For each mode, positions of its nodes of vibration: 2.37 is at 37 % of the element number 2, from its
        first to its second node. In a row that is between nodes 2 and 3; the first node is 0.
    residual : float
        Largest residual of the modes, relative to the largest eigenvalue.
    names : tuple of q str
        "rigid body" (with the nodes, if only some move), "mode 1" and so on.
    modal_inertia : ndarray of shape (q,)
        x' M x of each shape [kg m^2 or kg].
    kinetic_shares : ndarray of shape (n, q)
        Share of each node in the mode's kinetic energy; columns sum to 1.
    strain_shares : ndarray of shape (e + n, q)
        Share of each of the e elements, then of each connection to ground, in the mode's strain
        energy, in the order of `strain_names`; columns sum to 1, those of rigid-body modes are 0. It
        is also the relative change of the squared frequency per relative change of that stiffness.
    connections : tuple of e pairs of int
        Nodes that each element joins.
    """

    angular_frequencies: Array
    shapes: Array
    rigid: int
    node_positions: tuple[tuple[float, ...], ...]
    residual: float
    names: tuple[str, ...]
    modal_inertia: Array
    kinetic_shares: Array
    strain_shares: Array
    node_names: tuple[str, ...]
    connections: tuple[tuple[int, int], ...]

    @property
    def frequencies(self) -> Array:
        """Natural frequencies [Hz], shape (q,), ascending."""
        return self.angular_frequencies / (2.0 * np.pi)

    @property
    def elastic_frequencies(self) -> Array:
        """Natural frequencies without those of rigid-body modes [Hz], shape (q - rigid,), ascending.

        A chain that turns freely has one rigid-body mode, and one more with the ring of each viscous
        damper, which only its oil holds.
        """
        return self.frequencies[self.rigid :]

    @property
    def strain_names(self) -> tuple[str, ...]:
        """Name of each row of `strain_shares`, (e + n,): "node 0 - node 1", then "node 0 - ground"."""
        joined = [
            f"{self.node_names[left]} - {self.node_names[right]}"
            for left, right in self.connections
        ]
        return (*joined, *(f"{name} - ground" for name in self.node_names))

    def drawn_shapes(
        self, modes: Iterable[int], names: Sequence[str] = (), *, numbered: bool = False
    ) -> ChainShapes:
        """Return the shapes of some elastic modes as drawn, labeled with frequency and number of nodes.

        Parameters
        ----------
        modes : iterable of int
            Numbers from 0; those that the chain does not have are left out.
        names : sequence of n str, optional
            What nodes are called in place of their names.
        numbered : bool, optional
            Whether each label begins with the number of the elastic mode, from 1.
        """
        shown = [mode for mode in modes if mode < len(self.frequencies)]
        still = [self.node_positions[mode] for mode in shown]
        labels = []
        for mode, positions in zip(shown, still, strict=True):
            number = f"mode {mode - self.rigid + 1}: " if numbered else ""
            nodes = f"{len(positions)} node{'s' if len(positions) != 1 else ''}"
            labels.append(f"{number}{self.frequencies[mode]:.1f} Hz, {nodes}")
        return ChainShapes(
            self.shapes[:, shown], labels, still, self.connections, names or self.node_names
        )

    def plot(self, axes: Axes | None = None, *, count: int = 3) -> Axes:
        """Draw the shapes of the first elastic modes over the nodes.

        Returns
        -------
        matplotlib.axes.Axes
            Lines join nodes connected by an element; a cross marks a node of vibration.
        """
        most = whole_number("count", count, 1, "a diagram shows some modes")
        axes = new_axes(axes, height=3.4)
        draw_chain_shapes(axes, self.drawn_shapes(range(self.rigid, self.rigid + most)))
        write_title(axes, "Mode shapes")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return one row for each mode: name, frequency, number of nodes, modal inertia."""
        return table(
            {
                "mode": (list(self.names), ""),
                "frequency": (self.frequencies, "Hz"),
                "angular_frequency": (self.angular_frequencies, "rad/s"),
                "nodes": ([len(positions) for positions in self.node_positions], "1"),
                "modal_inertia": (self.modal_inertia, "kg m^2 or kg"),
            }
        )

    def to_xarray(self) -> Dataset:
        """Return shapes and energy shares over mode, node and spring, with the frequencies."""
        over, of_springs = ("node", "mode"), ("spring", "mode")
        return grid(
            {
                "frequency": (("mode",), self.frequencies, "Hz", "natural frequency"),
                "shapes": (over, self.shapes, "1", "relative displacement"),
                "kinetic_shares": (over, self.kinetic_shares, "1", "share of kinetic energy"),
                "strain_shares": (of_springs, self.strain_shares, "1", "share of strain energy"),
                "modal_inertia": (("mode",), self.modal_inertia, "kg m^2 or kg", "modal inertia"),
            },
            {
                "mode": name_axis(self.names, "mode"),
                "node": name_axis(self.node_names, "node"),
                "spring": name_axis(self.strain_names, "element, or spring to ground"),
            },
        )


def elastic_modes(rows: Array, mass: Array, count: int) -> tuple[Array, Array]:
    """Find the elastic modes of K x = w^2 M x with K = C' C.

    Parameters
    ----------
    rows : ndarray of shape (springs, q)
        C: one row for each spring, the root of its stiffness times its elongation.
    mass : ndarray of shape (q, q)
        M, positive definite.

    Returns
    -------
    angular_frequencies : ndarray of shape (count,)
        Ascending [rad/s].
    shapes : ndarray of shape (q, count)
        Of unit modal inertia.

    Notes
    -----
    With M = L L' the natural angular frequencies are the singular values of C L'^(-1), and its right
    singular vectors are L' times the modes. The error of these frequencies is round-off times the
    highest frequency; with K itself it would be that of the squares, and the lowest
    frequency of a stiff chain would lose twice the digits.
    """
    if np.array_equal(mass, np.diag(np.diag(mass))):
        inverse = np.diag(1.0 / np.sqrt(np.diag(mass)))
    else:
        inverse = np.linalg.inv(np.linalg.cholesky(mass))
    _, singular, vectors = np.linalg.svd(rows @ inverse.T, full_matrices=False)
    shapes = inverse.T @ vectors[:count].T
    return np.asarray(singular[:count][::-1]), np.asarray(shapes[:, ::-1])


def scaled(shapes: Array) -> Array:
    """Scale each column so that its largest absolute displacement is +1, at its first place."""
    largest = np.max(np.abs(shapes), axis=0)
    first = np.argmax(np.abs(shapes) >= (1.0 - EQUAL_DISPLACEMENT) * largest, axis=0)
    signs = np.sign(shapes[first, np.arange(shapes.shape[1])])
    return np.asarray(shapes * (signs / largest))


def eigen_residual(
    frequencies: Array,
    shapes: Array,
    mass: Array,
    stiffness: Array,
    expand: Array,
) -> float:
    """Return max |R^(-1) (K x - w^2 M x)| / (w_max^2 |x' M x|^(1/2)), R the root of M's diagonal."""
    highest = float(frequencies[-1]) ** 2
    if highest == 0.0:
        return 0.0
    root = np.sqrt(np.diag(expand.T @ mass @ expand))[:, np.newaxis]
    force = expand.T @ (stiffness @ shapes - mass @ shapes * frequencies**2)
    sizes = np.sqrt(np.sum(shapes * (mass @ shapes), axis=0))
    return float(np.max(np.linalg.norm(force / root, axis=0) / sizes) / highest)


def row_zero_crossings(shape: Array, pairs: tuple[tuple[int, int], ...]) -> tuple[float, ...]:
    """Return where a mode shape crosses zero in a row, in element indices, by interpolation.

    A displacement of zero at a node, between neighbors that move, counts once, at that node. A
    displacement that is small relative to one neighbor only belongs to a decaying mode, and has a sign.
    """
    assert len(pairs) == shape.size - 1
    size = np.pad(np.abs(shape), 1)
    moving = np.flatnonzero(size[1:-1] > ZERO_DISPLACEMENT * np.minimum(size[:-2], size[2:]))
    positions: list[float] = []
    for left, right in pairwise(moving.tolist()):
        if shape[left] * shape[right] > 0.0:
            continue
        if right == left + 1:
            positions.append(float(left + shape[left] / (shape[left] - shape[right])))
        else:
            positions.append(float(left + right) / 2.0)
    return tuple(positions)


def pair_zero_crossings(shape: Array, pairs: tuple[tuple[int, int], ...]) -> tuple[float, ...]:
    """Return where a mode shape crosses zero inside the elements of a branched chain."""
    return tuple(
        float(number + shape[left] / (shape[left] - shape[right]))
        for number, (left, right) in enumerate(pairs)
        if shape[left] * shape[right] < 0.0
    )


# Below this share of the largest mass-normalized displacement, an end of the shape is recomputed.
TAIL_SHARE = 1e-5


def with_accurate_tails(
    shape: Array,
    frequency: float,
    mass: Array,
    stiffness: Array,
    connections: tuple[tuple[int, int], ...],
) -> Array:
    """Return a mode whose displacements at the far ends have the right sign and full accuracy.

    A mode of a long chain may be confined to a few inertias and decay by a factor at each further one;
    there an eigenvalue routine leaves round-off of the largest displacement. The equation of
    motion of an end node gives the ratio of its displacement to that of its neighbor, the next
    equation the next ratio, and so on; from the ends inwards this is stable in the tail.

    Parameters
    ----------
    shape : ndarray of shape (n,)
    frequency : float
        Its angular frequency [rad/s].
    mass, stiffness : ndarray of shape (n, n)
    connections : tuple of tuples
        Pairs of nodes of the elements, without loops.

    Returns
    -------
    ndarray of shape (n,)
        The mode, its well-determined part unchanged.
    """
    normalized = np.abs(shape) * np.sqrt(np.diag(mass))
    large = normalized >= TAIL_SHARE * np.max(normalized)
    if np.all(large):
        return shape
    shape, dynamic = shape.copy(), stiffness - frequency**2 * mass
    neighbors: dict[int, list[int]] = {node: [] for node in range(shape.size)}
    for left, right in connections:
        neighbors[left].append(right)
        neighbors[right].append(left)
    # Outwards from the largest displacement, each node after the one before it.
    outwards = [int(np.argmax(normalized))]
    before: dict[int, int] = {}
    for node in outwards:
        further = [other for other in neighbors[node] if other != before.get(node)]
        before.update(dict.fromkeys(further, node))
        outwards += further
    pivots = np.diag(dynamic).copy()
    for node in reversed(outwards[1:]):
        inner, coupling = before[node], dynamic[before[node], node]
        if pivots[node] == 0.0:
            pivots[node] = np.finfo(np.float64).eps * abs(coupling)
        pivots[inner] -= coupling**2 / pivots[node]
        large[inner] |= large[node]
    for node in outwards[1:]:
        if not large[node]:
            shape[node] = -dynamic[before[node], node] / pivots[node] * shape[before[node]]
    return shape
