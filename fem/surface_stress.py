"""Stresses on free surfaces from their strains.

No force acts on a free surface, so its stress follows from the strain of the surface itself, which
is known better than any strain inside the elements: it follows from the displacements of the nodes without
a derivative into the depth, where stresses at a fillet fall off steeply. Strains of the facets are
evaluated at their quadrature points, where they are most accurate, and recovered at the corners by a
quadratic polynomial fitted to the adjacent facets, as in the superconvergent patch recovery (O. C.
Zienkiewicz and J. Z. Zhu, Int. J. Numer. Meth. Engng 33, 1331-1382, 1992). On a curved surface strains
of neighboring points are in different planes: they are rotated into the corner's tangent plane by the
smallest rotation that aligns the normals.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree
from skfem import MeshTri1
from skfem.quadrature import get_quadrature

from fem.material import Material
from geometry.mesh import ThrowMesh
from geometry.parts import Cylinder, ThrowParts, WebPlate
from geometry.shapes import triangle_shapes_at
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners

Array = NDArray[np.float64]

# Places of xx, yy, zz, xy, yz, zx in the symmetric matrix.
MATRIX = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
ROWS, COLUMNS = np.array([0, 1, 2, 0, 1, 2]), np.array([0, 1, 2, 1, 2, 0])


def as_matrices(stress: Array) -> Array:
    """Matrices (..., 3, 3) of stresses (..., 6) given as xx, yy, zz, xy, yz, zx."""
    return np.asarray(stress[..., MATRIX])


def as_components(matrices: Array) -> Array:
    """Components xx, yy, zz, xy, yz, zx (..., 6) of symmetric matrices (..., 3, 3)."""
    return np.asarray(matrices[..., ROWS, COLUMNS])


def principal_stresses(stress: Array) -> Array:
    """Principal stresses (..., 3), largest first, of stresses (..., 6) in the same unit."""
    return np.asarray(np.linalg.eigvalsh(as_matrices(stress))[..., ::-1])


def largest_principal(principals: Array) -> Array:
    """Principal stress (...) of the largest magnitude, with its sign, of principal ones (..., 3)."""
    first, last = principals[..., 0], principals[..., 2]
    return np.asarray(np.where(first >= -last, first, last))


def largest_shear(stress: Array) -> Array:
    """Half of the largest difference (...) of principal stresses, of stresses (..., 6)."""
    principals = principal_stresses(stress)
    return np.asarray(0.5 * (principals[..., 0] - principals[..., 2]))


def von_mises(stress: Array) -> Array:
    """Equivalent stress (...) by von Mises of stresses (..., 6) in the same unit."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    squares = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
    return np.asarray(np.sqrt(squares + 3.0 * (xy**2 + yz**2 + zx**2)))


Integers = NDArray[np.int64]

QUADRATURE_ORDER = 2  # three points
# Ends of the edges whose middles are the nodes 3, 4, 5 of a facet.
EDGES = ((0, 1), (1, 2), (0, 2))
# Facets that are turned against a corner's normal by more than this belong to another face.
SMALLEST_COSINE = 0.7
# Terms of the fitted polynomial are held back by this share of the samples' weight where a patch has
# too few of them to tell; the constant is free.
HELD_BACK = np.array([0.0, 1e-9, 1e-9, 1e-5, 1e-5, 1e-5])
CORNERS = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]])


@dataclass(frozen=True)
class SurfaceStress:
    """Stresses at the nodes of a free surface.

    Attributes
    ----------
    nodes : (s,) array
        Numbers of the nodes.
    stress : (s, k, 6) array
        xx, yy, zz, xy, yz, zx for k displacements [Pa].
    normals : (s, 3) array
        Of the surface, outwards.
    """

    nodes: Integers
    stress: Array
    normals: Array


