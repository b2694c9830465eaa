"""Balance against the sum of mass times acceleration, and against the bearings' loads."""

import cmath
import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from dynamics.balance import (
    Hodograph,
    balance,
    balancing_masses,
    hinged_rod_effects,
    hodograph_change,
    moving_masses,
    order_vectors,
)
from dynamics.critical import major_orders
from dynamics.cycle import order_step
from dynamics.engine.forces import acceleration_orders, cylinder_motion, piston_acceleration
from dynamics.engine.layout import (
    EngineCylinder,
    EngineLayout,
    RotatingMass,
    SlavePin,
    firing_order_of_angles,
)
from dynamics.engine.rods import ConnectingRod
from dynamics.torque import engine_torque, leading_stars, star_diagram
from parts_in_a_line import cylinder as made_cylinder
from references import even_firing_angles
from refusals import refusals, refusals_of, refused
from small_engines import vee

ROUND_OFF = 1e-13
SPEED = 150.0
MAIN = ConnectingRod(0.40, 30.0, 0.13, 0.9, center_offset=0.012)
HINGED = ConnectingRod(0.30, 12.0, 0.11, 0.2, center_offset=-0.004)
STRAIGHT = ConnectingRod(0.40, 30.0, 0.13, 0.9)


def engine_with_everything():
    """Two throws with hinged rods, offsets, lateral centers, odd angles, and counterweights."""
    cylinders = []
    for number, (crank, place) in enumerate(((0.3, 0.1), (2.0, 0.5))):
        main = made_cylinder(
            0.2, 20.0, MAIN, math.degrees(crank), math.degrees(-0.35), place, pin_offset=0.01
        )
        hinged = made_cylinder(
            0.2,
            18.0,
            HINGED,
            math.degrees(crank),
            math.degrees(0.45),
            place,
            pin_offset=-0.006,
            slave_pin=SlavePin(2 * number + 1, 0.1, angle_deg=math.degrees(0.75)),
        )
        cylinders += [main, hinged]
    weights = [
        RotatingMass(1.5, angle_deg=math.degrees(2.5), position=0.0),
        RotatingMass(2.0, angle_deg=math.degrees(-1.0), position=0.6),
    ]
    return EngineLayout(0.1, cylinders, [1, 2, 3, 4], 2, rotating=weights)


