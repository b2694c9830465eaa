"""Checks that a throw's dimensions fit together: every refusal names field, value, limit and reason."""

import math
from collections.abc import Callable
from functools import partial
from itertools import combinations

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.sentences import amount, finished
from geometry.parts import (
    OUTLINE_DIMENSIONS,
    OUTLINES,
    Cylinder,
    Drilling,
    Sector,
    ThrowParts,
    WebPlate,
)
from geometry.throw_dimensions import ThrowDimensions, web_dimension


def shown(value: float) -> str:
    """Write a length [m] into a refusal."""
    return amount(value, "m")


def dimension_error(field: str, value: float, allowed: str, reason: str) -> InputError:
    """Make the error of a dimension [m]: given value, allowed values and reason."""
    return InputError(f"throw.{field}: given {shown(value)}; allowed is {allowed}, {reason}.")


def label(cylinder: Cylinder) -> str:
    """Name a journal or pin in a sentence."""
    return cylinder.name.replace("pin", "crankpin") if cylinder.is_pin else "main journal"


def cylinder_field(throw: ThrowDimensions, parts: ThrowParts, cylinder: Cylinder, kind: str) -> str:
    """Name of the field that gave a cylinder's dimension (diameter, length, fillet_radius, bore)."""
    if not cylinder.is_pin:
        name = f"main_journal_{kind}"
    else:
        place = parts.cylinders.index(cylinder) - 2 if throw.further_pins else -1
        if place >= 0 and getattr(throw.further_pins[place], kind) is not None:
            return f"further_pins[{place}].{kind}"
        name = f"pin_{kind}"
    if kind == "fillet_radius" and getattr(throw, name) is None:
        return "fillet_radius"
    return name


def web_field(throw: ThrowDimensions, web: WebPlate, kind: str) -> str:
    """Name of the field that gave a web's dimension."""
    if web.name in ("left web", "right web"):
        return web_dimension(throw, web.name.replace(" ", "_"), kind)[0]
    place = int(web.name.split()[1]) - 2
    if getattr(throw.further_pins[place], f"web_{kind}", None) is not None:
        return f"further_pins[{place}].web_{kind}"
    return f"web_{kind}"


def web_label(throw: ThrowDimensions, web: WebPlate) -> str:
    """Label of a web, where the webs differ."""
    return web.name if throw.left_web or throw.right_web or throw.further_pins else "web"


# Shares of the journal's diameter: smallest and largest hole, and what stays free beside its exits.
SMALLEST_HOLE, LARGEST_HOLE, FREE_LEDGE = 0.02, 0.4, 0.01
# The smallest exit radius and the thinnest wall beside a hole, beside its diameter.
SMALLEST_EXIT, WALL_BESIDE_HOLE = 0.05, 0.1
# A hole with its exit radius, beside the journal's radius less that; of the bore's radius, what a hole
# that runs into it may take.
WIDEST_EXIT, SHARE_OF_BORE = 0.6, 0.95
STEPS = 400


def check_drillings(parts: ThrowParts) -> None:
    """Refuse oil holes that cannot be drilled as described.

    Raises
    ------
    InputError
        With one sentence.
    """
    for hole in parts.drillings:
        journal = next(cylinder for cylinder in parts.cylinders if cylinder.name == hole.journal)
        _check_sizes(hole, journal)
        if hole.bore_radius > 0.0:
            _check_run_into_bore(hole, journal)
        _check_place(parts, hole, journal)
    for first, second in combinations(parts.drillings, 2):
        if first.journal != second.journal:
            continue
        # Holes must not meet each other, nor their exits.
        wall = WALL_BESIDE_HOLE * 2.0 * min(first.radius, second.radius)
        between = min(
            _distance(part, other) - first.radius - second.radius
            for part in _stretches(first)
            for other in _stretches(second)
        )
        exits = min(
            float(np.linalg.norm(part[:, None] - other[None], axis=2).min())
            for part in _rims(first)
            for other in _rims(second)
        )
        if min(between, exits) < wall:
            what = "runs into" if between < wall else "comes out into the exit of"
            raise InputError(
                f"throw.oil_holes[{second.number - 1}]: given so that it {what} "
                f"oil_holes[{first.number - 1}]; allowed are holes that leave {shown(wall)} between them, "
                "because each is calculated separately."
            )


