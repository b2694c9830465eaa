"""Load of an engine over its speed: pressure in its cylinders, power, and what is said of it."""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Internal, Part, Quantity, Result, Speed, result
from crankbase.sentences import capital
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.engine_mechanism import (
    curve_at,
    full_load_only,
    pressure_maps,
    pressures_at,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.excitation_sections import (
    GasMap,
    gas_map_load,
    gas_map_pressure,
)
from dynamics.excitation.pressure_map import (
    EnginePower,
    PressureMap,
    indicated_power,
    load_at,
)
from dynamics.gas.pressure import GasPressure
from dynamics.indices import within

# Shares of the rated speed at which the load is told, beside lowest, rated and highest speed.
TOLD = (0.25, 0.5, 0.75)


@result("speed", "indicated_power")
class LoadPoint(Result):
    """Load of an engine at one speed."""

    speed: Speed
    indicated_power: Annotated[float, Quantity("W")]
    mean_indicated_pressure: Annotated[float, Quantity("Pa")]
    peak_pressure: Annotated[float, Quantity("Pa", "highest of any cylinder, absolute")]
    intake_pressure: Annotated[float | None, Quantity("Pa", "absolute", left_out=True)]


@result(
    "law", "speeds [rad/s]", "power [W]", "mean_pressure [Pa]", "peak_pressure [Pa]", "sentence"
)
class EngineLoad(Result):
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
    speeds: Internal[Array]
    power: Internal[Array]
    mean_pressure: Internal[Array]
    peak_pressure: Internal[Array]
    intake_pressure: Internal[Array | None]
    friction_pressure: Internal[float]
    rated: EnginePower

    @cached_property
    def points(self) -> Annotated[tuple[LoadPoint, ...], Quantity(key="speeds")]:
        """The load at each speed."""
        values = (self.speeds, self.power, self.mean_pressure, self.peak_pressure)
        intake = self.intake_pressure
        known = [None] * self.speeds.size if intake is None else intake.tolist()
        return tuple(map(LoadPoint, *(each.tolist() for each in values), known))

    @cached_property
    def sentence(self) -> Part[str]:
        """The load as a function of the speed, in words."""
        if self.law == "constant" and self.rated.driven:
            return (
                "every speed is calculated with the pressures of [gas]; a compressor that starts unloaded is "
                "excited less below its running speeds"
            )
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

    def table(self) -> Table:
        """Return the load at some speeds."""
        boosted = any(point.intake_pressure is not None for point in self.points)
        intake = [(Column("intake pressure", "MPa"), "intake_pressure")] if boosted else []
        return Table.of_records(
            "Load of the engine",
            self.points,
            (Column("speed", "1/min", decimals=1), "speed"),
            (Column("indicated power", "kW"), "indicated_power"),
            (Column("mean indicated pressure", "MPa"), "mean_indicated_pressure"),
            (Column("peak pressure", "MPa"), "peak_pressure"),
            *intake,
            note="Peak and intake pressure are absolute.",
        )

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return power, the load as a function of the speed, and the load at some speeds if it varies."""
        for text in (self.rated.sentence, self.sentence):
            yield units.written(f"{capital(text)}.")
        if self.law != "constant":
            yield self.table()


def pressure_over_speeds(
    engine_file: EngineFile, speed_range: tuple[float, float]
) -> PressureMap | tuple[PressureMap | GasPressure, ...]:
    """Return the pressure for `cylinder_harmonics`: along a load, of the file's map, or of full load.

    Raises
    ------
    InputError
        If a pressure cannot be read, or a cycle cannot reach the load.
    """
    if engine_file.gas_map is not None:
        return engine_gas_map(engine_file, engine_file.gas_map)
    if full_load_only(engine_file):
        return engine_file.pressure
    return pressure_maps(engine_file, speed_range)


def engine_gas_map(engine_file: EngineFile, section: GasMap) -> PressureMap:
    """Return the pressure map of an engine, or of a driven machine."""
    engine = engine_file.engine
    return gas_map_pressure(section, engine.strokes, engine_file.files, fires=not engine.driven_by)


def engine_load(engine_file: EngineFile) -> EngineLoad:
    """Return the load of an engine over its running range.

    Parameters
    ----------
    engine_file : EngineFile
        With gas pressure.

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
    pressures_at_speeds = pressures_of_cylinders(engine_file, speeds)
    indicated = [
        indicated_power(engine_file.layout, pressures, speed)
        for pressures, speed in zip(pressures_at_speeds, speeds.tolist(), strict=True)
    ]
    law, section, rated = "constant", engine_file.load, engine_file.power
    if engine_file.gas_map is not None:
        law = "map"
        at_rated = indicated[int(np.flatnonzero(speeds == engine.rated_speed)[0])]
        rated = EnginePower(
            engine.rated_speed, *at_rated, engine.rated_power, driven=bool(engine.driven_by) or None
        )
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
        peak_pressure=np.array(
            [max(pressure.peak_pressure for pressure in each) for each in pressures_at_speeds]
        ),
        intake_pressure=(
            None if law in ("constant", "map") else curve_at(engine_file, speeds).intake_pressure
        ),
        friction_pressure=friction,
        rated=rated,
    )


def pressures_of_cylinders(
    engine_file: EngineFile, speeds: Array
) -> Sequence[tuple[GasPressure, ...]]:
    """Return the pressure in each cylinder at each speed."""
    section, engine = engine_file.gas_map, engine_file.engine
    if section is None:
        if full_load_only(engine_file):
            return [engine_file.pressure] * speeds.size
        return pressures_at(engine_file, speeds)
    diagrams = engine_gas_map(engine_file, section)
    load = gas_map_load(section, engine.rated_speed)
    loads = [None] * speeds.size if load is None else load_at(load, speeds).tolist()
    cylinders = len(engine_file.layout.cylinders)
    return [
        (diagrams.at(speed, there),) * cylinders
        for speed, there in zip(speeds.tolist(), loads, strict=True)
    ]
