"""What each field of an engine file means, from its declaration: for the docs and the command line."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra, part_kind
from crankbase.units.quantity import format_quantity
from crankbase.units.units import DISPLAY_UNITS
from crankfem.files.sections import (
    damper_sections,
    engine_sections,
    excitation_sections,
    limits_sections,
    mechanism_sections,
    vibration_sections,
)
from fem.material import Material
from geometry.shaft_ends import ShaftEnds
from geometry.throw import CrankThrow

# Whole numbers below this are written out.
WRITTEN_OUT = 1e10

SECTIONS: tuple[tuple[type[InputModel], str], ...] = (
    (engine_sections.Engine, "required for more than a throw"),
    (CrankThrow, "required"),
    (engine_sections.NamedThrow, "optional, in place of [throw]; with all fields of [throw] and"),
    (engine_sections.ShaftLayout, "optional"),
    (ShaftEnds, "optional"),
    (Material, "optional, steel by default"),
    (mechanism_sections.Rod, "required for more than a throw"),
    (mechanism_sections.Piston, "required for more than a throw"),
    (mechanism_sections.HingedRods, "optional"),
    (engine_sections.Flywheel, "required for run and vibration"),
    (engine_sections.FreeEnd, "optional"),
    (engine_sections.ThrustBearing, "required for run and vibration"),
    (vibration_sections.Damping, "optional"),
    (damper_sections.TorsionalDamperSection, "optional"),
    (damper_sections.AxialDamperSection, "optional"),
    (vibration_sections.Driven, "optional"),
    (vibration_sections.Bearings, "optional"),
    (vibration_sections.ShaftLineFiles, "optional"),
    (mechanism_sections.Gas, "optional; without it reactions are given for 100 kN"),
    (excitation_sections.GasMap, "optional"),
    (excitation_sections.Misfire, "optional"),
    (excitation_sections.PropellerForcesSection, "optional"),
    (limits_sections.LimitsInput, "optional"),
    (limits_sections.RangesInput, "optional"),
    (engine_sections.VibrationSettings, "optional"),
    (engine_sections.TorqueTable, "optional"),
    (engine_sections.TwoMassInput, "optional"),
)

# Sections that have names of the user's own.
TITLES = {"throws": "[throws.NAME]"}


@dataclass(frozen=True)
class FieldRow:
    """One field: its name, the unit it is shown in, what is allowed, and its meaning."""

    name: str
    unit: str
    allowed: str
    meaning: str


@dataclass(frozen=True)
class SectionTable:
    """One section, or a table within it: its title in brackets, whether it is needed, its fields."""

    title: str
    need: str
    rows: tuple[FieldRow, ...]


def section_tables(section: str | None = None) -> list[SectionTable]:
    """Tables of one section, with the tables in it, or of all.

    Raises
    ------
    InputError
        If there is no such section.
    """
    names = [model.section for model, _ in SECTIONS]
    if section is not None and section not in names:
        raise InputError(f"section: given {section!r}; allowed are {', '.join(names)}.")
    return [
        table
        for model, need in SECTIONS
        if section in (None, model.section)
        for table in _tables(model, TITLES.get(model.section, f"[{model.section}]"), need)
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
        inner.setdefault(kind, place)  # tables of one kind are described once
    yield SectionTable(title, need, tuple(rows))
    for kind, place in inner.items():
        yield from _tables(kind, place, "optional")


def _row(name: str, info: FieldInfo) -> FieldRow:
    unit = field_extra(info, "unit")
    shown = "" if unit is None else DISPLAY_UNITS.get(unit, (unit, 1.0))[0]
    symbol = field_extra(info, "symbol")
    meaning = (info.description or "") + (f" ({symbol})" if symbol else "")
    return FieldRow(name, shown, _allowed(info), meaning)


def _allowed(info: FieldInfo) -> str:
    unit, low, high = (field_extra(info, key) for key in ("unit", "minimum_si", "maximum_si"))
    allowed = ""
    if unit is not None and low is not None and high is not None:
        allowed = f"{_limit(low, unit)} to {_limit(high, unit)}"
    choices = [kind for kind in (info.annotation, *get_args(info.annotation)) if _is_choice(kind)]
    if choices:
        allowed = " or ".join(get_args(choices[0]))
    default = info.default
    if default is not PydanticUndefined and default is not ... and default is not None:
        text = (
            format_quantity(default, unit) if unit and isinstance(default, float) else f"{default}"
        )
        allowed += f"{', ' if allowed else ''}default {text}"
    return allowed


def _limit(value: float, unit: str) -> str:
    """Write a limit; a pure number without exponent as long as it can be read so."""
    if not unit and float(value).is_integer() and abs(value) < WRITTEN_OUT:
        return f"{value:.0f}"
    return format_quantity(value, unit)


def _is_choice(kind: object) -> bool:
    return get_origin(kind) is Literal
