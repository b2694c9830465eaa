"""What all faults share: a study and its undisturbed results, commands under a time limit, and the judge."""

import hashlib
import json
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import psutil
from study_tools import THROW, environment, study, study_file, total

from geometry.throw import CrankThrow

# Eight designs of a plain throw, which cost little.
PLAIN = {"fillet_radius": 0.0, "main_journal_bore": 0.0, "pin_bore": 0.0}
STUDY = (8, 0.1, ("web_width", "pin_length"), CrankThrow(**THROW.model_dump() | PLAIN))
# Seconds after which a command hangs: a hundred times what it takes alone on a quiet machine.
HANGS = 400.0
# Codes of commands that end with a sentence; negative ones are kills of ours.
CODES = (0, 2, 3, 130)
# What must be the same, to the last bit, as in a study that nobody disturbs.
SAME = ("status", "inputs", "responses", "errors", "unknowns", "model_version")


@dataclass
class Finding:
    """What became of one trial."""

    inputs: int = 0
    lost: int = 0
    silent: int = 0
    tracebacks: int = 0
    hangs: int = 0
    words: list[str] = field(default_factory=list)

    @property
    def good(self) -> bool:
        return not (self.lost or self.silent or self.tracebacks or self.hangs)

    def says(self, text: str) -> None:
        """Keep a sentence that was printed, or what is wrong."""
        sentence = " ".join(text.split())
        if sentence and sentence not in self.words:
            self.words.append(sentence)


@dataclass(frozen=True)
class Ended:
    """A command that has ended."""

    code: int
    out: str
    errors: str


class Bench:
    """A folder with a study file, the undisturbed results of the study, and how long they took."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.plan = study(*STUDY)
        self.wanted = total(self.plan)
        self.file = study_file(folder / "study.toml", *STUDY)
        self.finished = folder / "reference.sqlite"
        began, finding = time.monotonic(), Finding()
        if not (folder / "seconds").exists():
            ended = self.end(self.doe(self.finished), finding)
            assert ended.code == 0, ended.errors
            (folder / "seconds").write_text(str(time.monotonic() - began))
        self.seconds = float((folder / "seconds").read_text())
        self.reference = {key: self.digest(row) for key, row in rows(self.finished).items()}
        assert len(self.reference) == self.wanted

    def doe(self, store: Path, *options: object, **process: object) -> "subprocess.Popen[str]":
        """Start the study in a store."""
        return command("doe", self.file, "--store", store, "--json", "-q", *options, **process)

    @staticmethod
    def digest(row: dict[str, object]) -> str:
        """Hash what must be the same in every run."""
        text = json.dumps([row[name] for name in SAME])
        return hashlib.sha256(text.encode()).hexdigest()

    def end(self, process: "subprocess.Popen[str]", finding: Finding) -> Ended:
        """Wait for a command; it must end in time, without a traceback, with a sentence if it fails."""
        try:
            out, errors = process.communicate(timeout=HANGS)
        except subprocess.TimeoutExpired:
            finding.hangs += 1
            process.kill()
            out, errors = process.communicate()
        if "Traceback" in out + errors or "an unexpected error" in errors:
            finding.tracebacks += 1
            finding.says(errors[-600:])
        code = process.returncode
        if code not in CODES and code != -signal.SIGKILL:
            finding.silent += 1
            finding.says(f"exit code {code}: {errors[-300:]}")
        elif code > 0:
            if "Error: " not in errors and "Stopped" not in errors:
                finding.silent += 1
            finding.says(errors[-300:])
        return Ended(code, out, errors)

    def judge(self, store: Path, finding: Finding, before: dict[str, dict[str, object]]) -> None:
        """Find finished designs that are gone or changed, and results that are wrong without a word."""
        now = rows(store, finding)
        for key, row in before.items():
            if row["status"] == "done" and now.get(key) != row:
                finding.lost += 1
                finding.says(f"{key} was finished, and is {'changed' if key in now else 'gone'}")
        for key, row in now.items():
            if row["status"] == "done" and self.reference.get(key) != self.digest(row):
                finding.silent += 1
                finding.says(f"{key} differs from the undisturbed run")

    def complete(self, store: Path, finding: Finding, *options: object) -> None:
        """Run the study to its end: all designs are there then, each as in the undisturbed run."""
        before = rows(store, finding)
        ended = self.end(self.doe(store, *options), finding)
        if ended.code == 0 and lost_rows(store):  # with both of their workers: tried again
            ended = self.end(self.doe(store, *options), finding)
        self.judge(store, finding, before)
        missing = self.wanted - sum(row["status"] == "done" for row in rows(store).values())
        if ended.code != 0 or missing:
            finding.lost += max(missing, 1)
            finding.says(f"{missing} designs missing in the end: {ended.errors[-300:]}")


def command(*arguments: object, **process: object) -> "subprocess.Popen[str]":
    """Start crankfem."""
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "crankfem", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **({"env": environment()} | process),
    )


def rows(store: Path, finding: Finding | None = None) -> dict[str, dict[str, object]]:
    """All rows of a store by design, as any program reads them; with `finding` its file is judged too."""
    if not store.is_file() or not store.stat().st_size:
        return {}
    with closing(sqlite3.connect(store, timeout=60.0)) as connection:
        connection.row_factory = sqlite3.Row
        connection.text_factory = lambda raw: raw.decode("utf-8", "surrogateescape")
        try:
            found = [text for (text,) in connection.execute("PRAGMA integrity_check")]
            listed = connection.execute("SELECT * FROM designs").fetchall()
        except sqlite3.OperationalError:  # the tables are not made yet
            return {}
        except sqlite3.DatabaseError as error:
            if finding is None:
                raise
            finding.lost += 1
            finding.says(f"cannot be read: {error}")
            return {}
    if finding is not None and found != ["ok"]:
        finding.lost += 1
        finding.says(f"integrity_check: {found[0]}")
    return {row["key"]: dict(row) for row in listed}


def lost_rows(store: Path) -> list[str]:
    """Reasons of the designs that were lost with their workers."""
    return [str(row["reason"]) for row in rows(store).values() if row["status"] == "lost"]


def workers(process: "subprocess.Popen[str]") -> list[psutil.Process]:
    """Worker and mesher processes of a command."""
    try:
        children = psutil.Process(process.pid).children(recursive=True)
        return [child for child in children if "crankbase.calls" in child.cmdline()]
    except psutil.Error:
        return []


def kill(process: "subprocess.Popen[str]", finding: Finding) -> None:
    """Kill a command as the system would; its children must end with it."""
    children = workers(process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    await_end(children, finding)


def await_end(children: list[psutil.Process], finding: Finding) -> None:
    """Wait for the children of a command that has ended."""
    _, alive = psutil.wait_procs(children, timeout=30.0)
    if alive:
        finding.hangs += len(alive)
        finding.says(f"{len(alive)} children outlive their owner")
        for child in alive:
            child.kill()
