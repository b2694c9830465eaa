"""The largest stresses at a throw's fillets and oil holes: results of `fillet_stresses`.

IACS UR M53, Appendix III, requires of a mesh and its stresses what is compared with the values reached:
at the fillets, within 90 degrees of the crank plane on the side of the overlap, elements measure a
quarter of the radius or less (a) along and around; three layers below are a, 2a and 3a thick; there are
six elements across the web. Where a stress is read the smallest principal stress is below 3 % of the
largest, and the values of single elements at the node are within 5 % of their mean. Second-order
tetrahedra are allowed; they are measured here by the side of the regular triangle of a facet's area, and
by the height of the regular tetrahedron of an element's volume, the mean of all.

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from scipy import sparse

from crankbase.array_checks import Array, Flags, Integers
from crankbase.choices import check_choice
from crankbase.diagrams import draw_groups, new_axes, write_title
from crankbase.frames import Axes, grid, table
from crankbase.results import Number, Part, Quantity, Result, result
from crankbase.summaries import frozen, summarized
from fem.correction import StressRecovery, stresses_at
from fem.material import Material
from fem.solver import SharedSolver, assemble_stiffness
from fem.superelement import RX, RY, CondensedClass, EndSections, condense, hold_ends
from fem.supports import STRETCH, TWIST, unit_response
from fem.symmetry import (
    MirrorImage,
    SymmetryClass,
    symmetry_classes,
    unit_pin_loads,
)
from fem.whole_throw import WholeNodes, whole_facets, whole_nodes
from geometry.any_throw import Throw
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.parts import Cylinder, DrillingExit, ThrowParts, WebPlate
from geometry.shapes import EDGES, element_volumes, quadrature, shapes_at_nodes, triangle_shapes_at
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners
from geometry.solid import CRANK_PLANE, FILLET, LEFT_END, MIDDLE_PLANE, OIL_HOLE, RIGHT_END

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


QUADRATURE_ORDER = 2  # three points
# Ends of the edges whose middles are the nodes 3, 4, 5 of a facet.
FACET_EDGES = ((0, 1), (1, 2), (0, 2))
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
    wanted: Flags,
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
    ends = number.reshape(-1, 3)[:, np.array(FACET_EDGES)].reshape(-1, 2)[first]
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
    # No force acts on the surface.
    modulus, ratio = material.youngs_modulus, material.poisson_ratio
    plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    spread = np.trace(strains, axis1=2, axis2=3)[..., None, None] * plane[:, None]
    stress = modulus / (1.0 + ratio) * (strains + ratio / (1.0 - ratio) * spread)
    return SurfaceStress(nodes, as_components(stress), normals)


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
    where, _ = quadrature(2, QUADRATURE_ORDER)
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
    from scipy.spatial import KDTree  # here: no other analysis of a throw needs it

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

    def holds(self, points: Array) -> Flags:
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


# Moments on both ends that open the throw as a radial force does, and that bend it across.
OPENING = np.zeros(12)
OPENING[[RX, 6 + RX]] = 1.0, -1.0
BENDING_ACROSS = np.zeros(12)
BENDING_ACROSS[[RY, 6 + RY]] = -1.0, 1.0


@dataclass(frozen=True)
class UnitLoad:
    """A load of 1 N or 1 N m on a throw.

    Attributes
    ----------
    kind : {"axial", "torsion", "bending", "cross bending", "radial"}
    unit : {"N", "N m"}
    ends : (12,) array
        Forces and moments on the left, then on the right end section.
    pin : int or None
        Index of the pin with a radial force towards the shaft, from 0; uniform over its surface.
    direction : (3,) array
        Of that force.
    """

    kind: str
    name: str
    unit: str
    ends: Array
    pin: int | None
    direction: Array


def unit_loads(radials: Array) -> tuple[UnitLoad, ...]:
    """Return the unit loads of a throw.

    Parameters
    ----------
    radials : (pins, 3) array
        Direction of a radial force on each pin, towards the shaft.
    """
    none = np.zeros(3)
    loads = [
        UnitLoad("axial", "axial force", "N", STRETCH, None, none),
        UnitLoad("torsion", "torque", "N m", TWIST, None, none),
        UnitLoad("bending", "bending in the crank plane", "N m", OPENING, None, none),
        UnitLoad(
            "cross bending", "bending across the crank plane", "N m", BENDING_ACROSS, None, none
        ),
    ]
    for pin, direction in enumerate(radials):
        name = "radial force" if len(radials) == 1 else f"radial force on pin {pin + 1}"
        loads.append(UnitLoad("radial", name, "N", np.zeros(12), pin, direction))
    return tuple(loads)


@dataclass(frozen=True)
class LoadedThrow:
    """A throw's displacements under several loads.

    Attributes
    ----------
    mesh : ThrowMesh
        The meshed part.
    shares : tuple of (SymmetryClass, (n, 3, k) array)
        Contribution of each symmetry class to the displacement of the meshed part under each of k
        loads [m].
    end_sections : {"rigid", "averaged"}
    """

    mesh: ThrowMesh
    material: Material
    loads: tuple[UnitLoad, ...]
    shares: tuple[tuple[SymmetryClass, Array], ...]
    solver: str
    end_sections: str

    @cached_property
    def whole(self) -> WholeNodes:
        """Numbers of the whole throw's nodes."""
        return whole_nodes(self.mesh)

    def displacement(self, image: MirrorImage, loads: slice = slice(None)) -> Array:
        """Displacements (n, 3, k) of an image of the meshed part under all or some of the loads [m]."""
        total = sum(symmetry.parity(image) * field[..., loads] for symmetry, field in self.shares)
        return np.asarray(image.signs[:, None] * total)

    def stresses(self, images: Sequence[MirrorImage]) -> list[Array]:
        """Stresses (n, k, 6) at the nodes of each image, recovered from the elements [Pa]."""
        mesh = self.mesh
        totals = [np.zeros((len(mesh.points), len(self.loads), 6)) for _ in images]
        recovery = StressRecovery(mesh.points, mesh.elements)
        for symmetry, field in self.shares:
            loads = np.flatnonzero(np.any(field, axis=(0, 1)))
            if not loads.size:
                continue
            stresses = recovery.stresses(field[:, :, loads], self.material)
            for image, total in zip(images, totals, strict=True):
                total[:, loads] += symmetry.parity(image) * stresses.transpose(0, 2, 1)
        return [
            as_components(np.outer(image.signs, image.signs) * as_matrices(total))
            for image, total in zip(images, totals, strict=True)
        ]

    def single_stresses(self, node: int, load: int) -> Array:
        """Stress (e, 6) at a corner node of the whole throw by each element round it."""
        mesh, whole = self.mesh, self.whole
        _, gradients = shapes_at_nodes()
        singles = []
        for image, numbers in zip(whole.images, whole.numbers, strict=True):
            element, corner = np.nonzero(
                np.isin(mesh.elements[:, :4], np.flatnonzero(numbers == node))
            )
            if not element.size:
                continue
            stress = stresses_at(
                image.points(mesh.points),
                mesh.elements[element],
                self.displacement(image, slice(load, load + 1))[..., 0],
                self.material,
                gradients,
            )
            singles.append(stress[np.arange(len(element)), corner])
        return np.concatenate(singles)


