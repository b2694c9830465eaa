"""The tables of an engine's vibration, from its plain records: the command line and the report show them."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any

from crankbase.quantity import RPM, UNBOUNDED
from crankbase.table import SI, Cell, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.shaft.chains import MOTION
from dynamics.assessment.wording import limit_at
from dynamics.chains.engine_chains import FREE_END
from dynamics.response.damped_criticals import LEAST_PEAK

# What a table shows; files hold everything.
ROWS_SHOWN = 12
# Resultant of the cylinders on a mode shape from which they count as acting together.
TOGETHER = 0.5
# Quantities of which there is one place, which they name.
LONE_PLACE = ("free end", "torsional damper", "coupling")
# Units in which loads are printed.
LOAD = {"torsional": "kN m", "axial": "kN"}
SPEED = Column("speed", "1/min", decimals=1)
FREQUENCY = Column("frequency", "Hz", decimals=2)


def load_table(record: Record) -> Table:
    """Return the load at some speeds, from the `load_record`."""
    rows = record["speeds"]
    boosted = bool(rows) and "intake_pressure" in rows[0]
    return Table(
        "Load of the engine",
        [
            SPEED,
            Column("indicated power", "kW"),
            Column("mean indicated pressure", "MPa"),
            Column("peak pressure", "MPa"),
            *([Column("intake pressure", "MPa")] if boosted else []),
        ],
        [
            [
                row["speed_rpm"] / RPM,
                row["indicated_power"],
                row["mean_indicated_pressure"],
                row["peak_pressure"],
                *([row["intake_pressure"]] if boosted else []),
            ]
            for row in rows
        ],
        note="Peak and intake pressure are absolute.",
    )


def critical_table(record: Record) -> Table:
    """Return the critical speeds of one kind; those at which the cylinders act in phase are marked."""
    return Table(
        f"{record['kind'].capitalize()} critical speeds in the running range, without damping",
        [
            SPEED,
            Column("order", digits=None),
            Column("mode"),
            FREQUENCY,
            Column("phase sum", decimals=3),
        ],
        [
            [
                critical["speed_rpm"] / RPM,
                critical["order"],
                critical["mode"],
                critical["frequency"],
                critical["phase_sum"],
            ]
            for critical in record["criticals"]
        ],
        marks=[
            ("chosen" if critical["phase_sum"] >= TOGETHER else "")
            + ("" if critical["in_running_range"] else " above")
            for critical in record["criticals"]
        ],
    )


def source_table(record: Record, said: Callable[[str], str] = str) -> Table:
    """Return the first frequencies of one kind with every source, which `said` puts into words."""
    unit = "m/N" if record["kind"] == "axial" else "rad/(N m)"
    first = next((source["first_mode"] for source in record["sources"]), 1)
    # Modes of a coupling or a damper, below the crankshaft's own, hardly depend on its compliances.
    own = f" of the crankshaft, from mode {first} on," if first > 1 else ""
    return Table(
        f"First {record['kind']} frequencies{own} by source of the compliances",
        [
            Column("source", words=True),
            Column("mean compliance", f"1e-9 {unit}"),
            Column("frequencies", "Hz", decimals=1),
            Column("ratio to chosen", decimals=3),
            Column("how it was used", words=True),
        ],
        [
            [
                said(source["source"]),
                source["mean_compliance"],
                source["crankshaft_frequencies"],
                source["beside_chosen"],
                source["remark"],
            ]
            for source in record["sources"]
        ],
        marks=[
            "chosen" if source["source"] == record["source"] else "" for source in record["sources"]
        ],
    )


def barred_within_error(ranges: list[Record]) -> str:
    """State which speeds have to be barred over the range of the compliances."""
    shown = ", ".join(f"{barred['low_rpm']:.0f} to {barred['high_rpm']:.0f}" for barred in ranges)
    return f"over that range of the compliances, speeds to be barred are within {shown} 1/min"


def factor_range(spread: Record) -> str:
    """Write the range of a factor.

    Examples
    --------
    >>> factor_range({"low": 0.6, "high": 1.4}), factor_range({"low": 0.9967, "high": 1.0033})
    ('0.6 to 1.4 times', '-0.33 to +0.33 % of')
    """
    low, high = spread["low"], spread["high"]
    if max(abs(low - 1.0), abs(high - 1.0)) < 0.1:
        return f"{100.0 * (low - 1.0):+.2g} to {100.0 * (high - 1.0):+.2g} % of"
    return f"{low:.3g} to {high:.3g} times"


def resonance_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the most severe resonances of a `forced_record`, by speed."""
    kind, resonances = record["kind"], record["resonances"]
    # Running speeds come first; what lies above them fills what is left.
    kept = sorted(
        (resonance for resonance in resonances if is_listed(resonance)),
        key=lambda resonance: (not resonance["in_running_range"], -resonance["severity"]),
    )
    worst = sorted(kept[:ROWS_SHOWN], key=lambda peak: peak["speed_rpm"] or float("inf"))
    motion = MOTION[kind].printed
    speed = replace(SPEED, missing="no peak")
    return Table(
        f"{kind.capitalize()} resonances {_assessed_range(record, units)}"
        + (f", the {ROWS_SHOWN} most severe of {len(kept)}" if len(kept) > ROWS_SHOWN else ""),
        [
            speed,
            Column("order", digits=None),
            Column("mode", words=True),
            Column("peak at", words=True, missing="-"),
            Column("peak", missing="-"),
            Column(record["free_end"]["node"], motion),
            Column("damping", "%", decimals=2),
            Column("kind", words=True),
        ],
        [
            [
                _from_rpm(peak["speed_rpm"]),
                peak["order"],
                peak_modes(peak),
                peak_place(peak),
                peak_size(peak, kind, units),
                UNBOUNDED if peak["unbounded"] else peak["amplitude"],
                peak["damping_ratio"],
                peak["kind"] + ("" if peak["in_running_range"] else ", above"),
            ]
            for peak in worst
        ],
        note=left_out(resonances, worst),
    )


