"""Nominal alternating stresses of a throw over the cycle by UR M53: web, oil hole and torsion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    FloatArray,
    check_shape,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
)
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import checked_strokes
from dynamics.response.loads import section_modulus
from dynamics.strength.concentration import CrankWeb

# K_e: what neighboring throws take of the bending of one that is supported by itself.
BENDING_SHARE = {2: 0.8, 4: 1.0}
# Directions among which the worst of an oil hole is looked for, half a turn [deg].
DIRECTIONS_DEG = np.arange(0.0, 180.0)


@summarized("length [m]", "rods [m]")
@dataclass(frozen=True, eq=False)
class SupportedThrow:
    """One throw on two supports, the middles of its main journals: statically determinate.

    Parameters
    ----------
    length : float
        L_3, between the supports [m].
    rods : (n,) array_like
        Position of each rod from the left support [m], L_2.
    radial, tangential : (n, m) array_like
        Force of each rod on the pin over one cycle, towards the shaft and in the sense of rotation [N].

    Raises
    ------
    InputError
        If there are no forces for each rod, or one is not between the supports.
    """

    length: float
    rods: ArrayLike
    radial: ArrayLike
    tangential: ArrayLike

    def __post_init__(self) -> None:
        span = positive_number("length", self.length, "m", "the supports are apart")
        rods = finite_vector("rods", self.rods)
        object.__setattr__(self, "rods", rods)
        if rods.size == 0 or np.any(rods <= 0.0) or np.any(rods >= span):
            raise InputError(
                f"rods: given {rods.tolist()} m; allowed are places above 0 and below {span:g} m, because "
                "rods stand between the supports."
            )
        for name in ("radial", "tangential"):
            forces = finite_array(name, getattr(self, name))
            if forces.ndim != 2 or forces.shape[0] != rods.size or forces.shape[1] == 0:
                raise InputError(
                    f"{name}: given an array of shape {forces.shape}; allowed is ({rods.size}, m), because "
                    "each rod has a force at each angle of the cycle."
                )
            object.__setattr__(self, name, forces)

    def moment(self, at: float, force: ArrayLike) -> FloatArray:
        """Return the bending moment at a distance from the left support, of forces as `radial` [N m], (m,).

        Raises
        ------
        InputError
            If the distance is not a finite number, or there are no forces for each rod.
        """
        rods, forces = self._checked(at, force)
        left = (self.length - rods) / self.length @ forces
        return np.asarray(left * at - np.maximum(at - rods, 0.0) @ forces)

    def shear(self, at: float, force: ArrayLike) -> FloatArray:
        """Return the shear force at a distance from the left support [N], (m,); otherwise as `moment`."""
        rods, forces = self._checked(at, force)
        left = (self.length - rods) / self.length @ forces
        return np.asarray(left - (rods < at).astype(float) @ forces)

    def _checked(self, at: float, force: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the rods and the forces on them, checked with the position of the section."""
        nonnegative_number("at", at, "m", "it is counted from the left support")
        rods, forces = np.asarray(self.rods), finite_array("force", force)
        check_shape("force", forces, (rods.size, *forces.shape[1:]))
        return rods, forces


def alternating(values: ArrayLike) -> FloatArray:
    """Return half of the distance from the lowest to the highest value over the last axis.

    Raises
    ------
    InputError
        If a value is not finite, or there is none over the last axis.
    """
    series = finite_array("values", values)
    if series.ndim == 0 or series.shape[-1] == 0:
        raise InputError(
            f"values: given an array of shape {series.shape}; allowed is a value or more over the last axis, "
            "because they alternate between the lowest and the highest."
        )
    return np.asarray(0.5 * np.ptp(series, axis=-1))


def web_stresses(
    throw: SupportedThrow, web: CrankWeb, at: float, *, strokes: int
) -> tuple[float, float]:
    """Return the nominal alternating stresses of a web due to the radial forces [Pa].

    Parameters
    ----------
    at : float
        Middle of the web's thickness from the left support [m]; L_1 of the left web.
    strokes : {2, 4}

    Returns
    -------
    bending : float
        s_BFN = M / (B W^2 / 6) K_e.
    shear : float
        s_QFN = Q / (B W) K_e, with K_e = 0.8 of two-stroke and 1 of four-stroke engines.

    Raises
    ------
    InputError
        If strokes are others.
    """
    checked_strokes(strokes)
    share, area = BENDING_SHARE[strokes], web.web_width * web.section_thickness
    moment = float(alternating(throw.moment(at, throw.radial)))
    shear = float(alternating(throw.shear(at, throw.radial)))
    return share * moment / web.bending_modulus, share * shear / area


def hole_stress(
    throw: SupportedThrow, web: CrankWeb, at: float, angle_deg: float | None = None
) -> float:
    """Return the nominal alternating bending stress of the pin at an oil hole's outlet [Pa].

    Parameters
    ----------
    web : CrankWeb
        Of the pin.
    at : float
        Position of the hole from the left support [m].
    angle_deg : float, optional
        psi: of the outlet from the direction in which the pin moves, positive away from the shaft [deg];
        by default the direction with the largest stress.

    Notes
    -----
    M_BO = M_BTO cos(psi) + M_BRO sin(psi) over pi/32 (D^4 - D_BH^4) / D. A force bends the pin in its
    own direction; the radial force points to the shaft, so it counts as negative in M_BRO.
    """
    directions = DIRECTIONS_DEG if angle_deg is None else finite_array("angle_deg", [angle_deg])
    psi = np.radians(directions)
    moments = np.outer(np.cos(psi), throw.moment(at, throw.tangential)) - np.outer(
        np.sin(psi), throw.moment(at, throw.radial)
    )
    modulus = 0.5 * float(section_modulus("torsional", web.pin_diameter, web.pin_bore))
    return float(np.max(alternating(moments))) / modulus
