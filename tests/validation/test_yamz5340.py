"""Torque harmonics and two-mass resonance of the YaMZ-5340 diesel.

Source: Yu. P. Makushev, T. A. Polyakova, Omsk Scientific Bulletin 2024 no. 3, pp. 39-47, doi
10.25206/1813-8225-2024-191-39-47: table 2, sections 2.1, 2.2 and 3, figures 2 and 3.

Tolerance: half of the last printed digit; where exact arithmetic on the paper's input differs from the
print, the exact figure counts.
"""

from pathlib import Path

import numpy as np
import pytest

from comparing import close
from dynamics.critical import critical_speeds, engine_orders, two_mass_check
from dynamics.harmonics import read_torque_table
from references import finite_sums

TABLE = Path(__file__).parents[2] / "data" / "tables" / "yamz5340_torque_one_throw.csv"


@pytest.fixture(scope="module")
def table():
    return read_torque_table(TABLE)


@pytest.fixture(scope="module")
def check(table):
    return two_mass_check(
        diameter=0.07,
        length=0.2,
        shear_modulus=8e10,
        inertia_1=0.78,
        inertia_2=0.1,
        order=14,
        harmonics=table.harmonics(),
    )


def test_table_keeps_its_source_and_loses_its_closing_sample(table):
    assert "table 2" in table.source
    assert table.strokes == 4
    assert table.torque.size == 36
    assert table.crank_angle_deg.tolist() == list(range(0, 720, 20))
    assert table.torque.sum() == 4441.0


@pytest.mark.parametrize("route", ["transform", "sums"])
def test_first_two_harmonics(table, route, figure):
    found = table.harmonics()
    mean, cosine, sine = found.mean, found.cosine, found.sine
    if route == "sums":
        mean, cosine, sine = finite_sums(table.torque)
    figure("mean torque", mean, 123.36, 0.005, "N m", "absolute")
    assert found.orders[:2].tolist() == [0.5, 1.0]
    assert cosine[:2] == close([-214.76, 138.05], abs=0.005)
    assert sine[:2] == close([-179.16, 371.63], abs=0.005)
    # M_2 stands as 396.64 at its calculation and as 396.44 in the final equation, which is right.
    amplitudes = np.hypot(cosine, sine)[:2]
    figure("first two harmonics", amplitudes, [279.68, 396.44], 0.005, "N m", "absolute")
    # Printed 20.37 deg, from a tangent rounded to 0.37.
    phases = np.degrees(found.phase[:2])
    figure("their phases", phases, [230.16, 20.38], 0.005, "deg", "absolute")


def test_curves_of_figures_2_and_3(table, figure):
    pytest.importorskip("matplotlib")
    axes = table.harmonics().plot(show="curves", highest_order=1.0, unit="N m")
    # The printed equations, x by the cycle; 20.37 deg is printed for 20.38.
    x = np.radians(np.linspace(0.0, 360.0, 721))
    first, second = (
        279.68 * np.sin(x + np.radians(230.16)),
        396.44 * np.sin(2 * x + np.radians(20.37)),
    )
    curves = [line.get_ydata() for line in axes.lines]
    figure("curve of figure 3a", curves[0], first, 0.03, "N m", "absolute")
    figure("curve of figure 3b", curves[1], second, 0.1, "N m", "absolute")


def test_two_mass_resonance(check, figure):
    # Printed 942,000; 3,260 and 31,146, from a pi of 3.14 and from rounded figures.
    figure("stiffness of the shaft", check.stiffness, 942.9e3, 0.05e3, "N m/rad", "absolute")
    natural = check.angular_frequency
    figure("natural frequency of two masses", natural, 3261.5, 0.05, "rad/s", "absolute")
    assert check.vibrations_per_minute == close(31145.0, abs=0.5)
    speed = check.resonant_speed_rpm
    figure("resonant speed of order 14", speed, 2224.7, 0.05, "1/min", "absolute")
    # Printed 232.8 rad/s, from a pi of 3.14.
    assert check.resonant_speed == close(232.97, abs=0.005)


def test_order_14_meets_the_mode_below_the_rated_speed(check):
    low, high = 600.0 * np.pi / 30.0, 2300.0 * np.pi / 30.0
    found = critical_speeds([check.frequency], engine_orders(4, 14.0), (low, high))
    # 31,145 / 13.5 is 2307 1/min, just above the rated speed: 14 is the lowest order below it.
    assert [item.order for item in found] == [14.0]
    assert found[0].speed_rpm == close(2224.7, abs=0.05)


def test_table_cannot_excite_the_resonant_order(table, check):
    assert table.harmonics().highest_order == 9.0
    assert check.resolved is False
    assert check.statement == (
        "36 samples over two revolutions resolve orders up to 9: this table cannot excite order 14."
    )
