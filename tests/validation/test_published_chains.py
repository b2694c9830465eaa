"""Torsional chains from the literature.

Source: MWM six-cylinder diesel, Mendes et al. 2008, doi 10.1243/14644193JMBD126, its frequencies calculated
independently; Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (Cambridge), example 9.7.1, two
disks, geared rotors, a long hollow shaft.

Tolerance: half of the last digit given: 1e-3 Hz, the book's 0.01, 0.1 or 1e-4 Hz.
"""

import numpy as np
import pytest

from comparing import close
from crankfem.files.chain.chain_file import load_chain
from dynamics.chains.chain import Chain, Gear
from dynamics.chains.shaft_line import RigidBody, ShaftLine, ShaftMaterial, shaft_cylinder

MWM_INERTIA = [0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750]
MWM_STIFFNESS = np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976]) * 1e6


@pytest.fixture(scope="module")
def mwm():
    return Chain(MWM_INERTIA, MWM_STIFFNESS).modes()


def test_mwm_frequencies(mwm, figure):
    expected = [
        0.0, 216.584, 592.740, 984.923, 1171.017, 1415.995, 1660.044, 1794.388, 2993.474,
    ]  # fmt: skip
    assert mwm.rigid == 1
    figure("MWM: frequencies", mwm.frequencies, expected, 5.1e-4, "Hz", "absolute")


def test_mwm_first_mode(mwm, figure):
    expected = [1.0, 0.9715, 0.9423, 0.8392, 0.6956, 0.5525, 0.3227, 0.0773, -0.0818]
    figure("MWM: first mode shape", mwm.shapes[:, 1], expected, 5.1e-5, "", "absolute")
    (node,) = mwm.node_positions[1]
    assert node == close(7.0 + 0.0773 / (0.0773 + 0.0818), abs=1e-3)
    assert [len(positions) for positions in mwm.node_positions] == list(range(9))


def test_friswell_example_9_7_1(figure):
    chain = Chain([3.5e-3, 3.5e-3, 3.5e-3, 0.15, 0.05], [12e3, 12e3, 14e3, 10e3])
    expected = [0.0, 81.21, 141.21, 378.95, 536.36]
    found = chain.modes().frequencies
    figure("Friswell 9.7.1: frequencies", found, expected, 5.1e-3, "Hz", "absolute")


def test_friswell_two_disks(figure):
    modes = Chain([211.4, 8.3], [9.775e6]).modes()
    figure("two disks: frequencies", modes.frequencies, [0.0, 176.1], 0.051, "Hz", "absolute")


def test_friswell_geared_rotors(figure):
    chain = Chain(
        [400e-6, 25e-6, 25e-6, 700e-6, 700e-6],
        [10000.0, 5000.0, 5000.0],
        connections=[(0, 1), (1, 3), (2, 4)],
        gears=[Gear(1, 2, -1.0)],
    )
    expected = [0.0, 425.4, 634.1, 3247.2]
    found = chain.modes().frequencies
    figure("geared rotors: frequencies", found, expected, 0.051, "Hz", "absolute")


@pytest.mark.parametrize(
    ("elements", "expected"),
    [
        (5, [1.9417, 4.0719, 6.5437, 9.1547]),
        (8, [1.9225, 3.9187, 6.0625, 8.4185]),
        (50, [1.9106, 3.8232, 5.7394, 7.6613]),
    ],
)
def test_friswell_long_shaft(elements, expected, figure):
    # The modulus of elasticity plays no part in torsion.
    material = ShaftMaterial(youngs_modulus=2e11, shear_modulus=75e9, density=8000.0)
    line = ShaftLine(
        [
            RigidBody(200.0, 0.0, "one end"),
            shaft_cylinder(800.0, 0.78, 0.65, material),
            RigidBody(10.0, 0.0, "other end"),
        ]
    )
    modes = line.chain(parts=elements).modes()
    what = f"long shaft of {elements} elements: frequencies"
    figure(what, modes.frequencies[1:5], expected, 5.1e-5, "Hz", "absolute")


def test_shipped_files_hold_these_figures():
    mwm = load_chain("mwm-six").chain
    assert mwm.inertia.tolist() == MWM_INERTIA
    assert mwm.stiffness.tolist() == MWM_STIFFNESS.tolist()
    assert mwm.loss_factor.tolist() == [0.035] * 8
    assert mwm.ground_damping.tolist() == [0.0] * 2 + [2.0] * 6 + [0.0]
    geared = load_chain("geared-example").chain
    assert geared.modes().frequencies == close([0.0, 425.4, 634.1, 3247.2], abs=0.051)
