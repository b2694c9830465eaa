"""Processes killed, hung, without memory; stores torn; disks full or read-only: nothing may be lost.

Run by hand, as root (small disks are mounted): python tests/campaigns/faults.py FOLDER
A second run goes on where the first stopped. `--only NAME` runs one attack, `--seed` draws other moments.
After each attack the store passes SQLite's integrity_check, every finished design is the same row as before,
and all designs of the study are there in the end with the bits of an undisturbed run. Exit code 1 if anything
was lost, silent, a traceback, or hung.
"""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from random import Random

import fault_disk
import fault_kills
import fault_names
import fault_service
import fault_terminal
from fault_tools import Bench, Finding

Attack = Callable[[Bench, Random, Path], Finding]
# What is attacked, and at how many moments, lengths or sizes at least.
ATTACKS: dict[str, tuple[Attack, int]] = {
    "coordinator killed": (fault_kills.coordinator, 30),
    "interrupted (SIGINT, SIGTERM), once or twice": (fault_kills.interrupted, 20),
    "worker killed (SIGKILL, SIGABRT or SIGSEGV)": (fault_kills.worker, 25),
    "Dask worker killed": (fault_kills.dask_worker, 12),
    "Dask scheduler killed": (fault_kills.dask_scheduler, 5),
    "service killed during a job": (fault_service.server, 10),
    "worker of the service killed, jobs in the queue": (fault_service.worker_killed, 9),
    "disk of the service full, jobs in the queue": (fault_service.disk_full, 9),
    "pairs of headers, under both parsers": (fault_service.header_pairs, 3000),
    "400 followers of the service's jobs": (fault_service.followers, 1200),
    "heaviest requests to the service": (fault_service.heavy_requests, 31),
    "500 silent readers of the service": (fault_service.silent_readers, 200),
    "mesher killed or aborted": (fault_kills.mesher_killed, 15),
    "mesher stopped (hangs)": (fault_kills.mesher_hang, 3),
    "worker stopped (hangs)": (fault_kills.worker_hang, 3),
    "worker out of memory": (fault_kills.worker_memory, 6),
    "two coordinators on one store": (fault_kills.coordinators, 6),
    "store cut at a random length": (fault_disk.cut, 12),
    "noise in a page or bytes of the store": (fault_disk.torn, 12),
    "write-ahead log taken away after a kill": (fault_disk.without_log, 6),
    "disk full": (fault_disk.full_disk, 6),
    "disk for temporary files full": (fault_disk.full_scratch, 3),
    "files limited in size": (fault_disk.file_limit, 4),
    "folder read-only": (fault_disk.read_only, 3),
    "results folder half written or cut": (fault_disk.results_folder, 3),
    "files named in every field": (fault_names.named_files, 3000),
    **fault_terminal.ATTACKS,
}
COLUMNS = ("inputs", "lost", "silent", "tracebacks", "hangs")


def recorded(file: Path) -> list[dict[str, object]]:
    """Trials of earlier runs."""
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def table(trials: list[dict[str, object]]) -> list[str]:
    """Return the lines of the table."""
    lines = [f"| attack | {' | '.join(COLUMNS)} |", "|---" + "|---:" * len(COLUMNS) + "|"]
    for name in (*ATTACKS, None):
        own = [trial for trial in trials if name in (None, trial["attack"])]
        sums = " | ".join(str(sum(trial[column] for trial in own)) for column in COLUMNS)
        lines.append(f"| {name or 'all'} | {sums} |")
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", choices=list(ATTACKS))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    file = given.folder / "trials.jsonl"
    trials = recorded(file)
    bench = Bench(given.folder.resolve())
    # In turn, so that a campaign cut short has tried everything.
    waiting = list(given.only or ATTACKS)
    while waiting:
        name = waiting.pop(0)
        attack, wanted = ATTACKS[name]
        own = [trial for trial in trials if trial["attack"] == name]
        if sum(trial["inputs"] for trial in own) >= wanted:
            continue
        waiting.append(name)
        draw = Random(f"{given.seed} {name} {len(own)}")
        place = bench.folder / f"{attack.__name__}-{len(own)}-{time.time_ns()}.sqlite"
        began = time.monotonic()
        found = attack(bench, draw, place)
        trials.append({"attack": name, "number": len(own)} | asdict(found))
        with file.open("a") as lines:
            lines.write(json.dumps(trials[-1]) + "\n")
        print(
            f"{'ok  ' if found.good else 'BAD '} {name} {len(own) + 1}: {found.inputs} inputs, "
            f"{time.monotonic() - began:.0f} s",
            *found.words,
            sep="\n       ",
            flush=True,
        )
    print("\n".join(table(trials)))
    return int(any(trial[column] for trial in trials for column in COLUMNS[1:]))


if __name__ == "__main__":
    raise SystemExit(main())
