import numpy as np
import pytest

from dynamics.chains.engine_chains import DrivenMachine, axial_chain, throw_inertia, torsional_chain
from geometry.errors import InputError


def test_axial_chain_shares_each_throw_between_its_sections():
    built = axial_chain([1e-9, 2e-9], [100.0, 140.0], 500.0, 1, 3e8, {0: 7.0})
    assert built.kind == "axial"
    assert built.nodes == ("section 0", "section 1, thrust bearing", "section 2, flywheel")
    assert built.chain.inertia.tolist() == [57.0, 120.0, 570.0]
    assert built.chain.stiffness == pytest.approx([1e9, 5e8])
    assert built.chain.ground.tolist() == [0.0, 3e8, 0.0]


def test_thrust_bearing_may_stand_at_the_flywheel_and_masses_as_a_list():
    built = axial_chain([1e-9], [100.0], 500.0, 1, 3e8, [1.0, 2.0])
    assert built.nodes == ("section 0", "section 1, flywheel, thrust bearing")
    assert built.chain.inertia.tolist() == [51.0, 552.0]


def test_axial_chain_without_bearing_and_flywheel_is_free():
    built = axial_chain([1e-9], [100.0], 0.0, 0, 0.0)
    assert built.nodes == ("section 0", "section 1")
    modes = built.chain.modes()
    assert modes.rigid == 1
    assert modes.angular_frequencies[1] == pytest.approx(np.sqrt(1e9 * (1 / 50 + 1 / 50)))


def test_torsional_chain_without_additions():
    built = torsional_chain([2e-7, 4e-7], [0.5, 0.6], 10.0)
    assert built.kind == "torsional"
    assert built.nodes == ("cylinder 1", "cylinder 2", "flywheel")
    assert built.chain.inertia.tolist() == [0.5, 0.6, 10.0]
    assert 1.0 / built.chain.stiffness == pytest.approx([3e-7, 2e-7])
    assert not built.chain.ground.any()


def test_torsional_chain_with_free_end_and_driven_machine():
    driven = DrivenMachine(inertia=30.0, coupling_stiffness=1e5)
    built = torsional_chain([2e-7, 4e-7], [0.5, 0.6], 10.0, free_end_inertia=0.1, driven=driven)
    assert built.nodes == ("free end", "cylinder 1", "cylinder 2", "flywheel", "driven machine")
    assert built.chain.inertia.tolist() == [0.1, 0.5, 0.6, 10.0, 30.0]
    assert 1.0 / built.chain.stiffness == pytest.approx([1e-7, 3e-7, 2e-7, 1e-5])


def test_whole_compliance_of_the_shaft_is_kept():
    compliances = [2e-7, 4e-7, 3e-7]
    chain = torsional_chain(compliances, [1.0, 1.0, 1.0], 5.0, free_end_inertia=1.0).chain
    assert np.sum(1.0 / chain.stiffness) == pytest.approx(sum(compliances))


def test_throw_inertia():
    assert throw_inertia(1.5, 4.0, 6.0, 0.1) == pytest.approx(1.5 + 0.04 + 0.03)


def test_half_the_reciprocating_mass_is_the_mean_over_a_revolution():
    # Exact slider-crank velocity per radian; the next term of the mean is lambda^2 / 8.
    radius, ratio, mass = 0.07, 0.3, 2.0
    angle = np.arange(720) * np.pi / 360.0
    swing = np.sqrt(1.0 - (ratio * np.sin(angle)) ** 2)
    velocity = radius * (np.sin(angle) + ratio * np.sin(angle) * np.cos(angle) / swing)
    mean = np.mean(mass * velocity**2)
    assert throw_inertia(1.0, 0.0, mass, radius) - 1.0 == pytest.approx(mean, rel=0.3 * ratio**2)


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
