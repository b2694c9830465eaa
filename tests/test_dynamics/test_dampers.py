"""Dampers: what they add to a chain, their best sizes and the search for them."""

import numpy as np
import pytest

from comparing import close
from dynamics.assessment.damper_sizing import (
    TrialSize,
    size_axial_damper,
    size_rubber_damper,
    size_viscous_damper,
    without_close_sizes,
)
from dynamics.assessment.limits import given_limit
from dynamics.assessment.response_curves import (
    damped_frequencies,
    element_load,
    node_amplitude,
    with_resonances,
)
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import (
    RubberDamper,
    ViscousDamper,
    main_inertia,
    rubber_damper_for,
    tuned_optimum,
    untuned_optimum,
    viscous_damper_for,
)
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import chain_system
from dynamics.response.order_excitation import OrderExcitation
from refusals import refusals, refusals_of, refused

# Main inertia 1, spring 1: frequency 1, static deflection 1 per unit torque.
MAIN = Chain([1.0], [], [1.0], names=["main"])
SPEEDS = np.linspace(0.5, 1.4, 3001)


def peak(chain, node=0, speeds=SPEEDS):
    forces = np.zeros((speeds.size, len(chain.names)), dtype=complex)
    forces[:, node] = 1.0
    motion = harmonic_response(chain_system(chain), speeds, forces).motion
    return np.max(np.abs(motion[:, node]))


def test_sized_dampers_calm_the_mode_they_are_for():
    chain = Chain([0.05, 0.1, 0.1, 2.0], [1e6, 1e6, 1e6])
    frequency = chain.modes().angular_frequencies[1]
    main, _ = main_inertia(chain, 0)
    speeds = np.linspace(0.5, 1.3, 2001) * frequency
    static = 1.0 / (main * frequency**2)
    for damper, best in (
        (viscous_damper_for(chain, 0, 0.2 * main), untuned_optimum(0.2)),
        (rubber_damper_for(chain, 0, 0.2 * main), tuned_optimum(0.2)),
    ):
        # Rigid motion and other modes add to the one mode: within a quarter of its peak.
        found = peak(damper.attached(chain, 0), speeds=speeds) / static
        assert found == close(best.magnifier, rel=0.25)


SIZING_MAIN = Chain([1.0], [], {0: 1.0}, connections=[], names=["main"])
SIZING_SPEEDS = np.linspace(0.4, 1.6, 121)
UNIT = OrderExcitation([1.0], SIZING_SPEEDS, np.ones((1, SIZING_SPEEDS.size, 1)))


def limit(value):
    return given_limit("amplitude", value, "rad", applies_to="main", source="test")


def test_axial_damper_of_one_mass():
    """Its peak is 1 / (2 z sqrt(1 - z^2)) static deflections, z = c / 2 for unit mass and spring."""
    found = size_axial_damper(
        SIZING_MAIN, 0, node_amplitude(UNIT, 0), limit(4.0), damping=(0.01, 5.0)
    )
    ratio = found.damper.damping / 2.0
    assert found.reached
    assert np.isinf(found.used_without)
    # The search aims at 0.05 % below the limit and knows the damping to as much.
    assert 1.0 / (2.0 * ratio * np.sqrt(1.0 - ratio**2)) == close(4.0, rel=2e-3)
    assert np.all(found.used_at_best[found.sizes < 0.99 * found.damper.damping] > 1.0)


def test_axial_damper_at_a_node_can_be_too_strong():
    """Beyond some damping the node is held, and the other one vibrates without any."""
    chain = Chain([1.0, 1.0], [1.0], {1: 1.0})
    force = np.zeros((1, SIZING_SPEEDS.size, 2))
    force[..., 1] = 1.0
    result = node_amplitude(OrderExcitation([1.0], SIZING_SPEEDS, force), 1)
    found = size_axial_damper(chain, 0, result, limit(1.0), damping=(1e-3, 1e3))
    assert not found.reached
    assert 0.1 < found.damper.damping < 10.0
    assert found.used_at_best[0] > 10.0 * found.used
    assert found.used_at_best[-1] > 10.0 * found.used


def test_sizes_of_a_searchs_end_are_told_once():
    tried = [
        TrialSize(size, np.empty(0), 2.0 - size) for size in (0.1, 0.5, 0.999, 1.001, 1.002, 3.0)
    ]
    assert [one.size for one in without_close_sizes(tried)] == [0.1, 0.5, 1.001, 3.0]
    assert without_close_sizes(tried[:1]) == tuple(tried[:1])


def test_a_free_nodes_amplitude_is_with_or_without_the_rigid_body():
    """Two equal masses, a unit force on one: 1 / (2 w^2) as one body, 1 / (2 (2 - w^2)) apart."""
    chain = Chain([1.0, 1.0], [1.0])
    force = np.zeros((1, 1, 2))
    force[..., 0] = 1.0
    speed = 0.5
    excitation = OrderExcitation([1.0], [speed], force)
    rigid, swinging = 0.5 / speed**2, 0.5 / (2.0 - speed**2)
    whole, elastic = (
        float(node_amplitude(excitation, 0, elastic=only)(chain).values[0])
        for only in (False, True)
    )
    # Half of the range over 360 samples of the turn or better: 1 - cos(0.5 deg) is 4e-5.
    assert whole == close(abs(swinging - rigid), rel=1e-4)
    assert elastic == close(swinging, rel=1e-4)


