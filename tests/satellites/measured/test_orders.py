"""Orders of toothed wheels against the integrated motion that made the pulses."""

import itertools
from functools import cache

import numpy as np
import pytest

from comparing import close
from crankfem.satellites.measured.measurement import Measurement, load, refuse_other_speeds
from crankfem.satellites.measured.order_fits import Samples, unbroken_windows
from crankfem.satellites.measured.wheel import Wheel, number_teeth
from crankfem.satellites.measured.wheel_constants import (
    constants_by_reference,
    edge_disagreement,
    without_wheel,
)
from refusals import refused
from toothed_wheels import ORDERS, RPM, pulses, real_wheel, turned_up

# Of a run-up's seconds: largest error of orders above a twentieth of the largest, by the largest amplitude,
# and each by its own peak; in 100 s by the wheel.
ALLOWED = {10.0: 0.05, 30.0: 0.003, 100.0: 1e-4}
OF_ITS_OWN = {10.0: 0.05, 30.0: 0.003, ("60-2", 100.0): 1.5e-4, ("36-1", 100.0): 3e-4}
turned = cache(turned_up)


def as_in_half_a_minute():
    """A part of the run-up in 30 s, as quick."""
    return turned(8.0, high=900.0)


def measured(teeth, times, **more):
    defaults = {
        "signal": None,
        "quantity": "angle",
        "place": "damper",
        "cycle": 2,
        "mark_angle": 0.0,
        "notes": (),
    }
    return Measurement(number_teeth(times, Wheel.read(teeth)), **(defaults | more))


