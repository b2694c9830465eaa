"""The optional parts of a throw, each a table of its own in a file."""

from typing import ClassVar, Literal

from pydantic import Field

from crankbase.model import InputModel, part_field, quantity_field

Outline = Literal["obround", "rectangle"]


class Counterweight(InputModel):
    """A sector on a web, centered on the shaft axis and opposite to the crankpin.

    Parameters
    ----------
    outer_radius, inner_radius : float
        [m]; the sector must reach into the web, so that the two are one piece.
    angle : float
        Whole angle of the sector [rad].
    thickness : float, optional
        Along the shaft [m]; the web's own by default.
    offset : float, optional
        Of its middle from the middle of the web, positive towards the crankpin [m].

    Raises
    ------
    InputError
        If a dimension is missing or out of range.
    """

    section: ClassVar[str] = "counterweight"

    outer_radius: float = quantity_field(
        "counterweight's outer radius from the shaft axis",
        "m",
        symbol="r_cw",
        minimum=0.005,
        maximum=5.0,
    )
    inner_radius: float = quantity_field(
        "counterweight's inner radius from the shaft axis; 0 for a full sector",
        "m",
        minimum=0.0,
        maximum=5.0,
        default=0.0,
        feature=True,
    )
    angle: float = quantity_field(
        "counterweight's whole angle",
        "rad",
        minimum=0.17453292519943295,
        maximum=3.141592653589793,
    )
    thickness: float | None = quantity_field(
        "counterweight's thickness along the shaft; the web's if not given",
        "m",
        minimum=0.002,
        maximum=3.0,
        default=None,
    )
    offset: float = quantity_field(
        "distance of the counterweight's middle from the web's middle, positive towards the crankpin",
        "m",
        minimum=-1.5,
        maximum=1.5,
        default=0.0,
        feature=True,
    )


class Web(InputModel):
    """What one web has of its own; whatever is not given is as the throw says for both.

    Parameters
    ----------
    thickness, width, outline, journal_end, pin_end : optional
    corner_radius, corner_chamfer, tip_thickness, foot_thickness : optional
        As the throw's ``web_thickness``, ``web_width`` and so on [m].
    counterweight : Counterweight, optional

    Raises
    ------
    InputError
        If a dimension is out of range.
    """

    section: ClassVar[str] = "web"

    thickness: float | None = quantity_field(
        "this web's thickness along the shaft",
        "m",
        symbol="h",
        minimum=0.002,
        maximum=1.5,
        default=None,
    )
    width: float | None = quantity_field(
        "this web's width across the crank",
        "m",
        symbol="B",
        minimum=0.005,
        maximum=4.0,
        default=None,
    )
    outline: Outline | None = Field(
        None, description="this web's outline: obround or rectangle", json_schema_extra={}
    )
    journal_end: float | None = quantity_field(
        "distance from the shaft axis to this web's end",
        "m",
        minimum=0.0025,
        maximum=4.0,
        default=None,
    )
    pin_end: float | None = quantity_field(
        "distance from the pin axis to this web's end",
        "m",
        minimum=0.0025,
        maximum=4.0,
        default=None,
    )
    corner_radius: float | None = quantity_field(
        "radius of this rectangle's corners", "m", minimum=0.0, maximum=2.0, default=None
    )
    corner_chamfer: float | None = quantity_field(
        "chamfer of this rectangle's corners, 45 deg", "m", minimum=0.0, maximum=2.0, default=None
    )
    tip_thickness: float | None = quantity_field(
        "this web's thickness at its pin end", "m", minimum=0.001, maximum=1.5, default=None
    )
    foot_thickness: float | None = quantity_field(
        "this web's thickness at its journal end", "m", minimum=0.001, maximum=1.5, default=None
    )
    counterweight: Counterweight | None = part_field("this web's counterweight", Counterweight)


class FurtherPin(InputModel):
    """A further crankpin with the web before it, where a main bearing is missing.

    What is not given is as for the first pin. The web before it is obround, between the two pins.

    Parameters
    ----------
    angle : float
        Angle of this pin from the first one about the shaft, +z [rad].
    crank_radius, diameter, length, fillet_radius, bore, bore_offset : float, optional
        As the throw's, for this pin [m].
    web_thickness, web_width : float, optional
        Of the web between the pin before and this one [m]; a thickness of 0 is a split pin whose
        halves touch, without fillets there.

    Raises
    ------
    InputError
        If a dimension is missing or out of range.
    """

    section: ClassVar[str] = "further_pin"

    angle: float = quantity_field(
        "angle of this pin from the first one about the shaft",
        "rad",
        minimum=-6.283185307179586,
        maximum=6.283185307179586,
    )
    crank_radius: float | None = quantity_field(
        "crank radius of this pin", "m", symbol="R", minimum=0.005, maximum=2.5, default=None
    )
    diameter: float | None = quantity_field(
        "diameter of this pin", "m", symbol="D_shm", minimum=0.005, maximum=2.0, default=None
    )
    length: float | None = quantity_field(
        "length of this pin between its webs",
        "m",
        symbol="L_shm",
        minimum=0.002,
        maximum=2.0,
        default=None,
    )
    fillet_radius: float | None = quantity_field(
        "fillet radius at this pin", "m", symbol="r_shm", minimum=0.0, maximum=0.3, default=None
    )
    bore: float | None = quantity_field(
        "bore diameter of this pin", "m", symbol="d_shm", minimum=0.0, maximum=2.0, default=None
    )
    bore_offset: float | None = quantity_field(
        "distance of this pin's bore from the pin axis, positive away from the shaft",
        "m",
        minimum=-1.0,
        maximum=1.0,
        default=None,
    )
    web_thickness: float | None = quantity_field(
        "thickness of the web before this pin; 0 for a split pin",
        "m",
        symbol="h",
        minimum=0.0,
        maximum=1.5,
        default=None,
    )
    web_width: float | None = quantity_field(
        "width of the web before this pin",
        "m",
        symbol="B",
        minimum=0.005,
        maximum=4.0,
        default=None,
    )
