"""Results that describe themselves: each value declares its unit and its meaning once.

JSON both ways, its units, data frames, the texts of the console and of notebooks follow from the declaration.
"""

import inspect
import json
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache, cached_property
from types import NoneType, UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Literal,
    Self,
    TypeAlias,
    TypeVar,
    Union,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from crankbase.errors import InputError, SolveError, quoted
from crankbase.frames import DataFrame, Row, table_of
from crankbase.quantity import RPM
from crankbase.sentences import Sentence, with_sentences
from crankbase.summaries import summarized

if TYPE_CHECKING:
    from pydantic import TypeAdapter


T = TypeVar("T")

# Units that files have in place of SI's, with the size of the SI unit in them and the end of the name.
EXPORTED = {"1/min": (RPM, "_rpm"), "deg": (180.0 / math.pi, "_deg")}


@dataclass(frozen=True)
class Quantity:
    """What a value is.

    Parameters
    ----------
    unit : str
        In SI; "1" of plain numbers, "" of words and parts, ".name" if the value of that name
        beside it tells, which may be internal, or one of the result around it; ".." if it is
        declared where the part is used.
    meaning : str, optional
        In words.
    exported : str, optional
        Unit in JSON if it is not SI, one of `EXPORTED`: its name ends with "_rpm" or "_deg" there.
    key : str, optional
        Name in JSON, if it is not that of the field.
    left_out : bool, optional
        Whether JSON leaves the value out where it is None.
    flat : bool, optional
        Whether the content of this part stands in JSON beside the part's neighbors.
    missing : float, optional
        What null in JSON stands for: without bound, or NaN for what there is not.
    """

    unit: str = ""
    meaning: str = ""
    exported: str = ""
    key: str = ""
    left_out: bool = False
    flat: bool = False
    missing: float = math.inf

    def key_of(self, name: str) -> str:
        """Return the key in JSON of a field."""
        return self.key or name + (EXPORTED[self.exported][1] if self.exported else "")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        size = EXPORTED[self.exported][0] if self.exported else 1.0
        # Also optional ones, and mappings to arrays; numpy 2.5 names the alias in place of the class.
        if any(name in str(source) for name in ("numpy.ndarray", "NDArray[")):
            return core_schema.no_info_plain_validator_function(
                lambda values: _array(values, size, self.missing)
            )
        if source is complex:
            return core_schema.no_info_plain_validator_function(lambda parts: complex(*parts))
        if (source is not float and size == 1.0) or not self.unit:
            return handler(source)

        def internal(value: Any, missing: float | None = self.missing) -> Any:
            if isinstance(value, list):
                return [internal(part) for part in value]
            return missing if value is None else value / size

        # JSON knows no infinity: null is unbounded.
        top = self.missing if source is float else None
        return core_schema.no_info_before_validator_function(
            lambda value: internal(value, top), handler(source)
        )


INTERNAL = Quantity("internal")
Internal: TypeAlias = Annotated[T, INTERNAL]
# Plain numbers and parts; quantities declare their meaning besides: Annotated[float, Quantity("N", "...")].
Number: TypeAlias = Annotated[float, Quantity("1")]
Hertz: TypeAlias = Annotated[float, Quantity("Hz")]
Speed: TypeAlias = Annotated[float, Quantity("rad/s", exported="1/min")]
Part: TypeAlias = Annotated[T, Quantity()]
# In the unit that the value "unit" beside it names.
InItsUnit: TypeAlias = Annotated[float, Quantity(".unit")]
Flat: TypeAlias = Annotated[T, Quantity(flat=True)]


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def result(*main: str, eq: bool = False) -> Callable[[type[T]], type[T]]:
    """Make a frozen class of results with a short text; what its texts say are finished sentences.

    Parameters
    ----------
    *main : str
        Main values, as for `crankbase.summaries.summarized`; declared units need not be told.
    eq : bool, optional
        Whether results of equal values are equal; no class with arrays can be so.
    """

    def decorate(cls: type[T]) -> type[T]:
        has_text = "__repr__" in vars(cls)
        return summarized(*main, keeps_text=has_text, unit_of=_unit_of)(
            with_sentences(dataclass(frozen=True, eq=eq, repr=False)(cls))
        )

    return decorate


def _unit_of(source: object, path: str) -> str:
    """Return the declared unit of an attribute, or of one of an attribute."""
    *owners, name = path.split(".")
    for owner in owners:
        source = getattr(source, owner)
    known = contents(type(source)) if isinstance(source, Result) else {}
    unit = known[name][0].unit if name in known else ""
    return "" if unit[:1] in ("1", ".") else unit


