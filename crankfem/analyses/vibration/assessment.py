"""Assessment of an engine's forced vibration: limits, verdict, and uncertainty."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankfem.analyses.shaft.chains import damped_engine_chain
from crankfem.analyses.shaft.source_errors import source_spread
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.vibration.bearing_sweep import HeldChains, answers_by_chain
from crankfem.analyses.vibration.chain_answers import cause_at
from crankfem.analyses.vibration.decision import engine_decision
from crankfem.analyses.vibration.engine_limits import (
    engine_limits,
    engine_verdict,
    limit_findings,
    limited_series,
    unmodeled_plant,
)
from crankfem.analyses.vibration.forced import ForcedVibration, forced_vibrations
from crankfem.analyses.vibration.modes import Vibration
from crankfem.analyses.vibration.source_verdicts import Again, source_verdicts
from crankfem.files.chain.shaft_lines import PLANT
from crankfem.files.engine.engine_file import EngineFile
from dynamics.assessment.limits import VibrationLimit
from dynamics.assessment.response_curves import with_resonances
from dynamics.assessment.separation import USUAL_MARGIN, CriticalRange, critical_ranges
from dynamics.assessment.uncertainty import Samples, Spread, chain_samples, frequency_bounds
from dynamics.assessment.verdict import Decision, Trial, Verdict, decide
from dynamics.chains.chain import Chain
from dynamics.critical import engine_orders
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.indices import within
from dynamics.response.forced import forced_response
from dynamics.response.series import synthesis
from fem.shaft import ShaftCompliances
from regression.models.compliance_model import ComplianceModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@summarized("kind", "spreads", "nominal [Hz]", "lowest [Hz]", "highest [Hz]")
@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of natural frequencies and amplitudes of one kind.

    Attributes
    ----------
    kind : str
    spreads : tuple of Spread
        Uncertain values.
    lowest, nominal, highest : (m,) arrays
        Elastic natural frequencies [Hz]; exact bounds.
    critical : tuple of CriticalRange
        Critical speeds in or near the running range, with margins.
    amplitudes : Samples or None
        Largest amplitude of the free end over the running range [rad or m] for many possible chains;
        None unless the engine file has the section [ranges].
    barred : tuple of pairs of float
        Speeds to be barred with some compliance of the range [rad/s]; they include those of the verdict.
    """

    kind: str
    spreads: tuple[Spread, ...]
    lowest: FloatArray
    nominal: FloatArray
    highest: FloatArray
    critical: tuple[CriticalRange, ...]
    amplitudes: Samples | None
    barred: tuple[tuple[float, float], ...] = ()

    def to_pandas(self) -> Any:
        """Return a table of the elastic natural frequencies with their bounds.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "mode": (np.arange(1, len(self.nominal) + 1), "1"),
                "lowest": (self.lowest, "Hz"),
                "nominal": (self.nominal, "Hz"),
                "highest": (self.highest, "Hz"),
            }
        )


@summarized("verdict.status", "decision.status", "limits", "remarks")
@dataclass(frozen=True, eq=False)
class Assessment:
    """Verdict and uncertainty of an engine's vibration.

    Attributes
    ----------
    verdict : Verdict
        With the given and the assumed values.
    decision : Decision
        Whether it holds for other possible values of the assumptions.
    limits : dict
        Name to limit; those given, or the selected rule.
    remarks : tuple of str
        What was not assessed, or assumed.
    axial, torsional : Uncertainty
    beside : tuple of str
        What the engine drives where it is not modeled, and where the verdict changes within the range of
        the bearings' stiffness, a sentence each.
    whole : Verdict or None
        That of the whole crankshaft by the same limits, where a chain that they judge is inadequate.
    by_whole : tuple of str
        How far the whole crankshaft differs from the chains that were judged, and its own verdict, a
        sentence each.
    """

    verdict: Verdict
    decision: Decision
    limits: dict[str, VibrationLimit]
    remarks: tuple[str, ...]
    axial: Uncertainty
    torsional: Uncertainty
    beside: tuple[str, ...] = ()
    whole: Verdict | None = None
    by_whole: tuple[str, ...] = ()

    @property
    def conclusion(self) -> str:
        """What can be concluded despite the assumptions, then the verdict with the values used."""
        decision, said = self.decision, self.verdict.sentence
        if decision.status == "undecided":
            with_used = f"{said[0].lower()}{said[1:]}"
            return f"Undecided: {decision.sentence}. With the values used, {with_used}"
        depends = "It depends on assumed or uncertain values"
        return f"{said} {depends}: {decision.sentence}." if decision.sentence else said

    def limit_curve(self, name: str, speeds: FloatArray) -> dict[str, FloatArray]:
        """Return a limit over speeds [rad/s] with its name in a legend; empty if there is none."""
        limit = self.limits.get(name)
        return {} if limit is None else {"limit": limit.continuous.at(speeds)}

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the use of each limit over the speed; see `Verdict.plot`."""
        return self.verdict.plot(axes)

    def to_pandas(self) -> Any:
        """Return a table with a row for each limit that was checked; see `Verdict.to_pandas`."""
        return self.verdict.to_pandas()


