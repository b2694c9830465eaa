"""Slopes of compliance models against differences of their values."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from fem.material import STEEL
from refusals import refused
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS, group_named
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.models.response_query import OutsideRangeWarning
from throws import MEDIUM_SPEED

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.050, 0.090), "pin_length": (0.120, 0.158)}
THROW = MEDIUM_SPEED | {"web_width": 0.3}
FIXED = {name: value for name, value in THROW.items() if name not in BOX}
GROUPS = ("R/h", "B/D_shm", "L_shm/D_shm")
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 4) for ends in BOX.values()))))
# Weights of the central difference of eighth order, at 1 to 4 steps.
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def compliance(x, size=1.4e-9):
    B, h, L = x.T
    return size * (B / 0.3) ** -0.8 * (h / 0.07) ** -1.2 * (1.0 + 3.0 * (L - 0.14))


def response(form, size, unit="m/N"):
    values = compliance(GRID, size)
    if FORMS[form].basis == "factors":
        return ResponseModel.from_fit(
            fit_form(form, tuple(BOX), GRID, values), symbol="e", unit=unit
        )
    dimensions = FIXED | dict(zip(BOX, GRID.T, strict=True))
    columns = np.stack([group_named(name).value(dimensions) for name in GROUPS], axis=-1)
    scale = 1.0 / (STEEL.youngs_modulus * THROW["pin_diameter"]) if unit else 1.0
    fit = fit_form(form, GROUPS, columns, values / scale)
    return ResponseModel.from_fit(fit, symbol="e", unit=unit)


def make_model(form):
    responses = {
        "axial_compliance": (1.4e-9, "m/N"),
        "axial_compliance_in_line": (0.3e-9, "m/N"),
        "axial_compliance_opposite": (1.3e-9, "m/N"),
        "tilt_stiffness_ratio": (2.6, ""),
    }
    return ComplianceModel(
        responses={name: response(form, *of) for name, of in responses.items()},
        fixed=FIXED,
        ranges=BOX,
        throw=THROW,
        material=STEEL.model_dump(),
    )


MODELS = {form: make_model(form) for form in FORMS}


def difference(value, dimensions, name):
    """Central difference of a value by one dimension, with a relative step of 0.2 %."""
    step = 2e-3 * dimensions[name]
    return (
        sum(
            weight
            * (
                value(**dimensions | {name: dimensions[name] + place * step})
                - value(**dimensions | {name: dimensions[name] - place * step})
            )
            for place, weight in enumerate(WEIGHTS, start=1)
        )
        / step
    )


@pytest.mark.parametrize("form", FORMS)
@settings(deadline=None, max_examples=15)
@given(
    B=st.floats(0.275, 0.325),
    h=st.floats(0.052, 0.088),
    L=st.floats(0.122, 0.156),
    gamma=st.one_of(st.none(), st.floats(0.0, 360.0)),
)
def test_slopes_are_the_derivatives_of_values(form, B, h, L, gamma):
    model, at = MODELS[form], {"web_width": B, "web_thickness": h, "pin_length": L}
    slopes = model.slopes("axial_compliance", gamma_deg=gamma, **at)
    assert list(slopes) == list(BOX)
    value = model.axial_compliance(gamma_deg=gamma, **at)

    def values(**dimensions):
        return model.axial_compliance(gamma_deg=gamma, **dimensions)

    for name, slope in slopes.items():
        assert slope.unit == "m/N per m"
        # A slope may vanish; it is then small beside value over dimension.
        expected = difference(values, at, name)
        assert slope.value == close(expected, rel=1e-8, abs=1e-9 * value / at[name])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("gamma", [None, 100.0])
def test_arrays_have_the_slopes_of_their_throws(form, gamma):
    model = MODELS[form]
    h, L = np.linspace(0.055, 0.085, 4)[:, None], np.array([0.125, 0.150])
    slopes = model.slopes(
        "axial_compliance", gamma_deg=gamma, web_width=0.3, web_thickness=h, pin_length=L
    )
    corner = {"web_width": 0.3, "web_thickness": 0.085, "pin_length": 0.125}
    single = model.slopes("axial_compliance", gamma_deg=gamma, **corner)
    for name, slope in slopes.items():
        assert slope.value.shape == (4, 2)
        assert slope.value[3, 0] == close(single[name].value, rel=1e-12)


@settings(deadline=None, max_examples=10)
@given(size=st.floats(0.1, 10.0))
def test_slopes_of_a_throw_of_another_size_are_scaled(size):
    model = MODELS["group quadratic"]
    plain = model.slopes("axial_compliance", **THROW)
    large = model.slopes("axial_compliance", **{name: size * of for name, of in THROW.items()})
    assert list(large) == list(BOX)
    for name, slope in large.items():
        assert slope.value == close(plain[name].value / size**2, rel=1e-10)


def test_outside_the_range_slopes_warn_or_are_refused_as_values():
    model = MODELS["log-quadratic"]
    outside = {"web_width": 0.3, "web_thickness": 0.02, "pin_length": 0.139}
    with pytest.warns(OutsideRangeWarning, match="web_thickness: given 20 mm") as caught:
        model.slopes("axial_compliance", **outside)
    assert caught[0].filename == __file__
    for ask in (model.axial_compliance, lambda **of: model.slopes("axial_compliance", **of)):
        with refused("web_thickness"):
            ask(strict=True, **outside)
        with refused("web_thickness"):
            ask(**outside | {"web_thickness": 70.0})
    with refused("response"):
        model.slopes("mass", **outside)


@pytest.fixture(scope="module")
def related():
    """A model of a width that follows from a ratio, and a length that follows from two dimensions."""
    ranges = {"width_ratio": (1.4, 1.8), "web_thickness": (0.05, 0.09)}
    x = np.array(list(itertools.product(*(np.linspace(*ends, 4) for ends in ranges.values()))))
    columns = np.stack([x[:, 0] * 0.18, x[:, 1], 0.395 - 2.0 * x[:, 1] ** 1.5], axis=-1)
    fit = fit_form(
        "power law",
        ("web_width", "web_thickness", "main_journal_length"),
        columns,
        columns[:, 0] ** -0.7 * columns[:, 1] ** -1.1 * columns[:, 2] ** 0.5 * 1e-9,
    )
    return ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges=ranges,
        fixed={"pin_diameter": 0.18},
        units={"width_ratio": ""},
        relations={
            "web_width": "width_ratio * pin_diameter",
            "main_journal_length": "395 mm - 2 * web_thickness ^ 1.5 / (1 m) ^ 0.5",
        },
    )


@settings(deadline=None, max_examples=20)
@given(ratio=st.floats(1.42, 1.78), h=st.floats(0.052, 0.088))
def test_what_follows_from_a_factor_moves_with_it(related, ratio, h):
    at = {"width_ratio": ratio, "web_thickness": h}
    slopes = related.slopes("axial_compliance", **at)
    assert [slope.unit for slope in slopes.values()] == ["m/N per 1", "m/N per m"]
    for name, slope in slopes.items():
        expected = difference(related.axial_compliance, at, name)
        assert slope.value == close(expected, rel=1e-8)
    # A dimension that is told besides its factor changes nothing.
    again = related.slopes("axial_compliance", web_width=0.18 * ratio, **at)
    assert [slope.value for slope in again.values()] == [slope.value for slope in slopes.values()]


def test_slopes_need_the_factors(related):
    columns = {
        "web_width": 0.288,
        "web_thickness": 0.07,
        "main_journal_length": 0.395 - 2.0 * 0.07**1.5,
    }
    with refused("web_width"):
        related.slopes("axial_compliance", **columns)


@pytest.mark.parametrize("power", ["0.5", "0.99"])
def test_a_root_of_zero_has_no_slope(power):
    """L = 125 mm + 0.3 x^p of an optional fillet x: its slope 0.3 p x^(p - 1) has no bound at zero."""
    made = MODELS["group quadratic"].model_dump()
    made["fixed"] = {n: v for n, v in made["fixed"].items() if n != "fillet_radius"}
    made["ranges"] = {n: of for n, of in BOX.items() if n != "pin_length"} | {
        "fillet_radius": (0.0, 0.02)
    }
    made["relations"] = {"pin_length": f"125 mm + 300 mm * (fillet_radius / (1 m)) ^ {power}"}
    model = ComplianceModel(**made | {"throw": None})
    at = {"web_width": 0.3, "web_thickness": 0.07}
    length = 0.125 + 0.3 * 0.01 ** float(power)
    direct = MODELS["group quadratic"].slopes("axial_compliance", pin_length=length, **at)
    chained = 0.3 * direct["pin_length"].value * float(power) * 0.01 ** (float(power) - 1.0)
    slopes = model.slopes("axial_compliance", fillet_radius=0.01, **at)
    assert slopes["fillet_radius"].value == close(chained, rel=1e-12)
    with refused("fillet_radius"):
        model.slopes("axial_compliance", fillet_radius=[0.0, 0.01], **at)
