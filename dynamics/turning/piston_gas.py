"""Gas forces on the pistons of a free-running engine, angle by angle."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crankbase.checks.arrays import FloatArray
from dynamics.cycle import cycle_radians
from dynamics.engine.gas_forces import Pressure, gas_forces
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import piston_ends

# Force on a piston towards the shaft [N]: of the cylinder's number, the piston's place (0 lowest to
# 1 highest), its direction (1 away from the shaft, -1 towards it), and the angle from the
# cylinder's firing top [rad].
PistonForce = Callable[[int, float, Literal[-1, 1], float], float]
Gas = Pressure | Sequence[Pressure] | PistonForce | None


@dataclass(frozen=True, eq=False)
class PistonGas:
    """The gas in all cylinders.

    Parameters
    ----------
    forces : callable
        (shaft angle [rad], pistons' s (n,) [m], directions (n,)) -> forces towards the shaft (n,)
        [N].
    turns_at_ends : bool
        Whether the forces may jump where a piston changes its direction.
    """

    forces: Callable[[float, FloatArray, FloatArray], FloatArray]
    turns_at_ends: bool


def piston_gas(engine: EngineLayout, gas: Gas, crankcase_pressure: float) -> PistonGas:
    """Return the gas forces from pressures, or from a function of the piston's position and direction.

    Raises
    ------
    InputError
        If there is not one pressure for each cylinder, or its cycle has other strokes.
    """
    if gas is None:
        return PistonGas(_no_forces, False)
    if callable(gas):
        return PistonGas(_from_places(engine, gas), True)
    # Refuses what does not fit.
    gas_forces(engine, gas, crankcase_pressure, shaft_angles_deg=[0.0])
    return PistonGas(_from_pressures(engine, gas, crankcase_pressure), False)


def _no_forces(_angle: float, places: FloatArray, _directions: FloatArray) -> FloatArray:
    return np.zeros(places.shape)


def _from_pressures(
    engine: EngineLayout, gas: Pressure | Sequence[Pressure], crankcase_pressure: float
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    count = len(engine.cylinders)
    pressures = list(gas) if isinstance(gas, Sequence) else [gas] * count
    areas = np.array([cylinder.area for cylinder in engine.cylinders])
    firing = np.radians(engine.firing_deg)
    # Cylinders with the same pressure are asked for together.
    groups: dict[int, tuple[Pressure, list[int]]] = {}
    for place, own in enumerate(pressures):
        groups.setdefault(id(own), (own, []))[1].append(place)

    def forces(angle: float, _places: FloatArray, _directions: FloatArray) -> FloatArray:
        found = np.empty(count)
        for pressure, members in groups.values():
            found[members] = pressure.at(angle_deg=np.degrees(angle - firing[members]))
        return np.asarray(areas * (found - crankcase_pressure))

    return forces


def _from_places(
    engine: EngineLayout, force: PistonForce
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    count = len(engine.cylinders)
    lowest, highest = np.array([piston_ends(engine, number + 1) for number in range(count)]).T
    firing, cycle = np.radians(engine.firing_deg), cycle_radians(engine.strokes)

    def forces(angle: float, places: FloatArray, directions: FloatArray) -> FloatArray:
        positions = np.clip((places - lowest) / (highest - lowest), 0.0, 1.0).tolist()
        since_firing = ((angle - firing) % cycle).tolist()
        return np.array(
            [
                force(place + 1, positions[place], 1 if way > 0.0 else -1, since_firing[place])
                for place, way in enumerate(directions.tolist())
            ],
            dtype=np.float64,
        )

    return forces
