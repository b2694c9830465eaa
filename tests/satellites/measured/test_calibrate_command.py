"""The command `calibrate`: what it prints, its JSON, what it refuses."""

import json

import pytest
import typer

import crankfem as cf
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.measured.calibration.command import calibrate
from measured_engines import ENGINE, FIELDS, measured, written
from stand_ins import caller_of

MOVES = [word for name, share in FIELDS.items() for word in ("--move", f"{name}={share:.0%}")]


@pytest.fixture
def call():
    app = typer.Typer()
    app.command()(calibrate)
    return caller_of(app)


@pytest.fixture
def orders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written(measured(), tmp_path / "run.csv")
    written(measured("flywheel", seed=5), tmp_path / "flywheel.csv")
    return tmp_path


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


def test_the_answer_is_whether_the_records_fit(call, orders):
    out = call(ENGINE, "run.csv", "--at", "free end", "--gains", *MOVES[:6])
    answer = " ".join(out.split()).rpartition(" The records ")[2]
    assert answer.startswith("fit this engine: misfit ")
    assert answer.endswith("% of the measured squares explained.")
    assert "Gas torque of each cylinder over the mean of the others" in out
    assert "No cylinder is weak: one weaker by" in out
    assert "Use of limits with the maker's values and with the fitted ones" in out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run.csv", "--at", "a", "--at", "b"), "--at: given 2 for 1 tables"),
        (("run.csv", "run.csv", "--at", "a", "--at", "b"), "one table twice"),
        (("run.csv", "--at", "rudder", *MOVES), "rudder"),
        (("run.csv", "--at", "free end", "--overlap", "1"), "overlap: given 1"),
        (("none.csv", "--at", "free end"), "none.csv"),
    ],
)
def test_what_cannot_be_used_is_refused(call, orders, arguments, sentence):
    with pytest.raises(cf.InputError, match=sentence):
        call(ENGINE, *arguments)
