"""Read engine files, and check what their sections say of each other."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from crankbase.errors import InputError
from crankbase.model import InputModel
from crankbase.summaries import summarized
from crankbase.units.quantity import format_quantity
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.engine.mechanism_cylinders import (
    angles_of_throws,
    check_sizes,
    pins_of,
    throws_of,
)
from crankfem.files.engine.throw_file import ThrowFile
from crankfem.files.reading.data_files import find_table
from crankfem.files.reading.file_kinds import (
    REQUIRED,
    check_sections,
    describes_a_throw,
    describes_mechanism,
    engine_sections,
)
from crankfem.files.reading.section_changes import (
    Change,
    changed_section,
    changed_throws,
    changes,
    without_changed,
)
from crankfem.files.reading.toml_file import InputRecord, TomlFile
from crankfem.files.sections.crank_throws import (
    PLAIN,
    free_end_throw_name,
    read_throws,
    throw_names,
    throws_along_shaft,
)
from crankfem.files.sections.damper_sections import AxialDamperSection, TorsionalDamperSection
from crankfem.files.sections.engine_sections import (
    Engine,
    Flywheel,
    FreeEnd,
    ShaftLayout,
    ThrustBearing,
    TorqueTable,
    TwoMassInput,
    VibrationSettings,
)
from crankfem.files.sections.excitation_sections import GasMap, Misfire, PropellerForcesSection
from crankfem.files.sections.limits_sections import LimitsInput, RangesInput
from crankfem.files.sections.mechanism_sections import Gas, HingedRods, Piston, Rod
from crankfem.files.sections.vibration_sections import (
    Bearings,
    Damping,
    Driven,
    ShaftLineFiles,
)
from crankfem.files.study.study_file import study_plan
from dynamics.chains.chain import Chain
from fem.material import STEEL, Material
from geometry.shaft_ends import ShaftEnds
from geometry.throw import CrankThrow
from regression.formulas.catalogue import AXIAL_FORMULA_NAMES
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES
from regression.plans.plan import StudyPlan


@summarized("engine.name", "path", "engine.rated_speed [rad/s]", "pins")
@dataclass(frozen=True)
class EngineFile:
    """An engine file, read and checked.

    Attributes
    ----------
    path : Path
    engine, throw, shaft_ends, material, rod, piston, flywheel, thrust_bearing, vibration
        Its sections; of several throws by name, the one at the free end.
    shaft_lines : dict
        Kind, "torsional" or "axial", to the chain of what follows the flywheel, where given.
    shaft, hinged_rods, free_end, damping, torsional_damper, axial_damper, driven, bearings, gas, \
