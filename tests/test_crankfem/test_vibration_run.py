"""Forced vibration, verdict and command of engines, from their files."""

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import damped_engine_chain, engine_torsional_chain
from crankfem.analyses.vibration.chain_answers import nominal_section_modulus
from crankfem.analyses.vibration.engine_excitation import engine_harmonics
from crankfem.analyses.vibration.engine_limits import engine_verdict, limit_findings
from crankfem.analyses.vibration.forced import forced_vibrations
from crankfem.analyses.vibration.misfiring import _crossings, _ranges
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.analyses.vibration.run_up import parse_duration
from crankfem.cli.console import write_columns
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.files.reading.data_files import input_path
from crankfem.report.interactive.vibration import VIBRATION
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.order_excitation import OrderExcitation
from dynamics.torque import engine_torque
from dynamics.wording import shown_range
from fem.analysis import analyze_throw

ADDED = """
[driven]
inertia = "200 kg m^2"
coupling_stiffness = "3e6 N m/rad"

[limits]
crankshaft_stress = { value = "30 MPa", source = "maker" }
coupling_torque = "20 kN m"
axial_amplitude = "0.4 mm"

[gas]
"""


# The bearings that the shipped six is taken to have: given, no others are tried beside them.
BEARINGS = '[bearings]\nstiffness = "2.2e9 N/m"\n\n'


def written(tmp_path, text, name="6chn25-34"):
    """A shipped engine with further sections before [gas]."""
    path = tmp_path / "engine.toml"
    path.write_text(
        input_path(name).read_text(encoding="utf-8").replace("[gas]\n", text), encoding="utf-8"
    )
    return path


@pytest.fixture(scope="module")
def coarse(coarse_throw):
    """Throw of the shipped six, as coarse as it may be."""
    return coarse_throw("6chn25-34")[1]


@pytest.fixture(scope="module")
def run(coarse):
    return engine_vibration("6chn25-34", analysis=coarse)


def test_a_damper_needs_a_free_end(tmp_path):
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    start, end = text.index("[free_end]"), text.index("[thrust_bearing]")
    damper = (
        '[torsional_damper]\nkind = "viscous"\nring_inertia = "4 kg m^2"\ndamping = "9 N m s"\n\n'
    )
    path = tmp_path / "engine.toml"
    path.write_text(text[:start] + damper + text[end:], encoding="utf-8")
    engine = load_engine(path)
    with pytest.raises(InputError, match=r"torsional_damper: "):
        engine_torsional_chain(engine, np.full(6, 1e-9), np.full(6, 8.0))


def test_damping_of_its_own_takes_the_magnifiers_place(tmp_path):
    def record(text):
        engine = load_engine(written(tmp_path, text))
        chain = engine_torsional_chain(engine, np.full(6, 1e-9), np.full(6, 8.0))
        return damped_engine_chain(engine, chain).record

    assert len(record("[gas]\n")) == 1
    (own,) = record('[damping]\ncylinder_damping = "20 N m s/rad"\n\n[gas]\n')
    assert "20 N m s/rad" in own
    assert "6 nodes" in own
    (given,) = record("[damping]\ntorsional_magnifier = 25\n\n[gas]\n")
    assert given.startswith("magnifier 25 ")
    guess = 'torsional_magnifier = { value = 25, assumed = "of a like engine" }'
    (guessed,) = record(f"[damping]\n{guess}\n\n[gas]\n")
    assert guessed.startswith("magnifier 25 ")
    assert guessed.endswith(": of a like engine")


