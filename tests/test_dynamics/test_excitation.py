"""Excitation of engines: cylinders' forces and torque on chains."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from dynamics.chains.dampers import AxialDamper, RubberDamper, ViscousDamper
from dynamics.chains.engine_chains import axial_chain, torsional_chain
from dynamics.engine.forces import gas_forces, mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.excitation.chain_excitation import (
    axial_excitation,
    axial_excitation_of_torsion,
    axial_throw_forces,
    combined_excitation,
    compare_axial_forces,
    node_torques,
    tangential_towards_flywheel,
    torque_excitation,
    torsion_influence,
)
from dynamics.excitation.cylinders import (
    cylinder_forces,
    cylinder_harmonics,
    forces_at_speeds,
    torque_harmonics,
)
from dynamics.excitation.pressure_map import propeller_load
from dynamics.gas.gas_cycle import gas_cycle, usual_gas_cycle
from dynamics.gas.pressure import cylinder_volume, gas_pressure, motored_from_compression
from dynamics.harmonics import harmonics
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.order_excitation import OrderExcitation
from equilibrium import unbalanced
from parts_in_a_line import cylinder as made_cylinder
from refusals import refusals, refusals_of, refused
from small_engines import ROD, SmoothPressure, two_stroke_row, vee

RADIUS = 0.07
SPEEDS = np.array([50.0, 100.0])
RANDOM = np.random.default_rng(3)


def chains_engine():
    """A V of three throws at 0, 120, 240 deg with rods side by side."""
    cylinders = [
        made_cylinder(
            0.12, 3.0, ROD, math.degrees(crank), math.degrees(bank), 0.2 * throw + 0.02 * side
        )
        for throw, crank in enumerate(np.radians([0.0, 120.0, 240.0]).tolist())
        for side, bank in enumerate(np.radians([-45.0, 45.0]).tolist())
    ]
    return EngineLayout(RADIUS, cylinders, [1, 2, 5, 6, 3, 4])


HARMONICS = cylinder_harmonics(chains_engine(), 6.0, SmoothPressure(4))
FORCES = forces_at_speeds(HARMONICS, SPEEDS)
TORSIONAL = torsional_chain([1e-7] * 3, [0.2] * 3, 20.0, 0.1, cylinders=2)
E_THROWS = np.array([1.0e-9, 0.8e-9, 1.1e-9])
AXIAL = axial_chain(E_THROWS, [60.0] * 3, 300.0, 3, 8e8)


def test_torques_act_on_the_nodes_of_throws():
    found = torque_excitation(FORCES, TORSIONAL)
    first = TORSIONAL.throw_nodes[0]
    by_throw = FORCES.torque[:, :, ::2] + FORCES.torque[:, :, 1::2]
    assert found.forces[:, :, first : first + 3] == close(by_throw, abs=1e-9)
    assert np.all(np.delete(found.forces, list(TORSIONAL.throw_nodes), axis=2) == 0.0)
    angles = RANDOM.uniform(0.0, 40.0, 9)
    over_time = node_torques(HARMONICS, TORSIONAL, SPEEDS[1], shaft_angle_deg=np.degrees(angles))
    waves = found.at_angle(1, shaft_angle_deg=np.degrees(angles))
    # What is left of both is the mean, the same at all angles.
    assert np.ptp(over_time - waves, axis=0) == close(np.zeros(waves.shape[1]), abs=1e-8)
    assert (over_time - waves)[0].sum() == close(FORCES.mean_torque[1], rel=1e-12)


def test_axial_forces_press_the_ends_of_throws_apart():
    own = np.array([0.5e-9, 0.4e-9, 0.6e-9])
    found = axial_excitation(FORCES, AXIAL, E_THROWS, own).forces
    pressing = (FORCES.radial[:, :, ::2] + FORCES.radial[:, :, 1::2]) * own / E_THROWS
    # Some orders cancel: what is left of them is round-off of the others.
    round_off = 1e-13 * np.abs(pressing).max()
    assert found[:, :, 0] == close(-pressing[:, :, 0], rel=1e-12, abs=round_off)
    assert found[:, :, 3] == close(pressing[:, :, 2], rel=1e-12, abs=round_off)
    assert found.sum(axis=2) == close(np.zeros(found.shape[:2]), abs=1e-9)
    # Statically, far below resonance, the chain lengthens as the free throws would: by c Z.
    quiet = axial_chain(E_THROWS, [1e-9] * 3, 1e-9, 3, 8e8)
    motion = forced_response(
        quiet.chain, axial_excitation(FORCES, quiet, E_THROWS, own), method="direct"
    ).motion
    lengthening = np.diff(motion, axis=2)
    wanted = pressing * E_THROWS
    assert lengthening == close(wanted, rel=1e-9, abs=1e-12 * np.abs(wanted).max())


def test_influence_of_neighbors_and_pins():
    influence = RANDOM.normal(size=(3, 3, 2)) * 1e-9
    found = axial_throw_forces(FORCES, E_THROWS, influence)
    wanted = np.zeros_like(found)
    for throw in range(3):
        for cylinder, pin in enumerate(FORCES.throws):
            wanted[..., throw] += influence[throw, pin, 0] * FORCES.radial[..., cylinder]
            wanted[..., throw] += influence[throw, pin, 1] * FORCES.tangential[..., cylinder]
    assert found == close(wanted / E_THROWS, abs=1e-9 * np.abs(wanted / E_THROWS).max())
    split = np.repeat(influence, 2, axis=1)
    assert axial_throw_forces(FORCES, E_THROWS, split, pins=range(6)) == close(found)
    assert axial_throw_forces(FORCES, E_THROWS, influence[..., 0]) != close(found)


def test_comparison_shows_what_neighbors_do():
    own, influence = np.full(3, 0.5e-9), np.full((3, 3), 0.1e-9) + 0.4e-9 * np.eye(3)
    shapes = np.array([[1.0, 0.8, 0.5, 0.1]])
    found = compare_axial_forces(FORCES, E_THROWS, own, influence, shapes=shapes)
    pins = FORCES.radial[:, :, ::2] + FORCES.radial[:, :, 1::2]
    apart = np.abs(0.1e-9 / E_THROWS * (pins - pins.sum(axis=2, keepdims=True))).max(axis=2)
    assert found.difference * np.abs(found.in_shaft).max(axis=2) == close(
        apart, rel=1e-9, abs=1e-13 * apart.max()
    )
    assert found.modal_alone[..., 0] == close(found.alone @ np.diff(shapes[0]))
    table = found.columns(1)
    assert list(table)[:3] == ["order", "throw_1_alone_N", "throw_1_in_shaft_N"]
    assert table["mode_1_in_shaft_N"] == close(np.abs(found.modal_in_shaft[:, 1, 0]))
    scaled = compare_axial_forces(FORCES, E_THROWS, own, influence, own_compliances=2 * E_THROWS)
    assert scaled.alone == close(0.5 * found.alone)
    assert scaled.modal_alone.shape == (12, 2, 0)


def test_torsion_lengthens_throws_as_the_tangential_forces_do_when_the_shaft_is_stiff():
    tangential, through = RANDOM.normal(size=(3, 3)) * 1e-10, RANDOM.normal(size=3) * 1e-9
    by_torque = torsion_influence(tangential, through, RADIUS)
    # Held at the flywheel instead: a torque R per T through the whole shaft is taken away.
    other_end = tangential - RADIUS * through[:, np.newaxis]
    assert tangential_towards_flywheel(tangential, through, RADIUS) == close(other_end)
    assert by_torque.sum(axis=1) == close(through)
    stiff = torsional_chain([1e-13] * 3, [1e-4] * 3, 1e9, 1e-4, cylinders=2)
    torsion = forced_response(stiff.chain, torque_excitation(FORCES, stiff), method="direct")
    found = axial_excitation_of_torsion(torsion, stiff, AXIAL, E_THROWS, by_torque)
    influence = np.stack((np.zeros((3, 3)), other_end), axis=-1)
    direct = axial_excitation(FORCES, AXIAL, E_THROWS, influence)
    # Inertia torques are 1e-6 of those of the gas here: 1e-4 kg m^2, 1e-13 rad/(N m), 600 rad/s.
    assert found.forces == close(direct.forces, abs=1e-5 * np.abs(direct.forces).max())


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_bodies_of_any_engine_are_in_equilibrium(seed):
    """The force through each throw accelerates all masses towards the free end, since none acts on pins."""
    draw = np.random.default_rng(seed)
    count = int(draw.integers(1, 8))
    per_throw = int(draw.integers(1, 3))
    throws = np.repeat(np.arange(count), per_throw)
    shape = (5, SPEEDS.size, throws.size)
    tangential, radial = 1e4 * (draw.normal(size=(2, *shape)) + 1j * draw.normal(size=(2, *shape)))
    forces = replace(
        FORCES,
        orders=np.sort(draw.uniform(0.5, 12.0, 5)),
        tangential=tangential,
        radial=radial,
        throws=tuple(throws.tolist()),
    )
    cranks = torsional_chain(
        10 ** draw.uniform(-9.0, -7.0, count),
        10 ** draw.uniform(-1.0, 1.0, count),
        draw.uniform(1.0, 300.0),
        draw.uniform(0.1, 3.0),
        loss_factor=draw.choice([0.0, 0.02]),
        throw_damping=draw.uniform(0.0, 20.0),
        cylinders=per_throw,
        damper=draw.choice([ViscousDamper(2.0, 300.0), RubberDamper(2.0, 1e5, 0.2), None]),
    )
    turned = damped(cranks.chain, modal_damping=draw.choice([None, 0.01]))
    twisted = forced_response(turned, torque_excitation(forces, cranks))
    torques = np.zeros_like(twisted.motion)
    np.add.at(
        torques,
        (..., np.array(cranks.throw_nodes)[throws]),
        RADIUS * tangential,
    )
    assert unbalanced(twisted, torques) < 1e-9

    compliances = 10 ** draw.uniform(-10.0, -8.0, count)
    engine = axial_chain(
        compliances,
        draw.uniform(20.0, 500.0, count),
        draw.uniform(0.0, 1000.0),
        int(draw.integers(0, count + 1)),
        draw.choice([0.0, 1e9]),
        {0: draw.uniform(0.0, 50.0)},
        thrust_damping=draw.uniform(0.0, 1e4),
        damping=draw.choice([0.0, 1e3]),
        loss_factor=draw.choice([0.0, 0.02]),
        damper=draw.choice([AxialDamper(damping=1e5, stiffness=1e8, mass=20.0), None]),
    )
    influence = draw.normal(size=(count, throws.size, 2)) * compliances[:, np.newaxis, np.newaxis]
    own = axial_excitation(forces, engine, compliances, influence, range(throws.size))
    by_parts = draw.normal(size=(count, count + 1)) * 1e-9
    by_torque = axial_excitation_of_torsion(twisted, cranks, engine, compliances, by_parts)
    pulled = damped(engine.chain, modal_damping=draw.choice([None, 0.01]))
    answer = forced_response(pulled, combined_excitation(own, by_torque))
    assert unbalanced(answer, np.zeros_like(answer.motion)) < 1e-9


def test_orders_of_engine_and_propeller_combine():
    one = OrderExcitation([1.0, 2.0], SPEEDS, np.ones((2, 2, 3)))
    other = OrderExcitation([1.5, 2.0 * (1 + 1e-12)], SPEEDS, np.full((2, 2, 3), 2j))
    found = combined_excitation(one, other)
    assert found.orders == close([1.0, 1.5, 2.0])
    assert found.forces[:, 0, 0].tolist() == [1.0, 2j, 1.0 + 2j]
    with refused("excitations"):
        combined_excitation(one, OrderExcitation([1.0], SPEEDS, np.ones((1, 2, 4))))


def test_what_does_not_fit_is_refused():
    with refused("engine_chain"):
        torque_excitation(FORCES, torsional_chain([1e-7] * 2, [0.2] * 2, 20.0))
    torsion = forced_response(TORSIONAL.chain, torque_excitation(FORCES, TORSIONAL))
    with refused("influence"):
        axial_excitation_of_torsion(torsion, TORSIONAL, AXIAL, E_THROWS, np.ones((3, 3)))
    endless = replace(torsion, unbounded=np.ones_like(torsion.unbounded))
    with refused("response"):
        axial_excitation_of_torsion(endless, TORSIONAL, AXIAL, E_THROWS, np.ones((3, 4)))
    with refused("throws"):
        torque_harmonics(
            harmonics(np.ones(8), 4),
            1.0,
            firing_angles_deg=[0, 360],
            crank_radius=0.1,
            throws=[0, 2],
        )
    with refused("compliances"):
        axial_excitation(
            forces_at_speeds(
                cylinder_harmonics(
                    chains_engine(), 2.0, SmoothPressure(4), throws=[0, 0, 1, 1, 0, 0]
                ),
                SPEEDS,
            ),
            AXIAL,
            E_THROWS[:2],
            np.ones(2),
        )
    with refused("shapes"):
        compare_axial_forces(FORCES, E_THROWS, np.ones(3), np.ones((3, 3)), shapes=np.ones((1, 3)))


CYLINDER_SPEEDS = np.array([60.0, 150.0, 240.0])
CYLINDER_RANDOM = np.random.default_rng(7)


ENGINES = pytest.mark.parametrize("engine", [two_stroke_row(), vee(True), vee(False)])


@ENGINES
@pytest.mark.parametrize("model", ["rigid", "two-mass"])
def test_orders_add_up_to_the_forces_of_the_mechanism(engine, model):
    pressure = SmoothPressure(engine.strokes)
    angles = CYLINDER_RANDOM.uniform(-20.0, 20.0, 40)
    found = cylinder_forces(engine, CYLINDER_SPEEDS, 36.0, pressure, model=model)
    gas = gas_forces(engine, pressure, shaft_angles_deg=np.degrees(angles))
    for place, speed in enumerate(CYLINDER_SPEEDS):
        forces = mechanism_forces(
            engine, speed, gas, model=model, shaft_angles_deg=np.degrees(angles)
        )
        tangential, radial = found.at_angle(place, shaft_angle_deg=np.degrees(angles))
        # Orders of rods fade by lambda / 4 each: beyond the 36th they are round-off.
        largest = np.max(np.abs(forces.crankpin))
        assert tangential == close(forces.tangential.T, abs=1e-11 * largest)
        assert radial == close(forces.radial.T, abs=1e-11 * largest)


def test_a_failing_cylinder_follows_the_pressure_without_combustion():
    engine, fired, cold = vee(True), SmoothPressure(4), SmoothPressure(4, 0.3)
    mixed = cylinder_forces(engine, CYLINDER_SPEEDS, 8.0, fired, misfire={3: 0.25}, motored=cold)
    each = [fired, fired, SmoothPressure(4, 0.75 + 0.25 * 0.3), fired]
    direct = cylinder_forces(engine, CYLINDER_SPEEDS, 8.0, each)
    assert mixed.tangential == close(direct.tangential, abs=1e-9)
    assert mixed.mean_radial == close(direct.mean_radial, abs=1e-9)
    all_fire = cylinder_forces(engine, CYLINDER_SPEEDS, 8.0, fired)
    same = np.isclose(mixed.tangential, all_fire.tangential, rtol=1e-12, atol=1e-9).all(axis=(0, 1))
    assert same.tolist() == [True, True, False, True]


def test_time_functions_follow_the_speed():
    engine = two_stroke_row()
    harmonics = cylinder_harmonics(engine, 30.0, SmoothPressure(2))
    angles = CYLINDER_RANDOM.uniform(0.0, 50.0, 20)
    turning = np.linspace(50.0, 200.0, 20)
    tangential, radial = harmonics.at(turning, shaft_angle_deg=np.degrees(angles))
    gas = gas_forces(engine, SmoothPressure(2), shaft_angles_deg=np.degrees(angles))
    forces = mechanism_forces(engine, turning, gas, shaft_angles_deg=np.degrees(angles))
    largest = np.max(np.abs(forces.crankpin))
    assert tangential == close(forces.tangential.T, abs=1e-11 * largest)
    assert radial == close(forces.radial.T, abs=1e-11 * largest)
    steady = cylinder_forces(engine, [120.0], 30.0, SmoothPressure(2)).at_angle(
        0, shaft_angle_deg=np.degrees(angles)
    )
    assert np.array(harmonics.at(120.0, shaft_angle_deg=np.degrees(angles))) == close(
        np.array(steady), rel=1e-9
    )


def crank_slider(angle):
    return 0.07 * np.cos(angle) + np.sqrt(0.25**2 - (0.07 * np.sin(angle)) ** 2)


def test_motored_pressure_from_a_fired_diagram():
    cycle = usual_gas_cycle(15.0, intake_pressure=2.5e5, exhaust_pressure=2.2e5)
    volume = cylinder_volume(crank_slider, 0.0133, 15.0)
    fired = gas_cycle(cycle, crank_slider, 0.0133, peak_pressure=16e6).pressure
    cold = gas_cycle(cycle, crank_slider, 0.0133, heat=0.0).pressure
    found = motored_from_compression(fired, volume)
    # The model compresses by one exponent, so that the closed part comes back to round-off. Only
    # the blow-down differs, measured 6.3e-4 of the peak.
    closed = np.abs(np.angle(np.exp(0.5j * np.radians(found.angles_deg)))) < math.radians(60.0)
    assert found.pressure[closed] == close(cold.pressure[closed], rel=1e-9)
    assert np.max(np.abs(found.pressure - cold.pressure)) < 1e-3 * fired.peak_pressure
    assert f"exponent {cycle.heat_capacity_ratio:.4g}" in found.remarks[-1]
    with refused("fit_from_deg"):
        motored_from_compression(fired, volume, fit_from_deg=-40.1)
    with refused("fit_from_deg"):
        motored_from_compression(fired, volume, fit_to_deg=12.0)
    lagging = gas_pressure(np.roll(fired.pressure, 600), angles_deg=fired.angles_deg)
    with refused("pressure"):
        motored_from_compression(lagging, volume)


def diagram(step_deg, strokes=4):
    angle = np.radians(np.arange(0.0, 180.0 * strokes, step_deg))
    return gas_pressure(
        SmoothPressure(strokes).at(angle_deg=np.degrees(angle)),
        strokes,
        angles_deg=np.degrees(angle),
    )


test_what_does_not_fit_is_refused_cylinder = refusals_of(
    lambda changed: cylinder_forces(
        vee(True),
        **{"speeds": CYLINDER_SPEEDS, "orders": 6.0, "pressure": SmoothPressure(4)} | changed,
    ),
    ({"orders": [0.75]}, "orders[0]"),
    ({"orders": [1.0, 200.0], "samples": 360}, "orders[1]"),
    ({"orders": [1.0, 18.0], "pressure": diagram(10.0)}, "orders[1]"),
    ({"speeds": [100.0, 90.0]}, "speeds[1]"),
    ({"pressure": [SmoothPressure(4)]}, "pressure"),
    ({"pressure": diagram(5.0, 2)}, "pressure"),
    ({"misfire": {1: 1.0}}, "motored"),
    ({"misfire": {5: 1.0}, "motored": SmoothPressure(4)}, "cylinder"),
    ({"misfire": {1: 1.5}, "motored": SmoothPressure(4)}, "misfire[1]"),
    ({"misfire": {1: 1.0}, "pressure": None}, "misfire"),
    ({"load": 0.5}, "load"),
    ({"throws": [0, 0, 2, 2]}, "throws"),
)


def test_a_firing_order_that_does_not_fit_the_cranks_is_refused():
    cylinders = [
        EngineCylinder(
            0.12, 3.0, ROD, crank_angle_deg=math.degrees(c), bank_angle_deg=0.0, position=0.2 * i
        )
        for i, c in enumerate(np.radians([0.0, 180.0, 180.0, 0.0]).tolist())
    ]
    with refused("firing_order"):
        EngineLayout(0.07, cylinders, [1, 4, 3, 2])


def test_propeller_load():
    assert propeller_load(100.0, 0.9, measure="power")(CYLINDER_SPEEDS) == close(
        0.9 * (CYLINDER_SPEEDS / 100.0) ** 3
    )


test_refused_calls = refusals(
    ("excitations", lambda: combined_excitation()),
    ("engine_chain", lambda: axial_excitation(FORCES, TORSIONAL, E_THROWS, np.ones(3))),
    ("engine_chain", lambda: torque_excitation(FORCES, AXIAL)),
    ("tangential", lambda: tangential_towards_flywheel(np.ones((2, 3)), np.ones(3), 0.1)),
    ("influence", lambda: axial_throw_forces(FORCES, E_THROWS, np.ones(2))),
    ("pins", lambda: axial_throw_forces(FORCES, E_THROWS, np.ones((3, 3)), pins=[0, 1])),
    ("tangential", lambda: torsion_influence(np.ones((2, 3)), np.ones(3), RADIUS)),
    ("measure", lambda: propeller_load(100.0, measure="thrust")),
)
