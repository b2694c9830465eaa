"""Times of the steps of a calculation."""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager


class Stopwatch:
    """Adds up the seconds of named pieces of work.

    Attributes
    ----------
    seconds : dict
        By name, in the order of first use.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def lap(self, name: str) -> Iterator[None]:
        """Measure the time of the block under this name, minus the named times inside it."""
        inside = sum(self.seconds.values())
        self.seconds.setdefault(name, 0.0)
        start = time.perf_counter()
        try:
            yield
        finally:
            named = sum(self.seconds.values()) - inside
            # Times taken elsewhere may be longer than the block, which then took none itself.
            self.seconds[name] += max(0.0, time.perf_counter() - start - named)

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add times measured elsewhere, such as in another process."""
        for name, value in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + value
