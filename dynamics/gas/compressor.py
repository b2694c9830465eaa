"""The pressure in the cylinder of a reciprocating compressor with ideal valves."""

import math
from dataclasses import dataclass

import numpy as np

from crankbase.array_checks import positive_number
from crankbase.errors import InputError
from crankbase.sentences import amount
from dynamics.cycle import even_angles
from dynamics.gas.gas_cycle import SAMPLES_PER_TURN
from dynamics.gas.pressure import GasPressure, Position, cylinder_volume


@dataclass(frozen=True)
class CompressorCycle:
    """Suction, compression, delivery and re-expansion in each revolution; valves open without loss.

    Parameters
    ----------
    suction_pressure, discharge_pressure : float
        Absolute [Pa].
    clearance : float
        Smallest volume over the swept one.
    exponent : float
        n of p V^n = const, of compression and of re-expansion.

    Raises
    ------
    InputError
        If a value is not above zero, the discharge pressure not above that of suction, or the compressor
        delivers nothing.

    Notes
    -----
    With the smallest volume V_c, the largest V_m = V_c + V_s and r = p_d / p_s,

        p = max(p_s, p_d (V_c / V)^n) from the top to the bottom,
        p = min(p_d, p_s (V_m / V)^n) from there to the top.

    It takes in V_s (1 + c - c r^(1/n)) = V_s e, c = V_c / V_s, and the gas does the work
    -p_s V_s e n / (n - 1) (r^((n - 1) / n) - 1) in each revolution, -p_s V_s e ln r with n = 1.
    """

    suction_pressure: float
    discharge_pressure: float
    clearance: float
    exponent: float

    def __post_init__(self) -> None:
        for name, unit in (
            ("suction_pressure", "Pa"),
            ("discharge_pressure", "Pa"),
            ("clearance", ""),
            ("exponent", ""),
        ):
            positive_number(name, getattr(self, name), unit, "it is that of a gas in a cylinder")
        discharged, taken = (
            amount(pressure, "Pa") for pressure in (self.discharge_pressure, self.suction_pressure)
        )
        if self.discharge_pressure <= self.suction_pressure:
            raise InputError(
                f"discharge_pressure: given {discharged}; allowed is more than suction_pressure, {taken}, "
                "because the machine compresses."
            )
        if self.volumetric_efficiency <= 0.0:
            most = self.suction_pressure * (1.0 + 1.0 / self.clearance) ** self.exponent
            raise InputError(
                f"discharge_pressure: given {discharged} with a suction_pressure of {taken}; allowed is less "
                f"than {amount(most, 'Pa', 4)}, because with a clearance of {self.clearance:g} the "
                "gas left in the cylinder fills it when it expands, and nothing is taken in."
            )

    @property
    def volumetric_efficiency(self) -> float:
        """Volume taken in per swept volume, at suction pressure."""
        ratio = self.discharge_pressure / self.suction_pressure
        return 1.0 + self.clearance * (1.0 - math.pow(ratio, 1.0 / self.exponent))

    def pressure(self, position: Position, area: float) -> GasPressure:
        """Return the pressure over a revolution.

        Parameters
        ----------
        position : callable
            Of the piston, as of `cylinder_volume`.
        area : float
            Piston area [m^2].
        """
        volume = cylinder_volume(position, area, 1.0 + 1.0 / self.clearance)
        angles_deg = even_angles(360.0, SAMPLES_PER_TURN)
        now = volume.at(angle_deg=angles_deg)
        expanded, compressed = (
            pressure * (start / now) ** self.exponent
            for pressure, start in (
                (self.discharge_pressure, volume.clearance),
                (self.suction_pressure, volume.clearance + volume.swept),
            )
        )
        downwards = (angles_deg - volume.top_angle_deg) % 360.0 < (
            volume.bottom_angle_deg - volume.top_angle_deg
        ) % 360.0
        pressure = np.where(
            downwards,
            np.maximum(expanded, self.suction_pressure),
            np.minimum(compressed, self.discharge_pressure),
        )
        return GasPressure(angles_deg, pressure, 2, source="compressor cycle with ideal valves")
