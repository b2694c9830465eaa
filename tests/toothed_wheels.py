"""Pulse trains of toothed wheels on a vibrating chain, by time integration of each order by itself.

The chain has modes alone, which forces of constant amplitude excite; the true amplitude of an order at any
time is the integrated motion itself, turned back by the shaft angle.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.signal import lfilter

RPM = np.pi / 30.0
# Frequency [Hz], damping ratio and share of each mode at the sensor.
MODES = ((100.0, 0.04, 3.0), (260.0, 0.05, 8.0))
ORDERS = np.arange(1, 25) / 2.0
RATE, LEAD, LARGEST = 16_000.0, 3.0, 0.01


@dataclass(frozen=True)
class Turning:
    """Times, rigid angle, speed and motion of the sensor's place; the phasor of each order."""

    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    motion: np.ndarray
    phasors: dict

    def at(self, speeds, orders):
        """Phasors at speeds on the ramp, (m, k)."""
        ramp = self.time > LEAD
        times = np.interp(speeds, self.speed[ramp], self.time[ramp])
        return np.array([np.interp(times, self.time, self.phasors[k]) for k in orders]).T


def integrated(frequency, ratio, force):
    """Motion q of q'' + 2 z w q' + w^2 q = force from rest, exact for forces linear between samples."""
    w = 2.0 * np.pi * frequency
    system = np.zeros((4, 4))
    system[:2, :2] = np.array([[0.0, 1.0], [-w * w, -2.0 * ratio * w]]) / RATE
    system[1, 2], system[2, 3] = 1.0 / RATE, 1.0
    step = expm(system)
    own, held, ramped = step[:2, :2], step[:2, 2] - step[:2, 3], step[:2, 3]
    numerator = [
        ramped[0],
        held[0] - own[1, 1] * ramped[0] + own[0, 1] * ramped[1],
        -own[1, 1] * held[0] + own[0, 1] * held[1],
    ]
    return lfilter(numerator, [1.0, -np.trace(own), np.linalg.det(own)], force)


def turned_up(duration, low=500.0, high=2000.0, orders=ORDERS, seed=1):
    """A chain that turns at the low speed [1/min] for a while, then up to the high one in this time [s]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, LEAD + duration, 1.0 / RATE)
    rise = (high - low) * RPM / duration
    after = np.maximum(time - LEAD, 0.0)
    angle, speed = low * RPM * time + 0.5 * rise * after**2, low * RPM + rise * after
    phasors, motion = {}, np.zeros_like(time)
    for order in orders:
        size = (1.0 if order % 3 == 0 else 0.3 if order % 1.5 == 0 else 0.1) * np.exp(-order / 8.0)
        force = size * np.exp(2j * np.pi * rng.random())
        turn = np.exp(1j * order * angle)
        moved = sum(
            integrated(f, z, share * force * turn * 2.0 * np.pi * f) for f, z, share in MODES
        )
        # The rigid body is slow enough to follow at once.
        phasors[order] = moved / turn - 0.1 * force * (100.0 / speed) ** 2
    scale = LARGEST / max(np.abs(values[time > LEAD]).max() for values in phasors.values())
    for order, values in phasors.items():
        phasors[order] = values * scale
        motion += (phasors[order] * np.exp(1j * order * angle)).real
    return Turning(time, angle, speed, motion, phasors)


def pulses(turning, pitches, missing=0, off=None, *, lead=LEAD):
    """Times of the teeth after the lead, and their numbers; teeth are off by so many radians."""
    moved = CubicSpline(turning.time, turning.angle + turning.motion)
    first = moved(lead) * pitches / (2.0 * np.pi)
    last = moved(turning.time[-1]) * pitches / (2.0 * np.pi)
    number = np.arange(int(first) + 2, int(last) - 1)
    number = number[number % pitches < pitches - missing]
    wanted = 2.0 * np.pi / pitches * number + (0.0 if off is None else off[number % pitches])
    times = np.interp(wanted, moved(turning.time), turning.time)
    slope = moved.derivative()
    for _ in range(3):
        times -= (moved(times) - wanted) / slope(times)
    return times, number


def real_wheel(pitches, missing, seed=5):
    """Errors of teeth [rad]: 1 % of a pitch, 15 % beside the gap; eccentricity of 0.2 % of the radius."""
    pitch = 2.0 * np.pi / pitches
    off = np.random.default_rng(seed).normal(0.0, 0.01, pitches) * pitch
    off[0] += 0.15 * pitch
    off[pitches - missing - 1] -= 0.15 * pitch
    return off + 0.002 * np.sin(pitch * np.arange(pitches) + 0.3)
