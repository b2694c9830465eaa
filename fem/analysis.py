"""Analyze a throw: mesh, solve, refine where the error is large until the answer is accurate enough.

Under a given axial force the compliance is twice the strain energy, and the error of the compliance is
twice the energy of the error. That energy is estimated element by element from recovered stresses
(`fem.correction`); the next mesh gets small elements where it is large.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from crankbase.choices import check_choice, check_kind
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.memory import check_memory
from crankbase.summaries import summarized
from fem.angle_law import AngleLaw, angle_law, compliance, compliance_over_angle
from fem.correction import (
    EnergyErrors,
    StressRecovery,
    class_energies,
    corrected_class,
    effectivity,
    error_bars,
    slope_errors,
)
from fem.end_reactions import (
    END_LOADS,
    ROUND_OFF,
    Reactions,
    compliance_table,
    stiffness_table,
    supported_table,
    throw_grid,
)
from fem.first_mesh import MOST_UNKNOWNS, REFINED_DRILLED, first_factor, most_planned
from fem.material import STEEL, Material
from fem.plots import ANGLES_DEG, LABELS, Compliance, check_compliance, plot_compliance
from fem.solver import SharedSolver, Stopwatch, assemble_stiffness
from fem.superelement import (
    CondensedClass,
    EndSections,
    HeldEnds,
    Superelement,
    checked_superelement,
    combine_classes,
    condense,
    hold_ends,
)
from fem.supports import (
    STRETCH,
    TABLE_SUPPORTS,
    Neighbors,
    PinResponse,
    Support,
    SupportedThrow,
    axial_motion,
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
from fem.symmetry import (
    RIGID,
    SHARED,
    Distribution,
    NodalLoads,
    Sections,
    SymmetryClass,
    axial_class,
    degree_of,
    radial_directions,
    symmetry_classes,
    unit_pin_loads,
)
from fem.wished_accuracy import COMPLIANCE_ACCURACY
from geometry.any_throw import Throw
from geometry.mass import MassProperties, mass_properties
from geometry.mesh import ThrowMesh
from geometry.mesher import Mesher, expected_unknowns, mesh_isolated
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from fem.exchange import SkfemThrow
    from fem.fillet_peaks import LoadedThrow
    from fem.modes import DynamicSuperelement, ThrowModes
    from fem.sensitivities import DimensionChange, Sensitivities


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
        bars: dict[str, Any] = {
            name: error_bars(value, getattr(discrete, name), coarse, missing=missing)
            for name, value in vars(support_throw(self.superelement, support)).items()
        }
        for name in ("axial", "torsional", "influence"):
            bars[name] = float(bars[name])
        return SupportedThrow(**bars)

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
        if not self.mesh.pins:
            return math.nan  # an end part of a crankshaft carries no rod
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
    ) -> "ThrowModes":
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
        from fem.modes import free_modes

        highest, solver = highest_frequency, self.solver
        return free_modes(
            self.mesh, self.material, count=count, highest_frequency=highest, solver=solver
        )

    def dynamic_superelement(self, highest_frequency: float) -> "DynamicSuperelement":
        """Stiffness and mass of the throw for vibration up to a frequency [Hz].

        Unknowns are the motions of the end sections and amplitudes of internal shapes, whose
        number is chosen for the frequency and recorded; 0 Hz gives Guyan's mass of the end motions
        alone. See `fem.modes.dynamic_superelement`.

        Raises
        ------
        InputError
            If the frequency is negative or not finite, or the end sections are not rigid.
        SolveError
            If the shapes cannot be found.
        """
        from fem.modes import dynamic_superelement

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

    @cached_property
    def changes_in_shaft(self) -> "tuple[dict[str, DimensionChange], dict[str, str]]":
        """The throw's change with its dimensions where throws meet, and why some have none."""
        return self._changes(joined=True)

    @cached_property
    def _changes_alone(self) -> "tuple[dict[str, DimensionChange], dict[str, str]]":
        return self._changes(joined=False)

    def _changes(self, *, joined: bool) -> "tuple[dict[str, DimensionChange], dict[str, str]]":
        from fem.sensitivities import dimension_changes

        return dimension_changes(
            self.throw,
            self.mesh,
            self.material,
            self.classes,
            joined=joined,
            corrected=self.corrected,
        )

    def sensitivities(
        self,
        quantity: str = "axial_compliance",
        support: Support = "pinned",
        *,
        pin: int = 0,
        pin_force: ArrayLike | None = None,
    ) -> "Sensitivities":
        """How a compliance, a reaction, the mass or the inertia changes with each dimension of the throw.

        All follow from the solutions at hand, without another mesh (`fem.sensitivities`); the first call
        takes most of the time, longer between neighbors.

        Parameters
        ----------
        quantity : str
            "axial_compliance", "torsional_compliance", "influence_coefficient", "pin_compliance" (motion of
            the pin along a force on it), "mass", "inertia" (about the shaft), or one of the `reactions`:
            "left Fx", "left Fy" and so on to "right Mz".
        support
            As for `axial_compliance`; without effect on mass and inertia.
        pin : int
            Index of the loaded pin, from 0 at the left.
        pin_force : (3,) array_like, optional
            On this pin in the throw frame, for its compliance and for reactions, by default radial; shares
            do not depend on how large it is.

        Raises
        ------
        InputError
            If an argument is unknown, the reaction is zero, the throw is a CAD part, or its end sections are
            not rigid.
        """
        from fem.sensitivities import VOLUME_ERROR, Sensitivities, sloped_answer

        # Those in the shaft, once known, hold what the throw alone needs.
        joined = isinstance(support, Neighbors) or "changes_in_shaft" in vars(self)
        changes, left_out = self.changes_in_shaft if joined else self._changes_alone
        if quantity in ("mass", "inertia"):
            shares = {path: getattr(change, quantity) for path, change in changes.items()}
            return Sensitivities(quantity, "", shares, left_out, VOLUME_ERROR)
        throw, force = self.superelement, pin_force
        checked_pin(pin, len(self.mesh.pins))
        along = throw.radials[pin] if force is None else checked_vector("pin_force", force, "N")
        if not np.any(along):
            raise InputError(
                "pin_force: given zero; allowed is a force, because zero has no direction."
            )
        answer = sloped_answer(quantity, support, pin, None if force is None else along)
        value, arm = answer(throw), self.mesh.length if "M" in quantity else 1.0
        if quantity in END_LOADS and abs(value) < ROUND_OFF * arm * np.linalg.norm(along):
            raise InputError(
                f"quantity: given {quantity!r}, which is zero under this force; allowed are reactions that "
                "are not, because a slope is a share of them."
            )
        shares = {path: change.share(answer) for path, change in changes.items()}
        plain = self.discrete.superelement
        coarse = axial_correction(throw, plain)
        error = float(slope_errors(value, answer(plain), coarse, self.corrected, throw.missing))
        return Sensitivities(quantity, str(support), shares, left_out, error)

    def plot(
        self,
        axes: Axes | None = None,
        *,
        view: Literal["side", "left end"] = "side",
        dimensions: bool = True,
    ) -> Axes:
        """Draw the throw to scale; see `CrankThrow.plot`.

        Raises
        ------
        InputError
            If the view is neither, or the throw is a CAD part, which has no dimensions to draw it from.
        """
        if not isinstance(self.throw, CrankThrow):
            raise InputError(
                "plot: given the analysis of a CAD part; allowed is that of a throw of dimensions, because "
                "it is drawn from them."
            )
        return self.throw.plot(axes, view=view, dimensions=dimensions)

    def plot_over_angle(
        self, axes: Axes | None = None, *, quantity: Compliance = "axial_compliance"
    ) -> Axes:
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

    def to_skfem(self) -> "SkfemThrow":
        """Return the whole throw for scikit-fem: mesh, basis, and displacements under unit loads.

        Solved parts are mirrored, so that forms see the whole throw. Ends are pinned. The displacements are
        those of the finite elements, whose compliances are those of ``discrete``.

        Examples
        --------
        >>> import crankfem as cf
        >>> from skfem.models.elasticity import linear_elasticity
        >>> throw = cf.CrankThrow(
        ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
        ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
        ... )
        >>> analysis = cf.analyze_throw(throw, accuracy=0.1)
        >>> given, steel = analysis.to_skfem(), analysis.material
        >>> form = linear_elasticity(steel.lame_constant, steel.shear_modulus)
        >>> pulled = given.displacement["axial force"]
        >>> twice_energy = pulled @ form.assemble(given.basis) @ pulled
        >>> bool(abs(twice_energy / analysis.discrete.axial_compliance() - 1.0) < 1e-9)
        True
        """
        from fem.exchange import skfem_throw

        return skfem_throw(self._under_unit_loads())

    def to_meshio(self) -> Any:
        """Return the whole throw for meshio: curved elements, and fields at the nodes under unit loads.

        Returns
        -------
        meshio.Mesh
            Cells "tetra10", and "triangle6" of the named surfaces; the cell data "left end", "pin",
            "fillet" and so on are 1 on theirs. For each load of `to_skfem` the point data "displacement,
            axial force [m/N]" (n, 3) and "stress, axial force [Pa/N]" (n, 6): xx, yy, zz, xy, yz, zx,
            recovered from the elements. The ends are pinned; nothing is corrected for discretization. Files
            for solvers are better written by `write_mesh`.
        """
        from fem.exchange import meshio_throw

        return meshio_throw(self._under_unit_loads())

    def to_pyvista(self) -> Any:
        """Return the whole throw for PyVista, with the fields of `to_meshio`.

        Returns
        -------
        pyvista.UnstructuredGrid
        """
        import pyvista

        return pyvista.from_meshio(self.to_meshio())

    def _under_unit_loads(self) -> "LoadedThrow":
        from fem.exchange import loaded_throw

        return loaded_throw(self.throw, self.mesh, self.material, self.discrete.classes)


