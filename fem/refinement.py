"""Local refinement of a mesh for a required error."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fem.recovery import EnergyErrors
from geometry.mesh import ThrowMesh
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners

Array = NDArray[np.float64]

# Squared energy error of second-order elements falls with the fourth power of their size where the
# stress is smooth, with the first or second at a sharp corner. This power in between makes as good
# meshes as the fourth does, and comes closer to the wished error at once.
ORDER = 2.5
# gmsh makes elements somewhat larger than a map says.
MADE_SMALLER = 0.83
# Sizes change at most by these factors at once, and grow by at most this per unit of distance.
MOST_REFINED, MOST_COARSENED = 0.2, 1.5
GROWTH = 0.6
SIZE_STEP = 1e-3


def refined_sizes(mesh: ThrowMesh, errors: EnergyErrors, target: float) -> SizeMap:
    """Sizes with which the fewest elements have a total error energy of `target`.

    Where the squared error of an element falls with the power p of its size and the space has three
    dimensions, the number of elements sum(r^-3) is least, for a given sum of e r^p over the old
    elements, if r is proportional to e^(-1 / (p + 3)) (X. D. Li and P. Bettess, Commun. Numer. Meth.
    Engng 11, 857-868 and 911-915, 1995).

    Parameters
    ----------
    mesh : ThrowMesh
    errors : EnergyErrors
        Of its solution.
    target : float
        Required error as a share of the energy.

    Returns
    -------
    SizeMap
    """
    corners = mesh.elements[:, :4]
    sizes = element_sizes(mesh.points, corners)
    shares = np.maximum(errors.elements, 1e-12 * errors.elements.max()) / errors.energy
    ratios = shares ** (-1.0 / (ORDER + 3.0))
    ratios *= (target / np.sum(shares * ratios**ORDER)) ** (1.0 / ORDER)
    wished = MADE_SMALLER * sizes * np.clip(ratios, MOST_REFINED, MOST_COARSENED)

    # The mean at the corners; the smallest would refine two layers for one element.
    nodal = sizes_at_corners(mesh.points, corners, wished)
    graded = _limit_size_growth(nodal.points, nodal.tetrahedra, nodal.sizes)
    # Sizes of few digits: rounding in the solution must not become another mesh.
    steps = np.round(np.log(graded / mesh.length) / SIZE_STEP)
    return replace(nodal, sizes=mesh.length * np.exp(SIZE_STEP * steps))


def _limit_size_growth(points: Array, tetrahedra: NDArray[np.int64], sizes: Array) -> Array:
    """Limit how fast sizes grow from where they are small."""
    pairs = np.array([(i, j) for i in range(4) for j in range(4) if i != j])
    start, stop = tetrahedra[:, pairs[:, 0]].ravel(), tetrahedra[:, pairs[:, 1]].ravel()
    lengths = np.linalg.norm(points[start] - points[stop], axis=1)
    sizes = sizes.copy()
    for _ in range(100):
        before = sizes.copy()
        np.minimum.at(sizes, stop, sizes[start] + GROWTH * lengths)
        if np.array_equal(before, sizes):
            break
    return sizes
