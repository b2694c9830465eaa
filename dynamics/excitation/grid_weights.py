"""Weights of a grid's values between them: along one axis, by splines or linear."""

from typing import Literal

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from dynamics.excitation.engine_load import per_minute

Method = Literal["cubic", "linear"]
# Speeds or loads of two points are one within this share.
SAME = 1e-9


def sorted_unique(values: list[float]) -> FloatArray:
    """Return values sorted in ascending order, each once."""
    ordered = np.unique(np.array(values))
    apart = np.diff(ordered, prepend=-np.inf) > SAME * np.abs(ordered)
    return np.asarray(ordered[apart])


def nearest_index(values: FloatArray, value: float) -> int:
    """Return the index of the nearest value."""
    return int(np.argmin(np.abs(values - value)))


def axis_weights(field: str, grid: FloatArray, asked: FloatArray, method: Method) -> FloatArray:
    """Return the weight of each grid value at the requested points (S, a)."""
    room = SAME * np.abs(grid[[0, -1]])
    outside = np.flatnonzero((asked < grid[0] - room[0]) | (asked > grid[-1] + room[1]))
    if outside.size:
        shown = per_minute if field == "speed" else "{:g}".format
        low, high = shown(float(grid[0])), shown(float(grid[-1]))
        allowed = low if grid.size == 1 else f"{low} to {high}"
        raise InputError(
            f"{field}: given {shown(float(asked[outside[0]]))}; allowed is {allowed}, because the pressure "
            "map has no diagrams beyond and is not extended."
        )
    within = np.clip(asked, grid[0], grid[-1])  # by round-off only
    unit = np.eye(grid.size)
    if grid.size == 1:
        return np.ones((asked.size, 1))
    if method == "linear":
        return np.array([np.interp(within, grid, own) for own in unit]).T
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    # Through three points a parabola, through two a straight line.
    return np.asarray(CubicSpline(grid, unit)(within), dtype=np.float64)
