"""The command line: one short function for each command."""

import shutil
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from crankfem import console, tables
from crankfem.console import number, print_json, print_table, rows_of
from crankfem.data_files import engine_path, shipped_engines
from geometry.errors import InputError
from geometry.model import field_extra
from geometry.quantity import DISPLAY_UNITS, parse_quantity

if TYPE_CHECKING:
    from geometry.throw import CrankThrow

app = typer.Typer(
    help="Axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode="rich",
)

EngineArgument = Annotated[
    str, typer.Argument(metavar="ENGINE.toml", help="Engine file, or the name of a shipped engine.")
]
ThrowArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, name of a shipped engine, or a STEP file of a throw.",
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print machine-readable results on standard output.")
]
WorkersOption = Annotated[int, typer.Option(help="Worker processes of the study.")]


@app.command(epilog="Example: crankfem run data/engines/6chn25-34.toml")
def run(
    engine: EngineArgument,
    output: Annotated[
        str | None, typer.Option(help="Folder for the results; NAME-results by default.")
    ] = None,
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Do everything: throw, formulas, study, vibration, and a report, into one folder."""
    from crankfem.pipeline import REPORT, run_engine

    with console.RunProgress() as progress:
        made = run_engine(engine, output, workers=workers, progress=progress)
        progress.finish()
    if json:
        print_json(made.results)
        return
    tables.print_throw(made.results["throw"])
    tables.print_formulas(made.results["formulas"], made.results["throw"])
    if made.results["study"] is not None:
        tables.print_fits(made.results["study"]["fits"])
    for vibration in made.results["vibration"].values():
        tables.print_vibration(vibration)
    console.output.print(f"Report: {made.folder / REPORT}", soft_wrap=True)


@app.command(epilog="Example: crankfem new mine.toml --from 6chn25-34")
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
        f"crankfem run {file}",
        soft_wrap=True,
    )


@app.command(epilog="Example: crankfem check mine.toml")
def check(engine: EngineArgument, json: JsonOption = False) -> None:
    """Check an engine file or a throw's, and list what is assumed in it."""
    from crankfem.engine_file import EngineFile, load_engine_or_throw
    from crankfem.results import input_records

    read = load_engine_or_throw(engine)
    records = input_records(read)
    kind = "engine" if isinstance(read, EngineFile) else "throw"
    assumed = sum(record["assumed"] for record in records)
    if json:
        name = read.engine.name if isinstance(read, EngineFile) else None
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


@app.command(epilog="Example: crankfem fields throw")
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


@app.command(epilog="Example: crankfem export 6chn25-34 throw.step")
def export(
    engine: EngineArgument,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="File to write; its ending says what: .step .stp (solid), .msh .vtu .vtk .inp .med "
            "(mesh), .stl .ply .obj (surface).",
        ),
    ],
    part: Annotated[str, typer.Option(help="full, half, quarter, or auto.")] = "full",
    size: Annotated[float, typer.Option(help="Scale of the element sizes; 1 is usual.")] = 1.0,
    shaft: Annotated[bool, typer.Option("--shaft", help="The whole crankshaft (STEP).")] = False,
    calculix: Annotated[
        bool,
        typer.Option(
            "--calculix", help="Into .inp write a whole deck: mesh, supports, load cases."
        ),
    ] = False,
    json: JsonOption = False,
) -> None:
    """Write the solid of a throw or of the whole crankshaft, or a throw's mesh, for other programs."""
    from crankfem.engine_file import load_crankshaft, load_throw
    from fem.calculix import write_calculix
    from geometry.mesh_files import ENDINGS as MESH_ENDINGS
    from geometry.mesh_files import SOLID_ENDINGS, SURFACE_ENDINGS, write_mesh
    from geometry.mesher import mesh_isolated
    from geometry.solid_files import ENDINGS, write_step

    throw, material = load_throw(engine)
    console.check_folder(file)
    record: dict[str, Any] = {"file": str(file)}
    if calculix and (file.suffix != ".inp" or part != "full"):
        raise InputError(
            f"--calculix: given {file.name} and --part {part}; allowed is a file ending in .inp with the "
            "whole throw, for the deck holds and loads both ends."
        )
    if shaft or file.suffix.lower() in ENDINGS:
        if size != 1.0:
            raise InputError(f"--size: given {size:g}; allowed only for meshes, not for solids.")
        write_step(load_crankshaft(engine) if shaft else throw, file, part)
    else:
        if file.suffix.lower() not in MESH_ENDINGS:
            raise InputError(
                f"{file.name}: given the ending {file.suffix!r}; allowed are {', '.join(ENDINGS)} (solid), "
                f"{', '.join(SOLID_ENDINGS)} (mesh) and {', '.join(SURFACE_ENDINGS)} (surface)."
            )
        if not 0.05 <= size <= 10.0:
            raise InputError(f"--size: given {size:g}; allowed is 0.05 to 10.")
        mesh = mesh_isolated(throw, size, part)
        if calculix:
            write_calculix(mesh, material, file)
        else:
            write_mesh(mesh, file)
        record |= {
            "kind": "surface" if file.suffix.lower() in SURFACE_ENDINGS else "mesh",
            "nodes": len(mesh.points),
            "elements": len(mesh.elements),
            "surfaces": {name: len(facets) for name, facets in mesh.surfaces.items()},
            "attempts": list(mesh.attempts),
        }
    if json:
        print_json(record)
        return
    mesh_text = ""
    if record.get("kind") == "mesh":
        mesh_text = f": {record['nodes']} nodes, {record['elements']} elements"
    console.output.print(f"{file} written{mesh_text}; lengths in m.", soft_wrap=True)


