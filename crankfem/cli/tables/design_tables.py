"""The designs of a study, as a table and as a record."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from crankbase.tables.table import Cell, Column, OutputUnit, Table
from crankbase.units.units import DISPLAY_UNITS
from crankfem.analyses.record import attributes
from crankfem.cli.console import print_line, print_table
from regression.plans.designs_space import DesignQuality, design_quality
from regression.plans.factors import Factor
from regression.plans.plan import ExcludedDesign, PlannedStudy
from regression.records import HELD_OUT, RUN

# More lines than this nobody reads.
MOST_ROWS = 200
MOST_REASONS = 12
# Reasons that differ in numbers alone are told once.
NUMBER = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?")


def plan_record(planned: PlannedStudy) -> dict[str, Any]:
    """Return the designs of a study as JSON content: SI units, choices by their labels."""
    factors, quality = planned.plan.factors, _quality(planned)
    return {
        "study": planned.plan.key,
        "statement": planned.statement,
        "remarks": list(planned.remarks),
        "quality": asdict(quality) | {"correlated": list(quality.correlated)},
        "factors": [
            {"name": factor.name, "unit": factor.unit, "labels": list(factor.labels)}
            for factor in factors
        ],
        "designs": [
            attributes(design, "role", "key") | {"values": _named(factors, design.values)}
            for design in planned.designs
        ],
        "excluded": [
            attributes(design, "role", "reason") | {"values": _named(factors, design.values)}
            for design in planned.excluded
        ],
    }


def print_plan(planned: PlannedStudy) -> None:
    """Print the designs of a study, their names, and which were excluded and why."""
    plan = planned.plan
    held_out = sum(design.role == HELD_OUT for design in planned.designs)
    print_line(
        f"{planned.statement[0].upper()}{planned.statement[1:]}; {held_out} held-out designs to judge the "
        f"fits (Latin hypercube, seed {plan.seed})."
    )
    for remark in planned.remarks:
        print_line(f"Note: {remark}")
    for line in _quality_lines(_quality(planned)):
        print_line(line)
    print_table(
        Table(
            "Designs",
            [Column("design"), Column("role", words=True), *map(_column, plan.factors)],
            [
                [number, design.role, *map(_cell, plan.factors, design.values)]
                for number, design in enumerate(planned.designs[:MOST_ROWS], start=1)
            ],
        )
    )
    if len(planned.designs) > MOST_ROWS:
        print_line(f"... and {len(planned.designs) - MOST_ROWS} more; --json has them all.")
    for path, text in plan.relations.items():
        print_line(f"In every design {path} = {text}.")
    _print_excluded(planned)


def _quality(planned: PlannedStudy) -> DesignQuality:
    runs = [design.values for design in planned.designs if design.role == RUN]
    return design_quality(planned.plan.factors, np.array(runs))


def _quality_lines(quality: DesignQuality) -> Iterator[str]:
    """State how well the runs fill the box, with ranges scaled to 0 to 1."""
    distance = "" if quality.distance is None else f"nearest runs {quality.distance:.3g} apart, "
    yield (
        f"Runs in the unit cube: {distance}discrepancy {quality.discrepancy:.2g} (random points: "
        f"{quality.random_discrepancy:.2g})."
    )
    if quality.correlated:
        yield (
            f"Largest correlation of two factors: {quality.correlation:.2g}, of "
            f"{' and '.join(quality.correlated)}."
        )
    elif quality.correlation is not None:
        yield "No two factors are correlated."


def _print_excluded(planned: PlannedStudy) -> None:
    """State which designs are excluded and why; of those for the same reason only the first."""
    if not planned.excluded:
        return
    factors = planned.plan.factors
    print_line(f"Excluded before any finite-element run: {len(planned.excluded)} designs.")
    alike: dict[str, list[ExcludedDesign]] = defaultdict(list)
    for design in planned.excluded:
        alike[NUMBER.sub("#", design.reason)].append(design)
    groups = sorted(alike.values(), key=len, reverse=True)
    for designs in groups[:MOST_REASONS]:
        first = designs[0]
        values = ", ".join(
            f"{factor.name} {factor.format_value(value)}"
            for factor, value in zip(factors, first.values, strict=True)
        )
        more = f" ({len(designs) - 1} more alike)" if len(designs) > 1 else ""
        print_line(f"  {first.role}, {values}: {first.reason.rstrip('.')}{more}.")
    if len(groups) > MOST_REASONS:
        print_line(f"  ... and {len(groups) - MOST_REASONS} other reasons; --json has them all.")


def _column(factor: Factor) -> Column:
    unit, size = DISPLAY_UNITS.get(factor.unit, (factor.unit, 1.0))
    return Column(factor.name, OutputUnit(unit, size), 6, words=factor.categorical)


def _cell(factor: Factor, value: float) -> Cell:
    return factor.format_value(value) if factor.categorical else float(value)


def _named(factors: tuple[Factor, ...], values: tuple[float, ...]) -> dict[str, float | str]:
    return {
        factor.name: factor.format_value(value) if factor.categorical else value
        for factor, value in zip(factors, values, strict=True)
    }