def true_orders(turning, numbers, pitches, found):
    """True phasors, with the angle zero at the first mark."""
    begun = 2.0 * np.pi * (numbers[0] // pitches)
    return turning.at(found.speed, found.orders) * np.exp(1j * found.orders * begun)


def errors(teeth, turning, off=None, noise=0.0, **how):
    wheel = Wheel.read(teeth)
    times, numbers = pulses(turning, wheel.pitches, wheel.missing, off)
    times = times + noise * np.random.default_rng(3).standard_normal(times.size)
    found = measured(teeth, times).orders(**how)
    true = true_orders(turning, numbers, wheel.pitches, found)
    return found, true, found.amplitude - true


def of_its_own(true, error):
    """Largest error of each order above a twentieth of the largest, and which these are."""
    peaks = np.abs(true).max(axis=0)
    large = peaks > 0.05 * peaks.max()
    return np.abs(error).max(axis=0)[large] / peaks[large], large


@pytest.mark.slow
@pytest.mark.parametrize(
    ("teeth", "duration"),
    [
        ("36-1", 10.0),
        *(
            pytest.param(teeth, duration, marks=pytest.mark.further)
            for teeth, duration in (
                ("60-2", 10.0),
                *itertools.product(("60-2", "36-1"), (30.0, 100.0)),
            )
        ),
    ],
)
def test_orders_of_a_run_up_are_those_integrated(teeth, duration):
    found, true, error = errors(teeth, turned(duration))
    own, large = of_its_own(true, error)
    assert np.count_nonzero(large) > 15
    assert np.abs(error[:, large]).max() < ALLOWED[duration] * np.abs(true).max()
    assert own.max() < OF_ITS_OWN.get(duration, OF_ITS_OWN.get((teeth, duration)))
    assert np.all(found.wheel_constant == (ORDERS % 1.0 == 0.0))
    assert found.ramp == close(1500.0 * RPM / duration, rel=1e-3)


@pytest.mark.further
def test_orders_that_are_not_there_are_not_found():
    present = ORDERS[ORDERS % 1.5 == 0.0]
    turning = turned_up(100.0, orders=present)
    times, _ = pulses(turning, 60, 2)
    found = measured("60-2", times).orders()
    absent = ~np.isin(found.orders, present)
    peaks = np.abs(found.amplitude).max(axis=0)
    assert peaks[absent].max() < 1e-3 * peaks.max()


@pytest.mark.slow
def test_a_real_wheel_moves_whole_orders_by_constants_alone():
    off = real_wheel(60, 2)
    found, true, error = errors("60-2", as_in_half_a_minute(), off)
    half = ~found.wheel_constant
    peaks = np.abs(true).max(axis=0)
    assert np.all(np.abs(error[:, half]) <= np.maximum(0.01 * peaks[half], np.radians(0.001)))
    # Far from true as they are: order 1 holds the eccentricity.
    whole = found.wheel_constant
    assert np.abs(error[:, np.cumsum(found.orders == 1.0) > 0]).max() > 0.1 * peaks.max()
    assert any("constant of the wheel" in note for note in found.notes)
    # A second sensor, at other speeds, tells the constants.
    reference = measured("36-1", pulses(as_in_half_a_minute(), 36, 1)[0]).orders()
    reference = without_wheel(reference, np.zeros(ORDERS.size))
    constants, scatter = constants_by_reference(found, reference)
    cleared = without_wheel(found, constants)
    _, large = of_its_own(true, error)
    left = np.abs(cleared.amplitude - true).max(axis=0) / peaks
    assert left[whole & large].max() < 0.02
    assert not cleared.wheel_constant.any()
    assert np.all(scatter > 0.0)


@pytest.mark.slow
def test_scatter_is_that_of_the_noise():
    ratios = []
    for method in ("along", "linear"):
        found, _, error = errors("60-2", as_in_half_a_minute(), noise=2e-6, method=method)
        ratios.append(np.sqrt(np.mean((error.real / found.scatter) ** 2)))
    assert ratios[0] == close(1.0, abs=0.35)
    # Amplitudes that are not linear in a window err besides.
    assert ratios[1] > 0.6


def steady_record(speeds, teeth="60-2", turns=60, noise=0.0, off=None):
    """Pulses at steady speeds [1/min], with orders 0.5 and 3 of known amplitudes."""
    wheel = Wheel.read(teeth)
    amplitudes = {0.5: 2e-3 * np.exp(0.4j), 3.0: 1e-3 * np.exp(-1.1j)}
    clock, times = 0.0, []
    last = None
    for speed in speeds:
        if last is not None:
            middle = np.sqrt(speed * last) * RPM
            angle = np.arange(3 * wheel.pitches) * 2.0 * np.pi / wheel.pitches
            times.append(clock + angle[: 3 * wheel.pitches] / middle)
            clock += 6.0 * np.pi / middle
        rigid = np.linspace(0.0, 2.0 * np.pi * turns, 200_000)
        motion = sum((x * np.exp(1j * k * rigid)).real for k, x in amplitudes.items())
        numbers = np.arange(1, wheel.pitches * turns)
        wanted = 2.0 * np.pi / wheel.pitches * numbers
        wanted = wanted + (0.0 if off is None else off[numbers % wheel.pitches])
        times.append(clock + np.interp(wanted, rigid + motion, rigid) / (speed * RPM))
        clock += 2.0 * np.pi * turns / (speed * RPM)
        last = speed
    whole = np.concatenate(times)
    return whole, amplitudes


@pytest.mark.parametrize("speed", [800.0])
def test_a_steady_speed_gives_one_row(speed):
    times, amplitudes = steady_record([speed], teeth="120")
    times = times + 1e-7 * np.random.default_rng(1).standard_normal(times.size)
    found = measured("120", times).orders([0.5, 3.0])
    assert found.speed == close([speed * RPM], rel=1e-4)
    assert "steady" in found.method
    # The angle begins at the first pulse, a pitch behind that of the motion.
    shift = np.exp(1j * found.orders * 2.0 * np.pi / 120)
    assert found.amplitude[0] == close(list(amplitudes.values()) * shift, abs=5e-6)
    assert np.all((found.scatter > 0.0) & (found.scatter < 5e-6))


def test_edges_that_disagree_show_the_wheel():
    off = real_wheel(60, 0, seed=8)
    first, second = (
        measured("60", steady_record([700.0], teeth="60", off=each)[0]).orders([0.5, 3.0, 4.0])
        for each in (off, np.zeros(60))
    )
    apart = edge_disagreement(first, second)
    assert apart[0] < 1e-5 < 2e-4 < max(apart[1:])


def test_orders_that_the_wheel_cannot_show_are_refused():
    times, _ = steady_record([900.0], teeth="24")
    with refused("orders"):
        measured("24", times).orders([13.0])
    with refused("window"):
        measured("24", times).orders([1.0], method="steady", window=2.0)


def test_windows_with_a_pause_are_left_out():
    times, amplitudes = steady_record([900.0], teeth="60", turns=100)
    times = times[np.arange(1, times.size + 1) % 60 < 58]
    found = measured("60-2", np.delete(times, np.s_[2000 : 2000 + 12 * 58])).orders([0.5, 3.0])
    assert found.amplitude[0] == close(list(amplitudes.values()), rel=1e-4)
    angle = np.delete(np.linspace(0.0, 40.0 * np.pi, 1201), np.s_[500:700])
    with refused("record") as caught:
        unbroken_windows(Samples(angle / 80.0, angle, angle), [0.0, 20.0], 24.0 * np.pi)
    assert "12 revolutions without a pause" in str(caught.value)


def test_a_record_of_another_engine_is_refused():
    record = measured("120", steady_record([800.0], teeth="120")[0])
    refuse_other_speeds(record, 500.0 * RPM, 1000.0 * RPM)
    with refused("record"):
        refuse_other_speeds(record, 3000.0 * RPM, 4000.0 * RPM)


def test_a_run_up_counted_with_half_the_teeth_is_refused():
    record = measured("60", steady_record([600.0, 1000.0, 1500.0], teeth="120")[0])
    with refused("record"):
        refuse_other_speeds(record, 600.0 * RPM, 1500.0 * RPM)


def test_a_rate_for_times_of_pulses_is_refused(tmp_path):
    file = tmp_path / "run.csv"
    np.savetxt(file, steady_record([800.0], teeth="120")[0], header="pulse_time_s", comments="")
    with refused("rate"):
        load(file, teeth="120", rate=1000.0)


def test_a_file_of_pulses_gives_orders(tmp_path):
    times, amplitudes = steady_record([800.0], teeth="120")
    file = tmp_path / "run.csv"
    file.write_text("pulse_time_s\n" + "\n".join(f"{one:.9f}" for one in times) + "\n")
    found = load(file, teeth="120", place="flywheel", mark_angle_deg=3.0).orders([0.5, 3.0])
    assert found.amplitude[0] == close(list(amplitudes.values()), abs=1e-5)
    assert found.zero_known
    with refused("wheel"):
        load(_two_columns(tmp_path), teeth="120")


def _two_columns(folder):
    file = folder / "two.csv"
    file.write_text("first_V,second_V\n0,1\n1,0\n0,1\n")
    return file


@pytest.mark.slow
def test_a_torque_beside_the_wheel_has_its_orders():
    turning = as_in_half_a_minute()
    times, numbers = pulses(turning, 60, 2)
    some = turning.time > times[0]
    torque = {2.5: 400.0 * np.exp(0.7j), 6.0: 900.0 * np.exp(-2.0j)}
    waves = [(x * np.exp(1j * k * turning.angle[some])).real for k, x in torque.items()]
    beside = (turning.time[some], 1e4 + sum(waves))
    found = measured("60-2", times, signal=beside, quantity="torque").orders([1.0, 2.5, 6.0])
    shift = np.exp(2j * np.pi * (numbers[0] // 60) * found.orders)
    assert np.abs(found.amplitude - np.array([0.0, *torque.values()]) * shift).max() < 1.0
    assert not found.wheel_constant.any()