def surface_stress(
    points: Array,
    facets: Integers,
    wanted: NDArray[np.bool_],
    displacement: Array,
    material: Material,
) -> SurfaceStress:
    """Recover the stress on a free surface.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    facets : (t, 6) array
        Nodes of the facets: corners, then the middles of 01, 12, 02; counterclockwise from outside.
    wanted : (t,) array
        Facets whose nodes need stresses. The others are used where they continue these
        without an edge.
    displacement : (n, 3, k) array
        [m]

    Returns
    -------
    SurfaceStress
        At the nodes of the wanted facets.
    """
    corners, number = np.unique(facets[wanted][:, :3], return_inverse=True)
    normals = _mean_normals(points, facets[wanted], number.reshape(-1, 3), 3, len(corners))
    frames = tangent_frames(normals)
    patches = _fitted(points, facets, displacement, corners, frames)

    # Tangential strains at the corners, then at the middles of edges as the mean of what the corners
    # at both ends say of them.
    at_corners = _planes(frames, patches.strains(np.arange(len(corners)), points[corners]))
    middles, first = np.unique(facets[wanted][:, 3:], return_index=True)
    ends = number.reshape(-1, 3)[:, np.array(EDGES)].reshape(-1, 2)[first]
    place = np.searchsorted(middles, facets[wanted][:, 3:])
    middle_normals = _mean_normals(points, facets[wanted], place, 6, len(middles))
    at_middles = np.zeros((len(middles), *at_corners.shape[1:]))
    for owner in ends.T:
        strains = _planes(frames[owner], patches.strains(owner, points[middles]))
        turn = smallest_rotations(normals[owner], middle_normals)[:, None]
        at_middles += 0.5 * turn @ strains @ turn.transpose(0, 1, 3, 2)
    strains = np.concatenate([at_corners, at_middles])
    normals = np.concatenate([normals, middle_normals])
    nodes = np.concatenate([corners, middles])
    return SurfaceStress(nodes, _plane_stress(strains, normals, material), normals)


@dataclass(frozen=True)
class _Patches:
    """Polynomials of tangential strains round corners, in the corners' tangent frames."""

    centers: Array
    frames: Array
    sizes: Array
    coefficients: Array  # (v, 6, k, 3)

    def strains(self, owner: Integers, places: Array) -> Array:
        """Strains (s, k, 3), along both tangents and between them, at places near the corners."""
        local = _tangential(self.frames[owner], places - self.centers[owner])
        terms = _terms(local / self.sizes[owner, None])
        return np.asarray(np.einsum("st,stkc->skc", terms, self.coefficients[owner]))


