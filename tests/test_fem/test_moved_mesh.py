"""Meshes moved from one throw to others: on their surfaces, sound, their slopes those of their answers."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import MeshError
from fem.analysis import Problem, solve_level
from fem.material import STEEL
from fem.moved_mesh import (
    ELASTIC,
    LEAST_QUALITY,
    VELOCITIES,
    ReferenceMesh,
    make_reference,
)
from fem.responses import evaluate_throw
from fem.solver import Stopwatch
from fem.superelement import combine_classes
from fem.supports import support_throw
from fem.symmetry import SHARED, degree_of, radial_directions, symmetry_classes
from geometry.boundary_motion import (
    STEP,
    bounding_surfaces,
    level_values,
    surface_conditions,
    with_length,
)
from geometry.mesh import mesh_throw
from geometry.shapes import element_volumes, smallest_jacobians
from geometry.sizes import SHARES
from geometry.throw import CrankThrow
from throws import MEDIUM_SPEED

PATHS = ("web_width", "web_thickness", "pin_length", "fillet_radius")
THROW = CrankThrow(
    **MEDIUM_SPEED,
    main_journal_bore=0.08,
    counterweight={"outer_radius": 0.26, "angle": 2.0},
)


@pytest.fixture(scope="module")
def reference():
    return make_reference(THROW, PATHS, mesh_throw_here)


def mesh_throw_here(throw, factor, part, sizes):
    return mesh_throw(throw, factor, part, sizes)


def changed(**shares):
    throw = THROW
    for path, share in shares.items():
        throw = with_length(throw, path, share * getattr(throw, path))
    return throw


OTHERS = [
    changed(),
    changed(web_width=1.05, pin_length=0.95),
    changed(web_thickness=1.04, fillet_radius=0.95, web_width=0.98),
]


@pytest.mark.parametrize("throw", OTHERS, ids=["itself", "wide", "thick"])
@pytest.mark.parametrize("tier", [VELOCITIES, ELASTIC])
def test_a_moved_mesh_bounds_its_throw(reference, throw, tier):
    moved = reference._accepted(throw, tier).mesh
    assert np.array_equal(moved.elements, reference.mesh.elements)
    surfaces = bounding_surfaces(throw.parts, moved.part)
    numbers, nodes = surface_conditions(bounding_surfaces(THROW.parts, moved.part), reference.mesh)
    levels = [surface.level for surface in surfaces.values()]
    at = moved.points.copy()
    # Edges that were straightened lie beside the surface.
    corners = np.isin(nodes, moved.elements[:, :4])
    off = np.abs(level_values(levels, numbers[corners], at[nodes[corners]]))
    assert off.max() < 1e-9 * throw.length
    assert smallest_jacobians(moved.points, moved.elements).min() > 0.0
    volume = element_volumes(moved.points, moved.elements).sum()
    assert volume == close(SHARES[moved.part] * throw.volume, rel=2e-3)
    assert moved.length == throw.length


def test_a_mesh_is_moved_to_its_own_throw_by_nothing(reference):
    moved = reference.at(THROW).mesh
    assert np.abs(moved.points - reference.mesh.points).max() < 1e-6 * THROW.length


@pytest.mark.parametrize(
    "throw", [THROW.changed(fillet_radius=0.0), THROW.changed(web_tip_thickness=0.06)]
)
def test_another_topology_is_refused(reference, throw):
    with pytest.raises(MeshError, match="another topology"):
        reference.at(throw)


CREASED = MEDIUM_SPEED | {"web_journal_end": 0.15, "web_pin_end": 0.14}


@pytest.fixture(scope="module")
def creased():
    """Sides of the web meet in creases so flat that these move far."""
    paths = ("web_width", "web_journal_end", "web_pin_end")
    return make_reference(CrankThrow(**CREASED), paths, mesh_throw_here)


@pytest.mark.parametrize(
    "change", [{"web_journal_end": 0.143}, {"web_pin_end": 0.13}, {"web_width": 0.294}]
)
def test_elements_that_turn_inside_out_are_turned_back(creased, change, monkeypatch):
    throw = CrankThrow(**CREASED | change)
    moved = creased.at(throw)
    assert moved.tier == ELASTIC
    assert moved.quality > LEAST_QUALITY
    assert smallest_jacobians(moved.mesh.points, moved.mesh.elements).min() > 0.0
    # Nodes follow steps of a dimension without sliding anew.
    path = next(iter(change))
    motion = creased.motion_at(throw, ELASTIC, [path])
    beside = creased._straightened(motion.beside[path][1], ELASTIC, creased._shift(throw, ELASTIC))
    step = STEP * change[path] * motion.velocities[path]
    length = np.abs(step).max()
    assert np.abs(moved.mesh.points + step - beside[0]).max() < 1e-2 * length
    monkeypatch.setattr("fem.moved_mesh.ROUNDS", 0)
    with pytest.raises(MeshError, match="inside out"):
        creased.at(throw)


def test_a_mesh_that_would_suffer_is_refused(reference):
    with pytest.raises(MeshError, match="cannot be moved"):
        reference.at(changed(pin_length=0.3))


def test_rounded_exits_of_oil_holes_are_not_moved():
    hole = {"part": "pin", "diameter": 0.02, "exit_radius": 0.004}
    throw = CrankThrow(**MEDIUM_SPEED, oil_holes=(hole,))
    with pytest.raises(MeshError, match="rounded exits"):
        ReferenceMesh.of(throw, mesh_throw(throw, 6.0), PATHS)


def discrete_answers(reference, throw):
    """Compliances of the moved mesh without correction."""
    problem = Problem(STEEL, "auto", "rigid", Stopwatch(), degree_of(SHARED))
    level = solve_level(reference._accepted(throw, VELOCITIES).mesh, problem)
    classes = level.condense(symmetry_classes(level.mesh.part), problem)
    plain = combine_classes([part.discrete or part for part in classes], radial_directions(throw))
    found = support_throw(plain, "pinned")
    return np.array([found.axial, found.torsional, found.influence])


@pytest.mark.parametrize("throw", OTHERS[:2], ids=["itself", "wide"])
def test_slopes_are_those_of_the_moved_mesh(reference, throw):
    """Differences of its answers over two steps, of which the error of second order cancels."""
    paths = ("web_width", "pin_length")
    found = evaluate_throw(throw, slopes=paths, reference=reference)
    assert found.moved.tier == VELOCITIES
    for path in paths:
        size = getattr(throw, path)

        def share(step, path=path, size=size):
            low, high = (
                discrete_answers(reference, with_length(throw, path, size * (1.0 + s)))
                for s in (-step, step)
            )
            return np.log(high / low) / (2.0 * step)

        by_difference = (4.0 * share(2e-4) - share(4e-4)) / 3.0
        slopes = [
            found.slopes[name][path]
            for name in (
                "axial_compliance_pinned", "torsional_compliance_pinned",
                "influence_coefficient_pinned",
            )
        ]  # fmt: skip
        assert np.abs(slopes - by_difference).max() < 1e-6


def test_a_throw_that_no_mesh_can_be_moved_to_is_meshed(reference):
    throw = CrankThrow(**MEDIUM_SPEED)
    found = evaluate_throw(throw, accuracy=0.1, reference=reference)
    assert found.moved is None
    assert found.values == evaluate_throw(throw, accuracy=0.1).values
