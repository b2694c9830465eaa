"""The section [study] of a file, field by field."""

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, StrictBool, field_validator, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, quantity_field
from fem.wished_accuracy import COMPLIANCE_ACCURACY
from regression.plans.designs import LARGEST_DESIGN, TAKERS, DesignKind
from regression.plans.plan import StudyPlan


class StudySection(InputModel):
    """Factors of a study, their ranges and the design."""

    section: ClassVar[str] = "study"
    choices = frozenset(
        {"held_out", "seed", "accuracy", "stresses", "constraints", "factors", "relations"}
    )

    design: DesignKind = Field("full factorial", description="which designs are run and fitted")
    runs: int | None = quantity_field(
        "number of runs of a Latin hypercube or a Sobol sequence",
        "",
        minimum=1,
        maximum=LARGEST_DESIGN,
        default=None,
    )
    resolution: Literal["III", "IV", "V", "VI", "VII", "VIII"] | None = Field(
        None, description="of a fractional factorial, or of the corners of a central composite"
    )
    generators: str | None = Field(
        None, description='of a fractional factorial in place of a resolution, like "a b c abc"'
    )
    face: Literal["faced", "inscribed", "circumscribed"] | None = Field(
        None, description="position of the star points of a central composite"
    )
    file: str | None = Field(
        None, description="CSV file of your own runs, in the folder of the study file"
    )
    held_out: int = quantity_field(
        "number of further designs that judge the fits",
        "",
        minimum=1,
        maximum=1000,
        default=StudyPlan.held_out,
    )
    seed: int = quantity_field(
        "seed of all random draws", "", minimum=0, maximum=2**31 - 1, default=StudyPlan.seed
    )
    accuracy: float = quantity_field(
        "relative accuracy of each design's axial compliance",
        "",
        minimum=COMPLIANCE_ACCURACY.least,
        maximum=COMPLIANCE_ACCURACY.most,
        default=StudyPlan.accuracy,
    )
    stresses: StrictBool = Field(
        StudyPlan.stresses,
        description="whether to compute the largest stress concentration factor at the fillets too",
    )
    constraints: tuple[Any, ...] = Field(
        default_factory=tuple,
        description='comparisons that every design fulfills, like "web_thickness >= 0.25 * pin_diameter"',
    )
    factors: dict[str, Any] = Field(
        default_factory=dict, description="section [study.factors] of levels and ranges"
    )
    relations: dict[str, Any] = Field(
        default_factory=dict,
        description="section [study.relations] of dimensions that follow from others",
    )
    throw: str | None = Field(
        None, description="which of several throws varies; by default the one at the free end"
    )

    @field_validator("design", mode="before")
    @classmethod
    def _in_small_letters(cls, given: object) -> object:
        return given.casefold() if isinstance(given, str) else given

    @model_validator(mode="after")
    def _fits_the_design(self) -> Self:
        for option, kinds in TAKERS.items():
            value = getattr(self, option)
            if value is not None and self.design not in kinds:
                raise InputError(
                    f"study.{option}: given {value!r} with the design {self.design!r}; allowed is it "
                    f"with {' and '.join(kinds)} only."
                )
        for option in ("runs", "file"):
            if getattr(self, option) is None and self.design in TAKERS[option]:
                raise InputError(
                    f"study.{option}: missing; the design {self.design!r} needs the "
                    f"{type(self).model_fields[option].description}."
                )
        if self.resolution is not None and self.generators is not None:
            raise InputError(
                "study.generators: given together with study.resolution; allowed is one of the two, because "
                "generators fix the resolution."
            )
        return self
