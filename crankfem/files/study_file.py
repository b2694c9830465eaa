"""A study in a file: its sections, its design, its values."""

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, StrictBool, field_validator, model_validator

from crankbase.errors import InputError
from crankbase.exported_table import separator_of, with_points
from crankbase.input_file import CSV, LARGEST_TABLE_FILE, InputFile
from crankbase.model import InputModel, quantity_field
from crankbase.written_quantity import parse_quantity
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.crank_throws import Throws, throw_of_name
from fem.material import Material
from fem.wished_accuracy import COMPLIANCE_ACCURACY
from geometry.any_throw import with_dimensions
from geometry.throw import CrankThrow
from regression.fits.forms import form_named
from regression.plans.designs import (
    LARGEST_DESIGN,
    ROMAN,
    SPACE_FILLING,
    TAKERS,
    DesignChoice,
    DesignKind,
    runs_with_slopes,
)
from regression.plans.factors import Factor, ThrowField, throw_fields, unknown_field
from regression.plans.plan import StudyPlan


def read_design(
    file: InputFile, factors: tuple[Factor, ...], throw: CrankThrow
) -> tuple[tuple[Factor, ...], tuple[tuple[float, ...], ...]]:
    """Read the runs of a CSV file, and the factors from its columns if the study names none.

    The first line names the factors. A unit stands there, as in ``web_width [mm]``, or in each cell, as
    in ``270 mm``.

    Parameters
    ----------
    factors : tuple of Factor
        Of the study; may be empty.

    Returns
    -------
    factors : tuple of Factor
        Those of the study, or those of the columns with the ranges that the runs span.
    rows : tuple of tuple of float
        One run each [SI], of choices the labels' indices.
    """
    shown = file.path.name
    header, lines = _read_csv(file)
    names = [_column(cell)[0] for cell in header]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"study.file: {name} is twice in {shown}; allowed is once.")
    wanted = {factor.name: factor for factor in factors}
    if wanted and set(names) != set(wanted):
        raise InputError(
            f"study.file: given the columns {', '.join(names)} in {shown}; allowed are the factors "
            f"{', '.join(wanted)}, or no section [study.factors]."
        )
    fields = throw_fields(throw)
    columns = {}
    for place, cell in enumerate(header):
        texts = [(number, line[place].strip()) for number, line in lines]
        name, unit = _column(cell)
        if name not in fields and unit:
            raise InputError(
                f"study.file: {name} in {shown} is an unknown throw dimension; "
                f"{unknown_field(name, fields, throw)}."
            )
        values, factor = _read_column(cell, texts, shown, fields, wanted)
        columns[name] = (values, factor)
    ordered = factors or tuple(factor for _, factor in columns.values())
    rows = zip(*(columns[factor.name][0] for factor in ordered), strict=True)
    return ordered, tuple(rows)


def _read_csv(file: InputFile) -> tuple[list[str], list[tuple[int, list[str]]]]:
    path = file.path
    try:
        text = file.text(LARGEST_TABLE_FILE, "a table of designs", "a table (CSV)", CSV)
    except InputError as error:
        raise InputError(f"study.file: {error}") from None
    delimiter = separator_of(text.partition("\n")[0])
    reader = csv.reader(text.splitlines(), delimiter=delimiter)
    try:
        lines = [(reader.line_num, line) for line in reader if any(cell.strip() for cell in line)]
    except csv.Error as error:
        raise InputError(f"study.file: given {path.name!r}, which is no table ({error}).") from None
    if len(lines) < 2:
        raise InputError(
            f"study.file: given {path.name!r} without any run; allowed is a line of factor names and a "
            "line for each run."
        )
    if delimiter != ",":
        cells = with_points([line for _, line in lines])
        lines = [(number, line) for (number, _), line in zip(lines, cells, strict=True)]
    header = [cell.strip() for cell in lines[0][1]]
    for number, line in lines[1:]:
        if len(line) != len(header):
            raise InputError(
                f"study.file: given {len(line)} cells in line {number} of {path.name}; allowed are "
                f"{len(header)}, as in its first line."
            )
    return header, lines[1:]


def _column(cell: str) -> tuple[str, str]:
    """Split a column's head into name and unit: "web_width [mm]"."""
    name, bracket, unit = cell.partition("[")
    return name.strip(), unit.strip().removesuffix("]").strip() if bracket else ""


