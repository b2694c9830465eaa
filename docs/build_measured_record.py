"""Make the record of docs/measured.md, run.csv: takes half a minute.

A six-cylinder engine's torsional chain, softer than its file says, runs up; a wheel 60-2 on its free end has
pitch errors, an eccentricity, lost and doubled teeth, and noise. Its motion is integrated here, mode by mode.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.signal import lfilter

import crankfem as cf

ENGINE, RATE, PITCHES, RATIO = "cat-3116", 40_000.0, 60, 0.0125
LOW, HIGH, DURATION, SOFTER = 1900.0, 2800.0, 60.0, 0.94  # 1/min, s


def pulses(
    response: cf.ForcedResponse, low: float, high: float, duration: float, softer: float
) -> np.ndarray:
    """Times at which the teeth pass [s], with all that instruments do to them."""
    time = np.arange(0.0, duration, 1.0 / RATE)
    rise = (high - low) * np.pi / 30.0 / duration
    speed = low * np.pi / 30.0 + rise * time
    rigid = low * np.pi / 30.0 * time + 0.5 * rise * time**2
    moved = CubicSpline(time, rigid + motion(response, speed, rigid, softer))
    rng, pitch = np.random.default_rng(1), 2.0 * np.pi / PITCHES
    off = rng.normal(0.0, 0.01, PITCHES) * pitch + 0.002 * np.sin(pitch * np.arange(PITCHES))
    off[[0, PITCHES - 3]] += [0.15 * pitch, -0.15 * pitch]
    teeth = np.arange(int(moved(0.5) / pitch), int(moved(time[-1]) / pitch) - 1)
    teeth = teeth[teeth % PITCHES < PITCHES - 2]
    wanted = teeth * pitch + off[teeth % PITCHES]
    times = np.interp(wanted, moved(time), time)
    for _ in range(3):
        times -= (moved(times) - wanted) / moved(times, 1)
    times += rng.normal(0.0, 5e-7, times.size)
    lost, doubled = rng.integers(100, times.size, 25), rng.integers(100, times.size, 9)
    return np.sort(np.concatenate((np.delete(times, lost), times[doubled] + 4e-5)))


def motion(
    response: cf.ForcedResponse, speed: np.ndarray, rigid: np.ndarray, softer: float
) -> np.ndarray:
    """Motion of the free end [rad], each mode integrated exactly for forces linear within a step."""
    chain, given = response.chain, response.excitation
    assert chain is not None
    ends, nodes = np.array(chain.connections), np.arange(len(chain.inertia))
    along = (nodes == ends[:, 1:]).astype(float) - (nodes == ends[:, :1])
    stiffness = along.T @ (softer * np.asarray(chain.stiffness)[:, None] * along)
    root = np.sqrt(np.asarray(chain.inertia))
    squares, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    shapes /= root[:, None]
    total = np.zeros_like(rigid)
    for square, shape in zip(squares, shapes.T, strict=True):
        force = np.zeros_like(rigid)
        quick = np.zeros_like(rigid)
        for order, forces in zip(given.orders, given.forces @ shape, strict=True):
            acting = np.interp(speed, given.speeds, forces) * np.exp(1j * order * rigid)
            quick -= (acting / (order * speed) ** 2).real  # of a body without stiffness
            # Lines from step to step weaken a harmonic force by this factor.
            force += (acting / np.sinc(order * speed / (2.0 * np.pi * RATE)) ** 2).real
        if square < 1e-6 * squares[-1]:
            total += shape[0] * quick
            continue
        step = np.zeros((4, 4))
        step[:2, :2] = [[0.0, 1.0], [-square, -2.0 * RATIO * np.sqrt(square)]]
        step[1, 2], step[2, 3] = 1.0, RATE
        step = expm(step / RATE)
        a, held, ramped = step[:2, :2], step[:2, 2] - step[:2, 3], step[:2, 3]
        numerator = [
            ramped[0],
            held[0] - a[1, 1] * ramped[0] + a[0, 1] * ramped[1],
            a[0, 1] * held[1] - a[1, 1] * held[0],
        ]
        total += shape[0] * lfilter(numerator, [1.0, -np.trace(a), np.linalg.det(a)], force)
    return total


def write_record(path: Path, response: cf.ForcedResponse) -> None:
    """Write the times of the pulses, with a header."""
    lines = [f"{moment:.9f}" for moment in pulses(response, LOW, HIGH, DURATION, SOFTER)]
    path.write_text("pulse_time_s\n" + "\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
    run = cf.engine_vibration(ENGINE)
    assert run.forced_torsional is not None
    write_record(folder / "run.csv", run.forced_torsional.response)
