"""The whole crankshaft of engines, what is around it, and its verdict."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import (
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
    shaft_surroundings,
)
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.whole_shaft import (
    ShaftComparison,
    damping_remarks,
    modal_damping,
    not_comparable,
    shaft_response,
    whole_shaft,
    whole_shaft_remark,
)
from crankfem.analyses.vibration.engine_limits import (
    engine_limits,
    even_firing_interval,
    refuse_limits,
)
from crankfem.analyses.vibration.modes import axial_weights
from crankfem.analyses.vibration.plots import plot_shaft_modes
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.analyses.vibration.whole_verdict import (
    WholeTorsion,
    decision_by_both,
    whole_sentence,
    whole_verdict,
)
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.reading.data_files import input_path
from dynamics.assessment.limits import AmplitudeCurve
from dynamics.assessment.verdict import decide
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.chain_comparison import (
    ChainVerdict,
    FlywheelTilt,
    ModeMatch,
    ResponseMatch,
)
from dynamics.crankshaft.coupled_response import coupled_response
from dynamics.crankshaft.shaft_modes import crankshaft_system
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
)
from dynamics.response.series import OrderSeries
from stand_ins import analysis_with


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


@pytest.mark.further
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


@pytest.mark.further
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
    told = runs[0].thrust.running_whole
    speeds, moved = (
        getattr(runs[0].comparison.coupled.split("main bearing 7 uz"), name)
        for name in ("speeds", "both_sum")
    )
    engine = runs[0].engine_file.engine
    running = (speeds >= engine.lowest_speed - 1e-9) & (speeds <= engine.highest_speed + 1e-9)
    assert told.amplitude == close(8e8 * moved[running].max())


@pytest.mark.further
def test_torques_of_the_whole_crankshaft_turn_the_masses_behind_it(six, coupled_vibration):
    engine_file, analysis = six
    machine = {"inertia": 900.0, "coupling_stiffness": 2e6, "coupling_loss_factor": 0.1}
    driven = engine_file.changed(driven=machine)
    forces = coupled_vibration("6chn25-34").forced_torsional.forces
    coupled = shaft_response(driven, whole_shaft(driven, analysis), forces)
    cranks = chain_of(driven, analysis)[1]
    loads = WholeTorsion(coupled, cranks, {}).loads
    assert loads.elements.names == loads.elastic.names == cranks.chain.elements
    *_, last, coupling = np.moveaxis(loads.elements.values, 2, 0)
    squared = coupled.total.angular_frequencies**2
    turned = squared * machine["inertia"] * coupled.motion("driven machine")
    scale = np.abs(turned).max()
    # The assumed damping of the modes, 1/80 of critical, is in no spring.
    assert np.abs(coupling - turned).max() < 1e-3 * scale
    assert loads.elastic.values[:, :, -1] * (1.0 + 0.1j) == close(coupling, abs=1e-9 * scale)
    # The crankshaft's last main bearing drives flywheel and machine, but for the end of the shaft.
    flywheel = squared * engine_file.flywheel.inertia * coupled.motion("main bearing 7 rz")
    assert last == close(flywheel + coupling, rel=0.02, abs=0.02 * scale)


PLACES = ("flywheel - input", "input - line damper")


def with_limited_line(plain):
    """An engine with a coupling and a damper behind the flywheel, and limits on both."""
    line = Chain(
        [12.0, 40.0, 0.0, 0.0, 900.0, 6.0],
        [4e5, 2e7, 2.15e6],
        connections=[(0, 1), (1, 2), (3, 4)],
        loss_factor=[0.15, 0.0, 0.0],
        gears=[Gear(2, 3, -0.4)],
        dashpots=[Dashpot(1, 5, 1500.0)],
        names=["flange", "input", "pinion", "wheel", "propeller", "line damper"],
    )
    limits = {"elements": [{"element": place, "torque": 3e3, "heat": 2e3} for place in PLACES]}
    bearings = {"stiffness": plain.main_bearings.stiffness}
    engine_file = plain.changed(limits=limits, bearings=bearings, misfire={"cylinders": [1]})
    return replace(engine_file, shaft_lines={"torsional": line})


@pytest.mark.further
def test_limits_on_a_coupling_and_a_damper_behind_the_flywheel(six, coupled_vibration):
    plain, analysis = six
    engine_file = with_limited_line(plain)
    refuse_limits(engine_file)
    forces = coupled_vibration("6chn25-34").forced_torsional.forces
    run = engine_vibration(engine_file, analysis=analysis)
    chain = run.forced_torsional
    coupled = shaft_response(engine_file, whole_shaft(engine_file, analysis), forces)
    cranks = chain_of(engine_file, analysis)[1]
    whole = WholeTorsion(coupled, cranks, {}).loads
    ring = chain.response.motion[:, :, chain.response.names.index("line damper")]
    for loads, response, moved in (
        (chain.loads, chain.response, ring),
        (whole, coupled.total, coupled.motion("line damper rz")),
    ):
        assert loads.dashpots.names == PLACES[1:]
        turned = 6.0 * response.angular_frequencies**2 * moved
        # Modal damping of the chain, 1/80 of critical, is in no dashpot.
        scale = np.abs(turned).max()
        assert np.abs(loads.dashpots.values[:, :, 0] - turned).max() < 0.02 * scale
        # The gears without inertia pass on what the shafts on both sides have.
        before, behind = (
            loads.elastic.values[:, :, loads.elastic.names.index(name)]
            for name in ("input - pinion", "wheel - propeller")
        )
        assert before == close(-0.4 * behind, abs=1e-9 * np.abs(behind).max())
    judged = {check.limit.name: check for check in run.assessment.verdict.checks}
    for place, series in zip(PLACES, (chain.loads.elements, chain.loads.dashpots), strict=True):
        check = judged[f"torque of {place}"]
        at = series.names.index(place)
        assert check.curve.name == place
        assert check.curve.peak == close(series.synthesis.amplitude[:, at].max())


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
    given = {"stiffness": engine_file.main_bearings.stiffness}
    longer = engine_file.changed(bearings=given, misfire={"cylinders": [1]})
    longer = replace(longer, shaft_lines={"plant": plant}, free_end=None)
    whole = whole_shaft(longer, analysis)
    monkeypatch.setattr("crankfem.analyses.vibration.run.whole_shaft", lambda *_: whole)
    run = engine_vibration(longer, analysis=analysis, coupled=True)
    assert (run.comparison.axial, run.comparison.torsional) == (None, None)
    told = run.to_record()
    assert told["axial_force"]["running_whole"] is None
    assert told["not_comparable"] in told["assessment"]["by_whole"][0]
    running = (run.engine_file.engine.lowest_speed, run.engine_file.engine.highest_speed)
    record = told["whole"]
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


def numbers(sentence):
    """Its values with their units, in turn."""
    return re.findall(r"[\d.]+ (?:mrad|um|Hz|1/min)", sentence)


def test_difference_of_the_whole_shaft_is_told_beside_the_verdict():
    def verdict(kind, chain_peak, shaft_peak, frequencies=(100.0, 100.0), share=0.99):
        speeds = np.array([10.0, 20.0])
        match = ModeMatch(kind, 1, frequencies[0], 6, frequencies[1], share, 1.0, 1, 6)
        peaks = [np.array([0.0, peak]) for peak in (chain_peak, shaft_peak)]
        return ChainVerdict((match,), ResponseMatch(kind, speeds, *peaks))

    good = verdict("axial", 1e-4, 1.01e-4)
    assert (
        whole_shaft_remark(ShaftComparison(None, good, verdict("torsional", 1e-2, 1.05e-2))) == ()
    )
    bad = ShaftComparison(None, good, verdict("torsional", 13.1e-3, 8.752e-3, (118.5, 126.4)))
    (said,) = whole_shaft_remark(bad)
    assert numbers(said) == ["8.75 mrad", "191 1/min", "13.1 mrad", "191 1/min"]
    other = verdict("axial", 1.266e-3, 1.27e-3, (105.6, 115.0))
    mixed = verdict("torsional", 1e-2, 1e-2, share=0.48)
    (said,) = whole_shaft_remark(ShaftComparison(None, other, mixed))
    assert "48 %" in said
    assert "115.0 instead of" in said
    divided = FlywheelTilt("axial", 1, 259.8, 303.5, 225.9)
    assert numbers(divided.sentence) == ["259.8 Hz", "303.5 Hz"]
    assert "225.9 and" in divided.sentence
    (match,) = other.modes
    two = replace(match, further_frequency=80.0, further_share=0.4)
    (said,) = whole_shaft_remark(ShaftComparison(None, ChainVerdict((two,))))
    assert numbers(said) == ["115.0 Hz", "105.6 Hz"]
    assert "80.0 and" in said
    (said,) = whole_shaft_remark(ShaftComparison(None, verdict("axial", 1.266e-3, np.inf)))
    assert "unbounded" in said
    assert numbers(said)[-2:] == ["1266 um", "191 1/min"]


# From 200 to 515 1/min, and some beyond.
SPEEDS = np.linspace(18.0, 60.0, 421)
MODULUS = 1e-3
# Three throws between free end and flywheel.
CRANKS = SimpleNamespace(
    throw_nodes=(1, 2, 3),
    chain=SimpleNamespace(
        connections=((0, 1), (1, 2), (2, 3), (3, 4)), elements=("a", "b", "c", "d")
    ),
)


@pytest.fixture(scope="module")
def verdict_six():
    return load_engine("6chn25-34")


def compared(torque, *, adequate=()):
    """A whole crankshaft with one order's torque at the third of its four bearings."""
    values = np.zeros((1, SPEEDS.size, 4), dtype=complex)
    values[0, :, 2] = torque
    series = OrderSeries(
        np.array([1.0]),
        SPEEDS,
        values,
        np.zeros((1, SPEEDS.size), dtype=bool),
        ("main bearing 1", "main bearing 2", "main bearing 3", "main bearing 4"),
    )
    response = ResponseMatch("torsional", SPEEDS, np.ones(SPEEDS.size), np.ones(SPEEDS.size))
    kinds = [
        SimpleNamespace(kind=kind, suffices=kind in adequate, response=response)
        for kind in ("axial", "torsional")
    ]
    return ShaftComparison(SimpleNamespace(torque=series), *kinds)


