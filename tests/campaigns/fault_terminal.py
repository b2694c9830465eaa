"""Faults of terminals: control characters in every text of every file, and widths from 0 to 40."""

import json
import re
import subprocess
import sys
from pathlib import Path
from random import Random

from fault_tools import Bench, Finding, command
from study_tools import ROOT, environment

from crankfem.files.reading.data_files import data_folder, input_kinds
from crankfem.files.satellites import satellite_files

# A window title, hidden text, a C1 sequence, and text written backwards; and as TOML writes them.
ESCAPES = "\u001b]0;evil\u0007\u001b[8m\u009b31m\u007f\u202e[red]"
WRITTEN = json.dumps(ESCAPES)[1:-1]
BATCH, SEPARATOR = 50, "=== end ===\n"
CHECK_ALL = f"""
import sys
from crankfem.cli import app
for file in sys.argv[1:]:
    for options in ((), ("--json",)):
        sys.argv = ["crankfem", "check", file, *options]
        try:
            app.main()
        except SystemExit as ended:
            assert ended.code in (None, 0, 2, 3), "Traceback"
        sys.stdout.write({SEPARATOR!r})
        sys.stdout.flush()
"""
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
WIDEST = 40
FILES = sorted(
    path for kind in input_kinds() for path in (data_folder() / f"{kind}s").glob("*.toml")
)
# Of first columns, which lists leave out.
HEADS = {
    "bearing",
    "cylinder",
    "design",
    "dimension",
    "engine",
    "field",
    "formula",
    "name",
    "order",
}
HEADS |= {"response", "support", "throw", "mode"}
TABLES = (
    ("check", "6chn25-34"),
    ("fields", "throw"),
    ("formulas", "6chn25-34"),
    ("formulas", "--published"),
    ("new", "--list"),
    ("plan", "6chn25-34"),
    ("lookup", "law", "--throw", "6chn25-34"),
    ("mechanism", "6chn25-34"),
    ("harmonics", "8chn26-26"),
    *((own.command,) for own in satellite_files().values()),
    ("vibration", "mwm-six"),
    ("vibration", "6chn25-34"),
    ("two-mass", "yamz-5340"),
    ("throw", "6chn25-34", "--accuracy", "0.1"),
)


def _texts() -> list[str]:
    """Files with escapes in one text each: every field of every model, as a value, its source or reason."""
    sys.path.append(str(ROOT / "tests"))
    from file_fields import fields, text_with

    values = (ESCAPES, {"value": ESCAPES, "source": ESCAPES}, {"value": 1, "assumed": ESCAPES})
    made = [text_with(kind, path, value) for kind, path, *_ in fields() for value in values]
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        made.append(f'{text}\n["{WRITTEN}"]\n"{WRITTEN}" = 1\n')
        if "[sources]" in text:
            named = text.replace("[sources]", f'[sources]\nevil = "{WRITTEN}"\n"{WRITTEN}" = "x"')
            made.append(named.replace("source =", 'source = "evil" #', 1))
    return [text.replace("\x7f", "\\u007f") for text in made]


def escapes(bench: Bench, draw: Random, place: Path) -> Finding:
    """Check files with escapes in one of their texts; the terminal gets none of them."""
    finding, number = Finding(), int(place.stem.split("-")[1])
    texts = _texts()
    for start in range(number * BATCH, (number + 1) * BATCH):
        file = place.with_name(f"{place.stem}-{start}.toml")
        file.write_text(texts[start % len(texts)], encoding="utf-8")
        finding.inputs += 1
    files = sorted(place.parent.glob(f"{place.stem}-*.toml"))
    # All in one process, which prints to a pipe as to a terminal.
    line = [sys.executable, "-c", CHECK_ALL, *map(str, files)]
    ended = subprocess.run(line, capture_output=True, text=True, env=environment(), check=False)
    for printed in (ended.stdout + ended.stderr).split(SEPARATOR):
        finding.silent += CONTROL.search(printed) is not None
        finding.tracebacks += "Traceback" in printed or "unexpected error" in printed
    finding.lost += ended.stdout.count(SEPARATOR) != 2 * len(files)
    for file in files:
        file.unlink()
    return finding


def widths(bench: Bench, draw: Random, place: Path) -> Finding:
    """Print tables at a width: each word that a wide terminal shows is there, but the first column's head."""
    finding = Finding()
    number = int(place.stem.split("-")[1])
    line, finding.inputs = TABLES[number % len(TABLES)], WIDEST + 1
    whole = _words(bench.end(_at(line, 400), finding).out)
    for width in range(WIDEST + 1):
        ended = bench.end(_at(line, width), finding)
        finding.lost += ended.code != 0 or not whole - _words(ended.out) <= HEADS
    return finding


def _at(line: tuple[str, ...], width: int) -> "subprocess.Popen[str]":
    full = () if line[0] in ("fields", "new") else ("--full",)
    return command(*line, *full, env=environment() | {"COLUMNS": str(width)})


def _words(text: str) -> set[str]:
    return {word.strip(":;[]") for word in text.split() if "--" not in word}


ATTACKS = {
    "escapes in a text of a file": (escapes, len(_texts())),
    "tables at widths from 0 to 40": (widths, len(TABLES) * (WIDEST + 1)),
}
