"""The features of a throw: what they weigh, what is refused, and that they are where they should be."""

import math
from functools import cache

import numpy as np
import pytest

from comparing import close
from condensed_parts import mass_of_elements
from geometry.gmsh_session import gmsh_session
from geometry.mass import mass_properties
from geometry.mesh import check_solid, mesh_throw, solid_properties
from geometry.solid import OIL_HOLE, build_solid, on_drilling
from geometry.throw import CrankThrow
from geometry.throw_checks import FIRST_EIGHT, fits_plainly
from geometry.throw_dimensions import Counterweight, FurtherPin, OilHole, ThrowDimensions, Web
from refusals import refused

HOLE = {"part": "pin", "diameter": 0.02}


@pytest.fixture(scope="module")
def build(dimensions):
    return lambda **changes: CrankThrow(**{**dimensions, **changes})


# Every feature alone, and some together: bores of two kinds with slopes, counterweights that stand out.
FEATURES = {
    "bores": {"main_journal_bore": 0.09, "pin_bore": 0.08},
    "eccentric bores": {
        "main_journal_bore": 0.06,
        "main_journal_bore_offset": -0.02,
        "pin_bore": 0.08,
        "pin_bore_offset": 0.02,
    },
    "separate fillets": {"main_journal_fillet_radius": 0.0, "pin_fillet_radius": 0.02},
    "narrow pin end": {"web_journal_end": 0.15, "web_pin_end": 0.12},
    "straight sides": {"web_journal_end": 0.2, "web_pin_end": 0.18},
    "rounded rectangle": {"web_outline": "rectangle", "web_corner_radius": 0.05},
    "chamfered rectangle": {"web_outline": "rectangle", "web_corner_chamfer": 0.04},
    "thin tip": {"web_tip_thickness": 0.045},
    "rectangle with a thin tip": {"web_outline": "rectangle", "web_tip_thickness": 0.048},
    "thin foot and bore": {"web_foot_thickness": 0.045, "main_journal_bore": 0.09},
    "counterweights": {"counterweight": Counterweight(outer_radius=0.25, angle=2.0)},
    "half-disc counterweights": {"counterweight": Counterweight(outer_radius=0.2, angle=math.pi)},
    "thick counterweights off the bearing": {
        "counterweight": Counterweight(
            outer_radius=0.25, inner_radius=0.13, angle=2.5, thickness=0.09, offset=-0.005
        )
    },
    "counterweight beside a thin foot": {
        "web_foot_thickness": 0.045,
        "main_journal_bore": 0.09,
        "counterweight": Counterweight(outer_radius=0.25, angle=1.6),
    },
    "unequal webs": {"right_web": Web(thickness=0.09, width=0.33)},
    "one counterweight": {
        "left_web": Web(counterweight=Counterweight(outer_radius=0.25, angle=2.0))
    },
    "two pins": {"further_pins": (FurtherPin(angle=math.pi),), "pin_bore": 0.06},
    "three pins": {
        "further_pins": (
            FurtherPin(angle=2.0 * math.pi / 3.0),
            FurtherPin(angle=4.0 * math.pi / 3.0, length=0.10, web_thickness=0.08),
        )
    },
    "split pin": {"further_pins": (FurtherPin(angle=math.radians(30.0), web_thickness=0.0),)},
    "split pin with web": {
        "further_pins": (FurtherPin(angle=math.radians(30.0), web_thickness=0.02),)
    },
    "oil hole across": {"oil_holes": (OilHole(part="pin", diameter=0.03, angle=0.5 * math.pi),)},
    "rounded oil holes into bores": {
        "pin_bore": 0.07,
        "main_journal_bore": 0.08,
        "oil_holes": tuple(
            OilHole(part=part, diameter=0.02, position=z, exit_radius=0.004, through=False)
            for part, z in (
                ("pin", 0.0),
                ("left main journal", 0.02),
                ("right main journal", -0.02),
            )
        ),
    },
    "tilted oil hole": {
        "oil_holes": (OilHole(part="pin", diameter=0.02, tilt=0.4, exit_radius=0.006),)
    },
    "oil hole askew": {
        "oil_holes": (
            OilHole(part="pin", diameter=0.02, angle=-0.8, tilt=-0.2, position=0.02, through=False),
        )
    },
}
SYMMETRY = {
    "unequal webs": "half",
    "one counterweight": "half",
    "two pins": "half",
    "three pins": "full",
    "split pin": "full",
    "split pin with web": "full",
    "tilted oil hole": "half",
    "oil hole askew": "full",
}
PARTS = {"quarter": 4.0, "half": 2.0, "full": 1.0}


# Meshes of the same throws serve several tests.
meshed = cache(mesh_throw)


