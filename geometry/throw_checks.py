"""What of a throw's dimensions fits together: every refusal names field, value, limit and reason."""

import math
from typing import TYPE_CHECKING

from geometry.errors import InputError
from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate
from geometry.quantity import show_quantity
from geometry.throw_sections import Web

if TYPE_CHECKING:
    from geometry.throw import CrankThrow

# A fillet may take this share of a journal's length for each of its two fillets, so that a tenth of
# it stays a cylinder for the bearing and for the pin load.
FILLET_SHARE_OF_LENGTH = 0.45
# Below this share of the journal diameter a fillet acts as a sharp corner, and meshing it only
# costs unknowns.
SMALLEST_FILLET_SHARE = 0.01
# A web must reach beyond an unfilleted journal by this share of its diameter.
SMALLEST_LEDGE = 1e-3
# A fillet's foot may lie on the web's edge, or this share of the journal's diameter inside it.
SMALLEST_FOOT_LEDGE = 2e-4
# Shares of a web's width: its smallest corner, and how far an end's radius may be from half of it.
SMALLEST_CORNER, SMALLEST_END_STEP = 0.01, 1e-3
# Two pins lie on one axis, or this share of their diameter apart.
SMALLEST_PIN_STEP = 5e-3
# Shares of a journal's diameter: the wall that a bore must leave, and the smallest bore.
SMALLEST_WALL = 0.05
SMALLEST_BORE = 0.05
# The thinnest end of a web, beside its thickness, and the shortest slope, beside its width.
THINNEST_END = 0.3
SHORTEST_SLOPE = 0.05
# A counterweight must stand out of its web by this share of the web's reach, reach into it as deep
# as this share, and share this much of the thinner one's thickness with it.
COUNTERWEIGHT_STANDS_OUT = 1.02
COUNTERWEIGHT_REACHES_IN = 0.9
COUNTERWEIGHT_SHARES = 0.3
# No part may be thinner than this share of the largest dimension.
THINNEST_PART = 1.0 / 25.0
# A step between a counterweight's face and its web's is at least this share of the web's thickness.
SMALLEST_STEP = 0.02
# The halves of a split pin without a web: distance of their axes beside the sum of their radii.
SPLIT_PIN_STEP = (0.02, 0.7)


def check_throw(throw: "CrankThrow", parts: ThrowParts) -> None:
    """Refuse a throw that cannot be built or meshed.

    Parameters
    ----------
    throw : CrankThrow
        For the names of what was given.
    parts : ThrowParts
        Its parts.

    Raises
    ------
    InputError
        With one sentence.
    """
    _check_proportions(throw, parts)
    _check_corners(throw)
    _check_outlines(throw)
    for place, web in enumerate(parts.webs):
        before, after = parts.cylinders[place : place + 2]
        if web.end == web.start:
            _check_split_pin(web, before, after)
            continue
        for cylinder, axis in _seats(web, before, after):
            _check_seat(throw, parts, web, cylinder, axis)
        if 1e-9 * web.outline.width < web.distance < SMALLEST_PIN_STEP * 2.0 * after.radius:
            raise InputError(
                f"throw.further_pins: given pins whose axes are {_mm(web.distance)} apart; allowed is 0 or "
                f"{_mm(SMALLEST_PIN_STEP * 2.0 * after.radius)} or more, for a smaller step cannot be meshed."
            )
        _check_wall_between(web, before, after)
        _check_slopes(throw, web)
        if web.sector is not None:
            journal, pin = (before, after) if place == 0 else (after, before)
            _check_counterweight(
                throw, web, web.sector, journal, pin, outer=-1.0 if place == 0 else 1.0
            )
    _check_fillets(throw, parts)
    for cylinder in parts.cylinders:
        _check_bore(throw, parts, cylinder)


