"""Results over the range of the main bearings' stiffness.

Source: the same engine in bearings of one stiffness each, at its full grid of speeds; the chain's
eigenproblem in the test.

Tolerance: 3 % of the used share, for the sweep's coarse grid, with the same verdict; frequencies round-off.
"""

import math
from functools import cache

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.quantity import compact

pytestmark = pytest.mark.further


@pytest.fixture(scope="module")
def engine():
    return cf.load_engine("6chn25-34")


@pytest.fixture(scope="module")
def analysis(engine):
    return cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)


@pytest.fixture(scope="module")
def nominal(engine, analysis):
    return cf.engine_vibration(engine, analysis=analysis)


@pytest.fixture(scope="module")
def alone(engine, analysis, nominal):
    """The engine with one stiffness of the range, by its place there."""

    @cache
    def calculated(place):
        stiffness = float(nominal.bearings.stiffness[place])
        return cf.engine_vibration(
            engine.changed(bearings={"stiffness": stiffness}), analysis=analysis
        )

    return calculated


def test_used_shares_are_those_of_full_calculations(alone, nominal, figure):
    own = nominal.bearings
    (used,) = own.used.values()
    for place in (0, 1, 5, 6):
        one = alone(place)
        assert one.bearings is None
        assert one.assessment.verdict.status == own.statuses[place]
        figure("used share of the limit", used[place], one.worst_check.used, 0.03)
    assert used[3] == close(nominal.worst_check.used)


def test_the_verdict_says_that_it_changes():
    """Of a V8; the limit lies between what the softest and the stiffest bearings make."""
    engine = cf.load_engine("8chn13-14")
    analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)

    def at(stiffness, limit):
        changed = engine.changed(
            bearings={"stiffness": stiffness}, limits={"crankshaft_stress": limit}
        )
        return cf.engine_vibration(changed, analysis=analysis)

    diameter = engine.throw.main_journal_diameter
    ends = (1e9 * diameter, 1e11 * diameter)
    low, high = (at(stiffness, 1e8).worst_check.worst_value for stiffness in ends)
    limit = math.sqrt(low * high)
    swept = cf.engine_vibration(
        engine.changed(limits={"crankshaft_stress": limit}), analysis=analysis
    )
    own = swept.bearings
    assert own.flips
    for place, stiffness in ((0, ends[0]), (6, ends[1])):
        assert own.stiffness[place] == close(stiffness)
        assert at(stiffness, limit).assessment.verdict.status == own.statuses[place]
    assert (own.statuses[0], own.statuses[-1]) == ("fine", "not acceptable")
    (said,) = [one for one in swept.assessment.beside if "changes within this range" in one]
    assert f'"fine" at {compact(ends[0])}' in said
    assert f"to {compact(ends[1])} N/m" in said


def test_bounds_hold_over_the_range(engine, analysis, nominal, figure):
    """Lowest and highest of the chains in all bearings, with the compliances' own spread on top."""
    found = nominal.assessment.torsional
    (spread,) = found.spreads
    own = []
    for stiffness in nominal.bearings.stiffness.tolist():
        for factor in (spread.low, spread.high):
            one = engine.changed(bearings={"stiffness": stiffness})
            chain = cf.engine_vibration(
                one.changed(gas=None, limits=None), analysis=analysis
            ).torsional_chain
            matrix = chain.stiffness_matrix() / factor
            squares = np.sort(np.linalg.eigvals(matrix / chain.inertia[:, None]).real)
            own.append(math.sqrt(squares[1]) / (2.0 * math.pi))
    figure("lowest first frequency", found.frequencies[0].lowest, min(own), 1e-9, "Hz")
    figure("highest first frequency", found.frequencies[0].highest, max(own), 1e-9, "Hz")


def test_bounds_of_critical_speeds_are_peaks_in_the_softest_and_the_stiffest_bearings(
    alone, nominal, figure
):
    """Of the damped response there, at the full grid; the compliances' spread moves it as the frequency."""
    found = nominal.assessment.torsional
    (spread,) = found.spreads
    peaks = {}
    for place in (0, 6):
        own = alone(place).torsional_chain.modes().elastic_frequencies[0]
        bounds = alone(place).assessment.torsional.frequencies[0]
        shift = (bounds.highest if place else bounds.lowest) / own
        for peak in alone(place).forced_torsional.peaks:
            peaks.setdefault((peak.mode, peak.order), {})[place] = shift * peak.speed
    assert spread.low < 1.0 < spread.high
    judged = [one for one in found.critical if len(peaks.get((one.mode, one.order), {})) == 2]
    assert len(judged) > 3
    for one in judged:
        softest, stiffest = (peaks[one.mode, one.order][place] for place in (0, 6))
        figure(f"lowest critical speed of order {one.order:g}", one.low, softest, 1e-4, "rad/s")
        figure(f"highest critical speed of order {one.order:g}", one.high, stiffest, 1e-4, "rad/s")
