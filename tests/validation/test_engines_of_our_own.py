"""Critical speeds and causes of peaks of three engines of our own.

Source: dynamic stiffness of the chains' matrices, numpy alone, at speeds in steps of 2e-4.

Tolerance: 0.2 % of the speed, 1 % of the amplitude; the orders' parts by their sum over the shaft angle,
1e-9.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import peak_prominences

import crankfem as cf

FOLDER = Path(__file__).parents[1] / "data" / "engines"
NAMES = ("8l32-42-damper", "5-42-176-propeller", "v12-170-190")
# Peaks below this share of the largest are not compared one by one, and what stands out of its surroundings
# by less than this share of itself is no peak: where another element takes over, a curve may be that flat.
LEAST, FLAT = 1e-3, 1e-4


@pytest.fixture(scope="module", params=NAMES)
def run(request):
    # At full load at all speeds: along the propeller's law order 4 has two tops of one mode within 4 % of
    # the speed, in different elements, of which only the higher one is told.
    engine = cf.load_engine(FOLDER / f"{request.param}.toml").changed(load=None)
    throw = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    return cf.engine_vibration(engine, analysis=throw).forced_torsional


def twists(run, order, speeds):
    """Twists of the crankshaft's elements times their stiffness, (S, e), at speeds of one order."""
    response, chain = run.response, run.response.chain
    forces = response.excitation.at_speeds(speeds).forces[response.orders.tolist().index(order)]
    w = (order * speeds)[:, np.newaxis, np.newaxis]
    system = response.system
    dynamic = system.stiffness + 1j * system.loss + 1j * w * system.damping - w**2 * system.mass
    motion = np.linalg.solve(dynamic, forces[..., np.newaxis])[..., 0]
    count = len(run.crank_elements.names)
    pairs = np.array(chain.connections[:count])
    return chain.stiffness[:count] * (motion[:, pairs[:, 1]] - motion[:, pairs[:, 0]])


@pytest.mark.further
def test_critical_speeds_are_peaks(run, figure):
    low, high = run.judged_range
    speeds = low * np.exp(np.arange(0.0, np.log(high / low), 2e-4))
    found = cf.response.damped_criticals(
        run.response, elements=run.crank_elements.names, speed_range=run.judged_range
    )
    largest = max(one.amplitude for one in found if one.has_peak)
    compared = 0
    for order in run.response.orders.tolist():
        rows = [one for one in found if one.order == order and one.has_peak]
        for name, values in zip(
            run.crank_elements.names, np.abs(twists(run, order, speeds)).T, strict=True
        ):
            tops = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
            told = [one for one in rows if one.place == name and one.amplitude > LEAST * largest]
            for one in told:
                top = tops[np.argmin(np.abs(speeds[tops] - one.speed))]
                figure("critical speed", one.speed, speeds[top], 2e-3, "rad/s")
                figure("torque there", one.amplitude, values[top], 1e-2, "N m")
                compared += 1
            tops = tops[values[tops] > LEAST * largest]
            tops = tops[peak_prominences(values, tops)[0] > FLAT * values[tops]]
            for speed in speeds[tops]:
                assert any(
                    name in (one.place, *one.others)
                    and 0.995 * one.spread[0] <= speed <= 1.005 * one.spread[1]
                    for one in rows
                ), (order, name, speed)
    assert compared >= 5


@pytest.mark.further
def test_parts_of_orders_make_the_largest_stress(run, figure):
    stress = run.stress
    place = stress.largest_place
    index = int(np.argmax(stress.synthesis.amplitude[:, place]))
    cause = cf.response.peak_cause(run.response, stress, place, index, unit="Pa", kind="torsional")
    angles = np.linspace(0.0, 4.0 * np.pi, 40_001)
    waves = stress.at_angle(index, shaft_angle_deg=np.degrees(angles))[:, place]
    figure("largest stress", cause.amplitude, 0.5 * np.ptp(waves), 1e-5, "Pa")
    figure(
        "sum of the orders' parts",
        sum(one.contribution for one in cause.parts),
        cause.amplitude,
        1e-9,
    )
    for one in cause.resonant:
        assert one.magnifier >= 2.0
        assert one.mode_share > 0.5
    assert "unbounded" not in cause.sentence


def test_files_are_accepted():
    for name in NAMES:
        assert cf.load_engine(FOLDER / f"{name}.toml").engine.cylinders in (5, 8, 12)
