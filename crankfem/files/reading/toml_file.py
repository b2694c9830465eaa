"""Read a TOML file of quantities: values with units, each with its source or marked assumed."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from crankbase.checks.choices import did_you_mean
from crankbase.errors import InputError, InputErrors
from crankbase.input_file import LARGEST_TEXT_FILE
from crankbase.model import InputModel, field_extra, part_kind
from crankbase.units.quantity import format_quantity
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_errors import not_toml
from crankfem.files.reading.toml_limits import check_content, check_keys, too_deep
from crankfem.files.reading.toml_places import place_of

Model = TypeVar("Model", bound=InputModel)


@dataclass(frozen=True)
class InputRecord:
    """One value of an input file, as given, with its source.

    Attributes
    ----------
    field : str
        Section and field, such as ``throw.crank_radius``.
    given : str
        The text in the file.
    meaning, symbol : str
        Its description.
    source : str
        Source of the value, or why it was assumed.
    assumed : bool
        Whether it is a typical value, not given by anybody.
    effect : str
        For an assumed value: its effect on results, if known.
    """

    field: str
    given: str
    meaning: str
    symbol: str
    source: str
    assumed: bool
    effect: str = ""


@dataclass(frozen=True)
class TomlFile:
    """The sections of a TOML file, with values and sources separated.

    Attributes
    ----------
    files : InputFiles
        The file, and those that it may name.
    sections : dict
        Section name to field name to value.
    provenance : dict
        Field to (source or reason, assumed).
    sources : dict
        Short name to full citation.
    records : list
        Every value read through `model`, in order.
    text : str
        Of the file.
    """

    files: InputFiles
    sections: dict[str, dict[str, Any]]
    provenance: dict[str, tuple[str, bool]]
    sources: dict[str, str]
    records: list[InputRecord] = field(default_factory=list)
    text: str = field(default="", repr=False, compare=False)

    @property
    def path(self) -> Path:
        """What messages call the file, and where it is unless it was sent."""
        return self.files.path

    def check_sections(self, allowed: Mapping[str, bool]) -> None:
        """Refuse unknown sections, and missing ones that are required.

        Raises
        ------
        InputError
            With a sentence for each unknown one, else one for those missing: an unknown section may be a
            missing one with another name.
        """
        unknown = [
            f"{self.path.name}: [{name}] is an unknown section; "
            f"{did_you_mean(name, allowed, cutoff=0.7, form='[{}]')}allowed are {', '.join(allowed)}."
            for name in self.sections
            if name not in allowed
        ]
        required = [name for name, needed in allowed.items() if needed]
        missing = [f"[{name}]" for name in required if name not in self.sections]
        if unknown:
            raise InputError("\n".join(unknown))
        if missing and not self.sections:
            raise InputError(
                f"{self.path.name}: has no sections; required are {', '.join(required)}, as in an example "
                "that crankfem new writes."
            )
        if missing:
            gone = "sections {} are" if len(missing) > 1 else "section {} is"
            raise InputError(
                f"{self.path.name}: the {gone.format(', '.join(missing))} missing; required are "
                f"{', '.join(required)}."
            )

    def model(self, section: str, kind: type[Model]) -> Model | None:
        """Validate one section; None if the file lacks it.

        Raises
        ------
        InputError
        """
        if section not in self.sections:
            return None
        return self.made(section, kind, self.sections[section])

    def made(self, section: str, kind: type[Model], values: Mapping[str, Any]) -> Model:
        """Validate values as a section, and record them.

        Raises
        ------
        InputError
        """
        made = kind.from_text(values, section)
        self._record(section, made, values)
        return made

    @contextmanager
    def all_errors(
        self,
        kinds: Mapping[str, type[InputModel]],
        others: Mapping[str, Callable[["TomlFile"], object]] | None = None,
    ) -> Iterator[None]:
        """Report, with the first error that ends a reading, those of all sections.

        Parameters
        ----------
        kinds : mapping
            Section to its model.
        others : mapping, optional
            Section without a model to its reader.

        Raises
        ------
        InputError
        """
        try:
            yield
        except InputError as first:
            errors = InputErrors()
            for name, values in self.sections.items():
                with errors.noted():
                    if name in kinds:
                        kinds[name].from_text(values, name)
                    elif others and name in others:
                        others[name](self)
            told = {line for error in errors.found for line in error.sentences}
            alone = [] if told.issuperset(first.sentences) else [first]
            with self.with_lines():
                raise InputError.of_all([*alone, *errors.found]) from None

    @contextmanager
    def with_lines(self) -> Iterator[None]:
        """Say of errors about fields in which lines of the file these are.

        Raises
        ------
        InputError
        """
        try:
            yield
        except InputError as error:
            raise InputError("\n".join(map(self._with_line, error.sentences))) from None

    def _with_line(self, sentence: str) -> str:
        """Add to a sentence about a field in which line of the file it is."""
        place = place_of(self.text, sentence.partition(":")[0])
        if place is None:
            return sentence
        return f"{sentence.removesuffix('.')} ({self.path.name}, {place})."

    def required(self, section: str, kind: type[Model]) -> Model:
        """Validate one required section.

        Raises
        ------
        InputError
        """
        made = self.model(section, kind)
        if made is None:
            raise InputError(f"{self.path.name}: the section [{section}] is missing.")
        return made

    def _record(self, section: str, made: InputModel, values: Mapping[str, Any]) -> None:
        """Record every value of a record, and of the nested records that the file gives."""
        for name, info in type(made).model_fields.items():
            field_name, value = f"{section}.{name}", getattr(made, name)
            if part_kind(info) is not None:
                parts = values.get(name, ())
                if isinstance(parts, Mapping):
                    self._record(field_name, value, parts)
                else:
                    for place, part in enumerate(parts):
                        self._record(f"{field_name}[{place}]", value[place], part)
                continue
            if name in values:
                source, assumed = self.provenance.get(field_name, (self.path.name, False))
                given = _show(values[name])
            elif value is None or field_extra(info, "feature"):
                continue
            else:
                source, assumed = "default", name not in type(made).choices
                given = _show(value, field_extra(info, "unit")) or "not given"
            self.records.append(
                InputRecord(
                    field=field_name,
                    given=given,
                    meaning=info.description or "",
                    symbol=field_extra(info, "symbol") or "",
                    source=source,
                    assumed=assumed,
                )
            )


def read_toml(given: Path | InputFiles) -> TomlFile:
    """Read a file into sections.

    Raises
    ------
    InputError
        If it cannot be read, is not TOML, or has values outside sections.
    """
    files = given if isinstance(given, InputFiles) else InputFiles(given)
    path = files.path
    if path.suffix.lower() in (".step", ".stp"):
        raise InputError(
            f"{path}: is a STEP file; allowed is a TOML file here, because only `crankfem throw` reads STEP."
        )
    text = files.own.text(LARGEST_TEXT_FILE, "a file of dimensions", "a TOML file")
    check_keys(path.name, text)
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise too_deep(path.name) from None
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise InputError(f"{path}: {not_toml(text, error)}") from None
    check_content(path.name, content)
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
        sections[section] = _values_apart(section, values, sources, provenance)
    texts = {name: str(value) for name, value in sources.items()}
    return TomlFile(files, sections, provenance, texts, text=text)


def _values_apart(
    prefix: str,
    values: Mapping[str, Any],
    sources: Mapping[str, str],
    provenance: dict[str, tuple[str, bool]],
) -> dict[str, Any]:
    """Separate the values of a table, and of nested tables, from their sources."""
    plain: dict[str, Any] = {}
    for name, value in values.items():
        field_name = f"{prefix}.{name}"
        if isinstance(value, dict) and "value" not in value:
            plain[name] = _values_apart(field_name, value, sources, provenance)
        elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            plain[name] = [
                _values_apart(f"{field_name}[{place}]", item, sources, provenance)
                for place, item in enumerate(value)
            ]
        else:
            plain[name], origin = _split(field_name, value, sources)
            if origin is not None:
                provenance[field_name] = origin
    return plain


def _split(
    field_name: str, value: Any, sources: Mapping[str, str]
) -> tuple[Any, tuple[str, bool] | None]:
    """Separate a value from its source or assumption."""
    if not isinstance(value, dict) or "value" not in value:
        return value, None
    extra = set(value) - {"value", "source", "assumed"}
    if extra or {"source", "assumed"} <= set(value):
        meant = "".join(did_you_mean(name, ("source", "assumed")) for name in sorted(extra))
        raise InputError(
            f"{field_name}: given {value!r}; {meant}allowed with value is either source or assumed."
        )
    if "assumed" in value:
        return value["value"], (_cite(str(value["assumed"]), sources), True)
    return value["value"], (_cite(str(value.get("source", "")), sources), False)


def _cite(text: str, sources: Mapping[str, str]) -> str:
    """Replace the short names of sources by brackets that the report explains."""
    for name in sources:
        if name not in text:  # most are not, and a pattern takes long to make
            continue
        text = re.sub(rf"\b{re.escape(name)}\b", f"[{name}]", text)
    return text


def _show(value: object, unit: str | None = None) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(str(item) for item in value)
    if isinstance(value, bool):
        return str(value).lower()
    return format_quantity(value, unit) if unit and isinstance(value, float) else str(value)
