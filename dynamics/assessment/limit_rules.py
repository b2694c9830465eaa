"""Limits of torsional stress from classification rules, with their sources."""

import math
from collections.abc import Callable
from functools import partial
from typing import Literal, TypedDict, Unpack, get_args

import numpy as np

from crankbase.array_checks import Array, positive_number
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.sentences import amount
from dynamics.assessment.limits import (
    LimitCurve,
    VibrationLimit,
    checked_rated_speed,
    constant_curve,
)

M68_SOURCE = (
    "IACS unified requirement M68 (Rev.3, February 2021), as carried into the Korean Register's "
    "Rules for Steel Ships 2025, Part 5, Chapter 4, 202"
)
CRANKSHAFT_SOURCE = "Korean Register, Rules for Steel Ships 2025, Part 5, Chapter 4, 201"
GENERATOR_SOURCE = "Korean Register, Rules for Steel Ships 2025, Part 5, Chapter 4, 203"
GENERATOR_READING = (
    "below 0.9 of the rated speed a generating set only passes, with the rule's limit for passing; values "
    "and speeds come from the 2025 edition alone, and no second source confirms them: check the rule before "
    "relying on them"
)

SHAFT_FEATURES: dict[str, tuple[float, bool]] = {
    "integral flange": (1.0, True),
    "shrink fit": (1.0, True),
    "tapered keyway": (0.6, True),
    "cylindrical keyway": (0.45, True),
    "radial hole": (0.5, True),
    "longitudinal slot": (0.3, True),
    "thrust collar": (0.85, True),
    "thrust roller bearing": (0.85, True),
    "propeller shaft": (0.55, False),
    "stern tube shaft": (0.8, False),
}
"""Factor c_K of a shaft's weakest feature, and whether it belongs to an intermediate or thrust shaft."""
# Tensile strengths that enter the formula of M68 at most [Pa].
CARBON_STRENGTH, ALLOY_STRENGTH = 600e6, 800e6
LOWEST_STRENGTH = 400e6
# Materials above which the limits of crankshafts may be raised, and up to which by formula [Pa].
BASE_STRENGTH, BASE_YIELD = 440e6, 225e6
CRANKSHAFT_STRENGTHS = {False: 590e6, True: 835e6}  # carbon steel, low alloy steel

# Share of the rated speed from which on a generating set of constant speed is kept running.
LEAST_SET_SPEED = 0.9

Kind = Literal["in line", "V"]


def propulsion_shaft_limit(
    tensile_strength: float,
    diameter: float,
    rated_speed: float,
    *,
    feature: str = "integral flange",
    alloy: bool = False,
    applies_to: str = "",
) -> VibrationLimit:
    """Return the torsional stress that classification permits in a ship's propulsion shaft.

    Parameters
    ----------
    tensile_strength : float
        Specified minimum tensile strength [Pa].
    diameter : float
        Of the shaft [m].
    rated_speed : float
        Maximum continuous speed of the shaft [rad/s].
    feature : str
        The weakest feature, a key of `SHAFT_FEATURES`: it sets c_K.
    alloy : bool
        Whether the steel is low-alloy; carbon and carbon-manganese steel otherwise.
    applies_to : str
        Name of the shaft; by default the feature.

    Returns
    -------
    VibrationLimit
        Amplitude of the nominal torsional stress [Pa] up to 1.05 of the rated speed, and up to 0.8 while
        a barred range is passed.

    Raises
    ------
    InputError
        If a value is not above zero, the strength is below 400 MPa or the feature unknown.

    Notes
    -----
    With the ratio r of the speed to the rated one, d in mm and stresses in N/mm2:
    (T + 160) / 18 c_K c_D (3 - 2 r^2) below r = 0.9, 1.38 (T + 160) / 18 c_K c_D from 0.9 to 1.05,
    c_D = 0.35 + 0.93 d^-0.2; 1.7 / sqrt(c_K) of that while passing. T is at most 600, and 800 for
    alloy steel of intermediate and thrust shafts.
    """
    strength = positive_number("tensile_strength", tensile_strength, "Pa", "it is that of a steel")
    size = positive_number("diameter", diameter, "m", "it is that of a shaft")
    rated = checked_rated_speed(rated_speed)
    check_choice("feature", feature, SHAFT_FEATURES, "the rule gives a factor for these")
    if strength < LOWEST_STRENGTH:
        raise InputError(
            f"tensile_strength: given {amount(strength, 'Pa')}; allowed is "
            f"{amount(LOWEST_STRENGTH, 'Pa')} or more, because "
            "classed shaft forgings begin there."
        )
    factor, may_be_alloy = SHAFT_FEATURES[feature]
    counted = min(strength, ALLOY_STRENGTH if alloy and may_be_alloy else CARBON_STRENGTH)
    base = (counted / 1e6 + 160.0) / 18.0 * factor * (0.35 + 0.93 * (size / 1e-3) ** -0.2) * 1e6
    remarks = []
    if counted < strength:
        remarks.append(
            f"a tensile strength of {amount(strength, 'Pa')} enters the rule as {amount(counted, 'Pa')}"
        )
    if "keyway" in feature:
        remarks.append("keyways are in general not used where a speed range is barred")
    return VibrationLimit(
        quantity="torsional stress",
        applies_to=applies_to
        or f"shaft with {feature}".replace("shaft with propeller", "propeller"),
        unit="Pa",
        continuous=LimitCurve(partial(_of_propulsion, rated, base), 0.0, 1.05 * rated),
        passing=LimitCurve(
            partial(_of_propulsion, rated, 1.7 / math.sqrt(factor) * base), 0.0, 0.8 * rated
        ),
        source=f"{M68_SOURCE}, c_K = {factor:g}",
        remark="; ".join(remarks),
    )


