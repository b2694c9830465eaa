import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import AxialDamper, RubberDamper, ViscousDamper
from dynamics.chains.editing import add_node, with_names
from dynamics.chains.engine_chains import (
    axial_chain,
    throw_inertia,
    throw_inertias,
    torsional_chain,
)
from dynamics.chains.shaft_line import DrivenMachine, ShaftLine, shaft_cylinder
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.motions import reduced_inertia
from dynamics.engine.rods import ConnectingRod


def test_axial_chain_shares_each_throw_between_its_sections():
    built = axial_chain([1e-9, 2e-9], [100.0, 140.0], 500.0, 1, 3e8, {0: 7.0})
    assert built.kind == "axial"
    assert built.nodes == (
        "main bearing 1",
        "main bearing 2, thrust bearing",
        "main bearing 3, flywheel",
    )
    assert built.chain.inertia.tolist() == [57.0, 120.0, 570.0]
    assert built.chain.stiffness == close([1e9, 5e8])
    assert built.chain.ground.tolist() == [0.0, 3e8, 0.0]


def test_thrust_bearing_may_stand_at_the_flywheel_and_masses_as_a_list():
    built = axial_chain([1e-9], [100.0], 500.0, 1, 3e8, [1.0, 2.0])
    assert built.nodes == ("main bearing 1", "main bearing 2, flywheel, thrust bearing")
    assert built.chain.inertia.tolist() == [51.0, 552.0]


def test_axial_chain_without_bearing_and_flywheel_is_free():
    built = axial_chain([1e-9], [100.0], 0.0, 0, 0.0)
    assert built.nodes == ("main bearing 1", "main bearing 2")
    modes = built.chain.modes()
    assert modes.rigid == 1
    assert modes.angular_frequencies[1] == close(np.sqrt(1e9 * (1 / 50 + 1 / 50)))


def test_torsional_chain_without_additions():
    built = torsional_chain([2e-7, 4e-7], [0.5, 0.6], 10.0)
    assert built.kind == "torsional"
    assert built.nodes == ("cylinder 1", "cylinder 2", "flywheel")
    assert built.chain.inertia.tolist() == [0.5, 0.6, 10.0]
    assert 1.0 / built.chain.stiffness == close([3e-7, 2e-7])
    assert not built.chain.ground.any()


def test_torsional_chain_with_free_end_and_driven_machine():
    driven = DrivenMachine(inertia=30.0, coupling_stiffness=1e5)
    built = torsional_chain([2e-7, 4e-7], [0.5, 0.6], 10.0, free_end_inertia=0.1, driven=driven)
    assert built.nodes == ("free end", "cylinder 1", "cylinder 2", "flywheel", "driven machine")
    assert built.chain.inertia.tolist() == [0.1, 0.5, 0.6, 10.0, 30.0]
    assert 1.0 / built.chain.stiffness == close([1e-7, 3e-7, 2e-7, 1e-5])


def test_whole_compliance_of_the_shaft_is_kept():
    compliances = [2e-7, 4e-7, 3e-7]
    chain = torsional_chain(compliances, [1.0, 1.0, 1.0], 5.0, free_end_inertia=1.0).chain
    assert np.sum(1.0 / chain.stiffness) == close(sum(compliances))


def test_throw_inertia():
    assert throw_inertia(1.5, 4.0, 6.0, 0.1) == close(1.5 + 0.04 + 0.03)


def test_half_the_reciprocating_mass_is_the_mean_over_a_revolution():
    # Exact slider-crank velocity per radian; the next term of the mean is lambda^2 / 8.
    radius, ratio, mass = 0.07, 0.3, 2.0
    angle = np.arange(720) * np.pi / 360.0
    swing = np.sqrt(1.0 - (ratio * np.sin(angle)) ** 2)
    velocity = radius * (np.sin(angle) + ratio * np.sin(angle) * np.cos(angle) / swing)
    mean = np.mean(mass * velocity**2)
    assert throw_inertia(1.0, 0.0, mass, radius) - 1.0 == close(mean, rel=0.3 * ratio**2)


