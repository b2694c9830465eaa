"""What comes with an answer: the error band, the distance from the range, refusals, the angle law.

Bands and the angle law are recalculated here from their definitions; they agree to rounding (1e-12).
"""

import copy
import itertools
import math
import pickle
import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from refusals import refused
from regression.fits.fits import fit_form
from regression.fits.forms import FittedForm, polynomial_terms
from regression.models.angle import between
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.models.response_query import PIECE, OutsideRangeWarning, compile_equation

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098)}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 3) for ends in BOX.values()))))
HELD = np.array([[0.28, 0.05], [0.31, 0.09]])
MIDDLE = {"web_width": 0.300, "web_thickness": 0.068}


def power(size, exponent):
    return lambda x: size * (x[:, 0] / 0.3) ** -0.5 * (x[:, 1] / 0.068) ** exponent


def response(function, symbol, unit, form="log-quadratic", **changes):
    fit = fit_form(form, tuple(BOX), GRID, function(GRID), HELD, function(HELD))
    made = ResponseModel.from_fit(fit, symbol=symbol, unit=unit)
    return ResponseModel(**(made.model_dump() | changes))


# As models of older releases have them, without the error of designs left out.
ERRORS = {
    "largest_heldout_error": 0.02,
    "largest_fe_error": 0.01,
    "heldout_runs": 10,
    "band_error": None,
    "band_designs": 0,
}
ANGLE = {
    "axial_compliance_in_line": (0.26e-9, "e_0", "m/N"),
    "axial_compliance_opposite": (1.34e-9, "e_180", "m/N"),
    "influence_coefficient_in_line": (0.08e-9, "c_0", "m/N"),
    "influence_coefficient_opposite": (0.6e-9, "c_180", "m/N"),
    "tilt_stiffness_ratio": (2.65, "rho", ""),
}


@pytest.fixture(scope="module")
def model():
    responses = {
        "axial_compliance": response(power(1.3e-9, -1.2), "e_n", "m/N", **ERRORS),
        "influence_coefficient": response(power(0.6e-9, -1.2), "c", "m/N", **ERRORS),
        "mass": response(power(100.0, 0.8), "m", "kg", **ERRORS),
    }
    responses |= {
        name: response(power(size, -0.9), symbol, unit, **ERRORS)
        for name, (size, symbol, unit) in ANGLE.items()
    }
    return ComplianceModel(responses=responses)


# ------------------------------------------------------------------------------------------- bands


def test_the_band_is_that_of_designs_not_seen():
    """40 runs left out in turn and 10 held-out designs, of which 95 % are off by 3 % at most."""
    told = ERRORS | {"band_error": 0.03, "runs": 40}
    del told["band_designs"]
    for number in (50, 18, 10):
        made = response(power(1e-9, -1.0), "e_n", "m/N", **told, band_designs=number)
        model = ComplianceModel(responses={"axial_compliance": made})
        found = model.lookup("axial_compliance", **MIDDLE)
        assert found.lower == close(found.value / 1.03 * 0.99, rel=1e-12)
        assert found.upper == close(found.value / 0.97 * 1.01, rel=1e-12)
        assert found.band.startswith("95 %") == (number == 50)


def test_the_band_holds_every_true_value_it_promises(model):
    """Any fe value that the equation misses by 2 % at most, and any truth up to 1 % from it."""
    found = model.lookup("axial_compliance", **MIDDLE)
    for miss, own in itertools.product((-0.02, -0.01, 0.0, 0.02), (-0.01, 0.0, 0.005, 0.01)):
        truth = found.value / (1.0 + miss) * (1.0 + own)
        assert found.lower * (1.0 - 1e-12) <= truth <= found.upper * (1.0 + 1e-12)


def test_band_of_a_negative_response():
    negative = response(lambda x: -power(1e-9, -1.0)(x), "c", "m/N", "quadratic", **ERRORS)
    model = ComplianceModel(responses={"influence_coefficient": negative})
    found = model.lookup("influence_coefficient", **MIDDLE)
    assert found.lower < found.value < found.upper < 0.0


# ------------------------------------------------------------------------------------------ ranges


