"""The quick check of an engine as two masses on one shaft."""

from typing import Annotated

import typer

from crankbase.errors import InputError
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json

MOST_ORDER = 48.0


@with_output(units=True)
def two_mass(
    engine: Annotated[
        str,
        typer.Argument(
            metavar="ENGINE.toml",
            help="Engine file with a section \\[two_mass_check], or a file of that section alone.",
            autocompletion=completion.engines,
        ),
    ],
    order: Annotated[
        float | None, typer.Option(help="Order examined; by default that of the file.")
    ] = None,
    *,
    out: Output,
) -> None:
    """Check a crankshaft as two masses on one shaft: frequency, resonant orders, excitation."""
    from crankfem.analyses.mechanism.two_masses import read_two_masses, two_mass_run_record
    from crankfem.cli.tables.two_mass_tables import print_two_masses
    from crankfem.files.engine.file_kinds import any_sections

    if order is not None and not 0.0 < order <= MOST_ORDER:
        raise InputError(
            f"--order: given {order:g}; allowed is an order above 0 up to {MOST_ORDER:g}, because orders "
            "count cycles per crankshaft revolution."
        )
    content = any_sections(engine)
    if content is None:
        raise InputError(f"{engine}: is no TOML file; allowed is an engine file.")
    record = two_mass_run_record(read_two_masses(content), order)
    if out.json:
        print_json(record, "two_mass")
    else:
        print_two_masses(record, out.units)
