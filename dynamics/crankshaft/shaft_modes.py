"""Natural modes of a whole crankshaft, told apart by their axial, torsional and bending shares."""

from dataclasses import dataclass, field

import numpy as np

from dynamics.checks import FloatArray, positive_vector
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.stations import CLASSES
from dynamics.response.linear_system import natural_modes

# A mode is called pure above this share of one class.
PURE = 0.95


@dataclass(frozen=True, eq=False)
class ShaftModes:
    """Natural modes, ascending: rigid motions first, then all elastic modes.

    Attributes
    ----------
    angular_frequencies : (q,) array
        [rad/s]; exactly 0 for rigid motions.
    shapes : (u, q) array
        Of the unknowns; rigid motions of unit translation or rotation, elastic modes of unit modal mass.
    rigid : int
        Number of rigid motions.
    names : tuple of q str
        What rigid motion it is; "mode 1" and so on for elastic ones.
    shares : (3, q) array
        Axial, torsional and bending share of the energy, of sum 1; see `Stations.energy_shares`.
    motions : (s, 6, q) array
        Of the stations: displacements, rotations, in the shaft's frame.
    positions : (s,) array
        Of the stations along the shaft [m].
    """

    angular_frequencies: FloatArray
    shapes: FloatArray = field(repr=False)
    rigid: int
    names: tuple[str, ...]
    shares: FloatArray
    motions: FloatArray = field(repr=False)
    positions: FloatArray = field(repr=False)

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies [Hz], (q,)."""
        return self.angular_frequencies / (2.0 * np.pi)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The class with the largest share of each mode, "axial", "torsional" or "bending"."""
        return tuple(CLASSES[place] for place in np.argmax(self.shares, axis=0))

    def label(self, mode: int) -> str:
        """Say what a mode is: its classes with 5 % or more, the largest first."""
        order = np.argsort(-self.shares[:, mode])
        parts = [
            f"{CLASSES[kind]} {100.0 * self.shares[kind, mode]:.0f} %"
            for kind in order
            if self.shares[kind, mode] >= 1.0 - PURE
        ]
        return ", ".join(parts)

    def first(self, kind: str) -> int:
        """Return the lowest elastic mode in which a class has the largest share.

        Raises
        ------
        ValueError
            If there is no such class.
        """
        if kind not in CLASSES:
            raise ValueError(f"{kind!r} is none of {', '.join(CLASSES)}")
        return self.kinds.index(kind, self.rigid)


def crankshaft_modes(shaft: AssembledShaft) -> ShaftModes:
    """Find all natural modes of a crankshaft without its damping.

    Parameters
    ----------
    shaft : AssembledShaft

    Returns
    -------
    ShaftModes
    """
    natural, shapes = natural_modes(shaft.mass, shaft.stiffness, shaft.rigid)
    rigid = shaft.rigid.shape[1]
    # Of rigid motions any combinations are modes; the plain ones have names.
    shapes = np.column_stack((shaft.rigid, shapes[:, rigid:]))
    elastic = natural.size - rigid
    return ShaftModes(
        angular_frequencies=natural,
        shapes=shapes,
        rigid=rigid,
        names=(*shaft.rigid_names, *(f"mode {number + 1}" for number in range(elastic))),
        shares=shaft.stations.energy_shares(shapes, shaft.added, shaft.added_inertia),
        motions=np.einsum("siu,uk->sik", shaft.stations.motions, shapes),
        positions=shaft.stations.positions,
    )


def rotation_ratio(speed: float, angular_frequencies: FloatArray) -> FloatArray:
    """Return speed of rotation over natural frequency: how much the rotating frame can matter.

    Parameters
    ----------
    speed : float
        Of the shaft [rad/s].
    angular_frequencies : ndarray of shape (m,)
        Of elastic modes [rad/s], above zero.

    Returns
    -------
    ndarray of shape (m,)
        r. A mode of bending that is alike in both planes has the frequencies w (1 +- r) in the rotating
        frame, w in the fixed one; the lateral part of modes of torsion and axial motion feels Coriolis'
        forces of the relative size 2 r and centrifugal ones of r^2, which change a frequency by the
        order of r^2 times the share of lateral motion.
    """
    return speed / positive_vector(
        "angular_frequencies", angular_frequencies, "rad/s", "rigid motions have no ratio"
    )
