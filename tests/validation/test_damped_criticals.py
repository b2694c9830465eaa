"""Critical speeds with damping, damped modes, causes of peaks.

Source: matrices M, C, K, H of an engine of six cylinders with viscous damper, numpy alone: each order at
very many speeds, eigenvalues, sums over angles.

Tolerance: 1e-5: the reference, a parabola through neighbors 2e-4 of the speed apart, is off by less than
1e-6.

Eigenvalues are those of the state space; the orders are summed over many thousand angles. The forces are
those of gas and, growing with the squared speed, of masses. The reference holds where the half bandwidth is
5e-3 and more.
"""

import numpy as np
import pytest

import crankfem as cf
from comparing import close

CYLINDERS, INERTIA, FLYWHEEL, HUB = 6, 0.05, 2.0, 0.06
SPRING, RING, LOSS, ABSOLUTE = 1.2e6, 0.08, 0.01, 0.4
FIRING = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
ORDERS = 0.5 * np.arange(1, 25)
LOW, HIGH = 60.0, 320.0
NODES = CYLINDERS + 3  # hub, cylinders, flywheel, ring
# About 100 N m s/rad is best for the first mode.
DAMPERS = (2.0, 20.0, 60.0, 100.0, 250.0, 1000.0, 20000.0)


def matrices(damping):
    mass = np.diag([HUB, *[INERTIA] * CYLINDERS, FLYWHEEL, RING])
    stiffness, loss, viscous = (np.zeros((NODES, NODES)) for _ in range(3))
    for left in range(CYLINDERS + 1):
        ends = np.ix_([left, left + 1], [left, left + 1])
        stiffness[ends] += SPRING * np.array([[1.0, -1.0], [-1.0, 1.0]])
    loss += LOSS * stiffness
    viscous[1:7, 1:7] += ABSOLUTE * np.eye(6)
    ends = np.ix_([0, 8], [0, 8])
    viscous[ends] += damping * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return mass, viscous, stiffness, loss


def forces(order, speeds):
    """Torques on the nodes, (S, n): gas by a law of the order, masses with the squared speed."""
    gas = 2000.0 / (1.0 + order**2)
    masses = 4e-3 * speeds**2 * (1.0 if order in (1.0, 2.0, 3.0, 4.0, 6.0) else 0.05)
    own = np.zeros((len(speeds), NODES), dtype=complex)
    own[:, 1:7] = (gas - 0.3j * masses)[:, np.newaxis] * np.exp(-1j * order * FIRING)
    return own


def solved(damping, order, speeds):
    """Motion of the nodes, (S, n)."""
    mass, viscous, stiffness, loss = matrices(damping)
    w = (order * speeds)[:, np.newaxis, np.newaxis]
    dynamic = stiffness + 1j * loss + 1j * w * viscous - w**2 * mass
    return np.linalg.solve(dynamic, forces(order, speeds)[..., np.newaxis])[..., 0]


def torques(motion):
    return SPRING * np.diff(motion[:, :8], axis=1)


def response(damping, speeds=None):
    speeds = np.linspace(LOW, HIGH, 40) if speeds is None else speeds
    chain = cf.Chain(
        [HUB, *[INERTIA] * CYLINDERS, FLYWHEEL],
        [SPRING] * 7,
        loss_factor=LOSS,
        ground_damping=dict.fromkeys(range(1, 7), ABSOLUTE),
    )
    damper = cf.dampers.ViscousDamper(RING, damping)
    excitation = cf.OrderExcitation(
        ORDERS, speeds, np.array([forces(order, speeds) for order in ORDERS])
    )
    return cf.forced_response(cf.chains.with_damper(chain, 0, damper), excitation)


def searched(amplitude):
    """Peaks of a function of speeds on a fine grid: speed and height of the parabola at each."""
    speeds = LOW * np.exp(np.arange(0.0, np.log(HIGH / LOW), 2e-4))
    values = amplitude(speeds)
    tops = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
    found = []
    for top in tops.tolist():
        a, b, c = np.polyfit(
            (speeds[top - 1 : top + 2] / speeds[top]) - 1.0, values[top - 1 : top + 2], 2
        )
        found.append((speeds[top] * (1.0 - b / (2.0 * a)), c - b**2 / (4.0 * a)))
    return np.array(found).reshape(-1, 2)


def peaks_of_order(criticals, order):
    """Speed and amplitude of the peaks of one order, ascending speed."""
    own = [(one.speed, one.amplitude) for one in criticals if one.order == order and one.has_peak]
    return np.array(sorted(own)).reshape(-1, 2)


