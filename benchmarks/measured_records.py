"""Pulse times of a long voltage record of a toothed wheel, beside reading it alone.

Run by hand (a minute on one core): ``python benchmarks/measured_records.py [SAMPLES]``. The record, 60-2
teeth at 100,000 samples/s, is made in a temporary folder. Both are processor time of this process, in
one run.
"""

import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from crankfem.satellites.measured.pulses import pulse_times
from crankfem.satellites.measured.records.reading import read_record

RATE, TURNS, BLOCK, PIECE = 1e5, 25.0, 5_000_000, 2**21


def write_voltage(path: Path, samples: int) -> None:
    """Write a 60-2 wheel's voltage with noise of 1 % [mV]."""
    rng = np.random.default_rng(0)
    with h5py.File(path, "w") as file:
        wheel = file.create_dataset("wheel", (samples,), "i2", chunks=(1_000_000,))
        wheel.attrs.update({"unit": "mV", "fs": RATE})
        for first in range(0, samples, BLOCK):
            count = min(BLOCK, samples - first)
            turned = np.mod(TURNS * (first + np.arange(count)) / RATE, 1.0)
            teeth = np.where(turned < 58.0 / 60.0, 2e3 * np.sin(120.0 * np.pi * turned), 0.0)
            wheel[first : first + count] = (teeth + rng.normal(0.0, 20.0, count)).astype("i2")


def main(samples: int) -> None:
    """Print both times and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.h5"
        write_voltage(path, samples)
        channel = read_record(path).channel("wheel")
        begin = time.process_time()
        read = sum(piece.size for piece in channel.column.read(PIECE))
        reading = time.process_time() - begin
        begin = time.process_time()
        pulses = pulse_times(channel.column.read(PIECE), channel.rate)
        both = time.process_time() - begin
    print(
        f"{read:,} samples read in {reading:.1f} s; with {pulses.size:,} pulse times {both:.1f} s, "
        f"{both / reading:.1f} times as long"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000_000)
