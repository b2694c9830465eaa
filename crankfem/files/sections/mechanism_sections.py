"""Pistons, rods, gas and load of an engine file."""

import math
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE
from crankbase.sentences import amount, kept
from dynamics.excitation.pressure_map import LoadPoints
from dynamics.gas.compressor import CompressorCycle
from dynamics.gas.gas_cycle import USUAL_VALUES, name_of_field
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.sample_tables import TableReading

GRAVITY = 9.80665  # standard [m/s^2]


def _check_share(section: str, share: float, whole: float) -> None:
    if not 0.0 < share < whole:
        raise InputError(
            f"{section}.rotating_mass: given {amount(share, 'kg')}; allowed is above 0 and less than the "
            f"rod's mass of {amount(whole, 'kg')}, because it is a share of it."
        )


def _inertia_field() -> Any:
    return quantity_field(
        "inertia about its center of mass; by default that of two masses at its pins",
        "kg m^2",
        minimum=1e-13,
        maximum=1e6,
        default=None,
    )


class Rod(InputModel):
    """Connecting rod."""

    section: ClassVar[str] = "rod"

    length: float = quantity_field("connecting-rod length", "m", 0.003, 10.0)
    mass: float = quantity_field("connecting-rod mass", "kg", 1e-6, 2e4)
    rotating_mass: float = quantity_field(
        "part of the rod's mass that turns with the crankpin, found by weighing: it sets the center of mass",
        "kg",
        minimum=0.0,
        maximum=2e4,
    )
    inertia: float | None = _inertia_field()
    center_offset: float = quantity_field(
        "offset of the center of mass from the rod's axis, positive to the side to which the crankpin moves "
        "at the top",
        "m",
        minimum=-1.0,
        maximum=1.0,
        symbol="l_d",
        default=0.0,
        feature=True,
    )
    swing_period: float | None = quantity_field(
        "period of small swings about a fixed edge, in place of inertia",
        "s",
        1e-3,
        100.0,
        default=None,
    )
    swing_distance: float | None = quantity_field(
        "distance of that edge from the center of mass", "m", 1e-4, 10.0, default=None
    )

    @property
    def known_inertia(self) -> float | None:
        """J about the center of mass, given or by the swings [kg m^2].

        A body that swings by small angles about an edge at a from its center of mass, with J + m a^2 about
        the edge, has the period T = 2 pi sqrt((J + m a^2) / (m g a)).
        """
        period, arm = self.swing_period, self.swing_distance
        if period is None or arm is None:
            return self.inertia
        return self.mass * arm * (GRAVITY * (period / (2.0 * math.pi)) ** 2 - arm)

    @model_validator(mode="after")
    def _can_be_a_body(self) -> Self:
        period, arm = self.swing_period, self.swing_distance
        if (period is None) is not (arm is None) or None not in (self.inertia, period):
            raise InputError(
                f"rod.swing_{'distance' if period is None else 'period'}: given "
                f"{'without the other one' if self.inertia is None else 'beside inertia'}; allowed are "
                "swing_period with swing_distance, or inertia, because either way defines the inertia."
            )
        if period is not None and (self.known_inertia or 0.0) <= 0.0:
            point = 2.0 * math.pi * math.sqrt((arm or 0.0) / GRAVITY)
            raise InputError(
                f"rod.swing_period: given {period:g} s at {amount(arm or 0.0, 'm')} from the edge; "
                f"allowed is above {point:.5g} s, because a body swings more slowly than a point does there."
            )
        if self.center_offset != 0.0 and self.known_inertia is None:
            raise InputError(
                f"rod.center_offset: given {amount(self.center_offset, 'm')} "
                "without inertia; allowed "
                "are both, because a rod modeled as two masses at its pins has its center between them."
            )
        _check_share(self.section, self.rotating_mass, self.mass)
        return self


class Piston(InputModel):
    """Piston with rings and gudgeon pin; crosshead and piston rod where the engine has them."""

    section: ClassVar[str] = "piston"

    mass: float = quantity_field("mass of the piston set", "kg", 1e-6, 2e4)
    pin_offset: float = quantity_field(
        "offset of the piston pin's line from the shaft axis, positive to the side to which the crankpin "
        "moves at the top",
        "m",
        minimum=-1.0,
        maximum=1.0,
        symbol="e",
        default=0.0,
        feature=True,
    )
    skirt_length: float | None = quantity_field(
        "length of the skirt below the piston pin, to check that counterweights pass under it",
        "m",
        minimum=0.0005,
        maximum=2.0,
        default=None,
    )


