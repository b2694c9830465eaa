"""The whole crankshaft's own vibration held against the limits, where a chain is no adequate model of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np

from crankbase.array_checks import ComplexArray
from crankbase.results import Flat, InItsUnit, Number, Quantity, Result, Speed, result
from crankbase.sentences import finished, joined
from crankfem.analyses.shaft.whole_shaft import (
    ShaftComparison,
    WholeShaft,
    not_comparable,
    whole_shaft_remark,
)
from crankfem.analyses.vibration.assessment import Assessment
from crankfem.analyses.vibration.bearing_sweep import BearingSweep
from crankfem.analyses.vibration.engine_limits import (
    assessment_end_speeds,
    engine_limits,
    engine_verdict,
    limited_quantities,
)
from crankfem.files.engine.engine_file import EngineFile
from dynamics import wording
from dynamics.assessment.limits import AmplitudeCurve
from dynamics.assessment.response_curves import curves_of
from dynamics.assessment.verdict import Decision, LimitCheck, Verdict, decide
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import FLYWHEEL, FREE_END, EngineChain
from dynamics.chains.varying import VaryingSpring
from dynamics.crankshaft.coupled_response import CoupledResponse, shaft_criticals
from dynamics.response.loads import ElementLoads, LinearQuantities, dashpot_names
from dynamics.response.series import OrderSeries

DIGITS = 3


def with_bearings(assessment: Assessment, sweep: BearingSweep) -> Assessment:
    """Add to an assessment what the range of the bearings' stiffness decides."""
    trials = (*assessment.decision.trials, *sweep.trials)
    sentences = sweep.sentences[1:] if sweep.flips else ()
    return replace(
        assessment,
        decision=decide(assessment.verdict.status, trials),
        beside=(*assessment.beside, *sentences),
    )


def with_whole_shaft(
    assessment: Assessment,
    engine_file: EngineFile,
    comparison: ShaftComparison,
    cranks: EngineChain,
    moduli: Mapping[int, float],
) -> Assessment:
    """Add to an assessment how the whole crankshaft differs and, where that matters, its own verdict.

    Further arguments are those of `whole_verdict`.
    """
    sentences = whole_shaft_remark(comparison)
    if reason := not_comparable(engine_file):
        sentences = (wording.chains_alone(reason),)
    whole = whole_verdict(engine_file, comparison, cranks, moduli, assessment.verdict)
    if whole is None:
        return replace(assessment, by_whole=sentences)
    return replace(
        assessment,
        whole=whole,
        decision=decision_by_both(assessment.decision, whole, assessment.verdict),
        by_whole=(*sentences, whole_sentence(whole, assessment.verdict)),
    )


@dataclass(frozen=True, eq=False)
class WholeTorsion:
    """The torsional vibration of the whole crankshaft, read by limits like that of a chain.

    Attributes
    ----------
    cranks : EngineChain
        The torsional chain: its elements in the crankshaft pass the main bearings.
    moduli : mapping of int to float
        Section modulus of each element of the crankshaft [m^3].
    """

    coupled: CoupledResponse
    cranks: EngineChain
    moduli: Mapping[int, float]

    @cached_property
    def stress(self) -> OrderSeries:
        """Nominal torsional stress [Pa], by the torque at its main bearings."""
        torque = self.coupled.torque
        elements = sorted(self.moduli)
        bearings = [_bearing(self.cranks, element) for element in elements]
        return replace(
            torque,
            values=torque.values[:, :, bearings] / [self.moduli[element] for element in elements],
            names=tuple(self.cranks.chain.elements[element] for element in elements),
        )

    @cached_property
    def loads(self) -> ElementLoads:
        """Torques in the elements and dashpots of the torsional chain [N m].

        In the crankshaft those at its main bearings, behind it and in a damper those of the springs.
        """

        def twist(pair: tuple[int, int]) -> ComplexArray:
            left, right = (
                coupled.total.motion[:, :, point] for point in _ends(coupled, chain, pair)
            )
            return right - left

        coupled, chain = self.coupled, self.cranks.chain
        elastic = whole_torques(coupled, self.cranks).series(coupled.total)
        total, speeds = elastic.values.copy(), coupled.total.angular_frequencies
        for spring in range(self.cranks.crank_elements, len(chain.connections)):
            total[:, :, spring] *= 1.0 + 1j * chain.loss_factor[spring]
            rate = 1j * speeds * twist(chain.connections[spring])
            total[:, :, spring] += chain.damping[spring] * rate
        none = replace(elastic, values=elastic.values[:, :, :0], names=())
        resisted = np.zeros((*speeds.shape, len(chain.dashpots)), dtype=complex)
        for place, dashpot in enumerate(chain.dashpots):
            rate = 1j * speeds * twist((dashpot.left, dashpot.right))
            resisted[:, :, place] = np.where(elastic.unbounded, 0.0, dashpot.damping * rate)
        dashpots = replace(elastic, values=resisted, names=dashpot_names(chain))
        return ElementLoads(replace(elastic, values=total), elastic, ground=none, dashpots=dashpots)


