"""What loads on a pin do, against direct solves of the whole throw."""

from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy import sparse

from comparing import close
from crankbase.errors import InputError
from fem import responses
from fem.analysis import analyze_throw
from fem.fillet_stress import fillet_stresses
from fem.material import STEEL
from fem.response_table import RESPONSES
from fem.responses import evaluate_throw
from fem.solver import Factorization, assemble_stiffness, factorize
from fem.superelement import nodes_on
from fem.supports import (
    Neighbors,
    all_end_motions,
    end_motions,
    equivalent_load,
    local_motion,
    pin_compliance,
    pin_response,
)
from fem.symmetry import pin_load, pin_surfaces, unit_pin_loads
from geometry.solid import LEFT_END, MAIN_JOURNAL, RIGHT_END
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin, Web
from parts_in_a_line import crank_throw
from refusals import refused

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow

SUPPORTS = ("pinned", "guided", Neighbors(120, 90))
SOLVED = 1e-7
FORCE, MOMENT = np.array([300.0, -800.0, 50.0]), np.array([20.0, -5.0, 9.0])
# Motions (rx ry uz rz of the left, then of the right end) that each support leaves free.
FREE = {"pinned": [3, 4, 9, 10, 8, 11], "guided": [8, 11]}


@pytest.fixture(scope="module")
def analyses(throw, mesh, half_mesh, full_mesh):
    """The same throw on the same mesh, analyzed by its quarter, half and whole."""
    found = {}
    for given_mesh in (mesh, half_mesh, full_mesh):
        found[given_mesh.part] = analyze_throw(
            throw, accuracy=0.1, mesher=lambda *_, answer=given_mesh: answer
        ).discrete
        assert found[given_mesh.part].mesh is given_mesh
    return found


@pytest.fixture(scope="module")
def analysis(analyses):
    return analyses["quarter"]


@pytest.fixture(scope="module", params=["quarter", "half", "full"])
def of_part(request, analyses):
    return analyses[request.param]


@dataclass(frozen=True)
class Direct:
    """The full mesh with rigid ends, supported as one of the named supports says.

    Attributes
    ----------
    mesh : ThrowMesh
    stiffness : (3 n, 3 n) sparse array
        Both triangles.
    factors : Factorization
        Of the stiffness against the free nodes' displacements and then the free motions of the ends.
    reduction : (3 n, u) sparse array
        Displacements for each of these unknowns.
    free : list
        Which of the 12 end motions the last unknowns are.
    """

    mesh: object
    stiffness: sparse.csr_array
    factors: Factorization
    reduction: sparse.csc_array
    free: list

    def solve(self, nodal, pull=0.0):
        """Displacements (n, 3) and end motions (12,) under nodal loads (n, 3) and an axial force."""
        loads = self.reduction.T @ nodal.ravel()
        loads[loads.size - len(self.free) + self.free.index(8)] += pull
        solved = self.factors.solve(loads[:, None])[:, 0]
        motions = np.zeros(12)
        motions[self.free] = solved[-len(self.free) :]
        return (self.reduction @ solved).reshape(-1, 3), motions


@contextmanager
def direct(mesh, support):
    """Impose a support on a full mesh; the factorization is kept within the block."""
    size = 3 * len(mesh.points)
    upper = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    stiffness = sparse.csr_array(upper + sparse.triu(upper, k=1).T)
    ends = np.zeros((len(mesh.points), 3, 12))
    inner = np.ones((len(mesh.points), 3), dtype=bool)
    for place, section in ((0, LEFT_END), (6, RIGHT_END)):
        nodes = nodes_on(mesh, section)
        inner[nodes] = False
        arms = mesh.points[nodes] * (1.0, 1.0, 0.0)
        for axis in range(3):
            ends[nodes, axis, place + axis] = 1.0
            ends[nodes, :, place + 3 + axis] = np.cross(np.eye(3)[axis], arms)
    single = sparse.csc_array(sparse.identity(size, format="csc"))[:, np.flatnonzero(inner)]
    moving = sparse.csc_array(ends.reshape(size, 12)[:, FREE[support]])
    reduction = sparse.hstack([single, moving], format="csc")
    matrix = sparse.csr_array(sparse.triu(reduction.T @ stiffness @ reduction, format="csr"))
    with factorize(matrix) as factors:
        yield Direct(mesh, stiffness, factors, reduction, FREE[support])


