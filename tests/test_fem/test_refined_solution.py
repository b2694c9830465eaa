"""Solutions of rough factors improved to round-off."""

import numpy as np
import pytest
from scipy import sparse

import fem.solver
from comparing import close
from fem.solver import SharedSolver, refined_solution

needs_pardiso = pytest.mark.skipif(fem.solver._pardiso() is None, reason="no Pardiso")


def graded(spread):
    """Upper triangle of a positive definite matrix whose eigenvalues span so many decades."""
    rng = np.random.default_rng(4)
    directions, _ = np.linalg.qr(rng.normal(size=(30, 30)))
    whole = directions * np.logspace(0.0, -spread, 30) @ directions.T
    return np.triu(0.5 * (whole + whole.T))


def rough_inverse(upper, error):
    whole = upper + np.triu(upper, 1).T
    inverse = np.linalg.inv(whole) * (1.0 + error)
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
