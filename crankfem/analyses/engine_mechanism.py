"""The crank mechanism that an engine file describes: pistons, rods, cranks and gas pressure."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import FloatArray
from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.quantity import format_quantity
from crankbase.results import made_from
from crankbase.summaries import summarized
from crankfem.files.engine.engine_file import EngineFile, check_driven, check_load, load_engine
from crankfem.files.engine.file_kinds import SECTIONS, check_sections, engine_sections, file_kind
from crankfem.files.engine.mechanism_cylinders import (
    MechanismSections,
    angles_of_throws,
    check_sizes,
    engine_cylinders,
    firing_evenness,
    inertia_remarks,
    side_by_side,
    throws_of,
)
from crankfem.files.engine.throw_file import ThrowFile, load_throw_file
from crankfem.files.engine.usual_parts import EngineScale, part_warnings
from crankfem.files.engine.usual_sizes import engine_warnings
from crankfem.files.engine.usual_tables import table_warnings
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_file import InputRecord, TomlFile
from crankfem.files.sections.crank_throws import (
    PLAIN,
    ShaftLayout,
    read_throws,
    throw_names,
    throws_along_shaft,
)
from crankfem.files.sections.engine_sections import Engine, Flywheel, FreeEnd
from crankfem.files.sections.mechanism_sections import (
    Gas,
    HingedRods,
    LoadSection,
    Piston,
    Rod,
    given_of_cycle,
    load_points,
)
from dynamics.engine.forces import full_load_cycles, motored_pressures, piston_position
from dynamics.engine.layout import EngineLayout, RotatingMass
from dynamics.excitation.pressure_map import (
    EnginePower,
    LoadCurve,
    PressureMap,
    indicated_power,
    load_curve,
    load_speeds,
    pressures_along,
)
from dynamics.gas.gas_cycle import FullLoad, PeakError, name_fields
from dynamics.gas.pressure import (
    ATMOSPHERE,
    HIGHEST_PEAK,
    GasPressure,
    cylinder_volume,
    motored_from_compression,
    read_pressure_table,
)
from fem.material import STEEL, Material
from geometry.crankshaft import ShaftEnds, throw_masses, throw_starts
from geometry.mass import MassProperties, unbalance
from geometry.throw import CrankThrow

NEEDED = ("engine", "throw", "rod", "piston")
READ = (
    *(*NEEDED, "shaft", "hinged_rods", "shaft_ends", "gas", "load", "flywheel", "free_end"),
    "material",
)


@summarized(
    "name",
    "path",
    "rated_speed [rad/s]",
    "layout.cylinders",
    "rotation_angles_deg [deg]",
    "remarks",
    "warnings",
)
@dataclass(frozen=True)
class MechanismFile:
    """The mechanism of an engine file, read and checked.

    Attributes
    ----------
    files : InputFiles
        The file, and those that it may name.
    name : str
        Of the engine.
    layout : EngineLayout
        Cylinders and rods alone, without the throws' unbalance and any inertia of the shaft, which
        `with_throws` adds from the throws' solids.
    pressure : tuple of GasPressure
        Cylinder by cylinder, at full load; empty if the file has no section [gas].
    power : EnginePower or None
        Indicated power at rated speed and the rated power; None without gas pressure.
    rated_speed : float
        [rad/s]
    throw, material
        Sections of the file; of several throws the one at the free end.
    crank_throws : tuple of CrankThrow
        Throw of each crank, from the free end.
    rotation_angles_deg : tuple of float
        Angle of each throw from the first, in the sense of rotation [deg].
    throws : tuple of int
        Throw that each cylinder works on, from 0.
    turning_sense : int
        1 if the shaft turns in the sense in which the file counts angles, else -1: then the layout is
        the mirror image, x against the file's.
    gas : Gas or None
        Section of the file.
    load : LoadSection or None
        Section of the file: the load as a function of the speed; None for full load at all speeds.
    attached_inertia : float
        Of flywheel and free end, if given [kg m^2].
    remarks : tuple of str
        What was assumed beyond the values of the file.
    warnings : tuple of str
        Sizes far outside of practice, and firing that could be even: perhaps slips.
    records : tuple of InputRecord
        Every value with its source.
    sources : dict
        Short name to full citation.
    """

    files: InputFiles
    name: str
    layout: EngineLayout
    pressure: tuple[GasPressure, ...]
    power: EnginePower | None
    rated_speed: float
    throw: CrankThrow
    crank_throws: tuple[CrankThrow, ...]
    material: Material
    rotation_angles_deg: tuple[float, ...]
    throws: tuple[int, ...]
    turning_sense: int
    gas: Gas | None
    load: LoadSection | None
    attached_inertia: float
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]
    records: tuple[InputRecord, ...]
    sources: dict[str, str]

    @property
    def path(self) -> Path:
        """What messages call the file, and where it is unless it was sent."""
        return self.files.path

    @property
    def bearing_positions(self) -> tuple[float, ...]:
        """Middle of each main bearing along the shaft, one more than throws [m]."""
        return throw_starts(self.crank_throws)


def load_mechanism(path: str | Path | TomlFile) -> MechanismFile:
    """Read the crank mechanism of an engine file, or of a shipped engine.

    Parameters
    ----------
    path : path
        The file, or the name of a shipped engine; or its sections, if already read. It needs
        the sections [engine], [throw] (or several [throws.NAME]), [rod] and [piston]; [gas], [load],
        [hinged_rods] and [shaft] are read if given.

    Raises
    ------
    InputError
        With a sentence for each wrong field, which names it, what was given and what is allowed.
    """
    content = engine_sections(path)
    with content.all_errors({name: SECTIONS[name].model for name in READ}, {"throws": read_throws}):
        return _read_mechanism(content)


def _read_mechanism(content: TomlFile) -> MechanismFile:
    check_sections(content, NEEDED)
    engine, throws = content.required("engine", Engine), read_throws(content)
    rod, piston = content.required("rod", Rod), content.required("piston", Piston)
    for name, throw in throws.items():
        check_sizes(engine, throw, rod, piston, name if name == PLAIN else f"throws.{name}")
    shaft, hinged = content.model("shaft", ShaftLayout), content.model("hinged_rods", HingedRods)
    content.model("shaft_ends", ShaftEnds)
    gas, load = content.model("gas", Gas), content.model("load", LoadSection)
    check_load(load, gas, None, engine)
    angles = angles_of_throws(shaft, engine, throws_of(engine))
    along = throws_along_shaft(throws, throw_names(throws, shaft, len(angles)), np.degrees(angles))
    sections = MechanismSections(
        files=content.files,
        engine=engine,
        shaft=shaft,
        named_throws=throws,
        crank_throws=along,
        rod=rod,
        piston=piston,
        hinged_rods=hinged,
        gas=gas,
        load=load,
        flywheel=content.model("flywheel", Flywheel),
        free_end=content.model("free_end", FreeEnd),
        material=content.model("material", Material) or STEEL,
        records=tuple(content.records),
        sources=content.sources,
    )
    check_driven(sections)
    return mechanism_of(sections)


Calculated = TypeVar("Calculated")


def by_gas(
    gas: Gas, layout: EngineLayout, calculate: Callable[[FullLoad, EngineLayout], Calculated]
) -> Calculated:
    """Calculate cycles from the section [gas]; errors name its fields, with pressures above ambient."""
    peak = None if gas.peak_pressure is None else gas.peak_pressure + ATMOSPHERE
    above = "" if gas.peak_pressure is None else format_quantity(gas.peak_pressure, "Pa")
    if peak is not None and peak > HIGHEST_PEAK:
        raise InputError(
            f"gas.peak_pressure: given {above} above ambient; allowed is "
            f"{format_quantity(HIGHEST_PEAK, 'Pa')} absolute at most, because no piston engine withstands "
            "more."
        )
    load = FullLoad(gas.compression_ratio, given_of_cycle(gas), peak, gas.mean_effective_pressure)
    try:
        return calculate(load, layout)
    except PeakError as error:
        raise InputError(
            f"gas.peak_pressure: given {above} above ambient; allowed in all are "
            f"{name_fields(error.allowed)}"
        ) from None
    except InputError as error:
        raise InputError(f"gas.{name_fields(error)}") from None


def motored_for_misfire(
    gas: Gas, layout: EngineLayout, pressure: Sequence[GasPressure]
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder without combustion.

    Parameters
    ----------
    gas : Gas
        The section of the engine file.
    pressure : sequence of n GasPressure
        Of the firing cylinders.

    Returns
    -------
    tuple of n GasPressure
        Of the cycle model without heat, or from the compression of the pressure table with the
        section's compression ratio.
    """
    if gas.pressure_table is None:
        return by_gas(gas, layout, motored_pressures)
    return tuple(
        motored_from_compression(
            firing,
            cylinder_volume(piston_position(layout, number), cylinder.area, gas.compression_ratio),
        )
        for number, (firing, cylinder) in enumerate(
            zip(pressure, layout.cylinders, strict=True), start=1
        )
    )


