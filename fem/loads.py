"""Loads on the pins: a force spread uniformly over a pin's cylindrical surface."""

import numpy as np
from numpy.typing import NDArray
from skfem import ElementTriP2, MeshTri1
from skfem.quadrature import get_quadrature

from geometry.facets import six_node_triangles
from geometry.mesh import ThrowMesh
from geometry.mesher import Throw

# Direction of a radial force on the first pin, towards the shaft.
RADIAL = np.array([0.0, -1.0, 0.0])


def uniform_pin_loads(mesh: ThrowMesh) -> NDArray[np.float64]:
    """Share of each node in a unit force spread uniformly over the meshed surface of each pin.

    Parameters
    ----------
    mesh : ThrowMesh

    Returns
    -------
    (pins, n) array
        Integrals of the shape functions over the pin's surface, divided by its area; each pin's sum
        to 1.
    """
    return np.array([_uniform_load(mesh, mesh.surfaces[pin]) for pin in mesh.pins])


def radial_directions(throw: Throw) -> NDArray[np.float64]:
    """Directions (pins, 3) from each pin's axis to the shaft."""
    axes = np.array([(*axis, 0.0) for axis in throw.pin_axes])
    return np.asarray(-axes / np.linalg.norm(axes, axis=1)[:, None])


def _uniform_load(mesh: ThrowMesh, corners: NDArray[np.int64]) -> NDArray[np.float64]:
    triangles = six_node_triangles(mesh, corners)
    where, weights = get_quadrature(MeshTri1.elem.refdom, 5)
    element = ElementTriP2()
    values = np.array([element.lbasis(where, i)[0] + np.zeros(where.shape[1]) for i in range(6)])
    slopes = np.array([element.lbasis(where, i)[1] + np.zeros_like(where) for i in range(6)])
    tangents = np.einsum("aiq,taj->tqij", slopes, mesh.points[triangles])
    areas = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * weights
    shares = np.zeros(len(mesh.points))
    np.add.at(shares, triangles, areas @ values.T)
    return np.asarray(shares / shares.sum())
