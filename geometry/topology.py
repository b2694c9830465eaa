"""The topology of a throw's surface, by its parts: which of its surfaces meet, and in what order.

A mesh can be moved from one throw to another only if both have the same faces, edges and corners. These
follow from the order, in each face of a web, of what stands or opens there and of the web's own edges: the
circles of journals, fillets and bores, the lines where slopes start, the counterweight and the pieces of the
outline.
"""

import math
from collections.abc import Iterator

import numpy as np

from geometry.boundary_motion import bounding_surfaces
from geometry.parts import Arc, Cylinder, Line, Point, Sector, WebPlate
from geometry.throw import CrankThrow

# Lengths that differ by less than this share of the throw's length coincide.
COINCIDENT = 1e-7
Circle = tuple[float, float]  # height of its center, and its radius


def topology(throw: CrankThrow) -> str:
    """Return a description of a throw's topology: throws with the same one have the same faces and edges."""
    parts = throw.parts
    least = COINCIDENT * parts.length
    order: list[object] = [
        (hole.journal, hole.through, hole.crosses_bore, hole.exit_radius > 0.0)
        for hole in parts.drillings
    ]
    for web, *beside in zip(parts.webs, parts.cylinders, parts.cylinders[1:], strict=False):
        if web.end <= web.start:
            order.append(_intervals(_circles(web, beside, web.start, least), least))
            continue
        for face in (web.start, web.end):
            circles = _circles(web, beside, face, least)
            order.append(_intervals(circles, least))
            order += [_with_outline(web, circle, least) for circle in circles.values()]
        heights = [piece.end[1] for piece in web.outline.pieces]
        for slope in web.slopes:
            circles = _circles(web, beside, slope.face, least)
            order += [
                _signs(heights, slope.start, least),
                _across(web, circles, slope.start, least),
            ]
        if web.sector:
            order += _with_sector(web, web.sector, beside, least)
    return repr((throw.symmetry, tuple(bounding_surfaces(parts, throw.symmetry)), order))


def _across(web: WebPlate, circles: dict[str, Circle], height: float, least: float) -> list[object]:
    """In which order a line across a web, at a height, meets circles, its outline and its counterweight."""
    lengths = {"outline": float(web.outline.half_width(np.array([height]))[0])}
    if web.sector:
        ring = {"outer": web.sector.outer_radius, "inner": web.sector.inner_radius}
        circles = circles | {name: (0.0, radius) for name, radius in ring.items()}
        lengths["edge"] = -height * math.tan(web.sector.half_angle)
    for name, (center, radius) in circles.items():
        lengths[name] = math.sqrt(max(radius**2 - (height - center) ** 2, 0.0))
    met = sorted((length, name) for name, length in lengths.items() if length > least)
    return [name for _, name in met]


def _circles(web: WebPlate, beside: list[Cylinder], face: float, least: float) -> dict[str, Circle]:
    """Circles in a web's face, by name: of journals, of the feet of their fillets, of bores."""
    (a, b), (x_0, y_0) = web.direction, web.foot

    def height(axis: Point) -> float:
        return (axis[0] - x_0) * a + (axis[1] - y_0) * b

    circles = {}
    for cylinder in beside:
        for end, fillet in (
            (cylinder.start, cylinder.start_fillet),
            (cylinder.end, cylinder.end_fillet),
        ):
            if abs(end - face) < least:
                circles[cylinder.name] = height(cylinder.axis), cylinder.radius
                if fillet:
                    foot = height(cylinder.axis), cylinder.radius + fillet
                    circles[f"fillet of {cylinder.name}"] = foot
        if cylinder.bore_radius and (
            cylinder.bore_start - least <= face <= cylinder.bore_end + least
        ):
            circles[f"bore of {cylinder.name}"] = height(cylinder.bore_axis), cylinder.bore_radius
    return circles


def _low(circle: Circle) -> float:
    return circle[0] - circle[1]


def _high(circle: Circle) -> float:
    return circle[0] + circle[1]


def _sign(difference: float, least: float) -> int:
    return 0 if abs(difference) <= least else int(math.copysign(1, difference))


def _signs(values: "tuple[float, ...] | list[float]", other: float, least: float) -> list[int]:
    return [_sign(value - other, least) for value in values]


def _intervals(circles: dict[str, Circle], least: float) -> list[object]:
    """How circles, whose centers stand on one line, lie to each other."""
    names = list(circles)
    return [
        (
            name,
            other,
            _signs((_low(circles[name]), _high(circles[name])), _low(circles[other]), least),
            _signs((_low(circles[name]), _high(circles[name])), _high(circles[other]), least),
        )
        for place, name in enumerate(names)
        for other in names[:place]
    ] + [*names]


