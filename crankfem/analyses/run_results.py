"""The results of a run, as results.json holds them."""

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Annotated, Any

from crankbase.results import Number, Part, Quantity, Result, Speed, result
from crankfem.analyses.findings import Finding, Grounds, findings
from crankfem.analyses.mechanism.mechanism_results import MechanismResults
from crankfem.analyses.mechanism.torque_harmonics import TableHarmonics
from crankfem.analyses.provenance import Provenance, Repetition
from crankfem.analyses.self_checks import Check, chain_checks, check, study_checks, throw_checks
from crankfem.analyses.shaft.whole_records import ShaftBalance, ThrowsInShaft
from crankfem.analyses.strength.cycle_fatigue import EngineFatigue
from crankfem.analyses.strength.engine_strength import EngineStrength
from crankfem.analyses.study.study_results import FittedStudy
from crankfem.analyses.throw.formula_records import CompliancesOverAngle, Formulas
from crankfem.analyses.throw.stress import StressResults
from crankfem.analyses.throw.throw_record import ThrowResults
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.reading.toml_file import InputRecord
from dynamics.critical import TwoMassCheck
from dynamics.response.loads import LARGEST_POWER_ERROR
from dynamics.torque import LARGEST_ENERGY_ERROR
from fem.angle_law import SYMMETRIC

Optional = Part[dict[str, Any] | None]


@result("cranks", "throw.mass")
class NamedThrow(Result):
    """One of several throws of an engine; cranks count from 1."""

    cranks: Annotated[tuple[int, ...], Quantity("1")]
    throw: ThrowResults
    formulas: Formulas
    fillets: StressResults | None
    fillet_note: str | None


@result("name", "cylinders")
class EngineFacts(Result):
    """What a report tells of an engine."""

    name: str
    cylinders: int
    strokes: int
    bore: Annotated[float, Quantity("m")]
    stroke: Annotated[float, Quantity("m")]
    file: str
    v_engine: bool
    reciprocating: str
    crank_angles: Annotated[tuple[float, ...], Quantity("rad")]
    firing_order: Annotated[tuple[int, ...], Quantity("1")]
    firing_intervals_deg: Annotated[tuple[float, ...], Quantity("deg")]
    mean_piston_speed: Annotated[float, Quantity("m/s")]
    rated_speed: Speed
    lowest_speed: Speed
    highest_speed: Speed
    major_orders: Annotated[tuple[float, ...], Quantity("1")]
    highest_order: Number
    radial_force_from_gas: bool
    driven_by: Annotated[str | None, Quantity(left_out=True)] = None


@result("title")
class AddedPart(Result):
    """A part of a report that is no part of the run: another command added it.

    Attributes
    ----------
    figure : str
        Name of its picture and its plot.
    alt, caption : str
        What is said in place of the figure, and below it.
    sentences : tuple of str
    heads, rows : tuple
        Of a table, as it is printed.
    """

    title: str
    sentences: tuple[str, ...]
    figure: str
    alt: str
    caption: str
    table_caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@result("pictures")
class RunResults(Result):
    """All numbers of a run, and the names of its pictures.

    Parameters
    ----------
    throw, formulas, fillets
        Of the throw at the free end.
    throws : mapping or None
        Of an engine with several throws, by their names.
    warned_fields : tuple of str
        What the warnings of the input are about.
    pictures, interactive : dict
        Names of static pictures and of interactive plots to their files.
    """

    about: Provenance
    engine: EngineFacts
    inputs: tuple[InputRecord, ...]
    input_warnings: tuple[str, ...]
    warned_fields: tuple[str, ...]
    sources: dict[str, str]
    throw: ThrowResults
    formulas: Formulas
    angle_law: CompliancesOverAngle
    balance: ShaftBalance
    fillets: StressResults | None
    fillet_note: str | None
    mechanism: MechanismResults | None
    study: FittedStudy | None
    harmonics: TableHarmonics | None
    two_mass: TwoMassCheck | None
    shaft: ThrowsInShaft
    vibration: EngineVibration
    strength: EngineStrength | None
    fatigue: EngineFatigue | None
    fatigue_note: str | None
    throws: Annotated[Mapping[str, NamedThrow] | None, Quantity(left_out=True)]
    repeat: Repetition
    checks: tuple[Check, ...] = ()
    pictures: dict[str, str] = field(default_factory=dict)
    interactive: dict[str, str] = field(default_factory=dict)
    # What results say until the pictures are there.
    picture_note: str | None = "The run ended before its pictures were drawn."
    added: Annotated[AddedPart | None, Quantity(left_out=True)] = None

    @property
    def findings(self) -> Part[tuple[Finding, ...]]:
        """What follows from the results, in the order in which a console tells it."""
        return findings(
            Grounds(
                self.vibration,
                self.inputs,
                self.engine.highest_order,
                self.input_warnings,
                self.warned_fields,
                self.strength,
                self.fatigue,
                self.checks,
            )
        )


def run_checks(
    results: RunResults, length: float, pin_center: Sequence[float]
) -> tuple[Check, ...]:
    """Return all self-checks possible with the results of a run.

    Parameters
    ----------
    length, pin_center
        As for `throw_checks`.

    Returns
    -------
    tuple of Check
        In the order in which a report shows them.
    """
    checks = throw_checks(results.throw, length, pin_center)
    by_elements, fillets, mechanism = results.formulas.fe, results.fillets, results.mechanism
    if by_elements is not None and by_elements.angle_law is not None:
        pinned = results.throw.supports["pinned"].axial
        checks.append(
            check(
                "Opposite neighbors compared with pinned ends",
                by_elements.axial_rigid_sections / pinned - 1.0,
                "With equal webs and rigid sections, a throw between opposite cranks tilts as freely as "
                "one with pinned ends, so both compliances must agree as far as the webs are equal.",
                # What the angle law takes for equal webs.
                allowed=SYMMETRIC,
            )
        )
    if fillets is not None:
        checks.append(
            check(
                "Error of the fillet stresses",
                fillets.error_estimate,
                "Largest estimate from successive meshes.",
                shown_unit="%",
                allowed=fillets.accuracy,
                met=fillets.accuracy_met,
            )
        )
    checks += study_checks(results.study)
    if mechanism is not None:
        checks.append(
            check(
                "Energy of the crank mechanism",
                abs(mechanism.energy_error),
                "Difference between the work of the torque over a cycle and the work of the gas, relative "
                "to the work exchanged.",
                allowed=LARGEST_ENERGY_ERROR,
            )
        )
    checks += [
        check(
            f"Power of the {kind} vibration",
            forced.largest_power.error,
            "Power of the exciting forces compared with the heat in all damping, at speeds with bounded "
            "vibration.",
            allowed=LARGEST_POWER_ERROR,
        )
        for kind, forced in (results.vibration.forced_by_kind or {}).items()
    ]
    return (*checks, *chain_checks(results.vibration.whole_crankshaft))
