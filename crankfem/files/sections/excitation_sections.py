"""Sections of engine files about excitation: pressure map, misfire and propeller forces."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE
from crankbase.sentences import kept
from crankfem.files.reading.data_files import InputFiles, torque_path
from dynamics.excitation.pressure_map import Load, PressureMap, pressure_map, propeller_load
from dynamics.excitation.propeller import PropellerForces
from dynamics.gas.pressure import GasPressure, read_pressure_table
from dynamics.harmonics import TorqueTable, read_torque_table
from dynamics.sample_tables import TableReading


class GasMapPoint(InputModel):
    """One diagram of the pressure map."""

    section: ClassVar[str] = "gas_map.points"

    speed: float = quantity_field(
        "speed at which the diagram was taken", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    load: float = quantity_field("load there, in the measure of the map", "", 0.0, 1e9, default=1.0)
    pressure_table: str = Field(
        description="CSV file of the pressure over the crank angle, in the folder of the engine file, or "
        "shipped"
    )
    reading: TableReading | None = part_field("how the table is to be read", TableReading)


class GasMap(InputModel):
    """Pressure in the cylinder over speed and load, for calculations over a range of speeds."""

    section: ClassVar[str] = "gas_map"
    choices = frozenset({"measure", "method"})

    measure: Literal["torque", "power"] = Field(
        "torque",
        description="quantity of which load is a share: torque (or mean effective pressure), or power",
    )
    law: Literal["propeller", "constant"] | None = Field(
        None, description="load over the speed; none if each speed has its own diagram"
    )
    rated_load: float = quantity_field(
        "load at the rated speed (propeller), or at all speeds (constant)",
        "",
        minimum=0.0,
        maximum=1e9,
        default=1.0,
    )
    method: Literal["cubic", "linear"] = Field(
        "cubic", description="interpolation between the diagrams: cubic spline, or straight lines"
    )
    points: tuple[GasMapPoint, ...] = part_field("diagrams of the map", GasMapPoint, many=True)

    @model_validator(mode="after")
    def _has_points(self) -> Self:
        if not self.points:
            raise InputError(
                "gas_map.points: given none; allowed are one or more, each under [[gas_map.points]], "
                "because a map has diagrams."
            )
        return self


class Misfire(InputModel):
    """Cylinders that do not fire, or fire weakly; without it each cylinder fails by itself in turn."""

    section: ClassVar[str] = "misfire"

    cylinders: tuple[int, ...] | None = quantity_field(
        "numbers of the cylinders that misfire at the same time; by default each cylinder in turn",
        "",
        default=None,
    )
    missing_share: float = quantity_field(
        "missing share of the combustion in each", "", 0.0, 1.0, default=1.0
    )
    compression: bool = Field(
        True,
        description="whether a misfiring cylinder still compresses; otherwise the missing share has no gas "
        "force",
    )

    @model_validator(mode="after")
    def _names_some_once(self) -> Self:
        cylinders = self.cylinders
        if cylinders is not None and (not cylinders or len(set(cylinders)) < len(cylinders)):
            raise InputError(
                f"misfire.cylinders: given {list(cylinders)}; allowed are one or more numbers, each "
                "once, because these cylinders fail."
            )
        return self


class PropellerForcesSection(InputModel):
    """Thrust and torque of a propeller that vary with the passing of its blades."""

    section: ClassVar[str] = "propeller_forces"

    node: str = Field("propeller", description="name of its node in the chain")
    blades: int = quantity_field("number of blades", "", 2, 12)
    rated_speed: float = quantity_field(
        "speed of the propeller at the rated point",
        "rad/s",
        minimum=1.0 * PER_MINUTE,
        maximum=10_000.0 * PER_MINUTE,
    )
    rated_thrust: float = quantity_field("mean thrust there", "N", 1.0, 1e8)
    rated_torque: float = quantity_field("mean torque there, taken from the shaft", "N m", 1.0, 1e9)
    thrust_shares: tuple[float, ...] = quantity_field(
        "amplitudes at blade order and its multiples, as shares of the mean thrust", "", default=()
    )
    thrust_phases: tuple[float, ...] | None = quantity_field(
        "their phases, as sines of the propeller's angle", "rad", default=None
    )
    torque_shares: tuple[float, ...] = quantity_field(
        "amplitudes at blade order and its multiples, as shares of the mean torque", "", default=()
    )
    torque_phases: tuple[float, ...] | None = quantity_field(
        "their phases, as sines of the propeller's angle", "rad", default=None
    )
    ratio: float | None = quantity_field(
        "speed of the propeller divided by that of the crankshaft; by default from the chain's gears",
        "",
        minimum=-100.0,
        maximum=100.0,
        default=None,
    )

    @model_validator(mode="after")
    def _has_shares(self) -> Self:
        shares = (*self.thrust_shares, *self.torque_shares)
        if not shares or not all(0.0 <= share <= 1.0 for share in shares):
            raise InputError(
                f"propeller_forces.thrust_shares: given {list(self.thrust_shares)}, with torque_shares "
                f"{list(self.torque_shares)}; allowed are shares from 0 to 1 in one of them or both, because "
                "a steady propeller excites nothing."
            )
        if self.ratio == 0.0:
            raise InputError(
                "propeller_forces.ratio: given 0; allowed is -100 to 100 but not 0, because the propeller "
                "turns."
            )
        return self

    @property
    def forces(self) -> PropellerForces:
        """The propeller as the calculation takes it."""
        phases = ("thrust_phases", "torque_phases")
        in_degrees: dict[str, Any] = {
            f"{name}_deg": None if phase is None else np.degrees(phase)
            for name, phase in ((name, getattr(self, name)) for name in phases)
        }
        return PropellerForces(**self.model_dump(exclude={"node", "ratio", *phases}), **in_degrees)


def gas_map_pressure(
    section: GasMap, strokes: int, files: InputFiles, *, fires: bool = True
) -> PressureMap:
    """Return the pressure map that a section describes.

    Parameters
    ----------
    strokes : int
        Of the engine, 2 or 4.
    files : InputFiles
        The engine file and those that it may name.
    fires : bool, optional
        Whether the diagrams are those of an engine, as of `read_pressure_table`.
    """
    # By table and how it is read: columns or sheets of one file may be different diagrams.
    diagrams: dict[tuple[str, str], GasPressure] = {}
    points: list[tuple[float, float, GasPressure]] = []
    for number, point in enumerate(section.points):
        key = point.pressure_table, repr(point.reading)
        if key not in diagrams:
            field = f"gas_map.points[{number}].pressure_table"
            table = files.named(field, point.pressure_table, "tables")
            table = replace(table, reading=point.reading)
            diagrams[key] = read_pressure_table(table, strokes, fires=fires)
        points.append((point.speed, point.load, diagrams[key]))
    try:
        return pressure_map(points, method=section.method)
    except InputError as error:
        raise InputError(f"gas_map.{kept(str(error))}") from None


def gas_map_load(section: GasMap, rated_speed: float) -> Load | None:
    """Return the load over the speed that a section describes, None where the map needs none.

    Parameters
    ----------
    rated_speed : float
        Of the engine [rad/s].
    """
    if section.law is None:
        return None
    if section.law == "constant":
        return section.rated_load
    return propeller_load(rated_speed, section.rated_load, measure=section.measure)


def load_torque_table(
    path: str | Path,
    *,
    strokes: int | None = None,
    columns: Mapping[str, int | str] | None = None,
    sheet: str = "",
) -> TorqueTable:
    """Read the torque of one throw over a cycle; `read_torque_table` describes the format.

    Parameters
    ----------
    path : path
        The file, CSV or a spreadsheet (.xlsx), or the name of a shipped one, such as
        ``yamz5340_torque_one_throw.csv``.
    strokes : int, optional
        Strokes per cycle, 2 or 4, if the table does not define it; 4 by default.
    columns : mapping, optional
        Column of angle and torque by heading or number from 1, if the header does not say so, such as
        ``{"crank_angle_deg": 1, "torque_Nm": "M1"}``.
    sheet : str, optional
        Of a spreadsheet with several.

    Raises
    ------
    InputError
        With file and line, if the table cannot be used.
    """
    reading = TableReading(columns=None if columns is None else dict(columns), sheet=sheet)
    return read_torque_table(torque_path(path), strokes=strokes, reading=reading)
