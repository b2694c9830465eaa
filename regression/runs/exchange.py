"""Read results from elsewhere into a study: a table of earlier or measured values, another store."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.errors import InputError, MissingLibraryError
from crankbase.exported_table import separator_of, with_points
from crankbase.input_file import LARGEST_TABLE_FILE, check_file_size
from crankbase.outputs import atomic_file
from crankbase.results import Result, result
from crankbase.sentences import kept
from crankbase.written_quantity import parse_quantity
from fem.response_table import RESPONSES
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from regression.plans.factors import Factor, field_value
from regression.plans.plan import MODEL_VERSION, StudyPlan, Variants
from regression.plans.relations import evaluate_expression
from regression.records import HELD_OUT, MEASURED, MOVED, RUN, ExtraRow, Outcome
from regression.response_kinds import is_positive_response
from regression.runs.store import ResultStore, damaged_rows_warning
from regression.runs.study_table import (
    DONE,
    PER,
    StudyTable,
    slope_name,
    slope_unit,
    throw_dimensions,
    throw_outlines,
)
from regression.throw_values import field_unit, format_value, same_dimension

# Columns that say something of a row as a whole.
ABOUT = ("role", "source", "status", "model_version")
# Columns of exported tables that an import has no use for.
MESH_COLUMNS = ("mesh_class", "mesh", "mesh_quality")
IGNORED = ("seconds", "unknowns", "reason", "design", "file", *MESH_COLUMNS)
HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")


@dataclass(frozen=True)
class ImportedColumn:
    """One column of the table: its header, what it holds, and how its cells are read."""

    header: str
    kind: str
    name: str
    read: Callable[[str, str], Any]


def read_lines(path: Path) -> list[list[str]]:
    """Cells of a CSV table, line by line; `InputError` if it cannot be read."""
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
        separator = separator_of(text.partition("\n")[0])
        lines = list(csv.reader(text.splitlines(keepends=True), strict=True, delimiter=separator))
    except csv.Error as error:
        raise InputError(
            f"{path.name}: is no CSV table ({error}); allowed are a header and lines of cells separated "
            "by commas, semicolons or tabs."
        ) from None
    return lines if separator == "," else with_points(lines)


def read_columns(file: str, headers: list[str], plan: StudyPlan) -> list[ImportedColumn]:
    """Columns of a table, by their headers; `InputError` if one is unusable."""
    columns: list[ImportedColumn] = []
    for number, header in enumerate(headers, start=1):
        where = f"{file}, line 1, column {number} ({header.strip()!r})"
        column = _column(header, where, plan)
        if column.kind != "ignored" and any(
            (earlier.kind, earlier.name) == (column.kind, column.name) for earlier in columns
        ):
            raise InputError(f"{where}: given twice; allowed is each column once.")
        columns.append(column)
    if not any(column.kind == "response" for column in columns):
        raise InputError(
            f"{file}, line 1: given no response; allowed are {', '.join(RESPONSES)}, each with its "
            "unit, like axial_compliance_pinned [m/N]."
        )
    return columns


def _column(header: str, where: str, plan: StudyPlan) -> ImportedColumn:
    matched = HEADER.fullmatch(header)
    if matched is None or not matched[1]:
        raise InputError(f"{where}: allowed is a name with its unit, like web_width [mm].")
    name, unit = matched[1], matched[2]
    header = header.strip()
    if name in IGNORED or name.partition(PER)[0] in RESPONSES.keys() - {name}:
        return ImportedColumn(header, "ignored", name, _text)
    if name in ABOUT:
        return ImportedColumn(header, "about", name, _text)
    if name.endswith(" error") and name.removesuffix(" error") in RESPONSES:
        return ImportedColumn(
            header, "error", name.removesuffix(" error"), _reader(where, "", unit)
        )
    if name in RESPONSES:
        return ImportedColumn(header, "response", name, _response_reader(where, name, unit))
    factor = next((factor for factor in plan.factors if factor.name == name), None)
    field = plan.variants().fields.get(name)
    if factor is not None and field is None:
        return ImportedColumn(header, "factor", name, _reader(where, factor.unit, unit))
    if field is None:
        raise InputError(
            f"{where}: unknown; allowed are {', '.join(ABOUT)}, fields of the throw, the study's factors "
            f"({', '.join(plan.names)}) and responses ({', '.join(RESPONSES)})."
        )
    if field.choices:
        return ImportedColumn(header, "field", name, _choice(field.choices))
    return ImportedColumn(header, "field", name, _reader(where, field.unit, unit))


def _text(cell: str, _: str) -> str:
    return cell


def _choice(choices: tuple[str, ...]) -> Callable[[str, str], str]:
    def read(cell: str, where: str) -> str:
        if cell not in choices:
            raise InputError(f"{where}: given {cell!r}; allowed are {', '.join(choices)}.")
        return cell

    return read


def _reader(where: str, unit: str, header_unit: str | None) -> Callable[[str, str], float]:
    """Make the function that reads the numbers of a column in a given unit."""
    if (header_unit or "") == unit:
        return _number
    if header_unit is None:
        raise InputError(f"{where}: given without a unit; write it in brackets, like [{unit}].")
    if not unit:
        raise InputError(
            f"{where}: given in {header_unit}; allowed is a plain number without a unit."
        )
    parse_quantity(f"1 {header_unit}", unit, where)  # refuses a unit of another kind

    def read(cell: str, place: str) -> float:
        _number(cell, place)
        return parse_quantity(f"{cell} {header_unit}", unit, place)

    return read


def _response_reader(where: str, name: str, header_unit: str | None) -> Callable[[str, str], float]:
    """Make the function that reads a response; most are above zero by nature."""
    read = _reader(where, RESPONSES[name].unit, header_unit)

    def read_positive(cell: str, place: str) -> float:
        value = read(cell, place)
        if value <= 0.0:
            raise InputError(
                f"{place}: given {cell!r}; allowed is a number above zero, as every throw has it."
            )
        return value

    return read_positive if is_positive_response(name) else read


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{where}: given {cell!r}; allowed is a finite number, like 68 or 1.5e-9, with a point for "
            "decimals, because the header gives its unit."
        )
    return value


Cell = str | float | int | None
FORMATS = (".csv", ".parquet")
ERROR = " error"


@dataclass(frozen=True)
class Column:
    """A column of a table: its name, SI unit ("" for none), and its cells."""

    name: str
    unit: str
    cells: list[Cell]

    @property
    def header(self) -> str:
        """Name and unit, as in "web_width [m]"."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def columns(table: StudyTable) -> tuple[Column, ...]:
    """List the columns of each row: role, factors, dimensions, responses, errors, reason."""
    rows = table.rows
    listed = [
        Column("role", "", [row.role for row in rows]),
        Column("status", "", [row.status for row in rows]),
        Column("source", "", [row.source or None for row in rows]),
    ]
    shown = set()
    for place, factor in enumerate(table.plan.factors):
        if factor.name in CrankThrow.model_fields:
            continue
        shown.add(factor.name)
        cells = [
            row.dimensions.get(factor.name, row.outlines.get(factor.name))
            if row.values is None
            else factor.setting(row.values[place])
            for row in rows
        ]
        listed.append(Column(factor.name, factor.unit, cells))
    parts: tuple[tuple[str, Callable[[str], str | None], str], ...] = (
        ("dimensions", field_unit, ""),
        ("outlines", field_unit, ""),
        ("responses", lambda name: RESPONSES[name].unit, ""),
        ("errors", lambda _: "", ERROR),
    )
    for part, unit, ending in parts:
        entries = [getattr(row, part) for row in rows]
        names = dict.fromkeys(name for entry in entries for name in entry if name not in shown)
        listed += [
            Column(name + ending, unit(name) or "", [entry.get(name) for entry in entries])
            for name in names
        ]
    sloped = dict.fromkeys(
        (name, over) for row in rows for name in row.slopes for over in row.slopes[name]
    )
    by_name = {factor.name: factor for factor in table.plan.factors}
    listed += [
        Column(
            slope_name(name, over),
            slope_unit(name, by_name[over]),
            [row.slopes.get(name, {}).get(over) for row in rows],
        )
        for name, over in sloped
    ]
    if any(row.mesh for row in rows):
        listed += [
            Column(name, "", [row.mesh_cells[place] for row in rows])
            for place, name in enumerate(MESH_COLUMNS)
        ]
    listed += [
        Column("seconds", "s", [None if row.source else row.seconds for row in rows]),
        Column("unknowns", "", [row.unknowns for row in rows]),
        Column("model_version", "", [None if row.source else MODEL_VERSION for row in rows]),
        Column("reason", "", [row.reason or None for row in rows]),
    ]
    return tuple(listed)


