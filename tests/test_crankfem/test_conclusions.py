"""What a run concludes, on the console and in the report."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from concluded import (
    BEARINGS,
    CHANGES,
    above_running_speeds,
    acceptable,
    axial_free_end,
    changed_results,
    conclusions,
    part,
    weak,
    with_parts,
)
from crankbase.table import parse_output_units
from crankfem.analyses.findings import (
    failed_checks,
    headline,
    main_findings,
    verdict_line,
)
from crankfem.analyses.vibration.assessment import Assessment, engine_decision, factor_range
from crankfem.analyses.vibration.engine_limits import engine_limits, engine_verdict
from crankfem.analyses.vibration.misfiring import FiringCheck, Reached
from crankfem.analyses.vibration.modes import Vibration
from crankfem.analyses.vibration.tables import (
    assessment_parts,
    critical_lines,
    misfiring_table,
    resonance_table,
    speed_table,
)
from crankfem.cli import console
from crankfem.cli.commands.run import _parts
from crankfem.files.engine.engine_file import load_engine
from crankfem.report.summary import summary, uncertain_sentence, worst_of_each
from crankfem.report.text_filters import loaded_most
from dynamics.assessment.limits import AmplitudeCurve, given_limit
from dynamics.assessment.uncertainty import Spread
from dynamics.plots.mode_shapes import chain_places, crosses_on_axis
from dynamics.wording import VERDICTS
from stand_ins import stored_results, typed

NUMBER = re.compile(r"(?<![\w.-])\d+(?:\.\d+)?(?:e-?\d+)?")
# Scales in which sentences write SI values: themselves, MPa, mrad, um, per cent.
SCALES = (1.0, 1e-6, 1e3, 1e6, 100.0)


@pytest.fixture
def results():
    return stored_results()


def verdict_parts(results):
    return typed(results).vibration, typed(results).strength


def printed(results, width, monkeypatch, capsys, full=False):
    assessment = results["vibration"]["assessment"]
    assessment |= {"running_rpm": [200.0, 515.0], "beside": []}
    assessment["limits"] = [one | {"judged_to_rpm": 575.0} for one in assessment["limits"]]
    assessment["barred"] = [one | {"ends": "not kept"} for one in assessment["barred"]]
    results["study"] = None
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(console, "output", console.Terminal(markup=False, width=width))
    answers = ("Report: somewhere/report.html", verdict_line(*verdict_parts(results)))
    console.print_parts(_parts(typed(results), console.SI), console.SI, answers, full=full)
    return capsys.readouterr().out.splitlines()


def numbers_within(record):
    """All numbers of a record, and those within its texts."""
    if isinstance(record, dict):
        for one in record.values():
            yield from numbers_within(one)
    elif isinstance(record, list):
        yield float(len(record))
        for one in record:
            yield from numbers_within(one)
    elif isinstance(record, str):
        yield from (float(one) for one in NUMBER.findall(record))
    elif isinstance(record, int | float) and not isinstance(record, bool):
        yield abs(float(record))


def test_every_number_concluded_is_one_of_the_record(results):
    assessment, inputs = results["vibration"]["assessment"], results["inputs"]
    worst = assessment["checks"][0]
    known = {*numbers_within(assessment), *numbers_within(results["engine"])}
    known |= {float(sum(one["assumed"] for one in inputs)), float(len(inputs))}
    known.add(float(sum(not one["passed"] for one in assessment["checks"]) - 1))
    resonant = ("at resonance", "near resonance")
    parts = [one for one in worst["cause"]["orders"] if one["state"] in resonant]
    known.add(worst["value"] - sum(one["contribution"] for one in parts))
    shown = [one for line in conclusions(typed(results)) for one in NUMBER.findall(line)]
    assert len(shown) > 15
    for text in shown:
        # Three digits may differ by half of the last one.
        assert any(
            abs(float(text) - scale * one) <= 0.0051 * abs(float(text))
            for one in known
            for scale in SCALES
        ), text


@pytest.mark.slow
def test_three_to_six_statements():
    assert {len(conclusions(typed(changed_results(name)))) for name in CHANGES} <= {3, 4, 5, 6}


def test_what_stands_on_the_first_screen_is_short(results):
    none = with_parts(results, part(1.5, 22e6, "forced"), part(6.0, 3e6, "near resonance", 2))
    barred = none["vibration"]["assessment"]["barred"]
    barred += [barred[0] | {"allowed": True, "refusals": []}, barred[0]]
    found = main_findings(typed(none).findings)
    assert [finding.about for finding, _ in found] == ["Why", "What helps", "Assumed"]
    assert max(len(text.split()) for _, text in found) <= 30


def test_nothing_is_said_of_checks_that_are_met(results):
    for one in results["checks"]:
        one["met"] = True
    assert failed_checks(typed(results).checks) == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("undecided", "barred"),
        ("misfires", "bad"),
        ("misfires alone", "barred"),  # amber, not green
        ("too weak alone", "bad"),
    ],
)
def test_the_color_of_the_verdict(name, status):
    assert summary(typed(changed_results(name)))["status"] == status


def test_a_crankshaft_strong_enough_leaves_the_verdict_as_it_is(results):
    weak(results)["strength"] = 2.0
    acceptable(results)
    assert summary(typed(results))["status"] == "fine"
    assert "M53" not in headline(*verdict_parts(results))


def test_a_mode_divided_between_two_is_on_its_card_by_both(results):
    results["vibration"]["bearings"] = BEARINGS | {"shaft": {"axial": [80.0, 90.0]}}
    mode = results["vibration"]["whole"]["chains"]["axial"]["modes"][0]
    for further, shown in ((None, "81.1 Hz (80.0 to 90.0 Hz)"), (60.0, "60.0 and 81.1 Hz")):
        mode["further_frequency"] = further
        details = summary(typed(results))["frequencies"][0]["details"]
        assert any(one.endswith(shown) for one in details)


@pytest.mark.slow
@pytest.mark.parametrize("width", [80, 200])
def test_the_console_says_the_verdict_last_in_few_lines(results, width, monkeypatch, capsys):
    lines = printed(results, width, monkeypatch, capsys)
    assert len(lines) <= console.LINES
    assert " ".join(lines).endswith(verdict_line(*verdict_parts(results)))


@pytest.mark.parametrize("width", [70, 200])
def test_lines_wrap_at_the_width_of_the_terminal_and_names_stay_whole(
    results, width, monkeypatch, capsys
):
    lines = printed(results, width, monkeypatch, capsys)
    assert max(map(len, lines)) <= width
    assert max(map(len, lines)) > 0.8 * width
    name = "a/path-with-hyphens-6chn25-34/" + 12 * "long-" + "report.html"
    console.print_line(f"- Of the engine 6chn25-34, whose name is not broken, {name}")
    text = capsys.readouterr().out
    assert "6chn25-34," in text.split()
    assert name in text.split()


def test_where_a_program_reads_lines_are_not_wrapped(results, monkeypatch, capsys):
    monkeypatch.delenv("COLUMNS", raising=False)
    console.print_line(60 * "word ")
    assert len(capsys.readouterr().out.splitlines()) == 1


@pytest.mark.parametrize("full", [False, True])
def test_all_tables_are_printed_if_asked_for(results, full, monkeypatch, capsys):
    lines = printed(results, 200, monkeypatch, capsys, full)
    assert sum(line == "Critical speeds" for line in lines) == 1
    assert any(line.startswith("Throw by finite elements") for line in lines) == full


def test_above_the_running_range_is_told_where_it_is_worse_and_of_which_place(results):
    assessment = results["vibration"]["assessment"]

    def use(used):
        return {"speed_rpm": 550.0, "value": used, "permitted": 1.0, "used": used}

    def worst(*uses):
        first = assessment["checks"][0]
        assessment["checks"] = [
            first | {"place": place, "running": use(running), "above": use(above)}
            for place, running, above in uses
        ]
        return worst_of_each(typed(results).vibration.assessment.verdict.checks)

    (found,) = worst(("a", 3.4, 2.6), ("b", 3.3, 2.7))
    assert (found.check.place, found.above) == ("a", None)
    (found,) = worst(("a", 3.4, 2.6), ("b", 3.3, 3.6))
    assert (found.check.place, found.place_above, found.above.used) == ("a", "b", 3.6)


def test_what_is_uncertain_names_the_bearings_and_the_crankshafts_own_first_mode(results):
    vibration = results["vibration"]

    def told():
        read = typed(results).vibration
        return uncertain_sentence(read, read.assessment, "torsional")

    assert "bearings" not in told()
    vibration["bearings"] = BEARINGS | {"stiffness": [2.2e8, 2.2e9, 2.2e10]}
    first, second = (one for one in vibration["torsional"]["modes"] if one["number"] in (1, 2))
    first["of_crankshaft"], second["of_crankshaft"] = False, True
    bounds = vibration["assessment"]["uncertainty"]["torsional"]["frequencies"][1]
    said = told()
    assert "2.2e8 to 2.2e10 N/m" in said
    ends = re.findall(r"[\d.]*\d", said)[-2:]
    assert [float(end) for end in ends] == close([bounds["low"], bounds["high"]], rel=5e-3)
    # The range of the chain may not hold the frequency of the better model, whose own range stands beside it.
    vibration["bearings"]["shaft"] = {"torsional": [50.0, None, 70.0]}
    assert "50.0 to 70.0 Hz" in told()


@pytest.mark.parametrize(
    ("low", "high", "written"),
    [
        (0.99668, 1.00332, "-0.33 to +0.33 % of"),
        (1.0, 1.019, "+0 to +1.9 % of"),
        (0.5, 1.02, "0.5 to 1.02 times"),
    ],
)
def test_a_range_on_both_sides_of_the_value_used_shows_both(low, high, written):
    assert factor_range(Spread("compliance", low, high)) == written


def test_bearings_that_are_alike_are_counted():
    sizes = {"a": 1.0, "b": 2.0 - 1e-12, "c": 2.0}
    loads = [SimpleNamespace(name=name, largest=size) for name, size in sizes.items()]
    assert [load.name for load in loaded_most(loads)] == ["b", "c"]


def test_a_node_on_a_branch_is_told_by_its_branch(results):
    mode = {"number": 1, "frequency": 30.0, "node_positions": [1.25, 2.4]}
    mode |= {"rigid": False, "of_crankshaft": True, "crankshaft_share": 1.0, "shape": []}
    record = results["vibration"]["torsional"] | {
        "nodes": ["end", "a", "wheel", "ring"],
        "connections": [[0, 1], [1, 2], [0, 3]],
        "modes": [mode],
    }
    (row,) = Vibration.from_record(record).mode_table().texts()
    assert re.findall(r"[\d.]+", row[-1]) == ["2.25", "0.40"]
    assert row[-1].endswith("end to ring")


def test_a_damper_ring_stands_before_the_free_end_and_later_nodes_close_up():
    # Free end, cylinder, flywheel, ring at the free end, generator behind the flywheel, a disc on a branch.
    pairs = [(0, 1), (1, 2), (0, 3), (2, 4), (1, 5)]
    places = chain_places(6, pairs)
    assert places.tolist() == [0.0, 1.0, 2.0, -1.0, 3.0, 1.5]
    # A node in the middle of the ring's element, and one on that from cylinder to flywheel.
    assert crosses_on_axis((2.5, 1.25), pairs, places) == [-0.5, 1.25]
    assert chain_places(3, [(0, 1), (1, 2)]).tolist() == [0.0, 1.0, 2.0]


def test_uses_at_and_above_running_speeds_stand_apart(results):
    above_running_speeds(results)
    (shown,) = worst_of_each(typed(results).vibration.assessment.verdict.checks[:2])
    assert (shown.use.used, shown.above.used) == (0.9, 1.2)


def test_every_sentence_takes_the_limit_that_decides():
    results = changed_results("propeller shaft decides")
    tile = summary(typed(results))["tiles"][0]
    assert (tile["value"], tile["mark"]) == ("123 %", "over")
    assert "123 %" in verdict_line(*verdict_parts(results))
    assert any("118 MPa" in text and "123 %" in text for text in conclusions(typed(results)))
    assert typed(results).vibration.assessment.verdict.deciding.passing


def test_what_the_bearings_change_is_told_once():
    results = changed_results("bearings")
    said = " ".join(conclusions(typed(results)))
    assert [said.count(one) for one in results["vibration"]["bearings"]["sentences"]] == [1, 1]


def test_axial_vibration_with_a_limit_is_not_called_unjudged(results):
    axial_free_end(9e-3, 1e-4, 2e-4, 3e-4, 8e-3)(results)
    assert any("not judged" in one for one in conclusions(typed(results)))
    results["vibration"]["assessment"]["limits"][0] |= {"name": "axial amplitude", "unit": "m"}
    assert not any("not judged" in one for one in conclusions(typed(results)))


def test_the_whole_crankshaft_stands_on_the_first_screen():
    found = conclusions(typed(changed_results("first screen of the whole")))
    (said,) = [one for one in found if one.startswith("It differs.")]
    assert said in found[:4]
    amounts = ("55.5 kN at 497 1/min", "117 kN at 501 1/min", "order 6 at 495 1/min", "1.2 %")
    assert all(one in said for one in amounts)


RATED = load_engine("6chn25-34").engine.rated_speed
SPEEDS = np.linspace(0.1, 1.2, 2201) * RATED


def decided(*peaks, **limits):
    """Return the decision on peaks, as `judged` does."""
    return judged(*peaks, **limits)[1]


def judged(*peaks, **limits):
    """Peaks at shares of the rated speed [MPa], narrow."""
    engine = load_engine("6chn25-34").changed(engine={"drives": "propeller"})
    if limits:
        engine = engine.changed(limits=limits)
    stress = sum(
        1e6 * height / (1.0 + ((SPEEDS / RATED - at) / 0.002) ** 2) for at, height in peaks
    )
    limit = engine_limits(engine)[0]["crankshaft_stress"]
    findings = [(limit, AmplitudeCurve("throw 1 - throw 2", SPEEDS, stress))]
    verdict = engine_verdict(engine, findings)
    return verdict, engine_decision(engine, verdict.status, findings)


# By the rule 45 - 24 r^2 is permitted, up to r = 0.8 twice that in passing: at 0.9 25.56, at 0.6 36.36 and
# 72.72 N/mm2.
KEPT, PASSED = (0.9, 25.56 * 1.1005), (0.6, 72.72 * 1.1)


def named(found):
    """Strengths and fields of a decision's sentence, in turn."""
    return re.findall(r"\d+ MPa|limits\.\w+", found.sentence)


