"""`crankfem throw` and `shapes`: calculate and draw throws."""

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from crankbase.errors import InputError
from crankbase.input_file import STEP_ENDINGS
from crankfem.cli import console
from crankfem.cli.commands.options import (
    EngineArgument,
    Output,
    ThrowArgument,
    ThrowOption,
    with_output,
)
from crankfem.cli.console import print_json, print_line, print_notes
from fem.wished_accuracy import COMPLIANCE_ACCURACY, STRESS_ACCURACY

if TYPE_CHECKING:
    from crankfem.files.reading.toml_file import TomlFile
    from fem.material import Material
    from geometry.any_throw import Throw


PinsOption = Annotated[
    list[str] | None,
    typer.Option("--pin", help="Name of a crankpin's face in a STEP file; once for each pin."),
]


@with_output(files=True, units=True, source="engine")
def throw(
    engine: ThrowArgument,
    name: ThrowOption = None,
    accuracy: Annotated[
        float, typer.Option(help=f"Relative accuracy of e_n, {COMPLIANCE_ACCURACY}.")
    ] = 0.01,
    gamma: Annotated[
        str | None,
        typer.Option(
            "--gamma",
            "--gamma-deg",
            metavar='"120 deg"',
            help="Angle between neighboring cranks, one more support: between equal throws.",
        ),
    ] = None,
    pin_force: Annotated[
        list[str] | None,
        typer.Option(
            metavar='"100 kN"',
            help='Force on a pin: Z towards the shaft, or x, y, z in the throw\'s frame ("40, -100, 0 kN"); '
            "once for each pin of the throw, the first one first.",
            show_default="100 kN on the first",
        ),
    ] = None,
    pins: PinsOption = None,
    end_sections: Annotated[
        str,
        typer.Option(help="rigid, or averaged (free to warp); the true value is between the two."),
    ] = "rigid",
    sections: Annotated[
        str,
        typer.Option(
            help="How sections between throws move: rigid, or bending (polynomials of degree 1, 2 or 4)."
        ),
    ] = "2",
    solver: Annotated[str, typer.Option(help="pardiso, superlu, or auto.")] = "auto",
    modes: Annotated[
        int, typer.Option(help="Also compute this many natural modes of the free throw.")
    ] = 0,
    slopes: Annotated[
        bool, typer.Option("--slopes", help="Also print how results change with each dimension.")
    ] = False,
    profile: Annotated[
        bool, typer.Option("--profile", help="Print the time of each step.")
    ] = False,
    pictures: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER", help="Draw the forces on the throw and its ends' reactions."
        ),
    ] = None,
    *,
    out: Output,
) -> None:
    """Analyze one throw by finite elements: compliances, reactions, masses.

    A STEP file is a CAD part of steel: z along the shaft, faces named "left end", "right end" and
    "pin", or none named at all.
    """
    from geometry.gmsh_session import shared_process

    shared_process().start()  # which loads gmsh while this process loads the rest

    from fem.first_mesh import begin_mesh
    from fem.solver import check_solver
    from fem.superelement import check_end_sections

    # Before anything is printed.
    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)
    check_solver(solver)
    check_end_sections(end_sections)
    part, material = _select_part(engine, name, pins, out.quiet)
    begin_mesh(part, accuracy)

    from crankfem.analyses.throw.law_record import law_results
    from crankfem.analyses.throw.throw_record import (
        PICTURE,
        UNIT_RADIAL_FORCE,
        free_modes,
        picture_reactions,
        throw_results,
    )
    from crankfem.cli.arguments import parse_gamma, parse_pin_force
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import check_outputs
    from fem.analysis import analyze_throw
    from fem.symmetry import degree_of, radial_directions
    from geometry.throw import CrankThrow

    angle = None if gamma is None else parse_gamma(gamma, out.quiet)
    if modes:
        from fem.modes import MOST_MODES

        if not 0 <= modes <= MOST_MODES:
            raise InputError(f"--modes: given {modes}; allowed is 0 to {MOST_MODES}, 0 for none.")
    texts = pin_force or []
    if len(texts) > len(part.pin_axes):
        raise InputError(
            f"--pin-force: given {len(texts)} times; allowed is once for each crankpin of the throw, here "
            f"{len(part.pin_axes)}, because each is loaded once."
        )
    directions = [(0.0, -1.0, 0.0), *radial_directions(part).tolist()[1:]]
    forces = [parse_pin_force(text, along) for text, along in zip(texts, directions, strict=False)]
    folder = check_outputs(None, pictures, input_path(engine), names=[PICTURE])
    shared: Any = int(sections) if sections in ("1", "2", "4") else sections
    degree_of(shared)  # before anything is printed
    if slopes:
        from fem.sensitivities import check_sloped

        check_sloped(part, end_sections)
    law = law_results(part, material) if isinstance(part, CrankThrow) else None
    if law is not None and not out.json:
        print_line(law.sentence(out.units))
    analysis = analyze_throw(
        part,
        material,
        accuracy,
        solver=solver,
        end_sections=cast(Any, end_sections),
        sections=shared,
    )
    results = replace(
        throw_results(
            analysis,
            UNIT_RADIAL_FORCE,
            pin_force=forces[0] if forces else None,
            further_pin_forces=forces[1:],
            gamma_deg=angle,
            slopes=slopes,
        ),
        law=law,
    )
    if modes:
        start = time.perf_counter()
        free = free_modes(analysis.free_modes(modes))
        seconds = dict(results.seconds) | {"modes": time.perf_counter() - start}
        results = replace(results, free_modes=free, seconds=seconds)
    made = None if folder is None else picture_reactions(results, folder)
    if out.json:
        from crankfem.analyses.record import with_units

        pictures_made = {} if made is None else {"pictures": [str(made)]}
        print_json(with_units(results) | pictures_made)
        return
    files = [] if made is None else [f"Picture: {made}"]
    table = results.loaded_table(out.units)
    out.show(results.parts(out.units, profile=profile), *files, table)


