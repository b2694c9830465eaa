import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from fem.shaft import assemble_shaft, free_unknowns
from fem.superelement import RX, RY, RZ, UZ
from fem.supports import (
    Neighbors,
    class_axial_compliances,
    class_torsional_compliance,
    reactions,
    support_throw,
)

SUPPORTS = ["pinned", "guided", Neighbors(120, 120), Neighbors(90, 180), Neighbors(0, 240)]
DIRECTIONS = [(1e5, 0.0, 0.0), (0.0, -1e5, 0.0), (0.0, 0.0, 1e5), (3e4, -7e4, 2e4)]


def near(found, expected, tolerance):
    assert found.axial == close(expected.axial, rel=tolerance)
    assert found.torsional == close(expected.torsional, rel=tolerance)
    assert found.influence == close(expected.influence, rel=tolerance)


def tilt_stiffness_ratio(superelement):
    """rho: stiffness against equal tilts across the crank plane over that against opposite tilts in it.

    Both with lengthening and twist free.
    """
    motions = np.zeros((12, 4))
    motions[[UZ, 6 + UZ], 0] = -1.0, 1.0
    motions[[RX, 6 + RX], 1] = 1.0, -1.0
    motions[[RY, 6 + RY], 2] = 1.0, 1.0
    motions[[RZ, 6 + RZ], 3] = -1.0, 1.0
    matrix = motions.T @ superelement.stiffness @ motions
    in_plane = matrix[1, 1] - matrix[0, 1] ** 2 / matrix[0, 0]
    across = matrix[2, 2] - matrix[2, 3] ** 2 / matrix[3, 3]
    return across / in_plane


@pytest.mark.parametrize("support", SUPPORTS, ids=str)
@pytest.mark.parametrize("force", DIRECTIONS, ids=str)
def test_reactions_are_in_equilibrium(superelement, throw, mesh, pin_shapes, support, force):
    found = reactions(superelement, support, superelement.end_load(np.array(force)))
    size = np.linalg.norm(force)
    total = found.left.force + found.right.force + force
    assert total == close(np.zeros(3), abs=1e-9 * size)
    pin = np.array([0.0, pin_shapes[0] @ mesh.points[:, 1], throw.length / 2.0])
    moments = (
        found.left.moment
        + found.right.moment
        + np.cross([0.0, 0.0, throw.length], found.right.force)
        + np.cross(pin, force)
    )
    assert moments == close(np.zeros(3), abs=1e-9 * size * throw.length)
    assert found.right.moment[2] == close(0.0, abs=1e-8 * size)


@pytest.mark.parametrize("support", SUPPORTS, ids=str)
def test_blocked_throw_presses_with_c_z_over_e(superelement, support):
    answers = support_throw(superelement, support)
    found = reactions(superelement, support, superelement.end_load(np.array([0.0, -2e5, 0.0])))
    thrust = answers.influence * 2e5 / answers.axial
    assert thrust > 0.0
    assert found.left.force[2] == close(thrust, rel=1e-6)
    assert found.right.force[2] == close(-thrust, rel=1e-6)


def test_pinned_ends_carry_no_tilting_moment(superelement):
    found = reactions(superelement, "pinned", superelement.end_load(np.array([1e5, -1e5, 1e5])))
    assert found.left.moment[:2] == close([0.0, 0.0], abs=1e-6)
    assert found.right.moment[:2] == close([0.0, 0.0], abs=1e-6)
    # The torque is that of the tangential force.
    assert found.left.moment[2] == close(1e5 * 0.170, rel=1e-4)


def test_reactions_superpose(superelement):
    parts = [reactions(superelement, "guided", superelement.end_load(force)) for force in np.eye(3)]
    both = reactions(superelement, "guided", superelement.end_load(np.array([2.0, -3.0, 5.0])))
    wanted = 2.0 * parts[0].left.moment - 3.0 * parts[1].left.moment + 5.0 * parts[2].left.moment
    assert both.left.moment == close(wanted, rel=1e-10, abs=1e-10)


def test_neighbors_opposite_are_pinned(superelement):
    found, pinned = (
        support_throw(superelement, Neighbors(180, 180)),
        support_throw(superelement, "pinned"),
    )
    assert found.axial == close(pinned.axial, rel=1e-9)
    assert found.stretches[0] == close(pinned.stretches[0], rel=1e-9, abs=1e-20)
    # Under torque opposite cranks keep each other's ends from tilting across the crank plane.
    guided = support_throw(superelement, "guided")
    assert found.torsional == close(guided.torsional, rel=1e-9)


