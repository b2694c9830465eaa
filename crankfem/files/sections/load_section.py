"""The section of engine files with the load over the speed."""

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.units.units import PER_MINUTE


class LoadPoint(InputModel):
    """Load of the cylinders at one speed."""

    section: ClassVar[str] = "load.points"

    speed: float = quantity_field(
        "speed of the crankshaft", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    mean_effective_pressure: float = quantity_field(
        "indicated mean effective pressure at that speed", "Pa", 1e3, 1e7
    )
    peak_pressure: float | None = quantity_field(
        "largest gas pressure above ambient at that speed; by default from the combustion of [gas]",
        "Pa",
        1e4,
        1e8,
        default=None,
    )
    intake_pressure: float | None = quantity_field(
        "absolute pressure in the cylinder at the end of the intake at that speed; by default boost is "
        "proportional to the power",
        "Pa",
        1e4,
        2e6,
        default=None,
    )


class LoadSection(InputModel):
    """Load over the speed, besides full load as in [gas]; full load at all speeds without it."""

    section: ClassVar[str] = "load"

    law: Literal["constant", "propeller"] | None = Field(
        None,
        description="full load at all speeds, or that of a propeller, whose power is proportional to the "
        "cube of the speed; none if points are given",
    )
    points: tuple[LoadPoint, ...] = part_field(
        "load of the cylinders at several speeds, in place of a law", LoadPoint, many=True
    )

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        if (self.law is None) == (not self.points):
            given = "neither it nor points" if self.law is None else "both it and points"
            raise InputError(
                f"load.law: given {given}; allowed is one of the two, because each defines the load at all "
                "speeds."
            )
        speeds = [point.speed for point in self.points]
        if len(speeds) == 1 or len(set(speeds)) < len(speeds):
            raise InputError(
                f"load.points: given {len(speeds)} of {len(set(speeds))} different speeds; allowed are two "
                "or more, each speed once, because the load between them is interpolated."
            )
        for name in ("peak_pressure", "intake_pressure"):
            known = sum(getattr(point, name) is not None for point in self.points)
            if known not in (0, len(speeds)):
                raise InputError(
                    f"load.points: given {name} at {known} of {len(speeds)} speeds; allowed is all of them "
                    "or none, because it is interpolated between them."
                )
        return self
