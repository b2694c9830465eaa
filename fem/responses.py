"""The responses of a throw in a study, each with an estimate of its discretization error.

Every result is corrected for discretization (`fem.correction`), and its error is a
share of that.

With the throw's length L, from end section to end section, and loads of 1: Z on the pin towards the
shaft, T on it in the sense of rotation about +z, N through the throw along +z. A study fits equations to
these numbers; `regression.response_kinds` calculates all reactions from them.
"""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import MeshError
from fem.analysis import Problem, RefinementLevel, solve_level, solve_to_accuracy
from fem.angle_law import between_neighbors
from fem.correction import error_bars, slope_errors
from fem.fillet_stress import fillet_stresses
from fem.material import STEEL, Material
from fem.moved_mesh import MovedMesh, ReferenceMesh
from fem.response_table import RESPONSES
from fem.sensitivities import VOLUME_ERROR, dimension_changes
from fem.solver import Stopwatch
from fem.superelement import RX, RY, Superelement, checked_superelement, combine_classes
from fem.supports import Neighbors, Support, all_end_motions, support_throw
from fem.symmetry import SHARED, degree_of, radial_directions, symmetry_classes
from geometry.boundary_motion import STEP
from geometry.mass import mass_properties
from geometry.mesher import Mesher, mesh_isolated
from geometry.throw import CrankThrow

# Columns of loads: the axial force, the radial and the tangential one.
AXIAL, RADIAL, TANGENTIAL = 0, 2, 3


def end_moment_numbers(throw: Superelement, length: float, alike: bool) -> dict[str, float]:
    """Find the end moments of a throw per unit load and length, and rho_x.

    Parameters
    ----------
    length : float
        Of the throw [m].
    alike : bool
        Whether its webs are equal: only then its results between neighbors follow from a few numbers.

    Returns
    -------
    dict
        By the names of `fem.response_table.RESPONSES`. Radial and axial ones are moments about -x on the
        left, about +x on the right end; tangential ones are about y, half of the difference of left and
        right (opposed) or half of their sum (alike). The throw is free to lengthen.
    """
    guided = _end_moments(throw, "guided", length)
    moments = {
        "radial_end_moment_left_guided": -guided[RX, RADIAL],
        "radial_end_moment_right_guided": guided[6 + RX, RADIAL],
        "axial_end_moment_left_guided": -guided[RX, AXIAL],
        "axial_end_moment_right_guided": guided[6 + RX, AXIAL],
        "tangential_end_moment_opposed_guided": _opposed(guided),
        "tangential_end_moment_alike_guided": _alike(guided),
    }
    if not alike:
        return moments
    in_line, quarter, opposite = (
        _end_moments(throw, Neighbors(angle, angle), length) for angle in (0.0, 90.0, 180.0)
    )
    straight, turned = _opposed(in_line), _opposed(quarter)
    return moments | {
        "radial_end_moment_in_line": -in_line[RX, RADIAL],
        "axial_end_moment_in_line": -in_line[RX, AXIAL],
        "tangential_end_moment_in_line": straight,
        "tangential_end_moment_opposite": _alike(opposite),
        "cross_tilt_stiffness_ratio": turned / (straight - turned),
    }


def _end_moments(throw: Superelement, support: Support, length: float) -> Array:
    """Reactions (12, 4) on the ends of the axially free throw under each load, divided by the length."""
    element = throw.joined if isinstance(support, Neighbors) else throw
    loads = np.hstack([element.radial_loads[:, :1], element.tangential_loads[:, :1]])
    reactions = element.stiffness @ all_end_motions(throw, support, loads)
    reactions[:, RADIAL:] -= loads
    return np.asarray(reactions[:12] / length)


def _opposed(moments: Array) -> float:
    return float(moments[RY, TANGENTIAL] - moments[6 + RY, TANGENTIAL]) / 2.0


def _alike(moments: Array) -> float:
    return float(moments[RY, TANGENTIAL] + moments[6 + RY, TANGENTIAL]) / 2.0


SUPPORTS: tuple[Support, ...] = ("pinned", "guided")
RATIOS = {
    "tilt_stiffness_ratio": "axial_compliance_in_line",
    "cross_tilt_stiffness_ratio": "tangential_end_moment_in_line",
}
# Of the unit loads of `fem.fillet_peaks`, those whose concentration factors the field knows.
STRESS_LOADS = ("bending", "torsion")
STRESS_ACCURACY = 0.05

