"""Samples over an engine's working cycle: shaft angles, gas forces there, and their harmonics."""

from collections.abc import Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from dynamics.cycle import cycle_radians, even_angles
from dynamics.engine.forces import MechanismForces, mechanism_forces
from dynamics.engine.gas_forces import Pressure, gas_forces
from dynamics.engine.layout import EngineLayout
from dynamics.harmonics import Harmonics, harmonics
from dynamics.mechanism.rod_model_names import RodModelName

# Steps of 0.5 deg over 720 deg resolve orders up to 360, those over 360 deg of twice that.
DEFAULT_SAMPLES = 1440


def samples_and_gas(
    engine: EngineLayout,
    pressure: Pressure | Sequence[Pressure] | ArrayLike | None,
    samples: int,
    crankcase_pressure: float,
) -> tuple[FloatArray, FloatArray]:
    """Return shaft angles evenly over a cycle (m,) [rad], and forces on the pistons (n, m) [N].

    Raises
    ------
    InputError
        If there are less than 3 samples, or pressures or forces do not fit.
    """
    count = whole_number("samples", samples, 3, "fewer show no harmonic")
    angles = even_angles(cycle_radians(engine.strokes), count)
    shape = (len(engine.cylinders), count)
    if pressure is None:
        return angles, np.zeros(shape)
    if _are_pressures(pressure):
        return angles, gas_forces(
            engine, pressure, crankcase_pressure, shaft_angles_deg=np.degrees(angles)
        )
    given = finite_array("pressure", np.asarray(pressure))
    if given.shape != shape:
        raise InputError(
            f"pressure: given forces of shape {given.shape}; allowed is {shape}, because there is one "
            "for each cylinder and sample."
        )
    return angles, given


def forces_by_cause(
    engine: EngineLayout, speed: float, angles: FloatArray, gas: FloatArray, model: RodModelName
) -> tuple[MechanismForces, MechanismForces]:
    """Return the forces in the mechanism of the gas alone, and of moving masses alone."""
    running = nonnegative_number("speed", speed, "rad/s", "the shaft turns forward")
    of_gas = mechanism_forces(engine, 0.0, gas, model=model, shaft_angles_deg=np.degrees(angles))
    return of_gas, mechanism_forces(
        engine, running, model=model, shaft_angles_deg=np.degrees(angles)
    )


def _are_pressures(
    given: "Pressure | Sequence[Pressure] | ArrayLike",
) -> TypeGuard["Pressure | Sequence[Pressure]"]:
    first = given[0] if isinstance(given, Sequence) and given else given
    return hasattr(first, "at")


def from_firing_top(
    engine: EngineLayout, place: int, angles: FloatArray, values: FloatArray
) -> Harmonics:
    """Return the harmonics of a cylinder's values (m,), its index from 0, counted from its firing top."""
    since_firing = np.degrees(angles - np.radians(engine.firing_deg[place]))
    return harmonics(values, engine.strokes, angles_deg=since_firing)