def mechanism_of(file: EngineFile | MechanismSections) -> MechanismFile:
    """Return the crank mechanism of an engine in its present state, with changes made after reading.

    Raises
    ------
    InputError
        If cranks, throws and pins contradict each other, or the gas pressure cannot be reached.
    """
    engine, layout, gas = file.engine, layout_of(file), file.gas
    if gas is None:
        pressure: tuple[GasPressure, ...] = ()
    elif gas.pressure_table is not None:
        table = replace(
            file.files.named("gas.pressure_table", gas.pressure_table, "tables"),
            reading=gas.reading,
        )
        diagram = read_pressure_table(table, layout.strokes, fires=not engine.driven_by)
        pressure = (diagram,) * len(layout.cylinders)
    elif (cycle := gas.compressor) is not None:
        pressure = tuple(
            cycle.pressure(piston_position(layout, number), cylinder.area)
            for number, cylinder in enumerate(layout.cylinders, start=1)
        )
    else:
        pressure = tuple(found.pressure for found in by_gas(gas, layout, full_load_cycles))
    power, rated = None, engine.rated_speed
    if pressure:
        indicated = indicated_power(layout, pressure, rated)
        power = EnginePower(
            rated, *indicated, engine.rated_power, driven=bool(engine.driven_by) or None
        )
    sense = engine.turning_sense
    attached = [part.inertia for part in (file.flywheel, file.free_end) if part is not None]
    return made_from(
        file,
        MechanismFile,
        name=engine.name,
        layout=layout,
        pressure=pressure,
        power=power,
        rated_speed=rated,
        throw=file.crank_throws[0],
        rotation_angles_deg=tuple(sense * angle for angle in file.throw_angles_deg),
        turning_sense=sense,
        attached_inertia=sum(attached),
        remarks=_remarks(file),
        warnings=_warnings(file, power, layout, pressure),
    )


