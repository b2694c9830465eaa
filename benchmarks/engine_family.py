"""A family of throws from 13/14 to 25/34 size: an equation on dimensionless groups, and a left-out engine.

Run from the root: ``python benchmarks/engine_family.py [--store FILE] [--workers N] [--golden FILE]``.
Takes some minutes with an empty store. With ``--golden`` the results are written as the golden numbers
of the tests (tests/golden/engine_family.csv).
"""

import argparse
import csv
import tempfile
from pathlib import Path

from crankfem.analyses.study.response_fits import fit_study
from crankfem.files.engine.throw_file import load_throw
from fem.material import STEEL
from fem.responses import evaluate_throw
from geometry.throw import CrankThrow
from regression.fits.forms import group_named
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.response_kinds import response_scale
from regression.runs.study import run_plan
from regression.runs.study_table import StudyTable

DIMENSIONS = (
    "crank_radius",
    "main_journal_diameter",
    "pin_diameter",
    "main_journal_length",
    "pin_length",
    "web_width",
    "web_thickness",
    "fillet_radius",
)
RESPONSES = ("axial_compliance_pinned", "torsional_compliance_pinned", "mass")
LEFT_OUT = "6chn18-22"
# Radii from 13/14 to 25/34 engines; the other factors are ratios, as engines of that kind have them.
FACTORS = (
    Factor("crank_radius", "m", 0.065, 0.175),
    Factor("overlap_ratio", "", 0.0, 0.6),
    Factor("slimness", "", 1.9, 3.3),
    Factor("width_ratio", "", 1.45, 1.8),
    Factor("journal_ratio", "", 1.1, 1.27),
    Factor("pin_ratio", "", 0.58, 0.95),
    Factor("length_ratio", "", 0.36, 0.78),
    Factor("fillet_ratio", "", 0.05, 0.075),
)
RELATIONS = {
    "pin_diameter": "2 * crank_radius * (1 + overlap_ratio) / (1 + journal_ratio)",
    "main_journal_diameter": "journal_ratio * pin_diameter",
    "main_journal_length": "length_ratio * pin_diameter",
    "pin_length": "pin_ratio * pin_diameter",
    "web_width": "width_ratio * pin_diameter",
    "web_thickness": "crank_radius / slimness",
    "fillet_radius": "fillet_ratio * pin_diameter",
}


def plain_throw(name: str) -> CrankThrow:
    """Return a shipped engine's throw with its eight main dimensions alone."""
    throw, _ = load_throw(name)
    return CrankThrow(**{field: getattr(throw, field) for field in DIMENSIONS})


def plan() -> StudyPlan:
    """Plan 160 runs and 30 held-out designs over the family."""
    return StudyPlan(
        plain_throw(LEFT_OUT),
        FACTORS,
        DesignChoice("latin hypercube", runs=160),
        relations=RELATIONS,
        held_out=30,
    )


def write_golden(path: Path, table: StudyTable, left_out: dict[str, float]) -> None:
    """Write the dimensions and responses of all designs, and of the engine that was left out."""
    throw = plain_throw(LEFT_OUT)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["role", *DIMENSIONS, *RESPONSES])
        for place, held in enumerate(table.held_out):
            writer.writerow(
                [
                    "held out" if held else "run",
                    *(f"{table.dimensions[name][place]:.9g}" for name in DIMENSIONS),
                    *(f"{table.responses[name][place]:.7g}" for name in RESPONSES),
                ]
            )
        writer.writerow(
            [
                LEFT_OUT,
                *(f"{getattr(throw, name):.9g}" for name in DIMENSIONS),
                *(f"{left_out[name]:.7g}" for name in RESPONSES),
            ]
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--store", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--golden", type=Path)
    given = parser.parse_args()
    throw = plain_throw(LEFT_OUT)
    with tempfile.TemporaryDirectory() as folder:
        table = run_plan(plan(), given.store or Path(folder) / "runs.sqlite", given.workers)
    left_out = evaluate_throw(throw, STEEL, 0.01).values
    if given.golden:
        write_golden(given.golden, table, left_out)
    dimensions = {name: getattr(throw, name) for name in DIMENSIONS}
    print(f"{'response':30}{'form':18}{'terms':>6}{'held out: largest (mean)':>26}{LEFT_OUT:>12}")
    for found in fit_study(table).values():
        for fit in found.fits:
            if fit.basis != "groups":
                continue
            x = [group_named(name).value(dimensions) for name in fit.factors]
            value = response_scale(found.unit, dimensions, STEEL) * float(fit.predict(x))
            print(
                f"{found.column:30}{fit.form:18}{fit.coefficient_count:6}"
                f"{100 * (fit.largest_heldout_error or 0):18.2f} % "
                f"({100 * (fit.mean_heldout_error or 0):.2f} %)"
                f"{100 * (value / left_out[found.column] - 1):10.2f} %"
            )


if __name__ == "__main__":
    main()
