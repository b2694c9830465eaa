"""Values of an engine's parts, and tables, far outside of practice, each beside the engine's other values."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.model import field_extra
from crankbase.sentences import amount, angle
from crankbase.table import text_rows
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_cylinders import inertia_of_masses
from crankfem.files.engine.usual_sizes import PRACTICE, SHIPPED, UsualRange
from crankfem.files.reading.toml_file import InputWarning
from dynamics.engine.forces import piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.gas.pressure import (
    ATMOSPHERE,
    GasPressure,
    compression_line,
    cylinder_volume,
    periodic_slope,
)
from dynamics.harmonics import read_torque_table
from fem.material import STEEL, Material
from geometry.any_throw import dimensioned
from geometry.crankshaft import throw_masses
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from regression.plans.plan import StudyPlan


@dataclass(frozen=True)
class EngineScale:
    """What the usual values of an engine's parts go by, estimated from its dimensions and masses."""

    file: EngineFile

    def part(self, section: str) -> Any:
        """Return a section of the file; None where it has none."""
        return getattr(self.file, "two_mass" if section == "two_mass_check" else section, None)

    def value(self, path: str) -> Any:
        """Return what `COMPARED`, an attribute or a field calls so; of a field None where there is none."""
        if path in COMPARED:
            return COMPARED[path](self)
        section, _, name = path.partition(".")
        return getattr(self.part(section), name, None) if name else getattr(self, path)

    @property
    def journal(self) -> float:
        """Diameter of the main journals [m]."""
        return self.file.crank_throws[0].main_journal_diameter

    @cached_property
    def swept(self) -> float:
        """Swept volume of all cylinders [m^3]."""
        engine = self.file.engine
        return 0.25 * math.pi * engine.bore**2 * engine.stroke * engine.cylinders

    @cached_property
    def crank_mass(self) -> float:
        """Mass of the shaft's throws, with webs as plates [kg]."""
        return sum(mass for mass, _ in self._throws)

    @cached_property
    def crank_inertia(self) -> float:
        """Inertia of throws, rods and half of the reciprocating masses [kg m^2]."""
        file, radius = self.file, self.file.crank_throws[0].crank_radius
        moved = 0.5 * (file.rod.mass + file.rod.rotating_mass + file.piston.mass)
        return (
            sum(inertia for _, inertia in self._throws) + file.engine.cylinders * moved * radius**2
        )

    @cached_property
    def _throws(self) -> list[tuple[float, float]]:
        """Mass [kg] and inertia [kg m^2] of each throw."""
        parts = []
        for throw in self.file.crank_throws:
            radius, density = throw.crank_radius, self.file.material.density
            if not isinstance(throw, CrankThrow):
                masses = throw_masses(throw, density)
                parts.append((masses.mass, masses.inertia_about_shaft))
                continue
            diameter, length = throw.main_journal_diameter, throw.main_journal_length
            pin = 0.25 * math.pi * throw.pin_diameter**2 * throw.pin_length * density
            journal = 0.25 * math.pi * diameter**2 * length * density
            long = radius + 0.5 * (diameter + throw.pin_diameter)
            webs = 2.0 * throw.web_thickness * throw.web_width * long * density
            plate = (long**2 + throw.web_width**2) / 12.0 + 0.25 * radius**2
            parts.append((pin + journal + webs, pin * radius**2 + webs * plate))
        return parts

    @cached_property
    def throw_stiffness(self) -> float:
        """Torsional stiffness of a plain shaft of the journals' diameter, as long as a throw [N m/rad]."""
        throw = self.file.crank_throws[0]
        area = math.pi / 32.0 * throw.main_journal_diameter**4
        return self.file.material.shear_modulus * area / throw.length

    @cached_property
    def frequency(self) -> float:
        """First natural frequency of the shaft in torsion, held at the flywheel [rad/s]."""
        throws = len(self.file.crank_throws)
        throw_frequency = math.sqrt(self.throw_stiffness * throws / self.crank_inertia)
        return 2.0 * throw_frequency * math.sin(0.5 * math.pi / (2 * throws + 1))

    @cached_property
    def rated(self) -> float:
        """Rated power, or the indicated one, or that of a usual pressure, given or taken [W]."""
        engine, power = self.file.engine, self.file.power
        if engine.rated_power:
            return engine.rated_power
        cycles = engine.rated_speed / (math.pi * engine.strokes)
        return abs(0.0 if power is None else power.indicated) or 1.4e6 * self.swept * cycles

    @cached_property
    def torque(self) -> float:
        """Torque at the rated point [N m]."""
        return self.rated / self.file.engine.rated_speed


