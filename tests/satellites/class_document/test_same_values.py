"""What the document tells has the value that other results tell."""

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.strength.cycle_loads import judged_speeds
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.satellites.class_document.firing_cases import (
    MISFIRING,
    STRESS,
    firing_cases,
    heat_of,
)
from crankfem.satellites.class_document.tables import damper_table, mode_stars
from test_crankfem.test_one_definition import ENGINES, at_rated, results_of
from test_crankfem.test_whole_shaft import PLACES, with_limited_line

pytestmark = pytest.mark.further


@pytest.fixture(scope="module", params=ENGINES)
def told(request):
    return results_of(request.param)


@pytest.fixture(scope="module")
def firing(told):
    return firing_cases(told.run)


def test_torque_at_rated_speed(told, firing):
    mean = firing.mean_torque[at_rated(told, firing.speeds)]
    assert mean == close(told.in_mechanism.torque.mean, rel=1e-12)


def test_largest_stress_in_verdict_misfiring_and_class_document(told, firing):
    cases, elements = firing, told.run.forced_torsional.stress.names
    (check,) = (
        own
        for own in told.run.misfiring.checks
        if own.quantity.startswith("torsional stress of cr")
    )
    for (cylinder,), reached in check.each.items():
        found = cases.failing[MISFIRING][cylinder].kept
        worst = max((found[STRESS, name] for name in elements), key=lambda own: own.used)
        assert (worst.place, worst.speed) == (reached.place, close(reached.speed, rel=1e-9))
        assert worst.used == close(reached.used, rel=1e-9)
    # Nothing is barred, so that the class document leaves no running speed out.
    kept, _ = judged_speeds(told.run)
    assert np.all(kept == told.run.forced_torsional.speed_parts["running"])
    worst = max((cases.firing.kept[STRESS, name] for name in elements), key=lambda own: own.used)
    assert worst.used == close(check.normal.used, rel=1e-5)


def test_heat_of_dampers(told, firing):
    power, loads = told.run.forced_torsional.power, told.run.forced_torsional.loads
    chain = told.run.torsional_chain
    for place, name in enumerate(power.dashpot_names):
        series, size = loads.dashpots, chain.dashpots[place].damping
        assert heat_of(series, name, (0.0, 0.0, size)) == close(
            power.dashpots[:, :, place].sum(axis=0), rel=1e-9
        )
    for place, name in enumerate(power.element_names):
        values = chain.stiffness[place], chain.loss_factor[place], chain.damping[place]
        if any(values[1:]):
            assert heat_of(loads.elements, name, tuple(map(float, values))) == close(
                power.elements[:, :, place].sum(axis=0), rel=1e-9
            )
    running = told.run.forced_torsional.speed_parts["running"]
    for name, (heat, _) in firing.firing.heat.items():
        part, names = power.elements, power.element_names
        if name in power.dashpot_names:
            part, names = power.dashpots, power.dashpot_names
        most = part[:, running, names.index(name)].sum(axis=0).max()
        assert heat == close(most, rel=1e-9)


def test_vector_sums_of_the_cylinders(told):
    vibration = told.run.torsional
    rigid = vibration.chosen.modes.rigid
    assert vibration.criticals
    for critical in vibration.criticals:
        stars = mode_stars(told.run, rigid + critical.mode - 1)
        (star,) = (own for own in stars if own.order == critical.order)
        assert critical.phase_sum == close(star.share, abs=1e-9)


def test_permitted_values_of_a_coupling_and_a_damper(coarse_throw):
    plain, analysis = coarse_throw("6chn25-34")
    run = engine_vibration(with_limited_line(plain), analysis=analysis)
    rows = {row[0]: row for row in damper_table(run, firing_cases(run)).rows if row[1] == "normal"}
    assert [rows[place][4] for place in PLACES] == [3e3, 3e3]
    assert [rows[place][6] for place in PLACES] == [2e3, 2e3]
