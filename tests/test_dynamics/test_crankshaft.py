"""The whole crankshaft, of throws whose matrices are those of beams, and with a shaft line."""

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.engine_chains import axial_chain, torsional_chain
from dynamics.chains.varying import Variation
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.chain_comparison import (
    ChainVerdict,
    ModeMatch,
    ResponseMatch,
    followed_modes,
    match_modes,
    matching_modes,
    matching_response,
    mode_likeness,
)
from dynamics.crankshaft.coupled_response import (
    coupled_response,
    pins_of_cylinders,
    shaft_criticals,
)
from dynamics.crankshaft.shaft_modes import crankshaft_modes, crankshaft_system, rotation_ratio
from dynamics.crankshaft.surroundings import (
    RZ,
    UZ,
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
    TorsionalRing,
    rotation,
)
from dynamics.response.forced import forced_response
from dynamics.response.loads import checked_power_balance
from dynamics.response.order_excitation import OrderExcitation
from refusals import refusals, refused

E, NU, RHO = 210e9, 0.3, 7850.0
RADIUS, LENGTH, THICK = 0.17, 0.4, 0.15


def beam(start, end, diameter=THICK):
    """Stiffness and mass (12, 12) of a round beam between two points, in the global frame."""
    along = end - start
    length = np.linalg.norm(along)
    z = along / length
    x = np.array([1.0, 0.0, 0.0])
    frame = np.array([x, np.cross(z, x), z])
    area, second = math.pi / 4.0 * diameter**2, math.pi / 64.0 * diameter**4
    shear = E / (2.0 * (1.0 + NU))
    stiffness, mass = np.zeros((2, 12, 12))
    for place, k, m in ((2, E * area, RHO * area), (5, 2.0 * shear * second, 2.0 * RHO * second)):
        ends = np.ix_([place, 6 + place], [place, 6 + place])
        stiffness[ends] = k / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[ends] = m * length / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    # Deflection w with slope dw/dz: x with rotation ry, y with -rx.
    h = length
    bend = np.array([[6, 3 * h, -6, 3 * h], [0, 2 * h * h, -3 * h, h * h]])
    bend = np.vstack((bend, [[0, 0, 6, -3 * h], [0, 0, 0, 2 * h * h]]))
    inertia = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h * h, 13 * h, -3 * h * h]])
    inertia = np.vstack((inertia, [[0, 0, 156, -22 * h], [0, 0, 0, 4 * h * h]]))
    bend, inertia = (half + np.triu(half, 1).T for half in (2.0 * bend, inertia))
    for places, sign in (((0, 4), 1.0), ((1, 3), -1.0)):
        rows = [places[0], places[1], 6 + places[0], 6 + places[1]]
        signs = np.array([1.0, sign, 1.0, sign])
        both = np.outer(signs, signs)
        stiffness[np.ix_(rows, rows)] += both * E * second / h**3 * bend
        mass[np.ix_(rows, rows)] += both * RHO * area * h / 420.0 * inertia
    turn = np.kron(np.eye(4), frame)
    return turn.T @ stiffness @ turn, turn.T @ mass @ turn


def beam_throw():
    """Matrices of a throw in its own frame: both ends, then four corners and the pin's middle."""
    height = (0.0, 0.0, RADIUS, RADIUS, RADIUS, 0.0, 0.0)
    along = (0.0, 0.1, 0.1, 0.2, 0.3, 0.3, 0.4)
    points = np.array([[0.0, y, z] for y, z in zip(height, along, strict=True)])
    nodes = [0, 2, 3, 4, 5, 6, 1]
    stiffness, mass = np.zeros((2, 42, 42))
    for one, other in zip(range(6), range(1, 7), strict=True):
        k, m = beam(points[one], points[other])
        rows = np.r_[6 * nodes[one] : 6 * nodes[one] + 6, 6 * nodes[other] : 6 * nodes[other] + 6]
        stiffness[np.ix_(rows, rows)] += k
        mass[np.ix_(rows, rows)] += m
    pin = np.zeros((1, 42, 6))
    pin[0, 6 * nodes[3] : 6 * nodes[3] + 6] = np.eye(6)
    # Amplitudes vanish in rigid motion: inner motions are counted from the static answer to the ends.
    ends, inside = slice(0, 12), slice(12, 42)
    follow = np.eye(42)
    follow[inside, ends] = -np.linalg.solve(stiffness[inside, inside], stiffness[inside, ends])
    return follow.T @ stiffness @ follow, follow.T @ mass @ follow, follow.T @ pin[0]


