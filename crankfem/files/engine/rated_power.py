"""Indicated power of an engine at rated speed, and whether its rated power is consistent."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.summaries import summarized
from crankbase.units.quantity import format_quantity
from crankfem.files.sections.engine_sections import Engine
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import piston_ends
from dynamics.gas.cylinder_volume import indicated_work, periodic_slope
from dynamics.gas.pressure import GasPressure

# Rated power beside the indicated one: 0.75 in small old engines, 0.97 in slow-running crosshead ones.
LOWEST_EFFICIENCY, HIGHEST_EFFICIENCY = 0.75, 0.97


@summarized(
    "indicated [W]",
    "mean_indicated_pressure [Pa]",
    "rated [W]",
    "mean_effective_pressure [Pa]",
    "mechanical_efficiency",
)
@dataclass(frozen=True)
class EnginePower:
    """Power of an engine at rated speed.

    Attributes
    ----------
    speed : float
        Rated speed [rad/s].
    indicated : float
        Power of the gas on all pistons [W].
    mean_indicated_pressure : float
        Work of the gas per swept volume, mean of all cylinders [Pa].
    rated : float or None
        Power at the flywheel [W]; None if the file does not give it.
    """

    speed: float
    indicated: float
    mean_indicated_pressure: float
    rated: float | None

    @property
    def mechanical_efficiency(self) -> float | None:
        """Rated over indicated power; None without a rated power, or if the gas does no work."""
        if self.rated is None or self.indicated <= 0.0:
            return None
        return self.rated / self.indicated

    @property
    def mean_effective_pressure(self) -> float | None:
        """Mean effective pressure of the rated power [Pa]; None if the file does not give it."""
        efficiency = self.mechanical_efficiency
        return None if efficiency is None else efficiency * self.mean_indicated_pressure

    @property
    def friction_pressure(self) -> float:
        """Friction mean pressure [Pa]; zero if the rated power is unknown or inconsistent."""
        if self.mean_effective_pressure is None or not self.consistent:
            return 0.0
        return self.mean_indicated_pressure - self.mean_effective_pressure

    @property
    def consistent(self) -> bool:
        """Whether the mechanical efficiency is plausible; True if it is unknown."""
        if self.rated is None:
            return True
        efficiency = self.mechanical_efficiency
        return efficiency is not None and LOWEST_EFFICIENCY <= efficiency <= HIGHEST_EFFICIENCY

    @property
    def sentence(self) -> str:
        """Indicated power and its ratio to the rated power."""
        speed = format_quantity(self.speed, "rad/s", 5)
        indicated = (
            f"indicated power {_kilowatts(self.indicated)} at {speed}, mean indicated pressure "
            f"{format_quantity(self.mean_indicated_pressure, 'Pa', 4)}"
        )
        if self.rated is None:
            return (
                f"{indicated}; engine.rated_power is not given, so the gas pressure is not checked"
            )
        if self.mechanical_efficiency is None or self.mean_effective_pressure is None:
            return (
                f"The file is inconsistent: rated power {_kilowatts(self.rated)}, but {indicated}; correct "
                "the section [gas], because no engine drives with gas that does no work"
            )
        effective = (
            f"rated power {_kilowatts(self.rated)} (mean effective pressure "
            f"{format_quantity(self.mean_effective_pressure, 'Pa', 4)})"
        )
        share = f"{self.mechanical_efficiency:.3g}"
        if self.consistent:
            return f"{indicated}; {effective} is {share} of it, the mechanical efficiency"
        return (
            f"The file is inconsistent: {effective} is {share} of the {indicated}; usual mechanical "
            f"efficiencies are {LOWEST_EFFICIENCY:g} to {HIGHEST_EFFICIENCY:g}, so correct "
            "engine.rated_power or the section [gas]"
        )


def engine_power(
    engine: Engine, layout: EngineLayout, pressures: Sequence[GasPressure]
) -> EnginePower:
    """Return the power of an engine at rated speed.

    Parameters
    ----------
    engine : Engine
        The section of the engine file.
    layout : EngineLayout
    pressures : sequence of n GasPressure
        Of each cylinder at full load.
    """
    power, mean = indicated_power(layout, pressures, engine.rated_speed)
    return EnginePower(engine.rated_speed, power, mean, engine.rated_power)


def indicated_power(
    layout: EngineLayout, pressures: Sequence[GasPressure], speed: float
) -> tuple[float, float]:
    """Return indicated power [W] and mean indicated pressure [Pa] of all cylinders at a speed [rad/s]."""
    work = swept = 0.0
    for number, (cylinder, pressure) in enumerate(
        zip(layout.cylinders, pressures, strict=True), start=1
    ):
        low, high = piston_ends(layout, number)
        swept += cylinder.area * (high - low)
        slope = periodic_slope(
            piston_position(layout, number)(np.radians(pressure.angles_deg)),
            cycle_radians(pressure.strokes),
        )
        work += indicated_work(pressure.pressure, -cylinder.area * slope, layout.strokes)
    cycles = speed / (math.pi * layout.strokes)
    return work * cycles, work / swept


def _kilowatts(power: float) -> str:
    return f"{power / 1e3:.4g} kW"
