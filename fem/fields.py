"""Displacement fields of a throw whose end sections are moved, under no other load."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.symmetry import CUTS, MIRROR_X, MIRROR_Z
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Image:
    """The meshed part of a throw, or a mirror image of it, with its displacements.

    Attributes
    ----------
    points : (n, 3) array
        Nodes in the order of the mesh [m].
    displacement : (n, 3) array
        [m]
    inside_out : bool
        Whether a single mirror has turned elements and facets inside out.
    """

    points: Array
    displacement: Array
    inside_out: bool


def displacement_field(classes: Sequence[CondensedClass], motions: Array) -> Array:
    """Displacement of the nodes of a throw's meshed part for given motions of the end sections.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the part.
    motions : (12,) or (12, k) array
        Motions of the left, then the right end section, in the throw frame, such as those that
        `fem.supports.end_motions` finds under an axial force or a torque. Under a pin force the field
        of its end motions is not all: the force also bends the throw between its ends.

    Returns
    -------
    (n, 3) or (n, 3, k) array
        [m]
    """
    return np.asarray(sum(part.fields @ (part.symmetry.shares @ motions) for part in classes))


def images(mesh: ThrowMesh, classes: Sequence[CondensedClass], motions: Array) -> tuple[Image, ...]:
    """Displacement of a whole throw: of its meshed part and of the mirror images of that.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    classes : sequence of CondensedClass
        All its symmetry classes.
    motions : (12,) array
        Motions of both end sections.

    Returns
    -------
    tuple of Image
        Four of a quarter, two of a half, one of a whole throw; first the meshed part itself. Nodes on
        the cuts are in each image that they belong to.
    """
    choices = [(False, True) if cut else (False,) for cut in CUTS[mesh.part]]
    found = []
    for mirror_x, mirror_z in product(*choices):
        signs, shift, left, right = np.ones(6), np.zeros(3), motions[:6], motions[6:]
        if mirror_x:
            signs = signs * MIRROR_X
        if mirror_z:
            signs, shift[2], left, right = signs * MIRROR_Z, mesh.length, right, left
        # What the image does is the mirror image of what the part would do for mirrored end motions.
        field = displacement_field(classes, np.concatenate([signs * left, signs * right]))
        points = mesh.points * signs[:3] + shift
        found.append(Image(points, field * signs[:3], mirror_x != mirror_z))
    return tuple(found)
