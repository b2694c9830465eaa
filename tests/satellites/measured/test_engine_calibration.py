"""Calibration of a shipped engine by simulated records: its file, its verdict, its command."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.measured.calibration import calibrated
from crankfem.satellites.measured.calibration.calibrated import calibrate
from crankfem.satellites.measured.calibration.engine_problem import EngineModel
from crankfem.satellites.measured.calibration.groups import parsed_group
from crankfem.satellites.measured.calibration.orders_table import read_orders, write_orders
from crankfem.satellites.measured.calibration.response_slopes import Sensor
from crankfem.satellites.measured.calibration.told import calibration_parts
from measured_engines import (
    ENGINE,
    FIELDS,
    ORDERS,
    TRUTH,
    WITH_THROWS,
    calculated,
    measured,
    model,
    run,
    written,
)

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def calculated_once(monkeypatch):
    monkeypatch.setattr(calibrated, "engine_vibration", calculated)


def test_amplitudes_with_the_makers_values_are_those_of_the_verdict():
    engine = load_engine(ENGINE)
    of = EngineModel(run())
    speed = np.linspace(70.0, 160.0, 5)
    core = EngineChains.of(engine, run().axial, run().torsional, run().shaft)
    response = core.at(of.harmonics, speed)[1].response
    places = [int(np.argmin(np.abs(response.orders - order))) for order in ORDERS]
    w = np.outer(speed, ORDERS).ravel()
    for node in (0, 7):
        made, _ = of.shaft(()).amplitudes(
            np.zeros(0),
            Sensor(node),
            w,
            np.repeat(speed, ORDERS.size),
            of.excitation(ORDERS, speed),
        )
        expected = response.motion[places][:, :, node].T
        assert np.max(np.abs(made.reshape(5, -1) / expected - 1.0)) < 1e-9


def test_fields_are_written_with_source_interval_and_tolerance(tmp_path):
    path = tmp_path / "fitted.toml"
    made = calibrate(
        ENGINE, {"run 3.csv": measured()}, FIELDS, output=path, analysis=run().analyses
    )
    assert made.status == "fits"
    assert made.files == (str(path),)
    for group, true in zip(made.groups, TRUTH, strict=False):
        factor = np.exp(true * np.log1p(FIELDS[group.name]) / 2.0)
        assert group.low**1.5 * made[group.name].factor ** -0.5 < factor
        assert factor < group.high**1.5 * made[group.name].factor ** -0.5
        assert group.low < group.factor < group.high
    fitted = load_engine(path)
    before = load_engine(ENGINE)
    ratio = fitted.flywheel.inertia / before.flywheel.inertia
    assert abs(ratio / made["flywheel.inertia"].factor - 1.0) < 1e-12
    source, assumed = fitted.provenance["flywheel.inertia"]
    assert not assumed
    for part in ("run 3.csv", made.date, "95 %", "tolerance before 5 %", "4 kg m^2", "typical of"):
        assert part in source
    # The gain of the gas is in no field: it is said so.
    assert made.unwritten == ("gas torque",)
    # The file makes the fitted chain.
    chain = model().chain_of(fitted).chain
    shaft = made.fit.problem.shaft
    parameters = made.fit.parameters[: len(FIELDS)]
    assert np.max(np.abs(chain.inertia / shaft.chain_at(parameters).inertia - 1.0)) < 1e-12
    magnifier = fitted.damping.torsional_magnifier
    assert abs(magnifier / 40.0 / made["damping.torsional_magnifier"].factor - 1.0) < 1e-9
    # The new verdict is that of the file.
    again = engine_vibration(fitted, analysis=run().analyses).assessment.verdict
    assert made.verdict.status_after == again.status
    assert made.verdict.limits[0].after == max(check.used for check in again.checks)
    assert made.verdict.limits[0].before != made.verdict.limits[0].after
    # Alone, the groups explain most of the change of the worst use.
    change = made.verdict.limits[0].after - made.verdict.limits[0].before
    assert abs(sum(made.verdict.by_group.values()) / change - 1.0) < 0.3
    texts = [str(part) for part in calibration_parts(made)]
    assert any("The records fit this engine" in text for text in texts)
    made.to_json()


@pytest.mark.further
def test_compliances_of_throws_become_a_chain_of_the_plant(tmp_path):
    path = tmp_path / "fitted.toml"
    record = measured(groups=WITH_THROWS)
    beside = measured("flywheel", WITH_THROWS, 3)
    made = calibrate(
        ENGINE,
        {"pulley": record},
        WITH_THROWS,
        output=path,
        predict={"flywheel": beside},
        analysis=run().analyses,
    )
    assert made.status == "fits"
    assert [each.rpartition("/")[2] for each in made.files] == ["fitted.toml", "fitted-chain.toml"]
    assert made.predicted[0].inside > 0.9
    fitted = load_engine(path)
    expected = made.fit.problem.shaft.chain_at(made.fit.parameters[:5])
    for name in ("inertia", "stiffness"):
        ratio = getattr(fitted.shaft_lines["plant"], name) / getattr(expected, name)
        assert np.max(np.abs(ratio - 1.0)) < 1e-12
    content = tomllib.loads((tmp_path / "fitted-chain.toml").read_text())
    assert "95 %" in content["chain"]["elements"][1]["stiffness"]["source"]
    # What runs calculate of it is the fitted response, up to the magnifier, which the file has.
    after = engine_vibration(fitted, analysis=run().analyses)
    modes = after.torsional.chosen.modes.frequencies[1:]
    assert np.max(np.abs(modes / expected.modes().frequencies[1:] - 1.0)) < 1e-9


def test_a_record_of_degrees_for_radians_writes_nothing(tmp_path):
    record = measured()
    factor = 180.0 / np.pi
    wrong = replace(record, amplitude=factor * record.amplitude, scatter=factor * record.scatter)
    path = tmp_path / "fitted.toml"
    made = calibrate(ENGINE, {"wrong": wrong}, FIELDS, output=path, analysis=run().analyses)
    assert (made.status, made.slip) == ("does not fit", "degrees for radians")
    assert not made.files
    assert not path.exists()
    assert made.verdict is None
    *_, answer = calibration_parts(made)
    assert "do not fit" in answer
    assert "degrees for radians undone" in answer


def test_a_file_of_the_user_is_not_replaced(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("# mine\n")
    with pytest.raises(cf.InputError, match=r"mine\.toml"):
        calibrate(ENGINE, {"run": measured()}, FIELDS, output=path, analysis=run().analyses)
    assert path.read_text() == "# mine\n"


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("flywheel.weight", "flywheel.inertia|inertia"),
        ("flywheel.mass", "on which the torsional chain depends"),
        ("rod.mass", "parts of the torsional chain"),
        ("rudder", "unknown group"),
        ("torsional_damper.stiffness", "parts of the torsional chain"),
    ],
)
def test_groups_that_are_none_are_refused(name, sentence):
    with pytest.raises(cf.InputError, match=sentence):
        model().group(name, 0.1)


def test_nothing_that_may_move_is_refused():
    with pytest.raises(cf.InputError, match="--move: missing"):
        model().groups({})
    ranged = load_engine(ENGINE).changed(ranges={"inertia": (0.95, 1.05), "damping": (0.5, 2.0)})
    groups = EngineModel(replace(run(), engine_file=ranged)).groups({})
    assert [group.name for group in groups] == ["ranges.inertia", "ranges.damping"]
    assert abs(groups[1].deviation - 0.5 * np.log(2.0)) < 1e-12


def test_a_place_that_is_none_and_a_fast_ramp_are_refused():
    with pytest.raises(cf.InputError, match="rudder"):
        model().observation(replace(measured(), place="rudder"))
    with pytest.raises(cf.InputError, match="a ramp whose resonances lag"):
        model().observation(replace(measured(), ramp=np.full(30, 200.0)))


def test_orders_that_nothing_excites_are_left_out_with_a_remark():
    record = measured()
    odd = replace(record, orders=np.concatenate((ORDERS[:-1], [12.3])))
    observation, remarks = model().observation(odd)
    assert observation.measured.orders.size == 23
    assert any("12.3" in remark for remark in remarks)


def test_a_table_of_orders_is_read(tmp_path):
    record = measured()
    written(record, tmp_path / "orders.csv")
    made = read_orders(tmp_path / "orders.csv", "free end", overlap=0.5)
    assert np.allclose(made.amplitude, record.amplitude, rtol=1e-9)
    assert np.allclose(made.speed, record.speed, rtol=1e-9)
    assert np.allclose(made.scatter, record.scatter, rtol=1e-9)
    assert made.quantity == "angle"
    assert np.array_equal(made.wheel_constant, record.wheel_constant)
    assert abs(made.correlation[3, 4] - 0.5) < 1e-12
    assert made.correlation[3, 5] == 0.0


def test_a_table_keeps_ramp_correlation_and_an_unknown_zero(tmp_path):
    windows = np.arange(30)
    record = replace(
        measured(),
        ramp=np.linspace(1.0, 3.0, 30),
        correlation=np.exp(-np.abs(np.subtract.outer(windows, windows)) / 4.0),
        zero_known=False,
    )
    path = write_orders(tmp_path / "orders.csv", record)
    made = read_orders(path, "free end")
    assert np.allclose(made.amplitude, record.amplitude, rtol=1e-9)
    assert np.allclose(made.ramp, record.ramp, rtol=1e-9)
    assert made.independent == close(record.independent, rel=0.1)
    assert not made.zero_known
    assert read_orders(path, "free end", overlap=0.0).independent == 1.0
    path.write_text(path.read_text().replace("ramp [rad/s^2]", "ramp [rad/s]"))
    with pytest.raises(cf.InputError, match="ramp: given in"):
        read_orders(path, "free end")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("phase [deg]", "angle [deg]", "has no column phase"),
        ("amplitude [deg]", "amplitude [kg]", "allowed are rad, N m, m, Pa"),
        ("phase [deg]", "phase [m]", "allowed are deg and rad"),
        ("speed [1/min]", "speed [mm]", "allowed is a unit like rad/s"),
        ("700;0.5;", "700;x;", "x"),
        ("700;0.5;", "700;0.7;", "all orders, ascending, at each speed"),
    ],
)
def test_a_table_that_is_none_of_orders_is_refused(old, new, sentence, tmp_path):
    path = tmp_path / "orders.csv"
    written(measured(), path)
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(cf.InputError, match=sentence):
        read_orders(path, "free end")


def test_a_group_of_the_command_line_is_parsed():
    assert parsed_group("flywheel.inertia=5%") == ("flywheel.inertia", 0.05)
    name = "stiffness of cylinder 1 - cylinder 2"
    assert parsed_group(f"{name} = 0.1") == (name, 0.1)
    with pytest.raises(cf.InputError, match="allowed is a group and its tolerance"):
        parsed_group("flywheel.inertia")
