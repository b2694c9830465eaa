"""The whole vibration calculation of an engine: modes, forced response, verdict, whole crankshaft."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from crankbase.choices import check_choice
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.results import Internal, Part, Quantity, Result, result
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.record import AssumedInput, assumed_values
from crankfem.analyses.shaft.sources import compliances_in_shaft, usable_model
from crankfem.analyses.shaft.throw_analyses import Analyses, analyses_by_name, analyze_throws
from crankfem.analyses.shaft.whole_shaft import (
    ShaftComparison,
    WholeShaft,
    compare_with_chains,
    not_comparable,
    shaft_response,
    whole_shaft,
    with_differences,
)
from crankfem.analyses.vibration.assessment import Assessment, assess
from crankfem.analyses.vibration.axial_cycle import AxialForces, axial_cycle, axial_forces
from crankfem.analyses.vibration.bearing_sweep import (
    BearingSweep,
    HeldChains,
    bearing_sweep,
    chains_over_bearings,
    held_chains,
    with_answers,
)
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, refuse_vibration
from crankfem.analyses.vibration.engine_load import EngineLoad, engine_load
from crankfem.analyses.vibration.forced import ForcedVibration, forced_vibrations
from crankfem.analyses.vibration.misfiring import Misfiring, misfiring_or_reason
from crankfem.analyses.vibration.modes import Kind, Vibration, axial_vibration, torsional_vibration
from crankfem.analyses.vibration.whole_verdict import (
    WholeVibration,
    whole_criticals,
    with_bearings,
    with_whole_shaft,
)
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.mechanism_cylinders import firing_evenness, firing_sentence
from dynamics.assessment.verdict import LimitCheck
from dynamics.chains.chain import Chain
from dynamics.critical import engine_orders
from dynamics.excitation.chain_excitation import AxialForceOverCycle
from dynamics.plots.campbell import draw_campbell
from fem.analysis import ThrowAnalysis
from fem.superelement import ShaftCompliances

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from crankfem.analyses.vibration.input_slopes import VibrationSlopes
    from regression.models.compliance_model import ComplianceModel

Shown = Literal["campbell", "modes", "amplitude", "stress", "load", "power", "limits", "shaft"]
SHOWN: tuple[Shown, ...] = get_args(Shown)
# Limits of an engine file by what they are drawn into.
LIMITS = {"amplitude": "{kind}_amplitude", "stress": "crankshaft_stress"}


@result(
    "engine: engine_file.engine.name",
    "axial: axial.frequencies [Hz]",
    "torsional: torsional.frequencies [Hz]",
    "verdict: assessment.verdict.status",
)
class EngineVibration(Result):
    """Vibration of an engine, by its uncoupled chains and by its whole crankshaft.

    Attributes
    ----------
    analyses : dict of str to ThrowAnalysis
        Of each distinct throw by its name; "throw" is that of a file with one.
    shaft : ShaftCompliances
        Of the throws in the shaft.
    axial, torsional : Vibration
        Modes and critical speeds.
    forced_axial, forced_torsional : ForcedVibration or None
        None if the file has no gas pressure.
    assessment : Assessment or None
        None if nothing is forced.
    whole : WholeShaft or None
        None unless requested.
    comparison : ShaftComparison or None
        Coupled response of the whole crankshaft, and its comparison with the chains; without the latter
        if the chains have a shaft line or a propeller, which the whole crankshaft lacks.
    misfiring : Misfiring or None
        Vibration of the chains while a cylinder misfires, compared with normal firing.
    misfiring_note : str or None
        Why misfiring was not calculated, if vibration is forced.
    load : EngineLoad or None
        Load at each speed; None if nothing is forced.
    bearings : BearingSweep or None
        Effect of the range of the main bearings' stiffness; None if the file gives no range.
    axial_force : AxialForceOverCycle or None
        Over the cycle at rated speed, on the thrust bearing and between held ends; None if nothing is
        forced.
    """

    engine_file: Internal[EngineFile]
    analyses: Internal[dict[str, ThrowAnalysis]]
    shaft: Internal[ShaftCompliances]
    axial: Vibration
    torsional: Vibration
    forced_axial: Internal[ForcedVibration | None]
    forced_torsional: Internal[ForcedVibration | None]
    assessment: Assessment | None
    whole: Internal[WholeShaft | None]
    comparison: Internal[ShaftComparison | None]
    misfiring: Misfiring | None = None
    misfiring_note: str | None = None
    load: EngineLoad | None = None
    bearings: BearingSweep | None = None
    axial_force: Internal[AxialForceOverCycle | None] = None

    @cached_property
    def firing_order(self) -> Annotated[str, Quantity(key="firing")]:
        """Firing order and intervals."""
        return firing_sentence(self.engine_file.engine)

    @cached_property
    def firing_remarks(self) -> Part[tuple[str, ...]]:
        """Remarks on the evenness of firing."""
        return tuple(note.sentence for note in firing_evenness(self.engine_file.engine).notes)

    @cached_property
    def firing_warnings(self) -> Part[tuple[str, ...]]:
        """What looks wrong in it."""
        evenness = firing_evenness(self.engine_file.engine)
        return tuple(warning.sentence for warning in evenness.warnings)

    @cached_property
    def forced_by_kind(
        self,
    ) -> Annotated[dict[str, ForcedVibration] | None, Quantity(key="forced")]:
        """Forced vibration by kind; None without gas pressure."""
        both = (self.forced_axial, self.forced_torsional)
        return {vibration.kind: vibration for vibration in both if vibration is not None} or None

    @cached_property
    def assumed(self) -> Part[tuple[AssumedInput, ...]]:
        """Inputs that nobody gave."""
        return assumed_values(input_values(self.engine_file))

    @cached_property
    def not_comparable(self) -> Part[str | None]:
        """Why the whole crankshaft is not compared with the chains."""
        return not_comparable(self.engine_file) or None

    @cached_property
    def thrust(self) -> Annotated[AxialForces | None, Quantity(key="axial_force")]:
        """Axial force over the cycle, and largest at running speeds."""
        compared = self.comparison
        if self.axial_force is None or self.forced_axial is None:
            return None
        # Without a chain to compare with, the whole crankshaft lacks the plant.
        coupled = None if compared is None or compared.axial is None else compared.coupled
        return axial_forces(self.axial_force, self.forced_axial, self.engine_file, coupled)

    @cached_property
    def whole_crankshaft(self) -> Annotated[WholeVibration | None, Quantity(key="whole")]:
        """Modes of the whole crankshaft, its comparison with the chains, and its critical speeds."""
        if self.whole is None or self.comparison is None:
            return None
        criticals = whole_criticals(self.engine_file, self.comparison, self.torsional.chosen.chain)
        return WholeVibration(self.whole, self.comparison, criticals)

    @property
    def analysis(self) -> ThrowAnalysis:
        """That of the throw; of several, that of the throw at the free end."""
        return self.analyses[self.engine_file.throw_names[0]]

    @property
    def axial_chain(self) -> Chain:
        """The axial chain with the compliances of the chosen source."""
        return self.axial.chosen.chain.chain

    @property
    def torsional_chain(self) -> Chain:
        """The torsional chain with the compliances of the chosen source."""
        return self.torsional.chosen.chain.chain

    @property
    def forced(self) -> ForcedVibration | None:
        """Forced vibration in torsion, `forced_torsional`."""
        return self.forced_torsional

    def forced_of(self, kind: str) -> ForcedVibration | None:
        """Forced vibration of one kind; None if the gas pressure is unknown."""
        return (self.forced_by_kind or {}).get(kind)

    def modes(self, kind: str) -> Vibration:
        """Modes and critical speeds of one kind."""
        return self.axial if kind == "axial" else self.torsional

    @cached_property
    def running_range(
        self,
    ) -> Annotated[tuple[float, float], Quantity("rad/s", exported="1/min", key="running_rpm")]:
        """Lowest and highest running speed."""
        engine = self.engine_file.engine
        return engine.lowest_speed, engine.highest_speed

    @property
    def worst_check(self) -> LimitCheck | None:
        """The limit with the largest use at its worst speed; None if nothing is forced."""
        return None if self.assessment is None else self.assessment.verdict.checks[0]

    def plot(
        self, axes: "Axes | None" = None, *, kind: Kind = "torsional", show: Shown = "campbell"
    ) -> "Axes":
        """Draw one diagram of one kind of vibration.

        Parameters
        ----------
        kind : {"torsional", "axial"}
        show : str
            "campbell": natural frequencies, orders, and their intersections; "modes": first mode shapes;
            "amplitude" (of the free end), "stress", "load" and "power" over the speed, with limits and
            barred ranges; "limits": the use of all limits; "shaft": the whole
            crankshaft's first elastic mode.

        Raises
        ------
        InputError
            If an option is unknown, or the quantity was not calculated.
        """
        check_choice("kind", kind, ("axial", "torsional"), "these are calculated")
        check_choice("show", show, SHOWN, "these are diagrams of vibration")
        vibration, forced = self.modes(kind), self.forced_of(kind)
        if show == "modes":
            return vibration.plot(axes)
        if show == "campbell":
            axes = new_axes(axes)
            self._draw_campbell(axes, vibration, forced)
            return axes
        if show == "shaft" and self.whole is not None:
            return self.whole.plot(axes, radius=self.engine_file.throw.crank_radius)
        if show == "limits" and self.assessment is not None:
            return self.assessment.plot(axes)
        assessment = self.assessment
        if forced is None or assessment is None or show == "shaft" or show == "limits":
            raise InputError(
                f"show: given {show!r}; allowed is what was calculated, because forced vibration needs gas "
                "pressure in the engine file, and the whole crankshaft coupled=True."
            )
        limit = LIMITS.get(show, "").format(kind=kind)
        return forced.plot(
            axes,
            show=show,
            limits=assessment.limit_curve(limit, forced.response.speeds),
            barred=() if show == "power" else assessment.verdict.ranges_to_bar,
        )

    def slopes(self) -> "VibrationSlopes":
        """How frequencies and the worst limit's use change with the engine's dimensions and elements.

        In per cent for one per cent of each. A throw without slopes is named in `left_out`.
        """
        from crankfem.analyses.vibration.input_slopes import (
            vibration_slopes,  # here: few ask for them
        )

        return vibration_slopes(
            self.engine_file,
            self.analyses,
            self.shaft,
            self.axial.chosen,
            self.torsional.chosen,
            None if self.assessment is None else self.assessment.verdict.deciding,
        )

    def to_pandas(self) -> Any:
        """Return a table of the elastic natural frequencies of both chains.

        Units are in ``frame.attrs["units"]``.
        """
        rows = [
            (vibration.kind, number, frequency)
            for vibration in (self.axial, self.torsional)
            for number, frequency in enumerate(
                vibration.chosen.elastic_frequencies.tolist(), start=1
            )
        ]
        kinds, numbers, frequencies = zip(*rows, strict=True)
        return table(
            {"kind": (kinds, ""), "mode": (numbers, "1"), "frequency": (frequencies, "Hz")}
        )

    def _draw_campbell(
        self, axes: "Axes", vibration: Vibration, forced: ForcedVibration | None
    ) -> None:
        engine = self.engine_file.engine
        orders = engine_orders(engine.strokes, self.engine_file.vibration.highest_order)
        draw_campbell(
            axes,
            vibration.chosen.elastic_frequencies if forced is None else forced.frequencies,
            orders,
            (engine.lowest_speed, engine.highest_speed),
            vibration.criticals if forced is None else forced.peaks,
        )
        write_title(axes, f"{engine.name}, {vibration.kind}")


def engine_vibration(
    engine: str | Path | EngineFile,
    *,
    analysis: Analyses | None = None,
    model: "ComplianceModel | None" = None,
    coupled: bool = False,
    step: Callable[[str], None] | None = None,
) -> EngineVibration:
    """Calculate the vibration of an engine.

    Parameters
    ----------
    engine : path or EngineFile
        Engine file, name of a shipped engine, or the engine as read and perhaps changed
        (`EngineFile.changed`).
    analysis : ThrowAnalysis or mapping, optional
        Of its throw, if available; of several throws a mapping by name.
    model : ComplianceModel, optional
        Regression of compliances, one more source of them; by default the one named in the file.
    coupled : bool, optional
        Whether to calculate the whole crankshaft too, from superelements of its throws (seconds).
    step : callable, optional
        Called with the name of each step.

    Raises
    ------
    InputError
        If the file cannot be used, a regression that does not cover the throws is to be the source, or
        the analysis is that of another engine.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    tell = step or (lambda _: None)
    read = engine if isinstance(engine, EngineFile) else load_engine(engine)
    analyses = None if analysis is None else analyses_by_name(read, analysis)
    for name, throw_analysis in (analyses or {}).items():
        calculated = throw_analysis.throw, throw_analysis.material
        if calculated != (read.named_throws[name], read.material):
            throw = f"named_throws[{name!r}]" if read.throws_by_name else "throw"
            raise InputError(
                "analysis: given that of another throw or material; allowed is that of the engine's own, by "
                f"analyze_throw(engine.{throw}, engine.material), because its compliances are used."
            )
    forcing = read.gas is not None or read.gas_map is not None
    harmonics = engine_harmonics(read) if forcing else None
    refuse_vibration(read)
    model = usable_model(read, model)
    load = engine_load(read) if forcing else None
    if analyses is None:
        tell("Analyzing the throw" if len(read.named_throws) == 1 else "Analyzing the throws")
        analyses = analyze_throws(read)
    tell("Calculating vibration")
    shaft = compliances_in_shaft(read, analyses)
    axial = axial_vibration(read, analyses, shaft, model)
    torsional = torsional_vibration(read, analyses, shaft, model)
    nominal = HeldChains(read.main_bearings.stiffness, shaft, axial, torsional)
    held = chains_over_bearings(read, analyses, model, nominal)
    lengthened = twisted = assessment = whole = comparison = misfiring = axial_force = None
    note = ""
    if coupled:
        tell("Calculating the whole crankshaft")
        whole = whole_shaft(read, analyses)
    if harmonics is not None:
        modes = None if whole is None else whole.modes
        further = () if modes is None else modes.frequencies[modes.rigid :]
        lengthened, twisted = forced_vibrations(
            read, harmonics, axial, torsional, shaft, analyses, further
        )
        ready = EngineChains.of(read, axial, torsional, shaft)
        axial_force = axial_cycle(ready, harmonics)
        if not read.engine.driven_by:
            tell("Calculating misfiring")
        misfiring, note = misfiring_or_reason(ready, harmonics)
        if held:
            tell("Varying the main bearings")
            held = with_answers(read, held, harmonics)
        if read.ranges is not None:
            tell("Sampling what is uncertain")
        answered = replace(nominal, answers=(lengthened, twisted))
        assessment = assess(read, harmonics, answered, analyses, model, held)
        if misfiring is not None:
            misfiring = misfiring.outside(assessment.verdict.ranges_to_bar)
    if whole is not None:
        answer = None if twisted is None else shaft_response(read, whole, twisted.forces)
        running = (read.engine.lowest_speed, read.engine.highest_speed)
        comparison = (
            ShaftComparison(answer, running_range=running)
            if not_comparable(read)
            else compare_with_chains(
                whole,
                axial.chosen.chain,
                torsional.chosen.chain,
                answer,
                None if lengthened is None else lengthened.response,
                None if twisted is None else twisted.response,
                running,
            )
        )
        rigid = held_chains(read, analyses, model, math.inf)
        comparison = with_differences(
            comparison,
            whole,
            (axial.chosen.chain, torsional.chosen.chain),
            (rigid.chain("axial"), rigid.chain("torsional")),
        )
    sweep = None
    if held:
        verdict = None if assessment is None else assessment.verdict
        sweep = bearing_sweep(read, held, whole, verdict)
    if assessment is not None and sweep is not None:
        assessment = with_bearings(assessment, sweep)
    if assessment is not None and comparison is not None:
        cranks = torsional.chosen.chain
        assessment = with_whole_shaft(assessment, read, comparison, cranks, ready.moduli)
    return EngineVibration(
        engine_file=read,
        analyses=analyses,
        shaft=shaft,
        axial=axial,
        torsional=torsional,
        forced_axial=lengthened,
        forced_torsional=twisted,
        assessment=assessment,
        whole=whole,
        comparison=comparison,
        misfiring=misfiring,
        misfiring_note=note or None,
        load=load,
        bearings=sweep,
        axial_force=axial_force,
    )
