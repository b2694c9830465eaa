"""Volume of a throw from its parts, without any kernel: the check that the solid is what was meant."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate

Array = NDArray[np.float64]
GAUSS_POINTS = 40


def throw_volume(parts: ThrowParts) -> float:
    """Volume of a throw [m^3]: journals, fillets and webs with counterweights, less the bores.

    Parameters
    ----------
    parts : ThrowParts
    """
    volume = 0.0
    for cylinder in parts.cylinders:
        area = math.pi * (cylinder.radius**2 - cylinder.bore_radius**2)
        volume += area * (cylinder.end - cylinder.start)
        for fillet in (cylinder.start_fillet, cylinder.end_fillet):
            volume += fillet_volume(cylinder.radius, fillet)
    for web, before, after in zip(parts.webs, parts.cylinders, parts.cylinders[1:], strict=False):
        if web.end > web.start:
            volume += _web_volume(web) - _bored(web, before) - _bored(web, after)
    return volume


def fillet_volume(journal_radius: float, fillet_radius: float) -> float:
    """Volume between a cylinder, a flat web face and the fillet that joins them (Pappus) [m^3]."""
    area = fillet_radius**2 * (1.0 - math.pi / 4.0)
    # First moment of the square r x r less its quarter circle, about the journal's surface.
    square = fillet_radius**2 * 0.5 * fillet_radius
    quarter = math.pi / 4.0 * fillet_radius**2 * (1.0 - 4.0 / (3.0 * math.pi)) * fillet_radius
    return 2.0 * math.pi * (journal_radius * area + square - quarter)


def web_thickness(web: WebPlate, v: Array) -> Array:
    """Thickness of a web at heights v from its foot [m]."""
    thickness = np.full_like(v, web.end - web.start)
    for slope in web.slopes:
        thickness -= slope.depth(v)
    return thickness


def _web_volume(web: WebPlate) -> float:
    heights = [*web.outline.heights, *(slope.start for slope in web.slopes)]
    volume = _integral(
        lambda v: 2.0 * web.outline.half_width(v) * web_thickness(web, v), np.array(heights)
    )
    if web.sector is not None:
        volume += _sector_volume(web, web.sector)
    return volume


def _sector_volume(web: WebPlate, sector: Sector) -> float:
    """Volume of a counterweight outside its web [m^3]."""
    cosine, tangent = math.cos(sector.half_angle), math.tan(sector.half_angle)
    radii = (sector.outer_radius, sector.inner_radius)
    heights = [
        *(-r for r in radii),
        *(-r * cosine for r in radii),
        *(v for v in web.outline.heights if -sector.outer_radius < v < 0.0),
        *(s.start for s in web.slopes if -sector.outer_radius < s.start < 0.0),
        0.0,
    ]

    def area(v: Array) -> Array:
        low = np.sqrt(np.maximum(sector.inner_radius**2 - v**2, 0.0))
        high = np.sqrt(np.maximum(sector.outer_radius**2 - v**2, 0.0))
        if sector.half_angle < 0.5 * math.pi - 1e-12:
            high = np.minimum(high, -v * tangent)
        width = web.outline.half_width(v)
        outside = np.maximum(high - np.maximum(width, low), 0.0)
        inside = np.maximum(np.minimum(high, width) - low, 0.0)
        start, end = np.full_like(v, web.start), np.full_like(v, web.end)
        for slope in web.slopes:
            if slope.inward > 0.0:
                start += slope.depth(v)
            else:
                end -= slope.depth(v)
        shared = np.maximum(np.minimum(end, sector.end) - np.maximum(start, sector.start), 0.0)
        thickness = sector.end - sector.start
        return np.asarray(2.0 * (outside * thickness + inside * (thickness - shared)))

    return _integral(area, np.array(heights))


def _bored(web: WebPlate, cylinder: Cylinder) -> float:
    """Volume that a cylinder's bore takes out of a web [m^3]."""
    radius = cylinder.bore_radius
    if radius == 0.0:
        return 0.0
    (x, y), (a, b) = web.foot, web.direction
    center = (cylinder.bore_axis[0] - x) * a + (cylinder.bore_axis[1] - y) * b
    heights = [center - radius, center + radius]
    heights += [s.start for s in web.slopes if heights[0] < s.start < heights[1]]
    return _integral(
        lambda v: (
            2.0 * np.sqrt(np.maximum(radius**2 - (v - center) ** 2, 0.0)) * web_thickness(web, v)
        ),
        np.array(heights),
    )


def _integral(function: Callable[[Array], Array], breaks: Array) -> float:
    """Integrate between breakpoints; the sine takes the roots at the ends of arcs out."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    angles = 0.5 * math.pi * nodes
    total = 0.0
    breaks = np.unique(breaks)
    for low, high in pairwise(breaks):
        half = 0.5 * (high - low)
        v = 0.5 * (low + high) + half * np.sin(angles)
        total += float(np.sum(function(v) * np.cos(angles) * weights) * half * 0.5 * math.pi)
    return total
