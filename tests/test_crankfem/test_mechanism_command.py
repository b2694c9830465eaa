"""The command `mechanism`: tables, files, pictures, and what it refuses."""

import csv
import math

import numpy as np
import pytest

from comparing import close
from crankbase.tables.table import merged_rows
from crankfem.analyses.mechanism.balance_records import (
    balance_contents,
    mechanism_balance_record,
    throw_mass_table,
)
from crankfem.analyses.mechanism.mechanism_records import mechanism_record
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.mechanism.rod_models import (
    compare_rod_models,
    model_difference_sentence,
    model_difference_table,
)
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.mechanism_file import load_mechanism
from crankfem.report.interactive.mechanism import MECHANISM
from dynamics.balance.balance import balance
from geometry.crankshaft import throw_masses


@pytest.fixture(scope="module")
def v8():
    return run_mechanism(load_mechanism("8chn13-14"))


def test_the_record_is_consistent(v8):
    record = mechanism_record(v8)
    work = sum(row["indicated_work"] for row in record["cylinders"])
    # Four strokes: one cycle takes two turns.
    assert record["power"] == close(work * record["speed_rpm"] / 120.0, rel=1e-9)
    assert abs(record["energy_error"]) < 1e-12
    assert record["cylinders"][0]["mean_effective_pressure"] == close(1.1e6, rel=1e-6)
    assert len(record["crankpins"]) == 8
    assert len(record["main_bearings"]) == 5
    assumed = {entry["field"] for entry in record["assumed"]}
    assert {"rod.mass", "gas.mean_effective_pressure"} <= assumed
    assert "throw.web_width" not in assumed
    assert record["torque"]["smallest"] < record["torque"]["mean"] < record["torque"]["largest"]


def test_the_mean_load_balances_over_the_bearings(v8):
    # What the bearings carry is what rods and rotating masses press on the shaft.
    carried = sum(load.force for load in v8.bearings)
    pressed = v8.forces.crankpin.sum(axis=0)
    turning = sum(
        mass.static_moment * v8.speed**2 for mass in v8.layout.rotating
    )  # a bound: their sum turns once a turn and cancels over it
    assert abs((carried - pressed).mean()) < 1e-9 * turning


def test_models_differ_as_their_masses_do(v8):
    compared = {row.model: row for row in compare_rod_models(v8)}
    assert 0.02 < compared["three-mass"].crankpin < compared["two-mass"].crankpin < 0.05


def test_the_balance_is_that_of_the_exact_bodies_about_the_middle(v8):
    positions = v8.mechanism.bearing_positions
    assert v8.balance.about == close(0.5 * positions[-1])
    assert v8.balance.model == "rigid"
    classical = run_mechanism(v8.mechanism, model="two-mass")
    assert classical.balance.model == "two-mass"
    # The rods' centers lie 9 mm beside their axes.
    assert classical.balance.of(1).moment.major != close(v8.balance.of(1).moment.major, rel=1e-5)


def test_the_balance_says_what_is_in_it(v8):
    """By hand, for a cross-plane V8: the first order's moment is sqrt(10) a w^2 times what turns."""
    found = mechanism_balance_record(v8)
    throw, density = v8.mechanism.throw, v8.mechanism.material.density
    bare = throw_masses(throw.changed(left_web=None, right_web=None), density)
    solid = throw_masses(throw, density)
    moments = [own.mass * own.center[1] for own in (solid, bare)]
    for row in found["throws"]:
        # Two rods on each pin, 2.66264 kg of each at it.
        assert row["rods"] == close([2 * 2.66264 * 0.07, 0.0])
        assert row["solid"] == close([moments[0], 0.0])
        assert row["counterweights"] == close([moments[0] - moments[1], 0.0])
        assert row["sum"] == close([row["rods"][0] + moments[0], 0.0])
    # The halves of two reciprocating masses turn with the crank, and M l_d lambda behind it.
    one, pitch = found["masses"][0], 0.17
    turning = one["reciprocating"] * 0.07, one["lateral_static_moment"] * 0.07 / 0.265
    scale = math.sqrt(10.0) * pitch * v8.speed**2
    with_solids, bare_moment = (
        scale * math.hypot(found["throws"][0][name][0] + turning[0], turning[1])
        for name in ("sum", "rods")
    )
    assert found["orders"][0]["moment"]["major"] == close(with_solids, rel=1e-9)
    assert found["without_throws"]["moment"] == close(bare_moment, rel=1e-9)
    assert balance_contents(found).endswith(
        "First order: force balanced with and without the solids; moment 23.48 kN m, without the "
        "solids 18.68 kN m."
    )
    assert "throws' solids with counterweights;" in balance_contents(found)
    # Of throws without counterweights none are told.
    bare = found | {"throws": [row | {"counterweights": [0.0, 0.0]} for row in found["throws"]]}
    assert "throws' solids;" in balance_contents(bare)
    told = throw_mass_table(bare)
    assert [one.name for one in told.columns] == ["throw", "rods", "solid", "sum", "at"]
    assert "counterweights" not in told.note
    assert (
        found["without_throws"]["moment"]
        == balance(v8.mechanism.layout, v8.speed).of(1).moment.major
    )


