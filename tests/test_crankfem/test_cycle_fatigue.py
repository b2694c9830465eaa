"""Fatigue over the cycle: loads in balance, statics of a single throw, the worst point by brute force."""

from dataclasses import replace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.strength import cycle_fatigue
from crankfem.analyses.strength import cycle_loads as loads_module
from crankfem.analyses.strength.cycle_fatigue import (
    EngineFatigue,
    FatiguePlace,
    fatigue_or_reason,
    fatigue_table,
)
from crankfem.analyses.strength.cycle_loads import (
    ShaftUnderForces,
    cycle_loads,
    judged_speeds,
    superposition,
)
from crankfem.analyses.vibration.misfiring import Superposition
from dynamics.response.order_excitation import at_angles
from dynamics.strength.fatigue import critical_plane, findley_factor, findley_limit
from fem import fillet_stress
from fem.fields import stress_fields
from fem.superelement import assemble_shaft, shaft_unknowns
from stand_ins import stress_coarsely

STEEL = {"tensile_strength": 8e8, "manufacture": "continuous grain flow", "piston": "trunk"}
FORCES, MOMENTS = [0, 1, 2], [3, 4, 5]


@pytest.fixture(scope="module")
def vibration(coupled_vibration):
    whole = coupled_vibration("6chn25-34")
    return replace(whole, engine_file=whole.engine_file.changed(strength=STEEL))


@pytest.fixture(scope="module")
def stresses(vibration):
    with pytest.MonkeyPatch.context() as patched:
        stress_coarsely(patched)
        file = vibration.engine_file
        return {"throw": fillet_stress.fillet_stresses(file.throw, file.material, 0.2)}


@pytest.fixture(scope="module")
def found(vibration, stresses):
    """At every hundredth speed: the search is the same."""

    def some(own):
        kept, barred = judged_speeds(own)
        return kept & (np.arange(len(kept)) % 100 == 0), barred

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(cycle_fatigue, "judged_speeds", some)
        return cf.strength.engine_fatigue(vibration, stresses=stresses)


@pytest.fixture(scope="module")
def loads(vibration):
    """At three speeds, firing and while cylinder 4 misfires."""
    speeds = vibration.forced_torsional.response.speeds[[0, 60, 130]]
    both = cycle_loads(vibration, speeds, [(), (4,)])
    return {one.cylinders: one for one in both}


@pytest.mark.further
@pytest.mark.parametrize("case", [(), (4,)])
def test_every_throw_is_in_balance(loads, vibration, case):
    throw, own = vibration.engine_file.throw, loads[case]
    (pin,) = throw.parts.pins
    left, right = own.ends[..., :6], own.ends[..., 6:]
    force = left[..., FORCES] + right[..., FORCES] + own.pins[..., FORCES]
    moment = left[..., MOMENTS] + right[..., MOMENTS] + own.pins[..., MOMENTS]
    center = np.array([*pin.axis, 0.5 * (pin.start + pin.end)])
    moment += np.cross([0.0, 0.0, throw.length], right[..., FORCES])
    moment += np.cross(center, own.pins[..., FORCES])
    assert force == close(np.zeros_like(force), abs=1e-6 * np.abs(own.pins).max())
    assert moment == close(np.zeros_like(moment), abs=1e-6 * np.abs(own.ends).max())


@pytest.mark.slow
def test_torque_and_axial_force_are_the_chains(loads, vibration):
    own, forced = loads[()], vibration.forced_torsional
    # What one throw takes its neighbor gives: torque and tension go through the main journal.
    assert own.ends[:-1, ..., 11] == close(-own.ends[1:, ..., 5], abs=1e-6 * np.abs(own.ends).max())
    elastic = forced.loads.elastic
    place = int(np.argmin(np.abs(elastic.speeds - own.speeds[1])))
    cycle = at_angles(elastic.orders, elastic.values[:, place], own.angles)
    sense = vibration.engine_file.engine.turning_sense
    radius = vibration.engine_file.throw.crank_radius
    passed = -np.cumsum(radius * forced.forces.mean_tangential[place])
    for throw, node in enumerate(forced.engine_chain.throw_nodes):
        expected = sense * (cycle[:, node] + passed[throw])
        assert own.ends[throw, 1, :, 11] == close(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1, -1])
def test_pin_forces_and_torques_agree_whichever_way_the_shaft_turns(vibration, sense):
    """Slowly what a rod turns goes into the shaft: the throw's inertia takes little of it."""
    file = vibration.engine_file
    first, *others = file.engine.firing_order
    if sense != file.engine.turning_sense:
        others.reverse()
    own = replace(vibration, engine_file=file.changed(engine={"firing_order": (first, *others)}))
    assert own.engine_file.engine.turning_sense == sense
    slow = vibration.forced_torsional.response.speeds[:1]
    (loads,) = cycle_loads(own, slow, [()])
    radius = own.engine_file.throw.crank_radius
    taken = np.ptp(loads.pins[:, 0, :, 5], axis=1)
    assert np.all(taken < 0.1 * (radius * np.ptp(loads.pins[:, 0, :, 0], axis=1)))


