"""Forced vibration of a whole crankshaft of simple throws, and the comparison with chains.

A throw here is a spring of six components between two masses at its ends; its pin moves as the mean of
what both ends carry there. So it is known what every force does.
"""

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.engine_chains import axial_chain, torsional_chain
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.chain_comparison import (
    ModeMatch,
    ResponseMatch,
    chain_verdict,
    followed_modes,
    matching_modes,
    matching_response,
)
from dynamics.crankshaft.coupled_response import (
    coupled_response,
    pins_of_cylinders,
    shaft_criticals,
    shaft_excitation,
)
from dynamics.crankshaft.shaft_modes import crankshaft_system
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
)
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation

RADIUS, LENGTH = 0.15, 0.4
AXIAL, TWIST, MASS, INERTIA = 1e9, 2e7, 100.0, 3.0
# Share of a throw's inertia left at its ends where the rest is at the pin.
LEFT = 1e-6


def carried(arm):
    """Motion (6, 6) of a place at an arm from a section, rigidly joined."""
    x, y, z = arm
    moved = np.eye(6)
    moved[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return moved


def spring_throw(angle=0.0, coupling=0.0):
    """A throw with half of its mass at either end, whose twist stretches it by `coupling`."""
    relative = np.hstack((-carried((0, 0, LENGTH / 2)), carried((0, 0, -LENGTH / 2))))
    springs = np.diag([5e9, 5e9, AXIAL, 5e7, 5e7, TWIST])
    springs[2, 5] = springs[5, 2] = coupling * math.sqrt(AXIAL * TWIST)
    body = np.diag([MASS, MASS, MASS, 3.0, 3.0, INERTIA]) / 2.0
    pin = np.hstack([0.5 * carried((0, RADIUS, side * LENGTH / 2)) for side in (1, -1)])
    return ShaftThrow(
        stiffness=relative.T @ springs @ relative,
        mass=np.kron(np.eye(2), body),
        pin_loads=pin.T[None],
        pins=[[0, RADIUS, LENGTH / 2]],
        length=LENGTH,
        crank_angle_deg=math.degrees(angle),
    )


AROUND = ShaftSurroundings(
    bearings=MainBearings(math.inf),
    axial_supports=(AxialSupport(3, 5e8),),
    flywheel=EndBody(400.0, 50.0),
)
ANGLES = np.radians([0.0, 120.0, 240.0])


def straight(coupling=0.0):
    """Three throws without offset mass: nothing is coupled unless `coupling` says so."""
    throws = [spring_throw(angle, coupling) for angle in ANGLES]
    return crankshaft_system(assemble_crankshaft(throws, AROUND))


@pytest.fixture(scope="module")
def forces():
    rng = np.random.default_rng(7)
    shape = (6, 40, 3)
    tangential, radial = (
        1e4 * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) for _ in range(2)
    )
    return SimpleNamespace(
        orders=np.arange(1, 7) * 0.5,
        speeds=np.linspace(100.0, 700.0, 40),
        tangential=tangential,
        radial=radial,
        throws=(0, 1, 2),
    )


def chains():
    """Of the straight shaft: masses at the sections, half inertias at both ends of a throw."""
    axial = axial_chain([1.0 / AXIAL] * 3, [MASS] * 3, 400.0, 3, 5e8)
    torsional = torsional_chain([1.0 / TWIST] * 3, [INERTIA] * 3, 50.0)
    return axial, torsional


def test_axial_chain_is_the_straight_shaft():
    shaft, (axial, _) = straight(), chains()
    matches = matching_modes(shaft, axial, 1e4)
    assert len(matches) == 4
    for match in matches:
        assert match.difference == close(0.0, abs=1e-9)
        assert (match.share, match.likeness) == close((1.0, 1.0), abs=1e-9)
    assert chain_verdict(matches).suffices


def test_coupling_makes_chains_insufficient():
    axial, _ = chains()
    matches = matching_modes(straight(0.3), axial, 1e4)
    verdict = chain_verdict(matches)
    assert not verdict.suffices
    assert any("%" in reason for reason in verdict.reasons)
    nothing = chain_verdict([ModeMatch("axial", 0, 50.0, None, None, 0.0, 0.0)])
    assert nothing.reasons == (
        "The whole shaft has no mode like the axial mode of the chain at 50.0 Hz.",
    )


def test_a_mode_that_coupling_divides_is_told_by_both(monkeypatch):
    """Equal chains with coupled springs: each mode becomes two, at sqrt(1 - c) and sqrt(1 + c) of it."""
    monkeypatch.setattr(sys.modules[__name__], "TWIST", AXIAL * INERTIA / MASS)
    around = replace(
        AROUND,
        axial_supports=(AxialSupport(3, 1.0),),
        flywheel=EndBody(400.0, 400.0 * INERTIA / MASS),
    )
    throws = [spring_throw(angle, 0.3) for angle in ANGLES]
    shaft = crankshaft_system(assemble_crankshaft(throws, around))
    chain = axial_chain([1.0 / AXIAL] * 3, [MASS] * 3, 400.0, 3, 1.0)
    match = matching_modes(shaft, chain, 1e4)[1]
    own = match.chain_frequency
    assert match.divided == tuple(
        (close(own * math.sqrt(1.0 + sign * 0.3)), close(0.5)) for sign in (-1.0, 1.0)
    )
    (reason,) = chain_verdict([match]).reasons
    assert reason == (
        f"The whole shaft has two modes like the axial mode of the chain at {own:.1f} Hz: "
        f"{own * math.sqrt(0.7):.1f} Hz (50 % axial) and {own * math.sqrt(1.3):.1f} Hz (50 % axial)."
    )
    assert matching_modes(straight(), chains()[0], 1e4)[0].divided == ()


