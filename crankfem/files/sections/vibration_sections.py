"""The sections of engine files that vibration needs beyond cranks and flywheel: dampers too."""

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from dynamics.chains.dampers import AxialDamper, RubberDamper, TorsionalDamper, ViscousDamper
from dynamics.chains.shaft_line import DrivenMachine
from dynamics.chains.varying import Variation


class Damping(InputModel):
    """Damping of engine and shaft. Without any value a measured magnifier of 40 is assumed.

    An assumed magnifier damps only parts without damping of their own, a given one every mode.
    """

    section: ClassVar[str] = "damping"

    torsional_magnifier: float | None = quantity_field(
        "dynamic magnifier of every torsional mode: amplitude at resonance divided by the static one",
        "",
        minimum=1.0,
        maximum=1000.0,
        default=None,
    )
    axial_magnifier: float | None = quantity_field(
        "dynamic magnifier of every axial mode: amplitude at resonance divided by the static one",
        "",
        minimum=1.0,
        maximum=1000.0,
        default=None,
    )
    bending_magnifier: float | None = quantity_field(
        "dynamic magnifier of the bending modes of the whole crankshaft: amplitude at resonance divided by "
        "the static one",
        "",
        minimum=1.0,
        maximum=1000.0,
        default=None,
    )
    cylinder_damping: float | None = quantity_field(
        "absolute torsional damping at each cylinder", "N m s/rad", 0.0, 1e6, default=None
    )
    loss_factor: float | None = quantity_field(
        "loss factor of the throws in torsion: their stiffness is k (1 + i loss_factor)",
        "",
        minimum=0.0,
        maximum=0.5,
        default=None,
    )

    @property
    def damps_torsion(self) -> bool:
        """Whether cylinders or throws have damping of their own."""
        return bool(self.cylinder_damping or self.loss_factor)


class Driven(InputModel):
    """Driven machine behind a coupling at the flywheel."""

    section: ClassVar[str] = "driven"

    inertia: float = quantity_field(
        "inertia of the driven machine, referred to the crankshaft", "kg m^2", 1e-9, 1e8
    )
    coupling_stiffness: float = quantity_field(
        "torsional stiffness of the coupling", "N m/rad", 1e-4, 1e12
    )
    coupling_loss_factor: float = quantity_field(
        "loss factor of the coupling", "", 0.0, 2.0, default=0.0
    )
    variation: Variation | None = part_field("how the coupling varies", Variation)

    def machine(self) -> DrivenMachine:
        """Return the machine behind its coupling."""
        return DrivenMachine(
            self.inertia,
            self.coupling_stiffness,
            coupling_loss_factor=self.coupling_loss_factor,
            coupling_variation=self.variation,
        )


class Bearings(InputModel):
    """Main bearings with their housing, equal along the shaft and in all directions."""

    section: ClassVar[str] = "bearings"

    stiffness: float = quantity_field("lateral stiffness", "N/m", 1e5, 1e13)
    lowest_stiffness: float | None = quantity_field(
        "lowest possible lateral stiffness", "N/m", 1e5, 1e13, default=None
    )
    highest_stiffness: float | None = quantity_field(
        "highest possible lateral stiffness", "N/m", 1e5, 1e13, default=None
    )
    damping: float = quantity_field("lateral damping", "N s/m", 0.0, 1e10, default=0.0)
    variation: Variation | None = part_field("how stiffness and damping vary", Variation)

    @model_validator(mode="after")
    def _range_holds_the_stiffness(self) -> Self:
        for name, end, outside in (
            ("lowest_stiffness", self.lowest_stiffness, float.__gt__),
            ("highest_stiffness", self.highest_stiffness, float.__lt__),
        ):
            if end is not None and outside(end, self.stiffness):
                raise InputError(
                    f"bearings.{name}: given {end:g} N/m; allowed is a range that holds the stiffness of "
                    f"{self.stiffness:g} N/m, because that is its nominal value."
                )
        return self


class ShaftLineFiles(InputModel):
    """Chains behind the flywheel, each as a chain file whose first node is its place; or the whole plant."""

    section: ClassVar[str] = "shaft_line"

    torsional: str | None = Field(
        None,
        description="chain file of kind torsional, in the folder of the engine file, or shipped",
    )
    axial: str | None = Field(
        None, description="chain file of kind axial, in the folder of the engine file, or shipped"
    )
    plant: str | None = Field(
        None,
        description="torsional chain file of the whole plant as its maker gives it, from the free end, in "
        "place of the chain calculated from the throws; its crank nodes have the usual names "
        '("cylinder 1" or "throw 1" and so on)',
    )

    @model_validator(mode="after")
    def _names_a_file(self) -> Self:
        if not self.torsional and not self.axial and not self.plant:
            raise InputError(
                "shaft_line.torsional: given neither it nor axial; allowed is the name of a chain file in "
                "one of them or both, because they describe what follows the flywheel."
            )
        if self.torsional and self.plant:
            raise InputError(
                "shaft_line.plant: given together with torsional; allowed is one of the two, because the "
                "chain of the whole plant has what follows the flywheel."
            )
        return self


