"""Processor time of a whole run or of its parts: this checkout, or this one and another in turn.

Run by hand (a minute or two for each whole run)::

    python benchmarks/engine_run.py
    git worktree add ../before SOME_COMMIT
    python benchmarks/engine_run.py --beside ../before --rounds 3
    python benchmarks/engine_run.py quarter whole throw study --beside ../before --rounds 5

Each run begins with an empty folder: study, report and pictures are included. What counts is the time of
the processor, user's and system's, of the run and of all processes that it starts, so that other work on the
machine matters little; the clock's is shown beside it. ``quarter`` and ``whole`` are analyses of a throw to
4 % in a process that has made one before, on a mesh made before. Checkouts take turns, each with its own
engine file, as its study may name what the other does not know; ratios are those of the medians.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

HERE = Path(__file__).resolve().parent.parent
ENGINE = Path("data", "engines", "6chn25-34.toml")
ANALYSIS = """
import sys, time
from statistics import median
from crankfem.files.engine.throw_file import load_throw
from fem.analysis import analyze_throw
from fem.first_mesh import first_factor
from geometry.mesher import mesh_isolated
throw, material = load_throw(sys.argv[1])
mesh = mesh_isolated(throw, first_factor(throw, 0.04), sys.argv[2])
taken = []
for _ in range(8):
    before = time.process_time()
    analyze_throw(throw, material, 0.04, mesher=lambda *_: mesh)
    taken.append(time.process_time() - before)
print(median(taken[1:]))
"""
PARTS = {
    "run": ["-m", "crankfem", "run", "{engine}", "--output", "{folder}"],
    "throw": ["-m", "crankfem", "throw", "{engine}", "--accuracy", "0.04"],
    "study": ["-m", "crankfem", "doe", "{engine}", "--store", "{folder}/runs.sqlite"],
    "quarter": ["-c", ANALYSIS, "{engine}", "quarter"],
    "whole": ["-c", ANALYSIS, "{engine}", "full"],
}


def seconds_of(part: str, checkout: Path, engine: Path) -> tuple[float, float]:
    """Time of the processor and of the clock that a part takes by a checkout [s]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            word.replace("{engine}", str(engine)).replace("{folder}", folder)
            for word in PARTS[part]
        ]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        ended = subprocess.run(
            [sys.executable, "-P", *command],
            env=os.environ | {"PYTHONPATH": str(checkout), "OPENBLAS_NUM_THREADS": "1"},
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        clock, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return (float(ended.stdout),) * 2 if ANALYSIS in command else (taken, clock)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", default=["run"], help=", ".join(PARTS))
    parser.add_argument("--engine", type=Path, default=ENGINE, help="in each checkout, or a path")
    parser.add_argument("--beside", type=Path, help="another checkout")
    parser.add_argument("--rounds", type=int, default=1)
    given = parser.parse_args()
    checkouts = [HERE] if given.beside is None else [HERE, given.beside.resolve()]
    for part in given.parts:
        taken: dict[Path, list[tuple[float, float]]] = {checkout: [] for checkout in checkouts}
        for _ in range(given.rounds):
            for checkout in checkouts:
                taken[checkout].append(seconds_of(part, checkout, checkout / given.engine))
        middle = [[median(kind) for kind in zip(*taken[one], strict=True)] for one in checkouts]
        for checkout, (processor, clock) in zip(checkouts, middle, strict=True):
            print(
                f"{part}, {checkout}: {processor:.2f} s of the processor, {clock:.2f} s by the clock"
            )
        if given.beside is not None:
            processor, clock = (here / beside for here, beside in zip(*middle, strict=True))
            print(
                f"{part}: {processor:.2f} of its processor time, {clock:.2f} by the clock",
                flush=True,
            )


if __name__ == "__main__":
    main()