@pytest.mark.parametrize("loss", [0.05, 0.3])
def test_an_assumed_magnifier_does_not_damp_a_coupling_whose_damping_is_given(tmp_path, loss):
    driven = (
        f'[driven]\ninertia = "60 kg m^2"\ncoupling_stiffness = "40 kN m/rad"\n'
        f"coupling_loss_factor = {loss}\n\n[gas]\n"
    )

    def system(text):
        engine = load_engine(written(tmp_path, text))
        chain = engine_torsional_chain(engine, np.full(6, 1e-9), np.full(6, 8.0))
        return damped_engine_chain(engine, chain)

    found = system(driven)
    # The coupling's mode has its own loss, the crankshaft's modes the magnifier.
    ratios = found.system.damping_ratios()
    assert ratios[0] == close(0.5 * loss, rel=0.01)
    np.testing.assert_allclose(ratios[1:], 0.0125, rtol=0.02)
    # The same as loss factors 1/40 of the throws alone, beside that of the coupling.
    chain = found.chain
    eta = np.where(chain.loss_factor > 0.0, chain.loss_factor, 1.0 / 40.0)
    rows = chain.elongations()
    stiffness = rows.T @ np.diag(chain.stiffness * (1.0 + 1j * eta)) @ rows
    forces = np.linspace(1.0, -1.0, chain.inertia.size)
    peaks = found.system.elastic_frequencies[:2] * 2.0 * np.pi
    excitation = OrderExcitation([1.0], peaks, np.tile(forces, (1, 2, 1)))
    twist = forced_response(found, excitation).motion[0] @ rows[-1]
    by_hand = [
        np.linalg.solve(stiffness - w**2 * np.diag(chain.inertia), forces) @ rows[-1] for w in peaks
    ]
    np.testing.assert_allclose(np.abs(twist), np.abs(by_hand), rtol=0.03)
    # One that is given for every mode adds to it.
    both = system("[damping]\ntorsional_magnifier = 40\n\n" + driven).system.damping_ratios()
    assert both[0] == close(0.5 * loss + 0.0125, rel=0.01)


def test_a_coupling_over_the_mean_torque_carries_the_load_of_the_engine(tmp_path):
    engine = load_engine(
        written(
            tmp_path,
            """[driven]
inertia = "60 kg m^2"
coupling_stiffness = "40 kN m/rad"

[driven.variation]
torque = ["0 N m", "100 kN m"]
stiffness = [1.0, 3.0]

[load]
law = "propeller"

[gas]
""",
        )
    )
    engine = engine.changed(engine={"rated_power": 6e5})
    (spring,) = engine_torsional_chain(engine, np.full(6, 1e-9), np.full(6, 8.0)).chain.varying
    speeds = np.array([0.3, 0.7, 1.0]) * engine.engine.rated_speed
    rated = 6e5 / engine.engine.rated_speed
    assert spring.law.added(speeds, speeds).real == close(
        4e4 * 2.0 * rated * np.array([0.09, 0.49, 1.0]) / 1e5, rel=1e-4
    )


@pytest.mark.further
def test_forced_vibration_of_an_engine(run):
    torsional, axial = run.forced_torsional, run.forced_axial
    # What goes in becomes heat, at every speed; 1e-6 is promised.
    assert torsional.power.error < 1e-6
    assert axial.power.error < 1e-6
    # Torques of all cylinders together are the engine's, at the speed nearest to the rated one.
    engine, mechanism = run.engine_file.engine, load_mechanism(run.engine_file.path)
    place = int(np.argmin(np.abs(torsional.forces.speeds - engine.rated_speed)))
    speed = float(torsional.forces.speeds[place])
    whole = engine_torque(mechanism.layout, speed, mechanism.pressure).harmonics()
    own = np.abs(torsional.forces.torque[:, place].sum(axis=1))
    assert own == close(whole.amplitude[: own.size], rel=1e-6, abs=1e-6 * own.max())
    # Rules of limits go on to 1.15 of the rated speed.
    assert torsional.response.speeds[-1] >= 1.15 * engine.rated_speed * (1.0 - 1e-12)
    # Stress is torque over the weaker section, whose pin of 180 mm is solid.
    modulus = math.pi * 0.18**3 / 16.0
    assert nominal_section_modulus(run.engine_file.throw) == close(modulus)
    elastic = torsional.loads.elastic.amplitude[:, :, :7]
    assert torsional.stress.amplitude == close(elastic / modulus)
    # Far below all resonances the engine's torque twists the chain statically; order 3 leads there.
    assert {one.mode for one in torsional.peaks} == {1}
    assert max(torsional.resonances, key=lambda one: one.severity).order == 12.0
    # In phase on a rigid shaft, which the first mode resembles but is not.
    assert [one.order for one in torsional.peaks if one.kind == "major"] == [12.0]


