"""The command `mechanism`: balance, tables, files, pictures, and what it refuses."""

import csv
import json
import math
import shutil
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.diagrams import figure
from crankbase.errors import InputError
from crankbase.table import merged_rows
from crankfem.analyses.mechanism.engine_balance import EngineBalance, engine_balance, per_area_table
from crankfem.analyses.mechanism.hinged_rods import motion_columns
from crankfem.analyses.mechanism.mechanism_results import mechanism_results
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.mechanism.plots import (
    plot_accelerations,
    plot_balance,
    plot_hinged_rods,
    plot_polar_loads,
)
from crankfem.analyses.mechanism.rod_models import compare_rod_models
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.files.reading.data_files import data_folder, input_path
from crankfem.jobs.outputs import check_outputs
from crankfem.report.interactive.mechanism import MECHANISM
from dynamics.balance import balance, balancing_masses
from dynamics.engine.forces import LoadDiagram
from dynamics.engine.layout import EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.plots.load_diagrams import on_paper
from geometry.crankshaft import throw_masses
from json_units import numbers_with_units
from parts_in_a_line import cylinder
from satellite_cases import of_satellites


@pytest.fixture(scope="module")
def v8():
    return run_mechanism(load_mechanism("8chn13-14"))


def test_the_results_are_consistent(v8):
    results = mechanism_results(v8)
    work = sum(row.work for row in results.cylinders)
    # Four strokes: one cycle takes two turns.
    assert results.power == close(work * results.speed / (4.0 * math.pi), rel=1e-9)
    assert abs(results.energy_error) < 1e-12
    assert results.cylinders[0].mean_effective_pressure == close(1.1e6, rel=1e-6)
    assert len(results.crankpins) == 8
    assert len(results.main_bearings) == 5
    assumed = {entry.field for entry in results.assumed}
    assert {"rod.mass", "gas.mean_effective_pressure"} <= assumed
    assert "throw.web_width" not in assumed
    assert results.torque.smallest < results.torque.mean < results.torque.largest


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


@pytest.mark.slow
def test_the_balance_says_what_is_in_it(v8):
    """By hand, for a cross-plane V8: the first order's moment is sqrt(10) a w^2 times what turns."""
    found = engine_balance(v8)
    throw, density = v8.engine_file.throw, v8.engine_file.material.density
    bare = throw_masses(throw.changed(left_web=None, right_web=None), density)
    moments = [own.mass * own.center[1] for own in (throw_masses(throw, density), bare)]
    for row in found.throws:
        # Two rods on each pin, 2.66264 kg of each at it.
        assert row.rods == close((2 * 2.66264 * 0.07, 0.0))
        assert row.solid == close((moments[0], 0.0))
        assert row.counterweights == close((moments[0] - moments[1], 0.0))
        assert row.sum == close((row.rods[0] + moments[0], 0.0))
    # The halves of two reciprocating masses turn with the crank, and M l_d lambda behind it.
    one, pitch = found.balance.masses[0], 0.17
    turning = one.reciprocating * 0.07, one.lateral * 0.07 / 0.265
    scale = math.sqrt(10.0) * pitch * v8.speed**2
    with_solids, bare_moment = (
        scale * math.hypot(moment[0] + turning[0], turning[1])
        for moment in (found.throws[0].sum, found.throws[0].rods)
    )
    assert found.balance.rows[0].moment.major == close(with_solids, rel=1e-9)
    assert found.without_throws.moment == close(bare_moment, rel=1e-9)
    # Of throws without counterweights none are told.
    light = tuple(replace(row, counterweights=(0.0, 0.0)) for row in found.throws)
    bare = replace(found, throws=light)
    assert "throws' solids;" in bare.summary()
    _, told = bare.mass_tables()
    assert [one.name for one in told.columns] == ["throw", "rods", "solid", "sum", "at"]
    assert "counterweights" not in told.note
    assert (
        found.without_throws.moment == balance(v8.engine_file.layout, v8.speed).of(1).moment.major
    )


@pytest.mark.slow
def test_split_pins_are_counted_where_they_are():
    run = run_mechanism(load_mechanism("buick-3800"))
    found = engine_balance(run)
    split = found.throws[0]
    # Two pins 30 deg apart make 2 cos 15 deg, 15 deg ahead of the first.
    middle = math.radians(15.0)
    rods = 2.0 * 0.43 * run.layout.crank_radius * math.cos(middle)
    assert split.rods == close((rods * math.cos(middle), rods * math.sin(middle)), rel=1e-9)
    assert split.counterweights[0] < -0.05
    row = found.mass_tables()[1].rows[0]
    assert row[1] == split.rods[0]
    assert row[4] == close(math.hypot(*split.sum))
    assert row[5] == close(math.radians(15.0), abs=0.01)


