"""Stresses and torques of shafts in all cases of firing, limits and ranges to bar, as tables."""

import math
from itertools import pairwise

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.tables.table import Cell, Column, Table
from crankbase.units.units import UNBOUNDED
from crankfem.analyses.submission.firing_cases import MEANING, STRESS, TORQUE, FiringCases, limit_of
from crankfem.analyses.vibration.misfiring import Reached, permitted_at
from crankfem.analyses.vibration.run import EngineVibration
from dynamics.assessment.verdict import Verdict

SPEED = Column("at", "1/min", decimals=1)
STRESSES = "MPa"
# Columns of places that a table has at most; more of them go to another one.
PLACES_SHOWN = 7


def place_numbers(cases: FiringCases) -> dict[str, int]:
    """Return the numbers of the locations of stress in wide tables, from 1."""
    return {name: number for number, name in enumerate(cases.normal[STRESS].names, start=1)}


def normal_table(cases: FiringCases) -> Table:
    """Return the synthesized stress of each location in normal firing, with its limits."""
    rows, marks = [], []
    for name, number in place_numbers(cases).items():
        largest = cases.firing.largest[STRESS, name]
        kept, passed = cases.firing.kept[STRESS, name], cases.firing.passed.get((STRESS, name))
        rows.append(
            [
                number,
                name,
                found_value(largest),
                largest.speed,
                *_judged(kept),
                *((None, None, None) if passed is None else _judged(passed)),
            ]
        )
        over = kept.used > 1.0 or (passed is not None and passed.used > 1.0)
        marks.append("over" if over else "")
    return Table(
        "Normal firing: synthesized torsional stress",
        [
            Column("no."),
            Column("shaft", words=True),
            Column("largest", STRESSES),
            SPEED,
            Column("kept", STRESSES),
            SPEED,
            Column("used", "%", 3),
            Column("passed", STRESSES, missing="-"),
            Column("at", "1/min", decimals=1, missing="-"),
            Column("used", "%", 3, missing="-"),
        ],
        rows,
        note="Nominal stress amplitude (half the range over the cycle), all orders together. Largest: at "
        "any calculated speed. Kept: largest use of the continuous limit at running speeds outside ranges "
        "to be barred. Passed: largest use of the limit for passing within these ranges.",
        marks=marks,
    )


def found_value(found: Reached) -> float | str:
    """Return a value, as a word where it is unbounded."""
    return UNBOUNDED if math.isinf(found.value) else found.value


def _judged(found: Reached) -> list[float | str | None]:
    stated = not math.isinf(found.permitted)
    return [found_value(found), found.speed, found.used if stated else None]


def permitted_table(run: EngineVibration, cases: FiringCases) -> Table:
    """Return the limits of each location at shares of the rated speed."""
    shares = (0.4, 0.6, 0.8, 0.9, 1.0, 1.05)
    rated = run.engine_file.engine.rated_speed
    speeds = rated * np.array(shares)
    rows = []
    for name, number in place_numbers(cases).items():
        limit = limit_of(cases.limits, STRESS, name)
        if limit is None:
            continue
        for kind, curve in (("continuous", limit.continuous), ("passing", limit.passing)):
            if curve is None:
                continue
            values = curve.at(speeds).tolist()
            rows.append([f"{number}", kind, *(None if math.isinf(one) else one for one in values)])
    return Table(
        "Permitted stress at shares of the rated speed",
        [
            Column("no.", words=True),
            Column("limit", words=True),
            *(Column(f"{100.0 * share:g} %", STRESSES, missing="-") for share in shares),
        ],
        rows,
        note="Shafts by number; a dash where the rule states no limit.",
        merged=True,
    )


