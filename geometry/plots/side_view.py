"""The side view of a throw's drawing, over z and y."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

from geometry.outline import Line
from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate
from geometry.plots.dimension_lines import (
    BEYOND,
    CENTER,
    EDGE,
    HIDDEN,
    JOURNAL_COLOR,
    OUTLINE,
    THIN_CENTER,
    WEB_COLOR,
    Linear,
    View,
    text_size,
)
from geometry.plots.dimension_texts import distinct_values, millimeters, name_of, symbol
from geometry.plots.oil_holes import SIDE, dimension_oil_holes, draw_oil_holes
from geometry.plots.throw_shapes import (
    Array,
    Point,
    at_smaller_x,
    faces_at,
    outline,
    outline_uv,
    place,
    sector_uv,
    silhouette,
    weight_outline,
)


def draw_side(view: View, parts: ThrowParts, dimensions: bool = True) -> None:
    """Draw the side view, with its dimensions unless they are not wanted."""
    for cylinder in parts.cylinders:
        _draw_cylinder(view, cylinder)
    webs = [web for web in parts.webs if web.end > web.start]
    for web in webs:
        _draw_web(view, web)
    for cylinder in parts.cylinders:
        if cylinder.bore_radius > 0.0:
            _draw_bore(view, parts, cylinder)
    draw_oil_holes(view, parts, SIDE, hidden=False)
    for web, (before, after) in zip(parts.webs, pairwise(parts.cylinders), strict=True):
        if web.end == web.start:  # the halves of a split pin meet
            ends = [c.axis[1] + sign * c.radius for c in (before, after) for sign in (-1.0, 1.0)]
            view.stroke([(web.start, min(ends)), (web.start, max(ends))])
    _draw_center_lines(view, parts)
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
        if isinstance(before, Line) and isinstance(after, Line) and _is_visible_edge(before, after):
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


def _is_visible_edge(before: Line, after: Line) -> bool:
    """Whether two straight pieces of an outline meet in a visible edge."""
    first, second = np.subtract(before.end, before.start), np.subtract(after.end, after.start)
    sine = abs(first[0] * second[1] - first[1] * second[0])
    return bool(sine > 0.05 * np.linalg.norm(first) * np.linalg.norm(second))


def _draw_bore(view: View, parts: ThrowParts, cylinder: Cylinder) -> None:
    """Draw a bore, which ends on the faces of the webs beside its journal."""
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
        beyond = BEYOND * view.point
        ends = (cylinder.bore_start - beyond, cylinder.bore_end + beyond)
        view.stroke([(ends[0], middle), (ends[1], middle)], THIN_CENTER)


def _draw_center_lines(view: View, parts: ThrowParts) -> None:
    """Draw the axes of shaft and pins, and the middles of the main journals."""
    beyond = BEYOND * view.point
    view.stroke([(-beyond, 0.0), (parts.length + beyond, 0.0)], CENTER)
    for pin in parts.pins:
        start, end = pin.bore_start - beyond, pin.bore_end + beyond
        view.stroke([(start, pin.axis[1]), (end, pin.axis[1])], CENTER)
    reach = parts.cylinders[0].radius + beyond
    for z in (0.0, parts.length):
        view.stroke([(z, -reach), (z, reach)], CENTER)


def _dimension_fillets(view: View, parts: ThrowParts) -> None:
    journal, pins = parts.cylinders[0], parts.pins
    one_radius = len({journal.end_fillet, *map(_pin_fillet, pins)}) == 1
    if journal.end_fillet > 0.0:
        name = "$r$" if one_radius else symbol("r", "km")
        tip = _on_fillet(journal, False, 1.0)
        view.leader(tip, (-9.0, 16.0), f"{name} {millimeters(journal.end_fillet)}")
    for pin, _ in distinct_values(pins, _pin_fillet):
        if _pin_fillet(pin) > 0.0:
            name = "$r$" if one_radius else symbol("r", "shm")
            _dimension_pin_fillet(view, parts, pin, f"{name} {millimeters(_pin_fillet(pin))}")


def _pin_fillet(pin: Cylinder) -> float:
    """Radius of a pin's fillets; where it meets the other half of a split pin it has none."""
    return max(pin.start_fillet, pin.end_fillet)


def _dimension_pin_fillet(view: View, parts: ThrowParts, pin: Cylinder, text: str) -> None:
    """Write a pin's fillet radius between the webs or, if there is no room, beyond the outer one."""
    outward = 1.0 if pin.axis[1] >= 0.0 else -1.0
    room = (pin.end - pin.start) / view.point - 18.0
    if text_size(text)[0] <= room:
        at_start, side = pin.start_fillet > 0.0, -outward
        inward, up = 9.0, -16.0 * outward
    else:
        at_start, side = pin is parts.pins[0] and len(parts.pins) > 1, outward
        web = parts.webs[0 if at_start else -1]
        inward, up = -(web.end - web.start) / view.point - 10.0, 12.0 * outward
    view.leader(_on_fillet(pin, at_start, side), (inward if at_start else -inward, up), text)


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
            text = millimeters(end - start)
            if slope.towards * web.direction[1] > 0.0:
                tips.append(Linear((start, y), (end, y), text))
            else:
                low = [bottom(z) if z in (web.start, web.end) else y for z in (start, end)]
                feet.append(Linear((start, low[0]), (end, low[1]), text))
    view.stack(tips, 0, 1)
    view.stack(feet, 0, -1)
    for side in (1, -1):
        view.stack([one for web in webs for one in _weight_thickness(web, side)], 0, side)

    chain = []
    for cylinder in parts.cylinders:
        text = symbol("L", "shm") if cylinder.is_pin else symbol("L", "km") + "/2"
        length = millimeters(cylinder.end - cylinder.start)
        chain.append((cylinder.start, cylinder.end, f"{text} {length}"))
    chain += [(web.start, web.end, f"$h$ {millimeters(web.end - web.start)}") for web in webs]
    view.stack([linear(*one) for one in sorted(chain)], 0, -1)
    view.stack([linear(0.0, parts.length, millimeters(parts.length))], 0, -1)


def _weight_thickness(web: WebPlate, side: int) -> list[Linear]:
    """Thickness of a counterweight above (side 1) or below (-1), where it is not the web's."""
    sector = web.sector
    pointing = 1 if web.direction[1] < 0.0 else -1
    if sector is None or pointing != side or (sector.start, sector.end) == (web.start, web.end):
        return []
    y = weight_outline(web, sector)[:, 1]
    edge = float(y.max() if side > 0 else y.min())
    text = millimeters(sector.end - sector.start)
    return [Linear((sector.start, edge), (sector.end, edge), text)]
