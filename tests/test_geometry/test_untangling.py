"""Tetrahedra made rounder by their corners: turned if inside out, in free directions alone."""

import numpy as np
import pytest

from comparing import close
from geometry.untangling import untangle

# A cube round one corner in the middle, on whose faces two triangles each stand.
CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
MIDDLE = 8
ELEMENTS = np.array([[MIDDLE, a, *ends] for a, b, c, d in FACES for ends in ((b, c), (c, d))])
SIZES = np.full(len(ELEMENTS), 0.5 ** (1 / 3))


def volumes(points):
    sides = points[ELEMENTS[:, 1:]] - points[ELEMENTS[:, :1]]
    return np.linalg.det(sides)


def cube(middle):
    return np.vstack([CORNERS, middle])


def free(projection):
    directions = np.zeros((MIDDLE + 1, 3, 3))
    directions[MIDDLE] = projection
    return directions


def test_the_cube_is_whole():
    assert volumes(cube([0.5, 0.5, 0.5])) == close(np.full(len(ELEMENTS), 0.5))


@pytest.mark.parametrize("start", [[1.4, 0.5, 0.3], [0.5, -2.0, 0.6], [0.02, 0.02, 0.02]])
def test_a_corner_returns_to_the_middle(start):
    points = untangle(cube(start), ELEMENTS, free(np.eye(3)), SIZES)
    assert np.array_equal(points[:MIDDLE], CORNERS)
    assert volumes(points).min() > 0.3
    # Diagonals of the faces draw it aside, by as much from every start.
    middle = untangle(cube([0.5, 0.5, 0.5]), ELEMENTS, free(np.eye(3)), SIZES)
    assert points == close(middle, abs=2e-2)


def test_a_corner_slides_on_its_surface():
    normal = np.array([1.0, 2.0, 2.0]) / 3.0
    start = np.array([0.4, 1.6, -0.2])
    points = untangle(cube(start), ELEMENTS, free(np.eye(3) - np.outer(normal, normal)), SIZES)
    assert normal @ (points[MIDDLE] - start) == close(0.0, abs=1e-12)
    assert volumes(points).min() > 0.0
