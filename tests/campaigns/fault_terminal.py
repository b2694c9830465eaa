"""Faults of terminals: control characters in every text of every file, and widths from 0 to 40."""

import re
import subprocess
from collections import Counter
from pathlib import Path
from random import Random

from fault_tools import Bench, Finding, command
from study_tools import environment

from crankbase.model import InputModel
from crankfem.files.engine.engine_file import SECTIONS
from crankfem.files.reading.data_files import FOLDERS, data_folder

# A window title, hidden text, a C1 sequence, and text written backwards, as TOML writes them.
ESCAPES = r"\u001b]0;evil\u0007\u001b[8m\u009b31m\u007f\u202e[red]"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
WIDEST = 40
FILES = sorted(path for kind in FOLDERS.values() for path in (data_folder() / kind).glob("*.toml"))
FIELD = re.compile(r"(?m)^([\w.]+) *= *(.*)$")
TABLES = (
    ("check", "6chn25-34"),
    ("fields", "throw"),
    ("formulas", "6chn25-34"),
    ("formulas", "--published"),
    ("new", "--list"),
    ("doe", "6chn25-34", "--plan"),
    ("lookup", "law", "--throw", "6chn25-34"),
    ("mechanism", "6chn25-34"),
    ("harmonics", "8chn26-26"),
    ("hinge", "crosshead-30-100"),
    ("vibration", "mwm-six"),
    ("vibration", "6chn25-34"),
    ("two-mass", "yamz-5340"),
    ("throw", "6chn25-34", "--accuracy", "0.1"),
)


def _texts() -> list[str]:
    """Files with escapes in one text each: every line of every shipped file, every field of every model."""
    made = []
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        for line in FIELD.finditer(text):
            for value in (f'"{ESCAPES}"', f'{{ value = {line[2]}, assumed = "{ESCAPES}" }}'):
                made.append(f"{text[: line.start(2)]}{value}{text[line.end(2) :]}")
        made.append(f'{text}\n["{ESCAPES}"]\n"{ESCAPES}" = 1\n')
    engine = (data_folder() / "engines/6chn25-34.toml").read_text(encoding="utf-8")
    for section, kind in SECTIONS.items():
        fields = (
            kind.model_fields if isinstance(kind, type) and issubclass(kind, InputModel) else ()
        )
        start = re.split(rf"(?m)^\[{section}\]\n(?:[^\[\n].*\n|\n)*", engine)
        made += [f'{"".join(start)}\n[{section}]\n{name} = "{ESCAPES}"\n' for name in fields]
    return made


def escapes(bench: Bench, draw: Random, place: Path) -> Finding:
    """Check a file with escapes in one of its texts; the terminal gets none of them."""
    finding = Finding(inputs=1)
    file = place.with_suffix(".toml")
    # Each in turn: the number of the trial stands in the name of its place.
    texts = _texts()
    file.write_text(texts[int(place.stem.split("-")[1]) % len(texts)], encoding="utf-8")
    for line in (("check", file), ("check", file, "--json")):
        ended = bench.end(command(*line), finding)
        found = CONTROL.search(
            (ended.out + ended.errors).replace("\x7f", "" if "--json" in line else "\x7f")
        )
        finding.silent += found is not None
    file.unlink()
    return finding


def widths(bench: Bench, draw: Random, place: Path) -> Finding:
    """Print tables at a width: each character that a wide terminal shows is there."""
    finding = Finding()
    number = int(place.stem.split("-")[1])
    line, finding.inputs = TABLES[number % len(TABLES)], WIDEST + 1
    whole = _letters(bench.end(_at(line, 400), finding).out)
    for width in range(WIDEST + 1):
        ended = bench.end(_at(line, width), finding)
        finding.lost += ended.code != 0 or _letters(ended.out) != whole
    return finding


def _at(line: tuple[str, ...], width: int) -> "subprocess.Popen[str]":
    return command(*line, env=environment() | {"COLUMNS": str(width)})


def _letters(text: str) -> Counter[str]:
    return Counter(one for one in text if not one.isspace() and not "─" <= one <= "▟")


ATTACKS = {
    "escapes in a text of a file": (escapes, len(_texts())),
    "tables at widths from 0 to 40": (widths, len(TABLES) * (WIDEST + 1)),
}