@pytest.mark.slow
def test_unbounded_vibration_is_refused(vibration):
    speed = vibration.forced_torsional.response.speeds[:1]

    class Endless(Superposition):
        def at(self, speeds, cases):
            for case, series in super().at(speeds, cases):
                endless = {
                    key: replace(own, unbounded=np.ones_like(own.unbounded))
                    for key, own in series.items()
                }
                yield case, endless

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(loads_module, "Superposition", Endless)
        with pytest.raises(InputError, match=r"damping: "):
            list(cycle_loads(vibration, speed, [()]))


@pytest.mark.slow
def test_misfiring_lessens_the_forces_of_its_cylinder_alone(loads):
    change = np.abs(loads[4,].pins[..., :2] - loads[()].pins[..., :2]).max(axis=(1, 2, 3))
    assert np.all(np.delete(change, 3) < 1e-6 * change[3])


@pytest.mark.slow
def test_the_answer_to_all_forces_is_the_sum_of_normal_firing_and_what_is_missing(vibration):
    speeds = vibration.forced_torsional.response.speeds[::40]
    added = superposition(vibration)
    for case, expected in added.at(speeds, [(), (4,), (1, 4)]):
        for key, series in added.of(speeds, case).items():
            scale = np.max(np.abs(expected[key].values))
            assert series.values == close(expected[key].values, abs=1e-12 * scale)


@pytest.mark.further
def test_one_throw_by_itself_is_a_beam_on_two_supports(vibration, stresses):
    """A force off the middle of the pin, rigid bearings: supports by the lever rule, no end moments."""
    file = vibration.engine_file
    alone = ShaftUnderForces((vibration.analysis.superelement,), np.zeros(1), np.inf)
    (pin,) = file.throw.parts.pins
    length, arm = file.throw.length, 0.03
    place = 0.5 * (pin.start + pin.end) + arm
    acting = np.zeros((1, 1, 6))
    acting[..., 1], acting[..., 3] = -1.0, arm
    ends = alone.end_loads(acting, np.zeros((2, 1)), np.zeros((1, 1)))[0, 0]
    expected = np.zeros(12)
    expected[[1, 7]] = 1.0 - place / length, place / length
    assert ends == close(expected, abs=1e-6)
    # In the middle it is the radial unit load, with the same largest stresses.
    acting[..., 3] = 0.0
    ends = alone.end_loads(acting, np.zeros((2, 1)), np.zeros((1, 1)))
    own = stresses["throw"]
    fields = stress_fields(own.loaded.mesh, file.throw, file.material)
    amplitudes = fields.amplitudes(ends[0], acting[0])[0]
    radial = next(load for load in own.loaded.loads if load.kind == "radial")
    for site, peak in zip(fields.sites, own.under(radial), strict=True):
        first, second, between = np.tensordot(amplitudes, site.stress, axes=(0, 1)).T
        equivalent = np.sqrt(first**2 - first * second + second**2 + 3.0 * between**2)
        assert equivalent.max() == close(peak.von_mises, 1e-5)


