"""Throws of a crankshaft by their matrices, and their surroundings: bearings, end bodies, dampers, rods."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_array,
    nonnegative_number,
    positive_number,
    read_only,
)
from crankbase.choices import whole_number
from crankbase.errors import InputError, quoted
from crankbase.results import result
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import TorsionalRing
from dynamics.chains.engine_chains import Kind
from dynamics.chains.shaft_line import DRIVEN
from dynamics.chains.varying import Variation
from dynamics.crankshaft.line_beam import LineBeam

# Motions of a section: displacements, then rotations.
UX, UY, UZ, RX, RY, RZ = range(6)
# Largest difference of a matrix from its transpose, relative to its largest entry.
SYMMETRIC = 1e-8


@result("length [m]", "crank_angle_deg [deg]", "stiffness", "pins")
class ShaftThrow:
    """A throw by its matrices, in its own frame, and its position.

    Parameters
    ----------
    stiffness, mass : array_like of shape (12 + 2 b + m, 12 + 2 b + m)
        Unknowns ux uy uz rx ry rz of the left, then of the right end section (the middles of its
        main journals), then b amplitudes each of the bending of the left and the right section,
        then m amplitudes of internal shapes.
    pin_loads : array_like of shape (p, 12 + 2 b + m, 6)
        Loads on these unknowns equivalent to unit forces along x, y, z on each pin, and unit moments.
        Transposed, they give the pin's mean motion.
    pins : array_like of shape (p, 3)
        Center of each pin in the throw frame [m]; none of a part of the shaft beyond the throws.
    length : float
        From section to section [m].
    crank_angle_deg : float
        Angle of the throw's first pin about +z, counted from +y [deg].
    bending : int
        b: number of motions of a section beyond its mean motions; 0 for rigid sections. Adjacent throws
        share them, so they are in the shaft's frame, whatever the crank angle.

    Raises
    ------
    InputError
        If shapes do not fit, a matrix is not symmetric, or a number is not finite.
    """

    stiffness: Array
    mass: Array
    pin_loads: Array = field(repr=False)
    pins: Array
    length: float
    _: KW_ONLY
    crank_angle_deg: float = 0.0
    bending: int = 0

    def __post_init__(self) -> None:
        for name in ("stiffness", "mass", "pin_loads", "pins"):
            object.__setattr__(self, name, read_only(finite_array(name, getattr(self, name))))
        finite_array("crank_angle_deg", self.crank_angle_deg)
        positive_number("length", self.length, "m", "a throw has a length")
        whole_number("bending", self.bending, 0, "a section has these motions beside its mean ones")
        size, least = len(self.stiffness), 12 + 2 * self.bending
        for name, matrix in (("stiffness", self.stiffness), ("mass", self.mass)):
            if matrix.ndim != 2 or matrix.shape != (size, size) or size < least:
                raise InputError(
                    f"{name}: given an array of shape {matrix.shape}; allowed are square ones of {least} "
                    f"rows or more, stiffness and mass alike, because two end sections have {least} motions."
                )
            if np.max(np.abs(matrix - matrix.T)) > SYMMETRIC * np.max(np.abs(matrix)):
                raise InputError(
                    f"{name}: given a matrix that is not symmetric; allowed are symmetric ones, because they "
                    "belong to an energy."
                )
        if self.pins.ndim != 2 or self.pins.shape[1] != 3:
            raise InputError(
                f"pins: given an array of shape {self.pins.shape}; allowed is (pins, 3), because a "
                "pin's center has three coordinates."
            )
        if np.any(np.hypot(self.pins[:, 0], self.pins[:, 1]) == 0.0):
            raise InputError(
                "pins: given one on the shaft axis; allowed are pins aside of it, because radial and "
                "tangential directions need the pin's radius."
            )
        expected = (len(self.pins), size, 6)
        if self.pin_loads.shape != expected:
            raise InputError(
                f"pin_loads: given an array of shape {self.pin_loads.shape}; allowed is {expected}, "
                "because each pin takes three forces and three moments."
            )

    @property
    def shapes(self) -> int:
        """Number of internal shapes, m."""
        return len(self.stiffness) - 12 - 2 * self.bending

    @property
    def turn(self) -> Array:
        """Matrix (12 + 2 b + m, ...) from motions in the throw frame to those in the shaft frame."""
        turn = np.eye(len(self.stiffness))
        turn[:12, :12] = np.kron(np.eye(4), rotation(math.radians(self.crank_angle_deg)))
        return turn

    def rigid_inertia(self) -> tuple[float, float]:
        """Mass [kg], and moment of inertia about the shaft axis [kg m^2], from rigid-body motion."""
        along, about = np.zeros((2, len(self.mass)))
        along[[UZ, 6 + UZ]] = 1.0
        about[[RZ, 6 + RZ]] = 1.0
        return float(along @ self.mass @ along), float(about @ self.mass @ about)


def rotation(angle: float) -> Array:
    """Return the matrix (3, 3) that turns a vector by an angle [rad] about z."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class EndBody:
    """A rigid body of revolution at an end of the shaft: flywheel, pulley, hub of a damper.

    Parameters
    ----------
    mass : float
        [kg]
    polar_inertia : float
        About the shaft axis [kg m^2].
    diametral_inertia : float, optional
        About a diameter through its center of mass [kg m^2]; by default half the polar one, as of a
        thin disc.
    overhang : float
        Distance of its center of mass from the end section, positive away from the shaft [m].
    """

    mass: float
    polar_inertia: float
    diametral_inertia: float | None = None
    overhang: float = 0.0

    def __post_init__(self) -> None:
        why = "it adds to the inertia of the shaft"
        nonnegative_number("mass", self.mass, "kg", why)
        nonnegative_number("polar_inertia", self.polar_inertia, "kg m^2", why)
        nonnegative_number("overhang", self.overhang, "m", "it is counted away from the shaft")
        if self.diametral_inertia is not None:
            nonnegative_number("diametral_inertia", self.diametral_inertia, "kg m^2", why)

    @property
    def diametral(self) -> float:
        """Diametral moment of inertia, given or half the polar one [kg m^2]."""
        if self.diametral_inertia is None:
            return 0.5 * self.polar_inertia
        return self.diametral_inertia

    def mass_matrix(self, outward: float) -> Array:
        """Return the mass matrix (6, 6) of its section; `outward` is -1 at the free end, else 1.

        Raises
        ------
        InputError
            If it is neither.
        """
        diagonal = [self.mass] * 3 + [self.diametral] * 2 + [self.polar_inertia]
        center = self.center_motion(outward)
        return np.asarray(center.T @ np.diag(diagonal) @ center)

    def center_motion(self, outward: float) -> Array:
        """Return the motion of its center per motion of its section, (6, 6); as `mass_matrix`."""
        if outward not in (-1, 1):
            raise InputError(
                f"outward: given {quoted(outward)}; allowed are -1 at the free end and 1 elsewhere, because "
                "the overhang points away from the shaft."
            )
        center = np.eye(6)
        center[UX, RY], center[UY, RX] = outward * self.overhang, -outward * self.overhang
        return center