def solve_unit_loads(
    mesh: ThrowMesh,
    loads: Sequence[UnitLoad],
    material: Material,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
) -> LoadedThrow:
    """Find the displacements of a throw under unit loads, ends pinned.

    Only the symmetry classes that the loads excite are solved: three of a quarter's four under those of
    `unit_loads`.

    Parameters
    ----------
    solver : str
        See `fem.solver.SharedSolver`.
    end_sections : {"rigid", "averaged"}
        See `fem.superelement.condense`.

    Raises
    ------
    InputError
        If `end_sections` is neither.
    SolveError
        If the system cannot be solved.
    """
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    pins = unit_pin_loads(mesh)
    held = hold_ends(mesh, stiffness, 0) if end_sections == "rigid" else None
    shared = SharedSolver(solver)
    try:
        parts = [
            condense(mesh, stiffness, pins, symmetry, shared, end_sections, held)
            for symmetry in symmetry_classes(mesh.part)
            if any(_excites(load, symmetry) for load in loads)
        ]
    finally:
        shared.close()
    return under_unit_loads(mesh, loads, material, parts)


def under_unit_loads(
    mesh: ThrowMesh,
    loads: Sequence[UnitLoad],
    material: Material,
    parts: Sequence[CondensedClass],
) -> LoadedThrow:
    """Return the displacements of a solved throw under unit loads, ends pinned.

    Parameters
    ----------
    parts : sequence of CondensedClass
        At least those that the loads excite, with rigid or averaged sections, not corrected.
    """
    shares = []
    for part in parts:
        fields = []
        for load in loads:
            if not _excites(load, part.symmetry):
                fields.append(np.zeros(part.fields.shape[:2]))
                continue
            work = load.ends @ part.symmetry.ends
            if load.pin is not None:
                work = work + part.pin_loads[load.pin, :, :3] @ load.direction
            field = part.fields @ unit_response(part, "pinned", work)
            if load.pin is not None:
                pins, components = part.pin_components.T
                on_it = (pins == load.pin) & (components < 3)
                field = field + part.pin_fields[:, :, on_it] @ load.direction[components[on_it]]
            fields.append(field)
        shares.append((part.symmetry, np.stack(fields, axis=-1)))
    return LoadedThrow(
        mesh, material, tuple(loads), tuple(shares), parts[0].solver, parts[0].end_sections
    )


