"""Lookups of arrays beside those of each of their throws alone: equal to rounding (1e-14)."""

import itertools
import time

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098)}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 5) for ends in BOX.values()))))
SIZES = {  # value in the middle, exponent of the thickness, symbol and unit
    "axial_compliance": (1.3e-9, -1.2, "e_n", "m/N"),
    "influence_coefficient": (0.6e-9, -1.2, "c", "m/N"),
    "axial_compliance_in_line": (0.26e-9, -0.9, "e_0", "m/N"),
    "axial_compliance_opposite": (1.34e-9, -0.9, "e_180", "m/N"),
    "influence_coefficient_in_line": (0.08e-9, -0.9, "c_0", "m/N"),
    "influence_coefficient_opposite": (0.6e-9, -0.9, "c_180", "m/N"),
    "tilt_stiffness_ratio": (2.65, -0.9, "rho", ""),
}


def response(size, exponent, symbol, unit, sign=1.0):
    y = sign * size * (GRID[:, 0] / 0.3) ** -0.5 * (GRID[:, 1] / 0.068) ** exponent
    form = "log-quadratic" if sign > 0.0 else "quadratic"
    fit = fit_form(form, tuple(BOX), GRID, y, drop_terms=True)
    made = ResponseModel.from_fit(fit, symbol=symbol, unit=unit, fe_error=0.01)
    return ResponseModel(**(made.model_dump() | {"band_error": 0.02}))


@pytest.fixture(scope="module")
def model():
    return ComplianceModel(responses={name: response(*given) for name, given in SIZES.items()})


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
    assert remark.startswith(
        "web_width: given 250 mm (and 4 more); the range of the fit is 270 mm to"
    )
    assert found.unit == "m/N"
    frame = found.to_pandas()
    assert frame["value"].tolist() == found.value.ravel().tolist()
    assert frame.attrs["units"] == {"value": "m/N", "lower": "m/N", "upper": "m/N", "inside": ""}
    with pytest.raises(InputError, match=r"web_width: given .* strict results are requested"):
        model.lookups("influence_coefficient", gamma_deg=gamma, strict=True, **asked)


def test_a_million_bands_in_less_than_a_second(model):
    rng = np.random.default_rng(3)
    asked = {name: rng.uniform(*ends, 1_000_000) for name, ends in BOX.items()}
    start = time.process_time()
    found = model.lookups("axial_compliance", gamma_deg=120.0, **asked)
    assert time.process_time() - start < 1.0
    assert found.inside.all()


def test_bands_of_arrays_of_either_sign():
    """A negative response has its ends the other way round; no end where the error reaches 100 %."""
    negative = response(0.6e-9, -1.2, "c", "m/N", sign=-1.0)
    widths = np.array([0.28, 0.3])
    found = ComplianceModel(responses={"influence_coefficient": negative}).lookups(
        "influence_coefficient", web_width=widths, web_thickness=0.06
    )
    assert np.all((found.lower < found.value) & (found.value < found.upper) & (found.upper < 0.0))
    poor = ResponseModel(
        **(response(*SIZES["axial_compliance"]).model_dump() | {"band_error": 1.2})
    )
    found = ComplianceModel(responses={"axial_compliance": poor}).lookups(
        "axial_compliance", web_width=widths, web_thickness=0.06
    )
    assert found.inside.all()
    assert found.lower == close(found.value * 0.99 / 2.2, rel=1e-12)
    assert np.isposinf(found.upper).all()
