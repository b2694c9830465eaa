import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from geometry.outline import Arc, obround, rectangle


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
    v = np.linspace(outline.foot, outline.tip, 4001)
    assert outline.half_width(v).max() == close(0.15)
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


@pytest.mark.parametrize(
    ("radius", "chamfer", "lost"),
    [(0.0, 0.0, 0.0), (0.05, 0.0, (4.0 - np.pi) * 0.05**2), (0.0, 0.05, 2.0 * 0.05**2)],
)
def test_corners_of_a_rectangle(radius, chamfer, lost):
    outline = rectangle(0.3, 0.14, 0.12, 0.17, radius, chamfer)
    assert area(outline) == close(0.3 * (0.14 + 0.17 + 0.12) - lost, rel=1e-6)


def test_a_rectangle_rounded_to_the_full_is_an_obround():
    rounded = rectangle(0.3, 0.15, 0.15, 0.17, 0.15, 0.0)
    v = np.linspace(-0.15, 0.32, 101)
    expected = obround(0.3, 0.15, 0.15, 0.17).half_width(v)
    assert rounded.half_width(v) == close(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: obround(0.3, 0.1, 0.12, 0.17), "150 mm or more"),
        (lambda: obround(0.3, 0.3, 0.1, 0.17), "swallows"),
        (lambda: rectangle(0.3, 0.15, 0.15, 0.17, 0.2, 0.0), "at most 150 mm"),
        (lambda: rectangle(0.3, 0.15, 0.15, 0.17, 0.02, 0.02), "either rounded or cut"),
    ],
)
def test_impossible_outlines(make, words):
    with pytest.raises(InputError, match=words):
        make()
