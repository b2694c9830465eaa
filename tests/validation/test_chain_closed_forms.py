"""Chains against closed forms of vibration theory.

Sources: the free chain of N equal masses m and springs k, f_j = (1/pi) sqrt(k/m) sin(j pi / (2N))
with shapes cos(j pi (i + 1/2) / N), and the uniform free rod, f_j = j/(2L) sqrt(E/rho): textbook
results, such as in S. S. Rao, Mechanical Vibrations (chapters on multi-degree-of-freedom and
continuous systems); the chain's follows from the difference equation by inserting the shape.

Tolerances: round-off for the chain, as the closed form is that of the same equations. A rod of N
elements is a chain with half masses at its ends, whose frequencies fall short of the rod's by
(j pi / (2N))^2 / 6 of their value; the test checks that error, not only its size.
"""

import numpy as np
import pytest

from dynamics.chains.chain import Chain


@pytest.mark.parametrize("count", [2, 3, 7, 40])
def test_free_chain_of_equal_masses(count):
    mass, stiffness = 3.7, 2.9e6
    modes = Chain(np.full(count, mass), np.full(count - 1, stiffness)).modes()
    j = np.arange(count)
    expected = np.sqrt(stiffness / mass) / np.pi * np.sin(j * np.pi / (2 * count))
    assert modes.frequencies == pytest.approx(expected, rel=1e-12)
    shapes = np.cos(np.outer(np.arange(count) + 0.5, j) * np.pi / count)
    shapes /= np.max(np.abs(shapes), axis=0)
    # Round-off in a shape grows with the nearness of the next frequency.
    assert np.abs(modes.shapes) == pytest.approx(np.abs(shapes), abs=1e-11)
    assert [len(positions) for positions in modes.node_positions] == j.tolist()


@pytest.mark.parametrize("count", [2, 5, 20])
def test_chain_of_equal_masses_on_a_wall(count):
    """Held at one end: w_j = 2 sqrt(k/m) sin((2j - 1) pi / (2 (2N + 1)))."""
    mass, stiffness = 0.8, 5e4
    chain = Chain(np.full(count, mass), np.full(count - 1, stiffness), {0: stiffness})
    j = np.arange(1, count + 1)
    angle = (2 * j - 1) * np.pi / (2 * (2 * count + 1))
    expected = 2.0 * np.sqrt(stiffness / mass) * np.sin(angle)
    assert chain.modes().angular_frequencies == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("elements", [40, 80, 160])
def test_uniform_free_rod_is_reached_from_below(elements):
    length, area, modulus, density = 4.0, 0.03, 2.06e11, 7850.0
    step = length / elements
    masses = np.full(elements + 1, density * area * step)
    masses[[0, -1]] /= 2.0
    modes = Chain(masses, np.full(elements, modulus * area / step)).modes()
    j = np.arange(1, 5)
    rod = j / (2.0 * length) * np.sqrt(modulus / density)
    shortfall = 1.0 - modes.frequencies[1:5] / rod
    assert shortfall == pytest.approx((j * np.pi / (2 * elements)) ** 2 / 6.0, rel=0.01)