@pytest.mark.slow
def test_worst_use_does_not_depend_on_what_else_is_calculated(run):
    """Another grid of speeds, as with the whole crankshaft; refined to 2e-6 of the use either way."""
    engine = run.engine_file
    forced = forced_vibrations(
        engine,
        engine_harmonics(engine),
        run.axial,
        run.torsional,
        run.shaft,
        run.analysis,
        (71.3, 96.9, 143.0),
    )
    assert forced[0].response.speeds.size > run.forced_axial.response.speeds.size
    other = engine_verdict(engine, limit_findings(engine, *forced)).checks[0]
    assert other.worst_speed == close(run.worst_check.worst_speed, rel=1e-4)
    assert other.used == close(run.worst_check.used, rel=1e-5)


@pytest.mark.slow
def test_resonances_are_listed_at_all_speeds_judged(run):
    engine, found = run.engine_file.engine, run.forced_torsional
    end = 1.1 * engine.rated_speed  # where the rule for generating sets ends
    assert found.judged_range == close((engine.lowest_speed, end))
    resonances = [one for one in found.resonances if one.in_band]
    speeds = [one.speed for one in resonances]
    above = [one for one in resonances if not one.in_running_range]
    meeting = {
        k: 2.0 * math.pi * run.torsional.chosen.elastic_frequencies[0] / k
        for k in found.response.orders
    }
    expected = {k for k, speed in meeting.items() if engine.highest_speed < speed <= end}
    assert expected
    assert {one.order for one in above} == expected
    assert speeds == sorted(speeds)
    criticals = run.torsional.criticals
    assert [one.speed for one in criticals] == close([one.undamped_speed for one in resonances])
    # A magnifier of 40 hardly moves the peaks, at whatever place they are told of.
    assert speeds == close([one.undamped_speed for one in resonances], rel=2e-3)
    assert [one.in_running_range for one in criticals] == [
        one.in_running_range for one in resonances
    ]
    record = found.to_record()
    assert [one["in_running_range"] for one in record["resonances"] if one["in_band"]].count(
        False
    ) == len(above)
    assert record["judged_rpm"][1] == close(end * 30.0 / math.pi)
    # Most is used where the limit ends, below the resonance of order 9 at 568 1/min: near it, not at it.
    worst = run.worst_check
    assert worst.worst_speed == close(end)
    assert worst.cause.resonant == ()
    near = max(worst.cause.parts, key=lambda one: abs(one.contribution))
    assert (near.order, near.state, near.mode) == (9.0, "near resonance", 1)
    assert worst.cause.amplitude == close(worst.worst_value, rel=1e-9)
    assert 0.1 < worst.cause.share("near resonance") < 0.5 < worst.cause.share("forced")
    assert worst.sentence in run.assessment.verdict.sentence
    axes = run.assessment.plot()
    assert axes.get_xlim()[1] == close(end * 30.0 / math.pi)


@pytest.mark.further
def test_records_pictures_and_columns(run, tmp_path):
    record = run.to_record()
    text = json.dumps(record, allow_nan=False)
    assert json.loads(text)["assessment"]["status"] == run.assessment.verdict.status
    assert record["whole"] is None
    assert [limit["assumed"] for limit in record["assessment"]["limits"]] == [True]
    made = VIBRATION.draw(tmp_path / "pictures", run)
    assert {path.stem for path in made} == {
        *(f"{kind}_{what}" for kind in ("axial", "torsional") for what in ("modes", "campbell")),
        "axial_amplitude",
        "axial_force",
        "torsional_amplitude",
        "torsional_stress",
        "deciding",
        "misfiring_stress",
    }
    assert all(path.read_text(encoding="utf-8").startswith("<?xml") for path in made)
    write_columns(tmp_path / "torsional.csv", *run.forced_torsional.columns())
    head, names, first = (tmp_path / "torsional.csv").read_text("utf-8").splitlines()[:3]
    assert head.startswith("# torsional vibration")
    assert len(names.split(",")) == len(first.split(",")) == 3 + 24 + 7


def test_a_vibration_is_the_same_in_another_process(run):
    returned = pickle.loads(pickle.dumps(run))
    assert returned.to_record() == run.to_record()


