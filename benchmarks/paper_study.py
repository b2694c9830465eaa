"""The study of the paper done anew: two designs over its ranges, judged by the same held-out designs.

Run from the root: ``python benchmarks/paper_study.py [--store FILE] [--workers N] [--golden FILE]
[--plots FOLDER]``. Takes a few minutes with an empty store. With ``--golden`` the results are written as
the golden numbers of the tests (tests/golden/paper_study.csv), with ``--plots`` the diagrams of
docs/regression.md.
"""

import argparse
import csv
import math
import tempfile
from pathlib import Path

from crankbase.outputs import replacing_files
from crankfem.analyses.study.fit_plots import plot_parity, plot_response
from crankfem.analyses.study.response_fits import fit_study
from geometry.throw import CrankThrow
from regression.fits.fit import Fit
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS
from regression.fits.selection import choose
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.runs.study import run_plan
from regression.runs.study_table import StudyTable

FACTORS = ("web_width", "web_thickness", "pin_length")
# Lengths that the paper does not give are those of a plausible throw of that size.
THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.135,
    pin_length=0.139,
    web_width=0.300,
    web_thickness=0.068,
    fillet_radius=0.012,
)
HELD_OUT = 30
COLUMNS = ("axial_compliance_pinned", "torsional_compliance_pinned")
# The paper's printed coefficients: constant, B, h, L_shm, times 1e-10.
PRINTED = (6.1, -0.0583, -0.0386, 0.0102)


def plans() -> dict[str, StudyPlan]:
    """Plan the paper's factorial, and one of 36 runs with four levels of h denser at its ends."""
    width = Factor.spread("web_width", "m", 0.270, 0.330, 3, "even")
    length = Factor.spread("pin_length", "m", 0.120, 0.158, 3, "even")
    designs = {
        "27": Factor.spread("web_thickness", "m", 0.038, 0.098, 3, "even"),
        "36": Factor.spread("web_thickness", "m", 0.038, 0.098, 4, "log chebyshev"),
    }
    return {
        name: StudyPlan(THROW, (width, thickness, length), held_out=HELD_OUT)
        for name, thickness in designs.items()
    }


def fits(table: StudyTable) -> list[Fit]:
    """Fit all forms on the factors to the axial compliance."""
    x, y, held = table.values, table.responses[COLUMNS[0]], table.held_out
    return [
        fit_form(form, FACTORS, x[~held], y[~held], x[held], y[held], drop_terms=True)
        for form in FORMS
        if FORMS[form].basis == "factors"
    ]


def write_golden(path: Path, tables: dict[str, StudyTable]) -> None:
    """Write every design once, with the designs that it belongs to."""
    rows: dict[tuple[float, ...], dict[str, str]] = {}
    for name, table in tables.items():
        for place, values in enumerate(table.values.tolist()):
            role = "held out" if table.held_out[place] else name
            row = rows.setdefault(tuple(values), {"role": role})
            if role not in row["role"].split("+"):
                row["role"] += f"+{role}"
            row |= {n: f"{v:.12g}" for n, v in zip(FACTORS, values, strict=True)}
            for column in COLUMNS:
                row[column] = f"{table.responses[column][place]:.10g}"
                row[f"{column}_error"] = f"{table.errors[column][place]:.4g}"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(
            file, fieldnames=list(next(iter(rows.values()))), lineterminator="\n"
        )
        writer.writeheader()
        writer.writerows(rows.values())


def printed_linear(kind: str, width: float, thickness: float, length: float) -> float:
    """Return the paper's printed linear form in one reading of its variables [m/N]."""
    given = (width, thickness, length)
    centers, halves = (0.300, 0.068, 0.139), (0.030, 0.030, 0.019)
    read = {
        "mm": [1e3 * value for value in given],
        "cm": [1e2 * value for value in given],
        "centered mm": [1e3 * (v - c) for v, c in zip(given, centers, strict=True)],
        "coded": [(v - c) / s for v, c, s in zip(given, centers, halves, strict=True)],
    }[kind]
    return 1e-10 * (PRINTED[0] + sum(c * u for c, u in zip(PRINTED[1:], read, strict=True)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--store", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--golden", type=Path)
    parser.add_argument("--plots", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        store = given.store or Path(folder) / "runs.sqlite"
        tables = {name: run_plan(plan, store, given.workers) for name, plan in plans().items()}
    if given.golden:
        write_golden(given.golden, tables)
    if given.plots:
        for name, plot in (("27", plot_parity), ("36", plot_response)):
            found = fit_study(tables[name])["axial_compliance"]
            with replacing_files():
                plot(given.plots / f"paper_study_{name}.svg", tables[name], found)
    for name, table in tables.items():
        found = fits(table)
        taken = choose(found, float(table.errors[COLUMNS[0]].std()))
        print(f"\n{name} runs, {HELD_OUT} held out; errors in %: largest (mean)")
        print(f"{'form':18}{'terms':>6}{'R2':>9}{'Q2':>9}{'at the runs':>16}{'held out':>16}")
        for place, fit in enumerate(found):
            print(
                f"{fit.form:18}{fit.coefficient_count:6}{fit.r_squared:9.4f}"
                f"{math.nan if fit.q_squared is None else fit.q_squared:9.4f}"
                f"{100 * fit.largest_error:8.2f} ({100 * fit.mean_error:.2f})"
                f"{100 * (fit.largest_heldout_error or 0):9.2f} "
                f"({100 * (fit.mean_heldout_error or 0):.2f})" + (" *" * (place == taken.place))
            )
        print(taken.reason)
    table = tables["27"]
    y = table.responses[COLUMNS[0]]
    print("\nThe paper's printed linear form against finite elements, 1e-9 m/N")
    print(f"finite elements: {1e9 * y.min():.2f} to {1e9 * y.max():.2f}")
    for kind in ("mm", "cm", "centered mm", "coded"):
        e = [printed_linear(kind, *values) for values in table.values.tolist()]
        print(f"{kind:12} {1e9 * min(e):.2f} to {1e9 * max(e):.2f}")


if __name__ == "__main__":
    main()
