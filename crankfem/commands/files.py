"""Engine files: start one, check one, and what their fields mean."""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankfem import console, tables
from crankfem.commands.options import EngineArgument, JsonOption
from crankfem.console import print_json, print_table, rows_of
from crankfem.data_files import engine_path, shipped_engines
from geometry.errors import InputError

if TYPE_CHECKING:
    from geometry.throw import CrankThrow


def new(
    file: Annotated[Path, typer.Argument(metavar="MY.toml", help="The file to write.")],
    source: Annotated[str, typer.Option("--from", help="Shipped engine to copy.")] = "6chn25-34",
    json: JsonOption = False,
) -> None:
    """Copy a shipped engine file as the start of one's own."""
    if file.exists():
        raise InputError(f"{file}: exists already; give a new file name.")
    name = source.removesuffix(".toml")
    if name not in shipped_engines():
        raise InputError(f"--from: given {source!r}; allowed are {', '.join(shipped_engines())}.")
    shutil.copyfile(engine_path(name), file)
    if json:
        print_json({"file": str(file), "from": name})
        return
    console.output.print(
        f"{file} written. Replace its values with yours (those marked assumed first), then: "
        f"crankfem {_next_command(file)} {file}",
        soft_wrap=True,
    )


def _next_command(file: Path) -> str:
    """What serves a file best: run takes whole engines only."""
    from crankfem.mechanism_file import MechanismFile, load_any
    from crankfem.throw_file import ThrowFile

    kind = type(load_any(file))
    return {MechanismFile: "mechanism", ThrowFile: "throw"}.get(kind, "run")


def check(engine: EngineArgument, json: JsonOption = False) -> None:
    """Check an engine file or a throw's, and list what is assumed in it."""
    from crankfem.engine_file import EngineFile
    from crankfem.mechanism_file import MechanismFile, load_any
    from crankfem.results import input_records

    read = load_any(engine)
    records = input_records(read.records)
    kind, name = "throw", None
    if isinstance(read, EngineFile):
        kind, name = "engine", read.engine.name
    elif isinstance(read, MechanismFile):
        kind, name = "mechanism", read.name
    assumed = sum(record["assumed"] for record in records)
    if json:
        shape = _shape_record(read.throw)
        print_json({"engine": name, "kind": kind, "valid": True, "shape": shape, "inputs": records})
        return
    console.output.print(
        f"{read.path}: valid {kind} file; {assumed} of {len(records)} values are assumed."
    )
    if kind == "throw":
        console.output.print(
            "It describes a throw, not an engine: it serves throw, formulas, draw and export.",
            soft_wrap=True,
        )
    if kind == "mechanism":
        console.output.print(
            "It describes cranks, rods and pistons, not a whole engine: it serves mechanism, harmonics, "
            "throw, formulas, draw and export.",
            soft_wrap=True,
        )
    tables.print_shape(_shape_record(read.throw))
    print_table(
        "Inputs",
        ["field", "value:", "assumed:", "source:"],
        rows_of(
            records,
            lambda r: r["field"],
            lambda r: r["given"],
            lambda r: "yes" if r["assumed"] else "",
            lambda r: r["source"],
        ),
    )


def fields(
    section: Annotated[
        str | None,
        typer.Argument(help="Section of an engine file, such as throw; all if not given."),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Say what every field of an engine file means: unit, allowed range, default."""
    from dataclasses import asdict

    from crankfem.field_tables import section_tables

    found = section_tables(section)
    if json:
        print_json({"sections": [asdict(table) for table in found]})
        return
    for table in found:
        print_table(
            f"{table.title} ({table.need})",
            ["field", "unit:", "allowed:", "meaning:"],
            [[row.name, row.unit, row.allowed, row.meaning] for row in table.rows],
        )


def _shape_record(throw: "CrankThrow") -> dict[str, Any]:
    """What the dimensions make: sizes that follow, and how much of the throw must be solved."""
    return {
        "length": throw.length,
        "overlap": throw.overlap,
        "volume": throw.volume,
        "pins": len(throw.parts.pins),
        "solved_part": throw.symmetry,
        "remarks": list(throw.remarks),
    }
