"""Volume, center and second moments of a CAD solid, where its faces are splines from a mesh of its surface.

The kernel integrates over splines with a few points, and errs by up to 1 %. By the divergence theorem, with x
from any origin and n out of the solid, the integral over it of a polynomial f of degree k is that of
f x.n / (3 + k) over its surface.
"""

from typing import Any

import numpy as np

from crankbase.array_checks import Array, Integers
from crankbase.errors import MeshError
from geometry.faces import PLAIN_KINDS
from geometry.gmsh_session import forget_array_types
from geometry.mesh import SolidProperties, properties_of

# Up to this share of the surface the kernel does: rounded exits of oil holes are splines, too.
FEW_SPLINES = 0.05
# Six-node triangles round a full circle, and the largest beside the solid's size. With 16, halves of throws
# come out wrong by up to 4e-4, with 20 all by 4e-6.
AROUND, LARGEST = 20.0, 0.1
# Points of a rule along either direction, exact for second moments over six-node triangles.
POINTS = 6
# Options of gmsh for this mesh alone.
SIZES = ("Mesh.MeshSizeFromCurvature", "Mesh.MeshSizeMax", "Mesh.MeshOnlyVisible")


def measured_properties(gmsh: Any, tag: int) -> SolidProperties:
    """Return them for one volume in the model, which has no mesh, in the model's unit of length."""
    sides = gmsh.model.getBoundary([(3, tag)], combined=False, oriented=False)
    areas = np.array([gmsh.model.occ.getMass(2, side) for _, side in sides])
    splines = [gmsh.model.getType(2, side) not in PLAIN_KINDS for _, side in sides]
    if areas[splines].sum() <= FEW_SPLINES * areas.sum():
        return properties_of(gmsh, tag)
    box = np.array(gmsh.model.getBoundingBox(3, tag)).reshape(2, 3)
    options = dict.fromkeys(SIZES, 1.0)
    options |= {SIZES[0]: AROUND, SIZES[1]: LARGEST * float(np.ptp(box, axis=0).max())}
    before = {option: gmsh.option.getNumber(option) for option in SIZES}
    entities = gmsh.model.getEntities()
    try:
        for option, value in options.items():
            gmsh.option.setNumber(option, value)
        gmsh.model.setVisibility(entities, 0)
        gmsh.model.setVisibility([(3, tag)], 1, recursive=True)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        faces = [
            np.asarray(gmsh.model.mesh.getElementsByType(9, side)[1]).reshape(-1, 6)
            for _, side in sides
        ]
    finally:
        gmsh.model.mesh.clear()
        gmsh.model.setVisibility(entities, 1)
        for option, value in before.items():
            gmsh.option.setNumber(option, value)
    forget_array_types()
    order = np.argsort(tags)
    nodes = np.concatenate(_oriented(faces))
    places = order[np.searchsorted(np.asarray(tags)[order], nodes)]
    return _enclosed(np.asarray(coordinates).reshape(-1, 3)[places])


def _oriented(faces: list[Integers]) -> list[Integers]:
    """Turn the triangles (t, 6) of faces that close a solid, each alike within, so that all are alike.

    What the kernel says of a cut's outside is that of the solid on one of its sides. Where two faces meet,
    triangles that are alike run along their common edges in opposite directions.
    """
    runs: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for place, nodes in enumerate(faces):
        edges = nodes[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        keys, first, count = np.unique(
            np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True
        )
        for (low, high), edge in zip(keys[count == 1], edges[first[count == 1]], strict=True):
            runs.setdefault((int(low), int(high)), []).append((place, bool(edge[0] == low)))
    meets: dict[int, dict[int, bool]] = {place: {} for place in range(len(faces))}
    for pair in runs.values():
        if len(pair) == 2:
            (face, forward), (other, onward) = pair
            meets[face][other] = meets[other][face] = forward == onward
    turned = {0: False}
    waiting = [0]
    while waiting:
        face = waiting.pop()
        for other, against in meets[face].items():
            if other not in turned:
                turned[other] = turned[face] != against
                waiting.append(other)
    if len(turned) < len(faces):
        raise MeshError("the faces of the solid do not close it.")
    return [
        nodes[:, [0, 2, 1, 5, 4, 3]] if turned[place] else nodes
        for place, nodes in enumerate(faces)
    ]


def _enclosed(triangles: Array) -> SolidProperties:
    """Integrate over what six-node triangles (t, 6, 3) enclose, all of one sense."""
    roots, weights = np.polynomial.legendre.leggauss(POINTS)
    across, shares = 0.5 + 0.5 * roots, 0.5 * weights
    first, second = (grid.ravel() for grid in np.meshgrid(across, across, indexing="ij"))
    a, b = first, second * (1.0 - first)
    scale = np.outer(shares, shares).ravel() * (1.0 - first)
    c = 1.0 - a - b
    values = np.array(
        [c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * a * c, 4 * a * b, 4 * b * c]
    )
    none = np.zeros_like(a)
    along_a = np.array([1 - 4 * c, 4 * a - 1, none, 4 * (c - a), 4 * b, -4 * b])
    along_b = np.array([1 - 4 * c, none, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b)])
    center = triangles.reshape(-1, 3).mean(axis=0)
    moved = triangles - center
    places, first_way, second_way = (
        np.einsum("nq,tnk->tqk", shape, moved) for shape in (values, along_a, along_b)
    )
    flux = np.einsum("tqk,tqk,q->tq", places, np.cross(first_way, second_way), scale)
    flux *= np.sign(flux.sum())
    volume = float(flux.sum()) / 3.0
    moment = np.einsum("tq,tqk->k", flux, places) / 4.0 / volume
    second_moments = np.einsum("tq,tqk,tql->kl", flux, places, places) / 5.0
    about_center = second_moments - volume * np.outer(moment, moment)
    return SolidProperties(volume, center + moment, about_center)
