"""Calls in a separate process, which may crash or hang: only the call is lost.

A request names a function and gives its arguments; the response is its result, or the error it raised.
Both are pickled, through pipes read by a thread, so that the caller can check time and memory.
"""

import contextlib
import os
import pickle
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from queue import Empty, SimpleQueue
from typing import Any, BinaryIO, NoReturn

from crankbase.errors import (
    InputError,
    MeshError,
    MissingLibraryError,
    NotEnoughMemoryError,
    SolveError,
)
from crankbase.processes import end_child, signal_name

ERRORS: dict[str, type[Exception]] = {
    kind.__name__: kind
    for kind in (InputError, MeshError, MissingLibraryError, NotEnoughMemoryError, SolveError)
}
REMARK, RESULT = "remark", "result"
# Seconds between two looks at a process's time and memory.
WATCH = 0.1
GIGABYTE = 1e9

# What a process has sent: a kind and its content, or None when it is gone.
Message = tuple[str, Any] | None
Messages = SimpleQueue[tuple[Any, Message]]


@dataclass(frozen=True)
class Limits:
    """Limits of one call, after which its process is ended.

    Attributes
    ----------
    seconds : float
        Time to the next remark or the response [s].
    memory : float or None
        Resident memory of the process [byte], its libraries included; None for no limit.
    tree : bool
        Whether to include the memory of all processes started by it.
    """

    seconds: float
    memory: float | None = None
    tree: bool = False


class ProcessLostError(Exception):
    """The process died, or had to be ended; the text states why, `seconds` the time until then."""

    def __init__(self, reason: str, seconds: float = 0.0) -> None:
        super().__init__(reason)
        self.seconds = seconds


class CallProcess:
    """A process that handles calls by `serve`, one at a time, until it is lost or ended.

    Parameters
    ----------
    process : subprocess.Popen
        With pipes for its standard input and output.
    what : str
        Its name in reasons, such as "the worker process".
    messages : SimpleQueue, optional
        Queue for its messages, if one is to be used for several processes.
    """

    def __init__(
        self, process: subprocess.Popen[bytes], what: str, messages: Messages | None = None
    ) -> None:
        self.name = f"{socket.gethostname()}:{process.pid}"
        self._process, self._what = process, what
        self._messages: Messages = SimpleQueue() if messages is None else messages
        self._started, self._peak = time.monotonic(), 0.0

        def listen() -> None:
            assert process.stdout is not None
            with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError):
                while True:
                    self._messages.put((self, pickle.load(process.stdout)))
            self._messages.put((self, None))

        self._listener = threading.Thread(target=listen, daemon=True)
        self._listener.start()

    def give(self, function: str, *arguments: Any, remarks: bool = False) -> None:
        """Send it a call of ``"module:name"``; with remarks, the function gets an ``on_remark``."""
        request = pickle.dumps((function, arguments, remarks))
        self._started, self._peak = time.monotonic(), 0.0
        assert self._process.stdin is not None
        # If it died, its closed output is read next and settles the call.
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(request)
            self._process.stdin.flush()

    def take(self, message: Message) -> tuple[str, Any]:
        """Return a message of this process.

        Raises
        ------
        ProcessLostError
            If it is gone instead.
        """
        if message is None:
            code = self._process.wait()
            ending = f"died (exit code {code})"
            if name := signal_name(code):
                hint = ", as the system does when memory runs out" if name == "SIGKILL" else ""
                ending = f"was ended by {name}{hint}"
            self.lose(f"{self._what} {ending}")
        return message

    def watch(self, limits: Limits) -> None:
        """Check time and memory.

        Raises
        ------
        ProcessLostError
            If one exceeds its limit, and the process had to be ended.
        """
        if self.seconds > limits.seconds:
            self.lose(f"took longer than the limit of {limits.seconds:g} s")
        if limits.memory is None:
            return
        self._peak = max(self._peak, _memory(self._process.pid, limits.tree))
        if self._peak > limits.memory:
            self.lose(
                f"took {self._peak / GIGABYTE:.2f} GB of memory, more than the limit of "
                f"{limits.memory / GIGABYTE:g} GB"
            )

    def wait(
        self, limits: Limits, on_remark: Callable[[Any], None] | None = None
    ) -> tuple[str, Any]:
        """Wait for the response, for `answered`, within limits; call `on_remark` with each remark.

        Raises
        ------
        ProcessLostError
            If the process is gone, or had to be ended.
        """
        self._started = time.monotonic()
        while True:
            try:
                _, message = self._messages.get(timeout=min(WATCH, limits.seconds))
            except Empty:
                self.watch(limits)
                continue
            kind, content = self.take(message)
            if kind != REMARK:
                return kind, content
            self._started = time.monotonic()
            if on_remark is not None:
                on_remark(content)

    @property
    def seconds(self) -> float:
        """Seconds since the last call, the start of the wait or the last remark."""
        return time.monotonic() - self._started

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def kill(self) -> None:
        """Kill the process; a wait for its response then ends."""
        self._process.kill()

    def end(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._listener.join()
        end_child(self._process)

    def lose(self, reason: str) -> NoReturn:
        """End the process and raise the reason of its loss."""
        seconds = self.seconds
        self.end()
        raise ProcessLostError(reason, seconds)


def _memory(number: int, tree: bool) -> float:
    """Resident memory of a process, optionally with its descendants [byte]; zero for ended ones."""
    import psutil

    total = 0.0
    with contextlib.suppress(psutil.Error):  # gone: its closed output says so
        process = psutil.Process(number)
        for running in [process, *(process.children(recursive=True) if tree else ())]:
            with contextlib.suppress(psutil.Error):
                total += running.memory_info().rss
    return total


def answered(kind: str, content: Any) -> Any:
    """Return the result in a response, or raise its error.

    Raises
    ------
    InputError, MeshError, MissingLibraryError, SolveError
        As raised by the function.
    RuntimeError
        For any other error of the function.
    """
    if kind == RESULT:
        return content
    raise ERRORS.get(kind, RuntimeError)(content)


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Handle calls until there are no more."""

    def send(kind: str, content: Any) -> None:
        pickle.dump((kind, content), answers)
        answers.flush()

    while True:
        try:
            function, arguments, remarks = pickle.load(requests)
        except EOFError:
            return
        extra = {"on_remark": lambda content: send(REMARK, content)} if remarks else {}
        try:
            result = _named(function)(*arguments, **extra)
        except Exception as error:  # passed on to the caller
            known = type(error).__name__ in ERRORS
            text = str(error) if known else f"{type(error).__name__}: {error}"
            send(type(error).__name__, text)
        else:
            send(RESULT, result)


def _named(function: str) -> Callable[..., Any]:
    module, name = function.split(":")
    made: Callable[..., Any] = getattr(import_module(module), name)
    return made


def main() -> None:
    """Serve on standard input and output, protected from prints of libraries, after loading given modules."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    for load in sys.argv[1:]:
        with contextlib.suppress(MissingLibraryError):  # said again when the library is needed
            _named(load)()  # while the owner is still busy
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