def judged(six, comparison, checks=()):
    chains = SimpleNamespace(checks=checks)
    return whole_verdict(six, comparison, CRANKS, dict.fromkeys(range(4), MODULUS), chains)


def test_stress_at_a_bearing_is_that_of_the_element_through_it():
    moduli = {1: MODULUS, 2: 2.0 * MODULUS, 3: MODULUS}
    stress = WholeTorsion(compared(5e3).coupled, CRANKS, moduli).stress
    assert stress.names == ("b", "c", "d")
    assert np.max(stress.amplitude, axis=(0, 1)) == close((0.0, 2.5e6, 0.0))
    # Without a node at the free end the first element lies between the first two throws.
    bare = SimpleNamespace(
        throw_nodes=(0, 1, 2),
        chain=SimpleNamespace(connections=((0, 1), (1, 2), (2, 3)), elements=("b", "c", "d")),
    )
    stress = WholeTorsion(compared(5e3).coupled, bare, dict.fromkeys(range(3), MODULUS)).stress
    assert np.max(stress.amplitude, axis=(0, 1)) == close((0.0, 5e6, 0.0))


def test_only_inadequate_chains_are_replaced(verdict_six):
    assert judged(verdict_six, compared(1e5, adequate=("axial", "torsional"))) is None
    assert judged(verdict_six, ShaftComparison(None)) is None
    found = judged(verdict_six, compared(1e5))
    assert found.status == "not acceptable"
    assert (found.checks[0].curve.name, found.checks[0].worst_value) == ("c", close(1e8))
    assert judged(verdict_six, compared(1e2)).status == "fine"
    # Without a limit on what the inadequate chain gives, nothing is decided by it.
    assert judged(verdict_six, compared(1e2, adequate=("torsional",))) is None


