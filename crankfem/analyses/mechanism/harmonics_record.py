"""Harmonics of a torque and the reduction to two masses, as plain JSON content."""

import math

import numpy as np

from crankfem.analyses.record import Record
from dynamics.chains.two_mass import TwoMassCheck
from dynamics.harmonics import Harmonics


def harmonics_record(found: Harmonics) -> Record:
    """Mean and harmonics M_k sin(k w t + a_k)."""
    return {
        "strokes": found.strokes,
        "samples": found.samples,
        "mean": found.mean,
        "highest_order": found.highest_order,
        "orders": found.orders.tolist(),
        "cosine": found.cosine.tolist(),
        "sine": found.sine.tolist(),
        "amplitude": found.amplitude.tolist(),
        "phase_deg": np.rad2deg(found.phase).tolist(),
    }


def two_mass_record(check: TwoMassCheck) -> Record:
    """The two-mass check."""
    return {
        "stiffness": check.stiffness,
        "angular_frequency": check.angular_frequency,
        "frequency": check.angular_frequency / (2.0 * math.pi),
        "vibrations_per_minute": check.vibrations_per_minute,
        "order": check.order,
        "resonant_speed_rpm": check.resonant_speed_rpm,
        "statement": check.statement,
    }
