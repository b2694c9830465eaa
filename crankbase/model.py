"""The base of all validated input: pydantic models whose errors are one clear sentence each."""

import inspect
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self, cast, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from crankbase.choices import allowed_names, is_number
from crankbase.errors import MOST_TOLD, InputError, InputErrors, named, quoted
from crankbase.quantity import DISPLAY_UNITS
from crankbase.sentences import amount, joined, kept, lines
from crankbase.written_quantity import Limits, effect_by_mass, other_unit, parse_quantity

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
    from pydantic_core import ErrorDetails
else:
    ModelMetaclass = type(BaseModel)


def field_extra(info: FieldInfo, key: str) -> Any:
    """Return one entry of a field's declaration (unit, symbol, range), or None."""
    extra = info.json_schema_extra
    return extra.get(key) if isinstance(extra, dict) else None


def sentences(model: type[BaseModel], error: ValidationError) -> list[str]:
    """Turn what pydantic found into sentences for people, one for each field."""
    by_field = {
        str(finding["loc"][0]) if finding["loc"] else "": finding
        for finding in reversed(error.errors())
    }
    findings = list(by_field.items())[::-1]
    # Suggestions take their time; beyond the first ones nobody reads them.
    first = [sentence(model, finding) for _, finding in findings[:MOST_TOLD]]
    return first + [f"{name}: {finding['msg']}." for name, finding in findings[MOST_TOLD:]]


def sentence(model: type[BaseModel], first: "ErrorDetails") -> str:
    """Turn one finding of pydantic into a sentence."""
    location = [str(part) for part in first["loc"]]
    section = getattr(model, "section", "")
    prefix = f"{section}." if section else ""
    entry = first.get("input")
    if first["type"] == "value_error":
        text = str(first["ctx"]["error"])
        if not location:
            return text if text.startswith(prefix) else prefix + text
        field = prefix + _path(location)
        # What a part says of a field of its own begins with the part's section.
        place = prefix + ".".join(part for part in location if not part.isdigit()) + "."
        return joined(
            "\n",
            (
                f"{field}.{kept(line.removeprefix(place))}"
                if line.startswith(place)
                else f"{field}: {kept(line)}"
                for line in lines(text)
            ),
        )
    name = location[0] if location else ""
    field = prefix + _path(location)
    if first["type"] == "missing":
        info = model.model_fields[name]
        allowed = "" if field_extra(info, "unit") is None else f"; allowed is {range_text(info)}"
        return f"{field}: missing; give {_describe(info)}{allowed}."
    if first["type"] == "extra_forbidden":
        return f"{field}: unknown field; {allowed_names(name, model.model_fields)}."
    known = model.model_fields.get(name)
    if known is None:
        return f"{field}: given {quoted(entry)}; {first['msg']}."
    unit = field_extra(known, "unit")
    shown = quoted(entry)
    if unit is not None and is_number(entry):
        shown = amount(float(entry), unit)
    if first["type"] == "literal_error":
        expected = str(first["ctx"]["expected"]).replace("'", "")
        return f"{field}: given {quoted(entry)}; allowed is {expected}."
    allowed = range_text(known) if unit is not None else ""
    bound = _BOUNDS.get(first["type"])
    if unit is None and bound is not None:
        allowed = bound.format(**first.get("ctx", {}))
    if first["type"] in _KINDS:
        allowed = f"{_KINDS[first['type']]}, {allowed}".removesuffix(", ")
    meant = ""
    if unit is not None and bound is not None:
        value = float(first["input"])
        other = other_unit(f"{value:.12g} {unit}", unit, value, limits_of(known))
        meant = f"did you mean {other}? " if other else ""
    return f"{field}: given {shown}; {meant}allowed is {allowed} for {_describe(known)}."


def _path(location: Sequence[str]) -> str:
    """Write where a value stands, such as "points[0].speed"."""
    parts = [f"[{part}]" if part.isdigit() else f".{named(part)}" for part in location]
    return "".join(parts).removeprefix(".")


