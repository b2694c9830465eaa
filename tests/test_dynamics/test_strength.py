"""Strength of crankshafts: nominal stresses, fatigue over the cycle, shaft elements."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.shaft_line import (
    Coupling,
    Propeller,
    RigidBody,
    ShaftCone,
    ShaftLine,
    ShaftMaterial,
    shaft_cylinder,
    shaft_flange,
)
from dynamics.strength.concentration import (
    FACTORS,
    RANGES,
    ConcentrationFactors,
    CrankWeb,
    SupportedThrow,
    alternating,
    coefficient_differences,
    hole_stress,
    web_stresses,
)
from dynamics.strength.fatigue import (
    PlaceStrength,
    SurfaceTreatment,
    added_bending,
    critical_plane,
    enclosing_radius,
    factors_below,
    fatigue_strength,
    fillet_equivalent,
    findley_bound,
    findley_factor,
    findley_limit,
    hole_equivalent,
)
from dynamics.strength.shrink_fit import ShrinkFit
from refusals import refusals, refusals_of, refused

USUAL = {
    "overlap": 0.15,
    "journal": 1.2,
    "web_thickness": 0.4,
    "web_width": 1.6,
    "pin_fillet_radius": 0.06,
    "journal_fillet_radius": 0.06,
    "pin_bore": 0.0,
    "journal_bore": 0.0,
    "pin_recess": 0.0,
    "journal_recess": 0.0,
    "oil_hole_diameter": 0.08,
}


def web(size=0.2, semi_built=False, **ratios):
    """A web by its ratios to the pin's diameter, which is the size [m]."""
    own = USUAL | ratios
    overlap, journal = own.pop("overlap"), own.pop("journal")
    radius = 0.5 * (1.0 + journal) - overlap
    return CrankWeb(
        pin_diameter=size,
        journal_diameter=size * journal,
        crank_radius=size * radius,
        semi_built=semi_built,
        **{name: size * value for name, value in own.items()},
    )


def random_ratios(count, seed=53):
    """Cranks spread over the ranges of the rule, that of beta_Q included."""
    rng = np.random.default_rng(seed)
    ends = {name: (low, high) for name, (_, low, high) in RANGES.items()}
    ends |= {"overlap": (-0.6, 0.5), "oil_hole_diameter": (1e-3, 0.2), "journal": (0.9, 1.1)}
    ends |= {"pin_recess": (0.0, 0.03), "journal_recess": (0.0, 0.1)}  # no deeper than the fillet
    ends |= {"journal_fillet_radius": (0.034, 0.115)}  # over the journal's diameter in range too
    drawn = {name: rng.uniform(*own, count) for name, own in ends.items()}
    return [{name: own[k] for name, own in drawn.items()} for k in range(count)]


def values(ratios, size=0.2):
    factors = ConcentrationFactors(web(size, **ratios))
    return np.array([getattr(factors, name) for name in FACTORS])


@pytest.mark.slow
def test_factors_are_positive_over_two_thousand_cranks():
    found = np.array([values(own) for own in random_ratios(2_000)])
    assert found.shape == (2_000, 7)
    assert np.all(found > 0.0)
    assert np.all(np.isfinite(found))


@pytest.mark.slow
def test_factors_are_continuous_and_do_not_depend_on_the_size():
    """Also where an overlap ends to count, and where a recess begins to."""
    step = 1e-8  # beta_Q, which falls to zero, is compared by its size
    cranks = random_ratios(150)
    cranks[50:60] = [own | {"overlap": -0.5} for own in cranks[50:60]]
    cranks[60:70] = [own | {"overlap": -1.8 / 3.2} for own in cranks[60:70]]
    for own in cranks:
        before = values(own)
        assert values(own, size=1.7) == close(before)
        for name in ("overlap", "web_thickness", "web_width", "pin_fillet_radius", "pin_bore"):
            _, low, high = RANGES[name]
            least = -0.6 if name == "overlap" else low
            near = own | {name: own[name] + (step if own[name] < 0.5 * (least + high) else -step)}
            assert values(near) == close(before, 3e-6, 1e-6), name


