import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain

# Of laws that hold for any chain or none.
FEW = settings(max_examples=30)


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


def test_matrices():
    chain = Chain([1.0, 2.0, 3.0], [10.0, 20.0], {2: 5.0})
    assert chain.mass_matrix().tolist() == np.diag([1.0, 2.0, 3.0]).tolist()
    expected = [[10.0, -10.0, 0.0], [-10.0, 30.0, -20.0], [0.0, -20.0, 25.0]]
    assert chain.stiffness_matrix().tolist() == expected


def test_ground_as_array_and_as_mapping_agree():
    mapped = Chain([1.0, 2.0], [3.0], {0: 4.0})
    listed = Chain([1.0, 2.0], [3.0], [4.0, 0.0])
    assert mapped.ground.tolist() == listed.ground.tolist() == [4.0, 0.0]


def test_one_mass():
    assert Chain([2.0], []).modes().frequencies.tolist() == [0.0]
    held = Chain([2.0], [], [8.0]).modes()
    assert held.angular_frequencies == close([2.0])
    assert held.rigid == 0
    assert held.node_positions == ((),)


def test_rigid_body_mode_is_exact():
    modes = Chain([0.017, 2.0, 3e-4], [1e6, 7e5]).modes()
    assert modes.rigid == 1
    assert modes.frequencies[0] == 0.0
    assert modes.shapes[:, 0].tolist() == [1.0, 1.0, 1.0]


def test_node_on_an_inertia_counts_once():
    modes = Chain([1.0, 1.0, 1.0], [1.0, 1.0]).modes()
    assert modes.node_positions[1] == (1.0,)
    assert modes.node_positions[2] == close((1.0 / 3.0, 5.0 / 3.0))
    assert modes.shapes[:, 1] == close([1.0, 0.0, -1.0], abs=1e-14)


def test_node_of_two_masses_divides_the_shaft_by_their_inertias():
    modes = Chain([3.0, 1.0], [5.0]).modes()
    assert modes.node_positions[1] == close((0.25,))


def test_lowest_frequency_of_a_stiff_chain_on_a_soft_support():
    # A rigid row of masses on one spring; the error left is the compliance ratio times the count.
    modes = Chain(np.ones(10), np.full(9, 1e14), {0: 1.0}).modes()
    assert modes.angular_frequencies[0] == close(np.sqrt(0.1), rel=1e-7)


@given(chain_values())
def test_frequencies_are_those_of_the_general_eigenproblem(values):
    chain = Chain(*values)
    squares = eigh(chain.stiffness_matrix(), chain.mass_matrix(), eigvals_only=True)
    expected = np.sqrt(np.maximum(squares, 0.0))
    assert chain.modes().angular_frequencies == close(expected, rel=1e-9, abs=1e-6)


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


@given(chain_values(), st.floats(1e-6, 1e6))
@FEW
def test_stiffness_times_s_gives_frequencies_times_its_root(values, factor):
    inertia, stiffness, ground = values
    scaled = Chain(inertia, factor * np.array(stiffness), factor * np.array(ground))
    expected = np.sqrt(factor) * Chain(*values).modes().frequencies
    assert scaled.modes().frequencies == close(expected, rel=1e-12)


@given(chain_values(), st.floats(1e-6, 1e6))
@FEW
def test_change_of_both_units_changes_nothing(values, factor):
    inertia, stiffness, ground = (factor * np.array(part) for part in values)
    modes, expected = Chain(inertia, stiffness, ground).modes(), Chain(*values).modes()
    assert modes.frequencies == close(expected.frequencies, rel=1e-12)


@given(chain_values())
@FEW
def test_chain_turned_end_for_end_keeps_its_frequencies(values):
    turned = Chain(*(part[::-1] for part in values))
    expected = Chain(*values).modes().frequencies
    assert turned.modes().frequencies == close(expected, rel=1e-12)


@given(chain_values())
def test_mode_number_counts_the_nodes(values):
    modes = Chain(*values).modes()
    assert [len(positions) for positions in modes.node_positions] == list(range(len(values[0])))
    for positions in modes.node_positions:
        assert list(positions) == sorted(positions)
        assert all(0.0 <= position <= len(values[0]) - 1 for position in positions)


