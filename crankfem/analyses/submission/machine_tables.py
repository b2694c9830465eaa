"""The class document's tables of the machine: engine, masses, shaft line, damper, propeller."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from crankbase.array_checks import ComplexArray, FloatArray
from crankbase.quantity import UNBOUNDED, format_quantity
from crankbase.table import Cell, Column, OutputUnit, Table
from crankfem.analyses.submission.firing_cases import (
    GEARS,
    GENERATOR,
    HIGHEST_SHARE,
    TORQUE,
    FiringCases,
    damper_places,
    heat_factors,
)
from crankfem.analyses.submission.mode_tables import MEGA_STIFFNESS, SPEED, found_value, orders_of
from crankfem.analyses.vibration.engine_excitation import engine_harmonics
from crankfem.analyses.vibration.engine_limits import COUPLING
from crankfem.analyses.vibration.misfiring import Reached
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.mechanism_file import (
    MechanismFile,
    curve_at,
    full_load_only,
    mechanism_of,
    pressure_maps,
)
from crankfem.files.sections.cylinder_pressures import LoadSection
from crankfem.files.sections.excitation_sections import gas_map_load
from crankfem.files.sections.limits_sections import LimitsInput
from dynamics.chains.chain import Chain
from dynamics.excitation.cylinders import cylinder_harmonics
from dynamics.indices import within


def damper_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return torque and heat of dampers and couplings with the permitted values; None without any."""
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
        for way, reached, heat in _each_way(cases, key, name):
            used = [
                value / limit
                for value, limit in (
                    (reached.value, permitted["torque"]),
                    (heat, permitted["heat"]),
                )
                if limit is not None and value is not None
            ]
            rows.append(
                [
                    name,
                    way,
                    found_value(reached),
                    reached.speed,
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
        note="Outside ranges to be barred; torque with all orders together, mean heat over the cycle. "
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
        heats = [case.heat[name][0] for case in failing.values() if name in case.heat]
        ways.append((way, failing[worst].kept[key, name], max(heats, default=None)))
    return ways


def gear_table(run: EngineVibration, cases: FiringCases) -> Table | None:
    """Return vibratory and mean torque of each gear; None without gears."""
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
            reached = cases.firing.kept[GEARS, name]
            rows.append(
                [name, reached.speed, None, found_value(reached), None, "mean torque not known"]
            )
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
        note="Torques on the driven wheel; the mean torque is that of the gas, without friction. Teeth "
        "separate where the vibratory torque exceeds the mean torque.",
        marks=marks,
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
    rated = float(cases.normal[GENERATOR].synthesis.amplitude[at_rated, 0])
    ways = [("normal, at rated speed", rated, float(cases.speeds[at_rated]))]
    for way, reached, _ in _each_way(cases, GENERATOR, node):
        ways.append((f"{way}, at running speeds", reached.value, reached.speed))
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
        "mechanical degrees; the whole motion counts, including rigid-body motion.",
        marks=["over" if limit is not None and angle > limit else "" for _, angle, _ in ways],
    )


# Loads of an engine of constant load at which its harmonics are told, as shares of full load.
LOADS = (0.25, 0.5, 0.75, 1.0)


def engine_data_table(run: EngineVibration) -> Table:
    """Return the data of the engine and its moving parts."""
    file, engine = run.engine_file, run.engine_file.engine
    load = run.load
    reciprocating = file.piston.mass + (file.rod.mass - file.rod.rotating_mass)
    rows = [
        ("engine", engine.name),
        ("drives", engine.drives or "not given: a propeller is assumed"),
        ("cylinders", f"{engine.cylinders} {'in line' if engine.bank_angles is None else 'in V'}"),
        ("strokes per cycle", f"{engine.strokes}"),
        ("firing order", "-".join(str(number) for number in engine.firing_order)),
        (
            "firing angles of the cylinders",
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
    ratios = chain.speed_ratios
    geared = bool(chain.gears)
    return Table(
        "Masses of the torsional chain",
        [
            Column("no."),
            Column("mass", words=True),
            Column("inertia", "kg m^2", digits=6),
            Column("damping to ground", "N m s/rad"),
            *([Column("speed ratio", decimals=4)] if geared else []),
        ],
        [
            [number, name, inertia, damping, *([ratio] if geared else [])]
            for number, (name, inertia, damping, ratio) in enumerate(
                zip(
                    chain.names,
                    chain.inertia.tolist(),
                    chain.ground_damping.tolist(),
                    ratios.tolist(),
                    strict=True,
                ),
                start=1,
            )
        ],
        note="The cranks carry their shares of rods and pistons."
        + (
            " Values are those of each shaft itself, not referred to the crankshaft."
            if geared
            else ""
        ),
    )


def chain_shaft_table(run: EngineVibration) -> Table:
    """Return the shafts of the torsional chain with their diameters, if known."""
    chain = run.torsional_chain
    diameters = _diameters(run)
    return Table(
        "Shafts of the torsional chain",
        [
            Column("shaft", words=True),
            Column("stiffness", MEGA_STIFFNESS, digits=6),
            Column("damping", "N m s/rad"),
            Column("loss factor"),
            Column("diameter for the stress", "mm", missing="-"),
        ],
        [
            [name, stiffness, damping, loss, diameters.get(name)]
            for name, stiffness, damping, loss in zip(
                chain.elements,
                chain.stiffness.tolist(),
                chain.damping.tolist(),
                chain.loss_factor.tolist(),
                strict=True,
            )
        ],
        note="For the crankshaft: the weaker of main journal and crankpin.",
    )


def _diameters(run: EngineVibration) -> dict[str, float]:
    """Outer diameters by which nominal stresses are calculated [m]."""
    file, forced = run.engine_file, run.forced_torsional
    diameters = {}
    if forced is not None and forced.stress is not None:
        for name in forced.stress.names:
            diameters[name] = min(
                min(throw.main_journal_diameter, throw.pin_diameter) for throw in file.crank_throws
            )
    for shaft in () if file.limits is None else file.limits.shafts:
        diameters[shaft.element] = shaft.diameter
    return diameters


def harmonics_by_load(run: EngineVibration) -> tuple[list[str], FloatArray, str]:
    """Return amplitudes of the tangential gas force by order at several loads, and these loads.

    Returns
    -------
    loads : list of str
        Description of each load.
    amplitudes : (K, m) array
        Over the area of the piston [Pa]; the last column is that of the moving masses at rated speed.
    note : str
    """
    file, mechanism = run.engine_file, mechanism_of(run.engine_file)
    assert run.load is not None
    rated = file.engine.rated_speed
    whole = engine_harmonics(file, mechanism, HIGHEST_SHARE)
    steady = file.gas_map is None and full_load_only(mechanism)
    if steady and mechanism.gas is not None and mechanism.gas.pressure_table is None:
        gas, means = _part_loads(run, mechanism)
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


def _part_loads(run: EngineVibration, mechanism: MechanismFile) -> tuple[ComplexArray, FloatArray]:
    """Phasors (K, m) of the gas force of cylinder 1 at part loads, and the mean indicated pressures [Pa].

    With a propeller's law, each load is that at the speed at which it reaches this share.
    """
    assert run.load is not None
    along = replace(mechanism, load=LoadSection(law="propeller"))
    speeds = mechanism.rated_speed * np.sqrt(LOADS)
    maps = pressure_maps(along, (float(speeds[0]), float(speeds[-1])))
    harmonics = cylinder_harmonics(
        mechanism.layout, orders_of(run), maps, inertia=False, throws=mechanism.throws
    )
    full = run.load.mean_pressure[-1]
    return harmonics.phasors(speeds)[1:, :, 0, 0], full * curve_at(along, speeds).mean_pressure


def harmonics_table(run: EngineVibration) -> Table:
    """Return the harmonics of the tangential force of one cylinder by load."""
    loads, amplitudes, note = harmonics_by_load(run)
    return Table(
        "Harmonics of the tangential force of cylinder 1 divided by the piston area: gas by load, moving "
        "masses",
        [Column("order", digits=None), *(Column(load, "MPa", digits=4) for load in loads)],
        [
            [order, *row]
            for order, row in zip(orders_of(run).tolist(), amplitudes.tolist(), strict=True)
        ],
        note=note,
    )
