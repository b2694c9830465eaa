"""Vibration through time: linear chains, and chains that turn with their rods and pistons."""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.vibration.plots import plot_transient, plot_transient_over_speed
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.dampers import TorsionalRing
from dynamics.chains.engine_chains import EngineChain
from dynamics.chains.varying import Variation, Varying
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import gas_pressure
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import chain_system
from dynamics.response.loads import element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.motions import envelope_over, steady_motion, transient_motion
from dynamics.transient.propagator import LoadStep, SpeedCurve, viscous_system
from dynamics.transient.turning_run import (
    steady_cycle,
    throw_inertia_curves,
    turn_under_gas,
    turning_chain,
)
from dynamics.turning.free_turning import turn_freely
from refusals import refusals, refused

EXACT = 1e-9
ORDERS = np.array([0.5, 1.0, 2.5, 4.0])
SPEEDS = np.array([40.0, 60.0, 80.0, 100.0, 120.0])


def excitation(nodes, orders=ORDERS, speeds=SPEEDS):
    rng = np.random.default_rng(7)
    shape = (len(orders), 1, nodes)
    forces = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    return OrderExcitation(orders, speeds, forces * (1.0 + (speeds[:, np.newaxis] / 80.0) ** 2))


def row(**options):
    return Chain([1.0, 2.0, 0.5, 8.0], [9e4, 4e4, 7e4], **options)


def test_forces_between_speeds_follow_the_square_of_the_speed():
    # Those of `excitation` are quadratic in the speed, which a cubic spline meets exactly.
    acting = excitation(4)
    exact = OrderExcitation(ORDERS, [73.0], acting.forces[:, 2:3] / 2.0 * (1 + (73.0 / 80.0) ** 2))
    chain = row(damping=5.0)
    one, other = (steady_motion(chain, own, 73.0).motion for own in (acting, exact))
    assert np.allclose(one, other, rtol=0.0, atol=EXACT * np.abs(other).max())


@pytest.mark.slow
def test_elements_that_push_their_ends_apart_carry_no_part_of_it():
    chain, plain = row(damping=5.0), excitation(3).forces
    forces = np.zeros((*plain.shape[:2], 4), dtype=complex)
    for place, (left, right) in enumerate(chain.connections):
        forces[:, :, left] -= plain[:, :, place]
        forces[:, :, right] += plain[:, :, place]
    acting = OrderExcitation(ORDERS, SPEEDS, forces, plain)
    by_orders = element_loads(forced_response(chain, acting)).elastic
    steady = steady_motion(chain, acting, SPEEDS[1])
    wanted = by_orders.at_angle(1, shaft_angle_deg=steady.shaft_angle_deg)
    assert np.allclose(steady.torque, wanted, rtol=0.0, atol=EXACT * np.abs(wanted).max())
    # From a second excitation on at half of the time, half as large.
    half = OrderExcitation(ORDERS, SPEEDS, 0.5 * forces, 0.5 * plain)
    curve = SpeedCurve([0.0, 40.0], [SPEEDS[1], SPEEDS[1]])
    run = transient_motion(chain, acting, curve, changes=[(0.5, half)])
    wanted = by_orders.at_angle(1, shaft_angle_deg=run.shaft_angle_deg)
    early, late = run.time < 0.5, run.time > 39.0
    most = np.abs(wanted).max()
    assert np.allclose(run.torque[early], wanted[early], rtol=0.0, atol=1e-7 * most)
    assert np.allclose(run.torque[late], 0.5 * wanted[late], rtol=0.0, atol=1e-7 * most)


