"""Meaning of each field of an engine file, from its declaration: for the docs and the command line."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from crankbase.choices import allowed_names
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra, gd2_name, is_inertia, part_kind
from crankbase.quantity import DISPLAY_UNITS, format_quantity
from crankfem.files.chain.chain_build import KINDS as CHAIN_KINDS
from crankfem.files.engine.file_kinds import SECTIONS
from fem.material import Material

# Whole numbers below this are written out.
WRITTEN_OUT = 1e10

# The section of a chain file, which has fields of its own.
CHAIN = "chain"
# Sections that have names of the user's own.
TITLES = {"throws": "[throws.NAME]"}


@dataclass(frozen=True)
class FieldRow:
    """One field: its name, the unit it is shown in, its allowed values, and its meaning."""

    name: str
    unit: str
    allowed: str
    meaning: str


@dataclass(frozen=True)
class SectionTable:
    """One section, or a table within it: its title in brackets, whether it is required, its fields."""

    title: str
    need: str
    rows: tuple[FieldRow, ...]


def section_tables(section: str | None = None) -> list[SectionTable]:
    """Tables of one section, with nested tables, or of all."""
    if section == CHAIN:
        return chain_tables()
    if section is not None and section not in SECTIONS:
        name = section.rpartition(".")[2]
        having = [other for other, kind in SECTIONS.items() if name in kind.model.model_fields]
        if having:
            raise InputError(
                f"section: given {section!r}; {name} is a field of {', '.join(having)}: allowed are sections."
            )
        raise InputError(
            f"section: given {section!r}; {allowed_names(section, (*SECTIONS, CHAIN))}."
        )
    return [
        table
        for name, kind in SECTIONS.items()
        if section in (None, name)
        for table in _tables(kind.model, TITLES.get(name, f"[{name}]"), kind.need)
    ]


def chain_tables() -> list[SectionTable]:
    """Tables of a chain file: a section [chain] for each kind of chain, and its nested tables."""
    return [
        *(
            table
            for name, kind in CHAIN_KINDS.items()
            for table in _tables(
                kind.section, "[chain]", f'required, of a chain file with kind = "{name}"'
            )
        ),
        *_tables(Material, "[material]", "optional, steel by default"),
    ]


def _tables(model: type[InputModel], title: str, need: str) -> Iterator[SectionTable]:
    rows: list[FieldRow] = []
    inner: dict[type[InputModel], str] = {}
    for name, info in model.model_fields.items():
        kind = part_kind(info)
        if kind is None:
            rows.append(_row(name, info))
            continue
        place = f"{title.strip('[]')}.{name}"
        place = f"[[{place}]]" if field_extra(info, "many") else f"[{place}]"
        rows.append(FieldRow(name, "", f"a table {place}", info.description or ""))
        inner.setdefault(kind, place)  # tables of one kind are SECTIONS once
    yield SectionTable(title, need, tuple(rows))
    for kind, place in inner.items():
        yield from _tables(kind, place, "optional")


def _row(name: str, info: FieldInfo) -> FieldRow:
    unit = field_extra(info, "unit")
    shown = "" if unit is None else DISPLAY_UNITS.get(unit, (unit, 1.0))[0]
    symbol = field_extra(info, "symbol")
    meaning = (info.description or "") + (f" ({symbol})" if symbol else "")
    if is_inertia(info):
        meaning += f"; or {gd2_name(name)}, its GD2"
    low, high, allowed = field_extra(info, "minimum_si"), field_extra(info, "maximum_si"), ""
    if unit is not None and low is not None and high is not None:
        allowed = f"{_limit(low, unit)} to {_limit(high, unit)}"
    choices = [
        kind
        for kind in (info.annotation, *get_args(info.annotation))
        if get_origin(kind) is Literal
    ]
    if choices:
        allowed = " or ".join(get_args(choices[0]))
    default = info.default
    if default is not PydanticUndefined and default not in (..., None, "", ()):
        text = (
            format_quantity(default, unit) if unit and isinstance(default, float) else f"{default}"
        )
        allowed += f"{', ' if allowed else ''}default {text}"
    return FieldRow(name, shown, allowed, meaning)


def _limit(value: float, unit: str) -> str:
    """Write a limit; a pure number without exponent as long as it is readable."""
    if not unit and float(value).is_integer() and abs(value) < WRITTEN_OUT:
        return f"{value:.0f}"
    return format_quantity(value, unit)