def _field(hole: Drilling, name: str) -> str:
    return f"oil_holes[{hole.number - 1}].{name}"


def _check_sizes(hole: Drilling, journal: Cylinder) -> None:
    """A hole's diameter and the radius of its exit are in proportion to its journal."""
    diameter, outside = 2.0 * hole.radius, 2.0 * hole.journal_radius
    low, high = SMALLEST_HOLE * outside, LARGEST_HOLE * outside
    if not low * (1.0 - 1e-12) <= diameter <= high * (1.0 + 1e-12):
        reason = (
            "a larger one leaves too little of it"
            if diameter > high
            else "a smaller one does not matter (leave it out)"
        )
        raise dimension_error(
            _field(hole, "diameter"),
            diameter,
            f"{shown(low)} to {shown(high)} in the {label(journal)} of {shown(outside)}",
            f"because {reason}",
        )
    radius, low = hole.exit_radius, SMALLEST_EXIT * 2.0 * hole.radius
    room = (WIDEST_EXIT * hole.journal_radius - hole.radius) / (1.0 + WIDEST_EXIT)
    high = min(2.0 * hole.radius, room)
    if radius and not low * (1.0 - 1e-12) <= radius <= high * (1.0 + 1e-12):
        reason = (
            "a smaller one acts as a sharp edge (give 0)"
            if radius < low
            else f"the hole of {shown(2.0 * hole.radius)} cannot be opened further"
        )
        raise dimension_error(
            _field(hole, "exit_radius"),
            radius,
            f"0, or {shown(low)} to {shown(high)}",
            f"because {reason}",
        )


def _check_run_into_bore(hole: Drilling, journal: Cylinder) -> None:
    """A hole enters the bore with its whole width, or passes it by."""
    across, along = hole.bore_place
    wall = WALL_BESIDE_HOLE * 2.0 * hole.radius
    if abs(across) - hole.radius >= hole.bore_radius + wall:
        return
    widest = 2.0 * (SHARE_OF_BORE * hole.bore_radius - abs(across))
    if 2.0 * hole.radius > widest * (1.0 + 1e-12):
        bore = f"the {label(journal)}'s bore of {shown(2.0 * hole.bore_radius)}"
        off = (
            f", whose axis passes the hole's at {shown(abs(across))}" if abs(across) > 1e-9 else ""
        )
        reason = f"because it must run with its whole width into {bore}{off}, or pass it by"
        if widest <= 0.0:
            raise InputError(
                f"throw.{_field(hole, 'angle')}: given {math.degrees(hole.angle):.6g} deg; allowed is "
                f"another one, {reason}."
            )
        raise dimension_error(
            _field(hole, "diameter"),
            2.0 * hole.radius,
            f"at most {shown(widest)} at this angle",
            reason,
        )
    for outlet in hole.exits:
        p, q, t = outlet.lip.T
        height = outlet.side * (t * math.cos(hole.tilt) + q * math.sin(hole.tilt) - along)
        left = float(np.min(height - np.sqrt(hole.bore_radius**2 - (p - across) ** 2)))
        if left < wall:
            raise dimension_error(
                _field(hole, "exit_radius"),
                hole.exit_radius,
                "a smaller one",
                f"because {shown(wall)} of straight hole must be left between its rounding and the bore of "
                f"{shown(2.0 * hole.bore_radius)}",
            )


