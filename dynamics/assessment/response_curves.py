"""Amplitudes of all orders together over the speed, for comparison with limits."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, ComplexArray, Flags, positive_number
from crankbase.choices import whole_within
from crankbase.errors import InputError
from dynamics.assessment.limits import AmplitudeCurve
from dynamics.chains.chain import Chain
from dynamics.chains.editing import find_node
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.loads import element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import OrderSeries, synthesis


def curves_of(series: OrderSeries) -> tuple[AmplitudeCurve, ...]:
    """Return the amplitude of the sum of all orders at each place of a series, over the speed.

    Returns
    -------
    tuple of p AmplitudeCurve
        Half of the range from lowest to highest value over the cycle; inf where unbounded.
    """
    amplitudes = series.synthesis.amplitude
    return tuple(
        AmplitudeCurve(name, series.speeds, amplitudes[:, place])
        for place, name in enumerate(series.names)
    )


def node_amplitude(
    excitation: OrderExcitation,
    node: int | str,
    *,
    elastic: bool = False,
    magnifier: float | None = None,
) -> Callable[[Chain], AmplitudeCurve]:
    """Return a function that gives the amplitude of one node of a chain over the speed.

    **It includes the motion of the whole shaft as a rigid body**, unless `elastic` is set. This motion is
    large at low speeds, where low orders swing a free shaft to and fro, and causes no strain. The free
    end's amplitude of an engine's forced vibration, and the limits on it, exclude it.

    Parameters
    ----------
    excitation : OrderExcitation
        Forces on the nodes; further nodes of the chain, such as the ring of a damper, are free.
    elastic : bool
        Whether only the motion relative to that of the rigid body counts.
    magnifier : float, optional
        Damping added to each mode; see `forced_response`.

    Returns
    -------
    callable
        Chain to AmplitudeCurve [rad or m]: for `size_viscous_damper` and similar functions. It adds the
        speeds of the chain's resonances to those of the excitation, so that no peak is missed.
    """

    def curve(chain: Chain) -> AmplitudeCurve:
        place = find_node(chain, node)
        response = _response(chain, excitation, magnifier)
        motion = response.elastic.values if elastic else response.motion
        return _curve(response, motion[:, :, place], chain.names[place])

    return curve


def element_load(
    excitation: OrderExcitation,
    element: int,
    *,
    section: float = 1.0,
    magnifier: float | None = None,
) -> Callable[[Chain], AmplitudeCurve]:
    """Return a function that gives the load or the nominal stress of one element over the speed.

    Parameters
    ----------
    excitation, magnifier
        As in `node_amplitude`.
    element : int
        From 0.
    section : float
        Section modulus in torsion [m^3] or area [m^2]: the result is the stress [Pa]. By default the
        load of the element [N m or N].

    Returns
    -------
    callable
        Chain to AmplitudeCurve.

    Raises
    ------
    InputError
        If the section is not above zero or, when called, the element does not exist.
    """
    size = positive_number("section", section, "m^3 or m^2", "stress is load over section")

    def curve(chain: Chain) -> AmplitudeCurve:
        count = len(chain.elements)
        place = whole_within("element", element, 0, count - 1, f"the chain has {count} elements")
        response = _response(chain, excitation, magnifier)
        loads = element_loads(response).elastic.values[:, :, place] / size
        return _curve(response, loads, chain.elements[place])

    return curve


def with_resonances(excitation: OrderExcitation, chain: Chain) -> OrderExcitation:
    """Return an excitation for all nodes of a chain, with the speeds of its resonances added.

    Parameters
    ----------
    excitation : OrderExcitation
        Forces on the first nodes of the chain, and pressing of its first elements, if any.

    Returns
    -------
    OrderExcitation
        Adds the speeds, between the first and the last one given, at which an order meets a damped natural
        frequency; forces there are interpolated linearly.
    """
    orders, speeds, forces = excitation.orders, excitation.speeds, excitation.acting
    count, known = chain.inertia.size, excitation.forces.shape[2]
    if known > count:
        raise InputError(
            f"excitation: given forces on {known} nodes; allowed are up to {count}, because "
            "the chain has so many."
        )
    meeting = (damped_frequencies(chain)[:, np.newaxis] / orders).reshape(-1)
    inside = meeting[(speeds[0] < meeting) & (meeting < speeds[-1])]
    finer = np.unique(np.concatenate((speeds, inside)))
    right = np.clip(np.searchsorted(speeds, finer), 1, speeds.size - 1) if speeds.size > 1 else None
    if right is None:
        at = forces
    else:
        share = (finer - speeds[right - 1]) / (speeds[right] - speeds[right - 1])
        weight = share[:, np.newaxis]
        at = (1.0 - weight) * forces[:, right - 1] + weight * forces[:, right]

    def padded(values: ComplexArray, places: int) -> ComplexArray:
        return np.pad(values, ((0, 0), (0, 0), (0, places - values.shape[2])))

    pressing = None
    if excitation.pressing is not None:
        pressing = padded(at[:, :, known:], len(chain.elements))
    return OrderExcitation(orders, finer, padded(at[:, :, :known], count), pressing)


def damped_frequencies(chain: Chain) -> Array:
    """Return the angular frequencies of the chain's damped free vibrations [rad/s], ascending.

    Only viscous damping counts: loss factors hardly shift frequencies. Overdamped modes are
    excluded.
    """
    expand = chain.expansion()
    mass, stiffness, damping = (
        expand.T @ matrix @ expand
        for matrix in (chain.mass_matrix(), chain.stiffness_matrix(), chain.damping_matrix())
    )
    count = len(mass)
    inverse = np.linalg.inv(mass)
    scale = float(np.sqrt(np.max(np.diag(inverse @ stiffness)))) or 1.0
    state = np.block(
        [
            [np.zeros((count, count)), scale * np.eye(count)],
            [-inverse @ stiffness / scale, -inverse @ damping],
        ]
    )
    eigenvalues = np.linalg.eigvals(state)
    # Rigid motions are round-off: the root of it, as they come in pairs.
    return np.sort(eigenvalues.imag[eigenvalues.imag > 1e-6 * scale])


def _response(chain: Chain, excitation: OrderExcitation, magnifier: float | None) -> ForcedResponse:
    return forced_response(chain, with_resonances(excitation, chain), magnifier=magnifier)


def _curve(response: ForcedResponse, values: NDArray[np.complex128], name: str) -> AmplitudeCurve:
    series = OrderSeries(
        response.orders, response.speeds, values[:, :, np.newaxis], response.unbounded, (name,)
    )
    return curves_of(series)[0]


# Sums made at once.
TOGETHER = 128


def largest_amplitude(series: OrderSeries, weights: Array) -> tuple[float, int, int]:
    """Find the largest weighted amplitude of a series.

    Parameters
    ----------
    weights : ndarray of shape (S,)
        Of each speed, such as the reciprocal of the limit; not negative, zero where the speed is ignored.

    Returns
    -------
    amplitude : float
        Without its weight, in the unit of the series; inf where unbounded.
    speed, place : int
        Their indices.

    Notes
    -----
    No amplitude exceeds the plain sum of the orders' amplitudes. Sums over the cycle are formed in the
    order of these bounds, until no remaining bound exceeds the largest sum found. The result equals that
    of all sums, most of which are never formed.
    """
    endless = np.any(series.unbounded, axis=0) & (weights > 0.0)
    if np.any(endless):
        return np.inf, int(np.argmax(endless)), 0
    values = series.values
    bounds = weights[:, np.newaxis] * np.sum(np.abs(values), axis=0)
    ranked = np.argsort(-bounds, axis=None, kind="stable")
    best, amplitude, winner = -1.0, 0.0, int(ranked[0])
    flat = values.reshape(len(series.orders), -1)
    for start in range(0, ranked.size, TOGETHER):
        some = ranked[start : start + TOGETHER]
        if bounds.flat[some[0]] <= best:
            break
        speeds, _ = np.unravel_index(some, bounds.shape)
        amplitudes = synthesis(series.orders, series.speeds[speeds], flat[:, some]).amplitude
        used = weights[speeds] * amplitudes
        top = int(np.argmax(used))
        if used[top] > best:
            best, amplitude, winner = float(used[top]), float(amplitudes[top]), int(some[top])
    speed, place = np.unravel_index(winner, bounds.shape)
    return amplitude, int(speed), int(place)


def speeds_above(series: OrderSeries, weights: Array, known: Flags) -> Flags:
    """Return at which speeds the weighted amplitude of any point exceeds one, (S,).

    Parameters
    ----------
    weights : ndarray of shape (S,)
        As for `largest_amplitude`.
    known : ndarray of shape (S,), bool
        Speeds that are skipped, because they exceed it already.
    """
    above = known | (np.any(series.unbounded, axis=0) & (weights > 0.0))
    bounds = weights[:, np.newaxis] * np.sum(np.abs(series.values), axis=0)
    ranked = np.argsort(-bounds, axis=1)
    for place in ranked.T:
        rows = np.flatnonzero(~above)
        rows = rows[bounds[rows, place[rows]] > 1.0]
        if not rows.size:
            break
        phasors = series.values[:, rows, place[rows]]
        amplitudes = synthesis(series.orders, series.speeds[rows], phasors).amplitude
        above[rows] = weights[rows] * amplitudes > 1.0
    return np.asarray(above)


# Maxima that reach this share of a curve's largest value are refined: on a grid that refines resonances
# another may read 0.2 % less than it is, and turn out to be the largest.
NEARLY_LARGEST = 0.99
# A maximum's neighbors come this many times closer in each round, and so often.
CLOSER, ROUNDS = 4, 3

Uses = Callable[[Array], Array]


def refined_maxima(uses_at: Uses, speeds: Array, least: float = np.inf) -> Array:
    """Find the speeds of the largest values of curves, more closely than the calculated speeds.

    Parameters
    ----------
    uses_at : callable
        Speeds (S,) [rad/s] to the values (C, S) of the curves, such as the used share of limits; not
        negative, inf where unbounded.
    speeds : ndarray of shape (S,)
        Ascending [rad/s].
    least : float, optional
        In each range in which a curve exceeds this, its first and last maximum are refined too.

    Returns
    -------
    ndarray of shape (m,)
        Ascending speeds between those given at which a curve has a maximum [rad/s].

    Notes
    -----
    Each maximum is between the neighbors of the largest calculated value. Values are calculated at
    even steps between them, and the neighbors of the new largest value are the next bounds: after three
    rounds they are 64 times closer. On a grid that steps by an eighth of the half bandwidth near
    resonances, this gives the speed to 1/512 of it and the value, as a peak is round, to 1e-6.
    """
    values = uses_at(speeds)
    chosen = set()
    for curve, uses in enumerate(values):
        beside = np.concatenate(([-1.0], uses, [-1.0]))
        highs = np.flatnonzero((uses > beside[:-2]) & (uses >= beside[2:]) & (uses > 0.0))
        largest = np.max(uses, initial=0.0)
        chosen |= {
            (curve, high) for high in highs.tolist() if uses[high] >= NEARLY_LARGEST * largest
        }
        # Ranges without a gap above the least value, numbered by the steps up to it.
        runs = np.cumsum(np.diff(uses > least, prepend=False))
        exceeding = highs[uses[highs] > least]
        for run in np.unique(runs[exceeding]):
            inside = exceeding[runs[exceeding] == run]
            chosen |= {(curve, int(inside[0])), (curve, int(inside[-1]))}
    # An unbounded maximum needs no refinement.
    bounded = sorted(pair for pair in chosen if np.isfinite(values[pair]))
    if not bounded:
        return np.empty(0)
    curves, tops = np.array(bounded, dtype=np.intp).T
    none = np.full(curves.size, -1.0)
    best = speeds[tops]
    left = speeds[np.maximum(tops - 1, 0)]
    right = speeds[np.minimum(tops + 1, speeds.size - 1)]
    reached = values[curves, tops]
    steps = np.arange(1, 2 * CLOSER) / (2.0 * CLOSER)
    for _ in range(ROUNDS):
        # The best place known stays among those tried, for the bracket need not be even about it.
        tried = left[:, np.newaxis] + (right - left)[:, np.newaxis] * steps
        asked = np.unique(tried)
        uses = uses_at(asked)[curves[:, np.newaxis], np.searchsorted(asked, tried)]
        every = np.column_stack((left, best, tried, right))
        known = np.column_stack((none, reached, uses, none))
        row, top = np.arange(best.size), np.argmax(known, axis=1)
        best, reached = every[row, top], known[row, top]
        below, above = every < best[:, np.newaxis], every > best[:, np.newaxis]
        # At the first and last speed calculated there is none beyond.
        left = np.max(np.where(below, every, -np.inf), axis=1)
        left = np.where(np.isfinite(left), left, best)
        right = np.min(np.where(above, every, np.inf), axis=1)
        right = np.where(np.isfinite(right), right, best)
    return np.asarray(np.unique(best))
