"""Torque of the MWM diesel under its digitized cylinder pressure.

Source: pressure as digitized in openTorsion (Aalto-Arotor, examples/ICE_data, commit 88ab7893); an
independent solution with 7,200 points of the cycle; chain of Mendes et al. 2008, doi
10.1243/14644193JMBD126.

Tolerance: 1 %, for digits of the curve and the cut inertia series.

The engine (shipped as mwm-six): bore 105, stroke 137, rod 207 mm, 2.521 kg of reciprocating mass in each
cylinder, firing offsets (0, 4, 2, 5, 1, 3) times 120 deg. The pressure at a speed is the curve times its
peak. The independent solution interpolates it linearly and takes the inertia by the series m r w^2 (cos a +
L cos 2a - L^3/4 cos 4a + 9 L^5/128 cos 6a), orders 0.5 to 12: half peak-to-peak torque between flywheel and
cylinder 6, and the plain sum of all orders, largest at 2165/min. openTorsion's own picture shows about 9550
N m at 2175/min.
"""

import numpy as np
import pytest

from crankfem.files.chain.chain_file import load_chain
from dynamics.chains.engine_chains import EngineChain
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import GasPressure
from dynamics.response.forced import forced_response
from dynamics.response.loads import element_loads

# Angle after the scavenging top [deg], pressure [MPa].
CURVE = """
    0.00 0.2669, 28.05 0.2669, 50.61 0.2824, 71.34 0.2669, 94.51 0.2669, 112.20 0.2669,
    135.98 0.2824, 160.37 0.2824, 179.88 0.2824, 208.54 0.3133, 234.15 0.3598, 248.17 0.4062,
    262.80 0.4990, 276.83 0.6383, 292.07 0.9168, 301.22 1.2882, 309.15 1.5667, 314.63 1.9226,
    318.29 2.2940, 322.56 2.8511, 325.61 3.3926, 328.66 3.9342, 332.32 4.5068, 336.59 5.4043,
    337.80 6.2708, 340.85 6.9671, 343.90 8.1277, 345.73 9.1489, 348.17 10.1857, 350.61 10.9749,
    357.32 12.2592, 359.15 13.1412, 360.98 13.7756, 362.80 14.3017, 364.63 14.7814,
    367.68 15.1992, 371.34 14.6576, 373.78 14.1779, 375.00 13.7447, 376.83 13.1103,
    378.66 12.6151, 379.88 12.0271, 382.93 11.3617, 384.76 10.7273, 386.59 10.2012,
    388.41 9.1335, 390.24 8.6847, 391.46 8.2515, 393.90 7.7408, 395.73 7.1528, 397.56 6.4720,
    400.61 6.0696, 403.05 5.5126, 408.54 5.0019, 410.37 4.3211, 415.85 3.7331, 420.73 3.1296,
    428.05 2.7273, 437.80 2.1393, 451.22 1.7524, 465.85 1.4120, 481.71 1.1644, 501.83 0.9942,
    524.39 0.8549, 543.29 0.7002, 557.93 0.5300, 582.32 0.4062, 603.05 0.3288, 635.98 0.2979,
    669.51 0.2669, 698.17 0.2515, 720.00 0.2515
"""
# Speed [1/min], peak pressure [MPa].
PEAK = """
    997.8 14.278, 1097.2 14.278, 1197.8 14.266, 1296.0 14.064, 1396.5 14.827, 1495.8 14.827,
    1595.2 14.827, 1693.3 14.958, 1799.0 14.767, 1898.4 14.767, 1999.0 14.911, 2097.1 14.899,
    2197.7 15.149, 2298.6 13.479, 2398.4 11.809, 2550.6 5.881
"""
STEP = 0.1  # [deg], of the samples of a cycle
RADIUS, ROD = 0.0685, 0.207  # [m]
FIRING = [0.0, 480.0, 240.0, 600.0, 120.0, 360.0]  # [deg]
# Speed [1/min], half peak-to-peak torque [N m]; speed and largest plain sum of amplitudes.
TORQUES = ((1000.0, 1945.0), (1500.0, 2890.0), (2000.0, 4589.0), (2200.0, 7375.0))
SUM_SPEED, LARGEST_SUM = 2165.0, 9514.0


def pairs(table):
    """Return the two columns of pairs with commas between."""
    return np.array([pair.split() for pair in table.split(",")], dtype=float).T


def pressure(speed_rpm):
    """Return the pressure in a cylinder at a speed, from its firing top."""
    angles, values = pairs(CURVE)
    since_firing = STEP * np.arange(round(720.0 / STEP))
    # The curve begins half a cycle before firing.
    curve = np.interp((since_firing + 360.0) % 720.0, angles, values)
    peak = np.interp(speed_rpm, *pairs(PEAK))
    return GasPressure(since_firing, 1e6 * curve / 15.2 * peak, strokes=4)


def engine():
    # The mass that goes up and down is known alone: it is put into the piston, the rod weighs nothing.
    rod = ConnectingRod(ROD, 1e-9, 0.5 * ROD, 1e-12)
    cylinders = [
        EngineCylinder(0.105, 2.521, rod, crank_angle_deg=-angle % 360.0) for angle in FIRING
    ]
    return EngineLayout(RADIUS, cylinders, (1, 5, 3, 6, 2, 4), firing_angles_deg=FIRING)


@pytest.fixture(scope="module")
def torque():
    """Return what gives half the range and the plain sum of the torque before the flywheel."""
    layout = engine()
    chain = EngineChain(load_chain("mwm-six").chain, "torsional", throw_nodes=tuple(range(2, 8)))

    def found(speed_rpm):
        acting = cylinder_forces(
            layout,
            [speed_rpm * np.pi / 30.0],
            12.0,
            pressure(speed_rpm),
            crankcase_pressure=0.0,
            throws=range(6),
        )
        answer = forced_response(chain.chain, torque_excitation(acting, chain))
        both = element_loads(answer).elements.synthesis
        return float(both.amplitude[0, -1]), float(both.plain_sum[0, -1])

    return found


@pytest.mark.parametrize(("speed", "half"), TORQUES)
def test_half_range_of_the_torque_before_the_flywheel(torque, speed, half, figure):
    figure(f"half peak-to-peak torque at {speed:g} 1/min", torque(speed)[0], half, 0.01, "N m")


@pytest.mark.slow
def test_plain_sum_of_the_amplitudes_at_its_peak(torque, figure):
    near = SUM_SPEED + np.arange(-30.0, 31.0, 5.0)
    sums = [torque(speed)[1] for speed in near]
    largest = int(np.argmax(sums))
    figure("plain sum of all orders, its largest", sums[largest], LARGEST_SUM, 0.01, "N m")
    figure("speed of the largest plain sum", near[largest], SUM_SPEED, 0.005, "1/min")