# Bytes of a process that has loaded what solving needs, and for each unknown of a quarter or half with all
# solutions that a superelement needs. Fitted to resident memory of 6,000 to 180,000 unknowns, which it meets
# within 30 % (docs/developers/faults.md).
LIBRARIES, PER_UNKNOWN = 1.9e8, 6.9e3
# Of a whole throw all solutions are held at once; under the unit loads for stresses there are fewer.
WHOLE, FOR_STRESSES = 1.5, 0.6


def solving_memory(throw: Throw, unknowns: float, *, stresses: bool = False) -> float:
    """Predict the resident memory of a process that solves a throw [byte].

    Parameters
    ----------
    unknowns : float
        Of the meshed part.
    stresses : bool
        Whether for the stresses at its fillets alone, or for its superelement.
    """
    each = PER_UNKNOWN * (FOR_STRESSES if stresses else 1.0)
    if throw.symmetry == "full":
        each *= WHOLE
    return LIBRARIES + each * unknowns


def check_solving_memory(
    throw: Throw, unknowns: float, accuracy: float, *, stresses: bool = False
) -> None:
    """Refuse a mesh whose solution would need more memory than is free.

    Parameters
    ----------
    throw, unknowns, stresses
        As for `solving_memory`.
    accuracy : float
        Requested accuracy.

    Raises
    ------
    NotEnoughMemoryError
    """
    rounded = float(f"{unknowns:.2g}")
    check_memory(
        solving_memory(throw, unknowns, stresses=stresses) - LIBRARIES,  # which are loaded by now
        f"accuracy: given {accuracy:g}, whose next mesh of about {rounded:,.0f} unknowns takes",
        "ask for a larger accuracy, or free memory",
    )


