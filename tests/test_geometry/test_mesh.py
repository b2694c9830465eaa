"""Meshes of throws, and meshes made from sizes at the nodes of an earlier one."""

import ctypes
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace

import gmsh
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from skfem import ElementTetP2, ElementTriP2
from skfem.quadrature import get_quadrature

import geometry.mesh
from comparing import close, same_mesh
from crankbase.errors import InputError, MeshError
from geometry.mesh import MESHING_STRATEGIES, check_quality, check_volume, mesh_throw
from geometry.mesher import mesh_isolated
from geometry.shapes import (
    EDGES,
    RULES,
    corner_quality,
    element_quadrature,
    element_volumes,
    quadrature,
    smallest_jacobians,
    straighten_elements,
)
from geometry.sizes import SizeMap, regular_volume
from geometry.solid import CRANK_PLANE, FILLET, LEFT_END, MAIN_JOURNAL, MIDDLE_PLANE, PIN, WEB
from geometry.throw import CrankThrow
from refusals import refused

VARIANTS = {
    "plain": {},
    "sharp": {"fillet_radius": 0.0},
    "large fillet": {"fillet_radius": 0.030},
    "fillet as large as the web allows": {"fillet_radius": 0.040},
    "fillet as large as the journal allows": {"fillet_radius": 0.054, "web_width": 0.340},
    "fillets flush with web and both journals": {
        "fillet_radius": 0.022,
        "web_width": 0.264,
        "pin_diameter": 0.220,
    },
    "web hardly wider than the journals": {
        "fillet_radius": 0.0,
        "web_width": 0.22022,
        "pin_diameter": 0.220,
    },
    "no overlap": {"crank_radius": 0.300},
    "pin inside the main journal": {"crank_radius": 0.020},
    "thick web": {"web_thickness": 0.200},
}


def corner_areas(mesh, name):
    a, b, c = mesh.points[mesh.surfaces[name]].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def determinants(mesh, order):
    """Jacobian determinants (m, q) of all elements at quadrature points, by the definition."""
    where, _ = get_quadrature(ElementTetP2.refdom, order)
    element = ElementTetP2()
    slopes = np.array([element.lbasis(where, i)[1] + np.zeros_like(where) for i in range(10)])
    return np.linalg.det(np.einsum("aiq,maj->mqij", slopes, mesh.points[mesh.elements]))


@pytest.mark.parametrize("variant", VARIANTS)
def test_solid_and_mesh_have_the_volume_of_the_closed_form(dimensions, variant):
    throw = CrankThrow(**{**dimensions, **VARIANTS[variant]})
    mesh = mesh_throw(throw, 1.8)
    assert 4.0 * mesh.solid.volume == close(throw.volume, rel=1e-9)
    assert 4.0 * element_volumes(mesh.points, mesh.elements).sum() == close(throw.volume, rel=1e-3)
    assert determinants(mesh, 6).min() > 0.0
    assert smallest_jacobians(mesh.points, mesh.elements).min() >= 0.05


def test_finer_meshes_reach_the_volume(dimensions):
    throw = CrankThrow(**dimensions)
    mesh = mesh_throw(throw, 0.7)
    assert 4.0 * element_volumes(mesh.points, mesh.elements).sum() == close(throw.volume, rel=1e-5)


@pytest.mark.parametrize("scale", [1.0, 0.05, 8.0])
def test_named_surfaces_cover_their_places(dimensions, scale):
    throw = CrankThrow(**{name: scale * value for name, value in dimensions.items()})
    mesh = mesh_throw(throw, 1.0)
    main, pin = throw.main_journal_diameter / 2.0, throw.pin_diameter / 2.0
    fillet, half = throw.fillet_radius, throw.web_width / 2.0
    areas = {name: corner_areas(mesh, name).sum() for name in mesh.surfaces}
    rim = np.pi * half + throw.crank_radius
    faces = np.pi * half**2 / 2.0 + half * throw.crank_radius
    expected = {
        LEFT_END: np.pi * main**2 / 2.0,
        MIDDLE_PLANE: np.pi * pin**2 / 2.0,
        MAIN_JOURNAL: np.pi * main * (throw.main_journal_length / 2.0 - fillet),
        PIN: np.pi * pin * (throw.pin_length / 2.0 - fillet),
        # A quarter of a torus at each journal, about its axis by half a turn.
        FILLET: np.pi
        * sum((radius + fillet) * np.pi / 2.0 * fillet - fillet**2 for radius in (main, pin)),
        CRANK_PLANE: main * throw.main_journal_length
        + (throw.crank_radius + throw.web_width) * throw.web_thickness
        + pin * throw.pin_length
        + 4.0 * (1.0 - np.pi / 4.0) * fillet**2,
        WEB: rim * throw.web_thickness
        + 2.0 * faces
        - np.pi / 2.0 * ((main + fillet) ** 2 + (pin + fillet) ** 2),
    }
    assert areas.keys() == expected.keys()
    for name, area in expected.items():
        # Chords across the fillets and journals are shorter than the arcs.
        assert areas[name] == close(area, rel=0.05), name
    # The cut and end surfaces are flat, so their areas are exact but for curved outlines.
    assert areas[CRANK_PLANE] == close(expected[CRANK_PLANE], rel=5e-3)


