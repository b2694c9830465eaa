"""Pieces of shaft against quadrature of their cross sections, and shaft lines against hand counts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.shaft_line import (
    Coupling,
    Propeller,
    RigidBody,
    ShaftCone,
    ShaftLine,
    ShaftMaterial,
    shaft_cylinder,
    shaft_flange,
)

G, E, RHO = 8e10, 2e11, 7800.0
MATERIAL = ShaftMaterial(E, G, RHO)


@settings(max_examples=20)
@given(
    st.floats(0.1, 0.5),
    st.floats(0.1, 0.5),
    st.sampled_from([0.0, 1e-4, 0.049, 0.051, 0.5, 0.95]),
    st.sampled_from(["cylindrical", "proportional"]),
)
def test_cones_by_quadrature(left, right, share, shape):
    length, bore = 0.7, share * min(left, right)
    cone = ShaftCone(length, left, right, bore, shape, MATERIAL)

    def powers(z, power):
        outer = left + (right - left) * z / length
        inner = bore if shape == "cylindrical" else bore * outer / left
        return outer**power - inner**power

    def along(function):
        return quad(function, 0.0, length, epsabs=0.0, epsrel=1e-12)[0]

    # The quadrature's own tolerance.
    twist = along(lambda z: 32.0 / (math.pi * G * powers(z, 4)))
    assert cone.torsional_compliance == close(twist, rel=1e-11)
    stretch = along(lambda z: 4.0 / (math.pi * E * powers(z, 2)))
    assert cone.axial_compliance == close(stretch, rel=1e-11)
    assert cone.mass == close(RHO * math.pi / 4.0 * along(lambda z: powers(z, 2)))
    inertia = RHO * math.pi / 32.0 * along(lambda z: powers(z, 4))
    assert cone.polar_inertia == close(inertia)
    parts = cone.divided(3)
    assert sum(part.torsional_compliance for part in parts) == close(twist, rel=1e-10)
    assert sum(part.mass for part in parts) == close(cone.mass)
    moduli = [
        math.pi / 16.0 * powers(z, 4) / (left + (right - left) * z / length) for z in (0, length)
    ]
    assert cone.section_modulus == close(min(moduli))


def test_cylinders_and_flanges():
    tube = shaft_cylinder(2.0, 0.3, 0.1, MATERIAL)
    polar = math.pi / 32.0 * (0.3**4 - 0.1**4)
    assert tube.torsional_compliance == close(2.0 / (G * polar))
    assert tube.axial_compliance == close(2.0 / (E * math.pi / 4.0 * (0.09 - 0.01)))
    assert tube.polar_inertia == close(RHO * polar * 2.0)
    assert tube.section_modulus == close(polar / 0.15)
    disk = shaft_flange(0.05, 0.6, material=MATERIAL)
    assert disk.polar_inertia == close(disk.mass * 0.3**2 / 2.0)


def test_a_shaft_line_as_a_chain():
    line = ShaftLine(
        [
            shaft_flange(0.08, 0.5, material=MATERIAL),
            shaft_cylinder(4.0, 0.3, material=MATERIAL, name="intermediate"),
            Coupling(2e6, 5e8, 3.0, 4.0, 30.0, 40.0, torsional_damping=9.0, loss_factor=0.1),
            ShaftCone(1.0, 0.3, 0.2, material=MATERIAL),
            Propeller(
                100.0, 900.0, entrained_inertia_share=0.25, entrained_mass=500.0, damping=7.0
            ),
        ],
        name="line",
    )
    flange, shaft, _, cone, _ = line.pieces
    chain = line.chain()
    assert chain.names == ("line 0", "line 1", "line 2", "line 3", "propeller")
    assert chain.inertia.tolist() == [0.0, 0.0, 3.0, 4.0, 125.0]
    assert chain.distributed_inertia.tolist() == [
        flange.polar_inertia, shaft.polar_inertia, 0.0, cone.polar_inertia,
    ]  # fmt: skip
    assert 1.0 / chain.stiffness == close(
        [flange.torsional_compliance, shaft.torsional_compliance, 5e-7, cone.torsional_compliance]
    )
    assert chain.loss_factor.tolist() == [0.0, 0.0, 0.1, 0.0]
    assert chain.damping.tolist() == [0.0, 0.0, 9.0, 0.0]
    assert chain.ground_damping.tolist() == [0.0, 0.0, 0.0, 0.0, 7.0]
    assert line.compliance("torsional") == close(np.sum(1.0 / chain.stiffness))
    axial = line.chain("axial", parts=3, inertia="lumped")
    assert len(axial.names) == 1 + 3 + 3 + 1 + 3
    assert not axial.distributed_inertia.any()
    assert axial.inertia.sum() == close(line.mass + 30.0 + 40.0 + 1400.0)
    assert np.sum(1.0 / axial.stiffness) == close(line.compliance("axial"))
    assert axial.modes().rigid == 1
    assert line.section_modulus == close(math.pi / 16.0 * 0.2**3)


def test_bodies_share_a_joint():
    pieces = [RigidBody(1.0, 2.0, "gear"), RigidBody(3.0, 4.0, "brake"), shaft_cylinder(1.0, 0.1)]
    chain = ShaftLine(pieces).chain()
    assert chain.names == ("gear, brake", "shaft 1")
    assert chain.inertia.tolist() == [4.0, 0.0]


def test_propeller_with_water():
    given = Propeller(10.0, 200.0, entrained_inertia=2.0, entrained_mass_share=0.6)
    assert (given.inertia, given.mass) == (12.0, 320.0)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: shaft_cylinder(0.0, 0.1), "shaft.length: given 0 m"),
        (lambda: shaft_cylinder(1.0, -0.1), "shaft.diameter: given -0.1 m"),
        (lambda: shaft_cylinder(1.0, 0.1, 0.1), "shaft.bore: given 0.1 m; .*less than 0.1 m"),
        (lambda: ShaftCone(1.0, 0.2, 0.1, 0.15), "shaft.bore: given 0.15 m; .*less than 0.1 m"),
        (lambda: ShaftCone(1.0, 0.2, 0.1, 0.05, "oval"), "shaft.bore_shape: given 'oval'"),
        (lambda: Coupling(torsional_stiffness=0.0), "coupling.torsional_stiffness: given 0"),
        (lambda: ShaftLine([Coupling(1.0)]).chain("axial"), "coupling.axial_stiffness: given none"),
        (lambda: ShaftLine([Coupling(1.0)]).chain(), r"inertia\[0\]: given 0"),
        (lambda: ShaftLine([]), "pieces: given none"),
        (lambda: ShaftLine([3.0]), r"pieces\[0\]: given 3.0"),
        (lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain("bending"), "kind: given 'bending'"),
        (lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain(parts=0), "parts: given 0"),
        (
            lambda: ShaftLine([shaft_cylinder(1.0, 0.1)]).chain(inertia="thick"),
            "inertia: given 'thick'",
        ),
        (lambda: ShaftLine([RigidBody(1.0, 1.0, "a")]).section_modulus, "pieces: given no piece"),
        (lambda: RigidBody(-1.0, 0.0, "a"), "body.inertia: given -1"),
        (lambda: Propeller(1.0, 1.0, entrained_mass=0.0), "propeller.entrained_inertia: .*neither"),
        (
            lambda: Propeller(1.0, 1.0, 1.0, 1.0, entrained_mass_share=0.6),
            "propeller.entrained_mass: given both",
        ),
        (lambda: ShaftMaterial(density=0.0), "material.density: given 0"),
    ],
)
def test_unusable_pieces_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