def test_outside_the_range_there_is_no_band(model):
    for angle in (None, 120.0):
        found = model.lookup("axial_compliance", gamma_deg=angle, **(MIDDLE | {"web_width": 0.4}))
        assert not found.inside
        assert (found.lower, found.upper) == (None, None)


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_a_dimension_of_another_unit_is_refused(model, factor):
    wrong = factor * MIDDLE["web_thickness"]
    for value in (wrong, np.array([MIDDLE["web_thickness"], wrong])):
        for ask in (model.axial_compliance, partial(model.lookups, "axial_compliance")):
            with refused("web_thickness"):
                ask(**(MIDDLE | {"web_thickness": value}))


def test_models_are_shown_in_a_line(model):
    """Responses by name and factors, and none of the equations' numbers."""
    assert repr(model) == str(model)
    for shown in (model, model.responses["mass"]):
        assert "web_width 270 mm to 330 mm" in repr(shown)
    assert len(repr(model)) < 500
    found = repr(model.lookup("axial_compliance", **MIDDLE))
    assert found.startswith(f"Lookup({model.responses['axial_compliance'].symbol} = 1.")
    assert "\n" not in found


@settings(deadline=None, max_examples=30)
@given(beyond=st.floats(0.001, 2.0), above=st.booleans(), name=st.sampled_from(list(BOX)))
def test_distance_from_the_range(model, beyond, above, name):
    low, high = BOX[name]
    beyond = min(beyond, 0.5 * low / (high - low)) if not above else beyond
    value = high + beyond * (high - low) if above else low - beyond * (high - low)
    found = model.lookup("mass", **(MIDDLE | {name: value}))
    (remark,) = found.remarks
    assert not found.inside
    told = float(re.search(r"; (\S+) % of its width outside", remark)[1])
    assert told == close(100.0 * beyond, rel=6e-3)  # three digits
    for ask in (model.value, model.lookup):
        with refused(name):
            ask("mass", strict=True, **(MIDDLE | {name: value}))


def test_strict_takes_all_that_is_inside(model):
    edge = {name: high for name, (_, high) in BOX.items()}
    assert model.axial_compliance(strict=True, **edge) == model.axial_compliance(**edge)
    assert model.lookup("mass", strict=True, **edge).inside
    with refused("web_width"):
        model.value("mass", strict=True, web_width=[0.3, 0.34, 0.35], web_thickness=0.05)


def test_one_number_beside_a_large_array_is_told_once(model):
    widths = np.linspace(0.28, 0.32, 3 * PIECE)
    with pytest.warns(OutsideRangeWarning, match=r"web_thickness: given 20 mm; the range"):
        model.axial_compliance(web_width=widths, web_thickness=0.020)
    # As many numbers, all alike, are that many.
    thin = np.full(3 * PIECE, 0.020)
    with pytest.warns(OutsideRangeWarning, match=rf"20 mm \(and {3 * PIECE - 1} more\); the range"):
        model.axial_compliance(web_width=widths, web_thickness=thin)


def test_far_outside_there_is_an_error_and_no_infinite_number(model):
    for width in (0.3, [0.3, 0.31]):
        with refused("web_thickness"):
            model.axial_compliance(web_width=width, web_thickness=1e-300)


# --------------------------------------------------------------------------------------- angle law


def law(gamma, in_line, opposite, ratio):
    return in_line + (opposite - in_line) / (1.0 + ratio / math.tan(math.radians(gamma) / 2.0) ** 2)


@pytest.mark.parametrize("kind", ["axial_compliance", "influence_coefficient"])
@pytest.mark.parametrize("gamma", [1.0, 60.0, 90.0, 120.0, 179.0])
def test_angle_law(model, kind, gamma):
    parts = [
        model.value(name, **MIDDLE)
        for name in (f"{kind}_in_line", f"{kind}_opposite", "tilt_stiffness_ratio")
    ]
    value = getattr(model, kind)(gamma_deg=gamma, **MIDDLE)
    assert isinstance(value, float)
    assert value == close(law(gamma, *parts), rel=1e-12)
    for same in (-gamma, 360.0 - gamma, 360.0 + gamma, int(gamma)):
        assert model.value(kind, gamma_deg=same, **MIDDLE) == close(value, rel=1e-12)


