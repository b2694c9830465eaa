"""Fatigue by UR M53, of hardened surfaces too (Appendix V), and Findley's criterion."""

import math
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    Integers,
    check_shape,
    finite_array,
    nonnegative_number,
    positive_number,
)
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.results import Number, Part, Quantity, Result, result
from crankbase.sentences import in_si
from crankbase.summaries import frozen
from dynamics.strength.concentration import ConcentrationFactors, ElementFactors

Stress = Annotated[float, Quantity("Pa")]
MPA, MM = 1e6, 1e-3
# Least acceptability factor Q.
REQUIRED = 1.15
Piston = Literal["trunk", "crosshead"]
# Additional bending stress at fillets [Pa]: of misalignment and bedplate, and of axial vibration.
ADDED: dict[str, tuple[float, float]] = {"trunk": (10e6, 0.0), "crosshead": (10e6, 20e6)}
Manufacture = Literal["continuous grain flow", "free-form forged", "cast and cold rolled"]
# K at fillets, and at oil holes.
MANUFACTURE: dict[str, tuple[float, float]] = {
    "continuous grain flow": (1.05, 1.0),
    "free-form forged": (1.0, 1.0),
    "cast and cold rolled": (0.93, 0.93),
}
# Smaller radii do not raise the strength [m].
LEAST_RADIUS = 2e-3


@result("throw", "place", "web", "equivalent", "strength", "acceptability", "passed", eq=True)
class PlaceStrength(Result):
    """One location of a throw: its alternating stresses and its fatigue strength.

    Parameters
    ----------
    throw : int
        Number of the throw, from 1 at the free end.
    place : {"pin fillet", "journal fillet", "oil hole"}
    web : str
        Adjacent web, "left web" or "right web"; "" for an oil hole.
    depth : float
        Depth below the surface, of a hardened location.
    nominal_bending, nominal_shear, nominal_torsion : float
        Alternating, without stress concentration.
    bending, torsion : float
        With stress concentration; shear is part of the bending.
    added : float
        Additional bending stress.
    strength : float
        Fatigue strength at the location [Pa].
    """

    throw: int
    place: str
    web: str
    depth: Annotated[float, Quantity("m")]
    nominal_bending: Stress
    nominal_shear: Stress
    nominal_torsion: Stress
    bending: Stress
    torsion: Stress
    added: Stress
    equivalent: Stress
    strength: Stress

    @property
    def acceptability(self) -> Number:
        """Q: strength over equivalent stress; inf without stress."""
        return self.strength / self.equivalent if self.equivalent else math.inf

    @property
    def passed(self) -> Part[bool]:
        """Whether Q is 1.15 or more."""
        return self.acceptability >= REQUIRED


def fatigue_strength(
    tensile_strength: float, diameter: float, radius: float, factor: float = 1.0
) -> float:
    """Return the alternating bending fatigue strength s_DW at a location [Pa].

    Parameters
    ----------
    tensile_strength : float
        s_B, specified minimum [Pa].
    diameter, radius : float
        D and R_X [m]: of the pin and its fillet; of the journal and its fillet; of the pin and half of its
        oil hole. A radius below 2 mm counts as 2 mm.
    factor : float, optional
        K of the manufacture, of `MANUFACTURE`.

    Raises
    ------
    InputError
        If a value is not above zero.

    Notes
    -----
    K (0.42 s_B + 39.3) (0.264 + 1.073 D^-0.2 + (785 - s_B) / 4900 + 196 / s_B sqrt(1 / R_X)), in N and mm.
    """
    tensile = (
        positive_number("tensile_strength", tensile_strength, "Pa", "it is that of a steel") / MPA
    )
    across = positive_number("diameter", diameter, "m", "it is a length") / MM
    rounded = max(positive_number("radius", radius, "m", "it is a length"), LEAST_RADIUS) / MM
    share = positive_number("factor", factor, "", "it multiplies the strength")
    size = 0.264 + 1.073 * math.pow(across, -0.2)
    return (
        MPA
        * share
        * (0.42 * tensile + 39.3)
        * (size + (785.0 - tensile) / 4900.0 + 196.0 / tensile * math.sqrt(1.0 / rounded))
    )


def fillet_equivalent(bending: float, torsion: float, added: float) -> float:
    """Return sqrt((s_B + s_add)^2 + 3 t^2) of a fillet, alternating stresses [Pa].

    Raises
    ------
    InputError
        If a stress is not a finite number.
    """
    _check_finite(bending=bending, torsion=torsion, added=added)
    return math.hypot(bending + added, math.sqrt(3.0) * torsion)


