"""The section [study] of a file: what varies, over which ranges, by which design."""

from collections.abc import Iterator, Mapping
from typing import Any

from crankbase.checks.choices import allowed_names
from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.crank_throws import Throws, throw_of_name
from crankfem.files.study.design_file import read_design
from fem.material import Material
from geometry.throw import CrankThrow
from regression.plans.design_choice import DesignChoice
from regression.plans.designs_factorial import ROMAN
from regression.plans.factors import Factor, ThrowField, throw_fields, unknown_field
from regression.plans.plan import StudyPlan

FIELDS = (
    "design",
    "runs",
    "resolution",
    "generators",
    "face",
    "file",
    "held_out",
    "seed",
    "accuracy",
    "stresses",
    "constraints",
    "factors",
    "relations",
    "throw",
)
# What the plan takes and checks as the file says it.
PLAIN_FIELDS = ("held_out", "seed", "accuracy", "stresses", "constraints")
RANGE_KEYS = ("from", "to", "levels", "spacing")


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
    for name in values:
        if name not in FIELDS:
            raise InputError(f"study.{name}: unknown field; {allowed_names(name, FIELDS)}.")
    throw = throw_of_name(throws, values.get("throw"), "study.throw", default)
    kind = values.get("design", DesignChoice.kind)
    kind = kind.casefold() if isinstance(kind, str) else kind
    factors = _factors(_table(values, "factors"), throw)
    rows = None
    if kind == "file":
        factors, rows = read_design(content.path.parent, values.get("file"), factors, throw)
    elif "file" in values:
        raise InputError(
            f"study.file: given {values['file']!r} with the design {kind!r}; allowed is it with 'file' "
            "only."
        )
    return StudyPlan(
        throw=throw,
        factors=factors,
        design=DesignChoice(
            kind=kind,
            runs=values.get("runs"),
            resolution=_resolution(values.get("resolution")),
            generators=values.get("generators"),
            face=values.get("face"),
            rows=rows,
        ),
        relations=_relations(_table(values, "relations")),
        material=material,
        **{name: values[name] for name in PLAIN_FIELDS if name in values},
    )


def _table(values: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    given = values.get(name, {})
    if not isinstance(given, dict):
        example = {
            "factors": 'web_width = ["270 mm", "300 mm", "330 mm"]',
            "relations": 'web_width = "1.6 * pin_diameter"',
        }[name]
        raise InputError(
            f"study.{name}: given {given!r}; allowed is a section [study.{name}] with lines like "
            f"{example}."
        )
    return given


def _factors(table: Mapping[str, Any], throw: CrankThrow) -> tuple[Factor, ...]:
    fields = throw_fields(throw)
    return tuple(_factor(path, given, fields, throw) for path, given in _paths(table, fields, ""))


def _paths(
    table: Mapping[str, Any], fields: Mapping[str, ThrowField], prefix: str
) -> Iterator[tuple[str, Any]]:
    """Take what varies out of tables of parts, such as [study.factors.counterweight]."""
    for name, given in table.items():
        path = prefix + name
        part = any(known.startswith(f"{path}.") for known in fields)
        if isinstance(given, dict) and (part or not set(given) & set(RANGE_KEYS)) and given:
            yield from _paths(given, fields, f"{path}.")
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


def _resolution(given: object) -> int | None:
    if given is None:
        return None
    found = next((number for number, roman in ROMAN.items() if roman == given), None)
    if found is None:
        raise InputError(
            f"study.resolution: given {given!r}; allowed are {', '.join(ROMAN.values())}, in quotes."
        )
    return found


def _relations(table: Mapping[str, Any]) -> dict[str, str]:
    """Take relations out of tables of parts."""
    found: dict[str, str] = {}
    for name, given in table.items():
        if isinstance(given, dict):
            found |= {f"{name}.{path}": text for path, text in _relations(given).items()}
        else:
            found[name] = given
    return found