test_ratios_outside_are_refused = refusals_of(
    lambda name, value: ConcentrationFactors(web(**{name: value})),
    ("overlap", 0.55, "overlap over pin_diameter (s)"),
    ("web_thickness", 0.15, "web_thickness over pin_diameter (w)"),
    ("web_width", 2.3, "web_width over pin_diameter (b)"),
    ("pin_fillet_radius", 0.02, "pin_fillet_radius over pin_diameter (r)"),
    ("journal_fillet_radius", 0.031, "journal_fillet_radius over journal_diameter (r)"),
    ("pin_bore", 0.85, "pin_bore over pin_diameter (d_H)"),
    ("journal_bore", 0.85, "journal_bore over pin_diameter (d_G)"),
    ("oil_hole_diameter", 0.25, "oil_hole_diameter over pin_diameter (d_O)"),
)


def test_a_shrunk_journal_has_no_fillet_and_a_pin_without_hole_no_outlet():
    factors = ConcentrationFactors(
        web(semi_built=True, journal_fillet_radius=0.0, oil_hole_diameter=0.0)
    )
    assert factors.alpha_bending > 1.0
    with refused("semi_built"):
        _ = factors.beta_bending
    with refused("semi_built"):
        _ = factors.beta_torsion
    with refused("oil_hole_diameter"):
        _ = factors.gamma_torsion
    assert set(coefficient_differences(factors.web)) == {"alpha_T"}


def test_a_deep_recess_thins_the_web_of_a_shaft_without_overlap():
    deep = {"pin_recess": 0.1}
    assert web(**deep).section_thickness == close(0.4 * 0.2)
    assert web(**deep, overlap=-0.1).section_thickness == close((0.4 - 0.04) * 0.2)
    assert web(**deep, semi_built=True).section_thickness == close((0.4 - 0.04) * 0.2)


def test_a_throw_with_a_rod_in_the_middle_shares_its_force():
    force = np.array([[0.0, 100e3, -20e3]])
    throw = SupportedThrow(0.4, [0.2], force, np.zeros((1, 3)))
    assert throw.moment(0.1, force) == close(0.5 * force[0] * 0.1)
    assert throw.moment(0.3, force) == close(0.5 * force[0] * 0.1)
    assert throw.shear(0.3, force) == close(-0.5 * force[0])
    own = web()
    bending, shear = web_stresses(throw, own, 0.1, strokes=4)
    area = own.web_width * own.web_thickness
    assert bending == close(0.5 * 60e3 * 0.1 / (area * own.web_thickness / 6.0))
    assert shear == close(0.5 * 60e3 / area)
    assert web_stresses(throw, own, 0.1, strokes=2) == close([0.8 * bending, 0.8 * shear])


def test_an_oil_hole_is_bent_in_its_own_direction():
    angle = np.linspace(0.0, 2.0 * math.pi, 361)
    radial, tangential = 3e4 * np.cos(angle)[np.newaxis], 1e4 * np.sin(angle)[np.newaxis]
    throw, own = SupportedThrow(0.4, [0.2], radial, tangential), web()
    modulus = math.pi / 32.0 * own.pin_diameter**3
    assert hole_stress(throw, own, 0.2, 0.0) == close(0.5 * 1e4 * 0.2 / modulus)
    assert hole_stress(throw, own, 0.2, 90.0) == close(0.5 * 3e4 * 0.2 / modulus)
    assert hole_stress(throw, own, 0.2) == close(0.5 * 3e4 * 0.2 / modulus)
    # Forces in phase towards +t and -r, the radial one towards the shaft, bend most where they point.
    both = SupportedThrow(0.4, [0.2], tangential, tangential)
    assert hole_stress(both, own, 0.2, -45.0) == close(hole_stress(both, own, 0.2))
    assert hole_stress(both, own, 0.2, 45.0) < 1e-6 * hole_stress(both, own, 0.2)