def _of_propulsion(rated: float, base: float, speeds: Array) -> Array:
    ratio = speeds / rated
    return np.asarray(base * np.where(ratio < 0.9, 3.0 - 2.0 * ratio**2, 1.38))


class Steel(TypedDict, total=False):
    """Material of a crankshaft; see `crankshaft_limit`."""

    tensile_strength: float
    yield_strength: float
    alloy: bool


def crankshaft_limit(
    rated_speed: float,
    *,
    strokes: int,
    kind: Kind = "in line",
    firing_interval_deg: float | None = None,
    **steel: Unpack[Steel],
) -> VibrationLimit:
    """Return the torsional stress that one class permits in the crankshaft of a ship's main engine.

    Use it where the engine maker states none: a crankshaft whose strength was calculated is
    approved up to the stress that its maker specifies, which then is the limit.

    Parameters
    ----------
    rated_speed : float
        Maximum continuous speed [rad/s].
    strokes : int
        2 or 4.
    kind : {"in line", "V"}
    firing_interval_deg : float, optional
        Of a V engine; 45 and 60 deg have the limits of engines in line.
    tensile_strength, yield_strength : float
        Specified minimum values [Pa]; more than 440 and 225 MPa raise the limits. A tensile strength
        enters the rule as at most 590 MPa of carbon steel and 835 MPa of low alloy steel.
    alloy : bool
        Whether the steel is low-alloy; carbon steel otherwise.

    Returns
    -------
    VibrationLimit
        Amplitude of the nominal torsional stress [Pa] up to 1.15 of the rated speed, and up to 0.8 while
        a barred range is passed.

    Raises
    ------
    InputError
        If strokes or kind are unknown, or the yield strength is above the tensile strength.

    Notes
    -----
    With the ratio r of the speed to the rated one, in N/mm2: 45 - 24 r^2 (two-stroke engines and
    other V engines 45 - 29 r^2) up to r = 1, then 21 (16) + 237 (r - 0.8) sqrt(r - 1) up to 1.15;
    twice the former while passing, up to 0.8. They are multiplied by 1 + 2/3 (T / 440 - 1), those
    while passing by Y / 225, if T or Y exceed these values.
    """
    rated = checked_rated_speed(rated_speed)
    even = _has_limits_of_engines_in_line(strokes, kind, firing_interval_deg)
    kept, passed = crankshaft_material_factors(**steel)
    permitted = partial(_of_crankshaft, rated, even)
    return VibrationLimit(
        quantity="torsional stress",
        applies_to="crankshaft",
        unit="Pa",
        continuous=LimitCurve(partial(permitted, kept), 0.0, 1.15 * rated),
        passing=LimitCurve(partial(permitted, 2.0 * passed), 0.0, 0.8 * rated),
        source=CRANKSHAFT_SOURCE,
        remark="; ".join(filter(None, (_counted(**steel), _raised(passed)))),
    )


def _of_crankshaft(rated: float, even: bool, factor: float, speeds: Array) -> Array:
    slope, at_rated = (24.0, 21.0) if even else (29.0, 16.0)
    ratio = speeds / rated
    above = at_rated + 237.0 * (ratio - 0.8) * np.sqrt(np.maximum(ratio - 1.0, 0.0))
    return factor * np.where(ratio <= 1.0, 45.0 - slope * ratio**2, above) * 1e6


