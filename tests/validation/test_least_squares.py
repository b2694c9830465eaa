"""Ordinary least squares against statsmodels, and Longley's data against certified values.

Longley (J. W. Longley, Journal of the American Statistical Association 62, 1967, pp. 819-841) is
the standard test of accuracy on nearly dependent columns; the certified coefficients are those of
the NIST Statistical Reference Datasets.
"""

import numpy as np
import pytest

from regression.fits import fit_form
from regression.forms import FORMS, code, design_matrix, form_terms

statsmodels = pytest.importorskip("statsmodels.api")

# Constant, GNPDEFL, GNP, UNEMP, ARMED, POP, YEAR.
LONGLEY_CERTIFIED = [
    -3482258.63459582,
    15.0618722713733,
    -0.358191792925910e-01,
    -2.02022980381683,
    -1.03322686717359,
    -0.511041056535807e-01,
    1829.15146461355,
]
LONGLEY_R_SQUARED = 0.995479004577296


def longley():
    data = pytest.importorskip("statsmodels.datasets").longley.load_pandas()
    return np.asarray(data.exog, dtype=float), np.asarray(data.endog, dtype=float)


def compare(form, x, y):
    """Compare coefficients, fitted values, R2 and leave-one-out with statsmodels, to 1e-10."""
    factors = tuple(f"x{i}" for i in range(x.shape[1]))
    ours = fit_form(form, factors, x, y)
    fitted, logarithmic = ours.fitted, FORMS[form].logarithmic
    matrix = design_matrix(
        form_terms(FORMS[form], x.shape[1]),
        code(x, fitted.center, fitted.half_range, logarithmic),
    )
    theirs = statsmodels.OLS(np.log(y) if logarithmic else y, matrix).fit()
    assert fitted.coefficients == pytest.approx(theirs.params, rel=1e-10, abs=1e-10 * abs(y).max())
    back = np.exp if logarithmic else np.asarray
    assert ours.predict(x) == pytest.approx(back(theirs.fittedvalues), rel=1e-10)
    influence = theirs.get_influence()
    left_out = back(theirs.model.endog - influence.resid_press)
    q_squared = 1 - np.sum((y - left_out) ** 2) / np.sum((y - y.mean()) ** 2)
    assert ours.q_squared == pytest.approx(q_squared, rel=1e-10)
    if not logarithmic:
        assert ours.r_squared == pytest.approx(theirs.rsquared, rel=1e-10)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", range(3))
def test_random_designs(form, seed):
    rng = np.random.default_rng(seed)
    x = rng.uniform([0.27, 0.038, 0.12], [0.33, 0.098, 0.158], size=(40, 3))
    y = 0.1 / (x[:, 0] * x[:, 1]) + 30 * x[:, 2] + rng.normal(0, 0.1, 40)
    compare(form, x, y)


def test_longley_against_statsmodels():
    compare("linear", *longley())


def test_longley_against_certified_values():
    x, y = longley()
    found = fit_form("linear", ("GNPDEFL", "GNP", "UNEMP", "ARMED", "POP", "YEAR"), x, y)
    assert list(found.coefficients.values()) == pytest.approx(LONGLEY_CERTIFIED, rel=1e-10)
    assert found.r_squared == pytest.approx(LONGLEY_R_SQUARED, rel=1e-12)


def test_stack_loss():
    data = pytest.importorskip("statsmodels.datasets").stackloss.load_pandas()
    x, y = np.asarray(data.exog, dtype=float), np.asarray(data.endog, dtype=float)
    compare("linear", x, y)
    compare("quadratic", x, y)
