"""The log: lines of JSON on standard error."""

import contextlib
import sys
import time
from typing import Any

from pydantic_core import to_json


def log_line(**told: Any) -> None:
    """Write a line; one that finds no space, or no reader, is lost."""
    line = to_json({"time": round(time.time(), 3)} | told).decode()
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write(f"{line}\n")
