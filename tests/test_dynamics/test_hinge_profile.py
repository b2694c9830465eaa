"""Gas spring and guides of an elastic hinge.

Tolerances: 1e-12 for the same algebra two ways; others have their reason beside them.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from comparing import close
from crankbase.errors import InputError
from dynamics.engine.rods import ConnectingRod
from dynamics.hinge.crosshead import CrossheadEngine, reduced_crank
from dynamics.hinge.moment import hinge_moment
from dynamics.hinge.profile import (
    GasSpring,
    check_roller,
    hinge_profile,
    outer_parallel,
    polar_curvature,
    smallest_hollow,
)

ENGINE = CrossheadEngine(
    0.3, 0.5, 80.0, 0.2, 30.0, ConnectingRod(1.55, 150.0, 0.8, 50.0), 150.0, 200.0, 110.0
)
SPRING = GasSpring(0.031, 1.0, 5e6)


def smooth_force(angles):
    return 5e5 * np.exp(4.0 * (np.cos(angles - 0.3) - 1.0))


@pytest.fixture(scope="module")
def moment():
    return hinge_moment(ENGINE, smooth_force, 9.32)


@pytest.fixture(scope="module")
def profile(moment):
    return hinge_profile(moment, SPRING, 0.8)


@pytest.mark.parametrize("ambient", [0.0, 101325.0])
@pytest.mark.parametrize("exponent", [1.0, 1.0 + 1e-9, 1.25, 1.4])
def test_spring_work_force_and_back(exponent, ambient):
    spring = GasSpring(0.031, 1.0, 5e6, exponent, ambient)
    shorter = np.linspace(-0.4, 0.9, 27)
    work = spring.work(shorter)
    # Fourth-order differences with a step of 1e-4 of the height: 1e-11 of the force and less.
    step = 1e-4
    near = spring.work(shorter + step) - spring.work(shorter - step)
    far = spring.work(shorter + 2 * step) - spring.work(shorter - 2 * step)
    slope = (8.0 * near - far) / (12.0 * step)
    np.testing.assert_allclose(slope, spring.force(shorter), rtol=1e-8)
    np.testing.assert_allclose(spring.compression(work), shorter, atol=1e-12)
    assert float(spring.force(0.0)) == close(0.031 * 5e6, rel=1e-14)


def test_spring_without_atmosphere_is_the_printed_law():
    shorter, n = 0.3, 1.25
    printed = 1.0**n * 0.031 * 5e6 / (1.0 - shorter) ** n
    assert float(SPRING.force(shorter)) == close(printed, rel=1e-14)
    energy = 0.031 * 5e6 * ((1.0 - shorter) ** (1.0 - n) - 1.0) / (n - 1.0)
    assert float(SPRING.work(shorter)) == close(energy, rel=1e-13)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"height": 0.0}, "height: given 0 m"),
        ({"pressure": -1.0}, "pressure: given -1 Pa"),
        ({"exponent": 0.9}, "exponent: given 0.9"),
        ({"ambient": -1.0}, "ambient: given -1 Pa"),
    ],
)
def test_springs_refused(change, match):
    with pytest.raises(InputError, match=match):
        replace(SPRING, **change)


@pytest.mark.parametrize("ambient", [0.0, 101325.0])
@pytest.mark.parametrize("name", ["force", "gas_pressure", "work"])
@pytest.mark.parametrize(
    ("compression", "message"),
    [
        (1.0, "compression: given 1 m of a gas column 1 m high; allowed is less than its height"),
        ([0.1, 1.5], "compression: given 1.5 m of a gas column 1 m high"),
        ([0.1, np.nan], r"compression\[1\]: given nan"),
        (-np.inf, "compression: given -inf"),
    ],
)
def test_compression_beyond_the_column_is_refused(ambient, name, compression, message):
    with pytest.raises(InputError, match=message):
        getattr(replace(SPRING, ambient=ambient), name)(compression)


def test_largest_work_leaves_the_least_column():
    """100 to the power of n - 1, by hand: (100^0.25 - 1) / 0.25 of A p_0 H."""
    most = 0.031 * 5e6 * (100.0**0.25 - 1.0) / 0.25
    assert float(SPRING.compression(most * (1.0 - 1e-9))) == close(0.99, abs=1e-9)
    for work in (most * (1.0 + 1e-9), 1e50):
        with pytest.raises(
            InputError, match=r"at most 1341 kJ until 0\.01 m of the column are left"
        ):
            SPRING.compression(work)
    with pytest.raises(InputError, match="the compression z must stay below the height H"):
        replace(SPRING, ambient=101325.0).compression(1e50)


@pytest.mark.parametrize("ambient", [0.0, 101325.0])
def test_energy_beyond_the_gas_is_refused(ambient):
    weak = replace(SPRING, pressure=1e5, ambient=ambient)
    with pytest.raises(InputError, match=r"spring that must give 100 kJ; allowed .* here at most"):
        weak.compression([-1e5])
    with pytest.raises(InputError, match="the compression z must stay below the height H"):
        weak.compression([1e6])


def test_profile_gives_the_moment_by_its_energy(moment, profile):
    """M_h is minus the derivative of the spring's energy along the guides."""
    energy = profile.spring.work(profile.compression)
    spectrum = np.fft.rfft(energy)
    slope = np.fft.irfft(1j * np.arange(spectrum.size) * spectrum, energy.size)
    largest = np.abs(moment.moment).max()
    np.testing.assert_allclose(-slope, moment.moment, atol=1e-9 * largest)
    # Slopes of the cubic spline at its knots are off by h^4 / 180 of the fifth derivative.
    np.testing.assert_allclose(profile.moment, moment.moment, atol=1e-7 * largest)


