"""Checks of runs and responses for a fit."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError
from regression.fits.forms import Form

Array = NDArray[np.float64]


def checked_runs(
    x_name: str, y_name: str, factors: tuple[str, ...], x: ArrayLike, y: ArrayLike, form: Form
) -> tuple[Array, Array]:
    """Return columns (n, k) and responses (n,), checked for a fit.

    Raises
    ------
    InputError
    """
    if not factors or len(set(factors)) != len(factors):
        raise InputError(
            f"factors: given {list(factors)}; allowed is each varied dimension once, at least one."
        )
    points = np.asarray(x, dtype=np.float64)
    values = np.asarray(y, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != len(factors) or points.shape[0] == 0:
        raise InputError(
            f"{x_name}: given an array of shape {points.shape}; allowed is (runs, {len(factors)}), "
            f"one column for each of {', '.join(factors)}."
        )
    if values.shape != points.shape[:1]:
        raise InputError(
            f"{y_name}: given an array of shape {values.shape}; allowed is ({points.shape[0]},), "
            f"one response for each row of {x_name}."
        )
    for name, array in ((x_name, points), (y_name, values)):
        if not np.all(np.isfinite(array)):
            raise InputError(
                f"{name}: given a number that is not finite; leave failed runs out of a fit."
            )
    if np.any(values == 0.0):
        raise InputError(
            f"{y_name}: given a response of 0; allowed is any other number, because errors are "
            "relative to the response."
        )
    if form.logarithmic and not np.all(values > 0.0):
        raise InputError(
            f"{y_name}: given {float(np.min(values)):g}, which is not positive; allowed are "
            f"positive values, because the {form.name} form takes their logarithm."
        )
    return points, values


def checked_sizes(name: str, scale: ArrayLike, values: Array) -> Array:
    """Return the scale of each response, all above zero.

    Raises
    ------
    InputError
    """
    sizes = np.asarray(scale, dtype=np.float64)
    if sizes.shape not in ((), values.shape) or not np.all(np.isfinite(sizes) & (sizes > 0.0)):
        raise InputError(
            f"{name}: given an array of shape {sizes.shape}; allowed are positive numbers, one or "
            f"{len(values)}, because a response is divided by its scale."
        )
    return sizes
