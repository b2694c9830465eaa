"""Optima, and sensitivities."""

import itertools
import math

import numpy as np
import pytest
from scipy import stats

from comparing import close
from crankbase.errors import InputError
from refusals import refusals_of, refused
from regression.fits import fits as module
from regression.fits.fits import (
    JudgedEquation,
    expected_errors,
    fit_form,
    lacking_terms,
    worst_places,
)
from regression.fits.forms import FittedForm
from regression.fits.sensitivity import (
    SOBOL_POINTS,
    SOBOL_SEED,
    constrained_indices,
    elasticities,
    region_sample,
    sobol_indices,
)
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.optimum import Limit, Points, find_optimum, worst_values
from regression.plans.factors import Factor

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}
FIXED = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "fillet_radius": 0.012,
}
THROW = {**FIXED, "web_width": 0.300, "web_thickness": 0.068, "pin_length": 0.139}


def grid(box, levels):
    return np.array(list(itertools.product(*(np.linspace(*ends, levels) for ends in box.values()))))


def axial(x):
    width, thickness, length = x.T
    return 1.4e-9 * (width / 0.3) ** -0.8 * (thickness / 0.07) ** -1.2 * (length / 0.14) ** 0.4


def mass(x):
    width, thickness, length = x.T
    return 7850.0 * (2.0 * width * thickness * 0.35 + 0.025 * (length + 0.12))


def response(form, function, symbol, unit, box=BOX, **others):
    x = grid(box, 3)
    held = np.array([np.mean(ends) for ends in box.values()])[None] * [[1.01], [0.98]]
    fit = fit_form(form, tuple(box), x, function(x), held, function(held))
    return ResponseModel.from_fit(fit, symbol=symbol, unit=unit, **others)


@pytest.fixture(scope="module")
def model():
    return ComplianceModel(
        responses={
            "axial_compliance": response("log-quadratic", axial, "e_n", "m/N", fe_error=0.01),
            "mass": response("quadratic", mass, "m", "kg", fe_error=1e-4),
        },
        fixed=FIXED,
        ranges=BOX,
        throw=THROW,
    )


@pytest.mark.slow
def test_lightest_throw_against_a_grid(model):
    limit = Limit(("axial_compliance",), at_most=1.1e-9, unit="m/N")
    found = find_optimum(model, "mass", [limit])
    points = 41
    x = grid(BOX, points)
    rows = Points(model, dict(zip(BOX, x.T, strict=True)))
    weights = rows.band("mass")[0]
    kept = worst_values(limit, rows, margins=True) <= 1.1e-9
    assert 0 < kept.sum() < len(x)
    best = weights[kept].min()
    assert found.value <= best * (1.0 + 1e-9)
    # One step of the grid in each dimension at the optimum changes the mass by this at most.
    steps = [np.ptp(ends) / (points - 1) for ends in BOX.values()]
    at = np.array([[found.factors[name] for name in BOX]])
    change = sum(
        float(mass(at + np.eye(3)[n] * step)[0] - mass(at)[0]) for n, step in enumerate(steps)
    )
    assert best - found.value <= change
    (check,) = found.limits
    assert check.active
    assert check.worst <= 1.1e-9
    assert check.worst == close(1.1e-9, rel=1e-6)
    assert found.lookups["axial_compliance"].upper == close(check.worst, rel=1e-12)
    assert all(answer.inside for answer in found.lookups.values())
    assert found.throw.web_thickness == found.factors["web_thickness"]
    assert all(name in repr(found) for name in ("web_thickness", "axial_compliance"))


@pytest.mark.slow
def test_a_frequency_as_a_function_of_the_compliance(model):
    # A mass of 500 kg on the throw's stiffness: f = sqrt(1 / (m e)) / (2 pi).
    def frequency(compliance):
        return (1.0 / (500.0 * compliance)) ** 0.5 / (2.0 * np.pi)

    limit = Limit(("axial_compliance",), at_least=200.0, function=frequency, name="f", unit="Hz")
    found = find_optimum(model, "web_thickness", [limit])
    needed = 1.0 / (500.0 * (2.0 * np.pi * 200.0) ** 2)
    same = find_optimum(
        model, "web_thickness", [Limit(("axial_compliance",), at_most=needed, name="e")]
    )
    assert found.value == close(same.value, rel=1e-6)
    assert found.limits[0].worst == close(200.0, rel=1e-6)
    assert found.limits[0].value > found.limits[0].worst


