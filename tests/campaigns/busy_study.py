"""Ten factors and 200 designs by one command: how busy the workers are; interrupted and resumed.

Run by hand: python tests/campaigns/busy_study.py --designs 200 --accuracy 0.01
Busy is the time that the designs took, as the workers measured it, over the workers' wall time from
the start of the command to the last result: the start of Python, of the workers and all storing count
as idle. Exit code 1 if it is below 90 %, or if the interrupt lost or repeated a design.
"""

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from study_tools import environment, rows, said, study, study_file, total, wait_for

ALLOWED = 0.90


@dataclass(frozen=True)
class Part:
    """One run of the command: its exit code, what it said, its wall time, and the rows it left."""

    code: int
    words: str
    seconds: float
    rows: list[tuple[object, ...]]


def run(file: Path, store: Path, workers: int, wanted: int, *, interrupt: bool) -> Part:
    """Run the command until so many designs are finished, then to its end."""
    # An interrupt is ignored by what is started in the background, unless it is asked for.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from crankfem.cli.entry import main; main()"
    )
    arguments = ["doe", file, "--store", store, "--workers", workers, "--json"]
    began = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code, *map(str, arguments)],
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(store, wanted, process, 4.0 * 3600.0)
    seconds = time.monotonic() - began
    if interrupt:
        process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    return Part(process.returncode, " ".join(errors.split()), seconds, rows(store))


def busy(part: Part, before: int, workers: int) -> float:
    """Share of the workers' time that went into designs."""
    return sum(float(row[3]) for row in part.rows[before:]) / (workers * part.seconds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=200)
    parser.add_argument("--accuracy", type=float, default=0.01)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--interrupt", type=float, default=0.4, help="after this share of the designs"
    )
    given = parser.parse_args()
    wanted = total(study(given.designs, given.accuracy))
    with tempfile.TemporaryDirectory() as folder:
        file = study_file(Path(folder) / "study.toml", given.designs, given.accuracy)
        store = Path(folder) / "runs.sqlite"
        half = round(given.interrupt * wanted)
        first = run(file, store, given.workers, half, interrupt=True)
        print(f"     {first.words}")
        kept = len(first.rows)
        good = said(
            f"interrupted after {kept} of {wanted} designs: exit code {first.code}, one sentence",
            good=first.code == 130 and f"{kept} of {wanted} designs" in first.words,
        )
        second = run(file, store, given.workers, wanted, interrupt=False)
        new = len(second.rows) - kept
        good &= said(
            f"resumed: {new} designs computed, {len(second.rows)} of {wanted} finished, exit code "
            f"{second.code}",
            good=second.code == 0 and len(second.rows) == wanted,
        )
        good &= said(
            f"the {kept} designs of before are the same rows, to the last byte",
            good=second.rows[:kept] == first.rows,
        )
        failed = [row for row in second.rows if row[1] != "done"]
        for row in failed:
            print(f"     {row[1]}: {row[5]}")
        good &= said(f"{len(failed)} designs failed", good=not failed)
        for name, part, before in (("before", first, 0), ("after", second, kept)):
            share = busy(part, before, given.workers)
            designs = len(part.rows) - before
            good &= said(
                f"{name} the interrupt: {designs} designs in {part.seconds:.0f} s, "
                f"{60.0 * designs / part.seconds:.1f} a minute, {given.workers} workers busy "
                f"{100.0 * share:.1f} % of the time",
                good=share > ALLOWED,
            )
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
