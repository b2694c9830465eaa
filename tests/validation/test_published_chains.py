"""Torsional chains from the literature.

Sources and tolerances:

- MWM six-cylinder diesel without damper: inertias and stiffnesses from A. S. Mendes,
  P. S. Meirelles, D. E. Zampieri, Proc. IMechE Part K, J. Multi-body Dynamics 2008,
  doi 10.1243/14644193JMBD126. The frequencies and the first mode shape were calculated from this
  input independently of this project and rounded to 1e-3 Hz and 1e-4; half of that is allowed.
- M. I. Friswell, J. E. T. Penny, S. D. Garvey, A. W. Lees, Dynamics of Rotating Machines
  (Cambridge University Press): example 9.7.1, and a shaft with two disks. Given to 0.01 and
  0.1 Hz; half of that is allowed.
- The same book's long hollow shaft with an inertia at either end. Its figures with 50 elements of
  consistent inertia lie above the exact ones by about (b h)^2 / 24, b h being the wave number times
  the element length, at most 0.26 % in mode 4; a chain of 400 lumped inertias lies below by less
  than 0.01 %. The figures are compared after removing the former, to 0.1 %.
"""

import numpy as np
import pytest

from dynamics.chains.chain import Chain

MWM_INERTIA = [0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750]
MWM_STIFFNESS = np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976]) * 1e6


@pytest.fixture(scope="module")
def mwm():
    return Chain(MWM_INERTIA, MWM_STIFFNESS).modes()


def test_mwm_frequencies(mwm):
    expected = [
        0.0, 216.584, 592.740, 984.923, 1171.017, 1415.995, 1660.044, 1794.388, 2993.474,
    ]  # fmt: skip
    assert mwm.rigid == 1
    assert mwm.frequencies == pytest.approx(expected, abs=5.1e-4)


def test_mwm_first_mode(mwm):
    expected = [1.0, 0.9715, 0.9423, 0.8392, 0.6956, 0.5525, 0.3227, 0.0773, -0.0818]
    assert mwm.shapes[:, 1] == pytest.approx(expected, abs=5.1e-5)
    (node,) = mwm.node_positions[1]
    assert node == pytest.approx(7.0 + 0.0773 / (0.0773 + 0.0818), abs=1e-3)
    assert [len(positions) for positions in mwm.node_positions] == list(range(9))


def test_friswell_example_9_7_1():
    chain = Chain([3.5e-3, 3.5e-3, 3.5e-3, 0.15, 0.05], [12e3, 12e3, 14e3, 10e3])
    expected = [0.0, 81.21, 141.21, 378.95, 536.36]
    assert chain.modes().frequencies == pytest.approx(expected, abs=5.1e-3)


def test_friswell_two_disks():
    modes = Chain([211.4, 8.3], [9.775e6]).modes()
    assert modes.frequencies == pytest.approx([0.0, 176.1], abs=0.051)


def test_friswell_long_shaft():
    length, outer, inner, shear_modulus, density = 800.0, 0.78, 0.65, 75e9, 8000.0
    elements = 400
    step = length / elements
    polar = np.pi * (outer**4 - inner**4) / 32.0
    inertia = np.full(elements + 1, density * polar * step)
    inertia[[0, -1]] /= 2.0
    inertia[[0, -1]] += [200.0, 10.0]
    modes = Chain(inertia, np.full(elements, shear_modulus * polar / step)).modes()
    published = np.array([1.9106, 3.8232, 5.7394, 7.6613])
    wave_number = 2.0 * np.pi * published / np.sqrt(shear_modulus / density)
    excess = (wave_number * length / 50) ** 2 / 24.0
    assert modes.frequencies[1:5] == pytest.approx(published / (1.0 + excess), rel=1e-3)
    # Each position is the nearer to the truth, so that the chain lies below the published figures.
    assert np.all(modes.frequencies[1:5] < published)