@pytest.fixture(scope="module")
def supported(full_mesh):
    with direct(full_mesh, "pinned") as pinned, direct(full_mesh, "guided") as guided:
        yield {"pinned": pinned, "guided": guided}


def nodal_load(mesh, force, moment, distribution, pin=0):
    """Nodal loads (n, 3) on a mesh of the whole throw."""
    loads = pin_load(pin_surfaces(mesh)[pin], force, moment, distribution)
    found = np.zeros((len(mesh.points), 3))
    found[loads.nodes] = loads.values[0, ..., 0]
    return found


def pin_motion(mesh, field, pin=0):
    """Mean motion (6,) of a pin of a mesh of the whole throw."""
    loads = unit_pin_loads(mesh)[pin]
    return np.einsum("sac,sa->c", loads.values[0], field[loads.nodes])


def relative(found, expected):
    """Largest difference of translations and of rotations, each against its own largest."""
    found, expected = (np.asarray(one).reshape(-1, 2, 3) for one in (found, expected))
    size = np.abs(expected).max(axis=(0, 2))
    return (np.abs(found - expected).max(axis=(0, 2)) / size).max()


def both(motion):
    return np.concatenate([motion.displacement, motion.rotation])


@pytest.mark.parametrize("support", ["pinned", "guided"])
@pytest.mark.parametrize("distribution", ["uniform", "cosine"])
def test_a_direct_solve_gives_the_same_motions(of_part, supported, support, distribution):
    full = supported[support].mesh
    field, motions = supported[support].solve(nodal_load(full, FORCE, MOMENT, distribution))
    found = of_part.pin_response(FORCE, MOMENT, support, distribution=distribution)
    ends = np.concatenate([both(found.left), both(found.right)])
    assert relative(ends, motions) <= SOLVED
    assert relative(both(found.pin), pin_motion(full, field)) <= SOLVED
    assert found.lengthening == close(motions[8] - motions[2], rel=SOLVED)
    assert ends[[0, 1, 2, 5, 6, 7]] == close(0.0, abs=1e-20)


@pytest.mark.parametrize("support", SUPPORTS, ids=str)
def test_parts_have_one_pin_compliance(analyses, support):
    expected = analyses["full"].pin_compliance(support)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    for part in ("quarter", "half"):
        assert np.abs((analyses[part].pin_compliance(support) - expected) / size).max() <= SOLVED


@pytest.mark.parametrize("distribution", ["uniform", "cosine"])
def test_reactions_by_a_direct_solve(analyses, supported, distribution):
    """The pull that keeps the length of the free throw, and what the support does then."""
    held = supported["pinned"]
    load = nodal_load(held.mesh, FORCE, MOMENT, distribution)
    _, under_load = held.solve(load)
    _, under_pull = held.solve(np.zeros_like(load), pull=1.0)
    thrust = -under_load[8] / under_pull[8]
    field, motions = held.solve(load, pull=thrust)
    assert abs(motions[8]) <= SOLVED * abs(under_load[8])
    nodal = (held.stiffness @ field.ravel()).reshape(-1, 3) - load
    expected = []
    for section in (LEFT_END, RIGHT_END):
        nodes = nodes_on(held.mesh, section)
        arms = held.mesh.points[nodes] * (1.0, 1.0, 0.0)
        expected += [nodal[nodes].sum(axis=0), np.cross(arms, nodal[nodes]).sum(axis=0)]
    for part in analyses.values():
        found = part.reactions(FORCE, "pinned", pin_moment=MOMENT, distribution=distribution)
        reactions = [found.left.force, found.left.moment, found.right.force, found.right.moment]
        assert np.array(reactions) == close(np.array(expected), abs=1e-5)


