"""Resonances within a range of speeds, each calculated at its own speed."""

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from dynamics.critical import critical_speeds
from dynamics.indices import index_of_name
from dynamics.response.forced import ForcedResponse
from dynamics.response.harmonic import NO_WORK, UNDAMPED, harmonic_response

# Forces act together if their sum reaches this share of the sum of their sizes.
IN_PHASE = 0.99


@summarized(
    "mode",
    "order",
    "frequency [Hz]",
    "speed [rad/s]",
    "amplitude",
    "magnifier",
    "kind",
    "in_running_range",
)
@dataclass(frozen=True)
class Resonance:
    """A speed at which an order excites an elastic mode at its natural frequency.

    Parameters
    ----------
    mode : int
        Number of the elastic mode, 1 the lowest.
    frequency : float
        Its natural frequency, without damping [Hz].
    order : float
        In cycles per crankshaft revolution.
    speed : float
        [rad/s].
    amplitude : float
        Of this order at the chosen node, all modes together, calculated at exactly this speed [rad or
        m]; inf where unbounded.
    equilibrium : float
        Static displacement of that node in this mode under the order's forces [rad or m].
    magnifier : float
        Of this mode, 1 / (2 damping ratio); inf where undamped.
    estimate : float
        The classical equilibrium amplitude times magnifier [rad or m]: this mode alone.
    share : float
        Magnitude of the sum of the forces' phasors, each weighted with the mode at its node, over the sum of
        their magnitudes: 1 if all act in phase on this mode, 0 if they cancel.
    severity : float
        Amplitude over the largest of the table (of those that are bounded; 1 for an unbounded one).
    kind : {"major", "minor"}
        Major if all forces of the order have the same phase, whatever the mode.
    unbounded : bool
        Whether an undamped mode is excited.
    in_running_range : bool
        Whether the engine runs at that speed; limits may apply at higher speeds too.
    """

    mode: int
    frequency: float
    order: float
    speed: float
    amplitude: float
    equilibrium: float
    magnifier: float
    estimate: float
    share: float
    severity: float
    kind: Literal["major", "minor"]
    unbounded: bool
    in_running_range: bool = True

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""
        return self.speed * 30.0 / pi

    def row(self) -> Row:
        """Return the columns of a table of resonances, each value with its unit; see `table_of`."""
        return {
            "mode": (self.mode, "1"),
            "order": (self.order, "1"),
            "speed": (self.speed, "rad/s"),
            "frequency": (self.frequency, "Hz"),
            "amplitude": (self.amplitude, "rad or m"),
            "equilibrium": (self.equilibrium, "rad or m"),
            "magnifier": (self.magnifier, "1"),
            "estimate": (self.estimate, "rad or m"),
            "share": (self.share, "1"),
            "severity": (self.severity, "1"),
            "kind": (self.kind, ""),
            "unbounded": (self.unbounded, ""),
            "in_running_range": (self.in_running_range, ""),
        }


def resonances(
    response: ForcedResponse, node: int | str = 0, *, speed_range: tuple[float, float] | None = None
) -> tuple[Resonance, ...]:
    """Find all resonances of elastic modes and orders, and their severity.

    Parameters
    ----------
    response : ForcedResponse
        Its system and excitation are used; forces between its speeds are interpolated.
    node : int or str, optional
        Node whose amplitude is reported, by number from 0 or name; the first by default.
    speed_range : tuple of two floats, optional
        Within the speeds of the response; by default all of them [rad/s].

    Returns
    -------
    tuple of Resonance
        In ascending speed.

    Raises
    ------
    InputError
        If there is no such node, or the range is upside down or exceeds the speeds of the response.
    """
    system, excitation = response.system, response.excitation
    place = index_of_name("node", node, response.names, "nodes", "an amplitude is that of a node")
    if speed_range is None and response.speeds.size == 1:
        raise InputError(
            "speed_range: given none, for a response at one speed; allowed is a response at two "
            "speeds or more, because resonances are looked for between them."
        )
    ends = (float(response.speeds[0]), float(response.speeds[-1]))
    frequencies = system.elastic_frequencies
    found = critical_speeds(
        frequencies, response.orders, ends if speed_range is None else speed_range
    )
    if not found:
        return ()
    modes = np.array([own.mode for own in found])
    speeds = np.array([own.speed for own in found])
    order_places = np.searchsorted(response.orders, [own.order for own in found])
    forces = excitation.interpolated(order_places, speeds)
    unknown_forces = forces @ system.expand
    rigid = system.rigid.shape[1]
    natural = system.natural[rigid + modes]
    answer = harmonic_response(system, natural, unknown_forces)
    amplitudes = np.abs(answer.motion @ system.expand[place])
    # One mode by itself.
    shapes = (system.expand @ system.shapes[:, rigid:])[:, modes].T
    work, share = _summed(forces * shapes)
    equilibrium = np.abs(shapes[:, place]) * work / natural**2
    ratios = system.damping_ratios()[modes]
    # Below the limit nothing damps the mode; a force that does no work on it does not move it.
    damped, worked = ratios > 0.5 * UNDAMPED, share > NO_WORK
    magnifiers = np.divide(0.5, ratios, out=np.full(ratios.size, np.inf), where=damped)
    estimates = np.zeros(ratios.size)
    estimates[worked & ~damped] = np.inf
    estimates[worked & damped] = (equilibrium * np.where(damped, magnifiers, 0.0))[worked & damped]
    _, together = _summed(forces)
    largest = float(np.max(amplitudes))
    severities = np.where(answer.unbounded, 1.0, amplitudes / (largest or 1.0))
    return tuple(
        Resonance(
            mode=own.mode + 1,
            frequency=own.frequency,
            order=own.order,
            speed=own.speed,
            amplitude=float("inf") if answer.unbounded[row] else float(amplitudes[row]),
            equilibrium=float(equilibrium[row]),
            magnifier=float(magnifiers[row]),
            estimate=float(estimates[row]),
            share=float(share[row]),
            severity=float(severities[row]),
            kind="major" if together[row] >= IN_PHASE else "minor",
            unbounded=bool(answer.unbounded[row]),
        )
        for row, own in enumerate(found)
    )


def _summed(phasors: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the magnitude of each row's sum, and its share of the sum of magnitudes (0 without forces)."""
    sums, sizes = np.abs(phasors.sum(axis=1)), np.abs(phasors).sum(axis=1)
    share: NDArray[np.float64] = np.divide(sums, sizes, out=np.zeros(sums.size), where=sizes > 0.0)
    return sums, share
