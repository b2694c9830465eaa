"""Periodic quantities of the shaft angle, for quick evaluation at any angle."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray
from dynamics.cycle import even_angles
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import parts_motion, reduced_inertia
from dynamics.engine.orders import turn_spectrum
from dynamics.mechanism.rods import RodModel

# Samples that show how large a curve is, and the share of that which counts as nothing.
SIZE_SAMPLES = 64
NEGLIGIBLE = 1e-17


@dataclass(frozen=True, eq=False)
class TurnCurves:
    """Several periodic curves as Fourier series, with derivatives.

    Parameters
    ----------
    mean : ndarray of shape (c,)
        Of each curve.
    coefficients : complex ndarray of shape (c, K)
        a_k of Re sum a_k exp(i k phi), k from 1.
    """

    mean: FloatArray
    coefficients: ComplexArray

    def at(self, angle: float) -> tuple[FloatArray, FloatArray]:
        """Return values and derivatives by the angle [rad] of all curves, each of shape (c,)."""
        numbers = np.arange(1, self.coefficients.shape[1] + 1)
        terms = np.exp(1j * angle * numbers)
        values = self.mean + (self.coefficients @ terms).real
        return values, -(self.coefficients @ (numbers * terms)).imag


def turn_curves(function: Callable[[FloatArray], FloatArray]) -> TurnCurves:
    """Return the series of curves over a revolution.

    Parameters
    ----------
    function : callable
        Takes angles (m,) [rad] and returns the curves' values (c, m).

    Raises
    ------
    InputError
        If a curve's harmonics do not decay.
    """
    largest = np.max(
        np.abs(function(even_angles(2.0 * np.pi, SIZE_SAMPLES))), axis=1, keepdims=True
    )
    # Each curve by its own size: inertias and lengths are not to be compared.
    scale = np.where(largest > 0.0, largest, 1.0)
    found = scale * turn_spectrum(lambda angles: function(angles) / scale, 1)
    half = found.shape[1] // 2
    terms = 2.0 * found[:, 1:half]
    above = np.flatnonzero(np.max(np.abs(terms) / scale, axis=0) > NEGLIGIBLE)
    needed = int(above[-1]) + 1 if above.size else 0
    return TurnCurves(found[:, 0].real.copy(), terms[:, :needed].copy())


def engine_curves(engine: EngineLayout, models: tuple[RodModel, ...]) -> TurnCurves:
    """Return the curves of an engine: positions of the n pistons, inertia, static moment upwards.

    Parameters
    ----------
    engine : EngineLayout
    models : tuple of n RodModel

    Returns
    -------
    TurnCurves
        c = n + 2: s of each piston pin [m]; inertia reduced to the shaft [kg m^2]; sum of masses
        times heights [kg m], which determines the work of gravity.

    Raises
    ------
    InputError
        If a rod is so short that no reasonable number of harmonics describes the motion.
    """
    return turn_curves(functools.partial(_engine_samples, engine, models))


def _engine_samples(
    engine: EngineLayout, models: tuple[RodModel, ...], angles: FloatArray
) -> FloatArray:
    places = []
    height = np.zeros(angles.shape)
    for number, (cylinder, model) in enumerate(zip(engine.cylinders, models, strict=True), start=1):
        motion = parts_motion(engine, number, angles)
        upwards = np.exp(1j * math.radians(cylinder.bank_angle_deg))
        places.append(motion.piston.place.real)
        height += cylinder.piston_mass * (upwards * motion.piston.place).real
        height += model.mass * (upwards * motion.rod_point(model.center).place).real
    for mass in engine.rotating:
        height += mass.static_moment * np.cos(math.radians(mass.angle_deg) + angles)
    inertia, _ = reduced_inertia(engine, models, shaft_angles_deg=np.degrees(angles))
    return np.array([*places, inertia, height])
