"""What may come of any input: a sentence or a finite result; all else is a defect, and has a name here."""

import contextlib
import dataclasses
import inspect
import re
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel

from crankbase.errors import InputError, MeshError, MissingLibraryError, RenderError
from fem.solver import SolveError
from regression.records import StudyStoppedError

REFUSALS = (InputError, MeshError, MissingLibraryError, RenderError, SolveError, StudyStoppedError)
REFUSED, ACCEPTED = "refused", "accepted"
TRACEBACK, NOT_FINITE, HANG = "traceback", "not finite", "hang"
DEFECTS = (TRACEBACK, NOT_FINITE, HANG)
# Seconds of processor time after which an input hangs, and of waiting on a machine that is busy.
PATIENCE, WAITING = 10.0, 300.0
DEEPEST = 6
# A message is one sentence on each line, and shows nothing of how the program is made.
_SENTENCE = re.compile(r"\S.*[.?!)]", re.DOTALL)
_INNER = re.compile(r"Traceback|object at 0x|<class |<function |np\.float64\(|\barray\(")


@dataclass(frozen=True)
class Outcome:
    """What came of an input: its kind, and of a defect what tells it from others."""

    kind: str
    text: str = ""

    @property
    def good(self) -> bool:
        """Whether it is a sentence or a finite result."""
        return self.kind not in DEFECTS


class HangError(BaseException):
    """Raised by the clock: no `except Exception` holds it up."""


@contextlib.contextmanager
def patience() -> Iterator[None]:
    """Raise HangError where this takes too long."""

    def end(*_: object) -> None:
        raise HangError

    clocks = (
        (signal.SIGPROF, signal.ITIMER_PROF, PATIENCE),
        (signal.SIGALRM, signal.ITIMER_REAL, WAITING),
    )
    before = [signal.signal(number, end) for number, _, _ in clocks]
    for _, clock, seconds in clocks:
        signal.setitimer(clock, seconds, 1.0)  # again, where a callback of Python has swallowed it
    try:
        yield
    finally:
        for (number, clock, _), handler in zip(clocks, before, strict=True):
            signal.setitimer(clock, 0.0)
            signal.signal(number, handler)


def outcome_of(
    call: Callable[[], Any], allowed: Callable[[str], bool] = lambda _: False
) -> Outcome:
    """Make a call, and tell what came of it.

    Parameters
    ----------
    call : callable
    allowed : callable
        Whether a value of this name within the result may be without end; by default none.
    """
    try:
        with patience(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)
            result = call()
            found = [name for name in not_finite(result) if not allowed(name)]
    except REFUSALS as error:
        fault = bad_sentence(str(error))
        return Outcome(TRACEBACK, fault) if fault else Outcome(REFUSED, str(error))
    except HangError:
        return Outcome(HANG, "took too long")
    except (Exception, SystemExit) as error:
        return Outcome(TRACEBACK, where_raised(error))
    return (
        Outcome(NOT_FINITE, f"{type(result).__name__}: {', '.join(found[:4])}")
        if found
        else Outcome(ACCEPTED)
    )


def bad_sentence(message: str) -> str:
    """Say what is wrong with a message; nothing is, if it is empty."""
    for line in message.split("\n"):
        if not _SENTENCE.fullmatch(line) or _INNER.search(line):
            return f"no sentence: {line[:200]!r}"
    return ""


def where_raised(error: BaseException) -> str:
    """Say which error it is and where it was raised, the last place within the project."""
    own = [
        one
        for one in traceback.extract_tb(error.__traceback__)
        if "site-packages" not in one.filename and "/lib/python" not in one.filename
    ]
    at = " < ".join(f"{'/'.join(one.filename.split('/')[-2:])}:{one.lineno}" for one in own[:-5:-1])
    return f"{type(error).__name__}: {' '.join(str(error).split())[:120]} at {at}"


def not_finite(value: Any, name: str = "", depth: int = 0) -> Iterator[str]:
    """Name all that is not finite in a result, in its fields and in what these hold."""
    if depth > DEEPEST or value is None or isinstance(value, str | bytes | int):
        return
    if isinstance(value, float | complex | np.number | np.ndarray):
        array = np.asarray(value)
        if array.dtype.kind in "fc" and not np.isfinite(array).all():
            yield name or "result"
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield from not_finite(one, f"{name}[{key!r}]", depth + 1)
    elif isinstance(value, list | tuple | set | frozenset):
        for one in value:
            yield from not_finite(one, f"{name}[]", depth + 1)
    elif isinstance(value, BaseModel):
        for field in type(value).model_fields:
            yield from not_finite(getattr(value, field), f"{name}.{field}", depth + 1)
    elif dataclasses.is_dataclass(value) and not inspect.isclass(value):
        for one in dataclasses.fields(value):
            yield from not_finite(getattr(value, one.name), f"{name}.{one.name}", depth + 1)
