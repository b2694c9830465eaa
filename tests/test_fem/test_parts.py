"""Quarter, half and full models of throws; unequal webs, several pins."""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from condensed_parts import torsional_compliance
from fem.analysis import analyze_throw
from fem.responses import evaluate_throw
from fem.superelement import UZ, shaft_compliances, solve_shaft
from fem.supports import (
    Neighbors,
    class_axial_compliances,
    support_throw,
)
from fem.symmetry import axial_class, radial_directions, symmetry_classes
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin, Web
from refusals import refused

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow

# Half a turn about y: the ends change places, x and z change sign.
TURN = np.kron([[0.0, 1.0], [1.0, 0.0]], np.diag([-1.0, 1.0, -1.0, -1.0, 1.0, -1.0]))


def same(found, expected, tolerance=1e-9):
    """Two superelements, each entry beside those of the unknowns that it couples."""
    size = np.sqrt(np.outer(np.diag(expected.stiffness), np.diag(expected.stiffness)))
    assert np.abs((found.stiffness - expected.stiffness) / size).max() <= tolerance
    # Entries of one kind (force or moment, by force or moment) are of one size.
    kind = np.repeat([0, 1], 3)
    for row in (0, 1):
        for column in (0, 1):
            rows, columns = np.tile(kind, 2) == row, kind == column
            one, other = (
                loads[:, rows][:, :, columns] for loads in (found.pin_loads, expected.pin_loads)
            )
            assert np.abs(one - other).max() <= tolerance * np.abs(other).max()
    kinds = np.tile([1.0, 1.0, 1.0, 10.0, 10.0, 10.0], len(found.pin_loads))
    differences = (found.pin_flexibility - expected.pin_flexibility) / np.outer(kinds, kinds)
    assert np.abs(differences).max() <= tolerance * np.abs(expected.pin_flexibility[1, 1])


def skewed(mesh, symmetric):
    """Bend a mesh so that its ends become unequal and, unless `symmetric`, its crank plane goes."""
    x, y, z = mesh.points.T
    share = z / mesh.length
    points = np.column_stack([x * (1.0 + 0.2 * share**2), y * (1.1 - 0.3 * share), z])
    if not symmetric:
        points[:, 0] += 0.2 * y * share
    return replace(mesh, points=points)


@pytest.fixture(scope="module")
def two_loads(half_mesh):
    """The half, its main journals as if they were a second pin: a load that is not in the middle."""
    facets = half_mesh.surfaces["main journal"]
    left = facets[half_mesh.points[facets, 2].max(axis=1) < 0.5 * half_mesh.length]
    return replace(
        half_mesh, pins=("pin", "journal"), surfaces={**half_mesh.surfaces, "journal": left}
    )


@pytest.fixture(scope="module")
def two_radials():
    return np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def models(mesh, half_mesh, full_mesh, condensed):
    meshes = {"quarter": mesh, "half": half_mesh, "full": full_mesh}
    return {part: condensed(found) for part, found in meshes.items()}


@pytest.fixture(scope="module")
def skewed_models(two_loads, two_radials, mirror, condensed):
    """Unequal ends and two loads: half and full models of the same, and one without any symmetry."""
    half = skewed(two_loads, symmetric=True)
    return {
        "half": condensed(half, radials=two_radials),
        "full": condensed(mirror(half), radials=two_radials),
        "free": condensed(skewed(mirror(two_loads), symmetric=False), radials=two_radials),
    }


@pytest.mark.parametrize("part", ["half", "full"])
def test_all_parts_give_the_same_superelement(models, part):
    same(models[part][1], models["quarter"][1])


def test_half_and_full_of_a_throw_with_unequal_ends_are_the_same(skewed_models):
    same(skewed_models["half"][1], skewed_models["full"][1])


def test_a_pin_turned_with_its_force_keeps_its_influence(skewed_models):
    superelement = skewed_models["free"][1]
    before, after = (
        support_throw(found, "guided")
        for found in (superelement, superelement.turned(angle_deg=np.degrees(0.7)))
    )
    assert after.influences == close(before.influences, rel=1e-8)


def test_a_shaft_has_a_column_for_each_pin(skewed_models, superelement):
    _, other = skewed_models["half"]
    shaft, angles = [superelement, other, superelement], [0.3, 1.4, 4.0]
    found = shaft_compliances(shaft, crank_angles_deg=np.degrees(angles)).influence
    assert found.shape == (3, 4)
    turned = [
        part.turned(angle_deg=np.degrees(angle)) for part, angle in zip(shaft, angles, strict=True)
    ]
    pulls = np.zeros((24, 3))
    for throw in range(3):
        pulls[6 * throw + UZ, throw], pulls[6 * throw + 6 + UZ, throw] = -1.0, 1.0
    motions = solve_shaft(turned, pulls)
    inward = np.vstack(
        [
            part.radial_loads.T @ motions[6 * place : 6 * place + 12]
            for place, part in enumerate(turned)
        ]
    )
    assert found == close(inward.T, abs=1e-9 * np.abs(found).max())


@pytest.fixture(scope="module")
def unequal(dimensions):
    return CrankThrow(**dimensions, right_web=Web(thickness=0.09, width=0.34))


@pytest.fixture(scope="module")
def opposite(dimensions):
    """Two pins at half a turn, the second longer."""
    return CrankThrow(**dimensions, further_pins=(FurtherPin(angle=math.pi, length=0.16),))


@pytest.fixture(scope="module")
def split(dimensions):
    pin = FurtherPin(angle=math.radians(30.0), web_thickness=0.0)
    return CrankThrow(**dimensions, further_pins=(pin,))


