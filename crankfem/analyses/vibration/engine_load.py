"""The load of an engine at each speed of its vibration, and the corresponding gas pressure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile
from crankfem.files.engine.mechanism_load import (
    curve_at,
    full_load_only,
    pressure_maps,
    pressures_at,
)
from crankfem.files.engine.rated_power import EnginePower, indicated_power
from crankfem.files.sections.excitation_sections import gas_map_load, gas_map_pressure
from dynamics.excitation.pressure_map import PressureMap, load_at
from dynamics.gas.pressure import GasPressure
from dynamics.indices import within

# Shares of the rated speed at which the load is told, beside lowest, rated and highest speed.
TOLD = (0.25, 0.5, 0.75)


@summarized(
    "law", "speeds [rad/s]", "power [W]", "mean_pressure [Pa]", "peak_pressure [Pa]", "sentence"
)
@dataclass(frozen=True, eq=False)
class EngineLoad:
    """Load of an engine over its speed.

    Attributes
    ----------
    law : {"constant", "propeller", "points", "map"}
        Full load at all speeds; by the propeller law; by points of the file; by its pressure map.
    given : bool
        Whether the file specifies it; by default full load.
    speeds : (S,) array
        Speeds of the load: lowest, rated and highest, and some between [rad/s].
    power : (S,) array
        Indicated power there [W].
    mean_pressure : (S,) array
        Indicated mean effective pressure [Pa].
    peak_pressure : (S,) array
        Highest of any cylinder, absolute [Pa].
    intake_pressure : (S,) array or None
        Absolute, if the cycle is calculated along a load [Pa].
    friction_pressure : float
        Part of the pressure assigned to friction at every speed, with a propeller law [Pa].
    rated : EnginePower
        Power of [gas], or of the pressure map replacing it, at rated speed, and the rated power.
    """

    law: str
    given: bool
    speeds: FloatArray
    power: FloatArray
    mean_pressure: FloatArray
    peak_pressure: FloatArray
    intake_pressure: FloatArray | None
    friction_pressure: float
    rated: EnginePower

    @property
    def sentence(self) -> str:
        """The load as a function of the speed, in words."""
        if self.law == "constant":
            source = (
                "as given in [load]" if self.given else "because the file has no section [load]"
            )
            return (
                f"every speed is calculated at full load, that of [gas], {source}; if the load falls with "
                "the speed, as with a propeller, the gas excites less than calculated here"
            )
        if self.law == "map":
            return "each speed is calculated at its load in the section [gas_map]"
        if self.law == "points":
            return (
                "each speed is calculated at its load in the section [load], on a smooth curve through the "
                "points"
            )
        if not self.friction_pressure:
            return (
                "each speed is calculated at the load of a propeller: mean indicated pressure is "
                "proportional to the square of the speed, power and boost to its cube, also above rated "
                "speed"
            )
        return (
            "each speed is calculated at the load of a propeller: mean effective pressure is proportional "
            "to the square of the speed, power at the flywheel to its cube; friction takes "
            f"{self.friction_pressure / 1e5:.3g} bar at every speed, and boost is proportional to the "
            "indicated power, also above rated speed"
        )


def pressure_over_speeds(
    engine_file: EngineFile, mechanism: MechanismFile, speed_range: tuple[float, float]
) -> PressureMap | tuple[PressureMap | GasPressure, ...]:
    """Return the pressure for `cylinder_harmonics`: along a load, of the file's map, or of full load.

    Raises
    ------
    InputError
        If a pressure cannot be read, or a cycle cannot reach the load.
    """
    if engine_file.gas_map is not None:
        return gas_map_pressure(engine_file.gas_map, engine_file.engine.strokes, engine_file.files)
    if full_load_only(mechanism):
        return mechanism.pressure
    return pressure_maps(mechanism, speed_range)


def engine_load(engine_file: EngineFile, mechanism: MechanismFile) -> EngineLoad:
    """Return the load of an engine over its running range.

    Parameters
    ----------
    engine_file : EngineFile
        With gas pressure.
    mechanism : MechanismFile
        Of the same engine.

    Raises
    ------
    InputError
        As `pressure_over_speeds`.
    """
    engine = engine_file.engine
    running = (engine.lowest_speed, engine.highest_speed)
    speeds = np.unique(
        [
            *running,
            engine.rated_speed,
            *(
                share * engine.rated_speed
                for share in TOLD
                if within(share * engine.rated_speed, *running)
            ),
        ]
    )
    found = pressures_of_cylinders(engine_file, mechanism, speeds)
    indicated = [
        indicated_power(mechanism.layout, pressures, speed)
        for pressures, speed in zip(found, speeds.tolist(), strict=True)
    ]
    law, section, rated = "constant", engine_file.load, mechanism.power
    if engine_file.gas_map is not None:
        law = "map"
        at_rated = indicated[int(np.flatnonzero(speeds == engine.rated_speed)[0])]
        rated = EnginePower(engine.rated_speed, *at_rated, engine.rated_power)
    elif section is not None:
        law = section.law or "points"
    assert rated is not None  # of [gas], where there is no map
    friction = rated.friction_pressure if law == "propeller" else 0.0
    return EngineLoad(
        law=law,
        given=section is not None,
        speeds=speeds,
        power=np.array([power for power, _ in indicated]),
        mean_pressure=np.array([mean for _, mean in indicated]),
        peak_pressure=np.array([max(one.peak_pressure for one in each) for each in found]),
        intake_pressure=(
            None if law in ("constant", "map") else curve_at(mechanism, speeds).intake_pressure
        ),
        friction_pressure=friction,
        rated=rated,
    )


def pressures_of_cylinders(
    engine_file: EngineFile, mechanism: MechanismFile, speeds: FloatArray
) -> Sequence[tuple[GasPressure, ...]]:
    """Return the pressure in each cylinder at each speed."""
    section, engine = engine_file.gas_map, engine_file.engine
    if section is None:
        if full_load_only(mechanism):
            return [mechanism.pressure] * speeds.size
        return pressures_at(mechanism, speeds)
    diagrams = gas_map_pressure(section, engine.strokes, engine_file.files)
    load = gas_map_load(section, engine.rated_speed)
    loads = [None] * speeds.size if load is None else load_at(load, speeds).tolist()
    cylinders = len(mechanism.layout.cylinders)
    return [
        (diagrams.at(speed, there),) * cylinders
        for speed, there in zip(speeds.tolist(), loads, strict=True)
    ]