def throw_remarks(parts: ThrowParts) -> tuple[str, ...]:
    """What can be built but is hardly meant: bores that come out in another journal's fillet.

    Parameters
    ----------
    parts : ThrowParts
    """
    remarks = []
    for place, web in enumerate(parts.webs):
        joined = parts.cylinders[place : place + 2]
        for bored, other in (joined, joined[::-1]):
            if bored.bore_radius == 0.0 or web.end == web.start:
                continue
            apart = math.dist(bored.bore_axis, other.axis)
            if abs(other.collar - apart) < bored.bore_radius:
                remarks.append(
                    f"The bore of the {_label(bored)} cuts the fillet or the surface of the "
                    f"{_label(other)} at the {web.name}: it comes out {_mm(apart - bored.bore_radius)} to "
                    f"{_mm(apart + bored.bore_radius)} from that axis, and the fillet's foot is at "
                    f"{_mm(other.collar)}."
                )
    return tuple(dict.fromkeys(remarks))


def _mm(value: float) -> str:
    return show_quantity(value, "m")


def _refuse(field: str, given: float, allowed: str, reason: str) -> InputError:
    return InputError(f"throw.{field}: given {_mm(given)}; allowed is {allowed}, {reason}.")


def _label(cylinder: Cylinder) -> str:
    return cylinder.name.replace("pin", "crankpin") if cylinder.is_pin else "main journal"


def _field(throw: "CrankThrow", parts: ThrowParts, cylinder: Cylinder, kind: str) -> str:
    """Name of the field that gave a cylinder's dimension (diameter, length, fillet_radius, bore)."""
    if not cylinder.is_pin:
        name = f"main_journal_{kind}"
    else:
        place = parts.cylinders.index(cylinder) - 2
        if place >= 0 and getattr(throw.further_pins[place], kind) is not None:
            return f"further_pins[{place}].{kind}"
        name = f"pin_{kind}"
    if kind == "fillet_radius" and getattr(throw, name) is None:
        return "fillet_radius"
    return name


def _web_field(throw: "CrankThrow", web: WebPlate, kind: str) -> str:
    """Name of the field that gave a web's dimension."""
    if web.name in ("left web", "right web"):
        table = web.name.replace(" ", "_")
        own = getattr(throw, table)
        if own is not None and getattr(own, kind) is not None:
            return f"{table}.{kind}"
    else:
        place = int(web.name.split()[1]) - 2
        if getattr(throw.further_pins[place], f"web_{kind}", None) is not None:
            return f"further_pins[{place}].web_{kind}"
    return f"web_{kind}"


def _check_proportions(throw: "CrankThrow", parts: ThrowParts) -> None:
    """Refuse parts so thin or short that a mesh of them would never end."""
    largest = max(
        *(2.0 * c.radius for c in parts.cylinders), *(math.hypot(*p.axis) for p in parts.pins)
    )
    lowest = largest * THINNEST_PART
    sizes = [
        (_field(throw, parts, c, "length"), (c.end - c.start) * (1.0 if c.is_pin else 2.0))
        for c in parts.cylinders
    ]
    sizes += [
        (_web_field(throw, w, "thickness"), w.end - w.start) for w in parts.webs if w.end > w.start
    ]
    for name, value in sizes:
        if value < lowest * (1.0 - 1e-12):
            raise _refuse(
                name,
                value,
                f"{_mm(lowest)} or more beside the throw's other dimensions (up to {_mm(largest)})",
                "because a thinner part cannot be meshed sensibly",
            )


def _check_corners(throw: "CrankThrow") -> None:
    """Corners belong to rectangles."""
    webs = {"left_web.": throw.left_web, "right_web.": throw.right_web}
    given: list[tuple[str, float | None, str]] = [
        (f"{table}{kind}", getattr(web, kind), web.outline or throw.web_outline)
        for table, web in webs.items()
        if web is not None
        for kind in ("corner_radius", "corner_chamfer")
    ]
    outlines = [(web and web.outline) or throw.web_outline for web in webs.values()]
    common = "rectangle" if "rectangle" in outlines else "obround"
    given.append(("web_corner_radius", throw.web_corner_radius, common))
    given.append(("web_corner_chamfer", throw.web_corner_chamfer, common))
    for name, value, outline in given:
        if value and outline != "rectangle":
            raise _refuse(name, value, "only 0", "because an obround web has no corners")


