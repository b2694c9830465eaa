"""Stresses at a throw's fillets and oil holes as plain numbers, and the tables made from them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from crankbase.errors import InputError, MeshError, SolveError
from crankbase.results import plain
from crankbase.table import SI, Column, OutputUnit, OutputUnits, Table
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.stress_picture import RENDER, picture_arrays, picture_name
from crankfem.analyses.throw.throw_record import dimensions_of
from fem import fillet_stress
from fem.fillet_peaks import FilletPeak, FilletStresses, OilHolePeak
from fem.material import Material
from geometry.throw import CrankThrow

# Of the largest stresses: enough to compare fillets and to see which is the weakest.
ACCURACY = 0.1
# What loads a throw most in an engine: the rod's force and the torque.
KINDS_SHOWN = ("radial", "torsion")


def stresses_or_reason(
    throw: CrankThrow, material: Material, mesh: fillet_stress.FilletMesh = "adaptive"
) -> tuple[FilletStresses | None, str | None]:
    """Compute the stresses at a throw's fillets; if impossible, the other results remain.

    Parameters
    ----------
    mesh : {"adaptive", "m53"}
        See `fem.fillet_stress.fillet_stresses`.

    Returns
    -------
    str or None
        Why there are none.
    """
    try:
        return fillet_stress.fillet_stresses(throw, material, ACCURACY, mesh=mesh), None
    except (InputError, MeshError, SolveError) as error:
        return None, str(error)


def shown_loads(stresses: FilletStresses) -> FilletStresses:
    """Return the stresses under the loads that are pictured: radial on the first pin, and a torque."""
    loaded = stresses.loaded
    kept = [
        place
        for kind in KINDS_SHOWN
        for place, load in enumerate(loaded.loads)
        if load.kind == kind and load.pin in (None, 0)
    ]
    return of_loads(stresses, kept)


def of_loads(stresses: FilletStresses, kept: Sequence[int]) -> FilletStresses:
    """Return the stresses under some of the loads, by their indices."""
    loaded = stresses.loaded
    loads = tuple(loaded.loads[place] for place in kept)
    return replace(
        stresses,
        peaks=tuple(peak for peak in stresses.peaks if peak.load in loads),
        hole_peaks=tuple(peak for peak in stresses.hole_peaks if peak.load in loads),
        loaded=replace(
            loaded,
            loads=loads,
            shares=tuple(
                (symmetry, np.take(field, kept, axis=2)) for symmetry, field in loaded.shares
            ),
        ),
        surface=replace(stresses.surface, stress=np.take(stresses.surface.stress, kept, axis=1)),
    )


def stress_files(stresses: FilletStresses) -> dict[str, str]:
    """Return picture name to file name of the pictures of `StressRendering`."""
    names = [picture_name(load) for load in stresses.loaded.loads]
    return {Path(name).stem.replace("-", "_"): name for name in names}


class StressRendering(OffscreenProcess):
    """The pictures of stresses being rendered in the background, into a folder.

    Parameters
    ----------
    stresses : FilletStresses
        `shown_loads` of a throw.
    folder : Path
        Folder of the `stress_files`.
    """

    def __init__(self, stresses: FilletStresses, folder: Path) -> None:
        super().__init__(RENDER, folder, picture_arrays(stresses))


# Stresses are printed for loads of 1 kN and 1 kN m, or of so many of the user's own units.
LOAD = 1000.0


def stress_record(stresses: FilletStresses) -> Record:
    """Plain content of the stresses at a throw's fillets and oil holes, in SI units."""
    mesh = stresses.loaded.mesh
    return {
        "dimensions": plain(dimensions_of(stresses.throw)),
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
            attributes(meshing, "fillet", "size", "size_share", "layers", "across_web", "met")
            for meshing in stresses.meshings
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
