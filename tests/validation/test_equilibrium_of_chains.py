"""Equilibrium of every body of all chains.

Source: Newton's second law: the force through a throw accelerates all masses up to the free end.

Tolerance: 1e-9 of the largest spring force, round-off; 0.5 % where modal damping acts on all masses (0.3
%); values printed to 0.1 kN 0.2 kN.

Nothing pulls at a crankpin along the shaft, so that force is m w^2 x of each order, besides what damps
them. In torsion gas and inertia torques of the throws act too. Amplitudes of 6ChN 25/34, 7.2 to 68.0 kN,
are these sums of the motion at running speeds, without the forces of damping. The modes' damping has
magnifier 40; misfiring looks for its speeds itself, 0.1 %; speeds miss the peak by 0.1 %.
"""

from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.strength.cycle_loads import shaft_loads, superposition
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import (
    calculated_range,
    engine_harmonics,
    failing_harmonics,
    forces_over_speeds,
)
from crankfem.analyses.vibration.modes import axial_vibration, torsional_vibration
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.file_kinds import engine_sections, file_kind
from crankfem.files.reading.data_files import shipped_names
from dynamics.response.series import synthesis
from equilibrium import unbalanced
from fem.analysis import analyze_throw

QUICK = "6chn25-34"
KILO = 1e-3


def engines():
    """Shipped engines and those of our own, with gas pressure."""
    own = sorted((Path(__file__).parents[1] / "data" / "engines").glob("*.toml"))
    return [
        pytest.param(
            file,
            id=Path(file).stem,
            marks=pytest.mark.slow if file == QUICK else pytest.mark.further,
        )
        for file in (*shipped_names("engine"), *own)
        if file_kind(sections := engine_sections(file)) == "engine"
        and {"gas", "gas_map"} & set(sections.sections)
    ]


@pytest.mark.parametrize("name", engines())
def test_all_bodies(name, figure):
    engine = load_engine(name)
    # As coarse as may be: equilibrium holds for any compliances.
    analyses = {
        throw: analyze_throw(dimensions, engine.material, 0.1, sections="rigid")
        for throw, dimensions in engine.named_throws.items()
    }
    shaft = compliances_in_shaft(engine, analyses)
    chains = EngineChains.of(
        engine,
        axial_vibration(engine, analyses, shaft, None),
        torsional_vibration(engine, analyses, shaft, None),
        shaft,
    )
    firing = engine_harmonics(engine)
    speeds = np.linspace(*calculated_range(engine), 40)
    cases = {"firing": forces_over_speeds(engine, firing, speeds)}
    if engine.gas is not None and not engine.engine.driven_by:
        failing = failing_harmonics(engine, firing)
        cases["without combustion"] = forces_over_speeds(engine, failing, speeds)
    for case, forces in cases.items():
        pulled, turned = chains.answers(forces, propeller=False)
        torques = np.zeros_like(turned.response.motion)
        for cylinder, throw in enumerate(engine.throws):
            node = turned.engine_chain.throw_nodes[throw]
            torques[:, :, node] += 0.5 * engine.engine.stroke * forces.tangential[:, :, cylinder]
        left = unbalanced(turned.response, torques)
        figure(f"force left on any body, torsional, {case}", left, 0.0, 1e-9, "", kind="absolute")
        left = unbalanced(pulled.response, np.zeros_like(pulled.response.motion))
        figure(f"force left on any body, axial, {case}", left, 0.0, 1e-9, "", kind="absolute")


def from_the_free_end(response, throws):
    """What accelerates the masses between the free end and each throw, by orders (K, S, n)."""
    chain, w = response.chain, response.angular_frequencies[:, :, np.newaxis]
    return -np.cumsum(w**2 * chain.inertia * response.motion, axis=2)[:, :, :throws]


@pytest.mark.further
def test_axial_force_of_throws_is_one_wherever_it_is_judged(figure):
    limit = 80e3
    engine = load_engine(QUICK).changed(limits={"axial_force": limit})
    run = engine_vibration(engine)
    forced, verdict = run.forced_axial, run.assessment.verdict
    response, running = forced.response, forced.speed_parts["running"]
    sums = from_the_free_end(response, 6)
    by_masses = synthesis(response.orders, response.speeds, sums).amplitude[running].max(axis=0)
    known = np.array([7.2, 21.4, 34.7, 47.2, 58.7, 68.0])
    figure("by masses, 6ChN 25/34", KILO * by_masses, known, 0.2, "kN", kind="absolute")
    checks = {
        check.place: check for check in verdict.checks if check.limit.name.startswith("axial force")
    }
    judged = np.array([checks[name].running.value for name in forced.crank_elements.names])
    figure("as judged", judged, by_masses, 5e-3, "N", scale=by_masses[-1])
    assert {check.passed for check in checks.values()} == {True}
    assert max(check.used for check in checks.values()) == close(0.85, abs=0.005)
    # One definition: table, causes, misfiring and strength have what is judged.
    listed = np.array([peak.running.peak for peak in forced.load_peaks])
    figure("in the table of elements", listed, judged, 1e-9, "N")
    for check in checks.values():
        assert check.cause.amplitude == close(check.worst_value, rel=1e-9)
        assert sum(part.contribution for part in check.cause.parts) == close(check.worst_value)
    failing = next(one for one in run.misfiring.checks if one.quantity.startswith("axial force"))
    figure("in normal firing, beside misfiring", failing.normal.value, judged.max(), 1e-3, "N")
    added = superposition(run)
    speed = np.array([failing.misfiring.speed])
    pulled, _ = added.chains.answers(added.forces(speed, failing.cylinders))
    sums = from_the_free_end(pulled.response, 6)
    by_masses = synthesis(pulled.response.orders, speed, sums).amplitude.max()
    figure("while a cylinder misfires", failing.misfiring.value, by_masses, 5e-3, "N")
    strength = [load.value for load in shaft_loads(run).axial]
    figure("in the strength", strength, judged, 1e-9, "N")
