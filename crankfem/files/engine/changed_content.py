"""Sections of an engine file changed in Python: records of their values, and the file's content then."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args

import numpy as np

from crankbase.choices import allowed_names, is_number
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra
from crankbase.quantity import format_quantity
from crankfem.files.reading.toml_file import InputRecord
from crankfem.files.reading.toml_text import field_value
from geometry.any_throw import Throw
from geometry.throw import CrankThrow

SOURCE = "changed in Python"

Provenance = Mapping[str, tuple[str, bool]]


@dataclass(frozen=True)
class Change:
    """A value that differs from before: its field, such as "throw.web_width", and the new value.

    `record` is None if the value was removed.
    """

    field: str
    record: InputRecord | None


def section_kinds(owner: type[Any]) -> dict[str, tuple[type[InputModel], bool]]:
    """Return the sections of a class by name: their type, and whether they may be missing."""
    kinds = {}
    for part in fields(owner):
        for kind in get_args(part.type) if isinstance(part.type, UnionType) else (part.type,):
            if isinstance(kind, type) and issubclass(kind, InputModel):
                kinds[part.name] = (kind, NoneType in get_args(part.type))
    return kinds


def changed_section(owner: object, name: str, section_or_values: object) -> Any:
    """Return a section of a file with its changes.

    Parameters
    ----------
    owner : object
        The file as read; its annotations define its sections.
    section_or_values : InputModel, mapping or None
        The whole section; the fields that change with their values [SI]; or None.
    """
    kinds = section_kinds(type(owner))
    if name not in kinds:
        raise InputError(f"{name}: unknown section; {allowed_names(name, kinds)}.")
    kind, optional = kinds[name]
    if section_or_values is None:
        if optional:
            return None
        raise InputError(
            f"{name}: given None; allowed are its fields or a whole section, because every engine has it."
        )
    if isinstance(section_or_values, Mapping):
        section = getattr(owner, name)
        return (
            kind(**section_or_values)
            if section is None
            else changed_fields(name, section, section_or_values)
        )
    if not isinstance(section_or_values, Throw if name == "throw" else kind):
        raise InputError(
            f"{name}: given {section_or_values!r}; allowed are fields with their values, such as "
            f"{{{next(iter(kind.model_fields))!r}: ...}}, or a whole section of the type {kind.__name__}."
        )
    return section_or_values


def changed_fields(section: str, before: object, values: Mapping[str, Any]) -> Any:
    """Return a record with some fields changed; a throw from a STEP file has none."""
    if isinstance(before, InputModel):
        return before.changed(**values)
    raise InputError(
        f"{section}: given fields of a throw from a STEP file; allowed is a whole CrankThrow, or what "
        "import_throw returns, because such a throw has no dimensions to change."
    )


def changed_throws(throws: Mapping[str, Throw], new: object) -> dict[str, Throw]:
    """Return named throws with changes to some of them.

    Parameters
    ----------
    throws : mapping
        Empty if the file has one throw without a name.
    new : mapping
        Name to a throw, to fields that change [SI] (all fields of a new throw), or to None: removed.
    """
    if not isinstance(new, Mapping) or (new and not throws):
        raise InputError(
            f"throws: given {new!r}; allowed are names with changes, in an engine with throws by name; the "
            "one throw of another is changed by throw={...}."
        )
    made = dict(throws)
    for name, change in new.items():
        if change is None:
            made.pop(name, None)
        elif isinstance(change, Throw):
            made[name] = change
        elif isinstance(change, Mapping):
            made[name] = (
                changed_fields(f"throws.{name}", throws[name], change)
                if name in throws
                else CrankThrow(**change)
            )
        else:
            raise InputError(
                f"throws.{name}: given {change!r}; allowed are fields with their new, a whole CrankThrow, "
                "or None."
            )
    return made


def changes(before: object, after: object, section: str | None = None) -> tuple[Change, ...]:
    """Return the differences between two records of one section, which may have a name of its own.

    A throw from a STEP file is no record, and has none.
    """
    some = after or before
    if not isinstance(some, InputModel):
        return ()
    return tuple(_changes(section or type(some).section, before, after))


def without_changed(
    records: Sequence[InputRecord], provenance: Provenance, changed: Sequence[Change]
) -> tuple[tuple[InputRecord, ...], dict[str, tuple[str, bool]]]:
    """Return records and provenance in which changed values no longer have their former sources."""

    def stale(name: str) -> bool:
        return any(
            name == change.field or name.startswith((f"{change.field}.", f"{change.field}["))
            for change in changed
        )

    new = {change.field: change.record for change in changed if change.record is not None}
    kept: list[InputRecord] = []
    for record in records:
        if not stale(record.field):
            kept.append(record)
        elif record.field in new:
            kept.append(new.pop(record.field))
    kept.extend(new.values())
    remaining = {name: origin for name, origin in provenance.items() if not stale(name)}
    for change in changed:
        if change.record is not None:
            remaining[change.field] = (change.record.source, change.record.assumed)
    return tuple(kept), remaining


def _changes(prefix: str, before: object, after: object) -> Iterator[Change]:
    kind = type(after or before)
    assert issubclass(kind, InputModel)
    for name, info in kind.model_fields.items():
        field = f"{prefix}.{name}"
        old, new = getattr(before, name, None), getattr(after, name, None)
        if old == new:
            continue
        if isinstance(new or old, InputModel):
            yield from _changes(field, old, new)
            continue
        record = None
        if new is not None:
            shown = _format_change(new, field_extra(info, "unit"))
            meaning, symbol = info.description or "", field_extra(info, "symbol") or ""
            set_now = name in getattr(after, "model_fields_set", ())
            source = SOURCE if set_now else "default"
            assumed = not set_now and name not in kind.choices
            record = InputRecord(field, shown, meaning, symbol, source, assumed)
        yield Change(field, record)


def _format_change(value: object, unit: str | None) -> str:
    if isinstance(value, tuple):
        return ", ".join(_format_change(item, unit) for item in value)
    if unit is not None and is_number(value):
        return format_quantity(value, unit)
    return str(value)


# Fields that name files in the folder of theirs.
FILE_FIELDS = re.compile(
    r"torque\.table|throw\.file|throws\.[\w-]+\.file|gas\.pressure_table|gas_map\.points\[\d+\]\.pressure_table|vibration\.model|study\.file"
    r"|shaft_line\.(torsional|axial|plant)"
)

Table = dict[str, Any]


def changed_content(content: Mapping[str, Any], before: Any, after: Any) -> Table:
    """Return the content of a changed engine's file.

    Parameters
    ----------
    content : mapping
        Of the file that the engine was read from, as parsed.
    before, after : EngineFile
        As that file describes it, and with its changes.
    """
    made = dict(content)
    changes = _Changes(before.provenance, after.provenance, tuple(after.sources))
    for name, (kind, _) in section_kinds(type(after)).items():
        if name == "throw" and (after.throws_by_name or after.throw == before.throw):
            continue
        section, old, new = kind.section, getattr(before, name), getattr(after, name)
        if new is None:
            made.pop(section, None)
        elif section in content or old != new:
            made[section] = changes.section(made.get(section, {}), old, new, section)
    if after.throws_by_name != before.throws_by_name:
        made["throws"] = {
            name: changes.section(
                {} if "like" in content["throws"].get(name, {}) else made["throws"].get(name, {}),
                before.throws_by_name.get(name),
                throw,
                f"throws.{name}",
            )
            for name, throw in after.throws_by_name.items()
        }
    if after.study is None:
        made.pop("study", None)
    if after.torque_table is None:
        made.pop("torque", None)
    if not after.shaft_lines:
        made.pop("shaft_line", None)
    return made


def lost_changes(written: Any, changed: Any) -> list[str]:
    """Return the parts of a changed `EngineFile` in which what was written of it differs, as read again."""
    return [
        part.name
        for part in fields(changed)
        if part.name not in ("files", "records", "provenance", "text")
        and _comparable(getattr(written, part.name)) != _comparable(getattr(changed, part.name))
    ]


def _comparable(part: Any) -> Any:
    """Return what is equal of parts that are equal: of arrays lists."""
    if is_dataclass(part):
        return [_comparable(getattr(part, each.name)) for each in fields(part)]
    if isinstance(part, Mapping):
        return {name: _comparable(item) for name, item in part.items()}
    if isinstance(part, tuple):
        return [*map(_comparable, part)]
    return part.tolist() if isinstance(part, np.ndarray) else part


class _Changes:
    """Tables with changes, and the sources of their values before and after."""

    def __init__(
        self,
        before: Mapping[str, tuple[str, bool]],
        after: Mapping[str, tuple[str, bool]],
        sources: tuple[str, ...],
    ) -> None:
        self._before, self._after, self._sources = before, after, sources

    def section(
        self, table: Mapping[str, Any], before: InputModel | None, after: InputModel, path: str
    ) -> Table:
        """Return the table of a record: what is unchanged stands as it is."""
        names = [
            name
            for name in type(after).model_fields
            if name in after.model_fields_set and getattr(after, name) is not None
        ]
        ordered = sorted(names, key=lambda name: [*table, name].index(name))
        return {name: self._field(table, before, after, path, name) for name in ordered}

    def _field(
        self,
        table: Mapping[str, Any],
        before: InputModel | None,
        after: InputModel,
        path: str,
        name: str,
    ) -> Any:
        field, new, old = f"{path}.{name}", getattr(after, name), getattr(before, name, None)
        entry = table.get(name)
        if isinstance(new, InputModel):
            return self.section(entry or {}, old, new, field)
        if isinstance(new, tuple) and new and all(isinstance(part, InputModel) for part in new):
            parts = zip(
                [*(entry or ()), *[{}] * len(new)],
                [*(old or ()), *[None] * len(new)],
                new,
                strict=False,
            )
            return [self.section(*part, f"{field}[{place}]") for place, part in enumerate(parts)]
        same_source = self._before.get(field) == self._after.get(field)
        if entry is not None and old == new and same_source:
            return entry
        return self._with_source(field, field_value(after, name))

    def _with_source(self, field: str, value: Any) -> Any:
        text, assumed = self._after.get(field, ("", False))
        for name in self._sources:  # which stand in brackets when they are read
            text = text.replace(f"[{name}]", name)
        return {"value": value, "assumed" if assumed else "source": text} if text else value


def with_files_seen_from(folder: Path, content: Any, home: Path, field: str = "") -> Any:
    """Return content in which the names of files are as seen from another folder than their home."""
    if isinstance(content, Mapping):
        return {
            name: with_files_seen_from(
                folder, item, home, field if name == "value" else f"{field}.{name}".lstrip(".")
            )
            for name, item in content.items()
        }
    if isinstance(content, list):
        return [
            with_files_seen_from(folder, item, home, f"{field}[{place}]")
            for place, item in enumerate(content)
        ]
    named = isinstance(content, str) and FILE_FIELDS.fullmatch(field)
    if not named or not os.path.isfile(home / content):
        return content
    place = (home / content).resolve()
    with suppress(ValueError):  # on another drive
        place = Path(os.path.relpath(place, folder.resolve()))
    return place.as_posix()