def test_what_cannot_load_a_throw_is_refused():
    one = np.ones((1, 2))
    with refused("rods"):
        SupportedThrow(0.4, [0.5], one, one)
    with refused("radial"):
        SupportedThrow(0.4, [0.1, 0.2], one, one)
    with refused("strokes"):
        web_stresses(SupportedThrow(0.4, [0.1], one, one), web(), 0.1, strokes=3)
    assert alternating([[1.0, -3.0], [2.0, 2.0]]) == close([2.0, 0.0])


def test_equivalent_stresses():
    assert fillet_equivalent(90.0, 0.0, 10.0) == close(100.0)
    assert fillet_equivalent(0.0, 10.0, 0.0) == close(math.sqrt(300.0))
    assert hole_equivalent(90.0, 0.0) == close(90.0)
    assert hole_equivalent(0.0, 90.0) == close(90.0)
    bending, torsion = 60.0, 80.0
    printed = bending / 3.0 * (1.0 + 2.0 * math.sqrt(1.0 + 9.0 / 4.0 * (torsion / bending) ** 2))
    assert hole_equivalent(bending, torsion) == close(printed)


def test_additional_stress():
    assert [added_bending("trunk"), added_bending("crosshead")] == close([10e6, 30e6])
    assert added_bending("crosshead", 6e6) == close(16e6)
    assert added_bending("crosshead", 25e6) == close(35e6)
    assert added_bending("trunk", 6e6) == close(10e6)


def test_small_radii_do_not_raise_the_strength():
    assert fatigue_strength(8e8, 0.1, 1e-3) == close(fatigue_strength(8e8, 0.1, 2e-3))
    assert fatigue_strength(8e8, 0.1, 1e-2) < fatigue_strength(8e8, 0.1, 2e-3)


def test_a_place_is_acceptable_from_1_15_on():
    def place(equivalent):
        return PlaceStrength(1, "pin fillet", "left web", 0.0, *[0.0] * 6, equivalent, 230e6)

    assert place(200e6).passed
    assert not place(200.1e6).passed
    assert place(0.0).acceptability == math.inf
    assert place(math.inf).acceptability == 0.0


def test_factors_fall_below_the_surface():
    factors = ConcentrationFactors(web(0.2))
    assert factors_below(factors, "pin fillet", 0.0) == close(
        [factors.alpha_bending, factors.alpha_torsion]
    )
    assert factors_below(factors, "oil hole", 0.0) == close(
        [factors.gamma_bending, factors.gamma_torsion]
    )
    # 4 mm below a fillet of 12 mm and a hole of 16 mm, with W 80 mm, S 30 mm, D 200 mm.
    bending, torsion = factors.alpha_bending, factors.alpha_torsion
    across = (8.0 / math.hypot(80.0, 30.0)) ** (0.6 / math.sqrt(bending))
    through = (8.0 / 200.0) ** (1.0 / math.sqrt(torsion))
    assert factors_below(factors, "pin fillet", 4e-3) == close(
        [
            (bending - 1.0) * math.exp(-8.0 / 12.0) + 1.0 - across,
            (torsion - 1.0) * math.exp(-4.0 / 12.0) + 1.0 - through,
        ]
    )
    assert factors_below(factors, "oil hole", 4e-3) == close(
        [
            (factors.gamma_bending - 1.0) * math.exp(-1.0) + 1.0,
            (factors.gamma_torsion - 1.0) * math.exp(-0.5) + 1.0,
        ]
    )
    for place, depth, why in (
        ("journal fillet", 1e-3, "place: given 'journal fillet'"),
        ("pin fillet", -1e-3, "depth: given -0.001 m"),
        ("pin fillet", 0.1, "depth: given 0.1 m; allowed is less than half"),
    ):
        with pytest.raises(InputError, match=why):
            factors_below(factors, place, depth)


