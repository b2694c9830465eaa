"""The gas pressure of a mechanism at the load of its speed."""

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray
from crankfem.files.engine.mechanism_file import MechanismFile
from crankfem.files.sections.cylinder_pressures import full_load_cycles
from crankfem.files.sections.load_pressures import (
    LoadCurve,
    load_curve,
    load_speeds,
    pressures_along,
)
from dynamics.excitation.pressure_map import PressureMap
from dynamics.gas.pressure import GasPressure


def full_load_only(mechanism: MechanismFile) -> bool:
    """Return whether the load is full load at all speeds, as without a section [load]."""
    return mechanism.gas is None or mechanism.load is None or mechanism.load.law == "constant"


def curve_at(mechanism: MechanismFile, speeds: FloatArray) -> LoadCurve:
    """Return the pressures that the cycles reach at speeds [rad/s].

    Raises
    ------
    InputError
        If a speed is beyond the points of the load.
    """
    assert mechanism.gas is not None
    assert mechanism.load is not None
    friction = 0.0 if mechanism.power is None else mechanism.power.friction_pressure
    full = full_load_cycles(mechanism.gas, mechanism.layout)[0]
    return load_curve(mechanism.load, full, mechanism.rated_speed, speeds, friction)


def pressure_maps(
    mechanism: MechanismFile, speed_range: tuple[float, float], *, motored: bool = False
) -> tuple[PressureMap, ...]:
    """Return the pressure in each cylinder over a range of speeds [rad/s].

    Raises
    ------
    InputError
        If a cycle cannot reach the load.
    """
    assert mechanism.gas is not None
    assert mechanism.load is not None
    speeds = load_speeds(mechanism.load, mechanism.rated_speed, speed_range)
    curve = curve_at(mechanism, speeds)
    return pressures_along(curve, mechanism.gas, mechanism.layout, motored=motored)


def pressures_at(
    mechanism: MechanismFile, speeds: ArrayLike, *, motored: bool = False
) -> tuple[tuple[GasPressure, ...], ...]:
    """Return the pressure in each cylinder at the load of each speed.

    Parameters
    ----------
    mechanism : MechanismFile
        With a section [load] that is not full load at all speeds.
    speeds : (S,) array_like
        Ascending [rad/s].
    motored : bool, optional
        Without combustion, at the boost of this load.

    Raises
    ------
    InputError
        If a speed is beyond the points of the load, or a cycle cannot reach it.
    """
    assert mechanism.gas is not None
    curve = curve_at(mechanism, np.asarray(speeds, dtype=np.float64))
    maps = pressures_along(curve, mechanism.gas, mechanism.layout, motored=motored)
    return tuple(zip(*(one.diagrams for one in maps), strict=True))
