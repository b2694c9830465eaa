"""Analyze a throw: from dimensions to superelement, masses and an error estimate in one call."""

from crankbase.stopwatch import Stopwatch
from fem.accuracy import Mesher, Problem, solve_to_accuracy
from fem.axial_analysis import AxialAnalysis
from fem.condensation import EndSections
from fem.loads import radial_directions
from fem.material import STEEL, Material
from fem.section_motions import SHARED, Sections, degree_of
from fem.superelement import checked_superelement
from fem.symmetry import symmetry_classes
from fem.throw_analysis import ThrowAnalysis
from geometry.mass import mass_properties
from geometry.mesher import Throw, mesh_isolated


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

    Returns
    -------
    AxialAnalysis
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
