"""Meshes made from sizes at the nodes of an earlier one."""

import math
from dataclasses import replace

import gmsh
import numpy as np
import pytest

import geometry.mesh
from comparing import close
from crankbase.errors import InputError, MeshError
from geometry.gmsh_session import IsolatedProcess, gmsh_session
from geometry.mesh import MESHING_STRATEGIES, mesh_throw
from geometry.mesher import mesh_here, mesh_isolated
from geometry.shapes import element_volumes
from geometry.sizes import SizeMap, regular_volume, set_size_map
from geometry.throw import CrankThrow

# Corners and edges of a regular tetrahedron with edges of 1 m.
REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(8.0)
EDGES = [(i, j) for i in range(4) for j in range(i)]


def same(first, second):
    return (
        np.array_equal(first.points, second.points)
        and np.array_equal(first.elements, second.elements)
        and first.surfaces.keys() == second.surfaces.keys()
        and all(
            np.array_equal(first.surfaces[name], second.surfaces[name]) for name in first.surfaces
        )
    )


def map_of(mesh, sizes):
    """Sizes as a function of places, on the mesh's corners."""
    corners, number = np.unique(mesh.elements[:, :4], return_inverse=True)
    points = mesh.points[corners]
    return SizeMap(points, number.reshape(-1, 4), np.asarray(sizes(points), dtype=float))


def wished_size(points, throw):
    return 0.030 - 0.032 * points[:, 2] / throw.length


def mean_edges(points, tetrahedra):
    """Mean edge of each element."""
    corners = points[tetrahedra]
    return np.mean(
        [np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i, j in EDGES], axis=0
    )


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions)


@pytest.fixture(scope="module")
def graded(throw, coarse_mesh):
    """From 30 mm at the left end to 14 mm at the other side of the meshed quarter, the pin's middle."""
    return map_of(coarse_mesh, lambda points: wished_size(points, throw))


@pytest.fixture(scope="module")
def made(throw, graded):
    return mesh_throw(throw, sizes=graded)


def test_volume_of_a_regular_tetrahedron():
    assert np.linalg.norm(REGULAR[0] - REGULAR[1]) == close(1.0)
    expected = abs(np.linalg.det(REGULAR[1:] - REGULAR[0])) / 6.0
    assert regular_volume(np.array([1.0, 0.02])) == close([expected, 8e-6 * expected])


def test_expected_unknowns_scale_with_the_size(graded):
    """Nodes inside grow with the third power, those on the surface with the second."""
    counts = [graded.expected_unknowns(0.5**power) for power in range(-1, 8)]
    growth = np.array(counts[1:]) / counts[:-1]
    assert 4.0 <= growth.min() <= growth.max() <= 8.01
    assert growth[-1] > 7.5
    finer = replace(graded, sizes=0.5 * graded.sizes)
    assert finer.expected_unknowns(2.0) == counts[1]


def test_expected_unknowns_do_not_depend_on_the_order_of_corners(coarse_mesh):
    uniform = map_of(coarse_mesh, lambda points: np.full(len(points), 0.02))
    turned = replace(uniform, tetrahedra=uniform.tetrahedra[::-1, [1, 0, 2, 3]])
    assert turned.expected_unknowns() == uniform.expected_unknowns()


@pytest.mark.parametrize(
    ("part", "size"), [("quarter", 0.040), ("quarter", 0.018), ("half", 0.025), ("full", 0.040)]
)
def test_expected_unknowns_are_about_those_made(throw, part, size):
    """Within 40 %, for budgets and time limits go by them."""
    first = mesh_throw(throw, 2.5, part=part)
    sizes = map_of(first, lambda points: np.full(len(points), size))
    mesh = mesh_throw(throw, 1.0, part, sizes)
    assert mesh.attempts == ()
    assert sizes.expected_unknowns() == close(mesh.unknowns, rel=0.4)


def test_elements_have_the_sizes_of_the_map(made, throw):
    """Slices across the shaft; gmsh makes edges 16 to 28 % longer than it is told."""
    tetrahedra = made.elements[:, :4]
    edges = mean_edges(made.points, tetrahedra)
    centers = made.points[tetrahedra].mean(axis=1)
    wished = wished_size(centers, throw)
    ratios = []
    for low in (0.0, 0.1, 0.2, 0.3, 0.4):
        inside = (centers[:, 2] >= low * throw.length) & (
            centers[:, 2] < (low + 0.1) * throw.length
        )
        assert inside.sum() > 30
        ratios.append(np.mean(edges[inside]) / np.mean(wished[inside]))
    assert min(ratios) > 1.1
    assert max(ratios) < 1.35


