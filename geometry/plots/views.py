"""Side and end view of a throw, with their dimensions."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

from crankbase.array_checks import Array
from geometry.parts import Arc, Cylinder, Drilling, DrillingExit, Line, Sector, ThrowParts, WebPlate
from geometry.plots.dimension_lines import (
    BEYOND,
    CENTER,
    DIMENSION,
    EDGE,
    HIDDEN,
    JOURNAL_COLOR,
    OPEN,
    OUTLINE,
    THIN_CENTER,
    WEB_COLOR,
    Callout,
    Linear,
    Point,
    View,
    at_smaller_x,
    bore_offset,
    circle,
    corner_texts,
    degrees,
    distances_to_ends,
    distinct_values,
    faces_at,
    half_width,
    has_flush_weight,
    highest_full_width,
    millimeters,
    mirror,
    name_of,
    on_weight,
    outline,
    outline_uv,
    place,
    sector_arc,
    sector_uv,
    silhouette,
    symbol,
    text_size,
    weight_outline,
)

# Right and up in each view, as rows of x, y, z.
SIDE = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
FROM_LEFT = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# Holes that point to the eye or away from it by this sine or less are drawn as their rims alone.
END_ON = 0.05


def draw_oil_holes(view: View, parts: ThrowParts, axes: Array, hidden: bool) -> None:
    """Draw the holes of a throw: walls dashed, rims that are seen in full.

    Parameters
    ----------
    axes : (2, 3) array
        Right and up on paper, `SIDE` or `FROM_LEFT`.
    hidden : bool
        Whether something stands before all journals, so that no rim is seen.
    """
    eye = np.cross(axes[0], axes[1])
    for hole in parts.drillings:
        for outlet in hole.exits:
            rim = _on_paper(hole, outlet.rim, axes)
            seen = not hidden and outlet.direction @ eye > END_ON
            view.stroke(rim, {**(EDGE if seen else HIDDEN), "linewidth": 0.6}, closed=True)
            across = np.cross(hole.frame[2], eye)
            sine = float(np.linalg.norm(across))
            if sine > END_ON:
                for sign in (-1.0, 1.0):
                    p, q = sign * hole.radius * (hole.frame[:2] @ across) / sine
                    view.stroke(_line(outlet, p, q, 0.0, axes), HIDDEN)
                view.stroke(_line(outlet, 0.0, 0.0, BEYOND * view.point, axes), THIN_CENTER)


def dimension_oil_holes(view: View, parts: ThrowParts) -> None:
    """Write what each hole measures beside where it comes out, in the side view."""
    for hole in parts.drillings:
        outlet = max(hole.exits, key=lambda exit_: exit_.point[1])
        place = hole.middle + np.array([0.0, 0.0, outlet.surface(np.zeros(1), np.zeros(1))[0]]) @ (
            hole.frame
        )
        size = f"⌀ {millimeters(2.0 * hole.radius)}, {_signed(outlet.angle_deg)}"
        if hole.tilt:
            size += f", tilt {_signed(math.degrees(hole.tilt * outlet.side))}"
        if hole.exit_radius:
            size += f", $r$ {millimeters(hole.exit_radius)}"
        tip = axes_point(place)
        view.leader(tip, (-10.0 if hole.number % 2 else 10.0, 14.0), view.label(size, "oil_holes"))


def axes_point(place: Array) -> tuple[float, float]:
    """Place (z, y) in the side view."""
    return (float(place[2]), float(place[1]))


def _signed(angle_deg: float) -> str:
    return ("−" if angle_deg < 0.0 else "") + degrees(math.radians(angle_deg))


def _line(outlet: DrillingExit, p: float, q: float, beyond: float, axes: Array) -> Array:
    """A line along the hole from its inner end to the surface, and so far beyond it."""
    across = np.array([[p, q]])
    ends = outlet.inner(*across.T), outlet.surface(*across.T) + outlet.side * beyond
    places = np.array([[p, q, end[0]] for end in ends])
    return _on_paper(outlet.drilling, places, axes)


def _on_paper(hole: Drilling, places: Array, axes: Array) -> Array:
    """Points (n, 2) on paper of places p, q, t (n, 3)."""
    return np.asarray((hole.middle + places @ hole.frame) @ axes.T)


def draw_side(view: View, parts: ThrowParts, dimensions: bool = True) -> None:
    """Draw the side view, with its dimensions unless they are not wanted."""
    for cylinder in parts.cylinders:
        _draw_cylinder(view, cylinder)
    webs = [web for web in parts.webs if web.end > web.start]
    for web in webs:
        _draw_web(view, web)
    for cylinder in parts.cylinders:
        if cylinder.bore_radius > 0.0:
            # A bore ends on the faces of the webs beside its journal.
            x, middle = cylinder.bore_axis
            for y in (middle - cylinder.bore_radius, middle + cylinder.bore_radius):
                start, end = cylinder.bore_start, cylinder.bore_end
                for web in parts.webs:
                    height = float(np.dot(np.subtract((x, y), web.foot), web.direction))
                    if web.start == start:
                        start, _ = faces_at(web, height)
                    if web.end == end:
                        _, end = faces_at(web, height)
                view.stroke([(start, y), (end, y)], HIDDEN)
            if middle != cylinder.axis[1]:
                margin = BEYOND * view.point
                past = (cylinder.bore_start - margin, cylinder.bore_end + margin)
                view.stroke([(past[0], middle), (past[1], middle)], THIN_CENTER)
    draw_oil_holes(view, parts, SIDE, hidden=False)
    for web, (before, after) in zip(parts.webs, pairwise(parts.cylinders), strict=True):
        if web.end == web.start:  # the halves of a split pin meet
            ends = [c.axis[1] + sign * c.radius for c in (before, after) for sign in (-1.0, 1.0)]
            view.stroke([(web.start, min(ends)), (web.start, max(ends))])
    # The axes of shaft and pins, and the middles of the main journals.
    beyond = BEYOND * view.point
    view.stroke([(-beyond, 0.0), (parts.length + beyond, 0.0)], CENTER)
    for pin in parts.pins:
        start, end = pin.bore_start - beyond, pin.bore_end + beyond
        view.stroke([(start, pin.axis[1]), (end, pin.axis[1])], CENTER)
    reach = parts.cylinders[0].radius + beyond
    for z in (0.0, parts.length):
        view.stroke([(z, -reach), (z, reach)], CENTER)
    if len(parts.pins) > 1:
        for pin in parts.pins:
            middle, above = 0.5 * (pin.start + pin.end), pin.axis[1] + 8.0 * view.point
            view.write(name_of(pin), (middle, above, "center"), paper=JOURNAL_COLOR, fontsize=7.0)
    if dimensions:
        _dimension_fillets(view, parts)
        dimension_oil_holes(view, parts)
        _dimension_lengths(view, parts, webs)


def _draw_cylinder(view: View, cylinder: Cylinder) -> None:
    """Draw a journal's silhouette with its fillets."""
    quarter = np.linspace(0.0, 0.5 * math.pi, 19)
    curves = []
    for fillet, web, free in (
        (cylinder.start_fillet, cylinder.start, 1.0),
        (cylinder.end_fillet, cylinder.end, -1.0),
    ):
        z = web + free * fillet * (1.0 - np.cos(quarter))
        curves.append(np.column_stack([z, cylinder.radius + fillet * (1.0 - np.sin(quarter))]))
    upper = np.vstack([curves[0], curves[1][::-1]])
    above, below = (upper * (1.0, side) + np.array([0.0, cylinder.axis[1]]) for side in (1.0, -1.0))
    view.surface(np.vstack([above, below[::-1]]), JOURNAL_COLOR, edge=0.0)
    for edge in (above, below):
        view.stroke(edge, {**OUTLINE, "zorder": 1.0})


