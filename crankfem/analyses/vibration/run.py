"""The whole vibration calculation of an engine: modes, forced response, verdict, whole crankshaft."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from crankbase.checks.choices import check_choice
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.tables.frames import table
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.whole_shaft import (
    ShaftComparison,
    WholeShaft,
    compare_with_chains,
    left_out,
    shaft_response,
    whole_beside,
    whole_shaft,
)
from crankfem.analyses.vibration.assessment import Assessment, assess
from crankfem.analyses.vibration.excitation import engine_harmonics
from crankfem.analyses.vibration.forced import ForcedVibration, forced_vibrations
from crankfem.analyses.vibration.modes import Vibration, axial_vibration, torsional_vibration
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.mechanism_file import MechanismFile, layout_of, mechanism_of
from dynamics.assessment.verdict import LimitCheck
from dynamics.chains.chain import Chain
from dynamics.critical import engine_orders, major_orders
from dynamics.plots.campbell import draw_campbell
from fem.analysis import analyze_throw
from fem.shaft import ShaftCompliances
from fem.throw_analysis import ThrowAnalysis
from regression.models.compliance_model import ComplianceModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Kind = Literal["axial", "torsional"]
Shown = Literal["campbell", "modes", "amplitude", "stress", "load", "power", "limits", "shaft"]
SHOWN: tuple[Shown, ...] = (
    "campbell",
    "modes",
    "amplitude",
    "stress",
    "load",
    "power",
    "limits",
    "shaft",
)
# Limits of an engine file by what they are drawn into.
LIMITS = {"amplitude": "{kind}_amplitude", "stress": "crankshaft_stress"}


@dataclass(frozen=True, eq=False)
class EngineVibration:
    """Vibration of an engine, by its uncoupled chains and by its whole crankshaft.

    Attributes
    ----------
    engine_file : EngineFile
    analysis : ThrowAnalysis
    shaft : ShaftCompliances
        Of the throws at their places.
    axial, torsional : Vibration
        Modes and critical speeds.
    forced_axial, forced_torsional : ForcedVibration or None
        None where the file has no gas pressure.
    assessment : Assessment or None
        None where nothing is forced.
    whole : WholeShaft or None
        None where it was not asked for.
    comparison : ShaftComparison or None
        Coupled response of the whole crankshaft, and how far the chains agree with it; without the latter
        where the chains have a shaft line or a propeller, which the whole crankshaft has not.
    """

    engine_file: EngineFile
    analysis: ThrowAnalysis
    shaft: ShaftCompliances
    axial: Vibration
    torsional: Vibration
    forced_axial: ForcedVibration | None
    forced_torsional: ForcedVibration | None
    assessment: Assessment | None
    whole: WholeShaft | None
    comparison: ShaftComparison | None

    @property
    def axial_chain(self) -> Chain:
        """The axial chain with the compliances of the chosen source."""
        return self.axial.chosen.chain.chain

    @property
    def torsional_chain(self) -> Chain:
        """The torsional chain with the compliances of the chosen source."""
        return self.torsional.chosen.chain.chain

    @property
    def worst_check(self) -> LimitCheck | None:
        """The limit of which most is used at its worst speed; None where nothing is forced."""
        return None if self.assessment is None else self.assessment.verdict.checks[0]

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        kind: Kind = "torsional",
        show: Shown = "campbell",
    ) -> "Axes":
        """Draw one diagram of one kind of vibration.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        kind : {"torsional", "axial"}
        show : str
            "campbell": natural frequencies, orders, and where they meet; "modes": first mode shapes;
            "amplitude" (of the free end), "stress", "load" and "power" over the speed, with limits and
            barred ranges; "limits": how far all limits are used; "shaft": energy of the whole
            crankshaft's modes.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If an option is none of these, or what is to be shown was not calculated.
        """
        check_choice("kind", kind, ("axial", "torsional"), "these are calculated")
        check_choice("show", show, SHOWN, "these are diagrams of vibration")
        vibration, forced = {
            "axial": (self.axial, self.forced_axial),
            "torsional": (self.torsional, self.forced_torsional),
        }[kind]
        if show == "modes":
            return vibration.plot(axes)
        if show == "campbell":
            axes = new_axes(axes)
            self._draw_campbell(axes, vibration, forced)
            return axes
        if show == "shaft" and self.whole is not None:
            return self.whole.plot(axes)
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

    def to_pandas(self) -> Any:
        """Return a table of the elastic natural frequencies of both chains.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        rows = [
            (one.kind, number, frequency)
            for one in (self.axial, self.torsional)
            for number, frequency in enumerate(one.chosen.elastic_frequencies.tolist(), start=1)
        ]
        kinds, numbers, frequencies = zip(*rows, strict=True)
        return table(
            {
                "kind": (kinds, ""),
                "mode": (numbers, "1"),
                "frequency": (frequencies, "Hz"),
            }
        )

    def _draw_campbell(
        self, axes: "Axes", vibration: Vibration, forced: ForcedVibration | None
    ) -> None:
        engine = self.engine_file.engine
        orders = engine_orders(engine.strokes, self.engine_file.vibration.highest_order)
        majors = major_orders(orders, engine.firing_angles)
        draw_campbell(
            axes,
            vibration.chosen.elastic_frequencies,
            orders,
            (engine.lowest_speed, engine.highest_speed),
            vibration.critical_dots(majors) if forced is None else forced.resonances,
        )
        write_title(axes, f"{engine.name}, {vibration.kind}")