@pytest.mark.parametrize("kind", ["axial_compliance", "influence_coefficient"])
def test_limits_of_the_angle_law(model, kind):
    """In line and opposite are met to the last digit, and so are many angles at once."""
    ends = [model.value(f"{kind}_{end}", **MIDDLE) for end in ("in_line", "opposite")]
    assert model.value(kind, gamma_deg=0.0, **MIDDLE) == ends[0]
    assert model.value(kind, gamma_deg=180.0, **MIDDLE) == close(ends[1], rel=1e-15)
    values = model.value(kind, gamma_deg=[0.0, 90.0, 180.0, 270.0], **MIDDLE)
    assert values[0] == ends[0]
    assert values[1] == close(values[3], rel=1e-14)
    assert np.all(np.diff(values[:3]) > 0.0)
    many = model.value(kind, gamma_deg=120.0, web_width=[0.3, 0.31], web_thickness=0.068)
    assert many[0] == close(model.value(kind, gamma_deg=120.0, **MIDDLE), rel=1e-14)


def test_band_between_neighbors_covers_the_bands_of_its_parts(model):
    found = model.lookup("axial_compliance", gamma_deg=120.0, **MIDDLE)
    parts = [
        model.lookup(name, **MIDDLE)
        for name in (
            "axial_compliance_in_line",
            "axial_compliance_opposite",
            "tilt_stiffness_ratio",
        )
    ]
    inner = np.random.default_rng(1).random((200, 3))
    values = [
        law(120.0, *(p.lower + u * (p.upper - p.lower) for p, u in zip(parts, row, strict=True)))
        for row in inner
    ]
    assert found.lower <= min(values) < max(values) <= found.upper
    # A softer throw, or a smaller rho, gives more.
    assert found.upper == close(
        law(120.0, parts[0].upper, parts[1].upper, parts[2].lower), rel=1e-12
    )
    assert found.support == "between neighbors at 120 deg"
    assert found.symbol == "e_n(120 deg)"
    assert found.value == model.axial_compliance(gamma_deg=120.0, **MIDDLE)


@pytest.mark.parametrize(
    ("name", "gamma"),
    [
        ("mass", 90.0),
        *(("axial_compliance", gamma) for gamma in (math.nan, math.inf, "120 deg", [], True)),
    ],
)
def test_unusable_angles(model, name, gamma):
    with refused("gamma_deg"):
        model.value(name, gamma_deg=gamma, **MIDDLE)


def test_angles_of_another_shape_than_the_dimensions(model):
    with refused("gamma_deg"):
        model.axial_compliance(gamma_deg=[0, 1, 2], web_width=[0.3, 0.31], web_thickness=0.068)
    with refused("gamma_deg"):
        model.lookup("axial_compliance", gamma_deg=[0.0, 90.0], **MIDDLE)


def test_an_angle_needs_its_three_numbers(model):
    kept = {"axial_compliance", "axial_compliance_in_line", "mass"}
    less = ComplianceModel(responses={name: model.responses[name] for name in kept})
    with refused("gamma_deg"):
        less.axial_compliance(gamma_deg=120.0, **MIDDLE)


def test_throws_of_several_pins_have_no_angle(model):
    """Also not where a model holds a ratio, as models did of studies of such throws."""
    pins = ComplianceModel(
        responses=model.responses, fixed={**model.fixed, "further_pins.0.angle": 0.5}
    )
    asked = {**MIDDLE, "further_pins.0.angle": 0.5}
    assert pins.axial_compliance(**asked) == model.axial_compliance(**MIDDLE)
    with refused("gamma_deg"):
        pins.axial_compliance(gamma_deg=120.0, **asked)


@pytest.mark.parametrize("ratio", [0.0, -0.5, [2.0, -0.5, 1.0]])
@pytest.mark.parametrize("gamma", [0.0, 90.0])
def test_a_ratio_of_stiffnesses_is_positive(ratio, gamma):
    with refused("tilt_stiffness_ratio"):
        between(gamma, 1.0, 3.0, np.array(ratio) if isinstance(ratio, list) else ratio)