def layout_of(file: EngineFile | MechanismSections) -> EngineLayout:
    """Return the cylinders and rods of an engine in its present state, without throws and gas pressure."""
    engine = file.engine
    cylinders = engine_cylinders(
        engine,
        file.crank_throws,
        file.rod,
        file.piston,
        file.hinged_rods,
        file.throws,
        [math.radians(angle) for angle in file.throw_angles_deg],
    )
    # Those of a driven machine may be at the top together, which no order can say.
    tops = [cylinder.top_shaft_angle_deg for cylinder in cylinders] if engine.driven_by else None
    return EngineLayout(
        0.5 * engine.stroke,
        cylinders,
        engine.top_order,
        engine.strokes,
        firing_angles_deg=tops,
    )


def _warnings(
    file: EngineFile | MechanismSections,
    power: EnginePower | None,
    layout: EngineLayout,
    pressure: Sequence[GasPressure],
) -> tuple[str, ...]:
    """Name what is far outside of practice, and so perhaps a slip."""
    thrust = file.thrust_bearing if isinstance(file, EngineFile) else None
    material = () if file.material.remark is None else (file.material.remark,)
    firing = firing_evenness(file.engine).warnings
    rated: tuple[str, ...] = ()
    if power is not None and not power.consistent:
        rated = (f"engine.rated_power: {power.sentence[0].lower()}{power.sentence[1:]}",)
    scale = EngineScale(file, None if power is None else power.indicated)
    return (
        *(*firing, *material, *rated, *engine_warnings(file, power, thrust)),
        *(*part_warnings(scale), *table_warnings(scale, layout, pressure)),
    )


