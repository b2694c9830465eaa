"""Checks of a counterweight: one piece with its web, clear of the bearing and of the rod."""

import math

from geometry.parts import Cylinder, Sector, WebPlate
from geometry.throw_dimensions import ThrowDimensions
from geometry.throw_fields import dimension_error, in_mm

# A counterweight must stand out of its web by this share of the web's reach, reach into it as deep
# as this share, and share this much of the thinner one's thickness with it.
COUNTERWEIGHT_STANDS_OUT = 1.02
COUNTERWEIGHT_REACHES_IN = 0.9
COUNTERWEIGHT_SHARES = 0.3
# Beside a crankpin, each of two webs' counterweights may stand out by this share of its length.
SHARE_OF_PIN_LENGTH = 0.45
# A step between a counterweight's face and its web's is at least this share of the web's thickness.
SMALLEST_STEP = 0.02


def check_counterweight(
    throw: ThrowDimensions,
    web: WebPlate,
    sector: Sector,
    journal: Cylinder,
    pin: Cylinder,
    outer: float,
) -> None:
    """A counterweight must be one piece with its web and clear bearing and rod."""
    own = getattr(throw, web.name.replace(" ", "_"))
    table = f"{web.name.replace(' ', '_')}." if own is not None and own.counterweight else ""
    name = f"{table}counterweight"
    reach = -web.outline.foot
    if sector.outer_radius < COUNTERWEIGHT_STANDS_OUT * reach:
        raise dimension_error(
            f"{name}.outer_radius",
            sector.outer_radius,
            f"{in_mm(COUNTERWEIGHT_STANDS_OUT * reach)} or more",
            f"because the {web.name} itself reaches {in_mm(reach)} from the shaft axis",
        )
    if sector.inner_radius > COUNTERWEIGHT_REACHES_IN * reach:
        raise dimension_error(
            f"{name}.inner_radius",
            sector.inner_radius,
            f"0 to {in_mm(COUNTERWEIGHT_REACHES_IN * reach)}",
            f"because it must reach into the {web.name}, which ends {in_mm(reach)} from the shaft axis",
        )
    thickness = web.end - web.start
    foot_drop = sum(s.drop for s in web.slopes if s.towards < 0.0)
    start = web.start + (foot_drop if outer > 0.0 else 0.0)
    end = web.end - (foot_drop if outer < 0.0 else 0.0)
    shared = min(end, sector.end) - max(start, sector.start)
    lowest = COUNTERWEIGHT_SHARES * min(thickness, sector.end - sector.start)
    if shared < lowest:
        raise dimension_error(
            f"{name}.offset",
            0.5 * (sector.start + sector.end - web.start - web.end) * -outer,
            f"one that puts more of its {in_mm(sector.end - sector.start)} on the web",
            f"because {in_mm(lowest)} of the thickness must be shared with the {web.name}, not "
            f"{in_mm(max(shared, 0.0))}",
        )
    for step in (abs(sector.start - web.start), abs(sector.end - web.end)):
        if 0.0 < step < SMALLEST_STEP * thickness:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"one whose faces are flush with the {web.name} or {in_mm(SMALLEST_STEP * thickness)} off",
                f"because a step of {in_mm(step)} cannot be meshed sensibly",
            )
    beyond_outer = (web.start - sector.start) if outer < 0.0 else (sector.end - web.end)
    beyond_inner = (sector.end - web.end) if outer < 0.0 else (web.start - sector.start)
    if beyond_outer > 0.0:
        room = 0.9 * (journal.end - journal.start)
        if beyond_outer > room:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {in_mm(room)} beyond the {web.name}",
                "or it would meet the neighboring throw's",
            )
        clear = 1.02 * journal.collar
        if sector.inner_radius < clear:
            raise dimension_error(
                f"{name}.inner_radius",
                sector.inner_radius,
                f"{in_mm(clear)} or more",
                f"because the counterweight stands {in_mm(beyond_outer)} out over the main bearing, which it "
                "must clear",
            )
    if beyond_inner > 0.0:
        room = SHARE_OF_PIN_LENGTH * (pin.end - pin.start)
        if beyond_inner > room:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {in_mm(room)} beyond the {web.name} towards the crankpin",
                "or it would meet the other web's",
            )
        lowest_pin = web.distance - 1.02 * pin.collar
        highest = -sector.inner_radius * math.cos(sector.half_angle)
        if highest > lowest_pin:
            raise dimension_error(
                f"{name}.inner_radius",
                sector.inner_radius,
                "a larger one, or a smaller angle",
                f"because the counterweight stands {in_mm(beyond_inner)} out beside the crankpin, which it "
                "must clear",
            )
