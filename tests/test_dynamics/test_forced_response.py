"""Forced response by orders: excitation, loads, stress, heat, and what is unbounded or refused."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.harmonics import harmonics
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.loads import (
    alternating_stress,
    element_loads,
    power_balance,
    section_modulus,
)
from dynamics.response.order_excitation import OrderExcitation, phasors_of
from dynamics.response.resonance import resonances

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
        with pytest.raises(InputError, match="speed_index: given 1, where order 2 excites"):
            series.at_angle(1, shaft_angle_deg=np.degrees([0.0]))
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
    modulus = section_modulus("torsional", [0.05], [0.02])
    stress = alternating_stress(loads, modulus)
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


def test_excitation_over_the_cycle():
    forces = np.zeros((2, 3, 2), dtype=complex)
    forces[0, :, 0], forces[1, :, 1] = 2.0j, 3.0
    own = excitation(forces)
    angle = np.array([0.0, 0.3, 2.0])
    expected = np.column_stack((-2.0 * np.sin(angle), 3.0 * np.cos(2.0 * angle)))
    np.testing.assert_allclose(
        own.at_angle(1, shaft_angle_deg=np.degrees(angle)), expected, atol=1e-15
    )


def test_forces_of_inertia_are_exact_between_speeds():
    forces = (SPEEDS**2)[np.newaxis, :, np.newaxis] * np.array([2.0, 1.0j]) * np.ones((2, 1, 1))
    between = excitation(forces + 5.0).at_speeds([50.0, 77.0, 149.0])
    expected = np.array([50.0, 77.0, 149.0])[:, np.newaxis] ** 2 * np.array([2.0, 1.0j]) + 5.0
    np.testing.assert_allclose(between.forces[1], expected, rtol=1e-13)
    with pytest.raises(InputError, match="speeds: given 160 rad/s; allowed are 50 to 150"):
        excitation().at_speeds([160.0])


def test_phasors_from_samples_and_aliasing():
    angle = np.radians(np.arange(0.0, 720.0, 30.0))
    found = harmonics(10.0 + 8.0 * np.cos(1.5 * angle - 0.4))
    np.testing.assert_allclose(
        phasors_of(found, [1.0, 1.5]), [0.0, 8.0 * np.exp(-0.4j)], atol=1e-14
    )
    with pytest.raises(InputError, match="24 samples over one cycle resolve no others"):
        phasors_of(found, [1.5, 22.5])  # it would look like order 1.5
    with pytest.raises(InputError, match="given 6; allowed are those below 6, because 24 samples"):
        phasors_of(found, [6.0])


@pytest.mark.parametrize(
    ("orders", "speeds", "forces", "words"),
    [
        ([1.0, 2.0], SPEEDS[::-1], PUSH, "speeds.1.: given 100 rad/s after 150 rad/s; allowed are"),
        ([2.0, 1.0], SPEEDS, PUSH, "orders.1.: given 1 after 2"),
        ([0.0, 1.0], SPEEDS, PUSH, "orders.0.: given 0"),
        ([1.0, 2.0], [0.0, 1.0, 2.0], PUSH, "speeds.0.: given 0"),
        ([1.0, 2.0], SPEEDS, PUSH[:1], "forces: given an array of shape"),
        ([1.0, 2.0], SPEEDS, PUSH * np.nan, r"forces\[0\]\[0\]\[0\]: given"),
        ([], SPEEDS, PUSH, "orders: given no values"),
    ],
)
def test_excitation_refused(orders, speeds, forces, words):
    with pytest.raises(InputError, match=words):
        OrderExcitation(orders, speeds, forces)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: forced_response(TWO, excitation(np.ones((2, 3, 3)))), "excitation: given forces"),
        (
            lambda: forced_response(TWO, excitation(), magnifier=40.0, modal_damping=0.01),
            "magnifier: given 40.0 together",
        ),
        (lambda: excitation().at_angle(3, shaft_angle_deg=[0.0]), "speed_index: given 3"),
        (
            lambda: element_loads(forced_response(damped(TWO).system, excitation())),
            "response: given that of a system of matrices",
        ),
        (
            lambda: alternating_stress(element_loads(forced_response(TWO, excitation())), {3: 1.0}),
            "sections: given 3",
        ),
        (
            lambda: alternating_stress(element_loads(forced_response(TWO, excitation())), [0.0]),
            r"sections\[0\]: given 0",
        ),
        (lambda: section_modulus("torsional", 0.05, 0.05), "bore: given 0.05 m"),
        (lambda: resonances(forced_response(TWO, excitation()), "crank"), "node: given 'crank'"),
        (
            lambda: resonances(forced_response(TWO, excitation()), speed_range=(150.0, 50.0)),
            "speed_range: given",
        ),
    ],
)
def test_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()
