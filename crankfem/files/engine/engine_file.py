"""Read engine files, and check their sections against each other."""

import math
import os
import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from crankbase.choices import check_kind
from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.model import InputModel
from crankbase.outputs import write_errors, write_text
from crankbase.summaries import summarized
from crankfem.files.chain.chain_file import PLANT, plant_chain, read_shaft_lines
from crankfem.files.engine.changed_content import (
    Change,
    changed_content,
    changed_section,
    changed_throws,
    changes,
    lost_changes,
    section_kinds,
    with_files_seen_from,
    without_changed,
)
from crankfem.files.engine.file_kinds import SECTIONS, check_sections, engine_sections, file_kind
from crankfem.files.engine.full_load import full_load_pressure
from crankfem.files.engine.mechanism_cylinders import (
    angles_of_throws,
    check_sizes,
    engine_cylinders,
    engine_layout,
    firing_evenness,
    inertia_remarks,
    pins_of,
    side_by_side,
    throws_of,
)
from crankfem.files.engine.section_checks import (
    check_gas_map,
    check_highest_order,
    check_load,
    check_misfire,
    check_sources,
    check_strength,
    check_thrust_bearing,
)
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_file import InputRecord, TomlFile, sections_of
from crankfem.files.reading.toml_text import toml_text
from crankfem.files.sections.crank_throws import (
    PLAIN,
    ShaftLayout,
    free_end_throw_name,
    read_throws,
    throw_names,
    throws_along_shaft,
)
from crankfem.files.sections.engine_sections import (
    Engine,
    Flywheel,
    FreeEnd,
    ThrustBearing,
    TwoMassInput,
    VibrationSettings,
    torque_table_file,
)
from crankfem.files.sections.excitation_sections import GasMap, Misfire, PropellerForcesSection
from crankfem.files.sections.limits_sections import LimitsInput, RangesInput
from crankfem.files.sections.mechanism_sections import Gas, HingedRods, LoadSection, Piston, Rod
from crankfem.files.sections.strength_section import StrengthSection
from crankfem.files.sections.vibration_sections import (
    ASSUMED_PER_DIAMETER,
    ASSUMED_RANGE,
    AxialDamperSection,
    Bearings,
    Damping,
    TorsionalDamperSection,
)
from dynamics.chains.chain import Chain
from dynamics.chains.shaft_line import Driven, Driver
from dynamics.chains.varying import over_amplitude
from dynamics.crankshaft.line_beam import LineBeam
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.pressure_map import EnginePower, indicated_power
from dynamics.gas.pressure import GasPressure
from fem.material import STEEL, Material
from geometry.any_throw import NO_DIMENSIONS, Throw, dimensioned, with_dimensions
from geometry.crankshaft import Crankshaft, ShaftEnds, throw_starts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from regression.plans.plan import StudyPlan

THROWS = ("throw", "throws")
Section = TypeVar("Section", bound=InputModel)
Calculated = TypeVar("Calculated")


def check_plant(engine: "EngineFile") -> None:
    """Refuse a plant's chain that lacks cranks, and sections that it would make ineffective."""
    plant = engine.shaft_lines.get(PLANT)
    if plant is None:
        return
    plant_chain(plant, [count for _, count in sorted(Counter(engine.throws).items())])
    damping = engine.damping
    twice = {
        "torsional_damper": engine.torsional_damper is not None,
        "driven": engine.driven is not None,
        "driver": engine.driver is not None,
        "damping.cylinder_damping": damping is not None and damping.cylinder_damping is not None,
        "damping.loss_factor": damping is not None and damping.loss_factor is not None,
        "vibration.torsional_source": engine.vibration.torsional_source != "fe",
    }
    for name in (name for name, there in twice.items() if there):
        raise InputError(
            f"{name}: given together with shaft_line.plant; allowed is one of the two, because the chain of "
            "the plant defines the whole torsional chain."
        )


