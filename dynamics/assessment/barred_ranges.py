"""Barred speed ranges: where limits are exceeded, widened by the rule and merged."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, positive_number
from crankbase.errors import InputError
from crankbase.frames import Row
from crankbase.results import Internal, Part, Result, Speed, result
from crankbase.sentences import in_si
from dynamics import wording
from dynamics.assessment.limits import (
    AmplitudeCurve,
    LimitUse,
    VibrationLimit,
    checked_rated_speed,
    usage,
    worst_use,
)
from dynamics.indices import at_most, within

Position = Literal["below", "running", "above"]


@dataclass(frozen=True)
class DecidingUse:
    """The use of a limit at a place for which a range of speeds is barred, or cannot be.

    Parameters
    ----------
    passing : bool
        Whether the limit is that for passing.
    """

    limit: VibrationLimit
    curve: AmplitudeCurve
    use: LimitUse
    passing: bool


@result("low", "high", "allowed", "position", "peaks", "limits", eq=True)
class BarredRange(Result):
    """A range of speeds to be passed quickly, or a proposal that cannot be accepted.

    Parameters
    ----------
    low, high : float
        Its ends [rad/s]. One that reaches into the running range from below begins with that: slower speeds
        are passed on every start, and judged with it.
    peaks : tuple of float
        Speeds of the largest vibration in it, or of which it is a flank [rad/s].
    limits : tuple of str
        Names of the limits exceeded in it.
    refusals : tuple of str
        Why running through it cannot be accepted; none if it can.
    remarks : tuple of str
        What is not known of it.
    position : {"running", "below", "above"}
        Whether it has running speeds, or lies as a whole below them, so that every start passes it, or
        above them, where nothing runs and nothing can be barred, but a limit still applies.
    ends : str
        Where the range's ends come from: at which speeds and places limits are exceeded, and the rule
        that widens the range about peaks.
    full_load : bool
        Whether it lies below the running speeds and was calculated at full load, so that it is not judged.
    deciding : DecidingUse or None
        For which it is barred or, if it cannot be, for which it is refused: what exceeds the limit for
        passing only where nothing else refuses it. None if it was read from JSON.
    """

    low: Speed
    high: Speed
    peaks: Internal[tuple[float, ...]]
    limits: tuple[str, ...]
    refusals: tuple[str, ...]
    remarks: tuple[str, ...]
    position: Position = "running"
    ends: str = ""
    full_load: Internal[bool] = False
    deciding: Internal[DecidingUse | None] = field(default=None, compare=False)

    @cached_property
    def allowed(self) -> Part[bool]:
        """Whether it may be barred, or passed on starting."""
        return not self.refusals

    @cached_property
    def shown(self) -> Part[str]:
        """Such as "700 to 800 1/min"."""
        return wording.speed_range(self.low, self.high)

    @cached_property
    def sentence(self) -> Part[str]:
        """Whether it may be barred or passed, and why not; without its full stop."""
        return wording.barred_sentence(
            self.low, self.high, self.position, self.refusals, self.full_load
        )

    def row(self) -> Row:
        """Return what a table of ranges shows, each value with its unit; see `table_of`."""
        return {
            "low": (self.low, "rad/s"),
            "high": (self.high, "rad/s"),
            "position": (self.position, ""),
            "allowed": (self.allowed, ""),
            "limits": (", ".join(self.limits), ""),
            "refusals": ("; ".join(self.refusals), ""),
            "remarks": ("; ".join(self.remarks), ""),
        }


BARRED_SOURCE = (
    "IACS unified requirement M68 (Rev.3, February 2021); Korean Register, Rules for Steel Ships "
    "2025, Part 5, Chapter 4, 206 and Annex 5-3, 2 (2)"
)

USUAL_HIGHEST_RATIO = 0.8
# A range is one to run in from this width on, as a share of its speed, or half of the running range's.
USABLE = 0.05
# Of the distance of two speeds, to find where a limit is met between them: so many parts, so often.
PARTS, ROUNDS = 256, 5


@dataclass(frozen=True)
class BarredRangeRule:
    """Width of the barred range around a critical speed, and the highest speed that may be barred.

    Parameters
    ----------
    rated_speed : float
        n0 [rad/s].
    highest_ratio : float, optional
        Share of the rated speed above which nothing may be barred, for all limits. By default that of
        each limit, and 0.8 where a limit states none.
    source : str
        Of both.

    Raises
    ------
    InputError
        If a value is not above zero.

    Notes
    -----
    With r = n_c / n0 the range is 16 n_c / (18 - r) to (18 - r) n_c / 16.
    """

    rated_speed: float
    highest_ratio: float | None = None
    source: str = BARRED_SOURCE

    def __post_init__(self) -> None:
        checked_rated_speed(self.rated_speed)
        if self.highest_ratio is not None:
            why = "it is a share of the rated speed"
            positive_number("highest_ratio", self.highest_ratio, "", why)

    @property
    def highest(self) -> float:
        """Speed above which nothing may be barred, where the limit states none [rad/s]."""
        ratio = USUAL_HIGHEST_RATIO if self.highest_ratio is None else self.highest_ratio
        return ratio * self.rated_speed

    def highest_by(self, limit: VibrationLimit) -> float:
        """Return the speed above which no range that exceeds a limit may be barred [rad/s]."""
        highest = np.inf if limit.passing is None else limit.passing.high
        if np.isinf(highest):
            return self.highest
        return highest if self.highest_ratio is None else min(highest, self.highest)

    def bounds(self, critical: float) -> tuple[float, float]:
        """Return the lowest and highest barred speed about a critical speed [rad/s].

        Raises
        ------
        InputError
            If the critical speed is not above zero, or above twice the rated one, where the
            formula's range has shrunk to nothing.
        """
        speed = positive_number("critical", critical, "rad/s", "it is that of a turning shaft")
        wide = 18.0 - speed / self.rated_speed
        if wide <= 16.0:
            raise InputError(
                f"critical: given {in_si(speed, 'rad/s')}; allowed is less than twice the rated speed of "
                f"{in_si(self.rated_speed, 'rad/s')}, because the formula gives no range from there on."
            )
        return 16.0 * speed / wide, wide * speed / 16.0


@dataclass(frozen=True)
class ExceededRange:
    """A continuous range of speeds in which one limit is exceeded.

    Parameters
    ----------
    low, high : float
        Where the limit is met, by interpolation between the speeds calculated [rad/s].
    peaks : tuple of float
        Speeds at which the vibration has a maximum [rad/s]; also that of a flank which the range ends on,
        though it lies beyond. Neither an end of the speeds calculated nor a bend of the limit is one.
    cut_off : bool
        Whether the range reaches the first or last calculated speed, so that it may continue beyond.
    used : float
        Largest use of the limit in it.
    """

    low: float
    high: float
    peaks: tuple[float, ...]
    cut_off: bool
    used: float


def exceeded_ranges(
    limit: VibrationLimit, curve: AmplitudeCurve, highest: float = np.inf
) -> tuple[ExceededRange, ...]:
    """Find the ranges of speed in which a limit is exceeded.

    Parameters
    ----------
    highest : float
        Ranges end there [rad/s].

    Returns
    -------
    tuple of ExceededRange
        Ascending.

    Notes
    -----
    Between two calculated speeds the amplitude is interpolated linearly. The limit is not: a range ends
    where it jumps. The flank of a resonance is concave up, so the chord is above it and the range is
    slightly too wide. Next to an unbounded value the range extends to the next calculated speed.
    """
    speeds, used = curve.speeds, usage(limit, curve)
    # Indices of the local maxima; the first of equal neighbors, neither end.
    middle = curve.values[1:-1]
    tops = 1 + np.flatnonzero((middle > curve.values[:-2]) & (middle >= curve.values[2:]))
    ranges = []
    edges = np.diff(np.concatenate(([0], (used > 1.0).astype(int), [0])))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    for first, last in zip(starts.tolist(), stops.tolist(), strict=True):
        if not at_most(speeds[first], highest):
            break
        judged = first + np.flatnonzero(at_most(speeds[first : last + 1], highest))
        ranges.append(
            ExceededRange(
                low=_crossing(limit, curve, used, first, -1),
                high=min(_crossing(limit, curve, used, last, 1), highest),
                peaks=_peaks_to(curve, tops[(tops >= first) & (tops <= last)], highest),
                cut_off=first == 0 or speeds.size - 1 in judged,
                used=float(np.max(used[judged])),
            )
        )
    return tuple(ranges)


def barred_ranges(
    findings: Sequence[tuple[VibrationLimit, AmplitudeCurve]],
    rule: BarredRangeRule,
    running_range: tuple[float, float],
    full_load: bool = False,
) -> tuple[BarredRange, ...]:
    """Propose the ranges of speed to be barred.

    Parameters
    ----------
    findings : sequence of pairs of VibrationLimit and AmplitudeCurve
    running_range : tuple of two floats
        Lowest and highest running speed [rad/s]. Ranges that end below the lowest one are passed on
        every start, and only have to be passable.
    full_load : bool, optional
        Whether the amplitudes are those of full load also below the running range, where no engine
        starts with it: these ranges are then told, and not judged.

    Returns
    -------
    tuple of BarredRange
        Ascending and separate; those that are not acceptable state the reason.

    Notes
    -----
    Each range in which a limit is exceeded is widened to the rule's bounds about each of its peaks;
    touching ranges become one. A range may be barred if it ends below the highest speed that the
    limit and the rule allow to be barred, stays within the limit for passing, and leaves part of the
    running range free: since touching ranges are merged, separate ones always leave speeds between them.
    """
    widened = []
    for limit, curve in findings:
        for exceeded in exceeded_ranges(limit, curve, limit_end_speed(limit, running_range)):
            peaks = [peak for peak in exceeded.peaks if at_most(peak, rule.rated_speed)]
            bounds = [(exceeded.low, exceeded.high), *map(rule.bounds, peaks)]
            low, high = min(low for low, _ in bounds), max(high for _, high in bounds)
            widened.append(_Widened(low, high, exceeded, limit, curve))
    groups: list[list[_Widened]] = []
    reach = -np.inf
    for item in sorted(widened, key=lambda entry: entry.low):
        if item.low > reach:
            groups.append([])
        groups[-1].append(item)
        reach = max(reach, item.high)
    return tuple(_barred(group, findings, rule, running_range, full_load) for group in groups)


def is_usable(span: tuple[float, float], running_range: tuple[float, float]) -> bool:
    """Return whether a range of running speeds is wide enough to keep an engine in it."""
    low, high = running_range
    return span[1] >= span[0] * (1.0 + min(USABLE, 0.5 * (high / low - 1.0)))


def limit_end_speed(limit: VibrationLimit, running_range: tuple[float, float]) -> float:
    """Return the speed at which a limit ends: the highest running one, or the rule's end."""
    end = limit.continuous.high
    return max(running_range[1], end) if np.isfinite(end) else running_range[1]


