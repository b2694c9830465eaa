"""Sentences that keep their values: written again in other units or with fewer digits, never searched.

A function that words something writes a value by `amount`, as a mark, into an ordinary f-string. `finished`
makes a sentence of it, which a door writes by `written` as it needs. What a person wrote has no marks, and
stays as it is.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from functools import cached_property, wraps
from typing import Any, Protocol, Self, SupportsIndex, TypeVar, cast

from crankbase.quantity import (
    DISPLAY_UNITS,
    POWER_OF_TEN,
    UNBOUNDED,
    UNITS,
    compact_large,
    number_and_unit,
    significant,
)


class Shown(Protocol):
    """A unit in which values are shown, as `crankbase.table.OutputUnit`."""

    @property
    def size(self) -> float:
        """In SI."""

    @property
    def wished(self) -> bool:
        """Whether it replaces the usual one."""

    def with_name(self, value: float | None, digits: int = 4) -> str:
        """Write an SI number in it, with its name."""


class Units(Protocol):
    """Units in which values are shown, as `crankbase.table.OutputUnits`."""

    def of(self, printed: str) -> Shown:
        """Return the unit in place of a usual one."""


T = TypeVar("T")
# Around a value in a text. They are for private use in Unicode: no file and no keyboard has them.
START, END = "\ue000", "\ue001"
# The name of a field at the start of a remark.
_FIELD = re.compile(r"\w+(?:\.\w+|_\w)")
# Of a mark, as `_mark` writes it and nothing else: what a person wrote may hold the same letters after all.
_NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?|nan"
_MARK = re.compile(
    rf"{START}((?:{_NUMBER})\|[^|{START}{END}]*(?:\|(?:(?:digits|decimals)=\d{{1,2}}|other=(?:{_NUMBER})"
    rf"|(?:zeros|signed|bare|exact)=(?:True|False)|shown=(?:{'|'.join(map(re.escape, UNITS))})))*){END}"
)
# Digits up to which two values are told apart, and with which an output unit is shown at least.
MOST_DIGITS, LEAST_DIGITS = 6, 3


@dataclass(frozen=True)
class Amount:
    """A value in a sentence, and how it is written.

    Attributes
    ----------
    value : float
        In SI.
    unit : str
        SI unit.
    digits : int
        Significant digits at most; all before the point stay.
    decimals : int or None
        Decimals instead of digits.
    shown : str
        One of `UNITS`, if it is not the usual one.
    zeros : bool
        Whether zeros at the end stay.
    signed : bool
        Whether it has a plus.
    bare : bool
        Whether its unit stands elsewhere, as in "500 to 600 1/min".
    other : float or None
        A value that it is told apart from, if the two differ.
    exact : bool
        Whether it was given, so that no digits are left out.
    """

    value: float
    unit: str
    digits: int = MOST_DIGITS
    decimals: int | None = None
    shown: str = ""
    zeros: bool = False
    signed: bool = False
    bare: bool = False
    other: float | None = None
    exact: bool = False

    def text(
        self, units: Units | None = None, most: int | None = None, *, full: bool = False
    ) -> str:
        """Write it with its unit, with so many digits at most.

        In another unit it has as many digits as in the usual one or, `full`, all that it may have.
        """
        number, unit = self.pair(units, most, full=full)
        return number if self.bare else f"{number} {unit}".rstrip()

    def pair(
        self, units: Units | None = None, most: int | None = None, *, full: bool = False
    ) -> tuple[str, str]:
        """Write number and unit."""
        digits, cut = self.digits, most
        number, unit = self._pair(self.value, digits, units, cut, full=full)
        while (
            self.other not in (None, self.value)
            and min(digits, MOST_DIGITS if cut is None else cut) < MOST_DIGITS
            and self._pair(self.other or 0.0, digits, units, cut)[0] == number
        ):
            digits, cut = digits + 1, None if cut is None else cut + 1
            number, unit = self._pair(self.value, digits, units, cut, full=full)
        return number, unit

    def _pair(
        self,
        value: float,
        digits: int,
        units: Units | None,
        most: int | None,
        *,
        full: bool = False,
    ) -> tuple[str, str]:
        unit, size = DISPLAY_UNITS.get(self.unit, (self.unit, 1.0))
        if self.shown:
            unit, size = self.shown, UNITS[self.shown][1]
        if self.decimals is not None:
            number = f"{value / size:.{self.decimals}f}"
        elif self.zeros:
            number = significant(value / size, digits)
        elif self.shown:
            number = compact_large(value / size, digits)
        else:
            number, unit = number_and_unit(value, self.unit, digits)
            size = UNITS[unit][1] if unit in UNITS else 1.0
        converted = units.of(unit) if units is not None and unit in UNITS else None
        if converted is not None and converted.wished:
            # What is written out, as 250000, has zeros that are no digits.
            written = number.partition("e")[0].lstrip("+-").lstrip("0.").replace(".", "")
            kept = max(digits if full else min(len(written), digits), LEAST_DIGITS)
            size = converted.size
            if number.endswith("e-9"):  # as in tables
                converted = cast("Units", units).of(f"{POWER_OF_TEN}{unit}")
            number, _, unit = converted.with_name(value, kept).partition(" ")
        if most is not None and not self.exact:
            number = _cut(number, value / size, most)
        return (f"+{number}" if self.signed and value >= 0.0 else number), unit


def _cut(number: str, exact: float, most: int) -> str:
    """Write a number with so many digits; those before the point all stay."""
    mantissa, e, power = number.partition("e")
    before, _, decimals = mantissa.partition(".")
    whole = before.lstrip("+-0")
    leading = 0 if whole else len(decimals) - len(decimals.lstrip("0"))
    kept = max(0, most - len(whole)) + leading
    if kept >= len(decimals):
        return number
    return f"{exact / 10.0 ** int(power or 0):.{kept}f}{e}{power}"


_DEFAULTS = {entry.name: entry.default for entry in fields(Amount)}


def amount(value: float, unit: str, digits: int = MOST_DIGITS, **how: Any) -> str:
    """Write a value into a text as a mark; what is unbounded as that.

    Parameters
    ----------
    value : float
        In SI.
    **how
        Further fields of `Amount`.

    Examples
    --------
    >>> finished(f"The web is {amount(0.27, 'm')} wide.")
    'The web is 270 mm wide.'
    """
    if math.isinf(value):
        return UNBOUNDED
    return _mark(Amount(float(value), unit, digits, **how))


def in_si(value: float, unit: str, digits: int = MOST_DIGITS) -> str:
    """Write a value into a text in its SI unit, as what is given in Python; see `amount`.

    Examples
    --------
    >>> finished(f"depth: given {in_si(0.27, 'm')}")
    'depth: given 0.27 m'
    """
    return amount(value, unit, digits, shown=unit)


def apart(value: float, other: float, unit: str, digits: int = 3) -> tuple[str, str]:
    """Write two values into a text, with up to six digits where that tells them apart.

    Examples
    --------
    >>> reached, permitted = apart(22.28e6, 22.27e6, "Pa")
    >>> finished(f"{reached} of {permitted}")
    '22.28 MPa of 22.27 MPa'
    """
    if math.isinf(value) or math.isinf(other):
        return amount(value, unit, digits), amount(other, unit, digits)
    return amount(value, unit, digits, other=other), amount(other, unit, digits, other=value)


def angle(degrees: float, digits: int = MOST_DIGITS) -> str:
    """Write an angle [deg] into a text; see `amount`."""
    return amount(math.radians(degrees), "rad", digits)


def listed(
    values: Sequence[float], unit: str, digits: int = MOST_DIGITS, between: str = ", ", **how: Any
) -> str:
    """Write several values into a text, with their unit behind the last one alone; see `amount`.

    Examples
    --------
    >>> finished(listed((50.0, 60.0), "rad/s", 4, " to "))
    '477.5 to 573 1/min'
    """
    last = len(values) - 1
    return between.join(
        amount(value, unit, digits, bare=place < last, **how) for place, value in enumerate(values)
    )


def _mark(part: Amount) -> str:
    how = _how(part)
    value, unit = how.pop("value"), how.pop("unit")
    return f"{START}{'|'.join((repr(value), unit, *(f'{name}={how[name]}' for name in how)))}{END}"


def _how(part: Amount) -> dict[str, Any]:
    """Return what is not by default."""
    return {
        name: getattr(part, name)
        for name, default in _DEFAULTS.items()
        if default is MISSING or getattr(part, name) != default
    }


def _read(mark: str) -> Amount:
    value, unit, *how = mark.split("|")
    named: dict[str, Any] = dict(entry.split("=", 1) for entry in how)
    for name, text in named.items():
        if text in ("True", "False"):
            named[name] = text == "True"
        elif name != "shown":
            named[name] = int(text) if text.lstrip("-").isdigit() else float(text)
    return Amount(float(value), unit, **named)


class Sentence(str):
    """A text, with its values in SI units as they are usually written, which can be written otherwise.

    It is kept where it is copied or joined by "+", but not in an f-string: that takes `kept`.

    Attributes
    ----------
    marked : str
        The text with marks in place of the values.
    """

    __slots__ = ("marked",)
    marked: str

    def __new__(cls, marked: str) -> Self:
        """Write the values of a text with marks."""
        made = super().__new__(cls, written(marked))
        made.marked = kept(marked)
        return made

    def __getnewargs__(self) -> tuple[str]:
        """Copies and pickles keep the values."""
        return (self.marked,)

    def __add__(self, other: str) -> str:
        return finished(self.marked + kept(other))

    def __radd__(self, other: str) -> str:
        return finished(kept(other) + self.marked)

    def removesuffix(self, suffix: str, /) -> str:
        """Return it without an end; without its values if the end is in one."""
        if self.marked.endswith(suffix):
            return finished(self.marked.removesuffix(suffix))
        return super().removesuffix(suffix)

    def removeprefix(self, prefix: str, /) -> str:
        """Return it without a beginning; without its values if the beginning is in one."""
        if self.marked.startswith(prefix):
            return finished(self.marked.removeprefix(prefix))
        return super().removeprefix(prefix)

    def rstrip(self, chars: str | None = None, /) -> str:
        """Return it without letters at its end; without its values if they are in one."""
        left = finished(self.marked.rstrip(chars))
        return left if str(left) == super().rstrip(chars) else super().rstrip(chars)

    def __getitem__(self, place: SupportsIndex | slice) -> str:
        """Return a part; of all but a first letter the values are kept."""
        if place == slice(1, None) and not self.marked.startswith(START):
            return finished(self.marked[1:])
        return super().__getitem__(place)

    def record(self) -> list[Any]:
        """Return the text as JSON holds it: words and values in turn."""
        pieces = _MARK.split(self.marked)
        return [
            _how(_read(piece)) if place % 2 else piece
            for place, piece in enumerate(pieces)
            if piece
        ]

    @classmethod
    def from_record(cls, pieces: Iterable[str | Mapping[str, Any]]) -> Self:
        """Read what `record` returned."""
        return cls(
            "".join(piece if isinstance(piece, str) else _mark(Amount(**piece)) for piece in pieces)
        )


def finished(text: str) -> str:
    """Return a finished text; one without values is plain."""
    return text if isinstance(text, Sentence) or START not in text else Sentence(text)


def has_values(text: str) -> bool:
    """Return whether a text has values that can be written otherwise."""
    return START in kept(text)


def kept(text: str) -> str:
    """Return a text for another one, with its values.

    Examples
    --------
    >>> width = finished(f"{amount(0.27, 'm')} wide")
    >>> finished(f"It is {kept(width)}.").record()
    ['It is ', {'value': 0.27, 'unit': 'm'}, ' wide.']
    """
    return text.marked if isinstance(text, Sentence) else text


def joined(between: str, texts: Iterable[str]) -> str:
    """Join texts for another one, with their values."""
    return between.join(map(kept, texts))


def lines(text: str) -> list[str]:
    """Return the lines of a text, with their values."""
    return [finished(line) for line in kept(text).split("\n")]


def capital(text: str) -> str:
    """Begin a text with a capital letter, for another one."""
    return f"{kept(text)[:1].upper()}{kept(text)[1:]}"


def sentence(text: str) -> str:
    """Write a remark as a sentence; the name of a field keeps its small letter.

    Examples
    --------
    >>> sentence("rod.inertia is not given")
    'rod.inertia is not given.'
    """
    begun = kept(text) if _FIELD.match(kept(text)) else capital(text)
    return f"{begun.removesuffix('.')}."


def written(text: str, write: Callable[[Amount], str] = Amount.text) -> str:
    """Write a text for a reader: `write` writes its values."""
    return _MARK.sub(lambda mark: write(_read(mark[1])), kept(text))


def with_sentences(cls: type[T]) -> type[T]:
    """Make what a data class says in its fields and properties finished sentences."""
    texts = [entry.name for entry in fields(cast("type[Any]", cls)) if "str" in str(entry.type)]
    if texts:
        made = cast("Any", cls)
        made.__init__ = _finishing(made.__init__, texts)
    for entry in list(vars(cls).values()):
        getter = getattr(entry, "fget", None) or getattr(entry, "func", None)
        if getter is not None and "str" in str(getter.__annotations__.get("return", "")):
            if isinstance(entry, cached_property):
                entry.func = _finished(getter)
            elif isinstance(entry, property):
                setattr(cls, getter.__name__, property(_finished(getter), doc=entry.__doc__))
    return cls


def _finishing(init: Callable[..., None], texts: list[str]) -> Callable[..., None]:
    @wraps(init)
    def start(self: Any, *args: Any, **named: Any) -> None:
        init(self, *args, **named)
        for name in texts:
            value = vars(self)[name]
            if (text := _as_sentences(value)) is not value:
                vars(self)[name] = text

    return start


def _finished(getter: Callable[[Any], Any]) -> Callable[[Any], Any]:
    @wraps(getter)
    def get(self: Any) -> Any:
        return _as_sentences(getter(self))

    return get


def _as_sentences(value: Any) -> Any:
    """Return a text with values, or several, as sentences, and anything else as it is."""
    if type(value) is str:
        return finished(value)
    if isinstance(value, tuple | list) and any(isinstance(part, str) for part in value):
        return type(value)(map(_as_sentences, value))
    if isinstance(value, Mapping) and any(isinstance(part, str) for part in value.values()):
        return {name: _as_sentences(part) for name, part in value.items()}
    return value
