"""The angle law for looked-up values: e(gamma) from e_0, e_180 and rho.

e = e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma / 2)), written without the cotangent, which is infinite
at 0; for its derivation see `fem.angle_law`, which a lookup does not load because it loads a solver.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import finite_array
from crankbase.errors import InputError, quoted
from regression.response_kinds import fold_angle_deg

SEVERAL_PINS = (
    "gamma_deg: given for throws of several pins; allowed are throws of one pin, because with more the "
    "compliances at an angle and at its opposite differ: use analyze_throw."
)


def fold_angle(gamma_deg: ArrayLike) -> Any:
    """Fold angles between neighbors to 0 ... 180 deg; `InputError` if one is not a finite number.

    Examples
    --------
    >>> fold_angle(240.0), fold_angle(-90.0), fold_angle(540.0)
    (120.0, 90.0, 180.0)
    """
    if gamma_deg.__class__ in (float, int) and math.isfinite(gamma_deg):
        return fold_angle_deg(float(gamma_deg))
    angles = finite_array("gamma_deg", gamma_deg)
    if not angles.size:
        raise InputError(
            f"gamma_deg: given {quoted(gamma_deg)}; allowed are one or more angles in degrees, because each "
            "has a result."
        )
    if angles.ndim == 0:
        return fold_angle_deg(float(angles))
    rest = np.fmod(np.abs(angles), 360.0)  # as fold_angle_deg does, for all at once
    return np.where(rest > 180.0, 360.0 - rest, rest)


def between(gamma_deg: ArrayLike, in_line: Any, opposite: Any, ratio: Any) -> Any:
    """Value at an angle between neighboring cranks [deg] from those at 0 and 180 deg, floats or arrays.

    The ratio is rho, stiffness against tilting across the crank plane divided by that in it.
    `InputError` if an angle is not a finite number, or rho not positive.
    """
    least = ratio if isinstance(ratio, float) else float(np.min(ratio))
    if not least > 0.0:
        raise InputError(
            f"tilt_stiffness_ratio: given {least:g}; allowed is a positive number, because it is a ratio "
            "of two stiffnesses: an equation that gives another one does not hold for these dimensions."
        )
    share = opposite_share(gamma_deg, ratio)
    # In this form both ends are met to the last digit.
    values = in_line * (1.0 - share) + opposite * share
    return values if isinstance(values, np.ndarray) else float(values)


def opposite_share(gamma_deg: ArrayLike, ratio: Any) -> Any:
    """Share of e_180 in the mean of e_0 and e_180, by angle [deg] and rho."""
    half = np.pi / 360.0 * fold_angle(gamma_deg)
    if isinstance(half, float):
        sine, cosine = math.sin(half) ** 2, math.cos(half) ** 2
    else:
        sine, cosine = np.sin(half) ** 2, np.cos(half) ** 2
    return sine / (sine + ratio * cosine)


def between_values(angle: Any, values: Sequence[Any]) -> Any:
    """Apply the angle law to e_0, e_180 and rho, as `between`; `InputError` if the shapes do not fit, too."""
    try:
        return between(angle, *values)
    except InputError:
        raise
    except ValueError:
        raise InputError(
            f"gamma_deg: given an array of shape {np.shape(angle)} for dimensions of shape "
            f"{np.shape(values[0])}; allowed are shapes that can be broadcast together."
        ) from None


def between_ends(angle: Any, ends: Sequence[tuple[Any, Any]]) -> tuple[Any, Any]:
    """Apply the angle law to the ends of e_0, e_180 and rho: the smallest and the largest value.

    The law is a mean of e_0 and e_180, so it increases with both, and is monotonic in rho.
    """
    *values, ratios = ends
    low, high = (
        [between_values(angle, [*(pair[end] for pair in values), ratio]) for ratio in ratios]
        for end in (0, 1)
    )
    if isinstance(low[0], float):
        return min(low), max(high)
    return np.minimum(*low), np.maximum(*high)
