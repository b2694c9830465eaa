"""The dimensions of one crank throw: fields, units and ranges, before anything is made of them."""

from typing import ClassVar

from pydantic import Field

from crankbase.model import InputModel, part_field, quantity_field
from geometry.throw_sections import Counterweight, FurtherPin, Outline, Web


class ThrowDimensions(InputModel):
    """What describes a throw; `geometry.throw.CrankThrow` says what each means and fits them together.

    Raises
    ------
    InputError
        If a dimension is missing or out of its own range.
    """

    section: ClassVar[str] = "throw"

    crank_radius: float = quantity_field(
        "crank radius, half the stroke", "m", symbol="R", minimum=0.005, maximum=2.5
    )
    main_journal_diameter: float = quantity_field(
        "main journal diameter", "m", symbol="D_km", minimum=0.005, maximum=2.0
    )
    pin_diameter: float = quantity_field(
        "crankpin diameter", "m", symbol="D_shm", minimum=0.005, maximum=2.0
    )
    main_journal_length: float = quantity_field(
        "main journal length between the webs", "m", symbol="L_km", minimum=0.002, maximum=2.0
    )
    pin_length: float = quantity_field(
        "crankpin length between the webs", "m", symbol="L_shm", minimum=0.002, maximum=2.0
    )
    web_width: float = quantity_field(
        "web width across the crank", "m", symbol="B", minimum=0.005, maximum=4.0
    )
    web_thickness: float = quantity_field(
        "web thickness along the shaft", "m", symbol="h", minimum=0.002, maximum=1.5
    )
    fillet_radius: float = quantity_field(
        "fillet radius at main journals and pin",
        "m",
        symbol="r",
        minimum=0.0,
        maximum=0.3,
        default=0.0,
    )

    main_journal_fillet_radius: float | None = quantity_field(
        "fillet radius at the main journals, if it differs",
        "m",
        symbol="r_km",
        minimum=0.0,
        maximum=0.3,
        default=None,
    )
    pin_fillet_radius: float | None = quantity_field(
        "fillet radius at the pin, if it differs",
        "m",
        symbol="r_shm",
        minimum=0.0,
        maximum=0.3,
        default=None,
    )
    main_journal_bore: float = quantity_field(
        "bore diameter of main journals and the webs beside them",
        "m",
        symbol="d_km",
        minimum=0.0,
        maximum=2.0,
        default=0.0,
        feature=True,
    )
    pin_bore: float = quantity_field(
        "bore diameter of the crankpin and the webs beside it",
        "m",
        symbol="d_shm",
        minimum=0.0,
        maximum=2.0,
        default=0.0,
        feature=True,
    )
    main_journal_bore_offset: float = quantity_field(
        "distance of the main journals' bore from the shaft axis, positive towards the pin",
        "m",
        minimum=-1.0,
        maximum=1.0,
        default=0.0,
        feature=True,
    )
    pin_bore_offset: float = quantity_field(
        "distance of the pin's bore from the pin axis, positive away from the shaft",
        "m",
        minimum=-1.0,
        maximum=1.0,
        default=0.0,
        feature=True,
    )
    web_outline: Outline = Field(
        "obround", description="outline of the webs: obround or rectangle", json_schema_extra={}
    )
    web_journal_end: float | None = quantity_field(
        "distance from the shaft axis to the web's end; radius of that end if obround; B / 2 if not given",
        "m",
        minimum=0.0025,
        maximum=4.0,
        default=None,
    )
    web_pin_end: float | None = quantity_field(
        "distance from the pin axis to the web's end; radius of that end if obround; B / 2 if not given",
        "m",
        minimum=0.0025,
        maximum=4.0,
        default=None,
    )
    web_corner_radius: float = quantity_field(
        "radius of a rectangular web's corners",
        "m",
        minimum=0.0,
        maximum=2.0,
        default=0.0,
        feature=True,
    )
    web_corner_chamfer: float = quantity_field(
        "chamfer of a rectangular web's corners, 45 deg",
        "m",
        minimum=0.0,
        maximum=2.0,
        default=0.0,
        feature=True,
    )
    web_tip_thickness: float | None = quantity_field(
        "web thickness at its pin end, sloped on the outer face; h if not given",
        "m",
        minimum=0.001,
        maximum=1.5,
        default=None,
    )
    web_foot_thickness: float | None = quantity_field(
        "web thickness at its journal end, sloped on the inner face; h if not given",
        "m",
        minimum=0.001,
        maximum=1.5,
        default=None,
    )
    counterweight: Counterweight | None = part_field("counterweight on both webs", Counterweight)
    left_web: Web | None = part_field("what the left web has of its own", Web)
    right_web: Web | None = part_field("what the right web has of its own", Web)
    further_pins: tuple[FurtherPin, ...] = part_field(
        "further pins without a main bearing before them", FurtherPin, many=True
    )
