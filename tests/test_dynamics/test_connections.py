"""Gears, branches, dashpots and loops: chains with gears against equivalent chains without."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import chain_system

value = st.floats(0.5, 2.0)
ratio = st.floats(0.3, 4.0).flatmap(lambda r: st.sampled_from([r, -r]))


def answer(chain, frequency, node):
    forces = np.zeros((1, len(chain.names)), dtype=complex)
    forces[0, node] = 1.0
    system = chain_system(chain)
    found = harmonic_response(system, np.array([frequency]), forces @ system.expand)
    return (system.expand @ found.motion.T)[:, 0]


@settings(max_examples=15)
@given(st.lists(value, min_size=12, max_size=12), ratio, st.floats(0.2, 3.0))
def test_a_geared_chain_is_its_equivalent_by_the_ratio_squared(v, r, frequency):
    # Nodes 0-1 on one shaft, 2-3 on another that turns r times as fast, 1 and 2 being the gears.
    geared = Chain(
        v[:4],
        v[4:6],
        {3: v[6]},
        connections=[(0, 1), (2, 3)],
        damping=v[7:9],
        loss_factor=[0.1, 0.2],
        ground_damping={3: v[9]},
        distributed_inertia=v[10:12],
        gears=[Gear(1, 2, r)],
    )
    q = r * r
    plain = Chain(
        [v[0], v[1] + q * v[2], q * v[3]],
        [v[4], q * v[5]],
        {2: q * v[6]},
        damping=[v[7], q * v[8]],
        loss_factor=[0.1, 0.2],
        ground_damping={2: q * v[9]},
        distributed_inertia=[v[10], q * v[11]],
    )
    # Round-off: the systems are the same but for the order of sums.
    assert geared.modes().frequencies == close(plain.modes().frequencies, rel=1e-9)
    moved, referred = answer(geared, frequency, 0), answer(plain, frequency, 0)
    expected = np.array([referred[0], referred[1], r * referred[1], r * referred[2]])
    assert moved == close(expected, rel=1e-8)


@settings(max_examples=10)
@given(st.lists(value, min_size=10, max_size=10), ratio, ratio)
def test_two_gears_in_a_row_multiply_and_branches_add(v, first, second):
    # 0 on the first shaft; 1-2 behind the first gear; 3-4 behind the second, which node 2 drives.
    geared = Chain(
        v[:6],
        v[6:9],
        connections=[(0, 1), (2, 3), (4, 5)],
        gears=[Gear(1, 2, first), Gear(3, 4, second)],
    )
    a, b = first**2, (first * second) ** 2
    plain = Chain(
        [v[0], v[1] + a * v[2], a * v[3] + b * v[4], b * v[5]], [v[6], a * v[7], b * v[8]]
    )
    assert geared.modes().frequencies == close(plain.modes().frequencies, rel=1e-9, abs=1e-9)
    assert geared.speed_ratios == close([1, 1, first, first, first * second, first * second])
    assert geared.modes().rigid == 1


def test_a_loop_through_gears_that_agree():
    # Two shafts side by side between two equal pairs of gears share the torque: their stiffnesses,
    # referred to one of them, add.
    r = 2.5
    loop = Chain(
        [1.0, 1.0, 0.1, 0.1],
        [3.0, 0.4],
        connections=[(0, 1), (2, 3)],
        gears=[Gear(0, 2, r), Gear(1, 3, r)],
    )
    inertia, stiffness = 1.0 + 0.1 * r**2, 3.0 + 0.4 * r**2
    assert loop.modes().angular_frequencies == close([0.0, np.sqrt(2.0 * stiffness / inertia)])


def test_an_idler_gear_may_be_without_inertia():
    # Shaft, idler and shaft: 0 - 1 and 3 - 4 are springs, 2 the idler between the gears 1 and 3.
    chain = Chain(
        [1.0, 0.1, 0.0, 0.1, 1.0],
        [3.0, 3.0],
        connections=[(0, 1), (3, 4)],
        gears=[Gear(1, 2, -2.0), Gear(2, 3, -0.5)],
    )
    assert chain.speed_ratios.tolist() == [1.0, 1.0, -2.0, 1.0, 1.0]
    expected = Chain([1.0, 0.2, 1.0], [3.0, 3.0]).modes().frequencies
    assert chain.modes().frequencies == close(expected)
    with pytest.raises(InputError, match=r"inertia\[2\]: given 0; allowed is more than zero where"):
        Chain([1.0, 1.0, 0.0], [1.0], connections=[(1, 2)], gears=[Gear(0, 1, 2.0)])


def test_a_loop_of_springs():
    # Three equal inertias in a ring: 0 and twice sqrt(3 k / m).
    ring = Chain([2.0] * 3, [5.0] * 3, connections=[(0, 1), (1, 2), (2, 0)])
    assert ring.modes().angular_frequencies == close([0.0, 7.5**0.5, 7.5**0.5])


def test_two_ways_through_gears_that_contradict():
    for gears in ([Gear(0, 2, 2.0), Gear(1, 3, 2.1)], [Gear(0, 2, 2.0), Gear(1, 3, -2.0)]):
        with pytest.raises(InputError, match=r"gears: given ratios .*because otherwise the shafts"):
            Chain([1.0] * 4, [1.0] * 2, connections=[(0, 1), (2, 3)], gears=gears)
    with pytest.raises(InputError, match="gears: given ratios"):
        Chain([1.0] * 2, [1.0], gears=[Gear(0, 1, 1.5)])


def test_dashpots_join_and_let_turn():
    chain = Chain([1.0, 1.0, 1.0], [4.0], connections=[(0, 1)], dashpots=[Dashpot(1, 2, 3.0)])
    modes = chain.modes()
    assert modes.rigid == 2
    assert modes.names[:2] == ("rigid body: node 0, node 1", "rigid body: node 2")


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Gear(0, 1, 0.0), "gear.ratio: given 0"),
        (lambda: Gear(0, 1, float("inf")), "gear.ratio.*given inf"),
        (lambda: Dashpot(0, 1, -1.0), "dashpot.damping: given -1"),
        (
            lambda: Chain([1.0] * 3, [1.0], connections=[(0, 1)]),
            "connections: given ones that do not join node 2 to node 0",
        ),
        (
            lambda: Chain([1.0] * 2, [1.0], connections=[(0, 0)]),
            r"connections\[0\]: given node 0 twice",
        ),
        (
            lambda: Chain([1.0] * 2, [1.0], connections=[(0, 2)]),
            r"connections\[0\]: given 2; allowed",
        ),
        (lambda: Chain([1.0] * 2, [1.0], gears=[Gear(0, 5, 1.0)]), r"gears\[0\]: given 5"),
        (
            lambda: Chain([1.0] * 4, [1.0] * 2, connections=[(0, 1), (2, 3)], gears=[(1, 2, -0.6)]),
            r"gears\[0\]: given \(1, 2, -0.6\); allowed is a Gear, like Gear\(driver=1",
        ),
        (
            lambda: Chain([1.0] * 2, [1.0], dashpots=[(0, 1, 3.0)]),
            r"dashpots\[0\]: given \(0, 1, 3.0\); allowed is a Dashpot",
        ),
        (
            lambda: Chain([1.0] * 2, [1.0], gears=Gear(0, 1, 2.0)),
            "gears: given Gear.*; allowed is a sequence of Gear",
        ),
        (lambda: Chain([1.0] * 2, [1.0], names=["a", "a"]), "names: given 2 names, 1 of them"),
    ],
)
def test_unusable_links_are_refused(build, message):
    with pytest.raises(InputError, match=message) as raised:
        build()
    assert "\n" not in str(raised.value)