def test_the_tensile_strength_decides_on_what_is_kept():
    # 440 (1 + 3/2 0.1005) = 506.3
    assert named(decided(KEPT)) == ["507 MPa", "506 MPa", "440 MPa", "limits.tensile_strength"]


def test_the_yield_strength_decides_on_what_is_passed():
    assert named(decided(PASSED)) == ["248 MPa", "247 MPa", "225 MPa", "limits.yield_strength"]


def test_both_decide_together():
    # Kept asks for 506 MPa, which brings 259 MPa of yield strength: more than the 247.5 that passing asks.
    found = decided(KEPT, PASSED)
    assert found.status == "undecided"
    assert named(found)[0].startswith("50")
    assert named(found)[-2:] == ["limits.tensile_strength", "limits.yield_strength"]


def test_no_steel_is_tried_that_breaks_before_it_yields():
    engine = load_engine("7l32-40-set")  # 800 and 550 MPa, both assumed
    limit = engine_limits(engine)[0]["crankshaft_stress"]
    speeds = np.linspace(0.9, 1.1, 41) * engine.engine.rated_speed
    findings = [(limit, AmplitudeCurve("throw 1 - throw 2", speeds, np.full(41, 27e6)))]
    tried = engine_decision(engine, "fine", findings).trials
    assert {trial.field for trial in tried} == {"limits.tensile_strength"}
    assert min(trial.value for trial in tried) >= 550e6
    assert {trial.status for trial in tried} == {"fine", "not acceptable"}


