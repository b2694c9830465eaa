"""The command `hinge`, and its files."""

import csv
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.files.reading.data_files import data_folder, input_path
from crankfem.satellites.hinge.file import load_hinge
from crankfem.satellites.hinge.run import run_hinge

SHIPPED = "crosshead-30-100"


@pytest.fixture
def changed(tmp_path, edit):
    def make(changes):
        path = tmp_path / "mine.toml"
        path.write_text(
            edit(input_path(SHIPPED, "hinge").read_text(encoding="utf-8"), changes), "utf-8"
        )
        return path

    return make


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"engine.bore": "300"}, "engine.bore: given 300, "),
        ({"hinge.design_speed": '"90 1/min"'}, r"hinge.design_speed: given 90 1/min; allowed are"),
        ({"hinge.color": '"red"'}, "hinge.color: unknown field"),
        ({"rod.inertia": None}, "rod.inertia: missing"),
        ({"[sliding]": None}, r"the section \[sliding\] is missing"),
        ({"engine.crank_radius": '"1.6 m"'}, r"crank_radius: given 1\.6 m"),
    ],
)
def test_files_refused(changed, changes, match):
    path = changed(changes)
    with pytest.raises(InputError, match=match):
        load_hinge(path)


def test_angles_of_a_cycle_that_cannot_be(changed):
    path = changed({"cycle.combustion_start": '"20 deg"', "cycle.exhaust_opens": '"1.1 rad"'})
    message = r"^exhaust_opens: given 63\.0254 deg, with end of combustion at 80 deg; allowed is"
    with pytest.raises(InputError, match=message):
        load_hinge(path).moment()


def test_a_file_without_running_points(changed):
    path = changed({"[comparison]": None, "[[comparison.sizes]]": None})
    assert load_hinge(path).comparison is None
    assert load_hinge(path).compared(load_hinge(path).moment()) == ()
    bare = changed({"[[operation.points]]": None})
    with pytest.raises(InputError, match=r"operation\.points: given none; allowed are one or more"):
        load_hinge(bare)


def test_a_file_that_is_not_there():
    with pytest.raises(InputError, match=r"nowhere: does not exist; .*crosshead-30-100"):
        load_hinge("nowhere")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--speed", "100 1/min"), "--speed: given 100 1/min; allowed are the speeds"),
        (("--speed", "142"), "--speed: given '142', a bare number"),
        (("--roller-radius", "60"), "--roller-radius: given '60', a bare number"),
        (("--roller-radius", "-6 mm"), "roller_radius: given -0.006 m; allowed"),
        (("--kinematics", "round"), "--kinematics: given 'round'; allowed are exact, series"),
        (("--csv", "no/such/folder.csv"), "cannot be written"),
    ],
)
def test_arguments_refused(call, arguments, message):
    answer = call("hinge", *arguments)
    assert answer.code == 2
    assert message in answer.err


