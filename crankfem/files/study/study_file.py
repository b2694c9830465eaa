"""The section [study] of a file: factors, ranges and design."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.crank_throws import Throws, throw_of_name
from crankfem.files.sections.study_section import StudySection
from crankfem.files.study.design_file import read_design
from fem.material import Material
from geometry.throw import CrankThrow
from regression.plans.designs import ROMAN, DesignChoice
from regression.plans.factors import Factor, ThrowField, throw_fields, unknown_field
from regression.plans.plan import StudyPlan

RANGE_KEYS = ("from", "to", "levels", "spacing")
RESOLUTIONS = {roman: number for number, roman in ROMAN.items()}


def study_plan(
    content: TomlFile, throws: Throws, default: str, material: Material
) -> StudyPlan | None:
    """Read the plan of a study; None if the file has no section [study].

    Parameters
    ----------
    content : TomlFile
    throws : mapping
        Of the same file, by name.
    default : str
        Name of the throw that varies where the section names none.
    material : Material

    Raises
    ------
    InputError
        If something is unknown or out of range. Whether its designs can be built is found out when they
        are listed, by `StudyPlan.planned`.
    """
    values = content.sections.get("study")
    if values is None:
        return None
    given = StudySection.from_text(values)
    throw = throw_of_name(throws, given.throw, "study.throw", default)
    factors, rows = _factors(given.factors, throw), None
    if given.file is not None:
        factors, rows = read_design(content.files.named("study.file", given.file), factors, throw)
    return StudyPlan(
        throw=throw,
        factors=factors,
        design=DesignChoice(
            kind=given.design,
            runs=given.runs,
            resolution=RESOLUTIONS[given.resolution] if given.resolution else None,
            generators=given.generators,
            face=given.face,
            rows=rows,
        ),
        relations=dict(_paths(given.relations)),
        constraints=given.constraints,
        held_out=given.held_out,
        seed=given.seed,
        material=material,
        accuracy=given.accuracy,
        stresses=given.stresses,
    )


def _factors(table: Mapping[str, Any], throw: CrankThrow) -> tuple[Factor, ...]:
    fields = throw_fields(throw)

    def is_range(path: str, given: Mapping[str, Any]) -> bool:
        part = any(known.startswith(f"{path}.") for known in fields)
        return not given or (not part and bool(set(given) & set(RANGE_KEYS)))

    return tuple(_factor(path, given, fields, throw) for path, given in _paths(table, is_range))


def _paths(
    table: Mapping[str, Any],
    ends_at: Callable[[str, Mapping[str, Any]], bool] | None = None,
    prefix: str = "",
) -> Iterator[tuple[str, Any]]:
    """Separate entries of tables of parts, such as [study.factors.counterweight]."""
    for name, given in table.items():
        path = prefix + name
        if isinstance(given, dict) and not (ends_at and ends_at(path, given)):
            yield from _paths(given, ends_at, f"{path}.")
        else:
            yield path, given


def _factor(
    path: str, given: object, fields: Mapping[str, ThrowField], throw: CrankThrow
) -> Factor:
    name, found = f"study.factors.{path}", fields.get(path)
    if found is not None and found.choices:
        if not isinstance(given, list) or not all(isinstance(label, str) for label in given):
            raise InputError(
                f"{name}: given {given!r}; allowed is a list of {', '.join(found.choices)}."
            )
        return Factor.of_labels(path, given)
    if found is None and _has_text(given):
        # A name that relations use is a pure number, so this is meant as a field.
        raise InputError(f"{name}: unknown throw dimension; {unknown_field(path, fields, throw)}.")
    unit = "" if found is None else found.unit
    if isinstance(given, dict):
        return _range(path, given, unit)
    if not isinstance(given, list):
        raise InputError(
            f'{name}: given {given!r}; allowed is a list of levels, like ["270 mm", "300 mm", '
            '"330 mm"], or a range, like { from = "270 mm", to = "330 mm" }.'
        )
    levels = [parse_quantity(text, unit, f"{name}[{place}]") for place, text in enumerate(given)]
    return Factor.of_levels(path, unit, levels)


def _has_text(given: object) -> bool:
    items: list[object] = []
    if isinstance(given, dict):
        items = [value for key, value in given.items() if key != "spacing"]
    elif isinstance(given, list):
        items = given
    return any(isinstance(item, str) for item in items)


def _range(path: str, given: Mapping[str, Any], unit: str) -> Factor:
    name = f"study.factors.{path}"
    for key in given:
        if key not in RANGE_KEYS:
            raise InputError(f"{name}.{key}: unknown field; allowed are {', '.join(RANGE_KEYS)}.")
    for key in ("from", "to"):
        if key not in given:
            raise InputError(f"{name}.{key}: missing; a range needs both from and to.")
    low = parse_quantity(given["from"], unit, f"{name}.from")
    high = parse_quantity(given["to"], unit, f"{name}.to")
    if "levels" in given:
        return Factor.spread(path, unit, low, high, given["levels"], given.get("spacing", "even"))
    if "spacing" in given:
        raise InputError(
            f"{name}.spacing: given without levels; allowed beside it is a number of levels, which it "
            "spreads over the range."
        )
    return Factor(path, unit, low, high)
