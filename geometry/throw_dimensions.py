"""The dimensions of one crank throw: fields, units and ranges, before their combination is checked.

The optional parts of a throw have their own tables in a file, and so their own classes here.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from pydantic import Field

from crankbase.model import InputModel, length_field, part_field, quantity_field
from geometry.parts import OUTLINES, OutlineName

# Smallest and largest lengths [m], of the throw and of what its webs and further pins have of their own.
CRANK_RADIUS = (0.0005, 2.5)
DIAMETER, LENGTH = (0.001, 2.0), (0.0003, 2.0)
WIDTH, THICKNESS, THINNED = (0.001, 4.0), (0.0002, 1.5), (0.0001, 1.5)
FILLET_RADIUS = (0.0, 0.3)
BORE, BORE_OFFSET = (0.0, 2.0), (-1.0, 1.0)
WEB_END, CORNER = (0.0005, 4.0), (0.0, 2.0)
HOLE, EXIT_RADIUS = (0.00002, 0.5), (0.0, 0.2)
# No bearing stands between a few pins; no throw is drilled more often.
MOST_FURTHER_PINS, MOST_OIL_HOLES = 7, 40
STEEPEST_TILT = 0.6981317007977318  # 40 deg: sharper lips have no stress that can be told
OUTLINE_NAMES = " or ".join(OUTLINES)


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
        Offset of its middle from the middle of the web, positive towards the crankpin [m].

    Raises
    ------
    InputError
        If a dimension is missing or out of range.
    """

    section: ClassVar[str] = "counterweight"

    outer_radius: float = length_field(
        "counterweight's outer radius from the shaft axis", (0.001, 5.0), symbol="r_cw"
    )
    inner_radius: float = length_field(
        "counterweight's inner radius from the shaft axis; 0 for a full sector",
        (0.0, 5.0),
        default=0.0,
        feature=True,
    )
    angle: float = quantity_field(
        "counterweight's whole angle", "rad", minimum=0.17453292519943295, maximum=3.141592653589793
    )
    thickness: float | None = length_field(
        "counterweight's thickness along the shaft; by default that of the web",
        (0.0002, 3.0),
        default=None,
    )
    offset: float = length_field(
        "distance of the counterweight's middle from the web's middle, positive towards the crankpin",
        (-1.5, 1.5),
        default=0.0,
        feature=True,
    )


class Web(InputModel):
    """Fields that differ on one web; by default as for both webs.

    Parameters
    ----------
    corner_radius, corner_chamfer, tip_thickness, foot_thickness : optional
        As the throw's ``web_thickness``, ``web_width`` and so on [m].

    Raises
    ------
    InputError
        If a dimension is out of range.
    """

    section: ClassVar[str] = "web"

    thickness: float | None = length_field(
        "this web's thickness along the shaft", THICKNESS, symbol="h", default=None
    )
    width: float | None = length_field(
        "this web's width across the crank", WIDTH, symbol="B", default=None
    )
    outline: OutlineName | None = Field(None, description=f"this web's outline: {OUTLINE_NAMES}")
    journal_end: float | None = length_field(
        "distance from the shaft axis to this web's end", WEB_END, default=None
    )
    pin_end: float | None = length_field(
        "distance from the pin axis to this web's end", WEB_END, default=None
    )
    corner_radius: float | None = length_field(
        "radius of this rectangle's corners", CORNER, default=None
    )
    corner_chamfer: float | None = length_field(
        "chamfer of this rectangle's corners, 45 deg", CORNER, default=None
    )
    tip_thickness: float | None = length_field(
        "this web's thickness at its pin end", THINNED, default=None
    )
    foot_thickness: float | None = length_field(
        "this web's thickness at its journal end", THINNED, default=None
    )
    counterweight: Counterweight | None = part_field("this web's counterweight", Counterweight)


