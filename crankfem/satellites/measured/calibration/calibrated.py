"""Calibrate an engine with measured orders: fit, what it cannot tell, fitted file, new verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.outputs import check_output
from crankbase.quantity import format_quantity
from crankbase.results import Internal, Number, Part, Quantity, Result, Speed, result
from crankfem.analyses.shaft.chains import damped_engine_chain
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_limits import limit_findings
from crankfem.analyses.vibration.run import EngineVibration, engine_vibration
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.satellites.measured.calibration.agreement import agreement
from crankfem.satellites.measured.calibration.engine_problem import (
    EngineModel,
    engine_problem,
    with_magnifier,
)
from crankfem.satellites.measured.calibration.fit import (
    NORMAL95,
    Fit,
    Observation,
    fit,
    profile,
)
from crankfem.satellites.measured.calibration.fitted_engine import FittedEngine, fitted_engine
from crankfem.satellites.measured.calibration.gains import CylinderGain, Gains, cylinder_gains
from crankfem.satellites.measured.calibration.groups import MODAL
from crankfem.satellites.measured.calibration.identifiability import (
    Further,
    directions,
    further_measurements,
    remedies,
)
from crankfem.satellites.measured.calibration.sampling import Samples, check_sampler, sampled
from crankfem.satellites.measured.measured_orders import MeasuredOrders
from dynamics.assessment.limits import usage

# Further speeds that are tried, evenly over the running range, and remedies named of each direction.
FURTHER_SPEEDS, MOST_REMEDIES = 5, 3


@result("name", "factor", "low", "high")
class FittedGroup(Result):
    """A group's factor on the maker's values.

    Attributes
    ----------
    low, high : float
        95 % interval, linear in the logarithm.
    profile_low, profile_high, sample_low, sample_high : float or None
        By profile likelihood, and by samples of the posterior; None if not asked for.
    tolerance : float
        Share by which the maker's value may be off, 95 of 100 times.
    pull : float
        Distance from the maker's value, in standard deviations of that tolerance.
    determined : float
        Share of the tolerance's variance that the records remove; 0 where they tell nothing.
    """

    name: str
    field: str
    factor: Number
    low: Number
    high: Number
    profile_low: Annotated[float | None, Quantity("1")]
    profile_high: Annotated[float | None, Quantity("1")]
    sample_low: Annotated[float | None, Quantity("1")]
    sample_high: Annotated[float | None, Quantity("1")]
    tolerance: Number
    pull: Number
    determined: Number


@result("parts", "strength")
class Untold(Result):
    """A combination of groups that the records tell less of than the tolerances do.

    Attributes
    ----------
    parts : dict of str to float
        Change of each factor together, as a share, at one deviation of the tolerances.
    strength : float
        0 where the records tell nothing of it, 1 where as much as the tolerances.
    remedies : tuple of str
        Further sensors or speeds that would tell it, the best first.
    """

    parts: Annotated[Mapping[str, float], Quantity("1")]
    strength: Number
    remedies: tuple[str, ...]


@result("place", "order", "misfit")
class OrderResidual(Result):
    """Residuals of one order of a record.

    Attributes
    ----------
    measured, left : float
        Root mean square over the speeds of what was measured and of what the fit leaves [of the quantity].
    misfit : float
        Root mean square of the residual in deviations of the scatter told.
    """

    record: str
    place: str
    order: Number
    measured: Annotated[float, Quantity(".unit")]
    left: Annotated[float, Quantity(".unit")]
    misfit: Number
    unit: str


@result("place", "inside", "misfit")
class Predicted(Result):
    """A record that was left out of the fit, and the prediction for it.

    Attributes
    ----------
    inside : float
        Share of its amplitudes within the 95 % band of prediction and scatter.
    band : float
        Median half width of the prediction's band, as a share of the amplitude.
    """

    record: str
    place: str
    inside: Number
    band: Number


@result("limit", "place", "before", "after")
class LimitChange(Result):
    """Use of a limit with the maker's values and with the fitted ones.

    Attributes
    ----------
    speed_before, speed_after : float
        Speeds at which most is used [rad/s].
    """

    limit: str
    place: str
    before: Number
    after: Number
    speed_before: Speed
    speed_after: Speed


@result("status_before", "status_after")
class VerdictChange(Result):
    """The verdict with the maker's values and with the fitted ones.

    Attributes
    ----------
    limits : tuple of LimitChange
        Those most used after, first.
    by_group : dict of str to float
        Of the first one's use, the change by each group alone.
    frequency_before, frequency_after : float or None
        Of the crankshaft's first torsional mode [Hz].
    """

    status_before: str
    status_after: str
    limits: tuple[LimitChange, ...]
    by_group: Annotated[Mapping[str, float], Quantity("1")]
    frequency_before: Annotated[float | None, Quantity("Hz")]
    frequency_after: Annotated[float | None, Quantity("Hz")]


@result("engine", "status", "misfit")
class Calibration(Result):
    """An engine's values fitted to measured orders.

    Attributes
    ----------
    status : {"fits", "fits roughly", "does not fit"}
        Within the scatter told; beyond it; or not at all: then no file is written.
    pulled : tuple of str
        Groups that would have to be far beyond their tolerances.
    slip : str or None
        What explains a record that does not fit.
    size : float
        Median of measured amplitudes over those with the maker's values.
    misfit, limit : float
        Square of the residuals over the scatter told, and what it exceeds by chance in 1 of 100 fits.
    explained : float
        Share of the measured square sum that the fit gives.
    effective : float
        Number of independent values; overlapping windows count once.
    lost_starts, starts : int
        Starts of the search that ended in a worse minimum, of how many.
    samples : Samples or None
        Those of the posterior; None if not asked for.
    unwritten : tuple of str
        Fitted factors that no field of an engine file holds, such as that of the gas torque; the verdict is
        without them.
    files : tuple of str
        Written.
    """

    engine: str
    records: tuple[str, ...]
    date: str
    status: str
    pulled: tuple[str, ...]
    slip: str | None
    size: Number
    misfit: Number
    limit: Number
    explained: Number
    effective: Number
    lost_starts: int
    starts: int
    groups: tuple[FittedGroup, ...]
    samples: Part[Samples | None]
    untold: tuple[Untold, ...]
    residuals: tuple[OrderResidual, ...]
    predicted: tuple[Predicted, ...]
    cylinders: tuple[CylinderGain, ...]
    cylinder_remedies: tuple[str, ...]
    verdict: VerdictChange | None
    remarks: tuple[str, ...]
    unwritten: tuple[str, ...]
    files: tuple[str, ...]
    fit: Internal[Fit | None] = None
    fitted: Internal[FittedEngine | None] = None

    def __getitem__(self, name: str) -> FittedGroup:
        """Return the fitted group of a name."""
        return next(group for group in self.groups if group.name == name)


def calibrate(
    engine: str | Path | EngineFile,
    records: Mapping[str, MeasuredOrders],
    moves: Mapping[str, float] | None = None,
    *,
    gains: bool = False,
    predict: Mapping[str, MeasuredOrders] | None = None,
    output: str | Path | None = None,
    profiles: bool = False,
    samples: bool = False,
    analysis: Analyses | None = None,
    step: Callable[[str], None] | None = None,
) -> Calibration:
    """Fit the values of an engine that may move to measured orders, and judge it with them.

    Parameters
    ----------
    engine : path or EngineFile
    records : mapping of str to MeasuredOrders
        By name.
    moves : mapping of str to float, optional
        What may move, with the maker's tolerance as a share: fields of the engine file such as
        "flywheel.inertia"; "torsional_compliance", "inertia" and "damping" as in [ranges], those of the file
        by default; "gas torque"; or parts of the chain such as "stiffness of cylinder 1 - cylinder 2".
    gains : bool, optional
        Whether each cylinder has a gain, to find a weak one.
    predict : mapping of str to MeasuredOrders, optional
        Records that are left out of the fit, to be predicted.
    output : path, optional
        Engine file to write; nothing is written if the records do not fit.
    profiles : bool, optional
        Whether to find intervals by profile likelihood, too.
    samples : bool, optional
        Whether to find intervals by samples of the posterior, too; needs crankfem[sampling].
    analysis : ThrowAnalysis or mapping, optional
        Of its throws, if available.
    step : callable, optional
        Called with the name of each step.

    Raises
    ------
    InputError
        If something given cannot be used.
    MissingLibraryError
        If samples are asked for without their package.
    """
    tell = step or (lambda _: None)
    if output is not None:  # before minutes are spent
        check_output(Path(output), "input file")
    if samples:
        check_sampler()
    asked = dict(moves or {})
    read = engine if isinstance(engine, EngineFile) else load_engine(engine)
    run = engine_vibration(with_magnifier(read, [*asked]), analysis=analysis, step=step)
    model = EngineModel(run)
    groups = model.groups(asked, gains)
    problem, remarks = engine_problem(model, [*records.values()], groups)
    solved = fit(problem, step=step)
    agreed = agreement(solved)
    tell("Finding what the records cannot tell")
    names, date = [*records], datetime.now(UTC).date().isoformat()
    # What does not fit has values at which nothing can be calculated, nor told.
    fits = agreed.status != "does not fit"
    further: Sequence[Further] = ()
    if fits:
        further = further_measurements(solved, _further_speeds(model, solved), model.excitation)
    drawn = sampled(solved, step=step) if samples and fits else None
    cylinders: Gains | None = cylinder_gains(solved, model.cylinders, further) if gains else None
    fitted, verdict, files = None, None, list[str]()
    if fits:
        fitted = fitted_engine(model, solved, names, date)
        if output is not None:
            files = [str(path) for path in fitted.write(Path(output))]
        tell("Judging the fitted engine")
        verdict = _verdict_change(model, solved, fitted, Path(output) if output else None)
    return Calibration(
        engine=read.engine.name,
        records=tuple(names),
        date=date,
        status=agreed.status,
        pulled=agreed.pulled,
        slip=agreed.slip,
        size=agreed.size,
        misfit=solved.misfit,
        limit=solved.limit,
        explained=solved.explained,
        effective=solved.effective,
        lost_starts=solved.lost_starts,
        starts=len(solved.starts),
        groups=_groups(solved, profiles and fits, drawn, tell),
        samples=drawn,
        untold=tuple(
            Untold(
                each.named(solved),
                each.strength,
                tuple(remedy.what for remedy in remedies(each, further)[:MOST_REMEDIES]),
            )
            for each in directions(solved)
            if each.untold and fits
        ),
        residuals=_residuals(solved, names),
        predicted=tuple(
            _predicted(name, model.observation(record)[0], solved)
            for name, record in (predict or {}).items()
        ),
        cylinders=() if cylinders is None else cylinders.cylinders,
        cylinder_remedies=()
        if cylinders is None
        else tuple(what for what, _ in cylinders.remedies[:MOST_REMEDIES]),
        verdict=verdict,
        remarks=remarks,
        unwritten=() if fitted is None else fitted.left_out,
        files=tuple(files),
        fit=solved,
        fitted=fitted,
    )


def _groups(
    solved: Fit, profiles: bool, drawn: Samples | None, tell: Callable[[str], None]
) -> tuple[FittedGroup, ...]:
    made = []
    factors = solved.factors()
    for number, group in enumerate(solved.problem.shaft.groups):
        ends: tuple[float | None, float | None] = None, None
        if profiles:
            tell(f"Profile of {group.name}")
            ends = profile(solved, number)
        sides = (None, None) if drawn is None else drawn.interval(solved, number)
        low, high = solved.interval(number)
        made.append(
            FittedGroup(
                name=group.name,
                field=group.field,
                factor=float(factors[number]),
                low=low,
                high=high,
                profile_low=ends[0],
                profile_high=ends[1],
                sample_low=sides[0],
                sample_high=sides[1],
                tolerance=group.tolerance,
                pull=float(solved.parameters[number]),
                determined=float(np.clip(1.0 - solved.deviations[number] ** 2, 0.0, 1.0)),
            )
        )
    return tuple(made)


def _further_speeds(model: EngineModel, solved: Fit) -> dict[str, Array]:
    """Return further speeds over the running range, each by itself and all, by what they are called."""
    engine, first = model.engine_file.engine, solved.problem.observations[0].measured
    speeds = np.linspace(engine.lowest_speed, engine.highest_speed, FURTHER_SPEEDS)
    place = f"{'the angle at' if first.quantity == 'angle' else 'the torque in'} {first.place}"
    shown = [format_quantity(float(speed), "rad/s") for speed in speeds]
    each = {
        f"{place} at {text}": speeds[[k]]
        for k, text in enumerate(shown)
        if np.min(np.abs(first.speed / speeds[k] - 1.0)) > 0.02
    }
    return {**each, f"{place} at {FURTHER_SPEEDS} speeds from {shown[0]} to {shown[-1]}": speeds}


def _residuals(solved: Fit, names: Sequence[str]) -> tuple[OrderResidual, ...]:
    made = []
    for each, name, rest in zip(solved.problem.observations, names, solved.residuals, strict=True):
        measured = each.measured
        for k, order in enumerate(measured.orders.tolist()):
            left = rest[:, :, k] * measured.scatter[:, k]
            made.append(
                OrderResidual(
                    record=name,
                    place=measured.place,
                    order=order,
                    measured=float(np.sqrt(np.mean(np.abs(measured.amplitude[:, k]) ** 2))),
                    left=float(np.sqrt(np.mean(np.sum(left**2, axis=0)))),
                    misfit=float(np.sqrt(np.mean(rest[:, :, k] ** 2))),
                    unit=measured.unit,
                )
            )
    return tuple(made)


def _predicted(name: str, observation: Observation, solved: Fit) -> Predicted:
    """Compare the prediction with a record; of a wheel's orders those without its constants."""
    y, deviation = solved.band(observation)
    measured = observation.measured
    known = ~measured.wheel_constant
    if not np.any(known):
        known = ~known
    off = np.abs(np.abs(y) - np.abs(measured.amplitude))[:, known]
    width = NORMAL95 * np.hypot(deviation, measured.scatter)[:, known]
    size = np.maximum(np.abs(y[:, known]), 1e-300)
    return Predicted(
        record=name,
        place=measured.place,
        inside=float(np.mean(off <= width)),
        band=float(np.median(NORMAL95 * deviation[:, known] / size)),
    )


