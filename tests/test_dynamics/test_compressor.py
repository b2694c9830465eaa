"""The cycle of a compressor with ideal valves: work, volumes, limits."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.gas.compressor import CompressorCycle
from dynamics.gas.pressure import indicated_work, periodic_slope

AREA, CRANK, ROD = 0.05, 0.1, 0.45
SWEPT = 2.0 * CRANK * AREA


def position(angle):
    return CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)


def work_of(cycle):
    pressure = cycle.pressure(position, AREA)
    slope = periodic_slope(position(np.radians(pressure.angles_deg)), 2.0 * math.pi)
    return indicated_work(pressure.pressure, -AREA * slope, 2)


@given(st.floats(0.5e5, 50e5), st.floats(1.2, 6.0), st.floats(0.01, 0.3), st.floats(1.0, 1.5))
def test_work_is_that_of_the_closed_form(suction, ratio, clearance, n):
    taken_in = SWEPT * (1.0 + clearance - clearance * ratio ** (1.0 / n))
    assume(taken_in > 0.2 * SWEPT)
    cycle = CompressorCycle(suction, ratio * suction, clearance, n)
    lost = (
        math.log(ratio) if n == 1.0 else n / (n - 1.0) * math.expm1((n - 1.0) / n * math.log(ratio))
    )
    # The kinks at the valves fall between samples a quarter degree apart.
    assert work_of(cycle) == close(-suction * taken_in * lost, 1e-4)
    assert cycle.volumetric_efficiency == close(taken_in / SWEPT, 1e-12)


def test_pressure_has_both_lines_and_both_polytropes():
    cycle = CompressorCycle(1e5, 4e5, 0.06, 1.35)
    pressure = cycle.pressure(position, AREA)
    clearance = 0.06 * SWEPT

    def volume(degrees):
        return clearance + AREA * (CRANK + ROD - position(np.radians(degrees)))

    assert pressure.peak_pressure == 4e5
    assert pressure.lowest == 1e5
    assert pressure.at(angle_deg=90.0) == close(1e5, 1e-12)
    assert pressure.at(angle_deg=350.0) == close(4e5, 1e-12)
    assert pressure.at(angle_deg=15.0) == close(4e5 * (clearance / volume(15.0)) ** 1.35, 1e-9)
    assert pressure.at(angle_deg=240.0) == close(
        1e5 * ((clearance + SWEPT) / volume(240.0)) ** 1.35, 1e-9
    )


@pytest.mark.parametrize(
    "values",
    [(1e5, 1e5, 0.06, 1.35), (4e5, 1e5, 0.06, 1.35), (1e5, 60e5, 0.1, 1.3), (1e5, 4e5, 0.0, 1.3)],
)
def test_a_machine_that_does_not_deliver_is_refused(values):
    with pytest.raises(InputError):
        CompressorCycle(*values)