def _excites(load: UnitLoad, symmetry: SymmetryClass) -> bool:
    """Whether a load does work on any motion of a class."""
    on_pin = load.pin is not None and np.any(load.direction[symmetry.central_motions[:3]])
    return bool(on_pin or np.any(load.ends @ symmetry.ends))


# Allowed: size beside the fillet's radius, layers beside a, elements across the web.
LARGEST_SIZE, LAYERS, ACROSS_WEB = 0.25, (1.0, 2.0, 3.0), 6.0
# Wished, so that the largest facet, not the mean one, is as small as allowed.
WISHED_SIZE = 0.18
# The mesher's elements come out up to a few percent larger than wished: so many are wished across the web.
WISHED_ACROSS = 6.3
# Of the largest stress: the smallest principal one, and by how much elements may differ.
LARGEST_NORMAL, LARGEST_SPREAD = 0.03, 0.05
# Height of a regular tetrahedron beside its edge.
HEIGHT = math.sqrt(2.0 / 3.0)
# Loads for which the rule has factors of fillets.
RULE_LOADS = ("torsion", "bending", "radial")
ON_SIDE = -1e-6  # of the journal's radius


@result("fillet", "size", "size_share", "layers", "across_web", "met", eq=True)
class FilletMeshing(Result):
    """Mesh size at a fillet and its web, and the requirements of UR M53, Appendix III.

    The size is that of the largest element along and around the fillet, within 90 degrees of the crank
    plane. A quarter of the radius is allowed, layers of 1, 2 and 3 quarters below, and six elements
    across the web are required.
    """

    fillet: str
    size: Annotated[float, Quantity("m")]
    size_share: Annotated[float, Quantity("1", "of the radius")]
    layers: Annotated[tuple[float, ...], Quantity("1", "mean heights in quarters of the radius")]
    across_web: Annotated[float, Quantity("1", "elements across the web's thickness")]

    @property
    def met(self) -> Part[bool]:
        """Whether the mesh is as fine as the rule requires."""
        layers = all(thickness <= most for thickness, most in zip(self.layers, LAYERS, strict=True))
        return self.size_share <= LARGEST_SIZE and layers and self.across_web >= ACROSS_WEB


@result("normal_share", "spread", "met", eq=True)
class ReadingQuality(Result):
    """The two criteria of UR M53, Appendix III, for a stress read at a node.

    `normal_share` is the magnitude of the smallest principal stress over that of the largest, of the
    elements' mean stress, below 0.03; `spread` the largest difference of a single element's equivalent
    stress at the node from the mean one, relative to that, at most 0.05.
    """

    normal_share: Number
    spread: Number

    @property
    def met(self) -> Part[bool]:
        """Whether both criteria are met."""
        return self.normal_share < LARGEST_NORMAL and self.spread <= LARGEST_SPREAD


def on_crank_side(fillet: Fillet, points: Array) -> Flags:
    """Which points (n, 3) lie within 90 degrees of the crank plane, where journal and pin overlap."""
    axis = np.array(fillet.journal.axis)
    far = math.dist(fillet.web.foot, axis) > math.dist(fillet.web.tip, axis)
    towards = np.array(fillet.web.direction) * (-1.0 if far else 1.0)
    return np.asarray((points[:, :2] - axis) @ towards > ON_SIDE * fillet.journal.radius)