def hole_equivalent(bending: float, torsion: float) -> float:
    """Return the equivalent stress at an oil hole's outlet [Pa].

    Raises
    ------
    InputError
        If a stress is not a finite number.

    Notes
    -----
    s_BO / 3 (1 + 2 sqrt(1 + 9/4 (s_TO / s_BO)^2)), written so that it is valid without bending too.
    """
    _check_finite(bending=bending, torsion=torsion)
    return (bending + math.hypot(2.0 * bending, 3.0 * torsion)) / 3.0


def _check_finite(**stresses: float) -> None:
    for name, stress in stresses.items():
        check_shape(name, finite_array(name, stress), ())


def added_bending(piston: str, axial_vibration: float | None = None) -> float:
    """Return the additional bending stress at fillets [Pa].

    Parameters
    ----------
    piston : {"trunk", "crosshead"}
        10 N/mm2 with trunk pistons; 30 with crossheads, of which 20 are for axial vibration.
    axial_vibration : float, optional
        Result of a calculation of the axial vibration that replaces the 20 [Pa]; for crossheads only.

    Raises
    ------
    InputError
        If the piston is neither, or the stress below zero.
    """
    check_choice("piston", piston, tuple(ADDED), "the rule covers these")
    seat, vibration = ADDED[piston]
    if axial_vibration is not None and vibration:
        why = "it is an amplitude"
        vibration = nonnegative_number("axial_vibration", axial_vibration, "Pa", why)
    return seat + vibration


FINDLEY_SOURCE = (
    "W. N. Findley, A theory for the effect of mean stress on fatigue of metals under combined torsion and "
    "axial load or bending, Journal of Engineering for Industry 81, 1959, 301-306"
)
# Of the fatigue strengths in torsion and in bending, both fully reversed: that of von Mises, as UR M53 has
# it at fillets.
TORSION_SHARE = 1.0 / math.sqrt(3.0)
# Planes first looked at, and how much closer each further look is [deg].
FIRST_STEP, CLOSER, LOOKS = 10.0, 5.0, 2
# A circle holds points that are outside by less than this share of its radius.
HELD, MOST_STEPS = 1e-9, 60
# A path of stress has no extent in a direction where it is smaller than this share of its largest.
FLAT = 1e-9


@frozen("value [Pa]", "shear_amplitude [Pa]", "normal_stress [Pa]", "moment", "normal", eq=False)
class CriticalPlane:
    """The plane through a point on which the criterion is largest.

    Attributes
    ----------
    value : float
        shear_amplitude + k normal_stress [Pa].
    shear_amplitude : float
        Radius of the smallest circle around the path of the shear stress [Pa].
    normal_stress : float
        The largest over the history [Pa].
    moment : int
        Its index in the history.
    normal : (3,) array
        Of the plane: along both directions of the surface, and out of it.
    """

    value: float
    shear_amplitude: float
    normal_stress: float
    moment: int
    normal: Array


def findley_factor(torsion_share: float = TORSION_SHARE) -> float:
    """Return k, the weight of the normal stress, of a steel.

    Parameters
    ----------
    torsion_share : float, optional
        Fatigue strength in torsion over that in bending, both fully reversed: above 1/2, below 1.

    Raises
    ------
    InputError
        If it is not.

    Notes
    -----
    Fully reversed, tau_a + k sigma_max is largest with t sqrt(1 + k^2) in torsion and with
    f/2 (k + sqrt(1 + k^2)) in bending. Both are one limit if k / sqrt(1 + k^2) = 2 t/f - 1; with
    t/f = 1/sqrt(3) k is 0.1566.
    """
    share = positive_number("torsion_share", torsion_share, "", "strengths are above zero")
    if not 0.5 < share < 1.0:
        raise InputError(
            f"torsion_share: given {share:g}; allowed is above 0.5 and below 1, because normal stress is of "
            "no use to a plane, and shear decides."
        )
    sine = 2.0 * share - 1.0
    return sine / math.sqrt(1.0 - sine**2)


def findley_limit(bending_strength: float, factor: float) -> float:
    """Return the limit of the criterion [Pa]: f/2 (k + sqrt(1 + k^2)).

    Parameters
    ----------
    bending_strength : float
        f, fully reversed [Pa].
    factor : float
        k, from `findley_factor`.

    Raises
    ------
    InputError
        If the strength is not above zero, or the factor below it.
    """
    factor = nonnegative_number("factor", factor, "", "it weighs the normal stress")
    strength = positive_number("bending_strength", bending_strength, "Pa", "it is that of a steel")
    return 0.5 * strength * (factor + math.hypot(1.0, factor))