@pytest.mark.slow
def test_bending_is_that_of_the_whole_shaft_far_below_its_bending_modes(vibration, loads):
    """The coupled answer has inertia, and the rods at the middle of their pins, as this engine has them."""
    own, file = loads[()], vibration.engine_file
    forced = vibration.forced_torsional
    place = int(np.argmin(np.abs(forced.response.speeds - own.speeds[0])))
    coupled = vibration.comparison.coupled
    assert coupled.speeds[place] == close(own.speeds[0])
    motion = coupled.tangential.motion[:, place] + coupled.radial.motion[:, place]
    forces = forced.forces
    angles = [float(angle) for angle in file.throw_angles_deg]
    throws = [vibration.analysis.superelement.joined.turned(angle_deg=one) for one in angles]
    parts = [shaft_unknowns(place, 6, throws[0].sections.bending) for place in range(6)]
    stiffness = assemble_shaft(throws)
    given = np.zeros((len(stiffness), len(forces.orders)), dtype=complex)
    acting = np.zeros((6, 6, len(forces.orders)), dtype=complex)
    acting[:, 0] = -file.engine.turning_sense * forces.tangential[:, place].T
    acting[:, 1] = -forces.radial[:, place].T
    for part, throw, loads_on_pin in zip(parts, throws, acting, strict=True):
        given[part] += throw.pin_loads[0] @ loads_on_pin
    # Sections bend as if at rest: what is beyond their mean motion has no load from outside.
    mean, beyond = np.split(np.arange(len(stiffness)), [42])
    moved = np.concatenate([motion[:, mean].T, np.empty((len(beyond), len(forces.orders)))])
    rest = given[beyond] - stiffness[np.ix_(beyond, mean)] @ moved[mean]
    moved[beyond] = np.linalg.solve(stiffness[np.ix_(beyond, beyond)], rest)
    compared = []
    for throw, angle in enumerate(np.radians(angles).tolist()):
        own_throw = throws[throw]
        ends = own_throw.stiffness @ moved[parts[throw]] - own_throw.pin_loads[0] @ acting[throw]
        moment = np.cos(angle) * ends[9] + np.sin(angle) * ends[10]
        cycle = at_angles(forces.orders, moment[:, None], own.angles)[:, 0]
        compared.append((np.ptp(cycle), np.ptp(own.ends[throw, 0, :, 9])))
    whole, ours = np.array(compared).T
    # Inertia makes 0.1 %. The last section carries the flywheel, whose tilting inertia is left out.
    assert ours[:-1] == close(whole[:-1], rel=5e-3)


@pytest.mark.further
def test_the_worst_point_is_the_worst_of_all(found, vibration, stresses):
    """Every node of the fillet by the criterion itself, on the loads of the place's speed and firing."""
    file, worst = vibration.engine_file, found.places[0]
    (own,) = cycle_loads(vibration, np.array([worst.speed]), [worst.cylinders])
    fields = stress_fields(stresses["throw"].loaded.mesh, file.throw, file.material)
    site = next(one for one in fields.sites if one.name == worst.name)
    number = worst.throw - 1
    amplitudes = fields.amplitudes(own.ends[number, 0], own.pins[number, 0])
    history = np.tensordot(amplitudes, site.stress, axes=(1, 1)).swapaxes(0, 1)
    factor = findley_factor()
    every = [critical_plane(one, factor) for one in history]
    assert worst.value == close(max(every, key=lambda one: one.value).value, 5e-3)
    node = int(np.argmin(np.linalg.norm(site.points - worst.point, axis=1)))
    assert every[node].value == close(worst.value)
    assert np.degrees(own.angles[every[node].moment]) == close(worst.shaft_angle_deg)
    assert worst.safety == close(findley_limit(worst.strength, factor) / every[node].value)


@pytest.mark.further
def test_what_is_said_of_fatigue(found, vibration):
    assert len(found.places) == 24
    assert [one.safety for one in found.places] == sorted(one.safety for one in found.places)
    least = found.places[0]
    rule = cf.strength.engine_strength(vibration)
    factors = [
        one.acceptability for one in rule.throws[least.throw - 1].places if one.place == least.place
    ]
    assert least.rule_factor == close(min(factors))
    assert f"{least.safety:.2f} at the {least.name}" in found.sentence
    assert f"UR M53 has Q = {least.rule_factor:.2f}" in found.sentence
    assert len(fatigue_table(found).rows) == 12  # pin and journal fillets of six throws
    (place, *_) = found.to_record()["places"]
    assert place["safety"] == least.safety
    assert place["speed_rpm"] == close(least.speed * 30.0 / np.pi)
    assert EngineFatigue.from_json(found.to_json()).sentence == found.sentence
    assert len(found.to_pandas()) == 24


def test_sentences_of_misfiring_and_of_places_without_a_factor():
    place = FatiguePlace(
        *(2, "oil hole", "pin, oil hole 1 at 0 deg", (0.0, 0.1, 0.2), 50.0, (3,), 12.0),
        *(1e8, 5e7, 1.1e8, 1.65e8, 2.8e8, None),
    )
    said = EngineFatigue((place,), 0.1566, ()).sentence
    assert "safety factor is 1.50" in said
    assert "cylinder 3 misfires" in said
    weak = replace(place, value=3.3e8, rule_factor=0.9)
    said = EngineFatigue((weak, place), 0.1566, ()).sentence
    assert "is 0.50 at" in said
    assert all(one in said for one in ("1 of 2 ", "Q = 0.90"))


@pytest.mark.slow
def test_an_engine_without_fillets_has_a_reason(vibration):
    bare = vibration.engine_file.changed(
        throw={"fillet_radius": 0.0, "main_journal_fillet_radius": 0.0}
    )
    own = replace(vibration, engine_file=bare)
    fatigue, reason = fatigue_or_reason(own, cf.strength.engine_strength(own), {})
    assert fatigue is None
    assert reason.startswith("fillet_radius: given 0")
