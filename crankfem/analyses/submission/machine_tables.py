"""Dampers, couplings, gears and the generator in all cases of firing, as tables."""

import math
from collections.abc import Sequence

import numpy as np

from crankbase.tables.table import Cell, Column, OutputUnit, Table
from crankbase.units.units import UNBOUNDED
from crankfem.analyses.submission.firing_cases import (
    GEARS,
    GENERATOR,
    TORQUE,
    FiringCases,
    damper_places,
    heat_factors,
)
from crankfem.analyses.submission.stress_tables import SPEED, found_value
from crankfem.analyses.vibration.engine_limits import COUPLING
from crankfem.analyses.vibration.misfiring import Reached
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.sections.limits_sections import LimitsInput
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
                    found_value(found),
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
        own = [one.heat[name][0] for one in failing.values() if name in one.heat]
        ways.append((way, failing[worst].kept[key, name], max(own, default=None)))
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
            found = cases.firing.kept[GEARS, name]
            rows.append(
                [name, found.speed, None, found_value(found), None, "mean torque not known"]
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
        "mechanical degrees; the whole motion counts, including rigid-body motion.",
        marks=["over" if limit is not None and angle > limit else "" for _, angle, _ in ways],
    )
