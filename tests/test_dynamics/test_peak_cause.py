"""Parts of orders in a peak, their resonances, and what is said of them."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.loads import alternating_stress, element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.peak_cause import peak_cause

# One inertia on a spring to ground would have no element: two, the second a hundred times as large.
PAIR = Chain([1.0, 100.0], [1e4], names=["engine", "generator"])
NATURAL = float(np.sqrt(1e4 * 1.01))


def cause(amplitudes, speed, magnifier=20.0, **options):
    orders = np.array(sorted(amplitudes))
    forces = np.zeros((orders.size, 1, 2), dtype=complex)
    forces[:, 0, 0] = [amplitudes[order] for order in orders.tolist()]
    chain = damped(PAIR, undamped=True) if magnifier is None else damped(PAIR, magnifier=magnifier)
    response = forced_response(chain, OrderExcitation(orders, [speed], forces))
    loads = element_loads(response).elastic
    return peak_cause(response, loads, 0, 0, unit="N m", kind="torsional", **options)


def test_an_order_at_resonance_and_one_far_from_it():
    found = cause({1.0: 100.0, 6.0: 10.0}, NATURAL / 6.0)
    slow, fast = found.parts
    assert (slow.state, fast.state) == ("forced", "at resonance")
    assert (slow.mode, fast.mode, fast.kind) == (1, 1, "torsional")
    assert fast.magnifier == close(20.0, rel=2e-3)
    assert fast.detuning == close(0.0, abs=1e-3)
    # Both mass points move against each other: the static twist of a force on the first.
    assert fast.amplitude == close(10.0 * 100.0 / 101.0 * 20.0, rel=2e-3)
    assert slow.contribution + fast.contribution == close(found.amplitude, rel=1e-12)
    assert found.share("at resonance") == close(fast.contribution / found.amplitude)
    assert found.resonant == (fast,)
    assert "order 6, at the resonance of torsional mode 1, contributes" in found.sentence
    assert "order 1, forced without resonance, contributes" in found.sentence


@pytest.mark.parametrize(
    ("ratio", "magnifier", "state"),
    [
        (1.0, 20.0, "at resonance"),
        (1.024, 20.0, "at resonance"),  # within the half-power bandwidth, 2.5 % to either side
        (1.03, 20.0, "near resonance"),
        (0.91, 20.0, "near resonance"),
        (0.89, 20.0, "amplified"),  # 4.6 times the static amplitude
        (1.11, 20.0, "amplified"),
        (0.8, 2.5, "amplified"),  # 17 % from the peak, in the half-power bandwidth
        (0.96, 2.5, "at resonance"),
        (0.72, 20.0, "amplified"),
        (0.7, 20.0, "forced"),  # 1.96 times
        (1.0, 1.5, "forced"),  # so damped that most of the amplitude is there without resonance
        (0.3, 1.5, "forced"),
    ],
)
def test_where_a_resonance_ends(ratio, magnifier, state):
    (part,) = cause({1.0: 100.0}, NATURAL * ratio, magnifier).parts
    assert part.state == state
    size = 1.0 / abs(1.0 - ratio**2 + 1j * ratio / magnifier)
    assert part.magnifier == close(size, rel=1e-6)


def test_of_orders_at_one_resonance_the_largest_comes_first():
    found = cause({4.9: 10.0, 5.0: 100.0}, NATURAL / 5.0, 2.5)
    assert [one.order for one in found.resonant] == [5.0, 4.9]


def test_unbounded():
    found = cause({1.0: 100.0, 2.0: 10.0}, NATURAL / 2.0, None)
    assert np.isinf(found.amplitude)
    assert found.reasons == "order 2 excites torsional mode 1, which nothing damps"
    assert found.sentence.startswith("unbounded at ")


def test_small_orders_are_told_together():
    amplitudes = {0.5 * number: 10.0 for number in range(1, 7)} | {9.0: 0.05, 3.5: 0.01, 4.0: 1e-4}
    found = cause(amplitudes, 0.01 * NATURAL)
    assert "orders 0.5 to 3, forced without resonance, contribute" in found.sentence
    assert "9" not in found.sentence.partition(":")[2].split(",")[0]


def test_runs_end_at_orders_that_are_told_elsewhere():
    amplitudes = {1.0: 100.0, 2.0: 100.0, 3.0: 100.0, 4.0: 30.0, 5.0: 300.0, 6.0: 600.0, 7.0: 900.0}
    found = cause(amplitudes, NATURAL / 4.0)
    assert found.parts[3].state == "at resonance"
    assert found.reasons.startswith("orders 2 and 5 to 7, forced without resonance, contribute")


def test_forces_that_another_vibration_brings():
    speed = NATURAL / 6.0
    torsional = cause({1.0: 100.0, 6.0: 10.0}, speed)
    chain = damped(Chain([1.0, 100.0], [1e7], names=["a", "b"]), magnifier=30.0)
    forces = np.zeros((2, 1, 2), dtype=complex)
    forces[:, 0, 0] = [5.0, 50.0]
    own = OrderExcitation([1.0, 6.0], [speed], forces)
    response = forced_response(chain, own)
    brought = OrderExcitation([1.0, 6.0], [speed], 0.8 * forces)
    found = peak_cause(
        response, response.elastic, "a", 0, unit="m", kind="axial", driven=(brought, torsional)
    )
    assert [one.state for one in found.parts] == ["forced", "at resonance"]
    assert found.parts[1].kind == "torsional"
    assert found.parts[1].amplitude == close(response.elastic.amplitude[1, 0, 0])
    assert "order 6, at the resonance of torsional mode 1, contributes" in found.sentence
    little = OrderExcitation([1.0, 6.0], [speed], 0.3 * forces)
    alone = peak_cause(response, response.elastic, "a", 0, driven=(little, torsional))
    assert [one.state for one in alone.parts] == ["forced", "forced"]


def test_of_a_stress_and_no_place():
    forces = np.full((1, 2, 2), [10.0, 0.0], dtype=complex)
    response = forced_response(damped(PAIR), OrderExcitation([1.0], [50.0, 90.0], forces))
    stress = alternating_stress(element_loads(response), [1e-5])
    found = peak_cause(response, stress, "engine - generator", 1, unit="Pa")
    assert found.amplitude == close(stress.amplitude[0, 1, 0])
    assert repr(found).startswith("PeakCause(place engine - generator, speed 90 rad/s")
    assert found.parts[0].row()["order"] == (1.0, "1")
    with pytest.raises(InputError, match="speed_index: given 2"):
        peak_cause(response, stress, 0, 2)
    ground = element_loads(response).dashpots
    with pytest.raises(InputError, match="place: given"):
        peak_cause(response, ground, 0, 0)
