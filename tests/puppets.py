"""Worker processes that do no finite elements."""

import subprocess
import sys

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
