"""A freely turning V6.

Source: Modelica Standard Library 4.0.0, EngineV6_analytic, reference trajectory of the Modelica Association
(Dymola 2020x, DASSL); Lagrange's equations by energy, written without the code under test.

Tolerance: 1e-5, of which DASSL's tolerance uses 5e-6; 1e-9 of both integrations against Lagrange.

Engine: Modelica.Mechanics.MultiBody.Examples.Loops.EngineV6_analytic of the Modelica Standard Library 4.0.0:
crank radius 50 mm, rods 175 mm of 1 kg and 0.006 kg m^2 with the center of mass in the middle, pistons 6 kg,
bore 100 mm, banks at -30 and 30 deg, cranks at -30, 90, 210, 210, 90 and -30 deg, crankshaft 0.1 kg m^2, load
1 kg m^2 and a torque of 100 N m (w / 200 rad/s)^2; gravity. The gas force is a function of the piston's
position in a cylinder of 195 mm and of its direction. Start: angle 0, 10 rad/s.

The trajectory is in MAP-LIB_ReferenceResults, branch of version 4.0.0, EngineV6_analytic.csv, relative
tolerance 1e-6. The torque at the start agrees to the 15 digits printed.

The second reference shares nothing with the code under test: positions by Pythagoras' theorem, kinetic
energy and its derivative by differences of fourth order, integrated stroke by stroke to 1e-12. Both
integrations leave 1e-9.
"""

import math
from itertools import pairwise

import numpy as np
import pytest

import crankfem as cf
from comparing import close

RADIUS, LENGTH, BORE, CYLINDER = 0.05, 0.175, 0.1, 0.195
PISTON, ROD, ROD_INERTIA, SHAFT_INERTIA, GRAVITY = 6.0, 1.0, 0.006, 1.1, 9.81
CRANKS = np.radians([-30.0, 90.0, 210.0, 210.0, 90.0, -30.0])
BANKS = np.radians([-30.0, 30.0, -30.0, 30.0, -30.0, 30.0])
# Between the piston at its highest place and the end of the cylinder.
CLEARANCE = 0.42 - (0.1 + LENGTH + RADIUS)

# Columns time [s], load.phi [rad], load.w [rad/s] of the trajectory.
TRAJECTORY = [
    (0.000202, 0.00202485406563152, 10.0480643238077),
    (0.0101, 0.113366675489971, 12.4727531208377),
    (0.0202, 0.252430333263351, 15.0870168727551),
    (0.0404, 0.612303859437142, 20.5614759296013),
    (1.007576, 129.879726061332, 227.871330938362),
    (1.01, 130.432525060875, 228.245115488327),
]
# filter.x[1] at the start, where the filter is steady: torque of the engine on the load [N m].
FIRST_TORQUE = 238.056148886056


def pressure(x, direction):
    """GasForce2's pressure [Pa] of the place x, 1 at the cylinder's end; x stays below 0.93."""
    if direction > 0:
        return 1e5 * (177.4132 * x**4 - 287.2189 * x**3 + 151.8252 * x**2 - 24.9973 * x + 2.4)
    return 1e5 * (145.930 * x**4 - 131.707 * x**3 + 17.3438 * x**2 + 17.9272 * x + 2.4)


def gas(_number, position, direction, _angle):
    free = CLEARANCE + 2.0 * RADIUS * (1.0 - position)
    return pressure(1.0 - free / CYLINDER, direction) * 0.25 * math.pi * BORE**2


def load(speed, _angle):
    return 100.0 * (speed / 200.0) ** 2


def engine():
    rod = cf.ConnectingRod(LENGTH, ROD, LENGTH / 2.0, ROD_INERTIA)
    cylinders = [
        cf.EngineCylinder(
            BORE,
            PISTON,
            rod,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=math.degrees(bank),
        )
        for crank, bank in zip(CRANKS.tolist(), BANKS.tolist(), strict=True)
    ]
    return cf.EngineLayout(
        RADIUS, cylinders, [1, 6, 3, 4, 5, 2], strokes=2, shaft_inertia=SHAFT_INERTIA
    )


