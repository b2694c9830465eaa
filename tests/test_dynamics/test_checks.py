"""Numbers that no result can be calculated from, and what every vibration is checked for."""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.array_checks import (
    HIGHEST_SPEED,
    LARGEST,
    SMALLEST,
    finite_array,
    nonnegative_number,
    positive_number,
    positive_vector,
    turning_speeds,
)
from crankbase.errors import SolveError
from dynamics.assessment.limit_rules import crankshaft_limit, propulsion_shaft_limit
from dynamics.assessment.limits import LimitCurve, axial_force_limit, given_limit
from dynamics.balance import balance
from dynamics.chains import chain as chains
from dynamics.chains.chain import Chain
from dynamics.chains.shaft_line import ShaftCone
from dynamics.crankshaft.surroundings import AxialSupport
from dynamics.critical import critical_speeds, engine_orders
from dynamics.engine.forces import (
    acceleration_orders,
    mechanism_forces,
    piston_acceleration,
    reduced_inertia,
)
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.cylinders import cylinder_forces, cylinder_harmonics
from dynamics.excitation.pressure_map import PressureMap
from dynamics.excitation.propeller import PropellerForces, propeller_excitation
from dynamics.gas.pressure import GasPressure, gas_pressure
from dynamics.indices import at_most, within
from dynamics.response import harmonic
from dynamics.response.forced import forced_response
from dynamics.response.loads import checked_power_balance
from dynamics.response.order_excitation import OrderExcitation
from dynamics.torque import check_energy, engine_torque, pin_force_harmonics, star_diagram
from refusals import refusals, refused

ROD = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
ENGINE = EngineLayout(
    0.05,
    [
        EngineCylinder(0.1, 1.0, ROD, crank_angle_deg=math.degrees(angle), position=0.1 * place)
        for place, angle in enumerate((0.0, math.pi, math.pi, 0.0))
    ],
    [1, 3, 4, 2],
)
ANGLES = np.radians(np.arange(0.0, 720.0, 2.0))
DEGREES = np.degrees(ANGLES)
PRESSURE = 2e5 + 6e6 * np.exp(-8.0 * (np.mod(ANGLES + np.pi, 4.0 * np.pi) - np.pi - 0.2) ** 2)
GAS = gas_pressure(PRESSURE, 4, angles_deg=DEGREES)
HARMONICS = cylinder_harmonics(ENGINE, 4.0, GAS)
CHAIN = Chain([1.0, 2.0, 3.0], [1e5, 2e5])
AT_RATED = {"blades": 4, "rated_thrust": 1e5, "rated_torque": 1e5}
AT_RATED |= {"thrust_shares": [0.1], "torque_shares": [0.1]}
PROPELLER = PropellerForces(**AT_RATED, rated_speed=10.0)
MODELS = tuple(cylinder.rod.model("rigid") for cylinder in ENGINE.cylinders)

# Everything that takes the speed of a shaft.
OF_SPEED = {
    "mechanism_forces": lambda speed: mechanism_forces(ENGINE, speed, shaft_angles_deg=DEGREES),
    "mechanism_forces at each angle": lambda speed: mechanism_forces(
        ENGINE, np.append(np.full(ANGLES.size - 1, 100.0), speed), shaft_angles_deg=DEGREES
    ),
    "balance": lambda speed: balance(ENGINE, speed),
    "engine_torque": lambda speed: engine_torque(ENGINE, speed, GAS),
    "pin_force_harmonics": lambda speed: pin_force_harmonics(ENGINE, speed),
    "piston_acceleration": lambda speed: piston_acceleration(ENGINE, 1, speed, angles_deg=DEGREES),
    "acceleration_orders": lambda speed: acceleration_orders(ENGINE, 1, speed),
    "cylinder_forces": lambda speed: cylinder_forces(ENGINE, [50.0, speed], 4.0, GAS),
    "harmonics, phasors": lambda speed: HARMONICS.phasors(np.array([50.0, speed])),
    "harmonics, at": lambda speed: HARMONICS.at(speed, shaft_angle_deg=DEGREES),
    "OrderExcitation": lambda speed: OrderExcitation([1.0], [50.0, speed], np.ones((1, 2, 3))),
    "critical_speeds": lambda speed: critical_speeds([10.0], [1.0], (5.0, speed)),
    "propeller_excitation": lambda speed: propeller_excitation(
        PROPELLER, CHAIN, 2, [5.0, speed], kind="torsional"
    ),
    "mean_torque": lambda speed: PROPELLER.mean_torque([5.0, speed]),
    "crankshaft_limit": lambda speed: crankshaft_limit(speed, strokes=4),
}


