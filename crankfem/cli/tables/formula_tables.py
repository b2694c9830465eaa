"""The tables of `crankfem formulas`: one throw, all engines, and the published table."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table as RichTable

from crankbase.tables.table import SI, Column, OutputUnit, OutputUnits, Table
from crankbase.units.units import significant
from crankfem.analyses.throw.formula_records import (
    EngineSpread,
    FormulaSpread,
    Ratio,
    formula_spreads,
)
from crankfem.cli import console
from crankfem.cli.angle_and_speed import angle_text
from crankfem.cli.console import print_line, print_table
from regression.formulas.published import AXIAL_FORMULAS
from regression.formulas.published_table import (
    FINITE_ELEMENTS,
    FINITE_ELEMENTS_DOUBT,
    PublishedValue,
)

# What may stand behind a number.
MARKS = ("*", "?")
# The row of finite elements among those of formulas.
_ELEMENTS: dict[str, Any] = {"name": "finite elements", "valid": None, "remarks": ()}
_LAW = _ELEMENTS | {"name": "the law"}


def _print_title(text: str) -> None:
    console.output.print(text, style="bold", soft_wrap=True, highlight=False)


def _given(constants: Mapping[str, float] | None) -> str:
    """Name the constants that were given."""
    return "".join(f", {name} = {value:g}" for name, value in (constants or {}).items())


def print_one_throw(
    records: dict[str, Any],
    gamma_deg: float,
    constants: Mapping[str, float] | None = None,
    units: OutputUnits = SI,
) -> None:
    """Print the formulas for one throw, with finite elements if they are among the records."""
    fe = records.get("fe")
    for kind, support in (("axial", f"neighbors at {gamma_deg:g} deg"), ("torsional", "pinned")):
        angle = f", gamma = {angle_text(gamma_deg)}{_given(constants)}" if kind == "axial" else ""
        beside = "" if fe is None else f" (finite elements: {support})"
        left_out = records["left_out"] if kind == "axial" else []
        _print_kind(
            f"{kind.capitalize()} compliance{angle}{beside}",
            records[kind],
            left_out,
            None if fe is None else fe[kind],
            (records.get("law") or {}).get(f"{kind}_compliance"),
            units,
        )
    if fe is not None and fe["angle_law"] is not None:
        law, axial = fe["angle_law"], units.of("1e-9 m/N")
        print_line(
            "Finite elements over the angle: e(gamma) = e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma/2)) "
            f"with e_0 = {axial.with_name(law['e_0'])}, e_180 = {axial.with_name(law['e_180'])}, "
            f"rho = {law['rho']:.3g}."
        )


def _print_kind(
    title: str,
    records: list[dict[str, Any]],
    left_out: list[dict[str, Any]],
    fe: float | None,
    law: dict[str, Any] | None,
    units: OutputUnits,
) -> None:
    texts = [text for record in records for text in record["remarks"]]
    numbers = {text: str(place) for place, text in enumerate(dict.fromkeys(texts), start=1)}
    unit = units.of(f"1e-9 {records[0]['unit'] if records else 'm/N'}")

    def remarks(record: dict[str, Any]) -> str:
        return ", ".join(sorted((numbers[text] for text in record["remarks"]), key=int))

    applies = {True: "yes", False: "no", None: ""}
    elements = [] if fe is None else [_ELEMENTS | {"value": fe}]
    by_law = [] if law is None else [_LAW | {"value": law["value"]}]
    ratio = [(Column("ratio to FE"), lambda record: f"{record['value'] / fe:.2f}")] if fe else []
    # As a line of its own, because a table breaks its title at its own width.
    _print_title(title)
    print_table(
        Table.of_records(
            "",
            [*elements, *by_law, *records],
            (Column("formula", words=True), "name"),
            (Column(f"value [{unit.name}]"), lambda record: _four_digits(record["value"], unit)),
            *ratio,
            (Column("applies", words=True), lambda record: applies[record["valid"]]),
            (Column("remarks", words=True), remarks),
        )
    )
    for text, place in numbers.items():
        print_line(units.text(f"  {place}. {text}"))
    for record in left_out:
        print_line(units.text(f"  Left out: {record['reason']}."))
    if law is not None:
        low, high = (unit.with_name(law[end]) for end in ("lower", "upper"))
        beside = "neighbors" in law["support"]
        softer = ", and omits the bending of sections between neighbors" if beside else ""
        print_line(
            "  The law, fitted to finite elements with rigid end sections, has a band of "
            f"{low} to {high} (95 of 100 throws are in theirs){softer}."
        )
    inside = [record["value"] / fe for record in records if record["valid"]] if fe else []
    if len(inside) > 1:
        print_line(
            f"  The {len(inside)} formulas that apply give {min(inside):.2f} to {max(inside):.2f} times the "
            "finite-element value."
        )


def print_spread(
    spreads: Sequence[EngineSpread],
    gamma_deg: float,
    variant: str,
    constants: Mapping[str, float] | None = None,
    units: OutputUnits = SI,
) -> None:
    """Print formula / finite elements of all engines, one row for each."""
    for kind, si_unit, head in (
        ("axial", "m/N", f"gamma = {angle_text(gamma_deg)}, {variant} formulas{_given(constants)}"),
        ("torsional", "rad/(N m)", "pinned"),
    ):
        unit = units.of(f"1e-9 {si_unit}")
        names = list(dict.fromkeys(name for spread in spreads for name in spread.ratios[kind]))
        if not names:
            continue
        _print_title(
            f"{kind.capitalize()} compliance: formula / finite elements, {head} (FE in {unit.name})"
        )
        table = _wide_table(["engine", "s/R", "FE", *map(_short, names)])
        rows = [
            [
                spread.engine,
                f"{spread.overlap:.2f}",
                _compliance(spread.fe[kind], unit),
                *(_ratio(spread.ratios[kind].get(name)) for name in names),
            ]
            for spread in spreads
        ]
        summary = formula_spreads(spreads, kind)
        for word in ("least", "mean", "greatest"):
            rows.append([word, "", "", *(_summary(summary.get(name), word) for name in names)])
        _add_rows(table, rows, section=len(spreads))
        console.print_drawn(table)
    print_line(
        "* outside the range where the formula has a meaning. s/R: overlap of main journal and crankpin "
        "divided by the crank radius. Mean: geometric."
    )
    print_line(_legend())


def print_published(values: Sequence[PublishedValue]) -> None:
    """Print the survey's table in its own units, repaired values marked, with remarks on doubtful ones."""
    names = [
        name for name in dict.fromkeys(value.formula for value in values) if name != FINITE_ELEMENTS
    ]
    _print_title("Published axial compliance of one throw [1e-9 m/N]")
    table = _wide_table(["engine", *map(_short, names)])
    cells = {(value.engine, value.formula): value for value in values}
    rows = [
        [engine, *(_published(cells.get((engine, name))) for name in names)]
        for engine in dict.fromkeys(value.engine for value in values)
    ]
    _add_rows(table, rows)
    console.print_drawn(table)
    print_line("* power of ten repaired; printed are:")
    for value in values:
        if value.mark == "*" and value.repaired is not None and value.formula != FINITE_ELEMENTS:
            print_line(
                f"    {value.engine}, {value.formula}: {value.digits}, read as {value.repaired * 1e9:.6g}"
            )
    print_line("? as printed, doubtful:")
    for value in values:
        if value.mark == "?" and value.exponent_factor is not None:
            print_line(f"    {value.engine}, {value.formula}: {value.doubt}")
    print_line("    Guglielmotti-Macchiotta: exponents of this column lost one by one")
    print_line(FINITE_ELEMENTS_DOUBT)
    print_line(
        "The paper gives no dimensions, and no dimensions make all columns agree: TsN, D2, And, Dor and "
        "Sko go with one web thickness, D1, Gor and Sto with a thicker one."
    )
    print_line(_legend())


