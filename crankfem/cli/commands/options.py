"""Arguments and options common to several commands: inputs, outputs and --strict."""

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.outputs import replacing_files
from crankbase.table import OutputUnits, Table, parse_output_units
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.layout import wrapped
from crankfem.files.reading.data_files import each_file_once
from crankfem.jobs.exit_codes import EXIT_LIMITS, EXIT_UNDECIDED

if TYPE_CHECKING:
    from crankfem.analyses.vibration.run import EngineVibration
    from crankfem.files.engine.engine_file import EngineFile


Command = Callable[..., None]


def _set_replacement_rules(command: typer.Context, force: bool) -> bool:
    """Set the rules by which the command writes its files."""
    command.with_resource(replacing_files(force))
    return force


EngineArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, or the name of a shipped engine.",
        autocompletion=completion.engines,
    ),
]
ThrowArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, name of a shipped engine, or a STEP file of a throw.",
        autocompletion=completion.engines_and_parts,
    ),
]
ModelArgument = Annotated[
    Path,
    typer.Argument(
        metavar="MODEL.json", help="Model file.", autocompletion=completion.files(".json")
    ),
]
SavedModelOption = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="MODEL.json",
        help="Use the compliances of this saved model in place of the file's sources.",
        autocompletion=completion.files(".json"),
    ),
]
SpeedOption = Annotated[
    str | None,
    typer.Option(metavar='"1000 1/min"', help="Speed of an engine; its rated speed by default."),
]
GammaOption = Annotated[
    str | None,
    typer.Option(
        "--gamma",
        "--gamma-deg",
        metavar='"120 deg"',
        help="Angle between neighboring cranks; a bare number is in degrees.",
        show_default="180 deg",
    ),
]
JsonOption = Annotated[
    bool,
    typer.Option(
        "--json", help="Print only machine-readable results, in SI units, on standard output."
    ),
]
QuietOption = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", help="Print only errors and warnings of lost data on standard error."
    ),
]
FullOption = Annotated[
    bool, typer.Option("--full", help="Print all tables and remarks, not the main ones alone.")
]
ForceOption = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Also replace files not made by crankfem, except those read here.",
        callback=_set_replacement_rules,
    ),
]
UnitsOption = Annotated[
    str | None,
    typer.Option(
        metavar='"in, lbf, ksi"',
        help="Units of printed results, or imperial. JSON and files stay in SI units.",
        show_default="SI",
    ),
]
StrictOption = Annotated[
    bool,
    typer.Option(
        "--strict",
        help="Exit with code 4 if limits are exceeded, 5 if that depends on assumed values, 2 if nothing "
        "can be judged.",
    ),
]
ThrowOption = Annotated[
    str | None,
    typer.Option(
        "--throw",
        metavar="NAME",
        help="Which of several throws (sections throws.NAME); by default the one at the free end.",
        show_default=False,
    ),
]
WorkersOption = Annotated[int, typer.Option(help="Worker processes of the study.")]


@dataclass(frozen=True)
class Output:
    """Output of a command: units, JSON, notes, replacing of files, all tables or the main ones."""

    units: OutputUnits
    json: bool
    quiet: bool
    force: bool
    full: bool

    def show(self, parts: Iterable[Table | str], *answers: Table | str) -> None:
        """Print tables and paragraphs, then the answers."""
        console.print_parts(parts, self.units, answers, full=self.full)


