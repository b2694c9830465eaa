"""Analyze a throw: mesh, solve, and refine where the error is large until the answer is accurate enough.

Under a given axial force the compliance is twice the strain energy, and the error of the compliance is
twice the energy of the error. That energy is estimated element by element from recovered stresses
(`fem.correction`); the next mesh gets small elements where it is large.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from crankbase.choices import check_kind
from crankbase.memory import check_memory
from fem.assembly import assemble_stiffness
from fem.condensation import CondensedClass, EndSections, condense
from fem.correction import (
    EnergyErrors,
    class_energies,
    class_errors,
    corrected_class,
    effectivity,
    error_bars,
)
from fem.loads import NodalLoads, radial_directions, unit_pin_loads
from fem.material import STEEL, Material
from fem.solver import SharedSolver, Stopwatch
from fem.superelement import checked_superelement
from fem.supports import axial_motion, class_axial_compliances
from fem.symmetry import (
    RIGID,
    SHARED,
    Sections,
    SymmetryClass,
    axial_class,
    degree_of,
    symmetry_classes,
)
from fem.throw_analysis import AxialAnalysis, ThrowAnalysis
from fem.wished_accuracy import COMPLIANCE_ACCURACY
from geometry.mass import mass_properties
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw, expected_unknowns, mesh_isolated
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners
from geometry.throw import CrankThrow

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
    if not isinstance(throw, CrankThrow) or throw.symmetry == "full":
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


Array = NDArray[np.float64]

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
    graded = _limit_size_growth(nodal.points, nodal.tetrahedra, nodal.sizes)
    # Sizes of few digits: rounding in the solution must not become another mesh.
    steps = np.round(np.log(graded / mesh.length) / SIZE_STEP)
    return replace(nodal, sizes=mesh.length * np.exp(SIZE_STEP * steps))


def _limit_size_growth(points: Array, tetrahedra: NDArray[np.int64], sizes: Array) -> Array:
    """Limit how fast sizes grow from where they are small."""
    pairs = np.array([(i, j) for i in range(4) for j in range(4) if i != j])
    start, stop = tetrahedra[:, pairs[:, 0]].ravel(), tetrahedra[:, pairs[:, 1]].ravel()
    lengths = np.linalg.norm(points[start] - points[stop], axis=1)
    sizes = sizes.copy()
    for _ in range(100):
        before = sizes.copy()
        np.minimum.at(sizes, stop, sizes[start] + GROWTH * lengths)
        if np.array_equal(before, sizes):
            break
    return sizes


# Size factor of the first mesh.
FIRST_FILLETED = 2.0
FIRST_SHARP = 2.2
# With oil holes it is planned for this times the squared inverse of the wished accuracy, as far as this
# factor goes: holes are small and many elements stand round them, though they hardly change compliances.
# So is the first refined mesh, which has some 1.4 times the unknowns that are planned.
FIRST_DRILLED, COARSEST_DRILLED, REFINED_DRILLED = 36.0, 12.0, 33.0
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
MOST_UNKNOWNS = 450_000

# Makes the mesh of a throw: size factor, part, and element sizes instead of the planned ones.
Mesher = Callable[[Throw, float, str, SizeMap | None], ThrowMesh]


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
    axial_part : CondensedClass
        The class excited by an axial force, with rigid sections.
    solved_part : CondensedClass
        The same without correction, with all section motions.
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
    axial_part: CondensedClass
    solved_part: CondensedClass
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
            if one == known.symmetry
            else condense(
                *solved_mesh, one, self.solver, problem.end_sections, problem.watch, problem.degree
            )
            for one in symmetries
        ]
        if not known.sections.bending:  # then its energies are known as well
            parts = [one for one in parts if one is not known]
        with problem.watch.lap("error estimate"):
            energies = class_energies(parts, self.mesh, problem.material)
            corrected = {
                part.symmetry: corrected_class(part, energy, self.effectivity)
                for part, energy in zip(parts, energies, strict=True)
            }
        corrected.setdefault(known.symmetry, self.axial_part)
        return tuple(corrected[one] for one in symmetries)


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
    solver = SharedSolver(problem.solver, watch)
    solved = condense(
        mesh,
        stiffness,
        pins,
        axial_class(mesh.part),
        solver,
        problem.end_sections,
        watch,
        problem.degree,
    )
    part = solved.up_to(RIGID)
    with watch.lap("error estimate"):
        stresses = class_errors(part, mesh, problem.material)
        axial = np.append(axial_motion(part, "pinned"), np.zeros(len(part.pin_components)))
        errors = stresses.energy_errors(axial)
        factor = effectivity(mesh, errors.relative)
        part = corrected_class(part, stresses.products(), factor)
    return RefinementLevel(mesh, stiffness, pins, part, solved, errors, factor, solver)


def predicted_unknowns(throw: Throw, accuracy: float) -> float:
    """Predict the unknowns of the finest mesh that an accuracy of the axial compliance takes.

    Few meshes have more than that; with fillets they are within 30 %, with sharp corners down to half.
    """
    first = expected_unknowns(throw, first_factor(throw, accuracy))
    growth = GROWTH_FILLETED if throw.filleted else GROWTH_SHARP
    return min(first * max(1.0, growth / accuracy), MOST_UNKNOWNS)


def first_factor(throw: Throw, accuracy: float) -> float:
    """Size factor of the first mesh for an accuracy of the axial compliance."""
    factor = FIRST_FILLETED if throw.filleted else FIRST_SHARP
    most = _most_planned(throw, accuracy, FIRST_DRILLED)
    while factor < COARSEST_DRILLED and expected_unknowns(throw, factor) > most:
        factor *= 1.1
    while expected_unknowns(throw, factor) > MOST_UNKNOWNS:
        factor *= 1.2
    return factor


def _most_planned(throw: Throw, accuracy: float, planned: float) -> float:
    """Most unknowns that the first mesh, or the first refined one, is planned for."""
    if isinstance(throw, CrankThrow) and throw.oil_holes:
        return min(planned / accuracy**2, MOST_UNKNOWNS)
    return MOST_UNKNOWNS


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
    _check(throw, accuracy, problem.material)
    first = first_factor(throw, accuracy)
    check_solving_memory(throw, expected_unknowns(throw, first), accuracy)
    level = solve_level(_mesh(throw, first, None, problem, mesher), problem)
    aim = AIM_FILLETED if throw.filleted else AIM_SHARP
    target = aim * MOST_CORRECTED * accuracy / level.effectivity
    most = _most_planned(throw, accuracy, REFINED_DRILLED)
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


def _check(throw: Throw, accuracy: float, material: Material) -> None:
    check_kind("throw", throw, Throw, "a CrankThrow, or what import_throw returns")
    check_kind("material", material, Material, "a Material, like STEEL")
    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)


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
