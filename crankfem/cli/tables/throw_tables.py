"""Tables of throws on the command line: compliances, stresses, formulas, reactions, checks of files."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from crankbase.sentences import kept
from crankbase.table import SI, Cell, Column, Main, MainWarning, OutputUnit, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.cli.arguments import angle_text
from crankfem.files.satellites import satellite_files
from regression.formulas.axial_formulas import (
    AXIAL_FORMULAS,
    FINITE_ELEMENTS,
    FINITE_ELEMENTS_DOUBT,
    PublishedValue,
)

if TYPE_CHECKING:  # of whole engines and finite elements, for which much is loaded
    from crankfem.analyses.file_check import Arrangement
    from crankfem.analyses.throw.formula_records import (
        EngineFormulas,
        EngineSpread,
        Formulas,
        Kind,
    )
    from crankfem.analyses.throw.throw_record import ReactionResults


def _notes(remarks: Iterable[str], units: OutputUnits) -> Iterator[str]:
    return (units.written(f"Note: {kept(remark)}") for remark in remarks)


_PARTS = {
    "quarter": "symmetric about two planes, a quarter is solved",
    "half": "symmetric about the crank plane, half of it is solved",
    "full": "without planes of symmetry, all of it is solved",
}


# What may stand behind a number.
MARKS = ("*", "?")


def _given(constants: Mapping[str, float] | None) -> str:
    """Name the constants that were given."""
    return "".join(f", {name} = {value:g}" for name, value in (constants or {}).items())


def one_throw_parts(
    formulas: "Formulas",
    gamma_deg: float = 180.0,
    constants: Mapping[str, float] | None = None,
    units: OutputUnits = SI,
) -> Iterator[Table | str]:
    """Return the formulas for one throw, with finite elements if they have them."""
    from crankfem.analyses.throw.formula_records import KINDS

    fe = formulas.fe
    for kind in KINDS:
        support = f"neighbors at {gamma_deg:g} deg" if kind == "axial" else "pinned"
        angle = f", gamma = {angle_text(gamma_deg)}{_given(constants)}" if kind == "axial" else ""
        beside = "" if fe is None else f" (finite elements: {support})"
        title = f"{kind.capitalize()} compliance{angle}{beside}"
        yield from _kind_parts(formulas, kind, title, units)
    if fe is not None and (law := fe.angle_law) is not None:
        axial = units.of("1e-9 m/N")
        yield (
            "Finite elements over the angle: e(gamma) = e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma/2)) "
            f"with e_0 = {axial.with_name(law.in_line)}, e_180 = {axial.with_name(law.opposite)}, "
            f"rho = {law.ratio:.3g}."
        )


def formulas_answer(formulas: "Formulas", units: OutputUnits = SI) -> Iterator[str]:
    """State the compliances by finite elements, and the range of the formulas that apply."""
    from crankfem.analyses.throw.formula_records import KINDS

    for kind, si in KINDS.items() if formulas.fe is not None else ():
        fe = getattr(formulas.fe, kind)
        inside = [formula.value / fe for formula in formulas.of_kind(kind) if formula.valid]
        beside = (
            f"; the {len(inside)} formulas that apply give {min(inside):.2f} to {max(inside):.2f} times this"
            if len(inside) > 1
            else ""
        )
        value = units.of(f"1e-9 {si}").with_name(fe)
        yield f"{kind.capitalize()} compliance by finite elements: {value}{beside}."


def _kind_parts(
    formulas: "Formulas", kind: "Kind", title: str, units: OutputUnits
) -> Iterator[Table | str]:
    values, law = formulas.of_kind(kind), formulas.by_law(kind)
    fe = None if formulas.fe is None else getattr(formulas.fe, kind)
    texts = dict.fromkeys(text for formula in values for text in formula.remarks)
    numbers = {text: place for place, text in enumerate(texts, start=1)}
    unit = f"1e-9 {values[0].unit if values else 'm/N'}"
    columns = [Column("formula", words=True), Column("value", unit)]
    columns += [Column("ratio to FE", decimals=2)] if fe else []
    columns += [Column("applies", words=True), Column("remarks", words=True)]

    def row(name: str, value: float, applies: str = "", remarks: Sequence[str] = ()) -> list[Cell]:
        ratio = [value / fe] if fe else []
        noted = ", ".join(map(str, sorted(numbers[text] for text in remarks)))
        return [name, value, *ratio, applies, noted]

    rows = [] if fe is None else [row("finite elements", fe)]
    rows += [] if law is None else [row("the law", law.value)]
    rows += [
        row(formula.name, formula.value, "yes" if formula.valid else "no", formula.remarks)
        for formula in values
    ]
    yield Table(title, columns, rows, main=True)
    for text, place in numbers.items():
        yield units.written(f"  {place}. {kept(text)}")
    for without in formulas.left_out if kind == "axial" else ():
        yield units.written(f"  Left out: {kept(without.reason)}.")
    if law is not None:
        low, high = (units.of(unit).with_name(end) for end in (law.lower, law.upper))
        beside = "neighbors" in law.support
        softer = ", and omits the bending of sections between neighbors" if beside else ""
        yield (
            "  The law, fitted to finite elements with rigid end sections, has a band of "
            f"{low} to {high} (95 of 100 throws are in theirs){softer}."
        )


def engines_parts(
    engines: "Sequence[EngineFormulas]",
    gamma_deg: float,
    variant: str,
    constants: Mapping[str, float],
    units: OutputUnits = SI,
) -> Iterator[Table | str]:
    """Return the compliances of several engines by all formulas, one row for each."""
    from crankfem.analyses.throw.formula_records import KINDS

    for each in engines:
        for without in each.formulas.left_out:
            yield units.written(f"Left out of {each.engine}: {kept(without.reason)}.")
    yield _legend()
    yield Main("* outside the range where the formula has a meaning.")
    gamma = f"gamma = {angle_text(gamma_deg)}, {variant} formulas{_given(constants)}"
    for kind, si in KINDS.items():
        unit = units.of(f"1e-9 {si}")
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
        title = f"{kind.capitalize()} compliance [{unit.name}], {head}"
        yield _marked_table(title, names, [[row.get(name, "-") for name in names] for row in rows])


def spread_parts(
    spreads: "Sequence[EngineSpread]",
    gamma_deg: float,
    variant: str,
    constants: Mapping[str, float] | None = None,
    units: OutputUnits = SI,
) -> Iterator[Table | str]:
    """Return formula / finite elements of all engines, one row for each."""
    from crankfem.analyses.throw.formula_records import KINDS, formula_spreads

    yield _legend()
    yield Main(
        "* outside the range where the formula has a meaning. s/R: overlap of main journal and crankpin "
        "divided by the crank radius. Mean: geometric."
    )
    for kind, si in KINDS.items():
        head = f"gamma = {angle_text(gamma_deg)}, {variant} formulas{_given(constants)}"
        unit = units.of(f"1e-9 {si}")
        names = list(dict.fromkeys(name for spread in spreads for name in spread.ratios[kind]))
        if not names:
            continue
        rows = []
        for spread in spreads:
            fe = _compliance(getattr(spread.fe, kind), unit)
            rows.append([spread.engine, f"{spread.overlap:.2f}", fe])
            for ratio in map(spread.ratios[kind].get, names):
                mark = "" if ratio is None or ratio.valid else "*"
                rows[-1].append("-" if ratio is None else f"{ratio.value:.2f}{mark}")
        summary = formula_spreads(spreads, kind)
        for word in ("least", "mean", "greatest"):
            values = [getattr(summary[name], word) if name in summary else None for name in names]
            shown = ["-" if value is None else f"{value:.2f}" for value in values]
            rows.append([word, "", "", *shown])
        yield _marked_table(
            f"{kind.capitalize()} compliance: formula / finite elements, "
            f"{head if kind == 'axial' else 'pinned'} (FE in {unit.name})",
            ["engine", "s/R", "FE", *map(_short, names)],
            rows,
            # What sums the engines up stays where there is no room for all.
            weights=[*(1.0 for _ in spreads), 2.0, 2.0, 2.0],
        )


def published_parts(values: Sequence[PublishedValue]) -> Iterator[Table | str]:
    """Return the survey's table in its own units, repaired values marked, with remarks on doubtful ones."""
    names = [
        name for name in dict.fromkeys(value.formula for value in values) if name != FINITE_ELEMENTS
    ]
    yield "* power of ten repaired; printed are:"
    for value in values:
        if value.mark == "*" and value.repaired is not None and value.formula != FINITE_ELEMENTS:
            yield f"    {value.engine}, {value.formula}: {value.digits}, read as {value.repaired * 1e9:.6g}"
    yield "? as printed, doubtful:"
    for value in values:
        if value.mark == "?" and value.exponent_factor is not None:
            yield f"    {value.engine}, {value.formula}: {value.doubt}"
    yield "    Guglielmotti-Macchiotta: exponents of this column lost one by one"
    yield FINITE_ELEMENTS_DOUBT
    yield (
        "The paper gives no dimensions, and no dimensions make all columns agree: TsN, D2, And, Dor and "
        "Sko go with one web thickness, D1, Gor and Sto with a thicker one."
    )
    yield Main(_legend())
    yield Main("* power of ten repaired; ? as printed, doubtful.")
    cells = {(value.engine, value.formula): value for value in values}
    yield _marked_table(
        "Published axial compliance of one throw [1e-9 m/N]",
        ["engine", *map(_short, names)],
        [
            [engine, *(_published(cells.get((engine, name))) for name in names)]
            for engine in dict.fromkeys(value.engine for value in values)
        ],
    )


