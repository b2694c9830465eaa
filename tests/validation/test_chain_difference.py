"""Difference between a whole crankshaft and its chain.

Source: statics and an eigenproblem: stiffness assembled row by row with springs of bearings, coupling and
ring; inertia at the chain's positions about the shaft axis.

Tolerance: 1 % of the first torsional frequency, as only the path of inertia loads differs; the rest
round-off.
"""

import math
import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import eigh

import crankfem as cf
from comparing import close
from crankfem.analyses.shaft.chains import shaft_surroundings
from crankfem.analyses.shaft.whole_shaft import shaft_throws, whole_shaft
from crankfem.analyses.vibration.bearing_sweep import (
    bearing_sweep,
    chains_over_bearings,
    held_chains,
    in_bearings,
)
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.chain_comparison import CAUSES, frequency_difference, match_modes
from dynamics.crankshaft.shaft_modes import crankshaft_modes

pytestmark = pytest.mark.further
OWN = "tests/data/engines/"
ENGINES = (
    "6chn25-34",
    "8chn13-14",
    "vw-tdi",
    OWN + "8l32-42-damper.toml",
    OWN + "v12-170-190.toml",
)
RX, RY, RZ = 3, 4, 5
HIGHEST = 200.0  # Hz


@dataclass
class Case:
    engine: object
    analysis: object
    whole: object
    chain: object
    rigid_chain: object
    mode: int


@pytest.fixture(scope="module", params=ENGINES)
def case(request):
    engine = cf.load_engine(request.param)
    analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    whole = whole_shaft(engine, analysis, superelement=analysis.dynamic_superelement(HIGHEST))
    held = held_chains(engine, analysis, None, engine.main_bearings.stiffness)
    rigid = held_chains(engine, analysis, None, math.inf)
    chain = held.chain("torsional")
    mode = first_of_crankshaft(chain)
    return Case(engine, analysis, whole, chain, rigid.chain("torsional"), mode)


def first_of_crankshaft(chain):
    """Elastic mode, from 1, whose springs between throws, free end and flywheel hold half of the energy."""
    matrix, inertia = chain.chain.stiffness_matrix(), chain.chain.inertia
    squares, shapes = eigh(matrix, np.diag(inertia))
    rigid = np.count_nonzero(squares < 1e-9 * squares[-1])
    cranks = chain.throw_nodes[-1] + 1
    for number in range(rigid, len(squares)):
        twist = [
            k * (shapes[a, number] - shapes[b, number]) ** 2
            for k, (a, b) in zip(chain.chain.stiffness, chain.chain.connections, strict=True)
        ]
        if sum(twist[:cranks]) >= 0.5 * sum(twist):
            return number - rigid + 1
    raise AssertionError