def test_a_map_replaces_the_planned_sizes(throw, coarse_mesh, made):
    assert not same(made, coarse_mesh)
    assert made.size_factor == 1.0
    assert made.part == coarse_mesh.part == "quarter"
    assert made.pins == coarse_mesh.pins
    assert made.surfaces.keys() == coarse_mesh.surfaces.keys()


def test_the_factor_scales_the_map(throw, graded):
    expected = mesh_throw(throw, sizes=replace(graded, sizes=0.8 * graded.sizes))
    found = mesh_throw(throw, 0.8, sizes=graded)
    assert found.size_factor == 0.8
    assert same(found, expected)


def test_the_mesh_is_checked_as_others_are(throw, made):
    volume = element_volumes(made.points, made.elements).sum()
    assert 4.0 * made.solid.volume == close(throw.volume, rel=1e-9)
    assert volume == close(made.solid.volume, rel=1e-3)


def test_a_map_of_any_size_gives_a_mesh_of_the_volume(throw, coarse_mesh):
    """Elements as large as a journal's radius would cut chords off it: they are smaller there."""
    for size in (0.1, 0.5):
        coarse = map_of(coarse_mesh, lambda points, size=size: np.full(len(points), size))
        mesh = mesh_throw(throw, sizes=coarse)
        assert mesh.attempts == ()
        volume = element_volumes(mesh.points, mesh.elements).sum()
        assert volume == close(mesh.solid.volume, rel=5e-4)


def test_a_map_whose_mesh_is_refused_is_meshed_finer(throw, graded, monkeypatch):
    def refuse(*_):
        monkeypatch.undo()
        raise MeshError("refused")

    monkeypatch.setattr(geometry.mesh, "check_volume", refuse)
    mesh = mesh_throw(throw, sizes=graded)
    assert mesh.attempts == ("as planned: refused",)
    assert mesh.size_factor == MESHING_STRATEGIES[1].share


@pytest.mark.slow
def test_the_same_mesh_here_and_in_a_process_of_its_own(throw, graded, made):
    process = IsolatedProcess()
    try:
        for _ in range(2):
            assert same(mesh_isolated(throw, sizes=graded, process=process), made)
        # The next mesh without a map knows nothing of it.
        assert same(mesh_isolated(throw, 2.0, process=process), mesh_throw(throw, 2.0))
    finally:
        process.close()
    assert same(mesh_here(throw, sizes=graded), made)


def test_too_many_unknowns_are_refused_before_meshing(throw, graded):
    factor = 0.5 * (graded.expected_unknowns() / 1_500_000) ** (1.0 / 3.0)
    for mesher in (mesh_throw, mesh_isolated):
        with pytest.raises(InputError, match=r"^size_factor: given .*; allowed are 1,500,000"):
            mesher(throw, factor, sizes=graded)


def test_an_open_gmsh_session_gets_nothing_left_behind(throw, graded, made):
    """Sizes travel as a post-processing view, which does not belong to the model."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("of somebody else")
        mine = gmsh.view.add("of somebody else")
        assert same(mesh_throw(throw, sizes=graded), made)
        assert same(mesh_throw(throw, sizes=graded), made)
        assert list(gmsh.view.getTags()) == [mine]
        assert gmsh.model.getCurrent() == "of somebody else"
    finally:
        gmsh.finalize()


def test_the_field_between_nodes_and_beside_the_map():
    """A box of its own, whose map covers half of it: linear inside, the closest node's beside it."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    sizes = SizeMap(corners, np.array([[0, 1, 2, 3]]), np.array([0.05, 0.2, 0.1, 0.1]))
    with gmsh_session("a tetrahedron") as session:
        points = [session.model.occ.addPoint(*corner) for corner in corners]
        lines = {
            (i, j): session.model.occ.addLine(points[i], points[j])
            for i in range(4)
            for j in range(i + 1, 4)
        }
        session.model.occ.synchronize()
        set_size_map(session, sizes, 0.5)
        session.model.mesh.generate(1)
        count = {
            ends: len(session.model.mesh.getElements(1, line)[1][0]) for ends, line in lines.items()
        }
    for (i, j), found in count.items():
        # Along an edge with sizes from a to b there is room for the integral of 1 / size.
        a, b = 0.5 * sizes.sizes[[i, j]]
        length = np.linalg.norm(corners[i] - corners[j])
        room = length / a if math.isclose(a, b) else length * np.log(b / a) / (b - a)
        assert found == close(room, abs=1.5)
