"""Dampers: viscous and tuned rubber ones against torsion, and one against axial vibration."""

import math
from typing import Self, get_args

from pydantic import Field, model_validator

from crankbase.array_checks import SMALLEST, positive_number
from crankbase.choices import check_kind, whole_within
from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.chains.editing import add_node, find_node, with_ground, with_inertia, with_varying
from dynamics.chains.varying import Variation, VaryingPart, varied


class TorsionalRing(InputModel):
    """A body that turns with a node of a chain or a section of a shaft through a spring and a dashpot.

    The ring of a viscous damper (no stiffness) or of a rubber damper (a loss factor), a driven machine
    behind a coupling.
    """

    section = "ring"
    positional = ("inertia", "stiffness", "damping", "loss_factor", "variation")

    inertia: float = quantity_field("inertia of the body", "kg m^2", SMALLEST)
    stiffness: float = quantity_field("stiffness of the spring", "N m/rad", 0.0, default=0.0)
    damping: float = quantity_field("damping of the dashpot", "N m s/rad", 0.0, default=0.0)
    loss_factor: float = quantity_field("loss factor of the spring", "", 0.0, default=0.0)
    variation: Variation | None = part_field("how the connection varies", Variation)

    @model_validator(mode="after")
    def _is_joined(self) -> Self:
        if self.stiffness == 0.0 and self.damping == 0.0:
            raise InputError(
                "ring: given neither stiffness nor damping; allowed is one of them or both, because the "
                "ring would not be joined to the shaft."
            )
        return self

    @property
    def connection(self) -> tuple[float, float, float, VaryingPart | None]:
        """Stiffness, loss factor and damping, and the law by which they vary, if they do."""
        return varied(self.variation, self.stiffness, self.loss_factor, self.damping)

    def attached(self, chain: Chain, node: str | int, name: str) -> Chain:
        """Return the chain with this body on a node, as its last node, of the given name."""
        stiffness, loss_factor, damping, law = self.connection
        wider = add_node(
            chain,
            name,
            self.inertia,
            to=node,
            stiffness=stiffness or None,
            damping=damping,
            loss_factor=loss_factor,
        )
        return wider if law is None else with_varying(wider, len(wider.stiffness) - 1, law)


class _OnHub(InputModel):
    """What all torsional dampers have: a hub or housing, which turns with the shaft, and a ring on it."""

    section = "damper"

    ring_inertia: float = quantity_field("inertia of the ring", "kg m^2", 1e-10, 1e6)
    hub_inertia: float = quantity_field(
        "inertia of hub or housing", "kg m^2", 0.0, default=0.0, feature=True
    )
    name: str = Field(
        "damper ring", description="of the ring's node", json_schema_extra={"feature": True}
    )

    @property
    def ring(self) -> TorsionalRing:
        """Ring and connection, without the hub."""
        names = ("stiffness", "damping", "loss_factor", "variation")
        return TorsionalRing(
            inertia=self.ring_inertia,
            **{name: getattr(self, name) for name in names if name in type(self).model_fields},
        )

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this damper on a node; its ring is the last node."""
        return self.ring.attached(with_inertia(chain, node, self.hub_inertia), node, self.name)


class ViscousDamper(_OnHub):
    """Viscous torsional damper: a ring that floats in silicone oil in a housing, without a spring."""

    positional = ("ring_inertia", "damping", "hub_inertia", "name")

    damping: float = quantity_field(
        "torque per relative speed of ring and hub", "N m s/rad", 1e-6, 1e8
    )


class RubberDamper(_OnHub):
    """Tuned torsional damper: a ring on a rubber spring, whose complex stiffness is k (1 + i loss_factor)."""

    positional = ("ring_inertia", "stiffness", "loss_factor", "damping", "hub_inertia", "name")

    stiffness: float = quantity_field("torsional stiffness of the rubber", "N m/rad", 1e-3, 1e10)
    loss_factor: float = quantity_field(
        "loss factor of the rubber", "", 0.0, 2.0, default=0.0, feature=True
    )
    damping: float = quantity_field(
        "viscous damping parallel to it", "N m s/rad", 0.0, 1e8, default=0.0, feature=True
    )
    variation: Variation | None = part_field("how the rubber varies", Variation)

    @property
    def angular_frequency(self) -> float:
        """Natural frequency of the ring with the shaft held [rad/s]."""
        return float((self.stiffness / self.ring_inertia) ** 0.5)


class AxialDamper(InputModel):
    """Axial damper at the free end: a collar of the shaft that displaces oil in a fixed housing."""

    section = "axial_damper"
    positional = ("damping", "stiffness", "mass")

    damping: float = quantity_field("force per speed", "N s/m", 1e-6, 1e10)
    stiffness: float = quantity_field(
        "stiffness of oil and housing", "N/m", 0.0, 1e12, default=0.0, feature=True
    )
    mass: float = quantity_field("mass of the collar", "kg", 0.0, default=0.0, feature=True)

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this damper between a node and ground."""
        held = with_ground(chain, node, self.stiffness, damping=self.damping)
        return with_inertia(held, node, self.mass)


