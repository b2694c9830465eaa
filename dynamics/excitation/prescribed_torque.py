"""Forces of cylinders from prescribed torque harmonics, measured or printed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import ComplexArray, finite_vector, positive_number, read_only
from crankbase.errors import InputError
from dynamics.cycle import order_step
from dynamics.engine.firing import MOST_CYLINDERS
from dynamics.excitation.cylinder_harmonics import CylinderHarmonics
from dynamics.excitation.gas_sources import constant_weight
from dynamics.excitation.sampled_phasors import order_indices, requested_orders
from dynamics.harmonics import Harmonics


def torque_harmonics(
    torque: Harmonics | Sequence[Harmonics],
    orders: ArrayLike | float,
    *,
    firing_angles_deg: ArrayLike,
    crank_radius: float,
    throws: Sequence[int] | None = None,
) -> CylinderHarmonics:
    """Return given torques of the cylinders in the form of calculated forces.

    Parameters
    ----------
    torque : Harmonics or sequence of c Harmonics
        Of one cylinder's torque, gas and inertia together [N m], phases counted from its own firing
        top: the same for all, or one for each. They are used at all speeds.
    orders : array_like of shape (K,), or a number
        Ascending; a number for all up to it.
    firing_angles_deg : array_like of shape (c,)
        Shaft angle at which each cylinder fires [deg].
    crank_radius : float
        R [m].
    throws : sequence of c int, optional
        Throw of each cylinder, 0 next to the free end; by default one each.

    Returns
    -------
    CylinderHarmonics
        Without radial forces, which a torque does not determine.

    Raises
    ------
    InputError
        If there is not one for each cylinder, strokes differ, or samples do not resolve an order.
    """
    firing = np.radians(finite_vector("firing_angles_deg", firing_angles_deg))
    each = [torque] * firing.size if isinstance(torque, Harmonics) else list(torque)
    if firing.size > MOST_CYLINDERS:
        raise InputError(
            f"firing_angles_deg: given {firing.size} angles; allowed are at most {MOST_CYLINDERS}, because "
            "no engine has more cylinders."
        )
    if not each or len(each) != firing.size or len({own.strokes for own in each}) > 1:
        raise InputError(
            f"torque: given {len(each)} for {firing.size} firing angles; allowed is one for each cylinder, "
            "all of one kind of cycle, because each cylinder works on the same shaft."
        )
    at_throws = tuple(range(firing.size)) if throws is None else tuple(throws)
    if sorted(set(at_throws)) != list(range(max(at_throws) + 1)) or len(at_throws) != firing.size:
        raise InputError(
            f"throws: given {list(at_throws)}; allowed is one for each of {firing.size} cylinders, from "
            "0 on without a gap, because each cylinder works on one."
        )
    radius = positive_number("crank_radius", crank_radius, "m", "it is a length")
    strokes = each[0].strokes
    asked = requested_orders(orders, strokes)
    gas: list[ComplexArray] = []
    for own, angle in zip(each, firing.tolist(), strict=True):
        order_indices(asked, strokes, own.samples, "the given torques")
        order_indices(asked, strokes, 2 * own.orders.size + 1, "the orders kept of the torques")
        places = np.round(asked / order_step(strokes)).astype(np.int64) - 1
        phasors = (own.cosine - 1j * own.sine)[places] * np.exp(-1j * asked * angle)
        tangential = np.zeros(asked.size + 1, dtype=np.complex128)
        tangential[0], tangential[1:] = own.mean / radius, phasors / radius
        gas.append(np.stack((tangential, 0.0 * tangential), axis=-1)[np.newaxis])
    return CylinderHarmonics(
        orders=read_only(asked),
        crank_radius=radius,
        throws=at_throws,
        gas=tuple(gas),
        weights=(constant_weight,) * firing.size,
        inertia=np.zeros((asked.size + 1, firing.size, 2), dtype=np.complex128),
        takes_load=False,
        one_diagram="torque diagram",
        remarks=(),
    )