@pytest.mark.slow
def test_axial_force_over_the_cycle_in_the_record(run):
    found, record = run.axial_force, run.to_record()["axial_force"]
    said = " ".join(record["sentences"])
    for name, force in (("thrust_bearing", found.thrust_bearing), ("held", found.held)):
        # Extremes are between the samples, a degree apart; the curve is flat there.
        extremes, span = record[name], np.ptp(force)
        assert 0.0 <= extremes["highest"] - force.max() <= 5e-3 * span
        assert 0.0 <= force.min() - extremes["lowest"] <= 5e-3 * span
        # Each firing interval of 120 deg has the same one, but for round-off.
        assert (extremes["highest_angle_deg"] - np.argmax(force) + 60.0) % 120.0 == close(
            60.0, abs=1.0
        )
        assert f"{extremes['lowest'] / 1e3:.3g} kN to {extremes['highest'] / 1e3:.3g} kN" in said
    assert len(record["throws"]) == 6
    # At the worst running speed it is no smaller than at rated speed, and is what the motion there makes.
    worst = record["running"]
    rated = record["thrust_bearing"]
    assert worst["amplitude"] >= 0.5 * (rated["highest"] - rated["lowest"]) * (1.0 - 1e-9)
    response = run.forced_axial.response
    place = int(np.argmin(np.abs(response.speeds - worst["speed_rpm"] * np.pi / 30.0)))
    moved = response.nodes.at_angle(
        place, shaft_angle_deg=np.degrees(np.linspace(0.0, 4.0 * np.pi, 20_000))
    )[:, 6]
    assert worst["amplitude"] == close(0.5 * 8e8 * np.ptp(moved), rel=1e-5)
    assert f"{worst['amplitude'] / 1e3:.3g} kN by the chain, at {worst['speed_rpm']:.4g}" in said
    assert record["running_whole"] is None


@pytest.mark.slow
def test_unbounded_vibration_is_null_in_records(run):
    forced = run.forced_torsional
    nothing = np.zeros_like(forced.response.unbounded)
    nothing[23, 10] = True
    record = replace(forced, response=replace(forced.response, unbounded=nothing)).to_record()
    assert record["free_end"]["synthesis"][10] is None
    assert record["free_end"]["orders"][23]["amplitude"] is None
    assert record["free_end"]["synthesis"][11] is not None


@pytest.mark.further
def test_limits_of_a_file_are_judged(coarse, tmp_path):
    given = engine_vibration(written(tmp_path, BEARINGS + ADDED), analysis=coarse)
    checks = {check.limit.name: check for check in given.assessment.verdict.checks}
    assert set(checks) == {
        "torsional stress of crankshaft",
        "torque of coupling",
        "axial amplitude of free end",
    }
    assert checks["torsional stress of crankshaft"].limit.source == "maker"
    assert checks["torque of coupling"].curve.name == "flywheel - driven machine"
    assert not any("no limit is given" in remark for remark in given.assessment.remarks)
    alone = ADDED[ADDED.index("[limits]") :]
    with pytest.raises(InputError, match=r"limits\.coupling_torque: "):
        engine_vibration(written(tmp_path, alone), analysis=coarse)


@pytest.mark.further
def test_uncertain_values_widen_the_critical_speeds(coarse, tmp_path):
    text = "[ranges]\ninertia = [0.9, 1.1]\nsamples = 4\n\n[gas]\n"
    given = engine_vibration(written(tmp_path, text), analysis=coarse)
    found, engine = given.assessment, given.engine_file.engine
    torsional = found.torsional
    # The estimated error of the finite elements is possible either way.
    one = torsional.spreads[0]
    assert (one.low, one.high) == close((1.0 - coarse.error_estimate, 1.0 + coarse.error_estimate))
    # Nominal samples are the response itself at running speeds; torsion is larger outside.
    for kind, forced in ((found.axial, given.forced_axial), (torsional, given.forced_torsional)):
        free_end = forced.free_end
        amplitude = free_end.synthesis.amplitude[:, 0]
        runs = (free_end.speeds >= engine.lowest_speed) & (free_end.speeds <= engine.highest_speed)
        # The grid of speeds differs by the damped resonances that samples add.
        assert kind.amplitudes.nominal == close(amplitude[runs].max(), rel=1e-3)
    assert torsional.amplitudes.nominal < 0.9 * amplitude.max()
    # The flywheel's inertia matters little to the first mode: nearly the root of the factor.
    # Softer main bearings than the nominal ones come on top of it.
    swept = given.bearings.chains["torsional"]
    softer = swept[3] / swept.min()
    assert softer > 1.02
    first = torsional.frequencies[0]
    assert first.nominal / first.lowest == close(1.1**0.5 * softer, rel=0.06)
    assert torsional.samples.values.shape == (4,)
    assert found.axial.amplitudes is not None
    assert all(own.low <= own.nominal <= own.high for own in torsional.critical)


