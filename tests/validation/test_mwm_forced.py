"""Forced torsional vibration of the MWM six-cylinder diesel.

Source: the chain's equations solved in the test, order by order and by DOP853; engine of Mendes, Meirelles,
Zampieri, Proc. IMechE K 222 (2008) 155-178, doi 10.1243/14644193JMBD126, with an assumed gas pressure.

Tolerance: 1e-10, round-off times a condition of 1e4; time integration 2e-5, of which 1e-5 is lost between
20,000 instants.

The engine: inertias, stiffnesses, absolute damping of 2 N m s/rad at each cylinder, loss factor 0.035 of
each shaft, bore 105, stroke 137, rod 207 mm, firing at 120 deg x (0, 4, 2, 5, 1, 3). Its cylinder pressure
is not printed in numbers. Assumed is a pressure above the crankcase's of 90 bar exp(-((theta - 12 deg) / 24
deg)^2) after the firing top, on the piston of a slider-crank, orders 0.5 to 12. Each order is solved with
hysteretic damping; time integration uses viscous damping, c = eta k / w_1, in both, over one cycle from the
periodic initial state, with a relative tolerance of 1e-9.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from dynamics.chains.chain import Chain
from dynamics.harmonics import harmonics
from dynamics.response.forced import forced_response
from dynamics.response.loads import element_loads, power_balance
from dynamics.response.order_excitation import OrderExcitation, phasors_of

INERTIA = np.array([0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750])
STIFFNESS = 1e6 * np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976])
LOSS_FACTOR, ABSOLUTE = 0.035, 2.0
CYLINDERS = slice(2, 8)
FIRING = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
BORE, RADIUS, ROD = 0.105, 0.0685, 0.207
ORDERS = 0.5 * np.arange(1, 25)
FIRST = 2.0 * np.pi * 216.584
TWIST = np.eye(9)[1:] - np.eye(9)[:-1]
# Order 6 at its resonance with mode 1, and a speed between resonances.
SPEEDS = np.array([1900.0 * np.pi / 30.0, FIRST / 6.0])


def cylinder_torque():
    """Return the amplitudes of the orders of one cylinder's torque [N m], from its firing top."""
    angle_deg = np.arange(-360.0, 360.0, 0.5)
    angle = np.radians(angle_deg)
    pressure = 90e5 * np.exp(-(((angle_deg - 12.0) / 24.0) ** 2))
    swing = np.arcsin(RADIUS / ROD * np.sin(angle))
    torque = pressure * np.pi / 4.0 * BORE**2 * RADIUS * np.sin(angle + swing) / np.cos(swing)
    return phasors_of(harmonics(torque, angles_deg=angle_deg), ORDERS)


@pytest.fixture(scope="module")
def excitation():
    forces = np.zeros((ORDERS.size, SPEEDS.size, 9), dtype=complex)
    turned = cylinder_torque()[:, np.newaxis] * np.exp(-1j * np.outer(ORDERS, FIRING))
    forces[:, :, CYLINDERS] = turned[:, np.newaxis, :]
    return OrderExcitation(ORDERS, SPEEDS, forces)


def engine(**damping):
    return Chain(INERTIA, STIFFNESS, ground_damping=dict.fromkeys(range(2, 8), ABSOLUTE), **damping)


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_hysteretic_damping_order_by_order(excitation, method, figure):
    found = forced_response(engine(loss_factor=LOSS_FACTOR), excitation, method=method)
    loads = element_loads(found)
    stiffness = TWIST.T @ np.diag(STIFFNESS * (1.0 + 1j * LOSS_FACTOR)) @ TWIST
    absolute = np.zeros(9)
    absolute[CYLINDERS] = ABSOLUTE
    for place, speed in enumerate(SPEEDS):
        for number, order in enumerate(ORDERS):
            w = order * speed
            dynamic = stiffness + np.diag(1j * w * absolute - w**2 * INERTIA)
            motion = np.linalg.solve(dynamic, excitation.forces[number, place])
            size = np.max(np.abs(motion))
            own = found.motion[number, place]
            figure(f"motion, {method}, of the largest", own, motion, 1e-10, "rad", scale=size)
            torque = STIFFNESS * (1.0 + 1j * LOSS_FACTOR) * (TWIST @ motion)
            own, size = loads.elements.values[number, place], np.max(np.abs(torque))
            figure(f"torque, {method}, of the largest", own, torque, 1e-10, "N m", scale=size)
    figure(f"power balance, {method}", power_balance(found).error, 0.0, 1e-12, "", "absolute")