def order_tables(cases: FiringCases) -> list[Table]:
    """Return the largest stress of each order at any speed, and the speed, for each location."""
    series, speeds = cases.normal[STRESS], cases.speeds
    numbers = list(place_numbers(cases).values())
    tables = []
    parts = -(-len(numbers) // PLACES_SHOWN)
    ends = [round(part * len(numbers) / parts) for part in range(parts + 1)]
    for some in (slice(*pair) for pair in pairwise(ends)):
        values = series.amplitude[:, :, some]
        tops = np.argmax(values, axis=1)
        highest = np.max(values, axis=1)
        columns = [Column("order", digits=None)]
        for number in numbers[some]:
            columns += [Column(f"no. {number}", STRESSES, digits=3), SPEED]
        rows = [
            [
                order,
                *(
                    cell
                    for place in range(highest.shape[1])
                    for cell in (
                        UNBOUNDED if math.isinf(highest[k, place]) else float(highest[k, place]),
                        float(speeds[tops[k, place]]),
                    )
                ),
            ]
            for k, order in enumerate(series.orders.tolist())
        ]
        tables.append(
            Table(
                "Normal firing: largest torsional stress by order, and its speed",
                columns,
                rows,
                note="Amplitudes of single orders up to the highest speed calculated; shafts by number.",
            )
        )
    return tables


def failing_table(cases: FiringCases, way: str) -> Table:
    """Return the worst case of one cylinder failing for each location, and normal firing."""
    rows: list[list[Cell]] = []
    marks = []
    for name, number in place_numbers(cases).items():
        worst = cases.worst_cylinder(way, STRESS, name)
        found = cases.failing[way][worst].kept[STRESS, name]
        largest = max(
            (one.largest[STRESS, name] for one in cases.failing[way].values()),
            key=lambda one: one.value,
        )
        permitted = None if math.isinf(found.permitted) else found.permitted
        rows.append(
            [
                number,
                name,
                found_value(cases.firing.largest[STRESS, name]),
                found_value(largest),
                largest.speed,
                f"{worst}",
                found_value(found),
                found.speed,
                permitted,
                None if permitted is None else found.used,
            ]
        )
        marks.append("over" if found.used > 1.0 else "")
    return Table(
        f"{way.capitalize()}: the worst of all cylinders",
        [
            Column("no."),
            Column("shaft", words=True),
            Column("normal", STRESSES),
            Column("largest", STRESSES),
            SPEED,
            Column("worst cylinder"),
            Column("kept", STRESSES),
            SPEED,
            Column("permitted", STRESSES, missing="-"),
            Column("used", "%", 3, missing="-"),
        ],
        rows,
        note=f"{MEANING[way][0].upper()}{MEANING[way][1:]}; the others fire as before, at the speeds of "
        "normal firing. Compared with the continuous limit, or with that for passing where it serves while a "
        "cylinder misfires, outside ranges to be barred.",
        marks=marks,
    )


def each_table(cases: FiringCases, way: str) -> Table:
    """Return the stress of each location with each cylinder failing."""
    numbers = sorted(cases.failing[way])
    return Table(
        f"{way.capitalize()}: largest use of the limit, cylinder by cylinder",
        [
            Column("no."),
            Column("shaft", words=True),
            *(Column(f"cylinder {one}", "%", 3, missing="-") for one in numbers),
        ],
        [
            [
                number,
                name,
                *(
                    None if math.isinf(found.permitted) else found.used
                    for one in numbers
                    for found in (cases.failing[way][one].kept[STRESS, name],)
                ),
            ]
            for name, number in place_numbers(cases).items()
        ],
    )


def torque_table(cases: FiringCases) -> Table:
    """Return the vibratory torque of each element in all cases of firing."""
    ways = list(cases.failing)
    rows = []
    for name in cases.normal[TORQUE].names:
        row = [
            name,
            found_value(cases.firing.kept[TORQUE, name]),
            cases.firing.kept[TORQUE, name].speed,
        ]
        for way in ways:
            worst = cases.worst_cylinder(way, TORQUE, name)
            found = cases.failing[way][worst].kept[TORQUE, name]
            row += [found_value(found), found.speed]
        rows.append(row)
    columns = [Column("shaft", words=True), Column("normal firing", "kN m"), SPEED]
    for way in ways:
        columns += [Column(way, "kN m"), SPEED]
    return Table(
        "Vibratory torque in every shaft, synthesized: largest at running speeds that are not to be barred",
        columns,
        rows,
        note="With a cylinder failing: the worst of all cylinders.",
    )


def barred_table(verdict: Verdict) -> Table:
    """Return the speed ranges to be barred, and the remarks on passing them."""
    ranges = (*verdict.started_through, *verdict.barred)
    return Table(
        "Speed ranges to be barred, or passed on starting",
        [
            Column("from", "1/min", decimals=2),
            Column("to", "1/min", decimals=2),
            Column("may be passed", words=True),
            Column("why, and where it ends", words=True),
        ],
        [
            [
                one.low,
                one.high,
                "not judged" if one.full_load else "yes" if one.allowed else "no",
                "; ".join((*one.refusals, one.ends, *one.remarks)),
            ]
            for one in ranges
        ],
        marks=["" if one.allowed else "over" for one in ranges],
    )


def limit_source_table(cases: FiringCases) -> Table:
    """Return the source of each limit."""
    rows = {
        limit.name: [
            limit.name,
            ("assumed: " if limit.assumed else "") + limit.source,
            limit.remark or "-",
        ]
        for limit in cases.limits.values()
    }
    return Table(
        "Limits and their sources",
        [Column("limit", words=True), Column("source", words=True), Column("remark", words=True)],
        list(rows.values()),
    )


def permitted_curves(cases: FiringCases, name: str) -> dict[str, FloatArray]:
    """Return the limits of a location over the speeds, by their names in the legend."""
    limit = limit_of(cases.limits, STRESS, name)
    if limit is None:
        return {}
    found = {"continuous limit": permitted_at(limit, cases.speeds)}
    if limit.passing is not None:
        found["limit for passing"] = limit.passing.at(cases.speeds)
    return found
