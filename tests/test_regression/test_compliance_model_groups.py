"""Models in dimensionless groups, with choices and with relations."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from crankbase.results import plain
from fem.material import STEEL
from geometry.throw import CrankThrow
from refusals import refusals, refused
from regression.fits.fits import fit_form
from regression.fits.forms import (
    GROUPS,
    group_encoding,
    group_named,
    group_names,
    group_values,
    independent_groups,
)
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.models.response_query import OutsideRangeWarning
from regression.plans.factors import Factor
from regression.response_kinds import response_scale
from throws import MEDIUM_SPEED

E, RHO = STEEL.youngs_modulus, STEEL.density
THROW = MEDIUM_SPEED | {"web_width": 0.3}
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.050, 0.090), "pin_length": (0.120, 0.158)}
FIXED = {name: value for name, value in THROW.items() if name not in BOX} | {
    "main_journal_bore": 0.0,
    "pin_bore": 0.0,
}
COLUMNS = ("R/h", "B/D_shm", "L_shm/D_shm")
WEIGHT = {"outer_radius": 0.3, "angle": 2.0}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 4) for ends in BOX.values()))))


def frame(d):
    """Compliance of the pin and two webs as a plane frame."""
    pin = np.pi * d["pin_diameter"] ** 4 / 64.0
    web = d["web_width"] * d["web_thickness"] ** 3 / 12.0
    bending = d["pin_length"] / pin + 2.0 * d["crank_radius"] / (3.0 * web)
    return d["crank_radius"] ** 2 * bending / E


def weight(d):
    return RHO * 2.0 * d["web_width"] * d["web_thickness"] * (d["crank_radius"] + d["pin_diameter"])


def at_grid(function):
    designs = FIXED | dict(zip(BOX, GRID.T, strict=True))
    return designs, function(designs)


def group_response(function, scale, symbol, unit, **others):
    designs, values = at_grid(function)
    x = np.stack([group_named(name).value(designs) for name in COLUMNS], axis=-1)
    fit = fit_form("log-quadratic", COLUMNS, x, values / scale)
    return ResponseModel.from_fit(fit, symbol=symbol, unit=unit, basis="groups", **others)


@pytest.fixture(scope="module")
def model():
    pin = THROW["pin_diameter"]
    return ComplianceModel(
        responses={
            "axial_compliance": group_response(frame, 1.0 / (E * pin), "e_n", "m/N"),
            "torsional_compliance": group_response(
                lambda d: frame(d) / d["crank_radius"] ** 2, 1.0 / (E * pin**3), "e_t", "rad/(N m)"
            ),
            "mass": group_response(weight, RHO * pin**3, "m", "kg", support=""),
        },
        fixed=FIXED,
        ranges=BOX,
        labels={"web_outline": "obround"},
        throw=THROW,
        material=STEEL.model_dump(),
    )


def scaled(values, size):
    return {name: size * value for name, value in values.items()}


MIDDLE = {name: THROW[name] for name in BOX}
POWERS = {"axial_compliance": -1, "torsional_compliance": -3, "mass": 3}


@settings(deadline=None, max_examples=40)
@given(
    size=st.floats(0.05, 20.0),
    B=st.floats(0.272, 0.328),
    h=st.floats(0.051, 0.089),
    L=st.floats(0.121, 0.157),
)
def test_scaled_throws_have_scaled_responses(model, size, B, h, L):
    throw = THROW | {"web_width": B, "web_thickness": h, "pin_length": L}
    own = {name: throw[name] for name in BOX}
    for name, power in POWERS.items():
        plain = model.value(name, **own)
        assert model.value(name, **throw) == close(plain, rel=1e-13)
        large = model.value(name, strict=True, **scaled(throw, size))
        assert large == close(size**power * plain, rel=1e-12)


def test_the_frame_itself_is_met(model):
    # The quadratic in logarithms misses the frame by 2e-5 inside this box.
    assert model.axial_compliance(**MIDDLE) == close(frame(THROW), rel=1e-4)
    assert model.value("mass", **MIDDLE) == close(weight(THROW), rel=1e-9)


@pytest.mark.parametrize(
    ("change", "ratio"),
    [
        ({"crank_radius": 0.187}, "s/R"),
        ({"main_journal_length": 0.24}, "L_km/D_shm"),
        ({"fillet_radius": 0.0}, "r/D_shm"),
        ({"pin_bore": 0.09}, "d_shm/D_shm"),
    ],
)
def test_a_ratio_that_did_not_vary_must_agree(model, change, ratio):
    for asked in (MIDDLE | change, *(scaled(THROW | change, size) for size in (1.0, 0.7))):
        with refused(ratio):
            model.axial_compliance(**asked)


def test_rounded_dimensions_of_a_scaled_throw_agree(model):
    small = {name: round(value * 0.5303, 6) for name, value in THROW.items()}
    exact = model.axial_compliance(**THROW) / 0.5303
    # Rounding to 1 um changes the web's cube by 3 / 36000 at most.
    assert model.axial_compliance(**small) == close(exact, rel=1e-4)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"web_outline": "rectangle"}, "web_outline"),
        ({"pin_bore": 0.06}, "d_shm/D_shm"),
        ({"web_tip_thickness": 0.05}, "throw.web_tip_thickness"),
        ({"counterweight": WEIGHT}, "throw.counterweight.outer_radius"),
        ({"left_web": {"thickness": 0.07}}, "throw.left_web.thickness"),
    ],
)
def test_of_throw_refuses_what_the_models_throws_did_not_have(model, change, field):
    with refused(field):
        model.of_throw(CrankThrow(**(THROW | change)))


def test_what_the_models_throws_had_must_be_there():
    model = ComplianceModel(
        responses={"axial_compliance": group_response(frame, 1.0 / (E * 0.18), "e_n", "m/N")},
        fixed=FIXED,
        ranges=BOX,
        throw=THROW | {"counterweight": WEIGHT},
        material=STEEL.model_dump(),
    )
    large = THROW | {"counterweight": WEIGHT}
    double = scaled(THROW, 2.0) | {"counterweight": WEIGHT | {"outer_radius": 0.6}}
    for throw in (large, double):
        assert model.of_throw(CrankThrow(**throw))["axial_compliance"].inside
    for throw in (double | {"counterweight": WEIGHT | {"outer_radius": 0.59}}, THROW):
        with refused("throw.counterweight.outer_radius"):
            model.of_throw(CrankThrow(**throw))


def test_spelled_out_defaults_are_no_features(model):
    spelled = THROW | {"pin_fillet_radius": 0.012, "web_pin_end": 0.150, "web_tip_thickness": 0.068}
    expected = plain(model.of_throw(CrankThrow(**THROW)))
    assert plain(model.of_throw(CrankThrow(**spelled))) == expected


def test_some_responses_at_another_size_are_left_out_with_a_warning(model):
    fit = fit_form("linear", tuple(BOX), GRID, at_grid(weight)[1])
    responses = {
        "axial_compliance": model.responses["axial_compliance"],
        "mass": ResponseModel.from_fit(fit, symbol="m", unit="kg"),
    }
    mixed = ComplianceModel(**(model.model_dump() | {"responses": responses}))
    assert set(mixed.of_throw(CrankThrow(**THROW))) == {"axial_compliance", "mass"}
    with pytest.warns(UserWarning, match="mass is left out: .*fixed in this model"):
        found = mixed.of_throw(CrankThrow(**scaled(THROW, 2.0)))
    assert set(found) == {"axial_compliance"}


def test_groups_follow_another_material(model):
    iron = STEEL.changed(youngs_modulus=1.65e11, density=7200.0)
    found = model.of_throw(CrankThrow(**THROW)), model.of_throw(CrankThrow(**THROW), material=iron)
    shares = {name: answer.value / found[0][name].value for name, answer in found[1].items()}
    factor = 210.0 / 165.0
    known = {"axial_compliance": factor, "torsional_compliance": factor, "mass": 7200.0 / 7850.0}
    assert shares == close(known, rel=1e-12)


def test_a_dimensionless_equation_needs_the_material(model):
    with pytest.raises(InputError, match=r"^model\.material: given"):
        ComplianceModel(**(model.model_dump() | {"material": {}}))


def test_groups_that_stayed_the_same_although_their_dimensions_varied(model):
    content = model.model_dump()
    fixed = {n: v for n, v in FIXED.items() if n not in ("pin_diameter", "crank_radius")}
    ranges = BOX | {"pin_diameter": (0.16, 0.2), "crank_radius": (0.15, 0.19)}
    content |= {"fixed": fixed, "ranges": ranges, "throw": None}
    free = ComplianceModel(**content)
    bound = ComplianceModel(**(content | {"constant_groups": {"s/R": 0.2 / 0.17 - 1.0}}))
    asked = MIDDLE | {"pin_diameter": 0.18, "crank_radius": 0.18}
    assert free.axial_compliance(**asked) > 0.0
    with refused("s/R"):
        bound.axial_compliance(**asked)
    assert bound.axial_compliance(**(asked | {"crank_radius": 0.17})) == close(
        model.axial_compliance(**MIDDLE), rel=1e-13
    )


# ---------------------------------------------------------------------------- choices and relations


@pytest.fixture(scope="module")
def choices():
    """e = (1 + 0.2 rectangle + 0.3 chamfered) / h."""
    columns = ("web_thickness", "web_outline=rectangle", "web_outline=chamfered")
    rows = [(0, 0), (1, 0), (0, 1)]
    x = np.array([[h, *row] for h in (0.05, 0.06, 0.07) for row in rows])
    y = 1e-9 * (1.0 + x[:, 1] * 0.2 + x[:, 2] * 0.3) * 0.06 / x[:, 0]
    fit = fit_form("power law", columns, x, y)
    return ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"web_thickness": (0.05, 0.07)},
        categories={"web_outline": ("obround", "rectangle", "chamfered")},
        labels={"steel": "cast"},
    )


def test_choices_in_an_array(choices):
    labels = ["rectangle", "obround", "chamfered"]
    values = choices.axial_compliance(web_thickness=0.06, web_outline=labels)
    assert values == close([1.2e-9, 1.0e-9, 1.3e-9], rel=1e-12)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"web_outline": "round"}, "web_outline"),
        ({"web_outline": 1.0}, "web_outline"),
        ({"web_outline": ["obround", "round"]}, "web_outline"),
        ({}, "web_outline"),
        ({"web_outline": "obround", "steel": "forged"}, "steel"),
    ],
)
def test_unusable_labels(choices, given, field):
    with refused(field):
        choices.axial_compliance(web_thickness=0.06, **given)


def test_a_label_that_did_not_vary_may_be_given(choices):
    plain = choices.axial_compliance(web_thickness=0.06, web_outline="obround")
    assert plain == choices.axial_compliance(
        web_thickness=0.06, web_outline="obround", steel="cast"
    )


@pytest.fixture(scope="module")
def ratio_model():
    x = np.array(list(itertools.product(np.linspace(1.4, 1.8, 3), np.linspace(0.05, 0.09, 3))))
    y = 1e-9 / (x[:, 0] / 1.6) / (x[:, 1] / 0.07)
    fit = fit_form("power law", ("width_ratio", "web_thickness"), x, y)
    names = ("crank_radius", "pin_diameter", "main_journal_diameter", "fillet_radius")
    return ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"width_ratio": (1.4, 1.8), "web_thickness": (0.05, 0.09)},
        fixed={name: THROW[name] for name in names} | {"pin_length": 0.139},
        units={"width_ratio": ""},
        relations={
            "web_width": "width_ratio * pin_diameter",
            "main_journal_length": "395 mm - pin_length - 2 * web_thickness",
        },
        throw=THROW,
    )


def test_a_free_factor_and_what_follows_from_it(ratio_model):
    value = ratio_model.axial_compliance(width_ratio=1.6, web_thickness=0.07)
    assert value == close(1e-9, rel=1e-12)
    again = ratio_model.axial_compliance(width_ratio=1.6, web_thickness=0.07, web_width=0.288)
    assert again == value
    with refused("web_width"):
        ratio_model.axial_compliance(width_ratio=1.6, web_thickness=0.07, web_width=0.3)
    with pytest.raises(InputError, match="width_ratio: missing"):
        ratio_model.axial_compliance(web_width=0.3, web_thickness=0.07)
    with pytest.warns(OutsideRangeWarning, match=r"width_ratio: given 1\.9; .* 1\.4 to 1\.8"):
        ratio_model.axial_compliance(width_ratio=1.9, web_thickness=0.07)
    with refused("width_ratio"):
        ratio_model.axial_compliance(width_ratio="wide", web_thickness=0.07)


def test_a_free_factor_is_found_from_the_throw(ratio_model):
    throw = CrankThrow(
        **(THROW | {"web_width": 0.27, "web_thickness": 0.068, "main_journal_length": 0.120})
    )
    assert ratio_model.dimensions_of(throw)["width_ratio"] == close(1.5, rel=1e-12)
    found = ratio_model.of_throw(throw)["axial_compliance"]
    assert found.value == close(1e-9 * (1.6 / 1.5) * (0.07 / 0.068), rel=1e-12)
    other = CrankThrow(**(THROW | {"web_width": 0.27, "main_journal_length": 0.130}))
    with refused("main_journal_length"):
        ratio_model.of_throw(other)


def slenderness_model(relation, ends):
    """A model of one factor that is no dimension, and of which the web's width follows."""
    x = np.array(list(itertools.product(np.linspace(*ends, 3), np.linspace(0.05, 0.09, 3))))
    y = 1e-9 * (1.0 + x[:, 0]) * 0.07 / x[:, 1]
    fit = fit_form("quadratic", ("slenderness", "web_thickness"), x, y)
    return ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"slenderness": ends, "web_thickness": (0.05, 0.09)},
        fixed={n: v for n, v in THROW.items() if n not in ("web_width", "web_thickness")},
        units={"slenderness": ""},
        relations={"web_width": relation},
        throw=THROW,
    )