def _read_column(
    cell: str,
    texts: Sequence[tuple[int, str]],
    file: str,
    fields: Mapping[str, ThrowField],
    wanted: Mapping[str, Factor],
) -> tuple[list[float], Factor]:
    name, unit_text = _column(cell)
    field = fields.get(name)
    if field is not None and field.choices:
        labels = list(dict.fromkeys(text for _, text in texts))
        factor = wanted.get(name) or Factor.of_labels(name, labels)
        for number, text in texts:
            if text not in factor.labels:
                raise InputError(
                    f"study.file: given {name} = {text!r} in line {number} of {file}; allowed are "
                    f"{', '.join(factor.labels)}."
                )
        return [float(factor.labels.index(text)) for _, text in texts], factor
    unit = "" if field is None else field.unit
    values = []
    for number, text in texts:
        setting: object = text
        if unit:
            setting = f"{text} {unit_text}" if unit_text else text
        else:
            with suppress(ValueError):
                setting = float(text)
        place = f"study.file: {name} in line {number} of {file}"
        values.append(parse_quantity(setting, unit, place))
    return values, wanted.get(name) or Factor(name, unit, min(values), max(values))


# In place of a number of runs.
WITH_SLOPES = "with slopes"


class StudySection(InputModel):
    """Factors of a study, their ranges and the design."""

    section: ClassVar[str] = "study"
    choices = frozenset(
        {
            "held_out",
            "seed",
            "accuracy",
            "stresses",
            "slopes",
            "constraints",
            "factors",
            "relations",
        }
    )

    design: DesignKind = Field("full factorial", description="which designs are run and fitted")
    runs: int | None = quantity_field(
        f'number of runs of a Latin hypercube or a Sobol sequence; or "{WITH_SLOPES}", in any design',
        "",
        minimum=1,
        maximum=LARGEST_DESIGN,
        default=None,
    )
    resolution: Literal["III", "IV", "V", "VI", "VII", "VIII"] | None = Field(
        None, description="of a fractional factorial, or of the corners of a central composite"
    )
    generators: str | None = Field(
        None,
        description='generators of a fractional factorial in place of a resolution, like "a b c abc"',
    )
    face: Literal["faced", "inscribed", "circumscribed"] | None = Field(
        None, description="position of the star points of a central composite"
    )
    file: str | None = Field(
        None, description="CSV file of your own runs, in the folder of the study file"
    )
    held_out: int = quantity_field(
        "number of further designs that judge the fits",
        "",
        minimum=1,
        maximum=1000,
        default=StudyPlan.held_out,
    )
    seed: int = quantity_field(
        "seed of all random draws", "", minimum=0, maximum=2**31 - 1, default=StudyPlan.seed
    )
    accuracy: float = quantity_field(
        "relative accuracy of each design's axial compliance",
        "",
        minimum=COMPLIANCE_ACCURACY.least,
        maximum=COMPLIANCE_ACCURACY.most,
        default=StudyPlan.accuracy,
    )
    stresses: StrictBool = Field(
        StudyPlan.stresses,
        description="whether to compute the largest stress concentration factor at the fillets too",
    )
    slopes: StrictBool = Field(
        StudyPlan.slopes,
        description="whether the runs have slopes of their responses, which are fitted as well",
    )
    form: str | None = Field(
        None,
        description="form of all equations, like Gaussian process; by default the best of each",
    )
    mesh: Literal["new", "moved"] = Field(
        StudyPlan.mesh,
        description="whether designs are meshed anew, or share meshes that are moved, with some anchors",
    )
    constraints: tuple[Any, ...] = Field(
        default_factory=tuple,
        description='comparisons that every design fulfills, like "web_thickness >= 0.25 * pin_diameter"',
    )
    factors: dict[str, Any] = Field(
        default_factory=dict, description="section [study.factors] of levels and ranges"
    )
    relations: dict[str, Any] = Field(
        default_factory=dict,
        description="section [study.relations] of dimensions that follow from others",
    )
    throw: str | None = Field(
        None, description="which of several throws varies; by default the one at the free end"
    )

    @classmethod
    def from_text(cls, values: Mapping[str, object], section: str | None = None) -> Self:
        """Build it from text with units; the number of runs may be `WITH_SLOPES`."""
        runs = values.get("runs")
        if isinstance(runs, str):
            if runs != WITH_SLOPES:
                raise InputError(
                    f'study.runs: given {runs!r}; allowed is a number of runs, like 40, or "{WITH_SLOPES}".'
                )
            rest = {name: value for name, value in values.items() if name != "runs"}
            values = {"slopes": True} | rest
        return super().from_text(values, section)

    @field_validator("design", mode="before")
    @classmethod
    def _in_small_letters(cls, word: object) -> object:
        return word.casefold() if isinstance(word, str) else word

    @model_validator(mode="after")
    def _fits_the_design(self) -> Self:
        for option, kinds in TAKERS.items():
            value = getattr(self, option)
            if value is not None and self.design not in kinds:
                raise InputError(
                    f"study.{option}: given {value!r} with the design {self.design!r}; it is "
                    f"allowed with {' and '.join(kinds)} only."
                )
        for option in ("runs", "file"):
            counted = option == "runs" and self.slopes  # by `runs_with_slopes`
            if getattr(self, option) is None and self.design in TAKERS[option] and not counted:
                raise InputError(
                    f"study.{option}: missing; the design {self.design!r} needs the "
                    f"{type(self).model_fields[option].description}."
                )
        if self.resolution is not None and self.generators is not None:
            raise InputError(
                "study.generators: given together with study.resolution; allowed is one of the two, because "
                "generators fix the resolution."
            )
        return self


