"""Slopes of complex amplitudes, against a complex step in the equations written in real form."""

import numpy as np
import pytest

import crankfem as cf
from crankfem.files.chain.chain_file import load_chain
from crankfem.satellites.measured.calibration.groups import (
    Group,
    chain_group,
    excitation_group,
    group_of_spread,
)
from crankfem.satellites.measured.calibration.response_slopes import Excitation, Sensor, Shaft
from dynamics.assessment.uncertainty import Spread
from dynamics.chains.chain import Chain, Dashpot
from dynamics.chains.varying import Variation, Varying, varied
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.order_excitation import OrderExcitation

STEP = 1e-30
ORDERS, SPEEDS = np.array([0.5, 3.0, 4.5, 6.0]), np.linspace(60.0, 240.0, 23)
POINTS = np.outer(SPEEDS, ORDERS).ravel(), np.repeat(SPEEDS, ORDERS.size)
# A ramp takes the response to frequencies beside the real ones.
BESIDE = POINTS[0] * (1.02 - 0.02j), POINTS[1]


def excitation(nodes: int, on: tuple[int, ...], fixed: bool = True) -> Excitation:
    rng = np.random.default_rng(5)
    count = POINTS[0].size

    def some(width: int):
        return rng.normal(size=(count, width)) + 1j * rng.normal(size=(count, width))

    return Excitation(some(nodes) * float(fixed), some(len(on)), on)


def scaled(values, groups: tuple[Group, ...], field: str, parameters):
    """The values of a field under complex parameters."""
    made = values.astype(complex)
    for group, parameter in zip(groups, parameters, strict=True):
        for act in group.acts:
            if act.field == field:
                factor = np.exp(act.power * group.deviation * parameter)
                made = made * (1.0 + act.shares * (factor - 1.0))
    return made


def by_real_form(shaft: Shaft, parameters, sensor: Sensor, acting: Excitation, points=POINTS):
    """Amplitudes by real and imaginary part, from unknowns that are real for real parameters."""
    chain = shaft.chain
    now = {
        name: scaled(value, shaft.groups, name, parameters) for name, value in shaft.nominal.items()
    }
    rows, count = chain.elongations(), len(chain.names)
    dashed = chain.dashpot_elongations()
    mass = np.diag(now["inertia"])
    for (left, right), spread in zip(chain.connections, now["distributed_inertia"], strict=True):
        ends = np.ix_([left, right], [left, right])
        mass[ends] += spread / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    stiffness = rows.T @ (now["stiffness"][:, None] * rows) + np.diag(now["ground"])
    loss = rows.T @ ((now["stiffness"] * now["loss_factor"])[:, None] * rows)
    damping = rows.T @ (now["damping"][:, None] * rows) + np.diag(now["ground_damping"])
    damping = damping + dashed.T @ (now["dashpots"][:, None] * dashed)
    if shaft.modal_damping:
        squares, modes = np.linalg.eig(np.linalg.solve(mass, stiffness))
        modes = modes / np.sqrt(np.einsum("iq,ij,jq->q", modes, mass, modes))
        springs = np.concatenate((now["stiffness"], now["ground"]))
        damps = shaft.damps if shaft.damps.size else np.ones(springs.size, dtype=bool)
        twists = np.vstack((rows, np.eye(count))) @ modes
        elastic = np.abs(squares) > 1.0
        frequencies = np.sqrt(np.where(elastic, squares, 1.0))
        strain = np.sum((damps * springs)[:, None] * twists**2, axis=0)
        modal = np.where(elastic, 2.0 * now["modal"][0] * strain / frequencies, 0.0)
        damping = damping + (mass @ modes * modal) @ (mass @ modes).T
    answers = []
    for point, (w, speed) in enumerate(zip(*points, strict=True)):
        forces = acting.fixed[point].astype(complex)
        held, lost, viscous = stiffness.copy(), loss.copy(), damping.copy()
        for spring in chain.varying:
            k, eta, c = (
                float(v[0]) for v in spring.law.constants(np.array([w]), np.array([speed]))
            )
            field = "ground_damping" if spring.to_ground else "damping"
            row = (np.eye(count) if spring.to_ground else rows)[spring.place]
            if spring.law.damping:
                ratio = now[field][spring.place] / spring.law.damping
                viscous = viscous + np.outer(row, row) * ratio * (c - spring.law.damping)
            if not spring.to_ground:
                grown = now["stiffness"][spring.place] / chain.stiffness[spring.place]
                held = held + np.outer(row, row) * grown * (k - spring.law.stiffness)
                share = now["loss_factor"][spring.place] / chain.loss_factor[spring.place]
                before = spring.law.stiffness * spring.law.loss_factor
                lost = lost + np.outer(row, row) * grown * share * (k * eta - before)
        real = held - (w**2).real * mass - w.imag * viscous
        imaginary = lost + w.real * viscous - (w**2).imag * mass
        whole = np.block([[real, -imaginary], [imaginary, real]])
        sides = [forces.real.astype(complex), forces.imag.astype(complex)]
        for source, node in enumerate(acting.nodes):
            sides[0][node] += now["excitation"][source] * acting.sources[point, source].real
            sides[1][node] += now["excitation"][source] * acting.sources[point, source].imag
        x = np.linalg.solve(whole, np.concatenate(sides))
        if sensor.kind == "node":
            answers.append((x[sensor.place], x[count + sensor.place]))
            continue
        k = now["stiffness"][sensor.place]
        for spring in (each for each in chain.varying if each.place == sensor.place):
            k = (
                k
                * spring.law.constants(np.array([w]), np.array([speed]))[0][0]
                / spring.law.stiffness
            )
        twist = rows[sensor.place]
        answers.append((k * (twist @ x[:count]), k * (twist @ x[count:])))
    return np.array(answers).T


