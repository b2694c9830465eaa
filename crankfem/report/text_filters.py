"""How numbers and names are written in a report: so many digits, with units, in an engineer's words."""

import datetime
import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from crankbase.quantity import (
    RPM,
    UNBOUNDED,
    fixed,
    format_quantity,
    format_usage,
    nano,
    percent,
    scaled,
    significant,
    tiny,
)
from crankbase.sentences import capital, has_values, joined, kept, sentence, written
from crankbase.table import Table
from crankfem.analyses.shaft.chains import MOTION

if TYPE_CHECKING:
    from crankfem.analyses.mechanism.mechanism_results import BearingLoad

# What the sources of compliances are called in results.json, and in words.
SOURCE_WORDS = {
    "fe": "finite elements",
    "fe pinned": "finite elements, pinned",
    "given": "the engine file",
    "law": "the law",
}
# How books print units, each in one piece.
SYMBOLS = {"um": "\N{MICRO SIGN}m", "m^2": "m²", "m^3": "m³", " ": "\N{NO-BREAK SPACE}"}
TABLE_DIGITS = 3
DECIMALS = re.compile(r"(?<![\w.])(?P<whole>\d+)\.(?P<decimals>\d+)(?!\d| %)")
# Loads that differ by a smaller share are alike.
ALIKE = 1e-6
MINUTE, HOUR = 60.0, 3600.0


def quantity(value: float | None, unit: str, digits: int = TABLE_DIGITS) -> str:
    """Write a quantity in the unit in which engineers read it, without bound where there is none.

    Examples
    --------
    >>> quantity(12.3456, "m")
    '12300 mm'
    """
    if value is None or math.isinf(value):
        return UNBOUNDED
    return format_quantity(value, unit, digits) if unit else f"{value:g}"


def motion(value: float | None, kind: str, digits: int = 3) -> str:
    """Write an amplitude of axial or torsional vibration with its unit."""
    shown = MOTION[kind]
    return UNBOUNDED if value is None else f"{shown.number(value, digits)} {shown.unit}"


def source_label(name: str) -> str:
    """Label the source of compliances."""
    return SOURCE_WORDS.get(name, name)


def moment(text: str) -> str:
    """Write a time of ISO 8601 so that it can be read.

    Examples
    --------
    >>> moment("2026-11-21T21:30:07+00:00")
    '21 November 2026, 21:30 UTC'
    """
    try:
        time = datetime.datetime.fromisoformat(text)
    except ValueError:
        return text
    offset = time.strftime("%z")
    zone = " UTC" if offset in ("", "+0000") else f" UTC{offset[:3]}:{offset[3:]}"
    return f"{time.day} {time:%B %Y, %H:%M}{zone}"


def duration(seconds: float) -> str:
    """Write how long something took.

    Examples
    --------
    >>> duration(41.7)
    '42 s'
    >>> duration(125.0)
    '2 min 5 s'
    """
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < MINUTE:
        return f"{whole} s"
    if whole < HOUR:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def loaded_most(bearings: Sequence["BearingLoad"]) -> list["BearingLoad"]:
    """Return the bearings with the largest load; several where they are alike but for round-off."""
    largest = max(bearing.largest for bearing in bearings)
    return [bearing for bearing in bearings if bearing.largest > (1.0 - ALIKE) * largest]


def head(text: str) -> Markup:
    """Write a column's head so that its unit stays in one piece.

    Examples
    --------
    >>> str(head("speed [1/min]"))
    'speed <span class="nowrap">[1/min]</span>'
    """
    name, bracket, unit = text.partition(" [")
    shown = Markup('{} <span class="nowrap">[{}</span>').format(name, with_symbols(unit))
    return shown if bracket else escape(text)


def table_cells(table: Table) -> list[list[str]]:
    """Write the cells of a table: numbers with three digits, but those that were given as they are."""
    return [
        [
            text if column.words or column.digits is None else _with_three_digits(text)
            for column, text in zip(table.columns, row, strict=True)
        ]
        for row in table.texts(
            write=lambda value, digits: significant(value, min(digits, TABLE_DIGITS))
        )
    ]


def _with_three_digits(text: str) -> str:
    """Cut the decimals of the numbers in a cell so that three digits stay; digits before the point stay.

    Examples
    --------
    >>> _with_three_digits("376.08"), _with_three_digits("0.5522"), _with_three_digits("24.51 MPa")
    ('376', '0.552', '24.5 MPa')
    """

    def cut(match: re.Match[str]) -> str:
        whole, decimals = match["whole"].lstrip("0"), match["decimals"]
        leading = 0 if whole else len(decimals) - len(decimals.lstrip("0"))
        kept = max(0, TABLE_DIGITS - len(whole)) + leading
        return match[0] if kept >= len(decimals) else f"{float(match[0]):.{kept}f}"

    return DECIMALS.sub(cut, text).replace(" um", " \N{MICRO SIGN}m")


def printed(text: Any, most: int | None = TABLE_DIGITS) -> Any:
    r"""Write the values of a text with so many digits, and each with its unit on one line, as books print it.

    Examples
    --------
    >>> from crankbase.sentences import amount
    >>> printed(f"The web of {amount(0.2704, 'm')} in the series of 500.0 mm.")
    'The web of 270\xa0mm in the series of 500.0 mm.'
    """
    if not isinstance(text, str) or not has_values(text):
        return text  # as it is, which may be HTML
    return written(text, lambda value: with_symbols(value.text(None, most)))


def with_symbols(text: str) -> str:
    """Write a value with its unit, or a unit, as books print it, in one piece."""
    for plain, symbol in SYMBOLS.items():
        text = text.replace(plain, symbol)
    return text


FILTERS = {
    "cells": table_cells,
    "sig": lambda value, digits=TABLE_DIGITS: significant(value, digits),
    "plain": lambda value: f"{value:g}",
    "count": lambda value: f"{value:,}".replace(",", "\N{NARROW NO-BREAK SPACE}"),
    "nano": lambda value: nano(value, TABLE_DIGITS),
    "percent": percent,
    "fixed": fixed,
    "quantity": quantity,
    "given": lambda value, unit: quantity(value, unit, 6),
    "scaled": scaled,
    "motion": motion,
    "tiny": tiny,
    "source": source_label,
    "words": lambda name: name.replace("_", " "),
    "sentence": sentence,
    # Signs of an equation as books print them.
    "signs": lambda text: text.replace(" * ", " · ").replace(" - ", " − "),
    "moment": moment,
    "duration": duration,
    "loaded_most": loaded_most,
    # A bar can be no longer than full.
    "bar": lambda share: min(1.0, share) if math.isfinite(share) else 1.0,
    "used": format_usage,
    "head": head,
    "joined": lambda texts: joined(" ", texts),
    "kept": kept,
    "capital": capital,
    "gpa": lambda value: f"{value / 1e9:.4g} GPa",
    "rpm": lambda speed: speed * RPM,
    "length_of": lambda values: math.hypot(*values),
    "sig_or_zero": lambda value: significant(value, TABLE_DIGITS) if value else "0",
}
