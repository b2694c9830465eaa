"""Analyze a throw: one call from dimensions to superelement, masses and an error estimate."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem.accuracy import Mesher, Problem, solve_to
from fem.angle_law import AngleLaw, angle_law, is_symmetric
from fem.class_compliances import axial_answers
from fem.condensation import CondensedClass, EndSections
from fem.craig_bampton import DynamicSuperelement, dynamic_superelement
from fem.loads import Distribution, NodalLoads, pin_load, pin_surfaces, radial_directions
from fem.material import STEEL, Material
from fem.modes import ThrowModes, free_modes
from fem.pin_response import (
    PinResponse,
    equivalent_load,
    local_motion,
    pin_compliance,
    pin_response,
)
from fem.plots.over_angle import (
    ANGLES_DEG,
    LABELS,
    Compliance,
    check_compliance,
    draw_compliance,
)
from fem.superelement import Superelement, combine_classes
from fem.supports import (
    STRETCH,
    Neighbors,
    Reactions,
    Support,
    SupportedThrow,
    end_motions,
    reactions,
    support_throw,
)
from fem.symmetry import symmetry_classes
from fem.throw_frames import compliance_table, stiffness_table, throw_grid
from geometry.diagram_style import new_axes
from geometry.errors import InputError
from geometry.frames import table
from geometry.mass import MassProperties, mass_properties
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw, mesh_isolated
from geometry.plots.legends import write_title
from geometry.stopwatch import Stopwatch

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NO_FORCE = (0.0, 0.0, 0.0)
# Far beyond any real load, far below what overflows.
LARGEST_LOAD = 1e30
# Supports of the table of compliances, by the names it gives them.
TABLE_SUPPORTS: Mapping[str, Support] = {
    "pinned": "pinned",
    "guided": "guided",
    **{f"neighbors {step:g} deg": Neighbors(step, step) for step in (0.0, 90.0, 120.0, 180.0)},
}


@dataclass(frozen=True)
class ThrowAnalysis:
    """A throw's elastic and mass properties, from one mesh and one superelement.

    Attributes
    ----------
    throw : CrankThrow or ImportedThrow
    material : Material
    superelement : Superelement
    mesh : ThrowMesh
        Mesh of the part of the throw that was solved.
    classes : tuple of CondensedClass
        The solved symmetry classes with their displacement fields.
    masses : MassProperties
    error_estimate : float
        Estimated relative discretization error of the axial compliance (pinned), from the energy of
        the error; the compliance is about that much too small.
    accuracy : float
        The accuracy that was asked for.
    seconds : mapping
        Where the time went, by name.
    """

    throw: Throw
    material: Material
    superelement: Superelement
    mesh: ThrowMesh
    classes: tuple[CondensedClass, ...] = field(repr=False)
    masses: MassProperties
    error_estimate: float
    accuracy: float
    seconds: Mapping[str, float] = field(default_factory=dict, repr=False)

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness (12, 12): ux uy uz rx ry rz of the left, then the right end section [SI]."""
        return self.superelement.stiffness

    @property
    def accuracy_met(self) -> bool:
        """Whether the error estimate is within the accuracy asked for."""
        return self.error_estimate <= self.accuracy

    @property
    def solver(self) -> str:
        """The equation solver that was used."""
        return self.classes[0].solver

    @property
    def end_sections(self) -> str:
        """What the end sections may do: "rigid" or "averaged"."""
        return self.classes[0].end_sections

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
        """Compliance and influence coefficient over the angle to equal neighbors, in closed form.

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
            If the support is none of these.
        """
        return self.supported(support).axial

    def torsional_compliance(self, support: Support = "pinned") -> float:
        """Twist per unit torque [rad/(N m)]; parameters as for `axial_compliance`."""
        return self.supported(support).torsional

    def influence_coefficient(
        self, support: Support = "pinned", pin: int = 0, distribution: Distribution = "uniform"
    ) -> float:
        """Influence coefficient c of P = c Z / e_n: lengthening per unit radial force Z [m/N].

        Z acts on the pin towards the shaft axis and opens a throw of one pin, so its c > 0. Yamanin
        and Zhukov 2021, doi 10.24143/2073-1574-2021-4-75-83.

        Parameters
        ----------
        support : "pinned", "guided" or Neighbors
        pin : int
            Which pin, from 0 at the left.
        distribution : {"uniform", "cosine"}
            How the force is spread over the pin; see `pin_response`.

        Raises
        ------
        InputError
            If an argument is none of these.
        """
        radial = self.superelement.radials[self._checked_pin(pin)]
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
        pin : int
            Which pin, from 0 at the left.
        pin_moment : (3,) array_like
            Moment on the pin about its center [N m].
        distribution : {"uniform", "cosine"}
            How the load is spread over the pin; see `pin_response`.

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
            Which pin, from 0 at the left.
        distribution : {"uniform", "cosine"}
            ``uniform``: traction spread evenly over the pin, for moments growing linearly from its
            center. ``cosine``: force and moment across the pin as pressures p cos(theta) on the half
            that each presses on; force along the pin and torque about it are uniform in either case.

        Returns
        -------
        PinResponse

        Raises
        ------
        InputError
            As for `reactions`.
        """
        load = self._pin_load(
            pin, _vector("force", force, "N"), _vector("moment", moment, "N m"), distribution
        )
        local = local_motion(self.classes, load, len(self.mesh.pins))[6 * pin : 6 * pin + 6]
        end_load = equivalent_load(self.classes, load)
        return pin_response(self.superelement, support, end_load, local, pin)

    def pin_compliance(self, support: Support = "pinned", pin: int = 0) -> NDArray[np.float64]:
        """Mean motions (6, 6) of a pin per unit load on it, the throw axially free.

        Translations along x, y, z [m] and rotations about them [rad] under unit forces [N] and moments
        about the pin's center [N m], uniformly spread. Errors as for `axial_compliance`, also if there
        is no such pin.
        """
        return pin_compliance(self.superelement, support, self._checked_pin(pin))

    def free_modes(
        self, count: int | None = None, highest_frequency: float | None = None
    ) -> ThrowModes:
        """Elastic natural modes of the throw without supports, with consistent masses.

        Parameters
        ----------
        count : int, optional
            How many of the lowest modes.
        highest_frequency : float, optional
            Instead, all modes up to this frequency [Hz].

        Returns
        -------
        ThrowModes

        Raises
        ------
        InputError
            If not one of the two is given, or it is out of range.
        SolveError
            If the modes cannot be found.
        """
        return free_modes(
            self.mesh,
            self.material,
            count=count,
            highest_frequency=highest_frequency,
            solver=self.solver,
        )

    def dynamic_superelement(self, highest_frequency: float) -> DynamicSuperelement:
        """Stiffness and mass of the throw for vibration up to a frequency [Hz].

        Unknowns are the motions of the end sections and amplitudes of shapes of the inside, whose
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
        self,
        quantity: Compliance = "axial_compliance",
        gamma_deg: ArrayLike = ANGLES_DEG,
    ) -> NDArray[np.float64]:
        """Values of a compliance between equal neighbors, over the angle to them.

        Parameters
        ----------
        quantity : {"axial_compliance", "torsional_compliance", "influence_coefficient"}
        gamma_deg : (n,) array_like
            Angles between neighboring cranks [deg]; every 5 deg from 0 to 180 by default.

        Returns
        -------
        (n,) array
            [m/N or rad/(N m)]

        Raises
        ------
        InputError
            If the quantity is none of these or an angle is not finite.
        """
        name = check_compliance(quantity)
        angles = np.atleast_1d(np.asarray(gamma_deg, dtype=np.float64))
        if name != "torsional_compliance" and is_symmetric(self.superelement):
            law = self.angle_law
            return law.axial(angles) if name == "axial_compliance" else law.influence(angles)
        return np.array(
            [self._compliance(name, Neighbors(angle, angle)) for angle in angles.tolist()]
        )

    def plot(
        self, axes: "Axes | None" = None, *, quantity: Compliance = "axial_compliance"
    ) -> "Axes":
        """Draw a compliance over the angle to equal neighbors, beside the pinned and the guided throw.

        With equal webs neighbors in line give the guided value and opposite ones the pinned value of the
        axial compliance and the influence coefficient; for the torsional compliance it is the other way
        round. The band beside the axial compliance is its estimated discretization error.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        quantity : {"axial_compliance", "torsional_compliance", "influence_coefficient"}

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If the quantity is none of these.
        """
        values = self.over_angle(quantity)
        bounds = {name: self._compliance(quantity, name) for name in ("guided", "pinned")}
        axes = new_axes(axes)
        draw_compliance(
            axes,
            values,
            bounds,
            quantity,
            self.error_estimate if quantity == "axial_compliance" else None,
        )
        write_title(axes, "Throw by finite elements")
        return axes

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
        InputError
            If the content is neither.
        MissingLibraryError
            If pandas is not installed.
        """
        if content == "stiffness":
            return stiffness_table(self.stiffness)
        if content != "compliances":
            raise InputError(
                f"content: given {content!r}; allowed are compliances, stiffness, because these are tables."
            )
        answers = {name: self.supported(support) for name, support in TABLE_SUPPORTS.items()}
        return compliance_table(
            {name: (one.axial, one.torsional, one.influence) for name, one in answers.items()}
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
            If xarray is not installed.
        """
        return throw_grid(
            self.stiffness, ANGLES_DEG, {name: self.over_angle(name) for name in LABELS}
        )

    def _compliance(self, quantity: Compliance, support: Support) -> float:
        answer = self.supported(support)
        return {
            "axial_compliance": answer.axial,
            "torsional_compliance": answer.torsional,
            "influence_coefficient": answer.influence,
        }[quantity]

    def _end_load(
        self, pin: int, force: ArrayLike, moment: ArrayLike, distribution: Distribution
    ) -> NDArray[np.float64]:
        """End loads (12,) that a load on a pin is equivalent to."""
        checked = (_vector("pin_force", force, "N"), _vector("pin_moment", moment, "N m"))
        if distribution == "uniform":
            load = self.superelement.pin_loads[self._checked_pin(pin)] @ np.concatenate(checked)
            return np.asarray(load)
        return equivalent_load(self.classes, self._pin_load(pin, *checked, distribution))

    def _pin_load(
        self,
        pin: int,
        force: NDArray[np.float64],
        moment: NDArray[np.float64],
        distribution: Distribution,
    ) -> NodalLoads:
        surface = pin_surfaces(self.mesh)[self._checked_pin(pin)]
        return pin_load(surface, force, moment, distribution)

    def _checked_pin(self, pin: int) -> int:
        count = len(self.superelement.pin_loads)
        if isinstance(pin, bool) or not isinstance(pin, int | np.integer) or not 0 <= pin < count:
            allowed = "0, for the throw has one pin" if count == 1 else f"0 to {count - 1}"
            raise InputError(f"pin: given {pin!r}; allowed is {allowed}.")
        return int(pin)


