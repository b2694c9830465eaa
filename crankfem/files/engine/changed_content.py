"""The content of an engine file with the changes that were made in Python."""

import os
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.model import InputModel
from crankfem.files.reading.section_changes import section_kinds
from crankfem.files.reading.toml_text import field_value

# Fields that name files in the folder of theirs.
FILE_FIELDS = re.compile(
    r"torque\.table|gas\.pressure_table|gas_map\.points\[\d+\]\.pressure_table|vibration\.model|study\.file"
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
        if name == "throw" and after.throws_by_name:
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
