"""A whole crankshaft of throws whose matrices are those of beams, made here.

A throw is a row of Euler's and Bernoulli's beams with consistent masses: half journal, web, pin in two
pieces, web, half journal. Motions of its inner nodes beyond the static answer to those of its ends are
its shapes. So every motion is known, and no finite elements in three dimensions are needed.
"""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.shaft_modes import crankshaft_modes, crankshaft_system, rotation_ratio
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
    TorsionalRing,
    rotation,
)

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


@pytest.mark.parametrize(
    ("around", "names"),
    [
        (
            ShaftSurroundings(bearings=MainBearings(1e9)),
            ("rotation about the shaft axis", "axial translation"),
        ),
        (AROUND, ("rotation about the shaft axis", "rotation of the ring alone")),
        (
            ShaftSurroundings(
                bearings=MainBearings([0.0, 0.0, 1e9, 0.0, 0.0]),
                axial_supports=(AxialSupport(0, math.inf),),
            ),
            ("rotation about the shaft axis", "tilt about x", "tilt about y"),
        ),
    ],
)
def test_rigid_motions_in_bearings(around, names):
    shaft = shaft_of(CRANKS, around)
    modes = crankshaft_modes(shaft)
    assert modes.names[: modes.rigid] == names
    assert np.abs(shaft.stiffness @ shaft.rigid).max() < 1e-12 * np.abs(shaft.stiffness).max()
    assert modes.angular_frequencies[modes.rigid] > 10.0


def test_elastic_modes_are_those_of_the_matrices(surrounded):
    """The same by a general solver, which sees rigid motions as small numbers."""
    modes = crankshaft_modes(surrounded)
    squares = eigh(surrounded.stiffness, surrounded.mass, eigvals_only=True)
    # Round-off of the highest frequency is what the general solver leaves.
    assert modes.angular_frequencies**2 == close(squares, abs=1e-11 * squares[-1])


def test_shares_do_not_depend_on_the_frame(surrounded):
    modes = crankshaft_modes(surrounded)
    turned = crankshaft_modes(shaft_of([angle + 37.0 for angle in CRANKS], AROUND))
    apart = np.diff(modes.frequencies[modes.rigid : 12]).min()
    assert apart > 1.0  # no two of them alike, so that each mode is one
    assert turned.frequencies == close(modes.frequencies, rel=1e-9)
    assert turned.shares[:, :12] == close(modes.shares[:, :12], abs=1e-6)
    assert modes.shares.min() >= 0.0
    assert modes.shares.sum(axis=0) == close(np.ones(len(modes.frequencies)))


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


def test_a_tangential_force_turns_the_shaft_and_a_radial_one_does_not():
    shaft = shaft_of(CRANKS)
    about = shaft.rigid[:, 0]
    moved = shaft.pins.reshape(4, 3, -1) @ about
    assert moved == close(np.tile([RADIUS, 0.0, 0.0], (4, 1)), abs=1e-12)
    against = shaft_of(CRANKS, turning_sense=-1).pins.reshape(4, 3, -1) @ about
    assert against[:, 0] == close(np.full(4, -RADIUS))
    # Towards the axis: +x of the shaft for a crank at 90 degrees (which lies at -x).
    along_x = shaft.pins.reshape(4, 3, -1) @ shaft.rigid[:, 2]
    assert along_x[:, 1] == close([0.0, 1.0, -1.0, 0.0], abs=1e-12)


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
    ],
)
def test_refused(make, field):
    with pytest.raises(InputError, match=rf"^{field}.*given .*; allowed .*because"):
        make()
