"""The free memory, and a refusal of work that is predicted to need more."""

import contextlib
from pathlib import Path

from crankbase.calls import GIGABYTE
from crankbase.errors import NotEnoughMemoryError

# Limit, use and statistics of a control group (a container), of its second and first version.
CONTROL_GROUPS = (
    ("memory.max", "memory.current", "memory.stat"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "memory/memory.stat"),
)
CONTROL_FOLDER = Path("/sys/fs/cgroup")
# Of files in the page cache, which give way, in the statistics.
CACHED = ("inactive_file", "total_inactive_file")
# So much is there on any machine that loads the libraries; it is not asked for.
LITTLE = 0.1 * GIGABYTE


def free_memory() -> float:
    """Return the free memory [byte]: of the machine, or of its container if that is less."""
    import psutil  # takes long to load, and little memory is not asked for

    free = float(psutil.virtual_memory().available)
    for limit, use, statistics in CONTROL_GROUPS:
        # No such files, or no limit, which version 2 calls "max".
        with contextlib.suppress(OSError, ValueError):
            allowed = float((CONTROL_FOLDER / limit).read_text(encoding="ascii"))
            used = float((CONTROL_FOLDER / use).read_text(encoding="ascii"))
            words = (CONTROL_FOLDER / statistics).read_text(encoding="ascii").split()
            numbers = dict(zip(words[::2], words[1::2], strict=False))
            cached = max(float(numbers.get(name, 0.0)) for name in CACHED)
            free = min(free, max(allowed - used + cached, 0.0))
    return free


def check_memory(needed: float, request: str, advice: str) -> None:
    """Refuse work that needs more memory than is free.

    Parameters
    ----------
    needed : float
        Predicted [byte].
    request : str
        The request, such as "accuracy: given 0.001, whose mesh takes".
    advice : str
        The remedy, after "so".

    Raises
    ------
    NotEnoughMemoryError
    """
    if needed <= LITTLE:
        return
    free = free_memory()
    if needed > free:
        raise NotEnoughMemoryError(
            f"{request} about {needed / GIGABYTE:.2g} GB of memory; allowed is what fits into the "
            f"{free / GIGABYTE:.2g} GB that are free, so {advice}."
        )