def test_what_an_adequate_chain_exceeds_is_not_acceptable_by_the_whole_crankshaft_either(
    verdict_six,
):
    limited = verdict_six.changed(limits={"axial_amplitude": 1e-3, "axial_force": 1e4})
    found = judged(limited, compared(1e2, adequate=("axial",)))
    assert found.status == "not acceptable"
    assert found.checks[0].limit.name.startswith("axial amplitude")
    # Axial forces are those of the chain.
    limited = verdict_six.changed(limits={"axial_force": 1e4})
    limit = next(one for key, one in engine_limits(limited)[0].items() if key == "axial_force")
    force = AmplitudeCurve("throw 1", SPEEDS, np.full(SPEEDS.size, 2e4))
    found = judged(limited, compared(1e2), [SimpleNamespace(limit=limit, curve=force)])
    assert found.status == "not acceptable"
    assert found.checks[0].curve is force
    said = whole_sentence(found, SimpleNamespace(checks=found.checks[:1], status=found.status))
    assert limit.name in said
    assert f'"not acceptable" ({found.barred[0].sentence}).' in said


def test_verdicts_that_differ_leave_it_undecided(verdict_six):
    bad, fine, other = (judged(verdict_six, compared(torque)) for torque in (1e5, 1e2, 1e5))
    decided = decide("not acceptable", [])
    assert decision_by_both(decided, bad, bad) is decided
    for whole, chains, said in (
        (fine, bad, "acceptable by the whole crankshaft, not by the lumped model"),
        (bad, fine, "acceptable by the lumped model, not by the whole crankshaft"),
    ):
        found = decision_by_both(decided, whole, chains)
        assert found.status == "undecided"
        assert found.sentence.startswith(said)
    assert 'another verdict, "fine"' in whole_sentence(fine, bad)
    assert "100 MPa at" in whole_sentence(bad, other)