def _vector(name: str, given: ArrayLike, unit: str) -> NDArray[np.float64]:
    """Three finite numbers."""
    try:
        vector = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        vector = np.empty(0)
    if vector.shape != (3,) or not np.all(np.abs(vector) <= LARGEST_LOAD):
        raise InputError(
            f"{name}: given {given!r}; allowed are three finite numbers [{unit}], none beyond "
            f"{LARGEST_LOAD:g}."
        )
    return vector


@dataclass(frozen=True)
class AxialAnalysis:
    """A throw's axial compliance alone, several times cheaper than the whole analysis.

    Attributes
    ----------
    throw : CrankThrow or ImportedThrow
    material : Material
    mesh : ThrowMesh
    part : CondensedClass
        The symmetry class that an axial force excites.
    error_estimate, accuracy, seconds
        As of `ThrowAnalysis`.
    """

    throw: Throw
    material: Material
    mesh: ThrowMesh
    part: CondensedClass = field(repr=False)
    error_estimate: float
    accuracy: float
    seconds: Mapping[str, float] = field(default_factory=dict, repr=False)

    @property
    def accuracy_met(self) -> bool:
        """Whether the error estimate is within the accuracy asked for."""
        return self.error_estimate <= self.accuracy

    def axial_compliance(self, support: str = "pinned") -> float:
        """Axial compliance e_n [m/N]; `support` is "pinned" or "guided".

        Raises
        ------
        InputError
            If the support is neither; between neighbors every class counts, see `analyze_throw`.
        """
        return axial_answers(self.part, _class_support(support))[0]

    def influence_coefficient(self, support: str = "pinned") -> float:
        """Influence coefficient c of the first pin [m/N]; support and errors as for e_n."""
        return axial_answers(self.part, _class_support(support))[1]

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
        supports = ("pinned", "guided")
        return table(
            {
                "support": (list(supports), ""),
                "axial_compliance": ([self.axial_compliance(one) for one in supports], "m/N"),
                "influence_coefficient": (
                    [self.influence_coefficient(one) for one in supports],
                    "m/N",
                ),
            }
        ).set_index("support")