def _remarks(file: EngineFile | MechanismSections) -> tuple[str, ...]:
    """Say what is assumed beyond the sections."""
    remarks = inertia_remarks(file.rod, file.hinged_rods)
    remarks += firing_evenness(file.engine).notes
    if side_by_side(file.crank_throws[0], file.throws, file.hinged_rods):
        remarks.insert(
            0,
            "rods side by side share the pin's length equally, the cylinder with the lower number "
            "nearer to the free end",
        )
    return tuple(remarks)


def load_any(path: str | Path | TomlFile) -> EngineFile | MechanismFile | ThrowFile:
    """Read and check a file of any kind: a whole engine, a mechanism, or a throw."""
    content = engine_sections(path)
    kind = file_kind(content)
    if kind == "mechanism":
        return load_mechanism(content)
    return load_throw_file(content) if kind == "throw" else load_engine(content)


def with_throws(
    mechanism: MechanismFile, masses: MassProperties | Sequence[MassProperties] | None = None
) -> EngineLayout:
    """Return the layout with the throws' unbalance and inertia, from their solids.

    Each throw is represented by two masses in the planes of its ends, with its static and dynamic
    unbalance. The inertia is that of the throws, flywheel and free end.

    Parameters
    ----------
    masses : MassProperties or sequence of such, optional
        Of the one throw that all cranks have, or of each crank's, from the free end, if
        known.

    Raises
    ------
    MeshError
        If a throw's solid cannot be built.
    """
    each, starts = _masses_along(mechanism, masses), mechanism.bearing_positions
    sense, rotating = mechanism.turning_sense, []
    for number, (masses_of_throw, throw) in enumerate(
        zip(each, mechanism.crank_throws, strict=True)
    ):
        moments, angle = (
            unbalance(masses_of_throw, 0.0),
            math.radians(mechanism.rotation_angles_deg[number]),
        )
        # Real and imaginary part lie along +y and against +x, as in the layout's frame.
        static = complex(moments.static[1], -sense * moments.static[0])
        far = complex(moments.dynamic[1], -sense * moments.dynamic[0]) / throw.length
        for moment, place in ((static - far, starts[number]), (far, starts[number + 1])):
            rotating.append(
                RotatingMass(
                    abs(moment),
                    angle_deg=math.degrees(float(np.angle(moment)) + angle),
                    position=place,
                )
            )
    inertia = mechanism.attached_inertia + math.fsum(mass.inertia_about_shaft for mass in each)
    return replace(mechanism.layout, rotating=tuple(rotating), shaft_inertia=inertia)


