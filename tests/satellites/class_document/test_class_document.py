"""The torsional vibration document: its numbers, its files, and what is refused before."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankbase.quantity import RPM
from crankfem.analyses.vibration.assessment import ROWS_SHOWN
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.reading.data_files import input_path
from crankfem.satellites.class_document.document import check_submission, class_document
from crankfem.satellites.class_document.firing_cases import (
    CUT_OUT,
    DASHPOTS,
    MISFIRING,
    STRESS,
    TORQUE,
    _gear_torques,
    firing_cases,
    heat_factors,
    heat_of,
)
from crankfem.satellites.class_document.tables import holzer_table
from dynamics.chains.chain import Chain, Dashpot
from dynamics.response.forced import forced_response
from dynamics.response.loads import element_loads, power_balance
from dynamics.response.order_excitation import OrderExcitation

SPEEDS = np.array([60.0, 80.0, 130.0])
ORDERS = np.array([1.0, 2.5])


def excited(chain, node=0):
    forces = np.zeros((ORDERS.size, SPEEDS.size, chain.inertia.size), dtype=complex)
    forces[:, :, node] = [[100.0 + 20.0j], [30.0 - 50.0j]]
    return forced_response(chain, OrderExcitation(ORDERS, SPEEDS, forces))


def test_holzer_table_balances_in_a_row():
    chain = load_chain("mwm-six").chain
    modes = chain.modes()
    for mode in (1, 3):
        own = holzer_table(chain, modes, mode)
        assert own.amplitude[0] == 1.0
        w = modes.angular_frequencies[mode]
        assert own.inertia_torque == close(1e-3 * w**2 * chain.inertia * own.amplitude)
        # What the masses so far bring, the next shaft passes on.
        sums = np.cumsum(own.inertia_torque)
        assert own.torque == close(-sums[:-1], rel=1e-7, abs=1e-9 * np.max(np.abs(sums)))
        assert own.modal_inertia == close(np.sum(chain.inertia * own.amplitude**2))
        assert own.kinetic_shares.sum() == close(1.0)
        assert own.strain_shares.sum() == close(1.0)
        assert own.frequency == close(modes.frequencies[mode])


def test_heat_from_torques_is_that_of_the_power_balance():
    chain = Chain(
        [2.0, 5.0, 1.0, 0.5],
        [4e5, 9e4],
        connections=[(0, 1), (1, 2)],
        loss_factor=[0.0, 0.2],
        damping=[30.0, 5.0],
        dashpots=[Dashpot(0, 3, 40.0)],
    )
    response = excited(chain)
    loads, balance = element_loads(response), power_balance(response)
    factors = heat_factors(chain)
    assert list(factors) == [
        (TORQUE, "node 0 - node 1"),
        (TORQUE, "node 1 - node 2"),
        (DASHPOTS, "node 0 - node 3"),
    ]
    for place, (key, name) in enumerate(factors):
        series = loads.elements if key == TORQUE else loads.dashpots
        wanted = balance.elements[:, :, place] if key == TORQUE else balance.dashpots[:, :, 0]
        assert heat_of(series, name, factors[key, name]) == close(wanted.sum(axis=0))


def test_a_gear_holds_both_of_its_wheels_in_equilibrium():
    chain = load_chain("geared-example").chain
    response = excited(chain)
    (torque,) = np.moveaxis(_gear_torques(response, chain).values, 2, 0)
    (gear,) = chain.gears
    stiffness, masses = chain.stiffness_matrix(), chain.mass_matrix()
    w = response.angular_frequencies[:, :, np.newaxis]
    needed = response.motion @ stiffness.T - w**2 * (response.motion @ masses.T)
    left = needed - response.excitation.forces
    size = np.max(np.abs(needed))
    assert left[:, :, gear.driven] == close(torque)
    # The driver gets the same power with the opposite sign; no other node is held.
    assert left[:, :, gear.driver] == close(-gear.ratio * torque, abs=1e-9 * size)
    others = [node for node in range(5) if node not in (gear.driver, gear.driven)]
    assert np.max(np.abs(left[:, :, others])) < 1e-9 * size


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gas": None, "load": None, "limits": None}, "has no gas pressure"),
        ({"limits": {"generator_angle": 0.05}}, "limits.generator_angle: given without engine.gen"),
    ],
)
def test_what_no_document_can_be_made_of(change, said):
    engine = cf.load_engine("6chn25-34").changed(**{"load": None} | change)
    with pytest.raises(InputError, match=re.escape(said)):
        check_submission(engine)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"engine": {"generator_poles": 7}}, "engine.generator_poles: given 7"),
        ({"engine": {"drives": "propeller"}}, 'of what drives "propeller"'),
    ],
)
def test_poles_are_those_of_a_generator(change, said):
    engine = cf.load_engine("6chn18-22-set")
    with pytest.raises(InputError, match=re.escape(said)):
        engine.changed(**change)


PLANT = """
[shaft_line]
plant = { value = "5rt-flex50d-plant", source = "flex50d" }
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (PLANT, PLANT + 'torsional = "5rt-flex50d-plant"\n', "shaft_line.plant: given together"),
        ("5rt-flex50d-plant", "mwm-six", "shaft_line.plant: given a chain with 'cylinder 6'"),
        ("5rt-flex50d-plant", "axial.toml", "shaft_line.plant: given 'axial.toml', a chain of"),
        ("5rt-flex50d-plant", "short.toml", "shaft_line.plant: given a chain without 'cylinder 5'"),
        (
            PLANT,
            PLANT + '\n[driven]\ninertia = "5 kg m^2"\ncoupling_stiffness = "1e5 N m/rad"\n',
            "driven: given together with shaft_line.plant",
        ),
        ("torsional_magnifier", "loss_factor = 0.1\ntorsional_magnifier", "damping.loss_factor:"),
    ],
)
def test_a_plant_that_cannot_be_one(tmp_path, old, new, said):
    text = input_path("5rt-flex50d").read_text(encoding="utf-8")
    assert old in text
    row = '[chain]\nname = "x"\nkind = "{}"\nnames = [{}]\n{} = [{}]\nstiffness = [{}]\n'
    four = ", ".join(f'"cylinder {number}"' for number in range(1, 5))
    for name, kind, field, unit in (
        ("axial", "axial", "mass", "kg"),
        ("short", "torsional", "inertia", "kg m^2"),
    ):
        stiff = "N/m" if kind == "axial" else "N m/rad"
        values = ", ".join([f'"1 {unit}"'] * 4), ", ".join([f'"1e6 {stiff}"'] * 3)
        (tmp_path / f"{name}.toml").write_text(
            row.format(kind, four, field, *values), encoding="utf-8"
        )
    path = tmp_path / "engine.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=said):
        cf.load_engine(path)