class Result:
    """Base of results: fields are their content, but for those that are `Internal`.

    Properties whose return type holds a `Quantity` belong to the content, too. A result that is read from
    JSON has its content and the defaults alone: of properties, those cached have what was written, and
    others follow from the content again. What is internal is not there.
    """

    def to_json(self, indent: int | None = None) -> str:
        """Return content and units of its numbers; None where a value is unbounded.

        Raises
        ------
        SolveError
            Naming the first number that is NaN.
        """
        return json_text(self.to_record() | {"units": by_names(units(self))}, indent)

    def to_record(self) -> dict[str, Any]:
        """Return the content as JSON holds it, without units."""
        record: dict[str, Any] = plain(self)
        return record

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """Read what `to_json` wrote; keys that it does not know are left out.

        Raises
        ------
        InputError
            Naming the first key that is missing, or has another kind of value.
        """
        return cls.from_record(json.loads(text))

    @classmethod
    def from_record(cls, content: "Mapping[str, Any] | Self") -> Self:
        """Read content of JSON; a result is returned as it is."""
        from pydantic import ValidationError

        if isinstance(content, cls):
            return content
        if not isinstance(content, Mapping):
            raise InputError(f"{cls.__name__}: given {quoted(content)}; allowed is its content.")
        made = object.__new__(cls)
        for name, (quantity, kind) in _read(cast("Any", cls)).items():
            key = quantity.key_of(name)
            if key not in content and not (quantity.flat or quantity.left_out):
                raise InputError(
                    f"{cls.__name__}: the result has no {key}; it is not of this release."
                )
            part = content if quantity.flat else content.get(key)
            try:
                vars(made)[name] = _said_again(
                    _adapter(kind).validate_python(part), content.get(SAID, {}).get(key)
                )
            except ValidationError as error:
                first = error.errors()[0]
                if isinstance(inner := first.get("ctx", {}).get("error"), InputError):
                    raise inner from None
                place = ".".join(map(str, (name, *first["loc"])))
                raise InputError(f"{cls.__name__}.{place}: {first['msg']}.") from None
        return made

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(cls.from_record)

    def row(self) -> Row:
        """Return the single values by column, each with its SI unit."""
        return dict(_cells(self, ""))

    def to_pandas(self) -> DataFrame:
        """Return a table with one row; units in ``frame.attrs["units"]``."""
        return table_of([self])


def made_from(source: object, kind: type[T], **others: Any) -> T:
    """Return an instance of a data class whose required fields are attributes of another object.

    Parameters
    ----------
    **others
        Fields that are not.
    """
    needed = (
        entry.name
        for entry in fields(cast("type[Any]", kind))
        if entry.name not in others and entry.default is MISSING is entry.default_factory
    )
    return kind(**{name: getattr(source, name) for name in needed}, **others)


def json_text(content: Mapping[str, Any], indent: int | None = None) -> str:
    """Return content as JSON, in which every number is finite.

    Raises
    ------
    SolveError
        Naming the first number that is not.
    """
    try:
        return json.dumps(content, indent=indent, allow_nan=False) + "\n"
    except ValueError:
        wrong = next(_not_finite(content, ""), None)
        if wrong is None:
            raise
        raise SolveError(
            f"The result {wrong[0]} is {wrong[1]}: allowed are finite numbers."
        ) from None


def contents(cls: Any) -> dict[str, tuple[Quantity, Any]]:
    """Return what each value of a class is, and its type; fields first, then properties.

    Raises
    ------
    TypeError
        If a field has neither a declaration nor a type that JSON holds.
    """
    return _contents(cls)


@cache
def _contents(cls: Any) -> dict[str, tuple[Quantity, Any]]:
    hints = get_type_hints(cls, include_extras=True) if is_dataclass(cls) else {}
    known = {
        entry.name: _entry(f"{cls.__name__}.{entry.name}", hints[entry.name])
        for entry in (fields(cls) if is_dataclass(cls) else ())
    }
    for base in reversed(cls.__mro__):
        for name, entry in vars(base).items():
            getter = (
                entry.fget
                if isinstance(entry, property)
                else entry.func
                if isinstance(entry, cached_property)
                else None
            )
            if getter is None or "Quantity" not in str(getter.__annotations__.get("return", "")):
                continue
            kind = get_type_hints(getter, include_extras=True)["return"]
            known[name] = _entry(f"{cls.__name__}.{name}", kind)
    return {name: entry for name, entry in known.items() if entry[0] is not INTERNAL}