@pytest.mark.parametrize(
    "limits", [{"tensile_strength": 480e6, "yield_strength": 260e6}, {"crankshaft_stress": 20e6}]
)
def test_what_is_given_is_not_tried(limits):
    found = decided(KEPT, **limits)
    assert (found.status, found.trials) == ("not acceptable", ())


@pytest.mark.parametrize(
    ("peaks", "limits", "begins"),
    [
        ((KEPT,), {}, f"{VERDICTS['undecided']}: "),
        ((KEPT,), {"crankshaft_stress": 20e6}, f"{VERDICTS['not acceptable']}: "),
        (((0.9, 1.0),), {"crankshaft_stress": 20e6}, f"{VERDICTS['fine']} from "),
    ],
)
def test_there_is_one_conclusion(peaks, limits, begins):
    verdict, decision = judged(*peaks, **limits)
    said = Assessment(verdict, decision, {}, (), {}).conclusion
    assert said.startswith(begins)
    # The status of the values used is told as theirs where it is not the conclusion.
    used = f"With the values used, {verdict.sentence[0].lower()}{verdict.sentence[1:]}"
    assert said.endswith(used if decision.status == "undecided" else verdict.sentence)


STRESS = given_limit("torsional stress", 20e6, "Pa", applies_to="crankshaft", source="maker")
RPM = math.pi / 30.0