@pytest.mark.slow
def test_without_margins_the_worst_value_is_still_that_of_the_band(model):
    limit = Limit(("axial_compliance",), at_most=1.1e-9)
    (check,) = find_optimum(model, "mass", [limit], margins=False).limits
    assert check.value == close(1.1e-9, rel=1e-6)
    assert check.active
    assert check.worst > 1.0001 * check.value


def test_categories_are_tried_each():
    x = np.array([[h, label] for h in np.linspace(0.04, 0.10, 5) for label in (0.0, 1.0)])

    def stiff(x):
        return 1e-9 * (x[:, 0] / 0.07) ** -1.0 * (1.0 - 0.1 * x[:, 1])

    fit = fit_form("log-quadratic", ("web_thickness", "web_outline=rectangle"), x, stiff(x))
    model = ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"web_thickness": (0.04, 0.10)},
        categories={"web_outline": ("obround", "rectangle")},
    )
    limit = Limit(("axial_compliance",), at_most=1e-9)
    found = find_optimum(model, "web_thickness", [limit], margins=False)
    assert found.factors["web_outline"] == "rectangle"
    assert found.value == close(0.063, rel=1e-6)
    obround = find_optimum(
        model, "web_thickness", [limit], margins=False, fixed={"web_outline": "obround"}
    )
    assert obround.value == close(0.070, rel=1e-6)


@pytest.mark.slow
def test_relations_and_constraints_are_kept():
    x = np.linspace(1.2, 1.9, 5)[:, None]
    box = {"width_ratio": (1.2, 1.9), "web_thickness": (0.04, 0.10)}

    def stiff(x):
        return 1e-9 / (x[:, 0] / 1.6) / (x[:, 1] / 0.07)

    x = grid(box, 4)
    fit = fit_form("log-quadratic", tuple(box), x, stiff(x))
    model = ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        fixed=FIXED | {"pin_length": 0.139},
        ranges=box,
        relations={"web_width": "width_ratio * pin_diameter"},
        constraints=("web_width <= 4 * web_thickness",),
        throw=THROW,
    )
    limit = Limit(("axial_compliance",), at_most=1e-9)
    found = find_optimum(model, "web_thickness", [limit], margins=False)
    # The wide web that the compliance alone would take breaks the constraint: B = 4 h and
    # B h = 1.6 D 0.07 meet at h^2 = 0.4 D 0.07.
    assert found.value == close((0.4 * 0.18 * 0.07) ** 0.5, rel=1e-6)
    assert found.dimensions["web_width"] == close(4.0 * found.value, rel=1e-6)
    assert found.throw.web_width == found.dimensions["web_width"]
    narrow = find_optimum(model, "web_width", [limit], margins=False)
    assert narrow.value == close(1.2 * 0.18, rel=1e-9)


def test_a_throw_that_cannot_be_built_is_told():
    box = {"web_width": (0.150, 0.330)}
    made = response("quadratic", lambda x: 1e-9 * (2.0 - x[:, 0]), "e_n", "m/N", box)
    model = ComplianceModel(
        responses={"axial_compliance": made}, ranges=box, throw=THROW | {"web_width": 0.3}
    )
    found = find_optimum(model, "web_width")
    assert found.value == 0.150
    assert (found.throw, len(found.remarks)) == (None, 1)


@pytest.mark.slow
def test_what_cannot_be_kept_is_told_with_how_near_one_comes(model):
    impossible = Limit(("axial_compliance",), at_most=0.5e-9, unit="m/N")
    with pytest.raises(InputError) as caught:
        find_optimum(model, "mass", [impossible])
    text = str(caught.value)
    stiffest = {"web_width": 0.330, "web_thickness": 0.098, "pin_length": 0.120}
    nearest = model.lookup("axial_compliance", **stiffest).upper
    assert f"{1e9 * nearest:.6g}e-9 m/N" in text
    assert "web_width 330 mm, web_thickness 98 mm, pin_length 120 mm" in text