@cache
def _read(cls: Any) -> dict[str, tuple[Quantity, Any]]:
    """Return the contents that are read from JSON: all but properties that follow from the others."""
    return {
        name: entry
        for name, entry in contents(cls).items()
        if not isinstance(inspect.getattr_static(cls, name, None), property)
    }


def _entry(place: str, kind: Any) -> tuple[Quantity, Any]:
    if quantity := _quantity(kind):
        return quantity, kind
    if not _is_part(kind):
        raise TypeError(f"{place}: {kind} needs a Quantity, or is Internal")
    return Quantity("1" if kind is int else ""), kind


def _quantity(kind: Any) -> Quantity | None:
    """Return the declaration of a type, also of one that may be None."""
    if isinstance(kind, str):
        return None
    extras = getattr(kind, "__metadata__", ())
    known = next((extra for extra in extras if isinstance(extra, Quantity)), None)
    if known is None and get_origin(kind) in (Union, UnionType):
        return next(filter(None, map(_quantity, get_args(kind))), None)
    return known


def _is_part(kind: Any) -> bool:
    """Return whether JSON holds values of a type, without a unit."""
    origin = get_origin(kind)
    if origin is Literal:
        return True
    if origin is Annotated:
        return _quantity(kind) is not None or _is_part(get_args(kind)[0])
    if origin is not None:
        return all(part is Ellipsis or _is_part(part) for part in get_args(kind))
    return kind in (str, bool, int, NoneType, dict) or _is_result(kind) or _is_input(kind)


def _is_result(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Result)


def _is_input(value: Any) -> bool:
    """Return whether something is a model of input, or a class of such."""
    return hasattr(value, "model_dump")


def plain(value: Any) -> Any:
    """Return a value as JSON content: arrays and complex numbers as lists, infinities as None."""
    if value is None or type(value) in (str, int, bool):  # most are; what follows takes its time
        return value
    if isinstance(value, Result):
        record: dict[str, Any] = {}
        said: dict[str, Any] = {}
        for name, (quantity, _) in contents(type(value)).items():
            content = getattr(value, name)
            if quantity.left_out and content is None:
                continue
            if quantity.flat:
                part = plain(content)
                said |= part.pop(SAID, {})
                record |= part
                continue
            if (pieces := _said(content)) is not None:
                said[quantity.key_of(name)] = pieces
            if math.isnan(quantity.missing):
                content = _without_nan(content)
            if quantity.exported and content is not None:
                content = np.asarray(content, dtype=float) * EXPORTED[quantity.exported][0]
            record[quantity.key_of(name)] = plain(content)
        return record | ({SAID: said} if said else {})
    if isinstance(value, str):
        return str(value)
    if _is_input(value):
        value = value.model_dump(mode="json")
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind in "bif" and np.isfinite(value).all():
            return value.tolist()
        value = value.tolist()
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    return None if isinstance(value, float) and math.isinf(value) else value


# Key of the sentences of a result, beside its texts: words and values of each in turn, by its key.
SAID = "said"


def _said(content: Any) -> Any:
    """Return words and values of a sentence or of several, None in place of a plain text; None for none."""
    if isinstance(content, Sentence):
        return content.record()
    if isinstance(content, tuple | list):
        pieces = [_said(part) if isinstance(part, str) else None for part in content]
        return pieces if any(pieces) else None
    if isinstance(content, Mapping):
        by_name = {
            str(name): _said(part) for name, part in content.items() if isinstance(part, str)
        }
        return {name: pieces for name, pieces in by_name.items() if pieces} or None
    return None


def _said_again(value: Any, pieces: Any) -> Any:
    """Return what was read with the sentences that belong to it, if there are any."""
    if not pieces:
        return value
    if isinstance(value, str):
        return Sentence.from_record(pieces)
    if isinstance(value, Mapping):
        return {name: _said_again(part, pieces.get(name)) for name, part in value.items()}
    return type(value)(map(_said_again, value, pieces))


def _without_nan(value: Any) -> Any:
    """Return numbers with what JSON has as null, infinity, in place of NaN."""
    if isinstance(value, Mapping):
        return {name: _without_nan(part) for name, part in value.items()}
    return None if value is None else np.where(np.isnan(value), np.inf, value)


