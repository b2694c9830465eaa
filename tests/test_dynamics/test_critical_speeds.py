"""Critical speeds, their peaks and causes."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import peak_prominences

from comparing import close
from crankbase.frames import table_of
from dynamics.assessment.separation import major_criticals
from dynamics.chains.chain import Chain, Gear
from dynamics.chains.dampers import RubberDamper, ViscousDamper
from dynamics.critical import critical_speeds, vector_sums
from dynamics.response.complex_modes import complex_modes
from dynamics.response.damped_criticals import LEAST_PEAK, NEARLY, _highest, damped_criticals
from dynamics.response.forced import forced_response
from dynamics.response.harmonic import damped_modes
from dynamics.response.linear_system import chain_system, damped
from dynamics.response.loads import alternating_stress, element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.peak_cause import peak_cause
from dynamics.response.resonance import refined_speeds
from references import even_firing_angles
from refusals import refusals, refusals_of, refused


def test_ends_of_the_range_belong_to_it():
    speed = 2.0 * math.pi * 100.0 / 4.0
    assert len(critical_speeds([100.0], [4.0], (speed, 2.0 * speed))) == 1
    assert len(critical_speeds([100.0], [4.0], (0.5 * speed, speed))) == 1


def test_weights_bring_out_a_minor_order():
    angles = even_firing_angles((1, 3, 4, 2))
    # Order 0.5 fires at 0, 270, 90, 180 deg of phase: 1 - 0.5 and 0.8 + 0.2 at right angles.
    assert vector_sums([0.5], angles, [1.0, 0.8, -0.2, 0.5]) == close([math.hypot(0.5, 1.0)])


@pytest.mark.parametrize(
    ("speed", "there"), [(89.9, False), (90.0, True), (110.0, True), (110.1, False)]
)
def test_only_major_orders_within_the_speeds_count(speed, there):
    """Order 3 meets the mode at the speed asked for; orders 2.5 and 3.5 beside it are minor."""
    frequency = 3.0 * speed / 6.283185307179586
    met = critical_speeds([frequency], [2.5, 3.0, 3.5], (1.0, 1000.0))
    majors = major_criticals(met, 100.0, cylinders=6, strokes=4, drives="generator")
    assert [critical.order for critical in majors.criticals] == ([3.0] if there else [])
    assert majors.passed is not there


SPEEDS = np.linspace(40.0, 200.0, 30)
ROW = Chain([1.0, 1.0, 4.0], [4e4, 4e4])
MAIN = Chain([1.0], [], {0: 1e4}, connections=[], names=["main"])


def response(chain, orders=(1.0, 2.0), node=0, speeds=SPEEDS):
    given = chain.chain if hasattr(chain, "record") else chain
    forces = np.zeros((len(orders), len(speeds), given.inertia.size), dtype=complex)
    forces[:, :, node] = 10.0
    return forced_response(chain, OrderExcitation(orders, speeds, forces))


def test_a_mode_that_creeps_is_none():
    assert complex_modes(damped(MAIN, modal_damping=1.5)).eigenvalues.size == 0
    found = damped_criticals(response(damped(MAIN, modal_damping=1.5)), node=0)
    assert [(one.order, one.mode, one.has_peak) for one in found] == [
        (1.0, 1, False),
        (2.0, 1, False),
    ]
    assert np.isnan(found[0].mode_frequency)
    assert "954.9 1/min" in found[0].sentence


def test_at_speeds_that_hold_all_that_are_looked_at():
    chain = damped(MAIN, modal_damping=0.02)
    speeds = refined_speeds([100.0 / (2.0 * np.pi)], 0.02, [1.0], (40.0, 200.0))
    (own,) = damped_criticals(response(chain, orders=(1.0,), speeds=speeds), node=0)
    assert own.speed == close(100.0 * np.sqrt(1.0 - 2.0 * 0.02**2), rel=1e-6)


def test_no_peak_with_much_damping():
    found = damped_criticals(response(damped(MAIN, modal_damping=0.75)), node=0)
    assert [one.has_peak for one in found] == [False, False]
    assert "nan" not in repr(found[0])
    assert found[0].damping_ratio == close(0.75)


@pytest.mark.parametrize("damping", [1e-3, 30.0, 1e6])
def test_the_ring_of_a_damper_free_and_locked(damping):
    chain = ViscousDamper(0.5, damping).attached(ROW, 0)
    modes = complex_modes(damped(chain, loss_factor=0.01))
    free = ROW.modes().frequencies[1:]
    locked = Chain([1.5, 1.0, 4.0], [4e4, 4e4]).modes().frequencies[1:]
    assert modes.undamped == close(free, rel=1e-9)
    assert modes.locked == close(locked, rel=1e-9)
    assert modes.numbers.tolist() == [1, 2]
    frame = modes.to_pandas()
    assert frame["undamped"].tolist() == close(free, rel=1e-9)
    assert frame["locked"].tolist() == close(locked, rel=1e-9)
    if damping == 1e-3:
        assert modes.frequencies == close(free, rel=1e-4)
    elif damping == 1e6:
        assert modes.frequencies == close(locked, rel=1e-4)
    else:
        assert np.all((locked < modes.frequencies) & (modes.frequencies < free))
        assert next(iter(modes.sources[0])) == "node 0 - damper ring"
    assert [sum(own.values()) for own in modes.sources] == close([1.0, 1.0])
    # Loss factors alone give half of themselves as a damping ratio.
    if damping != 30.0:
        assert modes.damping_ratios == close([0.005, 0.005], rel=0.05)


def test_sources_of_every_kind():
    chain = damped(
        RubberDamper(0.1, 3e3, 0.2, 1.0).attached(ROW, 0),
        relative={0: 2.0},
        absolute={1: 3.0},
        modal_damping=0.01,
    )
    modes = complex_modes(chain)
    names = set().union(*modes.sources)
    assert names == {"node 0 - damper ring", "node 0 - node 1", "node 1 to ground", "modal damping"}
    assert modes.shapes.shape == (4, 3)
    assert np.abs(modes.shapes).max(axis=0) == close([1.0, 1.0, 1.0])


def test_of_a_system_and_with_gears():
    modes = complex_modes(chain_system(MAIN).with_magnifier(10.0))
    assert modes.sources == ({"damping of the system": 1.0},)
    geared = Chain([1.0, 1.0, 2.0], [4e4], connections=[(0, 1)], gears=[Gear(1, 2, 2.0)])
    assert complex_modes(damped(geared)).frequencies == close(
        geared.modes().frequencies[1:], rel=1e-3
    )
    assert {one.place for one in damped_criticals(response(damped(geared)))} == {"node 0 - node 1"}


@pytest.mark.parametrize("chain", [damped(ROW), ViscousDamper(0.5, 30.0).attached(ROW, 0)])
def test_contributions_of_modes_are_the_whole_response(chain):
    found = response(chain)
    modes = complex_modes(found)
    row = (found.chain.elongations() @ found.system.expand)[0]
    forces = found.excitation.forces[1] @ found.system.expand
    parts = modes.contributions(2.0 * SPEEDS, forces, np.broadcast_to(row, forces.shape))
    assert parts.sum(axis=1) == close(found.unknowns[1] @ row, rel=1e-9)


def test_peaks_of_the_forces_are_no_resonances():
    """A force that is large about 90 rad/s makes a peak there, 10 % above the mode's own."""
    speeds = np.linspace(40.0, 200.0, 400)
    forces = (1.0 + 40.0 / (1.0 + ((speeds - 130.0) / 3.0) ** 2))[np.newaxis, :, np.newaxis]
    run = forced_response(
        damped(MAIN, modal_damping=0.01), OrderExcitation([1.0], speeds, forces.astype(complex))
    )
    own, other = damped_criticals(run, node=0)
    assert (own.in_band, other.in_band) == (True, False)
    assert own.speed == close(100.0, rel=2e-3)
    assert other.speed == close(130.0, rel=2e-2)
    assert "forces" in other.sentence


