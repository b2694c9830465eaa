"""Propeller forces: orders and phases through gears, by synthesis over the propeller's angle."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Gear
from dynamics.excitation.propeller import PropellerForces, propeller_excitation

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
    for changed, sentence in (
        ({"node": 4}, "propeller node: given 4"),
        ({"kind": "bending"}, "kind: given 'bending'"),
        ({"ratio": 0.0}, "ratio: given 0; allowed is a finite number"),
        ({"speeds": [2.0, 1.0]}, r"speeds\[1\]: given 1 rad/s after 2"),
    ):
        given = {"node": 3, "speeds": SPEEDS, "kind": "torsional"} | changed
        with pytest.raises(InputError, match=sentence):
            propeller_excitation(FORCES, chain, **given)
    steady = PropellerForces(4, 20.0, 3e5, 2e5, [], [0.1])
    with pytest.raises(InputError, match="given no harmonics of its thrust"):
        propeller_excitation(steady, chain, 3, SPEEDS, kind="axial")
    with pytest.raises(InputError, match=r"propeller_forces.thrust_phases: given 1 for 2 shares"):
        PropellerForces(4, 20.0, 3e5, 2e5, [0.1, 0.02], [], thrust_phases_deg=[0.1])
    with pytest.raises(InputError, match=r"propeller_forces.blades: given 1"):
        PropellerForces(1, 20.0, 3e5, 2e5, [0.1], [])
