"""The whole vibration calculation of an engine: modes, forced response, verdict, whole crankshaft."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from crankfem.engine_file import EngineFile, load_engine
from crankfem.mechanism_file import MechanismFile, load_mechanism
from crankfem.vibration.assessment import Assessment, assess
from crankfem.vibration.excitation import engine_harmonics
from crankfem.vibration.forced import ForcedVibration, forced_vibrations
from crankfem.vibration.modes import Vibration, axial_vibration, torsional_vibration
from crankfem.vibration.sources import compliances_in_shaft
from crankfem.vibration.whole_shaft import (
    ShaftComparison,
    WholeShaft,
    compare_with_chains,
    left_out,
    shaft_response,
    whole_shaft,
)
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.shaft import ShaftCompliances
from geometry.errors import InputError
from regression.models.compliance_model import ComplianceModel


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
        Engine file, name of a shipped engine, or the file as read.
    analysis : ThrowAnalysis, optional
        Of its throw, where it is there already.
    mechanism : MechanismFile, optional
        Of the same file, where it is read already.
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
        If the file cannot be used.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    read = engine if isinstance(engine, EngineFile) else load_engine(engine)
    mechanism = mechanism or load_mechanism(read.path)
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
