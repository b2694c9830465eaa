"""Straight round shafts, meshed like throws."""

import numpy as np

from fem.symmetry import NodalLoads, mirror_images
from geometry.gmsh_session import gmsh_session
from geometry.mesh import SolidProperties, ThrowMesh, read_mesh
from geometry.solid import LEFT_END

DIAMETER = 0.1


def shaft_quarter(length, bore=0.0, size=0.2):
    """The quarter x >= 0, z <= length / 2 of a shaft, meshed like a throw's, elements of `size` diameters."""
    with gmsh_session("shaft") as gmsh:
        occ = gmsh.model.occ

        def half_round(diameter):
            tag = occ.addCylinder(0, 0, 0, 0, 0, length / 2.0, diameter / 2.0, angle=np.pi)
            occ.rotate([(3, tag)], 0, 0, 0, 0, 0, 1, -np.pi / 2.0)
            return [(3, tag)]

        shaft = half_round(DIAMETER)
        if bore:
            occ.cut(shaft, half_round(bore))
        occ.synchronize()
        near = 1e-3 * DIAMETER
        at_end = gmsh.model.getEntitiesInBoundingBox(-1, -1, -near, 1, 1, near, 2)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size * DIAMETER)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        points, elements, surfaces = read_mesh(gmsh, {LEFT_END: [tag for _, tag in at_end]})
    solid = SolidProperties(
        np.pi / 16.0 * (DIAMETER**2 - bore**2) * length, np.zeros(3), np.zeros((3, 3))
    )
    return ThrowMesh("quarter", length, ("pin",), points, elements, surfaces, 1.0, 0, solid)


def no_pin(mesh):
    """Return six load cases without a load."""
    images = mirror_images(mesh)
    return NodalLoads(np.empty(0, dtype=int), images, np.zeros((len(images), 0, 3, 6)))
