"""What a study keeps of a throw: its responses, each with an estimate of its discretization error.

Under its supports a throw's axial answers are those of one symmetry class, its torsional ones those of
another; no others are solved for a throw with equal webs. Every answer is corrected for what
discretization takes from it (`fem.correction`), and its error is a share of that.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from crankbase.stopwatch import Stopwatch
from fem.accuracy import Mesher, Problem, RefinementLevel, solve_to_accuracy
from fem.angle_law import effective_angle_law
from fem.class_compliances import unit_response
from fem.condensation import CondensedClass
from fem.correction import error_bars
from fem.fillet_stress import fillet_stresses
from fem.loads import RADIAL, radial_directions
from fem.material import STEEL, Material
from fem.section_motions import RIGID, SHARED, degree_of
from fem.superelement import RX, RY, combine_classes
from fem.supports import STRETCH, TWIST
from fem.symmetry import axial_class, symmetry_classes, torsional_class
from geometry.mass import mass_properties
from geometry.mesher import mesh_isolated
from geometry.throw import CrankThrow

Array = NDArray[np.float64]

SUPPORTS = ("pinned", "guided")
# Loads that tilt the two ends as neighbors do: against each other in the crank plane, alike across it.
TILT_IN_PLANE = np.zeros(12)
TILT_IN_PLANE[[RX, 6 + RX]] = 1.0, -1.0
TILT_ACROSS = np.zeros(12)
TILT_ACROSS[[RY, 6 + RY]] = 1.0, 1.0
# Of the unit loads of `fem.unit_loads`, those whose concentration factors the field knows.
STRESS_LOADS = ("bending", "torsion")
STRESS_ACCURACY = 0.05

# A value and its estimated relative error.
Answer = tuple[float, float]


@dataclass(frozen=True)
class ResponseKind:
    """A response: its symbol, SI unit ("" for a plain number) and meaning."""

    symbol: str
    unit: str
    meaning: str


RESPONSES: Mapping[str, ResponseKind] = MappingProxyType(
    {
        "axial_compliance_pinned": ResponseKind("e_n", "m/N", "axial compliance, ends pinned"),
        "axial_compliance_guided": ResponseKind("e_g", "m/N", "axial compliance, ends guided"),
        "axial_compliance_opposite": ResponseKind(
            "e_180", "m/N", "axial compliance between opposite neighbors, 180 deg"
        ),
        "axial_compliance_in_line": ResponseKind(
            "e_0", "m/N", "axial compliance between neighbors in line, 0 deg"
        ),
        "tilt_stiffness_ratio": ResponseKind(
            "rho", "", "tilt stiffness across the crank plane divided by that in it"
        ),
        "torsional_compliance_pinned": ResponseKind(
            "e_t", "rad/(N m)", "torsional compliance, ends pinned"
        ),
        "torsional_compliance_guided": ResponseKind(
            "e_tg", "rad/(N m)", "torsional compliance, ends guided"
        ),
        "influence_coefficient_pinned": ResponseKind(
            "c", "m/N", "lengthening per unit radial force on the pin, ends pinned"
        ),
        "influence_coefficient_guided": ResponseKind(
            "c_g", "m/N", "lengthening per unit radial force on the pin, ends guided"
        ),
        "influence_coefficient_opposite": ResponseKind(
            "c_180", "m/N", "influence coefficient between opposite neighbors, 180 deg"
        ),
        "influence_coefficient_in_line": ResponseKind(
            "c_0", "m/N", "influence coefficient between neighbors in line, 0 deg"
        ),
        "axial_reaction_pinned": ResponseKind(
            "P/Z", "", "axial reaction per unit radial force on the pin, length kept, ends pinned"
        ),
        "axial_reaction_guided": ResponseKind(
            "P_g/Z", "", "axial reaction per unit radial force on the pin, length kept, ends guided"
        ),
        "mass": ResponseKind("m", "kg", "mass"),
        "fillet_stress_factor": ResponseKind(
            "k_s",
            "",
            "largest stress concentration factor at the fillets, under bending in the crank plane and "
            "under torque",
        ),
    }
)


@dataclass(frozen=True)
class ThrowResponses:
    """The responses of one throw.

    Attributes
    ----------
    values : dict
        By the names of `RESPONSES`, SI units.
    errors : dict
        Estimated relative error of each.
    unknowns : int
        Of the meshed part.
    """

    values: dict[str, float]
    errors: dict[str, float]
    unknowns: int


def evaluate_throw(
    throw: CrankThrow,
    material: Material = STEEL,
    accuracy: float = 0.01,
    stresses: bool = False,
    mesher: Mesher = mesh_isolated,
) -> ThrowResponses:
    """Compute all responses of a throw.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    accuracy : float
        Wished relative accuracy of the axial compliance (pinned), 0.001 to 0.1; the others share its
        mesh and come out with errors of their own.
    stresses : bool
        Also find the largest stress concentration factor at the fillets, which takes several times as
        long as everything else.
    mesher : callable
        As for `fem.analysis.analyze_throw`.

    Returns
    -------
    ThrowResponses

    Raises
    ------
    InputError
        If an argument is out of range, or stresses are asked of a throw without fillets.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    problem = Problem(material, "auto", "rigid", Stopwatch(), degree_of(SHARED))
    level = solve_to_accuracy(throw, accuracy, problem, mesher)
    part = level.mesh.part
    solved = dict.fromkeys((axial_class(part), torsional_class(part)))
    classes = level.condense(
        tuple(solved) if part == "quarter" else symmetry_classes(part), problem
    )
    by_class = {one.symmetry: one.up_to(RIGID) for one in classes}
    axial = _class_responses(by_class[axial_class(part)], level, STRETCH, TILT_IN_PLANE)
    torsional = _class_responses(by_class[torsional_class(part)], level, TWIST, TILT_ACROSS)
    answers: dict[str, Answer] = {}
    for number, support in enumerate(SUPPORTS):
        compliance, influence = axial.compliances[number], axial.influences[number]
        answers[f"axial_compliance_{support}"] = compliance
        answers[f"torsional_compliance_{support}"] = torsional.compliances[number]
        answers[f"influence_coefficient_{support}"] = influence
        answers[f"axial_reaction_{support}"] = _ratio(influence, compliance)
    answers |= _angle_law_responses(throw, classes, axial, torsional)
    mass = mass_properties(level.mesh, material.density).mass
    answers["mass"] = (mass, abs(mass / (material.density * throw.volume) - 1.0))
    if stresses:
        answers["fillet_stress_factor"] = _largest_factor(throw, material, mesher)
    order = [name for name in RESPONSES if name in answers]
    return ThrowResponses(
        {name: answers[name][0] for name in order},
        {name: abs(answers[name][1]) for name in order},
        level.mesh.unknowns,
    )