def rule_sizes(
    sizes: SizeMap, webs: Sequence[WebPlate], places: Sequence[tuple[Fillet, Array]]
) -> SizeMap:
    """Limit the size of elements to that required by the rule.

    Parameters
    ----------
    places : sequence of (Fillet, (p, 3) array)
        Fillets with points on them [m].
    """
    wished = sizes.sizes.copy()
    for web in webs:
        inside = _in_web(web, sizes.points)
        wished[inside] = np.minimum(wished[inside], (web.end - web.start) / WISHED_ACROSS)
    return refine_at(
        SizeMap(sizes.points, sizes.tetrahedra, wished),
        [
            (points[on_crank_side(fillet, points)], WISHED_SIZE * fillet.radius)
            for fillet, points in places
        ],
    )


def fillet_meshings(mesh: ThrowMesh, fillets: Sequence[Fillet]) -> tuple[FilletMeshing, ...]:
    """Measure a mesh at those fillets that are on the meshed part."""
    facets = mesh.points[mesh.surfaces[FILLET]]
    corners = mesh.elements[:, :4]
    places, heights = (
        mesh.points[corners].mean(axis=1),
        HEIGHT * element_sizes(mesh.points, corners),
    )
    volumes = element_volumes(mesh.points, mesh.elements)
    meshings = []
    for fillet in fillets:
        flat = facets.reshape(-1, 3)
        here = (fillet.holds(flat) & on_crank_side(fillet, flat)).reshape(-1, 3).all(axis=1)
        if not here.any():
            continue
        first, second, third = facets[here].transpose(1, 0, 2)
        areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
        size = float(np.sqrt(4.0 / math.sqrt(3.0) * areas.max()))
        step = LARGEST_SIZE * fillet.radius
        # Depth of the elements' middles below the fillet's surface; infinite outside it.
        journal, radius = fillet.journal, fillet.radius
        on_left = abs(fillet.start - journal.start) < abs(fillet.end - journal.end)
        center = fillet.end if on_left else fillet.start
        outwards = journal.radius + radius - np.linalg.norm(places[:, :2] - journal.axis, axis=1)
        along = (center - places[:, 2]) if on_left else (places[:, 2] - center)
        beside = (outwards < 0.0) | (along < 0.0) | ~on_crank_side(fillet, places)
        depth = np.where(beside, np.inf, np.hypot(outwards, along) - radius)
        layers, start = [], 0.0
        for thickness in LAYERS:
            off = np.abs(depth / step - (start + 0.5 * thickness)) / (0.5 * thickness)
            # On a coarse mesh the layer may hold no element's middle; then the nearest one counts.
            layers.append(float(heights[off <= max(1.0, off.min())].mean() / step))
            start += thickness
        web = _in_web(fillet.web, places)
        mean = float(volumes[web] @ heights[web] / volumes[web].sum())
        across = (fillet.web.end - fillet.web.start) / mean
        meshings.append(
            FilletMeshing(fillet.name, size, size / fillet.radius, tuple(layers), across)
        )
    return tuple(meshings)


def reading_quality(loaded: LoadedThrow, node: int, load: int, *, shear: bool) -> ReadingQuality:
    """Agreement of the elements around a node on the stress there.

    Parameters
    ----------
    node : int
        Of the whole throw, as `fem.fillet_peaks.whole_nodes` numbers them. Where it is the middle of an edge
        the worse of the two ends counts, since more elements meet there.
    load : int
        Number of the load.
    shear : bool
        Whether to use the half difference of principal stresses instead of von Mises.
    """
    measure = largest_shear if shear else von_mises
    shares, spreads = [], []
    mesh, whole = loaded.mesh, loaded.whole
    image, number = (int(index[0]) for index in np.nonzero(whole.numbers == node))
    element, place = (int(index[0]) for index in np.nonzero(mesh.elements == number))
    # The node itself if it is a corner, else the ends of the edge that it halves.
    places = [place] if place < 4 else EDGES[place - 4]
    for corner in whole.numbers[image, mesh.elements[element, places]]:
        every = loaded.single_stresses(corner, load)
        mean = every.mean(axis=0)
        sizes = np.abs(principal_stresses(mean))
        shares.append(sizes.min() / sizes.max())
        spreads.append(np.abs(measure(every) - measure(mean)).max() / measure(mean))
    return ReadingQuality(float(max(shares)), float(max(spreads)))


