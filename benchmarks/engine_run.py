"""Processor time of a whole run: this checkout, or this one and others in turn.

Run by hand (a minute or two for each run)::

    python benchmarks/engine_run.py
    git worktree add ../before SOME_COMMIT
    python benchmarks/engine_run.py --beside ../before --rounds 3

Each run begins with an empty folder: study, report and pictures are included. What counts is the time of
the processor, user's and system's, of the run and of all processes that it starts, so that other work on the
machine matters little. Checkouts take turns; the ratio is that of the medians.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

HERE = Path(__file__).resolve().parent.parent
ENGINE = HERE / "data" / "engines" / "6chn25-34.toml"


def processor_seconds(checkout: Path, engine: Path) -> tuple[float, dict[str, float]]:
    """Run an engine by a checkout; return the processor time, and the clock's for each step."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, "-P", "-m", "crankfem", "run", str(engine), "--output", folder],
            env=os.environ | {"PYTHONPATH": str(checkout)},
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        results = json.loads(Path(folder, "results.json").read_text(encoding="utf-8"))
    taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return taken, results["repeat"]["seconds"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engine", type=Path, default=ENGINE)
    parser.add_argument("--beside", type=Path, help="another checkout")
    parser.add_argument("--rounds", type=int, default=1)
    given = parser.parse_args()
    checkouts = [HERE] if given.beside is None else [HERE, given.beside.resolve()]
    taken: dict[Path, list[float]] = {checkout: [] for checkout in checkouts}
    for _ in range(given.rounds):
        for checkout in checkouts:
            seconds, steps = processor_seconds(checkout, given.engine.resolve())
            taken[checkout].append(seconds)
            told = ", ".join(f"{name} {clock:.1f}" for name, clock in steps.items())
            print(f"{checkout}: {seconds:.1f} s of the processor; by the clock: {told}", flush=True)
    if given.beside is not None:
        here, beside = (median(taken[checkout]) for checkout in checkouts)
        print(f"medians {here:.1f} and {beside:.1f} s, ratio {here / beside:.2f}")


if __name__ == "__main__":
    main()
