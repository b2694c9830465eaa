"""The work of jobs, each in a worker process: from the request and its files to files in the job's folder."""

import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import psutil

from crankbase.errors import InputError, MeshError, first_sentences
from crankbase.input_file import STEP_ENDINGS
from crankbase.outputs import write_text
from crankbase.processes import scratch_folder
from crankbase.results import Result, json_text
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_file import TomlFile, read_toml
from crankfem.satellites.service.asking import (
    UNIT_FORCE,
    AnalysisQuestion,
    FileQuestion,
    ProblemError,
    StressQuestion,
    parse_question,
)
from geometry.gmsh_session import IsolatedProcess
from regression.records import Outcome

_PLAIN = re.compile(r"[A-Za-z0-9][\w .()+-]{0,79}", re.ASCII)
TABLE_ENDINGS = (".csv", ".json", ".toml")
MOST_TABLES = 200
# Faces of an uploaded STEP file, and memory that reading it may take [bytes].
MOST_FACES, CHECK_MEMORY = 3000, 2_000_000_000
# The folder of a job in which its uploaded files are kept, apart from all that the job writes.
KEPT = "sent"


def read_upload(question: Mapping[str, Any]) -> TomlFile:
    """Read an uploaded file; whatever reads the files that it names gets those sent with it, and no other."""
    asked = FileQuestion(**question)
    _check_name("name", asked.name, (".toml",))
    if len(asked.tables) > MOST_TABLES:
        raise InputError(
            f"tables: given {len(asked.tables)}; allowed are {MOST_TABLES} at most, because each list of "
            "jobs names the files of all."
        )
    contents = {asked.name: _encoded(asked.name, asked.text)}
    for name, text in asked.tables.items():
        _check_name("tables", name, TABLE_ENDINGS)
        if name in contents:
            raise InputError(
                f"tables: given {name!r}, the name of the file itself; allowed is another."
            )
        contents[name] = _encoded(name, text)
    return read_toml(InputFiles(Path(asked.name), contents))


def _kept_upload(question: Mapping[str, Any], folder: Path) -> TomlFile:
    """Read an uploaded file; write it, and those sent with it, where nothing that a job writes is."""
    content = read_upload(question)
    (folder / KEPT).mkdir(exist_ok=True)
    for name, sent in (content.files.sent or {}).items():
        (folder / KEPT / name).write_bytes(sent)
    return content


def _encoded(name: str, text: str) -> bytes:
    try:
        return text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{name}: given text with half a character; allowed is Unicode.") from None


def _check_name(field: str, name: str, endings: tuple[str, ...]) -> None:
    if _PLAIN.fullmatch(name) is None or not name.endswith(endings):
        raise InputError(
            f"{field}: given {name!r}; allowed is the plain name of a file that ends in "
            f"{' or '.join(endings)}, of up to 80 letters, digits, spaces and . ( ) + - _, because uploaded "
            "files share a folder."
        )


RESULT, SOLID, MODEL = "result.json", "throw.step", "model.json"
REPORT, FIRST_SCREEN = "results/report.html", "first_screen.json"
# A medium-speed engine's throw [m], the first one of the page.
EXAMPLE = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.285,
    "web_thickness": 0.068,
    "fillet_radius": 0.012,
}
OnRemark = Callable[[Any], None]


class ToldProgress:
    """Reports the progress of a job to the service."""

    def __init__(self, on_remark: OnRemark) -> None:
        self._tell = on_remark

    def step(self, text: str) -> None:
        """Report a step that begins."""
        self._tell({"step": text})

    def design(self, finished: int, total: int, _: Outcome | None = None) -> None:
        """Return how many designs of a study are finished."""
        self._tell({"finished": finished, "total": total})

    def note(self, text: str) -> None:
        """Report a note for the user."""
        self._tell({"note": text})

    warn = note


def load() -> None:
    """Load what jobs need, before there is one: a coarse throw goes through all of it."""
    from fem.analysis import analyze_throw
    from fem.material import STEEL
    from geometry.mesher import mesh_here
    from geometry.throw import CrankThrow

    for module in (
        "crankfem.analyses.throw.formula_records",
        "crankfem.analyses.throw.pictures.drawing",
        "crankfem.analyses.throw.throw_record",
        "crankfem.report.interactive.throw_view",
        "crankfem.report.writing",
    ):
        import_module(module)
    analyze_throw(CrankThrow(**EXAMPLE), STEEL, 0.1, mesher=mesh_here)


def load_checks() -> None:
    """Load what `check_upload` needs."""
    import_module("crankfem.analyses.file_check")


