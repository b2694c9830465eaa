import numpy as np
import pytest

from comparing import close
from fem.fields import displacement_field, images
from fem.supports import STRETCH, end_motions

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def models(mesh, half_mesh, full_mesh, condensed):
    meshes = {"quarter": mesh, "half": half_mesh, "full": full_mesh}
    return {part: (found, condensed(found)[0]) for part, found in meshes.items()}


def rows_of(points, wanted):
    """Number of the node at each wanted place."""
    found = {tuple(place): number for number, place in enumerate(points.round(8) + 0.0)}
    return [found[tuple(place)] for place in wanted.round(8) + 0.0]


@pytest.mark.parametrize("part", ["quarter", "half", "full"])
def test_images_make_the_whole_throws_field(models, part):
    """Against the field of the full mesh, for motions with nothing symmetric in them."""
    motions = np.random.default_rng(5).normal(size=12)
    mesh, classes = models[part]
    full, whole = models["full"]
    expected = displacement_field(whole, motions)
    copies = images(mesh, classes, motions)
    assert len(copies) == {"quarter": 4, "half": 2, "full": 1}[part]
    assert np.array_equal(copies[0].points, mesh.points)
    assert copies[0].displacement == close(displacement_field(classes, motions))
    nodes = set()
    for copy in copies:
        rows = rows_of(full.points, copy.points)
        nodes.update(rows)
        assert copy.displacement == close(expected[rows], abs=1e-8)
    assert nodes == set(range(len(full.points)))
    assert sum(copy.inside_out for copy in copies) == len(copies) // 2


@pytest.mark.parametrize("part", ["quarter", "half", "full"])
def test_rigid_motions_have_rigid_fields(models, rigid_motions, throw, part):
    mesh, classes = models[part]
    found = displacement_field(classes, rigid_motions)
    expected = np.zeros_like(found)
    expected[:, :, :3] = np.eye(3)
    for axis in range(3):
        turned = np.cross(np.eye(3)[axis], mesh.points)
        expected[:, :, 3 + axis] = turned / throw.crank_radius
    assert found == close(expected, abs=1e-9)


def test_pins_move_as_the_superelement_says(models, superelement, pin_shapes):
    """Under an axial pull the pin goes towards the shaft by c."""
    _, classes = models["quarter"]
    motions = end_motions(superelement, "pinned")[:, 0]
    field = displacement_field(classes, motions)
    ends = superelement.pin_load.T @ motions
    assert pin_shapes[0] @ field[:, 1] == close(ends[1], rel=1e-9)
    assert STRETCH @ motions > 0.0 > ends[1]