STIFFNESS, MASS, PIN = beam_throw()


def shaft_of(degrees, around=None, **options):
    throws = [
        ShaftThrow(STIFFNESS, MASS, PIN[None], [[0.0, RADIUS, 0.2]], LENGTH, crank_angle_deg=angle)
        for angle in degrees
    ]
    return assemble_crankshaft(throws, around, **options)


AROUND = ShaftSurroundings(
    bearings=MainBearings([1e9, 2e9, math.inf, 2e9, 1e9], 1e4),
    axial_supports=(AxialSupport(4, 1e9, 1e4), AxialSupport(0, 0.0, 2e5)),
    flywheel=EndBody(800.0, 120.0, 70.0, 0.1),
    free_end=EndBody(30.0, 1.5, overhang=0.05),
    ring=TorsionalRing(2.0, 0.0, 800.0),
    machine=TorsionalRing(60.0, 5e6, loss_factor=0.1),
    pin_masses=(20.0, 20.0, 30.0, 20.0),
    loss_factor=0.01,
)
CRANKS = (0.0, 90.0, 270.0, 180.0)


@pytest.fixture(scope="module")
def surrounded():
    return shaft_of(CRANKS, AROUND)


def test_free_shaft_has_six_rigid_motions_by_name():
    shaft = shaft_of(CRANKS)
    modes = crankshaft_modes(shaft)
    assert modes.rigid == 6
    assert modes.names[:6] == (
        "rotation about the shaft axis",
        "axial translation",
        "translation along x",
        "translation along y",
        "tilt about x",
        "tilt about y",
    )
    assert modes.angular_frequencies[:6].tolist() == [0.0] * 6
    assert modes.angular_frequencies[6] > 100.0
    assert modes.kinds[:6] == ("torsional", "axial", *("bending",) * 4)
    assert modes.shares[:, :6].max(axis=0) == close(np.ones(6), abs=1e-12)
    left = shaft.stiffness @ shaft.rigid
    # Round-off of the largest stiffness.
    assert np.abs(left).max() < 1e-12 * np.abs(shaft.stiffness).max()
    # The mass moved along and the inertia turned are those of all throws.
    throw = ShaftThrow(STIFFNESS, MASS, PIN[None], [[0.0, RADIUS, 0.2]], LENGTH)
    found = np.diag(shaft.rigid.T @ shaft.mass @ shaft.rigid)
    mass, inertia = throw.rigid_inertia()
    assert mass == close(RHO * math.pi / 4.0 * THICK**2 * (LENGTH + 2.0 * RADIUS))
    assert found[:4] == close([4 * inertia, 4 * mass, 4 * mass, 4 * mass])


def test_elastic_modes_are_those_of_the_matrices(surrounded):
    """The same by a general solver, which sees rigid motions as small numbers."""
    modes = crankshaft_modes(surrounded)
    squares = eigh(surrounded.stiffness, surrounded.mass, eigvals_only=True)
    # Round-off of the highest frequency is what the general solver leaves.
    assert modes.angular_frequencies**2 == close(squares, abs=1e-11 * squares[-1])


def test_a_straight_shaft_has_pure_modes():
    """Without an offset nothing is coupled: shares are one, and the first mode of torsion is known."""
    points = [np.array([0.0, 0.0, z]) for z in (0.0, 0.2, 0.4)]
    stiffness, mass = np.zeros((2, 18, 18))
    for rows, ends in (((0, 2), (0, 1)), ((2, 1), (1, 2))):
        k, m = beam(points[ends[0]], points[ends[1]])
        places = np.r_[6 * rows[0] : 6 * rows[0] + 6, 6 * rows[1] : 6 * rows[1] + 6]
        stiffness[np.ix_(places, places)] += k
        mass[np.ix_(places, places)] += m
    inside = slice(12, 18)
    follow = np.eye(18)
    follow[inside, :12] = -np.linalg.solve(stiffness[inside, inside], stiffness[inside, :12])
    pin = follow.T[:, inside]
    # A "pin" hardly aside of the axis, for one on it has no radial direction.
    throw = ShaftThrow(
        follow.T @ stiffness @ follow, follow.T @ mass @ follow, pin[None], [[0, 1e-9, 0.2]], 0.4
    )
    modes = crankshaft_modes(assemble_crankshaft([throw] * 5))
    for mode in range(6, 14):
        assert modes.shares[:, mode].max() == close(1.0, abs=1e-6)
    first = modes.first("torsional")
    speed = math.sqrt(E / (2.0 * (1.0 + NU)) / RHO)
    # Ten elements with consistent mass are 0.4 % high: (pi / 10)^2 / 24.
    exact = speed / (2.0 * 5 * 0.4)
    assert modes.frequencies[first] == close(exact * (1.0 + (math.pi / 10) ** 2 / 24), rel=1e-3)


