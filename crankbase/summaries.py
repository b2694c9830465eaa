"""Display of results: a text of one to three lines, and a small table in notebooks."""

import math
import textwrap
from collections.abc import Callable, Mapping, Sized
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any, TypeVar, dataclass_transform

import numpy as np

T = TypeVar("T")

WIDTH = 100
# Lines of a text, its first and last included.
LINES = 3
# So many values are shown one by one.
FEW = 4
# So long may a text be, and one of several.
LONGEST = 60
BRIEF = 24
# Stands for a space at which no line ends.
TIED = "\u00a0"


def summarized(
    *items: str, keeps_text: bool = False, unit_of: Callable[[object, str], str] | None = None
) -> Callable[[type[T]], type[T]]:
    """Give a class of results a short `__repr__`, and `_repr_html_` for notebooks.

    Parameters
    ----------
    *items : str
        Main values, as "attribute [unit]": their path, with the SI unit. An attribute of an
        attribute is named "mesh.unknowns", and its last name is shown, or a label before it as
        in "left: left.force [N]"; a method is called without arguments. None and a single NaN
        are left out, and so are all attributes of None.
    keeps_text : bool, optional
        Whether the class has its own text.
    unit_of : callable, optional
        Gives the unit of an item that states none, by the result and the path.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> @summarized("mesh.unknowns", "mass [kg]", "speeds [rad/s]")
    ... class Analysis:
    ...     mesh, mass = SimpleNamespace(unknowns=21340), 312.4567
    ...     speeds = np.linspace(10.0, 50.0, 60)
    >>> Analysis()
    Analysis(unknowns 21340, mass 312.5 kg, speeds 10 to 50 rad/s (60))
    """
    declared = []
    for item in items:
        place, _, unit = item.partition(" [")
        label, colon, path = place.rpartition(": ")
        declared.append((label if colon else path.rpartition(".")[2], path, unit.removesuffix("]")))

    def rows(result: object) -> dict[str, str]:
        texts = {}
        for label, path, unit in declared:
            value: Any = result
            for name in path.split("."):
                # What is internal is not there in a result that is read from a file.
                value = getattr(value, name, None)
            text = _value(value, unit or (unit_of(result, path) if unit_of else ""))
            if text:
                texts[label] = text
        return texts

    def __repr__(self: object) -> str:  # noqa: N807 - these become methods
        return summary_text(
            type(self).__name__, [f"{name} {text}" for name, text in rows(self).items()]
        )

    def _repr_html_(self: object) -> str:
        return summary_html(type(self).__name__, rows(self))

    def decorate(cls: type[T]) -> type[T]:
        if not keeps_text:
            cls.__repr__ = __repr__  # type: ignore[method-assign]
        cls._repr_html_ = _repr_html_  # type: ignore[attr-defined]
        return cls

    return decorate


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(*items: str, eq: bool = True) -> Callable[[type[T]], type[T]]:
    """Make a frozen data class with the short texts of `summarized`.

    Parameters
    ----------
    *items : str
        Main values, as for `summarized`, unless the class has a text of its own.
    eq : bool, optional
        Whether objects of equal values are equal; no class with arrays can be so.
    """

    def decorate(cls: type[T]) -> type[T]:
        has_text = "__repr__" in vars(cls)
        return summarized(*items, keeps_text=has_text)(dataclass(frozen=True, eq=eq)(cls))

    return decorate


def summary_text(name: str, parts: list[str]) -> str:
    """Return "name(part, part)" in few lines; parts that do not fit are counted.

    Examples
    --------
    >>> summary_text("Sum", ["a 1", "b 2"])
    'Sum(a 1, b 2)'
    """
    for kept in range(len(parts), -1, -1):
        more = [f"and {len(parts) - kept} more"] if kept < len(parts) else []
        tied = [part.replace(" ", TIED) for part in parts[:kept] + more]
        whole = f"{name}({', '.join(tied)})"
        lines = textwrap.wrap(
            whole, WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
        if len(lines) <= LINES:
            break
    return "\n".join(lines).replace(TIED, " ")


def summary_html(name: str, rows: Mapping[str, str]) -> str:
    """Return a small table: the name above, a row for each value.

    Examples
    --------
    >>> summary_html("Sum", {"a": "< 1"})
    '<table><caption>Sum</caption><tr><th>a</th><td>&lt; 1</td></tr></table>'
    """
    body = "".join(
        f"<tr><th>{escape(label)}</th><td>{escape(_short(text))}</td></tr>"
        for label, text in rows.items()
    )
    return f"<table><caption>{escape(name)}</caption>{body}</table>"


def _value(value: Any, unit: str) -> str:
    """Write a value with its unit; "" for none."""
    if callable(value):
        value = value()
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, np.ndarray) and value.size > FEW:
        return _array_summary(value, unit)
    if isinstance(value, tuple | list | np.ndarray):
        items = list(np.atleast_1d(value) if isinstance(value, np.ndarray) else value)
        if len(items) > FEW or not all(
            _is_plain(item) and len(str(item)) <= BRIEF for item in items
        ):
            return str(len(items))
        listed = ", ".join(_plain(item) for item in items) or "none"
        text = f"({listed})" if len(items) > 1 else listed
    elif not _is_plain(value) and isinstance(value, Sized):
        return str(len(value))
    else:
        text = _plain(value)
    return f"{text} {unit}".rstrip()


def _array_summary(values: np.ndarray[Any, Any], unit: str) -> str:
    """Write the range of an array and its number of values, by its axes."""
    size = " x ".join(str(length) for length in values.shape)
    finite = values[np.isfinite(values)] if np.issubdtype(values.dtype, np.number) else values[:0]
    if not finite.size:
        return size
    if np.iscomplexobj(finite):
        reach = f"up to {_plain(float(np.abs(finite).max()))}"
    else:
        ends = dict.fromkeys(_plain(float(end)) for end in (finite.min(), finite.max()))
        reach = " to ".join(ends)
    return f"{f'{reach} {unit}'.rstrip()} ({size})"


def _is_plain(value: object) -> bool:
    return isinstance(value, bool | int | float | complex | str | Path | np.generic)


def _plain(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | complex):
        return f"{value:.4g}"
    return _short(str(value))


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3].rstrip()}..."