@pytest.mark.slow
def test_two_limits_against_each_other(model):
    limits = [Limit(("axial_compliance",), at_most=0.9e-9), Limit(("mass",), at_most=120.0)]
    with refused("limits"):
        find_optimum(model, "web_thickness", limits)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("color", []), "minimize"),
        (("mass", [Limit(("hue",), at_most=1.0)]), "quantity"),
    ],
)
def test_unknown_names(model, arguments, match):
    with refused(match):
        find_optimum(model, *arguments)


@pytest.mark.parametrize(
    ("fixed", "match"),
    [
        ({"crank_radius": 0.17}, "fixed: given crank_radius; allowed are the factors web_width"),
        ({"web_width": 0.4}, "fixed: given 400 mm for web_width; allowed is 270 mm to 330 mm"),
        ({"color": 0.4}, "color: unknown dimension"),
    ],
)
def test_unusable_fixed_factors(model, fixed, match):
    with pytest.raises(InputError, match=match):
        find_optimum(model, "mass", [], fixed=fixed)


test_unusable_limits = refusals_of(
    lambda arguments: Limit(**arguments),
    ({"quantities": ("mass",)}, "limit on mass"),
    ({"quantities": ("mass",), "at_most": 1.0, "at_least": 0.0}, "limit on mass"),
    ({"quantities": ("mass",), "at_most": float("nan")}, "limit on mass"),
    ({"quantities": (), "at_most": 1.0}, "limit"),
    ({"quantities": "mass", "at_most": 1.0}, "limit"),
    ({"quantities": ("mass", "web_width"), "at_most": 1.0}, "limit on mass, web_width"),
)


def test_a_box_of_one_throw_is_that_throw_and_limits_may_take_fixed_dimensions(model):
    only = {name: np.mean(ends) for name, ends in BOX.items()}
    limit = Limit(("mass", "crank_radius"), at_most=1e4, function=lambda m, r: m * r, name="moment")
    found = find_optimum(model, "mass", [limit], fixed=only)
    assert found.value == close(mass(np.array([[*only.values()]]))[0], rel=1e-6)
    assert found.limits[0].value == close(found.value * FIXED["crank_radius"])


def test_a_function_without_a_value_is_refused(model):
    limit = Limit(("mass",), at_most=1.0, function=lambda _: float("nan"), name="f")
    with refused("f"):
        find_optimum(model, "mass", [limit])


A, B = Factor("a", "m", 1.0, 2.0), Factor("b", "m", 1.0, 3.0)
KIND = Factor.of_labels("kind", ("x", "y", "z"))


def test_elasticities_of_a_fitted_form_are_its_derivatives():
    # d ln y / d ln a = (d y / d a) a / y, with y = 1 + 0.5 z^2 + 0.2 z w, z = 2 a - 3, w = b - 2.
    terms, coefficients = ((), (0, 0), (0, 1)), (1.0, 0.5, 0.2)
    form = FittedForm(
        form="quadratic",
        factors=("a", "b"),
        logarithmic=False,
        log_factors=(False, False),
        center=(1.5, 2.0),
        half_range=(0.5, 1.0),
        terms=terms,
        coefficients=coefficients,
    )
    a, b = 1.8, 2.4
    z, w = 2 * a - 3, b - 2
    y = 1 + 0.5 * z**2 + 0.2 * z * w
    expected = [(z + 0.2 * w) * 2 * a / y, 0.2 * z * b / y]
    assert elasticities(form.predict, (A, B), (a, b)) == close(expected, rel=1e-6)


def test_elasticities_of_a_negative_response():
    """Differences are of y, not of its logarithm: a reaction may be negative."""
    found = elasticities(lambda x: -1e-9 * x[:, 0] ** 3 / x[:, 1], (A, B), (1.5, 2.0))
    assert found == close([3.0, -1.0], rel=1e-6)


def test_elasticity_at_nothing():
    def through_zero(x):
        return 3.0 + x[:, 0]

    zero = Factor("a", "m", 0.0, 1.0)
    assert elasticities(through_zero, (zero,), (0.0,)) == [0.0]
    with refused("nominal"):
        elasticities(lambda x: x[:, 0], (zero,), (0.0,))


