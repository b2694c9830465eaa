"""Natural vibration of chains.

Source: free chain of N equal masses, f_j = (1/pi) sqrt(k/m) sin(j pi / (2N)), and the uniform free rod,
j/(2L) sqrt(E/rho) (S. S. Rao, Mechanical Vibrations).

Tolerance: round-off; elements of a rod are off by t^2 / 24, t = j pi / N, which is tested.

Shapes of the chain: cos(j pi (i + 1/2) / N). A rod of N elements with half masses at their ends has w_j = 2
sqrt(k/m) sin(j pi / (2N)), with consistent mass w_j^2 = 6 (k/m) (1 - cos t) / (2 + cos t): round-off. They
are too low and too high against the rod.
"""

import numpy as np
import pytest

from comparing import close
from dynamics.chains.chain import Chain
from dynamics.chains.shaft_line import ShaftLine, ShaftMaterial, shaft_cylinder


@pytest.mark.parametrize("count", [2, 3, 7, 40])
def test_free_chain_of_equal_masses(count, figure):
    mass, stiffness = 3.7, 2.9e6
    modes = Chain(np.full(count, mass), np.full(count - 1, stiffness)).modes()
    j = np.arange(count)
    expected = np.sqrt(stiffness / mass) / np.pi * np.sin(j * np.pi / (2 * count))
    assert modes.frequencies[0] == close(0.0, abs=1e-12)
    figure("equal masses, free: frequencies", modes.frequencies[1:], expected[1:], 1e-12, "Hz")
    shapes = np.cos(np.outer(np.arange(count) + 0.5, j) * np.pi / count)
    shapes /= np.max(np.abs(shapes), axis=0)
    # Round-off in a shape grows with the nearness of the next frequency.
    own, wanted = np.abs(modes.shapes), np.abs(shapes)
    figure("equal masses, free: mode shapes", own, wanted, 1e-11, "", "absolute")
    assert [len(positions) for positions in modes.node_positions] == j.tolist()


@pytest.mark.parametrize("count", [2, 5, 20])
def test_chain_of_equal_masses_on_a_wall(count, figure):
    """Held at one end: w_j = 2 sqrt(k/m) sin((2j - 1) pi / (2 (2N + 1)))."""
    mass, stiffness = 0.8, 5e4
    chain = Chain(np.full(count, mass), np.full(count - 1, stiffness), {0: stiffness})
    angle = (2 * np.arange(1, count + 1) - 1) * np.pi / (2 * (2 * count + 1))
    expected = 2.0 * np.sqrt(stiffness / mass) * np.sin(angle)
    found = chain.modes().angular_frequencies
    figure("equal masses on a wall: frequencies", found, expected, 1e-12, "rad/s")


LENGTH, DIAMETER, E, G, DENSITY = 4.0, 0.2, 2.06e11, 8e10, 7850.0


def rod_chain(kind, elements, inertia):
    line = ShaftLine([shaft_cylinder(LENGTH, DIAMETER, 0.0, ShaftMaterial(E, G, DENSITY))])
    return line.chain(kind, parts=elements, inertia=inertia)


@pytest.mark.parametrize(("kind", "modulus"), [("axial", E), ("torsional", G)])
def test_uniform_free_rod_is_bracketed_at_second_order(kind, modulus, figure):
    j = np.arange(1, 3)
    rod = j / (2.0 * LENGTH) * np.sqrt(modulus / DENSITY)
    errors = []
    for elements in (10, 20, 40):
        speed = np.sqrt(modulus / DENSITY) * elements / LENGTH  # sqrt(k / m) of one element
        t = j * np.pi / elements
        lumped = rod_chain(kind, elements, "lumped").modes().frequencies[1:3]
        consistent = rod_chain(kind, elements, "consistent").modes().frequencies[1:3]
        expected = 2.0 * speed * np.sin(t / 2.0) / (2.0 * np.pi)
        figure("rod of lumped elements: frequencies", lumped, expected, 1e-11, "Hz")
        expected = speed * np.sqrt(6.0 * (1.0 - np.cos(t)) / (2.0 + np.cos(t))) / (2.0 * np.pi)
        figure("rod of consistent elements: frequencies", consistent, expected, 1e-11, "Hz")
        assert np.all(lumped < rod)
        assert np.all(rod < consistent)
        # The next terms are below t^4 / 1900 and t is at most 0.63: 0.5 % of the error.
        assert 1.0 - lumped / rod == close(t**2 / 24.0, rel=0.006)
        assert consistent / rod - 1.0 == close(t**2 / 24.0, rel=0.006)
        errors.append((1.0 - lumped / rod, consistent / rod - 1.0))
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    # Half the element length leaves a quarter of the error; the terms in t^4 change that by 1 %.
    figure("order of convergence to the uniform rod", orders, 2.0, 0.02, "", "absolute")
