"""Read results from elsewhere into a study: a table of earlier or measured values, another store."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fem.responses import RESPONSES
from geometry.errors import InputError
from geometry.quantity import parse_quantity
from geometry.text_limits import LARGEST_TABLE_FILE, check_file_size
from geometry.throw import CrankThrow
from regression.plans.factors import Factor, changed_record, field_value
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.plans.relations import calculate
from regression.plans.variants import Variants
from regression.records import HELD_OUT, MEASURED, RUN, ExtraRow, Outcome
from regression.runs.store import ResultStore
from regression.runs.study_table import DONE, throw_dimensions, throw_outlines
from regression.throw_values import same, show

ROLES = (RUN, HELD_OUT, MEASURED)
# Columns that say something of a row as a whole.
ABOUT = ("role", "source", "status", "model_version")
# Responses that are above zero in every throw; influence coefficients and reactions have a sign.
POSITIVE = tuple(
    name for name in RESPONSES if not name.startswith(("influence_coefficient", "axial_reaction"))
)
# Columns of an exported table that an import has no use for.
IGNORED = ("seconds", "unknowns", "reason")
# A dimension and a ratio that both were measured agree if they do to this share: they were rounded.
AGREE = 0.005
HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")


@dataclass(frozen=True)
class _Column:
    """One column of the table: its header, what it holds, and how its cells are read."""

    header: str
    kind: str
    name: str
    read: Callable[[str, str], Any]


def read_rows(path: Path, plan: StudyPlan) -> tuple[ExtraRow, ...]:
    """Read a CSV table of results for a study.

    Parameters
    ----------
    path : path
        Header: dimensions of the throw and factors with their units ("web_width [mm]"), responses
        ("axial_compliance_pinned [m/N]"), their estimated relative errors
        ("axial_compliance_pinned error"), and optionally role ("run", "held out" or "measured", the
        default), source, status and model_version. Dimensions that have no column are the study's.
    plan : StudyPlan

    Raises
    ------
    InputError
        In one sentence with line and column, if something cannot be used.
    """
    lines = _read_lines(path)
    if not lines or not any(cell.strip() for cell in lines[0]):
        raise InputError(f"{path.name}, line 1: empty; the first line must name the columns.")
    listed = _columns(path.name, lines[0], plan)
    reader = _RowReader(path.name, plan)
    rows = []
    for number, cells in enumerate(lines[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(listed):
            raise InputError(
                f"{path.name}, line {number}: given {len(cells)} cells; allowed are {len(listed)}, one "
                "for each column, separated by commas, with points in decimal numbers."
            )
        row = reader.row(number, listed, cells)
        if row is not None:
            rows.append(row)
    if not rows:
        raise InputError(f"{path.name}: given no line with results; allowed is one or more.")
    return tuple(rows)


def _read_lines(path: Path) -> list[list[str]]:
    if path.suffix == ".parquet":
        raise InputError(
            f"{path.name}: is a Parquet table; allowed are a CSV table or another store, because Parquet "
            "is written for other programs only."
        )
    check_file_size(path, LARGEST_TABLE_FILE, "a table of results")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = file.read()
    except UnicodeDecodeError:
        text = "\0"
    except OSError as error:
        raise InputError(f"{path.name}: cannot be read ({error.strerror}).") from None
    if "\0" in text:
        raise InputError(
            f"{path.name}: is no text in UTF-8; allowed is a CSV table, saved as UTF-8 text, or another "
            "store."
        )
    try:
        lines = list(csv.reader(text.splitlines(keepends=True), strict=True))
    except csv.Error as error:
        raise InputError(
            f"{path.name}: is no CSV table ({error}); allowed are a header and lines of cells separated "
            "by commas."
        ) from None
    for mark, name in ((";", "semicolons"), ("\t", "tabs")):
        if lines and any(mark in cell for cell in lines[0]):
            raise InputError(
                f"{path.name}, line 1: given cells separated by {name}; allowed are commas between "
                "columns, and points in decimal numbers."
            )
    return lines


def _columns(file: str, headers: list[str], plan: StudyPlan) -> list[_Column]:
    found: list[_Column] = []
    for number, header in enumerate(headers, start=1):
        where = f"{file}, line 1, column {number} ({header.strip()!r})"
        column = _column(header, where, plan)
        if column.kind != "ignored" and any(
            (one.kind, one.name) == (column.kind, column.name) for one in found
        ):
            raise InputError(f"{where}: given twice; allowed is each column once.")
        found.append(column)
    if not any(column.kind == "response" for column in found):
        raise InputError(
            f"{file}, line 1: given no response; allowed are {', '.join(RESPONSES)}, each with its "
            "unit, like axial_compliance_pinned [m/N]."
        )
    return found


def _column(header: str, where: str, plan: StudyPlan) -> _Column:
    matched = HEADER.fullmatch(header)
    if matched is None or not matched[1]:
        raise InputError(f"{where}: allowed is a name with its unit, like web_width [mm].")
    name, unit = matched[1], matched[2]
    header = header.strip()
    if name in IGNORED:
        return _Column(header, "ignored", name, _text)
    if name in ABOUT:
        return _Column(header, "about", name, _text)
    if name.endswith(" error") and name.removesuffix(" error") in RESPONSES:
        return _Column(header, "error", name.removesuffix(" error"), _reader(where, "", unit))
    if name in RESPONSES:
        return _Column(header, "response", name, _response_reader(where, name, unit))
    factor = next((factor for factor in plan.factors if factor.name == name), None)
    field = plan.variants().fields.get(name)
    if factor is not None and field is None:
        return _Column(header, "factor", name, _reader(where, factor.unit, unit))
    if field is None:
        raise InputError(
            f"{where}: unknown; allowed are {', '.join(ABOUT)}, fields of the throw, the study's factors "
            f"({', '.join(plan.names)}) and responses ({', '.join(RESPONSES)})."
        )
    if field.choices:
        return _Column(header, "field", name, _choice(field.choices))
    return _Column(header, "field", name, _reader(where, field.unit, unit))


def _text(cell: str, _: str) -> str:
    return cell


def _choice(choices: tuple[str, ...]) -> Callable[[str, str], str]:
    def read(cell: str, where: str) -> str:
        if cell not in choices:
            raise InputError(f"{where}: given {cell!r}; allowed are {', '.join(choices)}.")
        return cell

    return read


def _reader(where: str, unit: str, given: str | None) -> Callable[[str, str], float]:
    """Make what reads the numbers of a column in a given unit."""
    if (given or "") == unit:
        return _number
    if given is None:
        raise InputError(f"{where}: given without a unit; write it in brackets, like [{unit}].")
    if not unit:
        raise InputError(f"{where}: given in {given}; allowed is a plain number without a unit.")
    parse_quantity(f"1 {given}", unit, where)  # refuses a unit of another kind

    def read(cell: str, place: str) -> float:
        _number(cell, place)
        return parse_quantity(f"{cell} {given}", unit, place)

    return read


def _response_reader(where: str, name: str, given: str | None) -> Callable[[str, str], float]:
    """Make what reads a response; most are above zero by nature."""
    read = _reader(where, RESPONSES[name].unit, given)

    def read_positive(cell: str, place: str) -> float:
        value = read(cell, place)
        if value <= 0.0:
            raise InputError(
                f"{place}: given {cell!r}; allowed is a number above zero, as every throw has it."
            )
        return value

    return read_positive if name in POSITIVE else read


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{where}: given {cell!r}; allowed is a finite number, like 68 or 1.5e-9, with a point for "
            "decimals, because its unit stands in the header."
        )
    return value


class _RowReader:
    """Makes rows of a study from the cells of a table."""

    def __init__(self, file: str, plan: StudyPlan) -> None:
        self._file, self._plan = file, plan
        self._variants = plan.variants()
        self._needed = tuple(n for n in RESPONSES if plan.stresses or n != "fillet_stress_factor")

    def row(self, number: int, columns: list[_Column], cells: list[str]) -> ExtraRow | None:
        """Read one line; None if it tells of a design without a result."""
        line = f"{self._file}, line {number}"
        given: dict[str, dict[str, Any]] = {
            kind: {} for kind in ("about", "ignored", "field", "factor", "response", "error")
        }
        headers = {}
        for column, text in zip(columns, cells, strict=True):
            cell = text.strip()
            if cell:
                where = f"{line}, column {column.header}"
                given[column.kind][column.name] = column.read(cell, where)
                headers[column.name] = where
        about = given["about"]
        if about.get("status", DONE) != DONE:
            return None
        role = about.get("role", MEASURED)
        if role not in ROLES:
            raise InputError(f"{headers['role']}: given {role!r}; allowed are {', '.join(ROLES)}.")
        if not given["response"]:
            raise InputError(f"{line}: given no response; allowed is one or more.")
        values = self._values(given["field"] | given["factor"])
        if role == MEASURED:
            self._check_ratios(given, headers)
            throw = self._measured_throw(line, values, given["field"])
        else:
            throw = self._computed_throw(line, values, given, headers)
        # Of its parts, what the line itself says; the rest is as the study has it.
        parts = {
            name: value
            for name, value in given["field"].items()
            if "." in name and role == MEASURED
        }
        words = {name: value for name, value in parts.items() if isinstance(value, str)}
        return ExtraRow(
            role=role,
            dimensions=throw_dimensions(throw)
            | {name: float(value) for name, value in parts.items() if name not in words},
            outlines=throw_outlines(throw) | words,
            values=values,
            responses=given["response"],
            errors=given["error"],
            source=about.get("source", line),
        )

    def _values(self, given: Mapping[str, Any]) -> tuple[float, ...] | None:
        """Values of the study's factors; None unless all are given, and every choice is one of its own."""
        if not all(name in given for name in self._plan.names):
            return None
        if any(f.labels and given[f.name] not in f.labels for f in self._plan.factors):
            return None  # a choice that the study does not have
        return tuple(_factor_value(factor, given[factor.name]) for factor in self._plan.factors)

    def _measured_throw(
        self, line: str, values: tuple[float, ...] | None, fields: Mapping[str, Any]
    ) -> dict[str, Any]:
        """The study's throw, with the dimensions that the line gives and what follows from them."""
        base: Mapping[str, Any] = self._plan.throw.model_dump(mode="json")
        if values is not None:
            base = self._variants_of(fields).at(np.array([values]))[0].throw or base
        try:
            return CrankThrow(**changed_record(base, fields)).model_dump(mode="json")
        except InputError as error:
            raise InputError(f"{line}: {error}") from None

    def _variants_of(self, fields: Mapping[str, Any]) -> Variants:
        """What makes throws if the line's dimensions take the place of the study's."""
        return replace(self._variants, record=changed_record(self._variants.record, fields))

    def _check_ratios(
        self, given: Mapping[str, Mapping[str, Any]], headers: Mapping[str, str]
    ) -> None:
        """Refuse a ratio beside a dimension that follows from it and has another value."""
        record = self._variants_of(given["field"]).record
        for path, relation in self._variants.relations.items():
            ratios = [name for name in relation.names if name not in self._variants.fields]
            if not ratios or path not in given["field"]:
                continue
            known: dict[str, Any] = {
                name: given["factor"].get(name)
                if name in ratios
                else given["field"].get(name, field_value(record, name))
                for name in relation.names
            }
            if any(value is None for value in known.values()):
                continue
            values = {name: np.array(float(value)) for name, value in known.items()}
            units = self._variants.units
            expected = float(calculate(relation, values, units, units[path]))
            if not abs(given["field"][path] - expected) <= AGREE * abs(expected):
                listed = ", ".join(f"{name} = {known[name]:g}" for name in ratios)
                raise InputError(
                    f"{headers[path]}: given {show(path, given['field'][path])} beside {listed}; "
                    f"allowed is {show(path, expected)}, which follows from it, or one of the two alone."
                )

    def _computed_throw(
        self,
        line: str,
        values: tuple[float, ...] | None,
        given: Mapping[str, Mapping[str, Any]],
        headers: Mapping[str, str],
    ) -> dict[str, Any]:
        """The throw that the study makes of the line's factors; the rest must agree with it."""
        for factor in self._plan.factors:
            self._check_range(factor, given, headers)
        if values is None:
            missing = [
                n for n in self._plan.names if n not in {**given["field"], **given["factor"]}
            ]
            raise InputError(
                f"{line}: given no {', '.join(missing)}; a line that is fitted or held out must have all "
                f"factors of the study ({', '.join(self._plan.names)})."
            )
        lacking = [name for name in self._needed if name not in given["response"]]
        if lacking:
            raise InputError(
                f"{line}: given no {', '.join(lacking)}; a line that is fitted or held out must have all "
                "responses of the study, because its equations share their designs; others are "
                f"'{MEASURED}'."
            )
        version = given["about"].get("model_version", str(MODEL_VERSION))
        if version != str(MODEL_VERSION):
            raise InputError(
                f"{headers['model_version']}: given {version}; allowed is {MODEL_VERSION}, because "
                "results of different models must not be mixed."
            )
        variant = self._variants.at(np.array([values]))[0]
        if variant.throw is None:
            raise InputError(f"{line}: no design of this study, because {variant.reason}.")
        for name, value in given["field"].items():
            self._check_field(headers[name], name, value, variant.throw)
        return variant.throw

    def _check_range(
        self, factor: Factor, given: Mapping[str, Mapping[str, Any]], headers: Mapping[str, str]
    ) -> None:
        value = given["field"].get(factor.name, given["factor"].get(factor.name))
        if value is None or _within(factor, value):
            return
        shown = value if factor.labels else factor.show(value)
        allowed = ", ".join(factor.labels) or (
            f"{factor.show(factor.lowest)} to {factor.show(factor.highest)}"
        )
        raise InputError(
            f"{headers[factor.name]}: given {shown}; allowed is {allowed}, the study's own range, in a "
            f"line that is fitted or held out, or the role '{MEASURED}'."
        )

    def _check_field(self, where: str, name: str, value: Any, throw: Mapping[str, Any]) -> None:
        expected = field_value(throw, name)
        if isinstance(value, str):
            agrees, shown, allowed = value == expected, value, str(expected)
        else:
            number = 0.0 if expected is None else float(expected)
            agrees = same(value, number)
            shown, allowed = show(name, value), show(name, number)
        if not agrees:
            raise InputError(
                f"{where}: given {shown}; allowed is {allowed}, as the study has it at these factors, "
                f"or the role '{MEASURED}'."
            )


