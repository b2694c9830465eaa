"""Read engine files, and check their sections against each other."""

import math
import os
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crankbase.choices import check_kind
from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankbase.model import InputModel
from crankbase.outputs import write_errors, write_text
from crankbase.quantity import format_quantity
from crankbase.summaries import summarized
from crankfem.files.chain.chain_file import PLANT, plant_chain, read_shaft_lines
from crankfem.files.engine.changed_content import (
    changed_content,
    lost_changes,
    with_files_seen_from,
)
from crankfem.files.engine.file_kinds import SECTIONS, check_sections, engine_sections, file_kind
from crankfem.files.engine.mechanism_cylinders import (
    MechanismSections,
    angles_of_throws,
    check_sizes,
    pins_of,
    throws_of,
)
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.section_changes import (
    Change,
    changed_section,
    changed_throws,
    changes,
    section_kinds,
    without_changed,
)
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
from fem.material import STEEL, Material
from geometry.crankshaft import Crankshaft, ShaftEnds
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import AXIAL_FORMULA_NAMES
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from regression.plans.plan import StudyPlan


def check_misfire(misfire: Misfire | None, gas: Gas | None, engine: Engine) -> None:
    """Refuse cylinders that do not exist, and failing ones without a pressure."""
    if misfire is None:
        return
    wrong = [number for number in misfire.cylinders or () if not 1 <= number <= engine.cylinders]
    if wrong:
        raise InputError(
            f"misfire.cylinders: given {wrong[0]}; allowed is 1 to {engine.cylinders}, because the engine "
            "has these cylinders."
        )
    if gas is None and misfire.compression:
        raise InputError(
            "misfire: given without the section [gas]; allowed are both, or compression = false, because "
            "the pressure without combustion follows from it."
        )


def check_gas_map(gas_map: GasMap | None, engine: Engine) -> None:
    """Refuse a pressure map that does not cover the running range."""
    if gas_map is None:
        return
    _check_covers("gas_map.points", [point.speed for point in gas_map.points], engine)


def check_load(
    load: LoadSection | None, gas: Gas | None, gas_map: GasMap | None, engine: Engine
) -> None:
    """Refuse a load without a known pressure, and one that does not cover the running range."""
    if load is None:
        return
    if gas_map is not None:
        raise InputError(
            "load: given together with the section [gas_map]; allowed is one of the two, because the map "
            "defines the load by its own law."
        )
    if gas is None:
        raise InputError(
            "load: given without the section [gas]; allowed are both, because the load is a share of what "
            "[gas] gives at rated speed."
        )
    if gas.pressure_table is not None and load.law != "constant":
        raise InputError(
            "load: given together with gas.pressure_table; allowed are peak_pressure or "
            "mean_effective_pressure in [gas], or a section [gas_map] with diagrams of several loads, "
            "because one diagram does not define those at other loads."
        )
    if load.points:
        _check_covers("load.points", [point.speed for point in load.points], engine)


def _check_covers(field: str, speeds: Sequence[float], engine: Engine) -> None:
    if min(speeds) > engine.lowest_speed or max(speeds) < engine.highest_speed:
        listed, allowed = (
            f"{format_quantity(low, 'rad/s', 5)} to {format_quantity(high, 'rad/s', 5)}"
            for low, high in (
                (min(speeds), max(speeds)),
                (engine.lowest_speed, engine.highest_speed),
            )
        )
        raise InputError(
            f"{field}: given speeds from {listed}; allowed are ones that cover the running range of "
            f"{allowed}, because nothing is extrapolated beyond them."
        )


def check_sources(vibration: VibrationSettings, study: "StudyPlan | None") -> None:
    """Refuse an unknown source of compliances before anything is computed."""
    for kind, source, formulas in (
        ("axial", vibration.axial_source, AXIAL_FORMULA_NAMES),
        ("torsional", vibration.torsional_source, TORSIONAL_FORMULA_NAMES),
    ):
        fitted = study is not None or vibration.model is not None
        allowed = ["fe", "fe pinned", "law", *(["regression"] if fitted else []), *formulas]
        if source.casefold() not in [name.casefold() for name in allowed]:
            reason = (
                ", because the file has neither a section [study] to fit nor a vibration.model"
                if source.casefold() == "regression"
                else ""
            )
            raise InputError(
                f"vibration.{kind}_source: given {source!r}; allowed are {', '.join(allowed)}{reason}."
            )


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


