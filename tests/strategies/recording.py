"""Calls of the public functions as tests and examples make them, to be made again with wrong arguments.

As a plugin of pytest (``-p strategies.recording --calls FILE``) it keeps the calls of a whole run of tests.
"""

import inspect
import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Self

import cloudpickle

import crankfem as cf
from crankbase.model import InputModel

MOST_CALLS = 6  # of one function
LARGEST_CALL = 1_000_000  # bytes, pickled


@dataclass(frozen=True)
class Call:
    """A call: the name of what was called, and its arguments."""

    name: str
    arguments: tuple[Any, ...]
    options: dict[str, Any]


def public_objects() -> dict[str, Any]:
    """Return all public functions and classes of crankfem by their whole names."""
    found = {f"crankfem.{name}": getattr(cf, name) for name in cf.__all__}
    for topic, module in list(found.items()):
        if inspect.ismodule(module):
            del found[topic]
            found |= {f"{topic}.{name}": getattr(module, name) for name in module.__all__}
    return {name: one for name, one in found.items() if callable(one)}


def public_callables() -> dict[str, Callable[..., Any]]:
    """Return the public functions and classes, and the classes' own public methods."""
    found: dict[str, Callable[..., Any]] = {}
    for name, one in public_objects().items():
        if inspect.isclass(one) and issubclass(one, BaseException):
            continue
        found[name] = one
        if inspect.isclass(one):
            for own, member in vars(one).items():
                if inspect.isfunction(member) and not own.startswith("_"):
                    found[f"{name}.{own}"] = member
    return found


class Recorder:
    """Keeps some calls of each public function, wherever it is called from while this is a context.

    Attributes
    ----------
    calls : dict
        Name to calls.
    """

    def __init__(self) -> None:
        self._random = random.Random(1)
        self._seen: dict[str, int] = {}
        self._put_back: list[tuple[Any, str, Any]] = []
        self.calls: dict[str, list[Call]] = {}

    def __enter__(self) -> Self:
        named = public_callables()
        for name, one in named.items():
            if inspect.isclass(one):
                if "__init__" in vars(one):
                    self._put(one, "__init__", self._constructor(one))
            elif name.rpartition(".")[0] in named:  # a method
                self._put(named[name.rpartition(".")[0]], one.__name__, self._wrapper(name, one))
            else:
                wrapper = self._wrapper(name, one)
                for module in list(sys.modules.values()):
                    if vars(module).get(one.__name__) is one:
                        self._put(module, one.__name__, wrapper)
        self._put(InputModel, "__init__", self._constructor(InputModel))
        return self

    def __exit__(self, *_: object) -> None:
        for holder, name, one in reversed(self._put_back):
            setattr(holder, name, one)
        self._put_back.clear()

    def _put(self, holder: Any, name: str, other: Any) -> None:
        self._put_back.append((holder, name, vars(holder)[name]))
        setattr(holder, name, other)

    def _wrapper(self, name: str, one: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(one)
        def call(*arguments: Any, **options: Any) -> Any:
            self._keep(name, arguments, options)
            return one(*arguments, **options)

        return call

    def _constructor(self, kind: type) -> Callable[..., None]:
        made = vars(kind)["__init__"]
        names = {one: own for own, one in public_objects().items() if inspect.isclass(one)}

        @wraps(made)
        def init(new: Any, *arguments: Any, **options: Any) -> None:
            own = names.get(type(new))
            if own is not None:
                self._keep(own, arguments, options)
            made(new, *arguments, **options)

        return init

    def _keep(self, name: str, arguments: tuple[Any, ...], options: dict[str, Any]) -> None:
        """Keep the first calls, and later ones by chance in their place."""
        count = self._seen[name] = self._seen.get(name, 0) + 1
        kept = self.calls.setdefault(name, [])
        if len(kept) < MOST_CALLS:
            kept.append(Call(name, arguments, dict(options)))
        elif self._random.random() < MOST_CALLS / count:
            kept[self._random.randrange(1, MOST_CALLS)] = Call(name, arguments, dict(options))


def saved(calls: dict[str, list[Call]]) -> bytes:
    """Pickle what can be pickled of some calls."""
    kept: dict[str, list[bytes]] = {}
    for name, some in calls.items():
        for one in some:
            try:
                text = cloudpickle.dumps(one)
            except Exception:  # an open file, a process: nothing to be given again
                continue
            if len(text) <= LARGEST_CALL:
                kept.setdefault(name, []).append(text)
    return cloudpickle.dumps(kept)


def loaded(content: bytes) -> dict[str, list[Call]]:
    """Return the calls that were saved."""
    found: dict[str, list[Call]] = {}
    for name, some in cloudpickle.loads(content).items():
        for text in some:
            try:
                found.setdefault(name, []).append(cloudpickle.loads(text))
            except Exception:  # made by a module of the tests that is not there
                continue
    return {name: some for name, some in found.items() if some}


# As a plugin of pytest.


def pytest_addoption(parser: Any) -> None:
    """Take the file that calls are kept in."""
    parser.addoption("--calls", type=Path, help="Keep the calls of public functions in this file.")


def pytest_collection_finish(session: Any) -> None:
    """Begin when all that the tests import is there."""
    if session.config.getoption("--calls") is not None:
        session.config.recorder = Recorder()
        session.config.recorder.__enter__()


def pytest_sessionfinish(session: Any) -> None:
    """Write the calls."""
    recorder = getattr(session.config, "recorder", None)
    if recorder is not None:
        recorder.__exit__()
        session.config.getoption("--calls").write_bytes(saved(recorder.calls))