@pytest.mark.parametrize("highest", [None, 600.0, 150.0])
def test_static_answers_are_exact_however_many_modes_are_left_out(highest):
    # Ring and machine alone vibrate above 1 kHz, so that their modes are among those left out.
    around = ShaftSurroundings(
        bearings=MainBearings(1e9, 1e4),
        axial_supports=(AxialSupport(4, 1e9),),
        flywheel=EndBody(800.0, 120.0),
        ring=TorsionalRing(2.0, 1e8, 800.0),
        machine=TorsionalRing(60.0, 5e9),
    )
    shaft = shaft_of(CRANKS, around)
    reduced = crankshaft_system(shaft, highest)
    assert (reduced.corrections > 0) == (highest is not None)
    # Forces on pins that do not turn the shaft as a whole: it has no support against that.
    loads = np.zeros(len(shaft.names))
    for name, value in (
        ("pin 1 tangential", 1e4),
        ("pin 3 tangential", -1e4),
        ("pin 2 radial", 2e4),
        ("pin 4 radial", -5e3),
        ("main bearing 1 uz", 3e3),
        ("main bearing 3 ux", 1e4),
        ("damper ring", 2e3),
        ("driven machine", -2e3),
    ):
        loads[shaft.names.index(name)] = value
    exact = np.linalg.lstsq(shaft.stiffness, shaft.expand.T @ loads, rcond=1e-13)[0]
    turning = shaft.rigid[:, 0]
    exact -= turning * (turning @ shaft.mass @ exact) / (turning @ shaft.mass @ turning)
    system = reduced.system
    work = system.expand.T @ loads
    assert abs(work[0]) < 1e-6
    answer = system.expand[:, 1:] @ (work[1:] / system.natural[1:] ** 2)
    whole = shaft.expand @ exact
    # Rounding of the least squares solution, whose matrix has a condition of 1e7.
    assert answer == close(whole, abs=1e-7 * np.abs(whole).max())


