"""Long records of a wheel's voltage: in pieces, and in little memory."""

import subprocess
import sys

import numpy as np
import pytest

from comparing import close
from crankfem.satellites.measured.pulses import pulse_times

RATE, TURNS = 1e5, 25.0
MEASURED = """
import re, sys
from crankfem.satellites.measured.pulses import pulse_times
from crankfem.satellites.measured.records.reading import read_record
wheel = read_record(sys.argv[1]).channel("wheel")
pulses = pulse_times(wheel.column.read(2**21), wheel.rate)
# Its own peak: that of `resource` begins with the process that started it.
peak = re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())[1]
print(pulses.size, peak)
"""


def voltage(first, count):
    """A 60-2 wheel with noise of 1 % [mV]."""
    turned = np.mod(TURNS * (first + np.arange(count)) / RATE, 1.0)
    noise = np.random.default_rng(first).normal(0.0, 20.0, count)
    return (
        np.where(turned < 58.0 / 60.0, 2e3 * np.sin(120.0 * np.pi * turned), 0.0) + noise
    ).astype("i2")


@pytest.mark.parametrize("size", [100_000, 200_000, 1_000_000])
def test_pieces_that_end_in_the_gap_of_the_wheel_change_no_pulse(size):
    samples = voltage(0, 1_000_000)
    whole = pulse_times(samples[:-1], RATE)
    pieces = pulse_times((samples[k : k + size] for k in range(0, samples.size, size)), RATE)
    assert pieces.size == whole.size == 250 * 58 - 1
    # Half a sample, a fifth of which is the noise of a crossing.
    assert pieces == close(whole, abs=0.5 / RATE)


@pytest.mark.further
@pytest.mark.skipif(sys.platform != "linux", reason="has no /proc")
def test_a_hundred_million_samples_take_a_gigabyte(tmp_path):
    import h5py

    count, block = 100_000_000, 5_000_000
    with h5py.File(tmp_path / "record.h5", "w") as file:
        wheel = file.create_dataset("wheel", (count,), "i2", chunks=(1_000_000,))
        wheel.attrs.update({"unit": "mV", "fs": RATE})
        for first in range(0, count, block):
            wheel[first : first + block] = voltage(first, block)
    run = subprocess.run(
        [sys.executable, "-c", MEASURED, tmp_path / "record.h5"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    pulses, kilobytes = map(float, run.stdout.split())
    assert pulses in (25_000 * 58 - 1, 25_000 * 58)  # the first is at the first sample
    assert kilobytes < 1e6
