"""Gaussian processes of values and slopes: their covariances, likelihood, predictions and bands."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankfem.analyses.study.fit_records import compliance_model, fitted_study
from crankfem.analyses.study.response_fits import fit_study
from crankfem.analyses.study.studies import worst_designs
from refusals import refused
from regression.fits.fits import JudgedEquation, expected_errors, fit_form
from regression.fits.forms import FORMS, code
from regression.fits.gaussian_process import (
    MOST_ROWS,
    Kriging,
    Rows,
    correlation_slopes,
    correlations,
    process_of,
)
from regression.models.compliance_model import ComplianceModel
from regression.plans.plan import StudyPlan
from sloped_studies import FACTORS, NAME, box, plan, slopes_of, table_with_slopes

PROCESS = "Gaussian process"
AT = {"web_width": 0.3, "web_thickness": 0.06, "pin_length": 0.14}


def rows_of(seed, columns=3, values=5, slopes=6):
    """Values at random points, and slopes in random directions at some of them."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.0, 1.0, (values, columns))
    return Rows.at(points).with_slopes(
        rng.integers(0, values, slopes), rng.normal(size=(slopes, columns))
    )


def wave(x):
    """A response that no low polynomial follows."""
    return 1e-9 * (1.5 + np.sin(40.0 * x[:, 1] + 3.0 * x[:, 0])) * (1.0 + x[:, 2])


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 1000), columns=st.integers(1, 4))
def test_covariances_of_slopes_are_derivatives_of_those_of_values(seed, columns):
    first, second = rows_of(seed, columns), rows_of(seed + 1, columns)
    scales = np.random.default_rng(seed).uniform(0.5, 3.0, columns)
    step = 1e-4

    def by_differences(rows, covariance):
        """Central differences along each row's direction; a value has none."""
        ends = [
            covariance(Rows.at(rows.points + sign * step * rows.directions)) for sign in (1, -1)
        ]
        slopes = (ends[0] - ends[1]) / (2.0 * step)
        return np.where(rows.is_value[:, None], covariance(Rows.at(rows.points)), slopes)

    expected = by_differences(
        first,
        lambda rows: by_differences(second, lambda others: correlations(others, rows, scales)).T,
    )
    assert correlations(first, second, scales) == close(expected, rel=1e-5, abs=1e-6)


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 1000))
def test_slopes_of_the_likelihood(seed):
    rng = np.random.default_rng(seed)
    rows, y = rows_of(seed, 2, 7, 4), rng.normal(size=11)
    place = rng.uniform(-0.5, 0.5, 4) - np.array([0.0, 0.0, 4.0, 3.0])

    def misfit(place):
        return Kriging(rows, np.exp(place[:2]), np.exp(place[2:])).misfit(y)

    step = 1e-5 * np.eye(4)
    expected = [(misfit(place + one)[0] - misfit(place - one)[0]) / 2e-5 for one in step]
    assert misfit(place)[1] == close(expected, rel=1e-4, abs=1e-5)
    symmetric = np.add.outer(y, y)
    scales = np.exp(place[:2])
    changes = [
        correlations(rows, rows, scales * np.exp(one[:2]))
        - correlations(rows, rows, scales * np.exp(-one[:2]))
        for one in step[:2]
    ]
    expected = [np.sum(symmetric * change) / 2e-5 for change in changes]
    assert correlation_slopes(rows, scales, symmetric) == close(expected, rel=1e-5, abs=1e-6)


def test_values_and_slopes_are_met_and_a_linear_function_is_the_mean():
    rows = rows_of(3)
    exact = Kriging(rows, np.array([1.0, 2.0, 1.5]), (1e-9, 1e-9))
    y = np.random.default_rng(3).normal(size=11)
    process, mean = process_of(exact, y), exact.coefficients(y)

    def function(points):
        return mean[0] + points @ mean[1:] + process.predict(points)

    step = 1e-5 * rows.directions
    slopes = (function(rows.points + step) - function(rows.points - step)) / 2e-5
    found = np.where(rows.is_value, function(rows.points), slopes)
    assert found == close(y, rel=1e-4, abs=1e-4)
    assert process.deviations(rows.points) == close(0.0, abs=1e-3 * process.variance**0.5)
    linear = rows.mean_terms @ [1.0, 0.5, -2.0, 3.0]
    assert exact.coefficients(linear) == close([1.0, 0.5, -2.0, 3.0], rel=1e-6)
    assert exact.projected @ linear == close(0.0, abs=1e-5)