def test_bearings_over_the_speed_and_a_coupling_over_the_frequency():
    """The motion is that of the matrices made anew at each speed, with bearings and coupling as there."""
    over_speed = Variation(speed=(0.0, 200.0), stiffness=(1.0, 3.0), damping=(1.0, 0.5))
    over_hz = Variation(frequency=(0.0, 50.0), stiffness=(1.0, 1.5), loss_factor=(0.1, 0.2))
    orders, speeds = np.array([1.0, 2.0]), np.array([60.0, 150.0])

    def system(speed, w, *varying):
        film, oil = (np.interp(speed, (0.0, 200.0), ends) for ends in ((2e8, 6e8), (1e4, 5e3)))
        hz = w / (2.0 * math.pi)
        rubber, loss = (np.interp(hz, (0.0, 50.0), ends) for ends in ((4e6, 6e6), (0.1, 0.2)))
        around = ShaftSurroundings(
            bearings=MainBearings(film, oil, *varying[:1]),
            machine=TorsionalRing(30.0, rubber, 0.0, loss, *varying[1:]),
            axial_supports=[AxialSupport(0, 1e9, 1e4)],
        )
        return crankshaft_system(shaft_of([0.0, 180.0], around)).system

    varying = system(0.0, 0.0, over_speed, over_hz)
    forces = np.zeros((2, 2, len(varying.expand)), complex)
    forces[:, :, varying.expand.shape[0] // 2 :] = 1.0 + 0.5j
    answer = forced_response(varying, OrderExcitation(orders, speeds, forces))
    for k, order in enumerate(orders):
        for s, speed in enumerate(speeds):
            w = order * speed
            fixed = system(speed, w)
            matrix = fixed.stiffness + 1j * (fixed.loss + w * fixed.damping) - w**2 * fixed.mass
            motion = fixed.expand @ np.linalg.solve(matrix, forces[k, s] @ fixed.expand)
            assert answer.motion[k, s] == close(motion, abs=1e-9 * np.max(np.abs(motion)))
    checked_power_balance(answer)


def test_masses_at_pins_add_what_rods_add(surrounded):
    mass = 30.0
    bare, laden = shaft_of(CRANKS), shaft_of(CRANKS, ShaftSurroundings(pin_masses=[mass] * 4))
    added = np.diag(laden.rigid.T @ (laden.mass - bare.mass) @ laden.rigid)
    assert added[:4] == close([4 * mass * RADIUS**2, 0.0, 4 * mass, 4 * mass], abs=1e-9)
    # A body's own center counts: mass, and inertia about its section by Steiner's theorem.
    body = EndBody(10.0, 0.4, 0.3, 0.2).mass_matrix(1.0)
    assert body[3, 3] == close(0.3 + 10.0 * 0.2**2)
    assert (body[0, 4], body[1, 3]) == (2.0, -2.0)


def test_turning_a_vector_about_the_shaft():
    assert rotation(math.pi / 2) @ [0.0, 1.0, 0.0] == close([-1.0, 0.0, 0.0], abs=1e-15)


def test_rotation_ratio():
    assert rotation_ratio(100.0, np.array([400.0, 1000.0])) == close([0.25, 0.1])


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: assemble_crankshaft([]), "throws"),
        (lambda: shaft_of(CRANKS, ShaftSurroundings(bearings=MainBearings([1e9] * 4))), "bearings"),
        (lambda: shaft_of(CRANKS, ShaftSurroundings(bearings=MainBearings(-1.0))), "bearings"),
        (lambda: shaft_of(CRANKS, ShaftSurroundings(pin_masses=[1.0])), "pin_masses"),
        (
            lambda: shaft_of(CRANKS, ShaftSurroundings(axial_supports=[AxialSupport(9, 1.0)])),
            "axial",
        ),
        (lambda: shaft_of(CRANKS, turning_sense=0), "turning_sense"),
        (lambda: AxialSupport(0, math.nan), "axial support stiffness"),
        (lambda: TorsionalRing(1.0), "ring"),
        (lambda: EndBody(-1.0, 1.0), "mass"),
        (lambda: ShaftThrow(STIFFNESS, MASS, PIN[None], [[0, 0, 0.2]], 0.4), "pins"),
        (
            lambda: ShaftThrow(STIFFNESS + np.triu(STIFFNESS), MASS, PIN[None], [[0, 1, 0]], 1),
            "stiff",
        ),
        (lambda: crankshaft_system(shaft_of(CRANKS), -5.0), "highest_frequency"),
        (lambda: shaft_of(range(101)), "throws"),
        (lambda: ShaftThrow(STIFFNESS, MASS, PIN[None], [0.0, 1.0, 0.0], 1.0), "pins"),
        (lambda: ShaftThrow(STIFFNESS, MASS, PIN, [[0.0, 1.0, 0.0]], 1.0), "pin_loads"),
        (lambda: ShaftThrow(STIFFNESS[:6, :6], MASS, PIN[None], [[0, 1, 0]], 1.0), "stiffness"),
        (lambda: ChainVerdict(()), "modes"),
        (lambda: mode_likeness(shaft_of(CRANKS), None, chains()[0], [1]), "chain"),
    ],
)
def test_refused(make, field):
    with pytest.raises(InputError, match=rf"^{field}.*given .*; allowed .*because"):
        make()


SPRING_RADIUS, SPRING_LENGTH = 0.15, 0.4
AXIAL, TWIST, SPRING_MASS, INERTIA = 1e9, 2e7, 100.0, 3.0
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
    relative = np.hstack((-carried((0, 0, SPRING_LENGTH / 2)), carried((0, 0, -SPRING_LENGTH / 2))))
    springs = np.diag([5e9, 5e9, AXIAL, 5e7, 5e7, TWIST])
    springs[2, 5] = springs[5, 2] = coupling * math.sqrt(AXIAL * TWIST)
    body = np.diag([SPRING_MASS, SPRING_MASS, SPRING_MASS, 3.0, 3.0, INERTIA]) / 2.0
    pin = np.hstack(
        [0.5 * carried((0, SPRING_RADIUS, side * SPRING_LENGTH / 2)) for side in (1, -1)]
    )
    return ShaftThrow(
        stiffness=relative.T @ springs @ relative,
        mass=np.kron(np.eye(2), body),
        pin_loads=pin.T[None],
        pins=[[0, SPRING_RADIUS, SPRING_LENGTH / 2]],
        length=SPRING_LENGTH,
        crank_angle_deg=math.degrees(angle),
    )


