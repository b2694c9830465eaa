"""Harmonics, natural frequencies and critical speeds."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem import console, tables
from crankfem.commands.options import EngineArgument, JsonOption
from crankfem.console import print_json, print_table
from geometry.errors import InputError


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