@dataclass(frozen=True)
class _Widened:
    """A range in which a limit is exceeded at one position, with the ends that the rule gives it."""

    low: float
    high: float
    exceeded: ExceededRange
    limit: VibrationLimit
    curve: AmplitudeCurve

    @property
    def place(self) -> str:
        """Where the amplitude is."""
        return self.curve.name


def _barred(
    group: Sequence[_Widened],
    findings: Sequence[tuple[VibrationLimit, AmplitudeCurve]],
    rule: BarredRangeRule,
    running_range: tuple[float, float],
    full_load: bool,
) -> BarredRange:
    low, high = min(item.low for item in group), max(item.high for item in group)
    names = tuple(dict.fromkeys(item.limit.name for item in group))
    position: Position = (
        "below"
        if not at_most(running_range[0], high)
        else "running"
        if at_most(low, running_range[1])
        else "above"
    )
    refusals, remarks = [], []
    too_much: list[DecidingUse] = []
    if at_most(low, running_range[0]) and at_most(running_range[1], high):
        refusals.append(wording.NO_SPEED_LEFT)
    # Below the running range nothing is barred, but only what the limit for passing covers may be passed.
    if position == "below":
        end = min(item.limit.passing.high if item.limit.passing else np.inf for item in group)
    else:
        end = min(rule.highest_by(item.limit) for item in group)
    if position == "above":
        most = max(group, key=lambda item: item.exceeded.used)
        applies_to = limit_end_speed(most.limit, running_range)
        refusals.append(wording.above_running(most.limit.name, most.exceeded.used, applies_to))
    elif not at_most(high, end):
        # What counts is where the engine runs: a range goes on above it as far as a limit applies.
        top = min(high, running_range[1]) if at_most(end, running_range[1]) else high
        holds_rated = bool(at_most(low, rule.rated_speed) and at_most(rule.rated_speed, top))
        refusals.append(wording.too_high(top, end, rule.rated_speed, holds_rated))
    unjudged = position == "above" or (position == "below" and full_load)
    for limit, curve in () if unjudged else findings:
        inside = within(curve.speeds, low, high)
        values = curve.values[inside]
        if not values.size or limit.name not in names:
            continue
        if limit.passing is None:
            if np.any(np.isinf(values)):
                refusals.append(wording.unbounded_inside(limit.name))
            remarks.append(wording.no_passing(limit.name))
            continue
        passing = limit.passing.at(curve.speeds[inside])
        share = np.zeros(values.shape)
        np.divide(values, passing, out=share, where=np.isfinite(passing))
        # Running speeds first: others are only passed on starting, or never reached.
        speeds = curve.speeds[inside]
        runs = within(speeds, *running_range) & (share > 1.0)
        worst = int(np.argmax(np.where(runs, share, 0.0) if np.any(runs) else share))
        if share[worst] > 1.0:
            use = LimitUse(*(float(each[worst]) for each in (speeds, values, passing)))
            too_much.append(DecidingUse(limit, curve, use, passing=True))
    deciding = _most_used(group, running_range)
    if too_much:
        passed = max(too_much, key=lambda most: _running_first(most.use, running_range))
        if not refusals:
            deciding = passed
        use = passed.use
        refusals.append(
            wording.too_much(
                *(passed.curve.name, use.value, use.permitted, passed.limit.unit, use.speed),
                others=len(too_much) - 1,
            )
        )
    if any(item.exceeded.cut_off for item in group):
        remarks.append(wording.CUT_OFF)
    # What lies below the running range is passed on every start, and nothing is barred there.
    begins = max(low, running_range[0]) if position == "running" else low
    return BarredRange(
        low=float(begins),
        high=float(high),
        peaks=tuple(sorted({peak for item in group for peak in item.exceeded.peaks})),
        limits=names,
        refusals=tuple(dict.fromkeys(refusals)),
        remarks=tuple(dict.fromkeys(remarks)),
        position=position,
        ends=_ends(group, rule) + wording.begins_below(float(low), float(begins)),
        full_load=position == "below" and full_load,
        deciding=deciding,
    )


