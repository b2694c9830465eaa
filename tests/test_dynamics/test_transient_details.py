"""Details of motion through time that whole engines show too faintly.

Linear chains are met to 1e-9, as the opening of `test_transient_linear` explains; turning chains to
what each test says.
"""

import math

import numpy as np
import pytest

from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Gear
from dynamics.chains.engine_chains import EngineChain
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import gas_pressure
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.applied_forces import LoadStep, SpeedCurve
from dynamics.transient.run import steady_motion, transient_motion
from dynamics.transient.turning_chain import turning_chain
from dynamics.transient.turning_run import steady_cycle, turn_under_gas

FREE = {"inertia": [1.0, 2.0, 3.0], "stiffness": [1e4, 2e4]}
SPEED = 30.0


def at_first_node(speed):
    return OrderExcitation([1.0], [speed], np.array([[[1.0, 0.0, 0.0]]]))


def gas_forces(peak, strokes=2):
    """Engine of one cylinder, and the forces of its gas at SPEED."""
    rod = ConnectingRod(length=0.5, mass=8.0, center_distance=0.18, inertia=0.3)
    cylinder = EngineCylinder(bore=0.2, piston_mass=12.0, rod=rod)
    engine = EngineLayout(0.12, [cylinder], [1], strokes=strokes)
    angles = np.radians(np.arange(0.0, 360.0, 5.0))
    pressure = gas_pressure(
        1e5 + peak * np.exp(4.0 * np.cos(angles - 0.35) - 4.0),
        strokes=strokes,
        angles_deg=np.degrees(angles),
    )
    return engine, cylinder_forces(engine, [SPEED], 4, pressure, inertia=False)


def one_throw(peak=2e6, chain=None):
    engine, gas = gas_forces(peak)
    own = Chain([1.0, 9.0], [2e4], damping=30.0) if chain is None else chain
    return turning_chain(engine, EngineChain(own, "torsional", throw_nodes=(0,)), gas), gas


def test_free_chain_moves_about_its_even_turning_and_follows_the_angle_it_starts_at():
    chain = Chain(**FREE, damping=[5.0, 2.0])
    forces = np.array([[[1.0, 2.0, 0.0]], [[1j, 0.0, 4.0]]])
    acting = OrderExcitation([1.0, 2.0], [40.0], forces)
    motion = steady_motion(chain, acting, 40.0).motion
    # A mean over even angles, to round-off.
    assert np.abs(motion.mean(axis=0)).max() < 1e-12 * np.abs(motion).max()
    run = transient_motion(
        chain, acting, SpeedCurve.constant(40.0, 0.3, start_angle_deg=math.degrees(1.1))
    )
    wanted = forced_response(chain, acting).nodes.at_angle(0, shaft_angle_deg=run.shaft_angle_deg)
    # A free chain drifts by the error of its first speed times the time.
    off = np.abs(run.motion + run.rigid_motion - wanted)
    assert off.max() < 1e-8 * np.abs(wanted).max()


@pytest.mark.parametrize(("away", "unbounded"), [(0.9e-9, True), (1.1e-9, False)])
@pytest.mark.parametrize("stiffness", [2e4, 2e8])
def test_undamped_mode_is_unbounded_within_a_billionth_of_its_own_frequency(
    away, unbounded, stiffness
):
    # However high the others are; of stiffnesses 1e4 apart round-off leaves 1e-11 of the frequency.
    chain = Chain([1.0, 2.0, 3.0], [1e4, stiffness])
    speed = chain.modes().angular_frequencies[1] * (1.0 + away)
    found = steady_motion(chain, at_first_node(speed), speed)
    assert found.unbounded == unbounded
    # Nothing that could be taken for a result.
    assert np.all(found.motion == 0.0) == unbounded
    assert np.all(found.torque == 0.0) == unbounded
    assert np.all(np.isinf(found.amplitude)) == unbounded


def test_load_step_on_an_oscillator():
    chain = Chain([1.0], [], {0: 25.0})
    silent = OrderExcitation([1.0], [10.0], np.zeros((1, 1, 1)))
    loads = [LoadStep(0.5, 0, 3.0)]
    run = transient_motion(chain, silent, SpeedCurve.constant(10.0, 2.0), loads=loads, start="rest")
    since = np.maximum(run.time - 0.5, 0.0)
    wanted = 3.0 / 25.0 * (1.0 - np.cos(5.0 * since))
    assert np.allclose(run.motion[:, 0], wanted, rtol=0.0, atol=1e-9 * 0.24)