def _check_place(parts: ThrowParts, hole: Drilling, journal: Cylinder) -> None:
    """A hole's exit is on its journal between the fillets, and clear of the throw's ends."""
    reached = [np.asarray(hole.place + outlet.rim @ hole.frame[:, 2]) for outlet in hole.exits]
    if not hole.through:
        half = hole.radius * math.cos(hole.tilt)
        reached.append(np.array([hole.place - half, hole.place + half]))
    lowest, highest = min(z.min() for z in reached), max(z.max() for z in reached)
    ledge = FREE_LEDGE * 2.0 * hole.journal_radius
    start = journal.start + journal.start_fillet + ledge
    end = journal.end - journal.end_fillet - ledge
    if lowest >= start * (1.0 - 1e-12) and highest <= end * (1.0 + 1e-12):
        return
    middle = 0.5 * (journal.start + journal.end)
    if not journal.is_pin:
        middle = journal.start if journal is parts.cylinders[0] else journal.end
    position = hole.place - middle
    low, high = position + start - lowest, position + end - highest
    if low > high:
        raise dimension_error(
            _field(hole, "diameter"),
            2.0 * hole.radius,
            f"a hole that takes at most {shown(end - start)} along the shaft with tilt and exit radius, not "
            f"{shown(highest - lowest)}",
            f"because the {label(journal)} has no more between its fillets"
            + ("" if journal.is_pin else " and the end of the throw"),
        )
    at_end = lowest < start if journal is parts.cylinders[0] else highest > end
    reason = (
        "because the throw ends in the middle of the main journal, and its section there must be whole"
        if not journal.is_pin and at_end
        else f"or the hole would cut the {label(journal)}'s fillet or the web"
    )
    raise dimension_error(
        _field(hole, "position"), position, f"{shown(low)} to {shown(high)}", reason
    )


def _rims(hole: Drilling) -> list[Array]:
    return [hole.middle + outlet.rim @ hole.frame for outlet in hole.exits]


def _stretches(hole: Drilling) -> list[tuple[Array, Array]]:
    """Ends of the axis of each stretch of a hole in the material; a bore is open between two."""
    none = np.zeros(1)
    return [
        (hole.middle + outlet.inner(none, none)[0] * hole.frame[2], outlet.point)
        for outlet in hole.exits
    ]


def _distance(stretch: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """Distance of two stretches [m]."""
    points = stretch[0] + np.linspace(0.0, 1.0, STEPS)[:, None] * (stretch[1] - stretch[0])
    way = other[1] - other[0]
    share = np.clip((points - other[0]) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(points - other[0] - share[:, None] * way, axis=1).min())


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
    web_table = getattr(throw, web.name.replace(" ", "_"))
    table = (
        f"{web.name.replace(' ', '_')}."
        if web_table is not None and web_table.counterweight
        else ""
    )
    name = f"{table}counterweight"
    reach = -web.outline.foot
    if sector.outer_radius < COUNTERWEIGHT_STANDS_OUT * reach:
        raise dimension_error(
            f"{name}.outer_radius",
            sector.outer_radius,
            f"{shown(COUNTERWEIGHT_STANDS_OUT * reach)} or more",
            f"because the {web.name} itself reaches {shown(reach)} from the shaft axis",
        )
    if sector.inner_radius > COUNTERWEIGHT_REACHES_IN * reach:
        raise dimension_error(
            f"{name}.inner_radius",
            sector.inner_radius,
            f"0 to {shown(COUNTERWEIGHT_REACHES_IN * reach)}",
            f"because it must reach into the {web.name}, which ends {shown(reach)} from the shaft axis",
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
            f"one that puts more of its {shown(sector.end - sector.start)} on the web",
            f"because {shown(lowest)} of the thickness must be shared with the {web.name}, not "
            f"{shown(max(shared, 0.0))}",
        )
    for step in (abs(sector.start - web.start), abs(sector.end - web.end)):
        if 0.0 < step < SMALLEST_STEP * thickness:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"one whose faces are flush with the {web.name} or {shown(SMALLEST_STEP * thickness)} off",
                f"because a step of {shown(step)} cannot be meshed sensibly",
            )
    beyond_outer = (web.start - sector.start) if outer < 0.0 else (sector.end - web.end)
    beyond_inner = (sector.end - web.end) if outer < 0.0 else (web.start - sector.start)
    if beyond_outer > 0.0:
        room = 0.9 * (journal.end - journal.start)
        if beyond_outer > room:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {shown(room)} beyond the {web.name}",
                "or it would meet the neighboring throw's",
            )
        clear = 1.02 * journal.collar
        if sector.inner_radius < clear:
            raise dimension_error(
                f"{name}.inner_radius",
                sector.inner_radius,
                f"{shown(clear)} or more",
                f"because the counterweight stands {shown(beyond_outer)} out over the main bearing, which it "
                "must clear",
            )
    if beyond_inner > 0.0:
        room = SHARE_OF_PIN_LENGTH * (pin.end - pin.start)
        if beyond_inner > room:
            raise dimension_error(
                f"{name}.thickness",
                sector.end - sector.start,
                f"at most {shown(room)} beyond the {web.name} towards the crankpin",
                "or it would meet the other web's",
            )
        lowest_pin = web.distance - 1.02 * pin.collar
        highest = -sector.inner_radius * math.cos(sector.half_angle)
        if highest > lowest_pin:
            raise dimension_error(
                f"{name}.inner_radius",
                sector.inner_radius,
                "a larger one, or a smaller angle",
                f"because the counterweight stands {shown(beyond_inner)} out beside the crankpin, which it "
                "must clear",
            )


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
# No part may be thinner than this share of the largest dimension.
THINNEST_PART = 1.0 / 25.0
# All that describes an ordinary throw.
FIRST_EIGHT = frozenset(tuple(ThrowDimensions.model_fields)[:8])
# The halves of a split pin without a web: distance of their axes beside the sum of their radii.
SPLIT_PIN_STEP = (0.02, 0.7)


