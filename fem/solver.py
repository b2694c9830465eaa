"""Assemble stiffness and mass, and solve symmetric positive definite systems; selects the library.

Every run checks its solution: reciprocity, rigid motions, definiteness, balance. Rotations are measured
as length x angle, so that all figures are shares. Figures of round-off are below 1e-11 for throws of all
kinds (tests/campaigns/random_throws.py draws such); an error of 1e-6 in a solution appears as about the
same figure.

Of symmetric matrices only upper triangles are kept. Inertia acts on each displacement component alone, so
the mass matrix is one of nodes times the identity of three axes.
"""

import copy
import os
import sys
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError, SolveError
from fem.material import Material
from fem.symmetry import rigid_motions
from geometry.shapes import jacobians, shapes_for_quadrature

# Four points integrate the stiffness of a straight element exactly; on curved ones the error is far
# below that of the mesh.
QUADRATURE_ORDER = 2
# Two quadratic shape functions times the cubic Jacobian determinant of a curved element are of seventh
# order, which scikit-fem's rule "8" integrates exactly; its rules 5 to 9 are exact to one order less
# than their names.
MASS_QUADRATURE_ORDER = 8
CHUNK = 4096
# Pairs (2, 55) of an element's nodes, each once, nodes with themselves included.
PAIRS = np.array(np.triu_indices(10))
# Where their 3 x 3 entries, row by row and column by column, stand in a 30 x 30 matrix of all nodes.
_BLOCKS = 90 * PAIRS[0][:, None, None] + 3 * PAIRS[1][:, None, None]
_ENTRIES = (_BLOCKS + np.arange(0, 90, 30)[:, None] + np.arange(3)).ravel()
_TRANSPOSED = (_BLOCKS + np.arange(3)[:, None] + np.arange(0, 90, 30)).ravel()


def physical_gradients(corners: Array, gradients: Array, weights: Array) -> tuple[Array, Array]:
    """Gradients in space and integration weights of a batch of elements.

    Parameters
    ----------
    corners : (m, 10, 3) array
        Node coordinates of the elements [m].
    gradients : (q, 10, 3) array
        Reference gradients of the shape functions.
    weights : (q,) array
        Quadrature weights.

    Returns
    -------
    gradients : (m, q, 10, 3) array
        Derivatives of each shape function by x, y, z [1/m].
    volumes : (m, q) array
        Weight times Jacobian determinant [m^3].
    """
    jacobian = jacobians(gradients, corners)
    # The inverse by cofactors: several times faster than a general one for so many small matrices.
    first, second, third = jacobian[:, :, 0], jacobian[:, :, 1], jacobian[:, :, 2]
    adjugate = np.empty_like(jacobian)
    _cross(second, third, adjugate[:, :, 0])
    _cross(third, first, adjugate[:, :, 1])
    _cross(first, second, adjugate[:, :, 2])
    determinant = np.einsum("mqi,mqi->mq", first, adjugate[:, :, 0])
    adjugate /= determinant[:, :, None, None]
    return gradients[None] @ adjugate, determinant * weights


def _cross(left: Array, other: Array, product: Array) -> None:
    """Cross products of vectors along the last axis."""
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        product[..., axis] = (
            left[..., after] * other[..., last] - left[..., last] * other[..., after]
        )