SPRING_AROUND = ShaftSurroundings(
    bearings=MainBearings(math.inf),
    axial_supports=(AxialSupport(3, 5e8),),
    flywheel=EndBody(400.0, 50.0),
)
ANGLES = np.radians([0.0, 120.0, 240.0])


def straight(coupling=0.0):
    """Three throws without offset mass: nothing is coupled unless `coupling` says so."""
    throws = [spring_throw(angle, coupling) for angle in ANGLES]
    return crankshaft_system(assemble_crankshaft(throws, SPRING_AROUND))


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
    axial = axial_chain([1.0 / AXIAL] * 3, [SPRING_MASS] * 3, 400.0, 3, 5e8)
    return axial, torsional_chain([1.0 / TWIST] * 3, [INERTIA] * 3, 50.0)


def test_coupling_makes_chains_insufficient():
    axial, _ = chains()
    verdict = ChainVerdict(matching_modes(straight(0.3), axial, 1e4))
    assert not verdict.suffices
    assert verdict.reasons
    assert len(ChainVerdict((ModeMatch("axial", 0, 50.0, None, None, 0.0, 0.0),)).reasons) == 1


def test_a_mode_that_coupling_divides_is_told_by_both(monkeypatch):
    """Equal chains with coupled springs: each mode becomes two, at sqrt(1 - c) and sqrt(1 + c) of it."""
    monkeypatch.setattr(sys.modules[__name__], "TWIST", AXIAL * INERTIA / SPRING_MASS)
    around = replace(
        SPRING_AROUND,
        axial_supports=(AxialSupport(3, 1.0),),
        flywheel=EndBody(400.0, 400.0 * INERTIA / SPRING_MASS),
    )
    throws = [spring_throw(angle, 0.3) for angle in ANGLES]
    shaft = crankshaft_system(assemble_crankshaft(throws, around))
    chain = axial_chain([1.0 / AXIAL] * 3, [SPRING_MASS] * 3, 400.0, 3, 1.0)
    match = matching_modes(shaft, chain, 1e4)[1]
    own = match.chain_frequency
    assert match.divided == tuple(
        (close(own * math.sqrt(1.0 + sign * 0.3)), close(0.5)) for sign in (-1.0, 1.0)
    )
    assert len(ChainVerdict((match,)).reasons) == 1
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
        own = np.array([[-SPRING_RADIUS, 0.0, 0.0, 0.0, 0.0, 1.0]])
        throws.append(
            ShaftThrow(
                stiffness,
                mass,
                np.concatenate((base.pin_loads, own[None]), axis=1),
                base.pins,
                SPRING_LENGTH,
                crank_angle_deg=math.degrees(float(angle)),
            )
        )
    shaft = crankshaft_system(assemble_crankshaft(throws, SPRING_AROUND), 2000.0)
    _, torsional = chains()
    matches = matching_modes(shaft, torsional, 300.0)
    assert len(matches) == 1
    # The ends' share of the inertia is what both differ by.
    assert abs(matches[0].difference) < 5.0 * LEFT
    assert matches[0].share == close(1.0, abs=1e-9)
    assert matches[0].likeness == close(1.0, abs=1e-6)
    torques = np.zeros((6, 40, 4), dtype=complex)
    torques[:, :, :3] = SPRING_RADIUS * forces.tangential
    by_chain = forced_response(
        torsional.chain, OrderExcitation(forces.orders, forces.speeds, torques), modal_damping=0.05
    )
    coupled = coupled_response(shaft, forces, modal_damping=0.05)
    found = matching_response(coupled, torsional, by_chain)
    assert found.chain == close(found.shaft, rel=100.0 * LEFT)
    assert ChainVerdict(matches, found).suffices
    other = OrderExcitation(forces.orders[:2], forces.speeds, torques[:2])
    shorter = forced_response(torsional.chain, other)
    with refused("answer"):
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
        with refused("pins"):
            pins_of_cylinders(*arguments)


