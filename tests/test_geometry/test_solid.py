"""Solids of throws and crankshafts: outlines, masses and what a process keeps."""

import math

import gmsh
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geometry.mesh
from comparing import close, same_mesh
from crankbase.errors import InputError, MeshError
from geometry import crankshaft
from geometry.crankshaft import Crankshaft, ShaftEnds, make_shaft, throw_masses, throw_solid
from geometry.gmsh_session import IsolatedProcess, gmsh_session
from geometry.mass import cylinder_mass_properties, mass_properties, unbalance
from geometry.mesh import SolidKeeper, mesh_throw, solid_properties
from geometry.mesher import mesh_isolated
from geometry.parts import Arc, obround, rectangle, scaled_parts
from geometry.sizes import element_sizes, sizes_at_corners
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight, FurtherPin, OilHole, Web
from refusals import refused


@pytest.fixture
def keeper(monkeypatch):
    made = SolidKeeper()
    made.keeps = True
    monkeypatch.setattr(geometry.mesh, "_KEEPER", made)
    yield made
    made.close()
    assert not gmsh.isInitialized()


@pytest.fixture
def bored(dimensions):
    weight = Counterweight(outer_radius=0.25, angle=2.0)
    return CrankThrow(**dimensions, pin_bore=0.06, counterweight=weight)


