"""Kinds of damping: what each does at resonance, and what the record says."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import EngineMagnifier, damped
from dynamics.response.order_excitation import OrderExcitation

ONE = Chain([1.0], [], ground=[1e4])  # 100 rad/s
TWO = Chain([1.0, 1.0], [2e4])  # 200 rad/s


def magnification(chain, speed):
    """Amplitude at resonance over the static one of the elastic mode."""
    count = chain.chain.inertia.size
    forces = np.array([1.0, -1.0])[:count] * np.ones((1, 1, 1))
    found = forced_response(chain, OrderExcitation([1.0], [speed], forces))
    static = 1.0 / speed**2
    return found.amplitude[0, 0, 0] / static


@pytest.mark.parametrize(
    ("chain", "speed", "choice"),
    [
        (TWO, 200.0, {}),
        (ONE, 100.0, {}),
        (TWO, 200.0, {"magnifier": 40.0}),
        (TWO, 200.0, {"modal_damping": 1.0 / 80.0}),
        (TWO, 200.0, {"modal_damping": [1.0 / 80.0]}),
        (TWO, 200.0, {"loss_factor": 1.0 / 40.0}),
        (TWO, 200.0, {"element_magnifier": {0: 40.0}}),
        (TWO, 200.0, {"relative": 2e4 / (200.0 * 40.0)}),
        (TWO, 200.0, {"absolute": {0: 5.0, 1: 5.0}}),  # I w / M = 200 / 40
        (TWO, 200.0, {"engine_magnifier": EngineMagnifier(40.0, (0, 1), 100.0 / np.pi)}),
        (TWO, 200.0, {"loss_factor": 1.0 / 80.0, "magnifier": 80.0}),  # losses add up
    ],
)
def test_each_kind_gives_a_magnifier_of_40(chain, speed, choice):
    found = damped(chain, source="a test bed", **choice)
    assert magnification(found, speed) == close(40.0, rel=1e-11)
    np.testing.assert_allclose(found.system.damping_ratios(), 1.0 / 80.0, rtol=1e-11)
    assert len(found.record) == max(1, len(choice))
    said = found.record[0]
    assert said.endswith(": a test bed") if choice else "1997/01151" in said
    if not choice:
        assert said.startswith("magnifier 40 of every elastic mode, because none is given")


def test_own_damping_is_told_value_by_value_with_its_places():
    chain = Chain(
        [1.0] * 5,
        [2e4] * 3,
        connections=[(0, 1), (1, 2), (2, 3)],
        dashpots=[Dashpot(0, 4, 7.0)],
        loss_factor=[0.02, 0.02, 0.3],
        ground_damping=[0.0, 5.0, 5.0, 5.0, 0.0],
        names=["end", "a", "b", "machine", "ring"],
    )
    (said,) = damped(chain).record
    assert "loss factor 0.02 of end - a, a - b; loss factor 0.3 of b - machine;" in said
    assert said.count("7 N m s/rad") == 1
    assert "between end - ring" in said
    assert said.endswith("to ground at 3 nodes")


def test_own_damping_stays_and_needs_no_default():
    own = Chain([1.0, 1.0], [2e4], loss_factor=0.01, damping=0.5)
    found = damped(own)
    (said,) = found.record
    assert said.startswith(
        "damping of the chain itself: loss factor 0.01 of node 0 - node 1; 0.5 N m"
    )
    np.testing.assert_array_equal(found.system.damping, damped(own).chain.damping_matrix())
    for kind, choice in {
        "relative": {"relative": [1.0]},
        "loss_factor": {"loss_factor": [0.02]},
        "element_magnifier": {"element_magnifier": {0: 40.0}},
    }.items():
        with pytest.raises(InputError, match=f"^{kind}: given damping of node 0 - node 1, which"):
            damped(own, **choice)
    more = damped(own, relative=[1.0], loss_factor=[0.02], add=True)
    assert more.chain.damping[0] == 1.5
    assert more.chain.loss_factor[0] == close(0.03)
    assert len(more.record) == 3


def test_a_node_is_damped_once():
    own = Chain([1.0, 1.0], [2e4], ground_damping={0: 5.0})
    with pytest.raises(
        InputError, match=r"^absolute: given damping of node 0, .* \(5\); .*add=True"
    ):
        damped(own, absolute={0: 5.0})
    with pytest.raises(InputError, match=r"^engine_magnifier: given damping of node 1, which"):
        damped(own, absolute={1: 2.0}, engine_magnifier=EngineMagnifier(40.0, (1,), 20.0))
    assert damped(own, absolute={0: 5.0}, add=True).chain.ground_damping[0] == 10.0
    assert damped(own, magnifier=40.0, loss_factor=0.01).chain.loss_factor[0] == 0.01


def test_undamped_on_purpose():
    found = damped(TWO, undamped=True)
    assert found.record == ("no damping, on purpose",)
    assert magnification(found, 200.0) == np.inf
    assert np.all(found.system.damping_ratios() == 0.0)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"magnifier": 40.0, "modal_damping": 0.01}, "magnifier: given 40.0 together with modal"),
        ({"undamped": True, "relative": 1.0}, "undamped: given True together with relative"),
        ({"magnifier": 0.0}, "magnifier: given 0"),
        ({"modal_damping": [0.1, 0.1]}, "modal_damping: given 2 values"),
        ({"loss_factor": -0.1}, "loss_factor.0.: given -0.1"),
        ({"relative": [1.0, 1.0]}, "relative: given 2 values for 1 elements"),
        ({"relative": {1: 1.0}}, r"relative\[1\]: given 1; allowed is 0, because"),
        ({"element_magnifier": 0.0}, "element_magnifier.0.: given 0"),
        ({"absolute": {2: 1.0}}, "absolute"),
    ],
)
def test_refused(choice, words):
    with pytest.raises(InputError, match=words):
        damped(TWO, **choice)
    with pytest.raises(InputError, match="frequency: given 0 Hz"):
        EngineMagnifier(40.0, (0,), 0.0)