def check(normal, misfiring):
    return FiringCheck(STRESS.name, "Pa", STRESS, normal, (4,), misfiring, {(4,): misfiring})


def reached(value, permitted=20e6, place="cylinder 4 - flywheel", speed=1000.0):
    return Reached(place, speed * RPM, value, permitted)


def test_what_normal_firing_exceeds_stands_out_like_what_misfiring_does():
    checks = [check(reached(52e6), reached(18e6)), check(reached(18e6), reached(math.inf))]
    assert list(misfiring_table(SimpleNamespace(checks=checks)).marks) == ["over", "", "", "over"]


@pytest.mark.parametrize(
    ("normal", "misfiring", "said"),
    [
        # What is permitted is told once where it is the same.
        (reached(30e6), reached(29e6), ["29 MPa", "145 %", "20 MPa", "30 MPa", "150 %"]),
        (
            reached(30e6, 25e6, "free end", 900.0),
            reached(29e6),
            ["29 MPa", "145 %", "20 MPa", "30 MPa", "120 %", "25 MPa"],
        ),
        # A share has no use where nothing is permitted, or all is unbounded.
        (reached(30e6, math.inf), reached(29e6), ["29 MPa", "145 %", "20 MPa", "30 MPa"]),
        (reached(30e6), reached(math.inf), ["20 MPa", "30 MPa", "150 %", "20 MPa"]),
    ],
)
def test_normal_firing_is_told_with_its_share(normal, misfiring, said):
    assert re.findall(r"\d+ (?:MPa|%)", check(normal, misfiring).sentence) == said


