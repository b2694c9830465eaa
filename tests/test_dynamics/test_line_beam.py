"""Bending of shaft lines: rigid motions, closed forms of free and pinned beams, and a line behind throws."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.shaft_line import ShaftCone, shaft_cylinder
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.line_beam import LineBeam
from dynamics.crankshaft.shaft_modes import crankshaft_modes
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
)

E, G, RHO = 2.1e11, 2.1e11 / 2.6, 7850.0
# Ends held across, by springs that no shaft here bends noticeably.
HELD = 1e16


def beam(*pieces, bearings=()):
    still = (0.0,) * (len(pieces) + 1)
    return LineBeam(tuple(pieces), still, still, bearings)


def frequencies(line):
    """Angular frequencies [rad/s], from the lowest."""
    bending = line.bending
    return np.sqrt(np.abs(eigh(bending.stiffness, bending.mass, eigvals_only=True)))


@st.composite
def rows(draw):
    """Cones and cylinders, solid and bored, in a row."""
    pieces = []
    for _ in range(draw(st.integers(1, 4))):
        left, right = (draw(st.floats(0.05, 0.8)) for _ in range(2))
        bore = draw(st.floats(0.0, 0.9)) * min(left, right)
        shape = draw(st.sampled_from(["cylindrical", "proportional"]))
        pieces.append(ShaftCone(draw(st.floats(0.02, 6.0)), left, right, bore, shape))
    return pieces


@given(rows(), st.lists(st.floats(0.0, 1.0), max_size=3), st.data())
@settings(max_examples=40, deadline=None)
def test_rigid_motions_take_no_force_and_have_the_mass_of_the_pieces(pieces, shares, data):
    bodies = tuple(data.draw(st.floats(0.0, 500.0)) for _ in range(len(pieces) + 1))
    wheels = tuple(data.draw(st.floats(0.0, 50.0)) for _ in bodies)
    length = sum(piece.length for piece in pieces)
    held = tuple((share * length, 0.0) for share in shares)
    bending = LineBeam(tuple(pieces), bodies, wheels, held).bending
    places = bending.places
    assert np.diff(places).min() > 0.0
    assert places[-1] == close(length)
    for share in shares:
        assert np.abs(places - share * length).min() <= 1.1e-6 * length
    across = np.tile([1.0, 0.0], places.size)
    tilted = np.column_stack((places, np.ones(places.size))).ravel()
    size = np.abs(bending.springs).max()
    assert np.abs(bending.springs @ np.column_stack((across, tilted))).max() < 1e-9 * size * length
    assert np.abs(bending.mass - bending.mass.T).max() <= 1e-12 * np.abs(bending.mass).max()
    assert np.all(np.diag(bending.mass) > 0.0)
    ends = np.cumsum([0.0, *(piece.length for piece in pieces)])
    mass = sum(piece.mass for piece in pieces)
    assert across @ bending.mass @ across == close(mass + sum(bodies))
    # About the beginning: no more and no less than discs at their places have.
    disc = 0.5 * (sum(piece.polar_inertia for piece in pieces) + sum(wheels))
    reach = [
        sum(piece.mass * end**2 for piece, end in zip(pieces, side, strict=True))
        for side in (ends[:-1], ends[1:])
    ]
    own = float(np.sum(np.array(bodies) * ends**2))
    turning = tilted @ bending.mass @ tilted - disc - own
    assert reach[0] - 1e-6 * reach[1] <= turning <= reach[1] * (1.0 + 1e-6)


@given(st.floats(0.05, 0.8), st.floats(3.0, 60.0), st.floats(0.0, 0.8))
@settings(max_examples=30, deadline=None)
def test_pinned_ends_have_the_frequencies_of_timoshenkos_beam(diameter, slender, hollow):
    """With a = n pi / L: E I a^4 - (rho A + rho I (1 + E / k G) a^2) w^2 + rho^2 I / (k G) w^4 = 0."""
    length, bore = slender * diameter, hollow * diameter
    area, second = (
        math.pi / size * (diameter**power - bore**power) for size, power in ((4, 2), (64, 4))
    )
    m, poisson = hollow**2, 0.3
    thick = (7 + 6 * poisson) * (1 + m) ** 2 + (20 + 12 * poisson) * m
    shear = 6 * (1 + poisson) * (1 + m) ** 2 / thick * G
    piece, held = shaft_cylinder(length, diameter, bore), ((0.0, HELD), (length, HELD))
    found, coarse = (frequencies(beam(*piece.divided(parts), bearings=held)) for parts in (40, 1))
    for number in (1, 2):
        a = number * math.pi / length
        linear = RHO * area + RHO * second * (1 + E / shear) * a**2
        squares = np.roots([RHO**2 * second / shear, -linear, E * second * a**4])
        exact = math.sqrt(squares.min())
        assert found[number - 1] == close(exact, rel=1e-3)
        # As the line divides a piece itself.
        assert exact * 0.999 < coarse[number - 1] < exact * (1.0 + 3e-3 * number**2)


@given(st.floats(0.01, 0.2))
@settings(max_examples=10, deadline=None)
def test_free_slender_shafts_have_eulers_frequencies(diameter):
    length = 100.0 * diameter
    found = frequencies(
        beam(shaft_cylinder(0.4 * length, diameter), shaft_cylinder(0.6 * length, diameter))
    )
    scale = diameter / 4.0 * math.sqrt(E / RHO) / length**2
    assert found[:2] == close(0.0, abs=1e-3 * found[2])
    assert found[2:5] / scale == close([22.3733, 61.6728, 120.9034], rel=4e-3)


def test_a_cone_bends_as_many_short_cylinders_do():
    cone = ShaftCone(3.0, 0.4, 0.2, 0.1)
    steps = cone.divided(60)
    short = [
        shaft_cylinder(piece.length, 0.5 * (piece.left_diameter + piece.right_diameter), 0.1)
        for piece in steps
    ]
    assert frequencies(beam(cone))[2:5] == close(frequencies(beam(*short))[2:5], rel=5e-3)


def test_what_cannot_be_is_refused():
    piece = shaft_cylinder(2.0, 0.1)
    for make, said in (
        (lambda: beam(), "pieces"),
        (lambda: LineBeam((piece,), (0.0,), (0.0, 0.0)), "masses: given 1 value;"),
        (lambda: LineBeam((piece,), (0.0, 0.0), (0.0, -1.0)), "inertias"),
        (lambda: beam(piece, bearings=((2.1, 1e9),)), "given one at 2.1 m; allowed is 0 to 2 m"),
        (lambda: beam(piece, bearings=((1.0, -1.0),)), "bearings"),
    ):
        with pytest.raises(InputError, match=said):
            make()


def straight_throw():
    """A throw of a rigid section after the other, with springs between them in all directions."""
    reach, mass = 0.4, 50.0
    relative = np.zeros((6, 12))
    for first, arm in ((0, reach / 2), (6, -reach / 2)):
        side = np.eye(6)
        side[0, 4], side[1, 3] = arm, -arm
        relative[:, first : first + 6] = side if first else -side
    springs = np.diag([3e9, 3e9, 5e9, 2e8, 2e8, 1e8])
    pin = np.zeros((6, 12))
    pin[:, :6] = pin[:, 6:] = 0.5 * np.eye(6)
    body = np.diag([mass / 2] * 3 + [1.0, 1.0, 2.0])
    both = np.kron(np.eye(2), body)
    center = [[0.0, 0.1, reach / 2]]
    return ShaftThrow(relative.T @ springs @ relative, both, pin.T[None], center, reach)


LINE = LineBeam(
    (shaft_cylinder(2.0, 0.12), shaft_cylinder(1.0, 0.15)),
    (0.0, 0.0, 300.0),
    (0.0, 0.0, 80.0),
    ((1.3, 1e9), (3.0, 1e9)),
)


def shaft(line, **around):
    wheel = EndBody(200.0, 20.0, overhang=0.15)
    return assemble_crankshaft(
        [straight_throw()] * 2, ShaftSurroundings(flywheel=wheel, line_beam=line, **around)
    )


@pytest.mark.parametrize("count", [0, 1, 2])
def test_rigid_motions_of_a_crankshaft_with_its_line(count):
    line = LineBeam(LINE.pieces, LINE.masses, LINE.inertias, LINE.bearings[:count])
    free = shaft(line)
    assert len(free.rigid_names) == {0: 6, 1: 4, 2: 2}[count]
    assert np.abs(free.stiffness @ free.rigid).max() < 1e-6 * np.abs(free.stiffness).max()
    for matrix in (free.stiffness, free.mass):
        assert np.abs(matrix - matrix.T).max() <= 1e-12 * np.abs(matrix).max()
    modes = crankshaft_modes(free)
    assert modes.frequencies[modes.rigid] > 1.0
    assert modes.shares.sum(axis=0) == close(np.ones(modes.frequencies.size))
    if count == 0:
        translation = free.rigid[:, free.rigid_names.index("translation along y")]
        lateral = translation @ free.mass @ translation
        line_mass = sum(piece.mass for piece in LINE.pieces) + 300.0
        assert lateral == close(4 * 25.0 + 200.0 + line_mass)


def test_a_line_holds_the_flywheel_and_its_own_modes_are_none_of_the_crankshaft():
    held = {
        "bearings": MainBearings(2e9),
        "axial_supports": (AxialSupport(2, 1e9),),
    }
    bare, whole = (crankshaft_modes(shaft(line, **held)) for line in (None, LINE))
    tilt = bare.frequencies[bare.first("bending")]
    first = whole.first("bending")
    assert whole.frequencies[first] > tilt
    # Modes in pairs below it are the line's: they strain it more than the crankshaft.
    below = slice(whole.rigid, first)
    assert whole.frequencies[below].size >= 2
    assert np.all(whole.crankshaft_shares[below][whole.shares[2, below] > 0.9] < 0.5)
    for one, other in pairwise(whole.frequencies[below][whole.shares[2, below] > 0.9][:2]):
        assert one == close(other, rel=1e-6)
