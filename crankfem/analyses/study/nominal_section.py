"""Sections through the factors of a study: one factor moves, the others stay at the nominal throw."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.study.fitting import ResponseFits, nominal_points, predicted, surface
from regression.fits.fits import Fit
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


@dataclass(frozen=True, eq=False)
class FactorSweep:
    """Equations and designs along one factor, in SI units.

    Attributes
    ----------
    values : (p,) array
        Of the factor.
    curves : list of (p,) array
        Of the forms at these values, the other factors at the nominal throw.
    results : (n,) array
        Of the designs; those elsewhere are moved to this line along the chosen equation: they keep
        their distance to it.
    on_line : (n,) array of bool
        Which designs lie on this line themselves.
    """

    values: Array
    curves: list[Array]
    results: Array
    on_line: NDArray[np.bool_]


def factor_sweep(
    table: StudyTable, found: ResponseFits, place: int, forms: Sequence[Fit], values: Array
) -> FactorSweep:
    """Return forms at (p,) values of the factor at `place`, and the designs beside them."""
    section = nominal_section(table)
    points = moved(section, place, values)
    here = moved(section, place, table.values[:, place])
    off_curve = table.responses[found.column] / predicted(table, found, found.chosen)
    return FactorSweep(
        values=values,
        curves=[surface(table.plan, found, fit)(points) for fit in forms],
        results=surface(table.plan, found, found.chosen)(here) * off_curve,
        on_line=same_designs(table, here),
    )