def test_a_critical_speed_stands_once_with_all_that_is_known_of_it(results):
    vibration = results["vibration"]
    table = speed_table(typed(results).vibration)
    names = [column.name for column in table.columns]
    kinds, orders, modes = (
        [row[names.index(name)] for row in table.rows] for name in ("vibration", "order", "mode")
    )
    assert len(set(zip(kinds, orders, modes, strict=True))) == len(table.rows)
    one = next(
        row for row in table.rows if row[0] == "torsional" and row[names.index("order")] == 12
    )
    peak = next(p for p in vibration["forced"]["torsional"]["resonances"] if p["order"] == 12.0)
    limits = vibration["assessment"]["uncertainty"]["torsional"]["critical"]
    own = next(p for p in limits if p["order"] == 12.0)
    shown = table.texts()[table.rows.index(one)]
    assert shown[names.index("speed")] == f"{peak['speed_rpm']:.1f}"
    assert shown[names.index("lowest")] == f"{own['low_rpm']:.1f}"
    assert shown[names.index("amplitude")] == "1.42 mrad"


def test_each_of_two_peaks_of_one_mode_has_a_row(results):
    peaks = results["vibration"]["forced"]["torsional"]["resonances"]
    first = next(one for one in peaks if one["order"] == 12.0)
    peaks.append({**first, "speed_rpm": 0.9 * first["speed_rpm"], "value": 0.5e-3})
    table = speed_table(typed(results).vibration, most=99)
    names = [column.name for column in table.columns]
    rows = [
        dict(zip(names, texts, strict=True))
        for texts in table.texts()
        if texts[0] == "torsional" and texts[names.index("order")] == "12"
    ]
    assert [row["amplitude"] for row in rows] == ["0.5 mrad", "1.42 mrad"]
    # Bounds belong to the peak they are about.
    assert (rows[0]["lowest"], rows[1]["lowest"] != "-") == ("-", True)


