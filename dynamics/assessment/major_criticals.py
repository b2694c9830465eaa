"""Major critical speeds near the rated speed, which one class forbids."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from dynamics.assessment.limits import checked_rated_speed
from dynamics.critical import CriticalSpeed
from dynamics.running_limits import within

MAJOR_SOURCE = "Korean Register, Rules for Steel Ships 2025, Part 5, Chapter 4, 204"
MAJOR_READING = "from the 2025 edition alone; no second source confirms it"
# Shares of the rated speed between which no major critical speed may lie, by what is driven.
CLEAR = {"propeller": (0.8, 1.1), "generator": (0.9, 1.1)}


@summarized("orders", "clear [rad/s]", "found", "passed")
@dataclass(frozen=True)
class MajorCriticals:
    """Critical speeds of the orders that one class calls major, and the speeds they must avoid.

    Attributes
    ----------
    orders : tuple of float
    clear : tuple of two floats
        Speeds between which none may be [rad/s].
    found : tuple of CriticalSpeed
        Those within the range.
    """

    orders: tuple[float, ...]
    clear: tuple[float, float]
    found: tuple[CriticalSpeed, ...]

    @property
    def passed(self) -> bool:
        """Whether none is within the range."""
        return not self.found


def major_criticals(
    criticals: Sequence[CriticalSpeed],
    rated_speed: float,
    *,
    cylinders: int,
    strokes: int,
    drives: str = "propeller",
) -> MajorCriticals:
    """Find the major critical speeds that are too near to the rated speed.

    Parameters
    ----------
    criticals : sequence of CriticalSpeed
        Torsional, at least those up to 1.1 of the rated speed.
    rated_speed : float
        [rad/s].
    cylinders, strokes : int
        Of an engine in line.
    drives : {"propeller", "generator"}

    Raises
    ------
    InputError
        If the speed is not above zero.

    Notes
    -----
    With n cylinders in line the major orders are n / 2 and n of four-stroke engines and n of two-stroke
    engines. None of their critical speeds may be between 0.8 and 1.1 of the rated speed, 0.9 and 1.1 for
    generating sets (`MAJOR_SOURCE`).
    """
    rated = checked_rated_speed(rated_speed)
    share = CLEAR[drives]
    clear = (share[0] * rated, share[1] * rated)
    orders = (0.5 * cylinders, float(cylinders)) if strokes == 4 else (float(cylinders),)
    majors: FloatArray = np.array(orders)
    found = tuple(
        one
        for one in criticals
        if np.any(np.isclose(one.order, majors)) and within(one.speed, *clear)
    )
    return MajorCriticals(orders, clear, found)