def six() -> Chain:
    return load_chain("mwm-six").chain


def damped_plant() -> Chain:
    """A chain with every kind of value: a damper's ring, distributed inertia, a spring to ground."""
    return Chain(
        [0.02, 0.3, 0.2, 0.2, 2.0, 0.1],
        [1.2e6, 1.5e6, 1.1e6, 3e5],
        [0.0, 0.0, 0.0, 0.0, 5e4, 0.0],
        connections=[(0, 1), (1, 2), (2, 3), (3, 4)],
        damping=[0.0, 3.0, 0.0, 40.0],
        loss_factor=[0.02, 0.0, 0.03, 0.3],
        ground_damping=[0.0, 2.0, 2.0, 2.0, 1.0, 0.0],
        distributed_inertia=[0.0, 0.02, 0.03, 0.0],
        dashpots=[Dashpot(0, 5, 25.0)],
    )


def varying_line() -> Chain:
    coupling = Variation(
        frequency=(10.0, 60.0, 200.0), stiffness=(1.0, 1.4, 2.0), loss_factor=(0.3, 0.2, 0.1)
    )
    stiffness, loss, _, law = varied(coupling, 8e4, 0.25)
    course = Variation(speed=(0.0, 300.0), stiffness=(1.0, 1.0), damping=(0.1, 2.0))
    water = varied(course, 0.0, damping=30.0)[3]
    return Chain(
        [1.0, 0.5, 0.3, 2.0],
        [2e6, stiffness, 3e5],
        loss_factor=[0.01, loss, 0.0],
        ground_damping=[1.0, 0.0, 0.0, 30.0],
        varying=[Varying(1, law), Varying(3, water, True)],
    )


GROUPS = {
    "six": [
        "inertia of flywheel",
        "inertia",
        "stiffness of pulley - gear train",
        "compliance",
        "loss factor",
        "ground damping",
    ],
    "plant": [
        "inertia",
        "distributed inertia",
        "stiffness",
        "damping",
        "loss factor",
        "ground damping",
        "dashpot damping",
        "ground stiffness",
        "all damping",
    ],
    "varying": ["inertia of node 1", "stiffness", "loss factor", "ground damping"],
}
CHAINS = {"six": six, "plant": damped_plant, "varying": varying_line}


