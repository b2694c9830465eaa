"""The tables and texts of an engine's vibration, which the command line and the report show."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.quantity import RPM, UNBOUNDED
from crankbase.sentences import amount, capital, joined, kept, listed
from crankbase.table import SI, Cell, Column, Main, OutputUnits, Table
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.vibration.assessment import ROWS_SHOWN, Assessment
from crankfem.analyses.vibration.forced import ForcedVibration, PlacePeak
from crankfem.analyses.vibration.misfiring import FiringCheck, Misfiring, Reached
from crankfem.analyses.vibration.modes import TOGETHER, Vibration, WeightedCritical
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.whole_verdict import WholeVibration
from dynamics import wording
from dynamics.assessment.separation import CriticalRange
from dynamics.assessment.verdict import LimitCheck
from dynamics.indices import at_most
from dynamics.response.damped_criticals import LEAST_PEAK, DampedCritical
from dynamics.wording import limit_at

# Quantities of which there is one place, which they name.
LONE_PLACE = ("free end", "torsional damper", "coupling")
SPEED = Column("speed", "1/min", decimals=1)
FREQUENCY = Column("frequency", "Hz", decimals=2)
NOT_FORCED = (
    "Amplitudes are not calculated, because the engine file gives no gas pressure: add [gas]."
)
CHAINS_USED = "the verdict uses lumped models (chains)"
CHAINS_ALONE = (
    "--coupled also holds the whole crankshaft against the limits where they are inadequate"
)


def vibration_parts(run: EngineVibration, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return all tables and paragraphs; critical speeds only where nothing is forced."""

    def notes(remarks: Sequence[str]) -> Iterator[str]:
        return (units.written(f"Note: {kept(remark)}") for remark in remarks)

    forced, whole, misfiring = run.forced_by_kind, run.whole_crankshaft, run.misfiring
    yield units.written(run.firing_order)
    yield from notes([f"{kept(remark)}." for remark in run.firing_remarks])
    if run.load is not None:
        yield from run.load.parts(units)
    yield Main(
        units.written(
            "Natural frequencies by the chains: "
            + "; ".join(
                f"{modes.kind} {listed([m.frequency for m in modes.elastic_modes[:3]], 'Hz', 4)}"
                for modes in (run.axial, run.torsional)
            )
            + "."
        )
    )
    for vibration in (run.axial, run.torsional):
        yield vibration.mode_table()
        if note := vibration.formula_note:
            yield Main(units.written(f"{capital(note)}."))
        if forced is None:
            yield replace(vibration.critical_table(), main=True)
        yield vibration.source_table().select("source", "frequencies", "ratio to chosen")
        yield from notes([f"Not used: {kept(remark)}." for remark in vibration.unusable])
        if forced is not None:
            answer = forced[vibration.kind]
            for line in (*answer.damping, *answer.all_remarks):
                yield units.written(f"{vibration.kind.capitalize()}: {kept(line)}")
            yield resonance_table(answer, units)
            yield element_table(answer)
        if vibration.kind == "axial" and run.thrust is not None:
            yield from map(units.written, run.thrust.sentences)
    if whole is not None:
        yield from whole_parts(whole, units)
    if run.bearings is not None:
        yield from map(units.written, run.bearings.sentences)
    if run.assessment is None:
        yield Main(NOT_FORCED)
        return
    if run.bearings is not None:
        yield units.written(f"Axial and torsional: {kept(run.bearings.stiffness_range)}")
    yield from assessment_parts(run.assessment, units)
    if misfiring is not None:
        yield misfiring_table(misfiring, units)
        yield from notes(misfiring.remarks)
    elif run.misfiring_note:
        yield from notes([run.misfiring_note])
    if whole is None:
        yield from notes([f"{CHAINS_USED}; {kept(run.not_comparable or CHAINS_ALONE)}"])
    yield from range_sentences(run.assessment, units)


