"""Balance against the sum of mass times acceleration, and against the bearings' and walls' forces.

Tolerances: relative to the sum of all masses times R w^2, of which sums of some tens of terms leave
about 1e-15 as round-off; 1e-13 leaves room for it.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.balance.balance import balance, hinged_rod_effects, hodograph_change
from dynamics.balance.moving_masses import Hodograph, balancing_masses, moving_masses
from dynamics.engine.firing import firing_order_of_angles
from dynamics.engine.forces import mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout, RotatingMass, SlavePin
from dynamics.engine.motions import (
    acceleration_orders,
    cylinder_motion,
    piston_acceleration,
    turn_spectrum,
)
from dynamics.engine.rods import ConnectingRod
from dynamics.engine.slider_crank import SliderCrank

ROUND_OFF = 1e-13
SPEED = 150.0
MAIN = ConnectingRod(0.40, 30.0, 0.13, 0.9, center_offset=0.012)
HINGED = ConnectingRod(0.30, 12.0, 0.11, 0.2, center_offset=-0.004)
STRAIGHT = ConnectingRod(0.40, 30.0, 0.13, 0.9)


def engine_with_everything():
    """Two throws with hinged rods, offsets, lateral centers, odd angles, and counterweights."""
    cylinders = []
    for number, (crank, place) in enumerate(((0.3, 0.1), (2.0, 0.5))):
        main = EngineCylinder(
            0.2,
            20.0,
            MAIN,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=math.degrees(-0.35),
            position=place,
            pin_offset=0.01,
        )
        pin = SlavePin(2 * number + 1, 0.1, angle_deg=math.degrees(0.75))
        hinged = EngineCylinder(
            0.2,
            18.0,
            HINGED,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=math.degrees(0.45),
            position=place,
            pin_offset=-0.006,
            slave_pin=pin,
        )
        cylinders += [main, hinged]
    weights = [
        RotatingMass(1.5, angle_deg=math.degrees(2.5), position=0.0),
        RotatingMass(2.0, angle_deg=math.degrees(-1.0), position=0.6),
    ]
    return EngineLayout(0.1, cylinders, [1, 2, 3, 4], 2, rotating=weights)


def in_line(cranks, rod=STRAIGHT, pitch=0.25):
    cylinders = [
        EngineCylinder(
            0.2,
            20.0,
            rod,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=0.0,
            position=place * pitch,
        )
        for place, crank in enumerate(cranks)
    ]
    firing = [-crank for crank in cranks]
    order = firing_order_of_angles(firing, 2, 1)
    return EngineLayout(0.1, cylinders, order, 2, firing_angles_deg=np.degrees(firing))


def one_cylinder(ratio):
    return in_line([0.0], ConnectingRod(0.1 / ratio, 30.0, 0.05, 0.1))


def summed_orders(found, angles, kind):
    return sum(getattr(row, kind).at(shaft_angle_deg=np.degrees(angles)) for row in found.rows)


def test_forces_are_minus_mass_times_acceleration():
    engine = engine_with_everything()
    # Of the orders beyond 31 less than round-off is left.
    angles = 2.0 * np.pi * np.arange(64) / 64
    found = balance(engine, SPEED, range(1, 32))
    force, moment = np.zeros(64, complex), np.zeros(64, complex)
    for number, cylinder in enumerate(engine.cylinders, start=1):
        motion = cylinder_motion(engine, number, shaft_angles_deg=np.degrees(angles))
        rod = motion.rod_point(cylinder.rod.center).acceleration(SPEED)
        along = cylinder.piston_mass * motion.piston.acceleration(SPEED)
        own = -(along + cylinder.rod.mass * rod) * np.exp(
            1j * math.radians(cylinder.bank_angle_deg)
        )
        force += own
        moment += 1j * (cylinder.position - found.about) * own
    for mass in engine.rotating:
        own = mass.static_moment * SPEED**2 * np.exp(1j * (math.radians(mass.angle_deg) + angles))
        force += own
        moment += 1j * (mass.position - found.about) * own
    assert found.about == close(0.3)
    row = found.rows[0]
    np.testing.assert_allclose(
        summed_orders(found, angles, "force"),
        force - force.mean(),
        rtol=0,
        atol=ROUND_OFF * row.force_scale,
    )
    np.testing.assert_allclose(
        summed_orders(found, angles, "moment"),
        moment - moment.mean(),
        rtol=0,
        atol=ROUND_OFF * row.force_scale,
    )


def test_forces_arrive_at_bearings_and_walls():
    engine = replace(engine_with_everything(), rotating=())
    angles = 2.0 * np.pi * np.arange(64) / 64
    found = balance(engine, SPEED, range(1, 32))
    forces = mechanism_forces(engine, SPEED, shaft_angles_deg=np.degrees(angles))
    turns = np.exp(
        1j * np.array([[math.radians(cylinder.bank_angle_deg)] for cylinder in engine.cylinders])
    )
    on_engine = np.sum(forces.crankpin - 1j * forces.side * turns, axis=0)
    np.testing.assert_allclose(
        summed_orders(found, angles, "force"),
        on_engine - on_engine.mean(),
        rtol=0,
        atol=ROUND_OFF * found.rows[0].force_scale,
    )


def test_two_masses_are_exact_where_nothing_lies_beside_the_rods():
    engine = in_line([0.0, 2.0, 4.0])
    rigid, two = balance(engine, SPEED), balance(engine, SPEED, model="two-mass")
    assert [row.total for row in rigid.rows] == [row.total for row in two.rows]
    beside = engine_with_everything()
    rigid, two = balance(beside, SPEED), balance(beside, SPEED, model="two-mass")
    for ours, plain in zip(rigid.rows, two.rows, strict=True):
        assert ours.reciprocating == plain.reciprocating
        assert plain.lateral.force.major == 0.0
        assert ours.force.forward == close(
            plain.force.forward + ours.lateral.force.forward, abs=ROUND_OFF * ours.force_scale
        )
    # sin(beta) has a first order only when there is no offset; its part is S lambda w^2.
    leaning = in_line([0.0], MAIN)
    static = moving_masses(leaning)[0].lateral
    assert static == close(30.0 * 0.012)
    first = balance(leaning, SPEED).of(1).lateral.force
    assert first.major == close(static * 0.25 * SPEED**2, rel=1e-13)


def test_masses_are_shared_out_without_loss():
    engine = engine_with_everything()
    main, hinged = moving_masses(engine)[:2]
    assert main.reciprocating + main.rotating + hinged.reciprocating == close(
        20.0 + 30.0 + 18.0 + 12.0, rel=1e-15
    )
    assert hinged.rotating == 0.0
    at_pin = 12.0 * (1 - 0.11 / 0.30)
    assert main.lateral == close(30.0 * 0.012 + at_pin * 0.1 * math.sin(0.75))


def test_scales_of_what_counts_as_round_off():
    """All moving masses times R w^2, and that times the farthest cylinder's distance, or R."""
    engine = in_line([0.0, 2.0, 4.0])
    scale = 3 * 50.0 * 0.1 * SPEED**2
    for about, reach in ((None, 0.25), (0.1, 0.4), (-1.0, 1.5)):
        row = balance(engine, SPEED, about=about).rows[0]
        assert row.force_scale == close(scale, rel=1e-14)
        assert row.moment_scale == close(scale * reach, rel=1e-14)
    alone = balance(in_line([0.0]), SPEED).rows[0]
    assert alone.moment_scale == close(alone.force_scale * 0.1, rel=1e-14)


