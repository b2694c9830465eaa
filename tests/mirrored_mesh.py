"""Meshes put together from a part and its mirror image."""

from dataclasses import replace

import numpy as np

from fem.superelement import nodes_on
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

# A mirror image of a tetrahedron is inside out until two of its corners change places.
SWAPPED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]


def add_mirror_image(mesh):
    """Make a half of a quarter, or a full mesh of a half, sharing the nodes on the cut."""
    cut, part = {"quarter": (MIDDLE_PLANE, "half"), "half": (CRANK_PLANE, "full")}[mesh.part]
    axis, place = (2, 0.5 * mesh.length) if cut == MIDDLE_PLANE else (0, 0.0)
    others = np.setdiff1d(np.arange(len(mesh.points)), nodes_on(mesh, cut))
    number = np.arange(len(mesh.points))
    number[others] = len(mesh.points) + np.arange(len(others))
    image = mesh.points[others].copy()
    image[:, axis] = 2.0 * place - image[:, axis]
    surfaces = {}
    for name, facets in mesh.surfaces.items():
        other_side = number[facets][:, ::-1]
        if name == cut:
            continue
        if name == LEFT_END and cut == MIDDLE_PLANE:
            surfaces |= {LEFT_END: facets, RIGHT_END: other_side}
        else:
            surfaces[name] = np.vstack([facets, other_side])
    return replace(
        mesh,
        part=part,
        points=np.vstack([mesh.points, image]),
        elements=np.vstack([mesh.elements, number[mesh.elements][:, SWAPPED]]),
        surfaces=surfaces,
    )