def check_driven(file: "EngineFile") -> None:
    """Refuse what an engine alone has, for a machine that is driven, and the other way round."""
    driven_by, gas = file.engine.driven_by, file.gas
    if not driven_by:
        if gas is not None and gas.compressor is not None:
            raise InputError(
                "gas.discharge_pressure: given without engine.driven_by; allowed are both, because something "
                "drives a compressor."
            )
        if file.driver is not None:
            raise InputError(
                "driver: given without engine.driven_by; allowed are both, or the section [driven], because "
                "an engine drives what is behind its coupling."
            )
        return
    if gas is not None and gas.compressor is None and gas.pressure_table is None:
        raise InputError(
            "gas.discharge_pressure: missing for a driven machine; allowed are suction_pressure, "
            "discharge_pressure, clearance and exponent, or pressure_table, because nothing burns in it."
        )
    varies = file.load is not None and file.load.law != "constant"
    for name, value, reason in (
        ("load", varies, "its pressures are those of [gas]"),
        ("driven", file.driven, "what is behind its coupling drives it: [driver]"),
        ("misfire", file.misfire, "nothing fires"),
        ("propeller_forces", file.propeller_forces, "it drives none"),
        ("strength", file.strength, "UR M53 is a rule for engines"),
    ):
        if value:
            raise InputError(
                f"{name}: given together with engine.driven_by; allowed is none, because {reason}."
            )


def check_variations(file: "EngineFile") -> None:
    """Refuse what varies over the amplitude: natural vibration and the verdict know none."""
    varying = [
        part.name
        for part in fields(file)
        if (variation := getattr(getattr(file, part.name), "variation", None))
        and variation.amplitude
    ]
    varying += [
        name
        for name, line in file.shaft_lines.items()
        if any(over_amplitude(spring.law) for spring in line.varying)
    ]
    if varying:
        raise InputError(
            f"{varying[0]}.variation.amplitude: given for a part of an engine; allowed are frequency, "
            "torque, speed and temperature, because natural frequencies and the verdict know no amplitude."
        )


def check_cad(file: "EngineFile") -> None:
    """Refuse what needs the dimensions of throws, for throws from CAD files."""
    if len(dimensioned(file.named_throws)) == len(file.named_throws):
        return
    sources = {
        f"vibration.{kind}_source": getattr(file.vibration, f"{kind}_source")
        for kind in ("axial", "torsional")
    }
    wrong = {name: source for name, source in sources.items() if source not in ("fe", "fe pinned")}
    if file.strength is not None:
        wrong["strength"] = "the rule UR M53"
    for name, source in wrong.items():
        raise InputError(
            f"{name}: given {source} for throws from STEP files; allowed are finite elements, because "
            f"formulas take dimensions, and {NO_DIMENSIONS}."
        )


# What is taken for a section that is not there.
DEFAULTS = {"material": STEEL, "shaft_ends": ShaftEnds(), "vibration": VibrationSettings()}


