"""The elastic hinge with a given gas force, and the surface of its rollers.

Source: Zotov and Imaeva 2024, doi 10.24412/0131-4270-2024-1-2-50-55: equations (5), (8), figure 4 (path of
the rollers' centers); slider-crank by hand, distances by search.

Tolerance: 1e-6 of the force, a spline through a table every 2 deg; surface 1e-9 m.

The equations hold for any gas force; the paper leaves the path's parallel curve to the maker.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from comparing import close
from crankbase.errors import InputError
from crankfem.files.reading.data_files import input_path
from crankfem.satellites.hinge.file import load_hinge
from crankfem.satellites.hinge.moment import hinge_moment
from crankfem.satellites.hinge.run import hinge_columns, run_hinge

pytestmark = pytest.mark.slow

RADIUS, ROD = 0.5, 1.55  # crank and rod of figure 3 [m]
SPEED = 89.0 * np.pi / 30.0


def law(angle):
    """A gas force [N] that rises as one of a cylinder does."""
    return 4e4 + 5e5 * np.exp(3.0 * (np.cos(angle - 0.2) - 1.0))


def travel_rate(angle):
    """dx/dphi of the piston towards the shaft [m/rad], from the slider-crank by hand."""
    ratio = RADIUS / ROD * np.sin(angle)
    return RADIUS * (np.sin(angle) + np.cos(angle) * ratio / np.sqrt(1.0 - ratio**2))


@pytest.fixture
def given(tmp_path):
    """A hinge file of one running point with a table of the law, without [cycle]."""

    def written(step=2.0, unit="N", start=0.0, point='gas_force_table = "force.csv"'):
        angles = start + np.arange(0.0, 360.0 + step, step)
        size = {"N": 1.0, "kN": 1e3}[unit]
        rows = [f"{one:.6g},{float(law(np.radians(one))) / size!r}\n" for one in angles.tolist()]
        (tmp_path / "force.csv").write_text(
            f"# made here\ncrank_angle_deg,gas_force_{unit}\n" + "".join(rows), encoding="utf-8"
        )
        text = input_path("crosshead-30-100", "hinge").read_text(encoding="utf-8")
        before, _, rest = text.partition("\n[cycle]\n")
        operation = "\n[operation]\n" + rest.partition("\n[operation]\n")[2]
        head, _, points = operation.partition("[[operation.points]]\n")
        after = points[points.index("[comparison]") :]
        own = f'[[operation.points]]\nspeed = "89 1/min"\n{point}\n\n'
        path = tmp_path / "mine.toml"
        path.write_text(before + head + own + after, encoding="utf-8")
        return path

    return written


@pytest.mark.parametrize(("step", "unit", "start"), [(2.0, "N", 0.0), (1.0, "kN", -180.0)])
def test_a_table_gives_the_moments_of_its_law(given, figure, step, unit, start):
    file = load_hinge(given(step, unit, start))
    assert file.cycle is None
    assert [path.name for path in file.tables] == ["force.csv"]
    found = file.moment()
    work = quad(lambda angle: law(angle) * travel_rate(angle), 0.0, 2.0 * np.pi, epsrel=1e-12)[0]
    figure("load of constant torque", found.load, work / (2.0 * np.pi), 1e-6, "N m")
    angles = np.radians(found.angles_deg)
    torque = law(angles) * travel_rate(angles)
    largest = np.abs(torque).max()
    figure("torque of the gas", found.gas_moment, torque, 1e-6, "N m", scale=largest)
    exact = hinge_moment(file.engine, law, SPEED)
    figure("hinge moment", found.moment, exact.moment, 1e-6, "N m", scale=largest)


def test_the_gas_force_is_given_once_and_whole(given, tmp_path):
    three = 'mean_pressure = "1 MPa"\npeak_pressure = "9 MPa"\ncharge_pressure = "0.2 MPa"'
    for point, said in (
        (
            'gas_force_table = "no.csv"',
            "gas_force_table: given 'no.csv', which is neither in the folder of mine.toml",
        ),
        (
            'gas_force_table = "force.csv"\nmean_pressure = "1 MPa"',
            "mean_pressure: given together with gas_force",
        ),
        (
            'mean_pressure = "1 MPa"',
            "peak_pressure: missing; allowed are mean_pressure, peak_pressure",
        ),
        (three, r"the section \[cycle\] is missing"),
    ):
        with pytest.raises(InputError, match=said):
            load_hinge(given(point=point))
    path = given()
    table = tmp_path / "force.csv"
    text = table.read_text(encoding="utf-8")
    for wrong, said in (
        (text.replace("gas_force_N", "gas_force_lb"), 'allowed is "crank_angle_deg,gas_force_N"'),
        ("\n".join(text.splitlines()[:100]), "allowed is one cycle of 360 deg"),
        (text.replace("\n180,", "\n# 180,").replace("\n182,", "\n# 182,"), ""),
        (
            "\n".join(row for row in text.splitlines() if row[:2] not in ("10", "11")),
            "gaps of 10 deg",
        ),
    ):
        table.write_text(wrong, encoding="utf-8")
        if said:
            with pytest.raises(InputError, match=said):
                load_hinge(path)
        else:
            load_hinge(path)


@pytest.fixture(scope="module")
def rolled():
    """The paper's hinge with rollers of 60 mm, calculated at its design speed alone."""
    return run_hinge(replace(load_hinge(), roller_radius=0.060, comparison=None), speed=SPEED)


