"""A command that is ended leaves nothing behind: no scratch folder, no process."""

import signal
from pathlib import Path

import pytest

STRESS = pytest.param(("stress", "vw-tdi", "--pictures", "made"), marks=pytest.mark.slow)


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize(
    "command",
    [
        ("draw", "vw-tdi", "--shaft", "shaft.png"),
        ("export", "vw-tdi", "throw.step"),
        STRESS,
    ],
)
def test_a_command_that_is_ended_leaves_nothing_behind(own, command, number):
    owner = own("-m", "crankfem", *command)
    owner.wait_for(lambda: list(owner.scratch.iterdir()))
    assert owner.end(getattr(signal, number)) == ([], [])
    assert not Path("made").exists()
