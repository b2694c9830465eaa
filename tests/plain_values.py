"""Texts of results that hold a value which cannot be written in other units."""

import re
from collections.abc import Mapping

from crankbase.quantity import UNITS
from crankbase.results import Result, contents
from crankbase.sentences import END, START, kept
from dynamics.gas.gas_cycle import USUAL_VALUES

UNIT = "|".join(re.escape(unit) for unit in sorted(UNITS, key=len, reverse=True))
PLAIN = re.compile(rf"(?<![\w./^-])\d[\d.]*(?:e[+-]?\d+)? (?:{UNIT})(?![\w^/])")
# What a person wrote, in the file or in a source.
WRITTEN = ("source", "given", "reason", "name", "engine")
WRITTEN_TEXTS = re.compile("|".join(re.escape(usual.reason) for usual in USUAL_VALUES.values()))
MARK = re.compile(f"{START}[^{END}]*{END}")


def texts_with_plain_values(value, path=""):
    """Yield texts that hold a number with a unit which cannot be written otherwise."""
    if isinstance(value, str):
        assert START not in str(value), f"{path}: {value!r} is not finished"
        if PLAIN.search(WRITTEN_TEXTS.sub("", MARK.sub("", kept(value)))):
            yield f"{path}: {value}"
    elif isinstance(value, Result):
        for name in contents(type(value)):
            if name not in WRITTEN:
                yield from texts_with_plain_values(getattr(value, name), f"{path}.{name}")
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield from texts_with_plain_values(part, f"{path}.{name}")
    elif isinstance(value, list | tuple):
        for part in value:
            yield from texts_with_plain_values(part, path)