ALL = """
[damping]
loss_factor = 0.02
cylinder_damping = "20 N m s/rad"

[torsional_damper]
kind = "rubber"
ring_inertia = "4 kg m^2"
stiffness = "2e6 N m/rad"
loss_factor = 0.2

[axial_damper]
damping = "2e5 N s/m"
stiffness = "1e7 N/m"

[driven]
inertia = "200 kg m^2"
coupling_stiffness = "3e6 N m/rad"
coupling_loss_factor = 0.1

[bearings]
stiffness = "2e9 N/m"
damping = "3e4 N s/m"

[shaft_line]
torsional = "mwm-six"

[propeller_forces]
node = "propeller"
mean_thrust = "1 kN"

[gas]
"""
# Shares of axial, torsional and bending motion of a rigid mode, two that are kept, and one left out.
SHARES = np.array([[0.0, 1.0, 0.5, 0.2], [1.0, 0.0, 0.25, 0.4], [0.0, 0.0, 0.25, 0.4]])


def around(text="[gas]\n", name="6chn25-34", tmp_path=None):
    engine = load_engine(name)
    if tmp_path is not None:
        path = tmp_path / "engine.toml"
        path.write_text(
            input_path(name).read_text(encoding="utf-8").replace("[gas]\n", text), encoding="utf-8"
        )
        engine = load_engine(path)
    analysis = analysis_with(masses=SimpleNamespace(inertia_about_shaft=5.0))
    return engine, *shaft_surroundings(engine, analysis)


