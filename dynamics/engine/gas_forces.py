"""Gas forces on all pistons of an engine from the pressures in its cylinders."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import FloatArray, nonnegative_number
from crankbase.errors import InputError
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import parts_motion
from dynamics.engine.orders import checked_cylinder
from dynamics.gas.pressure import ATMOSPHERE


class Pressure(Protocol):
    """A pressure over the working cycle."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle, 2 or 4."""
        ...

    def at(self, *, angle_deg: ArrayLike) -> FloatArray:
        """Return the absolute pressure [Pa] at angles [deg] from the firing top."""
        ...


def gas_forces(
    engine: EngineLayout,
    pressure: Pressure | Sequence[Pressure],
    crankcase_pressure: float = ATMOSPHERE,
    *,
    shaft_angles_deg: ArrayLike,
) -> FloatArray:
    """Return the gas force on each piston towards the shaft.

    Parameters
    ----------
    engine : EngineLayout
    pressure : GasPressure or sequence of n GasPressure
        One for all cylinders, each counted from its own firing top, or one for each cylinder.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa].
    shaft_angles_deg : array_like of shape (m,)
        [deg]

    Returns
    -------
    ndarray of shape (n, m)
        (p - p_crankcase) times piston area [N].

    Raises
    ------
    InputError
        If there is not one pressure for each cylinder, or its cycle has other strokes.
    """
    angles = radians_of("shaft_angles_deg", shaft_angles_deg, vector=True)
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    count = len(engine.cylinders)
    pressures = list(pressure) if isinstance(pressure, Sequence) else [pressure] * count
    if len(pressures) != count:
        raise InputError(
            f"pressure: given {len(pressures)} for {count} cylinders; allowed is one for all, or one "
            "for each cylinder, because each piston has its own force."
        )
    forces = []
    for cylinder, firing, own in zip(
        engine.cylinders, np.radians(engine.firing_deg), pressures, strict=True
    ):
        if own.strokes != engine.strokes:
            raise InputError(
                f"pressure: given a cycle of {own.strokes} strokes; allowed is {engine.strokes}, because "
                "that is the engine's."
            )
        forces.append(cylinder.area * (own.at(angle_deg=np.degrees(angles - firing)) - under))
    return np.array(forces)


def piston_position(engine: EngineLayout, number: int) -> Callable[[FloatArray], FloatArray]:
    """Return the position of a cylinder's piston over the angle from its firing top.

    Parameters
    ----------
    engine : EngineLayout
    number : int
        Of the cylinder, from 1.

    Returns
    -------
    callable
        Angles [rad] of shape (m,) to positions of the piston pin along the cylinder axis, away from the
        shaft [m], as required by `gas_cycle`.

    Raises
    ------
    InputError
        If the engine has no such cylinder.
    """
    own = checked_cylinder(engine, number)
    firing = np.radians(engine.firing_deg[own - 1])
    return lambda angle: parts_motion(engine, own, firing + angle).piston.place.real
