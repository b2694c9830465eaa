import numpy as np
import pytest

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


def test_a_gear_may_be_without_inertia(shaft):
    geared = add_node(shaft, "d", 0.0, to="c", ratio=3.0)
    assert geared.modes().frequencies == close(shaft.modes().frequencies)


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
    ("change", "message"),
    [
        (lambda c: find_node(c, "x"), "node: given 'x'; allowed are a, b, c"),
        (lambda c: find_node(c, 3), "node: given 3; allowed are the whole numbers 0 to 2"),
        (lambda c: join_chains(c, "c", c), "name: given 'b', which a node of the chain has"),
        (lambda c: join_chains(c, "c", c, "x"), "other_at: given 'x'"),
        (
            lambda c: join_chains(c, "c", c, stiffness=1.0, ratio=2.0, prefix="2 "),
            "stiffness: given 1 beside a ratio",
        ),
        (lambda c: join_chains(c, "c", c, ratio=0.0, prefix="2 "), "gear.ratio: given 0"),
        (lambda c: add_node(c, "d", 1.0, to="c"), "dashpot.damping: given 0"),
        (lambda c: add_node(c, "d", 1.0, to="c", loss_factor=0.1), "stiffness: given none beside"),
        (lambda c: add_node(c, "d", 1.0, to="c", stiffness=-1.0), r"stiffness\[2\]: given -1"),
        (lambda c: add_node(c, "a", 1.0, to="c", stiffness=1.0), "name: given 'a'"),
        (lambda c: with_ground(c, "a", -1.0), "stiffness: given -1"),
        (lambda c: with_inertia(c, "a", -1.0), "added: given -1"),
        (lambda c: with_element(c, "a", "a", 1.0), r"connections\[2\]: given node 0 twice"),
        (lambda c: with_gear(c, "a", "c", 2.0), "gears: given ratios"),
    ],
)
def test_unusable_changes_are_refused(shaft, change, message):
    with pytest.raises(InputError, match=message):
        change(shaft)