def _check_outlines(throw: "CrankThrow") -> None:
    """Steps and corners of an outline must be absent or large enough to mesh."""
    for table, web in (("left_web", throw.left_web), ("right_web", throw.right_web)):

        def dimension(
            kind: str, web: Web | None = web, table: str = table
        ) -> tuple[str, float | None]:
            own = None if web is None else getattr(web, kind)
            if own is not None:
                return f"{table}.{kind}", own
            return f"web_{kind}", getattr(throw, f"web_{kind}")

        width = dimension("width")[1]
        assert width is not None
        smallest = SMALLEST_CORNER * width
        for kind in ("corner_radius", "corner_chamfer"):
            name, value = dimension(kind)
            if value and value < smallest:
                raise _refuse(
                    name,
                    value,
                    f"0, or {_mm(smallest)} or more",
                    "because a smaller one acts as a sharp corner",
                )
        if ((web and web.outline) or throw.web_outline) == "rectangle":
            continue
        step = SMALLEST_END_STEP * width
        for kind in ("journal_end", "pin_end"):
            name, value = dimension(kind)
            if value is not None and 1e-9 * width < abs(value - 0.5 * width) < step:
                raise _refuse(
                    name,
                    value,
                    f"{_mm(0.5 * width)}, or a value {_mm(step)} or more off it",
                    "because a smaller step from half the web's width cannot be meshed",
                )


def _seats(web: WebPlate, before: Cylinder, after: Cylinder) -> list[tuple[Cylinder, float]]:
    """The two cylinders on a web with the heights of their axes in its coordinates."""
    return [
        (cylinder, 0.0 if math.dist(cylinder.axis, web.foot) == 0.0 else web.distance)
        for cylinder in (before, after)
    ]


def _check_seat(
    throw: "CrankThrow", parts: ThrowParts, web: WebPlate, cylinder: Cylinder, axis: float
) -> None:
    """A journal must lie within its web."""
    reach = web.outline.distance(axis)
    width = _mm(web.outline.width)
    # A journal whose surface is also that of the web cannot be meshed; a fillet keeps them apart.
    limit = 2.0 * reach / (1.0 if _fillet_on(web, cylinder) > 0.0 else 1.0 + SMALLEST_LEDGE)
    if 2.0 * cylinder.radius > limit:
        raise _refuse(
            _field(throw, parts, cylinder, "diameter"),
            2.0 * cylinder.radius,
            f"at most {_mm(limit)} with a web width of {width}",
            f"or the {_label(cylinder)} would stand outside the {_which(throw, web)}",
        )


def _which(throw: "CrankThrow", web: WebPlate) -> str:
    """A web's name, where the webs differ."""
    return web.name if throw.left_web or throw.right_web or throw.further_pins else "web"


def _fillet_on(web: WebPlate, cylinder: Cylinder) -> float:
    return cylinder.start_fillet if cylinder.start == web.end else cylinder.end_fillet


def _check_fillets(throw: "CrankThrow", parts: ThrowParts) -> None:
    """Fillets must leave some of their journal, fit their webs, and be large enough to matter."""
    given: dict[str, float] = {}
    limits: dict[str, list[tuple[float, str]]] = {}
    lowest: dict[str, float] = {}
    for cylinder in parts.cylinders:
        name = _field(throw, parts, cylinder, "fillet_radius")
        if max(cylinder.start_fillet, cylinder.end_fillet) == 0.0:
            continue
        given[name] = max(cylinder.start_fillet, cylinder.end_fillet)
        # Of a main journal, the throw has half.
        length = (cylinder.end - cylinder.start) * (1.0 if cylinder.is_pin else 2.0)
        reason = f"the {_label(cylinder)} of {_mm(length)} is too short for two larger fillets"
        limits.setdefault(name, []).append((FILLET_SHARE_OF_LENGTH * length, reason))
        smallest = SMALLEST_FILLET_SHARE * 2.0 * cylinder.radius
        lowest[name] = max(lowest.get(name, 0.0), smallest)
    for place, web in enumerate(parts.webs):
        for cylinder, axis in _seats(web, *parts.cylinders[place : place + 2]):
            name = _field(throw, parts, cylinder, "fillet_radius")
            if name in limits and _fillet_on(web, cylinder) > 0.0:
                reason = (
                    f"the {_which(throw, web)} of {_mm(web.outline.width)} is too narrow for a larger one "
                    f"round the {_label(cylinder)} of {_mm(2.0 * cylinder.radius)}"
                )
                room = web.outline.distance(axis) - cylinder.radius
                limits[name].append((room, reason))
                ledge = room - _fillet_on(web, cylinder)
                smallest = SMALLEST_FOOT_LEDGE * 2.0 * cylinder.radius
                if 1e-9 * room < ledge < smallest:
                    raise _refuse(
                        name,
                        _fillet_on(web, cylinder),
                        f"at most {_mm(room - smallest)}, or {show_quantity(room, 'm', 9)} exactly",
                        f"because its foot is {_mm(ledge)} inside the edge of the {_which(throw, web)}, too "
                        "close to be meshed",
                    )
    for name, radius in given.items():
        highest, reason = min(limits[name], key=lambda limit: limit[0])
        allowed = f"0, or {_mm(lowest[name])} to {_mm(highest)}"
        if highest < lowest[name]:
            allowed = "only 0 (sharp corners)"
        if radius > highest * (1.0 + 1e-12):
            raise _refuse(name, radius, allowed, f"because {reason}")
        if radius < lowest[name] * (1.0 - 1e-12):
            raise _refuse(
                name, radius, allowed, "because a smaller one acts as a sharp corner (give 0)"
            )


