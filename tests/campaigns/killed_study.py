"""A study whose workers and coordinator are killed (SIGKILL) loses nothing that was finished.

Run by hand: python tests/campaigns/killed_study.py --designs 24 --accuracy 0.1
Prints what became of the designs; exit code 1 if one was lost or computed twice.
"""

import argparse
import signal
import tempfile
import time
from pathlib import Path

import psutil
from study_tools import coordinator, rows, said, study, total, wait_for


def kill_a_worker(process) -> bool:
    """Kill one of the worker processes of a coordinator."""
    for child in psutil.Process(process.pid).children():
        if "crankbase.calls" in child.cmdline():
            child.kill()
            return True
    return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=40)
    parser.add_argument("--accuracy", type=float, default=0.1)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    plan = study(given.designs, given.accuracy)
    wanted = total(plan)
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "runs.sqlite"
        good = True
        # The coordinator is killed after a quarter and after half of the designs.
        before = []
        for part in (wanted // 4, wanted // 2):
            process = coordinator(plan, store, given.workers)
            wait_for(store, part, process)
            workers = psutil.Process(process.pid).children()
            process.send_signal(signal.SIGKILL)
            process.communicate()
            _, alive = psutil.wait_procs(workers, timeout=10.0)
            good &= said("workers end by themselves when the coordinator is killed", good=not alive)
            now = rows(store)
            good &= said(
                f"coordinator killed: store readable, {len(now)} of {wanted} designs in it",
                good=len(now) >= part and now[: len(before)] == before,
            )
            before = now
        # Then one worker after the other, while the rest is computed.
        process = coordinator(plan, store, given.workers)
        killed = 0
        for part in range(len(before) + 2, wanted - 2, max(2, wanted // 8)):
            if not wait_for(store, part, process):
                break
            time.sleep(0.2)
            killed += kill_a_worker(process)
        _, errors = process.communicate()
        lost = sum(row[1] == "lost" for row in rows(store))
        if lost:  # killed in both attempts: the next run tries them again
            print(f"     {lost} designs were lost with both of their workers; run again")
            coordinator(plan, store, given.workers).communicate()
        after = rows(store)
        good &= said(
            f"{killed} workers killed: the coordinator ends with {process.returncode}",
            good=killed > 0 and process.returncode == 0 and not errors.strip(),
        )
        done = [row for row in after if row[1] == "done"]
        for key, status, *_, reason, _ in after:
            if status != "done":
                print(f"     {key} {status}: {reason}")
        good &= said(
            f"{len(done)} of {wanted} designs finished in the end", good=len(done) == wanted
        )
        good &= said(
            f"the {len(before)} designs finished before are the same rows, to the last byte",
            good=after[: len(before)] == before,
        )
        retried = sum(row[6] > 1 for row in after)
        good &= said(
            f"{retried} designs took a second attempt, no more than were killed ({killed})",
            good=retried <= killed,
        )
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
