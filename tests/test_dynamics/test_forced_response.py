"""Forced vibration of damped chains."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import crankshaft_limit
from dynamics.assessment.limits import AmplitudeCurve, given_limit, worst_use
from dynamics.assessment.response_curves import largest_amplitude, speeds_above, with_resonances
from dynamics.assessment.verdict import judge
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.editing import join_chains
from dynamics.chains.shaft_line import Coupling, RigidBody, ShaftLine
from dynamics.chains.varying import Variation, Varying
from dynamics.excitation.chain_excitation import combined_excitation
from dynamics.harmonics import harmonics
from dynamics.plots.curves import quantity_display
from dynamics.response.damped_criticals import damped_criticals
from dynamics.response.forced import forced_response
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import EngineMagnifier, chain_system, damped
from dynamics.response.loads import (
    alternating_stress,
    element_loads,
    load_quantities,
    named_quantity,
    power_balance,
    section_modulus,
)
from dynamics.response.order_excitation import OrderExcitation, at_angles, phasors_of
from dynamics.response.peak_cause import peak_cause
from dynamics.response.resonance import refined_speeds, resonances
from dynamics.response.series import (
    OrderSeries,
    common_order,
    extreme_angles,
    synthesis,
)
from equilibrium import unbalanced
from refusals import refusals, refusals_of, refused

TWO = Chain([1.0, 1.0], [2e4], names=["pulley", "flywheel"])  # 200 rad/s
SPEEDS = np.array([50.0, 100.0, 150.0])
PUSH = np.ones((2, 3, 2)) * np.array([1.0 + 0j, -1.0])


def excitation(forces=PUSH):
    return OrderExcitation([1.0, 2.0], SPEEDS, forces)


def test_unbounded_is_told_in_every_result():
    """Order 2 at 100 rad/s meets 200 rad/s: inf there, numbers elsewhere, NaN nowhere."""
    found = forced_response(TWO, excitation())
    assert np.argwhere(found.unbounded).tolist() == [[1, 1]]
    loads = element_loads(found)
    stress = alternating_stress(loads, {"pulley - flywheel": 1e-5})
    heat = power_balance(found)
    for values in (found.amplitude, loads.elements.amplitude, stress.amplitude, heat.power_in):
        assert np.all(np.isinf(values[1, 1]))
        assert np.count_nonzero(np.isinf(values)) == values[1, 1].size
        assert not np.any(np.isnan(values))
    for series in (found.nodes, found.elastic, loads.elastic, loads.ground, stress):
        both = series.synthesis
        assert both.unbounded.tolist() == [False, True, False]
        assert np.all(np.isinf(both.amplitude[1]))
        assert np.all(np.isinf(both.plain_sum[1]))
        assert np.all(np.isfinite(both.amplitude[[0, 2]]))
        with refused("speed_index"):
            series.at_angle(1, shaft_angle_deg=[0.0])
    (meeting,) = resonances(found, "flywheel")
    assert meeting.unbounded
    assert meeting.amplitude == meeting.estimate == meeting.magnifier == np.inf
    assert meeting.severity == 1.0
    assert heat.error < 1e-14


def test_loads_and_stress():
    """A twist of 2 F / (2 k - m w^2) and its torque; heat by hand."""
    chain = Chain([1.0, 1.0], [2e4], loss_factor=0.05, damping=3.0)
    found = forced_response(chain, excitation())
    loads = element_loads(found)
    w = np.outer([1.0, 2.0], SPEEDS)
    dynamic = 2e4 * (1.0 + 0.05j) + 3.0j * w
    twist = -2.0 / (2.0 * dynamic - w**2)
    np.testing.assert_allclose(loads.elements.values[:, :, 0], dynamic * twist, rtol=1e-10)
    np.testing.assert_allclose(loads.elastic.values[:, :, 0], 2e4 * twist, rtol=1e-10)
    stress = alternating_stress(loads, section_modulus("torsional", [0.05], [0.02]))
    np.testing.assert_allclose(
        stress.amplitude[:, :, 0],
        2e4 * np.abs(twist) * 16.0 * 0.05 / (np.pi * (0.05**4 - 0.02**4)),
        rtol=1e-10,
    )
    assert section_modulus("axial", 0.05, 0.02) == close(np.pi / 4 * (0.05**2 - 0.02**2))
    heat = power_balance(found)
    by_hand = 0.5 * w * (2e4 * 0.05 + w * 3.0) * np.abs(twist) ** 2
    np.testing.assert_allclose(heat.elements[:, :, 0], by_hand, rtol=1e-10)
    assert np.all(heat.rest == 0.0)
    assert heat.error < 1e-12
    # Matrices tell no elements apart, but the same heat.
    as_matrices = power_balance(forced_response(found.system, excitation()))
    np.testing.assert_allclose(as_matrices.rest, heat.dissipated, rtol=1e-10)
    assert as_matrices.elements.shape == (2, 3, 0)
    # The rigid body is left out of the elastic motion: equal masses move apart alike.
    np.testing.assert_allclose(found.elastic.values.sum(axis=2), 0.0, atol=1e-20)


def test_phasors_from_samples_and_aliasing():
    found = harmonics(10.0 + 8.0 * np.cos(1.5 * np.radians(np.arange(0.0, 720.0, 30.0)) - 0.4))
    np.testing.assert_allclose(
        phasors_of(found, [1.0, 1.5]), [0.0, 8.0 * np.exp(-0.4j)], atol=1e-14
    )
    with refused("order"):
        phasors_of(found, [1.5, 22.5])  # it would look like order 1.5
    with refused("order"):
        phasors_of(found, [6.0])


test_excitation_refused = refusals_of(
    lambda orders, speeds, forces: OrderExcitation(orders, speeds, forces),
    ([1.0, 2.0], SPEEDS[::-1], PUSH, "speeds[1]"),
    ([0.0, 1.0], SPEEDS, PUSH, "orders[0]"),
    ([1.0, 2.0], [0.0, 1.0, 2.0], PUSH, "speeds[0]"),
    ([1.0, 2.0], SPEEDS, PUSH[:1], "forces"),
    ([], SPEEDS, PUSH, "orders"),
)


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


def pressed(chain, seed, speeds=(20.0, 50.0, 110.0)):
    """An excitation from outside and by elements that push their ends apart, and the part from outside."""
    draw = np.random.default_rng(seed)
    outside, pressing = (
        draw.normal(size=shape) + 1j * draw.normal(size=shape)
        for shape in ((2, len(speeds), n) for n in (chain.inertia.size, len(chain.elements)))
    )
    pushed = outside.copy()
    for place, (first, second) in enumerate(chain.connections):
        pushed[:, :, first] -= pressing[:, :, place]
        pushed[:, :, second] += pressing[:, :, place]
    return OrderExcitation([1.0, 2.5], speeds, pushed, pressing), outside


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_any_chain(seed):
    """Modal equals direct, power in equals heat, and every node is in equilibrium."""
    chain = any_chain(seed)
    excitation, outside = pressed(chain, seed)
    modal = forced_response(chain, excitation, magnifier=50.0)
    direct = forced_response(chain, excitation, magnifier=50.0, method="direct")
    largest = np.max(np.abs(direct.motion), axis=2, keepdims=True)
    assert np.max(np.abs(modal.motion - direct.motion) / largest) < 1e-10
    balance = power_balance(modal)
    np.testing.assert_allclose(balance.power_in, balance.dissipated, rtol=1e-9)
    assert balance.error < 1e-9
    assert np.all(balance.rest > 0.0)

    # The loads of elements, ground and dashpots are all that acts besides outside force and inertia.
    for damping in ({}, {"magnifier": 50.0}):
        answer = forced_response(chain, excitation, **damping)
        assert unbalanced(answer, outside) < 1e-10
        strained, named = element_loads(answer).elastic, load_quantities(answer).series(answer)
        np.testing.assert_allclose(named.values, strained.values, rtol=1e-9, atol=1e-12)


def test_what_pushes_elements_apart_is_interpolated_and_added_with_its_forces():
    chain = any_chain(5)
    acting, outside = pressed(chain, 5)
    plain = OrderExcitation(acting.orders, acting.speeds, outside)

    def from_outside(excitation):
        return excitation.forces - excitation.pressing @ chain.elongations()

    for change in (
        lambda excitation: excitation.at_speeds([20.0, 35.0, 90.0]),
        lambda excitation: with_resonances(excitation, chain),
    ):
        np.testing.assert_allclose(from_outside(change(acting)), change(plain).forces, atol=1e-12)
    both = combined_excitation(OrderExcitation([1.0, 3.0], acting.speeds, outside), acting)
    assert both.orders.tolist() == [1.0, 2.5, 3.0]
    np.testing.assert_allclose(
        from_outside(both), [2.0 * outside[0], outside[1], outside[1]], atol=1e-12
    )
    with refused("pressing"):
        replace(acting, pressing=np.ones((2, 3)))
    with refused("excitation"):
        forced_response(chain, replace(acting, pressing=np.ones((2, 3, 2))))


def test_load_of_an_element_that_pushes_its_ends_apart_is_what_its_masses_take():
    """Two equal masses pushed apart by P: k d = P w_n^2 / (w_n^2 - w^2 + i w w_n / M), and N = k d - P."""
    speeds, push, magnifier = np.linspace(10.0, 300.0, 400), 7.0, 25.0
    forces = push * np.array([-1.0, 1.0]) * np.ones((1, speeds.size, 2))
    acting = OrderExcitation([1.0], speeds, forces, np.full((1, speeds.size, 1), push))
    answer = forced_response(damped(TWO, modal_damping=0.5 / magnifier), acting)

    def by_hand(w, natural=200.0):
        apart = natural**2 - w**2 + 1j * w * natural / magnifier
        return push * (natural**2 / apart - 1.0)

    load = element_loads(answer).elastic
    np.testing.assert_allclose(load.values[0, :, 0], by_hand(speeds), rtol=1e-9)
    (peak,) = (one for one in damped_criticals(answer) if one.of_load)
    assert peak.amplitude == close(np.max(np.abs(by_hand(np.linspace(199, 201, 999)))))
    assert peak.mode_share == close(1.0, rel=1e-6)
    # The mode makes the whole load at each speed, so far below its resonance the order is forced.
    for speed, state in ((60.0, "forced"), (200.0, "at resonance")):
        index = int(np.argmin(np.abs(speeds - speed)))
        (part,) = peak_cause(answer, load, 0, index).parts
        assert (part.mode, part.state) == (1, state)
        assert part.mode_share == close(1.0, rel=1e-6)


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


ONE = Chain([1.0], [], ground=[1e4])  # 100 rad/s
LOSS_TWO = Chain([1.0, 1.0], [2e4])  # 200 rad/s


def magnification(chain, speed):
    """Amplitude at resonance over the static one of the elastic mode."""
    forces = np.array([1.0, -1.0])[: chain.chain.inertia.size] * np.ones((1, 1, 1))
    found = forced_response(chain, OrderExcitation([1.0], [speed], forces))
    static = 1.0 / speed**2
    return found.amplitude[0, 0, 0] / static


@pytest.mark.parametrize(
    ("chain", "speed", "choice"),
    [
        (LOSS_TWO, 200.0, {}),
        (ONE, 100.0, {}),
        (LOSS_TWO, 200.0, {"magnifier": 40.0}),
        (LOSS_TWO, 200.0, {"modal_damping": 1.0 / 80.0}),
        (LOSS_TWO, 200.0, {"modal_damping": [1.0 / 80.0]}),
        (LOSS_TWO, 200.0, {"loss_factor": 1.0 / 40.0}),
        (LOSS_TWO, 200.0, {"element_magnifier": {0: 40.0}}),
        (LOSS_TWO, 200.0, {"relative": 2e4 / (200.0 * 40.0)}),
        (LOSS_TWO, 200.0, {"absolute": {0: 5.0, 1: 5.0}}),  # I w / M = 200 / 40
        (LOSS_TWO, 200.0, {"engine_magnifier": EngineMagnifier(40.0, (0, 1), 100.0 / np.pi)}),
        (LOSS_TWO, 200.0, {"loss_factor": 1.0 / 80.0, "magnifier": 80.0}),  # losses add up
    ],
)
def test_each_kind_gives_a_magnifier_of_40(chain, speed, choice):
    found = damped(chain, source="a test bed", **choice)
    assert magnification(found, speed) == close(40.0, rel=1e-11)
    np.testing.assert_allclose(found.system.damping_ratios(), 1.0 / 80.0, rtol=1e-11)
    assert len(found.record) == max(1, len(choice))
    assert found.record[0].endswith(": a test bed") or not choice


def test_own_damping_stays_and_needs_no_default():
    own = Chain([1.0, 1.0], [2e4], loss_factor=0.01, damping=0.5)
    found = damped(own)
    assert len(found.record) == 1
    np.testing.assert_array_equal(found.system.damping, damped(own).chain.damping_matrix())
    for kind, choice in {
        "relative": {"relative": [1.0]},
        "loss_factor": {"loss_factor": [0.02]},
        "element_magnifier": {"element_magnifier": {0: 40.0}},
    }.items():
        with pytest.raises(InputError, match=f"^{kind}: given damping of node 0 - node 1, which"):
            damped(own, **choice)
    more = damped(own, relative=[1.0], loss_factor=[0.02], add=True)
    assert more.chain.damping[0] == 1.5
    assert more.chain.loss_factor[0] == close(0.03)
    assert len(more.record) == 3


def test_a_node_is_damped_once():
    own = Chain([1.0, 1.0], [2e4], ground_damping={0: 5.0})
    with refused("absolute"):
        damped(own, absolute={0: 5.0})
    with refused("engine_magnifier"):
        damped(own, absolute={1: 2.0}, engine_magnifier=EngineMagnifier(40.0, (1,), 20.0))
    assert damped(own, absolute={0: 5.0}, add=True).chain.ground_damping[0] == 10.0
    assert damped(own, magnifier=40.0, loss_factor=0.01).chain.loss_factor[0] == 0.01


def test_undamped_on_purpose():
    found = damped(LOSS_TWO, undamped=True)
    assert found.record == ("no damping, on purpose",)
    assert magnification(found, 200.0) == np.inf
    assert np.all(found.system.damping_ratios() == 0.0)


test_refused_loss = refusals_of(
    lambda choice: damped(LOSS_TWO, **choice),
    ({"magnifier": 40.0, "modal_damping": 0.01}, "magnifier"),
    ({"undamped": True, "relative": 1.0}, "undamped"),
    ({"magnifier": 0.0}, "magnifier"),
    ({"modal_damping": [0.1, 0.1]}, "modal_damping"),
    ({"loss_factor": -0.1}, "loss_factor[0]"),
    ({"relative": [1.0, 1.0]}, "relative"),
    ({"relative": {1: 1.0}}, "relative[1]"),
    ({"element_magnifier": 0.0}, "element_magnifier[0]"),
    ({"absolute": {2: 1.0}}, "absolute[2]"),
)


SUM_ONE = np.array([100.0])


def test_against_dense_samples():
    """24 half orders with random phases: no sample of 40,001 exceeds, the best comes within 2e-6.

    A sample stands at most half a step, 1.6e-4 rad, from the peak, where the sum has fallen by up
    to (12 * 1.6e-4)^2 / 2 = 1.8e-6 of its amplitude.
    """
    draw = np.random.default_rng(4)
    orders = 0.5 * np.arange(1, 25)
    phasors = draw.normal(size=(24, 1, 40)) + 1j * draw.normal(size=(24, 1, 40))
    found = synthesis(orders, SUM_ONE, phasors)
    assert found.period == close(4.0 * np.pi)
    angles = np.linspace(0.0, 4.0 * np.pi, 40_001)
    for place in range(3):
        dense = at_angles(orders, phasors[:, 0, place], angles)
        assert dense.max() <= found.highest[0, place] * (1.0 + 1e-14)
        assert dense.min() >= found.lowest[0, place] * (1.0 + 1e-14)
        half = 0.5 * (dense.max() - dense.min())
        assert found.amplitude[0, place] == close(half, rel=2e-6)
    assert np.all(found.amplitude < found.plain_sum)


def test_plain_sum_is_reached_where_peaks_meet_and_rest_is_rest():
    phasors = np.zeros((3, 1, 2), dtype=complex)
    phasors[:, 0, 0] = [1.0, 2.0, 3.0]
    found = synthesis(np.array([1.0, 3.0, 5.0]), SUM_ONE, phasors)
    np.testing.assert_allclose(found.amplitude, [[6.0, 0.0]], rtol=1e-14)
    np.testing.assert_allclose(found.plain_sum, [[6.0, 0.0]], rtol=1e-14)


def test_common_order():
    multiples, common = common_order(np.array([0.5, 1.5, 4.0]))
    assert (multiples.tolist(), common) == ([1, 3, 8], 0.5)
    assert common_order(np.array([4.0, 8.0]))[1] == 4.0
    assert common_order(np.array([1.0 / 3.0, 0.5]))[1] == close(1.0 / 6.0)


def test_of_equal_peaks_the_first_is_told():
    """Order 1 alone has two equal peaks in a cycle of two revolutions; round-off may raise either."""
    orders = np.array([0.5, 1.0])
    for noise in (-1e-13, 1e-13):
        phasors = np.array([noise, np.exp(-0.5j)])
        assert extreme_angles(orders, phasors) == close((0.5, 0.5 + np.pi), rel=1e-6)


# Six cylinders and a flywheel, firing 1-5-3-6-2-4.
ENGINE = Chain([0.05] * 6 + [2.0], [1.2e6] * 6)
FIRING = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
ORDERS = 0.5 * np.arange(1, 25)
RANGE = (100.0, 300.0)


def peak_excitation(speeds, orders=ORDERS):
    own = 1000.0 / (1.0 + orders**2)[:, np.newaxis] * (1.0 + 1e-5 * np.asarray(speeds) ** 2)
    forces = np.zeros((orders.size, len(speeds), 7), dtype=complex)
    forces[:, :, :6] = own[:, :, np.newaxis] * np.exp(-1j * np.outer(orders, FIRING))[:, np.newaxis]
    return OrderExcitation(orders, speeds, forces)


def test_each_resonance_is_calculated_at_its_own_speed():
    chain = damped(ENGINE)
    table = resonances(forced_response(chain, peak_excitation([100.0, 300.0])))
    frequencies = ENGINE.modes().frequencies
    assert [own.speed for own in table] == sorted(own.speed for own in table)
    assert {own.mode for own in table} == {1, 2}
    for own in table:
        assert own.frequency == close(frequencies[own.mode], rel=1e-12)
        assert own.order * own.speed == close(2.0 * np.pi * own.frequency, rel=1e-14)
        # The force at that speed is known exactly from two, as it follows the squared speed.
        alone = peak_excitation([own.speed], np.array([own.order]))
        exact = forced_response(chain, alone).amplitude[0, 0, 0]
        assert own.amplitude == close(exact, rel=1e-9)
        assert own.magnifier == close(40.0, rel=1e-9)
        assert own.estimate == close(own.equilibrium * own.magnifier, rel=1e-12)
        if own.share > 0.1 and own.mode == 1:
            # Other modes, at rest beside a magnifier of 40 of this one, are all that differs.
            assert own.estimate == close(own.amplitude, rel=5e-3)
    assert {own.order for own in table if own.kind == "major"} == {6.0, 9.0, 12.0}
    worst = max(table, key=lambda own: own.amplitude)
    assert (worst.order, worst.mode, worst.kind, worst.severity) == (6.0, 1, "major", 1.0)
    # Mode 1 does not change sign from cylinder to cylinder: at major orders all work together.
    assert worst.share == close(1.0, abs=1e-9)
    assert worst.speed_rpm == close(worst.speed * 30.0 / np.pi)


def test_no_resonance_in_range_and_no_force():
    response = forced_response(damped(ENGINE), peak_excitation([100.0, 300.0], np.array([0.5])))
    assert resonances(response) == ()
    silent = OrderExcitation([6.0], [100.0, 300.0], np.zeros((1, 2, 7)))
    (only, *_) = resonances(forced_response(ENGINE, silent))
    assert (only.amplitude, only.share, only.severity, only.estimate) == (0.0, 0.0, 0.0, 0.0)
    assert not only.unbounded


def test_undamped_resonance_stands_among_the_speeds():
    chain = damped(ENGINE, undamped=True)
    frequencies = chain.system.elastic_frequencies
    speeds = refined_speeds(frequencies, 0.0, [6.0], RANGE)
    response = forced_response(chain, peak_excitation(speeds, np.array([6.0])))
    critical = 2.0 * np.pi * frequencies / 6.0
    inside = critical[(critical >= RANGE[0]) & (critical <= RANGE[1])]
    assert np.count_nonzero(response.unbounded) == inside.size > 0


test_refused_peak = refusals_of(
    lambda given: refined_speeds(*given),
    (([50.0], 0.01, [1.0], (300.0, 100.0)), "speed_range"),
    (([50.0], [0.01, 0.02], [1.0], RANGE), "damping_ratios"),
    (([50.0], -0.01, [1.0], RANGE), "damping_ratios[0]"),
)


GRID_SPEEDS = np.linspace(40.0, 80.0, 150)


@pytest.fixture
def series():
    rng = np.random.default_rng(7)
    shape = (6, GRID_SPEEDS.size, 4)
    values = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    return OrderSeries(
        0.5 * np.arange(1.0, 7.0),
        GRID_SPEEDS,
        values,
        np.zeros(shape[:2], bool),
        ("a", "b", "c", "d"),
    )


def test_the_largest_is_that_of_all_sums(series):
    weights = np.where(GRID_SPEEDS < 60.0, 1.0 / GRID_SPEEDS, 0.0)
    every = weights[:, np.newaxis] * series.synthesis.amplitude
    amplitude, speed, place = largest_amplitude(series, weights)
    assert (speed, place) == np.unravel_index(np.argmax(every), every.shape)
    assert amplitude == close(series.synthesis.amplitude[speed, place])


def test_unbounded_vibration_is_the_largest_where_it_counts(series):
    series.unbounded[2, [10, 140]] = True
    weights = np.where(GRID_SPEEDS > 60.0, 1.0, 0.0)
    assert largest_amplitude(series, weights)[:2] == (np.inf, 140)


def test_speeds_above_are_those_of_all_sums(series):
    level = float(np.median(series.synthesis.amplitude.max(axis=1)))
    weights = np.full(GRID_SPEEDS.shape, 1.0 / level)
    none = np.zeros(GRID_SPEEDS.shape, bool)
    expected = np.max(series.synthesis.amplitude, axis=1) > level
    assert 0 < np.count_nonzero(expected) < GRID_SPEEDS.size
    assert np.array_equal(speeds_above(series, weights, none), expected)
    known = none.copy()
    known[:3] = True
    assert np.array_equal(speeds_above(series, weights, known), expected | known)


def test_a_limit_while_misfiring_is_that_for_passing_only_where_something_says_so():
    limit = crankshaft_limit(100.0, strokes=4)
    assert limit.misfiring is limit.continuous
    limit = replace(limit, misfiring_basis="the class")
    speeds = np.array([50.0, 80.0, 80.001, 100.0, 110.0, 116.0])
    ratio = speeds[:4] / 100.0
    plain = 1e6 * (45.0 - 24.0 * ratio**2)
    found = limit.misfiring.at(speeds)
    assert found[:4] == close(plain * [2.0, 2.0, 1.0, 1.0])
    assert found[4] == limit.continuous.at(speeds[4:5])[0]
    assert np.isinf(found[5])
    maker = given_limit("torque", 5.0, "N m", applies_to="coupling", source="maker")
    maker = replace(maker, misfiring_basis="the class")
    assert maker.misfiring is maker.continuous


def test_checks_speak_of_running_speeds_first():
    # The largest use lies above the running range, where the rule goes on to 115 rad/s.
    speeds = np.linspace(20.0, 115.0, 96)
    values = np.where(speeds > 100.0, 60e6, np.where(speeds < 40.0, 80e6, 10e6))
    limit = crankshaft_limit(100.0, strokes=4)
    verdict = judge(
        [(limit, AmplitudeCurve("shaft", speeds, values))], (40.0, 100.0), BarredRangeRule(100.0)
    )
    (check,) = verdict.checks
    assert (check.running.speed, check.running.value) == (100.0, 10e6)
    assert check.running.permitted == close(21e6)
    assert check.above.value == 60e6
    assert check.above.speed > 100.0
    # What decides the status stays the worst of all that is judged, and is told first.
    assert check.worst_value == 60e6
    assert check.sentence.index("231 %") < check.sentence.index("47.6 %")
    assert worst_use(limit, check.curve, 0.0, 39.9).value == 80e6


def test_diagrams_take_their_height_and_orders_from_running_speeds(series):
    values = series.values.copy()
    values[5, :30] = 1000.0
    values[4, :30] = values[4, 120:] = 500.0
    loud = OrderSeries(series.orders, series.speeds, values, series.unbounded, series.names)
    running = (float(GRID_SPEEDS[30]), float(GRID_SPEEDS[119]))
    curves = loud.over_speed(0, quantity_display(None, "SI"), running=running, main_orders=1)
    assert curves.y.ends[1] == close(1.08 * loud.synthesis.plain_sum[30:120, 0].max())
    assert [band.name for band in curves.bands] == 2 * ["outside the running range"]
    assert curves.bands[0].high == close(running[0] * 30.0 / np.pi)
    (main,) = (line.name for line in curves.lines if line.name.startswith("order") and line.main)
    sizes = np.abs(values[:, 30:120, 0]).max(axis=1)
    assert main == f"order {series.orders[np.argmax(sizes)]:g}"


OVER_HZ = Variation(
    frequency=(0.0, 20.0, 60.0), stiffness=(1.0, 1.2, 1.6), loss_factor=(0.1, 0.15, 0.12)
)
OVER_SPEED = Variation(
    speed=(0.0, 100.0, 300.0), stiffness=(1.0, 2.0, 4.0), damping=(1.0, 0.7, 0.4)
)


@pytest.mark.slow
def test_a_coupling_over_the_frequency_and_a_bearing_over_the_speed():
    """Every motion is that of the matrices made anew at its frequency and speed."""
    coupling = Coupling(5e4, loss_factor=0.1, variation=OVER_HZ)
    line = ShaftLine([RigidBody(0.5, 1.0, "b"), coupling, RigidBody(1.5, 1.0, "c")]).chain()
    bearing = Varying(1, OVER_SPEED.of(2e4, damping=12.0), to_ground=True)
    line = replace(
        line, ground=[0.0, 2e4], ground_damping=[0.0, 12.0], varying=(*line.varying, bearing)
    )
    chain = join_chains(Chain([0.9, 1.5], [2e5], loss_factor=0.02, names=["a", "b"]), "b", line)
    orders, speeds = np.array([0.5, 1.0, 2.0]), np.linspace(50.0, 300.0, 101)
    forces = np.full((3, 101, 3), 30.0 + 20.0j) * [1.0, 2.0, 0.0]
    answer = forced_response(chain, OrderExcitation(orders, speeds, forces))

    def motion(order, speed, force):
        w = order * speed
        stiff, loss = (
            np.interp(w / (2.0 * np.pi), OVER_HZ.frequency, values)
            for values in (OVER_HZ.stiffness, OVER_HZ.loss_factor)
        )
        share, oil = (
            np.interp(speed, OVER_SPEED.speed, values)
            for values in (OVER_SPEED.stiffness, OVER_SPEED.damping)
        )
        first, second = 2e5 * (1.0 + 0.02j), 5e4 * stiff * (1.0 + 1j * loss)
        film = 2e4 * share + 12j * w * oil
        stiffness = np.array(
            [[first, -first, 0.0], [-first, first + second, -second], [0.0, -second, second + film]]
        )
        x = np.linalg.solve(stiffness - w**2 * np.diag([0.9, 2.0, 1.5]), force)
        return x, second * (x[2] - x[1])

    made = [[motion(order, speed, forces[0, 0]) for speed in speeds] for order in orders]
    assert answer.motion == close(np.array([[x for x, _ in row] for row in made]), 1e-9)
    torque = np.array([[torque for _, torque in row] for row in made])
    assert element_loads(answer).elements.values[:, :, 1] == close(torque, 1e-9)
    assert power_balance(answer).error < 1e-9
    peaks = {c.order: c for c in damped_criticals(answer, elements=[1]) if c.in_band}
    finer = np.linspace(speeds[0], speeds[-1], 5001)
    top = finer[np.argmax([abs(motion(1.0, speed, forces[0, 0])[1]) for speed in finer])]
    assert peaks[1.0].speed == close(top, 2e-3)
    assert peaks[1.0].undamped_speed == close(top, 0.02)
    met = chain_system(chain).frequencies_met(1.0)[0] * 2.0 * np.pi
    assert np.min(np.abs(met - peaks[1.0].undamped_speed)) < 0.01 * top
    cause = peak_cause(answer, element_loads(answer).elastic, 1, int(np.argmin(abs(speeds - top))))
    assert sum(part.contribution for part in cause.parts) == close(cause.amplitude)


VARIED_ENGINE = Chain([0.9, 1.5], [2e5], loss_factor=0.02, names=["a", "b"])
VARIED_ORDERS, VARIED_SPEEDS = np.array([0.5, 1.0, 2.0]), np.linspace(50.0, 300.0, 101)
FORCES = np.full((3, 101, 3), 30.0 + 20.0j) * [1.0, 2.0, 0.0]


def coupled_by(stiffness, *, loss_factor=0.1, damping=2.0, variation=None):
    """Two inertias and, behind a coupling, a third one."""
    coupling = Coupling(
        stiffness, torsional_damping=damping, loss_factor=loss_factor, variation=variation
    )
    line = ShaftLine([RigidBody(0.5, 1.0, "b"), coupling, RigidBody(1.5, 1.0, "c")])
    return join_chains(VARIED_ENGINE, "b", line.chain())


def response_of(chain):
    return forced_response(chain, OrderExcitation(VARIED_ORDERS, VARIED_SPEEDS, FORCES))


def motion_with(order, speed, coupling):
    """Motion by the dynamic stiffness with a complex stiffness of the coupling."""
    first, w = 2e5 * (1.0 + 0.02j), order * speed
    stiffness = np.array(
        [[first, -first, 0], [-first, first + coupling, -coupling], [0, -coupling, coupling]]
    )
    return np.linalg.solve(stiffness - w**2 * np.diag([0.9, 2.0, 1.5]), FORCES[0, 0])


@pytest.mark.slow
def test_a_coupling_over_mean_torque_and_frequency_in_one_table():
    table = np.array([[1.0, 1.3], [1.5, 1.6], [2.4, 3.0]])
    losses = np.array([[0.1, 0.2], [0.15, 0.22], [0.12, 0.3]])
    variation = Variation(
        torque=(0.0, 400.0, 1000.0),
        frequency=(5.0, 40.0),
        stiffness=tuple(map(tuple, table.T.tolist())),
        loss_factor=tuple(map(tuple, losses.T.tolist())),
        at_speed=tuple(VARIED_SPEEDS.tolist()),
        at_torque=tuple((900.0 * (VARIED_SPEEDS / 300.0) ** 2).tolist()),
    )
    answer = response_of(coupled_by(5e4, variation=variation))

    def coupling(order, speed):
        torque, w = 900.0 * (speed / 300.0) ** 2, order * speed
        share = np.clip((w / (2.0 * np.pi) - 5.0) / 35.0, 0.0, 1.0)
        stiff, loss = (
            np.interp(torque, (0.0, 400.0, 1000.0), (1.0 - share) * of[:, 0] + share * of[:, 1])
            for of in (table, losses)
        )
        return 5e4 * stiff * (1.0 + 1j * loss) + 2j * w

    made = [[motion_with(o, s, coupling(o, s)) for s in VARIED_SPEEDS] for o in VARIED_ORDERS]
    assert answer.motion == close(np.array(made), 1e-11)
    assert power_balance(answer).error < 1e-11
    twist = answer.motion[:, :, 2] - answer.motion[:, :, 1]
    springs = np.array([[coupling(o, s) for s in VARIED_SPEEDS] for o in VARIED_ORDERS])
    heat = 0.5 * answer.angular_frequencies * springs.imag * np.abs(twist) ** 2
    assert power_balance(answer).elements[:, :, 1] == close(heat, 1e-11)
    assert element_loads(answer).elements.values[:, :, 1] == close(springs * twist, 1e-11)
    peaks = [c for c in damped_criticals(answer, elements=[1]) if c.order == 2.0]
    finer = np.linspace(VARIED_SPEEDS[0], VARIED_SPEEDS[-1], 5001)
    loads = [np.diff(motion_with(2.0, s, c := coupling(2.0, s)))[1] * c.real for s in finer]
    top = finer[np.argmax(np.abs(loads))]
    assert min(abs(peak.speed - top) for peak in peaks if peak.speed > 0.0) < 2e-3 * top


@pytest.mark.parametrize("axes", [("frequency",), ("speed", "amplitude"), ("frequency", "torque")])
def test_a_constant_table_is_a_constant_spring(axes):
    ones = (1.0, 1.0) if len(axes) == 1 else ((1.0, 1.0), (1.0, 1.0))
    over = dict.fromkeys(axes, (0.0, 10.0)) | ({"at_torque": 3.0} if "torque" in axes else {})
    varying = response_of(coupled_by(5e4, variation=Variation(stiffness=ones, **over)))
    constant = response_of(coupled_by(5e4))
    assert np.max(np.abs(varying.motion - constant.motion)) < 1e-12 * np.max(
        np.abs(constant.motion)
    )


def test_a_coupling_at_its_mean_torque_and_temperature_has_constant_values():
    """So natural frequencies and motion over time are those of the values there."""
    variation = Variation(
        torque=(0.0, 100.0),
        temperature=(300.0, 400.0),
        stiffness=((1.0, 0.6), (3.0, 1.0)),
        damping=((1.0, 2.0), (1.0, 2.0)),
        at_torque=25.0,
        at_temperature=350.0,
    )
    chain = coupled_by(5e4, variation=variation)
    same = coupled_by(5e4 * (0.8 * 0.75 + 2.0 * 0.25), damping=3.0)
    assert not chain.varying
    assert chain.modes().frequencies == close(same.modes().frequencies, 1e-12)
    assert chain.damping_matrix() == close(same.damping_matrix(), 1e-12)


@pytest.mark.slow
def test_a_coupling_over_its_amplitude_has_the_one_that_it_reaches():
    variation = Variation(
        amplitude=(0.0, 0.002, 0.01), stiffness=(1.0, 0.7, 0.5), loss_factor=(0.1, 0.3, 0.4)
    )
    chain = coupled_by(5e4, variation=variation)
    answer = response_of(chain)
    turns = np.exp(1j * VARIED_ORDERS * np.linspace(0.0, 4.0 * np.pi, 40001)[:, np.newaxis])

    def coupling(amplitude, order, speed):
        stiff, loss = (
            np.interp(amplitude, variation.amplitude, of)
            for of in (variation.stiffness, variation.loss_factor)
        )
        return 5e4 * stiff * (1.0 + 1j * loss) + 2j * order * speed

    for place in (0, 30, 60, 100):
        amplitude, speed = 0.0, VARIED_SPEEDS[place]
        for _ in range(200):
            x = np.array(
                [motion_with(o, speed, coupling(amplitude, o, speed)) for o in VARIED_ORDERS]
            )
            course = (turns @ (x[:, 2] - x[:, 1])).real
            amplitude += 0.3 * (0.5 * np.ptp(course) - amplitude)
        assert amplitude > 1e-4
        assert answer.motion[:, place] == close(x, 1e-6)
    assert power_balance(answer).error < 1e-9
    loads = element_loads(answer).elements.synthesis.amplitude
    small = forced_response(chain, OrderExcitation(VARIED_ORDERS, VARIED_SPEEDS, 1e-6 * FORCES))
    assert small.motion * 1e6 == close(response_of(coupled_by(5e4)).motion, 1e-3)
    assert np.all(loads[:, 1] > 0.0)
    with refused("chain"):
        damped_criticals(answer)
    with refused("variation.amplitude"):
        chain_system(chain).frequencies_met(1.0)


test_a_variation_has_a_value_at_each_of_ascending_points = refusals_of(
    lambda given_values: Variation(stiffness=(1.0, 1.2), **given_values),
    (dict.fromkeys(("frequency", "speed", "torque"), (0.0, 1.0)), "variation.frequency"),
    ({}, "variation.frequency"),
    ({"frequency": (0.0, 1.0), "speed": (0.0, 1.0)}, "variation.stiffness"),
    ({"torque": (0.0, 1.0), "at_torque": (1.0, 2.0)}, "variation.at_torque"),
    ({"speed": (1.0, 1.0)}, "variation.speed"),
    ({"frequency": (0.0, 1.0), "damping": (1.0,)}, "variation.damping"),
)


test_refused = refusals(
    ("excitation", lambda: forced_response(TWO, excitation(np.ones((2, 3, 3))))),
    ("magnifier", lambda: forced_response(TWO, excitation(), magnifier=40.0, modal_damping=0.01)),
    ("speed_index", lambda: excitation().at_angle(3, shaft_angle_deg=[0.0])),
    ("response", lambda: element_loads(forced_response(damped(TWO).system, excitation()))),
    (
        "sections",
        lambda: alternating_stress(element_loads(forced_response(TWO, excitation())), {3: 1.0}),
    ),
    (
        "sections[0]",
        lambda: alternating_stress(element_loads(forced_response(TWO, excitation())), [0.0]),
    ),
    ("bore", lambda: section_modulus("torsional", 0.05, 0.05)),
    ("diameter", lambda: section_modulus("torsional", 0.0)),
    (
        "sections",
        lambda: alternating_stress(element_loads(forced_response(TWO, excitation())), [1.0] * 2),
    ),
    ("place", lambda: named_quantity(forced_response(TWO, excitation()), "crank")),
    ("excitation", lambda: with_resonances(excitation(), Chain([1.0], []))),
    ("variation.at_torque", lambda: Variation(torque=(0.0, 9.0), stiffness=(1.0, 2.0)).of(2e4)),
    ("node", lambda: resonances(forced_response(TWO, excitation()), "crank")),
    (
        "speed_range",
        lambda: resonances(forced_response(TWO, excitation()), speed_range=(150.0, 50.0)),
    ),
    ("method", lambda: forced_response(TWO, excitation(), method="guess")),
    ("frequency", lambda: EngineMagnifier(40.0, (0,), 0.0)),
    ("speeds", lambda: excitation().at_speeds([160.0])),
    ("orders", lambda: common_order(np.array([1.0, np.sqrt(2.0)]))),
    ("orders", lambda: common_order(np.array([1.0 / 997.0, 90.0]))),
    ("speed_range", lambda: resonances(forced_response(ENGINE, peak_excitation([100.0])))),
)
