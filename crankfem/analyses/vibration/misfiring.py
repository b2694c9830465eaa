"""Misfiring compared with normal firing: the worst cylinder, by superposition of the chains' responses."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Annotated, Any, TypeAlias

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError
from crankbase.frames import Row, table_of
from crankbase.results import Flat, InItsUnit, Internal, Part, Quantity, Result, Speed, result
from crankbase.sentences import joined
from crankfem.analyses.vibration.chain_answers import ChainAnswer, EngineChains, cause_at
from crankfem.analyses.vibration.engine_excitation import (
    calculated_speeds,
    failing_harmonics,
    forces_over_speeds,
)
from crankfem.analyses.vibration.engine_limits import (
    at_place,
    compared_quantities,
    compared_series,
    limited_quantities,
)
from crankfem.files.engine.engine_file import EngineFile
from dynamics import wording
from dynamics.assessment.barred_ranges import is_usable
from dynamics.assessment.limits import VibrationLimit
from dynamics.assessment.response_curves import (
    largest_amplitude,
    refined_maxima,
    speeds_above,
)
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics, forces_at_speeds
from dynamics.indices import within
from dynamics.response.peak_cause import PeakCause
from dynamics.response.series import OrderSeries

DIGITS = 3
# Numbers of cylinders that fail together, from 1.
Cylinders = tuple[int, ...]
SpeedRanges: TypeAlias = Annotated[
    tuple[tuple[float, float], ...], Quantity("rad/s", exported="1/min")
]


@result("place", "speed", "value", "permitted", "used", eq=True)
class Reached(Result):
    """The worst of a quantity at running speeds.

    Attributes
    ----------
    place : str
        Node or element.
    value : float
        Amplitude, all orders together, in the quantity's unit; inf where unbounded.
    permitted : float
        At this speed; inf where no limit is stated.
    """

    place: str
    speed: Speed
    value: InItsUnit
    permitted: InItsUnit

    @property
    def used(self) -> float:
        """Share of the permitted amplitude; 0 where no limit is stated."""
        return self.used_share or 0.0

    @property
    def used_share(self) -> Annotated[float | None, Quantity("1", key="used")]:
        """The same; None where no limit is stated."""
        return None if np.isinf(self.permitted) else self.value / self.permitted

    @property
    def severity(self) -> tuple[float, float]:
        """Measure for the comparison of cases: the used share, and without a limit the value."""
        return self.used, self.value


@result("cylinders", "reached", eq=True)
class Failing(Result):
    """The worst of a quantity while cylinders misfire."""

    cylinders: Annotated[Cylinders, Quantity("1")]
    reached: Flat[Reached]


@result("cylinders", "reached", eq=True)
class NewlyExceeded(Failing):
    """The worst of a limit that misfiring exceeds at speeds at which normal firing keeps it."""

    cause: Internal[PeakCause]

    @cached_property
    def reasons(self) -> Annotated[str, Quantity(key="cause")]:
        """The cause in words."""
        return self.cause.reasons


@result("quantity", "unit", "normal", "cylinders", "misfiring")
class FiringCheck(Result):
    """One quantity in normal firing, and in the worst case of misfiring.

    Attributes
    ----------
    quantity : str
        For example "torsional stress of crankshaft".
    unit : str
        SI unit of the values.
    normal : Reached
        With all cylinders firing, compared with the limit for continuous running.
    cylinders : tuple of int
        Failing cylinders in the worst case.
    misfiring : Reached
        In the worst case, compared with the limit while misfiring, `VibrationLimit.misfiring`.
    each : dict
        Cylinders whose failing is then worst.
    over_speed : tuple of three (S,) arrays, or None
        Running speeds [rad/s], and at the place of `misfiring` the amplitude with all cylinders firing
        and in the worst case; of the stress that uses its limit most alone.
    new : NewlyExceeded or None
        What misfiring alone exceeds.
    """

    quantity: str
    unit: str
    limit: Internal[VibrationLimit | None]
    normal: Reached
    cylinders: Annotated[Cylinders, Quantity("1")]
    misfiring: Reached
    each: Internal[Mapping[Cylinders, Reached]]
    over_speed: Internal[tuple[Array, Array, Array] | None] = None
    new: NewlyExceeded | None = None

    @cached_property
    def source(self) -> Part[str | None]:
        """That of the limit, if any."""
        return None if self.limit is None else self.limit.source

    @cached_property
    def assumed(self) -> Part[bool]:
        """Whether the limit is assumed."""
        return self.limit is not None and self.limit.assumed

    @cached_property
    def verdict(self) -> Annotated[bool | None, Quantity(key="passed")]:
        """As `passed`; None without a limit."""
        return None if self.limit is None else self.passed

    @cached_property
    def basis(self) -> Part[str | None]:
        """Why the limit for passing serves while a cylinder misfires; empty if it does not."""
        return None if self.limit is None else self.limit.misfiring_basis

    @cached_property
    def cases(self) -> Annotated[list[Failing], Quantity(key="each")]:
        """The worst of each case."""
        return [Failing(*case) for case in self.each.items()]

    @property
    def passed(self) -> bool:
        """Whether the limit while misfiring is kept at running speeds."""
        return self.misfiring.used <= 1.0

    @property
    def sentence(self) -> str:
        """The finding while misfiring by both limits, with normal firing for comparison."""
        return f"{self._finding(self.cylinders, self.misfiring)}."

    @property
    def news(self) -> str:
        """What misfiring alone exceeds, with its cause; empty if nothing."""
        if self.new is None:
            return ""
        reached = self.new.reached
        finding = self._finding(self.new.cylinders, reached)
        kept_at = None if self.normal_keeps else reached.speed
        return wording.exceeded_alone(finding, kept_at, self.new.cause.reasons)

    @property
    def normal_keeps(self) -> bool:
        """Whether normal firing keeps the limit at all running speeds."""
        return self.normal.used <= 1.0

    def _finding(self, cylinders: Cylinders, reached: Reached) -> str:
        normal, limit, unit = self.normal, self.limit, self.unit
        value, permitted, speed = reached.value, reached.permitted, reached.speed
        if limit is None or np.isinf(permitted):
            use = f"at most {wording.amount_at(value, unit, speed)}"
        else:
            use = wording.use_in_words(unit, speed, value, permitted, DIGITS)
            use += self._by_the_other(limit, reached)
        beside = wording.amount_at(normal.value, unit, normal.speed)
        if not np.isinf(normal.permitted) and not np.isinf(normal.value):
            shown = np.inf if np.isinf(value) else permitted
            beside += wording.normal_share(normal.used, normal.permitted, shown, unit)
        if normal.place != reached.place:
            beside += f", {normal.place}"
        where = wording.limit_at(self.quantity, reached.place)
        return wording.use_while_misfiring(where, cylinders, use, beside)

    def _by_the_other(self, limit: VibrationLimit, reached: Reached) -> str:
        """Write the share of the limit that does not decide, if there is one."""
        if limit.passing is None:
            return ""
        at = np.array([reached.speed])
        passing, kept = float(limit.passing.at(at)[0]), float(limit.continuous.at(at)[0])
        if np.isinf(passing) or passing == kept:
            return ""
        other = kept if limit.misfiring_basis else passing
        return wording.other_limit(reached.value, other, self.unit, limit.misfiring_basis)

    def row(self) -> Row:
        """Return the columns of a table, each value with its unit; see `table_of`."""
        cells: Row = {"quantity": (self.quantity, ""), "unit": (self.unit, "")}
        for name, reached in (("normal", self.normal), ("misfiring", self.misfiring)):
            cells |= {
                f"{name}_place": (reached.place, ""),
                f"{name}_speed": (reached.speed, "rad/s"),
                f"{name}_value": (reached.value, "SI, see the column unit"),
                f"{name}_permitted": (reached.permitted, "SI, see the column unit"),
                f"{name}_used": (reached.used, "1"),
            }
        return cells | {"cylinders": (wording.cylinders_named(self.cylinders), "")}


def permitted_at(limit: VibrationLimit | None, speeds: Array) -> Array:
    """Return the permitted values at speeds [rad/s]; inf where none is stated, or without a limit."""
    if limit is None:
        return np.full(speeds.shape, np.inf)
    return limit.continuous.at(speeds)


def weights(limit: VibrationLimit | None, speeds: Array) -> Array:
    """Return the reciprocal of the permitted value at each speed; without a limit one everywhere."""
    return np.ones(speeds.shape) if limit is None else 1.0 / permitted_at(limit, speeds)


def worst_of(
    series: OrderSeries, limit: VibrationLimit | None, among: Flags | None = None
) -> Reached:
    """Return the worst of a quantity: where most of a limit is used, or the largest without one.

    Parameters
    ----------
    among : (S,) array of bool, optional
        The speeds that count.
    """
    counted = weights(limit, series.speeds) * (1.0 if among is None else among)
    value, speed, place = largest_amplitude(series, counted)
    permitted = permitted_at(limit, series.speeds[[speed]])
    return Reached(
        place=series.names[place],
        speed=float(series.speeds[speed]),
        value=value,
        permitted=float(permitted[0]),
    )


# What adds up of the forces of cylinders.
SUMMED = ("tangential", "radial", "mean_tangential", "mean_radial")
# Speeds that leave a smaller share of the speed between them leave none to run at.
NARROW = 5e-3
# An end of a range is sought at so many speeds between two calculated ones, and so often closer.
PARTS, ROUNDS = 16, 3
# Share of a limit by which misfiring uses more of it than normal firing, where that counts as new.
NEWS = 0.1
# By the key of `compared_quantities`.
Series = dict[str, OrderSeries]
Found = dict[str, dict[Cylinders, Reached]]


@result("cases", "missing_share", "compression", "checks", "exceeded", "remarks")
class Misfiring(Result):
    """Worst vibration while cylinders misfire, and in normal firing, at running speeds.

    Attributes
    ----------
    cases : tuple of tuples of int
        Numbers of the cylinders that fail together, a tuple for each calculated case.
    missing_share : float
        Share of the combustion that is missing in each of them.
    compression : bool
        Whether they still compress.
    checks : tuple of FiringCheck
        Each quantity with its own worst case, those with a limit first: what normal firing keeps and
        misfiring exceeds, then the worst use.
    exceeded : tuple of pairs of floats
        Ranges of running speeds in which a limit while misfiring is exceeded in any of the cases, from where
        it is met to where it is met again [rad/s].
    remaining : tuple of pairs of floats
        Ranges of running speeds in which all limits are kept, in these cases and in normal firing, and
        nothing is barred [rad/s].
    running_range : tuple of two floats
        [rad/s].
    """

    cases: Annotated[tuple[Cylinders, ...], Quantity("1")]
    missing_share: Annotated[float, Quantity("1")]
    compression: bool
    checks: tuple[FiringCheck, ...]
    exceeded: SpeedRanges
    remaining: SpeedRanges
    running_range: Annotated[
        tuple[float, float], Quantity("rad/s", exported="1/min", key="running_rpm")
    ]

    @cached_property
    def otherwise(self) -> Annotated[SpeedRanges, Quantity("rad/s", exported="1/min")]:
        """Further speeds that do not remain: limits are exceeded, or they are to be barred, anyway."""
        taken = sorted((*self.exceeded, *self.remaining))
        return _between(_joined(taken), self.running_range)

    @cached_property
    def advised(self) -> Annotated[SpeedRanges, Quantity("rad/s", exported="1/min")]:
        """Those of the ranges that remain in which an engine can be kept."""
        return tuple(span for span in self.remaining if is_usable(span, self.running_range))

    @property
    def worst(self) -> FiringCheck:
        """The quantity whose limit misfiring alone exceeds most, or that with the largest use."""
        return self.checks[0]

    @property
    def of_stress(self) -> FiringCheck | None:
        """That of the stress, of crankshaft or shaft line, of whose limit most is used."""
        return next((check for check in self.checks if check.over_speed is not None), None)

    @cached_property
    def passed(self) -> Part[bool]:
        """Whether all limits while misfiring are kept at running speeds."""
        return self.worst.passed

    @cached_property
    def sentence(self) -> Part[str]:
        """What misfiring alone exceeds, the largest use of a limit, and the speeds that remain."""
        if not self.exceeded:
            return self.worst.sentence
        # What normal firing keeps at all speeds comes first; then the largest use, and further speeds.
        first = self.worst.news if self.worst.normal_keeps else ""
        most = max(self.checks, key=lambda check: check.misfiring.used)
        newest = most.new is not None and most.new.reached is most.misfiring
        sentences = [first, "" if newest else most.sentence]
        sentences.append("" if most.normal_keeps and most is self.worst else most.news)
        who = self.cases[0] if len(self.cases) == 1 else ()
        sentences.append(wording.speeds_while_misfiring(who, self.exceeded, self.restriction))
        return joined(" ", filter(None, sentences))

    @property
    def restriction(self) -> str:
        """Where to run then, without its full stop."""
        return wording.restricted_running(self.advised, self.remaining, self.otherwise)

    @cached_property
    def remarks(self) -> Part[tuple[str, ...]]:
        """Assumptions, a sentence each."""
        bases = {check.limit.misfiring_basis for check in self.checks if check.limit is not None}
        share, still = self.missing_share, self.compression
        return wording.misfiring_assumed(self.cases, share, still, "".join(bases))

    def outside(self, barred: Sequence[tuple[float, float]]) -> "Misfiring":
        """Return the same with no speed that remains in ranges barred in normal firing [rad/s]."""
        left = self.remaining
        for low, high in barred:
            parts = (
                part
                for kept in left
                for part in ((kept[0], min(kept[1], low)), (max(kept[0], high), kept[1]))
            )
            left = tuple(part for part in parts if part[1] > part[0] * (1.0 + NARROW))
        return replace(self, remaining=left)

    def to_pandas(self) -> Any:
        """Return a table with a row for each quantity: normal firing and misfiring side by side.

        Units are in ``frame.attrs["units"]``.
        """
        return table_of(self.checks)


def misfiring_or_reason(
    chains: EngineChains, harmonics: CylinderHarmonics
) -> tuple[Misfiring | None, str]:
    """Calculate the vibration while cylinders misfire; without a section [misfire] each one in turn.

    Returns
    -------
    reason : str
        Why it was not calculated, or "".

    Raises
    ------
    InputError
        If the file has a section [misfire] and the pressure without combustion is unknown.
    """
    file = chains.engine_file
    if file.engine.driven_by:
        return None, "misfiring is not calculated: nothing fires in a driven machine"
    try:
        failing = failing_harmonics(file, harmonics)
    except InputError as error:
        if file.misfire is not None:
            raise
        return None, f"misfiring is not calculated: {error}"
    engine = file.engine
    speeds = calculated_speeds(file, harmonics.orders, chains.damped)
    running = speeds[within(speeds, engine.lowest_speed, engine.highest_speed)]
    return _misfiring(Superposition(chains, harmonics, failing), running), ""


@dataclass(frozen=True, eq=False)
class Superposition:
    """Adds the effect of missing combustion to normal firing, as chains are linear.

    Attributes
    ----------
    firing, failing : CylinderHarmonics
        Of cylinders that fire, and of cylinders without combustion.
    series : callable, optional
        To be superposed: engine file, responses of the axial and of the torsional chain to series by key.
    """

    chains: EngineChains
    firing: CylinderHarmonics
    failing: CylinderHarmonics
    series: Callable[[EngineFile, ChainAnswer, ChainAnswer], Series] = compared_series

    def at(self, speeds: Array, cases: Iterable[Cylinders]) -> Iterator[tuple[Cylinders, Series]]:
        """Return the series in each case; without a failing cylinder firing is normal."""
        file = self.chains.engine_file
        forces = forces_over_speeds(file, self.firing, speeds)
        normal = self.series(file, *self.chains.answers(forces))
        for case in cases:
            if not case:
                yield case, normal
                continue
            missing = self._missing(forces, case)
            change = self.series(file, *self.chains.answers(missing, propeller=False))
            yield case, {key: _sum(normal[key], missed) for key, missed in change.items()}

    def of(self, speeds: Array, case: Cylinders) -> Series:
        """Return the series in one case, of the forces together."""
        answers = self.chains.answers(self.forces(speeds, case))
        return self.series(self.chains.engine_file, *answers)

    def forces(self, speeds: Array, case: Cylinders) -> CylinderForces:
        """Return the forces of all cylinders at speeds [rad/s] in a case."""
        firing = forces_over_speeds(self.chains.engine_file, self.firing, speeds)
        if not case:
            return firing
        missing = self._missing(firing, case)
        return replace(
            firing, **{name: getattr(firing, name) + getattr(missing, name) for name in SUMMED}
        )

    def _missing(self, forces: CylinderForces, case: Cylinders) -> CylinderForces:
        """Return the change of forces by the missing combustion of some cylinders."""
        misfire = self.chains.engine_file.misfire
        # There is no load to ask for: where nothing burns a single diagram serves, or none.
        cold = forces_at_speeds(self.failing, forces.speeds)
        factors = np.zeros(len(forces.throws))
        factors[[number - 1 for number in case]] = 1.0 if misfire is None else misfire.missing_share
        changed = {name: factors * (getattr(cold, name) - getattr(forces, name)) for name in SUMMED}
        return replace(forces, **changed)


def misfiring_cases(engine_file: EngineFile) -> tuple[Cylinders, ...]:
    """Return the cylinders that fail together in each case: those of the file, else each in turn."""
    misfire = engine_file.misfire
    if misfire is not None and misfire.cylinders is not None:
        return (misfire.cylinders,)
    return tuple((number + 1,) for number in range(engine_file.engine.cylinders))


def _misfiring(added: Superposition, speeds: Array) -> Misfiring:
    """Find the worst case of each quantity, and its speed closer than the grid."""
    file = added.chains.engine_file
    misfire, cases = file.misfire, misfiring_cases(file)
    quantities = compared_quantities(file)
    each: Found = {}
    none = np.zeros(speeds.shape, dtype=bool)
    exceeded, unkept = none, none
    kept: dict[str, Flags] = {}
    alone: dict[str, tuple[Reached, Cylinders]] = {}
    stresses: dict[tuple[str, Cylinders], OrderSeries] = {}
    for case, case_series in added.at(speeds, [(), *cases]):
        for key, series in case_series.items():
            limit = quantities[key].while_firing(case)
            each.setdefault(key, {})[case] = worst_of(series, limit)
            if quantities[key].unit == "Pa":
                stresses[key, case] = series
            if limit is None:
                continue
            if not case:
                above = speeds_above(series, weights(limit, speeds), none)
                kept[key], unkept = ~above, unkept | above
                continue
            exceeded = speeds_above(series, weights(limit, speeds), exceeded)
            reached = worst_of(series, limit, kept[key])
            if key not in alone or reached.used > alone[key][0].used:
                alone[key] = reached, case
    _refine(added, speeds, each)
    worst = {
        key: max(cases, key=lambda case: by_case[case].severity) for key, by_case in each.items()
    }
    drawn = max(
        dict.fromkeys(key for key, _ in stresses),
        key=lambda key: each[key][worst[key]].used,
        default=None,
    )
    checks = []
    for key, by_case in each.items():
        case, over_speed = worst[key], None
        if key == drawn:
            firing, failing = (
                at_place(stresses[key, out], by_case[case].place).synthesis.amplitude[:, 0]
                for out in ((), case)
            )
            over_speed = stresses[key, ()].speeds, firing, failing
        checks.append(
            FiringCheck(
                quantity=quantities[key].name,
                unit=quantities[key].unit,
                limit=quantities[key].limit,
                normal=by_case[()],
                cylinders=case,
                misfiring=by_case[case],
                each={out: reached for out, reached in by_case.items() if out},
                over_speed=over_speed,
                new=_new(added, key, by_case, case, alone.get(key)),
            )
        )
    while_failing, normal = (
        _ranges(speeds, flags, _crossings(partial(_exceeded, added, of), speeds, flags))
        for flags, of in ((exceeded, cases), (unkept, [()]))
    )
    running = (float(speeds[0]), float(speeds[-1]))
    return Misfiring(
        cases=cases,
        missing_share=1.0 if misfire is None else misfire.missing_share,
        compression=misfire is None or misfire.compression,
        # Limits before what has none, and first what normal firing keeps and misfiring exceeds.
        checks=tuple(
            sorted(
                checks,
                key=lambda check: (
                    check.limit is None,
                    check.new is None or not check.normal_keeps,
                    -check.misfiring.used,
                ),
            )
        ),
        exceeded=while_failing,
        remaining=_between(_joined(sorted((*while_failing, *normal))), running),
        running_range=running,
    )


def _exceeded(added: Superposition, cases: Sequence[Cylinders], speeds: Array) -> Flags:
    """Return at which speeds a limit is exceeded in any of the cases."""
    quantities = compared_quantities(added.chains.engine_file)
    above = np.zeros(speeds.shape, dtype=bool)
    for case, case_series in added.at(speeds, cases):
        for key, series in case_series.items():
            limit = quantities[key].while_firing(case)
            if limit is not None:
                above = speeds_above(series, weights(limit, speeds), above)
    return above


def _crossings(
    exceeded_at: Callable[[Array], Flags],
    speeds: Array,
    flags: Flags,
) -> dict[int, float]:
    """Return the speeds at which flags change, by the index of the calculated speed before each."""
    places = np.flatnonzero(flags[1:] != flags[:-1])
    if not places.size:
        return {}
    low, high, before = speeds[places], speeds[places + 1], flags[places]
    steps = np.arange(1, PARTS) / PARTS
    for _ in range(ROUNDS):
        tried = low[:, np.newaxis] + (high - low)[:, np.newaxis] * steps
        asked = np.unique(tried)
        flagged = exceeded_at(asked)[np.searchsorted(asked, tried)]
        bounds = np.column_stack((low, tried, high))
        # The first change, as there may be several.
        changed = np.column_stack((flagged != before[:, np.newaxis], np.ones(len(low), dtype=bool)))
        first, row = np.argmax(changed, axis=1), np.arange(len(low))
        low, high = bounds[row, first], bounds[row, first + 1]
    return dict(zip(places.tolist(), (0.5 * (low + high)).tolist(), strict=True))


def _new(
    added: Superposition,
    key: str,
    each: Mapping[Cylinders, Reached],
    worst: Cylinders,
    alone: tuple[Reached, Cylinders] | None,
) -> NewlyExceeded | None:
    """Return the worst that misfiring alone exceeds, with its cause, where normal firing is well below."""
    if alone is None:
        return None
    file = added.chains.engine_file
    # The worst is known more closely, and counts unless normal firing exceeds the limit there too.
    for reached, case in ((each[worst], worst), alone):
        if not reached.used > 1.0 or np.isinf(reached.value):
            continue
        at = np.array([reached.speed])
        answers = {firing: added.chains.answers(added.forces(at, firing)) for firing in ((), case)}
        series = {firing: added.series(file, *answer)[key] for firing, answer in answers.items()}
        normal = at_place(series[()], reached.place).synthesis.amplitude[0, 0] / reached.permitted
        if normal <= 1.0:
            break
    else:
        return None
    if reached.used - normal < NEWS:
        return None
    lengthened, twisted = answers[case]
    answer = lengthened if limited_quantities(file)[key].kind == "axial" else twisted
    unit = compared_quantities(file)[key].unit
    cause = cause_at(answer, twisted, series[case], reached.place, reached.speed, unit)
    return NewlyExceeded(case, reached, cause)


def _between(
    ranges: Sequence[tuple[float, float]], ends: tuple[float, float]
) -> tuple[tuple[float, float], ...]:
    """Return what is left of the running range between ranges, where an engine can run."""
    stops = (ends[0], *(high for _, high in ranges))
    starts = (*(low for low, _ in ranges), ends[1])
    pairs = zip(stops, starts, strict=True)
    return tuple((float(low), float(high)) for low, high in pairs if high > low * (1.0 + NARROW))


def _ranges(
    speeds: Array, flags: Flags, crossings: Mapping[int, float]
) -> tuple[tuple[float, float], ...]:
    """Return the ranges of flagged speeds, each from the crossing before it to the one behind it."""
    edges = np.diff(np.concatenate(([0], flags.astype(int), [0])))
    first, last = float(speeds[0]), float(speeds[-1])
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return _joined(
        (crossings.get(start - 1, first), crossings.get(stop - 1, last))
        for start, stop in zip(starts.tolist(), stops.tolist(), strict=True)
    )


def _joined(ranges: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Join ascending ranges between which no engine can run, as they leave less than `NARROW`."""
    joined: list[tuple[float, float]] = []
    for low, high in ranges:
        if joined and low <= joined[-1][1] * (1.0 + NARROW):
            before = joined.pop()
            joined.append((before[0], max(before[1], high)))
        else:
            joined.append((low, high))
    return tuple(joined)


