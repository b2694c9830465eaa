"""Dampers found by search.

Source: J. P. Den Hartog, Mechanical Vibrations, 4th edition, section 3.3: untuned viscous damper, least
peak (2 + mu) / mu; tuned damper, fixed points of sqrt(1 + 2 / mu).

Tolerance: 5e-4 of the search, 2e-4 between its speeds; damping 2 %, as the peak is flat at its least.

Viscous damper (Houdaille): at c / (2 I w) = 1 / sqrt(2 (1 + mu) (2 + mu)). Tuned damper: two fixed points,
at best both of that height with the tuning 1 / (1 + mu), a lower bound on the peak of any tuned damper. The
best loss factor follows here from the response, minimized over a fine grid of frequencies, tunings and loss
factors. The search uses speeds 0.004 apart and resonances; a curve between them is higher by up to (0.002 /
half width)^2 / 2, below 2e-4 here.
"""

import numpy as np
import pytest
from scipy.optimize import minimize

from comparing import close
from dynamics.assessment.damper_sizing import size_rubber_damper, size_viscous_damper
from dynamics.assessment.limits import given_limit
from dynamics.assessment.response_curves import node_amplitude
from dynamics.chains.chain import Chain
from dynamics.response.order_excitation import OrderExcitation

MAIN = Chain([1.0], [], {0: 1.0}, connections=[], names=["main"])
SPEEDS = np.arange(0.4, 1.6, 0.004)
RESULT = node_amplitude(OrderExcitation([1.0], SPEEDS, np.ones((1, SPEEDS.size, 1))), 0)


def limit(value):
    return given_limit("amplitude", value, "rad", applies_to="main", source="test")


@pytest.mark.parametrize("mu", [0.1, 0.5])
def test_best_viscous_damper(mu, figure):
    found = size_viscous_damper(MAIN, 0, RESULT, limit(1.0), ring_inertia=mu)
    figure("viscous damper: least peak", found.curve.peak, (2.0 + mu) / mu, 5e-4)
    best = 1.0 / np.sqrt(2.0 * (1.0 + mu) * (2.0 + mu))
    figure("viscous damper: its damping ratio", found.damper.damping / (2.0 * mu), best, 0.02)


@pytest.mark.slow
def test_smallest_viscous_damper(figure):
    """(2 + mu) / mu = 9 asks for mu = 1/4."""
    found = size_viscous_damper(MAIN, 0, RESULT, limit(9.0), ring_inertia=(0.02, 1.0))
    assert found.reached
    ring = found.damper.ring_inertia
    figure("smallest viscous damper for a peak of 9: its ring", ring, 0.25, 2e-3, "kg m^2")


def peak_of_rubber_damper(mu, tuning, loss):
    g = np.arange(0.3, 1.8, 2e-4)
    spring = mu * tuning**2 * (1.0 + 1j * loss)
    ring = spring / (spring - mu * g**2)
    return np.max(1.0 / np.abs(1.0 - g**2 + spring * (1.0 - ring)))


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.1, 0.5])
def test_best_rubber_damper(mu, figure):
    found = size_rubber_damper(MAIN, 0, RESULT, limit(1.0), ring_inertia=mu)
    best = minimize(
        lambda x: peak_of_rubber_damper(mu, *x),
        [1.0 / (1.0 + mu), np.sqrt(mu)],
        method="Nelder-Mead",
        options={"xatol": 1e-5, "fatol": 1e-7},
    )
    assert best.fun > np.sqrt(1.0 + 2.0 / mu)
    tuning = found.damper.angular_frequency
    figure("rubber damper: least peak", found.curve.peak, best.fun, 1e-3)
    figure("rubber damper: its tuning", tuning, best.x[0], 2e-3, "rad/s")
    figure("rubber damper: its loss factor", found.damper.loss_factor, best.x[1], 0.02)
    figure("rubber damper: tuning of the fixed points", tuning, 1.0 / (1.0 + mu), 5e-3, "rad/s")


def test_rubber_damper_of_given_loss_factor():
    """With less damping than is best, the best tuning is still found and the fixed points bound."""
    mu = 0.1
    found = size_rubber_damper(MAIN, 0, RESULT, limit(1.0), ring_inertia=mu, loss_factor=0.2)
    tunings = np.linspace(0.85, 0.97, 61)
    peaks = [peak_of_rubber_damper(mu, tuning, 0.2) for tuning in tunings]
    assert found.curve.peak > np.sqrt(1.0 + 2.0 / mu)
    # The grid of tunings is 0.002 apart: by that much of the slope its best may be higher.
    assert found.curve.peak == close(min(peaks), rel=1e-2)
    assert found.damper.angular_frequency == close(tunings[np.argmin(peaks)], abs=3e-3)
