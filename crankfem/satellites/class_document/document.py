"""The torsional vibration document of an engine: its parts in order, with their tables and diagrams."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from crankbase.diagrams import GREEN, ORANGE, figure, legend_below, with_gaps, write_title
from crankbase.errors import InputError
from crankbase.quantity import RPM, percent
from crankbase.sentences import amount, with_sentences
from crankbase.table import Column, Table
from crankfem.analyses.assumptions import assumed_values
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration.misfiring import permitted_at
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.limits_sections import LimitsInput
from crankfem.satellites.class_document import tables
from crankfem.satellites.class_document.firing_cases import (
    CUT_OUT,
    HIGHEST_SHARE,
    MEANING,
    MISFIRING,
    STRESS,
    FiringCases,
    damper_places,
    firing_cases,
    limit_of,
)
from crankfem.satellites.class_document.tables import mode_stars, shown_modes
from dynamics.assessment.verdict import Verdict
from dynamics.plots.curves import quantity_display
from dynamics.plots.harmonics import draw_star, finish_stars
from dynamics.plots.mode_shapes import draw_chain_shapes
from dynamics.torque import same_stars
from dynamics.wording import at_speed

# Stars in a row of a picture, and mode shapes in one picture.
STARS_IN_ROW, SHAPES = 5, 3
# Stars in a row of a picture of which two stand beside each other.
STARS_IN_HALF = 3
# Orders of single lines in a diagram over the speed.
MAIN_ORDERS = 4
FAILING_COLORS = {MISFIRING: ORANGE, CUT_OUT: GREEN}


def draw_modes(path: Path, run: EngineVibration, first: int) -> None:
    """Draw the shapes of some of the modes shown, from index `first` on."""
    result = run.torsional.chosen
    names = [short_name(name) for name in result.chain.chain.names]
    shown = shown_modes(run)[first : first + SHAPES]
    drawn = result.modes.drawn_shapes(shown, names, numbered=True)
    with figure(path, height=3.6) as axes:
        draw_chain_shapes(axes, drawn, MOTION["torsional"].quantity)


def star_rows(run: EngineVibration, mode: int) -> tuple[int, int]:
    """Return the numbers of rows and columns of the phase vectors of a mode."""
    count = len(same_stars(mode_stars(run, mode)))
    columns = min(STARS_IN_ROW, count)
    return -(-count // columns), columns


def draw_vectors(path: Path, run: EngineVibration, mode: int) -> None:
    """Draw the phase vectors of all orders in one mode, orders of equal shape together."""
    groups = same_stars(mode_stars(run, mode))
    rows, columns = star_rows(run, mode)
    with figure(path, width=1.5 * columns + 0.4, height=1.85 * rows) as axes:
        for place, group in enumerate(groups):
            row, column = divmod(place, columns)
            orders = ", ".join(f"{star.order:g}" for star in group[:5])
            more = " ..." if len(group) > 5 else ""
            center = (3.4 * column, -1.15 * 3.4 * row)
            draw_star(axes, group[0], f"{orders}{more}", center)
        finish_stars(axes, rows, columns)


def draw_stress(path: Path, run: EngineVibration, cases: FiringCases, place: int) -> None:
    """Draw the stress of one location over the speed: main orders, all orders, cylinders failing, limits."""
    series, forced = cases.normal[STRESS], run.forced_torsional
    limit = limit_of(cases.limits, STRESS, series.names[place])
    limits = {} if limit is None else {"continuous limit": permitted_at(limit, cases.speeds)}
    if limit is not None and limit.passing is not None:
        limits["limit for passing"] = limit.passing.at(cases.speeds)
    barred = [] if run.assessment is None else run.assessment.verdict.ranges_to_bar
    with figure(path, height=3.7) as axes:
        series.plot(
            axes,
            place,
            quantity="stress",
            limits=limits,
            barred=barred,
            main_orders=MAIN_ORDERS,
            running=None if forced is None else forced.running_range,
        )
        top = axes.get_ylim()[1]
        for way, envelope in cases.envelopes.items():
            values = envelope[:, place] / 1e6
            axes.plot(
                RPM * cases.speeds,
                with_gaps(values),
                color=FAILING_COLORS[way],
                linestyle="--",
                linewidth=1.2,
                label=f"{way}, worst of each",
            )
            top = max(top, 1.05 * float(np.max(values[np.isfinite(values)], initial=0.0)))
        axes.set_ylim(0.0, top)
        axes.set_ylabel(quantity_display("stress", "SI").label)
        legend_below(axes, 3)


@dataclass(frozen=True)
class DocumentTable:
    """A table, and the name of its file."""

    name: str
    table: Table


@dataclass(frozen=True)
class DocumentPicture:
    """A diagram: its file name, its caption, its drawing function, whether two fit in a row."""

    name: str
    caption: str
    draw: Callable[[Path], None]
    half: bool = False


@with_sentences
@dataclass(frozen=True)
class DocumentPart:
    """A part of the document: title, sentences, then tables and diagrams in their order.

    The name is used in addresses.
    """

    name: str
    title: str
    sentences: tuple[str, ...]
    items: tuple[DocumentTable | DocumentPicture, ...] = ()

    @property
    def tables(self) -> tuple[DocumentTable, ...]:
        """Its tables."""
        return tuple(entry for entry in self.items if isinstance(entry, DocumentTable))

    @property
    def pictures(self) -> tuple[DocumentPicture, ...]:
        """Its diagrams."""
        return tuple(entry for entry in self.items if isinstance(entry, DocumentPicture))


def check_submission(engine: EngineFile) -> None:
    """Refuse an engine without the data for the document, and permitted values for parts that it lacks."""
    if engine.gas is None and engine.gas_map is None:
        raise InputError(
            f"{engine.path.name}: has no gas pressure; allowed is a file with a section [gas] or [gas_map], "
            "because the document reports stresses."
        )
    limits = engine.limits or LimitsInput()
    if limits.generator_angle is not None and engine.engine.generator_poles is None:
        raise InputError(
            "limits.generator_angle: given without engine.generator_poles; allowed are both, because the "
            "poles make electrical degrees of mechanical ones."
        )


def check_damper_limits(run: EngineVibration) -> None:
    """Refuse permitted values of a torsional damper that the chain does not have."""
    limits = run.engine_file.limits or LimitsInput()
    for name in ("damper_torque", "damper_heat"):
        if getattr(limits, name) is not None and not damper_places(run.torsional_chain):
            raise InputError(
                f"limits.{name}: given for an engine without a torsional damper; allowed is a chain with a "
                'node "damper ring", because the value is that of the damper.'
            )


GEAR_HAMMER = "Gear hammer"
# Of tables by the name of their first column, the column of the share that is used.
JUDGED = {"gear": 4, "firing": 5, "part": 7}


def class_document(run: EngineVibration) -> tuple[DocumentPart, ...]:
    """Return the parts of the document.

    Parameters
    ----------
    run : EngineVibration
        With gas pressure.
    """
    check_damper_limits(run)
    cases = firing_cases(run)
    assert run.assessment is not None
    verdict = run.assessment.verdict
    rigid, load = run.torsional.chosen.modes.rigid, run.load
    limits = [DocumentTable("limits", tables.limit_source_table(cases))]
    if (axial_limits := tables.axial_limit_table(run)) is not None:
        limits.append(DocumentTable("axial_limits", axial_limits))

    def campbell(path: Path) -> None:
        with figure(path, height=3.8) as axes:
            run.plot(axes)
            write_title(axes, "")

    return (
        _findings(run, cases),
        DocumentPart(
            "plant",
            "System data and plant",
            (f"Source of the torsional chain: {run.torsional.chosen.remark.rstrip('.')}.",),
            (
                DocumentTable("engine", tables.engine_data_table(run)),
                DocumentTable("masses", tables.chain_mass_table(run.torsional_chain)),
                DocumentTable("shafts", tables.chain_shaft_table(run)),
            ),
        ),
        _modes(run),
        DocumentPart(
            "vectors",
            "Phase vectors and vector sums",
            (
                "Diagrams: phase vectors of the cylinders, with lengths from the mode shape. Orders with "
                "equal diagrams share one; the dark arrow is the sum of a minor order.",
            ),
            (
                DocumentTable("vector_sums", tables.vector_table(run)),
                *(
                    DocumentPicture(
                        f"vectors_{mode - rigid + 1}",
                        f"Mode {mode - rigid + 1}: cylinders by order.",
                        partial(draw_vectors, run=run, mode=mode),
                        half=star_rows(run, mode)[1] <= STARS_IN_HALF,
                    )
                    for mode in shown_modes(run)
                ),
            ),
        ),
        DocumentPart(
            "excitation",
            "Harmonics of the tangential force",
            ()
            if load is None
            else tuple(
                f"{_upper(text).rstrip('.')}." for text in (load.sentence, load.rated.sentence)
            ),
            (DocumentTable("tangential_harmonics", tables.harmonics_table(run)),),
        ),
        DocumentPart(
            "criticals",
            "Critical speeds",
            tables.major_sentences(run),
            (
                DocumentTable("critical_speeds", tables.critical_table(run)),
                DocumentPicture(
                    "campbell",
                    "Campbell diagram: running range shaded, damped frequencies; dots mark resonances, "
                    "larger for larger amplitudes.",
                    campbell,
                ),
            ),
        ),
        _normal(run, cases),
        _failing(run, cases),
        _barred(run, verdict),
        _uncertainty(run),
        _dampers(run, cases),
        DocumentPart("limits", "Limits", (), tuple(limits)),
        _assumptions(run, cases),
    )


def _uncertainty(run: EngineVibration) -> DocumentPart:
    """What is uncertain of the kinds of vibration that are judged."""
    assert run.assessment is not None
    judged = ["torsional"] if tables.axial_limit_table(run) is None else ["torsional", "axial"]
    sentences = [] if run.bearings is None else [_upper(run.bearings.stiffness_range)]
    listed = []
    for kind in judged:
        for part in run.assessment.uncertainty[kind].parts():
            if isinstance(part, Table):
                listed.append(DocumentTable(f"uncertain_{kind}", part))
            else:
                sentences.append(part)
    stated = tuple(f"{sentence.rstrip('.')}." for sentence in sentences)
    return DocumentPart("uncertainty", "Uncertainty", stated, tuple(listed))


def _findings(run: EngineVibration, cases: FiringCases) -> DocumentPart:
    assert run.assessment is not None
    sentences = [run.assessment.conclusion]
    for way in cases.failing:
        places = cases.normal[STRESS].names
        name = max(places, key=lambda place: cases.worst(way, STRESS, place).severity)
        worst = cases.worst(way, STRESS, name)
        sentences.append(
            f"With {way}, the stress limits are {'kept' if worst.used <= 1.0 else 'exceeded'}. The worst "
            f"case is {name} with cylinder {cases.worst_cylinder(way, STRESS, name)} failing: "
            f"{amount(worst.value, 'Pa', 4)} at {at_speed(worst.speed)}, "
            f"{percent(worst.used, 3)} % of the permitted stress."
        )
    sentences.append(tables.major_sentences(run)[0])
    for what, table in (
        (GEAR_HAMMER, tables.gear_table(run, cases)),
        ("Permitted angle of the generator", tables.generator_table(run, cases)),
        ("Permitted values of dampers and couplings", tables.damper_table(run, cases)),
    ):
        sentences += () if table is None else _kept_or_exceeded(what, table)
    return DocumentPart("findings", "Findings", tuple(sentences))


def _upper(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}"


def _kept_or_exceeded(what: str, table: Table) -> tuple[str, ...]:
    """State whether the rows of a table keep their limits; empty if unknown."""
    judged = [row for row in table.rows if row[JUDGED[table.columns[0].name]] is not None]
    rows = [
        ", ".join(str(cell) for cell in row[:2] if isinstance(cell, str))
        for row, mark in zip(table.rows, table.marks, strict=True)
        if mark == "over"
    ]
    kept, exceeded = (
        ("none in normal running", "teeth part") if what == GEAR_HAMMER else ("kept", "exceeded")
    )
    if rows:
        return (f"{what}: {exceeded} ({'; '.join(rows)}).",)
    return (f"{what}: {kept}.",) if judged else ()


def _modes(run: EngineVibration) -> DocumentPart:
    result = run.torsional.chosen
    shown = tables.shown_modes(run)
    chain, modes = result.chain.chain, result.modes
    items: list[DocumentTable | DocumentPicture] = [
        DocumentTable("frequencies", tables.mode_list_table(run))
    ]
    for first in range(0, len(shown), SHAPES):
        numbers = [mode - modes.rigid + 1 for mode in shown[first : first + SHAPES]]
        items.append(
            DocumentPicture(
                f"modes_{numbers[0]}",
                f"{'Shapes of modes' if len(numbers) > 1 else 'Shape of mode'} "
                f"{', '.join(map(str, numbers))}; crosses mark the nodes.",
                partial(draw_modes, run=run, first=first),
            )
        )
    for mode in shown:
        number, holzer = mode - modes.rigid + 1, tables.holzer_table(chain, modes, mode)
        masses, shafts = (
            table(chain, holzer, number) for table in (tables.mass_table, tables.shaft_table)
        )
        items += [
            DocumentTable(f"holzer_masses_{number}", masses),
            DocumentTable(f"holzer_shafts_{number}", shafts),
        ]
    return DocumentPart(
        "holzer",
        "Natural frequencies, Holzer tables and mode shapes",
        (
            "Holzer tables are given for the modes excited by orders up to "
            f"{run.engine_file.vibration.highest_order:g} below {100.0 * HIGHEST_SHARE:g} % of the rated "
            f"speed, {tables.LEAST_MODES} at least and {tables.MOST_MODES} at most.",
        ),
        tuple(items),
    )


def _normal(run: EngineVibration, cases: FiringCases) -> DocumentPart:
    drawn = [
        DocumentPicture(
            f"stress_{number}",
            f"No. {number}, {name}.",
            partial(draw_stress, run=run, cases=cases, place=number - 1),
        )
        for name, number in tables.place_numbers(cases).items()
    ]
    orders = tables.order_tables(cases)
    return DocumentPart(
        "stresses",
        "Torsional stresses in normal running",
        (
            *(f"{_upper(note)}." for note in cases.notes),
            "Diagrams: stress over speed; ranges to be barred are red, speeds outside the running range "
            "gray. With a cylinder failing: the worst of all cylinders.",
        ),
        (
            DocumentTable("stress_normal", tables.normal_table(cases)),
            DocumentTable("stress_permitted", tables.permitted_table(run, cases)),
            *(
                DocumentTable(f"stress_by_order{'' if len(orders) == 1 else f'_{place}'}", table)
                for place, table in enumerate(orders, start=1)
            ),
            DocumentTable("torques", tables.torque_table(cases)),
            *drawn,
        ),
    )


def _failing(run: EngineVibration, cases: FiringCases) -> DocumentPart:
    items = []
    for way in cases.failing:
        name = way.split()[-1] if "cut" not in way else "cut_out"
        items += [
            DocumentTable(f"stress_{name}", tables.failing_table(cases, way)),
            DocumentTable(f"stress_{name}_each", tables.each_table(cases, way)),
        ]
    assert run.misfiring is not None or run.misfiring_note
    title = "One cylinder misfiring, one cut out"
    if MISFIRING not in cases.failing:
        title = "One cylinder cut out"
    sentence = () if run.misfiring is None else (run.misfiring.sentence,)
    meaning = tuple(f"{_upper(way)}: {MEANING[way]}." for way in cases.failing)
    return DocumentPart("failing", title, (*meaning, *sentence), tuple(items))


def _barred(run: EngineVibration, verdict: Verdict) -> DocumentPart:
    if not (verdict.barred or verdict.started_through):
        return DocumentPart("barred", "Barred speed ranges", ("No speed range has to be barred.",))
    listed = [DocumentTable("barred_ranges", tables.barred_table(verdict))]
    peaks = sorted({peak for barred in verdict.barred for peak in barred.peaks})
    if peaks:
        rule = (run.engine_file.limits or LimitsInput()).barred_rule(
            run.engine_file.engine.rated_speed
        )
        ends = Table(
            "Ends by the rule for each peak in these ranges",
            [
                Column(name, "1/min", decimals=2)
                for name in ("peak n", "16 n/(18 - r)", "(18 - r) n/16")
            ],
            [[peak, *rule.bounds(peak)] for peak in peaks],
            note="r is n divided by the rated speed (IACS M68). A range extends to where limits are kept, "
            "if that is wider.",
        )
        listed.append(DocumentTable("barred_by_rule", ends))
    sentence = (
        "Barred ranges are to be passed quickly; the table of normal running gives the stresses while "
        "passing."
        if verdict.ranges_to_bar
        else "No range in which a limit is exceeded can be barred, or has to be."
    )
    return DocumentPart("barred", "Barred speed ranges", (sentence,), tuple(listed))


def _dampers(run: EngineVibration, cases: FiringCases) -> DocumentPart:
    made = {
        "dampers": tables.damper_table(run, cases),
        "gears": tables.gear_table(run, cases),
        "generator": tables.generator_table(run, cases),
    }
    missing = {
        "dampers": "Dampers and couplings: the torsional chain has none that dissipate vibration energy.",
        "gears": "Gear hammer: the torsional chain has no gears.",
        "generator": "Generator: none is driven, so there is no electrical angle."
        if run.engine_file.engine.drives != "generator"
        else "Generator: its poles are not given (engine.generator_poles), so its electrical angle is not "
        "known.",
    }
    return DocumentPart(
        "dampers",
        "Dampers, couplings, gears, generator",
        tuple(words for name, words in missing.items() if made[name] is None),
        tuple(DocumentTable(name, table) for name, table in made.items() if table is not None),
    )


def _assumptions(run: EngineVibration, cases: FiringCases) -> DocumentPart:
    assert run.assessment is not None
    remarks: Sequence[str] = (
        *run.assessment.remarks,
        *(() if run.forced_torsional is None else run.forced_torsional.remarks),
        *(() if run.misfiring is None else run.misfiring.remarks[1:]),
        *cases.notes,
        "chains are linear; torques of cylinders act at their cranks, at constant speed",
    )
    values = assumed_values(run.engine_file)
    return DocumentPart(
        "assumptions",
        "Assumptions",
        tuple(dict.fromkeys(f"{_upper(assumed).rstrip('.')}." for assumed in remarks)),
        (
            DocumentTable(
                "assumptions",
                Table(
                    "Assumed values",
                    [Column(name, words=True) for name in ("field", "value", "why")],
                    [[assumed.field, assumed.given, assumed.source] for assumed in values],
                ),
            ),
        ),
    )
