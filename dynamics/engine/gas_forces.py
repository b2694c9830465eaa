"""Gas forces on all pistons of an engine from the pressures in its cylinders."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_vector, nonnegative_number
from crankbase.errors import InputError
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import cylinder_motion
from dynamics.engine.orders import checked_cylinder
from dynamics.gas.pressure import ATMOSPHERE


class Pressure(Protocol):
    """A pressure over the working cycle."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle, 2 or 4."""
        ...

    def at(self, angle: ArrayLike) -> FloatArray:
        """Return the absolute pressure [Pa] at angles [rad] from the firing top."""
        ...


def gas_forces(
    engine: EngineLayout,
    shaft_angles: ArrayLike,
    pressure: Pressure | Sequence[Pressure],
    crankcase_pressure: float = ATMOSPHERE,
) -> FloatArray:
    """Return the gas force on each piston towards the shaft.

    Parameters
    ----------
    engine : EngineLayout
    shaft_angles : array_like of shape (m,)
        [rad]
    pressure : GasPressure or sequence of n GasPressure
        One for all cylinders, each counted from its own firing top, or one for each cylinder.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa].

    Returns
    -------
    ndarray of shape (n, m)
        (p - p_crankcase) times piston area [N].

    Raises
    ------
    InputError
        If there is not one pressure for each cylinder, or its cycle has other strokes.
    """
    angles = finite_vector("shaft_angles", shaft_angles)
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    count = len(engine.cylinders)
    pressures = list(pressure) if isinstance(pressure, Sequence) else [pressure] * count
    if len(pressures) != count:
        raise InputError(
            f"pressure: given {len(pressures)} for {count} cylinders; allowed is one for all, or one "
            "for each cylinder, because each piston has its own force."
        )
    forces = []
    for cylinder, firing, own in zip(engine.cylinders, engine.firing, pressures, strict=True):
        if own.strokes != engine.strokes:
            raise InputError(
                f"pressure: given a cycle of {own.strokes} strokes; allowed is {engine.strokes}, because "
                "that is the engine's."
            )
        forces.append(cylinder.area * (own.at(angles - firing) - under))
    return np.array(forces)


def piston_position(engine: EngineLayout, number: int) -> Callable[[FloatArray], FloatArray]:
    """Return where a cylinder's piston stands over the angle from its firing top.

    Parameters
    ----------
    engine : EngineLayout
    number : int
        Of the cylinder, from 1.

    Returns
    -------
    callable
        Angles [rad] of shape (m,) to places of the piston pin along the cylinder axis, away from the
        shaft [m], as `gas_cycle` takes it.

    Raises
    ------
    InputError
        If the engine has no such cylinder.
    """
    own = checked_cylinder(engine, number)
    firing = engine.firing[own - 1]
    return lambda angle: cylinder_motion(engine, own, firing + angle).piston.place.real