@pytest.mark.slow
def test_limit_out_of_reach_is_said_with_the_reason():
    found = size_viscous_damper(
        SIZING_MAIN, "main", node_amplitude(UNIT, 0), limit(5.0), ring_inertia=(0.01, 0.1)
    )
    assert not found.reached
    assert found.damper.ring_inertia == 0.1
    assert found.used == close(21.0 / 5.0, rel=1e-3)  # (2 + mu) / mu


def test_smallest_ring_is_enough_if_it_keeps_the_limit():
    found = size_rubber_damper(
        SIZING_MAIN,
        0,
        node_amplitude(UNIT, 0),
        limit(50.0),
        ring_inertia=(0.1, 0.4),
        loss_factor=0.39,
        tuning=0.909,
    )
    assert found.reached
    assert found.damper.ring_inertia == close(0.1)
    assert found.damper.angular_frequency == close(0.909)


def test_resonances_are_looked_at_however_coarse_the_speeds_are():
    chain = Chain([1.0], [], {0: 1.0}, connections=[], ground_damping={0: 0.02})
    coarse = OrderExcitation([0.5, 1.0], [0.5, 1.7, 4.1], np.ones((2, 3, 1)))
    finer = with_resonances(coarse, chain)
    # Orders 0.5 and 1 meet the damped frequency at 2 and 1 times it.
    own = np.sqrt(1.0 - 0.01**2)
    assert finer.speeds == close([0.5, own, 1.7, 2.0 * own, 4.1])
    assert damped_frequencies(chain) == close([own])
    # Half a cycle of order 0.5 off or on, order 1 alone has the magnifier 50 = 1 / (2 * 0.01).
    assert node_amplitude(coarse, 0)(chain).peak > 49.0
    assert max(node_amplitude(coarse, 0)(chain).values[[0, 2, 4]]) < 5.0


def test_ring_gets_no_force_and_loads_become_stresses():
    chain = Chain([1.0, 2.0], [3.0], loss_factor=0.1)
    force = np.zeros((1, SIZING_SPEEDS.size, 2))
    force[..., 0] = 1.0
    excitation = OrderExcitation([1.0], SIZING_SPEEDS, force)
    damped = ViscousDamper(0.2, 0.3).attached(chain, 0)
    load, stress = (element_load(excitation, 0, section=s)(damped) for s in (1.0, 1e-4))
    assert stress.values == close(1e4 * load.values)
    with refused("element"):
        element_load(excitation, 1)(chain)


test_impossible_ranges_are_refused = refusals_of(
    lambda options: size_viscous_damper(
        **{"chain": SIZING_MAIN, "node": 0, "result": node_amplitude(UNIT, 0)}
        | {"limit": limit(5.0)}
        | options
    ),
    ({"ring_inertia": (0.2, 0.1)}, "ring_inertia"),
    ({"ring_inertia": -1.0}, "ring_inertia"),
    ({"ring_inertia": 0.1, "damping": (0.0, 1.0)}, "damping[0]"),
    ({"ring_inertia": 0.1, "chain": Chain([1.0], [])}, "chain"),
)


@pytest.mark.slow
def test_viscous_damper_of_a_six_cylinder_engine():
    """Torsional chain of the MWM engine (doi 10.1243/14644193JMBD126), its first mode excited."""
    chain = Chain(
        [0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750],
        np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976]) * 1e6,
        ground_damping=dict.fromkeys(range(2, 8), 2.0),
    )
    orders, speeds = np.arange(0.5, 12.5, 0.5), np.linspace(80.0, 260.0, 60)
    phases = np.exp(-1j * np.outer(orders, np.radians([0, 480, 240, 600, 120, 360])))
    forces = np.zeros((orders.size, speeds.size, 9), dtype=complex)
    forces[:, :, 2:8] = (800.0 / (1.0 + (orders / 2.0) ** 2) * phases.T).T[:, np.newaxis]
    result = element_load(OrderExcitation(orders, speeds, forces), 6, section=1e-4)
    bare = result(chain).peak
    wanted = given_limit("stress", bare / 3.5, "Pa", applies_to="crankshaft", source="test")
    found = size_viscous_damper(chain, 0, result, wanted, ring_inertia=(0.02, 0.5))
    assert found.reached
    # Aimed at 0.05 % below the limit; the size is known to as much.
    assert 0.998 < found.used <= 1.0
    # A ring 3 % smaller keeps the limit with no damping.
    smaller = size_viscous_damper(
        chain, 0, result, wanted, ring_inertia=0.97 * found.damper.ring_inertia
    )
    assert not smaller.reached


test_refused = refusals(
    ("damper.damping", lambda: ViscousDamper(1.0, 0.0)),
    ("damper.loss_factor", lambda: RubberDamper(1.0, 1.0, loss_factor=-0.1)),
    ("mass_ratio", lambda: tuned_optimum(0.0)),
    ("node", lambda: ViscousDamper(1.0, 1.0).attached(MAIN, "hub")),
    ("name", lambda: ViscousDamper(1.0, 1.0, name="main").attached(MAIN, 0)),
    ("mode", lambda: main_inertia(MAIN, 0, 2)),
    ("node", lambda: main_inertia(Chain([1.0, 1.0, 1.0], [1.0, 1.0]), 1)),
)