@pytest.mark.parametrize("angle", [0.4, 2.0, 5.0])
def test_profile_is_the_printed_equation(moment, profile, angle):
    """(11) with the integral of M_h by adaptive quadrature."""

    def wanted(at):
        reduced = reduced_crank(ENGINE, angles_deg=np.degrees(np.array([at])))
        gas = smooth_force(at) * reduced.travel_rate
        inertia = 0.5 * moment.speed**2 * reduced.inertia_rate
        return float((inertia - gas - reduced.weight_moment + moment.load)[0])

    integral = quad(wanted, 0.0, angle, epsabs=1e-6)[0]
    n, height = SPRING.exponent, SPRING.height
    bracket = height ** (1 - n) - (n - 1) * integral / (
        SPRING.piston_area * SPRING.pressure * height**n
    )
    expected = 0.8 - 0.5 * height + 0.5 * bracket ** (1.0 / (1.0 - n))
    assert float(profile.curve(angle)) == close(expected, abs=1e-9)


def test_profile_is_closed_and_starts_at_its_radius(profile):
    assert profile.radius[0] == close(0.8, abs=1e-14)
    assert float(profile.curve(2.0 * np.pi)) == close(0.8, abs=1e-14)


def test_pressure_scales_the_moment(profile):
    """(14): with the same guides the moment is proportional to the start pressure."""
    angles = np.linspace(0.0, 6.0, 37)
    plain = profile.moment_at(angles_deg=np.degrees(angles))
    np.testing.assert_allclose(
        profile.moment_at(1.95 * 5e6, angles_deg=np.degrees(angles)), 1.95 * plain, rtol=1e-13
    )
    np.testing.assert_allclose(
        profile.with_pressure(2.5e6).moment, 0.5 * profile.moment, rtol=1e-13
    )


def test_with_atmosphere_the_scaling_is_not_exact(moment):
    exact = hinge_profile(moment, replace(SPRING, ambient=101325.0), 0.8)
    twice = exact.with_pressure(1e7).moment
    off = np.abs(twice - 2.0 * exact.moment).max() / np.abs(twice).max()
    # The atmosphere is 2 % of the pressure; it counts with (H/(H-z))^n - 1, here 0.2 to 0.6.
    assert 1e-3 < off < 0.02


def test_rollers_balance_spring_and_moment(profile):
    along = profile.normal_force * np.cos(np.radians(profile.force_angle_deg))
    np.testing.assert_allclose(along, profile.spring_force, rtol=1e-13)
    aside = profile.normal_force * np.sin(np.radians(profile.force_angle_deg))
    np.testing.assert_allclose(2.0 * aside * profile.radius, profile.moment, atol=1e-9 * 8e4)


def test_curvature_of_known_curves():
    angles = np.linspace(0.3, 6.0, 50)
    # A circle of radius a about a point e aside of the origin.
    a, e = 0.7, 0.25
    root = np.sqrt(a**2 - (e * np.sin(angles)) ** 2)
    radius = e * np.cos(angles) + root
    root_1 = -(e**2) * np.sin(angles) * np.cos(angles) / root
    root_2 = -(e**2 * np.cos(2.0 * angles) + root_1**2) / root
    first, second = -e * np.sin(angles) + root_1, -e * np.cos(angles) + root_2
    np.testing.assert_allclose(polar_curvature(radius, first, second), 1.0 / a, rtol=1e-13)
    # Its parallel is the larger circle about the same point.
    points = outer_parallel(angles, radius, first, 0.1)
    np.testing.assert_allclose(np.abs(points - e), a + 0.1, rtol=1e-13)
    # The spiral of Archimedes, rho = b phi.
    b = 0.2
    spiral = polar_curvature(b * angles, np.full(50, b), np.zeros(50))
    np.testing.assert_allclose(spiral, (angles**2 + 2) / (b * (angles**2 + 1) ** 1.5), rtol=1e-13)