@given(
    st.lists(st.tuples(st.floats(-4.0, 2.0), st.floats(3.0, 9.0)), min_size=2, max_size=10),
    st.floats(3.0, 9.0) | st.none(),
)
@example([(0.0, 3.0), (-3.0, 9.0), (2.0, 3.0)], None)
def test_mode_number_counts_the_nodes_where_modes_die_out(exponents, ground):
    inertia = [10.0**first for first, _ in exponents]
    stiffness = [10.0**second for _, second in exponents[1:]]
    chain = Chain(inertia, stiffness, None if ground is None else {0: 10.0**ground})
    counted = [len(positions) for positions in chain.modes().node_positions]
    assert counted == list(range(len(inertia)))


def test_displacements_far_from_a_local_mode():
    # A light end on a stiff spring vibrates against a row of heavy masses: by the equation of the
    # far end each displacement is about -k / (w^2 m) of the one before it.
    modes = Chain([1e-4, 1.0, 1.0, 1.0, 1.0], [1e6, 1e6, 1e6, 1e6]).modes()
    ratios = modes.shapes[1:, -1] / modes.shapes[:-1, -1]
    square = modes.angular_frequencies[-1] ** 2
    assert ratios[-1] == close(-1e6 / (square - 1e6), rel=1e-9)
    assert ratios == close(np.full(4, -1e6 / square), rel=3e-4)
    assert abs(modes.shapes[-1, -1]) < 1e-15


@given(chain_values(supported=False), st.floats(0.01, 2.0))
@FEW
def test_any_support_raises_every_frequency(values, added):
    inertia, stiffness, _ = values
    free = Chain(inertia, stiffness).modes().frequencies
    held = Chain(inertia, stiffness, {0: added}).modes().frequencies
    assert np.all(held > free * (1.0 - 1e-12))
    assert held[0] > 0.0


@pytest.mark.parametrize(
    ("inertia", "stiffness", "ground", "message"),
    [
        ([], [], None, "inertia: given no values"),
        ([1.0, 0.0], [1.0], None, r"inertia\[1\]: given 0 .*more than zero"),
        ([1.0, -2.0], [1.0], None, r"inertia\[1\]: given -2"),
        ([1.0, float("nan")], [1.0], None, r"inertia\[1\]: given nan"),
        ([1.0, 1.0], [0.0], None, r"stiffness\[0\]: given 0 .*more than zero"),
        ([1.0, 1.0], [-3.0], None, r"stiffness\[0\]: given -3"),
        ([1.0, 1.0], [float("inf")], None, r"stiffness\[0\]: given inf"),
        ([1.0, 1.0], [1.0, 1.0], None, "stiffness: given 2 values for 2 inertias; .*exactly 1"),
        ([1.0, 1.0], [1.0], [1.0], "ground: given 1 values; allowed are exactly 2"),
        ([1.0, 1.0], [1.0], [1.0, -1.0], r"ground\[1\]: given -1"),
        ([1.0, 1.0], [1.0], {1: -1.0}, r"ground\[1\]: given -1"),
        (
            [1.0, 1.0],
            [1.0],
            {2: 1.0},
            r"ground\[2\]: given 2; allowed are the whole numbers 0 to 1",
        ),
        ([1.0, 1.0], [1.0], {-1: 1.0}, r"ground\[-1\]: given -1; allowed are the whole numbers"),
        ([1.0, 1.0], [1.0], {"a": 1.0}, "ground.*given 'a'; allowed are the whole numbers"),
        ([1.0, 1.0], [1.0], {0: float("nan")}, r"ground\[0\]: given nan"),
        ([1.0, 1.0], [1.0], {0: "5"}, r"ground\[0\]: given '5'"),
    ],
)
def test_unusable_chains_are_refused(inertia, stiffness, ground, message):
    with pytest.raises(InputError, match=message) as raised:
        Chain(inertia, stiffness, ground)
    assert "\n" not in str(raised.value)


def test_chain_keeps_its_own_values():
    inertia = np.array([1.0, 2.0])
    chain = Chain(inertia, [3.0])
    inertia[0] = 9.0
    assert chain.inertia.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        chain.inertia[0] = 9.0