# What pydantic's findings about fields without a unit mean to people.
_KINDS = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "string_type": "text",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}
# And about the numbers in them; a field with a unit tells its range.
_BOUNDS = {
    "finite_number": "a finite number",
    "greater_than_equal": "a number of {ge:g} or more",
    "less_than_equal": "a number of {le:g} or less",
    "too_long": "a list of {max_length} at most",
}


def _describe(info: FieldInfo) -> str:
    symbol = field_extra(info, "symbol")
    meaning = info.description or "this value"
    return f"{meaning} ({symbol})" if symbol else meaning


def limits_of(info: FieldInfo) -> Limits:
    """Return the smallest and the largest value of a field [SI], None where there is none."""
    return field_extra(info, "minimum_si"), field_extra(info, "maximum_si")


def range_text(info: FieldInfo) -> str:
    """Write the allowed range of a field."""
    unit = field_extra(info, "unit")
    low, high = limits_of(info)
    if low is not None and high is not None:
        return f"{_limit(low, unit)} to {_limit(high, unit)}"
    if low is not None:
        return f"{_limit(low, unit)} or more"
    if high is not None:
        return f"{_limit(high, unit)} or less"
    return f"any number in {DISPLAY_UNITS.get(unit, (unit,))[0]}" if unit else "any number"


def _limit(value: float, unit: str) -> str:
    """Write the end of a range, that of a whole number with all its digits."""
    return str(value) if not unit and isinstance(value, int) else amount(value, unit)


def quantity_field(
    meaning: str,
    unit: str,
    minimum: float | None = None,
    maximum: float | None = None,
    *,
    symbol: str = "",
    default: Any = ...,
    feature: bool = False,
) -> Any:
    """Declare a field of a physical quantity: SI unit, allowed range, meaning, the papers' symbol.

    File format, error texts, help and docs all use this one declaration. A `feature` is something
    that is absent unless given: its default is no assumption.
    """
    return Field(
        default,
        ge=minimum,
        le=maximum,
        description=meaning,
        json_schema_extra={
            "unit": unit,
            "symbol": symbol,
            "minimum_si": minimum,
            "maximum_si": maximum,
            "feature": feature or default is None,
        },
    )


def length_field(meaning: str, limits: tuple[float, float], **declared: Any) -> Any:
    """Declare a field of a length [m] with its smallest and largest value; the rest as `quantity_field`."""
    return quantity_field(meaning, "m", minimum=limits[0], maximum=limits[1], **declared)


def part_field(
    meaning: str, kind: type["InputModel"], *, many: bool = False, most: int | None = None
) -> Any:
    """Declare an optional part of a record that is a record itself, or a list of such (`many`).

    A list holds `most` at most.
    """
    return Field(
        () if many else None,
        description=meaning,
        max_length=most,
        json_schema_extra={"part": kind.section, "many": many, "most": most},
    )


def field_of(model: type["InputModel"], name: str, **changed: Any) -> Any:
    """Declare a field as another record does, with another default, description or feature."""
    info = model.model_fields[name]
    low, high = limits_of(info)
    extra = {**cast(Any, info.json_schema_extra or {})}
    return Field(
        changed.get("default", info.default),
        ge=low,
        le=high,
        description=changed.get("description", info.description),
        json_schema_extra=extra | {"feature": changed.get("feature", extra.get("feature", False))},
    )


def part_kind(info: FieldInfo) -> type["InputModel"] | None:
    """Return the record that a field of parts holds, or None for any other field."""
    if field_extra(info, "part") is None:
        return None
    return next(
        kind
        for kind in get_args(info.annotation)
        if isinstance(kind, type) and issubclass(kind, InputModel)
    )


def model_units(model: "InputModel", path: str = "") -> dict[str, str]:
    """Return the units of the numbers in a record of input and in its parts, by their paths in JSON."""
    known: dict[str, str] = {}
    for name, info in type(model).model_fields.items():
        content = getattr(model, name)
        for part in content if isinstance(content, tuple | list) else (content,):
            if isinstance(part, InputModel):
                known |= model_units(part, f"{path}{name}.")
            elif is_number(part):
                known[f"{path}{name}"] = field_extra(info, "unit") or "1"
    return known


