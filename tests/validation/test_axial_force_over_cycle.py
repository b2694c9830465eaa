"""Axial force of a crankshaft over the working cycle.

Source: shaft of superelements on bearing springs, solved with all pin loads at every degree, and the damped
axial chain. Yamanin and Zhukov 2021, doi 10.24143/2073-1574-2021-4-75-83, figure 5, without dimensions.

Tolerance: 1e-5: round-off and the superelement's turning residual, 2e-6; the chain, solved twice, 1e-8.
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from comparing import close
from crankfem.analyses.shaft.chains import magnifier_of
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.vibration.axial_cycle import axial_cycle
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, forces_over_speeds
from crankfem.analyses.vibration.modes import axial_vibration, torsional_vibration
from crankfem.files.engine.engine_file import load_engine
from fem.analysis import analyze_throw
from fem.superelement import RZ, UX, UY, UZ

pytestmark = pytest.mark.slow

# Six in line turning against the angles of the file; four throws of a V engine, two cylinders to a pin.
ENGINES = ["6chn25-34", pytest.param("8chn13-14", marks=pytest.mark.further)]


@pytest.fixture(scope="module", params=ENGINES)
def case(request):
    engine = load_engine(request.param)
    # As coarse as may be: all that is compared comes from one superelement.
    analysis = analyze_throw(engine.throw, engine.material, 0.1, sections="rigid")
    shaft = compliances_in_shaft(engine, analysis)
    chains = EngineChains.of(
        engine,
        axial_vibration(engine, analysis, shaft, None),
        torsional_vibration(engine, analysis, shaft, None),
        shaft,
    )
    harmonics = engine_harmonics(engine)
    return chains, analysis.superelement, harmonics, axial_cycle(chains, harmonics)


def solved_by_hand(matrix, loads, held):
    """Motions of a shaft with some unknowns held, and the forces on these."""
    free = np.setdiff1d(np.arange(len(matrix)), held)
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(matrix[np.ix_(free, free)], loads[free])
    return motions, (matrix @ motions - loads)[held]


def test_against_a_shaft_assembled_by_hand(case, figure):
    chains, superelement, harmonics, found = case
    engine = chains.engine_file
    throws = [superelement.turned(angle_deg=angle) for angle in engine.throw_angles_deg]
    size = 6 * (len(throws) + 1)
    matrix = np.zeros((size, size))
    for place, throw in enumerate(throws):
        matrix[6 * place : 6 * place + 12, 6 * place : 6 * place + 12] += throw.stiffness
    for across in (UX, UY):
        matrix[range(across, size, 6), range(across, size, 6)] += engine.main_bearings.stiffness
    tangential, radial = harmonics.at(
        engine.engine.rated_speed, shaft_angle_deg=found.shaft_angles_deg
    )
    assert len(found.shaft_angles_deg) == 720
    loads = np.zeros((size, 720))
    for cylinder, place in enumerate(engine.throws):
        # In the frame of the crank: y away from the shaft, T along -x where the shaft turns about +z.
        across, along = -engine.engine.turning_sense * tangential[:, cylinder], -radial[:, cylinder]
        on_pin = throws[place].pin_loads[0]
        loads[6 * place : 6 * place + 12] += np.outer(on_pin[:, 0], across)
        loads[6 * place : 6 * place + 12] += np.outer(on_pin[:, 1], along)
    # Both ends held along the shaft, the flywheel's end against turning.
    first, last = UZ, size - 6 + UZ
    _, taken = solved_by_hand(matrix, loads, [first, last, size - 6 + RZ])
    most = np.max(np.abs(found.held))
    ends = np.stack((taken[0], -taken[1]))
    figure("force on held ends", found.held + 0.0 * ends, ends, 1e-5, "N", scale=most)
    # Held at the flywheel's end alone, each throw lengthens freely; no support takes anything axial.
    moved, taken = solved_by_hand(matrix, loads, [last, size - 6 + RZ])
    free = np.diff(moved[UZ::6], axis=0)
    lengthened = found.throws * chains.shaft.axial
    most_free = np.max(np.abs(free))
    figure("lengthening of the throws", lengthened, free.T, 1e-5, "m", scale=most_free)
    figure("axial force of one end held", taken[0], 0.0 * taken[0], 1e-5, "N", scale=most)


def test_thrust_bearing_against_a_chain_solved_by_hand(case, figure):
    chains, _, harmonics, found = case
    engine, chain = chains.engine_file, chains.pulled.chain.chain
    pulled, _ = chains.answers(
        forces_over_speeds(engine, harmonics, np.array([engine.engine.rated_speed]))
    )
    forces = pulled.response.excitation.forces[:, 0]
    count = len(chain.inertia)
    stiffness = np.diag(chain.ground)
    for (left, right), spring in zip(chain.connections, chain.stiffness, strict=True):
        stiffness[np.ix_([left, right], [left, right])] += spring * np.array([[1, -1], [-1, 1]])
    mass = np.diag(chain.inertia)
    squares, shapes = eigh(stiffness, mass)
    modal = np.diag(np.sqrt(squares) / magnifier_of(engine, "axial")[0])
    damping = mass @ shapes @ modal @ shapes.T @ mass
    node = engine.thrust_bearing.section_index
    assert chain.ground[node] == engine.thrust_bearing.stiffness
    force = np.zeros(len(found.shaft_angles_deg))
    for order, acting in zip(harmonics.orders, forces, strict=True):
        w = order * engine.engine.rated_speed
        moved = np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, acting)
        assert moved.shape == (count,)
        turned = np.exp(1j * order * np.radians(found.shaft_angles_deg))
        force += engine.thrust_bearing.stiffness * (moved[node] * turned).real
    most = np.max(np.abs(force))
    figure("force on the thrust bearing", found.thrust_bearing, force, 1e-8, "N", scale=most)
    assert np.mean(found.thrust_bearing) == close(0.0, abs=1e-9 * most)