def test_split_pins_are_counted_where_they_are():
    run = run_mechanism(load_mechanism("buick-3800"))
    split = mechanism_balance_record(run)["throws"][0]
    # Two pins 30 deg apart make 2 cos 15 deg, 15 deg ahead of the first.
    middle = math.radians(15.0)
    rods = 2.0 * 0.43 * run.layout.crank_radius * math.cos(middle)
    assert split["rods"] == close([rods * math.cos(middle), rods * math.sin(middle)], rel=1e-9)
    assert split["counterweights"][0] < -0.05
    (row,) = throw_mass_table({"throws": [split]}).rows
    assert row[1] == split["rods"][0]
    assert row[4] == close(math.hypot(*split["sum"]))
    assert row[5] == close(math.radians(15.0), abs=0.01)


def test_motored_engine_gives_no_power():
    run = run_mechanism(load_mechanism("6chn25-34"), 20.0, motored=True)
    fired = run_mechanism(load_mechanism("6chn25-34"), 20.0)
    assert abs(run.torque.power) < 0.1 * fired.torque.power
    assert max(work.peak_pressure for work in run.works) < 6e6


@pytest.mark.slow
def test_tables_and_files(call, tmp_path):
    answer = call(
        "mechanism", "8chn26-26", "--csv", tmp_path / "forces.csv", "--pictures", tmp_path / "p"
    )
    assert answer.code == 0
    assert "indicated power" in answer.out
    assert "1 to 4" in answer.out  # cylinders alike share a row
    assert "gas.intake_pressure, gas.exhaust_pressure" in " ".join(answer.out.split())
    with (tmp_path / "forces.csv").open(encoding="utf-8") as file:
        assert file.readline().startswith("# 8ChN 26/26")
        rows = list(csv.DictReader(file))
    assert len(rows) == 1440
    total = sum(float(rows[100][f"cylinder_{number}_torque_Nm"]) for number in range(1, 9))
    assert float(rows[100]["torque_Nm"]) == close(total, rel=1e-6)
    assert len(list((tmp_path / "p").glob("*.svg"))) >= 5
    # Main and hinged piston by order: printed, drawn, written.
    assert (tmp_path / "p" / "accelerations.svg").is_file()
    shown = " ".join(answer.out.split())
    assert "│ 2 │ 5 │ hinged │ 255.4 │ 15.22 │ -11.33 │ 8.111 │" in shown
    assert "(3.1 %) to 48.09 m/s^2 at 155.5 deg (2.8 %)" in shown
    whole, first, second = (
        np.array([float(row[f"cylinder_5_{name}_m_s2"]) for row in rows])
        for name in ("acceleration", "order_1", "order_2")
    )
    assert np.max(np.abs(whole - first - second)) == close(3.043, abs=5e-3)
    assert np.max(second) == close(255.4, abs=0.05)


@pytest.mark.slow
def test_two_models_of_the_rods(call, tmp_path):
    asked = ("mechanism", "8chn13-14", "--model", "two-mass", "--model", "three-mass")
    answer = call(*asked, "--csv", tmp_path / "f.csv", "--pictures", tmp_path / "p")
    shown = " ".join(answer.out.split())
    assert "rods as two-mass: indicated power" in shown
    assert "│ three-mass │ 2.28 │ 1.316 │ 0.6035 │ 0 │" in shown
    assert (
        "from two-mass to three-mass: it changes by up to -5.51 % of its size at the same angle (at 33 "
        "deg), or -2.29 % of its mean (at 38 deg); its mean changes by -0.78 %, its maximum by -0.01 %."
        in shown
    )
    assert (tmp_path / "p" / "rod_models.svg").is_file()
    with (tmp_path / "f.csv").open(encoding="utf-8") as file:
        next(file)
        row = list(csv.DictReader(file))[66]  # 33 deg
    static, dynamic = (float(row[f"crankpin_cylinder_1_{name}_N"]) for name in asked[3::2])
    assert float(row["difference_of_same_angle"]) == close(dynamic / static - 1.0)
    assert 100.0 * float(row["difference_of_same_angle"]) == close(-5.51, abs=5e-3)


