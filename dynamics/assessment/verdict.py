"""The verdict: vibration over the speed against limits, the measures required, and what decides it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np

from crankbase.diagrams import (
    BLUE,
    GRAY,
    ORANGE,
    ORDER_COLORS,
    RED,
    draw_bands,
    legend_below,
    legend_inside,
    new_axes,
    with_gaps,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Row, table, table_of
from crankbase.quantity import RPM, percent
from crankbase.results import Flat, InItsUnit, Internal, Number, Part, Quantity, Result, result
from crankbase.sentences import amount, joined, kept
from dynamics.assessment.barred_ranges import (
    BarredRange,
    BarredRangeRule,
    barred_ranges,
    is_usable,
    limit_end_speed,
)
from dynamics.assessment.limits import (
    AmplitudeCurve,
    LimitUse,
    VibrationLimit,
    check_findings,
    checked_running_range,
    usage,
    worst_use,
)
from dynamics.indices import at_most, within
from dynamics.plots.curves import SPEED_LABEL, barred_bands, in_unit, set_speed_axis
from dynamics.response.peak_cause import PeakCause
from dynamics.wording import (
    at_speed,
    check_sentences,
    limit_at,
    narrow_between,
    shown_range,
    use_in_words,
    values_sentence,
    verdict_headline,
)

# Checks that a diagram of the verdict draws: those of which most is used.
WORST_DRAWN, SAME = 5, 1e-9  # speeds this near, as a share, are one
Status = Literal["fine", "barred range needed", "not acceptable"]


@result(
    "limit.name",
    "worst_value",
    "permitted",
    "worst_speed [rad/s]",
    "used",
    "passed",
    "remarks",
    eq=True,
)
class LimitCheck(Result):
    """One curve compared with one limit.

    Parameters
    ----------
    worst_speed : float
        Speed at which most of the limit is used, among the speeds judged: from the lowest running speed
        to the highest, or to the end of the limit's rule above it [rad/s].
    worst_value, permitted : float
        Amplitude (inf if unbounded) and permitted value at that speed, in the unit of the limit.
    remarks : tuple of str
        Speeds not covered by the limit or the calculation.
    judged : tuple of two floats
        The speeds judged [rad/s].
    cause : PeakCause or None
        Contributions of orders to the amplitude at the worst speed, if known.
    highest_running : float
        The highest running speed [rad/s]; speeds judged above it are reported separately.
    passing : bool
        Whether the permitted value is that for passing, which decides about a range that is to be barred
        or is passed on starting.
    """

    limit: Flat[VibrationLimit]
    curve: Internal[AmplitudeCurve]
    worst_speed: Annotated[float, Quantity("rad/s", exported="1/min", key="speed_rpm")]
    worst_value: Annotated[float, Quantity(".unit", key="value")]
    permitted: InItsUnit
    remarks: Internal[tuple[str, ...]]
    judged: Internal[tuple[float, float]]
    cause: PeakCause | None = None
    highest_running: Internal[float] = np.inf
    passing: bool = False

    @cached_property
    def place(self) -> Part[str]:
        """Where the amplitude is."""
        return self.curve.name

    @cached_property
    def in_running_range(self) -> Part[bool]:
        """Whether the engine runs at the worst speed."""
        return self.worst_speed <= self.highest_running

    @cached_property
    def below(self) -> Part[LimitUse | None]:
        """Largest use below the speeds judged."""
        return worst_use(self.limit, self.curve, 0.0, (1.0 - SAME) * self.judged[0])

    @cached_property
    def running(self) -> Part[LimitUse | None]:
        """Largest use at running speeds."""
        return worst_use(
            self.limit, self.curve, self.judged[0], min(self.judged[1], self.highest_running)
        )

    @cached_property
    def above(self) -> Part[LimitUse | None]:
        """The same above the running range, as far as the limit is judged."""
        if at_most(self.judged[1], self.highest_running):
            return None
        return worst_use(
            self.limit, self.curve, (1.0 + SAME) * self.highest_running, self.judged[1]
        )

    @property
    def at_worst(self) -> LimitUse:
        """Largest use at all speeds judged."""
        return LimitUse(self.worst_speed, self.worst_value, self.permitted)

    @property
    def at_running(self) -> LimitUse:
        """Largest use at running speeds; where none was judged, that of all speeds."""
        return self.running or self.at_worst

    @property
    def at_running_speeds(self) -> "LimitCheck":
        """The same check at its worst running speed, if any; one for passing as it is."""
        if self.passing or self.running is None or at_most(self.worst_speed, self.highest_running):
            return self
        worst = self.running
        return replace(
            self,
            worst_speed=worst.speed,
            worst_value=worst.value,
            permitted=worst.permitted,
            cause=None,
        )

    @cached_property
    def used(self) -> Number:
        """Share of the permitted amplitude that is used at the worst speed."""
        return self.worst_value / self.permitted

    @property
    def margin(self) -> float:
        """Share of the permitted amplitude that is left at the worst speed; negative if exceeded."""
        return 1.0 - self.used

    @cached_property
    def passed(self) -> Part[bool]:
        """Whether the limit is kept at all speeds judged."""
        return self.used <= 1.0

    @property
    def sentence(self) -> str:
        """The finding with its numbers and the limit's source."""
        return joined(" ", self.sentences)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The finding, and its cause."""
        at_running = self.at_running_speeds
        return check_sentences(
            limit_at(self.limit.name, self.place),
            self.limit.source + (", assumed" if self.limit.assumed else ""),
            self.worst_speed,
            self.use,
            "" if at_running is self else at_running.use,
            "" if self.cause is None else self.cause.reasons,
            above_alone=at_running.passed and not self.passed,
        )

    @property
    def use(self) -> str:
        """What is reached at the worst speed, and what is permitted there."""
        return use_in_words(
            self.limit.unit,
            self.worst_speed,
            self.worst_value,
            self.permitted,
            passing=self.passing,
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the amplitude and the permitted value over the speed, with a dot at the worst speed.

        Returns
        -------
        matplotlib.axes.Axes
            The curve has gaps where the vibration is unbounded; the limit ends where it is not stated.
        """
        drawn = in_unit(self.limit.unit)
        speeds = self.curve.speeds
        axes = new_axes(axes)
        rpm, limit = RPM * speeds, self.limit
        permitted = with_gaps(drawn.factor * limit.continuous.at(speeds))
        axes.plot(rpm, with_gaps(drawn.factor * self.curve.values), color=BLUE, label="amplitude")
        axes.plot(rpm, permitted, "--", color=RED, label="permitted")
        if limit.passing is not None:
            passing = with_gaps(drawn.factor * limit.passing.at(speeds))
            axes.plot(rpm, passing, ":", color=ORANGE, label="permitted in passing")
        if np.isfinite(self.worst_value):
            worst = (RPM * self.worst_speed, drawn.factor * self.worst_value)
            axes.plot(*worst, "o", color=BLUE, label=f"worst: {percent(self.used, 3)} % used")
        else:
            axes.axvline(RPM * self.worst_speed, color=RED, linestyle=":", label="unbounded")
        set_speed_axis(axes, speeds)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel(drawn.label)
        write_title(axes, limit_at(limit.name, self.curve.name))
        legend_inside(axes)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each speed: amplitude, what is permitted (inf if nothing is stated), its use.

        Units and errors are those of `crankbase.frames.table`.
        """
        unit = self.limit.unit
        return table(
            {
                "speed": (self.curve.speeds, "rad/s"),
                "amplitude": (self.curve.values, unit),
                "permitted": (self.limit.continuous.at(self.curve.speeds), unit),
                "used": (usage(self.limit, self.curve), "1"),
            }
        )

    def row(self) -> Row:
        """Return the columns of a table of checks, each value with its unit; see `table_of`.

        The worst value and the permitted one are in the unit that the row names.
        """
        return {
            "limit": (self.limit.name, ""),
            "curve": (self.curve.name, ""),
            "passed": (self.passed, ""),
            "used": (self.used, "1"),
            "worst_speed": (self.worst_speed, "rad/s"),
            "worst_value": (self.worst_value, "SI, see the column unit"),
            "permitted": (self.permitted, "SI, see the column unit"),
            "unit": (self.limit.unit, ""),
            "source": (self.limit.source, ""),
            "assumed": (self.limit.assumed, ""),
        }


@result("status", "checks", "barred", "running_range")
class Verdict(Result):
    """Result of comparing an engine's vibration with its limits.

    Parameters
    ----------
    status : {"fine", "barred range needed", "not acceptable"}
    checks : tuple of LimitCheck
        One for each curve, the worst use first.
    barred : tuple of BarredRange
        Ranges of running speeds to be barred, proposed; also those that cannot be accepted, some of
        which may lie above the running range.
    started_through : tuple of BarredRange
        Ranges below the lowest running speed that are passed on every start.
    running_range : tuple of two floats
        [rad/s].
    remarks : tuple of str
        Open questions.
    deciding : LimitCheck
        The check for which the status is what it is, at the speed that decides: where a range cannot be
        barred or passed, what refuses it (`BarredRange.deciding`), else what makes a range to be barred,
        else the largest use at running speeds.
    """

    status: Status
    checks: tuple[LimitCheck, ...]
    barred: tuple[BarredRange, ...]
    started_through: tuple[BarredRange, ...]
    running_range: Annotated[
        tuple[float, float], Quantity("rad/s", exported="1/min", key="running_rpm")
    ]
    remarks: Internal[tuple[str, ...]]
    deciding: LimitCheck

    @property
    def deciding_first(self) -> tuple[BarredRange, ...]:
        """All ranges: that of `deciding` first, then those that cannot be barred or passed."""
        check = self.deciding

        def decides(span: BarredRange) -> bool:
            inside = bool(within(check.worst_speed, span.low, span.high))
            return inside and check.limit.name in span.limits

        each = (*self.barred, *self.started_through)
        return tuple(sorted(each, key=lambda span: (span.allowed, not decides(span))))

    @property
    def ranges_to_bar(self) -> list[tuple[float, float]]:
        """Speed ranges that may be barred, for any limit [rad/s]."""
        return ranges_to_bar(self.barred)

    @classmethod
    def from_record(cls, content: Any) -> "Verdict":
        """Read content of JSON; older ones have their sentences in one text."""
        if isinstance(content, Mapping) and "sentences" not in content:
            content = {**content, "sentences": [content.get("sentence", "")]}
        return super().from_record(content)

    @property
    def sentence(self) -> Part[str]:
        """The verdict in words, with the ranges and the worst finding."""
        return joined(" ", self.sentences)

    @cached_property
    def sentences(self) -> Part[tuple[str, ...]]:
        """The verdict with what decides it, its cause, what is worse above running speeds, and refusals."""
        check, most = self.deciding, self.checks[0]
        above: tuple[str, ...] = ()
        if check.curve is most.curve and check.worst_speed == most.at_running.speed:
            check = most  # which tells both
        elif most.used > check.used and not most.in_running_range:
            place = limit_at(most.limit.name, most.curve.name)
            above = (f"Above the running range, {place}: {kept(most.use)}.",)
        first, *cause = check.sentences
        refused = [span for span in self.deciding_first if not span.allowed]
        return (
            f"{kept(self.headline)}: {kept(first)}",
            *(*cause, *above),
            *(f"{kept(span.sentence)}." for span in refused),
        )

    @cached_property
    def headline(self) -> Part[str]:
        """The status in words, with the running range or the ranges to bar."""
        ranges = [barred.shown for barred in self.barred]
        return verdict_headline(self.status, self.running_range, ranges)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the share of each limit that is used over the speed, with barred ranges shaded.

        Returns
        -------
        matplotlib.axes.Axes
            Over all speeds judged, including those above the running range. The dashed line is the
            permitted value; gaps are where the vibration is unbounded or no limit is stated.
            Of more than five checks the five with the worst use are drawn, and the legend counts the
            others.
        """
        axes = new_axes(axes)
        low, highest = self.running_range
        end = max(check.judged[1] for check in self.checks)
        draw_bands(axes, barred_bands(self.ranges_to_bar))
        worst = sorted(self.checks, key=lambda check: -check.used)[:WORST_DRAWN]
        for check, color in zip(worst, ORDER_COLORS, strict=False):
            speeds = check.curve.speeds
            stated = np.isfinite(check.limit.continuous.at(speeds))
            # As far as it is judged, and to the next speed, so that no line ends before.
            stated[np.searchsorted(speeds, check.judged[1]) + 1 :] = False
            used = np.where(stated, 100.0 * usage(check.limit, check.curve), np.inf)
            axes.plot(
                RPM * speeds,
                with_gaps(used),
                color=color,
                label=limit_at(check.limit.name, check.curve.name),
            )
        if others := len(self.checks) - len(worst):
            axes.plot([], [], " ", label=f"and {others} more, used less")
        axes.axhline(100.0, color=RED, linestyle="--", linewidth=1.2, label="permitted")
        if not at_most(end, highest):
            label = "highest running speed"
            axes.axvline(RPM * highest, color=GRAY, linestyle=":", linewidth=1.2, label=label)
        axes.set_xlabel(SPEED_LABEL)
        axes.set_xlim(RPM * low, RPM * end)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel("used of the permitted amplitude [%]")
        write_title(axes, f"Vibration against its limits: {self.status}")
        legend_below(axes, 1)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return one row for each check, the worst use first.

        Units and errors are those of `crankbase.frames.table`.
        """
        return table_of(self.checks)


def judge(
    findings: Sequence[tuple[VibrationLimit, AmplitudeCurve]],
    running_range: tuple[float, float],
    rule: BarredRangeRule,
    full_load: bool = False,
) -> Verdict:
    """Compare vibration with its limits and propose barred speed ranges.

    Parameters
    ----------
    findings : sequence of pairs of VibrationLimit and AmplitudeCurve
        Amplitudes over the speed with their limits; one limit may be used in many pairs.
    running_range : tuple of two floats
        Lowest and highest running speed [rad/s]; every curve must cover it. A limit
        that its source states up to a higher speed is judged up to there, as far as calculated.
    full_load : bool, optional
        As of `barred_ranges`.

    Returns
    -------
    Verdict
        "fine" if all limits are kept at running speeds, and speeds below can be passed on starting;
        "barred range needed" if barring ranges achieves this; "not acceptable" otherwise.

    Raises
    ------
    InputError
        If there are no findings or one is not such a pair, the running range is reversed or a curve does
        not cover it.
    """
    check_findings(findings)
    low, high = checked_running_range(running_range)
    checks = [_check(limit, curve, (low, high)) for limit, curve in findings]
    ranges = barred_ranges(findings, rule, (low, high), full_load)
    barred = tuple(span for span in ranges if span.position != "below")
    below = tuple(span for span in ranges if span.position == "below")
    noted = [f"{check.curve.name}: {kept(text)}" for check in checks for text in check.remarks]
    noted += [f"{kept(span.shown)}: {kept(text)}" for span in ranges for text in span.remarks]
    between = [(below[1], above[0]) for below, above in pairwise(ranges_to_bar(ranges))]
    noted += [narrow_between(*strip) for strip in between if not is_usable(strip, (low, high))]
    for limit, _ in findings:
        if not at_most(high, limit.continuous.high):
            stated = at_speed(limit.continuous.high)
            noted.append(f"{limit.name}: not judged above {stated}, where the limit ends")
        if limit.remark:
            noted.append(f"{limit.name}: {kept(limit.remark)}")
    ranked = tuple(sorted(checks, key=lambda check: -check.used))
    return Verdict(
        status=status_by(ranges),
        checks=ranked,
        barred=barred,
        started_through=below,
        running_range=(low, high),
        remarks=tuple(dict.fromkeys(noted)),
        deciding=_deciding(ranked, ranges),
    )


def _deciding(checks: Sequence[LimitCheck], ranges: Sequence[BarredRange]) -> LimitCheck:
    """Return the check that decides, by the ranges of `barred_ranges` or, without any, at running speeds."""
    refused = [span for span in ranges if not span.allowed]
    decides = [
        (span.position == "running", span.deciding.use.used, span.deciding)
        for span in refused or ranges
        if span.deciding is not None and not (span.allowed and span.position == "below")
    ]
    if not decides:
        return max((check.at_running_speeds for check in checks), key=lambda check: check.used)
    *_, most = max(decides, key=lambda ranked: ranked[:2])
    check = next(
        check for check in checks if check.curve is most.curve and check.limit is most.limit
    )
    return replace(
        check,
        worst_speed=most.use.speed,
        worst_value=most.use.value,
        permitted=most.use.permitted,
        passing=most.passing,
    )


def ranges_to_bar(ranges: Iterable[BarredRange]) -> list[tuple[float, float]]:
    """Return which of the ranges of `barred_ranges` may be barred [rad/s]."""
    return [(span.low, span.high) for span in ranges if span.allowed and span.position != "below"]


def status_by(ranges: Sequence[BarredRange]) -> Status:
    """Return the status by the ranges of `barred_ranges`."""
    if any(not span.allowed for span in ranges):
        return "not acceptable"
    return "barred range needed" if any(span.position != "below" for span in ranges) else "fine"


def _check(
    limit: VibrationLimit, curve: AmplitudeCurve, running_range: tuple[float, float]
) -> LimitCheck:
    low, high = running_range
    if not (at_most(curve.speeds[0], low) and at_most(high, curve.speeds[-1])):
        raise InputError(
            f"speeds of {curve.name}: given {shown_range(curve.speeds[0], curve.speeds[-1])}; allowed "
            f"are speeds that cover the running range of {shown_range(low, high)}, because every "
            "speed at which the engine runs is judged."
        )
    end = limit_end_speed(limit, running_range)
    used, permitted = usage(limit, curve), limit.continuous.at(curve.speeds)
    judged = np.isfinite(permitted) & within(curve.speeds, low, end)
    if not np.any(judged):
        raise InputError(
            f"limit on {limit.name}: given for {shown_range(limit.continuous.low, limit.continuous.high)}"
            f"; allowed is one that is stated at running speeds, {shown_range(low, high)}, because it "
            "judges nothing otherwise."
        )
    worst = int(np.argmax(np.where(judged, used, -np.inf)))
    remarks = []
    if not at_most(end, curve.speeds[-1]):
        remarks.append(
            f"the limit goes on to {at_speed(end)}, the calculation to "
            f"{at_speed(float(curve.speeds[-1]))}"
        )
    return LimitCheck(
        limit=limit,
        curve=curve,
        worst_speed=float(curve.speeds[worst]),
        worst_value=float(curve.values[worst]),
        permitted=float(permitted[worst]),
        remarks=tuple(remarks),
        judged=(low, min(end, float(curve.speeds[-1]), limit.continuous.high)),
        highest_running=high,
    )


Acceptance = Literal["acceptable", "not acceptable", "undecided"]


@result("field", "value", "unit", "status", "taken", eq=True)
class Trial(Result):
    """The verdict with one possible value of an assumption.

    Parameters
    ----------
    field : str
        Field of the value, such as "limits.tensile_strength".
    name : str
        Name of the value, such as "tensile strength".
    taken : bool
        Whether this is the value used in the calculation.
    why : str
        Why another value is possible, if the value is not simply assumed.
    """

    field: str
    name: str
    value: InItsUnit
    unit: str
    status: Status
    taken: bool = False
    why: str = ""

    @property
    def acceptable(self) -> bool:
        """Whether the engine may run, with barred speeds if necessary."""
        return self.status != "not acceptable"

    @property
    def shown(self) -> str:
        """The value with its unit."""
        return amount(self.value, self.unit, 4)


@result("status", "reasons", "trials", eq=True)
class Decision(Result):
    """What can be concluded despite the assumptions.

    Parameters
    ----------
    status : {"acceptable", "not acceptable", "undecided"}
        "undecided" if the engine is acceptable with some of the values tried and not with others.
    reasons : tuple of str
        What decides, and the fields that give it, of each field; none if no trial changes the verdict.
    trials : tuple of Trial
    """

    status: Acceptance
    reasons: tuple[str, ...]
    trials: tuple[Trial, ...]

    @property
    def sentence(self) -> Part[str]:
        """The reasons in one sentence; empty if there are none."""
        return joined("; ", self.reasons)

    @classmethod
    def from_record(cls, content: Any) -> "Decision":
        """Read content of JSON; older ones have the reasons in one sentence."""
        if isinstance(content, Mapping) and "reasons" not in content:
            content = {**content, "reasons": list(filter(None, [content.get("sentence")]))}
        return super().from_record(content)

    def to_pandas(self) -> DataFrame:
        """Return a table with a row for each value tried.

        Units and errors are those of `crankbase.frames.table`.
        """
        return table_of(self.trials)


def decide(status: Status, trials: Iterable[Trial]) -> Decision:
    """Compare the verdict with the values used and those with other possible values.

    Parameters
    ----------
    status : {"fine", "barred range needed", "not acceptable"}
        Of the calculation.
    trials : iterable of Trial
        Of one or more fields, each varied separately; the value used is among its values.

    Examples
    --------
    >>> steel = ("limits.tensile_strength", "tensile strength")
    >>> decide("not acceptable", [
    ...     Trial(*steel, 440e6, "Pa", "not acceptable", taken=True), Trial(*steel, 590e6, "Pa", "fine")
    ... ]).sentence
    'acceptable with a tensile strength of 590 MPa, not with 440 MPa (assumed): give limits.tensile_strength'
    """
    tried = tuple(trials)
    by_field = [
        sorted((trial for trial in tried if trial.field == field), key=lambda trial: trial.value)
        for field in dict.fromkeys(trial.field for trial in tried)
    ]
    accepted = status != "not acceptable"
    conclusion: Acceptance = "acceptable" if accepted else "not acceptable"
    deciding = [
        (field, [trial.acceptable for trial in field])
        for field in by_field
        if any(trial.acceptable != accepted for trial in field)
    ]
    holds = "acceptable"
    if deciding:
        conclusion = "undecided"
    elif accepted:
        holds = "no speeds need be barred"
        deciding = [
            (field, [trial.status == "fine" for trial in field])
            for field in by_field
            if any(trial.status != status for trial in field)
        ]
    reasons = []
    for field, holding in deciding:
        first, shown = field[0], [kept(trial.shown) for trial in field]
        taken = next((place for place, trial in enumerate(field) if trial.taken), None)
        values = values_sentence(first.field, first.name, first.why, shown, holding, taken)
        reasons.append(f"{holds} with {values}")
    return Decision(conclusion, tuple(reasons), tried)


def changes(trials: Sequence[Trial]) -> list[tuple[Trial, Trial]]:
    """Return the adjacent values between which the engine becomes acceptable, or stops being so."""
    ordered = sorted(trials, key=lambda trial: trial.value)
    return [pair for pair in pairwise(ordered) if pair[0].acceptable != pair[1].acceptable]
