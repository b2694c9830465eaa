"""An engine's crank mechanism: its forces, torque and balance, harmonics, and rods of two masses."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import EngineArgument, Output, SpeedOption, with_output
from crankfem.cli.console import print_json
from dynamics.engine import ROD_MODELS, RodModelName

if TYPE_CHECKING:
    from crankbase.array_checks import Array
    from crankfem.analyses.mechanism.torque_harmonics import EngineHarmonics, TableHarmonics
    from dynamics.harmonics import Harmonics
    from dynamics.sample_tables import TableReading


ROD_MODELS_FILE = "rod_models.svg"


@with_output(files=True, units=True, source="engine")
def mechanism(
    engine: EngineArgument,
    speed: SpeedOption = None,
    model: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODEL",
            help=f"Model of the rods' masses, one of: {', '.join(ROD_MODELS)}; give it twice to compare the "
            "crankpin loads.",
            show_default="rigid",
        ),
    ] = None,
    motored: Annotated[
        bool, typer.Option("--motored", help="Motor the engine without combustion.")
    ] = False,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write all forces over the cycle.")
    ] = None,
    pictures: Annotated[
        str | None, typer.Option(metavar="FOLDER", help="Write load diagrams and hodographs.")
    ] = None,
    *,
    out: Output,
) -> None:
    """Calculate forces in the crank mechanism, bearing loads, and the balance of the engine."""
    from crankfem.analyses.engine_mechanism import engine_inputs, input_warnings
    from crankfem.analyses.mechanism.mechanism_results import force_columns, mechanism_details
    from crankfem.analyses.mechanism.mechanism_run import run_mechanism
    from crankfem.analyses.mechanism.plots import ENGINE_FILES, plot_engine, plot_model_difference
    from crankfem.analyses.titles import at_speed
    from crankfem.cli.arguments import parse_speed
    from crankfem.cli.console import write_columns
    from crankfem.files.engine.engine_file import load_mechanism
    from crankfem.jobs.outputs import check_outputs
    from crankfem.report.interactive.mechanism import MECHANISM

    loaded, turning = load_mechanism(engine), parse_speed(speed)
    # One model, or two to be compared.
    models = cast(list[RodModelName], model or ["rigid"])
    for name in models:
        check_choice("--model", name, ROD_MODELS, "these are the models of a rod's mass")
    if len(models) > 2 or len(set(models)) < len(models):
        raise InputError(
            f"--model: given {', '.join(models)}; allowed are one model or two different ones, because one "
            "is compared with the other."
        )
    inputs = [file.path for file in engine_inputs(loaded)]
    names = [*MECHANISM.files(), *ENGINE_FILES, *([ROD_MODELS_FILE] if len(models) == 2 else [])]
    folder = check_outputs(csv, pictures, *inputs, names=names)
    console.print_warnings(input_warnings(loaded), out.units)
    run = run_mechanism(loaded, turning, models[0], motored=motored)
    details = mechanism_details(run, *models[1:], rods_shown=bool(model))
    compared = details.model_difference
    if csv is not None:
        write_columns(csv, *force_columns(run, compared))
    made, title = [], at_speed(loaded.engine.name, run.speed)
    if folder is not None:
        made = [*MECHANISM.draw(folder, run), *plot_engine(folder, run, title=title)]
    if folder is not None and compared is not None:
        title = f"{compared.crankpin}, {title}"
        plot_model_difference(folder / ROD_MODELS_FILE, compared, title=title)
        made.append(folder / ROD_MODELS_FILE)
    if out.json:
        print_json(replace(details, pictures=tuple(map(str, made))))
        return
    files = [f"Forces: {csv}"] if csv is not None else []
    files += [f"Pictures: {pictures} ({len(made)} files)"] if made else []
    out.show(details.parts(out.units), *files, details.results.answer(out.units))


USUAL_ENGINE_ORDERS = 12.0


@dataclass(frozen=True)
class _Request:
    """The options of the command line."""

    strokes: int | None
    orders: float | None
    cylinder: int | None
    speed: str | None
    firing: tuple[str | None, str | None]
    reading: "TableReading"
    csv: Path | None
    pictures: str | None
    sums: Path | None


@with_output(files=True, units=True, source="source")
def harmonics(
    source: Annotated[
        str,
        typer.Argument(
            metavar="TORQUE.csv|ENGINE.toml",
            help="Torque over a cycle (CSV, .xlsx); or an engine file or the name of a shipped engine.",
            autocompletion=completion.engines_and_tables,
        ),
    ],
    strokes: Annotated[
        int | None, typer.Option(help="Strokes per cycle of a torque table, 2 or 4 (4 by default).")
    ] = None,
    orders: Annotated[
        float | None,
        typer.Option(help="Highest order; 9 by default for a torque table, 12 for an engine."),
    ] = None,
    cylinder: Annotated[
        int | None,
        typer.Option(help="Also the harmonics of this cylinder's forces on its crankpin."),
    ] = None,
    speed: SpeedOption = None,
    firing_order: Annotated[
        str | None,
        typer.Option(
            metavar="1-3-4-2",
            help="With a torque table: firing order of the cylinders with this torque, at even intervals.",
        ),
    ] = None,
    firing_angles: Annotated[
        str | None,
        typer.Option(
            metavar='"0, 540, 180, 360 deg"',
            help="With a torque table: shaft angle at which each cylinder fires.",
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar='"crank_angle_deg=1, torque_Nm=M1"',
            help="Columns of a table that does not say them, by number or heading.",
        ),
    ] = None,
    sheet: Annotated[str | None, typer.Option(help="Sheet of a spreadsheet with several.")] = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write the harmonics as a table.")
    ] = None,
    sums: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Write the samples y of the torque with y cos kx and y sin kx, and their sums.",
        ),
    ] = None,
    pictures: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Write torque, harmonics and star diagrams as SVG."),
    ] = None,
    *,
    out: Output,
) -> None:
    """Split torque into harmonics M_k sin(k w t + a_k), for a table or an engine with its stars."""
    from crankfem.analyses.mechanism.torque_harmonics import COLUMNS
    from crankfem.jobs.outputs import write_rows
    from dynamics.sample_tables import TableReading

    if orders is not None and not orders > 0.0:
        raise InputError(
            f"--orders: given {orders:g}; allowed is an order above 0, because "
            "orders count cycles per crankshaft revolution."
        )
    firing = (firing_order, firing_angles)
    named: dict[str, int | str] = {}
    for part in columns.split(",") if columns is not None else ():
        name, sign, column = (word.strip() for word in part.partition("="))
        if not sign or not column:
            raise InputError(
                f"--columns: given {columns!r}; allowed are names with the number or heading of their "
                'column, such as "crank_angle_deg=1, torque_Nm=M1".'
            )
        named[name] = int(column) if column.isdecimal() else column
    reading = TableReading(columns=named if columns is not None else None, sheet=sheet or "")
    asked = _Request(strokes, orders, cylinder, speed, firing, reading, csv, pictures, sums)
    split = _engine_harmonics if _names_engine(source) else _torque_table_harmonics
    spectra = split(source, asked)
    if csv is not None:
        heading, rows = spectra.rows()
        write_rows(csv, ["of", "unit", *COLUMNS], rows, heading)
    if out.json:
        print_json(spectra)
        return
    *parts, answer = spectra.parts(out.units)
    files = ((csv, "Table"), (sums, "Sums"), (pictures, "Pictures"))
    out.show(parts, *(f"{kind}: {path}" for path, kind in files if path is not None), answer)


def _names_engine(source: str) -> bool:
    """Distinguish an engine from a torque table: by the file's ending, or the name of a shipped engine."""
    from crankfem.files.reading.data_files import shipped_names

    path = Path(source)
    if path.suffix.lower() in (".toml", ".csv"):
        return path.suffix.lower() == ".toml"
    return not path.is_file() or (path.name in shipped_names("engine") and path.parent == Path())


