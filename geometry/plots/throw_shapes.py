"""Shapes of a throw's parts as a drawing needs them: points, edges and widths of webs, in meters."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.outline import Arc
from geometry.parts import Cylinder, Sector, WebPlate

Array = NDArray[np.float64]
Point = tuple[float, float]
Coordinates = float | Sequence[float] | Array


def place(web: WebPlate, u: Coordinates, v: Coordinates) -> Array:
    """Points (n, 2), x and y, of a web's coordinates u and v."""
    x, y = web.direction
    coordinates = np.column_stack(np.broadcast_arrays(u, v))
    return np.asarray(web.foot + coordinates @ np.array([(y, -x), (x, y)]))


def at_smaller_x(web: WebPlate, u: float, v: float) -> Point:
    """The one of the points (u, v) and (-u, v) that is near in the side view, right in the other."""
    x, y = min(place(web, [u, -u], [v, v]).tolist())
    return (x, y)


def outline_uv(web: WebPlate) -> Array:
    """Whole outline of a web in its coordinates u and v."""
    half = web.outline.polygon(48)
    return np.vstack([half, half[::-1] * (-1.0, 1.0)])


def sector_arc(sector: Sector, radius: float) -> Array:
    """Arc of a counterweight at a radius, in its web's coordinates u and v."""
    angles = np.linspace(-sector.half_angle, sector.half_angle, 97)
    return radius * np.column_stack([np.sin(angles), -np.cos(angles)])


def sector_uv(sector: Sector) -> Array:
    """Outline of a counterweight in its web's coordinates u and v."""
    inner, outer = (sector_arc(sector, r) for r in (sector.inner_radius, sector.outer_radius))
    sides = [np.linspace(inner[k], outer[k], 60) for k in (0, -1)]
    return np.vstack([sides[0], outer, sides[1][::-1], inner[::-1]])


def outline(web: WebPlate) -> Array:
    """Whole outline of a web, (n, 2) in x and y."""
    return place(web, *outline_uv(web).T)


def weight_outline(web: WebPlate, sector: Sector) -> Array:
    """Outline of a web's counterweight, (n, 2) in x and y."""
    return place(web, *sector_uv(sector).T)


def silhouette(web: WebPlate) -> Array:
    """Outline of a web with its counterweight, their points together, (n, 2) in x and y."""
    if web.sector is None:
        return outline(web)
    return np.vstack([outline(web), weight_outline(web, web.sector)])


def faces_at(web: WebPlate, v: float) -> Point:
    """Where along z a web starts and ends at one height v."""
    start, end = web.faces(np.array([v]))
    return float(start[0]), float(end[0])


def half_width(web: WebPlate, v: float) -> float:
    """Half of a web's width at one height v."""
    return float(web.outline.half_width(np.array([v]))[0])


def highest_full_width(web: WebPlate) -> float:
    """Height v, nearest to the tip, where a web has its full width."""
    centers = [p.center[1] for p in web.outline.pieces if isinstance(p, Arc)]
    within = [v for v in centers if web.outline.foot < v < web.outline.tip]
    heights = np.unique([*web.outline.heights, *within])
    widths = web.outline.half_width(heights)
    return float(heights[widths >= widths.max() * (1.0 - 1e-9)].max())


def distances_to_ends(web: WebPlate) -> Point:
    """Distances of a web's ends from the axes that it joins, the foot's first."""
    return (-web.outline.foot, web.outline.tip - web.distance)


def on_weight(web: WebPlate, points: Array) -> NDArray[np.bool_]:
    """Which points (u, v) of a web lie on its counterweight."""
    if web.sector is None:
        return np.zeros(len(points), dtype=bool)
    angle = np.arctan2(np.abs(points[:, 0]), -points[:, 1])
    reach = np.hypot(*points.T)
    return np.asarray((angle < web.sector.half_angle) & (reach > web.sector.inner_radius))


def has_flush_weight(web: WebPlate) -> bool:
    """Whether a web and its counterweight have one face towards the left end."""
    return web.sector is not None and web.sector.start == web.start


def bore_offset(cylinder: Cylinder) -> float:
    """How far a bore lies off its journal's axis, positive away from the shaft or to the first pin."""
    direction = cylinder.axis if cylinder.is_pin else (0.0, 1.0)
    off = np.subtract(cylinder.bore_axis, cylinder.axis)
    return round(float(off @ direction) / math.hypot(*direction), 12)


def circle(center: Point, radius: float) -> Array:
    """Points of a circle, (n, 2) in x and y."""
    angles = np.linspace(0.0, 2.0 * math.pi, 121)
    return np.array(center) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def mirror(points: ArrayLike) -> Array:
    """Points as seen from the left end, where x points to the left."""
    return np.asarray(points, dtype=float) * (-1.0, 1.0)