def check_driven(file: "EngineFile | MechanismSections") -> None:
    """Refuse what an engine alone has, for a machine that is driven, and the other way round."""
    driven_by, gas = file.engine.driven_by, file.gas
    if not driven_by:
        if gas is not None and gas.compressor is not None:
            raise InputError(
                "gas.discharge_pressure: given without engine.driven_by; allowed are both, because something "
                "drives a compressor."
            )
        if isinstance(file, EngineFile) and file.driver is not None:
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
    refused = {
        "load": None
        if file.load is None or file.load.law == "constant"
        else "its pressures are those of [gas]",
    }
    if isinstance(file, EngineFile):
        for name, why in (
            ("driven", "what is behind its coupling drives it: [driver]"),
            ("misfire", "nothing fires"),
            ("propeller_forces", "it drives none"),
            ("strength", "UR M53 is a rule for engines"),
        ):
            refused[name] = None if getattr(file, name) is None else why
    for name, reason in refused.items():
        if reason is not None:
            raise InputError(
                f"{name}: given together with engine.driven_by; allowed is none, because {reason}."
            )


def check_variations(file: "EngineFile") -> None:
    """Refuse what varies over the amplitude: natural vibration and the verdict know none."""
    varying = [
        part.name
        for part in fields(EngineFile)
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


def check_highest_order(vibration: VibrationSettings, engine: Engine) -> None:
    """Refuse a highest order that the engine's cycle does not have."""
    lowest = 2.0 / engine.strokes
    if vibration.highest_order < lowest or vibration.highest_order % lowest:
        raise InputError(
            f"vibration.highest_order: given {vibration.highest_order:g}; allowed are multiples of "
            f"{lowest:g}, because these are the orders of a {engine.strokes}-stroke engine."
        )


def check_thrust_bearing(thrust: ThrustBearing, throws: int) -> None:
    """Refuse a thrust bearing at a main bearing that does not exist."""
    if thrust.main_bearing > throws + 1:
        raise InputError(
            f"thrust_bearing.main_bearing: given {thrust.main_bearing}; allowed is 1 (at the free end) to "
            f"{throws + 1} (at the flywheel), because {throws} throws have {throws + 1} main bearings."
        )


def check_strength(
    strength: StrengthSection | None, throws: Sequence[CrankThrow], gas: Gas | GasMap | None
) -> None:
    """Refuse strength without forces, or for throws that the rule does not cover."""
    if strength is None:
        return
    if gas is None:
        raise InputError(
            "strength: given without gas pressure; allowed are both, because stresses need what loads the "
            "throws: a section [gas] or [gas_map]."
        )
    for number, throw in enumerate(throws, start=1):
        if throw.further_pins:
            raise InputError(
                f"strength: given for throw {number} with several pins; allowed are throws with one pin "
                "between main bearings, because UR M53 holds for these."
            )
        if strength.pin_recess >= throw.web_thickness:
            raise InputError(
                f"strength.pin_recess: given {format_quantity(strength.pin_recess, 'm')}; allowed is less "
                f"than the web_thickness of throw {number}, {format_quantity(throw.web_thickness, 'm')}, "
                "because the recess is cut into the web."
            )
        fit = strength.shrink_fit
        if fit is not None and fit.shrink_diameter <= throw.main_journal_bore:
            raise InputError(
                f"strength.shrink_fit.shrink_diameter: given {format_quantity(fit.shrink_diameter, 'm')}; "
                f"allowed is more than the main_journal_bore of throw {number}, "
                f"{format_quantity(throw.main_journal_bore, 'm')}, because the journal has a wall."
            )


# What is taken for a section that is not there.
DEFAULTS = {"material": STEEL, "shaft_ends": ShaftEnds(), "vibration": VibrationSettings()}


@summarized("engine.name", "path", "engine.rated_speed [rad/s]", "pins")
@dataclass(frozen=True)
class EngineFile:
    """An engine file, read and checked.

    Attributes
    ----------
    files : InputFiles
        The file, and those that it may name.
    engine, throw, shaft_ends, material, rod, piston, flywheel, thrust_bearing, vibration
        Its sections; of several throws by name, the one at the free end.
    shaft_lines : dict
        Kind, "torsional" or "axial", to the chain of the shaft line behind the flywheel, if given.
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
    throw: CrankThrow
    material: Material
    rod: Rod
    piston: Piston
    hinged_rods: HingedRods | None
    shaft: ShaftLayout | None
    thrust_bearing: ThrustBearing
    gas: Gas | None
    load: LoadSection | None
    gas_map: GasMap | None
    misfire: Misfire | None
    torque_table: InputFile | None
    vibration: VibrationSettings
    shaft_ends: ShaftEnds
    flywheel: Flywheel
    free_end: FreeEnd | None
    damping: Damping | None
    torsional_damper: TorsionalDamperSection | None
    axial_damper: AxialDamperSection | None
    driven: Driven | None
    driver: Driver | None
    bearings: Bearings | None
    shaft_lines: dict[str, Chain]
    propeller_forces: PropellerForcesSection | None
    limits: LimitsInput | None
    ranges: RangesInput | None
    strength: StrengthSection | None
    two_mass: TwoMassInput | None
    study: "StudyPlan | None"
    records: tuple[InputRecord, ...]
    provenance: dict[str, tuple[str, bool]]
    sources: dict[str, str]
    throws_by_name: dict[str, CrankThrow] = field(default_factory=dict)
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
        check_strength(self.strength, self.crank_throws, self.gas or self.gas_map)

    @property
    def throws(self) -> tuple[int, ...]:
        """Throw that each cylinder works on, from 0."""
        return throws_of(self.engine)

    @property
    def throw_angles_deg(self) -> tuple[float, ...]:
        """Angle of each throw's first pin, throw by throw, as the file counts angles [deg]."""
        return tuple(map(math.degrees, angles_of_throws(self.shaft, self.engine, self.throws)))

    @property
    def named_throws(self) -> dict[str, CrankThrow]:
        """The distinct throws by name; that of a plain file has the name "throw"."""
        return dict(self.throws_by_name) or {PLAIN: self.throw}

    @property
    def throw_names(self) -> tuple[str, ...]:
        """Name of each crank's throw, from the free end."""
        return throw_names(self.named_throws, self.shaft, len(self.throw_angles_deg))

    @property
    def crank_throws(self) -> tuple[CrankThrow, ...]:
        """Throw of each crank, from the free end."""
        throws = self.named_throws
        return tuple(throws[name] for name in self.throw_names)

    @property
    def path(self) -> Path:
        """What messages call the file, and where it is unless it was sent."""
        return self.files.path

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

    @property
    def pins(self) -> tuple[int, ...]:
        """Pin that each cylinder works on, from 0, counted along the shaft."""
        return pins_of(self.engine, self.throw, self.throws, self.hinged_rods)

    @property
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

    @property
    def crankshaft(self) -> Crankshaft:
        """The whole crankshaft: the throws at their angles, and the ends."""
        return Crankshaft(
            self.crank_throws, crank_angles_deg=self.throw_angles_deg, ends=self.shaft_ends
        )

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
            return load_engine(sections_of(self.files, tomllib.loads(text), text))

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

    def _study_of(
        self, throws: Mapping[str, CrankThrow], made: Mapping[str, Any]
    ) -> "StudyPlan | None":
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
            study = replace(study, throw=throws[name], material=material)
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
    models = {name: section.model for name, section in SECTIONS.items() if name != "throws"}
    with content.all_errors(models, {"throws": read_throws}):
        return _read_engine(content)


def _read_engine(content: TomlFile) -> EngineFile:
    check_sections(content)
    throws: dict[str, CrankThrow] = {}
    sections: dict[str, Any] = {}
    kinds = section_kinds(EngineFile)
    for part in fields(EngineFile):  # in this order the report shows them
        if part.name == "throw":
            throws = read_throws(content)
        elif part.name == "torque_table":
            sections[part.name] = torque_table_file(content)
        elif part.name == "shaft_lines":
            sections[part.name] = read_shaft_lines(content)
        elif part.name in kinds:
            model, _ = kinds[part.name]
            sections[part.name] = content.model(model.section, model) or DEFAULTS.get(part.name)
    first, study = free_end_throw_name(throws, sections["shaft"]), None
    if "study" in content.sections:
        from crankfem.files.study_file import study_plan  # here: few files have a study

        study = study_plan(content, throws, first, sections["material"])
    return EngineFile(
        **sections,
        files=content.files,
        throw=throws[first],
        study=study,
        records=tuple(content.records),
        provenance=content.provenance,
        sources=content.sources,
        throws_by_name={} if PLAIN in throws else throws,
        text=content.text,
    )
