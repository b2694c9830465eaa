"""The sections of engine files that vibration needs beyond cranks and flywheel, declared once."""

from typing import ClassVar, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, quantity_field


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

    @model_validator(mode="after")
    def _range_holds_the_stiffness(self) -> Self:
        for name, given, outside in (
            ("lowest_stiffness", self.lowest_stiffness, float.__gt__),
            ("highest_stiffness", self.highest_stiffness, float.__lt__),
        ):
            if given is not None and outside(given, self.stiffness):
                raise InputError(
                    f"bearings.{name}: given {given:g} N/m; allowed is a range that holds the stiffness of "
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