def own_frequency(case):
    """First torsional frequency of the crankshaft itself with the chain's masses on the axis [Hz]."""
    engine, element = case.engine, case.analysis.dynamic_superelement(HIGHEST)
    angles, inner = np.radians(engine.throw_angles_deg), len(element.stiffness) - 12
    sections = 6 * (len(angles) + 1)
    rings = {
        name: node
        for node, name in enumerate(case.chain.nodes)
        if name in ("damper ring", "driven machine")
    }
    size = sections + inner * len(angles) + len(rings)
    stiffness, mass = np.zeros((2, size, size))
    chain = case.chain.chain
    turning = []  # of each throw, in the order of the chain: mean rotation of its pins per unknown
    for place, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        turn = np.eye(12 + inner)
        turn[:12, :12] = np.kron(np.eye(4), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        own = np.r_[
            6 * place : 6 * place + 12, sections + inner * place : sections + inner * (place + 1)
        ]
        stiffness[np.ix_(own, own)] += turn @ element.stiffness @ turn.T
        mean = np.zeros(size)
        mean[own] = np.mean([(turn @ pin)[:, RZ] for pin in element.pin_loads], axis=0)
        turning.append(mean)
        # A little of the throw's own mass, so that no motion is without any.
        mass[np.ix_(own, own)] += 1e-6 * turn @ element.mass @ turn.T
    bearing = engine.main_bearings.stiffness
    for section in range(len(angles) + 1):
        for across in (0, 1):
            stiffness[6 * section + across, 6 * section + across] += bearing
    thrust = engine.thrust_bearing
    stiffness[6 * thrust.section_index + 2, 6 * thrust.section_index + 2] += thrust.stiffness
    unit = np.eye(size)
    rows = dict(zip(case.chain.throw_nodes, turning, strict=True))
    for place, node in enumerate(rings.values()):
        rows[node] = unit[size - len(rings) + place]
        stiffness[size - len(rings) + place, size - len(rings) + place] += 1e-12
    for node, name in enumerate(case.chain.nodes):
        if name in ("free end", "flywheel"):
            rows[node] = unit[RZ if name == "free end" else sections - 6 + RZ]
    for number, (a, b) in enumerate(chain.connections):
        if number >= case.chain.crank_elements:
            twist = rows[a] - rows[b]
            stiffness += chain.stiffness[number] * np.outer(twist, twist)
    for node, row in rows.items():
        mass += chain.inertia[node] * np.outer(row, row)
    shift = (2.0 * math.pi * 5.0) ** 2
    inverse, shapes = eigh(mass, stiffness + shift * mass)
    frequencies = np.sqrt(np.maximum(1.0 / inverse[::-1] - shift, 0.0)) / (2.0 * math.pi)
    shapes = shapes[:, ::-1]
    nodes = sorted(rows)
    moved = np.array([rows[node] for node in nodes]) @ shapes
    weight = chain.inertia[nodes]
    modes = chain.modes()
    wanted = modes.shapes[nodes, modes.rigid + case.mode - 1]
    like = ((weight * wanted) @ moved) ** 2 / (weight @ wanted**2)
    # Shapes have the same energy: that of the largest product has it in torsion like the chain's.
    return float(frequencies[np.argmax(like / np.einsum("uk,uv,vk->k", shapes, mass, shapes))])


def test_masses_on_the_axis_leave_the_frequency_of_the_chain(case, figure):
    chain = float(case.chain.chain.modes().elastic_frequencies[case.mode - 1])
    figure("first torsional frequency, masses on the axis", own_frequency(case), chain, 0.01, "Hz")


def test_causes_sum_to_the_difference(case, figure):
    found = frequency_difference(
        case.whole.crankshaft.shaft, case.chain, case.rigid_chain, case.mode
    )
    assert tuple(found.causes) == CAUSES
    figure(
        "rigid chain and causes",
        found.rigid_chain + sum(found.causes.values()),
        found.shaft,
        1e-12,
        "Hz",
    )
    assert found.chain - found.rigid_chain == close(found.causes["bearings"])
    told = f"{case.mode}: {found.shaft:.1f} Hz by the whole crankshaft, {found.chain:.1f} Hz by the chain"
    assert told in found.sentence
    for name, by in found.causes.items():
        shown = name != "bearings" and abs(by) >= 0.05
        assert (f"{name} {by:+.1f} Hz" in found.sentence) == shown
    # What is printed adds up to the printed difference, and that to the printed frequencies.
    steps = [float(one) for one in re.findall(r"([+-]\d+\.\d) Hz", found.sentence)]
    assert steps[0] == close(round(found.shaft, 1) - round(found.chain, 1), abs=1e-9)
    assert sum(steps[1:]) == close(steps[0], abs=1e-9)


def test_flywheel_without_inertia_about_a_diameter(case, figure):
    """The same shaft put together with a flywheel that has next to none."""
    around, _ = shaft_surroundings(case.engine, case.analysis)
    thin = replace(around, flywheel=replace(around.flywheel, diametral_inertia=0.0))
    element = case.analysis.dynamic_superelement(HIGHEST)
    throws = shaft_throws(element, case.engine.throw, crank_angles_deg=case.engine.throw_angles_deg)
    shaft = assemble_crankshaft(throws, thin, turning_sense=case.engine.engine.turning_sense)
    modes = case.chain.chain.modes()
    (match,) = match_modes(
        shaft, crankshaft_modes(shaft), case.chain, [modes.rigid + case.mode - 1]
    )
    difference = frequency_difference(
        case.whole.crankshaft.shaft, case.chain, case.rigid_chain, case.mode
    )
    found = difference.tilt
    # The step told as a cause is the shift told of the flywheel.
    assert difference.causes["flywheel tilt"] == close(found.shaft - found.without)
    figure("frequency without tilt", found.without, match.shaft_frequency, 1e-8, "Hz")
    both = " and ".join(f"{one:.1f}" for one in sorted(filter(None, (found.shaft, found.further))))
    assert f"from {found.without:.1f} Hz without to {both} Hz with it" in found.sentence
    # Where a mode is told higher with more inertia, one more lies below it than without.
    below = [
        np.sum(crankshaft_modes(held).frequencies < 0.999 * frequency)
        for held, frequency in ((shaft, found.without), (case.whole.crankshaft.shaft, found.shaft))
    ]
    assert ("brings another mode below it" in found.sentence) == (
        found.further is None and found.shaft - found.without >= 0.05
    )
    if "brings" in found.sentence:
        assert below[1] > below[0]


def match_nominal(case, chain):
    shaft = case.whole.crankshaft.shaft
    wanted = chain.first_mode(chain.chain.modes())
    return match_modes(shaft, case.whole.modes, chain, [wanted])[0].shaft_frequency


def test_sweep_is_that_of_chains_and_shafts_one_by_one(case, figure):
    engine, analysis = case.engine, case.analysis
    each = chains_over_bearings(engine, analysis)
    found = bearing_sweep(engine, each, case.whole)
    held = engine.main_bearings
    assert (found.stiffness[0], found.stiffness[3], found.stiffness[-1]) == close(
        (held.lowest, held.stiffness, held.highest)
    )
    assert (found.used, found.statuses, found.flips) == ({}, (), False)
    for place in (0, 3, 6):
        own = held_chains(engine, analysis, None, float(found.stiffness[place]))
        named = own.chain("torsional")
        frequency = named.chain.modes().elastic_frequencies[first_of_crankshaft(named) - 1]
        figure("first frequency of the chain", found.chains["torsional"][place], frequency, 1e-12)
    changed = engine.changed(bearings={"stiffness": held.lowest})
    softer = whole_shaft(
        changed, analysis, superelement=analysis.dynamic_superelement(HIGHEST)
    ).crankshaft.shaft
    figure(
        "stiffness of the whole crankshaft in other bearings",
        in_bearings(case.whole.crankshaft.shaft, held.lowest - held.stiffness).stiffness,
        softer.stiffness,
        1e-12,
        scale=np.abs(softer.stiffness).max(),
    )
    # What is followed by shape moves up with the stiffness, and none that is most like the chain's is lost.
    for kind in ("axial", "torsional"):
        branches = np.vstack((found.shaft[kind], found.further[kind]))
        for branch in branches:
            assert np.all(np.diff(branch[np.isfinite(branch)]) > 0.0)
        for place, held_one in enumerate(each):
            named, added = held_one.chain(kind), float(found.stiffness[place]) - held.stiffness
            shaft = in_bearings(case.whole.crankshaft.shaft, added)
            wanted = named.first_mode(named.chain.modes())
            (match,) = match_modes(shaft, crankshaft_modes(shaft), named, [wanted])
            assert match.shaft_frequency in branches[:, place]
        assert found.shaft[kind][3] == match_nominal(case, each[3].chain(kind))
    low, high = np.min(found.chains["torsional"]), np.max(found.chains["torsional"])
    assert f"{low:.1f} to {high:.1f} Hz by the chain" in found.sentences[0]
