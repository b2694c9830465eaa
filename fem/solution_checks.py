"""Checks of a solved throw in every run: reciprocity, rigid motions, definiteness, balance.

Rotations are measured as length x angle, so that all figures are shares. Figures of round-off are below
1e-11 for throws of all kinds (tests/campaigns/random_throws.py draws such); an error of 1e-6 in a
solution appears as about the same figure.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import SolveError
from fem.loads import rigid_motions

Array = NDArray[np.float64]

# Every solution leaves at most 1e-9 of its right side; what is checked is made of a few solutions.
LARGEST_ROUND_OFF = 1e-8
# Energies against forces at the ends: throws of engines leave 1e-11, journals of 0.04 crank radii 1e-8.
LARGEST_DIFFERENCE = 1e-6
# The softest elastic motion of a throw has 1e-2 of the energy of the stiffest, of sections that bend 1e-4.
SMALLEST_ENERGY = 1e-7
RIGID_MOTIONS = 6


def rigid_body_motions(count: int = 12) -> Array:
    """Return the rigid-body motions (count, 6) of two end sections, rotations as length x angle.

    `count` is 12, or 12 + 2 b where sections bend; then these do not.
    """
    motions = np.zeros((count, RIGID_MOTIONS))
    motions[:6], motions[6:12] = np.eye(6), np.eye(6)
    # Turned about x or y through the left end section, the right one is carried along.
    motions[6, 4], motions[7, 3] = 1.0, -1.0
    return motions


def scaled_stiffness(stiffness: ArrayLike, length: float) -> Array:
    """Return a stiffness (n, n) in N/m alone, with rotations measured as length x angle."""
    given = np.asarray(stiffness, dtype=float)
    size = _sizes(len(given), length)
    return given * np.outer(size, size)


def rigid_body_residual(stiffness: ArrayLike, length: float) -> float:
    """Return the largest force caused by a rigid-body motion, relative to the largest stiffness.

    Parameters
    ----------
    stiffness : (12, 12) array
        ux uy uz rx ry rz of the left, then the right end section [SI]; more rows if sections bend.
    length : float
        Between the end sections [m].
    """
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled @ rigid_body_motions(len(scaled)))) / np.max(np.abs(scaled)))


def asymmetry(stiffness: ArrayLike, length: float) -> float:
    """Return the largest difference between K and its transpose, relative to the largest stiffness."""
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled - scaled.T)) / np.max(np.abs(scaled)))


def check_reciprocity(
    ends: Array, stiffness: tuple[Array, Array], pin_loads: tuple[Array, Array], length: float
) -> None:
    """Refuse a solved symmetry class with different results for stiffness and pin loads in two ways.

    Energies of fields and forces on the end sections come from different solutions, equal by reciprocity
    as far as these are in equilibrium.

    Parameters
    ----------
    ends : (2 n, k) array
        Motions of both end sections for unit amplitudes.
    stiffness : two (k, k) arrays
        By energies, and by the forces on the end sections.
    pin_loads : two (pins, k, 6) arrays
        By work on the pins, and by reactions at the end sections.
    length : float
        Of the throw [m].

    Raises
    ------
    SolveError
    """
    turns = np.abs(ends[[3, 4, 5, 9, 10, 11]]).any(axis=0)
    size = np.where(turns, 1.0 / length, 1.0)
    energies, forces = (one * np.outer(size, size) for one in stiffness)
    works, reactions = (one * size[:, None] * _unit(length) for one in pin_loads)
    apart = np.max(np.abs(forces - energies)) / np.max(np.abs(energies))
    off = np.max(np.abs(reactions - works), initial=0.0)
    _check(
        "Reciprocity of the throw's end forces is off by",
        float(np.maximum(apart, off)),
        LARGEST_DIFFERENCE,
    )


def check_superelement(
    stiffness: Array, pin_loads: Array, length: float, pin_centers: Sequence[Array]
) -> None:
    """Refuse a superelement that is not a free elastic body, or whose reactions do not balance a load.

    Parameters
    ----------
    stiffness, pin_loads
        As of a `fem.superelement.Superelement`.
    length : float
        Between the end sections [m].
    pin_centers : sequence of (3,) arrays
        About which moments on the pins are given [m].

    Raises
    ------
    SolveError
        If the stiffness is not finite and symmetric, resists a rigid motion or does not resist another, or
        if forces and moments on the ends do not balance a unit load on a pin.
    """
    _check("The throw's stiffness is unsymmetric by", asymmetry(stiffness, length))
    _check("Rigid motions of the throw meet forces of", rigid_body_residual(stiffness, length))
    energies = strain_energies(stiffness, length)
    softest = float(energies[RIGID_MOTIONS])
    if not softest >= SMALLEST_ENERGY:
        raise SolveError(
            f"The softest elastic motion of the throw has {softest:.1e} of the strain energy of the stiffest "
            f"(allowed {SMALLEST_ENERGY:.0e} or more): its stiffness is not positive definite."
        )
    _check(
        "Reactions of the throw leave an unbalanced share of a pin's load of",
        unbalanced_pin_loads(pin_loads, length, pin_centers),
    )


def strain_energies(stiffness: ArrayLike, length: float) -> Array:
    """Strain energies (n,) of unit motions along the principal axes of K, ascending, the largest 1.

    The first six are those of rigid motions.
    """
    scaled = scaled_stiffness(stiffness, length)
    energies = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return np.asarray(energies / energies[-1])


def unbalanced_pin_loads(pin_loads: Array, length: float, pin_centers: Sequence[Array]) -> float:
    """Largest difference of the end loads of a unit load on a pin from its force or moment, as a share.

    In a rigid motion the end loads must do the work of the load itself.
    """
    count, unit = pin_loads.shape[1], _unit(length)
    motions = rigid_body_motions(count)
    left = [0.0]
    for loads, center in zip(pin_loads, pin_centers, strict=True):
        at_pin = np.zeros((6, 6))
        at_pin[:3] = rigid_motions(np.asarray(center)[None])[0] * unit
        at_pin[3:, 3:] = np.diag(unit[3:])
        work = (loads * _sizes(count, length)[:, None]).T @ motions
        left.append(float(np.max(np.abs((work - at_pin) / unit[:, None]))))
    return float(np.max(left))


def _sizes(count: int, length: float) -> Array:
    """Sizes (count,) of unit motions of both ends: rotations times length are 1."""
    return np.concatenate([np.tile(_unit(length), 2), np.ones(count - 12)])


def _unit(length: float) -> Array:
    return np.array([1.0, 1.0, 1.0, *[1.0 / length] * 3])


def _check(what: str, figure: float, allowed: float = LARGEST_ROUND_OFF) -> None:
    if not figure <= allowed:
        raise SolveError(
            f"{what} {figure:.1e} (allowed {allowed:.0e}): the equations are not solved accurately."
        )
