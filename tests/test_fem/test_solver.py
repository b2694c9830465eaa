from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

import fem.solver
from comparing import close
from crankbase.errors import InputError, SolveError
from fem.condensation import condense
from fem.solver import SharedSolver
from fem.symmetry import axial_class, symmetry_classes
from solving import solve_symmetric

SOLVERS = ["superlu"] if fem.solver._pardiso() is None else ["pardiso", "superlu"]
needs_both = pytest.mark.skipif(len(SOLVERS) < 2, reason="Pardiso is not installed")


def supported(size=50):
    """Upper triangle of a chain of springs held at one end."""
    diagonal = np.full(size, 2.0)
    diagonal[-1] = 1.0
    return sparse.csr_array(sparse.diags([diagonal, np.full(size - 1, -1.0)], [0, 1]))


@pytest.mark.parametrize("solver", SOLVERS)
def test_solution_of_a_spring_chain(solver):
    rights = np.zeros((50, 2))
    rights[-1, 0] = 1.0
    rights[9, 1] = 2.0
    solution, used = solve_symmetric(supported(), rights, solver)
    assert used == solver
    place = np.arange(1.0, 51.0)
    expected = np.column_stack([place, 2.0 * np.minimum(place, 10.0)])
    assert solution == close(expected, rel=1e-12)


@needs_both
@pytest.mark.parametrize("symmetry", symmetry_classes("quarter"))
def test_both_solvers_agree(mesh, stiffness, pins, symmetry):
    first, second = (condense(mesh, stiffness, pins, symmetry, solver) for solver in SOLVERS)
    assert (first.solver, second.solver) == ("pardiso", "superlu")
    size = np.abs(first.stiffness).max()
    # A rigid motion, where the class has one, costs round-off only.
    assert first.stiffness == close(second.stiffness, rel=1e-10, abs=1e-10 * size)
    assert first.fields == close(second.fields, abs=1e-11)
    assert first.pin_loads == close(second.pin_loads, abs=1e-11)


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


def test_unknown_solver():
    with pytest.raises(InputError, match="allowed are auto, pardiso, superlu"):
        solve_symmetric(supported(), np.ones((50, 1)), "cholesky")


def test_no_load_no_motion():
    solution, _ = solve_symmetric(supported(), np.zeros((50, 1)))
    assert not solution.any()


@pytest.mark.parametrize("solver", SOLVERS)
def test_matrices_of_one_pattern_follow_each_other(solver):
    shared = SharedSolver(solver)
    rights = np.ones((50, 1))
    chain = supported()
    for scale in (1.0, 3.0):
        solution = shared.factorize(scale * chain).solve(rights)
        assert chain @ solution + chain.T @ solution - chain.diagonal()[:, None] * solution == (
            close(rights / scale, rel=1e-10)
        )
    other = supported(60)
    alone, _ = solve_symmetric(other, np.ones((60, 1)), solver)
    assert shared.factorize(other).solve(np.ones((60, 1))) == close(alone, rel=1e-12)
    shared.close()
    shared.close()


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
