"""A throw's axial compliance alone, from the one symmetry class excited by an axial force."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.summaries import summarized
from fem.condensation import CondensedClass
from fem.loads import RADIAL
from fem.material import Material
from fem.supports import STRETCH, TWIST, free_motions
from fem.throw_frames import compliance_table
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw


def class_axial_compliances(part: CondensedClass, support: str) -> tuple[float, float]:
    """Axial compliance e_n and influence coefficient c of the first pin, both [m/N].

    Parameters
    ----------
    part : CondensedClass
        The meshed part's `fem.symmetry.axial_class`.
    support : {"pinned", "guided"}
    """
    pull = STRETCH @ part.symmetry.ends
    lengthening = axial_motion(part, support)
    return float(lengthening @ pull), float(lengthening @ part.pin_loads[0, :, :3] @ RADIAL)


def axial_motion(part: CondensedClass, support: str) -> NDArray[np.float64]:
    """Amplitudes (k,) of the class under a unit axial force; arguments as for `class_axial_compliances`."""
    return unit_response(part, support, STRETCH @ part.symmetry.ends)


def class_torsional_compliance(part: CondensedClass, support: str) -> float:
    """Torsional compliance [rad/(N m)] from the meshed part's `fem.symmetry.torsional_class`."""
    torque = TWIST @ part.symmetry.ends
    return float(unit_response(part, support, torque) @ torque)


def unit_response(
    part: CondensedClass, support: str, load: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Amplitudes (k,) of the supported class under a load (k,) that does work on its unit motions.

    Multiplied with a second load they are, by reciprocity, also the motion of the first one under that.
    """
    free = free_motions(part.symmetry.ends, support)
    stiffness = part.symmetry.copies * part.stiffness[np.ix_(free, free)]
    amplitudes = np.zeros(len(load))
    amplitudes[free] = np.linalg.solve(stiffness, load[free])
    return amplitudes


@dataclass(frozen=True, kw_only=True)
class SolvedThrow:
    """A throw solved on a mesh that was refined until the axial compliance is accurate enough.

    Attributes
    ----------
    throw : CrankThrow or ImportedThrow
    material : Material
    mesh : ThrowMesh
        Mesh of the part of the throw that was solved.
    error_estimate : float
        Estimated relative error of the axial compliance (pinned) after correction
        (`fem.correction`).
    accuracy : float
        The requested accuracy.
    seconds : mapping
        Time of each step, by name.
    """

    throw: Throw
    material: Material
    mesh: ThrowMesh
    error_estimate: float
    accuracy: float
    seconds: Mapping[str, float] = field(default_factory=dict, repr=False)

    @property
    def accuracy_met(self) -> bool:
        """Whether the error estimate is within the requested accuracy."""
        return self.error_estimate <= self.accuracy


@summarized(
    "axial_compliance [m/N]",
    "influence_coefficient [m/N]",
    "error_estimate",
    "accuracy",
    "mesh.unknowns",
)
@dataclass(frozen=True, kw_only=True)
class AxialAnalysis(SolvedThrow):
    """A throw's axial compliance alone, several times cheaper than the whole analysis.

    Attributes
    ----------
    part : CondensedClass
        The symmetry class excited by an axial force.
    """

    part: CondensedClass = field(repr=False)

    def axial_compliance(self, support: str = "pinned") -> float:
        """Axial compliance e_n [m/N]; `support` is "pinned" or "guided".

        Raises
        ------
        InputError
            If the support is neither; between neighbors every class is needed, see `analyze_throw`.
        """
        return class_axial_compliances(self.part, _class_support(support))[0]

    def influence_coefficient(self, support: str = "pinned") -> float:
        """Influence coefficient c of the first pin [m/N]; support and errors as for e_n."""
        return class_axial_compliances(self.part, _class_support(support))[1]

    @property
    def discrete(self) -> "AxialAnalysis":
        """The same without correction: for comparisons on one mesh."""
        plain = replace(self, part=self.part.discrete or self.part)
        taken = 1.0 - plain.axial_compliance() / self.axial_compliance()
        return replace(plain, error_estimate=taken)

    def to_pandas(self) -> Any:
        """Return a table of compliance and influence coefficient by support.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return compliance_table(
            ("pinned", "guided"),
            axial_compliance=self.axial_compliance,
            influence_coefficient=self.influence_coefficient,
        )


def _class_support(support: str) -> str:
    if support not in ("pinned", "guided"):
        raise InputError(
            f'support: given {support!r}; allowed are "pinned" and "guided", because other supports need the '
            "whole analysis (analyze_throw)."
        )
    return support
