"""The table of an engine's critical speeds: their position, uncertainty and effect."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Cell, Column, Table
from crankbase.units.units import RPM
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.tables import (
    FREQUENCY,
    ROWS_SHOWN,
    SPEED,
    TOGETHER,
    is_listed,
    left_out,
    peak_modes,
    peak_place,
    peak_size,
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
    columns = [one for one in columns if any(row[one.name] is not None for row in rows)]
    return Table(
        "Critical speeds",
        columns,
        [[row[one.name] for one in columns] for row in rows],
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
    met = {_meeting(one): one for one in vibration[kind]["criticals"]}
    found: list[Record] = [{"resonance": one} for one in peaks]
    known = {(mode, one["order"]) for one in calculated for mode in _modes(one)}
    found += [{"critical": met[key]} for key in met.keys() - known]
    for own in found:
        key = _meeting(_known(own))
        own |= {"kind of motion": kind} | ({"critical": met[key]} if key in met else {})
    margins = [] if assessment is None else assessment["uncertainty"][kind]["critical"]
    for margin in margins:
        same = [
            own
            for own in found
            if _known(own)["order"] == margin["order"] and margin["mode"] in _modes(_known(own))
        ]
        if same:
            nearest = min(same, key=lambda own: _distance(own, margin))
            nearest["margin"] = margin
        elif margin["mode"] not in damped and _meeting(margin) not in known:
            found.append({"kind of motion": kind, "margin": margin})
    return found


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
    worst = sorted(records, key=lambda one: -_strength(one))[:most]
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


def _from_rpm(speed: float | None) -> float | None:
    return None if speed is None else speed / RPM
