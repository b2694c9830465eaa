"""Chains of engines in elastic main bearings.

Source: statics: stiffness of turned throws with a spring per direction on each journal, assembled row by
row and inverted.

Tolerance: 1e-9, round-off of one linear system.

The frequencies of 6ChN 25/34 with rigid sections (rigid bearings 86.97 Hz, 85.0 at 2.2e9 N/m, 82.2 at 2.2e8,
free 80.8) come from an eigenproblem with the chain's inertias.
"""

import math

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankfem.analyses.shaft.chains import engine_torsional_chain
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.throw_analyses import analyze_throws

UX, UY, UZ, RZ = 0, 1, 2, 5
pytestmark = pytest.mark.further


@pytest.fixture(scope="module")
def engine():
    return cf.load_engine("6chn25-34")


@pytest.fixture(scope="module")
def analysis(engine):
    return analyze_throws(engine)["throw"]


def by_hand(analysis, angles, bearing):
    """Stretch and twist of each throw per pull and per torque at the last section."""
    count = len(angles)
    throw = analysis.superelement.joined
    bending = throw.sections.bending
    matrix = np.zeros(((6 + bending) * (count + 1),) * 2)
    for place, angle in enumerate(angles):
        rows = 6 * place + np.arange(12)
        beyond = 6 * (count + 1) + bending * place + np.arange(2 * bending)
        own = np.concatenate([rows, beyond])
        matrix[np.ix_(own, own)] += throw.turned(angle_deg=math.degrees(angle)).stiffness
    held = [UZ, RZ]
    for section in range(count + 1):
        for direction in (UX, UY):
            if math.isinf(bearing):
                held.append(6 * section + direction)
            else:
                matrix[6 * section + direction, 6 * section + direction] += bearing
    free = np.setdiff1d(np.arange(len(matrix)), held)
    motions = np.zeros((len(matrix), 2))
    loads = np.zeros((len(matrix), 2))
    loads[[6 * count + UZ, 6 * count + RZ], [0, 1]] = 1.0
    motions[free] = np.linalg.inv(matrix[np.ix_(free, free)]) @ loads[free]
    moved = motions[: 6 * (count + 1)]
    return np.diff(moved[UZ::6, 0]), np.diff(moved[RZ::6, 1]), np.diff(moved[UZ::6, 1])


@pytest.mark.parametrize("bearing", [math.inf, 2.2e10, 2.2e9, 2.2e8, 1e7])
def test_a_chain_holds_what_the_shaft_does(engine, analysis, bearing, figure):
    found = compliances_in_shaft(engine, analysis, bearing)
    axial, torsional, through = by_hand(analysis, np.radians(engine.throw_angles_deg), bearing)
    figure("axial compliances in the shaft", found.axial, axial, 1e-9, "m/N")
    figure("torsional compliances in the shaft", found.torsional, torsional, 1e-9, "rad/(N m)")
    figure("stretch by torque", found.through, through, 1e-9, "1/N", scale=np.abs(through).max())


def test_one_stiffness_serves_chains_and_whole_crankshaft(engine, analysis):
    """Given in the file, it is that of both; without the section both have the assumed one, and say so."""
    for changed, stiffness in (
        (engine.changed(bearings={"stiffness": 4e8}), 4e8),
        (engine.changed(bearings=None), 1e10 * engine.throw.main_journal_diameter),
    ):
        assert changed.main_bearings.stiffness == stiffness
        vibration = cf.engine_vibration(changed, analysis=analysis, coupled=True)
        axial, torsional, _ = by_hand(analysis, np.radians(changed.throw_angles_deg), stiffness)
        assert vibration.axial.chosen.compliances == close(axial, rel=1e-9)
        assert vibration.torsional.chosen.compliances == close(torsional, rel=1e-9)
        springs = vibration.whole.crankshaft.shaft
        moved = springs.sections[UX::6]
        # The shaft's own stiffness does not resist a shift: what does is the bearings alone.
        shift = np.linalg.lstsq(springs.sections, np.tile(np.eye(6)[UX], 7), rcond=None)[0]
        assert shift @ springs.stiffness @ shift == close(len(moved) * stiffness, rel=1e-5)


def test_first_torsional_frequency_over_the_bearings(engine, analysis, figure):
    # Found on a mesh with an error of about 0.9 %, whose compliances were not corrected, with rigid sections.
    analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.005).discrete
    analysis = analysis.with_sections("rigid")
    for bearing, published in (
        (math.inf, 86.97),
        (2.2e10, 86.7),
        (2.2e9, 85.0),
        (2.2e8, 82.2),
        (0.0, 80.8),
    ):
        torsional = compliances_in_shaft(engine, analysis, bearing).torsional
        named = engine_torsional_chain(engine, torsional, inertias(engine, analysis))
        inertia = named.chain.inertia
        if bearing == 0.0:
            torsional = np.full(6, analysis.torsional_compliance("pinned"))
        else:
            torsional = by_hand(analysis, np.radians(engine.throw_angles_deg), bearing)[1]
        # Half a throw on either side of each crank, between free end and flywheel.
        between = np.concatenate(
            ([0.5 * torsional[0]], 0.5 * (torsional[1:] + torsional[:-1]), [0.5 * torsional[-1]])
        )
        stiffness = np.zeros((8, 8))
        for place, compliance in enumerate(between):
            rows = np.ix_([place, place + 1], [place, place + 1])
            stiffness[rows] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / compliance
        squares = np.sort(np.linalg.eigvals(stiffness / inertia[:, None]).real)
        own = math.sqrt(squares[1]) / (2.0 * math.pi)
        figure(
            "first torsional frequency", named.chain.modes().elastic_frequencies[0], own, 1e-9, "Hz"
        )
        figure("the same, as found by others", own, published, 1e-3, "Hz")


def inertias(engine, analysis):
    from crankfem.analyses.shaft.chains import engine_throw_inertias

    return engine_throw_inertias(engine, analysis.masses.inertia_about_shaft)
