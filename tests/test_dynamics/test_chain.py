"""Torsional and axial chains: elements, editing, gears and branches."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.editing import (
    add_node,
    find_node,
    join_chains,
    with_dashpot,
    with_element,
    with_gear,
    with_ground,
    with_inertia,
    with_names,
)
from dynamics.chains.varying import Variation, Varying
from dynamics.excitation.propeller import PropellerForces, propeller_excitation
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import chain_system
from refusals import refusals, refusals_of, refused


@st.composite
def chain_values(draw, supported=None):
    count = draw(st.integers(1, 6))
    # Ratios up to four: the comparisons with other routines need well-separated frequencies.
    value = st.floats(0.5, 2.0)
    inertia = draw(st.lists(value, min_size=count, max_size=count))
    stiffness = draw(st.lists(value, min_size=count - 1, max_size=count - 1))
    ground = [0.0] * count
    if draw(st.booleans()) if supported is None else supported:
        ground[draw(st.integers(0, count - 1))] = draw(value)
    return inertia, stiffness, ground


def test_node_on_an_inertia_counts_once():
    modes = Chain([1.0, 1.0, 1.0], [1.0, 1.0]).modes()
    assert modes.node_positions[1] == (1.0,)
    assert modes.node_positions[2] == close((1.0 / 3.0, 5.0 / 3.0))
    assert modes.shapes[:, 1] == close([1.0, 0.0, -1.0], abs=1e-14)


def test_lowest_frequency_of_a_stiff_chain_on_a_soft_support():
    # A rigid row of masses on one spring; the error left is the compliance ratio times the count.
    modes = Chain(np.ones(10), np.full(9, 1e14), {0: 1.0}).modes()
    assert modes.angular_frequencies[0] == close(np.sqrt(0.1), rel=1e-7)


@pytest.mark.slow
@given(chain_values())
def test_frequencies_are_those_of_the_general_eigenproblem(values):
    chain = Chain(*values)
    squares = eigh(chain.stiffness_matrix(), chain.mass_matrix(), eigvals_only=True)
    expected = np.sqrt(np.maximum(squares, 0.0))
    assert chain.modes().angular_frequencies == close(expected, rel=1e-9, abs=1e-6)


@pytest.mark.slow
@given(chain_values())
def test_modes_are_orthogonal_and_scaled(values):
    chain = Chain(*values)
    modes = chain.modes()
    products = modes.shapes.T @ chain.mass_matrix() @ modes.shapes
    sizes = np.sqrt(np.diag(products))
    assert products / np.outer(sizes, sizes) == close(np.eye(sizes.size), abs=1e-12)
    assert np.max(np.abs(modes.shapes), axis=0) == close(np.ones(sizes.size))
    assert np.max(modes.shapes, axis=0) == close(np.ones(sizes.size))
    assert np.all(np.diff(modes.frequencies) > 0.0)
    assert modes.residual < 1e-13


@given(st.integers(0, 2**32 - 1))
def test_mode_number_counts_the_nodes_of_branches_too(seed):
    """Of a tree, with inertia along its shafts, whose modes decay into far ends."""
    random = np.random.default_rng(seed)
    count = random.integers(3, 14)
    chain = Chain(
        10 ** random.uniform(-2.0, 3.0, count),
        10 ** random.uniform(5.0, 9.0, count - 1),
        connections=tuple((int(random.integers(node)), node) for node in range(1, count)),
        distributed_inertia=10 ** random.uniform(-3.0, 2.0, count - 1),
    )
    counts = [len(positions) for positions in chain.modes().node_positions]
    assert counts == list(range(count))


@pytest.mark.slow
@given(chain_values())
def test_mode_number_counts_the_nodes(values):
    modes = Chain(*values).modes()
    assert [len(positions) for positions in modes.node_positions] == list(range(len(values[0])))
    for positions in modes.node_positions:
        assert list(positions) == sorted(positions)
        assert all(0.0 <= position <= len(values[0]) - 1 for position in positions)


test_unusable_chains_are_refused = refusals_of(
    Chain,
    ([], [], None, "inertia"),
    ([1.0, 0.0], [1.0], None, "inertia[1]"),
    ([1.0, 1.0], [0.0], None, "stiffness[0]"),
    ([1.0, 1.0], [1.0, 1.0], None, "stiffness"),
    ([1.0, 1.0], [1.0], [1.0], "ground"),
    ([1.0, 1.0], [1.0], [1.0, -1.0], "ground[1]"),
    ([1.0, 1.0], [1.0], {1: -1.0}, "ground[1]"),
    ([1.0, 1.0], [1.0], {2: 1.0}, "ground[2]"),
    ([1.0, 1.0], [1.0], {"a": 1.0}, "ground['a']"),
)


def test_chain_keeps_its_own_values():
    inertia = np.array([1.0, 2.0])
    chain = Chain(inertia, [3.0])
    inertia[0] = 9.0
    assert chain.inertia.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        chain.inertia[0] = 9.0


@pytest.fixture
def shaft():
    return Chain(
        [1.0, 2.0, 3.0],
        [10.0, 20.0],
        {2: 5.0},
        damping=[0.1, 0.2],
        loss_factor=[0.3, 0.4],
        ground_damping={0: 0.5},
        distributed_inertia=[0.6, 0.7],
        dashpots=[Dashpot(0, 2, 0.8)],
        names=["a", "b", "c"],
    )


def block(*matrices):
    size = sum(len(m) for m in matrices)
    whole, start = np.zeros((size, size)), 0
    for m in matrices:
        whole[start : start + len(m), start : start + len(m)] = m
        start += len(m)
    return whole


MATRICES = ("mass_matrix", "stiffness_matrix", "damping_matrix", "loss_matrix")


def test_merged_nodes_add_up_everything(shaft):
    other = with_names(shaft, ["d", "e", "f"])
    joined = join_chains(shaft, "c", other)
    assert joined.names == ("a", "b", "c", "e", "f")
    assert joined.is_row
    # Both matrices side by side, nodes 2 and 3 moving as one.
    expand = np.zeros((6, 5))
    expand[[0, 1, 2, 3, 4, 5], [0, 1, 2, 2, 3, 4]] = 1.0
    for name in MATRICES:
        apart = block(getattr(shaft, name)(), getattr(other, name)())
        assert getattr(joined, name)() == close(expand.T @ apart @ expand)


def test_chains_joined_by_an_element_and_by_a_gear(shaft):
    other = Chain([4.0, 5.0], [7.0], names=["a", "b"], gears=[Gear(0, 1, 1.0)])
    joined = join_chains(
        shaft, 1, other, "b", stiffness=9.0, damping=0.1, loss_factor=0.2, prefix="2 "
    )
    assert joined.names == ("a", "b", "c", "2 a", "2 b")
    assert joined.connections == ((0, 1), (1, 2), (3, 4), (1, 4))
    assert joined.stiffness.tolist() == [10.0, 20.0, 7.0, 9.0]
    assert joined.loss_factor[-1] == 0.2
    assert joined.gears == (Gear(3, 4, 1.0),)
    assert joined.dashpots == (Dashpot(0, 2, 0.8),)
    geared = join_chains(shaft, "a", other, 1, ratio=-2.0, prefix="2 ")
    assert geared.gears == (Gear(3, 4, 1.0), Gear(0, 4, -2.0))
    assert geared.stiffness.tolist() == [10.0, 20.0, 7.0]
    loose = join_chains(shaft, "a", other, damping=3.0, prefix="2 ")
    assert loose.dashpots == (Dashpot(0, 2, 0.8), Dashpot(0, 3, 3.0))


def test_nodes_are_added_in_three_ways(shaft):
    spring = add_node(shaft, "d", 4.0, to="c", stiffness=6.0, damping=0.1, distributed_inertia=0.2)
    assert spring.names[-1] == "d"
    assert spring.connections[-1] == (2, 3)
    assert (spring.stiffness[-1], spring.distributed_inertia[-1]) == (6.0, 0.2)
    assert add_node(shaft, "d", 4.0, to=0, damping=1.5).dashpots[-1] == Dashpot(0, 3, 1.5)
    assert add_node(shaft, "d", 4.0, to="b", ratio=3.0).gears == (Gear(1, 3, 3.0),)


def test_links_and_supports_are_added(shaft):
    assert with_element(shaft, "a", "c", 4.0, loss_factor=0.1).connections[-1] == (0, 2)
    assert with_dashpot(shaft, "a", "b", 4.0).dashpots[-1] == Dashpot(0, 1, 4.0)
    loose = Chain([1.0, 1.0, 1.0], [2.0], connections=[(0, 1)], dashpots=[Dashpot(1, 2, 1.0)])
    assert with_gear(loose, 1, 2, 2.0).gears == (Gear(1, 2, 2.0),)
    held = with_ground(with_inertia(shaft, "b", 7.0), "c", 5.0, damping=0.1)
    assert held.inertia.tolist() == [1.0, 9.0, 3.0]
    assert held.ground.tolist() == [0.0, 0.0, 10.0]
    assert held.ground_damping.tolist() == [0.5, 0.0, 0.1]
    assert shaft.inertia.tolist() == [1.0, 2.0, 3.0]
    assert find_node(shaft, "c") == find_node(shaft, 2) == 2


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda c: find_node(c, "x"), "node"),
        (lambda c: find_node(c, 3), "node"),
        (lambda c: join_chains(c, "c", c), "name"),
        (lambda c: join_chains(c, "c", c, "x"), "other_at"),
        (lambda c: join_chains(c, "c", c, stiffness=1.0, ratio=2.0, prefix="2 "), "stiffness"),
        (lambda c: join_chains(c, "c", c, ratio=0.0, prefix="2 "), "gear.ratio"),
        (lambda c: add_node(c, "d", 1.0, to="c"), "dashpot.damping"),
        (lambda c: add_node(c, "d", 1.0, to="c", loss_factor=0.1), "stiffness"),
        (lambda c: add_node(c, "d", 1.0, to="c", stiffness=-1.0), "stiffness[2]"),
        (lambda c: add_node(c, "a", 1.0, to="c", stiffness=1.0), "name"),
        (lambda c: with_ground(c, "a", -1.0), "stiffness"),
        (lambda c: with_inertia(c, "a", -1.0), "added"),
        (lambda c: with_element(c, "a", "a", 1.0), "connections[2]"),
        (lambda c: with_gear(c, "a", "c", 2.0), "gears"),
    ],
)
def test_unusable_changes_are_refused(shaft, change, field):
    with refused(field):
        change(shaft)


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
    with refused("inertia[2]"):
        Chain([1.0, 1.0, 0.0], [1.0], connections=[(1, 2)], gears=[Gear(0, 1, 2.0)])


@pytest.mark.slow
@settings(max_examples=15)
@given(st.lists(value, min_size=6, max_size=6), ratio, st.floats(0.2, 3.0), st.floats(0.0, 0.2))
def test_gears_without_inertia_stand_in_equilibrium(v, r, frequency, loss):
    def shafts(gear, losses=(loss, loss)):
        # Nodes 0 - 1 and 2 - 3 on shafts that the gears 1 and 2 join.
        return Chain(
            [v[0], gear, gear, v[1]],
            v[2:4],
            {3: v[4]},
            connections=[(0, 1), (2, 3)],
            loss_factor=losses,
            gears=[Gear(1, 2, r)],
        )

    led = shafts(0.0)
    # In series: the first spring seen from the second shaft is 1/r^2 as stiff.
    spring = 1.0 / (1.0 / v[3] + r * r / v[2])
    plain = Chain([r**-2 * v[0], v[1]], [spring], {1: v[4]}, loss_factor=loss)
    assert led.leading_nodes.tolist() == [0, 3]
    assert led.modes().frequencies == close(plain.modes().frequencies, rel=1e-9)
    # Moments about the first shaft are r times those about the second, motions 1/r.
    moved, referred = answer(led, frequency, 3), answer(plain, frequency, 1)
    assert moved[[0, 3]] == close(np.array([referred[0] / r, referred[1]]), rel=1e-8)
    # Gears of next to no inertia move alike.
    assert moved == close(answer(shafts(1e-9), frequency, 3), rel=1e-5)
    # The error by loss factors that differ is a quarter of their squared difference at most.
    still, light = (answer(shafts(gear, (0.0, 0.1)), 1e-4, 0)[0] for gear in (0.0, 1e-9))
    assert abs(still / light - 1.0) <= 0.26 * 0.1**2


@pytest.mark.parametrize(
    "resisted",
    [
        {"damping": [0.1, 0.0]},
        {"ground_damping": {2: 0.1}},
        {"dashpots": [Dashpot(0, 1, 0.1)]},
        {"varying": [Varying(1, Variation(speed=(0.0, 1.0), stiffness=(1.0, 2.0)).of(2.0))]},
        {"inertia": [0.0, 0.0, 0.0, 1.0], "connections": [(1, 0), (2, 3)]},
    ],
)
def test_gears_without_inertia_need_springs_that_lead_them(resisted):
    chain = {"inertia": [1.0, 0.0, 0.0, 1.0], "stiffness": [1.0, 2.0], "gears": [Gear(1, 2, 2.0)]}
    chain["connections"] = [(0, 1), (2, 3)]
    assert Chain(**chain).leading_nodes.tolist() == [0, 3]
    with pytest.raises(InputError, match=r"inertia\[\d\]: given 0; allowed is .*because a node"):
        Chain(**chain | resisted)


def test_a_loop_of_springs():
    # Three equal inertias in a ring: 0 and twice sqrt(3 k / m).
    ring = Chain([2.0] * 3, [5.0] * 3, connections=[(0, 1), (1, 2), (2, 0)])
    assert ring.modes().angular_frequencies == close([0.0, 7.5**0.5, 7.5**0.5])


def test_two_ways_through_gears_that_contradict():
    for gears in ([Gear(0, 2, 2.0), Gear(1, 3, 2.1)], [Gear(0, 2, 2.0), Gear(1, 3, -2.0)]):
        with refused("gears"):
            Chain([1.0] * 4, [1.0] * 2, connections=[(0, 1), (2, 3)], gears=gears)


def test_dashpots_join_and_let_turn():
    chain = Chain([1.0, 1.0, 1.0], [4.0], connections=[(0, 1)], dashpots=[Dashpot(1, 2, 3.0)])
    modes = chain.modes()
    assert modes.rigid == 2
    assert modes.names[:2] == ("rigid body: node 0, node 1", "rigid body: node 2")


SPEEDS = np.array([40.0, 80.0])
FORCES = PropellerForces(
    4,
    20.0,
    3e5,
    2e5,
    [0.08, 0.02],
    [0.1, 0.03],
    thrust_phases_deg=np.degrees([0.3, 1.0]),
    torque_phases_deg=np.degrees([-0.5, 2.0]),
)
ANGLES = np.random.default_rng(5).uniform(0.0, 60.0, 25)


def geared(ratio):
    return Chain(
        [2.0, 30.0, 5.0, 80.0], [1e6, 1e6], connections=[(0, 1), (2, 3)], gears=[Gear(1, 2, ratio)]
    )


@pytest.mark.parametrize("ratio", [0.25, -0.3])
def test_torque_varies_with_the_angle_of_the_propeller(ratio):
    found = propeller_excitation(FORCES, geared(ratio), 3, SPEEDS, kind="torsional")
    assert found.orders == close([4 * abs(ratio), 8 * abs(ratio)])
    theta = ratio * ANGLES
    mean = 2e5 * (ratio * 80.0 / 20.0) ** 2
    varying = mean * (0.1 * np.sin(4 * theta - 0.5) + 0.03 * np.sin(8 * theta + 2.0))
    # It resists the turning of its own node.
    assert found.at_angle(1, shaft_angle_deg=np.degrees(ANGLES))[:, 3] == close(
        -np.sign(ratio) * varying, abs=1e-9 * mean
    )
    assert np.all(found.forces[:, :, :3] == 0.0)
    assert FORCES.mean_torque([ratio * 80.0]) == close([mean])


def test_thrust_acts_towards_the_free_end():
    chain = Chain([10.0, 20.0], [1e9])
    found = propeller_excitation(FORCES, chain, 1, SPEEDS, kind="axial", ratio=0.5)
    theta = 0.5 * ANGLES
    mean = 3e5 * (0.5 * 40.0 / 20.0) ** 2
    varying = mean * (0.08 * np.sin(4 * theta + 0.3) + 0.02 * np.sin(8 * theta + 1.0))
    assert found.at_angle(0, shaft_angle_deg=np.degrees(ANGLES))[:, 1] == close(
        -varying, abs=1e-9 * mean
    )
    direct = propeller_excitation(FORCES, chain, 1, SPEEDS, kind="axial")
    assert direct.orders.tolist() == [4.0, 8.0]


def test_what_does_not_fit_is_refused():
    chain = geared(0.25)
    for changed, field in (
        ({"node": 4}, "propeller node"),
        ({"kind": "bending"}, "kind"),
        ({"ratio": 0.0}, "ratio"),
        ({"speeds": [2.0, 1.0]}, "speeds[1]"),
    ):
        given = {"node": 3, "speeds": SPEEDS, "kind": "torsional"} | changed
        with refused(field):
            propeller_excitation(FORCES, chain, **given)
    steady = PropellerForces(4, 20.0, 3e5, 2e5, [], [0.1])
    with refused("propeller"):
        propeller_excitation(steady, chain, 3, SPEEDS, kind="axial")
    with refused("propeller_forces.thrust_phases"):
        PropellerForces(4, 20.0, 3e5, 2e5, [0.1, 0.02], [], thrust_phases_deg=[0.1])


test_refused_calls = refusals(
    ("connections[0]", lambda: Chain([1.0, 1.0], [1.0], connections=[(0, 1, 1)])),
    ("gears", lambda: Chain([1.0] * 2, [1.0], gears=[Gear(0, 1, 1.5)])),
    ("propeller_forces.blades", lambda: PropellerForces(1, 20.0, 3e5, 2e5, [0.1], [])),
    ("gear.ratio", lambda: Gear(0, 1, 0.0)),
    ("gear.ratio[0]", lambda: Gear(0, 1, float("inf"))),
    ("dashpot.damping", lambda: Dashpot(0, 1, -1.0)),
    ("connections", lambda: Chain([1.0] * 3, [1.0], connections=[(0, 1)])),
    ("connections[0]", lambda: Chain([1.0] * 2, [1.0], connections=[(0, 0)])),
    ("connections[0]", lambda: Chain([1.0] * 2, [1.0], connections=[(0, 2)])),
    ("gears[0]", lambda: Chain([1.0] * 2, [1.0], gears=[Gear(0, 5, 1.0)])),
    ("gears[0]", lambda: Chain([1.0] * 2, [1.0], gears=[(1, 0, -0.6)])),
    ("dashpots[0]", lambda: Chain([1.0] * 2, [1.0], dashpots=[(0, 1, 3.0)])),
    ("gears", lambda: Chain([1.0] * 2, [1.0], gears=Gear(0, 1, 2.0))),
    ("names", lambda: Chain([1.0] * 2, [1.0], names=["a", "a"])),
)