def run_job(
    kind: str, question: Mapping[str, Any], folder: str, workers: int, on_remark: OnRemark
) -> None:
    """Do a job, in its folder: messages have no path beyond it."""
    try:
        os.chdir(folder)
    except OSError as error:
        raise OSError(error.errno, f"the job's folder: {error.strerror}") from None
    _JOBS[kind](question, Path(), workers, ToldProgress(on_remark))


def _analysis(question: Mapping[str, Any], folder: Path, _: int, reporter: ToldProgress) -> None:
    from crankfem.analyses.provenance import provenance
    from crankfem.analyses.throw.formula_records import formulas_of
    from crankfem.analyses.throw.pictures.drawing import write_drawing
    from crankfem.analyses.throw.stress import stress_results, stresses_or_reason
    from crankfem.analyses.throw.throw_record import throw_results
    from crankfem.report.interactive.throw_view import throw_view
    from crankfem.report.writing import THROW_DRAWING
    from fem.analysis import analyze_throw
    from geometry.mesher import mesh_here
    from geometry.solid_files import step_text

    asked = AnalysisQuestion(**question)
    throw, material = asked.read_throw(), asked.read_material()
    reporter.step("Meshing and solving")
    analysis = analyze_throw(throw, material, asked.accuracy, mesher=mesh_here)
    record: dict[str, Any] = {
        "about": provenance(),
        "throw": throw_results(
            analysis,
            UNIT_FORCE,
            pin_force=asked.pin_force,
            gamma_deg=asked.gamma_deg,
            left_gamma_deg=asked.left_gamma_deg,
            slopes=True,
        ),
        "formulas": formulas_of(
            throw, material, 180.0 if asked.gamma_deg is None else asked.gamma_deg
        ),
        "fillets": None,
        "fillet_note": None,
    }
    _write(folder, record)
    reporter.step("Drawing the throw")
    throw_view(folder, analysis)
    if asked.stress:
        reporter.step("Calculating stresses at the fillets")
        stresses, record["fillet_note"] = stresses_or_reason(throw, material)
        if stresses is not None:
            record["fillets"] = stress_results(stresses)
            throw_view(folder, analysis, stresses)
        _write(folder, record)
    reporter.step("Writing the solid")
    write_text(folder / SOLID, step_text(throw, "full"), "solid")
    reporter.step("Drawing the dimensions")
    write_drawing(throw, folder / THROW_DRAWING, "Crank throw")


def _stress(question: Mapping[str, Any], folder: Path, _: int, reporter: ToldProgress) -> None:
    from crankfem.analyses.throw.stress import stress_results
    from fem.fillet_stress import fillet_stresses

    asked = StressQuestion(**question)
    reporter.step("Calculating stresses at the fillets")
    stresses = fillet_stresses(asked.read_throw(), asked.read_material(), asked.accuracy)
    _write(folder, stress_results(stresses))


def _study(question: Mapping[str, Any], folder: Path, workers: int, reporter: ToldProgress) -> None:
    from crankfem.analyses.study.fit_records import fitted_study
    from crankfem.analyses.study.studies import run_study

    content = _kept_upload(question, folder)
    reporter.step("Running the study")
    study = run_study(
        content, folder / "study.sqlite", workers, reporter.design, note=reporter.note
    )
    study.model.save(folder / MODEL)
    _write(folder, fitted_study(study.table, study.fits, study.model))


def _engine(
    question: Mapping[str, Any], folder: Path, workers: int, reporter: ToldProgress
) -> None:
    from crankfem.jobs.pipeline import run_engine
    from crankfem.jobs.run_files import results_text
    from crankfem.report.summary import summary
    from crankfem.report.text_filters import printed

    def shown(value: Any) -> Any:
        """Write the values of texts as the report does."""
        if isinstance(value, Mapping):
            return {name: shown(part) for name, part in value.items()}
        return [*map(shown, value)] if isinstance(value, list | tuple) else printed(value)

    content = _kept_upload(question, folder)
    made = run_engine(content, folder / "results", workers=workers, progress=reporter)
    write_text(folder / RESULT, results_text(made.results), "results")
    first = summary(made.results)
    screen = {name: first[name] for name in ("status", "headline", "tiles", "plot")}
    screen["findings"] = [(finding.about, line) for finding, line in first["findings"]]
    write_text(folder / FIRST_SCREEN, json_text(shown(screen)), "results")


def _write(folder: Path, content: dict[str, Any] | Result) -> None:
    from crankfem.analyses.record import with_units

    write_text(folder / RESULT, json_text(with_units(content)), "results")