def element_stiffnesses(
    points: Array, elements: Integers, material: Material
) -> Iterator[tuple[slice, Array]]:
    """Yield the stiffness of elements between each two of their nodes, in batches.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    material : Material
        Elastic constants.

    Yields
    ------
    batch : slice
        Which elements.
    stiffness : (b, 55, 3, 3) array
        Forces along three axes (rows) on the first node of each pair of `PAIRS` for displacements
        (columns) of the second. The nodes of an element are taken by ascending numbers [N/m].
    """
    lame, shear = material.lame_constant, material.shear_modulus
    _, gradients, weights = shapes_for_quadrature(QUADRATURE_ORDER)
    order = np.argsort(elements, axis=1)
    for batch in _batches(elements):
        spatial, volumes = physical_gradients(points[elements[batch]], gradients, weights)
        scaled = spatial * np.sqrt(volumes)[:, :, None, None]
        scaled = np.take_along_axis(scaled, order[batch, None, :, None], axis=2)
        scaled = scaled.reshape(*volumes.shape, 30)
        # products[a, i, b, j] = integral of d_i phi_a d_j phi_b
        products = (scaled.transpose(0, 2, 1) @ scaled).reshape(len(volumes), 900)
        stiffness = lame * products.take(_ENTRIES, axis=1)
        stiffness += shear * products.take(_TRANSPOSED, axis=1)
        # What both have on the diagonal is the integral of grad phi_a grad phi_b.
        laplacian = shear * sum(products.take(_ENTRIES[axis::9], axis=1) for axis in (0, 4, 8))
        for axis in (0, 4, 8):
            stiffness[:, axis::9] += laplacian
        yield batch, stiffness.reshape(len(volumes), -1, 3, 3)


def element_masses(
    points: Array, elements: Integers, density: float
) -> Iterator[tuple[slice, Array]]:
    """Yield mass matrices of curved 10-node tetrahedra in batches.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    density : float
        [kg/m^3]

    Yields
    ------
    batch : slice
        Which elements.
    masses : (b, 10, 10) array
        Integral of density times the shape functions of two nodes, the same along each axis [kg].
    """
    values, gradients, weights = shapes_for_quadrature(MASS_QUADRATURE_ORDER)
    products = (values[:, :, None] * values[:, None, :]).reshape(len(weights), 100)
    weighted = density * weights[:, None] * products
    for batch in _batches(elements):
        determinants = np.linalg.det(jacobians(gradients, points[elements[batch]]))
        yield batch, (determinants @ weighted).reshape(-1, 10, 10)


def _batches(elements: Integers) -> Iterator[slice]:
    for start in range(0, len(elements), CHUNK):
        yield slice(start, min(start + CHUNK, len(elements)))


AXES = 3


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """The upper triangle of a symmetric matrix by blocks of 3 x 3, those on the diagonal whole.

    Attributes
    ----------
    shape : tuple of two int
        Rows and columns of blocks.
    indptr, indices : (n + 1,) and (b,) arrays
        Rows and columns of the blocks, as in compressed sparse rows.
    data : (9 b,) array
        Entries block by block, column by column.
    """

    shape: tuple[int, int]
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    data: NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class NodeBlocks:
    """Where the entries of a pattern stand in its blocks.

    Attributes
    ----------
    indptr, indices : arrays
        As in `BlockMatrix`.
    places : (9 b,) array
        Where each entry of the blocks stands among those of the upper triangle.
    """

    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    places: Integers

    def of(self, upper: sparse.csr_array) -> BlockMatrix:
        """Return a matrix of the pattern, given by its upper triangle, by blocks."""
        count = len(self.indptr) - 1
        return BlockMatrix((count, count), self.indptr, self.indices, upper.data[self.places])


def node_blocks(upper: sparse.csr_array) -> NodeBlocks | None:
    """Find the blocks of three axes of an upper triangle.

    Parameters
    ----------
    upper : (m, m) sparse array
        Its columns in ascending order in each row.

    Returns
    -------
    NodeBlocks or None
        None if the pattern is not one of full blocks.
    """
    limits, columns = upper.indptr.astype(np.int64), upper.indices
    if upper.shape[0] % AXES or not columns.size:
        return None
    starts = limits[:-1].reshape(-1, AXES)
    lengths = np.diff(limits).reshape(-1, AXES)
    count = lengths[:, 0] // AXES
    # Below the diagonal, the second row of a node has one entry less than the first, the third two.
    if np.any(lengths != AXES * count[:, None] - np.arange(AXES)) or np.any(count == 0):
        return None
    rows = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(count) - count
    within = AXES * (np.arange(len(rows)) - first[rows])
    # places[b, j, i]: entry of row i and column j, so that columns follow each other.
    row, column = np.arange(AXES), np.arange(AXES)[:, None]
    places = starts[rows][:, None, :] + within[:, None, None] + (column - row)
    below = column < row  # of blocks on the diagonal: the same as above it
    places[first] = np.where(below, places[first].transpose(0, 2, 1), places[first])
    nodes = columns[places[:, 0, 0]] // AXES
    fits = columns[places] == AXES * nodes[:, None, None] + column
    fits[first] |= below
    if not fits.all() or not np.array_equal(nodes[first], np.arange(len(count))):
        return None
    return NodeBlocks(
        np.append(first, len(rows)).astype(np.int32), nodes.astype(np.int32), places.ravel()
    )


