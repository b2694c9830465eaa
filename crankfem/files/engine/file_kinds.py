"""The sections of engine files; the kind of a file; the shipped files."""

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

from crankbase.errors import InputError
from crankbase.input_file import LOOKED_AT
from crankbase.model import InputModel
from crankfem.files.reading.data_files import input_kinds, input_path, shipped_names
from crankfem.files.reading.toml_file import TomlFile, read_toml
from crankfem.files.satellites import at_place, satellite_files

# A file with none of these is not meant as a whole engine.
ENGINE_SECTIONS = {"rod", "piston", "flywheel", "thrust_bearing"}


@dataclass(frozen=True)
class EngineSection:
    """A section: place of its model, loaded on demand; where it is needed; whether an engine needs it."""

    place: str
    need: str = "optional"
    required: bool = False

    @property
    def model(self) -> type[InputModel]:
        """Its model."""
        model: type[InputModel] = at_place(self.place, "crankfem.files")
        return model


MECHANISM, WHOLE_ENGINE = "required for more than a throw", "required for run and vibration"

SECTIONS = {
    "engine": EngineSection(".sections.engine_sections:Engine", MECHANISM, required=True),
    "throw": EngineSection("geometry.throw:CrankThrow", "required", required=True),
    "throws": EngineSection(
        ".sections.crank_throws:NamedThrow",
        "optional, in place of [throw]; with all fields of [throw] and",
    ),
    "shaft": EngineSection(".sections.crank_throws:ShaftLayout"),
    "shaft_ends": EngineSection("geometry.crankshaft:ShaftEnds"),
    "material": EngineSection("fem.material:Material", "optional, steel by default"),
    "rod": EngineSection(".sections.mechanism_sections:Rod", MECHANISM, required=True),
    "piston": EngineSection(".sections.mechanism_sections:Piston", MECHANISM, required=True),
    "hinged_rods": EngineSection(".sections.mechanism_sections:HingedRods"),
    "flywheel": EngineSection(".sections.engine_sections:Flywheel", WHOLE_ENGINE, required=True),
    "free_end": EngineSection(".sections.engine_sections:FreeEnd"),
    "thrust_bearing": EngineSection(
        ".sections.engine_sections:ThrustBearing", WHOLE_ENGINE, required=True
    ),
    "damping": EngineSection(".sections.vibration_sections:Damping"),
    "torsional_damper": EngineSection(".sections.vibration_sections:TorsionalDamperSection"),
    "axial_damper": EngineSection(".sections.vibration_sections:AxialDamperSection"),
    "driven": EngineSection("dynamics.chains.shaft_line:Driven"),
    "driver": EngineSection(
        "dynamics.chains.shaft_line:Driver",
        "optional, in place of [driven] with engine.driven_by; with the same fields",
    ),
    "bearings": EngineSection(".sections.vibration_sections:Bearings"),
    "shaft_line": EngineSection(".sections.vibration_sections:ShaftLineFiles"),
    "gas": EngineSection(
        ".sections.mechanism_sections:Gas", "optional; without it reactions are given for 100 kN"
    ),
    "load": EngineSection(".sections.mechanism_sections:LoadSection"),
    "gas_map": EngineSection(".sections.excitation_sections:GasMap"),
    "misfire": EngineSection(".sections.excitation_sections:Misfire"),
    "propeller_forces": EngineSection(".sections.excitation_sections:PropellerForcesSection"),
    "limits": EngineSection(".sections.limits_sections:LimitsInput"),
    "ranges": EngineSection(".sections.limits_sections:RangesInput"),
    "strength": EngineSection(".sections.strength_section:StrengthSection"),
    "vibration": EngineSection(".sections.engine_sections:VibrationSettings"),
    "torque": EngineSection(".sections.engine_sections:TorqueTable"),
    "two_mass_check": EngineSection(".sections.engine_sections:TwoMassInput"),
    "study": EngineSection(".study_file:StudySection"),
}

# A section that files of input have, at the beginning of a line.
MARKS = "".join(f"|{mark}" for files in satellite_files().values() for mark in files.marks)
SECTION = re.compile(rf"^\s*\[(?:engine|throw|throws\.\w+|chain{MARKS})\]", re.MULTILINE)


def file_kind(content: TomlFile) -> str:
    """Return the kind of a file, from its sections.

    A throw has no engine around it; a mechanism has cranks, rods and pistons, but no flywheel
    or thrust bearing for the chains.
    """
    sections = set(content.sections)
    if "chain" in sections:
        return "chain"
    for kind, files in satellite_files().items():
        if "throw" not in sections and sections & files.marks:
            return kind
    if sections & {"throw", "throws"} and not sections & ENGINE_SECTIONS:
        return "throw"
    if {"engine", "rod", "piston"} <= sections and not sections & {"flywheel", "thrust_bearing"}:
        return "mechanism"
    return "engine"


def engine_sections(source: str | Path | TomlFile) -> TomlFile:
    """Return the sections of an engine file, or of a shipped engine.

    Parameters
    ----------
    source : path or TomlFile
        Sections that have been read already are not read again, so that a command uses them in
        one state of the file. Their records start anew.
    """
    content = source if isinstance(source, TomlFile) else read_toml(input_path(source))
    if (files := satellite_files().get(file_kind(content))) is not None:
        raise InputError(f"{content.path.name}: {files.about}; use it with {files.command}.")
    return replace(content, records=[])


def check_sections(content: TomlFile, needed: Collection[str] | None = None) -> None:
    """Refuse unknown and missing sections; [throws.NAME] may replace [throw].

    Parameters
    ----------
    needed : collection of str, optional
        Required sections; those of a whole engine by default.
    """
    allowed = {
        name: kind.required if needed is None else name in needed for name, kind in SECTIONS.items()
    }
    named = "throws" in content.sections
    content.check_sections(allowed | {"throw": allowed["throw"] and not named})
    if named and "throw" in content.sections:
        raise InputError(
            "throws: given together with the section [throw]; allowed is one of the two, because every "
            "crank is the one throw or a named one."
        )


def any_sections(file: str) -> TomlFile | None:
    """Return the sections of any file of input, or of a shipped one; None if it is the text of a chain."""
    name = Path(file).name.removesuffix(".toml")
    kinds = [kind for kind in input_kinds() if kind != "engine" and name in shipped_names(kind)]
    path = input_path(file, *kinds[:1])
    if path.suffix.lower() == ".toml":
        return read_toml(path)
    try:
        with path.open(encoding="utf-8-sig") as text:
            has_sections = SECTION.search(text.read(LOOKED_AT)) is not None
    except (OSError, UnicodeDecodeError):
        return None
    return read_toml(path) if has_sections else None


@dataclass(frozen=True)
class ShippedFile:
    """A shipped file: its name, what it describes, a line about it."""

    name: str
    kind: str
    about: str
    path: Path


def shipped_files() -> tuple[ShippedFile, ...]:
    """Return all shipped files, engines first."""
    shipped = []
    for path in (input_path(name, kind) for kind in input_kinds() for name in shipped_names(kind)):
        words = []
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line.startswith("#") or line.startswith("#  "):
                break
            words.append(line.removeprefix("#").strip())
        # The first sentence of the comment at its head tells what it is.
        about = " ".join(words).partition(". ")[0].partition("; ")[0].rstrip(".")
        shipped.append(ShippedFile(path.stem, file_kind(read_toml(path)), about, path))
    return tuple(shipped)
