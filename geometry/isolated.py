"""Call functions in a separate process: gmsh may crash or hang there, and only the call is lost.

The process is started once, handles one call after another, and ends with this one.
"""

import atexit
import os
import subprocess
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from crankbase.calls import CallProcess, Limits, answered
from crankbase.processes import start_child


class IsolatedProcess:
    """A process that calls functions of our packages by name, from any thread, one at a time."""

    def __init__(self) -> None:
        self._process: CallProcess | None = None
        self._lock = threading.Lock()

    def start(self) -> CallProcess:
        """Start the process, if none runs, so that it is ready when needed."""
        if self._process is None or not self._process.alive:
            child = start_child(
                "crankbase.calls",
                "geometry.built_solid:keep_solids",
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            self._process = CallProcess(child, "the process that called gmsh")
        return self._process

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.end()

    def call(
        self,
        function: str,
        *arguments: Any,
        time_limit: float,
        on_remark: Callable[[Any], None] | None = None,
    ) -> Any:
        """Call a function there.

        Parameters
        ----------
        function : str
            ``"module:name"``. If `on_remark` is given, the function gets a callable of that name.
        *arguments
            Any that can be pickled.
        time_limit : float
            Time limit to the next remark or the result [s].
        on_remark : callable, optional
            Called here with each remark that the function makes there.

        Raises
        ------
        crankbase.calls.ProcessLostError
            If the process died or took too long; the next call starts a fresh one.
        InputError, MeshError, MissingLibraryError
            As raised by the function.
        """
        with self._lock:
            try:
                process = self.start()
                process.give(function, *arguments, remarks=on_remark is not None)
                answer = process.wait(Limits(time_limit), on_remark)
            except BaseException:
                # An answer may still be on its way: it must not be taken for that of the next call.
                self.close()
                raise
        return answered(*answer)


@cache
def _process_of(_owner: int) -> IsolatedProcess:
    process = IsolatedProcess()
    atexit.register(process.close)
    return process


def shared_process() -> IsolatedProcess:
    """Return the process shared by all calls from this one; a forked child gets its own."""
    return _process_of(os.getpid())
