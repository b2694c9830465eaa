"""Pulses of toothed wheels from voltage, and the tooth of each pulse, against wheels that are known."""

import numpy as np
import pytest

from crankfem.satellites.measured.pulses import PIECE, pulse_times
from crankfem.satellites.measured.wheel import Wheel, number_teeth
from refusals import refused

RATE = 50_000.0


def times_of(numbers, pitches, off=None):
    """Times of teeth while the shaft slows down and speeds up a little."""
    angle = 2.0 * np.pi / pitches * numbers + (0.0 if off is None else off[numbers % pitches])
    return angle / 80.0 + 2e-4 * np.sin(angle / 7.0) * angle / angle[-1]


def real(pitches, missing, turns=60):
    numbers = np.arange(5, turns * pitches)
    numbers = numbers[numbers % pitches < pitches - missing]
    off = np.random.default_rng(2).normal(0.0, 0.01, pitches) * 2.0 * np.pi / pitches
    off[0] += 0.2 * 2.0 * np.pi / pitches
    off[pitches - missing - 1] -= 0.2 * 2.0 * np.pi / pitches
    return numbers, times_of(numbers, pitches, off)


@pytest.mark.parametrize(("pitches", "missing"), [(60, 2), (36, 1)])
def test_lost_and_doubled_teeth_are_mended_and_counted(pitches, missing):
    numbers, times = real(pitches, missing)
    rng = np.random.default_rng(3)
    kept = rng.random(times.size) > 0.01
    kept[[0, -1]] = True
    bounced = times[kept][40::101]
    given = np.sort(np.concatenate((times[kept], bounced + 5e-5)))
    found = number_teeth(given, Wheel(pitches, missing))
    assert found.doubled == bounced.size
    true = dict(zip(times.tolist(), numbers.tolist(), strict=True))
    known = np.isin(found.time, times)
    apart = {
        true[t] - n
        for t, n in zip(found.time[known].tolist(), found.number[known].tolist(), strict=True)
    }
    assert apart == {0}
    assert len(found.notes) >= 2
    assert found.lost + found.unsure >= np.count_nonzero(~kept)


def test_a_long_dropout_is_bridged_by_the_marks():
    numbers, times = real(60, 2)
    given, left = (np.delete(each, np.s_[800:895]) for each in (times, numbers))
    found = number_teeth(given, Wheel(60, 2))
    true = dict(zip(given.tolist(), left.tolist(), strict=True))
    assert {
        true[t] - n for t, n in zip(found.time.tolist(), found.number.tolist(), strict=True)
    } == {0}


def test_a_gap_that_vibration_widens_by_a_pitch_is_the_gap():
    """Order 6 about its peak, with teeth displaced beside the gap: it is almost 4 pitches wide."""
    numbers = np.arange(5, 300 * 60)
    numbers = numbers[numbers % 60 < 58]
    off = np.zeros(60)
    off[0], off[57] = 0.15, -0.15
    angle = 2.0 * np.pi / 60.0 * (numbers + off[numbers % 60])
    large = 0.035 * np.exp(-(((angle / angle[-1] - 0.5) / 0.2) ** 2))
    times = (angle - large * np.cos(6.0 * angle - 3.77)) / 270.0
    lost = np.arange(500, times.size, 1234)
    gaps = np.diff(times)[numbers[:-1] % 60 == 57] / np.median(np.diff(times))
    assert gaps.max() > 3.8
    found = number_teeth(np.delete(times, lost), Wheel(60, 2))
    assert np.array_equal(found.number, np.delete(numbers, lost))
    assert (found.lost, found.unsure) == (lost.size, 0)


def test_a_double_tooth_marks_the_revolution():
    numbers = np.arange(5, 60 * 60)
    times = times_of(numbers, 60)
    last = numbers[:-1] % 60 == 59
    middle = 0.5 * (times[:-1] + times[1:])[last]
    found = number_teeth(np.sort(np.concatenate((times, middle))), Wheel.read("60+1"))
    assert np.array_equal(found.number, numbers)
    assert np.array_equal(found.time, times)