def test_neighbors_in_line_are_guided(superelement):
    found, guided = (
        support_throw(superelement, Neighbors(0, 0)),
        support_throw(superelement, "guided"),
    )
    assert found.axial == close(guided.axial, rel=1e-9)
    assert found.stretches[0] == close(guided.stretches[0], rel=1e-9, abs=1e-20)
    # Under torque all cranks tilt alike and hold each other nowhere.
    pinned = support_throw(superelement, "pinned")
    assert found.torsional == close(pinned.torsional, rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(gamma=st.floats(5.0, 355.0))
def test_helix_has_a_closed_form(superelement, gamma):
    free, held = support_throw(superelement, "pinned"), support_throw(superelement, "guided")
    ratio = tilt_stiffness_ratio(superelement) / math.tan(math.radians(gamma / 2.0)) ** 2
    found = support_throw(superelement, Neighbors(gamma, gamma))
    expected = held.axial + (free.axial - held.axial) / (1.0 + ratio)
    assert found.axial == close(expected, rel=1e-8)
    expected = held.influence + (free.influence - held.influence) / (1.0 + ratio)
    assert found.influence == close(expected, rel=1e-8)


@settings(max_examples=25, deadline=None)
@given(left=st.floats(0.0, 360.0), right=st.floats(0.0, 360.0))
def test_neighbors_lie_between_guided_and_pinned(superelement, left, right):
    free, held = support_throw(superelement, "pinned"), support_throw(superelement, "guided")
    found = support_throw(superelement, Neighbors(left, right))
    for name in ("axial", "torsional", "influence"):
        low, high = getattr(held, name), getattr(free, name)
        assert low * (1.0 - 1e-9) <= getattr(found, name) <= high * (1.0 + 1e-9)
    # Seen from the other end, and seen in a mirror, the throw has the same compliances.
    near(support_throw(superelement, Neighbors(right, left)), found, 1e-8)
    near(support_throw(superelement, Neighbors(-left, -right)), found, 1e-8)
    near(support_throw(superelement, Neighbors(left + 360.0, right)), found, 1e-8)


@pytest.mark.parametrize("support", [Neighbors(120, 120), Neighbors(70, 200)], ids=str)
def test_neighbors_against_a_long_shaft(superelement, support):
    """The middle one of 41 throws assembled one by one, with nothing condensed beforehand."""
    reach = 20
    places = np.arange(-reach, reach + 1)
    steps = np.where(places < 0, support.left_deg, support.right_deg)
    shaft = [
        superelement.turned(angle_deg=np.degrees(angle)) for angle in np.radians(steps * places)
    ]
    loads = np.zeros((6 * (len(shaft) + 1), 5))
    loads[-6 + UZ, 0] = loads[-6 + RZ, 1] = 1.0
    # Each throw's left end takes the torque and the axial push of its own pin.
    ends = superelement.pin_load[:6] + superelement.pin_load[6:]
    for place, part in enumerate(shaft):
        loads[6 * place : 6 * place + 12, 2:] += part.pin_load
        loads[[6 * place + UZ, 6 * place + RZ], 2:] -= ends[[UZ, RZ]]
    free = free_unknowns(len(shaft) + 1)
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(assemble_shaft(shaft)[np.ix_(free, free)], loads[free])
    middle = motions[6 * reach : 6 * reach + 12]
    found = support_throw(superelement, support)
    stretch = middle[6 + UZ] - middle[UZ]
    assert found.axial == close(stretch[0], rel=1e-6)
    assert found.torsional == close((middle[6 + RZ] - middle[RZ])[1], rel=1e-6)
    assert found.stretches[0] == close(stretch[2:], rel=1e-5, abs=1e-14)


def test_turning_the_throw_changes_nothing(superelement):
    for support in ("pinned", "guided", Neighbors(120, 120)):
        near(
            support_throw(superelement.turned(angle_deg=np.degrees(0.83)), support),
            support_throw(superelement, support),
            1e-9,
        )


@pytest.mark.parametrize("support", ["pinned", "guided"])
def test_two_classes_are_enough_for_these_supports(superelement, classes, support):
    expected = support_throw(superelement, support)
    axial, influence = class_axial_compliances(classes[0], support)
    assert axial == close(expected.axial, rel=1e-10)
    assert influence == close(expected.influence, rel=1e-10)
    assert class_torsional_compliance(classes[-1], support) == close(expected.torsional, rel=1e-10)


def test_lengthening_under_radial_force_is_the_pins_motion_under_axial_force(superelement):
    """Maxwell and Betti: c is also the pin's mean motion towards the shaft per unit pull."""
    blocked = [0, 1, 2, 5, 6, 7]
    free = np.setdiff1d(np.arange(12), blocked)
    motion = np.zeros(12)
    pull = np.zeros(12)
    pull[8] = 1.0
    motion[free] = np.linalg.solve(superelement.stiffness[np.ix_(free, free)], pull[free])
    inward = -(superelement.pin_load[:, 1] @ motion)
    assert support_throw(superelement, "pinned").influence == close(inward, rel=1e-10)


@pytest.mark.parametrize("support", ["free", "", None, 180, "Pinned"])
def test_unknown_support(superelement, support):
    with pytest.raises(InputError, match=r"^support: given .*pinned.*guided.*Neighbors"):
        support_throw(superelement, support)


@pytest.mark.parametrize("angle", [math.nan, math.inf, "120 deg", None])
def test_neighbors_take_finite_angles(angle):
    with pytest.raises(InputError, match=r"^Neighbors.right_deg: given "):
        Neighbors(120, angle)