def test_loss_factors_become_viscous():
    chain = row(loss_factor=[0.05, 0.02, 0.03])
    lowest = chain.modes().angular_frequencies[1]
    viscous = viscous_system(chain)
    assert f"{lowest / 2 / np.pi:.6g} Hz" in viscous.note
    damping = chain.stiffness * chain.loss_factor / lowest
    assert np.allclose(viscous.system.damping, row(damping=damping).damping_matrix())
    # Right at the frequency stated: order 1 at a speed equal to it.
    acting = OrderExcitation([1.0], [50.0], np.ones((1, 1, 4)) * [1.0, 2.0, 0.0, 0.0])
    found = steady_motion(chain, acting, 50.0, loss_frequency=50.0)
    wanted = forced_response(chain, acting).motion[0, 0]
    assert np.allclose(found.phasors(1.0)[0], wanted, rtol=0.0, atol=EXACT * np.abs(wanted).max())
    modal = viscous_system(chain, loss_as="modal").system
    shares = chain.modes().strain_shares[:3, 1:] * chain.loss_factor[:, np.newaxis]
    wanted = viscous_system(row(), modal_damping=0.5 * shares.sum(axis=0)).system
    assert np.allclose(modal.damping, wanted.damping, atol=1e-9)
    assert viscous_system(row(), magnifier=40.0).note == ""


def test_constant_speed_stays_steady_and_rest_gets_there():
    chain = row(damping=150.0, ground_damping=[20.0] * 4)
    acting = excitation(4)
    wanted = steady_motion(chain, acting, 80.0)
    run = transient_motion(chain, acting, SpeedCurve.constant(80.0, 10.0))
    assert run.complete
    assert run.turns == 2
    at_start = np.array([wanted.motion[0], (run.motion + run.rigid_motion)[0]])
    assert np.allclose(at_start[0], at_start[1], atol=EXACT * np.abs(wanted.motion).max())
    # Peaks by parabolas through samples half a radian apart: 2e-4.
    assert np.allclose(run.envelope(rigid=True).motion, wanted.amplitude, rtol=5e-4)
    assert np.allclose(run.envelope().torque, wanted.torque_amplitude, rtol=5e-4)
    rest = transient_motion(chain, acting, SpeedCurve.constant(80.0, 10.0), start="rest")
    assert np.all(rest.motion[0] == 0.0)
    off = np.max(np.abs(rest.torque[-200:] - run.torque[-200:]))
    # The slowest elastic mode decays by exp(-zeta w t) < 1e-9 within 10 s.
    assert off < 1e-8 * np.abs(run.torque).max()


def test_failure_of_a_cylinder_takes_over_at_its_time():
    chain = row(damping=150.0, ground_damping=[20.0] * 4)
    before, after = excitation(4), excitation(4, orders=np.array([0.5, 1.5]))
    curve = SpeedCurve.constant(80.0, 10.0, start_angle_deg=math.degrees(1.0))
    plain = transient_motion(chain, before, curve)
    # A time between two steps of the plain run, so that all samples fall together.
    run = transient_motion(chain, before, curve, changes=[(float(plain.time[1000]), after)])
    wanted = transient_motion(chain, after, curve, step=plain.step)
    size = np.abs(plain.torque).max()
    assert run.time.size == plain.time.size == wanted.time.size
    assert np.allclose(run.torque[:1001], plain.torque[:1001], rtol=0.0, atol=EXACT * size)
    assert np.max(np.abs(run.torque[1002] - plain.torque[1002])) > 1e-4 * size
    assert np.allclose(run.torque[-200:], wanted.torque[-200:], rtol=0.0, atol=EXACT * size)


def test_load_step_settles_at_the_static_twist():
    chain = row(ground={3: 5e4}, damping=400.0, ground_damping=[200.0] * 4)
    silent = OrderExcitation([1.0], [50.0], np.zeros((1, 1, 4)))
    load = LoadStep(time=0.31, node=0, load=250.0, rise=0.2)
    run = transient_motion(chain, silent, SpeedCurve.constant(50.0, 3.0), loads=[load])
    static = np.linalg.solve(chain.stiffness_matrix(), [250.0, 0.0, 0.0, 0.0])
    assert np.all(run.motion[run.time < 0.31 - run.step] == 0.0)
    assert np.allclose(run.motion[-1], static, rtol=1e-9)
    assert np.allclose(run.torque[-1], [-250.0] * 3, rtol=1e-9)


