"""Draw docs/law_formulas.svg: published formulas, the formula by hand and the law over finite elements.

The throws are those of the sample plain-test in data/tables/law_throws.csv.gz, which the law has not seen.
"""

import csv
import gzip
from pathlib import Path

import numpy as np

from crankbase.diagrams import BLUE, GRAY, figure
from crankbase.outputs import replacing_files
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formulas
from regression.law.throw_law import PLAIN, axial_law, hand_formula

HERE = Path(__file__).parent
TABLE = HERE.parent / "data" / "tables" / "law_throws.csv.gz"
E = 2.1e11
OURS = ("by hand", "the law")


def ratios_to_fe() -> dict[str, list[float]]:
    """Return by name what formulas give of the finite elements' e_n, for each throw."""
    with gzip.open(TABLE, "rt", encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    found: dict[str, list[float]] = {}
    for row in rows:
        if row["sample"] != "plain-test":
            continue
        throw = CrankThrow(main_journal_diameter=1.0, **{name: float(row[name]) for name in PLAIN})
        values = {name: one.value for name, one in axial_formulas(throw).items()}
        values |= {"by hand": hand_formula(throw).value, "the law": axial_law(throw).pinned}
        for name, value in values.items():
            found.setdefault(name, []).append(value * E / float(row["axial_pinned"]))
    return found


def main() -> None:
    """Draw the picture and print each formula's ratios, of which docs/law.md quotes some."""
    found = ratios_to_fe()
    with replacing_files(), figure(HERE / "law_formulas.svg") as axes:
        for place, (name, values) in enumerate(reversed(found.items())):
            spread = np.random.default_rng(0).uniform(-0.28, 0.28, len(values))
            color = BLUE if name in OURS else GRAY
            axes.plot(values, place + spread, ".", color=color, markersize=3, alpha=0.6)
        axes.axvline(1.0, color="black", linewidth=0.8)
        axes.set_xscale("log")
        ticks = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0]
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_yticks(range(len(found)), list(reversed(found)))
        axes.set_xlabel("axial compliance, formula / finite elements")
    for name, values in found.items():
        middle = np.median(values)
        rms = 100.0 * np.sqrt(np.mean((np.array(values) - 1.0) ** 2))
        print(f"| {name} | {min(values):.3g} | {middle:.3g} | {max(values):.3g} | {rms:.3g} % |")


if __name__ == "__main__":
    main()
