"""Least squares of small systems whose answers are known by hand; against statsmodels see validation."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.selection import adjusted, coefficient_of_determination, least_squares


def random_system(seed=0, rows=30, columns=6):
    rng = np.random.default_rng(seed)
    matrix = np.column_stack([np.ones(rows), rng.uniform(-1, 1, (rows, columns - 1))])
    return matrix, matrix @ rng.normal(size=columns) + 0.3 * rng.normal(size=rows)


def names(matrix):
    return [f"c{i}" for i in range(matrix.shape[1])]


def test_a_line_through_three_points():
    # y = 0, 1, 1 over x = -1, 0, 1: slope 1/2, mean 2/3, residuals -1/6, 1/3, -1/6.
    matrix = np.array([[1.0, -1.0], [1.0, 0.0], [1.0, 1.0]])
    found = least_squares(matrix, np.array([0.0, 1.0, 1.0]), names(matrix))
    assert found.coefficients == close([2 / 3, 1 / 2])
    assert found.residuals == close([-1 / 6, 1 / 3, -1 / 6])
    assert found.residual_variance == close(1 / 6)
    assert found.standard_errors == close([np.sqrt(1 / 18), np.sqrt(1 / 12)])
    assert found.r_squared == close(3 / 4)
    assert found.adjusted_r_squared == close(1 / 2)
    assert found.f_value == close(3.0)
    assert found.leverage == close([5 / 6, 1 / 3, 5 / 6])
    # Left out one by one: -1 at the first, 1/2 at the second, 2 at the third.
    assert found.leave_one_out == close([1.0, 0.5, 2.0])
    assert found.press == close(2.25)
    assert found.q_squared == close(1 - 2.25 / (2 / 3))
    assert found.variance_inflation == close([1.0])
    assert found.condition_number == close(np.sqrt(3 / 2))


def test_as_many_rows_as_columns_leave_nothing_to_judge_by():
    matrix, y = random_system(rows=6)
    found = least_squares(matrix, y, names(matrix))
    assert found.fitted == close(y, rel=1e-9)
    assert found.residual_variance is None
    assert found.standard_errors is None
    assert found.t_values is None
    assert found.f_value is None
    assert found.press is None
    assert found.q_squared is None
    assert found.adjusted_r_squared is None


def test_a_constant_response_has_nothing_to_explain():
    matrix, _ = random_system()
    found = least_squares(matrix, np.full(30, 0.5), names(matrix))
    assert found.r_squared is None
    assert found.q_squared is None
    assert coefficient_of_determination(np.full(4, 2.0), np.full(4, 2.0)) == 1.0


def test_variance_inflation_of_a_column_that_nearly_repeats_another():
    matrix, y = random_system()
    # x5 + a small part of its own: R2 of the new column by the others is 1 - (own part's share).
    noise = 0.01 * np.random.default_rng(3).normal(size=30)
    matrix = np.column_stack([matrix, matrix[:, 5] + noise])
    found = least_squares(matrix, y, names(matrix))
    others = least_squares(matrix[:, :-1], matrix[:, -1], names(matrix))
    assert found.variance_inflation[-1] == close(1 / (1 - others.r_squared), rel=1e-9)
    assert found.variance_inflation[-1] > 1000


def test_what_cannot_be_solved():
    matrix, y = random_system(rows=8)
    with pytest.raises(InputError, match="runs: given 5; at least 6 are needed"):
        least_squares(matrix[:5], y[:5], names(matrix))
    double = np.column_stack([matrix, matrix[:, 2] - matrix[:, 1]])
    with pytest.raises(InputError, match="do not determine the coefficient of c6"):
        least_squares(double, y, names(double))


def test_adjusted():
    assert adjusted(0.9, 11, 3) == close(0.875)
    assert adjusted(0.9, 3, 3) is None