@pytest.fixture(scope="module")
def plant(coarse_throw):
    engine, analysis = coarse_throw(
        "5rt-flex50d"
    )  # whose chain has none of the throw's compliances
    return engine_vibration(engine, analysis=analysis)


@pytest.fixture(scope="module")
def cases(plant):
    return firing_cases(plant)


@pytest.mark.further
def test_normal_firing_is_that_of_the_vibration_run(plant, cases):
    """At speeds that both have: same stresses, and the worst of each limit outside of barred ranges."""
    both, here, there = np.intersect1d(
        np.round(cases.speeds, 9),
        np.round(plant.forced_torsional.response.speeds, 9),
        return_indices=True,
    )
    assert both.size > 100
    stress = plant.forced_torsional.stress
    own = cases.normal[STRESS]
    for place, name in enumerate(stress.names):
        mine = own.values[:, here, own.names.index(name)]
        assert mine == close(stress.values[:, there, place], abs=1e3)
    assert cases.speeds[-1] == close(1.2 * plant.engine_file.engine.rated_speed)
    (barred,) = plant.assessment.verdict.ranges_to_bar
    for key, found in cases.firing.kept.items():
        assert not barred[0] < found.speed < barred[1], key
    for found in cases.firing.passed.values():
        assert barred[0] <= found.speed <= barred[1]


@pytest.mark.further
def test_failing_cylinders_are_those_of_a_calculation_of_their_own(plant, cases):
    """Misfiring beside the vibration run; cut out beside one that is told to have no compression."""
    cold = plant.engine_file.changed(misfire={"compression": False})
    other = engine_vibration(cold, analysis=plant.analysis)
    for way, run in ((MISFIRING, plant), (CUT_OUT, other)):
        check = next(one for one in run.misfiring.checks if one.quantity.endswith("crankshaft"))
        worst = max(
            cases.failing[way][number].kept[STRESS, place].used
            for number in cases.failing[way]
            for place in plant.forced_torsional.stress.names
        )
        assert worst == close(check.misfiring.used, rel=2e-3), way