def assemble_stiffness(points: Array, elements: Integers, material: Material) -> sparse.csr_array:
    """Assemble the upper triangle of the stiffness matrix.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers of 10-node tetrahedra.
    material : Material
        Elastic constants.

    Returns
    -------
    (3 n, 3 n) sparse array
        Unknown 3 a + i is the displacement of node a along axis i; entries below the diagonal are
        left out because the matrix is symmetric [N/m].
    """
    count = len(points)
    # Blocks of 3 x 3 for pairs of nodes: nine times fewer than entries to be sorted.
    blocks = np.empty((len(elements), PAIRS.shape[1], 3, 3))
    for batch, stiffness in element_stiffnesses(points, elements, material):
        blocks[batch] = stiffness
    rows, columns = np.sort(elements, axis=1)[:, PAIRS].transpose(1, 0, 2)
    keys = (rows * count + columns).ravel()
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    limits = np.append(starts, len(keys))
    gather = sparse.csr_array((np.ones(len(keys)), order, limits), shape=(len(starts), len(keys)))
    sums = gather @ blocks.reshape(-1, 9)
    rows, columns = np.divmod(keys[starts], count)
    limits = np.searchsorted(rows, np.arange(count + 1))
    whole = sparse.bsr_array(
        (sums.reshape(-1, 3, 3), columns.astype(np.int32), limits.astype(np.int32)),
        shape=(3 * count, 3 * count),
    ).tocsr()
    return upper_triangle(whole)