TorsionalDamper = ViscousDamper | RubberDamper


def check_torsional(damper: TorsionalDamper) -> None:
    """Refuse what is no torsional damper."""
    if not isinstance(damper, TorsionalDamper):
        names = " and ".join(f"a {kind.__name__}" for kind in get_args(TorsionalDamper))
        raise InputError(
            f"damper: given {damper!r}; allowed are {names}, because the chain is torsional."
        )


def check_axial(damper: AxialDamper) -> None:
    """Refuse what is no axial damper."""
    check_kind("damper", damper, AxialDamper, "an AxialDamper, because the chain is axial")


# A node that moves less than this share of the mode's largest motion cannot drive a damper.
STANDS_STILL = 1e-3


@frozen("tuning", "damping_ratio", "loss_factor", "magnifier")
class AbsorberOptimum:
    """The best absorber on a main inertia with a spring to ground and without damping.

    Parameters
    ----------
    tuning : float
        Absorber's own frequency over that of the main inertia; 0 for one without a spring.
    damping_ratio : float
        c / (2 I_a w_n), I_a the absorber's inertia and w_n the main inertia's frequency; 0 where
        the damping is a loss factor.
    loss_factor : float
        That of the absorber's spring; 0 where the damping is viscous.
    magnifier : float
        Largest amplitude over all frequencies, relative to the static deflection.
    """

    tuning: float
    damping_ratio: float
    loss_factor: float
    magnifier: float


def untuned_optimum(mass_ratio: float) -> AbsorberOptimum:
    """Return the best viscous absorber without a spring.

    Parameters
    ----------
    mass_ratio : float
        mu, inertia of the absorber over that of the main system.

    Raises
    ------
    InputError
        If the ratio is not above zero.

    Notes
    -----
    With g = w / w_n and z = c / (2 I_a w_n) the main amplitude per static deflection is

        |x|^2 = (g^2 + 4 z^2) / (g^2 (1 - g^2)^2 + 4 z^2 (1 - (1 + mu) g^2)^2).

    Where |1 - g^2| = |1 - (1 + mu) g^2|, which is at g^2 = 2 / (2 + mu), it does not depend on z:
    x = (2 + mu) / mu. No damping gives a lower maximum, and the best one has its peak there: with
    N and D for numerator and denominator as functions of g^2, N' = |x|^2 D' gives
    z^2 = 1 / (2 (1 + mu) (2 + mu)).
    """
    mu = _checked_ratio(mass_ratio)
    return AbsorberOptimum(
        tuning=0.0,
        damping_ratio=1.0 / math.sqrt(2.0 * (1.0 + mu) * (2.0 + mu)),
        loss_factor=0.0,
        magnifier=(2.0 + mu) / mu,
    )


def tuned_optimum(mass_ratio: float) -> AbsorberOptimum:
    """Return the absorber with spring and viscous damping after Den Hartog.

    Notes
    -----
    With f the tuning, g = w / w_n, x = g^2 and z = c / (2 I_a w_n)

        |x|^2 = (A^2 + 4 z^2 g^2) / (C^2 + 4 z^2 g^2 E^2),
        A = f^2 - g^2,  C = (1 - g^2) A - mu f^2 g^2,  E = 1 - (1 + mu) g^2.

    At the two frequencies where A / C = - 1 / E the damping does not matter. Their amplitudes are
    equal for f = 1 / (1 + mu), then both E^2 = mu / (2 + mu) and |x|^2 = 1 + 2 / mu. A horizontal
    tangent requires a different z at each; the mean of their squares is
    z^2 = 3 mu / (8 (1 + mu)^3). The peak is then above the fixed points, by 0.2 % for mu = 0.1 and
    by 0.8 % for mu = 0.5; `magnifier` is that of the fixed points, the lower bound for any damping.
    J. P. Den Hartog, Mechanical Vibrations, section on the damped vibration absorber.
    """
    mu = _checked_ratio(mass_ratio)
    return AbsorberOptimum(
        tuning=1.0 / (1.0 + mu),
        damping_ratio=math.sqrt(3.0 * mu / (8.0 * (1.0 + mu) ** 3)),
        loss_factor=0.0,
        magnifier=math.sqrt(1.0 + 2.0 / mu),
    )