def test_hardened_surfaces():
    induction = SurfaceTreatment("induction", 4e-3, 550.0)
    assert induction.surface_strength == close(475e6)
    assert induction.transition == close(4e-3)
    assert induction.transition_strength(300e6) == close(240e6)
    nitrided = SurfaceTreatment("nitriding", 0.5e-3, 700.0)
    assert nitrided.surface_strength == close(450e6)
    assert nitrided.transition == close(0.6e-3)
    assert nitrided.transition_strength(300e6) == close(300e6)
    # The layer ends where the steel is 50 HV harder than its core.
    assert nitrided.hardness([0.0, 0.5e-3, 5e-3], 300.0) == close([700.0, 350.0, 300.0])


test_wrong_hardening_is_refused = refusals_of(
    lambda given: SurfaceTreatment(*given),
    (("peening", 1e-3, 500.0), "process"),
    (("induction", 0.0, 500.0), "depth"),
    (("induction", 1e-3, 390.0), "surface_hardness"),
    (("nitriding", 1e-3, 590.0), "surface_hardness"),
)


FIT = {
    "shrink_diameter": 0.7,
    "shrink_length": 0.32,
    "web_diameter": 1.3,
    "journal_diameter": 0.68,
    "fillet_radius": 0.02,
    "distance": 0.1,
    "web_yield": 3.5e8,
    "journal_yield": 3e8,
    "torque": 1.2e6,
}


def test_a_shrink_fit_by_hand():
    """In N and mm: 4000 S_R M / (mu pi D_S^2 L_S s_SP) and so on."""
    fit = ShrinkFit(**FIT, journal_bore=0.1)
    slip = 4000.0 * 2.0 * 1.2e6 / (0.2 * math.pi)
    assert fit.largest_bore == close(0.7 * math.sqrt(1.0 - slip / (700.0**2 * 320.0 * 300.0)))
    q_a, q_s = 700.0 / 1300.0, 100.0 / 700.0
    thin = (1.0 - (q_a * q_s) ** 2) / ((1.0 - q_a**2) * (1.0 - q_s**2))
    held = slip / (2.05e5 * 700.0 * 320.0) * thin
    assert fit.least_shrinkage == close(1e-3 * max(350.0 * 700.0 / 2.05e5, held))
    assert fit.most_shrinkage == close(1e-3 * 700.0 * (350.0 / 2.05e5 + 0.8e-3))
    assert (fit.passed, fit.refusals, fit.remarks) == (True, (), ())
    # With a torque so large that it, not the web's yield, sets the least shrinkage.
    more = ShrinkFit(**FIT | {"torque": 2.6e6, "web_yield": 2e8}, journal_bore=0.1)
    assert more.least_shrinkage == close(1e-3 * held * 2.6 / 1.2)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"distance": 0.03}, "30 mm apart at the fit, 0.05 shrink diameters or 35 mm are needed"),
        ({"fillet_radius": 0.01}, "fillet has a radius of 10 mm, 10.2 mm are needed"),
        ({"journal_diameter": 0.6, "fillet_radius": 0.04}, "radius of 40 mm, 50 mm are needed"),
        ({"torque": 8e6}, "no bore is small enough"),
        ({"journal_bore": 0.69}, "bore of 690 mm is above"),
        ({"torque": 6e6, "web_yield": 1e8}, "the torque needs a shrinkage of"),
    ],
)
def test_a_shrink_fit_that_is_not_allowed(change, said):
    fit = ShrinkFit(**FIT | change)
    assert not fit.passed
    assert any(said in one for one in fit.refusals), fit.refusals


def test_a_near_pin_asks_for_special_consideration():
    assert len(ShrinkFit(**FIT | {"distance": 0.06}).remarks) == 1


