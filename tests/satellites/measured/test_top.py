"""The firing top of a record over the crank angle, said and checked by the peak of the pressure."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.satellites.measured.records.record import Channel, Column
from crankfem.satellites.measured.records.top import cylinder_pressure, firing_top


def pressure(
    peak, reference="", *, start=-360.0, cycles=3, unit="bar", axis="angle", strokes=4, noise=200.0
):
    angles = start + np.arange(cycles * strokes * 180.0)
    # One cycle has noise that is higher than the pressure.
    values = 1.0 + 80.0 * np.exp(
        -((np.mod(angles - peak + 180.0, strokes * 180.0) - 180.0) ** 2) / 400.0
    )
    values[5] += noise
    return Channel(
        "p",
        "",
        unit,
        Column.of(values),
        axis,
        "deg",
        *np.radians([start, 1.0]),
        reference=reference,
    )


@pytest.mark.parametrize("start", [-360.0, 0.0, 100.0])
def test_the_top_is_told_by_the_peak(start):
    assert firing_top(pressure(12.0, start=start)) == 0.0
    assert firing_top(pressure(372.0, start=start)) == 2.0 * math.pi
    assert firing_top(pressure(358.0, start=start), "gas exchange") == 2.0 * math.pi


def test_what_is_said_is_checked():
    with pytest.raises(
        InputError, match=r"is at 372 deg, with the firing top at zero; allowed are -10 deg"
    ):
        firing_top(pressure(372.0), "firing")
    with pytest.raises(InputError, match=r"is at 12 deg, with the gas exchange top at zero"):
        firing_top(pressure(12.0), "gas exchange")
    with pytest.raises(
        InputError, match=r"is at 252 deg, with a top of this cylinder at zero.*another"
    ):
        firing_top(pressure(252.0))
    with pytest.raises(InputError, match=r"zero: given 'middle'; allowed are firing, gas exchange"):
        firing_top(pressure(12.0), "middle")


def test_a_two_stroke_engine_has_one_top():
    assert firing_top(pressure(12.0, strokes=2), strokes=2) == 0.0
    with pytest.raises(InputError, match="allowed are firing, because"):
        firing_top(pressure(12.0, strokes=2), "gas exchange", strokes=2)


@pytest.mark.parametrize(
    ("channel", "told"),
    [
        (pressure(12.0, unit="Nm"), "p: is in N m over angle"),
        (
            pressure(12.0, axis="time"),
            "p: is in Pa over time; allowed is a pressure over the crank angle",
        ),
        (pressure(12.0, cycles=0.5), "recorded over 359 deg; allowed is a whole cycle of 720 deg"),
    ],
)
def test_what_has_no_such_peak_is_refused(channel, told):
    with pytest.raises(InputError, match=told):
        firing_top(channel)


@pytest.mark.parametrize(("reference", "added"), [("absolute", 0.0), ("gauge", 101325.0)])
def test_a_recorded_pressure_is_that_of_an_engine_file(reference, added):
    recorded = pressure(372.0, reference, start=0.0, cycles=2, noise=0.0)
    taken = cylinder_pressure(recorded)
    assert (taken.strokes, taken.peak_angle_deg) == (4, 12.0)
    assert taken.peak_pressure == close(81e5 + added)
    assert "The mean of 2 cycles is used." in taken.remarks[-1]


def test_whether_it_is_absolute_must_be_known():
    with pytest.raises(InputError, match=r'p: given in bar; .* like units = \{ p = "bar\(a\)" \}'):
        cylinder_pressure(pressure(12.0))