def test_interrupted_run_keeps_what_is_finished():
    chain, acting = row(damping=5.0), excitation(4)
    curve = SpeedCurve.ramp(50.0, 110.0, duration=10.0)
    told = []

    def stop(share):
        told.append(share)
        if share > 0.4:
            raise KeyboardInterrupt

    run = transient_motion(chain, acting, curve, progress=stop)
    whole = transient_motion(chain, acting, curve, progress=told.append)
    assert not run.complete
    assert whole.complete
    assert told[-1] == 1.0
    count = run.time.size
    assert 0.4 * whole.time.size < count < 0.8 * whole.time.size
    assert np.allclose(run.torque, whole.torque[:count], rtol=0.0, atol=1e-9)
    assert run.envelope().time.size > 10


def test_speed_curve():
    curve = SpeedCurve([0.0, 1.0, 3.0], [10.0, 30.0, 20.0], start_angle_deg=math.degrees(2.0))
    assert np.allclose(np.radians(curve.angle_deg([0.0, 0.5, 1.0, 3.0])), [2.0, 9.5, 22.0, 72.0])
    times = np.linspace(0.0, 3.0, 31)
    assert np.allclose(curve.time_at(angle_deg=curve.angle_deg(times)), times, atol=1e-12)
    assert SpeedCurve.ramp(30.0, 10.0, acceleration=5.0).duration == 4.0
    sampled = SpeedCurve.sampled(lambda time: 10.0 + 5.0 * time, 2.0, samples=11)
    assert np.isclose(np.radians(sampled.angle_deg(2.0)), 30.0)


def test_envelope_of_a_sine():
    time = np.linspace(0.0, 40.0, 1601)
    angle = 2.0 * np.pi * time
    values = (3.0 + np.sin(3.0 * angle + 0.4))[:, np.newaxis]
    found = envelope_over(time, np.full(time.shape, 2.0 * np.pi), angle, values, values[:, :0], 2)
    # 0.47 rad of the sine between samples: 2e-4 by parabolas, 1e-2 without.
    assert np.allclose(found.motion, 1.0, rtol=2e-4)
    assert found.time.size == 20
    assert found.torque.shape == (20, 0)