def test_every_section_of_a_file_has_its_place(tmp_path):
    text = ALL[: ALL.index("[shaft_line]")] + "[gas]\n"
    engine, found, remarks = around(text, tmp_path=tmp_path)
    stiffness, damping = found.bearings.at(7)
    assert (set(stiffness), set(damping)) == ({2e9}, {3e4})
    thrust, damper = found.axial_supports
    assert (thrust.section, thrust.stiffness) == (
        engine.thrust_bearing.section_index,
        engine.thrust_bearing.stiffness,
    )
    assert (damper.section, damper.stiffness, damper.damping) == (0, 1e7, 2e5)
    ring, machine = found.ring, found.machine
    assert (ring.inertia, ring.stiffness, ring.damping, ring.loss_factor) == (4.0, 2e6, 0.0, 0.2)
    assert (machine.inertia, machine.stiffness, machine.loss_factor) == (200.0, 3e6, 0.1)
    assert (found.flywheel.mass, found.flywheel.polar_inertia) == (
        engine.flywheel.mass,
        engine.flywheel.inertia,
    )
    assert found.free_end.polar_inertia == close(engine.free_end.inertia)
    # Damping of the shaft itself goes by modes.
    assert found.loss_factor == 0.0
    # No flange is given: the flywheel stands at the end of the last main journal.
    assert found.flywheel.overhang == 0.5 * engine.throw.main_journal_length
    assert any("assumed, because no flange is given" in remark for remark in remarks)
    assert not any("main bearings are assumed" in remark for remark in remarks)


def test_a_line_that_does_not_bend_is_told(tmp_path):
    line = ALL[ALL.index("[shaft_line]") : ALL.index("[propeller_forces]")]
    *_, without = around(tmp_path=tmp_path)
    engine, found, remarks = around(f"{line}[gas]\n", tmp_path=tmp_path)
    assert found.torsional_line is engine.shaft_lines["torsional"]
    (told,) = set(remarks) - set(without)
    assert "without bending" in told


LINE = """
[chain]
name = "line"
kind = "torsional"
[[chain.nodes]]
name = "flange"
inertia = "1 kg m^2"
[[chain.nodes]]
name = "joint"
inertia = "12 kg m^2"
[[chain.nodes]]
name = "propeller"
inertia = "100 kg m^2"
[[chain.elements]]
nodes = ["flange", "joint"]
shape = "cylinder"
diameter = "0.2 m"
length = "3 m"
[[chain.elements]]
nodes = ["joint", "propeller"]
shape = "cylinder"
diameter = "0.25 m"
length = "5 m"
"""


def lined(tmp_path, text=LINE, section="", axial=None):
    (tmp_path / "line.toml").write_text(text, encoding="utf-8")
    if axial is not None:
        (tmp_path / "along.toml").write_text(axial, encoding="utf-8")
        section += '\naxial = "along.toml"'
    return around(f'[shaft_line]\ntorsional = "line.toml"\n{section}\n[gas]\n', tmp_path=tmp_path)


def test_a_line_of_shafts_bends_on_bearings_that_are_assumed(tmp_path):
    *_, without = around(tmp_path=tmp_path)
    _, found, remarks = lined(tmp_path)
    beam = found.line_beam
    assert [piece.length for piece in beam.pieces] == [3.0, 5.0]
    assert (beam.masses, beam.inertias) == ((0.0,) * 3, (1.0, 12.0, 100.0))
    # 450 times the root of 200 mm is 6.36 m: two spans of 4 m.
    assert beam.bearings == ((4.0, 2e9), (8.0, 2e9))
    told = " ".join(remark for remark in remarks if remark not in without)
    assert (
        "bends over 8000 mm from the flywheel on, on bearings assumed to be 4000 mm, 8000 mm"
        in told
    )
    assert "give shaft_line.bearings" in told
    assert "give shaft_line.bearing_stiffness" in told
    assert "no mass across it" in told


