"""The dimensions in the view of a throw from its left end."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate
from geometry.plots.dimension_lines import (
    BEYOND,
    CENTER,
    DIMENSION,
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
from geometry.plots.throw_shapes import (
    Point,
    at_smaller_x,
    bore_offset,
    distances_to_ends,
    half_width,
    highest_full_width,
    mirror,
    place,
    silhouette,
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
    lanes: list[list[Linear]] = [
        [Linear((start, 0.0), (-pin.collar - gap, pin.axis[1]), text)],
        [],
    ]
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
        for axis, v, text in (
            (0.0, web.outline.foot, foot),
            (web.distance, web.outline.tip, tip),
        ):
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