def _fields_and_methods(names: Iterable[str]) -> list[str]:
    """Hide the methods of all pydantic models: users who describe an engine do not need them."""
    usual, pydantics = dir(object), {*dir(BaseModel)}
    return [
        name for name in names if name in usual or not (name in pydantics or name.startswith("__"))
    ]


class _ShowsFields(ModelMetaclass):
    """Hides pydantic's own names in `help` and completion of a class."""

    def __dir__(self) -> list[str]:
        return _fields_and_methods(super().__dir__())


class _Kind:
    """The type of a field as shown in a signature: ``float [m]``."""

    def __init__(self, info: FieldInfo) -> None:
        kind = re.sub(r"\b(?:\w+\.)+(?=[A-Z])", "", inspect.formatannotation(info.annotation))
        kind = re.sub(r"Annotated\[(\w+), [^\[\]]*\]", r"\1", kind)
        unit = field_extra(info, "unit")
        first, *others = kind.split(" | ")
        self.text = " | ".join((f"{first} [{unit}]", *others)) if unit else kind

    def __repr__(self) -> str:
        return self.text


class InputModel(BaseModel, metaclass=_ShowsFields):
    """A frozen record of input in SI units that refuses unknown, missing and impossible values.

    Raises
    ------
    InputError
        On construction, with a sentence for each wrong field: its name, the value and the allowed values.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    section: ClassVar[str] = ""
    # Fields that choose how to calculate: their defaults assume nothing of what is calculated.
    choices: ClassVar[frozenset[str]] = frozenset()
    # Fields that others may give in another form: their defaults then assume nothing.
    other_forms: ClassVar[dict[str, tuple[str, ...]]] = {}
    # Fields that Python takes by position, too: those of a short record.
    positional: ClassVar[tuple[str, ...]] = ()

    def __init__(self, *unnamed: Any, **values: Any) -> None:
        """Take and check the values of the fields, by name, in SI units."""
        values = dict(zip(self.positional, unnamed, strict=False)) | values
        if len(unnamed) > len(self.positional):
            name = next(iter(type(self).model_fields))
            raise InputError(
                f"{type(self).__name__}: given values without names; allowed are fields by name, such as "
                f"{name}=..., because positions say nothing of what a value is."
            )
        for name, value in values.items():
            if not isinstance(value, str | bool):
                continue
            info = type(self).model_fields.get(name)
            unit = None if info is None else field_extra(info, "unit")
            if unit is not None:
                prefix = f"{self.section}." if self.section else ""
                what = "a number in deg, as the field's name says"
                if not name.endswith("_deg"):
                    kind = f"in {unit}" if unit else "without a unit"
                    what = f"a number {kind}, because in Python quantities are SI numbers"
                raise InputError(f"{prefix}{name}: given {quoted(value)}; allowed is {what}.")
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise InputError(joined("\n", sentences(type(self), error))) from None

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        cls.__signature__ = inspect.Signature(
            [
                inspect.Parameter(
                    name,
                    inspect.Parameter.KEYWORD_ONLY,
                    default=inspect.Parameter.empty
                    if info.is_required()
                    else info.get_default(call_default_factory=True),
                    annotation=_Kind(info),
                )
                for name, info in cls.model_fields.items()
            ]
        )

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse a new value: records stay as they were checked."""
        raise InputError(
            f"{type(self).__name__}.{name}: given a new value; allowed is another record, by "
            f"changed({name}=...), because records stay as they were checked."
        )

    def __dir__(self) -> Iterable[str]:
        return _fields_and_methods(super().__dir__())

    def _given(self) -> dict[str, Any]:
        """Return the given values, without defaults, in the fields' order."""
        names = self.model_fields_set
        return {name: getattr(self, name) for name in type(self).model_fields if name in names}

    def __repr__(self) -> str:
        """Show the given values, as many as a few lines hold."""
        from crankbase.summaries import summary_text

        parts = [f"{name}={value!r}" for name, value in self._given().items()]
        return summary_text(type(self).__name__, parts)

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Show the given values as a table."""
        from crankbase.summaries import summary_html

        fields = type(self).model_fields
        rows = {
            name: f"{value!r} {field_extra(fields[name], 'unit') or ''}".rstrip()
            for name, value in self._given().items()
        }
        return summary_html(type(self).__name__, rows)

    def changed(self, **values: Any) -> Self:
        """Return a record with some values changed, checked like a new one.

        Parameters
        ----------
        **values
            New values by field [SI]; None removes an optional one.

        Returns
        -------
        Self
            Fields that were defaults follow the defaults again.

        Raises
        ------
        InputError
            If a field is unknown, or the values are impossible together.
        """
        return type(self)(**self._given() | values)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy; with new values it is the record that `changed` returns."""
        return self.changed(**update) if update else super().model_copy(deep=deep)

    @classmethod
    def from_text(cls, values: Mapping[str, object], section: str | None = None) -> Self:
        """Build the record from text with units, as in a file.

        Parameters
        ----------
        values : mapping
            Field name to text, such as ``{"crank_radius": "170 mm"}``.
        section : str, optional
            Name of the record in messages; by default the class's own section.

        Raises
        ------
        InputError
            If fields are unknown, missing, without unit or outside their ranges: a sentence for each.
        """
        name = cls.section if section is None else section
        prefix = f"{name}." if name else ""
        converted: dict[str, Any] = {}
        errors = InputErrors()
        for key, text in values.items():
            field = inertia_field(cls, key)
            unknown = field is None and key not in cls.model_fields
            if unknown and len(errors.errors) >= MOST_TOLD:
                errors.errors.append(InputError(f"{prefix}{named(key)}: unknown field."))
                continue
            with errors.noted():
                if field is None:
                    converted[key] = _value_from_text(cls, key, text, f"{prefix}{named(key)}")
                elif field not in values:
                    converted[field] = _inertia_from_gd2(
                        cls.model_fields[field], text, f"{prefix}{key}"
                    )
                else:
                    raise InputError(
                        f"{prefix}{key}: given together with {field}; allowed is one of the two, because GD2 "
                        "is four times the inertia."
                    )
        if errors.errors:
            unread = {inertia_field(cls, key) or key for key in values} - set(converted)
            raise InputError.of_all(
                [*errors.errors, *_field_errors(cls, converted, unread, prefix)]
            )
        try:
            return cls(**converted)
        except InputError as error:
            section_prefix = f"{cls.section}." if cls.section else ""
            said = [prefix + line.removeprefix(section_prefix) for line in error.sentences]
            raise InputError(joined("\n", said)) from None