def check_throw(throw: ThrowDimensions, parts: ThrowParts) -> None:
    """Refuse a throw that cannot be built or meshed.

    Parameters
    ----------
    throw : ThrowDimensions
        For the names of the given fields.
    parts : ThrowParts
        Its parts.

    Raises
    ------
    InputError
        With one sentence.
    """
    _check_proportions(throw, parts)
    _check_outlines(throw)
    # The two cylinders beside each web, with the distances of their axes from its outline.
    seats = [
        [
            (cylinder, web.outline.distance(0.0 if cylinder.axis == web.foot else web.distance))
            for cylinder in parts.cylinders[place : place + 2]
        ]
        for place, web in enumerate(parts.webs)
    ]
    for place, web in enumerate(parts.webs):
        before, after = parts.cylinders[place : place + 2]
        if web.end == web.start:
            _check_split_pin(web, before, after)
            continue
        for cylinder, reach in seats[place]:
            # A journal must be within its web, whose edge keeps a minimum distance from its axis.
            # A journal whose surface is also that of the web cannot be meshed; a fillet keeps them apart.
            limit = 2.0 * reach / (1.0 if _fillet_on(web, cylinder) > 0.0 else 1.0 + SMALLEST_LEDGE)
            if 2.0 * cylinder.radius > limit:
                raise dimension_error(
                    cylinder_field(throw, parts, cylinder, "diameter"),
                    2.0 * cylinder.radius,
                    f"at most {shown(limit)} with a web width of {shown(web.outline.width)}",
                    f"or the {label(cylinder)} would stand outside the {web_label(throw, web)}",
                )
        if 1e-9 * web.outline.width < web.distance < SMALLEST_PIN_STEP * 2.0 * after.radius:
            raise InputError(
                f"throw.further_pins: given pins whose axes are {shown(web.distance)} apart; allowed is 0 or "
                f"{shown(SMALLEST_PIN_STEP * 2.0 * after.radius)} or more, because a smaller step cannot be "
                "meshed."
            )
        _check_wall_between(web, before, after)
        _check_slopes(throw, web)
        if web.sector is not None:
            journal, pin = (before, after) if place == 0 else (after, before)
            check_counterweight(
                throw, web, web.sector, journal, pin, outer=-1.0 if place == 0 else 1.0
            )
    _check_fillets(throw, parts, seats)
    for cylinder in parts.cylinders:
        _check_bore(throw, parts, cylinder)
    check_drillings(parts)