def test_moments_about_another_point():
    engine = engine_with_everything()
    here, there = balance(engine, SPEED, about=0.0), balance(engine, SPEED, about=2.0)
    for near, far in zip(here.rows, there.rows, strict=True):
        assert near.force == far.force
        assert far.moment.forward == close(
            near.moment.forward - 2j * near.force.forward, abs=ROUND_OFF * near.force_scale
        )


@pytest.mark.parametrize("ratio", [0.2, 0.9, 0.999])
def test_orders_are_free_of_aliasing(ratio):
    engine = one_cylinder(ratio)
    found = acceleration_orders(engine, 1, SPEED)
    angles = np.linspace(0.1, 6.0, 50)
    drive = SliderCrank(0.1, 0.1 / ratio)
    whole = -(SPEED**2) * drive.piston(angle_deg=np.degrees(angles)).second.real
    largest = np.max(
        np.abs(piston_acceleration(engine, 1, SPEED, angles_deg=np.degrees(np.linspace(0, 7, 500))))
    )
    np.testing.assert_array_equal(
        piston_acceleration(engine, 1, SPEED, angles_deg=np.degrees(angles)), whole
    )
    # The series meets the function between the samples, too, which folded orders would forbid; near
    # a dead mechanism cos(beta) comes down to 0.04, which makes round-off of 2e-14.
    np.testing.assert_allclose(
        found.at(crank_angle_deg=np.degrees(angles)), whole, rtol=0, atol=1e-13 * largest
    )


def test_samples_grow_with_the_orders():
    # Poisson's kernel has the orders q^|k| exactly.
    share = 0.95

    def kernel(angles):
        return (1 - share**2) / (1 - 2 * share * np.cos(angles) + share**2)

    found = turn_spectrum(kernel, 40)
    assert found.shape == (2048,)
    for order in (0, 1, -3, 40):
        # Where the kernel is largest, its divisor is 0.0025 as a difference of numbers of 1.9.
        assert complex(found[order]) == close(share ** abs(order), abs=1e-13)
    assert turn_spectrum(np.cos, 100).shape[-1] > 2 * 100