def check_export(path: Path) -> None:
    """Refuse a file that could not be written, before anything is computed for it.

    `InputError`; `MissingLibraryError` if Parquet is requested without the required package.
    """
    if path.suffix not in FORMATS:
        raise InputError(f"export: given {str(path)!r}; allowed are {' and '.join(FORMATS)} files.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"export: given {str(path)!r}; there is no folder {path.parent}.")
    if path.suffix == ".parquet":
        _parquet()


@result("file", "rows", eq=True)
class ExportedTable(Result):
    """A table of a study's rows in a file."""

    file: str
    rows: int

    def parts(self) -> Iterator[str]:
        """State what was written."""
        yield f"{self.rows} rows written to {self.file}."


def export_table(table: StudyTable, path: str | Path) -> ExportedTable:
    """Write all rows of a study, including those without a result.

    To ``.csv`` or ``.parquet``, in SI units, named in the columns' headers; in Parquet also as metadata
    of each column, the study's key as metadata of the file. Replaced when complete; errors as of
    `check_export`.
    """
    path = Path(path)
    check_export(path)
    with atomic_file(path, "table") as part:
        if path.suffix == ".csv":
            write_csv(part, columns(table))
        else:
            pyarrow, parquet = _parquet()
            listed = columns(table)
            arrays = [pyarrow.array(column.cells) for column in listed]
            fields = [
                pyarrow.field(column.header, array.type, metadata={"unit": column.unit})
                for column, array in zip(listed, arrays, strict=True)
            ]
            about = {"study": table.plan.key, "model_version": str(MODEL_VERSION)}
            schema = pyarrow.schema(fields, metadata=about)
            parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=schema), part)
    return ExportedTable(str(path), len(table.rows))