def engine_vibration(
    engine: str | Path | EngineFile,
    *,
    analysis: ThrowAnalysis | None = None,
    mechanism: MechanismFile | None = None,
    model: ComplianceModel | None = None,
    coupled: bool = False,
    step: Callable[[str], None] = lambda _: None,
) -> EngineVibration:
    """Calculate the vibration of an engine.

    Parameters
    ----------
    engine : path or EngineFile
        Engine file, name of a shipped engine, or the engine as read and perhaps changed
        (`EngineFile.changed`).
    analysis : ThrowAnalysis, optional
        Of its throw, where it is there already.
    mechanism : MechanismFile, optional
        Of the same engine, where it is there already.
    model : ComplianceModel, optional
        Regression of compliances, one more source of them.
    coupled : bool, optional
        Whether the whole crankshaft is calculated too, from superelements of its throws: seconds more.
    step : callable, optional
        Told what begins.

    Returns
    -------
    EngineVibration

    Raises
    ------
    InputError
        If the file cannot be used, or analysis or mechanism are those of another engine.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    read = engine if isinstance(engine, EngineFile) else load_engine(engine)
    if mechanism is None:
        mechanism = mechanism_of(read)
    _check_same_engine(read, analysis, mechanism)
    forcing = read.gas is not None or read.gas_map is not None
    harmonics = engine_harmonics(read, mechanism) if forcing else None
    if not forcing and read.limits is not None:
        raise InputError(
            "limits: given without gas pressure; allowed are both, because amplitudes need what excites "
            "them: a section [gas] or [gas_map]."
        )
    if analysis is None:
        step("Analyzing the throw")
        analysis = analyze_throw(read.throw, read.material)
    step("Calculating vibration")
    shaft = compliances_in_shaft(read, analysis)
    axial = axial_vibration(read, analysis, shaft, model)
    torsional = torsional_vibration(read, analysis, shaft, model)
    lengthened = twisted = assessment = whole = comparison = None
    if coupled:
        step("Calculating the whole crankshaft")
        whole = whole_shaft(read, analysis)
    if harmonics is not None:
        modes = None if whole is None else whole.modes
        lengthened, twisted = forced_vibrations(
            read,
            harmonics,
            axial,
            torsional,
            shaft,
            analysis,
            () if modes is None else modes.frequencies[modes.rigid :],
        )
        if read.ranges is not None:
            step("Sampling what is uncertain")
        assessment = assess(read, lengthened, twisted, analysis)
    if whole is not None:
        answer = None if twisted is None else shaft_response(read, whole, twisted.forces)
        comparison = (
            ShaftComparison(answer)
            if left_out(read)
            else compare_with_chains(
                whole,
                axial.chosen.chain,
                torsional.chosen.chain,
                answer,
                None if lengthened is None else lengthened.response,
                None if twisted is None else twisted.response,
            )
        )
    if assessment is not None and comparison is not None:
        assessment = replace(assessment, beside=whole_beside(comparison))
    return EngineVibration(
        engine_file=read,
        analysis=analysis,
        shaft=shaft,
        axial=axial,
        torsional=torsional,
        forced_axial=lengthened,
        forced_torsional=twisted,
        assessment=assessment,
        whole=whole,
        comparison=comparison,
    )


def _check_same_engine(
    engine: EngineFile, analysis: ThrowAnalysis | None, mechanism: MechanismFile
) -> None:
    """Refuse what was calculated or read of an engine that is another one, or was another one then.

    Raises
    ------
    InputError
    """
    if analysis is not None and (analysis.throw, analysis.material) != (
        engine.throw,
        engine.material,
    ):
        raise InputError(
            "analysis: given that of another throw or material; allowed is that of the engine's own, by "
            "analyze_throw(engine.throw, engine.material), because its compliances are used."
        )
    if (mechanism.gas, mechanism.layout) != (engine.gas, layout_of(engine)):
        raise InputError(
            "mechanism: given one with other cylinders, rods or pressure than the engine's; allowed is its "
            "own, by mechanism_of(engine), because its forces are used."
        )
