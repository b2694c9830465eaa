"""Distributed loads: forces and moments spread over the surface of a pin or over an end section.

A load and the mean motion of its surface are conjugate: the work of a unit load on a displacement is
the mean motion along it, for translations and rotations. This defines "the motion of the pin"
and the free deformation of an end section with given mean motion.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import MeshTri1
from skfem.quadrature import get_quadrature

from crankbase.errors import InputError
from fem.symmetry import MirrorImage, SymmetryClass, mirror_images
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.mesher import Throw
from geometry.shapes import triangle_shapes_at
from geometry.solid import LEFT_END, RIGHT_END

Array = NDArray[np.float64]
Distribution = Literal["uniform", "cosine"]
DISTRIBUTIONS = ("uniform", "cosine")

# Direction of a radial force on the first pin, towards the shaft.
RADIAL = np.array([0.0, -1.0, 0.0])
# Integrates the shape functions times linear loads on flat facets exactly.
QUADRATURE_ORDER = 5


@dataclass(frozen=True)
class LoadedSurface:
    """A meshed surface, with its mirror images, ready to carry loads.

    Attributes
    ----------
    nodes : (s,) array
        Nodes on its meshed part.
    center : (3,) array
        Centroid of the whole surface [m]; forces act there and moments about it.
    places, areas : (q, 3) array
        Quadrature points of the meshed part [m] and their outward area vectors [m^2].
    shares : (q, s) sparse array
        Shape functions of the nodes there.
    images : tuple of MirrorImage
        The meshed part and its mirror images, which together are the whole surface.
    resultants : (6, 6) array
        Forces and moments of the tractions that move with unit rigid motions of the surface.
    """

    nodes: NDArray[np.int64]
    center: Array
    places: Array
    areas: Array
    shares: sparse.csr_array
    images: tuple[MirrorImage, ...]
    resultants: Array

    def on_image(self, image: MirrorImage) -> tuple[Array, Array]:
        """Positions relative to the center and outward area vectors of an image, (q, 3) each."""
        return image.points(self.places) - self.center, self.areas * image.signs

    def uniform(self, resultants: Array) -> list[Array]:
        """Tractions (q, 3) on each image with given forces and moments.

        A force is uniform; a moment is tractions that grow linearly from the center.
        """
        share = np.linalg.solve(self.resultants, resultants)
        return [rigid_motions(self.on_image(image)[0]) @ share for image in self.images]

    def nodal(self, tractions: list[Array]) -> Array:
        """Nodal loads (images, s, 3) of tractions (q, 3) on each image."""
        sizes = np.linalg.norm(self.areas, axis=1)
        return np.array([self.shares.T @ (sizes[:, None] * traction) for traction in tractions])


@dataclass(frozen=True)
class NodalLoads:
    """Loads on the nodes of a surface and of its mirror images.

    Attributes
    ----------
    nodes : (s,) array
    values : (images, s, 3, c) array
        For c load cases, on the nodes of each image along the axes of the throw.
    """

    nodes: NDArray[np.int64]
    images: tuple[MirrorImage, ...]
    values: Array

    def of_class(self, symmetry: SymmetryClass) -> Array:
        """Loads (s, 3, c) whose work on the meshed part's field is that of all on the whole throw."""
        return np.asarray(
            sum(
                symmetry.parity(image) * image.signs[:, None] * load
                for image, load in zip(self.images, self.values, strict=True)
            )
        )


def pin_surfaces(mesh: ThrowMesh) -> tuple[LoadedSurface, ...]:
    """Return the pins of a meshed throw, ready to carry loads."""
    return tuple(_surface(mesh, mesh.surfaces[pin], mirror_images(mesh)) for pin in mesh.pins)


def unit_pin_loads(mesh: ThrowMesh) -> tuple[NodalLoads, ...]:
    """Unit forces along x, y, z and unit moments about them on each pin, spread over its surface.

    Returns
    -------
    tuple of NodalLoads
        One for each pin, with six load cases.
    """
    return tuple(_unit_loads(surface) for surface in pin_surfaces(mesh))


def unit_end_loads(mesh: ThrowMesh, end: str) -> NodalLoads:
    """Unit forces and moments on an end section, spread over it.

    Their work is the mean motion of the section. Of a quarter the left end only is meshed, and its
    images are those across the crank plane.
    """
    center = np.array([0.0, 0.0, 0.0 if end == LEFT_END else mesh.length])
    return _unit_loads(_with_center(end_surface(mesh, end), center))


def end_surface(mesh: ThrowMesh, end: str) -> LoadedSurface:
    """Return a meshed end section; its images are those across the crank plane."""
    images = tuple(image for image in mirror_images(mesh) if not image.across_middle)
    return _surface(mesh, mesh.surfaces[end], images)


def end_sections(symmetry: SymmetryClass) -> tuple[str, ...]:
    """Names of the end sections that are meshed."""
    return (LEFT_END,) if symmetry.middle_plane else (LEFT_END, RIGHT_END)