def _refine(added: Superposition, speeds: Array, each: Found) -> None:
    """Find the worst speeds of all cases, with normal firing, between their neighbors."""
    quantities = compared_quantities(added.chains.engine_file)
    for case in dict.fromkeys(case for by_case in each.values() for case in by_case):
        best = {key: by_case[case] for key, by_case in each.items()}
        limits = {key: quantities[key].while_firing(case) for key in best}

        def used(
            some: Array,
            case: Cylinders = case,
            best: Mapping[str, Reached] = best,
            limits: Mapping[str, VibrationLimit | None] = limits,
        ) -> Array:
            case_series = added.of(some, case)
            rows = []
            for key, reached in best.items():
                amplitudes = at_place(case_series[key], reached.place).synthesis.amplitude[:, 0]
                rows.append(
                    np.where(np.isfinite(amplitudes), amplitudes * weights(limits[key], some), 0.0)
                )
            return np.array(rows)

        tops = np.searchsorted(speeds, [reached.speed for reached in best.values()])
        near = np.unique(np.clip([tops - 1, tops, tops + 1], 0, speeds.size - 1))
        closer = np.union1d(refined_maxima(used, speeds[near]), speeds[tops])
        case_series = added.of(closer, case)
        for key, limit in limits.items():
            each[key][case] = worst_of(case_series[key], limit)


def _sum(order_series: OrderSeries, other: OrderSeries) -> OrderSeries:
    """Return the sum of two series; a propeller's orders may be missing in the second."""
    places = np.searchsorted(order_series.orders, other.orders)
    values, unbounded = order_series.values.copy(), order_series.unbounded.copy()
    values[places] += other.values
    unbounded[places] |= other.unbounded
    return replace(order_series, values=values, unbounded=unbounded)
