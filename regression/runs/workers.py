"""Local worker processes: a crash or a hang costs one design, not the study."""

import selectors
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from regression.records import Outcome
from regression.runs.interrupts import interrupts_deferred
from regression.runs.supervised import WATCH, Limits, Loss, SupervisedProcess
from regression.runs.work_list import WorkList


def run_designs(
    designs: Iterable[tuple[str, Mapping[str, Any]]],
    on_outcome: Callable[[Outcome], None],
    workers: int,
    limits: Limits | None = None,
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
    limits : Limits, optional
        What one design may take before its worker is ended.

    Notes
    -----
    A design whose worker dies, hangs or takes too much memory is tried once more in a fresh process,
    then recorded as lost, for a later run to try again. On an exception here (Ctrl-C included) all
    workers are ended; what arrived is kept, for Ctrl-C waits while an answer is taken and stored.
    """
    limits = limits or Limits()
    work = WorkList(designs)
    # Each process with the key of the design it works on.
    pool: dict[SupervisedProcess, str] = {}
    selector = selectors.DefaultSelector()

    def start() -> None:
        request = work.take()
        if request is not None:
            process = SupervisedProcess()
            pool[process] = request["key"]
            selector.register(process, selectors.EVENT_READ)
            process.give(request)

    def dismiss(process: SupervisedProcess) -> None:
        selector.unregister(process)
        process.end()
        del pool[process]

    def lose(process: SupervisedProcess, loss: Loss) -> None:
        outcome = work.lost(pool[process], loss.reason, loss.seconds, process.name)
        dismiss(process)
        start()
        if outcome is not None:
            on_outcome(outcome)

    def settle(process: SupervisedProcess) -> None:
        answer = process.read()
        if isinstance(answer, Loss):
            lose(process, answer)
            return
        # The process works on while the answer is stored.
        request = work.take()
        if request is None:
            dismiss(process)
        else:
            pool[process] = request["key"]
            process.give(request)
        on_outcome(work.answered(answer, process.name))

    try:
        for _ in range(min(workers, len(work))):
            start()
        while pool:
            for event, _ in selector.select(timeout=WATCH):
                assert isinstance(event.fileobj, SupervisedProcess)
                with interrupts_deferred():
                    settle(event.fileobj)
            for process in list(pool):
                loss = process.watch(limits)
                if loss is not None:
                    lose(process, loss)
    finally:
        for process in pool:
            process.end()
        selector.close()