def test_a_fitted_ratio_that_is_not_positive_is_refused(model):
    # rho falls through 0 at h = 73 mm.
    falling = response(lambda x: 0.005 - (x[:, 1] - 0.068), "rho", "", "linear", **ERRORS)
    poor = ComplianceModel(responses={**model.responses, "tilt_stiffness_ratio": falling})
    assert poor.axial_compliance(gamma_deg=120.0, **MIDDLE) > 0.0
    thick = MIDDLE | {"web_thickness": 0.080}
    for call in (poor.axial_compliance, lambda **asked: poor.lookup("axial_compliance", **asked)):
        with refused("tilt_stiffness_ratio"):
            call(gamma_deg=120.0, **thick)


THROW = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "fillet_radius": 0.012,
    **MIDDLE,
}


@pytest.mark.parametrize(
    ("throw", "ranges", "equal"),
    [
        (THROW, {}, True),
        (THROW | {"left_web": {"thickness": 0.068}}, {}, True),
        (THROW | {"left_web": {"thickness": 0.060}}, {}, False),
        (THROW | {"left_web": {"thickness": 0.068}}, {"left_web.thickness": (0.06, 0.07)}, False),
        (None, {}, True),
        (None, {"right_web.width": (0.28, 0.32)}, False),
    ],
)
def test_unequal_webs_make_the_angle_law_an_interpolation(model, throw, ranges, equal):
    own = ComplianceModel(responses=model.responses, throw=throw, ranges=BOX | ranges)
    found = own.lookup("axial_compliance", gamma_deg=120.0, **MIDDLE)
    assert bool(found.remarks) != equal
    assert found.inside
    assert own.lookup("axial_compliance", **MIDDLE).remarks == ()


# --------------------------------------------------------------------------------------- equations


@settings(deadline=None, max_examples=40)
@given(
    columns=st.integers(1, 4),
    degree=st.integers(1, 3),
    logarithmic=st.booleans(),
    seed=st.integers(0, 2**31),
)
def test_compiled_equations_are_the_fitted_ones(columns, degree, logarithmic, seed):
    """Scalars and arrays agree to 1e-14, both with the plain evaluation to its own rounding."""
    rng = np.random.default_rng(seed)
    terms = polynomial_terms(columns, degree)
    kept = tuple(term for term in terms if not term or rng.random() < 0.8)
    logged = tuple(bool(flag) for flag in rng.integers(0, 2, columns))
    coefficients = 0.5 * rng.standard_normal(len(kept))
    coefficients[0] = -20.0 if logarithmic else 5.0
    fitted = FittedForm(
        form="any",
        factors=tuple(f"x{n}" for n in range(columns)),
        logarithmic=logarithmic,
        log_factors=logged,
        center=tuple(np.where(logged, -1.0, 0.3).tolist()),
        half_range=(0.2,) * columns,
        terms=kept,
        coefficients=tuple(coefficients.tolist()),
    )
    compiled = compile_equation(fitted)
    coded = rng.uniform(-1.0, 1.0, (50, columns))
    x = np.where(logged, np.exp(-1.0 + 0.2 * coded), 0.3 + 0.2 * coded)
    arrays = compiled(list(x.T), np)
    scalars = np.array([compiled(row, math) for row in x.tolist()])
    size = np.maximum(np.abs(arrays), 1.0 if not logarithmic else 0.0)
    assert np.max(np.abs(arrays - scalars) / size) <= 1e-14
    # The exponent of the plain evaluation is of the size 20 to 40: 40 * 2^-53 and a few of its sums.
    assert np.max(np.abs(arrays - fitted.predict(x)) / size) <= 1e-13


def test_copies_and_processes_answer_alike(model):
    value = model.axial_compliance(**MIDDLE)
    for other in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
        assert other == model
        assert other.axial_compliance(**MIDDLE) == value
    changed = model.model_copy(
        update={"responses": {"axial_compliance": model.responses["axial_compliance_in_line"]}}
    )
    assert changed.axial_compliance(**MIDDLE) == model.value("axial_compliance_in_line", **MIDDLE)