@pytest.mark.parametrize("speed", [math.nan, math.inf, 1e308, 1e200, 2.0 * HIGHEST_SPEED])
@pytest.mark.parametrize("name", OF_SPEED)
def test_speeds_of_no_shaft_are_refused(name, speed):
    with refused():
        OF_SPEED[name](speed)


@pytest.mark.parametrize("name", OF_SPEED)
def test_any_speed_of_a_shaft_is_taken(name):
    OF_SPEED[name](1e4)


# What the same numbers do elsewhere: they overflowed, or divided by zero.
ELSEWHERE = {
    "rod length": lambda: ConnectingRod(
        length=1e308, mass=1.0, center_distance=0.07, inertia=0.006
    ),
    "piston mass": lambda: EngineCylinder(0.1, 1e308, ROD),
    "inertia of a chain": lambda: Chain([1.0, 1e-320, 3.0], [1e5, 2e5]),
    "stiffness of a chain": lambda: Chain([1.0, 2.0, 3.0], [1e308, 2e5]),
    "forces": lambda: OrderExcitation([1.0], [50.0], np.full((1, 1, 3), 1e308)),
    "complex forces": lambda: OrderExcitation([1.0], [50.0], np.full((1, 1, 3), 1e308 + 1e308j)),
    "cone": lambda: ShaftCone(0.1, 1e308, 0.1),
    "propeller's speed": lambda: PropellerForces(**AT_RATED, rated_speed=1e-320),
    "propeller's ratio": lambda: propeller_excitation(
        PROPELLER, CHAIN, 2, [5.0], kind="torsional", ratio="a"
    ),
    "rated speed": lambda: propulsion_shaft_limit(6e8, 0.3, 1e-320),
    "web thickness": lambda: axial_force_limit(5e7, 0.1, 0.2, 1e-320, source="maker"),
    "limit for passing": lambda: given_limit(
        "force", 1.0, "N", applies_to="shaft", source="maker", passing="a"
    ),
    "highest order": lambda: engine_orders(4, 1e50),
    "orders": lambda: cylinder_harmonics(ENGINE, "a", GAS),
    "star": lambda: star_diagram(ENGINE, 1e308),
    "angle": lambda: reduced_inertia(ENGINE, MODELS, shaft_angles_deg=[0.0, np.nan]),
    "acceleration": lambda: mechanism_forces(
        ENGINE, 1.0, crank_acceleration=-1e308, shaft_angles_deg=DEGREES
    ),
    "support": lambda: AxialSupport(0, "a"),
    "pressure map's speeds": lambda: PressureMap(
        np.array([10.0, np.nan]), None, (GAS, GAS), "linear"
    ),
    "pressure map's loads": lambda: PressureMap(
        np.array([10.0]), np.array([np.nan]), (GAS,), "linear"
    ),
    "pressure map's diagrams": lambda: PressureMap(np.array([10.0]), None, (GAS, GAS), "linear"),
    "limit from": lambda: LimitCurve(np.ones_like, np.nan),
    "limit from text": lambda: LimitCurve(np.ones_like, "a"),
    "limit to": lambda: LimitCurve(np.ones_like, 5.0, 4.0),
    "limit to no number": lambda: LimitCurve(np.ones_like, 5.0, np.nan),
}


@pytest.mark.parametrize("name", ELSEWHERE)
def test_numbers_that_leave_what_can_be_calculated_are_refused(name):
    with refused():
        ELSEWHERE[name]()


def test_the_bounds_themselves_are_taken():
    assert positive_number("mass", LARGEST, "kg", "") == LARGEST
    assert positive_number("mass", SMALLEST, "kg", "") == SMALLEST
    assert positive_number("speed", HIGHEST_SPEED, "rad/s", "") == HIGHEST_SPEED
    assert nonnegative_number("damping", 1e-300, "", "") == 1e-300  # as good as none
    assert turning_speeds("speed", -HIGHEST_SPEED) == -HIGHEST_SPEED
    assert finite_array("force", [-LARGEST]).tolist() == [-LARGEST]


def test_a_hair_of_a_bore_is_none():
    solid, hair = (ShaftCone(0.1, 0.10, 0.12, bore) for bore in (0.0, 1e-320))
    assert hair.axial_compliance == close(solid.axial_compliance)
    assert hair.torsional_compliance == close(solid.torsional_compliance)
    small = ShaftCone(0.1, 0.10, 0.12, 1e-6)
    assert small.axial_compliance == close(solid.axial_compliance, rel=1e-8)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1e5, 0.0, 1e308])
def test_a_gas_pressure_is_checked_however_it_is_made(bad):
    spoiled = GAS.pressure.copy()
    spoiled[3] = bad
    with refused("pressure[3]"):
        GasPressure(GAS.angles_deg, spoiled, 4)


