"""Keep the throws that the law was trained and tested by: ``python benchmarks/law_table.py FOLDER``.

Writes data/tables/law_throws.csv.gz. Lengths are in main journal diameters, answers those of E = 1 and D = 1
(`regression.law.networks.OUTPUTS`), nu = 0.3.
"""

import argparse
import csv
import gzip
import io
import platform
from importlib.metadata import version
from pathlib import Path

from fit_law import SAMPLES, numbers, read
from geometry.throw import CrankThrow
from regression.law.networks import OUTPUTS
from regression.law.ratios import throw_dimensions

TABLE = Path(__file__).parent.parent / "data" / "tables" / "law_throws.csv.gz"
TESTS = ("plain-test", "real-test")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    rows = read(parser.parse_args().folder, (*SAMPLES["real"], *TESTS))
    text = io.StringIO()
    libraries = ", ".join(f"{name} {version(name)}" for name in ("gmsh", "numpy", "scipy"))
    text.write(
        "# Throws that the law was trained by, and (test) judged by: corrected finite-element answers of\n"
        "# this program, accuracy 1 %, of real ones 3 %. Lengths over the main journal's diameter; answers\n"
        "# with E and D the unit: compliances times E D, twists and tilts per moment times E D^3, per force\n"
        "# times E D^2. Samples and seeds: benchmarks/law_throws.py. Written by benchmarks/law_table.py,\n"
        f"# Python {platform.python_version()}, {libraries}.\n"
    )
    throws = [throw_dimensions(CrankThrow(**row["fields"])) for row in rows]
    names = [name for name in throws[0] if name != "main_journal_diameter"]
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["sample", "number", *names, *OUTPUTS])
    for row, throw in zip(rows, throws, strict=True):
        given = ["" if throw[name] is None else f"{throw[name]:.6g}" for name in names]
        answers = [f"{value:.6g}" for value in numbers(row)]
        table.writerow([row["sample"], row["number"], *given, *answers])
    # No time in the file: the same throws make the same bytes.
    TABLE.write_bytes(gzip.compress(text.getvalue().encode(), mtime=0))
    print(f"{len(rows)} throws, {TABLE.stat().st_size / 1024:.0f} KB")


if __name__ == "__main__":
    main()
