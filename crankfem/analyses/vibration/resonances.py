"""The resonances of an engine at all speeds assessed: peaks of single orders at any place."""

from collections.abc import Collection
from dataclasses import replace
from typing import Protocol

import numpy as np

from crankfem.files.engine.engine_file import EngineFile
from dynamics.critical import major_orders
from dynamics.response.complex_modes import ComplexModes
from dynamics.response.damped_criticals import DampedCritical, damped_criticals
from dynamics.response.forced import ForcedResponse


class Answer(Protocol):
    """A vibrating system; `crankfem.analyses.vibration.forced.ForcedVibration` is an example."""

    @property
    def response(self) -> ForcedResponse:
        """Motion of the chain."""

    @property
    def modes(self) -> ComplexModes:
        """The damped modes of the chain."""

    @property
    def running_range(self) -> tuple[float, float]:
        """Speeds at which the engine runs [rad/s]."""

    @property
    def judged_range(self) -> tuple[float, float]:
        """Speeds at which vibration is assessed [rad/s]."""


def resonances_of(
    engine_file: EngineFile, forced: Answer, limited: Collection[str] = ()
) -> tuple[DampedCritical, ...]:
    """Return the peaks of all elements and nodes, ascending in speed, and then modes without a peak.

    Major orders are those in which all cylinders fire in phase. A peak of the exciting forces
    without a mode near it is not a resonance; it is not `in_band`. Places with limits are told first.
    """
    response = forced.response
    major = major_orders(response.orders, engine_file.engine.firing_angles)
    found = damped_criticals(
        response, speed_range=forced.judged_range, modes=forced.modes, first=limited
    )
    told = [
        replace(
            one,
            kind="major" if np.any(np.isclose(major, one.order)) else "minor",
            in_running_range=_speed(one) <= forced.running_range[1],
        )
        for one in found
    ]
    return tuple(sorted(told, key=lambda one: (not one.has_peak, _speed(one))))


def _speed(critical: DampedCritical) -> float:
    """Speed of a peak; without one that at which the order meets the undamped mode [rad/s]."""
    return critical.speed if critical.has_peak else critical.undamped_speed