@pytest.mark.further
def test_the_surface_lies_at_the_rollers_radius_from_their_path(rolled, figure):
    columns = hinge_columns(rolled)
    surface = columns["guide_x_m"] + 1j * columns["guide_y_m"]
    curve = rolled.profile.curve

    def center(angle):
        return curve(angle) * np.exp(1j * angle)

    distances, slopes = [], []
    for place in range(0, surface.size, 36):
        point, angle = surface[place], np.radians(rolled.profile.angles_deg[place])
        # The nearest center of all: by search over the whole turn, then closely.
        turn = np.linspace(0.0, 2.0 * np.pi, 721)
        near = turn[np.argmin(np.abs(point - center(turn)))]
        closest = minimize_scalar(
            lambda one, point=point: abs(point - center(one)) ** 2,
            bounds=(near - 0.02, near + 0.02),
            method="bounded",
            options={"xatol": 1e-12},
        )
        assert np.exp(1j * closest.x) == close(np.exp(1j * angle), abs=1e-4)
        distances.append(np.sqrt(closest.fun))
        # The tangent of the surface, by differences, is that of the path.
        before, after = surface[place - 1], surface[(place + 1) % surface.size]
        path = center(angle + 1e-5) - center(angle - 1e-5)
        slopes.append(np.angle((after - before) / path))
    figure("distance from the path", distances, 0.060, 1e-9, "m", "absolute")
    figure("angle between surface and path", slopes, 0.0, 1e-4, "rad", "absolute")
    assert rolled.rolled.roller_radius == 0.060
    assert rolled.rolled.surface.largest_radius == close(np.abs(surface).max())
    assert np.all(np.abs(surface) > columns["radius_m"])


@pytest.mark.further
def test_without_a_radius_the_path_is_the_surface():
    run = run_hinge(replace(load_hinge(), comparison=None), speed=SPEED)
    assert run.surface is None
    assert "guide_x_m" not in hinge_columns(run)
    assert run.to_record()["profile"]["surface"] is None


@pytest.mark.further
def test_what_the_moment_lacks_is_told_as_mean_and_as_largest(figure):
    """By sums over the turn of the two moments, written down once more."""
    run = run_hinge(replace(load_hinge(), comparison=None), speed=142.0 * np.pi / 30.0)
    (other,) = run.others
    wanted = other.point.moment
    lacking = wanted - run.profile.with_pressure(other.best.pressure).moment
    mean = np.sqrt(np.sum(lacking**2) / np.sum(wanted**2))
    figure("missing moment, root mean square", other.best.moment_residual, mean, 1e-9)
    largest = np.abs(lacking).max() / np.abs(wanted).max()
    figure("missing moment, largest", other.best.largest_residual, largest, 1e-9)
    assert largest > 1.5 * mean