def _draw_web(view: View, web: WebPlate) -> None:
    """Draw a web as seen along x: the hull of its corners, its counterweight behind and beside it."""
    if web.sector is not None:
        _draw_weight(view, web.sector, weight_outline(web, web.sector)[:, 1])

    knees = np.array([slope.start for slope in web.slopes])
    half = web.outline.half_width(knees)
    uv = np.vstack([outline_uv(web), np.column_stack([[*half, *-half], [*knees, *knees]])])
    y = place(web, *uv.T)[:, 1]
    corners = np.vstack([np.column_stack([z, y]) for z in web.faces(uv[:, 1])])
    view.surface(corners[ConvexHull(corners).vertices], WEB_COLOR)
    for before, after in pairwise(web.outline.pieces):
        if not (isinstance(before, Line) and isinstance(after, Line)):
            continue
        first, second = np.subtract(before.end, before.start), np.subtract(after.end, after.start)
        sine = abs(first[0] * second[1] - first[1] * second[0])
        if sine > 0.05 * np.linalg.norm(first) * np.linalg.norm(second):  # a visible edge
            u, v = after.start
            _, y_near = at_smaller_x(web, u, v)
            start, end = faces_at(web, v)
            view.stroke([(start, y_near), (end, y_near)], {**EDGE, "zorder": 1.0})

    if web.sector is not None:
        uv = sector_uv(web.sector)
        beside = np.abs(uv[:, 0]) > web.outline.half_width(uv[:, 1]) * (1.0 + 1e-9)
        _draw_weight(view, web.sector, place(web, *uv[beside].T)[:, 1])


