"""Natural modes of an unsupported throw, over all of its symmetry classes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.scalars import is_number, whole_within
from crankbase.drawing.diagram_style import new_axes
from crankbase.errors import InputError, SolveError, quoted
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from fem.class_modes import (
    MOST_MODES,
    ClassModes,
    PartMatrices,
    check_resolved,
    class_problem,
    frequencies_of,
)
from fem.condensation import unit_end_motions
from fem.material import Material
from fem.plots.over_angle import draw_frequencies
from fem.superelement import RX, RY, RZ, UX, UY, UZ
from fem.symmetry import MIRROR_X, MIRROR_Z, SymmetryClass, symmetry_classes
from geometry.mesh import ThrowMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Array = NDArray[np.float64]

# Kinds of motion of an end section, and how a mode is named after them (see `name_of_motion`).
KINDS = {"bending": [UX, UY, RX, RY], "axial": [UZ], "torsion": [RZ]}
EVIDENT = 0.9
PURE = 0.999


def end_motions_of(mesh: ThrowMesh, symmetry: SymmetryClass, shape: Array) -> Array:
    """Motions (12,) of both end sections that best fit a displacement (n, 3) of the meshed part."""
    nodes, motions = zip(*unit_end_motions(mesh, symmetry), strict=True)
    columns = np.concatenate(motions).reshape(-1, symmetry.ends.shape[1])
    fit = np.linalg.lstsq(columns, shape[np.concatenate(nodes)].ravel(), rcond=None)
    return np.asarray(symmetry.ends @ fit[0])


def name_of_motion(motions: Array, length: float) -> str:
    """Describe a mode from the motions of the end sections.

    Rotations count as displacements at a distance of half the throw's length, shares are of the sum of
    squares. Two kinds of motion are named unless one has 90 %; a plane, and a symmetry about the
    throw's middle, only where the motion has nothing else.

    Parameters
    ----------
    motions : (12,) array
        Of the left, then the right end section [m, rad].
    length : float
        Of the throw [m].
    """
    scaled = motions * np.tile([1.0, 1.0, 1.0, *[0.5 * length] * 3], 2)
    total = float(scaled @ scaled)
    if total == 0.0:
        return "end sections at rest"
    squares = (scaled**2).reshape(2, 6).sum(axis=0) / total
    shares = {kind: float(squares[places].sum()) for kind, places in KINDS.items()}
    first, second = sorted(shares, key=lambda kind: shares[kind], reverse=True)[:2]
    name = first if shares[first] >= EVIDENT else f"{first} with {second}"
    for mirrored, symmetric, antisymmetric in (
        (np.tile(MIRROR_X, 2) * scaled, " in the crank plane", " across the crank plane"),
        (np.roll(np.tile(MIRROR_Z, 2) * scaled, 6), ", symmetric", ", antisymmetric"),
    ):
        parity = float(mirrored @ scaled) / total
        if abs(parity) >= PURE:
            name += symmetric if parity > 0.0 else antisymmetric
    return name


# The shift's angular frequency is this share of wave speed / length, the order of a throw's first
# elastic mode; far from it Lanczos takes more steps, with the same result.
SHIFT_SHARE = 0.3
# A motion is one without stiffness if its w^2 is below this share of the shift: rounding leaves 1e-13,
# a bar a hundred times as long as thick bends with 3e-2.
NO_STIFFNESS = 1e-6


@summarized("frequencies [Hz]", "symmetries", "solver")
@dataclass(frozen=True)
class ThrowModes:
    """Elastic modes of an unsupported throw, by ascending frequency.

    Attributes
    ----------
    frequencies : (k,) array
        [Hz]
    symmetries : tuple of k SymmetryClass
        The class of each mode.
    names : tuple of k str
        Description of each mode from its end sections.
    shapes : (n, 3, k) array
        Displacement of the meshed part's nodes, of unit modal mass of the whole throw [1/sqrt(kg)].
    residuals : (k,) array
        Difference of K x and w^2 M x, relative to their size.
    rigid_frequencies : (6,) array
        Frequencies of the rigid motions, nonzero by rounding only [Hz].
    solver : str
        The equation solver used.
    """

    frequencies: Array
    symmetries: tuple[SymmetryClass, ...]
    names: tuple[str, ...]
    shapes: Array = field(repr=False)
    residuals: Array = field(repr=False)
    rigid_frequencies: Array = field(repr=False)
    solver: str

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the frequencies by their number, colored by the kind of motion.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes, width=9.0)
        kinds = [name.partition(",")[0] for name in self.names]
        draw_frequencies(axes, self.frequencies, kinds, "Free modes of the throw")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the modes, numbered from 1.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "mode": (np.arange(1, len(self.frequencies) + 1), ""),
                "frequency": (self.frequencies, "Hz"),
                "name": (list(self.names), ""),
                "residual": (self.residuals, "1"),
            }
        )


def free_modes(
    mesh: ThrowMesh,
    material: Material,
    *,
    count: int | None = None,
    highest_frequency: float | None = None,
    solver: str = "auto",
) -> ThrowModes:
    """Elastic modes of the whole throw, free in space, its end sections free to warp.

    Parameters
    ----------
    mesh : ThrowMesh
        Of the throw or the part of it required by its symmetry; either gives all modes.
    material : Material
    count : int, optional
        Number of modes, 1 to 500, or
    highest_frequency : float, optional
        highest frequency [Hz]; one of the two.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.

    Returns
    -------
    ThrowModes
        Sorted by frequency over all symmetry classes.

    Raises
    ------
    InputError
        If not one of `count` and `highest_frequency` is given, or it is out of range.
    SolveError
        If a mode does not satisfy its equation, or there are not six rigid motions.
    """
    _check_mode_count(count, highest_frequency)
    if highest_frequency is not None:
        check_resolved(mesh, material, highest_frequency)
    matrices = PartMatrices.of_mesh(mesh, material)
    shift = (SHIFT_SHARE / mesh.length) ** 2 * material.youngs_modulus / material.density

    def solve(symmetry: SymmetryClass, elastic: int | None) -> ClassModes:
        with class_problem(mesh, matrices, symmetry, shift=shift, solver=solver) as problem:
            if highest_frequency is not None:
                return problem.up_to(highest_frequency)
            return problem.lowest(rigid_count(symmetry) + (elastic or 0))

    symmetries = symmetry_classes(mesh.part)
    if count is None:
        classes = [solve(symmetry, None) for symmetry in symmetries]
    else:
        classes = _lowest_modes(solve, symmetries, count)
    rigid = _checked_rigid_squares(classes, shift)

    elastic = [modes.part(slice(rigid_count(modes.symmetry), None)) for modes in classes]
    frequencies = np.concatenate([modes.frequencies for modes in elastic])
    order = np.argsort(frequencies, kind="stable")[:count]
    if highest_frequency is not None:
        order = order[frequencies[order] <= highest_frequency]
    owners = [modes.symmetry for modes in elastic for _ in modes.squares]
    chosen = tuple(owners[place] for place in order)
    shapes = np.concatenate([modes.shapes for modes in elastic], axis=2)[:, :, order]
    return ThrowModes(
        frequencies=frequencies[order],
        symmetries=chosen,
        names=tuple(
            name_of_motion(end_motions_of(mesh, symmetry, shapes[:, :, mode]), mesh.length)
            for mode, symmetry in enumerate(chosen)
        ),
        shapes=shapes,
        residuals=np.concatenate([modes.residuals for modes in elastic])[order],
        rigid_frequencies=frequencies_of(np.abs(rigid)),
        solver=classes[0].solver,
    )


def rigid_count(symmetry: SymmetryClass) -> int:
    """How many of the six rigid motions of a throw, about its middle, are of this class."""
    return int(np.count_nonzero(symmetry.central_motions))


def _check_mode_count(count: int | None, highest_frequency: float | None) -> None:
    if (count is None) == (highest_frequency is None):
        raise InputError(
            f"count, highest_frequency: given {quoted(count)} and {quoted(highest_frequency)}; allowed is "
            "one of them, because each alone says how many modes there are."
        )
    if count is not None:
        reason = "higher modes have waves shorter than a throw's details"
        whole_within("count", count, 1, MOST_MODES, reason)
    if highest_frequency is not None and not (
        is_number(highest_frequency) and highest_frequency > 0.0
    ):
        raise InputError(
            f"highest_frequency: given {quoted(highest_frequency)}; allowed is a finite frequency above 0 "
            "Hz, because a free throw has modes of any height."
        )


def _lowest_modes(
    solve: Callable[[SymmetryClass, int], ClassModes],
    symmetries: Sequence[SymmetryClass],
    count: int,
) -> list[ClassModes]:
    """Modes of all classes, so many of each that the `count` lowest elastic ones are among them.

    Each class is first solved for its even share and two more, and again for twice as many if the
    last of them is still below the highest one required.
    """
    wanted = dict.fromkeys(symmetries, min(count, -(-count // len(symmetries)) + 2))
    found = {symmetry: solve(symmetry, number) for symmetry, number in wanted.items()}
    while True:
        elastic = np.concatenate([found[each].squares[rigid_count(each) :] for each in symmetries])
        highest = np.sort(elastic)[count - 1]
        short = [
            each
            for each in symmetries
            if found[each].squares[-1] < highest and wanted[each] < count
        ]
        if not short:
            return list(found.values())
        for each in short:
            wanted[each] = min(count, 2 * wanted[each])
            found[each] = solve(each, wanted[each])


def _checked_rigid_squares(classes: Sequence[ClassModes], shift: float) -> Array:
    """w^2 (6,) of the rigid motions, after a check of their number in each class."""
    stiffless = [np.abs(modes.squares) < NO_STIFFNESS * shift for modes in classes]
    expected = [rigid_count(modes.symmetry) for modes in classes]
    if [int(np.count_nonzero(which)) for which in stiffless] != expected:
        raise SolveError(
            f"The free throw has {sum(int(np.count_nonzero(which)) for which in stiffless)} motions "
            "without stiffness instead of six: its mesh is not in one piece, or not whole."
        )
    return np.concatenate(
        [modes.squares[:number] for modes, number in zip(classes, expected, strict=True)]
    )
