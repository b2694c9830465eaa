"""Quick check of a crankshaft as two inertias on one shaft, and of its resonant order."""

import math
from dataclasses import dataclass

from crankbase.checks.arrays import positive_number
from crankbase.summaries import summarized
from crankbase.units.units import RPM
from dynamics.cycle import order_step
from dynamics.harmonics import Harmonics


@summarized("stiffness [N m/rad]", "frequency [Hz]", "order", "resonant_speed [rad/s]")
@dataclass(frozen=True, eq=False)
class TwoMassCheck:
    """Natural frequency of two inertias on a shaft, and the speed at which one order meets it.

    Parameters
    ----------
    stiffness : float
        C_np, torsional stiffness of the shaft [N m/rad].
    angular_frequency : float
        w_c1, natural angular frequency [rad/s].
    order : float
        Order considered, in cycles per crankshaft revolution.
    harmonics : Harmonics or None
        Those of the exciting torque [N m], if given.
    """

    stiffness: float
    angular_frequency: float
    order: float
    harmonics: Harmonics | None = None

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]."""
        return self.angular_frequency / (2.0 * math.pi)

    @property
    def vibrations_per_minute(self) -> float:
        """Natural vibrations per minute [1/min]."""
        return self.angular_frequency * RPM

    @property
    def resonant_speed(self) -> float:
        """Crankshaft speed at which the order meets the natural frequency [rad/s]."""
        return self.angular_frequency / self.order

    @property
    def resonant_speed_rpm(self) -> float:
        """Crankshaft speed at which the order meets the natural frequency [1/min]."""
        return self.vibrations_per_minute / self.order

    @property
    def resolved(self) -> bool | None:
        """Whether the torque's samples resolve the order; None if no torque was given."""
        return None if self.harmonics is None else self.harmonics.resolves(self.order)

    @property
    def statement(self) -> str:
        """One sentence on whether the given torque can resolve the order."""
        if self.harmonics is None:
            return f"No torque table is given: how strongly order {self.order:g} excites is open."
        table = self.harmonics
        revolutions = "two revolutions" if table.strokes == 4 else "one revolution"
        known = (
            f"{table.samples} samples over {revolutions} resolve orders up to "
            f"{table.highest_order:g}"
        )
        if table.resolves(self.order):
            amplitude = table.amplitude[table.index_of(self.order)]
            return f"{known}: this table excites order {self.order:g} with {amplitude:.4g} N m."
        if self.order < table.highest_order:
            known += f" in steps of {order_step(table.strokes):g}"
        return f"{known}: this table cannot excite order {self.order:g}."


def solid_shaft_stiffness(diameter: float, length: float, shear_modulus: float) -> float:
    """Return the torsional stiffness of a solid round shaft.

    Parameters
    ----------
    diameter : float
        d_b, diameter of the equivalent shaft [m].
    length : float
        L_np, length of the equivalent shaft [m].
    shear_modulus : float
        G [Pa].

    Returns
    -------
    float
        C_np [N m/rad].

    Raises
    ------
    InputError
        If a value is not a finite number above zero.

    Notes
    -----
    C_np = G J / L_np with J = pi d_b^4 / 32, (10) in Makushev, Polyakova, Omsk Scientific Bulletin
    2024 no. 3 (191), doi 10.25206/1813-8225-2024-191-39-47. The stiffness is the torque per
    radian of twist.
    """
    d = positive_number("diameter", diameter, "m", "a shaft has a cross section")
    L = positive_number("length", length, "m", "a shaft has a length")
    G = positive_number("shear_modulus", shear_modulus, "Pa", "the material resists shear")
    return G * math.pi * d**4 / (32.0 * L)


def two_mass_frequency(stiffness: float, inertia_1: float, inertia_2: float) -> float:
    """Return the natural angular frequency of two free inertias joined by a shaft.

    Parameters
    ----------
    stiffness : float
        C_np [N m/rad].
    inertia_1, inertia_2 : float
        J_MAX and J_np: flywheel and united inertia of the throws [kg m^2].

    Returns
    -------
    float
        w_c1 [rad/s].

    Raises
    ------
    InputError
        If a value is not a finite number above zero.

    Notes
    -----
    w_c1 = sqrt(C_np (J_MAX + J_np) / (J_MAX J_np)), (11) in Makushev, Polyakova 2024,
    doi 10.25206/1813-8225-2024-191-39-47.
    """
    c = positive_number("stiffness", stiffness, "N m/rad", "the shaft holds the inertias together")
    why = "both ends of the shaft vibrate against each other"
    first = positive_number("inertia_1", inertia_1, "kg m^2", why)
    second = positive_number("inertia_2", inertia_2, "kg m^2", why)
    return math.sqrt(c / first + c / second)


def two_mass_check(
    *,
    diameter: float,
    length: float,
    shear_modulus: float,
    inertia_1: float,
    inertia_2: float,
    order: float,
    harmonics: Harmonics | None = None,
) -> TwoMassCheck:
    """Check a crankshaft as two inertias on an equivalent solid shaft.

    Parameters
    ----------
    diameter, length : float
        d_b and L_np of the equivalent shaft [m].
    shear_modulus : float
        G [Pa].
    inertia_1, inertia_2 : float
        J_MAX and J_np [kg m^2].
    order : float
        Order to consider, in cycles per crankshaft revolution.
    harmonics : Harmonics, optional
        Those of the exciting torque [N m], to check whether they resolve the order.

    Returns
    -------
    TwoMassCheck
        Stiffness, natural frequency, resonant speed, and whether the torque resolves the order.

    Raises
    ------
    InputError
        If a value is not a finite number above zero.

    Notes
    -----
    (10) to (14) in Makushev, Polyakova 2024, doi 10.25206/1813-8225-2024-191-39-47.
    """
    stiffness = solid_shaft_stiffness(diameter, length, shear_modulus)
    return TwoMassCheck(
        stiffness=stiffness,
        angular_frequency=two_mass_frequency(stiffness, inertia_1, inertia_2),
        order=positive_number("order", order, "", "it counts cycles per revolution"),
        harmonics=harmonics,
    )