test_wrong_fits_are_refused = refusals_of(
    lambda change: ShrinkFit(**FIT | change),
    ({"friction": 0.25}, "friction"),
    ({"safety": 1.5}, "safety"),
    ({"web_diameter": 0.65}, "shrink_diameter"),
    ({"torque": 0.0}, "torque"),
)


K = findley_factor()
CYCLE = np.linspace(0.0, 2.0 * np.pi, 181)[:-1]
# Planes are found to 0.2 degrees, where the criterion is flat: half the square of that angle.
FLAT = 2e-5


def stresses(first, second, between):
    return np.stack(np.broadcast_arrays(first, second, between), axis=-1)


def proportional(bending, torsion):
    wave = np.cos(CYCLE)
    return stresses(bending * wave, 0.0 * wave, torsion * wave)


def test_both_strengths_are_one_limit():
    """k by its own equation, solved apart from the program: sin(arctan k) = 2/sqrt(3) - 1."""
    assert math.tan(math.asin(2.0 / math.sqrt(3.0) - 1.0)) == close(K)
    bending, torsion = 300e6, 300e6 / math.sqrt(3.0)
    limit = findley_limit(bending, K)
    assert critical_plane(proportional(bending, 0.0), K).value == close(limit, FLAT)
    assert critical_plane(proportional(0.0, torsion), K).value == close(limit, FLAT)


def test_shear_that_turns_has_the_radius_of_its_circle():
    """Torsion a quarter of a cycle behind tension: on the cross section tau alone, else an ellipse."""
    history = stresses(np.cos(CYCLE), 0.0, 0.5 * np.sin(CYCLE))
    found = critical_plane(history, K)
    # Across the axis: shear 0.5, normal 1. No plane is below that.
    assert found.value >= 0.5 + K - 1e-12
    assert found.value <= findley_bound(history, K)


@pytest.mark.slow
def test_no_plane_among_many_is_worse():
    """Every moment on planes all over the half sphere, circles by an even search; out-of-phase history."""
    history = stresses(
        80.0 + 100.0 * np.cos(CYCLE),
        30.0 * np.cos(CYCLE + 0.3),
        70.0 * np.sin(CYCLE) + 20.0 * np.cos(3.0 * CYCLE),
    )
    normals = np.random.default_rng(2).normal(size=(3000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    tensor = np.zeros((len(CYCLE), 3, 3))
    tensor[:, 0, 0], tensor[:, 1, 1] = history[:, 0], history[:, 1]
    tensor[:, 0, 1] = tensor[:, 1, 0] = history[:, 2]
    traction = np.einsum("mij,pj->pmi", tensor, normals)
    normal = np.einsum("pmi,pi->pm", traction, normals)
    shear = traction - normal[..., None] * normals[:, None]
    aside = np.where(np.abs(normals[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normals, first)
    flat = np.stack([np.einsum("pmi,pi->pm", shear, one) for one in (first, second)], axis=-1)
    brute = enclosing_radius(flat) + K * normal.max(axis=1)
    found = critical_plane(history, K)
    assert found.value >= brute.max() * (1.0 - FLAT)
    assert found.value == close(brute.max(), 0.01)  # 3000 planes are 3.7 degrees apart
    assert found.value <= findley_bound(history, K)


@pytest.mark.slow
def test_smallest_circles():
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5 * math.sqrt(3.0)], [0.5, 0.3]])
    flat = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, -1.9]])
    assert enclosing_radius([triangle, flat]) == close([1.0 / math.sqrt(3.0), 2.0])
    assert enclosing_radius(np.ones((1, 5, 2))) == close([0.0], abs=1e-15)
    points = np.random.default_rng(1).normal(size=(20, 30, 2))
    radii = enclosing_radius(points)
    # No circle about any place of a fine grid is smaller, and that of the best place hardly larger.
    grid = np.stack(np.meshgrid(*[np.linspace(-1.6, 1.6, 129)] * 2), axis=-1).reshape(-1, 2)
    best = np.linalg.norm(points[:, None] - grid[:, None], axis=-1).max(axis=2).min(axis=1)
    assert np.all(radii <= best + 1e-12)
    assert np.all(best - radii < 0.025)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_strengths_that_no_factor_fits_are_refused(share):
    with refused("torsion_share"):
        findley_factor(share)


