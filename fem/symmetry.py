"""Symmetry classes: how the motions of a whole throw follow from its quarter.

Any motion of a throw with equal webs is a sum of four parts, each symmetric or antisymmetric about
the crank plane (x = 0) and about the middle plane of the pin. Each part is one problem on the
quarter, with displacements blocked on the cuts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# A mirror reverses the displacement across it, and the rotations about the axes along it.
MIRROR_X = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
MIRROR_Z = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True)
class SymmetryClass:
    """One of the four parts of a motion.

    Attributes
    ----------
    crank_plane, middle_plane : int
        +1 symmetric, -1 antisymmetric about that plane.
    """

    crank_plane: int
    middle_plane: int

    @property
    def end_unknowns(self) -> tuple[int, int, int]:
        """The unknowns (of ux uy uz rx ry rz) that an end section has in this class."""
        kept = np.flatnonzero(self.crank_plane == MIRROR_X)
        return int(kept[0]), int(kept[1]), int(kept[2])

    @property
    def ends(self) -> NDArray[np.float64]:
        """Motions (12, 3) of both end sections for unit motions of the left one."""
        motions = np.zeros((12, 3))
        for column, unknown in enumerate(self.end_unknowns):
            motions[unknown, column] = 1.0
            motions[6 + unknown, column] = self.middle_plane * MIRROR_Z[unknown]
        return motions

    def blocked_axes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Displacements blocked on the crank plane and on the middle plane."""
        return (
            (0,) if self.crank_plane > 0 else (1, 2),
            (2,) if self.middle_plane > 0 else (0, 1),
        )


AXIAL = SymmetryClass(1, 1)
TORSIONAL = SymmetryClass(-1, -1)
ALL_CLASSES = (AXIAL, SymmetryClass(1, -1), SymmetryClass(-1, 1), TORSIONAL)