BAD = {
    "speeds[1]: given 0 rad/s": lambda: SpeedCurve([0.0, 1.0], [10.0, 0.0]),
    "speeds[0]: given nan": lambda: SpeedCurve([0.0, 1.0], [np.nan, 1.0]),
    "times[1]: given -1 s after 0 s": lambda: SpeedCurve([0.0, -1.0], [10.0, 20.0]),
    "times: given 3 for 2 speeds": lambda: SpeedCurve([0.0, 1.0, 2.0], [10.0, 20.0]),
    "angle_deg: given 90 to 90": lambda: SpeedCurve.constant(1.0, 1.0).time_at(angle_deg=90.0),
    "time: given 2 to 2 s": lambda: SpeedCurve.constant(1.0, 1.0).speed(2.0),
    "turns: given 3": lambda: envelope_over(*3 * [np.arange(5.0)], *2 * [np.ones((5, 1))], 3),
    "start: given 'steady'": lambda: transient_motion(
        Chain([1.0, 1.0, 1.0], [300.0, 300.0]), at_first_node(30.0), SpeedCurve.constant(30.0, 1.0)
    ),
    "chain: given springs that vary": lambda: viscous_system(
        row(varying=[Varying(0, Variation(speed=(0.0, 9.0), stiffness=(1.0, 2.0)).of(9e4))])
    ),
    "end_speed: given 10 rad/s": lambda: SpeedCurve.ramp(10.0, 10.0, duration=1.0),
    "acceleration: given None": lambda: SpeedCurve.ramp(10.0, 20.0),
    "speed: given -80 rad/s": lambda: steady_motion(row(), excitation(4), -80.0),
    "speed: given 130 rad/s": lambda: steady_motion(row(), excitation(4), 130.0),
    "excitation: given forces on 3 nodes": lambda: steady_motion(row(), excitation(3), 80.0),
    "step: given": lambda: steady_motion(row(), excitation(4), 80.0, steps=20),
    "loss_as: given": lambda: viscous_system(row(), loss_as="none"),
    "loss_frequency: given": lambda: viscous_system(row(), loss_as="modal", loss_frequency=3.0),
    "magnifier: given": lambda: viscous_system(row(), magnifier=9.0, modal_damping=0.1),
    "speed: given 30 to 50": lambda: transient_motion(
        row(damping=3.0), excitation(4), SpeedCurve.ramp(30.0, 50.0, duration=1.0)
    ),
    "changes[0]: given a time of 2 s": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1.0), changes=[(2.0, excitation(4))]
    ),
    "loads[0].node: given 4": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1.0), loads=[LoadStep(0.0, 4, 1.0)]
    ),
    "load_step.load: given nan": lambda: LoadStep(0.0, 1, np.nan),
    "step: given 0.1 s": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1.0), step=0.1
    ),
    "start: given 'now'": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1.0), start="now"
    ),
    "speed: given a curve that takes": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1e6)
    ),
    "speed: given a curve that": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1e50)
    ),
    "speed: given": lambda: transient_motion(
        row(), excitation(4), SpeedCurve.constant(80.0, 1.0), step=1e-50
    ),
    "orders: given": lambda: steady_motion(
        row(), excitation(4, orders=np.array([1.0, np.pi, 4.0])), 80.0
    ),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_refused_in_one_sentence(message):
    with refused(message.partition(": ")[0]) as caught:
        BAD[message]()
    assert str(caught.value).startswith(message)


SPEED, HIGHEST = 30.0, 4


def engine(share=1.0):
    rod = ConnectingRod(0.5, 8.0 * share, 0.18, 0.3 * share)
    cylinders = [
        EngineCylinder(
            0.2, 12.0 * share, rod, crank_angle_deg=math.degrees(angle), position=position
        )
        for angle, position in ((0.0, 0.0), (np.pi, 0.3))
    ]
    return EngineLayout(0.12, cylinders, [1, 2], strokes=2)


def pressure():
    angles = np.radians(np.arange(0.0, 360.0, 5.0))
    return gas_pressure(
        1e5 + 2e6 * np.exp(4.0 * (np.cos(angles - 0.35) - 1.0)),
        strokes=2,
        angles_deg=np.degrees(angles),
    )


def small_chain(**options):
    # 12.5 and 43 Hz; orders 2 and 4 at 30 rad/s lie at 9.5 and 19 Hz.
    chain = Chain([2.0, 2.0, 9.0], [6e4, 2e4], **options)
    return EngineChain(chain, "torsional", throw_nodes=(0, 1))


def turning(share=1.0, gas=None, **options):
    own = engine(share)
    forces = cylinder_forces(own, [SPEED], HIGHEST, gas, inertia=False)
    return turning_chain(own, small_chain(**options), forces), forces


def with_gas_share(chain, share):
    curves = chain.curves
    torque = {"torque_mean": share * curves.torque_mean, "torque": share * curves.torque}
    return replace(chain, curves=replace(curves, **torque))


@pytest.mark.slow
@pytest.mark.parametrize("options", [{"damping": 30.0}, {"ground_damping": [8.0, 8.0, 0.0]}])
def test_little_gas_and_constant_inertia_give_the_linear_response(options):
    # The torque goes by the throw's own angle, so that the difference is of the second order.
    bare, forces = turning(gas=pressure(), **options)
    differences = []
    for share in (1e-3, 1e-4):
        found = steady_cycle(with_gas_share(bare, share).with_constant_inertia(), SPEED)
        acting = torque_excitation(forces, small_chain())
        wanted = share * forced_response(bare.system.system, acting).motion[:, 0]
        left = np.abs(found.phasors(forces.orders) - wanted).max()
        differences.append(left / np.abs(wanted).max())
        assert found.load == close(share * forces.mean_torque[0], rel=1e-3)
    assert differences[1] < 1e-4
    assert differences[1] == close(0.1 * differences[0], rel=0.1)


