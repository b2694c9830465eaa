"""Layouts of engines: firing angles by hand, and everything that is refused with its reason."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.forces import cylinder_motion, piston_ends, piston_position
from dynamics.engine.layout import (
    IN_LINE,
    EngineCylinder,
    EngineLayout,
    RotatingMass,
    SlavePin,
    firing_angles_of_order,
    firing_intervals,
    firing_order_of_angles,
)
from dynamics.engine.rods import ConnectingRod, SliderCrank
from refusals import refusals, refusals_of, refused

ROD = ConnectingRod(0.265, 5.0, 0.097, 0.069)
SHORT = ConnectingRod(0.065, 5.0, 0.03, 0.005)


def cylinder(crank=0.0, bank=0.0, **more):
    given = {"bore": 0.13, "piston_mass": 4.0, "rod": ROD, **more}
    return EngineCylinder(crank_angle_deg=crank, bank_angle_deg=bank, **given)


def in_line(*cranks):
    return [cylinder(crank) for crank in cranks]


def degrees(angles):
    return np.degrees(angles).tolist()


@pytest.mark.parametrize(
    ("cranks", "order", "strokes", "wanted"),
    [
        ((0, 180, 180, 0), (1, 3, 4, 2), 4, (0, 540, 180, 360)),
        ((0, 180, 180, 0), (1, 2, 4, 3), 4, (0, 180, 540, 360)),
        ((0, 240, 120, 120, 240, 0), (1, 5, 3, 6, 2, 4), 4, (0, 480, 240, 600, 120, 360)),
        ((0, 240, 120), (1, 2, 3), 2, (0, 120, 240)),
        # Two cylinders side by side on one crank, 360 deg apart, and a twin with a pause.
        ((0, 0), (1, 2), 4, (0, 360)),
        ((0, 180), (1, 2), 4, (0, 180)),
        ((90,), (1,), 4, (270,)),
    ],
)
def test_firing_angles_in_line(cranks, order, strokes, wanted):
    engine = EngineLayout(0.07, in_line(*cranks), order, strokes)
    assert degrees(np.radians(engine.firing_deg)) == close(wanted, abs=1e-9)
    assert engine.cycle_deg == close(180.0 * strokes)
    assert firing_order_of_angles(np.radians(engine.firing_deg), strokes, order[0]) == order


@settings(max_examples=20, deadline=None)
@given(st.permutations(range(1, 6)), st.floats(0.0, 6.0))
def test_firing_angles_of_even_cranks_follow_the_order(order, start):
    """Any order over even intervals: cranks set so that cylinder order[j] fires at j * 144 deg."""
    tops = [0.0] * 5
    for place, number in enumerate(order):
        tops[number - 1] = math.fmod(start + math.radians(144.0 * place), 2.0 * math.pi)
    angles = firing_angles_of_order(order, tops, 4)
    assert firing_order_of_angles(angles, 4, order[0]) == tuple(order)
    for place, number in enumerate(order):
        later = angles[number - 1] - angles[order[0] - 1]
        assert math.degrees(later) == close(144.0 * place, abs=1e-3)
        assert math.remainder(angles[number - 1] - tops[number - 1], 2.0 * math.pi) == (
            close(0.0, abs=1e-9)
        )


def test_firing_angles_may_be_given():
    engine = EngineLayout(0.07, in_line(0, 0), [1, 2], firing_angles_deg=[720.0, 360.0])
    assert engine.firing_deg == (720.0, 360.0)
    assert engine.main_of(2) == 2


@pytest.mark.parametrize("apart", [1e-9, -1e-9])
def test_tops_that_differ_by_round_off_are_a_turn_apart(apart):
    """Two cranks in one direction in a four-stroke engine: the second fires 360 deg later."""
    angles = firing_angles_of_order([1, 2], [0.0, apart], 4)
    assert angles == close((0.0, 2.0 * math.pi + apart), abs=1e-12)


FIRED_1342 = np.radians([0.0, 540.0, 180.0, 360.0])


@pytest.mark.parametrize("order", [(1, 2, 3, 4), (1, 2, 4, 3), (1, 4, 3, 2)])
@pytest.mark.parametrize("later", [0.0, 100.0 * math.pi])
def test_an_order_against_the_firing_angles_is_refused(order, later):
    angles = FIRED_1342 + np.array([later, 0.0, 0.0, 0.0])
    words = rf"given \[{order[0]}, .*; allowed is \[1, 3, 4, 2\], because the firing angles"
    with pytest.raises(InputError, match=words):
        EngineLayout(0.07, in_line(0, 180, 180, 0), order, firing_angles_deg=np.degrees(angles))


def test_all_may_fire_together():
    engine = EngineLayout(0.07, in_line(0, 0, 0), [3, 1, 2], firing_angles_deg=[0.0, 0.0, 0.0])
    assert engine.firing_order == (3, 1, 2)


@pytest.mark.parametrize(
    "make",
    [
        lambda off: EngineLayout(0.07, in_line(0), [1], firing_angles_deg=np.degrees([off])),
        lambda off: EngineLayout(0.07, [cylinder(), hinged_to(1, crank=math.degrees(off))], [1, 2]),
    ],
)
def test_angles_count_as_in_line_within_round_off_of_degrees(make):
    make(0.9 * IN_LINE)
    with pytest.raises(InputError):
        make(1e-5)
    assert IN_LINE == 1e-6


def test_a_layout_keeps_what_was_checked():
    """Lists given are copied into tuples: what is appended later stays out, and it can be hashed."""
    cylinders, order, angles = in_line(0, 180), [1, 2], [0.0, 180.0]
    rotating = [RotatingMass(0.1, angle_deg=0.0)]

    def made(kind):
        options = {"firing_angles_deg": kind(angles), "rotating": kind(rotating)}
        return EngineLayout(0.07, kind(cylinders), kind(order), shaft_inertia=1.0, **options)

    engine, same = made(lambda values: values), made(tuple)
    for values in (cylinders, order, rotating, angles):
        values.append(values[0])
    assert engine == same
    assert hash(engine) == hash(same)
    assert len(engine.cylinders) == len(engine.firing_deg) == 2
    assert len(engine.rotating) == 1
    by_numpy = EngineLayout(0.07, in_line(0, 180), np.array([1, 2]))
    assert [type(number) for number in by_numpy.firing_order] == [int, int]


def test_a_pistons_place_is_asked_by_a_whole_number():
    engine = EngineLayout(0.07, in_line(0, 180), [1, 2])
    assert piston_position(engine, np.int64(2))(np.zeros(1)) == close(0.335)
    for number in (1.5, 0, 3, True):
        with refused("cylinder"):
            piston_position(engine, number)


def test_one_cylinder_of_an_engine_moves_as_a_slider_crank():
    engine = EngineLayout(0.07, [cylinder(30.0, -45.0, pin_offset=0.01)], [1])
    drive = SliderCrank(0.07, 0.265, 0.01)
    angles = np.linspace(0.0, 6.0, 9)
    motion, alone = (
        cylinder_motion(engine, 1, shaft_angles_deg=np.degrees(angles)),
        drive.piston(angle_deg=np.degrees(angles + math.radians(75.0))),
    )
    for name in ("place", "first", "second"):
        ours, wanted = getattr(motion.piston, name), getattr(alone, name)
        np.testing.assert_allclose(ours, wanted, rtol=0.0, atol=1e-15)
    lowest, highest = piston_ends(engine, 1)
    assert highest == close(drive.top, abs=1e-14)
    assert highest - lowest == close(drive.stroke, abs=1e-14)
    travel = drive.travel(angle_deg=np.degrees(angles + math.radians(75.0))).place.real
    np.testing.assert_allclose(highest - motion.piston.place.real, travel, rtol=0.0, atol=1e-14)


def hinged_to(main, crank=0.0, **pin):
    return cylinder(
        crank,
        40.0,
        slave_pin=SlavePin(main, **{"radius": 0.06, "angle_deg": math.degrees(0.7), **pin}),
    )


test_bad_layouts_are_refused_with_the_reason = refusals_of(
    lambda parts, order, more: EngineLayout(
        **{"crank_radius": 0.07, "cylinders": parts, "firing_order": order, **more}
    ),
    (in_line(0, 0, 0), [1, 2, 2], {}, "firing_order"),
    (in_line(0, 0, 0), [1, 2], {}, "firing_order"),
    (in_line(0, 0), [1, 3], {}, "firing_order"),
    (in_line(0, 0), [0, 1], {}, "firing_order"),
    (in_line(0, 0), [1, 2, 1], {}, "firing_order"),
    (in_line(0, 0), [True, 2], {}, "firing_order"),
    (in_line(0, 0), [1, 2.0], {}, "firing_order"),
    (in_line(0, 0), ["1", 2], {}, "firing_order"),
    (in_line(0, 180, 180, 0), [1, 4, 3, 2], {}, "firing_order"),
    (in_line(0, 0), [1, 2], {"strokes": 2}, "firing_order"),
    (in_line(0), [1], {"strokes": 3}, "strokes"),
    ([], [], {}, "cylinders"),
    (in_line(0), [1], {"crank_radius": 0.0}, "crank_radius"),
    (in_line(0), [1], {"shaft_inertia": -1.0}, "shaft_inertia"),
    ([cylinder(rod=SHORT)], [1], {}, "crank_radius"),
    ([cylinder(pin_offset=-0.2)], [1], {}, "crank_radius"),
    ([hinged_to(1)], [1], {}, "slave pin"),
    ([cylinder(), hinged_to(3)], [1, 2], {}, "slave pin"),
    ([cylinder(), hinged_to(0)], [1, 2], {}, "slave pin"),
    ([cylinder(), hinged_to(1), hinged_to(2)], [1, 2, 3], {}, "slave pin"),
    ([cylinder(), hinged_to(1, crank=90.0)], [1, 2], {}, "crank_angle_deg"),
    ([cylinder(position=0.1), hinged_to(1)], [1, 2], {}, "position"),
    ([cylinder(), hinged_to(1, radius=0.265)], [1, 2], {}, "slave pin radius"),
    (
        [cylinder(), hinged_to(1, radius=0.26, angle_deg=math.degrees(-0.9))],
        [1, 2],
        {},
        "rod length",
    ),
    (in_line(0, 0), [1, 2], {"firing_angles_deg": [0.0]}, "firing_angles_deg"),
    (in_line(0, 180), [1, 2], {"firing_angles_deg": [0.0, 0.0]}, "firing_angles_deg"),
)


@pytest.mark.parametrize(("strokes", "total"), [(2, 2.0), (4, 4.0)])
def test_firing_intervals_are_one_cycle_together(strokes, total):
    steps = firing_intervals([0.5, 0.1, 3.0], strokes)
    assert steps[:2] == close((0.4, 2.5))
    assert sum(steps) == close(total * np.pi)


def test_a_firing_order_may_be_text():
    engine = EngineLayout(0.07, in_line(0, 180, 180, 0), "1-3-4-2")
    assert engine == EngineLayout(0.07, in_line(0, 180, 180, 0), [1, 3, 4, 2])


test_refused = refusals(
    ("bore", lambda: cylinder(bore=0.0)),
    ("crank_angle_deg", lambda: cylinder(crank=math.inf)),
    ("slave pin main_cylinder", lambda: SlavePin(1.0, 0.06, angle_deg=math.degrees(0.7))),
    ("slave pin main_cylinder", lambda: SlavePin("1", 0.06, angle_deg=math.degrees(0.7))),
    ("slave pin radius", lambda: SlavePin(1, 0.0, angle_deg=math.degrees(0.7))),
    ("static_moment", lambda: RotatingMass(-0.1, angle_deg=0.0)),
    ("angle_deg", lambda: RotatingMass(0.1, angle_deg=math.nan)),
    ("rod", lambda: EngineCylinder(0.1, 1.0, "rod")),
    ("firing_order", lambda: EngineLayout(0.07, in_line(0, 180, 180, 0), "1;3;4;2")),
)
