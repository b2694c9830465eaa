"""Compliance models, and lookups of arrays."""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.material import STEEL, Material
from geometry.throw import CrankThrow
from refusals import refusals, refusals_of, refused
from regression.fits.fits import fit_form
from regression.models.compliance_model import (
    FILE_FORMAT,
    FORMAT_VERSION,
    ComplianceModel,
    checksum,
)
from regression.models.response_model import ResponseModel
from regression.models.response_query import OutsideRangeWarning

ROOT = Path(__file__).resolve().parents[2]
FACTORS = ("web_width", "web_thickness", "pin_length")
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}
RUNS = np.array(list(itertools.product(*(np.linspace(*box, 3) for box in BOX.values()))))
HELDOUT = np.array(
    [
        [low + u * (high - low) for u, (low, high) in zip(row, BOX.values(), strict=True)]
        for row in np.random.default_rng(5).random((10, 3))
    ]
)
MIDDLE = {"web_width": 0.300, "web_thickness": 0.068, "pin_length": 0.139}
FIXED = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "fillet_radius": 0.0,
}


def axial(x):
    return 1.4e-9 * (x[:, 0] / 0.3) ** -0.8 * (x[:, 1] / 0.07) ** -1.2 * (x[:, 2] / 0.14) ** 0.4


def torsional(x):
    return 4e-8 * (1 + 2 * (x[:, 2] - 0.14)) * (x[:, 0] / 0.3) ** -0.2 * (x[:, 1] / 0.07) ** -0.1


def response(form, function, symbol, unit):
    fit = fit_form(form, FACTORS, RUNS, function(RUNS), HELDOUT, function(HELDOUT))
    return ResponseModel.from_fit(fit, symbol=symbol, unit=unit)


def make_model(axial_form="log-quadratic"):
    return ComplianceModel(
        responses={
            "axial_compliance": response(axial_form, axial, "e_n", "m/N"),
            "torsional_compliance": response("quadratic", torsional, "e_t", "rad/(N m)"),
        },
        fixed=FIXED,
        material={"youngs_modulus": 2.1e11, "poisson_ratio": 0.3},
        provenance={"study": "abc123", "crankfem": "0.1.0", "date": "2025-01-31", "designs": 27},
    )


MODEL = make_model()


def test_saving_replaces_in_one_step(tmp_path):
    path = tmp_path / "model.json"
    make_model("linear").save(path)
    MODEL.save(str(path))
    assert ComplianceModel.load(str(path)) == MODEL


def test_outside_the_range_warns_and_never_clips():
    with pytest.warns(OutsideRangeWarning, match="web_thickness: given 20 mm; .* 38 mm to 98 mm"):
        value = MODEL.axial_compliance(**(MIDDLE | {"web_thickness": 0.020}))
    assert value == close(1.4e-9 * (20 / 70) ** -1.2 * (139 / 140) ** 0.4, rel=1e-6)
    with pytest.warns(OutsideRangeWarning) as caught:
        MODEL.axial_compliance(
            web_width=[0.25, 0.30, 0.34, 0.35], web_thickness=0.068, pin_length=0.139
        )
    assert len(caught) == 1
    # The farthest of the three; 20 mm below or 20 mm above the range are equally far.
    assert "mm (and 2 more); the range" in str(caught[0].message)
    assert caught[0].filename == __file__


def test_fixed_dimension_may_be_repeated_but_not_changed():
    plain = MODEL.axial_compliance(**MIDDLE)
    assert MODEL.axial_compliance(**MIDDLE, crank_radius=0.17, fillet_radius=0) == plain


