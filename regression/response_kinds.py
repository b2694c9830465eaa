"""Properties of responses for equations and lookups; `fem.responses` declares the rest."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from crankbase.errors import InputError
from fem.material import Material

AXIAL = "axial_compliance"
TORSIONAL = "torsional_compliance"
INFLUENCE = "influence_coefficient"
TILT_RATIO = "tilt_stiffness_ratio"
# Responses that are above zero in every throw; influence coefficients and reactions have a sign.
ABOVE_ZERO = (
    *(AXIAL, TORSIONAL, TILT_RATIO),
    *("cross_tilt_stiffness_ratio", "mass", "fillet_stress_factor"),
)
# Compliances of a force at its own place, which finite elements find too small if nothing corrects them;
# an influence coefficient is none.
TOO_SMALL = (AXIAL, TORSIONAL)
# Responses that depend on the angle to the neighbors, and what their angle law needs.
ANGLE_LAWS: Mapping[str, tuple[str, str, str]] = {
    name: (f"{name}_in_line", f"{name}_opposite", TILT_RATIO) for name in (AXIAL, INFLUENCE)
}


@dataclass(frozen=True)
class ResponseScale:
    """Conversion between responses of a unit and dimensionless ones.

    Attributes
    ----------
    symbol : str
        The dimensionless response, "{}" being the symbol of the response.
    value : callable
        Material and pin diameter to the factor on the dimensionless response.
    """

    symbol: str
    value: Callable[[Material, Any], Any]


# E is Young's modulus, rho the density, D_shm the pin diameter.
SCALES: Mapping[str, ResponseScale] = {
    "m/N": ResponseScale("{} E D_shm", lambda m, pin: 1.0 / (m.youngs_modulus * pin)),
    "rad/(N m)": ResponseScale(
        "{} E D_shm^3", lambda m, pin: 1.0 / (m.youngs_modulus * pin * pin * pin)
    ),
    "kg": ResponseScale("{} / (rho D_shm^3)", lambda m, pin: m.density * pin * pin * pin),
    "": ResponseScale("{}", lambda _, __: 1.0),
}


def is_positive_response(response: str) -> bool:
    """Whether a response, named as in a study or a model, is above zero by nature."""
    return response.startswith(ABOVE_ZERO)


def response_scale(unit: str, dimensions: Mapping[str, Any], material: Material) -> Any:
    """Factor from a dimensionless response to the response.

    Parameters
    ----------
    unit : str
        SI unit of the response.
    dimensions : mapping
        The pin diameter, at least.
    material : Material

    Raises
    ------
    InputError
        If responses of this unit have no scale.
    """
    if unit not in SCALES:
        raise InputError(
            f"unit: given {unit!r}; allowed are {', '.join(filter(None, SCALES))} and none, because "
            "only these have a scale made of modulus, density and pin diameter."
        )
    return SCALES[unit].value(material, dimensions["pin_diameter"])
