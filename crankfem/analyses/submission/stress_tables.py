"""Stresses, dampers, couplings, gears and the generator in all ways of firing, as tables."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.tables.output_units import OutputUnit
from crankbase.tables.table import Cell, Column, Table
from crankbase.units.number_formats import UNBOUNDED
from crankfem.analyses.submission.firing_cases import (
    GEARS,
    GENERATOR,
    MEANING,
    STRESS,
    TORQUE,
    FiringCases,
    damper_places,
    heat_factors,
    limit_of,
)
from crankfem.analyses.vibration.engine_limits import COUPLING
from crankfem.analyses.vibration.firing_check import Reached, permitted_at
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.sections.limits_sections import LimitsInput
from dynamics.assessment.verdict import Verdict
from dynamics.running_limits import within

SPEED = Column("at", "1/min", decimals=1)
STRESSES = "MPa"
# Columns of places that a table has at most; more of them go to another one.
PLACES_SHOWN = 7


def place_numbers(cases: FiringCases) -> dict[str, int]:
    """Return the numbers by which wide tables call the places of stress, from 1."""
    return {name: number for number, name in enumerate(cases.normal[STRESS].names, start=1)}


def normal_table(cases: FiringCases) -> Table:
    """Return the synthesized stress of each place in normal firing, beside its limits."""
    rows, marks = [], []
    for name, number in place_numbers(cases).items():
        largest = cases.firing.largest[STRESS, name]
        kept, passed = cases.firing.kept[STRESS, name], cases.firing.passed.get((STRESS, name))
        rows.append(
            [
                number,
                name,
                _value(largest),
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
        note="Half of the range over the cycle, nominal, all orders together. Largest: at any speed up to "
        "the highest calculated. Kept: where most of the continuous limit is used at running speeds not in "
        "ranges to be barred. Passed: the same within these ranges, of the limit for passing.",
        marks=marks,
    )


def _value(found: Reached) -> float | str:
    return UNBOUNDED if math.isinf(found.value) else found.value


def _judged(found: Reached) -> list[float | str | None]:
    stated = not math.isinf(found.permitted)
    return [_value(found), found.speed, found.used if stated else None]


def permitted_table(run: EngineVibration, cases: FiringCases) -> Table:
    """Return the limits of each place at shares of the rated speed."""
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
        note="Shafts by their numbers; a dash where the rule states none.",
        merged=True,
    )


def order_tables(cases: FiringCases) -> list[Table]:
    """Return the largest stress of each order at any speed, and the speed, of each place."""
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
    """Return the worst case of one cylinder failing for each place, beside normal firing."""
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
                _value(cases.firing.largest[STRESS, name]),
                _value(largest),
                largest.speed,
                f"{worst}",
                _value(found),
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
        note=f"{MEANING[way][0].upper()}{MEANING[way][1:]}; the others fire as before, at the speeds "
        "of normal firing. Held against the limit for passing at speeds for which it is stated, else against "
        "that for continuous running, outside of ranges to be barred.",
        marks=marks,
    )


def each_table(cases: FiringCases, way: str) -> Table:
    """Return the stress of each place with each cylinder failing."""
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
    """Return the vibratory torque of each element in all ways of firing."""
    ways = list(cases.failing)
    rows = []
    for name in cases.normal[TORQUE].names:
        row = [name, _value(cases.firing.kept[TORQUE, name]), cases.firing.kept[TORQUE, name].speed]
        for way in ways:
            worst = cases.worst_cylinder(way, TORQUE, name)
            found = cases.failing[way][worst].kept[TORQUE, name]
            row += [_value(found), found.speed]
        rows.append(row)
    columns = [Column("shaft", words=True), Column("normal firing", "kN m"), SPEED]
    for way in ways:
        columns += [Column(way, "kN m"), SPEED]
    return Table(
        "Vibratory torque in every shaft, synthesized: largest at running speeds that are not to be barred",
        columns,
        rows,
        note="With a cylinder failing the worst of all cylinders.",
    )


def damper_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return torque and heat of dampers and couplings beside what is permitted; None without any."""
    chain, limits = run.torsional_chain, run.engine_file.limits or LimitsInput()
    dampers = damper_places(chain)
    keys = dict.fromkeys([*dampers, *heat_factors(chain)])
    if COUPLING in chain.elements:
        keys[TORQUE, COUPLING] = None
    rows, marks = [], []
    for key, name in keys:
        permitted = {
            "torque": limits.damper_torque if (key, name) in dampers else None,
            "heat": limits.damper_heat if (key, name) in dampers else None,
        }
        if name == COUPLING:
            permitted = {"torque": limits.coupling_torque, "heat": limits.coupling_heat}
        for way, found, heat in _each_way(cases, key, name):
            used = [
                value / limit
                for value, limit in ((found.value, permitted["torque"]), (heat, permitted["heat"]))
                if limit is not None and value is not None
            ]
            rows.append(
                [
                    name,
                    way,
                    _value(found),
                    found.speed,
                    permitted["torque"],
                    heat,
                    permitted["heat"],
                    max(used, default=None),
                ]
            )
            marks.append("over" if used and max(used) > 1.0 else "")
    if not rows:
        return None
    return Table(
        "Dampers, couplings and shafts with damping: vibratory torque and heat at running speeds",
        [
            Column("part", words=True),
            Column("firing", words=True),
            Column("torque", "kN m"),
            SPEED,
            Column("permitted", "kN m", missing="not given"),
            Column("heat", "kW", missing="none"),
            Column("permitted", "kW", missing="not given"),
            Column("used", "%", 3, missing="-"),
        ],
        rows,
        note="Outside of ranges to be barred; torque with all orders together, heat the mean of the cycle. "
        "Permitted values are the maker's: damper_torque, damper_heat, coupling_torque, coupling_heat of "
        "[limits].",
        marks=marks,
    )


