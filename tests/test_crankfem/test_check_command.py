"""What `crankfem check` says of files of every kind."""

import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankfem.analyses.file_check import check_file
from crankfem.analyses.vibration.engine_limits import engine_limits, unmodeled_plant
from crankfem.files.engine.usual_sizes import SHARP

ENGINES = Path(__file__).resolve().parents[2] / "data" / "engines"


def test_an_engine_is_shown_as_understood(call):
    record = call("check", "6chn25-34", "--json").json()
    arrangement = record["arrangement"]
    assert arrangement["firing_order"] == [1, 5, 3, 6, 2, 4]
    # In firing order, evenly over two revolutions.
    assert arrangement["firing_angles_deg"] == [0.0, 120.0, 240.0, 360.0, 480.0, 600.0]
    assert arrangement["crank_angles_deg"] == [0.0, 120.0, 240.0, 240.0, 120.0, 0.0]
    assert arrangement["lowest_speed_rpm"] == close(200.0)
    dimensions = {one["name"]: one["value"] for one in record["dimensions"]}
    assert dimensions["web_width"] == 0.285
    assert "pin_bore" not in dimensions
    # Half of both journals, less the crank radius.
    assert record["shape"]["overlap"] == close(0.5 * (0.220 + 0.180) - 0.170)
    assert {"run", "vibration", "doe", "mechanism", "throw"} <= set(record["commands"])
    assert "gas" in record["sections"]
    words = " ".join(call("check", "6chn25-34").out.split())
    for said in (
        "use it with: run, vibration",
        "runs from 200 to 515 1/min",
        "firing order 1-5-3-6-2-4",
        "web_thickness │ h │ 68",
        "a quarter is solved",
        "thrust bearing at main bearing 7 of 7, counted from 1 at the free end",
        "a classification society's rule",
        "the rule 'KR generator set', because the engine drives a generator (engine.drives)",
    ):
        assert said in words


def test_hinges_and_chains_are_checked(call, tmp_path):
    hinge = call("check", "crosshead-30-100", "--json").json()
    assert (hinge["kind"], hinge["commands"], hinge["shape"]) == ("hinge", ["hinge"], None)
    assert {"engine", "hinge", "operation"} <= set(hinge["sections"])
    assert "valid hinge file" in call("check", "crosshead-30-100").out
    chain = call("check", "mwm-six", "--json").json()
    assert (chain["kind"], chain["commands"]) == ("chain", ["vibration"])
    assert "a torsional chain of" in call("check", "mwm-six").out
    assert call("new", "mine.toml", "--from", "crosshead-30-100").code == 0
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace("[sliding]", "[slidng]"), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert answer.code == 2
    assert "[slidng] is an unknown section" in answer.err


def test_an_impossible_cycle_is_found(call, tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"gas.mean_effective_pressure": '"9 MPa"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    answer = call("check", "mine.toml")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Error: gas.peak_pressure: given 8.5 MPa above ambient; allowed")


def test_a_picture_of_the_throw(call, tmp_path):
    answer = call("check", "6chn25-34", "--picture", "throw.svg")
    assert answer.code == 0
    assert answer.out.rstrip().endswith("throw.svg written.")
    assert (tmp_path / "throw.svg").read_text(encoding="utf-8").startswith("<?xml")
    answer = call("check", "mwm-six", "--picture", "throw.svg")
    assert answer.code == 2
    assert "--picture: given with a chain file" in answer.err


def test_sections_are_told_in_readable_limits(call):
    out = " ".join(call("fields", "engine").out.split())
    assert "5 1/min to 30000 1/min" in out
    assert "4.77" not in out
    assert "-85 deg to 85 deg" in " ".join(call("fields", "gas").out.split())


UNKNOWN_SHAFT = """
[[limits.shafts]]
element = "flywheel - proppeller"
diameter = "300 mm"
tensile_strength = "600 MPa"
"""


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("changes", "more", "message"),
    [
        (
            {},
            UNKNOWN_SHAFT,
            r"limits\.shafts\[0\]\.element: given 'flywheel - proppeller'; .*allowed are .*because",
        ),
        ({}, '[limits]\ncoupling_torque = "1 kN m"\n', "limits.coupling_torque: given without"),
        (
            {
                "study.factors.web_width": '["60 mm", "300 mm"]',
                "study.factors.web_thickness": '["5 mm", "68 mm"]',
                "study.factors.pin_length": '["20 mm", "139 mm"]',
            },
            "",
            r"study\.factors: given 8 designs of which \d can be built, to which no equation",
        ),
    ],
    ids=["element", "coupling", "study"],
)
def test_check_refuses_what_run_refuses_before_it_computes(
    call, tmp_path, unseen, six_cylinders, edit, command, changes, more, message
):
    (tmp_path / "mine.toml").write_text(edit(six_cylinders, changes) + more, encoding="utf-8")
    answer = call(command, "mine.toml")
    assert answer.code == 2
    assert re.search(message, answer.err)
    assert not (tmp_path / "mine-results").exists()