def test_a_line_of_shafts_bends_on_the_bearings_of_the_file(tmp_path):
    *_, without = around(tmp_path=tmp_path)
    axial = LINE.replace("torsional", "axial").replace("inertia", "mass").replace(" m^2", "")
    section = 'bearings = ["1 m", "7 m"]\nbearing_stiffness = "3e8 N/m"'
    _, found, remarks = lined(tmp_path, section=section, axial=axial)
    assert found.line_beam.bearings == ((1.0, 3e8), (7.0, 3e8))
    assert found.line_beam.masses == (1.0, 12.0, 100.0)
    (told,) = set(remarks) - set(without)
    assert "on bearings 1000 mm, 7000 mm from there, of 3e8 N/m each" in told


def test_a_line_bends_up_to_what_is_no_piece_of_shaft(tmp_path):
    second = LINE[LINE.index('[[chain.elements]]\nnodes = ["joint') :]
    sizes = 'shape = "cylinder"\ndiameter = "0.25 m"\nlength = "5 m"'
    spring = second.replace(sizes, 'stiffness = "1e6 N m/rad"')
    _, found, _ = lined(tmp_path, LINE.replace(second, spring))
    assert found.line_beam.length == 3.0
    reversed_nodes = LINE.replace('["joint", "propeller"]', '["propeller", "joint"]')
    _, found, _ = lined(tmp_path, reversed_nodes)
    assert found.line_beam.length == 3.0


@pytest.mark.parametrize(
    ("change", "section", "said"),
    [
        (("", ""), 'bearings = ["9 m"]', "given one at 9000 mm; allowed is 0 to 8000 mm"),
        (("", ""), 'bearings = ["-1 m"]', "given one at -1000 mm"),
        (
            ('shape = "cylinder"\ndiameter = "0.2 m"\nlength = "3 m"', 'stiffness = "1e6 N m/rad"'),
            'bearings = ["1 m"]',
            "given for a line without a piece of shaft",
        ),
    ],
)
def test_bearings_that_no_line_has_are_refused(tmp_path, change, section, said):
    with pytest.raises(InputError, match=said):
        lined(tmp_path, LINE.replace(*change), section)


def test_overhangs_of_a_shaft_with_both_ends():
    engine, found, remarks = around(name="8chn13-14")
    assert found.flywheel.overhang == close(0.022)
    assert found.free_end.overhang == close(0.055)
    stub = engine.material.density * math.pi / 4.0 * 0.082**2 * 0.110
    assert found.free_end.mass == close(stub)
    # Across the cylinder m (3 r^2 + l^2) / 12, and half of what the file puts on it.
    own = stub * (3.0 * 0.041**2 + 0.110**2) / 12.0
    assert found.free_end.diametral == close(own + 0.5 * engine.free_end.inertia)
    assert any("far side of the flange, 22 mm beyond" in remark for remark in remarks)


def test_what_stands_at_the_ends_may_be_given_whole():
    engine = load_engine("6chn25-34").changed(
        flywheel={"diametral_inertia": 300.0, "overhang": 0.1},
        free_end={"mass": 40.0, "diametral_inertia": 3.0},
    )
    analysis = analysis_with(masses=SimpleNamespace(inertia_about_shaft=5.0))
    found, remarks = shaft_surroundings(engine, analysis)
    assert (found.flywheel.diametral, found.flywheel.overhang) == (300.0, 0.1)
    assert (found.free_end.mass, found.free_end.diametral) == (40.0, 3.0)
    assert not any("free end" in remark or "assumed" in remark for remark in remarks[1:])
    # The mass moves along the shaft, too.
    chains = [
        engine_axial_chain(own, np.full(6, 1e-9), 50.0).chain.inertia
        for own in (load_engine("6chn25-34"), engine)
    ]
    assert (chains[1] - chains[0]).tolist() == [40.0, *[0.0] * 6]