test_unusable_dimensions = refusals_of(
    lambda dimensions: MODEL.axial_compliance(**dimensions),
    ({"web_width": 0.3, "web_thickness": 0.068}, "pin_length"),
    (MIDDLE | {"bore": 0.1}, "bore"),
    (MIDDLE | {"web_thicknes": 0.1}, "web_thicknes"),
    (MIDDLE | {"web_width": 0.0}, "web_width"),
    (MIDDLE | {"web_width": [0.3, float("inf")]}, "web_width"),
    (MIDDLE | {"web_width": "300 mm"}, "web_width"),
    (MIDDLE | {"web_width": []}, "web_width"),
    (MIDDLE | {"web_width": [0.3, 0.31], "pin_length": [0.13, 0.14, 0.15]}, "dimensions"),
)


def test_lookup_takes_single_numbers_of_known_responses():
    with refused("web_width"):
        MODEL.lookup("axial_compliance", **(MIDDLE | {"web_width": [0.3, 0.31]}))


def test_missing_response():
    alone = ComplianceModel(responses={"axial_compliance": MODEL.responses["axial_compliance"]})
    with refused("response"):
        alone.torsional_compliance(**MIDDLE)


def test_a_factor_may_start_at_zero():
    x = np.array([[r, h] for r in (0.0, 0.006, 0.012) for h in (0.05, 0.07, 0.09)])
    fit = fit_form("quadratic", ("fillet_radius", "web_thickness"), x, 1e-9 - 1e-8 * x[:, 0])
    model = ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")}
    )
    assert model.axial_compliance(fillet_radius=0.0, web_thickness=0.07) == close(1e-9)
    with refused("fillet_radius"):
        model.axial_compliance(fillet_radius=-0.001, web_thickness=0.07)