gas_map, misfire, propeller_forces, limits, ranges, torque_table, two_mass, study
        Optional sections; None where the file lacks them.
    records : tuple of InputRecord
        Every value with its source.
    provenance : dict
        Field to its source and whether it is assumed, where the file says so.
    sources : dict
        Short name to full citation.
    throws_by_name : dict
        The throws of sections [throws.NAME]; empty for a file with one [throw].

    Raises
    ------
    InputError
        If sections do not fit each other, when made by `dataclasses.replace` or `changed` as well.
    """

    path: Path
    engine: Engine
    shaft: ShaftLayout | None
    throw: CrankThrow
    shaft_ends: ShaftEnds
    material: Material
    rod: Rod
    piston: Piston
    hinged_rods: HingedRods | None
    flywheel: Flywheel
    thrust_bearing: ThrustBearing
    vibration: VibrationSettings
    free_end: FreeEnd | None
    damping: Damping | None
    torsional_damper: TorsionalDamperSection | None
    axial_damper: AxialDamperSection | None
    driven: Driven | None
    bearings: Bearings | None
    shaft_lines: dict[str, Chain]
    gas: Gas | None
    gas_map: GasMap | None
    misfire: Misfire | None
    propeller_forces: PropellerForcesSection | None
    limits: LimitsInput | None
    ranges: RangesInput | None
    torque_table: Path | None
    two_mass: TwoMassInput | None
    study: StudyPlan | None
    records: tuple[InputRecord, ...]
    provenance: dict[str, tuple[str, bool]]
    sources: dict[str, str]
    throws_by_name: dict[str, CrankThrow] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, throw in self.named_throws.items():
            section = name if name == PLAIN else f"throws.{name}"
            check_sizes(self.engine, throw, self.rod, self.piston, section)
        along = throws_along_shaft(self.named_throws, self.throw_names, self.throw_angles)
        if self.throw != along[0]:
            raise InputError(
                "throw: given for an engine with throws by name; allowed is throws={NAME: ...}, because "
                "each name stands for a throw of its own."
            )
        bearings = len(self.throw_angles)
        if self.thrust_bearing.bearing > bearings:
            raise InputError(
                f"thrust_bearing.bearing: given {self.thrust_bearing.bearing}; allowed is 0 (free end) to "
                f"{bearings} (flywheel)."
            )
        _ = self.pins  # refuses hinged rods of cylinders that are not there
        _check_misfire(self.misfire, self.gas, self.engine)
        _check_gas_map(self.gas_map, self.engine)
        _check_sources(self.vibration, self.study)
        _check_highest_order(self.vibration, self.engine)

    @property
    def throws(self) -> tuple[int, ...]:
        """Throw that each cylinder works on, from 0."""
        return throws_of(self.engine)

    @property
    def throw_angles(self) -> tuple[float, ...]:
        """Angle of each throw's first pin, throw by throw, as the file counts angles [rad]."""
        return angles_of_throws(self.shaft, self.engine, self.throws)

    @property
    def named_throws(self) -> dict[str, CrankThrow]:
        """The distinct throws by name; the one of a plain file has the name "throw"."""
        return dict(self.throws_by_name) or {PLAIN: self.throw}

    @property
    def throw_names(self) -> tuple[str, ...]:
        """Name of each crank's throw, from the free end."""
        return throw_names(self.named_throws, self.shaft, len(self.throw_angles))

    @property
    def crank_throws(self) -> tuple[CrankThrow, ...]:
        """Throw of each crank, from the free end."""
        throws = self.named_throws
        return tuple(throws[name] for name in self.throw_names)

    @property
    def pins(self) -> tuple[int, ...]:
        """Pin that each cylinder works on, from 0, counted along the shaft."""
        return pins_of(self.engine, self.throw, self.throws, self.hinged_rods)

    @property
    def assumed(self) -> tuple[InputRecord, ...]:
        """The values that nobody gave."""
        return tuple(record for record in self.records if record.assumed)

    def changed(self, **sections: InputModel | Mapping[str, Any] | None) -> "EngineFile":
        """Return the engine with some sections changed, checked like a file; the file stays as it is.

        Parameters
        ----------
        **sections
            By the section's name: the fields that change with their new values in SI units, such as
            ``throw={"web_thickness": 0.046}``; or the whole section, such as ``throw=another``; or None,
            which takes an optional one away. A section that the file lacks is made of its fields.
            Throws by name are changed so by their names, such as ``throws={"b": {"web_thickness": 0.05}}``.

        Returns
        -------
        EngineFile
            With `path` of the same file, beside which tables are looked for. Changed values have the
            source "changed in Python"; a study is one of the changed throw and material.

        Raises
        ------
        InputError
            If a section or field is unknown, or the values do not fit each other.

        Examples
        --------
        >>> engine = load_engine("6chn25-34")
        >>> engine.changed(rod={"length": 0.7}, flywheel={"inertia": 250.0}).rod.length
        0.7
        """
        given = dict(sections)
        throws = changed_throws(self.throws_by_name, given.pop("throws", {}))
        made: dict[str, Any] = {
            name: changed_section(self, name, section) for name, section in given.items()
        }
        told: list[Change] = [
            change
            for name, section in made.items()
            for change in changes(getattr(self, name), section)
        ]
        for name in dict.fromkeys((*self.throws_by_name, *throws)):
            before, after = self.throws_by_name.get(name), throws.get(name)
            told += changes(before, after, f"throws.{name}")
        records, provenance = without_changed(self.records, self.provenance, told)
        study = self._study_of(throws or {PLAIN: made.get("throw", self.throw)}, made)
        if throws and "throw" not in made:
            made["throw"] = throws[free_end_throw_name(throws, made.get("shaft", self.shaft))]
        return replace(
            self,
            **made,
            study=study,
            records=records,
            provenance=provenance,
            throws_by_name=throws,
        )

    def _study_of(
        self, throws: Mapping[str, CrankThrow], made: Mapping[str, Any]
    ) -> StudyPlan | None:
        """The study with its throw and material as changed; without its throw there is none."""
        study = self.study
        if study is None:
            return None
        name = next(name for name, own in self.named_throws.items() if own == study.throw)
        if name not in throws:
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
        The file, or the name of a shipped engine; or its sections, where they have been read already.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    content = engine_sections(path)
    if describes_a_throw(content):
        raise InputError(
            f"{content.path.name}: describes a throw, not an engine; add the sections "
            f"{', '.join(f'[{name}]' for name, needed in REQUIRED.items() if needed and name != 'throw')}, "
            "or use it with throw, formulas, draw and export."
        )
    if describes_mechanism(content):
        raise InputError(
            f"{content.path.name}: describes a crank mechanism, not a whole engine; add the sections "
            "[flywheel] and [thrust_bearing], or use it with mechanism, harmonics, throw and draw."
        )
    check_sections(content)
    engine = content.required("engine", Engine)
    throws = read_throws(content)
    material = content.model("material", Material) or STEEL
    rod, piston = content.required("rod", Rod), content.required("piston", Piston)
    hinged = content.model("hinged_rods", HingedRods)
    shaft = content.model("shaft", ShaftLayout)
    first = free_end_throw_name(throws, shaft)
    thrust = content.required("thrust_bearing", ThrustBearing)
    gas, gas_map = content.model("gas", Gas), content.model("gas_map", GasMap)
    misfire = content.model("misfire", Misfire)
    torque = content.model("torque", TorqueTable)
    vibration = content.model("vibration", VibrationSettings) or VibrationSettings()
    return EngineFile(
        path=content.path,
        engine=engine,
        shaft=shaft,
        throw=throws[first],
        shaft_ends=content.model("shaft_ends", ShaftEnds) or ShaftEnds(),
        material=material,
        rod=rod,
        piston=piston,
        hinged_rods=hinged,
        flywheel=content.required("flywheel", Flywheel),
        thrust_bearing=thrust,
        vibration=vibration,
        free_end=content.model("free_end", FreeEnd),
        damping=content.model("damping", Damping),
        torsional_damper=content.model("torsional_damper", TorsionalDamperSection),
        axial_damper=content.model("axial_damper", AxialDamperSection),
        driven=content.model("driven", Driven),
        bearings=content.model("bearings", Bearings),
        shaft_lines=_shaft_lines(content),
        gas=gas,
        gas_map=gas_map,
        misfire=misfire,
        propeller_forces=content.model("propeller_forces", PropellerForcesSection),
        limits=content.model("limits", LimitsInput),
        ranges=content.model("ranges", RangesInput),
        torque_table=None
        if torque is None
        else find_table("torque.table", content.path, torque.table),
        two_mass=content.model("two_mass_check", TwoMassInput),
        study=study_plan(content, throws, first, material),
        records=tuple(content.records),
        provenance=content.provenance,
        sources=content.sources,
        throws_by_name={} if PLAIN in throws else throws,
    )