def _verdict_change(
    model: EngineModel, solved: Fit, fitted: FittedEngine, path: Path | None
) -> VerdictChange | None:
    """Judge the fitted engine as the other was, and find which group changes the use of the worst limit."""
    before = model.run.assessment
    if before is None:
        return None
    run = _fitted_run(model, fitted, path)
    after = run.assessment
    assert after is not None
    uses = {(check.limit.name, check.place): check for check in before.verdict.checks}
    pairs = [
        (uses[key], check)
        for check in after.verdict.checks
        if (key := (check.limit.name, check.place)) in uses
    ]
    limits = tuple(
        LimitChange(new.limit.name, new.place, old.used, new.used, old.worst_speed, new.worst_speed)
        for old, new in sorted(pairs, key=lambda pair: -pair[1].used)
    )
    by_group = {}
    if limits:
        deciding = max(pairs, key=lambda pair: pair[1].used)[1]
        forced = model.run.forced_torsional, run.forced_torsional
        speeds = np.unique(np.concatenate([each.speeds for each in forced if each is not None]))
        low, high = deciding.judged
        speeds = speeds[(speeds >= low * (1.0 - 1e-12)) & (speeds <= high * (1.0 + 1e-12))]
        key = deciding.limit.name, deciding.place
        shaft, parameters = solved.problem.shaft, solved.parameters
        still = _use(model, np.zeros(len(shaft.groups)), solved, speeds, key)
        for number, group in enumerate(shaft.groups):
            alone = np.zeros(len(shaft.groups))
            alone[number] = parameters[number]
            by_group[group.name] = _use(model, alone, solved, speeds, key) - still
    return VerdictChange(
        status_before=before.verdict.status,
        status_after=after.verdict.status,
        limits=limits,
        by_group=dict(sorted(by_group.items(), key=lambda item: -abs(item[1]))),
        frequency_before=_first_frequency(model.run),
        frequency_after=_first_frequency(run),
    )


