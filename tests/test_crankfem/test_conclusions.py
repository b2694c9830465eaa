"""What a run concludes, on the console and in the report."""

import copy
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankbase.results import contents
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
from crankfem.report.summary import engine_facts, summary, uncertain_sentence, worst_of_each
from crankfem.report.text_filters import loaded_most
from dynamics.assessment.limits import AmplitudeCurve, given_limit
from dynamics.assessment.uncertainty import Spread
from dynamics.plots.mode_shapes import chain_places, crosses_on_axis
from dynamics.strength.fatigue import PlaceStrength
from dynamics.wording import VERDICTS
from stand_ins import stored_results, typed

NUMBER = re.compile(r"(?<![\w.-])\d+(?:\.\d+)?(?:e-?\d+)?")
BEARINGS = {"flips": False, "sentences": [], "stiffness": [1e9, 2e9], "shaft": {}, "statuses": []}
BEARINGS |= {"modes": {"axial": 1, "torsional": 1}}
BEARINGS |= {"further": {"axial": [], "torsional": []}, "chains": {}, "used": {}, "assumed": True}
POWER = ("speed_rpm", "indicated_power", "mean_indicated_pressure", "rated_power")
LOAD = {
    "law": "constant",
    "given": True,
    "speeds": [],
    "sentence": "full load",
    "rated": {
        **dict.fromkeys((*POWER, "mechanical_efficiency", "mean_effective_pressure"), 1.0),
        "consistent": False,
        "sentence": "no power",
    },
}
# Scales in which sentences write SI values: themselves, MPa, mrad, um, per cent.
SCALES = (1.0, 1e-6, 1e3, 1e6, 100.0)


@pytest.fixture
def results():
    return stored_results()


def part(order, contribution, state, mode=1):
    made = {"order": order, "contribution": contribution, "state": state, "kind": "torsional"}
    known = dict.fromkeys(("amplitude", "mode_share", "magnifier", "detuning"), 1.0)
    return known | made | {"mode": mode}


def misfiring(passed=False, sentence="too much"):
    told = {"passed": passed, "sentence": sentence, "missing_share": 1.0, "compression": True}
    told["running_rpm"] = [200.0, 515.0]
    ranges = [f"{name}_rpm" for name in ("exceeded", "remaining", "otherwise", "advised")]
    return told | {key: [] for key in ("cases", "checks", "remarks", *ranges)}


def verdict_parts(results):
    return typed(results).vibration, typed(results).strength


def with_parts(results, *parts):
    """A worst check of so many parts: their sum is reached, 20 MPa are permitted."""
    worst = results["vibration"]["assessment"]["checks"][0]
    value = sum(one["contribution"] for one in parts)
    worst |= {
        "value": value,
        "permitted": 20e6,
        "used": value / 20e6,
        "passed": value <= 20e6,
        "cause": {"sentence": "they make it", "orders": list(parts)},
    }
    return results


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


def conclusions(results):
    """Findings in full, but for those about checks."""
    return [
        " ".join(each.long) for each in results.findings if each.long and each.section != "checks"
    ]


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


def test_three_to_six_statements(results):
    assert 3 <= len(conclusions(typed(results))) <= 6
    results["vibration"] |= {
        "misfiring": misfiring(sentence="cylinder 2 misfiring makes 30 MPa"),
        "load": LOAD,
    }
    results["vibration"]["assessment"] |= {
        "decision": {"status": "undecided", "sentence": "it hangs", "trials": []},
        "beside": ["The whole crankshaft differs."],
    }
    found = conclusions(typed(results))
    assert len(found) == 6
    assert all(
        any(said in line for line in found)
        for said in (
            "Cylinder 2 misfiring makes 30 MPa.",
            "With all cylinders firing, it hangs.",
            "No power.",
        )
    )
    results["vibration"] |= {"forced": None, "assessment": None}
    assert 3 <= len(conclusions(typed(results))) <= 6