@summarized("engine.name", "path", "engine.rated_speed [rad/s]", "pins")
@dataclass(frozen=True)
class EngineFile:
    """An engine file, read and checked: a whole engine, or its crank mechanism alone.

    What follows from the sections is calculated once, when first used.

    Attributes
    ----------
    files : InputFiles
        The file, and those that it may name.
    engine, throw, shaft_ends, material, rod, piston, vibration
        Its sections; of several throws by name, the one at the free end.
    flywheel, thrust_bearing
        Sections that every whole engine has; without a thrust bearing it is a mechanism alone.
    shaft_lines : dict
        Kind, "torsional" or "axial", to the chain of the shaft line behind the flywheel, if given.
    line_beam : LineBeam or None
        How that line bends, if it begins with pieces of shaft.
    shaft, hinged_rods, free_end, damping, torsional_damper, axial_damper, driven, driver, bearings, \
gas, load, gas_map, misfire, propeller_forces, limits, ranges, strength, torque_table, two_mass, study
        Optional sections; None where the file lacks them.
    records : tuple of InputRecord
        Every value with its source.
    provenance : dict
        Field to its source and whether it is assumed, if the file states it.
    sources : dict
        Short name to full citation.
    throws_by_name : dict
        The throws of sections [throws.NAME]; empty for a file with one [throw].
    text : str
        Of the file, without changes.

    Raises
    ------
    InputError
        If sections contradict each other, also when made by `dataclasses.replace` or `changed`.
    """

    files: InputFiles
    engine: Engine
    throw: Throw
    material: Material
    rod: Rod
    piston: Piston
    hinged_rods: HingedRods | None
    shaft: ShaftLayout | None
    thrust_bearing: ThrustBearing | None
    gas: Gas | None
    load: LoadSection | None
    gas_map: GasMap | None
    misfire: Misfire | None
    torque_table: InputFile | None
    vibration: VibrationSettings
    shaft_ends: ShaftEnds
    flywheel: Flywheel | None
    free_end: FreeEnd | None
    damping: Damping | None
    torsional_damper: TorsionalDamperSection | None
    axial_damper: AxialDamperSection | None
    driven: Driven | None
    driver: Driver | None
    bearings: Bearings | None
    shaft_lines: dict[str, Chain]
    line_beam: LineBeam | None
    propeller_forces: PropellerForcesSection | None
    limits: LimitsInput | None
    ranges: RangesInput | None
    strength: StrengthSection | None
    two_mass: TwoMassInput | None
    study: "StudyPlan | None"
    records: tuple[InputRecord, ...]
    provenance: dict[str, tuple[str, bool]]
    sources: dict[str, str]
    throws_by_name: dict[str, Throw] = field(default_factory=dict)
    text: str = field(default="", repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, throw in self.named_throws.items():
            section = name if name == PLAIN else f"throws.{name}"
            check_sizes(self.engine, throw, self.rod, self.piston, section)
        along = throws_along_shaft(self.named_throws, self.throw_names, self.throw_angles_deg)
        if self.throw != along[0]:
            raise InputError(
                "throw: given for an engine with throws by name; allowed is throws={NAME: ...}, because "
                "each name is a throw of its own."
            )
        if self.thrust_bearing is not None:
            check_thrust_bearing(self.thrust_bearing, len(self.throw_angles_deg))
        _ = self.pins  # refuses hinged rods of cylinders that are not there
        check_misfire(self.misfire, self.gas, self.engine)
        check_gas_map(self.gas_map, self.engine)
        check_load(self.load, self.gas, self.gas_map, self.engine)
        check_sources(self.vibration, self.study)
        check_driven(self)
        check_plant(self)
        check_variations(self)
        check_highest_order(self.vibration, self.engine)
        check_cad(self)
        check_strength(
            self.strength, tuple(dimensioned(self.named_throws).values()), self.gas or self.gas_map
        )

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what follows from the sections where an engine is copied or sent."""
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @property
    def path(self) -> Path:
        """What messages call the file, and where it is unless it was sent."""
        return self.files.path

    @property
    def whole(self) -> bool:
        """Whether this is a whole engine, with flywheel and thrust bearing."""
        return self.flywheel is not None and self.thrust_bearing is not None

    def __hash__(self) -> int:
        # Dictionaries among the fields have none.
        return hash((self.path, self.engine, self.throw))

    def required(self, section: type[Section]) -> Section:
        """Return a section that a whole engine has.

        Raises
        ------
        InputError
            If this is a mechanism alone.
        """
        part = getattr(self, section.section)
        if not isinstance(part, section):
            raise InputError(
                f"{self.path.name}: given without the section [{section.section}]; allowed is a whole "
                "engine, as load_engine reads it, because not only its mechanism is calculated."
            )
        return part

    def once(self, calculate: Callable[["EngineFile"], Calculated]) -> Calculated:
        """Return what a function calculates from the file; it is calculated once."""
        if calculate not in self._calculated:
            self._calculated[calculate] = calculate(self)
        known: Calculated = self._calculated[calculate]
        return known

    @cached_property
    def _calculated(self) -> dict[Callable[["EngineFile"], Any], Any]:
        return {}

    @cached_property
    def throws(self) -> tuple[int, ...]:
        """Throw that each cylinder works on, from 0."""
        return throws_of(self.engine)

    @cached_property
    def throw_angles_deg(self) -> tuple[float, ...]:
        """Angle of each throw's first pin, throw by throw, as the file counts angles [deg]."""
        return tuple(map(math.degrees, angles_of_throws(self.shaft, self.engine, self.throws)))

    @property
    def rotation_angles_deg(self) -> tuple[float, ...]:
        """Angle of each throw's first pin, throw by throw, in the sense of rotation [deg]."""
        return tuple(self.engine.turning_sense * angle for angle in self.throw_angles_deg)

    @cached_property
    def named_throws(self) -> Mapping[str, Throw]:
        """The distinct throws by name; that of a plain file has the name "throw"."""
        return MappingProxyType(dict(self.throws_by_name) or {PLAIN: self.throw})

    @cached_property
    def throw_names(self) -> tuple[str, ...]:
        """Name of each crank's throw, from the free end."""
        return throw_names(self.named_throws, self.shaft, len(self.throw_angles_deg))

    @cached_property
    def crank_throws(self) -> tuple[Throw, ...]:
        """Throw of each crank, from the free end."""
        return tuple(self.named_throws[name] for name in self.throw_names)

    @cached_property
    def crankshaft(self) -> Crankshaft:
        """The whole crankshaft: the throws at their angles, and the ends."""
        return Crankshaft(
            self.crank_throws, crank_angles_deg=self.throw_angles_deg, ends=self.shaft_ends
        )

    @cached_property
    def bearing_positions(self) -> tuple[float, ...]:
        """Middle of each main bearing along the shaft, one more than throws [m]."""
        return throw_starts(self.crank_throws)

    @cached_property
    def pins(self) -> tuple[int, ...]:
        """Pin that each cylinder works on, from 0, counted along the shaft."""
        return pins_of(self.engine, self.throw, self.throws, self.hinged_rods)

    @cached_property
    def layout(self) -> EngineLayout:
        """Cylinders and rods alone, which `with_throws` completes by the throws' unbalance and inertia.

        Angles are in the sense of rotation: where the shaft turns against the sense in which the file
        counts angles, this is the mirror image, x against the file's.

        Raises
        ------
        InputError
            If cranks, throws and pins contradict each other.
        """
        return engine_layout(
            self.engine,
            engine_cylinders(
                self.engine,
                self.crank_throws,
                self.rod,
                self.piston,
                self.hinged_rods,
                self.throws,
                [math.radians(angle) for angle in self.throw_angles_deg],
            ),
        )

    @cached_property
    def pressure(self) -> tuple[GasPressure, ...]:
        """Gas pressure at full load, cylinder by cylinder; empty without a section [gas].

        Raises
        ------
        InputError
            If the pressure cannot be reached or read.
        """
        if self.gas is None:
            return ()
        return full_load_pressure(self.engine, self.gas, self.layout, self.files)

    @cached_property
    def power(self) -> EnginePower | None:
        """Indicated power at full load and rated speed, and the rated power; None without a section [gas]."""
        if not self.pressure:
            return None
        engine, speed = self.engine, self.engine.rated_speed
        indicated = indicated_power(self.layout, self.pressure, speed)
        return EnginePower(
            speed, *indicated, engine.rated_power, driven=bool(engine.driven_by) or None
        )

    @property
    def attached_inertia(self) -> float:
        """Inertia of flywheel and free end, if given [kg m^2]."""
        return sum(part.inertia for part in (self.flywheel, self.free_end) if part is not None)

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """What is assumed of the mechanism beyond its sections."""
        remarks = inertia_remarks(self.rod, self.hinged_rods)
        remarks += [note.sentence for note in firing_evenness(self.engine).notes]
        if side_by_side(self.throw, self.throws, self.hinged_rods):
            remarks.insert(
                0,
                "rods side by side share the pin's length equally, the cylinder with the lower number "
                "nearer to the free end",
            )
        return tuple(remarks)

    @property
    def model_file(self) -> InputFile | None:
        """The saved compliance model that the file names, if any.

        Raises
        ------
        InputError
            If there is no such file.
        """
        name = self.vibration.model
        return None if name is None else self.files.named("vibration.model", name)

    @cached_property
    def main_bearings(self) -> Bearings:
        """The main bearings; assumed ones, with the range of the assumption, where the file gives none."""
        assumed, ratio = ASSUMED_PER_DIAMETER * self.throw.main_journal_diameter, ASSUMED_RANGE
        return self.bearings or Bearings(
            stiffness=assumed, lowest_stiffness=assumed / ratio, highest_stiffness=assumed * ratio
        )

    @property
    def behind_coupling(self) -> Driven | None:
        """What is behind the coupling at the flywheel: a driven machine, or the prime mover of one."""
        return self.driven or self.driver

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the crankshaft from the side; see `Crankshaft.plot`."""
        return self.crankshaft.plot(axes)

    def changed(self, **sections: InputModel | Mapping[str, Any] | None) -> "EngineFile":
        """Return the engine with some sections changed, checked like a file; the file itself is unchanged.

        Parameters
        ----------
        **sections
            By the section's name: the fields that change with their new values in SI units, such as
            ``throw={"web_thickness": 0.046}``; or the whole section, such as ``throw=another``; or None,
            which removes an optional one. A section that the file lacks is made from its fields.
            Named throws are changed by their names, such as ``throws={"b": {"web_thickness": 0.05}}``.

        Returns
        -------
        EngineFile
            With `files` of the same file, among which tables are searched. Changed values have the
            source "changed in Python"; a study is one of the changed throw and material.

        Raises
        ------
        InputError
            If a section or field is unknown, or the values contradict each other.

        Examples
        --------
        >>> engine = load_engine("6chn25-34")
        >>> engine.changed(rod={"length": 0.7}, flywheel={"inertia": 250.0}).rod.length
        0.7
        """
        values = dict(sections)
        throws = changed_throws(self.throws_by_name, values.pop("throws", {}))
        made: dict[str, Any] = {
            name: changed_section(self, name, section) for name, section in values.items()
        }
        changed: list[Change] = [
            change
            for name, section in made.items()
            for change in changes(getattr(self, name), section)
        ]
        for name in dict.fromkeys((*self.throws_by_name, *throws)):
            before, after = self.throws_by_name.get(name), throws.get(name)
            changed += changes(before, after, f"throws.{name}")
        records, provenance = without_changed(self.records, self.provenance, changed)
        study = self._study_of(throws or {PLAIN: made.get("throw", self.throw)}, made)
        if throws and "throw" not in made:
            made["throw"] = throws[free_end_throw_name(throws, made.get("shaft", self.shaft))]
        return replace(
            self, **made, study=study, records=records, provenance=provenance, throws_by_name=throws
        )

    def save(self, path: str | Path) -> Path:
        """Write the engine, with its changes, as a file that is read as the same engine.

        Values that are unchanged stand as in the file that it was read from, with their sources and marked as
        assumed or not, and the names of other files as seen from the new folder; its comments do not.

        Parameters
        ----------
        path : path
            A file ending in ``.toml``.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If the ending is another, the file cannot be written or is not one that this method wrote, or a
            change is not one of a section's fields, which are all that a file holds.

        Examples
        --------
        >>> import tempfile
        >>> engine = load_engine("6chn25-34").changed(rod={"length": 0.7})
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     load_engine(engine.save(Path(folder) / "long-rod.toml")).rod.length
        0.7
        """
        check_kind("path", path, str | os.PathLike, "the name of a file ending in '.toml'")
        path = Path(path)
        if path.suffix != ".toml":
            raise InputError(
                f"{path.name}: given the ending {path.suffix!r}; allowed is '.toml', as engine files have it."
            )

        def read(text: str) -> EngineFile:
            content = sections_of(self.files, tomllib.loads(text), text)
            whole = self.whole and file_kind(content) == "engine"
            return load_engine(content) if whole else load_mechanism(content)

        content = changed_content(tomllib.loads(self.text), read(self.text), self)
        for name in lost_changes(read(toml_text(content)), self):
            raise InputError(
                f"{name}: given a change that a file cannot hold; allowed are changes of fields of sections, "
                "by changed(), because a file names a table, a chain or the plan of a study."
            )
        head = f"# Written by crankfem from {self.path.name}: its values, changes and sources.\n\n"
        moved = with_files_seen_from(path.parent, content, self.path.parent)
        with write_errors(path):
            return write_text(path, head + toml_text(moved), "input file")

    def _study_of(self, throws: Mapping[str, Throw], made: Mapping[str, Any]) -> "StudyPlan | None":
        """The study with the changed throw and material; None without its throw."""
        study = self.study
        if study is None:
            return None
        name = next(
            (name for name, throw in self.named_throws.items() if throw == study.throw), None
        )
        if name is None or name not in throws:
            return None
        material = made.get("material", self.material)
        if (throws[name], material) != (study.throw, study.material):
            study = replace(study, throw=with_dimensions(throws[name]), material=material)
        return study


def load_engine(path: str | Path | TomlFile) -> EngineFile:
    """Read and check an engine file.

    Parameters
    ----------
    path : path
        The file, or the name of a shipped engine; or its sections, if already read.

    Raises
    ------
    InputError
        With a sentence for each wrong field, which names it, what was given and what is allowed.
    """
    content = engine_sections(path)
    kind = file_kind(content)
    if kind == "throw":
        needed = [
            f"[{name}]"
            for name, section in SECTIONS.items()
            if section.required and name != "throw"
        ]
        raise InputError(
            f"{content.path.name}: describes a throw, not an engine; add the sections {', '.join(needed)}, "
            "or use it with a command for throws: `crankfem check` lists them."
        )
    if kind == "mechanism":
        raise InputError(
            f"{content.path.name}: describes a crank mechanism, not a whole engine; add the sections "
            "[flywheel] and [thrust_bearing], or use it with mechanism, harmonics, throw and draw."
        )
    models = {name: section.model for name, section in SECTIONS.items() if name not in THROWS}
    with content.all_errors(models, dict.fromkeys(THROWS, read_throws)):
        check_sections(content)
        return _read_engine(content, [part.name for part in fields(EngineFile)])


def load_mechanism(path: str | Path | TomlFile) -> EngineFile:
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
    models = {name: SECTIONS[name].model for name in MECHANISM_PARTS if name not in THROWS}
    with content.all_errors(models, dict.fromkeys(THROWS, read_throws)):
        check_sections(content, ("engine", "throw", "rod", "piston"))
        mechanism = _read_engine(content, MECHANISM_PARTS)
        _ = mechanism.layout, mechanism.pressure  # which refuse what cannot be
        return mechanism


# The sections of a mechanism, in the order in which its values are listed.
MECHANISM_PARTS = (
    *("engine", "throw", "rod", "piston", "shaft", "hinged_rods", "shaft_ends", "gas", "load"),
    *("flywheel", "free_end", "material"),
)


def _read_engine(content: TomlFile, parts: Sequence[str]) -> EngineFile:
    """Read some sections of a file, in this order, which their records keep; others are missing."""
    throws: dict[str, Throw] = {}
    kinds = section_kinds(EngineFile)
    sections: dict[str, Any] = {name: DEFAULTS.get(name) for name in kinds}
    sections |= {"torque_table": None, "shaft_lines": {}, "line_beam": None}
    for name in parts:
        if name == "throw":
            throws = read_throws(content)
        elif name == "torque_table":
            sections[name] = torque_table_file(content)
        elif name == "shaft_lines":
            sections[name], sections["line_beam"] = read_shaft_lines(content)
        elif name in kinds:
            model, _ = kinds[name]
            sections[name] = content.model(model.section, model) or DEFAULTS.get(name)
    first, study = free_end_throw_name(throws, sections["shaft"]), None
    if "study" in parts and "study" in content.sections:
        from crankfem.files.study_file import study_plan  # here: few files have a study

        study = study_plan(content, throws, first, sections["material"])
    return EngineFile(
        **sections
        | {
            "files": content.files,
            "throw": throws[first],
            "study": study,
            "records": tuple(content.records),
            "provenance": content.provenance,
            "sources": content.sources,
            "throws_by_name": {} if PLAIN in throws else throws,
            "text": content.text,
        }
    )
