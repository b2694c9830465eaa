"""Stresses at a throw's fillets and oil holes as plain numbers, and the tables made from them."""

from crankbase.tables.output_units import SI, OutputUnit, OutputUnits
from crankbase.tables.table import Column, Table
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.throw_record import given_dimensions
from fem.fillet_peaks import FilletPeak, FilletStresses, OilHolePeak

# Stresses are printed for loads of 1 kN and 1 kN m, or of so many of the user's own units.
LOAD = 1000.0


def stress_record(stresses: FilletStresses) -> Record:
    """Plain content of the stresses at a throw's fillets and oil holes, in SI units."""
    mesh = stresses.loaded.mesh
    return {
        "dimensions": given_dimensions(stresses.throw),
        "material": stresses.loaded.material.model_dump(),
        "support": "pinned",
        "end_sections": stresses.loaded.end_sections,
        "loads": [
            {
                "load": load.name,
                "kind": load.kind,
                "unit": load.unit,
                "stress_unit": f"Pa/({load.unit})" if " " in load.unit else f"Pa/{load.unit}",
                "fillets": [
                    {"fillet": peak.name, "radius": peak.fillet.radius, **_peak_record(peak)}
                    for peak in stresses.under(load)
                ],
                "oil_holes": [
                    {
                        "exit": peak.name,
                        "diameter": 2.0 * peak.outlet.drilling.radius,
                        "exit_radius": peak.outlet.drilling.exit_radius,
                        **_peak_record(peak),
                    }
                    for peak in stresses.at_oil_holes(load)
                ],
            }
            for load in stresses.loaded.loads
        ],
        **attributes(stresses, "sharp_corners", "error_estimate", "accuracy", "accuracy_met"),
        "elements_across_fillets": stresses.fineness,
        "mesh": stresses.mesh,
        "meshings": [
            attributes(found, "fillet", "size", "size_share", "layers", "across_web", "met")
            for found in stresses.meshings
        ],
        "rule_met": stresses.rule_met,
        "unknowns": mesh.unknowns,
        "solved_part": mesh.part,
        "mended_elements": mesh.mended_elements,
        "meshing_attempts": list(mesh.attempts),
        "solver": stresses.loaded.solver,
        "pictures": [],
    }


def _peak_record(peak: FilletPeak | OilHolePeak) -> Record:
    return {
        **attributes(
            peak,
            *("principal", "principal_place", "principals", "von_mises", "von_mises_place"),
            *("shear", "shear_place", "nominal", "factor", "von_mises_factor", "shear_factor"),
            *("rule_factor", "error_estimate"),
        ),
        "quality": attributes(peak.quality, "normal_share", "spread", "met"),
    }


def stress_tables(record: Record, units: OutputUnits = SI) -> list[Table]:
    """Return a table of the largest stresses for each load; of a symmetric throw the left half."""
    length = units.of("mm")
    tables = []
    for load in record["loads"]:
        fillets, holes = load["fillets"], load.get("oil_holes", [])
        shown = fillets[: len(fillets) // 2] if mirrored(record) else fillets
        stress = _stress_per_load(load["unit"], units)
        by_rule = any(peak.get("rule_factor") is not None for peak in (*shown, *holes))
        tables.append(
            Table(
                f"{load['load'].capitalize()}: largest stresses at fillets"
                f"{' and exits of oil holes' if holes else ''} [{stress.name}]",
                [
                    Column("fillet or exit" if holes else "fillet", words=True),
                    *(
                        Column(name, stress, bare=True)
                        for name in ("principal", "Mises", "nominal")
                    ),
                    Column("factor", decimals=2),
                    *([Column("M53", decimals=2)] if by_rule else []),
                    Column("principal at x y z", length),
                ],
                [
                    [
                        (peak.get("fillet") or peak["exit"]).replace("main journal", "journal"),
                        *(peak[name] for name in ("principal", "von_mises", "nominal", "factor")),
                        *([peak.get("rule_factor")] if by_rule else []),
                        _place(peak["principal_place"], length),
                    ]
                    for peak in (*shown, *holes)
                ],
            )
        )
    return tables


def mirrored(record: Record) -> bool:
    """Return whether the left half of a throw, symmetric about its middle, is sufficient."""
    return bool(record["solved_part"] == "quarter")


def _stress_per_load(unit: str, units: OutputUnits) -> OutputUnit:
    """Return the unit of a stress per load of "N" or "N m", in Pa per SI unit of the load."""
    stress, load = units.of("MPa"), units.of(unit)
    name = f"{LOAD:.0f} {load.name}" if load.wished else f"k{unit}"
    return OutputUnit(
        f"{stress.name} per {name}",
        stress.size / (LOAD * load.size),
        wished=stress.wished or load.wished,
    )


def _place(place: list[float], length: OutputUnit) -> str:
    values = [value / length.size for value in place]
    digits = 2 if length.wished else 1
    return " ".join(f"{round(value, digits) + 0.0:.{digits}f}" for value in values)