def test_synthesis_and_plain_sum_are_kept_apart(excitation):
    """What both say of the free end and of the most loaded shaft, at resonance and beside it."""
    found = forced_response(engine(loss_factor=LOSS_FACTOR), excitation)
    twist = found.elastic.synthesis
    torque = element_loads(found).elements.synthesis
    assert np.all(twist.amplitude < twist.plain_sum)
    assert np.all(torque.amplitude < torque.plain_sum)
    # The sum depends on how the orders meet: no order alone, nor the plain sum, stands for it.
    alone = found.elastic.amplitude[:, 1, 0]
    assert np.argmax(alone) == list(ORDERS).index(6.0)
    assert alone.max() < 0.8 * twist.amplitude[1, 0]
    assert np.min(twist.plain_sum[0] / twist.amplitude[0]) > 1.2


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 1])
def test_time_integration(excitation, place, figure):
    """One cycle of the periodic motion: velocities, twists, and the angle of the free end."""
    speed = SPEEDS[place]
    relative = LOSS_FACTOR * STIFFNESS / FIRST
    absolute = np.zeros(9)
    absolute[CYLINDERS] = ABSOLUTE
    damping = TWIST.T @ np.diag(relative) @ TWIST + np.diag(absolute)
    # State: 9 velocities, 8 twists; the angle of the rigid body has no place of its own.
    matrix = np.zeros((17, 17))
    matrix[:9, :9] = -damping / INERTIA[:, np.newaxis]
    matrix[:9, 9:] = -(TWIST.T * STIFFNESS) / INERTIA[:, np.newaxis]
    matrix[9:, :9] = TWIST
    cycle = 4.0 * np.pi / speed
    phasors = excitation.forces[:, place]

    def slope(time, state):
        torque = (np.exp(1j * ORDERS * speed * time) @ phasors).real
        own = matrix @ state[:17]
        own[:9] += torque / INERTIA
        return np.append(own, state[0])

    def run(start, times=None):
        return solve_ivp(
            slope, (0.0, cycle), start, "DOP853", t_eval=times, rtol=1e-9, atol=1e-12
        ).y

    start = np.linalg.solve(np.eye(17) - expm(matrix * cycle), run(np.zeros(18))[:17, -1])
    times = np.linspace(0.0, cycle, 20_001)
    states = run(np.append(start, 0.0), times)
    np.testing.assert_allclose(states[:17, -1], start, atol=1e-6 * np.max(np.abs(start)))

    found = forced_response(engine(damping=relative), excitation)
    twists = states[9:17]
    angles = states[17] + np.vstack((np.zeros(times.size), np.cumsum(twists, axis=0)))
    torques = STIFFNESS[:, np.newaxis] * twists + relative[:, np.newaxis] * (TWIST @ states[:9])
    loads = element_loads(found)
    for what, series, own in (
        ("angles", found.nodes, angles),
        ("torques", loads.elements, torques),
    ):
        half = 0.5 * (own.max(axis=1) - own.min(axis=1))
        unit = "rad" if what == "angles" else "N m"
        figure(f"amplitudes of {what}", series.synthesis.amplitude[place], half, 2e-5, unit)
        assert np.all(series.synthesis.plain_sum[place] > 1.05 * half)
    curve = loads.elements.at_angle(place, shaft_angle_deg=np.degrees(speed * times))
    largest = np.max(np.abs(torques))
    figure("torques over time, of the largest", curve.T, torques, 1e-6, "N m", scale=largest)
