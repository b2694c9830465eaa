"""An engine's vibration over the possible range of its main bearings' stiffness."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np

from crankbase.array_checks import Array
from crankbase.frames import table
from crankbase.results import Internal, Part, Quantity, Result, result
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.shaft.whole_shaft import WholeShaft, not_comparable
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import calculated_range
from crankfem.analyses.vibration.engine_limits import (
    assessment_end_speeds,
    bending_speeds,
    engine_verdict,
    judges_axial,
    limit_findings,
)
from crankfem.analyses.vibration.forced import ForcedVibration, resonances_of, vibrations_at
from crankfem.analyses.vibration.modes import Vibration, axial_vibration, torsional_vibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.vibration_sections import Bearings
from dynamics import wording
from dynamics.assessment.verdict import Status, Trial, Verdict
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import EngineChain
from dynamics.crankshaft.assembly import CLASSES, AssembledShaft
from dynamics.crankshaft.chain_comparison import DIVIDED, followed_modes, mode_likeness
from dynamics.crankshaft.shaft_modes import ShaftModes, crankshaft_modes
from dynamics.crankshaft.surroundings import UX, UY
from dynamics.critical import critical_speeds
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.indices import at_most
from fem.superelement import ShaftCompliances

if TYPE_CHECKING:
    from regression.models.compliance_model import ComplianceModel

KINDS = ("axial", "torsional")
# Speeds of the even grid, and others about each critical speed in half bandwidths: 97 % of a peak is read.
POINTS = 40
NEAR = np.array([-0.5, 0.0, 0.5])


@dataclass(frozen=True, eq=False)
class HeldChains:
    """An engine's chains in main bearings of one stiffness.

    Attributes
    ----------
    stiffness : float
        Lateral, of each main bearing [N/m].
    axial, torsional : Vibration
        With the chosen compliances alone.
    answers : tuple of ForcedVibration or None
        Axial and torsional, with their resonances; None if not calculated.
    """

    stiffness: float
    shaft: ShaftCompliances
    axial: Vibration
    torsional: Vibration
    answers: tuple[ForcedVibration, ForcedVibration] | None = None

    def chain(self, kind: str) -> EngineChain:
        """Return the chain of one kind with the chosen compliances."""
        vibration = self.axial if kind == "axial" else self.torsional
        return vibration.chosen.chain


Frequencies: TypeAlias = Annotated[dict[str, Array], Quantity("Hz", missing=math.nan)]


@result("stiffness", "chains", "shaft", "used", "statuses")
class BearingSweep(Result):
    """Effect of the main bearings' stiffness on frequencies, limits and the verdict.

    Attributes
    ----------
    assumed : bool
        Whether the stiffness is assumed.
    stiffness : (k,) array
        Lateral, of each main bearing, ascending over the range [N/m].
    chains, shaft : dict of str to (k,) array
        By kind: the frequency of the crankshaft's own first mode by its chain, of the number that it has at
        the nominal stiffness, and that of the whole crankshaft's mode that is most similar at the nominal
        stiffness, followed by its shape [Hz]; NaN where there is none, or it is no longer like the chain's.
        Empty without a whole crankshaft to compare.
    modes : dict of str to int
        By kind: the number of that mode of the chain, from 1.
    further : dict of str to (b, k) array
        By kind: other modes of the whole crankshaft that are like the chain's somewhere [Hz], as where
        coupling divides it between two; NaN elsewhere.
    used : dict of str to (k,) array
        By limit: the largest share of it that is used. Calculated at a coarse grid of speeds, within
        3 % of a peak, except for the nominal stiffness. Empty if nothing is assessed.
    statuses : tuple of k str, or empty
        Verdict at each stiffness.
    beyond : tuple of str
        Limits of which most is used above the running range, at one stiffness or more.
    """

    bearings: Internal[Bearings]
    assumed: bool
    stiffness: Annotated[Array, Quantity("N/m")]
    chains: Frequencies
    shaft: Frequencies
    used: Annotated[dict[str, Array], Quantity("1")]
    statuses: tuple[Status, ...]
    further: Frequencies = field(default_factory=dict)
    beyond: Internal[tuple[str, ...]] = ()
    modes: Annotated[dict[str, int], Quantity("1")] = field(default_factory=dict)

    @property
    def stiffness_range(self) -> str:
        """The range in words."""
        low, high = self.stiffness[[0, -1]].tolist()
        return f"stiffness of the main bearings {wording.stiffness_range(low, high)} each"

    @property
    def flips(self) -> Part[bool]:
        """Whether the verdict varies over the range."""
        return len(set(self.statuses)) > 1

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The verdict at each stiffness, if it is assumed; empty if the file gives it."""
        if not self.assumed:
            return ()
        name = ("bearings.stiffness", "lateral stiffness of the main bearings")
        return tuple(
            Trial(*name, value, "N/m", status, taken=value == self.bearings.stiffness)
            for value, status in zip(self.stiffness.tolist(), self.statuses, strict=False)
        )

    @cached_property
    def sentences(self) -> Part[tuple[str, ...]]:
        """Effect of the range on first frequencies and limits, and whether the verdict changes."""
        held = self.bearings
        frequencies = [
            wording.first_frequencies(
                kind,
                self.modes.get(kind, 1),
                self.chains.get(kind),
                self.shaft.get(kind),
                self.further.get(kind, ()),
            )
            for kind in KINDS[::-1]
        ]
        first = wording.over_bearings(held.lowest, held.highest, self.assumed, frequencies)
        if not self.used:
            return (first,)
        limits = wording.limits_over_bearings(self.used, self.beyond, self.statuses, self.stiffness)
        return first, limits

    def to_pandas(self) -> Any:
        """Return a row for each stiffness.

        Units are in ``frame.attrs["units"]``.
        """
        return table(
            {"stiffness": (self.stiffness, "N/m")}
            | {f"{kind} chain": (chain, "Hz") for kind, chain in self.chains.items()}
            | {f"{kind} whole crankshaft": (curve, "Hz") for kind, curve in self.shaft.items()}
            | {f"used of {name}": (curve, "1") for name, curve in self.used.items()}
            | ({"status": (list(self.statuses), "")} if self.statuses else {})
        )