def test_a_couple_of_forces_is_a_moment(analysis):
    """Torque of the pin's center about the shaft: a force across at the crank radius."""
    found = analysis.reactions((100.0, 0.0, 0.0))
    radius = pin_surfaces(analysis.mesh)[0].center[1]
    assert found.left.moment[2] == close(100.0 * radius, rel=SOLVED)
    turned = analysis.reactions(pin_moment=(0.0, 0.0, 100.0))
    assert turned.left.moment[2] == close(-100.0, rel=SOLVED)


def test_loads_on_one_of_two_pins(supported, full_mesh, half_mesh, condensed):
    """The main journals' surface plays a second pin, about whose center it is loaded.

    Its motions under loads on the first pin, and the other way round, are in `local_motion` by the
    place of each pin.
    """
    names = ("pin", MAIN_JOURNAL)
    radials = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    whole = replace(supported["pinned"], mesh=replace(full_mesh, pins=names))
    half = replace(half_mesh, pins=names)
    classes, throw = condensed(half, radials=radials)
    assert throw.pin_loads.shape == (2, 12, 6)
    assert throw.pin_flexibility == close(throw.pin_flexibility.T, rel=1e-12)
    for pin in (0, 1):
        load = pin_load(pin_surfaces(half)[pin], FORCE, MOMENT, "cosine")
        local = local_motion(classes, load, 2)
        field, motions = whole.solve(nodal_load(whole.mesh, FORCE, MOMENT, "cosine", pin))
        ends = equivalent_load(classes, load)
        found = pin_response(throw, "pinned", ends, local[6 * pin : 6 * pin + 6], pin)
        assert relative(both(found.pin), pin_motion(whole.mesh, field, pin)) <= SOLVED
        assert relative(np.concatenate([both(found.left), both(found.right)]), motions) <= SOLVED
        other = 1 - pin
        moved = end_motions(throw, "pinned", ends[:, None])[:, 2]
        of_other = local[6 * other : 6 * other + 6] + throw.pin_loads[other].T @ moved
        assert relative(of_other, pin_motion(whole.mesh, field, other)) <= SOLVED
        compliance = pin_compliance(throw, "pinned", pin)
        field, _ = whole.solve(nodal_load(whole.mesh, np.zeros(3), MOMENT, "uniform", pin))
        assert relative(compliance[:, 3:] @ MOMENT, pin_motion(whole.mesh, field, pin)) <= SOLVED


@pytest.mark.parametrize(
    "wrong", [(1.0, 2.0), 5.0, (0.0, np.nan, 0.0), (0.0, np.inf, 0.0), np.zeros((3, 1)), "1 kN"]
)
def test_vectors_that_are_none(analysis, wrong):
    """The message has the name of the argument that was given."""
    for distribution in ("uniform", "cosine"):
        with pytest.raises(InputError, match=r"(?s)^pin_moment: given .*three finite numbers"):
            analysis.reactions((0.0, 1.0, 0.0), pin_moment=wrong, distribution=distribution)
        with pytest.raises(InputError, match=r"(?s)^pin_force: given .*three finite numbers"):
            analysis.reactions(wrong, distribution=distribution)
        with pytest.raises(InputError, match=r"(?s)^force: given .*three finite numbers"):
            analysis.pin_response(wrong, distribution=distribution)
        with pytest.raises(InputError, match=r"(?s)^moment: given .*three finite numbers"):
            analysis.pin_response(moment=wrong, distribution=distribution)


def test_what_else_is_refused(analysis):
    force = (0.0, -1.0, 0.0)
    for call in (
        lambda **more: analysis.reactions(force, **more),
        lambda **more: analysis.pin_response(force, **more),
        analysis.influence_coefficient,
    ):
        with refused("distribution"):
            call(distribution="even")
        for distribution in ("uniform", "cosine"):
            with refused("pin"):
                call(pin=1, distribution=distribution)
            with refused("support"):
                call(support="fixed", distribution=distribution)
    with refused("pin"):
        analysis.pin_compliance(pin=True)
    with refused("support"):
        analysis.pin_compliance("fixed")