# Squared energy error of second-order elements falls with the fourth power of their size where the
# stress is smooth, with the first or second at a sharp corner. This power in between makes as good
# meshes as the fourth does, and comes closer to the wished error at once.
ORDER = 2.5
# gmsh makes elements somewhat larger than a map says.
MADE_SMALLER = 0.83
# Sizes change at most by these factors at once, and grow by at most this per unit of distance.
MOST_REFINED, MOST_COARSENED = 0.2, 1.5
GROWTH = 0.6
SIZE_STEP = 1e-3


def refined_sizes(mesh: ThrowMesh, errors: EnergyErrors, target: float) -> SizeMap:
    """Sizes with which the fewest elements have a total error energy of `target`.

    Where the squared error of an element falls with the power p of its size and the space has three
    dimensions, the number of elements sum(r^-3) is least, for a given sum of e r^p over the old
    elements, if r is proportional to e^(-1 / (p + 3)) (X. D. Li and P. Bettess, Commun. Numer. Meth.
    Engng 11, 857-868 and 911-915, 1995).

    Parameters
    ----------
    errors : EnergyErrors
        Of its solution.
    target : float
        Required error as a share of the energy.
    """
    corners = mesh.elements[:, :4]
    sizes = element_sizes(mesh.points, corners)
    shares = np.maximum(errors.elements, 1e-12 * errors.elements.max()) / errors.energy
    ratios = shares ** (-1.0 / (ORDER + 3.0))
    ratios *= (target / np.sum(shares * ratios**ORDER)) ** (1.0 / ORDER)
    wished = MADE_SMALLER * sizes * np.clip(ratios, MOST_REFINED, MOST_COARSENED)

    # The mean at the corners; the smallest would refine two layers for one element.
    nodal = sizes_at_corners(mesh.points, corners, wished)
    # From where they are small, sizes grow no faster than meshers can follow.
    pairs = np.array([(i, j) for i in range(4) for j in range(4) if i != j])
    start = nodal.tetrahedra[:, pairs[:, 0]].ravel()
    stop = nodal.tetrahedra[:, pairs[:, 1]].ravel()
    lengths = np.linalg.norm(nodal.points[start] - nodal.points[stop], axis=1)
    graded = nodal.sizes.copy()
    for _ in range(100):
        before = graded.copy()
        np.minimum.at(graded, stop, graded[start] + GROWTH * lengths)
        if np.array_equal(before, graded):
            break
    # Sizes of few digits: rounding in the solution must not become another mesh.
    steps = np.round(np.log(graded / mesh.length) / SIZE_STEP)
    return replace(nodal, sizes=mesh.length * np.exp(SIZE_STEP * steps))