Practice = partial(UsualRange, basis=PRACTICE)
# What a value may be compared with beside an attribute of the scale or a field.
COMPARED: Mapping[str, Callable[[EngineScale], float]] = {
    "1": lambda _: 1.0,
    "1 deg": lambda _: math.radians(1.0),
    "steel": lambda _: STEEL.poisson_ratio,
    "two masses": lambda scale: inertia_of_masses(scale.file.rod),
    "pin": lambda scale: scale.file.crank_throws[0].pin_diameter,
    "end": lambda scale: scale.part("free_end").inertia / scale.journal**2,
    "ring w": lambda scale: scale.part("torsional_damper").ring_inertia * scale.frequency,
    "ring w^2": lambda scale: scale.part("torsional_damper").ring_inertia * scale.frequency**2,
    "root": lambda scale: math.sqrt(scale.part("thrust_bearing").stiffness * scale.crank_mass),
    "engine": lambda scale: scale.crank_inertia + scale.part("flywheel").inertia,
    "coupling": lambda scale: (
        scale.part("driven").coupling_stiffness / scale.file.engine.rated_speed
    ),
    "crank w": lambda scale: scale.crank_inertia * scale.frequency / scale.file.engine.cylinders,
    "E d": lambda scale: scale.file.material.youngs_modulus * scale.journal,
    "bearing": lambda scale: scale.part("bearings").stiffness / scale.file.engine.rated_speed,
    "G / 1e3": lambda scale: scale.file.material.shear_modulus / 1e3,
    "stroke / 1e3": lambda scale: scale.file.engine.stroke / 1e3,
    "piston": lambda scale: (
        1e6 * scale.swept / scale.file.engine.stroke / scale.file.engine.cylinders
    ),
    "shaft": lambda scale: sum(throw.length for throw in scale.file.crank_throws),
}
# Field; lowest and highest usual ratio, and margin; what it is the ratio to, as
# `EngineScale.value` finds it; how it is written; its unit if it is no factor. Where the shipped engines have
# the part, the range is theirs; the margins leave room for engines unlike them.
USUAL = """
material.poisson_ratio | 0.83 1.2 1.1 | steel | that of steel
rod.rotating_mass | 0.61 0.7 1.35 | rod.mass | the rod's mass | | shipped
rod.inertia | 0.7 1.2 2 | two masses | that of two masses at its pins
piston.pin_offset | 0 0.1 2 | engine.bore | the bore
hinged_rods.pin_radius | 0.7 1.3 2 | pin | the pin's diameter
hinged_rods.length | 0.6 1 1.5 | rod.length | that of the main rod
hinged_rods.mass | 0.3 1 2 | rod.mass | that of the main rod
hinged_rods.rotating_mass | 0.4 0.7 1.35 | hinged_rods.mass | the hinged rod's mass
shaft_ends.free_end_diameter | 0.7 0.8 1.5 | journal | the main journal's diameter | | shipped
shaft_ends.free_end_length | 0.8 1.2 5 | journal | the main journal's diameter | | shipped
shaft_ends.flange_diameter | 1.5 2 1.5 | journal | the main journal's diameter | | shipped
shaft_ends.flange_thickness | 0.19 0.26 3 | journal | the main journal's diameter | | shipped
flywheel.diametral_inertia | 0.5 1 1.5 | flywheel.inertia | its inertia about the shaft
flywheel.overhang | 0 1 2 | journal | the main journal's diameter
free_end.mass | 0.5 10 4 | end | its inertia over the main journal's diameter squared
free_end.diametral_inertia | 0.5 1 1.5 | free_end.inertia | its inertia about the shaft
torsional_damper.ring_inertia | 0.1 0.4 1.2 | crank_inertia | that of cranks and rods
torsional_damper.damping | 0.4 1.2 5 | ring w | the ring's inertia times the shaft's first frequency
torsional_damper.stiffness | 0.2 1 5 | ring w^2 | the ring's inertia times the shaft's first frequency squared
torsional_damper.loss_factor | 0.05 0.4 3 | 1 | | of the stiffness
axial_damper.damping | 0.1 0.5 5 | root | the root of thrust stiffness times the throws' mass
axial_damper.stiffness | 0.01 1 3 | thrust_bearing.stiffness | that of the thrust bearing
driven.coupling_loss_factor | 0.005 0.25 3 | 1 | | of the stiffness
driven.coupling_damping | 0.001 0.5 3 | coupling | the coupling's stiffness over the rated speed
damping.torsional_magnifier | 12 60 2.5 | 1 | the static amplitude
damping.axial_magnifier | 12 60 2.5 | 1 | the static amplitude
damping.bending_magnifier | 12 60 2.5 | 1 | the static amplitude
damping.loss_factor | 0.005 0.05 3 | 1 | | of the stiffness
damping.cylinder_damping | 0.005 0.05 5 | crank w | a crank's inertia times the shaft's first frequency
bearings.stiffness | 0.01 0.2 5 | E d | E times the main journal's diameter
bearings.lowest_stiffness | 0.1 1 3 | bearings.stiffness | the bearings' stiffness
bearings.highest_stiffness | 1 10 3 | bearings.stiffness | the bearings' stiffness
bearings.damping | 0.001 1 5 | bearing | the bearings' stiffness over the rated speed
limits.crankshaft_stress | 0.2 0.9 2.5 | G / 1e3 | of the shear modulus | MPa per GPa
limits.crankshaft_stress_passing | 1 3 2 | limits.crankshaft_stress | crankshaft_stress
limits.coupling_torque | 0.2 1 5 | torque | the rated torque
limits.coupling_torque_passing | 1 4 2 | limits.coupling_torque | coupling_torque
limits.damper_torque | 0.1 1 5 | torque | the rated torque
limits.coupling_heat | 0.0002 0.003 5 | rated | the rated power
limits.damper_heat | 0.001 0.01 5 | rated | the rated power
limits.generator_angle | 2 5 4 | 1 deg | of electrical angle | deg
limits.torsional_amplitude | 0.1 1.5 5 | 1 deg | of twist | deg
limits.axial_amplitude | 0.2 2 5 | stroke / 1e3 | of stroke | mm per m
limits.axial_force | 0.1 2 5 | piston | on the piston | MPa
two_mass_check.shaft_diameter | 0.7 1.3 1.5 | journal | the main journal's diameter
two_mass_check.shaft_length | 0.4 1.5 3 | shaft | the length of all throws
two_mass_check.shear_modulus | 0.95 1.05 1.5 | material.shear_modulus | that of the material
two_mass_check.engine_inertia | 0.5 1.5 1.6 | crank_inertia | that of cranks and rods
two_mass_check.flywheel_inertia | 0.8 1.25 3 | flywheel.inertia | the flywheel's
"""


