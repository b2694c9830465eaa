"""Keep an interrupt (Ctrl-C) out of the moment between the arrival of a result and its being on disk."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


def interrupts_ignored() -> bool:
    """Whether Ctrl-C does nothing here, as under nohup and in jobs that a shell runs in the background."""
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Let an interrupt wait until the block is done.

    What else handles interrupts then, or ignores them, does so at its end. On any thread but the main
    one nothing is done, for interrupts reach the main one alone.
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
