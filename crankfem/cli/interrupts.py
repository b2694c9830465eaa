"""Interrupts: reported in one sentence, whatever Python is doing at that time."""

import atexit
import os
import signal
import sys
import threading
from _thread import interrupt_main
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from crankfem.jobs.exit_codes import EXIT_INTERRUPTED

# The command whose finished work is always kept and continued; of a run it depends on its file.
CONTINUED = "doe"
STANDARD_ERROR = 2
# In seconds.
A_MOMENT = 0.02


def interrupted_sentence() -> str:
    """The message for an interrupt, by the command."""
    if sys.argv[1:2] == [CONTINUED]:
        return "Stopped. Finished designs are kept; the same command continues where it stopped."
    return "Stopped."


def end_at_once(*_: object) -> None:
    """Handle an interrupt without raising an exception, which could print its traceback.

    Python prints an exception raised while an object is destroyed or a module is loaded, and
    continues.
    """
    os.write(STANDARD_ERROR, f"{interrupted_sentence()}\n".encode())
    # A module that is not loaded has written nothing.
    if (outputs := sys.modules.get("crankbase.outputs")) is not None:
        outputs.remove_unfinished()
    os._exit(EXIT_INTERRUPTED)


def exit_on_interrupts() -> None:
    """Let an interrupt end the process from now on, as long as nothing is open that would have to be closed.

    A request to end (SIGTERM), as schedulers and containers send it, is answered as Ctrl-C is.
    """
    usual = signal.getsignal(signal.SIGINT)
    if usual is signal.default_int_handler:
        signal.signal(signal.SIGINT, end_at_once)
    elif usual is not signal.SIG_IGN:  # somebody wants to answer them
        return
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _interrupt)
    atexit.register(_ignore_interrupts)


def _ignore_interrupts() -> None:
    """Ignore interrupts where Python ends: a second one must not change how a command has ended.

    Python takes away its own handlers then, but leaves what is ignored.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    # Once an interrupt has passed through exec of a text, as dataclasses use it, Python would in the end
    # kill itself by SIGINT, whatever was answered; one that goes well takes that back.
    exec("")


def _interrupt(*_: object) -> None:
    # As in jobs that a shell runs in the background.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        end_at_once()
    signal.raise_signal(signal.SIGINT)


@contextmanager
def interrupts_raise() -> Iterator[None]:
    """While something is open that has to be closed, such as a store or a bar, interrupts raise again."""
    if signal.getsignal(signal.SIGINT) is not end_at_once:
        yield
        return
    hook = sys.unraisablehook
    sys.unraisablehook = _again
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, end_at_once)
        sys.unraisablehook = hook


def _again(unraisable: Any) -> None:
    """Raise an interrupt again that Python would only have printed."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        # A moment later, for here an exception would be told of too.
        threading.Timer(A_MOMENT, _interrupt_main).start()
    else:
        sys.__unraisablehook__(unraisable)


def _interrupt_main() -> None:
    """Interrupt the main thread, even if it waits."""
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)
    else:
        interrupt_main()