def _select_part(
    engine: str, name: str | None, pins: list[str] | None, quiet: bool
) -> tuple["Throw", "Material"]:
    """Select a throw of a file, or read a CAD part of steel from a STEP file.

    Parameters
    ----------
    engine : str
        File, or the name of a shipped engine.
    name : str, optional
        From `--throw`, for files of dimensions.
    pins : list of str, optional
        Names of the pins' faces, for STEP files.
    quiet : bool
        Whether to omit notes.
    """
    from crankfem.cli.arguments import select_throw

    if Path(engine).suffix.lower() not in STEP_ENDINGS:
        if pins:
            raise InputError(
                f"--pin: given {pins[0]!r}; allowed only with a STEP file, whose faces have names."
            )
        return select_throw(engine, name, quiet)
    if name is not None:
        raise InputError(
            f"--throw: given {name!r} with a STEP file; allowed only with a TOML file, because a part is one "
            "throw."
        )
    from fem.material import STEEL
    from geometry.imported import import_throw

    part = import_throw(engine, pins=pins or ("pin",))
    for remark in part.remarks:
        console.print_note(remark, quiet)
    return part, STEEL


@with_output(files=True, units=True, source="engine")
def stress(
    engine: ThrowArgument,
    name: ThrowOption = None,
    accuracy: Annotated[
        float, typer.Option(help=f"Relative accuracy of the largest stresses, {STRESS_ACCURACY}.")
    ] = 0.05,
    end_sections: Annotated[str, typer.Option(help="rigid, or averaged (free to warp).")] = "rigid",
    pins: PinsOption = None,
    mesh: Annotated[
        str, typer.Option(help="adaptive, or m53: fillets as IACS UR M53, Appendix III, requires.")
    ] = "adaptive",
    pictures: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder for a picture of each load.")
    ] = None,
    *,
    out: Output,
) -> None:
    """Calculate stresses at a throw's fillets under unit loads, and their concentration factors.

    A STEP file is a CAD part of steel, as for `crankfem throw`.
    """
    from crankbase.outputs import protect
    from crankfem.analyses.throw.pictures.stress_picture import picture_name
    from crankfem.analyses.throw.stress import stress_results
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import make_output_folder
    from fem.fillet_peaks import unit_loads
    from fem.fillet_stress import fillet_stresses
    from fem.symmetry import radial_directions

    part, material = _select_part(engine, name, pins, out.quiet)
    if pictures is not None:
        protect(input_path(engine))
        names = [picture_name(load) for load in unit_loads(radial_directions(part))]
        make_output_folder("--pictures", pictures, names)
    stresses = fillet_stresses(
        part, material, accuracy, end_sections=cast(Any, end_sections), mesh=cast(Any, mesh)
    )
    results = stress_results(stresses)
    if pictures is not None:
        from crankfem.analyses.throw.pictures.stress_picture import picture_stresses

        made = tuple(str(file) for file in picture_stresses(stresses, pictures))
        results = replace(results, pictures=made)
    if out.json:
        print_json(results)
    else:
        written = (f"{picture} written." for picture in results.pictures)
        out.show(
            [*results.tables(out.units), *results.sentences()], results.factor_table(), *written
        )


