"""Bodies at the ends of an engine: driven machines behind couplings, and propellers."""

from dataclasses import dataclass

from crankbase.checks.arrays import nonnegative_number, positive_number
from crankbase.errors import InputError

# Shares of the dry propeller that designers often take before they know better; assumed here, no
# published table stands behind them. D. M. MacPherson, V. R. Puleo, M. B. Packard, Estimation of
# Entrained Water Added Mass Properties for Vibration Analysis (2007), surveys better estimates.
TYPICAL_ENTRAINED_INERTIA_SHARE = 0.25  # to 0.30, of the polar inertia
TYPICAL_ENTRAINED_MASS_SHARE = 0.60


@dataclass(frozen=True)
class DrivenMachine:
    """A driven machine: one inertia behind a coupling.

    Parameters
    ----------
    inertia : float
        Moment of inertia, referred to the crankshaft speed [kg m^2].
    coupling_stiffness : float
        Torsional stiffness between flywheel and machine [N m/rad].
    coupling_damping : float, optional
        Viscous damping of the coupling [N m s/rad].
    coupling_loss_factor : float, optional
        Hysteretic damping of the coupling: its stiffness is k (1 + i loss factor).
    damping : float, optional
        Absolute damping of the machine, torque per speed of vibration [N m s/rad].
    name : str, optional
        Of its node.
    on : str, optional
        Name of the node with the coupling; the flywheel by default.

    Raises
    ------
    InputError
        If the inertia or the stiffness is not a finite number above zero, or a damping negative.
    """

    inertia: float
    coupling_stiffness: float
    coupling_damping: float = 0.0
    coupling_loss_factor: float = 0.0
    damping: float = 0.0
    name: str = "driven machine"
    on: str = "flywheel"

    def __post_init__(self) -> None:
        positive_number("driven.inertia", self.inertia, "kg m^2", "a machine has inertia")
        positive_number(
            "driven.coupling_stiffness",
            self.coupling_stiffness,
            "N m/rad",
            "without stiffness the machine is not coupled",
        )
        why = "damping takes energy away"
        unit = "N m s/rad"
        nonnegative_number("driven.coupling_damping", self.coupling_damping, unit, why)
        nonnegative_number("driven.coupling_loss_factor", self.coupling_loss_factor, "", why)
        nonnegative_number("driven.damping", self.damping, unit, why)


@dataclass(frozen=True)
class Propeller:
    """A propeller with its entrained water.

    Parameters
    ----------
    dry_inertia : float
        Polar moment of inertia in air [kg m^2].
    dry_mass : float
        [kg]
    entrained_inertia, entrained_mass : float, optional
        Of the entrained water in torsion [kg m^2] and along the shaft [kg].
    entrained_inertia_share, entrained_mass_share : float, optional
        Alternatively as shares of the dry values; 0.25 to 0.30 and about 0.60 are often
        assumed.
    damping : float, optional
        Torque per speed of torsional vibration [N m s/rad].
    axial_damping : float, optional
        Force per speed of axial vibration [N s/m].
    name : str, optional
        Of its node.

    Raises
    ------
    InputError
        If inertia or mass are not above zero, another value is negative, or the water is not given
        in exactly one of the two ways: it has no default, because it shifts the frequencies.
    """

    dry_inertia: float
    dry_mass: float
    entrained_inertia: float | None = None
    entrained_mass: float | None = None
    entrained_inertia_share: float | None = None
    entrained_mass_share: float | None = None
    damping: float = 0.0
    axial_damping: float = 0.0
    name: str = "propeller"

    def __post_init__(self) -> None:
        positive_number("propeller.dry_inertia", self.dry_inertia, "kg m^2", "blades have inertia")
        positive_number("propeller.dry_mass", self.dry_mass, "kg", "blades have mass")
        for name, unit, usual in (
            ("entrained_inertia", "kg m^2", "0.25 to 0.30"),
            ("entrained_mass", "kg", "about 0.60"),
        ):
            value, share = getattr(self, name), getattr(self, f"{name}_share")
            if (value is None) == (share is None):
                raise InputError(
                    f"propeller.{name}: given {'both' if value is not None else 'neither'} it and its "
                    f"share of the dry value; allowed is one of them (a share of {usual} is often "
                    "assumed), because water vibrates with the blades."
                )
            why = "water adds to the blades"
            nonnegative_number(f"propeller.{name}", value or 0.0, unit, why)
            nonnegative_number(f"propeller.{name}_share", share or 0.0, "", why)
        why = "damping takes energy away"
        nonnegative_number("propeller.damping", self.damping, "N m s/rad", why)
        nonnegative_number("propeller.axial_damping", self.axial_damping, "N s/m", why)

    @property
    def inertia(self) -> float:
        """Polar moment of inertia with the water [kg m^2]."""
        share = self.entrained_inertia_share
        water = self.entrained_inertia if share is None else share * self.dry_inertia
        return self.dry_inertia + (water or 0.0)

    @property
    def mass(self) -> float:
        """Mass for axial vibration with the water [kg]."""
        share = self.entrained_mass_share
        water = self.entrained_mass if share is None else share * self.dry_mass
        return self.dry_mass + (water or 0.0)
