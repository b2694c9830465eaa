"""Description of a mode from the motions of the end sections."""

import numpy as np
from numpy.typing import NDArray

from fem.condensation import unit_end_motions
from fem.superelement import RX, RY, RZ, UX, UY, UZ
from fem.symmetry import MIRROR_X, MIRROR_Z, SymmetryClass
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]

# Kinds of motion of an end section, and how a mode is named after them (see `name_of_motion`).
KINDS = {"bending": [UX, UY, RX, RY], "axial": [UZ], "torsion": [RZ]}
EVIDENT = 0.9
PURE = 0.999


def end_motions_of(mesh: ThrowMesh, symmetry: SymmetryClass, shape: Array) -> Array:
    """Motions (12,) of both end sections that best fit a displacement (n, 3) of the meshed part."""
    nodes, motions = zip(*unit_end_motions(mesh, symmetry), strict=True)
    columns = np.concatenate(motions).reshape(-1, symmetry.ends.shape[1])
    fit = np.linalg.lstsq(columns, shape[np.concatenate(nodes)].ravel(), rcond=None)
    return np.asarray(symmetry.ends @ fit[0])


def name_of_motion(motions: Array, length: float) -> str:
    """Describe a mode from the motions of the end sections.

    Rotations count as displacements at a distance of half the throw's length, shares are of the sum of
    squares. Two kinds of motion are named unless one has 90 %; a plane, and a symmetry about the
    throw's middle, only where the motion has nothing else.

    Parameters
    ----------
    motions : (12,) array
        Of the left, then the right end section [m, rad].
    length : float
        Of the throw [m].
    """
    scaled = motions * np.tile([1.0, 1.0, 1.0, *[0.5 * length] * 3], 2)
    total = float(scaled @ scaled)
    if total == 0.0:
        return "end sections at rest"
    squares = (scaled**2).reshape(2, 6).sum(axis=0) / total
    shares = {kind: float(squares[places].sum()) for kind, places in KINDS.items()}
    first, second = sorted(shares, key=lambda kind: shares[kind], reverse=True)[:2]
    name = first if shares[first] >= EVIDENT else f"{first} with {second}"
    for mirrored, symmetric, antisymmetric in (
        (np.tile(MIRROR_X, 2) * scaled, " in the crank plane", " across the crank plane"),
        (np.roll(np.tile(MIRROR_Z, 2) * scaled, 6), ", symmetric", ", antisymmetric"),
    ):
        parity = float(mirrored @ scaled) / total
        if abs(parity) >= PURE:
            name += symmetric if parity > 0.0 else antisymmetric
    return name
