import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from geometry.crankshaft import Crankshaft, ShaftEnds, make_shaft, throw_masses
from geometry.gmsh_session import gmsh_session
from geometry.mass import unbalance
from geometry.mesh import solid_properties
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight, FurtherPin, Web

DENSITY = 7850.0
ENDS = ShaftEnds(
    free_end_diameter=0.2, free_end_length=0.3, flange_diameter=0.4, flange_thickness=0.05
)
SIX = np.deg2rad([0.0, 120.0, 240.0, 240.0, 120.0, 0.0])


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"counterweight": Counterweight(outer_radius=0.25, angle=2.0), "pin_bore": 0.06},
        {"right_web": Web(thickness=0.08)},
        {"further_pins": (FurtherPin(angle=0.5, web_thickness=0.0),)},
    ],
)
def test_the_whole_solid_weighs_what_its_throws_weigh(dimensions, changes):
    shaft = Crankshaft(
        [CrankThrow(**dimensions, **changes)] * 6, crank_angles_deg=np.degrees(SIX), ends=ENDS
    )
    expected = shaft.masses(DENSITY)
    with gmsh_session("shaft") as gmsh:
        make_shaft(gmsh, shaft)
        solid = solid_properties(gmsh)
    assert DENSITY * solid.volume == close(expected.mass, rel=1e-6)
    assert solid.center == close(expected.center, abs=1e-6)
    moments = DENSITY * solid.second_moments
    inertia = np.trace(moments) * np.eye(3) - moments
    assert inertia == close(expected.inertia, abs=1e-6 * expected.inertia.max())


def test_six_in_line_is_balanced_and_three_is_not(dimensions):
    throw = CrankThrow(**dimensions)
    six = Crankshaft([throw] * 6, crank_angles_deg=np.degrees(SIX)).unbalance(DENSITY)
    size = throw_masses(throw, DENSITY).mass * throw.crank_radius
    assert six.static == close([0.0, 0.0], abs=1e-9 * size)
    assert six.dynamic == close([0.0, 0.0], abs=1e-9 * size * throw.length)
    three = Crankshaft([throw] * 3, crank_angles_deg=np.degrees(SIX[:3])).unbalance(DENSITY)
    assert three.static == close([0.0, 0.0], abs=1e-9 * size)
    # Forces of size U at -L, 0 and L, 120 deg apart: a moment of sqrt(3) U L remains.
    one = unbalance(throw_masses(throw, DENSITY), throw.length / 2.0)
    expected = np.sqrt(3.0) * np.linalg.norm(one.static) * throw.length
    assert np.linalg.norm(three.dynamic) == close(expected, rel=1e-9)


def test_unbalance_of_one_throw(dimensions):
    throw = CrankThrow(**dimensions)
    masses = throw_masses(throw, DENSITY)
    found = unbalance(masses, throw.length / 2.0)
    assert found.static == close([0.0, masses.mass * masses.center[1]], abs=1e-12)
    assert found.dynamic == close([0.0, 0.0], abs=1e-12)
    moved = unbalance(masses, 0.0)
    assert moved.dynamic == close(found.static * throw.length / 2.0, abs=1e-12)
    lopsided = CrankThrow(**dimensions, right_web=Web(thickness=0.09))
    other = unbalance(throw_masses(lopsided, DENSITY), lopsided.length / 2.0)
    assert other.dynamic[1] > 0.0


def test_counterweights_take_the_unbalance_away(dimensions):
    plain = unbalance(throw_masses(CrankThrow(**dimensions), DENSITY), 0.0).static[1]
    weight = Counterweight(outer_radius=0.25, angle=np.pi)
    heavy = CrankThrow(**dimensions, counterweight=weight)
    left = plain - unbalance(throw_masses(heavy, DENSITY), 0.0).static[1]
    # First moment of a half ring between the web's end and the outer radius.
    foot = heavy.web_width / 2.0
    expected = DENSITY * 2.0 * heavy.web_thickness * 2.0 / 3.0 * (0.25**3 - foot**3)
    assert left == close(expected, rel=1e-9)


def test_what_does_not_fit_together_is_refused(dimensions):
    throw = CrankThrow(**dimensions)
    with pytest.raises(InputError, match="given 2 for 3 throws"):
        Crankshaft([throw] * 3, crank_angles_deg=[0.0, 60.0])
    other = CrankThrow(**{**dimensions, "main_journal_diameter": 0.2})
    with pytest.raises(InputError, match="share a main journal"):
        Crankshaft([throw, other], crank_angles_deg=[0.0, 60.0])
    off = CrankThrow(**dimensions, main_journal_bore=0.06, main_journal_bore_offset=0.02)
    assert Crankshaft([off] * 2, crank_angles_deg=[0.0, 0.0]).length == close(2.0 * off.length)
    with pytest.raises(InputError, match=r"throws 1 and 2 are 40 mm apart"):
        Crankshaft([off] * 2, crank_angles_deg=[0.0, 180.0])
    with pytest.raises(InputError, match="finite"):
        Crankshaft([throw], crank_angles_deg=[float("nan")])
    with pytest.raises(InputError, match="flange_thickness: missing"):
        ShaftEnds(flange_diameter=0.4)