@pytest.mark.slow
def test_steady_cycle_repeats_and_keeps_its_energy():
    chain, _ = turning(gas=pressure(), damping=30.0, loss_factor=0.02)
    found = steady_cycle(chain, SPEED)
    assert found.turns == 1
    assert found.energy_error < 1e-8
    assert found.closing_error < 1e-7
    assert found.gas_work > 0.0 > found.damping_work
    assert found.load_work == close(-found.load * 2.0 * np.pi, rel=1e-8)
    assert np.mean(found.speed, axis=0) == close([SPEED] * 3, rel=1e-9)
    # The twist of the shaft's end carries the load, by its mean.
    assert np.mean(found.torque[:, 1]) == close(-found.load, rel=1e-6)
    assert "Hz, that of the lowest elastic mode" in found.note


@pytest.mark.slow
def test_implicit_integration_finds_the_same_cycle():
    chain, _ = turning(gas=pressure(), damping=30.0)
    light = with_gas_share(chain, 0.3)
    one, other = (steady_cycle(light, SPEED, method=way) for way in ("DOP853", "Radau"))
    # Radau's steps keep 1e-9 of each value, but their errors add up over some thousand of them.
    assert np.allclose(one.torque, other.torque, atol=1e-5 * np.abs(one.torque).max())


@pytest.mark.slow
def test_coasting_shaft_turns_like_the_rigid_engine():
    # A stiff shaft: 100 N m twist it by 1e-5 rad at 1e7 N m/rad, and as much comes from inertia.
    own = replace(engine(), shaft_inertia=2.0)
    mean = throw_inertia_curves(own, [0, 1]).mean
    shaft = Chain([0.5 + mean[0], 0.5 + mean[1], 1.0], [1e7, 1e7])
    forces = cylinder_forces(own, [SPEED], HIGHEST, inertia=False)
    chain = turning_chain(own, EngineChain(shaft, "torsional", throw_nodes=(0, 1)), forces)
    found = turn_under_gas(chain, SPEED, 0.1, load=100.0, samples_per_turn=36)
    wanted = turn_freely(
        own, start_angle_deg=0.0, start_speed=SPEED, duration=0.1, load=100.0, times=found.time
    )
    assert found.complete
    nodes = found.motion + np.radians(found.shaft_angle_deg)[:, np.newaxis]
    assert np.allclose(nodes, np.radians(wanted.angle_deg)[:, np.newaxis], rtol=0.0, atol=2e-5)
    assert np.allclose(found.kinetic_energy, wanted.kinetic_energy, rtol=1e-3)
    assert found.energy_error < 1e-9


@pytest.mark.slow
def test_run_up_under_gas_keeps_its_energy_and_a_governor_holds_the_speed():
    chain, forces = turning(gas=pressure(), damping=30.0, ground_damping=[4.0, 4.0, 0.0])
    mean = forces.mean_torque[0]

    def load(speed, _):
        return mean + 150.0 * (speed - SPEED)

    run = turn_under_gas(chain, 20.0, 1.0, load=load)
    assert run.complete
    assert run.energy_error < 1e-8
    assert run.damping_work[-1] < 0.0 < run.gas_work[-1]
    # By trapezoids of 2 deg; errors of their ends remain, the square of a step by the slope there.
    power = load(run.shaft_speed, 0.0) * run.speed[:, 2]
    assert np.trapezoid(power, run.time) == close(-run.load_work[-1], rel=1e-4)
    # Of 13 kg m^2 by 150 N m s/rad: exp(-1 s / 87 ms) of 10 rad/s is left after the run.
    turns = np.interp(
        np.radians(run.shaft_angle_deg)[-1] - 2.0 * np.pi * np.arange(3),
        np.radians(run.shaft_angle_deg),
        run.time,
    )
    assert turns[0] - turns[1] == close(turns[1] - turns[2], rel=1e-3)
    assert 2.0 * np.pi / (turns[0] - turns[1]) == close(SPEED, rel=0.05)
    assert run.envelope().torque.shape[1] == 2


