"""Who follows jobs: one look at each job serves all of them."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable

from pydantic_core import to_json

from crankfem.service.answers import ENDED
from crankfem.service.job_store import JobStore
from crankfem.service.problems import ProblemError

LOOK, PING = 0.1, 15.0  # seconds between two looks at the jobs, between two signs of life


class _Followed:
    """A job that is followed: its record as JSON, and whom to wake at its next change."""

    def __init__(self) -> None:
        self.followers = 0
        self.text, self.over = b"", False
        self.changed = asyncio.Event()

    def change(self, text: bytes, over: bool) -> None:
        if (text, over) != (self.text, self.over):
            self.text, self.over = text, over
            self.wake()

    def wake(self) -> None:
        self.changed.set()
        self.changed = asyncio.Event()


class Followers:
    """All streams of progress.

    Parameters
    ----------
    store : JobStore
    stopping : callable
        Whether the service ends, and all streams with it.
    """

    def __init__(self, store: JobStore, stopping: Callable[[], bool]) -> None:
        self._store, self._stopping = store, stopping
        self._jobs: dict[str, _Followed] = {}
        self._watch: asyncio.Task[None] | None = None

    async def follow(self, name: str) -> AsyncIterator[bytes]:
        """Yield the record of a job at each change and from time to time, until it has ended."""
        job = self._jobs.setdefault(name, _Followed())
        job.followers += 1
        if self._watch is None or self._watch.done():
            self._watch = asyncio.create_task(self._watching())
        told, when = b"", time.monotonic()
        try:
            while True:
                changed = job.changed
                if job.text and (job.text != told or time.monotonic() - when > PING / 2):
                    told, when = job.text, time.monotonic()
                    yield told
                elif job.over:
                    return
                else:
                    await changed.wait()
        finally:
            job.followers -= 1
            if not job.followers:
                del self._jobs[name]

    async def _watching(self) -> None:
        """Look at all jobs that are followed, beside the other requests, as long as there are some."""
        pinged = time.monotonic()
        while self._jobs:
            over = self._stopping()
            found = await asyncio.to_thread(self._look, list(self._jobs))
            ping = time.monotonic() - pinged >= PING
            for name, job in self._jobs.items():
                text, ended = found.get(name, (job.text, False))
                job.change(text, ended or over)
                if ping:
                    job.wake()
            pinged = time.monotonic() if ping else pinged
            await asyncio.sleep(LOOK)

    def _look(self, names: list[str]) -> dict[str, tuple[bytes, bool]]:
        """Return the records of jobs, and which of them have ended or are gone."""
        found = {}
        for name in names:
            try:
                job = self._store.job(name)
            except (OSError, ProblemError):
                continue  # the next look may find it
            found[name] = (b"", True) if job is None else (to_json(job), job.state in ENDED)
        return found