def test_two_models_that_are_the_same(call):
    content = call(
        "mechanism", "8chn26-26", "--model", "rigid", "--model", "two-mass", "--json"
    ).json()
    record = content["model_difference"]
    assert model_difference_table(record) is None
    assert "the same, to round-off, as two-mass and as rigid" in model_difference_sentence(record)
    # Without an inertia given, the rods are two masses.
    assert [row["at_center"] for row in content["rod_masses"][0]["models"]] == [
        75.0,
        0.0,
        None,
        None,
    ]


def test_json(call):
    content = call("mechanism", "6chn25-34", "--json", "--speed", "300 1/min").json()
    assert content["speed_rpm"] == close(300.0)
    assert content["balance"]["orders"][0]["force_balanced"] is True
    assert content["pictures"] == []
    # Not in the file: the default is told.
    assert "gas.compression_ratio" in {entry["field"] for entry in content["assumed"]}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--speed", "1000"), "--speed: given '1000', a bare number"),
        (("--speed", "0 1/min"), "--speed: given '0 1/min'; allowed is 5 1/min to 30000 1/min"),
        (("--speed", "4.99 1/min"), "allowed is 5 1/min to 30000 1/min, because"),
        (("--speed", "30001 1/min"), "allowed is 5 1/min to 30000 1/min"),
        (("--speed", "3 m"), "is no speed of rotation"),
        (("--model", "stiff"), "--model: given 'stiff'; allowed are rigid, three-mass"),
        (("--model", "rigid", "--model", "rigid"), "--model: given rigid, rigid; allowed are one"),
        (("--model", "stiff", "--model", "rigid"), "--model: given 'stiff'; allowed are rigid"),
        (("--csv", "/no/such/folder/x.csv"), "there is no folder /no/such/folder"),
    ],
)
def test_refused_options(call, arguments, message):
    answer = call("mechanism", "6chn25-34", *arguments)
    assert answer.code == 2
    assert message in answer.err
    assert "Traceback" not in answer.err


def test_refused_files(call):
    answer = call("mechanism", "8chn14-14")
    assert answer.code == 2
    assert "the sections [engine], [rod], [piston] are missing" in answer.err


@pytest.mark.slow
def test_fast_engines_are_told_without_powers_of_ten(call, tmp_path):
    answer = call("mechanism", "8chn26-26", "--speed", "20000 1/min", "--pictures", "p")
    assert answer.code == 0
    assert "at 20000 1/min, rods" in answer.out
    for name in ("crankpin_polar", "piston_forces", "balance", "hinged_rods"):
        picture = (tmp_path / "p" / f"{name}.svg").read_text(encoding="utf-8")
        # Text is drawn; what it says stands beside it as a comment.
        assert "8ChN 26/26 (7-6D49), 20000 1/min" in picture


@pytest.mark.slow
def test_a_whole_engine_serves_as_its_mechanism(v8):
    whole = run_mechanism(load_engine("8chn13-14"))
    assert whole.torque.power == v8.torque.power


def test_rows_alike_become_one():
    assert merged_rows([["1", "a"], ["2", "b"], ["3", "a"]]) == [["1, 3", "a"], ["2", "b"]]
    assert merged_rows([[name, "a"] for name in "234"]) == [["2 to 4", "a"]]
    assert merged_rows([["1+5", "a"], ["2+6", "a"], ["3+7", "a"]]) == [["1+5, 2+6, 3+7", "a"]]


@pytest.mark.slow
def test_a_balanced_engine_has_no_picture_of_what_is_left(v8, tmp_path):
    six = run_mechanism(load_mechanism("6chn25-34"))
    assert "balance.svg" not in {path.name for path in MECHANISM.draw(tmp_path / "six", six)}
    assert "balance.svg" in {path.name for path in MECHANISM.draw(tmp_path / "eight", v8)}
