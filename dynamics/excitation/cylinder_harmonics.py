"""Harmonics of the forces of all cylinders for any speed: gas by diagram, and inertia."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import (
    ComplexArray,
    FloatArray,
    nonnegative_number,
    read_only,
    turning_speeds,
)
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import cycle_radians, even_angles
from dynamics.engine.forces import MechanismForces, mechanism_forces, over_angles
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.engine_load import Load
from dynamics.excitation.gas_sources import (
    GasSource,
    Pressures,
    Weights,
    constant_weight,
    gas_sources,
)
from dynamics.excitation.sampled_phasors import order_indices, phasors_of_samples, requested_orders
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.torque.cycle_samples import DEFAULT_SAMPLES
from dynamics.torque.throws import checked_throws, throws_along_shaft

TURN = 2.0 * math.pi
# The forces of moving masses are smooth: so many samples of a turn tell all harmonics that matter.
INERTIA_SAMPLES = 720


@summarized("orders", "crank_radius [m]", "throws", "takes_load", "remarks")
@dataclass(frozen=True, eq=False)
class CylinderHarmonics:
    """Tangential and radial force of every cylinder by orders, for any speed and load.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution, ascending.
    crank_radius : float
        R [m].
    throws : tuple of c int
        Throw of each cylinder, from 0 at the free end.
    gas : tuple of c complex ndarrays of shape (D, K + 1, 2)
        Mean and phasors of T and Z for each of the cylinder's diagrams [N], at shaft angle zero.
    weights : tuple of c callables
        Speeds and load to the weight of each of these diagrams (S, D).
    inertia : complex ndarray of shape (K + 1, c, 2)
        Mean and phasors of T and Z of moving masses, per square of the speed [N s^2/rad^2].
    takes_load : bool
        Whether the gas depends on a load.
    one_diagram : str
        What is used at all speeds though it belongs to one: "pressure diagram", "torque diagram", or ""
        for nothing.
    remarks : tuple of str
    """

    orders: FloatArray
    crank_radius: float
    throws: tuple[int, ...]
    gas: tuple[ComplexArray, ...]
    weights: tuple[Weights, ...]
    inertia: ComplexArray
    takes_load: bool
    one_diagram: str
    remarks: tuple[str, ...]

    def phasors(self, speeds: FloatArray, load: Load | None = None) -> ComplexArray:
        """Return mean and phasors of T and Z of each cylinder, (K + 1, S, c, 2) [N].

        Raises
        ------
        InputError
            If a speed is not a finite number or too high, a speed or load is outside a pressure map,
            or a load is given but not needed.
        """
        speeds = np.atleast_1d(turning_speeds("speeds", speeds))
        if load is not None and not self.takes_load:
            raise InputError(
                "load: given without a pressure map; allowed is none, because a single diagram has no load."
            )
        found = speeds[:, np.newaxis, np.newaxis] ** 2 * self.inertia[:, np.newaxis]
        known: dict[int, FloatArray] = {}
        for place, (of_diagrams, weigh) in enumerate(zip(self.gas, self.weights, strict=True)):
            if id(weigh) not in known:
                known[id(weigh)] = weigh(speeds, load)
            found[:, :, place] += np.tensordot(known[id(weigh)], of_diagrams, axes=1).swapaxes(0, 1)
        return found

    def at(
        self, speed: float | ArrayLike, load: Load | None = None, *, shaft_angle_deg: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Return T and Z over shaft angles, as the sum of mean and all orders.

        Parameters
        ----------
        speed : number or array_like of shape (m,)
            Of the shaft [rad/s]: the inertia forces are proportional to its square, and a pressure map is
            evaluated at it.
        load : optional
            As for `phasors`, at each of these speeds.
        shaft_angle_deg : array_like of shape (m,)
            [deg].

        Returns
        -------
        tangential, radial : ndarray of shape (m, c)
            [N].

        Raises
        ------
        InputError
            As `phasors`, and if an angle or speed is not a finite number.
        """
        angles = radians_of("shaft_angle_deg", shaft_angle_deg, vector=True)
        if np.ndim(speed) == 0:
            single = cast(float, speed)
            running = np.array([nonnegative_number("speed", single, "rad/s", "the shaft turns")])
        else:
            running = over_angles("speed", turning_speeds("speed", speed), angles)
        turning = np.exp(1j * np.outer(angles, np.concatenate(([0.0], self.orders))))
        found = self.phasors(running, load)
        if running.size == 1:
            total = np.tensordot(turning, found[:, 0], axes=1).real
        else:
            total = np.einsum("mk,kmcx->mcx", turning, found).real
        return total[..., 0], total[..., 1]


