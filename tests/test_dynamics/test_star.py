import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.critical import major_orders, vector_sums
from dynamics.cycle import order_step
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.torque.star import leading_stars, same_stars, star_diagram
from dynamics.torque.torque import engine_torque
from references import even_firing_angles

FOUR = np.degrees(even_firing_angles((1, 3, 4, 2)))
SIX = np.degrees(even_firing_angles((1, 5, 3, 6, 2, 4)))


def test_stars_of_the_in_line_six():
    stars = star_diagram(firing_angles_deg=SIX, orders=6.0)
    assert [star.order for star in stars if star.kind == "major"] == [3.0, 6.0]
    assert {star.kind for star in stars} == {"major", "balanced"}
    groups = [[star.order for star in group] for group in same_stars(stars)]
    assert groups == [[0.5, 2.5, 3.5, 5.5], [1.0, 2.0, 4.0, 5.0], [1.5, 4.5], [3.0, 6.0]]
    # Order 1: three directions 120 deg apart, cylinders 1 and 6, 2 and 5, 3 and 4 together.
    first = np.radians(stars[1].directions_deg)
    assert np.degrees(first) == close([0.0, 120.0, 240.0, 240.0, 120.0, 0.0])
    assert [star.order for star in leading_stars(stars)] == [3.0, 6.0]


def test_resultants_are_the_vector_sums():
    orders = np.arange(0.5, 8.5, 0.5)
    angles = [0.0, 1.0, 2.5, 4.0, 4.2]
    shape = [1.0, 0.6, 0.1, -0.4, -0.8]
    for weights in (None, shape):
        stars = star_diagram(
            firing_angles_deg=np.degrees(angles), orders=orders, mode_shape=weights
        )
        sums = vector_sums(orders, angles, weights)
        assert [star.resultant for star in stars] == close(sums)


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


def test_mode_shape_turns_majors_into_minors():
    """The one-node mode of the in-line four, antisymmetric: order 2 cancels, half orders do not."""
    stars = star_diagram(firing_angles_deg=FOUR, orders=4.0, mode_shape=[1.0, 0.4, -0.4, -1.0])
    kinds = {star.order: star.kind for star in stars}
    assert kinds[2.0] == kinds[4.0] == "balanced"
    assert kinds[0.5] == "minor"
    assert stars[0].largest == close(2.8)


def hinged_vee():
    rod = ConnectingRod(0.25, 2.0, 0.08, 0.02)
    slave = ConnectingRod(0.18, 1.2, 0.07, 0.008)
    cylinders = []
    for throw, crank in enumerate((0.0, math.pi)):
        main = EngineCylinder(
            0.12,
            3.0,
            rod,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=-30.0,
            position=0.2 * throw,
        )
        pin = SlavePin(2 * throw + 1, 0.06, angle_deg=60.0)
        hinged = EngineCylinder(
            0.12,
            2.8,
            slave,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=30.0,
            position=0.2 * throw,
            slave_pin=pin,
        )
        cylinders += [main, hinged]
    return EngineLayout(0.07, cylinders, [1, 2, 3, 4])


def test_stars_with_each_cylinders_own_harmonics_sum_to_the_engines():
    """Hinged rods: amplitudes and phases differ, and the resultant is the engine's harmonic."""
    engine = hinged_vee()
    forces = 1e4 * np.random.default_rng(5).random((4, 48))
    torque = engine_torque(engine, 100.0, forces, samples=48)
    own = [torque.cylinder_harmonics(number) for number in (1, 2, 3, 4)]
    whole = torque.harmonics()
    # Not the half sampling rate, where the phase is not that of a shifted wave.
    orders = whole.orders[:-1]
    stars = star_diagram(
        engine,
        orders,
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


def test_an_engine_gives_its_own_orders_and_firing_angles():
    engine = hinged_vee()
    stars = star_diagram(engine, 2.0)
    assert [star.order for star in stars] == [0.5, 1.0, 1.5, 2.0]
    assert np.radians(stars[1].directions_deg) == close(
        np.mod(np.radians(engine.firing_deg), 2.0 * np.pi)
    )


def test_balanced_orders_have_no_direction():
    assert (
        math.radians(star_diagram(firing_angles_deg=FOUR, orders=[1.0])[0].resultant_direction_deg)
        == 0.0
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"firing_angles_deg": [], "orders": 4.0}, "firing_angles_deg: given none; .*because"),
        ({"firing_angles_deg": FOUR, "orders": [0.0]}, r"orders\[0\]: given 0"),
        ({"firing_angles_deg": FOUR, "orders": 0.1}, "highest: given 0.1"),
        (
            {"engine": hinged_vee(), "orders": [1.0, 0.7]},
            r"orders\[1\]: given 0.7; allowed are multiples of 0.5, because",
        ),
        ({"engine": FOUR}, "engine: given ndarray with firing_angles_deg left out; .*because"),
        ({"engine": hinged_vee(), "firing_angles_deg": FOUR}, "engine: given EngineLayout with"),
    ],
)
def test_refusals(arguments, message):
    with pytest.raises(InputError, match=message):
        star_diagram(**arguments)


@pytest.mark.parametrize(
    ("engine", "orders", "strokes", "message"),
    [
        ({"firing_angles_deg": FOUR}, 4.0, 0, "strokes: given 0; allowed are 2 and 4"),
        ({"firing_angles_deg": FOUR}, [1.0], 3, "strokes: given 3; allowed are 2 and 4"),
        (
            {"firing_angles_deg": FOUR},
            [0.5],
            2,
            r"orders\[0\]: given 0.5; allowed are multiples of 1, because",
        ),
        ({"engine": hinged_vee()}, 4.0, 0, "strokes: given 0; allowed are 2 and 4"),
        ({"engine": hinged_vee()}, 4.0, 2, "strokes: given 2; allowed is 4 or nothing, because"),
    ],
)
def test_strokes_that_do_not_fit_are_refused(engine, orders, strokes, message):
    with pytest.raises(InputError, match=message):
        star_diagram(**engine, orders=orders, strokes=strokes)


def test_strokes_may_be_said():
    assert [star.order for star in star_diagram(hinged_vee(), 1.0, strokes=4)] == [0.5, 1.0]
    assert [star.order for star in star_diagram(firing_angles_deg=FOUR, orders=2.0, strokes=2)] == [
        1.0,
        2.0,
    ]
    assert [
        star.order for star in star_diagram(firing_angles_deg=FOUR, orders=[1.5], strokes=4)
    ] == [1.5]


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match=r"mode_shape: given an array of shape .*because"):
        star_diagram(firing_angles_deg=FOUR, orders=4.0, mode_shape=[1.0, 2.0])
    with pytest.raises(InputError, match="stars: given none"):
        leading_stars([])


def test_no_order_leads_where_all_are_balanced():
    stars = star_diagram(firing_angles_deg=np.arange(6) * 60.0, orders=4.0, strokes=2)
    assert {star.kind for star in stars} == {"balanced"}
    assert leading_stars(stars) == ()
