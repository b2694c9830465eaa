"""The tables of an engine's vibration, from its plain records: the command line and the report show them."""

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from operator import itemgetter
from typing import Any

from crankbase.quantity import RPM, UNBOUNDED
from crankbase.table import SI, Cell, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.shaft.chains import MOTION
from dynamics.chains.engine_chains import FREE_END
from dynamics.response.damped_criticals import LEAST_PEAK
from dynamics.wording import limit_at

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


def _speed(name: str = "speed_rpm") -> Callable[[Record], float | None]:
    """Return what reads a speed [rad/s] of a record; None where there is none."""
    return lambda record: None if record.get(name) is None else record[name] / RPM


def load_table(record: Record) -> Table:
    """Return the load at some speeds, from the record of an `EngineLoad`."""
    rows = record["speeds"]
    boosted = bool(rows) and "intake_pressure" in rows[0]
    return Table.of_records(
        "Load of the engine",
        rows,
        (SPEED, _speed()),
        (Column("indicated power", "kW"), "indicated_power"),
        (Column("mean indicated pressure", "MPa"), "mean_indicated_pressure"),
        (Column("peak pressure", "MPa"), "peak_pressure"),
        *([(Column("intake pressure", "MPa"), "intake_pressure")] if boosted else []),
        note="Peak and intake pressure are absolute.",
    )


def critical_table(record: Record) -> Table:
    """Return the critical speeds of one kind; those at which the cylinders act in phase are marked."""
    return Table.of_records(
        f"{record['kind'].capitalize()} critical speeds in the running range, without damping",
        record["criticals"],
        (SPEED, _speed()),
        (Column("order", digits=None), "order"),
        (Column("mode"), "mode"),
        (FREQUENCY, "frequency"),
        (Column("phase sum", decimals=3), "phase_sum"),
        mark=lambda critical: (
            ("chosen" if critical["phase_sum"] >= TOGETHER else "")
            + ("" if critical["in_running_range"] else " above")
        ),
    )