def is_listed(peak: Record) -> bool:
    """Return whether a table lists a peak of a `forced_record`, or tells of it in `left_out`."""
    return peak["speed_rpm"] is None or (peak["in_band"] and peak["severity"] >= LEAST_PEAK)


def peak_modes(peak: Record) -> str:
    """Write the modes that make a peak, the main one first."""
    return ", ".join(str(mode) for mode in peak.get("modes") or [peak["mode"]])


def peak_place(peak: Record) -> str | None:
    """Write where a peak is, and how many other places have theirs at what speeds nearby."""
    if not peak.get("place"):
        return None
    # Of a point with several parts the first one tells it from others.
    others, name = len(peak["others"]), peak["place"].split(", ")[0]
    low, high = (f"{speed:.4g}" for speed in peak["spread_rpm"])
    return f"{name} (+{others}{f' at {low} to {high}' if low != high else ''})" if others else name


def peak_size(peak: Record, kind: str, units: OutputUnits, digits: int = 4) -> str | None:
    """Write the amplitude of a peak at its place."""
    if peak["speed_rpm"] is None:
        return None
    if peak["unbounded"]:
        return UNBOUNDED
    motion = MOTION[kind]
    if peak["unit"] == motion.si:
        own = units.of(motion.printed)
        return f"{own.number(peak['value'], digits)} {own.name}"
    return units.quantity(peak["value"], peak["unit"], digits)


