"""What an engine file says of its crank mechanism: loads, the throws' unbalance, what is unusual."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.sentences import kept
from crankfem.files.engine.engine_file import EngineFile, load_engine, load_mechanism
from crankfem.files.engine.file_kinds import engine_sections, file_kind
from crankfem.files.engine.full_load import by_gas
from crankfem.files.engine.mechanism_cylinders import firing_evenness
from crankfem.files.engine.throw_file import ThrowFile, load_throw_file
from crankfem.files.engine.usual_parts import (
    EngineScale,
    material_warnings,
    part_warnings,
    table_warnings,
)
from crankfem.files.engine.usual_sizes import size_warnings
from crankfem.files.reading.toml_file import InputWarning, TomlFile
from crankfem.files.sections.mechanism_sections import load_points
from dynamics.engine.forces import full_load_cycles
from dynamics.engine.layout import EngineLayout, RotatingMass
from dynamics.excitation.pressure_map import (
    LoadCurve,
    PressureMap,
    load_curve,
    load_speeds,
    pressures_along,
)
from dynamics.gas.pressure import GasPressure
from geometry.crankshaft import throw_masses
from geometry.mass import MassProperties, unbalance
from geometry.throw import CrankThrow


def load_any(path: str | Path | TomlFile) -> EngineFile | ThrowFile:
    """Read and check a file of any kind: a whole engine, a mechanism, or a throw."""
    content = engine_sections(path)
    kind = file_kind(content)
    if kind == "mechanism":
        return load_mechanism(content)
    return load_throw_file(content) if kind == "throw" else load_engine(content)


def input_warnings(engine_file: EngineFile) -> tuple[str, ...]:
    """Name what is far outside of practice, and so perhaps a slip."""
    return tuple(warning.sentence for warning in warned_inputs(engine_file))


def warned_inputs(engine_file: EngineFile) -> tuple[InputWarning, ...]:
    """Return what is far outside of practice, by fields."""
    power, scale = engine_file.power, EngineScale(engine_file)
    warnings = [
        *firing_evenness(engine_file.engine).warnings,
        *material_warnings(engine_file.material),
    ]
    if power is not None and not power.consistent:
        text = kept(power.sentence)
        warnings.append(InputWarning("engine.rated_power", f"{text[0].lower()}{text[1:]}"))
    return (
        *warnings,
        *size_warnings(engine_file),
        *part_warnings(scale),
        *table_warnings(scale),
    )


def with_throws(
    engine_file: EngineFile, masses: MassProperties | Sequence[MassProperties] | None = None
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
    each, starts = _masses_along(engine_file, masses), engine_file.bearing_positions
    sense, rotating = engine_file.engine.turning_sense, []
    for number, (masses_of_throw, throw) in enumerate(
        zip(each, engine_file.crank_throws, strict=True)
    ):
        moments, angle = (
            unbalance(masses_of_throw, 0.0),
            math.radians(engine_file.rotation_angles_deg[number]),
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
    inertia = engine_file.attached_inertia + math.fsum(mass.inertia_about_shaft for mass in each)
    return replace(engine_file.layout, rotating=tuple(rotating), shaft_inertia=inertia)


def _masses_along(
    engine_file: EngineFile, masses: MassProperties | Sequence[MassProperties] | None
) -> Sequence[MassProperties]:
    """Mass properties of each crank's throw; of equal throws the solid is built once."""
    throws = engine_file.crank_throws
    if masses is None:
        density = engine_file.material.density
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


def full_load_only(engine_file: EngineFile) -> bool:
    """Return whether the load is full load at all speeds, as without a section [load]."""
    return engine_file.gas is None or engine_file.load is None or engine_file.load.law == "constant"


def curve_at(engine_file: EngineFile, speeds: Array) -> LoadCurve:
    """Return the pressures that the cycles reach at speeds [rad/s]."""
    assert engine_file.gas is not None
    assert engine_file.load is not None
    friction = 0.0 if engine_file.power is None else engine_file.power.friction_pressure
    full = by_gas(engine_file.gas, engine_file.layout, full_load_cycles)[0]
    points = load_points(engine_file.load)
    return load_curve(points, full, engine_file.engine.rated_speed, speeds, friction)


def pressure_maps(
    engine_file: EngineFile, speed_range: tuple[float, float], *, motored: bool = False
) -> tuple[PressureMap, ...]:
    """Return the pressure in each cylinder over a range of speeds [rad/s]."""
    assert engine_file.load is not None
    points = load_points(engine_file.load)
    speeds = load_speeds(points, speed_range, engine_file.engine.rated_speed)
    return _maps_at(engine_file, speeds, motored=motored)


def _maps_at(engine_file: EngineFile, speeds: Array, *, motored: bool) -> tuple[PressureMap, ...]:
    assert engine_file.gas is not None
    curve = curve_at(engine_file, speeds)
    full = by_gas(engine_file.gas, engine_file.layout, full_load_cycles)
    return pressures_along(curve, full, engine_file.layout, motored=motored)


def pressures_at(
    engine_file: EngineFile, speeds: ArrayLike, *, motored: bool = False
) -> tuple[tuple[GasPressure, ...], ...]:
    """Return the pressure in each cylinder at the load of each speed.

    Parameters
    ----------
    engine_file : EngineFile
        With a section [load] that is not full load at all speeds.
    speeds : (S,) array_like
        Ascending [rad/s].
    motored : bool, optional
        Without combustion, at the boost of this load.
    """
    maps = _maps_at(engine_file, np.asarray(speeds, dtype=np.float64), motored=motored)
    return tuple(zip(*(diagram_map.diagrams for diagram_map in maps), strict=True))


def engine_inputs(engine_file: EngineFile) -> tuple[InputFile, ...]:
    """Return an engine file and those it names: of pressures, at points of a map, of torque, its model."""
    files, gas, gas_map = engine_file.files, engine_file.gas, engine_file.gas_map
    inputs: list[InputFile | None] = [files.main]
    if gas is not None and gas.pressure_table is not None:
        inputs.append(files.named("gas.pressure_table", gas.pressure_table, "tables"))
    for point in () if gas_map is None else gas_map.points:
        inputs.append(files.named("gas_map.points.pressure_table", point.pressure_table, "tables"))
    inputs += [engine_file.torque_table, engine_file.model_file]
    inputs += [
        InputFile(Path(throw.path))
        for throw in engine_file.named_throws.values()
        if not isinstance(throw, CrankThrow)
    ]
    read = [
        file for file in inputs if file
    ]  # how tables are read is told in mappings, which have no hash
    return tuple(file for place, file in enumerate(read) if file not in read[:place])
