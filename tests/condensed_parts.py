"""What only tests ask of condensed and meshed parts of a throw."""

from dataclasses import replace

import numpy as np

from fem.supports import TWIST, unit_response
from geometry.mass import solid_mass_properties
from geometry.mesh import SolidProperties
from geometry.shapes import element_quadrature


def torsional_compliance(part, support):
    """Return the torsional compliance [rad/(N m)] from the last class of a meshed part."""
    torque = TWIST @ part.symmetry.ends
    return unit_response(part, support, torque) @ torque


def of_modes(throw, count):
    """Return Craig's and Bampton's superelement of the lowest natural modes; of none, Guyan's."""
    assert count <= throw.natural
    kept = slice(0, 2 * throw.sections.count + count)
    return replace(
        throw,
        stiffness=throw.stiffness[kept, kept],
        mass=throw.mass[kept, kept],
        pin_loads=throw.pin_loads[:, kept],
        frequencies=throw.frequencies[:count],
        natural=count,
        symmetries=throw.symmetries[:count],
        shapes=throw.shapes[:, :, :count],
    )


def mass_of_elements(mesh, density):
    """Return the mass properties of a throw integrated over the elements of its mesh."""
    where, volumes = element_quadrature(mesh.points, mesh.elements)
    center = volumes @ where / volumes.sum()
    second = np.einsum("p,pi,pj->ij", volumes, where - center, where - center)
    solid = SolidProperties(float(volumes.sum()), center, second)
    return solid_mass_properties(solid, mesh.part, mesh.length, density)
