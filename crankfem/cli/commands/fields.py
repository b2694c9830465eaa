"""Meaning of the fields of an engine file, or of a chain file."""

from typing import Annotated

import typer

from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json, print_table


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

    from crankbase.tables.table import Column, Table
    from crankfem.files.engine.field_tables import section_tables

    found = section_tables(section)
    if out.json:
        print_json({"sections": [asdict(table) for table in found]})
        return
    for table in found:
        columns = [Column(name, words=True) for name in ("field", "unit", "allowed", "meaning")]
        rows = [list(astuple(row)) for row in table.rows]
        print_table(Table(f"{table.title} ({table.need})", columns, rows))
