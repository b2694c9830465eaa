"""Throws, crankshafts and meshes on the axes of a diagram: what is drawn has the objects' own numbers."""

import math

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.collections import PolyCollection

from comparing import close
from crankbase.diagrams import display_unit
from geometry.crankshaft import Crankshaft, ShaftEnds
from geometry.mesh import SolidProperties, ThrowMesh
from geometry.plots.throw_plot import positioned_parts, view_frame
from geometry.throw import CrankThrow
from refusals import refused


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions)


def reach(axes):
    """Lowest and highest point of the filled surfaces."""
    points = np.vstack([patch.get_path().vertices for patch in axes.patches])
    return points.min(axis=0), points.max(axis=0)


def test_a_throw_is_drawn_to_scale(throw):
    axes = throw.plot(dimensions=False)
    low, high = reach(axes)
    # z from 0 to the length; y from the webs' foot, B / 2 below the shaft, to B / 2 above the pin.
    assert low == close([0.0, -0.150])
    assert high == close([throw.length, 0.170 + 0.150])
    assert axes.get_aspect() == 1.0
    assert axes.get_xlabel().endswith("[m]")
    assert axes.get_ylabel().endswith("[m]")


def test_dimensions_are_written_in_millimeters(throw):
    axes = throw.plot()
    assert {"$h$ 68", "395"} <= {text.get_text() for text in axes.texts}
    assert "lengths in mm" in axes.get_title("left")
    assert "$R$ 170" in {text.get_text() for text in throw.plot(view="left end").texts}


@pytest.mark.slow
def test_letters_keep_to_the_axes_that_are_given(throw):
    figure, both = pyplot.subplots(1, 2, figsize=(9.0, 4.0))
    for axes, view in zip(both, ("side", "left end"), strict=True):
        assert throw.plot(axes, view=view) is axes
    figure.canvas.draw()
    for axes in both:
        frame = axes.get_window_extent()
        for text in axes.texts:
            box = text.get_window_extent()
            # Letters are measured as outlines, which rounding to pixels may widen by a few.
            assert frame.x0 - 4.0 <= box.x0
            assert box.x1 <= frame.x1 + 4.0


def test_no_other_views(throw):
    with refused("view"):
        throw.plot(view="top")


def test_parts_are_turned_and_moved(throw):
    placed = positioned_parts(throw.parts, math.pi / 2.0, 1.0)
    assert placed.pins[0].axis == close((-0.170, 0.0), abs=1e-15)
    assert placed.webs[1].end == close(throw.parts.webs[1].end + 1.0)
    assert placed.cylinders[0].axis == close((0.0, 0.0))


def test_a_crankshaft_has_its_throws_at_their_angles(throw):
    ends = ShaftEnds(free_end_diameter=0.2, free_end_length=0.15)
    shaft = Crankshaft([throw, throw], crank_angles_deg=[0.0, 180.0], ends=ends)
    axes = shaft.plot()
    low, high = reach(axes)
    assert (low[0], high[0]) == close(shaft.reach)
    assert (low[1], high[1]) == close((-0.320, 0.320))
    assert [text.get_text() for text in axes.texts] == ["1", "2"]


def test_a_mesh_shows_what_looks_at_the_eye():
    """One tetrahedron with its corner at the origin, seen along +z: one face looks there."""
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
    facets = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    mesh = ThrowMesh(
        part="half",
        length=0.1,
        pins=("pin",),
        points=points,
        elements=np.arange(10)[None],
        surfaces={"web": facets[[0, 1, 3]], "crank plane": facets[[2]]},
        size_factor=1.0,
        mended_elements=0,
        solid=SolidProperties(1e-3 / 6.0, np.full(3, 0.025), np.eye(3)),
    )
    axes = mesh.plot(eye=(0.0, 0.0, 1.0))
    (drawn,) = [one for one in axes.collections if isinstance(one, PolyCollection)]
    (face,) = drawn.get_paths()
    # x to the right, y up.
    assert face.vertices[:3] == close(points[[1, 2, 3], :2])
    assert axes.get_title("left") == "Half mesh, 1 element"
    assert axes.get_legend().get_texts()[0].get_text() == "cut: crank plane"
    with refused("eye"):
        mesh.plot(eye=(0.0, 1.0, 0.0))


def test_a_view_is_a_right_handed_frame():
    frame = view_frame(np.array([-1.0, 0.45, -0.6]))
    assert frame @ frame.T == close(np.eye(3), abs=1e-15)
    assert np.linalg.det(frame) == close(1.0)
    assert frame[1, 1] > 0.0  # the crank stands upright


@pytest.mark.parametrize(
    ("unit", "shown"),
    [("m", ("mm", 1e-3)), ("m/N", ("$10^{-9}$ m/N", 1e-9)), ("kg", ("kg", 1.0)), ("", ("1", 1.0))],
)
def test_units_on_axes(unit, shown):
    assert display_unit(unit) == shown
