"""A throw's elastic and mass properties from one superelement: the result of `analyze_throw`."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from fem.angle_law import AngleLaw, angle_law, compliance, compliance_over_angle
from fem.condensation import CondensedClass
from fem.correction import error_bars
from fem.craig_bampton import DynamicSuperelement, dynamic_superelement
from fem.end_reactions import (
    Reactions,
    compliance_table,
    stiffness_table,
    supported_table,
    throw_grid,
)
from fem.loads import Distribution
from fem.material import Material
from fem.modes import ThrowModes, free_modes
from fem.plots import ANGLES_DEG, LABELS, Compliance, check_compliance, plot_compliance
from fem.superelement import Superelement, combine_classes
from fem.supports import (
    STRETCH,
    TABLE_SUPPORTS,
    Neighbors,
    PinResponse,
    Support,
    SupportedThrow,
    checked_pin,
    checked_vector,
    class_axial_compliances,
    end_load,
    end_motions,
    pin_compliance,
    pin_motion,
    pin_response,
    reactions,
    support_throw,
)
from fem.symmetry import RIGID, Sections
from geometry.mass import MassProperties
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, kw_only=True)
class SolvedThrow:
    """A throw solved on a mesh that was refined until the axial compliance is accurate enough.

    Attributes
    ----------
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


# An entry so small beside those on the diagonal is round-off.
VANISHING = 1e-9
# Steps of the cranks [deg] between which a throw of equal webs and rigid sections is guided or pinned.
IN_LINE, OPPOSITE = 0.0, 180.0


def axial_correction(corrected: Superelement, discrete: Superelement) -> float:
    """Share of the axial compliance, pinned, that is correction: how coarse the mesh is."""
    return 1.0 - support_throw(discrete, "pinned").axial / support_throw(corrected, "pinned").axial


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
        classes = tuple(part.discrete or part for part in self.classes)
        plain = combine_classes(classes, self.superelement.radials)
        taken = axial_correction(self.superelement, plain)
        return replace(self, classes=classes, superelement=plain, error_estimate=taken)

    @property
    def corrected(self) -> bool:
        """Whether results are corrected for discretization: not if the correction would be too large."""
        return all(part.discrete is not None for part in self.classes)

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
        step = IN_LINE if support == "guided" else OPPOSITE
        where = support if isinstance(support, Neighbors) else Neighbors(step, step)
        bending = support_throw(self.superelement, where)
        rigid = support_throw(replace(self.superelement, bending=None), where)
        return SupportedThrow(
            **{name: value - getattr(rigid, name) for name, value in vars(bending).items()}
        )

    @property
    def section_error(self) -> float:
        """Effect of rigid sections on the axial compliance (pinned), as a share of it."""
        return self.section_errors().axial / support_throw(self.superelement, "pinned").axial

    def error_bars(self, support: Support = "pinned") -> SupportedThrow:
        """Estimated errors of compliances under a support, in their units (docs/accuracy.md)."""
        plain = self.discrete.superelement
        coarse = axial_correction(self.superelement, plain)
        missing = self.superelement.missing
        discrete = support_throw(plain, support)
        bars = {
            name: error_bars(value, getattr(discrete, name), coarse, missing=missing)
            for name, value in vars(support_throw(self.superelement, support)).items()
        }
        return SupportedThrow(
            axial=float(bars.pop("axial")), torsional=float(bars.pop("torsional")), **bars
        )

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
        classes = tuple(part.up_to(kept if kept.bending else RIGID) for part in self.classes)
        return replace(
            self, classes=classes, superelement=self.superelement.with_sections(sections)
        )


NO_FORCE = (0.0, 0.0, 0.0)