class FurtherPin(InputModel):
    """A further crankpin with the web before it, if a main bearing is missing.

    By default its dimensions are those of the first pin. The web before it is obround, between the two pins.

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
    crank_radius: float | None = length_field(
        "crank radius of this pin", CRANK_RADIUS, symbol="R", default=None
    )
    diameter: float | None = length_field(
        "diameter of this pin", DIAMETER, symbol="D_shm", default=None
    )
    length: float | None = length_field(
        "length of this pin between its webs", LENGTH, symbol="L_shm", default=None
    )
    fillet_radius: float | None = length_field(
        "fillet radius at this pin", FILLET_RADIUS, symbol="r_shm", default=None
    )
    bore: float | None = length_field(
        "bore diameter of this pin", BORE, symbol="d_shm", default=None
    )
    bore_offset: float | None = length_field(
        "distance of this pin's bore from the pin axis, positive away from the shaft",
        BORE_OFFSET,
        default=None,
    )
    web_thickness: float | None = length_field(
        "thickness of the web before this pin; 0 for a split pin",
        (0.0, 1.5),
        symbol="h",
        default=None,
    )
    web_width: float | None = length_field(
        "width of the web before this pin", WIDTH, symbol="B", default=None
    )


class OilHole(InputModel):
    """A straight oil hole across a crankpin or a main journal.

    It runs right through, or from the surface to the axis or, if present, to the bore.

    Parameters
    ----------
    part : str
        "pin" (of several: "pin 2" and so on), "left main journal" or "right main journal".
    diameter : float
        [m]
    position : float, optional
        Intersection of its axis with that of the part: distance from the middle of the pin or whole main
        journal, positive towards the flywheel [m].
    angle : float, optional
        Its direction from the axis of the part outward, counted from the crank (+y) about the shaft,
        +z [rad].
    tilt : float, optional
        Inclination of that direction from the plane across the shaft, towards the flywheel [rad].
    exit_radius : float, optional
        Radius of its rounded exits; 0 for sharp ones [m].
    through : bool, optional
        Whether it runs right through, with a second exit on the opposite side.

    Raises
    ------
    InputError
        If a dimension is missing or out of range.
    """

    section: ClassVar[str] = "oil_hole"

    part: str = Field(
        description="part it is drilled into: pin, pin 2 ..., left main journal, right main journal"
    )
    diameter: float = length_field("diameter of the hole", HOLE, symbol="d_o")
    position: float = length_field(
        "position where its axis crosses the part's, from the middle of the pin or of the whole main "
        "journal, positive towards the flywheel",
        BORE_OFFSET,
        default=0.0,
        feature=True,
    )
    angle: float = quantity_field(
        "direction from the part's axis outward, from the crank (+y) about the shaft (+z)",
        "rad",
        minimum=-6.283185307179586,
        maximum=6.283185307179586,
        default=0.0,
        feature=True,
    )
    tilt: float = quantity_field(
        "inclination of that direction towards the flywheel",
        "rad",
        minimum=-STEEPEST_TILT,
        maximum=STEEPEST_TILT,
        default=0.0,
        feature=True,
    )
    exit_radius: float = length_field(
        "radius of its rounded exits; 0 for sharp ones", EXIT_RADIUS, default=0.0, feature=True
    )
    through: bool = Field(
        True,
        description="whether it is a through hole; otherwise it ends at the part's axis, or at its bore",
        json_schema_extra={"feature": True},
    )


class ThrowDimensions(InputModel):
    """The dimensions of a throw; see `geometry.throw.CrankThrow` for their meaning.

    Raises
    ------
    InputError
        If a dimension is missing or out of its own range.
    """

    section: ClassVar[str] = "throw"

    crank_radius: float = length_field("crank radius, half the stroke", CRANK_RADIUS, symbol="R")
    main_journal_diameter: float = length_field("main journal diameter", DIAMETER, symbol="D_km")
    pin_diameter: float = length_field("crankpin diameter", DIAMETER, symbol="D_shm")
    main_journal_length: float = length_field(
        "main journal length between the webs", LENGTH, symbol="L_km"
    )
    pin_length: float = length_field("crankpin length between the webs", LENGTH, symbol="L_shm")
    web_width: float = length_field("web width across the crank", WIDTH, symbol="B")
    web_thickness: float = length_field("web thickness along the shaft", THICKNESS, symbol="h")
    fillet_radius: float = length_field(
        "fillet radius at main journals and pin", FILLET_RADIUS, symbol="r", default=0.0
    )

    main_journal_fillet_radius: float | None = length_field(
        "fillet radius at the main journals, if it differs",
        FILLET_RADIUS,
        symbol="r_km",
        default=None,
    )
    pin_fillet_radius: float | None = length_field(
        "fillet radius at the pin, if it differs", FILLET_RADIUS, symbol="r_shm", default=None
    )
    main_journal_bore: float = length_field(
        "bore diameter of main journals and the webs beside them",
        BORE,
        symbol="d_km",
        default=0.0,
        feature=True,
    )
    pin_bore: float = length_field(
        "bore diameter of the crankpin and the webs beside it",
        BORE,
        symbol="d_shm",
        default=0.0,
        feature=True,
    )
    main_journal_bore_offset: float = length_field(
        "distance of the main journals' bore from the shaft axis, positive towards the pin",
        BORE_OFFSET,
        default=0.0,
        feature=True,
    )
    pin_bore_offset: float = length_field(
        "distance of the pin's bore from the pin axis, positive away from the shaft",
        BORE_OFFSET,
        default=0.0,
        feature=True,
    )
    web_outline: OutlineName = Field("obround", description=f"outline of the webs: {OUTLINE_NAMES}")
    web_journal_end: float | None = length_field(
        "distance from the shaft axis to the web's end; radius of that end if obround; by default B / 2",
        WEB_END,
        default=None,
    )
    web_pin_end: float | None = length_field(
        "distance from the pin axis to the web's end; radius of that end if obround; by default B / 2",
        WEB_END,
        default=None,
    )
    web_corner_radius: float = length_field(
        "radius of a rectangular web's corners", CORNER, default=0.0, feature=True
    )
    web_corner_chamfer: float = length_field(
        "chamfer of a rectangular web's corners, 45 deg", CORNER, default=0.0, feature=True
    )
    web_tip_thickness: float | None = length_field(
        "web thickness at its pin end, sloped on the outer face; by default h",
        THINNED,
        default=None,
    )
    web_foot_thickness: float | None = length_field(
        "web thickness at its journal end, sloped on the inner face; by default h",
        THINNED,
        default=None,
    )
    counterweight: Counterweight | None = part_field("counterweight on both webs", Counterweight)
    left_web: Web | None = part_field("values of the left web alone", Web)
    right_web: Web | None = part_field("values of the right web alone", Web)
    further_pins: tuple[FurtherPin, ...] = part_field(
        "further pins without a main bearing before them",
        FurtherPin,
        many=True,
        most=MOST_FURTHER_PINS,
    )
    oil_holes: tuple[OilHole, ...] = part_field(
        "straight oil holes across pins and main journals",
        OilHole,
        many=True,
        most=MOST_OIL_HOLES,
    )


def web_dimension(throw: ThrowDimensions, table: str, kind: str) -> tuple[str, Any]:
    """Field and value of a dimension of the "left_web" or "right_web": its own, or that of both webs."""
    web = getattr(throw, table)
    special = None if web is None else getattr(web, kind, None)
    if special is not None:
        return f"{table}.{kind}", special
    return f"web_{kind}", getattr(throw, f"web_{kind}")


def values_by_path(record: InputModel, prefix: str = "") -> Iterator[tuple[str, float | str]]:
    """Iterate over the numbers and labels of a record and its parts, by path ("further_pins.0.length")."""
    for name in type(record).model_fields:
        value = getattr(record, name)
        if isinstance(value, InputModel):
            yield from values_by_path(value, f"{prefix}{name}.")
        elif isinstance(value, tuple):
            for place, item in enumerate(value):
                yield from values_by_path(item, f"{prefix}{name}.{place}.")
        elif value is not None:
            yield prefix + name, value if isinstance(value, str) else float(value)


def changed_record(record: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Copy of a throw's record (JSON content) with other values at some paths.

    Parts that it lacks are made.
    """
    changed: dict[str, Any] = _copied(record)
    for path, value in changes.items():
        *steps, last = path.split(".")
        place: Any = changed
        for step in steps:
            if isinstance(place, list):
                place = place[int(step)]
                continue
            if place.get(step) is None:
                place[step] = {}
            place = place[step]
        place[last] = value
    return changed


def _copied(content: Any) -> Any:
    """Copy JSON content; several times as fast as what copies anything."""
    if isinstance(content, Mapping):
        return {name: _copied(value) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_copied(value) for value in content]
    return content
