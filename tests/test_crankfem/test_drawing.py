import io
import math
import warnings
from functools import cache
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.throw.pictures import solid_picture
from crankfem.analyses.throw.pictures.drawing import draw_throw, write_drawing
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import data_folder
from geometry.throw import CrankThrow
from throws import MEDIUM_SPEED

DIMENSIONS = dict(MEDIUM_SPEED)
TWO_STROKE = {
    "crank_radius": 1.1,
    "main_journal_diameter": 0.75,
    "pin_diameter": 0.75,
    "main_journal_length": 0.4,
    "pin_length": 0.4,
    "web_width": 1.3,
    "web_thickness": 0.38,
    "fillet_radius": 0.03,
    "web_outline": "rectangle",
    "web_corner_radius": 0.12,
    "web_journal_end": 0.6,
    "web_pin_end": 0.61,
    "pin_bore": 0.35,
}
SMALL = {
    "crank_radius": 0.05,
    "main_journal_diameter": 0.06,
    "pin_diameter": 0.05,
    "main_journal_length": 0.025,
    "pin_length": 0.026,
    "web_width": 0.078,
    "web_thickness": 0.018,
    "fillet_radius": 0.003,
    "main_journal_fillet_radius": 0.0025,
}
PLAIN = "R 170; B 285; L_km/2 60; h 68; L_shm 139; 395; 142.5; D_km ⌀220; D_shm ⌀180; "
# What differs from the first throw (or a whole throw), and the texts that its drawing must have.
THROWS = {
    "plain": ({}, PLAIN + "r 12; overlap 30 mm; volume 23.44 dm³"),
    "sharp": ({"fillet_radius": 0.0}, PLAIN + "volume 23.36 dm³"),
    "bores, weights, slopes": (
        {
            "main_journal_bore": 0.08,
            "main_journal_bore_offset": -0.01,
            "pin_bore": 0.07,
            "pin_bore_offset": 0.012,
            "counterweight": {"outer_radius": 0.25, "angle": 2.0},
            "web_tip_thickness": 0.045,
            "web_foot_thickness": 0.05,
        },
        PLAIN + "d_km ⌀80; offset −10; d_shm ⌀70; offset 12; r_cw 250; 114.6°; 45; 50; r 12",
    ),
    "thick weights": (
        {
            "main_journal_length": 0.16,
            "counterweight": {
                "outer_radius": 0.27,
                "angle": 2.2,
                "inner_radius": 0.128,
                "thickness": 0.09,
                "offset": -0.005,
            },
        },
        "r_cw 270; inner r 128; 126.1°; 90",
    ),
    "different weights": (
        {
            "left_web": {"counterweight": {"outer_radius": 0.25, "angle": 2.0}},
            "right_web": {"counterweight": {"outer_radius": 0.28, "angle": 1.5}},
        },
        "r_cw 250 left web; r_cw 280 right web; 114.6° left web; 85.9° right web",
    ),
    "rectangles, unequal": (
        {
            "web_outline": "rectangle",
            "web_corner_chamfer": 0.04,
            "web_pin_end": 0.12,
            "right_web": {"thickness": 0.09, "width": 0.32, "pin_end": 0.13},
        },
        "40 × 45°; h 68; h 90; B 285 left web; B 320 right web; "
        "120 left web; 130 right web; 142.5 left web; 160 right web",
    ),
    "two pins": ({"further_pins": [{"angle": math.pi}]}, "pin 1; pin 2, 180°; 602"),
    "two pins, different": (
        {
            "pin_bore": 0.05,
            "counterweight": {"outer_radius": 0.25, "angle": 2.0},
            "further_pins": [
                {
                    "angle": math.radians(120.0),
                    "crank_radius": 0.15,
                    "diameter": 0.17,
                    "web_width": 0.3,
                    "bore": 0.06,
                }
            ],
        },
        "120°; pin 2, R 150; D_shm ⌀180 pin 1; D_shm ⌀170 pin 2; B 300 web 2; "
        "d_shm ⌀50 pin 1; d_shm ⌀60 pin 2; B 285 left web, right web",
    ),
    "three pins": (
        {"further_pins": [{"angle": 2.0}, {"angle": -2.0, "length": 0.12}]},
        "114.6°; pin 3; L_shm 139; L_shm 120",
    ),
    "split pin": (
        {"further_pins": [{"angle": math.radians(30.0), "web_thickness": 0.0}]},
        "30°; pin 1; pin 2; 534",
    ),
    "split pin with a web": (
        {
            "pin_length": 0.08,
            "further_pins": [{"angle": math.radians(30.0), "web_thickness": 0.02}],
        },
        "30°; h 68; h 20; L_shm 80",
    ),
    "narrow pin end": (
        {"web_pin_end": 0.11, "web_journal_end": 0.1425},
        "B 285; r 110; 110; 142.5",
    ),
    "wide ends": ({"web_pin_end": 0.16, "web_journal_end": 0.17}, "r 160; r 170; 160"),
    "two-stroke": (
        TWO_STROKE,
        "R 1100; B 1300; h 380; r 120; r 30; D_km ⌀750; d_shm ⌀350; 600; 610; no overlap",
    ),
    "small": (SMALL, "R 50; L_km/2 12.5; r_km 2.5; r_shm 3; h 18"),
}
ENGINES = sorted(path.stem for path in (data_folder() / "engines").glob("*.toml"))
DRAWN = [*THROWS, *(pytest.param(name, marks=pytest.mark.slow) for name in ENGINES)]