def load_engine_or_throw(path: str | Path | TomlFile) -> EngineFile | ThrowFile:
    """Read and check a file: as an engine if it has any of its sections, else as a throw.

    Raises
    ------
    InputError
    """
    content = engine_sections(path)
    if not describes_a_throw(content):
        return load_engine(content)
    check_sections(content, ["throw"])
    throws = read_throws(content)
    material = content.model("material", Material) or STEEL
    content.model("engine", Engine)
    first = free_end_throw_name(throws, content.model("shaft", ShaftLayout))
    content.model("shaft_ends", ShaftEnds)
    study_plan(content, throws, first, material)
    return ThrowFile(content.path, throws, throws[first], material, tuple(content.records))


def _shaft_lines(content: TomlFile) -> dict[str, Chain]:
    """Read the chains of what follows the flywheel.

    Raises
    ------
    InputError
        Also if one is of the other kind.
    """
    given = content.model("shaft_line", ShaftLineFiles)
    found: dict[str, Chain] = {}
    for kind in ("torsional", "axial"):
        name = None if given is None else getattr(given, kind)
        if name is None:
            continue
        beside = content.path.parent / name
        read = load_chain(beside if beside.is_file() else name)
        if read.kind != kind:
            raise InputError(
                f"shaft_line.{kind}: given {name!r}, a chain of kind {read.kind}; allowed is one of kind "
                f"{kind}, because it continues that chain of the engine."
            )
        found[kind] = read.chain
    return found


