"""The cycle model of the gas pressure.

Source: ideal cycles (J. B. Heywood, Internal Combustion Engine Fundamentals): p V^g = const, Otto's work
ratio 1 - r^(1 - g), rise of pressure (g - 1) Q / V; Wiebe's law.

Tolerance: round-off where the model is the closed form; shortfall of a short combustion to a hundredth.

Volume of a slider-crank: V = V_c + A (R + L - R cos a - sqrt(L^2 - R^2 sin^2 a)). The shortfall against
combustion at constant volume is V / V_c - 1.
"""

from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from dynamics.gas.gas_cycle import gas_cycle, pressure_rise_per_heat, usual_gas_cycle
from dynamics.gas.pressure import cylinder_volume
from references import closed_pressure

R, L, AREA = 0.07, 0.25, 0.0133


def position(angle):
    return R * np.cos(angle) + np.sqrt(L**2 - (R * np.sin(angle)) ** 2)


def volume_law(angle, ratio):
    way = R + L - R * np.cos(angle) - np.sqrt(L**2 - (R * np.sin(angle)) ** 2)
    return AREA * (2.0 * R / (ratio - 1.0) + way)


def closed_work(cycle, law, heat):
    """Work of the closed part by its balance: heat less the rise of the internal energy."""
    ends = [cycle.intake_closes_deg, cycle.exhaust_opens_deg]
    products = closed_pressure(cycle, law, heat, ends) * law.at(angle_deg=ends)
    return heat - float(products[1] - products[0]) / (cycle.heat_capacity_ratio - 1.0)


@pytest.mark.parametrize(("ratio", "gamma"), [(8.0, 1.4), (14.0, 1.35), (22.0, 1.3)])
def test_isentropic_compression_from_the_bottom(ratio, gamma, figure):
    cycle = usual_gas_cycle(ratio, intake_closes_deg=-180.0, heat_capacity_ratio=gamma)
    found = gas_cycle(cycle, position, AREA, heat=0.0)
    expected = 2.5e5 * ratio**gamma
    figure("isentropic compression pressure", found.compression_pressure, expected, 1e-12, "Pa")
    assert found.pressure.peak_pressure == close(expected, rel=1e-12)
    angles = np.radians([-120.0, -60.0, -30.0, 10.0, 100.0])
    law = 2.5e5 * (volume_law(np.pi, ratio) / volume_law(angles, ratio)) ** gamma
    # Between its samples the pressure is a cubic; these angles are samples.
    figure(
        "isentropic pressure over the angle",
        found.pressure.at(angle_deg=np.degrees(angles)),
        law,
        1e-11,
        "Pa",
    )


@pytest.mark.parametrize(("ratio", "gamma"), [(8.0, 1.4), (14.0, 1.35), (22.0, 1.3)])
def test_instant_combustion_at_the_top_is_the_constant_volume_cycle(ratio, gamma, figure):
    """Opening as far after the top as closing before it, the cycle closes over volumes V_o, V_c."""
    opens_deg, heat = 150.0, 3000.0
    cycle = usual_gas_cycle(
        ratio, intake_closes_deg=-opens_deg, exhaust_opens_deg=opens_deg, heat_capacity_ratio=gamma
    )
    law = cylinder_volume(position, AREA, ratio)
    effective = float(volume_law(np.radians(opens_deg), ratio) / volume_law(0.0, ratio))
    otto = 1.0 - effective ** (1.0 - gamma)
    instant = replace(cycle, combustion_start_deg=0.0, combustion_duration_deg=np.degrees(1e-6))
    # The volume grows by 1e-12 during combustion.
    figure(
        "constant-volume cycle: work by heat", closed_work(instant, law, heat) / heat, otto, 1e-11
    )
    rise = (gamma - 1.0) * heat / float(volume_law(0.0, ratio))
    before = 2.5e5 * effective**gamma
    after = closed_pressure(instant, law, heat, np.degrees([2e-6]))[0]
    figure("constant-volume rise of pressure", after - before, rise, 1e-9, "Pa")


def test_shortfall_of_a_short_combustion_grows_with_the_square_of_its_duration(figure):
    ratio, gamma, opens_deg = 14.0, 1.35, 150.0
    cycle = usual_gas_cycle(
        ratio, intake_closes_deg=-opens_deg, exhaust_opens_deg=opens_deg, heat_capacity_ratio=gamma
    )
    law = cylinder_volume(position, AREA, ratio)
    effective = float(volume_law(np.radians(opens_deg), ratio) / volume_law(0.0, ratio))
    otto = 1.0 - effective ** (1.0 - gamma)
    for duration in (0.02, 0.01, 0.005):
        short = replace(
            cycle, combustion_start_deg=0.0, combustion_duration_deg=np.degrees(duration)
        )
        # Heat released where V = (1 + c a^2) V_c works as with the ratio V_o / V.
        share = (np.arange(4000) + 0.5) / 4000
        a = np.log(1000.0)
        rate = 2.0 * a * share * np.exp(-a * share**2) / 0.999 / 4000
        mean_square = duration**2 * float(rate @ share**2)
        growth = (ratio - 1.0) * (1.0 + R / L) / 4.0 * mean_square
        expected = effective ** (1.0 - gamma) * (gamma - 1.0) * growth
        shortfall = otto - closed_work(short, law, 3000.0) / 3000.0
        figure("shortfall of a short combustion", shortfall, expected, 0.01)


def test_wiebe_law_with_the_customary_factor(figure):
    """x = 1 - exp(-6.908 t^2) for the shape 1, which the model scales by 1 / 0.999.

    The rise of p V / (g - 1) by one joule is the burnt share where V^(g - 1) is constant: a ratio of
    1 + e leaves 3 e of it, 4e-11, of shares from a fifteenth on.
    """
    cycle = usual_gas_cycle(14.0, heat_capacity_ratio=1.0 + 2.0**-36)
    law = cylinder_volume(position, AREA, 14.0)
    share = np.array([0.1, 0.25, 0.5, 0.8])
    angles = cycle.combustion_start_deg + share * cycle.combustion_duration_deg
    expected = 1.0 - np.exp(-6.907755278982137 * share**2)
    burnt = pressure_rise_per_heat(cycle, law, angles) * law.at(angle_deg=angles) * 2.0**36
    figure("burnt share by Wiebe's law", 0.999 * burnt, expected, 1e-9)


def test_gas_exchange_does_the_work_of_its_two_pressures(figure):
    """Exhaust from the bottom to the top and intake back to the bottom: (p_i - p_e) V_s.

    Blow-down is left out by opening at the lowest pressure difference, a motored cycle that
    closes at the bottom; the overlap passes over symmetrically about the top, so that what it
    takes before is given after: the work is met to the square of its half width.
    """
    half = 2.5
    cycle = usual_gas_cycle(
        14.0,
        intake_pressure=3e5,
        exhaust_pressure=2e5,
        intake_closes_deg=-180.0,
        exhaust_opens_deg=175.0,
        overlap_begins_deg=360.0 - half,
        overlap_ends_deg=360.0 + half,
    )
    found = gas_cycle(cycle, position, AREA, heat=0.0)
    # Overlap and blow-down over 5 deg at a dead center: V_s (1 + R / L) half^2 / 4 at most each.
    figure("work of the gas exchange", found.mean_effective_pressure, 1e5, 2e-3, "Pa")