def with_output(
    *, units: bool = False, files: bool = False, tables: bool = False, source: str = ""
) -> Callable[[Command], Command]:
    """Add --json and --quiet to a command behind its own options; it gets all of them as `out`.

    Parameters
    ----------
    units : bool
        Whether it prints quantities, and so has --units and --full.
    files : bool
        Whether it writes files, and so has --force.
    tables : bool
        Whether it prints many results without quantities, and so has --full.
    source : str, optional
        Arguments, between spaces, that are files of sections; what is not used of them is named.
    """
    options: dict[str, tuple[object, object]] = {
        "force": (ForceOption, False),
        "units": (UnitsOption, None),
        "full": (FullOption, False),
        "json": (JsonOption, False),
        "quiet": (QuietOption, False),
    }
    left_out = {"force": not files, "units": not units, "full": not (units or tables)}
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in options.items()
        if not left_out.get(name)
    ]

    def decorate(command: Command) -> Command:
        @wraps(command)
        def printing(
            *,
            force: bool = False,
            units: str | None = None,
            full: bool = False,
            json: bool,
            quiet: bool,
            **arguments: Any,
        ) -> None:
            console.output.printed = console.errors.printed = 0
            output = Output(parse_output_units(units), json, quiet, force, full)
            console.errors.units = output.units
            with each_file_once():
                note = _name_not_used(command.__name__, source.split(), arguments, output)
                # Its lines are those of the first screen too.
                console.errors.printed = len(wrapped(note, console.errors.width)) if note else 0
                try:
                    command(**arguments, out=output)
                except SystemExit as verdict:
                    if note and verdict.code in (EXIT_LIMITS, EXIT_UNDECIDED):
                        console.print_note(note)
                    raise
                finally:
                    console.output.not_used = None
            if note:
                console.print_note(note)

        signature = inspect.signature(command)
        parameters = [
            parameter for name, parameter in signature.parameters.items() if name != "out"
        ]
        printing.__annotations__ = {
            parameter.name: parameter.annotation for parameter in [*parameters, *added]
        }
        printing.__signature__ = signature.replace(parameters=[*parameters, *added])  # type: ignore[attr-defined]
        return printing

    return decorate


# Names of what is not used that a note has.
MOST_NAMES = 6


def _name_not_used(
    name: str, sources: Iterable[str], arguments: dict[str, Any], out: Output
) -> str:
    """Keep for JSON what a command does not use of its files; return the note about it, or nothing."""
    files = [
        file
        for source in sources
        for file in (
            (arguments[source],) if isinstance(arguments[source], str) else arguments[source] or ()
        )
    ]
    if not files:
        return ""
    from crankfem.files.engine.used_values import command_use, not_used_of

    unused = {file: not_used_of(file, command_use(name, arguments)) for file in files}
    read = {file: names for file, names in unused.items() if names is not None}
    if not read:
        return ""
    names = list(dict.fromkeys(chain.from_iterable(read.values())))
    console.output.not_used = names
    if not names or out.json or out.quiet:
        return ""
    words = [name if "." in name else f"[{name}]" for name in names]
    shown = words if out.full else words[:MOST_NAMES]
    more = f" and {len(words) - len(shown)} more (--json)" if len(shown) < len(words) else ""
    return f"Note: not used of {', '.join(read)}: {', '.join(shown)}{more}."


NOT_ACCEPTABLE, UNDECIDED = "not acceptable", "undecided"


def check_has_limits(engine: "EngineFile") -> None:
    """Refuse an engine without limits, which --strict cannot judge, before anything is computed for it."""
    if engine.gas is None and engine.gas_map is None:
        raise InputError(
            "--strict: given for an engine file without gas pressure; allowed is one with a section [gas] "
            "or [gas_map], because nothing can be judged otherwise."
        )


def exit_unless_acceptable(run: "EngineVibration") -> None:
    """Exit with a code of its own unless the verdict is acceptable, after all has been written and printed.

    Parameters
    ----------
    run : EngineVibration
        Of an engine that `check_has_limits` has let pass.

    Raises
    ------
    SystemExit
        With code 4 if the verdict is "not acceptable" for all assumptions, with 5 if it is undecided.
    """
    assert run.assessment is not None
    codes = {UNDECIDED: EXIT_UNDECIDED, NOT_ACCEPTABLE: EXIT_LIMITS}
    if code := codes.get(run.assessment.decision.status):
        console.exit_by_verdict(run.assessment.conclusions[0], code)