@result("order", "place", "value", "speed")
class WholeCritical(Result):
    """A critical speed of the whole crankshaft.

    Attributes
    ----------
    value : float
        Amplitude of the order at its place; inf where unbounded.
    mode : int
        That makes the peak, with its undamped frequency [Hz] and share of critical damping; 0 for none.
    share : float
        Of the largest amplitude at the place.
    """

    order: Number
    place: str
    value: InItsUnit
    mode: int
    frequency: Annotated[float | None, Quantity("Hz")]
    damping_ratio: Annotated[float | None, Quantity("1")]
    share: Number
    speed: Speed
    in_running_range: bool
    unit: str


@result("peaks", "left_out")
class WholeCriticals(Result):
    """Critical speeds of the whole crankshaft in one kind of vibration, and how many are too small."""

    left_out: int
    peaks: tuple[WholeCritical, ...]


@result("shaft", "comparison")
class WholeVibration(Result):
    """The whole crankshaft of an engine beside its chains.

    Attributes
    ----------
    criticals : dict of str to WholeCriticals
        By kind: of those whose chain is inadequate.
    """

    shaft: Flat[WholeShaft]
    comparison: Flat[ShaftComparison]
    criticals: dict[str, WholeCriticals]


def whole_criticals(
    engine_file: EngineFile, comparison: ShaftComparison, cranks: EngineChain
) -> dict[str, WholeCriticals]:
    """Return the whole crankshaft's critical speeds, by the kinds of vibration whose chain is inadequate.

    Torques [N m] in the elements of the torsional chain, axial motions [m] of the main bearings, from the
    lowest running speed to the highest one judged, or to the end of the gas pressures over the speed.
    """
    coupled = comparison.coupled
    if coupled is None:
        return {}
    ends, frequencies = assessment_end_speeds(engine_file), coupled.total.system.elastic_frequencies
    judged = ends[0], min(ends[-1], float(coupled.speeds[-1]))  # a map of the gas may end before
    highest = engine_file.engine.highest_speed * (1.0 + 1e-9)
    criticals = {}
    for kind, verdict in comparison.chains.items():
        if verdict.suffices:
            continue
        torsional = kind == "torsional"
        quantities = whole_torques(coupled, cranks) if torsional else coupled.axial_motions
        peaks, left_out = shaft_criticals(coupled, quantities, judged)
        criticals[kind] = WholeCriticals(
            left_out,
            tuple(
                WholeCritical(
                    order=peak.order,
                    place=peak.place,
                    value=peak.amplitude,
                    mode=peak.mode if peak.in_band else 0,
                    frequency=float(frequencies[peak.mode - 1]) if peak.in_band else None,
                    damping_ratio=peak.damping_ratio if peak.in_band else None,
                    share=peak.severity,
                    speed=peak.speed,
                    in_running_range=peak.speed <= highest,
                    unit="N m" if torsional else "m",
                )
                for peak in peaks
            ),
        )
    return criticals


def whole_torques(coupled: CoupledResponse, cranks: EngineChain) -> LinearQuantities:
    """Return the torques k d in the elements of the torsional chain [N m], of the whole crankshaft."""
    shaft, chain = coupled.crankshaft, cranks.chain
    torques, expand = coupled.bearing_torques, shaft.system.expand
    crank_elements = range(cranks.crank_elements)
    bearings = [_bearing(cranks, element) for element in crank_elements]
    springs = range(cranks.crank_elements, len(chain.connections))
    twists = [
        np.subtract(*(expand[point] for point in _ends(coupled, chain, pair)[::-1]))
        for pair in chain.connections[cranks.crank_elements :]
    ]
    rows = [chain.stiffness[spring] * twist for spring, twist in zip(springs, twists, strict=True)]
    varying = tuple(
        (spring.place, VaryingSpring(twists[spring.place - len(bearings)], spring.law))
        for spring in chain.varying
        if not spring.to_ground
    )
    more = ((0, len(springs)), (0, 0))
    assert torques.inertia is not None
    assert torques.direct is not None
    return LinearQuantities(
        names=chain.elements,
        rows=np.vstack((torques.rows[bearings], *rows)),
        loads=np.ones(len(chain.elements), dtype=bool),
        inertia=np.pad(torques.inertia[bearings], more),
        direct=np.pad(torques.direct[bearings], more),
        varying=varying,
    )


