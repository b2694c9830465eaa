"""The class document's tables of natural frequencies, amplitudes and stresses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.quantity import UNBOUNDED
from crankbase.summaries import summarized
from crankbase.table import Cell, Column, OutputUnit, Table
from crankfem.analyses.submission.firing_cases import (
    HIGHEST_SHARE,
    MEANING,
    STRESS,
    TORQUE,
    FiringCases,
    limit_of,
)
from crankfem.analyses.vibration.misfiring import Reached, permitted_at
from crankfem.analyses.vibration.run import EngineVibration
from dynamics.assessment.separation import (
    MAJOR_READING,
    MAJOR_SOURCE,
    MajorCriticals,
    major_criticals,
)
from dynamics.assessment.verdict import Verdict
from dynamics.chains.chain import Chain
from dynamics.chains.chain_modes import Modes
from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders, major_orders
from dynamics.torque import Star, star_diagram

MEGA_STIFFNESS = OutputUnit("MN m/rad", 1e6)
# Modes that are shown at least, and at most.
LEAST_MODES, MOST_MODES = 3, 6
# The amplitude to which Holzer tables are scaled [rad].
UNIT_AMPLITUDE = 1e-3
# Sums of torques below this share of the largest one are zero.
ROUND_OFF = 1e-9


@summarized("frequency [Hz]", "modal_inertia [kg m^2]", "amplitude")
@dataclass(frozen=True, eq=False)
class HolzerTable:
    """One mode scaled to an amplitude of 1 mrad at the first node: motions and torques.

    Attributes
    ----------
    frequency : float
        [Hz].
    amplitude : (n,) array
        Of each node relative to that of the first one.
    inertia_torque : (n,) array
        Torque of the inertia of each node [N m].
    torque : (e,) array
        In each element, the second node minus the first [N m].
    ground : (n,) array
        Torque of the springs to ground at each node [N m].
    modal_inertia : float
        Referred to the first node [kg m^2].
    kinetic_shares : (n,) array
    strain_shares : (e,) array
    """

    frequency: float
    amplitude: FloatArray
    inertia_torque: FloatArray
    torque: FloatArray
    ground: FloatArray
    modal_inertia: float
    kinetic_shares: FloatArray
    strain_shares: FloatArray


def holzer_table(chain: Chain, modes: Modes, mode: int) -> HolzerTable:
    """Return the Holzer table of a mode.

    Parameters
    ----------
    modes : Modes
        Of this chain.
    mode : int
        Number among all modes, rigid ones counted, from 0.

    Notes
    -----
    With the shape a, a_1 = 1 at the first node, node i contributes the torque w^2 (M a)_i and element j
    carries k_j times its twist. Together with springs to ground and gears they balance at each node. A mode
    with the first node at rest is scaled to its largest amplitude.
    """
    shape = modes.shapes[:, mode]
    first = shape[0] if abs(shape[0]) > np.finfo(float).eps else 1.0
    amplitude = shape / first
    w = float(modes.angular_frequencies[mode])
    elements = len(chain.connections)
    return HolzerTable(
        frequency=w / (2.0 * np.pi),
        amplitude=amplitude,
        inertia_torque=UNIT_AMPLITUDE * w**2 * (chain.mass_matrix() @ amplitude),
        torque=UNIT_AMPLITUDE * chain.stiffness * (chain.elongations() @ amplitude),
        ground=UNIT_AMPLITUDE * chain.ground * amplitude,
        modal_inertia=float(modes.modal_inertia[mode]) / first**2,
        kinetic_shares=modes.kinetic_shares[:, mode],
        strain_shares=modes.strain_shares[:elements, mode],
    )


def shown_modes(run: EngineVibration) -> tuple[int, ...]:
    """Return the elastic modes that the orders reach up to 120 % of rated speed, rigid ones counted."""
    modes, engine = run.torsional.chosen.modes, run.engine_file.engine
    turns = HIGHEST_SHARE * engine.rated_speed / (2.0 * np.pi)
    highest = run.engine_file.vibration.highest_order * turns
    reached = int(np.count_nonzero(modes.elastic_frequencies <= highest))
    count = min(max(reached, LEAST_MODES), MOST_MODES, modes.elastic_frequencies.size)
    return tuple(range(modes.rigid, modes.rigid + count))


def mode_list_table(run: EngineVibration) -> Table:
    """Return natural frequencies with modal inertias and the number of nodes."""
    chain, modes = run.torsional_chain, run.torsional.chosen.modes
    rows = []
    for number in range(modes.rigid, len(modes.frequencies)):
        holzer = holzer_table(chain, modes, number)
        rows.append(
            [
                number - modes.rigid + 1,
                holzer.frequency,
                60.0 * holzer.frequency,
                holzer.modal_inertia,
                len(modes.node_positions[number]),
            ]
        )
    return Table(
        "Natural frequencies, without damping",
        [
            Column("mode"),
            Column("frequency", "Hz", decimals=3),
            Column("vibrations per minute", decimals=2),
            Column("modal inertia, referred to the first mass", "kg m^2"),
            Column("nodes"),
        ],
        rows,
    )


def mass_table(chain: Chain, holzer: HolzerTable, number: int) -> Table:
    """Return the masses of a Holzer table."""
    return Table(
        f"Mode {number}, {60.0 * holzer.frequency:.2f} vibrations per minute "
        f"({holzer.frequency:.3f} Hz): masses",
        [
            Column("no."),
            Column("mass", words=True),
            Column("inertia", "kg m^2", digits=6),
            Column("relative amplitude", decimals=5),
            Column("inertia torque", "kN m"),
            Column("their sum so far", "kN m"),
            Column("kinetic energy", "%", decimals=2),
        ],
        [
            [place, *row]
            for place, row in enumerate(
                zip(
                    chain.names,
                    chain.inertia.tolist(),
                    holzer.amplitude.tolist(),
                    holzer.inertia_torque.tolist(),
                    _sums(holzer.inertia_torque),
                    holzer.kinetic_shares.tolist(),
                    strict=True,
                ),
                start=1,
            )
        ],
        note=f"Torques at an amplitude of 1 mrad of {chain.names[0]}; modal inertia referred to it "
        f"{holzer.modal_inertia:.5g} kg m^2.",
    )


def _sums(torques: FloatArray) -> list[float]:
    """Return sums from the first on, with zero for round-off."""
    sums = np.cumsum(torques)
    small = np.abs(sums) < ROUND_OFF * np.max(np.abs(torques))
    cleaned: list[float] = np.where(small, 0.0, sums).tolist()
    return cleaned


def shaft_table(chain: Chain, holzer: HolzerTable, number: int) -> Table:
    """Return the shafts of a Holzer table."""
    return Table(
        f"Mode {number}: shafts",
        [
            Column("shaft", words=True),
            Column("stiffness", MEGA_STIFFNESS, digits=6),
            Column("relative twist", decimals=5),
            Column("torque", "kN m"),
            Column("strain energy", "%", decimals=2),
        ],
        [
            list(row)
            for row in zip(
                chain.elements,
                chain.stiffness.tolist(),
                (chain.elongations() @ holzer.amplitude).tolist(),
                holzer.torque.tolist(),
                holzer.strain_shares.tolist(),
                strict=True,
            )
        ],
        note=f"At an amplitude of 1 mrad of {chain.names[0]}.",
    )


def mode_stars(run: EngineVibration, mode: int) -> tuple[Star, ...]:
    """Return the stars of all orders of a mode, cylinders weighted by its amplitudes, the first node's 1."""
    file, named = run.engine_file, run.torsional.chosen.chain
    holzer = holzer_table(named.chain, run.torsional.chosen.modes, mode)
    return star_diagram(
        firing_angles_deg=np.degrees(file.engine.firing_angles),
        orders=orders_of(run),
        strokes=file.engine.strokes,
        mode_shape=holzer.amplitude[list(named.throw_nodes)][list(file.throws)],
    )