def test_torque_at_the_last_bearing_is_what_turns_the_flywheel(forces):
    free_end = EndBody(20.0, 2.0)
    around = replace(SPRING_AROUND, free_end=free_end, pin_masses=(12.0, 8.0, 5.0))
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
        pins = forces.tangential[:, :, 1] * sense * SPRING_RADIUS
        turning = sum(0.5 * INERTIA * w * found.motion(f"main bearing {n} rz") for n in (2, 3))
        rod = 8.0 * SPRING_RADIUS * w * sense * found.motion("pin 2 tangential")
        assert torque[:, :, 2] - torque[:, :, 1] == close(
            -(pins + turning + rod), abs=1e-6 * largest
        )


LINE_RADIUS, LINE_LENGTH, THROWS = 0.17, 0.4, 4
LINE_TWIST, LINE_INERTIA, ALONG, LINE_MASS = 2e7, 8.0, 3e9, 120.0
# Stiff across the shaft, so that torsion is alone; a section without any inertia has no motion.
STIFF, LINE_LEFT = 1e11, 1e-7
FLYWHEEL, FREE_END = 60.0, 3.0
# Error of an eigenvalue [rad^2/s^2]: round-off of the largest, that of the sections almost without inertia.
ROUND_OFF = 4.0 * np.finfo(float).eps * LINE_TWIST / (LINE_LEFT * LINE_INERTIA)


def twisting_throw(angle_deg):
    """Two springs 2 k with the inertia at the pin between: a spring k of the ends, 4 k of the pin's shape."""
    relative = np.zeros((6, 13))
    for first, arm in ((0, LINE_LENGTH / 2.0), (6, -LINE_LENGTH / 2.0)):
        side = np.eye(6)
        side[0, 4], side[1, 3] = arm, -arm
        relative[:, first : first + 6] = side if first else -side
    springs = np.diag([STIFF, STIFF, ALONG, STIFF, STIFF, LINE_TWIST])
    stiffness = relative.T @ springs @ relative
    body = [LINE_MASS / 2.0] * 3 + [3.0, 3.0, LINE_LEFT * LINE_INERTIA]
    mass = np.diag([*body, *body, 0.0])
    stiffness[12, 12] = 4.0 * LINE_TWIST
    turning = np.zeros(13)
    turning[[RZ, RZ + 6, 12]] = 0.5, 0.5, 1.0
    mass += LINE_INERTIA * np.outer(turning, turning)
    pin = np.zeros((6, 13))
    pin[RZ] = turning
    pin[0] = -LINE_RADIUS * turning
    pin[2, [UZ, UZ + 6]] = 0.5
    return ShaftThrow(
        stiffness,
        mass,
        pin.T[None],
        [[0.0, LINE_RADIUS, LINE_LENGTH / 2.0]],
        LINE_LENGTH,
        crank_angle_deg=angle_deg,
    )


def whole(line, *, kind="torsional", **around):
    surroundings = ShaftSurroundings(
        bearings=MainBearings(STIFF),
        axial_supports=(AxialSupport(THROWS, 5e8),),
        flywheel=EndBody(400.0, FLYWHEEL),
        free_end=EndBody(10.0, FREE_END),
        **{f"{kind}_line": line},
        **around,
    )
    throws = [twisting_throw(angle) for angle in (0.0, 180.0, 180.0, 0.0)]
    return assemble_crankshaft(throws, surroundings)


def chain(line):
    return torsional_chain(
        [1.0 / LINE_TWIST] * THROWS, [LINE_INERTIA] * THROWS, FLYWHEEL, FREE_END, shaft_line=line
    )


def of_kind(shaft, kind):
    """Natural frequencies of the modes of one kind [Hz], rigid ones included."""
    modes = crankshaft_modes(shaft)
    return modes.frequencies[modes.shares[("axial", "torsional").index(kind)] > 0.999]


size = st.floats(0.2, 5.0)


@st.composite
def lines(draw):
    """Lines with a branch through a gear, couplings, dashpots, and sometimes a spring to ground."""
    ratio = draw(st.sampled_from([-2.5, -1.0, 0.4, 1.0, 3.0]))
    return Chain(
        [draw(size) for _ in range(6)],
        [1e6 * draw(size) for _ in range(4)],
        connections=[(0, 1), (1, 2), (3, 4), (4, 5)],
        ground={5: 1e5} if draw(st.booleans()) else None,
        damping=[0.0, 200.0 * draw(size), 0.0, 100.0],
        loss_factor=[0.05 * draw(size), 0.0, 0.02, 0.0],
        ground_damping={2: 50.0},
        distributed_inertia=[0.0, 0.3, 0.0, 0.0],
        dashpots=[Dashpot(2, 5, 30.0)] if draw(st.booleans()) else (),
        gears=[Gear(draw(st.sampled_from([0, 1])), 3, ratio)],
        names=["flange", "coupling", "propeller", "pinion", "shaft", "pump"],
    )


