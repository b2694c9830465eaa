"""Local worker processes: a crash or a hang costs one design, not the study."""

import contextlib
import math
import signal
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from types import FrameType
from typing import Any, TypedDict

from crankbase.calls import (
    GIGABYTE,
    WATCH,
    CallProcess,
    Limits,
    Message,
    Messages,
    ProcessLostError,
    answered,
)
from crankbase.choices import is_number
from crankbase.errors import InputError, NotEnoughMemoryError
from crankbase.processes import start_child
from fem.material import Material
from fem.responses import ThrowResponses, evaluate_throw
from geometry.mesher import mesh_here
from geometry.throw import CrankThrow
from regression.records import MESHED, MOVED, SLOPES, Outcome
from regression.runs.reference_meshes import ReferenceMeshes, mesh_digest, opened


def interrupts_ignored() -> bool:
    """Whether Ctrl-C is ignored, as under nohup and in background jobs of a shell."""
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Delay an interrupt until the block is done.

    Other handlers of interrupts are called at its end. On any thread but the main
    one this has no effect, since interrupts reach only the main thread.
    """
    handler = signal.getsignal(signal.SIGINT)
    if handler is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupted = False

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = True

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if interrupted:
            signal.raise_signal(signal.SIGINT)


# Seconds that a design may take at 1 % accuracy before its worker counts as hanging.
TIME_LIMIT = 300.0
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("MKL", "OMP", "OPENBLAS")}
# Memory of one design is kept for the next: where the C library is GNU's, giving it back and asking for it
# again takes a twentieth of a worker's time.
KEPT_MEMORY = {"MALLOC_MMAP_THRESHOLD_": str(2**25), "MALLOC_TRIM_THRESHOLD_": str(2**29)}
# A worker cannot do with less: the libraries alone take a quarter of it.
SMALLEST_MEMORY = 0.5 * GIGABYTE


class AskedLimits(TypedDict, total=False):
    """Limits that a user may ask for [s], [byte]; see `design_limits`."""

    time_limit: float | None
    memory_limit: float | None


def design_limits(
    accuracy: float, time_limit: float | None = None, memory_limit: float | None = None
) -> Limits:
    """Limits [s], [byte] of a study's designs; a finer mesh has a longer default.

    `InputError` if impossible.
    """
    for name, limit, kind in (
        ("time_limit", time_limit, "seconds, like 300"),
        ("memory_limit", memory_limit, "bytes, like 4e9"),
    ):
        if limit is not None and not is_number(limit):
            raise InputError(f"{name}: given {limit!r}; allowed is a finite number of {kind}.")
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
    """A worker process that computes one design after another, until it is lost or ended."""

    def __init__(self, messages: Messages | None = None) -> None:
        super().__init__(spawn_worker(), "the worker process", messages)

    def compute(self, request: Mapping[str, Any]) -> None:
        """Send it a design."""
        self.give("regression.runs.workers:answer", request)

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
        "geometry.mesh:keep_solids",
        environment=ONE_THREAD | KEPT_MEMORY,
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


# Claims a design: True if it is to be computed, False while another program computes it, None once it is
# finished.
Claim = Callable[[str], bool | None]

# A design is tried once more after its worker is lost, then set aside.
TRIES = 2


class WorkQueue:
    """Designs (key, inputs) to compute, handed out one by one, if `claim` of their key permits."""

    def __init__(
        self, designs: Iterable[tuple[str, Mapping[str, Any]]], claim: Claim | None = None
    ) -> None:
        self._claim: Claim = claim or (lambda _: True)
        self._references = ReferenceMeshes()
        self._inputs = dict(designs)
        self._waiting = deque(self._inputs)
        self._tries = dict.fromkeys(self._inputs, 0)

    def __len__(self) -> int:
        """Count the designs that wait."""
        return len(self._waiting)

    def next_request(self) -> dict[str, Any] | None:
        """Return the next design as a request to a worker; None if none is available now."""
        for _ in range(len(self._waiting)):
            key = self._waiting.popleft()
            claimed = self._claim(key)
            if claimed:
                self._tries[key] += 1
                inputs = self._inputs[key]
                return {"key": key, "inputs": inputs, "reference": self._references.of(inputs)}
            if claimed is False:
                self._waiting.append(key)
        return None

    def outcome(self, answer: Mapping[str, Any], worker: str) -> Outcome:
        """Make the outcome from a worker's response."""
        return self._outcome(
            answer["key"],
            responses=answer.get("responses"),
            reason=answer.get("reason"),
            seconds=answer["seconds"],
            errors=answer.get("errors") or {},
            unknowns=answer.get("unknowns"),
            worker=worker,
            slopes=answer.get("slopes") or {},
            slope_errors=answer.get("slope_errors") or {},
            mesh=answer.get("mesh") or {},
        )

    def lost(self, key: str, reason: str, seconds: float, worker: str) -> Outcome | None:
        """Take back a design whose worker is lost: None if it will be tried again, else its outcome."""
        if self._tries[key] < TRIES:
            self._waiting.append(key)
            return None
        return self._outcome(
            key, responses=None, reason=reason, seconds=seconds, lost=True, worker=worker
        )

    def _outcome(self, key: str, **results: Any) -> Outcome:
        return Outcome(key=key, inputs=self._inputs[key], attempts=self._tries[key], **results)