@pytest.mark.parametrize("part", ["quarter", pytest.param("full", marks=pytest.mark.slow)])
def test_meshes_of_a_kept_solid_are_bit_identical(bored, keeper, part):
    """Whatever was meshed before, by a plan or a map."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(geometry.mesh, "_KEEPER", SolidKeeper())
        coarse = mesh_throw(bored, 3.0, part)
        corners = coarse.elements[:, :4]
        sizes = sizes_at_corners(coarse.points, corners, element_sizes(coarse.points, corners))
        mapped = mesh_throw(bored, 0.9, part, sizes)
    kept = []
    for expected, made_with in (coarse, None), (mapped, sizes), (coarse, None), (mapped, sizes):
        found = mesh_throw(bored, 3.0 if made_with is None else 0.9, part, made_with)
        assert same_mesh(found, expected)
        kept.append(found.geometry_seconds)
    assert kept[0] > 0.0
    assert kept[1:] == [0.0, 0.0, 0.0]


@pytest.mark.slow
def test_one_solid_is_kept_at_most_and_without_its_mesh(dimensions, bored, keeper):
    """Exits of oil holes are rounded in a model of their own, which does not stay either."""
    drilled = bored.changed(oil_holes=(OilHole(part="pin", diameter=0.03, exit_radius=0.005),))
    expected = None
    for throw in (CrankThrow(**dimensions), drilled, bored, drilled, CrankThrow(**dimensions)):
        mesh = mesh_throw(throw, 3.0)
        assert mesh.geometry_seconds > 0.0
        if throw is drilled:
            expected = expected or mesh
            assert same_mesh(mesh, expected)
            again = mesh_throw(throw, 3.0)
            assert same_mesh(again, expected)
            assert again.geometry_seconds == 0.0
        assert gmsh.model.list() == ["", "throw"]  # gmsh always has the first
        assert len(gmsh.model.getEntities(3)) == 1
        assert len(gmsh.model.mesh.getNodes()[0]) == 0
        assert len(gmsh.model.mesh.field.list()) == len(gmsh.view.getTags()) == 0


def test_masses_are_those_of_the_kept_solid(bored, keeper):
    built = []
    make, keeper._build = keeper._build, lambda *key: built.append(key) or make(*key)
    solid = mesh_throw(bored, 3.0).solid
    assert throw_solid(bored).volume == solid.volume
    assert throw_solid(bored).center == close(solid.center, abs=1e-15)
    assert len(built) == 1


@pytest.mark.slow
def test_a_solid_that_could_not_be_meshed_is_not_kept(dimensions, coarse_mesh, keeper, monkeypatch):
    def refuse(*_):
        raise MeshError("refused")

    throw = CrankThrow(**dimensions)
    mesh_throw(throw, 2.0)
    with monkeypatch.context() as patch:
        patch.setattr(geometry.mesh, "check_volume", refuse)
        with pytest.raises(MeshError, match="refused"):
            mesh_throw(throw, 2.0)
    assert not gmsh.isInitialized()
    assert same_mesh(mesh_throw(throw, 2.0), coarse_mesh)


@pytest.mark.slow
def test_a_process_of_ours_keeps_the_solid_and_a_fresh_one_builds_it_again(dimensions, coarse_mesh):
    throw, process = CrankThrow(**dimensions), IsolatedProcess()
    try:
        meshes = [mesh_isolated(throw, 2.0, process=process) for _ in range(2)]
        process.start().kill()
        process.start().end()
        meshes.append(mesh_isolated(throw, 2.0, process=process))
    finally:
        process.close()
    assert all(same_mesh(mesh, coarse_mesh) for mesh in meshes)
    assert [mesh.geometry_seconds > 0.0 for mesh in meshes] == [True, False, True]
    assert not gmsh.isInitialized()


@pytest.mark.slow
def test_throws_with_oil_holes_get_the_same_mesh_down_to_model_engines(dimensions):
    """Of a journal of 2.2 mm with a hole of 0.1 mm, rounded and tilted."""
    meshes = []
    for scale in (1.0, 0.01):
        hole = OilHole(part="pin", diameter=0.01 * scale, exit_radius=0.003 * scale, tilt=0.3)
        sizes = {name: scale * value for name, value in dimensions.items()}
        meshes.append(mesh_throw(CrankThrow(**sizes, oil_holes=(hole,)), 3.0))
    assert np.array_equal(meshes[0].elements, meshes[1].elements)
    assert meshes[1].points == close(0.01 * meshes[0].points, abs=1e-15)


def test_scaled_parts_are_those_of_the_scaled_throw(bored):
    weight = Counterweight(outer_radius=2.0 * 0.25, angle=2.0)
    values = {name: value for name, value in bored if isinstance(value, float)}
    larger = CrankThrow(**{n: 2.0 * v for n, v in values.items()}, counterweight=weight)
    assert scaled_parts(bored.parts, 2.0) == scaled_parts(larger.parts, 1.0)


def area(outline):
    """Area of the whole outline, by the trapezoidal rule on its polygon."""
    points = outline.polygon(2001)
    u, v = points[:, 0], points[:, 1]
    return float(np.sum((u[1:] + u[:-1]) * np.diff(v)))


def test_the_ordinary_web_is_two_half_discs_and_a_rectangle():
    outline = obround(0.3, 0.15, 0.15, 0.17)
    assert area(outline) == close(np.pi * 0.15**2 + 0.3 * 0.17, rel=1e-6)
    assert (outline.foot, outline.tip) == (-0.15, close(0.32))
    assert outline.distance(0.0) == close(0.15)
    assert outline.distance(0.17) == close(0.15)


def test_unequal_ends_are_joined_by_their_common_tangent():
    """Hull of two discs: both, their tangent quadrilaterals, less nothing."""
    outline = obround(0.4, 0.2, 0.1, 0.25)
    angle = math.asin((0.2 - 0.1) / 0.25)
    expected = (
        0.2**2 * (np.pi / 2.0 + angle)
        + 0.1**2 * (np.pi / 2.0 - angle)
        + (0.2 + 0.1) * 0.25 * math.cos(angle)
    )
    assert area(outline) == close(expected, rel=1e-6)
    # The tangent leaves both circles at right angles to their radii.
    first, line, second = outline.pieces
    for arc, touch in ((first, line.start), (second, line.end)):
        radius = np.subtract(touch, arc.center)
        assert radius @ np.subtract(line.end, line.start) == close(0.0, abs=1e-15)


def test_ends_wider_than_the_web_are_cut_by_straight_sides():
    outline = obround(0.3, 0.2, 0.2, 0.17)
    assert outline.half_width(np.linspace(outline.foot, outline.tip, 4001)).max() == close(0.15)
    assert outline.half_width(np.array([0.0, 0.17])) == close([0.15, 0.15])
    assert (outline.foot, outline.tip) == (-0.2, close(0.37))
    # Two circular segments of radius 0.2 beyond the chords of length 0.3, and what is between.
    half = math.asin(0.15 / 0.2)
    rise = 0.2 * math.cos(half)
    segment = 0.2**2 * (half - math.sin(half) * math.cos(half))
    assert area(outline) == close(2.0 * segment + 0.3 * (0.17 + 2.0 * rise), rel=1e-6)


@given(
    st.floats(0.05, 0.3), st.floats(0.05, 0.3), st.floats(0.02, 0.5), st.floats(0.6, 1.0)
)  # fmt: skip
def test_any_obround_is_convex_and_closed(foot, tip, distance, share):
    width = 2.0 * max(foot, tip) * share
    if abs(foot - tip) >= 0.95 * distance:
        return
    outline = obround(width, foot, tip, distance)
    points = outline.polygon(30)
    assert points[0] == close([0.0, -foot], abs=1e-15)
    assert points[-1] == close([0.0, distance + tip], abs=1e-15)
    steps = np.diff(points, axis=0)
    turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    assert turns.min() > -1e-12
    for first, second in zip(outline.pieces, outline.pieces[1:], strict=False):
        assert first.end == close(second.start, abs=1e-15)
    for piece in outline.pieces:
        if isinstance(piece, Arc):
            assert math.dist(piece.center, piece.end) == close(piece.radius)
    heights = np.linspace(outline.foot, outline.tip, 50)
    assert outline.half_width(heights).max() <= 0.5 * width * (1.0 + 1e-12)
    assert outline.width == close(width)


def test_a_rectangle_rounded_to_the_full_is_an_obround():
    rounded = rectangle(0.3, 0.15, 0.15, 0.17, 0.15, 0.0)
    v = np.linspace(-0.15, 0.32, 101)
    assert rounded.half_width(v) == close(obround(0.3, 0.15, 0.15, 0.17).half_width(v), abs=1e-12)


@pytest.mark.parametrize(
    "make",
    [
        lambda: obround(0.3, 0.1, 0.12, 0.17),
        lambda: obround(0.3, 0.3, 0.1, 0.17),
        lambda: rectangle(0.3, 0.15, 0.15, 0.17, 0.2, 0.0),
        lambda: rectangle(0.3, 0.15, 0.15, 0.17, 0.02, 0.02),
    ],
)
def test_impossible_outlines(make):
    with pytest.raises(InputError, match="; allowed is "):
        make()


DENSITY = 7850.0


def cylinder(diameter, length, center):
    mass = DENSITY * np.pi / 4.0 * diameter**2 * length
    across = mass * (diameter**2 / 16.0 + length**2 / 12.0)
    return mass, center, np.diag([across, across, mass * diameter**2 / 8.0])


def mass_obround(width, distance, thickness, z):
    """A plate: a rectangle between two half discs at y = 0 and y = distance."""
    radius = width / 2.0
    per_area = DENSITY * thickness
    rectangle, half_disc = width * distance, np.pi * radius**2 / 2.0
    mass = per_area * (rectangle + 2.0 * half_disc)
    # Second moments about the plate's middle; a half disc's centroid lies 4 r / (3 pi) from its chord.
    offset = 4.0 * radius / (3.0 * np.pi)
    xx = distance * width**3 / 12.0 + 2.0 * np.pi * radius**4 / 8.0
    yy = width * distance**3 / 12.0 + 2.0 * (
        np.pi * radius**4 / 8.0 - half_disc * offset**2 + half_disc * (distance / 2.0 + offset) ** 2
    )
    through = mass * thickness**2 / 12.0
    tensor = np.diag([per_area * yy + through, per_area * xx + through, per_area * (xx + yy)])
    return mass, np.array([0.0, distance / 2.0, z]), tensor


def composed(throw):
    """Mass, center and inertia of a throw without fillets, from its seven simple parts."""
    quarter = throw.main_journal_length / 4.0
    web_z = throw.main_journal_length / 2.0 + throw.web_thickness / 2.0
    parts = []
    for z in (quarter, throw.length - quarter):
        center = np.array([0.0, 0.0, z])
        parts.append(cylinder(throw.main_journal_diameter, 2.0 * quarter, center))
    for z in (web_z, throw.length - web_z):
        parts.append(mass_obround(throw.web_width, throw.crank_radius, throw.web_thickness, z))
    pin_center = np.array([0.0, throw.crank_radius, throw.length / 2.0])
    parts.append(cylinder(throw.pin_diameter, throw.pin_length, pin_center))
    mass = sum(part[0] for part in parts)
    center = sum(part[0] * part[1] for part in parts) / mass
    inertia = np.zeros((3, 3))
    for part_mass, part_center, part_inertia in parts:
        arm = part_center - center
        inertia += part_inertia + part_mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, center, inertia


@pytest.mark.slow
@pytest.mark.parametrize(
    "change", [{}, {"crank_radius": 0.3, "pin_diameter": 0.2}, {"web_thickness": 0.038}]
)
def test_mass_properties_against_the_composed_solid(dimensions, change):
    throw = CrankThrow(**{**dimensions, "fillet_radius": 0.0, **change})
    found = mass_properties(mesh_throw(throw, 1.0), DENSITY)
    mass, center, inertia = composed(throw)
    assert found.mass == close(mass, rel=1e-10)
    assert found.mass == close(DENSITY * throw.volume, rel=1e-10)
    assert found.center == close(center, rel=1e-10, abs=1e-12)
    assert np.diag(found.inertia) == close(np.diag(inertia), rel=1e-9)
    assert found.inertia - np.diag(np.diag(found.inertia)) == close(np.zeros((3, 3)))
    about_shaft = inertia[2, 2] + mass * center[1] ** 2
    assert found.inertia_about_shaft == close(about_shaft, rel=1e-9)


@pytest.mark.parametrize(
    "density", [math.nan, math.inf, -7850.0, 0.0, 1e308, "7850", True, None, [7850.0]]
)
def test_densities_of_no_body_are_refused(dimensions, density, monkeypatch):
    """Before anything is built, which takes a second."""
    monkeypatch.setattr(crankshaft, "shared_process", None)
    throw = CrankThrow(**dimensions)
    shaft = Crankshaft((throw,), crank_angles_deg=(0.0,))
    for call in (
        lambda: throw_masses(throw, density),
        lambda: shaft.masses(density),
        lambda: shaft.unbalance(density),
        lambda: cylinder_mass_properties(0.1, 0.0, 0.1, density),
    ):
        with refused("density"):
            call()


@pytest.mark.parametrize("density", [7850, 1.0, np.float64(7850.0), np.int64(7850)])
def test_densities_of_any_number_type_are_taken(density):
    assert cylinder_mass_properties(0.1, 0.0, 0.1, density).mass > 0.0


ENDS = ShaftEnds(
    free_end_diameter=0.2, free_end_length=0.3, flange_diameter=0.4, flange_thickness=0.05
)
SIX = np.deg2rad([0.0, 120.0, 240.0, 240.0, 120.0, 0.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"counterweight": Counterweight(outer_radius=0.25, angle=2.0), "pin_bore": 0.06},
        {"right_web": Web(thickness=0.08)},
        {"further_pins": (FurtherPin(angle=0.5, web_thickness=0.0),)},
    ],
)
def test_the_whole_solid_weighs_what_its_throws_weigh(dimensions, changes):
    shaft = Crankshaft(
        [CrankThrow(**dimensions, **changes)] * 6, crank_angles_deg=np.degrees(SIX), ends=ENDS
    )
    expected = shaft.masses(DENSITY)
    with gmsh_session("shaft") as gmsh:
        make_shaft(gmsh, shaft)
        solid = solid_properties(gmsh)
    assert DENSITY * solid.volume == close(expected.mass, rel=1e-6)
    assert solid.center == close(expected.center, abs=1e-6)
    moments = DENSITY * solid.second_moments
    inertia = np.trace(moments) * np.eye(3) - moments
    assert inertia == close(expected.inertia, abs=1e-6 * expected.inertia.max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bores", "offsets", "step"),
    [
        ((0.06, 0.06), (-0.01, -0.01), "60 mm and 60 mm, 20 mm apart"),  # open into each other
        ((0.05, 0.05), (-0.03, -0.03), "50 mm and 50 mm, 60 mm apart"),  # both blind
        ((0.06, 0.04), (0.0, 0.0), "60 mm and 40 mm"),
        ((0.06, 0.0), (-0.02, 0.0), "60 mm and 0 mm"),
    ],
)
def test_bores_that_do_not_meet_end_in_the_journal(dimensions, bores, offsets, step):
    """Each takes away its own length up to the middle, whatever the other does; turned until they
    meet, equal ones leave no remark."""
    throws = [
        CrankThrow(**dimensions, main_journal_bore=bore, main_journal_bore_offset=offset)
        for bore, offset in zip(bores, offsets, strict=True)
    ]
    shaft = Crankshaft(throws, crank_angles_deg=[0.0, 180.0])
    assert [step in remark for remark in shaft.remarks] == [True]
    with gmsh_session("shaft") as gmsh:
        make_shaft(gmsh, shaft)
        solid = solid_properties(gmsh)
    assert DENSITY * solid.volume == close(shaft.masses(DENSITY).mass, rel=1e-6)
    aligned = Crankshaft(throws, crank_angles_deg=[0.0, 0.0])
    assert bool(aligned.remarks) == (bores[0] != bores[1])


def test_six_in_line_is_balanced_and_three_is_not(dimensions):
    throw = CrankThrow(**dimensions)
    six = Crankshaft([throw] * 6, crank_angles_deg=np.degrees(SIX)).unbalance(DENSITY)
    size = throw_masses(throw, DENSITY).mass * throw.crank_radius
    assert six.static == close([0.0, 0.0], abs=1e-9 * size)
    assert six.dynamic == close([0.0, 0.0], abs=1e-9 * size * throw.length)
    three = Crankshaft([throw] * 3, crank_angles_deg=np.degrees(SIX[:3])).unbalance(DENSITY)
    assert three.static == close([0.0, 0.0], abs=1e-9 * size)
    # Forces of size U at -L, 0 and L, 120 deg apart: a moment of sqrt(3) U L remains.
    one = unbalance(throw_masses(throw, DENSITY), throw.length / 2.0)
    expected = np.sqrt(3.0) * np.linalg.norm(one.static) * throw.length
    assert np.linalg.norm(three.dynamic) == close(expected, rel=1e-9)


def test_what_does_not_fit_together_is_refused(dimensions):
    throw = CrankThrow(**dimensions)
    with refused("crank_angles_deg"):
        Crankshaft([throw] * 3, crank_angles_deg=[0.0, 60.0])
    other = CrankThrow(**{**dimensions, "main_journal_diameter": 0.2})
    with refused("throws"):
        Crankshaft([throw, other], crank_angles_deg=[0.0, 60.0])
    off = CrankThrow(**dimensions, main_journal_bore=0.06, main_journal_bore_offset=0.02)
    assert Crankshaft([off] * 2, crank_angles_deg=[0.0, 0.0]).length == close(2.0 * off.length)
    with refused("crank_angles_deg[0]"):
        Crankshaft([throw], crank_angles_deg=[float("nan")])
    with pytest.raises(InputError, match="flange_thickness: missing"):
        ShaftEnds(flange_diameter=0.4)