def fits_plainly(throw: ThrowDimensions) -> bool:
    """Whether a throw with only the first eight dimensions passes `check_throw`, without its parts.

    Returns
    -------
    bool
        False if only `check_throw` can decide.
    """
    if not throw.model_fields_set <= FIRST_EIGHT:
        return False
    journal, pin, fillet = throw.main_journal_diameter, throw.pin_diameter, throw.fillet_radius
    larger, radius = max(journal, pin), throw.crank_radius
    length = min(throw.main_journal_length, throw.pin_length)
    # Both axes are half a width from an obround's outline; a percent for round-off, and more.
    room = 0.5 * (throw.web_width - 1.01 * larger)
    return (
        1.01 * THINNEST_PART * max(larger, radius) < min(length, throw.web_thickness)
        and radius > 1.01 * SMALLEST_PIN_STEP * larger
        and room > 0.0
        and (
            fillet == 0.0
            or 1.01 * SMALLEST_FILLET_SHARE * larger
            < fillet
            < 0.99 * min(room, FILLET_SHARE_OF_LENGTH * length)
        )
    )


def throw_remarks(parts: ThrowParts) -> tuple[str, ...]:
    """Features that can be built but are hardly intended: bores that open into another journal's fillet."""
    remarks = []
    for place, web in enumerate(parts.webs):
        joined = parts.cylinders[place : place + 2]
        for bored, other in (joined, joined[::-1]):
            if bored.bore_radius == 0.0 or web.end == web.start:
                continue
            apart = math.dist(bored.bore_axis, other.axis)
            if abs(other.collar - apart) < bored.bore_radius:
                remarks.append(
                    f"The bore of the {label(bored)} cuts the fillet or the surface of the "
                    f"{label(other)} at the {web.name}: it comes out {shown(apart - bored.bore_radius)} to "
                    f"{shown(apart + bored.bore_radius)} from that axis, and the fillet's foot is at "
                    f"{shown(other.collar)}."
                )
    return tuple(map(finished, dict.fromkeys(remarks)))


def _check_proportions(throw: ThrowDimensions, parts: ThrowParts) -> None:
    """Refuse parts so thin or short that their mesh would be endless."""
    largest = max(
        *(2.0 * c.radius for c in parts.cylinders), *(math.hypot(*p.axis) for p in parts.pins)
    )
    lowest = largest * THINNEST_PART
    for cylinder in parts.cylinders:
        length = (cylinder.end - cylinder.start) * (1.0 if cylinder.is_pin else 2.0)
        if length < lowest * (1.0 - 1e-12):
            raise _too_thin(
                cylinder_field(throw, parts, cylinder, "length"), length, lowest, largest
            )
    for web in parts.webs:
        if web.start < web.end < web.start + lowest * (1.0 - 1e-12):
            name = web_field(throw, web, "thickness")
            raise _too_thin(name, web.end - web.start, lowest, largest)


def _too_thin(name: str, value: float, lowest: float, largest: float) -> InputError:
    return dimension_error(
        name,
        value,
        f"{shown(lowest)} or more, compared with the throw's other dimensions (up to {shown(largest)})",
        "because a thinner part cannot be meshed sensibly",
    )


def _check_outlines(throw: ThrowDimensions) -> None:
    """Dimensions of other outlines must be absent, its steps and corners large enough to mesh."""
    outlines = {
        table: web_dimension(throw, table, "outline")[1] for table in ("left_web", "right_web")
    }
    for kind in OUTLINE_DIMENSIONS:
        without = {
            table: outline
            for table, outline in outlines.items()
            if kind not in OUTLINES[outline].dimensions
        }
        for table, outline in without.items():
            _check_absent(f"{table}.{kind}", getattr(getattr(throw, table), kind, None), outline)
        if len(without) == len(outlines):
            _check_absent(f"web_{kind}", getattr(throw, f"web_{kind}"), outlines["left_web"])
    for table, outline in outlines.items():
        width = web_dimension(throw, table, "width")[1]
        smallest = SMALLEST_CORNER * width
        for kind, what in OUTLINE_DIMENSIONS.items():
            name, value = web_dimension(throw, table, kind)
            if what == "corners" and value and value < smallest:
                raise dimension_error(
                    name,
                    value,
                    f"0, or {shown(smallest)} or more",
                    "because a smaller one acts as a sharp corner",
                )
        if not OUTLINES[outline].round_ends:
            continue
        step = SMALLEST_END_STEP * width
        for kind in ("journal_end", "pin_end"):
            name, value = web_dimension(throw, table, kind)
            if value is not None and 1e-9 * width < abs(value - 0.5 * width) < step:
                raise dimension_error(
                    name,
                    value,
                    f"{shown(0.5 * width)}, or a value {shown(step)} or more off it",
                    "because a smaller step from half the web's width cannot be meshed",
                )