def left_out(found: list[Record], shown: list[Record]) -> str:
    """Say which peaks of one kind a table leaves out, and why; empty without any."""
    peaks = [one for one in found if one["speed_rpm"] is not None and one not in shown]
    beyond = [peak for peak in peaks if is_listed(peak)]
    forced = [peak for peak in peaks if not peak["in_band"]]
    small = [peak for peak in peaks if peak not in beyond and peak not in forced]
    texts = []
    if beyond:
        most = 100.0 * max(one["severity"] for one in beyond)
        texts.append(
            f"{_counted(beyond, 'critical speed')}, up to {most:.0f} % of the largest peak at a place"
        )
    if small:
        texts.append(
            f"{_counted(small, 'peak')} below {100.0 * LEAST_PEAK:.0f} % of the largest one at every place"
        )
    if forced:
        worst = max(forced, key=lambda one: one["severity"])
        texts.append(
            f"{_counted(forced, 'peak')} of the exciting forces, where no mode reaches half of its largest "
            f"magnifier, the main one of order {worst['order']:g} at {worst['speed_rpm']:.4g} 1/min "
            f"({worst['place'].split(', ')[0]})"
        )
    return f"Not listed: {'; '.join(texts)}." if texts else ""


def _counted(peaks: list[Record], name: str) -> str:
    return f"{len(peaks)} {name}{'s' if len(peaks) > 1 else ''}"


def _from_rpm(speed: float | None) -> float | None:
    return None if speed is None else speed / RPM


def element_table(record: Record) -> Table:
    """Return the largest loads, and stresses if there are, of the elements of a `forced_record`.

    Running speeds come first; larger or smaller values below and above them have their own columns.
    """

    def peak(element: Record | None, part: str) -> float | str | None:
        found = None if element is None else element.get(part, element)
        return "" if found is None else found["peak"]

    stresses = {element["element"]: element for element in record["stress"] or ()}
    load = LOAD[record["kind"]]
    beside = [
        part
        for part in ("below", "above")
        if any(load[part] is not None for load in record["loads"])
    ]
    where = {"below": "below running speeds", "above": "above them, as far as judged"}
    return Table(
        f"{record['kind'].capitalize()} vibration of the elements, largest at running speeds "
        "(all orders over the cycle; plain sum of amplitudes)",
        [
            Column("element", words=True),
            Column("load", load, missing=UNBOUNDED),
            Column("at", "1/min", decimals=0),
            Column("plain sum", load, missing=UNBOUNDED),
            *([Column("stress", "MPa", missing=UNBOUNDED)] if stresses else []),
            *(Column(where[part], load, missing=UNBOUNDED) for part in beside),
        ],
        [
            [
                load["element"],
                peak(load, "running"),
                load.get("running", load)["speed_rpm"] / RPM,
                load.get("running", load)["plain_sum_peak"],
                *([peak(stresses.get(load["element"]), "running")] if stresses else []),
                *(peak(load, part) for part in beside),
            ]
            for load in record["loads"]
        ],
    )


def limit_table(
    record: Record, limit: str | None = None, units: OutputUnits = SI, digits: int = 4
) -> Table:
    """Return the use of limits, each location at its worst speed: all of them, or one by its name."""
    checks = [check for check in record["checks"] if limit in (None, check["limit"])]

    def quantity(value: float | None, unit: str) -> str:
        return UNBOUNDED if value is None else units.quantity(value, unit, digits)

    # What was judged above the running range stands beside it.
    beside = any(check["above"] is not None for check in checks)
    table = Table(
        f"{'Limits' if limit is None else limit.capitalize()}, at the running speeds where most is used",
        [
            Column("limit", words=True),
            Column("where", words=True),
            Column("at", "1/min", decimals=1),
            Column("reached"),
            Column("permitted"),
            Column("used", "%", 3, missing=UNBOUNDED),
            Column("above at", "1/min", decimals=1, missing="-"),
            Column("used above", "%", 3, missing="-"),
        ],
        [
            [
                check["limit"].removesuffix(f" of {check['place']}"),
                check["place"],
                running["speed_rpm"] / RPM,
                quantity(running["value"], check["unit"]),
                quantity(running["permitted"], check["unit"]),
                running["used"],
                None if above is None else above["speed_rpm"] / RPM,
                None if above is None else UNBOUNDED if above["used"] is None else above["used"],
            ]
            for check in checks
            for running, above in ((check["running"] or check, check["above"]),)
        ],
        marks=["" if check["passed"] else "over" for check in checks],
    )
    shown = ["where", "at", "reached", "permitted", "used"]
    return table.select(
        *([] if limit is not None else ["limit"]),
        *shown,
        *(["above at", "used above"] if beside else []),
    )


