"""Tables of the vibration of an engine or a chain on the command line, and a run's conclusions."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.quantity import RPM, UNBOUNDED
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.vibration.tables import (
    barred_within_error,
    critical_table,
    element_table,
    factor_range,
    limit_table,
    load_table,
    margin_table,
    misfiring_table,
    mode_table,
    resonance_table,
    run_up_table,
    source_table,
    speed_table,
    whole_critical_table,
    whole_table,
)
from crankfem.cli.console import number, print_line, print_notes, print_table
from crankfem.files.chain.chain_file import ChainFile
from crankfem.report.conclusions import conclusions, reached_and_permitted, verdict_line
from crankfem.report.summary import engine_facts, worst_of_each
from dynamics.wording import VERDICTS

if TYPE_CHECKING:
    from crankfem.analyses.strength.engine_strength import EngineStrength

NOT_FORCED = (
    "Amplitudes are not calculated, because the engine file gives no gas pressure: add [gas]."
)

CHAINS_USED = "the verdict uses lumped models (chains)"
CHAINS_ALONE = (
    "--coupled also holds the whole crankshaft against the limits where they are inadequate"
)


def print_run(record: Record, units: OutputUnits = SI) -> None:
    """Print an engine's vibration, the verdict last; critical speeds only where nothing is forced."""
    forced = record["forced"]
    print_line(units.text(record["firing"]))
    print_notes([f"{remark}." for remark in record["firing_remarks"]], units)
    if record["load"] is not None:
        print_load(record["load"], units)
    for kind in ("axial", "torsional"):
        chain = record[kind]
        print_table(mode_table(chain), units)
        if forced is None:
            print_table(critical_table(chain), units)
        sources = source_table(chain).select("source", "frequencies", "ratio to chosen")
        print_table(sources, units)
        print_notes([f"Not used: {remark}." for remark in chain["unusable"]], units)
        if forced is not None:
            _print_forced(forced[kind], units)
        if kind == "axial" and record["axial_force"] is not None:
            for line in record["axial_force"]["sentences"]:
                print_line(units.text(line))
    if record["whole"] is not None:
        _print_whole(record["whole"], units)
    for line in (record["bearings"] or {"sentences": ()})["sentences"]:
        print_line(units.text(line))
    count = len(record["assumed"])
    if count:
        counted = "1 value is" if count == 1 else f"{count} values are"
        print_line(f"{counted} assumed, not given; crankfem check lists them with their reasons.")
    if record["assessment"] is None:
        print_line(NOT_FORCED)
    else:
        print_assessment(record["assessment"], units)
        misfiring = record["misfiring"]
        if misfiring is not None:
            print_table(misfiring_table(misfiring, units), units)
        print_notes(
            filter(None, misfiring["remarks"] if misfiring else [record["misfiring_note"]]),
            units,
        )
        if record["whole"] is None:
            reason = record["not_comparable"]
            print_notes([f"{CHAINS_USED}; {reason or CHAINS_ALONE}"], units)
        print_judgment(record["assessment"], units)
        if misfiring is not None:
            print_line(units.text(f"Misfiring: {misfiring['sentence']}"))


def print_run_up(record: Record, units: OutputUnits = SI) -> None:
    """Print the largest torques of a run-up."""
    print_table(run_up_table(record, units), units)
    print_notes(record["notes"], units)


def print_load(record: Record, units: OutputUnits = SI) -> None:
    """Print power, the load as a function of the speed, and the load at some speeds if it varies."""
    for text in (record["rated"]["sentence"], record["sentence"]):
        print_line(units.text(f"{text[0].upper()}{text[1:]}."))
    if record["law"] != "constant":
        print_table(load_table(record), units)


def _print_forced(record: Record, units: OutputUnits) -> None:
    for line in (*record["damping"], *record["remarks"]):
        print_line(units.text(f"{record['kind'].capitalize()}: {line}"))
    print_table(resonance_table(record, units), units)
    print_table(element_table(record), units)


