"""What a terminal shows: one screen of main results, the answer at its end, no word broken, nothing lost."""

import re
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crankbase.table import SI, Column, Main, MainWarning, Table
from crankfem.cli import console
from crankfem.cli.layout import short_places, table_lines
from satellite_cases import of_satellites
from stand_ins import calculate_satellites_once, calculate_vibration_once

WORDS = st.text("abcxyz.-", min_size=1, max_size=14)
CELLS = st.one_of(
    st.lists(WORDS, max_size=6).map(" ".join),
    st.none(),
    st.integers(-999, 99999),
    st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: float(f"{value:.6g}")),
)
COLUMNS = st.builds(
    Column,
    st.lists(WORDS, min_size=1, max_size=3).map(" ".join),
    st.sampled_from(["", "kN m", "mm", "%"]),
    decimals=st.one_of(st.none(), st.integers(0, 3)),
    words=st.booleans(),
)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
WIDTHS = pytest.mark.parametrize("width", [80, 60])


@st.composite
def tables(draw):
    columns = draw(st.lists(COLUMNS, min_size=1, max_size=8))
    rows = draw(st.lists(st.tuples(*(CELLS for _ in columns)).map(list), max_size=12))
    return Table(draw(st.lists(WORDS).map(" ".join)), columns, rows)


def fits(lines, width):
    """Whether each line fits, but for a word that is longer than a line."""
    return all(len(line) <= width or " " not in line.strip() for line in lines)


@pytest.mark.further
@given(tables(), st.integers(8, 120))
def test_a_table_fits_its_width_and_breaks_and_loses_no_word(table, width):
    lines = [line for line, _ in table_lines(table, SI, width)]
    assert fits(lines, width)
    shown = Counter(re.split(r"[\s:;]+", " ".join(lines)))
    wanted = Counter(
        word
        for row in table.texts()
        for column, cell in zip(table.columns, row, strict=True)
        for word in cell.split()
        if column.decimals is None
    )
    assert not wanted - shown


@pytest.mark.slow
@given(tables())
def test_numbers_keep_their_values_and_get_no_zeros_at_their_ends(table):
    shown = Counter(map(float, NUMBER.findall(" ".join(line for line, _ in table_lines(table)))))
    cells = [cell for row in table.texts() for cell in row]
    assert not Counter(map(float, NUMBER.findall("  ".join(cells)))) - shown


def printed(monkeypatch, capsys, width, parts, answers, full):
    monkeypatch.setenv("COLUMNS", str(width))
    terminal = console.Terminal(markup=False, emoji=False, width=width)
    monkeypatch.setattr(console, "output", terminal)
    capsys.readouterr()
    console.print_parts(parts, SI, answers, full=full)
    return capsys.readouterr().out.splitlines()


def test_the_first_screen_has_main_parts_within_its_lines_and_the_answer_last(monkeypatch, capsys):
    table = Table("Loads", [Column("at"), Column("load", "kN")], [[n, 1e3 * n] for n in range(70)])
    heavy = replace(table, main=True, weights=[n % 9 for n in range(70)])
    warnings = [MainWarning(f"field {n} looks wrong. It is large.") for n in range(5)]
    findings = [Main(f"Finding {n}.", "Its reasons are long and many.") for n in range(30)]
    parts = ["a remark", table, heavy, *warnings, *findings]
    for width in (80, 60):
        lines = printed(monkeypatch, capsys, width, parts, ["Verdict: fine."], full=False)
        assert 30 <= len(lines) <= console.LINES
        assert lines[-1] == "Verdict: fine."
        assert all(str(warning) in lines for warning in warnings)
        assert "Finding 0." in lines
        assert "a remark" not in lines
        numbers = [
            int(row[0]) for line in lines if len(row := line.split()) == 2 and row[0].isdigit()
        ]
        assert numbers == sorted(numbers)
        assert {8, 17, 26} <= {*numbers}
        whole = printed(monkeypatch, capsys, width, parts, ["Verdict: fine."], full=True)
        assert {*lines} - {*whole} == {
            line for line in lines if "--full" in line or "Finding" in line
        }


def test_places_have_short_names_with_a_legend(monkeypatch, capsys):
    table = Table("Loads", [Column("element")], [["cylinder 4 - cylinder 5"], ["main bearing 2"]])
    assert short_places("cylinder 6 - flywheel") == "cyl 6 - flywheel"
    lines = printed(monkeypatch, capsys, 80, [table], [], full=True)
    assert [line for line in lines if line.startswith(("cyl 4-5", "brg 2"))] == ["cyl 4-5", "brg 2"]
    assert sum("cyl: cylinder" in line for line in lines) == 1


ENGINES = ("6chn25-34", "8chn13-14")
QUICK = [
    *(tuple(line.split()) for line in of_satellites("ANSWERS")),
    ("two-mass", "yamz-5340"),
    ("vibration", "mwm-six"),
    ("plan", "6chn25-34"),
    ("formulas", "--published"),
    ("harmonics", "yamz5340_torque_one_throw.csv", "--firing-order", "1-3-4-2"),
    *(("lookup", "law", "--throw", engine) for engine in (ENGINES[0], "12chn18-20")),
    *((command, engine) for engine in ENGINES for command in ("check", "mechanism", "harmonics")),
]
LONG = [
    *((command, engine) for engine in ENGINES for command in ("throw", "formulas", "stress")),
    *(("vibration", engine, "--coupled", "--run-up", "10 s") for engine in ENGINES),
]
ANSWERS = {
    "two-mass": "resonates at",
    "vibration": "Verdict: |strain energy",
    "plan": "held-out designs",
    "formulas": "by finite elements|ChN 13/14",
    "harmonics": "ajor",
    "lookup": "torsional",
    "check": "valid engine file",
    "mechanism": "indicated power",
    "throw": "guided",
    "stress": "pin, ",
    **{line.split()[0]: words for line, words in of_satellites("ANSWERS").items()},
}


def check_screens(call, monkeypatch, width, line):
    calculate_satellites_once(monkeypatch)
    calculate_vibration_once(monkeypatch)
    monkeypatch.setenv("COLUMNS", str(width))
    for stream in (console.output, console.errors):
        monkeypatch.setattr(stream, "_width", width)
    answer = call(*line, "--quiet")
    lines = answer.out.splitlines()
    assert answer.code == 0
    assert fits(lines, width)
    assert len(lines) + len(answer.err.splitlines()) <= console.LINES + (width < 80) * 10
    assert re.search(ANSWERS[line[0]], " ".join(" ".join(lines[-10:]).split()))
    whole = call(*line, "--quiet", "--full").out.splitlines()
    assert fits(whole, width)


@pytest.mark.further
@WIDTHS
@pytest.mark.parametrize("line", QUICK, ids=" ".join)
def test_commands_end_with_their_answer_on_one_screen(call, monkeypatch, width, line):
    check_screens(call, monkeypatch, width, line)


@pytest.mark.further
@WIDTHS
@pytest.mark.parametrize("line", LONG, ids=" ".join)
def test_long_commands_do_so_too(call, lightly, monkeypatch, width, line):
    check_screens(call, monkeypatch, width, line)


def test_a_table_without_rows_says_so():
    table = Table(
        "Torsional resonances", [Column("speed", "1/min")], [], note="Not listed: 1 peak."
    )
    lines = [line for line, _ in table_lines(table)]
    assert lines == ["Torsional resonances: none", "Not listed: 1 peak."]
