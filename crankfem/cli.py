"""The command line: every command with an example, in the order of use."""

import typer

from crankfem import console
from crankfem.commands.doe import doe
from crankfem.commands.files import check, fields, new
from crankfem.commands.fit import fit
from crankfem.commands.formulas import formulas
from crankfem.commands.harmonics import harmonics
from crankfem.commands.hinge import hinge
from crankfem.commands.lookup import lookup
from crankfem.commands.mechanism import mechanism
from crankfem.commands.optimum import optimum
from crankfem.commands.run import report, run
from crankfem.commands.shapes import draw, export
from crankfem.commands.throw import stress, throw
from crankfem.commands.vibration import vibration

COMMANDS = (
    (run, "Example: crankfem run data/engines/6chn25-34.toml"),
    (new, "Example: crankfem new mine.toml --from 6chn25-34"),
    (check, "Example: crankfem check mine.toml"),
    (fields, "Example: crankfem fields throw"),
    (export, "Example: crankfem export 6chn25-34 throw.step"),
    (throw, "Example: crankfem throw 6chn25-34 --accuracy 0.005"),
    (stress, "Example: crankfem stress 6chn25-34 --pictures stresses"),
    (draw, "Example: crankfem draw 6chn25-34 --shaft crankshaft.png"),
    (formulas, "Example: crankfem formulas 6chn25-34 --gamma 120"),
    (doe, "Example: crankfem doe 6chn25-34 --store runs.sqlite --workers 2"),
    (fit, "Example: crankfem fit runs.sqlite --model model.json"),
    (
        lookup,
        "Example: crankfem lookup model.json web_width=300mm web_thickness=68mm pin_length=139mm",
    ),
    (
        optimum,
        "Example: crankfem optimum model.json --minimize web_thickness "
        "--limit 'axial_compliance <= 1.2e-9 m/N'",
    ),
    (mechanism, "Example: crankfem mechanism 8chn13-14 --pictures loads"),
    (harmonics, "Example: crankfem harmonics yamz5340_torque_one_throw.csv --orders 4"),
    (vibration, "Example: crankfem vibration 6chn25-34"),
    (hinge, "Example: crankfem hinge crosshead-30-100 --pictures hinge"),
    (report, "Example: crankfem report 6chn25-34-results"),
)

app = typer.Typer(
    help="Axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode="rich",
)
for command, example in COMMANDS:
    app.command(epilog=example)(command)


def main() -> None:
    """Run the command line; errors are one sentence and an exit code."""
    with console.clear_errors():
        app()
