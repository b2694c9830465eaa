"""A study on a Dask cluster: one design at a time for each of its workers.

The coordinator assigns the designs itself. Dask would give a design whose worker is lost to the next
worker, and the next, and a stored result could be computed again with its lost worker:
so each task is bound to its worker, attempts are counted here, and a result is stored, then released.
On the worker's machine the design runs in the same supervised process as it would locally.
"""

import atexit
import contextlib
import logging
import re
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Protocol

from crankbase.calls import Limits, ProcessLostError
from crankbase.errors import InputError, MissingLibraryError
from crankbase.processes import once_per_process
from regression.plans.plan import MODEL_VERSION
from regression.records import Outcome, StudyStoppedError
from regression.runs.workers import (
    Claim,
    SupervisedProcess,
    WorkQueue,
    interrupts_deferred,
    interrupts_ignored,
)

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
        """Compute one design for a run: ``worker``, and ``answer`` or ``lost`` with ``seconds``."""
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


@once_per_process
def shared_process_pool() -> ProcessPool:
    """Return the pool common to all threads of this process; a forked child gets its own."""
    pool = ProcessPool()
    atexit.register(pool.close)
    return pool


# Seconds between two looks at the tasks if none has woken the loop, and at the list of workers.
WAKE, LOOK = 0.5, 1.0
# Seconds beyond the time limit after which a worker that has not answered is given up.
GRACE = 60.0
# Seconds without any worker before it is said, and between two reminders.
QUIET, REMIND = 5.0, 60.0
# What decides the last digits of a result beside crankfem itself.
LIBRARIES = ("gmsh", "numpy", "scipy", "scikit-fem", "pypardiso", "mkl")

Note = Callable[[str], None]


class TaskLostError(Exception):
    """A design's worker is lost, or its result is; the text states which."""


class Task(Protocol):
    """A design in progress on a cluster."""

    def done(self) -> bool:
        """Whether a result can be fetched."""

    def result(self) -> dict[str, Any]:
        """Fetch the result of `compute_design`; `TaskLostError` if there is nothing."""

    def release(self) -> None:
        """Release it on the cluster, finished or not."""


class Cluster(Protocol):
    """Machines that compute designs."""

    def places(self) -> Mapping[str, bool]:
        """Present workers, and whether each accepts designs; `StudyStoppedError` if the cluster is gone."""

    def submit(self, place: str, request: Mapping[str, Any], limits: Limits) -> Task:
        """Assign a design to a worker."""

    def wait(self, seconds: float) -> None:
        """Wait until a task may be done, up to a time."""


