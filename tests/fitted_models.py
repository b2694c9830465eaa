"""Compliance models of a throw with known equations and known errors."""

import numpy as np

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
