"""Tables of throws on the command line: compliances, stresses, formulas, reactions, checks of files."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rich.table import Table as RichTable

from crankbase.quantity import significant
from crankbase.table import SI, Column, OutputUnit, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.throw.formula_records import (
    KINDS,
    EngineFormulas,
    EngineSpread,
    Formulas,
    FormulaSpread,
    Kind,
    Ratio,
    formula_spreads,
)
from crankfem.analyses.throw.throw_record import NOT_CORRECTED, ReactionResults, ThrowResults
from crankfem.cli import console
from crankfem.cli.arguments import angle_text
from crankfem.cli.console import print_line, print_notes, print_table
from regression.formulas.axial_formulas import (
    AXIAL_FORMULAS,
    FINITE_ELEMENTS,
    FINITE_ELEMENTS_DOUBT,
    PublishedValue,
)

if TYPE_CHECKING:  # of whole engines, for which much is loaded that a throw does without
    from crankfem.analyses.file_check import Arrangement, Dimension, Shape


def print_throw(results: ThrowResults, units: OutputUnits = SI) -> None:
    """Print compliances, reactions and masses of a throw."""
    print_table(results.loaded_table(units), units)
    print_table(results.reaction_table(units), units)
    for sentence in results.sentences(units):
        print_line(sentence)
    if not results.corrected:
        print_notes([NOT_CORRECTED], units)


def print_shape(shape: "Shape", units: OutputUnits = SI, name: str = "Throw") -> None:
    """Print the quantities that follow from the dimensions."""
    length, volume = units.of("mm"), units.of("dm^3")
    pins = "one pin" if shape.pins == 1 else f"{shape.pins} pins"
    print_line(
        f"{name} with {pins}: length {length.with_name(shape.length, 5)}, overlap of journal and pin "
        f"{length.with_name(shape.overlap)}, volume {volume.with_name(shape.volume)}; "
        f"{_PARTS[shape.solved_part]}."
    )
    print_notes(shape.remarks, units)


_PARTS = {
    "quarter": "symmetric about two planes, a quarter is solved",
    "half": "symmetric about the crank plane, half of it is solved",
    "full": "without planes of symmetry, all of it is solved",
}


# What may stand behind a number.
MARKS = ("*", "?")


def _print_title(text: str) -> None:
    console.output.print(text, style="bold", soft_wrap=True, highlight=False)


def _given(constants: Mapping[str, float] | None) -> str:
    """Name the constants that were given."""
    return "".join(f", {name} = {value:g}" for name, value in (constants or {}).items())


def print_one_throw(
    formulas: Formulas,
    gamma_deg: float = 180.0,
    constants: Mapping[str, float] | None = None,
    units: OutputUnits = SI,
) -> None:
    """Print the formulas for one throw, with finite elements if they have them."""
    fe = formulas.fe
    for kind in KINDS:
        support = f"neighbors at {gamma_deg:g} deg" if kind == "axial" else "pinned"
        angle = f", gamma = {angle_text(gamma_deg)}{_given(constants)}" if kind == "axial" else ""
        beside = "" if fe is None else f" (finite elements: {support})"
        _print_title(f"{kind.capitalize()} compliance{angle}{beside}")
        _print_kind(formulas, kind, units)
    if fe is not None and (law := fe.angle_law) is not None:
        axial = units.of("1e-9 m/N")
        print_line(
            "Finite elements over the angle: e(gamma) = e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma/2)) "
            f"with e_0 = {axial.with_name(law.in_line)}, e_180 = {axial.with_name(law.opposite)}, "
            f"rho = {law.ratio:.3g}."
        )


def _print_kind(formulas: Formulas, kind: Kind, units: OutputUnits) -> None:
    values, law = formulas.of_kind(kind), formulas.by_law(kind)
    fe = None if formulas.fe is None else getattr(formulas.fe, kind)
    texts = dict.fromkeys(text for formula in values for text in formula.remarks)
    numbers = {text: place for place, text in enumerate(texts, start=1)}
    unit = units.of(f"1e-9 {values[0].unit if values else 'm/N'}")
    columns = [Column("formula", words=True), Column(f"value [{unit.name}]")]
    columns += [Column("ratio to FE")] if fe else []
    columns += [Column("applies", words=True), Column("remarks", words=True)]

    def row(name: str, value: float, applies: str = "", remarks: Sequence[str] = ()) -> list[str]:
        shown = unit.number(value) if unit.wished else significant(value / unit.size)
        ratio = [f"{value / fe:.2f}"] if fe else []
        noted = ", ".join(map(str, sorted(numbers[text] for text in remarks)))
        return [name, shown, *ratio, applies, noted]

    rows = [] if fe is None else [row("finite elements", fe)]
    rows += [] if law is None else [row("the law", law.value)]
    rows += [
        row(formula.name, formula.value, "yes" if formula.valid else "no", formula.remarks)
        for formula in values
    ]
    # Its title is a line of its own, because a table breaks its title at its own width.
    print_table(Table("", columns, rows))
    for text, place in numbers.items():
        print_line(units.text(f"  {place}. {text}"))
    for without in formulas.left_out if kind == "axial" else ():
        print_line(units.text(f"  Left out: {without.reason}."))
    if law is not None:
        low, high = (unit.with_name(end) for end in (law.lower, law.upper))
        beside = "neighbors" in law.support
        softer = ", and omits the bending of sections between neighbors" if beside else ""
        print_line(
            "  The law, fitted to finite elements with rigid end sections, has a band of "
            f"{low} to {high} (95 of 100 throws are in theirs){softer}."
        )
    inside = [formula.value / fe for formula in values if formula.valid] if fe else []
    if len(inside) > 1:
        print_line(
            f"  The {len(inside)} formulas that apply give {min(inside):.2f} to {max(inside):.2f} times the "
            "finite-element value."
        )


def print_engines(
    engines: Sequence[EngineFormulas],
    gamma_deg: float,
    variant: str,
    constants: Mapping[str, float],
    units: OutputUnits = SI,
) -> None:
    """Print the compliances of several engines by all formulas, one row for each."""
    gamma = f"gamma = {angle_text(gamma_deg)}, {variant} formulas{_given(constants)}"
    for kind in KINDS:
        unit = units.of("1e-9 m/N" if kind == "axial" else "1e-9 rad/(N m)")
        rows: list[dict[str, str]] = []
        for each in engines:
            rows.append({"engine": each.engine})
            if each.formulas.fe is not None:
                rows[-1]["FE"] = _compliance(getattr(each.formulas.fe, kind), unit)
            for value in each.formulas.of_kind(kind):
                shown = _compliance(value.value, unit)
                rows[-1][_short(value.name)] = f"{shown}{'' if value.valid else '*'}"
        names = list(dict.fromkeys(name for row in rows for name in row))
        head = gamma if kind == "axial" else "pinned"
        _print_title(f"{kind.capitalize()} compliance [{unit.name}], {head}")
        table = _wide_table(names)
        _add_rows(table, [[row.get(name, "-") for name in names] for row in rows])
        console.print_drawn(table)
    print_line("* outside the range where the formula has a meaning.")
    for each in engines:
        for without in each.formulas.left_out:
            print_line(units.text(f"Left out of {each.engine}: {without.reason}."))
    print_line(_legend())


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
                _compliance(getattr(spread.fe, kind), unit),
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


def print_reactions(results: ReactionResults, units: OutputUnits) -> None:
    """Print reactions as those of a throw by finite elements, with their bands."""
    print_table(results.table(units), units)
    kilonewtons = units.of("kN")
    for name, support in results.supports.items():
        push, band = support.reactions.left.force[2], support.band.left.force[2]
        if not support.inside:
            accuracy = "OUTSIDE the range, where no band applies"
        elif not math.isfinite(band):
            accuracy = "its band is open"
        else:
            accuracy = (
                f"within {kilonewtons.with_name(band, 3)} of {kilonewtons.with_name(push, 4)}"
            )
        print_line(f"Axial reaction {name}: {accuracy}")
    for name, reason in results.refused.items():
        print_line(units.text(f"Reactions {name}: left out; {reason}"))


FILE_KINDS = {
    "engine": "It describes a whole engine",
    "mechanism": "It describes cranks, rods and pistons, not a whole engine",
    "throw": "It describes a throw, not an engine",
    "hinge": "It describes an elastic hinge",
    "chain": "It describes a chain of inertias and springs",
}


def print_check(record: Record, units: OutputUnits = SI) -> None:
    """Print how a file is understood."""
    inputs = record["inputs"]
    assumed = sum(value.assumed for value in inputs)
    verb = "is" if assumed == 1 else "are"
    counted = f"; {assumed} of {len(inputs)} values {verb} assumed" if inputs else ""
    warnings = record["warnings"]
    warned = f"; {len(warnings)} warning{'s' if len(warnings) > 1 else ''}" if warnings else ""
    print_line(f"{record['file']}: valid {record['kind']} file{counted}{warned}.")
    for warning in warnings:
        print_line(units.text(f"Warning: {warning.rstrip('.')}."))
    print_line(f"{FILE_KINDS[record['kind']]}; use it with: {', '.join(record['commands'])}.")
    print_line(f"Sections: {', '.join(record['sections'])}.")
    if record["arrangement"] is not None:
        _print_arrangement(record["engine"], record["arrangement"], units)
    for name, throw_record in record.get("throws", {}).items():
        print_shape(throw_record["shape"], units, f"Throw {name}")
        print_line(throw_record["law"].sentence(units))
        _print_dimensions(throw_record["dimensions"], units, f"The throw {name} as understood")
    if record["shape"] is not None and "throws" not in record:
        print_shape(record["shape"], units)
        print_line(record["law"].sentence(units))
        _print_dimensions(record["dimensions"], units)
    print_notes((f"{remark.rstrip('.')}." for remark in record["remarks"]), units)
    print_table(
        Table.of_records(
            "Inputs",
            inputs,
            (Column("field", words=True), "field"),
            (Column("value", words=True), "given"),
            (Column("assumed", words=True), lambda value: "yes" if value.assumed else ""),
            (Column("source", words=True), "source"),
        )
    )


def _print_arrangement(name: str, engine: "Arrangement", units: OutputUnits) -> None:
    from crankfem.analyses.mechanism.mechanism_results import intervals_text

    length, speed = units.of("mm"), units.of("1/min")
    digits = _digits(length)
    kind = "in line" if engine.bank_angles_deg is None else "in banks"
    speeds = [
        speed.number(running, 6)
        for running in (engine.lowest_speed, engine.highest_speed, engine.rated_speed)
    ]
    print_line(
        f"{name}: {_cylinders(engine.cylinders)} {kind}, {engine.strokes}-stroke, bore x stroke "
        f"{length.number(engine.bore, digits)} x {length.number(engine.stroke, digits)} "
        f"{length.name}; runs from "
        f"{speeds[0]} to {speeds[1]} {speed.name}, rated speed {speeds[2]} {speed.name} (mean piston "
        f"speed {units.of('m/s').with_name(engine.mean_piston_speed, 3)}); firing order "
        f"{'-'.join(map(str, engine.firing_order))}, "
        f"{intervals_text(engine.firing_intervals_deg, units)}."
    )
    fired = dict(zip(engine.firing_order, engine.firing_angles_deg, strict=True))
    angles = {"crank angle": engine.crank_angles_deg}
    if engine.bank_angles_deg is not None:
        angles["bank angle"] = engine.bank_angles_deg
    angles["fires at"] = tuple(fired[number] for number in sorted(fired))
    print_table(
        Table(
            f"Cylinders [{units.of('deg').name}]",
            [Column("cylinder"), *(Column(name, "deg", 6, bare=True) for name in angles)],
            [
                [number, *map(math.radians, row)]
                for number, row in enumerate(zip(*angles.values(), strict=True), start=1)
            ],
        ),
        units,
    )


def _cylinders(count: int) -> str:
    return "1 cylinder" if count == 1 else f"{count} cylinders"


def _digits(unit: OutputUnit) -> int:
    """Digits of a given length: all of them, and five if it was converted."""
    return 5 if unit.wished else 6


def _print_dimensions(
    dimensions: "Sequence[Dimension]", units: OutputUnits, title: str = "The throw as read"
) -> None:
    print_table(
        Table.of_records(
            title,
            dimensions,
            (Column("dimension", words=True), "name"),
            (Column("symbol", words=True), "symbol"),
            (Column("", "mm", _digits(units.of("mm"))), "value"),
            (Column("meaning", words=True), "meaning"),
        ),
        units,
    )
