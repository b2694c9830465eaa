"""A shaft line that bends: Timoshenko's beams in a row behind the flywheel, on bearings."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from crankbase.array_checks import Array, nonnegative_number
from crankbase.choices import check_some, so_many
from crankbase.errors import InputError
from crankbase.sentences import in_si
from crankbase.summaries import frozen
from dynamics.chains.shaft_line import ShaftCone

# An element is as long as its piece's least diameter, within these shares of the line.
LEAST, MOST = 1.0 / 50.0, 1.0 / 12.0
# Bearings this near to a joint, as a share of the line's length, stand at it.
AT_JOINT = 1e-6
# Points and weights that integrate polynomials up to degree 7 from 0 to 1 exactly.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
POINTS, WEIGHTS = 0.5 * (POINTS + 1.0), 0.5 * WEIGHTS


@frozen("length [m]", "pieces", "bearings")
class LineBeam:
    """Pieces of shaft in a row, which bend and shear alike in all planes, from the flywheel on.

    Parameters
    ----------
    pieces : tuple of n ShaftCone
        The first one begins at the flywheel's center of mass, and moves with it.
    masses, inertias : tuple of n + 1 float
        Of bodies at the ends and joints: mass that moves across the shaft [kg], moment of inertia about it
        [kg m^2]; that about a diameter is half of this, as of a thin disc.
    bearings : tuple of pairs of float
        Place, from the beginning of the line [m], and lateral stiffness [N/m] of each.

    Raises
    ------
    InputError
        If there is no piece, numbers do not fit, or a bearing stands beside the line.
    """

    pieces: tuple[ShaftCone, ...]
    masses: tuple[float, ...] = field(repr=False)
    inertias: tuple[float, ...] = field(repr=False)
    bearings: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        check_some("pieces", self.pieces, "a line has pieces of shaft")
        for name, values in (("masses", self.masses), ("inertias", self.inertias)):
            if len(values) != len(self.pieces) + 1:
                raise InputError(
                    f"{name}: given {so_many(len(values))}; allowed are {len(self.pieces) + 1}, because "
                    "pieces in a row have so many ends and joints."
                )
            for value in values:
                nonnegative_number(
                    name, value, "kg" if name == "masses" else "kg m^2", "it is a body's"
                )
        for place, stiffness in self.bearings:
            nonnegative_number("bearings", stiffness, "N/m", "a bearing does not drive the shaft")
            if not 0.0 <= place <= self.length * (1.0 + AT_JOINT):
                raise InputError(
                    f"bearings: given one at {in_si(place, 'm')}; allowed is 0 to {in_si(self.length, 'm')}, "
                    "because the line that bends is so long."
                )

    @property
    def length(self) -> float:
        """Of all pieces [m]."""
        return math.fsum(piece.length for piece in self.pieces)

    @cached_property
    def bending(self) -> "PlaneBending":
        """Its matrices in one plane."""
        parts = [part for number in range(len(self.pieces)) for part in self._parts(number)]
        places = np.cumsum([0.0, *(part.length for part in parts)])
        size = 2 * len(places)
        mass, springs = np.zeros((size, size)), []
        for number, part in enumerate(parts):
            nodes = slice(2 * number, 2 * number + 4)
            of_part, rows = beam_element(part)
            mass[nodes, nodes] += of_part
            springs.append(np.zeros((2, size)))
            springs[-1][:, nodes] = rows
        joints = np.cumsum([0.0, *(piece.length for piece in self.pieces)])
        for joint, body, inertia in zip(joints, self.masses, self.inertias, strict=True):
            node = 2 * int(np.argmin(np.abs(places - joint)))
            mass[[node, node + 1], [node, node + 1]] += body, 0.5 * inertia
        for place, stiffness in self.bearings:
            springs.append(np.zeros((1, size)))
            springs[-1][0, 2 * int(np.argmin(np.abs(places - place)))] = math.sqrt(stiffness)
        return PlaneBending(places, mass, np.vstack(springs))

    def _parts(self, number: int) -> Iterator[ShaftCone]:
        """Divide a piece at bearings, and into elements."""
        piece, start = self.pieces[number], math.fsum(each.length for each in self.pieces[:number])
        near = AT_JOINT * self.length
        inside = {
            place - start
            for place, _ in self.bearings
            if start + near < place < start + piece.length - near
        }
        thin = min(piece.left_diameter, piece.right_diameter)
        longest = min(max(thin, LEAST * self.length), MOST * self.length)
        for left, right in pairwise([0.0, *sorted(inside), piece.length]):
            yield from piece.between(left, right).divided(math.ceil((right - left) / longest))


@dataclass(frozen=True, eq=False)
class PlaneBending:
    """A line in one plane; unknowns are the deflection and the slope of each node, along the line.

    Attributes
    ----------
    places : (n,) array
        Of the nodes, from the beginning of the line [m].
    mass : (2 n, 2 n) array
    springs : (r, 2 n) array
        Rows whose squares are twice the strain energy of beams and bearings.
    """

    places: Array
    mass: Array
    springs: Array

    @property
    def stiffness(self) -> Array:
        """(2 n, 2 n) array."""
        return np.asarray(self.springs.T @ self.springs)


def beam_element(part: ShaftCone) -> tuple[Array, Array]:
    """Return the consistent mass (4, 4) of a short piece of shaft, and its springs (2, 4).

    Notes
    -----
    The shapes are those of the deflection w and the rotation t of the cross sections under end loads, with
    shear: phi = 12 E I / (kappa G A L^2), kappa of a round cross section by Cowper (1966). The strain
    energy is that of two springs, exactly:

        E I / L                            on t_2 - t_1
        12 E I / (L^3 (1 + phi))           on w_2 - w_1 - L (t_1 + t_2) / 2

    A and I of a cone are those with its compliances along and about the axis, mass and inertia its own.
    """
    length, material = part.length, part.material
    young, shear = material.youngs_modulus, material.shear_modulus
    area = length / (young * part.axial_compliance)
    bending = young * 0.5 * length / (shear * part.torsional_compliance)
    # Cowper's coefficient of a round or hollow cross section, in the middle of the piece.
    poisson = 0.5 * young / shear - 1.0
    half = part.between(0.5 * length, length)
    hollow = (half.bore / half.left_diameter) ** 2
    thick = (7.0 + 6.0 * poisson) * (1.0 + hollow) ** 2 + (20.0 + 12.0 * poisson) * hollow
    kappa = 6.0 * (1.0 + poisson) * (1.0 + hollow) ** 2 / thick
    phi = 12.0 * bending / (kappa * shear * area * length**2)
    tilt = math.sqrt(bending / length) * np.array([0.0, -1.0, 0.0, 1.0])
    across = np.array([-1.0, -0.5 * length, 1.0, -0.5 * length])
    across *= math.sqrt(12.0 * bending / (length**3 * (1.0 + phi)))
    x = POINTS
    bow, hump, slope = x**2 * (3.0 - 2.0 * x), x - x**2, 6.0 * (x - x**2) / length
    deflection = np.array(
        [
            1.0 - bow + phi * (1.0 - x),
            length * hump * (1.0 - x + 0.5 * phi),
            bow + phi * x,
            -length * hump * (x + 0.5 * phi),
        ]
    )
    rotation = np.array(
        [
            -slope,
            1.0 - 4.0 * x + 3.0 * x**2 + phi * (1.0 - x),
            slope,
            3.0 * x**2 - 2.0 * x + phi * x,
        ]
    )
    mass = part.mass * (deflection * WEIGHTS) @ deflection.T
    mass += 0.5 * part.polar_inertia * (rotation * WEIGHTS) @ rotation.T
    return mass / (1.0 + phi) ** 2, np.array([tilt, across])