def test_a_balance_is_read_as_it_was_written(v8):
    found = engine_balance(v8)
    text = found.to_json()
    again = EngineBalance.from_json(text)
    assert again.to_json() == text
    assert again.summary() == found.summary()
    units = {".".join(path): unit for path, _, unit in numbers_with_units(json.loads(text))}
    assert (units["orders.force.major"], units["orders.parts.lateral.moment.x"]) == ("N", "N m")


def test_motored_engine_gives_no_power():
    run = run_mechanism(load_mechanism("6chn25-34"), 20.0, motored=True)
    fired = run_mechanism(load_mechanism("6chn25-34"), 20.0)
    assert abs(run.torque.power) < 0.1 * fired.torque.power
    assert max(work.peak_pressure for work in run.works) < 6e6


@pytest.mark.further
def test_tables_and_files(call, tmp_path):
    files = ("--csv", tmp_path / "forces.csv", "--pictures", tmp_path / "p")
    answer = call("mechanism", "8chn26-26", *files, "--full")
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
    assert "2 5 hinged 255.4 15.22 -11.33 8.111" in shown
    assert "(3.1 %) to 48.09 m/s^2 at 155.5 deg (2.8 %)" in shown
    whole, first, second = (
        np.array([float(row[f"cylinder_5_{name}_m_s2"]) for row in rows])
        for name in ("acceleration", "order_1", "order_2")
    )
    assert np.max(np.abs(whole - first - second)) == close(3.043, abs=5e-3)
    assert np.max(second) == close(255.4, abs=0.05)


@pytest.mark.further
def test_two_models_of_the_rods(call, tmp_path):
    asked = ("mechanism", "8chn13-14", "--model", "two-mass", "--model", "three-mass")
    answer = call(*asked, "--csv", tmp_path / "f.csv", "--pictures", tmp_path / "p", "--full")
    shown = " ".join(answer.out.split())
    assert "three-mass 2.28 1.316 0.6035 0" in shown
    changes = ("-5.51 %", "33 deg", "-2.29 %", "38 deg", "-0.78 %", "-0.01 %")
    assert all(change in shown for change in changes)
    assert (tmp_path / "p" / "rod_models.svg").is_file()
    with (tmp_path / "f.csv").open(encoding="utf-8") as file:
        next(file)
        rows = list(csv.DictReader(file))
    row = rows[66]  # 33 deg
    static, dynamic = (float(row[f"crankpin_cylinder_1_{name}_N"]) for name in asked[3::2])
    assert float(row["difference_of_same_angle"]) == close(dynamic / static - 1.0)
    assert 100.0 * float(row["difference_of_same_angle"]) == close(-5.51, abs=5e-3)
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    tangential, radial = (
        columns[f"cylinder_1_{force}_N"] + columns[f"difference_{force}_N"]
        for force in ("tangential", "radial")
    )
    whole = columns["crankpin_cylinder_1_three-mass_N"]
    assert np.hypot(tangential, radial) == close(whole, rel=1e-9)
    sides = [
        run_mechanism(load_mechanism("8chn13-14"), model=model).forces.side[0]
        for model in ("two-mass", "three-mass")
    ]
    assert columns["difference_side_N"] == close(sides[1] - sides[0], abs=1e-6)
    for name in ("piston_motion", "crankpins"):
        assert (tmp_path / "p" / f"{name}.svg").stat().st_size > 10_000


