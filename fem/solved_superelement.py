"""A solved throw's superelement: corrected, uncorrected, with other sections, and its errors."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fem.answer_errors import (
    axial_correction,
    section_errors,
    stiffness_errors,
    supported_errors,
)
from fem.axial_analysis import SolvedThrow
from fem.condensation import CondensedClass
from fem.section_motions import RIGID, Sections
from fem.superelement import Superelement, combine_classes
from fem.supports import Support, SupportedThrow, support_throw


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
