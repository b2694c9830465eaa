"""The throw as a dynamic superelement: motions of its end sections and internal shapes.

A throw's displacement is composed of the static fields for unit motions of its end sections (Guyan's
condensation) and of shapes with the end sections held, of which the lowest natural modes are the most
important (R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal
6, 1313-1319, 1968). The static fields do no work on the shapes, so stiffness falls into blocks; mass
couples them. Guyan's fields alone give the inertia of rigid motions exactly, that of others too small,
and so frequencies too high.

The modes left out still yield, like springs, to the inertia forces of moving end sections.
Their static response to these forces is one more shape for each motion (the residual modes of J.-G. Kim,
P.-S. Lee, An enhanced Craig-Bampton method, Int. J. Numer. Meth. Engng 103, 79-93, 2015, here with
amplitudes of their own). It takes the error from the second to the fourth power of the frequency
relative to the lowest mode left out.
"""

import math
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from crankbase.checks.scalars import is_number, whole_within
from crankbase.drawing.diagram_style import GRAY, new_axes
from crankbase.errors import InputError, quoted
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from fem.assembly import symmetric_product
from fem.class_modes import PartMatrices, check_resolved, class_problem, frequencies_of
from fem.condensation import CondensedClass
from fem.fixed_interface_shapes import shapes_of_class, shapes_of_throw
from fem.material import Material
from fem.plots.over_angle import draw_frequencies
from fem.section_motions import RIGID, SectionMotions, both_ends, section_turn
from fem.solver import SharedSolver
from fem.symmetry import SymmetryClass, symmetry_classes
from geometry.mesh import ThrowMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Natural modes are kept up to this multiple of the highest frequency of interest. Frequencies of shafts
# of three to six throws, free or in bearings, are then within 0.05 % of their limit up to that
# frequency, whether it lies below the throw's first natural mode or at three times it (three throws;
# without corrections the same takes a multiple of 6 or more, and a multiple of 2 leaves 5 %).
CUTOFF_FACTOR = 1.5