def _field_errors(
    kind: type[InputModel], converted: Mapping[str, Any], unread: Collection[str], prefix: str
) -> list[InputError]:
    """Errors of single fields in addition to unreadable ones, which are not missing."""
    try:
        kind.__pydantic_validator__.validate_python(
            dict(converted), self_instance=kind.__new__(kind)
        )
    except ValidationError as error:
        section_prefix = f"{kind.section}." if kind.section else ""
        return [
            InputError(prefix + sentence(kind, finding).removeprefix(section_prefix))
            for finding in error.errors()
            if finding["loc"] and finding["loc"][0] not in unread
        ]
    return []


def _value_from_text(kind: type[InputModel], key: str, text: object, name: str) -> Any:
    """Convert the file's value of one field."""
    if key not in kind.model_fields:
        keys = [
            key_of_field
            for field, info in kind.model_fields.items()
            for key_of_field in ((field, gd2_name(field)) if is_inertia(info) else (field,))
        ]
        raise InputError(f"{name}: unknown field; {allowed_names(key, keys)}.")
    info = kind.model_fields[key]
    unit, part = field_extra(info, "unit"), part_kind(info)
    if part is not None:
        return _parts_from_text(part, info, text, name)
    if unit is None:
        return text
    limits = limits_of(info)
    if isinstance(text, list) and _holds_several(info):
        # Rows of pure numbers are those of a table.
        return tuple(
            _value_from_text(kind, key, entry, f"{name}[{number}]")
            if isinstance(entry, list) and not unit
            else parse_quantity(entry, unit, f"{name}[{number}]", range_text(info), limits)
            for number, entry in enumerate(text)
        )
    value = parse_quantity(text, unit, name, range_text(info), limits)
    if meant := other_unit(text, unit, value, limits):
        raise InputError(
            f"{name}: given {text!r}; did you mean {meant}? allowed is {range_text(info)}."
        )
    return value