def test_a_run_is_left_out_with_its_slopes():
    rows = Rows.at(box(6, 1) * 10.0).with_slopes(np.array([0, 0, 2]), np.eye(3))
    y = np.random.default_rng(1).normal(size=9)
    groups = np.array([[0, 6, 7], [1, 1, 1], [2, 8, 2], [3, 3, 3], [4, 4, 4], [5, 5, 5]])
    whole = Kriging(rows, np.array([0.5, 0.6, 0.4]), (1e-3, 1e-2))
    found, deviations = whole.left_out(y, groups)
    for run, group in enumerate(groups):
        others = np.setdiff1d(np.arange(9), group)
        rest = Kriging(rows.chosen(others), whole.scales, whole.noises)
        points = rows.points[[run]]
        weights = rest.projected @ y[others]
        expected = Rows.at(points).mean_terms @ rest.coefficients(y[others])
        expected += correlations(Rows.at(points), rest.rows, rest.scales) @ weights
        assert found[run] == close(expected[0], rel=1e-8)
        expected = np.sqrt(whole.variance(y) * rest.variances(points))
        assert deviations[run] == close(expected[0], rel=1e-8)


@pytest.mark.parametrize("runs", [14, 40])
def test_a_process_follows_what_no_polynomial_does(runs):
    x, at = box(runs, 2), box(60, 3)
    slopes = slopes_of(wave, x) if runs == 14 else None

    def errors(form):
        fit = fit_form(form, FACTORS, x, wave(x), at, wave(at), slopes=slopes, drop_terms=True)
        return fit.largest_heldout_error

    assert errors(PROCESS) < 0.1 * min(map(errors, ("quadratic", "log-quadratic", "power law")))


def test_the_band_holds_new_values():
    x, judges, fresh = box(12, 2), box(20, 3), box(200, 4)
    fit = fit_form(
        PROCESS, FACTORS, x, wave(x), judges, wave(judges), slopes=slopes_of(wave, x)
    ).fitted
    logged = np.log(fresh) if fit.log_factors[0] else fresh
    coded = (logged - fit.center) / np.array(fit.half_range)
    missed = np.abs(np.log(fit.predict(fresh) / wave(fresh)))
    held = missed <= fit.process.band * fit.process.deviations(coded)
    assert np.mean(held) >= 0.93
    # Not by wide bands: half of the values use at least a tenth of theirs.
    assert np.median(missed / (fit.process.band * fit.process.deviations(coded))) > 0.1


def test_negative_responses_are_fitted_without_their_logarithm():
    def function(x):
        return wave(x) - 1.4e-9

    x, at = box(16, 2), box(30, 3)
    fit = fit_form(PROCESS, FACTORS, x, function(x), slopes=slopes_of(function, x)).fitted
    assert (fit.logarithmic, fit.log_factors) == (False, (True,) * 3)
    assert fit.predict(at) == close(function(at), abs=0.02e-9)


@pytest.mark.parametrize("runs", [4, 5])
@pytest.mark.parametrize("function", [wave, lambda x: np.ones(len(x)), lambda x: 1e-9 / x[:, 1]])
def test_few_runs_and_plain_responses(runs, function):
    """With as many runs as coefficients of the mean none can be left out; a power law is the mean."""
    x, at = box(runs, 5), box(20, 6)
    fit = fit_form(PROCESS, FACTORS, x, function(x), at, function(at))
    assert (fit.q_squared is None) == (runs == 4)
    if function is not wave:
        assert fit.predict(at) == close(function(at), rel=1e-6)