def _bearing(cranks: EngineChain, element: int) -> int:
    """Return the main bearing, from 0, that an element of the crankshaft passes."""
    return int(np.sum(np.array(cranks.throw_nodes) <= min(cranks.chain.connections[element])))


def _ends(coupled: CoupledResponse, chain: Chain, pair: tuple[int, int]) -> list[int]:
    """Return the points of the whole crankshaft at two nodes of the chain behind it or in a damper."""
    points, count = coupled.crankshaft, coupled.crankshaft.shaft.section_count
    ends = {FREE_END: "main bearing 1 rz", FLYWHEEL: f"main bearing {count} rz"}
    names = (chain.names[node] for node in pair)
    return [
        points.point(ends.get(name, name if name in points.names else f"{name} rz"))
        for name in names
    ]


def whole_verdict(
    engine_file: EngineFile,
    comparison: ShaftComparison,
    cranks: EngineChain,
    moduli: Mapping[int, float],
    chains: Verdict,
) -> Verdict | None:
    """Judge the whole crankshaft by all limits of the chains' verdict.

    Parameters
    ----------
    chains : Verdict
        Its curves are kept for what the whole crankshaft does not give: axial forces in the throws.

    Returns
    -------
    Verdict or None
        None where it was not compared with chains, where all chains are adequate, or where no limit on
        stress or on the free end's motion is on an inadequate one.
    """
    inadequate = {verdict.kind for verdict in comparison.verdicts if not verdict.suffices}
    if comparison.coupled is None or not inadequate:
        return None
    motions = {f"{verdict.kind}_amplitude": verdict.response for verdict in comparison.verdicts}
    limits, quantities = engine_limits(engine_file)[0], limited_quantities(engine_file)
    whole = WholeTorsion(comparison.coupled, cranks, moduli)
    curves: dict[str, Sequence[AmplitudeCurve]] = {}
    for name in limits:
        if (moved := motions.get(name)) is not None:
            curves[name] = [AmplitudeCurve("free end", moved.speeds, moved.shaft)]
        elif quantities[name].kind == "torsional":
            curves[name] = curves_of(quantities[name].series(whole))
    if not inadequate & {quantities[name].kind for name in curves}:
        return None
    findings = [
        (limit, curve)
        for name, limit in limits.items()
        for curve in curves.get(
            name, [check.curve for check in chains.checks if check.limit.name == limit.name]
        )
    ]
    return engine_verdict(engine_file, findings)


def whole_sentence(whole: Verdict, chains: Verdict) -> str:
    """Say what the whole crankshaft reaches of the limit used most, and whether the verdicts agree.

    Beside it stands what the chains reach of the same limit, each at its own worst of the speeds judged.
    """
    by_chains = {check.curve for check in chains.checks}
    worst = next(check for check in whole.checks if check.curve not in by_chains)
    same = next((check for check in chains.checks if check.limit.name == worst.limit.name), None)
    shown: list[str] = []
    if whole.status == "barred range needed":
        shown = [joined(", ", (barred.shown for barred in whole.barred))]
    elif worst.passed:  # not acceptable by what is not told above
        refused = (*whole.barred, *whole.started_through)
        shown = [barred.sentence for barred in refused if not barred.allowed]
    text = wording.whole_use(
        f"{wording.limit_at(worst.limit.name, worst.curve.name)}, {_use(worst)}",
        {check.limit.name for check in whole.checks if check.curve in by_chains},
        "" if same is None else f"{same.curve.name}, {_use(same)}",
        whole.status == chains.status,
        whole.status,
        shown,
    )
    return finished(text)


def _use(check: LimitCheck) -> str:
    return wording.use_in_words(
        check.limit.unit, check.worst_speed, check.worst_value, check.permitted, DIGITS
    )


def decision_by_both(decision: Decision, whole: Verdict, chains: Verdict) -> Decision:
    """Leave undecided what is acceptable by the chains alone, or by the whole crankshaft alone."""
    accepted = [verdict.status != "not acceptable" for verdict in (chains, whole)]
    if accepted[0] == accepted[1]:
        return decision
    reasons = (wording.by_one_model(accepted[0]), *decision.reasons)
    return replace(decision, status="undecided", reasons=reasons)