def assess(
    engine_file: EngineFile,
    axial: ForcedVibration,
    torsional: ForcedVibration,
    errors: Mapping[str, Spread],
    held: Sequence[HeldChains] = (),
    chains: tuple[Vibration, Vibration] | None = None,
    again: Again | None = None,
) -> Assessment:
    """Compare the forced vibration of an engine with limits, including the uncertainties.

    Parameters
    ----------
    engine_file : EngineFile
        Its sections [limits] and [ranges] are used if given.
    axial, torsional : ForcedVibration
    errors : mapping of str to Spread
        Kind to the error of its compliances' source; see `crankfem.analyses.shaft.source_errors`.
    held : sequence of HeldChains, optional
        The chains over the range of the bearings' stiffness with their responses; the bounds
        of frequencies and critical speeds cover all of them.
    chains : pair of Vibration, optional
        The axial and the torsional one.
    again : callable, optional
        Forced vibration of an engine with other damping or other chains, to check whether the verdict
        holds; without it and the chains neither is varied.

    Raises
    ------
    InputError
        If a limit is on an element that the chain does not have.
    """
    limits, remarks = engine_limits(engine_file)
    findings = limit_findings(engine_file, axial, torsional)
    verdict = engine_verdict(engine_file, findings)
    limited = {
        (limit.name, place): (forced, series)
        for name, limit in limits.items()
        for forced in (axial if name.startswith("axial") else torsional,)
        for series in (limited_series(name, engine_file, axial, torsional),)
        for place in series.names
    }
    *checks, worst = (
        replace(
            one,
            cause=cause_at(
                forced, torsional, series, one.curve.name, one.worst_speed, one.limit.unit
            ),
        )
        for one in (*verdict.checks, verdict.worst)
        for forced, series in (limited[one.limit.name, one.curve.name],)
    )
    spreads = {own.kind: _spreads(engine_file, own, errors[own.kind]) for own in (axial, torsional)}
    trials: tuple[Trial, ...] = ()
    barred: dict[str, tuple[tuple[float, float], ...]] = {}
    damped = None
    if again is not None and chains is not None:
        known, answer = chains, again

        def damped(other: EngineFile) -> tuple[ForcedVibration, ForcedVibration]:
            return answer(other, *known)

        for kind, own in spreads.items():
            (spread,) = (one for one in own if one.kind == "compliance")
            found = source_verdicts(engine_file, chains, kind, spread, verdict, again)
            trials, barred = (*trials, *found.trials), barred | {kind: found.barred}
    decision = engine_decision(engine_file, verdict.status, findings, damped)
    return Assessment(
        verdict=replace(verdict, checks=tuple(checks), worst=worst),
        limits=limits,
        decision=decide(verdict.status, (*decision.trials, *trials)),
        remarks=remarks,
        axial=_uncertainty(engine_file, axial, spreads["axial"], held, barred.get("axial", ())),
        torsional=_uncertainty(
            engine_file, torsional, spreads["torsional"], held, barred.get("torsional", ())
        ),
        beside=unmodeled_plant(engine_file),
    )


