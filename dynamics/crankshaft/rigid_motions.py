"""Motions of a whole crankshaft that no stiffness resists."""

import numpy as np
from crankbase.checks.arrays import FloatArray

from dynamics.crankshaft.shaft_throw import RX, RY, RZ, UX, UY, UZ
from dynamics.crankshaft.surroundings import ShaftSurroundings, TorsionalRing


def rings_of(around: ShaftSurroundings, count: int) -> list[tuple[TorsionalRing, int]]:
    """Return damper ring and driven machine, as far as given, with the section that each turns with."""
    places = ((around.ring, 0), (around.machine, count - 1))
    return [(ring, section) for ring, section in places if ring is not None]


def rigid_motions(
    around: ShaftSurroundings, places: FloatArray, size: int
) -> tuple[FloatArray, tuple[str, ...]]:
    """Find the motions that no stiffness resists.

    Parameters
    ----------
    around : ShaftSurroundings
    places : ndarray of shape (n + 1,)
        Of the sections along the shaft [m].
    size : int
        Number of unknowns: six for each section, shapes, and one for each ring.

    Returns
    -------
    motions : ndarray of shape (size, r)
        As columns; those of unit rotation or translation, exact.
    names : tuple of r str
    """
    found: dict[str, FloatArray] = {}
    sections = np.arange(len(places))

    def motion(values: dict[int, FloatArray | float]) -> FloatArray:
        column = np.zeros(size)
        for component, value in values.items():
            column[6 * sections + component] = value
        return column

    rings = rings_of(around, len(places))
    turning = motion({RZ: 1.0})
    alone = {}
    for number, (ring, section) in enumerate(rings):
        row = size - len(rings) + number
        if ring.stiffness > 0.0:
            turning[row] = 1.0
        else:
            alone["ring" if section == 0 else "driven machine"] = row
    found["rotation about the shaft axis"] = turning
    for name, row in alone.items():
        found[f"rotation of the {name} alone"] = np.eye(size)[row]
    if not any(support.stiffness > 0.0 for support in around.axial_supports):
        found["axial translation"] = motion({UZ: 1.0})
    holding = np.zeros(len(places))
    if around.bearings is not None:
        holding = around.bearings.at(len(places))[0]
    bearings = np.flatnonzero(holding > 0.0)
    if bearings.size == 0:
        found["translation along x"] = motion({UX: 1.0})
        found["translation along y"] = motion({UY: 1.0})
    if bearings.size <= 1:
        arms = places - (places[bearings[0]] if bearings.size else places.mean())
        found["tilt about x"] = motion({RX: 1.0, UY: -arms})
        found["tilt about y"] = motion({RY: 1.0, UX: arms})
    return np.column_stack(list(found.values())), tuple(found)
