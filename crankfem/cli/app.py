"""The command line: every command with examples, in groups by what it is for."""

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from crankbase.errors import InputError
from crankbase.written_quantity import split_quantity
from crankfem.cli import console
from crankfem.files.satellites import at_place, called, plugs
from crankfem.jobs.exit_codes import EXIT_INPUT, EXIT_INTERRUPTED, MEANINGS

# The base of typer's errors about wrong options and arguments; it has no public name.
USAGE_ERROR: Any = typer.BadParameter.__mro__[2]


# Commands by group, as module of `crankfem.cli.commands` and function, with examples that work in an empty
# folder or on files made before.
COMMANDS: dict[str, dict[str, tuple[str, ...]]] = {
    "Main job": {
        "run:run": ("run 6chn25-34", "run mine.toml --output results --strict"),
        "run:report": ("report mine-results",),
    },
    "Files": {
        "input_files:new": (
            "new mine.toml",
            "new mine.toml --cylinders 12 --v-angle even --drawing throw.svg",
            "new mine.toml --from vw-tdi",
            "new --list",
        ),
        "input_files:check": ("check mine.toml", "check 6chn25-34 --picture throw.svg"),
        "input_files:fields": ("fields throw",),
    },
    "Throw": {
        "throw:throw": (
            'throw 6chn25-34 --gamma "120 deg" --pin-force "100 kN"',
            "throw part.step --pin pin",
            "throw mine.toml --json",
        ),
        "throw:stress": ("stress 6chn25-34 --pictures stresses",),
        "throw:draw": ("draw 6chn25-34", "draw 6chn25-34 --shaft crankshaft.png"),
        "throw:export": ("export 6chn25-34 throw.step", "export 6chn25-34 throw.inp --calculix"),
    },
    "Compliance": {
        "formulas:formulas": (
            'formulas 6chn25-34 --gamma "120 deg"',
            "formulas --all",
            "formulas --published",
        ),
        "doe:plan": ("plan 6chn25-34",),
        "doe:doe": (
            "doe 6chn25-34 --store runs.sqlite --workers 2",
            "doe 6chn25-34 --store runs.sqlite --more 10",
        ),
        "doe:designs": ("designs 6chn25-34 designs --mesh step",),
        "doe:import_": ("import study.toml bench.csv", "import study.toml results.csv --alone"),
        "doe:results": ("results runs.sqlite runs.csv",),
        "doe:verify": ("verify runs.sqlite",),
        "fit:fit": ("fit runs.sqlite --model model.json",),
        "lookup:lookup": (
            "lookup model.json web_width=300mm web_thickness=68mm pin_length=139mm",
            'lookup model.json --throw 6chn25-34 --gamma "120 deg"',
        ),
    },
    "Forces": {
        "mechanism:mechanism": (
            "mechanism 8chn13-14 --pictures loads",
            'mechanism 8chn13-14 --speed "1500 1/min"',
        ),
        "mechanism:harmonics": (
            "harmonics 8chn26-26",
            "harmonics yamz5340_torque_one_throw.csv --orders 4",
        ),
    },
    "Vibration": {
        "vibration:vibration": (
            "vibration 6chn25-34",
            'vibration 6chn25-34 --units "in, lbf, ksi"',
            "vibration mine.toml --strict --csv amplitudes",
            "vibration mwm-six",
        ),
        "mechanism:two_mass": ("two-mass yamz-5340", "two-mass yamz-5340 --order 14.5"),
    },
}


# Group, place and examples of each command of the core.
CORE = {
    called(place): (group, f"crankfem.cli.commands.{place}", examples)
    for group, commands in COMMANDS.items()
    for place, examples in commands.items()
}


@cache
def places() -> dict[str, tuple[str, str, tuple[str, ...]]]:
    """Group, place and examples of each command; those of satellites follow the one they name."""
    every = {}
    for name, of_core in CORE.items():
        every[name] = of_core
        for plug in plugs():
            if plug.after == name:
                every[called(plug.command)] = of_core[0], plug.command, plug.examples
    return every


# What typer says of a wrong option, in words for people.
TYPERS_WORDS = {
    "Input should be a valid integer, unable to parse string as an integer": "allowed is a whole number",
    "Input should be a valid number, unable to parse string as a number": "allowed is a number",
    "extra argument(s)": "extra argument",
}

LOOK: dict[str, Any] = {"pretty_exceptions_enable": False, "rich_markup_mode": "rich"}
EXIT_CODES = "; ".join(f"{code} {words}" for code, words in MEANINGS.items())


class OptionsOnce(TyperCommand):
    """A command that refuses an option of one value given twice, since only the last would count."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line."""
        end = args.index("--") if "--" in args else len(args)
        names = [argument.partition("=")[0] for argument in args[:end]]
        for option in self.params:
            repeats = getattr(option, "multiple", True) or getattr(option, "is_flag", True)
            if not repeats and sum(name in option.opts for name in names) > 1:
                raise InputError(f"{option.opts[0]}: given more than once; give it once.")
        return super().parse_args(ctx, args)


@cache
def _command(name: str) -> Any:
    group, place, examples = (CORE if name in CORE else places())[name]
    # Brackets and the like in examples are text, not markup.
    lines = (f"crankfem {example}".replace("[", r"\[") for example in examples)
    epilog = "Example: " + "\n\n".join(lines)
    alone = typer.Typer(add_completion=False, **LOOK)
    alone.command(name, cls=OptionsOnce, epilog=epilog, rich_help_panel=group)(at_place(place))
    return typer.main.get_command(alone)


class LoadedOnDemand(Mapping[str, Any]):
    """The commands by name: the modules of the others are not loaded for one, but for the help on all."""

    def __getitem__(self, name: str) -> Any:
        """Return a command."""
        return _command(name)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(places())

    def __len__(self) -> int:
        """Count the commands."""
        return len(places())


class Commands(TyperGroup):
    """All commands."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings | {"commands": LoadedOnDemand()})


app = typer.Typer(
    cls=Commands,
    help="Axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.",
    epilog="Begin with: crankfem new mine.toml, then crankfem run mine.toml. Results go to standard output, "
    f"progress and errors to standard error.\n\nExit codes: {EXIT_CODES}.",
    **LOOK,
)


def _version(asked: bool) -> None:
    if asked:
        from crankfem.analyses.provenance import program_version

        console.print_line(f"crankfem {program_version()}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def _crankfem(
    context: typer.Context,
    version: Annotated[  # noqa: ARG001 - its callback answers
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        context.get_help()  # prints it
        raise typer.Exit(EXIT_INPUT)


def main() -> None:
    """Run the command line; errors are one sentence and an exit code."""
    with console.clear_errors():
        try:
            code = app(prog_name="crankfem", standalone_mode=False)
        except typer.Abort:
            raise SystemExit(EXIT_INTERRUPTED) from None
        except USAGE_ERROR as error:
            context = getattr(error, "ctx", None)
            path = "crankfem" if context is None else context.command_path
            sentence = str(error.format_message())
            for typers, ours in TYPERS_WORDS.items():
                sentence = sentence.replace(typers, ours)
            if (apart := split_quantity(sys.argv[1:])) is not None:
                words = " ".join(apart)
                sentence = (
                    f'{words}: given as two words; write number and unit in quotes, "{words}"'
                )
            console.exit_usage_error(sentence, f"{path} --help")
        if code:
            raise SystemExit(code)