def _usual(numbers: str, words: str, unit: str = "", basis: str = "") -> UsualRange:
    low, high, margin = map(float, numbers.split())
    meaning, basis = f"is {{}} {words}".rstrip(), SHIPPED if basis else PRACTICE
    return UsualRange(low, high, meaning, unit or "times", basis, margin)


PARTS = {
    field: (beside, _usual(numbers, *cells)) for field, numbers, beside, *cells in text_rows(USUAL)
}
POISSON = PARTS["material.poisson_ratio"][1]


def material_warnings(material: Material) -> tuple[InputWarning, ...]:
    """Name a modulus that does not go with the density."""
    remark = material.remark
    return () if remark is None else (InputWarning("material.youngs_modulus", remark),)


def part_warnings(scale: EngineScale) -> Iterator[InputWarning]:
    """Name the values of parts, limits and throw angles that are far outside of practice."""
    for field, (compared, usual) in PARTS.items():
        value = scale.value(field)
        if value:  # zero is what most of these are without the part
            section, name = field.split(".")
            unit = field_extra(type(scale.part(section)).model_fields[name], "unit")
            yield from usual.warning_of(field, value, unit, abs(value) / scale.value(compared))
    shaft, engine = scale.file.shaft, scale.file.engine
    yield from near_angles("shaft.throw_angles", None if shaft is None else shaft.throw_angles)
    yield from near_angles("engine.bank_angles", engine.bank_angles)
    yield from _counterweights(scale)
    driven = scale.part("driven")
    if driven is not None:
        usual, beside = DRIVEN, scale.value("engine")
        if engine.drives == "generator":
            usual, beside = ROTOR, ROTOR_SCALE * scale.torque ** (5.0 / 3.0)
        inertia, stiffness = driven.inertia, driven.coupling_stiffness
        yield from usual.warning_of("driven.inertia", inertia, "kg m^2", inertia / beside)
        coupling = RUBBER if driven.loss_factor >= DAMPS else ANY_COUPLING
        yield from coupling.warning_of(
            "driven.coupling_stiffness", stiffness, "N m/rad", stiffness / scale.torque
        )
    yield from (warning for warning, twice in first_nodes(scale.file) if twice)