def test_sobol_indices_of_ishigami():
    """Ishigami and Homma 1990, a = 7, b = 0.1: the usual test, with its closed-form variances."""

    def ishigami(x):
        return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    pi = math.pi
    v1 = 0.5 * (1 + 0.1 * pi**4 / 5) ** 2
    v2 = 7**2 / 8
    v13 = 0.1**2 * pi**8 * (1 / 18 - 1 / 50)
    total = v1 + v2 + v13
    found = sobol_indices(ishigami, [Factor(name, "m", -pi, pi) for name in "abc"])
    assert list(found.first) == ["a", "b", "c"]
    assert [*found.first.values()] == close([v1 / total, v2 / total, 0.0], abs=0.01)
    assert [*found.total.values()] == close([(v1 + v13) / total, v2 / total, v13 / total], abs=0.01)


def test_sobol_indices_are_those_of_scipy():
    factors = [*UNIT[:2], KIND]

    def product(x):
        return 1e-9 * (1 + x[:, 0] ** 2) * (2 + np.sin(9.0 * x[:, 1])) * (1 + x[:, 2])

    spreads = [stats.uniform(0.0, 1.0)] * 2 + [stats.randint(0, len(KIND.labels))]
    theirs = stats.sobol_indices(
        func=lambda x: 1e9 * product(x.T), n=SOBOL_POINTS, dists=spreads, rng=SOBOL_SEED
    )
    found = sobol_indices(product, factors)
    assert [*found.first.values()] == close(theirs.first_order.ravel(), rel=1e-12, abs=1e-14)
    assert [*found.total.values()] == close(theirs.total_order.ravel(), rel=1e-12, abs=1e-14)


def test_one_factor_has_all_of_the_variance():
    found = sobol_indices(lambda x: x[:, 0] ** 2, [Factor("a", "m", 1.0, 2.0)])
    assert found.first == found.total == {"a": 1.0}
    assert sobol_indices(lambda x: 0.0 * x[:, 0] + 3.0, [Factor("a", "m", 1.0, 2.0)]) is None


UNIT = [Factor(name, "m", 0.0, 1.0) for name in "abc"]


def triangle(x):
    return x[:, 0] + x[:, 1] <= 1.0


@pytest.fixture(scope="module")
def over_triangle():
    """A triangle, where two factors have the variance 1/18 and the covariance -1/36, and a free factor."""
    return region_sample(UNIT, triangle)


@pytest.mark.parametrize("slopes", [(1.0, 1.0, 0.5), (3.0, -1.0, 0.0), (2.0, 1.0, 1.0)])
def test_a_plane_over_a_triangle(over_triangle, slopes):
    """E(b | a) = (1 - a) / 2 and E Var(b | a) = 1/24 give every index."""
    a, b, c = slopes
    found = constrained_indices(lambda x: x @ np.array(slopes), over_triangle)
    variance = (a * a + b * b - a * b) / 18 + c * c / 12
    free = c * c / 12
    first = [(a - b / 2) ** 2 / 18, (b - a / 2) ** 2 / 18, free]
    total = [a * a / 24, b * b / 24, free]
    both = (a * a + b * b - a * b) / 18
    shapley = [(total[0] + both - total[1]) / 2, (total[1] + both - total[0]) / 2, free]
    for given, expected in ((found.first, first), (found.total, total), (found.shapley, shapley)):
        assert [*given.values()] == close([value / variance for value in expected], abs=0.015)
    assert sum(found.shapley.values()) == close(1.0)


def test_a_region_that_is_the_box_has_the_usual_indices():
    factors = [*UNIT[:2], KIND]

    def product(x):
        return (1 + x[:, 0]) * (2 + x[:, 1]) * (1 + x[:, 2])

    usual = sobol_indices(product, factors)
    sample = region_sample(factors, lambda x: np.ones(len(x), dtype=bool))
    found = constrained_indices(product, sample)
    assert found.first == close(usual.first, abs=0.025)
    assert found.total == close(usual.total, abs=0.025)
    for name, share in found.shapley.items():
        assert usual.first[name] - 0.015 < share < usual.total[name] + 0.015


