"""Answers to harmonic forces: closed forms, both methods alike, reciprocity, power, and no bounds.

Tolerances: what both methods leave is round-off times the condition of the dynamic stiffness, at
most 1e5 for the chains made here.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.response.forced import forced_response
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import chain_system
from dynamics.response.loads import element_loads, power_balance
from dynamics.response.order_excitation import OrderExcitation


def any_chain(seed):
    """A branched chain of six nodes with a gear, a dashpot, distributed inertia, all damping."""
    draw = np.random.default_rng(seed)
    return Chain(
        inertia=draw.uniform(0.1, 2.0, 6),
        stiffness=draw.uniform(1e4, 1e5, 4),
        connections=[(0, 1), (1, 2), (1, 3), (4, 5)],
        ground={2: draw.uniform(0.0, 1e4)} if seed % 2 else None,
        damping=draw.uniform(0.0, 5.0, 4),
        loss_factor=draw.uniform(0.0, 0.1, 4),
        ground_damping={0: draw.uniform(0.1, 5.0), 3: 1.0},
        distributed_inertia=draw.uniform(0.0, 0.2, 4),
        dashpots=[Dashpot(0, 3, draw.uniform(0.1, 50.0))],
        gears=[Gear(3, 4, draw.choice([-2.0, 0.4]))],
    )


def any_excitation(chain, seed, speeds=(20.0, 50.0, 110.0)):
    draw = np.random.default_rng(seed)
    shape = (2, len(speeds), chain.inertia.size)
    return OrderExcitation(
        [1.0, 2.5], speeds, draw.normal(size=shape) + 1j * draw.normal(size=shape)
    )


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_any_chain(seed):
    """Modal equals direct, power in equals heat, and every node is in equilibrium."""
    chain = any_chain(seed)
    excitation = any_excitation(chain, seed)
    modal = forced_response(chain, excitation, magnifier=50.0)
    direct = forced_response(chain, excitation, magnifier=50.0, method="direct")
    largest = np.max(np.abs(direct.motion), axis=2, keepdims=True)
    assert np.max(np.abs(modal.motion - direct.motion) / largest) < 1e-10
    balance = power_balance(modal)
    np.testing.assert_allclose(balance.power_in, balance.dissipated, rtol=1e-9)
    assert balance.error < 1e-9
    assert np.all(balance.rest > 0.0)

    # The loads of elements, ground and dashpots are all that acts besides force and inertia.
    own = forced_response(chain, excitation)
    loads = element_loads(own)
    dashpot = np.zeros((1, 6))
    dashpot[0, [0, 3]] = -1.0, 1.0
    w = own.angular_frequencies[:, :, np.newaxis]
    left = (
        loads.elements.values @ chain.elongations()
        + loads.dashpots.values @ dashpot
        + loads.ground.values
        - w**2 * (own.motion @ chain.mass_matrix())
        - excitation.forces
    ) @ chain.expansion()
    assert np.max(np.abs(left)) < 1e-10 * np.max(np.abs(loads.elements.values))


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10_000))
def test_reciprocity(seed):
    """A force on one node moves another as much as one there moves the first."""
    chain = any_chain(seed)
    system = chain_system(chain)
    frequency = np.random.default_rng(seed).uniform(10.0, 500.0)
    one_each = np.eye(6, dtype=complex) @ system.expand
    answer = harmonic_response(system, np.full(6, frequency), one_each)
    receptance = answer.motion @ system.expand.T
    np.testing.assert_allclose(
        receptance, receptance.T, rtol=0.0, atol=1e-11 * np.max(np.abs(receptance))
    )


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_one_mass(method):
    """X = F / (k (1 + i eta) - m w^2 + i w c), below, at and above resonance, also critically damped."""
    speeds = np.array([3.0, 10.0, 200.0])
    forces = np.full((1, 3, 1), 7.0 - 2.0j)
    for damping in (0.3, 20.0):
        chain = Chain([1.0], [], ground=[100.0], ground_damping=[damping])
        found = forced_response(chain, OrderExcitation([1.0], speeds, forces), method=method)
        exact = (7.0 - 2.0j) / (100.0 - speeds**2 + 1j * speeds * damping)
        np.testing.assert_allclose(found.motion[0, :, 0], exact, rtol=1e-12)
    chain = Chain([1.0, 1e9], [100.0], loss_factor=0.04)
    forces = np.array([7.0, 0.0]) * np.ones((1, 3, 1))
    found = forced_response(chain, OrderExcitation([1.0], speeds, forces), method=method)
    exact = 7.0 / (100.0 * (1.0 + 0.04j) - speeds**2)  # beside an almost infinite mass
    np.testing.assert_allclose(found.motion[0, :, 0], exact, rtol=1e-7)


def test_unbounded_within_1e_9_and_a_number_beyond():
    """Two equal masses: w = sqrt(2 k / m) = 200 rad/s; the antisymmetric force drives it."""
    system = chain_system(Chain([1.0, 1.0], [2e4]))
    assert system.natural[0] == 0.0
    apart = np.array([-1e-8, -0.9e-9, 0.0, 0.9e-9, 1e-8])
    forces = np.tile(np.array([1.0 + 0j, -1.0]), (5, 1))
    for method in ("modal", "direct"):
        answer = harmonic_response(system, 200.0 * (1.0 + apart), forces, method)
        assert answer.unbounded.tolist() == [False, True, True, True, False]
        assert np.all(np.isfinite(answer.motion))
        # 2 F / (2 m (w_n^2 - w^2)), the difference of squares to 8 of its 16 digits
        exact = 1.0 / (200.0**2 - (200.0 * (1.0 + apart[[0, 4]])) ** 2)
        np.testing.assert_allclose(answer.motion[[0, 4], 0], exact, rtol=1e-6)
        # A force that does no work on the mode moves the rigid body only.
        together = harmonic_response(system, np.array([200.0]), np.ones((1, 2), complex), method)
        assert not together.unbounded[0]
        np.testing.assert_allclose(together.motion, -1.0 / 200.0**2, rtol=1e-9)


def test_damping_at_a_node_of_the_mode_leaves_it_unbounded():
    chain = Chain([1.0, 1.0, 1.0], [1e4, 1e4], ground_damping={1: 5.0})
    forces = np.array([[1.0 + 0j, 0.0, -1.0], [1.0, 0.0, 1.0]])
    answer = harmonic_response(chain_system(chain), np.array([100.0, 100.0]), forces)
    assert answer.unbounded.tolist() == [True, False]


def test_an_unknown_method_is_refused():
    system = chain_system(Chain([1.0, 1.0], [2e4]))
    with pytest.raises(InputError, match="method: given 'guess'"):
        harmonic_response(system, np.array([1.0]), np.ones((1, 2), complex), "guess")
