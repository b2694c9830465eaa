"""Loads of bearings and pins, and axial force over the cycle."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.forces import LoadDiagram, crankpin_loads, main_bearing_loads, mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout, RotatingMass, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import axial_force_over_cycle
from refusals import refusals_of, refused

ROD = ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009)
ANGLES = np.radians(np.arange(0.0, 720.0, 10.0))
DEGREES = np.degrees(ANGLES)
SPEED = 220.0
BEARINGS = [0.0, 0.16, 0.32]


def cylinder(crank=0.0, position=0.0, bank=0.0, **more):
    return EngineCylinder(
        0.13, 4.0, ROD, crank_angle_deg=crank, bank_angle_deg=bank, position=position, **more
    )


def twin(*rotating):
    return EngineLayout(
        0.07, [cylinder(0.0, 0.06), cylinder(180.0, 0.24)], [1, 2], rotating=rotating
    )


def forces_of(engine, angles=ANGLES, **more):
    gas = [4e4 * (1.1 + np.cos(0.5 * angles - 0.8 * n)) for n in range(len(engine.cylinders))]
    return mechanism_forces(
        engine, SPEED, np.array(gas), **more, shaft_angles_deg=np.degrees(angles)
    )


def test_a_crankpin_bears_the_rods_on_it():
    hinged = cylinder(bank=60.0, slave_pin=SlavePin(1, 0.06, angle_deg=60.0))
    engine = EngineLayout(
        0.07,
        [cylinder(), hinged, cylinder(bank=60.0)],
        [1, 2, 3],
        4,
        firing_angles_deg=[0.0, 60.0, 420.0],
    )
    forces = forces_of(engine)
    loads = crankpin_loads(forces)
    assert [load.name for load in loads] == ["crankpin, cylinders 1 and 2", "crankpin, cylinder 3"]
    np.testing.assert_allclose(loads[0].force, forces.crankpin[:2].sum(axis=0), rtol=1e-14)
    np.testing.assert_allclose(loads[1].force, forces.crankpin[2], rtol=1e-14)
    np.testing.assert_allclose(loads[1].in_crank_frame, forces.in_crank_frame[2], rtol=1e-12)
    np.testing.assert_allclose(np.abs(loads[0].in_crank_frame), loads[0].magnitude, rtol=1e-12)


def test_each_crankpin_turns_with_its_own_crank():
    forces = forces_of(twin())
    for number, load in enumerate(crankpin_loads(forces)):
        np.testing.assert_allclose(load.in_crank_frame, forces.in_crank_frame[number], rtol=1e-12)
    assert math.radians(crankpin_loads(forces)[1].crank_angle_deg) == math.pi


def test_each_load_is_shared_by_the_lever():
    """Cylinder 1 at 0.06 of 0.16, cylinder 2 in the middle of the second bay."""
    forces = forces_of(twin())
    first, second = forces.crankpin
    loads = main_bearing_loads(forces, BEARINGS)
    wanted = [0.625 * first, 0.375 * first + 0.5 * second, 0.5 * second]
    for load, force in zip(loads, wanted, strict=True):
        np.testing.assert_allclose(load.force, force, rtol=1e-12)
        assert math.radians(load.crank_angle_deg) == 0.0
    assert [load.name for load in loads] == [f"main bearing {n}" for n in (1, 2, 3)]


def test_bearings_carry_forces_and_moments_of_all_loads_turning_masses_included():
    """A mass at rest on the shaft, m r (w^2 - i w') outwards; sum and lever sum over the bearings."""
    masses = (
        RotatingMass(0.3, angle_deg=math.degrees(2.0), position=0.1),
        RotatingMass(0.2, angle_deg=math.degrees(-1.0), position=0.32),
    )
    gain = 4000.0
    forces = forces_of(twin(*masses), crank_acceleration=gain)
    loads = main_bearing_loads(forces, BEARINGS)
    total, moment = forces.crankpin.sum(axis=0), forces.crankpin.T @ [0.06, 0.24]
    for mass in masses:
        # Twice differentiated in time: r'' = (i w' - w^2) r.
        inertia = (
            mass.static_moment
            * np.exp(1j * (math.radians(mass.angle_deg) + ANGLES))
            * (SPEED**2 - 1j * gain)
        )
        total, moment = total + inertia, moment + mass.position * inertia
    found = np.array([load.force for load in loads])
    size = np.max(np.abs(total))
    np.testing.assert_allclose(found.sum(axis=0), total, rtol=0.0, atol=1e-12 * size)
    np.testing.assert_allclose(found.T @ BEARINGS, moment, rtol=0.0, atol=1e-12 * size)
    bare = main_bearing_loads(forces_of(twin(), crank_acceleration=gain), BEARINGS)
    np.testing.assert_allclose(found[0] - bare[0].force, 0.375 * 0.3 * np.exp(1j * (2.0 + ANGLES)) * (
        SPEED**2 - 1j * gain
    ), rtol=1e-9)  # fmt: skip


def test_a_hinged_rod_loads_the_shaft_where_the_main_rod_does():
    hinged = cylinder(bank=60.0, position=0.04, slave_pin=SlavePin(1, 0.06, angle_deg=60.0))
    forces = forces_of(EngineLayout(0.07, [cylinder(position=0.04), hinged], [1, 2]))
    loads = main_bearing_loads(forces, [0.0, 0.16])
    np.testing.assert_allclose(loads[0].force, 0.75 * forces.crankpin.sum(axis=0), rtol=1e-12)


def test_a_speed_for_each_angle():
    speeds = np.linspace(200.0, 240.0, ANGLES.size)
    with_mass, without = (
        main_bearing_loads(mechanism_forces(engine, speeds, shaft_angles_deg=DEGREES), BEARINGS)
        for engine in (twin(RotatingMass(0.3, angle_deg=math.degrees(2.0), position=0.0)), twin())
    )
    np.testing.assert_allclose(
        np.abs(with_mass[0].force - without[0].force), 0.3 * speeds**2, rtol=1e-9
    )


def test_cylinders_in_the_same_place_have_no_bearing_loads():
    engine = EngineLayout(
        0.07, [cylinder(position=0.1), cylinder(crank=180.0, position=0.1)], [1, 2]
    )
    with refused("position"):
        main_bearing_loads(forces_of(engine), BEARINGS)


@pytest.mark.parametrize(
    ("motion", "field"),
    [
        ({"speed": np.ones(3)}, "speed"),
        ({"speed": math.nan}, "speed"),
        ({"crank_acceleration": math.inf}, "crank_acceleration"),
        ({"crank_acceleration": np.ones((2, 72))}, "crank_acceleration"),
    ],
)
def test_a_motion_that_does_not_fit_is_refused(motion, field):
    engine = twin(RotatingMass(0.3, angle_deg=math.degrees(2.0), position=0.0))
    given = {"speed": SPEED} | motion
    with refused(field):
        mechanism_forces(engine, shaft_angles_deg=DEGREES, **given)


@pytest.mark.parametrize(
    ("angles", "words"),
    [
        (ANGLES[:36], r"given 36 angles from 0 to 350 deg, .*; allowed is one cycle of 720 deg"),
        (ANGLES[:2], "given 2 angles"),
        (ANGLES[::-1], "given 700 deg after 710 deg"),
        (np.delete(ANGLES, 5), r"given 60 deg after 40 deg; allowed are even steps"),
        (np.radians(np.arange(0.0, 1440.0, 10.0)), "given 144 angles from 0 to 1430 deg"),
    ],
)
def test_angles_that_are_not_one_cycle_are_refused(angles, words):
    forces = forces_of(twin(), angles)
    for loads in (crankpin_loads, lambda forces: main_bearing_loads(forces, BEARINGS)):
        with pytest.raises(InputError, match=f"^shaft_angles.*: {words}"):
            loads(forces)


test_bearings_that_do_not_hold_the_shaft_are_refused = refusals_of(
    lambda bearings, rotating: main_bearing_loads(forces_of(twin(*rotating)), bearings),
    ([0.0], (), "bearing_positions"),
    ([0.0, 0.3, 0.3], (), "bearing_positions"),
    ([0.3, 0.0], (), "bearing_positions"),
    ([0.1, 0.3], (), "position"),
    ([0.0, 0.2], (), "position"),
    (BEARINGS, (RotatingMass(0.1, angle_deg=0.0, position=0.4),), "position"),
)


def test_bearings_without_size_are_refused():
    load = LoadDiagram("pin", DEGREES, ANGLES.astype(complex), 0.0)
    with refused("bearing diameter"):
        load.specific_pressure(0.0, 0.05)
    with refused("bearing length"):
        load.specific_pressure(0.1, -1.0)


def test_two_throws_by_hand():
    # Z on pin 1 lengthens throw 1 by 2 and throw 2 by -1; T on pin 2 both by 1 [nm/N].
    influence = 1e-9 * np.array([[[2.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]]])
    forces = np.array([[[1e3, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1e3]]])
    found = axial_force_over_cycle(
        10.0, forces, [1e-9, 3e-9], influence, shaft_angles_deg=[0.0, 57.0]
    )
    assert found.throws == close(np.array([[2000.0, -1000.0 / 3.0], [1000.0, 1000.0 / 3.0]]))
    assert found.held == close([250.0, 500.0])
    assert found.thrust_bearing is None
    assert list(found.columns()) == ["shaft_angle_deg", "held_N", "throw_1_N", "throw_2_N"]
    with refused("pin_forces"):
        axial_force_over_cycle(
            10.0, forces[:1], [1e-9, 3e-9], influence, shaft_angles_deg=[0.0, 57.0]
        )