def _not_finite(value: Any, path: str) -> Iterator[tuple[str, float]]:
    """Yield path and value of every number that is not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path, value
    inside = (
        value.items()
        if isinstance(value, Mapping)
        else enumerate(value, start=1)
        if isinstance(value, list | tuple)
        else ()
    )
    for name, part in inside:
        yield from _not_finite(part, f"{path}.{name}" if path else str(name))


def units(
    value: Any, path: str = "", around: tuple["Result", ...] = (), of_part: str = ""
) -> dict[str, str]:
    """Return the units of the numbers in results, by their paths in JSON; lists are not counted.

    "*" stands for all names of a mapping of numbers; `by_names` shortens the paths.

    Parameters
    ----------
    around : tuple of Result
        Those that the value is a part of, the innermost first.
    of_part : str
        Unit declared for the value.
    """
    known: dict[str, str] = {}
    if value is None or isinstance(value, str | float | int):
        return known
    if isinstance(value, Result):
        around = (value, *around)
        for name, (quantity, kind) in contents(type(value)).items():
            content, place = getattr(value, name), f"{path}{quantity.key_of(name)}"
            unit = of_part if quantity.unit == ".." else quantity.exported or quantity.unit
            if unit and not _has_results(kind):
                inside = f"{place}.*" if isinstance(content, Mapping) else place
                named: Any = unit
                tells = (owner for owner in around if unit[:1] == "." and hasattr(owner, unit[1:]))
                owner = next(tells, None)
                if owner is not None and unit[1:] not in contents(type(owner)):
                    named = getattr(owner, unit[1:])  # JSON has nothing else that tells it
                if isinstance(named, Mapping):  # a unit for each name
                    known |= {f"{place}.{key}": key_unit for key, key_unit in named.items()}
                else:
                    known[inside] = named
            known |= units(content, path if quantity.flat else f"{place}.", around, unit)
    elif _is_input(value):
        from crankbase.model import model_units

        known = model_units(value, path)
    elif isinstance(value, Mapping):
        for name, part in value.items():
            known |= units(part, f"{path}{name}.", around, of_part)
    elif isinstance(value, list | tuple):
        for part in value:
            known |= units(part, path, around, of_part)
    return known


def by_names(paths: Mapping[str, str]) -> dict[str, str]:
    """Return units by the fewest last names of each path that no number of another unit has.

    Examples
    --------
    >>> by_names({"pin.mass": "kg", "rod.mass": "kg", "pin.load": "N", "fit.load": "m", "fit.a.*": "1"})
    {'mass': 'kg', 'pin.load': 'N', 'fit.load': 'm', 'a.*': '1'}
    """
    known, of_stars = defaultdict[str, set[str]](set), defaultdict[str, set[str]](set)
    for path, unit in paths.items():
        for end, with_star in _ends(path):
            known[end].add(unit)
            (of_stars if end == with_star else known)[with_star].add(unit)
    return {
        next(
            (end for end, star in _ends(path) if len(known[end] | of_stars[star]) == 1), path
        ): unit
        for path, unit in paths.items()
    }


def _ends(path: str) -> list[tuple[str, str]]:
    """Return the ends of a path, the shortest first, and the same with a star for the last name."""
    names = path.split(".")
    return [
        (".".join(names[-count:]), ".".join((*names[-count:-1], "*")))
        for count in range(1 + (names[-1] == "*"), len(names) + 1)
    ]


@cache
def _has_results(kind: Any) -> bool:
    """Return whether a type is of results, or holds them."""
    return _is_result(kind) or any(map(_has_results, get_args(kind)))


def _cells(source: Result, before: str, of_part: str = "") -> Iterator[tuple[str, tuple[Any, str]]]:
    for name, (quantity, _) in contents(type(source)).items():
        value = getattr(source, name)
        unit = of_part if quantity.unit == ".." else quantity.unit
        if isinstance(value, Result):
            yield from _cells(value, f"{before}{name}.", unit)
        elif not (isinstance(value, Mapping | tuple | list | np.ndarray) or _is_input(value)):
            yield f"{before}{name}", (value, getattr(source, unit[1:]) if unit[:1] == "." else unit)


@cache
def _adapter(kind: Any) -> "TypeAdapter[Any]":
    """Return what reads a value of a type from JSON."""
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def _array(values: Any, size: float, missing: float) -> Any:
    if values is None or isinstance(values, Mapping):
        return values and {name: _array(each, size, missing) for name, each in values.items()}
    array = np.array(values)
    if array.dtype == object:
        array = array.astype(float)  # in which null is NaN
        array[np.isnan(array)] = missing
    return array if size == 1.0 else array / size
