"""What is said of an engine that nobody tuned for, recomputed from the numbers of the same run.

A car's four in line (the shipped one) on a flywheel of two masses joined by soft springs: numbers of no
engine, idling at 800 1/min above a resonance of the coupling with order 2. The frequency of the
coupling is that of two inertias on a spring within 0.5 %, as the crankshaft is some 700 times as stiff.
"""

from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.sentences import finished
from crankfem.analyses.findings import verdict_line
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, failing_harmonics
from crankfem.analyses.vibration.engine_limits import engine_limits, engine_verdict, limit_findings
from crankfem.analyses.vibration.misfiring import Superposition
from crankfem.analyses.vibration.tables import (
    critical_lines,
    is_listed,
    resonance_table,
    speed_table,
)
from crankfem.files.engine.engine_file import load_engine
from crankfem.report.summary import _first_frequencies, _worst_critical

FILE = Path(__file__).parents[2] / "data/engines/vw-tdi.toml"
RPM = 30.0 / np.pi
IDLE, STIFFNESS, DRIVEN, PASSING = 800.0, 752.0, 0.1, 200.0
SECTIONS = f"""
[driven]
inertia = "{DRIVEN} kg m^2"
coupling_stiffness = "{STIFFNESS} N m/rad"
coupling_loss_factor = 0.1

[limits]
crankshaft_stress = "400 MPa"
coupling_torque = "80 N m"
coupling_torque_passing = "{PASSING} N m"

[load]
law = "propeller"

[sources]"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    text = FILE.read_text(encoding="utf-8").replace('"900 1/min"', f'"{IDLE:g} 1/min"')
    path = tmp_path_factory.mktemp("engine") / "car.toml"
    path.write_text(text.replace("\n[sources]", SECTIONS), encoding="utf-8")
    engine = load_engine(path)
    analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    return cf.engine_vibration(engine, analysis=analysis)


def test_the_first_frequency_is_the_lowest_whatever_moves_in_it(run):
    cranks = run.torsional.inertia.sum() - DRIVEN
    alone = np.sqrt(STIFFNESS * (1.0 / cranks + 1.0 / DRIVEN)) / (2.0 * np.pi)
    first, own = run.torsional.first_mode, run.torsional.crankshaft_mode
    assert first.frequency == close(alone, rel=5e-3)
    assert own.number == 2
    _, value, details, *_ = _first_frequencies(run)
    assert finished(value).startswith("17.0 / ")
    assert any(f"torsional mode 2 {own.frequency:.0f} Hz" in finished(text) for text in details)


def test_a_critical_speed_below_idling_stands_in_a_table(run):
    """Order 2 meets the coupling's mode at 30 times its frequency."""
    (peak,) = (
        peak
        for peak in run.forced_torsional.started_through
        if peak.order == 2.0 and peak.modes[:1] == (1,) and peak.severity == 1.0
    )
    assert peak.speed * RPM == close(30.0 * run.torsional.first_mode.frequency, rel=0.01)
    assert not peak.in_running_range
    (row,) = (row for row in speed_table(run).rows if row[1] == peak.speed)
    assert row[:1] + row[2:3] == ["torsional", "start"]
    assert all(peak.speed * RPM > IDLE * (1.0 - 1e-9) for peak in run.forced_torsional.peaks)


def test_what_cannot_be_passed_on_starting_decides(run):
    """All limits are kept at running speeds; on starting the coupling takes more than may be passed."""
    verdict = run.assessment.verdict
    assert verdict.status == "not acceptable"
    assert all(check.passed for check in verdict.checks)
    check = verdict.deciding
    speeds = check.curve.speeds
    below = speeds < IDLE / RPM * (1.0 - 1e-9)
    largest = check.curve.values[below].max()
    assert (check.worst_value, check.used) == (largest, largest / PASSING)
    line = verdict_line(run)
    assert f"coupling {100.0 * largest / PASSING:.0f} % of" in line
    # The order that makes it, and its critical speed.
    main = max(check.cause.parts, key=lambda part: part.contribution)
    assert (main.order, main.mode, main.kind) == (2.0, 1, "torsional")
    shown = float(finished(_worst_critical(run)[1]).split()[0])
    assert shown == close(check.worst_speed * RPM, rel=0.01)
    assert any(
        line.speed is not None and line.speed < IDLE / RPM
        for line in critical_lines(run, "torsional")
    )


def test_the_ends_of_what_misfiring_exceeds_are_where_a_limit_is_met(run):
    """A tenth of a thousandth inside them a limit is exceeded in one of the cases, outside in none."""
    misfiring, file = run.misfiring, run.engine_file
    firing = engine_harmonics(file)
    chains = EngineChains.of(file, run.axial, run.torsional, run.shaft)
    added = Superposition(chains, firing, failing_harmonics(file, firing))
    limits = engine_limits(file)[0]
    inside, outside = [], []
    for low, high in misfiring.exceeded:
        if low > 1.001 * misfiring.running_range[0]:
            outside.append(low * (1.0 - 1e-4))
            inside.append(low * (1.0 + 1e-4))
        if high < 0.999 * misfiring.running_range[1]:
            outside.append(high * (1.0 + 1e-4))
            inside.append(high * (1.0 - 1e-4))
    assert inside

    def most(speeds):
        speeds = np.sort(speeds)
        used = np.zeros(len(speeds))
        for _, found in added.at(speeds, misfiring.cases):
            for name, limit in limits.items():
                permitted = limit.misfiring.at(speeds)[:, np.newaxis]
                used = np.maximum(used, np.max(found[name].synthesis.amplitude / permitted, axis=1))
        return used

    assert np.all(most(inside) > 1.0)
    assert np.all(most(outside) < 1.0)
    assert np.all(most(outside) > 0.99)
    # Together with what remains, and what is left out anyway, they are all running speeds.
    parts = sorted((*misfiring.exceeded, *misfiring.remaining, *misfiring.otherwise))
    ends = np.array(parts)
    assert ends[[0, -1], [0, 1]] == close(run.running_range)
    assert ends[1:, 0] == close(ends[:-1, 1])
    assert all(low * 1.05 <= high for low, high in misfiring.advised)


def test_nothing_is_barred_below_the_lowest_running_speed(run):
    file = run.engine_file.changed(limits={"coupling_torque": 34.0, "crankshaft_stress": 400e6})
    verdict = engine_verdict(file, limit_findings(file, run.forced_axial, run.forced_torsional))
    span = next(span for span in verdict.barred if "torque of coupling" in span.limits)
    assert span.low == run.running_range[0] < span.high
    assert span.ends


def test_what_a_table_leaves_out_is_less_severe(run):
    for forced in (run.forced_axial, run.forced_torsional):
        listed = [peak for peak in forced.resonances if is_listed(peak) and peak.has_peak]
        speeds = [row[0] for row in resonance_table(forced).rows]
        shown = [peak.severity for peak in listed if peak.speed in speeds]
        left = [peak.severity for peak in listed if peak.speed not in speeds]
        assert shown
        assert max(left, default=0.0) < min(shown)
