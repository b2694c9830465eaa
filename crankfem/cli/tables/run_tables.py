"""Output of `crankfem run`: the verdict, its consequences, limits and the worst critical speeds."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from crankbase.tables.table import SI, Column, OutputUnits, Table
from crankbase.units.units import RPM, UNBOUNDED
from crankfem.analyses.vibration.tables import speed_table
from crankfem.cli.console import print_line, print_table
from crankfem.report.conclusions import conclusions, reached_and_permitted, verdict_line
from crankfem.report.summary import engine_facts, worst_of_each

# Critical speeds of each kind; --verbose and the report show more.
SPEEDS_SHOWN = 2


def print_conclusions(results: Mapping[str, Any], units: OutputUnits = SI) -> None:
    """Print the verdict of a run, its basis and its consequences.

    Parameters
    ----------
    results : mapping
        Content of results.json.
    units : OutputUnits, optional
    """
    print_verdict(results, units)
    for line in conclusions(results):
        print_line(units.text(f"- {line}"))


def print_engine(results: Mapping[str, Any], units: OutputUnits = SI) -> None:
    """Print what the engine is, in one line."""
    print_line(units.text(f"{results['engine']['name']}: {'; '.join(engine_facts(results))}."))


def print_worst(results: Mapping[str, Any], units: OutputUnits = SI) -> None:
    """Print limits, each at its worst location, and the worst critical speeds.

    Parameters
    ----------
    results : mapping
        Content of results.json.
    units : OutputUnits, optional
    """
    vibration = results["vibration"]
    if vibration["assessment"] is not None:
        print_table(_limits(vibration["assessment"]["checks"], units), units, plain=True)
    speeds = speed_table(vibration, units, SPEEDS_SHOWN)
    shown = ["vibration", "speed", "order", "peak at", "amplitude", "kind"]
    if vibration["forced"] is None:
        shown = ["vibration", "speed", "order", "mode", "phase sum"]
    known = [column.name for column in speeds.columns]  # without peaks there are no amplitudes
    if speeds.rows:
        own = speeds.select(*(name for name in shown if name in known))
        print_table(replace(own, note=""), units, plain=True)


def print_verdict(results: Mapping[str, Any], units: OutputUnits = SI) -> None:
    """Print the verdict of a run in one line."""
    print_line(units.text(verdict_line(results)))


def _limits(checks: list[dict[str, Any]], units: OutputUnits) -> Table:
    return Table.of_records(
        "Limits, each at its worst location and running speed",
        worst_of_each(checks),
        (Column("limit", words=True), lambda one: one["limit"].removesuffix(f" of {one['place']}")),
        (Column("where", words=True), "place"),
        (Column("at", "1/min", decimals=1), lambda one: one["speed_rpm"] / RPM),
        (Column("reached"), lambda one: units.text(reached_and_permitted(one)[0])),
        (Column("permitted"), lambda one: units.text(reached_and_permitted(one)[1])),
        (Column("used", "%", 3, missing=UNBOUNDED), "used"),
    )