def test_what_stands_on_the_first_screen_is_short(results):
    none = with_parts(results, part(1.5, 22e6, "forced"), part(6.0, 3e6, "near resonance", 2))
    barred = none["vibration"]["assessment"]["barred"]
    barred += [barred[0] | {"allowed": True, "refusals": []}, barred[0]]
    found = main_findings(typed(none).findings)
    assert [finding.about for finding, _ in found] == ["Why", "What helps", "Assumed"]
    assert max(len(text.split()) for _, text in found) <= 30


@pytest.mark.slow
def test_damping_is_advised_only_where_it_can_help(results):
    # Without order 6 there are 15 of the 20 MPa permitted.
    help_ = with_parts(
        copy.deepcopy(results), part(3.0, 15e6, "forced"), part(6.0, 10e6, "at resonance")
    )
    text = " ".join(conclusions(typed(help_)))
    assert "leave at least 15 MPa" in text
    assert "less than the permitted 20 MPa" in text
    assert "more damping (the file has no torsional damper), or another frequency of" in text
    damper = {"field": "torsional_damper.kind", "assumed": False}
    help_["inputs"].append(help_["inputs"][0] | damper)
    text = " ".join(conclusions(typed(help_)))
    assert "more damping, or another frequency of torsional mode 1, may be sufficient" in text
    # Here 22 MPa are left whatever the damping.
    none = with_parts(
        copy.deepcopy(results), part(1.5, 22e6, "forced"), part(6.0, 3e6, "near resonance", 2)
    )
    text = " ".join(conclusions(typed(none)))
    assert "leave at least 22 MPa" in text
    assert "more damping alone is not sufficient" in text
    # The others counteract the peak of 35 MPa: without the resonance 25 MPa are left, not minus 25.
    against = with_parts(
        copy.deepcopy(results), part(1.5, -25e6, "forced"), part(6.0, 60e6, "at resonance")
    )
    assert "leave at least 25 MPa, more than the permitted 20 MPa" in " ".join(
        conclusions(typed(against))
    )
    fine = with_parts(copy.deepcopy(results), part(6.0, 10e6, "at resonance"))
    assert "at or near resonance contribute" not in " ".join(conclusions(typed(fine)))


def test_checks_that_fail_are_named(results):
    checks = results["checks"]
    text = failed_checks(typed(results).checks)
    failing = [one for one in checks if one["met"] is False]
    assert len(failing) == 2
    count = sum(one["met"] is not None for one in checks)
    said = "with the whole crankshaft; the calculation passes all others."
    assert text == f"2 of {count} checks fail: they compare the chains {said}"
    failing[0]["met"] = True
    assert (
        failed_checks(typed(results).checks)
        == f"1 of {count} checks fails: it compares a chain {said}"
    )
    failing[0]["met"] = False
    # An error of the calculation itself is told with what is allowed, and nothing reassures.
    checks[0] |= {"met": False, "figure": 0.04, "allowed": 0.01}
    text = failed_checks(typed(results).checks)
    assert "error of the axial compliance, 4 % (allowed: at most 1 %)" in text
    assert all(one["name"][1:] in text for one in failing)
    assert "passes all others" not in text
    for one in checks:
        one["met"] = True
    assert failed_checks(typed(results).checks) == ""


def test_modes_with_little_part_in_a_resonance_are_not_named(results):
    parts = (part(4.0, 30e6, "at resonance", 2), part(6.0, 1e6, "near resonance", 3))
    text = " ".join(conclusions(typed(with_parts(results, part(1.0, 5e6, "forced"), *parts))))
    assert "another frequency of torsional mode 2, may" in text


@pytest.mark.slow
def test_a_verdict_that_hangs_on_assumptions_is_undecided(results):
    results["vibration"]["assessment"]["decision"] = {
        "status": "undecided",
        "sentence": "acceptable with a tensile strength of 590 MPa",
        "trials": [],
    }
    said = "Not acceptable with the values used; undecided"
    assert headline(*verdict_parts(results)) == said
    assert summary(typed(results))["status"] == "barred"
    assert verdict_line(*verdict_parts(results)).startswith(
        f"Verdict: {said}: torsional stress of crankshaft 115 %"
    )
    found = conclusions(typed(results))
    assert found[0].startswith("Acceptable with a tensile strength of 590 MPa.")
    assert found[1].startswith("With the values used: torsional stress of crankshaft")
    assert sum("Acceptable with a tensile strength" in line for line in found) == 1