def _running_first(use: LimitUse, running_range: tuple[float, float]) -> tuple[bool, float]:
    """Rank uses: what is exceeded at running speeds first, then the largest."""
    return bool(within(use.speed, *running_range)) and use.used > 1.0, use.used


def _most_used(group: Sequence[_Widened], running_range: tuple[float, float]) -> DecidingUse:
    """Return the largest use of the limits for running, at running speeds if one is exceeded there."""
    low, high = running_range
    uses = [
        DecidingUse(item.limit, item.curve, use, passing=False)
        for item in group
        for first, last in (
            (item.exceeded.low, item.exceeded.high),
            (max(item.exceeded.low, low), min(item.exceeded.high, high)),
        )
        if (use := worst_use(item.limit, item.curve, first, last)) is not None
    ]
    return max(uses, key=lambda most: _running_first(most.use, running_range))


def _ends(group: Sequence[_Widened], rule: BarredRangeRule) -> str:
    """State where limits are exceeded first and last, and how the rule widens the range, if it does."""
    # Where several places share an end, as at a jump of the limit, the one with the largest use is named.
    first = min(group, key=lambda item: (item.exceeded.low, -item.exceeded.used))
    last = max(group, key=lambda item: (item.exceeded.high, item.exceeded.used))
    spans = sorted((item.exceeded.low, item.exceeded.high) for item in group)
    reached = np.maximum.accumulate([high for _, high in spans])
    gaps = any(low > high for (low, _), high in zip(spans[1:], reached, strict=False))
    lowest, highest = min(group, key=lambda item: item.low), max(group, key=lambda item: item.high)
    below = above = None
    if lowest.low < first.exceeded.low:
        below = lowest.exceeded.peaks[0]
    if highest.high > last.exceeded.high:
        above = max(top for top in highest.exceeded.peaks if at_most(top, rule.rated_speed))
    return wording.range_ends(
        (first.exceeded.low, first.place),
        (last.exceeded.high, last.place),
        gaps,
        max(item.exceeded.used for item in group),
        rule.rated_speed,
        (below, above),
    )