Further = Callable[[CrankThrow, Superelement, float, float], Mapping[str, float]]
# A value and its estimated relative error.
Answer = tuple[float, float]


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
    slopes : dict
        Response to its d ln(response) / d ln(dimension) by the dimension's path, where wanted and known.
    slope_errors : dict
        Estimated error of the slopes of each response. They are those of the mesh's own answer, without its
        correction, whose slopes would take two to three times as long as the rest.
    discrete : dict
        The values without correction, where the mesh was moved.
    moved : MovedMesh or None
        The mesh, where it was moved.
    """

    values: dict[str, float]
    errors: dict[str, float]
    unknowns: int
    slopes: dict[str, dict[str, float]] = field(default_factory=dict)
    slope_errors: dict[str, float] = field(default_factory=dict)
    discrete: dict[str, float] = field(default_factory=dict)
    moved: MovedMesh | None = None


def evaluate_throw(
    throw: CrankThrow,
    material: Material = STEEL,
    accuracy: float = 0.01,
    stresses: bool = False,
    mesher: Mesher = mesh_isolated,
    slopes: Collection[str] = (),
    further: Further = lambda *_: {},
    reference: ReferenceMesh | None = None,
) -> ThrowResponses:
    """Compute all responses of a throw.

    Parameters
    ----------
    accuracy : float
        Required relative accuracy of the axial compliance (pinned), 0.001 to 0.1; the others have the
        same mesh and errors of their own.
    stresses : bool
        Also find the largest stress concentration factor at the fillets, which takes several times as
        long as everything else.
    mesher : callable
        As for `fem.analysis.analyze_throw`.
    slopes : collection of str
        Paths of dimensions over which slopes are wanted (`fem.sensitivities`); the fillets' stress has none.
    further : callable
        Returns answers by name, to be treated as the others, from throw, superelement, mass and inertia.
    reference : ReferenceMesh, optional
        Whose mesh is moved, so that the answers have its accuracy. If it cannot be moved to this throw, the
        throw is meshed as without it.

    Raises
    ------
    InputError
        If an argument is out of range, or stresses are requested for a throw without fillets.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    problem = Problem(material, "auto", "rigid", Stopwatch(), degree_of(SHARED))
    moved, level = None, None
    if reference is not None:
        moved, level = _solve_moved(throw, reference, problem)
    if level is None:
        level = solve_to_accuracy(throw, accuracy, problem, mesher)
    part = level.mesh.part
    classes = level.condense(symmetry_classes(part), problem)
    radials = radial_directions(throw)
    corrected = checked_superelement(classes, radials, level.mesh)
    discrete = combine_classes([condensed.discrete or condensed for condensed in classes], radials)
    masses = mass_properties(level.mesh, material.density)
    mass, inertia = masses.mass, masses.inertia_about_shaft

    def answered(
        of: CrankThrow, superelement: Superelement, mass: float, inertia: float
    ) -> dict[str, float]:
        plain_answers = _plain_answers(superelement, of.length, part)
        return {**plain_answers, **further(of, superelement, mass, inertia)}

    values = answered(throw, corrected, mass, inertia)
    plain = answered(throw, discrete, mass, inertia)
    estimates = list(values.values()), list(plain.values())
    bars = error_bars(*estimates, level.axial_correction, missing=corrected.missing)
    answers: dict[str, Answer] = {
        name: (value, bar / abs(value or 1.0))
        for (name, value), bar in zip(values.items(), bars.tolist(), strict=True)
    }
    for support in SUPPORTS:
        (influence, error), (axial, axial_error) = (answers[name] for name in _reaction_of(support))
        # The errors may be independent.
        answers[f"axial_reaction_{support}"] = influence / axial, math.hypot(error, axial_error)
    # A ratio of differences is known less well than what it is made of.
    for name, other in RATIOS.items():
        if name in answers:
            value, error = answers[name]
            answers[name] = value, math.hypot(error, answers[other][1])
    answers["mass"] = (mass, abs(mass / (material.density * throw.volume) - 1.0))
    if stresses:
        peaks = fillet_stresses(throw, material, STRESS_ACCURACY, mesher=mesher).peaks
        loaded = [peak for peak in peaks if peak.load.kind in STRESS_LOADS]
        largest = max(loaded, key=lambda peak: peak.factor)
        answers["fillet_stress_factor"] = largest.factor, largest.error_estimate
    order = sorted(answers, key=[*RESPONSES, *answers].index)
    shares: dict[str, dict[str, float]] = {}
    slope_bars: dict[str, float] = {}
    if slopes:
        changes, _ = dimension_changes(
            throw,
            level.mesh,
            material,
            classes,
            joined=True,
            corrected=False,
            moving=reference.motion_at(throw, moved.tier, slopes)
            if reference and moved
            else slopes,
        )
        by_path = {}
        for path, change in changes.items():
            grown = mass * (1.0 + STEP * change.mass), inertia * (1.0 + STEP * change.inertia)
            larger = answered(change.throws[1], change.ends[1], *grown)
            by_path[path] = _shares(larger, plain) | {"mass": change.mass}
            if moved:
                # To the last digits those of the mesh, from either side.
                shrunk = 2.0 * mass - grown[0], 2.0 * inertia - grown[1]
                smaller = _shares(answered(change.throws[0], change.ends[0], *shrunk), plain)
                by_path[path] |= {
                    name: 0.5 * (by_path[path][name] - share) for name, share in smaller.items()
                }
        shares = {
            name: {path: by_name[name] for path, by_name in by_path.items() if name in by_name}
            for name in order
        }
        coarse = level.axial_correction, False, corrected.missing
        slope_bars = {
            name: float(slope_errors(value, plain[name], *coarse))
            for name, value in values.items()
            if value
        }
        for support in SUPPORTS:
            parts = [slope_bars[name] for name in _reaction_of(support)]
            slope_bars[f"axial_reaction_{support}"] = math.hypot(*parts)
        slope_bars["mass"] = VOLUME_ERROR
    uncorrected = {}
    if moved:
        uncorrected = {**plain, "mass": mass}
        for support in SUPPORTS:
            influence, axial = (plain[name] for name in _reaction_of(support))
            uncorrected[f"axial_reaction_{support}"] = influence / axial
    return ThrowResponses(
        {name: answers[name][0] for name in order},
        {name: abs(answers[name][1]) for name in order},
        level.mesh.unknowns,
        {name: of_paths for name, of_paths in shares.items() if of_paths},
        {name: slope_bars[name] for name, of_paths in shares.items() if of_paths},
        uncorrected,
        moved,
    )