@pytest.mark.slow
def test_misfiring_that_fails_is_in_the_headline(results):
    results["vibration"]["misfiring"] = misfiring()
    # Where limits are exceeded with all cylinders firing, the largest figure is that of normal firing.
    assert headline(*verdict_parts(results)) == "Not acceptable"
    results["vibration"]["assessment"] |= {"status": "fine", "headline": "Acceptable"}
    assert headline(*verdict_parts(results)).startswith(
        "Acceptable with all cylinders firing; limits are exceeded"
    )
    assert ". With all cylinders firing: torsional stress of crankshaft" in verdict_line(
        *verdict_parts(results)
    )
    assert summary(typed(results))["status"] == "barred"  # amber, not green


@pytest.mark.slow
def test_a_crankshaft_too_weak_is_in_the_headline(results):
    place = dict.fromkeys(contents(PlaceStrength), 1.0) | {"place": "pin fillet", "web": ""}
    throw = {"throw": 1, "alternating_torque": 1.0, "torque_speed_rpm": 1.0, "misfiring": []}
    throw |= {"places": [place | {"throw": 1}], "webs": {}, "shrink_fit": None}
    said = {"throws": [throw], "by_elements": False, "warning": "", "source": ""}
    results["strength"] = said | {key: [] for key in ("remarks", "left_out", "unsafe")}
    assert headline(*verdict_parts(results)) == "Not acceptable"
    results["vibration"]["assessment"] |= {"status": "fine", "headline": "Acceptable"}
    assert headline(*verdict_parts(results)).endswith(
        "; the crankshaft is not strong enough by UR M53"
    )
    assert summary(typed(results))["status"] == "bad"
    assert ". Vibration: torsional stress of crankshaft" in verdict_line(*verdict_parts(results))
    throw["places"][0]["strength"] = 2.0
    assert "UR M53" not in headline(*verdict_parts(results))
    assert summary(typed(results))["status"] == "fine"


def test_a_mode_divided_between_two_is_on_its_card_by_both(results):
    results["vibration"]["bearings"] = BEARINGS | {"shaft": {"axial": [80.0, 90.0]}}
    mode = results["vibration"]["whole"]["chains"]["axial"]["modes"][0]
    shown = "whole crankshaft in its bearings: 81.1 Hz (80.0 to 90.0 Hz)"
    assert shown in summary(typed(results))["frequencies"][0]["details"]
    mode["further_frequency"] = 60.0
    shown = "whole crankshaft in its bearings: 60.0 and 81.1 Hz"
    assert shown in summary(typed(results))["frequencies"][0]["details"]


def test_a_steel_that_keeps_the_limits_of_normal_firing_is_not_said_to_keep_those_of_misfiring(
    results,
):
    results["vibration"]["misfiring"] = misfiring()
    results["vibration"]["assessment"]["decision"] = {
        "status": "undecided",
        "sentence": "acceptable with a tensile strength of 672 MPa",
        "trials": [],
    }
    said = "With all cylinders firing, acceptable with a tensile strength of 672 MPa."
    assert any(said in line for line in conclusions(typed(results)))
    assert headline(*verdict_parts(results)) == (
        "Not acceptable with the values used, also while a cylinder misfires; undecided"
    )


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
    assert "stiffness of the main bearings 2.2e8 to 2.2e10 N/m each" in said
    ends = said.rpartition("itself ")[2].removesuffix(" Hz by the chain.").split(" to ")
    assert [float(end) for end in ends] == close([bounds["low"], bounds["high"]], rel=5e-3)
    # The range of the chain may not hold the frequency of the better model, whose own range stands beside it.
    vibration["bearings"]["shaft"] = {"torsional": [50.0, None, 70.0]}
    said = told()
    assert said.endswith(
        " by the chain, 50.0 to 70.0 Hz by the whole crankshaft over this stiffness."
    )


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
    assert row[-1] == "2.25, 0.40 of the way from end to ring"


