"""Progress messages of a run, and the duration of its steps."""

import time
from typing import Protocol

from regression.records import Outcome


class Progress(Protocol):
    """Progress messages of a run."""

    def step(self, text: str) -> None:
        """A new step begins."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """A design of the study is finished."""

    def note(self, text: str) -> None:
        """A note for the user."""

    def warn(self, text: str) -> None:
        """Data are lost or damaged, or the input looks wrong, which nobody should miss."""


class SilentProgress:
    """Silent progress: nothing is reported."""

    def step(self, text: str) -> None:
        """Ignore a step."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Ignore a design."""

    def note(self, text: str) -> None:
        """Ignore a note."""

    def warn(self, text: str) -> None:
        """Ignore a warning."""


class TimedProgress:
    """Timed progress: passes everything on and takes the time of the steps.

    Attributes
    ----------
    seconds : dict
        Step to the time it took [s].
    """

    def __init__(self, told: Progress) -> None:
        self._told = told
        self._began: tuple[str, float] | None = None
        self.seconds: dict[str, float] = {}

    def step(self, text: str) -> None:
        """End one step and begin the next."""
        self.stop()
        self._began = (text, time.perf_counter())
        self._told.step(text)

    def stop(self) -> None:
        """Take the time of the step that has ended."""
        if self._began is not None:
            text, began = self._began
            self.seconds[text] = self.seconds.get(text, 0.0) + time.perf_counter() - began
            self._began = None

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Pass on that a design is finished."""
        self._told.design(finished, total, newest)

    def note(self, text: str) -> None:
        """Pass a note on."""
        self._told.note(text)

    def warn(self, text: str) -> None:
        """Pass a warning on."""
        self._told.warn(text)
