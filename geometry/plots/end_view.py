"""The view of a throw from its left end, over -x and y."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate
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
    View,
    text_size,
)
from geometry.plots.dimension_texts import (
    corner_texts,
    degrees,
    distinct_values,
    millimeters,
    name_of,
    symbol,
)
from geometry.plots.oil_holes import FROM_LEFT, draw_oil_holes
from geometry.plots.throw_shapes import (
    Array,
    Point,
    at_smaller_x,
    bore_offset,
    circle,
    distances_to_ends,
    half_width,
    has_flush_weight,
    highest_full_width,
    mirror,
    on_weight,
    outline,
    outline_uv,
    place,
    sector_arc,
    sector_uv,
    silhouette,
    weight_outline,
)

Weight = tuple[WebPlate, Sector, str]
WEIGHT_LANE = 20.0  # from the arc of one counterweight's angle to the next [points]


def dimension_end(view: View, parts: ThrowParts) -> None:
    """Dimension radii, diameters, widths, corners and angles."""
    webs = [web for web in parts.webs if web.end > web.start]
    callouts = _circle_callouts(parts)
    reach = max(float(np.hypot(*silhouette(web).T).max()) for web in webs)
    callouts += _dimension_weights(view, webs)
    _dimension_pins(view, parts, reach)
    heights, more = _end_distances(view, parts)
    callouts += more
    widths, more = _widths(webs)
    callouts += more
    cornered = [web for web in webs if corner_texts(web)]
    for web, who in distinct_values(cornered, lambda w: list(corner_texts(w))):
        for text, (u, v) in corner_texts(web).items():
            callouts.append(_callout(at_smaller_x(web, u, v), text + who))
    for side, dimensions in widths.items():
        view.stack(dimensions, 0, side)
    for dimensions in heights:
        view.stack(dimensions, 1, -1)
    view.callouts(callouts)
    view.write_angles()


def _end_distances(view: View, parts: ThrowParts) -> tuple[list[list[Linear]], list[Callout]]:
    """Crank radius, and the end webs' reach beyond both axes: left of the view in two lanes."""
    pin, gap = parts.pins[0], BEYOND * view.point
    start = -parts.cylinders[0].collar - gap
    text = f"$R$ {millimeters(pin.axis[1])}"
    lanes: list[list[Linear]] = [[Linear((start, 0.0), (-pin.collar - gap, pin.axis[1]), text)], []]
    callouts = []
    ends = (parts.webs[0], parts.webs[-1])
    for web, who in distinct_values(
        ends, lambda w: [millimeters(end) for end in distances_to_ends(w)]
    ):
        foot, tip = (millimeters(end) for end in distances_to_ends(web))
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


def _widths(webs: Sequence[WebPlate]) -> tuple[dict[int, list[Linear]], list[Callout]]:
    """Widths of the webs: above (1) and below (-1) the view if they stand upright, or beside it."""
    across: dict[int, list[Linear]] = {1: [], -1: []}
    callouts = []
    for web, who in distinct_values(webs, lambda w: millimeters(w.outline.width)):
        half = 0.5 * web.outline.width
        text = f"$B$ {millimeters(web.outline.width)}{who}"
        if web.direction[0] == 0.0:
            y = float(place(web, 0.0, highest_full_width(web))[0, 1])
            side = 1 if web.direction[1] > 0.0 else -1
            across[side].append(Linear((-half, y), (half, y), text))
        else:
            callouts.append(_callout(at_smaller_x(web, half, 0.5 * web.distance), text))
    return across, callouts


def _callout(point: Point, text: str) -> Callout:
    x, y = point
    return Callout((-x, y), 0.0, text, y)