def test_a_peak_of_two_modes_has_the_range_about_its_own_speed(results):
    vibration = results["vibration"]
    peaks = vibration["forced"]["torsional"]["resonances"]
    peak = next(one for one in peaks if one["order"] == 12.0)
    peak["modes"] = [peak["mode"], peak["mode"] + 1]
    bounds = vibration["assessment"]["uncertainty"]["torsional"]["critical"]
    own = next(one for one in bounds if one["order"] == 12.0)
    faster = {name: 1.2 * own[name] for name in ("speed_rpm", "low_rpm", "high_rpm")}
    bounds.append({**own, **faster, "mode": peak["mode"] + 1})
    (line,) = (
        one for one in critical_lines(typed(results).vibration, "torsional") if one.order == 12
    )
    assert line.margin.low <= line.speed <= line.margin.high


def test_no_critical_speed_is_both_inside_and_outside_the_running_range(results):
    vibration = results["vibration"]
    high = 520.0
    vibration["assessment"]["running_rpm"] = [300.0, high]
    peak = next(
        one for one in vibration["forced"]["torsional"]["resonances"] if one["order"] == 12.0
    )
    peak |= {"speed_rpm": 1.01 * high, "in_running_range": False}
    bounds = vibration["assessment"]["uncertainty"]["torsional"]["critical"]
    own = next(one for one in bounds if one["order"] == 12.0)
    own |= {"speed_rpm": 1.01 * high, "low_rpm": 0.99 * high, "margin": 0.0}
    # An order that has no peak at speeds calculated, just above the running range too.
    bounds.append({**own, "order": 30.0})
    table = speed_table(typed(results).vibration, most=99)
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, texts, strict=True)) for texts in table.texts()]
    one, other = (
        next(row for row in rows if (row["vibration"], row["order"]) == ("torsional", order))
        for order in ("12", "30")
    )
    # Outside there is a margin, though nothing may be left of it.
    assert (one["margin"], other["margin"]) == ("0.0", "0.0")


def test_an_order_without_a_peak_is_not_called_unbounded(results):
    one = results["vibration"]["forced"]["axial"]["resonances"][0]
    one |= {"speed_rpm": None, "amplitude": None, "unbounded": False}
    table = speed_table(typed(results).vibration, most=99)
    (row,) = (texts for texts in table.texts() if "no peak" in texts)
    assert row[[column.name for column in table.columns].index("amplitude")] == "-"
    assert not any("unbounded" in text for text in row)


def test_a_mode_that_makes_no_peak_has_no_critical_speed_outside(results):
    """Nor a margin to one, of an order beyond the speeds calculated."""
    vibration = results["vibration"]
    peaks = vibration["forced"]["axial"]["resonances"]
    damped = {"mode": 7, "modes": [], "order": 12.0, "speed_rpm": None, "severity": 0.0}
    peaks.append({**peaks[0], **damped, "in_running_range": False})
    bounds = {"mode": 7, "order": 11.0, "margin": 0.0, "speed_rpm": 650.0}
    critical = vibration["assessment"]["uncertainty"]["axial"]["critical"]
    critical.append(bounds | {"low_rpm": 30.0, "high_rpm": 660.0})
    met = vibration["axial"]["criticals"]
    met.append({**met[0], "mode": 7, "order": 12.0, "in_running_range": False})

    def modes():
        table = speed_table(typed(results).vibration, most=99)
        place = [column.name for column in table.columns].index("mode")
        return {texts[place] for texts in table.texts() if texts[0] == "axial"}

    assert "7" not in modes()
    peaks[-1]["in_running_range"] = True
    assert "7" in modes()


