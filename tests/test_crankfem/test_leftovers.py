"""A command that is ended leaves nothing behind: no scratch folder, no process."""

import signal
from pathlib import Path

import pytest

DRAW = ("draw", "vw-tdi", "--shaft", "shaft.png")
EXPORT = ("export", "vw-tdi", "throw.step")
STRESS = ("stress", "vw-tdi", "--pictures", "made")


@pytest.mark.parametrize(
    ("command", "number"),
    [
        (EXPORT, "SIGINT"),
        (EXPORT, "SIGTERM"),
        pytest.param(DRAW, "SIGINT", marks=pytest.mark.slow),
        pytest.param(DRAW, "SIGTERM", marks=pytest.mark.slow),
        pytest.param(STRESS, "SIGTERM", marks=pytest.mark.slow),
    ],
)
def test_a_command_that_is_ended_leaves_nothing_behind(own, command, number):
    owner = own("-m", "crankfem", *command)
    # Not for the file by which Python finds out for a moment where it may write.
    owner.wait_for(lambda: list(owner.scratch.glob("crankfem-*")))
    assert owner.end(getattr(signal, number)) == ([], [])
    # The folder that the command names is made before it calculates; nothing is in it.
    assert not Path("made").exists() or not list(Path("made").iterdir())


def test_a_file_that_is_being_written_is_taken_away_by_an_interrupt(own):
    program = (
        "import time; from pathlib import Path; from crankbase.outputs import atomic_file;"
        "from crankfem.cli.interrupts import exit_on_interrupts\nexit_on_interrupts()\n"
        "with atomic_file(Path('made.svg'), 'picture') as part:\n"
        "    Path('begun').touch(); time.sleep(60)"
    )
    owner = own("-c", program)
    owner.wait_for(lambda: list(owner.scratch.parent.glob("begun")))
    assert list(owner.scratch.parent.glob(".crankfem-*.svg"))
    owner.end(signal.SIGINT)
    assert not list(owner.scratch.parent.glob(".crankfem-*.svg"))
