"""What ends or begins badly: interrupts, leftovers, and what is no file."""

import os
import signal
import socket
from pathlib import Path

import pytest
import typer

from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankfem.cli.app import app
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.reading.data_files import input_path
from geometry.imported import import_throw
from regression.models.compliance_model import ComplianceModel
from satellite_cases import of_satellites

DRAW = ("draw", "vw-tdi", "--shaft", "shaft.png")
EXPORT = ("export", "vw-tdi", "throw.step")
STRESS = ("stress", "vw-tdi", "--pictures", "made")


@pytest.mark.further
@pytest.mark.parametrize(
    ("command", "number"),
    [
        (EXPORT, "SIGINT"),
        (EXPORT, "SIGTERM"),
        pytest.param(DRAW, "SIGINT", marks=pytest.mark.slow),
        pytest.param(DRAW, "SIGTERM", marks=pytest.mark.slow),
        pytest.param(STRESS, "SIGTERM", marks=pytest.mark.further),
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


COMMANDS = typer.main.get_command(app).commands
ENDINGS = (".toml", ".json", ".sqlite", ".csv")
# Commands by their arguments that are files to read; "new" writes the one it is given, two need more.
LINES = [
    (name, *("PATH" for argument in arguments))
    for name, command in COMMANDS.items()
    if name not in ("new", "export", "designs", "import", "results")
    and name not in of_satellites("READS")
    and (
        arguments := [
            one
            for one in command.params
            if one.param_type_name == "argument"
            and (one.metavar or "").partition("|")[0].endswith(ENDINGS)
        ]
    )
]
LINES += [
    ("export", "PATH", "throw.step"),
    ("run", "6chn25-34", "--model", "PATH"),
    ("vibration", "6chn25-34", "--model", "PATH"),
    ("mechanism", "PATH"),
    ("import", "6chn25-34", "PATH"),
    ("designs", "PATH", "designs"),
    ("results", "PATH", "runs.csv"),
    ("doe", "6chn25-34", "--store", "PATH"),
    *of_satellites("READS").values(),
]
TABLES = {
    "gas.pressure_table": ('[gas]\npressure_table = "pipe"\n', "[gas]"),
    "torque.table": ('[torque]\ntable = "pipe"\n', None),
    "pipe": ('[shaft_line]\nplant = "pipe"\n', None),
    "study.file": ('[study]\ndesign = "file"\nfile = "pipe"\n', "[study]"),
}


@pytest.fixture
def places(tmp_path):
    """Paths that are no files, each with a word for it; a pipe that nobody writes to is one."""

    def late(*_):
        raise AssertionError("waits for the pipe")

    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    usual = signal.signal(signal.SIGALRM, late)
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket")
        signal.alarm(60)
        yield {
            "pipe": "pipe",
            "folder": "folder",
            "socket": "socket",
            "/dev/null": "device",
            "-": "standard input",
            "/dev/stdin": "standard input",
        }
        signal.alarm(0)
    signal.signal(signal.SIGALRM, usual)


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_what_is_no_file_is_called_what_it_is(call, places, monkeypatch, line):
    reading, writing = os.pipe()
    usual = os.dup(0)
    os.dup2(reading, 0)
    # What reads a file is one function: each command meets two of the places, the first ones all.
    number = LINES.index(line)
    some = [*places][number % 3 :: 3] if number > 2 else [*places]
    for path, word in ((path, places[path]) for path in some):
        answer = call(*(path if one == "PATH" else one for one in line))
        assert (answer.code, answer.out) == (2, ""), path
        assert answer.err.lstrip().startswith("Error: ")
        assert path in answer.err
        assert f"is {'' if word == 'standard input' else 'a '}{word}" in answer.err, path
        assert answer.err.strip().count("\n") == 0
        assert "does not exist" not in answer.err
    os.dup2(usual, 0)
    for one in (reading, writing, usual):
        os.close(one)


@pytest.mark.parametrize("field", TABLES)
def test_tables_that_an_engine_file_names(call, places, tmp_path, edit, field):
    added, gone = TABLES[field]
    text = edit(input_path("6chn25-34").read_text(encoding="utf-8"), {gone: None} if gone else {})
    (tmp_path / "mine.toml").write_text(f"{text}\n{added}", encoding="utf-8")
    answer = call("doe" if field == "study.file" else "vibration", "mine.toml")
    assert (answer.code, answer.out) == (2, "")
    assert field in answer.err
    assert "is a pipe, not a file (save what comes through it in one)" in answer.err


@pytest.mark.parametrize("read", [load_engine, load_chain, ComplianceModel.load, import_throw])
def test_python_says_the_same(places, read):
    for path, word in places.items():
        with pytest.raises(InputError, match=word):
            read(path)


def test_files_and_nothing_are_no_such_thing(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("file")
    (tmp_path / "broken").symlink_to("none")
    for name in ("file", "link", "broken", "none", "none/in", "x" * 100_000, "\0"):
        assert not_a_file(tmp_path / name) is None