@cache
def identity() -> dict[str, Any]:
    """Versions that must be equal on coordinator and worker, and those that should."""
    return {
        "model_version": MODEL_VERSION,
        "crankfem": _version("crankfem"),
        "libraries": {name: _version(name) for name in LIBRARIES},
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def compute_design(
    run: str, request: Mapping[str, Any], limits: Limits, coordinator: Mapping[str, Any]
) -> dict[str, Any]:
    """Compute a design on a worker's machine; see `ProcessPool.compute` for the result.

    A worker of another model version, or release, computes nothing and returns its identity alone.
    """
    here = identity()
    if any(here[name] != coordinator[name] for name in ("model_version", "crankfem")):
        return {"identity": here}
    return shared_process_pool().compute(run, request, limits) | {"identity": here}


async def end_run(run: str) -> None:
    """End the calculations of a stopped run on a worker's machine."""
    shared_process_pool().end_run(run)


@dataclass
class _RunningDesign:
    """A design in progress: its key, its task, and its start time."""

    key: str
    task: Task
    since: float = field(default_factory=time.monotonic)


class _Dispatch:
    """The designs of one run on a cluster, assigned and collected."""

    def __init__(self, work: WorkQueue, cluster: Cluster, limits: Limits, note: Note) -> None:
        self.work, self.cluster, self.limits, self.note = work, cluster, limits, note
        self.running: dict[str, _RunningDesign] = {}
        # Why a worker cannot take part: raised when what the others have finished is stored.
        self.refusal: InputError | None = None
        self._places: Mapping[str, bool] = {}
        self._looked = -LOOK
        # Workers that did not answer in time, and until when they get nothing.
        self._set_aside: dict[str, float] = {}
        self._next_reminder = time.monotonic() + QUIET
        self._warned: set[str] = set()

    def collect(self) -> list[tuple[Outcome | None, Task]]:
        """Settle the tasks that are done, lost or overdue."""
        settled = []
        for place, running in list(self.running.items()):
            if running.task.done():
                outcome = self._fetch(place, running)
            elif place not in self._places:
                outcome = self._lose(place, running, "the cluster lost the worker")
            elif time.monotonic() - running.since > self.limits.seconds + GRACE:
                waited = time.monotonic() - running.since
                self._set_aside[place] = time.monotonic() + self.limits.seconds
                self.note(f"worker {place} has not answered for {waited:.0f} s: set aside")
                outcome = self._lose(
                    place, running, f"the worker did not answer for {waited:.0f} s"
                )
            else:
                continue
            del self.running[place]
            settled.append((outcome, running.task))
        return settled

    def assign_designs(self) -> None:
        """Assign a design to every free worker; `InputError` if one was refused."""
        if self.refusal is not None:
            raise self.refusal
        now = time.monotonic()
        if now - self._looked >= LOOK:
            self._places, self._looked = self.cluster.places(), now
        if self._places:
            self._next_reminder = now + QUIET
        elif now >= self._next_reminder:
            self._next_reminder = now + REMIND
            stops = "" if interrupts_ignored() else " (Ctrl-C stops)"
            self.note(f"the cluster has no workers; waiting for one{stops}")
        free = {place for place, takes in self._places.items() if takes} - self.running.keys()
        for place in sorted(free):
            if now < self._set_aside.get(place, 0.0):
                continue
            request = self.work.next_request()
            if request is None:
                return
            task = self.cluster.submit(place, request, self.limits)
            self.running[place] = _RunningDesign(request["key"], task)

    def _fetch(self, place: str, running: _RunningDesign) -> Outcome | None:
        try:
            answer = running.task.result()
        except TaskLostError as error:
            return self._lose(place, running, str(error))
        except InputError as error:
            self.refusal = self.refusal or error
            return None
        if "answer" not in answer and "lost" not in answer:
            here, there = identity(), answer["identity"]
            self.refusal = self.refusal or InputError(
                f"dask: given a cluster whose worker {place} has crankfem {there['crankfem']} with model "
                f"version {there['model_version']}; allowed is the coordinator's crankfem "
                f"{here['crankfem']} with model version {here['model_version']}, because results of "
                "different models must not be mixed."
            )
            return None
        self._compare(place, answer["identity"])
        if "lost" in answer:
            return self.work.lost(running.key, answer["lost"], answer["seconds"], answer["worker"])
        return self.work.outcome(answer["answer"], answer["worker"])

    def _lose(self, place: str, running: _RunningDesign, reason: str) -> Outcome | None:
        return self.work.lost(running.key, reason, time.monotonic() - running.since, place)

    def _compare(self, place: str, there: Mapping[str, Any]) -> None:
        """Warn once of a worker whose libraries differ, and with them the last digits."""
        here = identity()["libraries"]
        other = [f"{n} {v}" for n, v in there["libraries"].items() if here.get(n) != v]
        if other and place not in self._warned:
            self._warned.add(place)
            self.note(
                f"worker {place} has other libraries than the coordinator ({', '.join(other)}): its "
                "results may differ in the last digits"
            )


def run_on_cluster(
    designs: Iterable[tuple[str, Mapping[str, Any]]],
    on_outcome: Callable[[Outcome], None],
    cluster: Cluster,
    limits: Limits,
    note: Note,
    claim: Claim | None = None,
) -> None:
    """Compute designs (key, inputs) on a cluster, as `run_designs` does on this machine.

    `note` is called with notes for the user, such as that there are no workers.

    Raises
    ------
    InputError
        If a worker has another crankfem, or none.
    StudyStoppedError
        If the cluster is gone.
    """
    work = WorkQueue(designs, claim)
    dispatch = _Dispatch(work, cluster, limits, note)
    try:
        while len(work) or dispatch.running:
            settled: list[tuple[Outcome | None, Task]] = []
            try:
                with interrupts_deferred():
                    settled = dispatch.collect()
                # The workers go on while the answers are stored.
                dispatch.assign_designs()
            finally:  # whatever becomes of the cluster, or of another worker
                with interrupts_deferred():
                    for outcome, task in settled:
                        if outcome is not None:
                            on_outcome(outcome)
                        task.release()
            if not settled:
                cluster.wait(WAKE)
    finally:
        for running in dispatch.running.values():
            running.task.release()


# Seconds to wait for the scheduler to answer, and for a result that it says is there.
CONNECT, FETCH = 10.0, 30.0
# Results that are fetched at a time.
FETCHERS = 16
# Schemes of Dask's addresses; one within a process alone is none that a study could share.
ADDRESS = re.compile(
    r"(?:(?:tcp|tls|ucx|ucxx|ws|wss)://)?(?:[\w.-]+|\[[0-9A-Fa-f:.%]+\]):(\d{1,5})"
)


# Dask may report a result just when it has been lost with its worker, and then wait for it: only the thread
# that fetches it waits.
class _DaskTask:
    """A design in progress as a future of Dask, whose result is fetched in a separate thread."""

    def __init__(self, place: str, future: Any, fetchers: Executor, fetched: Callable[[], None]):
        self._place, self._future, self._fetched = place, future, fetched
        self._found: dict[str, Any] | Exception | None = None

        def fetch_later(_: Any) -> None:
            with contextlib.suppress(RuntimeError):  # the cluster has been left
                fetchers.submit(self._fetch)

        future.add_done_callback(fetch_later)

    def done(self) -> bool:
        return self._found is not None

    def result(self) -> dict[str, Any]:
        assert self._found is not None
        if isinstance(self._found, Exception):
            raise self._found
        return self._found

    def release(self) -> None:
        with contextlib.suppress(Exception):  # the scheduler may be gone
            if self.done():
                self._future.release()
            else:
                self._future.cancel()

    def _fetch(self) -> None:
        try:
            self._found = self._future.result(timeout=FETCH)
        except (ImportError, AttributeError) as error:
            self._found = InputError(
                f"dask: given a cluster whose worker {self._place} cannot load crankfem ({error}); allowed "
                "are workers with the same crankfem as the coordinator's."
            )
        except Exception as error:  # whatever Dask says of a worker that is gone
            self._found = TaskLostError(
                f"the result was lost with its worker ({type(error).__name__}: {error})"
            )
        self._fetched()


def silence_dask_log() -> None:
    """Silence Dask's own log: what matters of it is said by us, in sentences."""
    with contextlib.suppress(ImportError):
        import_module("distributed")  # sets the levels of its loggers when it is first loaded
    for name in list(logging.root.manager.loggerDict):
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def check_address(address: object) -> str:
    """Address of a Dask scheduler if it has the form of one, ``tcp://10.0.0.1:8786``; else `InputError`."""
    matched = ADDRESS.fullmatch(address) if isinstance(address, str) else None
    if not isinstance(address, str) or matched is None or not 1 <= int(matched[1]) <= 65535:
        raise InputError(
            f"dask: given {address!r}; allowed is the address of a running Dask scheduler, like "
            "tcp://10.0.0.1:8786: a host and a port, with tcp, tls, ucx, ws or wss in front."
        )
    return address


class DaskCluster:
    """The workers of a Dask cluster, by its scheduler's address.

    Raises
    ------
    InputError
        If this is not an address, or no scheduler responds there.
    MissingLibraryError
        If the package distributed is not installed.
    """

    def __init__(self, address: str) -> None:
        check_address(address)
        try:
            from distributed import Client
        except ImportError:
            raise MissingLibraryError(
                "dask: given, but the package distributed is not installed; install it with: "
                "pip install 'crankfem[cluster]'"
            ) from None
        self.address = address
        self.run = uuid.uuid4().hex[:12]
        self._tasks = 0
        self._wake = threading.Event()
        self._fetchers = ThreadPoolExecutor(FETCHERS, thread_name_prefix="crankfem-fetch")
        # Made in two steps: a client that fails halfway must be closed, or it complains when it is
        # collected.
        client: Any = Client.__new__(Client)
        self._client = client
        try:
            client.__init__(address, timeout=CONNECT, set_as_default=False, name="crankfem")
        except (OSError, ValueError, TypeError) as error:
            self.close()
            why = f"nothing answers there ({type(error).__name__})"
            if address.startswith("tls"):
                why += ", or not to the certificate that Dask's configuration names on this machine"
            raise InputError(
                f"dask: given {address!r}; allowed is the address of a running Dask scheduler, like "
                f"tcp://10.0.0.1:8786, because {why}."
            ) from None

    def places(self) -> dict[str, bool]:
        """List the addresses of the workers, and whether each accepts designs."""
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"]
        except Exception:  # whatever Dask says when it loses its scheduler
            raise self._gone() from None
        if self._client.status not in ("running", "connecting"):
            raise self._gone()
        return {address: about["status"] == "running" for address, about in workers.items()}

    def submit(self, place: str, request: Mapping[str, Any], limits: Limits) -> Task:
        """Assign a design to a worker."""
        self._tasks += 1
        future = self._client.submit(
            compute_design,
            self.run,
            request,
            limits,
            identity(),
            workers=[place],
            allow_other_workers=False,
            pure=False,
            retries=0,
            key=f"crankfem-{self.run}-{self._tasks}",
        )
        return _DaskTask(place, future, self._fetchers, self._wake.set)

    def wait(self, seconds: float) -> None:
        """Wait until a task may be done, up to a time."""
        self._wake.wait(seconds)
        self._wake.clear()

    def close(self) -> None:
        """Leave the cluster; designs in progress for this run are ended."""
        with contextlib.suppress(Exception):  # the scheduler may be gone
            if self._client.status == "running":
                self._client.run(end_run, self.run, wait=False, on_error="ignore")
        self._fetchers.shutdown(wait=False, cancel_futures=True)
        with contextlib.suppress(Exception):
            self._client.close(timeout=CONNECT)

    def _gone(self) -> StudyStoppedError:
        return StudyStoppedError(
            f"dask: the scheduler at {self.address} is gone; finished designs are kept, and the same "
            "command continues when it is back."
        )