@pytest.mark.further
def test_findings_say_what_the_tables_hold(plant, cases):
    """The worst of all cylinders and shafts, whether it is kept, and the major critical speed that is not."""
    parts = {part.name: part for part in class_document(plant)}
    said = parts["findings"].sentences
    for way, sentence in zip((MISFIRING, CUT_OUT), said[1:3], strict=True):
        used = {
            (number, place): found.used
            for number, case in cases.failing[way].items()
            for (key, place), found in case.kept.items()
            if key == STRESS
        }
        (number, place), most = max(used.items(), key=lambda one: one[1])
        assert f"with {way}" in sentence.lower()
        assert ("exceeded" in sentence) == (most > 1.0)
        assert f"{place} with cylinder {number} failing" in sentence
        assert f"{100.0 * most:.3g} % of the permitted stress" in sentence
    uncertainty = plant.assessment.uncertainty["torsional"]
    assert len(parts["uncertainty"].sentences) >= len(uncertainty.spreads)
    assert len(parts["uncertainty"].tables[0].table.rows) == min(
        len(uncertainty.critical), ROWS_SHOWN
    )
    (row,) = parts["barred"].tables[0].table.rows
    assert [speed * RPM for speed in row[:2]] == close([61.80, 72.81], rel=1e-3)
    # What is undecided comes before the verdict with the values used.
    decided = replace(plant.assessment.decision, status="undecided", reasons=("give this",))
    open_ = replace(plant, assessment=replace(plant.assessment, decision=decided))
    headline = class_document(open_)[0].sentences[0]
    assert headline.startswith("Undecided: give this. With the values used, barred range needed, ")


TABLES = [
    *("engine", "masses", "shafts", "frequencies", "holzer_masses_1", "holzer_shafts_1"),
    *("vector_sums", "tangential_harmonics", "critical_speeds", "stress_normal"),
    *("stress_permitted", "stress_by_order", "torques", "stress_misfiring"),
    *("stress_misfiring_each", "stress_cut_out", "stress_cut_out_each", "uncertain_torsional"),
    *("dampers", "generator", "limits", "assumptions"),
]
DIAGRAMS = ["modes_1", "vectors_1", "campbell", "stress_1"]


@pytest.mark.further
def test_the_command_writes_every_table_and_replaces_only_its_own(call, tmp_path):
    folder = tmp_path / "out"
    first = call("class", "6chn18-22-set", "--output", str(folder))
    page = folder / "class.html"
    assert f"Document: {page}" in first.out.splitlines()
    assert "Permitted angle of the generator: kept." in first.out
    text = page.read_text(encoding="utf-8")
    assert "@page" in text
    assert "http" not in re.sub(r"http://www.w3.org[^\"]*", "", text.split("<body")[1])
    tables = {path.stem for path in (folder / "class-tables").glob("*.csv")}
    assert set(TABLES) <= tables
    assert all(f'id="{name}"' in text for name in tables)
    assert set(DIAGRAMS) <= {path.stem for path in (folder / "class-diagrams").glob("*.svg")}
    assert text.count("data:image/svg+xml") == len(list((folder / "class-diagrams").glob("*.svg")))

    with (folder / "class-tables" / "generator.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    # Eight poles: four electrical degrees to a mechanical one.
    for row in rows:
        mechanical = float(row["mechanical amplitude [deg]"])
        assert float(row["electrical angle [deg]"]) == close(4.0 * mechanical, rel=1e-5)
        assert float(row["used [%]"]) < 100.0
    # A second run replaces the first one; a table of the last document goes, a user's file stays.
    (folder / "class-tables" / "mine.txt").write_text("mine", encoding="utf-8")
    again = call("class", "6chn18-22-set", "--output", str(folder), "--quiet")
    assert again.out.strip() == str(page)
    assert (folder / "class-tables" / "mine.txt").read_text(encoding="utf-8") == "mine"
    assert {path.stem for path in (folder / "class-tables").glob("*.csv")} == tables
    page.write_text("my own", encoding="utf-8")
    refused = call("class", "6chn18-22-set", "--output", str(folder))
    assert refused.code == 2
    assert "changed since crankfem wrote it" in refused.err
    assert page.read_text(encoding="utf-8") == "my own"


@pytest.mark.slow
def test_sentences_for_wrong_input(call, tmp_path):
    assert "--output" in call("class", "6chn25-34").err
    file = tmp_path / "file"
    file.write_text("mine", encoding="utf-8")
    refused = call("class", "6chn25-34", "--output", "file")
    assert refused.code == 2
    assert "output: given 'file'" in refused.err
    assert file.read_text(encoding="utf-8") == "mine"
    assert "output: given ''" in call("class", "6chn25-34", "--output", "").err
    assert call("class", "mwm-six", "--output", str(tmp_path / "out")).code == 2
    assert not (tmp_path / "out").exists()


def test_check_tells_that_a_document_can_be_made(call, tmp_path, six_cylinders, edit):
    assert "class" in call("check", "6chn25-34", "--json").json()["commands"]
    path = tmp_path / "mine.toml"
    path.write_text(edit(six_cylinders, {"[gas]": None}), encoding="utf-8")
    commands = call("check", path, "--json").json()["commands"]
    assert "vibration" in commands
    assert "class" not in commands
    path.write_text(
        edit(six_cylinders, {"vibration.axial_source": '"regression"'}), encoding="utf-8"
    )
    assert "class" not in call("check", path, "--json").json()["commands"]
