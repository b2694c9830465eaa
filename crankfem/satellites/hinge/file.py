"""The file of a hinge: its sections and the hinge they make."""

import math
from dataclasses import replace
from pathlib import Path
from typing import ClassVar, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE
from crankbase.sentences import amount
from crankbase.summaries import frozen
from crankfem.files.reading.data_files import InputFiles, input_path
from crankfem.files.reading.toml_file import InputRecord, TomlFile, read_toml
from crankfem.files.sections.mechanism_sections import given_of_cycle
from crankfem.satellites.hinge.crosshead import (
    CrossheadEngine,
    GasForce,
    Kinematics,
    piston_gas_force,
    read_gas_force,
    two_stroke_cycle,
)
from crankfem.satellites.hinge.moment import HingeMoment, hinge_moment
from crankfem.satellites.hinge.profile import ComparedGuides, HingeProfile, hinge_profile
from crankfem.satellites.hinge.spring import GasSpring
from dynamics.engine.rods import ConnectingRod
from dynamics.gas.gas_cycle import name_fields
from dynamics.sample_tables import TableReading


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
    reading: TableReading | None = part_field("how the table is to be read", TableReading)
    pressure: float | None = quantity_field(
        "pressure of the spring's gas at the top dead center to evaluate here, above ambient_pressure, "
        "beside the best one; at design_speed only that of [hinge]",
        "Pa",
        minimum=1e3,
        maximum=1e9,
        symbol="p_0",
        default=None,
    )

    @property
    def pressures(self) -> tuple[float, float, float] | None:
        """Mean, peak and charge pressure [Pa]; None if a table gives the gas force."""
        mean, peak, charge = self.mean_pressure, self.peak_pressure, self.charge_pressure
        return None if mean is None or peak is None or charge is None else (mean, peak, charge)

    @model_validator(mode="after")
    def _gas_is_given_once(self) -> Self:
        names = ("mean_pressure", "peak_pressure", "charge_pressure")
        present = [name for name in names if getattr(self, name) is not None]
        if self.gas_force_table is not None and present:
            raise InputError(
                f"{present[0]}: given together with gas_force_table; allowed is one of the two, "
                "because each defines the gas force."
            )
        if self.reading is not None and self.gas_force_table is None:
            raise InputError(
                "reading: given without gas_force_table; allowed are both, because it says how that is read."
            )
        missing = [name for name in names if name not in present]
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


# Speeds of a file count as equal within this share.
SAME_SPEED = 1e-6


