"""Calls of public functions with wrong arguments: of the right kind, and of wrong size, sign or length."""

import contextlib
import dataclasses
import inspect
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from crankbase.model import InputModel
from strategies.files import WORDS, factors, positions
from strategies.outcomes import NOT_FINITE, Outcome, not_finite, outcome_of
from strategies.recording import Call, public_callables

DEEPEST = 4
HUGE = 200_000
# Seconds of processor time after which a run that reports its progress is interrupted, and must end.
INTERRUPTED = 4.0
FLOATS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    np.nan,
    np.inf,
    -np.inf,
    1e300,
    -1e300,
    1e-300,
    5e-324,
    1e12,
    1e-12,
    0.5,
    3.0,
)
INTEGERS = (0, 1, -1, 2, 3, 7, 1000, 10**6, 10**9, 2**31, 2**63, 10**30, -(10**9))
# These mesh, start processes or write; what they check first is tried through commands and the service.
LONG = (
    "run_engine", "run_study", "analyze_", "mesh_throw", "import_throw", "fillet_stresses", "write_",
    "picture_", "save",
    "engine_stresses", "shaft_throws", "engine_vibration", "whole_shaft", "replacing_files", "export",
    "plot",
)  # fmt: skip

# Infinite by what their documentation says: limits beside their range, samples without bounds, undamped
# resonances.
ENDLESS = (
    "crankfem.limits.LimitCurve.at", "crankfem.limits.Samples", "crankfem.limits.chain_samples",
    "crankfem.dampers.size_",
)  # fmt: skip


def is_quick(name: str) -> bool:
    """Whether what is called so neither meshes nor writes nor draws."""
    own = name.rpartition(".")[2]
    return not any(own.startswith(one) for one in LONG)


def is_checked(kind: type) -> bool:
    """Whether a dataclass is one that people make; results check nothing, for functions alone make them."""
    return dataclasses.is_dataclass(kind) and hasattr(kind, "__post_init__")


def is_asked(name: str) -> bool:
    """Whether a recorded call is one that people make: not of a class of results."""
    called = public_callables()[name]
    return is_quick(name) and (not dataclasses.is_dataclass(called) or is_checked(called))


