"""Couplings and rigid bodies between the sections of a shaft line."""

from dataclasses import dataclass

from crankbase.checks.arrays import nonnegative_number, positive_number
from crankbase.errors import InputError
from dynamics.chains.shaft_elements import Motion


@dataclass(frozen=True)
class Coupling:
    """A coupling by its data sheet: stiffness, damping, and the inertia of its two halves.

    Parameters
    ----------
    torsional_stiffness, axial_stiffness : float, optional
        Dynamic stiffness [N m/rad] and [N/m]; each is required only for chains of its kind.
    left_inertia, right_inertia : float, optional
        Of each half [kg m^2].
    left_mass, right_mass : float, optional
        [kg]
    torsional_damping, axial_damping : float, optional
        Viscous [N m s/rad] and [N s/m].
    loss_factor : float, optional
        Hysteretic damping: the stiffness is k (1 + i loss_factor). Data sheets give the relative
        damping psi, the energy lost in a cycle over the largest stored: loss_factor = psi / (2 pi).
    name : str, optional

    Raises
    ------
    InputError
        If a stiffness is not above zero, or another value is negative.
    """

    torsional_stiffness: float | None = None
    axial_stiffness: float | None = None
    left_inertia: float = 0.0
    right_inertia: float = 0.0
    left_mass: float = 0.0
    right_mass: float = 0.0
    torsional_damping: float = 0.0
    axial_damping: float = 0.0
    loss_factor: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        for field, unit in (("torsional_stiffness", "N m/rad"), ("axial_stiffness", "N/m")):
            value = getattr(self, field)
            if value is not None:
                positive_number(f"coupling.{field}", value, unit, "a coupling joins two shafts")
        why = "it belongs to a passive body"
        for field, unit in (
            ("left_inertia", "kg m^2"),
            ("right_inertia", "kg m^2"),
            ("left_mass", "kg"),
            ("right_mass", "kg"),
            ("torsional_damping", "N m s/rad"),
            ("axial_damping", "N s/m"),
            ("loss_factor", ""),
        ):
            nonnegative_number(f"coupling.{field}", getattr(self, field), unit, why)

    def stiffness(self, kind: Motion) -> float:
        """Return the stiffness for one kind of motion.

        Raises
        ------
        InputError
            If it is not given.
        """
        value = self.torsional_stiffness if kind == "torsional" else self.axial_stiffness
        if value is None:
            raise InputError(
                f"coupling.{kind}_stiffness: given none; allowed are finite numbers of more than zero, "
                f"because the chain is {kind}."
            )
        return value


@dataclass(frozen=True)
class RigidBody:
    """A rigid body on a shaft: a disk, a wheel, a rotor.

    Parameters
    ----------
    inertia : float
        Polar moment of inertia [kg m^2].
    mass : float
        [kg]
    name : str
        Of its node.

    Raises
    ------
    InputError
        If a value is negative.
    """

    inertia: float
    mass: float
    name: str

    def __post_init__(self) -> None:
        why = "it belongs to a body"
        nonnegative_number("body.inertia", self.inertia, "kg m^2", why)
        nonnegative_number("body.mass", self.mass, "kg", why)
