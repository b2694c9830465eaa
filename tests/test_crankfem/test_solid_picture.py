import math
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from matplotlib.image import imread

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.throw.pictures import solid_picture
from crankfem.analyses.throw.pictures.solid_picture import (
    ENDS,
    PICTURE,
    picture_shaft,
    picture_throw,
    render,
    shaft_surface,
    throw_surface,
)
from geometry.crankshaft import Crankshaft, ShaftEnds
from geometry.throw import CrankThrow
from throws import MEDIUM_SPEED

pytestmark = pytest.mark.slow

DIMENSIONS = dict(MEDIUM_SPEED)
# One throw for each part that may be meshed.
THROWS = {
    "quarter": {"main_journal_bore": 0.06},
    "half": {"left_web": {"counterweight": {"outer_radius": 0.25, "angle": 2.0}}},
    "full": {"further_pins": [{"angle": math.radians(30.0), "web_thickness": 0.0}]},
}
ENDS_GIVEN = ShaftEnds(
    free_end_diameter=0.15, free_end_length=0.2, flange_diameter=0.4, flange_thickness=0.05
)


@cache
def throw_of(part):
    throw = CrankThrow(**DIMENSIONS, **THROWS[part])
    assert throw.symmetry == part
    return throw


@cache
def shaft_of(part):
    return Crankshaft([throw_of(part)] * 3, crank_angles_deg=[0.0, 120.0, 240.0], ends=ENDS_GIVEN)


