"""Amplitudes of all orders together over the speed, for comparison with limits."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError
from dynamics.assessment.limits import AmplitudeCurve
from dynamics.chains.chain import Chain
from dynamics.chains.editing import find_node
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.loads import element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import OrderSeries


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
    node : int or str
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
        Forces on the first nodes of the chain.
    chain : Chain

    Returns
    -------
    OrderExcitation
        Adds the speeds, between the first and the last one given, at which an order meets a damped natural
        frequency; forces there are interpolated linearly.

    Raises
    ------
    InputError
        If the chain has fewer nodes than the excitation.
    """
    orders, speeds, forces = excitation.orders, excitation.speeds, excitation.forces
    count = chain.inertia.size
    if forces.shape[2] > count:
        raise InputError(
            f"excitation: given forces on {forces.shape[2]} nodes; allowed are up to {count}, because "
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
    padded: NDArray[np.complex128] = np.zeros((orders.size, finer.size, count), dtype=complex)
    padded[:, :, : forces.shape[2]] = at
    return OrderExcitation(orders, finer, padded)


def damped_frequencies(chain: Chain) -> FloatArray:
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
    found = np.linalg.eigvals(state)
    # Rigid motions are round-off: the root of it, as they come in pairs.
    return np.sort(found.imag[found.imag > 1e-6 * scale])


def _response(chain: Chain, excitation: OrderExcitation, magnifier: float | None) -> ForcedResponse:
    return forced_response(chain, with_resonances(excitation, chain), magnifier=magnifier)


def _curve(response: ForcedResponse, values: NDArray[np.complex128], name: str) -> AmplitudeCurve:
    series = OrderSeries(
        response.orders, response.speeds, values[:, :, np.newaxis], response.unbounded, (name,)
    )
    return curves_of(series)[0]
