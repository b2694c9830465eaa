"""Misfiring compared with normal firing: the worst cylinder, by superposition of the chains' responses."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table_of
from crankfem.analyses.vibration.chain_answers import ChainAnswer, EngineChains, cause_at
from crankfem.analyses.vibration.engine_excitation import (
    calculated_speeds,
    failing_harmonics,
    forces_over_speeds,
)
from crankfem.analyses.vibration.engine_limits import (
    compared_quantities,
    compared_series,
    of_stress,
)
from crankfem.analyses.vibration.firing_check import (
    Cylinders,
    FiringCheck,
    NewlyExceeded,
    Reached,
    named,
    weights,
    worst_of,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile
from dynamics.assessment.response_curves import NEARLY_LARGEST, refined_maxima, speeds_above
from dynamics.assessment.wording import shown_range
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics, forces_at_speeds
from dynamics.indices import within
from dynamics.response.series import OrderSeries

# What adds up of the forces of cylinders.
SUMMED = ("tangential", "radial", "mean_tangential", "mean_radial")
# Speeds that leave a smaller share of the speed between them leave none to run at.
NARROW = 5e-3
# Share of a limit by which misfiring uses more of it than normal firing, where that counts as new.
NEWS = 0.1
# By the key of `compared_quantities`.
Series = dict[str, OrderSeries]
Found = dict[str, dict[Cylinders, Reached]]


@summarized("cases", "missing_share", "compression", "checks", "exceeded [rad/s]", "remarks")
@dataclass(frozen=True, eq=False)
class Misfiring:
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
        Ranges of running speeds in which a limit while misfiring is exceeded in any of the cases, each
        widened to the next speeds at which all are kept [rad/s].
    remaining : tuple of pairs of floats
        Ranges of running speeds in which all limits are kept, in these cases and in normal firing, and
        nothing is barred [rad/s].
    """

    cases: tuple[Cylinders, ...]
    missing_share: float
    compression: bool
    checks: tuple[FiringCheck, ...]
    exceeded: tuple[tuple[float, float], ...]
    remaining: tuple[tuple[float, float], ...]

    @property
    def worst(self) -> FiringCheck:
        """The quantity whose limit misfiring alone exceeds most, or that with the largest use."""
        return self.checks[0]

    @property
    def of_stress(self) -> FiringCheck | None:
        """That of the stress, of crankshaft or shaft line, of whose limit most is used."""
        return next((one for one in self.checks if one.over_speed is not None), None)

    @property
    def passed(self) -> bool:
        """Whether all limits while misfiring are kept at running speeds."""
        return self.worst.passed

    @property
    def sentence(self) -> str:
        """What misfiring alone exceeds, the largest use of a limit, and the speeds that remain."""
        if not self.exceeded:
            return self.worst.sentence
        # What normal firing keeps at all speeds comes first; then the largest use, and further speeds.
        first = self.worst.news if self.worst.normal_keeps else ""
        most = max(self.checks, key=lambda one: one.misfiring.used)
        told = [first] if first and most is self.worst else [first, most.sentence]
        told.append("" if most.normal_keeps else most.news)
        who = named(self.cases[0]) if len(self.cases) == 1 else "a cylinder"
        keeps = (
            f"restrict running to {_listed(self.remaining)} then"
            if self.remaining
            else "no running speed keeps them"
        )
        told.append(
            f"While {who} misfires, limits are exceeded from {_listed(self.exceeded)}: {keeps}."
        )
        return " ".join(filter(None, told))

    @property
    def remarks(self) -> tuple[str, ...]:
        """Assumptions, a sentence each."""
        one = len(self.cases) == 1
        which = named(self.cases[0]) if one else f"each of {len(self.cases)} cylinders in turn"
        share = 100.0 * self.missing_share
        still = "compression stays" if self.compression else "compression is missing as well"
        return (
            f"misfiring of {which}: {share:.3g} % of the combustion is missing, {still}; the others fire as "
            "before, so the mean torque is lower",
            f"while misfiring, {self._basis}; only running speeds are judged",
        )

    @property
    def _basis(self) -> str:
        """Which limit decides, in words."""
        bases = {one.limit.misfiring_basis for one in self.checks if one.limit is not None}
        if basis := "".join(bases):
            return f"the limit for passing serves where stated, by {basis}, elsewhere the continuous one"
        return (
            "the limits of continuous running decide; those for passing serve only where the class or the "
            "maker says so, with limits.passing_while_misfiring"
        )

    def outside(self, barred: Sequence[tuple[float, float]]) -> "Misfiring":
        """Return the same with no speed that remains in ranges barred in normal firing [rad/s]."""
        left = self.remaining
        for low, high in barred:
            parts = (
                part
                for own in left
                for part in ((own[0], min(own[1], low)), (max(own[0], high), own[1]))
            )
            left = tuple(part for part in parts if part[1] > part[0] * (1.0 + NARROW))
        return replace(self, remaining=left)

    def to_pandas(self) -> Any:
        """Return a table with a row for each quantity: normal firing and misfiring side by side.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``; values are in the unit that the row names.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.checks)


def misfiring_or_reason(
    chains: EngineChains, mechanism: MechanismFile, harmonics: CylinderHarmonics
) -> tuple[Misfiring | None, str]:
    """Calculate the vibration while cylinders misfire; without a section [misfire] each one in turn.

    Parameters
    ----------
    chains : EngineChains
    mechanism : MechanismFile
    harmonics : CylinderHarmonics
        Of normal firing.

    Returns
    -------
    misfiring : Misfiring or None
    reason : str
        Why it was not calculated, or "".

    Raises
    ------
    InputError
        If the file has a section [misfire] and the pressure without combustion is unknown.
    """
    file = chains.engine_file
    try:
        failing = failing_harmonics(file, mechanism, harmonics)
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
    chains : EngineChains
    firing, failing : CylinderHarmonics
        Of cylinders that fire, and of cylinders without combustion.
    series : callable, optional
        To be superposed: engine file, responses of the axial and of the torsional chain to series by key.
    """

    chains: EngineChains
    firing: CylinderHarmonics
    failing: CylinderHarmonics
    series: Callable[[EngineFile, ChainAnswer, ChainAnswer], Series] = compared_series

    def at(
        self, speeds: FloatArray, cases: Iterable[Cylinders]
    ) -> Iterator[tuple[Cylinders, Series]]:
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
            yield case, {key: _sum(normal[key], own) for key, own in change.items()}

    def forces(self, speeds: FloatArray, case: Cylinders) -> CylinderForces:
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
        given = self.chains.engine_file.misfire
        # There is no load to ask for: where nothing burns a single diagram serves, or none.
        cold = forces_at_speeds(self.failing, forces.speeds)
        return _difference(forces, cold, case, 1.0 if given is None else given.missing_share)


