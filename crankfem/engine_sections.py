"""The sections of engine files: every field with its unit, range and meaning, declared once."""

import math
from typing import ClassVar, Self

from pydantic import Field, model_validator

from dynamics.critical import even_firing_angles
from geometry.errors import InputError
from geometry.model import InputModel, quantity_field
from geometry.quantity import show_quantity


class Engine(InputModel):
    """Cylinders, speeds and crank arrangement. Fields are declared once, below."""

    section: ClassVar[str] = "engine"

    name: str = Field(description="what to call the engine")
    cylinders: int = quantity_field("number of cylinders in line", "", minimum=1, maximum=24)
    strokes: int = quantity_field("strokes per cycle, 2 or 4", "", minimum=2, maximum=4)
    bore: float = quantity_field("cylinder bore", "m", minimum=0.01, maximum=2.0)
    stroke: float = quantity_field("piston stroke", "m", minimum=0.01, maximum=5.0)
    rated_speed: float = quantity_field("rated speed", "rad/s", minimum=0.5, maximum=3000.0)
    lowest_speed: float = quantity_field(
        "lowest running speed", "rad/s", minimum=0.1, maximum=3000.0
    )
    highest_speed: float = quantity_field(
        "highest running speed", "rad/s", minimum=0.5, maximum=3000.0
    )
    crank_angles: tuple[float, ...] = quantity_field(
        "angle of each crank from the first, cylinder by cylinder, all in one sense of rotation",
        "rad",
    )
    firing_order: tuple[int, ...] = Field(
        description="cylinder numbers in firing order; they fire at even intervals"
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.strokes not in (2, 4):
            raise InputError(f"engine.strokes: given {self.strokes}; allowed are 2 and 4.")
        if not self.lowest_speed < self.highest_speed:
            raise InputError(
                f"engine.lowest_speed: given {show_quantity(self.lowest_speed, 'rad/s')}; allowed is less "
                f"than highest_speed, {show_quantity(self.highest_speed, 'rad/s')}."
            )
        if not self.lowest_speed <= self.rated_speed <= self.highest_speed:
            raise InputError(
                f"engine.rated_speed: given {show_quantity(self.rated_speed, 'rad/s')}; allowed is "
                f"lowest_speed to highest_speed, {show_quantity(self.lowest_speed, 'rad/s')} to "
                f"{show_quantity(self.highest_speed, 'rad/s')}."
            )
        if len(self.crank_angles) != self.cylinders:
            raise InputError(
                f"engine.crank_angles: given {len(self.crank_angles)} angles; allowed is one for each of "
                f"the {self.cylinders} cylinders."
            )
        if sorted(self.firing_order) != list(range(1, self.cylinders + 1)):
            raise InputError(
                f"engine.firing_order: given {list(self.firing_order)}; allowed is each cylinder number "
                f"from 1 to {self.cylinders} once."
            )
        self._check_firing()
        return self

    def _check_firing(self) -> None:
        """Each crank must be at the top when its cylinder fires."""
        for sense in (1.0, -1.0):
            offsets = [
                math.remainder(firing - sense * crank, 2.0 * math.pi)
                for firing, crank in zip(self.firing_angles, self.crank_angles, strict=True)
            ]
            if max(abs(offset - offsets[0]) for offset in offsets) < 1e-6:
                return
        raise InputError(
            f"engine.firing_order: given {list(self.firing_order)}, which does not fit the crank angles "
            f"{[round(math.degrees(angle), 3) for angle in self.crank_angles]} deg at even firing "
            "intervals; allowed is an order in which each crank is at the top when its cylinder fires."
        )

    @property
    def firing_angles(self) -> tuple[float, ...]:
        """Crank angle at which each cylinder fires, at even intervals [rad]."""
        return tuple(even_firing_angles(self.firing_order, self.strokes).tolist())


class ShaftLayout(InputModel):
    """How throws follow each other in a shaft whose throws are not its cylinders one by one.

    Raises
    ------
    InputError
        If an angle is no number.
    """

    section: ClassVar[str] = "shaft"

    throw_angles: tuple[float, ...] = quantity_field(
        "angle of each throw's first pin, throw by throw from the free end; the crank angles of the "
        "engine if not given",
        "rad",
    )


class Rod(InputModel):
    """Connecting rod."""

    section: ClassVar[str] = "rod"

    length: float = quantity_field("connecting-rod length", "m", minimum=0.02, maximum=10.0)
    mass: float = quantity_field("connecting-rod mass", "kg", minimum=1e-3, maximum=2e4)
    rotating_mass: float = quantity_field(
        "share of the rod's mass that turns with the crankpin", "kg", minimum=0.0, maximum=2e4
    )

    @model_validator(mode="after")
    def _share_below_whole(self) -> Self:
        if self.rotating_mass >= self.mass:
            raise InputError(
                f"rod.rotating_mass: given {self.rotating_mass:g} kg; allowed is less than the rod's mass "
                f"of {self.mass:g} kg."
            )
        return self


class Piston(InputModel):
    """Piston with rings and gudgeon pin; crosshead and piston rod where the engine has them."""

    section: ClassVar[str] = "piston"

    mass: float = quantity_field("mass of the piston set", "kg", minimum=1e-3, maximum=2e4)


class Flywheel(InputModel):
    """Flywheel, rigid on the last main journal."""

    section: ClassVar[str] = "flywheel"

    inertia: float = quantity_field("flywheel inertia", "kg m^2", minimum=1e-5, maximum=1e7)
    mass: float = quantity_field("flywheel mass", "kg", minimum=1e-2, maximum=1e6)


class FreeEnd(InputModel):
    """What the free end carries."""

    section: ClassVar[str] = "free_end"

    inertia: float = quantity_field("inertia at the free end", "kg m^2", minimum=1e-7, maximum=1e6)


class ThrustBearing(InputModel):
    """Thrust bearing with its housing."""

    section: ClassVar[str] = "thrust_bearing"

    stiffness: float = quantity_field("axial stiffness", "N/m", minimum=1e4, maximum=1e13)
    bearing: int = quantity_field(
        "main bearing it sits at, 0 at the free end", "", minimum=0, maximum=24
    )


class Gas(InputModel):
    """Gas pressure in the cylinder."""

    section: ClassVar[str] = "gas"

    peak_pressure: float = quantity_field(
        "largest gas pressure above ambient", "Pa", minimum=1e4, maximum=1e8
    )


class VibrationSettings(InputModel):
    """Choices for the vibration calculation."""

    section: ClassVar[str] = "vibration"

    axial_source: str = Field(
        "fe", description="source of axial compliances: fe, regression or a formula"
    )
    torsional_source: str = Field(
        "fe", description="source of torsional compliances: fe, regression or a formula"
    )
    highest_order: float = quantity_field(
        "highest harmonic order considered", "", minimum=0.5, maximum=48.0, default=12.0
    )


class TorqueTable(InputModel):
    """Torque of one throw over a cycle, as a table."""

    section: ClassVar[str] = "torque"

    table: str = Field(description="CSV file beside the engine file, or a shipped table")


class TwoMassInput(InputModel):
    """An engine reduced to two masses on an equivalent shaft."""

    section: ClassVar[str] = "two_mass_check"

    shaft_diameter: float = quantity_field(
        "equivalent shaft diameter", "m", minimum=1e-3, maximum=2.0
    )
    shaft_length: float = quantity_field(
        "equivalent shaft length", "m", minimum=1e-3, maximum=100.0
    )
    shear_modulus: float = quantity_field("shear modulus", "Pa", minimum=1e9, maximum=5e11)
    engine_inertia: float = quantity_field("engine inertia", "kg m^2", minimum=1e-6, maximum=1e7)
    flywheel_inertia: float = quantity_field(
        "flywheel inertia", "kg m^2", minimum=1e-6, maximum=1e7
    )
    order: float = quantity_field("harmonic order examined", "", minimum=0.5, maximum=48.0)
