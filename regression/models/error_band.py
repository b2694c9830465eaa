"""The band of a looked-up value: the equation's error and the finite elements' own.

There are two errors between an equation and the throw. The equation differs from finite elements by up to m,
|equation / fe - 1| <= m. 95 % of new designs do not exceed m, measured at designs not used in the fit: the
runs, each left out of the fit and of the selection of its terms, and the designs held out of both. And finite
elements differ from the solution by an estimate f, either way. Hence::

    equation (1 - f) / (1 + m)    to  equation (1 + f) / (1 - m)

Models of older releases were fitted to finite elements that were not corrected for discretization, whose
compliances could only be too small; their bands begin at equation / (1 + m). The oldest have the largest
errors at the runs and at held-out designs only; m is then the larger of these. No band is valid outside the
range.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from regression.fits.statistics import COVERAGE
from regression.models.response_model import ResponseModel

# Smaller relative errors are rounding, and not told by their value.
LEAST_SAID = 1e-5
# The largest error of so many designs holds 95 % of new ones on the average.
FEWEST = 19
# A larger factor is the same as none: errors of nearly 100 %, or estimates beyond all measure.
_OPEN = 1e30


@dataclass(frozen=True)
class ErrorBand:
    """The band of a response as factors of its value, and its origin.

    Attributes
    ----------
    lower : float
        Factor to the end nearer to zero.
    upper : float or None
        Factor to the other end; None if an error of 100 % leaves it open.
    text : str
        One sentence.
    """

    lower: float
    upper: float | None
    text: str

    def around(self, value: float) -> tuple[float | None, float | None]:
        """Lower and upper end round a value, which may be negative."""
        low = value * self.lower
        high = None if self.upper is None else value * self.upper
        return (low, high) if value >= 0.0 else (high, low)

    def around_all(self, values: Any) -> tuple[Any, Any]:
        """Lower and upper ends round an array of values; an open end is infinite."""
        far = np.copysign(np.inf, values) if self.upper is None else values * self.upper
        ends = values * self.lower, far
        if np.min(values) >= 0.0:
            return ends
        return tuple(np.where(values >= 0.0, *pair) for pair in (ends, ends[::-1]))


def percent(share: float) -> str:
    """Write an error; below 0.001 % it is rounding.

    Examples
    --------
    >>> percent(0.018), percent(4.4e-16)
    ('1.8 %', 'below 0.001 %')
    """
    return f"{100.0 * share:.2g} %" if share >= LEAST_SAID else f"below {100.0 * LEAST_SAID:g} %"


def equation_error(response: ResponseModel) -> float:
    """Relative error of an equation for its band."""
    if response.band_error is not None:
        return response.band_error
    return max(response.largest_error, response.largest_heldout_error or 0.0)


def error_band(response: ResponseModel) -> ErrorBand:
    """Find the band of a response."""
    m = equation_error(response)
    f = response.largest_fe_error or 0.0
    lower = (1.0 if response.too_small else max(0.0, 1.0 - f)) / (1.0 + m)
    upper = (1.0 + f) / (1.0 - m) if m < 1.0 else math.inf
    elements = (
        "the error of the finite elements was not estimated"
        if response.largest_fe_error is None
        else f"the finite elements' own estimate is {percent(f)}"
        + (", by which they are too small" if response.too_small else " either way")
    )
    text = f"{_told(response)}; {elements}"
    return ErrorBand(lower, upper if upper < _OPEN else None, text)


def _told(response: ResponseModel) -> str:
    """State on which designs the equation's error is based."""
    error, held_out = equation_error(response), response.largest_heldout_error
    if response.band_error is not None:
        held = f"{response.heldout_runs} held-out designs" if response.heldout_runs else ""
        left_out = response.band_designs > response.heldout_runs
        runs = f"{response.runs} runs, each left out of the fit in turn" if left_out else ""
        designs = ", and ".join(filter(None, (runs, held)))
        of = (
            f"{100.0 * COVERAGE:g} % of new throws"
            if response.band_designs >= FEWEST
            else f"designs not seen, too few for {100.0 * COVERAGE:g} % of new throws,"
        )
        return f"{of} are predicted within {percent(error)}, by {designs}"
    designs = f"{response.heldout_runs} held-out designs"
    if held_out is None:
        designs = f"the {response.runs} fitted runs themselves, without held-out designs too small an error"
    elif held_out < error:
        designs = f"the {response.runs} fitted runs, {100.0 * held_out:.2g} % at {designs}"
    return f"largest error {100.0 * error:.2g} % at {designs}"
