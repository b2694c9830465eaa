"""The class document's tables: machine, modes and critical speeds, stresses, dampers, gears, generator."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from crankbase.array_checks import Array, ComplexArray
from crankbase.quantity import UNBOUNDED, format_quantity, percent
from crankbase.summaries import frozen
from crankbase.table import Cell, Column, OutputUnit, Table
from crankfem.analyses.engine_mechanism import (
    curve_at,
    full_load_only,
    pressure_maps,
)
from crankfem.analyses.vibration.engine_excitation import engine_harmonics
from crankfem.analyses.vibration.engine_limits import coupling_of
from crankfem.analyses.vibration.misfiring import Reached
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.mechanism_cylinders import order_named
from crankfem.files.sections.excitation_sections import gas_map_load
from crankfem.files.sections.limits_sections import LimitsInput
from crankfem.files.sections.mechanism_sections import LoadSection
from crankfem.satellites.class_document.firing_cases import (
    GEARS,
    GENERATOR,
    HIGHEST_SHARE,
    MEANING,
    STRESS,
    TORQUE,
    FiringCases,
    damper_places,
    heat_factors,
    limit_of,
)
from dynamics.assessment.separation import MAJOR_READING, MAJOR_SOURCE, major_criticals
from dynamics.assessment.verdict import Verdict
from dynamics.chains.chain import Chain
from dynamics.chains.chain_modes import Modes
from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders, major_orders
from dynamics.excitation.cylinders import cylinder_harmonics
from dynamics.indices import within
from dynamics.torque import Star, star_diagram

MEGA_STIFFNESS = OutputUnit("MN m/rad", 1e6)
DEGREES = OutputUnit("deg", math.pi / 180.0)
# Modes that are shown at least, and at most.
LEAST_MODES, MOST_MODES = 3, 6
# The amplitude to which Holzer tables are scaled [rad].
UNIT_AMPLITUDE = 1e-3
# Sums of torques below this share of the largest one are zero.
ROUND_OFF = 1e-9
SPEED = Column("at", "1/min", decimals=1)
NAME, INERTIA = Column("mass", words=True), Column("inertia", "kg m^2", digits=6)
SHAFT, SHAFT_STIFFNESS = Column("shaft", words=True), Column("stiffness", MEGA_STIFFNESS, digits=6)
ORDER, NUMBER = Column("order", digits=None), Column("no.")
USED = Column("used", "%", 3, missing="-")
STRESSES = "MPa"
# Columns of places that a table has at most; more of them go to another one.
PLACES_SHOWN = 7
# Loads of an engine of constant load at which its harmonics are told, as shares of full load.
LOADS = (0.25, 0.5, 0.75, 1.0)
# A column of a table with its cells.
Filled = tuple[Column, Iterable[Any]]


def _marks(word: str, flags: Iterable[Any]) -> list[str]:
    return [word if flag else "" for flag in flags]


def _largest(
    name: str, unit: str, reached: Iterable[Reached | None], missing: str = "none"
) -> list[Filled]:
    """Return the column of values, and that of their speeds."""
    listed = list(reached)
    return [
        (Column(name, unit, missing=missing), [_value(worst) for worst in listed]),
        (
            replace(SPEED, missing=missing),
            [None if worst is None else worst.speed for worst in listed],
        ),
    ]


def _value(reached: Reached | None) -> float | str | None:
    return None if reached is None else _finite(reached.value)


def _finite(value: float) -> float | str:
    return UNBOUNDED if math.isinf(value) else value


def _used(reached: Reached | None) -> float | None:
    return None if reached is None or math.isinf(reached.permitted) else reached.used


def engine_data_table(run: EngineVibration) -> Table:
    """Return the data of the engine and its moving parts."""
    file, engine = run.engine_file, run.engine_file.engine
    load = run.load
    reciprocating = file.piston.mass + (file.rod.mass - file.rod.rotating_mass)
    rows = [
        ("engine", engine.name),
        ("driven by", engine.driven_by)
        if engine.driven_by
        else ("drives", engine.drives or "not given: a propeller is assumed"),
        ("cylinders", f"{engine.cylinders} {'in line' if engine.bank_angles is None else 'in V'}"),
        ("strokes per cycle", f"{engine.strokes}"),
        (order_named(engine.driven_by), "-".join(map(str, engine.top_order))),
        (
            f"{'angles at the top' if engine.driven_by else 'firing angles'} of the cylinders",
            ", ".join(f"{angle:g}" for angle in np.round(np.degrees(engine.firing_angles), 3))
            + " deg",
        ),
        ("bore", format_quantity(engine.bore, "m")),
        ("stroke", format_quantity(engine.stroke, "m")),
        ("length of the connecting rod", format_quantity(file.rod.length, "m")),
        ("reciprocating mass of each cylinder", format_quantity(reciprocating, "kg", 5)),
        ("rated speed", format_quantity(engine.rated_speed, "rad/s", 5)),
        (
            "running range",
            f"{format_quantity(engine.lowest_speed, 'rad/s', 5)} to "
            f"{format_quantity(engine.highest_speed, 'rad/s', 5)}",
        ),
        (
            "rated power",
            "not given" if engine.rated_power is None else format_quantity(engine.rated_power, "W"),
        ),
        ("load over the speed", "not told" if load is None else load.sentence.rstrip(".")),
        (
            "main journals and pins",
            ", ".join(
                f"{format_quantity(throw.main_journal_diameter, 'm')} and "
                f"{format_quantity(throw.pin_diameter, 'm')}"
                for throw in dict.fromkeys(file.crank_throws)
            ),
        ),
        (
            "torsional damping",
            "; ".join(() if run.forced_torsional is None else run.forced_torsional.damping),
        ),
    ]
    return Table(
        "Engine",
        [Column("what", words=True), Column("value", words=True)],
        [list(row) for row in rows],
    )


def chain_mass_table(chain: Chain) -> Table:
    """Return the masses of the torsional chain."""
    geared = bool(chain.gears)
    return Table.of_columns(
        "Masses of the torsional chain",
        (NUMBER, range(1, len(chain.names) + 1)),
        (NAME, chain.names),
        (INERTIA, chain.inertia),
        (Column("damping to ground", "N m s/rad"), chain.ground_damping),
        *([(Column("speed ratio", decimals=4), chain.speed_ratios)] if geared else []),
        note="The cranks carry their shares of rods and pistons."
        + (
            " Values are those of each shaft itself, not referred to the crankshaft."
            if geared
            else ""
        ),
    )


def chain_shaft_table(run: EngineVibration) -> Table:
    """Return the shafts of the torsional chain with their diameters, if known."""
    chain, file, forced = run.torsional_chain, run.engine_file, run.forced_torsional
    crankshaft = min(
        min(throw.main_journal_diameter, throw.pin_diameter) for throw in file.crank_throws
    )
    stressed = () if forced is None or forced.stress is None else forced.stress.names
    diameters = dict.fromkeys(stressed, crankshaft)
    for shaft in () if file.limits is None else file.limits.shafts:
        diameters[shaft.element] = shaft.diameter
    return Table.of_columns(
        "Shafts of the torsional chain",
        (SHAFT, chain.elements),
        (SHAFT_STIFFNESS, chain.stiffness),
        (Column("damping", "N m s/rad"), chain.damping),
        (Column("loss factor"), chain.loss_factor),
        (Column("diameter for the stress", "mm", missing="-"), map(diameters.get, chain.elements)),
        note="For the crankshaft: the weaker of main journal and crankpin.",
    )


def harmonics_by_load(run: EngineVibration) -> tuple[list[str], Array, str]:
    """Return amplitudes of the tangential gas force by order at several loads, and these loads.

    Returns
    -------
    loads : list of str
        Description of each load.
    amplitudes : (K, m) array
        Over the area of the piston [Pa]; the last column is that of the moving masses at rated speed.
    note : str
    """
    file = run.engine_file
    assert run.load is not None
    rated = file.engine.rated_speed
    whole = engine_harmonics(file, HIGHEST_SHARE)
    steady = file.gas_map is None and full_load_only(file)
    by_cycle = file.gas is not None and file.gas.pressure_table is None
    if steady and by_cycle and not file.engine.driven_by:
        gas, means = _part_loads(run)
        loads = [
            f"{100.0 * share:g} %, {mean / 1e6:.3g} MPa"
            for share, mean in zip(LOADS, means.tolist(), strict=True)
        ]
        note = (
            "Loads are shares of the brake mean effective pressure at rated speed, with mean indicated "
            "pressures. Boost at part load is proportional to the power, as for a propeller."
        )
    else:
        listed = [run.load.speeds.tolist()[-1]] if steady else run.load.speeds.tolist()
        speeds = np.array(listed)
        law = None if file.gas_map is None else gas_map_load(file.gas_map, rated)
        alone = replace(whole, inertia=np.zeros_like(whole.inertia))
        gas = alone.phasors(speeds, law)[1:, :, 0, 0]
        means = run.load.mean_pressure[-speeds.size :]
        loads = [
            f"{mean / 1e6:.3g} MPa at {format_quantity(speed, 'rad/s', 4)}"
            for speed, mean in zip(speeds.tolist(), means.tolist(), strict=True)
        ]
        note = "Mean indicated pressures of the load at these speeds." + (
            " One diagram serves all speeds." if steady else ""
        )
    masses = rated**2 * whole.inertia[1:, 0, 0]
    area = np.pi / 4.0 * file.engine.bore**2
    return (
        [*loads, "moving masses at rated speed"],
        np.abs(np.column_stack((gas, masses))) / area,
        note,
    )


def _part_loads(run: EngineVibration) -> tuple[ComplexArray, Array]:
    """Phasors (K, m) of the gas force of cylinder 1 at part loads, and the mean indicated pressures [Pa].

    With a propeller's law, each load is that at the speed at which it reaches this share.
    """
    assert run.load is not None
    along = run.engine_file.changed(load=LoadSection(law="propeller"))
    speeds = along.engine.rated_speed * np.sqrt(LOADS)
    maps = pressure_maps(along, (float(speeds[0]), float(speeds[-1])))
    harmonics = cylinder_harmonics(
        along.layout, orders_of(run), maps, inertia=False, throws=along.throws
    )
    full = run.load.mean_pressure[-1]
    return harmonics.phasors(speeds)[1:, :, 0, 0], full * curve_at(along, speeds).mean_pressure


def harmonics_table(run: EngineVibration) -> Table:
    """Return the harmonics of the tangential force of one cylinder by load."""
    loads, amplitudes, note = harmonics_by_load(run)
    return Table.of_columns(
        "Harmonics of the tangential force of cylinder 1 divided by the piston area: gas by load, moving "
        "masses",
        (ORDER, orders_of(run)),
        *((Column(load, "MPa"), row) for load, row in zip(loads, amplitudes.T, strict=True)),
        note=note,
    )


@frozen("frequency [Hz]", "modal_inertia [kg m^2]", "amplitude", eq=False)
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
    amplitude: Array
    inertia_torque: Array
    torque: Array
    ground: Array
    modal_inertia: float
    kinetic_shares: Array
    strain_shares: Array


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
    modes = run.torsional.chosen.modes
    elastic = range(modes.rigid, len(modes.frequencies))
    holzers = [holzer_table(run.torsional_chain, modes, number) for number in elastic]
    return Table.of_columns(
        "Natural frequencies, without damping",
        (Column("mode"), range(1, len(holzers) + 1)),
        (Column("frequency", "Hz", decimals=3), [holzer.frequency for holzer in holzers]),
        (
            Column("vibrations per minute", decimals=2),
            [60.0 * holzer.frequency for holzer in holzers],
        ),
        (
            Column("modal inertia, referred to the first mass", "kg m^2"),
            [holzer.modal_inertia for holzer in holzers],
        ),
        (Column("nodes"), [len(modes.node_positions[number]) for number in elastic]),
    )


def mass_table(chain: Chain, holzer: HolzerTable, number: int) -> Table:
    """Return the masses of a Holzer table."""
    sums = np.cumsum(holzer.inertia_torque)
    sums[np.abs(sums) < ROUND_OFF * np.max(np.abs(holzer.inertia_torque))] = 0.0
    return Table.of_columns(
        f"Mode {number}, {60.0 * holzer.frequency:.2f} vibrations per minute "
        f"({holzer.frequency:.3f} Hz): masses",
        (NUMBER, range(1, len(chain.names) + 1)),
        (NAME, chain.names),
        (INERTIA, chain.inertia),
        (Column("relative amplitude", decimals=5), holzer.amplitude),
        (Column("inertia torque", "kN m"), holzer.inertia_torque),
        (Column("their sum so far", "kN m"), sums),
        (Column("kinetic energy", "%", decimals=2), holzer.kinetic_shares),
        note=f"Torques at an amplitude of 1 mrad of {chain.names[0]}; modal inertia referred to it "
        f"{holzer.modal_inertia:.5g} kg m^2.",
    )


def shaft_table(chain: Chain, holzer: HolzerTable, number: int) -> Table:
    """Return the shafts of a Holzer table."""
    return Table.of_columns(
        f"Mode {number}: shafts",
        (SHAFT, chain.elements),
        (SHAFT_STIFFNESS, chain.stiffness),
        (Column("relative twist", decimals=5), chain.elongations() @ holzer.amplitude),
        (Column("torque", "kN m"), holzer.torque),
        (Column("strain energy", "%", decimals=2), holzer.strain_shares),
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


def orders_of(run: EngineVibration) -> Array:
    """Return the orders of the engine up to the highest of its file."""
    file = run.engine_file
    return engine_orders(file.engine.strokes, file.vibration.highest_order)


def _major(run: EngineVibration, orders: Sequence[float] | Array) -> list[str]:
    """Return the marks of orders, of which the major ones are highlighted."""
    majors = major_orders(orders_of(run), run.engine_file.engine.firing_angles)
    return _marks("chosen", [np.any(np.isclose(order, majors)) for order in orders])


def vector_table(run: EngineVibration) -> Table:
    """Return the vector sums of all orders in the modes that are shown."""
    rigid, orders = run.torsional.chosen.modes.rigid, orders_of(run)
    columns: list[Filled] = []
    for mode in shown_modes(run):
        stars = mode_stars(run, mode)
        columns += [
            (Column(f"mode {mode - rigid + 1}", decimals=4), [star.resultant for star in stars]),
            (Column("", "%", decimals=1), [star.share for star in stars]),
        ]
    return Table.of_columns(
        "Vector sums by order and mode, and their share of the largest possible sum",
        (ORDER, orders),
        *columns,
        note="Amplitudes of the cylinders relative to the first mass; highlighted orders are major: all "
        "cylinders act together.",
        marks=_major(run, orders),
    )


def criticals_to_highest(run: EngineVibration) -> tuple[CriticalSpeed, ...]:
    """Return the critical speeds from half the lowest running speed to 120 % of the rated one."""
    engine, modes = run.engine_file.engine, run.torsional.chosen.modes
    ends = (0.5 * engine.lowest_speed, HIGHEST_SHARE * engine.rated_speed)
    return critical_speeds(modes.elastic_frequencies, orders_of(run), ends)


def critical_table(run: EngineVibration) -> Table:
    """Return the critical speeds up to 120 % of rated speed."""
    rated, rigid = run.engine_file.engine.rated_speed, run.torsional.chosen.modes.rigid
    criticals = criticals_to_highest(run)
    sums = {
        (mode, star.order): star.resultant
        for mode in {critical.mode for critical in criticals}
        for star in mode_stars(run, rigid + mode)
    }
    return Table.of_columns(
        f"Critical speeds up to {100.0 * HIGHEST_SHARE:g} % of the rated speed, without damping",
        (Column("speed", "1/min", decimals=2), [critical.speed for critical in criticals]),
        (
            Column("of rated speed", "%", decimals=1),
            [critical.speed / rated for critical in criticals],
        ),
        (ORDER, [critical.order for critical in criticals]),
        (Column("mode"), [critical.mode + 1 for critical in criticals]),
        (
            Column("vibrations per minute", decimals=2),
            [60.0 * critical.frequency for critical in criticals],
        ),
        (
            Column("vector sum", decimals=4),
            [sums[critical.mode, critical.order] for critical in criticals],
        ),
        note="Highlighted: major orders, at which all cylinders act together.",
        marks=_major(run, [critical.order for critical in criticals]),
    )


def major_sentences(run: EngineVibration) -> tuple[str, ...]:
    """State the finding of the rule of one class on major critical speeds."""
    engine, forced = run.engine_file.engine, run.forced_torsional
    if engine.driven_by:
        return (
            "No rule on major critical speeds is applied: those of classes are for engines, not for a "
            "machine that is driven.",
        )
    judgment = major_criticals(
        criticals_to_highest(run),
        engine.rated_speed,
        cylinders=engine.cylinders,
        strokes=engine.strokes,
        drives=engine.drives or "propeller",
    )
    damped = {
        critical.mode: critical.damping_ratio
        for critical in (() if forced is None else forced.resonances)
    }
    listed = ", ".join(
        f"order {critical.order:g} in mode {critical.mode + 1} at {critical.speed_rpm:.1f} 1/min"
        + (
            f" (a mode with {percent(damped[critical.mode + 1], 3)} % of critical damping)"
            if critical.mode + 1 in damped
            else ""
        )
        for critical in judgment.criticals
    )
    orders = " and ".join(f"{order:g}" for order in judgment.orders)
    low, high = (f"{speed / engine.rated_speed:.2g}" for speed in judgment.clear)
    sentences = [
        f"No critical speed of a major order ({orders}) may be between {low} and {high} of the rated speed. "
        f"Found: {listed or 'none'}.",
        f"Rule: {MAJOR_SOURCE}; {MAJOR_READING}.",
    ]
    if engine.bank_angles is not None:
        sentences.append(
            "The rule names these orders for engines in line; for this V engine they are assumed to follow "
            "from the number of cylinders in the same way."
        )
    return tuple(sentences)


def place_numbers(cases: FiringCases) -> dict[str, int]:
    """Return the numbers of the locations of stress in wide tables, from 1."""
    return {name: number for number, name in enumerate(cases.normal[STRESS].names, start=1)}


def _shafts(cases: FiringCases) -> list[Filled]:
    numbers = place_numbers(cases)
    return [(NUMBER, numbers.values()), (SHAFT, numbers)]


def normal_table(cases: FiringCases) -> Table:
    """Return the synthesized stress of each location in normal firing, with its limits."""
    firing, names = cases.firing, cases.normal[STRESS].names
    kept = [firing.kept[STRESS, name] for name in names]
    passed = [firing.passed.get((STRESS, name)) for name in names]
    return Table.of_columns(
        "Normal running: synthesized torsional stress",
        *_shafts(cases),
        *_largest("largest", STRESSES, [firing.largest[STRESS, name] for name in names]),
        *_largest("kept", STRESSES, kept),
        (Column("used", "%", 3), map(_used, kept)),
        *_largest("passed", STRESSES, passed, "-"),
        (USED, map(_used, passed)),
        note="Nominal stress amplitude (half the range over the cycle), all orders together. Largest: at "
        "any calculated speed. Kept: largest use of the continuous limit at running speeds outside ranges "
        "to be barred. Passed: largest use of the limit for passing within these ranges.",
        marks=_marks(
            "over",
            [
                max(kept.used, 0.0 if passing is None else passing.used) > 1.0
                for kept, passing in zip(kept, passed, strict=True)
            ],
        ),
    )


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
    series, numbers = cases.normal[STRESS], list(place_numbers(cases).values())
    parts = -(-len(numbers) // PLACES_SHOWN)
    tables = []
    for start, end in pairwise(round(part * len(numbers) / parts) for part in range(parts + 1)):
        columns: list[Filled] = [(ORDER, series.orders)]
        for number in numbers[start:end]:
            stress = series.amplitude[:, :, number - 1]
            columns += [
                (
                    Column(f"no. {number}", STRESSES, digits=3),
                    [UNBOUNDED if math.isinf(most) else most for most in np.max(stress, axis=1)],
                ),
                (SPEED, cases.speeds[np.argmax(stress, axis=1)]),
            ]
        tables.append(
            Table.of_columns(
                "Normal running: largest torsional stress by order, and its speed",
                *columns,
                note="Amplitudes of single orders up to the highest speed calculated; shafts by number.",
            )
        )
    return tables


def failing_table(cases: FiringCases, way: str) -> Table:
    """Return the worst case of one cylinder failing for each location, and normal firing."""
    names = cases.normal[STRESS].names
    kept = [cases.worst(way, STRESS, name) for name in names]
    largest = [
        max(
            (firing.largest[STRESS, name] for firing in cases.failing[way].values()),
            key=lambda reached: reached.value,
        )
        for name in names
    ]
    return Table.of_columns(
        f"{way.capitalize()}: the worst of all cylinders",
        *_shafts(cases),
        (
            Column("normal", STRESSES),
            [_value(cases.firing.largest[STRESS, name]) for name in names],
        ),
        *_largest("largest", STRESSES, largest),
        (
            Column("worst cylinder"),
            [str(cases.worst_cylinder(way, STRESS, name)) for name in names],
        ),
        *_largest("kept", STRESSES, kept),
        (
            Column("permitted", STRESSES, missing="-"),
            [None if math.isinf(worst.permitted) else worst.permitted for worst in kept],
        ),
        (USED, map(_used, kept)),
        note=f"{MEANING[way][0].upper()}{MEANING[way][1:]}; the others work as before, at the speeds of "
        "normal running. Compared with the continuous limit, or with that for passing where it serves while "
        "a cylinder fails, outside ranges to be barred.",
        marks=_marks("over", [worst.used > 1.0 for worst in kept]),
    )


def each_table(cases: FiringCases, way: str) -> Table:
    """Return the stress of each location with each cylinder failing."""
    return Table.of_columns(
        f"{way.capitalize()}: largest use of the limit, cylinder by cylinder",
        *_shafts(cases),
        *(
            (
                Column(f"cylinder {cylinder}", "%", 3, missing="-"),
                [_used(firing.kept[STRESS, name]) for name in cases.normal[STRESS].names],
            )
            for cylinder, firing in sorted(cases.failing[way].items())
        ),
    )


def torque_table(cases: FiringCases) -> Table:
    """Return the vibratory torque of each element in all cases of firing."""
    names = cases.normal[TORQUE].names
    columns = _largest(
        "normal running", "kN m", [cases.firing.kept[TORQUE, name] for name in names]
    )
    for way in cases.failing:
        columns += _largest(way, "kN m", [cases.worst(way, TORQUE, name) for name in names])
    return Table.of_columns(
        "Vibratory torque in every shaft, synthesized: largest at running speeds that are not to be barred",
        (SHAFT, names),
        *columns,
        note="With a cylinder failing: the worst of all cylinders.",
    )


def barred_table(verdict: Verdict) -> Table:
    """Return the speed ranges to be barred, and the remarks on passing them."""
    ranges = (*verdict.started_through, *verdict.barred)
    return Table.of_columns(
        "Speed ranges to be barred, or passed on starting",
        (Column("from", "1/min", decimals=2), [barred.low for barred in ranges]),
        (Column("to", "1/min", decimals=2), [barred.high for barred in ranges]),
        (
            Column("may be passed", words=True),
            [
                "not judged" if barred.full_load else "yes" if barred.allowed else "no"
                for barred in ranges
            ],
        ),
        (
            Column("why, and where it ends", words=True),
            ["; ".join((*barred.refusals, barred.ends, *barred.remarks)) for barred in ranges],
        ),
        marks=_marks("over", [not barred.allowed for barred in ranges]),
    )


def limit_source_table(cases: FiringCases) -> Table:
    """Return the source of each limit."""
    limits = {limit.name: limit for limit in cases.limits.values()}
    return Table.of_columns(
        "Limits and their sources",
        (Column("limit", words=True), limits),
        (
            Column("source", words=True),
            [("assumed: " if each.assumed else "") + each.source for each in limits.values()],
        ),
        (Column("remark", words=True), [each.remark or "-" for each in limits.values()]),
    )


def axial_limit_table(run: EngineVibration) -> Table | None:
    """Return the use of each limit of the axial vibration, which the verdict has too; None without any."""
    assert run.assessment is not None
    axial = {limit.name for limit in run.assessment.judged_limits if limit.kind == "axial"}
    checks = [check for check in run.assessment.verdict.checks if check.limit.name in axial]
    if not checks:
        return None
    return Table(
        "Axial vibration: use of its limits",
        [Column("limit", words=True), Column("place", words=True), SPEED, USED],
        [
            [check.limit.name, check.place, check.worst_speed, _finite(check.used)]
            for check in checks
        ],
        marks=_marks("over", [not check.passed for check in checks]),
    )


def damper_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return torque and heat of dampers and couplings with the permitted values; None without any."""
    chain, limits = run.torsional_chain, run.engine_file.limits or LimitsInput()
    dampers = damper_places(chain)
    places = dict.fromkeys([*dampers, *heat_factors(chain)])
    permitted = {
        coupling_of(run.engine_file.engine): (limits.coupling_torque, limits.coupling_heat)
    }
    permitted |= {part.element: (part.torque, part.heat) for part in limits.elements}
    places |= {(TORQUE, name): None for name in permitted if name in chain.elements}
    of_damper = limits.damper_torque, limits.damper_heat
    rows: list[list[Cell]] = []
    for key, name in places:
        unlimited = of_damper if (key, name) in dampers else (None, None)
        torque_limit, heat_limit = permitted.get(name, unlimited)
        for way, reached, heat in _each_way(cases, key, name):
            used = [
                value / limit
                for value, limit in ((reached.value, torque_limit), (heat, heat_limit))
                if limit is not None and value is not None
            ]
            most = max(used, default=None)
            torque = (_value(reached), reached.speed, torque_limit)
            rows.append([name, way, *torque, heat, heat_limit, most])
    if not rows:
        return None
    return Table(
        "Dampers, couplings and shafts with damping: vibratory torque and heat at running speeds",
        [
            Column("part", words=True),
            Column("case", words=True),
            Column("torque", "kN m"),
            SPEED,
            Column("permitted", "kN m", missing="not given"),
            Column("heat", "kW", missing="none"),
            Column("permitted", "kW", missing="not given"),
            USED,
        ],
        rows,
        note="Outside ranges to be barred; torque with all orders together, mean heat over the cycle. "
        "Permitted values are the maker's: damper_torque, damper_heat, coupling_torque, coupling_heat of "
        "[limits], and [[limits.elements]].",
        marks=_marks("over", [isinstance(row[-1], float) and row[-1] > 1.0 for row in rows]),
    )