@pytest.mark.slow
def test_a_thin_region_that_leaves_one_freedom():
    """Where a and b are nearly the same, each tells all alone, nothing is left without it, and they share."""
    sample = region_sample(UNIT[:2], lambda x: np.abs(x[:, 0] - x[:, 1]) < 0.01)
    found = constrained_indices(lambda x: x[:, 0] + x[:, 1], sample)
    shares = zip((found.first, found.total, found.shapley), (1.0, 0.0, 0.5), strict=True)
    for share, each in shares:
        assert [*share.values()] == close([each, each], abs=0.015)


def test_what_does_not_vary_and_what_is_not_found(over_triangle):
    assert constrained_indices(lambda x: np.full(len(x), 3e-9), over_triangle) is None
    assert region_sample(UNIT, lambda x: np.zeros(len(x), dtype=bool), count=64) is None


RNG = np.random.default_rng(3)
PLACES = RNG.uniform(0.5, 3.0, (6, 2))
RUNS = RNG.uniform(1.0, 2.0, (15, 2))


def sensitivity_response(x):
    return 2.0 + np.sin(2.0 * x[:, 0]) + x[:, 0] * x[:, 1]


def judged(form="quadratic", runs=RUNS, places=PLACES):
    fit = fit_form(form, ("a", "b"), runs, sensitivity_response(runs))
    target = sensitivity_response(runs)
    return JudgedEquation(fit, runs, target, places, np.full(len(places), 2.0))


def test_terms_of_one_degree_more_are_lacking():
    fit = fit_form("linear", ("a", "b=x"), np.array([[1, 0], [2, 1], [3, 0]]), [1, 2, 3])
    assert set(fit.fitted.terms) == {(), (0,), (1,)}
    assert lacking_terms(fit) == ((0, 0), (0, 1))  # a column of 0 and 1 has no square


def columns(equation, x):
    form = equation.fit.fitted
    z = (x - np.array(form.center)) / np.array(form.half_range)

    def powers(terms):
        return np.column_stack([np.prod(z[:, list(term)], axis=1) for term in terms])

    return powers(form.terms), powers(lacking_terms(equation.fit))


def posterior(equation, ratio, variance, runs):
    """Covariance of the response at places, given runs, by a wide prior of the equation's own terms."""
    own, further = columns(equation, np.vstack([equation.places, runs]))
    wide = 1e7 * variance
    covariance = variance * further @ further.T + wide * own @ own.T
    count = len(equation.places)
    at_runs = covariance[count:, count:] + ratio * variance * np.eye(len(runs))
    cross = covariance[:count, count:]
    return covariance[:count, :count] - cross @ np.linalg.solve(at_runs, cross.T)


def test_a_run_changes_them_by_what_it_tells(monkeypatch):
    monkeypatch.setattr(module, "_likeliest", lambda *_: (0.01, 0.3))
    equation = judged()
    found = expected_errors(equation).after_run(4)
    expected = posterior(equation, 0.01, 0.3, np.vstack([RUNS, PLACES[4:5]])) / 4.0
    assert found.squares == close(np.diag(expected), rel=1e-4)


@pytest.mark.parametrize("form", ["linear", "quadratic"])
def test_the_worst_places_lie_outside_the_runs_and_apart(form):
    grid = np.array([[a, b] for a in np.linspace(0.8, 2.2, 8) for b in np.linspace(0.8, 2.2, 8)])
    chosen = grid[worst_places([judged(form, places=grid)], 4)]
    assert chosen[0].tolist() in [[a, b] for a in (0.8, 2.2) for b in (0.8, 2.2)]
    assert np.any((chosen == 0.8) | (chosen == 2.2), axis=1).all()
    distances = np.linalg.norm(chosen[:, None] - chosen, axis=2)
    assert distances[~np.eye(4, dtype=bool)].min() > 0.5


def test_as_many_runs_as_coefficients_tell_nothing_of_the_error():
    runs = np.array([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]])
    found = expected_errors(judged("linear", runs=runs))
    assert np.all(np.isfinite(found.squares))
    assert np.all(found.squares > 0.0)
