"""Values of an engine's parts far outside of practice, each beside the engine's other values."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations
from typing import Any

from crankbase.model import field_extra
from crankbase.quantity import format_quantity
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_cylinders import MechanismSections, inertia_of_masses
from crankfem.files.engine.usual_sizes import PRACTICE, UsualRange
from fem.material import STEEL
from regression.plans.plan import StudyPlan


@dataclass(frozen=True)
class EngineScale:
    """What the usual values of an engine's parts go by, estimated from its dimensions and masses.

    Attributes
    ----------
    power : float or None
        Indicated power at rated speed, if the pressure is known [W].
    """

    file: EngineFile | MechanismSections
    power: float | None

    def part(self, section: str) -> Any:
        """Return a section of the file; None where it has none."""
        return getattr(self.file, "two_mass" if section == "two_mass_check" else section, None)

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
            pin = 0.25 * math.pi * throw.pin_diameter**2 * throw.pin_length * density
            journal = (
                0.25
                * math.pi
                * throw.main_journal_diameter**2
                * throw.main_journal_length
                * density
            )
            long = radius + 0.5 * (throw.main_journal_diameter + throw.pin_diameter)
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
        one = math.sqrt(self.throw_stiffness * throws / self.crank_inertia)
        return 2.0 * one * math.sin(0.5 * math.pi / (2 * throws + 1))

    @cached_property
    def rated(self) -> float:
        """Rated power, or the indicated one, or that of a usual pressure [W]."""
        engine = self.file.engine
        cycles = engine.rated_speed / (math.pi * engine.strokes)
        return engine.rated_power or self.power or 1.4e6 * self.swept * cycles

    @cached_property
    def torque(self) -> float:
        """Torque at the rated point [N m]."""
        return self.rated / self.file.engine.rated_speed


Practice = partial(UsualRange, basis=PRACTICE)
POISSON = Practice(0.83, 1.2, "is {} that of steel", margin=1.1)
MAGNIFIES = "is {} the static amplitude"
# Field to what its value is compared with, and the usual ratio. Where the shipped engines have the part, the
# range is theirs; the margins leave room for engines unlike them.
PARTS: Mapping[str, tuple[Callable[[EngineScale], float] | float, UsualRange]] = {
    "material.poisson_ratio": (STEEL.poisson_ratio, POISSON),
    "rod.rotating_mass": (
        lambda scale: scale.file.rod.mass,
        UsualRange(0.61, 0.7, "is {} the rod's mass", margin=1.35),
    ),
    "rod.inertia": (
        lambda scale: inertia_of_masses(scale.file.rod),
        Practice(0.7, 1.2, "is {} that of two masses at its pins"),
    ),
    "piston.pin_offset": (
        lambda scale: scale.file.engine.bore,
        Practice(0.0, 0.1, "is {} the bore"),
    ),
    "hinged_rods.pin_radius": (
        lambda scale: scale.file.crank_throws[0].pin_diameter,
        Practice(0.7, 1.3, "is {} the pin's diameter"),
    ),
    "hinged_rods.length": (
        lambda scale: scale.file.rod.length,
        Practice(0.6, 1.0, "is {} that of the main rod", margin=1.5),
    ),
    "hinged_rods.mass": (
        lambda scale: scale.file.rod.mass,
        Practice(0.3, 1.0, "is {} that of the main rod"),
    ),
    "hinged_rods.rotating_mass": (
        lambda scale: scale.part("hinged_rods").mass,
        Practice(0.4, 0.7, "is {} the hinged rod's mass", margin=1.35),
    ),
    "shaft_ends.free_end_diameter": (
        lambda scale: scale.journal,
        UsualRange(0.7, 0.8, "is {} the main journal's diameter", margin=1.5),
    ),
    "shaft_ends.free_end_length": (
        lambda scale: scale.journal,
        UsualRange(0.8, 1.2, "is {} the main journal's diameter", margin=5.0),
    ),
    "shaft_ends.flange_diameter": (
        lambda scale: scale.journal,
        UsualRange(1.5, 2.0, "is {} the main journal's diameter", margin=1.5),
    ),
    "shaft_ends.flange_thickness": (
        lambda scale: scale.journal,
        UsualRange(0.19, 0.26, "is {} the main journal's diameter", margin=3.0),
    ),
    "flywheel.diametral_inertia": (
        lambda scale: scale.part("flywheel").inertia,
        Practice(0.5, 1.0, "is {} its inertia about the shaft", margin=1.5),
    ),
    "flywheel.overhang": (
        lambda scale: scale.journal,
        Practice(0.0, 1.0, "is {} the main journal's diameter"),
    ),
    "free_end.inertia": (
        lambda scale: scale.crank_inertia,
        UsualRange(0.0078, 0.12, "is {} that of cranks and rods", margin=4.0),
    ),
    "free_end.mass": (
        lambda scale: scale.part("free_end").inertia / scale.journal**2,
        Practice(
            0.5, 10.0, "is {} its inertia over the main journal's diameter squared", margin=4.0
        ),
    ),
    "free_end.diametral_inertia": (
        lambda scale: scale.part("free_end").inertia,
        Practice(0.5, 1.0, "is {} its inertia about the shaft", margin=1.5),
    ),
    "torsional_damper.ring_inertia": (
        lambda scale: scale.crank_inertia,
        Practice(0.1, 0.4, "is {} that of cranks and rods", margin=4.0),
    ),
    "torsional_damper.damping": (
        lambda scale: scale.part("torsional_damper").ring_inertia * scale.frequency,
        Practice(
            0.4, 1.2, "is {} the ring's inertia times the shaft's first frequency", margin=5.0
        ),
    ),
    "torsional_damper.stiffness": (
        lambda scale: scale.part("torsional_damper").ring_inertia * scale.frequency**2,
        Practice(
            0.2,
            1.0,
            "is {} the ring's inertia times the shaft's first frequency squared",
            margin=5.0,
        ),
    ),
    "torsional_damper.loss_factor": (
        1.0,
        Practice(0.05, 0.4, "is {}", "of the stiffness", margin=3.0),
    ),
    "axial_damper.damping": (
        lambda scale: math.sqrt(scale.part("thrust_bearing").stiffness * scale.crank_mass),
        Practice(0.1, 0.5, "is {} the root of thrust stiffness times the throws' mass", margin=5.0),
    ),
    "axial_damper.stiffness": (
        lambda scale: scale.part("thrust_bearing").stiffness,
        Practice(0.01, 1.0, "is {} that of the thrust bearing", margin=3.0),
    ),
    "driven.inertia": (
        lambda scale: scale.crank_inertia + scale.part("flywheel").inertia,
        Practice(0.3, 3.0, "is {} that of engine and flywheel", margin=5.0),
    ),
    "driven.coupling_stiffness": (
        lambda scale: scale.torque,
        Practice(2.5, 1000.0, "is {} the rated torque for each radian"),
    ),
    "driven.coupling_loss_factor": (
        1.0,
        Practice(0.005, 0.25, "is {}", "of the stiffness", margin=3.0),
    ),
    "driven.coupling_damping": (
        lambda scale: scale.part("driven").coupling_stiffness / scale.file.engine.rated_speed,
        Practice(0.001, 0.5, "is {} the coupling's stiffness over the rated speed", margin=3.0),
    ),
    "damping.torsional_magnifier": (1.0, Practice(12.0, 60.0, MAGNIFIES, margin=2.5)),
    "damping.axial_magnifier": (1.0, Practice(12.0, 60.0, MAGNIFIES, margin=2.5)),
    "damping.bending_magnifier": (1.0, Practice(12.0, 60.0, MAGNIFIES, margin=2.5)),
    "damping.loss_factor": (1.0, Practice(0.005, 0.05, "is {}", "of the stiffness", margin=3.0)),
    "damping.cylinder_damping": (
        lambda scale: scale.crank_inertia * scale.frequency / scale.file.engine.cylinders,
        Practice(
            0.005, 0.05, "is {} a crank's inertia times the shaft's first frequency", margin=5.0
        ),
    ),
    "bearings.stiffness": (
        lambda scale: scale.file.material.youngs_modulus * scale.journal,
        Practice(0.01, 0.2, "is {} E times the main journal's diameter", margin=5.0),
    ),
    "bearings.lowest_stiffness": (
        lambda scale: scale.part("bearings").stiffness,
        Practice(0.1, 1.0, "is {} the bearings' stiffness", margin=3.0),
    ),
    "bearings.highest_stiffness": (
        lambda scale: scale.part("bearings").stiffness,
        Practice(1.0, 10.0, "is {} the bearings' stiffness", margin=3.0),
    ),
    "bearings.damping": (
        lambda scale: scale.part("bearings").stiffness / scale.file.engine.rated_speed,
        Practice(0.001, 1.0, "is {} the bearings' stiffness over the rated speed", margin=5.0),
    ),
    "limits.crankshaft_stress": (
        lambda scale: scale.file.material.shear_modulus / 1e3,
        Practice(0.2, 0.9, "is {} of the shear modulus", "MPa per GPa", margin=2.5),
    ),
    "limits.crankshaft_stress_passing": (
        lambda scale: scale.part("limits").crankshaft_stress,
        Practice(1.0, 3.0, "is {} crankshaft_stress"),
    ),
    "limits.coupling_torque": (
        lambda scale: scale.torque,
        Practice(0.2, 1.0, "is {} the rated torque", margin=5.0),
    ),
    "limits.coupling_torque_passing": (
        lambda scale: scale.part("limits").coupling_torque,
        Practice(1.0, 4.0, "is {} coupling_torque"),
    ),
    "limits.damper_torque": (
        lambda scale: scale.torque,
        Practice(0.1, 1.0, "is {} the rated torque", margin=5.0),
    ),
    "limits.coupling_heat": (
        lambda scale: scale.rated,
        Practice(2e-4, 3e-3, "is {} the rated power", margin=5.0),
    ),
    "limits.damper_heat": (
        lambda scale: scale.rated,
        Practice(1e-3, 1e-2, "is {} the rated power", margin=5.0),
    ),
    "limits.generator_angle": (
        math.radians(1.0),
        Practice(2.0, 5.0, "is {} of electrical angle", "deg", margin=4.0),
    ),
    "limits.torsional_amplitude": (
        math.radians(1.0),
        Practice(0.1, 1.5, "is {} of twist", "deg", margin=5.0),
    ),
    "limits.axial_amplitude": (
        lambda scale: scale.file.engine.stroke / 1e3,
        Practice(0.2, 2.0, "is {} of stroke", "mm per m", margin=5.0),
    ),
    "limits.axial_force": (
        lambda scale: 1e6 * scale.swept / scale.file.engine.stroke / scale.file.engine.cylinders,
        Practice(0.1, 2.0, "is {} on the piston", "MPa", margin=5.0),
    ),
    "two_mass_check.shaft_diameter": (
        lambda scale: scale.journal,
        Practice(0.7, 1.3, "is {} the main journal's diameter", margin=1.5),
    ),
    "two_mass_check.shaft_length": (
        lambda scale: sum(throw.length for throw in scale.file.crank_throws),
        Practice(0.4, 1.5, "is {} the length of all throws", margin=3.0),
    ),
    "two_mass_check.shear_modulus": (
        lambda scale: scale.file.material.shear_modulus,
        Practice(0.95, 1.05, "is {} that of the material", margin=1.5),
    ),
    "two_mass_check.engine_inertia": (
        lambda scale: scale.crank_inertia,
        Practice(0.5, 1.5, "is {} that of cranks and rods", margin=3.0),
    ),
    "two_mass_check.flywheel_inertia": (
        lambda scale: scale.part("flywheel").inertia,
        Practice(0.8, 1.25, "is {} the flywheel's", margin=3.0),
    ),
}


def part_warnings(scale: EngineScale) -> Iterator[str]:
    """Name the values of parts, limits and throw angles that are far outside of practice."""
    for field, (compared, usual) in PARTS.items():
        section, name = field.split(".")
        part = scale.part(section)
        value = getattr(part, name, None)
        if value:  # zero is what most of these are without the part
            unit = field_extra(type(part).model_fields[name], "unit")
            beside = compared(scale) if callable(compared) else compared
            yield from usual.warning_of(field, value, unit, abs(value) / beside)
    shaft, engine = scale.file.shaft, scale.file.engine
    yield from near_angles("shaft.throw_angles", None if shaft is None else shaft.throw_angles)
    yield from near_angles("engine.bank_angles", engine.bank_angles)
    yield from _counterweights(scale)
    if isinstance(scale.file, EngineFile):
        yield from (sentence for sentence, twice in first_nodes(scale.file) if twice)


# What a line's first node may have of the flywheel's inertia before it is perhaps the flywheel itself.
FLYWHEEL_AGAIN = (0.5, 2.0)


def first_nodes(file: EngineFile) -> Iterator[tuple[str, bool]]:
    """Say what a line's first node adds to the flywheel, and whether that is perhaps counted twice."""
    wheel = file.flywheel
    for kind, size, unit in (
        ("torsional", wheel.inertia, "kg m^2"),
        ("axial", wheel.mass, "kg"),
    ):
        if (line := file.shaft_lines.get(kind)) is None:
            continue
        added = float(line.inertia[0])
        twice = FLYWHEEL_AGAIN[0] <= added / size <= FLYWHEEL_AGAIN[1]
        sentence = (
            f"shaft_line.{kind}: its first node {line.names[0]!r} is the flywheel, and adds "
            f"{format_quantity(added, unit, 4)} to the {format_quantity(size, unit, 4)} of [flywheel]"
        )
        yield sentence + ("; perhaps both files give the flywheel" if twice else ""), twice