def _draw_weight(view: View, sector: Sector, y: Array) -> None:
    """Draw a counterweight, or what of it is seen, as the box over its heights."""
    low, high = y.min(), y.max()
    z = (sector.start, sector.end)
    view.surface([(z[0], low), (z[1], low), (z[1], high), (z[0], high)], WEB_COLOR)


def _dimension_fillets(view: View, parts: ThrowParts) -> None:
    journal, pins = parts.cylinders[0], parts.pins
    one_radius = len({journal.end_fillet, *map(_pin_fillet, pins)}) == 1
    if journal.end_fillet > 0.0:
        name = "$r$" if one_radius else symbol("r", "km")
        tip = _on_fillet(journal, False, 1.0)
        text = f"{name} {millimeters(journal.end_fillet)}"
        field = "fillet_radius" if one_radius else "main_journal_fillet_radius"
        view.leader(tip, (-9.0, 16.0), view.label(text, field))
    for pin, _ in distinct_values(pins, _pin_fillet):
        if _pin_fillet(pin) > 0.0:
            name = "$r$" if one_radius else symbol("r", "shm")
            text = f"{name} {millimeters(_pin_fillet(pin))}"
            field = "fillet_radius" if one_radius else "pin_fillet_radius"
            # Between the webs or, if there is no room, beyond the outer one.
            text = view.label(text, field)
            outward = 1.0 if pin.axis[1] >= 0.0 else -1.0
            room = (pin.end - pin.start) / view.point - 18.0
            if text_size(text)[0] <= room:
                at_start, side = pin.start_fillet > 0.0, -outward
                inward, up = 9.0, -16.0 * outward
            else:
                at_start, side = pin is parts.pins[0] and len(parts.pins) > 1, outward
                web = parts.webs[0 if at_start else -1]
                inward, up = -(web.end - web.start) / view.point - 10.0, 12.0 * outward
            view.leader(
                _on_fillet(pin, at_start, side), (inward if at_start else -inward, up), text
            )


def _pin_fillet(pin: Cylinder) -> float:
    """Radius of a pin's fillets; where it meets the other half of a split pin it has none."""
    return max(pin.start_fillet, pin.end_fillet)


def _on_fillet(cylinder: Cylinder, at_start: bool, side: float) -> Point:
    """Middle (z, y) of a fillet's silhouette above (side 1) or below (-1) its journal."""
    fillet = cylinder.start_fillet if at_start else cylinder.end_fillet
    inset = fillet * (1.0 - math.sqrt(0.5))
    z = cylinder.start + inset if at_start else cylinder.end - inset
    return (z, cylinder.axis[1] + side * (cylinder.radius + inset))