def test_a_path_repeated_thousands_of_times_is_that_path():
    """In line, so that it has two corners."""
    angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    once = np.outer(np.cos(angles), [0.0, 0.0, 1.7e8])
    found, wanted = (critical_plane(path, 0.16) for path in (np.resize(once, (100_000, 3)), once))
    assert (found.value, found.moment) == (wanted.value, wanted.moment)


G, E, RHO = 8e10, 2e11, 7800.0
MATERIAL = ShaftMaterial(E, G, RHO)


@settings(max_examples=20)
@given(
    st.floats(0.1, 0.5),
    st.floats(0.1, 0.5),
    st.sampled_from([0.0, 1e-4, 0.049, 0.051, 0.5, 0.95]),
    st.sampled_from(["cylindrical", "proportional"]),
)
def test_cones_by_quadrature(left, right, share, shape):
    length, bore = 0.7, share * min(left, right)
    cone = ShaftCone(length, left, right, bore, shape, MATERIAL)

    def powers(z, power):
        outer = left + (right - left) * z / length
        return outer**power - (bore if shape == "cylindrical" else bore * outer / left) ** power

    def along(function):
        return quad(function, 0.0, length, epsabs=0.0, epsrel=1e-12)[0]

    # The quadrature's own tolerance.
    twist = along(lambda z: 32.0 / (math.pi * G * powers(z, 4)))
    assert cone.torsional_compliance == close(twist, rel=1e-11)
    stretch = along(lambda z: 4.0 / (math.pi * E * powers(z, 2)))
    assert cone.axial_compliance == close(stretch, rel=1e-11)
    assert cone.mass == close(RHO * math.pi / 4.0 * along(lambda z: powers(z, 2)))
    inertia = RHO * math.pi / 32.0 * along(lambda z: powers(z, 4))
    assert cone.polar_inertia == close(inertia)
    parts = cone.divided(3)
    assert sum(part.torsional_compliance for part in parts) == close(twist, rel=1e-10)
    assert sum(part.mass for part in parts) == close(cone.mass)
    moduli = [
        math.pi / 16.0 * powers(z, 4) / (left + (right - left) * z / length) for z in (0, length)
    ]
    assert cone.section_modulus == close(min(moduli))


def test_a_shaft_line_as_a_chain():
    line = ShaftLine(
        [
            shaft_flange(0.08, 0.5, material=MATERIAL),
            shaft_cylinder(4.0, 0.3, material=MATERIAL, name="intermediate"),
            Coupling(2e6, 5e8, 3.0, 4.0, 30.0, 40.0, torsional_damping=9.0, loss_factor=0.1),
            ShaftCone(1.0, 0.3, 0.2, material=MATERIAL),
            Propeller(
                100.0, 900.0, entrained_inertia_share=0.25, entrained_mass=500.0, damping=7.0
            ),
        ],
        name="line",
    )
    flange, shaft, _, cone, _ = line.pieces
    chain = line.chain()
    assert chain.names == ("line 0", "line 1", "line 2", "line 3", "propeller")
    assert chain.inertia.tolist() == [0.0, 0.0, 3.0, 4.0, 125.0]
    assert chain.distributed_inertia.tolist() == [
        flange.polar_inertia, shaft.polar_inertia, 0.0, cone.polar_inertia,
    ]  # fmt: skip
    assert 1.0 / chain.stiffness == close(
        [flange.torsional_compliance, shaft.torsional_compliance, 5e-7, cone.torsional_compliance]
    )
    assert chain.loss_factor.tolist() == [0.0, 0.0, 0.1, 0.0]
    assert chain.damping.tolist() == [0.0, 0.0, 9.0, 0.0]
    assert chain.ground_damping.tolist() == [0.0, 0.0, 0.0, 0.0, 7.0]
    assert line.compliance("torsional") == close(np.sum(1.0 / chain.stiffness))
    axial = line.chain("axial", parts=3, inertia="lumped")
    assert len(axial.names) == 1 + 3 + 3 + 1 + 3
    assert not axial.distributed_inertia.any()
    assert axial.inertia.sum() == close(line.mass + 30.0 + 40.0 + 1400.0)
    assert np.sum(1.0 / axial.stiffness) == close(line.compliance("axial"))
    assert axial.modes().rigid == 1
    assert line.section_modulus == close(math.pi / 16.0 * 0.2**3)


