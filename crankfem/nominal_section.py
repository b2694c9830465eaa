"""Sections through the factors of a study: one factor moves, the others stay at the nominal throw."""

import numpy as np
from numpy.typing import NDArray

from crankfem.fitting import nominal_points
from regression.runs.study_table import StudyTable

Array = NDArray[np.float64]

# Of a factor's range: designs nearer to each other are the same.
SAME = 1e-6


def nominal_section(table: StudyTable) -> Array:
    """Return the (k,) values of the factors at the nominal throw, or at the levels next to it."""
    return np.array(
        [
            min(factor.levels, key=lambda level: abs(level - nominal))
            if factor.levels is not None
            else nominal
            for factor, nominal in zip(table.plan.factors, nominal_points(table.plan), strict=True)
        ]
    )


def moved(section: Array, place: int, values: Array) -> Array:
    """Return (n, k) points of a section in which the factor at `place` has (n,) other values."""
    points = np.tile(section, (len(values), 1))
    points[:, place] = values
    return points


def same_designs(table: StudyTable, points: Array) -> NDArray[np.bool_]:
    """Tell which designs of a table (n, k) are the points (n, k) beside them."""
    spans = np.array([factor.highest - factor.lowest for factor in table.plan.factors])
    return np.asarray(np.all(np.abs(table.values - points) <= SAME * spans, axis=1))