def _circle_callouts(parts: ThrowParts) -> list[Callout]:
    """Diameters of journals, pins and bores."""
    found = []

    def add(center: Point, radius: float, height: float, text: str) -> None:
        found.append(Callout((-center[0], center[1]), radius, text, center[1] + height))

    journal = parts.cylinders[0]
    for cylinders, index in (([journal], "km"), (parts.pins, "shm")):
        for one, who in distinct_values(cylinders, lambda c: millimeters(c.radius)):
            text = f"{symbol('D', index)} ⌀{millimeters(2.0 * one.radius)}{who}"
            add(one.axis, one.radius, 0.6 * one.radius, text)
        bored = [c for c in cylinders if c.bore_radius > 0.0]
        for one, who in distinct_values(bored, _bore_texts):
            text, offset = _bore_texts(one)
            add(one.bore_axis, one.bore_radius, 0.0, f"{symbol('d', index)} {text}{who}{offset}")
    return found


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
    radii: tuple[tuple[str, float, Callable[[Sector], float]], ...] = (
        (symbol("r", "cw"), 0.7, lambda sector: sector.outer_radius),
        ("inner $r$", 0.3, lambda sector: sector.inner_radius),
    )
    for text, share, value in radii:
        for web, sector, who in _weights(webs, value):
            radius, angle = value(sector), share * sector.half_angle
            point = at_smaller_x(web, radius * math.sin(angle), -radius * math.cos(angle))
            callouts.append(_callout(point, f"{text} {millimeters(radius)}{who}"))

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
        text = f"{degrees(2.0 * half)}{who}"
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
            view.angle((0.0, 0.0), radius, 0.5 * math.pi, 0.5 * math.pi - angle, degrees(angle))
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
            _draw_web(view, web)
            if cylinder.bore_radius > 0.0:
                view.surface(_circle(cylinder.bore_axis, cylinder.bore_radius), OPEN)
    journal = parts.cylinders[0]
    if journal.bore_radius > 0.0:
        view.surface(_circle(journal.bore_axis, journal.bore_radius), OPEN)
    if journal.end_fillet > 0.0:
        view.stroke(_circle(journal.axis, journal.radius + journal.end_fillet), EDGE)
    _draw_hidden(view, parts)
    draw_oil_holes(view, parts, FROM_LEFT, hidden=True)
    _draw_center_lines(view, parts)
    if dimensions:
        dimension_end(view, parts)


def _circle(center: Point, radius: float) -> Array:
    return mirror(circle(center, radius))


def _draw_web(view: View, web: WebPlate) -> None:
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


def _edges(web: WebPlate) -> list[Array]:
    """Edges of a web and its counterweight, cut off where their faces are one."""
    edges = [np.vstack([outline_uv(web), outline_uv(web)[:1]])]
    if web.sector is not None:
        edges.append(sector_uv(web.sector))
    if has_flush_weight(web):
        edges = [_resampled_line(edge) for edge in edges]
        within = np.abs(edges[1][:, 0]) < web.outline.half_width(edges[1][:, 1]) * (1.0 - 1e-9)
        edges[0][on_weight(web, edges[0])] = np.nan
        edges[1][within] = np.nan
    return [mirror(place(web, *edge.T)) for edge in edges]


def _resampled_line(points: Array, count: int = 1200) -> Array:
    """Points at equal steps along a line, so that it can be cut off anywhere."""
    steps = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.linspace(0.0, steps[-1], count)
    return np.column_stack([np.interp(places, steps, column) for column in points.T])


def _slope_start(web: WebPlate, v: float) -> Array:
    """The line on a web's face where its slope begins."""
    half = half_width(web, v)
    return mirror(place(web, [-half, half], [v, v]))


def _draw_hidden(view: View, parts: ThrowParts) -> None:
    """Draw dashed what lies behind, but no line twice and none that is seen in front."""
    drawn = _lines_in_front(parts)
    for line in _lines_behind(parts):
        if not any(_same(line, other) for other in drawn):
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


def _lines_in_front(parts: ThrowParts) -> list[Array]:
    """Lines of the first journal, the first web, and the bores that open towards the left end."""
    journal, web = parts.cylinders[0], parts.webs[0]
    lines = [_circle(journal.axis, journal.radius)]
    lines += [_circle(c.bore_axis, c.bore_radius) for c in parts.cylinders[:2] if c.bore_radius]
    if web.sector is None or has_flush_weight(web):
        lines += _edges(web)
    return lines + [_slope_start(web, slope.start) for slope in web.slopes if slope.inward > 0.0]


def _lines_behind(parts: ThrowParts) -> list[Array]:
    """All lines, hidden or not."""
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
    return lines


def _same(one: Array, other: Array) -> bool:
    return one.shape == other.shape and np.allclose(one, other, equal_nan=True)


def _draw_center_lines(view: View, parts: ThrowParts) -> None:
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


def _draw_crosshair(view: View, center: Point, reach: float, direction: Array) -> None:
    across = np.array([direction[1], -direction[0]])
    for way in (direction, across):
        view.stroke(mirror(center + np.outer([-reach, reach], way)), CENTER)
