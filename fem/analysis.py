"""Analyze a throw: one call from dimensions to superelement, masses and an error estimate."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from fem.assembly import assemble_stiffness
from fem.class_compliances import axial_answers, torsional_answer
from fem.condensation import CondensedClass, condense
from fem.loads import radial_directions, uniform_pin_loads
from fem.material import STEEL, Material
from fem.superelement import Superelement, combine_classes
from fem.supports import Reactions, Support, SupportedThrow, reactions, support_throw
from fem.symmetry import SymmetryClass, axial_class, symmetry_classes, torsional_class
from geometry.errors import InputError
from geometry.mass import MassProperties, mass_properties
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw, expected_unknowns, mesh_isolated

# The error of the compliance falls with the element size to this power. Filleted throws show 1.6 to
# 2.1, sharp corners 1.0 to 1.1; the lower values keep the estimate on the safe side.
ORDER_FILLETED = 1.6
ORDER_SHARP = 1.0
# Size factors above these are not used: on coarser meshes the error follows no power.
COARSEST_FILLETED = 1.0
COARSEST_SHARP = 2.0
COARSENING = 1.5
MOST_REFINEMENTS = 3
MOST_UNKNOWNS = 450_000

# Makes the mesh of a throw with a size factor.
Mesher = Callable[[Throw, float], ThrowMesh]


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
        Estimated relative discretization error of the axial compliance (pinned), from two meshes
        and the known order of convergence; the compliance is that much too small.
    accuracy : float
        The accuracy that was asked for.
    """

    throw: Throw
    material: Material
    superelement: Superelement
    mesh: ThrowMesh
    classes: tuple[CondensedClass, ...] = field(repr=False)
    masses: MassProperties
    error_estimate: float
    accuracy: float

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

    def influence_coefficient(self, support: Support = "pinned", pin: int = 0) -> float:
        """Influence coefficient c of P = c Z / e_n: lengthening per unit radial force Z [m/N].

        Z acts on the pin towards the shaft axis, spread uniformly over the pin's surface, and opens
        a throw of one pin, so its c > 0. Yamanin and Zhukov 2021,
        doi 10.24143/2073-1574-2021-4-75-83.

        Parameters
        ----------
        support : "pinned", "guided" or Neighbors
        pin : int
            Which pin, from 0 at the left.

        Raises
        ------
        InputError
            If the support is none of these, or there is no such pin.
        """
        return float(self.supported(support).influences[self._checked_pin(pin)])

    def reactions(
        self, pin_force: ArrayLike, support: Support = "pinned", pin: int = 0
    ) -> Reactions:
        """Reactions of the supports on the throw under a force on a pin, axial motion blocked.

        Parameters
        ----------
        pin_force : (3,) array_like
            Force on the pin in the throw frame [N]; the radial force Z on the first pin is
            ``(0, -Z, 0)``.
        support : "pinned", "guided" or Neighbors
            The left end takes the torque.
        pin : int
            Which pin, from 0 at the left.

        Returns
        -------
        Reactions
            ``.left`` and ``.right``, each with ``.force`` [N] and ``.moment`` [N m] of shape (3,).

        Raises
        ------
        InputError
            If the force is not three finite numbers, the support is unknown, or there is no such pin.
        """
        try:
            force = np.asarray(pin_force, dtype=float)
        except (TypeError, ValueError):
            force = np.empty(0)
        if force.shape != (3,) or not np.all(np.isfinite(force)):
            raise InputError(
                f"pin_force: given {pin_force!r}; allowed are three finite numbers [N]."
            )
        return reactions(self.superelement, support, force, self._checked_pin(pin))

    def _checked_pin(self, pin: int) -> int:
        count = len(self.superelement.pin_loads)
        if isinstance(pin, bool) or not isinstance(pin, int | np.integer) or not 0 <= pin < count:
            allowed = "0, for the throw has one pin" if count == 1 else f"0 to {count - 1}"
            raise InputError(f"pin: given {pin!r}; allowed is {allowed}.")
        return int(pin)


def analyze_throw(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.01,
    *,
    solver: str = "auto",
    mesher: Mesher = mesh_isolated,
) -> ThrowAnalysis:
    """Compute a throw's superelement, compliances, reactions and masses by finite elements.

    The throw, or the part of it that its symmetry leaves, is meshed twice; the difference and the known
    order of convergence give the error estimate. The mesh is refined until the estimate meets
    `accuracy`.

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
    mesher : callable
        How to mesh: throw and size factor to ThrowMesh. By default gmsh runs in a process of its own,
        which a crash or a hang cannot leave.

    Returns
    -------
    ThrowAnalysis

    Raises
    ------
    InputError
        If `accuracy` is out of range.
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
    1.27e-09 m/N
    """
    level, estimate = _solve_to(throw, material, accuracy, solver, mesher)
    classes = tuple(
        level.condense(symmetry, solver) for symmetry in symmetry_classes(level.mesh.part)
    )
    return ThrowAnalysis(
        throw=throw,
        material=material,
        superelement=combine_classes(classes, radial_directions(throw)),
        mesh=level.mesh,
        classes=classes,
        masses=mass_properties(level.mesh, material.density),
        error_estimate=estimate,
        accuracy=accuracy,
    )