def test_a_damper_ring_stands_before_the_free_end_and_later_nodes_close_up():
    # Free end, cylinder, flywheel, ring at the free end, generator behind the flywheel, a disc on a branch.
    pairs = [(0, 1), (1, 2), (0, 3), (2, 4), (1, 5)]
    places = chain_places(6, pairs)
    assert places.tolist() == [0.0, 1.0, 2.0, -1.0, 3.0, 1.5]
    # A node in the middle of the ring's element, and one on that from cylinder to flywheel.
    assert crosses_on_axis((2.5, 1.25), pairs, places) == [-0.5, 1.25]
    assert chain_places(3, [(0, 1), (1, 2)]).tolist() == [0.0, 1.0, 2.0]


def test_uses_at_and_above_running_speeds_stand_apart(results):
    checks = results["vibration"]["assessment"]["checks"]
    for check, used in zip(checks, (0.8, 0.9), strict=False):
        own = {name: check[name] for name in ("value", "permitted", "speed_rpm")}
        check["running"] = own | {"used": used}
        check["above"] = own | {"used": used + 0.3, "speed_rpm": 570.0}
        check["in_running_range"] = False
    first = results["vibration"]["assessment"]["deciding"]
    kept = {"value": 0.8 * first["permitted"], "used": 0.8}
    results["vibration"]["assessment"]["deciding"] = first | first["running"] | kept
    first["used"] = 1.1
    (shown,) = worst_of_each(typed(results).vibration.assessment.verdict.checks[:2])
    assert (shown.use.used, shown.above.used) == (0.9, 1.2)
    assert (
        "80 % of the permitted 21.2 MPa; above the running range" in conclusions(typed(results))[0]
    )


def test_every_sentence_takes_the_limit_that_decides(results):
    """A propeller shaft, 118 MPa where 95.7 may be passed below the running range; all else is kept."""
    assessment = results["vibration"]["assessment"]
    for check in assessment["checks"]:
        check |= {"value": 0.8 * check["permitted"], "used": 0.8, "passed": True}
    deciding = copy.deepcopy(assessment["checks"][0])
    deciding |= {"limit": "torsional stress of propeller shaft", "place": "propeller shaft"}
    deciding |= {"value": 118e6, "permitted": 95.7e6, "used": 118.0 / 95.7, "speed_rpm": 150.0}
    assessment |= {"deciding": deciding | {"passed": False, "passing": True}}
    assessment |= {"status": "not acceptable", "headline": "Not acceptable", "barred": []}
    vibration = typed(results).vibration
    share = "123 % of what may be passed at 150 1/min"
    assert f"torsional stress of propeller shaft {share}" in verdict_line(vibration)
    first = summary(typed(results))
    tile = first["tiles"][0]
    assert (tile["value"], tile["mark"]) == ("123 %", "over")
    assert tile["details"][1] == "118 MPa at 150 1/min, 95.7 MPa may be passed"
    told = {finding.about: text for finding, text in first["findings"]}
    assert told["Why"].startswith("At 150 1/min, ")
    reached = "118 MPa at 150 1/min, 123 % of the 95.7 MPa that may be passed"
    assert any(reached in text for text in conclusions(typed(results)))
    assert vibration.assessment.verdict.deciding.passing


def test_the_headline_says_that_chain_and_whole_crankshaft_disagree(results):
    assessment = results["vibration"]["assessment"]
    assessment |= {"status": "fine", "headline": "Acceptable from 200 to 515 1/min"}
    assessment["decision"] |= {"status": "undecided", "sentence": "acceptable by one"}
    checks = assessment["checks"][:1]
    assessment["whole"] = {"status": "barred range needed", "checks": checks, "barred": []}
    told = "by the whole crankshaft it is"
    assert told not in summary(typed(results))["headline"]
    assessment["whole"]["status"] = "not acceptable"
    assert f"undecided, as that is by the lumped model: {told} not acceptable" in (
        verdict_line(typed(results).vibration)
    )