def test_more_rows_than_it_keeps_are_refused():
    x = box(MOST_ROWS // 3, 1)
    with refused("runs"):
        fit_form(PROCESS, FACTORS, x, wave(x), slopes=slopes_of(wave, x))


@pytest.fixture(scope="module")
def study():
    table = table_with_slopes(plan(runs=8, held_out=20, form=PROCESS))
    fits = fit_study(table)
    return table, fits, compliance_model(table, fits)


def test_a_study_names_the_form(study):
    table, fits, model = study
    response = fits["axial_compliance"]
    assert response.chosen.form == PROCESS
    assert {fit.form for fit in response.fits} > {"power law", "log-quadratic", PROCESS}
    assert fitted_study(table, fits, model).fits["axial_compliance"].selected().form == PROCESS
    plain = replace(table, plan=replace(table.plan, form=None))
    assert PROCESS not in {fit.form for fit in fit_study(plain)["axial_compliance"].fits}
    asked = fit_study(plain, PROCESS)["axial_compliance"]
    assert asked.fit_named(PROCESS).fitted == response.chosen.fitted
    both = fit_study(table, "power law")["axial_compliance"]
    assert (both.chosen.form, both.fit_named("power law").form) == (PROCESS, "power law")
    assert StudyPlan.from_record(table.plan.as_record()) == table.plan
    assert "form" not in plain.plan.as_record()


def test_a_stored_process_gives_the_same_values_bands_and_slopes(study, tmp_path):
    table, fits, model = study
    path = tmp_path / "model.json"
    model.save(path)
    loaded = ComplianceModel.load(path)
    found = loaded.lookup("axial_compliance", **AT)
    assert found == model.lookup("axial_compliance", **AT)
    places = dict(zip(FACTORS, table.values.T, strict=True))
    many = loaded.lookups("axial_compliance", **places)
    values = table.responses[NAME]
    assert np.mean((many.lower <= values) & (values <= many.upper)) > 0.95
    one = loaded.lookup("axial_compliance", **{name: v[3] for name, v in places.items()})
    assert (one.value, one.lower, one.upper) == close(
        (many.value[3], many.lower[3], many.upper[3]), rel=1e-9
    )
    assert many.value == close(fits["axial_compliance"].chosen.predict(table.values), rel=1e-9)
    # Wider between the runs than at one.
    width = (many.upper - many.lower) / many.value
    assert np.ptp(width) > 0.0
    for name, slope in loaded.slopes("axial_compliance", **AT).items():
        ends = [
            loaded.value("axial_compliance", **AT | {name: AT[name] * (1.0 + s)})
            for s in (1e-5, -1e-5)
        ]
        assert slope.value == close((ends[0] - ends[1]) / (2e-5 * AT[name]), rel=1e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_process_of_another_size(sign):
    """In logarithms, and without them for negative values: values and deviations by the same factor."""
    x, at = box(16, 2), box(30, 3)
    fit = fit_form(PROCESS, FACTORS, x, sign * wave(x)).fitted
    other = fit.scaled(1.25)
    assert other.logarithmic == (sign > 0.0)
    assert other.predict(at) == close(
        1.25 * fit.predict(at), rel=1e-9
    )  # sums of weights of either sign
    coded = code(at, fit.center, fit.half_range, fit.log_factors)
    width = 1.0 if other.logarithmic else 1.25
    assert other.process.deviations(coded) == close(width * fit.process.deviations(coded), rel=1e-9)


def test_other_models_are_written_as_before(study, tmp_path):
    table, *_ = study
    plain = replace(table, plan=replace(table.plan, form=None))
    model = compliance_model(plain, fit_study(plain))
    model.save(tmp_path / "model.json")
    assert '"process"' not in (tmp_path / "model.json").read_text()


def test_further_runs_are_where_the_process_is_least_known(study):
    table, fits, _ = study
    fit, runs = fits["axial_compliance"].chosen, ~table.held_out
    places = box(40, 9)
    judged = JudgedEquation(
        fit, table.values[runs], np.log(table.responses[NAME][runs]), places, np.ones(40)
    )
    errors = expected_errors(judged)
    form = fit.fitted
    coded = (np.log(places) - form.center) / np.array(form.half_range)
    noise = form.process.variance * form.process.noises[0]
    assert errors.squares + noise == close(form.process.deviations(coded) ** 2, rel=1e-6)
    worst = int(np.argmax(errors.squares))
    after = errors.after_run(worst)
    assert after.squares[worst] < 0.5 * errors.squares[worst]
    assert np.all(after.squares <= errors.squares * (1.0 + 1e-9))
    assert worst_designs(table, fits, 2).shape == (2, 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda _, over: over, {0}),
        (lambda run, over: dict.fromkeys(over, 0.0) if run == 5 else over, {2, 3}),
        (lambda _, over: over | {"pin_length": -over["pin_length"]}, {12}),
    ],
    ids=["none", "those of a run", "all over a factor"],
)
def test_wrong_slopes_are_found_by_the_process(change, expected):
    table = table_with_slopes(plan(runs=12, form=PROCESS), change)
    found = fit_study(table)["axial_compliance"]
    # One of the three is nearly as flat as its wrong slope says.
    assert 36 - found.slopes in expected
    assert found.chosen.largest_heldout_error < 0.01


def test_the_text_says_what_it_is(study):
    _, fits, model = study
    text = model.responses["axial_compliance"].equation
    assert "no equation" in text
    assert "8 values and 24 slopes" in text
    assert fits["axial_compliance"].chosen.statistics is None
    assert set(fits["axial_compliance"].chosen.coefficients) == {
        "1",
        "ln(web_width)",
        "ln(web_thickness)",
        "ln(pin_length)",
    }
    assert PROCESS not in FORMS


def test_a_study_without_slopes():
    table = table_with_slopes(replace(plan(runs=20), slopes=False, form=PROCESS))
    found = fit_study(table)["axial_compliance"]
    assert (found.slopes, found.chosen.form) == (0, PROCESS)
    assert found.chosen.largest_heldout_error < 0.02
