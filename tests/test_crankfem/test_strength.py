"""Strength of an engine's crankshaft: what goes into it, what is said of it, and the report's part."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.assumptions import assumed_values
from crankfem.analyses.strength import engine_strength
from crankfem.analyses.strength.cycle_loads import shaft_loads
from crankfem.analyses.strength.engine_strength import shown_factor
from crankfem.analyses.vibration.engine_limits import engine_limits
from dynamics.response.series import synthesis
from dynamics.strength.fatigue import factors_below
from plain_values import texts_with_plain_values

GIVEN = {
    "tensile_strength": 8e8,
    "manufacture": "continuous grain flow",
    "piston": "trunk",
    "oil_hole_diameter": 0.015,
}
FIT = {
    "shrink_diameter": 0.23,
    "shrink_length": 0.06,
    "web_diameter": 0.285,
    "fillet_radius": 0.012,
    "web_yield": 4e8,
    "journal_yield": 4e8,
}


@pytest.fixture(scope="module")
def loads(coupled_vibration):
    """Largest alternating loads of the six-cylinder engine's throws."""
    vibration = coupled_vibration("6chn25-34")
    return shaft_loads(vibration)


@pytest.fixture(scope="module")
def judged(coupled_vibration, loads):
    """Judge the six-cylinder engine with what its section [strength] has besides; its loads are shared."""
    vibration = coupled_vibration("6chn25-34")

    def judge(throw=None, assessment=None, **section):
        file = vibration.engine_file.changed(strength=GIVEN | section)
        if throw is not None:
            file = file.changed(throw=throw)
        own = replace(vibration, engine_file=file, assessment=assessment or vibration.assessment)
        with pytest.MonkeyPatch.context() as patched:
            if assessment is None:
                patched.setattr(engine_strength, "shaft_loads", lambda *_: loads)
            return cf.strength.engine_strength(own)

    return judge


@pytest.fixture(scope="module")
def usual(judged):
    return judged()


def by_name(found, throw):
    return {one.place: one for one in found.throws[throw - 1].places}


@pytest.mark.slow
def test_every_value_of_the_strength_stays_a_value(usual, judged):
    for strength in (usual, judged(shrink_fit=FIT), judged(factors="formulas")):
        assert [*texts_with_plain_values(strength)] == []


@pytest.mark.slow
def test_torques_are_those_of_the_vibration(usual, loads, coupled_vibration):
    vibration = coupled_vibration("6chn25-34")
    forced, engine = vibration.forced_torsional, vibration.engine_file.engine
    elastic = forced.loads.elastic
    running = (elastic.speeds >= engine.lowest_speed) & (elastic.speeds <= engine.highest_speed)
    total = synthesis(elastic.orders, elastic.speeds, elastic.values, elastic.unbounded).amplitude
    # Throw 4 lies between elements 3 and 4; the free end lies before element 0.
    normal = [np.max(total[running][:, [place, place + 1]]) for place in range(6)]
    assert [one.value for one in loads.normal] == close(normal)
    assert [one.torque.value for one in usual.throws] == close(
        [max(one.value, two.value) for one, two in zip(loads.normal, loads.misfiring, strict=True)]
    )
    # That check looks for the worst speed between those calculated, where most of the limit is used.
    worst = vibration.misfiring.of_stress
    place = int(re.findall(r"\d", worst.misfiring.place)[0])
    near = loads.misfiring[place - 1]
    assert near.cylinders == worst.cylinders
    assert near.value == close(worst.misfiring.value * math.pi / 16.0 * 0.18**3, 1e-3)
    mean = float(np.max(forced.forces.mean_torque[running]))
    assert loads.torque(3).value < loads.passed_on[3] <= mean + loads.torque(3).value