def _check_absent(field: str, value: float | None, outline: str) -> None:
    if value:
        what = OUTLINE_DIMENSIONS[field.partition(".")[2] or field.removeprefix("web_")]
        article = "an" if outline[0] in "aeiou" else "a"
        reason = f"because {article} {outline} web has no {what}"
        raise dimension_error(field, value, "only 0", reason)


def _fillet_on(web: WebPlate, cylinder: Cylinder) -> float:
    return cylinder.start_fillet if cylinder.start == web.end else cylinder.end_fillet


def _check_fillets(
    throw: ThrowDimensions, parts: ThrowParts, seats: list[list[tuple[Cylinder, float]]]
) -> None:
    """Fillets must leave part of their journal, fit their webs, and be large enough to matter."""
    radii: dict[str, float] = {}
    limits: dict[str, list[tuple[float, Callable[[], str]]]] = {}
    lowest: dict[str, float] = {}
    for cylinder in parts.cylinders:
        name = cylinder_field(throw, parts, cylinder, "fillet_radius")
        if max(cylinder.start_fillet, cylinder.end_fillet) == 0.0:
            continue
        radii[name] = max(cylinder.start_fillet, cylinder.end_fillet)
        # Of a main journal, the throw has half.
        length = (cylinder.end - cylinder.start) * (1.0 if cylinder.is_pin else 2.0)
        limits.setdefault(name, []).append(
            (FILLET_SHARE_OF_LENGTH * length, partial(_too_short, cylinder, length))
        )
        smallest = SMALLEST_FILLET_SHARE * 2.0 * cylinder.radius
        lowest[name] = max(lowest.get(name, 0.0), smallest)
    for web, joined in zip(parts.webs, seats, strict=True):
        for cylinder, reach in joined:
            name = cylinder_field(throw, parts, cylinder, "fillet_radius")
            if name in limits and _fillet_on(web, cylinder) > 0.0:
                room = reach - cylinder.radius
                limits[name].append((room, partial(_too_narrow, throw, web, cylinder)))
                ledge = room - _fillet_on(web, cylinder)
                smallest = SMALLEST_FOOT_LEDGE * 2.0 * cylinder.radius
                if 1e-9 * room < ledge < smallest:
                    raise dimension_error(
                        name,
                        _fillet_on(web, cylinder),
                        f"at most {shown(room - smallest)}, or {amount(room, 'm', 9)} exactly",
                        f"because its foot is {shown(ledge)} inside the edge of the {web_label(throw, web)}, "
                        "too close to be meshed",
                    )
    for name, radius in radii.items():
        highest, reason = min(limits[name], key=lambda limit: limit[0])
        if lowest[name] * (1.0 - 1e-12) <= radius <= highest * (1.0 + 1e-12):
            continue
        allowed = f"0, or {shown(lowest[name])} to {shown(highest)}"
        if highest < lowest[name]:
            allowed = "only 0 (sharp corners)"
        if radius > highest * (1.0 + 1e-12):
            raise dimension_error(name, radius, allowed, f"because {reason()}")
        raise dimension_error(
            name, radius, allowed, "because a smaller one acts as a sharp corner (give 0)"
        )


def _too_short(cylinder: Cylinder, length: float) -> str:
    return f"the {label(cylinder)} of {shown(length)} is too short for two larger fillets"


def _too_narrow(throw: ThrowDimensions, web: WebPlate, cylinder: Cylinder) -> str:
    return (
        f"the {web_label(throw, web)} of {shown(web.outline.width)} is too narrow for a larger one around "
        f"the {label(cylinder)} of {shown(2.0 * cylinder.radius)}"
    )


