"""Meshes refined in place: each element divided into eight on its own curved shape.

Whatever quadratic displacements the coarse mesh has, the refined one has too.
"""

from dataclasses import replace

import numpy as np

from geometry.shapes import EDGES

# An element's ten nodes by their shares of its four corners.
NODES = np.vstack([np.eye(4), [0.5 * (np.eye(4)[a] + np.eye(4)[b]) for a, b in EDGES]])
# Corners of the eight parts of an element among its ten nodes, and of the four of a face among its six.
PARTS = np.array(
    [
        [0, 4, 6, 7],
        [4, 1, 5, 8],
        [6, 5, 2, 9],
        [7, 8, 9, 3],
        [6, 8, 4, 5],
        [6, 8, 5, 9],
        [6, 8, 9, 7],
        [6, 8, 7, 4],
    ]
)
FACE_PARTS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
FACE_NODES = np.array([[4, 0, 0], [0, 4, 0], [0, 0, 4], [2, 2, 0], [0, 2, 2], [2, 0, 2]])


def shape_functions(shares):
    """Values (p, 10) of an element's shape functions at points given by shares (p, 4) of its corners."""
    corners = shares * (2.0 * shares - 1.0)
    edges = np.column_stack([4.0 * shares[:, a] * shares[:, b] for a, b in EDGES])
    return np.hstack([corners, edges])


def names(nodes, quarters):
    """Names (..., k) of points by their quarters of nodes: the same from every element and face."""
    return np.sort(np.where(quarters > 0, 5 * (nodes + 1) + quarters, 0), axis=-1)


def refined(mesh):
    """Divide each element into eight on its own curved shape.

    Returns
    -------
    ThrowMesh
    callable
        Takes values (n, ...) at the nodes of the coarse mesh to those of the fine one.
    """
    parts = NODES[PARTS]
    middles = 0.5 * (parts[:, [a for a, _ in EDGES]] + parts[:, [b for _, b in EDGES]])
    shares = np.concatenate([parts, middles], axis=1).reshape(-1, 4)
    shapes = shape_functions(shares)
    named = names(mesh.elements[:, None, :4], np.rint(4.0 * shares).astype(int)).reshape(-1, 4)
    kept, first, number = np.unique(named, axis=0, return_index=True, return_inverse=True)
    numbered = {tuple(name): place for place, name in enumerate(kept.tolist())}
    owner, place = np.divmod(first, len(shares))

    def taken(values):
        return np.einsum("fs,fs...->f...", shapes[place], values[mesh.elements[owner]])

    def divided(faces):
        named = names(faces[:, None], FACE_NODES)
        named = np.pad(named, ((0, 0), (0, 0), (1, 0))).reshape(-1, 4)
        nodes = np.array([numbered[tuple(name)] for name in named.tolist()]).reshape(-1, 6)
        return nodes[:, FACE_PARTS].reshape(-1, 3)

    fine = replace(
        mesh,
        points=taken(mesh.points),
        elements=number.reshape(-1, 10),
        surfaces={name: divided(faces) for name, faces in mesh.surfaces.items()},
    )
    return fine, taken
