"""Compliances and reactions of throws, on the same mesh.

Source: CalculiX 2.20 (https://www.calculix.de), element C3D10, rigid end sections, each load on the same
coarse mesh of the whole throw; crankfem by its condensed 12 x 12 stiffness, not corrected for
discretization.

Tolerance: 1e-5: round-off and the 7 digits that CalculiX prints make 3e-7; a wrong edge node, support, load
share or sign makes percents.

Reactions are relative to the load, their moments to the load times the crank radius. CalculiX itself is
first tested on a square bar with nu = 0: L/(E A), L/(E I) and reactions from equilibrium, 1e-6.
"""

import math
import shutil
from dataclasses import dataclass

import numpy as np
import pytest

from calculix_run import read_calculix, run_calculix
from comparing import close
from fem.analysis import analyze_throw
from fem.calculix import axial_case, bending_case, pin_case, torque_case, write_calculix
from fem.material import STEEL, Material
from fem.symmetry import uniform_pin_loads
from geometry.mesh import SolidProperties, ThrowMesh
from geometry.mesher import mesh_isolated
from geometry.solid import LEFT_END, RIGHT_END
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight, FurtherPin, Web

pytestmark = [
    pytest.mark.further,
    pytest.mark.skipif(
        shutil.which("ccx") is None,
        reason="CalculiX is not installed: apt-get install calculix-ccx",
    ),
]

TOLERANCE = 1e-5
SIZE_FACTOR = 5.0
SUPPORTS = ("pinned", "guided")
# No component is zero, so that no part of the pins' loads goes unseen.
PIN_FORCE = np.array([0.7, -1.0, 0.4])
# What differs from the reference throw, which has sharp corners and 300 mm wide obround webs here.
FEATURES = {
    "sharp corners": {},
    "fillets": {"fillet_radius": 0.012},
    "bores off their axes": {
        "fillet_radius": 0.012,
        "main_journal_bore": 0.08,
        "main_journal_bore_offset": -0.01,
        "pin_bore": 0.09,
        "pin_bore_offset": 0.01,
    },
    "chamfered rectangles, unequal webs": {
        "fillet_radius": 0.012,
        "web_outline": "rectangle",
        "web_corner_chamfer": 0.04,
        "right_web": Web(thickness=0.09, width=0.33),
    },
    "counterweights off the bearing": {
        "fillet_radius": 0.012,
        "counterweight": Counterweight(
            outer_radius=0.25, inner_radius=0.13, angle=2.5, thickness=0.09, offset=-0.005
        ),
    },
    "webs thinned to tip and foot": {
        "fillet_radius": 0.012,
        "web_tip_thickness": 0.045,
        "web_foot_thickness": 0.045,
        "web_journal_end": 0.16,
        "web_pin_end": 0.13,
    },
    "two pins at 120 deg": {
        "fillet_radius": 0.012,
        "further_pins": (FurtherPin(angle=math.radians(120.0), length=0.10),),
    },
}


@dataclass(frozen=True)
class Compared:
    """A throw by our superelement, and CalculiX's steps by name."""

    analysis: object
    mesh: ThrowMesh
    steps: dict


def analyzed_on(mesh, throw):
    """The superelement of one given mesh, whatever mesh is asked for."""
    return analyze_throw(throw, accuracy=0.1, mesher=lambda *_, **__: mesh).discrete


def radial_forces(throw):
    """A unit force on each pin towards the shaft, one pin after the other: (pins, pins, 3)."""
    axes = np.array([(*axis, 0.0) for axis in throw.pin_axes])
    return -np.eye(len(axes))[:, :, None] * axes / np.linalg.norm(axes, axis=1)[:, None]


def calculix_steps(mesh, material, cases, folder):
    path = write_calculix(mesh, material, folder / "throw.inp", list(cases.values()))
    return dict(zip(cases, read_calculix(run_calculix(path, threads=1)), strict=True))