_JOBS: dict[str, Callable[[Mapping[str, Any], Path, int, ToldProgress], None]] = {
    "analysis": _analysis,
    "stress": _stress,
    "study": _study,
    "engine": _engine,
}


def check_body(body: bytes) -> tuple[dict[str, Any], dict[str, Any]] | tuple[int, str]:
    """Read and check the body of a request with a file: return the question, and what the file is.

    Returns status and sentence of a body that is no question.
    """
    try:
        question = parse_question(body, FileQuestion).model_dump()
        if question["name"].lower().endswith(STEP_ENDINGS):
            return question, check_step(question)
        return question, check_upload(question)
    except ProblemError as refused:
        return refused.status, refused.detail
    except InputError as error:
        raise InputError("\n".join(first_sentences(str(error)))) from None


class _Here(IsolatedProcess):
    """Calls functions in this process, which is one of its own for each file already."""

    def call(
        self,
        function: str,
        *arguments: Any,
        time_limit: float,  # noqa: ARG002 - the whole check has one
        on_remark: Callable[[Any], None] | None = None,
    ) -> Any:
        """Call it."""
        module, _, name = function.partition(":")
        more = {} if on_remark is None else {"on_remark": on_remark}
        return getattr(import_module(module), name)(*arguments, **more)


@contextmanager
def memory_bounded(more: int) -> Iterator[None]:
    """Let this process take so much more memory at most [bytes]; what takes more fails."""
    try:
        import resource  # here: not all systems have it
    except ImportError:
        yield
        return
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = psutil.Process().memory_info().vms + more
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))


def check_step(question: Mapping[str, Any]) -> dict[str, Any]:
    """Read an uploaded STEP file in this process, and return its crankshaft's throws, of steel."""
    from fem.material import STEEL
    from geometry.imported_shaft import import_crankshaft

    asked = FileQuestion(**question)
    _check_name("name", asked.name, STEP_ENDINGS)
    faces = asked.text.count("_FACE(")
    if faces > MOST_FACES:
        raise InputError(
            f"text: given a STEP file with {faces} faces; allowed are {MOST_FACES} at most, because one file "
            "is checked at a time; crankfem cad takes larger ones."
        )
    with scratch_folder() as folder, memory_bounded(CHECK_MEMORY):
        (folder / asked.name).write_bytes(_encoded(asked.name, asked.text))
        try:
            shaft = import_crankshaft(folder / asked.name, folder=folder, process=_Here())
        except (InputError, MeshError, MemoryError) as error:
            reason = str(error).replace(f"{folder.resolve()}/", "") or "it takes too much memory"
            raise InputError(f"text: {reason}") from None
        throws = [
            {
                "number": number,
                "angle_deg": angle,
                "start": start,
                "length": throw.length,
                "mass": mass.mass,
                "inertia_about_shaft": mass.inertia_about_shaft,
                "symmetry": symmetry,
                "like": like,
                "change": change,
            }
            for number, (throw, angle, start, mass, symmetry, (like, change)) in enumerate(
                zip(
                    *(shaft.throws, shaft.angles_deg, shaft.starts, shaft.masses(STEEL.density)),
                    *(shaft.symmetries, shaft.like),
                    strict=False,
                ),
                start=1,
            )
        ]
    units = {"angle_deg": "deg", "start": "m", "length": "m", "mass": "kg"}
    units |= {"inertia_about_shaft": "kg m^2", "number": "1", "like": "1"}
    return {
        "kind": "crankshaft",
        "valid": True,
        "commands": ("cad",),
        "remarks": shaft.remarks,
        "warnings": (),
        "dimensions": None,
        "throw": None,
        "material": None,
        "record": {
            "solid": shaft.solid,
            "throws": throws,
            "units": {f"throws.{name}": unit for name, unit in units.items()},
        },
    }


def check_upload(question: Mapping[str, Any]) -> dict[str, Any]:
    """Read and check an uploaded file, and return its interpretation."""
    from crankfem.analyses.file_check import check_file, check_record
    from geometry.throw import CrankThrow

    checked = check_file(read_upload(question))
    record = check_record(checked)
    throw = checked.throw or next(iter(checked.throws.values()), None)
    return {
        name: record[name]
        for name in ("kind", "valid", "commands", "remarks", "warnings", "dimensions")
    } | {
        "throw": throw.model_dump(mode="json", exclude_defaults=True)
        if isinstance(throw, CrankThrow)
        else None,
        "material": None if throw is None else checked.material.model_dump(),
        "record": record,
    }