def test_curvature_of_the_guides(profile):
    """Against the turning of the tangent between points of the curve."""
    step = 1e-3
    angles = np.radians(profile.angles_deg)[::97]

    def place(at):
        return profile.curve(at) * np.exp(1j * at)

    middle, left, right = place(angles), place(angles - step), place(angles + step)
    turned = np.angle((right - middle) / (middle - left))
    length = 0.5 * (np.abs(right - middle) + np.abs(middle - left))
    # Second order in the step; the spline's second derivative bends within it.
    largest = np.abs(profile.curvature).max()
    np.testing.assert_allclose(profile.curvature[::97], turned / length, atol=1e-4 * largest)


def test_a_roller_larger_than_the_hollow_has_a_cusp():
    angles = np.linspace(0.0, 2.0 * np.pi, 721)
    radius = 1.0 + 0.3 * np.cos(2.0 * angles)
    first, second = -0.6 * np.sin(2.0 * angles), -1.2 * np.cos(2.0 * angles)
    curvature = polar_curvature(radius, first, second)
    hollow = smallest_hollow(curvature)
    # At 90 deg: rho = 0.7, rho'' = 1.2, curvature (0.49 - 0.84) / 0.7^3.
    assert hollow == close(0.98, rel=1e-12)

    def runs_back(distance):
        points = outer_parallel(angles, radius, first, distance)
        tangent = np.diff(radius * np.exp(1j * angles))
        return bool(np.any((np.diff(points) * np.conj(tangent)).real < 0.0))

    assert not runs_back(0.98 * hollow)
    assert runs_back(1.02 * hollow)
    check_roller(0.98 * hollow, curvature)
    with pytest.raises(InputError, match=r"roller_radius: given 1 m; allowed is less than 0\.98 m"):
        check_roller(1.0, curvature)


def test_checks_of_guides(moment, profile):
    assert all(check.met for check in profile.checks)
    radius, *_, hollow = (check.sentence for check in profile.checks)
    assert radius.startswith("Smallest radius: 5")
    assert radius.endswith(
        " mm, met; it must be above the roller's radius, or the two rollers would meet."
    )
    assert hollow.startswith("Smallest hollow: none, met; it must be above the roller's radius")
    small = hinge_profile(moment, GasSpring(0.031, 0.4, 3e6), 0.3, roller_radius=0.2)
    met = {check.name: check.met for check in small.checks}
    assert met["lowest spring pressure"]
    assert met["shortest gas column"]
    assert not met["smallest radius"]
    # Guides that someone else has made: z of 0.985 m of 1 m leaves 15 mm, 0.995 m leaves 5 mm.
    radius = profile.radius.copy()
    for compression, enough in ((0.985, True), (0.995, False)):
        radius[0] = 0.8 - 0.5 * compression
        (check,) = (
            one
            for one in replace(profile, radius=radius.copy()).checks
            if one.name == "shortest gas column"
        )
        assert (check.met, check.limit) == (enough, 0.01)
        assert check.value == close(1.0 - compression, rel=1e-12)
    remarks = " ".join(small.remarks)
    assert "is up to" in remarks
    assert "guide of its own" in remarks


def test_guides_that_cannot_be(moment):
    with pytest.raises(InputError, match=r"height: given 1\.6 m with a start radius of 0\.8 m"):
        hinge_profile(moment, replace(SPRING, height=1.6), 0.8)
    with pytest.raises(InputError, match="the compression z must stay below the height H"):
        hinge_profile(moment, replace(SPRING, pressure=1e5), 0.8)
    with pytest.raises(InputError, match=r"roller_radius: given -0\.1 m"):
        hinge_profile(moment, SPRING, 0.8, roller_radius=-0.1)


def test_guide_surface_lies_outside_by_the_roller(moment):
    rolled = hinge_profile(moment, SPRING, 0.8, roller_radius=0.05)
    centers = rolled.radius * np.exp(1j * np.radians(rolled.angles_deg))
    np.testing.assert_allclose(np.abs(rolled.guide() - centers), 0.05, rtol=1e-12)
    assert np.all(np.abs(rolled.guide()) > rolled.radius)
