"""Second-order tetrahedral mesh of a throw's quarter, checked and mended."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import MeshError
from geometry.gmsh_session import gmsh_session
from geometry.shapes import jacobians, shapes_at_nodes, shapes_for_quadrature
from geometry.solid import FILLET, PIN, build_quarter, place_tolerance
from geometry.throw import CrankThrow

# gmsh numbers the edges of a 10-node tetrahedron in another order than scikit-fem.
GMSH_TO_SKFEM = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
# The two end nodes of each edge node 4..9, in scikit-fem's order.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
# Element sizes at factor 1, found by converging ordinary throws: at fillets beside their radius and,
# for large fillets, beside the web thickness; at sharp corners beside the web thickness; and how much
# elements grow per unit of distance from there.
ROOT_PER_FILLET = 0.8
FILLET_ROOT_PER_WEB = 0.20
ROOT_PER_WEB = 0.10
GROWTH = 0.5
# Shares of the size factor tried in turn until the mesh can be mended and has the solid's volume.
FINER_SHARES = (1.0, 0.8, 0.6)


@dataclass(frozen=True)
class ThrowMesh:
    """A mesh of a throw or of the part of it that its symmetry leaves.

    Attributes
    ----------
    part : {"quarter", "half", "full"}
        What is meshed: x >= 0 and z <= length / 2, only x >= 0, or everything.
    length : float
        Length of the whole throw along the shaft [m].
    pins : tuple of str
        Names of the crankpins' surfaces, "pin", "pin 2" ...
    points : (n, 3) array
        Node coordinates in the throw frame [m].
    elements : (m, 10) array
        Node numbers of the tetrahedra, corner nodes first, edge nodes in scikit-fem's order.
    surfaces : dict
        Corner node numbers (k, 3) of the facets of each named surface: "left end", "right end" (not of
        a quarter), "crank plane" and "middle plane" (the cuts), each of `pins`, "main journal",
        "fillet", "web", "bore", "counterweight".
    size_factor : float
        The size factor the mesh was made with: 1 is the default, smaller is finer.
    mended_elements : int
        Elements that were inside out and had their edges straightened.
    solid_volume : float
        Volume of the quarter solid [m^3].
    """

    part: str
    length: float
    pins: tuple[str, ...]
    points: NDArray[np.float64]
    elements: NDArray[np.int64]
    surfaces: dict[str, NDArray[np.int64]]
    size_factor: float
    mended_elements: int
    solid_volume: float

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns of the quarter."""
        return 3 * len(self.points)


def mesh_throw(throw: CrankThrow, size_factor: float = 1.0) -> ThrowMesh:
    """Mesh the quarter of a throw.

    A mesh too coarse for the solid's volume is made again, finer; its `size_factor` then says so.

    Parameters
    ----------
    throw : CrankThrow
        The dimensions.
    size_factor : float
        Scales all element sizes; 1 gives about 1 % accuracy of the axial compliance.

    Returns
    -------
    ThrowMesh

    Raises
    ------
    MeshError
        If gmsh fails, the mesh cannot be mended, or its volume is not the solid's.
    """
    for share in FINER_SHARES:
        try:
            mesh = _mesh_once(throw, size_factor * share)
            _check_volume(mesh)
        except MeshError:
            if share == FINER_SHARES[-1]:
                raise
            continue
        break
    return mesh


def _mesh_once(throw: CrankThrow, size_factor: float) -> ThrowMesh:
    with gmsh_session("throw") as gmsh:
        try:
            surfaces = build_quarter(gmsh, throw)
            volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
            _set_sizes(gmsh, throw, surfaces, size_factor)
            gmsh.model.mesh.generate(3)
            gmsh.model.mesh.setOrder(2)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception
            raise MeshError(f"gmsh could not mesh the throw: {error}") from error
        points, elements, facets = _read_mesh(gmsh, surfaces)
    points, mended = _mend(points, elements)
    return ThrowMesh(
        "quarter", throw.length, (PIN,), points, elements, facets, size_factor, mended, volume
    )


def _set_sizes(gmsh: Any, throw: CrankThrow, surfaces: dict[str, list[int]], factor: float) -> None:
    """Small elements at the fillets (or sharp journal corners), growing into the bulk."""
    bulk = factor * min(throw.web_thickness, 0.5 * throw.pin_diameter)
    if throw.fillet_radius > 0.0:
        root = factor * min(
            ROOT_PER_FILLET * throw.fillet_radius, FILLET_ROOT_PER_WEB * throw.web_thickness
        )
        root = min(bulk, root)
        where = {"SurfacesList": surfaces[FILLET]}
    else:
        root = min(bulk, factor * ROOT_PER_WEB * throw.web_thickness)
        where = {"CurvesList": _corner_curves(gmsh, throw)}
    field = gmsh.model.mesh.field
    distance = field.add("Distance")
    for key, tags in where.items():
        field.setNumbers(distance, key, tags)
    field.setNumber(distance, "Sampling", 40)
    size = field.add("Threshold")
    field.setNumber(size, "InField", distance)
    field.setNumber(size, "SizeMin", root)
    field.setNumber(size, "SizeMax", bulk)
    field.setNumber(size, "DistMin", 0.0)
    field.setNumber(size, "DistMax", (bulk - root) / GROWTH + 1e-6 * bulk)
    field.setAsBackgroundMesh(size)