def _in_web(web: WebPlate, points: Array) -> Flags:
    """Which points (n, 3) are in a web's plate between foot and tip, counterweight left out."""
    along = (points[:, :2] - web.foot) @ np.array(web.direction)
    height = (along > web.outline.foot) & (along < web.outline.tip)
    reach = 1e-6 * (web.end - web.start)
    return np.asarray(
        height & (points[:, 2] > web.start - reach) & (points[:, 2] < web.end + reach)
    )


# Surfaces where stresses are asked for, and those that are not free.
STRESSED = (FILLET, OIL_HOLE)
CUTS_AND_ENDS = (CRANK_PLANE, MIDDLE_PLANE, LEFT_END, RIGHT_END)


@dataclass(frozen=True)
class FilletSurface:
    """Nodes on the fillets and in the oil holes of a whole throw with their stresses.

    Attributes
    ----------
    nodes : (s,) array
        Their numbers by `fem.fillet_peaks.whole_nodes`.
    points : (s, 3) array
        [m]
    stress : (s, k, 6) array
        xx, yy, zz, xy, yz, zx under k loads [Pa].
    meshed : (s,) array of bool
        Which are on the meshed part itself, not only on its mirror images.
    normals : (s, 3) array
        Of the surface, outwards.
    """

    nodes: Integers
    points: Array
    stress: Array
    meshed: Flags
    normals: Array


def fillet_surface(loaded: LoadedThrow) -> FilletSurface:
    """Recover the stresses at fillets and oil holes of a loaded throw from the strains of the surface.

    The facets of the whole throw are used, so that points on a cut are treated like
    any other.
    """
    mesh = loaded.mesh
    free = [name for name in mesh.surfaces if name not in CUTS_AND_ENDS]
    corners = np.concatenate([mesh.surfaces[name] for name in free])
    stressed = np.concatenate(
        [np.full(len(mesh.surfaces[name]), name in STRESSED) for name in free]
    )
    # Facets on and next to fillets and oil holes.
    near = np.isin(corners, corners[stressed]).any(axis=1)
    whole = loaded.whole
    points = whole.collect([image.points(mesh.points) for image in whole.images])
    displacement = whole.collect([loaded.displacement(image) for image in whole.images])
    stresses = surface_stress(
        points,
        whole_facets(whole, six_node_triangles(mesh, corners[near])),
        np.tile(stressed[near], len(whole.images)),
        displacement,
        loaded.material,
    )
    meshed = np.isin(stresses.nodes, whole.numbers[0])
    return FilletSurface(
        stresses.nodes, points[stresses.nodes], stresses.stress, meshed, stresses.normals
    )


def fillet_points(mesh: ThrowMesh) -> Array:
    """Nodes (p, 3) on the fillets and in the oil holes of a meshed part [m]."""
    corners = np.concatenate([mesh.surfaces[name] for name in STRESSED if name in mesh.surfaces])
    return np.asarray(mesh.points[np.unique(six_node_triangles(mesh, corners))])


Criterion = Literal["principal", "von Mises"]
LABELS: Mapping[Criterion, str] = {
    "principal": "largest principal / nominal stress [1]",
    "von Mises": "von Mises / nominal stress [1]",
}


@dataclass(frozen=True, kw_only=True)
class _Peak:
    """The largest stresses at one location under one unit load; see `FilletPeak`."""

    load: UnitLoad
    principal: float
    principal_place: Array
    principals: Array
    von_mises: float
    von_mises_place: Array
    shear: float
    shear_place: Array
    nominal: float
    error_estimate: float
    quality: ReadingQuality

    @property
    def factor(self) -> float:
        """Stress concentration factor: magnitude of the largest principal stress over the nominal one."""
        return abs(self.principal) / self.nominal

    @property
    def von_mises_factor(self) -> float:
        """Largest equivalent stress by von Mises divided by the nominal stress."""
        return self.von_mises / self.nominal

    @property
    def shear_factor(self) -> float:
        """Largest shear stress divided by the nominal stress."""
        return self.shear / self.nominal


