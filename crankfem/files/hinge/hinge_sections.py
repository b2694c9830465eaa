"""The sections of hinge files: every field with its unit, range and meaning, declared once."""

import math
from typing import ClassVar, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.units.units import PER_MINUTE


class Crank(InputModel):
    """Cylinder and crank."""

    section: ClassVar[str] = "engine"

    name: str = Field(description="name of the engine")
    bore: float = quantity_field("cylinder bore", "m", 0.01, 2.0)
    crank_radius: float = quantity_field("crank radius", "m", 0.005, 2.5, symbol="r_1 + r_2")
    crank_mass: float = quantity_field("mass of the crank with the guides", "kg", 0.0, 1e5)
    crank_center_distance: float = quantity_field(
        "from the shaft axis to the crank's center of mass, negative if away from the crankpin",
        "m",
        minimum=-2.5,
        maximum=2.5,
        symbol="r_1",
    )
    crank_inertia: float = quantity_field(
        "inertia of crank and guides about the shaft axis", "kg m^2", 1e-6, 1e6
    )


class HingeRod(InputModel):
    """Connecting rod."""

    section: ClassVar[str] = "rod"

    length: float = quantity_field("connecting-rod length", "m", 0.02, 10.0)
    mass: float = quantity_field("connecting-rod mass", "kg", 1e-3, 2e4)
    center_distance: float = quantity_field(
        "from the crankpin to the rod's center of mass", "m", 0.0, 10.0, symbol="l_1"
    )
    inertia: float = quantity_field("inertia about the rod's center of mass", "kg m^2", 1e-9, 1e6)


class Sliding(InputModel):
    """What moves along the cylinder."""

    section: ClassVar[str] = "sliding"

    crosshead_mass: float = quantity_field("mass of the crosshead", "kg", 0.0, 2e4)
    piston_rod_mass: float = quantity_field("mass of the piston rod", "kg", 0.0, 2e4)
    piston_mass: float = quantity_field("mass of the piston", "kg", 1e-3, 2e4)


class Hinge(InputModel):
    """Elastic hinge: gas spring and guides."""

    section: ClassVar[str] = "hinge"

    design_speed: float = quantity_field(
        "speed for which the guides are made, one of the running points",
        "rad/s",
        minimum=1.0 * PER_MINUTE,
        maximum=30_000.0 * PER_MINUTE,
    )
    piston_area: float = quantity_field(
        "piston area of the gas spring", "m^2", 1e-6, 10.0, symbol="A"
    )
    height: float = quantity_field(
        "height of the gas column at the top dead center", "m", 1e-3, 10.0, symbol="H"
    )
    start_radius: float = quantity_field(
        "radius of the rollers' path at the top dead center", "m", 1e-3, 10.0, symbol="rho_0"
    )
    pressure: float = quantity_field(
        "pressure of the gas at the top dead center, above ambient_pressure",
        "Pa",
        minimum=1e3,
        maximum=1e9,
        symbol="p_0",
    )
    exponent: float = quantity_field(
        "exponent of the polytropic law", "", 1.0, 1.667, symbol="n", default=1.25
    )
    ambient_pressure: float = quantity_field(
        "pressure outside of the spring's pistons", "Pa", 0.0, 1e6, default=0.0
    )
    roller_radius: float = quantity_field("radius of the rollers", "m", 0.0, 5.0, default=0.0)


class Cycle(InputModel):
    """Common values of the cycles of all operating points; usual values by default."""

    section: ClassVar[str] = "cycle"

    compression_ratio: float = quantity_field(
        "largest over smallest cylinder volume", "", 2.0, 40.0
    )
    combustion_start: float | None = quantity_field(
        "crank angle at which heat release begins",
        "rad",
        minimum=math.radians(-55.0),
        maximum=math.radians(45.0),
        default=None,
    )
    exhaust_opens: float | None = quantity_field(
        "crank angle at which the exhaust opens",
        "rad",
        minimum=math.radians(60.0),
        maximum=math.radians(175.0),
        default=None,
    )
    intake_closes: float | None = quantity_field(
        "crank angle at which the cylinder closes",
        "rad",
        minimum=math.radians(-175.0),
        maximum=math.radians(-60.0),
        default=None,
    )


class RunningPoint(InputModel):
    """A speed with its pressures."""

    section: ClassVar[str] = "points"

    speed: float = quantity_field("crank speed", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE)
    mean_pressure: float | None = quantity_field(
        "indicated mean effective pressure", "Pa", 1e3, 1e7, default=None
    )
    peak_pressure: float | None = quantity_field(
        "highest pressure in the cylinder, absolute", "Pa", 1e5, 5e7, default=None
    )
    charge_pressure: float | None = quantity_field(
        "pressure of the charge and below the piston, absolute", "Pa", 1e4, 5e6, default=None
    )
    gas_force_table: str | None = Field(
        None,
        description="gas force on the piston over the crank angle, in place of the three pressures: CSV "
        "file in the folder of the hinge file",
    )

    @property
    def pressures(self) -> tuple[float, float, float] | None:
        """Mean, peak and charge pressure [Pa]; None if a table gives the gas force."""
        mean, peak, charge = self.mean_pressure, self.peak_pressure, self.charge_pressure
        return None if mean is None or peak is None or charge is None else (mean, peak, charge)

    @model_validator(mode="after")
    def _gas_is_given_once(self) -> Self:
        names = ("mean_pressure", "peak_pressure", "charge_pressure")
        given = [name for name in names if getattr(self, name) is not None]
        if self.gas_force_table is not None and given:
            raise InputError(
                f"{given[0]}: given together with gas_force_table; allowed is one of the two, "
                "because each defines the gas force."
            )
        missing = [name for name in names if name not in given]
        if self.gas_force_table is None and missing:
            raise InputError(
                f"{missing[0]}: missing; allowed are {', '.join(names)}, or "
                "gas_force_table in their place, because they define the gas force."
            )
        return self


class Operation(InputModel):
    """Running points."""

    section: ClassVar[str] = "operation"

    flywheel_fluctuation: float = quantity_field(
        "coefficient of speed fluctuation to compare flywheels at", "", 1e-5, 1.0, default=0.02
    )
    points: tuple[RunningPoint, ...] = part_field("running points", RunningPoint, many=True)

    @model_validator(mode="after")
    def _has_points(self) -> Self:
        if not self.points:
            raise InputError(
                "operation.points: given none; allowed are one or more under [[operation.points]], because "
                "the hinge is made for one."
            )
        return self


class SpringSize(InputModel):
    """A size of hinge to compare."""

    section: ClassVar[str] = "sizes"

    height: float = quantity_field("height of the gas column", "m", 1e-3, 10.0)
    start_radius: float = quantity_field("radius at the top dead center", "m", 1e-3, 10.0)


class Comparison(InputModel):
    """Springs whose guides are drawn beside each other."""

    section: ClassVar[str] = "comparison"

    pressures: tuple[float, ...] = quantity_field("start pressures", "Pa")
    sizes: tuple[SpringSize, ...] = part_field("sizes", SpringSize, many=True)