def misfiring_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return normal firing and the worst misfiring, row below row, from a `misfiring_record`."""
    motions = {own.si: own.printed for own in MOTION.values()}

    def written(value: float | None, unit: str) -> str | None:
        if value is None:
            return None
        if unit in motions:
            return units.of(motions[unit]).with_name(value, 3)
        return units.quantity(value, unit, 3)

    def row(one: Record, firing: str, found: Record) -> list[Any]:
        reached, permitted = (written(found[name], one["unit"]) for name in ("value", "permitted"))
        at = found["speed_rpm"] / RPM
        alone = one["quantity"].endswith(LONE_PLACE)
        return [
            one["quantity"] if alone else limit_at(one["quantity"], found["place"]),
            *(firing, at, reached or UNBOUNDED, permitted, found["used"]),
        ]

    def rows(one: Record) -> list[list[Any]]:
        cylinders = ", ".join(str(number) for number in one["cylinders"])
        return [
            row(one, "all cylinders", one["normal"]),
            row(one, f"all but {cylinders}", one["misfiring"]),
        ]

    return Table(
        "All cylinders firing and the worst case of misfiring: at running speeds the largest use of each "
        "limit, without a limit the largest amplitude",
        [
            Column("quantity", words=True),
            Column("firing", words=True),
            Column("at", "1/min", decimals=0),
            Column("reached"),
            Column("permitted", missing="-"),
            Column("used", "%", 3, missing="-"),
        ],
        [each for check in record["checks"] for each in rows(check)],
        marks=[
            "over" if _exceeded(check[firing]) else ""
            for check in record["checks"]
            for firing in ("normal", "misfiring")
        ],
    )


def _exceeded(reached: Record) -> bool:
    """Whether more is reached than permitted, where anything is."""
    return reached["permitted"] is not None and (reached["used"] is None or reached["used"] > 1.0)


def margin_table(record: Record, kind: str) -> Table:
    """Return the critical speeds of one kind with their uncertainty."""
    critical = record["critical"]
    return Table(
        f"{kind.capitalize()} critical speeds with uncertainty ranges, and margins to running speeds"
        + (f", the first {ROWS_SHOWN} of {len(critical)}" if len(critical) > ROWS_SHOWN else ""),
        [
            Column("mode"),
            Column("order", digits=None),
            SPEED,
            *(Column(name, "1/min", decimals=1, bare=True) for name in ("lowest", "highest")),
            Column("margin", "%", decimals=1),
        ],
        [
            [
                one["mode"],
                one["order"],
                *(one[name] / RPM for name in ("speed_rpm", "low_rpm", "high_rpm")),
                one["margin"] or None,
            ]
            for one in critical[:ROWS_SHOWN]
        ],
    )


def whole_table(record: Record) -> Table:
    """Return the modes of a `whole_record`."""
    return Table(
        "Modes of the whole crankshaft in its bearings",
        [
            Column("mode", words=True),
            Column("frequency", "Hz", decimals=2),
            Column("motion", words=True),
        ],
        [[mode["name"], mode["frequency"], mode["label"]] for mode in record["modes"]],
    )


def whole_critical_table(record: Record, kind: str) -> Table:
    """Return critical speeds of one kind in a `whole_record`: the largest of each place, then the largest."""
    criticals = record["criticals"][kind]
    largest = sorted(
        criticals["peaks"],
        key=lambda peak: (
            peak["share"] < 1.0,
            -math.inf if peak["value"] is None else -peak["value"],
        ),
    )
    shown = sorted(largest[:ROWS_SHOWN], key=lambda one: one["speed_rpm"])
    left = criticals["left_out"] + len(largest) - len(shown)
    return Table(
        f"Critical speeds of the whole crankshaft: {kind} "
        f"{'motion' if kind == 'axial' else 'torque'} by one order",
        [
            SPEED,
            Column("order", digits=None),
            Column("at", words=True),
            Column("amplitude", "um" if kind == "axial" else "kN m", 3, missing=UNBOUNDED),
            Column("mode", missing="none"),
            Column("damping", "%", decimals=2, missing="-"),
            Column("range", words=True),
        ],
        [
            [
                one["speed_rpm"] / RPM,
                one["order"],
                one["place"],
                one["value"],
                one["mode"] or None,
                one["damping_ratio"],
                "running" if one["in_running_range"] else "above",
            ]
            for one in shown
        ],
        note=f"{left} smaller {'one is' if left == 1 else 'ones are'} left out."
        if left
        else "None is left out.",
    )


def run_up_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the largest torques of a `run_up_record`."""
    speed = units.of("1/min")
    cut = "" if record["complete"] else ", interrupted"
    return Table(
        f"Run-up from {speed.fixed(record['from_rpm'] / RPM, 0)} to "
        f"{speed.fixed(record['to_rpm'] / RPM, 0)} {speed.name} in {record['duration']:g} s{cut}: "
        "amplitude of the torque in the springs",
        [
            Column("element", words=True),
            Column("largest", "kN m"),
            Column("at", "1/min", decimals=0),
            Column("at constant speeds", "kN m", missing=UNBOUNDED),
        ],
        [
            [element["element"], element["largest"], element["at_rpm"] / RPM, element["steady"]]
            for element in record["elements"]
        ],
    )


