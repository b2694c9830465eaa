"""Numbers of a diagram in as few characters as one sees."""

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 5
# Powers of ten up to this one are exact numbers.
EXACT = 22


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
    given = np.asarray(values, dtype=np.float64)
    known = np.isfinite(given)
    finite = np.where(known, given, 0.0)
    sizes = np.where(finite == 0.0, 1.0, np.abs(finite))
    shifts = np.minimum(digits - 1 - np.floor(np.log10(sizes)), EXACT)
    # Whole number times or by an exact power: the nearest number there is, which is written shortest.
    powers = 10.0 ** np.abs(shifts)
    whole = np.rint(np.where(shifts >= 0.0, finite * powers, finite / powers))
    found = np.where(shifts >= 0.0, whole / powers, whole * powers)
    return [
        None if not here else int(value) if value.is_integer() else value
        for value, here in zip(found.tolist(), known.tolist(), strict=True)
    ]