def _dimension_lengths(view: View, parts: ThrowParts, webs: Sequence[WebPlate]) -> None:
    """Dimension all that lies along the shaft, in lanes above and below the throw."""

    def bottom(z: float) -> float:
        """Lower end of the silhouette where one part ends and the next begins."""
        reached = [c.axis[1] - c.radius for c in parts.cylinders if z in (c.start, c.end)]
        for web in webs:
            if z in (web.start, web.end):
                same = web.sector is not None and z in (web.sector.start, web.sector.end)
                reached.append((silhouette(web) if same else outline(web))[:, 1].min())
        return float(min(reached))

    def linear(start: float, end: float, text: str) -> Linear:
        return Linear((start, bottom(start)), (end, bottom(end)), text)

    tips: list[Linear] = []
    feet: list[Linear] = []
    for web in webs:
        for slope in web.slopes:
            v = web.outline.tip if slope.towards > 0.0 else web.outline.foot
            start, end = faces_at(web, v)
            y = float(place(web, 0.0, v)[0, 1])
            upper = slope.towards > 0.0
            text = view.label(
                millimeters(end - start), f"web_{'tip' if upper else 'foot'}_thickness"
            )
            if slope.towards * web.direction[1] > 0.0:
                tips.append(Linear((start, y), (end, y), text))
            else:
                low = [bottom(z) if z in (web.start, web.end) else y for z in (start, end)]
                feet.append(Linear((start, low[0]), (end, low[1]), text))
    view.stack(tips, 0, 1)
    view.stack(feet, 0, -1)
    # Of counterweights above (1) and below (-1), where they are not as thick as their webs.
    weights: dict[int, list[Linear]] = {1: [], -1: []}
    for web in webs:
        sector = web.sector
        if sector is None or (sector.start, sector.end) == (web.start, web.end):
            continue
        side = 1 if web.direction[1] < 0.0 else -1
        rim = weight_outline(web, sector)[:, 1]
        edge = float(rim.max() if side > 0 else rim.min())
        text = view.label(millimeters(sector.end - sector.start), "counterweight.thickness")
        weights[side].append(Linear((sector.start, edge), (sector.end, edge), text))
    for side, dimensions in weights.items():
        view.stack(dimensions, 0, side)

    chain = []
    cylinders = parts.cylinders
    if view.lettered:  # names are longer than values, and one of each is sufficient
        cylinders, webs = cylinders[1:], webs[:1]
    for cylinder in cylinders:
        text = symbol("L", "shm") if cylinder.is_pin else symbol("L", "km") + "/2"
        length = millimeters(cylinder.end - cylinder.start)
        field = "pin_length" if cylinder.is_pin else "main_journal_length / 2"
        chain.append((cylinder.start, cylinder.end, view.label(f"{text} {length}", field)))
    for web in webs:
        text = view.label(f"$h$ {millimeters(web.end - web.start)}", "web_thickness")
        chain.append((web.start, web.end, text))
    view.stack([linear(*dimension) for dimension in sorted(chain)], 0, -1)
    whole = view.label(millimeters(parts.length), "cylinder pitch (follows)")
    view.stack([linear(0.0, parts.length, whole)], 0, -1)


Weight = tuple[WebPlate, Sector, str]
WEIGHT_LANE = 20.0  # from the arc of one counterweight's angle to the next [points]


def dimension_end(view: View, parts: ThrowParts) -> None:
    """Dimension radii, diameters, widths, corners and angles."""
    webs = [web for web in parts.webs if web.end > web.start]
    callouts = _circle_callouts(view, parts)
    reach = max(float(np.hypot(*silhouette(web).T).max()) for web in webs)
    callouts += _dimension_weights(view, webs)
    _dimension_pins(view, parts, reach)
    heights, more = _end_distances(view, parts)
    callouts += more
    # Above (1) and below (-1) the view if the webs stand upright, or beside it.
    widths: dict[int, list[Linear]] = {1: [], -1: []}
    for web, who in distinct_values(webs, lambda w: millimeters(w.outline.width)):
        half = 0.5 * web.outline.width
        text = view.label(f"$B$ {millimeters(web.outline.width)}", "web_width") + who
        if web.direction[0] == 0.0:
            y = float(place(web, 0.0, highest_full_width(web))[0, 1])
            side = 1 if web.direction[1] > 0.0 else -1
            widths[side].append(Linear((-half, y), (half, y), text))
        else:
            callouts.append(_callout(at_smaller_x(web, half, 0.5 * web.distance), text))
    # The radii of round ends are the distances to the ends, which have their names already.
    cornered = [web for web in webs if corner_texts(web) and not (view.lettered and _round(web))]
    for web, who in distinct_values(cornered, lambda w: list(corner_texts(w))):
        for text, (u, v) in corner_texts(web).items():
            field = "web_corner_chamfer" if "×" in text else "web_corner_radius"
            callouts.append(_callout(at_smaller_x(web, u, v), view.label(text, field) + who))
    for side, dimensions in widths.items():
        view.stack(dimensions, 0, side)
    for dimensions in heights:
        view.stack(dimensions, 1, -1)
    view.callouts(callouts)
    view.write_angles()


