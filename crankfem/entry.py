"""The start of the command line: an interrupt is answered in a sentence, even during the imports."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

# Commands whose finished work is kept and continued.
CONTINUED = ("run", "doe")
EXIT_INTERRUPTED = 130
STANDARD_ERROR = 2


def interrupted_sentence() -> str:
    """What to say of an interrupt, by the command that was given."""
    if any(word in CONTINUED for word in sys.argv[1:2]):
        return "Stopped. Finished designs are kept; the same command continues where it stopped."
    return "Stopped."


def _end_at_once(*_: object) -> None:
    """Answer an interrupt without raising anything: an exception could be told of by its traceback.

    Python prints one that is raised while an object is cleared away, and goes on.
    """
    os.write(STANDARD_ERROR, f"{interrupted_sentence()}\n".encode())
    os._exit(EXIT_INTERRUPTED)


@contextmanager
def _interrupts_end_at_once() -> Iterator[None]:
    """Let an interrupt end the process, as long as nothing is open that would have to be closed."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is not signal.default_int_handler:
        # Somebody wants interrupts to be ignored, or to answer them.
        yield
        return
    signal.signal(signal.SIGINT, _end_at_once)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


def main() -> None:
    """Run the command line."""
    # Dense matrices are small here. With more threads numpy's own library spends most of its time in
    # waiting: twice the processor time on two cores, and several times as long where others work too.
    # Finite elements are solved by another library, which is not bound by this.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        with _interrupts_end_at_once():
            from crankfem import cli
        cli.main()
    except KeyboardInterrupt:
        print(interrupted_sentence(), file=sys.stderr)
        raise SystemExit(EXIT_INTERRUPTED) from None
