import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from dynamics.assessment.separation import critical_ranges, separation_margin
from dynamics.assessment.uncertainty import (
    Spread,
    chain_samples,
    frequency_bounds,
    frequency_samples,
    frequency_sensitivities,
    function_samples,
    sampled_factors,
    scaled_chain,
)
from dynamics.chains.chain import Chain, Dashpot, Gear
from refusals import refusals, refused

# A geared and branched shaft with all that a chain can have.
CHAIN = Chain(
    [0.3, 0.2, 0.1, 0.5, 0.4],
    [2e5, 1e5, 3e5],
    {3: 4e4},
    connections=[(0, 1), (1, 2), (3, 4)],
    damping=[1.0, 0.0, 2.0],
    loss_factor=0.03,
    ground_damping={0: 1.5},
    distributed_inertia=[0.05, 0.0, 0.02],
    dashpots=[Dashpot(0, 4, 3.0)],
    gears=[Gear(2, 3, -1.5)],
    names=["fan", "crank 1", "crank 2", "wheel", "pump"],
)
SPREADS = (
    Spread("compliance", 0.9, 1.2, places=("fan - crank 1",)),
    Spread("stiffness", 0.8, 1.1, places=(1, 2)),
    Spread.within("inertia", 0.1, places=("crank 1", "pump")),
    Spread("distributed inertia", 0.5, 2.0),
    Spread("ground stiffness", 0.25, 4.0, places=("wheel",)),
    Spread("loss factor", 0.5, 1.5),
    Spread("all damping", 0.5, 3.0),
)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(0.0, 1.0), min_size=len(SPREADS), max_size=len(SPREADS)))
def test_no_chain_within_the_ranges_leaves_the_bounds(shares):
    low, high = frequency_bounds(CHAIN, SPREADS)
    factors = [s.low + share * (s.high - s.low) for s, share in zip(SPREADS, shares, strict=True)]
    found = scaled_chain(CHAIN, SPREADS, factors).modes().frequencies
    # Round-off of the frequencies is 1e-15 of the highest one.
    assert np.all(low - 1e-12 * high[-1] <= found)
    assert np.all(found <= high + 1e-12 * high[-1])


def test_bounds_are_reached_at_their_corners():
    low, high = frequency_bounds(CHAIN, SPREADS)
    softest = scaled_chain(CHAIN, SPREADS, [1.2, 0.8, 1.1, 2.0, 0.25, 1.0, 1.0])
    stiffest = scaled_chain(CHAIN, SPREADS, [0.9, 1.1, 0.9, 0.5, 4.0, 1.0, 1.0])
    assert low == close(softest.modes().frequencies, rel=1e-12)
    assert high == close(stiffest.modes().frequencies, rel=1e-12)


def test_sensitivities_are_the_derivatives():
    found = frequency_sensitivities(CHAIN, SPREADS)
    step = 1e-5
    for number, row in enumerate(found):
        ends = []
        for sign in (1.0, -1.0):
            factors = np.ones(len(SPREADS))
            factors[number] += sign * step
            ends.append(np.log(scaled_chain(CHAIN, SPREADS, factors).modes().frequencies))
        # Central differences err by step^2, and by round-off 1e-15 / step.
        assert row == close((ends[0] - ends[1]) / (2.0 * step), abs=1e-8)
    assert not np.any(found[5:])


def test_samples_at_once_are_the_chains_one_by_one_and_free_modes_stay_exactly_zero():
    free = Chain([1.0, 2.0, 3.0], [1e4, 2e4], distributed_inertia=[0.1, 0.0])
    spreads = (Spread.within("stiffness", 0.2), Spread("distributed inertia", 0.5, 2.0))
    for chain, given_spreads in ((CHAIN, SPREADS), (free, spreads)):
        samples = frequency_samples(chain, given_spreads, samples=7, seed=3)
        for factors, values in zip(samples.factors, samples.values, strict=True):
            alone = scaled_chain(chain, given_spreads, factors).modes().frequencies
            assert values == close(alone, rel=1e-11)
        assert samples.nominal == close(chain.modes().frequencies, rel=1e-12)
    assert not np.any(samples.values[:, 0])


@pytest.mark.parametrize("gears", [[Gear(1, 2, -0.5)], [Gear(1, 2, -0.5), Gear(2, 1, -2.0)]])
def test_gears_without_inertia_stand_elsewhere_in_each_sample(gears):
    # The second gear of a pair says the same again.
    chain = Chain(
        [4.0, 0.0, 0.0, 9.0], [2e3, 3e3], connections=[(0, 1), (2, 3)], gears=gears, ground={3: 1e3}
    )
    spreads = [Spread.within("compliance", 0.3, (0,)), Spread.within("inertia", 0.2)]
    samples = frequency_samples(chain, spreads, 10, 3)
    for factors, frequencies in zip(samples.factors, samples.values, strict=True):
        expected = scaled_chain(chain, spreads, factors).modes().frequencies
        assert frequencies == close(expected, rel=1e-9)


