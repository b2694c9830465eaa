"""Critical speeds of random damped chains with branches, beside the dynamic stiffness at very many speeds."""

import numpy as np
import pytest
from scipy.signal import peak_prominences

from comparing import close
from dynamics.chains.chain import Chain, Gear
from dynamics.response.damped_criticals import LEAST_PEAK, NEARLY, damped_criticals
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import chain_system, damped
from dynamics.response.order_excitation import OrderExcitation

LOW, HIGH = 40.0, 200.0
FINE = LOW * np.exp(np.arange(0.0, np.log(HIGH / LOW), 3e-4))
ORDERS = (1.0, 2.5, 4.0)


def random_chain(random):
    """A row of masses; on two of them branches, one behind a gear; dashpots, losses, modal damping."""
    count = int(random.integers(3, 6))
    ends = [(node, node + 1) for node in range(count - 1)]
    ends += [(int(random.integers(count)), count), (count + 1, count + 2)]
    inertia = 10.0 ** random.uniform(-1.5, 0.5, count + 3)
    stiffness = 10.0 ** random.uniform(3.5, 5.0, len(ends))
    chain = Chain(
        inertia,
        stiffness,
        connections=ends,
        gears=[Gear(int(random.integers(count)), count + 1, float(random.uniform(-3.0, 3.0)))],
    )
    relative = {int(random.integers(len(ends))): 10.0 ** random.uniform(-1.0, 2.0)}
    return damped(
        chain,
        relative=relative,
        loss_factor=float(random.uniform(0.0, 0.1)),
        modal_damping=10.0 ** random.uniform(-2.5, -0.7),
    )


def case(seed):
    """A response, and amplitudes of each order at FINE speeds by place, solved for one by one."""
    random = np.random.default_rng(seed)
    chain = random_chain(random)
    nodes = chain.chain.inertia.size
    gas, masses = (
        random.normal(size=(3, nodes)) + 1j * random.normal(size=(3, nodes)) for _ in range(2)
    )

    def forces(speeds):
        squares = ((speeds / HIGH) ** 2)[np.newaxis, :, np.newaxis]
        return gas[:, np.newaxis] + masses[:, np.newaxis] * squares

    speeds = np.linspace(0.9 * LOW, 1.1 * HIGH, 60)
    run = forced_response(chain, OrderExcitation(ORDERS, speeds, forces(speeds)))
    system, shaft = run.system, run.chain
    plain = chain_system(shaft)
    rigid = plain.shapes[:, : plain.rigid.shape[1]]
    found = {}
    for order, own in zip(ORDERS, forces(FINE), strict=True):
        w = (order * FINE)[:, np.newaxis, np.newaxis]
        dynamic = system.stiffness + 1j * (system.loss + w * system.damping) - w**2 * system.mass
        motion = np.linalg.solve(dynamic, (own @ system.expand)[..., np.newaxis])[..., 0]
        elastic = motion - motion @ system.mass @ rigid @ rigid.T
        loads = motion @ system.expand.T @ shaft.elongations().T * shaft.stiffness
        for names, values in ((shaft.elements, loads), (shaft.names, elastic @ system.expand.T)):
            for place, name in enumerate(names):
                found[order, name] = np.abs(values[:, place])
    return run, found


def tops(values, least=1e-5):
    """Places of the local maxima, and their values; one that rises by less is a shoulder."""
    at = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
    at = at[peak_prominences(values, at)[0] >= least * values[at]]
    return FINE[at], values[at]


def check(seed):
    """Compare both ways: no maximum is missing, and none is invented. Return how many were compared."""
    run, curves = case(seed)
    rows = [one for one in damped_criticals(run, speed_range=(LOW, HIGH)) if one.has_peak]
    maxima = {key: tops(values) for key, values in curves.items()}
    largest: dict[str, float] = {}
    for (_, name), (_, values) in maxima.items():
        largest[name] = max(largest.get(name, 0.0), float(np.max(values, initial=0.0)))
    compared = 0
    for (order, name), (speeds, values) in maxima.items():
        # A maximum next to an end may be beyond it by a digit.
        kept = values >= LEAST_PEAK * largest[name]
        kept &= (speeds > 1.001 * LOW) & (speeds < 0.999 * HIGH)
        of_place = [one for one in rows if one.order == order and name in (one.place, *one.others)]
        for speed, value in zip(speeds[kept], values[kept], strict=True):
            near = [
                one
                for one in of_place
                if 0.995 * one.spread[0] <= speed <= 1.005 * one.spread[1]
                and abs(one.speed / speed - 1.0) <= 2.0 * NEARLY
            ]
            assert near, (seed, order, name, speed, value / largest[name])
            assert max(one.severity for one in near) >= 0.99 * LEAST_PEAK
            compared += 1
        # Each row of a place is one of its maxima, so that they are as many.
        assert len(of_place) >= np.count_nonzero(kept)
    for one in rows:
        speeds, values = tops(curves[one.order, one.place], 0.0)
        if LOW * 1.001 < one.speed < HIGH * 0.999 and one.severity > 1e-3:
            nearest = int(np.argmin(np.abs(speeds - one.speed)))
            assert one.speed == close(speeds[nearest], rel=2e-3)
            assert one.amplitude == close(values[nearest], rel=1e-3)
    return compared


@pytest.mark.parametrize("seed", range(3))
def test_no_peak_of_any_place_is_missing(seed):
    assert check(seed) > 10


@pytest.mark.further
@pytest.mark.parametrize("block", range(10))
def test_no_peak_of_any_place_is_missing_in_two_hundred_chains(block):
    assert sum(check(1000 + 20 * block + seed) for seed in range(20)) > 400


@pytest.mark.further
def test_no_peak_is_told_where_no_place_has_one():
    """The mode of an order without a speed has no maximum near its frequencies at any place."""
    told = 0
    for seed in range(30, 45):
        run, curves = case(seed)
        for one in damped_criticals(run, speed_range=(LOW, HIGH)):
            if one.has_peak:
                continue
            told += 1
            for (order, _), values in curves.items():
                if order == one.order:
                    apart = np.abs(
                        tops(values)[0] / (2.0 * np.pi * one.mode_frequency / order) - 1.0
                    )
                    assert not np.any(apart < 0.5 * one.damping_ratio)
    assert told
