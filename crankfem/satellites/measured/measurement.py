"""A measurement: a wheel's teeth, perhaps another signal beside them, and its orders over the speed."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, positive_number
from crankbase.choices import allowed_names, check_choice
from crankbase.errors import InputError, quoted
from crankbase.results import result
from crankbase.sentences import amount, finished
from crankfem.analyses.shaft.chains import engine_axial_chain, engine_torsional_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.satellites.measured.measured_orders import (
    MEASURANDS,
    OF_WHEEL,
    Measurand,
    MeasuredOrders,
)
from crankfem.satellites.measured.order_fits import (
    CONSTANT,
    LINEAR,
    SEPARATION,
    TURN,
    OrderFit,
    Samples,
    fit_along,
    fit_windows,
    spacing,
    unbroken_windows,
)
from crankfem.satellites.measured.pulses import Edge, pulse_times
from crankfem.satellites.measured.records.reading import read_record
from crankfem.satellites.measured.records.record import Channel, Record
from crankfem.satellites.measured.wheel import Teeth, Wheel, number_teeth
from dynamics.response.order_excitation import checked_orders

Method = Literal["auto", "steady", "linear", "along"]
# Orders up to this one are in the fit at least, whichever are asked for, and these of the wheel's at most.
USUAL_ORDER, OF_HIGHEST = 12.0, 0.8
# A speed is steady that changes by less than this share over so many revolutions at least.
STEADY, LEAST_DWELL = 0.005, 40
# Windows of a steady speed from which on their scatter is known from themselves.
KNOWN_SCATTER = 4
# Longest record that is fitted as a whole [revolutions].
LONGEST_WHOLE = 4000.0
# Orders along a record are asked for every so many revolutions, at so many speeds at most; not at its ends.
EVERY, MOST_SPEEDS, OFF_ENDS = 3.0, 400, 8.0
# An order that is not fitted is there with this share of the largest amplitude.
REMAINS = 0.02
# Samples of a signal to a cycle of its highest order; more are averaged.
SAMPLES_OF_ORDER = 24.0


@result("teeth", "place", "quantity")
class Measurement:
    """A record of a toothed wheel, and perhaps of another signal over the same time.

    Attributes
    ----------
    teeth : Teeth
        The pulses with the tooth of each.
    signal : tuple of two ndarray or None
        Times [s] and values in SI of another channel; the motion of the wheel is measured without.
    quantity : str
        As that of `MeasuredOrders`.
    place : str
        Mass or element of the chain where it was measured.
    cycle : {1, 2}
        Revolutions per working cycle.
    mark_angle : float or None
        Shaft angle of the engine file when the first tooth behind the mark passes [rad].
    notes : tuple of str
    """

    teeth: Teeth
    signal: tuple[Array, Array] | None
    quantity: Measurand
    place: str
    cycle: int
    mark_angle: float | None
    notes: tuple[str, ...]

    def speed(self) -> tuple[Array, Array]:
        """Return the middle of each revolution [s] and the mean speed in it [rad/s]."""
        pitches = self.teeth.wheel.pitches
        turns = self.teeth.number / pitches
        ends = np.interp(np.arange(np.ceil(turns[0]), turns[-1]), turns, self.teeth.time)
        return 0.5 * (ends[1:] + ends[:-1]), TURN / np.diff(ends)

    def orders(
        self,
        orders: ArrayLike | None = None,
        *,
        method: Method = "auto",
        window: float = LINEAR,
    ) -> MeasuredOrders:
        """Find amplitude, phase and scatter of orders over the speed.

        Parameters
        ----------
        orders : array_like, optional
            Cycles per revolution; those of the working cycle up to 12 by default, which are in the fit
            anyway: an order that is there and not fitted spoils its neighbors.
        method : {"auto", "steady", "linear", "along"}, optional
            Constant amplitudes in windows of steady speeds; linear ones in windows; or smooth ones along the
            whole record. By the record itself, unless given.
        window : float, optional
            Length of windows [revolutions].

        Raises
        ------
        InputError
            If an order is too high for the wheel, or orders cannot be told apart.
        """
        check_choice("method", method, get_args(Method), "these are the ways to fit orders")
        usual, highest = self._of_cycle(USUAL_ORDER), self.teeth.wheel.highest_order
        wanted = checked_orders(usual[usual < OF_HIGHEST * highest] if orders is None else orders)
        if wanted[-1] >= highest and self.signal is None:
            raise InputError(
                f"orders: given {wanted[-1]:g}; allowed are those below {highest:g}, because the wheel "
                f"{self.teeth.wheel} shows two teeth to each wave of that one."
            )
        top, notes = max(USUAL_ORDER, float(wanted[-1])), []
        fit, fitted, name = self._fit(wanted, top, method, window)
        remaining = self._remaining(fit, fitted)
        if remaining:
            try:
                fit, fitted, name = self._fit(wanted, remaining, method, window)
            except InputError:
                notes.append(
                    f"Order {remaining:g} remains in the record, and cannot be fitted too."
                )
        fit = self._mended(fit, fitted)
        chosen = np.searchsorted(fitted, wanted)
        turned = np.exp(-1j * wanted * (self.mark_angle or 0.0))
        wheel = self.signal is None
        constant = wheel & (wanted % 1.0 == 0.0)
        if wheel:
            notes.append(OF_WHEEL)
        return MeasuredOrders(
            wanted,
            fit.speed,
            fit.amplitude[:, chosen] * turned,
            fit.scatter[:, chosen],
            self.place,
            self.quantity,
            fit.correlation,
            fit.ramp,
            constant,
            self.cycle,
            self.mark_angle is not None,
            f"{name}, {fitted.size} orders fitted, condition {fit.condition:.2g}",
            (*self.notes, *self.teeth.notes, *notes),
        )

    def _of_cycle(self, top: float) -> Array:
        """Return the orders of the working cycle up to one."""
        return np.asarray(np.arange(1, round(top * self.cycle) + 1) / self.cycle)

    def _fit(
        self, wanted: Array, top: float, method: Method, window: float
    ) -> tuple[OrderFit, Array, str]:
        """Return the fit, its orders and the name of the method."""
        highest = self.teeth.wheel.highest_order
        usual = self._of_cycle(top)
        if self.signal is None:
            usual = usual[usual < max(OF_HIGHEST * highest, float(wanted[-1]))]
        fitted = np.union1d(usual, wanted)
        samples = self._samples(fitted)
        dwells = self.dwells()
        if method == "auto":
            steady = sum(end - begin for begin, end in dwells) > 0.5 * samples.revolutions * TURN
            short = samples.revolutions > LONGEST_WHOLE
            method = "steady" if steady else "linear" if short else "along"
        if method == "along":
            room = OFF_ENDS * TURN
            ends = float(samples.angle[0]) + room, float(samples.angle[-1]) - room
            if ends[1] <= ends[0]:
                raise InputError(
                    f"record: given {samples.revolutions:.3g} revolutions; allowed are more than "
                    f"{2 * OFF_ENDS:g}, because amplitudes are sure that far from its ends."
                )
            count = int(np.clip((ends[1] - ends[0]) / (EVERY * TURN), 1, MOST_SPEEDS))
            return (
                fit_along(samples, fitted, np.linspace(*ends, count)),
                fitted,
                "smooth amplitudes along the whole record",
            )
        length = TURN * max(window, SEPARATION / spacing(fitted))
        if method == "linear":
            begins = np.arange(samples.angle[0], samples.angle[-1] - length, 0.5 * length)
            if not begins.size:
                raise InputError(
                    f"record: given {samples.revolutions:.3g} revolutions; allowed are at least "
                    f"{length / TURN:g}, because one window takes so many."
                )
            ends_of = unbroken_windows(samples, begins, length)
            name = f"amplitudes linear in windows of {length / TURN:g} revolutions"
            return fit_windows(samples, fitted, ends_of, linear=True), fitted, name
        if not dwells:
            raise InputError(
                'method: given "steady"; allowed is a record with a steady speed, which changes by less than '
                f"{100 * STEADY:g} % over {LEAST_DWELL} revolutions."
            )
        rows = [_dwell(samples, fitted, dwell, length) for dwell in dwells]
        name = f"means over windows of {length / TURN:g} revolutions at steady speeds"
        mean = OrderFit(
            speed=np.concatenate([row.speed for row in rows]),
            ramp=np.concatenate([row.ramp for row in rows]),
            amplitude=np.concatenate([row.amplitude for row in rows]),
            scatter=np.concatenate([row.scatter for row in rows]),
            correlation=np.eye(len(rows)),
            condition=max(row.condition for row in rows),
            residual=float(np.mean([row.residual for row in rows])),
        )
        return mean, fitted, name

    def _samples(self, orders: Array) -> Samples:
        """Return what is fitted: the teeth, or the signal at the rigid angles."""
        teeth = self.teeth
        pitches = teeth.wheel.pitches
        turning = Samples(teeth.time, teeth.angle, teeth.angle, teeth.number % pitches, pitches)
        if self.signal is None:
            return turning
        usual = self._of_cycle(USUAL_ORDER)
        usual = usual[usual < OF_HIGHEST * teeth.wheel.highest_order]
        if turning.revolutions > LONGEST_WHOLE or not usual.size:
            rigid = np.interp(self.signal[0], turning.time, turning.angle)
        else:
            middle = 0.5 * (turning.angle[0] + turning.angle[-1])
            along = fit_along(turning, usual, np.array([middle])).rigid
            assert along is not None
            rigid = along(self.signal[0])
        time, value = self.signal
        merged = self._merged(orders)
        within = (time >= turning.time[0]) & (time <= turning.time[-1])
        parts = [array[within] for array in (time, rigid, value)]
        whole = parts[0].size // merged * merged
        return Samples(*(part[:whole].reshape(-1, merged).mean(axis=1) for part in parts))

    def _merged(self, orders: Array) -> int:
        """Return of how many samples of the signal the mean is taken."""
        assert self.signal is not None
        step = float(np.max(self.speed()[1]) * np.median(np.diff(self.signal[0])))
        return max(int(TURN / (SAMPLES_OF_ORDER * orders[-1] * step)), 1)

    def _mended(self, fit: OrderFit, orders: Array) -> OrderFit:
        """Return orders of means over samples as those of the samples themselves."""
        if self.signal is None:
            return fit
        count = self._merged(orders)
        half = 0.5 * np.median(np.diff(self.signal[0])) * np.outer(fit.speed, orders)
        return replace(fit, amplitude=fit.amplitude * count * np.sin(half) / np.sin(count * half))

    def dwells(self) -> list[tuple[float, float]]:
        """Return the angles between which the speed is steady [rad]."""
        _, speeds = self.speed()
        first = float(np.ceil(self.teeth.number[0] / self.teeth.wheel.pitches))
        steady: list[tuple[float, float]] = []
        begin = 0
        low = high = float(speeds[0])
        for place, speed in enumerate([*speeds.tolist(), np.inf]):
            lowest, highest = min(low, speed), max(high, speed)
            if highest - lowest <= STEADY * lowest:
                low, high = lowest, highest
                continue
            if place - begin >= LEAST_DWELL:
                steady.append((TURN * (first + begin), TURN * (first + place)))
            begin, low, high = place, speed, speed
        return steady

    def _remaining(self, fit: OrderFit, fitted: Array) -> float:
        """Return the highest order of the cycle that is in the record but not in the fit, or zero."""
        if fit.left is None or self.signal is not None:
            return 0.0
        samples = self._samples(fitted)
        above = (
            np.arange(1, int(OF_HIGHEST * self.teeth.wheel.highest_order * self.cycle)) / self.cycle
        )
        above = above[above > fitted[-1]]
        window = np.floor((samples.angle - samples.angle[0]) / (CONSTANT * TURN)).astype(int)
        largest = REMAINS * float(np.max(np.abs(fit.amplitude)))
        there = 0.0
        for order in above.tolist():
            turned = fit.left * np.exp(-1j * order * samples.angle)
            sums = np.bincount(window, turned.real) + 1j * np.bincount(window, turned.imag)
            if 2.0 * float(np.max(np.abs(sums / np.maximum(np.bincount(window), 1)))) > largest:
                there = order
        return there


def _dwell(samples: Samples, orders: Array, dwell: tuple[float, float], length: float) -> OrderFit:
    """Return the mean of the orders over the windows of one steady speed."""
    begins = dwell[0] + length * np.arange(max(int((dwell[1] - dwell[0]) / length), 1))
    windows = unbroken_windows(samples, begins, length)
    count = len(windows)
    fit = fit_windows(samples, orders, windows)
    mean = np.mean(fit.amplitude, axis=0)
    scatter = np.sqrt(np.mean(fit.scatter**2, axis=0))
    if count >= KNOWN_SCATTER:
        # Cycles differ: the windows show it, their residuals do not.
        spread = np.sum(np.abs(fit.amplitude - mean) ** 2, axis=0) / (2.0 * (count - 1.0))
        scatter = np.maximum(scatter, np.sqrt(spread))
    return replace(
        fit,
        speed=np.mean(fit.speed, keepdims=True),
        ramp=np.mean(fit.ramp, keepdims=True),
        amplitude=mean[None, :],
        scatter=scatter[None, :] / np.sqrt(count),
    )


def load(
    path: str | Path,
    teeth: str,
    *,
    wheel: str | None = None,
    signal: str | None = None,
    place: str = "",
    cycle: int = 2,
    mark_angle_deg: float | None = None,
    edge: Edge = "rising",
    rate: float | None = None,
    columns: Mapping[str, int | str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Measurement:
    """Read a measurement of vibration.

    Parameters
    ----------
    path : str or Path
        A record in any format of `crankfem.satellites.measured.records`.
    teeth : str
        Of the wheel: a number, one with missing teeth like "60-2", or with a double tooth like "60+1".
    wheel : str, optional
        Channel with the times of its pulses [s], its voltage, or its logic level; found if there is one.
    signal : str, optional
        Channel of another sensor, such as a torque, over the time of the same record.
    place : str, optional
        Mass or element of the chain where the sensor is.
    cycle : {1, 2}, optional
        Revolutions per working cycle.
    mark_angle_deg : float, optional
        Shaft angle, as the engine file counts it, when the first tooth behind the mark passes [deg].
    edge : {"rising", "falling"}, optional
        Of a voltage.
    rate, columns, units
        As for `read_record`.

    Raises
    ------
    InputError
        If the record cannot be read, or does not fit what is said of it.
    """
    if cycle not in (1, 2):
        raise InputError(f"cycle: given {cycle!r}; allowed are 1 and 2 revolutions.")
    check_choice("edge", edge, get_args(Edge), "a tooth has these")
    toothed = Wheel.read(teeth)
    record = read_record(path, rate=rate, columns=columns, units=units)
    pulses = record.channel(wheel) if wheel else _only_wheel(record)
    if rate is not None and pulses.si_unit == "s":
        raise InputError(
            f"rate: given {rate:g} 1/s; allowed is none, because {pulses.name} has times of pulses in s."
        )
    numbered = number_teeth(_times(pulses, edge), toothed)
    measurand: Measurand = "angle"
    beside = None
    if signal is not None:
        channel = record.channel(signal)
        if channel.axis != "time" or channel.si_unit not in MEASURANDS:
            raise InputError(
                f"signal: given {signal}, in {channel.si_unit or 'an unknown unit'} over {channel.axis}; "
                f"allowed are {', '.join(MEASURANDS)} over the time."
            )
        beside, measurand = (channel.abscissa(), channel.si()), MEASURANDS[channel.si_unit]
    angle = None if mark_angle_deg is None else float(np.radians(mark_angle_deg))
    return Measurement(numbered, beside, measurand, place, cycle, angle, record.notes)


def _only_wheel(record: Record) -> Channel:
    """Return the channel of the wheel: the only one in seconds, in volts, or the only one."""
    for unit in ("s", "V"):
        some = [channel for channel in record.channels if channel.si_unit == unit]
        if len(some) == 1:
            return some[0]
    if len(record.channels) == 1:
        return record.channels[0]
    names = [channel.name for channel in record.channels]
    raise InputError(
        f"wheel: given none; {allowed_names('', names)}, because {record.path} has several channels."
    )


def _times(channel: Channel, edge: Edge) -> Array:
    """Return the times of the pulses of a channel [s]."""
    if channel.si_unit == "s":
        return channel.si()
    # What has another unit, such as a speed, is no sensor's signal.
    plain = channel.axis == "time" and channel.si_unit in ("", "V")
    if plain and channel.places is not None and np.unique(channel.values[:1000]).size <= 2:
        level = channel.values
        changes = np.diff(level) > 0.0 if edge == "rising" else np.diff(level) < 0.0
        return channel.abscissa()[1:][changes]
    if not plain or channel.step is None:
        shown = f"{channel.unit or 'no unit'} over {'no time' if channel.axis == 'none' else channel.axis}"
        raise InputError(
            f"{channel.name}: given in {shown}; allowed are times of pulses in s, as under pulse_time_s, or "
            "the voltage of the wheel's sensor at even times, such as one with rate = 50000 (1/s)."
        )
    begin = float(channel.start or 0.0)
    pieces = (values for values in channel.column.read(2**21))
    return pulse_times(pieces, channel.rate or 1.0 / channel.step, begin, edge)


def refuse_other_places(engine: EngineFile, places: Iterable[str]) -> None:
    """Refuse places that are no mass and no element of an engine's chains, before records are read."""
    unit = np.ones(len(engine.crank_throws))
    twisted = engine_torsional_chain(engine, unit, unit).chain
    pulled = engine_axial_chain(engine, unit, unit).chain
    for place in places:
        if place not in (*twisted.names, *twisted.elements, *pulled.names):
            raise InputError(
                f"--at: given {quoted(place)}; {allowed_names(place, twisted.names)}, and of a torque "
                f"{', '.join(twisted.elements)}, because orders are compared where they were measured."
            )


def refuse_other_speeds(measured: Measurement, lowest: float, highest: float) -> None:
    """Refuse a record that turns outside an engine's speeds [rad/s], with the factor that would mend it.

    Raises
    ------
    InputError
        If most revolutions are a quarter outside the range.
    """
    positive_number("lowest", lowest, "rad/s", "an engine turns")
    _, speeds = measured.speed()
    if 0.75 * lowest <= np.median(speeds) <= 1.25 * highest:
        return
    factor = float(np.sqrt(lowest * highest) / np.median(speeds))
    raise InputError(
        finished(
            f"record: turns at {amount(float(speeds.min()), 'rad/s')} to "
            f"{amount(float(speeds.max()), 'rad/s')}; the engine at {amount(lowest, 'rad/s')} to "
            f"{amount(highest, 'rad/s')}: the sample rate or the number of teeth may be off by a factor of "
            f"about {factor:.2g}, or it is another engine's."
        )
    )