def _print_whole(record: Record, units: OutputUnits) -> None:
    length = units.of("um")
    print_table(whole_table(record), units)
    print_notes(record["remarks"], units)
    for kind in record["criticals"]:
        print_table(whole_critical_table(record, kind), units)
    for kind, chain in record["chains"].items():
        motion = units.of(MOTION[kind].printed)
        if chain["chain_amplitude"] is not None or chain["shaft_amplitude"] is not None:
            print_line(
                f"{kind.capitalize()} amplitude of the free end, largest at running speeds: chain "
                f"{motion.number(chain['chain_amplitude'])}, whole crankshaft "
                f"{motion.number(chain['shaft_amplitude'])} {motion.name}"
            )
        if chain["suffices"]:
            print_line(f"The {kind} chain is an adequate lumped model of the whole crankshaft.")
        else:
            reasons = " ".join(chain["reasons"])
            print_line(units.text(f"Lumped model inadequate ({kind} chain): {reasons}"))
    for difference in record["differences"]:
        print_line(f"{difference['sentence'][0].upper()}{difference['sentence'][1:]}.")
    if record["flywheel_tilt"] is not None:
        print_line(units.text(record["flywheel_tilt"]["sentence"]))
    split = record["axial_split"]
    if split is not None:
        causes = {
            "tangential": "tangential forces alone (torsion)",
            "radial": "radial forces alone",
            "both": "both",
        }
        words = [
            f"{length.number(split[name])} {length.name} by {cause} at "
            + units.text(f"{split[f'{name}_speed_rpm']:.0f} 1/min")
            for name, cause in causes.items()
        ]
        print_line(
            f"Axial amplitude of the free end, each at its own worst running speed: {', '.join(words)}"
        )


def print_assessment(record: Record, units: OutputUnits = SI) -> None:
    """Print what is uncertain, the limits, and what was assumed of them."""
    for kind, uncertain in record["uncertainty"].items():
        _print_uncertainty(kind, uncertain, units)
    for limit in dict.fromkeys(check["limit"] for check in record["checks"]):
        print_table(limit_table(record, limit, units), units)
    lowest, highest = record["running_rpm"]
    for limit in record["limits"]:
        assumed = ", assumed" if limit["assumed"] else ""
        end = limit["judged_to_rpm"]
        beyond = (
            f", because it also applies above the highest running speed of {highest:.4g} 1/min"
            if end > highest
            else ""
        )
        print_line(
            units.text(
                f"Limit on {limit['name']}: {limit['source']}{assumed}; judged from {lowest:.4g} to "
                f"{end:.4g} 1/min{beyond}."
            )
        )
    print_notes(record["remarks"], units)


def print_judgment(record: Record, units: OutputUnits = SI) -> None:
    """Print ranges of speed, the verdict with its reasons, what decides it, and how sure it is."""
    for passed in (*record["barred"], *record["started_through"]):
        # The verdict has the reasons of those that cannot be accepted.
        text = passed["sentence"] if passed["allowed"] else passed["shown"]
        print_line(units.text(f"Range {text}. Its ends: {passed['ends']}."))
    decision = record["decision"]
    if decision["status"] == "undecided":
        undecided = VERDICTS["undecided"].lower()
        print_line(units.text(f"Verdict: {undecided}, {decision['sentence']}."))
        print_line(units.text(f"With the values used: {record['sentence']}"))
    else:
        print_line(units.text(f"Verdict: {record['sentence']}"))
        if decision["sentence"]:
            print_line(
                units.text(f"It depends on assumed or uncertain values: {decision['sentence']}.")
            )
    for line in record["beside"]:
        print_line(units.text(line))


def _print_uncertainty(kind: str, record: Record, units: OutputUnits) -> None:
    for spread in record["spreads"]:
        print_line(f"{kind.capitalize()}: {spread['name']} {factor_range(spread)} the value used")
    if record["barred"]:
        print_line(units.text(f"{kind.capitalize()}: {barred_within_error(record['barred'])}."))
    print_table(margin_table(record, kind), units)
    drawn, motion = record["amplitudes"], units.of(MOTION[kind].printed)
    if drawn is not None:
        print_line(
            f"{kind.capitalize()} amplitude of the free end at running speeds: nominal "
            f"{motion.number(drawn['nominal'])} {motion.name}; of {drawn['samples']} random choices of the "
            f"uncertain values, 90 % give {motion.number(drawn['percentile_5'])} to "
            f"{motion.number(drawn['percentile_95'])} {motion.name}"
        )


# Modes and shares that tables show; records hold all.
MODES_SHOWN, LEAST_SHARE = 10, 0.01


