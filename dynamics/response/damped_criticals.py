"""Critical speeds with damping: where an order alone makes a quantity largest, and the mode responsible."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray, checked_range
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from crankbase.units.units import RPM
from dynamics.response.complex_modes import ComplexModes, complex_modes
from dynamics.response.forced import ForcedResponse
from dynamics.response.harmonic import harmonic_response
from dynamics.response.over_speed import OverSpeed
from dynamics.response.place_rows import load_rows, motion_row
from dynamics.response.speed_grid import refined_speeds
from dynamics.running_limits import within

# Maxima below this share of the largest one are round-off of orders that nothing excites.
LEAST_SHARE = 1e-9
# Share of a mode's largest magnifier down to which a peak is that of the mode: 1.7 half bandwidths.
BAND = 0.5
# Steps of the golden section: a bracket becomes a millionth of what it was.
SECTION, STEPS = 0.5 * (np.sqrt(5.0) - 1.0), 29


@summarized(
    *("order", "mode", "has_peak", "speed_rpm [1/min]", "amplitude", "place", "damping_ratio"),
    "undamped_speed [rad/s]",
)
@dataclass(frozen=True)
class DampedCritical:
    """The speed at which one order alone makes a quantity largest, and the mode responsible.

    Parameters
    ----------
    order : float
        In cycles per crankshaft revolution.
    mode : int
        Number of the elastic mode with the largest part of the amplitude there, 1 the lowest; 0 for
        an overdamped motion.
    speed : float
        Speed of the maximum amplitude [rad/s]; NaN if there is none near this mode's
        frequencies: too much damping, or forces that cancel on the mode.
    amplitude : float
        Of this order there, all modes together; inf where undamped, NaN without a maximum.
    place : str
        Its element or node; empty without a maximum.
    mode_share : float
        Part of the amplitude from this mode; others may counteract it.
    in_band : bool
        Whether the mode's magnifier at the peak is half of its largest or more. If not, the
        exciting forces have a peak, as axial ones have where torsional vibration is large.
    mode_frequency : float
        Damped natural frequency of the mode [Hz]; NaN for an overdamped one.
    damping_ratio : float
        Share of critical damping of the mode; NaN for an overdamped one.
    undamped_speed : float
        Speed at which the order meets the undamped frequency, the ring of a viscous damper free [rad/s].
    locked_speed : float
        The same with that ring locked to its housing [rad/s]; NaN without one.
    severity : float
        Amplitude over the largest bounded one of all; 1 for an unbounded one, 0 without a maximum.
    kind : {"major", "minor"}
        Whether all cylinders act in phase at this order, if known.
    in_running_range : bool
        Whether the engine runs at that speed, if known; limits may apply at higher speeds too.
    """

    order: float
    mode: int
    speed: float
    amplitude: float
    place: str
    mode_share: float
    in_band: bool
    mode_frequency: float
    damping_ratio: float
    undamped_speed: float
    locked_speed: float
    severity: float
    kind: Literal["major", "minor"] = "minor"
    in_running_range: bool = True

    @property
    def unbounded(self) -> bool:
        """Whether it is undamped."""
        return bool(np.isinf(self.amplitude))

    @property
    def has_peak(self) -> bool:
        """Whether the order has a maximum there."""
        return not np.isnan(self.speed)

    @property
    def frequency(self) -> float:
        """Frequency of the order at the peak [Hz]; that of the mode without a peak."""
        peak = self.order * self.speed / (2.0 * np.pi)
        return peak if self.has_peak else self.mode_frequency

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""
        return self.speed * RPM

    @property
    def sentence(self) -> str:
        """Position of the peak relative to the speeds without damping."""
        if not self.mode:
            return f"Order {self.order:g}: peak at {self.speed_rpm:.4g} 1/min, of no mode's own."
        beside = f"{self.undamped_speed * RPM:.4g} 1/min undamped"
        if not np.isnan(self.locked_speed):
            beside = (
                f"{self.undamped_speed * RPM:.4g} 1/min with the damper's ring free, "
                f"{self.locked_speed * RPM:.4g} 1/min with it locked"
            )
        found = f"peak at {self.speed_rpm:.4g} 1/min" if self.has_peak else "no peak"
        if self.has_peak and not self.in_band:
            found += ", where its forces are largest"
        return f"Order {self.order:g}, mode {self.mode}: {found} ({beside})."

    def row(self) -> Row:
        """Return the columns of a table of critical speeds, each value with its unit; see `table_of`."""
        return {
            "order": (self.order, "1"),
            "mode": (self.mode, "1"),
            "speed": (self.speed, "rad/s"),
            "amplitude": (self.amplitude, "SI"),
            "place": (self.place, ""),
            "mode_share": (self.mode_share, "1"),
            "in_band": (self.in_band, ""),
            "mode_frequency": (self.mode_frequency, "Hz"),
            "damping_ratio": (self.damping_ratio, "1"),
            "undamped_speed": (self.undamped_speed, "rad/s"),
            "locked_speed": (self.locked_speed, "rad/s"),
            "severity": (self.severity, "1"),
            "kind": (self.kind, ""),
            "in_running_range": (self.in_running_range, ""),
        }


def damped_criticals(
    response: ForcedResponse,
    *,
    elements: Sequence[int | str] | None = None,
    node: int | str | None = None,
    speed_range: tuple[float, float] | None = None,
    modes: ComplexModes | None = None,
) -> tuple[DampedCritical, ...]:
    """Find the critical speeds of a damped chain: the peaks of each order alone.

    Parameters
    ----------
    response : ForcedResponse
        Its system and excitation are used; forces between its speeds are interpolated.
    elements : sequence of int or str, optional
        Elements whose load k d [N m or N] is considered, at each speed that with the largest load; all
        elements by default.
    node : int or str, optional
        Node whose elastic motion is considered instead of loads [rad or m].
    speed_range : tuple of two floats, optional
        Within the speeds of the response; by default all of them [rad/s].
    modes : ComplexModes, optional
        Of the system, if known.

    Returns
    -------
    tuple of DampedCritical
        In ascending order, mode and speed. One order may have several peaks with one mode, as where forces
        grow with the speed next to a resonance: each is listed. For a mode that an order meets within
        the range, with ring free, ring locked or damped, there is an entry without a speed if the order
        has no maximum near it.

    Raises
    ------
    InputError
        If elements and node are both given, one does not exist, the range is reversed or exceeds
        the speeds of the response, or elements are requested of a system that is not a chain.

    Notes
    -----
    Each order is calculated at the speeds of the response and about each damped frequency, an eighth
    of its half bandwidth apart. Between the neighbors of each maximum a golden section finds the
    speed to a millionth of their distance. The peak belongs to the mode that gives the largest part
    of the amplitude in phase with it (`ComplexModes.contributions`). It counts as that mode's own if it
    is `in_band`.
    """
    if node is not None and elements is not None:
        raise InputError(
            f"node: given {node!r} together with elements; allowed is one of both, because peaks are those "
            "of loads or of a motion."
        )
    rows, names = load_rows(response, elements) if node is None else motion_row(response, node)
    modes = complex_modes(response) if modes is None else modes
    ends = _checked_ends(response, speed_range)
    forces = OverSpeed.of(response.speeds, response.excitation.forces)
    peaks = _Vibration(response, modes, rows, forces).peaks()
    largest = max((own.amplitude for own in peaks if np.isfinite(own.amplitude)), default=0.0)
    kept = [own for own in peaks if own.amplitude > LEAST_SHARE * largest]
    bounded = (own.amplitude for own in kept if within(own.speed, *ends))
    worst = max((size for size in bounded if np.isfinite(size)), default=0.0)
    met = {(own.order, own.number) for own in kept if own.in_band}
    found = [
        _critical(modes, own.order, own.number, names, own, worst)
        for own in kept
        if within(own.speed, *ends)
    ]
    for order in response.orders.tolist():
        for number in range(1, modes.undamped.size + 1):
            if (order, number) not in met and _meets(modes, order, number, ends):
                found.append(_critical(modes, order, number, names))
    return tuple(sorted(found, key=lambda own: (own.order, own.mode, own.speed)))


class _Peak(NamedTuple):
    """A maximum of an order: speed, amplitude, row of the place; number and share of its mode."""

    order: float
    speed: float
    amplitude: float
    row: int
    number: int
    share: float
    in_band: bool


def _checked_ends(
    response: ForcedResponse, speed_range: tuple[float, float] | None
) -> tuple[float, float]:
    low, high = float(response.speeds[0]), float(response.speeds[-1])
    if low == high:
        raise InputError(
            "response: given one at one speed; allowed is one at two speeds or more, because peaks are "
            "looked for between them."
        )
    if speed_range is None:
        return low, high
    first, last = checked_range("speed_range", speed_range, "rad/s", "peaks are looked for in it")
    if not (within(first, low, high) and within(last, low, high)):
        raise InputError(
            f"speed_range: given {first:g} to {last:g} rad/s; allowed is within {low:g} to {high:g} rad/s, "
            "because the response is known there."
        )
    return first, last


@dataclass(frozen=True, eq=False)
class _Vibration:
    """A response evaluated at pairs of order and speed: the row with the largest value counts."""

    response: ForcedResponse
    modes: ComplexModes
    rows: FloatArray
    forces: OverSpeed

    def answer(
        self, places: NDArray[np.intp], speeds: FloatArray
    ) -> tuple[ComplexArray, NDArray[np.bool_], ComplexArray]:
        """Return values of the rows (m, p), where unbounded (m,), and forces on the unknowns (m, q)."""
        system = self.response.system
        forces = self.forces.at(places, speeds) @ system.expand
        answer = harmonic_response(system, self.response.orders[places] * speeds, forces)
        return answer.motion @ self.rows.T, answer.unbounded, forces

    def amplitudes(self, places: NDArray[np.intp], speeds: FloatArray) -> FloatArray:
        """Return the largest amplitude of any row, (m,)."""
        if not speeds.size:
            return np.empty(0)
        values, unbounded, _ = self.answer(places, speeds)
        return np.where(unbounded, np.inf, np.max(np.abs(values), axis=1))

    def brackets(self, place: int) -> FloatArray:
        """Return the speeds below and above each maximum of an order, (m, 2)."""
        order, known = float(self.response.orders[place]), self.response.speeds
        ends = (float(known[0]), float(known[-1]))
        about = refined_speeds(self.modes.frequencies, self.modes.damping_ratios, [order], ends)
        added = np.setdiff1d(about, known)
        grid = np.concatenate((known, added))
        values = np.max(np.abs(self.response.unknowns[place] @ self.rows.T), axis=1)
        values = np.where(self.response.unbounded[place], np.inf, values)
        found = np.append(values, self.amplitudes(np.full(added.size, place), added))
        ascending = np.argsort(grid)
        grid, found = grid[ascending], found[ascending]
        tops = 1 + np.flatnonzero((found[1:-1] > found[:-2]) & (found[1:-1] >= found[2:]))
        beside = np.isfinite(found[tops]).astype(np.intp)  # an unbounded one is where it is
        return np.column_stack((grid[tops - beside], grid[tops + beside]))

    def peaks(self) -> list[_Peak]:
        """Return all local maxima of all orders."""
        brackets = [self.brackets(place) for place in range(self.response.orders.size)]
        places = np.repeat(np.arange(len(brackets)), [len(own) for own in brackets])
        if not places.size:
            return []
        low, high = np.concatenate(brackets).T
        speeds = _golden_section(lambda some: self.amplitudes(places, some), low, high)
        values, unbounded, forces = self.answer(places, speeds)
        best = np.argmax(np.abs(values), axis=1)
        value = values[np.arange(speeds.size), best]
        orders = self.response.orders[places]
        parts = self.modes.contributions(orders * speeds, forces, self.rows[best])
        size = np.where(value == 0.0, 1.0, np.abs(value))[:, np.newaxis]
        shares = (parts / size * np.conj(value[:, np.newaxis] / size)).real
        # Where nothing bounds the amplitude, the mode at its own frequency makes it.
        own = np.append(self.modes.eigenvalues.imag, np.inf)
        apart = np.abs(own - (orders * speeds)[:, np.newaxis])
        alone = (apart == np.min(apart, axis=1, keepdims=True)).astype(np.float64)
        shares = np.where(unbounded[:, np.newaxis], alone, shares)
        most = np.argmax(shares, axis=1)
        numbers = np.append(self.modes.numbers, 0)
        reached = self.modes.magnifiers(orders * speeds) >= BAND * self.modes.largest_magnifiers
        in_band = np.column_stack((reached, np.zeros(speeds.size, dtype=bool)))
        return [
            _Peak(
                float(orders[row]),
                float(speeds[row]),
                float("inf") if unbounded[row] else float(np.abs(value[row])),
                int(best[row]),
                int(numbers[most[row]]),
                float(shares[row, most[row]]),
                bool(in_band[row, most[row]] or unbounded[row]),
            )
            for row in range(speeds.size)
        ]


def _golden_section(
    at: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the maximum of a function within brackets (m,), each with one maximum."""
    for _ in range(STEPS):
        span = SECTION * (high - low)
        left, right = at(high - span), at(low + span)
        falling = left > right
        low, high = np.where(falling, low, high - span), np.where(falling, low + span, high)
    return np.asarray(0.5 * (low + high))