def test_another_wheel_is_named():
    _, times = real(60, 2)
    with refused("teeth") as caught:
        number_teeth(times, Wheel(36, 1))
    assert "60-2" in str(caught.value)
    with refused("teeth") as caught:
        number_teeth(times, Wheel(120))
    assert "60-2" in str(caught.value)
    numbers = np.arange(3000)
    with refused("teeth") as caught:
        number_teeth(times_of(numbers + 1, 60), Wheel(60, 2))
    assert "without a mark" in str(caught.value)


@pytest.mark.parametrize("text", ["60-40", "0", "60+2", "sixty", "60--2"])
def test_wrong_teeth_are_refused(text):
    with refused("teeth"):
        Wheel.read(text)


def test_times_that_do_not_ascend_are_refused():
    with refused("pulse_time_s[2]"):
        number_teeth([0.0, 0.1, 0.1, 0.2], Wheel(1))


def voltage(count, heights, noise):
    """Samples of a magnetic wheel 60-2 whose speed and height rise, and its rising edges [s]."""
    time = np.arange(count) / RATE
    turned = 60.0 * time + 2.0 * time**2
    pitch = turned / (2.0 * np.pi) * 60
    tooth = pitch.astype(int) % 60
    wave = np.sin(2.0 * np.pi * pitch) * heights[tooth] * (tooth < 58) * (1.0 + time / 20.0)
    numbers = np.arange(1, int(pitch[-1]) + 1)
    numbers = numbers[numbers % 60 < 58]
    edges = (-60.0 + np.sqrt(3600.0 + 8.0 * 2.0 * np.pi / 60 * numbers)) / 4.0
    return wave + noise * np.random.default_rng(4).standard_normal(count), edges, numbers


@pytest.mark.slow
def test_pulses_follow_ordinary_teeth_past_magnetic_ones():
    heights = np.random.default_rng(0).uniform(0.7, 1.3, 60)
    heights[20], heights[40] = 2.5, 0.55
    samples, edges, numbers = voltage(PIECE + 300_000, heights, 0.02)
    found = pulse_times(samples, RATE)
    assert found.size == edges.size
    # Noise of 2 % of a tooth of 0.55, which rises by 0.035 in a sample, moves a crossing by some samples.
    assert np.abs(found - edges).max() < 4.0 / RATE
    assert np.median(np.abs(found - edges)) < 0.5 / RATE
    counted = number_teeth(found, Wheel(60, 2))
    assert np.array_equal(counted.number, numbers)
    in_parts = pulse_times(np.array_split(samples, 7), RATE)
    assert np.abs(in_parts - edges).max() < 4.0 / RATE


def test_both_edges_are_half_a_pitch_apart():
    samples, edges, _ = voltage(200_000, np.ones(60), 0.0)
    falling = pulse_times(samples, RATE, edge="falling")
    rising = pulse_times(samples, RATE)
    # Behind a gap there is no crossing: a tooth begins there as its neighbors do.
    assert np.abs(rising - edges).max() < 1.0 / RATE
    assert np.median(np.abs(rising - edges)) < 0.01 / RATE
    share = (falling[1:51] - rising[:50]) / np.diff(rising)[:50]
    assert np.abs(share - 0.5).max() < 0.02


def test_a_flat_voltage_has_no_teeth():
    with refused("voltage"):
        pulse_times(np.zeros(1000), RATE)


def test_a_wheel_is_not_said_to_be_like_itself():
    _, times = real(60, 2)
    with refused("teeth") as caught:
        number_teeth(np.delete(times, np.s_[600:1800]), Wheel(60, 2))
    assert "1200 are missing" in str(caught.value)
    assert "like" not in str(caught.value)