@pytest.mark.further
def test_uncertain_damping_is_also_what_the_magnifier_stands_for(coarse, tmp_path):
    """At a resonance the amplitude of an order goes with the inverse of its damping."""
    text = "[ranges]\ndamping = [0.5, 2.0]\nsamples = 8\n\n[gas]\n"
    found = engine_vibration(written(tmp_path, text), analysis=coarse).assessment
    amplitudes = found.axial.samples.values
    assert max(amplitudes) > 1.3 * min(amplitudes)


def test_ranges_exceeded_while_misfiring_with_next_to_nothing_between_them_are_one():
    speeds = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.01, 9.0])
    flags = np.array([0, 1, 0, 1, 0, 0, 1, 0, 0, 1], dtype=bool)
    crossings = {0: 1.5, 1: 2.49, 2: 2.5, 3: 4.75, 5: 6.25, 6: 7.98, 8: 8.009}
    assert _ranges(speeds, flags, crossings) == ((1.5, 4.75), (6.25, 9.0))
    assert _ranges(speeds[:1], flags[1:2], {}) == ((1.0, 1.0),)
    assert _ranges(speeds[:2], flags[:2], {0: 1.25}) == ((1.25, 2.0),)


def test_the_end_of_a_range_is_where_the_limit_is_met():
    speeds = np.linspace(0.0, 10.0, 11)

    def exceeded(some):
        return np.sin(some) > 0.5

    ends = np.array([np.pi / 6.0, 5.0 * np.pi / 6.0, 13.0 * np.pi / 6.0, 17.0 * np.pi / 6.0])
    found = _crossings(exceeded, speeds, exceeded(speeds))
    assert list(found) == [0, 2, 6, 8]
    assert np.array([*found.values()]) == close(ends, rel=1e-3)
    assert _crossings(exceeded, speeds[:1], exceeded(speeds[:1])) == {}


