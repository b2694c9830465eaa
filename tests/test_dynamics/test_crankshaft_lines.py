"""A shaft line behind the whole crankshaft: with torsion alone it is the chain with its line."""

from types import SimpleNamespace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.dampers import TorsionalRing
from dynamics.chains.engine_chains import axial_chain, torsional_chain
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.chain_comparison import match_modes
from dynamics.crankshaft.coupled_response import coupled_response
from dynamics.crankshaft.shaft_modes import crankshaft_modes, crankshaft_system
from dynamics.crankshaft.surroundings import (
    RZ,
    UZ,
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
)
from dynamics.response.forced import forced_response
from dynamics.response.loads import checked_power_balance
from dynamics.response.order_excitation import OrderExcitation

RADIUS, LENGTH, THROWS = 0.17, 0.4, 4
TWIST, INERTIA, ALONG, MASS = 2e7, 8.0, 3e9, 120.0
# Stiff across the shaft, so that torsion is alone; a section without any inertia has no motion.
STIFF, LEFT = 1e11, 1e-7
FLYWHEEL, FREE_END = 60.0, 3.0
# Error of an eigenvalue [rad^2/s^2]: round-off of the largest, that of the sections almost without inertia.
ROUND_OFF = 4.0 * np.finfo(float).eps * TWIST / (LEFT * INERTIA)


def twisting_throw(angle_deg):
    """Two springs 2 k with the inertia at the pin between: a spring k of the ends, 4 k of the pin's shape."""
    relative = np.zeros((6, 13))
    for first, arm in ((0, LENGTH / 2.0), (6, -LENGTH / 2.0)):
        side = np.eye(6)
        side[0, 4], side[1, 3] = arm, -arm
        relative[:, first : first + 6] = side if first else -side
    springs = np.diag([STIFF, STIFF, ALONG, STIFF, STIFF, TWIST])
    stiffness = relative.T @ springs @ relative
    body = [MASS / 2.0] * 3 + [3.0, 3.0, LEFT * INERTIA]
    mass = np.diag([*body, *body, 0.0])
    stiffness[12, 12] = 4.0 * TWIST
    turning = np.zeros(13)
    turning[[RZ, RZ + 6, 12]] = 0.5, 0.5, 1.0
    mass += INERTIA * np.outer(turning, turning)
    pin = np.zeros((6, 13))
    pin[RZ] = turning
    pin[0] = -RADIUS * turning
    pin[2, [UZ, UZ + 6]] = 0.5
    return ShaftThrow(
        stiffness,
        mass,
        pin.T[None],
        [[0.0, RADIUS, LENGTH / 2.0]],
        LENGTH,
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
        [1.0 / TWIST] * THROWS, [INERTIA] * THROWS, FLYWHEEL, FREE_END, shaft_line=line
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
    torques[:3, :, list(own.throw_nodes)] = RADIUS * tangential
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


def test_a_geared_line_reduces_like_that_of_a_chain():
    """What turns r times as fast counts with r^2 of its inertia and stiffness."""
    ratio = -3.0
    geared = Chain(
        [5.0, 2.0, 4.0],
        [3e6],
        connections=[(1, 2)],
        gears=[Gear(0, 1, ratio)],
        names=["wheel", "pinion", "pump"],
    )
    plain = Chain([5.0 + 2.0 * ratio**2, 4.0 * ratio**2], [3e6 * ratio**2], names=["wheel", "pump"])
    found, reduced = of_kind(whole(geared), "torsional"), of_kind(whole(plain), "torsional")
    assert found[:10] == close(reduced[:10], 1e-8)


def test_a_line_along_the_shaft_is_that_of_the_axial_chain():
    line = Chain(
        [100.0, 50.0, 3000.0], [2e8, 4e8], ground={2: 1e6}, names=["flange", "a", "propeller"]
    )
    own = axial_chain(
        [1.0 / ALONG] * THROWS, [MASS] * THROWS, 400.0, THROWS, 5e8, {0: 10.0}, shaft_line=line
    )
    expected = own.chain.modes().frequencies
    assert of_kind(whole(line, kind="axial"), "axial")[: expected.size] == close(expected, 1e-6)


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