@pytest.mark.slow
def test_the_motion_of_the_third_mass(v8):
    """Yamanin, Zhukov, Baryshnikov 2018, equation (3), differentiated here by finite differences."""
    radius, length, foot, aside = 0.07, 0.265, 0.097, 0.009  # R, L, l_shk, l_d
    alpha = np.radians(np.arange(0.0, 360.0, 0.01))
    beta = np.arcsin(radius / length * np.sin(alpha))
    up = radius * np.cos(alpha) + foot * np.cos(beta) + aside * np.sin(beta)
    across = radius * np.sin(alpha) - foot * np.sin(beta) + aside * np.cos(beta)
    rod = replace(v8.layout.cylinders[0].rod, center_offset=aside)
    one = replace(v8.layout.cylinders[0], rod=rod, crank_angle_deg=0.0, bank_angle_deg=0.0)
    columns = motion_columns(EngineLayout(radius, [one], [1]), v8.speed, (1,), alpha)
    for name, place in (("", -up), ("_across", across)):
        rate = np.gradient(np.gradient(place, alpha), alpha)[2:-2] * v8.speed**2
        found = columns[f"cylinder_1_rod_center_acceleration{name}_m_s2"][2:-2]
        assert found == close(rate, abs=1e-5 * np.max(np.abs(rate)))
    travel = radius * (1.0 - np.cos(alpha)) + length * (1.0 - np.cos(beta))
    assert columns["cylinder_1_piston_travel_m"] == close(travel, abs=1e-12)


@pytest.mark.slow
def test_masses_over_the_piston_area_are_those_of_the_papers_table(v8):
    """Mikhina, Vyalkov 2024, table 2, whose areas are those of a piston of 265 mm, not of 260 mm."""
    run = run_mechanism(load_mechanism("8chn26-26"))
    rows, car = (
        np.array(
            [row[1:] for row in per_area_table(each.layout.cylinders, each.balance).rows], float
        )
        for each in (run, v8)
    )
    printed = np.array([799.2, 1195.8, 998.1]) * (0.265 / 0.26) ** 2
    assert [rows[0, 0], rows[0, 1], rows[4, 1]] == close(printed, rel=1e-3)
    assert np.all(car[:, :2] < [270.0, 410.0])


@pytest.mark.further
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
    assert run_mechanism(load_engine("8chn13-14")).torque.power == v8.torque.power


def test_rows_alike_become_one():
    assert merged_rows([["1", "a"], ["2", "b"], ["3", "a"]]) == [["1, 3", "a"], ["2", "b"]]
    assert merged_rows([[name, "a"] for name in "234"]) == [["2 to 4", "a"]]
    assert merged_rows([["1+5", "a"], ["2+6", "a"], ["3+7", "a"]]) == [["1+5, 2+6, 3+7", "a"]]


@pytest.mark.further
def test_a_balanced_engine_has_no_picture_of_what_is_left(v8, tmp_path):
    six = run_mechanism(load_mechanism("6chn25-34"))
    assert "balance.svg" not in {path.name for path in MECHANISM.draw(tmp_path / "six", six)}
    assert "balance.svg" in {path.name for path in MECHANISM.draw(tmp_path / "eight", v8)}


SPEED = 1000.0 * math.pi / 30.0


def vee():
    """Two throws, cranks opposite, a hinged rod on each main rod."""
    main, hinged = ConnectingRod(0.65, 75.0, 0.17, 4.0), ConnectingRod(0.5, 24.0, 0.23, 1.0)
    cylinders = []
    for throw, crank in enumerate((0.0, math.pi)):
        pin = SlavePin(2 * throw + 1, 0.15, angle_deg=45.0)
        cylinders += [
            cylinder(0.26, 44.1, main, math.degrees(crank), -22.5, 0.4 * throw),
            cylinder(0.26, 44.1, hinged, math.degrees(crank), 22.5, 0.4 * throw, slave_pin=pin),
        ]
    return EngineLayout(0.13, cylinders, [1, 2, 3, 4])


@pytest.mark.further
def test_pictures(tmp_path):
    engine = vee()
    plot_balance(tmp_path / "forces.svg", balance(engine, SPEED), title="V4 at 1000 1/min")
    assert "V4 at 1000 1/min" in (tmp_path / "forces.svg").read_text(encoding="utf-8")
    balanced = replace(engine, rotating=balancing_masses(engine))
    plot_balance(tmp_path / "second.svg", balance(balanced, SPEED, (2,)))
    plot_hinged_rods(tmp_path / "hinged.svg", engine, SPEED, cylinders=[1, 2])
    plot_accelerations(tmp_path / "pistons.svg", engine, SPEED, {1: "main rod", 2: "hinged rod"})
    again = tmp_path / "again.svg"
    plot_hinged_rods(again, engine, SPEED, cylinders=[1, 2])
    assert again.read_bytes() == (tmp_path / "hinged.svg").read_bytes()
    assert all(
        file.read_text(encoding="utf-8").rstrip().endswith("</svg>")
        for file in tmp_path.glob("*.svg")
    )
    with pytest.raises(InputError, match="cylinder: given 7"):
        plot_accelerations(again, engine, SPEED, {7: "none"})