def generator_set_limit(
    rated_speed: float,
    *,
    part: Literal["crankshaft", "generator shaft"],
    strokes: int = 4,
    kind: Kind = "in line",
    firing_interval_deg: float | None = None,
    **steel: Unpack[Steel],
) -> VibrationLimit:
    """Return the torsional stress that one class permits in a generator set of constant speed.

    Parameters
    ----------
    rated_speed : float
        [rad/s].
    part : {"crankshaft", "generator shaft"}
    strokes, kind, firing_interval_deg, tensile_strength, yield_strength, alloy
        As in `crankshaft_limit`.

    Returns
    -------
    VibrationLimit
        Amplitude of the nominal torsional stress [Pa] from 0.9 to 1.1 of the rated speed: 21 N/mm2 in
        the crankshaft (two-stroke engines and other V engines 16), 31 in the generator shaft. Below 0.9
        a set only passes the speeds, with 90 and 118. Strong materials raise the limits as
        in `crankshaft_limit`.

    Raises
    ------
    InputError
        As `crankshaft_limit`, and if the part is unknown.
    """
    rated = checked_rated_speed(rated_speed)
    check_choice("part", part, ("crankshaft", "generator shaft"), "the rule limits these")
    even = _has_limits_of_engines_in_line(strokes, kind, firing_interval_deg)
    kept, passed = crankshaft_material_factors(**steel)
    running, quick = (31e6, 118e6) if part == "generator shaft" else (21e6 if even else 16e6, 90e6)
    slowest = LEAST_SET_SPEED * rated
    return VibrationLimit(
        quantity="torsional stress",
        applies_to=part,
        unit="Pa",
        continuous=LimitCurve(
            partial(_of_set, slowest, passed * quick, kept * running), 0.0, 1.1 * rated
        ),
        passing=constant_curve(passed * quick, 0.0, slowest),
        source=GENERATOR_SOURCE,
        remark="; ".join(filter(None, (_counted(**steel), _raised(passed), GENERATOR_READING))),
    )


def _of_set(slowest: float, below: float, running: float, speeds: Array) -> Array:
    return np.where(speeds < slowest, below, running)


def _has_limits_of_engines_in_line(strokes: int, kind: str, interval: float | None) -> bool:
    if strokes not in (2, 4):
        raise InputError(f"strokes: given {strokes}; allowed are 2 and 4.")
    check_choice("kind", kind, get_args(Kind), "the rule covers these")
    return strokes == 4 and (kind == "in line" or interval in (45.0, 60.0))


def crankshaft_material_factors(
    tensile_strength: float = BASE_STRENGTH,
    yield_strength: float = BASE_YIELD,
    *,
    alloy: bool = False,
) -> tuple[float, float]:
    """Return the factors by which a strong material raises the limits for running and for passing.

    Parameters
    ----------
    tensile_strength, yield_strength : float
        Specified minimum strengths [Pa].
    alloy : bool
        Whether the steel is low-alloy; carbon steel otherwise.
    """
    strength = positive_number("tensile_strength", tensile_strength, "Pa", "it is that of a steel")
    limit = positive_number("yield_strength", yield_strength, "Pa", "it is that of a steel")
    if limit > strength:
        raise InputError(
            f"yield_strength: given {amount(limit, 'Pa')} above a tensile strength of "
            f"{amount(strength, 'Pa')}; allowed is that or less, because a steel yields before it breaks."
        )
    counted = min(strength, CRANKSHAFT_STRENGTHS[alloy])
    kept = 1.0 + 2.0 / 3.0 * (max(counted, BASE_STRENGTH) / BASE_STRENGTH - 1.0)
    return kept, max(limit, BASE_YIELD) / BASE_YIELD


def _counted(**steel: Unpack[Steel]) -> str:
    """State with which value a strength beyond the end of the rule's formula enters it, else nothing."""
    strength, alloy = steel.get("tensile_strength", BASE_STRENGTH), steel.get("alloy", False)
    most = CRANKSHAFT_STRENGTHS[alloy]
    if strength <= most:
        return ""
    text = f"a tensile strength of {amount(strength, 'Pa')} enters the rule as {amount(most, 'Pa')}"
    end = f", where its formula ends for {'low alloy' if alloy else 'carbon'} steel"
    more = (
        ""
        if alloy
        else f" (for low alloy steel, alloy = true, at {amount(CRANKSHAFT_STRENGTHS[True], 'Pa')})"
    )
    return f"{text}{end}{more}"


def _raised(passed: float) -> str:
    """State by what the yield strength raises the limits while passing, which may decide nothing."""
    return f"by the yield strength {passed:.3g} times as much may be passed" if passed > 1.0 else ""


CRANKSHAFT_RULES: dict[str, Callable[..., VibrationLimit]] = {
    "KR main engine": crankshaft_limit,
    "KR generator set": partial(generator_set_limit, part="crankshaft"),
}
"""Rules for crankshafts by name; called with what `crankshaft_limit` is, by the same names."""
RULE_OF_DRIVEN = {"propeller": "KR main engine", "generator": "KR generator set"}
"""What an engine drives to the name of the rule for its crankshaft."""
