"""Runs jobs one after another in worker processes: a failure of one affects neither service nor others."""

import contextlib
import os
import threading
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crankbase.calls import CallProcess, Limits, ProcessLostError, answered
from crankbase.errors import InputError
from crankfem.satellites.service.asking import ProblemError, field_errors, problem
from crankfem.satellites.service.guard import Bounds, log_line
from crankfem.satellites.service.job_store import FULL, NO_SPACE, JobStore, StoreError
from regression.runs.workers import spawn_worker

# A job whose process was lost is tried once more; one that the service did not outlive, too. One that finds
# the disk full waits for space several times.
TRIES, FULL_TRIES = 2, 8
LOOK = 1.0  # seconds between two looks for work, where nobody calls
LOADING = 120.0  # seconds that a process may take until it is ready
# Seconds before the second try of what failed at once again; each further one waits twice as long.
PAUSE, LONGEST_PAUSE = 1.0, 60.0
# Worker processes that are lost before they have work, until no more are started unless a job is submitted.
STARTS = 8
LOST_WITH_SERVICE = problem(500, f"The service ended {TRIES} times while this job ran.")
# What an error of a worker says where its disk is full.
FULL_WORDS = (*(os.strerror(number) for number in NO_SPACE), "database or disk is full")


class JobRunner:
    """Runs the jobs of a store."""

    def __init__(self, store: JobStore, bounds: Bounds) -> None:
        self._store, self._bounds = store, bounds
        self._work = threading.Condition()
        # Whether the service ends: no other job begins, and those who follow jobs are let go.
        self.stopping, self._recovered = False, False
        self._ending = threading.Event()
        # By thread: why it does not run jobs, since when, and whether it has given up.
        self._troubles: dict[int, tuple[str, float, bool]] = {}
        # Why the process of a job was ended from here.
        self._ended: dict[str, str] = {}
        self._running: dict[str, CallProcess] = {}
        # How often a job found the disk full.
        self._filled: Counter[str] = Counter()
        self._threads = [
            threading.Thread(target=self._run, args=(place,), daemon=True)
            for place in range(bounds.running)
        ]

    def start(self) -> None:
        """Begin; jobs that ran when the last service ended go on."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End; jobs that run wait for the next service."""
        with self._work:
            self.stopping = True
            self._ending.set()
            for process in self._running.values():
                process.kill()
            self._work.notify_all()
        for thread in self._threads:
            thread.join()

    def health(self) -> dict[str, Any]:
        """Return whether jobs run, and what is wrong."""
        with contextlib.suppress(StoreError):
            self._store.check()
        troubles = list(self._troubles.values())
        problems = [text for text, _, _ in troubles]
        if self._store.trouble is not None:
            problems.append(self._store.trouble)
        since = [since for _, since, _ in troubles] or ([time.time()] if problems else [])
        return {
            "state": "stopped" if self._stopped() else "retrying" if problems else "ok",
            "problems": list(dict.fromkeys(problems)),
            "since": min(since, default=None),
            "queued": self._store.count("queued"),
            "running": self._store.count("running"),
        }

    def _stopped(self) -> str | None:
        """Why no thread starts processes any more; None while one does."""
        troubles = list(self._troubles.values())
        if len(troubles) < len(self._threads) or not all(gave_up for _, _, gave_up in troubles):
            return None
        return troubles[0][0]

    def submit(self, kind: str, title: str, question: Mapping[str, Any]) -> str | None:
        """Let a job wait; None where too many do.

        Raises
        ------
        ProblemError
            If jobs do not run, or this one cannot be recorded.
        """
        stopped = self._stopped()
        name = None if stopped else self._store.add(kind, title, question, self._bounds.waiting)
        with self._work:
            self._work.notify()
        if stopped:
            raise ProblemError(503, f"{stopped} This is tried again now.")
        return name

    def cancel(self, name: str) -> None:
        """End a job that waits or runs."""
        with self._work:
            job = None if self._end(name, "canceled") else self._store.job(name)
            if job is not None and job.state == "queued":
                self._store.settle(name, "canceled")

    def _run(self, place: int) -> None:
        """Run jobs, whatever becomes of one, of its process or of the store, until the service ends."""
        process: CallProcess | None = None
        worked, tries, failed = False, 0, 0.0
        while not self.stopping:
            try:
                self._store.check()
                if process is None or not process.alive:
                    lost, process = process, None
                    if lost is not None and not worked:
                        raise ProcessLostError("the worker process ended before it had work")
                    process, worked = _started(self._store.folder), False
                taken = self._next(process)
            except Exception as error:
                tries = 1 if time.monotonic() - failed > LONGEST_PAUSE else tries + 1
                self._wait(place, error, tries)
                failed = time.monotonic()
                continue
            if self._troubles.pop(place, None) is not None:
                log_line(jobs="ok")
            if taken is not None:
                self._do(place, process, *taken)
                worked = True
        if process is not None:
            process.end()

    def _next(self, process: CallProcess) -> tuple[str, str, dict[str, Any], int] | None:
        """Take a job for a process, or wait for one."""
        with self._work:
            if self.stopping:
                return None
            if not self._recovered:
                self._store.queue_again(TRIES + 1, LOST_WITH_SERVICE)
                self._recovered = True
            taken = self._store.start_next()
            if taken is None:
                self._work.wait(LOOK)
            else:
                self._running[taken[0]] = process
            return taken

    def _wait(self, place: int, error: Exception, tries: int) -> None:
        """Tell what is wrong, and wait until it may be tried again."""
        gives_up = isinstance(error, ProcessLostError) and tries >= STARTS
        text = error.detail if isinstance(error, StoreError) else f"Jobs do not run: {error}."
        before = self._troubles.get(place)
        if before is None or before[0] != text or before[2] != gives_up:
            since = time.time() if before is None else before[1]
            self._troubles[place] = text, since, gives_up
            log_line(jobs="stopped" if gives_up else "retrying", problem=text)
        if not gives_up:
            self._ending.wait(min(PAUSE * 2 ** min(tries - 1, STARTS), LONGEST_PAUSE))
            return
        with self._work:
            if not self.stopping:
                self._work.wait()  # for a job that is submitted

    def _do(
        self,
        place: int,
        process: CallProcess,
        name: str,
        kind: str,
        question: Mapping[str, Any],
        attempts: int,
    ) -> None:
        """Have a process do a job, and record how that ended, as soon as it can be."""
        timer = threading.Timer(self._bounds.job_seconds, self._end, (name, "expired"))
        timer.daemon = True
        # Notes that could not be recorded when they were made.
        notes: list[str] = []
        try:
            timer.start()
            settled = self._settled(process, name, kind, question, attempts, notes)
        except Exception as error:
            process.kill()  # it may still be at work
            settled = _failed(500, f"The job was lost: {error}.")
        finally:
            timer.cancel()
            with self._work:
                del self._running[name]
                self._ended.pop(name, None)
        tries = 0
        while not (tries and self.stopping):
            try:
                self._store.settle(name, **settled, notes=notes)
            except Exception as error:
                tries += 1
                self._wait(place, error, tries)
            else:
                break
        if settled["state"] != "queued":
            self._filled.pop(name, None)
        elif self._filled[name]:
            self._wait(place, StoreError(507, FULL), self._filled[name] + 2)

    def _settled(
        self,
        process: CallProcess,
        name: str,
        kind: str,
        question: Mapping[str, Any],
        attempts: int,
        notes: list[str],
    ) -> dict[str, Any]:
        """Have a process do a job, and return what is to be recorded of its end."""
        bounds, folder = self._bounds, str(self._store.place(name))

        def tell(change: Mapping[str, Any]) -> None:
            try:
                if "note" in change:
                    self._store.note(name, change["note"])
                else:
                    self._store.change(name, **change)
            except StoreError:  # kept in `trouble`; the job goes on
                if "note" in change:
                    notes.append(change["note"])

        process.give(
            "crankfem.satellites.service.tasks:run_job",
            kind,
            question,
            folder,
            bounds.workers,
            remarks=True,
        )
        response = None
        try:
            limits = Limits(bounds.job_seconds, bounds.job_memory, tree=True)
            response = process.wait(limits, tell)
            answered(*response)
        except ProcessLostError as lost:
            ended, reason = self._ended.get(name), str(lost)
            if ended == "canceled":
                return {"state": "canceled"}
            if ended == "expired":
                return _failed(
                    500, f"The job took longer than the limit of {bounds.job_seconds:g} s."
                )
            if self.stopping:
                # It was no fault of the job's: this time does not count.
                return {"state": "queued", "attempts": attempts - 1}
            if attempts >= TRIES:
                return _failed(500, f"The job was lost: {reason}.")
            notes.append(f"Tried again, because {reason}.")
            return {"state": "queued"}
        except Exception as error:  # the job failed, with its reason; the service goes on
            if response is None:
                raise  # a fault of the service's own
            if isinstance(error, InputError) and not _is_full(error):
                return _failed(422, error.sentences[0], field_errors(error))
            if not _is_full(error):
                return _failed(500, str(error))
            self._filled[name] += 1
            if self._filled[name] >= FULL_TRIES:
                return _failed(507, FULL)
            if self._filled[name] == 1:
                notes.append("Tried again, because the disk of the service was full.")
            return {"state": "queued", "attempts": attempts - 1}
        return {"state": "done"}

    def _end(self, name: str, why: str) -> bool:
        """End a job's process, and return whether it has one."""
        with self._work:
            process = self._running.get(name)
            if process is not None:
                self._ended[name] = why
                process.kill()
            return process is not None


def _is_full(error: Exception) -> bool:
    return any(words in str(error) for words in FULL_WORDS)


def _failed(status: int, detail: str, errors: list[dict[str, str]] | None = None) -> dict[str, Any]:
    return {"state": "failed", "problem": problem(status, detail, errors)}


def _started(folder: Path) -> CallProcess:
    """Start a worker process as studies have them, and let it load what jobs need."""
    try:
        process = CallProcess(spawn_worker(folder), "the worker process")
    except OSError as error:
        raise ProcessLostError(f"no worker process can be started ({error.strerror})") from None
    process.give("crankfem.satellites.service.tasks:load")
    try:
        answered(*process.wait(Limits(LOADING)))
    except ProcessLostError:
        raise
    except Exception:  # told again by the first job
        pass
    return process
