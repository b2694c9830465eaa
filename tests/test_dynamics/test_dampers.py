"""Dampers: what they add to a chain, and their best sizes against the forced answer of a chain."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import (
    AxialDamper,
    RubberDamper,
    ViscousDamper,
    main_inertia,
    rubber_damper_for,
    rubber_optimum,
    tuned_optimum,
    untuned_optimum,
    viscous_damper_for,
)
from dynamics.chains.editing import with_damper
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import chain_system

# Main inertia 1, spring 1: frequency 1, static deflection 1 per unit torque.
MAIN = Chain([1.0], [], [1.0], names=["main"])
SPEEDS = np.linspace(0.5, 1.4, 3001)


def peak(chain, node=0, speeds=SPEEDS):
    forces = np.zeros((speeds.size, len(chain.names)), dtype=complex)
    forces[:, node] = 1.0
    motion = harmonic_response(chain_system(chain), speeds, forces).motion
    return np.max(np.abs(motion[:, node]))


def test_viscous_damper_on_a_chain():
    chain = with_damper(
        Chain([1.0, 2.0], [5.0], names=["a", "b"]), "a", ViscousDamper(0.3, 4.0, 0.2)
    )
    assert chain.names == ("a", "b", "damper ring")
    assert chain.inertia.tolist() == [1.2, 2.0, 0.3]
    assert chain.damping_matrix().tolist() == [[4.0, 0.0, -4.0], [0.0, 0.0, 0.0], [-4.0, 0.0, 4.0]]
    assert chain.stiffness.tolist() == [5.0]
    modes = chain.modes()
    assert modes.rigid == 2
    assert modes.elastic_frequencies.tolist() == modes.frequencies[2:].tolist()
    assert np.all(modes.elastic_frequencies > 0.0)
    assert modes.strain_names == (*chain.elements, *(f"{name} - ground" for name in chain.names))
    assert len(modes.strain_names) == len(modes.strain_shares)


def test_rubber_damper_on_a_chain():
    damper = RubberDamper(0.3, 7.0, loss_factor=0.2, damping=0.1, hub_inertia=0.5, name="ring")
    chain = damper.attached(Chain([1.0], [], names=["hub"]), 0)
    assert chain.inertia.tolist() == [1.5, 0.3]
    assert chain.loss_matrix()[1].tolist() == close([-1.4, 1.4])
    assert chain.damping.tolist() == [0.1]
    assert damper.angular_frequency == close((7.0 / 0.3) ** 0.5)


def test_axial_damper_holds_to_ground():
    chain = AxialDamper(3.0, stiffness=50.0, mass=2.0).attached(Chain([1.0, 1.0], [9.0]), 1)
    assert chain.inertia.tolist() == [1.0, 3.0]
    assert chain.ground.tolist() == [0.0, 50.0]
    assert chain.ground_damping.tolist() == [0.0, 3.0]


@pytest.mark.parametrize("ratio", [0.05, 0.3])
def test_untuned_optimum(ratio):
    best = untuned_optimum(ratio)
    # The grid of speeds misses the top of the peak by less than 1e-4 of it.
    found = [
        peak(on_main(ViscousDamper(ratio, 2.0 * z * best.damping_ratio * ratio)))
        for z in (0.95, 1.0, 1.05)
    ]
    assert found[1] == close(best.magnifier, rel=1e-4)
    assert found[1] < min(found[0], found[2])


def on_main(damper):
    return damper.attached(MAIN, "main")


@pytest.mark.parametrize("ratio", [0.05, 0.3])
@pytest.mark.parametrize("kind", ["viscous", "rubber"])
def test_tuned_optima_put_both_fixed_points_level_and_the_peak_near_them(ratio, kind):
    best = tuned_optimum(ratio) if kind == "viscous" else rubber_optimum(ratio)

    def damped(factor, tuning=1.0):
        return on_main(
            RubberDamper(
                ratio,
                ratio * (best.tuning * tuning) ** 2,
                loss_factor=factor * best.loss_factor,
                damping=factor * 2.0 * best.damping_ratio * ratio,
            )
        )

    # The fixed points: (1 - (1 + mu) g^2)^2 = mu / (2 + mu), whatever the damping.
    level = np.sqrt(ratio / (2.0 + ratio))
    fixed = np.sqrt(np.array([1.0 - level, 1.0 + level]) / (1.0 + ratio))
    for factor in (0.5, 1.0, 3.0):
        for place in fixed:
            at = peak(damped(factor), speeds=np.array([place]))
            assert at == close(best.magnifier, rel=1e-9)
    # Excess of the peak at the mean of both dampings, as stated where the formulas are derived.
    excess = peak(damped(1.0)) / best.magnifier - 1.0
    assert 0.0 < excess < (0.006 if kind == "viscous" else 0.09)
    assert peak(damped(1.0)) < min(peak(damped(0.7)), peak(damped(1.4)))
    assert peak(damped(1.0)) < min(peak(damped(1.0, 0.95)), peak(damped(1.0, 1.05)))


@pytest.mark.parametrize("ratio", [0.1, 0.3])
def test_damping_of_tuned_optima_is_the_mean_of_both_level_tangents(ratio):
    """With y = g^2, |x|^2 = (A^2 + 4 z^2 y) / (C^2 + 4 z^2 y E^2): level where its numerator less M^2 times
    its denominator has the slope zero; with a loss factor h^2 f^4 in the place of 4 z^2 y."""
    viscous, rubber = tuned_optimum(ratio), rubber_optimum(ratio)
    tuning, level = viscous.tuning**2, viscous.magnifier**2
    step = 1e-6
    dampings, losses = [], []
    for sign in (-1.0, 1.0):
        fixed = (1.0 + sign * np.sqrt(ratio / (2.0 + ratio))) / (1.0 + ratio)
        y = fixed + np.array([-step, step])
        ring, both = tuning - y, 1.0 - (1.0 + ratio) * y
        undamped = ring**2 - level * ((1.0 - y) * ring - ratio * tuning * y) ** 2
        (left,) = np.diff(undamped)
        dampings.append(-left / (4.0 * np.diff(y - level * y * both**2)[0]))
        losses.append(left / (tuning**2 * np.diff(level * both**2)[0]))
    # Differences over 1e-6 leave 1e-8 of the slopes.
    assert np.mean(dampings) == close(viscous.damping_ratio**2, rel=1e-6)
    assert np.mean(losses) == close(rubber.loss_factor**2, rel=1e-6)


def test_a_mode_acts_as_one_inertia():
    # Two equal inertias on a wall: modal inertia and shape by hand.
    chain = Chain([1.0, 1.0], [1.0], {0: 1.0})
    inertia, frequency = main_inertia(chain, 1)
    golden = (1.0 + 5.0**0.5) / 2.0
    assert inertia == close(1.0 + 1.0 / golden**2)
    assert frequency == close(1.0 / golden)


def test_sized_dampers_calm_the_mode_they_are_for():
    chain = Chain([0.05, 0.1, 0.1, 2.0], [1e6, 1e6, 1e6])
    frequency = chain.modes().angular_frequencies[1]
    main, _ = main_inertia(chain, 0)
    speeds = np.linspace(0.5, 1.3, 2001) * frequency
    static = 1.0 / (main * frequency**2)
    for damper, best in (
        (viscous_damper_for(chain, 0, 0.2 * main), untuned_optimum(0.2)),
        (rubber_damper_for(chain, 0, 0.2 * main), tuned_optimum(0.2)),
    ):
        # Rigid motion and other modes add to the one mode: within a quarter of its peak.
        found = peak(damper.attached(chain, 0), speeds=speeds) / static
        assert found == close(best.magnifier, rel=0.25)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: ViscousDamper(0.0, 1.0), "damper.ring_inertia: given 0"),
        (lambda: ViscousDamper(1.0, 0.0), "damper.damping: given 0"),
        (lambda: RubberDamper(1.0, -1.0), "damper.stiffness: given -1"),
        (lambda: RubberDamper(1.0, 1.0, loss_factor=-0.1), "damper.loss_factor: given -0.1"),
        (lambda: AxialDamper(0.0), "axial_damper.damping: given 0"),
        (lambda: tuned_optimum(0.0), "mass_ratio: given 0"),
        (lambda: ViscousDamper(1.0, 1.0).attached(MAIN, "hub"), "given 'hub'; allowed are main"),
        (lambda: ViscousDamper(1.0, 1.0, name="main").attached(MAIN, 0), "name: given 'main'"),
        (lambda: main_inertia(MAIN, 0, 2), "mode: given 2; allowed is 1, because the chain has 1"),
        (lambda: main_inertia(Chain([1.0, 1.0, 1.0], [1.0, 1.0]), 1), "does not move in mode 1"),
    ],
)
def test_unusable_dampers_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
