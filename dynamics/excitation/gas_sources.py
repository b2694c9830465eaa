"""Sources of the gas pressure in each cylinder: diagrams, and their weights over the speed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from crankbase.array_checks import FloatArray, nonnegative_number
from crankbase.errors import InputError
from dynamics.engine.forces import Pressure, pressure_of_each
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import checked_cylinder
from dynamics.excitation.pressure_map import Load, PressureMap
from dynamics.gas.pressure import GasPressure

# Pressure of one kind for all cylinders, or one for each.
AnyPressure = Pressure | PressureMap
Pressures = AnyPressure | Sequence[AnyPressure]
Weights = Callable[[FloatArray, Load | None], FloatArray]


@dataclass(frozen=True, eq=False)
class GasSource:
    """Diagrams whose weighted sum is the pressure in a cylinder.

    Parameters
    ----------
    weights : callable
        Speeds (S,) [rad/s] and load to the weight of each diagram (S, D).
    """

    diagrams: tuple[Pressure, ...]
    weights: Weights
    takes_load: bool
    at_all_speeds: bool

    @property
    def samples(self) -> int | None:
        """Samples over the cycle of the coarsest diagram, None if none is sampled."""
        known = [
            diagram.angles_deg.size for diagram in self.diagrams if isinstance(diagram, GasPressure)
        ]
        return min(known, default=None)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Changes made to the diagrams."""
        return tuple(text for diagram in self.diagrams for text in getattr(diagram, "remarks", ()))


def gas_sources(
    engine: EngineLayout,
    pressure: Pressures,
    misfire: Mapping[int, float] | None = None,
    motored: Pressures | None = None,
) -> tuple[GasSource, ...]:
    """Return the source of the pressure in each cylinder; equal sources are one object."""
    fired = _one_for_each("pressure", pressure, engine)
    failing = {
        checked_cylinder(engine, number): _share(number, share)
        for number, share in (misfire or {}).items()
    }
    if not failing:
        return tuple(fired)
    if motored is None:
        raise InputError(
            f"motored: given none for misfire in cylinder {min(failing)}; allowed is the pressure without "
            "combustion (of the cycle model with heat=0, measured, or by `motored_from_compression`), "
            "because a fired diagram alone does not define it."
        )
    cold = _one_for_each("motored", motored, engine)
    made: dict[tuple[int, int, float], GasSource] = {}
    for number, share in failing.items():
        both = fired[number - 1], cold[number - 1]
        key = (id(both[0]), id(both[1]), share)
        fired[number - 1] = made.setdefault(key, _mixed(*both, share))
    return tuple(fired)


def _one_for_each(field: str, pressure: Pressures, engine: EngineLayout) -> list[GasSource]:
    pressures = pressure_of_each(field, pressure, engine)
    made = {id(each): _source(each) for each in pressures}
    return [made[id(each)] for each in pressures]


def _source(pressure: AnyPressure) -> GasSource:
    if isinstance(pressure, PressureMap):
        return GasSource(pressure.diagrams, pressure.weights, True, False)
    return GasSource((pressure,), constant_weight, False, True)


def constant_weight(speeds: FloatArray, _load: Load | None) -> FloatArray:
    """Return the constant weight of a diagram that is used at every speed."""
    return np.ones((speeds.size, 1))


def _share(number: int, share: float) -> float:
    missing = nonnegative_number(f"misfire[{number}]", share, "", "it is a share of the combustion")
    if missing > 1.0:
        raise InputError(
            f"misfire[{number}]: given {missing:g}; allowed is 0 to 1, because it is the share of the "
            "combustion that is missing."
        )
    return missing


def _mixed(fired: GasSource, cold: GasSource, share: float) -> GasSource:
    """Return the source of a cylinder that lacks a share of its combustion."""
    return GasSource(
        fired.diagrams + cold.diagrams,
        partial(_mixed_weights, fired, cold, share),
        fired.takes_load or cold.takes_load,
        fired.at_all_speeds or cold.at_all_speeds,
    )


def _mixed_weights(
    fired: GasSource, cold: GasSource, share: float, speeds: FloatArray, load: Load | None
) -> FloatArray:
    left = (1.0 - share) * fired.weights(speeds, load)
    return np.hstack([left, share * cold.weights(speeds, load)])