@summarized("frequencies [Hz]", "stiffness", "highest_frequency [Hz]")
@dataclass(frozen=True)
class DynamicSuperelement:
    """A throw condensed to 2 n motions of its end sections and m amplitudes of internal shapes.

    Attributes
    ----------
    stiffness, mass : (2 n + m, 2 n + m) array
        Unknowns ux uy uz rx ry rz of the left, then of the right end section, in the throw frame (or
        that of the shaft, once turned); amplitudes of the bending of the left, then the right section
        [m], if sections bend; then the amplitudes of the shapes [sqrt(kg) m].
    pin_loads : (pins, 2 n + m, 6) array
        Loads on these unknowns equivalent to unit forces along x, y, z on each pin, and unit moments
        about them at its center.
    frequencies : (m,) array
        Of the shapes, with the end sections held [Hz]: natural modes ascending, then corrections.
    natural : int
        Number of natural modes among them.
    symmetries : tuple of m SymmetryClass
        The class of each shape.
    shapes : (n, 3, m) array
        Displacement of the meshed part's nodes in the throw frame, zero at the end sections; of unit
        modal mass of the whole throw, and orthogonal to each other [1/sqrt(kg)].
    highest_frequency : float
        Highest frequency of the superelement [Hz].
    cutoff_factor : float
        Natural modes were kept up to this multiple of it.
    solver : str
        The equation solver used.
    sections : SectionMotions
        The n motions of an end section.
    """

    stiffness: Array
    mass: Array
    pin_loads: Array
    frequencies: Array
    natural: int
    symmetries: tuple[SymmetryClass, ...]
    shapes: Array = field(repr=False)
    highest_frequency: float
    cutoff_factor: float
    solver: str
    sections: SectionMotions = RIGID

    def turned(self, *, angle_deg: float) -> "DynamicSuperelement":
        """Return the superelement of the throw turned by an angle [deg] about the shaft, +z.

        The end motions are then in the shaft frame; pin loads stay in the frame of the throw.
        """
        return self._changed(section_turn(self.sections, math.radians(angle_deg)))

    def bending_turned(self, *, angle_deg: float) -> "DynamicSuperelement":
        """Return it with the sections' bending, and only that, in a turned frame."""
        turn = section_turn(self.sections, math.radians(angle_deg))
        return self._changed(block_diag(np.eye(12), turn[12:, 12:]))

    def shared_with(self, sections: SectionMotions) -> "DynamicSuperelement":
        """Return it in section motions over another ring; see `Superelement.shared_with`."""
        if sections == self.sections:
            return self
        own = both_ends(self.sections.amplitudes_of(sections))
        return replace(self._changed(own.T), sections=sections)

    def _changed(self, ends: Array) -> "DynamicSuperelement":
        """Return it with other motions of the end sections, matrix (2 n, 2 n)."""
        change = block_diag(ends, np.eye(len(self.frequencies)))
        return replace(
            self,
            stiffness=change @ self.stiffness @ change.T,
            mass=change @ self.mass @ change.T,
            pin_loads=change @ self.pin_loads,
        )

    def with_modes(self, count: int) -> "DynamicSuperelement":
        """Return Craig's and Bampton's superelement of the lowest natural modes; of none, Guyan's.

        Corrections are left out.

        Raises
        ------
        InputError
            If it has fewer natural modes.
        """
        whole_within("count", count, 0, self.natural, "the superelement has no more natural modes")
        kept = slice(0, 2 * self.sections.count + count)
        return replace(
            self,
            stiffness=self.stiffness[kept, kept],
            mass=self.mass[kept, kept],
            pin_loads=self.pin_loads[:, kept],
            frequencies=self.frequencies[:count],
            natural=count,
            symmetries=self.symmetries[:count],
            shapes=self.shapes[:, :, :count],
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kind of each shape: "natural mode" or "correction"."""
        corrections = len(self.frequencies) - self.natural
        return ("natural mode",) * self.natural + ("correction",) * corrections

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the frequencies of the shapes, with the highest frequency of the superelement.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        draw_frequencies(
            axes, self.frequencies, self.kinds, "Shapes of the throw with its end sections held"
        )
        axes.axhline(self.highest_frequency, color=GRAY, linestyle="--", label="made for")
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the shapes, numbered from 1.

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
                "shape": (np.arange(1, len(self.frequencies) + 1), ""),
                "frequency": (self.frequencies, "Hz"),
                "kind": (list(self.kinds), ""),
            }
        )


def dynamic_superelement(
    mesh: ThrowMesh,
    material: Material,
    classes: Sequence[CondensedClass],
    highest_frequency: float,
    *,
    cutoff_factor: float = CUTOFF_FACTOR,
    corrections: bool = True,
    solver: str = "auto",
) -> DynamicSuperelement:
    """Build a throw's dynamic superelement from its static condensation.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    material : Material
        That of the condensation.
    classes : sequence of CondensedClass
        All symmetry classes of the part, condensed with rigid end sections or such that bend.
    highest_frequency : float
        Highest frequency of interest [Hz]; 0 for Guyan's superelement, which
        has no shapes.
    cutoff_factor : float
        All natural modes with the end sections held up to this multiple of it are kept, at least 1.
    corrections : bool
        Whether to add the static response of the modes left out, one shape for each end motion.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.

    Returns
    -------
    DynamicSuperelement

    Raises
    ------
    InputError
        If a number is out of range, the classes do not belong to the mesh, or their end sections are
        not rigid.
    SolveError
        If the modes cannot be found.
    """
    if not (is_number(highest_frequency) and highest_frequency >= 0.0):
        raise InputError(
            f"highest_frequency: given {quoted(highest_frequency)}; allowed is a finite frequency from 0 Hz, "
            "because modes are kept in proportion to it."
        )
    if not (is_number(cutoff_factor) and cutoff_factor >= 1.0):
        raise InputError(
            f"cutoff_factor: given {quoted(cutoff_factor)}; allowed is a finite number from 1, because modes "
            "below the highest frequency must not be missing."
        )
    _check_classes(mesh, classes)
    check_resolved(mesh, material, highest_frequency)
    matrices = PartMatrices.of_mesh(mesh, material)
    cutoff = cutoff_factor * highest_frequency
    sections = classes[0].sections
    stiffness, mass = np.zeros((2, 2 * sections.count, 2 * sections.count))
    found = []
    with closing(SharedSolver(solver, few_sides=False)) as shared:
        for part in classes:
            shares, copies = part.shares, part.symmetry.copies
            fields = part.fields.reshape(mesh.unknowns, -1)
            inertia = symmetric_product(matrices.mass, fields)
            stiffness += copies * shares.T @ part.stiffness @ shares
            mass += copies * shares.T @ (fields.T @ inertia) @ shares
            if cutoff > 0.0:
                with class_problem(
                    mesh, matrices, part.symmetry, held_ends=True, solver=shared
                ) as problem:
                    found.append(
                        shapes_of_class(
                            problem, part, matrices.stiffness, inertia, cutoff, corrections
                        )
                    )
    inside = shapes_of_throw(mesh, classes[0], found)
    end_pin_loads = sum(part.shares.T @ part.pin_loads for part in classes)
    count = len(inside.squares)
    mass = np.block([[mass, inside.coupling], [inside.coupling.T, np.eye(count)]])
    return DynamicSuperelement(
        stiffness=block_diag(0.5 * (stiffness + stiffness.T), np.diag(inside.squares)),
        mass=0.5 * (mass + mass.T),
        pin_loads=np.concatenate([end_pin_loads, inside.pin_loads], axis=1),
        frequencies=frequencies_of(inside.squares),
        natural=int(np.count_nonzero(inside.natural)),
        symmetries=inside.symmetries,
        shapes=inside.shapes.reshape(len(mesh.points), 3, count),
        highest_frequency=highest_frequency,
        cutoff_factor=cutoff_factor,
        solver=classes[0].solver,
        sections=sections,
    )


def _check_classes(mesh: ThrowMesh, classes: Sequence[CondensedClass]) -> None:
    """Refuse classes of another mesh, and end sections that are not rigid.

    Raises
    ------
    InputError
    """
    wanted = symmetry_classes(mesh.part)
    if {part.symmetry for part in classes} != set(wanted) or len(classes) != len(wanted):
        raise InputError(
            f"classes: given {len(classes)}; allowed are the {len(wanted)} of a {mesh.part} mesh, each "
            "once, because only all of them together make the throw."
        )
    for part in classes:
        if len(part.fields) != len(mesh.points):
            raise InputError(
                f"classes: given fields at {len(part.fields)} nodes; allowed are the "
                f"{len(mesh.points)} of the mesh, because they must be condensed from it."
            )
        if part.end_sections != "rigid":
            raise InputError(
                f"classes: given {part.end_sections!r} end sections; allowed are rigid ones, because "
                "natural modes with the ends held are computed for these only."
            )
