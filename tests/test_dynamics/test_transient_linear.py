"""Integration of linear chains through time.

Steps are exact for forces that are polynomials of the fifth degree within a step. With half a
radian of the highest order in a step these miss a sine by less than 1e-8, and the Gauss points make
their integral better still; what is left is round-off, some 1e-12. So 1e-9 is asked for.
"""

import math

import numpy as np
import pytest

from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.applied_forces import LoadStep, SpeedCurve
from dynamics.transient.motions import envelope_over
from dynamics.transient.propagator import viscous_system
from dynamics.transient.run import steady_motion, transient_motion

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


CHAINS = {
    "absolute damping": row(ground_damping=[3.0, 0.0, 2.0, 0.0]),
    "relative damping, so that the rigid motion is free": row(damping=[5.0, 0.0, 9.0]),
    "no damping": row(),
    "held": row(ground={3: 5e4}, damping=4.0),
    "ring behind a dashpot": Chain(
        [1.0, 2.0, 0.5], [9e4], connections=[(0, 1)], dashpots=[Dashpot(1, 2, 40.0)]
    ),
    "gear": Chain(
        [1.0, 2.0, 0.5, 3.0],
        [9e4, 4e4],
        connections=[(0, 1), (2, 3)],
        gears=[Gear(1, 2, -1.7)],
        damping=3.0,
    ),
    "distributed inertia": row(distributed_inertia=0.4, damping=4.0),
}


@pytest.mark.parametrize("name", CHAINS)
def test_steady_motion_is_the_harmonic_answer(name):
    chain = CHAINS[name]
    acting = excitation(chain.inertia.size)
    found = steady_motion(chain, acting, 80.0)
    wanted = forced_response(chain, acting).motion[:, 2]
    assert np.max(np.abs(found.phasors(ORDERS) - wanted)) < EXACT * np.max(np.abs(wanted))
    springs = chain.stiffness * (wanted @ chain.elongations().T)
    waves = np.exp(1j * np.outer(np.radians(found.shaft_angle_deg), ORDERS))
    assert np.allclose(found.torque, (waves @ springs).real, atol=EXACT * np.abs(springs).max())


def test_a_step_covers_half_a_radian_of_the_highest_order():
    found = steady_motion(row(), excitation(4), 80.0)
    reach = 2.0 * np.pi * found.turns * ORDERS[-1] / found.shaft_angle_deg.size
    assert 0.46 < reach <= 0.5


def test_stiff_chain_needs_no_shorter_steps():
    chain = Chain([1.0, 2.0, 0.5, 8.0], [9e4, 4e12, 7e4], damping=3.0)
    acting = excitation(4)
    found = steady_motion(chain, acting, 80.0)
    wanted = forced_response(chain, acting).motion[:, 2]
    phase = found.step * chain.modes().angular_frequencies[-1]
    assert phase > 2e3
    # Round-off of a step grows with the phase of the stiff mode that it covers.
    assert np.max(np.abs(found.phasors(ORDERS) - wanted)) < 1e-7 * np.max(np.abs(wanted))


def test_undamped_resonance_is_unbounded_and_the_next_speed_is_not():
    chain = row()
    speed = chain.modes().angular_frequencies[1] / 2.5
    forces = np.ones((1, 2, 4)) * [1.0, 0.0, 0.0, 0.0]
    for factor, unbounded in ((1.0, True), (1.0 + 1e-6, False)):
        own = speed * factor
        acting = OrderExcitation([2.5], [own, 2.0 * own], forces)
        found = steady_motion(chain, acting, own)
        assert found.unbounded == unbounded == bool(forced_response(chain, acting).unbounded[0, 0])
        assert np.all(np.isinf(found.amplitude)) == unbounded
        assert not np.any(np.isnan(found.motion))
    # A mode whose frequency an order meets that does not act is left alone.
    alone = OrderExcitation([1.0, 2.5], [speed], np.array([1.0, 0.0])[:, None, None] * np.ones(4))
    assert not steady_motion(chain, alone, speed).unbounded


def test_forces_between_speeds_follow_the_square_of_the_speed():
    # Those of `excitation` are quadratic in the speed, which a cubic spline meets exactly.
    acting = excitation(4)
    exact = OrderExcitation(ORDERS, [73.0], acting.forces[:, 2:3] / 2.0 * (1 + (73.0 / 80.0) ** 2))
    chain = row(damping=5.0)
    one, other = (steady_motion(chain, own, 73.0).motion for own in (acting, exact))
    assert np.allclose(one, other, rtol=0.0, atol=EXACT * np.abs(other).max())


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
    at = float(plain.time[1000])
    run = transient_motion(chain, before, curve, changes=[(at, after)])
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
    assert "Interrupted at" in run.notes[-1]
    assert run.envelope().time.size > 10


def test_speed_curve():
    curve = SpeedCurve([0.0, 1.0, 3.0], [10.0, 30.0, 20.0], start_angle_deg=math.degrees(2.0))
    assert np.allclose(np.radians(curve.angle_deg([0.0, 0.5, 1.0, 3.0])), [2.0, 9.5, 22.0, 72.0])
    times = np.linspace(0.0, 3.0, 31)
    assert np.allclose(curve.time_at(angle_deg=curve.angle_deg(times)), times, atol=1e-12)
    down = SpeedCurve.ramp(30.0, 10.0, acceleration=5.0)
    assert down.duration == 4.0
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
    with pytest.raises(InputError) as error:
        BAD[message]()
    text = str(error.value)
    assert text.startswith(message)
    assert "allowed" in text
    assert "because" in text