def test_throws_and_sections_are_known_by_their_nodes():
    torsional = torsional_chain([1.0, 1.0], [1.0, 1.0], 2.0, free_end_inertia=0.5)
    assert torsional.throw_nodes == (1, 2)
    assert (torsional.sections, torsional.throws) == ((), 2)
    axial = axial_chain([1.0, 1.0], [1.0, 1.0], 2.0, 0, 0.0)
    assert axial.sections == (0, 1, 2)
    assert (axial.throw_nodes, axial.throws) == ((), 2)


def test_throws_of_several_cylinders_are_called_throws():
    assert torsional_chain([1.0], [1.0], 1.0, cylinders=2).nodes == ("throw 1", "flywheel")
    mixed = torsional_chain([1.0] * 2, [1.0] * 2, 1.0, cylinders=[1, 2])
    assert mixed.nodes == ("throw 1", "throw 2", "flywheel")


def test_torsional_chain_with_damping_dampers_and_machines():
    machines = [
        DrivenMachine(30.0, 1e5, 0.2, 0.1, damping=0.3, name="alternator"),
        DrivenMachine(2.0, 1e4, name="exciter", on="alternator"),
    ]
    built = torsional_chain(
        *([2e-7, 4e-7], [0.5, 0.6], 10.0, 0.1, machines),
        damping=1.0,
        loss_factor=[0.01, 0.02, 0.03],
        throw_damping=[2.0, 4.0],
        damper=ViscousDamper(0.7, 50.0, hub_inertia=0.2),
    )
    chain = built.chain
    assert built.nodes == (
        *("free end", "cylinder 1", "cylinder 2", "flywheel"),
        *("alternator", "exciter", "damper ring"),
    )
    assert chain.inertia == close([0.3, 0.5, 0.6, 10.0, 30.0, 2.0, 0.7])
    assert chain.damping.tolist() == [1.0, 1.0, 1.0, 0.2, 0.0]
    assert chain.loss_factor.tolist() == [0.01, 0.02, 0.03, 0.1, 0.0]
    assert chain.ground_damping.tolist() == [0.0, 2.0, 4.0, 0.0, 0.3, 0.0, 0.0]
    assert chain.connections[-2:] == ((3, 4), (4, 5))
    assert [(d.left, d.right, d.damping) for d in chain.dashpots] == [(0, 6, 50.0)]


def test_the_hub_of_a_damper_makes_a_free_end():
    built = torsional_chain([1e-7], [1.0], 1.0, damper=RubberDamper(0.3, 1e5, hub_inertia=0.1))
    assert built.nodes == ("free end", "cylinder 1", "flywheel", "damper ring")
    assert built.chain.inertia.tolist() == [0.1, 1.0, 1.0, 0.3]
    assert built.chain.stiffness == close([2e7, 2e7, 1e5])


def test_axial_chain_with_damping_damper_and_shaft_line():
    line = ShaftLine([shaft_cylinder(3.0, 0.2)], name="line").chain("axial")
    built = axial_chain(
        *([1e-9, 2e-9], [100.0, 140.0], 500.0, 1, 3e8),
        thrust_damping=9.0,
        damping=[1.0, 2.0],
        loss_factor=0.01,
        section_damping=[4.0, 5.0, 6.0],
        damper=AxialDamper(1e5, stiffness=2e7, mass=30.0),
        shaft_line=line,
    )
    chain = built.chain
    assert built.nodes[-2:] == ("main bearing 3, flywheel", "line 1")
    assert chain.inertia.tolist() == [80.0, 120.0, 570.0, 0.0]
    assert chain.ground.tolist() == [2e7, 3e8, 0.0, 0.0]
    assert chain.ground_damping.tolist() == [1e5 + 4.0, 14.0, 6.0, 0.0]
    assert chain.damping.tolist() == [1.0, 2.0, 0.0]
    assert chain.loss_factor.tolist() == [0.01, 0.01, 0.0]
    assert built.sections == (0, 1, 2)


def test_torsional_chain_with_a_shaft_line():
    line = ShaftLine([shaft_cylinder(3.0, 0.2)], name="line").chain()
    built = torsional_chain([1e-7], [1.0], 5.0, shaft_line=line)
    assert built.nodes == ("cylinder 1", "flywheel", "line 1")
    assert built.chain.is_row