def _corner_curves(gmsh: Any, throw: CrankThrow) -> list[int]:
    """Return the circles where unfilleted journals meet their web."""
    tolerance = place_tolerance(throw)
    half_journal = throw.main_journal_length / 2.0
    corners = {
        half_journal: throw.main_journal_diameter / 2.0,
        half_journal + throw.web_thickness: throw.pin_diameter / 2.0,
    }
    tags = []
    for _, tag in gmsh.model.getEntities(1):
        _, _, z_low, x_high, _, z_high = gmsh.model.getBoundingBox(1, tag)
        for z, radius in corners.items():
            if abs(z_low - z) < tolerance > abs(z_high - z) and abs(x_high - radius) < tolerance:
                tags.append(tag)
    return tags


def _read_mesh(
    gmsh: Any, surfaces: dict[str, list[int]]
) -> tuple[NDArray[np.float64], NDArray[np.int64], dict[str, NDArray[np.int64]]]:
    """Take nodes, tetrahedra and named facets out of gmsh, nodes numbered from zero."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.asarray(coordinates, dtype=float).reshape(-1, 3)
    number = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    _, nodes = gmsh.model.mesh.getElementsByType(11)
    elements = number[nodes.astype(np.int64)].reshape(-1, 10)[:, GMSH_TO_SKFEM]
    if len(elements) == 0:
        raise MeshError("gmsh made no tetrahedra for the throw.")
    facets = {}
    for name, surface_tags in surfaces.items():
        parts = [
            number[gmsh.model.mesh.getElementsByType(9, tag)[1].astype(np.int64)].reshape(-1, 6)[
                :, :3
            ]
            for tag in surface_tags
        ]
        facets[name] = np.concatenate(parts) if parts else np.empty((0, 3), dtype=np.int64)
    used, renumbered = np.unique(elements, return_inverse=True)
    order = np.full(len(points), -1, dtype=np.int64)
    order[used] = np.arange(len(used))
    return (
        points[used],
        renumbered.reshape(elements.shape),
        {k: order[v] for k, v in facets.items()},
    )


def smallest_jacobians(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Smallest ratio (m,) of the Jacobian at any node to the straight element's mean one."""
    _, gradients = shapes_at_nodes()
    determinant = np.linalg.det(jacobians(gradients, points[elements]))
    return np.asarray(determinant.min(axis=1) / np.abs(determinant).mean(axis=1))


def _mend(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> tuple[NDArray[np.float64], int]:
    """Straighten the edges of elements that curving turned inside out.

    Straightening one element changes its neighbors, so the check is repeated.
    """
    points = points.copy()
    mended: set[int] = set()
    for _ in range(10):
        bad = np.flatnonzero(smallest_jacobians(points, elements) < 0.05)
        if len(bad) == 0:
            return points, len(mended)
        mended.update(bad.tolist())
        for node, (first, second) in enumerate(EDGES, start=4):
            middles = elements[bad, node]
            points[middles] = 0.5 * (points[elements[bad, first]] + points[elements[bad, second]])
    raise MeshError(
        f"{len(bad)} elements of the throw's mesh stay inside out after straightening their edges."
    )


def _check_volume(mesh: ThrowMesh) -> None:
    volume = float(element_volumes(mesh.points, mesh.elements).sum())
    if not math.isclose(volume, mesh.solid_volume, rel_tol=2e-3):
        raise MeshError(
            f"the mesh has a volume of {volume:.6g} m^3, the solid {mesh.solid_volume:.6g} m^3: "
            "they differ by more than 0.2 %."
        )


def element_volumes(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Volumes (m,) of straight or curved 10-node tetrahedra [m^3]."""
    return np.asarray(
        element_quadrature(points, elements)[1].reshape(len(elements), -1).sum(axis=1)
    )


def element_quadrature(
    points: NDArray[np.float64], elements: NDArray[np.int64], order: int = 5
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Quadrature points (p, 3) and their volumes (p,) over all elements."""
    values, gradients, weights = shapes_for_quadrature(order)
    corners = points[elements]
    volumes = np.linalg.det(jacobians(gradients, corners)) * weights
    return (values[None] @ corners).reshape(-1, 3), volumes.ravel()