def assemble_mass(points: Array, elements: Integers, density: float) -> sparse.csr_array:
    """Assemble the upper triangle of the consistent mass matrix.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers of 10-node tetrahedra.
    density : float
        [kg/m^3]

    Returns
    -------
    (3 n, 3 n) sparse array
        Unknown 3 a + i is the displacement of node a along axis i, as in
        `assemble_stiffness` [kg].
    """
    first, second = np.triu_indices(10)
    values = np.empty((len(elements), len(first)))
    for batch, masses in element_masses(points, elements, density):
        values[batch] = masses[:, first, second]
    rows = np.minimum(elements[:, first], elements[:, second]).ravel().astype(np.int32)
    columns = np.maximum(elements[:, first], elements[:, second]).ravel().astype(np.int32)
    size = len(points)
    nodal = sparse.coo_array((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    return sparse.csr_array(sparse.kron(nodal, sparse.eye_array(3), format="csr"))


def upper_triangle(matrix: sparse.csr_array) -> sparse.csr_array:
    """Remove the part below the diagonal in the diagonal blocks."""
    lengths = np.diff(matrix.indptr)
    kept = matrix.indices >= np.repeat(np.arange(matrix.shape[0]), lengths)
    limits = np.concatenate([[0], np.cumsum(kept)])[matrix.indptr]
    return sparse.csr_array(
        (matrix.data[kept], matrix.indices[kept], limits.astype(np.int32)), matrix.shape
    )


def symmetric_product(upper: sparse.csr_array, vectors: Array) -> Array:
    """Multiply a symmetric matrix, given by its upper triangle, with vectors (n,) or (n, k)."""
    count, starts = upper.shape[0], upper.indptr[:-1]
    # Mostly each row begins with its entry on the diagonal.
    if np.diff(upper.indptr).all() and np.array_equal(upper.indices[starts], np.arange(count)):
        diagonal = np.asarray(upper.data[starts])
    else:
        diagonal = np.asarray(upper.diagonal())
    scaled = diagonal * vectors if vectors.ndim == 1 else diagonal[:, None] * vectors
    return np.asarray(upper @ vectors + upper.T @ vectors - scaled)


class Stopwatch:
    """Adds up the seconds of named pieces of work.

    Attributes
    ----------
    seconds : dict
        By name, in the order of first use.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def lap(self, name: str) -> Iterator[None]:
        """Measure the time of the block under this name, minus the named times inside it."""
        inside = sum(self.seconds.values())
        self.seconds.setdefault(name, 0.0)
        start = time.perf_counter()
        try:
            yield
        finally:
            named = sum(self.seconds.values()) - inside
            # Times taken elsewhere may be longer than the block, which then took none itself.
            self.seconds[name] += max(0.0, time.perf_counter() - start - named)

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add times measured elsewhere, such as in another process."""
        for name, value in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + value


# Residuals are measured as `residual_shares` does. This is what factors in double precision leave.
ROUND_OFF = 1e-13
# A step that gains less than one digit is the last; what is left then may be no more than this.
LAST = 1e-11
MOST_STEPS = 8


def residual_shares(
    upper: sparse.csr_array, size: float, solution: Array, sides: Array
) -> tuple[Array, Array]:
    """Return b - A x (n, k), and its size relative to b, or to the possible round-off of A x.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of A.
    size : float
        Largest sum of magnitudes in a row of it.
    solution, sides : (n, k) arrays
        x and b.
    """
    residual = sides - symmetric_product(upper, solution)
    of_product = size * np.linalg.norm(solution, axis=0)
    scale = np.maximum(np.linalg.norm(sides, axis=0), 1e-3 * of_product)
    return residual, np.linalg.norm(residual, axis=0) / np.maximum(scale, np.finfo(float).tiny)


def refined_solution(
    upper: sparse.csr_array, size: float, sides: Array, rough: Callable[[Array], Array]
) -> Array | None:
    """Solve A x = b with an approximate solver, repeatedly for the residual.

    Parameters
    ----------
    upper, size, sides
        As for `residual_shares`.
    rough : callable
        Gives approximately x for b; called with right sides of size one.

    Returns
    -------
    (n, k) array or None
        None if the steps do not converge to round-off.
    """
    solution, residual, last = np.zeros(sides.shape), sides, np.inf
    for _ in range(MOST_STEPS):
        largest = np.abs(residual).max(axis=0, initial=0.0)
        largest = np.where(largest > 0.0, largest, 1.0)
        solution = solution + largest * rough(residual / largest)
        residual, shares = residual_shares(upper, size, solution, sides)
        worst = float(shares.max(initial=0.0))
        if worst <= ROUND_OFF:
            return solution
        if not worst <= 0.1 * last:
            return solution if worst <= LAST else None
        last = worst
    return None


# A backward stable solve leaves a residual near round-off; anything above this is a wrong solve.
LARGEST_RESIDUAL = 1e-9
# Supported structures keep their pivots within eight decades of each other; a rigid-body motion left
# free leaves one at round-off.
SMALLEST_PIVOT = 1e-13
SOLVERS = ("pardiso", "superlu")
# Smaller systems are solved by one thread: a second one takes more processor time (a tenth in
# factorizing, four fifths in solving) than it saves.
FOR_ONE_THREAD = 100_000
# Of so many unknowns on single precision saves more than refining takes, with the sides of a whole throw.
SINGLE_FROM = 100_000
# Phases of Pardiso.
ANALYSIS, FACTORIZATION, SOLUTION = 11, 22, 33
# Where pip and conda put MKL. Left alone, pypardiso reads all folders of an environment, twice.
MKL_FILES, MKL_VARIABLE = ("lib/libmkl_rt.*", "Library/bin/mkl_rt*.dll"), "PYPARDISO_MKL_RT"


@dataclass(frozen=True)
class Factorization:
    """A factorized matrix, ready to solve with any number of right sides.

    Attributes
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver : str
        The solver used.
    size : float
        Largest sum of magnitudes in a row of `upper`, which residuals are compared with.
    apply : callable
        Solves without any check.
    """

    upper: sparse.csr_array
    solver: str
    size: float
    apply: Callable[[Array], Array]

    def solve(self, right_sides: Array) -> Array:
        """Solve A x = b and check the residual.

        Parameters
        ----------
        right_sides : (n, k) array

        Returns
        -------
        (n, k) array

        Raises
        ------
        SolveError
            If the residual is not near round-off.
        """
        return self.solve_with_residual(right_sides)[0]

    def solve_with_residual(self, right_sides: Array) -> tuple[Array, Array]:
        """Return x as `solve` does, and b - A x."""
        solution = self.apply(right_sides)
        residual, shares = residual_shares(self.upper, self.size, solution, right_sides)
        if not np.all(shares <= LARGEST_RESIDUAL):
            raise SolveError(
                f"{self.solver} left a relative residual of {np.max(shares):.1e} (allowed "
                f"{LARGEST_RESIDUAL:.0e}): the structure may be insufficiently supported."
            )
        return solution, residual


class SharedSolver:
    """Factorizes matrices one after the other; matrices of one pattern are analyzed once.

    Half of the work of a factorization is to find the order of elimination, which depends on the
    pattern alone. Each factorization ends the one before.

    Parameters
    ----------
    solver : {"auto", "pardiso", "superlu"}
        MKL's Pardiso, or scipy's SuperLU, which needs no MKL and is several times slower. "auto" is
        Pardiso if it can be loaded.
    watch : Stopwatch, optional
        Measures the time.
    few_sides : bool
        Whether each matrix has only a few right sides. Pardiso then factorizes large ones in single
        precision, in little more than half the time, and solutions are refined until their residual is
        that of double precision; if this fails, double precision is used.

    Raises
    ------
    SolveError
        If the solver is missing.
    InputError
        If the solver is unknown.
    """

    def __init__(
        self, solver: str = "auto", watch: Stopwatch | None = None, *, few_sides: bool = True
    ) -> None:
        check_solver(solver)
        self.watch = Stopwatch() if watch is None else watch
        if solver != "superlu":
            with self.watch.lap("loading the solver"):
                installed = _pardiso() is not None
            if not installed and solver == "pardiso":
                raise SolveError(
                    "The solver pardiso is not installed; install it with: pip install pypardiso"
                )
            solver = "pardiso" if installed else "superlu"
        self.solver = solver
        self._pattern: _PardisoPattern | None = None
        self._few_sides = few_sides

    def factorize(self, upper: sparse.csr_array) -> Factorization:
        """Factorize a symmetric positive definite matrix.

        Parameters
        ----------
        upper : (n, n) sparse array
            Upper triangle of the matrix, explicit zeros included if they belong to the pattern.

        Raises
        ------
        SolveError
            If the matrix is singular.
        """
        with self.watch.lap("factorization"):
            size = float(abs(upper).sum(axis=1).max())
            if self.solver == "superlu":
                apply = _superlu(upper)
            elif self._few_sides and len(upper.indptr) > SINGLE_FROM:
                apply = self._in_single(upper, size)
            else:
                apply = self._with_pardiso(upper, single=False)
        return Factorization(upper, self.solver, size, apply)

    def _with_pardiso(self, upper: sparse.csr_array, *, single: bool) -> Callable[[Array], Array]:
        if self._pattern is None or not self._pattern.fits(upper, single):
            self.close()
            self._pattern = _PardisoPattern(upper, single)
        return self._pattern.factorize(upper)

    def _in_single(self, upper: sparse.csr_array, size: float) -> Callable[[Array], Array]:
        """Factorize in single precision; return the function that solves and refines, if needed in double."""
        try:
            rough = self._with_pardiso(upper, single=True)
        except SolveError:  # not positive definite but for round-off, perhaps
            self._few_sides = False
            return self._with_pardiso(upper, single=False)
        exact: Callable[[Array], Array] | None = None

        def apply(sides: Array) -> Array:
            nonlocal exact
            if exact is None:
                solution = refined_solution(upper, size, sides, rough)
                if solution is not None:
                    return solution
                self._few_sides = False  # nor will it do for the next matrices
                exact = self._with_pardiso(upper, single=False)
            return exact(sides)

        return apply

    def close(self) -> None:
        """Free the memory of the factors."""
        if self._pattern is not None:
            self._pattern.free()
            self._pattern = None


@contextmanager
def factorize(upper: sparse.csr_array, solver: str = "auto") -> Iterator[Factorization]:
    """Factorize a symmetric positive definite matrix; its memory is freed at the end of the block.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver
        As for `SharedSolver`, which also says what is raised.

    Yields
    ------
    Factorization

    Raises
    ------
    SolveError
        If the matrix is singular.
    """
    shared = SharedSolver(solver, few_sides=False)
    try:
        yield shared.factorize(upper)
    finally:
        shared.close()


def check_solver(solver: str) -> None:
    """Refuse a solver of another name."""
    if solver not in ("auto", *SOLVERS):
        raise InputError(f"solver: given {solver!r}; allowed are auto, {', '.join(SOLVERS)}.")


@cache
def _pardiso() -> Any:
    """Load Pardiso once; None if it is not available."""
    for file in (path for pattern in MKL_FILES for path in Path(sys.prefix).glob(pattern)):
        os.environ.setdefault(MKL_VARIABLE, str(file))
    try:
        from pypardiso import PyPardisoSolver

        return PyPardisoSolver(mtype=2)
    except (ImportError, OSError):
        return None


class _PardisoPattern:
    """Pardiso's analysis of a pattern, and the factors of the last matrix that had it.

    In single precision, if wanted: right sides are then to be of size one.
    """

    def __init__(self, upper: sparse.csr_array, single: bool) -> None:
        self._solver = copy.copy(_pardiso())
        self._solver.pt = np.zeros_like(self._solver.pt)
        self._solver.iparm = np.zeros_like(self._solver.iparm)
        # With its own defaults it solves two to three times more slowly. Order 2 is nested dissection.
        self._solver.set_iparm(1, 1)
        self._solver.set_iparm(2, 2)
        self._single, self._kind = single, np.float32 if single else np.float64
        self._solver.set_iparm(28, int(single))
        self._count = 0
        self._indptr, self._indices = upper.indptr.copy(), upper.indices.copy()
        self._blocks = node_blocks(upper)
        if self._blocks is not None:
            self._solver.set_iparm(37, AXES)
        # Also when nobody closes it.
        self._finalizer = weakref.finalize(self, self._solver.free_memory, everything=True)
        self._run(ANALYSIS, self._stored(upper)[0], np.zeros((upper.shape[0], 1)))

    def fits(self, upper: sparse.csr_array, single: bool) -> bool:
        """Whether a matrix has this pattern, and the required precision."""
        return (
            single == self._single
            and np.array_equal(self._indptr, upper.indptr)
            and np.array_equal(self._indices, upper.indices)
        )

    def factorize(self, upper: sparse.csr_array) -> Callable[[Array], Array]:
        """Factorize a matrix of this pattern; give what solves with it."""
        matrix, size = self._stored(upper)
        self._run(FACTORIZATION, matrix, np.zeros((upper.shape[0], 1)))
        self._count += 1
        count = self._count

        def apply(sides: Array) -> Array:
            if count != self._count:
                raise SolveError("these factors were replaced by those of a later matrix.")
            return self._run(SOLUTION, matrix, sides) / size

        return apply

    def free(self) -> None:
        self._finalizer()

    def _stored(self, upper: sparse.csr_array) -> "tuple[sparse.csr_array | BlockMatrix, float]":
        """Return the matrix for Pardiso, divided by a number, and this number."""
        size = 1.0
        if self._single:
            # Single precision has a narrow range: the largest entry is made one.
            size = float(np.abs(upper.data).max(initial=0.0)) or 1.0
            entries = (upper.data / size).astype(self._kind)
            upper = sparse.csr_array((entries, upper.indices, upper.indptr), upper.shape)
        return upper if self._blocks is None else self._blocks.of(upper), size

    def _run(self, phase: int, matrix: "sparse.csr_array | BlockMatrix", sides: Array) -> Array:
        if not self._finalizer.alive:
            raise SolveError("the factors were freed before the last solve.")
        self._solver.set_phase(phase)
        small = len(sides) < FOR_ONE_THREAD
        try:
            with _one_thread(self._solver.libmkl) if small else nullcontext():
                sides = np.asfortranarray(sides, dtype=self._kind)
                return np.asarray(self._solver._call_pardiso(matrix, sides), dtype=np.float64)
        except Exception as error:  # pypardiso's own kinds; not positive definite is number -4
            raise SolveError(f"Pardiso could not solve the system: {error}") from error


@contextmanager
def _one_thread(mkl: Any) -> Iterator[None]:
    """Let MKL calculate with one thread where this thread calls it."""
    before = mkl.MKL_Set_Num_Threads_Local(1)
    try:
        yield
    finally:
        mkl.MKL_Set_Num_Threads_Local(before)


def _superlu(upper: sparse.csr_array) -> Callable[[Array], Array]:
    """Factorize with SuperLU; give what solves with the factors."""
    from scipy.sparse.linalg import splu  # here: Pardiso does without

    full = upper + sparse.triu(upper, k=1).T
    try:
        factors = splu(
            sparse.csc_matrix(full),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise SolveError(f"SuperLU could not solve the system: {error}") from error
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() <= SMALLEST_PIVOT * pivots.max():
        raise SolveError(
            "SuperLU met a vanishing pivot: the structure is insufficiently supported."
        )
    return lambda sides: np.asarray(factors.solve(sides))


# Every solution leaves at most 1e-9 of its right side; what is checked is made of a few solutions.
LARGEST_ROUND_OFF = 1e-8
# Energies against forces at the ends: throws of engines leave 1e-11, journals of 0.04 crank radii 1e-8.
LARGEST_DIFFERENCE = 1e-6
# The softest elastic motion of a throw has 1e-2 of the energy of the stiffest, of sections that bend 1e-4.
SMALLEST_ENERGY = 1e-7
RIGID_MOTIONS = 6


def rigid_body_motions(count: int) -> Array:
    """Return the rigid-body motions (count, 6) of two end sections, rotations as length x angle.

    `count` is 12, or 12 + 2 b where sections bend; then these do not.
    """
    motions = np.zeros((count, RIGID_MOTIONS))
    motions[:6], motions[6:12] = np.eye(6), np.eye(6)
    # Turned about x or y through the left end section, the right one is carried along.
    motions[6, 4], motions[7, 3] = 1.0, -1.0
    return motions


def scaled_stiffness(stiffness: ArrayLike, length: float) -> Array:
    """Return a stiffness (n, n) in N/m alone, with rotations measured as length x angle."""
    matrix = np.asarray(stiffness, dtype=float)
    size = _sizes(len(matrix), length)
    return matrix * np.outer(size, size)


def rigid_body_residual(stiffness: ArrayLike, length: float) -> float:
    """Return the largest force caused by a rigid-body motion, relative to the largest stiffness.

    Parameters
    ----------
    stiffness : (12, 12) array
        ux uy uz rx ry rz of the left, then the right end section [SI]; more rows if sections bend.
    length : float
        Between the end sections [m].
    """
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled @ rigid_body_motions(len(scaled)))) / np.max(np.abs(scaled)))