def _each_way(
    cases: FiringCases, key: str, name: str
) -> Sequence[tuple[str, Reached, float | None]]:
    heat = cases.firing.heat.get(name)
    ways = [("normal", cases.firing.kept[key, name], None if heat is None else heat[0])]
    for way, failing in cases.failing.items():
        worst = cases.worst_cylinder(way, key, name)
        own = [one.heat[name][0] for one in failing.values() if name in one.heat]
        ways.append((way, failing[worst].kept[key, name], max(own, default=None)))
    return ways


def barred_table(verdict: Verdict) -> Table:
    """Return the speed ranges to be barred, and what is said of passing them."""
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
                "yes" if one.allowed else "no",
                "; ".join((*one.refusals, one.ends, *one.remarks)),
            ]
            for one in ranges
        ],
        marks=["" if one.allowed else "over" for one in ranges],
    )


def gear_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return vibratory beside mean torque of each gear; None without gears."""
    if GEARS not in cases.normal:
        return None
    engine, chain = run.engine_file.engine, run.torsional_chain
    series, speeds = cases.normal[GEARS], cases.speeds
    running = within(speeds, engine.lowest_speed, engine.highest_speed)
    rows: list[list[Cell]] = []
    marks = []
    for place, name in enumerate(series.names):
        # One gear passes all of the mean torque on; of several the file does not tell which share.
        mean = np.abs(cases.mean_torque / chain.gears[0].ratio) if len(chain.gears) == 1 else None
        amplitude = series.synthesis.amplitude[:, place]
        if mean is None:
            found = cases.firing.kept[GEARS, name]
            rows.append([name, found.speed, None, _value(found), None, "mean torque not known"])
            marks.append("")
            continue
        share = np.where(running, amplitude / mean, 0.0)
        worst = int(np.argmax(share))
        hammers = share[worst] > 1.0
        rows.append(
            [
                name,
                float(speeds[worst]),
                float(mean[worst]),
                float(amplitude[worst]),
                float(share[worst]),
                "teeth part" if hammers else "teeth stay in contact",
            ]
        )
        marks.append("over" if hammers else "")
    return Table(
        "Gears in normal firing: worst running speed",
        [
            Column("gear", words=True),
            SPEED,
            Column("mean torque", "kN m", missing="-"),
            Column("vibratory torque", "kN m"),
            Column("share", "%", 3, missing="-"),
            Column("gear hammer", words=True),
        ],
        rows,
        note="Torques on the driven wheel, the mean one that of the gas, without friction. Teeth part where "
        "the vibratory torque exceeds the mean one.",
        marks=marks,
    )


def generator_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return the electrical angle of the generator's rotor; None where its poles are not given."""
    if GENERATOR not in cases.normal:
        return None
    engine = run.engine_file.engine
    assert engine.generator_poles is not None
    limit = (run.engine_file.limits or LimitsInput()).generator_angle
    (node,) = cases.normal[GENERATOR].names
    at_rated = int(np.argmin(np.abs(cases.speeds - engine.rated_speed)))
    rated = float(cases.normal[GENERATOR].synthesis.amplitude[at_rated, 0])
    ways = [("normal, at rated speed", rated, float(cases.speeds[at_rated]))]
    for way, found, _ in _each_way(cases, GENERATOR, node):
        ways.append((f"{way}, at running speeds", found.value, found.speed))
    degrees = OutputUnit("deg", math.pi / 180.0)
    return Table(
        f"Oscillation of the generator's rotor ({node})",
        [
            Column("firing", words=True),
            SPEED,
            Column("mechanical amplitude", degrees),
            Column("electrical angle", degrees),
            Column("permitted", degrees, missing="not given"),
            Column("used", "%", 3, missing="-"),
        ],
        [
            [
                way,
                speed,
                2.0 * angle / engine.generator_poles,
                UNBOUNDED if math.isinf(angle) else angle,
                limit,
                None if limit is None else angle / limit,
            ]
            for way, angle, speed in ways
        ],
        note=f"{engine.generator_poles} poles: an electrical degree is {2.0 / engine.generator_poles:.4g} "
        "mechanical ones; the whole motion counts, that of the rotor as one with the shaft included.",
        marks=["over" if limit is not None and angle > limit else "" for _, angle, _ in ways],
    )


def limit_source_table(cases: FiringCases) -> Table:
    """Return where each limit comes from."""
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
        [
            Column("limit", words=True),
            Column("source", words=True),
            Column("remark", words=True),
        ],
        list(rows.values()),
    )


def permitted_curves(cases: FiringCases, name: str) -> dict[str, FloatArray]:
    """Return the limits of a place over the speeds, by what a legend calls them."""
    limit = limit_of(cases.limits, STRESS, name)
    if limit is None:
        return {}
    found = {"continuous limit": permitted_at(limit, cases.speeds)}
    if limit.passing is not None:
        found["limit for passing"] = limit.passing.at(cases.speeds)
    return found
