"""Give every parser, the command line, the service and the public functions 20,000 wrong inputs each.

Run by hand: ``python tests/campaigns/fuzzing.py [--inputs 20000] [--folder FOLDER] [NAME ...]``. NAME is
that of a row of the table or its beginning; all by default. What is counted stands in FOLDER
(``fuzzing-results``), so that the same command goes on where it was stopped; defects stand there with
the input that brought them, and the same command tries those inputs again. ``--fresh`` begins anew.

Each input must give one sentence or a finite result: no traceback, no warning of numpy, no NaN or
infinity, nothing that takes more than 10 s of processor time.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from satellite_cases import of_satellites
from strategies import command_lines
from strategies.calls import Attempted, is_asked, made, wrong_calls
from strategies.outcomes import (
    ACCEPTED,
    DEFECTS,
    HANG,
    NOT_FINITE,
    REFUSED,
    TRACEBACK,
    Outcome,
    outcome_of,
)
from strategies.parsers import lay_out, parsers
from strategies.recording import Call, loaded

# Inputs between two states on disk.
CHUNK = 250
MOST_KEPT = 3  # inputs of each defect
MEMORY = 6 * 1024**3  # bytes of address space: what asks for more must be refused
KINDS = (REFUSED, ACCEPTED, TRACEBACK, NOT_FINITE, HANG)
QUICK = 0.05  # seconds of processor time that a call takes which is made often
ROOT = Path(__file__).resolve().parents[2]
# Tests whose calls are given again, wrongly.
RECORDED = ("tests/test_dynamics", "tests/test_regression/test_law.py",
"tests/test_regression/test_formulas.py",
            "tests/test_regression/test_formulas.py")  # fmt: skip
QUIET = ("-q", "-p", "no:cacheprovider", "-n", "0", "-m", "not slow")
Try = Callable[[Any], Outcome]


class Row:
    """A row of the table: what is counted, chunk by chunk, in a file of its own.

    Chunks that held defects are given again, for what brought them may be mended.
    """

    def __init__(self, name: str, folder: Path, fresh: bool = False) -> None:
        self.name, self.path = name, folder / f"{name.replace(' ', '-')}.json"
        kept = self.path.is_file() and not fresh
        read: dict[str, Any] = json.loads(self.path.read_text(encoding="utf-8")) if kept else {}
        self.chunks = {first: one for first, one in read.items() if not one["defects"]}

    @property
    def counts(self) -> Counter[str]:
        """How many inputs there were of each outcome."""
        return sum((Counter(one["counts"]) for one in self.chunks.values()), Counter())

    @property
    def defects(self) -> dict[str, list[str]]:
        """Some inputs of each defect."""
        found: dict[str, list[str]] = {}
        for one in self.chunks.values():
            for defect, inputs in one["defects"].items():
                found[defect] = (found.get(defect, []) + inputs)[:MOST_KEPT]
        return found

    def note(self, first: str, given_input: Any, outcome: Outcome) -> None:
        """Count what came of an input of a chunk, and keep it if that is a defect."""
        chunk = self.chunks.setdefault(first, {"counts": {}, "defects": {}})
        chunk["counts"][outcome.kind] = chunk["counts"].get(outcome.kind, 0) + 1
        if not outcome.good:
            kept = chunk["defects"].setdefault(f"{outcome.kind}: {outcome.text}", [])
            if len(kept) < MOST_KEPT:
                kept.append(
                    given_input.decode("latin-1")
                    if isinstance(given_input, bytes)
                    else repr(given_input)
                )

    def save(self) -> None:
        """Write what is counted."""
        self.path.write_text(json.dumps(self.chunks, indent=1), encoding="utf-8")

    def text(self) -> str:
        """Return the row as it stands in the docs."""
        counts = self.counts
        cells = (counts.total(), *(counts[kind] for kind in KINDS))
        return f"| {self.name} | " + " | ".join(f"{cell:,}" for cell in cells) + " |"


def attack(row: Row, inputs: st.SearchStrategy[Any], attempt: Try, most: int) -> None:
    """Give the inputs of all chunks that are missing."""
    for first in range(1, most + 1, CHUNK):
        if str(first) in row.chunks:
            continue
        give(row, first, min(CHUNK, most + 1 - first), inputs, attempt)
        row.save()
        counts = row.counts
        print(
            f"\r{row.name}: {counts.total()}, {sum(counts[kind] for kind in DEFECTS)} bad ",
            end="",
            file=sys.stderr,
        )
    print(file=sys.stderr)


def give(row: Row, first: int, count: int, inputs: st.SearchStrategy[Any], attempt: Try) -> None:
    """Give one chunk, drawn by the number of its first input."""

    @seed(first)
    @given(one=inputs)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def chunk(one: Any) -> None:
        row.note(str(first), one, attempt(one))

    chunk()


def targets(
    folder: Path, calls: Path, names: list[str]
) -> dict[str, tuple[st.SearchStrategy[Any], Try, float]]:
    """Return by name what is attacked: its inputs, what tries one, and its share of the inputs."""

    def wanted(name: str) -> bool:
        return not names or any(name.startswith(one) for one in names)

    lay_out(folder)
    found: dict[str, tuple[st.SearchStrategy[Any], Try, float]] = {}
    for name, parser in parsers().items():
        found[name] = parser.inputs, partial(parser.attempt, folder=folder), parser.share
    command_lines.lay_out(folder)
    found["command line"] = (
        command_lines.command_lines(),
        partial(command_lines.run_command, folder=folder),
        1.0,
    )
    for name, (questions, asking) in of_satellites("ASKED").items():
        found[name] = questions(), asking(folder), 1.0
    if wanted("public functions"):
        quick, slow = recorded_calls(calls)
        found["public functions"] = wrong_calls(quick), Attempted.outcome, 1.0
        found["public functions, slow"] = wrong_calls(slow), Attempted.outcome, 0.05
    return {name: one for name, one in found.items() if wanted(name)}


def recorded_calls(path: Path) -> tuple[dict[str, list[Call]], dict[str, list[Call]]]:
    """Return calls of the public functions as the tests make them, quick ones and those that take longer."""
    if not path.is_file():
        print(f"{path}: recording the calls that the tests make ...", file=sys.stderr)
        plugin = ["-p", "strategies.recording", "--calls", str(path.absolute()), *QUIET]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}
        subprocess.run(
            [sys.executable, "-m", "pytest", *plugin, *RECORDED],
            cwd=ROOT,
            env=environment,
            check=False,
        )
    quick: dict[str, list[Call]] = {}
    slow: dict[str, list[Call]] = {}
    for name, calls in loaded(path.read_bytes()).items():
        for call in calls if is_asked(name) else ():
            start = time.process_time()
            if outcome_of(partial(made, call)).kind in (ACCEPTED, NOT_FINITE):
                kind = quick if time.process_time() - start < QUICK else slow
                kind.setdefault(name, []).append(call)
    print(f"{len(quick.keys() | slow.keys())} functions, {len(slow)} of them slow", file=sys.stderr)
    return quick, slow


def main() -> None:
    """Run the campaign and print its table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("names", nargs="*", metavar="NAME")
    options.add_argument("--inputs", type=int, default=20_000)
    options.add_argument("--folder", type=Path, default=Path("fuzzing-results"))
    options.add_argument("--fresh", action="store_true")
    asked = options.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    asked.folder.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for name, (inputs, attempt, share) in targets(
            Path(scratch), asked.folder / "calls.pickle", asked.names
        ).items():
            row = Row(name, asked.folder, asked.fresh)
            attack(row, inputs, attempt, int(share * asked.inputs))
            rows.append(row)
    print("| parser | inputs | refused | accepted | tracebacks | not finite | hangs |")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        print(row.text())
    for row in rows:
        for defect, kept in row.defects.items():
            print(f"{row.name}: {defect} ({len(kept)} kept)")


if __name__ == "__main__":
    main()
