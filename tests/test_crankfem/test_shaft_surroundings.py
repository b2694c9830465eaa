"""What an engine file puts around the whole crankshaft, and how that is damped; no finite elements."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.shaft.chains import engine_axial_chain, shaft_surroundings
from crankfem.analyses.shaft.whole_shaft import (
    damping_remarks,
    modal_damping,
    not_comparable,
    shaft_response,
)
from crankfem.analyses.vibration.engine_limits import engine_limits, even_firing_interval
from crankfem.analyses.vibration.modes import axial_weights
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.reading.data_files import input_path
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.coupled_response import coupled_response
from dynamics.crankshaft.shaft_modes import crankshaft_system
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    MainBearings,
    ShaftSurroundings,
    ShaftThrow,
)

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
    analysis = SimpleNamespace(masses=SimpleNamespace(inertia_about_shaft=5.0))
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
    analysis = SimpleNamespace(masses=SimpleNamespace(inertia_about_shaft=5.0))
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
