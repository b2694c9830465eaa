"""The core without its satellites, and what it loads of them."""

import sys

import pytest

from crankfem.cli.app import places
from crankfem.files.satellites import SATELLITES, called, plugs

# No satellite is in the table, and none can be imported.
WITHOUT = """
import sys
sys.modules["crankfem.satellites"] = None
import crankfem.files.satellites as table
table.SATELLITES = ()
from crankfem.cli.entry import main
main()
"""


@pytest.fixture
def core(spawn):
    return lambda *arguments: spawn(*arguments, command=[sys.executable, "-c", WITHOUT])


@pytest.mark.slow
def test_the_core_lists_its_commands_and_files(core):
    answer = core("--help")
    assert answer.code == 0, answer.err
    listed = {line.split()[1] for line in answer.out.splitlines() if len(line.split()) > 1}
    assert {"run", "throw", "vibration", "mechanism"} <= listed
    assert not {called(plug.command) for plug in plugs()} & listed
    shipped = core("new", "--list", "--json").json()["shipped"]
    assert {one["kind"] for one in shipped} == {"engine", "mechanism", "throw", "chain"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "line", [("check", "7l32-40-set"), ("mechanism", "vw-tdi"), ("vibration", "mwm-six")]
)
def test_the_core_works_alone(core, line):
    answer = core(*line, "--json")
    assert answer.code == 0, answer.err
    assert answer.json()


def test_commands_of_satellites_are_listed():
    assert {called(plug.command) for plug in plugs()} <= places().keys()


def test_a_plug_loads_nothing_of_its_satellite(spawn):
    code = (
        "import sys; from crankfem.files.satellites import plugs; plugs(); "
        "print(*sorted(name for name in sys.modules if name.startswith('crankfem.')))"
    )
    answer = spawn(command=[sys.executable, "-c", code])
    assert answer.code == 0, answer.err
    own = {f"crankfem.satellites.{name}{module}" for name in SATELLITES for module in ("", ".plug")}
    loaded = set(answer.out.split()) - {"crankfem.satellites"}
    assert loaded == own | {"crankfem.files", "crankfem.files.satellites"}