def test_what_the_bearings_change_is_told_once(results):
    told = ["First frequencies.", "Over that range the verdict changes."]
    vibration = results["vibration"]
    vibration["assessment"]["beside"] = ["The whole crankshaft differs.", told[1]]
    vibration["bearings"] = BEARINGS | {"sentences": told, "statuses": ["fine", "not acceptable"]}
    said = " ".join(conclusions(typed(results)))
    assert "The whole crankshaft differs." in said
    assert [said.count(one) for one in told] == [1, 1]


def test_axial_vibration_without_a_limit_is_told_with_its_size(results):
    """At running speeds, 200 to 515 1/min, alone."""
    forced = results["vibration"]["forced"]["axial"]
    forced |= {"speeds_rpm": [100.0, 200.0, 400.0, 515.0, 600.0]}
    for curve, told in (
        ([9e-3, 1e-4, 7.386e-3, 2e-4, 8e-3], "7386 um at the free end at 400 1/min"),
        ([9e-3, 1e-4, 2e-4, 3e-4, 8e-3], "300 um at the free end at 515 1/min"),
        ([9e-3, 1e-4, 2e-4, None, 8e-3], "unbounded at the free end at 515 1/min"),
    ):
        forced["free_end"]["synthesis"] = curve
        said = f"Axial vibration ({told}) is not judged"
        assert any(said in one for one in conclusions(typed(results)))
    results["vibration"]["assessment"]["limits"][0] |= {"name": "axial amplitude", "unit": "m"}
    assert not any("not judged" in one for one in conclusions(typed(results)))


def test_the_engine_is_told_in_a_line(results):
    # 0.34 m of stroke at 500 1/min: two strokes in 0.12 s.
    results["engine"] |= {
        "firing_intervals_deg": [120.0] * 6,
        "mean_piston_speed": 2.0 * 0.34 * 500.0 / 60.0,
    }
    text = "; ".join(engine_facts(typed(results)))
    assert "6 cylinders in line, 4-stroke; bore 250 mm, stroke 340 mm" in text
    assert "rated speed 500 1/min (mean piston speed 5.67 m/s)" in text
    assert "firing order 1-5-3-6-2-4, evenly every 120 deg" in text
    results["engine"]["firing_intervals_deg"] = [90.0, 150.0] * 3
    assert "unevenly, at intervals of 90, 150 deg in turn" in engine_facts(typed(results))[-1]
    results["engine"]["highest_speed_rpm"] = 12500.0
    assert "to 12500 1/min" in engine_facts(typed(results))[2]


def test_the_whole_crankshaft_stands_on_the_first_screen(results):
    """The verdict's box shows four findings; like is told beside like, each with its speed."""
    vibration = results["vibration"]
    vibration["assessment"] |= {"by_whole": ["It differs."], "beside": ["It differs.", "A note."]}
    ends = {"lowest": 0.0, "lowest_angle_deg": 0.0, "highest": 1.0, "highest_angle_deg": 9.0}
    vibration["axial_force"] = {
        "speed_rpm": 500.0,
        "thrust_bearing": None,
        "held": ends,
        "throws": [],
        "sentences": [],
        "running": {"amplitude": 116683.6, "speed_rpm": 500.6},
        "running_whole": {"amplitude": 55509.2, "speed_rpm": 496.9},
    }
    peak = {"order": 6.0, "speed_rpm": 494.6, "value": 6170.0, "unit": "N m", "place": "a - b"}
    peak |= {"mode": 1, "frequency": 50.0, "share": 1.0, "damping_ratio": None}
    above = peak | {"value": 1e9, "in_running_range": False}
    peaks = [peak | {"in_running_range": True, "damping_ratio": 0.0125}, above]
    vibration["whole"]["criticals"] = {"torsional": {"left_out": 0, "peaks": peaks}}
    found = conclusions(typed(results))
    (said,) = [one for one in found[:4] if one.startswith("It differs.")]
    assert "55.5 kN at 497 1/min by the whole crankshaft, 117 kN at 501 1/min by the chain" in said
    assert "order 6 at 495 1/min" in said
    assert "at a - b, damping 1.2 %" in said
    assert sum("It differs." in one for one in found) == 1


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


