"""Meshes of many throws by moving the mesh of one, whose nodes go where each throw has them.

The nodes move with the dimensions, along velocities that are found once, and from there by Newton's
method onto the surfaces and the seams of the throw. Where elements suffer, corners are placed anew as in
an elastic body whose small elements are stiff, and those round elements that are still flat or inside out
slide to where these are rounder. Throws of another topology, and meshes that come out worse than the
reference by much, are refused. Answers on meshes of one reference vary as smoothly over the
dimensions as the throws do.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy import sparse

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError, MeshError
from fem.first_mesh import first_factor
from fem.sensitivities import NodeMotion, node_velocities
from fem.solver import factorize, upper_triangle
from geometry.boundary_motion import (
    STEP,
    ZERO,
    Level,
    boundary_motion,
    bounding_surfaces,
    lengths_of,
    level_values,
    surface_conditions,
    with_length,
)
from geometry.mesh import MESH_VOLUME_TOLERANCE, SolidProperties, ThrowMesh
from geometry.mesher import Mesher, mesh_isolated
from geometry.shapes import (
    EDGES,
    corner_quality,
    element_quadrature,
    element_volumes,
    smallest_jacobians,
    straighten_elements,
)
from geometry.sizes import SHARES
from geometry.throw import CrankThrow
from geometry.topology import topology
from geometry.untangling import untangle

# Ways to move a mesh, the quickest first.
VELOCITIES, ELASTIC = "velocities", "elastic"
# Elastic solutions, one after the other.
SOLUTIONS = 2
# Of the motion of nodes onto surfaces: most steps; the distance at which they end, and that allowed, in
# shares of the throw's length.
MOST_STEPS, REACHED, ALLOWED = 6, 1e-13, 1e-6
# Normals of surfaces that touch are parallel, where their directions differ by less than this at the
# reference.
PARALLEL = 2e-3
# For gradients of levels, in lengths of the throw: short beside the smallest fillet.
SHIFT = 1e-7
# Accepted meshes: mean ratio of the flattest element, or half of the reference's if that is less; elements
# that may have straightened edges beside those of the reference, as a share: gmsh's meshes have as many.
LEAST_QUALITY, MOST_STRAIGHTENED = 0.15, 0.01
# Elements up to so many times the least quality are made rounder, together with so many rings of others round
# them, so often.
ROUNDER, RINGS, ROUNDS = 1.5, 2, 4
# Stiffness that holds corners on the surface, in median entries of the diagonal.
HELD = 1e6


# Size factors of the reference's mesh, in those of the first mesh of an analysis to 1 %: the first with all
# mean ratios above this and few elements whose smallest Jacobian is below that, or the best.
COARSER, LEAST_REGULAR, LEAST_CURVED, MOST_CURVED = (2.0, 1.5, 1.0), 0.15, 0.2, 3
ACCURACY = 0.01


def make_reference(
    throw: CrankThrow, paths: Collection[str], mesher: Mesher = mesh_isolated
) -> "ReferenceMesh":
    """Mesh a throw, so that the mesh can be moved over the dimensions at some paths.

    Raises
    ------
    MeshError
        If the throw cannot be meshed, or its mesh not be moved.
    """
    meshes = []
    for coarser in COARSER:
        mesh = mesher(throw, coarser * first_factor(throw, ACCURACY), "auto", None)
        bent = int(np.sum(smallest_jacobians(mesh.points, mesh.elements) < LEAST_CURVED))
        quality = float(corner_quality(mesh.points, mesh.elements).min())
        meshes.append((bent, -quality, mesh))
        if bent <= MOST_CURVED and quality > LEAST_REGULAR:
            break
    _, _, best = min(meshes, key=lambda made: made[:2])
    return ReferenceMesh.of(throw, best, paths)


@dataclass(frozen=True)
class MovedMesh:
    """A mesh that was moved.

    Attributes
    ----------
    tier : str
        How: `VELOCITIES` or `ELASTIC`.
    quality : float
        Mean ratio of its flattest element.
    straightened : int
        Elements with straightened edges, those of the reference left out.
    """

    mesh: ThrowMesh
    tier: str
    quality: float
    straightened: int


@dataclass(frozen=True)
class ReferenceMesh:
    """The mesh of one throw, which can be moved to others of the same topology.

    Attributes
    ----------
    throw : CrankThrow
        Whose mesh it is.
    velocities : dict of str to (n, 3) array
        Velocities of its nodes, by dimension [per unit of the dimension].
    topology : str
        Of the throw, as of `geometry.topology`.
    """

    throw: CrankThrow
    mesh: ThrowMesh
    velocities: dict[str, Array]
    topology: str

    @classmethod
    def of(cls, throw: CrankThrow, mesh: ThrowMesh, paths: Collection[str]) -> "ReferenceMesh":
        """Make one from a throw's mesh, to be moved over the dimensions at some paths.

        Raises
        ------
        MeshError
            If it cannot be moved over one of them.
        """
        if any(hole.exit_radius for hole in throw.parts.drillings):
            raise MeshError(
                "rounded exits of oil holes are on no surface that a mesh could follow."
            )
        motion = boundary_motion(throw, mesh, paths)
        sizes = lengths_of(throw)
        for path, why in motion.left_out.items():
            # A feature that is not there, of size zero, stays away in all throws of the topology.
            if sizes[path]:
                raise MeshError(f"{path} moves no mesh: {why}.")
        # One thread and one library, whatever the machine has, make the same meshes everywhere.
        velocities = node_velocities(mesh, motion, "superlu") if motion.speeds else {}
        return cls(throw, mesh, velocities, topology(throw))

    def at(self, throw: CrankThrow) -> MovedMesh:
        """Move the mesh to another throw.

        Raises
        ------
        MeshError
            If that has another topology, or the moved mesh would be too bad.
        """
        if topology(throw) != self.topology:
            raise MeshError("the throw has another topology than the one whose mesh is moved.")
        reasons = []
        for tier in (VELOCITIES, ELASTIC):
            try:
                return self._accepted(throw, tier)
            except MeshError as error:
                reasons.append(str(error).rstrip("."))
        raise MeshError(f"the mesh cannot be moved: {'; '.join(reasons)}.")

    def motion_at(self, throw: CrankThrow, tier: str, paths: Collection[str]) -> NodeMotion:
        """Velocities of the nodes of the mesh moved to a throw in one way, over dimensions at some paths."""
        sizes, velocities, beside = lengths_of(throw), {}, {}
        left_out = {}
        shift = self._shift(throw, tier)
        for path in paths:
            value = sizes.get(path, 0.0)
            if value == 0.0:
                left_out[path] = ZERO
                continue
            try:
                low, high = (with_length(throw, path, value * (1.0 + s)) for s in (-STEP, STEP))
                ends = [self._straightened(end, tier, shift)[0] for end in (low, high)]
            except (InputError, MeshError) as error:
                left_out[path] = f"next to it no throw can be built or meshed ({error})"
                continue
            velocities[path] = (ends[1] - ends[0]) / (2.0 * STEP * value)
            beside[path] = (low, high)
        return NodeMotion(velocities, beside, left_out)

    def _accepted(self, throw: CrankThrow, tier: str) -> MovedMesh:
        elements, part, length = self.mesh.elements, self.mesh.part, throw.parts.length
        points, straightened = self._straightened(throw, tier, self._shift(throw, tier))
        straightened = max(0, straightened - self.mesh.mended_elements)
        if straightened > MOST_STRAIGHTENED * len(elements):
            raise MeshError(f"{straightened} elements would have to be straightened.")
        quality = float(corner_quality(points, elements).min())
        if quality < self._least_quality:
            raise MeshError(f"an element would be flat, with a mean ratio of {quality:.2g}.")
        # What curved edges miss of the volume, they miss of the reference's as well.
        where, volumes = element_quadrature(points, elements)
        volume = SHARES[part] * throw.volume
        missed = float(volumes.sum()) / volume / self._meshed_share - 1.0
        if abs(missed) > MESH_VOLUME_TOLERANCE:
            raise MeshError(f"its volume would be off by {missed:.1e}.")
        center = volumes @ where / volumes.sum()
        arms = where - center
        second = (volumes[:, None] * arms).T @ arms
        solid = SolidProperties(volume, center, second)
        moved = replace(
            self.mesh, points=points, length=length, mended_elements=straightened, solid=solid
        )
        return MovedMesh(moved, tier, quality, straightened)

    def _straightened(
        self, throw: CrankThrow, tier: str, shift: Array | float
    ) -> tuple[Array, int]:
        """Nodes of the mesh moved in one way and shifted, and how many elements were straightened."""
        points = self._points(throw, tier)
        if np.any(shift):
            points = self._on_surfaces(points + shift, self._levels(throw))
        return straighten_elements(points, self.mesh.elements)

    def _points(self, throw: CrankThrow, tier: str) -> Array:
        """Nodes of the mesh moved in one way, on the surfaces."""
        levels = self._levels(throw)
        sizes, before = lengths_of(throw), lengths_of(self.throw)
        points = self.mesh.points + sum(
            (sizes[path] - before[path]) * velocity for path, velocity in self.velocities.items()
        )
        if tier == ELASTIC:
            corners = self._corners
            for _ in range(SOLUTIONS):
                points[corners] += self._elastic_step(points, levels)
            points = self._with_middles(points, self.mesh.points)
        return self._on_surfaces(points, levels)

    def _with_middles(self, points: Array, before: Array) -> Array:
        """Points with edge nodes that went as far as the ends of their edges, on the mean."""
        shifts, points = points - before, points.copy()
        for node, (start, stop) in zip(range(4, 10), EDGES, strict=True):
            nodes = self.mesh.elements[:, [node, start, stop]].T
            points[nodes[0]] = before[nodes[0]] + 0.5 * (shifts[nodes[1]] + shifts[nodes[2]])
        return points

    def _shift(self, throw: CrankThrow, tier: str) -> Array | float:
        """Shifts (n, 3) by which flat elements of the mesh moved in one way become rounder; 0.0: none."""
        if tier != ELASTIC:
            return 0.0
        levels, elements = self._levels(throw), self.mesh.elements
        points = start = self._points(throw, tier)
        quality = corner_quality(points, elements)
        for _ in range(ROUNDS):
            if quality.min() > self._least_quality:
                break
            near = np.zeros(len(points), dtype=bool)
            near[elements[quality < ROUNDER * self._least_quality, :4]] = True
            for _ in range(RINGS):
                near[elements[near[elements].any(axis=1), :4]] = True
            patch = near[elements].any(axis=1)
            free = np.where(near[:, None, None], self._free(points, levels), 0.0)
            moved = untangle(points, elements[patch, :4], free, self._sizes[patch])
            moved = self._on_surfaces(self._with_middles(moved, points), levels)
            reached = corner_quality(moved, elements)
            if reached.min() <= quality.min():
                break
            points, quality = moved, reached
        return points - start

    def _free(self, points: Array, levels: list[Level]) -> Array:
        """Projections (n, 3, 3) of motions of nodes on directions that their surfaces leave free."""
        numbers, nodes = self._conditions
        _, normals = _normals(levels, numbers, points[nodes], SHIFT * self.mesh.length)
        free = np.tile(np.eye(3), (len(points), 1, 1))
        for here, conditions, rank in self._sharing:
            held = np.linalg.svd(normals[conditions], full_matrices=False)[2][:, :rank]
            free[here] -= held.transpose(0, 2, 1) @ held
        return free

    @cached_property
    def _sizes(self) -> Array:
        return np.cbrt(6.0 * element_volumes(self.mesh.points, self.mesh.elements))

    def _levels(self, throw: CrankThrow) -> list[Level]:
        surfaces = bounding_surfaces(throw.parts, self.mesh.part)
        return [surface.level for surface in surfaces.values()]

    @cached_property
    def _least_quality(self) -> float:
        reference = corner_quality(self.mesh.points, self.mesh.elements).min()
        return min(LEAST_QUALITY, 0.5 * float(reference))

    @cached_property
    def _meshed_share(self) -> float:
        """Volume of the reference mesh, as a share of its solid's."""
        volume = element_volumes(self.mesh.points, self.mesh.elements).sum()
        return float(volume / self.mesh.solid.volume)

    @cached_property
    def _conditions(self) -> tuple[Integers, Integers]:
        return surface_conditions(bounding_surfaces(self.throw.parts, self.mesh.part), self.mesh)

    @cached_property
    def _sharing(self) -> list[tuple[Integers, Integers, int]]:
        """Nodes (n,) with as many conditions, these (n, k), and how many directions they hold."""
        numbers, nodes = self._conditions
        points, step = self.mesh.points[nodes], SHIFT * self.mesh.length
        _, normals = _normals(self._levels(self.throw), numbers, points, step)
        order = np.argsort(nodes, kind="stable")
        held, first, counts = np.unique(nodes[order], return_index=True, return_counts=True)
        sharing = []
        for count in np.unique(counts).tolist():
            here = np.flatnonzero(counts == count)
            conditions = order[first[here, None] + np.arange(count)]
            sizes = np.linalg.svd(normals[conditions], compute_uv=False)
            ranks = np.sum(sizes > PARALLEL * sizes[:, :1], axis=1)
            sharing += [
                (held[here[ranks == rank]], conditions[ranks == rank], rank)
                for rank in np.unique(ranks).tolist()
            ]
        return sharing

    def _on_surfaces(self, points: Array, levels: list[Level]) -> Array:
        """Move nodes onto the surfaces that they belong to, by the least motion.

        Raises
        ------
        MeshError
            If one stays off.
        """
        numbers, nodes = self._conditions
        length = self.mesh.length
        points = points.copy()
        for _ in range(MOST_STEPS):
            values, normals = _normals(levels, numbers, points[nodes], SHIFT * length)
            if np.abs(values).max() < REACHED * length:
                return points
            for here, conditions, rank in self._sharing:
                missed, along = -values[conditions], normals[conditions]
                if conditions.shape[1] == 1:
                    squares = np.sum(along**2, axis=2)
                    points[here] += (missed / squares) * along[:, 0]
                else:
                    left, sizes, right = np.linalg.svd(along, full_matrices=False)
                    shares = np.einsum("nck,nc->nk", left, missed)[:, :rank] / sizes[:, :rank]
                    points[here] += np.einsum("nk,nka->na", shares, right[:, :rank])
        off = float(np.abs(level_values(levels, numbers, points[nodes])).max()) / length
        if not off < ALLOWED:
            raise MeshError(
                f"a node would stay off the surface by {off:.1e} of the throw's length."
            )
        return points

    @cached_property
    def _corners(self) -> Integers:
        return np.unique(self.mesh.elements[:, :4])

    @cached_property
    def _numbered(self) -> Integers:
        """Number of each corner among the corners (n,), -1 of other nodes."""
        numbered = np.full(len(self.mesh.points), -1)
        numbered[self._corners] = np.arange(len(self._corners))
        return numbered

    def _elastic_step(self, points: Array, levels: list[Level]) -> Array:
        """Motion (c, 3) of the corners of an elastic body whose surface is drawn to where it must be."""
        numbers, nodes = self._conditions
        here = self._numbered[nodes] >= 0
        values, normals = _normals(
            levels, numbers[here], points[nodes[here]], SHIFT * self.mesh.length
        )
        sides = points[self.mesh.elements[:, 1:4]] - points[self.mesh.elements[:, :1]]
        if not np.all(np.linalg.det(sides)):
            raise MeshError("elements would be flat.")
        others = np.linalg.inv(sides).transpose(0, 2, 1)
        gradients = np.concatenate([-others.sum(axis=1, keepdims=True), others], axis=1)
        # Without Poisson's ratio, and of a modulus by the inverse volume, which cancels the volume.
        shared = np.einsum("mib,mja->mijab", gradients, gradients)
        products = gradients @ gradients.transpose(0, 2, 1)
        entries = 0.5 * (shared + products[..., None, None] * np.eye(3))
        size = 3 * len(self._corners)
        rows, columns = self._places
        matrix = sparse.csr_array((entries.ravel(), (rows, columns)), shape=(size, size))
        at = 3 * self._numbered[nodes[here], None] + np.arange(3)
        conditions = sparse.csr_array(
            (normals.ravel(), at.ravel(), 3 * np.arange(len(at) + 1)), shape=(len(at), size)
        )
        held = HELD * float(np.median(matrix.diagonal()))
        matrix = sparse.csr_array(matrix + held * (conditions.T @ conditions))
        with factorize(upper_triangle(matrix)) as factors:
            moved = factors.solve(-held * np.asarray(conditions.T @ values[:, None]))
        return moved.reshape(-1, 3)

    @cached_property
    def _places(self) -> tuple[Integers, Integers]:
        """Rows and columns of the entries of the elastic body's elements."""
        elements = self._numbered[self.mesh.elements[:, :4]]
        shape = (len(elements), 4, 4, 3, 3)
        rows = 3 * elements[:, :, None, None, None] + np.arange(3)[:, None]
        columns = 3 * elements[:, None, :, None, None] + np.arange(3)
        return np.broadcast_to(rows, shape).ravel(), np.broadcast_to(columns, shape).ravel()


def _normals(
    levels: list[Level], numbers: Integers, points: Array, step: float
) -> tuple[Array, Array]:
    """Values (c,) of levels at points, and their gradients (c, 3)."""
    starts = np.r_[np.flatnonzero(np.diff(numbers, prepend=-1)), len(numbers)]
    values, gradients = np.empty(len(points)), np.empty((len(points), 3))
    shifts = np.concatenate([np.zeros((1, 3)), step * np.eye(3)])[:, None]
    for first, last in pairwise(starts.tolist()):
        at = (points[first:last] + shifts).reshape(-1, 3)
        here, *beside = levels[numbers[first]](at).reshape(4, -1)
        values[first:last] = here
        gradients[first:last] = (np.array(beside) - here).T / step
    return values, gradients
