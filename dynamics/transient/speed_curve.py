"""The speed of a shaft over time, and its angle."""

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import (
    FloatArray,
    finite_array,
    finite_vector,
    positive_number,
    positive_vector,
    read_only,
)
from crankbase.checks.scalars import whole_number
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from crankbase.units.units import RPM
from dynamics.plots.angle_curves import draw_over_time
from dynamics.plots.quantities import SPEED_LABEL
from dynamics.response.order_excitation import check_ascending

# [share] By which an angle may miss the ends of a curve.
ROUND_OFF = 1e-14


@summarized("times [s]", "speeds [rad/s]", "duration [s]")
@dataclass(frozen=True, eq=False)
class SpeedCurve:
    """The speed over time, linear between the values given; the angle is its integral.

    Parameters
    ----------
    times : array_like of shape (m,)
        Ascending, two or more [s].
    speeds : array_like of shape (m,)
        Above zero [rad/s].
    start_angle_deg : float, optional
        Shaft angle at the first time [deg].

    Raises
    ------
    InputError
        If times do not ascend, a speed is not above zero, or lengths differ.

    Examples
    --------
    >>> curve = SpeedCurve.ramp(50.0, 150.0, acceleration=20.0)
    >>> curve.duration, float(curve.angle_deg(curve.duration).round())
    (5.0, 28648.0)
    """

    times: FloatArray
    speeds: FloatArray
    _: KW_ONLY
    start_angle_deg: float = 0.0

    def __post_init__(self) -> None:
        times = finite_vector("times", self.times)
        speeds = positive_vector("speeds", self.speeds, "rad/s", "the shaft turns forward")
        if times.size < 2 or times.size != speeds.size:
            raise InputError(
                f"times: given {times.size} for {speeds.size} speeds; allowed are two or more, one for "
                "each speed, because the curve runs from point to point."
            )
        check_ascending("times", times, " s", "time does not run back")
        object.__setattr__(self, "times", read_only(times))
        object.__setattr__(self, "speeds", read_only(speeds))
        object.__setattr__(
            self, "start_angle_deg", float(finite_array("start_angle_deg", self.start_angle_deg))
        )

    @classmethod
    def constant(
        cls, speed: float, duration: float, *, start_angle_deg: float = 0.0
    ) -> "SpeedCurve":
        """Return a constant speed [rad/s] over a time [s]."""
        end = positive_number("duration", duration, "s", "time runs forward")
        return cls(np.array([0.0, end]), np.array([speed, speed]), start_angle_deg=start_angle_deg)

    @classmethod
    def ramp(
        cls,
        start_speed: float,
        end_speed: float,
        *,
        acceleration: float | None = None,
        duration: float | None = None,
        start_angle_deg: float = 0.0,
    ) -> "SpeedCurve":
        """Return a uniform run-up, or run-down, from time zero.

        Parameters
        ----------
        start_speed, end_speed : float
            [rad/s]
        acceleration : float, optional
            Its magnitude, for either direction [rad/s^2].
        duration : float, optional
            Alternatively, duration [s].
        start_angle_deg : float, optional
            [deg]

        Raises
        ------
        InputError
            If a number is not above zero, the speeds are equal, or not exactly one of acceleration
            and duration is given.
        """
        start = positive_number("start_speed", start_speed, "rad/s", "the shaft turns forward")
        end = positive_number("end_speed", end_speed, "rad/s", "the shaft turns forward")
        if (acceleration is None) == (duration is None):
            raise InputError(
                f"acceleration: given {acceleration} with a duration of {duration}; allowed is one of "
                "both, because each follows from the other."
            )
        if start == end:
            raise InputError(
                f"end_speed: given {end:g} rad/s, that of the start; allowed is another, because a "
                "ramp changes the speed."
            )
        if acceleration is not None:
            rate = positive_number("acceleration", acceleration, "rad/s^2", "it is a size")
            time = abs(end - start) / rate
        else:
            assert duration is not None
            time = positive_number("duration", duration, "s", "time runs forward")
        return cls(np.array([0.0, time]), np.array([start, end]), start_angle_deg=start_angle_deg)

    @classmethod
    def sampled(
        cls,
        speed: Callable[[float], float],
        duration: float,
        *,
        samples: int = 1001,
        start_angle_deg: float = 0.0,
    ) -> "SpeedCurve":
        """Return the linear pieces through a function time [s] -> speed [rad/s] from time zero."""
        end = positive_number("duration", duration, "s", "time runs forward")
        count = whole_number("samples", samples, 2, "start and end are among them")
        times = np.linspace(0.0, end, count)
        return cls(
            times,
            np.array([speed(time) for time in times.tolist()]),
            start_angle_deg=start_angle_deg,
        )

    @property
    def duration(self) -> float:
        """From first to last time [s]."""
        return float(self.times[-1] - self.times[0])

    def speed(self, time: ArrayLike) -> FloatArray:
        """Return the speed at times [s] within the curve [rad/s].

        Raises
        ------
        InputError
            If a time is outside.
        """
        return np.asarray(np.interp(self._checked(time), self.times, self.speeds))

    def angle_deg(self, time: ArrayLike) -> FloatArray:
        """Return the shaft angle at times [s] within the curve [deg].

        Raises
        ------
        InputError
            If a time is outside.
        """
        times = self._checked(time)
        piece = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, self.times.size - 2)
        since = times - self.times[piece]
        rates = np.diff(self.speeds) / np.diff(self.times)
        return np.degrees(
            self._angles[piece] + since * (self.speeds[piece] + 0.5 * rates[piece] * since)
        )

    def time_at(self, *, angle_deg: ArrayLike) -> FloatArray:
        """Return the times at which the shaft passes angles [deg], such as firing angles.

        Raises
        ------
        InputError
            If an angle is not passed.
        """
        angles = radians_of("angle_deg", angle_deg)
        known = self._angles
        # The ends as `angle_deg` gives them differ from these by round-off.
        room = ROUND_OFF * max(abs(known[0]), abs(known[-1]))
        if np.any((angles < known[0] - room) | (angles > known[-1] + room)):
            raise InputError(
                f"angle_deg: given {np.min(angle_deg):g} to {np.max(angle_deg):g}; allowed are "
                f"{math.degrees(known[0]):g} to {math.degrees(known[-1]):g}, because the shaft passes those."
            )
        piece = np.clip(np.searchsorted(known, angles, "right") - 1, 0, known.size - 2)
        rate = (np.diff(self.speeds) / np.diff(self.times))[piece]
        start, past = self.speeds[piece], np.clip(angles, known[0], known[-1]) - known[piece]
        # Smaller root of rate t^2 / 2 + start t = past, in the form that holds for rate 0.
        root = np.sqrt(np.maximum(start**2 + 2.0 * rate * past, 0.0))
        return np.asarray(self.times[piece] + 2.0 * past / (start + root))

    @property
    def _angles(self) -> FloatArray:
        """Shaft angle at the times given [rad], (m,)."""
        means = 0.5 * (self.speeds[1:] + self.speeds[:-1])
        return math.radians(self.start_angle_deg) + np.concatenate(
            ([0.0], np.cumsum(means * np.diff(self.times)))
        )

    def _checked(self, time: ArrayLike) -> FloatArray:
        times = finite_array("time", time)
        room = 1e-12 * self.duration
        if np.any((times < self.times[0] - room) | (times > self.times[-1] + room)):
            raise InputError(
                f"time: given {float(np.min(times)):g} to {float(np.max(times)):g} s; allowed are "
                f"{self.times[0]:g} to {self.times[-1]:g} s, because the speed is known there."
            )
        return times

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the time.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes, height=3.4)
        draw_over_time(axes, self.times, {"speed": RPM * self.speeds}, SPEED_LABEL)
        write_title(axes, "Speed over time")
        return axes