# Finite elements throughout: not for the inner loop.

PLAIN = crank_throw(0.170, 0.220, 0.180, 0.120, 0.139, 0.285, 0.068, fillet_radius=0.012)
UNEQUAL = PLAIN.model_copy(update={"right_web": Web(thickness=0.080)})


def changed(throw, **values):
    return CrankThrow(**throw.model_dump() | values)


@cache
def evaluated(throw, accuracy):
    return evaluate_throw(throw, accuracy=accuracy)


@pytest.fixture(scope="module")
def coarse():
    return evaluated(PLAIN, 0.03)


def end_moments(analysis, throw):
    """End moments by the analysis's reactions, where the length is kept, and its angle law."""
    length = throw.length

    def held(support):
        radial, tangential = (
            analysis.reactions(force, support) for force in ((0, -1, 0), (-1, 0, 0))
        )
        ends = [tangential.left.moment[1] / length, tangential.right.moment[1] / length]
        return radial, (ends[0] - ends[1]) / 2.0, (ends[0] + ends[1]) / 2.0

    def axial(support):
        """End moments of an axial force: what the superelement is held with while it is pulled."""
        motions = all_end_motions(analysis.superelement, support)[:, 0]
        whole = analysis.superelement if support == "guided" else analysis.superelement.joined
        ends = whole.stiffness @ motions / length
        return -ends[3], ends[9]

    radial, opposed, alike = held("guided")
    left, right = axial("guided")
    push = radial.left.force[2]
    found = {
        "radial_end_moment_left_guided": left * push - radial.left.moment[0] / length,
        "radial_end_moment_right_guided": right * push + radial.right.moment[0] / length,
        "axial_end_moment_left_guided": left,
        "axial_end_moment_right_guided": right,
        "tangential_end_moment_opposed_guided": opposed,
        "tangential_end_moment_alike_guided": alike,
    }
    if throw is not PLAIN:
        return found
    radial, opposed, _ = held(Neighbors(0.0, 0.0))
    left, _ = axial(Neighbors(0.0, 0.0))
    turned = held(Neighbors(90.0, 90.0))[1]
    return found | {
        "radial_end_moment_in_line": left * radial.left.force[2] - radial.left.moment[0] / length,
        "axial_end_moment_in_line": left,
        "tangential_end_moment_in_line": opposed,
        "tangential_end_moment_opposite": held(Neighbors(180.0, 180.0))[2],
        "cross_tilt_stiffness_ratio": turned / (opposed - turned),
    }


@pytest.mark.parametrize("throw", [PLAIN, UNEQUAL], ids=["equal webs", "unequal webs"])
def test_responses_are_those_of_the_whole_analysis(throw):
    found = evaluate_throw(throw, accuracy=0.05)
    analysis = analyze_throw(throw, accuracy=0.05)
    wanted = {"mass": analysis.mass}
    for support in ("pinned", "guided"):
        answer = analysis.supported(support)
        wanted[f"axial_compliance_{support}"] = answer.axial
        wanted[f"torsional_compliance_{support}"] = answer.torsional
        wanted[f"influence_coefficient_{support}"] = answer.influence
        reaction = analysis.reactions((0.0, -1.0, 0.0), support).left.force[2]
        wanted[f"axial_reaction_{support}"] = reaction
    for name, angle in (("in_line", 0.0), ("opposite", 180.0)):
        answer = analysis.supported(Neighbors(angle, angle))
        wanted[f"axial_compliance_{name}"] = answer.axial
        wanted[f"influence_coefficient_{name}"] = answer.influence
    low, high = wanted["axial_compliance_in_line"], wanted["axial_compliance_opposite"]
    middle = analysis.axial_compliance(Neighbors(90.0, 90.0))
    wanted["tilt_stiffness_ratio"] = (high - middle) / (middle - low)
    wanted |= end_moments(analysis, throw)
    alike = throw is PLAIN
    assert set(found.values) == set(wanted)
    assert alike == (set(wanted) == set(RESPONSES) - {"fillet_stress_factor"})
    # The same mesh and the same matrices, added up in another order; the ratio is one of differences.
    for name, value in wanted.items():
        assert found.values[name] == close(value, rel=1e-8), name
    assert found.errors["axial_compliance_pinned"] == close(analysis.error_estimate)
    assert found.unknowns == analysis.mesh.unknowns


