"""One system of equations solved, as tests need it."""

from fem.solver import factorize


def solve_symmetric(upper, right_sides, solver="auto"):
    """Solution (n, k) for a matrix given by its upper triangle, and the name of the solver used."""
    with factorize(upper, solver) as factors:
        return factors.solve(right_sides), factors.solver