def _round(web: WebPlate) -> bool:
    """Whether all arcs of a web's outline are about its middle line."""
    arcs = [piece for piece in web.outline.pieces if isinstance(piece, Arc)]
    return bool(arcs) and all(arc.center[0] == 0.0 for arc in arcs)


def _end_distances(view: View, parts: ThrowParts) -> tuple[list[list[Linear]], list[Callout]]:
    """Crank radius, and the end webs' reach beyond both axes: left of the view in two lanes."""
    pin, gap = parts.pins[0], BEYOND * view.point
    start = -parts.cylinders[0].collar - gap
    text = view.label(f"$R$ {millimeters(pin.axis[1])}", "crank_radius")
    lanes: list[list[Linear]] = [[Linear((start, 0.0), (-pin.collar - gap, pin.axis[1]), text)], []]
    callouts = []
    ends = (parts.webs[0], parts.webs[-1])
    for web, who in distinct_values(
        ends, lambda w: [millimeters(end) for end in distances_to_ends(w)]
    ):
        foot, tip = map(
            view.label, map(millimeters, distances_to_ends(web)), ("web_journal_end", "web_pin_end")
        )
        if web.direction[0] != 0.0:
            end = place(web, 0.0, web.outline.tip)[0]
            callouts.append(_callout((end[0], end[1]), f"ends {foot}, {tip}{who}"))
            continue
        sign = web.direction[1]
        for axis, v, text in ((0.0, web.outline.foot, foot), (web.distance, web.outline.tip, tip)):
            stop = (-half_width(web, v), sign * v)
            lane = lanes[0 if web is parts.webs[0] else 1]
            lane.append(Linear((start, sign * axis), stop, text + who))
    return lanes, callouts


def _callout(point: Point, text: str) -> Callout:
    x, y = point
    return Callout((-x, y), 0.0, text, y)


def _circle_callouts(view: View, parts: ThrowParts) -> list[Callout]:
    """Diameters of journals, pins and bores."""
    callouts = []

    def add(center: Point, radius: float, height: float, text: str) -> None:
        callouts.append(Callout((-center[0], center[1]), radius, text, center[1] + height))

    journal = parts.cylinders[0]
    for cylinders, index, part in (
        ([journal], "km", "main_journal"),
        (parts.pins, "shm", "pin"),
    ):
        for cylinder, who in distinct_values(cylinders, lambda c: millimeters(c.radius)):
            text = f"{symbol('D', index)} ⌀{millimeters(2.0 * cylinder.radius)}"
            text = view.label(text, f"{part}_diameter") + who
            add(cylinder.axis, cylinder.radius, 0.6 * cylinder.radius, text)
        bored = [c for c in cylinders if c.bore_radius > 0.0]
        for cylinder, who in distinct_values(bored, _bore_texts):
            text, offset = _bore_texts(cylinder)
            text = view.label(f"{symbol('d', index)} {text}", f"{part}_bore") + who
            text += view.label(offset, f"\n{part}_bore_offset") if offset else ""
            add(cylinder.bore_axis, cylinder.bore_radius, 0.0, text)
    return callouts


def _bore_texts(cylinder: Cylinder) -> tuple[str, str]:
    offset = bore_offset(cylinder)
    return (
        f"⌀{millimeters(2.0 * cylinder.bore_radius)}",
        f"\noffset {millimeters(offset)}" if offset != 0.0 else "",
    )


def _weights(webs: Sequence[WebPlate], value: Callable[[Sector], float]) -> list[Weight]:
    """Return the first web with each value of its counterweight's, its counterweight, who has it."""

    def shown(web: WebPlate) -> str:
        return "" if web.sector is None else f"{value(web.sector):.9f}"

    weighted = [web for web in webs if web.sector is not None and value(web.sector) > 0.0]
    return [(web, web.sector, who) for web, who in distinct_values(weighted, shown) if web.sector]


