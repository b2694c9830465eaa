"""The published axial formulas against the exact compliance of a throw made of slender beams.

The source is the theory of plane frames: an Euler-Bernoulli frame of journal halves, webs and pin,
clamped nowhere, solved here by its own small stiffness method, which shares nothing with the
formulas. With the journal ends free to tilt (gamma = 180 deg between neighboring cranks) the
throw's compliance is pin + 2/3 web, with them blocked (gamma = 0) it tends to 1/2 pin + 1/6 web as
the webs become flexible.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.throw import CrankThrow
from regression.axial_formulas import AXIAL_FORMULA_NAMES, axial_formula, axial_formulas

E = 2.1e11


def slender_throw(web_thickness=0.05):
    """Return a throw without overlap, whose parts are far longer than thick."""
    return CrankThrow(
        crank_radius=1.2,
        main_journal_diameter=0.20,
        pin_diameter=0.18,
        main_journal_length=1.0,
        pin_length=0.9,
        web_width=0.25,
        web_thickness=web_thickness,
    )


def beam_parts(throw):
    """Return (pin, web, tension) of the beam theory [m/N]."""
    pin_inertia = math.pi * throw.pin_diameter**4 / 64
    web_inertia = throw.web_width * throw.web_thickness**3 / 12
    pin = throw.crank_radius**2 * throw.pin_length / (E * pin_inertia)
    web = throw.crank_radius**3 / (E * web_inertia)
    tension = (
        throw.main_journal_length / (math.pi * throw.main_journal_diameter**2 / 4)
        + throw.pin_length / (math.pi * throw.pin_diameter**2 / 4)
    ) / E
    return pin, web, tension


def frame_compliance(throw, tilt_blocked):
    """Axial compliance of the throw as a plane Euler-Bernoulli frame, by the stiffness method."""
    half, pin, R = throw.main_journal_length / 2, throw.pin_length, throw.crank_radius
    nodes = np.array([(0, 0), (half, 0), (half, R), (half + pin, R), (half + pin, 0)])
    nodes = np.vstack([nodes, (2 * half + pin, 0)])
    journal = (math.pi * throw.main_journal_diameter**2 / 4, throw.main_journal_diameter**4)
    crankpin = (math.pi * throw.pin_diameter**2 / 4, throw.pin_diameter**4)
    web = (throw.web_width * throw.web_thickness, throw.web_width * throw.web_thickness**3 / 12)
    round_inertia = math.pi / 64
    sections = [
        (journal[0], round_inertia * journal[1]),
        web,
        (crankpin[0], round_inertia * crankpin[1]),
        web,
        (journal[0], round_inertia * journal[1]),
    ]
    K = np.zeros((18, 18))
    for first, (area, inertia) in enumerate(sections):
        K_beam = beam_stiffness(nodes[first], nodes[first + 1], area, inertia)
        K[3 * first : 3 * first + 6, 3 * first : 3 * first + 6] += K_beam
    # Unknowns: axial, lateral, tilt of each node. Both ends stay on the axis, the left one fixed.
    held = [0, 1, 16] + ([2, 17] if tilt_blocked else [])
    free = [i for i in range(18) if i not in held]
    load = np.zeros(18)
    load[15] = 1.0
    displacement = np.zeros(18)
    displacement[free] = np.linalg.solve(K[np.ix_(free, free)], load[free])
    return displacement[15]


def beam_stiffness(start, end, area, inertia):
    """Return the stiffness of one beam in the frame's axes, (6, 6)."""
    span = end - start
    L = float(np.hypot(*span))
    c, s = span / L
    a, b = E * area / L, E * inertia / L**3
    local = np.array(
        [
            [a, 0, 0, -a, 0, 0],
            [0, 12 * b, 6 * b * L, 0, -12 * b, 6 * b * L],
            [0, 6 * b * L, 4 * b * L**2, 0, -6 * b * L, 2 * b * L**2],
            [-a, 0, 0, a, 0, 0],
            [0, -12 * b, -6 * b * L, 0, 12 * b, -6 * b * L],
            [0, 6 * b * L, 2 * b * L**2, 0, -6 * b * L, 4 * b * L**2],
        ]
    )
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    both = np.kron(np.eye(2), turn)
    return both.T @ local @ both


def test_free_frame_is_pin_plus_two_thirds_web():
    throw = slender_throw()
    pin, web, tension = beam_parts(throw)
    exact = frame_compliance(throw, tilt_blocked=False)
    assert exact == pytest.approx(pin + 2 / 3 * web + tension, rel=1e-9)


def test_blocked_frame_is_the_closed_form():
    throw = slender_throw()
    pin, web, tension = beam_parts(throw)
    journal_inertia = math.pi * throw.main_journal_diameter**4 / 64
    j = throw.crank_radius**2 * throw.main_journal_length / (2 * E * journal_inertia)
    a = pin / 2
    m = (a + web / 2) / (a + web + j)
    bending = 2 * ((1 - m) ** 2 * a + web * (1 / 3 - m + m**2) + m**2 * j)
    assert 2 * ((1 - m) * a + web / 3 - m * web / 2) == pytest.approx(bending, rel=1e-12)
    exact = frame_compliance(throw, tilt_blocked=True)
    assert exact == pytest.approx(bending + tension, rel=1e-9)