def _each_way(cases: FiringCases, key: str, name: str) -> list[tuple[str, Reached, float | None]]:
    """Return the worst of a location and its heat, firing normally and with each way of failing."""
    ways = [("normal", cases.firing.kept[key, name], cases.firing.heat.get(name, (None,))[0])]
    for way, failing in cases.failing.items():
        heats = [case.heat[name][0] for case in failing.values() if name in case.heat]
        ways.append((way, cases.worst(way, key, name), max(heats, default=None)))
    return ways


def gear_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return vibratory and mean torque of each gear; None without gears."""
    if GEARS not in cases.normal:
        return None
    engine, gears = run.engine_file.engine, run.torsional_chain.gears
    series, speeds = cases.normal[GEARS], cases.speeds
    running = within(speeds, engine.lowest_speed, engine.highest_speed)
    # One gear passes all of the mean torque on; of several the file does not tell which share.
    mean = np.abs(cases.mean_torque / gears[0].ratio) if len(gears) == 1 else None
    rows: list[list[Cell]] = []
    for place, name in enumerate(series.names):
        if mean is None:
            reached = cases.firing.kept[GEARS, name]
            rows.append([name, reached.speed, None, _value(reached), None, "mean torque not known"])
            continue
        amplitude = series.synthesis.amplitude[:, place]
        share = np.where(running, amplitude / mean, 0.0)
        worst = int(np.argmax(share))
        numbers = [float(values[worst]) for values in (speeds, mean, amplitude, share)]
        rows.append(
            [name, *numbers, "teeth part" if share[worst] > 1.0 else "teeth stay in contact"]
        )
    return Table(
        "Gears in normal running: worst running speed",
        [
            Column("gear", words=True),
            SPEED,
            Column("mean torque", "kN m", missing="-"),
            Column("vibratory torque", "kN m"),
            Column("share", "%", 3, missing="-"),
            Column("gear hammer", words=True),
        ],
        rows,
        note="Torques on the driven wheel; the mean torque is that of the gas, without friction. Teeth "
        "separate where the vibratory torque exceeds the mean torque.",
        marks=_marks("over", [row[-1] == "teeth part" for row in rows]),
    )


def generator_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return the electrical angle of the generator's rotor; None without its number of poles."""
    if GENERATOR not in cases.normal:
        return None
    engine = run.engine_file.engine
    assert engine.generator_poles is not None
    limit = (run.engine_file.limits or LimitsInput()).generator_angle
    (node,) = cases.normal[GENERATOR].names
    at_rated = int(np.argmin(np.abs(cases.speeds - engine.rated_speed)))
    each = _each_way(cases, GENERATOR, node)
    angles = [float(cases.normal[GENERATOR].synthesis.amplitude[at_rated, 0])]
    angles += [reached.value for _, reached, _ in each]
    return Table.of_columns(
        f"Oscillation of the generator's rotor ({node})",
        (
            Column("firing", words=True),
            ["normal, at rated speed", *(f"{way}, at running speeds" for way, *_ in each)],
        ),
        (SPEED, [cases.speeds[at_rated], *(reached.speed for _, reached, _ in each)]),
        (
            Column("mechanical amplitude", DEGREES),
            [2.0 * angle / engine.generator_poles for angle in angles],
        ),
        (
            Column("electrical angle", DEGREES),
            [UNBOUNDED if math.isinf(angle) else angle for angle in angles],
        ),
        (Column("permitted", DEGREES, missing="not given"), [limit] * len(angles)),
        (USED, [None if limit is None else angle / limit for angle in angles]),
        note=f"{engine.generator_poles} poles: an electrical degree is {2.0 / engine.generator_poles:.4g} "
        "mechanical degrees; the whole motion counts, including rigid-body motion.",
        marks=_marks("over", [limit is not None and angle > limit for angle in angles]),
    )
