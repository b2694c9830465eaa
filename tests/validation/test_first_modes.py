"""The first mode reported is the crankshaft's own.

Source: two inertias on a coupling of 1e5 N m/rad: 1/(2 pi) sqrt(k (1/J1 + 1/J2)).

Tolerance: 1 %, as the engine is not quite one rigid body.
"""

import math
from types import SimpleNamespace

import pytest

import crankfem as cf
from comparing import close
from crankfem.jobs.run_records import _engine_facts
from crankfem.report.summary import summary

pytestmark = pytest.mark.slow
STIFFNESS, GENERATOR = 1.0e5, 200.0  # N m/rad, kg m^2


@pytest.fixture(scope="module")
def run():
    engine = cf.load_engine("6chn25-34").changed(
        driven={"inertia": GENERATOR, "coupling_stiffness": STIFFNESS}
    )
    analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    return cf.engine_vibration(engine, analysis=analysis, coupled=True)


@pytest.mark.further
def test_a_soft_coupling_is_not_told_as_the_first_mode(run, figure):
    engine = sum(run.torsional_chain.inertia) - GENERATOR
    coupling = math.sqrt(STIFFNESS * (1.0 / engine + 1.0 / GENERATOR)) / (2.0 * math.pi)
    frequencies = run.torsional.chosen.elastic_frequencies
    figure("frequency of the coupling", frequencies[0], coupling, 0.01, "Hz")
    assert run.torsional.chosen.first_frequency == frequencies[1] > 80.0
    first, second = run.torsional.elastic_modes[:2]
    assert (first.of_crankshaft, second.of_crankshaft) == (False, True)
    assert first.crankshaft_share < 0.05
    told = [row[0] for row in run.torsional.mode_table().rows]
    assert told[1:3] == ["1 (coupling, damper or line)", "2"]


def test_summary_names_the_lowest_mode_and_that_of_the_crankshaft(run):
    throw = SimpleNamespace(
        error_words="", axial_correction=0.0, supports={"pinned": SimpleNamespace(axial=1e-9)}
    )
    results = SimpleNamespace(
        engine=_engine_facts(run.engine_file),
        mechanism=None,
        vibration=run,
        inputs=[],
        input_warnings=[],
        throw=throw,
        strength=None,
        throws=None,
        fatigue=None,
        findings=(),
    )
    (found,) = [one for one in summary(results)["frequencies"] if "torsional" in one["label"]]
    lowest, own = run.torsional.chosen.elastic_frequencies[:2]
    assert run.torsional.chosen.first_frequency == own
    (low, high), (own_low, own_high) = (
        [getattr(run.assessment.torsional.frequencies[mode], end) for end in ("lowest", "highest")]
        for mode in (0, 1)
    )
    # What the system's lowest mode is, is one thing; the crankshaft's own is named beside it.
    assert float(found["value"].removesuffix(" Hz")) == close(lowest, rel=0.01)
    assert found["details"][0].startswith("uncertainty range of the chain ")
    assert low <= lowest <= high
    assert any(
        f"the crankshaft's own first, mode 2: {own:.1f} Hz ({own_low:.1f} to {own_high:.1f} Hz)"
        in one
        for one in found["details"]
    )
    shaft = run.comparison.torsional.modes[0].shaft_frequency
    assert any(f"whole crankshaft in its bearings: {shaft:.1f}" in one for one in found["details"])
    assert "a mode of coupling, damper or line" in found["details"]


def test_rotation_is_told_beside_the_lowest_bending_mode(run, figure):
    modes = run.whole.modes
    kinds, frequencies = modes.kinds, modes.frequencies
    first = next(n for n in range(modes.rigid, len(kinds)) if kinds[n] == "bending")
    assert first > modes.rigid  # The coupling's mode is lower.
    bending = run.whole.bending
    turns = run.engine_file.engine.highest_speed / (2.0 * math.pi)
    figure("rotation over bending", bending.rotation_ratio, turns / frequencies[first], 1e-9)
    assert bending.frequency == frequencies[first]
    assert bending.rotation_ratio < 0.2 < run.whole.rotation_ratios[0]