def test_sharp_corners_have_no_fillet_surface_and_small_elements(dimensions):
    throw = CrankThrow(**{**dimensions, "fillet_radius": 0.0})
    mesh = mesh_throw(throw, 1.0)
    assert len(mesh.surfaces[FILLET]) == 0
    corner = throw.main_journal_diameter / 2.0
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    on_corner = (np.abs(radius - corner) < 1e-9) & (
        np.abs(mesh.points[:, 2] - throw.main_journal_length / 2.0) < 1e-9
    )
    # Nodes stand about half an element's length apart along the half circle.
    assert on_corner.sum() > 0.8 * np.pi * corner / (0.05 * throw.web_thickness)


@pytest.mark.slow
def test_bit_identical_wherever_it_runs(dimensions, coarse_mesh):
    throw = CrankThrow(**dimensions)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as processes, ThreadPoolExecutor(1) as threads:
        away = processes.submit(mesh_throw, throw, 2.0)
        meshes = [mesh_throw(throw, 2.0), threads.submit(mesh_throw, throw, 2.0).result()]
        meshes.append(away.result(timeout=120))
    assert all(same_mesh(mesh, coarse_mesh) for mesh in meshes)


def straight_tetrahedra(corners, connections):
    """Points and ten-node elements of straight tetrahedra that share edge nodes."""
    points, number, elements = [*map(np.asarray, corners)], {}, []
    for element in connections:
        row = list(element)
        for first, second in EDGES:
            edge = frozenset((element[first], element[second]))
            if edge not in number:
                number[edge] = len(points)
                points.append(0.5 * (points[element[first]] + points[element[second]]))
            row.append(number[edge])
        elements.append(row)
    return np.array(points, dtype=float), np.array(elements, dtype=np.int64)


CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
TWO = [(0, 1, 2, 3), (1, 2, 3, 4)]


@pytest.mark.parametrize(("dimension", "order"), RULES)
def test_rules_of_quadrature_are_those_of_scikit_fem(dimension, order):
    element = {2: ElementTriP2, 3: ElementTetP2}[dimension]
    made, known = (
        np.vstack(rule) for rule in (quadrature(dimension, order), get_quadrature(element, order))
    )
    made, known = (rule[:, np.lexsort(rule.round(9))] for rule in (made, known))
    assert made == close(known, rel=1e-14)


def test_volumes_of_curved_tetrahedra_are_those_of_a_quadrature_that_is_more_than_exact():
    draw = np.random.default_rng(2)
    points, elements = draw.random((20, 3)), np.array([draw.permutation(20)[:10] for _ in "abc"])
    exact = element_quadrature(points, elements, 6)[1].reshape(3, -1).sum(axis=1)
    assert element_volumes(points, elements) == close(exact, abs=1e-15)


def test_mending_straightens_what_curving_turned_inside_out_by_halves():
    points, elements = straight_tetrahedra(CORNERS, TWO)
    straight = points.copy()
    shared = elements[0, 5]  # the edge node between corners 1 and 2
    points[shared] -= 0.45
    kept = elements[0, 4]
    points[kept] += (0.0, 0.0, 0.02)
    assert smallest_jacobians(points, elements).min() < 0.0
    mended_points, mended = straighten_elements(points, elements)
    assert smallest_jacobians(mended_points, elements).min() > 0.05
    assert mended == np.count_nonzero(smallest_jacobians(points, elements) < 0.05)
    bow, left = (where[shared] - straight[shared] for where in (points, mended_points))
    halvings = np.log2(bow / left)
    assert halvings == close(np.full(3, round(halvings[0])), rel=1e-12)
    again = straight + 2.0 * (mended_points - straight)  # one halving less was not enough
    assert smallest_jacobians(again, elements).min() < 0.05


def test_mending_leaves_sound_meshes_alone():
    points, elements = straight_tetrahedra(CORNERS, TWO)
    points[elements[0, 4]] += (0.0, 0.0, 0.02)
    mended_points, mended = straighten_elements(points, elements)
    assert mended == 0
    assert np.array_equal(mended_points, points)


