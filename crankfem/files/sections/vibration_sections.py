"""The sections of engine files that vibration needs beyond cranks and flywheel, declared once."""

from typing import ClassVar, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, quantity_field


class Damping(InputModel):
    """Damping of engine and shaft. Without any value a measured magnifier of 40 is assumed."""

    section: ClassVar[str] = "damping"

    torsional_magnifier: float | None = quantity_field(
        "amplitude of every torsional mode at resonance beside its static one",
        "",
        minimum=1.0,
        maximum=1000.0,
        default=None,
    )
    axial_magnifier: float | None = quantity_field(
        "amplitude of every axial mode at resonance beside its static one",
        "",
        minimum=1.0,
        maximum=1000.0,
        default=None,
    )
    cylinder_damping: float | None = quantity_field(
        "absolute torsional damping at each cylinder",
        "N m s/rad",
        minimum=0.0,
        maximum=1e6,
        default=None,
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
    """What the engine drives, behind a coupling at the flywheel."""

    section: ClassVar[str] = "driven"

    inertia: float = quantity_field(
        "inertia of the driven machine, referred to the crankshaft",
        "kg m^2",
        minimum=1e-5,
        maximum=1e8,
    )
    coupling_stiffness: float = quantity_field(
        "torsional stiffness of the coupling", "N m/rad", minimum=1.0, maximum=1e12
    )
    coupling_loss_factor: float = quantity_field(
        "loss factor of the coupling", "", minimum=0.0, maximum=2.0, default=0.0
    )


class Bearings(InputModel):
    """Main bearings with their housing, alike along the shaft and in all directions."""

    section: ClassVar[str] = "bearings"

    stiffness: float = quantity_field("lateral stiffness", "N/m", minimum=1e5, maximum=1e13)
    damping: float = quantity_field(
        "lateral damping", "N s/m", minimum=0.0, maximum=1e10, default=0.0
    )


class ShaftLineFiles(InputModel):
    """What follows the flywheel, each as a chain file whose first node is the flywheel's place."""

    section: ClassVar[str] = "shaft_line"

    torsional: str | None = Field(
        None, description="chain file of kind torsional, beside the engine file or shipped"
    )
    axial: str | None = Field(
        None, description="chain file of kind axial, beside the engine file or shipped"
    )

    @model_validator(mode="after")
    def _names_a_file(self) -> Self:
        if not self.torsional and not self.axial:
            raise InputError(
                "shaft_line.torsional: given neither it nor axial; allowed is the name of a chain file in "
                "one of them or both, because they describe what follows the flywheel."
            )
        return self