def pin_load(
    surface: LoadedSurface, force: Array, moment: Array, distribution: Distribution
) -> NodalLoads:
    """One load case on a pin.

    Parameters
    ----------
    force, moment : (3,) array
        In the throw frame, about the pin's center [N, N m].
    distribution : {"uniform", "cosine"}
        ``uniform``: uniform traction (moments: growing linearly from the center). ``cosine``: a
        force across the pin as a pressure p cos(theta) on the half that it presses on; a moment
        across it as such pressures that grow with the distance from the middle, on opposite halves of
        the pin's two ends. Loads that a pressure cannot carry (force along the pin, torque about it) are
        uniform in either case.

    Raises
    ------
    InputError
        If the distribution is neither.
    """
    if distribution not in DISTRIBUTIONS:
        raise InputError(
            f'distribution: given {distribution!r}; allowed are "uniform" and "cosine".'
        )
    wanted = np.concatenate([force, moment])
    if distribution == "uniform":
        tractions = surface.uniform(wanted)
    else:
        across = np.array([force[0], force[1], 0.0])
        # A force couple z x (moment x z) turns about the moment's own direction.
        couple = np.array([moment[1], -moment[0], 0.0])
        pressures = [
            pressure + other
            for pressure, other in zip(
                _pressure_patterns(surface, across, couple=False),
                _pressure_patterns(surface, couple, couple=True),
                strict=True,
            )
        ]
        rest = surface.uniform(wanted - _resultants(surface, pressures))
        tractions = [pressure + other for pressure, other in zip(pressures, rest, strict=True)]
    return NodalLoads(surface.nodes, surface.images, surface.nodal(tractions)[..., None])


def uniform_pin_loads(mesh: ThrowMesh) -> NDArray[np.float64]:
    """Share of each node in a unit force spread uniformly over the meshed surface of each pin.

    Returns
    -------
    (pins, n) array
        Integrals of the shape functions over the pin's surface, divided by its area; each pin's sum
        to 1.
    """
    shares = np.zeros((len(mesh.pins), len(mesh.points)))
    for pin, surface in enumerate(pin_surfaces(mesh)):
        sizes = np.linalg.norm(surface.areas, axis=1)
        shares[pin, surface.nodes] = sizes @ surface.shares / sizes.sum()
    return shares


def radial_directions(throw: Throw) -> NDArray[np.float64]:
    """Directions (pins, 3) from each pin's axis to the shaft."""
    axes = np.array([(*axis, 0.0) for axis in throw.pin_axes])
    return np.asarray(-axes / np.linalg.norm(axes, axis=1)[:, None])


def rigid_motions(arms: Array) -> Array:
    """Displacements (q, 3, 6) of places (q, 3) from a center for unit translations and rotations."""
    motions = np.zeros((len(arms), 3, 6))
    motions[:, 0, 0] = motions[:, 1, 1] = motions[:, 2, 2] = 1.0
    x, y, z = arms.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions


def _pressure_patterns(surface: LoadedSurface, direction: Array, *, couple: bool) -> list[Array]:
    """Pressures (q, 3) on each image with the resultant force, or couple, of that direction."""
    size = float(np.linalg.norm(direction))
    if size == 0.0:
        return [np.zeros_like(surface.places) for _ in surface.images]
    unit = direction / size
    pressures = []
    total = 0.0
    for image in surface.images:
        arms, areas = surface.on_image(image)
        sizes = np.linalg.norm(areas, axis=1)
        normals = areas / sizes[:, None]
        weight = arms[:, 2] if couple else np.ones(len(arms))
        facing = normals @ unit
        pressed = np.where(facing * np.sign(weight) < 0.0, np.abs(facing * weight), 0.0)
        pressures.append(-pressed[:, None] * normals)
        total += float(np.sum(sizes * weight * (pressures[-1] @ unit)))
    return [pressure * (size / total) for pressure in pressures]


def _resultants(surface: LoadedSurface, tractions: list[Array]) -> Array:
    """Force and moment (6,) of tractions on all images."""
    total = np.zeros(6)
    for image, traction in zip(surface.images, tractions, strict=True):
        arms, areas = surface.on_image(image)
        sizes = np.linalg.norm(areas, axis=1)
        total += np.einsum("q,qaj,qa->j", sizes, rigid_motions(arms), traction)
    return total


def _unit_loads(surface: LoadedSurface) -> NodalLoads:
    cases = [surface.nodal(surface.uniform(case)) for case in np.eye(6)]
    return NodalLoads(surface.nodes, surface.images, np.stack(cases, axis=-1))


def _surface(
    mesh: ThrowMesh, corners: NDArray[np.int64], images: tuple[MirrorImage, ...]
) -> LoadedSurface:
    triangles = six_node_triangles(mesh, corners)
    where, weights = get_quadrature(MeshTri1.elem.refdom, QUADRATURE_ORDER)
    values, slopes = triangle_shapes_at(where)
    tangents = np.einsum("aiq,taj->tqij", slopes, mesh.points[triangles])
    areas = np.cross(tangents[:, :, 0], tangents[:, :, 1]) * weights[:, None]
    nodes, number = np.unique(triangles, return_inverse=True)
    number = number.reshape(triangles.shape)
    count = len(weights)
    size = len(triangles) * count
    rows = np.repeat(np.arange(size), 6)
    columns = np.repeat(number, count, axis=0).ravel()
    shares = sparse.csr_array(
        (np.tile(values, (len(triangles), 1)).ravel(), (rows, columns)), (size, len(nodes))
    )
    surface = LoadedSurface(
        nodes=nodes,
        center=np.zeros(3),
        places=np.asarray(shares @ mesh.points[nodes]),
        areas=areas.reshape(-1, 3),
        shares=shares,
        images=images,
        resultants=np.eye(6),
    )
    sizes = np.linalg.norm(surface.areas, axis=1)
    middle = np.mean([sizes @ image.points(surface.places) for image in images], axis=0)
    return _with_center(surface, middle / sizes.sum())


def _with_center(surface: LoadedSurface, center: Array) -> LoadedSurface:
    """Return the surface with another center."""
    resultants = np.zeros((6, 6))
    sizes = np.linalg.norm(surface.areas, axis=1)
    for image in surface.images:
        motions = rigid_motions(image.points(surface.places) - center)
        resultants += np.einsum("q,qai,qaj->ij", sizes, motions, motions)
    return replace(surface, center=center, resultants=resultants)