def test_an_engine_chain_keeps_its_throws_when_its_chain_is_edited():
    built = torsional_chain([1e-7], [1.0], 5.0)
    wider = built.with_chain(add_node(built.chain, "pump", 0.1, to="flywheel", ratio=2.0))
    assert wider.nodes == ("cylinder 1", "flywheel", "pump")
    assert wider.throw_nodes == built.throw_nodes
    with pytest.raises(InputError, match=r"chain: given nodes a, b; .*begin with cylinder 1"):
        built.with_chain(with_names(built.chain, ["a", "b"]))


@pytest.fixture
def v_four():
    """Two throws at 90 deg with two cylinders each: side by side, and one rod hinged."""
    rod = ConnectingRod(length=0.25, mass=3.0, center_distance=0.08, inertia=0.02)
    crank, bank = np.pi / 2.0, np.pi / 4.0
    pin = SlavePin(main_cylinder=3, radius=0.06, angle_deg=90.0)
    slave = ConnectingRod(length=0.19, mass=2.0, center_distance=0.08, inertia=0.01)
    return EngineLayout(
        crank_radius=0.07,
        cylinders=[
            EngineCylinder(
                0.12,
                2.0,
                rod,
                crank_angle_deg=0.0,
                bank_angle_deg=math.degrees(-bank),
                position=0.0,
            ),
            EngineCylinder(
                0.12,
                2.0,
                rod,
                crank_angle_deg=0.0,
                bank_angle_deg=math.degrees(bank),
                position=0.03,
            ),
            EngineCylinder(
                0.12,
                2.0,
                rod,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=math.degrees(-bank),
                position=0.2,
            ),
            EngineCylinder(
                0.12,
                2.0,
                slave,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=math.degrees(bank),
                position=0.2,
                slave_pin=pin,
            ),
        ],
        firing_order=[1, 2, 3, 4],
    )


def test_throw_inertias_of_several_cylinders(v_four):
    half = throw_inertias(v_four, [0.5, 0.6])
    at_piston = 3.0 * 0.08 / 0.25
    assert half[0] == close(throw_inertia(0.5, [3.0 - at_piston] * 2, [2.0 + at_piston] * 2, 0.07))
    exact = throw_inertias(v_four, [0.5, 0.6], reciprocating="mean")
    # The mean of the whole engine's reduced inertia, by another path through the mechanism.
    models = tuple(cylinder.rod.model("rigid") for cylinder in v_four.cylinders)
    whole, _ = reduced_inertia(
        v_four,
        models,
        shaft_angles_deg=np.degrees(np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)),
    )
    assert exact.sum() == close(1.1 + whole.mean(), rel=1e-12)
    # Half the mass leaves out lambda^2 / 8 of the piston's share and the rod's lacking inertia.
    assert half[0] == close(exact[0], rel=0.02)
    assert half[0] != close(exact[0], rel=1e-4)
    given = throw_inertias(v_four, [0.5, 0.6], reciprocating="mean", throws=[0, 0, 1, 1])
    assert given.tolist() == exact.tolist()


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 0.4), st.floats(0.1, 0.6), st.floats(0.5, 1.0))
def test_mean_inertia_of_a_throw_is_its_series_in_the_crank_ratio(ratio, along, share):
    """The next terms have lambda^4, times the moving masses and the inertia that two masses lack."""
    radius, piston, mass = 0.12, 12.0, 8.0
    length = radius / ratio
    near, far = along * length, (1.0 - along) * length
    inertia = share * mass * near * far
    rod = ConnectingRod(length, mass, near, inertia)
    engine = EngineLayout(radius, [EngineCylinder(0.2, piston, rod)], [1], strokes=2)
    moving = piston + mass * along
    (half,) = throw_inertias(engine, [1.5])
    (mean,) = throw_inertias(engine, [1.5], reciprocating="mean")
    assert half == close(1.5 + (mass * (1.0 - along) + moving / 2.0) * radius**2)
    series = half + ratio**2 * (moving * radius**2 / 8.0 + (inertia - mass * near * far) / 2.0)
    beyond = (piston + mass) * radius**2 + mass * near * far / 4.0
    assert mean == close(series, abs=beyond * ratio**4)