def critical_plane(history: ArrayLike, factor: float) -> CriticalPlane:
    """Find the plane with the worst combination of shear amplitude and largest normal stress.

    Parameters
    ----------
    history : (m, 3) array_like
        Stresses of a free surface over one cycle, along two directions of it and between them [Pa].
    factor : float
        k, from `findley_factor`.

    Raises
    ------
    InputError
        If the history is not such an array, or the factor below zero.

    Notes
    -----
    Planes are searched over all directions in steps of 10 degrees, then near the worst in steps of 2 and 0.4.
    Stresses on a plane are linear in those of the history, so the corners of its path are sufficient.
    """
    points = finite_array("history", history)
    factor = nonnegative_number("factor", factor, "", "it weighs the normal stress")
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise InputError(
            f"history: given an array of shape {points.shape}; allowed is (m, 3), because a free surface has "
            "three stresses at each moment."
        )
    corners = _corners(points)
    path = points[corners]
    step = math.radians(FIRST_STEP)
    around = np.arange(0.0, math.pi - 1e-9, step)
    down = np.arange(0.0, 0.5 * math.pi + 1e-9, step)
    for _ in range(LOOKS + 1):
        angles = np.stack(np.meshgrid(around, down, indexing="ij"), axis=-1).reshape(-1, 2)
        values, shear, normal = _on_planes(path, angles, factor)
        worst = int(np.argmax(values))
        best = angles[worst]
        near = np.arange(-CLOSER, CLOSER + 0.5) * step / CLOSER
        around, down, step = best[0] + near, best[1] + near, step / CLOSER
    stress = normal[worst]
    return CriticalPlane(
        value=float(values[worst]),
        shear_amplitude=float(shear[worst]),
        normal_stress=float(stress.max()),
        moment=int(corners[np.argmax(stress)]),
        normal=_normals(best[None])[0],
    )


def _corners(history: Array) -> Integers:
    """Return the moments at which the path turns outwards: only they determine circle and largest stress."""
    centered = history - history.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centered, full_matrices=False)
    # In a plane, or along a line, where the path has no extent besides.
    path = centered @ axes[sizes > FLAT * sizes[0]].T
    if path.shape[1] < 2:
        along = path.sum(axis=1)
        return np.unique([along.argmin(), along.argmax()])
    from scipy.spatial import ConvexHull, QhullError  # here: engine files are read without it

    try:
        return np.sort(ConvexHull(path).vertices)
    except QhullError:  # too few moments
        return np.arange(len(history))


def findley_bound(histories: ArrayLike, factor: float) -> Array:
    """Return an upper bound of the criterion on any plane, (...), of histories (..., m, 3) [Pa].

    Notes
    -----
    No shear stress on any plane is farther from its middle than half the largest principal difference of
    the stress less that in the middle of its range; no normal stress is above the largest principal one.
    """
    stress = np.asarray(histories, dtype=np.float64)
    middle = 0.5 * (stress.max(axis=-2, keepdims=True) + stress.min(axis=-2, keepdims=True))
    mean, radius = _circle(stress - middle)
    shear = np.maximum(radius, 0.5 * (np.abs(mean) + radius)).max(axis=-1)
    mean, radius = _circle(stress)
    return np.asarray(shear + factor * np.maximum((mean + radius).max(axis=-1), 0.0))


def _circle(stress: Array) -> tuple[Array, Array]:
    """Center and radius of Mohr's circle in the surface."""
    first, second, between = np.moveaxis(stress, -1, 0)
    return 0.5 * (first + second), np.hypot(0.5 * (first - second), between)


