"""The designs of a study for other solvers: a table of them, and a mesh or a solid of each."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from crankbase.errors import InputError, MeshError
from crankbase.outputs import atomic_file, check_output, is_listed, write_errors
from geometry.mesher import mesh_isolated
from geometry.solid_files import SOLID_ENDINGS, write_mesh, write_step
from geometry.throw import CrankThrow
from regression.plans.plan import PlannedDesign, PlannedStudy
from regression.records import content_key
from regression.runs.exchange import Column, columns, write_csv
from regression.runs.study_table import study_table

TABLE = "designs.csv"
KINDS = (*(ending.removeprefix(".") for ending in SOLID_ENDINGS), "step")
# What the table of a study says of designs that are computed.
OF_RESULTS = ("status", "source", "seconds", "unknowns", "model_version", "reason")


@dataclass(frozen=True)
class ExportedDesigns:
    """Files of a study's designs.

    Attributes
    ----------
    table : Path
        A line for each design: its number, file and role, factors and dimensions. With columns of
        responses added, a study can import it.
    files : tuple of Path
        Of the designs in order, whether they exist or not.
    written : int
        Number of files written in this call.
    failures : dict
        File that could not be made to the reason.
    """

    table: Path
    files: tuple[Path, ...]
    written: int
    failures: dict[Path, str]


def export_designs(
    planned: PlannedStudy, folder: Path, kind: str, progress: Callable[[int, int], None]
) -> ExportedDesigns:
    """Write a table of a study's designs, and a mesh or a solid of each.

    A file's name has the key of its throw; existing files of an earlier call are not written again.

    Parameters
    ----------
    planned : PlannedStudy
    folder : Path
    kind : str
        One of `KINDS`: the ending of a mesh's file, or "step". Whole throws, lengths in m; the meshes are
        second-order tetrahedra of the usual sizes.
    progress : callable
        Called with (finished, total).

    Returns
    -------
    ExportedDesigns

    Raises
    ------
    InputError
        If a file cannot be written, or is not ours: checked before anything is meshed.
    MissingLibraryError
        If the kind needs a package that is not installed.
    """
    check_kind(kind)
    files = tuple(
        folder / f"{place:03d}-{content_key(design.inputs['throw'])[:8]}.{kind}"
        for place, design in enumerate(planned.designs, start=1)
    )
    missing = [
        place for place, file in enumerate(files) if not (file.is_file() and is_listed(file))
    ]
    for place in missing:
        check_output(files[place], "solid" if kind == "step" else "mesh")
    table = folder / TABLE
    with write_errors(table), atomic_file(table, "table") as part:
        write_csv(part, _columns(planned, files))
    failures = {}
    done = len(files) - len(missing)
    progress(done, len(files))
    for place in missing:
        try:
            _write(planned.designs[place], files[place])
        except MeshError as error:
            failures[files[place]] = str(error)
        done += 1
        progress(done, len(files))
    return ExportedDesigns(table, files, len(missing) - len(failures), failures)


def check_kind(kind: str) -> None:
    """Refuse a kind of file that is not in `KINDS`.

    Raises
    ------
    InputError
    """
    if kind not in KINDS:
        raise InputError(f"mesh: given {kind!r}; allowed are {', '.join(KINDS)}.")


def _columns(planned: PlannedStudy, files: tuple[Path, ...]) -> list[Column]:
    about = columns(study_table(planned.plan, planned.designs, {}))
    return [
        Column("design", "", list(range(1, len(files) + 1))),
        Column("file", "", [file.name for file in files]),
        *(column for column in about if column.name not in OF_RESULTS),
    ]


def _write(design: PlannedDesign, file: Path) -> None:
    throw = CrankThrow(**design.inputs["throw"])
    if file.suffix == ".step":
        write_step(throw, file)
    else:
        write_mesh(mesh_isolated(throw, part="full"), file)
