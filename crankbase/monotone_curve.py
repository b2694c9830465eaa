"""Curves through samples that exceed no neighbor, as `scipy.interpolate` has them, without its loading."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crankbase.array_checks import Array


@dataclass(frozen=True)
class MonotoneCurve:
    """Piecewise cubic through samples: bit for bit scipy's PchipInterpolator.

    Attributes
    ----------
    places, values : (n,) arrays
        Ascending; n is at least 2.

    Notes
    -----
    Slopes after F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304; those at the ends
    after C. Moler, Numerical Computing with MATLAB, section 3.6.
    """

    places: Array
    values: Array

    def slopes(self) -> Array:
        """Slopes (n,) of the curve at the samples."""
        steps = np.diff(self.places)
        rises = np.diff(self.values) / steps
        if len(rises) == 1:
            return np.repeat(rises, 2)
        before, after = rises[:-1], rises[1:]
        near = 2.0 * steps[1:] + steps[:-1]
        far = steps[1:] + 2.0 * steps[:-1]
        turns = (np.sign(before) != np.sign(after)) | (before == 0.0) | (after == 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            inner = np.where(turns, 0.0, 1.0 / ((near / before + far / after) / (near + far)))
        ends = (_end_slope(*steps[:2], *rises[:2]), _end_slope(*steps[:-3:-1], *rises[:-3:-1]))
        return np.array([ends[0], *inner, ends[1]])

    @cached_property
    def coefficients(self) -> Array:
        """Coefficients (4, n - 1) of each piece, by powers of the distance from its first sample."""
        steps, slopes = np.diff(self.places), self.slopes()
        rises = np.diff(self.values) / steps
        bends = (slopes[:-1] + slopes[1:] - 2.0 * rises) / steps
        square = (rises - slopes[:-1]) / steps - bends
        return np.array([self.values[:-1], slopes[:-1], square, bends / steps])

    def __call__(self, places: Array) -> Array:
        """Return values at places of any shape within those of the samples."""
        piece = np.searchsorted(self.places, places, "right") - 1
        piece = np.clip(piece, 0, len(self.places) - 2)
        constant, linear, square, cubic = self.coefficients[:, piece]
        beyond = places - self.places[piece]
        total = constant + linear * beyond + square * (beyond * beyond)
        return np.asarray(total + cubic * (beyond * beyond * beyond))


def _end_slope(step: float, next_step: float, rise: float, next_rise: float) -> float:
    slope = ((2.0 * step + next_step) * rise - step * next_rise) / (step + next_step)
    if np.sign(slope) != np.sign(rise):
        return 0.0
    turns = np.sign(rise) != np.sign(next_rise)
    return 3.0 * rise if turns and abs(slope) > 3.0 * abs(rise) else slope
