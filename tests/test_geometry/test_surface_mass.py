import numpy as np
import pytest

from comparing import close
from geometry.gmsh_session import gmsh_session
from geometry.mesh import properties_of
from geometry.surface_mass import measured_properties

# Half axes and length of an elliptic cylinder.
AXES = (3.0, 2.0, 1.0)


@pytest.fixture
def gmsh():
    with gmsh_session("mass") as gmsh:
        yield gmsh


def test_a_spline_body_weighs_what_it_should_beside_others(gmsh):
    occ = gmsh.model.occ
    body = occ.addCylinder(5.0, -1.0, 2.0, 0.0, 0.0, 1.0, 1.0)
    occ.dilate([(3, body)], 5.0, -1.0, 2.5, *AXES)
    occ.addBox(20.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    occ.synchronize()
    measured = measured_properties(gmsh, body)
    volume = np.pi * np.prod(AXES)
    assert measured.volume == close(volume, rel=3e-5)
    assert measured.center == close([5.0, -1.0, 2.5], abs=3e-5)
    wanted = np.diag(volume * np.square(AXES) / [4.0, 4.0, 12.0])
    assert measured.second_moments == close(wanted, abs=1e-4 * wanted.max())
    assert len(gmsh.model.mesh.getNodes()[0]) == 0


def test_pieces_with_a_common_cut_make_up_the_whole(gmsh):
    """Only one of them has the cut's face with its outside out."""
    occ = gmsh.model.occ
    body = occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0)
    occ.affineTransform([(3, body)], np.eye(4)[:3].ravel().tolist())
    disk = occ.addDisk(0.0, 0.0, 0.7, 2.0, 2.0)
    _, (pieces, *_) = occ.fragment([(3, body)], [(2, disk)])
    occ.synchronize()
    first, second = (measured_properties(gmsh, tag) for dimension, tag in pieces if dimension == 3)
    assert sorted([first.volume, second.volume]) == close([0.7 * np.pi, 1.3 * np.pi], rel=3e-5)
    assert sorted([first.center[2], second.center[2]]) == close([0.35, 1.35], rel=3e-5)


def test_the_kernel_weighs_plain_bodies(gmsh):
    body = gmsh.model.occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0)
    gmsh.model.occ.synchronize()
    measured, expected = measured_properties(gmsh, body), properties_of(gmsh, body)
    assert (measured.volume, *measured.center) == (expected.volume, *expected.center)
