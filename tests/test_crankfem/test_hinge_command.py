"""Hinge files, and the command that calculates them."""

import csv
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.hinge.hinge_run import run_hinge
from crankfem.files.hinge_file import load_hinge
from crankfem.files.reading.data_files import input_path
from dynamics.hinge.profile import GasSpring

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


def test_the_shipped_file():
    found = load_hinge(SHIPPED)
    assert found.engine.crank_ratio == close(0.5 / 1.55, rel=1e-15)
    assert found.engine.sliding_mass == 460.0
    assert found.spring == GasSpring(0.031, 1.0, 5e6, 1.25, 0.0)
    np.testing.assert_allclose(np.array(found.speeds) * 30.0 / np.pi, [89.0, 129.0, 142.0])
    # Every value says where it comes from.
    silent = [record.field for record in found.records if record.source == found.path.name]
    assert silent == ["engine.name"]
    assert {"zotov2024"} == set(found.sources)


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
    assert load_hinge(path).compared(load_hinge(path).moment()) == []
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_guides_by_the_series_turn_in_the_exact_mechanism():
    """The crank let turn is exact whatever the guides were made by: 0.038, as documented."""
    run = run_hinge(load_hinge(SHIPPED), "series", 142.0 * np.pi / 30.0)
    assert (run.moment.kinematics, run.point.kinematics) == ("series", "exact")
    assert run.with_hinge.fluctuation == close(0.038, abs=0.0005)


@pytest.mark.slow
def test_flywheels_at_another_speed():
    """With the best pressure, not that of the design; both documented to the last digit given."""
    run = run_hinge(load_hinge(SHIPPED), speed=142.0 * np.pi / 30.0)
    (other,) = run.others
    assert other.flywheel_with_hinge == close(2277.0, abs=0.5)
    assert other.flywheel == close(33514.0, abs=0.5)


@pytest.mark.slow
def test_tables_and_options(call, changed):
    answer = call("hinge", SHIPPED, "--speed", "142 1/min", "--kinematics", "printed")
    assert answer.code == 0, answer.err
    assert "(printed" in answer.out
    assert "At 142 1/min with the pressure unchanged" in answer.out
    assert "At 129 1/min" not in answer.out
    # Root mean square, and the largest beside it; which is which is told.
    assert re.search(r"│ +\d+\.?\d*, at most \d+\.?\d* +│", answer.out)
    assert "first by root mean squares, then by largest values" in answer.out
    weak = call(
        "hinge", changed({"comparison.pressures": '["0.2 MPa"]', "hinge.pressure": '"3 MPa"'})
    )
    assert weak.code == 0, weak.err
    assert "not feasible" in weak.out
    assert "the compression z must stay below the height H" in weak.out
    none = call("hinge", changed({"hinge.pressure": '"0.2 MPa"'}))
    assert none.code == 2
    assert "pressure: given 0.2 MPa" in none.err