def test_the_tensile_strength_decides_on_what_is_kept():
    # 440 (1 + 3/2 0.1005) = 506.3
    assert decided(KEPT).sentence == (
        "acceptable with a tensile strength of 507 MPa, not with 506 MPa (440 MPa assumed): give "
        "limits.tensile_strength"
    )


def test_the_yield_strength_decides_on_what_is_passed():
    assert decided(PASSED).sentence == (
        "acceptable with a yield strength of 248 MPa, not with 247 MPa (225 MPa assumed): give "
        "limits.yield_strength"
    )


def test_both_decide_together():
    # Kept asks for 506 MPa, which brings 259 MPa of yield strength: more than the 247.5 that passing asks.
    found = decided(KEPT, PASSED)
    assert found.status == "undecided"
    assert "tensile strength (yield strength in proportion) of 50" in found.sentence
    assert found.sentence.endswith("give limits.tensile_strength and limits.yield_strength")


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
        (
            (KEPT,),
            {},
            f"{VERDICTS['undecided']}: acceptable with a tensile strength of 507 MPa, not with 506 MPa",
        ),
        ((KEPT,), {"crankshaft_stress": 20e6}, f"{VERDICTS['not acceptable']}: torsional stress"),
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
        (
            reached(30e6),
            reached(29e6),
            "145 % of the permitted 20 MPa; with all cylinders firing 30 MPa at 1000 1/min, 150 %.",
        ),
        (
            reached(30e6, 25e6, "free end", 900.0),
            reached(29e6),
            "; with all cylinders firing 30 MPa at 900 1/min, 120 % of the permitted 25 MPa, free end.",
        ),
        # A share has no use where nothing is permitted, or all is unbounded.
        (reached(30e6, math.inf), reached(29e6), "with all cylinders firing 30 MPa at 1000 1/min."),
        (reached(30e6), reached(math.inf), "30 MPa at 1000 1/min, 150 % of the permitted 20 MPa."),
    ],
)
def test_normal_firing_is_told_with_its_share(normal, misfiring, said):
    sentence = check(normal, misfiring).sentence
    assert sentence.startswith(
        "With cylinder 4 misfiring, torsional stress of crankshaft, cylinder 4"
    )
    assert sentence.endswith(said)


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
    assert "1 critical speed, up to 6 % of the largest peak at a place" in table.note
    assert "2 peaks below 5 % of the largest one at every place" in table.note
    assert "1 peak of the exciting forces" in table.note
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
    assert "of the crankshaft, from mode 2 on" in table.title
    assert table.rows[0][2] == (49.2, 129.1, 207.6)
    note = read.mode_table().note
    last = len(record["nodes"]) - 1
    assert f"0 free end, 1 to 6 cylinder 1 to cylinder 6, {last} flywheel" in note


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
    assert (
        f"Limit on {LIMIT_STRESS}: A rule, assumed; judged from 200 to 575 rpm, because it also "
        "applies above the highest running speed of 515 rpm." in lines
    )
    assert f"Limit on {TWIST}: The maker; judged from 200 to 515 rpm." in lines


def test_what_decides_stands_before_the_verdict_with_the_values_assumed(record):
    record["decision"] = {
        "status": "undecided",
        "sentence": "acceptable with this: give that",
        "trials": [],
    }
    first, *further = Assessment.from_record(record).conclusions
    assert first == f"{VERDICTS['undecided']}: acceptable with this: give that."
    assert further == ["With the values used, fine."]


def test_a_verdict_that_only_its_barred_ranges_hang_on_says_so(record):
    record["decision"] = {
        "status": "acceptable",
        "sentence": "no speeds need be barred with this",
        "trials": [],
    }
    assert Assessment.from_record(record).conclusions == (
        "Fine.",
        "It depends on assumed or uncertain values: no speeds need be barred with this.",
    )