RANGE_KEYS = ("from", "to", "levels", "spacing")
RESOLUTIONS = {roman: number for number, roman in ROMAN.items()}


def study_plan(
    content: TomlFile, throws: Throws, default: str, material: Material
) -> StudyPlan | None:
    """Read the plan of a study; None if the file has no section [study].

    Parameters
    ----------
    throws : mapping
        Of the same file, by name.
    default : str
        Name of the throw that varies where the section names none.
    """
    values = content.sections.get("study")
    if values is None:
        return None
    section = StudySection.from_text(values)
    throw = with_dimensions(throw_of_name(throws, section.throw, "study.throw", default))
    fields = throw_fields(throw)

    def is_range(path: str, part_table: Mapping[str, Any]) -> bool:
        part = any(known.startswith(f"{path}.") for known in fields)
        return not part_table or (not part and bool(set(part_table) & set(RANGE_KEYS)))

    paths = _paths(section.factors, is_range)
    factors, rows = tuple(_factor(path, text, fields, throw) for path, text in paths), None
    if section.file is not None:
        factors, rows = read_design(content.files.named("study.file", section.file), factors, throw)
    number = section.runs
    if number is None and section.design in SPACE_FILLING:
        number = runs_with_slopes(factors)
    return StudyPlan(
        throw=throw,
        factors=factors,
        design=DesignChoice(
            kind=section.design,
            runs=number,
            resolution=RESOLUTIONS[section.resolution] if section.resolution else None,
            generators=section.generators,
            face=section.face,
            rows=rows,
        ),
        relations=dict(_paths(section.relations)),
        constraints=section.constraints,
        held_out=section.held_out,
        seed=section.seed,
        material=material,
        accuracy=section.accuracy,
        stresses=section.stresses,
        slopes=section.slopes,
        form=None if section.form is None else form_named(section.form, "study.form").name,
        mesh=section.mesh,
    )


def _paths(
    table: Mapping[str, Any],
    ends_at: Callable[[str, Mapping[str, Any]], bool] | None = None,
    prefix: str = "",
) -> Iterator[tuple[str, Any]]:
    """Separate entries of tables of parts, such as [study.factors.counterweight]."""
    for name, content in table.items():
        path = prefix + name
        if isinstance(content, dict) and not (ends_at and ends_at(path, content)):
            yield from _paths(content, ends_at, f"{path}.")
        else:
            yield path, content


def _factor(
    path: str, stated: object, fields: Mapping[str, ThrowField], throw: CrankThrow
) -> Factor:
    name, field = f"study.factors.{path}", fields.get(path)
    if field is not None and field.choices:
        if not isinstance(stated, list) or not all(isinstance(label, str) for label in stated):
            raise InputError(
                f"{name}: given {stated!r}; allowed is a list of {', '.join(field.choices)}."
            )
        return Factor.of_labels(path, stated)
    settings: list[object] = []
    if isinstance(stated, dict):
        settings = [part for key, part in stated.items() if key != "spacing"]
    elif isinstance(stated, list):
        settings = stated
    if field is None and any(isinstance(setting, str) for setting in settings):
        # A name that relations use is a pure number, so this is meant as a field.
        raise InputError(f"{name}: unknown throw dimension; {unknown_field(path, fields, throw)}.")
    unit = "" if field is None else field.unit
    if isinstance(stated, dict):
        return _range(path, stated, unit)
    if not isinstance(stated, list):
        raise InputError(
            f'{name}: given {stated!r}; allowed is a list of levels, like ["270 mm", "300 mm", '
            '"330 mm"], or a range, like { from = "270 mm", to = "330 mm" }.'
        )
    levels = [parse_quantity(text, unit, f"{name}[{place}]") for place, text in enumerate(stated)]
    return Factor.of_levels(path, unit, levels)


def _range(path: str, table: Mapping[str, Any], unit: str) -> Factor:
    name = f"study.factors.{path}"
    for key in table:
        if key not in RANGE_KEYS:
            raise InputError(f"{name}.{key}: unknown field; allowed are {', '.join(RANGE_KEYS)}.")
    for key in ("from", "to"):
        if key not in table:
            raise InputError(f"{name}.{key}: missing; a range needs both from and to.")
    low = parse_quantity(table["from"], unit, f"{name}.from")
    high = parse_quantity(table["to"], unit, f"{name}.to")
    if "levels" in table:
        return Factor.spread(path, unit, low, high, table["levels"], table.get("spacing", "even"))
    if "spacing" in table:
        raise InputError(
            f"{name}.spacing: given without levels; allowed beside it is a number of levels, which it "
            "spreads over the range."
        )
    return Factor(path, unit, low, high)
