"""A solved throw's superelement: corrected, uncorrected, with other sections, and its errors."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fem.axial_analysis import SolvedThrow
from fem.condensation import CondensedClass
from fem.correction import error_bars
from fem.section_motions import RIGID, Sections
from fem.superelement import Superelement, combine_classes
from fem.supports import Neighbors, Support, SupportedThrow, support_throw

# An entry so small beside those on the diagonal is round-off.
VANISHING = 1e-9
# Steps of the cranks [deg] between which a throw of equal webs and rigid sections is guided or pinned.
IN_LINE, OPPOSITE = 0.0, 180.0


def axial_correction(corrected: Superelement, discrete: Superelement) -> float:
    """Share of the axial compliance, pinned, that is correction: how coarse the mesh is."""
    return 1.0 - support_throw(discrete, "pinned").axial / support_throw(corrected, "pinned").axial


def supported_errors(
    corrected: Superelement, discrete: Superelement, support: Support
) -> SupportedThrow:
    """Estimated errors of the compliances under a support, in their units; see `error_bars`."""
    here, mesh = support_throw(corrected, support), support_throw(discrete, support)
    coarse, missing = axial_correction(corrected, discrete), corrected.missing
    return SupportedThrow(
        axial=float(error_bars(here.axial, mesh.axial, coarse, missing=missing)),
        torsional=float(error_bars(here.torsional, mesh.torsional, coarse, missing=missing)),
        stretches=error_bars(here.stretches, mesh.stretches, coarse, missing=missing),
        influences=error_bars(here.influences, mesh.influences, coarse, missing=missing),
    )


def section_errors(throw: Superelement, support: Support) -> SupportedThrow:
    """Effect of rigid sections on a throw's compliances, in their units; see `ThrowAnalysis`."""
    step = IN_LINE if support == "guided" else OPPOSITE
    where = support if isinstance(support, Neighbors) else Neighbors(step, step)
    bending = support_throw(throw, where)
    rigid = support_throw(replace(throw, bending=None), where)
    return SupportedThrow(
        axial=bending.axial - rigid.axial,
        torsional=bending.torsional - rigid.torsional,
        stretches=bending.stretches - rigid.stretches,
        influences=bending.influences - rigid.influences,
    )


def stiffness_errors(corrected: Superelement, discrete: Superelement) -> NDArray[np.float64]:
    """Estimated errors (12, 12) of the entries of the stiffness [SI]; see `error_bars`.

    The size of an entry is half of the geometric mean of the corresponding diagonal entries; entries that
    vanish by symmetry have no error.
    """
    stiffness, coarse = corrected.stiffness, axial_correction(corrected, discrete)
    diagonal = np.sqrt(np.diag(stiffness))
    sizes = 0.5 * np.outer(diagonal, diagonal)
    bars = error_bars(stiffness, discrete.stiffness, coarse, sizes, corrected.missing)
    return np.where(np.abs(stiffness) > VANISHING * sizes, bars, 0.0)


@dataclass(frozen=True, kw_only=True)
class SolvedSuperelement(SolvedThrow):
    """A throw solved for all motions of its end sections.

    Attributes
    ----------
    superelement : Superelement
    classes : tuple of CondensedClass
        The solved symmetry classes with their displacement fields.
    """

    superelement: Superelement
    classes: tuple[CondensedClass, ...] = field(repr=False)

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness (12, 12): ux uy uz rx ry rz of the left, then the right end section [SI]."""
        return self.superelement.stiffness

    @property
    def discrete(self) -> Self:
        """The same throw without correction: for comparisons on one mesh."""
        classes = tuple(one.discrete or one for one in self.classes)
        plain = combine_classes(classes, self.superelement.radials)
        taken = axial_correction(self.superelement, plain)
        return replace(self, classes=classes, superelement=plain, error_estimate=taken)

    @property
    def corrected(self) -> bool:
        """Whether results are corrected for discretization: not if the correction would be too large."""
        return all(one.discrete is not None for one in self.classes)

    @property
    def stiffness_error(self) -> NDArray[np.float64]:
        """Estimated errors (12, 12) of the entries of the stiffness [SI]."""
        return stiffness_errors(self.superelement, self.discrete.superelement)

    def section_errors(self, support: Support = "pinned") -> SupportedThrow:
        """Effect of rigid sections on compliances under a support, in their units, on the same mesh.

        Compliances between equal neighbors with bending sections, minus those with rigid ones; for pinned
        ends between opposite cranks, for guided ones between cranks in line, where rigid sections with equal
        webs give the same results. Zero if the throw was solved with rigid sections alone.
        """
        return section_errors(self.superelement, support)

    @property
    def section_error(self) -> float:
        """Effect of rigid sections on the axial compliance (pinned), as a share of it."""
        return self.section_errors().axial / support_throw(self.superelement, "pinned").axial

    def error_bars(self, support: Support = "pinned") -> SupportedThrow:
        """Estimated errors of compliances under a support, in their units (docs/accuracy.md)."""
        return supported_errors(self.superelement, self.discrete.superelement, support)

    @property
    def solver(self) -> str:
        """The equation solver used."""
        return self.classes[0].solver

    @property
    def end_sections(self) -> str:
        """Allowed motion of the end sections: "rigid" or "averaged"."""
        return self.classes[0].end_sections

    @property
    def sections(self) -> Sections:
        """Section motions where throws meet: "rigid", or polynomials of degree 1, 2 or 4."""
        return self.superelement.joined.sections.sections

    def with_sections(self, sections: Sections) -> Self:
        """Return the same throw with polynomials of a lower degree, or rigid sections, where throws meet.

        Raises
        ------
        InputError
            If the degree is higher than that of the solution.
        """
        kept = self.superelement.joined.sections.up_to(sections)
        classes = tuple(one.up_to(kept if kept.bending else RIGID) for one in self.classes)
        return replace(
            self, classes=classes, superelement=self.superelement.with_sections(sections)
        )
