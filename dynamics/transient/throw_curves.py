"""Inertia of rods and pistons, and torque of gas, of each throw as functions of its own angle."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray
from dynamics.chains.throw_inertias import cylinder_inertia
from dynamics.engine.forces import rod_models
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.cylinders import CylinderForces
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.transient.order_forces import cycle_turns
from dynamics.turning.curves import TurnCurves, turn_curves

# Harmonics of the inertia below this share of its mean are left out.
NEGLIGIBLE = 1e-14


@dataclass(frozen=True, eq=False)
class ThrowCurves:
    """Curves of t throws, each over its own angle: y = mean + Re sum of a_k exp(i k theta).

    Parameters
    ----------
    orders : ndarray of shape (K,)
        k, those of inertia and torque together.
    inertia_mean : ndarray of shape (t,)
        Of rods and pistons [kg m^2].
    inertia : complex ndarray of shape (t, K)
        Its harmonics.
    torque_mean : ndarray of shape (t,)
        Of the gas [N m].
    torque : complex ndarray of shape (t, K)
        Its harmonics.
    """

    orders: FloatArray
    inertia_mean: FloatArray
    inertia: ComplexArray
    torque_mean: FloatArray
    torque: ComplexArray

    def at(self, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return inertia, its derivative by the angle, and torque at angles (c, t), each of that shape."""
        table = self._table
        # Waves of all orders by repeated multiplication: it costs a tenth of exponentials.
        waves = np.empty((*angles.shape, table.shape[1]), dtype=np.complex128)
        waves[...] = np.exp(1j * self._step * angles)[..., np.newaxis]
        waves = np.cumprod(waves, axis=-1)
        found = np.matmul(waves.swapaxes(0, 1), table).real
        inertia = self.inertia_mean + found[..., 0].T
        return inertia, found[..., 1].T, self.torque_mean + found[..., 2].T

    @cached_property
    def _step(self) -> float:
        """Order of which all orders are multiples."""
        return 1.0 / cycle_turns(self.orders) if self.orders.size else 1.0

    @cached_property
    def _table(self) -> ComplexArray:
        """Harmonics of inertia, its derivative and torque at all multiples of the step, (t, N, 3)."""
        places = np.round(self.orders / self._step).astype(int) - 1
        count = int(places.max(initial=0)) + 1
        table = np.zeros((self.inertia_mean.size, count, 3), dtype=np.complex128)
        table[:, places, 0] = self.inertia
        table[:, places, 1] = 1j * self.orders * self.inertia
        table[:, places, 2] = self.torque
        return table

    def with_constant_inertia(self) -> "ThrowCurves":
        """Return the same with the inertia at its mean."""
        return replace(self, inertia=np.zeros_like(self.inertia))


def throw_inertia_curves(
    engine: EngineLayout, throws: Sequence[int], model: RodModelName = "rigid"
) -> TurnCurves:
    """Return the inertia of rods and pistons on each throw over its angle, as series.

    Parameters
    ----------
    engine : EngineLayout
    throws : sequence of n int
        Throw of each cylinder, from 0.
    model : str, optional
        Of the rods.

    Raises
    ------
    InputError
        If there is no such model, or a rod is so short that its harmonics do not decay.
    """
    models = rod_models(engine, model)

    def sampled(angles: FloatArray) -> FloatArray:
        inertia = np.zeros((max(throws) + 1, angles.size))
        for place, (throw, rod) in enumerate(zip(throws, models, strict=True)):
            inertia[throw] += cylinder_inertia(engine, place + 1, rod, angles)
        return inertia

    return turn_curves(sampled)


def throw_curves(
    engine: EngineLayout, forces: CylinderForces, speed_index: int, model: RodModelName = "rigid"
) -> ThrowCurves:
    """Return the curves of an engine's throws from its gas forces at one of their speeds."""
    found = throw_inertia_curves(engine, forces.throws, model)
    largest = np.max(np.abs(found.coefficients) / found.mean[:, np.newaxis], axis=0, initial=0.0)
    kept = np.flatnonzero(largest > NEGLIGIBLE)
    throws = found.mean.size
    mean, phasors = np.zeros(throws), np.zeros((forces.orders.size, throws), dtype=np.complex128)
    for cylinder, throw in enumerate(forces.throws):
        mean[throw] += forces.crank_radius * forces.mean_tangential[speed_index, cylinder]
        phasors[:, throw] += forces.torque[:, speed_index, cylinder]
    of_inertia = np.asarray(kept + 1.0, dtype=np.float64)
    orders = np.union1d(of_inertia, forces.orders)
    return ThrowCurves(
        orders,
        found.mean,
        _placed(found.coefficients[:, kept], of_inertia, orders),
        mean,
        _placed(phasors.T, forces.orders, orders),
    )


def _placed(values: ComplexArray, orders: FloatArray, among: FloatArray) -> ComplexArray:
    placed = np.zeros((len(values), among.size), dtype=np.complex128)
    placed[:, np.searchsorted(among, orders)] = values
    return placed