@pytest.mark.slow
def test_interrupted_and_stopping_runs_keep_what_is_finished():
    chain, forces = turning(gas=pressure(), damping=30.0)

    def stop(share):
        if share > 0.4:
            raise KeyboardInterrupt

    run = turn_under_gas(chain, SPEED, 0.8, load=forces.mean_torque[0], progress=stop)
    assert not run.complete
    assert 0.3 < run.time[-1] < 0.7
    silent, _ = turning(damping=30.0)
    braked = turn_under_gas(silent, SPEED, 2.0, load=600.0)
    assert not braked.complete
    assert abs(braked.shaft_speed[-1]) < 0.1 * SPEED
    assert braked.energy_error < 1e-8


def turning_of(chain, throws=(0, 1), gas=True, **options):
    own = engine()
    forces = cylinder_forces(own, [SPEED], HIGHEST, inertia=not gas)
    return turning_chain(own, EngineChain(chain, "torsional", throws), forces, **options)


ENDS, SPRINGS = [2.0, 2.0, 9.0], [6e4, 2e4]
LOOSE = {"connections": [(0, 1), (1, 2)], "gears": [Gear(3, 4, 2.0)]}
BAD_TURNING = {
    "mean_speed: given 0": lambda chain: steady_cycle(chain, 0.0),
    "speeds[1]: given inf": lambda chain: chain.mean_speed(np.array([1.0, np.inf, 1.0])),
    "speeds: given an array of shape (2,)": lambda chain: chain.mean_speed(np.ones(2)),
    "method: given 'Euler'": lambda chain: steady_cycle(chain, SPEED, method="Euler"),
    "start_speed: given -1": lambda chain: turn_under_gas(chain, -1.0, 1.0),
    "duration: given 0": lambda chain: turn_under_gas(chain, 1.0, 0.0),
    "duration: given 100000 s": lambda chain: turn_under_gas(chain, 1.0, 1e5),
    "duration: given 1000 s": lambda chain: turn_under_gas(chain, 1e3, 1e3),
    "load: given a moment of nan": lambda chain: turn_under_gas(
        chain, 9.0, 1.0, load=lambda *_: np.nan
    ),
    "changes[0]: given a time of 2 s": lambda chain: turn_under_gas(
        chain, 9.0, 1.0, changes=((2.0, chain),)
    ),
    "changes[0]: given a chain of other": lambda chain: turn_under_gas(
        chain, 9.0, 1.0, changes=((0.5, turning_of(Chain(ENDS, [6e4, 3e4]))),)
    ),
    "engine_chain: given 0.1 kg m^2": lambda _: turning_of(Chain([0.1, 2.0, 9.0], SPRINGS)),
    "engine_chain: given torsional, held": lambda _: turning_of(Chain(ENDS, SPRINGS, {2: 5.0})),
    "engine_chain: given 1 throws": lambda _: turning_of(Chain(ENDS, SPRINGS), (0,)),
    "engine_chain: given a chain without springs": lambda _: turning_of(
        Chain([2.0, 2.0], [], connections=[], gears=[Gear(0, 1, 1.0)])
    ),
    "engine_chain: given throws that turn [1.0, 2.0]": lambda _: turning_of(
        Chain(ENDS, [2e4], connections=[(1, 2)], gears=[Gear(0, 1, 2.0)])
    ),
    "engine_chain: given parts that dashpots hold": lambda _: turning_of(
        Chain(
            [*ENDS, 1.0, 1.0], SPRINGS, dashpots=[Dashpot(2, 3, 5.0), Dashpot(2, 4, 5.0)], **LOOSE
        )
    ),
    "gas: given forces that hold": lambda _: turning_of(Chain(ENDS, SPRINGS), gas=False),
    "load_node: given": lambda _: turning_of(Chain(ENDS, SPRINGS), load_node=3),
}