def _assessed_range(record: Record, units: OutputUnits) -> str:
    """State over which speeds resonances are listed."""
    running, judged = record["running_rpm"], record["judged_rpm"]
    if judged[1] <= running[1]:
        return "in the running range"
    return units.text(
        f"at the speeds judged: the running range to {running[1]:.4g} 1/min, and above it to "
        f"{judged[1]:.4g} 1/min, as far as a limit applies"
    )


KINDS = ("axial", "torsional")
# Of what there is none, or none is known, such as amplitudes beyond the speeds judged.
ABSENT = "-"
BESIDE = ("lowest", "highest", "undamped", "ring locked")


def speed_table(
    vibration: Record,
    units: OutputUnits = SI,
    most: int = ROWS_SHOWN,
    major: Collection[float] | None = None,
) -> Table:
    """Return the critical speeds of both kinds of vibration, with all that is known of each.

    Parameters
    ----------
    vibration : dict
        Record of a run's vibration. Without forces there are no amplitudes, and critical speeds are those
        without damping.
    units : OutputUnits, optional
        In which amplitudes are written.
    most : int
        How many are shown of each kind: the most severe, or without forces those at which the cylinders
        act together most.
    major : collection of float, optional
        The engine's major orders, to name the kind of critical speeds without a peak at speeds calculated.

    Returns
    -------
    Table
        Speeds at which the cylinders act in phase are marked.
    """
    running = (vibration["assessment"] or {}).get("running_rpm")
    shown = {kind: _shown(_speeds(vibration, kind), most) for kind in KINDS}
    rows = [_row(one, units, major, running) for kind in KINDS for one in shown[kind]]
    notes = [
        f"{kind.capitalize()}: {text}"
        for kind in KINDS
        if vibration["forced"] is not None
        and (
            text := left_out(
                vibration["forced"][kind]["resonances"],
                [one["resonance"] for one in shown[kind] if "resonance" in one],
            )
        )
    ]
    columns = [
        Column("vibration", words=True),
        SPEED,
        *(_absent(Column(name, "1/min", decimals=1, bare=True)) for name in BESIDE),
        Column("order", digits=None),
        Column("mode", words=True),
        _absent(FREQUENCY),
        _absent(Column("phase sum", decimals=2)),
        _absent(Column("peak at", words=True)),
        _absent(Column("amplitude")),
        _absent(Column("damping", "%", decimals=2)),
        Column("margin", "%", decimals=1, missing="inside"),
        Column("kind", words=True, missing=""),
    ]
    # A column that would say "none" of every speed says nothing.
    columns = [column for column in columns if any(row[column.name] is not None for row in rows)]
    return Table(
        "Critical speeds",
        columns,
        [[row[column.name] for column in columns] for row in rows],
        note=" ".join(notes),
        marks=[
            "chosen" if isinstance(row["phase sum"], float) and row["phase sum"] >= TOGETHER else ""
            for row in rows
        ],
    )


