"""The results of a run, as results.json holds them, and its self-checks."""

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.results import Number, Part, Quantity, Result, Speed, result
from crankfem.analyses.mechanism.mechanism_results import MechanismResults
from crankfem.analyses.mechanism.torque_harmonics import TableHarmonics
from crankfem.analyses.provenance import Provenance, Repetition
from crankfem.analyses.shaft.whole_records import ShaftBalance, ThrowsInShaft
from crankfem.analyses.strength.cycle_fatigue import EngineFatigue
from crankfem.analyses.strength.engine_strength import EngineStrength
from crankfem.analyses.study.study_results import FittedStudy
from crankfem.analyses.throw.formula_records import CompliancesOverAngle, Formulas
from crankfem.analyses.throw.stress import StressResults
from crankfem.analyses.throw.throw_record import ThrowResults
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.whole_verdict import WholeVibration
from crankfem.files.reading.toml_file import InputRecord
from dynamics import wording
from dynamics.critical import TwoMassCheck
from dynamics.response.loads import LARGEST_POWER_ERROR
from dynamics.torque import LARGEST_ENERGY_ERROR
from fem.angle_law import SYMMETRIC
from fem.end_reactions import EndReaction
from fem.solver import LARGEST_ROUND_OFF, rigid_body_residual
from regression.response_kinds import AXIAL, TORSIONAL

Array = NDArray[np.float64]
Figure = Annotated[float | None, Quantity("1")]


@result("figure", "allowed", "met")
class Check(Result):
    """A self-check of a calculation.

    Parameters
    ----------
    unit, shown_unit : str
        "1" for a share, else a word; "%" shows a share that is more than round-off.
    allowed : float or None
        None where nothing is.
    met : bool or None
        None where the check does not judge.
    sentence : str
        What the figure means.
    """

    name: str
    figure: Figure
    unit: str
    shown_unit: str
    allowed: Figure
    met: bool | None
    sentence: str


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


def unbalanced_share(
    ends: Sequence[EndReaction], places: ArrayLike, force: ArrayLike, at: ArrayLike
) -> float:
    """Return the unbalanced part of the reactions to a force, relative to its size.

    Parameters
    ----------
    ends : sequence of EndReaction
        Of the supports on the shaft.
    places : (ends, 3) array
        Their positions [m].
    force : (3,) array
        Force on the pin [N].
    at : (3,) array
        Position of its resultant [m].

    Returns
    -------
    float
        The larger of unbalanced force / force and unbalanced moment / (force x distance of the ends).
    """
    places, force, at = (np.asarray(vector, dtype=float) for vector in (places, force, at))
    forces = np.array([end.force for end in ends])
    moments = np.array([end.moment for end in ends])
    size = float(np.linalg.norm(force))
    arm = float(np.linalg.norm(places[-1] - places[0]))
    left_over = forces.sum(axis=0) + force
    turning = moments.sum(axis=0) + np.cross(places, forces).sum(axis=0) + np.cross(at, force)
    return max(
        float(np.linalg.norm(left_over)) / size, float(np.linalg.norm(turning)) / (size * arm)
    )


