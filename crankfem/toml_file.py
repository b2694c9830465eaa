"""Read a TOML file of quantities: values with units, each with its source or marked assumed."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from geometry.errors import InputError
from geometry.model import InputModel, field_extra

Model = TypeVar("Model", bound=InputModel)


@dataclass(frozen=True)
class InputRecord:
    """One value of an input file, as given, with where it comes from.

    Attributes
    ----------
    field : str
        Section and field, such as ``throw.crank_radius``.
    given : str
        The text in the file.
    meaning, symbol : str
        What it is.
    source : str
        Where the value stands, or why it was assumed.
    assumed : bool
        Whether it is a typical value that nobody gave.
    """

    field: str
    given: str
    meaning: str
    symbol: str
    source: str
    assumed: bool


@dataclass(frozen=True)
class TomlFile:
    """The sections of a TOML file, values and sources apart.

    Attributes
    ----------
    path : Path
    sections : dict
        Section name to field name to value.
    provenance : dict
        Field to (source or reason, assumed).
    sources : dict
        Short name to full citation.
    records : list
        Every value read through `model`, in order.
    """

    path: Path
    sections: dict[str, dict[str, Any]]
    provenance: dict[str, tuple[str, bool]]
    sources: dict[str, str]
    records: list[InputRecord] = field(default_factory=list)

    def check_sections(self, allowed: Mapping[str, bool]) -> None:
        """Refuse unknown sections, and missing ones that are required.

        Raises
        ------
        InputError
        """
        for name in self.sections:
            if name not in allowed:
                raise InputError(
                    f"{self.path.name}: [{name}] is an unknown section; allowed are {', '.join(allowed)}."
                )
        for name, required in allowed.items():
            if required and name not in self.sections:
                raise InputError(
                    f"{self.path.name}: the section [{name}] is missing; required are "
                    f"{', '.join(key for key, needed in allowed.items() if needed)}."
                )

    def model(self, section: str, kind: type[Model]) -> Model | None:
        """Validate one section; None if the file lacks it.

        Raises
        ------
        InputError
        """
        if section not in self.sections:
            return None
        values = self.sections[section]
        made = kind.from_text(values, section)
        for name, info in kind.model_fields.items():
            if name in values:
                source, assumed = self.provenance.get(f"{section}.{name}", (self.path.name, False))
                given = _show(values[name])
            else:
                source, assumed = "default", True
                given = _show(getattr(made, name))
            self.records.append(
                InputRecord(
                    field=f"{section}.{name}",
                    given=given,
                    meaning=info.description or "",
                    symbol=field_extra(info, "symbol") or "",
                    source=source,
                    assumed=assumed,
                )
            )
        return made


def read_toml(path: Path) -> TomlFile:
    """Read a file into sections.

    Raises
    ------
    InputError
        If it cannot be read, is not TOML, or has values outside sections.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: cannot be read as text ({error}); allowed is a TOML file."
        ) from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: is not TOML ({error}); allowed is a TOML file.") from None
    sources = content.pop("sources", {})
    if not isinstance(sources, dict):
        raise InputError(
            f"{path.name}: sources: given {sources!r}; allowed is a section [sources]."
        )
    sections: dict[str, dict[str, Any]] = {}
    provenance: dict[str, tuple[str, bool]] = {}
    for section, values in content.items():
        if not isinstance(values, dict):
            raise InputError(
                f"{path.name}: {section}: given {values!r} outside any section; "
                "allowed are sections like [throw]."
            )
        sections[section] = {}
        for name, value in values.items():
            plain, origin = _split(f"{section}.{name}", value, sources)
            sections[section][name] = plain
            if origin is not None:
                provenance[f"{section}.{name}"] = origin
    return TomlFile(path, sections, provenance, {k: str(v) for k, v in sources.items()})


def _split(
    field_name: str, value: Any, sources: Mapping[str, str]
) -> tuple[Any, tuple[str, bool] | None]:
    """Take a value out of its table with source or assumption."""
    if not isinstance(value, dict) or "value" not in value:
        return value, None
    extra = set(value) - {"value", "source", "assumed"}
    if extra or {"source", "assumed"} <= set(value):
        raise InputError(
            f"{field_name}: given {value!r}; allowed beside value is either source or assumed."
        )
    if "assumed" in value:
        return value["value"], (_cite(str(value["assumed"]), sources), True)
    return value["value"], (_cite(str(value.get("source", "")), sources), False)


def _cite(text: str, sources: Mapping[str, str]) -> str:
    """Replace the short names of sources by brackets that the report explains."""
    for name in sources:
        text = re.sub(rf"\b{re.escape(name)}\b", f"[{name}]", text)
    return text


def _show(value: object) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(str(item) for item in value)
    return str(value)