def turned(times, **changes):
    settings = {"gas": gas, "load": load, "gravity": GRAVITY} | changes
    return cf.torque.turn_freely(
        engine(),
        start_angle_deg=0.0,
        start_speed=10.0,
        duration=float(times[-1]),
        times=times,
        **settings,
    )


def test_torque_at_the_start(figure):
    found = turned([0.0, 1e-6])
    # The load's inertia of 1 kg m^2 and its torque of 0.25 N m hang on the engine's flange.
    torque = found.acceleration[0] + 0.25
    figure("Modelica: torque at the start", torque, FIRST_TORQUE, 1e-12, "N m")


@pytest.mark.slow
def test_trajectory_of_modelica(figure):
    time, angle, speed = np.array(TRAJECTORY).T
    found = turned(time)
    figure("Modelica: angle", np.radians(found.angle_deg), angle, 1e-5, "rad")
    figure("Modelica: speed", found.speed, speed, 1e-5, "rad/s")
    assert found.energy_error < 1e-9


def places(angle):
    """Piston and rod centers over the angle, s + i n: (6, m) each, by Pythagoras' theorem."""
    alpha = CRANKS[:, np.newaxis] - BANKS[:, np.newaxis] + angle
    aside = RADIUS * np.sin(alpha)
    piston = RADIUS * np.cos(alpha) + np.sqrt(LENGTH**2 - aside**2)
    center = 0.5 * (RADIUS * np.exp(1j * alpha) + piston)
    return piston, center, -np.arcsin(aside / LENGTH)


STEP = 1e-3
OFFSETS = STEP * np.array([-2.0, -1.0, 1.0, 2.0])
WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * STEP)


def slopes(angles):
    """Derivatives of places and of the rods' turning, (6, m) each."""
    near = places((angles[:, np.newaxis] + OFFSETS).ravel())
    return [value.reshape(6, angles.size, 4) @ WEIGHTS for value in near]


def inertia(angles):
    """Twice the kinetic energy at one rad/s."""
    piston, center, turn = slopes(angles)
    masses = PISTON * piston**2 + ROD * np.abs(center) ** 2 + ROD_INERTIA * turn**2
    return SHAFT_INERTIA + masses.sum(axis=0)


def height(angles):
    """Sum of masses times heights."""
    piston, center, _ = places(angles)
    up = np.exp(1j * BANKS[:, np.newaxis])
    return ((PISTON * piston + ROD * center) * up).real.sum(axis=0)


@pytest.mark.slow
def test_lagrange_equation_with_differences(figure):
    from scipy.integrate import solve_ivp

    area = 0.25 * math.pi * BORE**2

    def slope(angle, state, ways):
        time_slope, speed = 1.0 / state[1], state[1]
        here, around = np.array([angle]), angle + OFFSETS
        x = 1.0 - (CLEARANCE + RADIUS + LENGTH - places(here)[0][:, 0]) / CYLINDER
        forces = np.array([pressure(*each) for each in zip(x, ways, strict=True)]) * area
        moment = -forces @ slopes(here)[0][:, 0] - load(speed, angle)
        moment -= GRAVITY * (height(around) @ WEIGHTS)
        moment -= 0.5 * (inertia(around) @ WEIGHTS) * speed**2
        return [time_slope, moment / inertia(here)[0] * time_slope]

    # A stroke ends every 60 deg; in between all directions stay.
    ends = np.radians(60.0) * np.arange(13)
    states = [np.array([0.0, 10.0])]
    for begin, end in pairwise(ends):
        ways = np.sign(slopes(np.array([0.5 * (begin + end)]))[0][:, 0])
        found = solve_ivp(
            slope, (begin, end), states[-1], "DOP853", args=(ways,), rtol=1e-12, atol=1e-13
        )
        states.append(found.y[:, -1])
    times, speeds = np.array(states).T
    free = turned(times)
    assert np.radians(free.angle_deg) == close(ends, rel=1e-9, abs=1e-9)
    figure("Lagrange: speed at the ends of the strokes", free.speed, speeds, 1e-9, "rad/s")
