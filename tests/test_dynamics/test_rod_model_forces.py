"""What the four rod models share and where they part, pressures, groups, and what is refused.

Sums of a dozen terms of the largest force's size: 1e-12 of it is round-off with room.
"""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.engine import ROD_MODELS
from dynamics.engine.forces import gas_forces, mechanism_forces, pin_groups, summed
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.motions import cylinder_motion
from dynamics.engine.rods import ConnectingRod

SPEED, GAIN = 220.0, 9000.0
ANGLES = np.linspace(0.0, 4.0 * math.pi, 24, endpoint=False)
GAS = np.array([30e3 * (1.2 + np.cos(ANGLES / 2.0)), 20e3 * (1.1 + np.sin(ANGLES / 2.0))])
RUB = np.array([400.0 * np.sin(ANGLES), -300.0 * np.cos(ANGLES)])
FORCES = ("side", "piston_pin", "foot", "crankpin")


def largest(values):
    return np.max(np.abs(values))


def single(rod, **more):
    return EngineLayout(0.07, [EngineCylinder(0.13, 4.0, rod, **more)], [1])


def test_without_lateral_offset_three_masses_are_the_rigid_rod_and_two_are_not():
    """Requirement: 1e-12 between three masses and the rigid rod; two masses alone are 3.7 % of the
    largest side force and 0.8 % of the largest crankpin force off."""
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069))
    found = {
        name: mechanism_forces(
            engine,
            SPEED,
            GAS[0],
            model=name,
            crank_acceleration=GAIN,
            shaft_angles_deg=np.degrees(ANGLES),
        )
        for name in ROD_MODELS
    }
    size = largest(found["rigid"].foot)
    for name in ("three-mass", "two-mass with inertia"):
        for part in FORCES:
            ours, wanted = getattr(found[name], part), getattr(found["rigid"], part)
            np.testing.assert_allclose(ours, wanted, rtol=0.0, atol=1e-12 * size)
    static, rigid = found["two-mass"], found["rigid"]
    side, pin = (largest(getattr(static, n) - getattr(rigid, n)) for n in ("side", "crankpin"))
    assert side / largest(rigid.side) == close(0.0370, abs=5e-5)
    assert pin / largest(rigid.crankpin) == close(0.0084, abs=5e-5)


def test_with_lateral_offset_only_the_rigid_rod_is_the_rigid_rod():
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009))
    found = {
        name: mechanism_forces(engine, SPEED, model=name, shaft_angles_deg=np.degrees(ANGLES))
        for name in ROD_MODELS
    }
    size = largest(found["rigid"].crankpin)
    for name in ROD_MODELS[1:]:
        apart = largest(found[name].crankpin - found["rigid"].crankpin)
        assert apart > 0.01 * size


def test_a_static_pair_is_enough_for_the_inertia_that_it_has():
    """J = M l_shk l_shp: all four models are one."""
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 5.0 * 0.097 * 0.168))
    rigid = mechanism_forces(engine, SPEED, GAS[0], shaft_angles_deg=np.degrees(ANGLES)).crankpin
    for name in ROD_MODELS[1:]:
        other = mechanism_forces(
            engine, SPEED, GAS[0], model=name, shaft_angles_deg=np.degrees(ANGLES)
        ).crankpin
        np.testing.assert_allclose(other, rigid, rtol=0.0, atol=1e-12 * largest(rigid))


def test_a_rod_without_mass_gives_the_forces_of_the_textbook():
    """N = P tan b, T = P sin(a + b) / cos b, Z = P cos(a + b) / cos b, P towards the shaft."""
    engine = single(ConnectingRod(0.265, 1e-12, 0.097, 1e-14))
    forces = mechanism_forces(
        engine, SPEED, GAS[0], friction=700.0, shaft_angles_deg=np.degrees(ANGLES)
    )
    drive = cylinder_motion(engine, 1, shaft_angles_deg=np.degrees(ANGLES))
    push = GAS[0] - 700.0 + 4.0 * SPEED**2 * drive.piston.second.real
    lean = np.arcsin(0.07 / 0.265 * np.sin(ANGLES))
    size = largest(push)
    for ours, wanted in (
        (forces.side[0], push * np.tan(lean)),
        (forces.tangential[0], push * np.sin(ANGLES + lean) / np.cos(lean)),
        (forces.radial[0], push * np.cos(ANGLES + lean) / np.cos(lean)),
        (forces.torque[0], 0.07 * push * np.sin(ANGLES + lean) / np.cos(lean)),
    ):
        np.testing.assert_allclose(ours, wanted, rtol=0.0, atol=1e-11 * size)
    np.testing.assert_array_equal(forces.gas, [GAS[0]])