def _absent(column: Column) -> Column:
    return replace(column, missing=ABSENT)


def _speeds(vibration: Record, kind: str) -> list[Record]:
    """Return the results for each critical speed of one kind, combined by its mode and order.

    One order may have several peaks by one mode, each a critical speed of its own. Orders that damping
    leaves without a peak count at running speeds alone, and modes that no order brings to a peak have no
    margin.
    """
    forced, assessment = vibration["forced"], vibration["assessment"]
    calculated = [] if forced is None else forced[kind]["resonances"]
    peaks = [
        one
        for one in calculated
        if is_listed(one) and (one["speed_rpm"] is not None or one["in_running_range"])
    ]
    damped = {one["mode"] for one in calculated}
    damped -= {mode for one in calculated if one["speed_rpm"] is not None for mode in _modes(one)}
    met = {_meeting(critical): critical for critical in vibration[kind]["criticals"]}
    speeds: list[Record] = [{"resonance": peak} for peak in peaks]
    known = {(mode, one["order"]) for one in calculated for mode in _modes(one)}
    speeds += [{"critical": met[key]} for key in met.keys() - known]
    for own in speeds:
        key = _meeting(_known(own))
        own |= {"kind of motion": kind} | ({"critical": met[key]} if key in met else {})
    margins = [] if assessment is None else assessment["uncertainty"][kind]["critical"]
    for margin in margins:
        same = [
            speed
            for speed in speeds
            if _known(speed)["order"] == margin["order"] and margin["mode"] in _modes(_known(speed))
        ]
        if same:
            nearest = min(same, key=lambda own: _distance(own, margin))
            nearest["margin"] = margin
        elif margin["mode"] not in damped and _meeting(margin) not in known:
            speeds.append({"kind of motion": kind, "margin": margin})
    return speeds


def _meeting(record: Record) -> tuple[int, float]:
    return record["mode"], record["order"]


def _modes(record: Record) -> list[int]:
    """Return all modes that make a peak."""
    return [record["mode"], *record.get("modes", ())]


def _distance(record: Record, margin: Record) -> float:
    speed = _speed_rpm(record)
    return float("inf") if speed is None else abs(speed - float(margin["speed_rpm"]))


def _strength(record: Record) -> float:
    """How much a critical speed matters beside others of its kind."""
    severity = float(record.get("resonance", {}).get("severity", 0.0))
    return severity + float(record.get("critical", {}).get("phase_sum", 0.0)) * 1e-9


def _shown(records: list[Record], most: int) -> list[Record]:
    worst = sorted(records, key=lambda record: -_strength(record))[:most]
    return sorted(worst, key=lambda one: (_speed_rpm(one) or float("inf"), _known(one)["order"]))


def _known(record: Record) -> Record:
    """The main quantity of a critical speed: its peak, or its undamped speed, or its margin."""
    return next(record[part] for part in ("resonance", "critical", "margin") if part in record)


def _speed_rpm(record: Record) -> float | None:
    for part in ("resonance", "margin", "critical"):
        if part in record:
            return None if record[part]["speed_rpm"] is None else float(record[part]["speed_rpm"])
    return None