def test_draminsky_1_is_the_exact_frame():
    for thickness in (0.05, 0.08, 0.15):
        throw = slender_throw(thickness)
        _, _, tension = beam_parts(throw)
        exact = frame_compliance(throw, tilt_blocked=False) - tension
        assert axial_formula("Draminsky (1)", throw).value == pytest.approx(exact, rel=1e-9)


def test_dorey_tends_to_the_frame_at_both_ends_of_the_angle():
    throw = slender_throw()
    pin, web, tension = beam_parts(throw)
    opposite = axial_formula("Dorey", throw, 180.0).value
    assert opposite == pytest.approx(pin + 0.667 * web, rel=1e-12)
    exact = frame_compliance(throw, tilt_blocked=False) - tension
    assert opposite == pytest.approx(exact, rel=1e-3)
    parallel = axial_formula("Dorey", throw, 0.0).value
    assert parallel == pytest.approx(0.5 * pin + 0.167 * web, rel=1e-12)
    # Webs so flexible that journals and pin count as rigid.
    exact = frame_compliance(throw, tilt_blocked=True) - tension
    assert parallel == pytest.approx(exact, rel=0.02)


def test_anderson_tends_to_the_frame_at_both_ends_of_the_angle():
    # Anderson's own parts besides the frame's: 1.1 on the pin, k_1 for the thickness of journals.
    throw = slender_throw()
    pin, web, tension = beam_parts(throw)
    free_web = 2 * (throw.crank_radius - 0.19) / (E / 2.6 * throw.web_width * throw.web_thickness)
    k_1 = 1 - 0.125 * 0.38 / 1.2
    for gamma, pin_share, web_share in (
        (180.0, 1.1, k_1**2 * (1 - k_1 / 3)),
        (0.0, 0.55, k_1**2 * (1 / 2 - k_1 / 3)),
    ):
        value = axial_formula("Anderson", throw, gamma).value
        assert value == pytest.approx(
            pin_share * pin + web_share * web + tension + free_web, rel=1e-12
        )
    # As k_1 tends to 1 (journals thin beside the crank radius) the shares are 2/3 and 1/6.
    for gamma, share, blocked in ((180.0, 2 / 3, False), (0.0, 1 / 6, True)):
        thin = CrankThrow(
            crank_radius=2.4,
            main_journal_diameter=0.11,
            pin_diameter=0.11,
            main_journal_length=0.12,
            pin_length=0.12,
            web_width=0.12,
            web_thickness=0.1,
        )
        pin, web, tension = beam_parts(thin)
        web_part = axial_formula("Anderson", thin, gamma).value
        web_part -= (1.1 if gamma else 0.55) * pin + tension
        web_part -= 2 * (2.4 - 0.11) / (E / 2.6 * 0.012)
        assert web_part == pytest.approx(share * web, rel=0.03)
        exact = frame_compliance(thin, tilt_blocked=blocked)
        assert axial_formula("Anderson", thin, gamma).value == pytest.approx(exact, rel=0.15)


def test_gorbunov_web_is_the_exact_web_at_half_the_printed_factor():
    # With 0.5 (1 - cos gamma) and no overlap: 8 R^3 / (E B h^3) = 2/3 web.
    throw = slender_throw()
    pin, web, _ = beam_parts(throw)
    value = axial_formula("Gorbunov", throw, constants={"k_gorbunov": 0.5}).value
    assert value == pytest.approx(frame_compliance(throw, tilt_blocked=False), rel=0.01)
    more = axial_formula("Gorbunov", throw, constants={"k_gorbunov": 1.0}).value
    assert more - value == pytest.approx(2 / 3 * web, rel=1e-9)
    assert value > pin


@given(
    gamma=st.floats(0.0, 180.0),
    R=st.floats(0.1, 0.4),
    h=st.floats(0.03, 0.1),
    L=st.floats(0.05, 0.2),
)
def test_doubling_all_lengths_halves_every_formula(gamma, R, h, L):
    dimensions = {
        "crank_radius": R,
        "main_journal_diameter": 0.22,
        "pin_diameter": 0.18,
        "main_journal_length": 0.12,
        "pin_length": L,
        "web_width": 0.3,
        "web_thickness": h,
    }
    small = axial_formulas(CrankThrow(**dimensions), gamma)
    large = axial_formulas(CrankThrow(**{k: 2 * v for k, v in dimensions.items()}), gamma)
    for name in AXIAL_FORMULA_NAMES:
        assert large[name].value == pytest.approx(small[name].value / 2, rel=1e-10, abs=1e-20), name
