"""Add computed throws to those of the law: ``python benchmarks/law_table.py FOLDER``.

Writes data/tables/law_throws.csv.gz. Lengths are in main journal diameters, answers those of E = 1 and D = 1
(`regression.law.throw_law.OUTPUTS`), nu = 0.3.
"""

import argparse
import csv
import gzip
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.supports import STRETCH, TWIST
from geometry.throw import CrankThrow
from law_throws import SAMPLES
from regression.law.throw_law import OUTPUTS, throw_dimensions

Array = NDArray[np.float64]
TABLE = Path(__file__).parent.parent / "data" / "tables" / "law_throws.csv.gz"
UX, UY, UZ, RX, RY, RZ = range(6)
PINNED = [n for n in range(12) if n not in (UX, UY, 6 + UX, 6 + UY, UZ, RZ)]
# What dimensions are that a throw leaves open.
OPEN = {"web_pin_end": "web_width", "web_journal_end": "web_width"}


def throws() -> tuple[Array, dict[str, Array], dict[str, Array]]:
    """Samples (n,), dimensions by their names and answers by `OUTPUTS` of the throws in the table."""
    with gzip.open(TABLE, "rt", encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    columns = {
        name: np.array([float(row[name] or "nan") for row in rows])
        for name in rows[0]
        if name not in ("sample", "number")
    }
    answers = {name: columns.pop(name) for name in OUTPUTS}
    found = {"main_journal_diameter": np.ones(len(rows))}
    for name, values in columns.items():
        other = "web_thickness" if name.endswith("thickness") else "fillet_radius"
        rest = 0.5 * columns[OPEN[name]] if name in OPEN else columns[other]
        found[name] = np.where(np.isnan(values), rest, values)
    return np.array([row["sample"] for row in rows]), found, answers


def computed(folder: Path) -> list[dict[str, Any]]:
    """Finished throws in a folder of `train_law`, each once, in the order of their numbers."""
    found: dict[tuple[str, int], dict[str, Any]] = {}
    for sample in SAMPLES:
        for file in sorted(folder.glob(f"{sample}-[0-9].jsonl")):
            for line in file.read_text(encoding="utf-8").splitlines():
                try:
                    row = json.loads(line)
                except ValueError:
                    continue
                if "failed" not in row and row["corrected"]:
                    found[sample, row["number"]] = row
    return [found[key] for key in sorted(found)]


def moment(axis: int, other: float) -> Array:
    """Unit moment on the left end about an axis, and another on the right end (12,)."""
    load = np.zeros(12)
    load[[axis, 6 + axis]] = 1.0, other
    return load


def numbers(row: dict[str, Any]) -> list[float]:
    """The law's answers of a throw, by `OUTPUTS`, from its superelement; E and D are 1 there."""
    stiffness, pins = np.array(row["stiffness"]), np.array(row["pin_loads"])
    tilts = [moment(RX, -1.0), moment(RY, 1.0), moment(RX, 1.0), moment(RY, -1.0)]
    loads = np.column_stack([STRETCH, TWIST, *tilts, pins[:, 0], -pins[:, 1]])
    motions = np.zeros_like(loads)
    motions[PINNED] = np.linalg.solve(stiffness[np.ix_(PINNED, PINNED)], loads[PINNED])
    work = loads.T @ motions
    axial, torsional, in_plane, across, alike, bent = np.diag(work)[:6]
    return [
        axial,
        axial - work[0, 2] ** 2 / in_plane,
        in_plane / across,
        work[0, 7],
        work[0, 7] - work[0, 2] * work[2, 7] / in_plane,
        torsional,
        torsional - work[1, 3] ** 2 / across,
        in_plane,
        alike,
        bent,
        work[5, 6],
        row["volume"],
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    rows = computed(parser.parse_args().folder)
    before = gzip.decompress(TABLE.read_bytes()).decode().splitlines(keepends=True)
    head = sum(line.startswith("#") for line in before) + 1
    names = [n for n in before[head - 1].strip().split(",")[2:] if n not in OUTPUTS]
    again = {(row["sample"], str(row["number"])) for row in rows}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    for row in rows:
        throw = throw_dimensions(CrankThrow(**row["fields"]))
        given = ["" if throw[name] is None else f"{throw[name]:.6g}" for name in names]
        answers = [f"{value:.6g}" for value in numbers(row)]
        table.writerow([row["sample"], row["number"], *given, *answers])
    lines = [line for line in before[head:] if tuple(line.split(",", 2)[:2]) not in again]
    lines = sorted(
        [*lines, *text.getvalue().splitlines(keepends=True)],
        key=lambda line: (line.split(",")[0], int(line.split(",")[1])),
    )
    # No time in the file: the same throws make the same bytes.
    content = "".join([*before[:head], *lines])
    TABLE.write_bytes(gzip.compress(content.encode(), mtime=0))
    print(f"{len(lines)} throws, {TABLE.stat().st_size / 1024:.0f} KB")


if __name__ == "__main__":
    main()
