"""The same by another way: plain sums and closed forms that results are compared with."""

import math

import numpy as np

from dynamics.gas.gas_cycle import motored_pressure, pressure_rise_per_heat


def finite_sums(samples):
    """Return M_0, A_k and B_k as they stand in Makushev, Polyakova 2024, (3) to (5).

    doi 10.25206/1813-8225-2024-191-39-47, with x_j = 2 pi j / m: A_k = 2/m sum y_j cos(k x_j) (3),
    B_k = 2/m sum y_j sin(k x_j) (4), M_0 = 1/m sum y_j (5); with 1/m for the order at half the
    sampling rate.
    """
    values = np.asarray(samples, dtype=float)
    count = values.size
    numbers = np.arange(1, count // 2 + 1)
    # k j modulo m keeps the arguments below 2 pi, where cosine and sine are accurate.
    arguments = 2.0 * np.pi / count * (np.outer(numbers, np.arange(count)) % count)
    weights = np.where(2 * numbers == count, 1.0, 2.0) / count
    cosine, sine = (weights * (function(arguments) @ values) for function in (np.cos, np.sin))
    return values.sum() / count, cosine, sine


def even_firing_angles(firing_order, strokes=4):
    """Return the crank angle at which each cylinder fires, at even intervals over the cycle [rad]."""
    interval = math.pi * strokes / len(firing_order)
    return np.array(
        [interval * firing_order.index(number + 1) for number in range(len(firing_order))]
    )


def closed_pressure(cycle, volume, heat, angle_deg):
    """Return the pressure of the closed part of a cycle for a heat released [Pa]."""
    rise = pressure_rise_per_heat(cycle, volume, angle_deg)
    return motored_pressure(cycle, volume, angle_deg) + heat * rise