def orders_of(run: EngineVibration) -> FloatArray:
    """Return the orders of the engine up to the highest of its file."""
    file = run.engine_file
    return engine_orders(file.engine.strokes, file.vibration.highest_order)


def vector_table(run: EngineVibration) -> Table:
    """Return the vector sums of all orders in the modes that are shown."""
    rigid, shown = run.torsional.chosen.modes.rigid, shown_modes(run)
    stars = [mode_stars(run, mode) for mode in shown]
    majors = major_orders(orders_of(run), run.engine_file.engine.firing_angles)
    columns = [Column("order", digits=None)]
    for mode in shown:
        name = f"mode {mode - rigid + 1}"
        columns += [Column(name, decimals=4), Column("", "%", decimals=1)]
    return Table(
        "Vector sums by order and mode, and their share of the largest possible sum",
        columns,
        [
            [
                order,
                *(cell for star in stars for cell in (star[place].resultant, star[place].share)),
            ]
            for place, order in enumerate(orders_of(run).tolist())
        ],
        note="Amplitudes of the cylinders relative to the first mass; highlighted orders are major: all "
        "cylinders act together.",
        marks=["chosen" if np.any(np.isclose(order, majors)) else "" for order in orders_of(run)],
    )


def criticals_to_highest(run: EngineVibration) -> tuple[CriticalSpeed, ...]:
    """Return the critical speeds from half the lowest running speed to 120 % of the rated one."""
    engine, modes = run.engine_file.engine, run.torsional.chosen.modes
    ends = (0.5 * engine.lowest_speed, HIGHEST_SHARE * engine.rated_speed)
    return critical_speeds(modes.elastic_frequencies, orders_of(run), ends)


