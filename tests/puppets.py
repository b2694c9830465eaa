"""Worker processes that do no finite elements."""

import os
import subprocess
import sys
from pathlib import Path

from regression.runs import workers as workers_module

# Goes before a puppet's own code: the requests as they come, and how to answer one.
PRELUDE = """
import os, pickle, sys, time
def requests():
    while True:
        try:
            _, (request,), _ = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        yield request
def answer(content):
    pickle.dump(("result", content), sys.stdout.buffer)
    sys.stdout.buffer.flush()
"""


def puppet(code):
    """Start a worker process that runs this code."""
    return subprocess.Popen(
        [sys.executable, "-S", "-c", PRELUDE + code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )


def spawned(monkeypatch, program):
    """Make workers puppets that run a program, and return the list of those started."""
    started = []

    def spawn():
        started.append(puppet(program))
        return started[-1]

    monkeypatch.setattr(workers_module, "spawn_worker", spawn)
    return started


def marked(mark):
    """Return the living processes with a mark, this one left out."""
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            environment = (folder / "environ").read_bytes().split(b"\0")
            state = (folder / "stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if mark in environment and state not in "ZX":
            found.append(int(folder.name))
    return found