def _with_outline(web: WebPlate, circle: Circle, least: float) -> list[object]:
    """How a circle lies to the pieces of a web's outline."""
    outline = web.outline
    ends = _sign(_low(circle) - outline.foot, least), _sign(_high(circle) - outline.tip, least)
    return [ends, *(_crossed(piece, circle, least) for piece in outline.pieces)]


def _crossed(piece: Line | Arc, circle: Circle, least: float) -> int:
    """How often a circle about (0, height) crosses a piece of an outline, both ends left out."""
    height, radius = circle
    points = []
    if isinstance(piece, Line):
        (u, v), (du, dv) = (
            piece.start,
            (piece.end[0] - piece.start[0], piece.end[1] - piece.start[1]),
        )
        size = math.hypot(du, dv)
        along = -(u * du + (v - height) * dv) / size
        off = (u * dv - (v - height) * du) / size
        if abs(off) < radius - least:
            half = math.sqrt(radius**2 - off**2)
            points = [
                (u + share * du, v + share * dv)
                for share in ((along - half) / size, (along + half) / size)
                if 0.0 < share < 1.0
            ]
    else:
        u, v = piece.center
        apart = math.hypot(u, v - height)
        if abs(piece.radius - radius) + least < apart < piece.radius + radius - least:
            along = (apart**2 + radius**2 - piece.radius**2) / (2.0 * apart)
            half = math.sqrt(max(radius**2 - along**2, 0.0))
            eu, ev = u / apart, (v - height) / apart
            points = [
                (along * eu - side * half * ev, height + along * ev + side * half * eu)
                for side in (1.0, -1.0)
            ]
            points = [p for p in points if piece.distance(p) < least]
    return sum(
        p[0] > least and min(math.dist(p, piece.start), math.dist(p, piece.end)) > least
        for p in points
    )


def _with_sector(
    web: WebPlate, sector: Sector, beside: list[Cylinder], least: float
) -> Iterator[object]:
    """How a counterweight lies to its web, to what stands on it, and to the bores through both."""
    for place in (sector.start, sector.end):
        yield _signs((web.start, web.end), place, least)
        yield [
            _sign((place - slope.face) * slope.inward - slope.drop, least) for slope in web.slopes
        ]
    sine, cosine = math.sin(sector.half_angle), math.cos(sector.half_angle)
    ray = Line(
        (sector.inner_radius * sine, -sector.inner_radius * cosine),
        (sector.outer_radius * sine, -sector.outer_radius * cosine),
    )
    for radius in (sector.inner_radius, sector.outer_radius):
        yield _with_outline(web, (0.0, radius), least)
    # Where a slope comes out of the counterweight's face.
    for slope in web.slopes:
        for face in (sector.start, sector.end):
            depth = (face - slope.face) * slope.inward / slope.drop
            if 0.0 < depth < 1.0:
                height = slope.start + depth * (slope.end - slope.start)
                joints = [piece.end[1] for piece in web.outline.pieces]
                yield _signs(joints, height, least)
                yield _across(web, _circles(web, beside, slope.face, least), height, least)
    yield [_cut(ray, piece) for piece in web.outline.pieces]
    highest = max(0.0, -sector.outer_radius * cosine)
    for face in (web.start, web.end, sector.start, sector.end):
        for circle in _circles(web, beside, face, least).values():
            if _low(circle) > highest + least:
                continue
            yield _crossed(ray, circle, least)
            for radius in (sector.inner_radius, sector.outer_radius):
                if radius:
                    yield _intervals({"ring": (0.0, radius), "circle": circle}, least)


def _cut(ray: Line, piece: Line | Arc) -> int:
    """How often a ray crosses a piece of an outline: by the side of the ray on which it starts and ends."""

    def side(point: Point) -> float:
        (u, v), (u_1, v_1) = ray.start, ray.end
        return (point[0] - u) * (v_1 - v) - (point[1] - v) * (u_1 - u)

    first, last = side(piece.start), side(piece.end)
    if first * last >= 0.0:
        return 0
    if isinstance(piece, Line):
        share = first / (first - last)
        reach = math.hypot(
            piece.start[0] + share * (piece.end[0] - piece.start[0]),
            piece.start[1] + share * (piece.end[1] - piece.start[1]),
        )
    else:
        # The farther crossing of the ray with the arc's circle.
        du, dv = ray.end[0] - ray.start[0], ray.end[1] - ray.start[1]
        size = math.hypot(du, dv)
        du, dv = du / size, dv / size
        along = piece.center[0] * du + piece.center[1] * dv
        off = piece.center[0] * dv - piece.center[1] * du
        reach = along + math.sqrt(max(piece.radius**2 - off**2, 0.0))
    return int(math.hypot(*ray.start) < reach < math.hypot(*ray.end))