def _crossing(
    limit: VibrationLimit, curve: AmplitudeCurve, used: Array, place: int, step: int
) -> float:
    """Return the speed at which the use is 1, outwards from the last index above it."""
    speeds, values = curve.speeds, curve.values
    other = place + step
    if not 0 <= other < speeds.size:
        return float(speeds[place])
    if np.isinf(used[place]):
        return float(speeds[other])
    above, below = float(speeds[place]), float(speeds[other])
    for _ in range(ROUNDS):
        tried = np.linspace(above, below, PARTS + 1)
        share = (tried - speeds[place]) / (speeds[other] - speeds[place])
        value = values[place] + share * (values[other] - values[place])
        exceeded = value > limit.continuous.at(tried)
        # By halves, as more than one part may meet the limit.
        first, last = 0, PARTS
        while last - first > 1:
            middle = (first + last) // 2
            first, last = (middle, last) if exceeded[middle] else (first, middle)
        above, below = float(tried[first]), float(tried[last])
    return above


def _peaks_to(curve: AmplitudeCurve, tops: NDArray[np.intp], highest: float) -> tuple[float, ...]:
    """Return the speeds of the local maxima up to a speed, and of the maximum on whose flank that is."""
    peaks = tuple(curve.speeds[tops].tolist())
    inside = tuple(peak for peak in peaks if at_most(peak, highest))
    beyond = peaks[len(inside) :]
    place = int(np.count_nonzero(at_most(curve.speeds, highest)))
    rises = beyond and curve.values[place] > curve.values[place - 1]
    return (*inside, beyond[0]) if rises else inside
