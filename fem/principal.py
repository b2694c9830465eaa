"""Principal stresses and the equivalent stress of von Mises of a stress tensor."""

import numpy as np
from numpy.typing import NDArray

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
