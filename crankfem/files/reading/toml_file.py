"""Read a TOML file of quantities: values with units, each with its source or marked assumed."""

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from crankbase.choices import did_you_mean
from crankbase.errors import MOST_TOLD, InputError, InputErrors, shortened
from crankbase.input_file import (
    DEEPEST_TABLE,
    LARGEST_TEXT_FILE,
    LONGEST_TEXT,
    MOST_BITS,
    MOST_VALUES,
    STEP_ENDINGS,
)
from crankbase.model import InputModel, field_extra, inertia_field, part_kind
from crankbase.quantity import format_quantity
from crankbase.results import Result
from crankbase.sentences import END, START, finished, joined, with_sentences
from crankbase.written_quantity import SEPARATED_NUMBER, either, readings
from crankfem.files.reading.data_files import FILES_READ, InputFiles

# A key of more names than tables may lie in tables; taking it apart would take long. Nothing is gone
# back on, so that looking for it does not take long either.
_LONG_KEY = re.compile(
    rf"(?<![\w-])(?>(?>[\w-]+|\"[^\"\n]*\"|'[^'\n]*')[ \t]*\.[ \t]*){{{DEEPEST_TABLE}}}", re.ASCII
)


def check_keys(name: str, text: str) -> None:
    """Refuse a text with a dotted key of too many names.

    Parameters
    ----------
    name : str
        Of the file, for the message.
    """
    deep = _LONG_KEY.search(text)
    if deep is not None:
        line = text.count("\n", 0, deep.start()) + 1
        raise InputError(
            f"{name}: line {line}, {shortened(deep[0])!r}: given a key of more than {DEEPEST_TABLE} names; "
            f"allowed is {DEEPEST_TABLE} at most, because sections are nested no deeper than a table or two."
        )


def too_deep(name: str) -> InputError:
    """Return the error for too deeply nested tables or lists."""
    return InputError(
        f"{name}: given tables or lists within more than {DEEPEST_TABLE} others; allowed are "
        f"{DEEPEST_TABLE}, because sections are nested no deeper than a table or two."
    )


def check_content(name: str, content: dict[str, Any]) -> None:
    """Refuse content with too many values, too long texts or numbers, or too deeply nested tables.

    Parameters
    ----------
    name : str
        Of the file, for the message.
    content : dict
        From the parser.
    """
    count = 0
    waiting: list[tuple[str, int, Any]] = [("", 0, content)]
    while waiting:
        field, depth, value = waiting.pop()
        count += 1
        if count > MOST_VALUES:
            raise InputError(
                f"{name}: given more than {MOST_VALUES} values; allowed is {MOST_VALUES} at most, because an "
                "engine has some hundred."
            )
        if depth > DEEPEST_TABLE:
            raise too_deep(name)
        if isinstance(value, dict):
            for key in value:
                _check_text(name, f"{field}.{key}".lstrip("."), key)
            inner = [(f"{field}.{key}".lstrip("."), depth + 1, part) for key, part in value.items()]
            waiting.extend(reversed(inner))
        elif isinstance(value, list):
            inner = [(f"{field}[{place}]", depth + 1, part) for place, part in enumerate(value)]
            waiting.extend(reversed(inner))
        elif isinstance(value, str):
            _check_text(name, field, value)
        elif isinstance(value, float) and not math.isfinite(value):
            raise InputError(
                f"{name}: {field}: given {value}, which is not finite; allowed are numbers up to 1.8e308."
            )
        elif isinstance(value, int) and not -(2**MOST_BITS) <= value < 2**MOST_BITS:
            raise InputError(
                f"{name}: {field}: given a whole number of {value.bit_length()} bits; allowed is "
                f"{MOST_BITS} at most, because TOML has no larger ones."
            )


def _check_text(name: str, field: str, text: str) -> None:
    if len(text) > LONGEST_TEXT:
        raise InputError(
            f"{name}: {field}: given {text!r}, of {len(text)} characters; allowed is {LONGEST_TEXT} at most, "
            "because even a citation is shorter."
        )
    if START in text or END in text:
        raise InputError(
            f"{name}: {field}: given {text!r}; allowed are texts without U+E000 and U+E001, because these "
            "mark values in sentences."
        )