@pytest.mark.parametrize("message", BAD_TURNING)
def test_bad_input_is_refused_in_one_sentence_turning(message):
    chain, _ = turning(gas=pressure(), damping=30.0)
    with refused(message.partition(": ")[0]) as caught:
        BAD_TURNING[message](chain)
    assert str(caught.value).startswith(message)


def test_a_chain_that_turns_evenly_has_that_speed_and_gas_may_change_within_a_run():
    chain, _ = turning(gas=pressure(), damping=30.0)
    assert chain.mean_speed(SPEED * chain.even) == close(SPEED)
    alone, changed = (
        turn_under_gas(chain, SPEED, 0.1, changes=changes) for changes in ((), ((0.04, chain),))
    )
    assert changed.shaft_speed[-1] == close(alone.shaft_speed[-1], rel=1e-6)


def test_a_cycle_that_takes_too_many_evaluations_is_given_up(monkeypatch):
    chain, _ = turning(gas=pressure(), damping=30.0)
    monkeypatch.setattr("dynamics.transient.turning_run.MOST_EVALUATIONS", 500)
    with refused("mean_speed"):
        steady_cycle(chain, 1e-6)
    monkeypatch.setattr("dynamics.transient.turning_run.MOST_EVALUATIONS", 500)
    with refused("duration"):
        turn_under_gas(chain, 1e-3, 1e4)


FREE = {"inertia": [1.0, 2.0, 3.0], "stiffness": [1e4, 2e4]}
DETAILS_SPEED = 30.0


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
    return engine, cylinder_forces(engine, [DETAILS_SPEED], 4, pressure, inertia=False)


def one_throw(peak=2e6, chain=None):
    engine, gas = gas_forces(peak)
    own = Chain([1.0, 9.0], [2e4], damping=30.0) if chain is None else chain
    ends = EngineChain(own, "torsional", throw_nodes=(0,))
    return turning_chain(engine, ends, gas, load_node=1), gas


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
    assert np.abs(run.motion + run.rigid_motion - wanted).max() < 1e-8 * np.abs(wanted).max()


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
    wanted = 3.0 / 25.0 * (1.0 - np.cos(5.0 * np.maximum(run.time - 0.5, 0.0)))
    assert np.allclose(run.motion[:, 0], wanted, rtol=0.0, atol=1e-9 * 0.24)


def test_orders_without_a_common_cycle_take_windows_of_given_turns():
    chain = Chain(**FREE, damping=5.0)
    acting = OrderExcitation([0.5, 4 * 0.337], [50.0, 100.0], np.ones((2, 2, 3)) * [1.0, 0.0, 0.0])
    run = transient_motion(chain, acting, SpeedCurve.constant(60.0, 2.0), start="rest")
    assert run.complete
    assert run.envelope(turns=2).turns == 2
    for call in (run.envelope, lambda: run.turns):
        with refused("orders"):
            call()


@pytest.mark.slow
def test_phasors_of_a_cycle_are_those_of_its_orders_and_no_others():
    chain, gas = one_throw(1e3)
    cycle = steady_cycle(chain, DETAILS_SPEED)
    orders = np.array([1.0, 2.0, 3.0])
    twist = cycle.phasors(orders) @ [-1.0, 1.0]
    # One spring: its torque is stiffness times twist at every angle, so by every order, to round-off.
    waves = np.exp(-1j * np.outer(orders, np.radians(cycle.shaft_angle_deg)))
    torque = 2.0 * np.mean(waves * cycle.torque[:, 0], axis=1)
    assert np.allclose(torque, 2e4 * twist, rtol=0.0, atol=1e-12 * np.abs(torque).max())
    half = cycle.shaft_angle_deg.size / 2.0
    for order in (0.5, 0.0, -1.0, half, 1.0001):
        with refused("orders"):
            cycle.phasors([order])
    assert gas.orders.tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.slow
