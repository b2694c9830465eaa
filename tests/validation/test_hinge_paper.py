"""The elastic hinge of a two-stroke crosshead engine.

Source: A. N. Zotov, E. Sh. Imaeva, Transport i khranenie nefteproduktov 2024 no. 1-2, pp. 50-55, doi
10.24412/0131-4270-2024-1-2-50-55: equations (1) to (14), figures 3 and 4, 9.75 MPa for 142 1/min.

Tolerance: 1e-9 where the paper's statement is exact; figures of three digits are records of this program.

That is 1.95 times the 5 MPa at which the guides are made for 89 1/min. Gas forces, moments and guides are
only drawn; those here come from a cycle model with assumed pressures (data/hinges/crosshead-30-100.toml).
Tested are the corrected equations and these statements:

- the hinge moment has the integral zero over a revolution;
- a hinge made for a speed makes it constant;
- the larger H and p_0, the closer the guides are to a circle;
- the moment is proportional to the start pressure;
- other start pressures adapt the guides to other speeds "practically": not with the forces here.
"""

import numpy as np
import pytest

from comparing import close
from crankfem.satellites.hinge.file import load_hinge
from crankfem.satellites.hinge.moment import hinge_moment
from crankfem.satellites.hinge.turning import (
    best_pressure,
    flywheel_for,
    simulate_hinge,
    steady_hinge_turn,
)


@pytest.fixture(scope="module")
def file():
    return load_hinge("crosshead-30-100")


@pytest.fixture(scope="module")
def point(file):
    return file.moment()


@pytest.fixture(scope="module")
def profile(file, point):
    return file.profile(point)


@pytest.mark.slow
@pytest.mark.parametrize(("rpm", "kinematics"), [(89, "exact"), (129, "series"), (142, "printed")])
def test_the_moment_is_potential(file, rpm, kinematics, figure):
    found = file.moment(rpm * np.pi / 30.0, kinematics)
    closing = found.closing_error
    figure("integral of the hinge moment over a revolution", closing, 0.0, 1e-9, "", "absolute")
    # (5), by its own sum.
    gas = found.gas_force(np.radians(found.angles_deg)) * found.reduced.travel_rate
    figure("load of constant torque by (5)", found.load, np.mean(gas), 1e-12, "N m")


@pytest.mark.slow
def test_the_hinge_at_its_design_speed(point, profile, figure):
    """Bound: 0.1 % of the fluctuation without the hinge. Found: less than a millionth of it."""
    with_hinge = simulate_hinge(point, profile, samples=720)
    without = simulate_hinge(point, start_speed=point.speed, samples=720)
    assert without.fluctuation == close(1.68, abs=0.02)
    assert with_hinge.fluctuation < 1e-3 * without.fluctuation
    # Splines between 1440 radii, and a pressure curve whose second derivative jumps.
    left = with_hinge.fluctuation
    figure("fluctuation of speed with the hinge", left, 0.0, 1e-5, "", "absolute")
    # The same from the energy alone, which decides: 1.42e-6.
    found = steady_hinge_turn(point, profile)
    assert found.fluctuation == close(1.42e-6, abs=0.005e-6)
    figure("mean speed with the hinge", found.mean_speed, point.speed, 1e-12, "rad/s")


@pytest.mark.slow
def test_the_series_costs_what_it_leaves_out(file, point, profile):
    """Guides made by the series, in the exact mechanism; the printed sign of the rod costs more."""
    left = {
        name: steady_hinge_turn(point, file.profile(file.moment(kinematics=name))).fluctuation
        for name in ("series", "printed")
    }
    assert left["series"] == close(0.038, abs=0.002)
    assert left["printed"] == close(0.099, abs=0.003)
    assert steady_hinge_turn(point, profile).fluctuation < 1e-5


def test_large_springs_make_round_guides(file, point):
    """Figure 4: H = 1 m is rounder than 0.4 m, and of each the higher pressure."""
    ratio = {
        (made.height, made.pressure): made.guides.smallest_radius / made.guides.largest_radius
        for made in file.compared(point)
    }
    for height in (1.0, 0.4):
        assert ratio[height, 3e6] < ratio[height, 5e6] < ratio[height, 8e6]
    for pressure in (3e6, 5e6, 8e6):
        assert ratio[0.4, pressure] < ratio[1.0, pressure]


def test_all_guides_of_figure_4_can_be_made(file, point):
    for made in (compared.guides for compared in file.compared(point)):
        assert all(check.met for check in made.checks)
        assert made.radius[0] == close(made.start_radius, abs=1e-12)
        # The gas force makes the spring shorter over all of the turn but a few degrees at the top.
        assert np.mean(made.compression > 0.0) > 0.97


@pytest.mark.slow
def test_pressure_for_another_speed(file, profile):
    """The paper: 1.95 times the pressure suits 142 1/min, "almost constant" speed. Ours: 2.45 times.

    The ratio follows the gas force, of which the paper tells nothing: our mean pressure at 142 1/min
    is 2.5 times that at 89 1/min. What no pressure can give, 13 % of the moment, makes the speed of
    so light an engine fluctuate by 86 %, for the curves of the combustion are not proportional.
    """
    fast = file.moment(142.0 * np.pi / 30.0)
    best = best_pressure(fast, profile)
    assert best.ratio == close(2.45, abs=0.02)
    assert best.fitted_ratio == close(2.38, abs=0.02)
    assert best.moment_residual == close(0.132, abs=0.005)
    assert best.fluctuation == close(0.86, abs=0.02)
    assert best.unchanged is None
    # Proportional in the pressure, (14).
    scaled = profile.moment_at(1.95 * 5e6, angles_deg=fast.angles_deg)
    np.testing.assert_allclose(
        scaled, 1.95 * profile.moment_at(angles_deg=fast.angles_deg), rtol=1e-12
    )
    # Still the hinge saves most of a flywheel.
    with_hinge = flywheel_for(fast, 0.02, profile.with_pressure(best.pressure))
    assert with_hinge < 0.1 * flywheel_for(fast, 0.02)


@pytest.mark.slow
def test_proportional_forces(file, point, profile, figure):
    """With the force of 89 1/min times 1.95 at 142 1/min, 1.95 times the pressure, 9.75 MPa, is best.

    The swing of the energy is between the dead centers, where the reduced inertia is almost equal, so
    that the inertia's own part in the moment counts little. The speed is still not "almost constant":
    the inertia's part has grown with the square of the speed, 2.55 times. Were the force to grow so
    too, the weights alone, which do not grow, would be left.
    """
    fast = 142.0 * np.pi / 30.0
    found = {}
    for times in (1.95, (142.0 / 89.0) ** 2):
        scaled = hinge_moment(
            file.engine, lambda angles, times=times: times * point.gas_force(angles), fast
        )
        found[times] = best_pressure(scaled, profile)
        what = f"best pressure ratio for {times:.2f} times the force"
        figure(what, found[times].ratio, times, 0.005, "", "absolute")
    mild, square = found.values()
    assert mild.fluctuation == close(0.20, abs=0.01)
    assert mild.moment_residual == close(0.059, abs=0.002)
    assert square.fluctuation == close(0.058, abs=0.003)
    assert square.moment_residual < 0.01