def damaged(text, kind):
    record = json.loads(text)
    match kind:
        case "cut":
            return text[: len(text) // 2]
        case "number changed":
            return text.replace('"crank_radius": 0.17', '"crank_radius": 0.18')
        case "other kind":
            return json.dumps({"mesh": []})
        case "list":
            return "[1, 2]"
        case "empty":
            return ""
        case "newer":
            return json.dumps(record | {"version": 5})
        case "long number":
            return text.replace('"version": 4', f'"version": {"9" * 5000}')
        case "no responses":
            del record["responses"]
            return json.dumps(record)
    raise AssertionError(kind)


DAMAGES = {
    "cut": "complete",
    "number changed": "checksum",
    "other kind": "another kind",
    "list": "another kind",
    "empty": "complete",
    "newer": "version 5",
    "long number": "digits",
    "no responses": "checksum",
}


@pytest.mark.parametrize("kind", DAMAGES)
def test_wrong_or_damaged_files(tmp_path, kind):
    path = tmp_path / "model.json"
    MODEL.save(path)
    path.write_text(damaged(path.read_text(), kind))
    with pytest.raises(InputError, match=DAMAGES[kind]) as caught:
        ComplianceModel.load(path)
    assert str(path) in caught.value.sentences[0]


def test_unreadable_files(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        ComplianceModel.load(tmp_path / "absent.json")
    binary = tmp_path / "binary.json"
    binary.write_bytes(b"\x80\xfe\x00\x80")
    with pytest.raises(InputError, match="cannot be read as text"):
        ComplianceModel.load(binary)
    with pytest.raises(InputError, match="given a folder; allowed is a file to write, because"):
        MODEL.save(tmp_path)


def test_contradictory_content_is_refused():
    good = MODEL.responses["axial_compliance"].model_dump()
    for change, field in (
        ({"coefficients": (1.0, 2.0)}, "coefficients"),
        ({"lowest": (0.27,)}, "lowest"),
        ({"factors": (good["factors"][0],) * 3}, "factors"),
        ({"lowest": (0.27, 0.2, 0.12)}, "lowest, highest"),
        ({"half_range": (0.0, 1.0, 1.0)}, "half_range"),
        ({"terms": ((3,), *good["terms"][1:])}, "terms"),
        ({"basis": "cubes"}, "basis"),
        ({"color": "red"}, "color"),
        ({"r_squared": float("nan")}, "r_squared"),
    ):
        with refused(f"response.{field}"):
            ResponseModel(**(good | change))
    with refused("model.fixed"):
        ComplianceModel(responses=MODEL.responses, fixed={"web_width": 0.3})


def changed_file(path, model, change):
    """Write a model whose numbers were changed by somebody who also mended the checksum."""
    content = model.model_dump(mode="json")
    change(content)
    record = {"format": FILE_FORMAT, "version": FORMAT_VERSION, "checksum": checksum(content)}
    path.write_text(json.dumps(record | content))
    return path


def of_axial(field, value, place=None):
    def change(content):
        response = content["responses"]["axial_compliance"]
        if place is None:
            response[field] = value
        else:
            response[field][place] = value

    return change


LINEAR = make_model("linear")
# No model that was fitted has such numbers, though each of them is finite.
IMPOSSIBLE = {
    "half range no number can be divided by": (MODEL, of_axial("half_range", 1e-320, 0)),
    "half range far too small": (MODEL, of_axial("half_range", 1e-6, 0)),
    "half range far too large": (MODEL, of_axial("half_range", 1e300, 0)),
    "center elsewhere": (MODEL, of_axial("center", 1e300, 0)),
    "logarithm of a negative number": (MODEL, of_axial("lowest", -0.27, 0)),
    "exponential overflows": (MODEL, of_axial("coefficients", 1000.0, 0)),
    "exponential vanishes": (MODEL, of_axial("coefficients", -1000.0, 0)),
    "response of no size": (MODEL, of_axial("coefficients", 400.0, 0)),
    "term of more factors than any": (MODEL, of_axial("terms", [0] * 100_000, 1)),
    "coefficient overflows": (MODEL, of_axial("coefficients", 1e308, 1)),
    "sum overflows": (LINEAR, of_axial("coefficients", [1e308] * 4)),
    "below zero everywhere": (LINEAR, of_axial("coefficients", -1e-7, 0)),
    "fixed length below zero": (MODEL, lambda c: c["fixed"].update(crank_radius=-0.17)),
    "no runs": (MODEL, of_axial("runs", 0)),
    "negative number of designs": (MODEL, of_axial("heldout_runs", -1)),
    "r_squared": (MODEL, of_axial("r_squared", 1.5)),
    "q_squared": (MODEL, of_axial("q_squared", 1.5)),
    **{
        name: (MODEL, of_axial(name, -0.5))
        for name in (
            *("largest_error", "mean_error", "largest_fe_error"),
            *("largest_heldout_error", "mean_heldout_error"),
        )
    },
}


@pytest.mark.parametrize("kind", IMPOSSIBLE)
def test_impossible_numbers_are_refused_at_load(tmp_path, kind):
    path = changed_file(tmp_path / "model.json", *IMPOSSIBLE[kind])
    with refused("model.json"):
        ComplianceModel.load(path)


def test_a_compliance_that_is_not_positive_is_no_answer(tmp_path):
    """It is found where the model is asked: elsewhere in the range its equation is above zero."""
    path = changed_file(tmp_path / "model.json", LINEAR, of_axial("coefficients", -1e-11, 0))
    model = ComplianceModel.load(path)
    thin = MIDDLE | {"web_thickness": 0.040}
    assert model.axial_compliance(**thin) > 0.0
    several = MIDDLE | {"web_thickness": np.array([0.040, 0.068])}
    for ask, throw in (
        (model.axial_compliance, MIDDLE),
        (model.axial_compliance, several),
        (lambda **asked: model.value("axial_compliance", **asked), MIDDLE),
        (lambda **asked: model.lookup("axial_compliance", **asked), MIDDLE),
    ):
        with refused("axial_compliance"):
            ask(**throw)


HEAVY = (
    *("gmsh", "vtk", "vtkmodules", "pyvista", "scipy", "pint", "skfem", "matplotlib", "meshio"),
    *("rich", "typer"),
)
LIGHT = (
    "import sys; import crankfem as cf; cf.ComplianceModel; "
    f"print(*(set({HEAVY!r}) & sys.modules.keys()))"
)


def light_import():
    done = subprocess.run(
        [sys.executable, "-c", LIGHT], check=True, cwd=ROOT, capture_output=True, text=True
    )
    return done.stdout.split()


@pytest.mark.slow
def test_import_for_lookups_is_light():
    assert light_import() == []


LOOKUP_BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098)}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 5) for ends in LOOKUP_BOX.values()))))
SIZES = {  # value in the middle, exponent of the thickness, symbol and unit
    "axial_compliance": (1.3e-9, -1.2, "e_n", "m/N"),
    "influence_coefficient": (0.6e-9, -1.2, "c", "m/N"),
    "axial_compliance_in_line": (0.26e-9, -0.9, "e_0", "m/N"),
    "axial_compliance_opposite": (1.34e-9, -0.9, "e_180", "m/N"),
    "influence_coefficient_in_line": (0.08e-9, -0.9, "c_0", "m/N"),
    "influence_coefficient_opposite": (0.6e-9, -0.9, "c_180", "m/N"),
    "tilt_stiffness_ratio": (2.65, -0.9, "rho", ""),
}