@pytest.fixture(scope="module", params=FEATURES)
def compared(request, dimensions, tmp_path_factory):
    throw = CrankThrow(**dimensions | {"fillet_radius": 0.0} | FEATURES[request.param])
    mesh = mesh_isolated(throw, SIZE_FACTOR, "full")
    cases = {"bending x": bending_case("x"), "bending y": bending_case("y")}
    for support in SUPPORTS:
        cases["axial", support] = axial_case(support)
        cases["torque", support] = torque_case(support)
        for pin, forces in enumerate(radial_forces(throw)):
            loaded = np.zeros((len(mesh.pins), 3))
            loaded[pin] = PIN_FORCE
            cases["influence", support, pin] = pin_case(forces, support, blocked=False)
            cases["reactions", support, pin] = pin_case(loaded, support, blocked=True)
    steps = calculix_steps(mesh, STEEL, cases, tmp_path_factory.mktemp("calculix"))
    return Compared(analyzed_on(mesh, throw), mesh, steps)


def test_the_superelement_is_that_of_the_mesh(compared):
    assert compared.analysis.mesh.points is compared.mesh.points


@pytest.mark.parametrize("support", SUPPORTS)
def test_axial_and_torsional_compliance(compared, support, figure):
    ours, steps = compared.analysis, compared.steps
    lengthening = steps["axial", support].motions[8]
    twist = steps["torque", support].motions[11]
    axial, torsional = ours.axial_compliance(support), ours.torsional_compliance(support)
    figure(f"axial compliance, {support}", axial, lengthening, TOLERANCE, "m/N")
    figure(f"torsional compliance, {support}", torsional, twist, TOLERANCE, "rad/(N m)")


@pytest.mark.parametrize("axis", ["x", "y"])
def test_bending_compliance(compared, axis, figure):
    tilts = [3, 9] if axis == "x" else [4, 10]
    load = np.zeros(12)
    load[tilts] = -1.0, 1.0
    free = np.setdiff1d(np.arange(12), bending_case(axis).held)
    motions = np.zeros(12)
    motions[free] = np.linalg.solve(compared.analysis.stiffness[np.ix_(free, free)], load[free])
    theirs = load @ compared.steps[f"bending {axis}"].motions
    figure(f"bending compliance about {axis}", load @ motions, theirs, TOLERANCE, "rad/(N m)")


@pytest.mark.parametrize("support", SUPPORTS)
def test_influence_coefficient(compared, support, figure):
    for pin in range(len(compared.mesh.pins)):
        lengthening = compared.steps["influence", support, pin].motions[8]
        ours = compared.analysis.influence_coefficient(support, pin)
        figure(f"influence coefficient, {support}", ours, lengthening, TOLERANCE, "m/N")


@pytest.mark.parametrize("support", SUPPORTS)
def test_reactions(compared, support, figure):
    load = np.linalg.norm(PIN_FORCE)
    moment = load * compared.analysis.throw.crank_radius
    for pin in range(len(compared.mesh.pins)):
        theirs = compared.steps["reactions", support, pin].forces.reshape(2, 2, 3)
        ours = compared.analysis.reactions(PIN_FORCE, support, pin)
        for end, (force, torque) in zip((ours.left, ours.right), theirs, strict=True):
            figure(f"reaction forces, {support}", end.force, force, TOLERANCE, "N", scale=load)
            figure(
                f"reaction moments, {support}", end.moment, torque, TOLERANCE, "N m", scale=moment
            )


@pytest.mark.parametrize("support", SUPPORTS)
def test_the_compression_is_c_z_over_e(compared, support, figure):
    """Our compression by a radial force Z beside c Z / e_n of two other steps of CalculiX."""
    for pin, axis in enumerate(compared.analysis.throw.pin_axes):
        radial = -np.array([*axis, 0.0]) / np.linalg.norm(axis)
        compression = compared.analysis.reactions(radial, support, pin).left.force[2]
        influence = compared.steps["influence", support, pin].motions[8]
        wanted = influence / compared.steps["axial", support].motions[8]
        figure(f"compression per radial force, {support}", compression, wanted, TOLERANCE, "N/N")