def test_throws_of_two_pins_have_no_law_of_the_angle():
    """With pins 30 deg apart e(60) is not e(-60), with a right angle e(90) is below e(0) and e(180)."""
    pins = FurtherPin(angle=np.deg2rad(30.0), web_thickness=0.05)
    analysis = analyze_throw(PLAIN.changed(further_pins=[pins]), accuracy=0.1)
    ahead, behind = (analysis.axial_compliance(Neighbors(angle, angle)) for angle in (60.0, -60.0))
    assert behind > 1.2 * ahead
    crossed = PLAIN.changed(further_pins=[pins.changed(angle=np.pi / 2)])
    found = evaluate_throw(crossed, accuracy=0.1, slopes=["web_width"])
    analysis = analyze_throw(crossed, accuracy=0.1)
    low, middle, high = (
        analysis.axial_compliance(Neighbors(angle, angle)) for angle in (0.0, 90.0, 180.0)
    )
    assert middle < min(low, high)
    assert found.values["axial_compliance_in_line"] == close(low, rel=1e-8)
    assert found.values["axial_compliance_opposite"] == close(high, rel=1e-8)
    for by_name in (found.values, found.errors, found.slopes):
        assert "tilt_stiffness_ratio" not in by_name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("throw", "accuracy", "reference"),
    [
        (PLAIN, 0.03, 0.003),
        (changed(PLAIN, web_thickness=0.045, pin_bore=0.06, main_journal_bore=0.08), 0.05, 0.005),
    ],
    ids=["plain", "bored and thin"],
)
def test_true_errors_are_those_estimated(throw, accuracy, reference):
    coarse, fine = evaluated(throw, accuracy), evaluated(throw, reference)
    for name, value in fine.values.items():
        if name == "mass":
            continue
        assert abs(value / coarse.values[name] - 1.0) < coarse.errors[name], name


@pytest.mark.slow
def test_errors_fall_with_the_accuracy(coarse):
    for name, error in evaluate_throw(PLAIN, accuracy=0.004).errors.items():
        if name != "mass":
            assert 0.0 < error < coarse.errors[name], name
    assert coarse.errors["mass"] < 1e-4


def test_every_response_says_what_it_is(coarse):
    for name, kind in RESPONSES.items():
        assert kind.unit in ("m/N", "rad/(N m)", "kg", ""), name
        assert kind.symbol
        assert kind.meaning
    assert len({kind.symbol for kind in RESPONSES.values()}) == len(RESPONSES)
    assert all(np.isfinite(list(coarse.values.values())))


@pytest.mark.slow
def test_the_largest_stress_factor(monkeypatch):
    """Of the stresses that are computed on the way; large fillets are soon solved."""
    throw = changed(PLAIN, fillet_radius=0.018)
    asked, made = [], []

    def noted(*arguments, mesher):
        asked.append(arguments)
        made.append(fillet_stresses(*arguments, mesher=mesher))
        return made[-1]

    monkeypatch.setattr(responses, "fillet_stresses", noted)
    found = evaluate_throw(throw, accuracy=0.1, stresses=True)
    assert asked == [(throw, STEEL, 0.05)]
    wanted = max(p.factor for p in made[0].peaks if p.load.kind in ("bending", "torsion"))
    assert found.values["fillet_stress_factor"] == wanted
    assert 0.0 < found.errors["fillet_stress_factor"] <= 0.05


def test_stresses_of_sharp_corners_are_refused():
    with refused("fillet_radius"):
        evaluate_throw(changed(PLAIN, fillet_radius=0.0), accuracy=0.1, stresses=True)
