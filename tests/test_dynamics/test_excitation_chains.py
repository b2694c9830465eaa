"""Excitation of chains by the cylinders: nodes, signs, and torsion that lengthens throws."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.engine_chains import axial_chain, torsional_chain
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.axial_forces import compare_axial_forces
from dynamics.excitation.chain_excitation import (
    axial_excitation,
    axial_excitation_of_torsion,
    axial_throw_forces,
    combined_excitation,
    node_torques,
    tangential_towards_flywheel,
    torque_excitation,
    torsion_influence,
)
from dynamics.excitation.cylinders import cylinder_harmonics, forces_at_speeds
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
RADIUS = 0.07
SPEEDS = np.array([50.0, 100.0])
RANDOM = np.random.default_rng(3)


class Waves:
    strokes = 4

    def at(self, *, angle_deg):
        angle = np.radians(angle_deg)
        return 1e5 * (12.0 + 9.0 * np.cos(0.5 * angle - 0.4) + 3.0 * np.cos(angle - 0.7))


def engine():
    """A V of three throws at 0, 120, 240 deg with rods side by side."""
    cylinders = [
        EngineCylinder(
            0.12,
            3.0,
            ROD,
            crank_angle_deg=math.degrees(crank),
            bank_angle_deg=math.degrees(bank),
            position=0.2 * throw + 0.02 * side,
        )
        for throw, crank in enumerate(np.radians([0.0, 120.0, 240.0]).tolist())
        for side, bank in enumerate(np.radians([-45.0, 45.0]).tolist())
    ]
    return EngineLayout(RADIUS, cylinders, [1, 2, 5, 6, 3, 4])


HARMONICS = cylinder_harmonics(engine(), 6.0, Waves())
FORCES = forces_at_speeds(HARMONICS, SPEEDS)
TORSIONAL = torsional_chain([1e-7] * 3, [0.2] * 3, 20.0, 0.1, cylinders=2)
E_THROWS = np.array([1.0e-9, 0.8e-9, 1.1e-9])
AXIAL = axial_chain(E_THROWS, [60.0] * 3, 300.0, 3, 8e8)


def test_torques_act_on_the_nodes_of_throws():
    found = torque_excitation(FORCES, TORSIONAL)
    first = TORSIONAL.throw_nodes[0]
    by_throw = FORCES.torque[:, :, ::2] + FORCES.torque[:, :, 1::2]
    assert found.forces[:, :, first : first + 3] == close(by_throw, abs=1e-9)
    others = np.delete(found.forces, list(TORSIONAL.throw_nodes), axis=2)
    assert np.all(others == 0.0)
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
    radial_only = axial_throw_forces(FORCES, E_THROWS, influence[..., 0])
    assert radial_only != close(found)


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


def test_orders_of_engine_and_propeller_combine():
    one = OrderExcitation([1.0, 2.0], SPEEDS, np.ones((2, 2, 3)))
    other = OrderExcitation([1.5, 2.0 * (1 + 1e-12)], SPEEDS, np.full((2, 2, 3), 2j))
    found = combined_excitation(one, other)
    assert found.orders == close([1.0, 1.5, 2.0])
    assert found.forces[:, 0, 0].tolist() == [1.0, 2j, 1.0 + 2j]
    with pytest.raises(InputError, match="allowed are the same speeds and nodes"):
        combined_excitation(one, OrderExcitation([1.0], SPEEDS, np.ones((1, 2, 4))))
    with pytest.raises(InputError, match="excitations: given none"):
        combined_excitation()


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match="given a torsional one; allowed is an axial"):
        axial_excitation(FORCES, TORSIONAL, E_THROWS, np.ones(3))
    with pytest.raises(InputError, match="allowed is a torsional one"):
        torque_excitation(FORCES, AXIAL)
    with pytest.raises(InputError, match="given one of 2 throws for cylinders on 3"):
        torque_excitation(FORCES, torsional_chain([1e-7] * 2, [0.2] * 2, 20.0))
    with pytest.raises(InputError, match=r"influence: given an array of shape \(2,\)"):
        axial_throw_forces(FORCES, E_THROWS, np.ones(2))
    with pytest.raises(InputError, match="pins: given"):
        axial_throw_forces(FORCES, E_THROWS, np.ones((3, 3)), pins=[0, 1])
    with pytest.raises(InputError, match="given 2 for a chain of 4 sections"):
        axial_excitation(
            forces_at_speeds(
                cylinder_harmonics(engine(), 2.0, Waves(), throws=[0, 0, 1, 1, 0, 0]), SPEEDS
            ),
            AXIAL,
            E_THROWS[:2],
            np.ones(2),
        )
    with pytest.raises(InputError, match="shapes: given an array of shape"):
        compare_axial_forces(FORCES, E_THROWS, np.ones(3), np.ones((3, 3)), shapes=np.ones((1, 3)))
    with pytest.raises(InputError, match=r"tangential: given an array of shape \(2, 3\)"):
        torsion_influence(np.ones((2, 3)), np.ones(3), RADIUS)