@pytest.mark.slow
@pytest.mark.parametrize("feature", FEATURES)
def test_the_solid_and_the_mesh_are_what_is_described(build, feature):
    throw = build(**FEATURES[feature])
    assert throw.symmetry == SYMMETRY.get(feature, "quarter")
    mesh = meshed(throw, 3.0)
    assert mesh.part == throw.symmetry
    assert PARTS[mesh.part] * mesh.solid.volume == close(throw.volume, rel=1e-6)
    solid, elements = mass_properties(mesh, 7850.0), mass_of_elements(mesh, 7850.0)
    assert elements.mass == close(solid.mass, rel=1e-3)
    assert elements.center == close(solid.center, rel=1e-3, abs=1e-3 * throw.crank_radius)
    scale = float(np.abs(solid.inertia).max())
    assert elements.inertia == close(solid.inertia, abs=1e-3 * scale)
    assert set(mesh.pins) <= mesh.surfaces.keys()
    for name in mesh.pins:
        assert len(mesh.surfaces[name])


@pytest.mark.slow
def test_oil_holes_are_cut_alike_out_of_quarter_half_and_full(build):
    parts = build(**FEATURES["rounded oil holes into bores"]).parts
    areas = []
    for part, copies in PARTS.items():
        with gmsh_session("throw") as gmsh:
            surfaces = build_solid(gmsh, parts, part)
            check_solid(parts, part, solid_properties(gmsh))
            found = [gmsh.model.occ.getMass(2, tag) for tag in surfaces[OIL_HOLE]]
        areas.append(copies * sum(found))
    assert areas == close([areas[0]] * 3, rel=1e-3)
    # Walls and roundings, which are somewhat larger than the walls would be without them.
    walls = sum(2.0 * hole.volume / hole.radius for hole in parts.drillings)
    assert 1.0 < areas[0] / walls < 1.4


@pytest.mark.parametrize(("share", "belongs"), [(0.5, True), (3.0, False)])
def test_a_rounding_belongs_to_the_oil_hole_if_it_is_at_its_exit(build, share, belongs):
    parts = build(**FEATURES["tilted oil hole"]).parts
    hole = parts.drillings[0]
    beside = np.array([hole.radius + share * hole.exit_radius, 0.0])
    along = hole.exits[0].surface(*beside[:, None])
    point = hole.middle + np.append(beside, along) @ hole.frame
    assert on_drilling(None, parts, "BSpline surface", 0, point) == belongs


def test_a_part_that_the_symmetry_does_not_allow_is_refused(build):
    throw = build(**FEATURES["unequal webs"])
    with refused("part"):
        mesh_throw(throw, 2.0, "quarter")
    with refused("part"):
        mesh_throw(throw, 2.0, "eighth")


@pytest.mark.slow
@pytest.mark.parametrize("feature", FEATURES)
def test_described_from_the_other_end_it_is_the_same_part(build, feature):
    """Half a turn about y takes one to the other; a throw symmetric about x is thereby mirrored."""
    throw = build(**FEATURES[feature])
    other = throw.reversed()
    assert other.volume == close(throw.volume, rel=1e-9)
    assert other.length == close(throw.length, rel=1e-12)
    first, second = (mass_properties(meshed(t, 3.0), 1.0) for t in (throw, other))
    # The new first pin stands at +y: turn the old last one there.
    last = throw.further_pins[-1].angle if throw.further_pins else 0.0
    turned = first.moved(angle_deg=np.degrees(-last), along=0.0)
    swap = np.diag([-1.0, 1.0, -1.0])
    center = swap @ turned.center + np.array([0.0, 0.0, throw.length])
    scale = float(np.abs(first.inertia).max())
    assert second.center == close(center, abs=1e-6 * throw.length)
    assert second.inertia == close(swap @ turned.inertia @ swap, abs=1e-6 * scale)


def test_counterweights_add_their_sector(build):
    radius, angle = 0.25, math.pi
    throw = build(counterweight=Counterweight(outer_radius=radius, angle=angle))
    foot = build().web_width / 2.0
    added = 2.0 * throw.web_thickness * angle / 2.0 * (radius**2 - foot**2)
    assert throw.volume - build().volume == close(added, rel=1e-9)


def test_the_order_of_fields_makes_no_difference(dimensions):
    forward = CrankThrow(**dimensions, pin_bore=0.06)
    backward = CrankThrow(**dict(reversed([*dimensions.items(), ("pin_bore", 0.06)])))
    assert forward == backward
    assert np.array_equal(mesh_throw(forward, 2.0).points, mesh_throw(backward, 2.0).points)


def holes(*changes, **more):
    return {"oil_holes": [HOLE | change for change in changes or ({},)]} | more


def weight(outer_radius, angle, **more):
    return {"counterweight": Counterweight(outer_radius=outer_radius, angle=angle, **more)}


