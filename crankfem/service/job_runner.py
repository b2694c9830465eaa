"""Runs jobs one after another in worker processes: a failure of one affects neither service nor others."""

import contextlib
import shutil
import threading
from collections.abc import Mapping
from typing import Any

from crankbase.calls import CallProcess, Limits, ProcessLostError, answered
from crankbase.errors import InputError
from crankfem.service.bounds import Bounds
from crankfem.service.job_store import JobStore
from crankfem.service.problems import field_errors, problem
from regression.runs.supervised import spawn_worker

# A job whose process was lost is tried once more; one that the service did not outlive, too.
TRIES = 2
LOOK = 1.0  # seconds between two looks for work, where nobody calls
LOADING = 120.0  # seconds that a process may take until it is ready
LOST_WITH_SERVICE = problem(500, f"The service ended {TRIES} times while this job ran.")


class JobRunner:
    """Runs the jobs of a store.

    Parameters
    ----------
    store : JobStore
    bounds : Bounds
    """

    def __init__(self, store: JobStore, bounds: Bounds) -> None:
        self._store, self._bounds = store, bounds
        self._work = threading.Condition()
        self._stopping = False
        # Why the process of a job was ended from here.
        self._ended: dict[str, str] = {}
        self._running: dict[str, CallProcess] = {}
        self._threads = [
            threading.Thread(target=self._run, daemon=True) for _ in range(bounds.running)
        ]

    def start(self) -> None:
        """Begin; jobs that ran when the last service ended go on."""
        self._store.queue_again(TRIES + 1, LOST_WITH_SERVICE)
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End; jobs that run wait for the next service."""
        with self._work:
            self._stopping = True
            for process in self._running.values():
                process.kill()
            self._work.notify_all()
        for thread in self._threads:
            thread.join()

    def announce_stop(self) -> None:
        """Let those who follow jobs go, and begin no other job."""
        self._stopping = True

    @property
    def stopping(self) -> bool:
        """Whether the service ends."""
        return self._stopping

    def submit(self, kind: str, title: str, question: Mapping[str, Any]) -> str | None:
        """Let a job wait; None where too many do."""
        name = self._store.add(kind, title, question, self._bounds.waiting)
        with self._work:
            self._work.notify()
        return name

    def cancel(self, name: str) -> None:
        """End a job that waits or runs."""
        with self._work:
            process = self._running.get(name)
            if process is not None:
                self._ended[name] = "canceled"
                process.kill()
                return
            job = self._store.job(name)
            if job is not None and job.state == "queued":
                self._store.end(name, "canceled")

    def remove(self, name: str) -> None:
        """Forget a job that has ended, with its files."""
        self._store.remove(name)
        shutil.rmtree(self._store.place(name), ignore_errors=True)

    def _run(self) -> None:
        process: CallProcess | None = None
        while not self._stopping:
            if process is None or not process.alive:
                process = _started()
            with self._work:
                taken = None if self._stopping else self._store.start_next()
                if taken is None:
                    if not self._stopping:
                        self._work.wait(LOOK)
                    continue
                self._running[taken[0]] = process
            self._do(process, *taken)
        if process is not None:
            process.end()

    def _do(self, process: CallProcess, name: str, kind: str, question: Mapping[str, Any]) -> None:
        """Have a process do a job, and note how that ended."""
        bounds, folder = self._bounds, str(self._store.place(name).absolute())
        process.give(
            "crankfem.service.tasks:run_job", kind, question, folder, bounds.workers, remarks=True
        )
        timer = threading.Timer(bounds.job_seconds, self._expire, (name,))
        timer.daemon = True
        timer.start()
        try:
            limits = Limits(bounds.job_seconds, bounds.job_memory, tree=True)
            answered(*process.wait(limits, lambda told: self._note(name, told)))
        except ProcessLostError as lost:
            self._settle(name, lost)
        except InputError as error:
            told = problem(422, error.sentences[0], field_errors(error))
            self._store.end(name, "failed", told)
        except Exception as error:  # the job failed, with its reason; the service goes on
            self._store.end(name, "failed", problem(500, str(error)))
        else:
            self._store.end(name, "done")
        finally:
            timer.cancel()
            with self._work:
                del self._running[name]
                self._ended.pop(name, None)

    def _settle(self, name: str, lost: ProcessLostError) -> None:
        """Record the end of a job whose process is gone."""
        job, ended = self._store.job(name), self._ended.get(name)
        if ended == "canceled":
            self._store.end(name, "canceled")
        elif ended == "expired":
            detail = f"The job took longer than the limit of {self._bounds.job_seconds:g} s."
            self._store.end(name, "failed", problem(500, detail))
        elif self._stopping:
            # It was no fault of the job's: this time does not count.
            attempts = 1 if job is None else job.attempts
            self._store.change(name, state="queued", attempts=attempts - 1)
        elif job is not None and job.attempts < TRIES:
            self._store.note(name, f"Tried again, because {lost}.")
            self._store.change(name, state="queued")
        else:
            self._store.end(name, "failed", problem(500, f"The job was lost: {lost}."))

    def _note(self, name: str, told: Mapping[str, Any]) -> None:
        if "note" in told:
            self._store.note(name, told["note"])
        else:
            self._store.change(name, **told)

    def _expire(self, name: str) -> None:
        with self._work:
            process = self._running.get(name)
            if process is not None:
                self._ended[name] = "expired"
                process.kill()


def _started() -> CallProcess:
    """Start a worker process as studies have them, and let it load what jobs need."""
    process = CallProcess(spawn_worker(), "the worker process")
    process.give("crankfem.service.tasks:load")
    with contextlib.suppress(Exception):  # told again by the first job
        answered(*process.wait(Limits(LOADING)))
    return process