def test_what_cannot_be_mended_is_refused():
    points, elements = straight_tetrahedra(CORNERS, [(1, 0, 2, 3)])
    with pytest.raises(MeshError, match="stay inside out"):
        straighten_elements(points, elements)


def test_mended_elements_are_counted(dimensions):
    mesh = mesh_throw(CrankThrow(**dimensions), 3.0)
    assert mesh.mended_elements > 0
    assert smallest_jacobians(mesh.points, mesh.elements).min() >= 0.05


def test_meshes_leave_no_types_of_arrays_behind(dimensions):
    mesh_throw(CrankThrow(**dimensions), 3.0)
    before = len(ctypes._pointer_type_cache)
    mesh_throw(CrankThrow(**dimensions), 2.6)
    assert len(ctypes._pointer_type_cache) <= before


def test_a_mesh_of_another_volume_is_refused_with_both_volumes(dimensions):
    mesh = mesh_throw(CrankThrow(**dimensions), 3.0)
    check_volume(mesh.points, mesh.elements, mesh.solid)
    for factor in (1.001, np.nan):
        with pytest.raises(MeshError, match=r"volume of .* 0.1 %"):
            check_volume(factor * mesh.points, mesh.elements, mesh.solid)


def test_a_mesh_that_misses_the_volume_is_made_again_finer(dimensions, monkeypatch):
    check, seen = check_volume, []

    def refuse_once(points, elements, solid):
        seen.append(len(points))
        if len(seen) == 1:
            raise MeshError("refused")
        check(points, elements, solid)

    monkeypatch.setattr(geometry.mesh, "check_volume", refuse_once)
    mesh = mesh_throw(CrankThrow(**dimensions), 2.0)
    assert len(mesh.points) == seen[1] > seen[0]
    assert mesh.size_factor == close(1.6)
    assert mesh.attempts == ("as planned: refused",)


@pytest.mark.slow
@pytest.mark.parametrize("rung", range(len(MESHING_STRATEGIES)))
def test_every_way_of_meshing_gives_the_same_part(dimensions, rung):
    throw = CrankThrow(**dimensions, pin_bore=0.06)
    failed = tuple(f"{way.what}: tried elsewhere" for way in MESHING_STRATEGIES[:rung])
    mesh = mesh_throw(throw, 1.2, "auto", None, failed)
    assert mesh.attempts[:rung] == failed
    assert 4.0 * mesh.solid.volume == close(throw.volume, rel=1e-9)


@pytest.mark.slow
def test_a_hopeless_mesh_is_an_error_that_says_what_was_tried(dimensions, monkeypatch):
    def refuse(*_):
        raise MeshError("refused")

    monkeypatch.setattr(geometry.mesh, "check_volume", refuse)
    with pytest.raises(MeshError, match=f"{len(MESHING_STRATEGIES)} ways .* refused"):
        mesh_throw(CrankThrow(**dimensions), 3.0)


def test_a_solid_that_lost_a_part_is_not_meshed(dimensions, monkeypatch):
    throw = CrankThrow(**dimensions)
    monkeypatch.setattr(geometry.mesh, "throw_volume", lambda _: 1.001 * throw.volume)
    with pytest.raises(MeshError, match="the solid has a volume of"):
        mesh_throw(throw, 3.0)


def test_flat_elements_are_refused():
    points, elements = straight_tetrahedra(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1e-6)], [(0, 1, 2, 3)]
    )
    with pytest.raises(MeshError, match="flat"):
        check_quality(points, elements)
    regular = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    for sense, corners in ((-1.0, (0, 1, 2, 3)), (1.0, (0, 2, 1, 3))):
        points, elements = straight_tetrahedra(regular, [corners])
        assert corner_quality(points, elements) == close([sense])


@st.composite
def throws(draw):
    """Throws that can be built, from 40 mm to 400 mm journals, limits included."""

    def share(low, high):
        return draw(st.floats(low, high, allow_subnormal=False))

    main = share(0.04, 0.4)
    pin = main * share(0.6, 1.2)
    sizes = {
        "main_journal_diameter": main,
        "pin_diameter": pin,
        "crank_radius": main * share(0.25, 2.0),
        "main_journal_length": main * share(0.2, 1.5),
        "pin_length": main * share(0.2, 1.5),
        "web_width": max(main, pin) * share(1.002, 2.0),
        "web_thickness": main * share(0.12, 1.0),
    }
    room = min(
        0.45 * sizes["main_journal_length"],
        0.45 * sizes["pin_length"],
        0.5 * (sizes["web_width"] - max(main, pin)),
    )
    smallest = 0.01 * max(main, pin)
    if room > smallest and draw(st.booleans()):
        sizes["fillet_radius"] = share(smallest, room)
    try:
        return CrankThrow(**sizes)
    except InputError:  # a part too thin beside a long crank radius
        return CrankThrow(**{**sizes, "crank_radius": main})


