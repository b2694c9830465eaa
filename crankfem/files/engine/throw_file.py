"""Read what a file says of throws alone: one throw, a whole crankshaft, the plan of a study."""

from dataclasses import dataclass
from pathlib import Path

from crankbase.errors import InputError
from crankfem.files.reading.file_kinds import REQUIRED, engine_sections
from crankfem.files.reading.toml_file import InputRecord, TomlFile
from crankfem.files.sections.engine_sections import Engine, ShaftLayout
from crankfem.files.study.study_file import study_plan
from fem.material import STEEL, Material
from geometry.crankshaft import Crankshaft
from geometry.shaft_ends import ShaftEnds
from geometry.throw import CrankThrow
from regression.plans.plan import StudyPlan


def load_throw(path: str | Path | TomlFile) -> tuple[CrankThrow, Material]:
    """Read only the throw and its material from an engine or study file.

    Raises
    ------
    InputError
    """
    content = engine_sections(path)
    content.check_sections(dict.fromkeys(REQUIRED, False) | {"throw": True})
    throw = content.required("throw", CrankThrow)
    return throw, content.model("material", Material) or STEEL


@dataclass(frozen=True)
class ThrowFile:
    """A file that describes a throw alone, read and checked.

    Attributes
    ----------
    path : Path
    throw, material
        Its sections.
    records : tuple of InputRecord
        Every value with its source.
    """

    path: Path
    throw: CrankThrow
    material: Material
    records: tuple[InputRecord, ...]


def load_crankshaft(path: str | Path | TomlFile) -> Crankshaft:
    """Read the whole crankshaft of an engine file: equal throws at their angles, and the ends.

    The angles are ``throw_angles`` of the section [shaft], or the crank angles of [engine].

    Raises
    ------
    InputError
        Also if the file has neither.
    """
    content = engine_sections(path)
    content.check_sections(dict.fromkeys(REQUIRED, False) | {"throw": True})
    throw = content.required("throw", CrankThrow)
    layout = content.model("shaft", ShaftLayout)
    if layout is not None:
        angles = layout.throw_angles
    else:
        engine = content.model("engine", Engine)
        if engine is None:
            raise InputError(
                f"{content.path.name}: the angles of the throws are missing; allowed is throw_angles in a "
                "section [shaft], or crank_angles in [engine]."
            )
        if throw.further_pins:
            raise InputError(
                f"{content.path.name}: a throw has {1 + len(throw.further_pins)} pins, so the crank angles "
                "of [engine] are not those of the throws; give throw_angles in a section [shaft]."
            )
        angles = engine.crank_angles
    ends = content.model("shaft_ends", ShaftEnds) or ShaftEnds()
    return Crankshaft([throw] * len(angles), angles, ends)


def load_study(path: str | Path | TomlFile) -> StudyPlan:
    """Read the plan of a study from a file with the sections [throw] and [study].

    Raises
    ------
    InputError
    """
    content = engine_sections(path)
    content.check_sections(dict.fromkeys(REQUIRED, False) | {"throw": True, "study": True})
    throw = content.required("throw", CrankThrow)
    plan = study_plan(content, throw, content.model("material", Material) or STEEL)
    assert plan is not None  # the section has been made sure of
    return plan
