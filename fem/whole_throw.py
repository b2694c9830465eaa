"""The whole throw put together from its meshed part and the mirror images of that."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.array_checks import Array, Integers
from fem.superelement import nodes_on
from fem.symmetry import CUTS, MirrorImage, mirror_images
from geometry.mesh import ThrowMesh
from geometry.mesh_exchange import surface_triangles
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

# Nodes of a six-node triangle seen from its other side, and of a tetrahedron whose mirror image would be
# inside out.
TURNED = [0, 2, 1, 5, 4, 3]
SWAPPED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]


@dataclass(frozen=True)
class WholeNodes:
    """Numbers of nodes of a whole throw, those on the cuts shared by the images.

    Attributes
    ----------
    numbers : (images, n) array
        Number of each node of the mesh in each image.
    """

    images: tuple[MirrorImage, ...]
    numbers: Integers

    def collect(self, values: Sequence[Array]) -> Array:
        """Values of the whole throw's nodes (w, ...) from those of each image (n, ...)."""
        count = int(self.numbers.max()) + 1
        whole = np.empty((count, *values[0].shape[1:]))
        for number, value in zip(self.numbers, values, strict=True):
            whole[number] = value
        return whole


def whole_nodes(mesh: ThrowMesh) -> WholeNodes:
    """Number the nodes of a whole throw."""
    images = mirror_images(mesh)
    places = {(image.across_crank, image.across_middle): k for k, image in enumerate(images)}
    count = len(mesh.points)
    numbers = np.arange(len(images) * count).reshape(len(images), count)
    cut_crank, cut_middle = CUTS[mesh.part]
    for (across_crank, across_middle), place in places.items():
        if cut_crank and across_crank:
            shared = nodes_on(mesh, CRANK_PLANE)
            numbers[place, shared] = numbers[places[False, across_middle], shared]
        if cut_middle and across_middle:
            shared = nodes_on(mesh, MIDDLE_PLANE)
            numbers[place, shared] = numbers[places[across_crank, False], shared]
    _, packed = np.unique(numbers, return_inverse=True)
    return WholeNodes(images, packed.reshape(numbers.shape))


def whole_points(mesh: ThrowMesh, nodes: WholeNodes) -> Array:
    """Return the nodes (w, 3) of a whole throw [m]."""
    return nodes.collect([image.points(mesh.points) for image in nodes.images])


def whole_facets(nodes: WholeNodes, facets: Integers) -> Integers:
    """Facets (images t, 6) of a whole throw from those (t, 6) of the meshed part, outside kept."""
    return _in_images(nodes, facets, TURNED)


def whole_elements(nodes: WholeNodes, elements: Integers) -> Integers:
    """Tetrahedra (images m, 10) of a whole throw from those (m, 10) of the meshed part."""
    return _in_images(nodes, elements, SWAPPED)


def whole_surfaces(mesh: ThrowMesh, nodes: WholeNodes) -> dict[str, Integers]:
    """Return the facets (t, 6) of a whole throw's named surfaces, which have no cuts."""
    surfaces = {}
    for name, facets in surface_triangles(mesh).items():
        if name == LEFT_END and mesh.part == "quarter":
            across = np.array([image.across_middle for image in nodes.images])
            by_image = whole_facets(nodes, facets).reshape(len(across), -1, 6)
            surfaces[LEFT_END], surfaces[RIGHT_END] = (
                by_image[chosen].reshape(-1, 6) for chosen in (~across, across)
            )
        elif name not in (CRANK_PLANE, MIDDLE_PLANE):
            surfaces[name] = whole_facets(nodes, facets)
    return surfaces


def _in_images(nodes: WholeNodes, of_part: Integers, mirrored: list[int]) -> Integers:
    return np.concatenate(
        [
            number[of_part[:, mirrored] if image.inside_out else of_part]
            for image, number in zip(nodes.images, nodes.numbers, strict=True)
        ]
    )