def _class_support(support: str) -> str:
    if support not in ("pinned", "guided"):
        raise InputError(
            f'support: given {support!r}; allowed are "pinned" and "guided", for other supports need the '
            "whole analysis (analyze_throw)."
        )
    return support


def analyze_throw(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.01,
    *,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
    mesher: Mesher = mesh_isolated,
) -> ThrowAnalysis:
    """Compute a throw's superelement, compliances, reactions and masses by finite elements.

    The throw, or the part of it that its symmetry leaves, is meshed coarsely and solved under an axial
    force; the energy of the error, estimated from recovered stresses, says where the next mesh must be
    finer, until the estimate meets `accuracy`.

    Parameters
    ----------
    throw : CrankThrow or ImportedThrow
        The dimensions, or a part read by `import_throw`.
    material : Material
        Elastic constants and density.
    accuracy : float
        Wished relative accuracy of the axial compliance, 0.001 to 0.1.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.
    end_sections : {"rigid", "averaged"}
        Rigid discs, or sections of which only the mean motion is given; the two bound the truth.
    mesher : callable
        How to mesh: throw, size factor, part and size map to ThrowMesh. By default gmsh runs in a
        process of its own, which a crash or a hang cannot leave.

    Returns
    -------
    ThrowAnalysis

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
    1.26e-09 m/N
    """
    problem = Problem(material, solver, end_sections, Stopwatch())
    level = solve_to(throw, accuracy, problem, mesher)
    classes = tuple(
        level.condense(symmetry, problem) for symmetry in symmetry_classes(level.mesh.part)
    )
    with problem.watch.lap("masses"):
        masses = mass_properties(level.mesh, material.density)
    return ThrowAnalysis(
        throw=throw,
        material=material,
        superelement=combine_classes(classes, radial_directions(throw)),
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
    mesher: Mesher = mesh_isolated,
) -> AxialAnalysis:
    """Compute a throw's axial compliance e_n and influence coefficient c alone, pinned and guided.

    Parameters and errors as for `analyze_throw`, whose axial numbers these are.

    Returns
    -------
    AxialAnalysis
    """
    problem = Problem(material, solver, end_sections, Stopwatch())
    level = solve_to(throw, accuracy, problem, mesher)
    return AxialAnalysis(
        throw=throw,
        material=material,
        mesh=level.mesh,
        part=level.axial_part,
        error_estimate=level.error_estimate,
        accuracy=accuracy,
        seconds=problem.watch.seconds,
    )
