"""What reaches the terminal: no control characters of others, and at any width all of a table."""

import re
import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest

from crankfem.cli import console
from crankfem.files.reading.data_files import input_path

# A window title, hidden text, a C1 sequence, a line written backwards, markup, a picture's name.
EVIL = "\x1b]0;evil\x07\x1b[8m\x9b31m\x7f\u202e[red][link=x]:smile:"
SHOWN = r"\x1b]0;evil\x07\x1b[8m\x9b31m\x7f\u202e[red][link=x]:smile:"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
TOML = EVIL.translate({ord(one): f"\\u{ord(one):04x}" for one in "\x1b\x07\x9b\x7f\u202e"})
ROOT = Path(__file__).resolve().parents[2]


def shown(answer, text=SHOWN):
    told = answer.out + answer.err
    assert CONTROL.search(told) is None
    # A table breaks long words.
    assert text in told or text in re.sub(r"\s|[│┃]", "", told)


@pytest.mark.parametrize(
    "change",
    [
        {"engine.name": f'"{TOML}"'},
        {"throw.crank_radius": f'{{ value = "170 mm", assumed = "{TOML}" }}'},
        {"throw.crank_radius": f'"{TOML}"'},
        {"throw.web_outline": f'"{TOML}"'},
    ],
)
def test_texts_of_a_file_are_shown(call, tmp_path, edit, six_cylinders, change):
    (tmp_path / "mine.toml").write_text(edit(six_cylinders, change), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert CONTROL.search(answer.out + answer.err) is None
    assert answer.code in (0, 2)
    # As it is, or as Python quotes it.
    assert r"\x1b]0;evil\x07" in re.sub(r"\s|[│┃]", "", answer.out + answer.err)
    assert CONTROL.search(call("check", "mine.toml", "--json").out.replace("\x7f", "")) is None


def test_names_of_sections_and_files_are_shown(call, tmp_path, six_cylinders):
    text = f'{six_cylinders}\n["{TOML}"]\nx = 1\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    shown(call("check", "mine.toml"))
    shown(call("check", f"{EVIL}.toml"))
    shown(call(EVIL))
    (tmp_path / f"{EVIL}.toml").write_text(six_cylinders, encoding="utf-8")
    shown(call("check", f"{EVIL}.toml"))


def test_progress_and_tracebacks_are_shown(capsys, monkeypatch):
    with console.RunProgress() as progress:
        progress.step(EVIL)
        progress.warn(EVIL)
    monkeypatch.setenv("CRANKFEM_TRACEBACK", "1")
    with pytest.raises(SystemExit), console.clear_errors():
        raise RuntimeError(EVIL)
    told = capsys.readouterr().err
    assert CONTROL.search(told) is None
    assert told.count(SHOWN) >= 4


def test_nothing_else_writes_to_the_terminal():
    writes = re.compile(r"(?<![\w.\">`])print\(|\btyper\.echo\(|sys\.std(?:out|err)\.write\(")
    found = {
        str(path.relative_to(ROOT))
        for package in ("crankbase", "geometry", "fem", "regression", "dynamics", "crankfem")
        for path in (ROOT / package).rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if writes.search(line) and ">>>" not in line
    }
    # A sentence that never changes, JSON of the service's log, and notes of a study in Python.
    assert found == {
        "crankfem/cli/console.py",
        "crankfem/cli/entry.py",
        "crankfem/service/guard.py",
        "crankfem/analyses/study/studies.py",
    }


def letters(text):
    return Counter(one for one in text if not one.isspace() and not "─" <= one <= "▟")


@pytest.mark.parametrize(
    "line", [("fields", "throw"), ("two-mass", "yamz-5340"), ("new", "--list")]
)
def test_a_narrow_terminal_loses_nothing(call, monkeypatch, line):
    monkeypatch.setattr(console.output, "_width", 400)
    whole = letters(call(*line).out)
    for width in (1, 2, 7, 20, 40, 79):
        monkeypatch.setattr(console.output, "_width", width)
        answer = call(*line)
        assert (answer.code, answer.err) == (0, "")
        assert letters(answer.out) == whole


@pytest.mark.slow
@pytest.mark.parametrize("given", [{"COLUMNS": "0"}, {"COLUMNS": "²", "LINES": "²"}])
def test_impossible_sizes_are_none(spawn, spawn_environment, given):
    expected = spawn("new", "--list")
    assert spawn("new", "--list", env=spawn_environment(**given)) == expected


@pytest.mark.slow
def test_closed_streams_and_poor_encodings(spawn, spawn_environment, tmp_path):
    (tmp_path / "mü.toml").write_bytes(input_path("6chn25-34").read_bytes())
    answer = spawn("check", "mü.toml", env=spawn_environment(PYTHONIOENCODING="ascii"))
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(r"m\xfc.toml: valid engine file")
    start = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", sys.executable, "-m", "crankfem"]
    for line, code in (("check", "mü.toml"), 0), (("check", "none"), 2):
        assert spawn(*line, command=start).code == code


def test_an_option_of_one_value_is_not_given_twice(call):
    for line in (
        ("throw", "6chn25-34", "--pin-force", "1 kN", "--pin-force=2 kN"),
        ("throw", "6chn25-34", "--gamma", "90 deg", "--gamma-deg", "120"),
        ("run", "6chn25-34", "--output", "a", "--output", "b"),
    ):
        answer = call(*line)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.strip() == f"Error: {line[2]}: given more than once; give it once."
    # Some are meant to be, and flags say the same twice.
    assert call("formulas", "6chn25-34", "--constant", "x=1", "--constant", "y=2").code == 2
    assert call("fields", "throw", "--json", "--json").code == 0


def test_help_keeps_names_of_sections(call):
    assert "[two_mass_check]" in call("two-mass", "--help").out


def test_a_drawing_of_such_a_name_is_well_formed(call, tmp_path, edit, six_cylinders):
    text = edit(six_cylinders, {"engine.name": f'"<b>&]]>{TOML}"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    assert call("draw", "mine.toml", "--output", "throw.svg").code == 0
    ElementTree.parse(tmp_path / "throw.svg")