def test_modes_that_cross_are_followed_by_their_shapes():
    """Two masses on springs of their own, a weak one between: the stiffer becomes the softer one."""
    mass = np.diag([2.0, 3.0])
    shapes = []
    for ratio in (0.25, 0.5, 2.0, 4.0):
        stiffness = np.diag([2.0, 3.0 * ratio]) + 0.02 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        shapes.append(eigh(stiffness, mass)[1])
    assert followed_modes(mass, shapes).tolist() == [[0, 1], [0, 1], [1, 0], [1, 0]]


def test_no_mode_of_the_shaft_stands_for_two_of_the_chain():
    matches = matching_modes(straight(0.9), chains()[0], 1e4)
    taken = [match.shaft_mode for match in matches if match.shaft_mode is not None]
    assert len(taken) == len(set(taken)) > 1


def test_tangential_forces_move_the_free_end_only_where_torsion_is_coupled(forces):
    """The torque of a straight shaft stays in torsion; with a coupled spring it shows at the end."""
    plain = coupled_response(straight(), forces)
    split = plain.split("main bearing 1 uz")
    # Nothing but rounding: the pin of a straight shaft has no way to push along it.
    assert split.both_sum.max() < 1e-15
    coupled = coupled_response(straight(0.3), forces).split("main bearing 1 uz")
    assert coupled.tangential_sum.min() > 1e-8
    assert np.all(coupled.both <= coupled.tangential + coupled.radial + 1e-18)


def test_both_kinds_of_force_together_are_their_sum(forces):
    shaft = straight(0.3)
    answer = coupled_response(shaft, forces, modal_damping=0.02)
    whole = forced_response(
        shaft.system.with_modal_damping(0.02), shaft_excitation(shaft, forces), method="direct"
    )
    row = shaft.point("pin 2 tangential")
    # Modal against direct: what is allowed of the modal answer's residual, times the peak's magnifier.
    largest = np.abs(whole.motion[:, :, row]).max()
    assert (
        np.abs(answer.motion("pin 2 tangential") - whole.motion[:, :, row]).max() < 1e-8 * largest
    )
    assert not answer.unbounded.any()


@pytest.mark.slow
def test_critical_speeds_are_all_peaks_of_single_orders(forces):
    """Every local maximum on a grid ten times as fine is there, unless it is small at its place."""
    shaft = straight(0.3)
    fine = np.linspace(100.0, 700.0, 20001)

    def answer(speeds):
        one = (slice(None), slice(0, 1))
        steady = {
            name: np.repeat(getattr(forces, name)[one], speeds.size, axis=1)
            for name in ("tangential", "radial")
        }
        own = SimpleNamespace(**vars(forces) | steady | {"speeds": speeds})
        return coupled_response(shaft, own, modal_damping=0.01)

    coarse = answer(fine[::10])
    found, _ = shaft_criticals(coarse, coarse.bearing_torques, (150.0, 650.0))
    assert len(found) > 3
    sizes = np.abs(answer(fine).torque.values)
    rising = sizes[:, 1:-1] > np.maximum(sizes[:, :-2], sizes[:, 2:])
    inside = (fine[1:-1] > 150.0) & (fine[1:-1] < 650.0)
    peaks = np.argwhere(rising & inside[:, np.newaxis])
    heights = sizes[peaks[:, 0], peaks[:, 1] + 1, peaks[:, 2]]
    largest = np.array([heights[peaks[:, 2] == place].max(initial=0.0) for place in range(4)])
    for (order, index, place), height in zip(peaks.tolist(), heights.tolist(), strict=True):
        if height < 0.05 * largest[place]:
            continue
        near = [
            one
            for one in found
            if one.order == forces.orders[order] and one.speed == close(fine[index + 1], 0.03)
        ]
        assert near
        assert max(one.amplitude for one in near) > 0.999 * height
    natural = shaft.system.elastic_frequencies
    for one in found:
        if one.in_band:
            assert one.undamped_speed == close(
                2.0 * math.pi * natural[one.mode - 1] / one.order, 1e-9
            )
            assert one.frequency == close(one.mode_frequency, 0.03)
            assert one.damping_ratio == close(0.01)


