"""The start of the command line: an interrupt is reported in a sentence, even during imports."""

import gc
import os
import sys

from crankbase.processes import GARBAGE_THRESHOLD
from crankfem.cli.interrupts import exit_on_interrupts, interrupted_sentence
from crankfem.jobs.exit_codes import EXIT_INTERRUPTED


def main() -> None:
    """Run the command line."""
    # Dense matrices are small here. With more threads numpy's own library spends most of its time in
    # waiting: twice the processor time on two cores, and several times as long where others work too.
    # Finite elements are solved by another library, which is not bound by this.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(GARBAGE_THRESHOLD)
    # Commands load most modules when they begin, so this holds for them too, but where something is open
    # that must be closed (`crankfem.cli.interrupts.interrupts_raise`); and until Python itself has ended.
    exit_on_interrupts()
    try:
        from crankfem.cli import app as cli

        cli.main()
    except KeyboardInterrupt:
        print(interrupted_sentence(), file=sys.stderr)
        raise SystemExit(EXIT_INTERRUPTED) from None