EXIT = {"exit_radius": 0.005}
# What is refused: the change, the field, and numbers of what is allowed.
REFUSED = [
    ({"pin_bore": 0.17}, "pin_bore", "0, or 9 mm to 162 mm"),
    ({"main_journal_bore": 0.004}, "main_journal_bore"),
    ({"pin_bore": 0.12, "pin_bore_offset": 0.04}, "pin_bore", "82 mm", "40 mm"),
    ({"pin_bore_offset": 0.01}, "pin_bore_offset"),
    (holes({"part": "web"}), "oil_holes[0].part"),
    (holes({"diameter": 0.2}), "oil_holes[0].diameter", "3.6 mm to 72 mm"),
    (holes({"exit_radius": 0.0005}), "oil_holes[0].exit_radius", "0, or 1 mm to 20 mm"),
    (holes({"position": 0.06}), "oil_holes[0].position", "-45.7 mm to 45.7 mm"),
    (holes({}, {"part": "left main journal"}), "oil_holes[1].position"),
    (holes({"diameter": 0.06, "tilt": 0.6}), "oil_holes[0].diameter", "111.4 mm"),
    (holes({}, {"angle": 1.0}), "oil_holes[1]", "oil_holes[0]", "2 mm"),
    (holes(EXIT, EXIT | {"position": 0.03}), "oil_holes[1]", "oil_holes[0]"),
    (holes({"diameter": 0.06}, pin_bore=0.06), "oil_holes[0].diameter", "57 mm"),
    (
        holes({"angle": 0.5 * math.pi}, pin_bore=0.06, pin_bore_offset=0.035),
        *("oil_holes[0].angle", "90 deg", "35 mm"),
    ),
    (holes({"exit_radius": 0.018}, pin_bore=0.15), "oil_holes[0].exit_radius", "2 mm"),
    ({"main_journal_bore": 0.18, "pin_bore": 0.15}, "pin_bore", "5 mm"),
    ({"web_corner_radius": 0.01}, "web_corner_radius"),
    (
        {"web_outline": "rectangle", "web_corner_chamfer": 0.13, "web_pin_end": 0.11},
        "fillet_radius",
    ),
    ({"web_pin_end": 0.08}, "pin_diameter"),
    ({"web_journal_end": 0.14, "web_pin_end": 0.14}, "web_journal_end", "150 mm or more"),
    ({"web_tip_thickness": 0.07}, "web_tip_thickness", "20.4 mm to 68 mm"),
    (
        {"crank_radius": 0.02, "main_journal_diameter": 0.276, "web_tip_thickness": 0.05},
        *("web_tip_thickness", "68 mm"),
    ),
    (weight(0.15, 2.0), "counterweight.outer_radius", "153 mm or more"),
    (weight(0.25, 2.0, inner_radius=0.14), "counterweight.inner_radius", "0 to 135 mm"),
    (weight(0.25, 2.0, thickness=0.09), "counterweight.inner_radius"),
    (weight(0.25, 2.0, inner_radius=0.13, thickness=0.25), "counterweight.thickness"),
    (weight(0.25, 2.0, thickness=0.02, offset=0.06), "counterweight.offset"),
    (weight(0.25, 2.0, thickness=0.0675), "counterweight.thickness"),
    ({"further_pins": (FurtherPin(angle=2.0, web_thickness=0.0),)}, "further_pins"),
    ({"left_web": Web(thickness=0.005)}, "left_web.thickness"),
    ({"web_width": 0.264001, "fillet_radius": 0.022, "pin_diameter": 0.18}, "fillet_radius"),
    ({"web_outline": "rectangle", "web_corner_radius": 1e-5}, "web_corner_radius", "3 mm"),
    ({"right_web": Web(pin_end=0.150001)}, "right_web.pin_end", "150 mm", "0.3 mm"),
    ({"further_pins": (FurtherPin(angle=1e-7),)}, "further_pins", "0.9 mm or more"),
    ({"further_pins": (FurtherPin(angle=2.0, diameter=0.35),)}, "further_pins[0].diameter"),
]


@pytest.mark.parametrize("row", REFUSED)
def test_what_cannot_be_built_is_refused_with_its_reason(build, row):
    changes, field, *numbers = row
    with refused(f"throw.{field}") as caught:
        build(**changes)
    assert all(number in str(caught.value) for number in numbers)


def test_a_bore_that_comes_out_in_the_other_fillet_is_remarked(build):
    assert build(pin_bore=0.05, pin_bore_offset=0.02).remarks == ()
    # The pin's collar reaches to 170 - 90 - 12 = 68 mm from the shaft axis.
    assert build(main_journal_bore=0.130).remarks == ()
    assert len(build(main_journal_bore=0.140).remarks) == 2


def test_other_dimensions_are_left_to_the_whole_check():
    values = dict.fromkeys(FIRST_EIGHT, 0.1) | {"web_width": 0.15, "fillet_radius": 0.01}
    assert fits_plainly(ThrowDimensions(**values))
    assert not fits_plainly(ThrowDimensions(**values, pin_bore_offset=0.02))