@pytest.mark.parametrize(
    ("given", "axial", "torsional"),
    [
        (None, 1 / 80, 1 / 80),
        ({}, 1 / 80, 1 / 80),
        ({"axial_magnifier": 10.0}, 1 / 20, 1 / 80),
        ({"torsional_magnifier": 20.0}, 1 / 80, 1 / 40),
        ({"loss_factor": 0.03}, 1 / 80, 0.015),
        ({"torsional_magnifier": 20.0, "loss_factor": 0.03}, 1 / 80, 1 / 40 + 0.015),
        # Absolute damping is left out, so that the assumed magnifier stays.
        ({"cylinder_damping": 20.0}, 1 / 80, 1 / 80),
    ],
)
def test_each_kind_of_motion_brings_its_damping(given, axial, torsional):
    fields = dict.fromkeys(
        (
            "axial_magnifier",
            "torsional_magnifier",
            "bending_magnifier",
            "loss_factor",
            "cylinder_damping",
        )
    )
    own_fields = fields | (given or {})
    damps = bool(own_fields["loss_factor"] or own_fields["cylinder_damping"])
    fields |= {"damps_torsion": damps}
    engine = SimpleNamespace(
        damping=None if given is None else SimpleNamespace(**fields | given), provenance={}
    )
    modes = SimpleNamespace(
        rigid=1, shares=SHARES, shapes=np.eye(3), angular_frequencies=np.array([0.0, 10.0, 20.0])
    )
    # A coupling with damping of its own has a tenth of the strain energy of the first elastic mode.
    coupled = SimpleNamespace(
        added_springs=np.array([[0.0, 10.0 * np.sqrt(0.1), 0.0]]),
        spring_kinds=np.array([0]),
        damped_springs=np.array([True]),
    )
    bare = SimpleNamespace(
        added_springs=np.empty((0, 3)),
        spring_kinds=np.empty(0, dtype=int),
        damped_springs=np.empty(0, dtype=bool),
    )
    crankshaft = SimpleNamespace(modes=modes, kept=2, corrections=1, shaft=bare)
    first = modal_damping(engine, SimpleNamespace(**vars(crankshaft) | {"shaft": coupled}))[0]
    is_given = given is not None and "axial_magnifier" in given
    assert first == close(axial * (1.0 if is_given else 0.9))
    if given is not None:
        bent = SimpleNamespace(
            damping=SimpleNamespace(**fields | given | {"bending_magnifier": 20.0}), provenance={}
        )
        assert modal_damping(bent, crankshaft)[-1] == close(1 / 40)
    mixed = 0.5 * axial + 0.25 * torsional + 0.25 / 80
    assert modal_damping(engine, crankshaft) == close([axial, mixed, 1 / 80])
    # What the file gives is not called assumed.
    own = given or {}
    twisted = "torsional_magnifier" in own or "loss_factor" in own
    told = damping_remarks(engine)[0].partition("axial motion ")[2].split(", ")
    wanted = [
        f"{100 * axial:.3g} %" + ("" if "axial_magnifier" in own else " (assumed)"),
        f"torsion {100 * torsional:.3g} %" + ("" if twisted else " (assumed)"),
        "bending 1.25 % (assumed)",
    ]
    assert told == wanted


