"""One quantity has one value wherever it is told: pairs of places that calculate it are compared."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.shaft.throw_analyses import crank_analyses
from crankfem.analyses.shaft.whole_records import shaft_balance, throws_in_shaft
from crankfem.analyses.strength.cycle_loads import HIGHEST_ORDER, judged_speeds, shaft_loads
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.optimum.frequencies import first_frequency
from dynamics.response.series import synthesis
from fem.analysis import analyze_throw

pytestmark = pytest.mark.further

# A V engine that misfires badly; a generating set with a damper, a coupling and counterweights.
ENGINES = ["yamz-5340", "7l32-40-set"]
# Powers are integrals over samples or over orders of the same pressure.
INTEGRALS = 1e-6


@cache
def results_of(name):
    """Results of a shipped engine, once for all files of tests."""
    engine = load_engine(name)
    analyses = {
        name: analyze_throw(throw, engine.material, 0.1, sections="rigid")
        for name, throw in engine.named_throws.items()
    }
    run = engine_vibration(engine, analysis=analyses)
    return SimpleNamespace(
        engine=engine,
        run=run,
        in_mechanism=run_mechanism(engine),
    )


@pytest.fixture(scope="module", params=ENGINES)
def told(request):
    return results_of(request.param)


def at_rated(told, speeds):
    return int(np.argmin(np.abs(speeds - told.engine.engine.rated_speed)))


def test_torque_power_and_pressure_at_rated_speed(told):
    forces, load = told.run.forced_torsional.forces, told.run.load
    work, torque = told.in_mechanism.works, told.in_mechanism.torque
    rated = at_rated(told, forces.speeds)
    assert forces.mean_torque[rated] == close(torque.mean, rel=1e-12)
    rated = at_rated(told, load.speeds)
    assert load.power[rated] == close(torque.power, rel=INTEGRALS)
    assert load.peak_pressure[rated] == close(max(own.peak_pressure for own in work), rel=1e-12)
    mean = np.mean([own.mean_effective_pressure for own in work])
    assert load.mean_pressure[rated] == close(mean, rel=INTEGRALS)


def test_masses_and_inertias(told):
    engine, chain = told.engine, told.run.torsional.chosen.chain
    cranks = crank_analyses(engine, told.run.analyses)
    solids = sum(crank.masses.inertia_about_shaft for crank in cranks)
    layout = told.in_mechanism.layout
    assert layout.shaft_inertia - engine.attached_inertia == close(solids, rel=1e-9)
    # The whole crankshaft has its ends, too.
    assert shaft_balance(engine).inertia_about_shaft >= solids * (1.0 - 1e-9)
    assert sum(crank.mass for crank in cranks) <= shaft_balance(engine).mass * (1.0 + 1e-9)
    ends = [
        chain.chain.inertia[chain.nodes.index(name)]
        for name in ("free end", "flywheel")
        if name in chain.nodes
    ]
    assert engine.attached_inertia == close(sum(ends), rel=1e-9)
    # Half of what moves with the piston, and what turns with the pin.
    moving = engine.piston.mass + engine.rod.mass - engine.rod.rotating_mass
    radius = 0.5 * engine.engine.stroke
    rods = engine.engine.cylinders * (engine.rod.rotating_mass + 0.5 * moving) * radius**2
    inertias = chain.chain.inertia[list(chain.throw_nodes)]
    assert sum(inertias) == close(solids + rods, rel=1e-9)


@pytest.mark.parametrize("kind", ["axial", "torsional"])
def test_first_frequency_of_the_crankshaft(told, kind):
    vibration, bearings = told.run.modes(kind), told.run.bearings
    first = vibration.chosen.first_frequency
    ranges = told.run.assessment.uncertainty[kind].frequencies
    others = [
        vibration.crankshaft_mode.frequency,
        first_frequency(vibration.chosen.chain),
        ranges[vibration.crankshaft_mode.number - 1].nominal,
        *(own.first_frequency for own in vibration.sources if own.source == vibration.source),
    ]
    if bearings is not None:
        others.append(bearings.chains[kind][len(bearings.stiffness) // 2])
    assert others == close([first] * len(others), rel=1e-12)


def test_compliances_of_the_throws_in_the_shaft(told):
    run = told.run
    in_shaft = throws_in_shaft(run.shaft, crank_analyses(told.engine, run.analyses))
    for kind in ("axial", "torsional"):
        chosen = run.modes(kind).chosen
        (source,) = (own for own in run.modes(kind).sources if own.source == chosen.source)
        assert chosen.compliances == close(getattr(in_shaft.compliances, kind), rel=1e-12)
        assert source.mean_compliance == close(np.mean(chosen.compliances), rel=1e-12)
    assert 1.0 / run.axial_chain.stiffness[: len(in_shaft.compliances.axial)] == close(
        in_shaft.compliances.axial, rel=1e-12
    )


def test_worst_uses_of_limits(told):
    verdict, bearings = told.run.assessment.verdict, told.run.bearings
    most = max(check.used for check in verdict.checks)
    assert verdict.checks[0].used == told.run.worst_check.used == most
    if bearings is not None:
        place = len(bearings.stiffness) // 2
        assert max(used[place] for used in bearings.used.values()) == close(most, rel=1e-12)
    for check in told.run.misfiring.checks:
        if check.limit is None:
            continue
        running = [own.running for own in verdict.checks if own.limit.name == check.limit.name]
        worst = max(running, key=lambda own: own.used)
        assert check.normal.used == close(worst.used, rel=1e-5)
        assert check.normal.speed == close(worst.speed, rel=1e-4)


def test_torques_in_tables_strength_and_stress(told):
    forced, file = told.run.forced_torsional, told.engine
    kept, _ = judged_speeds(told.run)
    counted = forced.orders <= HIGHEST_ORDER[file.engine.strokes]
    elastic = forced.loads.elastic
    amplitude = synthesis(
        elastic.orders[counted], elastic.speeds, elastic.values[counted], elastic.unbounded[counted]
    ).amplitude[kept]
    chain = forced.engine_chain
    for throw, load in enumerate(shaft_loads(told.run).normal):
        beside = [
            place
            for place, nodes in enumerate(chain.chain.connections[: chain.crank_elements])
            if chain.throw_nodes[throw] in nodes
        ]
        assert load.value == close(amplitude[:, beside].max(), rel=1e-9)
    running = forced.speed_parts["running"]
    for place, modulus in forced.moduli.items():
        most = elastic.synthesis.amplitude[running, place].max() / modulus
        peak = next(own for own in forced.stress_peaks if own.element == elastic.names[place])
        assert peak.running.peak == close(most, rel=1e-12)


def test_use_of_a_limit_by_a_peak_alone(told):
    forced = told.run.forced_torsional
    limit = told.run.assessment.limits["crankshaft_stress"]
    names = list(forced.stress.names)
    results_of = [
        peak for peak in forced.peaks if peak.place in names and np.isfinite(peak.limit_used)
    ]
    assert results_of
    for peak in results_of:
        modulus = forced.moduli[list(forced.loads.elastic.names).index(peak.place)]
        own = peak.amplitude / modulus / limit.continuous.at(np.array([peak.speed]))[0]
        assert peak.limit_used == close(own, rel=1e-6)


def test_force_on_the_thrust_bearing(told):
    engine, forced, thrust = told.engine, told.run.forced_axial, told.run.thrust
    node = forced.engine_chain.sections[engine.thrust_bearing.section_index]
    rated = at_rated(told, forced.speeds)
    moved = forced.response.synthesis
    both = thrust.thrust_bearing.lowest, thrust.thrust_bearing.highest
    wanted = moved.lowest[rated, node], moved.highest[rated, node]
    assert both == close(engine.thrust_bearing.stiffness * np.array(wanted), rel=1e-9)
    running = forced.speed_parts["running"]
    by_ground = forced.loads.ground.synthesis.amplitude[running, node].max()
    assert thrust.running.amplitude == close(by_ground, rel=1e-12)