@summarized(
    "axial_compliance [m/N]",
    "torsional_compliance [rad/(N m)]",
    "influence_coefficient [m/N]",
    "mass [kg]",
    "error_estimate",
    "accuracy",
    "mesh.unknowns",
)
@dataclass(frozen=True, kw_only=True)
class ThrowAnalysis(SolvedSuperelement):
    """A throw's elastic and mass properties, from one mesh and one superelement.

    Attributes
    ----------
    throw, material, mesh, error_estimate, accuracy, seconds
        Input and accuracy, as of an `AxialAnalysis`.
    classes : tuple of CondensedClass
        The solved symmetry classes with their displacement fields.
    """

    masses: MassProperties

    @property
    def mass(self) -> float:
        """Mass of the throw [kg]."""
        return self.masses.mass

    @property
    def center_of_mass(self) -> NDArray[np.float64]:
        """Center of mass (3,) in the throw frame [m]."""
        return self.masses.center

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Inertia tensor (3, 3) about the center of mass [kg m^2]."""
        return self.masses.inertia

    def supported(self, support: Support = "pinned") -> SupportedThrow:
        """All compliances under one support."""
        return support_throw(self.superelement, support)

    @property
    def angle_law(self) -> AngleLaw:
        """Compliance and influence coefficient over the angle to equal neighbors by three numbers.

        Raises
        ------
        InputError
            If the throw's webs are not equal: for others use ``support=Neighbors(...)``.
        """
        return angle_law(self.superelement)

    def axial_compliance(self, support: Support = "pinned") -> float:
        """Axial compliance e_n: lengthening per unit axial force [m/N].

        Parameters
        ----------
        support : "pinned", "guided" or Neighbors
            ``pinned``: end sections stay on the axis and tilt freely; ``guided``: they do not tilt;
            ``Neighbors(left_deg, right_deg)``: between identical throws.

        Raises
        ------
        InputError
            If the support is unknown.
        """
        return self.supported(support).axial

    def torsional_compliance(self, support: Support = "pinned") -> float:
        """Twist per unit torque [rad/(N m)]; parameters as for `axial_compliance`."""
        return self.supported(support).torsional

    def influence_coefficient(
        self, support: Support = "pinned", pin: int = 0, distribution: Distribution = "uniform"
    ) -> float:
        """Influence coefficient c of P = c Z / e_n: lengthening per unit radial force Z [m/N].

        Z acts on the pin towards the shaft axis and opens a throw with one pin, so its c > 0. Yamanin
        and Zhukov 2021, doi 10.24143/2073-1574-2021-4-75-83.

        Parameters
        ----------
        support, pin, distribution
            As for `pin_response`.

        Raises
        ------
        InputError
            If an argument is unknown.
        """
        radial = self.superelement.radials[checked_pin(pin, len(self.mesh.pins))]
        load = self._end_load(pin, radial, NO_FORCE, distribution)
        return float(STRETCH @ end_motions(self.superelement, support, load[:, None])[:, 2])

    def reactions(
        self,
        pin_force: ArrayLike = NO_FORCE,
        support: Support = "pinned",
        pin: int = 0,
        *,
        pin_moment: ArrayLike = NO_FORCE,
        distribution: Distribution = "uniform",
    ) -> Reactions:
        """Reactions of the supports on the throw under a load on a pin, axial motion blocked.

        Parameters
        ----------
        pin_force : (3,) array_like
            Force on the pin in the throw frame [N]; the radial force Z on the first pin is
            ``(0, -Z, 0)``.
        support : "pinned", "guided" or Neighbors
            The left end takes the torque.
        pin_moment : (3,) array_like
            Moment on the pin about its center [N m].
        pin, distribution
            As for `pin_response`.

        Returns
        -------
        Reactions
            ``.left`` and ``.right``, each with ``.force`` [N] and ``.moment`` [N m] of shape (3,).

        Raises
        ------
        InputError
            If force or moment are not three finite numbers, the support or distribution is unknown,
            or there is no such pin.
        """
        load = self._end_load(pin, pin_force, pin_moment, distribution)
        return reactions(self.superelement, support, load)

    def _end_load(
        self, pin: int, force: ArrayLike, moment: ArrayLike, distribution: Distribution
    ) -> NDArray[np.float64]:
        load = (pin, force, moment, distribution)
        return end_load(self.superelement, self.classes, self.mesh, *load)

    def pin_response(
        self,
        force: ArrayLike = NO_FORCE,
        moment: ArrayLike = NO_FORCE,
        support: Support = "pinned",
        pin: int = 0,
        distribution: Distribution = "uniform",
    ) -> PinResponse:
        """Motions of end sections and pin under a load on the pin, the throw axially free.

        Parameters
        ----------
        force, moment : (3,) array_like
            On the pin, in the throw frame, the moment about the pin's center [N, N m].
        support : "pinned", "guided" or Neighbors
            The left end is held along and about the shaft.
        pin : int
            Index of the pin, from 0 at the left.
        distribution : {"uniform", "cosine"}
            ``uniform``: uniform traction over the pin, for moments growing linearly from its
            center. ``cosine``: force and moment across the pin as pressures p cos(theta) on the half
            that each presses on; force along the pin and torque about it are uniform in either case.

        Raises
        ------
        InputError
            As for `reactions`.
        """
        load = checked_vector("force", force, "N"), checked_vector("moment", moment, "N m")
        ends = self._end_load(pin, *load, distribution)
        local = pin_motion(self.superelement, self.classes, self.mesh, pin, *load, distribution)
        return pin_response(self.superelement, support, ends, local, pin)

    def pin_compliance(self, support: Support = "pinned", pin: int = 0) -> NDArray[np.float64]:
        """Mean motions (6, 6) of a pin per unit load on it, the throw axially free.

        Translations along x, y, z [m] and rotations [rad] under unit forces [N] and moments about the
        pin's center [N m], uniformly distributed. Errors as for `reactions`.
        """
        return pin_compliance(self.superelement, support, checked_pin(pin, len(self.mesh.pins)))

    def free_modes(
        self, count: int | None = None, highest_frequency: float | None = None
    ) -> ThrowModes:
        """Elastic natural modes of the throw without supports, with consistent masses.

        Parameters
        ----------
        count : int, optional
            Number of the lowest modes.
        highest_frequency : float, optional
            Instead, all modes up to this frequency [Hz].

        Raises
        ------
        InputError
            If not one of the two is given, or it is out of range.
        SolveError
            If the modes cannot be found.
        """
        highest, solver = highest_frequency, self.solver
        return free_modes(
            self.mesh, self.material, count=count, highest_frequency=highest, solver=solver
        )

    def dynamic_superelement(self, highest_frequency: float) -> DynamicSuperelement:
        """Stiffness and mass of the throw for vibration up to a frequency [Hz].

        Unknowns are the motions of the end sections and amplitudes of internal shapes, whose
        number is chosen for the frequency and recorded; 0 Hz gives Guyan's mass of the end motions
        alone. See `fem.craig_bampton.dynamic_superelement`.

        Raises
        ------
        InputError
            If the frequency is negative or not finite, or the end sections are not rigid.
        SolveError
            If the shapes cannot be found.
        """
        return dynamic_superelement(
            self.mesh, self.material, self.classes, highest_frequency, solver=self.solver
        )

    def over_angle(
        self, quantity: Compliance = "axial_compliance", gamma_deg: ArrayLike = ANGLES_DEG
    ) -> NDArray[np.float64]:
        """Values (n,) of a compliance between equal neighbors, over the angle to them [SI].

        Parameters
        ----------
        quantity : {"axial_compliance", "torsional_compliance", "influence_coefficient"}
        gamma_deg : (n,) array_like
            Angles between neighboring cranks [deg]; every 5 deg from 0 to 180 by default.

        Raises
        ------
        InputError
            For another quantity or an angle that is not finite.
        """
        return compliance_over_angle(self.superelement, check_compliance(quantity), gamma_deg)

    def plot(
        self, axes: "Axes | None" = None, *, quantity: Compliance = "axial_compliance"
    ) -> "Axes":
        """Draw a compliance over the angle to equal neighbors, with the pinned and the guided throw.

        With equal webs the value for neighbors in line is near the guided one, for opposite ones near the
        pinned one, for the torsional compliance the reverse: exactly so with rigid sections. The band is the
        estimated discretization error.

        Parameters
        ----------
        quantity : {"axial_compliance", "torsional_compliance", "influence_coefficient"}

        Raises
        ------
        InputError
            If the quantity is unknown.
        """
        chosen = check_compliance(quantity)
        bounds = {
            name: compliance(self.superelement, chosen, name) for name in ("guided", "pinned")
        }
        error = self.error_estimate if chosen == "axial_compliance" else None
        return plot_compliance(axes, self.over_angle(chosen), bounds, chosen, error)

    def to_pandas(self, content: Literal["compliances", "stiffness"] = "compliances") -> Any:
        """Return a table.

        Parameters
        ----------
        content : {"compliances", "stiffness"}
            Axial and torsional compliance and influence coefficient by support; or the stiffness
            (12, 12), loads in rows and end motions in columns.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        InputError, MissingLibraryError
            If the content is neither, or pandas is not installed.
        """
        check_choice("content", content, ("compliances", "stiffness"), "these are tables")
        if content == "stiffness":
            return stiffness_table(self.stiffness)
        return supported_table(
            {name: self.supported(support) for name, support in TABLE_SUPPORTS.items()}
        )

    def to_xarray(self) -> Any:
        """Return stiffness over loads and end motions, and compliances over the angle to neighbors.

        Returns
        -------
        xarray.Dataset
            ``stiffness`` (load, motion) with names such as "left ux"; ``axial_compliance``,
            ``torsional_compliance`` and ``influence_coefficient`` (gamma_deg).

        Raises
        ------
        MissingLibraryError
        """
        return throw_grid(
            self.stiffness, ANGLES_DEG, {name: self.over_angle(name) for name in LABELS}
        )
