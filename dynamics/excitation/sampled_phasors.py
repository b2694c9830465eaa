"""Phasors of even samples over a cycle, and the orders that the samples resolve."""

from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from dynamics.critical import engine_orders
from dynamics.cycle import order_step
from dynamics.response.order_excitation import checked_orders

# An order that was calculated is a multiple of the step within this share of it.
ON_STEP = 1e-9


def phasors_of_samples(samples: FloatArray) -> NDArray[np.complex128]:
    """Return mean and phasors of even samples over a cycle, angles counted from the first.

    Parameters
    ----------
    samples : ndarray of shape (..., m)

    Returns
    -------
    complex ndarray of shape (..., (m - 1) // 2 + 1)
        The mean, then Y_j of y = mean + Re sum of Y_j exp(i j 2 pi x / cycle). The order at half the
        sampling rate is left out: the samples do not determine its phase.
    """
    count = samples.shape[-1]
    found = np.fft.rfft(samples)[..., : (count - 1) // 2 + 1] / count
    found[..., 1:] *= 2.0
    return np.asarray(found)


def order_indices(orders: ArrayLike, strokes: int, samples: int, what: str) -> NDArray[np.int64]:
    """Return the indices of orders among the phasors of samples over a cycle.

    Parameters
    ----------
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution, above zero and ascending.
    strokes : int
        Strokes per cycle, 2 or 4.
    samples : int
        Over the cycle.
    what : str
        Whose samples, for the message.

    Raises
    ------
    InputError
        If an order is not a multiple of the cycle's, or the samples do not resolve it: it would appear
        as a lower order (aliasing).
    """
    values, step = checked_orders(orders), order_step(strokes)
    places = np.round(values / step)
    between = np.flatnonzero(np.abs(values / step - places) > ON_STEP * places)
    if between.size:
        first = int(between[0])
        raise InputError(
            f"orders[{first}]: given {values[first]:g}; allowed are multiples of {step:g}, because "
            f"a cycle of {strokes} strokes has no others."
        )
    highest = (samples - 1) // 2
    beyond = np.flatnonzero(places > highest)
    if beyond.size:
        first = int(beyond[0])
        raise InputError(
            f"orders[{first}]: given {values[first]:g}; allowed are orders up to {step * highest:g}, because "
            f"{what} have {samples} samples over the cycle and in them a higher order looks like a lower "
            "one."
        )
    return np.asarray(places, dtype=np.int64)


def requested_orders(orders: ArrayLike | float, strokes: int) -> FloatArray:
    """Return the requested orders (K,): those given, or all up to a highest one.

    Raises
    ------
    InputError
        If they are not above zero and ascending.
    """
    if np.ndim(orders) == 0:
        return engine_orders(strokes, cast(float, orders))
    return checked_orders(orders)
