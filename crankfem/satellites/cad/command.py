"""The command `cad`."""

import os
import shlex
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Annotated

import typer

from crankbase.errors import InputError
from crankbase.input_file import STEP_ENDINGS
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json
from fem.wished_accuracy import COMPLIANCE_ACCURACY

MOST_MODES = 20


@with_output(files=True, units=True)
def cad(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE.step",
            help="STEP file with the whole crankshaft, perhaps beside other solids.",
            autocompletion=completion.files(*STEP_ENDINGS),
        ),
    ],
    solid: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Name or number of the crankshaft among several."),
    ] = None,
    free_end: Annotated[
        str | None,
        typer.Option(
            metavar="low|high",
            help="The free end: that with the low or the high coordinate in the file; by default the thinner "
            "one.",
        ),
    ] = None,
    cut: Annotated[
        list[str] | None,
        typer.Option(
            metavar='"2=3 mm"',
            help="Move a cut, counted from the free end, towards the flange; once for each.",
        ),
    ] = None,
    accuracy: Annotated[
        float, typer.Option(help=f"Relative accuracy of e_n, {COMPLIANCE_ACCURACY}.")
    ] = 0.01,
    no_fe: Annotated[
        bool, typer.Option("--no-fe", help="Only find and weigh the throws, without compliances.")
    ] = False,
    free_modes: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            max=MOST_MODES,
            help="Find N natural frequencies of the whole crankshaft, free in space as in a hammer test.",
        ),
    ] = 0,
    throws: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER", help="Write the throws as STEP files, which crankfem throw takes."
        ),
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            metavar="MINE.toml",
            help="Write an engine file with the throws, and examples of what CAD does not tell.",
        ),
    ] = None,
    v_angle: Annotated[
        str | None,
        typer.Option(
            metavar='"90 deg"',
            help="Angle between two banks: two cylinders on each pin, or on the pins of each throw in turn.",
        ),
    ] = None,
    *,
    out: Output,
) -> None:
    """Find the crankshaft in a STEP file, cut it into throws, and analyze each kind of throw once."""
    from pathlib import Path

    from crankbase.outputs import write_user_file
    from crankfem.analyses.record import with_units
    from crankfem.files.engine.new_file import V_ANGLES
    from crankfem.jobs.outputs import check_outputs, check_writable, make_output_folder
    from crankfem.satellites.cad.dimensions import dimensions_text
    from crankfem.satellites.cad.new_engine import engine_text
    from crankfem.satellites.cad.run import run_cad

    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)
    if no_fe and free_modes:
        raise InputError(
            "--free-modes: given with --no-fe; give one, because modes take finite elements."
        )
    moved = _moved(cut or [])
    if v_angle is not None and engine is None:
        raise InputError(
            f"--v-angle: given {v_angle} without --engine; allowed only with it, whose cylinders it arranges."
        )
    banks = None if v_angle is None else V_ANGLES.read(v_angle)
    check_outputs(None, None, Path(file))
    written = None if engine is None else Path(engine)
    if written is not None:
        if written.suffix != ".toml":
            raise InputError(f"--engine: given {engine}; allowed is a name ending in .toml.")
        if os.path.lexists(written):
            raise InputError(f"--engine: {engine} exists already; give a new file name.")
        check_writable(written, "input file", Path(file))
        throws = throws or str(written.with_name(f"{written.stem}-throws"))
    new_folder = None if throws is None or os.path.lexists(throws) else throws
    folder = make_output_folder("--throws", throws, (), "solid")
    with _removed_if_empty(new_folder), console.RunProgress(out.quiet) as progress:
        run = run_cad(
            file,
            solid=solid,
            free_end=free_end,
            cuts=moved,
            folder=folder,
            accuracy=None if no_fe else accuracy,
            free=free_modes,
            on_step=progress.step,
        )
        dimensions: dict[int, str] = {}
        for number, analysis in run.analyses.items() if written is not None else ():
            progress.step(f"Looking for dimensions of throw {number}")
            dimensions[number] = dimensions_text(analysis, accuracy)
        progress.finish()
    count = len(run.files)
    files = [f"Throws: {throws} ({count} file{'s' * (count > 1)})"] if folder is not None else []
    made = {}
    if written is not None:
        write_user_file(written, engine_text(run, written, dimensions, banks).encode())
        made = {"engine": engine}
        files.append(f"Engine file: {engine}; next: crankfem check {shlex.quote(str(engine))}")
    if out.json:
        print_json(with_units(run) | made)
        return
    *parts, answer = run.parts()
    out.show(parts, *files, answer)


@contextmanager
def _removed_if_empty(folder: str | None) -> Iterator[None]:
    """Remove a folder in the end that nothing has been written into."""
    try:
        yield
    finally:
        if folder is not None:
            with suppress(OSError):  # it has files
                os.rmdir(folder)


def _moved(texts: list[str]) -> dict[int, float]:
    """Return by how much cuts are moved [m], by number."""
    from crankbase.written_quantity import parse_quantity

    moved: dict[int, float] = {}
    for text in texts:
        number, equals, shift = text.partition("=")
        if not (number.strip().isdecimal() and equals):
            raise InputError(
                f"--cut: given {text!r}; allowed is the number of a cut and how far it moves, like "
                '"2=3 mm", because cuts are counted from the free end.'
            )
        if int(number) in moved:
            raise InputError(f"--cut: given twice for cut {int(number)}; give it once.")
        moved[int(number)] = parse_quantity(shift, "m", "--cut")
    return moved
