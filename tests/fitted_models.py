"""Compliance models of a throw with known equations and known errors."""

import itertools

import numpy as np

from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import input_path
from fem.material import STEEL
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.throw_values import throw_values

THIN, THICK = 0.045, 0.090
UNITS = {"axial_compliance": "m/N", "torsional_compliance": "rad/(N m)"}


def known_model(throw, material, compliances, error):
    """Make a model of webs of 45 to 90 mm: lines of half the slope, with an error at held-out designs.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    compliances : dict of str to float
        Response to its value at the web thickness of the throw.
    error : float
        By which the lines miss the held-out designs, above one of them and below the other.
    """
    at = np.array([[THIN], [throw.web_thickness], [THICK]])
    held = np.array([[THIN + 0.005], [THICK - 0.010]])

    def response(name, value):
        def line(points):
            return value * (1.0 - 0.5 * (points[:, 0] / throw.web_thickness - 1.0))

        found = line(held) / np.array([1.0 + error, 1.0 - error])
        fit = fit_form("linear", ("web_thickness",), at, line(at), held, found)
        return ResponseModel.from_fit(fit, symbol="e", unit=UNITS[name])

    described = throw_values(throw, spelled_out=True)
    del described["web_thickness"]
    return ComplianceModel(
        responses={name: response(name, value) for name, value in compliances.items()},
        fixed={name: one for name, one in described.items() if isinstance(one, float)},
        labels={name: one for name, one in described.items() if isinstance(one, str)},
        throw=throw.model_dump(mode="json", exclude_defaults=True),
        material=material.model_dump(),
    )


THROW = load_throw(input_path("6chn25-34"))[0]
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.050, 0.090)}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 3) for ends in BOX.values()))))
FIXED = (
    *("crank_radius", "main_journal_diameter", "pin_diameter", "main_journal_length"),
    *("pin_length", "fillet_radius", "main_journal_bore", "pin_bore"),
)
SIZES = {
    "axial_compliance": (1.3e-9, -1.0, "e_n", "m/N"),
    "axial_compliance_in_line": (0.26e-9, -0.5, "e_0", "m/N"),
    "axial_compliance_opposite": (1.3e-9, -1.0, "e_180", "m/N"),
    "tilt_stiffness_ratio": (2.6, -0.2, "rho", ""),
    "torsional_compliance": (4e-8, -0.1, "e_t", "rad/(N m)"),
    "mass": (100.0, 0.8, "m", "kg"),
}

JUDGED = {"largest_heldout_error": 0.005, "band_error": 0.005, "band_designs": 40}


def power(size, exponent):
    return lambda x: size * (x[:, 0] / 0.3) ** -0.5 * (x[:, 1] / 0.068) ** exponent


def made_model(**others):
    """Make a model of a shipped throw whose web varies: powers with known errors."""
    responses = {}
    for name, (size, exponent, symbol, unit) in SIZES.items():
        values = power(size, exponent)(GRID)
        fit = fit_form("log-quadratic", tuple(BOX), GRID, values, GRID, values)
        made = ResponseModel.from_fit(fit, symbol=symbol, unit=unit, fe_error=0.01)
        responses[name] = ResponseModel(**(made.model_dump() | JUDGED))
    content = {
        "responses": responses,
        "fixed": {name: getattr(THROW, name) for name in FIXED},
        "ranges": BOX,
        "throw": THROW.model_dump(mode="json"),
        "material": STEEL.model_dump(),
    }
    return ComplianceModel(**(content | others))
