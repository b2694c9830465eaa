"""Delay an interrupt (Ctrl-C) between the arrival of a result and its storage on disk."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


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