def held_chains(
    engine_file: EngineFile, analysis: Analyses, model: "ComplianceModel | None", stiffness: float
) -> HeldChains:
    """Return an engine's chains in main bearings of a lateral stiffness [N/m], rigid ones if infinite."""
    shaft = compliances_in_shaft(engine_file, analysis, stiffness)
    return HeldChains(
        stiffness,
        shaft,
        axial_vibration(engine_file, analysis, shaft, model, chosen_alone=True),
        torsional_vibration(engine_file, analysis, shaft, model, chosen_alone=True),
    )


def chains_over_bearings(
    engine_file: EngineFile,
    analysis: Analyses,
    model: "ComplianceModel | None" = None,
    nominal: HeldChains | None = None,
) -> tuple[HeldChains, ...]:
    """Return an engine's chains at each stiffness of the sweep; empty if the file gives no range.

    `nominal` are those of the nominal stiffness, if known.
    """
    values = engine_file.main_bearings.sweep
    if len(values) == 1:
        return ()
    return tuple(
        nominal
        if nominal is not None and value == nominal.stiffness
        else held_chains(engine_file, analysis, model, value)
        for value in values.tolist()
    )


def bearing_sweep(
    engine_file: EngineFile,
    each: Sequence[HeldChains],
    whole: WholeShaft | None = None,
    verdict: Verdict | None = None,
) -> BearingSweep:
    """Apply the range of the bearings' stiffness to frequencies, limits and verdict.

    Parameters
    ----------
    each : sequence of HeldChains
        From `chains_over_bearings`, and `with_answers` if there is a verdict.
    whole : WholeShaft, optional
        In the nominal bearings.
    verdict : Verdict, optional
        At the nominal stiffness; without it nothing is assessed.
    """
    held = engine_file.main_bearings
    nominal = len(each) // 2
    shafts = (
        []
        if whole is None or not_comparable(engine_file)
        else [
            in_bearings(whole.crankshaft.shaft, held_chain.stiffness - held.stiffness)
            for held_chain in each
        ]
    )
    modes = [crankshaft_modes(shaft) for shaft in shafts]
    # Of the nominal stiffness: a mode keeps its number over the range, not its shape.
    firsts, frequencies, matched, further = {}, {}, {}, {}
    for kind in KINDS:
        chains = [held_chain.chain(kind) for held_chain in each]
        first = chains[nominal].first_mode(chains[nominal].chain.modes())
        firsts[kind] = first
        frequencies[kind] = np.array(
            [
                math.nan if first is None else chain.chain.modes().frequencies[first]
                for chain in chains
            ]
        )
        if shafts:
            matched[kind], further[kind] = _followed(shafts, modes, chains, nominal, first)
    verdicts = [
        engine_verdict(engine_file, limit_findings(engine_file, *held_chain.answers))
        if held_chain.answers
        else verdict
        for held_chain in each
        if verdict is not None
    ]
    limits = dict.fromkeys(check.limit.name for verdict in verdicts for check in verdict.checks)
    worst = {
        name: [
            max((c for c in verdict.checks if c.limit.name == name), key=lambda c: c.used)
            for verdict in verdicts
        ]
        for name in limits
    }
    return BearingSweep(
        bearings=held,
        assumed=engine_file.bearings is None,
        stiffness=np.array([held_chain.stiffness for held_chain in each]),
        chains=frequencies,
        shaft=matched,
        used={name: np.array([c.used for c in checks]) for name, checks in worst.items()},
        statuses=tuple(verdict.status for verdict in verdicts),
        further=further,
        beyond=tuple(
            name
            for name, checks in worst.items()
            if any(not at_most(c.worst_speed, c.highest_running) for c in checks)
        ),
        modes={
            kind: first - each[nominal].chain(kind).chain.modes().rigid + 1
            for kind, first in firsts.items()
            if first is not None
        },
    )


