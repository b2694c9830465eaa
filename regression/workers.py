"""Supervise worker processes: a crash or a hang costs one design, not the study."""

import contextlib
import json
import selectors
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from geometry.processes import package_environment
from regression.store import Outcome

TRIES = 2
# Seconds that a design may take at 1 % accuracy before its worker counts as hanging.
TIME_LIMIT = 300.0


@dataclass
class _Worker:
    """One process and the design it works on."""

    process: subprocess.Popen[bytes]
    key: str | None = None
    started: float = 0.0


def run_designs(
    designs: Iterable[tuple[str, Mapping[str, Any]]],
    on_outcome: Callable[[Outcome], None],
    workers: int,
    time_limit: float = TIME_LIMIT,
) -> None:
    """Compute designs in worker processes.

    Parameters
    ----------
    designs : iterable of (key, inputs)
        What to compute.
    on_outcome : callable
        Called in this process with each outcome as it arrives.
    workers : int
        Number of processes.
    time_limit : float
        Seconds that one design may take before its worker is ended.

    Notes
    -----
    A design whose worker dies or hangs is tried once more in a fresh process, then recorded as
    lost, for a later run to try again. On an exception here (Ctrl-C included) all workers are ended;
    what arrived is kept.
    """
    inputs = dict(designs)
    waiting = deque(inputs)
    tries = dict.fromkeys(inputs, 0)
    selector = selectors.DefaultSelector()
    pool: list[_Worker] = []

    def start() -> None:
        worker = _Worker(_spawn())
        pool.append(worker)
        assert worker.process.stdout is not None
        selector.register(worker.process.stdout, selectors.EVENT_READ, worker)
        assign(worker)

    def assign(worker: _Worker) -> None:
        if not waiting:
            worker.key = None
            return
        worker.key, worker.started = waiting.popleft(), time.monotonic()
        tries[worker.key] += 1
        request = json.dumps({"key": worker.key, "inputs": inputs[worker.key]}) + "\n"
        assert worker.process.stdin is not None
        # If it died, its closed output is read next and settles the design.
        with contextlib.suppress(BrokenPipeError):
            worker.process.stdin.write(request.encode())
            worker.process.stdin.flush()

    def lose(worker: _Worker, reason: str) -> None:
        selector.unregister(worker.process.stdout)  # type: ignore[arg-type]
        _end(worker.process)
        pool.remove(worker)
        if worker.key is not None:
            if tries[worker.key] < TRIES:
                waiting.append(worker.key)
            else:
                seconds = time.monotonic() - worker.started
                on_outcome(
                    Outcome(worker.key, inputs[worker.key], None, reason, seconds, lost=True)
                )
        if waiting:
            start()

    try:
        for _ in range(min(workers, len(inputs))):
            start()
        while any(worker.key is not None for worker in pool):
            for event, _ in selector.select(timeout=0.5):
                worker = event.data
                line = worker.process.stdout.readline()
                if not line:
                    lose(worker, f"the worker process died (exit code {worker.process.wait()})")
                    continue
                answer = json.loads(line)
                key = answer["key"]
                on_outcome(
                    Outcome(
                        key,
                        inputs[key],
                        answer.get("responses"),
                        answer.get("reason"),
                        answer["seconds"],
                    )
                )
                assign(worker)
            for worker in list(pool):
                if worker.key is not None and time.monotonic() - worker.started > time_limit:
                    lose(worker, f"took longer than the limit of {time_limit:g} s")
    finally:
        for worker in pool:
            _end(worker.process)
        selector.close()


def _spawn() -> subprocess.Popen[bytes]:
    environment = package_environment() | {"MKL_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # -P keeps a folder named like our packages in the working directory out of the way.
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "regression.worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    )


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