def _fitted(
    points: Array, facets: Integers, displacement: Array, corners: Integers, frames: Array
) -> _Patches:
    """Fit polynomials to the strains of the facets round each corner."""
    where, _ = get_quadrature(MeshTri1.elem.refdom, QUADRATURE_ORDER)
    values, slopes = triangle_shapes_at(where)
    tangents = np.einsum("aiq,taj->tqij", slopes, points[facets])
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    normals /= np.linalg.norm(normals, axis=2)[:, :, None]
    places = values @ points[facets]
    stretches = np.einsum("aiq,tajk->tqkij", slopes, displacement[facets])
    # Gradient along the surface: d u_j / d x_m = sum_i dual_im d u_j / d xi_i.
    dual = np.linalg.inv(tangents @ tangents.swapaxes(2, 3)) @ tangents

    number = np.full(len(points), -1)
    number[corners] = np.arange(len(corners))
    facet, corner = np.nonzero(number[facets[:, :3]] >= 0)
    owner = number[facets[facet, corner]]
    count = where.shape[1]
    owner, facet = np.repeat(owner, count), np.repeat(facet, count)
    point = np.tile(np.arange(count), len(facet) // count)
    near = np.sum(normals[facet, point] * frames[owner, 2], axis=1) > SMALLEST_COSINE
    owner, facet, point = owner[near], facet[near], point[near]

    turns = smallest_rotations(normals[facet, point], frames[owner, 2])
    tangential = frames[owner, :2] @ turns  # the corner's tangents seen from the facet
    along = tangential @ dual[facet, point].swapaxes(1, 2)
    gradients = (
        along[:, None] @ stretches[facet, point] @ tangential.swapaxes(1, 2)[:, None]
    )  # d u_b / d a in the tangents a, b
    strains = np.stack(
        [
            gradients[..., 0, 0],
            gradients[..., 1, 1],
            0.5 * (gradients[..., 0, 1] + gradients[..., 1, 0]),
        ],
        axis=-1,
    )
    local = _tangential(frames[owner], places[facet, point] - points[corners[owner]])
    reach = np.linalg.norm(local, axis=1)
    samples = np.bincount(owner, minlength=len(corners))
    sizes = np.bincount(owner, reach, len(corners)) / samples
    terms = _terms(local / sizes[owner, None])
    gather = sparse.csr_array(
        (np.ones(len(owner)), (owner, np.arange(len(owner)))), (len(corners), len(owner))
    )
    matrices = gather @ (terms[:, :, None] * terms[:, None, :]).reshape(len(owner), -1)
    systems = matrices.reshape(-1, 6, 6)
    systems[:, np.arange(6), np.arange(6)] += samples[:, None] * HELD_BACK
    flat = strains.reshape(len(owner), 1, -1)
    sides = gather @ (terms[:, :, None] * flat).reshape(len(owner), -1)
    solved = np.linalg.solve(systems, sides.reshape(len(corners), 6, -1))
    coefficients = solved.reshape(len(corners), 6, -1, 3)
    return _Patches(points[corners], frames, sizes, coefficients)


def _mean_normals(
    points: Array, facets: Integers, number: Integers, last: int, count: int
) -> Array:
    """Unit normals (count, 3) at the corners (`last` 3) or the middles (6), mean of their facets."""
    _, slopes = triangle_shapes_at(CORNERS if last == 3 else MIDDLES)
    tangents = np.einsum("aiq,taj->tqij", slopes, points[facets])
    areas = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    total = np.zeros((count, 3))
    np.add.at(total, number, areas)
    return np.asarray(total / np.linalg.norm(total, axis=1)[:, None])


def tangent_frames(normals: Array) -> Array:
    """Right-handed frames (n, 3, 3) of two tangents and the normal, as rows, at unit normals (n, 3)."""
    aside = np.where(np.abs(normals[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    first = np.cross(aside, normals)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normals, first), normals], axis=1)


def smallest_rotations(start: Array, stop: Array) -> Array:
    """Rotations (n, 3, 3) by the smallest angles that bring unit vectors (n, 3) to others."""
    x, y, z = np.cross(start, stop).T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    cosine = np.sum(start * stop, axis=1)[:, None, None]
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + cosine))


def _tangential(frames: Array, arms: Array) -> Array:
    """Coordinates (s, 2) in tangent planes, stretched to the length of the arms (s, 3) [m]."""
    flat = np.einsum("sij,sj->si", frames[:, :2], arms)
    lengths, reach = np.linalg.norm(arms, axis=1), np.linalg.norm(flat, axis=1)
    scale = np.divide(lengths, reach, out=np.ones_like(reach), where=reach > 0.0)
    return np.asarray(flat * scale[:, None])


def _terms(local: Array) -> Array:
    """Terms (s, 6) of a quadratic polynomial at places (s, 2)."""
    x, y = local.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _planes(frames: Array, strains: Array) -> Array:
    """Tensors (s, k, 3, 3) in space of tangential strains (s, k, 3) in frames."""
    local = np.zeros((*strains.shape[:2], 2, 2))
    local[..., 0, 0], local[..., 1, 1] = strains[..., 0], strains[..., 1]
    local[..., 0, 1] = local[..., 1, 0] = strains[..., 2]
    tangents = frames[:, None, :2]
    return np.asarray(tangents.swapaxes(2, 3) @ local @ tangents)


