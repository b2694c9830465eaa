"""The user's design: runs from a CSV file, one line for each, quantities with their units."""

import csv
from collections.abc import Mapping, Sequence

from crankbase.errors import InputError
from crankbase.input_file import CSV, LARGEST_TABLE_FILE, InputFile
from crankbase.units.quantity import parse_quantity
from geometry.throw import CrankThrow
from regression.plans.factors import Factor, ThrowField, throw_fields, unknown_field


def read_design(
    file: InputFile, factors: tuple[Factor, ...], throw: CrankThrow
) -> tuple[tuple[Factor, ...], tuple[tuple[float, ...], ...]]:
    """Read the runs of a CSV file, and the factors from its columns if the study names none.

    The first line names the factors. A unit stands there, as in ``web_width [mm]``, or in each cell, as
    in ``270 mm``.

    Parameters
    ----------
    file : InputFile
    factors : tuple of Factor
        Of the study; may be empty.
    throw : CrankThrow

    Returns
    -------
    factors : tuple of Factor
        Those of the study, or those of the columns with the ranges that the runs span.
    rows : tuple of tuple of float
        One run each [SI], of choices the labels' indices.

    Raises
    ------
    InputError
        If the file cannot be read or does not fit the factors; the message names the line.
    """
    given = file.path.name
    header, lines = _read_csv(file)
    names = [_column(cell)[0] for cell in header]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"study.file: {name} is twice in {given}; allowed is once.")
    wanted = {factor.name: factor for factor in factors}
    if wanted and set(names) != set(wanted):
        raise InputError(
            f"study.file: given the columns {', '.join(names)} in {given}; allowed are the factors "
            f"{', '.join(wanted)}, or no section [study.factors]."
        )
    fields = throw_fields(throw)
    columns = {}
    for place, cell in enumerate(header):
        texts = [(number, line[place].strip()) for number, line in lines]
        name, unit = _column(cell)
        if name not in fields and unit:
            raise InputError(
                f"study.file: {name} in {given} is an unknown throw dimension; "
                f"{unknown_field(name, fields, throw)}."
            )
        values, factor = _read_column(cell, texts, given, fields, wanted)
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
    delimiter = ";" if ";" in text.partition("\n")[0] else ","
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
    found = fields.get(name)
    if found is not None and found.choices:
        labels = list(dict.fromkeys(text for _, text in texts))
        factor = wanted.get(name) or Factor.of_labels(name, labels)
        for number, text in texts:
            if text not in factor.labels:
                raise InputError(
                    f"study.file: given {name} = {text!r} in line {number} of {file}; allowed are "
                    f"{', '.join(factor.labels)}."
                )
        return [float(factor.labels.index(text)) for _, text in texts], factor
    unit = "" if found is None else found.unit
    values = [
        _cell(text, unit, unit_text, f"study.file: {name} in line {number} of {file}")
        for number, text in texts
    ]
    return values, wanted.get(name) or Factor(name, unit, min(values), max(values))


def _cell(text: str, unit: str, unit_text: str, name: str) -> float:
    if unit:
        return parse_quantity(f"{text} {unit_text}" if unit_text else text, unit, name)
    try:
        number: object = float(text)
    except ValueError:
        number = text
    return parse_quantity(number, "", name)
