"""The sections of engine files that vibration needs beyond cranks and flywheel: dampers too."""

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.model import InputModel, field_of, part_field, quantity_field, range_text
from crankbase.sentences import amount
from dynamics.chains.dampers import AxialDamper, RubberDamper, TorsionalDamper, ViscousDamper
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


# Lateral stiffness of a main bearing (oil film, cap and wall) per journal diameter, where the file gives
# none. An assumption of the order of magnitude, no measurement: it makes 0.5e9 N/m of a journal of 50 mm
# and 2e9 N/m of one of 200 mm; hence a range of ten times less to ten times more.
ASSUMED_PER_DIAMETER = 1e10  # N/m per m
ASSUMED_RANGE = 10.0
# Steps of the range on either side of the nominal value: seven values in all.
STEPS = 3


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

    @property
    def lowest(self) -> float:
        """Lower end of the range [N/m]; the stiffness itself without one."""
        return self.lowest_stiffness or self.stiffness

    @property
    def highest(self) -> float:
        """Upper end of the range [N/m]; the stiffness itself without one."""
        return self.highest_stiffness or self.stiffness

    @property
    def sweep(self) -> Array:
        """Seven values over the range, with equal ratios on either side of the nominal one in the middle.

        A single value if there is no range.
        """
        if self.lowest == self.highest:
            return np.array([self.stiffness])
        below = np.geomspace(self.lowest, self.stiffness, STEPS + 1)
        above = np.geomspace(self.stiffness, self.highest, STEPS + 1)
        return np.concatenate((below, above[1:]))

    @model_validator(mode="after")
    def _range_holds_the_stiffness(self) -> Self:
        for name, end, outside in (
            ("lowest_stiffness", self.lowest_stiffness, float.__gt__),
            ("highest_stiffness", self.highest_stiffness, float.__lt__),
        ):
            if end is not None and outside(end, self.stiffness):
                raise InputError(
                    f"bearings.{name}: given {amount(end, 'N/m')}; allowed is a range that holds the "
                    f"stiffness of {amount(self.stiffness, 'N/m')}, because that is its nominal value."
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
    bearings: tuple[float, ...] | None = quantity_field(
        "distances of the bearings of its pieces of shaft from the flywheel",
        "m",
        default=None,
    )
    bearing_stiffness: float | None = quantity_field(
        "lateral stiffness of each of these bearings", "N/m", 1e5, 1e13, default=None
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
DAMPERS: dict[str, type[TorsionalDamper]] = {"viscous": ViscousDamper, "rubber": RubberDamper}


def _of_kind(kind: str, name: str) -> Any:
    """Declare a field that one kind of damper has."""
    model = DAMPERS[kind]
    text = f"{model.model_fields[name].description}, for kind {kind}"
    return field_of(model, name, default=None, description=text, feature=True)


def damper_of(kind: str, known: dict[str, Any], field: str) -> TorsionalDamper:
    """Return the damper of a kind from the fields of a record; messages call it `field`."""
    model = DAMPERS[kind]
    data = {name: known[name] for name in known if known[name] is not None}
    for name in data.keys() - model.model_fields.keys():
        if any(name in other.model_fields for other in DAMPERS.values()):
            raise InputError(
                f"{field}.{name}: given for a {kind} damper; allowed is another kind, because this one "
                "has no such part."
            )
    for name, info in model.model_fields.items():
        if info.is_required() and name not in data:
            raise InputError(
                f"{field}.{name}: missing; allowed is {range_text(info)} for a {kind} damper."
            )
    return model(**{name: data[name] for name in data if name in model.model_fields})


# The data of each kind in an engine file, beside the inertia of the ring.
DATA = {"viscous": ("damping",), "rubber": ("stiffness", "loss_factor")}


class TorsionalDamperSection(InputModel):
    """Torsional damper at the free end: a ring in oil, or a ring on rubber."""

    section: ClassVar[str] = "torsional_damper"

    kind: TorsionalKind = Field(description="viscous or rubber")
    ring_inertia: float = field_of(ViscousDamper, "ring_inertia")
    damping: float | None = _of_kind("viscous", "damping")
    stiffness: float | None = _of_kind("rubber", "stiffness")
    loss_factor: float | None = _of_kind("rubber", "loss_factor")
    variation: Variation | None = _of_kind("rubber", "variation")

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
        return damper_of(self.kind, dict(self), "torsional_damper")


class AxialDamperSection(InputModel):
    """Axial damper at the free end: a piston on the shaft in oil."""

    section: ClassVar[str] = "axial_damper"

    damping: float = quantity_field(
        "force per speed of the free end", "N s/m", minimum=1.0, maximum=1e10
    )
    stiffness: float = field_of(
        AxialDamper, "stiffness", description="stiffness of its oil to ground", feature=False
    )

    def damper(self) -> AxialDamper:
        """Return the damper; its collar is part of the free end."""
        return AxialDamper(damping=self.damping, stiffness=self.stiffness)


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
    name: str = field_of(ViscousDamper, "name")
    ring_inertia: float = field_of(ViscousDamper, "ring_inertia")
    hub_inertia: float = field_of(ViscousDamper, "hub_inertia")
    damping: float | None = field_of(
        RubberDamper, "damping", description="viscous damping", default=None
    )
    stiffness: float | None = _of_kind("rubber", "stiffness")
    loss_factor: float | None = _of_kind("rubber", "loss_factor")
    variation: Variation | None = _of_kind("rubber", "variation")

    def damper(self, field: str) -> TorsionalDamper:
        """Return the damper; `field` is what messages call it."""
        return damper_of(self.type, dict(self), field)


class AxialDamperPart(AxialDamper):
    """A damper against axial vibration."""

    node: str = Field(description="name of its node")

    def damper(self, _field: str) -> AxialDamper:
        """Return the damper."""
        return self
