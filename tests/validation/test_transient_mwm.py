"""Time integration of the MWM diesel's vibration.

Source: scipy's DOP853, quadrature of Duhamel's integral and the harmonic solution; engine of Mendes et al.
2008, doi 10.1243/14644193JMBD126.

Tolerance: 1e-9 of the largest order, as steps are exact for polynomial forces; DOP853 (relative tolerance
1e-10) and the quadrature set the others.

The engine: inertias, stiffnesses, absolute damping of 2 N m s/rad at each cylinder (nodes 3 to 8), loss
factor 0.035 of every shaft, firing offsets (0, 4, 2, 5, 1, 3) times 120 deg. The torque is stated in
`torque`. The harmonic solution uses the same viscous damping as the integration.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from comparing import close
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.motions import steady_motion, transient_motion
from dynamics.transient.propagator import SpeedCurve, viscous_system

INERTIA = [0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750]
STIFFNESS = np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976]) * 1e6
CYLINDERS = range(2, 8)
FIRING = np.array([0, 4, 2, 5, 1, 3]) * np.radians(120.0)
ORDERS = np.arange(0.5, 12.25, 0.5)
SPEEDS = np.linspace(100.0, 260.0, 9)


def mwm():
    return Chain(
        INERTIA, STIFFNESS, ground_damping=dict.fromkeys(CYLINDERS, 2.0), loss_factor=0.035
    )


def torque(failing=()):
    """Order k of each cylinder: 900 N m / (1 + k^1.5), lagging by 0.4 k rad, and one part by speed."""
    sizes = 900.0 / (1.0 + ORDERS**1.5) * np.exp(-0.4j * ORDERS)
    phasors = sizes[:, np.newaxis] * np.exp(-1j * np.outer(ORDERS, FIRING))
    phasors[:, list(failing)] *= 0.2
    forces = np.zeros((ORDERS.size, SPEEDS.size, 9), dtype=complex)
    growing = 1.0 - 0.3 * (SPEEDS / 200.0) ** 2
    forces[:, :, CYLINDERS] = phasors[:, np.newaxis] * growing[:, np.newaxis]
    return OrderExcitation(ORDERS, SPEEDS, forces)


@pytest.mark.parametrize("failing", [(), (3,)])
def test_steady_motion_is_the_harmonic_solution(failing, figure):
    chain, acting = mwm(), torque(failing)
    same = viscous_system(chain)
    for method in ("modal", "direct"):
        wanted = forced_response(same.system, acting, method=method).motion
        for place in (0, 3, 8):
            found = steady_motion(chain, acting, float(SPEEDS[place])).phasors(ORDERS)
            largest = np.max(np.abs(wanted[:, place]))
            what = f"steady motion against the harmonic one, {method}"
            figure(what, found, wanted[:, place], 1e-9, "rad", scale=largest)


def test_loss_factors_as_viscous_are_near_where_they_are_right(figure):
    # Resonance of order 6 at the first mode: its size is set by damping right at that frequency.
    chain = mwm()
    speed = float(chain.modes().angular_frequencies[1]) / 6.0
    found = steady_motion(chain, torque(), speed).phasors([6.0])[0]
    exact = OrderExcitation(
        [6.0], [speed], (900.0 / (1 + 6**1.5)) * _only(torque(), speed)[np.newaxis, np.newaxis]
    )
    wanted = forced_response(chain, exact).motion[0, 0]
    # 0.1 %: of the elastic motion the damping is equal, and the rest is far from resonance.
    largest = np.max(np.abs(wanted))
    figure("loss factors as viscous, at resonance", found, wanted, 1e-3, "rad", scale=largest)


def _only(acting, speed):
    growing = 1.0 - 0.3 * (speed / 200.0) ** 2
    shape = np.zeros(9, dtype=complex)
    shape[list(CYLINDERS)] = growing * np.exp(-2.4j) * np.exp(-6j * FIRING)
    return shape


@pytest.mark.slow
def test_run_up_by_an_integrator_of_its_own(figure):
    """The same run by DOP853 in the physical coordinates, forces written out by hand."""
    chain = mwm()
    start, rate, duration = 180.0, 400.0, 0.1
    curve = SpeedCurve.ramp(
        start, start + rate * duration, duration=duration, start_angle_deg=math.degrees(0.2)
    )
    run = transient_motion(chain, torque(), curve, start="rest")
    damping = viscous_system(chain).system.damping
    phasors = torque().forces[:, 0] / (1.0 - 0.3 * (100.0 / 200.0) ** 2)
    inverse = 1.0 / np.array(INERTIA)

    def slope(time, state):
        speed = start + rate * time
        angle = 0.2 + start * time + 0.5 * rate * time**2
        force = (1.0 - 0.3 * (speed / 200.0) ** 2) * (np.exp(1j * ORDERS * angle) @ phasors).real
        motion, velocity = state[:9], state[9:]
        force = force - chain.stiffness_matrix() @ motion - damping @ velocity
        return np.concatenate((velocity, inverse * force))

    found = solve_ivp(
        slope,
        (0.0, duration),
        np.zeros(18),
        method="DOP853",
        rtol=1e-10,
        atol=1e-13,
        t_eval=run.time,
    )
    springs = (STIFFNESS[:, np.newaxis] * chain.elongations() @ found.y[:9]).T
    largest = np.max(np.abs(springs))
    figure("run-up by DOP853: torques", run.torque, springs, 1e-6, "N m", scale=largest)
    whole, own = run.motion + run.rigid_motion, found.y[:9].T
    figure("run-up by DOP853: motion", whole, own, 1e-6, "rad", scale=np.max(np.abs(own)))


def test_work_of_the_forces_is_what_damping_takes(figure):
    """Over a cycle of the steady motion; velocities by the exact derivative of its Fourier series."""
    chain, acting, speed = mwm(), torque(), 200.0
    found = steady_motion(chain, acting, speed)
    count = found.shaft_angle_deg.size
    numbers = np.fft.rfftfreq(count, 1.0 / count) / found.turns * speed
    spectrum = np.fft.rfft(found.motion, axis=0)
    velocity = np.fft.irfft(1j * numbers[:, np.newaxis] * spectrum, count, axis=0)
    given = acting.at_angle(
        int(np.flatnonzero(speed == SPEEDS)[0]), shaft_angle_deg=found.shaft_angle_deg
    )
    work = np.sum(given * velocity)
    taken = np.sum(velocity @ found.system.system.damping * velocity)
    # 1e-6 is what power balances of this project keep; both sums are exact for such series.
    figure("work of the forces and of damping, each times a constant", work, taken, 1e-6)
    assert work > 0.0


MASS, NATURAL, RATIO, FORCE, PHASE = 2.0, 100.0, 0.03, 5.0, 0.7


def oscillator():
    held = {"ground": [MASS * NATURAL**2], "ground_damping": [2.0 * RATIO * NATURAL * MASS]}
    forces = np.full((1, 2, 1), FORCE * np.exp(1j * PHASE))
    return Chain([MASS], [], **held), OrderExcitation([2.0], [20.0, 80.0], forces)


def test_sweep_through_resonance_is_duhamels_integral(figure):
    """x(t) = integral of h(t - s) F cos(2 phi(s) + a) ds / m, phi = phi_0 + W s + c s^2 / 2.

    By 600 Gauss points over at most 100 radians of the integrand, which leaves round-off.
    """
    chain, acting = oscillator()
    start, rate, angle = 30.0, 80.0, 0.3
    curve = SpeedCurve.ramp(start, 70.0, acceleration=rate, start_angle_deg=np.degrees(angle))
    run = transient_motion(chain, acting, curve, start="rest")
    damped = NATURAL * np.sqrt(1.0 - RATIO**2)
    places, weights = np.polynomial.legendre.leggauss(600)
    for number in np.linspace(20, run.time.size - 1, 6).astype(int):
        time = run.time[number]
        s = 0.5 * time * (places + 1.0)
        answer = np.exp(-RATIO * NATURAL * (time - s)) * np.sin(damped * (time - s))
        turned = angle + start * s + 0.5 * rate * s**2
        swept = FORCE / (MASS * damped) * answer * np.cos(2.0 * turned + PHASE)
        wanted = 0.5 * time * np.sum(weights * swept)
        own, largest = run.motion[number, 0], np.abs(run.motion).max()
        figure("sweep by Duhamel's integral", own, wanted, 1e-9, "m", scale=largest)


@pytest.mark.slow
def test_slow_run_up_tends_to_the_steady_amplitudes():
    """What a run-up is off by falls with the acceleration a, by about a / (zeta w_0)^2 times 2.

    The window over which amplitudes are taken adds to it, also in proportion to a.
    """
    chain, acting = oscillator()
    off = []
    for duration in (100.0, 400.0):
        run = transient_motion(chain, acting, SpeedCurve.ramp(40.0, 60.0, duration=duration))
        found = run.envelope()
        w = 2.0 * found.speed
        steady = FORCE / MASS / np.abs(NATURAL**2 - w**2 + 2j * RATIO * NATURAL * w)
        off.append(np.max(np.abs(found.motion[:, 0] - steady)) / np.max(steady))
    assert off[1] < 0.02
    assert off[1] == close(0.25 * off[0], rel=0.15)