@dataclass(frozen=True)
class MainBearings:
    """Lateral support of the sections (the middles of the main journals), alike in all directions.

    Parameters
    ----------
    stiffness : float or sequence of float
        Of each section, or of all [N/m]: ``math.inf`` for rigid, 0 for none.
    damping : float or sequence of float
        [N s/m]
    variation : Variation, optional
        How both vary with the frequency of vibration or the speed, as oil films do.
    """

    stiffness: float | Sequence[float]
    damping: float | Sequence[float] = 0.0
    variation: Variation | None = None

    def at(self, sections: int) -> tuple[Array, Array]:
        """Return stiffness and damping of each section.

        Raises
        ------
        InputError
            If one is negative or not a number, or there is not one for each section.
        """
        sections = whole_number("sections", sections, 1, "a shaft has sections")
        return (
            _each("bearings.stiffness", self.stiffness, sections, held=True),
            _each("bearings.damping", self.damping, sections, held=False),
        )


@dataclass(frozen=True)
class AxialSupport:
    """Axial connection of a section to ground: thrust bearing or axial damper.

    Parameters
    ----------
    section : int
        0 at the free end.
    stiffness : float
        [N/m]; ``math.inf`` for a rigid support.
    damping : float
        [N s/m]
    variation : Variation, optional
        How both vary with the frequency of vibration or the speed.
    """

    section: int
    stiffness: float = 0.0
    damping: float = 0.0
    variation: Variation | None = None

    def __post_init__(self) -> None:
        whole_number("axial support section", self.section, 0, "sections are counted from 0")
        if self.stiffness != math.inf:
            nonnegative_number(
                "axial support stiffness", self.stiffness, "N/m", "it does not push the shaft away"
            )
        nonnegative_number("axial support damping", self.damping, "N s/m", "damping takes energy")