def _marked_table(
    title: str, heads: Sequence[str], rows: list[list[str]], weights: Sequence[float] = ()
) -> Table:
    """Return a table with digits aligned in columns with marks in some cells."""
    marked = [any(cell.endswith(MARKS) for cell in column) for column in zip(*rows, strict=True)]
    aligned = [
        [
            cell + " " if mark and not cell.endswith(MARKS) else cell
            for cell, mark in zip(row, marked, strict=True)
        ]
        for row in rows
    ]
    return Table(title, [Column(head) for head in heads], aligned, main=True, weights=weights)


def _compliance(value: float, unit: OutputUnit) -> str:
    """Write a compliance with three digits, without a power of ten."""
    scaled = value / unit.size
    return f"{scaled:.0f}" if scaled >= 100.0 else f"{scaled:#.3g}"


def _published(value: PublishedValue | None) -> str:
    if value is None:
        return "-"
    if value.repaired is None:
        return f"{value.digits}{value.mark}"
    return f"{value.repaired * 1e9:#.4g}{value.mark}"


def _short(name: str) -> str:
    """Return the head of a formula's column; torsional ones keep their names."""
    return AXIAL_FORMULAS[name].short if name in AXIAL_FORMULAS else name


def _legend() -> str:
    return f"{', '.join(f'{formula.short} {formula.name}' for formula in AXIAL_FORMULAS.values())}."