def critical_table(run: EngineVibration) -> Table:
    """Return the critical speeds up to 120 % of rated speed."""
    engine, rigid = run.engine_file.engine, run.torsional.chosen.modes.rigid
    criticals = criticals_to_highest(run)
    stars = {
        mode: mode_stars(run, rigid + mode) for mode in {critical.mode for critical in criticals}
    }
    places = {order: place for place, order in enumerate(orders_of(run).tolist())}
    majors = major_orders(orders_of(run), engine.firing_angles)
    rows = [
        [
            critical.speed,
            critical.speed / engine.rated_speed,
            critical.order,
            critical.mode + 1,
            60.0 * critical.frequency,
            stars[critical.mode][places[critical.order]].resultant,
        ]
        for critical in criticals
    ]
    return Table(
        f"Critical speeds up to {100.0 * HIGHEST_SHARE:g} % of the rated speed, without damping",
        [
            Column("speed", "1/min", decimals=2),
            Column("of rated speed", "%", decimals=1),
            Column("order", digits=None),
            Column("mode"),
            Column("vibrations per minute", decimals=2),
            Column("vector sum", decimals=4),
        ],
        rows,
        note="Highlighted: major orders, at which all cylinders act together.",
        marks=[
            "chosen" if np.any(np.isclose(critical.order, majors)) else "" for critical in criticals
        ],
    )


def major_judgment(run: EngineVibration) -> MajorCriticals:
    """Judge the major critical speeds as one class does."""
    engine = run.engine_file.engine
    return major_criticals(
        criticals_to_highest(run),
        engine.rated_speed,
        cylinders=engine.cylinders,
        strokes=engine.strokes,
        drives=engine.drives or "propeller",
    )


def major_sentences(run: EngineVibration) -> tuple[str, ...]:
    """State the finding of the rule on major critical speeds."""
    engine, judgment = run.engine_file.engine, major_judgment(run)
    orders = " and ".join(f"{order:g}" for order in judgment.orders)
    low, high = (f"{speed / engine.rated_speed:.2g}" for speed in judgment.clear)
    sentences = [
        f"No critical speed of a major order ({orders}) may be between {low} and {high} of the rated speed. "
        "Found: " + (f"{_told(run, judgment.found)}." if judgment.found else "none."),
        f"Rule: {MAJOR_SOURCE}; {MAJOR_READING}.",
    ]
    if engine.bank_angles is not None:
        sentences.append(
            "The rule names these orders for engines in line; for this V engine they are assumed to follow "
            "from the number of cylinders in the same way."
        )
    return tuple(sentences)


def _told(run: EngineVibration, criticals: Sequence[CriticalSpeed]) -> str:
    """Name critical speeds in the range, with the damping of their modes if known."""
    forced = run.forced_torsional
    damped = {
        critical.mode: critical.damping_ratio
        for critical in (() if forced is None else forced.resonances)
    }
    return ", ".join(
        f"order {critical.order:g} in mode {critical.mode + 1} at {critical.speed_rpm:.1f} 1/min"
        + (
            f" (a mode with {100.0 * damped[critical.mode + 1]:.3g} % of critical damping)"
            if critical.mode + 1 in damped
            else ""
        )
        for critical in criticals
    )


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


def found_value(reached: Reached) -> float | str:
    """Return a value, as a word where it is unbounded."""
    return UNBOUNDED if math.isinf(reached.value) else reached.value


def _judged(reached: Reached) -> list[float | str | None]:
    stated = not math.isinf(reached.permitted)
    return [found_value(reached), reached.speed, reached.used if stated else None]


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
            rows.append(
                [f"{number}", kind, *(None if math.isinf(stress) else stress for stress in values)]
            )
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
        reached = cases.failing[way][worst].kept[STRESS, name]
        largest = max(
            (firing.largest[STRESS, name] for firing in cases.failing[way].values()),
            key=lambda firing: firing.value,
        )
        permitted = None if math.isinf(reached.permitted) else reached.permitted
        rows.append(
            [
                number,
                name,
                found_value(cases.firing.largest[STRESS, name]),
                found_value(largest),
                largest.speed,
                f"{worst}",
                found_value(reached),
                reached.speed,
                permitted,
                None if permitted is None else reached.used,
            ]
        )
        marks.append("over" if reached.used > 1.0 else "")
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
            *(Column(f"cylinder {cylinder}", "%", 3, missing="-") for cylinder in numbers),
        ],
        [
            [
                number,
                name,
                *(
                    None if math.isinf(reached.permitted) else reached.used
                    for cylinder in numbers
                    for reached in (cases.failing[way][cylinder].kept[STRESS, name],)
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
            reached = cases.failing[way][worst].kept[TORQUE, name]
            row += [found_value(reached), reached.speed]
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
                barred.low,
                barred.high,
                "not judged" if barred.full_load else "yes" if barred.allowed else "no",
                "; ".join((*barred.refusals, barred.ends, *barred.remarks)),
            ]
            for barred in ranges
        ],
        marks=["" if barred.allowed else "over" for barred in ranges],
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
    curves = {"continuous limit": permitted_at(limit, cases.speeds)}
    if limit.passing is not None:
        curves["limit for passing"] = limit.passing.at(cases.speeds)
    return curves