def _moved(draw: st.DrawFn, value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return not value
    if isinstance(value, int | np.integer):
        return draw(
            st.one_of(
                st.sampled_from(INTEGERS), st.integers(-3, 3).map(lambda step: int(value) + step)
            )
        )
    if isinstance(value, float | np.floating):
        return draw(
            st.one_of(st.sampled_from(FLOATS), factors.map(lambda factor: float(value) * factor))
        )
    return complex(value) * draw(factors)


def _array(draw: st.DrawFn, value: np.ndarray) -> np.ndarray:
    """Change an array as a whole, or one of its values."""
    kind = draw(
        st.sampled_from(
            (
                "one",
                "one",
                "one",
                "all",
                "empty",
                "longer",
                "shorter",
                "deeper",
                "flat",
                "huge",
                "order",
                "equal",
                "whole",
            )
        )
    )
    if value.dtype.kind not in "iufc" or kind == "empty":
        return value[:0] if value.ndim else value
    if kind == "one" and value.size:
        changed = np.array(value, dtype=float if value.dtype.kind in "iu" else value.dtype)
        place = int(draw(positions) * value.size)
        own = changed.flat[place]
        changed.flat[place] = draw(
            st.one_of(st.sampled_from(FLOATS), factors.map(lambda factor: own * factor))
        )
        return changed
    if kind == "all":
        return value * draw(factors)
    if kind == "longer" and value.ndim:
        return np.concatenate([value, value[-1:]])
    if kind == "shorter" and value.ndim:
        return value[:-1]
    if kind == "deeper":
        return value[np.newaxis]
    if kind == "flat":
        return value.ravel()
    if kind == "huge" and value.ndim and value.size:
        return np.resize(value, (HUGE, *value.shape[1:])) if value[0].size < 100 else value
    if kind == "order" and value.ndim:
        return value[::-1]
    if kind == "equal":
        return np.full_like(value, value.flat[0] if value.size else 0.0)
    return np.zeros_like(value)


def changed_value(draw: st.DrawFn, value: Any, depth: int = 0) -> Any:
    """Put something wrong in the place of a value, or of one within it.

    Raises
    ------
    InputError
        If the value is a record that cannot be made with it.
    """
    if isinstance(value, bool | np.bool_ | int | float | complex | np.number):
        return _moved(draw, value)
    if isinstance(value, str):
        return draw(st.one_of(st.sampled_from(WORDS), st.just(value + "x"), st.just(value.upper())))
    if isinstance(value, np.ndarray):
        return _array(draw, value)
    if isinstance(value, Path) or value is None or depth > DEEPEST:
        return value
    if isinstance(value, list | tuple) and not hasattr(value, "_fields"):
        return type(value)(_sequence(draw, list(value), depth))
    if isinstance(value, Mapping):
        if not value or draw(st.integers(0, 5)) == 0:
            return {}
        key = draw(st.sampled_from(sorted(value, key=str)))
        kept = {one: own for one, own in value.items() if one != key}
        kind = draw(st.integers(0, 5))
        return (
            kept
            if kind == 0
            else kept
            | {
                (draw(st.sampled_from(WORDS)) if kind == 1 else key): changed_value(
                    draw, value[key], depth + 1
                )
            }
        )
    if isinstance(value, InputModel):
        given = {name: getattr(value, name) for name in value.model_fields_set}
        return type(value)(**changed_options(draw, given, depth + 1)) if given else value
    if is_checked(type(value)):
        given = {
            one.name: getattr(value, one.name) for one in dataclasses.fields(value) if one.init
        }
        return (
            dataclasses.replace(value, **changed_options(draw, given, depth + 1))
            if given
            else value
        )
    if inspect.isroutine(value) or isinstance(value, partial):
        wrong = draw(st.sampled_from((np.nan, np.inf, 0.0, -1.0, 1e300, 1e-300)))
        return partial(_wrongly, value, wrong)
    return value


def _wrongly(function: Callable[..., Any], factor: float, *arguments: Any, **options: Any) -> Any:
    """Call a function of numbers, and return others; what it returns else stays as it is."""
    found = function(*arguments, **options)
    with np.errstate(all="ignore"):  # what it returns is judged, not how that is made here
        return found * factor if isinstance(found, float | np.ndarray | np.number) else found


def _sequence(draw: st.DrawFn, items: list[Any], depth: int) -> list[Any]:
    kind = draw(
        st.sampled_from(("one", "one", "one", "one", "empty", "longer", "shorter", "order", "many"))
    )
    if not items or kind == "empty":
        return []
    if kind == "one":
        place = int(draw(positions) * len(items))
        items[place] = changed_value(draw, items[place], depth + 1)
    elif kind == "longer":
        items.append(items[-1])
    elif kind == "shorter":
        items.pop()
    elif kind == "order":
        items.reverse()
    else:
        items *= 500
    return items


def changed_options(draw: st.DrawFn, given: Mapping[str, Any], depth: int = 0) -> dict[str, Any]:
    """Change one of some arguments by name, now and then two."""
    changed = dict(given)
    names = [name for name, value in given.items() if value is not None and name != "self"]
    for _ in range(draw(st.sampled_from((1, 1, 1, 2)))):
        if names:
            name = draw(st.sampled_from(names))
            changed[name] = changed_value(draw, changed[name], depth)
    return changed


@st.composite
def wrong_calls(draw: st.DrawFn, calls: dict[str, list[Call]]) -> Callable[[], Call]:
    """Draw a call with one or two arguments changed; it is made when the result is called.

    The records in it are made then, too: one that refuses what it is given is an answer as any other.
    """
    name = draw(st.sampled_from(sorted(calls)))
    one = draw(st.sampled_from(calls[name]))
    made: list[Any] = []

    def change() -> Call:
        if one.arguments and (not one.options or draw(st.booleans())):
            arguments = list(one.arguments)
            place = draw(st.integers(0, len(arguments) - 1))
            arguments[place] = changed_value(draw, arguments[place])
            return dataclasses.replace(one, arguments=tuple(arguments))
        return dataclasses.replace(one, options=changed_options(draw, one.options))

    # Drawn here, for later no more can be drawn; the outcome is that of the whole.
    outcome = outcome_of(lambda: made.append(change()))
    return Attempted(name, made[0] if made else None, outcome, one)


@dataclasses.dataclass(frozen=True)
class Attempted:
    """A wrong call, or what came of making its arguments; and the call as it was recorded."""

    name: str
    call: Call | None
    before: Outcome
    recorded: Call

    def outcome(self) -> Outcome:
        """Make the call, and tell what came of it."""
        if self.call is None:
            return dataclasses.replace(self.before, text=f"{self.name}: {self.before.text}")
        call = _interrupted(self.call)
        found = outcome_of(lambda: made(call), self._is_documented)
        if found.kind == NOT_FINITE and list(not_finite((self.call.arguments, self.call.options))):
            # What was no number in went in and out again, in a record that checks nothing.
            return Outcome(NOT_FINITE, f"{self.name}: {found.text}, as given")
        return (
            found if found.good else dataclasses.replace(found, text=f"{self.name}: {found.text}")
        )

    def _is_documented(self, field: str) -> bool:
        """Whether a field may be infinite or no number: so it is in the result of the recorded call, too."""
        return self.name.startswith(ENDLESS) or field in not_finite(made(self.recorded))

    def __repr__(self) -> str:
        return f"{self.name}: {_shown(self.call)}"


def made(call: Call) -> Any:
    """Make a call."""
    return public_callables()[call.name](*call.arguments, **call.options)


def _interrupted(call: Call) -> Call:
    """Interrupt a run as its user can, where it reports its progress."""
    if "progress" not in inspect.signature(public_callables()[call.name]).parameters:
        return call
    begin = time.process_time()

    def progress(*_: Any) -> None:
        if time.process_time() - begin > INTERRUPTED:
            raise KeyboardInterrupt

    return dataclasses.replace(call, options={"progress": progress} | call.options)


def _shown(call: Call | None) -> str:
    if call is None:
        return ""
    with np.printoptions(threshold=12, edgeitems=3), contextlib.suppress(Exception):
        parts = [
            *map(repr, call.arguments),
            *(f"{name}={value!r}" for name, value in call.options.items()),
        ]
        return ", ".join(part[:300] for part in parts)
    return "cannot be shown"