def test_orders_without_a_common_cycle_take_windows_of_given_turns():
    chain = Chain(**FREE, damping=5.0)
    acting = OrderExcitation([0.5, 4 * 0.337], [50.0, 100.0], np.ones((2, 2, 3)) * [1.0, 0.0, 0.0])
    run = transient_motion(chain, acting, SpeedCurve.constant(60.0, 2.0), start="rest")
    assert run.complete
    assert run.envelope(turns=2).turns == 2
    for call in (run.envelope, lambda: run.turns):
        with pytest.raises(InputError, match=r"^orders: given 0.5, 1.348; allowed are orders that"):
            call()


def test_phasors_of_a_cycle_are_those_of_its_orders_and_no_others():
    chain, gas = one_throw(1e3)
    cycle = steady_cycle(chain, SPEED)
    orders = np.array([1.0, 2.0, 3.0])
    twist = cycle.phasors(orders) @ [-1.0, 1.0]
    # One spring: its torque is stiffness times twist at every angle, so by every order, to round-off.
    torque = cycle.torque_phasors(orders)[:, 0]
    assert np.allclose(torque, 2e4 * twist, rtol=0.0, atol=1e-12 * np.abs(torque).max())
    half = cycle.shaft_angle_deg.size / 2.0
    for order in (0.5, 0.0, -1.0, half, 1.0001):
        for phasors in (cycle.phasors, cycle.torque_phasors):
            with pytest.raises(InputError, match=r"^orders: given .*; allowed are multiples of 1"):
                phasors([order])
    assert gas.orders.tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.slow
def test_mean_place_of_a_cycle_is_that_of_even_turning():
    chain, _ = one_throw()
    motion = steady_cycle(chain, SPEED).motion
    # The cycle closes to 1e-7 of the motion.
    mean = motion.mean(axis=0) @ [1.0, 9.0]
    assert np.abs(mean) < 1e-6 * np.abs(motion).max() * 10.0


def test_geared_chain_with_distributed_inertia_keeps_its_energy():
    chain = Chain(
        [1.0, 2.0, 0.5, 0.5],
        [2e4, 1e4],
        connections=[(0, 1), (2, 3)],
        damping=30.0,
        gears=[Gear(1, 2, -3.0)],
        distributed_inertia=[0.6, 0.0],
    )
    turning, _ = one_throw(chain=chain)
    assert not turning.separate
    run = turn_under_gas(turning, SPEED, 0.5)
    assert np.allclose(run.speed[0], SPEED * np.array([1.0, 1.0, -3.0, -3.0]))
    # The integration keeps 1e-9 of each step; some hundred steps.
    assert run.energy_error < 1e-6


def test_dampers_to_ground_turn_evenly():
    # Gas so weak that the torque hardly depends on the vibration itself: 1e-3.
    chain = Chain([1.0, 9.0], [2e4], damping=30.0, ground_damping={0: 200.0, 1: 100.0})
    turning, gas = one_throw(1e3, chain)
    ends = EngineChain(chain, "torsional", throw_nodes=(0,))
    wanted = forced_response(chain, torque_excitation(gas, ends)).motion[:, 0]
    found = steady_cycle(turning.with_constant_inertia(), SPEED).phasors(gas.orders)
    assert np.abs(found - wanted).max() < 1e-3 * np.abs(wanted).max()


def test_strain_energy_keeps_its_digits_after_many_turns():
    stiffness = np.array([1.7e4, 3.3e4])
    turning, _ = one_throw(1e3, Chain([1.0, 3.0, 9.0], stiffness, damping=30.0))
    run = turn_under_gas(turning, SPEED, 0.5)
    # Of the twist, whose round-off is 1e-15 of the 15 rad turned; energy from the angles themselves
    # would miss 1e-16 of stiffness times their square, 1e-9 J.
    wanted = 0.5 * run.torque**2 @ (1.0 / stiffness)
    room = 1e-14 * np.abs(run.torque).max()
    assert np.allclose(run.strain_energy, wanted, rtol=1e-12, atol=room)
    assert wanted.max() > 1e-6


def test_more_samples_than_are_counted_are_refused():
    with pytest.raises(InputError, match=r"samples: given .*; allowed is up to"):
        SpeedCurve.sampled(lambda _: 1.0, 1.0, samples=10**400)
