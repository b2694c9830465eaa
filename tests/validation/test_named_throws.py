"""A shaft of two different throws.

Source: numpy alone, from given mass properties and 12 x 12 of two different throws: balance, chains,
bearings' positions, masses, stiffness.

Tolerance: 1e-9, linear algebra on 24 unknowns with a condition of 1e7; sums of masses and positions 1e-12.

Three cranks at 0, 240 and 120 deg (`tests/data/unequal-three.toml`), the first with a counterweight and
longer. Repeated are:

- balance: masses at their centers, angles and positions, and moments about the middle;
- chains: rods as two masses at their pins and half of the reciprocating mass at each crank; compliances of
  the assembled throws with sections on lateral springs; half of a throw's compliance on either side;
- the whole crankshaft: positions of its sections, and its mass by the throws' mass matrices.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from crankfem.analyses.engine_mechanism import with_throws
from crankfem.analyses.shaft.whole_records import shaft_balance
from crankfem.analyses.shaft.whole_shaft import highest_exciting_frequency, whole_shaft
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from fem.analysis import analyze_throw
from geometry.crankshaft import throw_masses

FILE = Path(__file__).parents[1] / "data" / "unequal-three.toml"
NAMES = ("heavy", "plain", "plain")
ANGLES = np.radians([0.0, 240.0, 120.0])
RADIUS, ROD, ROTATING, PISTON = 0.064, 2.5, 1.75, 1.3
FREE_END, FLYWHEEL_INERTIA, FLYWHEEL_MASS, THRUST = 0.01, 0.78, 28.0, 2e8
# The file gives none: 1e10 N/m per m of the journal at the free end.
BEARING = 1e10 * 0.078
# Between journals' middles: journal, pin and two webs.
LENGTHS = {"heavy": 0.036 + 0.038 + 0.050, "plain": 0.034 + 0.036 + 0.050}
STARTS = np.cumsum([0.0, *(LENGTHS[name] for name in NAMES)])
EXACT, SOLVED = 1e-12, 1e-9
# Motions of a section beside its mean ones.
BESIDE = 12


@pytest.fixture(scope="module")
def engine():
    return load_engine(FILE)


@pytest.fixture(scope="module")
def analyses(engine):
    return {
        name: analyze_throw(throw, engine.material, 0.1)
        for name, throw in engine.named_throws.items()
    }


@pytest.fixture(scope="module")
def run(engine, analyses):
    return engine_vibration(engine, analysis=analyses)


@pytest.fixture(scope="module")
def solids(engine):
    density = engine.material.density
    return {name: throw_masses(throw, density) for name, throw in engine.named_throws.items()}


def turn(angle):
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def by_hand(solids):
    """Static unbalance, moment about the middle, mass and inertia about the shaft."""
    static, moment, middle = np.zeros(2), np.zeros(2), STARTS[-1] / 2.0
    for name, angle, start in zip(NAMES, ANGLES, STARTS[:-1], strict=True):
        solid = solids[name]
        along = turn(angle)[:2, :2] @ (solid.mass * solid.center[:2])
        # Of a throw about the section at its start: products of inertia, z along the shaft.
        about = solid.mass * solid.center[:2] * solid.center[2] - solid.inertia[:2, 2]
        static += along
        moment += turn(angle)[:2, :2] @ about + (start - middle) * along
    mass = sum(solids[name].mass for name in NAMES)
    inertia = sum(
        solids[name].inertia[2, 2] + solids[name].mass * np.sum(solids[name].center[:2] ** 2)
        for name in NAMES
    )
    return static, moment, mass, inertia


def test_balance_of_the_crankshaft(engine, solids, figure):
    static, moment, mass, inertia = by_hand(solids)
    found = shaft_balance(engine)
    assert np.linalg.norm(static) > 0.05  # kg m: the shaft is out of balance
    for what, name, wanted, unit in (
        ("static unbalance", "static", static, "kg m"),
        ("moment about the middle", "dynamic", moment, "kg m^2"),
    ):
        figure(what, complex(*getattr(found.unbalance, name)), complex(*wanted), EXACT, unit)
    figure("mass", found.mass, mass, EXACT, "kg")
    figure("inertia about the shaft", found.inertia_about_shaft, inertia, EXACT, "kg m^2")


@pytest.mark.slow
def test_balance_of_the_mechanism(engine, solids, figure):
    """Its masses stand as complex numbers, +y real, in the sense of rotation, which is against +z here."""
    static, moment, _, inertia = by_hand(solids)
    assert engine.engine.turning_sense in (1, -1)
    layout, sense = with_throws(engine), engine.engine.turning_sense
    sizes = np.array([own.static_moment for own in layout.rotating])
    places = np.array([own.position for own in layout.rotating])
    turned = sizes * np.exp(1j * np.array([math.radians(own.angle_deg) for own in layout.rotating]))
    wanted = static[1] - 1j * sense * static[0]
    figure("static unbalance of its rotating masses", turned.sum(), wanted, EXACT, "kg m")
    about = np.sum(turned * (places - STARTS[-1] / 2.0))
    wanted = moment[1] - 1j * sense * moment[0]
    figure("their moment about the middle", about, wanted, EXACT, "kg m^2")
    attached = FREE_END + FLYWHEEL_INERTIA
    figure("inertia of its shaft", layout.shaft_inertia, inertia + attached, EXACT, "kg m^2")
    figure("main bearings along the shaft", engine.bearing_positions[1:], STARTS[1:], EXACT, "m")


def in_a_row(analyses):
    """Lengthening and twist of each throw under an axial force and a torque through all of them."""
    sections = len(NAMES) + 1
    size = (6 + BESIDE) * sections
    stiffness = np.zeros((size, size))
    for place, (name, angle) in enumerate(zip(NAMES, ANGLES, strict=True)):
        own = analyses[name].superelement.joined.turned(angle_deg=math.degrees(angle)).stiffness
        # Six mean motions of each section first, then what the sections do beside them.
        beyond = 6 * sections + BESIDE * place
        part = np.r_[6 * place : 6 * place + 12, beyond : beyond + 2 * BESIDE]
        stiffness[np.ix_(part, part)] += own
    across = [6 * section + axis for section in range(len(NAMES) + 1) for axis in (0, 1)]
    stiffness[across, across] += BEARING
    free = np.setdiff1d(np.arange(size), [2, 5])
    motions = np.zeros((size, 2))
    loads = np.zeros((size, 2))
    loads[[6 * sections - 4, 6 * sections - 1], [0, 1]] = 1.0
    motions[free] = np.linalg.solve(stiffness[np.ix_(free, free)], loads[free])
    motions = motions[: 6 * sections]
    return np.diff(motions[2::6, 0]), np.diff(motions[5::6, 1])


@pytest.mark.further
def test_the_axial_chain(run, analyses, figure):
    lengthening, _ = in_a_row(analyses)
    halves = np.array([analyses[name].mass for name in NAMES]) / 2.0
    masses = np.array([*halves, 0.0]) + np.array([0.0, *halves])
    masses[-1] += FLYWHEEL_MASS
    chain = run.axial_chain
    figure(
        "stiffness of the throws in the shaft", chain.stiffness, 1.0 / lengthening, SOLVED, "N/m"
    )
    figure("masses at the sections", chain.inertia, masses, EXACT, "kg")
    matrix = np.diag([0.0] * len(NAMES) + [THRUST])
    for place, spring in enumerate(1.0 / lengthening):
        matrix[place : place + 2, place : place + 2] += spring * np.array([[1, -1], [-1, 1]])
    root = np.sqrt(masses)
    frequencies = np.sqrt(np.linalg.eigvalsh(matrix / np.outer(root, root))) / (2.0 * math.pi)
    figure("natural frequencies", run.axial.chosen.elastic_frequencies, frequencies, SOLVED, "Hz")


@pytest.mark.slow
def test_the_torsional_chain(run, analyses, figure):
    _, twist = in_a_row(analyses)
    moving = (ROD - ROTATING + PISTON) / 2.0
    rods = (ROTATING + moving) * RADIUS**2
    cranks = [analyses[name].masses.inertia_about_shaft + rods for name in NAMES]
    joined = np.array([0.0, *twist]) / 2.0 + np.array([*twist, 0.0]) / 2.0
    chain = run.torsional_chain
    figure("inertias", chain.inertia, [FREE_END, *cranks, FLYWHEEL_INERTIA], EXACT, "kg m^2")
    figure("stiffness between the cranks", chain.stiffness, 1.0 / joined, SOLVED, "N m/rad")


@pytest.mark.further
def test_the_whole_crankshaft(engine, analyses, figure):
    """Sections stand where throws end; moved along itself it has the mass of throws and flywheel."""
    shaft = whole_shaft(engine, analyses).crankshaft.shaft
    figure("sections along the shaft", shaft.positions[1:], STARTS[1:], EXACT, "m")
    wanted = np.tile([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], len(NAMES) + 1)
    # The shortest vector of unknowns that moves the sections so leaves the shapes of the inside at rest.
    along = np.linalg.pinv(shaft.sections) @ wanted
    assert np.allclose(shaft.sections @ along, wanted)
    highest = max(200.0, highest_exciting_frequency(engine))
    own = {name: analyses[name].dynamic_superelement(highest).mass for name in analyses}
    # uz of both ends; the mesh has a little less than the solid.
    mass = sum(own[name][np.ix_([2, 8], [2, 8])].sum() for name in NAMES) + FLYWHEEL_MASS
    figure("mass along the shaft", along @ shaft.mass @ along, mass, SOLVED, "kg")