def test_what_is_asked_for():
    run = response(damped(ROW))
    every = damped_criticals(run)
    first = damped_criticals(run, elements=[0])
    assert {one.place for one in first if one.has_peak} == {"node 0 - node 1"}
    assert len(every) == len(first)
    part = damped_criticals(run, speed_range=(60.0, 140.0))
    assert 0 < len(part) < len(every)
    assert {one.speed for one in part} <= {one.speed for one in every}
    assert table_of(every)["speed"].tolist() == [one.speed for one in every]
    assert every[0].speed_rpm == close(every[0].speed * 30.0 / np.pi)


test_options_refused = refusals_of(
    lambda options: damped_criticals(response(damped(ROW)), **options),
    ({"elements": [0], "node": 0}, "node"),
    ({"elements": [2]}, "elements"),
    ({"node": "nowhere"}, "node"),
    ({"speed_range": (200.0, 100.0)}, "speed_range"),
    ({"speed_range": (10.0, 100.0)}, "speed_range"),
)


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
    assert found.sentence.index("order 6") < found.sentence.index("order 1,")


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


@pytest.mark.parametrize("rounding", [0.0, 1e-13, -1e-9, 1e-13j, -1e-13j, 1e-6 + 1e-5j])
def test_far_below_all_modes_of_a_free_chain_nothing_is_amplified(monkeypatch, rounding):
    """The rigid body's eigenvalue is round-off, of any size and direction, and no mode."""

    def rounded(system):
        terms = damped_modes(system)
        least = np.argmin(np.abs(terms.eigenvalues))
        eigenvalues = terms.eigenvalues.copy()
        eigenvalues[least] = rounding
        return replace(terms, eigenvalues=eigenvalues)

    monkeypatch.setattr("dynamics.response.complex_modes.damped_modes", rounded)
    draw = np.random.default_rng(5)
    chain = damped(Chain(draw.uniform(1.0, 30.0, 8), draw.uniform(1e7, 3e7, 7)), magnifier=40.0)
    speed = 0.01 * float(chain.chain.modes().angular_frequencies[1])
    forces = 100.0 * np.exp(1j * draw.uniform(0.0, 2.0 * np.pi, (6, 1, 8)))
    response = forced_response(chain, OrderExcitation(0.5 * np.arange(1, 7), [speed], forces))
    assert complex_modes(response).numbers.tolist() == [1, 2, 3, 4, 5, 6, 7]
    loads = element_loads(response).elastic
    for element in range(7):
        parts = peak_cause(response, loads, element, 0).parts
        assert {part.state for part in parts} == {"forced"}


