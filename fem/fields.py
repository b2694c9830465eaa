"""Displacement fields of a throw whose end sections are moved and whose pins may be loaded."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.condensation import CondensedClass
from fem.symmetry import mirror_images
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
        Whether a single mirror has inverted elements and facets.
    """

    points: Array
    displacement: Array
    inside_out: bool


def displacement_field(
    classes: Sequence[CondensedClass], motions: Array, pin_loads: Array | None = None
) -> Array:
    """Displacement of the nodes of a throw's meshed part.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the part.
    motions : (m,) or (m, k) array
        Motions of the left, then the right end section, in the throw frame, such as those that
        `fem.supports.end_motions` finds: 12 of rigid sections, or all of the classes. Under a load
        on a pin these are not the whole motion: the load also bends the throw between its ends.
    pin_loads : (pins, 6) or (pins, 6, k) array, optional
        Forces along x, y, z and moments about them on each pin, uniformly spread, if any.

    Returns
    -------
    (n, 3) or (n, 3, k) array
        [m]
    """
    given = len(motions)
    field = np.asarray(sum(part.fields @ (part.shares[:, :given] @ motions) for part in classes))
    if pin_loads is not None:
        for part in classes:
            pins, components = part.pin_components.T
            field = field + part.pin_fields @ pin_loads[pins, components]
    return field


def images(
    mesh: ThrowMesh,
    classes: Sequence[CondensedClass],
    motions: Array,
    pin_loads: Array | None = None,
) -> tuple[Image, ...]:
    """Displacement of a whole throw: of its meshed part and of the mirror images of that.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    classes : sequence of CondensedClass
        All its symmetry classes.
    motions : (12,) array
        Motions of both end sections.
    pin_loads : (pins, 6) array, optional
        Forces along x, y, z and moments about them on each pin, if any.

    Returns
    -------
    tuple of Image
        Four of a quarter, two of a half, one of a whole throw; first the meshed part itself. Nodes on
        the cuts are in each image that they belong to.
    """
    found = []
    for image in mirror_images(mesh):
        # What the image does is the mirror image of what the part would do for mirrored motions and
        # loads. Pins lie on the cuts.
        ends = (motions[:6], motions[6:])
        left, right = ends[::-1] if image.across_middle else ends
        mirrored = np.concatenate([image.motion_signs * left, image.motion_signs * right])
        loads = None if pin_loads is None else pin_loads * image.motion_signs
        field = displacement_field(classes, mirrored, loads)
        found.append(Image(image.points(mesh.points), field * image.signs, image.inside_out))
    return tuple(found)