def reaction_parts(results: "ReactionResults", units: OutputUnits) -> Iterator[Table | str]:
    """Return reactions as those of a throw by finite elements, with their bands."""
    yield results.table(units)
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
        yield Main(f"Axial reaction {name}: {accuracy}")
    for name, reason in results.refused.items():
        yield Main(units.written(f"Reactions {name}: left out; {kept(reason)}"))


FILE_KINDS = {
    "engine": "describes a whole engine",
    "mechanism": "describes cranks, rods and pistons, not a whole engine",
    "throw": "describes a throw, not an engine",
    **{kind: files.about for kind, files in satellite_files().items()},
    "chain": "describes a chain of inertias and springs",
}


def check_parts(record: Record, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return how a file is understood."""
    for warning in record["warnings"]:
        yield MainWarning(units.written(f"{kept(warning).rstrip('.')}."))
    yield f"Sections: {', '.join(record['sections'])}."
    if record["arrangement"] is not None:
        yield from _arrangement_parts(record["engine"], record["arrangement"], units)
    throws = {
        f"Throw {name}": (
            throw["shape"],
            throw["law"],
            throw["dimensions"],
            f"The throw {name} as understood",
        )
        for name, throw in record.get("throws", {}).items()
    }
    if record["shape"] is not None and not throws:
        parts = (record["shape"], record["law"], record["dimensions"], "The throw as read")
        throws = {"Throw": parts}
    length, volume = units.of("mm"), units.of("dm^3")
    for name, (shape, law, dimensions, title) in throws.items():
        pins = "one pin" if shape.pins == 1 else f"{shape.pins} pins"
        yield Main(
            f"{name} with {pins}: length {length.with_name(shape.length, 5)}, overlap of journal and pin "
            f"{length.with_name(shape.overlap)}, volume {volume.with_name(shape.volume)}; "
            f"{_PARTS[shape.solved_part]}."
        )
        yield from _notes(shape.remarks, units)
        yield Main(law.sentence(units))
        if dimensions is None:
            continue
        yield Table.of_records(
            title,
            dimensions,
            (Column("dimension", words=True), "name"),
            (Column("symbol", words=True), "symbol"),
            (Column("", "mm", _digits(length)), "value"),
            (Column("meaning", words=True), "meaning"),
        )
    yield from _notes((f"{kept(remark).rstrip('.')}." for remark in record["remarks"]), units)
    yield Table.of_records(
        "Inputs",
        record["inputs"],
        (Column("field", words=True), "field"),
        (Column("value", words=True), "given"),
        (Column("assumed", words=True), lambda value: "yes" if value.assumed else ""),
        (Column("source", words=True), "source"),
        weight=lambda value: value.assumed,
        main=True,
    )


def check_answer(record: Record) -> str:
    """State whether a file is valid, what is assumed in it, and which commands can use it."""
    inputs = record["inputs"]
    assumed = sum(value.assumed for value in inputs)
    verb = "is" if assumed == 1 else "are"
    counted = f"; {assumed} of {len(inputs)} values {verb} assumed" if inputs else ""
    warnings = record["warnings"]
    warned = f"; {len(warnings)} warning{'s' if len(warnings) > 1 else ''}" if warnings else ""
    return (
        f"{record['file']}: valid {record['kind']} file{counted}{warned}. It {FILE_KINDS[record['kind']]}; "
        f"use it with: {', '.join(record['commands'])}."
    )


def _arrangement_parts(
    name: str, engine: "Arrangement", units: OutputUnits
) -> Iterator[Table | str]:
    from crankfem.analyses.mechanism.mechanism_results import intervals_text
    from crankfem.files.engine.mechanism_cylinders import order_named

    length, speed = units.of("mm"), units.of("1/min")
    digits = _digits(length)
    kind = "in line" if engine.bank_angles_deg is None else "in banks"
    cylinders = "1 cylinder" if engine.cylinders == 1 else f"{engine.cylinders} cylinders"
    speeds = [
        speed.number(running, 6)
        for running in (engine.lowest_speed, engine.highest_speed, engine.rated_speed)
    ]
    yield Main(
        f"{name}: {cylinders} {kind}, {engine.strokes}-stroke, bore x stroke "
        f"{length.number(engine.bore, digits)} x {length.number(engine.stroke, digits)} "
        f"{length.name}; runs from "
        f"{speeds[0]} to {speeds[1]} {speed.name}, rated speed {speeds[2]} {speed.name} (mean piston "
        f"speed {units.of('m/s').with_name(engine.mean_piston_speed, 3)}); "
        f"{order_named(engine.driven_by)} {'-'.join(map(str, engine.firing_order))}, "
        f"{intervals_text(engine.firing_intervals_deg, units, driven=bool(engine.driven_by))}."
    )
    fired = dict(zip(engine.firing_order, engine.firing_angles_deg, strict=True))
    angles = {"crank angle": engine.crank_angles_deg}
    if engine.bank_angles_deg is not None:
        angles["bank angle"] = engine.bank_angles_deg
    angles["top at" if engine.driven_by else "fires at"] = tuple(
        fired[number] for number in sorted(fired)
    )
    yield Table(
        f"Cylinders [{units.of('deg').name}]",
        [Column("cylinder"), *(Column(name, "deg", 6, bare=True) for name in angles)],
        [
            [number, *map(math.radians, row)]
            for number, row in enumerate(zip(*angles.values(), strict=True), start=1)
        ],
        main=True,
    )


def _digits(unit: OutputUnit) -> int:
    """Digits of a given length: all of them, and five if it was converted."""
    return 5 if unit.wished else 6