def test_every_share_of_a_range_is_drawn_once_and_the_same_seed_draws_the_same():
    spread = Spread("stiffness", 0.5, 2.0)
    factors = sampled_factors([spread], samples=40, seed=5)
    places = np.log(factors[:, 0] / 0.5) / np.log(4.0)
    assert np.sort(np.floor(40 * places)).tolist() == list(range(40))
    assert np.array_equal(factors, sampled_factors([spread], samples=40, seed=5))
    assert not np.array_equal(factors, sampled_factors([spread], samples=40, seed=6))


def test_samples_of_any_result():
    spreads = [Spread.within("inertia", 0.5)]
    samples = chain_samples(CHAIN, spreads, lambda chain: chain.inertia.sum(), samples=100)
    assert samples.nominal == close(1.5)
    assert samples.values == close(1.5 * samples.factors[:, 0])
    assert samples.lowest < samples.percentile(10) < samples.percentile(50) < samples.highest
    endless = function_samples(lambda f: np.inf if f[0] > 1.2 else f[0], spreads, samples=100)
    assert np.isinf(endless.highest)
    assert np.isfinite(endless.percentile(50))
    with refused("percent"):
        endless.percentile(101)
    never = function_samples(lambda _: np.inf, spreads, samples=2)
    with refused("place"):
        never.plot()
    with refused("samples"):
        function_samples(np.sum, spreads, samples=100_001)


def test_separation_margin():
    margins = separation_margin(
        np.array([70.0, 95.0, 230.0]), np.array([80.0, 105.0, 250.0]), (100.0, 200.0)
    )
    assert margins == close([0.2, 0.0, 0.15])


def test_critical_ranges_tell_what_the_nominal_value_hides():
    chain = Chain([1.0, 1.0], [5e3])  # 100 rad/s
    (found,) = critical_ranges(chain, [Spread.within("stiffness", 0.19)], [1.0], (50.0, 88.0))
    assert (found.mode, found.order) == (1, 1.0)
    assert (found.low, found.nominal, found.high) == close((90.0, 100.0, 100 * 1.19**0.5))
    assert found.nominal_margin == close(100.0 / 88.0 - 1.0)
    assert found.margin == close(90.0 / 88.0 - 1.0)
    assert not found.kept()
    assert "859.4 to 1042 1/min" in found.sentence
    assert critical_ranges(chain, [], [1.0], (50.0, 60.0)) == ()


def test_critical_ranges_take_each_chains_own_peaks_and_tell_every_peak():
    soft, chain, stiff = (Chain([1.0, 1.0], [5e3 * factor**2]) for factor in (0.9, 1.0, 1.2))
    peaks = {soft: (0.85, 1.10), chain: (0.9, 1.05), stiff: (1.0,)}
    found = critical_ranges(
        chain,
        [],
        [1.0],
        (50.0, 100.0),
        damped=lambda own, _mode, _order: peaks[own],
        others=(soft, stiff),
    )
    # 100 rad/s times the factors of stiffness and of damping. The stiff chain's one peak is the upper one's;
    # the lower one, without a partner there, shifts with the stiffness alone.
    lower, upper = ((one.low, one.nominal, one.high) for one in found)
    assert lower == close((90.0 * 0.85, 90.0, 120.0 * 0.9))
    assert upper == close((90.0 * 1.10, 105.0, 120.0))
    assert not critical_ranges(chain, [], [1.0], (50.0, 100.0), damped=lambda *_: ())


test_refused = refusals(
    ("kind", lambda: Spread("weight", 0.9, 1.1)),
    ("spread of inertia", lambda: Spread("inertia", 1.1, 1.2)),
    ("spread of inertia[0]", lambda: Spread.within("inertia", 1.0)),
    ("places", lambda: Spread("all damping", 0.5, 2.0, places=(1,))),
    (
        "spread of stiffness",
        lambda: frequency_bounds(CHAIN, [Spread("stiffness", 0.9, 1.1, places=(3,))]),
    ),
    ("spreads", lambda: sampled_factors([])),
    ("factors", lambda: scaled_chain(CHAIN, SPREADS, [1.0])),
    ("running_range", lambda: critical_ranges(CHAIN, [], [1.0], (2.0, 1.0))),
)
