"""`crankfem check`, `new` and `fields`: input files."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crankbase.choices import allowed_names
from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json, print_table
from crankfem.files.reading.data_files import input_kinds
from crankfem.files.satellites import satellite_files

if TYPE_CHECKING:
    from geometry.any_throw import Throw


@with_output(files=True, units=True)
def check(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE.toml",
            help=f"Engine, {', '.join(['throw', *satellite_files()])} or chain file, or the name of "
            "a shipped one.",
            autocompletion=completion.any_input,
        ),
    ],
    picture: Annotated[
        Path | None,
        typer.Option(metavar="THROW.svg", help="Also draw the throw with its dimensions."),
    ] = None,
    *,
    out: Output,
) -> None:
    """Check a file: show how it is read, what is assumed, and which commands can use it."""
    from crankfem.analyses.file_check import check_file, check_record
    from crankfem.cli.tables.throw_tables import check_answer, check_parts

    checked = check_file(file)
    record = check_record(checked)
    if picture is not None:
        from crankfem.analyses.throw.pictures.drawing import check_drawing_ending, write_drawing
        from crankfem.jobs.outputs import check_writable
        from geometry.any_throw import with_dimensions

        if checked.throw is None:
            raise InputError(
                f"--picture: given with a {checked.kind} file; allowed is a file with a throw, because "
                "that is drawn."
            )
        check_drawing_ending(picture)
        check_writable(picture, "picture", checked.path)
        record["picture"] = str(
            write_drawing(with_dimensions(checked.throw), picture, checked.path.stem)
        )
    if out.json:
        print_json(record)
        return
    written = [] if picture is None else [f"{picture} written."]
    out.show(check_parts(record, out.units), *written, check_answer(record))


CYLINDERS, STROKES = 6, 4
# What serves a file best, by its kind.
NEXT = {
    "engine": "run",
    "mechanism": "mechanism",
    "throw": "throw",
    **{kind: files.command for kind, files in satellite_files().items()},
    "chain": "vibration",
}


@with_output(files=True)
def new(
    file: Annotated[
        Path | None, typer.Argument(metavar="ENGINE.toml", help="The file to write.")
    ] = None,
    source: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help=f"Copy this shipped {', '.join(input_kinds()[:-1])} or chain in place of the template.",
            autocompletion=completion.shipped,
        ),
    ] = None,
    cylinders: Annotated[
        int | None,
        typer.Option(help="Cylinders of the template, 1 to 20.", show_default=str(CYLINDERS)),
    ] = None,
    strokes: Annotated[
        int | None, typer.Option(help="Its strokes per cycle, 2 or 4.", show_default=str(STROKES))
    ] = None,
    v_angle: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLE",
            help='Angle between the banks of a V engine, like "60 deg"; "even" for one with even firing. '
            "Without it the cylinders are in line.",
        ),
    ] = None,
    drawing: Annotated[
        Path | None,
        typer.Option(
            metavar="THROW.svg",
            help="Also draw its throw with the names of the fields, to see which value of a drawing is "
            "which field.",
        ),
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="List what is shipped.")] = False,
    *,
    out: Output,
) -> None:
    """Write an example engine file with explanations, ready to run, or copy a shipped one."""
    from crankbase.outputs import write_user_file
    from crankbase.table import Column, Table
    from crankfem.analyses.record import attributes
    from crankfem.files.engine.file_kinds import shipped_files
    from crankfem.files.engine.new_file import engine_template, template_throw
    from crankfem.jobs.outputs import check_writable

    if listed:
        if file is not None or source is not None:
            raise InputError(
                "--list: given with a file; allowed is --list alone, because it writes none."
            )
        if out.json:
            entries = [
                attributes(shipped, "name", "kind", "about") | {"file": str(shipped.path)}
                for shipped in shipped_files()
            ]
            print_json({"shipped": entries})
            return
        heads = ("name", "kind", "about")
        print_table(
            Table.of_records(
                "Shipped files, for `crankfem new MY.toml --from NAME` or by name in place of a file",
                shipped_files(),
                *((Column(head, words=True), head) for head in heads),
            )
        )
        return
    if file is None:
        raise InputError(
            "new: given no file; allowed is the name of one to write, like `crankfem new mine.toml`, or "
            "--list."
        )
    if os.path.lexists(file) and not out.force:
        raise InputError(f"{file}: exists already; give a new file name, or --force to replace it.")
    check_writable(file, "input file")
    throw: Throw | None = None
    if drawing is not None:
        from crankfem.analyses.file_check import check_file
        from crankfem.analyses.throw.pictures.drawing import check_drawing_ending, write_drawing

        check_drawing_ending(drawing)
        check_writable(drawing, "picture", file)
    if source is None:
        kind = "engine"
        text = engine_template(
            file.name,
            CYLINDERS if cylinders is None else cylinders,
            STROKES if strokes is None else strokes,
            v_angle,
        )
        if drawing is not None:
            throw = template_throw(text)
        write_user_file(file, text.encode())
    else:
        for option, value in (
            ("--cylinders", cylinders),
            ("--strokes", strokes),
            ("--v-angle", v_angle),
        ):
            if value is not None:
                raise InputError(
                    f"{option}: given {value} with --from; allowed is one of the two, because a copy has "
                    "its own cylinders."
                )
        known = {shipped.name: shipped for shipped in shipped_files()}
        copied = known.get(source.removesuffix(".toml"))
        if copied is None:
            raise InputError(
                f"--from: given {source!r}; {allowed_names(source, known)}, because these are shipped."
            )
        kind = copied.kind
        if drawing is not None and (throw := check_file(str(copied.path)).throw) is None:
            raise InputError(
                f"--drawing: given with a {kind} file; allowed is a file with a throw, because that is drawn."
            )
        check_writable(file, "input file", copied.path)
        write_user_file(file, copied.path.read_bytes())
    command = f"crankfem {NEXT[kind]} {file}"
    if drawing is not None and throw is not None:
        from geometry.any_throw import with_dimensions

        write_drawing(with_dimensions(throw), drawing, file.stem, lettered=True)
    if out.json:
        print_json({"file": str(file), "from": source, "kind": kind, "next": command})
        return
    if drawing is not None:
        console.print_line(f"{drawing} written.")
    console.print_line(
        f"{file} written. Replace its values with yours (those marked assumed first), check them with "
        f"`crankfem check {file}`, then: {command}"
    )


@with_output()
def fields(
    section: Annotated[
        str | None,
        typer.Argument(
            help="Section of an engine file, such as throw, or chain for a chain file; by default all "
            "sections of an engine file.",
            autocompletion=completion.sections,
        ),
    ] = None,
    *,
    out: Output,
) -> None:
    """List the fields of an engine or chain file: meaning, unit, allowed range, default."""
    from dataclasses import asdict, astuple

    from crankbase.table import Column, Table
    from crankfem.files.engine.field_tables import section_tables

    tables = section_tables(section)
    if out.json:
        print_json({"sections": [asdict(table) for table in tables]})
        return
    for table in tables:
        columns = [Column(name, words=True) for name in ("field", "unit", "allowed", "meaning")]
        rows = [list(astuple(row)) for row in table.rows]
        print_table(Table(f"{table.title} ({table.need})", columns, rows))