@pytest.mark.further
def test_results_as_json_table_and_pictures(call, tmp_path):
    rollers = ("--roller-radius", "60 mm")
    answer = call("hinge", "--json", "--csv", "turn.csv", "--pictures", "pictures", *rollers)
    assert answer.code == 0, answer.err
    found = answer.json()
    turning = found["turning"]
    assert turning["with_hinge"]["fluctuation"] < 1e-3 * turning["without"]["fluctuation"]
    assert turning["with_hinge"]["mean_speed_rpm"] == close(89.0, rel=1e-6)
    assert turning["flywheel"]["fluctuation"] == close(0.02, rel=1e-9)
    assert not turning["without"]["comes_round_at_mean_speed"]
    assert [other["speed_rpm"] for other in found["other_speeds"]] == close([129.0, 142.0])
    assert all(check["met"] for check in found["profile"]["checks"])
    assert len(found["compared"]) == 6
    assert len(found["assumed"]) == 14
    for name in ("hinge_moment", "hinge_speed", "hinge_guides", "hinge_surface"):
        assert (tmp_path / "pictures" / f"{name}.svg").stat().st_size > 10_000
    with (tmp_path / "turn.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 1440
    moment = np.array([float(row["hinge_moment_N_m"]) for row in rows])
    assert moment.max() == close(found["hinge_moment"]["largest"], rel=1e-11)
    surface = np.array([complex(float(row["guide_x_m"]), float(row["guide_y_m"])) for row in rows])
    radius = np.array([float(row["radius_m"]) for row in rows])
    angle = np.radians([float(row["crank_angle_deg"]) for row in rows])
    assert np.abs(surface - radius * np.exp(1j * angle)) == close(0.060, abs=1e-9)
    assert found["profile"]["surface"]["smallest_radius"] == close(np.abs(surface).min())
    slope = np.array([float(row["slope_m_per_rad"]) for row in rows])
    force = np.array([float(row["spring_force_N"]) for row in rows])
    # 2 F_pn rho' is the moment but for the spline of the guides.
    np.testing.assert_allclose(2.0 * force * slope, moment, atol=1e-4 * np.abs(moment).max())


@pytest.mark.further
def test_guides_by_the_series_turn_in_the_exact_mechanism():
    """The crank let turn is exact whatever the guides were made by: 0.038, as documented."""
    run = run_hinge(load_hinge(SHIPPED), "series", 142.0 * np.pi / 30.0)
    assert (run.moment.kinematics, run.point.kinematics) == ("series", "exact")
    assert run.turning.with_hinge.fluctuation == close(0.038, abs=0.0005)


@pytest.mark.further
def test_flywheels_at_another_speed():
    """With the best pressure, not that of the design; both documented to the last digit given."""
    (other,) = run_hinge(load_hinge(SHIPPED), speed=142.0 * np.pi / 30.0).others
    assert other.flywheel_with_hinge == close(2277.0, abs=0.5)
    assert other.flywheel == close(33514.0, abs=0.5)


@pytest.mark.further
def test_a_pressure_chosen_for_a_running_point(changed):
    """Without ambient pressure the guides' moment grows as the pressure; at the best one it leaves what
    the best leaves."""
    speed = 142.0 * np.pi / 30.0
    best = run_hinge(load_hinge(SHIPPED), speed=speed).others[0]
    path = changed({})
    text = path.read_text("utf-8")
    for pressure in (9.75e6, best.best.pressure):
        point = f'speed = "142 1/min"\npressure = "{pressure!r} Pa"'
        path.write_text(re.sub(r"(?m)^speed = .*142 .*", point, text), "utf-8")
        run = run_hinge(load_hinge(path), speed=speed)
        (other,) = run.others
        drawn = run.plot().lines[-2].get_ydata()  # behind it is the zero line
        assert drawn == close(1e-3 * pressure / 5e6 * run.profile.moment)
    assert other.chosen.fluctuation == close(best.best.fluctuation, rel=1e-6)
    assert other.chosen.flywheel == close(best.flywheel_with_hinge, rel=1e-6)
    assert other.chosen.moment_residual == close(best.best.moment_residual)
    path.write_text(re.sub(r"(?m)^speed = .*89 .*", point.replace("142", "89"), text), "utf-8")
    with pytest.raises(InputError, match=r"points\.pressure: given 12\.\d+ MPa at design_speed; "):
        load_hinge(path)


@pytest.mark.further
def test_guides_are_drawn_without_a_comparison(call, changed, tmp_path):
    path = changed({"[comparison]": None, "[[comparison.sizes]]": None})
    run = run_hinge(load_hinge(path), speed=142.0 * np.pi / 30.0)
    drawn = run.plot(show="guides").lines[1].get_xydata()[:-1]
    assert np.hypot(*drawn.T) == close(run.profile.radius)
    answer = call("hinge", path, "--pictures", "p", "--json", "--speed", "142 1/min")
    assert "hinge_guides.svg" in " ".join(answer.json()["pictures"]), answer.err
    assert answer.json()["compared"] == []


@pytest.mark.further
def test_tables_and_options(call, changed):
    asked = ("--speed", "142 1/min", "--kinematics", "printed", "--full")
    answer = call("hinge", SHIPPED, *asked)
    assert answer.code == 0, answer.err
    assert "(printed" in answer.out
    assert "At 142 1/min with the pressure unchanged" in answer.out
    assert "At 129 1/min" not in answer.out
    # Root mean square, and the largest beside it; which is which is told.
    assert re.search(r"  \d+\.?\d*, at most \d+\.?\d*\n", answer.out)
    assert "first by root mean squares, then by largest values" in answer.out
    weak = call(
        "hinge",
        changed({"comparison.pressures": '["0.2 MPa"]', "hinge.pressure": '"3 MPa"'}),
        "--full",
    )
    assert weak.code == 0, weak.err
    assert "not feasible" in weak.out
    assert "the compression z must stay below the height H" in weak.out
    none = call("hinge", changed({"hinge.pressure": '"0.2 MPa"'}))
    assert none.code == 2
    assert "pressure: given 0.2 MPa" in none.err


def test_a_hinge_file_is_checked(call, tmp_path):
    hinge = call("check", SHIPPED, "--json").json()
    assert (hinge["kind"], hinge["commands"], hinge["shape"]) == ("hinge", ["hinge"], None)
    assert {"engine", "hinge", "operation"} <= set(hinge["sections"])
    assert "valid hinge file" in call("check", SHIPPED).out
    assert call("new", "mine.toml", "--from", SHIPPED).code == 0
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace("[sliding]", "[slidng]"), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert answer.code == 2
    assert "[slidng] is an unknown section" in answer.err


def test_a_hinge_file_is_copied_and_listed(call, tmp_path):
    answer = call("new", "hinge.toml", "--from", SHIPPED)
    assert answer.code == 0
    assert "crankfem hinge hinge.toml" in answer.out
    assert (tmp_path / "hinge.toml").read_bytes() == input_path(SHIPPED, "hinge").read_bytes()
    shipped = call("new", "--list", "--json").json()["shipped"]
    assert {one["name"]: one["kind"] for one in shipped}[SHIPPED] == "hinge"


def test_sections_and_running_points_of_a_hinge_file(told):
    text = input_path("crosshead-30-100", "hinge").read_text(encoding="utf-8")
    changes = {
        '"1550 mm"': '"1550"',
        'peak_pressure = { value = "8 MPa"': 'peak_pressure = { value = "8"',
        'height = { value = "400 mm"': 'height = { value = "400"',
    }
    found = told(load_hinge, text, changes)
    assert found[0] == "rod.length"
    assert "comparison.sizes[1].height" in found
    assert any(one.startswith("operation.points[") for one in found)


@pytest.mark.parametrize("command", ["mechanism", "vibration", "throw", "run"])
def test_a_hinge_is_no_engine(tmp_path, monkeypatch, call, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hinge.toml").write_text('[sliding]\n[hinge]\nheight = "1 m"\n', encoding="utf-8")
    answer = call(command, "hinge.toml")
    assert answer.code == 2
    assert answer.err.endswith("describes an elastic hinge; use it with hinge.\n")


def test_an_engine_is_no_hinge(call, tmp_path, six_cylinders):
    (tmp_path / "mine.toml").write_text(six_cylinders, encoding="utf-8")
    answer = call("hinge", "mine.toml")
    assert answer.err.startswith("Error: mine.toml: describes an engine or a throw, not an")
    answer = call("hinge", "vw-tdi")
    assert answer.code == 2
    assert "vw-tdi: is an engine, not a hinge file; give the path of a hinge" in answer.err


@pytest.mark.further
def test_a_hinge():
    run = run_hinge(load_hinge(data_folder() / "hinges/crosshead-30-100.toml"))
    axes = run.plot()
    assert axes.lines[0].get_ydata() == close(1e-3 * run.moment.moment)
    assert "[kN m]" in axes.get_ylabel()
    for show in ("gas force", "speed", "guides"):
        assert run.plot(show=show).has_data(), show
    assert run.to_pandas()["flywheel"].tolist() == [one.flywheel for one in run.others]
    with pytest.raises(InputError, match="show: given 'sound'; allowed are moment, gas force, "):
        run.plot(show="sound")