LENGTH, WIDTH, HEIGHT = 0.4, 0.06, 0.1


@pytest.fixture(scope="module")
def bar():
    """A bar of 4 x 2 x 2 bricks of six tetrahedra each; its pin lies at y = HEIGHT / 2."""
    counts = (2, 2, 4)
    grid = np.stack(np.meshgrid(*(np.arange(2 * n + 1) for n in counts), indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    elements = []
    for brick in np.ndindex(counts):
        for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
            corners = [2 * np.array(brick)]
            for axis in order:
                corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
            if np.linalg.det(np.diff(corners, axis=0)) < 0.0:
                corners[2:] = corners[3], corners[2]
            edges = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
            middles = [(corners[i] + corners[j]) // 2 for i, j in edges]
            elements.append([number[tuple(place)] for place in (*corners, *middles)])
    elements = np.array(elements)
    steps = np.array([WIDTH, HEIGHT, LENGTH]) / (2.0 * np.array(counts))
    points = grid.reshape(-1, 3) * steps - [WIDTH / 2.0, HEIGHT / 2.0, 0.0]
    used, renumbered = np.unique(elements, return_inverse=True)
    points, elements = points[used], renumbered.reshape(elements.shape)
    facets = elements[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]].reshape(-1, 3)
    on_top = np.isclose(points[:, 1], HEIGHT / 2.0) & (abs(points[:, 2] / LENGTH - 0.5) < 0.26)
    places = {
        "pin": on_top,
        LEFT_END: np.isclose(points[:, 2], 0.0),
        RIGHT_END: np.isclose(points[:, 2], LENGTH),
    }
    surfaces = {name: facets[np.all(on[facets], axis=1)] for name, on in places.items()}
    solid = SolidProperties(LENGTH * WIDTH * HEIGHT, np.zeros(3), np.zeros((3, 3)))
    return ThrowMesh("full", LENGTH, ("pin",), points, elements, surfaces, 1.0, 0, solid)


def test_calculix_on_a_bar(bar, tmp_path, figure):
    material = Material(youngs_modulus=2e11, poisson_ratio=0.0, density=7850.0)
    assert uniform_pin_loads(bar).sum() == close(1.0)
    cases = {
        "tension": axial_case(),
        "torque": torque_case(),
        "bending x": bending_case("x"),
        "bending y": bending_case("y"),
        "forces": pin_case([[3.0, -2.0, 0.0]], blocked=True),
    }
    found = calculix_steps(bar, material, cases, tmp_path)
    tension = LENGTH / (2e11 * WIDTH * HEIGHT)
    figure("CalculiX itself: a bar pulled", found["tension"].motions[8], tension, 1e-6, "m/N")
    for axis, second, (left, right) in (
        ("x", WIDTH * HEIGHT**3 / 12.0, (3, 9)),
        ("y", HEIGHT * WIDTH**3 / 12.0, (4, 10)),
    ):
        half = 0.5 * LENGTH / (2e11 * second)
        bent = found[f"bending {axis}"].motions[[left, right]]
        figure("CalculiX itself: a bar bent", bent, [-half, half], 1e-6, "rad/(N m)")
    # At rotation nodes forces are moments: the left end holds the torque.
    assert found["torque"].forces[[5, 11]] == close([-1.0, 1.0], rel=1e-6)
    # 3 N along x at HEIGHT / 2 above the axis turns the bar by -3 HEIGHT / 2 about z. Pinned ends take
    # no moments about x and y.
    expected = np.zeros(12)
    expected[[0, 1, 5, 6, 7]] = -1.5, 1.0, 1.5 * HEIGHT, -1.5, 1.0
    along = [2, 8]  # depends on the bar's elasticity
    others = np.setdiff1d(np.arange(12), along)
    forces = found["forces"].forces
    np.testing.assert_allclose(forces[others], expected[others], atol=2e-6)
    assert forces[along].sum() == close(0.0, abs=2e-6)