@pytest.mark.further
def test_misfiring_is_held_against_the_continuous_limit_unless_the_file_says_otherwise(coarse, run):
    """A coupling that normal firing keeps anywhere, and misfiring does not."""
    driven = {"inertia": 200.0, "coupling_stiffness": 1e5, "coupling_loss_factor": 0.2}
    limits = {"coupling_torque": 3e3, "coupling_torque_passing": 4e4, "crankshaft_stress": 90e6}
    bearings = {"stiffness": run.engine_file.main_bearings.stiffness}
    engine = run.engine_file.changed(driven=driven, limits=limits, bearings=bearings)
    found = engine_vibration(engine, analysis=coarse).misfiring
    check = found.worst
    assert check.quantity == "torque of coupling"
    assert check.normal.used < 1.0 < check.misfiring.used
    # What is permitted does not change by misfiring, so misfiring is never better by another limit.
    for one in found.checks:
        for reached in (one.normal, one.misfiring):
            if one.limit is not None:
                at = np.array([reached.speed])
                assert reached.permitted == one.limit.continuous.at(at)[0]
    assert not found.passed
    assert f"{100.0 * check.misfiring.value / 4e4:.3g} % of the 40 kN m" in found.sentence
    # Its cause: the orders add up to what is reached there.
    cause = check.new.cause
    assert sum(one.contribution for one in cause.parts) == close(check.misfiring.value, rel=1e-3)
    assert cause.speed == check.misfiring.speed
    assert "order" in found.sentence.lower()
    # The remedy: the speeds that remain and those exceeded are all running speeds, and apart.
    ends = sorted(end for one in (*found.exceeded, *found.remaining) for end in one)
    assert ends[0] == close(engine.engine.lowest_speed)
    assert ends[-1] == close(engine.engine.highest_speed)
    for low, high in found.remaining:
        assert not any(one[0] < low < one[1] or one[0] < high < one[1] for one in found.exceeded)
    low, high = found.remaining[-1]
    third = (high - low) / 3.0
    left = found.outside([(low - third, low + third), (high - third, high + third)]).remaining
    assert left[-1] == close([low + third, high - third])
    assert len(left) == len(found.remaining)
    assert found.outside([(1.01 * high, 2.0 * high)]).remaining == found.remaining
    assert shown_range(*found.advised[0]) in found.sentence
    # What is barred anyway lies between the speeds that remain, and is named.
    barred = (low + third, high - third)
    left = found.outside([barred])
    assert left.otherwise == (barred,)
    assert shown_range(*barred) in left.sentence
    # Ranges too narrow to run in are no advice.
    narrow = found.outside([(found.running_range[0], 0.97 * high)])
    assert narrow.remaining == ((0.97 * high, high),)
    assert narrow.advised == ()
    assert "restrict running" not in narrow.sentence
    # Of the class or the maker's word the limit for passing serves, and the sentence says so.
    engine = engine.changed(misfire={"cylinders": list(check.cylinders)})
    said = engine_vibration(
        engine.changed(limits=limits | {"passing_while_misfiring": True}), analysis=coarse
    ).misfiring
    assert said.passed
    (passed,) = (one for one in said.checks if one.quantity == check.quantity)
    assert passed.misfiring.value == close(check.misfiring.value, rel=1e-6)
    by = "for passing, which serves while a cylinder misfires by limits.passing_while_misfiring"
    assert by in passed.sentence
    assert "permitted continuously" in passed.sentence
    # Where normal firing keeps the limit at no speed, misfiring alone exceeds nothing.
    nowhere = engine_vibration(
        engine.changed(limits=limits | {"coupling_torque": 1.0}), analysis=coarse
    ).misfiring
    assert all(one.new is None for one in nowhere.checks if one.quantity == check.quantity)
    assert "alone" not in nowhere.sentence


@pytest.mark.slow
def test_normal_firing_stands_beside_each_misfiring_cylinder(coarse, run):
    found = run.misfiring
    assert found.cases == ((1,), (2,), (3,), (4,), (5,), (6,))
    # Normal firing is what it is without misfiring.
    worst = run.worst_check
    checks = {one.quantity: one for one in found.checks}
    stress = checks[worst.limit.name]
    assert found.worst is stress
    engine = run.engine_file.engine
    assert all(
        engine.lowest_speed <= one.speed <= engine.highest_speed * (1.0 + 1e-12)
        for check in found.checks
        for one in (check.normal, check.misfiring)
    )
    free_end = checks["torsional amplitude of free end"]
    amplitude = run.forced_torsional.free_end.synthesis.amplitude[:, 0]
    runs = (run.forced_torsional.free_end.speeds <= engine.highest_speed) & (
        run.forced_torsional.free_end.speeds >= engine.lowest_speed
    )
    assert free_end.normal.value == close(amplitude[runs].max(), rel=1e-3)
    # Half orders, which cancel in normal firing, swing a cylinder's part of the shaft.
    assert free_end.misfiring.value > free_end.normal.value
    assert stress.misfiring.used == max(one.used for one in stress.each.values())
    assert found.sentence.startswith(f"With cylinder {stress.cylinders[0]} misfiring, ")
    assert run.to_record()["misfiring"]["checks"][0]["cylinders"] == list(stress.cylinders)