class HingedRods(InputModel):
    """Rods that are hinged to the rods of other cylinders instead of sitting on the crankpin."""

    section: ClassVar[str] = "hinged_rods"

    cylinders: tuple[int, ...] = quantity_field("numbers of the cylinders with hinged rods", "")
    main_cylinders: tuple[int, ...] = quantity_field(
        "numbers of the cylinders whose rods carry them, one for each", ""
    )
    pin_radius: float = quantity_field(
        "distance of the slave pin from the crankpin's center", "m", 0.0005, 5.0, symbol="R_1"
    )
    pin_angle: float | None = quantity_field(
        "angle of the slave pin from the main rod's axis, in the sense of bank_angles; by default the angle "
        "between the two banks",
        "rad",
        default=None,
    )
    length: float = quantity_field("length of the hinged rod between its pins", "m", 0.003, 10.0)
    mass: float = quantity_field("mass of the hinged rod", "kg", 1e-6, 2e4)
    rotating_mass: float = quantity_field(
        "share of its mass at the slave pin, found by weighing", "kg", 0.0, 2e4
    )
    inertia: float | None = _inertia_field()

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(self.cylinders) != len(self.main_cylinders):
            raise InputError(
                f"hinged_rods.main_cylinders: given {len(self.main_cylinders)} for {len(self.cylinders)} "
                "cylinders; allowed is one for each, because each rod is hinged to one."
            )
        if len(set(self.cylinders)) != len(self.cylinders):
            raise InputError(
                f"hinged_rods.cylinders: given {list(self.cylinders)}; allowed is each number once, because "
                "a cylinder has one rod."
            )
        _check_share(self.section, self.rotating_mass, self.mass)
        return self


# What the cycle of a compressor needs, of a machine that is driven.
COMPRESSOR = ("suction_pressure", "discharge_pressure", "clearance", "exponent")


class Gas(InputModel):
    """Gas pressure in the cylinder: measured, a cycle model fitted to given values, or a compressor's."""

    section: ClassVar[str] = "gas"

    peak_pressure: float | None = quantity_field(
        "largest gas pressure above ambient", "Pa", 1e4, 1e8, default=None
    )
    mean_effective_pressure: float | None = quantity_field(
        "indicated mean effective pressure", "Pa", 1e3, 1e7, default=None
    )
    pressure_table: str | None = Field(
        None,
        description="CSV file of the pressure over the crank angle, in the folder of the engine file, or "
        "shipped",
    )
    reading: TableReading | None = part_field("how the table is to be read", TableReading)
    compression_ratio: float = quantity_field(
        "compression ratio of the cycle", "", 2.0, 40.0, default=14.0
    )
    intake_pressure: float | None = quantity_field(
        "absolute pressure in the cylinder at the end of the intake", "Pa", 1e4, 2e6, default=None
    )
    exhaust_pressure: float | None = quantity_field(
        "absolute pressure in the cylinder during exhaust", "Pa", 1e4, 2e6, default=None
    )
    combustion_start: float | None = quantity_field(
        "crank angle at which combustion begins, from the top, negative before it",
        "rad",
        minimum=math.radians(-85.0),
        maximum=math.radians(85.0),
        default=None,
    )
    combustion_duration: float | None = quantity_field(
        "crank angle from start to end of combustion",
        "rad",
        minimum=math.radians(1.0),
        maximum=math.radians(170.0),
        default=None,
    )
    suction_pressure: float | None = quantity_field(
        "compressor: absolute pressure at which it takes in", "Pa", 1e3, 4e8, default=None
    )
    discharge_pressure: float | None = quantity_field(
        "compressor: absolute pressure at which it delivers", "Pa", 1e4, 4e8, default=None
    )
    clearance: float | None = quantity_field(
        "compressor: smallest volume over the swept one", "", 0.001, 5.0, default=None
    )
    exponent: float | None = quantity_field(
        "compressor: n of p V^n in compression and re-expansion", "", 1.0, 1.7, default=None
    )

    @property
    def compressor(self) -> CompressorCycle | None:
        """The cycle of a compressor, if it is given."""
        if self.discharge_pressure is None:
            return None
        try:
            return CompressorCycle(*(getattr(self, name) for name in COMPRESSOR))
        except InputError as error:
            raise InputError(f"gas.{kept(str(error))}") from None

    @model_validator(mode="after")
    def _says_how_high(self) -> Self:
        known = [name for name in COMPRESSOR if getattr(self, name) is not None]
        if known:
            self._check_compressor(known)
            return self
        if (
            self.peak_pressure is None
            and self.mean_effective_pressure is None
            and self.pressure_table is None
        ):
            raise InputError(
                "gas.peak_pressure: given neither it nor mean_effective_pressure nor pressure_table; allowed "
                "is one of them, or the first two together, because they define the gas pressure."
            )
        if self.reading is not None and self.pressure_table is None:
            raise InputError(
                "gas.reading: given without pressure_table; allowed are both, because it says how that is "
                "read."
            )
        beside = [
            name
            for name in (
                "peak_pressure",
                "mean_effective_pressure",
                "combustion_start",
                "combustion_duration",
            )
            if getattr(self, name) is not None
        ]
        if self.pressure_table is not None and beside:
            raise InputError(
                f"gas.{beside[0]}: given together with pressure_table; allowed is one of the two, because "
                "the table defines the whole pressure."
            )
        return self

    def _check_compressor(self, known: list[str]) -> None:
        """Refuse half a compressor, and one that is an engine as well."""
        missing = [name for name in COMPRESSOR if name not in known]
        if missing:
            raise InputError(
                f"gas.{missing[0]}: missing; give it with {', '.join(known)}, because the cycle of a "
                f"compressor has {', '.join(COMPRESSOR)}."
            )
        beside = [name for name in sorted(self.model_fields_set) if name not in COMPRESSOR]
        if beside:
            raise InputError(
                f"gas.{beside[0]}: given together with {known[0]}; allowed is one of the two, because the "
                "cycle of a compressor has no such value."
            )
        _ = self.compressor