@pytest.mark.slow
@settings(
    max_examples=8,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(throws())
def test_any_throw_that_can_be_built_is_meshed(throw):
    mesh = mesh_throw(throw, 1.5)
    assert 4.0 * mesh.solid.volume == close(throw.volume, rel=1e-8)
    assert 4.0 * element_volumes(mesh.points, mesh.elements).sum() == close(throw.volume, rel=1e-3)
    assert determinants(mesh, 5).min() > 0.0
    empty = {name for name, facets in mesh.surfaces.items() if len(facets) == 0}
    assert empty == (set() if throw.fillet_radius > 0.0 else {FILLET})


# Corners and edges of a regular tetrahedron with edges of 1 m.
REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(8.0)


def map_of(mesh, sizes):
    """Sizes as a function of places, on the mesh's corners."""
    corners, number = np.unique(mesh.elements[:, :4], return_inverse=True)
    points = mesh.points[corners]
    return SizeMap(points, number.reshape(-1, 4), np.asarray(sizes(points), dtype=float))


def wished_size(points, throw):
    return 0.030 - 0.032 * points[:, 2] / throw.length


@pytest.fixture(scope="module")
def map_throw(dimensions):
    return CrankThrow(**dimensions)


@pytest.fixture(scope="module")
def graded(map_throw, coarse_mesh):
    """From 30 mm at the left end to 14 mm at the other side of the meshed quarter, the pin's middle."""
    return map_of(coarse_mesh, lambda points: wished_size(points, map_throw))


@pytest.fixture(scope="module")
def made(map_throw, graded):
    return mesh_throw(map_throw, sizes=graded)


def test_volume_of_a_regular_tetrahedron():
    assert np.linalg.norm(REGULAR[0] - REGULAR[1]) == close(1.0)
    expected = abs(np.linalg.det(REGULAR[1:] - REGULAR[0])) / 6.0
    assert regular_volume(np.array([1.0, 0.02])) == close([expected, 8e-6 * expected])


def test_expected_unknowns_do_not_depend_on_the_order_of_corners(coarse_mesh):
    uniform = map_of(coarse_mesh, lambda points: np.full(len(points), 0.02))
    turned = replace(uniform, tetrahedra=uniform.tetrahedra[::-1, [1, 0, 2, 3]])
    assert turned.expected_unknowns() == uniform.expected_unknowns()


def test_a_map_replaces_the_planned_sizes(map_throw, coarse_mesh, made):
    assert not same_mesh(made, coarse_mesh)
    assert made.size_factor == 1.0
    assert made.part == coarse_mesh.part == "quarter"
    assert made.pins == coarse_mesh.pins
    assert made.surfaces.keys() == coarse_mesh.surfaces.keys()


@pytest.mark.slow
def test_the_factor_scales_the_map(map_throw, graded):
    expected = mesh_throw(map_throw, sizes=replace(graded, sizes=0.8 * graded.sizes))
    found = mesh_throw(map_throw, 0.8, sizes=graded)
    assert found.size_factor == 0.8
    assert same_mesh(found, expected)


@pytest.mark.slow
def test_a_map_whose_mesh_is_refused_is_meshed_finer(map_throw, graded, monkeypatch):
    def refuse(*_):
        monkeypatch.undo()
        raise MeshError("refused")

    monkeypatch.setattr(geometry.mesh, "check_volume", refuse)
    mesh = mesh_throw(map_throw, sizes=graded)
    assert mesh.attempts == ("as planned: refused",)
    assert mesh.size_factor == MESHING_STRATEGIES[1].share


def test_too_many_unknowns_are_refused_before_meshing(map_throw, graded):
    factor = 0.5 * (graded.expected_unknowns() / 1_500_000) ** (1.0 / 3.0)
    for mesher in (mesh_throw, mesh_isolated):
        with refused("size_factor"):
            mesher(map_throw, factor, sizes=graded)


@pytest.mark.slow
def test_an_open_gmsh_session_gets_nothing_left_behind(map_throw, graded, made):
    """Sizes travel as a post-processing view, which does not belong to the model."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("of somebody else")
        mine = gmsh.view.add("of somebody else")
        assert same_mesh(mesh_throw(map_throw, sizes=graded), made)
        assert same_mesh(mesh_throw(map_throw, sizes=graded), made)
        assert list(gmsh.view.getTags()) == [mine]
        assert gmsh.model.getCurrent() == "of somebody else"
    finally:
        gmsh.finalize()