_ANY_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
_BARE_NAME = re.compile(r"\s*([\w.-]+)\s*=")
# A field of a section, perhaps one of a list of tables or a value of a list.
FIELD = re.compile(r"[\w-]+(?:\[\d+\])?(?:\.[\w-]+(?:\[\d+\])?)*")


def line_of(text: str, field: str) -> int | None:
    r"""Return the number of the line that gives a field or begins a section, from 1.

    Parameters
    ----------
    text : str
        Of the file.
    field : str
        Such as ``throw.web_width`` or ``throw.further_pins[0].length``; of a value in a list, such as
        ``engine.crank_angles[2]``, the line of the list.

    Returns
    -------
    int or None
        None if no line gives it, or the text is no field.

    Examples
    --------
    >>> line_of('[throw]\nweb_width = "285 mm"', "throw.web_width")
    2
    """
    if not FIELD.fullmatch(field):
        return None
    wanted = {field, re.sub(r"\[\d+\]$", "", field)}
    section, counts = "", dict[str, int]()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _ANY_HEADER.match(line):
            section = header[2]
            if header[1] == "[[":
                place = counts[section] = counts.get(section, -1) + 1
                section = f"{section}[{place}]"
            if section == field:
                return number
        elif (name := _BARE_NAME.match(line)) and f"{section}.{name[1]}" in wanted:
            return number
    return None


def place_of(text: str, field: str) -> str | None:
    r"""Name the line that gives a field, or the section where it is missing; None if there is neither.

    Examples
    --------
    >>> place_of('[throw]\nweb_width = "285 mm"', "throw.pin_length")
    'section [throw], line 1'
    """
    if (line := line_of(text, field)) is not None:
        return f"line {line}"
    section = field.rpartition(".")[0]
    line = line_of(text, section) if section else None
    return None if line is None else f"section [{section}], line {line}"


# Of a line that is looked at.
LONGEST_LINE = 500
# Where the parser stopped.
AT_LINE = re.compile(r"\(at line (\d+), column \d+\)")
# A number followed by letters, with no quotes about them: "= 9 in", "value = 82,5 mm", "[0 deg, ...".
BARE = re.compile(
    rf"[=\[,]\s*({SEPARATED_NUMBER}\s*(?:1\s*/\s*)?[A-Za-z%°µ][^\s,}}\]#\"']*(?: [A-Za-z][\w^/*]*)*)"
)
# A number with separators, alone. In a list commas stand between numbers.
SEPARATED = re.compile(rf"=\s*({SEPARATED_NUMBER})\s*(?:[,}}]|$)")
NAME = re.compile(r"\s*([\w.-]+|\"[^\"]*\"|'[^']*')\s*=")
HEADER = re.compile(r"\s*\[(?!\[)([^\]]+)\]")
# What is written wrongly, where nothing else is, outside of quotes.
FAULTS = (
    (
        re.compile("[\u201c\u201d\u201e\u2018\u2019\u00ab\u00bb]"),
        "given typographic quotes; write straight ones, \" or '",
    ),
    (
        re.compile(r"^[^\"]*\"[^\"]*$|^[^']*'[^']*$"),
        "given an opening quote without a closing one; write both",
    ),
    (
        re.compile(r"^\s*\[[^\]]*[^\x00-\x7f][^\]]*\]|^[^=\"']*[^\x00-\x7f][^=\"']*="),
        "given a name with other letters than A to Z; write names with A to Z, digits, _ and -",
    ),
    (re.compile(r"^\s*[\w.-]+\s*:"), "given a colon behind a name; write ="),
    (re.compile(r"[;,]\s*$"), "given a comma or a semicolon at its end; leave it out"),
    (
        re.compile(r"=\s*(?!(?:true|false|inf|nan)\b)[A-Za-z][\w .-]*$"),
        "given text without quotes; write it in quotes",
    ),
    (re.compile(r"^\s*\[\[?[^\]=]*$"), "given a section without its closing bracket; write it"),
)
# An apostrophe behind a digit separates thousands.
QUOTED = re.compile(r"\"(?:[^\"\\]|\\.)*\"|(?<!\d)'[^']*'")