# Throws and banks are at one angle, or further apart than this [deg].
NEAREST_ANGLES = 5.0


def near_angles(field: str, angles: Sequence[float] | None) -> Iterator[str]:
    """Tell of angles that differ by less than any throws or banks do."""
    between = [
        abs(math.degrees(math.remainder(first - second, math.tau)))
        for first, second in combinations(angles or (), 2)
    ]
    near = [angle for angle in between if 1e-3 < angle < NEAREST_ANGLES]
    if near:
        yield (
            f"{field}: two of these differ by {min(near):.3g} deg; usual is one angle or at least "
            f"{NEAREST_ANGLES:g} deg between them ({PRACTICE})"
        )


# Share of the pin's length that a counterweight may reach over the pin beside a rod.
BESIDE_ROD = 0.05


def _counterweights(scale: EngineScale) -> Iterator[str]:
    """Tell of counterweights and webs that reach the piston at the bottom, or the rod."""
    file = scale.file
    skirt = file.piston.skirt_length or 0.0
    for name, throw in file.named_throws.items():
        section = name if name == "throw" else f"throws.{name}"
        room = file.rod.length - throw.crank_radius - skirt
        for side, web in (("left_web", throw.left_web), ("right_web", throw.right_web)):
            weight = (web and web.counterweight) or throw.counterweight
            thickness = (web and web.thickness) or throw.web_thickness
            reach = max(weight.outer_radius if weight else 0.0, 0.5 * throw.web_width)
            if reach >= room:
                yield (
                    f"{section}: counterweight or web reaches {format_quantity(reach, 'm', 4)} from the "
                    f"shaft axis on the {side}, where {'the skirt' if skirt else 'the piston pin'} comes "
                    f"down to {format_quantity(room, 'm', 4)}: they meet"
                )
            over = weight and weight.offset + 0.5 * ((weight.thickness or thickness) - thickness)
            if over and over > BESIDE_ROD * throw.pin_length:
                yield (
                    f"{section}.counterweight: reaches {format_quantity(over, 'm', 4)} over the pin on the "
                    f"{side}, where the rod's big end is; usual is at most {BESIDE_ROD:g} of pin_length, "
                    f"{format_quantity(BESIDE_ROD * throw.pin_length, 'm', 4)} ({PRACTICE})"
                )


LEVELS = Practice(0.5, 1.5, "is {} that of the throw", margin=3.0)


def study_warnings(study: StudyPlan) -> Iterator[str]:
    """Name levels of a study that are far from the throw that it varies."""
    for factor in study.factors:
        usual = getattr(study.throw, factor.name, None)
        if factor.labels or not isinstance(usual, float) or usual <= 0.0:
            continue
        for level in factor.levels or (factor.lowest, factor.highest):
            yield from LEVELS.warning_of(
                f"study.factors.{factor.name}", level, factor.unit, level / usual
            )