def _row(
    record: Record,
    units: OutputUnits,
    major: Collection[float] | None,
    running: Sequence[float] | None,
) -> dict[str, Cell]:
    kind = record["kind of motion"]
    critical, peak, margin = (record.get(part, {}) for part in ("critical", "resonance", "margin"))
    speed = _speed_rpm(record)
    known = _known(record)
    outside = not known.get("in_running_range", True) or bool(margin.get("margin"))
    if running is not None and speed is not None and not peak:
        outside = not running[0] <= speed <= running[1]
    named = peak.get("kind", "")
    if not named and major is not None:
        named = "major" if known["order"] in major else "minor"
    return {
        "vibration": kind,
        "speed": "no peak" if speed is None else speed / RPM,
        "lowest": _from_rpm(margin.get("low_rpm")),
        "highest": _from_rpm(margin.get("high_rpm")),
        "undamped": _from_rpm(peak.get("undamped_rpm")),
        "ring locked": _from_rpm(peak.get("locked_rpm")),
        "order": known["order"],
        "mode": peak_modes(known),
        "frequency": None if peak else critical.get("frequency"),
        "phase sum": critical.get("phase_sum"),
        "peak at": peak_place(peak),
        "amplitude": peak_size(peak, kind, units, 3) if peak else None,
        "damping": peak.get("damping_ratio"),
        # Of a speed outside whose uncertainty range reaches to running speeds nothing is left.
        "margin": (margin["margin"] if outside else None) if margin else ABSENT if peak else None,
        "kind": f"{named}{', ' if named else ''}outside" if outside else named or None,
    }


def mode_table(record: Record) -> Table:
    """Return the natural modes of one kind, from its `vibration_record`."""
    names = record["nodes"]
    # Points have the numbers of their names: throws and main bearings count from 1.
    first = 0 if names[0].startswith(FREE_END) else 1
    return Table(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        [
            Column("mode", words=True),
            FREQUENCY,
            Column("[1/min]", decimals=0),
            Column("nodes at", words=True),
        ],
        [
            [
                "rigid body" if mode["rigid"] else f"{mode['number']}{_beside_crankshaft(mode)}",
                mode["frequency"],
                60.0 * mode["frequency"],
                "moves as one"
                if mode["rigid"]
                else _still_at(mode["node_positions"], record, first),
            ]
            for mode in record["modes"]
        ],
        note=f"Node positions count the chain's points: {_points(names, first)}.",
    )


def _points(names: list[str], first: int) -> str:
    """Name all points by their numbers; those whose own numbers ascend along the chain together.

    Examples
    --------
    >>> _points(["free end", "throw 1", "throw 2", "throw 3", "flywheel"], 0)
    '0 free end, 1 to 3 throw 1 to throw 3, 4 flywheel'
    """
    runs: list[list[int]] = []
    for place, name in enumerate(names):
        before = names[place - 1].rpartition(" ") if place else ("", "", "")
        stem, _, number = name.rpartition(" ")
        follows = before[2].isdecimal() and number.isdecimal() and int(number) == int(before[2]) + 1
        if follows and stem == before[0]:
            runs[-1].append(place)
        else:
            runs.append([place])
    return ", ".join(
        f"{first + run[0]} {names[run[0]]}"
        if len(run) == 1
        else f"{first + run[0]} to {first + run[-1]} {names[run[0]]} to {names[run[-1]]}"
        for run in runs
    )


def _still_at(positions: list[float], record: Record, first: int) -> str | None:
    """State the positions of a mode's nodes: by the numbers of the points, or on their branch."""
    names = record["nodes"]
    pairs = record["connections"]
    positions_of_nodes = []
    for position in positions:
        element = min(int(position), len(pairs) - 1)
        (left, right), share = pairs[element], position - element
        row = f"{first + left + share:.2f}"
        branch = f"{share:.2f} of the way from {names[left]} to {names[right]}"
        positions_of_nodes.append(row if right == left + 1 else branch)
    return ", ".join(positions_of_nodes) or None


def _beside_crankshaft(mode: Record) -> str:
    return "" if mode["of_crankshaft"] else " (coupling, damper or line)"
