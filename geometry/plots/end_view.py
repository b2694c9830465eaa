"""The view of a throw from its left end, over -x and y."""

import math

import numpy as np

from geometry.parts import ThrowParts, WebPlate
from geometry.plots.dimension_lines import (
    BEYOND,
    CENTER,
    EDGE,
    HIDDEN,
    JOURNAL_COLOR,
    OPEN,
    OUTLINE,
    THIN_CENTER,
    WEB_COLOR,
    View,
)
from geometry.plots.end_dimensions import dimension_end
from geometry.plots.oil_holes import FROM_LEFT, draw_oil_holes
from geometry.plots.throw_shapes import (
    Array,
    Point,
    bore_offset,
    circle,
    half_width,
    has_flush_weight,
    mirror,
    on_weight,
    outline,
    outline_uv,
    place,
    sector_arc,
    sector_uv,
    weight_outline,
)


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