# Recovered stresses miss some of the error, most beside surfaces; the estimate is theirs times this
# (tests/campaigns/corrected_answers.py).
SAFETY = 1.35
# An answer is corrected by at most so many times the wished accuracy, or the mesh is refined: the less it
# rests on the estimate of its error, the better it is known.
MOST_CORRECTED = 2.0
# The first refined mesh is aimed at this share of the accuracy, for it rarely turns out as wished: less
# where corners are sharp, whose errors fall more slowly than those that the sizes are chosen for. Those
# after it are aimed by how much it fell short.
AIM_FILLETED = 0.85
AIM_SHARP = 0.5
AIM_AGAIN = 0.85
MOST_REFINEMENTS = 5
# The finest mesh has at most about so many times the unknowns of the first, divided by the accuracy.
GROWTH_FILLETED, GROWTH_SHARP = 0.0095, 0.030


@dataclass(frozen=True)
class Problem:
    """Settings for the solution of a throw.

    Attributes
    ----------
    solver : str
        See `fem.solver.factorize`.
    end_sections : {"rigid", "averaged"}
    degree : int
        Of the polynomials that rigid end sections also move as; 0 for none.
    """

    material: Material
    solver: str
    end_sections: EndSections
    watch: Stopwatch
    degree: int = 0


@dataclass(frozen=True)
class RefinementLevel:
    """One mesh with its axial class solved and corrected.

    Attributes
    ----------
    stiffness : sparse array
        Upper triangle.
    pins : tuple of NodalLoads
        Unit loads on each pin.
    held : HeldEnds or None
        None with averaged sections.
    axial_part : CondensedClass
        The class excited by an axial force, with rigid sections.
    solved_part : CondensedClass
        The same without correction, with all section motions.
    recovery : StressRecovery
        Of the mesh.
    energies : array
        Mutual energies of the estimated errors of the fields of `solved_part` [J].
    errors : EnergyErrors
        Of the solution under an axial force, ends pinned, from recovered stresses.
    effectivity : float
        True energies of errors over these.
    solver : SharedSolver
        Reusable for the pattern of the mesh.
    """

    mesh: ThrowMesh
    stiffness: sparse.csr_array
    pins: tuple[NodalLoads, ...]
    held: HeldEnds | None
    axial_part: CondensedClass
    solved_part: CondensedClass
    recovery: StressRecovery
    energies: NDArray[np.float64]
    errors: EnergyErrors
    effectivity: float
    solver: SharedSolver

    @property
    def axial(self) -> float:
        """Axial compliance, pinned [m/N]."""
        return class_axial_compliances(self.axial_part, "pinned")[0]

    @property
    def error_estimate(self) -> float:
        """Estimated relative error of the axial compliance."""
        if self.axial_part.discrete is None:
            return SAFETY * self.errors.relative
        correction = self.axial_correction
        return float(error_bars(1.0, 1.0 - correction, correction))

    @property
    def axial_correction(self) -> float:
        """Share of the axial compliance that is correction, or would be."""
        if self.axial_part.discrete is None:
            return self.effectivity * self.errors.relative
        return 1.0 - class_axial_compliances(self.axial_part.discrete, "pinned")[0] / self.axial

    def meets(self, accuracy: float) -> bool:
        """Whether the error is small enough, and the correction too."""
        return (
            self.error_estimate <= accuracy and self.axial_correction <= MOST_CORRECTED * accuracy
        )

    def condense(
        self, symmetries: Sequence[SymmetryClass], problem: Problem
    ) -> tuple[CondensedClass, ...]:
        """Condense classes on the same mesh."""
        known = self.solved_part
        solved_mesh = (self.mesh, self.stiffness, self.pins)
        parts = [
            known
            if symmetry == known.symmetry
            else condense(
                *solved_mesh,
                symmetry,
                self.solver,
                problem.end_sections,
                self.held,
            )
            for symmetry in symmetries
        ]
        with problem.watch.lap("error estimate"):
            return tuple(
                corrected_class(
                    part,
                    self.energies
                    if part is known
                    else class_energies(part, self.recovery, problem.material),
                    self.effectivity,
                )
                for part in parts
            )


