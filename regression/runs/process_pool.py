"""Worker processes kept alive between designs, on a machine of a cluster."""

import atexit
import os
import threading
from collections.abc import Mapping
from functools import cache
from typing import Any

from crankbase.calls import Limits, ProcessLostError
from regression.runs.supervised import SupervisedProcess

# Seconds after which a process that nobody asks any more is ended.
IDLE = 60.0


class ProcessPool:
    """Worker processes that wait for designs, for callers on any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[SupervisedProcess] = []
        self._busy: dict[SupervisedProcess, str] = {}
        self._ended: set[str] = set()
        self._timer: threading.Timer | None = None

    def compute(self, run: str, request: Mapping[str, Any], limits: Limits) -> dict[str, Any]:
        """Compute one design in a process of the pool.

        Parameters
        ----------
        run : str
            Name of the requesting run, for `end_run`.
        request : mapping
            As the worker process takes it.
        limits : Limits

        Returns
        -------
        dict
            ``worker``, and ``answer`` or ``lost`` with ``seconds``.
        """
        process = self._acquire(run)
        if process is None:
            return {"worker": "", "lost": "the run was stopped", "seconds": 0.0}
        process.compute(request)
        try:
            _, answer = process.wait(limits)
        except ProcessLostError as loss:
            self._release(process, alive=False)
            return {"worker": process.name, "lost": str(loss), "seconds": loss.seconds}
        self._release(process, alive=True)
        return {"worker": process.name, "answer": answer}

    def end_run(self, run: str) -> None:
        """End the calculations of a stopped run, including later ones."""
        with self._lock:
            self._ended.add(run)
            for process, owner in self._busy.items():
                if owner == run:
                    process.kill()

    def close(self) -> None:
        """End the idle processes."""
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            process.end()

    def _acquire(self, run: str) -> SupervisedProcess | None:
        with self._lock:
            if run in self._ended:
                return None
            if self._timer is not None:
                self._timer.cancel()
            while self._idle:
                process = self._idle.pop()
                if process.alive:
                    break
                process.end()
            else:
                process = SupervisedProcess()
            self._busy[process] = run
        return process

    def _release(self, process: SupervisedProcess, *, alive: bool) -> None:
        with self._lock:
            del self._busy[process]
            if alive:
                self._idle.append(process)
            if self._timer is not None:
                self._timer.cancel()
            self._timer = threading.Timer(IDLE, self.close)
            self._timer.daemon = True
            self._timer.start()


@cache
def _pool_of_process(_owner: int) -> ProcessPool:
    pool = ProcessPool()
    atexit.register(pool.close)
    return pool


def shared_process_pool() -> ProcessPool:
    """Return the pool common to all threads of this process; a forked child gets its own."""
    return _pool_of_process(os.getpid())
