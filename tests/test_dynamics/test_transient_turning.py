"""Chains that turn with the inertia of their rods and pistons.

The integration keeps 1e-9 of the size of the motion per step; over a cycle or a tenth of a second
that leaves some 1e-8 of the motion and, with errors that cancel, less than 1e-9 of the energy.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import EngineChain
from dynamics.engine.forces import rod_models
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.motions import reduced_inertia
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import cylinder_forces
from dynamics.gas.pressure import gas_pressure
from dynamics.response.forced import forced_response
from dynamics.transient.turning_chain import throw_inertia_curves, turning_chain
from dynamics.transient.turning_run import steady_cycle, turn_under_gas
from dynamics.turning.free_turning import turn_freely

SPEED, HIGHEST = 30.0, 4


def engine(share=1.0):
    rod = ConnectingRod(0.5, 8.0 * share, 0.18, 0.3 * share)
    cylinders = [
        EngineCylinder(
            0.2, 12.0 * share, rod, crank_angle_deg=math.degrees(angle), position=position
        )
        for angle, position in ((0.0, 0.0), (np.pi, 0.3))
    ]
    return EngineLayout(0.12, cylinders, [1, 2], strokes=2)


def pressure():
    angles = np.radians(np.arange(0.0, 360.0, 5.0))
    return gas_pressure(
        1e5 + 2e6 * np.exp(4.0 * (np.cos(angles - 0.35) - 1.0)),
        strokes=2,
        angles_deg=np.degrees(angles),
    )


def small_chain(**options):
    # 12.5 and 43 Hz; orders 2 and 4 at 30 rad/s lie at 9.5 and 19 Hz.
    chain = Chain([2.0, 2.0, 9.0], [6e4, 2e4], **options)
    return EngineChain(chain, "torsional", throw_nodes=(0, 1))


def turning(share=1.0, gas=None, **options):
    own = engine(share)
    forces = cylinder_forces(own, [SPEED], HIGHEST, gas, inertia=False)
    return turning_chain(own, small_chain(**options), forces), forces


def with_gas_share(chain, share):
    curves = chain.curves
    torque = {"torque_mean": share * curves.torque_mean, "torque": share * curves.torque}
    return replace(chain, curves=replace(curves, **torque))


def test_inertia_of_the_throws_is_that_of_the_engine():
    own = engine()
    curves = turning()[0].curves
    angles = np.linspace(0.0, 6.0, 13)
    inertia, slope, _ = curves.at(np.column_stack((angles, angles)))
    wanted = reduced_inertia(own, rod_models(own, "rigid"), shaft_angles_deg=np.degrees(angles))
    assert np.allclose(inertia.sum(axis=1), wanted[0], rtol=1e-12)
    assert np.allclose(slope.sum(axis=1), wanted[1], rtol=0.0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("options", [{"damping": 30.0}, {"ground_damping": [8.0, 8.0, 0.0]}])
def test_little_gas_and_constant_inertia_give_the_linear_response(options):
    # The torque goes by the throw's own angle, so that the difference is of the second order.
    bare, forces = turning(gas=pressure(), **options)
    differences = []
    for share in (1e-3, 1e-4):
        found = steady_cycle(with_gas_share(bare, share).with_constant_inertia(), SPEED)
        acting = torque_excitation(forces, small_chain())
        wanted = share * forced_response(bare.system.system, acting).motion[:, 0]
        left = np.abs(found.phasors(forces.orders) - wanted).max()
        differences.append(left / np.abs(wanted).max())
        assert found.load == close(share * forces.mean_torque[0], rel=1e-3)
    assert differences[1] < 1e-4
    assert differences[1] == close(0.1 * differences[0], rel=0.1)


@pytest.mark.slow
def test_light_pistons_give_the_response_to_inertia_forces():
    differences = []
    for share in (1e-1, 1e-2):
        chain, _ = turning(share, damping=30.0)
        found = steady_cycle(chain, SPEED)
        own = cylinder_forces(engine(share), [SPEED], HIGHEST)
        acting = torque_excitation(own, small_chain())
        wanted = forced_response(chain.system.system, acting).motion[:, 0]
        left = np.abs(found.phasors(own.orders) - wanted).max()
        differences.append(left / np.abs(wanted).max())
    assert differences[1] < 1e-2
    assert differences[1] == close(0.1 * differences[0], rel=0.2)


def test_steady_cycle_repeats_and_keeps_its_energy():
    chain, _ = turning(gas=pressure(), damping=30.0, loss_factor=0.02)
    found = steady_cycle(chain, SPEED)
    assert found.turns == 1
    assert found.energy_error < 1e-8
    assert found.closing_error < 1e-7
    assert found.gas_work > 0.0 > found.damping_work
    assert found.load_work == close(-found.load * 2.0 * np.pi, rel=1e-8)
    assert np.mean(found.speed, axis=0) == close([SPEED] * 3, rel=1e-9)
    # The twist of the shaft's end carries the load, by its mean.
    assert np.mean(found.torque[:, 1]) == close(-found.load, rel=1e-6)
    assert "Hz, that of the lowest elastic mode" in found.note


@pytest.mark.slow
def test_implicit_integration_finds_the_same_cycle():
    chain, _ = turning(gas=pressure(), damping=30.0)
    light = with_gas_share(chain, 0.3)
    one, other = (steady_cycle(light, SPEED, method=way) for way in ("DOP853", "Radau"))
    # Radau's steps keep 1e-9 of each value, but their errors add up over some thousand of them.
    assert np.allclose(one.torque, other.torque, atol=1e-5 * np.abs(one.torque).max())


@pytest.mark.slow
def test_coasting_shaft_turns_like_the_rigid_engine():
    # A stiff shaft: 100 N m twist it by 1e-5 rad at 1e7 N m/rad, and as much comes from inertia.
    own = replace(engine(), shaft_inertia=2.0)
    mean = throw_inertia_curves(own, [0, 1]).mean
    shaft = Chain([0.5 + mean[0], 0.5 + mean[1], 1.0], [1e7, 1e7])
    forces = cylinder_forces(own, [SPEED], HIGHEST, inertia=False)
    chain = turning_chain(own, EngineChain(shaft, "torsional", throw_nodes=(0, 1)), forces)
    found = turn_under_gas(chain, SPEED, 0.1, load=100.0, samples_per_turn=36)
    wanted = turn_freely(
        own, start_angle_deg=0.0, start_speed=SPEED, duration=0.1, load=100.0, times=found.time
    )
    assert found.complete
    nodes = found.motion + np.radians(found.shaft_angle_deg)[:, np.newaxis]
    assert np.allclose(nodes, np.radians(wanted.angle_deg)[:, np.newaxis], rtol=0.0, atol=2e-5)
    assert np.allclose(found.kinetic_energy, wanted.kinetic_energy, rtol=1e-3)
    assert found.energy_error < 1e-9


def test_run_up_under_gas_keeps_its_energy_and_a_governor_holds_the_speed():
    chain, forces = turning(gas=pressure(), damping=30.0, ground_damping=[4.0, 4.0, 0.0])
    mean = forces.mean_torque[0]

    def load(speed, _):
        return mean + 150.0 * (speed - SPEED)

    run = turn_under_gas(chain, 20.0, 1.0, load=load)
    assert run.complete
    assert run.energy_error < 1e-8
    assert run.damping_work[-1] < 0.0 < run.gas_work[-1]
    # By trapezoids of 2 deg; errors of their ends remain, the square of a step by the slope there.
    power = load(run.shaft_speed, 0.0) * run.speed[:, 2]
    assert np.trapezoid(power, run.time) == close(-run.load_work[-1], rel=1e-4)
    # Of 13 kg m^2 by 150 N m s/rad: exp(-1 s / 87 ms) of 10 rad/s is left after the run.
    turns = np.interp(
        np.radians(run.shaft_angle_deg)[-1] - 2.0 * np.pi * np.arange(3),
        np.radians(run.shaft_angle_deg),
        run.time,
    )
    assert turns[0] - turns[1] == close(turns[1] - turns[2], rel=1e-3)
    assert 2.0 * np.pi / (turns[0] - turns[1]) == close(SPEED, rel=0.05)
    assert run.envelope().torque.shape[1] == 2


def test_interrupted_and_stopping_runs_keep_what_is_finished():
    chain, forces = turning(gas=pressure(), damping=30.0)

    def stop(share):
        if share > 0.4:
            raise KeyboardInterrupt

    run = turn_under_gas(chain, SPEED, 0.8, load=forces.mean_torque[0], progress=stop)
    assert not run.complete
    assert 0.3 < run.time[-1] < 0.7
    assert run.notes[-1].startswith("Interrupted")
    silent, _ = turning(damping=30.0)
    braked = turn_under_gas(silent, SPEED, 2.0, load=600.0)
    assert not braked.complete
    assert braked.notes[-1].startswith("The shaft all but stops")
    assert abs(braked.shaft_speed[-1]) < 0.1 * SPEED
    assert braked.energy_error < 1e-8


@pytest.mark.slow
def test_misfire_takes_over():
    chain, _ = turning(gas=pressure(), damping=30.0)
    weaker = with_gas_share(chain, 0.5)
    run = turn_under_gas(chain, SPEED, 0.5, load=0.0, changes=((0.2, weaker),))
    plain = turn_under_gas(chain, SPEED, 0.2, load=0.0)
    assert np.interp(0.2, run.time, run.gas_work) == close(plain.gas_work[-1], rel=1e-6)
    assert run.energy_error < 1e-8
    gained = np.interp([0.2, 0.5], run.time, run.gas_work)
    whole = turn_under_gas(chain, SPEED, 0.5, load=0.0)
    assert np.diff(gained)[0] < 0.8 * np.diff(np.interp([0.2, 0.5], whole.time, whole.gas_work))[0]


def bad(message):
    chain, forces = turning(gas=pressure(), damping=30.0)
    own, ends = engine(), small_chain()
    heavy = EngineChain(Chain([0.1, 2.0, 9.0], [6e4, 2e4]), "torsional", throw_nodes=(0, 1))
    held = EngineChain(Chain([2.0, 2.0, 9.0], [6e4, 2e4], {2: 5.0}), "torsional", (0, 1))
    fewer = EngineChain(ends.chain, "torsional", throw_nodes=(0,))
    return {
        "mean_speed: given 0": lambda: steady_cycle(chain, 0.0),
        "speeds[1]: given inf": lambda: chain.mean_speed(np.array([1.0, np.inf, 1.0])),
        "speeds: given an array of shape (2,)": lambda: chain.mean_speed(np.ones(2)),
        "method: given 'Euler'": lambda: steady_cycle(chain, SPEED, method="Euler"),
        "start_speed: given -1": lambda: turn_under_gas(chain, -1.0, 1.0),
        "duration: given 0": lambda: turn_under_gas(chain, 1.0, 0.0),
        "load: given a moment of nan": lambda: turn_under_gas(
            chain, 9.0, 1.0, load=lambda *_: np.nan
        ),
        "changes[0]: given a time of 2 s": lambda: turn_under_gas(
            chain, 9.0, 1.0, changes=((2.0, chain),)
        ),
        "engine_chain: given 0.1 kg m^2": lambda: turning_chain(own, heavy, forces),
        "engine_chain: given torsional, held": lambda: turning_chain(own, held, forces),
        "engine_chain: given 1 throws": lambda: turning_chain(own, fewer, forces),
        "gas: given forces that hold": lambda: turning_chain(
            own, ends, cylinder_forces(own, [SPEED], HIGHEST)
        ),
        "load_node: given": lambda: turning_chain(own, ends, forces, load_node=3),
    }[message]


@pytest.mark.parametrize(
    "message",
    [
        "mean_speed: given 0",
        "speeds[1]: given inf",
        "speeds: given an array of shape (2,)",
        "method: given 'Euler'",
        "start_speed: given -1",
        "duration: given 0",
        "load: given a moment of nan",
        "changes[0]: given a time of 2 s",
        "engine_chain: given 0.1 kg m^2",
        "engine_chain: given torsional, held",
        "engine_chain: given 1 throws",
        "gas: given forces that hold",
        "load_node: given",
    ],
)
def test_bad_input_is_refused_in_one_sentence(message):
    act = bad(message)
    with pytest.raises(InputError) as error:
        act()
    text = str(error.value)
    assert text.startswith(message)
    assert "allowed" in text
    assert "because" in text


def test_a_cycle_that_takes_too_many_evaluations_is_given_up(monkeypatch):
    chain, _ = turning(gas=pressure(), damping=30.0)
    monkeypatch.setattr("dynamics.transient.turning_run.MOST_EVALUATIONS", 500)
    with pytest.raises(
        InputError, match=r"given 1e-06 rad/s; allowed is .* limit of 500 .* periods"
    ):
        steady_cycle(chain, 1e-6)
    monkeypatch.setattr("dynamics.transient.turning_run.MOST_EVALUATIONS", 500)
    with pytest.raises(InputError, match=r"duration: given .* \(a revolution takes more than"):
        turn_under_gas(chain, 1e-3, 1e4)