@pytest.mark.parametrize(
    ("relation", "ends", "width"),
    [
        ("pin_diameter / slenderness", (0.55, 0.67), lambda x: 0.18 / x),
        ("pin_diameter * slenderness ** 2", (1.2, 1.4), lambda x: 0.18 * x**2),
        ("250 mm + 1 m * slenderness ** 3", (0.2, 0.4), lambda x: 0.25 + x**3),
    ],
)
# Inside, at both ends, and a little outside, as far as a relation of first degree would go.
@pytest.mark.parametrize("place", [0.0, 0.13, 0.5, 0.97, 1.0, 1.1, -0.1])
def test_a_factor_of_a_relation_of_another_degree_is_found(relation, ends, width, place):
    """The relation is met within 1e-9, and its slope is such that the factor is so within 1e-8."""
    model = slenderness_model(relation, ends)
    factor = ends[0] + place * (ends[1] - ends[0])
    throw = CrankThrow(**(THROW | {"web_width": width(factor)}))
    assert model.dimensions_of(throw)["slenderness"] == close(factor, rel=1e-8)
    assert model.of_throw(throw)["axial_compliance"].inside == (0.0 <= place <= 1.0)


def test_a_factor_that_a_relation_does_not_tell_is_left_out():
    # Both -0.1 and 0.1 give the width, and none gives a narrower one than 270 mm.
    model = slenderness_model("pin_diameter * (1.5 + slenderness ** 2)", (-0.3, 0.4))
    for square in (0.01, -0.1):
        throw = CrankThrow(**(THROW | {"web_width": 0.18 * (1.5 + square)}))
        with pytest.raises(InputError, match="slenderness: missing; the model needs"):
            model.of_throw(throw)


