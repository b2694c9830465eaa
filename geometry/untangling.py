"""Rounder tetrahedra by moving their corners: those that are inside out turn, flat ones become thicker.

The sum over elements of the squared inverse mean ratio, (|S|^2 / (3 det(S)^(2/3)))^2, becomes least. S maps
the regular tetrahedron of an element's size to the element; instead of det(S) it takes a positive function of
it, so that it is smooth where elements are inside out (J. M. Escobar et al., Simultaneous untangling and
smoothing of tetrahedral meshes, Comput. Methods Appl. Mech. Eng. 192, 2003, 2775-2787).
"""

import numpy as np

from crankbase.array_checks import Array, Integers

# Gradients (4, 3) of the linear shape functions in a regular tetrahedron of volume 1/6.
_SIDES = np.array([[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]]) * 2.0 ** (-1 / 3)
_GRADIENTS = np.vstack([-np.ones(3), np.eye(3)]) @ np.linalg.inv(_SIDES).T
# Volumes, in those of elements of their size, which count as positive; the least change for them.
POSITIVE, LEAST_CHANGE = 0.05, 1e-4
MOST_ITERATIONS = 60


def untangle(points: Array, elements: Integers, free: Array, sizes: Array) -> Array:
    """Move corners of tetrahedra so that these become rounder.

    Parameters
    ----------
    points : (n, 3) array
    elements : (m, 4) array
        All tetrahedra round the corners that move.
    free : (n, 3, 3) array
        Projections on the directions in which points may move; zero for those that stay.
    sizes : (m,) array
        Of the elements: cube root of six times the volume that they should have about [m].

    Returns
    -------
    (n, 3) array
    """
    from scipy.optimize import minimize  # here: loading it takes long, and few meshes need it

    def maps(at: Array) -> Array:
        return np.asarray(np.einsum("ne,mni->mie", _GRADIENTS, at[elements]) / sizes[:, None, None])

    # Motions in the size of the smallest element round each corner.
    reach = np.full(len(points), np.inf)
    np.minimum.at(reach, elements, np.broadcast_to(sizes[:, None], elements.shape))
    here = np.flatnonzero(free.any(axis=(1, 2)))
    turned = reach[here, None, None] * free[here]

    def moved(motion: Array) -> Array:
        at = points.copy()
        at[here] += np.einsum("nab,nb->na", turned, motion.reshape(-1, 3))
        return at

    least = float(np.linalg.det(maps(points)).min())
    change = max(POSITIVE * (POSITIVE - least), LEAST_CHANGE**2)

    def distortion(motion: Array) -> tuple[float, Array]:
        S = maps(moved(motion))
        cofactors = np.cross(S[:, [1, 2, 0]], S[:, [2, 0, 1]])
        determinants = np.sum(S[:, 0] * cofactors[:, 0], axis=1)
        roots = np.sqrt(determinants**2 + 4.0 * change)
        squares = np.sum(S**2, axis=(1, 2))
        ratios = squares / (3.0 * (0.5 * (determinants + roots)) ** (2.0 / 3.0))
        slopes = 2.0 * S / squares[:, None, None] - (2.0 / 3.0) * cofactors / roots[:, None, None]
        slopes *= (2.0 * ratios**2 / sizes)[:, None, None]
        nodal = np.zeros_like(points)
        np.add.at(nodal, elements, np.einsum("mie,ne->mni", slopes, _GRADIENTS))
        return float(np.sum(ratios**2)), np.einsum("nba,nb->na", turned, nodal[here]).ravel()

    found = minimize(
        distortion,
        np.zeros(3 * len(here)),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": MOST_ITERATIONS},
    )
    return moved(found.x)
