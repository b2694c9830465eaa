"""The command `calibrate`: what it prints, its JSON, what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest
import typer
from scipy.interpolate import CubicSpline
from typer.testing import CliRunner

import crankfem as cf
from crankbase.errors import MissingLibraryError
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.measured.calibration import calibrated, sampling
from crankfem.satellites.measured.calibration.command import calibrate
from crankfem.satellites.measured.calibration.response_slopes import Sensor
from measured_engines import ENGINE, FIELDS, ORDERS, TRUTH, calculated, measured, model, written
from stand_ins import caller_of

pytestmark = pytest.mark.slow
MOVES = [word for name, share in FIELDS.items() for word in ("--move", f"{name}={share:.0%}")]


@pytest.fixture
def app(monkeypatch):
    monkeypatch.setattr(calibrated, "engine_vibration", calculated)
    app = typer.Typer()
    app.command()(calibrate)
    return app


@pytest.fixture
def call(app):
    return caller_of(app)


@pytest.fixture
def orders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written(measured(), tmp_path / "run.csv")
    written(measured("flywheel", seed=5), tmp_path / "flywheel.csv")
    return tmp_path


@pytest.mark.further
def test_json_has_factors_verdict_and_files(call, orders):
    places = ("--at", "free end", "--at", "flywheel", "--predict", "flywheel.csv")
    told = json.loads(call(ENGINE, "run.csv", *places, *MOVES, "--output", "fitted.toml", "--json"))
    assert told["status"] == "fits"
    assert told["files"] == ["fitted.toml"]
    group = next(each for each in told["groups"] if each["name"] == "free_end.inertia")
    assert group["low"] < group["factor"] < group["high"]
    inertia = load_engine("fitted.toml").free_end.inertia
    assert abs(inertia / 0.02 / group["factor"] - 1.0) < 1e-12
    assert told["predicted"][0]["inside"] > 0.9
    assert told["verdict"]["status_after"]
    assert told["verdict"]["limits"][0]["speed_after_rpm"] > 600.0
    assert told["units"]["frequency_after"] == "Hz"


@pytest.mark.further
def test_the_answer_is_whether_the_records_fit(call, orders):
    out = call(ENGINE, "run.csv", "--at", "free end", "--gains", *MOVES[:6])
    answer = " ".join(out.split()).rpartition(" The records ")[2]
    assert answer.startswith("fit this engine: misfit ")
    assert answer.endswith("% of the measured squares explained.")
    assert "Gas torque of each cylinder over the mean of the others" in out
    assert "No cylinder is weak: one weaker by" in out
    assert "Use of limits with the maker's values and with the fitted ones" in out


def pulse_times(seconds: float = 40.0):
    """Pulses of a 60-2 wheel at the free end during a run-up, whose pitches err; with the fitted values."""
    of = model()
    groups = of.groups(FIELDS)
    low, high = np.array([700.0, 1500.0]) * np.pi / 30.0
    speed = np.linspace(low, high, 600)
    acting = of.excitation(ORDERS, speed)
    w, over = np.outer(speed, ORDERS).ravel(), np.repeat(speed, ORDERS.size)
    y, _ = of.shaft(groups).amplitudes(TRUTH[:4], Sensor(0), w, over, acting)
    steady = CubicSpline(speed, y.reshape(speed.size, -1))
    ramp = (high - low) / seconds

    def orders(at):
        """Amplitudes with their lag: of the frequency w = n at, which grows by n ramp, to the first order."""
        return steady(at) - 0.5j * ramp / ORDERS * steady(at, 2)

    # Eight rigid angles to a pitch, at which the wheel is turned by its vibration.
    rigid = np.arange(0.0, 0.5 * (low + high) * seconds, 2.0 * np.pi / 480.0)
    time = (np.sqrt(low**2 + 2.0 * ramp * rigid) - low) / ramp
    motion = np.zeros(rigid.size)
    for part in np.array_split(np.arange(rigid.size), 200):
        amplitudes = orders(low + ramp * time[part])
        waves = np.exp(1j * np.outer(rigid[part], ORDERS))
        motion[part] = np.sum((amplitudes * waves).real, axis=1)
    number = np.arange(1, int(rigid[-1] / (2.0 * np.pi)) * 60)
    number = number[number % 60 < 58]
    errors = np.random.default_rng(3).normal(size=60) * 0.01
    teeth = 2.0 * np.pi / 60.0 * (number + errors[number % 60])
    passed = np.interp(teeth, rigid + motion, rigid)
    return np.interp(passed, rigid, time)


@pytest.mark.further
def test_a_record_of_pulses_is_fitted(call, orders):
    """From pulse times of a wheel to the truth, by whole orders less its constants, the zero known."""
    times = "\n".join(f"{time:.9f}" for time in pulse_times())
    (orders / "pulses.csv").write_text(f"pulse_time_s\n{times}\n")
    wheel = ("--teeth", "60-2", "--mark-angle", "0 deg")
    told = json.loads(call(ENGINE, "pulses.csv", "--at", "free end", *wheel, *MOVES, "--json"))
    assert told["status"] != "does not fit"
    for group, truth in zip(told["groups"], TRUTH, strict=False):
        factor = np.exp(truth * np.log1p(FIELDS[group["name"]]) / 2.0)
        width = np.log(group["high"] / group["low"])
        assert abs(np.log(group["factor"] / factor)) < max(width, 0.01), group


def test_records_that_do_not_fit_end_with_a_code(app, orders):
    record = measured()
    written(replace(record, amplitude=60.0 * record.amplitude), orders / "wrong.csv")
    words = (ENGINE, "wrong.csv", "--at", "free end", *MOVES, "--json")
    answer = CliRunner().invoke(app, words)
    assert (answer.exit_code, json.loads(answer.stdout)["status"]) == (0, "does not fit")
    answer = CliRunner().invoke(app, (*words, "--output", "fitted.toml"))
    assert (answer.exit_code, json.loads(answer.stdout)["status"]) == (2, "does not fit")
    assert not (orders / "fitted.toml").exists()


def test_samples_name_their_extra_before_anything_is_calculated(call, orders, monkeypatch):
    monkeypatch.setattr(sampling, "find_spec", {}.get)
    monkeypatch.setattr(calibrated, "engine_vibration", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'crankfem\[sampling\]'"):
        call(ENGINE, "run.csv", "--at", "free end", *MOVES, "--sample")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run.csv", "--at", "a", "--at", "b"), "--at: given 2 for 1 records"),
        (("run.csv", "run.csv", "--at", "a", "--at", "b"), "given one twice"),
        # Before a record is read.
        (("none.csv", "--at", "rudder", *MOVES), "--at: given .rudder"),
        (("run.csv", "--at", "free end", "--overlap", "1"), "overlap: given 1"),
        (("run.csv", "--at", "free end", "--mark-angle", "3 deg"), "given without --teeth"),
        (("none.csv", "--at", "free end"), "none.csv"),
    ],
)
def test_what_cannot_be_used_is_refused(call, orders, arguments, sentence):
    with pytest.raises(cf.InputError, match=sentence):
        call(ENGINE, *arguments)