def _within(factor: Factor, given: Any) -> bool:
    """Whether a value of a factor lies in the study's range; rounding must not put it outside."""
    if factor.labels:
        return given in factor.labels
    inside = factor.lowest <= given <= factor.highest
    return inside or same(given, factor.lowest) or same(given, factor.highest)


def _factor_value(factor: Factor, given: Any) -> float:
    return float(factor.labels.index(given)) if factor.labels else float(given)


@dataclass(frozen=True)
class StoreResults:
    """What another store has for a study.

    Attributes
    ----------
    finished : tuple of Outcome
        Results of designs that are exactly the study's own.
    rows : tuple of ExtraRow
        Results of other designs of the same throw and material, at other values of the factors within
        the study's ranges.
    left_out : int
        Results that do not belong to the study.
    """

    finished: tuple[Outcome, ...]
    rows: tuple[ExtraRow, ...]
    left_out: int


def read_store(store: ResultStore, plan: StudyPlan, keys: Iterable[str]) -> StoreResults:
    """Find what another store has for a study.

    Parameters
    ----------
    store : ResultStore
    plan : StudyPlan
    keys : iterable of str
        Of the study's designs.

    Raises
    ------
    InputError
        If it has nothing.
    """
    own = set(keys)
    finished, rows, left_out = [], list(store.extra_rows(plan.key)), 0
    for role, outcome, version in store.results():
        if outcome.key in own:
            finished.append(outcome)
            continue
        row = _row_of(outcome, role, plan, store.path.name) if version == MODEL_VERSION else None
        if row is None:
            left_out += 1
        else:
            rows.append(row)
    if not finished and not rows:
        raise InputError(
            f"import: given {str(store.path)!r}, in which {left_out} results are of another throw, "
            f"material, accuracy or model version; allowed is a store with results of this study."
        )
    return StoreResults(tuple(finished), tuple(rows), left_out)


def _row_of(outcome: Outcome, role: str, plan: StudyPlan, source: str) -> ExtraRow | None:
    """Make a row of another study's result, if the study could have such a design."""
    inputs: Mapping[str, Any] = outcome.inputs
    settings = {
        "material": plan.material.model_dump(),
        "accuracy": plan.accuracy,
        "stresses": plan.stresses,
    }
    if outcome.responses is None or any(inputs.get(n) != value for n, value in settings.items()):
        return None
    try:
        given = {name: field_value(inputs["throw"], name) for name in plan.names}
    except IndexError:  # a pin that the other throw does not have
        return None
    for factor in plan.factors:
        value = given[factor.name]  # None also for a ratio that only relations use
        if value is None or not _within(factor, value):
            return None
    values = tuple(_factor_value(factor, given[factor.name]) for factor in plan.factors)
    variant = plan.variants().at(np.array([values]))[0]
    if variant.throw is None or variant.throw != inputs["throw"]:
        return None
    return ExtraRow(
        role=role,
        dimensions=throw_dimensions(variant.throw),
        outlines=throw_outlines(variant.throw),
        values=values,
        responses=outcome.responses,
        errors=outcome.errors,
        source=f"{source}, design {outcome.key}",
    )
