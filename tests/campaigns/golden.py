"""Everything that two states of the program print and write, for all shipped files, compared.

Run by hand, each about half an hour of two cores::

    python tests/campaigns/golden.py make FOLDER --program PATH/TO/crankfem
    python tests/campaigns/golden.py compare BEFORE AFTER
    python tests/campaigns/golden.py digests FOLDER > tests/campaigns/golden.json
    python tests/campaigns/golden.py check FOLDER tests/campaigns/golden.json

``make`` runs every command on every shipped file that it can use: console at 100 columns, ``--json``,
tables as CSV, the results, report and model of whole runs. Outputs that are there already are kept, so it
continues where it was stopped. ``compare`` tells each number that differs by more than 1e-12 of itself,
each key or sentence that only one side has. Times, dates, paths and versions are left out. ``digests`` are
of numbers rounded to ten digits: equal digests mean equal outputs, different ones may still be rounding,
and ``compare`` with a tree of the earlier state decides.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from json_units import numbers_with_units

TOLERANCE = 1e-12
ENGINES = [
    "5rt-flex50d",
    "6chn105-130",
    "6chn15-18",
    "6chn18-22",
    "6chn18-22-set",
    "6chn25-34",
    "6s50mc-c",
    "7l32-40-set",
    "8chn13-14",
    "cat-3116",
    "vw-tdi",
    "yamz-5340",
]
THROWS = ["12chn18-20", "12dn23-30", "2ch85-110", "8chn14-14"]
MECHANISMS = ["8chn26-26", "buick-3800"]
CHAINS = ["5rt-flex50d-plant", "geared-example", "mwm-six"]
WHOLE_RUNS = ["6chn25-34", "yamz-5340", "8chn13-14", "8chn26-26"]
COUPLED = ["6chn25-34", "vw-tdi"]
# What differs from run to run: clocks, sizes of files, versions, folders.
PASSING = re.compile(
    r"(seconds|elapsed|duration|started|finished|created|written|version|date|host|folder|path|memory|processes|sha256)"
)
PASSING_TEXT = re.compile(
    r"\d+(\.\d+)? ?(s|ms|min|MB|KiB|MiB)\b|\d{4}-\d\d-\d\d[T ]?[\d:.+Z]*|/[\w./-]+|\d+\.\d+\.\d+\w*"
    r"|\d{1,2} [A-Z][a-z]+ \d{4}, \d\d:\d\d UTC"
)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w])")


def cases() -> dict[str, str]:
    """Return command lines by the name of their output; FOLDER stands for a folder of the output's own."""
    commands = {"fields": "fields", "formulas": "formulas", "new": "new --list"}
    for name in [*ENGINES, *THROWS, *MECHANISMS, *CHAINS, "crosshead-30-100"]:
        commands[f"check.{name}"] = f"check {name}"
    for name in [*ENGINES, *THROWS]:
        commands[f"throw.{name}"] = f"throw {name}"
        commands[f"formulas.{name}"] = f"formulas {name}"
        commands[f"law.{name}"] = f"lookup law --throw {name}"
    for name in [*ENGINES, *MECHANISMS]:
        commands[f"mechanism.{name}"] = f"mechanism {name} --csv FOLDER/forces.csv"
        commands[f"harmonics.{name}"] = f"harmonics {name} --csv FOLDER/harmonics.csv"
    for name in [*ENGINES, *CHAINS]:
        commands[f"vibration.{name}"] = f"vibration {name} --csv FOLDER/amplitudes"
        commands[f"class.{name}"] = f"class {name} --output FOLDER/document"
    for name in COUPLED:
        commands[f"coupled.{name}"] = f"vibration {name} --coupled"
    for name in WHOLE_RUNS:
        commands[f"run.{name}"] = f"run {name} --output FOLDER/results --workers 1"
    commands["hinge"] = "hinge --csv FOLDER/hinge.csv"
    commands["two-mass"] = "two-mass yamz-5340"
    commands["stress"] = "stress 6chn25-34"
    return commands


def run_case(name: str, command: str, program: str, target: Path, as_json: bool) -> str:
    """Run a command into its file of the target folder, unless it is there; return what to print."""
    answer = target / (name + (".json" if as_json else ".txt"))
    if answer.exists():
        return ""
    with tempfile.TemporaryDirectory() as scratch:
        words = command.replace("FOLDER", scratch).split() + (
            ["--json"] if as_json else ["--quiet"]
        )
        environment = {**os.environ, "COLUMNS": "100", "NO_COLOR": "1", "OMP_NUM_THREADS": "1"}
        process = subprocess.run(
            [program, *words],
            capture_output=True,
            text=True,
            env=environment,
            cwd=scratch,
            check=False,
        )
        for written in sorted(Path(scratch).rglob("*")):
            if written.suffix in (".csv", ".json", ".html") and not as_json:
                copy = target / f"{name}.files" / written.relative_to(scratch)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(written, copy)
    said = "" if as_json else process.stderr
    partial = answer.with_name(f"{answer.name}.partial")
    partial.write_text(
        process.stdout + said + ("" if as_json else f"\nexit code {process.returncode}\n")
    )
    partial.rename(answer)
    return f"{name}{' --json' if as_json else ''}: exit code {process.returncode}"


def make(target: Path, program: str) -> None:
    """Run all cases, two at a time."""
    target.mkdir(parents=True, exist_ok=True)
    program = str(Path(program).resolve())
    with ThreadPoolExecutor(2) as pool:
        tasks = [
            pool.submit(run_case, name, command, program, target, as_json)
            for name, command in cases().items()
            for as_json in (False, True)
        ]
        for task in tasks:
            if line := task.result():
                print(line, flush=True)


def leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield each value of a JSON document with its path, without those that pass with the clock."""
    if isinstance(value, dict):
        for name, part in value.items():
            if not PASSING.search(name):
                yield from leaves(part, f"{key}.{name}")
    elif isinstance(value, list):
        for place, part in enumerate(value):
            yield from leaves(part, f"{key}[{place}]")
    else:
        yield key, PASSING_TEXT.sub("", value) if isinstance(value, str) else value


def text_leaves(text: str) -> Iterator[tuple[str, Any]]:
    """Yield each line of a text: words with numbers replaced, then the numbers."""
    text = re.sub(
        r"<(script|style)\b.*?</\1>|<svg\b.*?</svg>|data:[\w/;,+=.-]+", "", text, flags=re.S
    )
    for number, line in enumerate(re.sub(r"<[^>]+>", "\n", text).splitlines()):
        words = PASSING_TEXT.sub("", line).strip()
        if words:
            yield f"line {number}", words


def read(file: Path) -> dict[str, Any]:
    """Return the values of an output by their places."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".json":
        try:
            content = json.loads(text)
            declared = content.pop("units", None) if isinstance(content, dict) else None
            values = dict(leaves(content))
            if (
                isinstance(declared, dict) and "format" not in content
            ):  # models tell those of inputs
                numbers = numbers_with_units(content | {"units": declared})
                values |= {f"unit of {'.'.join(path)}": unit for path, _, unit in numbers}
            return values
        except ValueError:
            pass
    return dict(text_leaves(text))


def differ(before: Any, after: Any) -> bool:
    """Return whether two values are different beyond rounding."""
    if isinstance(before, str) and isinstance(after, str):
        if NUMBER.sub("#", before) != NUMBER.sub("#", after):
            return True
        pairs = zip(NUMBER.findall(before), NUMBER.findall(after), strict=True)
        return any(differ(float(first), float(second)) for first, second in pairs)
    if isinstance(before, bool | None) or isinstance(after, bool | None | str):
        return before is not after
    return bool(abs(before - after) > TOLERANCE * max(abs(before), abs(after)))


def outputs(folder: Path) -> dict[str, Path]:
    """Return the outputs in a folder by name."""
    files = (file for file in folder.rglob("*") if file.is_file() and file.suffix != ".partial")
    return {str(file.relative_to(folder)): file for file in sorted(files)}


def compare(before: Path, after: Path) -> int:
    """Print what differs; return the number of outputs that do."""
    first, second = outputs(before), outputs(after)
    different = 0
    for name in sorted(first.keys() | second.keys()):
        if name not in first or name not in second:
            print(f"{name}: only in {before if name in first else after}")
            different += 1
            continue
        old, new = read(first[name]), read(second[name])
        if name.endswith(".json"):
            gone, added = old.keys() - new.keys(), new.keys() - old.keys()
            changed = [key for key in old if key in new and differ(old[key], new[key])]
            lines = [f"  gone {key}" for key in sorted(gone)] + [
                f"  new {key}" for key in sorted(added)
            ]
            lines += [f"  {key}: {old[key]!r} -> {new[key]!r}" for key in changed]
        else:
            lines = text_changes(list(old.values()), list(new.values()))
        if lines:
            different += 1
            print(f"{name}: {len(lines)} differences", *lines[:40], sep="\n")
    print(f"{len(first)} outputs before, {len(second)} after, {different} different")
    return different


def text_changes(before: list[str], after: list[str]) -> list[str]:
    """Return the lines that only one of two texts has, beyond rounding."""
    if len(before) == len(after):
        pairs = [pair for pair in zip(before, after, strict=True) if differ(*pair)]
        return [line for old, new in pairs for line in (f"  - {old}", f"  + {new}")]
    old_lines, new_lines = set(before), set(after)
    gone = [f"  - {line}" for line in before if line not in new_lines]
    return gone + [f"  + {line}" for line in after if line not in old_lines]


def digests(folder: Path) -> dict[str, str]:
    """Return a digest of each output, its numbers rounded to ten digits."""

    def rounded(value: Any) -> str:
        if isinstance(value, float):
            return f"{value:.10g}"
        return NUMBER.sub(lambda number: f"{float(number[0]):.10g}", str(value))

    found = {}
    for name, file in outputs(folder).items():
        text = "\n".join(f"{key}={rounded(value)}" for key, value in read(file).items())
        found[name] = hashlib.sha256(text.encode()).hexdigest()[:16]
    return found


def main() -> int:
    """Do what the first word of the command line says."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("task", choices=("make", "compare", "digests", "check"))
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--program", default="crankfem")
    options = parser.parse_args()
    folder = options.folders[0]
    if options.task == "make":
        make(folder, shutil.which(options.program) or options.program)
        return 0
    if options.task == "compare":
        return 1 if compare(folder, options.folders[1]) else 0
    today = digests(folder)
    if options.task == "digests":
        json.dump(today, sys.stdout, indent=0)
        return 0
    kept = json.loads(options.folders[1].read_text())
    different = [
        name for name in sorted(kept.keys() | today.keys()) if kept.get(name) != today.get(name)
    ]
    print(*different, f"{len(kept) - len(different)} of {len(kept)} outputs equal", sep="\n")
    return 1 if different else 0


if __name__ == "__main__":
    raise SystemExit(main())
