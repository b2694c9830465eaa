"""The command line: every command with examples, in groups by what it is for."""

import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from crankbase.errors import InputError
from crankbase.quantity import split_quantity
from crankfem.cli import console
from crankfem.cli.commands.doe import designs, doe, import_, plan, results, verify
from crankfem.cli.commands.fit import fit
from crankfem.cli.commands.formulas import formulas
from crankfem.cli.commands.hinge import hinge
from crankfem.cli.commands.input_files import check, fields, new
from crankfem.cli.commands.lookup import lookup, optimum
from crankfem.cli.commands.mechanism import harmonics, mechanism, two_mass
from crankfem.cli.commands.run import class_, report, run
from crankfem.cli.commands.serve import serve
from crankfem.cli.commands.throw import draw, export, stress, throw
from crankfem.cli.commands.vibration import vibration
from crankfem.jobs.exit_codes import EXIT_INPUT, EXIT_INTERRUPTED, MEANINGS

# The base of typer's errors about wrong options and arguments; it has no public name.
USAGE_ERROR: Any = typer.BadParameter.__mro__[2]


# Commands by group, with examples that work in an empty folder or on files made before.
COMMANDS: dict[str, dict[Callable[..., Any], tuple[str, ...]]] = {
    "Main job": {
        run: ("run 6chn25-34", "run mine.toml --output results --strict"),
        report: ("report mine-results",),
        serve: ("serve", "serve --models models --port 8000"),
    },
    "Files": {
        new: (
            "new mine.toml",
            "new mine.toml --cylinders 12 --v-angle even --drawing throw.svg",
            "new mine.toml --from vw-tdi",
            "new --list",
        ),
        check: ("check mine.toml", "check 6chn25-34 --picture throw.svg"),
        fields: ("fields throw",),
    },
    "Throw": {
        throw: (
            'throw 6chn25-34 --gamma "120 deg" --pin-force "100 kN"',
            "throw part.step --pin pin",
            "throw mine.toml --json",
        ),
        stress: ("stress 6chn25-34 --pictures stresses",),
        draw: ("draw 6chn25-34", "draw 6chn25-34 --shaft crankshaft.png"),
        export: ("export 6chn25-34 throw.step", "export 6chn25-34 throw.inp --calculix"),
    },
    "Compliance": {
        formulas: (
            'formulas 6chn25-34 --gamma "120 deg"',
            "formulas --all",
            "formulas --published",
        ),
        plan: ("plan 6chn25-34",),
        doe: (
            "doe 6chn25-34 --store runs.sqlite --workers 2",
            "doe 6chn25-34 --store runs.sqlite --more 10",
        ),
        designs: ("designs 6chn25-34 designs --mesh step",),
        import_: ("import study.toml bench.csv", "import study.toml results.csv --alone"),
        results: ("results runs.sqlite runs.csv",),
        verify: ("verify runs.sqlite",),
        fit: ("fit runs.sqlite --model model.json",),
        lookup: (
            "lookup model.json web_width=300mm web_thickness=68mm pin_length=139mm",
            'lookup model.json --throw 6chn25-34 --gamma "120 deg"',
        ),
        optimum: (
            "optimum model.json --minimize web_thickness --limit 'axial_compliance <= 1.2e-9 m/N'",
        ),
    },
    "Forces": {
        mechanism: (
            "mechanism 8chn13-14 --pictures loads",
            'mechanism 8chn13-14 --speed "1500 1/min"',
        ),
        harmonics: ("harmonics 8chn26-26", "harmonics yamz5340_torque_one_throw.csv --orders 4"),
        hinge: ("hinge crosshead-30-100 --pictures hinge",),
    },
    "Vibration": {
        vibration: (
            "vibration 6chn25-34",
            'vibration 6chn25-34 --units "in, lbf, ksi"',
            "vibration mine.toml --strict --csv amplitudes",
            "vibration mwm-six",
        ),
        class_: ("class 5rt-flex50d --output submission",),
        two_mass: ("two-mass yamz-5340", "two-mass yamz-5340 --order 14.5"),
    },
}

# What typer says of a wrong option, in words for people.
TYPERS_WORDS = {
    "Input should be a valid integer, unable to parse string as an integer": "allowed is a whole number",
    "Input should be a valid number, unable to parse string as a number": "allowed is a number",
    "extra argument(s)": "extra argument",
}

EXIT_CODES = "; ".join(f"{code} {words}" for code, words in MEANINGS.items())

app = typer.Typer(
    help="Axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.",
    epilog="Begin with: crankfem new mine.toml, then crankfem run mine.toml. Results go to standard output, "
    f"progress and errors to standard error.\n\nExit codes: {EXIT_CODES}.",
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
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


for group, commands in COMMANDS.items():
    for command, examples in commands.items():
        # One command has the name of what Python keeps for itself.
        called = command.__name__.strip("_").replace("_", "-")
        # Brackets and the like in examples are text, not markup.
        lines = (f"crankfem {example}".replace("[", r"\[") for example in examples)
        epilog = "Example: " + "\n\n".join(lines)
        app.command(called, cls=OptionsOnce, epilog=epilog, rich_help_panel=group)(command)


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