def _torque_table_harmonics(source: str, asked: _Request) -> "TableHarmonics":
    from crankfem.analyses.mechanism.plots import picture_torque_table, table_files
    from crankfem.analyses.mechanism.torque_harmonics import table_harmonics
    from crankfem.cli.arguments import firing_angles_deg
    from crankfem.files.reading.data_files import torque_path
    from crankfem.jobs.outputs import check_outputs
    from dynamics.harmonics import read_torque_table

    for name, value, lacks in (
        ("cylinder", asked.cylinder, "cylinders"),
        ("speed", asked.speed, "speed"),
    ):
        if value is not None:
            raise InputError(
                f"--{name}: given {value} with a torque table; allowed is an engine file, because a table "
                f"has no {lacks}."
            )
    path = torque_path(source)
    table = read_torque_table(
        path, strokes=4 if asked.strokes is None else asked.strokes, reading=asked.reading
    )
    firing = firing_angles_deg(*asked.firing, strokes=table.strokes)
    _check_resolved(asked.orders, table.harmonics())
    spectra, drawn = table_harmonics(path.name, table, asked.orders, firing)
    stars = spectra.cylinders.stars if spectra.cylinders is not None else ()
    folder = check_outputs(asked.csv, asked.pictures, path, names=table_files(stars))
    _write_sums(asked, path, table.crank_angle_deg, table.torque, drawn)
    if folder is not None:
        picture_torque_table(folder, table, drawn, stars)
    return spectra