def cylinder_harmonics(
    engine: EngineLayout,
    orders: ArrayLike | float,
    pressure: Pressures | None = None,
    *,
    misfire: Mapping[int, float] | None = None,
    motored: Pressures | None = None,
    model: RodModelName = "rigid",
    inertia: bool = True,
    samples: int = DEFAULT_SAMPLES,
    throws: Sequence[int] | None = None,
    crankcase_pressure: float = ATMOSPHERE,
) -> CylinderHarmonics:
    """Find the harmonics of the force of every cylinder on its crankpin, for any speed.

    Parameters
    ----------
    engine, orders, pressure, misfire, motored, model, inertia, samples, throws, crankcase_pressure
        As for `cylinder_forces`.

    Returns
    -------
    CylinderHarmonics

    Raises
    ------
    InputError
        As `cylinder_forces`, except for speeds and loads.
    """
    count = whole_number("samples", samples, 3, "fewer show no harmonic")
    asked = requested_orders(orders, engine.strokes)
    places = order_indices(asked, engine.strokes, count, "the force diagrams")
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    angles = even_angles(cycle_radians(engine.strokes), count)
    kept = np.concatenate(([0], places))
    cylinders = len(engine.cylinders)
    none = np.zeros((kept.size, cylinders, 2), dtype=np.complex128)
    gas = [none[np.newaxis, :, 0]] * cylinders
    sources: tuple[GasSource, ...] = ()
    if pressure is not None:
        sources = gas_sources(engine, pressure, misfire, motored)
        known = [source.samples for source in sources if source.samples is not None]
        if known:
            order_indices(asked, engine.strokes, min(known), "the pressure diagrams")
        per_force = _pin_forces(
            mechanism_forces(engine, 0.0, 1.0, model=model, shaft_angles_deg=np.degrees(angles))
        )
        for place, (source, cylinder) in enumerate(zip(sources, engine.cylinders, strict=True)):
            since_firing = angles - np.radians(engine.firing_deg[place])
            above = np.array(
                [
                    diagram.at(angle_deg=np.degrees(since_firing)) - under
                    for diagram in source.diagrams
                ]
            )
            forces = cylinder.area * above[:, np.newaxis] * per_force[place]
            gas[place] = phasors_of_samples(forces)[..., kept].swapaxes(1, 2)
    elif misfire:
        raise InputError(
            "misfire: given without a pressure; allowed is none, because an engine without gas forces "
            "does not fire."
        )
    return CylinderHarmonics(
        orders=read_only(asked),
        crank_radius=engine.crank_radius,
        throws=throw_of_each(engine, throws),
        gas=tuple(gas),
        weights=tuple(own.weights for own in sources) or (constant_weight,) * cylinders,
        inertia=_inertia_phasors(engine, asked, model) if inertia else none,
        takes_load=any(source.takes_load for source in sources),
        one_diagram=_one_diagram([own.at_all_speeds for own in sources]),
        remarks=tuple(dict.fromkeys(text for source in sources for text in source.remarks)),
    )


def _one_diagram(at_all_speeds: Sequence[bool]) -> str:
    """State what is used at all speeds: the pressure of all cylinders, that of some, or nothing."""
    if at_all_speeds and all(at_all_speeds):
        return "pressure diagram"
    some = [str(number) for number, own in enumerate(at_all_speeds, start=1) if own]
    return f"pressure diagram of cylinder {', '.join(some)}" if some else ""


def throw_of_each(engine: EngineLayout, throws: Sequence[int] | None) -> tuple[int, ...]:
    """Return the throw of each cylinder from 0, given or found from the layout.

    Raises
    ------
    InputError
        If given throws do not fit the cylinders.
    """
    groups = throws_along_shaft(engine) if throws is None else checked_throws(engine, throws)
    found = {number: throw for throw, group in enumerate(groups) for number in group}
    return tuple(found[number] for number in range(1, len(engine.cylinders) + 1))


def _pin_forces(forces: MechanismForces) -> FloatArray:
    """Return T and Z of each cylinder (c, 2, m)."""
    return np.stack((forces.tangential, forces.radial), axis=1)


def _inertia_phasors(engine: EngineLayout, orders: FloatArray, model: RodModelName) -> ComplexArray:
    """Return mean and phasors of T and Z per square of the speed, which repeat every revolution."""
    whole = np.flatnonzero(orders == np.round(orders))
    angles = even_angles(TURN, max(INERTIA_SAMPLES, 2 * int(orders[-1]) + 3))
    forces = phasors_of_samples(
        _pin_forces(
            mechanism_forces(engine, 1.0, 0.0, model=model, shaft_angles_deg=np.degrees(angles))
        )
    )
    found = np.zeros((orders.size + 1, len(engine.cylinders), 2), dtype=np.complex128)
    found[0] = forces[..., 0]
    found[1 + whole] = np.moveaxis(forces[..., orders[whole].astype(np.int64)], -1, 0)
    return found