def given_of_cycle(section: InputModel) -> dict[str, float]:
    """Return what a section gives of the cycle's parameters, angles in degrees."""
    fields = {name: getattr(section, name_of_field(name), None) for name in USUAL_VALUES}
    return {
        name: math.degrees(value) if name.endswith("_deg") else value
        for name, value in fields.items()
        if value is not None
    }


class LoadPoint(InputModel):
    """Load of the cylinders at one speed."""

    section: ClassVar[str] = "load.points"

    speed: float = quantity_field(
        "speed of the crankshaft", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    mean_effective_pressure: float = quantity_field(
        "indicated mean effective pressure at that speed", "Pa", 1e3, 1e7
    )
    peak_pressure: float | None = quantity_field(
        "largest gas pressure above ambient at that speed; by default from the combustion of [gas]",
        "Pa",
        1e4,
        1e8,
        default=None,
    )
    intake_pressure: float | None = quantity_field(
        "absolute pressure in the cylinder at the end of the intake at that speed; by default boost is "
        "proportional to the power",
        "Pa",
        1e4,
        2e6,
        default=None,
    )


class LoadSection(InputModel):
    """Load over the speed, besides full load as in [gas]; full load at all speeds without it."""

    section: ClassVar[str] = "load"

    law: Literal["propeller", "constant"] | None = Field(
        None,
        description="full load at all speeds, or that of a propeller, whose power is proportional to the "
        "cube of the speed; none if points are given",
    )
    points: tuple[LoadPoint, ...] = part_field(
        "load of the cylinders at several speeds, in place of a law", LoadPoint, many=True
    )

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        if (self.law is None) == (not self.points):
            what = "neither it nor points" if self.law is None else "both it and points"
            raise InputError(
                f"load.law: given {what}; allowed is one of the two, because each defines the load at all "
                "speeds."
            )
        speeds = [point.speed for point in self.points]
        if len(speeds) == 1 or len(set(speeds)) < len(speeds):
            raise InputError(
                f"load.points: given {len(speeds)} of {len(set(speeds))} different speeds; allowed are two "
                "or more, each speed once, because the load between them is interpolated."
            )
        for name in ("peak_pressure", "intake_pressure"):
            known = sum(getattr(point, name) is not None for point in self.points)
            if known not in (0, len(speeds)):
                raise InputError(
                    f"load.points: given {name} at {known} of {len(speeds)} speeds; allowed is all of them "
                    "or none, because it is interpolated between them."
                )
        return self


def load_points(section: LoadSection) -> LoadPoints | None:
    """Return the points of a section in ascending order of speed; None if it names a law."""
    if not section.points:
        return None
    points = sorted(section.points, key=lambda point: point.speed)
    speeds, mean, above, intake = (
        np.array([getattr(point, name) for point in points], dtype=np.float64)
        for name in ("speed", "mean_effective_pressure", "peak_pressure", "intake_pressure")
    )
    return LoadPoints(
        speeds,
        mean,
        None if points[0].peak_pressure is None else above + ATMOSPHERE,
        None if points[0].intake_pressure is None else intake,
    )
