"""The section of engine files about the crankshaft's strength by UR M53."""

import math
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, length_field, part_field, quantity_field
from crankbase.sentences import amount, kept
from dynamics.strength.concentration import Coefficients
from dynamics.strength.fatigue import TREATED, Manufacture, Piston, Process, SurfaceTreatment
from dynamics.strength.shrink_fit import LEAST_SAFETY, MOST_FRICTION


class HardeningInput(InputModel):
    """Hardened fillets and oil holes."""

    section: ClassVar[str] = "strength.hardening"

    process: Process = Field(description="induction or nitriding")
    depth: float = quantity_field(
        "depth with 80 % of the surface's hardness (induction), or of the nitrided layer",
        "m",
        1e-5,
        0.05,
    )
    surface_hardness: float = quantity_field(
        "least Vickers hardness of the surface", "", minimum=400.0, maximum=1500.0
    )
    places: tuple[str, ...] = Field(TREATED, description=f"what is hardened: {', '.join(TREATED)}")

    @model_validator(mode="after")
    def _known(self) -> Self:
        unknown = [place for place in self.places if place not in TREATED]
        if unknown or not self.places:
            raise InputError(
                f"strength.hardening.places: given {', '.join(unknown) or 'none'}; allowed are "
                f"{', '.join(TREATED)}, because the available formulas are for these."
            )
        try:
            self.treatment()
        except InputError as error:
            raise InputError(f"strength.hardening.{kept(str(error))}") from None
        return self

    def treatment(self) -> SurfaceTreatment:
        """Return the hardened surface."""
        return SurfaceTreatment(self.process, self.depth, self.surface_hardness)


class ShrinkFitInput(InputModel):
    """Shrink fits of main journals in the webs of a semi-built crankshaft."""

    section: ClassVar[str] = "strength.shrink_fit"

    shrink_diameter: float = length_field("diameter of the fit", (0.01, 4.0), symbol="D_S")
    shrink_length: float = length_field("length of the fit", (0.005, 3.0), symbol="L_S")
    web_diameter: float = length_field(
        "web's outer diameter at the fit, or twice the least distance from the journal's center to its edge",
        (0.01, 8.0),
        symbol="D_A",
    )
    fillet_radius: float = length_field(
        "radius of the journal's fillet next to the fit", (1e-4, 0.3), symbol="R_G"
    )
    web_yield: float = quantity_field("yield strength of the web", "Pa", 1e8, 2e9, symbol="s_SW")
    journal_yield: float = quantity_field(
        "yield strength of the journal", "Pa", 1e8, 2e9, symbol="s_SP"
    )
    friction: float = quantity_field(
        "friction of the fit", "", 0.01, MOST_FRICTION, symbol="mu", default=MOST_FRICTION
    )
    safety: float = quantity_field(
        "safety against slipping", "", LEAST_SAFETY, 10.0, symbol="S_R", default=LEAST_SAFETY
    )

    @model_validator(mode="after")
    def _lies_in_the_web(self) -> Self:
        if self.web_diameter <= self.shrink_diameter:
            raise InputError(
                f"strength.shrink_fit.web_diameter: given {amount(self.web_diameter, 'm')}; allowed "
                f"is more than the shrink_diameter of {amount(self.shrink_diameter, 'm')}, because "
                "the web surrounds the fit."
            )
        return self


class StrengthSection(InputModel):
    """Strength of the crankshaft by the unified requirement M53."""

    section: ClassVar[str] = "strength"
    choices = frozenset({"axial_vibration", "coefficients", "factors"})

    tensile_strength: float = quantity_field(
        "specified minimum tensile strength of the crankshaft", "Pa", 3e8, 2e9, symbol="s_B"
    )
    manufacture: Manufacture = Field(
        description="continuous grain flow (drop forged too), free-form forged, or cast and cold rolled"
    )
    piston: Piston = Field(description="trunk or crosshead: it sets the additional bending stress")
    axial_vibration: Literal["rule", "calculated"] = Field(
        "rule",
        description="crosshead engines: the rule's 20 MPa for axial vibration, or the calculated stress",
    )
    factors: Literal["formulas", "finite elements"] = Field(
        "formulas",
        description="stress concentration factors: by the rule's formulas, or by finite elements (Appendix "
        "III)",
    )
    oil_hole_diameter: float | None = length_field(
        "diameter of the radial oil hole in the pin", (5e-4, 0.3), symbol="D_O", default=None
    )
    oil_hole_angle: float | None = quantity_field(
        "angle of the hole's outlet from the direction in which the pin moves, positive away from the "
        "shaft; by default the worst direction",
        "rad",
        minimum=-math.pi,
        maximum=math.pi,
        symbol="psi",
        default=None,
    )
    pin_recess: float = length_field(
        "depth to which the pin's fillets are cut into the webs",
        (0.0, 0.5),
        symbol="T_H",
        default=0.0,
        feature=True,
    )
    journal_recess: float = length_field(
        "the same for the main journals' fillets",
        (0.0, 0.5),
        symbol="T_G",
        default=0.0,
        feature=True,
    )
    coefficients: Coefficients = Field(
        "printed", description="values of two doubtful coefficients: printed or suspected"
    )
    hardening: HardeningInput | None = part_field(
        "hardened pin fillets and oil holes", HardeningInput
    )
    shrink_fit: ShrinkFitInput | None = part_field(
        "fits of a semi-built crankshaft, whose journals are shrunk into the webs", ShrinkFitInput
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.axial_vibration == "calculated" and self.piston != "crosshead":
            raise InputError(
                "strength.axial_vibration: given 'calculated' with trunk pistons; allowed is 'rule', because "
                "their additional stress has no part for axial vibration."
            )
        if self.oil_hole_angle is not None and self.oil_hole_diameter is None:
            raise InputError(
                "strength.oil_hole_angle: given without oil_hole_diameter; allowed are both, because the "
                "angle is that of the hole."
            )
        return self