DRIVEN = Practice(0.3, 3.0, "is {} that of engine and flywheel", margin=5.0)
# A rotor's volume goes with the torque T [N m] and its inertia with the volume to the power of 5/3: of
# synchronous generators with 4 to 12 poles 1.2e-5 to 4e-5 kg m^2 for T = 1 N m.
ROTOR = Practice(0.45, 1.6, "is {} that usual of a generator for the rated torque", margin=1.15)
ROTOR_SCALE = 2.6e-5
# A coupling that damps is of rubber, and soft.
DAMPS = 0.05
RUBBER = Practice(
    2.5, 60.0, "is {} the rated torque for each radian, where rubber damps", margin=1.5
)
ANY_COUPLING = Practice(2.5, 1000.0, "is {} the rated torque for each radian")


# What a line's first node may have of the flywheel's inertia before it is perhaps the flywheel itself.
FLYWHEEL_AGAIN = (0.5, 2.0)


def first_nodes(file: EngineFile) -> Iterator[tuple[InputWarning, bool]]:
    """Say what a line's first node adds to the flywheel, and whether that is perhaps counted twice."""
    wheel = file.flywheel
    if wheel is None:
        return
    for kind, size, unit in (("torsional", wheel.inertia, "kg m^2"), ("axial", wheel.mass, "kg")):
        if (line := file.shaft_lines.get(kind)) is None:
            continue
        added = float(line.inertia[0])
        twice = FLYWHEEL_AGAIN[0] <= added / size <= FLYWHEEL_AGAIN[1]
        text = (
            f"its first node {line.names[0]!r} is the flywheel, and adds "
            f"{amount(added, unit, 4)} to the {amount(size, unit, 4)} of [flywheel]"
        )
        hint = "; perhaps both files give the flywheel" if twice else ""
        yield InputWarning(f"shaft_line.{kind}", text + hint), twice


# Throws and banks are at one angle, or further apart than this [deg].
NEAREST_ANGLES = 5.0


