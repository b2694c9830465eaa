"""Slopes over the dimensions of a throw.

Source: differences between throws 2 to 6 % apart, each with its own meshes (R 170, D 220/180, L 120/139, B
300, h 68 mm): -0.4569 to -0.4578; volume of cylinders and prisms for an 8ChN 13/14's mass.

Tolerance: the error stated for each slope, at most 0.01; mass 0.001, as facets leave out so much volume.

Slopes of the axial compliance over the diameter of the main journal, with fillets of 12 mm; of the mass of
the first throw of an 8ChN 13/14 with both counterweights of 122 mm over their radii.
"""

import numpy as np
import pytest

import crankfem as cf
from geometry.boundary_motion import with_length
from parts_in_a_line import crank_throw

REMESHED = -0.457


@pytest.mark.slow
def test_axial_compliance_over_the_main_journal(figure):
    throw = crank_throw(0.170, 0.220, 0.180, 0.120, 0.139, 0.300, 0.068, fillet_radius=0.012)
    slopes = cf.analyze_throw(throw).sensitivities()
    assert slopes.error < 0.01
    share = slopes["main_journal_diameter"]
    figure(
        "e_n over the main journal's diameter", share, REMESHED, slopes.error, "1", kind="absolute"
    )


@pytest.mark.slow
def test_mass_over_counterweights_of_equal_radius(figure):
    """Whose surfaces are on one cylinder."""
    throw, _ = cf.load_throw("8chn13-14")
    left, right = (f"{side}_web.counterweight.outer_radius" for side in ("left", "right"))
    throw = with_length(throw, right, 0.122)
    shares = cf.analyze_throw(throw, accuracy=0.05).sensitivities("mass").shares
    expected = []
    for path in (left, right):
        low, high = (with_length(throw, path, 0.122 * factor).volume for factor in (0.999, 1.001))
        expected.append(np.log(high / low) / 0.002)
    assert np.round(expected, 3).tolist() == [0.348, 0.232]
    found = shares[left], shares[right]
    figure("mass over equal radii of counterweights", found, expected, 1e-3, "1", kind="absolute")