@pytest.mark.slow
@pytest.mark.parametrize("order", [4.5, 6.0, 9.0, 12.0])
def test_the_critical_speeds_are_the_peaks_of_the_torque(order, figure):
    compared = 0
    for damping in DAMPERS:
        peaks = searched(
            lambda speeds, damping=damping: np.abs(torques(solved(damping, order, speeds))).max(
                axis=1
            )
        )
        found = peaks_of_order(cf.response.damped_criticals(response(damping)), order)
        found = found[found[:, 1] > 1e-6 * peaks[:, 1].max(initial=0.0)]
        assert found.shape == peaks.shape
        figure("critical speed", found[:, 0], peaks[:, 0], 1e-5, "rad/s")
        figure("torque at the critical speed", found[:, 1], peaks[:, 1], 1e-5, "N m")
        compared += len(peaks)
    assert compared >= len(DAMPERS)


@pytest.mark.slow
def test_the_critical_speeds_are_the_peaks_of_the_free_end(figure):
    weights = np.array([HUB, *[INERTIA] * CYLINDERS, FLYWHEEL])

    def swing(damping, speeds):
        # The shaft's mean motion is that of its rigid body; the ring floats.
        motion = solved(damping, 6.0, speeds)[:, :8]
        return np.abs(motion[:, 0] - motion @ weights / weights.sum())

    for damping in DAMPERS:
        peaks = searched(lambda speeds, damping=damping: swing(damping, speeds))
        found = peaks_of_order(cf.response.damped_criticals(response(damping), node=0), 6.0)
        assert found.shape == peaks.shape
        figure("critical speed of the free end", found[:, 0], peaks[:, 0], 1e-5, "rad/s")
        figure("its amplitude", found[:, 1], peaks[:, 1], 1e-5, "rad")


def test_the_undamped_table_misses_these_peaks():
    """With a damper near its best the peak is 12 % below the speed of the undamped mode."""
    run = response(100.0)
    (own,) = [one for one in cf.response.damped_criticals(run) if (one.order, one.mode) == (6.0, 1)]
    (table,) = [one for one in cf.resonances(run) if (one.order, one.mode) == (6.0, 1)]
    assert own.undamped_speed == close(table.speed, rel=1e-9)
    assert own.speed < 0.95 * table.speed
    assert own.locked_speed < own.speed < own.undamped_speed


@pytest.mark.parametrize("damping", DAMPERS[::3])
def test_damped_modes_are_the_eigenvalues_of_the_state_space(damping, figure):
    mass, viscous, stiffness, loss = matrices(damping)
    none, one = np.zeros((NODES, NODES)), np.eye(NODES)
    inverse = np.linalg.inv(mass)
    state = np.block([[none, one], [-inverse @ (stiffness + 1j * loss), -inverse @ viscous]])
    own = np.linalg.eigvals(state)
    own = own[
        (own.imag > 0.1 * np.abs(own)) & (np.abs(own) > 1.0)
    ]  # some are zero but for round-off
    own = own[np.argsort(own.imag)]
    modes = cf.response.complex_modes(response(damping))
    figure("damped frequency", modes.frequencies, own.imag / (2.0 * np.pi), 1e-9, "Hz")
    figure("damping ratio", modes.damping_ratios, -own.real / np.abs(own), 1e-7)
    # What damps a mode: the heat of each kind in the mode's own motion over one cycle.
    chosen = 0
    shape, w = modes.shapes[:, chosen], own[chosen].imag
    ring = damping * w**2 * np.abs(shape[8] - shape[0]) ** 2
    oil = ABSOLUTE * w**2 * np.sum(np.abs(shape[1:7]) ** 2)
    steel = LOSS * SPRING * w * np.sum(np.abs(np.diff(shape[:8])) ** 2)
    share = modes.sources[chosen]["node 0 - damper ring"]
    figure("share of the damper in the damping", share, ring / (ring + oil + steel), 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("damping", DAMPERS[::3])
def test_the_parts_of_orders_add_up_to_the_peak(damping, figure):
    speeds = np.linspace(LOW, HIGH, 40)
    run = response(damping, speeds)
    loads = cf.response.element_loads(run).elastic
    index, place = 28, 4
    cause = cf.response.peak_cause(run, loads, place, index, unit="N m", kind="torsional")
    own = np.array([torques(solved(damping, order, speeds))[index, place] for order in ORDERS])
    angles = np.linspace(0.0, 4.0 * np.pi, 400_001)
    waves = np.zeros(angles.size)
    for order, wave in zip(ORDERS, own, strict=True):
        waves += (wave * np.exp(1j * order * angles)).real
    high, low = angles[np.argmax(waves)], angles[np.argmin(waves)]
    parts = [
        0.5 * (wave * (np.exp(1j * order * high) - np.exp(1j * order * low))).real
        for order, wave in zip(ORDERS, own, strict=True)
    ]
    figure("peak of all orders", cause.amplitude, 0.5 * np.ptp(waves), 1e-7, "N m")
    figure(
        "part of an order in the peak",
        [one.contribution for one in cause.parts],
        parts,
        1e-3,
        "N m",
        scale=0.5 * np.ptp(waves),
    )
    total = sum(one.contribution for one in cause.parts)
    figure("parts of all orders", total, cause.amplitude, 1e-12, "N m")