def test_mean_place_of_a_cycle_is_that_of_even_turning():
    chain, _ = one_throw()
    motion = steady_cycle(chain, DETAILS_SPEED).motion
    # The cycle closes to 1e-7 of the motion.
    mean = motion.mean(axis=0) @ [1.0, 9.0]
    assert np.abs(mean) < 1e-6 * np.abs(motion).max() * 10.0


@pytest.mark.slow
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
    run = turn_under_gas(turning, DETAILS_SPEED, 0.5)
    assert np.allclose(run.speed[0], DETAILS_SPEED * np.array([1.0, 1.0, -3.0, -3.0]))
    # The integration keeps 1e-9 of each step; some hundred steps.
    assert run.energy_error < 1e-6


GROUNDED = Chain([1.0, 9.0], [2e4], damping=30.0, ground_damping={0: 200.0, 1: 100.0})
RING = TorsionalRing(inertia=0.4, damping=60.0).attached(Chain([1.0, 9.0], [2e4]), 0, "ring")


@pytest.mark.slow
@pytest.mark.parametrize("chain", [GROUNDED, RING], ids=["to ground", "viscous ring"])
def test_dampers_turn_evenly(chain):
    # Gas so weak that the torque hardly depends on the vibration itself: 1e-3.
    turning, gas = one_throw(1e3, chain)
    ends = EngineChain(chain, "torsional", throw_nodes=(0,))
    wanted = forced_response(chain, torque_excitation(gas, ends)).motion[:, 0]
    found = steady_cycle(turning.with_constant_inertia(), DETAILS_SPEED).phasors(gas.orders)
    assert np.abs(found - wanted).max() < 1e-3 * np.abs(wanted).max()


def run(system):
    acting = OrderExcitation([1.5], [100.0, 300.0], np.ones((1, 2, 2)) * [80.0, 0.0])
    return transient_motion(system, acting, SpeedCurve.ramp(120.0, 280.0, duration=1.0))


@pytest.mark.slow
def test_pictures(tmp_path):
    chain = Chain([0.3, 2.0], [4e4], damping=3.0, names=["crank", "flywheel"])
    found = run(chain)
    for quantity in ("torque", "motion"):
        path = tmp_path / f"{quantity}.svg"
        plot_transient(
            path, found, 0, quantity=quantity, steady=([150.0, 250.0], [20.0, 30.0]), title="a run"
        )
        assert path.read_text(encoding="utf-8").startswith("<?xml")
        assert path.stat().st_size < 200_000
    plot_transient(tmp_path / "turns.svg", found, turns=4)
    assert "amplitude over 4 turns" in (tmp_path / "turns.svg").read_text(encoding="utf-8")
    plot_transient_over_speed(tmp_path / "s.svg", [1.0, 2.0, 3.0], {"one": [1.0, np.inf, 2.0]})
    with refused("place"):
        plot_transient(tmp_path / "a.svg", found, 1)
    with refused("quantity"):
        plot_transient(tmp_path / "a.svg", run(chain_system(chain)))
    with refused("steady"):
        plot_transient(tmp_path / "a.svg", found, steady=([3.0, 2.0], [1.0, 1.0]))
    with refused("amplitudes"):
        plot_transient_over_speed(tmp_path / "a.svg", [1.0], {})
    with refused("amplitudes['x']"):
        plot_transient_over_speed(tmp_path / "a.svg", [1.0], {"x": [np.nan]})


test_refused = refusals(
    ("samples", lambda: SpeedCurve.sampled(lambda _: 1.0, 1.0, samples=10**400)),
)