def run_designs(
    designs: Iterable[tuple[str, Mapping[str, Any]]],
    on_outcome: Callable[[Outcome], None],
    workers: int,
    limits: Limits | None = None,
    claim: Claim | None = None,
) -> None:
    """Compute designs (key, inputs) in worker processes; each outcome is given to `on_outcome` as it arrives.

    A design whose worker dies, hangs or uses too much memory is tried once more in a fresh process,
    then recorded as lost, for a later run to try again. Designs that `claim` leaves to other programs
    are waited for. On an exception here (Ctrl-C included) all workers are ended; results that arrived
    are kept, since Ctrl-C is delayed while one is stored.
    """
    limits = limits or Limits(TIME_LIMIT)
    work = WorkQueue(designs, claim)
    # Each process with the key of the design it works on.
    pool: dict[SupervisedProcess, str] = {}
    messages: Messages = SimpleQueue()

    def start() -> bool:
        request = work.next_request()
        if request is not None:
            process = SupervisedProcess(messages)
            pool[process] = request["key"]
            process.compute(request)
        return request is not None

    def record_loss(process: SupervisedProcess, loss: ProcessLostError) -> None:
        outcome = work.lost(pool.pop(process), str(loss), loss.seconds, process.name)
        start()
        if outcome is not None:
            on_outcome(outcome)

    def store_answer(process: SupervisedProcess, message: Message) -> None:
        try:
            _, answer = process.take(message)
        except ProcessLostError as loss:
            record_loss(process, loss)
            return
        # The process works on while the answer is stored.
        request = work.next_request()
        if request is None:
            del pool[process]
            process.end()
        else:
            pool[process] = request["key"]
            process.compute(request)
        on_outcome(work.outcome(answer, process.name))

    try:
        while pool or len(work):
            while len(pool) < workers and start():
                pass
            with contextlib.suppress(Empty):
                process, message = messages.get(timeout=WATCH)
                if process in pool:  # no last word of one that was ended
                    with interrupts_deferred():
                        store_answer(process, message)
            for process in list(pool):
                try:
                    process.watch(limits)
                except ProcessLostError as loss:
                    record_loss(process, loss)
    finally:
        for process in pool:
            process.end()


# Numbers of Pardiso's errors: no memory, within or for files; files that cannot be opened or written.
PARDISO_MACHINE = (-2, -9, -10, -11)


def evaluate_design(inputs: dict[str, Any], reference: bytes = b"") -> ThrowResponses:
    """Compute the responses of a design: fields of throw and material [SI], accuracy, stresses, slopes.

    `reference` is the mesh that is moved to it, of `ReferenceMeshes`.
    """
    return evaluate_throw(
        CrankThrow(**inputs["throw"]),
        Material(**inputs["material"]),
        inputs["accuracy"],
        inputs["stresses"],
        mesher=mesh_here,  # this process is expendable: gmsh needs none of its own
        slopes=inputs.get(SLOPES, ()),
        reference=opened(reference) if reference else None,
    )


def _numbers_only(numbers: dict[str, float], what: str = "") -> dict[str, float]:
    for name, value in numbers.items():
        if not math.isfinite(value):
            raise ArithmeticError(f"{what}{name} came out as {value}")
    return numbers


def _of_the_machine(error: BaseException | None) -> bool:
    """Whether an error is due to the machine (no memory, a full disk), not to the design."""
    while error is not None:
        # Without memory a library cannot be loaded either.
        if isinstance(error, MemoryError | OSError | ImportError | NotEnoughMemoryError):
            return True
        # Pardiso's own kind of error, known by its module: without Pardiso there is none.
        if type(error).__module__.startswith("pypardiso") and (
            getattr(error, "value", None) in PARDISO_MACHINE
        ):
            return True
        error = error.__cause__
    return False


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Handle the request for a design.

    The result has ``responses``, or the ``reason`` why the design has none, or ``lost``: the reason why the
    machine could not compute it, such as a full disk.
    """
    start = time.perf_counter()
    made: dict[str, Any]
    try:
        reference = request.get("reference", b"")
        evaluated = evaluate_design(request["inputs"], reference)
        mesh: dict[str, Any] = {}
        if MOVED in request["inputs"]:
            moved = evaluated.moved
            mesh = {"tier": MESHED}
            if moved is not None:
                mesh = {
                    "tier": moved.tier,
                    "quality": moved.quality,
                    "straightened": moved.straightened,
                    "reference": mesh_digest(opened(reference)),
                    "discrete": _numbers_only(evaluated.discrete),
                }
        made = {
            "responses": _numbers_only(evaluated.values),
            "errors": _numbers_only(evaluated.errors, "the error of "),
            "unknowns": evaluated.unknowns,
            "slopes": {
                name: _numbers_only(shares, f"the slope of {name} over ")
                for name, shares in evaluated.slopes.items()
            },
            "slope_errors": _numbers_only(evaluated.slope_errors, "the error of the slopes of "),
            "mesh": mesh,
        }
    except Exception as error:  # the design fails, with its reason; the worker goes on
        kind = "lost" if _of_the_machine(error) else "reason"
        made = {kind: f"{type(error).__name__}: {error}"}
    return {"key": request["key"], **made, "seconds": time.perf_counter() - start}