def chain_record(read: ChainFile) -> Record:
    """Return nodes, elements, modes and energy shares, in SI units."""
    chain, modes = read.chain, read.chain.modes()
    return {
        "name": read.name,
        "kind": read.kind,
        "nodes": list(chain.names),
        "elements": list(chain.elements),
        "inertia": chain.inertia.tolist(),
        "stiffness": chain.stiffness.tolist(),
        "ground": chain.ground.tolist(),
        "modes": [
            {
                "name": modes.names[mode],
                "frequency": float(modes.frequencies[mode]),
                "rigid": mode < modes.rigid,
                "node_positions": list(modes.node_positions[mode]),
                "modal_inertia": float(modes.modal_inertia[mode]),
                "shape": modes.shapes[:, mode].tolist(),
                "kinetic_shares": dict(
                    zip(chain.names, modes.kinetic_shares[:, mode].tolist(), strict=True)
                ),
                "strain_shares": dict(
                    zip(modes.strain_names, modes.strain_shares[:, mode].tolist(), strict=True)
                ),
            }
            for mode in range(modes.frequencies.size)
        ],
        "sources": read.sources,
    }


def print_chain(record: Record, units: OutputUnits = SI) -> None:
    """Print the modes of a chain, with their largest energy shares."""
    print_table(
        Table.of_records(
            f"{record['name']}: {record['kind']} modes",
            record["modes"][:MODES_SHOWN],
            (Column("mode", words=True), "name"),
            (Column("frequency", "Hz", decimals=3), "frequency"),
            (Column("[1/min]", decimals=1), lambda mode: 60.0 * mode["frequency"]),
            (
                Column("nodes at", decimals=2, words=True),
                lambda mode: [1.0 + place for place in mode["node_positions"]],
            ),
            (Column("moves most", words=True), lambda mode: _largest(mode["kinetic_shares"])),
            (Column("strained most", words=True), lambda mode: _largest(mode["strain_shares"])),
            note="Nodes at 2.37 are at 37 % of element 2, counted from 1; shares are those of kinetic and of "
            "strain energy.",
        ),
        units,
    )
    for name, text in record["sources"].items():
        print_line(f"[{name}] {text}")


def _largest(shares: dict[str, float]) -> str:
    name = max(shares, key=lambda place: shares[place])
    share = shares[name]
    return (
        f"{name} {number(100.0 * share, 3)} %" if share > LEAST_SHARE and np.isfinite(share) else ""
    )


# Critical speeds of each kind; --verbose and the report show more.
SPEEDS_SHOWN = 2


def print_conclusions(results: RunResults, units: OutputUnits = SI) -> None:
    """Print the verdict of a run, its basis and its consequences."""
    print_verdict(results.vibration, results.strength, units)
    for line in conclusions(results):
        print_line(units.text(f"- {line}"))


def print_engine(results: RunResults, units: OutputUnits = SI) -> None:
    """Print what the engine is, in one line."""
    print_line(units.text(f"{results.engine['name']}: {'; '.join(engine_facts(results))}."))


def print_worst(vibration: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print limits, each at its worst location, and the worst critical speeds."""
    if vibration["assessment"] is not None:
        print_table(_limits(vibration["assessment"]["checks"], units), units, plain=True)
    speeds = speed_table(vibration, units, SPEEDS_SHOWN)
    shown = ["vibration", "speed", "order", "peak at", "amplitude", "kind"]
    if vibration["forced"] is None:
        shown = ["vibration", "speed", "order", "mode", "phase sum"]
    known = [column.name for column in speeds.columns]  # without peaks there are no amplitudes
    if speeds.rows:
        columns = speeds.select(*(name for name in shown if name in known))
        print_table(replace(columns, note=""), units, plain=True)


def print_verdict(
    vibration: Mapping[str, Any], strength: "EngineStrength | None", units: OutputUnits = SI
) -> None:
    """Print the verdict of a run in one line."""
    print_line(units.text(verdict_line(vibration, strength)))


def _limits(checks: list[dict[str, Any]], units: OutputUnits) -> Table:
    return Table.of_records(
        "Limits, each at its worst location and running speed",
        worst_of_each(checks),
        (
            Column("limit", words=True),
            lambda check: check["limit"].removesuffix(f" of {check['place']}"),
        ),
        (Column("where", words=True), "place"),
        (Column("at", "1/min", decimals=1), lambda check: check["speed_rpm"] / RPM),
        (Column("reached"), lambda check: units.text(reached_and_permitted(check)[0])),
        (Column("permitted"), lambda check: units.text(reached_and_permitted(check)[1])),
        (Column("used", "%", 3, missing=UNBOUNDED), "used"),
    )