def test_counterweights():
    # A V of 90 deg: all of the first order turns with the shaft and can be canceled.
    cylinders = [
        EngineCylinder(
            0.2,
            20.0,
            STRAIGHT,
            crank_angle_deg=math.degrees(0.4),
            bank_angle_deg=math.degrees(bank),
        )
        for bank in (-math.pi / 4, math.pi / 4)
    ]
    vee = EngineLayout(0.1, cylinders, [1, 2], 2)
    weights = balancing_masses(vee, 0.5)
    assert [math.radians(weight.angle_deg) for weight in weights] == close([0.4 + math.pi] * 2)
    assert balance(replace(vee, rotating=weights), SPEED).of(1).force_balanced
    assert not balance(replace(vee, rotating=balancing_masses(vee)), SPEED).of(1).force_balanced
    # One cylinder: what is left turns against the shaft.
    single = in_line([0.0])
    left = balance(replace(single, rotating=balancing_masses(single, 0.5)), SPEED).of(1)
    assert left.force.sense == -1
    assert left.force.angle_deg is None
    moving = moving_masses(single)[0].reciprocating
    assert left.force.major == close(0.5 * moving * 0.1 * SPEED**2, rel=1e-13)
    # Rotating masses alone leave a line.
    left = balance(replace(single, rotating=balancing_masses(single)), SPEED).of(1)
    assert left.force.sense == 0
    # A hinged rod has no counterweight of its own.
    assert len(balancing_masses(engine_with_everything())) == 2


def test_effects_of_hinged_rods_are_those_of_whole_engines():
    engine = replace(engine_with_everything(), rotating=())
    found = hinged_rod_effects(engine, SPEED, (1, 2))
    plain = balance(engine, SPEED, (1, 2))
    cylinders = [
        replace(cylinder, rod=MAIN, piston_mass=20.0, pin_offset=0.01, slave_pin=None)
        for cylinder in engine.cylinders
    ]
    beside = replace(engine, cylinders=cylinders)
    # The main cylinders carry a share of the hinged rods, which the copies lack: compare by mass.
    ratio = moving_masses(engine)[0].reciprocating / moving_masses(beside)[0].reciprocating
    for effect, row, other in zip(found, plain.rows, balance(beside, SPEED).rows[:2], strict=True):
        ours, reference = row.reciprocating.force, other.reciprocating.force.times(ratio)
        for made, wanted in ((effect.hinged, ours), (effect.side_by_side, reference)):
            assert made.forward == close(wanted.forward, abs=ROUND_OFF * row.force_scale)
            assert made.backward == close(wanted.backward, abs=ROUND_OFF * row.force_scale)
    section = hinged_rod_effects(engine, SPEED, (2,), [3, 4])[0]
    assert section.hinged.major != close(found[1].hinged.major, rel=1e-3)


def test_change_of_a_hodograph():
    reference = Hodograph(2, 3.0, 1.0)
    change = hodograph_change(Hodograph(2, 3.0, 2.0).times(np.exp(1.7j)), reference)
    assert (change.major, change.minor) == (close(0.25), close(-0.5))
    assert change.turn_deg == close(math.degrees(1.7) - 180.0)
    line, circle = Hodograph(2, 1.0, 1.0), Hodograph(2, 1.0, 0.0)
    assert hodograph_change(reference, line).minor is None
    assert hodograph_change(reference, circle).turn_deg is None
    assert hodograph_change(reference, Hodograph(2, 0.0, 0.0)).major is None


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda e: balance(e, 0.0), "speed: given 0 rad/s"),
        (lambda e: balance(e, 1.0, (1, 1.5)), "orders: given"),
        (lambda e: balance(e, 1.0, model="three-mass"), "model: given 'three-mass'"),
        (lambda e: balance(e, 1.0, about=math.inf), "about: given inf"),
        (lambda e: balance(e, 1.0).of(3), "order: given 3; allowed are 1, 2, 4"),
        (lambda e: acceleration_orders(e, 4, 1.0), "cylinder: given 4; .* 1 to 3"),
        (lambda e: acceleration_orders(e, 1, 1.0, 0), "orders: given"),
        (lambda e: piston_acceleration(e, 1, 1.0, angles_deg=np.degrees([math.nan])), "angles"),
        (lambda e: balancing_masses(e, -0.1), "reciprocating_share"),
        (lambda e: hinged_rod_effects(e, 1.0), "none of which has a hinged rod"),
        (lambda _: balance(one_cylinder(1.0 - 1e-9), 1.0), "orders do not fade out"),
    ],
)
def test_what_is_refused(act, message):
    with pytest.raises(InputError, match=message):
        act(in_line([0.0, 2.0, 4.0]))


def test_cylinders_of_a_bank_in_one_place_have_no_balance():
    rod = ConnectingRod(0.2, 1.0, 0.07, 0.006)
    cylinders = [
        EngineCylinder(0.1, 1.0, rod, crank_angle_deg=math.degrees(angle))
        for angle in (0.0, math.pi)
    ]
    with pytest.raises(InputError, match="cylinder 2: position: given 0 m, where cylinder 1"):
        balance(EngineLayout(0.05, cylinders, [1, 2]), 100.0)