def misfiring_cases(engine_file: EngineFile) -> tuple[Cylinders, ...]:
    """Return the cylinders that fail together in each case: those of the file, else each in turn."""
    given = engine_file.misfire
    if given is not None and given.cylinders is not None:
        return (given.cylinders,)
    return tuple((number + 1,) for number in range(engine_file.engine.cylinders))


def _misfiring(added: Superposition, speeds: FloatArray) -> Misfiring:
    """Find the worst case of each quantity, and its speed closer than the grid."""
    file = added.chains.engine_file
    given, cases = file.misfire, misfiring_cases(file)
    quantities = compared_quantities(file)
    each: Found = {}
    none = np.zeros(speeds.shape, dtype=bool)
    exceeded, unkept = none, none
    kept: dict[str, NDArray[np.bool_]] = {}
    alone: dict[str, tuple[Reached, Cylinders]] = {}
    for case, found in added.at(speeds, [(), *cases]):
        for key, series in found.items():
            limit = quantities[key].while_firing(case)
            each.setdefault(key, {})[case] = worst_of(series, limit)
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
    worst = {key: max(cases, key=lambda case: own[case].severity) for key, own in each.items()}
    drawn = max(filter(of_stress, each), key=lambda key: each[key][worst[key]].used, default=None)
    checks = [
        FiringCheck(
            quantity=quantities[key].name,
            unit=quantities[key].unit,
            limit=quantities[key].limit,
            normal=own[()],
            cylinders=worst[key],
            misfiring=own[worst[key]],
            each={case: one for case, one in own.items() if case},
            over_speed=_over_speed(added, speeds, key, worst[key], own[worst[key]].place)
            if key == drawn
            else None,
            new=_new(added, key, own, worst[key], alone.get(key)),
        )
        for key, own in each.items()
    ]
    return Misfiring(
        cases=cases,
        missing_share=1.0 if given is None else given.missing_share,
        compression=given is None or given.compression,
        checks=tuple(sorted(checks, key=_rank)),
        exceeded=_ranges(speeds, exceeded),
        remaining=_between(_ranges(speeds, exceeded | unkept), (speeds[0], speeds[-1])),
    )