TABLE = data_folder() / "tables" / "yamz5340_torque_one_throw.csv"
COMMANDS = {
    "mechanism": ("mechanism", input_path("6chn25-34")),
    "harmonics": ("harmonics", input_path("6chn25-34")),
    "harmonics of a table": ("harmonics", TABLE),
    **{
        name: (words[0], file)
        for name, (file, words, _) in of_satellites("WRITES").items()
        if "--csv" in words
    },
}


@pytest.mark.parametrize("case", COMMANDS)
def test_an_input_is_never_written_over(call, tmp_path, case):
    command, shipped = COMMANDS[case]
    mine = tmp_path / f"mine{shipped.suffix}"
    shutil.copy(shipped, mine)
    before = mine.read_bytes()
    # Another name of the same file: the names alone do not tell.
    answer = call(command, mine.name, "--csv", tmp_path / "." / mine.name)
    assert (answer.code, answer.out) == (2, "")
    assert mine.read_bytes() == before


@pytest.mark.parametrize("case", COMMANDS)
def test_folders_and_files_are_told_apart(call, tmp_path, case):
    command, shipped = COMMANDS[case]
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    for option, value in (
        ("--csv", "folder"),
        *(("--pictures", one) for one in ("file", "file/in", "")),
    ):
        answer = call(command, shipped, option, value)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith(f"Error: {option} {value}".rstrip())
        assert answer.err.count("\n") == 1


def test_a_pressure_table_is_an_input_too(call, tmp_path, edit):
    table = tmp_path / "pressure.csv"
    rows = "".join(f"{angle},{5.0 if angle == 0 else 1.0}\n" for angle in range(0, 720, 5))
    table.write_text(f"crank_angle_deg,absolute_pressure_bar\n{rows}", encoding="utf-8")
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    changes = {"[gas]": None}
    mine = tmp_path / "mine.toml"
    mine.write_text(
        edit(text, changes) + '\n[gas]\npressure_table = "pressure.csv"\n', encoding="utf-8"
    )
    before = table.read_bytes()
    for command in ("mechanism", "harmonics"):
        answer = call(command, mine, "--csv", table)
        assert answer.code == 2
        assert table.read_bytes() == before


def test_a_folder_that_takes_no_files(monkeypatch, tmp_path):
    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryFile", full)
    with pytest.raises(InputError, match="No space"):
        check_outputs(None, str(tmp_path))


@pytest.mark.parametrize("name", ["picture", "picture.png", "nowhere/picture.svg"])
def test_a_diagram_is_an_svg_file_in_a_folder_that_is_there(tmp_path, name):
    with (
        pytest.raises(InputError, match=r"path: "),
        figure(tmp_path / name),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_the_path_may_be_text(tmp_path):
    with figure(str(tmp_path / "picture.svg")):
        pass
    assert (tmp_path / "picture.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")


ANGLES = np.radians(np.arange(0.0, 720.0, 15.0))


@pytest.fixture
def diagram():
    """3 kN outwards and 4 kN with the rotation, on a crank that stands at 0.5 rad."""
    force = 1e3 * (3.0 + 4.0j) * np.exp(1j * (0.5 + ANGLES))
    return LoadDiagram("pin", np.degrees(ANGLES), force, np.degrees(0.5))


def test_the_crank_stands_upright_and_turns_clockwise(diagram):
    """Right is with the rotation and up outwards; at rest, right is -x, seen from the free end."""
    np.testing.assert_allclose(on_paper(diagram, "crank"), 4.0 + 3.0j, rtol=1e-12)
    columns = diagram.columns()
    at_rest = 1e-3 * (-columns["force_x_N"] + 1j * columns["force_y_N"])
    np.testing.assert_allclose(on_paper(diagram, "engine"), at_rest, rtol=1e-12)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"labels": ["one", "two"]}, "labels: given 2 for 1 diagrams"),
        ({"frame": "ship"}, "frame: given 'ship'; allowed are crank, engine"),
        ({"mark_step_deg": 0.0}, "mark_step_deg: given 0 deg; allowed are finite numbers of more"),
    ],
)
def test_what_does_not_fit_is_refused(diagram, tmp_path, more, words):
    with pytest.raises(InputError, match=words):
        plot_polar_loads(tmp_path / "x.svg", [diagram], **more)
    with pytest.raises(InputError, match=r"diagrams: "):
        plot_polar_loads(tmp_path / "x.svg", [])
