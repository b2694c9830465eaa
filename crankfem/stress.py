"""Stresses at a throw's fillets on the command line: computed, printed, pictured."""

from pathlib import Path

from crankfem.console import print_json, print_line, print_table
from crankfem.data_files import engine_path
from crankfem.output_units import SI, OutputUnit, OutputUnits
from crankfem.record import Record
from crankfem.throw_file import load_throw
from fem.condensation import EndSections
from fem.fillet_stress import FilletPeak, FilletStresses, fillet_stresses
from fem.loads import radial_directions
from fem.unit_loads import unit_loads
from geometry.errors import InputError
from geometry.outputs import check_output, protect

# Stresses are printed for loads of 1 kN and 1 kN m, or of so many of the user's own units.
LOAD = 1000.0


def run_stress(
    engine: str,
    accuracy: float = 0.05,
    *,
    end_sections: EndSections = "rigid",
    pictures: Path | None = None,
    json: bool = False,
    units: OutputUnits = SI,
) -> None:
    """Compute the stresses at the fillets of an engine file's throw, print them, and picture them.

    Parameters
    ----------
    engine : str
        Engine file, or the name of a shipped engine.
    accuracy : float
        Wished relative accuracy of the largest stresses.
    end_sections : {"rigid", "averaged"}
    pictures : Path or None
        Folder for the pictures, if wished.
    json : bool
        Whether to print JSON instead of tables.
    units : OutputUnits
        Of the tables.

    Raises
    ------
    InputError, MeshError, SolveError, MissingLibraryError
        As `fem.fillet_stress.fillet_stresses` and `picture_stresses` say.
    """
    throw, material = load_throw(engine)
    if pictures is not None:
        if not pictures.absolute().parent.is_dir():
            raise InputError(
                f"{pictures}: cannot be written; there is no folder {pictures.parent}."
            )
        if pictures.exists() and not pictures.is_dir():
            raise InputError(
                f"--pictures: given {pictures}, which is a file; allowed is a folder, for there is a "
                "picture of each load."
            )
        from crankfem.pictures.stress_picture import picture_name

        protect(engine_path(engine))
        for load in unit_loads(radial_directions(throw)):
            check_output(pictures / picture_name(load), "picture")
    stresses = fillet_stresses(throw, material, accuracy, end_sections=end_sections)
    record = stress_record(stresses)
    if pictures is not None:
        from crankfem.pictures.stress_picture import picture_stresses

        record["pictures"] = [str(file) for file in picture_stresses(stresses, pictures)]
    if json:
        print_json(record)
    else:
        print_stresses(record, units)


def stress_record(stresses: FilletStresses) -> Record:
    """Plain content of the stresses at a throw's fillets, in SI units."""
    mesh = stresses.loaded.mesh
    return {
        "dimensions": stresses.throw.model_dump(mode="json"),
        "material": stresses.loaded.material.model_dump(),
        "support": "pinned",
        "end_sections": stresses.loaded.end_sections,
        "loads": [
            {
                "load": load.name,
                "kind": load.kind,
                "unit": load.unit,
                "stress_unit": f"Pa/({load.unit})" if " " in load.unit else f"Pa/{load.unit}",
                "fillets": [_peak_record(peak) for peak in stresses.under(load)],
            }
            for load in stresses.loaded.loads
        ],
        "sharp_corners": list(stresses.sharp_corners),
        "error_estimate": stresses.error_estimate,
        "accuracy": stresses.accuracy,
        "accuracy_met": stresses.accuracy_met,
        "elements_across_fillets": stresses.fineness,
        "unknowns": mesh.unknowns,
        "solved_part": mesh.part,
        "mended_elements": mesh.mended_elements,
        "meshing_attempts": list(mesh.attempts),
        "solver": stresses.loaded.solver,
        "pictures": [],
    }


def _peak_record(peak: FilletPeak) -> Record:
    return {
        "fillet": peak.fillet.name,
        "radius": peak.fillet.radius,
        "principal": peak.principal,
        "principal_place": peak.principal_place.tolist(),
        "principals": peak.principals.tolist(),
        "von_mises": peak.von_mises,
        "von_mises_place": peak.von_mises_place.tolist(),
        "nominal": peak.nominal,
        "factor": peak.factor,
        "von_mises_factor": peak.von_mises_factor,
        "error_estimate": peak.error_estimate,
    }


def print_stresses(record: Record, units: OutputUnits = SI) -> None:
    """Print a table for each load, and what there is to say besides."""
    length = units.of("mm")
    # Of a throw symmetric about its middle the left half says everything.
    mirrored = record["solved_part"] == "quarter"
    for load in record["loads"]:
        fillets = load["fillets"]
        stress = _stress_per_load(load["unit"], units)
        print_table(
            f"{load['load'].capitalize()}: largest stresses at fillets [{stress.name}]",
            ["fillet", "principal", "von Mises", "nominal", "factor", f"at x y z [{length.name}]"],
            [
                _row(peak, stress, length)
                for peak in (fillets[: len(fillets) // 2] if mirrored else fillets)
            ],
        )
    for sentence in _sentences(record, mirrored):
        print_line(sentence)


def _stress_per_load(unit: str, units: OutputUnits) -> OutputUnit:
    """Return the unit of a stress per load of "N" or "N m", in Pa per SI unit of the load."""
    stress, load = units.of("MPa"), units.of(unit)
    name = f"{LOAD:.0f} {load.name}" if load.wished else f"k{unit}"
    return OutputUnit(
        f"{stress.name} per {name}",
        stress.size / (LOAD * load.size),
        wished=stress.wished or load.wished,
    )


def _row(peak: Record, stress: OutputUnit, length: OutputUnit) -> list[str]:
    place = [value / length.size for value in peak["principal_place"]]
    digits = 2 if length.wished else 1 if max(map(abs, place)) < 100.0 else 0
    return [
        peak["fillet"].replace("main journal", "journal"),
        *(stress.number(peak[name]) for name in ("principal", "von_mises", "nominal")),
        f"{peak['factor']:.2f}",
        " ".join(f"{round(value, digits) + 0.0:.{digits}f}" for value in place),
    ]


def _sentences(record: Record, mirrored: bool) -> list[str]:
    """What the tables leave unsaid."""
    found = [
        f"Ends pinned, end sections {record['end_sections']}. Principal: that of the largest magnitude, "
        "at the place given; factor: its size divided by the nominal stress, under a torque a shear "
        "stress."
    ]
    if mirrored:
        found.append(
            "The fillets at the right web have the same stresses, under a torque with the opposite sign."
        )
    if record["solved_part"] != "full":
        found.append(
            "Places at -x have the same stresses, under a torque and bending across the crank plane "
            "with the opposite sign."
        )
    if record["sharp_corners"]:
        found.append(
            f"No stress is given at {'; '.join(record['sharp_corners'])}: without a fillet the elastic "
            "stress has no bound."
        )
    errors = [peak["error_estimate"] for load in record["loads"] for peak in load["fillets"]]
    met = (
        "" if record["accuracy_met"] else f", not the {100.0 * record['accuracy']:.2g} % asked for"
    )
    found.append(
        f"Estimated errors of the stresses: {100.0 * min(errors):.2g} to {100.0 * max(errors):.2g} %{met}."
    )
    found += [f"{file} written." for file in record["pictures"]]
    return found