def _check_bore(throw: "CrankThrow", parts: ThrowParts, cylinder: Cylinder) -> None:
    """A bore must leave a wall."""
    diameter, bore = 2.0 * cylinder.radius, 2.0 * cylinder.bore_radius
    offset = math.dist(cylinder.axis, cylinder.bore_axis)
    name = _field(throw, parts, cylinder, "bore")
    if bore == 0.0:
        if offset > 0.0:
            raise _refuse(f"{name}_offset", offset, "only 0", "because there is no bore")
        return
    lowest, wall = SMALLEST_BORE * diameter, SMALLEST_WALL * diameter
    highest = diameter - 2.0 * wall - 2.0 * offset
    if bore > highest * (1.0 + 1e-12) or bore < lowest * (1.0 - 1e-12):
        allowed = "only 0" if highest < lowest else f"0, or {_mm(lowest)} to {_mm(highest)}"
        reason = (
            f"because a wall of {_mm(wall)} must remain in the {_label(cylinder)} of {_mm(diameter)}"
            + (f" with the bore {_mm(offset)} off its axis" if offset > 0.0 else "")
            if bore > highest
            else f"because a smaller bore does not matter to the {_label(cylinder)} (give 0)"
        )
        raise _refuse(name, bore, allowed, reason)


def _check_wall_between(web: WebPlate, before: Cylinder, after: Cylinder) -> None:
    """Two bores through one web must not meet."""
    if before.bore_radius == 0.0 or after.bore_radius == 0.0:
        return
    wall = math.dist(before.bore_axis, after.bore_axis) - before.bore_radius - after.bore_radius
    lowest = SMALLEST_WALL * 2.0 * min(before.radius, after.radius)
    if wall < lowest:
        raise InputError(
            f"throw.pin_bore: given bores of {_mm(2.0 * before.bore_radius)} and "
            f"{_mm(2.0 * after.bore_radius)}, which leave {_mm(wall)} between them in the {web.name}; "
            f"allowed is {_mm(lowest)} or more, because they must not meet."
        )


def _check_slopes(throw: "CrankThrow", web: WebPlate) -> None:
    """A web may be thinned towards its ends outside the journals' collars."""
    thickness = web.end - web.start
    width = web.outline.width
    for slope in web.slopes:
        kind, joined = (
            ("tip_thickness", "main journal")
            if slope.towards > 0.0
            else ("foot_thickness", "crankpin")
        )
        name, given = _web_field(throw, web, kind), thickness - slope.drop
        if not THINNEST_END * thickness <= given <= thickness:
            raise _refuse(
                name,
                given,
                f"{_mm(THINNEST_END * thickness)} to {_mm(thickness)}",
                f"because the web of {_mm(thickness)} gets thinner towards its end, but not to an edge",
            )
        room = slope.towards * (slope.end - slope.start)
        if room < SHORTEST_SLOPE * width:
            raise _refuse(
                name,
                given,
                f"only {_mm(thickness)}",
                f"because the {joined} leaves no room on the web's face to thin it",
            )