@app.command(epilog="Example: crankfem throw 6chn25-34 --accuracy 0.005")
def throw(
    engine: ThrowArgument,
    accuracy: Annotated[float, typer.Option(help="Relative accuracy of e_n, 0.001 to 0.1.")] = 0.01,
    pins: Annotated[
        list[str] | None,
        typer.Option("--pin", help="Name of a crankpin's face in a STEP file; once for each pin."),
    ] = None,
    end_sections: Annotated[
        str, typer.Option(help="rigid, or averaged (free to warp); the two bound the truth.")
    ] = "rigid",
    solver: Annotated[str, typer.Option(help="pardiso, superlu, or auto.")] = "auto",
    modes: Annotated[
        int, typer.Option(help="Also find so many natural modes of the free throw.")
    ] = 0,
    profile: Annotated[bool, typer.Option("--profile", help="Print where the time goes.")] = False,
    json: JsonOption = False,
) -> None:
    """Analyze one throw by finite elements: compliances, reactions, masses.

    A STEP file is a CAD part of steel: z along the shaft, faces named "left end", "right end" and
    "pin", or none named at all.
    """
    from crankfem.engine_file import load_throw
    from crankfem.pipeline import UNIT_RADIAL_FORCE
    from crankfem.results import mode_records, throw_record
    from fem.analysis import analyze_throw
    from fem.material import STEEL
    from fem.modes import MOST_MODES
    from geometry.imported import import_throw
    from geometry.mesher import Throw
    from geometry.solid_files import ENDINGS

    if not 0 <= modes <= MOST_MODES:
        raise InputError(f"--modes: given {modes}; allowed is 0 to {MOST_MODES}, 0 for none.")
    if Path(engine).suffix.lower() in ENDINGS:
        part: Throw = import_throw(engine, pins=pins or ("pin",))
        for remark in part.remarks:
            console.errors.print(remark, soft_wrap=True, highlight=False)
        material = STEEL
    else:
        if pins:
            raise InputError(
                f"--pin: given {pins[0]!r}; allowed only with a STEP file, whose faces have names."
            )
        part, material = load_throw(engine)
    analysis = analyze_throw(
        part, material, accuracy, solver=solver, end_sections=cast(Any, end_sections)
    )
    record = throw_record(analysis, UNIT_RADIAL_FORCE)
    if modes:
        start = time.perf_counter()
        record["free_modes"] = mode_records(analysis.free_modes(modes))
        record["seconds"]["modes"] = time.perf_counter() - start
    if json:
        print_json(record)
        return
    tables.print_throw(record)
    if modes:
        tables.print_free_modes(record["free_modes"])
    if profile:
        tables.print_profile(record["seconds"])


