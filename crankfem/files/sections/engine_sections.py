"""The sections of engine files: every field with its unit, range and meaning, declared once."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from crankbase.array_checks import refuse_crank_radians, refuse_many_turns
from crankbase.choices import check_choice
from crankbase.errors import InputError, quoted
from crankbase.input_file import InputFile
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE
from crankbase.sentences import amount
from crankfem.files.reading.toml_file import TomlFile
from dynamics.assessment.limit_rules import RULE_OF_DRIVEN
from dynamics.chains.shaft_line import PRIME_MOVERS
from dynamics.engine.layout import (
    angles_after_first,
    even_firing_order,
    firing_angles_of_order,
    firing_intervals,
    firing_order_from_text,
    firing_order_of_angles,
)
from dynamics.sample_tables import TableReading

# Limits are round numbers in the units in which people read them.


class Engine(InputModel):
    """Cylinders, speeds and crank arrangement. Fields are declared once, below."""

    section: ClassVar[str] = "engine"

    name: str = Field(description="name of the engine")
    cylinders: int = quantity_field("number of cylinders", "", 1, 24)
    strokes: int = quantity_field(
        "strokes per cycle, 2 or 4; 2 for a compressor, whose cycle is a revolution", "", 2, 4
    )
    bore: float = quantity_field("cylinder bore", "m", 0.002, 2.0)
    stroke: float = quantity_field("piston stroke", "m", 0.001, 5.0)
    rated_speed: float = quantity_field(
        "rated speed", "rad/s", 5.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    rated_power: float | None = quantity_field(
        "power at the flywheel at rated speed, given or taken; the gas pressure must agree with it",
        "W",
        minimum=0.1,
        maximum=2e8,
        default=None,
    )
    lowest_speed: float = quantity_field(
        "lowest running speed", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    highest_speed: float = quantity_field(
        "highest running speed", "rad/s", 5.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    drives: str = Field(
        "",
        description=f"what the engine drives, {' or '.join(RULE_OF_DRIVEN)}; it selects the rule for the "
        "crankshaft if [limits] gives none",
    )
    driven_by: str = Field(
        "",
        description=f"what drives the machine, {' or '.join(PRIME_MOVERS)}, if it takes power, as a "
        "compressor does; nothing fires then",
        json_schema_extra={"feature": True},
    )
    generator_poles: int | None = quantity_field(
        "poles of the generator, for its electrical angle", "", 2, 400, default=None
    )
    crank_angles: tuple[float, ...] = quantity_field(
        "angle of each crank from the first, cylinder by cylinder, all in one sense of rotation; of a "
        "driven machine in that in which it turns",
        "rad",
    )
    firing_order: tuple[int, ...] | None = Field(
        None,
        description='cylinder numbers in firing order, also as text like "1-5-3-6-2-4"; each fires when its '
        "crank is at the top; none of a driven machine",
    )
    bank_angles: tuple[float, ...] | None = quantity_field(
        "V engine: angle of each cylinder's axis, cylinder by cylinder, in the sense of crank_angles",
        "rad",
        default=None,
    )
    throws: tuple[int, ...] | None = quantity_field(
        "V engine: throw of each cylinder, from 1 at the free end; by default the first cylinder of each "
        "bank is on throw 1, the second on throw 2, and so on",
        "",
        default=None,
    )

    @field_validator("firing_order", mode="before")
    @classmethod
    def _read_order(cls, order: object) -> object:
        # The field's name is put in front of an error.
        return firing_order_from_text(order, "") if isinstance(order, str) else order

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.driven_by:
            self._check_driven()
        elif self.firing_order is None:
            raise InputError(
                "engine.firing_order: missing; give cylinder numbers in firing order, or driven_by for a "
                "machine that takes power."
            )
        if self.drives:
            check_choice("engine.drives", self.drives, RULE_OF_DRIVEN, "a rule goes by these")
        if self.generator_poles is not None and (
            self.generator_poles % 2 or self.drives != "generator"
        ):
            raise InputError(
                f"engine.generator_poles: given {self.generator_poles}, of what drives "
                f'"{self.drives}"; allowed are even numbers with drives = "generator", because poles are '
                "those of a generator and come in pairs."
            )
        if self.strokes not in (2, 4):
            raise InputError(f"engine.strokes: given {self.strokes}; allowed are 2 and 4.")
        if not self.lowest_speed < self.highest_speed:
            raise InputError(
                f"engine.lowest_speed: given {amount(self.lowest_speed, 'rad/s')}; allowed is less "
                f"than highest_speed, {amount(self.highest_speed, 'rad/s')}."
            )
        if not self.lowest_speed <= self.rated_speed <= self.highest_speed:
            raise InputError(
                f"engine.rated_speed: given {amount(self.rated_speed, 'rad/s')}; allowed is "
                f"lowest_speed to highest_speed, {amount(self.lowest_speed, 'rad/s')} to "
                f"{amount(self.highest_speed, 'rad/s')}."
            )
        for name, kind in (
            ("crank_angles", "angles"),
            ("bank_angles", "angles"),
            ("throws", "throws"),
        ):
            numbers = getattr(self, name)
            if numbers is not None and len(numbers) != self.cylinders:
                raise InputError(
                    f"engine.{name}: given {len(numbers)} {kind}; allowed is one for each of the "
                    f"{self.cylinders} cylinders."
                )
            if kind == "angles":
                refuse_many_turns(f"engine.{name}", numbers or ())
                refuse_crank_radians(f"engine.{name}", np.degrees(numbers or ()), written=True)
        if sorted(self.top_order) != list(range(1, self.cylinders + 1)):
            raise InputError(
                f"engine.firing_order: given {list(self.top_order)}; allowed is each cylinder number "
                f"from 1 to {self.cylinders} once."
            )
        if self.throws is not None and set(self.throws) != set(range(1, max(self.throws) + 1)):
            raise InputError(
                f"engine.throws: given {list(self.throws)}; allowed are numbers from 1 up without a gap, "
                "because each throw carries a cylinder."
            )
        _ = self.turning_sense
        return self

    def _check_driven(self) -> None:
        """Refuse what only an engine has, for a machine that takes power."""
        check_choice("engine.driven_by", self.driven_by, PRIME_MOVERS, "these turn a machine")
        for name, shown, allowed, why in (
            ("drives", self.drives, "one of the two", "a machine takes power or gives it"),
            (
                "firing_order",
                self.firing_order,
                "none",
                "nothing fires: crank_angles say what follows",
            ),
        ):
            if shown:
                raise InputError(
                    f"engine.{name}: given {quoted(shown)} together with driven_by; allowed is {allowed}, "
                    f"because {why}."
                )
        if self.strokes != 2:
            raise InputError(
                f"engine.strokes: given {self.strokes} together with driven_by; allowed is 2, because a "
                "compressor takes in and delivers in each revolution."
            )

    @property
    def top_order(self) -> tuple[int, ...]:
        """Cylinder numbers as they come to the top: the firing order, if they fire."""
        if self.firing_order is not None:
            return self.firing_order
        return firing_order_of_angles(self._tops(1), self.strokes, 1)

    @cached_property
    def turning_sense(self) -> int:
        """1 if the shaft turns in the sense in which the angles count, else -1: the firing order tells.

        Where the order fits both senses, the one in which the engine fires more evenly.
        """
        if self.driven_by:
            return 1
        unevenness = {}
        for sense in (1, -1):
            try:
                angles = firing_angles_of_order(self.top_order, self._tops(sense), self.strokes)
            except InputError:
                continue
            steps = firing_intervals(angles, self.strokes)
            unevenness[sense] = round(max(steps) - min(steps), 6)
        if unevenness:
            # Where both fit, the engine turns so that it fires evenly.
            return min(unevenness, key=lambda sense: unevenness[sense])
        tops = [round(math.degrees(top) % 360.0, 3) for top in self._tops(1)]
        even = even_firing_order([math.radians(top) for top in tops], self.strokes)
        such = "" if even is None else f", such as {'-'.join(map(str, even))}"
        raise InputError(
            f"engine.firing_order: given {list(self.top_order)}, which does not fit the crank angles; "
            "allowed is an order in which each crank is at the top when its cylinder fires, all within one "
            f"cycle{such} (cylinder by cylinder the tops are at {tops} deg, or the other way round)."
        )

    @property
    def firing_intervals_deg(self) -> tuple[float, ...]:
        """Angles from each firing, or top, to the next one, from the first cylinder of `top_order` [deg]."""
        steps = firing_intervals(self.firing_angles, self.strokes)
        return tuple(round(math.degrees(step), 6) for step in steps)

    def mean_piston_speed(self, speed: float) -> float:
        """Mean piston speed [m/s] at a speed of the shaft [rad/s]: two strokes a revolution."""
        return speed * self.stroke / math.pi

    def _tops(self, sense: int) -> list[float]:
        """Shaft angle at which each crank is at the top, for a sense of rotation [rad]."""
        banks = self.bank_angles or (0.0,) * self.cylinders
        return [
            sense * (bank - crank) for bank, crank in zip(banks, self.crank_angles, strict=True)
        ]

    @cached_property
    def firing_angles(self) -> tuple[float, ...]:
        """Crank angle at which each cylinder fires or is at the top, from the first of `top_order` [rad]."""
        tops = self._tops(self.turning_sense)
        if self.driven_by:
            return angles_after_first(tops, self.strokes)
        angles = firing_angles_of_order(self.top_order, tops, self.strokes)
        return tuple(angle - angles[self.top_order[0] - 1] for angle in angles)


class Flywheel(InputModel):
    """Flywheel, rigid on the last main journal."""

    section: ClassVar[str] = "flywheel"

    inertia: float = quantity_field("flywheel inertia", "kg m^2", 1e-9, 1e7)
    mass: float = quantity_field("flywheel mass", "kg", 1e-4, 1e6)
    diametral_inertia: float | None = quantity_field(
        "inertia about a diameter through its center of mass, for the whole crankshaft; by default half of "
        "inertia, as for a thin disc",
        "kg m^2",
        minimum=1e-10,
        maximum=1e7,
        default=None,
    )
    overhang: float | None = quantity_field(
        "distance of its center of mass beyond the middle of the last main journal, for the whole "
        "crankshaft; by default the thickness of the flange, or half of the journal's length without a "
        "flange",
        "m",
        minimum=0.0,
        maximum=5.0,
        default=None,
    )


class FreeEnd(InputModel):
    """Parts at the free end."""

    section: ClassVar[str] = "free_end"

    inertia: float = quantity_field("inertia at the free end", "kg m^2", 1e-11, 1e6)
    mass: float = quantity_field(
        "mass of the parts with this inertia, for axial vibration and the whole crankshaft",
        "kg",
        minimum=0.0,
        maximum=1e6,
        default=0.0,
    )
    diametral_inertia: float | None = quantity_field(
        "inertia about a diameter, for the whole crankshaft; by default half of inertia, as for a thin disc",
        "kg m^2",
        minimum=1e-12,
        maximum=1e6,
        default=None,
    )


class ThrustBearing(InputModel):
    """Thrust bearing with its housing."""

    section: ClassVar[str] = "thrust_bearing"

    stiffness: float = quantity_field("axial stiffness", "N/m", 1e4, 1e13)
    main_bearing: int = quantity_field(
        "number of its main bearing, counted from 1 at the free end like cylinders: n throws have n + 1",
        "",
        minimum=1,
        maximum=25,
    )

    @property
    def section_index(self) -> int:
        """Where it is in arrays of the shaft's sections, from 0 at the free end."""
        return self.main_bearing - 1

    @classmethod
    def from_text(cls, values: Mapping[str, object], section: str | None = None) -> Self:
        """Build it from text with units; see `InputModel.from_text`."""
        _refuse_bearing_from_zero(values)
        return super().from_text(values, section)

    @model_validator(mode="before")
    @classmethod
    def _check_counting(cls, values: Mapping[str, object]) -> Mapping[str, object]:
        _refuse_bearing_from_zero(values)
        return values