def test_of_orders_at_one_resonance_the_largest_comes_first():
    found = cause({4.9: 10.0, 5.0: 100.0}, NATURAL / 5.0, 2.5)
    assert [one.order for one in found.resonant] == [5.0, 4.9]


def test_unbounded():
    found = cause({1.0: 100.0, 2.0: 10.0}, NATURAL / 2.0, None)
    assert np.isinf(found.amplitude)
    assert re.findall(r"\d", found.reasons) == ["2", "1"]
    assert "unbounded" in found.sentence


def test_small_orders_are_told_together_and_runs_end_at_orders_that_are_told_elsewhere():
    amplitudes = {0.5 * number: 10.0 for number in range(1, 7)} | {9.0: 0.05, 3.5: 0.01, 4.0: 1e-4}
    assert "0.5 to 3," in cause(amplitudes, 0.01 * NATURAL).sentence
    amplitudes = {1.0: 100.0, 2.0: 100.0, 3.0: 100.0, 4.0: 30.0, 5.0: 300.0, 6.0: 600.0, 7.0: 900.0}
    found = cause(amplitudes, NATURAL / 4.0)
    assert found.parts[3].state == "at resonance"
    assert "2 and 5 to 7," in found.reasons


def test_forces_that_another_vibration_brings():
    speed = NATURAL / 6.0
    torsional = cause({1.0: 100.0, 6.0: 10.0}, speed)
    chain = damped(Chain([1.0, 100.0], [1e7], names=["a", "b"]), magnifier=30.0)
    forces = np.zeros((2, 1, 2), dtype=complex)
    forces[:, 0, 0] = [5.0, 50.0]
    response = forced_response(chain, OrderExcitation([1.0, 6.0], [speed], forces))
    brought = OrderExcitation([1.0, 6.0], [speed], 0.8 * forces)
    found = peak_cause(
        response, response.elastic, "a", 0, unit="m", kind="axial", driven=(brought, torsional)
    )
    assert [one.state for one in found.parts] == ["forced", "at resonance"]
    assert found.parts[1].kind == "torsional"
    assert found.parts[1].amplitude == close(response.elastic.amplitude[1, 0, 0])
    little = OrderExcitation([1.0, 6.0], [speed], 0.3 * forces)
    alone = peak_cause(response, response.elastic, "a", 0, driven=(little, torsional))
    assert [one.state for one in alone.parts] == ["forced", "forced"]