def test_a_rod_hinged_at_the_crankpin_stands_beside_the_main_rod():
    """With the slave pin at 1e-9 m what the main rod's wall adds is gone, to 1e-9 / 0.265."""
    rod = ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009)
    left, right = (
        EngineCylinder(0.13, 4.0, rod),
        EngineCylinder(0.13, 4.0, rod, bank_angle_deg=math.degrees(0.8)),
    )
    at_pin = EngineCylinder(
        0.13,
        4.0,
        rod,
        bank_angle_deg=math.degrees(0.8),
        slave_pin=SlavePin(1, 1e-9, angle_deg=math.degrees(0.8)),
    )
    side_by_side = EngineLayout(0.07, [left, right], [1, 2])
    hinged = EngineLayout(0.07, [left, at_pin], [1, 2])
    ours, theirs = (
        mechanism_forces(e, SPEED, GAS, friction=RUB, shaft_angles_deg=np.degrees(ANGLES))
        for e in (side_by_side, hinged)
    )
    size = largest(ours.foot)
    np.testing.assert_allclose(theirs.crankpin, ours.crankpin, rtol=0.0, atol=1e-7 * size)
    assert pin_groups(side_by_side) == ((1,), (2,))
    assert pin_groups(hinged) == ((1, 2),)


def test_groups_name_the_main_cylinder_first():
    rod = ConnectingRod(0.265, 5.0, 0.097, 0.069)
    hinged = EngineCylinder(
        0.13,
        4.0,
        rod,
        bank_angle_deg=math.degrees(0.8),
        slave_pin=SlavePin(2, 0.06, angle_deg=math.degrees(-0.8)),
    )
    engine = EngineLayout(
        0.07, [hinged, EngineCylinder(0.13, 4.0, rod, bank_angle_deg=math.degrees(1.6))], [1, 2]
    )
    assert pin_groups(engine) == ((2, 1),)
    forces = mechanism_forces(engine, SPEED, GAS, shaft_angles_deg=np.degrees(ANGLES))
    np.testing.assert_allclose(summed(forces, (2, 1)), forces.crankpin.sum(axis=0), rtol=1e-14)


def test_speed_and_acceleration_may_change_from_angle_to_angle():
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009))
    speeds, gains = np.linspace(100.0, 200.0, 24), np.linspace(-3e3, 5e3, 24)
    whole = mechanism_forces(
        engine, speeds, GAS[0], crank_acceleration=gains, shaft_angles_deg=np.degrees(ANGLES)
    )
    for place in (0, 11):
        one = mechanism_forces(
            engine,
            float(speeds[place]),
            float(GAS[0, place]),
            crank_acceleration=float(gains[place]),
            shaft_angles_deg=np.degrees(ANGLES[place : place + 1]),
        )
        assert whole.crankpin[0, place] == close(one.crankpin[0, 0], rel=1e-14)


def test_each_cylinder_takes_its_pressure_from_its_own_firing_top():
    class Rising:
        strokes = 4

        def at(self, *, angle_deg):
            angle = np.radians(angle_deg)
            return 1e5 + 1e4 * np.mod(angle, 4.0 * math.pi)

    rod = ConnectingRod(0.265, 5.0, 0.097, 0.069)
    cylinders = [
        EngineCylinder(0.13, 4.0, rod, crank_angle_deg=math.degrees(a)) for a in (0.0, math.pi)
    ]
    engine = EngineLayout(0.07, cylinders, [1, 2])
    area = 0.25 * math.pi * 0.13**2
    found = gas_forces(engine, Rising(), 0.9e5, shaft_angles_deg=np.degrees([0.0, 0.5]))
    np.testing.assert_allclose(found[0], area * (1e4 + 1e4 * np.array([0.0, 0.5])), rtol=1e-12)
    # Cylinder 2 fires half a turn after cylinder 1, so its own angle is three half turns on.
    np.testing.assert_allclose(
        found[1], area * (1e4 + 1e4 * (3.0 * math.pi + np.array([0.0, 0.5]))), rtol=1e-12
    )
    with pytest.raises(InputError, match="pressure: given 1 for 2 cylinders"):
        gas_forces(engine, [Rising()], shaft_angles_deg=np.degrees([0.0]))
    two_stroke = Rising()
    two_stroke.strokes = 2
    with pytest.raises(InputError, match="pressure: given a cycle of 2 strokes; allowed is 4"):
        gas_forces(engine, [Rising(), two_stroke], shaft_angles_deg=np.degrees([0.0]))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"gas": np.zeros((3, 24))}, r"gas: given an array of shape \(3, 24\); .*fits \(1, 24\)"),
        ({"friction": np.zeros(5)}, r"friction: given an array of shape \(5,\)"),
        ({"gas": math.nan}, "gas: given nan"),
        ({"model": "stiff"}, "rod model: given 'stiff'"),
    ],
)
def test_what_does_not_fit_is_refused(more, words):
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069))
    with pytest.raises(InputError, match=words):
        mechanism_forces(engine, SPEED, shaft_angles_deg=np.degrees(ANGLES), **more)
