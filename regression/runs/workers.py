"""Local worker processes: a crash or a hang costs one design, not the study."""

import contextlib
from collections.abc import Callable, Iterable, Mapping
from queue import Empty, SimpleQueue
from typing import Any

from crankbase.calls import WATCH, Limits, Message, Messages, ProcessLostError
from regression.records import Outcome
from regression.runs.interrupts import interrupts_deferred
from regression.runs.supervised import TIME_LIMIT, SupervisedProcess
from regression.runs.work_queue import Claim, WorkQueue


def run_designs(
    designs: Iterable[tuple[str, Mapping[str, Any]]],
    on_outcome: Callable[[Outcome], None],
    workers: int,
    limits: Limits | None = None,
    claim: Claim | None = None,
) -> None:
    """Compute designs in worker processes.

    Parameters
    ----------
    designs : iterable of (key, inputs)
        Designs to compute.
    on_outcome : callable
        Called in this process with each outcome as it arrives.
    workers : int
        Number of processes.
    limits : Limits, optional
        Limits of one design.
    claim : callable, optional
        As for `WorkQueue`: designs of other programs are waited for.

    Notes
    -----
    A design whose worker dies, hangs or uses too much memory is tried once more in a fresh process,
    then recorded as lost, for a later run to try again. On an exception here (Ctrl-C included) all
    workers are ended; results that arrived are kept, since Ctrl-C is delayed while one is stored.
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