def _rank(check: FiringCheck) -> tuple[bool, bool, float]:
    """Rank limits before what has none, and what normal firing keeps and misfiring exceeds first."""
    broken = check.new is not None and check.normal_keeps
    return check.limit is None, not broken, -check.misfiring.used


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
    # Where normal firing keeps the limit at all speeds, the worst is known more closely.
    reached, case = (each[worst], worst) if each[()].used <= 1.0 else alone
    file, at = added.chains.engine_file, np.array([reached.speed])
    if not reached.used > 1.0 or np.isinf(reached.value):
        return None
    answers = {own: added.chains.answers(added.forces(at, own)) for own in ((), case)}
    series = {own: added.series(file, *found)[key] for own, found in answers.items()}
    normal = at_place(series[()], reached.place).synthesis.amplitude[0, 0]
    if reached.used - normal / reached.permitted < NEWS:
        return None
    lengthened, twisted = answers[case]
    answer = lengthened if key.startswith("axial") else twisted
    unit = compared_quantities(file)[key].unit
    cause = cause_at(answer, twisted, series[case], reached.place, reached.speed, unit)
    return NewlyExceeded(case, reached, cause)


def _listed(ranges: Sequence[tuple[float, float]]) -> str:
    """Write ranges of speeds one after the other."""
    shown = [shown_range(*one) for one in ranges]
    return " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def _between(
    ranges: Sequence[tuple[float, float]], ends: tuple[float, float]
) -> tuple[tuple[float, float], ...]:
    """Return what is left of the running range between ranges, where an engine can run."""
    stops = (ends[0], *(high for _, high in ranges))
    starts = (*(low for low, _ in ranges), ends[1])
    pairs = zip(stops, starts, strict=True)
    return tuple((float(low), float(high)) for low, high in pairs if high > low * (1.0 + NARROW))


def _over_speed(
    added: Superposition, speeds: FloatArray, key: str, case: Cylinders, place: str
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return speeds, and the amplitude at a place in normal firing and in one case of misfiring."""
    normal, failing = (
        at_place(found[key], place).synthesis.amplitude[:, 0]
        for _, found in added.at(speeds, [(), case])
    )
    return speeds, normal, failing


def _ranges(speeds: FloatArray, flags: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Return the ranges of flagged speeds, each widened to the next speeds that are not.

    Ranges between which no engine can run, as they leave less than `NARROW`, are one.
    """
    edges = np.diff(np.concatenate(([0], flags.astype(int), [0])))
    last = speeds.size - 1
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    found: list[tuple[float, float]] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        low, high = float(speeds[max(start - 1, 0)]), float(speeds[min(stop, last)])
        if found and low <= found[-1][1] * (1.0 + NARROW):
            low = found.pop()[0]
        found.append((low, high))
    return tuple(found)


def _refine(added: Superposition, speeds: FloatArray, each: Found) -> None:
    """Find the worst speeds of normal firing and of the worst cases between their neighbors."""
    quantities = compared_quantities(added.chains.engine_file)
    pairs = []
    for key, own in each.items():
        most = max(one.severity for case, one in own.items() if case)
        near_worst = tuple(NEARLY_LARGEST * size for size in most)
        pairs += [
            (key, case) for case, one in own.items() if not case or one.severity >= near_worst
        ]
    cases = list(dict.fromkeys(case for _, case in pairs))
    best = {pair: each[pair[0]][pair[1]] for pair in pairs}

    def used(some: FloatArray) -> FloatArray:
        found = dict(added.at(some, cases))
        rows = []
        for key, case in pairs:
            own = at_place(found[case][key], best[key, case].place).synthesis.amplitude[:, 0]
            factors = weights(quantities[key].while_firing(case), some)
            rows.append(np.where(np.isfinite(own), own * factors, 0.0))
        return np.array(rows)

    tops = np.searchsorted(speeds, [one.speed for one in best.values()])
    near = np.unique(np.clip([tops - 1, tops, tops + 1], 0, speeds.size - 1))
    closer = np.union1d(refined_maxima(used, speeds[near]), speeds[tops])
    for case, found in added.at(closer, cases):
        for key, of in pairs:
            if of == case:
                each[key][case] = worst_of(found[key], quantities[key].while_firing(case))


def _difference(
    firing: CylinderForces, cold: CylinderForces, case: Cylinders, share: float
) -> CylinderForces:
    """Return the change by a missing share of the combustion in some cylinders."""
    factors = np.zeros(len(firing.throws))
    factors[[number - 1 for number in case]] = share
    changed = {name: factors * (getattr(cold, name) - getattr(firing, name)) for name in SUMMED}
    return replace(firing, **changed)


def _sum(one: OrderSeries, other: OrderSeries) -> OrderSeries:
    """Return the sum of two series; a propeller's orders may be missing in the second."""
    places = np.searchsorted(one.orders, other.orders)
    values, unbounded = one.values.copy(), one.unbounded.copy()
    values[places] += other.values
    unbounded[places] |= other.unbounded
    return replace(one, values=values, unbounded=unbounded)


def at_place(series: OrderSeries, name: str) -> OrderSeries:
    """Return one location of a series."""
    place = series.names.index(name)
    return replace(series, values=series.values[:, :, [place]], names=(name,))
