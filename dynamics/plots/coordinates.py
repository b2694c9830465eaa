"""Coordinates of grids: values, unit and name, for `crankbase.tables.frames.grid`."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray

Coordinate: TypeAlias = tuple[Any, str, str]


def orders_and_speeds(orders: FloatArray, speeds: FloatArray) -> dict[str, Coordinate]:
    """Return the coordinates "order" and "speed"."""
    return {
        "order": (orders, "1", "order, in cycles per crankshaft revolution"),
        "speed": speed_axis(speeds),
    }


def speed_axis(speeds: FloatArray) -> Coordinate:
    """Return the coordinate of crankshaft speeds [rad/s]."""
    return speeds, "rad/s", "crankshaft speed"


def angle_axis(angles: FloatArray) -> Coordinate:
    """Return the coordinate of shaft angles [deg]."""
    return angles, "deg", "shaft angle"


def time_axis(time: FloatArray) -> Coordinate:
    """Return the coordinate of the time [s]."""
    return time, "s", "time"


def name_axis(names: Sequence[str], words: str) -> Coordinate:
    """Return a coordinate of names."""
    return np.array(list(names), dtype=str), "", words


def number_axis(count: int, words: str) -> Coordinate:
    """Return a coordinate of numbers from 1."""
    return np.arange(1, count + 1), "1", words


def infinite_where_unbounded(values: ComplexArray, unbounded: NDArray[np.bool_]) -> ComplexArray:
    """Return phasors (K, S, ...), infinite where the response is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, complex(np.inf), values)