def assessment_parts(assessment: Assessment, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return what is uncertain, the limits, and what was assumed of them."""
    for uncertain in assessment.uncertainty.values():
        yield from uncertain.parts(units)
    for name in dict.fromkeys(check.limit.name for check in assessment.verdict.checks):
        yield limit_table(assessment, name, units)
    lowest, highest = assessment.verdict.running_range
    for limit in assessment.judged_limits:
        assumed, end = ", assumed" if limit.assumed else "", limit.judged_to
        beyond = (
            f", because it also applies above the highest running speed of {wording.at_speed(highest)}"
            if end > highest
            else ""
        )
        yield units.written(
            f"Limit on {limit.name}: {kept(limit.source)}{assumed}; judged from "
            f"{wording.speed_range(lowest, end)}{beyond}."
        )
    yield from (units.written(f"Note: {kept(remark)}") for remark in assessment.all_remarks)


def range_sentences(assessment: Assessment, units: OutputUnits = SI) -> Iterator[str]:
    """Return ranges of speed that are barred or passed, and what makes their ends."""
    for passed in assessment.verdict.deciding_first:
        yield units.written(f"Range {kept(passed.sentence)}. Its ends: {kept(passed.ends)}.")


def resonance_table(forced: ForcedVibration, units: OutputUnits = SI) -> Table:
    """Return the most severe resonances, by speed."""
    kind, resonances = forced.kind, forced.resonances
    kept = list(filter(is_listed, resonances))
    # All that are as severe as the last one shown, so that each one left out is less so.
    ranked = sorted((peak.severity for peak in kept), reverse=True)
    least = ranked[min(ROWS_SHOWN, len(ranked)) - 1] if ranked else 0.0
    worst = sorted(
        (peak for peak in kept if peak.severity >= least),
        key=lambda peak: peak.speed if peak.has_peak else math.inf,
    )
    running, judged = forced.running_range[1], forced.judged_range[1]
    where = "in the running range"
    if judged > running:
        where = units.written(
            f"at the speeds judged: the running range to {wording.at_speed(running)}, and above it to "
            f"{wording.at_speed(judged)}, as far as a limit applies"
        )
    return Table.of_records(
        f"{kind.capitalize()} resonances {where}"
        + (f", the {len(worst)} most severe of {len(kept)}" if len(kept) > len(worst) else ""),
        worst,
        (replace(SPEED, missing="no peak"), lambda peak: peak.speed if peak.has_peak else None),
        (Column("order", digits=None), "order"),
        (Column("mode", words=True), peak_modes),
        (Column("peak at", words=True, missing="-"), peak_place),
        (Column("peak", missing="-"), lambda peak: peak_size(peak, units)),
        (
            Column(forced.free_end_motion.node, MOTION[kind].printed),
            lambda peak: UNBOUNDED if peak.unbounded else peak.first_amplitude,
        ),
        (Column("damping", "%", decimals=2), lambda peak: peak.damping_ratio),
        (
            Column("kind", words=True),
            lambda peak: peak.kind + ("" if peak.in_running_range else ", above"),
        ),
        note=left_out(forced, worst),
    )


def is_listed(peak: DampedCritical) -> bool:
    """Return whether a table lists a peak, or tells of it in `left_out`."""
    return not peak.has_peak or (peak.in_band and peak.severity >= LEAST_PEAK)


def peak_modes(peak: DampedCritical) -> str:
    """Write the modes that make a peak, the main one first."""
    return ", ".join(map(str, peak.modes or [peak.mode]))


def peak_place(peak: DampedCritical) -> str | None:
    """Write where a peak is, and how many other places have theirs at what speeds nearby."""
    if peak.spread is None:
        return None
    # Of a point with several parts the first one tells it from others.
    others, name = len(peak.others), peak.place.split(", ")[0]
    low, high = (f"{RPM * speed:.4g}" for speed in peak.spread)
    return f"{name} (+{others}{f' at {low} to {high}' if low != high else ''})" if others else name


def peak_size(peak: DampedCritical, units: OutputUnits, digits: int = 4) -> str | None:
    """Write the amplitude of a peak at its place."""
    if not peak.has_peak:
        return None
    if peak.unbounded:
        return UNBOUNDED
    return _in_its_unit(peak.amplitude, peak.unit, units, digits)


def _in_its_unit(value: float, unit: str, units: OutputUnits, digits: int) -> str:
    """Write a value with the unit in which it is printed."""
    if math.isinf(value):
        return UNBOUNDED
    motion = next((motion for motion in MOTION.values() if motion.si == unit), None)
    if motion is None:
        return units.quantity(value, unit, digits)
    return units.of(motion.printed).with_name(value, digits)


def left_out(answer: ForcedVibration, shown: Sequence[DampedCritical]) -> str:
    """Say which peaks of one kind a table leaves out, and why; empty without any."""
    peaks = [peak for peak in answer.resonances if peak.has_peak and peak not in shown]
    passed = [peak for peak in answer.started_through if is_listed(peak) and peak not in shown]
    beyond = [peak for peak in peaks if is_listed(peak)]
    forced = [peak for peak in peaks if not peak.in_band]
    small = len(peaks) - len(beyond) - len(forced)
    texts = []
    if beyond:
        most = 100.0 * max(peak.severity for peak in beyond)
        texts.append(
            f"{_counted(len(beyond), 'critical speed')}, up to {most:.0f} % of the largest peak at a place"
        )
    if small:
        texts.append(
            f"{_counted(small, 'peak')} below {100.0 * LEAST_PEAK:.0f} % of the largest one at every place"
        )
    if forced:
        worst = max(forced, key=lambda peak: peak.severity)
        torsion = ", also at torsional resonances" if answer.kind == "axial" else ""
        texts.append(
            f"{_counted(len(forced), 'peak')} of the exciting forces{torsion}, which no mode of this chain "
            f"makes, the main one of order {worst.order:g} at {worst.speed_rpm:.4g} 1/min "
            f"({worst.place.split(', ')[0]})"
        )
    if passed:
        texts.append(
            f"{_counted(len(passed), 'critical speed')} below the running range, passed on every start"
        )
    return f"Not listed: {'; '.join(texts)}." if texts else ""


def _counted(count: int, name: str) -> str:
    return f"{count} {name}{'s' if count > 1 else ''}"


def element_table(forced: ForcedVibration) -> Table:
    """Return the largest loads, and stresses if there are, of the elements.

    Running speeds come first; larger or smaller values below and above them have their own columns.
    """
    loads, load = forced.load_peaks, MOTION[forced.kind].load_printed
    stresses = {stress.element: stress for stress in forced.stress_peaks or ()}

    def at(part: str, read: str = "peak") -> Callable[[PlacePeak | None], Cell]:
        return lambda peak: getattr(getattr(peak, part, None), read, "")

    return Table.of_records(
        f"{forced.kind.capitalize()} vibration of the elements, largest at running speeds "
        "(all orders over the cycle; plain sum of amplitudes)",
        loads,
        (Column("element", words=True), "element"),
        (Column("load", load), at("running")),
        (Column("at", "1/min", decimals=0), at("running", "speed")),
        (Column("plain sum", load), at("running", "plain_sum")),
        *(
            [(Column("stress", "MPa"), lambda peak: at("running")(stresses.get(peak.element)))]
            if stresses
            else []
        ),
        *(
            (Column(where, load), at(part))
            for part, where in (
                ("below", "below running speeds"),
                ("above", "above them, as far as judged"),
            )
            if any(getattr(peak, part) is not None for peak in loads)
        ),
    )


def limit_table(
    assessment: Assessment, name: str | None = None, units: OutputUnits = SI, digits: int = 4
) -> Table:
    """Return the use of limits, each location at its worst speed: all of them, or one by its name."""
    checks = [check for check in assessment.verdict.checks if name in (None, check.limit.name)]

    def above(part: str) -> Callable[[LimitCheck], Cell]:
        return lambda check: getattr(check.above, part, None)

    above_running = [
        (Column("above at", "1/min", decimals=1, missing="-"), above("speed")),
        (Column("used above", "%", 3, missing="-"), above("used")),
    ]
    limit = (
        Column("limit", words=True),
        lambda check: check.limit.name.removesuffix(f" of {check.place}"),
    )
    return Table.of_records(
        f"{'Limits' if name is None else name.capitalize()}, at the running speeds where most is used",
        checks,
        *([limit] if name is None else []),
        (Column("where", words=True), "place"),
        (Column("at", "1/min", decimals=1), lambda check: check.at_running.speed),
        (Column("reached"), lambda check: _written(check.at_running.value, check, units, digits)),
        (
            Column("permitted"),
            lambda check: _written(check.at_running.permitted, check, units, digits),
        ),
        (Column("used", "%", 3), lambda check: check.at_running.used),
        # What was judged above the running range stands beside it.
        *(above_running if any(check.above is not None for check in checks) else ()),
        mark=lambda check: "" if check.passed else "over",
    )


def _written(value: float, check: LimitCheck, units: OutputUnits, digits: int) -> str:
    return UNBOUNDED if math.isinf(value) else units.quantity(value, check.limit.unit, digits)


def misfiring_table(misfiring: Misfiring, units: OutputUnits = SI) -> Table:
    """Return normal firing and the worst misfiring, row below row."""

    def quantity(row: tuple[FiringCheck, Reached, str]) -> str:
        check, reached, _ = row
        lone = check.quantity.endswith(LONE_PLACE)
        return check.quantity if lone else limit_at(check.quantity, reached.place)

    def permitted(row: tuple[FiringCheck, Reached, str]) -> str | None:
        check, reached, _ = row
        if math.isinf(reached.permitted):
            return None
        return _in_its_unit(reached.permitted, check.unit, units, 3)

    def share(row: tuple[FiringCheck, Reached, str]) -> float | None:
        used = row[1].used_share
        return None if used is None or math.isinf(used) else used

    return Table.of_records(
        "All cylinders firing and the worst case of misfiring: at running speeds the largest use of each "
        "limit, without a limit the largest amplitude",
        [
            (check, reached, firing)
            for check in misfiring.checks
            for reached, firing in (
                (check.normal, "all cylinders"),
                (check.misfiring, f"all but {', '.join(map(str, check.cylinders))}"),
            )
        ],
        (Column("quantity", words=True), quantity),
        (Column("firing", words=True), lambda row: row[2]),
        (Column("at", "1/min", decimals=0), lambda row: row[1].speed),
        (
            Column("reached", missing=UNBOUNDED),
            lambda row: _in_its_unit(row[1].value, row[0].unit, units, 3),
        ),
        (Column("permitted", missing="-"), permitted),
        (Column("used", "%", 3, missing="-"), share),
        mark=lambda row: "over" if row[1].used > 1.0 else "",
    )


def whole_table(whole: WholeVibration) -> Table:
    """Return the modes of the whole crankshaft."""
    return Table.of_records(
        "Modes of the whole crankshaft in its bearings",
        whole.shaft.listed_modes,
        (Column("mode", words=True), "name"),
        (FREQUENCY, "frequency"),
        (Column("motion", words=True), "label"),
    )


def whole_critical_table(whole: WholeVibration, kind: str) -> Table:
    """Return critical speeds of one kind: the largest of each place, then the largest."""
    criticals = whole.criticals[kind]
    largest = sorted(criticals.peaks, key=lambda peak: (peak.share < 1.0, -peak.value))
    # All that are the largest of their place, whatever their number.
    count = max(ROWS_SHOWN, sum(peak.share >= 1.0 for peak in largest))
    shown = sorted(largest[:count], key=lambda peak: peak.speed)
    left = criticals.left_out + len(largest) - len(shown)
    note = "None is left out." if shown else "No order has a peak at the speeds judged."
    if left:
        note = f"{left} {'is' if left == 1 else 'are'} left out, none the largest of its place."
    return Table.of_records(
        f"Critical speeds of the whole crankshaft: {kind} "
        f"{'motion' if kind == 'axial' else 'torque'} by one order",
        shown,
        (SPEED, "speed"),
        (Column("order", digits=None), "order"),
        (Column("at", words=True), "place"),
        (Column("amplitude", "um" if kind == "axial" else "kN m", 3), "value"),
        (Column("mode", missing="none"), lambda peak: peak.mode or None),
        (Column("damping", "%", decimals=2, missing="-"), "damping_ratio"),
        (Column("range", words=True), lambda peak: "running" if peak.in_running_range else "above"),
        note=note,
    )


def whole_parts(whole: WholeVibration, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return modes of the whole crankshaft, and its comparison with the chains."""
    compared, length = whole.comparison, units.of("um")
    yield whole_table(whole)
    yield from (units.written(f"Note: {kept(remark)}") for remark in whole.shaft.remarks)
    for kind in whole.criticals:
        yield whole_critical_table(whole, kind)
    for kind, chain in compared.chains.items():
        motion = units.of(MOTION[kind].printed)
        if chain.chain_amplitude is not None or chain.shaft_amplitude is not None:
            yield (
                f"{kind.capitalize()} amplitude of the free end, largest at running speeds: chain "
                f"{motion.number(chain.chain_amplitude)}, whole crankshaft "
                f"{motion.number(chain.shaft_amplitude)} {motion.name}"
            )
        if chain.suffices:
            yield wording.adequate_chain(kind)
        else:
            yield units.written(f"{wording.inadequate_chain(kind)} {joined(' ', chain.reasons)}")
    for difference in compared.differences:
        yield units.written(f"{capital(difference.sentence)}.")
    if compared.flywheel_tilt is not None:
        yield units.written(compared.flywheel_tilt.sentence)
    split = compared.axial_split
    if split is not None:
        causes = (
            (split.tangential, split.tangential_speed, "tangential forces alone (torsion)"),
            (split.radial, split.radial_speed, "radial forces alone"),
            (split.both, split.both_speed, "both"),
        )
        words = [
            f"{length.number(amplitude)} {length.name} by {cause} at "
            + units.written(amount(speed, "rad/s", decimals=0))
            for amplitude, speed, cause in causes
        ]
        yield f"Axial amplitude of the free end, each at its own worst running speed: {', '.join(words)}"


# Of what there is none, or none is known, such as amplitudes beyond the speeds judged.
ABSENT = "-"


@dataclass(frozen=True)
class CriticalLine:
    """What is known of a critical speed: its peak, its undamped speed, and its margin, one at least."""

    vibration: str
    peak: DampedCritical | None
    critical: WeightedCritical | None
    margin: CriticalRange | None = None

    @property
    def known(self) -> DampedCritical | WeightedCritical | CriticalRange:
        """The main one of its parts."""
        known = self.peak or self.critical or self.margin
        assert known is not None
        return known

    @property
    def order(self) -> float:
        """In cycles per revolution."""
        return self.known.order

    @property
    def modes(self) -> tuple[int, ...]:
        """All modes that make it, the main one first."""
        further = () if self.peak is None else self.peak.modes
        return tuple(dict.fromkeys((*further, self.known.mode)))

    @property
    def speed(self) -> float | None:
        """Of the peak if there is one, else with its uncertainty [rad/s]."""
        if self.peak is not None:
            return self.peak.speed if self.peak.has_peak else None
        if self.margin is not None:
            return self.margin.nominal
        return None if self.critical is None else self.critical.speed

    @property
    def strength(self) -> tuple[float, float, float]:
        """How much it matters beside others of its kind: by its share of a limit, else by its size."""
        if self.peak is None:
            return 0.0, 0.0, self.phase_sum
        return np.nan_to_num(self.peak.limit_used), self.peak.severity, self.phase_sum

    @property
    def phase_sum(self) -> float:
        """Of the cylinders on the mode, if it is known."""
        return 0.0 if self.critical is None else self.critical.phase_sum

    def passed(self, running: tuple[float, float]) -> bool:
        """Return whether every start passes it: it lies below the running range [rad/s]."""
        speed = self.speed
        return speed is not None and not at_most(running[0], speed)

    def above(self, running: tuple[float, float]) -> bool:
        """Return whether it lies above the running range [rad/s]."""
        speed = self.speed
        return speed is not None and not at_most(speed, running[1])

    def outside(self, running: tuple[float, float]) -> bool:
        """Return whether it lies outside the running range [rad/s]."""
        return (
            self.passed(running) or self.above(running) or bool(self.margin and self.margin.margin)
        )


def speed_table(
    run: EngineVibration,
    units: OutputUnits = SI,
    most: int = ROWS_SHOWN,
) -> Table:
    """Return the critical speeds of both kinds of vibration, with all that is known of each.

    Parameters
    ----------
    run : EngineVibration
        Without forces there are no amplitudes, and critical speeds are those without damping.
    units : OutputUnits, optional
        In which amplitudes are written.
    most : int
        How many are shown of each kind: those whose order alone uses most of a limit, without limits the
        most severe, without forces those at which the cylinders act together most. Of those below the
        running range, which every start passes, the first of each mode beside the crankshaft's own, and
        others up to a third of that.

    Returns
    -------
    Table
        Speeds at which the cylinders act in phase are marked, and those of an order that alone exceeds a
        limit.
    """
    running = run.running_range
    shown = {
        kind: sorted(
            _shown(critical_lines(run, kind), run.modes(kind), running, most),
            key=lambda line: (line.speed or math.inf, line.order),
        )
        for kind in MOTION
    }

    def margin(line: CriticalLine) -> Cell:
        if line.margin is not None:
            # Of a speed outside whose uncertainty range reaches to running speeds nothing is left.
            return line.margin.margin if line.outside(running) else None
        return None if line.peak is None else ABSENT

    def beside(name: str, part: str, speed: str) -> tuple[Column, Callable[[CriticalLine], Cell]]:
        column = Column(name, "1/min", decimals=1, bare=True, missing=ABSENT)
        return (
            column,
            lambda line: None if (known := getattr(line, part)) is None else getattr(known, speed),
        )

    def of_peak(read: Callable[[DampedCritical], Cell]) -> Callable[[CriticalLine], Cell]:
        return lambda line: None if line.peak is None else read(line.peak)

    notes = {
        kind: left_out(answer, [line.peak for line in shown[kind] if line.peak])
        for kind, answer in (run.forced_by_kind or {}).items()
    }
    table = Table.of_records(
        "Critical speeds",
        [line for lines in shown.values() for line in lines],
        (Column("vibration", words=True), "vibration"),
        (SPEED, lambda line: "no peak" if line.speed is None else line.speed),
        (
            Column("range", words=True, missing="running"),
            lambda line: (
                "start" if line.passed(running) else "above" if line.above(running) else None
            ),
        ),
        beside("lowest", "margin", "low"),
        beside("highest", "margin", "high"),
        beside("undamped", "peak", "undamped_speed"),
        beside("ring locked", "peak", "locked_speed"),
        (Column("order", digits=None), "order"),
        (
            Column("mode", words=True),
            lambda line: peak_modes(line.peak) if line.peak else str(line.known.mode),
        ),
        (
            replace(FREQUENCY, missing=ABSENT),
            lambda line: line.critical.frequency if line.critical and not line.peak else None,
        ),
        (
            Column("phase sum", decimals=2, missing=ABSENT),
            lambda line: None if line.critical is None else line.critical.phase_sum,
        ),
        (Column("peak at", words=True, missing=ABSENT), of_peak(peak_place)),
        (Column("amplitude", missing=ABSENT), of_peak(lambda peak: peak_size(peak, units, 3))),
        (
            Column("damping", "%", decimals=2, missing=ABSENT),
            of_peak(lambda peak: peak.damping_ratio),
        ),
        (Column("margin", "%", decimals=1, missing="inside"), margin),
        (
            Column("limit used", "%", 3, missing=ABSENT),
            of_peak(lambda peak: None if np.isnan(peak.limit_used) else peak.limit_used),
        ),
        note=" ".join(f"{kind.capitalize()}: {text}" for kind, text in notes.items() if text),
        mark=_mark,
    )
    # A column that would say "none" of every speed says nothing.
    columns = zip(table.columns, zip(*table.rows, strict=True), strict=False)
    return table.select(
        *(
            column.name
            for column, cells in columns
            if any(
                (cell is not None and not (isinstance(cell, float) and math.isnan(cell)))
                for cell in cells
            )
        )
    )


def _shown(
    lines: Sequence[CriticalLine], modes: Vibration, running: tuple[float, float], most: int
) -> list[CriticalLine]:
    """Return the lines that a table of so many shows, see `speed_table`."""
    ranked = sorted(lines, key=lambda line: line.strength, reverse=True)
    kept = [line for line in ranked if not line.passed(running)][:most]
    passed = [line for line in ranked if line.passed(running)]
    beside = [mode.number for mode in modes.elastic_modes if not mode.of_crankshaft]
    firsts = [next((line for line in passed if line.modes[0] == number), None) for number in beside]
    chosen = [line for line in firsts if line is not None]
    others = [line for line in passed if line.peak and line not in chosen]
    return kept + chosen + others[: max(0, most // 3 - len(chosen))]


def _mark(line: CriticalLine) -> str:
    if line.peak is not None and line.peak.limit_used > 1.0:
        return "over"
    return "chosen" if line.phase_sum >= TOGETHER else ""


def critical_lines(run: EngineVibration, kind: str) -> list[CriticalLine]:
    """Return the results for each critical speed of one kind, combined by its mode and order.

    One order may have several peaks by one mode, each a critical speed of its own. Orders that damping
    leaves without a peak count at running speeds alone, and modes that no order brings to a peak have no
    margin.
    """
    forced = run.forced_of(kind)
    calculated = () if forced is None else (*forced.started_through, *forced.resonances)
    modes = run.modes(kind)
    met = {
        (critical.mode, critical.order): critical
        for critical in (*modes.started_through, *modes.criticals)
    }
    lines = [
        CriticalLine(kind, peak, met.get((peak.mode, peak.order)))
        for peak in calculated
        if is_listed(peak) and (peak.has_peak or peak.in_running_range)
    ]
    known = {(mode, peak.order) for peak in calculated for mode in (peak.mode, *peak.modes)}
    lines += [CriticalLine(kind, None, met[key]) for key in met.keys() - known]
    damped = {peak.mode for peak in calculated}
    damped -= {mode for peak in calculated if peak.has_peak for mode in (peak.mode, *peak.modes)}
    margins = [] if run.assessment is None else run.assessment.uncertainty[kind].critical
    for margin in margins:
        same = [
            place
            for place, line in enumerate(lines)
            if line.order == margin.order and margin.mode in line.modes
        ]
        if same:
            nearest = min(same, key=lambda place: _distance(lines[place], margin))
            line = lines[nearest]
            # A peak of several modes is that of the nearest of their critical speeds.
            if line.margin is None or _distance(line, margin) < _distance(line, line.margin):
                lines[nearest] = replace(line, margin=margin)
        elif margin.mode not in damped and (margin.mode, margin.order) not in known:
            lines.append(CriticalLine(kind, None, None, margin))
    return lines


def met_while_running(run: EngineVibration, kind: str) -> bool:
    """Whether any critical speed of one kind is a running speed."""
    running = run.running_range
    return any(
        line.speed is not None and not (line.passed(running) or line.above(running))
        for line in critical_lines(run, kind)
    )


def _distance(line: CriticalLine, margin: CriticalRange) -> float:
    return math.inf if line.speed is None else abs(line.speed - margin.nominal)