@frozen("bearings", "axial_supports", "loss_factor")
class ShaftSurroundings:
    """Surroundings of the throws: bearings, supports, flywheel, free end.

    Parameters
    ----------
    bearings : MainBearings, optional
        None for a shaft free in space.
    axial_supports : sequence of AxialSupport
        Thrust bearing, axial damper at the free end.
    flywheel, free_end : EndBody, optional
        At the last section and at section 0.
    ring : TorsionalRing, optional
        Of a torsional damper at the free end.
    machine : TorsionalRing, optional
        Driven machine behind a coupling at the flywheel, or the prime mover of a machine that is driven.
    pin_masses : sequence of float
        Mass that moves with each pin across the shaft but not along it [kg], pins counted along the
        shaft: rotating part of the rods and half of the reciprocating mass. Empty for none.
    loss_factor : float
        Of the shaft's material: its stiffness is k (1 + i loss_factor).
    torsional_line, axial_line : Chain, optional
        Shaft line at the last section: the first node of either chain turns, or moves along the shaft,
        with it, and its inertia adds to that of the flywheel.
    line_beam : LineBeam, optional
        How that line bends, from the flywheel's center of mass on.
    machine_name : str, optional
        What the rotation of `machine` is called.

    Notes
    -----
    A piston resists motion of the pin along the cylinder only. Seen from the shaft this direction turns
    once a revolution, so m_rec (1 + cos 2 phi) / 2 acts along a fixed direction of the shaft. Its
    mean is half; the rest, which excites at twice the speed of rotation, is neglected.
    """

    bearings: MainBearings | None = None
    axial_supports: Sequence[AxialSupport] = ()
    flywheel: EndBody | None = None
    free_end: EndBody | None = None
    ring: TorsionalRing | None = None
    machine: TorsionalRing | None = None
    pin_masses: Sequence[float] = ()
    loss_factor: float = 0.0
    torsional_line: Chain | None = None
    axial_line: Chain | None = None
    machine_name: str = DRIVEN
    line_beam: LineBeam | None = None

    def __post_init__(self) -> None:
        nonnegative_number("loss_factor", self.loss_factor, "", "it is that of a passive element")

    def bodies(self, sections: int) -> list[tuple[EndBody, int, float]]:
        """Return the end bodies that are given: body, section, -1 at the free end or 1."""
        both = ((self.free_end, 0, -1.0), (self.flywheel, sections - 1, 1.0))
        return [(body, section, outward) for body, section, outward in both if body is not None]

    def lines(self, sections: int) -> list[tuple[Kind, Chain, int]]:
        """Return the shaft lines that are given: kind, chain, unknown of the section that it moves with."""
        last = 6 * (sections - 1)
        both: tuple[tuple[Kind, Chain | None, int], ...] = (
            ("torsional", self.torsional_line, last + RZ),
            ("axial", self.axial_line, last + UZ),
        )
        return [(kind, chain, place) for kind, chain, place in both if chain is not None]

    def rings(self, sections: int) -> list[tuple[str, TorsionalRing, int]]:
        """Return damper ring and driven machine, if given: name, ring, section it turns with."""
        both = (("damper ring", self.ring, 0), (self.machine_name, self.machine, sections - 1))
        return [(name, ring, section) for name, ring, section in both if ring is not None]


def _each(name: str, stiffness: ArrayLike, count: int, *, held: bool) -> Array:
    values = np.array(stiffness, dtype=np.float64)
    values = np.full(count, values) if values.ndim == 0 else values
    allowed = "zero or more, or infinite for one that is held" if held else "zero or more"
    if values.shape != (count,):
        raise InputError(
            f"{name}: given an array of shape {values.shape}; allowed is one number for all, or one "
            f"for each of the {count} sections, because throws side by side share one."
        )
    if not np.all(values >= 0.0) or not (held or np.all(np.isfinite(values))):
        raise InputError(
            f"{name}: given {values.tolist()}; allowed are numbers of {allowed}, because a bearing does "
            "not drive the shaft."
        )
    return values
