"""Shaft lines: pieces in a row, and the chain built from them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Protocol, Self, get_args

import numpy as np
from pydantic import model_validator

from crankbase.array_checks import SMALLEST, nonnegative_number, positive_number
from crankbase.choices import check_choice, check_kind, check_some, whole_number, whole_within
from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.sentences import in_si
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.chains.coupling_damping import (
    LARGEST_PSI,
    MAGNIFIER,
    PSI,
    SMALLEST_MAGNIFIER,
    one_convention,
)
from dynamics.chains.dampers import TorsionalRing
from dynamics.chains.editing import with_ground
from dynamics.chains.varying import Variation, Varying, varied


class Driven(InputModel):
    """Driven machine behind a coupling at the flywheel."""

    section: ClassVar[str] = "driven"
    other_forms: ClassVar[dict[str, tuple[str, ...]]] = {
        "coupling_loss_factor": ("coupling_relative_damping", "coupling_magnifier")
    }

    inertia: float = quantity_field(
        "inertia of the coupled machine, referred to the crankshaft", "kg m^2", 1e-9, 1e8
    )
    coupling_stiffness: float = quantity_field(
        "torsional stiffness of the coupling", "N m/rad", 1e-4, 1e12
    )
    coupling_loss_factor: float = quantity_field(
        "loss factor of the coupling", "", 0.0, 2.0, default=0.0
    )
    coupling_relative_damping: float | None = quantity_field(
        PSI, "", 0.0, LARGEST_PSI, default=None
    )
    coupling_magnifier: float | None = quantity_field(
        MAGNIFIER, "", SMALLEST_MAGNIFIER, default=None
    )
    coupling_damping: float = quantity_field(
        "viscous damping of the coupling", "N m s/rad", 0.0, 1e8, default=0.0, feature=True
    )
    variation: Variation | None = part_field("how the coupling varies", Variation)

    @property
    def loss_factor(self) -> float:
        """Loss factor of the coupling, in whatever convention its damping is given."""
        return one_convention(
            f"{self.section}.coupling_",
            {
                "loss_factor": self.coupling_loss_factor,
                "relative_damping": self.coupling_relative_damping,
                "magnifier": self.coupling_magnifier,
            },
        )

    @model_validator(mode="after")
    def _has_one_convention(self) -> Self:
        _ = self.loss_factor
        return self

    @property
    def ring(self) -> TorsionalRing:
        """The machine behind its coupling, without its absolute damping."""
        return TorsionalRing(
            inertia=self.inertia,
            stiffness=self.coupling_stiffness,
            damping=self.coupling_damping,
            loss_factor=self.loss_factor,
            variation=self.variation,
        )


# The node of a machine behind a coupling, and those of what turns a machine that takes power.
DRIVEN = "driven machine"
PRIME_MOVERS = ("motor", "turbine", "engine")


class Driver(Driven):
    """Prime mover behind a coupling at the flywheel of a machine that takes power."""

    section = "driver"


class DrivenMachine(Driven):
    """A driven machine: one inertia behind a coupling on any node of a chain, by default the flywheel."""

    positional = (
        "inertia",
        "coupling_stiffness",
        "coupling_damping",
        "coupling_loss_factor",
        "damping",
        "name",
        "on",
    )

    damping: float = quantity_field(
        "absolute damping of the machine", "N m s/rad", 0.0, 1e8, default=0.0
    )
    name: str = DRIVEN
    on: str = "flywheel"

    def attached(self, chain: Chain) -> Chain:
        """Return the chain with this machine on its node."""
        wider = self.ring.attached(chain, self.on, self.name)
        return with_ground(wider, self.name, damping=self.damping)


class Propeller(InputModel):
    """A propeller with its entrained water.

    The water is given by its values, or as shares of the dry ones; 0.25 to 0.30 of the inertia and about
    0.60 of the mass are often assumed. It has no default, because it shifts the frequencies.
    """

    section = "propeller"
    positional = ("dry_inertia", "dry_mass", "entrained_inertia", "entrained_mass")

    dry_inertia: float = quantity_field("polar moment of inertia in air", "kg m^2", SMALLEST)
    dry_mass: float = quantity_field("mass in air", "kg", SMALLEST)
    entrained_inertia: float | None = quantity_field(
        "inertia of the entrained water in torsion", "kg m^2", 0.0, default=None
    )
    entrained_mass: float | None = quantity_field(
        "mass of the entrained water along the shaft", "kg", 0.0, default=None
    )
    entrained_inertia_share: float | None = quantity_field(
        "that inertia as a share of the dry one", "", 0.0, default=None
    )
    entrained_mass_share: float | None = quantity_field(
        "that mass as a share of the dry one", "", 0.0, default=None
    )
    damping: float = quantity_field("damping in torsion", "N m s/rad", 0.0, default=0.0)
    axial_damping: float = quantity_field("damping along the shaft", "N s/m", 0.0, default=0.0)
    name: str = "propeller"

    @model_validator(mode="after")
    def _has_its_water(self) -> Self:
        for name, usual in (
            ("entrained_inertia", "0.25 to 0.30"),
            ("entrained_mass", "about 0.60"),
        ):
            value, share = getattr(self, name), getattr(self, f"{name}_share")
            if (value is None) == (share is None):
                raise InputError(
                    f"propeller.{name}: given {'both' if value is not None else 'neither'} it and its "
                    f"share of the dry value; allowed is one of them (a share of {usual} is often "
                    "assumed), because water vibrates with the blades."
                )
        return self

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


Motion = Literal["torsional", "axial"]
BoreShape = Literal["cylindrical", "proportional"]
# Below this share of the smaller diameter a bore's closed form for torsion loses digits to
# cancellation, and its series in the fourth power of the share is exact with three terms.
SMALL_BORE = 0.05


class ElasticMaterial(Protocol):
    """Material of a shaft: E [Pa], G [Pa], density [kg/m^3]."""

    @property
    def youngs_modulus(self) -> float:
        """E [Pa]."""
        ...

    @property
    def shear_modulus(self) -> float:
        """G [Pa]."""
        ...

    @property
    def density(self) -> float:
        """[kg/m^3]."""
        ...


MOST_PARTS = 10_000


@dataclass(frozen=True)
class ShaftMaterial:
    """Elastic constants and density of a shaft; the default is steel, 210 GPa and nu = 0.3.

    Parameters
    ----------
    youngs_modulus, shear_modulus : float
        E and G [Pa].
    density : float
        [kg/m^3]
    """

    youngs_modulus: float = 2.1e11
    shear_modulus: float = 2.1e11 / 2.6
    density: float = 7850.0

    def __post_init__(self) -> None:
        why = "the material resists"
        positive_number("material.youngs_modulus", self.youngs_modulus, "Pa", why)
        positive_number("material.shear_modulus", self.shear_modulus, "Pa", why)
        positive_number("material.density", self.density, "kg/m^3", "the material has mass")


SHAFT_STEEL = ShaftMaterial()


@dataclass(frozen=True)
class ShaftCone:
    """A conical piece of shaft, solid or bored; a cylinder where both diameters are equal.

    Parameters
    ----------
    length : float
        [m]
    left_diameter, right_diameter : float
        Outside, at either end [m].
    bore : float, optional
        Diameter of a cylindrical bore, or at the left end that of a proportional one [m].
    bore_shape : {"cylindrical", "proportional"}, optional
        A proportional bore is a constant share of the outer diameter.
    material : optional
        Anything with youngs_modulus, shear_modulus and density; steel by default.

    Raises
    ------
    InputError
        If a size is not above zero, or the bore leaves no wall.

    Notes
    -----
    With D linear from D_1 to D_2 over L, and a bore d, the integrals along the piece are

        solid: int dz / D^2 = L / (D_1 D_2),
               int dz / D^4 = L (D_1^2 + D_1 D_2 + D_2^2) / (3 D_1^3 D_2^3),
               int D^2 dz = L (D_1^2 + D_1 D_2 + D_2^2) / 3,
               int D^4 dz = L (D_1^4 + D_1^3 D_2 + ... + D_2^4) / 5,

    for a proportional bore the same, with D^2 - d^2 = (1 - s^2) D^2 and D^4 - d^4 = (1 - s^4) D^4. For
    a cylindrical bore, by partial fractions, with t = D_2 - D_1,

        int dz / (D^2 - d^2) = L / (2 d t) ln(1 + 2 d t / ((D_2 + d)(D_1 - d))),
        int dz / (D^4 - d^4) = (1 / (2 d^2)) (the former - L / (d t) atan(d t / (d^2 + D_1 D_2))).
    """

    length: float
    left_diameter: float
    right_diameter: float
    bore: float = 0.0
    bore_shape: BoreShape = "cylindrical"
    material: ElasticMaterial = SHAFT_STEEL
    name: str = ""

    def __post_init__(self) -> None:
        why = "a shaft has a cross section"
        positive_number("shaft.length", self.length, "m", "a piece of shaft has a length")
        left = positive_number("shaft.left_diameter", self.left_diameter, "m", why)
        right = positive_number("shaft.right_diameter", self.right_diameter, "m", why)
        bore = nonnegative_number("shaft.bore", self.bore, "m", "it is a diameter, or none")
        near = "closed forms exist for these; others are near to cones in a row"
        check_choice("shaft.bore_shape", self.bore_shape, get_args(BoreShape), near)
        wall = left if self.bore_shape == "proportional" else min(left, right)
        if bore >= wall:
            raise InputError(
                f"shaft.bore: given {in_si(bore, 'm')}; allowed is less than {in_si(wall, 'm')}, because a "
                "wall is left around it."
            )

    @property
    def torsional_compliance(self) -> float:
        """Twist per torque [rad/(N m)]."""
        return 32.0 / (math.pi * self.material.shear_modulus) * self._inverse_fourth_powers()

    @property
    def axial_compliance(self) -> float:
        """Lengthening per force [m/N]."""
        return 4.0 / (math.pi * self.material.youngs_modulus) * self._inverse_squares()

    @property
    def mass(self) -> float:
        """[kg]."""
        return 0.25 * math.pi * self.material.density * self._powers(2)

    @property
    def polar_inertia(self) -> float:
        """Moment of inertia about the shaft axis [kg m^2]."""
        return math.pi / 32.0 * self.material.density * self._powers(4)

    @property
    def section_modulus(self) -> float:
        """Smallest torsional section modulus I_p / (D / 2), without stress concentration [m^3]."""
        outer = min(self.left_diameter, self.right_diameter)
        inner = self._bore_at(outer)
        return math.pi / 16.0 * (outer**4 - inner**4) / outer

    def divided(self, parts: int) -> tuple["ShaftCone", ...]:
        """Return the piece divided into equally long ones, at most 10,000."""
        why = "a piece of a shaft is cut into some parts"
        parts = whole_within("parts", parts, 1, MOST_PARTS, why)
        step = (self.right_diameter - self.left_diameter) / parts
        diameters = [self.left_diameter + step * number for number in range(parts)]
        return tuple(
            replace(
                self,
                length=self.length / parts,
                left_diameter=left,
                right_diameter=right,
                bore=self._bore_at(left),
            )
            for left, right in zip(diameters, [*diameters[1:], self.right_diameter], strict=True)
        )

    def between(self, start: float, end: float) -> "ShaftCone":
        """Return the part between two distances from the left end [m]."""
        widening = (self.right_diameter - self.left_diameter) / self.length
        left, right = (self.left_diameter + widening * place for place in (start, end))
        return replace(
            self,
            length=end - start,
            left_diameter=left,
            right_diameter=right,
            bore=self._bore_at(left),
        )

    def _bore_at(self, diameter: float) -> float:
        if self.bore_shape == "cylindrical":
            return self.bore
        return self.bore * diameter / self.left_diameter

    def _powers(self, power: int) -> float:
        """Return the integral of D^p - d^p along the piece, p even."""
        first, last = self.left_diameter, self.right_diameter
        outer = _power_sum(first, last, power) / (power + 1)
        if self.bore_shape == "proportional":
            return self.length * outer * (1.0 - (self.bore / first) ** power)
        return self.length * (outer - self.bore**power)

    def _inverse_squares(self) -> float:
        """Return the integral of 1 / (D^2 - d^2) along the piece."""
        first, last, bore = self.left_diameter, self.right_diameter, self.bore
        if self.bore_shape == "proportional":
            return self.length / (first * last * (1.0 - (bore / first) ** 2))
        twice = 2.0 * bore * (last - first)
        if abs(twice) < SMALLEST:  # the logarithm's limit
            return self.length / (first * last - bore**2)
        return self.length / twice * math.log1p(twice / ((last + bore) * (first - bore)))

    def _inverse_fourth_powers(self) -> float:
        """Return the integral of 1 / (D^4 - d^4) along the piece."""
        first, last, bore = self.left_diameter, self.right_diameter, self.bore
        if self.bore_shape == "proportional":
            solid = self.length * _inverse_powers(first, last, 4)
            return solid / (1.0 - (bore / first) ** 4)
        widening = last - first
        if widening == 0.0:
            return self.length / (first**4 - bore**4)
        if bore < SMALL_BORE * min(first, last):
            terms = (bore**power * _inverse_powers(first, last, power + 4) for power in (0, 4, 8))
            return self.length * sum(terms)
        angle = math.atan(bore * widening / (bore**2 + first * last))
        rest = self._inverse_squares() - self.length / (bore * widening) * angle
        return rest / (2.0 * bore**2)


def _power_sum(first: float, last: float, power: int) -> float:
    """Return (b^(p+1) - a^(p+1)) / (b - a) = a^p + a^(p-1) b + ... + b^p."""
    return math.fsum(first ** (power - k) * last**k for k in range(power + 1))


def _inverse_powers(first: float, last: float, power: int) -> float:
    """Return the mean of 1 / D^p from D = a to b: (a^(1-p) - b^(1-p)) / ((p - 1)(b - a))."""
    size = (power - 1) * (first * last) ** (power - 1)
    return _power_sum(first, last, power - 2) / size


def shaft_cylinder(
    length: float,
    diameter: float,
    bore: float = 0.0,
    material: ElasticMaterial = SHAFT_STEEL,
    name: str = "",
) -> ShaftCone:
    """Return a cylindrical piece of shaft, solid or hollow.

    Parameters
    ----------
    length, diameter : float
        [m]
    """
    outer = positive_number("shaft.diameter", diameter, "m", "a shaft has a cross section")
    return ShaftCone(length, outer, outer, bore, "cylindrical", material, name)


def shaft_flange(
    thickness: float,
    diameter: float,
    bore: float = 0.0,
    material: ElasticMaterial = SHAFT_STEEL,
    name: str = "",
) -> ShaftCone:
    """Return a flange: a short cylinder of large diameter, with inertia and little compliance.

    Parameters
    ----------
    thickness, diameter : float
        [m]

    Notes
    -----
    The compliance is that of the whole cross section. As the shaft's torque does not reach the rim of
    a thin flange, this is a lower bound. Bolts and joint count as rigid.
    """
    positive_number("flange.thickness", thickness, "m", "a flange has a thickness")
    return shaft_cylinder(thickness, diameter, bore, material, name)


class Coupling(InputModel):
    """A coupling by its data sheet: stiffness, damping, and the inertia of its two halves.

    Its stiffness is k (1 + i loss_factor). Data sheets give the relative damping psi, the energy lost in a
    cycle over the largest stored: loss_factor = psi / (2 pi).
    """

    section = "coupling"
    positional = (
        *("torsional_stiffness", "axial_stiffness", "left_inertia", "right_inertia"),
        *("left_mass", "right_mass"),
    )

    torsional_stiffness: float | None = quantity_field(
        "dynamic stiffness, for torsional chains", "N m/rad", SMALLEST, default=None
    )
    axial_stiffness: float | None = quantity_field(
        "dynamic stiffness, for axial chains", "N/m", SMALLEST, default=None
    )
    left_inertia: float = quantity_field("inertia of a half", "kg m^2", 0.0, default=0.0)
    right_inertia: float = quantity_field("inertia of the other", "kg m^2", 0.0, default=0.0)
    left_mass: float = quantity_field("mass of a half", "kg", 0.0, default=0.0)
    right_mass: float = quantity_field("mass of the other", "kg", 0.0, default=0.0)
    torsional_damping: float = quantity_field("viscous damping", "N m s/rad", 0.0, default=0.0)
    axial_damping: float = quantity_field("viscous damping", "N s/m", 0.0, default=0.0)
    loss_factor: float = quantity_field("hysteretic damping", "", 0.0, default=0.0)
    name: str = ""
    variation: Variation | None = part_field("how stiffness and damping vary", Variation)

    def stiffness(self, kind: Motion) -> float:
        """Return the stiffness for one kind of motion."""
        value = self.torsional_stiffness if kind == "torsional" else self.axial_stiffness
        if value is None:
            raise InputError(
                f"coupling.{kind}_stiffness: given none; allowed are finite numbers of more than zero, "
                f"because the chain is {kind}."
            )
        return value


class RigidBody(InputModel):
    """A rigid body on a shaft: a disk, a wheel, a rotor."""

    section = "body"
    positional = ("inertia", "mass", "name")

    inertia: float = quantity_field("polar moment of inertia", "kg m^2", 0.0)
    mass: float = quantity_field("mass", "kg", 0.0)
    name: str


Piece = ShaftCone | Coupling | RigidBody | Propeller
Spreading = Literal["consistent", "lumped"]


@frozen("name", "length [m]", "mass [kg]", "polar_inertia [kg m^2]", "pieces")
class ShaftLine:
    """Pieces of shaft, couplings, bodies and a propeller in a row, from left to right.

    Parameters
    ----------
    pieces : sequence of ShaftCone, Coupling, RigidBody or Propeller
        Bodies and propellers are at the joint given by their position in the row.
    name : str, optional
        Joints without a body are named by it and their number.

    Raises
    ------
    InputError
        If there is no piece, or an element is of another type.
    """

    pieces: Sequence[Piece]
    name: str = "shaft"

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", tuple(self.pieces))
        check_some("pieces", self.pieces, "a shaft line has pieces")
        for place, piece in enumerate(self.pieces):
            allowed = "a piece of shaft, a coupling, a body or a propeller"
            check_kind(f"pieces[{place}]", piece, Piece, allowed)

    @property
    def length(self) -> float:
        """Length of its pieces of shaft [m]."""
        return sum(piece.length for piece in self._shafts)

    @property
    def mass(self) -> float:
        """Mass of its pieces of shaft, without couplings and bodies [kg]."""
        return sum(piece.mass for piece in self._shafts)

    @property
    def polar_inertia(self) -> float:
        """Inertia of its pieces of shaft, without couplings and bodies [kg m^2]."""
        return sum(piece.polar_inertia for piece in self._shafts)

    @property
    def section_modulus(self) -> float:
        """Smallest torsional section modulus of its pieces of shaft [m^3]."""
        reason = "stress belongs to the cross section of a piece of shaft"
        check_some("pieces", self._shafts, reason)
        return min(piece.section_modulus for piece in self._shafts)

    def compliance(self, kind: Motion) -> float:
        """Return the compliance from end to end [rad/(N m)] or [m/N]."""
        check_choice("kind", kind, get_args(Motion), "a chain is one of them")
        return sum(_compliance(piece, kind) for piece in self.pieces)

    def chain(
        self,
        kind: Motion = "torsional",
        *,
        parts: int = 1,
        inertia: Spreading = "consistent",
        loss_factor: float = 0.0,
    ) -> Chain:
        """Return the chain of the line.

        Parameters
        ----------
        parts : int, optional
            Number of elements for each piece of shaft.
        inertia : {"consistent", "lumped"}, optional
            Distributed along each element, which makes frequencies too high, or half at either end,
            which makes those of a uniform shaft too low; both errors are proportional to the square of the
            element length.
        loss_factor : float, optional
            Of the pieces of shaft; couplings have their own.

        Returns
        -------
        Chain
            A row; its first node is the line's left end.

        Raises
        ------
        InputError
            If a choice is unknown, a coupling has no stiffness, or a joint between two couplings
            has no inertia.
        """
        check_choice("kind", kind, get_args(Motion), "a chain is one of them")
        check_choice("inertia", inertia, get_args(Spreading), "these are the ways to spread it")
        count = whole_number("parts", parts, 1, "a piece is at least one element")
        loss = nonnegative_number("loss_factor", loss_factor, "", "damping takes energy away")
        row = _Row()
        for piece in self.pieces:
            if isinstance(piece, ShaftCone):
                for part in piece.divided(count):
                    row.add_shaft(part, kind, loss, lumped=inertia == "lumped")
            elif isinstance(piece, Coupling):
                row.add_coupling(piece, kind)
            else:
                row.add_body(piece, kind)
        return row.chain(self.name)

    @property
    def _shafts(self) -> tuple[ShaftCone, ...]:
        return tuple(piece for piece in self.pieces if isinstance(piece, ShaftCone))


class _Row:
    """The values of a row of nodes, extended to the right."""

    def __init__(self) -> None:
        self.inertia, self.ground_damping = [0.0], [0.0]
        self.names: list[list[str]] = [[]]
        # Of each element: stiffness, damping, loss factor, inertia spread along it.
        self.elements: list[tuple[float, float, float, float]] = []
        self.varying: list[Varying] = []

    def add_shaft(self, part: ShaftCone, kind: Motion, loss: float, *, lumped: bool) -> None:
        spread = part.polar_inertia if kind == "torsional" else part.mass
        ends = spread / 2.0 if lumped else 0.0
        self.inertia[-1] += ends
        self._element(1.0 / _compliance(part, kind), 0.0, loss, 0.0 if lumped else spread, ends)

    def add_coupling(self, piece: Coupling, kind: Motion) -> None:
        torsional = kind == "torsional"
        self.inertia[-1] += piece.left_inertia if torsional else piece.left_mass
        right = piece.right_inertia if torsional else piece.right_mass
        damping = piece.torsional_damping if torsional else piece.axial_damping
        stiffness, loss, damping, law = varied(
            piece.variation, piece.stiffness(kind), piece.loss_factor, damping
        )
        if law is not None:
            self.varying.append(Varying(len(self.elements), law))
        self._element(stiffness, damping, loss, 0.0, right)

    def add_body(self, piece: RigidBody | Propeller, kind: Motion) -> None:
        self.inertia[-1] += piece.inertia if kind == "torsional" else piece.mass
        self.names[-1].append(piece.name)
        if isinstance(piece, Propeller):
            self.ground_damping[-1] += piece.damping if kind == "torsional" else piece.axial_damping

    def chain(self, name: str) -> Chain:
        stiffness, damping, loss_factor, spread = np.array(self.elements).reshape(-1, 4).T
        return Chain(
            self.inertia,
            stiffness,
            damping=damping,
            loss_factor=loss_factor,
            ground_damping=self.ground_damping,
            distributed_inertia=spread,
            varying=self.varying,
            names=[
                ", ".join(bodies) if bodies else f"{name} {number}"
                for number, bodies in enumerate(self.names)
            ],
        )

    def _element(
        self, stiffness: float, damping: float, loss: float, spread: float, right: float
    ) -> None:
        self.elements.append((stiffness, damping, loss, spread))
        self.inertia.append(right)
        self.ground_damping.append(0.0)
        self.names.append([])


def _compliance(piece: Piece, kind: Motion) -> float:
    if isinstance(piece, ShaftCone):
        return piece.torsional_compliance if kind == "torsional" else piece.axial_compliance
    return 1.0 / piece.stiffness(kind) if isinstance(piece, Coupling) else 0.0