def _wide_table(columns: Sequence[str]) -> RichTable:
    """Return a table without lines, so that a dozen columns fit into 80 characters."""
    table = RichTable(header_style="bold", box=None, padding=(0, 0, 0, 1), pad_edge=False)
    for place, column in enumerate(columns):
        table.add_column(
            column, justify="left" if place == 0 else "right", no_wrap=place == 0, overflow="fold"
        )
    return table


def _four_digits(value: float, unit: OutputUnit) -> str:
    """Write a value with four digits, zeros at the end among them."""
    return unit.number(value) if unit.wished else significant(value / unit.size)


def _compliance(value: float, unit: OutputUnit) -> str:
    """Write a compliance with three digits, without a power of ten."""
    scaled = value / unit.size
    return f"{scaled:.0f}" if scaled >= 100.0 else f"{scaled:#.3g}"


def _ratio(ratio: Ratio | None) -> str:
    if ratio is None:
        return "-"
    return f"{ratio.value:.2f}{'' if ratio.valid else '*'}"


def _summary(spread: FormulaSpread | None, word: str) -> str:
    return "-" if spread is None else f"{getattr(spread, word):.2f}"


def _published(value: PublishedValue | None) -> str:
    if value is None:
        return "-"
    if value.repaired is None:
        return f"{value.digits}{value.mark}"
    return f"{value.repaired * 1e9:#.4g}{value.mark}"


def _add_rows(table: RichTable, rows: Sequence[Sequence[str]], section: int | None = None) -> None:
    """Add rows so that digits are aligned in columns with marks in some cells."""
    marked = [any(cell.endswith(MARKS) for cell in column) for column in zip(*rows, strict=True)]
    for place, row in enumerate(rows):
        if place == section:
            table.add_section()
        table.add_row(
            *(
                cell + " " if mark and not cell.endswith(MARKS) else cell
                for cell, mark in zip(row, marked, strict=True)
            )
        )


def _short(name: str) -> str:
    """Return the head of a formula's column; torsional ones keep their names."""
    return AXIAL_FORMULAS[name].short if name in AXIAL_FORMULAS else name


def _legend() -> str:
    return f"{', '.join(f'{one.short} {one.name}' for one in AXIAL_FORMULAS.values())}."