def source_table(record: Record, said: Callable[[str], str] = str) -> Table:
    """Return the first frequencies of one kind with every source, which `said` puts into words."""
    unit = "m/N" if record["kind"] == "axial" else "rad/(N m)"
    first = next((source["first_mode"] for source in record["sources"]), 1)
    # Modes of a coupling or a damper, below the crankshaft's own, hardly depend on its compliances.
    own = f" of the crankshaft, from mode {first} on," if first > 1 else ""
    return Table.of_records(
        f"First {record['kind']} frequencies{own} by source of the compliances",
        record["sources"],
        (Column("source", words=True), lambda source: said(source["source"])),
        (Column("mean compliance", f"1e-9 {unit}"), "mean_compliance"),
        (Column("frequencies", "Hz", decimals=1), "crankshaft_frequencies"),
        (Column("ratio to chosen", decimals=3), "beside_chosen"),
        (Column("how it was used", words=True), "remark"),
        mark=lambda source: "chosen" if source["source"] == record["source"] else "",
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
    worst = sorted(kept[:ROWS_SHOWN], key=lambda peak: peak["speed_rpm"] or math.inf)
    running, judged = record["running_rpm"], record["judged_rpm"]
    where = "in the running range"
    if judged[1] > running[1]:
        where = units.text(
            f"at the speeds judged: the running range to {running[1]:.4g} 1/min, and above it to "
            f"{judged[1]:.4g} 1/min, as far as a limit applies"
        )
    return Table.of_records(
        f"{kind.capitalize()} resonances {where}"
        + (f", the {ROWS_SHOWN} most severe of {len(kept)}" if len(kept) > ROWS_SHOWN else ""),
        worst,
        (replace(SPEED, missing="no peak"), _speed()),
        (Column("order", digits=None), "order"),
        (Column("mode", words=True), peak_modes),
        (Column("peak at", words=True, missing="-"), peak_place),
        (Column("peak", missing="-"), lambda peak: peak_size(peak, kind, units)),
        (
            Column(record["free_end"]["node"], MOTION[kind].printed),
            lambda peak: UNBOUNDED if peak["unbounded"] else peak["amplitude"],
        ),
        (Column("damping", "%", decimals=2), "damping_ratio"),
        (
            Column("kind", words=True),
            lambda peak: peak["kind"] + ("" if peak["in_running_range"] else ", above"),
        ),
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


def element_table(record: Record) -> Table:
    """Return the largest loads, and stresses if there are, of the elements of a `forced_record`.

    Running speeds come first; larger or smaller values below and above them have their own columns.
    """
    loads, load = record["loads"], LOAD[record["kind"]]
    stresses = {stress["element"]: stress for stress in record["stress"] or ()}

    def peak(part: str, of_load: bool = True) -> Callable[[Record], Cell]:
        def cell(load: Record) -> Cell:
            element = load if of_load else stresses.get(load["element"])
            largest = None if element is None else element[part]
            return "" if largest is None else largest["peak"]

        return cell

    return Table.of_records(
        f"{record['kind'].capitalize()} vibration of the elements, largest at running speeds "
        "(all orders over the cycle; plain sum of amplitudes)",
        loads,
        (Column("element", words=True), "element"),
        (Column("load", load, missing=UNBOUNDED), peak("running")),
        (Column("at", "1/min", decimals=0), lambda load: load["running"]["speed_rpm"] / RPM),
        (
            Column("plain sum", load, missing=UNBOUNDED),
            lambda load: load["running"]["plain_sum_peak"],
        ),
        *(
            [(Column("stress", "MPa", missing=UNBOUNDED), peak("running", of_load=False))]
            if stresses
            else []
        ),
        *(
            (Column(where, load, missing=UNBOUNDED), peak(part))
            for part, where in (
                ("below", "below running speeds"),
                ("above", "above them, as far as judged"),
            )
            if any(load[part] is not None for load in loads)
        ),
    )


def limit_table(
    record: Record, limit: str | None = None, units: OutputUnits = SI, digits: int = 4
) -> Table:
    """Return the use of limits, each location at its worst speed: all of them, or one by its name."""
    checks = [check for check in record["checks"] if limit in (None, check["limit"])]

    def quantity(name: str) -> Callable[[Record], Cell]:
        def cell(check: Record) -> str:
            value = (check["running"] or check)[name]
            return UNBOUNDED if value is None else units.quantity(value, check["unit"], digits)

        return cell

    above: tuple[tuple[Column, Callable[[Record], Cell]], ...] = (
        (
            Column("above at", "1/min", decimals=1, missing="-"),
            lambda check: check["above"] and check["above"]["speed_rpm"] / RPM,
        ),
        (
            Column("used above", "%", 3, missing="-"),
            lambda check: (
                check["above"]
                and (UNBOUNDED if check["above"]["used"] is None else check["above"]["used"])
            ),
        ),
    )
    name = (
        Column("limit", words=True),
        lambda check: check["limit"].removesuffix(f" of {check['place']}"),
    )
    return Table.of_records(
        f"{'Limits' if limit is None else limit.capitalize()}, at the running speeds where most is used",
        checks,
        *([name] if limit is None else []),
        (Column("where", words=True), "place"),
        (
            Column("at", "1/min", decimals=1),
            lambda check: (check["running"] or check)["speed_rpm"] / RPM,
        ),
        (Column("reached"), quantity("value")),
        (Column("permitted"), quantity("permitted")),
        (
            Column("used", "%", 3, missing=UNBOUNDED),
            lambda check: (check["running"] or check)["used"],
        ),
        # What was judged above the running range stands beside it.
        *(above if any(check["above"] is not None for check in checks) else ()),
        mark=lambda check: "" if check["passed"] else "over",
    )


def misfiring_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return normal firing and the worst misfiring, row below row, from the record of `Misfiring`."""
    motions = {own.si: own.printed for own in MOTION.values()}

    def name(row: Record) -> str:
        quantity: str = row["quantity"]
        return quantity if quantity.endswith(LONE_PLACE) else limit_at(quantity, row["place"])

    def written(part: str) -> Callable[[Record], str | None]:
        def cell(row: Record) -> str | None:
            value, unit = row[part], row["unit"]
            if value is None:
                return None
            if unit in motions:
                return units.of(motions[unit]).with_name(value, 3)
            return units.quantity(value, unit, 3)

        return cell

    def over(row: Record) -> bool:
        return row["permitted"] is not None and (row["used"] is None or row["used"] > 1.0)

    return Table.of_records(
        "All cylinders firing and the worst case of misfiring: at running speeds the largest use of each "
        "limit, without a limit the largest amplitude",
        [
            {**check, **check[case], "firing": firing}
            for check in record["checks"]
            for case, firing in (
                ("normal", "all cylinders"),
                ("misfiring", f"all but {', '.join(map(str, check['cylinders']))}"),
            )
        ],
        (Column("quantity", words=True), name),
        (Column("firing", words=True), "firing"),
        (Column("at", "1/min", decimals=0), _speed()),
        (Column("reached", missing=UNBOUNDED), written("value")),
        (Column("permitted", missing="-"), written("permitted")),
        (Column("used", "%", 3, missing="-"), "used"),
        mark=lambda row: "over" if over(row) else "",
    )


def margin_table(record: Record, kind: str) -> Table:
    """Return the critical speeds of one kind with their uncertainty."""
    critical = record["critical"]
    return Table.of_records(
        f"{kind.capitalize()} critical speeds with uncertainty ranges, and margins to running speeds"
        + (f", the first {ROWS_SHOWN} of {len(critical)}" if len(critical) > ROWS_SHOWN else ""),
        critical[:ROWS_SHOWN],
        (Column("mode"), "mode"),
        (Column("order", digits=None), "order"),
        (SPEED, _speed()),
        (Column("lowest", "1/min", decimals=1, bare=True), _speed("low_rpm")),
        (Column("highest", "1/min", decimals=1, bare=True), _speed("high_rpm")),
        (Column("margin", "%", decimals=1), lambda margin: margin["margin"] or None),
    )


def whole_table(record: Record) -> Table:
    """Return the modes of a `whole_record`."""
    return Table.of_records(
        "Modes of the whole crankshaft in its bearings",
        record["modes"],
        (Column("mode", words=True), "name"),
        (FREQUENCY, "frequency"),
        (Column("motion", words=True), "label"),
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
    return Table.of_records(
        f"Critical speeds of the whole crankshaft: {kind} "
        f"{'motion' if kind == 'axial' else 'torque'} by one order",
        shown,
        (SPEED, _speed()),
        (Column("order", digits=None), "order"),
        (Column("at", words=True), "place"),
        (Column("amplitude", "um" if kind == "axial" else "kN m", 3, missing=UNBOUNDED), "value"),
        (Column("mode", missing="none"), lambda peak: peak["mode"] or None),
        (Column("damping", "%", decimals=2, missing="-"), "damping_ratio"),
        (
            Column("range", words=True),
            lambda peak: "running" if peak["in_running_range"] else "above",
        ),
        note=f"{left} smaller {'one is' if left == 1 else 'ones are'} left out."
        if left
        else "None is left out.",
    )


def run_up_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the largest torques of a run-up, from its record."""
    speed = units.of("1/min")
    cut = "" if record["complete"] else ", interrupted"
    return Table.of_records(
        f"Run-up from {speed.fixed(record['from_rpm'] / RPM, 0)} to "
        f"{speed.fixed(record['to_rpm'] / RPM, 0)} {speed.name} in {record['duration']:g} s{cut}: "
        "amplitude of the torque in the springs",
        record["elements"],
        (Column("element", words=True), "element"),
        (Column("largest", "kN m"), "largest"),
        (Column("at", "1/min", decimals=0), _speed("at_rpm")),
        (Column("at constant speeds", "kN m", missing=UNBOUNDED), "steady"),
    )


KINDS = ("axial", "torsional")
# Of what there is none, or none is known, such as amplitudes beyond the speeds judged.
ABSENT = "-"


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
    shown = {
        kind: sorted(
            sorted(_speeds(vibration, kind), key=lambda speed: -_strength(speed))[:most],
            key=lambda speed: (_speed_rpm(speed) or math.inf, _known(speed)["order"]),
        )
        for kind in KINDS
    }

    def part(name: str, read: Callable[[Record], Any]) -> Callable[[Record], Any]:
        """Read something of a part of a critical speed, if it has that part."""
        return lambda speed: read(speed[name]) if name in speed else None

    def place(speed: Record) -> Cell:
        rpm = _speed_rpm(speed)
        return "no peak" if rpm is None else rpm / RPM

    def outside(speed: Record) -> bool:
        rpm, known = _speed_rpm(speed), _known(speed)
        if running is not None and rpm is not None and "resonance" not in speed:
            return not running[0] <= rpm <= running[1]
        return not known.get("in_running_range", True) or bool(
            speed.get("margin", {}).get("margin")
        )

    def margin(speed: Record) -> Cell:
        if "margin" in speed:
            # Of a speed outside whose uncertainty range reaches to running speeds nothing is left.
            left: float = speed["margin"]["margin"]
            return left if outside(speed) else None
        return ABSENT if "resonance" in speed else None

    def kind_of(speed: Record) -> str | None:
        named = speed.get("resonance", {}).get("kind", "")
        if not named and major is not None:
            named = "major" if _known(speed)["order"] in major else "minor"
        return ", ".join(filter(None, (named, "outside" if outside(speed) else ""))) or None

    def size(speed: Record) -> str | None:
        peak = speed.get("resonance")
        return peak and peak_size(peak, speed["kind of motion"], units, 3)

    def beside(name: str, part_name: str, key: str) -> tuple[Column, Callable[[Record], Cell]]:
        column = Column(name, "1/min", decimals=1, bare=True, missing=ABSENT)
        return column, part(part_name, _speed(key))

    phase_sum = part("critical", itemgetter("phase_sum"))
    table = Table.of_records(
        "Critical speeds",
        [speed for kind in KINDS for speed in shown[kind]],
        (Column("vibration", words=True), "kind of motion"),
        (SPEED, place),
        beside("lowest", "margin", "low_rpm"),
        beside("highest", "margin", "high_rpm"),
        beside("undamped", "resonance", "undamped_rpm"),
        beside("ring locked", "resonance", "locked_rpm"),
        (Column("order", digits=None), lambda speed: _known(speed)["order"]),
        (Column("mode", words=True), lambda speed: peak_modes(_known(speed))),
        (
            replace(FREQUENCY, missing=ABSENT),
            lambda speed: (
                None if "resonance" in speed else speed.get("critical", {}).get("frequency")
            ),
        ),
        (Column("phase sum", decimals=2, missing=ABSENT), phase_sum),
        (Column("peak at", words=True, missing=ABSENT), part("resonance", peak_place)),
        (Column("amplitude", missing=ABSENT), size),
        (
            Column("damping", "%", decimals=2, missing=ABSENT),
            part("resonance", itemgetter("damping_ratio")),
        ),
        (Column("margin", "%", decimals=1, missing="inside"), margin),
        (Column("kind", words=True, missing=""), kind_of),
        note=" ".join(
            f"{kind.capitalize()}: {text}"
            for kind in KINDS
            if vibration["forced"] is not None
            and (
                text := left_out(
                    vibration["forced"][kind]["resonances"],
                    [speed["resonance"] for speed in shown[kind] if "resonance" in speed],
                )
            )
        ),
        mark=lambda speed: "chosen" if (phase_sum(speed) or 0.0) >= TOGETHER else "",
    )
    # A column that would say "none" of every speed says nothing.
    columns = zip(table.columns, zip(*table.rows, strict=True), strict=False)
    return table.select(
        *(column.name for column, cells in columns if any(cell is not None for cell in cells))
    )


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


def _known(record: Record) -> Record:
    """The main quantity of a critical speed: its peak, or its undamped speed, or its margin."""
    return next(record[part] for part in ("resonance", "critical", "margin") if part in record)


def _speed_rpm(record: Record) -> float | None:
    for part in ("resonance", "margin", "critical"):
        if part in record:
            return None if record[part]["speed_rpm"] is None else float(record[part]["speed_rpm"])
    return None


def mode_table(record: Record) -> Table:
    """Return the natural modes of one kind, from its `vibration_record`."""
    names = record["nodes"]
    # Points have the numbers of their names: throws and main bearings count from 1.
    first = 0 if names[0].startswith(FREE_END) else 1

    def name(mode: Record) -> str:
        beside = "" if mode["of_crankshaft"] else " (coupling, damper or line)"
        return "rigid body" if mode["rigid"] else f"{mode['number']}{beside}"

    def still_at(mode: Record) -> str | None:
        if mode["rigid"]:
            return "moves as one"
        return _still_at(mode["node_positions"], record, first)

    return Table.of_records(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        record["modes"],
        (Column("mode", words=True), name),
        (FREQUENCY, "frequency"),
        (Column("[1/min]", decimals=0), lambda mode: 60.0 * mode["frequency"]),
        (Column("nodes at", words=True), still_at),
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
