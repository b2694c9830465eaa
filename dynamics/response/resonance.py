"""Resonances within a range of speeds, the speeds to calculate at, and the Campbell diagram."""

from collections.abc import Sequence
from math import pi
from typing import Annotated, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    checked_range,
    nonnegative_vector,
    one_for_each,
    positive_vector,
)
from crankbase.choices import check_some, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.results import Hertz, Number, Quantity, Result, Speed, result
from dynamics.critical import CriticalSpeed, critical_speeds
from dynamics.indices import index_of_name
from dynamics.plots.campbell import draw_campbell
from dynamics.response.forced import ForcedResponse
from dynamics.response.harmonic import NO_WORK, UNDAMPED, harmonic_response
from dynamics.response.order_excitation import acting_at

# Forces act together if their sum reaches this share of the sum of their sizes.
IN_PHASE = 0.99
Motion: TypeAlias = Annotated[float, Quantity("rad or m")]


@result(
    *("mode", "order", "frequency", "speed", "amplitude", "magnifier", "kind", "in_running_range"),
    eq=True,
)
class Resonance(Result):
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
    frequency: Hertz
    order: Number
    speed: Speed
    amplitude: Motion
    equilibrium: Motion
    magnifier: Number
    estimate: Motion
    share: Number
    severity: Number
    kind: Literal["major", "minor"]
    unbounded: bool
    in_running_range: bool = True

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""
        return self.speed * 30.0 / pi


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
    criticals = critical_speeds(
        frequencies, response.orders, ends if speed_range is None else speed_range
    )
    if not criticals:
        return ()
    modes = np.array([critical.mode for critical in criticals])
    speeds = np.array([critical.speed for critical in criticals])
    order_places = np.searchsorted(response.orders, [critical.order for critical in criticals])
    forces = acting_at(excitation, order_places, speeds)[:, : len(system.expand)]
    unknown_forces = forces @ system.expand
    rigid = system.rigid.shape[1]
    natural = system.natural[rigid + modes]
    answer = harmonic_response(system, natural, unknown_forces, speeds=speeds)
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
            mode=critical.mode + 1,
            frequency=critical.frequency,
            order=critical.order,
            speed=critical.speed,
            amplitude=float("inf") if answer.unbounded[row] else float(amplitudes[row]),
            equilibrium=float(equilibrium[row]),
            magnifier=float(magnifiers[row]),
            estimate=float(estimates[row]),
            share=float(share[row]),
            severity=float(severities[row]),
            kind="major" if together[row] >= IN_PHASE else "minor",
            unbounded=bool(answer.unbounded[row]),
        )
        for row, critical in enumerate(criticals)
    )


def _summed(phasors: ComplexArray) -> tuple[Array, Array]:
    """Return the magnitude of each row's sum, and its share of the sum of magnitudes (0 without forces)."""
    sums, sizes = np.abs(phasors.sum(axis=1)), np.abs(phasors).sum(axis=1)
    share: Array = np.divide(sums, sizes, out=np.zeros(sums.size), where=sizes > 0.0)
    return sums, share


# Distances from a resonance in half bandwidths; then 1.5 times as far each, up to the even grid.
NEAR = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)
GROWTH = 1.5
# Half bandwidth taken where there is (almost) no damping, as a share of the speed.
LEAST_RATIO = 1e-4
# Speeds within this share of each other are one.
SAME_SPEED = 1e-12
# Of an even grid.
POINTS = 200


def refined_speeds(
    frequencies: ArrayLike,
    damping_ratios: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    *,
    points: int = POINTS,
) -> Array:
    """Return speeds that miss no peak of a lightly damped system.

    Parameters
    ----------
    frequencies : array_like of shape (n,)
        Natural frequencies [Hz]; zero for rigid-body modes.
    damping_ratios : float or array_like of shape (n,)
        Share of critical damping of each mode; 1 / (2 magnifier).
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Lowest and highest speed [rad/s].
    points : int, optional
        Number of speeds of the even grid.

    Returns
    -------
    ndarray of shape (S,)
        Ascending [rad/s]: the even grid, each critical speed itself, and speeds about it.

    Raises
    ------
    InputError
        If a value is out of range, or the range is reversed.

    Notes
    -----
    The response of a mode of damping ratio d is 1 / sqrt(1 + (x / d)^2) of its peak at the relative
    distance x from resonance: half the bandwidth at half power is d. At magnifier 40 this is 1.25 %
    of the speed, so an even grid may give a peak far too low. Here the speeds are d/8 apart
    within d/2: wherever other modes shift the peak between them, at least
    1 - (1/16)^2 / 2 = 99.8 % of it is found. Further away the spacing grows to that of the even grid.
    """
    natural = nonnegative_vector("frequencies", frequencies, "Hz", "they count vibrations in time")
    ratios = one_for_each(
        "damping_ratios",
        damping_ratios,
        natural.size,
        "frequencies",
        "",
        "damping takes energy away",
    )
    count = whole_number("points", points, 2, "the range has two ends")
    low, high = (float(limit) for limit in speed_range)
    return speeds_about(critical_speeds(natural, orders, speed_range), ratios, (low, high), count)


def speeds_about(
    critical: Sequence[CriticalSpeed],
    ratios: Array,
    ends: tuple[float, float],
    count: int = POINTS,
) -> Array:
    """Return `refined_speeds` about known critical speeds, for checked ratios and ends."""
    low, high = ends
    even = np.linspace(low, high, count)
    spacing = (high - low) / (count - 1)
    grids = [even]
    for resonance in critical:
        half = max(float(ratios[resonance.mode]), LEAST_RATIO) * resonance.speed
        offsets = list(NEAR)
        while offsets[-1] * (GROWTH - 1.0) * half < spacing and offsets[-1] * half < high - low:
            offsets.append(offsets[-1] * GROWTH)
        about = half * np.array(offsets)
        grids += [resonance.speed - about, np.array([resonance.speed]), resonance.speed + about]
    speeds = np.sort(np.concatenate(grids))
    speeds = speeds[(speeds >= low) & (speeds <= high)]
    # Of several alike the first stays; they differ by round-off.
    apart = np.diff(speeds, prepend=0.0) > SAME_SPEED * speeds
    return np.asarray(speeds[apart])


def campbell_diagram(
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    met: Sequence[Resonance] = (),
    axes: Axes | None = None,
) -> Axes:
    """Draw natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s], shaded.
    met : sequence of Resonance, optional
        Dots grow with their severity.

    Raises
    ------
    InputError
        If frequencies are not a row of finite numbers of zero or more, orders not finite numbers above
        zero, at least one, or the range is not two speeds, the lower first.
    """
    natural = nonnegative_vector("frequencies", frequencies, "Hz", "modes swing at them")
    lines = positive_vector("orders", orders, "", "their lines rise with the speed")
    check_some("orders", lines, "their lines set the height")
    ends = checked_range("speed_range", speed_range, "rad/s", "it is shaded")
    axes = new_axes(axes, height=4.8)
    draw_campbell(axes, natural, lines, ends, met)
    write_title(axes, "Campbell diagram")
    return axes