def near_angles(field: str, angles: Sequence[float] | None) -> Iterator[InputWarning]:
    """Tell of angles that differ by less than any throws or banks do."""
    between = [
        abs(math.degrees(math.remainder(first - second, math.tau)))
        for first, second in combinations(angles or (), 2)
    ]
    near = [gap for gap in between if 1e-3 < gap < NEAREST_ANGLES]
    if near:
        yield InputWarning(
            field,
            f"two of these differ by {angle(min(near), 3)}; usual is one angle or at least "
            f"{angle(NEAREST_ANGLES)} between them ({PRACTICE})",
        )


# Share of the pin's length that a counterweight may reach over the pin beside a rod.
BESIDE_ROD = 0.05


def _counterweights(scale: EngineScale) -> Iterator[InputWarning]:
    """Tell of counterweights and webs that reach the piston at the bottom, or the rod."""
    file = scale.file
    skirt = file.piston.skirt_length or 0.0
    for name, throw in dimensioned(file.named_throws).items():
        section = name if name == "throw" else f"throws.{name}"
        room = file.rod.length - throw.crank_radius - skirt
        for side, web in (("left_web", throw.left_web), ("right_web", throw.right_web)):
            weight = (web and web.counterweight) or throw.counterweight
            thickness = (web and web.thickness) or throw.web_thickness
            reach = max(weight.outer_radius if weight else 0.0, 0.5 * throw.web_width)
            if reach >= room:
                yield InputWarning(
                    section,
                    f"counterweight or web reaches {amount(reach, 'm', 4)} from the "
                    f"shaft axis on the {side}, where {'the skirt' if skirt else 'the piston pin'} comes "
                    f"down to {amount(room, 'm', 4)}: they meet",
                )
            over = weight and weight.offset + 0.5 * ((weight.thickness or thickness) - thickness)
            if over and over > BESIDE_ROD * throw.pin_length:
                yield InputWarning(
                    f"{section}.counterweight",
                    f"reaches {amount(over, 'm', 4)} over the pin on the "
                    f"{side}, where the rod's big end is; usual is at most {BESIDE_ROD:g} of pin_length, "
                    f"{amount(BESIDE_ROD * throw.pin_length, 'm', 4)} ({PRACTICE})",
                )


LEVELS = Practice(0.5, 1.5, "is {} that of the throw", margin=3.0)


def study_warnings(study: "StudyPlan") -> Iterator[InputWarning]:
    """Name levels of a study that are far from the throw that it varies."""
    for factor in study.factors:
        usual = getattr(study.throw, factor.name, None)
        if factor.labels or not isinstance(usual, float) or usual <= 0.0:
            continue
        for level in factor.levels or (factor.lowest, factor.highest):
            yield from LEVELS.warning_of(
                f"study.factors.{factor.name}", level, factor.unit, level / usual
            )


EXPONENT = Practice(
    1.25, 1.4, "has a compression line with {} for exponent", "in p V^n", margin=1.06
)
PEAK_ANGLE = Practice(2.0, 20.0, "is highest {} after the top", "deg", margin=1.5)
LOWEST = Practice(0.7, 3.0, "is {} the atmosphere", margin=1.3)
MEAN_TORQUE = Practice(0.8, 1.3, "is {} the rated torque for each throw")
# Between these angles [deg] the pressure rises to its peak and falls behind it; a change against that of
# this share is a dropout, more than the waves of a gauge's channel.
CLOSED, DROPOUT = 90.0, 0.15