def asymmetry(stiffness: ArrayLike, length: float) -> float:
    """Return the largest difference between K and its transpose, relative to the largest stiffness."""
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled - scaled.T)) / np.max(np.abs(scaled)))


def check_reciprocity(
    ends: Array, stiffness: tuple[Array, Array], pin_loads: tuple[Array, Array], length: float
) -> None:
    """Refuse a solved symmetry class with different results for stiffness and pin loads in two ways.

    Energies of fields and forces on the end sections come from different solutions, equal by reciprocity
    as far as these are in equilibrium.

    Parameters
    ----------
    ends : (2 n, k) array
        Motions of both end sections for unit amplitudes.
    stiffness : two (k, k) arrays
        By energies, and by the forces on the end sections.
    pin_loads : two (pins, k, 6) arrays
        By work on the pins, and by reactions at the end sections.
    length : float
        Of the throw [m].

    Raises
    ------
    SolveError
    """
    turns = np.abs(ends[[3, 4, 5, 9, 10, 11]]).any(axis=0)
    size = np.where(turns, 1.0 / length, 1.0)
    energies, forces = (pair * np.outer(size, size) for pair in stiffness)
    works, reactions = (pair * size[:, None] * _unit(length) for pair in pin_loads)
    apart = np.max(np.abs(forces - energies)) / np.max(np.abs(energies))
    off = np.max(np.abs(reactions - works), initial=0.0)
    _check(
        "Reciprocity of the throw's end forces is off by",
        float(np.maximum(apart, off)),
        LARGEST_DIFFERENCE,
    )


