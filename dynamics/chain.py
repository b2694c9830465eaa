"""A chain of inertias and springs, torsional or axial, and its natural frequencies and modes."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import svd

from dynamics.checks import FloatArray, positive_vector, read_only, values_at_nodes
from dynamics.tails import with_accurate_tails
from geometry.errors import InputError

# Residual that the modes must keep, relative to the largest eigenvalue; round-off leaves 1e-14.
RESIDUAL_LIMIT = 1e-10
# A displacement below this share of both next to it is zero.
ZERO_DISPLACEMENT = 1e-11
# Displacements within this share of the largest one count as equally large.
EQUAL_DISPLACEMENT = 1e-9


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural frequencies and mode shapes of a chain of n inertias, ascending.

    Parameters
    ----------
    angular_frequencies : ndarray of shape (n,)
        Natural frequencies [rad/s]; exactly 0 for the rigid-body mode.
    shapes : ndarray of shape (n, n)
        One mode per column, one node per row; the largest absolute displacement is +1, at the
        first node that reaches it.
    rigid : int
        Number of rigid-body modes: 1 for a free chain, 0 with any stiffness to ground.
    node_positions : tuple of tuple of float
        For each mode, where it does not move, in units of the element index, ascending: 2.37 lies
        between nodes 2 and 3 (the first node is 0), at 37 % of the element.
    residual : float
        Largest residual of the modes, relative to the largest eigenvalue.
    """

    angular_frequencies: FloatArray
    shapes: FloatArray
    rigid: int
    node_positions: tuple[tuple[float, ...], ...]
    residual: float

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies [Hz], shape (n,), ascending."""
        return self.angular_frequencies / (2.0 * np.pi)


@dataclass(frozen=True, init=False, eq=False)
class Chain:
    """Inertias in a row with springs between neighbors, and springs to ground where wanted.

    Parameters
    ----------
    inertia : array_like of shape (n,)
        Moments of inertia [kg m^2] of a torsional chain, or masses [kg] of an axial one.
    stiffness : array_like of shape (n - 1,)
        Stiffness between neighbors [N m/rad] or [N/m].
    ground : array_like of shape (n,) or mapping of int to float, optional
        Stiffness of each node to ground [N m/rad] or [N/m], or that of single nodes by their
        number from 0. None by default.

    Raises
    ------
    InputError
        If an inertia or a stiffness is not above zero, a ground stiffness is negative, the lengths
        do not fit, or a value is not a finite number.

    Examples
    --------
    >>> modes = Chain(inertia=[211.4, 8.3], stiffness=[9.775e6]).modes()
    >>> modes.frequencies.round(1).tolist()
    [0.0, 176.1]
    """

    inertia: FloatArray
    stiffness: FloatArray
    ground: FloatArray

    def __init__(
        self,
        inertia: ArrayLike,
        stiffness: ArrayLike,
        ground: ArrayLike | Mapping[int, float] | None = None,
    ) -> None:
        inertias = positive_vector(
            "inertia",
            inertia,
            "kg m^2 (torsional) or kg (axial)",
            "a node without inertia has no motion of its own",
        )
        if inertias.size == 0:
            raise InputError(
                "inertia: given no values; allowed are one or more, because a chain has a node."
            )
        unit = "N m/rad (torsional) or N/m (axial)"
        stiffnesses = positive_vector(
            "stiffness", stiffness, unit, "a spring without stiffness cuts the chain in two"
        )
        if stiffnesses.size != inertias.size - 1:
            raise InputError(
                f"stiffness: given {stiffnesses.size} values for {inertias.size} inertias; allowed "
                f"are exactly {inertias.size - 1}, because one spring joins each two neighbors."
            )
        to_ground = values_at_nodes(
            "ground", ground, inertias.size, unit, "a support does not push a node away"
        )
        object.__setattr__(self, "inertia", read_only(inertias))
        object.__setattr__(self, "stiffness", read_only(stiffnesses))
        object.__setattr__(self, "ground", read_only(to_ground))

    def mass_matrix(self) -> FloatArray:
        """Return the diagonal inertia matrix M, shape (n, n) [kg m^2 or kg]."""
        return np.diag(self.inertia)

    def stiffness_matrix(self) -> FloatArray:
        """Return the tridiagonal stiffness matrix K, shape (n, n) [N m/rad or N/m]."""
        diagonal = self.ground.copy()
        diagonal[:-1] += self.stiffness
        diagonal[1:] += self.stiffness
        return np.diag(diagonal) - np.diag(self.stiffness, 1) - np.diag(self.stiffness, -1)

    def modes(self) -> Modes:
        """Find all natural frequencies and mode shapes, K x = w^2 M x.

        Returns
        -------
        Modes
            n modes, ascending; the rigid-body mode of a free chain is exactly 0 and uniform.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the modes found do not satisfy the equation of motion.

        Notes
        -----
        With one row for each spring, K = C' C for C = sqrt(k) times the elongation of the spring.
        The natural angular frequencies are the singular values of C M^(-1/2) and its right
        singular vectors the mass-normalized modes. Frequencies found so keep an error of round-off
        times the highest frequency; from K itself the error would be that of the squares, and the
        lowest frequency of a stiff chain would lose twice the digits. Where a mode dies out
        towards an end, its small displacements follow from the equations of the nodes there, so
        that in a chain mode j (from 0) has j nodes as theory wants.
        """
        root_inertia = np.sqrt(self.inertia)
        _, singular, vectors = svd(self._spring_rows() / root_inertia, full_matrices=False)
        frequencies = singular[::-1]
        normalized = self._with_accurate_tails(vectors[::-1].T, frequencies)
        shapes = _scaled(normalized / root_inertia[:, np.newaxis])
        rigid = 0
        if not np.any(self.ground):
            rigid = 1
            frequencies = np.concatenate(([0.0], frequencies))
            shapes = np.column_stack((np.ones(self.inertia.size), shapes))
        residual = self._residual(frequencies, shapes)
        if not residual <= RESIDUAL_LIMIT:
            raise np.linalg.LinAlgError(
                f"the modes of the chain leave a residual of {residual:.1e} of the largest "
                f"eigenvalue, above {RESIDUAL_LIMIT:.0e}"
            )
        return Modes(
            angular_frequencies=read_only(np.array(frequencies)),
            shapes=read_only(shapes),
            rigid=rigid,
            node_positions=tuple(_zero_crossings(shape) for shape in shapes.T),
            residual=residual,
        )

    def _with_accurate_tails(self, modes: FloatArray, frequencies: FloatArray) -> FloatArray:
        """Return the mass-normalized modes, one per column, right down to their far ends."""
        root_inertia = np.sqrt(self.inertia)
        diagonal = np.diag(self.stiffness_matrix()) / self.inertia
        off_diagonal = -self.stiffness / (root_inertia[:-1] * root_inertia[1:])
        columns = [
            with_accurate_tails(mode, diagonal, off_diagonal, frequency**2)
            for mode, frequency in zip(modes.T, frequencies.tolist(), strict=True)
        ]
        return np.column_stack(columns) if columns else modes

    def _spring_rows(self) -> FloatArray:
        """Return C with C' C = K: one row per spring, shape (springs, n)."""
        count = self.inertia.size
        root = np.sqrt(self.stiffness)
        between = np.zeros((count - 1, count))
        rows = np.arange(count - 1)
        between[rows, rows] = root
        between[rows, rows + 1] = -root
        supported = np.flatnonzero(self.ground)
        to_ground = np.zeros((supported.size, count))
        to_ground[np.arange(supported.size), supported] = np.sqrt(self.ground[supported])
        return np.vstack((between, to_ground))

    def _residual(self, frequencies: FloatArray, shapes: FloatArray) -> float:
        """Return max |M^(-1/2) (K x - w^2 M x)| / (w_max^2 |M^(1/2) x|) over the modes."""
        highest = float(frequencies[-1]) ** 2
        if highest == 0.0:
            return 0.0
        root_inertia = np.sqrt(self.inertia)[:, np.newaxis]
        force = self.stiffness_matrix() @ shapes
        force -= self.inertia[:, np.newaxis] * shapes * frequencies**2
        sizes = np.linalg.norm(root_inertia * shapes, axis=0)
        return float(np.max(np.linalg.norm(force / root_inertia, axis=0) / sizes) / highest)


def _scaled(shapes: FloatArray) -> FloatArray:
    """Scale each column so that its largest absolute displacement is +1, at its first place."""
    largest = np.max(np.abs(shapes), axis=0)
    first = np.argmax(np.abs(shapes) >= (1.0 - EQUAL_DISPLACEMENT) * largest, axis=0)
    signs = np.sign(shapes[first, np.arange(shapes.shape[1])])
    return np.asarray(shapes * (signs / largest))


def _zero_crossings(shape: FloatArray) -> tuple[float, ...]:
    """Return where a mode shape crosses zero, in element indices, by linear interpolation.

    A displacement of zero at a node, between neighbors that move, counts once, at that node. One
    that is small beside one neighbor only belongs to a mode that dies out there, and has a sign.
    """
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