def assess_chains(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    chains: tuple[Vibration, Vibration],
    forced: tuple[ForcedVibration, ForcedVibration],
    shaft: ShaftCompliances,
    analysis: Analyses,
    model: ComplianceModel | None,
    held: Sequence[HeldChains],
) -> Assessment:
    """Assess the forced vibration of an engine's chains, with other chains and damping if decisive.

    Parameters
    ----------
    engine_file : EngineFile
    harmonics : CylinderHarmonics
        What excites.
    chains : pair of Vibration
        The axial and the torsional one.
    forced : pair of ForcedVibration
        Theirs.
    shaft, analysis, model
        Source of the compliances; see `source_spread`.
    held : sequence of HeldChains
        As of `assess`.
    """

    def again(
        other: EngineFile, axial: Vibration, torsional: Vibration
    ) -> tuple[ForcedVibration, ForcedVibration]:
        return forced_vibrations(
            other, harmonics, axial, torsional, shaft, analysis, limits_alone=True
        )

    errors = {
        own.kind: source_spread(engine_file, own.kind, own.chosen.source, analysis, shaft, model)
        for own in chains
    }
    return assess(engine_file, *forced, errors, held, chains, again)


def _uncertainty(
    engine_file: EngineFile,
    forced: ForcedVibration,
    spreads: tuple[Spread, ...],
    held: Sequence[HeldChains],
    barred: tuple[tuple[float, float], ...],
) -> Uncertainty:
    """Bounds of frequencies and critical speeds; amplitudes by samples where ranges are given."""
    engine, given = engine_file.engine, engine_file.ranges
    chain, running = forced.engine_chain.chain, (engine.lowest_speed, engine.highest_speed)
    rigid = chain.modes().rigid
    each = answers_by_chain(held, forced)
    others = tuple(each)[1:]
    low, high = frequency_bounds(chain, spreads, others)
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    margin = USUAL_MARGIN if given is None else given.separation_margin
    amplitudes = None
    if given is not None and spreads:
        amplitudes = chain_samples(
            chain,
            spreads,
            lambda changed: _peak(engine_file, forced, changed),
            given.samples,
            given.seed,
        )
    return Uncertainty(
        kind=forced.kind,
        spreads=spreads,
        lowest=low[rigid:],
        nominal=chain.modes().frequencies[rigid:],
        highest=high[rigid:],
        critical=critical_ranges(
            chain,
            spreads,
            orders,
            running,
            within=margin,
            damped=lambda own, mode, order: each[own].damped_shifts(mode, order),
            others=others,
        ),
        amplitudes=amplitudes,
        barred=barred,
    )


def _spreads(engine_file: EngineFile, forced: ForcedVibration, error: Spread) -> tuple[Spread, ...]:
    """The uncertainties given in the file, and at least the error of the compliances' source."""
    given = engine_file.ranges
    elements = tuple(range(len(forced.crank_elements.names)))
    found: tuple[Spread, ...] = ()
    if given is not None:
        found = (
            given.axial_spreads() if forced.kind == "axial" else given.torsional_spreads(elements)
        )
    if any(own.kind == "compliance" for own in found):
        return found
    # A plant's chain is its maker's throughout, the line behind the flywheel too.
    whole_plant = forced.kind == "torsional" and PLANT in engine_file.shaft_lines
    return (replace(error, places=None if whole_plant else elements), *found)


def _peak(engine_file: EngineFile, forced: ForcedVibration, chain: Chain) -> float:
    """Largest amplitude of the free end of a changed chain at running speeds."""
    changed = damped_engine_chain(engine_file, replace(forced.engine_chain, chain=chain))
    response = forced_response(changed, with_resonances(forced.response.excitation, chain))
    low, high = engine_file.engine.lowest_speed, engine_file.engine.highest_speed
    judged = within(response.speeds, low, high)
    free_end = response.elastic
    summed = synthesis(
        free_end.orders,
        free_end.speeds[judged],
        free_end.values[:, judged, 0],
        free_end.unbounded[:, judged],
    )
    return float(np.max(summed.amplitude))
