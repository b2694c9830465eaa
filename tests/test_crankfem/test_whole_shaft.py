"""The whole crankshaft of shipped engines, coarsely meshed.

Masses and inertias must be those of the chains, which come from the same file another way.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import engine_throw_inertias, engine_torsional_chain
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.whole_records import whole_record
from crankfem.analyses.shaft.whole_shaft import (
    ShaftComparison,
    highest_exciting_frequency,
    shaft_response,
    whole_shaft,
    whole_shaft_remark,
)
from crankfem.analyses.vibration.plots import plot_shaft_modes
from crankfem.analyses.vibration.records import run_record
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.mechanism_file import load_mechanism
from dynamics.chains.chain import Chain
from dynamics.crankshaft.chain_comparison import (
    FlywheelTilt,
    ModeMatch,
    ResponseMatch,
    chain_verdict,
)
from dynamics.crankshaft.shaft_modes import crankshaft_system
from dynamics.crankshaft.surroundings import MainBearings
from dynamics.excitation.cylinders import cylinder_harmonics, forces_at_speeds

ORDERS = np.arange(1, 25) * 0.5


@pytest.fixture(scope="module", params=["6chn25-34", "8chn13-14"])
def engine(request, coarse_throw):
    engine_file, analysis = coarse_throw(request.param)
    return engine_file, analysis, whole_shaft(engine_file, analysis)


@pytest.fixture(scope="module")
def six(coarse_throw):
    return coarse_throw("6chn25-34")


def chain_of(engine_file, analysis):
    shaft = compliances_in_shaft(engine_file, analysis)
    inertias = engine_throw_inertias(engine_file, analysis.masses.inertia_about_shaft)
    return shaft, engine_torsional_chain(engine_file, shaft.torsional, inertias)


def lengthening(crankshaft, ends, loaded):
    """Static difference of both ends' motion under a unit force at a point, balanced at the ends.

    An axial force or torque at one end is balanced by that at the other; a radial force on a pin by
    the bearings.
    """
    system, last = crankshaft.system, crankshaft.shaft.section_count
    span = system.expand[crankshaft.point(ends.format(last))]
    span = span - system.expand[crankshaft.point(ends.format(1))]
    force = span if crankshaft.names[loaded].startswith("main bearing") else system.expand[loaded]
    elastic = system.natural > 0.0
    return float((span[elastic] * force[elastic]) @ system.natural[elastic] ** -2.0)


@pytest.mark.slow
def test_whole_shaft_of_an_engine(engine, coupled_vibration, tmp_path):
    engine_file, analysis, whole = engine
    modes = whole.modes
    assert modes.names[: modes.rigid] == ("rotation about the shaft axis",)
    shaft, torsional = chain_of(engine_file, analysis)
    about = whole.crankshaft.shaft.rigid[:, 0]
    stub = engine_file.shaft_ends
    own = 0.0
    if stub.free_end_diameter is not None:
        d, length = stub.free_end_diameter, stub.free_end_length
        own = engine_file.material.density * math.pi / 32.0 * d**4 * length
    # The chain does not know the stub at the free end. Masses of superelements are those of meshes,
    # which have the solid's volume within 0.1 %.
    assert about @ whole.crankshaft.shaft.mass @ about == close(
        torsional.chain.inertia.sum() + own, rel=1e-3
    )
    # In the same bearings: those assumed for both, and rigid ones.
    rigid = whole_shaft(engine_file, analysis, bearings=MainBearings(math.inf))
    for held, static in (
        (whole, shaft),
        (rigid, compliances_in_shaft(engine_file, analysis, math.inf)),
    ):
        system = held.crankshaft
        twist = lengthening(system, "main bearing {} rz", system.point("main bearing 1 rz"))
        stretch = lengthening(system, "main bearing {} uz", system.point("main bearing 1 uz"))
        # The static assembly of the same superelement, by another way; residuals of the solver are 1e-9.
        assert twist == close(static.torsional.sum(), rel=1e-6)
        assert stretch == close(static.axial.sum(), rel=1e-6)
        by_pin = lengthening(system, "main bearing {} uz", system.point("pin 2 radial"))
        assert by_pin == close(static.influence[:, 1].sum(), rel=1e-6)
    assert any("assumed" in remark for remark in whole.remarks) == (engine_file.bearings is None)
    assert np.all(whole.rotation_ratios[:3] > 0.01)
    # Everything at once: forces of the engine, whole shaft, chains, pictures.
    found = coupled_vibration(engine_file.path.stem).comparison
    # The first mode of each chain is compared, and others up to the highest exciting frequency alone.
    for verdict in found.verdicts:
        further = [match.chain_frequency for match in verdict.modes[1:]]
        assert max(further, default=0.0) <= whole.exciting_frequency
    assert len(found.axial.modes) == 1
    split = found.coupled.split("main bearing 1 uz")
    assert split.both_sum.max() > 1e-6
    # Torsion shows in axial motion: tangential forces alone move the free end along the shaft.
    assert split.tangential_sum.max() > 0.1 * split.both_sum.max()
    # Torque by equilibrium turns what is beyond the last bearing, the flywheel alone, and is near that of
    # the chain's elements, whose modes are near the shaft's.
    torque, bearings = found.coupled.torque, whole.crankshaft.shaft.section_count
    angle = found.coupled.motion(f"main bearing {bearings} rz")
    turned = (
        engine_file.flywheel.inertia * (torque.orders[:, np.newaxis] * torque.speeds) ** 2 * angle
    )
    assert np.max(np.abs(torque.values[:, :, -1] - turned)) < 1e-9 * np.max(np.abs(turned))
    by_chain = coupled_vibration(engine_file.path.stem).forced_torsional.crank_elements
    whole_torque = found.coupled.torque.synthesis.amplitude
    chain_torque = by_chain.synthesis.amplitude[:, -whole_torque.shape[1] :]
    slow = (
        by_chain.speeds < 1.1 * by_chain.speeds[0]
    )  # below resonances that differ by some per cent
    assert np.max(whole_torque[slow]) == close(np.max(chain_torque[slow]), rel=0.1)
    for verdict in (found.axial, found.torsional):
        assert verdict.suffices == (not verdict.reasons)
        assert verdict.response is not None
    plot_shaft_modes(tmp_path / "modes.svg", modes, engine_file.throw.crank_radius)
    assert (tmp_path / "modes.svg").read_text(encoding="utf-8").startswith("<?xml")
    with pytest.raises(InputError, match=r"^count: given 0"):
        plot_shaft_modes(tmp_path / "none.svg", modes, 0.1, count=0)


@pytest.mark.slow
def test_leaving_modes_out_changes_no_answer(engine):
    """Static correction: the response within 1e-3, though most of the modes are gone."""
    engine_file, _, whole = engine
    mechanism = load_mechanism(engine_file.path)
    harmonics = cylinder_harmonics(
        mechanism.layout, ORDERS, mechanism.pressure, throws=mechanism.throws
    )
    engine_speeds = np.linspace(
        engine_file.engine.lowest_speed, engine_file.engine.highest_speed, 20
    )
    forces = forces_at_speeds(harmonics, engine_speeds)
    complete = crankshaft_system(whole.crankshaft.shaft)
    assert len(complete.system.mass) > len(whole.crankshaft.system.mass)
    answers = [
        shaft_response(engine_file, replace(whole, crankshaft=each), forces)
        for each in (whole.crankshaft, complete)
    ]
    for point in ("main bearing 1 uz", "main bearing 1 rz", "pin 2 tangential"):
        fewer, every = (answer.motion(point) for answer in answers)
        assert np.abs(fewer - every).max() < 1e-3 * np.abs(every).max()
    assert whole.exciting_frequency == highest_exciting_frequency(engine_file)
    assert whole.highest_frequency == max(200.0, whole.exciting_frequency)


@pytest.mark.slow
def test_an_engine_that_turns_the_other_way_vibrates_the_same(six, coupled_vibration, tmp_path):
    """All angles with the other sign: the mirror image, which turns against z.

    The throw is its own mirror image and its mesh is too, so that only round-off remains, larger by the
    condition of the static equations.
    """
    engine_file, analysis = six
    text = engine_file.path.read_text(encoding="utf-8")
    start = text.index("crank_angles")
    end = text.index("\n", start)
    mirrored = text[start:end].replace('"120 deg"', '"-120 deg"').replace('"240 deg"', '"-240 deg"')
    path = tmp_path / "mirrored.toml"
    path.write_text(text[:start] + mirrored + text[end:], encoding="utf-8")
    runs = [coupled_vibration("6chn25-34"), engine_vibration(path, analysis=analysis, coupled=True)]
    senses = [run.engine_file.engine.turning_sense for run in runs]
    assert senses[0] == -senses[1]
    for peaks in zip(*(_peaks(run) for run in runs), strict=True):
        assert peaks[1] == close(peaks[0], rel=1e-6)
    # The thrust bearing, here at the flywheel, by the whole shaft.
    told = run_record(runs[0])["axial_force"]["running_whole"]
    speeds, moved = (
        getattr(runs[0].comparison.coupled.split("main bearing 7 uz"), name)
        for name in ("speeds", "both_sum")
    )
    engine = runs[0].engine_file.engine
    running = (speeds >= engine.lowest_speed - 1e-9) & (speeds <= engine.highest_speed + 1e-9)
    assert told["amplitude"] == close(8e8 * moved[running].max())


def _peaks(run):
    """Largest amplitudes of the free end, by the chains and by the whole shaft."""
    split = run.comparison.coupled.split("main bearing 1 uz")
    return (
        run.forced_torsional.free_end.synthesis.amplitude.max(),
        run.forced_axial.free_end.synthesis.amplitude.max(),
        split.tangential_sum.max(),
        split.radial_sum.max(),
        split.both_sum.max(),
        run.axial_force.held.max(),
        run.axial_force.thrust_bearing.max(),
    )


@pytest.mark.slow
def test_a_makers_chain_of_the_plant_is_not_compared(six, monkeypatch):
    engine_file, analysis = six
    cranks = [f"cylinder {number}" for number in range(1, 7)]
    plant = Chain(
        [5.0] * 6 + [400.0, 500.0], [2e7] * 6 + [1e6], names=[*cranks, "wheel", "propeller"]
    )
    longer = replace(engine_file, shaft_lines={"plant": plant}, free_end=None)
    whole = whole_shaft(longer, analysis)
    assert any("is without the plant and judged by no limit" in one for one in whole.remarks)
    monkeypatch.setattr("crankfem.analyses.vibration.run.whole_shaft", lambda *_: whole)
    run = engine_vibration(longer, analysis=analysis, coupled=True)
    assert (run.comparison.axial, run.comparison.torsional) == (None, None)
    told = run_record(run)
    assert told["axial_force"]["running_whole"] is None
    assert told["not_comparable"] in told["assessment"]["by_whole"][0]
    running = (run.engine_file.engine.lowest_speed, run.engine_file.engine.highest_speed)
    record = whole_record(run.whole, run.comparison, running)
    assert record["chains"] == {}
    assert record["axial_split"]["both"] > 1e-6
    split = run.comparison.coupled.split("main bearing 1 uz")
    for name in ("tangential", "radial", "both"):
        curve = getattr(split, f"{name}_sum")
        inside = (split.speeds >= running[0] - 1e-9) & (split.speeds <= running[1] + 1e-9)
        worst = int(np.argmax(np.where(inside, curve, 0.0)))
        assert record["axial_split"][name] == curve[worst]
        speed = run.comparison.coupled.speeds[worst] * 30.0 / math.pi
        assert record["axial_split"][f"{name}_speed_rpm"] == close(speed)


def test_difference_of_the_whole_shaft_is_told_beside_the_verdict():
    def verdict(kind, chain_peak, shaft_peak, frequencies=(100.0, 100.0), share=0.99):
        speeds = np.array([10.0, 20.0])
        match = ModeMatch(kind, 1, frequencies[0], 6, frequencies[1], share, 1.0, 1, 6)
        peaks = [np.array([0.0, peak]) for peak in (chain_peak, shaft_peak)]
        return chain_verdict([match], ResponseMatch(kind, speeds, *peaks))

    good = verdict("axial", 1e-4, 1.01e-4)
    assert (
        whole_shaft_remark(ShaftComparison(None, good, verdict("torsional", 1e-2, 1.05e-2))) == ()
    )
    bad = ShaftComparison(None, good, verdict("torsional", 13.1e-3, 8.752e-3, (118.5, 126.4)))
    assert whole_shaft_remark(bad) == (
        "The verdict uses lumped models (chains), of which the torsional one is inadequate here; the whole "
        "crankshaft differs: largest torsional amplitude of the free end at running speeds 8.75 mrad at 191 "
        "1/min instead of 13.1 mrad at 191 1/min.",
    )
    other = verdict("axial", 1.266e-3, 1.27e-3, (105.6, 115.0))
    mixed = verdict("torsional", 1e-2, 1e-2, share=0.48)
    (said,) = whole_shaft_remark(ShaftComparison(None, other, mixed))
    assert "Hz is only 48 % torsional; axial mode 1 at 115.0 instead of" in said
    assert said.startswith(
        "The verdict uses lumped models (chains), which are inadequate here; the"
    )
    divided = FlywheelTilt("axial", 1, 259.8, 303.5, 225.9)
    assert divided.sentence == "axial mode 1 from 259.8 Hz without to 225.9 and 303.5 Hz with it"
    (match,) = other.modes
    two = replace(match, further_frequency=80.0, further_share=0.4)
    (said,) = whole_shaft_remark(ShaftComparison(None, chain_verdict([two])))
    assert said.endswith("two modes at 80.0 and 115.0 Hz instead of axial mode 1 at 105.6 Hz.")
    (said,) = whole_shaft_remark(ShaftComparison(None, verdict("axial", 1.266e-3, np.inf)))
    assert "at running speeds unbounded instead of 1270 um at 191 1/min" in said