def _plane_stress(strains: Array, normals: Array, material: Material) -> Array:
    """Stresses (s, k, 6) of tangential strains (s, k, 3, 3) where no force acts on the surface."""
    modulus, ratio = material.youngs_modulus, material.poisson_ratio
    plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    spread = np.trace(strains, axis1=2, axis2=3)[..., None, None] * plane[:, None]
    stress = modulus / (1.0 + ratio) * (strains + ratio / (1.0 - ratio) * spread)
    return as_components(stress)


# Elements grow by this much per unit of distance from where they are small.
GROWTH = 0.5


def fillet_element(radius: float, fineness: float) -> float:
    """Element size for a number of elements across the quarter circle of a fillet of a radius [m]."""
    return 0.5 * math.pi * radius / fineness


def measured_sizes(mesh: ThrowMesh) -> SizeMap:
    """Sizes of a mesh's elements: at each corner node the mean of the adjacent ones."""
    corners = mesh.elements[:, :4]
    return sizes_at_corners(mesh.points, corners, element_sizes(mesh.points, corners))


def refine_at(sizes: SizeMap, places: Sequence[tuple[Array, float]]) -> SizeMap:
    """Refine sizes at some points and let them grow from there.

    Parameters
    ----------
    places : sequence of ((p, 3) array, float)
        Points [m], and the size of elements there [m].
    """
    wished = sizes.sizes
    for points, size in places:
        if len(points):
            distance, _ = KDTree(points).query(sizes.points)
            wished = np.minimum(wished, size + GROWTH * distance)
    return SizeMap(sizes.points, sizes.tetrahedra, wished)


# Nodes lie on a fillet's torus to this share of the journal's radius.
PLACE_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Fillet:
    """A fillet between a main journal or pin and a web.

    Attributes
    ----------
    name : str
        For example "left main journal", "pin, left web".
    journal : Cylinder
        The main journal or pin.
    radius : float
        [m]
    start, end : float
        Extent along z [m].
    """

    name: str
    journal: Cylinder
    web: WebPlate
    radius: float
    start: float
    end: float

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 3) of the throw's fillets are on this one."""
        tolerance = PLACE_TOLERANCE * self.journal.radius
        reach = np.linalg.norm(points[:, :2] - self.journal.axis, axis=1)
        low, high = self.journal.radius - tolerance, self.journal.radius + self.radius + tolerance
        z = points[:, 2]
        along = (z > self.start - tolerance) & (z < self.end + tolerance)
        return np.asarray((reach > low) & (reach < high) & along)


def throw_fillets(parts: ThrowParts) -> tuple[Fillet, ...]:
    """Fillets of a throw from its left end to its right."""
    fillets = []
    for journal, web, radius, at_start in _roots(parts):
        if radius > 0.0:
            start = journal.start if at_start else journal.end - radius
            fillets.append(
                Fillet(_root_name(journal, web), journal, web, radius, start, start + radius)
            )
    return tuple(fillets)


def sharp_corners(parts: ThrowParts) -> tuple[str, ...]:
    """Names of the re-entrant corners at main journals and pins that have no fillet."""
    corners = []
    for number, web in enumerate(parts.webs):
        before, after = parts.cylinders[number : number + 2]
        if web.end == web.start:
            corners.append(f"{before.name} and {after.name} where they meet")
    for journal, web, radius, _ in _roots(parts):
        if radius == 0.0 and web.end > web.start:
            corners.append(_root_name(journal, web))
    return tuple(corners)


def _root_name(journal: Cylinder, web: WebPlate) -> str:
    return f"{journal.name}, {web.name}" if journal.is_pin else journal.name


def _roots(parts: ThrowParts) -> list[tuple[Cylinder, WebPlate, float, bool]]:
    """Journal, web, fillet radius and whether it is the journal's start, of each journal's root."""
    roots = []
    for number, web in enumerate(parts.webs):
        before, after = parts.cylinders[number : number + 2]
        roots.append((before, web, before.end_fillet, False))
        roots.append((after, web, after.start_fillet, True))
    return roots