def test_unequal_shapes_are_refused_before_anything_is_compared(ratio_model):
    asked = {"width_ratio": [1.5, 1.6], "web_thickness": 0.07}
    for other in ({"web_width": [0.27, 0.288, 0.3]}, {"web_thickness": [0.05, 0.06, 0.07]}):
        with refused("dimensions"):
            ratio_model.axial_compliance(**(asked | other))


@pytest.mark.parametrize(
    ("response", "size"), [("torsional_compliance", 1e-120), ("mass", 1e120), ("mass", 1e-120)]
)
def test_a_throw_of_no_size_that_numbers_have_is_refused(model, response, size):
    for asked in (scaled(THROW, size), scaled({n: np.array([v]) for n, v in THROW.items()}, size)):
        with refused("dimensions"):
            model.value(response, **asked)


MAIN = MEDIUM_SPEED | {
    "main_journal_length": 0.135,
    "web_width": 0.3,
    "main_journal_bore": 0.0,
    "pin_bore": 0.06,
}


def columns(count=20, seed=1, **ranges):
    """Arrays of all main dimensions, some of them varied over ranges."""
    rng = np.random.default_rng(seed)
    found = {name: np.full(count, value) for name, value in MAIN.items()}
    return found | {name: rng.uniform(*ends, count) for name, ends in ranges.items()}