@with_output(files=True, source="engine")
def export(
    engine: EngineArgument,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="File to write; its ending says what: .step .stp (solid), .msh .vtu .inp .med "
            "(mesh), .stl (surface).",
        ),
    ],
    name: ThrowOption = None,
    part: Annotated[str, typer.Option(help="full, half, quarter, or auto.")] = "full",
    size: Annotated[float, typer.Option(help="Scale of the element sizes; 1 is usual.")] = 1.0,
    shaft: Annotated[bool, typer.Option("--shaft", help="The whole crankshaft (STEP).")] = False,
    calculix: Annotated[
        bool,
        typer.Option(
            "--calculix", help="Into .inp write a whole deck: mesh, supports, load cases."
        ),
    ] = False,
    *,
    out: Output,
) -> None:
    """Write the solid of a throw or of the whole crankshaft, or a throw's mesh, for other programs."""
    from crankfem.cli.arguments import select_throw
    from crankfem.files.engine.file_kinds import engine_sections
    from crankfem.files.engine.throw_file import load_crankshaft
    from crankfem.jobs.outputs import check_writable
    from fem.calculix import write_calculix
    from geometry.crankshaft import Crankshaft
    from geometry.mesher import mesh_isolated
    from geometry.solid_files import (
        LISTED_ENDINGS,
        MESH_ENDINGS,
        SURFACE_ENDINGS,
        write_mesh,
        write_step,
    )
    from geometry.throw import CrankThrow

    if name is not None and shaft:
        raise InputError(
            f"--throw: given {name!r} with --shaft; allowed is one of the two, because the whole crankshaft "
            "has all throws."
        )
    content = engine_sections(engine)
    throw, material = select_throw(content, name, out.quiet or shaft, alone=not shaft)
    record: dict[str, Any] = {"file": str(file)}
    if calculix and (file.suffix != ".inp" or part != "full"):
        raise InputError(
            f"--calculix: given {file.name} and --part {part}; allowed is a file ending in .inp with the "
            "whole throw, because the deck holds and loads both ends."
        )
    if shaft or file.suffix.lower() in STEP_ENDINGS:
        if size != 1.0:
            raise InputError(f"--size: given {size:g}; allowed only for meshes, not for solids.")
        check_writable(file, "solid", content.path)
        crankshaft = load_crankshaft(content) if shaft else None
        solid = throw if crankshaft is None else crankshaft
        if not isinstance(solid, CrankThrow | Crankshaft):
            raise InputError(
                f"{file}: given a throw that is in {Path(solid.path).name} already; allowed is --shaft, or "
                "the ending of a mesh."
            )
        write_step(solid, file, part)
        if crankshaft is not None and crankshaft.remarks:
            record["remarks"] = list(crankshaft.remarks)
    else:
        if file.suffix.lower() not in MESH_ENDINGS:
            raise InputError(
                f"{file.name}: given the ending {file.suffix!r}; allowed are {', '.join(STEP_ENDINGS)} "
                f"(solid); and for a mesh {LISTED_ENDINGS}."
            )
        if not 0.05 <= size <= 10.0:
            raise InputError(f"--size: given {size:g}; allowed is 0.05 to 10.")
        check_writable(file, "deck" if calculix else "mesh", content.path)
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
            "units": dict.fromkeys(("nodes", "elements", "surfaces.*"), "1"),
        }
    if out.json:
        print_json(record)
        return
    mesh_text = ""
    if record.get("kind") == "mesh":
        mesh_text = f": {record['nodes']} nodes, {record['elements']} elements"
    console.output.print(f"{file} written{mesh_text}; lengths in m.", soft_wrap=True)
    print_notes(record.get("remarks", ()))


@with_output(files=True, source="engine")
def draw(
    engine: EngineArgument,
    name: ThrowOption = None,
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
    *,
    out: Output,
) -> None:
    """Draw a throw to scale with its dimensions; make pictures of throw and crankshaft."""
    from crankfem.analyses.throw.pictures.drawing import check_drawing_ending, write_drawing
    from crankfem.analyses.throw.pictures.solid_picture import (
        check_picture_ending,
        picture_shaft,
        picture_throw,
    )
    from crankfem.cli.arguments import select_throw
    from crankfem.files.engine.file_kinds import engine_sections
    from crankfem.files.engine.throw_file import load_crankshaft
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import check_distinct_files, check_writable
    from geometry.throw import CrankThrow

    source = input_path(engine)
    of = "throw" if name is None else f"throw-{name}"
    drawing = output or Path(f"{source.stem}-{of}.svg")
    check_drawing_ending(drawing)
    for file in filter(None, (picture, shaft)):
        check_picture_ending(file)
    check_distinct_files({"--output": drawing, "--picture": picture, "--shaft": shaft})
    for file in filter(None, (drawing, picture, shaft)):
        check_writable(file, "picture", source)
    content = engine_sections(engine)
    dimensions, _ = select_throw(content, name, out.quiet, alone=shaft is None)
    crankshaft = load_crankshaft(content) if shaft else None
    title = _title(content) if name is None else f"{_title(content)}, throw {name}"
    files = []
    if isinstance(dimensions, CrankThrow):
        files.append(write_drawing(dimensions, drawing, title))
    elif not (picture or shaft):
        raise InputError(
            "draw: given a throw from a STEP file, without dimensions for a drawing; give --picture or "
            "--shaft, which need none."
        )
    if picture:
        files.append(picture_throw(dimensions, picture))
    if shaft and crankshaft:
        files.append(picture_shaft(crankshaft, shaft))
    remarks = () if crankshaft is None else crankshaft.remarks
    if out.json:
        noted = {"remarks": list(remarks)} if remarks else {}
        print_json({"files": [str(file) for file in files]} | noted)
        return
    for file in files:
        console.output.print(f"{file} written.", soft_wrap=True)
    print_notes(remarks)


def _title(content: "TomlFile") -> str:
    """Return the engine's name, or its file's if it has none."""
    name = content.sections.get("engine", {}).get("name")
    return name if isinstance(name, str) and name.strip() else content.path.stem
