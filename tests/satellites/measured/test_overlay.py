"""Measured orders over an engine's: a record of its own chain, integrated apart, is found again."""

import importlib.util
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import engine_inputs
from crankfem.analyses.provenance import used_files
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.jobs.run_files import write_results
from crankfem.report.writing import render_report
from crankfem.satellites.measured.calibration.calibrated import calibrate
from crankfem.satellites.measured.measured_orders import MeasuredOrders
from crankfem.satellites.measured.measurement import Measurement
from crankfem.satellites.measured.overlay import overlay
from crankfem.satellites.measured.reporting import FinishedRun
from crankfem.satellites.measured.run import MeasuredVibration
from crankfem.satellites.measured.wheel import Wheel, number_teeth
from dynamics.response.forced import forced_response
from refusals import refused
from stand_ins import stored_results

ENGINE = "cat-3116"
RPM = np.pi / 30.0
vibration = cache(lambda: engine_vibration(ENGINE))


@cache
def builder():
    """The script that makes the record of the documentation, by its own time integration."""
    path = Path(__file__).parents[3] / "docs" / "build_measured_record.py"
    spec = importlib.util.spec_from_file_location("build_measured_record", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def steady_orders(place="free end", quantity="angle"):
    """Orders at some speeds, solved at each by the dynamic stiffness of plain matrices."""
    response = vibration().forced_torsional.response
    chain, given = response.chain, response.excitation
    speeds = np.linspace(1800.0, 2700.0, 61) * RPM
    nodes, ends = np.arange(len(chain.inertia)), np.array(chain.connections)
    along = (nodes == ends[:, 1:]).astype(float) - (nodes == ends[:, :1])
    stiffness = along.T @ (np.asarray(chain.stiffness)[:, None] * along)
    root = np.sqrt(np.asarray(chain.inertia))
    squares, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    shapes = shapes / root[:, None]
    at_speeds = given.at_speeds(speeds).forces
    w = np.outer(given.orders, speeds)[:, :, None]
    squares = np.maximum(squares, 0.0)
    gain = 1.0 / (squares - w**2 + 2j * 0.0125 * np.sqrt(squares) * w)
    moved = ((at_speeds @ shapes) * gain) @ shapes.T
    if quantity == "torque":
        values = (moved @ along.T * np.asarray(chain.stiffness))[:, :, chain.elements.index(place)]
    else:
        values = moved[:, :, chain.names.index(place)]
    count, size = speeds.size, given.orders.size
    return MeasuredOrders(
        orders=given.orders,
        speed=speeds,
        amplitude=values.T,
        scatter=np.full((count, size), 1e-7),
        place=place,
        quantity=quantity,
        correlation=np.eye(count),
        ramp=np.zeros(count),
        wheel_constant=np.zeros(size, dtype=bool),
        cycle=2,
        zero_known=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["angle", "torque"])
def test_orders_of_the_engine_itself_lie_on_its_own(quantity):
    names = vibration().forced_torsional.response.chain
    place = names.elements[3] if quantity == "torque" else names.names[0]
    found = overlay(steady_orders(place, quantity), vibration())
    assert found.by == "steady"
    assert found.difference < 1e-6
    assert found.doubt == ""
    first = found.pairs[0]
    assert (first.order, first.measured) == (6.0, close(first.calculated, rel=1e-6))


@pytest.mark.slow
def test_an_unknown_mark_and_a_wheel_are_chosen_to_agree():
    true = steady_orders()
    constants = np.where(true.orders % 1.0 == 0.0, 3e-3 * np.exp(1j * true.orders), 0.0)
    mark = np.radians(84.0)
    moved = true.amplitude * np.exp(1j * mark * true.orders) + constants
    whole = true.orders % 1.0 == 0.0
    record = replace(true, amplitude=moved, wheel_constant=whole, zero_known=False)
    found = overlay(record, vibration())
    assert found.difference < 0.01
    assert any("84.0 deg" in note for note in found.notes)


@pytest.mark.slow
def test_what_does_not_fit_is_told():
    true = steady_orders()
    shifted = overlay(replace(true, speed=true.speed * 0.9, amplitude=true.amplitude), vibration())
    assert "below the calculated" in shifted.doubt
    turned = replace(true, amplitude=-true.amplitude * np.exp(0.3j * true.orders**2))
    assert "More is left" in overlay(turned, vibration()).doubt
    with refused("place"):
        overlay(replace(true, place="crankpin 9"), vibration())
    with refused("engine"):
        overlay(replace(true, quantity="pressure"), vibration())
    with refused("record"):
        overlay(replace(true, speed=true.speed * 10.0), vibration())
    # A speed that changes unevenly and quickly is no steady one, and no run-up that is known.
    with pytest.raises(InputError, match="off by"):
        overlay(replace(true, ramp=np.linspace(-40.0, 90.0, true.speed.size)), vibration())


@pytest.mark.slow
def test_the_record_of_another_engine_at_one_speed_is_doubted():
    """Half orders alone are compared, with the mark unknown: another shipped engine leaves 70 to 75 %."""
    made = steady_orders()
    noise = np.random.default_rng(2).normal(size=(2, *made.amplitude.shape))
    scatter = 0.01 * np.abs(made.amplitude)
    record = replace(
        made,
        amplitude=made.amplitude + scatter * (noise[0] + 1j * noise[1]),
        scatter=scatter,
        wheel_constant=made.orders % 1.0 == 0.0,
        zero_known=False,
    ).part(slice(0, 1), made.orders <= 12.0)
    own = overlay(record, vibration())
    assert own.doubt == ""
    assert own.better == 0.0
    assert own.difference < 2.0 * own.by_scatter
    other = overlay(record, engine_vibration("yamz-5340"))
    assert other.difference < 1.0
    assert other.better > 0.05
    assert "other firing orders" in other.doubt
    # Of the same firing order: what is left is told beside the scatter.
    quicker = overlay(replace(record, speed=0.98 * record.speed), vibration())
    assert quicker.better == 0.0
    assert "at one speed" in quicker.doubt


@pytest.mark.slow
def test_orders_are_drawn_and_written(tmp_path):
    found = overlay(steady_orders(), vibration())
    run = MeasuredVibration.of("run.csv", steady_orders(), found)
    written = run.draw(tmp_path)
    assert [path.name for path in written] == ["orders_map.svg", "overlay.svg", "overlay.html"]
    assert "order 6 measured" in written[2].read_text(encoding="utf-8")
    lines = {line.get_label(): line for line in found.plot().lines}
    assert lines["order 6"].get_ydata() == close(
        np.degrees(np.abs(steady_orders().amplitude[:, 11])), rel=1e-5
    )


@pytest.mark.slow
def test_the_report_of_a_run_gets_the_overlay(tmp_path):
    engine = load_engine(ENGINE)
    with refused("--report"):
        FinishedRun.of(tmp_path, engine)
    content = stored_results()
    write_results(tmp_path, content)
    with refused("--report"):  # it is another engine's
        FinishedRun.of(tmp_path, engine)
    content["repeat"]["files"] = [
        {"name": file.name, "sha256": file.sha256, "text": None}
        for file in used_files(engine_inputs(engine))
    ]
    write_results(tmp_path, content)
    run = MeasuredVibration.of("run.csv", steady_orders(), overlay(steady_orders(), vibration()))
    for _ in range(2):  # the second takes the place of the first
        report = FinishedRun.of(tmp_path, engine).add(run)
    page = report.read_text(encoding="utf-8")
    assert page.count('<section id="added"') == 1
    assert 'id="plot-overlay"' in page
    assert 'id="picture-overlay"' in page
    assert run.overlay.conclusion.split(";")[0] in page
    # Numbers of the run stay as they are, and the report is the same when it is written again.
    stored = json.loads((tmp_path / "results.json").read_text())
    assert stored["vibration"] == content["vibration"]
    again = render_report(RunResults.from_json(json.dumps(stored)), tmp_path / "pictures")[0]
    assert again == page


@pytest.mark.further
def test_a_run_up_integrated_apart_is_that_of_the_engine():
    response = vibration().forced_torsional.response
    times = builder().pulses(response, 1900.0, 2800.0, 25.0, 1.0)
    measured = Measurement(
        number_teeth(times, Wheel(60, 2)), None, "angle", "free end", 2, None, ()
    ).orders()
    found = overlay(measured, vibration())
    assert found.by == "run-up"
    assert found.ramp_error > 0.02
    assert found.difference < 0.02
    first = found.pairs[0]
    assert first.order == 6.0
    assert first.measured == close(first.calculated, rel=0.01)
    # The same orders at steady speeds are not.
    speeds = found.measured.speed
    steady = forced_response(response.system, response.excitation.at_speeds(np.sort(speeds)))
    apart = found.measured.amplitude[np.argsort(speeds)] - steady.motion[:, :, 0].T
    assert np.linalg.norm(apart) > 2.0 * found.difference * np.linalg.norm(found.measured.amplitude)


@pytest.mark.slow
@pytest.mark.parametrize("speeds", [slice(30, 31), slice(None)], ids=["one speed", "many"])
def test_constants_of_the_wheel_do_not_make_another_engine_agree(speeds):
    made = steady_orders()
    # A four-cylinder's order 2 is large, a six-cylinder's is not.
    amplitude = 1e-6 * np.where(made.orders % 3.0 == 0.0, 50.0, 1.0) * np.ones(made.amplitude.shape)
    part = replace(
        made,
        speed=made.speed[speeds],
        amplitude=amplitude[speeds] + 0j,
        scatter=made.scatter[speeds],
        correlation=made.correlation[speeds, speeds],
        ramp=made.ramp[speeds],
        wheel_constant=made.orders % 1.0 == 0.0,
    )
    found = overlay(part, vibration())
    assert found.difference > 1.0
    assert found.doubt.startswith("More is left")
    if found.measured.speed.size == 1:
        assert all(pair.order % 1.0 for pair in found.pairs)
        assert any("half orders alone" in note for note in found.notes)


@pytest.mark.further
def test_the_record_of_the_page_gives_its_truth_back(tmp_path):
    """Of a shaft 6 % softer than its file says, from a quicker run-up past order 6 alone."""
    response = vibration().forced_torsional.response
    times = builder().pulses(response, 2400.0, 2800.0, 25.0, builder().SOFTER)
    teeth = number_teeth(times, Wheel(60, 2))
    record = Measurement(teeth, None, "angle", "free end", 2, None, ()).orders()
    made = calibrate(
        ENGINE,
        {"run.csv": record},
        {"torsional_compliance": 0.1, "damping.torsional_magnifier": 0.5, "gas torque": 0.1},
        output=tmp_path / "fitted.toml",
        analysis=vibration().analyses,
    )
    assert made.status != "does not fit"
    truth = (1.0 / builder().SOFTER, 1.0, 1.0)
    assert [group.factor for group in made.groups] == close(truth, rel=3e-3)
    fitted = load_engine(tmp_path / "fitted.toml")
    assert engine_vibration(fitted, analysis=vibration().analyses).assessment.verdict.status
