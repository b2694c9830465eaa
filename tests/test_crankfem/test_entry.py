"""An interrupt while modules load: one sentence and 130, whatever Python is doing just then."""

import atexit
import signal
import sys
import time

import pytest

from crankfem.cli.interrupts import (
    _ignore_interrupts,
    end_at_once,
    exit_on_interrupts,
    interrupts_raise,
)

pytestmark = pytest.mark.usefixtures("interruptible")

# A module's loading is where the interrupt comes, in the midst of clearing an object away: what is
# raised there, Python tells of with a traceback and goes on.
LOADING = """
import signal, sys

class Cleared:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

class Finder:
    def find_spec(self, name, path, target=None):
        if name == "crankfem.cli.app":
            Cleared()

sys.meta_path.insert(0, Finder())
from crankfem.cli.entry import main
main()
"""


# As in jobs that a shell runs in the background.
IGNORED = """
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
from crankfem.cli.interrupts import exit_on_interrupts
exit_on_interrupts()
signal.raise_signal(signal.SIGINT)
print("goes on", flush=True)
signal.raise_signal(signal.SIGTERM)
"""
ENDING = """
import os, signal
from crankfem.cli.entry import main

class Cleared:
    def __del__(self, kill=os.kill, own=os.getpid(), number=signal.{number}):
        kill(own, number)

cleared = Cleared()
main()
"""


@pytest.fixture
def immediate(interruptible):
    """Interrupts end this process, during a test."""
    before = [(number, signal.getsignal(number)) for number in (signal.SIGINT, signal.SIGTERM)]
    exit_on_interrupts()
    yield
    atexit.unregister(_ignore_interrupts)
    for number, handler in before:
        signal.signal(number, handler)


def test_where_interrupts_are_ignored_a_request_to_end_is_answered(spawn):
    answer = spawn(command=[sys.executable, "-c", IGNORED])
    assert (answer.code, answer.out.strip(), answer.err) == (130, "goes on", "Stopped.\n")


@pytest.mark.slow
def test_python_runs_the_package(spawn):
    answer = spawn("--version", command=[sys.executable, "-P", "-m", "crankfem"])
    assert answer.code == 0
    assert answer.out.startswith("crankfem ")


@pytest.mark.parametrize(
    ("command", "sentence"), [("run", "Stopped.\n"), ("doe", "Stopped. Finished designs")]
)
def test_an_interrupt_while_modules_load(spawn, command, sentence):
    answer = spawn(command, command=[sys.executable, "-c", LOADING])
    assert (answer.code, answer.out) == (130, "")
    assert answer.err.startswith(sentence)
    assert answer.err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_an_interrupt_while_python_ends_changes_nothing(spawn, number):
    """The second of somebody impatient, also while modules are cleared away."""
    answer = spawn("--version", command=[sys.executable, "-c", ENDING.format(number=number)])
    assert (answer.code, answer.err) == (0, "")


def test_an_interrupt_that_passes_through_exec_is_one_like_others(spawn, tmp_path):
    (tmp_path / "ending.py").write_text(
        "import crankfem.cli.app as app; from crankfem.cli.entry import main;"
        "app.main = lambda: exec('raise KeyboardInterrupt'); main()"
    )
    answer = spawn(command=[sys.executable, "-m", "ending"])
    assert (answer.code, answer.err) == (130, "Stopped.\n")


@pytest.mark.usefixtures("immediate")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_work_that_must_be_closed_sees_an_interrupt(number):
    ending = signal.getsignal(signal.SIGINT)
    assert ending is end_at_once
    with pytest.raises(KeyboardInterrupt), interrupts_raise():
        signal.raise_signal(number)
    assert signal.getsignal(signal.SIGINT) is ending


class Cleared:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)


def work():
    Cleared()
    time.sleep(5.0)  # the interrupt comes again much sooner


@pytest.mark.usefixtures("immediate")
def test_an_interrupt_while_something_is_cleared_away_is_not_lost(capsys):
    with interrupts_raise(), pytest.raises(KeyboardInterrupt):
        work()
    assert capsys.readouterr().err == ""
