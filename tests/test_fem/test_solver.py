"""Solutions of equations, their checks and the memory they take."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

import fem.solver
from comparing import close
from crankbase import memory
from crankbase.errors import NotEnoughMemoryError, SolveError
from fem import analysis
from fem.analysis import Problem, analyze_throw, solve_level
from fem.fillet_stress import fillet_stresses
from fem.material import STEEL
from fem.solver import (
    Factorization,
    SharedSolver,
    Stopwatch,
    assemble_stiffness,
    refined_solution,
    symmetric_product,
)
from fem.superelement import checked_superelement, condense
from fem.symmetry import RADIAL, axial_class, symmetry_classes, unit_pin_loads
from geometry.throw import CrankThrow
from refusals import refusals
from solving import solve_symmetric

SOLVERS = ["superlu"] if fem.solver._pardiso() is None else ["pardiso", "superlu"]
needs_both = pytest.mark.skipif(len(SOLVERS) < 2, reason="Pardiso is not installed")


def supported(size=50):
    """Upper triangle of a chain of springs held at one end."""
    diagonal = np.full(size, 2.0)
    diagonal[-1] = 1.0
    return sparse.csr_array(sparse.diags([diagonal, np.full(size - 1, -1.0)], [0, 1]))


@pytest.mark.parametrize("solver", SOLVERS)
def test_unsupported_structure_is_an_error(stiffness, solver):
    loads = np.random.default_rng(1).normal(size=(stiffness.shape[0], 1))
    with pytest.raises(SolveError):
        solve_symmetric(stiffness, loads, solver)


@pytest.mark.parametrize("solver", SOLVERS)
def test_free_unknown_is_an_error(solver):
    matrix = sparse.csr_array(sparse.diags([[1.0, 1.0, 0.0, 1.0]], [0]))
    with pytest.raises(SolveError):
        solve_symmetric(matrix, np.ones((4, 1)), solver)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    "spoil",
    [
        lambda x: x * (1.0 + 1e-7),
        lambda x: np.where(np.abs(x) == np.abs(x).max(axis=0), 1.0001 * x, x),
        np.zeros_like,
        lambda x: x[::-1],
        lambda x: np.full_like(x, np.nan),
    ],
    ids=["scaled", "one entry", "zero", "permuted", "nan"],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_wrong_solution_is_found(mesh, stiffness, pins, monkeypatch, solver, spoil):
    right = SharedSolver.factorize

    def spoiled(*arguments):
        factors = right(*arguments)
        return replace(factors, apply=lambda loads: spoil(factors.apply(loads)))

    monkeypatch.setattr(SharedSolver, "factorize", spoiled)
    with pytest.raises(SolveError, match="residual"):
        condense(mesh, stiffness, pins, axial_class("quarter"), solver)


def test_without_pardiso(monkeypatch):
    monkeypatch.setattr(fem.solver, "_pardiso", lambda: None)
    assert solve_symmetric(supported(), np.ones((50, 1)))[1] == "superlu"
    with pytest.raises(SolveError, match="pip install pypardiso"):
        solve_symmetric(supported(), np.ones((50, 1)), "pardiso")


def test_no_load_no_motion():
    solution, _ = solve_symmetric(supported(), np.zeros((50, 1)))
    assert not solution.any()


@needs_both
def test_factors_that_were_freed_are_not_used():
    shared = SharedSolver("pardiso")
    factors = shared.factorize(supported())
    shared.close()
    with pytest.raises(SolveError, match="freed"):
        factors.solve(np.ones((50, 1)))


@needs_both
def test_factors_of_an_earlier_matrix_are_not_used():
    shared = SharedSolver("pardiso")
    first = shared.factorize(supported())
    shared.factorize(3.0 * supported())
    with pytest.raises(SolveError, match="replaced"):
        first.solve(np.ones((50, 1)))
    shared.close()


needs_pardiso = pytest.mark.skipif(fem.solver._pardiso() is None, reason="no Pardiso")


def graded(spread):
    """Upper triangle of a positive definite matrix whose eigenvalues span so many decades."""
    directions, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(30, 30)))
    whole = directions * np.logspace(0.0, -spread, 30) @ directions.T
    return np.triu(0.5 * (whole + whole.T))


def rough_inverse(upper, error):
    inverse = np.linalg.inv(upper + np.triu(upper, 1).T) * (1.0 + error)
    return lambda sides: inverse @ sides


def test_a_rough_solver_leads_to_round_off():
    upper = graded(3.0)
    wanted = np.random.default_rng(5).normal(size=(30, 2)) * (1e-9, 1e9)
    whole = upper + np.triu(upper, 1).T
    found = refined_solution(
        sparse.csr_array(upper),
        np.abs(upper).sum(axis=1).max(),
        whole @ wanted,
        rough_inverse(upper, 1e-3),
    )
    assert found == close(wanted, rel=1e-10)


@pytest.mark.parametrize("error", [0.5, 3.0, np.nan])
def test_too_rough_a_solver_leads_to_none(error):
    upper = graded(3.0)
    sides = np.ones((30, 1))
    size = np.abs(upper).sum(axis=1).max()
    assert (
        refined_solution(sparse.csr_array(upper), size, sides, rough_inverse(upper, error)) is None
    )


def test_no_right_side_no_solution():
    upper = graded(1.0)
    nothing = np.zeros((30, 2))
    found = refined_solution(sparse.csr_array(upper), 1.0, nothing, rough_inverse(upper, 0.0))
    assert not found.any()


@needs_pardiso
@pytest.mark.parametrize("spread", [2.0, 7.5, 11.0], ids=["well", "badly", "worse conditioned"])
@pytest.mark.parametrize("size", [1e-60, 1.0, 1e60])
def test_few_sides_are_solved_as_exactly_as_many(monkeypatch, spread, size):
    """In single precision the second matrix is hardly, the third not positive definite."""
    monkeypatch.setattr(fem.solver, "SINGLE_FROM", 0)
    upper = sparse.csr_array(size * graded(spread))
    sides = np.random.default_rng(6).normal(size=(30, 3))
    few, many = SharedSolver("pardiso"), SharedSolver("pardiso", few_sides=False)
    found, expected = few.factorize(upper).solve(sides), many.factorize(upper).solve(sides)
    again = few.factorize(2.0 * upper).solve(sides)
    reached = 1e-14 * 10.0**spread
    scale = np.abs(expected).max()
    assert np.abs(found - expected).max() <= reached * scale
    assert np.abs(2.0 * again - expected).max() <= reached * scale
    few.close()
    many.close()


def solved(mesh, degree=2):
    """The superelement of a mesh, as a run makes it."""
    problem = Problem(STEEL, "auto", "rigid", Stopwatch(), degree)
    classes = solve_level(mesh, problem).condense(symmetry_classes(mesh.part), problem)
    return checked_superelement(classes, RADIAL[None], mesh)


def test_an_inaccurate_solution(mesh, monkeypatch):
    right, random = Factorization.solve_with_residual, np.random.default_rng(5)

    def poorly(self, right_sides):
        solution, _ = right(self, right_sides)
        solution *= 1.0 + 1e-4 * random.standard_normal(solution.shape)
        return solution, right_sides - symmetric_product(self.upper, solution)

    monkeypatch.setattr(Factorization, "solve_with_residual", poorly)
    with pytest.raises(SolveError, match=r"Reciprocity .* off by \d\.\de-0\d \(allowed 1e-06\)"):
        solved(mesh)


def test_a_stiffness_that_holds_the_throw_in_space(mesh, monkeypatch):
    def grounded(points, elements, material):
        found = assemble_stiffness(points, elements, material)
        spring = 1e-4 * found.diagonal().max() * (np.arange(found.shape[0]) == 3 * len(points) // 2)
        return (found + sparse.diags_array(spring)).tocsr()

    monkeypatch.setattr(analysis, "assemble_stiffness", grounded)
    with pytest.raises(SolveError, match="Rigid motions of the throw meet forces of"):
        solved(mesh)


def test_a_web_without_stiffness(mesh, monkeypatch):
    def soft(points, elements, material):
        cut = np.abs(points[elements[:, 0], 2] / mesh.length - 0.3) < 0.08
        left, right = (assemble_stiffness(points, elements[own], material) for own in (cut, ~cut))
        return (1e-10 * left + right).tocsr()

    monkeypatch.setattr(analysis, "assemble_stiffness", soft)
    with pytest.raises(SolveError, match="stiffness is not positive definite"):
        solved(mesh)


def test_a_load_of_which_a_node_is_lost(mesh, monkeypatch):
    def dropped(given):
        (load,) = unit_pin_loads(given)
        values = load.values.copy()
        values[:, 0] = 0.0
        return (replace(load, values=values),)

    monkeypatch.setattr(analysis, "unit_pin_loads", dropped)
    with pytest.raises(SolveError, match="leave an unbalanced share of a pin's load of"):
        solved(mesh)


def test_numbers_that_are_none(classes, mesh):
    first, *rest = classes
    spoiled = replace(first, stiffness=np.full_like(first.stiffness, np.nan))
    with pytest.raises(SolveError, match="unsymmetric by nan"):
        checked_superelement([spoiled, *rest], RADIAL[None], mesh)


@pytest.fixture
def little_memory(monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 0.0)
    monkeypatch.setattr(memory, "LITTLE", 0.0)


def refuse_to_mesh(*_):
    raise AssertionError("nothing may be meshed")


def test_an_analysis_that_does_not_fit_is_refused_before_meshing(throw, little_memory):
    wanted = r"^accuracy: given 0.01, whose next mesh of about [\d,]+ unknowns takes about"
    with pytest.raises(NotEnoughMemoryError, match=wanted):
        analyze_throw(throw, accuracy=0.01, mesher=refuse_to_mesh)


def test_stresses_that_do_not_fit_are_refused(throw, mesh, little_memory):
    meshed = []

    def once(*given):
        assert not meshed
        meshed.append(given)
        return mesh

    filleted = CrankThrow(**throw.model_dump() | {"fillet_radius": 0.012})
    with pytest.raises(NotEnoughMemoryError, match=r"^accuracy: given 0.05, whose .* GB that are"):
        fillet_stresses(filleted, accuracy=0.05, mesher=once)


test_refused = refusals(
    ("solver", lambda: solve_symmetric(supported(), np.ones((50, 1)), "cholesky")),
)
