"""Child processes and scratch folders that end with the process that made them.

A child detects the end of its owner by a pipe that only the owner holds open: the system closes it, so this
needs no handler in the owner, which may be killed. On Linux the end of the pipe is a signal to the child,
which also ends it if a library blocks Python's threads; elsewhere a thread waits for it.

This file is also run by its path as the child's first program, so it uses only the standard library.
"""

import contextlib
import gc
import os
import runpy
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

T = TypeVar("T")

# What the child does: run a module, or remove a folder when its owner is done or gone.
MODULE, REMOVE = "module", "remove"
# Where no pipe can be handed on, as on Windows.
NO_PIPE = -1
# Seconds between two looks at who the owner is; the end of the pipe is seen at once.
LOOK = 0.5
# So many new objects are made before Python looks for circles of references among them: with its own number
# it does so all through the loading of libraries, which makes a twentieth of a run.
GARBAGE_THRESHOLD = 200_000
# A folder in which a dying process still writes is removed by one of so many tries, so many seconds apart.
TRIES, PAUSE = 20, 0.05


def once_per_process(make: Callable[[], T]) -> Callable[[], T]:
    """Let a function make what it returns once in a process; a forked child gets one of its own."""

    @cache
    def made_by(_process: int) -> T:
        return make()

    @wraps(make)
    def shared() -> T:
        return made_by(os.getpid())

    return shared


def start_child(
    module: str, *arguments: str, environment: Mapping[str, str] | None = None, **streams: Any
) -> subprocess.Popen[bytes]:
    """Run a module of ours as ``python -m module`` in a process that ends with this one.

    The child ignores interrupts; its owner handles them.

    Parameters
    ----------
    *arguments : str
        Its ``sys.argv``.
    environment : mapping, optional
        Added to that of this process.
    **streams
        ``stdin``, ``stdout`` and ``stderr``, as for `subprocess.Popen`.

    Raises
    ------
    OSError
        If the process cannot be started.
    """
    passes = os.name == "posix"
    # A new Python finds our packages, however this one found them.
    home = str(Path(__file__).resolve().parent.parent)
    paths = [home, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    python_path = {"PYTHONPATH": os.pathsep.join(paths)}
    end, held = map(_beyond_standard_streams, os.pipe())
    try:
        process = subprocess.Popen(
            # -P keeps a folder named like our packages in the working directory out of the way.
            [
                sys.executable, "-P", __file__, MODULE,
                str(end if passes else NO_PIPE), module, *arguments,
            ],
            env=os.environ | python_path | dict(environment or {}),
            pass_fds=(end,) if passes else (),
            **streams,
        )  # fmt: skip
    except BaseException:
        os.close(held)
        raise
    finally:
        os.close(end)
    weakref.finalize(process, os.close, held)
    return process


def _beyond_standard_streams(end: int) -> int:
    """Move an open file from the number of a closed standard stream, where a child has its own."""
    if end > 2 or os.name != "posix":
        return end
    import fcntl

    moved = fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 3)
    os.close(end)
    return moved


def end_child(process: subprocess.Popen[bytes]) -> None:
    """End a process in any state, and close the pipes to it."""
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(BrokenPipeError):
                pipe.close()


def signal_name(code: int) -> str | None:
    """Name of the signal that ended a process with this code; None if none did, or none that has one."""
    try:
        return signal.Signals(-code).name
    except ValueError:
        return None


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """Create a folder that is removed at the end of the block, or with this process, however it ends.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    folder = Path(tempfile.gettempdir(), f"crankfem-{uuid4().hex}")
    # It must outlive this process, and what interrupts or ends the processes of a terminal together.
    # It starts before there is a folder, so no moment is left in which the folder has no guard.
    guard = subprocess.Popen(
        [sys.executable, "-I", "-S", __file__, REMOVE, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    )
    try:
        folder.mkdir(mode=0o700)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        assert guard.stdin is not None
        guard.stdin.close()
        guard.wait()


def _remove_at_the_end(folder: str) -> None:
    """Remove a folder when standard input ends."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    sys.stdin.buffer.read()
    for _ in range(TRIES):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.lexists(folder):
            return
        time.sleep(PAUSE)


def _end_with_owner(pipe: int) -> None:
    """Let this process end as soon as its owner does, in any state."""
    owner = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if pipe != NO_PIPE and hasattr(os, "O_ASYNC"):
        import fcntl

        # Linux ends a process by this signal if nobody handles it; other systems ignore it.
        signal.signal(signal.SIGIO, signal.SIG_DFL)
        fcntl.fcntl(pipe, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    threading.Thread(target=_wait_for_the_end, args=(owner, pipe), daemon=True).start()


def _wait_for_the_end(owner: int, pipe: int) -> None:
    if pipe == NO_PIPE:
        while os.getppid() == owner:
            time.sleep(LOOK)
    else:
        ended = select.poll()
        ended.register(pipe, select.POLLIN)
        # A fork of the owner may hold the pipe open beyond its end.
        while os.getppid() == owner and not ended.poll(1000.0 * LOOK):
            pass
    os._exit(1)


def _main() -> None:
    task, *arguments_left = sys.argv[1:]
    if task == REMOVE:
        _remove_at_the_end(*arguments_left)
        return
    gc.set_threshold(GARBAGE_THRESHOLD)
    pipe, module, *arguments = arguments_left
    _end_with_owner(int(pipe))
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    _main()