def _check_counterweight(
    throw: "CrankThrow",
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
        raise _refuse(
            f"{name}.outer_radius",
            sector.outer_radius,
            f"{_mm(COUNTERWEIGHT_STANDS_OUT * reach)} or more",
            f"because the {web.name} itself reaches {_mm(reach)} from the shaft axis",
        )
    if sector.inner_radius > COUNTERWEIGHT_REACHES_IN * reach:
        raise _refuse(
            f"{name}.inner_radius",
            sector.inner_radius,
            f"0 to {_mm(COUNTERWEIGHT_REACHES_IN * reach)}",
            f"because it must reach into the {web.name}, which ends {_mm(reach)} from the shaft axis",
        )
    thickness = web.end - web.start
    foot_drop = sum(s.drop for s in web.slopes if s.towards < 0.0)
    start = web.start + (foot_drop if outer > 0.0 else 0.0)
    end = web.end - (foot_drop if outer < 0.0 else 0.0)
    shared = min(end, sector.end) - max(start, sector.start)
    lowest = COUNTERWEIGHT_SHARES * min(thickness, sector.end - sector.start)
    if shared < lowest:
        raise _refuse(
            f"{name}.offset",
            0.5 * (sector.start + sector.end - web.start - web.end) * -outer,
            f"one that puts more of its {_mm(sector.end - sector.start)} on the web",
            f"because {_mm(lowest)} of the thickness must be shared with the {web.name}, not "
            f"{_mm(max(shared, 0.0))}",
        )
    for step in (abs(sector.start - web.start), abs(sector.end - web.end)):
        if 0.0 < step < SMALLEST_STEP * thickness:
            raise _refuse(
                f"{name}.thickness",
                sector.end - sector.start,
                f"one whose faces are flush with the {web.name} or {_mm(SMALLEST_STEP * thickness)} off",
                f"because a step of {_mm(step)} cannot be meshed sensibly",
            )
    beyond_outer = (web.start - sector.start) if outer < 0.0 else (sector.end - web.end)
    beyond_inner = (sector.end - web.end) if outer < 0.0 else (web.start - sector.start)
    if beyond_outer > 0.0:
        room = 0.9 * (journal.end - journal.start)
        if beyond_outer > room:
            raise _refuse(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {_mm(room)} beyond the {web.name}",
                "or it would meet the neighboring throw's",
            )
        clear = 1.02 * journal.collar
        if sector.inner_radius < clear:
            raise _refuse(
                f"{name}.inner_radius",
                sector.inner_radius,
                f"{_mm(clear)} or more",
                f"because the counterweight stands {_mm(beyond_outer)} out over the main bearing, which it "
                "must clear",
            )
    if beyond_inner > 0.0:
        room = FILLET_SHARE_OF_LENGTH * (pin.end - pin.start)
        if beyond_inner > room:
            raise _refuse(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {_mm(room)} beyond the {web.name} towards the crankpin",
                "or it would meet the other web's",
            )
        lowest_pin = web.distance - 1.02 * pin.collar
        highest = -sector.inner_radius * math.cos(sector.half_angle)
        if highest > lowest_pin:
            raise _refuse(
                f"{name}.inner_radius",
                sector.inner_radius,
                "a larger one, or a smaller angle",
                f"because the counterweight stands {_mm(beyond_inner)} out beside the crankpin, which it "
                "must clear",
            )


def _check_split_pin(web: WebPlate, before: Cylinder, after: Cylinder) -> None:
    """Halves of a split pin must be one piece, and two."""
    together = before.radius + after.radius
    low, high = (share * together for share in SPLIT_PIN_STEP)
    if not low <= web.distance <= high:
        raise InputError(
            f"throw.further_pins: given a split pin without a web whose axes are "
            f"{_mm(web.distance)} apart; allowed is {_mm(low)} to {_mm(high)} with these diameters, "
            "because its halves must hold together and differ (else give web_thickness or one longer pin)."
        )
    for first, second in ((before, after), (after, before)):
        if first.bore_radius > 0.0:
            gap = second.radius - math.dist(first.bore_axis, second.axis) - first.bore_radius
            if gap < SMALLEST_WALL * 2.0 * second.radius:
                raise InputError(
                    f"throw.pin_bore: given {_mm(2.0 * first.bore_radius)} in a split pin without a web; "
                    f"allowed is 0 or a bore that leaves a wall in both halves, not {_mm(gap)}."
                )
