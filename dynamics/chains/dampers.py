"""Dampers: viscous and tuned rubber ones against torsion, and one against axial vibration."""

from dataclasses import dataclass
from typing import get_args

from crankbase.checks.arrays import nonnegative_number, positive_number
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.chains.editing import add_node, with_ground, with_inertia


@dataclass(frozen=True)
class ViscousDamper:
    """Viscous torsional damper: a ring that floats in silicone oil in a housing, without a spring.

    Parameters
    ----------
    ring_inertia : float
        Of the ring [kg m^2].
    damping : float
        Torque per relative speed of ring and housing [N m s/rad].
    hub_inertia : float, optional
        Of the housing, which turns with the shaft [kg m^2].
    name : str, optional
        Of the ring's node.

    Raises
    ------
    InputError
        If ring inertia or damping are not above zero, or the hub's inertia is negative.
    """

    ring_inertia: float
    damping: float
    hub_inertia: float = 0.0
    name: str = "damper ring"

    def __post_init__(self) -> None:
        _check_ring(self.ring_inertia, self.hub_inertia)
        positive_number(
            "damper.damping", self.damping, "N m s/rad", "oil alone joins the ring to the shaft"
        )

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this damper on a node; its ring is the last node.

        Raises
        ------
        InputError
            If the node is unknown, or the ring's name is taken.
        """
        held = with_inertia(chain, node, self.hub_inertia)
        return add_node(held, self.name, self.ring_inertia, to=node, damping=self.damping)


@dataclass(frozen=True)
class RubberDamper:
    """Tuned torsional damper: a ring on a rubber spring.

    Parameters
    ----------
    ring_inertia : float
        Of the ring [kg m^2].
    stiffness : float
        Of the rubber, dynamic, at the relevant frequency and strain [N m/rad].
    loss_factor : float, optional
        Of the rubber: its complex stiffness is k (1 + i loss_factor).
    damping : float, optional
        Viscous damping parallel to it [N m s/rad].
    hub_inertia : float, optional
        Of the hub, which turns with the shaft [kg m^2].
    name : str, optional
        Of the ring's node.

    Raises
    ------
    InputError
        If ring inertia or stiffness are not above zero, or another value is negative.
    """

    ring_inertia: float
    stiffness: float
    loss_factor: float = 0.0
    damping: float = 0.0
    hub_inertia: float = 0.0
    name: str = "damper ring"

    def __post_init__(self) -> None:
        _check_ring(self.ring_inertia, self.hub_inertia)
        positive_number(
            "damper.stiffness", self.stiffness, "N m/rad", "rubber joins the ring to the shaft"
        )
        why = "damping takes energy away"
        nonnegative_number("damper.loss_factor", self.loss_factor, "", why)
        nonnegative_number("damper.damping", self.damping, "N m s/rad", why)

    @property
    def angular_frequency(self) -> float:
        """Natural frequency of the ring with the shaft held [rad/s]."""
        return float((self.stiffness / self.ring_inertia) ** 0.5)

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this damper on a node; its ring is the last node.

        Raises
        ------
        InputError
            If the node is unknown, or the ring's name is taken.
        """
        return add_node(
            with_inertia(chain, node, self.hub_inertia),
            self.name,
            self.ring_inertia,
            to=node,
            stiffness=self.stiffness,
            loss_factor=self.loss_factor,
            damping=self.damping,
        )


@dataclass(frozen=True)
class AxialDamper:
    """Axial damper at the free end: a collar of the shaft that displaces oil in a fixed housing.

    Parameters
    ----------
    damping : float
        Force per speed [N s/m].
    stiffness : float, optional
        Of oil and housing to ground [N/m].
    mass : float, optional
        Of the collar [kg].

    Raises
    ------
    InputError
        If the damping is not above zero, or another value is negative.
    """

    damping: float
    stiffness: float = 0.0
    mass: float = 0.0

    def __post_init__(self) -> None:
        positive_number("axial_damper.damping", self.damping, "N s/m", "the oil resists motion")
        nonnegative_number(
            "axial_damper.stiffness", self.stiffness, "N/m", "oil does not push the shaft away"
        )
        nonnegative_number("axial_damper.mass", self.mass, "kg", "it adds to that of the shaft")

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this damper between a node and ground.

        Raises
        ------
        InputError
            If the node is unknown.
        """
        held = with_ground(chain, node, self.stiffness, damping=self.damping)
        return with_inertia(held, node, self.mass)


TorsionalDamper = ViscousDamper | RubberDamper


def check_torsional(damper: TorsionalDamper) -> None:
    """Refuse what is no torsional damper.

    Raises
    ------
    InputError
    """
    if not isinstance(damper, TorsionalDamper):
        names = " and ".join(f"a {kind.__name__}" for kind in get_args(TorsionalDamper))
        raise InputError(
            f"damper: given {damper!r}; allowed are {names}, because the chain is torsional."
        )


def check_axial(damper: AxialDamper) -> None:
    """Refuse what is no axial damper.

    Raises
    ------
    InputError
    """
    if not isinstance(damper, AxialDamper):
        raise InputError(
            f"damper: given {damper!r}; allowed is an AxialDamper, because the chain is axial."
        )


def _check_ring(ring_inertia: float, hub_inertia: float) -> None:
    positive_number("damper.ring_inertia", ring_inertia, "kg m^2", "the ring works by its inertia")
    nonnegative_number("damper.hub_inertia", hub_inertia, "kg m^2", "it adds to that of the shaft")
