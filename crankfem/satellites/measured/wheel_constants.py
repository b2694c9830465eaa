"""The constants that a wheel adds to whole orders: taken away, found by a second sensor, tested by its edges.

Pitch errors and eccentricity turn with the wheel, and so add one complex constant to each whole order, the
same at all speeds. Half orders have none.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, check_shape
from crankbase.errors import InputError
from crankfem.satellites.measured.measured_orders import OF_WHEEL, MeasuredOrders


def without_wheel(measured: MeasuredOrders, constants: ArrayLike) -> MeasuredOrders:
    """Return measured orders less the wheel's constants (k,), which are then known.

    Raises
    ------
    InputError
        If there is not one constant for each order.
    """
    taken = np.asarray(constants, dtype=complex)
    check_shape("constants", np.abs(taken), (measured.orders.size,))
    known = np.where(measured.wheel_constant, taken, 0.0)
    return replace(
        measured,
        amplitude=measured.amplitude - known,
        wheel_constant=np.zeros(measured.orders.size, dtype=bool),
        notes=tuple(note for note in measured.notes if note != OF_WHEEL),
    )


def constants_by_reference(
    measured: MeasuredOrders, reference: MeasuredOrders
) -> tuple[ComplexArray, Array]:
    """Return the wheel's constants and their scatter, (k,) each, by a second sensor at the same place.

    Parameters
    ----------
    measured : MeasuredOrders
        By the wheel.
    reference : MeasuredOrders
        By a sensor with the same angle zero but without such constants, such as an encoder or a torsiograph.

    Raises
    ------
    InputError
        If the reference lacks an order, or their speeds do not overlap.
    """
    places = np.searchsorted(reference.orders, measured.orders)
    same = np.minimum(places, reference.orders.size - 1)
    if np.any(reference.orders[same] != measured.orders):
        raise InputError("reference: lacks some of the measured orders; allowed is one with all.")
    order = np.argsort(reference.speed)
    speeds = reference.speed[order]
    within = (measured.speed >= speeds[0]) & (measured.speed <= speeds[-1])
    if not np.any(within):
        raise InputError("reference: has none of the measured speeds; allowed is one with some.")
    differences, variances = [], []
    for column, place in enumerate(same.tolist()):
        values, spread = reference.amplitude[order, place], reference.scatter[order, place]
        there = np.interp(measured.speed[within], speeds, values)
        differences.append(measured.amplitude[within, column] - there)
        variances.append(
            measured.scatter[within, column] ** 2
            + np.interp(measured.speed[within], speeds, spread) ** 2
        )
    weights = 1.0 / np.maximum(np.array(variances).T, 1e-300)
    constants = np.sum(np.array(differences).T * weights, axis=0) / np.sum(weights, axis=0)
    independent = np.count_nonzero(within) * measured.part(within).independent
    scatter = np.sqrt(1.0 / np.mean(weights, axis=0) / independent)
    return np.where(measured.wheel_constant, constants, 0.0), scatter


def edge_disagreement(rising: MeasuredOrders, falling: MeasuredOrders) -> Array:
    """Return by how much the orders of a record by rising and by falling edges disagree, (k,) [rad].

    Both see the same vibration; the whole orders differ by the constants of two wheels, which are then at
    least half as large. Half orders tell how well the record is read at all.

    Raises
    ------
    InputError
        If the two are not of one record.
    """
    if rising.amplitude.shape != falling.amplitude.shape or np.any(rising.orders != falling.orders):
        raise InputError("falling: allowed are the orders of the same record by the other edge.")
    return np.asarray(np.abs(np.mean(rising.amplitude - falling.amplitude, axis=0)))