def _meets(modes: ComplexModes, order: float, number: int, ends: tuple[float, float]) -> bool:
    """Whether an order meets a mode within a range, undamped, locked or damped."""
    own = modes.frequencies[modes.numbers == number].tolist()
    known = [float(modes.undamped[number - 1]), *own]
    if modes.locked is not None:
        known.append(float(modes.locked[number - 1]))
    return any(within(2.0 * np.pi * frequency / order, *ends) for frequency in known)


def _critical(
    modes: ComplexModes,
    order: float,
    number: int,
    names: tuple[str, ...],
    peak: _Peak | None = None,
    worst: float = 0.0,
) -> DampedCritical:
    """Describe a peak, or state that a mode has none, with the frequencies of the mode."""
    none = float("nan")
    peak = peak or _Peak(order, none, none, -1, number, none, in_band=False)
    places = np.flatnonzero(modes.numbers == number)

    def met(frequencies: FloatArray | None) -> float:
        if frequencies is None or not number:
            return none
        return 2.0 * np.pi * float(frequencies[number - 1]) / order

    return DampedCritical(
        order=order,
        mode=number,
        speed=peak.speed,
        amplitude=peak.amplitude,
        place="" if peak.row < 0 else names[peak.row],
        mode_share=peak.share,
        in_band=peak.in_band,
        mode_frequency=float(modes.frequencies[places[0]]) if places.size else none,
        damping_ratio=float(modes.damping_ratios[places[0]]) if places.size else none,
        undamped_speed=met(modes.undamped),
        locked_speed=met(modes.locked),
        severity=_severity(peak.amplitude, worst),
    )


def _severity(amplitude: float, worst: float) -> float:
    if np.isnan(amplitude):
        return 0.0
    return min(amplitude / worst, 1.0) if worst > 0.0 else 1.0