def not_toml(text: str, error: Exception) -> str:
    """Describe the error of the parser, and the correct form.

    Parameters
    ----------
    text : str
        Of the file.
    error : Exception
        Of the parser; without a line number in it, its own words are used.

    Returns
    -------
    str
        For example ``line 46, web_width = 9 in: a quantity stands without quotes; write "9 in" ...``.
    """
    if not isinstance(error, tomllib.TOMLDecodeError):
        return "given a number of thousands of digits; allowed are numbers of 64 bits, as TOML has them."
    at_line = AT_LINE.search(str(error))
    # What is wrong shows at the beginning of a line; patterns would take long over all of a very long one.
    lines = [line[:LONGEST_LINE] for line in text.splitlines()]
    # What is never closed is found at the end of the file, of which no line is told.
    faulty = (number for number, line in enumerate(lines, start=1) if _fault(line))
    place = int(at_line[1]) if at_line else next(faulty, 0)
    if not 1 <= place <= len(lines):
        return f"is not TOML ({error}); allowed is a TOML file."
    line = lines[place - 1]
    shown = f"line {place}, {shortened(line.strip())}:"
    before = _before(lines, place)
    if before is not None:
        return (
            f"{shown} given twice, in line {before} too; allowed is each name once in its section, and each "
            "section once."
        )
    # What stands in quotes already, and remarks, are no bare quantities.
    plain = QUOTED.sub('""', line).partition("#")[0]
    bare = BARE.search(plain)
    if bare is not None:
        text_after = bare[1].strip()
        if "," in text_after and not bare[0].startswith("="):
            return (
                f"{shown} given {text_after} in a list without quotes; write each quantity in quotes, with a "
                "decimal point, because commas separate the values of a list."
            )
        return (
            f"{shown} given {text_after} without quotes; write a quantity in quotes, "
            f"{either(readings(text_after) or (text_after,))}, because it is text with its unit."
        )
    fault = _fault(line)
    if fault is not None:
        return f"{shown} {fault}."
    return f"{shown} is not TOML ({AT_LINE.sub('', str(error)).strip()}); allowed is a TOML file."


def _fault(line: str) -> str | None:
    """Say what is written wrongly in a line, None if nothing is known of it."""
    plain = QUOTED.sub('""', line).partition("#")[0]
    number = SEPARATED.search(plain)
    if number is not None and (meant := readings(number[1])):
        return (
            f"given {number[1]}; write a decimal point and no separators, like {' or '.join(meant)}"
        )
    return next((fault for pattern, fault in FAULTS if pattern.search(plain)), None)


def _before(lines: list[str], place: int) -> int | None:
    """Return the number of an earlier line that gives the same section or name, None if there is none."""
    line = lines[place - 1]
    header = HEADER.match(line)
    start = header or NAME.match(line)
    if start is None:
        return None
    for number in range(place - 1, 0, -1):
        other = lines[number - 1]
        if header is None and other.lstrip().startswith("["):
            return None
        match = start.re.match(other)
        if match is not None and match[1].strip() == start[1].strip():
            return number
    return None


Model = TypeVar("Model", bound=InputModel)


class InputWarning(NamedTuple):
    """What looks wrong in an input file: the section or field, and what is said of it."""

    field: str
    text: str

    @property
    def sentence(self) -> str:
        """Both together."""
        return finished(f"{self.field}: {self.text}")

    def with_hint(self, hint: str) -> "InputWarning":
        """Return it with what else the value may be."""
        return InputWarning(self.field, self.text + hint)


