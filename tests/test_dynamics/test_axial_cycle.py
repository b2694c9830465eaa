import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.excitation.axial_forces import axial_force_over_cycle


def test_two_throws_by_hand():
    # Z on pin 1 lengthens throw 1 by 2 and throw 2 by -1; T on pin 2 both by 1 [nm/N].
    influence = 1e-9 * np.array([[[2.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]]])
    forces = np.array([[[1e3, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1e3]]])
    found = axial_force_over_cycle(
        10.0, forces, [1e-9, 3e-9], influence, shaft_angles_deg=[0.0, 57.0]
    )
    assert found.throws == close(np.array([[2000.0, -1000.0 / 3.0], [1000.0, 1000.0 / 3.0]]))
    assert found.held == close([250.0, 500.0])
    assert found.thrust_bearing is None
    assert list(found.columns()) == ["shaft_angle_deg", "held_N", "throw_1_N", "throw_2_N"]
    with pytest.raises(InputError, match=r"pin_forces: given an array of shape \(1, 2, 2\)"):
        axial_force_over_cycle(
            10.0, forces[:1], [1e-9, 3e-9], influence, shaft_angles_deg=[0.0, 57.0]
        )
