"""The two ends of a crankshaft, beyond the first and the last main journal."""

from typing import ClassVar, Self

from pydantic import model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, length_field


class ShaftEnds(InputModel):
    """A cylindrical free end and a round flange, each only if its two dimensions are given.

    Parameters
    ----------
    free_end_diameter, free_end_length : float, optional
        [m]
    flange_diameter, flange_thickness : float, optional
        [m]

    Raises
    ------
    InputError
        If one dimension of an end is given without the other, or out of range.
    """

    section: ClassVar[str] = "shaft_ends"

    free_end_diameter: float | None = length_field(
        "diameter of the shaft's free end", (0.001, 2.0), default=None
    )
    free_end_length: float | None = length_field(
        "length of the free end beyond the first main journal", (0.0003, 5.0), default=None
    )
    flange_diameter: float | None = length_field(
        "diameter of the flange", (0.001, 4.0), default=None
    )
    flange_thickness: float | None = length_field(
        "thickness of the flange behind the last main journal", (0.0002, 1.0), default=None
    )

    @model_validator(mode="after")
    def _both_or_none(self) -> Self:
        for first, second in (
            ("free_end_diameter", "free_end_length"),
            ("flange_diameter", "flange_thickness"),
        ):
            for given, missing in ((first, second), (second, first)):
                if getattr(self, given) is not None and getattr(self, missing) is None:
                    raise InputError(
                        f"{self.section}.{missing}: missing; it must be given together with {given}."
                    )
        return self
