"""The throws of a file: one for all cranks, or named ones and the assignment to cranks."""

import math
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from crankbase.array_checks import refuse_crank_radians, refuse_many_turns
from crankbase.choices import check_choice
from crankbase.errors import InputError, InputErrors
from crankbase.model import InputModel, quantity_field
from crankbase.sentences import amount, joined, kept
from crankfem.files.reading.toml_file import TomlFile
from geometry.any_throw import Throw, dimensioned
from geometry.throw import CrankThrow

# What the one throw of a plain file is called among throws by name.
PLAIN = "throw"
# Names stand in fields, results and the names of files.
NAME = re.compile(r"[A-Za-z0-9_-]+")

Throws = Mapping[str, Throw]
# Crank radii of throws in one shaft agree to this share, if one is measured in a file.
SAME_RADIUS, MEASURED_RADIUS = 1e-9, 1e-4


class ShaftLayout(InputModel):
    """Sequence of throws in a shaft whose throws are unequal, or are not one per cylinder."""

    section: ClassVar[str] = "shaft"

    throw_angles: tuple[float, ...] | None = quantity_field(
        "angle of each throw's first pin, throw by throw from the free end; by default the crank angles of "
        "the engine",
        "rad",
        default=None,
    )
    throws: tuple[str, ...] | None = Field(
        None,
        description="name of each crank's throw from the free end, of those in the sections [throws.NAME]",
    )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.throw_angles is None and self.throws is None:
            raise InputError(
                f"{self.section}.throw_angles: missing; allowed are throw_angles, throws or both, because "
                "these are what the section is for."
            )
        angles, field = self.throw_angles or (), f"{self.section}.throw_angles"
        refuse_many_turns(field, angles)
        refuse_crank_radians(field, np.degrees(angles), written=True)
        return self


class NamedThrow(InputModel):
    """Fields of a named throw in addition to those of [throw]."""

    section: ClassVar[str] = "throws"

    like: str | None = Field(
        None,
        description="name of another throw, given in full, whose fields this one shares; fields given here "
        "replace them",
    )
    reversed: bool = Field(
        False,
        description="whether it is that other throw turned end for end, with the fields given here",
    )

    @model_validator(mode="after")
    def _turned_from_another(self) -> Self:
        if self.reversed and self.like is None:
            raise InputError(
                f"{self.section}.reversed: given without like; allowed are both, because a throw without "
                "like is described as it is in the shaft."
            )
        return self


class CadThrow(InputModel):
    """A throw whose shape is in a STEP file, in place of dimensions."""

    section: ClassVar[str] = "throw"

    file: str = Field(
        description="STEP file in the folder of this one: a throw along z, cut off square in the middles of "
        "its main journals, as crankfem cad writes it"
    )
    pins: tuple[str, ...] = Field(
        ("pin",),
        description="names of the crankpins' faces, where faces have names",
        json_schema_extra={"feature": True},
    )


def read_throws(content: TomlFile) -> dict[str, Throw]:
    """Read the throws of a file by name; that of the section [throw] is "throw"."""
    tables = content.sections.get("throws")
    if tables is None:
        if "file" in content.sections.get("throw", ()):
            return {PLAIN: _imported(content, "throw", content.sections["throw"])}
        return {PLAIN: content.required("throw", CrankThrow)}
    if not tables:
        raise InputError("throws: given no throw; allowed are sections like [throws.a].")
    made: dict[str, Throw] = {}
    errors = InputErrors()
    for name in tables:
        with errors.noted():
            made[name] = _named(content, name, tables)
    errors.tell()
    return made


def throw_names(throws: Throws, layout: ShaftLayout | None, count: int) -> tuple[str, ...]:
    """Return the name of each crank's throw, from the free end.

    Parameters
    ----------
    throws : mapping
        From `read_throws`.
    count : int
        Number of cranks.
    """
    names = None if layout is None else layout.throws
    if PLAIN in throws:
        if names is not None:
            raise InputError(
                "shaft.throws: given together with the section [throw]; allowed only with sections like "
                "[throws.a], because otherwise all cranks have the one throw."
            )
        return (PLAIN,) * count
    if names is None:
        raise InputError(
            "shaft.throws: missing; the name of each crank's throw must be given from the free end, "
            f"because the file has throws of the names {', '.join(throws)}."
        )
    if len(names) != count:
        raise InputError(
            f"shaft.throws: given {len(names)} names; allowed is {count}, because the shaft has so many "
            "cranks."
        )
    _check_names(names, throws)
    unused = [name for name in throws if name not in names]
    if unused:
        raise InputError(
            f"throws.{unused[0]}: given, but no crank uses it; allowed are throws listed in shaft.throws, "
            "because another name there may be meant as this one."
        )
    return names


def free_end_throw_name(throws: Throws, layout: ShaftLayout | None) -> str:
    """Return the name of the throw at the free end; if the file has no shaft, of its first throw."""
    names = () if layout is None or PLAIN in throws else layout.throws or ()
    _check_names(names, throws)
    return next(iter(names or throws))


def _check_names(names: Sequence[str], throws: Throws) -> None:
    for name in names:
        check_choice("shaft.throws", name, throws, "these throws are in the file")


def throw_of_name(throws: Throws, name: object, field: str, default: str) -> Throw:
    """Return the throw of a field or option, or the default one."""
    if name is None:
        return throws[default]
    if PLAIN in throws:
        raise InputError(
            f"{field}: given {name!r}; allowed only where throws have names, in sections like [throws.a], "
            "because the file has one throw, without a name."
        )
    check_choice(field, name, throws, "these throws are in the file")
    return throws[str(name)]


