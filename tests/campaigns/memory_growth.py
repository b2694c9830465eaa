"""A thousand designs in one worker process: its memory, and the coordinator's, may not grow.

Run by hand: python tests/campaigns/memory_growth.py --designs 1000
Prints resident memory after every tenth of the designs, and how much more the last tenth takes than the
second (in the first tenth caches fill); exit code 1 if it is more than 5 %.
"""

import argparse
import os
import tempfile
from pathlib import Path

import numpy as np
import psutil
from study_tools import said, study, total

from regression.runs.study import run_plan

ALLOWED = 0.05
TENTHS = 10


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=1000)
    parser.add_argument("--accuracy", type=float, default=0.1)
    given = parser.parse_args()
    plan = study(given.designs, given.accuracy)
    wanted, coordinator = total(plan), psutil.Process(os.getpid())
    memory: dict[str, list[float]] = {"worker": [], "coordinator": []}
    workers = set()

    def progress(finished: int, _total: int, newest: object) -> None:
        if newest is None:
            return
        taken = {
            child.pid: child.memory_info().rss
            for child in coordinator.children()
            if "crankbase.calls" in child.cmdline()
        }
        if not taken:  # the last answer has come
            return
        workers.update(taken)
        memory["worker"].append(max(taken.values()) / 1e6)
        memory["coordinator"].append(coordinator.memory_info().rss / 1e6)
        if finished % (wanted // TENTHS) == 0:
            now = ", ".join(f"{name} {values[-1]:.0f} MB" for name, values in memory.items())
            print(f"     {finished} designs: {now}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        table = run_plan(plan, Path(folder) / "runs.sqlite", 1, progress)
    good = said(
        f"{len(table.values)} of {wanted} designs in {len(workers)} process",
        good=len(table.values) == wanted and len(workers) == 1,
    )
    for name, values in memory.items():
        parts = [np.median(part) for part in np.array_split(values, TENTHS)]
        growth = float(parts[-1] / parts[1] - 1.0)
        good &= said(
            f"{name}: {parts[1]:.0f} MB in the second tenth, {parts[-1]:.0f} MB in the last, growth "
            f"{100.0 * growth:+.1f} %",
            good=growth < ALLOWED,
        )
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