@pytest.mark.slow
def test_a_place_put_together_by_hand(usual):
    torque = usual.throws[3].torque.value
    places = by_name(usual, 4)
    pin, journal, hole = (places[name] for name in ("pin fillet", "journal fillet", "oil hole"))
    factors = usual.throws[3].factors["left web"]
    assert pin.nominal_torsion == close(torque / (math.pi / 16.0 * 0.18**3))
    assert journal.nominal_torsion == close(torque / (math.pi / 16.0 * 0.22**3))
    bending = factors.beta_bending * 47.0214e6 + factors.beta_shear * 5.25034e6
    assert journal.bending == close(bending, 1e-4)
    assert journal.equivalent == close(
        math.hypot(bending + 10e6, math.sqrt(3.0) * factors.beta_torsion * journal.nominal_torsion),
        1e-4,
    )
    assert (pin.added, hole.added) == (10e6, 0.0)
    assert pin.bending == close(factors.alpha_bending * 47.0214e6, 1e-4)
    strength = cf.strength.fatigue_strength
    assert pin.strength == close(strength(8e8, 0.18, 0.012, 1.05))
    assert journal.strength == close(strength(8e8, 0.22, 0.012, 1.05))
    assert hole.strength == close(strength(8e8, 0.18, 0.0075))
    assert hole.torsion == close(factors.gamma_torsion * pin.nominal_torsion)
    assert hole.acceptability == close(hole.strength / hole.equivalent)


@pytest.mark.slow
def test_what_is_said_of_a_strong_and_of_a_weak_shaft(usual, judged):
    least = usual.places[0]
    assert usual.passed
    assert f"Q = {least.acceptability:.2f}" in usual.sentence
    assert f"{least.place} of throw {least.throw}," in usual.sentence
    frame = usual.to_pandas()
    assert frame["acceptability"].is_monotonic_increasing
    assert len(frame) == 18
    weak = judged(tensile_strength=4e8, manufacture="cast and cold rolled")
    wrong = sum(one.acceptability < 1.15 for one in weak.places)
    assert 0 < wrong < 18
    assert f"{wrong} of 18 " in weak.sentence
    assert not weak.passed


@pytest.mark.slow
def test_barred_ranges_are_left_out(usual, judged):
    speed = usual.throws[3].torque.speed
    barred = [(0.95 * speed, 1.02 * speed)]
    found = judged(assessment=SimpleNamespace(verdict=SimpleNamespace(ranges_to_bar=barred)))
    for before, after in zip(usual.throws, found.throws, strict=True):
        assert after.torque.value <= before.torque.value * (1.0 + 1e-12)
        assert not barred[0][0] < after.torque.speed < barred[0][1]
    assert found.throws[3].torque.value < usual.throws[3].torque.value


@pytest.mark.slow
def test_hardening_is_judged_at_the_surface_and_below(usual, judged):
    before = by_name(usual, 4)
    given = {
        "process": "induction",
        "depth": 3e-3,
        "surface_hardness": 550.0,
        "places": ("pin fillet",),
    }
    after = by_name(judged(hardening=given), 4)
    assert after["oil hole"].row() == before["oil hole"].row()
    below = factors_below(usual.throws[3].factors["left web"], "pin fillet", 3e-3)
    pin = before["pin fillet"]
    deep = math.hypot(
        below[0] * pin.nominal_bending + 10e6, math.sqrt(3.0) * below[1] * pin.nominal_torsion
    )
    candidates = {0.0: 475e6 / pin.equivalent, 3e-3: 0.8 * pin.strength / deep}
    depth = min(candidates, key=candidates.get)
    assert after["pin fillet"].depth == depth
    assert after["pin fillet"].acceptability == close(candidates[depth])


@pytest.mark.slow
def test_crossheads_take_the_calculated_axial_vibration(judged, coupled_vibration):
    rule = by_name(judged(piston="crosshead"), 6)["pin fillet"]
    own = judged(piston="crosshead", axial_vibration="calculated")
    found = by_name(own, 6)["pin fillet"]
    assert rule.added == close(30e6)
    # By the masses before the throw, which the force through it moves; losses in the springs aside.
    vibration = coupled_vibration("6chn25-34")
    forced, engine = vibration.forced_axial, vibration.engine_file.engine
    response, speeds = forced.response, forced.response.speeds
    running = (speeds >= engine.lowest_speed) & (speeds <= engine.highest_speed)
    w = response.angular_frequencies[:, :, np.newaxis]
    chain = response.chain
    moved = (w**2 * chain.inertia - 1j * w * chain.ground_damping - chain.ground) * response.motion
    total = np.sum(moved[:, :, : forced.engine_chain.sections[5] + 1], axis=2)
    force = np.max(synthesis(response.orders, speeds, total).amplitude[running])
    modulus = 0.285 * 0.068**2 / 6.0
    alpha = own.throws[5].factors["left web"].alpha_bending
    assert found.added - 10e6 == close(alpha * force * 0.17 / modulus, 0.02)