@summarized(
    "fillet: fillet.name", "load: load.kind", "factor", "von_mises_factor", "error_estimate"
)
@dataclass(frozen=True, kw_only=True)
class FilletPeak(_Peak):
    """The largest stresses at one fillet under one unit load.

    If a throw is symmetric about the crank plane, the location with x >= 0 is given; its mirror image
    has the same stresses, under a torque or bending across the crank plane with the opposite sign.

    Attributes
    ----------
    principal : float
        Principal stress of the largest magnitude, with its sign [Pa/N or Pa/(N m)].
    principal_place : (3,) array
        Its location, in the throw frame [m].
    principals : (3,) array
        All principal stresses there, largest first; that across the free surface is 0.
    von_mises : float
        Largest equivalent stress by von Mises, same unit.
    von_mises_place : (3,) array
    shear : float
        Largest shear stress, half of the difference of the outer principal stresses, same unit.
    shear_place : (3,) array
    nominal : float
        Nominal stress, as `fem.fillet_stress` defines it; under a torque a shear stress.
    error_estimate : float
        Estimated relative error of the largest values.
    quality : ReadingQuality
        Agreement of the elements on the stress read by the rule.
    """

    fillet: Fillet

    @property
    def name(self) -> str:
        """Name of the fillet."""
        return self.fillet.name

    @property
    def rule_factor(self) -> float | None:
        """Factor as UR M53 defines it: by the largest shear stress under a torque, by von Mises in bending.

        None under loads that are not in the rule.
        """
        if self.load.kind == "torsion":
            return self.shear_factor
        return self.von_mises_factor if self.load.kind in RULE_LOADS else None


@summarized("exit: outlet.name", "load: load.kind", "factor", "von_mises_factor", "error_estimate")
@dataclass(frozen=True, kw_only=True)
class OilHolePeak(_Peak):
    """The largest stresses at one exit of an oil hole under one unit load.

    The exit is its rounding and the hole's wall to a depth of one diameter. The nominal stress is that of
    the pin or main journal without the hole.

    Attributes
    ----------
    outlet : DrillingExit
        Which exit.
    load, principal, principal_place, principals, von_mises, von_mises_place, shear, shear_place, nominal
        As in `FilletPeak`.
    error_estimate, quality
        As in `FilletPeak`.
    """

    outlet: DrillingExit

    @property
    def name(self) -> str:
        """For example "pin, oil hole 1 at 45 deg"."""
        return self.outlet.name

    @property
    def rule_factor(self) -> float | None:
        """Factor as UR M53 defines it, by the largest principal stress; None for loads not in the rule."""
        return self.factor if self.load.kind in ("torsion", "bending", "cross bending") else None


