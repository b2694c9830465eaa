"""Angles given in degrees: radians are refused where they can be told, and degrees never."""

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.checks.angles import checked_degrees, radians_of, refuse_crank_radians
from crankbase.errors import InputError

TURN = 2.0 * np.pi


@pytest.mark.parametrize(
    "cranks",
    [
        [0.0, 2.09, 4.19],
        [0, 3.14159, 3.14159, 0],
        [0, 2.094, 4.189, 4.189, 2.094, 0],
        [0.0, 1.57, 4.71, 3.14],
        [0.0, -2.09, 2.09],
        np.radians([0, 180]),
        np.radians([0, 72, 144, 216, 288]),
        np.radians([0, 240, 480, 120, 360, 600]),
        np.radians([0, 30, 120, 150, 240, 270]),
    ],
)
def test_cranks_in_radians_are_refused(cranks):
    with pytest.raises(InputError, match=r"^crank_angles_deg: .* radians; allowed are degrees"):
        refuse_crank_radians("crank_angles_deg", cranks)


@pytest.mark.parametrize(
    "cranks",
    [
        [0.0],
        [0, 0, 0, 0],
        [0, 180, 180, 0],
        [0.0, 120.0, 240.0],
        [0.0, 10.0],  # a split pin
        [0.0, 12.5, 0.0, 12.5],
        [1.0, 2.0, 3.0],
        [0.0, 0.3, 0.5],
        [0, 51.43, 102.86, 154.29, 205.71, 257.14, 308.57],
    ],
)
def test_cranks_in_degrees_are_not_taken_for_radians(cranks):
    refuse_crank_radians("crank_angles_deg", cranks)


def test_layouts_in_radians_are_refused():
    rod = cf.ConnectingRod(0.265, 5.0, 0.097, 0.069)
    cylinders = [
        cf.EngineCylinder(0.13, 3.0, rod, crank_angle_deg=angle, position=0.1 * place)
        for place, angle in enumerate((0.0, 2.09, 4.19))
    ]
    with pytest.raises(InputError, match=r"^crank_angle_deg: given 3 angles from 0 to 4\.19, "):
        cf.EngineLayout(0.07, cylinders, [1, 3, 2])


@pytest.mark.parametrize("length", [TURN, 2.0 * TURN])
@pytest.mark.parametrize("count", [8, 361, 720])
@pytest.mark.parametrize("closed", [False, True])
def test_even_radians_over_a_turn_are_refused(length, count, closed):
    for begin in (0.0, -0.5 * length):
        angles = begin + np.linspace(0.0, length, count, endpoint=closed)
        with pytest.raises(InputError, match=r"^angles_deg: .* radians; allowed are degrees"):
            checked_degrees("angles_deg", angles)


@pytest.mark.parametrize(
    "angles",
    [
        np.arange(0.0, 720.0, 1.0),
        np.linspace(0.0, 12.5, 26),
        np.linspace(0.0, 12.6, 127),
        np.linspace(-6.0, 6.0, 121),
        np.arange(0.0, 6.3, 0.1),
        np.zeros(9),
        [0.0, TURN],
        [],
    ],
)
def test_degrees_are_not_taken_for_radians(angles):
    assert radians_of("angles_deg", angles) == close(np.radians(angles), abs=1e-15)
