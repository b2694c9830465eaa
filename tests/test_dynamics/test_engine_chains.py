"""Chains of engines, and details of their vibration."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.dampers import AxialDamper, RubberDamper, ViscousDamper, main_inertia
from dynamics.chains.editing import with_damper
from dynamics.chains.engine_chains import (
    axial_chain,
    throw_inertia,
    throw_inertias,
    torsional_chain,
)
from dynamics.chains.shaft_line import DrivenMachine, ShaftLine, shaft_cylinder
from dynamics.engine.forces import reduced_inertia
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import axial_excitation_of_torsion
from dynamics.excitation.cylinders import cylinder_forces, forces_at_speeds, torque_harmonics
from dynamics.excitation.pressure_map import pressure_map
from dynamics.excitation.propeller import PropellerForces, propeller_excitation
from dynamics.gas.pressure import gas_pressure
from dynamics.harmonics import harmonics
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import chain_system, damped
from dynamics.response.loads import element_loads, power_balance
from dynamics.response.order_excitation import OrderExcitation
from parts_in_a_line import cylinder as made_cylinder
from refusals import refusals, refused


def test_axial_chain_shares_each_throw_between_its_sections():
    built = axial_chain([1e-9, 2e-9], [100.0, 140.0], 500.0, 1, 3e8, {0: 7.0})
    assert built.kind == "axial"
    assert built.nodes == (
        "main bearing 1",
        "main bearing 2, thrust bearing",
        "main bearing 3, flywheel",
    )
    assert built.chain.inertia.tolist() == [57.0, 120.0, 570.0]
    assert built.chain.stiffness == close([1e9, 5e8])
    assert built.chain.ground.tolist() == [0.0, 3e8, 0.0]


def test_thrust_bearing_may_stand_at_the_flywheel_and_masses_as_a_list():
    built = axial_chain([1e-9], [100.0], 500.0, 1, 3e8, [1.0, 2.0])
    assert built.nodes == ("main bearing 1", "main bearing 2, flywheel, thrust bearing")
    assert built.chain.inertia.tolist() == [51.0, 552.0]


def test_axial_chain_without_bearing_and_flywheel_is_free():
    built = axial_chain([1e-9], [100.0], 0.0, 0, 0.0)
    assert built.nodes == ("main bearing 1", "main bearing 2")
    modes = built.chain.modes()
    assert modes.rigid == 1
    assert modes.angular_frequencies[1] == close(np.sqrt(1e9 * (1 / 50 + 1 / 50)))


def test_whole_compliance_of_the_shaft_is_kept():
    compliances = [2e-7, 4e-7, 3e-7]
    chain = torsional_chain(compliances, [1.0, 1.0, 1.0], 5.0, free_end_inertia=1.0).chain
    assert np.sum(1.0 / chain.stiffness) == close(sum(compliances))


def test_throw_inertia():
    assert throw_inertia(1.5, 4.0, 6.0, 0.1) == close(1.5 + 0.04 + 0.03)


def test_throws_of_several_cylinders_are_called_throws():
    assert torsional_chain([1.0], [1.0], 1.0, cylinders=2).nodes == ("throw 1", "flywheel")
    mixed = torsional_chain([1.0] * 2, [1.0] * 2, 1.0, cylinders=[1, 2])
    assert mixed.nodes == ("throw 1", "throw 2", "flywheel")


def test_torsional_chain_with_damping_dampers_and_machines():
    machines = [
        DrivenMachine(30.0, 1e5, 0.2, 0.1, damping=0.3, name="alternator"),
        DrivenMachine(2.0, 1e4, name="exciter", on="alternator"),
    ]
    built = torsional_chain(
        *([2e-7, 4e-7], [0.5, 0.6], 10.0, 0.1, machines),
        damping=1.0,
        loss_factor=[0.01, 0.02, 0.03],
        throw_damping=[2.0, 4.0],
        damper=ViscousDamper(0.7, 50.0, hub_inertia=0.2),
    )
    chain = built.chain
    assert built.nodes == (
        *("free end", "cylinder 1", "cylinder 2", "flywheel"),
        *("alternator", "exciter", "damper ring"),
    )
    assert chain.inertia == close([0.3, 0.5, 0.6, 10.0, 30.0, 2.0, 0.7])
    assert chain.damping.tolist() == [1.0, 1.0, 1.0, 0.2, 0.0]
    assert chain.loss_factor.tolist() == [0.01, 0.02, 0.03, 0.1, 0.0]
    assert chain.ground_damping.tolist() == [0.0, 2.0, 4.0, 0.0, 0.3, 0.0, 0.0]
    assert chain.connections[-2:] == ((3, 4), (4, 5))
    assert [(d.left, d.right, d.damping) for d in chain.dashpots] == [(0, 6, 50.0)]


def test_the_hub_of_a_damper_makes_a_free_end():
    built = torsional_chain([1e-7], [1.0], 1.0, damper=RubberDamper(0.3, 1e5, hub_inertia=0.1))
    assert built.nodes == ("free end", "cylinder 1", "flywheel", "damper ring")
    assert built.chain.inertia.tolist() == [0.1, 1.0, 1.0, 0.3]
    assert built.chain.stiffness == close([2e7, 2e7, 1e5])


def test_axial_chain_with_damping_damper_and_shaft_line():
    built = axial_chain(
        *([1e-9, 2e-9], [100.0, 140.0], 500.0, 1, 3e8),
        thrust_damping=9.0,
        damping=[1.0, 2.0],
        loss_factor=0.01,
        section_damping=[4.0, 5.0, 6.0],
        damper=AxialDamper(1e5, stiffness=2e7, mass=30.0),
        shaft_line=ShaftLine([shaft_cylinder(3.0, 0.2)], name="line").chain("axial"),
    )
    chain = built.chain
    assert built.nodes[-2:] == ("main bearing 3, flywheel", "line 1")
    assert chain.inertia.tolist() == [80.0, 120.0, 570.0, 0.0]
    assert chain.ground.tolist() == [2e7, 3e8, 0.0, 0.0]
    assert chain.ground_damping.tolist() == [1e5 + 4.0, 14.0, 6.0, 0.0]
    assert chain.damping.tolist() == [1.0, 2.0, 0.0]
    assert chain.loss_factor.tolist() == [0.01, 0.01, 0.0]
    assert built.sections == (0, 1, 2)


@pytest.fixture
def v_four():
    """Two throws at 90 deg with two cylinders each: side by side, and one rod hinged."""
    rod = ConnectingRod(length=0.25, mass=3.0, center_distance=0.08, inertia=0.02)
    crank, bank = np.pi / 2.0, np.pi / 4.0
    pin = SlavePin(main_cylinder=3, radius=0.06, angle_deg=90.0)
    slave = ConnectingRod(length=0.19, mass=2.0, center_distance=0.08, inertia=0.01)
    return EngineLayout(
        crank_radius=0.07,
        cylinders=[
            made_cylinder(0.12, 2.0, rod, 0.0, math.degrees(-bank), 0.0),
            made_cylinder(0.12, 2.0, rod, 0.0, math.degrees(bank), 0.03),
            made_cylinder(0.12, 2.0, rod, math.degrees(crank), math.degrees(-bank), 0.2),
            made_cylinder(
                0.12, 2.0, slave, math.degrees(crank), math.degrees(bank), 0.2, slave_pin=pin
            ),
        ],
        firing_order=[1, 2, 3, 4],
    )


def test_throw_inertias_of_several_cylinders(v_four):
    half = throw_inertias(v_four, [0.5, 0.6])
    at_piston = 3.0 * 0.08 / 0.25
    assert half[0] == close(throw_inertia(0.5, [3.0 - at_piston] * 2, [2.0 + at_piston] * 2, 0.07))
    exact = throw_inertias(v_four, [0.5, 0.6], reciprocating="mean")
    # The mean of the whole engine's reduced inertia, by another path through the mechanism.
    whole, _ = reduced_inertia(
        v_four,
        tuple(cylinder.rod.model("rigid") for cylinder in v_four.cylinders),
        shaft_angles_deg=np.degrees(np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)),
    )
    assert exact.sum() == close(1.1 + whole.mean(), rel=1e-12)
    # Half the mass leaves out lambda^2 / 8 of the piston's share and the rod's lacking inertia.
    assert half[0] == close(exact[0], rel=0.02)
    assert half[0] != close(exact[0], rel=1e-4)
    given = throw_inertias(v_four, [0.5, 0.6], reciprocating="mean", throws=[0, 0, 1, 1])
    assert given.tolist() == exact.tolist()


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 0.4), st.floats(0.1, 0.6), st.floats(0.5, 1.0))
def test_mean_inertia_of_a_throw_is_its_series_in_the_crank_ratio(ratio, along, share):
    """The next terms have lambda^4, times the moving masses and the inertia that two masses lack."""
    radius, piston, mass = 0.12, 12.0, 8.0
    length = radius / ratio
    near, far = along * length, (1.0 - along) * length
    inertia = share * mass * near * far
    rod = ConnectingRod(length, mass, near, inertia)
    engine = EngineLayout(radius, [EngineCylinder(0.2, piston, rod)], [1], strokes=2)
    moving = piston + mass * along
    (half,) = throw_inertias(engine, [1.5])
    (mean,) = throw_inertias(engine, [1.5], reciprocating="mean")
    assert half == close(1.5 + (mass * (1.0 - along) + moving / 2.0) * radius**2)
    series = half + ratio**2 * (moving * radius**2 / 8.0 + (inertia - mass * near * far) / 2.0)
    beyond = (piston + mass) * radius**2 + mass * near * far / 4.0
    assert mean == close(series, abs=beyond * ratio**4)


def test_unusable_throw_inertias_are_refused(v_four):
    with refused("reciprocating"):
        throw_inertias(v_four, 1.0, reciprocating="third")
    with refused("solid_inertias"):
        throw_inertias(v_four, [1.0, 1.0, 1.0])
    with refused("throws"):
        throw_inertias(v_four, 1.0, throws=[0])


ROW = Chain([1.0, 2.0, 3.0], [1e4, 2e4])
FOUR_STROKE = np.radians(np.arange(0.0, 720.0, 2.0))


def at_first_node(speed, nodes=3):
    """A unit force of order one on the first node."""
    forces = np.zeros((1, 1, nodes))
    forces[0, 0, 0] = 1.0
    return OrderExcitation([1.0], [speed], forces)


# --- chains


def test_dashpots_told_in_any_order_join_a_chain():
    dashpots = [Dashpot(2, 3, 1.0), Dashpot(1, 2, 1.0), Dashpot(0, 1, 1.0)]
    assert len(Chain([1.0] * 4, [], connections=[], dashpots=dashpots).dashpots) == 3


@pytest.mark.parametrize(("inertia", "pair"), [([1.0, 3.0], (0, 1)), ([3.0, 1.0], (1, 0))])
def test_node_of_a_mode_lies_near_the_larger_inertia(inertia, pair):
    # Motions are as 3 to -1: the node lies at 3/4 of the element, from the smaller inertia.
    assert Chain(inertia, [4.0], connections=[pair]).modes().node_positions[1] == close((0.75,))


def test_kinetic_shares_with_distributed_inertia_add_up_to_one():
    modes = Chain([0.1, 0.4], [50.0], distributed_inertia=[0.9]).modes()
    assert np.allclose(modes.kinetic_shares.sum(axis=0), 1.0)


def test_main_inertia_where_the_node_moves_little():
    # Free inertias 1 and 3 move as 1 and -1/3: referred to the second, (1 + 3 / 9) * 9.
    main, _ = main_inertia(Chain([1.0, 3.0], [4.0]), 1)
    assert main == close(12.0)


def test_loss_factor_of_a_shaft_line_is_that_of_every_part():
    line = ShaftLine([shaft_cylinder(1.0, 0.1)])
    assert np.all(line.chain(loss_factor=0.01, parts=2).loss_factor == 0.01)


def test_number_of_cylinders_may_be_a_numpy_integer():
    chains = [torsional_chain([1e-8] * 2, [1.0] * 2, 3.0, cylinders=n) for n in (2, np.int64(2))]
    assert chains[0].nodes == chains[1].nodes


# --- response


def test_loss_factor_damps_a_mode_far_below_the_highest():
    # 20 and 2e6 rad/s: beside the square of the highest frequency, the first mode's loss is 1e-12.
    chain = Chain([1.0, 1.0, 1.0], [200.0, 2e12], loss_factor=0.01)
    speed = chain.modes().angular_frequencies[1]
    found = {
        method: forced_response(chain, at_first_node(speed), method=method)
        for method in ("modal", "direct")
    }
    assert not found["modal"].unbounded[0, 0]
    assert not found["direct"].unbounded[0, 0]
    matrix = chain.stiffness_matrix() + 1j * chain.loss_matrix() - speed**2 * chain.mass_matrix()
    wanted = np.linalg.solve(matrix, [1.0, 0.0, 0.0])
    # The round-off of the stiff spring is 2e-6 of the soft one, which counts 100 times at resonance.
    for one in found.values():
        assert np.allclose(one.motion[0, 0], wanted, rtol=0.0, atol=1e-3 * np.abs(wanted).max())


def test_rigid_motion_of_unknowns_behind_a_gear():
    chain = Chain(
        [1.0, 2.0, 3.0, 4.0], [5e3, 7e3], connections=[(0, 2), (1, 3)], gears=[Gear(0, 1, 3.0)]
    )
    system = chain_system(chain)
    # No spring resists it, but for the round-off of their torques.
    resisted = np.abs(system.stiffness @ system.rigid)
    assert np.max(resisted) < 1e-12 * np.abs(system.stiffness).max()
    assert np.allclose(system.expand @ system.rigid / system.rigid[0], [[1.0], [3.0], [1.0], [3.0]])


def test_elastic_motion_has_no_momentum():
    chain = Chain([1.0, 2.0, 30.0], [1e4, 2e4], damping=3.0)
    motion = forced_response(chain, at_first_node(40.0)).elastic.values[0, 0]
    # A sum of three terms that cancel to their round-off.
    assert np.abs(chain.inertia @ motion) < 1e-12 * np.abs(chain.inertia * motion).sum()


@pytest.mark.parametrize("kind", ["absolute", "relative", "loss_factor", "element_magnifier"])
def test_damping_of_nothing_counts_as_not_given(kind):
    assert damped(ROW, **{kind: {}}).record == damped(ROW).record
    assert damped(ROW, **{kind: {}}, undamped=True).record == ("no damping, on purpose",)


def test_error_of_power_stays_small_where_damping_is_next_to_nothing():
    chain = Chain([1.0, 2.0, 3.0], [1e4, 2e4], damping=[1e-16, 0.0])
    response = forced_response(chain, OrderExcitation([1.0], [33.0, 50.0], np.ones((1, 2, 3))))
    # Of the apparent power, to its round-off; the heat is 1e-20 of it.
    assert power_balance(response).error < 1e-12


@pytest.mark.parametrize("speeds", [[50.0, 100.0], [50.0, 80.0, 100.0], [50.0, 60.0, 80.0, 100.0]])
def test_forces_of_inertia_are_met_between_speeds(speeds):
    squares = 3.0 + 1j * np.square(speeds)
    acting = OrderExcitation([1.0], speeds, squares[np.newaxis, :, np.newaxis] * np.ones(2))
    asked = np.array([50.0, 55.0, 93.0])
    assert np.allclose(acting.at_speeds(asked).forces[0, :, 0], 3.0 + 1j * asked**2, rtol=1e-12)


def test_forces_that_are_no_numbers_are_refused():
    for forces in ([[["a"]]], None, [[[1.0]], [1.0]]):
        with refused("forces"):
            OrderExcitation([1.0], [1.0], forces)


# --- excitation


def test_given_torque_is_met_at_every_angle_after_each_firing():
    angles = np.arange(0.0, 4.0 * np.pi, 4.0 * np.pi / 720)

    def torque(angle):
        return 100.0 + 30.0 * np.sin(1.5 * angle + 0.4) + 5.0 * np.cos(0.5 * angle)

    known = harmonics(torque(angles), strokes=4)
    found = torque_harmonics(
        known, firing_angles_deg=np.degrees([0.0, 1.1]), orders=[0.5, 1.5], crank_radius=0.1
    )
    tangential, _ = forces_at_speeds(found, [10.0]).at_angle(0, shaft_angle_deg=np.degrees([0.7]))
    assert tangential[0, 1] * 0.1 == close(torque(0.7 - 1.1))
    with refused("orders[1]"):
        torque_harmonics(
            known.up_to(3.0),
            firing_angles_deg=np.degrees([0.0, 1.1]),
            orders=[0.5, 3.5],
            crank_radius=0.1,
        )


def level(pressure):
    return gas_pressure(pressure + 0.0 * FOUR_STROKE, 4, angles_deg=np.degrees(FOUR_STROKE))


def test_points_of_a_map_within_round_off_are_one_speed():
    near = 1.0 + 1e-12
    points = [(10.0 * near, 1.0), (20.0, 1.0), (10.0, 2.0), (20.0 * near, 2.0)]
    found = pressure_map(
        [(*point, level(1e5 * number)) for number, point in enumerate(points, start=1)]
    )
    assert [own.pressure[0] for own in found.diagrams] == [1e5, 3e5, 2e5, 4e5]


def one_cylinder(strokes=4):
    rod = ConnectingRod(length=0.5, mass=8.0, center_distance=0.18, inertia=0.3)
    cylinder = EngineCylinder(bore=0.2, piston_mass=12.0, rod=rod)
    return EngineLayout(crank_radius=0.12, cylinders=[cylinder], firing_order=[1], strokes=strokes)


def test_spline_between_diagrams_below_zero_pressure_is_refused():
    peak = 45e5 * np.exp(-(((FOUR_STROKE - 2.0 * np.pi) / 0.3) ** 2))
    flat, fired = level(9e4), gas_pressure(9e4 + peak, 4, angles_deg=np.degrees(FOUR_STROKE))
    points = [(10.0, 1.0, flat), (20.0, 1.0, flat), (21.0, 1.0, fired), (40.0, 1.0, flat)]
    with refused("speed"):
        cylinder_forces(one_cylinder(), [15.0], 4, pressure_map(points))
    straight = pressure_map(points, method="linear")
    assert np.all(np.isfinite(cylinder_forces(one_cylinder(), [15.0], 4, straight).tangential))


def test_motored_diagram_at_all_speeds_beside_a_map_is_remarked():
    points = [(speed, 1.0, level(2e5)) for speed in (10.0, 20.0)]
    given = {"pressure": pressure_map(points), "motored": level(1e5)}
    plain = cylinder_forces(one_cylinder(), [12.0, 18.0], 4, **given)
    failing = cylinder_forces(one_cylinder(), [12.0, 18.0], 4, **given, misfire={1: 1.0})
    assert [len(found.remarks) for found in (plain, failing)] == [0, 1]


def test_inertia_forces_do_not_depend_on_the_samples_of_the_gas():
    few, many = (cylinder_forces(one_cylinder(), [15.0], 5.0, samples=n) for n in (24, 1440))
    assert np.array_equal(few.tangential, many.tangential)


def test_torque_of_a_ring_on_the_last_crank_is_not_that_of_the_crankshaft():
    plain = torsional_chain([4e-8] * 3, [8.0] * 3, 200.0, free_end_inertia=1.0)
    ring = RubberDamper(2.0, 1e6, 0.1)
    ringed = replace(plain, chain=with_damper(plain.chain, plain.throw_nodes[-1], ring))
    forces = np.zeros((1, 1, len(ringed.nodes)))
    forces[0, 0, 1] = 1e3
    response = forced_response(
        ringed.chain, OrderExcitation([1.0], [300.0], forces), magnifier=30.0
    )
    loads = element_loads(response).elastic.values
    # The torque of the ring is told last; beside the others it is small, but far above round-off.
    assert np.abs(loads[0, 0, -1]) > 5e-3 * np.abs(loads).max()
    axial = axial_chain([1e-9] * 3, [200.0] * 3, 1000.0, 3, 1e9)
    influence = np.arange(1.0, 13.0).reshape(3, 4) * 1e-9
    found = axial_excitation_of_torsion(response, ringed, axial, [1e-9] * 3, influence)
    wanted = loads[:, :, :-1] @ influence.T / 1e-9
    assert np.allclose(found.pressing, wanted, rtol=1e-12)
    assert np.allclose(found.forces, np.diff(wanted, prepend=0.0, append=0.0) * -1.0, rtol=1e-12)


def test_ratio_of_a_propeller_behind_gears_and_a_dashpot_has_to_be_given():
    propeller = PropellerForces(4, 20.0, 3e5, 2e5, [0.08], [0.1])
    slipping = {
        "inertia": [2.0, 30.0, 5.0, 80.0],
        "stiffness": [1e6],
        "connections": [(0, 1)],
        "dashpots": [Dashpot(1, 2, 50.0)],
    }
    geared = Chain(**slipping, gears=[Gear(2, 3, 0.25)])
    with refused("ratio"):
        propeller_excitation(propeller, geared, 3, [40.0], kind="torsional")
    given = propeller_excitation(propeller, geared, 3, [40.0], kind="torsional", ratio=0.25)
    assert given.orders == close([1.0])
    slipping["inertia"] = [2.0, 30.0, 80.0]
    direct = propeller_excitation(propeller, Chain(**slipping), 2, [40.0], kind="torsional")
    assert direct.orders == close([4.0])


test_refused = refusals(
    ("throw_compliances", lambda: axial_chain([], [], 1.0, 0, 1.0)),
    ("throw_compliances[0]", lambda: axial_chain([0.0], [1.0], 1.0, 0, 1.0)),
    ("throw_masses", lambda: axial_chain([1.0], [1.0, 1.0], 1.0, 0, 1.0)),
    ("flywheel_mass", lambda: axial_chain([1.0], [1.0], -1.0, 0, 1.0)),
    ("thrust_node", lambda: axial_chain([1.0], [1.0], 1.0, 2, 1.0)),
    ("thrust_node", lambda: axial_chain([1.0], [1.0], 1.0, 0.5, 1.0)),
    ("thrust_stiffness", lambda: axial_chain([1.0], [1.0], 1.0, 0, -1.0)),
    ("extra_masses", lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, [1.0])),
    ("extra_masses[0]", lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, {0: -1.0})),
    ("flywheel_inertia", lambda: torsional_chain([1.0], [1.0], 0.0)),
    ("throw_inertias[0]", lambda: torsional_chain([1.0], [-1.0], 1.0)),
    ("free_end_inertia", lambda: torsional_chain([1.0], [1.0], 1.0, -1.0)),
    ("damping[0]", lambda: torsional_chain([1.0], [1.0], 1.0, damping=-1.0)),
    ("throw_damping", lambda: torsional_chain([1.0], [1.0], 1.0, throw_damping=[1.0, 1.0])),
    ("cylinders", lambda: torsional_chain([1.0], [1.0], 1.0, cylinders=0)),
    ("cylinders", lambda: torsional_chain([1.0], [1.0], 1.0, cylinders=[1, 1])),
    (
        "free_end_inertia",
        lambda: torsional_chain([1.0], [1.0], 1.0, damper=ViscousDamper(1.0, 1.0)),
    ),
    ("damper", lambda: torsional_chain([1.0], [1.0], 1.0, damper=AxialDamper(1.0))),
    ("damper", lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, damper=ViscousDamper(1.0, 1.0))),
    ("to", lambda: torsional_chain([1.0], [1.0], 1.0, 0.0, DrivenMachine(1.0, 1.0, on="pump"))),
    ("driven.inertia", lambda: DrivenMachine(0.0, 1.0)),
    ("driven.coupling_stiffness", lambda: DrivenMachine(1.0, 0.0)),
    ("solid_inertia_about_shaft", lambda: throw_inertia(0.0, 1.0, 1.0, 1.0)),
    ("rod_rotating_mass", lambda: throw_inertia(1.0, -1.0, 1.0, 1.0)),
    ("reciprocating_mass", lambda: throw_inertia(1.0, 1.0, -1.0, 1.0)),
    ("crank_radius", lambda: throw_inertia(1.0, 1.0, 1.0, 0.0)),
)
