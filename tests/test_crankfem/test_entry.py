"""An interrupt while modules load: one sentence and 130, whatever Python is doing just then."""

import signal
import sys

import pytest

# A module's loading is where the interrupt comes, in the midst of clearing an object away: what is
# raised there, Python tells of with a traceback and goes on.
LOADING = """
import signal, sys

class Cleared:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

class Finder:
    def find_spec(self, name, path, target=None):
        if name == "crankfem.cli":
            Cleared()

sys.meta_path.insert(0, Finder())
from crankfem.entry import main
main()
"""


@pytest.mark.parametrize(
    ("command", "sentence"), [("mechanism", "Stopped."), ("run", "Stopped. Finished designs")]
)
def test_an_interrupt_while_modules_load(spawn, command, sentence):
    answer = spawn(command, command=[sys.executable, "-c", LOADING])
    assert (answer.code, answer.out) == (130, "")
    assert answer.err.startswith(sentence)
    assert answer.err.count("\n") == 1


def test_afterwards_interrupts_are_what_they_were():
    from crankfem.entry import _interrupts_end_at_once

    usual = signal.getsignal(signal.SIGINT)
    with _interrupts_end_at_once():
        assert signal.getsignal(signal.SIGINT) is not usual
    assert signal.getsignal(signal.SIGINT) is usual
