"""Resonance table and refined speeds, on a six-cylinder engine."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import refined_speeds, resonances

# Six cylinders and a flywheel, firing 1-5-3-6-2-4.
ENGINE = Chain([0.05] * 6 + [2.0], [1.2e6] * 6)
FIRING = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
ORDERS = 0.5 * np.arange(1, 25)
RANGE = (100.0, 300.0)


def excitation(speeds, orders=ORDERS):
    own = 1000.0 / (1.0 + orders**2)[:, np.newaxis] * (1.0 + 1e-5 * np.asarray(speeds) ** 2)
    forces = np.zeros((orders.size, len(speeds), 7), dtype=complex)
    forces[:, :, :6] = own[:, :, np.newaxis] * np.exp(-1j * np.outer(orders, FIRING))[:, np.newaxis]
    return OrderExcitation(orders, speeds, forces)


def test_each_resonance_is_calculated_at_its_own_speed():
    chain = damped(ENGINE)
    response = forced_response(chain, excitation([100.0, 300.0]))
    table = resonances(response)
    frequencies = ENGINE.modes().frequencies
    assert [own.speed for own in table] == sorted(own.speed for own in table)
    assert {own.mode for own in table} == {1, 2}
    for own in table:
        assert own.frequency == close(frequencies[own.mode], rel=1e-12)
        assert own.order * own.speed == close(2.0 * np.pi * own.frequency, rel=1e-14)
        # The force at that speed is known exactly from two, as it follows the squared speed.
        alone = excitation([own.speed], np.array([own.order]))
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
    response = forced_response(damped(ENGINE), excitation([100.0, 300.0], np.array([0.5])))
    assert resonances(response) == ()
    silent = OrderExcitation([6.0], [100.0, 300.0], np.zeros((1, 2, 7)))
    (only, *_) = resonances(forced_response(ENGINE, silent))
    assert (only.amplitude, only.share, only.severity, only.estimate) == (0.0, 0.0, 0.0, 0.0)
    assert not only.unbounded
    with pytest.raises(InputError, match="speed_range: given none, for a response at one speed"):
        resonances(forced_response(ENGINE, excitation([100.0])))


def peak(chain, speeds, order):
    found = forced_response(chain, excitation(speeds, np.array([order])))
    return found.amplitude[0, :, 0].max()


@pytest.mark.parametrize("magnifier", [40.0, 400.0])
def test_refined_speeds_read_every_peak(magnifier):
    """Within 0.2 %, as the distance of the speeds about a resonance promises; an even grid does not."""
    chain = damped(ENGINE, magnifier=magnifier)
    ratios = chain.system.damping_ratios()
    speeds = refined_speeds(chain.system.elastic_frequencies, ratios, ORDERS, RANGE, points=50)
    assert np.all(np.diff(speeds) > 0.0)
    assert speeds[[0, -1]].tolist() == list(RANGE)
    assert np.max(np.diff(speeds)) <= 200.0 / 49.0 * (1.0 + 1e-12)
    missed = 0.0
    for order in (6.0, 7.5, 9.0):
        critical = 2.0 * np.pi * chain.system.elastic_frequencies[0] / order
        true = peak(
            chain, critical * np.linspace(1.0 - 1.0 / magnifier, 1.0 + 1.0 / magnifier, 2001), order
        )
        assert peak(chain, speeds, order) >= 0.998 * true
        missed = max(missed, 1.0 - peak(chain, np.linspace(*RANGE, 50), order) / true)
    assert missed > 0.15


def test_undamped_resonance_stands_among_the_speeds():
    chain = damped(ENGINE, undamped=True)
    frequencies = chain.system.elastic_frequencies
    speeds = refined_speeds(frequencies, 0.0, [6.0], RANGE)
    response = forced_response(chain, excitation(speeds, np.array([6.0])))
    critical = 2.0 * np.pi * frequencies / 6.0
    inside = critical[(critical >= RANGE[0]) & (critical <= RANGE[1])]
    assert np.count_nonzero(response.unbounded) == inside.size > 0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (([50.0], 0.01, [1.0], (300.0, 100.0)), "speed_range: given"),
        (([50.0], [0.01, 0.02], [1.0], RANGE), "damping_ratios: given 2 values for 1 frequencies"),
        (([50.0], -0.01, [1.0], RANGE), "damping_ratios.0.: given -0.01"),
    ],
)
def test_refused(given, words):
    with pytest.raises(InputError, match=words):
        refined_speeds(*given)