@dataclass(frozen=True)
class _ClassResponses:
    """Responses of one symmetry class.

    Attributes
    ----------
    compliances : list of (value, error)
        Under the class's unit end load, for each of `SUPPORTS`.
    influences : list of (value, error)
        Motion along that load under a unit radial force on the first pin, for each of `SUPPORTS`.
    tilt : (value, error)
        Of the moments that tilt both ends as neighbors do, ends pinned.
    """

    compliances: list[Answer]
    influences: list[Answer]
    tilt: Answer


def _class_responses(
    part: CondensedClass, level: RefinementLevel, load: Array, tilt: Array
) -> _ClassResponses:
    """Solve a class under its end load, under the radial force on the pin and the tilting moments."""
    values = _class_values(part, load, tilt)
    plain = _class_values(part.discrete or part, load, tilt)
    bars = error_bars(values, plain, level.axial_correction, missing=part.missing)
    errors = bars / np.where(values == 0.0, 1.0, np.abs(values))
    found = list(zip(values.tolist(), errors.tolist(), strict=True))
    return _ClassResponses(found[:2], found[2:4], found[4])


def _class_values(part: CondensedClass, load: Array, tilt: Array) -> Array:
    """Compliances and influences (2 each) for each of `SUPPORTS`, and the tilt."""
    pull, moments = load @ part.symmetry.ends, tilt @ part.symmetry.ends
    radial = part.pin_loads[0, :, :3] @ RADIAL
    amplitudes = np.array([unit_response(part, support, pull) for support in SUPPORTS])
    tilting = unit_response(part, "pinned", moments) @ moments
    return np.concatenate([amplitudes @ pull, amplitudes @ radial, [tilting]])


def _ratio(numerator: Answer, denominator: Answer) -> Answer:
    """Quotient of two answers whose errors are not known to be alike."""
    return numerator[0] / denominator[0], math.hypot(numerator[1], denominator[1])


def _angle_law_responses(
    throw: CrankThrow,
    classes: Sequence[CondensedClass],
    axial: _ClassResponses,
    torsional: _ClassResponses,
) -> dict[str, Answer]:
    """e_0, e_180, c_0, c_180 and rho; see `fem.angle_law`.

    They have the errors of guided and pinned ends, and of the tilts. Of a throw with equal webs an axial
    force excites two classes only, whatever the angle: those that a half turn about the crank's axis keeps.
    """
    pinned, guided = range(2)
    ratio = _ratio(axial.tilt, torsional.tilt)
    law = effective_angle_law(combine_classes(classes, radial_directions(throw)))
    return {
        "axial_compliance_opposite": (law.opposite, axial.compliances[pinned][1]),
        "axial_compliance_in_line": (law.in_line, axial.compliances[guided][1]),
        "tilt_stiffness_ratio": (law.ratio, ratio[1]),
        "influence_coefficient_opposite": (law.influence_opposite, axial.influences[pinned][1]),
        "influence_coefficient_in_line": (law.influence_in_line, axial.influences[guided][1]),
    }


def _largest_factor(throw: CrankThrow, material: Material, mesher: Mesher) -> Answer:
    found = fillet_stresses(throw, material, STRESS_ACCURACY, mesher=mesher)
    peaks = [peak for peak in found.peaks if peak.load.kind in STRESS_LOADS]
    largest = max(peaks, key=lambda peak: peak.factor)
    return largest.factor, largest.error_estimate
