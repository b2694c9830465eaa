"""A throw as drawing, picture, solid or mesh."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands.options import EngineArgument, Output, ThrowOption, with_output
from crankfem.cli.console import print_json

if TYPE_CHECKING:
    from crankfem.files.reading.toml_file import TomlFile


@with_output(files=True)
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
    from crankfem.cli.throw_choice import select_throw
    from crankfem.files.engine.file_kinds import engine_sections
    from crankfem.files.engine.throw_file import load_crankshaft
    from crankfem.jobs.outputs import check_writable
    from fem.calculix import write_calculix
    from geometry.mesher import mesh_isolated
    from geometry.solid_files import (
        MESH_ENDINGS,
        SOLID_ENDINGS,
        STEP_ENDINGS,
        SURFACE_ENDINGS,
        write_mesh,
        write_step,
    )

    if name is not None and shaft:
        raise InputError(
            f"--throw: given {name!r} with --shaft; allowed is one of the two, because the whole crankshaft "
            "has all throws."
        )
    content = engine_sections(engine)
    throw, material = select_throw(content, name, out.quiet or shaft)
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
        write_step(load_crankshaft(content) if shaft else throw, file, part)
    else:
        if file.suffix.lower() not in MESH_ENDINGS:
            raise InputError(
                f"{file.name}: given the ending {file.suffix!r}; allowed are {', '.join(STEP_ENDINGS)} "
                f"(solid), {', '.join(SOLID_ENDINGS)} (mesh) and {', '.join(SURFACE_ENDINGS)} (surface)."
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
        }
    if out.json:
        print_json(record)
        return
    mesh_text = ""
    if record.get("kind") == "mesh":
        mesh_text = f": {record['nodes']} nodes, {record['elements']} elements"
    console.output.print(f"{file} written{mesh_text}; lengths in m.", soft_wrap=True)


@with_output(files=True)
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
    from crankfem.cli.throw_choice import select_throw
    from crankfem.files.engine.file_kinds import engine_sections
    from crankfem.files.engine.throw_file import load_crankshaft
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import check_distinct_files, check_writable

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
    dimensions, _ = select_throw(content, name, out.quiet)
    crankshaft = load_crankshaft(content) if shaft else None
    title = _title(content) if name is None else f"{_title(content)}, throw {name}"
    files = [write_drawing(dimensions, drawing, title)]
    if picture:
        files.append(picture_throw(dimensions, picture))
    if shaft and crankshaft:
        files.append(picture_shaft(crankshaft, shaft))
    if out.json:
        print_json({"files": [str(file) for file in files]})
        return
    for file in files:
        console.output.print(f"{file} written.", soft_wrap=True)


def _title(content: "TomlFile") -> str:
    """Return the engine's name, or its file's if it has none."""
    name = content.sections.get("engine", {}).get("name")
    return name if isinstance(name, str) and name.strip() else content.path.stem