def _check_bore(throw: ThrowDimensions, parts: ThrowParts, cylinder: Cylinder) -> None:
    """A bore must leave a wall."""
    diameter, bore = 2.0 * cylinder.radius, 2.0 * cylinder.bore_radius
    offset = math.dist(cylinder.axis, cylinder.bore_axis)
    if bore == 0.0:
        if offset > 0.0:
            name = cylinder_field(throw, parts, cylinder, "bore")
            raise dimension_error(f"{name}_offset", offset, "only 0", "because there is no bore")
        return
    lowest, wall = SMALLEST_BORE * diameter, SMALLEST_WALL * diameter
    highest = diameter - 2.0 * wall - 2.0 * offset
    if bore > highest * (1.0 + 1e-12) or bore < lowest * (1.0 - 1e-12):
        allowed = "only 0" if highest < lowest else f"0, or {shown(lowest)} to {shown(highest)}"
        reason = (
            f"because a wall of {shown(wall)} must remain in the {label(cylinder)} of {shown(diameter)}"
            + (f" with the bore {shown(offset)} off its axis" if offset > 0.0 else "")
            if bore > highest
            else f"because a smaller bore does not matter to the {label(cylinder)} (give 0)"
        )
        raise dimension_error(cylinder_field(throw, parts, cylinder, "bore"), bore, allowed, reason)


def _check_wall_between(web: WebPlate, before: Cylinder, after: Cylinder) -> None:
    """Two bores through one web must not meet."""
    if before.bore_radius == 0.0 or after.bore_radius == 0.0:
        return
    wall = math.dist(before.bore_axis, after.bore_axis) - before.bore_radius - after.bore_radius
    lowest = SMALLEST_WALL * 2.0 * min(before.radius, after.radius)
    if wall < lowest:
        raise InputError(
            f"throw.pin_bore: given bores of {shown(2.0 * before.bore_radius)} and "
            f"{shown(2.0 * after.bore_radius)}, which leave {shown(wall)} between them in the {web.name}; "
            f"allowed is {shown(lowest)} or more, because they must not meet."
        )


def _check_slopes(throw: ThrowDimensions, web: WebPlate) -> None:
    """A web may be thinned towards its ends outside the journals' collars."""
    thickness = web.end - web.start
    width = web.outline.width
    for slope in web.slopes:
        kind, joined = (
            ("tip_thickness", "main journal")
            if slope.towards > 0.0
            else ("foot_thickness", "crankpin")
        )
        name, end_thickness = web_field(throw, web, kind), thickness - slope.drop
        if not THINNEST_END * thickness <= end_thickness <= thickness:
            raise dimension_error(
                name,
                end_thickness,
                f"{shown(THINNEST_END * thickness)} to {shown(thickness)}",
                f"because the web of {shown(thickness)} gets thinner towards its end, but not to an edge",
            )
        room = slope.towards * (slope.end - slope.start)
        if room < SHORTEST_SLOPE * width:
            raise dimension_error(
                name,
                end_thickness,
                f"only {shown(thickness)}",
                f"because the {joined} leaves no room on the web's face to thin it",
            )


def _check_split_pin(web: WebPlate, before: Cylinder, after: Cylinder) -> None:
    """Halves of a split pin must be one piece, and two."""
    together = before.radius + after.radius
    low, high = (share * together for share in SPLIT_PIN_STEP)
    if not low <= web.distance <= high:
        raise InputError(
            f"throw.further_pins: given a split pin without a web whose axes are {shown(web.distance)} "
            f"apart; allowed is {shown(low)} to {shown(high)} with these diameters, because its halves must "
            "hold together and differ (else give web_thickness or one longer pin)."
        )
    for first, second in ((before, after), (after, before)):
        if first.bore_radius > 0.0:
            gap = second.radius - math.dist(first.bore_axis, second.axis) - first.bore_radius
            if gap < SMALLEST_WALL * 2.0 * second.radius:
                raise InputError(
                    f"throw.pin_bore: given {shown(2.0 * first.bore_radius)} in a split pin without a web; "
                    f"allowed is 0 or a bore that leaves a wall in both halves, not {shown(gap)}."
                )
