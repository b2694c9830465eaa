"""Equivalent alternating stress, fatigue strength and acceptability of a location by UR M53."""

import math
from dataclasses import dataclass, fields
from typing import Literal

from crankbase.checks.arrays import check_shape, finite_array, nonnegative_number, positive_number
from crankbase.checks.choices import check_choice
from crankbase.summaries import summarized
from crankbase.tables.frames import Row

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


@summarized(
    *("throw", "place", "web", "equivalent [Pa]", "strength [Pa]", "acceptability", "passed")
)
@dataclass(frozen=True)
class PlaceStrength:
    """One location of a throw: its alternating stresses and its fatigue strength.

    Parameters
    ----------
    throw : int
        Number of the throw, from 1 at the free end.
    place : {"pin fillet", "journal fillet", "oil hole"}
    web : str
        Adjacent web, "left web" or "right web"; "" for an oil hole.
    depth : float
        Depth below the surface, of a hardened location [m].
    nominal_bending, nominal_shear, nominal_torsion : float
        Alternating, without stress concentration [Pa].
    bending, torsion : float
        With stress concentration; shear is part of the bending [Pa].
    added : float
        Additional bending stress [Pa].
    equivalent : float
        [Pa]
    strength : float
        Fatigue strength at the location [Pa].
    """

    throw: int
    place: str
    web: str
    depth: float
    nominal_bending: float
    nominal_shear: float
    nominal_torsion: float
    bending: float
    torsion: float
    added: float
    equivalent: float
    strength: float

    @property
    def acceptability(self) -> float:
        """Q: strength over equivalent stress; inf without stress."""
        return self.strength / self.equivalent if self.equivalent else math.inf

    @property
    def passed(self) -> bool:
        """Whether Q is 1.15 or more."""
        return self.acceptability >= REQUIRED

    def row(self) -> Row:
        """Return its values by column, each with its unit, for tables."""
        units = {"throw": "1", "place": "", "web": "", "depth": "m"}
        found: Row = {
            own.name: (getattr(self, own.name), units.get(own.name, "Pa")) for own in fields(self)
        }
        return found | {"acceptability": (self.acceptability, "1"), "passed": (self.passed, "")}


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