def volume_inside(surface):
    """Volume that triangles enclose, positive if they are counterclockwise from outside."""
    a, b, c = (surface.points[surface.triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


# ------------------------------------------------------------------------------------- surfaces


@pytest.mark.further
@pytest.mark.parametrize("part", THROWS)
def test_surface_encloses_the_throw(part):
    throw = throw_of(part)
    surface = throw_surface(throw, fineness=3)
    assert volume_inside(surface) == close(throw.volume, rel=5e-4)
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    np.testing.assert_allclose((low[2], high[2]), (0.0, throw.length), atol=1e-9)
    assert high[1] == close(0.170 + 0.1425, rel=1e-3)
    if part != "full":
        np.testing.assert_allclose(low[0], -high[0], rtol=1e-9)


def test_finer_triangles_come_closer_to_the_throw():
    throw = throw_of("quarter")
    errors = [
        abs(volume_inside(throw_surface(throw, fineness)) - throw.volume) for fineness in (1, 2, 4)
    ]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]


def test_surface_of_a_shaft_encloses_throws_and_ends():
    shaft = shaft_of("quarter")
    surface = shaft_surface(shaft, fineness=3)
    ends = sum(0.25 * math.pi * d**2 * (high - low) for d, low, high in shaft.end_cylinders)
    assert volume_inside(surface) == close(3 * throw_of("quarter").volume + ends, rel=5e-4)
    z = surface.points[:, 2]
    np.testing.assert_allclose((z.min(), z.max()), shaft.reach, atol=1e-9)


def test_throws_of_a_shaft_stand_at_their_angles():
    shaft = Crankshaft([throw_of("quarter")] * 2, crank_angles_deg=(0.0, 90.0))
    surface = shaft_surface(shaft, fineness=1)
    points = surface.points[np.unique(surface.triangles)]
    first, second = (points[points[:, 2] < shaft.starts[1]], points[points[:, 2] > shaft.starts[1]])
    assert first[:, 1].max() == close(0.3125, rel=1e-3)
    assert second[:, 0].min() == close(-0.3125, rel=1e-3)  # +90 deg about z turns +y to -x


def test_throws_of_a_shaft_have_no_faces_between_them():
    shaft = shaft_of("quarter")
    surface = shaft_surface(shaft, fineness=1)
    places = surface.points[surface.triangles[surface.kinds == ENDS], 2]
    assert sorted(set(places.ravel().round(9))) == close([0.0, shaft.starts[-1]])


def test_bores_that_end_in_a_journal_keep_the_face_that_closes_them():
    narrow = throw_of("quarter").changed(main_journal_bore=0.04)
    shaft = Crankshaft([throw_of("quarter"), narrow, narrow], crank_angles_deg=[0.0, 120.0, 240.0])
    surface = shaft_surface(shaft, fineness=3)
    places = surface.points[surface.triangles[surface.kinds == ENDS], 2]
    assert sorted(set(places.ravel().round(9))) == close([0.0, *shaft.starts[[1, -1]]])
    expected = sum(throw.volume for throw in shaft.throws)
    assert volume_inside(surface) == close(expected, rel=5e-4)


# ------------------------------------------------------------------------------------- pictures


@pytest.fixture(scope="module")
def opengl(tmp_path_factory):
    """Skip where nothing can be rendered off-screen, whatever is rendered."""
    picture = tmp_path_factory.mktemp("opengl") / "sphere.png"
    program = (
        "import sys, pyvista; plotter = pyvista.Plotter(off_screen=True, window_size=(80, 60)); "
        "plotter.add_mesh(pyvista.Sphere()); plotter.screenshot(sys.argv[1])"
    )
    subprocess.run([sys.executable, "-c", program, picture], capture_output=True, check=False)
    if not picture.is_file():
        pytest.skip("there is no OpenGL library to render with")


def check_picture(path, pixels):
    assert path.read_bytes().startswith(b"\x89PNG")
    seen = imread(path)[:, :, :3].mean(axis=2)
    height, width = seen.shape
    assert max(height, width) == pixels
    assert min(height, width) > 0.2 * pixels
    white, dark = seen > 0.99, seen < 0.35
    assert 0.1 < np.mean(white) < 0.8  # the paper
    assert 0.001 < np.mean(dark) < 0.2  # lines and shadows
    assert np.mean(~white & ~dark) > 0.15  # steel
    border = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
    assert border.min() > 0.99
    # Nothing but a narrow margin is left round the solid.
    inked = ~white
    for side in (inked.any(axis=0), inked.any(axis=1)):
        margins = (np.flatnonzero(side)[0], len(side) - 1 - np.flatnonzero(side)[-1])
        assert max(margins) < 0.03 * pixels


class RenderedHere:
    """What the process that renders does, in this one, which is soon ready for it."""

    def __init__(self, _function, folder, *arguments):
        render(*arguments, folder)

    def wait(self):
        pass


@pytest.fixture
def rendered_here(opengl, monkeypatch):
    monkeypatch.setattr(solid_picture, "OffscreenProcess", RenderedHere)


@pytest.mark.further
def test_picture_of_a_throw(rendered_here, tmp_path):
    path = tmp_path / "throw.png"
    assert picture_throw(throw_of("full"), path) == path
    check_picture(path, 1200)


@pytest.mark.further
def test_picture_of_a_shaft(rendered_here, tmp_path):
    path = tmp_path / "shaft.PNG"
    assert picture_shaft(shaft_of("half"), str(path)) == path
    check_picture(path, 2400)
    height, width = imread(path).shape[:2]
    assert width > 1.5 * height


@pytest.mark.further
def test_pictures_from_the_command_line(opengl, call, tmp_path):
    """Rendered as always, in processes of their own."""
    answer = call("draw", "vw-tdi", "--picture", "throw.png", "--shaft", "shaft.png", "--json")
    assert answer.code == 0, answer.err
    files = ["vw-tdi-throw.svg", "throw.png", "shaft.png"]
    assert answer.json()["files"] == files
    assert {path.name for path in tmp_path.glob("[!.]*")} == set(files)
    check_picture(tmp_path / "throw.png", 1200)
    check_picture(tmp_path / "shaft.png", 2400)


class Pretended:
    """A rendering that writes something at once."""

    def __init__(self, _function, folder, *_):
        (folder / PICTURE).write_bytes(b"picture")

    def wait(self):
        pass


def test_picture_into_a_folder_that_is_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr(solid_picture, "OffscreenProcess", Pretended)
    path = tmp_path / "nowhere" / "throw.png"
    with pytest.raises(InputError, match=r"throw\.png: "):
        picture_throw(throw_of("quarter"), path)


@pytest.mark.parametrize("picture", [picture_throw, picture_shaft])
def test_picture_with_another_ending(tmp_path, picture):
    with pytest.raises(InputError, match=r"^throw\.jpg: "):
        picture(None, tmp_path / "throw.jpg")