def test_designs_that_are_left_out_are_told(call, tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"study.factors.web_thickness": '["5 mm", "68 mm", "98 mm"]'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    words = " ".join(call("check", "mine.toml").out.split())
    assert "study: 9 of 27 designs are excluded; reason for the first: it cannot be built" in words


def test_the_rule_follows_what_the_engine_drives(call, tmp_path, six_cylinders, edit):
    """At 0.5 of the rated speed a set only passes, 90 MPa; a main engine may be kept there, 39 MPa."""
    for driven, rule, permitted in (
        ("generator", "KR generator set", 90e6),
        ("propeller", "KR main engine", 39e6),
    ):
        text = edit(six_cylinders, {"engine.drives": f'"{driven}"'})
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        engine = cf.load_engine("mine.toml")
        limits, remarks = engine_limits(engine)
        half = np.array([0.5 * engine.engine.rated_speed])
        assert limits["crankshaft_stress"].continuous.at(half) == close([permitted])
        assert any(
            f"the rule {rule!r}, because the engine drives a {driven}" in one for one in remarks
        )
    text = edit(six_cylinders, {"engine.drives": '"generator"'}).replace('drives = "generator"', "")
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    _, remarks = engine_limits(cf.load_engine("mine.toml"))
    assert any("because the file does not say what the engine drives" in one for one in remarks)
    assert unmodeled_plant(cf.load_engine("mine.toml")) == ()
    # The law of its load says it too; nothing beyond the flywheel is in the file.
    text += '\n[load]\nlaw = "propeller"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    engine = cf.load_engine("mine.toml")
    reason = "the rule 'KR main engine', because the engine drives a propeller (load.law)"
    assert any(reason in one for one in engine_limits(engine)[1])
    (said,) = unmodeled_plant(engine)
    assert said.startswith("The propeller and its shafts are not modeled")
    for whole_plant in ("5rt-flex50d", "6chn18-22-set"):
        assert unmodeled_plant(cf.load_engine(whole_plant)) == ()


@pytest.mark.parametrize(
    ("engine", "intervals", "said"),
    [
        ("6chn25-34", [120.0] * 6, "fires every 120 deg"),
        ("8chn26-26", [45.0, 135.0] * 4, "fires at intervals of 45, 135 deg in turn"),
    ],
)
def test_firing_intervals_are_shown(call, engine, intervals, said):
    """Of the V8 of 45 deg with a flat crankshaft, by hand: 1 at 0, 5 at 45, 3 at 180, 7 at 225 deg ..."""
    assert (
        call("check", engine, "--json").json()["arrangement"]["firing_intervals_deg"] == intervals
    )
    assert said in " ".join(call("check", engine).out.split())
    answer = call("mechanism", engine, "--json").json()
    assert answer["firing_intervals_deg"] == close(intervals)
    assert said in " ".join(call("mechanism", engine).out.split())


def test_limits_outside_the_verdict_are_named_and_a_rule_by_assumption_counts_as_assumed():
    limits, remarks = engine_limits(cf.load_engine("6chn18-22-set"))
    (said,) = (one for one in remarks if "class document" in one)
    left_out = ("coupling_heat", "damper_torque", "damper_heat", "generator_angle")
    assert all(f"limits.{name}" in said for name in left_out)
    assert "coupling_torque" not in said
    assert "coupling_torque" in limits
    assert limits["crankshaft_stress"].assumed


def changed_file(tmp_path, pattern, new):
    """Write the file of 6ChN 25/34 with one line changed."""
    text = (ENGINES / "6chn25-34.toml").read_text(encoding="utf-8")
    changed = re.sub(rf"(?m)^{pattern} = .*\n", new, text)
    assert changed != text
    path = tmp_path / "mine.toml"
    path.write_text(changed, encoding="utf-8")
    return path


def test_a_fillet_that_is_left_out_is_told_with_its_effect(tmp_path):
    checked = check_file(str(changed_file(tmp_path, "fillet_radius", "")))
    (told,) = checked.warnings
    sharp, filleted = (
        cf.axial_law(checked.throw.changed(fillet_radius=radius)).pinned for radius in (0.0, 0.0121)
    )
    assert told.startswith("throw.fillet_radius: not given, so corners are taken as sharp: e_n is ")
    assert f"e_n is {100.0 * (sharp / filleted - 1.0):.2g} % above that with 12.1 mm" in told
    assert not check_file(
        str(changed_file(tmp_path, "fillet_radius", 'fillet_radius = "0 mm"\n'))
    ).warnings


def test_the_effect_of_sharp_corners_of_the_shipped_engines_holds():
    found = []
    for path in ENGINES.glob("*.toml"):
        throw, _ = cf.load_throw(path)
        sharp = throw.changed(
            fillet_radius=0.0, main_journal_fillet_radius=None, pin_fillet_radius=None
        )
        with suppress(cf.InputError):
            found.append(cf.axial_law(sharp).pinned / cf.axial_law(throw).pinned - 1.0)
    assert len(found) >= 15
    assert f"{100.0 * min(found):.0f} to {100.0 * max(found):.0f} %" == SHARP


@pytest.mark.parametrize("journal", [22, 60, 90])
def test_a_wrong_main_journal_is_named_by_itself(tmp_path, journal):
    line = f'main_journal_diameter = "{journal} mm"\n'
    (told,) = check_file(str(changed_file(tmp_path, "main_journal_diameter", line))).warnings
    assert told.startswith(f"throw.main_journal_diameter: given {journal} mm, with which ")
    low, high = (float(one) for one in re.search(r"suit (\S+) mm to (\S+) mm", told).groups())
    assert low <= 220.0 <= high
    for suiting in (1.01 * low, 0.99 * high):
        line = f'main_journal_diameter = "{suiting:.4g} mm"\n'
        with suppress(cf.InputError):  # where it stands outside the web
            said = check_file(str(changed_file(tmp_path, "main_journal_diameter", line))).warnings
            assert not any("law's training throws" in one for one in said)


def test_a_missing_field_is_told_once_with_file_and_section(call, tmp_path):
    answer = call("check", str(changed_file(tmp_path, "firing_order", "")))
    assert answer.code != 0
    assert answer.err.count("firing_order") == 1
    assert answer.err.startswith("Error: engine.firing_order: missing; give cylinder numbers in")
    assert answer.err.endswith("(mine.toml, section [engine], line 6).\n")