TorsionalKind = Literal["viscous", "rubber"]
# The data of each kind in an engine file, beside the inertia of the ring.
DATA = {"viscous": ("damping",), "rubber": ("stiffness", "loss_factor")}


class TorsionalDamperSection(InputModel):
    """Torsional damper at the free end: a ring in oil, or a ring on rubber."""

    section: ClassVar[str] = "torsional_damper"

    kind: TorsionalKind = Field(description="viscous or rubber")
    ring_inertia: float = quantity_field(
        "inertia of the ring", "kg m^2", minimum=1e-10, maximum=1e6
    )
    damping: float | None = quantity_field(
        "torque per relative speed of ring and hub, for kind viscous",
        "N m s/rad",
        minimum=1e-6,
        maximum=1e8,
        default=None,
    )
    stiffness: float | None = quantity_field(
        "torsional stiffness of the rubber, for kind rubber",
        "N m/rad",
        minimum=1e-3,
        maximum=1e10,
        default=None,
    )
    loss_factor: float | None = quantity_field(
        "loss factor of the rubber, for kind rubber", "", minimum=0.0, maximum=2.0, default=None
    )

    @model_validator(mode="after")
    def _has_its_data(self) -> Self:
        needed = [f"{' and '.join(names)} for {kind}" for kind, names in DATA.items()]
        for name in dict.fromkeys(name for names in DATA.values() for name in names):
            present = getattr(self, name) is not None
            if present != (name in DATA[self.kind]):
                raise InputError(
                    f"torsional_damper.{name}: {'given' if present else 'not given'} with kind "
                    f"{self.kind}; allowed are {', '.join(needed)}, because these are their data."
                )
        return self

    def damper(self) -> TorsionalDamper:
        """Return the damper; its hub is part of the free end."""
        data = {name: getattr(self, name) for name in DATA[self.kind]}
        if self.kind == "viscous":
            return ViscousDamper(self.ring_inertia, **data)
        return RubberDamper(self.ring_inertia, **data)


class AxialDamperSection(InputModel):
    """Axial damper at the free end: a piston on the shaft in oil."""

    section: ClassVar[str] = "axial_damper"

    damping: float = quantity_field(
        "force per speed of the free end", "N s/m", minimum=1.0, maximum=1e10
    )
    stiffness: float = quantity_field(
        "stiffness of its oil to ground", "N/m", minimum=0.0, maximum=1e12, default=0.0
    )

    def damper(self) -> AxialDamper:
        """Return the damper; its collar is part of the free end."""
        return AxialDamper(self.damping, self.stiffness)


def part_quantity(meaning: str, unit: str, default: Any = 0.0) -> Any:
    """Declare a quantity of a part of a chain; with a default it is absent unless given."""
    # What need not be there may be zero; the rest is checked where it is used, to be above zero.
    return quantity_field(
        meaning,
        unit,
        minimum=0.0 if default == 0.0 else None,
        default=default,
        feature=default is not ...,
    )


class TorsionalDamperPart(InputModel):
    """A torsional damper."""

    type: TorsionalKind = Field(description="viscous, or rubber")
    node: str = Field(description="name of its node")
    name: str = Field(
        "damper ring", description="of the ring's node", json_schema_extra={"feature": True}
    )
    ring_inertia: float = part_quantity("inertia of the ring", "kg m^2", ...)
    hub_inertia: float = part_quantity("inertia of hub or housing", "kg m^2")
    damping: float = part_quantity("viscous damping", "N m s/rad")
    stiffness: float | None = part_quantity("dynamic stiffness of the rubber", "N m/rad", None)
    loss_factor: float = quantity_field(
        "loss factor, hysteretic damping", "", minimum=0.0, maximum=2.0, default=0.0, feature=True
    )

    def damper(self, field: str) -> TorsionalDamper:
        """Return the damper; `field` is what messages call it."""
        if self.type == "rubber":
            if self.stiffness is None:
                raise InputError(
                    f"{field}.stiffness: missing; allowed are numbers above 0 N m/rad, because rubber "
                    "joins the ring to the shaft."
                )
            return RubberDamper(
                self.ring_inertia,
                self.stiffness,
                self.loss_factor,
                self.damping,
                self.hub_inertia,
                self.name,
            )
        for name in ("stiffness", "loss_factor"):
            if getattr(self, name):
                raise InputError(
                    f"{field}.{name}: given for a viscous damper; allowed is a rubber one, because oil "
                    "alone joins the ring to the shaft."
                )
        return ViscousDamper(self.ring_inertia, self.damping, self.hub_inertia, self.name)


class AxialDamperPart(InputModel):
    """A damper against axial vibration."""

    node: str = Field(description="name of its node")
    damping: float = part_quantity("force per speed", "N s/m", ...)
    stiffness: float = part_quantity("stiffness of oil and housing", "N/m")
    mass: float = part_quantity("mass of the collar", "kg")

    def damper(self, _field: str) -> AxialDamper:
        """Return the damper."""
        return AxialDamper(self.damping, self.stiffness, self.mass)