def throw_of(name):
    changes = THROWS[name][0]
    return CrankThrow(**({} if "crank_radius" in changes else DIMENSIONS) | changes)


@cache
def drawing_of(name):
    throw = throw_of(name) if name in THROWS else load_throw(name)[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return draw_throw(throw, name)


def texts_of(figure):
    """Return the texts, symbols like $R$ and $D_\\mathrm{km}$ written R and D_km."""
    found = [text.get_text() for axes in figure.axes for text in axes.texts]
    return [text.replace("$", "").replace("\\mathrm{", "").replace("}", "") for text in found]


@pytest.mark.slow
@pytest.mark.parametrize("name", THROWS)
def test_every_dimension_is_written(name):
    lines = [line for text in texts_of(drawing_of(name)) for line in text.split("\n")]
    assert [text for text in THROWS[name][1].split("; ") if text not in lines] == []


@pytest.mark.parametrize("name", DRAWN)
def test_texts_stand_clear_of_each_other_and_on_the_sheet(name):
    figure = drawing_of(name)
    renderer = figure.canvas.get_renderer()
    boxes = [
        (text.get_text(), text.get_window_extent(renderer))
        for axes in figure.axes
        for text in axes.texts
    ]
    meeting = [
        (first, second)
        for (first, a), (second, b) in combinations(boxes, 2)
        if min(a.x1, b.x1) > max(a.x0, b.x0) and min(a.y1, b.y1) > max(a.y0, b.y0)
    ]
    assert meeting == []
    sheet = figure.bbox
    outside = [
        text
        for text, box in boxes
        if box.x0 < sheet.x0 or box.x1 > sheet.x1 or box.y0 < sheet.y0 or box.y1 > sheet.y1
    ]
    assert outside == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain", "bores, weights, slopes", "two pins, different"])
@pytest.mark.parametrize("kind", ["png", "svg"])
def test_files(name, kind):
    written = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a sign that the font lacks is a warning
        drawing_of(name).savefig(written, format=kind)
    content = written.getvalue()
    if kind == "png":
        assert content.startswith(b"\x89PNG")
    else:
        assert ElementTree.fromstring(content).tag.endswith("svg")


def outlines_of(axes):
    """Return all corners of the webs and what else has an outline of its own."""
    return np.vstack([patch.get_xy() for patch in axes.patches if patch.get_linewidth() > 0.0])


def test_views_show_the_throw_at_its_size():
    side, end = drawing_of("plain").axes[:2]
    for axes, low, high in ((side, 0.06, 0.335), (end, -0.1425, 0.1425)):
        corners = outlines_of(axes)
        np.testing.assert_allclose(corners.min(axis=0), (low, -0.1425), atol=1e-9)
        np.testing.assert_allclose(corners.max(axis=0), (high, 0.3125), atol=1e-9)


@pytest.mark.slow
def test_positive_angles_turn_clockwise_seen_from_the_left_end():
    throw = CrankThrow(**DIMENSIONS, further_pins=[{"angle": 0.5 * math.pi}])
    corners = outlines_of(draw_throw(throw).axes[1])
    assert corners[:, 0].max() == close(0.170 + 0.1425)
    assert corners[:, 0].min() == close(-0.1425)


def test_thinned_web_is_as_thick_as_its_dimensions_say():
    corners = outlines_of(drawing_of("bores, weights, slopes").axes[0])
    tips = corners[np.isclose(corners[:, 1], 0.170 + 0.1425), 0]
    # The webs reach from 60 to 128 mm and from 267 to 335 mm, their tips are 45 mm thick.
    assert sorted(set(tips.round(6))) == close([0.083, 0.128, 0.267, 0.312])


@pytest.mark.slow
def test_title_is_taken_literally_and_has_a_default():
    throw = CrankThrow(**DIMENSIONS)
    assert "Crank throw" in texts_of(draw_throw(throw))
    figure = draw_throw(throw, "5 $ and\n6 $")
    figure.savefig(io.BytesIO(), format="png", dpi=30)
    assert any("5 \\ and 6 \\" in text for text in texts_of(figure))


@pytest.mark.slow
def test_user_settings_stay_as_they_are():
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    draw_throw(CrankThrow(**DIMENSIONS))
    assert dict(mpl.rcParams) == before


# ---------------------------------------------------------------------------------------- files

STARTS = {".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF", ".PNG": b"\x89PNG"}


@pytest.mark.parametrize(
    "ending",
    [".svg", ".png", *(pytest.param(one, marks=pytest.mark.slow) for one in (".pdf", ".PNG"))],
)
def test_drawings_are_the_same_bit_for_bit(tmp_path, ending):
    paths = [write_drawing(throw_of("plain"), tmp_path / f"{n}{ending}", "plain") for n in "ab"]
    first, second = (path.read_bytes() for path in paths)
    assert first.startswith(STARTS[ending])
    assert first == second


@pytest.mark.parametrize("name", ["throw.gif", "throw"])
def test_drawing_with_another_ending(tmp_path, name):
    with pytest.raises(InputError, match=rf"^{name}: given the ending .* \.svg, \.png, \.pdf\.$"):
        write_drawing(throw_of("plain"), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_draw_writes_the_drawing_beside_the_user(call, tmp_path):
    answer = call("draw", "vw-tdi")
    assert (answer.code, answer.out) == (0, "vw-tdi-throw.svg written.\n")
    assert ElementTree.parse(tmp_path / "vw-tdi-throw.svg").getroot().tag.endswith("svg")


@pytest.mark.slow
def test_draw_tells_the_files_as_json(call, tmp_path, monkeypatch):
    pictured = {}

    def picture_throw(throw, path):
        pictured["throw"] = throw.crank_radius
        return path

    def picture_shaft(shaft, path):
        pictured["shaft"] = len(shaft.throws)
        return path

    monkeypatch.setattr(solid_picture, "picture_throw", picture_throw)
    monkeypatch.setattr(solid_picture, "picture_shaft", picture_shaft)
    options = ("--output", "a.pdf", "--picture", "b.png", "--shaft", "c.png", "--json")
    answer = call("draw", "6chn25-34", *options)
    assert answer.code == 0
    assert answer.json()["files"] == ["a.pdf", "b.png", "c.png"]
    assert pictured == {"throw": close(0.170), "shaft": 6}
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