def _engine_harmonics(source: str, asked: _Request) -> "EngineHarmonics":
    from crankfem.analyses import titles
    from crankfem.analyses.engine_mechanism import engine_inputs, full_load_only, pressures_at
    from crankfem.analyses.mechanism.plots import FILES, picture_torque
    from crankfem.analyses.mechanism.torque_harmonics import engine_harmonics
    from crankfem.cli.arguments import parse_speed
    from crankfem.files.engine.engine_file import load_mechanism
    from crankfem.jobs.outputs import check_outputs
    from dynamics.torque import engine_torque, pin_force_harmonics

    engine_file = load_mechanism(source)
    engine, strokes, cylinder = engine_file.layout, asked.strokes, asked.cylinder
    of_tables = {
        **dict(zip(("--firing-order", "--firing-angles"), asked.firing, strict=True)),
        "--columns": asked.reading.columns,
        "--sheet": asked.reading.sheet or None,
    }
    for option, value in of_tables.items():
        if value is not None:
            raise InputError(
                f"{option}: given {value!r} with an engine file; allowed is a torque table, because the "
                "engine file defines when its cylinders fire, and its tables."
            )
    turning = parse_speed(asked.speed)
    speed = engine_file.engine.rated_speed if turning is None else turning
    if strokes is not None and strokes != engine.strokes:
        raise InputError(
            f"--strokes: given {strokes}; allowed is {engine.strokes} or nothing, because the engine file "
            "defines it."
        )
    if cylinder is not None and not 1 <= cylinder <= len(engine.cylinders):
        raise InputError(
            f"--cylinder: given {cylinder}; allowed is 1 to {len(engine.cylinders)}, because the "
            "engine has that many."
        )
    inputs = [file.path for file in engine_inputs(engine_file)]
    folder = check_outputs(asked.csv, asked.pictures, *inputs, names=FILES)
    pressure = engine_file.pressure or None
    if not full_load_only(engine_file):
        pressure = pressures_at(engine_file, [speed])[0]
    torque = engine_torque(engine, speed, pressure, throws=engine_file.throws)
    _check_resolved(asked.orders, torque.harmonics())
    highest = USUAL_ENGINE_ORDERS if asked.orders is None else asked.orders
    spectrum = torque.harmonics().up_to(highest)
    _write_sums(asked, engine_file.path, torque.shaft_angles_deg, torque.total, spectrum)
    forces = (
        None
        if cylinder is None
        else pin_force_harmonics(engine, speed, pressure, highest_order=highest)[cylinder - 1]
    )
    if folder is not None:
        picture_torque(
            folder, torque, highest, title=titles.at_speed(engine_file.engine.name, speed)
        )
    return engine_harmonics(engine_file, torque, highest, forces)


def _write_sums(
    asked: _Request, source: Path, degrees: "Array", torque: "Array", shown: "Harmonics"
) -> None:
    """Write the auxiliary table of the harmonics shown, if it is asked for."""
    from crankfem.analyses.mechanism.torque_harmonics import finite_sums
    from crankfem.jobs.outputs import check_distinct_files, check_writable, write_rows

    if asked.sums is None:
        return
    check_distinct_files({"--csv": asked.csv, "--sums": asked.sums})
    check_writable(asked.sums, "table", source, name=f"--sums {asked.sums}")
    names, *rows = finite_sums(degrees, torque, shown.strokes, float(shown.orders[-1]))
    write_rows(asked.sums, list(map(str, names)), rows)


def _check_resolved(orders: float | None, harmonics: "Harmonics") -> None:
    if orders is None:
        return
    if orders < harmonics.orders[0]:
        raise InputError(
            f"--orders: given {orders:g}; allowed is {harmonics.orders[0]:g} or more, because that is the "
            "lowest order of the cycle."
        )
    if orders > harmonics.highest_order * (1.0 + 1e-9):
        raise InputError(
            f"--orders: given {orders:g}; allowed is {harmonics.highest_order:g} or less, because "
            f"{harmonics.samples} samples over one cycle resolve no higher order."
        )


MOST_ORDER = 48.0


@with_output(units=True, source="engine")
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
    from crankfem.analyses.mechanism.two_masses import read_two_masses, run_two_masses
    from crankfem.files.engine.file_kinds import any_sections

    if order is not None and not 0.0 < order <= MOST_ORDER:
        raise InputError(
            f"--order: given {order:g}; allowed is an order above 0 up to {MOST_ORDER:g}, because orders "
            "count cycles per crankshaft revolution."
        )
    content = any_sections(engine)
    if content is None:
        raise InputError(f"{engine}: is no TOML file; allowed is an engine file.")
    run = run_two_masses(read_two_masses(content), order)
    if out.json:
        print_json(run)
    else:
        *parts, answer = run.parts(out.units)
        out.show(parts, answer)
