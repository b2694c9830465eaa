"""A two-stroke crosshead engine of one cylinder for hinge calculations, and its gas force."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number, positive_number
from crankbase.errors import InputError
from dynamics.engine.cylinder import EngineCylinder
from dynamics.engine.gas_forces import Pressure, gas_forces, piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.gas.cycle_values import usual_gas_cycle
from dynamics.gas.gas_cycle import GasCycleResult, gas_cycle
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.mechanism.rods import ConnectingRod
from dynamics.mechanism.slider_crank import check_reach

# Force on the piston towards the shaft [N] at crank angles [rad] of shape (m,).
GasForce = Callable[[FloatArray], FloatArray]
STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class CrossheadEngine:
    """A horizontal two-stroke engine of one cylinder with crosshead.

    Parameters
    ----------
    bore : float
        Diameter of the piston [m].
    crank_radius : float
        R, from shaft axis to crankpin [m].
    crank_mass : float
        Crank with the guides of the hinge [kg].
    crank_center_distance : float
        r_1, from the shaft axis to the crank's center of mass, on the side of the crankpin [m].
    crank_inertia : float
        Of crank and guides about the shaft axis [kg m^2].
    rod : ConnectingRod
        l_1 is its center distance.
    crosshead_mass, piston_rod_mass, piston_mass : float
        Mass that moves along the cylinder [kg].
    gravity : float, optional
        Acceleration of gravity across the cylinder axis, against the side to which the crankpin
        moves as it passes the top [m/s^2].

    Raises
    ------
    InputError
        If a length, mass or inertia is out of its range, the crank cannot complete a revolution, or no
        crank of that mass and center has that inertia.

    Examples
    --------
    >>> rod = ConnectingRod(1.55, 150.0, 0.8, 50.0)
    >>> engine = CrossheadEngine(0.3, 0.5, 80.0, 0.2, 30.0, rod, 150.0, 200.0, 110.0)
    >>> engine.sliding_mass, round(engine.crank_ratio, 4)
    (460.0, 0.3226)
    """

    bore: float
    crank_radius: float
    crank_mass: float
    crank_center_distance: float
    crank_inertia: float
    rod: ConnectingRod
    crosshead_mass: float
    piston_rod_mass: float
    piston_mass: float
    gravity: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        positive_number("bore", self.bore, "m", "it is a length")
        positive_number("crank_radius", self.crank_radius, "m", "it is a length")
        check_reach("crank_radius", self.crank_radius, self.rod.length, 0.0)
        for name in ("crank_mass", "crosshead_mass", "piston_rod_mass"):
            nonnegative_number(name, getattr(self, name), "kg", "it is a mass")
        positive_number("piston_mass", self.piston_mass, "kg", "it is a mass")
        positive_number("crank_inertia", self.crank_inertia, "kg m^2", "the crank has mass")
        finite_array("crank_center_distance", self.crank_center_distance)
        finite_array("gravity", self.gravity)
        least = self.crank_mass * self.crank_center_distance**2
        if self.crank_inertia < least:
            raise InputError(
                f"crank_inertia: given {self.crank_inertia:g} kg m^2; allowed is {least:g} kg m^2 or "
                f"more, because {self.crank_mass:g} kg with the center "
                f"{self.crank_center_distance:g} m from the axis have no less."
            )

    @property
    def area(self) -> float:
        """Area of the piston [m^2]."""
        return 0.25 * math.pi * self.bore**2

    @property
    def crank_ratio(self) -> float:
        """R / L, the papers' lambda."""
        return self.crank_radius / self.rod.length

    @property
    def sliding_mass(self) -> float:
        """Crosshead, piston rod and piston [kg]."""
        return self.crosshead_mass + self.piston_rod_mass + self.piston_mass

    @property
    def layout(self) -> EngineLayout:
        """The engine as a layout of one cylinder, for general calculations."""
        cylinder = EngineCylinder(bore=self.bore, piston_mass=self.sliding_mass, rod=self.rod)
        return EngineLayout(
            crank_radius=self.crank_radius,
            cylinders=(cylinder,),
            firing_order=(1,),
            strokes=2,
            shaft_inertia=float(self.crank_inertia),
        )


def piston_gas_force(
    engine: CrossheadEngine, pressure: Pressure, pressure_below: float = ATMOSPHERE
) -> GasForce:
    """Return the gas force as a function of the crank angle.

    Parameters
    ----------
    engine : CrossheadEngine
    pressure : GasPressure
        Two-stroke, over the angle from the top.
    pressure_below : float, optional
        Absolute pressure on the lower side of the piston [Pa].

    Returns
    -------
    callable
        Force towards the shaft [N] at crank angles [rad] of shape (m,).
    """
    layout = engine.layout
    return lambda angles: gas_forces(
        layout, pressure, pressure_below, shaft_angles_deg=np.degrees(angles)
    )[0]


def two_stroke_cycle(
    engine: CrossheadEngine,
    compression_ratio: float,
    *,
    peak_pressure: float,
    mean_effective_pressure: float,
    intake_pressure: float,
    **parameters: float,
) -> GasCycleResult:
    """Calculate the pressure over a two-stroke cycle from three pressures.

    Parameters
    ----------
    engine : CrossheadEngine
    compression_ratio : float
        Largest over smallest volume.
    peak_pressure, mean_effective_pressure, intake_pressure : float
        Highest pressure, absolute; indicated mean pressure; and pressure of the charge, absolute
        [Pa]. They determine the duration of the combustion.
    **parameters : float
        Any other parameters of `GasCycle`.

    Raises
    ------
    InputError
        As `gas_cycle`.
    """
    cycle = usual_gas_cycle(
        compression_ratio, strokes=2, intake_pressure=intake_pressure, **parameters
    )
    return gas_cycle(
        cycle,
        piston_position(engine.layout, 1),
        engine.area,
        peak_pressure=peak_pressure,
        mean_effective_pressure=mean_effective_pressure,
        solve_for="combustion_duration_deg",
    )