def test_every_peak_is_in_the_table_or_told_to_be_left_out(results):
    """A branch's peak counts by its own largest one, small peaks and those of the forces in a sentence."""
    record = results["vibration"]["forced"]["torsional"]
    one = next(own for own in record["resonances"] if own["order"] == 12.0)
    new = {"place": "pump shaft", "value": 294.0, "unit": "N m", "others": [], "modes": [2]}
    new |= {"mode": 2, "in_band": True, "spread_rpm": [440.0, 440.0], "in_running_range": True}
    record["resonances"] = [
        one | new | {"speed_rpm": 440.0 + place, "order": 4.0 + place, "severity": share}
        for place, share in enumerate((1.0, 0.6, 0.06, 0.04, 0.01))
    ]
    record["resonances"].append(record["resonances"][0] | {"in_band": False, "order": 20.0})
    table = speed_table(typed(results).vibration, most=2)
    rows = [texts for texts in table.texts() if texts[0] == "torsional"]
    assert len(rows) == 2
    assert all("pump shaft" in texts and "294 N m" in texts for texts in rows)
    assert "1 critical speed, up to 6 %" in table.note
    assert "2 peaks below 5 %" in table.note
    shown = resonance_table(typed(results).vibration.forced_of("torsional"))
    assert len(shown.rows) == 3
    assert "critical speed" not in shown.note
    assert "2 peaks below 5 %" in shown.note


def test_sources_show_modes_that_depend_on_them_and_all_points_have_names(results):
    record = results["vibration"]["torsional"]
    one = record["sources"][0]
    one |= {"first_mode": 2, "first_frequencies": [7.3, 49.2, 129.1]}
    one |= {"crankshaft_frequencies": [49.2, 129.1, 207.6]}
    read = Vibration.from_record(record)
    table = read.source_table()
    assert "mode 2" in table.title
    assert table.rows[0][2] == (49.2, 129.1, 207.6)
    note = read.mode_table().note
    last = len(record["nodes"]) - 1
    assert f"{last} flywheel" in note


LIMIT_STRESS, TWIST = "torsional stress of crankshaft", "torsional amplitude of free end"


@pytest.fixture
def record(results):
    assessment = results["vibration"]["assessment"]
    first = assessment["checks"][0] | {"speed_rpm": 498.0, "running": None, "above": None}

    def check(limit, place, unit, value):
        known = {"limit": limit, "place": place, "unit": unit, "value": value}
        used = {"used": None if value is None else 0.5, "passed": value is not None}
        return first | known | used | {"permitted": 2e7 if unit == "Pa" else 1e-3}

    limit = assessment["limits"][0]
    return assessment | {
        "running_rpm": [200.0, 515.0],
        "uncertainty": {},
        "checks": [
            check(LIMIT_STRESS, "cylinder 4 - cylinder 5", "Pa", 1e7),
            check(TWIST, "free end", "rad", None),
            check(LIMIT_STRESS, "cylinder 1 - cylinder 2", "Pa", 2e6),
        ],
        "limits": [
            limit
            | {"name": LIMIT_STRESS, "judged_to_rpm": 575.0, "source": "A rule", "assumed": True},
            limit
            | {"name": TWIST, "judged_to_rpm": 515.0, "source": "The maker", "assumed": False},
        ],
        "remarks": [],
        "barred": [],
        "started_through": [],
        "sentence": "Fine.",
        "decision": {"status": "acceptable", "sentence": "", "trials": []},
        "beside": [],
    }


def test_speeds_above_the_running_range_are_explained(record):
    lines = [*assessment_parts(Assessment.from_record(record), parse_output_units("rpm"))]
    lines = [line for line in lines if isinstance(line, str)]
    for limit, speeds in ((LIMIT_STRESS, "200 to 575 rpm"), (TWIST, "200 to 515 rpm")):
        assert any(limit in one and speeds in one for one in lines)


def test_what_decides_stands_before_the_verdict_with_the_values_assumed(record):
    record["decision"] = {
        "status": "undecided",
        "sentence": "acceptable with this: give that",
        "trials": [],
    }
    first, *further = Assessment.from_record(record).conclusions
    assert first == f"{VERDICTS['undecided']}: acceptable with this: give that."
    assert len(further) == 1


def test_a_verdict_that_only_its_barred_ranges_hang_on_says_so(record):
    record["decision"] = {
        "status": "acceptable",
        "sentence": "no speeds need be barred with this",
        "trials": [],
    }
    first, further = Assessment.from_record(record).conclusions
    assert first == "Fine."
    assert further.endswith("no speeds need be barred with this.")