@frozen("peaks", "error_estimate", "accuracy", "sharp_corners")
class FilletStresses:
    """Stresses at the fillets and at the exits of the oil holes of a throw.

    Attributes
    ----------
    peaks : tuple of FilletPeak
        For each load, the fillets from left to right.
    sharp_corners : tuple of str
        Corners without a fillet: the elastic stress there is unbounded, so there is no number.
    loaded : LoadedThrow
        The last mesh with its displacements.
    surface : FilletSurface
        Stresses over the fillets and oil holes.
    fineness : float
        Elements across the quarter circle of a fillet where it was refined last.
    accuracy : float
        The requested accuracy.
    mesh : {"adaptive", "m53"}
        The requested kind of mesh.
    hole_peaks : tuple of OilHolePeak
        For each load, the exits of the oil holes in their order.
    """

    throw: Throw
    peaks: tuple[FilletPeak, ...]
    sharp_corners: tuple[str, ...]
    loaded: LoadedThrow
    surface: FilletSurface
    fineness: float
    accuracy: float
    mesh: str = "adaptive"
    hole_peaks: tuple[OilHolePeak, ...] = ()

    @property
    def error_estimate(self) -> float:
        """Largest of the error estimates."""
        return max(peak.error_estimate for peak in (*self.peaks, *self.hole_peaks))

    @property
    def meshings(self) -> tuple[FilletMeshing, ...]:
        """Mesh size at the fillets on the meshed part, and the requirements of UR M53."""
        fillets = {peak.name: peak.fillet for peak in self.peaks}
        return fillet_meshings(self.loaded.mesh, list(fillets.values()))

    @property
    def rule_met(self) -> bool:
        """Whether the mesh, and the stresses under the loads of UR M53, meet its requirements."""
        read = [peak.quality.met for peak in self.peaks if peak.load.kind in RULE_LOADS]
        return all(read) and all(meshing.met for meshing in self.meshings)

    @property
    def accuracy_met(self) -> bool:
        """Whether all error estimates are within the requested accuracy."""
        return self.error_estimate <= self.accuracy

    def under(self, load: UnitLoad) -> tuple[FilletPeak, ...]:
        """Peaks under one load, the fillets from left to right."""
        return tuple(peak for peak in self.peaks if peak.load is load)

    def at_oil_holes(self, load: UnitLoad) -> tuple[OilHolePeak, ...]:
        """Peaks at the exits of oil holes under one load."""
        return tuple(peak for peak in self.hole_peaks if peak.load is load)

    @property
    def _all(self) -> list[FilletPeak | OilHolePeak]:
        """For each load, the fillets from left to right, then the exits of oil holes."""
        every: tuple[FilletPeak | OilHolePeak, ...] = (*self.peaks, *self.hole_peaks)
        loads = list({id(peak.load): None for peak in every})
        return sorted(every, key=lambda peak: loads.index(id(peak.load)))

    def plot(self, axes: Axes | None = None, *, criterion: Criterion = "principal") -> Axes:
        """Draw the stress concentration factors, a color for each load.

        There is a group of bars for each fillet and for each exit of an oil hole.

        Parameters
        ----------
        criterion : {"principal", "von Mises"}
            Stress that is divided by the nominal one.

        Raises
        ------
        InputError
            If the criterion is neither.
        """
        check_choice("criterion", criterion, LABELS, "factors are made of these stresses")
        loads, fillets = self._names
        factors = self._array("factor" if criterion == "principal" else "von_mises_factor")
        axes = new_axes(axes, width=8.6)
        draw_groups(axes, fillets, dict(zip(loads, factors, strict=True)), LABELS[criterion])
        holes = " and oil holes" if self.hole_peaks else ""
        write_title(axes, f"Stress concentration at the fillets{holes}")
        return axes

    def to_pandas(self) -> Any:
        """Return a table with a row for each load and fillet, from left to right, and each oil hole's exit.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        peaks = self._all
        stress = "Pa/N or Pa/(N m), as the load's unit says"
        places = np.array([peak.principal_place for peak in peaks])
        units = dict.fromkeys(("factor", "von_mises_factor"), "1")
        units |= dict.fromkeys(("principal", "von_mises", "nominal"), stress)
        units["error_estimate"] = "1"
        return table(
            {
                "load": ([peak.load.name for peak in peaks], ""),
                "load_unit": ([peak.load.unit for peak in peaks], ""),
                "fillet": ([peak.name for peak in peaks], ""),
            }
            | {
                name: ([getattr(peak, name) for peak in peaks], unit)
                for name, unit in units.items()
            }
            | {axis: (column, "m") for axis, column in zip("xyz", places.T, strict=True)}
        )

    def to_xarray(self) -> Any:
        """Return factors and their errors over loads and fillets, the exits of oil holes among these.

        Returns
        -------
        xarray.Dataset
            ``factor``, ``von_mises_factor`` and ``error_estimate`` (load, fillet).

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        words = {
            "factor": "largest principal stress by the nominal one",
            "von_mises_factor": "largest equivalent stress by the nominal one",
            "error_estimate": "estimated relative error of both",
        }
        loads, fillets = self._names
        return grid(
            {
                name: (("load", "fillet"), self._array(name), "1", text)
                for name, text in words.items()
            },
            {"load": (loads, "", "unit load"), "fillet": (fillets, "", "fillet")},
        )

    @property
    def _names(self) -> tuple[list[str], list[str]]:
        """Names of loads and fillets, in the order of the peaks."""
        loads = dict.fromkeys(peak.load.name for peak in self._all)
        return list(loads), list(dict.fromkeys(peak.name for peak in self._all))

    def _array(self, name: str) -> Array:
        """An attribute of the peaks (loads, fillets)."""
        values = np.array([getattr(peak, name) for peak in self._all], dtype=np.float64)
        return values.reshape(len(self._names[0]), -1)