def test_of_a_stress_and_no_place():
    forces = np.full((1, 2, 2), [10.0, 0.0], dtype=complex)
    response = forced_response(damped(PAIR), OrderExcitation([1.0], [50.0, 90.0], forces))
    stress = alternating_stress(element_loads(response), [1e-5])
    found = peak_cause(response, stress, "engine - generator", 1, unit="Pa")
    assert found.amplitude == close(stress.amplitude[0, 1, 0])
    assert found.parts[0].row()["order"] == (1.0, "1")
    with refused("speed_index"):
        peak_cause(response, stress, 0, 2)
    ground = element_loads(response).dashpots
    with refused("place"):
        peak_cause(response, ground, 0, 0)


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


@pytest.mark.parametrize(
    ("curve", "within"),
    [
        (
            lambda x: 1.0 / np.abs(1.0 - x**2 + 0.02j * x),
            2e-7,
        ),  # of a resonance, over an eighth of its band
        (
            lambda x: 1.0 + 1e-6 * np.cos(400.0 * (x - math.sqrt(0.9998))),
            1e-6,
        ),  # flat: round-off counts
        (lambda x: -np.abs(x - math.sqrt(0.9998)), 1.0 / 250.0),  # no parabola
        (lambda x: x, 1.0 / 100.0),
    ],
    ids=["resonance", "flat", "kink", "edge"],
)
def test_a_peak_is_found_within_a_share_of_its_bracket(curve, within):
    low, high = np.array([0.9989, 0.9987]), np.array([1.0014, 1.0012])
    top = high if curve(2.0) == 2.0 else math.sqrt(0.9998)
    assert np.all(np.abs(_highest(curve, low, high) - top) <= within * (high - low))


def test_a_peak_without_bounds_stays_where_it_is():
    place = np.array([3.0])
    assert _highest(lambda x: np.full(x.shape, np.inf), place, place) == close(place)


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


def test_the_resonance_of_what_excites_a_chain_is_not_called_a_mode_of_the_chain():
    """A mass with 40 % of critical damping: its own peak by constant forces, and one of another oscillator.

    Its own is at w_0 sqrt(1 - 2 d^2). Forces of an oscillator with 2 % of damping have a peak at its
    frequency, where the mass has 84 % of its largest magnifier.
    """
    chain = Chain(inertia=[1.0], stiffness=[], ground=[1e4], ground_damping=[80.0])
    speeds = np.linspace(5.0, 150.0, 1500)
    other = 40.0**2 / (40.0**2 - speeds**2 + 2j * 0.02 * 40.0 * speeds)

    def peaks(forces):
        excitation = OrderExcitation(np.array([1.0]), speeds, forces[np.newaxis, :, np.newaxis])
        return damped_criticals(forced_response(chain, excitation))

    (own,) = peaks(np.ones(1500, dtype=complex))
    assert (own.in_band, own.modes) == (True, (1,))
    assert own.speed == close(100.0 * math.sqrt(1.0 - 2.0 * 0.4**2), rel=1e-6)
    (foreign,) = peaks(other)
    assert (foreign.in_band, foreign.modes) == (False, ())
    assert foreign.speed == close(40.0, rel=1e-3)


test_refused = refusals(
    ("orders[0]", lambda: critical_speeds([10.0], [0.0], (1.0, 2.0))),
    ("frequencies[0]", lambda: critical_speeds([-1.0], [1.0], (1.0, 2.0))),
    ("weights", lambda: vector_sums([1.0], [0.0, 1.0], [1.0])),
    ("firing_angles", lambda: vector_sums([1.0], [])),
    ("rated_speed", lambda: major_criticals((), 0.0, cylinders=6, strokes=4)),
    ("response", lambda: damped_criticals(response(damped(ROW), speeds=np.array([50.0])))),
)
