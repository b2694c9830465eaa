"""Numbers of a diagram in as few characters as one sees."""

import math

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 5


def rounded(values: ArrayLike, digits: int = DIGITS) -> list[float | int | None]:
    """Round to significant digits, for JSON.

    Parameters
    ----------
    values : array_like of shape (n,)
    digits : int
        That stay.

    Returns
    -------
    list of n numbers
        None where a value is not finite; whole numbers as int, which saves their ".0".

    Examples
    --------
    >>> rounded([1234567.0, 0.0123456789, 2.0, float("inf")])
    [1234600, 0.012346, 2, None]
    """
    given = np.asarray(values, dtype=np.float64).tolist()
    return [shortest(float(f"{value:.{digits}g}")) for value in given]


def shortest(value: float) -> float | int | None:
    """Return a number as JSON writes it shortest: a whole one as int, None if it is not finite."""
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() else value
