"""Write the class document of an engine into a folder: the page, its diagrams, its tables."""

from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from crankbase.errors import InputError
from crankbase.outputs import check_output, files_listed, protected, recording_run_files, write_text
from crankbase.table import Table
from crankfem.analyses.engine_mechanism import engine_inputs
from crankfem.analyses.file_check import refuse_what_cannot_run
from crankfem.analyses.provenance import provenance
from crankfem.analyses.vibration.run import EngineVibration, engine_vibration
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.jobs.outputs import write_rows
from crankfem.jobs.run_files import Progress, SilentProgress, make_folders
from crankfem.report.text_filters import moment
from crankfem.satellites.class_document.document import (
    DocumentPart,
    check_submission,
    class_document,
)
from crankfem.satellites.class_document.page import render_class_document

PAGE, TABLES, DIAGRAMS = "class.html", "class-tables", "class-diagrams"


@dataclass(frozen=True, eq=False)
class WrittenDocument:
    """Files that were written, and their inputs."""

    page: Path
    tables: tuple[Path, ...]
    run: EngineVibration
    parts: tuple[DocumentPart, ...]


def write_class_document(
    engine: str | Path | EngineFile, output: str | Path, progress: Progress | None = None
) -> WrittenDocument:
    """Calculate an engine's torsional vibration and write the class document.

    Everything is calculated and drawn before the last document in the folder is replaced.

    Parameters
    ----------
    engine : path or EngineFile
        Engine file, or the name of a shipped engine.
    output : path
        Folder, which is made if it is not there: the page, its tables as CSV, and its diagrams.

    Raises
    ------
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    OSError
        If a file cannot be written.
    """
    reporter = progress or SilentProgress()
    reporter.step("Reading the engine file")
    read = engine if isinstance(engine, EngineFile) else load_engine(engine)
    refuse_what_cannot_run(read)
    check_submission(read)
    with protected(*(file.path for file in engine_inputs(read))):
        folder = _checked_folder(output)
        run = engine_vibration(read, step=reporter.step)
        reporter.step("Calculating all cylinders failing")
        parts = class_document(run)
        reporter.step("Drawing diagrams")
        for place in (folder / TABLES, folder / DIAGRAMS):  # another engine has others
            for path in files_listed(place):
                path.unlink(missing_ok=True)
        drawn = {}
        with recording_run_files():
            for picture in chain.from_iterable(part.pictures for part in parts):
                drawn[picture.name] = folder / DIAGRAMS / f"{picture.name}.svg"
                picture.draw(drawn[picture.name])
        reporter.step("Writing the document")
        created = moment(provenance().created)
        page = write_text(
            folder / PAGE, render_class_document(run, parts, drawn, created), "report"
        )
        with recording_run_files():
            tables = {
                folder / TABLES / f"{part_table.name}.csv": part_table.table
                for part in parts
                for part_table in part.tables
            }
            for path, table in tables.items():
                write_rows(path, [column.head() for column in table.columns], _rows(table))
    return WrittenDocument(page, tuple(tables), run, parts)


def _checked_folder(output: str | Path) -> Path:
    """Make the folders, refuse to replace files that crankfem did not write, and return the first folder."""
    folder = Path(output)
    if not str(output).strip() or folder.is_file():
        raise InputError(
            f"output: given {str(output)!r}; allowed is a writable folder, because the document, its "
            "tables and diagrams are files in it."
        )
    make_folders(folder, TABLES, DIAGRAMS)
    check_output(folder / PAGE, "report")
    with recording_run_files():
        for path in sorted((folder / TABLES).glob("*.csv")):
            check_output(path, "table")
        for path in sorted((folder / DIAGRAMS).glob("*.svg")):
            check_output(path, "picture")
    return folder


def _rows(table: Table) -> list[list[str]]:
    """Write the cells of a table in the units of its heads, with six digits."""
    return [
        [
            f"{cell / column.display_unit().size:.6g}"
            if isinstance(cell, float)
            else column.text(cell)
            for column, cell in zip(table.columns, row, strict=True)
        ]
        for row in table.rows
    ]
