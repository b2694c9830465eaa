import itertools
import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.forms import FORMS, FittedForm, form_named, form_terms
from regression.fits.terms import divisors, levels_needed, polynomial_terms, term_name

COUNTS = {  # of three columns
    "linear": 4,
    "interactions": 7,
    "quadratic": 10,
    "power law": 4,
    "log-interactions": 7,
    "log-quadratic": 10,
    "log-cubic": 20,
    "group power law": 4,
    "group quadratic": 10,
    "group cubic": 20,
}


def equation(**changes):
    given = {
        "form": "log-cubic",
        "factors": ("a", "b"),
        "logarithmic": True,
        "log_factors": (True, False),
        "center": (0.5, 2.0),
        "half_range": (0.25, 4.0),
        "terms": ((), (0,), (1,), (0, 0, 1)),
        "coefficients": (1.0, 0.5, -0.25, 0.125),
    }
    return FittedForm(**(given | changes))


def test_each_form_has_its_terms():
    assert {name: len(form_terms(form, 3)) for name, form in FORMS.items()} == COUNTS
    assert form_terms(FORMS["interactions"], 3)[4:] == ((0, 1), (0, 2), (1, 2))


def test_terms_contain_all_that_divides_them():
    terms = polynomial_terms(3, 3, indicators=[2])
    assert (2, 2) not in terms
    assert (0, 0, 1) in terms
    for term in terms:
        for length in range(len(term)):
            assert set(itertools.combinations(term, length)) <= set(terms)
    assert list(terms) == sorted(terms, key=len)


def test_divisors_levels_and_names():
    assert divisors((0, 0, 1)) == {(), (0,), (1,), (0, 0), (0, 1)}
    assert divisors(()) == set()
    assert levels_needed((0, 0, 0, 2)) == {0: 4, 2: 2}
    assert term_name((0, 0, 1), ("a", "b")) == "a^2 * b"
    assert term_name((), ("a",)) == "1"


def test_prediction_by_hand():
    z = ((math.log(3.0) - 0.5) / 0.25, (5.0 - 2.0) / 4.0)
    value = math.exp(1.0 + 0.5 * z[0] - 0.25 * z[1] + 0.125 * z[0] ** 2 * z[1])
    assert float(equation().predict([3.0, 5.0])) == close(value, rel=1e-14)


def test_natural_coefficients_give_the_prediction():
    found = equation()
    natural = found.natural_coefficients()
    # The equation lacks terms that its cubic term brings along.
    assert list(natural)[:4] == list(found.terms)
    assert set(natural) - set(found.terms) == {(0, 0), (0, 1)}
    for a, b in itertools.product((1.5, 3.0), (-2.0, 5.0)):
        u = (math.log(a), b)
        total = sum(c * math.prod(u[i] for i in term) for term, c in natural.items())
        assert float(found.predict([a, b])) == close(math.exp(total), rel=1e-12)


def test_natural_coefficients_in_other_units():
    found = equation()
    natural = found.natural_coefficients((1e-3, 10.0), 1e-9)
    u = (math.log(3.0 / 1e-3), 5.0 / 10.0)
    total = sum(c * math.prod(u[i] for i in term) for term, c in natural.items())
    assert float(found.predict([3.0, 5.0])) == close(1e-9 * math.exp(total), rel=1e-10)


def test_natural_transformation():
    found = equation()
    terms, matrix = found.natural_transformation()
    natural = found.natural_coefficients()
    assert terms == tuple(natural)
    assert matrix @ found.coefficients == close(list(natural.values()), rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"center": (0.5,)}, "center: given 1 values; allowed are 2"),
        ({"coefficients": (1.0, 2.0)}, "coefficients: given 2 values; allowed are 4"),
        ({"log_factors": (True,)}, "log_factors: given 1 values"),
        ({"half_range": (0.25, 0.0)}, "half_range: .* all must be positive"),
        ({"center": (0.5, np.nan)}, "center: .* all numbers must be finite"),
        ({"terms": ((), (0,), (1,), (1, 0))}, r"terms: given \[1, 0\]; allowed .* in rising order"),
        ({"terms": ((), (0,), (1,), (2,))}, r"terms: given \[2\]; allowed are numbers of columns"),
        ({"terms": ((), (0,), (1,), (1,))}, "terms: given .*; each is allowed once"),
    ],
)
def test_contradictory_equations(changes, match):
    with pytest.raises(InputError, match=match):
        equation(**changes)


def test_points_that_cannot_be_evaluated():
    with pytest.raises(InputError, match=r"x: given an array of shape \(3,\); its last axis"):
        equation().predict([1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="x: given -3; allowed are positive values"):
        equation().predict([-3.0, -2.0])
    # Columns that are not logged may be negative.
    assert np.isfinite(equation().predict([3.0, -2.0]))


def test_unknown_form():
    with pytest.raises(InputError, match="form: given 'cubic'; allowed are linear, interactions"):
        form_named("cubic")