def throw_responses(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.01,
    *,
    mesher: Mesher = mesh_isolated,
) -> dict[str, float]:
    """Compute the numbers that a study keeps of a throw, up to half cheaper than the whole analysis.

    Parameters, errors as for `analyze_throw`.

    Returns
    -------
    dict
        Compliances [m/N, rad/(N m)] and the first pin's influence coefficients [m/N] pinned and guided,
        mass [kg], error estimate of the axial compliance, unknowns of the meshed part.
    """
    level, estimate = _solve_to(throw, material, accuracy, "auto", mesher)
    torsional = level.condense(torsional_class(level.mesh.part), "auto")
    responses: dict[str, float] = {}
    for support in ("pinned", "guided"):
        compliance, influence = axial_answers(level.axial_part, support)
        responses[f"axial_compliance_{support}"] = compliance
        responses[f"torsional_compliance_{support}"] = torsional_answer(torsional, support)
        responses[f"influence_coefficient_{support}"] = influence
    responses["mass"] = mass_properties(level.mesh, material.density).mass
    responses["error_estimate"] = estimate
    responses["unknowns"] = float(level.mesh.unknowns)
    return responses


def _solve_to(
    throw: Throw, material: Material, accuracy: float, solver: str, mesher: Mesher
) -> tuple["_Level", float]:
    """Refine until the estimated error of the axial compliance meets the accuracy."""
    if not isinstance(throw, Throw):
        raise InputError(
            f"throw: given {throw!r}; allowed is a CrankThrow, or what import_throw returns."
        )
    if not isinstance(material, Material):
        raise InputError(f"material: given {material!r}; allowed is a Material, like STEEL.")
    if not isinstance(accuracy, int | float) or not 0.001 <= accuracy <= 0.1:
        raise InputError(
            f"accuracy: given {accuracy!r}; allowed is 0.001 to 0.1, the relative error of e_n."
        )
    order = ORDER_FILLETED if throw.filleted else ORDER_SHARP
    factor = _first_guess(accuracy, throw)
    while expected_unknowns(throw, factor) > MOST_UNKNOWNS:
        factor *= 1.2  # the estimate then says that the accuracy was not met
    coarse = _Level.solve(mesher(throw, COARSENING * factor), material, solver)
    # The coarse mesh may have been made finer than wished; the two must still differ.
    factor = min(factor, coarse.mesh.size_factor / COARSENING)
    for _ in range(MOST_REFINEMENTS):
        level = _Level.solve(mesher(throw, factor), material, solver)
        factor = level.mesh.size_factor
        ratio = coarse.mesh.size_factor / factor
        estimate = abs(level.axial - coarse.axial) / (ratio**order - 1.0) / level.axial
        if estimate <= accuracy:
            break
        wanted = factor * max(0.4, (0.7 * accuracy / estimate) ** (1.0 / order))
        if level.mesh.unknowns * (factor / wanted) ** 2.5 > MOST_UNKNOWNS:
            break
        coarse, factor = level, wanted
    return level, float(estimate)


def _first_guess(accuracy: float, throw: Throw) -> float:
    """Size factor that usually meets the accuracy at once, thin webs included."""
    if throw.filleted:
        return min(COARSEST_FILLETED, 0.65 * float((accuracy / 0.01) ** 0.3))
    return min(COARSEST_SHARP, max(0.25, 0.5 * float((accuracy / 0.01) ** (1.0 / ORDER_SHARP))))


@dataclass(frozen=True)
class _Level:
    """One mesh with its axial class solved, which the error estimate needs first."""

    mesh: ThrowMesh
    stiffness: sparse.csr_array
    pin_shapes: NDArray[np.float64]
    axial_part: CondensedClass

    @classmethod
    def solve(cls, mesh: ThrowMesh, material: Material, solver: str) -> "_Level":
        stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
        shapes = uniform_pin_loads(mesh)
        symmetry = axial_class(mesh.part)
        return cls(mesh, stiffness, shapes, condense(mesh, stiffness, shapes, symmetry, solver))

    @property
    def axial(self) -> float:
        """Axial compliance, pinned [m/N]."""
        return axial_answers(self.axial_part, "pinned")[0]

    def condense(self, symmetry: SymmetryClass, solver: str) -> CondensedClass:
        if symmetry == self.axial_part.symmetry:
            return self.axial_part
        return condense(self.mesh, self.stiffness, self.pin_shapes, symmetry, solver)