def check_superelement(
    stiffness: Array, pin_loads: Array, length: float, pin_centers: Sequence[Array]
) -> None:
    """Refuse a superelement that is not a free elastic body, or whose reactions do not balance a load.

    Parameters
    ----------
    stiffness, pin_loads
        As of a `fem.superelement.Superelement`.
    length : float
        Between the end sections [m].
    pin_centers : sequence of (3,) arrays
        About which moments on the pins are given [m].

    Raises
    ------
    SolveError
        If the stiffness is not finite and symmetric, resists a rigid motion or does not resist another, or
        if forces and moments on the ends do not balance a unit load on a pin.
    """
    _check("The throw's stiffness is unsymmetric by", asymmetry(stiffness, length))
    _check("Rigid motions of the throw meet forces of", rigid_body_residual(stiffness, length))
    energies = strain_energies(stiffness, length)
    softest = float(energies[RIGID_MOTIONS])
    if not softest >= SMALLEST_ENERGY:
        raise SolveError(
            f"The softest elastic motion of the throw has {softest:.1e} of the strain energy of the stiffest "
            f"(allowed {SMALLEST_ENERGY:.0e} or more): its stiffness is not positive definite."
        )
    _check(
        "Reactions of the throw leave an unbalanced share of a pin's load of",
        unbalanced_pin_loads(pin_loads, length, pin_centers),
    )