def in_line(cranks, rod=STRAIGHT, pitch=0.25):
    cylinders = [
        made_cylinder(0.2, 20.0, rod, math.degrees(crank), 0.0, place * pitch)
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


def test_counterweights():
    # A V of 90 deg: all of the first order turns with the shaft and can be canceled.
    cylinders = [
        made_cylinder(0.2, 20.0, STRAIGHT, math.degrees(0.4), math.degrees(bank))
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


def test_change_of_a_hodograph():
    reference = Hodograph(2, 3.0, 1.0)
    change = hodograph_change(Hodograph(2, 3.0, 2.0).times(np.exp(1.7j)), reference)
    assert (change.major, change.minor) == (close(0.25), close(-0.5))
    assert change.turn_deg == close(math.degrees(1.7) - 180.0)
    line, circle = Hodograph(2, 1.0, 1.0), Hodograph(2, 1.0, 0.0)
    assert hodograph_change(reference, line).minor is None
    assert hodograph_change(reference, circle).turn_deg is None
    assert hodograph_change(reference, Hodograph(2, 0.0, 0.0)).major is None


def test_a_radial_engine_has_no_round_off_in_what_cancels():
    main = ConnectingRod(length=0.33, mass=7.0, center_distance=0.07, inertia=0.1)
    slave = ConnectingRod(length=0.262, mass=1.6, center_distance=0.1, inertia=0.02)
    banks = [40.0 * number for number in range(9)]
    rods = [EngineCylinder(0.155, 2.6, main)]
    rods += [
        EngineCylinder(
            0.155, 2.6, slave, bank_angle_deg=bank, slave_pin=SlavePin(1, 0.068, angle_deg=bank)
        )
        for bank in banks[1:]
    ]
    radial = EngineLayout(0.087, rods, [1, 3, 5, 7, 9, 2, 4, 6, 8])
    assert moving_masses(radial)[0].lateral == 0.0
    (second,) = hinged_rod_effects(radial, SPEED, (2,))
    # Nine equal rods in a star have no second order, which nothing is a share of.
    assert second.side_by_side.major == 0.0
    change = hodograph_change(second.hinged, second.side_by_side)
    assert (change.major, change.minor, change.turn_deg) == (None, None, None)


test_what_is_refused = refusals_of(
    lambda act: act(in_line([0.0, 2.0, 4.0])),
    (lambda e: balance(e, 0.0), "speed"),
    (lambda e: balance(e, 1.0, (1, 1.5)), "orders"),
    (lambda e: balance(e, 1.0, model="three-mass"), "model"),
    (lambda e: balance(e, 1.0, about=math.inf), "about"),
    (lambda e: balance(e, 1.0).of(3), "order"),
    (lambda e: acceleration_orders(e, 4, 1.0), "cylinder"),
    (lambda e: acceleration_orders(e, 1, 1.0, 0), "orders"),
    (lambda e: piston_acceleration(e, 1, 1.0, angles_deg=[math.nan]), "angles_deg[0]"),
    (lambda e: balancing_masses(e, -0.1), "reciprocating_share"),
    (lambda e: hinged_rod_effects(e, 1.0), "cylinders"),
    (lambda _: balance(one_cylinder(1.0 - 1e-9), 1.0), "orders"),
)


def test_cylinders_of_a_bank_in_one_place_have_no_balance():
    rod = ConnectingRod(0.2, 1.0, 0.07, 0.006)
    cylinders = [
        EngineCylinder(0.1, 1.0, rod, crank_angle_deg=math.degrees(angle))
        for angle in (0.0, math.pi)
    ]
    with refused("position"):
        balance(EngineLayout(0.05, cylinders, [1, 2]), 100.0)


FOUR = np.degrees(even_firing_angles((1, 3, 4, 2)))


@given(st.permutations(range(1, 7)), st.sampled_from((2, 4)))
@settings(max_examples=20, deadline=None)
def test_even_firing_has_the_multiples_of_ignitions_per_turn_as_majors(order, strokes):
    angles = even_firing_angles(order, strokes)
    stars = star_diagram(firing_angles_deg=np.degrees(angles), strokes=strokes)
    majors = [star.order for star in stars if star.kind == "major"]
    per_turn = 6 * order_step(strokes)
    assert majors == list(np.arange(per_turn, 12.1, per_turn))
    assert majors == major_orders([star.order for star in stars], angles).tolist()
    assert {star.kind for star in stars} == {"major", "balanced"}


def test_uneven_firing_names_the_strongest_order():
    """A two-cylinder engine with cranks in one direction less 90 deg: fires at 0 and 450 deg.

    |1 + exp(i k 450 deg)| = 2 |cos(k 225 deg)|: 2 only from order 4 on; below, cos(2.5 * 225 deg)
    and cos(1.5 * 225 deg) = cos(337.5 deg) are the largest.
    """
    stars = star_diagram(firing_angles_deg=[0.0, 450.0], orders=3.5)
    assert all(star.kind != "major" for star in stars)
    found = leading_stars(stars)
    assert [star.order for star in found] == [1.5, 2.5]
    assert found[0].share == close(math.cos(math.radians(22.5)))
    assert [
        star.order
        for star in leading_stars(star_diagram(firing_angles_deg=[0.0, 450.0], orders=4.0))
    ] == [4.0]


def test_stars_with_each_cylinders_own_harmonics_sum_to_the_engines():
    """Hinged rods: amplitudes and phases differ, and the resultant is the engine's harmonic."""
    engine = vee(True)
    forces = 1e4 * np.random.default_rng(5).random((4, 48))
    torque = engine_torque(engine, 100.0, forces, samples=48)
    own = [torque.cylinder_harmonics(number) for number in (1, 2, 3, 4)]
    whole = torque.harmonics()
    # Not the half sampling rate, where the phase is not that of a shifted wave.
    stars = star_diagram(
        engine,
        whole.orders[:-1],
        amplitudes=np.array([each.amplitude[:-1] for each in own]).T,
        phases_deg=np.degrees(np.array([each.phase[:-1] for each in own]).T),
    )
    largest = np.max(whole.amplitude)
    found = [
        star.resultant * np.exp(-1j * math.radians(star.resultant_direction_deg)) for star in stars
    ]
    wanted = (whole.amplitude * np.exp(1j * whole.phase))[:-1]
    assert np.array(found) == close(wanted, abs=1e-12 * largest)
    assert len({round(float(weight), 6) for weight in stars[0].weights}) == 4


def test_balanced_orders_have_no_direction():
    assert (
        math.radians(star_diagram(firing_angles_deg=FOUR, orders=[1.0])[0].resultant_direction_deg)
        == 0.0
    )


test_refusals = refusals_of(
    lambda arguments: star_diagram(**arguments),
    ({"firing_angles_deg": [], "orders": 4.0}, "firing_angles_deg"),
    ({"firing_angles_deg": FOUR, "orders": [0.0]}, "orders[0]"),
    ({"firing_angles_deg": FOUR, "orders": 0.1}, "highest"),
    ({"engine": vee(True), "orders": [1.0, 0.7]}, "orders[1]"),
    ({"engine": FOUR}, "engine"),
    ({"engine": vee(True), "firing_angles_deg": FOUR}, "engine"),
)


test_strokes_that_do_not_fit_are_refused = refusals_of(
    lambda engine, orders, strokes: star_diagram(**engine, orders=orders, strokes=strokes),
    ({"firing_angles_deg": FOUR}, 4.0, 0, "strokes"),
    ({"firing_angles_deg": FOUR}, [1.0], 3, "strokes"),
    ({"firing_angles_deg": FOUR}, [0.5], 2, "orders[0]"),
    ({"engine": vee(True)}, 4.0, 0, "strokes"),
    ({"engine": vee(True)}, 4.0, 2, "strokes"),
)


def test_no_order_leads_where_all_are_balanced():
    stars = star_diagram(firing_angles_deg=np.arange(6) * 60.0, orders=4.0, strokes=2)
    assert {star.kind for star in stars} == {"balanced"}
    assert leading_stars(stars) == ()


def test_sense_and_points():
    forward, backward = Hodograph(1, 2.0, 1.0), Hodograph(2, 1.0, 2j)
    assert (forward.sense, backward.sense) == (1, -1)
    for shape in (forward, backward):
        x, y = shape.points(721)
        # Seen from the flywheel, x to the right, the shaft turns counterclockwise: positive area.
        area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
        # The polygon of 720 points has 1 - (2 pi / 720)^2 / 6 of the ellipse's area.
        assert area == close(shape.sense * math.pi * shape.major * shape.minor, rel=1.3e-5)
        assert np.max(np.abs(x)) <= shape.x * (1 + 1e-14)
        assert np.max(np.abs(y)) <= shape.y * (1 + 1e-14)


def test_shapes_without_two_axes():
    line = Hodograph(2, 100 * cmath.exp(-0.5j * math.pi), 100 * cmath.exp(-0.5j * math.pi))
    assert line.sense == 0
    assert line.angle_deg == 90.0  # a horizontal axis is written +90 deg
    assert (line.x, line.y) == (close(200.0), close(0.0, abs=1e-13))
    circle = Hodograph(1, 0.0, 3j)
    assert (circle.angle_deg, circle.largest_at_deg, circle.sense) == (None, None, -1)
    point = Hodograph(1, 0.0, 0.0)
    assert (point.angle_deg, point.largest_at_deg, point.sense, point.major) == (None, None, 0, 0.0)


test_hodographs_refused = refusals_of(
    lambda given: Hodograph(*given),
    ((0, 1.0, 1.0), "orders"),
    ((1.5, 1.0, 1.0), "orders"),
    ((-1, 1.0, 1.0), "orders"),
    ((1, math.nan, 1.0), "forward"),
    ((1, 1.0, complex(0.0, math.inf)), "backward"),
)


test_what_is_refused_hodograph = refusals_of(
    lambda vectors, orders: order_vectors(vectors, orders),
    ([1.0, 2.0, 3.0, 4.0], [2], "orders"),
    ([1.0, math.nan, 3.0, 4.0], [1], "vectors"),
    ([[1.0, 2.0]], [1], "vectors"),
    ([1.0, 2.0, 3.0, 4.0], [0.5], "orders"),
    ([1.0, 2.0, 3.0, 4.0], [], "orders"),
    ([1.0, 2.0, 3.0, 4.0], [1, 1], "orders"),
)


test_refused = refusals(
    ("mode_shape", lambda: star_diagram(firing_angles_deg=FOUR, orders=4.0, mode_shape=[1.0, 2.0])),
    ("stars", lambda: leading_stars([])),
)