# GD2, mass times the square of the diameter of gyration, takes the place of any inertia under the inertia's
# name with this ending.
INERTIA, GD2 = "inertia", "flywheel_effect"
GD2_OF_INERTIA = 4.0


def inertia_field(kind: type[InputModel], key: str) -> str | None:
    """Return the field of inertia that a key gives as GD2; None for any other key.

    Parameters
    ----------
    kind : type
        Of the record whose text has the key.
    """
    if not key.endswith(GD2) or key in kind.model_fields:
        return None
    name = key.removesuffix(GD2) + INERTIA
    return name if is_inertia(kind.model_fields.get(name)) else None


def gd2_name(field: str) -> str:
    """Return the key that gives an inertia as GD2.

    Examples
    --------
    >>> gd2_name("ring_inertia")
    'ring_flywheel_effect'
    """
    return field.removesuffix(INERTIA) + GD2


def is_inertia(info: FieldInfo | None) -> bool:
    """Return whether a field is a moment of inertia."""
    return info is not None and field_extra(info, "unit") == "kg m^2"


def _inertia_from_gd2(info: FieldInfo, text: object, name: str) -> Any:
    """Return the inertia [kg m^2] of a GD2, or of each in a list."""
    if isinstance(text, list) and _holds_several(info):
        return tuple(
            _inertia_from_gd2(info, entry, f"{name}[{number}]") for number, entry in enumerate(text)
        )
    low, high = (None if end is None else GD2_OF_INERTIA * end for end in limits_of(info))
    allowed = " to ".join(amount(end, "kg m^2") for end in (low, high) if end is not None)
    value = effect_by_mass(text)
    if value is None:
        value = parse_quantity(text, "kg m^2", name, allowed, (low, high))
    if (low is not None and value < low) or (high is not None and value > high):
        raise InputError(
            f"{name}: given {quoted(text)}; allowed is {allowed} of GD2, four times the inertia."
        )
    return value / GD2_OF_INERTIA


def _holds_several(info: FieldInfo) -> bool:
    """Return whether a field is a tuple, possibly an optional one."""
    return tuple in (get_origin(kind) for kind in (info.annotation, *get_args(info.annotation)))


def _parts_from_text(kind: type[InputModel], info: FieldInfo, value: object, name: str) -> Any:
    """Build the record, or the tuple of records, from a nested table."""
    if field_extra(info, "many"):
        if not isinstance(value, list) or not all(isinstance(item, Mapping) for item in value):
            raise InputError(
                f"{name}: given {quoted(value)}; allowed is a list of tables, each under [[{name}]]."
            )
        most = field_extra(info, "most")
        if most is not None and len(value) > most:
            raise InputError(
                f"{name}: given a list of {len(value)} tables; allowed is one of {most} at most."
            )
        parts, errors = [], InputErrors()
        for place, item in enumerate(value):
            with errors.noted():
                parts.append(kind.from_text(item, f"{name}[{place}]"))
        errors.tell()
        return tuple(parts)
    if not isinstance(value, Mapping):
        raise InputError(f"{name}: given {quoted(value)}; allowed is a table [{name}].")
    return kind.from_text(value, name)
