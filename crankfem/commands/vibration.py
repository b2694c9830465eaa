"""Natural frequencies and critical speeds."""

from crankfem import tables
from crankfem.commands.options import EngineArgument, JsonOption
from crankfem.console import print_json


def vibration(engine: EngineArgument, json: JsonOption = False) -> None:
    """Natural frequencies and critical speeds, without the study."""
    from crankfem.engine_file import load_engine
    from crankfem.results import vibration_record
    from crankfem.vibration.modes import axial_vibration, torsional_vibration
    from crankfem.vibration.sources import compliances_in_shaft
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