def test_bodies_share_a_joint():
    pieces = [RigidBody(1.0, 2.0, "gear"), RigidBody(3.0, 4.0, "brake"), shaft_cylinder(1.0, 0.1)]
    chain = ShaftLine(pieces).chain()
    assert chain.names == ("gear, brake", "shaft 1")
    assert chain.inertia.tolist() == [4.0, 0.0]


def test_propeller_with_water():
    given = Propeller(10.0, 200.0, entrained_inertia=2.0, entrained_mass_share=0.6)
    assert (given.inertia, given.mass) == (12.0, 320.0)


test_refused = refusals(
    ("pin_bore", lambda: web(pin_bore=1.5)),
    ("web_width", lambda: web(web_width=0.0)),
    ("process", lambda: SurfaceTreatment("induction", 1e-3, 500.0).hardness(0.0, 250.0)),
    ("core_hardness", lambda: SurfaceTreatment("nitriding", 1e-3, 700.0).hardness(0.0, 660.0)),
    ("history", lambda: critical_plane(np.zeros((4, 2)), K)),
    ("shaft.length", lambda: shaft_cylinder(0.0, 0.1)),
    ("shaft.diameter", lambda: shaft_cylinder(1.0, -0.1)),
    ("shaft.bore", lambda: shaft_cylinder(1.0, 0.1, 0.1)),
    ("shaft.bore", lambda: ShaftCone(1.0, 0.2, 0.1, 0.15)),
    ("shaft.bore_shape", lambda: ShaftCone(1.0, 0.2, 0.1, 0.05, "oval")),
    ("coupling.torsional_stiffness", lambda: Coupling(torsional_stiffness=0.0)),
    ("coupling.axial_stiffness", lambda: ShaftLine([Coupling(1.0)]).chain("axial")),
    ("inertia[0]", lambda: ShaftLine([Coupling(1.0)]).chain()),
    ("pieces", lambda: ShaftLine([])),
    ("pieces[0]", lambda: ShaftLine([3.0])),
    ("kind", lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain("bending")),
    ("parts", lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain(parts=0)),
    ("inertia", lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain(inertia="thick")),
    ("pieces", lambda: ShaftLine([RigidBody(1.0, 1.0, "a")]).section_modulus),
    ("body.inertia", lambda: RigidBody(-1.0, 0.0, "a")),
    ("propeller.entrained_inertia", lambda: Propeller(1.0, 1.0, entrained_mass=0.0)),
    ("propeller.entrained_mass", lambda: Propeller(1.0, 1.0, 1.0, 1.0, entrained_mass_share=0.6)),
    ("material.density", lambda: ShaftMaterial(density=0.0)),
    ("pin_recess", lambda: web(pin_recess=0.5, semi_built=True)),
    ("piston", lambda: added_bending("opposed")),
    ("axial_vibration", lambda: added_bending("crosshead", -1.0)),
    ("tensile_strength", lambda: fatigue_strength(0.0, 0.1, 1e-2)),
)