def table_warnings(scale: EngineScale) -> Iterator[InputWarning]:
    """Name what is unusual of an engine's tables of pressure and torque."""
    file = scale.file
    if file.gas is not None and file.gas.pressure_table is not None and not file.engine.driven_by:
        yield from pressure_warnings(file.pressure[0], file.layout, file.gas.compression_ratio)
    if file.torque_table is not None:
        table = read_torque_table(file.torque_table, strokes=file.engine.strokes)
        # A table is compared with the torque of a throw at the rated point.
        layout, pressure = scale.file.layout, scale.file.pressure
        field, mean = "torque.table", float(table.torque.mean())
        sense = -1.0 if scale.file.engine.driven_by else 1.0
        usual = sense * scale.torque / len(scale.file.crank_throws)
        hint = "; perhaps sign or order of the samples" if mean * usual < 0.0 else ""
        for warning in MEAN_TORQUE.warning_of(field, mean, "N m", mean / usual):
            yield warning.with_hint(hint)
        if pressure and len(layout.cylinders) == len(scale.file.crank_throws):
            torque = cylinder_torque(scale, layout, pressure[0], table.torque.size)
            along, against = (
                _likeness(torque, samples) for samples in (table.torque, table.torque[::-1])
            )
            if against > along:
                yield InputWarning(
                    field,
                    f"in the order given its samples correlate by {along:.2g} with the torque of a "
                    f"throw at rated speed, in the reverse order by {against:.2g}; perhaps the angles "
                    "are in reverse order",
                )


def pressure_warnings(
    pressure: GasPressure, layout: EngineLayout, compression_ratio: float
) -> Iterator[InputWarning]:
    """Compare a measured diagram with the compression, peak and lowest pressure of engines."""
    field = "gas.pressure_table"
    volume = cylinder_volume(
        piston_position(layout, 1), layout.cylinders[0].area, compression_ratio
    )
    exponent = -compression_line(pressure, volume)[0]
    text = f"the pressure, with compression ratio {compression_ratio:g}"
    for warning in EXPONENT.warning(field, text, exponent):
        yield warning.with_hint("; perhaps shifted, or gauge for absolute")
    peak = amount(pressure.peak_pressure, "Pa", 3)
    yield from PEAK_ANGLE.warning(field, f"its peak of {peak}", pressure.peak_angle_deg)
    least = f"its lowest pressure of {amount(pressure.lowest, 'Pa', 3)}"
    for warning in LOWEST.warning(field, least, pressure.lowest / ATMOSPHERE):
        yield warning.with_hint("; perhaps gauge for absolute, or a dropout")
    order = np.argsort(pressure.angles_from_top)
    angles, values = pressure.angles_from_top[order], pressure.pressure[order]
    top = int(np.argmax(values))
    # Towards the peak from either side, each sample beside the highest before it.
    for near in (slice(top + 1), slice(None, top - 1 if top else None, -1)):
        within = np.abs(angles[near]) <= CLOSED
        rising, at = values[near][within], angles[near][within]
        falls = rising / np.maximum.accumulate(rising)
        if falls.size and falls.min() < 1.0 - DROPOUT:
            yield InputWarning(
                field,
                f"the pressure at {angle(at[int(np.argmin(falls))], 4)} is {falls.min():.3g} times "
                f"that farther from the peak; usual is at least {1.0 - DROPOUT:g} times ({EXPONENT.basis}); "
                "perhaps a dropout",
            )


def cylinder_torque(
    scale: EngineScale, layout: EngineLayout, pressure: GasPressure, samples: int
) -> Array:
    """Return the torque of gas and reciprocating mass of the first cylinder over a cycle [N m]."""
    angles = 180.0 * layout.strokes / samples * np.arange(samples)
    period = math.pi * layout.strokes
    slope = periodic_slope(piston_position(layout, 1)(np.radians(angles)), period)
    rod = scale.file.rod
    mass = scale.file.piston.mass + rod.mass - rod.rotating_mass
    force = (pressure.at(angle_deg=angles) - ATMOSPHERE) * layout.cylinders[0].area
    inertia = mass * scale.file.engine.rated_speed**2 * periodic_slope(slope, period)
    return np.asarray(-(force + inertia) * slope)


def _likeness(first: Array, second: Array) -> float:
    """Return the largest correlation of two series over a cycle, wherever either begins."""
    parts = [np.fft.rfft(series - series.mean()) for series in (first, second)]
    shifted = np.fft.irfft(parts[0] * np.conj(parts[1]), n=first.size)
    return float(shifted.max() / first.size / (first.std() * second.std() + 1e-300))
