"""Faults of files and disks: torn stores, half-written folders, full disks, read-only folders, no memory."""

import json
import resource
import shutil
import sqlite3
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from random import Random

from fault_tools import Bench, Finding, command, kill, rows
from study_tools import environment

PAGE = 4096


def _checked(bench: Bench, store: Path, finding: Finding, whole: bool) -> Finding:
    """A damaged store is reported, and refused or completed: no wrong row is ever used."""
    before = rows(bench.finished)
    checked = bench.end(command("verify", store), finding)
    if checked.code == 0 and not whole:
        # Nothing but what holds no data may be damaged.
        try:
            sound = rows(store) == before
        except (sqlite3.DatabaseError, UnicodeDecodeError):
            sound = False
        finding.silent += not sound
    completed = bench.end(command("doe", bench.file, "--store", store, "-q"), finding)
    if completed.code != 0:
        return finding
    now = rows(store, finding)
    changed = (
        [k for k in before if bench.digest(now[k]) != bench.digest(before[k])] if now else [""]
    )
    finding.lost += len(changed)
    finding.says(f"changed after the next run: {changed}" if changed else "")
    return finding


def cut(bench: Bench, draw: Random, store: Path) -> Finding:
    """Cut a store at a random length."""
    store.write_bytes(bench.finished.read_bytes())
    with store.open("r+b") as file:
        file.truncate(draw.randrange(PAGE, store.stat().st_size))
    return _checked(bench, store, Finding(inputs=1), False)


def torn(bench: Bench, draw: Random, store: Path) -> Finding:
    """Write noise over a page of a store, or over single bytes."""
    content = bytearray(bench.finished.read_bytes())
    if draw.random() < 0.5:
        page = draw.randrange(1, len(content) // PAGE) * PAGE
        content[page : page + PAGE] = draw.randbytes(PAGE)
    else:
        for _ in range(20):
            content[draw.randrange(100, len(content))] = draw.randrange(256)
    store.write_bytes(content)
    return _checked(bench, store, Finding(inputs=1), False)


def without_log(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill the coordinator, then take the log of the store away."""
    finding = Finding(inputs=1)
    process = bench.doe(store)
    with suppress(subprocess.TimeoutExpired):
        process.wait(draw.uniform(0.2, 1.0) * bench.seconds)
    # What is in the file is known without the log; the last design may still be on its way.
    kill(process, finding)
    with_log = store.parent / f"{store.stem}-with-log.sqlite"
    for ending in ("", "-wal"):
        if Path(f"{store}{ending}").exists():
            shutil.copy(f"{store}{ending}", f"{with_log}{ending}")
    before = rows(with_log)
    for ending in ("-wal", "-shm"):
        Path(f"{store}{ending}").unlink(missing_ok=True)
    now = rows(store)
    finding.lost += max(0, len(before) - len(now) - 1)
    finding.says(
        f"{len(before) - len(now)} finished designs stood in the log alone" if before != now else ""
    )
    bench.complete(store, finding)
    return finding


@contextmanager
def mounted(folder: Path, kilobytes: int) -> Iterator[Path]:
    """A small disk in memory."""
    folder.mkdir()
    subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", folder], check=True
    )
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


def full_disk(bench: Bench, draw: Random, store: Path) -> Finding:
    """Run a study on a disk that runs full, then with space."""
    finding = Finding(inputs=1)
    most = bench.finished.stat().st_size // 1000
    with mounted(store.with_suffix(""), draw.randrange(8, 2 * most)) as folder:
        own = folder / "runs.sqlite"
        bench.end(bench.doe(own), finding)
        before = rows(own)
        bench.judge(own, finding, before)
        subprocess.run(["mount", "-o", "remount,size=9000k", folder], check=True)
        bench.complete(own, finding)
        bench.judge(own, finding, before)
    return finding


def full_scratch(bench: Bench, draw: Random, store: Path) -> Finding:
    """Run a study whose temporary files find no space."""
    finding = Finding(inputs=1)
    with mounted(store.with_suffix(""), draw.randrange(4, 40)) as folder:
        process = bench.doe(store, env=environment() | {"TMPDIR": str(folder)})
        bench.end(process, finding)
    bench.complete(store, finding)
    return finding


def file_limit(bench: Bench, draw: Random, store: Path) -> Finding:
    """Run a study whose files may not grow beyond a random size."""
    finding = Finding(inputs=1)
    most = draw.randrange(10_000, bench.finished.stat().st_size)
    process = bench.doe(
        store, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    )
    bench.end(process, finding)
    bench.complete(store, finding)
    return finding


def read_only(bench: Bench, draw: Random, store: Path) -> Finding:
    """Work in a folder that can only be read."""
    finding = Finding(inputs=1)
    with mounted(store.with_suffix(""), 9000) as folder:
        own = folder / "runs.sqlite"
        with (
            closing(sqlite3.connect(bench.finished)) as whole,
            closing(sqlite3.connect(own)) as part,
        ):
            whole.backup(part)
            part.execute("DELETE FROM designs WHERE rowid > ?", (draw.randrange(1, bench.wanted),))
            part.commit()
        before = rows(own)
        subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
        for line in (
            ("doe", bench.file, "--store", own),
            ("doe", bench.file, "--store", folder / "new.sqlite"),
            ("verify", own),
            ("fit", own),
            ("results", bench.finished, folder / "table.csv"),
        ):
            bench.end(command(*line, cwd=bench.folder), finding)
        subprocess.run(["mount", "-o", "remount,rw", folder], check=True)
        bench.judge(own, finding, before)
        bench.complete(own, finding)
    return finding


def results_folder(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill a whole run, or cut one of its files: the next run writes the same results."""
    finding = Finding(inputs=1)
    engine, whole = bench.folder / "mine.toml", bench.folder / "whole"
    if not engine.exists():
        bench.end(command("new", engine, "--cylinders", 1), finding)
    line = ("run", engine, "-q", "--output")
    if not (whole / "report.html").exists():
        bench.end(command(*line, whole), finding)
    folder = store.with_suffix("")
    if draw.random() < 0.7:
        process = command(*line, folder)
        with suppress(subprocess.TimeoutExpired):
            process.wait(draw.uniform(0.0, 60.0))
        kill(process, finding)
    else:
        shutil.copytree(whole, folder)
        torn_file = draw.choice(sorted(path for path in folder.rglob("*") if path.is_file()))
        with torn_file.open("r+b") as file:
            file.truncate(draw.randrange(1 + torn_file.stat().st_size))
        finding.says(f"cut: {torn_file.suffix or torn_file.name}")
    ended = bench.end(command(*line, folder), finding)
    if ended.code == 2:  # a cut file is none of its own any more: it is not replaced unasked
        ended = bench.end(command(*line, folder, "--force"), finding)
    finding.lost += ended.code != 0
    expected, found = (_numbers(one / "results.json") for one in (whole, folder))
    finding.silent += expected != found
    names = [
        sorted(p.name for p in one.iterdir() if p.suffix != ".sqlite") for one in (whole, folder)
    ]
    finding.lost += len(set(names[0]) - set(names[1]))
    return finding


def _numbers(path: Path) -> object:
    """Content of a results file without what tells of time and place."""

    def plain(content: object) -> object:
        if isinstance(content, dict):
            return {k: plain(own) for k, own in content.items() if k not in LEFT_OUT}
        return [plain(own) for own in content] if isinstance(content, list) else content

    return plain(json.loads(path.read_text(encoding="utf-8")))


LEFT_OUT = ("about", "seconds", "created", "output", "folder", "profile", "file")