@pytest.mark.parametrize(
    ("angles", "strokes", "field"),
    [
        (
            np.where(GAS.angles_deg == GAS.angles_deg[3], np.nan, GAS.angles_deg),
            4,
            "angles_deg[3]",
        ),
        (GAS.angles_deg[:-1], 4, "angles_deg"),
        (GAS.angles_deg - 180.0, 4, "angles_deg"),
        (GAS.angles_deg + 0.06 * np.sin(np.radians(GAS.angles_deg)), 4, "angles_deg"),
        (GAS.angles_deg, 2, "angles_deg"),
        (GAS.angles_deg, 3, "strokes"),
        (np.radians(GAS.angles_deg), 4, "angles_deg"),
    ],
)
def test_a_gas_pressure_has_even_angles_of_one_cycle(angles, strokes, field):
    again = GasPressure(GAS.angles_deg, GAS.pressure, 4)
    assert again.at(angle_deg=57.0) == GAS.at(angle_deg=57.0)
    with refused(field):
        GasPressure(angles, GAS.pressure, strokes)


@pytest.mark.parametrize("end", [1.15 * n for n in (10.0, 47.123889803846896, 187.0)])
def test_ranges_of_speed_have_closed_ends(end):
    """A speed that is meant to be the end may have been rounded to either side of it."""
    places = np.array([end * (1.0 + steps * np.finfo(float).eps) for steps in (-4, -1, 0, 1, 4)])
    assert within(places, end, 2.0 * end).all()
    assert within(places, 0.0, end).all()
    assert at_most(places, end).all()
    assert at_most(end, places).all()
    beside = np.array([end * (1.0 - 1e-12), end * (1.0 + 1e-12)])
    assert within(beside, 0.0, end).tolist() == [True, False]
    assert within(beside, end, 2.0 * end).tolist() == [False, True]


BROKEN_CHAIN = Chain(inertia=[1.0, 2.0, 5.0], stiffness=[1e5, 3e5], damping=[20.0, 30.0])
SHARE = 1e-5
BROKEN_ENGINE = EngineLayout(0.05, [EngineCylinder(0.1, 1.0, ROD)], [1])


def response(method="modal"):
    forces = np.ones((2, 40, 3), dtype=complex)
    excitation = OrderExcitation([1.0, 2.0], np.linspace(20.0, 400.0, 40), forces)
    return forced_response(BROKEN_CHAIN, excitation, magnifier=None, method=method)


def test_answers_that_do_not_satisfy_the_equations(monkeypatch):
    exact = harmonic.dynamic_stiffness
    monkeypatch.setattr(harmonic, "dynamic_stiffness", lambda *given: (1.0 + SHARE) * exact(*given))
    with pytest.raises(SolveError, match=r"leaves a residual of .*e-06 .*\(allowed 1e-09\)"):
        response("direct")


def test_power_that_does_not_balance():
    found = response()
    assert checked_power_balance(found).error < 1e-12
    late = replace(found, motion=found.motion * np.exp(1j * SHARE))
    with pytest.raises(SolveError, match=r"differ by a share of \d.*\(allowed 1e-06\)"):
        checked_power_balance(late)


def test_modes_that_are_none(monkeypatch):
    find = chains.elastic_modes

    def off(rows, mass, count):
        frequencies, shapes = find(rows, mass, count)
        return (1.0 + SHARE) * frequencies, shapes

    monkeypatch.setattr(chains, "elastic_modes", off)
    with pytest.raises(SolveError, match=r"modes of the chain leave a residual of .*1e-10"):
        BROKEN_CHAIN.modes()


def test_work_that_is_not_that_of_the_gas():
    angles = np.radians(np.arange(0.0, 720.0, 0.5))
    torque = engine_torque(BROKEN_ENGINE, 100.0, [3e4 * np.exp(-(angles**2))])
    check_energy(torque)
    with pytest.raises(SolveError, match=r"work of the gas differ by a share of .*\(allowed"):
        check_energy(replace(torque, indicated_work=torque.indicated_work + 1e-3))


test_refused = refusals(
    ("speed", lambda: balance(ENGINE, ANGLES)),
    ("mass", lambda: positive_number("mass", 2.0 * LARGEST, "kg", "")),
    ("mass[1]", lambda: positive_vector("mass", [1.0, 0.5 * SMALLEST], "kg", "")),
    ("speed[1]", lambda: turning_speeds("speed", [0.0, -2.0 * HIGHEST_SPEED])),
    ("force[0][1]", lambda: finite_array("force", [[0.0, -2.0 * LARGEST]])),
)