def solve_level(mesh: ThrowMesh, problem: Problem) -> RefinementLevel:
    """Solve the axial class on a mesh and estimate its error.

    Raises
    ------
    SolveError
    """
    watch = problem.watch
    with watch.lap("assembly"):
        stiffness = assemble_stiffness(mesh.points, mesh.elements, problem.material)
        pins = unit_pin_loads(mesh)
        rigid = problem.end_sections == "rigid"
        held = hold_ends(mesh, stiffness, problem.degree) if rigid else None
    solver = SharedSolver(problem.solver, watch)
    axial = axial_class(mesh.part)
    solved = condense(mesh, stiffness, pins, axial, solver, problem.end_sections, held)
    part = solved.up_to(RIGID)
    with watch.lap("error estimate"):
        recovery = StressRecovery(mesh.points, mesh.elements)
        moved = part.fields @ axial_motion(part, "pinned")
        errors = recovery.energy_errors(moved, problem.material)
        factor = effectivity(mesh, errors.relative)
        energies = class_energies(solved, recovery, problem.material)
        unbent = np.r_[: len(part.stiffness), len(solved.stiffness) : len(energies)]
        part = corrected_class(part, energies[np.ix_(unbent, unbent)], factor)
    return RefinementLevel(
        mesh, stiffness, pins, held, part, solved, recovery, energies, errors, factor, solver
    )


def predicted_unknowns(throw: Throw, accuracy: float) -> float:
    """Predict the unknowns of the finest mesh that an accuracy of the axial compliance takes.

    Few meshes have more than that; with fillets they are within 30 %, with sharp corners down to half.
    """
    first = expected_unknowns(throw, first_factor(throw, accuracy))
    growth = GROWTH_FILLETED if throw.filleted else GROWTH_SHARP
    return min(first * max(1.0, growth / accuracy), MOST_UNKNOWNS)