def _fitted_run(model: EngineModel, fitted: FittedEngine, path: Path | None) -> EngineVibration:
    """Return the vibration of the fitted engine: of its file, where one is written."""
    analyses = model.run.analyses
    if path is not None:
        return engine_vibration(load_engine(path), analysis=analyses)
    if fitted.chain is None:
        return engine_vibration(fitted.engine_file, analysis=analyses)
    lines = {**fitted.engine_file.shaft_lines, "plant": fitted.chain}
    return engine_vibration(replace(fitted.without_parts(), shaft_lines=lines), analysis=analyses)


def _use(
    model: EngineModel, parameters: Array, solved: Fit, speeds: Array, key: tuple[str, str]
) -> float:
    """Return the largest use of a limit at a place with the groups at parameters (p,)."""
    run, file, shaft = model.run, model.engine_file, solved.problem.shaft
    cranks = replace(model.chain, chain=shaft.chain_at(parameters))
    modal = shaft.moved(parameters).values[MODAL][0]
    if shaft.modal_damping and modal != shaft.modal_damping:
        file = file.changed(damping={"torsional_magnifier": 0.5 / float(modal)})
    pulled = run.axial.chosen
    damped = tuple(damped_engine_chain(file, chain) for chain in (pulled.chain, cranks))
    chains = EngineChains(file, pulled, cranks, (damped[0], damped[1]), run.shaft)
    for limit, curve in limit_findings(file, *chains.at(model.harmonics, speeds)):
        if (limit.name, curve.name) == key:
            return float(np.max(usage(limit, curve)))
    return 0.0


def _first_frequency(run: EngineVibration) -> float | None:
    chosen = run.torsional.chosen
    mode = chosen.first_mode
    return None if mode is None else float(chosen.modes.frequencies[mode])