@pytest.mark.slow
def test_running_speeds_stand_first(run):
    record = run.to_record()
    engine, forced = run.engine_file.engine, run.forced_torsional
    rpm = 30.0 / math.pi
    ends = [engine.lowest_speed * rpm, engine.highest_speed * rpm]
    speeds, amplitude = forced.response.speeds, forced.stress.synthesis.amplitude
    inside = (speeds >= engine.lowest_speed) & (speeds <= engine.highest_speed * (1.0 + 1e-12))
    for place, one in enumerate(record["forced"]["torsional"]["stress"]):
        assert ends[0] <= one["running"]["speed_rpm"] <= ends[1] * (1.0 + 1e-12)
        assert one["below"]["speed_rpm"] < ends[0]
        assert ends[1] < one["above"]["speed_rpm"] <= forced.judged_range[1] * rpm * (1.0 + 1e-12)
        assert one["running"]["peak"] == amplitude[inside, place].max()
        assert one["peak"] >= max(one[part]["peak"] for part in ("running", "below", "above"))
    for check in record["assessment"]["checks"]:
        assert check["running"]["speed_rpm"] <= ends[1] * (1.0 + 1e-12)
        both = [check[part]["used"] for part in ("running", "above") if check[part] is not None]
        assert check["used"] == max(both)
    assert forced.largest_place(forced.stress) == np.argmax(amplitude[inside].max(axis=0))


@pytest.mark.further
def test_the_file_chooses_failing_cylinders(coarse, run, tmp_path):
    text = f"{BEARINGS}[misfire]\ncylinders = [3]\n\n[gas]\n"
    chosen = engine_vibration(written(tmp_path, text), analysis=coarse)
    assert chosen.misfiring.cases == ((3,),)
    # Normal firing stays.
    assert chosen.worst_check.worst_value == run.worst_check.worst_value
    (stress,) = (
        one for one in chosen.misfiring.checks if one.quantity.startswith("torsional stress")
    )
    (searched,) = (one for one in run.misfiring.checks if one.quantity == stress.quantity)
    assert stress.misfiring.used == close(searched.each[(3,)].used, rel=1e-3)
    weak = engine_vibration(
        written(tmp_path, text.replace("[3]", "[3]\nmissing_share = 0.0")), analysis=coarse
    )
    for one in weak.misfiring.checks:
        assert one.misfiring.value == close(one.normal.value, rel=1e-9) or one.limit is not None
    bare = engine_vibration(
        written(tmp_path, text.replace("[3]", "[3]\ncompression = false")), analysis=coarse
    )
    assert bare.misfiring.worst.misfiring.value != stress.misfiring.value


@pytest.mark.further
def test_vibration_command(call, monkeypatch, tmp_path):
    monkeypatch.setattr(
        "fem.analysis.analyze_throw", lambda throw, material: analyze_throw(throw, material, 0.1)
    )
    files = ("--csv", tmp_path / "csv", "--pictures", tmp_path / "p")
    call("vibration", "8chn13-14", *files)
    assert (tmp_path / "csv" / "axial.csv").is_file()
    head, names, *rows = (tmp_path / "csv" / "axial_force.csv").read_text("utf-8").splitlines()
    assert "2100 1/min" in head
    assert names.split(",")[:3] == ["shaft_angle_deg", "thrust_bearing_N", "held_N"]
    assert len(rows) == 720
    assert len(names.split(",")) == 3 + 4
    assert (tmp_path / "p" / "torsional_stress.svg").is_file()


@pytest.mark.slow
def test_vibration_command_of_a_chain(call, tmp_path):
    answer = call("vibration", "mwm-six")
    assert "216.584" in answer.out
    content = call("vibration", "mwm-six", "--json").json()
    assert content["modes"][1]["frequency"] == close(216.584, abs=1e-3)
    assert sum(content["modes"][1]["strain_shares"].values()) == close(1.0)
    answer = call("vibration", "mwm-six", "--coupled")
    assert answer.code == 2
    (tmp_path / "line.txt").write_text("nonsense", encoding="utf-8")
    assert call("vibration", tmp_path / "line.txt").code == 2


@pytest.mark.parametrize("text", ["20", "20 mm", "0 s", "1 h"])
def test_wrong_durations_are_refused(text):
    with pytest.raises(InputError, match=r"^--run-up: given"):
        parse_duration(text)


TWO = Chain([1.0, 1.0], [2e4], names=["pulley", "flywheel"])  # 200 rad/s


def response(**damping):
    speeds = np.array([50.0, 100.0, 150.0])
    forces = np.ones((2, 3, 2)) * np.array([1.0, -1.0])
    return forced_response(damped(TWO, **damping), OrderExcitation([1.0, 2.0], speeds, forces))