def _solve_moved(
    throw: CrankThrow, reference: ReferenceMesh, problem: Problem
) -> tuple[MovedMesh | None, RefinementLevel | None]:
    """Solve a throw on the mesh of another; None twice if it is no good one for this throw."""
    try:
        moved = reference.at(throw)
    except MeshError:
        return None, None
    level = solve_level(moved.mesh, problem)
    return (None, None) if level.axial_part.discrete is None else (moved, level)


def _shares(larger: Mapping[str, float], plain: Mapping[str, float]) -> dict[str, float]:
    """Return d ln(response) / d ln(dimension) of all responses that are not zero, by their values."""
    shares = {name: (larger[name] / value - 1.0) / STEP for name, value in plain.items() if value}
    for support in SUPPORTS:
        influence, axial = (shares[name] for name in _reaction_of(support))
        shares[f"axial_reaction_{support}"] = influence - axial
    return {name: float(share) for name, share in shares.items()}


def _reaction_of(support: Support) -> tuple[str, str]:
    """Name the responses of which the axial reaction is the quotient."""
    return f"influence_coefficient_{support}", f"axial_compliance_{support}"


def _plain_answers(throw: Superelement, length: float, part: str) -> dict[str, float]:
    """Results that follow from a superelement, without another result's error."""
    answers: dict[str, float] = {}
    for support in SUPPORTS:
        answer = support_throw(throw, support)
        answers[f"axial_compliance_{support}"] = answer.axial
        answers[f"torsional_compliance_{support}"] = answer.torsional
        answers[f"influence_coefficient_{support}"] = answer.influence
    in_line, opposite, ratio = between_neighbors(throw)
    answers |= {
        "axial_compliance_opposite": opposite.axial,
        "axial_compliance_in_line": in_line.axial,
        **({"tilt_stiffness_ratio": ratio} if len(throw.pin_loads) == 1 else {}),
        "influence_coefficient_opposite": opposite.influence,
        "influence_coefficient_in_line": in_line.influence,
    }
    if part != "full":
        answers |= end_moment_numbers(throw, length, alike=part == "quarter")
    return answers