def check_compatible_throws(throws: Throws) -> None:
    """Refuse named throws that cannot be cranks of one shaft."""
    (first, model), *others = throws.items()
    count = len(model.parts.pins)
    for name, throw in others:
        both = len(dimensioned({name: throw, first: model})) == 2
        close = SAME_RADIUS if both else MEASURED_RADIUS
        if not math.isclose(throw.crank_radius, model.crank_radius, rel_tol=close):
            raise InputError(
                f"throws.{name}.crank_radius: given {amount(throw.crank_radius, 'm')}; allowed is "
                f"{amount(model.crank_radius, 'm')} as in throws.{first}, because all pistons of an "
                "engine have one stroke."
            )
        if len(throw.parts.pins) != count:
            raise InputError(
                f"throws.{name}.further_pins: given {len(throw.parts.pins)} pins in all; allowed is {count} "
                f"as in throws.{first}, because cylinders are counted along shafts with equally many pins "
                "on each crank."
            )


def throws_along_shaft(
    throws: Throws, names: Sequence[str], angles_deg: ArrayLike
) -> tuple[Throw, ...]:
    """Return the throw of each crank, named throws checked to form a shaft.

    Parameters
    ----------
    names : sequence of n str
        From `throw_names`.
    angles_deg : array_like of shape (n,)
        Of the throws [deg].
    """
    along = tuple(throws[name] for name in names)
    if PLAIN not in throws:
        from geometry.crankshaft import Crankshaft

        check_compatible_throws(throws)
        _ = Crankshaft(
            along, crank_angles_deg=np.asarray(angles_deg).tolist()
        )  # refuses main journals that neighbors cannot share
    return along


def _named(content: TomlFile, name: str, tables: Mapping[str, Any]) -> Throw:
    """Read a named throw, with the fields of the throw that it is like."""
    section, values = f"throws.{name}", tables[name]
    if not isinstance(values, Mapping):
        raise InputError(
            f"{section}: given {values!r}; allowed is a section [{section}] with the fields of a throw."
        )
    if name == PLAIN or not NAME.fullmatch(name):
        raise InputError(
            f"throws: given a throw of the name {name!r}; allowed are letters, digits, - and _, and "
            "another name than throw, because results and pictures have this name."
        )
    if "file" in values:
        return _imported(content, section, values)
    dimensions = {key: value for key, value in values.items() if key not in NamedThrow.model_fields}
    beside = {key: value for key, value in values.items() if key not in dimensions}
    if not beside:
        return content.made(section, CrankThrow, dimensions)
    try:
        also = content.made(section, NamedThrow, beside)
    except InputError as error:
        lines = [] if "like" in beside else _sentences(dimensions, section)
        raise InputError(joined("\n", [*error.sentences, *lines])) from None
    if also.like is None:
        return content.made(section, CrankThrow, dimensions)
    full = [
        other
        for other, fields in tables.items()
        if isinstance(fields, Mapping) and not {"like", "file"} & fields.keys()
    ]
    if also.like not in full:
        raise InputError(
            f"{section}.like: given {also.like!r}; allowed is another throw that is given in full"
            f"{': ' if full else ', but there is none'}{', '.join(full)}."
        )
    merged = _with_missing_fields(
        content, section, dimensions, f"throws.{also.like}", tables[also.like]
    )
    try:
        throw = content.made(section, CrankThrow, merged)
    except InputError as error:
        # What is wrong in the other throw is told of that one.
        other = tables[also.like]
        there = zip(
            _sentences(other, section), _sentences(other, f"throws.{also.like}"), strict=True
        )
        renamed = dict(there)
        raise InputError(
            joined("\n", (renamed.get(line, line) for line in error.sentences))
        ) from None
    return throw.reversed() if also.reversed else throw


def _imported(content: TomlFile, section: str, values: Mapping[str, Any]) -> Throw:
    """Read a throw from the STEP file that a section names."""
    made = content.made(section, CadThrow, values)
    file = content.files.named(f"{section}.file", made.file)
    if file.sent is not None:
        raise InputError(
            f"{section}.file: given {made.file!r}, sent with the engine; allowed are dimensions here, "
            "because STEP files are read where crankfem runs."
        )
    try:
        return _read(str(file.path.resolve()), file.path.stat().st_mtime_ns, made.pins)
    except InputError as error:
        raise InputError(f"{section}.file: {kept(str(error))}") from None


@lru_cache(maxsize=64)
def _read(path: str, _modified: int, pins: tuple[str, ...]) -> Throw:
    from geometry.imported import import_throw  # here: few files name a STEP file

    return import_throw(path, pins=pins)


def _sentences(values: Mapping[str, Any], section: str) -> list[str]:
    """The errors in the fields of a throw."""
    try:
        CrankThrow.from_text(
            {name: value for name, value in values.items() if name not in NamedThrow.model_fields},
            section,
        )
    except InputError as error:
        return error.sentences
    return []


def _with_missing_fields(
    content: TomlFile,
    section: str,
    values: Mapping[str, Any],
    other_section: str,
    other: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the fields of a table with those of another that it lacks, with their sources."""
    merged = dict(values)
    for key, value in other.items():
        place, origin = f"{section}.{key}", f"{other_section}.{key}"
        if key not in values:
            merged[key] = value
            for field, source in list(content.provenance.items()):
                if field == origin or field.startswith((f"{origin}.", f"{origin}[")):
                    content.provenance[place + field.removeprefix(origin)] = source
        elif isinstance(value, Mapping) and isinstance(values[key], Mapping):
            merged[key] = _with_missing_fields(content, place, values[key], origin, value)
    return merged