def _masses_along(
    mechanism: MechanismFile, masses: MassProperties | Sequence[MassProperties] | None
) -> Sequence[MassProperties]:
    """Mass properties of each crank's throw; of equal throws the solid is built once."""
    throws = mechanism.crank_throws
    if masses is None:
        density = mechanism.material.density
        known = {throw: throw_masses(throw, density) for throw in dict.fromkeys(throws)}
        return [known[throw] for throw in throws]
    if isinstance(masses, MassProperties) and len(set(throws)) == 1:
        return [masses] * len(throws)
    if isinstance(masses, MassProperties) or len(masses) != len(throws):
        of_which = "one throw" if isinstance(masses, MassProperties) else f"{len(masses)} throws"
        raise InputError(
            f"masses: given those of {of_which}; allowed are those of each of {len(throws)} "
            "cranks, because their throws differ."
        )
    return masses


def full_load_only(mechanism: MechanismFile) -> bool:
    """Return whether the load is full load at all speeds, as without a section [load]."""
    return mechanism.gas is None or mechanism.load is None or mechanism.load.law == "constant"


def curve_at(mechanism: MechanismFile, speeds: FloatArray) -> LoadCurve:
    """Return the pressures that the cycles reach at speeds [rad/s]."""
    assert mechanism.gas is not None
    assert mechanism.load is not None
    friction = 0.0 if mechanism.power is None else mechanism.power.friction_pressure
    full = by_gas(mechanism.gas, mechanism.layout, full_load_cycles)[0]
    points = load_points(mechanism.load)
    return load_curve(points, full, mechanism.rated_speed, speeds, friction)


def pressure_maps(
    mechanism: MechanismFile, speed_range: tuple[float, float], *, motored: bool = False
) -> tuple[PressureMap, ...]:
    """Return the pressure in each cylinder over a range of speeds [rad/s]."""
    assert mechanism.load is not None
    points = load_points(mechanism.load)
    speeds = load_speeds(points, speed_range, mechanism.rated_speed)
    return _maps_at(mechanism, speeds, motored=motored)


def _maps_at(
    mechanism: MechanismFile, speeds: FloatArray, *, motored: bool
) -> tuple[PressureMap, ...]:
    assert mechanism.gas is not None
    curve = curve_at(mechanism, speeds)
    full = by_gas(mechanism.gas, mechanism.layout, full_load_cycles)
    return pressures_along(curve, full, mechanism.layout, motored=motored)


def pressures_at(
    mechanism: MechanismFile, speeds: ArrayLike, *, motored: bool = False
) -> tuple[tuple[GasPressure, ...], ...]:
    """Return the pressure in each cylinder at the load of each speed.

    Parameters
    ----------
    mechanism : MechanismFile
        With a section [load] that is not full load at all speeds.
    speeds : (S,) array_like
        Ascending [rad/s].
    motored : bool, optional
        Without combustion, at the boost of this load.
    """
    maps = _maps_at(mechanism, np.asarray(speeds, dtype=np.float64), motored=motored)
    return tuple(zip(*(diagram_map.diagrams for diagram_map in maps), strict=True))


def mechanism_inputs(mechanism: EngineFile | MechanismFile) -> tuple[Path, ...]:
    """Return the engine file of a mechanism, and the pressure table that it names, if any."""
    return tuple(file.path for file in _mechanism_files(mechanism))


def engine_inputs(engine_file: EngineFile) -> tuple[InputFile, ...]:
    """Return an engine file and those it names: of pressures, at points of a map, of torque, its model."""
    points = () if engine_file.gas_map is None else engine_file.gas_map.points
    on_map = [
        engine_file.files.named("gas_map.points.pressure_table", point.pressure_table, "tables")
        for point in points
    ]
    others = (engine_file.torque_table, engine_file.model_file)
    named = (*_mechanism_files(engine_file), *on_map, *(file for file in others if file))
    return tuple(dict.fromkeys(named))


def _mechanism_files(mechanism: EngineFile | MechanismFile) -> Iterator[InputFile]:
    yield mechanism.files.own
    gas = mechanism.gas
    if gas is not None and gas.pressure_table is not None:
        yield mechanism.files.named("gas.pressure_table", gas.pressure_table, "tables")