@pytest.mark.slow
def test_a_semi_built_shaft_has_fits_and_no_journal_fillets(judged):
    found = judged(shrink_fit=FIT)
    assert len(found.places) == 12
    fit = found.throws[0].fit
    assert fit.torque > found.throws[0].torque.value
    assert fit.distance == 0.0  # pin and fit overlap in this crank: not allowed
    assert found.passed is False
    assert "throw 1" in found.sentence
    assert found.to_record()["throws"][0]["shrink_fit"]["refusals"]


@pytest.mark.slow
def test_what_the_rule_has_no_factors_for_is_named_once(judged):
    found = judged(throw={"main_journal_fillet_radius": 0.0})
    assert (found.passed, found.places) == (None, ())
    (left, right) = found.left_out
    assert all("throws 1 to 6, " in one and "journal_fillet_radius" in one for one in (left, right))


def test_a_factor_is_not_rounded_to_a_sufficient_one():
    def place(q):
        return SimpleNamespace(acceptability=q, passed=q >= 1.15)

    assert [shown_factor(place(q)) for q in (1.1499, 1.15, 1.7204, 1.14999999)] == [
        *("Q = 1.1499", "Q = 1.15", "Q = 1.72", "Q = 1.149999990")
    ]


def test_strength_asks_for_its_section_forces_and_one_pin_a_throw():
    engine = cf.load_engine("6chn25-34")
    with pytest.raises(InputError, match=r"strength: "):
        engine.changed(strength=GIVEN, gas=None)
    several = {"further_pins": ({"angle": 1.0, "web_thickness": 0.06},)}
    with pytest.raises(InputError, match=r"strength: "):
        engine.changed(strength=GIVEN, throw=several)
    with pytest.raises(InputError, match=r"strength.pin_recess: "):
        engine.changed(strength=GIVEN | {"pin_recess": 0.07})
    with pytest.raises(InputError, match=r"strength.shrink_fit.shrink_diameter: given 100 mm"):
        engine.changed(
            strength=GIVEN | {"shrink_fit": FIT | {"shrink_diameter": 0.1}},
            throw={"main_journal_bore": 0.12},
        )
    without = SimpleNamespace(engine_file=engine)
    with pytest.raises(InputError, match=r"\[strength\]"):
        cf.strength.engine_strength(without)


@pytest.mark.parametrize(
    ("told", "counted", "alloy"), [(550e6, 550e6, False), (900e6, 835e6, True)]
)
def test_the_steel_is_that_of_the_torsional_limit_too(told, counted, alloy):
    """Beyond the end of the rule's formula for alloy steel more strength counts no more."""
    engine = cf.load_engine("6chn25-34").changed(
        strength={
            "tensile_strength": told,
            "manufacture": "continuous grain flow",
            "piston": "trunk",
        }
    )
    written = engine.changed(strength=None, limits={"tensile_strength": counted, "alloy": alloy})
    speeds = np.linspace(0.2, 1.0, 5) * engine.engine.rated_speed
    here, there = (
        engine_limits(one)[0]["crankshaft_stress"].continuous.values(speeds)
        for one in (engine, written)
    )
    assert here == close(there, rel=1e-12)
    plain = engine_limits(engine.changed(strength=None))[0]["crankshaft_stress"]
    assert here[-1] > plain.continuous.values(speeds)[-1]
    named = [record.field for record in assumed_values(engine)]
    assert "limits.tensile_strength" not in named
    assert "limits.yield_strength" in named