def rubber_optimum(mass_ratio: float) -> AbsorberOptimum:
    """Return the absorber whose damping is the loss factor of its spring.

    Notes
    -----
    With the loss factor h, h f^2 replaces the 2 z g of a viscous absorber, see `tuned_optimum`:
    fixed points and tuning are the same. With x = g^2, R = 1 + 2 / mu and C' = dC/dx a horizontal
    tangent there requires

        h^2 = (f^2 - x + R C C') / (R f^4 (1 + mu) E),

    and the mean of both values is h^2 = mu (3 + 2 mu) / (2 + mu). The peak is then above the fixed
    points by 1.3 % for mu = 0.05, 2.7 % for 0.1, 5.3 % for 0.2 and 13 % for 0.5.
    """
    mu = _checked_ratio(mass_ratio)
    return AbsorberOptimum(
        tuning=1.0 / (1.0 + mu),
        damping_ratio=0.0,
        loss_factor=math.sqrt(mu * (3.0 + 2.0 * mu) / (2.0 + mu)),
        magnifier=math.sqrt(1.0 + 2.0 / mu),
    )


def main_inertia(chain: Chain, node: str | int, mode: int = 1) -> tuple[float, float]:
    """Return the modal inertia of one mode at a node, and the mode's angular frequency.

    Returns
    -------
    float
        [kg m^2] or [kg].
    float
        [rad/s]

    Raises
    ------
    InputError
        If there is no such node or mode, or the node stands still in it.
    """
    place, modes = find_node(chain, node), chain.modes()
    count = modes.angular_frequencies.size - modes.rigid
    number = whole_within("mode", mode, 1, count, f"the chain has {count} elastic modes")
    column = modes.rigid + number - 1
    motion = float(modes.shapes[place, column])
    if abs(motion) < STANDS_STILL:
        raise InputError(
            f"node: given {chain.names[place]!r}, which does not move in mode {number}; allowed is one "
            "that moves, because nothing else drives a damper."
        )
    inertia = float(modes.modal_inertia[column]) / motion**2
    return inertia, float(modes.angular_frequencies[column])


def viscous_damper_for(
    chain: Chain,
    node: str | int,
    ring_inertia: float,
    *,
    mode: int = 1,
    hub_inertia: float = 0.0,
    name: str = "damper ring",
) -> ViscousDamper:
    """Return the optimum viscous damper with a given ring for one mode.

    Parameters
    ----------
    chain : Chain
        Torsional, without the damper but with its hub.
    ring_inertia : float
        [kg m^2]

    Raises
    ------
    InputError
        As `main_inertia` and `ViscousDamper`.
    """
    main, frequency = main_inertia(chain, node, mode)
    ring = positive_number("ring_inertia", ring_inertia, "kg m^2", "it works by its inertia")
    best = untuned_optimum(ring / main)
    damping = 2.0 * best.damping_ratio * ring * frequency
    return ViscousDamper(ring_inertia=ring, damping=damping, hub_inertia=hub_inertia, name=name)


def rubber_damper_for(
    chain: Chain,
    node: str | int,
    ring_inertia: float,
    *,
    mode: int = 1,
    hub_inertia: float = 0.0,
    name: str = "damper ring",
) -> RubberDamper:
    """Return the optimum rubber damper with a given ring for one mode; see `viscous_damper_for`.

    Raises
    ------
    InputError
        As `main_inertia` and `RubberDamper`.
    """
    main, frequency = main_inertia(chain, node, mode)
    ring = positive_number("ring_inertia", ring_inertia, "kg m^2", "it works by its inertia")
    best = rubber_optimum(ring / main)
    stiffness = ring * (best.tuning * frequency) ** 2
    return RubberDamper(
        ring_inertia=ring,
        stiffness=stiffness,
        loss_factor=best.loss_factor,
        hub_inertia=hub_inertia,
        name=name,
    )


def _checked_ratio(mass_ratio: float) -> float:
    return positive_number("mass_ratio", mass_ratio, "", "an absorber has inertia")