@pytest.fixture(scope="module")
def of_throw(condensed):
    """Superelement of a throw on a coarse mesh."""

    def compute(throw, size_factor=2.0, part="auto"):
        mesh = mesh_throw(throw, size_factor, part=part)
        return condensed(mesh, radials=radial_directions(throw))[1]

    return compute


def described_from_its_other_end(found, last_angle):
    """Turn a superelement by half a turn about y, then so that its last pin stands along +y."""
    cosine, sine = math.cos(last_angle), math.sin(last_angle)
    back = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    frame = np.kron(np.eye(2), np.diag([-1.0, 1.0, -1.0]) @ back)
    turned = replace(
        found, stiffness=TURN @ found.stiffness @ TURN.T, pin_loads=TURN @ found.pin_loads
    ).turned(angle_deg=np.degrees(last_angle))
    # The pins in reverse order, each in the turned frame.
    pins = np.kron(np.eye(len(found.radials))[::-1], frame)
    return replace(
        turned,
        pin_loads=(turned.pin_loads @ frame)[::-1],
        pin_flexibility=pins.T @ found.pin_flexibility @ pins,
        radials=(found.radials @ frame[:3, :3])[::-1],
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part", "last_angle", "size_factor"),
    [
        ("unequal", "half", 0.0, 1.6),
        pytest.param("opposite", "half", math.pi, 1.2, marks=pytest.mark.further),
        ("split", "full", math.pi / 6.0, 1.6),
    ],
)
def test_reversed_throw_is_turned(request, of_throw, name, part, last_angle, size_factor):
    """Meshes of both directions differ, and each is good for about 1 %."""
    throw = request.getfixturevalue(name)
    assert throw.symmetry == part
    found, original = of_throw(throw.reversed(), size_factor), of_throw(throw, size_factor)
    expected = described_from_its_other_end(original, last_angle)
    same(found, expected, 0.01)
    assert found.radials == close(expected.radials, abs=1e-12)
    for support in ("pinned", "guided"):
        one, other = support_throw(found, support), support_throw(expected, support)
        assert one.axial == close(other.axial, rel=0.01)
        assert one.torsional == close(other.torsional, rel=0.01)
        assert one.influences == close(other.influences, rel=0.02)
    # Its neighbors are seen in the other order.
    one = support_throw(found, Neighbors(120, 60))
    other = support_throw(original, Neighbors(60, 120))
    assert one.axial == close(other.axial, rel=0.01)


@pytest.mark.slow
def test_full_mesh_of_unequal_webs_is_as_its_half(of_throw, unequal):
    half, full = (of_throw(unequal, 1.4, part=part) for part in ("half", "full"))
    same(full, half, 0.01)


def test_equal_webs_described_as_unequal_are_ordinary(of_throw, dimensions, superelement):
    throw = CrankThrow(**dimensions, left_web=Web(thickness=dimensions["web_thickness"]))
    assert throw.symmetry == "quarter"
    same(of_throw(throw, 3.0), superelement)


@pytest.mark.slow
def test_two_opposite_pins_are_symmetric(of_throw, dimensions):
    """Half a turn about the axis through the middle web's center takes one pin to the other."""
    throw = CrankThrow(**dimensions, further_pins=(FurtherPin(angle=math.pi),))
    answers = support_throw(of_throw(throw, 1.5), "guided")
    assert answers.influences[0] == close(answers.influences[1], rel=0.02)


@pytest.mark.slow
def test_analysis_of_a_throw_with_two_pins(opposite):
    found = analyze_throw(opposite, accuracy=0.1)
    assert found.mesh.part == "half"
    assert len(found.classes) == 2
    assert found.accuracy_met
    for pin in (0, 1):
        forces = found.reactions(1e5 * radial_directions(opposite)[pin], pin=pin)
        thrust = found.influence_coefficient(pin=pin) * 1e5 / found.axial_compliance()
        assert forces.left.force[2] == close(thrust, rel=1e-6)
    with refused("pin"):
        found.influence_coefficient(pin=2)
    responses = evaluate_throw(opposite, accuracy=0.1)
    assert responses.values["axial_compliance_guided"] == close(
        found.axial_compliance("guided"), rel=1e-9
    )
    assert responses.values["influence_coefficient_pinned"] == close(
        found.influence_coefficient(), rel=1e-9
    )
    assert responses.values["mass"] == found.mass
    assert responses.unknowns == found.mesh.unknowns
    assert responses.slopes == {}


@pytest.mark.parametrize("support", ["pinned", "guided"])
@pytest.mark.parametrize("kind", ["models", "skewed_models"])
def test_few_classes_are_enough_for_these_supports(request, kind, support):
    for classes, superelement in request.getfixturevalue(kind).values():
        part = {4: "quarter", 2: "half", 1: "full"}[classes[0].symmetry.copies]
        by_class = {found.symmetry: found for found in classes}
        expected = support_throw(superelement, support)
        axial, influence = class_axial_compliances(by_class[axial_class(part)], support)
        torsional = torsional_compliance(by_class[symmetry_classes(part)[-1]], support)
        assert axial == close(expected.axial, rel=1e-9)
        assert influence == close(expected.influence, rel=1e-9)
        assert torsional == close(expected.torsional, rel=1e-9)


@pytest.mark.slow
def test_analysis_of_a_throw_without_symmetry(split):
    found = analyze_throw(split, accuracy=0.1)
    assert found.mesh.part == "full"
    responses = evaluate_throw(split, accuracy=0.1)
    for support in ("pinned", "guided"):
        wanted = found.supported(support)
        assert responses.values[f"axial_compliance_{support}"] == close(wanted.axial, rel=1e-9)
        assert responses.values[f"torsional_compliance_{support}"] == close(
            wanted.torsional, rel=1e-9
        )
        assert responses.values[f"influence_coefficient_{support}"] == close(
            wanted.influence, rel=1e-9
        )
