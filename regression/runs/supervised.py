"""One worker process under supervision: it computes a design, or is ended with the reason."""

import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crankbase.calls import GIGABYTE, CallProcess, Limits, Message, Messages, answered
from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from crankbase.processes import start_child

# Seconds that a design may take at 1 % accuracy before its worker counts as hanging.
TIME_LIMIT = 300.0
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("MKL", "OMP", "OPENBLAS")}
# Memory of one design is kept for the next: where the C library is GNU's, giving it back and asking for it
# again takes a twentieth of a worker's time.
KEPT_MEMORY = {"MALLOC_MMAP_THRESHOLD_": str(2**25), "MALLOC_TRIM_THRESHOLD_": str(2**29)}
# A worker cannot do with less: the libraries alone take a quarter of it.
SMALLEST_MEMORY = 0.5 * GIGABYTE


def design_limits(
    accuracy: float, time_limit: float | None = None, memory_limit: float | None = None
) -> Limits:
    """Make the limits of a study's designs.

    Parameters
    ----------
    accuracy : float
        Of the study: a finer mesh has a longer limit.
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


class SupervisedProcess(CallProcess):
    """A worker process that computes one design after another, until it is lost or ended.

    Parameters
    ----------
    messages : SimpleQueue, optional
        As for `CallProcess`.
    """

    def __init__(self, messages: Messages | None = None) -> None:
        super().__init__(spawn_worker(), "the worker process", messages)

    def compute(self, request: Mapping[str, Any]) -> None:
        """Send it a design."""
        self.give("regression.runs.worker:answer", request)

    def take(self, message: Message) -> tuple[str, Any]:
        """Return the response to a design; it is lost, too, if the machine could not compute it."""
        kind, content = super().take(message)
        try:
            answer = answered(kind, content)
        except RuntimeError as error:  # it could not even load what designs need
            self.lose(str(error))
        if "lost" in answer:  # memory or disk ran out: the next design gets a fresh process
            self.lose(answer["lost"])
        return kind, answer


def spawn_worker(folder: Path | None = None) -> subprocess.Popen[bytes]:
    """Start a worker process in a folder; with one thread, so that no result depends on the machine."""
    return start_child(
        "crankbase.calls",
        "geometry.built_solid:keep_solids",
        environment=ONE_THREAD | KEPT_MEMORY,
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