def test_torque_of_the_chain_is_that_of_the_pins(forces):
    """With the inertia at its throws' middles, the shaft in torsion is the chain.

    The shape is the pin's turning beyond the mean of both ends: two springs of 2 k with the pin between
    are one spring k of the ends and one of 4 k of the shape.
    """
    throws = []
    for angle in ANGLES:
        base = spring_throw(angle)
        stiffness, mass = np.zeros((2, 13, 13))
        stiffness[:12, :12], mass[:12, :12] = base.stiffness, base.mass
        stiffness[12, 12] = 4.0 * TWIST
        mass[[5, 11], [5, 11]] = LEFT * INERTIA
        turning = np.zeros(13)
        turning[[5, 11, 12]] = 0.5, 0.5, 1.0
        mass += INERTIA * np.outer(turning, turning)
        own = np.array([[-RADIUS, 0.0, 0.0, 0.0, 0.0, 1.0]])
        pins = np.concatenate((base.pin_loads, own[None]), axis=1)
        throws.append(
            ShaftThrow(
                stiffness, mass, pins, base.pins, LENGTH, crank_angle_deg=math.degrees(float(angle))
            )
        )
    shaft = crankshaft_system(assemble_crankshaft(throws, AROUND), 2000.0)
    _, torsional = chains()
    matches = matching_modes(shaft, torsional, 300.0)
    assert len(matches) == 1
    # The ends' share of the inertia is what both differ by.
    assert abs(matches[0].difference) < 5.0 * LEFT
    assert matches[0].share == close(1.0, abs=1e-9)
    assert matches[0].likeness == close(1.0, abs=1e-6)
    torques = np.zeros((6, 40, 4), dtype=complex)
    torques[:, :, :3] = RADIUS * forces.tangential
    by_chain = forced_response(
        torsional.chain, OrderExcitation(forces.orders, forces.speeds, torques), modal_damping=0.05
    )
    coupled = coupled_response(shaft, forces, modal_damping=0.05)
    found = matching_response(coupled, torsional, by_chain)
    assert found.chain == close(found.shaft, rel=100.0 * LEFT)
    assert chain_verdict(matches, found).suffices
    other = OrderExcitation(forces.orders[:2], forces.speeds, torques[:2])
    shorter = forced_response(torsional.chain, other)
    with pytest.raises(InputError, match="answer: given"):
        matching_response(coupled, torsional, shorter)


def test_an_undamped_resonance_is_unbounded(forces):
    shaft = straight(0.3)
    natural = shaft.system.natural[1]
    at_resonance = SimpleNamespace(
        orders=np.array([2.0]),
        speeds=np.array([0.4 * natural, 0.5 * natural]),
        tangential=forces.tangential[:1, :2],
        radial=forces.radial[:1, :2],
        throws=(0, 1, 2),
    )
    answer = coupled_response(shaft, at_resonance, magnifier=None)
    assert answer.unbounded.tolist() == [[False, True]]
    assert answer.split("main bearing 1 uz").both_sum.tolist()[1] == math.inf
    match = ResponseMatch("axial", at_resonance.speeds, np.ones(2), np.array([1.0, np.inf]))
    assert match.difference == math.inf


def test_pins_of_cylinders():
    assert pins_of_cylinders((0, 1), (0, 1, 0, 1)) == (0, 1, 0, 1)
    assert pins_of_cylinders((0, 0, 1, 1), (0, 0, 1, 1), (0, 1, 2, 3)) == (0, 1, 2, 3)
    for arguments in (((0, 0), (0, 0)), ((0, 1), (0, 2)), ((0, 1), (0, 1), (0,))):
        with pytest.raises(InputError, match=r"^pins: given .*; allowed .*because"):
            pins_of_cylinders(*arguments)


def test_torque_at_the_last_bearing_is_what_turns_the_flywheel(forces):
    free_end = EndBody(20.0, 2.0)
    around = replace(AROUND, free_end=free_end, pin_masses=(12.0, 8.0, 5.0))
    throws = [spring_throw(angle, 0.3) for angle in ANGLES]
    for sense in (1, -1):
        shaft = crankshaft_system(assemble_crankshaft(throws, around, turning_sense=sense))
        found = coupled_response(shaft, forces, magnifier=1e9)
        torque = found.torque.values
        w = (forces.orders[:, np.newaxis] * forces.speeds) ** 2
        turned = w * found.motion("main bearing 4 rz")
        largest = np.max(np.abs(torque))
        assert torque[:, :, -1] == close(50.0 * turned, abs=1e-6 * largest)
        # Beyond the first bearing there is the free end alone.
        first = -w * free_end.polar_inertia * found.motion("main bearing 1 rz")
        assert torque[:, :, 0] == close(first, abs=1e-6 * largest)
        # Between two bearings torque changes by the forces on the pin, and by what turns there.
        pins = forces.tangential[:, :, 1] * sense * RADIUS
        turning = sum(0.5 * INERTIA * w * found.motion(f"main bearing {n} rz") for n in (2, 3))
        rod = 8.0 * RADIUS * w * sense * found.motion("pin 2 tangential")
        assert torque[:, :, 2] - torque[:, :, 1] == close(
            -(pins + turning + rod), abs=1e-6 * largest
        )