def write_csv(path: Path, listed: Sequence[Column]) -> None:
    """Write columns of one length as CSV, with a line of headers."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([column.header for column in listed])
        # Python writes a float with all digits that tell it from its neighbors.
        writer.writerows(zip(*(column.cells for column in listed), strict=True))


def _parquet() -> tuple[Any, Any]:
    try:
        import pyarrow
        import pyarrow.parquet as parquet
    except ImportError:
        raise MissingLibraryError(
            "export: given a Parquet file, but the package pyarrow is not installed; install it with: "
            "pip install 'crankfem[tables]', or write a .csv file."
        ) from None
    return pyarrow, parquet


def is_in_range(factor: Factor, setting: Any) -> bool:
    """Whether a value of a factor lies in the study's range; rounding must not put it outside."""
    if factor.labels:
        return setting in factor.labels
    inside = factor.lowest <= setting <= factor.highest
    return (
        inside or same_dimension(setting, factor.lowest) or same_dimension(setting, factor.highest)
    )


def factor_value(factor: Factor, setting: Any) -> float:
    """Return the value of a factor as in designs: for a label, its index."""
    return float(factor.labels.index(setting)) if factor.labels else float(setting)


@dataclass(frozen=True)
class StoreResults:
    """Results of another store for a study: of its own designs, and of others of the same throw and material.

    These lie within the study's ranges; `left_out` counts results that do not belong to the study.
    """

    finished: tuple[Outcome, ...]
    rows: tuple[ExtraRow, ...]
    left_out: int


def read_store(store: ResultStore, plan: StudyPlan, keys: Iterable[str]) -> StoreResults:
    """Find the results of another store for a study with these designs; `InputError` without any."""
    keys_here = set(keys)
    finished, rows, left_out = [], list(store.extra_rows(plan.key)), 0
    others = 0  # of another version of the model
    for role, outcome, version in store.results():
        if outcome.key in keys_here:
            finished.append(outcome)
            continue
        # Answers on a moved mesh are none until they are scaled.
        usable = version == MODEL_VERSION and MOVED not in outcome.inputs
        row = _row_of(outcome, role, plan, store.path.name) if usable else None
        if row is None:
            left_out += 1
            others += version != MODEL_VERSION
        else:
            rows.append(row)
    if not finished and not rows:
        damaged = f"; {damaged_rows_warning(store.damaged, store.path)}" if store.damaged else ""
        raise InputError(
            f"import: given {str(store.path)!r}, in which {left_out} results are of another throw, material, "
            f"accuracy or model version ({others} of another version than {MODEL_VERSION}, which must not be "
            f"mixed); allowed is a store with results of this study{damaged}."
        )
    return StoreResults(tuple(finished), tuple(rows), left_out)


def _row_of(outcome: Outcome, role: str, plan: StudyPlan, source: str) -> ExtraRow | None:
    """Make a row from another study's result, if the study could have such a design."""
    inputs: Mapping[str, Any] = outcome.inputs
    same = all(inputs.get(name) == value for name, value in plan.settings.items())
    if outcome.responses is None or not same:
        return None
    try:
        settings = {name: field_value(inputs["throw"], name) for name in plan.names}
    except IndexError:  # a pin that the other throw does not have
        return None
    for factor in plan.factors:
        value = settings[factor.name]  # None also for a ratio that only relations use
        if value is None or not is_in_range(factor, value):
            return None
    values = tuple(factor_value(factor, settings[factor.name]) for factor in plan.factors)
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