@frozen("name", "path", "design_speed [rad/s]", "speeds [rad/s]")
class HingeFile:
    """A hinge file, read and checked.

    Attributes
    ----------
    files : InputFiles
        The file, and those that it may name.
    name : str
    engine : CrossheadEngine
    spring : GasSpring
    start_radius, roller_radius, design_speed : float
    cycle : Cycle or None
        None if tables give the gas force of all operating points.
    operation : Operation
    comparison : Comparison or None
    records : tuple of InputRecord
        Every value with its source.
    sources : dict
        Short name to full citation.
    """

    files: InputFiles
    name: str
    engine: CrossheadEngine
    spring: GasSpring
    start_radius: float
    roller_radius: float
    design_speed: float
    cycle: Cycle | None
    operation: Operation
    comparison: Comparison | None
    records: tuple[InputRecord, ...]
    sources: dict[str, str]

    @property
    def path(self) -> Path:
        """What messages call the file, and where it is unless it was sent."""
        return self.files.path

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds of the operating points [rad/s]."""
        return tuple(point.speed for point in self.operation.points)

    def moment(self, speed: float | None = None, kinematics: Kinematics = "exact") -> HingeMoment:
        """Return the hinge moment at an operating point, by its speed [rad/s]; the design's by default.

        Raises
        ------
        InputError
            If there is no operating point of that speed, or its cycle is impossible.
        """
        point = self.point_at("speed", self.design_speed if speed is None else speed)
        return hinge_moment(self.engine, self._gas_force(point), point.speed, kinematics=kinematics)

    @property
    def tables(self) -> tuple[Path, ...]:
        """Tables of gas forces that the file names."""
        return tuple(
            self._table(point.gas_force_table).path
            for point in self.operation.points
            if point.gas_force_table is not None
        )

    def _table(self, name: str) -> InputFile:
        return self.files.named("operation.points.gas_force_table", name, "tables")

    def _gas_force(self, point: RunningPoint) -> GasForce:
        """Gas force of an operating point, by its table or by the cycle model."""
        if point.pressures is None or self.cycle is None:
            return read_gas_force(
                replace(self._table(point.gas_force_table or ""), reading=point.reading)
            )
        mean, peak, charge = point.pressures
        try:
            cycle = two_stroke_cycle(
                self.engine,
                self.cycle.compression_ratio,
                peak_pressure=peak,
                mean_effective_pressure=mean,
                intake_pressure=charge,
                **given_of_cycle(self.cycle),
            )
        except InputError as error:
            raise InputError(name_fields(error)) from None
        return piston_gas_force(self.engine, cycle.pressure, charge)

    def profile(self, moment: HingeMoment) -> HingeProfile:
        """Return the guides for a moment.

        Raises
        ------
        InputError
            As `hinge_profile`.
        """
        return hinge_profile(
            moment, self.spring, self.start_radius, roller_radius=self.roller_radius
        )

    def compared(self, moment: HingeMoment) -> tuple[ComparedGuides, ...]:
        """Return the guides, or why there are none, of all sizes and pressures of the comparison."""
        compared: list[ComparedGuides] = []
        if self.comparison is None:
            return ()
        for size in self.comparison.sizes:
            for pressure in self.comparison.pressures:
                spring = replace(self.spring, height=size.height, pressure=pressure)
                described = (size.height, pressure, size.start_radius)
                try:
                    guides = hinge_profile(
                        moment, spring, size.start_radius, roller_radius=self.roller_radius
                    )
                    compared.append(ComparedGuides(*described, guides))
                except InputError as error:
                    compared.append(ComparedGuides(*described, refused=str(error)))
        return tuple(compared)

    def point_at(self, field: str, speed: float) -> RunningPoint:
        """Return the operating point of a speed [rad/s]; `field` names it in the message.

        Raises
        ------
        InputError
            If there is none.
        """
        for point in self.operation.points:
            if math.isclose(point.speed, speed, rel_tol=SAME_SPEED):
                return point
        allowed = ", ".join(amount(known, "rad/s") for known in self.speeds)
        raise InputError(
            f"{field}: given {amount(speed, 'rad/s')}; allowed are the speeds of "
            "the running points, "
            f"{allowed}, because the gas force is known for them."
        )


NEEDED = ("engine", "rod", "sliding", "hinge", "operation")
KINDS = {
    kind.section: kind for kind in (Crank, HingeRod, Sliding, Hinge, Operation, Cycle, Comparison)
}


def load_hinge(path: str | Path | TomlFile = "crosshead-30-100") -> HingeFile:
    """Read and check a hinge file.

    Parameters
    ----------
    path : path, optional
        The file, or the name of a shipped one; or its sections, if already read.

    Raises
    ------
    InputError
        With a sentence for each wrong field, which names it, what was given and what is allowed.
    """
    content = path if isinstance(path, TomlFile) else read_toml(input_path(path, "hinge"))
    if (
        not {"sliding", "hinge", "operation"} & set(content.sections)
        and "throw" in content.sections
    ):
        raise InputError(
            f"{content.path.name}: describes an engine or a throw, not an elastic hinge; copy a hinge file "
            "by crankfem new mine.toml --from crosshead-30-100."
        )
    with content.all_errors(KINDS):
        content.check_sections({section: section in NEEDED for section in KINDS})
        crank, rod = content.required("engine", Crank), content.required("rod", HingeRod)
        sliding, hinge = content.required("sliding", Sliding), content.required("hinge", Hinge)
        engine = CrossheadEngine(
            rod=ConnectingRod(rod.length, rod.mass, rod.center_distance, rod.inertia),
            **crank.model_dump(exclude={"name"}),
            **sliding.model_dump(),
        )
        spring = GasSpring(
            piston_area=hinge.piston_area,
            height=hinge.height,
            pressure=hinge.pressure,
            exponent=hinge.exponent,
            ambient=hinge.ambient_pressure,
        )
        operation = content.required("operation", Operation)
        calculated = any(point.pressures is not None for point in operation.points)
        file = HingeFile(
            files=content.files,
            name=crank.name,
            engine=engine,
            spring=spring,
            start_radius=hinge.start_radius,
            roller_radius=hinge.roller_radius,
            design_speed=hinge.design_speed,
            cycle=content.required("cycle", Cycle) if calculated else content.model("cycle", Cycle),
            operation=operation,
            comparison=content.model("comparison", Comparison),
            records=tuple(content.records),
            sources=content.sources,
        )
        file.point_at("hinge.design_speed", hinge.design_speed)
        for point in operation.points:  # refuses what cannot be read
            if point.gas_force_table is not None:
                file._gas_force(point)
            design = math.isclose(point.speed, hinge.design_speed, rel_tol=SAME_SPEED)
            if design and point.pressure not in (None, hinge.pressure):
                raise InputError(
                    f"operation.points.pressure: given {amount(point.pressure or 0.0, 'Pa')} at "
                    f"design_speed; allowed is hinge.pressure, {amount(hinge.pressure, 'Pa')}, or "
                    "none, because the guides are made for that."
                )
        return file