def lookup_response(size, exponent, symbol, unit, sign=1.0):
    y = sign * size * (GRID[:, 0] / 0.3) ** -0.5 * (GRID[:, 1] / 0.068) ** exponent
    form = "log-quadratic" if sign > 0.0 else "quadratic"
    fit = fit_form(form, tuple(LOOKUP_BOX), GRID, y, drop_terms=True)
    made = ResponseModel.from_fit(fit, symbol=symbol, unit=unit, fe_error=0.01)
    return ResponseModel(**(made.model_dump() | {"band_error": 0.02}))


@pytest.fixture(scope="module")
def model():
    return ComplianceModel(
        responses={name: lookup_response(*given) for name, given in SIZES.items()}
    )


@pytest.mark.parametrize("gamma", [None, 120.0])
def test_bands_of_arrays_are_those_of_each_throw(model, gamma):
    widths = np.linspace(0.25, 0.345, 12).reshape(3, 4)
    asked = {"web_width": widths, "web_thickness": np.linspace(0.05, 0.09, 4)}
    found = model.lookups("influence_coefficient", gamma_deg=gamma, **asked)
    arrays = np.broadcast_arrays(*asked.values())
    for place in np.ndindex(3, 4):
        one = dict(zip(asked, (float(array[place]) for array in arrays), strict=True))
        alone = model.lookup("influence_coefficient", gamma_deg=gamma, **one)
        assert found.value[place] == close(alone.value, rel=1e-14)
        assert found.inside[place] == alone.inside
        for end, expected in ((found.lower, alone.lower), (found.upper, alone.upper)):
            if alone.inside:
                assert end[place] == close(expected, rel=1e-14)
            else:
                assert np.isinf(end[place])
    assert found.inside.sum() == 7
    (remark,) = found.remarks
    assert remark.startswith("web_width: given 250 mm (and 4 more); the range of the fit is 270")
    assert found.unit == "m/N"
    frame = found.to_pandas()
    assert frame["value"].tolist() == found.value.ravel().tolist()
    assert frame.attrs["units"] == {"value": "m/N", "lower": "m/N", "upper": "m/N", "inside": ""}
    with refused("web_width"):
        model.lookups("influence_coefficient", gamma_deg=gamma, strict=True, **asked)


@pytest.mark.slow
def test_a_million_bands_are_looked_up(model):
    rng = np.random.default_rng(3)
    asked = {name: rng.uniform(*ends, 1_000_000) for name, ends in LOOKUP_BOX.items()}
    found = model.lookups("axial_compliance", gamma_deg=120.0, **asked)
    assert found.inside.all()
    last = {name: values[-1:] for name, values in asked.items()}
    alone = model.lookups("axial_compliance", gamma_deg=120.0, **last)
    for whole, single in ((found.value, alone.value), (found.lower, alone.lower)):
        assert whole[-1] == close(single[0], 1e-12)