@pytest.fixture(scope="module")
def two_pins():
    """A shaft of two throws with two pins each, as simple as can be."""

    def carried(arm):
        x, y, z = arm
        moved = np.eye(6)
        moved[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        return moved

    relative = np.hstack((-carried((0, 0, 0.2)), carried((0, 0, -0.2))))
    pins = np.array([[0.0, 0.1, 0.15], [0.1, 0.0, 0.25]])
    throw = ShaftThrow(
        stiffness=relative.T @ np.diag([5e9, 5e9, 1e9, 5e7, 5e7, 2e7]) @ relative,
        mass=np.kron(np.eye(2), np.diag([50.0, 50.0, 50.0, 1.5, 1.5, 1.5])),
        pin_loads=np.array(
            [
                np.hstack(
                    [share * carried((x, y, z - at)) for share, at in ((0.5, 0.0), (0.5, 0.4))]
                ).T
                for x, y, z in pins
            ]
        ),
        pins=pins,
        length=0.4,
        crank_angle_deg=0.0,
    )
    held = ShaftSurroundings(
        bearings=MainBearings(1e9), axial_supports=(AxialSupport(2, 5e8),), flywheel=None
    )
    return crankshaft_system(assemble_crankshaft([throw, throw], held))


def test_cylinders_act_on_the_pins_and_with_the_damping_of_the_file(two_pins):
    rng = np.random.default_rng(1)
    forces = SimpleNamespace(
        orders=np.array([1.0, 2.0]),
        speeds=np.array([40.0, 60.0]),
        tangential=rng.standard_normal((2, 2, 4)) + 0j,
        radial=rng.standard_normal((2, 2, 4)) + 0j,
        throws=(1, 0, 0, 1),
    )
    damping = SimpleNamespace(
        axial_magnifier=80.0,
        torsional_magnifier=80.0,
        bending_magnifier=None,
        loss_factor=None,
        cylinder_damping=None,
    )
    engine = SimpleNamespace(
        pins=(3, 0, 1, 2), damping=damping, provenance={}, propeller_forces=None, shaft_lines={}
    )
    whole = SimpleNamespace(crankshaft=two_pins)
    found = shaft_response(engine, whole, forces)
    ratios = modal_damping(engine, two_pins)
    assert found.tangential.system.damping_ratios() == close(ratios)
    same = coupled_response(two_pins, forces, pins=(3, 0, 1, 2), modal_damping=ratios)
    for point in ("main bearing 1 uz", "pin 4 radial"):
        assert np.array_equal(found.motion(point), same.motion(point))
    doubled = shaft_response(engine, whole, forces, 20.0)
    assert doubled.tangential.system.damping_ratios() == close(1 / 40)


def test_what_only_the_chains_know(tmp_path):
    text = ALL.replace('\n[propeller_forces]\nnode = "propeller"\nmean_thrust = "1 kN"\n', "")
    engine, *_ = around(text, tmp_path=tmp_path)
    assert not_comparable(engine) == ""
    assert not_comparable(load_engine("6chn25-34")) == ""
    assert "shaft_line.plant" in not_comparable(load_engine("5rt-flex50d"))
    # A propeller on the line moves it; one elsewhere is in the chains alone.
    with_propeller = load_engine(Path(__file__).parents[1] / "data/engines/5-42-176-propeller.toml")
    assert not_comparable(with_propeller) == ""
    elsewhere = with_propeller.changed(propeller_forces={"node": "flywheel"})
    assert "act on flywheel, not behind the flywheel" in not_comparable(elsewhere)


def test_axial_work_of_a_radial_force_counts_all_throws_that_it_lengthens():
    """Force P_ij in throw i by pin j: 1 * 1 + 3 * 2 and 2 * 1 + 4 * 2."""
    weights = axial_weights(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([0.0, 1.0, 3.0]))
    assert weights.tolist() == [7.0, 10.0]


@pytest.mark.parametrize(
    ("degrees", "strokes", "interval"),
    [
        (np.arange(12) * 60.0, 4, 60.0),
        (np.arange(16) * 45.0 + 1e-9, 4, 45.0),
        ([0.0, 90.0, 150.0, 240.0, 300.0, 390.0], 4, None),
        ([0.0, 180.0], 2, 180.0),
        ([0.0, 180.0], 4, None),
    ],
)
def test_interval_of_even_firing(degrees, strokes, interval):
    assert even_firing_interval(np.radians(degrees), strokes) == interval


def test_interval_of_a_shipped_v_engine():
    engine = load_engine("8chn13-14").engine
    assert even_firing_interval(engine.firing_angles, engine.strokes) == 90.0


def test_a_picked_rule_takes_the_steel_that_is_given():
    plain = load_engine("6chn25-34")
    speeds = np.array([0.9 * plain.engine.rated_speed])
    permitted = [
        engine_limits(own)[0]["crankshaft_stress"].continuous.at(speeds)[0]
        for own in (plain, plain.changed(limits={"tensile_strength": 590e6}))
    ]
    assert permitted[1] / permitted[0] == close(1.0 + 2.0 / 3.0 * (590.0 / 440.0 - 1.0))