ROLES = (RUN, HELD_OUT, MEASURED)
# A dimension and a ratio that both were measured agree if they do to this share: they were rounded.
AGREE = 0.005


def read_rows(path: Path, plan: StudyPlan, *, alone: bool = False) -> tuple[ExtraRow, ...]:
    """Read a CSV table of results for a study.

    Parameters
    ----------
    path : path
        Header: dimensions of the throw and factors with their units ("web_width [mm]"), responses
        ("axial_compliance_pinned [m/N]"), their estimated relative errors
        ("axial_compliance_pinned error"), and optionally role ("run", "held out" or "measured", the
        default), source, status and model_version. Dimensions that have no column are the study's.
    alone : bool
        Whether equations are fitted without results computed by the study. Then lines that are fitted
        or held out need not have all responses of the study, only all the same ones.

    Raises
    ------
    InputError
        In one sentence with line and column, if something cannot be used.
    """
    lines = read_lines(path)
    if not lines or not any(cell.strip() for cell in lines[0]):
        raise InputError(f"{path.name}, line 1: empty; the first line must name the columns.")
    listed = read_columns(path.name, lines[0], plan)
    responses = tuple(column.name for column in listed if column.kind == "response")
    reader = _RowReader(path.name, plan, responses if alone else None)
    rows = []
    for number, cells in enumerate(lines[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(listed):
            raise InputError(
                f"{path.name}, line {number}: given {len(cells)} cells; allowed are {len(listed)}, one "
                "for each column, separated as those of the header."
            )
        row = reader.row(number, listed, cells)
        if row is not None:
            rows.append(row)
    if not rows:
        raise InputError(f"{path.name}: given no line with results; allowed is one or more.")
    return tuple(rows)


class _RowReader:
    """Makes rows of a study from the cells of a table."""

    def __init__(self, file: str, plan: StudyPlan, needed: tuple[str, ...] | None = None) -> None:
        self._file, self._plan = file, plan
        self._variants = plan.variants()
        every = tuple(n for n in RESPONSES if plan.stresses or n != "fillet_stress_factor")
        self._needed = every if needed is None else needed
        self._whose = "the study" if needed is None else "the table"

    def row(self, number: int, columns: list[ImportedColumn], texts: list[str]) -> ExtraRow | None:
        """Read one line; None for a design without a result."""
        line = f"{self._file}, line {number}"
        cells: dict[str, dict[str, Any]] = {
            kind: {} for kind in ("about", "ignored", "field", "factor", "response", "error")
        }
        headers = {}
        for column, text in zip(columns, texts, strict=True):
            cell = text.strip()
            if cell:
                where = f"{line}, column {column.header}"
                cells[column.kind][column.name] = column.read(cell, where)
                headers[column.name] = where
        about = cells["about"]
        if about.get("status", DONE) != DONE:
            return None
        role = about.get("role", MEASURED)
        if role not in ROLES:
            raise InputError(f"{headers['role']}: given {role!r}; allowed are {', '.join(ROLES)}.")
        if not cells["response"]:
            raise InputError(f"{line}: given no response; allowed is one or more.")
        values = self._values(cells["field"] | cells["factor"])
        if role == MEASURED:
            self._check_ratios(cells, headers)
            throw = self._measured_throw(line, values, cells["field"])
        else:
            throw = self._computed_throw(line, values, cells, headers)
        # Of its parts, what the line itself says; the rest is as the study has it.
        parts = {
            name: value
            for name, value in cells["field"].items()
            if "." in name and role == MEASURED
        }
        words = {name: value for name, value in parts.items() if isinstance(value, str)}
        return ExtraRow(
            role=role,
            dimensions=throw_dimensions(throw)
            | {name: float(value) for name, value in parts.items() if name not in words},
            outlines=throw_outlines(throw) | words,
            values=values,
            responses=cells["response"],
            errors=cells["error"],
            source=about.get("source", line),
        )

    def _values(self, cells: Mapping[str, Any]) -> tuple[float, ...] | None:
        """Values of the study's factors; None unless all are given, with known labels."""
        if not all(name in cells for name in self._plan.names):
            return None
        if any(f.labels and cells[f.name] not in f.labels for f in self._plan.factors):
            return None  # a choice that the study does not have
        return tuple(factor_value(factor, cells[factor.name]) for factor in self._plan.factors)

    def _measured_throw(
        self, line: str, values: tuple[float, ...] | None, fields: Mapping[str, Any]
    ) -> dict[str, Any]:
        """The study's throw, with the dimensions of the line and those that follow from them."""
        base: Mapping[str, Any] = self._plan.throw.model_dump(mode="json")
        if values is not None:
            base = self._variants_of(fields).at(np.array([values]))[0].throw or base
        try:
            return CrankThrow(**changed_record(base, fields)).model_dump(mode="json")
        except InputError as error:
            raise InputError(f"{line}: {error}") from None

    def _variants_of(self, fields: Mapping[str, Any]) -> Variants:
        """The function that makes throws with the line's dimensions instead of the study's."""
        return replace(self._variants, record=changed_record(self._variants.record, fields))

    def _check_ratios(
        self, cells: Mapping[str, Mapping[str, Any]], headers: Mapping[str, str]
    ) -> None:
        """Refuse a ratio together with a dimension that follows from it and has another value."""
        record = self._variants_of(cells["field"]).record
        for path, relation in self._variants.relations.items():
            ratios = [name for name in relation.names if name not in self._variants.fields]
            if not ratios or path not in cells["field"]:
                continue
            known: dict[str, Any] = {
                name: cells["factor"].get(name)
                if name in ratios
                else cells["field"].get(name, field_value(record, name))
                for name in relation.names
            }
            if any(value is None for value in known.values()):
                continue
            values = {name: np.array(float(value)) for name, value in known.items()}
            units = self._variants.units
            expected = float(evaluate_expression(relation, values, units, units[path]))
            if not abs(cells["field"][path] - expected) <= AGREE * abs(expected):
                listed = ", ".join(f"{name} = {known[name]:g}" for name in ratios)
                raise InputError(
                    f"{headers[path]}: given {format_value(path, cells['field'][path])} beside {listed}; "
                    f"allowed is {format_value(path, expected)}, which follows from it, or "
                    "one of the two alone."
                )

    def _computed_throw(
        self,
        line: str,
        values: tuple[float, ...] | None,
        cells: Mapping[str, Mapping[str, Any]],
        headers: Mapping[str, str],
    ) -> dict[str, Any]:
        """The throw of the study with the line's factors; other values must agree with it."""
        for factor in self._plan.factors:
            self._check_range(factor, cells, headers)
        if values is None:
            missing = [
                n for n in self._plan.names if n not in {**cells["field"], **cells["factor"]}
            ]
            raise InputError(
                f"{line}: given no {', '.join(missing)}; a line that is fitted or held out must have all "
                f"factors of the study ({', '.join(self._plan.names)})."
            )
        lacking = [name for name in self._needed if name not in cells["response"]]
        if lacking:
            raise InputError(
                f"{line}: given no {', '.join(lacking)}; a line that is fitted or held out must have all "
                f"responses of {self._whose}, because its equations share their designs; others are "
                f"'{MEASURED}'."
            )
        version = cells["about"].get("model_version", str(MODEL_VERSION))
        if version != str(MODEL_VERSION):
            raise InputError(
                f"{headers['model_version']}: given {version}; allowed is {MODEL_VERSION}, because "
                "results of different models must not be mixed."
            )
        variant = self._variants.at(np.array([values]))[0]
        if variant.throw is None:
            raise InputError(f"{line}: no design of this study, because {variant.reason}.")
        for name, value in cells["field"].items():
            self._check_field(headers[name], name, value, variant.throw)
        return variant.throw

    def _check_range(
        self, factor: Factor, cells: Mapping[str, Mapping[str, Any]], headers: Mapping[str, str]
    ) -> None:
        value = cells["field"].get(factor.name, cells["factor"].get(factor.name))
        if value is None or is_in_range(factor, value):
            return
        shown = value if factor.labels else kept(factor.format_value(value))
        raise InputError(
            f"{headers[factor.name]}: given {shown}; allowed is {kept(factor.range_text)}, the study's own "
            f"range, in a line that is fitted or held out, or the role '{MEASURED}'."
        )

    def _check_field(self, where: str, name: str, value: Any, throw: Mapping[str, Any]) -> None:
        expected = field_value(throw, name)
        if isinstance(value, str):
            agrees, shown, allowed = value == expected, value, str(expected)
        else:
            number = 0.0 if expected is None else float(expected)
            agrees = same_dimension(value, number)
            shown, allowed = format_value(name, value), format_value(name, number)
        if not agrees:
            raise InputError(
                f"{where}: given {shown}; allowed is {allowed}, as the study has it at these factors, "
                f"or the role '{MEASURED}'."
            )