def test_bands_of_arrays_of_either_sign():
    """A negative response has its ends the other way round; no end where the error reaches 100 %."""
    negative = lookup_response(0.6e-9, -1.2, "c", "m/N", sign=-1.0)
    widths = np.array([0.28, 0.3])
    found = ComplianceModel(responses={"influence_coefficient": negative}).lookups(
        "influence_coefficient", web_width=widths, web_thickness=0.06
    )
    assert np.all((found.lower < found.value) & (found.value < found.upper) & (found.upper < 0.0))
    poor = ResponseModel(
        **(lookup_response(*SIZES["axial_compliance"]).model_dump() | {"band_error": 1.2})
    )
    found = ComplianceModel(responses={"axial_compliance": poor}).lookups(
        "axial_compliance", web_width=widths, web_thickness=0.06
    )
    assert found.inside.all()
    assert found.lower == close(found.value * 0.99 / 2.2, rel=1e-12)
    assert np.isposinf(found.upper).all()


IRON = Material(youngs_modulus=1.65e11, poisson_ratio=0.3, density=7200.0)
BY_UNIT = {"m/N": 210.0 / 165.0, "rad/(N m)": 210.0 / 165.0, "kg": 7200.0 / 7850.0, "": 1.0}
SIZE = {"web_width": 0.285, "web_thickness": 0.061}


@pytest.fixture(scope="module")
def stored():
    """A model of a study, with equations of five forms."""
    return ComplianceModel.load(Path(__file__).parents[1] / "data" / "model-0.2.0.json")


def test_another_modulus_and_density_are_answered_exactly(stored, tmp_path):
    """Equations of all forms: compliances inverse to E, masses by the density, ratios unchanged."""
    throw = CrankThrow(**stored.throw)
    steel, iron = stored.of_throw(throw), stored.of_throw(throw, material=IRON)
    for name, answer in steel.items():
        factor = BY_UNIT[answer.unit]
        for bound in ("value", "lower", "upper"):
            assert getattr(iron[name], bound) == close(factor * getattr(answer, bound), rel=1e-12)
        slopes = stored.slopes(name, **SIZE), stored.of_material(IRON).slopes(name, **SIZE)
        for factor_name, slope in slopes[0].items():
            assert slopes[1][factor_name].value == close(factor * slope.value, rel=1e-9)
        assert (iron[name].equation == answer.equation) == (factor == 1.0)
    force = (0.0, -1e5, 0.0)
    reactions = [m.reactions(force, **SIZE) for m in (stored, stored.of_material(IRON))]
    assert reactions[1].left.force == close(reactions[0].left.force, rel=1e-12)
    stored.of_material(IRON).save(tmp_path / "iron.json")
    assert ComplianceModel.load(tmp_path / "iron.json").of_throw(throw) == iron
    assert stored.of_material(STEEL) is stored


def test_another_poisson_ratio_and_no_material_are_refused(stored):
    throw = CrankThrow(**stored.throw)
    with refused("material.poisson_ratio"):
        stored.of_throw(throw, material=IRON.changed(poisson_ratio=0.29))
    with pytest.raises(InputError, match=r"material: given \{\}"):
        stored.changed(material={}).of_throw(throw, material=STEEL)
    other = stored.responses["mass"].changed(unit="kg m")
    with refused("unit"):
        stored.changed(responses={"mass": other}).of_material(IRON)


test_refused_calls = refusals(
    ("crank_radius", lambda: MODEL.axial_compliance(**MIDDLE, crank_radius=0.175)),
    ("crank_radius", lambda: MODEL.axial_compliance(**MIDDLE, crank_radius=[0.17, 0.18])),
    ("fillet_radius", lambda: MODEL.axial_compliance(**MIDDLE, fillet_radius=0.012)),
    ("response", lambda: MODEL.lookup("mass", **MIDDLE)),
)