def solve_to_accuracy(
    throw: Throw, accuracy: float, problem: Problem, mesher: Mesher = mesh_isolated
) -> RefinementLevel:
    """Refine until the estimated error of the axial compliance meets the accuracy.

    Parameters
    ----------
    accuracy : float
        Required relative accuracy, 0.001 to 0.1.
    mesher : callable
        Function for meshing, as `geometry.mesher.mesh_isolated`.

    Returns
    -------
    Level
        The last and best; its estimate is above the accuracy if that was not reached with
        `MOST_UNKNOWNS` or in `MOST_REFINEMENTS` refinements.

    Raises
    ------
    InputError
        If an argument is out of range, or a mesh would need more memory than is free.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    check_kind("throw", throw, Throw, "a CrankThrow, or what import_throw returns")
    check_kind("material", problem.material, Material, "a Material, like STEEL")
    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)
    first = first_factor(throw, accuracy)
    check_solving_memory(throw, expected_unknowns(throw, first), accuracy)
    level = solve_level(_mesh(throw, first, None, problem, mesher), problem)
    aim = AIM_FILLETED if throw.filleted else AIM_SHARP
    target = aim * MOST_CORRECTED * accuracy / level.effectivity
    most = most_planned(throw, accuracy, REFINED_DRILLED)
    for _ in range(MOST_REFINEMENTS):
        if level.meets(accuracy):
            break
        with problem.watch.lap("error estimate"):
            sizes = replace(refined_sizes(level.mesh, level.errors, target), first_factor=first)
            factor = 1.0
            while sizes.expected_unknowns(factor) > most:
                factor *= 1.05
        level.solver.close()  # factors of two meshes need not be kept at once
        check_solving_memory(throw, sizes.expected_unknowns(factor), accuracy)
        finer = solve_level(_mesh(throw, factor, sizes, problem, mesher), problem)
        if finer.error_estimate >= level.error_estimate:
            break
        level = finer
        if factor > 1.0 and most == MOST_UNKNOWNS:
            break
        most = MOST_UNKNOWNS
        # What this mesh fell short of its aim by, the next one is expected to fall short of as well.
        target *= AIM_AGAIN * MOST_CORRECTED * accuracy / level.axial_correction
    return level


def _mesh(
    throw: Throw, factor: float, sizes: SizeMap | None, problem: Problem, mesher: Mesher
) -> ThrowMesh:
    with problem.watch.lap("mesh"):
        mesh = mesher(throw, factor, "auto", sizes)
        problem.watch.add({"geometry": mesh.geometry_seconds})
    return mesh


def analyze_throw(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.01,
    *,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
    sections: Sections = SHARED,
    mesher: Mesher | None = None,
) -> ThrowAnalysis:
    """Compute a throw's superelement, compliances, reactions and masses by finite elements.

    The throw, or the part of it required by its symmetry, is meshed coarsely and solved under an axial
    force; the energy of the error, estimated from recovered stresses, shows where the next mesh must be
    finer, until the estimate meets `accuracy`.

    Parameters
    ----------
    throw : CrankThrow or ImportedThrow
        The dimensions, or a part read by `import_throw`.
    material : Material
        Elastic constants and density.
    accuracy : float
        Required relative accuracy of the axial compliance, 0.001 to 0.1.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.
    end_sections : {"rigid", "averaged"}
        Rigid discs, or sections with prescribed mean motions only; the true value is between both.
    sections : {"rigid", 1, 2, 4}
        Section motions where throws meet, between `Neighbors`, in a shaft and in its
        vibration: polynomials of this degree, or rigid discs there as well. Pinned and
        guided results always have rigid sections; `ThrowAnalysis.section_error` is the effect of
        that.
    mesher : callable, optional
        Function for meshing: throw, size factor, part and size map to ThrowMesh. By default gmsh runs in a
        separate process, so that a crash or a hang does not matter.

    Raises
    ------
    InputError
        If an argument is out of range.
    MeshError, SolveError
        If the throw cannot be meshed or solved.

    Examples
    --------
    >>> import crankfem as cf
    >>> throw = cf.CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> analysis = cf.analyze_throw(throw, accuracy=0.02)
    >>> print(f"{analysis.axial_compliance():.2e} m/N")
    1.29e-09 m/N
    """
    problem = Problem(material, solver, end_sections, Stopwatch(), degree_of(sections))
    level = solve_to_accuracy(throw, accuracy, problem, mesher or mesh_isolated)
    classes = level.condense(symmetry_classes(level.mesh.part), problem)
    with problem.watch.lap("masses"):
        masses = mass_properties(level.mesh, material.density)
    return ThrowAnalysis(
        throw=throw,
        material=material,
        superelement=checked_superelement(classes, radial_directions(throw), level.mesh),
        mesh=level.mesh,
        classes=classes,
        masses=masses,
        error_estimate=level.error_estimate,
        accuracy=accuracy,
        seconds=problem.watch.seconds,
    )


def analyze_axial(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.01,
    *,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
    mesher: Mesher | None = None,
) -> AxialAnalysis:
    """Compute only a throw's axial compliance e_n and influence coefficient c, pinned and guided.

    Parameters and errors as for `analyze_throw`, with the same axial results.
    """
    problem = Problem(material, solver, end_sections, Stopwatch())
    level = solve_to_accuracy(throw, accuracy, problem, mesher or mesh_isolated)
    return AxialAnalysis(
        throw=throw,
        material=material,
        mesh=level.mesh,
        part=level.axial_part,
        error_estimate=level.error_estimate,
        accuracy=accuracy,
        seconds=problem.watch.seconds,
    )