@pytest.mark.slow
@given(lines())
@settings(max_examples=15)
def test_frequencies_are_those_of_the_chain_with_its_line(line):
    shaft, own = whole(line), chain(line)
    modes = own.chain.modes()
    low = modes.frequencies < 2000.0
    found = of_kind(shaft, "torsional")
    eigenvalues = (2.0 * np.pi * modes.frequencies[low]) ** 2
    assert (2.0 * np.pi * found[: low.sum()]) ** 2 == close(eigenvalues, rel=2e-6, abs=ROUND_OFF)
    assert (
        np.abs(shaft.stiffness @ shaft.rigid).max(initial=0.0)
        < 1e-9 * np.abs(shaft.stiffness).max()
    )
    # Each mode is found again, with its share of strain in the crankshaft.
    wanted = np.flatnonzero(low)[modes.rigid :].tolist()
    shaft_modes = crankshaft_modes(shaft)
    near = 1e-6 + 0.5 * ROUND_OFF / eigenvalues[modes.rigid]
    for match in match_modes(shaft, shaft_modes, own, wanted):
        assert (match.difference, match.likeness) == (close(0.0, abs=near), close(1.0, abs=1e-5))


@pytest.mark.slow
@given(lines())
@settings(max_examples=10)
def test_forces_on_pins_and_propeller_make_the_motion_of_the_chain(line):
    crankshaft, own = crankshaft_system(whole(line), 3000.0), chain(line)
    rng = np.random.default_rng(5)
    orders, speeds = np.array([0.5, 1.0, 3.0]), np.linspace(30.0, 200.0, 15)
    tangential = 1e4 * (rng.standard_normal((3, 15, THROWS)) + 0.5j)
    forces = SimpleNamespace(
        orders=orders,
        speeds=speeds,
        tangential=tangential,
        radial=0.0 * tangential,
        throws=tuple(range(THROWS)),
    )
    torque = 2e3 * np.ones((1, 15, len(crankshaft.names)), dtype=complex)
    torque *= np.array(crankshaft.names) == "propeller rz"
    pushed = OrderExcitation(np.array([4.0]), speeds, torque)
    answer = coupled_response(crankshaft, forces, modal_damping=0.0, further=pushed)
    assert answer.orders.tolist() == [0.5, 1.0, 3.0, 4.0]
    for part in answer.parts:
        checked_power_balance(part)
    torques = np.zeros((4, 15, len(own.nodes)), dtype=complex)
    torques[:3, :, list(own.throw_nodes)] = LINE_RADIUS * tangential
    torques[3, :, own.nodes.index("propeller")] = 2e3
    known = forced_response(own.chain, OrderExcitation(answer.orders, speeds, torques))
    for node, point in {
        "free end": "main bearing 1 rz",
        "flywheel": f"main bearing {THROWS + 1} rz",
        "pump": "pump rz",
        "propeller": "propeller rz",
    }.items():
        expected = known.motion[:, :, own.nodes.index(node)]
        # The few ten-millionths of inertia at the sections, times the largest magnifier.
        assert np.abs(answer.motion(point) - expected).max() < 1e-4 * np.abs(expected).max()


def test_what_holds_the_line_holds_the_shaft_and_dashpots_alone_do_not():
    held = Chain([5.0, 2.0], [3e6], ground={1: 1e5})
    assert whole(held).rigid_names == ()
    assert whole(held, ring=TorsionalRing(2.0, 0.0, 80.0)).rigid_names == (
        "rotation of the ring alone",
    )
    loose = Chain(
        [5.0, 2.0, 1.0], [3e6], connections=[(1, 2)], dashpots=[Dashpot(0, 1, 9.0)], names="abc"
    )
    assert whole(loose).rigid_names == ("rotation about the shaft axis", "rotation of b, c alone")


test_refused_calls = refusals(
    ("crankshaft", lambda: coupled_response(shaft_of([0.0]), None)),
)
