"""The start of the command line: an interrupt is reported in a sentence, even during imports."""

import atexit
import gc
import os
import re
import sys
from io import TextIOWrapper

from crankbase.processes import GARBAGE_THRESHOLD
from crankfem.cli.interrupts import exit_on_interrupts, interrupted_sentence
from crankfem.jobs.exit_codes import EXIT_INTERRUPTED

# A width or height of a terminal that can be written to.
SIZE = re.compile("0*[1-9][0-9]{0,3}")


def main() -> None:
    """Run the command line."""
    # Streams may be handed over closed, without room, or without the letters of a name.
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            # It takes the number of the closed stream, else the next file would, and libraries write there.
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    for name in ("COLUMNS", "LINES"):
        if not SIZE.fullmatch(os.environ.get(name, "1")):
            del os.environ[name]
    # Dense matrices are small here. With more threads numpy's own library spends most of its time in
    # waiting: twice the processor time on two cores, and several times as long where others work too.
    # Finite elements are solved by another library, which is not bound by this.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Its search for plugins, of which none is ours, reads what every installed package says of itself.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    gc.set_threshold(GARBAGE_THRESHOLD)
    # Else Python, when all is done, goes through everything that was loaded in search of circles.
    atexit.register(gc.freeze)
    # Commands load most modules when they begin, so this holds for them too, but where something is open
    # that must be closed (`crankfem.cli.interrupts.interrupts_raise`); and until Python itself has ended.
    exit_on_interrupts()
    try:
        from crankfem.cli import app as cli

        cli.main()
    except KeyboardInterrupt:
        print(interrupted_sentence(), file=sys.stderr)
        raise SystemExit(EXIT_INTERRUPTED) from None