@pytest.mark.parametrize("points", [POINTS, BESIDE], ids=["steady", "in a ramp"])
@pytest.mark.parametrize("sensor", [Sensor(0), Sensor(2), Sensor(1, "element")], ids=repr)
@pytest.mark.parametrize(
    ("kind", "modal"),
    [
        *((kind, modal) for kind in ("six", "plant") for modal in (0.0, 0.02, -0.02)),
        ("varying", 0.0),
    ],
)
def test_slopes_are_those_of_a_complex_step_in_real_form(kind, modal, sensor, points):
    chain = CHAINS[kind]()
    nodes = tuple(range(len(chain.names) - 1))[-3:]
    groups = (
        *(chain_group(chain, name, 0.2) for name in GROUPS[kind]),
        excitation_group("first", 3, [0], 0.3),
        excitation_group("all", 3, [0, 1, 2], 0.1),
    )
    damps = np.ones(0, dtype=bool)
    if modal < 0.0:  # an assumed magnifier stands for springs without damping of their own alone
        damps = np.arange(len(chain.stiffness) + len(chain.names)) != 1
    shaft = Shaft(chain, groups, 3, abs(modal), damps)
    acting = excitation(len(chain.names), nodes)
    at = np.random.default_rng(2).normal(size=len(groups))
    amplitudes, slopes = shaft.amplitudes(at, sensor, *points, acting)
    by_parts = by_real_form(shaft, at, sensor, acting, points)
    whole = by_parts[0].real + 1j * by_parts[1].real
    assert np.allclose(amplitudes, whole, rtol=1e-9, atol=1e-9 * np.abs(whole).max())
    for number, group in enumerate(groups):
        moved = at.astype(complex)
        moved[number] += 1j * STEP
        steps = by_real_form(shaft, moved, sensor, acting, points).imag / STEP
        expected = steps[0] + 1j * steps[1]
        error = np.abs(slopes[:, number] - expected).max() / np.abs(expected).max()
        assert error < 1e-8, (group.name, error)


@pytest.mark.parametrize("place", ["node", "element"])
def test_amplitudes_are_those_of_the_forced_response(place):
    """At nominal values they are what the core calculates, with its magnifier."""
    chain = damped_plant()
    acting = excitation(6, (1, 2, 3), fixed=False)
    shaft = Shaft(chain, (group_of_spread(chain, Spread.within("inertia", 0.1)),), 3, 0.0125)
    amplitudes, _ = shaft.amplitudes(np.zeros(1), Sensor(1, place), *POINTS, acting)
    forces = np.zeros((ORDERS.size, SPEEDS.size, 6), dtype=complex)
    for source, node in enumerate(acting.nodes):
        forces[:, :, node] = acting.sources[:, source].reshape(SPEEDS.size, -1).T
    response = forced_response(
        damped(chain, modal_damping=0.0125), OrderExcitation(ORDERS, SPEEDS, forces)
    )
    if place == "node":
        core = response.motion[:, :, 1]
    else:
        core = (response.motion[:, :, 2] - response.motion[:, :, 1]) * chain.stiffness[1]
    assert np.allclose(amplitudes.reshape(SPEEDS.size, -1).T, core, rtol=1e-8)


def test_modal_damping_of_a_spring_that_varies_is_refused():
    with pytest.raises(cf.InputError, match="modal damping together with springs that vary"):
        Shaft(varying_line(), (chain_group(varying_line(), "inertia", 0.1),), 1, 0.02)


@pytest.mark.parametrize(
    ("name", "tolerance", "sentence"),
    [
        ("mass", 0.1, "unknown group"),
        ("inertia of rudder", 0.1, "rudder"),
        ("inertia", 0.0, "allowed is a share"),
        ("dashpot damping", 0.1, "allowed are values above zero"),
    ],
)
def test_groups_that_move_nothing_are_refused(name, tolerance, sentence):
    with pytest.raises(cf.InputError, match=sentence):
        chain_group(six(), name, tolerance)