def _check_misfire(misfire: Misfire | None, gas: Gas | None, engine: Engine) -> None:
    """Refuse cylinders that are not there, and failing ones without a pressure.

    Raises
    ------
    InputError
    """
    if misfire is None:
        return
    wrong = [number for number in misfire.cylinders if not 1 <= number <= engine.cylinders]
    if wrong:
        raise InputError(
            f"misfire.cylinders: given {wrong[0]}; allowed is 1 to {engine.cylinders}, because the engine "
            "has these cylinders."
        )
    if gas is None:
        raise InputError(
            "misfire: given without the section [gas]; allowed are both, because the pressure without "
            "combustion follows from it."
        )


def _check_gas_map(gas_map: GasMap | None, engine: Engine) -> None:
    """Refuse a pressure map that does not cover the running range.

    Raises
    ------
    InputError
    """
    if gas_map is None:
        return
    speeds = [point.speed for point in gas_map.points]
    if min(speeds) > engine.lowest_speed or max(speeds) < engine.highest_speed:
        given, allowed = (
            f"{format_quantity(low, 'rad/s', 5)} to {format_quantity(high, 'rad/s', 5)}"
            for low, high in (
                (min(speeds), max(speeds)),
                (engine.lowest_speed, engine.highest_speed),
            )
        )
        raise InputError(
            f"gas_map.points: given speeds from {given}; allowed are ones that cover the running range of "
            f"{allowed}, because nothing is guessed beyond the diagrams."
        )


def _check_sources(vibration: VibrationSettings, study: StudyPlan | None) -> None:
    """Refuse an unknown source of compliances before anything is computed."""
    for kind, given, formulas in (
        ("axial", vibration.axial_source, AXIAL_FORMULA_NAMES),
        ("torsional", vibration.torsional_source, TORSIONAL_FORMULA_NAMES),
    ):
        allowed = ["fe", "fe pinned", *(["regression"] if study is not None else []), *formulas]
        if given.casefold() not in [name.casefold() for name in allowed]:
            reason = (
                ", because the file has no section [study] to fit"
                if given.casefold() == "regression"
                else ""
            )
            raise InputError(
                f"vibration.{kind}_source: given {given!r}; allowed are {', '.join(allowed)}{reason}."
            )


def _check_highest_order(vibration: VibrationSettings, engine: Engine) -> None:
    """Refuse a highest order that the engine's cycle has not."""
    lowest = 2.0 / engine.strokes
    if vibration.highest_order < lowest or vibration.highest_order % lowest:
        raise InputError(
            f"vibration.highest_order: given {vibration.highest_order:g}; allowed are multiples of "
            f"{lowest:g}, because these are the orders of a {engine.strokes}-stroke engine."
        )
