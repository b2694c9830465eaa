"""Ordinary least squares, and Longley's data.

Source: NIST's certified values of Longley's data (Longley.dat, 15 digits; J. Am. Stat. Assoc. 62, 1967,
819-841); statsmodels on stack loss (Brownlee, Statistical Theory and Methodology, 1965, p. 454) and on a
study (tests/golden/paper_study.csv).

Tolerance: 1e-10 against statsmodels, two orthogonal factorizations with a condition below 1e3; 1e-9 against
certified values.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS, code, design_matrix

# Not statsmodels.api, which loads all of the library.
statsmodels = pytest.importorskip("statsmodels.regression.linear_model")
influence_tools = pytest.importorskip("statsmodels.stats.outliers_influence")

GOLDEN = Path(__file__).parents[1] / "golden" / "paper_study.csv"
STUDY_FACTORS = ("web_width", "web_thickness", "pin_length")

# Constant, GNPDEFL, GNP, UNEMP, ARMED, POP, YEAR: coefficient and its standard deviation.
LONGLEY_CERTIFIED = {
    "1": (-3482258.63459582, 890420.383607373),
    "GNPDEFL": (15.0618722713733, 84.9149257747669),
    "GNP": (-0.358191792925910e-01, 0.334910077722432e-01),
    "UNEMP": (-2.02022980381683, 0.488399681651699),
    "ARMED": (-1.03322686717359, 0.214274163161675),
    "POP": (-0.511041056535807e-01, 0.226073200069370),
    "YEAR": (1829.15146461355, 455.478499142212),
}
LONGLEY_R_SQUARED = 0.995479004577296
LONGLEY_RESIDUAL_DEVIATION = 304.854073561965
LONGLEY_F = 330.285339234588


def longley():
    data = pytest.importorskip("statsmodels.datasets").longley.load_pandas()
    return np.asarray(data.exog, dtype=float), np.asarray(data.endog, dtype=float)


def stack_loss():
    data = pytest.importorskip("statsmodels.datasets").stackloss.load_pandas()
    return np.asarray(data.exog, dtype=float), np.asarray(data.endog, dtype=float)


def study():
    with GOLDEN.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if "36" in row["role"]]
    x = np.array([[float(row[name]) for name in STUDY_FACTORS] for row in rows])
    return x, np.array([float(row["axial_compliance_pinned"]) for row in rows])


def compare(figure, form, x, y):
    """Compare every statistic of the fitted polynomial with statsmodels, to 1e-10."""
    ours = fit_form(form, tuple(f"x{i}" for i in range(x.shape[1])), x, y)
    fitted, found = ours.fitted, ours.statistics
    coded = code(x, fitted.center, fitted.half_range, fitted.log_factors)
    matrix = design_matrix(fitted.terms, coded)
    back = np.exp if FORMS[form].logarithmic else np.asarray
    target = np.log(y) if FORMS[form].logarithmic else y
    theirs = statsmodels.OLS(target, matrix).fit()
    influence = theirs.get_influence()
    tight = {"rel": 1e-10}
    # A coefficient may be near 0: to 1e-10 of the largest.
    largest = np.abs(theirs.params).max()
    figure("coefficients, of the largest", found.coefficients, theirs.params, 1e-10, scale=largest)
    assert found.t_values == close(
        theirs.tvalues, rel=1e-9, abs=1e-10 * np.abs(theirs.tvalues).max()
    )
    figure("standard errors", found.standard_errors, theirs.bse, 1e-10)
    assert found.f_value == close(theirs.fvalue, **tight)
    assert found.r_squared == close(theirs.rsquared, **tight)
    assert found.adjusted_r_squared == close(theirs.rsquared_adj, **tight)
    assert found.residual_variance == close(theirs.mse_resid, **tight)
    assert found.leverage == close(influence.hat_matrix_diag, **tight)
    figure("PRESS", found.press, np.sum(influence.resid_press**2), 1e-10)
    q_squared = 1 - np.sum(influence.resid_press**2) / theirs.centered_tss
    assert found.q_squared == close(q_squared, **tight)
    assert found.aic == close(theirs.aic, **tight)
    assert found.bic == close(theirs.bic, **tight)
    assert found.condition_number == close(theirs.condition_number, **tight)
    inflation = [
        influence_tools.variance_inflation_factor(matrix, i) for i in range(1, matrix.shape[1])
    ]
    assert found.variance_inflation == close(inflation, **tight)
    # Of the response itself.
    assert ours.predict(x) == close(back(theirs.fittedvalues), **tight)
    left_out = back(target - influence.resid_press)
    q_squared = 1 - np.sum((y - left_out) ** 2) / np.sum((y - y.mean()) ** 2)
    assert ours.q_squared == close(q_squared, **tight)


@pytest.mark.parametrize("data", [longley, stack_loss], ids=["Longley", "stack loss"])
def test_linear_against_statsmodels(data, figure):
    compare(figure, "linear", *data())


@pytest.mark.parametrize("form", ["interactions", "quadratic", "power law"])
def test_stack_loss_against_statsmodels(form, figure):
    compare(figure, form, *stack_loss())


@pytest.mark.parametrize("form", [name for name in FORMS if FORMS[name].basis == "factors"])
def test_study_against_statsmodels(form, figure):
    compare(figure, form, *study())


def test_longley_against_certified_values(figure):
    x, y = longley()
    found = fit_form("linear", tuple(LONGLEY_CERTIFIED)[1:], x, y)
    for name, (value, deviation) in LONGLEY_CERTIFIED.items():
        figure(f"Longley: coefficient of {name}", found.coefficients[name], value, 1e-9)
        own = found.natural_standard_errors[name]
        figure(f"Longley: its standard deviation, {name}", own, deviation, 1e-9)
    assert set(found.coefficients) == set(found.natural_standard_errors) == set(LONGLEY_CERTIFIED)
    figure("Longley: R^2", found.r_squared, LONGLEY_R_SQUARED, 1e-12)
    figure("Longley: F", found.statistics.f_value, LONGLEY_F, 1e-9)
    deviation = np.sqrt(found.statistics.residual_variance)
    figure("Longley: residual deviation", deviation, LONGLEY_RESIDUAL_DEVIATION, 1e-9)