def run_checks(
    results: RunResults, length: float, pin_center: Sequence[float]
) -> tuple[Check, ...]:
    """Return all self-checks possible with the results of a run.

    Parameters
    ----------
    length : float
        Of the throw [m].
    pin_center : (3,) sequence
        Middle of the first pin as it is meshed, in the throw frame [m].

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
            _check(
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
            _check(
                "Error of the fillet stresses",
                fillets.error_estimate,
                "Largest estimate from successive meshes.",
                shown_unit="%",
                allowed=fillets.accuracy,
                met=fillets.accuracy_met,
            )
        )
    checks += _study_checks(results.study)
    if mechanism is not None:
        checks.append(
            _check(
                "Energy of the crank mechanism",
                abs(mechanism.energy_error),
                "Difference between the work of the torque over a cycle and the work of the gas, relative "
                "to the work exchanged.",
                allowed=LARGEST_ENERGY_ERROR,
            )
        )
    checks += [
        _check(
            f"Power of the {kind} vibration",
            forced.largest_power.error,
            "Power of the exciting forces compared with the heat in all damping, at speeds with bounded "
            "vibration.",
            allowed=LARGEST_POWER_ERROR,
        )
        for kind, forced in (results.vibration.forced_by_kind or {}).items()
    ]
    return (*checks, *_chain_checks(results.vibration.whole_crankshaft))


def _check(
    name: str,
    figure: float | None,
    sentence: str,
    *,
    unit: str = "1",
    shown_unit: str | None = None,
    allowed: float | None = None,
    met: bool | None = None,
) -> Check:
    """Make a check; without `met`, the figure is compared with the permitted one."""
    if met is None and allowed is not None and figure is not None:
        met = abs(figure) <= allowed
    return Check(name, figure, unit, shown_unit or unit, allowed, met, sentence)


def throw_checks(throw: ThrowResults, length: float, pin_center: Sequence[float]) -> list[Check]:
    """Return the self-checks possible with the results of a throw; arguments as for `run_checks`."""
    stiffness = throw.stiffness
    radial = (0.0, -throw.radial_force, 0.0)
    worst = max(
        unbalanced_share(
            (support.reactions.left, support.reactions.right),
            ((0.0, 0.0, 0.0), (0.0, 0.0, length)),
            radial,
            pin_center,
        )
        for support in throw.supports.values()
    )
    reciprocity = throw.reciprocity
    assert reciprocity is not None
    return [
        _check(
            "Error of the axial compliance",
            throw.error_estimate,
            "Error left after the correction for discretization: of 100 random throws tested, 95 had a "
            "smaller one."
            if throw.axial_correction
            else "Estimated from the finite-element stresses; the true compliance is larger by about this "
            "much.",
            shown_unit="%",
            allowed=throw.accuracy,
            met=throw.accuracy_met,
        ),
        _check(
            "Rigid-body motions of the stiffness",
            rigid_body_residual(stiffness, length),
            "A rigid-body motion must cause no force: largest force found, relative to the largest "
            "stiffness.",
            allowed=LARGEST_ROUND_OFF,
        ),
        _check(
            "Symmetry of the stiffness",
            reciprocity.asymmetry,
            "Reciprocity: largest difference between the stiffness from end-section forces and its "
            "transpose, relative to the largest stiffness. The stiffness used follows from strain energies "
            "and is always symmetric.",
            allowed=LARGEST_ROUND_OFF,
        ),
        _check(
            "Equilibrium of the reactions",
            worst,
            "Residual of the forces and moments at both ends and the radial force at the middle of the "
            "meshed pin, for pinned and guided ends.",
            allowed=LARGEST_ROUND_OFF,
        ),
        _check(
            "Axial reaction by reciprocity",
            reciprocity.axial_reaction,
            "Difference, relative to Z, between the axial reaction of the held ends to a radial force Z on "
            "the pin and c Z / e_n, with c from the motion of the pin when the ends are moved.",
            allowed=LARGEST_ROUND_OFF,
        ),
        _check(
            "Elements mended",
            throw.mended_elements,
            "Elements turned inside out by the curved surface; all were straightened.",
            unit="elements",
        ),
    ]


def _study_checks(study: FittedStudy | None) -> list[Check]:
    chosen = {
        name.removesuffix("_compliance"): fits.selected()
        for name, fits in ({} if study is None else study.fits).items()
        if name in (AXIAL, TORSIONAL)
    }
    return [
        _check(
            f"Error of the {kind} regression",
            fit.largest_heldout_error,
            f"Largest error of the chosen form ({fit.form}) at held-out designs.",
            shown_unit="%",
        )
        for kind, fit in chosen.items()
    ]


def _chain_checks(whole: WholeVibration | None) -> list[Check]:
    chain_checks = []
    for kind, chain in ({} if whole is None else whole.comparison.chains).items():
        first = chain.modes[0] if chain.modes else None
        shaft = None if first is None else first.shaft_frequency
        figure = None if first is None or shaft is None else first.chain_frequency / shaft - 1.0
        chain_checks.append(
            _check(
                f"The {kind} chain compared with the whole crankshaft",
                figure,
                f"First {kind} frequency of the chain compared with that of the whole crankshaft. "
                + (wording.ADEQUATE if chain.suffices else wording.INADEQUATE),
                shown_unit="%",
                # Frequencies, shares of the energy and amplitudes decide together.
                met=chain.suffices,
            )
        )
    return chain_checks