def _normals(angles: Array) -> Array:
    """Unit normals (p, 3) of planes by angle in the surface and angle from its normal (p, 2)."""
    around, down = angles.T
    return np.stack(
        [np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=1
    )


def _on_planes(history: Array, angles: Array, factor: float) -> tuple[Array, Array, Array]:
    """Return criterion (p,), shear amplitude (p,) and normal stress (p, m) on planes."""
    around, normals = angles[:, 0], _normals(angles)
    along = np.stack([-np.sin(around), np.cos(around), np.zeros_like(around)], axis=1)
    across = np.cross(normals, along)

    def acting(direction: Array) -> Array:
        """Stress (p, m) on the planes in a direction."""
        a, b = normals[:, 0], normals[:, 1]
        x, y = direction[:, 0], direction[:, 1]
        return np.asarray(np.stack([a * x, b * y, a * y + b * x], axis=1) @ history.T)

    normal = acting(normals)
    shear = enclosing_radius(np.stack([acting(along), acting(across)], axis=-1))
    return shear + factor * normal.max(axis=1), shear, normal


def enclosing_radius(paths: ArrayLike) -> Array:
    """Return the radius (b,) of the smallest circle around each path (b, m, 2).

    Notes
    -----
    A circle through two or three points is enlarged by the point farthest outside until none is: each step
    is the smallest circle around four points, with the farthest on it.
    """
    points = np.asarray(paths, dtype=np.float64)
    count = np.arange(len(points))

    def farthest(center: Array) -> tuple[Array, Array]:
        distance = np.linalg.norm(points - center[:, None], axis=2)
        place = distance.argmax(axis=1)
        return points[count, place], distance[count, place]

    start, _ = farthest(points.mean(axis=1))
    other, _ = farthest(start)
    held = np.stack([start, other, other], axis=1)
    center, radius = 0.5 * (start + other), 0.5 * np.linalg.norm(start - other, axis=1)
    for _ in range(MOST_STEPS):
        new, distance = farthest(center)
        outside = distance > radius * (1.0 + HELD)
        if not outside.any():
            break
        changed = _round_four(held[outside], new[outside])
        held[outside], center[outside], radius[outside] = changed
    return np.asarray(radius)


def _round_four(held: Array, new: Array) -> tuple[Array, Array, Array]:
    """Return the smallest circle through `new` (b, 2) around it and three points (b, 3, 2).

    Gives the points that determine it (b, 3, 2), its center and its radius.
    """
    four = np.concatenate([held, new[:, None]], axis=1)
    sets, centers = [], []
    for first in range(3):
        sets.append(np.stack([new, held[:, first], held[:, first]], axis=1))
        centers.append(0.5 * (new + held[:, first]))
    for first, second in ((0, 1), (0, 2), (1, 2)):
        sets.append(np.stack([new, held[:, first], held[:, second]], axis=1))
        # The circle through three points; inf where they are in line.
        a, b = held[:, first] - new, held[:, second] - new
        twice = 2.0 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        squares = np.sum(a * a, axis=1), np.sum(b * b, axis=1)
        x = b[:, 1] * squares[0] - a[:, 1] * squares[1]
        y = a[:, 0] * squares[1] - b[:, 0] * squares[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            offset = np.stack([x, y], axis=1) / twice[:, None]
        centers.append(np.where(np.isfinite(offset), new + offset, np.inf))
    center = np.stack(centers, axis=1)
    reach = np.linalg.norm(four[:, None] - center[:, :, None], axis=3)
    radius = np.linalg.norm(new[:, None] - center, axis=2)
    with np.errstate(invalid="ignore"):
        holds = np.all(reach <= radius[..., None] * (1.0 + HELD), axis=2)
    choice = np.where(holds, radius, np.inf).argmin(axis=1)
    count = np.arange(len(new))
    return np.stack(sets, axis=1)[count, choice], center[count, choice], radius[count, choice]


Process = Literal["induction", "nitriding"]
TREATED = ("pin fillet", "oil hole")
# The softer steel below an induction hardened layer has so much of the strength of untreated steel.
BELOW_HARDENED = 0.8
# The transition below a nitrided layer, over its depth.
NITRIDED_TRANSITION = 1.2
NITRIDED_STRENGTH, NITRIDED_HARDNESS = 450e6, 600.0


@frozen("process", "depth [m]", "surface_hardness", "surface_strength [Pa]")
class SurfaceTreatment:
    """A hardened surface.

    Parameters
    ----------
    process : {"induction", "nitriding"}
        Stroke peening and cold rolling raise the strength by tests alone, and are not included.
    depth : float
        Depth at which 80 % of the least surface hardness is left (induction), t_N (nitriding) [m].
    surface_hardness : float
        Vickers: 400 or more of induction, 600 or more of nitriding.

    Raises
    ------
    InputError
        If the process is neither, the depth not above zero, or the surface too soft for the rule's values.
    """

    process: Process
    depth: float
    surface_hardness: float

    def __post_init__(self) -> None:
        check_choice(
            "process", self.process, ("induction", "nitriding"), "the rule has values for these"
        )
        positive_number("depth", self.depth, "m", "a layer is hardened")
        least = NITRIDED_HARDNESS if self.process == "nitriding" else 400.0
        hard = positive_number(
            "surface_hardness", self.surface_hardness, "HV", "a layer is hardened"
        )
        if hard < least:
            raise InputError(
                f"surface_hardness: given {hard:g} HV; allowed is {least:g} HV or more for {self.process}, "
                "because the rule's strength of the surface begins there."
            )

    @property
    def surface_strength(self) -> float:
        """Fatigue strength of the surface [Pa]: 400 + 0.5 (HV - 400) N/mm2, or 450 when nitrided."""
        if self.process == "nitriding":
            return NITRIDED_STRENGTH
        return MPA * (400.0 + 0.5 * (self.surface_hardness - 400.0))

    @property
    def transition(self) -> float:
        """Depth below which the untreated steel must have the strength [m]."""
        return self.depth * (NITRIDED_TRANSITION if self.process == "nitriding" else 1.0)

    def transition_strength(self, untreated: float) -> float:
        """Return the fatigue strength at the transition, from that of the untreated surface [Pa].

        Raises
        ------
        InputError
            If the strength is not positive.
        """
        strength = positive_number("untreated", untreated, "Pa", "a strength is positive")
        return strength * (BELOW_HARDENED if self.process == "induction" else 1.0)

    def hardness(self, depths: ArrayLike, core_hardness: float) -> Array:
        """Return the Vickers hardness below a nitrided surface.

        Parameters
        ----------
        depths : (m,) array_like
            [m]
        core_hardness : float
            HV_c, more than 50 below the surface's.

        Raises
        ------
        InputError
            If the surface is not nitrided, or too little harder than the core.

        Notes
        -----
        HV_c + (HV_s - HV_c) (50 / (HV_s - HV_c))^((t / t_N)^2).
        """
        if self.process != "nitriding":
            raise InputError(
                "process: given induction; allowed is nitriding, because the rule gives only its hardness."
            )
        core = positive_number("core_hardness", core_hardness, "HV", "it is a hardness")
        above = self.surface_hardness - core
        if above <= 50.0:
            raise InputError(
                f"core_hardness: given {core:g} HV; allowed is below {self.surface_hardness - 50.0:g} HV, "
                "because the layer ends where it is 50 HV above the core."
            )
        share = finite_array("depths", depths) / self.depth
        return np.asarray(core + above * (50.0 / above) ** (share**2))


def factors_below(
    factors: ConcentrationFactors | ElementFactors, place: str, depth: float
) -> tuple[float, float]:
    """Return the factors on bending and torsion at a depth below the surface.

    Parameters
    ----------
    place : {"pin fillet", "oil hole"}
        The available text has no formula for the journal's fillet.
    depth : float
        t [m].

    Raises
    ------
    InputError
        If the location is unknown, it has no such part, or the depth is negative.

    Notes
    -----
    Pin fillet: (alpha_B - 1) exp(-2 t / R_H) + 1 - (2 t / sqrt(W^2 + S^2))^(0.6 / sqrt(alpha_B)) and
    (alpha_T - 1) exp(-t / R_H) + 1 - (2 t / D)^(1 / sqrt(alpha_T)); oil hole:
    (gamma_B - 1) exp(-4 t / D_O) + 1 and (gamma_T - 1) exp(-2 t / D_O) + 1.
    """
    check_choice("place", place, TREATED, "the rule has formulas for these")
    nonnegative_number("depth", depth, "m", "it lies below the surface")
    bending, _, torsion = factors.at(place)
    web = factors.web
    if place == "oil hole":
        over = depth / web.oil_hole_diameter
        return (
            (bending - 1.0) * math.exp(-4.0 * over) + 1.0,
            (torsion - 1.0) * math.exp(-2.0 * over) + 1.0,
        )
    over = depth / web.pin_fillet_radius
    across = 2.0 * depth / math.hypot(web.section_thickness, web.overlap)
    through = 2.0 * depth / web.pin_diameter
    if max(across, through) >= 1.0:
        raise InputError(
            f"depth: given {in_si(depth, 'm')}; allowed is less than half of web and pin, because stresses "
            "fall to zero in their middle."
        )
    return (
        (bending - 1.0) * math.exp(-2.0 * over) + 1.0 - across ** (0.6 / math.sqrt(bending)),
        (torsion - 1.0) * math.exp(-over) + 1.0 - through ** (1.0 / math.sqrt(torsion)),
    )
