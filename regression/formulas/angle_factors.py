"""How the formulas take account of the angle between neighboring cranks.

Each author gives the crankpin's and the web's term a factor that falls with gamma. The factors
here are divided by their values at gamma = 180 deg, so that they compare with e(gamma) / e_180 of
finite elements. Draminsky's second formula with k/4 in both places has Anderson's factors.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)


@dataclass(frozen=True)
class AngleFactors:
    """Factors of the crankpin's and the web's term, (g,) each, 1 at gamma = 180 deg."""

    pin: Array
    web: Array


def anderson_k_phi(cosine: Number) -> Number:
    """Return Anderson's k_phi = 0.75 - 0.25 cos gamma."""
    return 0.75 - 0.25 * cosine


def draminsky_k(cosine: Number) -> Number:
    """Return Draminsky's k = 1 + cos gamma."""
    return 1.0 + cosine


def gorbunov_k_phi(cosine: Number, number: float) -> Number:
    """Return Gorbunov's k_phi = 0.8 (1 - cos gamma), with another number in place of 0.8."""
    return number * (1.0 - cosine)


def dorey_shares(gamma_deg: Number) -> tuple[Number, Number]:
    """Return Dorey's 0.5 + gamma / 360 of the pin and 0.167 + gamma / 360 of the web."""
    return 0.5 + gamma_deg / 360.0, 0.167 + gamma_deg / 360.0


def _anderson(gamma_deg: Array) -> AngleFactors:
    k_phi = anderson_k_phi(np.cos(np.deg2rad(gamma_deg)))
    # The web's factor k_1^2 (k_phi - k_1 / 3) for journals thin beside the crank, k_1 = 1.
    return AngleFactors(k_phi, 1.5 * (k_phi - 1.0 / 3.0))


def _gorbunov(gamma_deg: Array) -> AngleFactors:
    k_phi = gorbunov_k_phi(np.cos(np.deg2rad(gamma_deg)), 0.5)
    return AngleFactors(np.ones_like(k_phi), k_phi)


def _draminsky_2(gamma_deg: Array) -> AngleFactors:
    k = draminsky_k(np.cos(np.deg2rad(gamma_deg)))
    return AngleFactors(1.0 - k / 12.0, 1.0 - 0.75 * k)


def _dorey(gamma_deg: Array) -> AngleFactors:
    pin, web = dorey_shares(gamma_deg)
    return AngleFactors(pin, web / 0.667)


ANGLE_FACTORS: Mapping[str, Callable[[Array], AngleFactors]] = {
    "Draminsky (2)": _draminsky_2,
    "Anderson": _anderson,
    "Gorbunov": _gorbunov,
    "Dorey": _dorey,
}
