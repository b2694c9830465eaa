import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from fem.analysis import analyze_throw
from fem.angle_law import AngleLaw, angle_law, is_symmetric
from fem.shaft import shaft_compliances
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Web

THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
    fillet_radius=0.012,
)


QUANTITIES = {"axial": "axial_compliance", "influence": "influence_coefficient"}


@pytest.fixture(scope="module")
def bending():
    return analyze_throw(THROW, accuracy=0.1)


@pytest.fixture(scope="module")
def analysis(bending):
    return bending.with_sections("rigid")


@pytest.mark.parametrize("gamma", [1.0, 30.0, 60.0, 90.0, 120.0, 144.0, 179.0, -120.0, 240.0])
def test_the_law_is_that_of_the_assembled_chain(analysis, gamma):
    law, chain = analysis.angle_law, analysis.supported(Neighbors(gamma, gamma))
    # Exact where sections are rigid.
    assert law.axial(gamma) == close(chain.axial, rel=1e-8)
    assert law.influence(gamma) == close(chain.influence, rel=1e-8)


def test_sections_that_bend_leave_the_law_a_little(analysis, bending):
    angles = np.arange(0.0, 181.0, 15.0)
    law = bending.angle_law
    for name in ("axial", "influence"):
        beside = getattr(law, name)(angles) / bending.over_angle(QUANTITIES[name], angles) - 1.0
        assert beside[[0, -1]] == close([0.0, 0.0], abs=1e-9)
        assert 5e-4 < np.abs(beside).max() < 4e-3
    assert law.axial(90.0) == close(bending.axial_compliance(Neighbors(90.0, 90.0)), rel=1e-9)
    # They are softer by up to 2 %, and tilt in nearly the same proportion.
    for name in ("in_line", "opposite"):
        assert 0.003 < getattr(law, name) / getattr(analysis.angle_law, name) - 1.0 < 0.02
    assert law.ratio == close(analysis.angle_law.ratio, rel=0.01)


@pytest.mark.parametrize("gamma", [60.0, 90.0, 120.0])
def test_the_law_holds_in_the_middle_of_a_long_shaft(analysis, gamma):
    count = 15
    shaft = shaft_compliances(
        [analysis.superelement] * count, crank_angles_deg=gamma * np.arange(count)
    )
    # What the shaft's free ends change dies out by about a factor of three from throw to throw.
    assert shaft.axial[count // 2] == close(float(analysis.angle_law.axial(gamma)), rel=1e-3)


def test_the_ratio_is_that_of_the_tilt_stiffnesses(analysis):
    stiffness = analysis.stiffness

    def condensed(mode, other):
        motions = np.zeros((12, 2))
        for column, unknowns in enumerate((mode, other)):
            for place, value in unknowns.items():
                motions[place, column] = value
        small = motions.T @ stiffness @ motions
        return small[0, 0] - small[0, 1] ** 2 / small[1, 1]

    in_plane = condensed({3: 1.0, 9: -1.0}, {8: 1.0})  # tilts about x, lengthening free
    across = condensed({4: 1.0, 10: 1.0}, {11: 1.0})  # tilts about y, twist free
    assert analysis.angle_law.ratio == close(across / in_plane, rel=1e-8)


numbers = st.floats(0.1, 10.0)


@given(numbers, numbers, numbers, st.floats(-720.0, 720.0))
def test_the_law_stays_between_its_ends_and_folds(low, more, ratio, gamma):
    law = AngleLaw(low, low + more, ratio, low, low + more)
    assert low * (1 - 1e-12) <= law.axial(gamma) <= (low + more) * (1 + 1e-12)
    assert law.axial(gamma) == close(law.axial(360.0 - gamma), rel=1e-9)
    assert law.axial(0.0) == low
    assert law.axial(180.0) == close(low + more, rel=1e-12)


def test_a_ratio_of_one_is_linear_in_the_cosine():
    law = AngleLaw(1.0, 3.0, 1.0, 1.0, 3.0)
    gammas = np.linspace(0.0, 180.0, 7)
    assert law.axial(gammas) == close(2.0 - np.cos(np.deg2rad(gammas)))


def test_throws_without_symmetry_are_refused():
    unequal = THROW.model_copy(update={"right_web": Web(thickness=0.080)})
    found = analyze_throw(unequal, accuracy=0.1)
    assert not is_symmetric(found.superelement)
    with pytest.raises(InputError, match="equal webs only"):
        angle_law(found.superelement)


@pytest.mark.parametrize(
    "gamma", [float("nan"), float("inf"), "x", "120", True, None, ["x"], [[1.0], [1.0, 2.0]]]
)
def test_angles_must_be_numbers(analysis, gamma):
    with pytest.raises(InputError, match=r"^gamma_deg: given"):
        analysis.angle_law.axial(gamma)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("ratio", value) for value in (0.0, -1.0, math.nan, math.inf)),
        *(("in_line", value) for value in (0.0, -1e-9, math.nan)),
        ("opposite", math.inf),
        ("influence_in_line", math.nan),
        ("influence_opposite", -math.inf),
    ],
)
def test_numbers_of_no_throw_are_refused(name, value):
    law = AngleLaw(1e-9, 2e-9, 1.5, -1e-10, 0.0)  # the influence has a sign
    with pytest.raises(InputError, match=f"^{name}: given .*; allowed is a finite number"):
        replace(law, **{name: value})
