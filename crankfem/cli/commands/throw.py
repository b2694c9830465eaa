"""A throw by finite elements: compliances and fillet stresses."""

import time
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from crankbase.errors import InputError
from crankfem.cli.commands.options import Output, ThrowArgument, ThrowOption, with_output
from crankfem.cli.console import print_json, print_line
from fem.wished_accuracy import COMPLIANCE_ACCURACY, STRESS_ACCURACY

PinsOption = Annotated[
    list[str] | None,
    typer.Option("--pin", help="Name of a crankpin's face in a STEP file; once for each pin."),
]


@with_output(units=True)
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
        str | None,
        typer.Option(
            metavar='"100 kN"',
            help='Force on the first pin: Z towards the shaft, or x, y, z in its frame ("40, -100, 0 kN").',
            show_default="100 kN",
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
    profile: Annotated[
        bool, typer.Option("--profile", help="Print the time of each step.")
    ] = False,
    *,
    out: Output,
) -> None:
    """Analyze one throw by finite elements: compliances, reactions, masses.

    A STEP file is a CAD part of steel: z along the shaft, faces named "left end", "right end" and
    "pin", or none named at all.
    """
    from crankfem.analyses.throw.law_record import law_record, law_sentence
    from crankfem.analyses.throw.throw_record import mode_records, throw_record
    from crankfem.cli.angle_and_speed import parse_gamma
    from crankfem.cli.quantity_list import parse_pin_force
    from crankfem.cli.tables import throw_tables
    from crankfem.cli.throw_choice import select_part
    from crankfem.jobs.run_records import UNIT_RADIAL_FORCE
    from fem.analysis import analyze_throw
    from fem.modes import MOST_MODES
    from fem.symmetry import degree_of
    from geometry.throw import CrankThrow

    angle = None if gamma is None else parse_gamma(gamma, out.quiet)
    force = None if pin_force is None else parse_pin_force(pin_force)
    if not 0 <= modes <= MOST_MODES:
        raise InputError(f"--modes: given {modes}; allowed is 0 to {MOST_MODES}, 0 for none.")
    part, material = select_part(engine, name, pins, out.quiet)
    shared: Any = int(sections) if sections in ("1", "2", "4") else sections
    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)  # before anything is printed
    degree_of(shared)
    law = law_record(part, material) if isinstance(part, CrankThrow) else None
    if law is not None and not out.json:
        print_line(law_sentence(law, out.units))
    analysis = analyze_throw(
        part,
        material,
        accuracy,
        solver=solver,
        end_sections=cast(Any, end_sections),
        sections=shared,
    )
    record = throw_record(analysis, UNIT_RADIAL_FORCE, pin_force=force, gamma_deg=angle)
    if law is not None:
        record["law"] = law
    if modes:
        start = time.perf_counter()
        record["free_modes"] = mode_records(analysis.free_modes(modes))
        record["seconds"]["modes"] = time.perf_counter() - start
    if out.json:
        print_json(record)
        return
    throw_tables.print_throw(record, out.units)
    if modes:
        throw_tables.print_free_modes(record["free_modes"], out.units)
    if profile:
        throw_tables.print_profile(record["seconds"])


@with_output(files=True, units=True)
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
    from crankfem.analyses.throw.stress import stress_record
    from crankfem.cli.tables.throw_tables import print_stresses
    from crankfem.cli.throw_choice import select_part
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import make_output_folder
    from fem.fillet_stress import fillet_stresses
    from fem.loads import radial_directions
    from fem.unit_loads import unit_loads

    part, material = select_part(engine, name, pins, out.quiet)
    if pictures is not None:
        protect(input_path(engine))
        names = [picture_name(load) for load in unit_loads(radial_directions(part))]
        make_output_folder("--pictures", pictures, names)
    stresses = fillet_stresses(
        part, material, accuracy, end_sections=cast(Any, end_sections), mesh=cast(Any, mesh)
    )
    record = stress_record(stresses)
    if pictures is not None:
        from crankfem.analyses.throw.pictures.stress_picture import picture_stresses

        record["pictures"] = [str(file) for file in picture_stresses(stresses, pictures)]
    if out.json:
        print_json(record)
    else:
        print_stresses(record, out.units)