def _dimension_weights(view: View, webs: Sequence[WebPlate]) -> list[Callout]:
    """Draw the angles of counterweights; return the callouts of their radii."""
    callouts: list[Callout] = []
    radii: tuple[tuple[str, str, float, Callable[[Sector], float]], ...] = (
        (symbol("r", "cw"), "outer", 0.7, lambda sector: sector.outer_radius),
        ("inner $r$", "inner", 0.3, lambda sector: sector.inner_radius),
    )
    for name, edge, share, value in radii:
        for web, sector, who in _weights(webs, value):
            radius, angle = value(sector), share * sector.half_angle
            point = at_smaller_x(web, radius * math.sin(angle), -radius * math.cos(angle))
            text = view.label(f"{name} {millimeters(radius)}", f"counterweight.{edge}_radius")
            callouts.append(_callout(point, text + who))

    points = np.vstack([mirror(silhouette(web)) for web in webs])
    distances = np.hypot(*points.T)
    weights = _weights(webs, lambda sector: sector.half_angle)
    for number, (web, sector, who) in enumerate(weights):
        middle, half = math.atan2(-web.direction[1], web.direction[0]), sector.half_angle
        along = points @ np.array([math.cos(middle), math.sin(middle)])
        reach = float(distances[along >= math.cos(half) * distances * (1.0 - 1e-9)].max())
        radius = reach + (14.0 + WEIGHT_LANE * number) * view.point
        for angle in (middle - half, middle + half):
            ray = np.array([math.cos(angle), math.sin(angle)])
            start = sector.outer_radius + 2.0 * view.point
            view.stroke([start * ray, (radius + 2.5 * view.point) * ray], DIMENSION)
        text = view.label(degrees(2.0 * half), "counterweight.angle") + who
        view.angle((0.0, 0.0), radius, middle - half, middle + half, text)
    return callouts


def _dimension_pins(view: View, parts: ThrowParts, reach: float) -> None:
    """Name several pins and give their angles from the first."""
    if len(parts.pins) == 1:
        return
    weights = len(_weights(parts.webs, lambda sector: sector.half_angle))
    radius = reach + (14.0 + WEIGHT_LANE * weights) * view.point
    first = math.hypot(*parts.pins[0].axis)
    names: list[tuple[float, str]] = []
    for pin in parts.pins:
        x, y = pin.axis
        angle, crank = math.atan2(-x, y), math.hypot(x, y)
        text = name_of(pin)
        if not math.isclose(crank, first):
            text += f", $R$ {millimeters(crank)}"
        if math.isclose(abs(angle), math.pi):
            text += ", 180°"
        elif abs(angle) > 1e-9:
            turned = view.label(degrees(angle), "further_pins.angle")
            view.angle((0.0, 0.0), radius, 0.5 * math.pi, 0.5 * math.pi - angle, turned)
            radius += 18.0 * view.point
        names.append((math.atan2(y, -x), text))
    for angle, text in names:
        ray = np.array([math.cos(angle), math.sin(angle)])
        view.stroke([reach * ray, radius * ray], CENTER)
        view.keep_clear(reach * ray, radius * ray)
        width, height = text_size(text)
        clear = 0.5 * (abs(ray[0]) * width + abs(ray[1]) * height) + 2.0
        places = [radius + (clear + more) * view.point for more in (0.0, 12.0, 24.0, 36.0)]
        view.write(text, *((r * ray[0], r * ray[1], "center") for r in places))


def draw_end(view: View, parts: ThrowParts, dimensions: bool = True) -> None:
    """Draw the parts from the farthest to the nearest, what they hide of each other, dimensions.

    The dimensions are left out if they are not wanted.
    """
    for cylinder, web in reversed(list(zip(parts.cylinders, [None, *parts.webs], strict=True))):
        view.surface(_circle(cylinder.axis, cylinder.radius), JOURNAL_COLOR)
        if web is not None and web.end > web.start:
            shapes = [outline(web)]
            if web.sector is not None:
                shapes.append(weight_outline(web, web.sector))
                if web.sector.start > web.start:  # the web's face is nearer
                    shapes.reverse()
            flush = has_flush_weight(web)
            for shape in shapes:
                view.surface(mirror(shape), WEB_COLOR, edge=0.0 if flush else 1.0)
            for edge in _edges(web) if flush else ():
                view.stroke(edge, {**OUTLINE, "zorder": 1.0})
            for slope in web.slopes:
                if slope.inward > 0.0:
                    view.stroke(_slope_start(web, slope.start), {**EDGE, "zorder": 1.0})
            if cylinder.bore_radius > 0.0:
                view.surface(_circle(cylinder.bore_axis, cylinder.bore_radius), OPEN)
    journal = parts.cylinders[0]
    if journal.bore_radius > 0.0:
        view.surface(_circle(journal.bore_axis, journal.bore_radius), OPEN)
    if journal.end_fillet > 0.0:
        view.stroke(_circle(journal.axis, journal.radius + journal.end_fillet), EDGE)
    _draw_hidden(view, parts)
    draw_oil_holes(view, parts, FROM_LEFT, hidden=True)
    beyond = BEYOND * view.point
    for number, pin in enumerate(parts.pins):
        web = parts.webs[number]
        direction = np.array(pin.axis) / math.hypot(*pin.axis)
        reach = max(pin.collar, web.outline.tip - web.distance)
        _draw_crosshair(view, pin.axis, pin.collar + beyond, direction)
        stop = np.array(pin.axis) + (reach + beyond) * direction
        view.stroke(mirror(np.array([np.zeros(2), stop])), CENTER)
    reach = parts.cylinders[0].collar + beyond
    _draw_crosshair(view, (0.0, 0.0), reach, np.array([0.0, 1.0]))
    if dimensions:
        dimension_end(view, parts)