def _refuse_bearing_from_zero(values: Mapping[str, object]) -> None:
    """Refuse the field that counted from 0: read as main_bearing it would be the bearing before."""
    if "bearing" in values:
        count = values["bearing"]
        now = int(str(count)) + 1 if str(count).isdecimal() else "its count"
        raise InputError(
            f"thrust_bearing.bearing: given {quoted(count)}; this field counted from 0 at the free end, main "
            f"bearings count from 1 like cylinders: write main_bearing = {now} in its place."
        )


class VibrationSettings(InputModel):
    """Choices for the vibration calculation."""

    section: ClassVar[str] = "vibration"
    choices = frozenset(
        {"axial_source", "torsional_source", "model", "reciprocating", "highest_order"}
    )

    axial_source: str = Field(
        "fe", description="source of axial compliances: fe, law, regression or a formula"
    )
    torsional_source: str = Field(
        "fe", description="source of torsional compliances: fe, law, regression or a formula"
    )
    model: str | None = Field(
        None,
        description="saved compliance model for the source regression, a file in the folder of the engine "
        "file",
    )
    reciprocating: Literal["half", "mean"] = Field(
        "half",
        description="equivalent inertia of pistons: half of their mass at the crank radius, or the exact "
        "mean over a revolution",
    )
    highest_order: float = quantity_field(
        "highest harmonic order considered", "", 0.5, 48.0, default=12.0
    )