@with_sentences
@dataclass(frozen=True)
class InputRecord(Result):
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
        """Refuse unknown sections, and missing ones that are required."""
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
        """Validate one section; None if the file lacks it."""
        if section not in self.sections:
            return None
        return self.made(section, kind, self.sections[section])

    def made(self, section: str, kind: type[Model], values: Mapping[str, Any]) -> Model:
        """Validate values as a section, and record them."""
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
            lines = {line for error in errors.errors for line in error.sentences}
            alone = [] if lines.issuperset(first.sentences) else [first]
            with self.with_lines():
                raise InputError.of_all([*alone, *errors.errors]) from None

    @contextmanager
    def with_lines(self) -> Iterator[None]:
        """Say of errors about fields in which lines of the file these are."""
        try:
            yield
        except InputError as error:
            first, others = error.sentences[:MOST_TOLD], error.sentences[MOST_TOLD:]
            raise InputError(joined("\n", [*map(self._with_line, first), *others])) from None

    def _with_line(self, sentence: str) -> str:
        """Add to a sentence about a field in which line of the file it is."""
        place = place_of(self.text, sentence.partition(":")[0])
        position = f" ({self.path.name}, {place})."
        if place is None or sentence.endswith(position):
            return sentence
        return sentence.removesuffix(".") + position

    def required(self, section: str, kind: type[Model]) -> Model:
        """Validate one required section."""
        made = self.model(section, kind)
        if made is None:
            raise InputError(f"{self.path.name}: the section [{section}] is missing.")
        return made

    def _record(self, section: str, made: InputModel, values: Mapping[str, Any]) -> None:
        """Record every value of a record, and of the nested records that the file gives."""
        # An inertia may be given as GD2; under its own name it has that one's source.
        as_gd2 = {inertia_field(type(made), key): key for key in values}
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
            if name in values or name in as_gd2:
                key = as_gd2.get(name, name)
                origin = self.provenance.get(f"{section}.{key}")
                source, assumed = origin or (self.path.name, False)
                shown = _show(values[key])
                if key != name:
                    shown += f" ({key})"
                    if origin is not None:
                        self.provenance[field_name] = origin
            elif (
                value is None
                or field_extra(info, "feature")
                or any(form in values for form in type(made).other_forms.get(name, ()))
            ):
                continue
            else:
                source, assumed = "default", name not in type(made).choices
                shown = _show(value, field_extra(info, "unit")) or "not given"
            self.records.append(
                InputRecord(
                    field=field_name,
                    given=shown,
                    meaning=info.description or "",
                    symbol=field_extra(info, "symbol") or "",
                    source=source,
                    assumed=assumed,
                )
            )


def read_toml(file: Path | InputFiles) -> TomlFile:
    """Read a file into sections."""
    files = file if isinstance(file, InputFiles) else InputFiles(file)
    path = files.path
    if path.suffix.lower() in STEP_ENDINGS:
        raise InputError(
            f"{path}: is a STEP file; allowed is a TOML file here. `crankfem cad --engine MINE.toml` writes "
            "one for a STEP file of a crankshaft, and `crankfem throw` reads that of a throw."
        )
    known = FILES_READ.get() if files.sent is None else None
    if known is None or path.absolute() not in known:
        text = files.main.text(LARGEST_TEXT_FILE, "a file of dimensions", "a TOML file")
        check_keys(path.name, text)
        try:
            content = tomllib.loads(text)
        except RecursionError:
            raise too_deep(path.name) from None
        except ValueError as error:  # not TOML, or a number of thousands of digits
            raise InputError(f"{path}: {not_toml(text, error)}") from None
        if known is None:
            return sections_of(files, content, text)
        known[path.absolute()] = text, content
    text, content = known[path.absolute()]
    return sections_of(files, deepcopy(content), text)


def sections_of(files: InputFiles, content: dict[str, Any], text: str = "") -> TomlFile:
    """Return the content of a file as sections, with values and sources separated."""
    path = files.path
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
        elif isinstance(value, dict):
            extra = set(value) - {"value", "source", "assumed"}
            if extra or {"source", "assumed"} <= set(value):
                meant = "".join(did_you_mean(word, ("source", "assumed")) for word in sorted(extra))
                raise InputError(
                    f"{field_name}: given {value!r}; {meant}allowed with value is either source or assumed."
                )
            assumed = "assumed" in value
            source = str(value["assumed"] if assumed else value.get("source", ""))
            plain[name], provenance[field_name] = value["value"], (_cite(source, sources), assumed)
        else:
            plain[name] = value
    return plain


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
