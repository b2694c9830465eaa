"""Call functions in a process of its own: gmsh may crash or hang there, and only the call is lost.

The process is started once, serves one call after another, and ends with this one.
"""

import atexit
import contextlib
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any, BinaryIO

from crankbase.errors import InputError, MeshError, MissingLibraryError
from crankbase.processes import end_child, signal_name, start_child

ERRORS: dict[str, type[Exception]] = {
    kind.__name__: kind for kind in (InputError, MeshError, MissingLibraryError)
}
REMARK, RESULT = "remark", "result"


class ProcessLostError(Exception):
    """The process died or took too long; the text says which."""


class IsolatedProcess:
    """A process that calls functions of our packages by name, from any thread, one at a time."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def start(self) -> None:
        """Start the process, so that it is ready when needed."""
        if self._process is None or self._process.poll() is not None:
            self._process = start_child(
                "geometry.isolated",
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            end_child(process)

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
            What can be pickled.
        time_limit : float
            Seconds until the next remark or the result.
        on_remark : callable, optional
            Called here with each remark that the function makes there.

        Raises
        ------
        ProcessLostError
            If the process died or took too long; the next call starts a fresh one.
        InputError, MeshError, MissingLibraryError
            As raised by the function.
        """
        request = pickle.dumps((function, arguments, on_remark is not None))
        with self._lock:
            try:
                answered, result = self._exchange(request, time_limit, on_remark)
            except BaseException:
                # An answer may still be on its way: it must not be taken for that of the next call.
                self.close()
                raise
            if not answered:
                raise result
            return result

    def _exchange(
        self,
        request: bytes,
        time_limit: float,
        on_remark: Callable[[Any], None] | None,
    ) -> tuple[bool, Any]:
        """Send a request and wait: (True, the result) or (False, the error that the function raised)."""
        self.start()
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        late = threading.Event()

        def end() -> None:
            late.set()
            process.kill()

        try:
            process.stdin.write(request)
            process.stdin.flush()
            while True:
                timer = threading.Timer(time_limit, end)
                timer.daemon = True
                timer.start()
                try:
                    kind, content = pickle.load(process.stdout)
                finally:
                    timer.cancel()
                if late.is_set():  # killed while the answer was read
                    self.close()
                if kind == RESULT:
                    return True, content
                if kind != REMARK:
                    return False, ERRORS.get(kind, RuntimeError)(content)
                if on_remark is not None:
                    on_remark(content)
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            code = process.wait()
            reason = f"took more than {time_limit:.0f} s" if late.is_set() else _ending(code)
            raise ProcessLostError(f"the process that called gmsh {reason}") from None


def _ending(code: int) -> str:
    name = signal_name(code)
    return f"ended with code {code}" if name is None else f"was ended by {name}"


@cache
def _process_of(_owner: int) -> IsolatedProcess:
    process = IsolatedProcess()
    atexit.register(process.close)
    return process


def shared_process() -> IsolatedProcess:
    """Return the process that all calls from this one share; a forked child gets one of its own."""
    return _process_of(os.getpid())


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer calls until there are no more."""

    def send(kind: str, content: Any) -> None:
        pickle.dump((kind, content), answers)
        answers.flush()

    while True:
        try:
            function, arguments, remarks = pickle.load(requests)
        except EOFError:
            return
        module, name = function.split(":")
        extra = {"on_remark": lambda content: send(REMARK, content)} if remarks else {}
        try:
            result = getattr(import_module(module), name)(*arguments, **extra)
        except Exception as error:  # passed on to the caller
            known = type(error).__name__ in ERRORS
            text = str(error) if known else f"{type(error).__name__}: {error}"
            send(type(error).__name__, text)
        else:
            send(RESULT, result)


def main() -> None:
    """Serve on standard input and output, whatever gmsh may print."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    from geometry.gmsh_session import load_gmsh

    with contextlib.suppress(MissingLibraryError):  # said again when gmsh is needed
        load_gmsh()  # while the owner is still busy
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