def strain_energies(stiffness: ArrayLike, length: float) -> Array:
    """Strain energies (n,) of unit motions along the principal axes of K, ascending, the largest 1.

    The first six are those of rigid motions.
    """
    scaled = scaled_stiffness(stiffness, length)
    energies = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return np.asarray(energies / energies[-1])


def unbalanced_pin_loads(pin_loads: Array, length: float, pin_centers: Sequence[Array]) -> float:
    """Largest difference of the end loads of a unit load on a pin from its force or moment, as a share.

    In a rigid motion the end loads must do the work of the load itself.
    """
    count, unit = pin_loads.shape[1], _unit(length)
    motions = rigid_body_motions(count)
    left = [0.0]
    for loads, center in zip(pin_loads, pin_centers, strict=True):
        at_pin = np.zeros((6, 6))
        at_pin[:3] = rigid_motions(np.asarray(center)[None])[0] * unit
        at_pin[3:, 3:] = np.diag(unit[3:])
        work = (loads * _sizes(count, length)[:, None]).T @ motions
        left.append(float(np.max(np.abs((work - at_pin) / unit[:, None]))))
    return float(np.max(left))


def _sizes(count: int, length: float) -> Array:
    """Sizes (count,) of unit motions of both ends: rotations times length are 1."""
    return np.concatenate([np.tile(_unit(length), 2), np.ones(count - 12)])


def _unit(length: float) -> Array:
    return np.array([1.0, 1.0, 1.0, *[1.0 / length] * 3])


def _check(what: str, figure: float, allowed: float = LARGEST_ROUND_OFF) -> None:
    if not figure <= allowed:
        raise SolveError(
            f"{what} {figure:.1e} (allowed {allowed:.0e}): the equations are not solved accurately."
        )