def test_unusable_throw_inertias_are_refused(v_four):
    with pytest.raises(InputError, match="reciprocating: given 'third'"):
        throw_inertias(v_four, 1.0, reciprocating="third")
    with pytest.raises(InputError, match="solid_inertias: given 3 values for 2 throws"):
        throw_inertias(v_four, [1.0, 1.0, 1.0])
    with pytest.raises(InputError, match="throws: given 1"):
        throw_inertias(v_four, 1.0, throws=[0])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: axial_chain([], [], 1.0, 0, 1.0), "throw_compliances: given no values"),
        (lambda: axial_chain([0.0], [1.0], 1.0, 0, 1.0), r"throw_compliances\[0\]: given 0 m/N"),
        (lambda: axial_chain([1.0], [1.0, 1.0], 1.0, 0, 1.0), "throw_masses: given 2 values"),
        (lambda: axial_chain([1.0], [1.0], -1.0, 0, 1.0), "flywheel_mass: given -1 kg"),
        (lambda: axial_chain([1.0], [1.0], 1.0, 2, 1.0), "thrust_node: given 2; .*0 to 1"),
        (lambda: axial_chain([1.0], [1.0], 1.0, 0.5, 1.0), "thrust_node: given 0.5"),
        (lambda: axial_chain([1.0], [1.0], 1.0, 0, -1.0), "thrust_stiffness: given -1 N/m"),
        (lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, [1.0]), "extra_masses: given 1 values"),
        (lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, {0: -1.0}), r"extra_masses\[0\]: given -1"),
        (lambda: torsional_chain([1.0], [1.0], 0.0), "flywheel_inertia: given 0 kg m"),
        (lambda: torsional_chain([1.0], [-1.0], 1.0), r"throw_inertias\[0\]: given -1"),
        (lambda: torsional_chain([1.0], [1.0], 1.0, -1.0), "free_end_inertia: given -1"),
        (lambda: torsional_chain([1.0], [1.0], 1.0, damping=-1.0), r"damping\[0\]: given -1"),
        (
            lambda: torsional_chain([1.0], [1.0], 1.0, throw_damping=[1.0, 1.0]),
            "throw_damping: given 2 values for 1 throws",
        ),
        (lambda: torsional_chain([1.0], [1.0], 1.0, cylinders=0), "cylinders: given 0"),
        (lambda: torsional_chain([1.0], [1.0], 1.0, cylinders=[1, 1]), "cylinders: given 2 values"),
        (
            lambda: torsional_chain([1.0], [1.0], 1.0, damper=ViscousDamper(1.0, 1.0)),
            "free_end_inertia: given 0 with a damper",
        ),
        (
            lambda: torsional_chain([1.0], [1.0], 1.0, damper=AxialDamper(1.0)),
            "damper: given AxialDamper.* torsional",
        ),
        (
            lambda: axial_chain([1.0], [1.0], 1.0, 0, 1.0, damper=ViscousDamper(1.0, 1.0)),
            "damper: given ViscousDamper.* axial",
        ),
        (
            lambda: torsional_chain([1.0], [1.0], 1.0, 0.0, DrivenMachine(1.0, 1.0, on="pump")),
            "to: given 'pump'; allowed are cylinder 1, flywheel",
        ),
        (
            lambda: torsional_chain(
                [1.0], [1.0], 1.0, shaft_line=Chain([1.0, 1.0], [1.0])
            ).with_chain(Chain([1.0], [])),
            "chain: given nodes node 0",
        ),
        (lambda: DrivenMachine(0.0, 1.0), "driven.inertia: given 0"),
        (lambda: DrivenMachine(1.0, 0.0), "driven.coupling_stiffness: given 0"),
        (lambda: throw_inertia(0.0, 1.0, 1.0, 1.0), "solid_inertia_about_shaft: given 0"),
        (lambda: throw_inertia(1.0, -1.0, 1.0, 1.0), "rod_rotating_mass: given -1"),
        (lambda: throw_inertia(1.0, 1.0, -1.0, 1.0), "reciprocating_mass: given -1"),
        (lambda: throw_inertia(1.0, 1.0, 1.0, 0.0), "crank_radius: given 0 m"),
    ],
)
def test_unusable_values_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