@app.command(epilog="Example: crankfem stress 6chn25-34 --pictures stresses")
def stress(
    engine: EngineArgument,
    accuracy: Annotated[
        float, typer.Option(help="Relative accuracy of the largest stresses, 0.02 to 0.2.")
    ] = 0.05,
    end_sections: Annotated[str, typer.Option(help="rigid, or averaged (free to warp).")] = "rigid",
    pictures: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder for a picture of each load.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Find the stresses at a throw's fillets under unit loads, and their concentration factors."""
    from crankfem.stress import run_stress

    run_stress(engine, accuracy, end_sections=cast(Any, end_sections), pictures=pictures, json=json)


@app.command(epilog="Example: crankfem draw 6chn25-34 --shaft crankshaft.png")
def draw(
    engine: EngineArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="DRAWING.svg", help="Drawing: svg, png or pdf; NAME-throw.svg by default."
        ),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="THROW.png", help="Picture of the throw's solid.")
    ] = None,
    shaft: Annotated[
        Path | None, typer.Option(metavar="SHAFT.png", help="Picture of the whole crankshaft.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Draw a throw to scale with its dimensions, and picture the solid of throw and crankshaft."""
    from crankfem.engine_file import load_crankshaft, load_throw
    from crankfem.pictures.drawing import check_drawing_ending, write_drawing
    from crankfem.pictures.solid_picture import check_picture_ending, picture_shaft, picture_throw

    name = engine_path(engine).stem
    drawing = output or Path(f"{name}-throw.svg")
    check_drawing_ending(drawing)
    for file in filter(None, (picture, shaft)):
        check_picture_ending(file)
    for file in filter(None, (drawing, picture, shaft)):
        console.check_folder(file)
    dimensions, _ = load_throw(engine)
    crankshaft = load_crankshaft(engine) if shaft else None
    files = [write_drawing(dimensions, drawing, name)]
    if picture:
        files.append(picture_throw(dimensions, picture))
    if shaft and crankshaft:
        files.append(picture_shaft(crankshaft, shaft))
    if json:
        print_json({"files": [str(file) for file in files]})
        return
    for file in files:
        console.output.print(f"{file} written.", soft_wrap=True)


@app.command(epilog="Example: crankfem formulas 6chn25-34 --gamma 120")
def formulas(
    engine: EngineArgument,
    gamma: Annotated[float, typer.Option(help="Angle between neighboring cranks in deg.")] = 180.0,
    variant: Annotated[str, typer.Option(help="corrected, printed or k/4.")] = "corrected",
    fe: Annotated[bool, typer.Option(help="Also compute the finite element value.")] = True,
    json: JsonOption = False,
) -> None:
    """Show the published formulas for a throw beside finite elements."""
    from crankfem.engine_file import load_throw
    from crankfem.results import formula_records
    from fem.analysis import analyze_throw
    from fem.supports import Neighbors

    dimensions, material = load_throw(engine)
    records: dict[str, Any] = dict(formula_records(dimensions, material, gamma, variant))
    records["gamma_deg"] = gamma
    if fe:
        analysis = analyze_throw(dimensions, material)
        records["fe"] = {
            "axial": analysis.axial_compliance(Neighbors(gamma, gamma)),
            "torsional": analysis.torsional_compliance("pinned"),
            "error_estimate": analysis.error_estimate,
        }
    if json:
        print_json(records)
        return
    for kind in ("axial", "torsional"):
        tables.print_formula_table(
            f"{kind.capitalize()} compliance"
            + (f", gamma = {gamma:g} deg" if kind == "axial" else ""),
            records[kind],
            records["fe"][kind] if fe else None,
            f"neighbors at {gamma:g} deg" if kind == "axial" else "pinned",
        )


@app.command(epilog="Example: crankfem doe 6chn25-34 --store runs.sqlite --workers 2")
def doe(
    study: Annotated[
        str, typer.Argument(metavar="STUDY.toml", help="File with the sections throw and study.")
    ],
    store: Annotated[Path, typer.Option(help="SQLite file of results.")] = Path("runs.sqlite"),
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Run a design of experiments, or continue it where it stopped."""
    from crankfem.engine_file import load_study
    from crankfem.results import study_record
    from crankfem.studies import fitted
    from regression.study import run_plan

    plan = load_study(study)
    with console.RunProgress() as progress:
        progress.step("Running the study")
        table = run_plan(plan, store, workers, progress.design)
        progress.finish()
    found = fitted(table)
    record = study_record(found.table, found.fits)
    if json:
        print_json(record)
        return
    console.output.print(
        f"{record['runs']} runs and {record['held_out']} held-out designs in {store}; "
        f"{record['computed_now']} computed now, {len(record['failures'])} failed.",
        soft_wrap=True,
    )
    tables.print_fits(record["fits"])


@app.command(epilog="Example: crankfem fit runs.sqlite --model model.json")
def fit(
    store: Annotated[Path, typer.Argument(metavar="RUNS.sqlite", help="Store of a study.")],
    model: Annotated[Path, typer.Option(help="Model file to write.")] = Path("model.json"),
    study: Annotated[
        str | None, typer.Option(help="First characters of the study's key, if there are several.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Fit equations to a study's results and save the best as a model."""
    from crankfem.results import study_record
    from crankfem.studies import fitted
    from regression.study import read_study

    found = fitted(read_study(store, study))
    found.model.save(model)
    record = study_record(found.table, found.fits)
    if json:
        print_json(record)
        return
    tables.print_fits(record["fits"])
    console.output.print(f"Model: {model}", soft_wrap=True)


@app.command(
    epilog="Example: crankfem lookup model.json web_width=300mm web_thickness=68mm pin_length=139mm"
)
def lookup(
    model: Annotated[Path, typer.Argument(metavar="MODEL.json", help="Model file.")],
    dimensions: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="Dimensions with units.")
    ],
    json: JsonOption = False,
) -> None:
    """Look compliances up in a model, with range check and error."""
    from geometry.throw import CrankThrow
    from regression.compliance_model import ComplianceModel

    loaded = ComplianceModel.load(model)

    def convert(name: str, text: str) -> float:
        info = CrankThrow.model_fields.get(name)
        unit = "m" if info is None else field_extra(info, "unit")
        return parse_quantity(text, unit, name)

    given = console.parse_pairs(dimensions, convert)
    fe_error = loaded.provenance.get("largest_fe_error_estimate")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the answer itself says what lies outside the range
        answers = {name: loaded.lookup(name, **given) for name in loaded.responses}
    if json:
        print_json(
            {
                name: {
                    "value": answer.value,
                    "unit": answer.unit,
                    "support": answer.support,
                    "inside": answer.inside,
                    "remarks": list(answer.remarks),
                    "largest_held_out_error": answer.error,
                    "largest_fe_error_estimate": fe_error,
                    "equation": answer.equation,
                }
                for name, answer in answers.items()
            }
        )
        return
    for name, answer in answers.items():
        shown, size = DISPLAY_UNITS.get(answer.unit, (answer.unit, 1.0))
        digits = number(answer.value / size)
        value = f"{digits}e-9 {answer.unit}" if shown.startswith("1e-9") else f"{digits} {shown}"
        error = "unknown" if answer.error is None else f"{100.0 * answer.error:.2g} %"
        place = "inside the range" if answer.inside else "OUTSIDE the range"
        console.output.print(
            f"{name.replace('_', ' ')}: {value} ({answer.support}), {place}; up to {error} from finite "
            "elements at held-out designs",
            soft_wrap=True,
            highlight=False,
        )
        for remark in answer.remarks:
            console.output.print(f"  {remark}", soft_wrap=True, highlight=False)
    if isinstance(fe_error, float):
        console.output.print(
            f"The finite elements themselves: axial compliance too small by up to about "
            f"{100.0 * fe_error:.2g} %.",
            soft_wrap=True,
            highlight=False,
        )


@app.command(epilog="Example: crankfem harmonics yamz5340_torque_one_throw.csv --orders 4")
def harmonics(
    table: Annotated[str, typer.Argument(metavar="TORQUE.csv", help="Torque over one cycle.")],
    strokes: Annotated[int, typer.Option(help="Strokes per cycle, 2 or 4.")] = 4,
    orders: Annotated[float, typer.Option(help="Highest order printed.")] = 9.0,
    json: JsonOption = False,
) -> None:
    """Split a torque table into harmonics M_k sin(k w t + a_k)."""
    from crankfem.data_files import data_folder
    from crankfem.results import harmonics_record
    from dynamics.torque_table import read_torque_table

    if not orders > 0.0:
        raise InputError(f"--orders: given {orders:g}; allowed is an order above 0.")
    path = Path(table)
    if not path.is_file() and (data_folder() / "tables" / path.name).is_file():
        path = data_folder() / "tables" / path.name
    record = harmonics_record(read_torque_table(path, strokes=strokes).harmonics())
    if json:
        print_json(record)
        return
    console.output.print(
        f"Mean {record['mean']:.2f} N m; {record['samples']} samples resolve orders up to "
        f"{record['highest_order']:g}."
    )
    columns = ("orders", "cosine", "sine", "amplitude", "phase_deg")
    rows = zip(*(record[name] for name in columns), strict=True)
    print_table(
        "Harmonics",
        ["order", "A_k [N m]", "B_k [N m]", "M_k [N m]", "a_k [deg]"],
        [[f"{row[0]:g}", *(f"{v:.2f}" for v in row[1:])] for row in rows if row[0] <= orders],
    )


@app.command(epilog="Example: crankfem vibration 6chn25-34")
def vibration(engine: EngineArgument, json: JsonOption = False) -> None:
    """Natural frequencies and critical speeds, without the study."""
    from crankfem.engine_file import load_engine
    from crankfem.results import vibration_record
    from crankfem.vibration import axial_vibration, compliances_in_shaft, torsional_vibration
    from fem.analysis import analyze_throw

    read = load_engine(engine)
    analysis = analyze_throw(read.throw, read.material)
    shaft = compliances_in_shaft(read, analysis)
    found = [
        vibration_record(calculate(read, analysis, shaft, None))
        for calculate in (axial_vibration, torsional_vibration)
    ]
    if json:
        print_json({record["kind"]: record for record in found})
        return
    for record in found:
        tables.print_vibration(record)


@app.command(epilog="Example: crankfem report 6chn25-34-results")
def report(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of a finished run.")],
    json: JsonOption = False,
) -> None:
    """Write the report of a finished run again, from its results and pictures."""
    import json as json_module

    from jinja2 import TemplateError

    from crankfem.pipeline import REPORT, RESULTS
    from crankfem.report import write_report

    path = folder / RESULTS
    if not path.is_file():
        raise InputError(
            f"{folder}: has no {RESULTS}; give the folder that crankfem run has written."
        )
    try:
        results = json_module.loads(path.read_text(encoding="utf-8"))
        made = write_report(results, folder / "pictures", folder / REPORT)
    except (OSError, ValueError, KeyError, TypeError, TemplateError) as error:
        raise InputError(
            f"{path}: is not what crankfem run writes ({error}); run it again."
        ) from None
    if json:
        print_json({"report": str(made)})
    else:
        console.output.print(f"Report: {made}", soft_wrap=True)


def main() -> None:
    """Run the command line; errors are one sentence and an exit code."""
    with console.clear_errors():
        app()