class TorqueTable(InputModel):
    """Torque of one throw over a cycle, as a table."""

    section: ClassVar[str] = "torque"

    table: str = Field(description="CSV file in the folder of the engine file, or a shipped table")
    reading: TableReading | None = part_field("how the table is to be read", TableReading)


def torque_table_file(content: TomlFile) -> InputFile | None:
    """Return the torque table that a file names, if it names one."""
    section = content.model("torque", TorqueTable)
    if section is None:
        return None
    file = content.files.named("torque.table", section.table, "tables")
    return replace(file, reading=section.reading)


class TwoMassInput(InputModel):
    """An engine reduced to two masses on an equivalent shaft."""

    section: ClassVar[str] = "two_mass_check"

    shaft_diameter: float = quantity_field("equivalent shaft diameter", "m", 1e-3, 2.0)
    shaft_length: float = quantity_field("equivalent shaft length", "m", 1e-3, 100.0)
    shear_modulus: float = quantity_field("shear modulus", "Pa", 1e9, 5e11)
    engine_inertia: float = quantity_field("engine inertia", "kg m^2", 1e-6, 1e7)
    flywheel_inertia: float = quantity_field("flywheel inertia", "kg m^2", 1e-6, 1e7)
    order: float = quantity_field("harmonic order examined", "", 0.5, 48.0)