def test_groups_of_plain_numbers_are_plain_numbers():
    for name in GROUPS:
        assert type(group_named(name).value(MAIN)) is float


def test_other_lengths_are_divided_by_the_pin():
    names = group_names([*MAIN, "web_journal_end"])
    assert names[-1] == "web_journal_end/D_shm"
    assert group_named(names[-1]).value(MAIN | {"web_journal_end": 0.09}) == close(0.5)


def test_scales_make_responses_dimensionless():
    """Lengths times 2: compliances by 2, by 8; mass times 8 (dimensional analysis)."""
    one, two = {"pin_diameter": 0.1}, {"pin_diameter": 0.2}
    for unit, ratio in (("m/N", 1 / 2), ("rad/(N m)", 1 / 8), ("kg", 8.0), ("", 1.0)):
        scale = response_scale(unit, one, STEEL)
        assert response_scale(unit, two, STEEL) / scale == close(ratio)
    assert response_scale("m/N", one, STEEL) == close(1 / (2.1e11 * 0.1))
    with refused("unit"):
        response_scale("Pa", one, STEEL)


def test_groups_that_vary_are_chosen():
    found = group_values(columns(web_width=(0.27, 0.33), web_thickness=(0.04, 0.09)))
    assert independent_groups(found, 2) == ("R/h", "B/D_shm")
    assert independent_groups(found, 1) == ("R/h",)
    # The radius moves two groups; one number cannot make them independent.
    found = group_values(columns(crank_radius=(0.165, 0.175)))
    assert independent_groups(found, 1) == ("s/R",)


@pytest.mark.parametrize(("share", "chosen"), [(2e-3, ("a", "b")), (5e-4, ("a",))])
def test_a_group_is_chosen_for_its_own_share(share, chosen):
    """A thousandth of a group's variation that others do not explain makes it one of its own."""
    first, second = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, 1.0, -1.0, -1.0])
    values = {"a": 5.0 + first, "b": 5.0 + np.sqrt(1.0 - share**2) * first + share * second}
    assert independent_groups(values, 2) == chosen


def test_more_groups_than_factors_are_refused():
    dimensions = columns(pin_diameter=(0.17, 0.19))
    values = dimensions["pin_diameter"][:, None]
    with refused("groups"):
        group_encoding((Factor("pin_diameter", "m", 0.17, 0.19),), values, dimensions)


def test_factors_that_are_no_lengths_of_the_throw_are_refused():
    factor = Factor("counterweight.angle", "rad", 0.5, 1.5)
    with refused("groups"):
        group_encoding((factor,), np.linspace(0.5, 1.5, 20)[:, None], columns())


test_refused_calls = refusals(
    ("group", lambda: group_named("web_width")),
)