def in_bearings(shaft: AssembledShaft, added: float) -> AssembledShaft:
    """Return a whole crankshaft in main bearings with their lateral stiffness increased by values [N/m]."""
    across = shaft.sections.reshape(shaft.section_count, 6, -1)[:, [UX, UY]]
    rows = across.reshape(-1, across.shape[-1])
    return replace(shaft, stiffness=shaft.stiffness + added * rows.T @ rows)


def with_answers(
    engine_file: EngineFile, each: Sequence[HeldChains], harmonics: CylinderHarmonics
) -> tuple[HeldChains, ...]:
    """Return chains of the sweep with their forced vibration and its resonances, except the nominal ones.

    Speeds are those of a coarse grid; resonances are found between them.
    """
    nominal, changed = len(each) // 2, []
    for place, held in enumerate(each):
        if place == nominal:
            changed.append(held)
            continue
        chains = EngineChains.of(engine_file, held.axial, held.torsional, held.shaft)
        low, high = ends = calculated_range(engine_file)
        marked = (*assessment_end_speeds(engine_file), *bending_speeds(engine_file))
        tried = [np.linspace(low, high, POINTS), np.clip(marked, low, high)]
        axial, torsional = (damped.system for damped in chains.damped)
        for system in (torsional, axial) if judges_axial(engine_file) else (torsional,):
            ratios = system.damping_ratios()
            tried += [
                critical.speed * (1.0 + ratios[critical.mode] * NEAR)
                for critical in critical_speeds(system.elastic_frequencies, harmonics.orders, ends)
            ]
        speeds = np.unique(np.concatenate(tried))
        speeds = speeds[(speeds >= low) & (speeds <= high)]
        speeds = speeds[np.diff(speeds, prepend=0.0) > 1e-9 * speeds]
        lengthened, twisted = (
            replace(forced, resonances=resonances_of(engine_file, forced))
            for forced in vibrations_at(chains, harmonics, speeds)
        )
        changed.append(replace(held, answers=(lengthened, twisted)))
    return tuple(changed)


def answers_by_chain(
    each: Sequence[HeldChains], nominal: ForcedVibration
) -> dict[Chain, ForcedVibration]:
    """Return the forced vibration of one kind by its chain: the nominal one first, then the others."""
    answers = {nominal.engine_chain.chain: nominal}
    for held in each:
        for answer in held.answers or ():
            if answer.kind == nominal.kind:
                answers[answer.engine_chain.chain] = answer
    return answers


def _followed(
    shafts: Sequence[AssembledShaft],
    modes: Sequence[ShaftModes],
    chains: Sequence[EngineChain],
    nominal: int,
    first: int | None,
) -> tuple[Array, Array]:
    """Frequencies of the whole crankshaft's modes like the chain's first one, followed by shape [Hz]."""
    rigid = modes[0].rigid
    follow = followed_modes(shafts[0].mass, [mode.shapes[:, rigid:] for mode in modes])
    frequencies, alike = np.full((2, *follow.shape), math.nan)
    for place, (shaft, chain_modes, chain) in enumerate(zip(shafts, modes, chains, strict=True)):
        if first is None:
            continue
        likeness = mode_likeness(shaft, chain_modes, chain, [first])[0]
        scores = (chain_modes.shares[CLASSES.index(chain.kind)] * likeness)[rigid + follow[place]]
        best = float(np.max(scores))
        alike[place] = scores
        known = (scores >= min(DIVIDED, best)) & (scores > 0.0)
        frequencies[place, known] = chain_modes.frequencies[rigid + follow[place]][known]
    there = np.isfinite(frequencies).any(axis=0)
    if not there.any():
        return frequencies[:, 0], np.empty((0, len(modes)))
    main = int(np.nanargmax(np.where(np.isnan(alike[nominal]), -1.0, alike[nominal])))
    others = [branch for branch in np.flatnonzero(there).tolist() if branch != main]
    return frequencies[:, main], frequencies[:, others].T