def _circle(center: Point, radius: float) -> Array:
    return mirror(circle(center, radius))


def _edges(web: WebPlate) -> list[Array]:
    """Edges of a web and its counterweight, cut off where their faces are one."""
    edges = [np.vstack([outline_uv(web), outline_uv(web)[:1]])]
    if web.sector is not None:
        edges.append(sector_uv(web.sector))
    if has_flush_weight(web):
        for number, edge in enumerate(edges):
            # Points at equal steps along the line, so that it can be cut off anywhere.
            steps = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(edge, axis=0).T))])
            places = np.linspace(0.0, steps[-1], 1200)
            edges[number] = np.column_stack([np.interp(places, steps, column) for column in edge.T])
        within = np.abs(edges[1][:, 0]) < web.outline.half_width(edges[1][:, 1]) * (1.0 - 1e-9)
        edges[0][on_weight(web, edges[0])] = np.nan
        edges[1][within] = np.nan
    return [mirror(place(web, *edge.T)) for edge in edges]


def _slope_start(web: WebPlate, v: float) -> Array:
    """The line on a web's face where its slope begins."""
    half = half_width(web, v)
    return mirror(place(web, [-half, half], [v, v]))


def _draw_hidden(view: View, parts: ThrowParts) -> None:
    """Draw dashed what lies behind, but no line twice and none that is seen in front."""
    # In front: the first journal, the first web, and the bores that open towards the left end.
    journal, first = parts.cylinders[0], parts.webs[0]
    drawn = [_circle(journal.axis, journal.radius)]
    drawn += [_circle(c.bore_axis, c.bore_radius) for c in parts.cylinders[:2] if c.bore_radius]
    if first.sector is None or has_flush_weight(first):
        drawn += _edges(first)
    drawn += [_slope_start(first, slope.start) for slope in first.slopes if slope.inward > 0.0]

    lines = [_circle(pin.axis, pin.radius) for pin in parts.pins]
    lines += [_circle(c.bore_axis, c.bore_radius) for c in parts.cylinders if c.bore_radius]
    for web in parts.webs:
        if web.end == web.start:
            continue
        lines += _edges(web)
        if web.sector is not None and web.sector.inner_radius > 0.0:
            inner = sector_arc(web.sector, web.sector.inner_radius)
            lines.append(mirror(place(web, *inner.T)))
        lines += [_slope_start(web, slope.start) for slope in web.slopes]
    for line in lines:
        if not any(
            line.shape == other.shape and np.allclose(line, other, equal_nan=True)
            for other in drawn
        ):
            drawn.append(line)
            view.stroke(line, HIDDEN)
    for pin in parts.pins:
        if pin.collar > pin.radius:
            view.stroke(_circle(pin.axis, pin.collar), {**HIDDEN, "linewidth": 0.4})
    for cylinder in parts.cylinders:
        if cylinder.bore_radius > 0.0 and bore_offset(cylinder) != 0.0:
            x, y = cylinder.bore_axis
            reach = cylinder.bore_radius + 4.0 * view.point
            view.stroke(mirror([(x - reach, y), (x + reach, y)]), THIN_CENTER)


def _draw_crosshair(view: View, center: Point, reach: float, direction: Array) -> None:
    across = np.array([direction[1], -direction[0]])
    for way in (direction, across):
        view.stroke(mirror(center + np.outer([-reach, reach], way)), CENTER)
