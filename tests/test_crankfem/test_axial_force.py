"""Axial force over the cycle, against a shaft assembled by hand angle by angle and a chain solved by hand."""

import csv
import json

import numpy as np
import pytest
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.bearings import bearing_stiffness
from crankfem.analyses.shaft.chains import magnifier_of
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.vibration.axial_cycle import axial_cycle
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, forces_over_speeds
from crankfem.analyses.vibration.modes import axial_vibration, torsional_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.mechanism_file import mechanism_of
from dynamics.excitation.axial_cycle import axial_force_over_cycle
from fem.superelement import RZ, UX, UY, UZ

# Six in line turning against the angles of the file; four throws of a V engine, two cylinders to a pin.
ENGINES = ["6chn25-34", pytest.param("8chn13-14", marks=pytest.mark.further)]


@pytest.fixture(scope="module", params=ENGINES)
def case(request, coarse_throw):
    engine = load_engine(request.param)
    analysis = coarse_throw(request.param)[1]
    shaft = compliances_in_shaft(engine, analysis)
    chains = EngineChains.of(
        engine,
        axial_vibration(engine, analysis, shaft, None),
        torsional_vibration(engine, analysis, shaft, None),
        shaft,
    )
    harmonics = engine_harmonics(engine, mechanism_of(engine))
    return chains, analysis.superelement, harmonics, axial_cycle(chains, harmonics)


def solved_by_hand(matrix, loads, held):
    """Motions of a shaft with some unknowns held, and the forces on these."""
    free = np.setdiff1d(np.arange(len(matrix)), held)
    motions = np.zeros_like(loads)
    motions[free] = np.linalg.solve(matrix[np.ix_(free, free)], loads[free])
    return motions, (matrix @ motions - loads)[held]


@pytest.mark.slow
def test_against_a_shaft_assembled_by_hand(case):
    chains, superelement, harmonics, found = case
    engine = chains.engine_file
    throws = [superelement.turned(angle) for angle in engine.throw_angles]
    size = 6 * (len(throws) + 1)
    matrix = np.zeros((size, size))
    for place, throw in enumerate(throws):
        matrix[6 * place : 6 * place + 12, 6 * place : 6 * place + 12] += throw.stiffness
    for across in (UX, UY):
        matrix[range(across, size, 6), range(across, size, 6)] += bearing_stiffness(engine).nominal
    tangential, radial = harmonics.at(found.shaft_angles, engine.engine.rated_speed)
    assert len(found.shaft_angles) == 720
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
    assert found.held == close(taken[0], abs=1e-5 * most)
    assert found.held == close(-taken[1], abs=1e-5 * most)
    # Held at the flywheel's end alone, each throw lengthens freely; no support takes anything axial.
    moved, taken = solved_by_hand(matrix, loads, [last, size - 6 + RZ])
    free = np.diff(moved[UZ::6], axis=0)
    assert found.throws * chains.shaft.axial == close(free.T, abs=1e-5 * np.max(np.abs(free)))
    assert np.max(np.abs(taken[0])) < 1e-5 * most


@pytest.mark.slow
def test_thrust_bearing_against_a_chain_solved_by_hand(case):
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
    node = engine.thrust_bearing.bearing
    assert chain.ground[node] == engine.thrust_bearing.stiffness
    force = np.zeros(len(found.shaft_angles))
    for order, acting in zip(harmonics.orders, forces, strict=True):
        w = order * engine.engine.rated_speed
        moved = np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, acting)
        assert moved.shape == (count,)
        turned = np.exp(1j * order * found.shaft_angles)
        force += engine.thrust_bearing.stiffness * (moved[node] * turned).real
    assert found.thrust_bearing == close(force, abs=1e-8 * np.max(np.abs(force)))
    assert np.mean(found.thrust_bearing) == close(0.0, abs=1e-9 * np.max(np.abs(force)))


@pytest.mark.slow
def test_command_tells_and_writes_it(call, tmp_path):
    answer = call("vibration", "vw-tdi", "--csv", "tables", "--pictures", "pictures", "--json")
    record = answer.json()["axial_force"]
    text = (tmp_path / "tables" / "axial_force.csv").read_text(encoding="utf-8").splitlines()
    assert text[0].startswith("# axial forces over the cycle at 4000 1/min")
    rows = list(csv.DictReader(text[1:]))
    assert len(rows) == 720
    assert list(rows[0])[:3] == ["shaft_angle_deg", "thrust_bearing_N", "held_N"]
    for name in ("thrust_bearing", "held"):
        column = np.array([float(row[f"{name}_N"]) for row in rows])
        assert record[name]["lowest"] == close(column.min())
        assert record[name]["highest"] == close(column.max())
        highest = float(rows[int(np.argmax(column))]["shaft_angle_deg"])
        assert record[name]["highest_angle_deg"] == close(highest, abs=1e-9)
    # The worst running speed is at least as bad as the rated one.
    span = record["thrust_bearing"]["highest"] - record["thrust_bearing"]["lowest"]
    assert record["running"]["amplitude"] >= 0.5 * span * (1.0 - 1e-3)
    said = " ".join(record["sentences"])
    for value in (
        record["thrust_bearing"]["lowest"],
        record["thrust_bearing"]["highest"],
        record["running"]["amplitude"],
        record["held"]["lowest"],
        record["held"]["highest"],
    ):
        assert f"{value / 1e3:.3g} kN" in said
    assert (tmp_path / "pictures" / "axial_force.svg").is_file()
    json.dumps(record, allow_nan=False)


def test_two_throws_by_hand():
    # Z on pin 1 lengthens throw 1 by 2 and throw 2 by -1; T on pin 2 both by 1 [nm/N].
    influence = 1e-9 * np.array([[[2.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]]])
    forces = np.array([[[1e3, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1e3]]])
    found = axial_force_over_cycle([0.0, 1.0], 10.0, forces, [1e-9, 3e-9], influence)
    assert found.throws == close(np.array([[2000.0, -1000.0 / 3.0], [1000.0, 1000.0 / 3.0]]))
    assert found.held == close([250.0, 500.0])
    assert found.thrust_bearing is None
    assert list(found.columns()) == ["shaft_angle_deg", "held_N", "throw_1_N", "throw_2_N"]
    with pytest.raises(InputError, match=r"pin_forces: given an array of shape \(1, 2, 2\)"):
        axial_force_over_cycle([0.0, 1.0], 10.0, forces[:1], [1e-9, 3e-9], influence)
