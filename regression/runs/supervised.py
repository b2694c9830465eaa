"""One worker process under supervision: it computes a design, or is ended with the reason."""

import contextlib
import json
import select
import socket
import subprocess
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import psutil
from crankbase.checks.scalars import is_number

from crankbase.errors import InputError
from crankbase.processes import end_child, signal_name, start_child

# Seconds that a design may take at 1 % accuracy before its worker counts as hanging.
TIME_LIMIT = 300.0
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("MKL", "OMP", "OPENBLAS")}
# Seconds between two looks at a worker's time and memory.
WATCH = 0.1
GIGABYTE = 1e9
# A worker cannot do with less: the libraries alone take a quarter of it.
SMALLEST_MEMORY = 0.5 * GIGABYTE


@dataclass(frozen=True)
class Limits:
    """What one design may take before its worker is ended.

    Attributes
    ----------
    seconds : float
    memory : float or None
        Resident memory of the worker process [byte], its libraries included; None for no limit.
    """

    seconds: float = TIME_LIMIT
    memory: float | None = None


def design_limits(
    accuracy: float, time_limit: float | None = None, memory_limit: float | None = None
) -> Limits:
    """Make the limits of a study's designs.

    Parameters
    ----------
    accuracy : float
        Of the study: a finer mesh may take longer before its worker counts as hanging.
    time_limit : float, optional
        Seconds.
    memory_limit : float, optional
        Bytes.

    Raises
    ------
    InputError
    """
    for name, given, kind in (
        ("time_limit", time_limit, "seconds, like 300"),
        ("memory_limit", memory_limit, "bytes, like 4e9"),
    ):
        if given is not None and not is_number(given):
            raise InputError(f"{name}: given {given!r}; allowed is a finite number of {kind}.")
    if time_limit is not None and time_limit <= 0.0:
        raise InputError(
            f"time_limit: given {time_limit:g} s; allowed is a positive time, because every "
            "design takes some."
        )
    if memory_limit is not None and memory_limit < SMALLEST_MEMORY:
        raise InputError(
            f"memory_limit: given {memory_limit / GIGABYTE:g} GB; allowed is "
            f"{SMALLEST_MEMORY / GIGABYTE:g} GB or more, because the libraries of a worker take up to "
            "half of that."
        )
    seconds = TIME_LIMIT * max(1.0, 0.01 / accuracy) if time_limit is None else time_limit
    return Limits(seconds, memory_limit)


@dataclass(frozen=True)
class Loss:
    """A design whose worker is gone: why, and after how many seconds."""

    reason: str
    seconds: float


class SupervisedProcess:
    """A worker process that computes one design after another, until it is lost or ended."""

    def __init__(self) -> None:
        self._process = spawn_worker()
        self._memory: psutil.Process | None = None
        with contextlib.suppress(psutil.Error):
            self._memory = psutil.Process(self._process.pid)
        self._peak = 0.0
        self._started = 0.0
        self.name = f"{socket.gethostname()}:{self._process.pid}"

    def fileno(self) -> int:
        """File descriptor that becomes readable when there is an answer, or the process is gone."""
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    def give(self, request: Mapping[str, Any]) -> None:
        """Give it a design."""
        self._started, self._peak = time.monotonic(), 0.0
        assert self._process.stdin is not None
        # If it died, its closed output is read next and settles the design.
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()

    def read(self) -> dict[str, Any] | Loss:
        """Read the answer, which must be there; a loss if the process is gone instead, or cannot work."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line.endswith(b"\n"):
            return self._lose(f"the worker process {_ending(self._process.wait())}")
        answer: dict[str, Any] = json.loads(line)
        if "lost" in answer:  # memory or disk ran out: the next design gets a fresh process
            return self._lose(answer["lost"])
        return answer

    def watch(self, limits: Limits) -> Loss | None:
        """Look at time and memory: a loss if the process had to be ended."""
        if self.seconds > limits.seconds:
            return self._lose(f"took longer than the limit of {limits.seconds:g} s")
        if limits.memory is None or self._memory is None:
            return None
        with contextlib.suppress(psutil.Error):  # gone: its closed output says so
            self._peak = max(self._peak, float(self._memory.memory_info().rss))
        if self._peak > limits.memory:
            return self._lose(
                f"took {self._peak / GIGABYTE:.2f} GB of memory, more than the limit of "
                f"{limits.memory / GIGABYTE:g} GB"
            )
        return None

    @property
    def seconds(self) -> float:
        """Seconds since the last design was given."""
        return time.monotonic() - self._started

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def compute(self, request: Mapping[str, Any], limits: Limits) -> dict[str, Any] | Loss:
        """Compute one design and wait for it."""
        self.give(request)
        while True:
            ready, _, _ = select.select([self], [], [], WATCH)
            if ready:
                return self.read()
            loss = self.watch(limits)
            if loss is not None:
                return loss

    def kill(self) -> None:
        """Kill the process; whoever waits for its answer finds it gone."""
        self._process.kill()

    def end(self) -> None:
        """End the process, whatever it does."""
        end_child(self._process)

    def _lose(self, reason: str) -> Loss:
        loss = Loss(reason, self.seconds)
        self.end()
        return loss


def _ending(code: int) -> str:
    name = signal_name(code)
    if name is None:
        return f"died (exit code {code})"
    hint = ", as the system does when memory runs out" if name == "SIGKILL" else ""
    return f"was ended by {name}{hint}"


def spawn_worker() -> subprocess.Popen[bytes]:
    """Start a worker process; with one thread, so that its results do not depend on the machine."""
    return start_child(
        "regression.runs.worker",
        environment=ONE_THREAD,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
