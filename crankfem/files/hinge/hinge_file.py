"""Read hinge files: a crosshead engine, its operating points, and its elastic hinge."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.summaries import summarized
from crankbase.units.quantity import format_quantity
from crankfem.files.hinge.hinge_sections import (
    Comparison,
    Crank,
    Cycle,
    Hinge,
    HingeRod,
    Operation,
    RunningPoint,
    Sliding,
)
from crankfem.files.reading.data_files import InputFiles, input_path
from crankfem.files.reading.toml_file import InputRecord, TomlFile, read_toml
from crankfem.files.sections.cylinder_pressures import given_of_cycle, name_fields
from dynamics.engine.rods import ConnectingRod
from dynamics.hinge.crosshead import (
    CrossheadEngine,
    GasForce,
    Kinematics,
    piston_gas_force,
    read_gas_force,
    two_stroke_cycle,
)
from dynamics.hinge.moment import HingeMoment, hinge_moment
from dynamics.hinge.profile import GasSpring, HingeProfile, hinge_profile

# Speeds of a file count as equal within this share.
SAME_SPEED = 1e-6


@summarized("name", "path", "design_speed [rad/s]", "speeds [rad/s]")
@dataclass(frozen=True)
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
            return read_gas_force(self._table(point.gas_force_table or ""))
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

    def compared(self, moment: HingeMoment) -> list[tuple[GasSpring, float, HingeProfile | str]]:
        """Return spring, initial radius, and guides or why there are none, of all sizes and pressures."""
        found: list[tuple[GasSpring, float, HingeProfile | str]] = []
        if self.comparison is None:
            return found
        for size in self.comparison.sizes:
            for pressure in self.comparison.pressures:
                spring = replace(self.spring, height=size.height, pressure=pressure)
                try:
                    made: HingeProfile | str = hinge_profile(
                        moment, spring, size.start_radius, roller_radius=self.roller_radius
                    )
                except InputError as error:
                    made = str(error)
                found.append((spring, size.start_radius, made))
        return found

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
        allowed = ", ".join(format_quantity(known, "rad/s") for known in self.speeds)
        raise InputError(
            f"{field}: given {format_quantity(speed, 'rad/s')}; allowed are the speeds of "
            "the running points, "
            f"{allowed}, because the gas force is known for them."
        )


NEEDED = ("engine", "rod", "sliding", "hinge", "operation")
KINDS = {
    kind.section: kind for kind in (Crank, HingeRod, Sliding, Hinge, Cycle, Operation, Comparison)
}
SECTIONS = {**dict.fromkeys(NEEDED, True), "cycle": False, "comparison": False}


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
        return _read_hinge(content)


def _read_hinge(content: TomlFile) -> HingeFile:
    content.check_sections(SECTIONS)
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
    found = HingeFile(
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
    found.point_at("hinge.design_speed", hinge.design_speed)
    for point in operation.points:  # refuses what cannot be read
        if point.gas_force_table is not None:
            found._gas_force(point)
    return found
