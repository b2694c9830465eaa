"""Volume of a throw from its parts, without any kernel, to check the solid."""

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.parts import Cylinder, Sector, ThrowParts, WebPlate

Array = NDArray[np.float64]
GAUSS_POINTS, PANELS = 10, 8
HALVINGS = 45


def throw_volume(parts: ThrowParts) -> float:
    """Volume of a throw [m^3]: journals, fillets, webs, counterweights, less bores and oil holes.

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
        if web.sector is not None:
            volume += _sector_volume(web, web.sector, after if before.is_pin else before)
    return volume - sum(hole.volume for hole in parts.drillings)


def fillet_volume(journal_radius: float, fillet_radius: float) -> float:
    """Volume between a cylinder, a flat web face and the fillet that joins them (Pappus) [m^3]."""
    area = fillet_radius**2 * (1.0 - math.pi / 4.0)
    # First moment of the square r x r less its quarter circle, about the journal's surface.
    square = fillet_radius**2 * 0.5 * fillet_radius
    quarter = math.pi / 4.0 * fillet_radius**2 * (1.0 - 4.0 / (3.0 * math.pi)) * fillet_radius
    return 2.0 * math.pi * (journal_radius * area + square - quarter)


def web_thickness(web: WebPlate, v: Array) -> Array:
    """Thickness of a web at heights v from its foot [m]."""
    start, end = web.faces(v)
    return end - start


def _web_volume(web: WebPlate) -> float:
    heights = [*web.outline.heights, *(slope.start for slope in web.slopes)]
    return _integral(
        lambda v: 2.0 * web.outline.half_width(v) * web_thickness(web, v), np.array(heights)
    )


def counterweight_moment(parts: ThrowParts) -> Array:
    """Return the integral of (x, y) over what the counterweights add to their webs, (2,) [m^4]."""
    moment = np.zeros(2)
    for web, before, after in zip(parts.webs, parts.cylinders, parts.cylinders[1:], strict=False):
        if web.sector is not None:
            journal = after if before.is_pin else before
            volume, first = (_sector_volume(web, web.sector, journal, power) for power in (0, 1))
            moment += volume * np.array(web.foot) + first * np.array(web.direction)
    return moment


def _sector_volume(web: WebPlate, sector: Sector, journal: Cylinder, power: int = 0) -> float:
    """Volume that a counterweight adds to its web, less the journal's bore through it [m^3].

    Or the integral of a power of the height from the web's foot over that volume.
    """
    bore, center = journal.bore_radius, _height(web, journal)
    cosine, tangent = math.cos(sector.half_angle), math.tan(sector.half_angle)
    radii = (sector.outer_radius, sector.inner_radius)
    heights = [
        *(-r for r in radii),
        *(-r * cosine for r in radii),
        *(v for v in web.outline.heights if -sector.outer_radius < v < 0.0),
        *(s.start for s in web.slopes if -sector.outer_radius < s.start < 0.0),
        *(v for v in (center - bore, center + bore) if v < 0.0),
        0.0,
    ]

    def bored(v: Array) -> Array:
        return np.sqrt(np.maximum(bore**2 - (v - center) ** 2, 0.0))

    def reach(v: Array) -> tuple[Array, Array, Array]:
        """Where the counterweight begins and ends beside the line of symmetry, and the web ends."""
        low = np.sqrt(np.maximum(sector.inner_radius**2 - v**2, 0.0))
        high = np.sqrt(np.maximum(sector.outer_radius**2 - v**2, 0.0))
        if sector.half_angle < 0.5 * math.pi - 1e-12:
            high = np.minimum(high, -v * tangent)
        return low, high, web.outline.half_width(v)

    def area(v: Array) -> Array:
        low, high, width = reach(v)
        outside = np.maximum(high - np.maximum(width, low), 0.0)
        inside = np.maximum(np.minimum(high, width) - low, 0.0)
        start, end = web.faces(v)
        shared = np.maximum(np.minimum(end, sector.end) - np.maximum(start, sector.start), 0.0)
        thickness = sector.end - sector.start
        # Where the web is thinned, the counterweight fills it up, but not the bore.
        filled = max(min(web.end, sector.end) - max(web.start, sector.start), 0.0) - shared
        hole = np.maximum(np.minimum(np.minimum(high, width), bored(v)) - low, 0.0)
        added = outside * thickness + inside * (thickness - shared) - hole * filled
        return np.asarray(2.0 * added * v**power)

    # Where the outlines cross, the integrand has a kink.
    fine = np.linspace(-sector.outer_radius, 0.0, 401)
    gaps: tuple[Callable[[Array], Array], ...] = (
        lambda v: reach(v)[1] - reach(v)[2],
        lambda v: reach(v)[0] - reach(v)[2],
        lambda v: reach(v)[1] - bored(v),
    )
    for gap in gaps:
        signs = np.sign(gap(fine))
        places = np.flatnonzero(signs[:-1] * signs[1:] < 0.0)
        if len(places):
            heights.extend(_roots(gap, fine[places], fine[places + 1]))
    # The web may be thinned so far that the counterweight's face comes out of it.
    for slope in web.slopes:
        for face in (sector.start, sector.end):
            depth = (face - slope.face) * slope.inward
            if 0.0 < depth < slope.drop:
                heights.append(slope.start + depth / slope.drop * (slope.end - slope.start))
    return _integral(area, np.clip(heights, -sector.outer_radius, 0.0))


def _roots(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Bisect intervals at whose ends a function has other signs; scipy's takes longer to load than a mesh."""
    sign = np.sign(function(low))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = np.sign(function(middle)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.asarray(0.5 * (low + high))


def _bored(web: WebPlate, cylinder: Cylinder) -> float:
    """Volume that a cylinder's bore takes out of a web [m^3]."""
    radius = cylinder.bore_radius
    if radius == 0.0:
        return 0.0
    center = _height(web, cylinder)
    heights = [center - radius, center + radius]
    heights += [s.start for s in web.slopes if heights[0] < s.start < heights[1]]
    return _integral(
        lambda v: (
            2.0 * np.sqrt(np.maximum(radius**2 - (v - center) ** 2, 0.0)) * web_thickness(web, v)
        ),
        np.array(heights),
    )


def _height(web: WebPlate, cylinder: Cylinder) -> float:
    """Height v of a bore's axis in a web's coordinates [m]."""
    (x, y), (a, b) = web.foot, web.direction
    return (cylinder.bore_axis[0] - x) * a + (cylinder.bore_axis[1] - y) * b


@cache
def _panels() -> tuple[Array, Array]:
    """Gauss points on (-1, 1), a few on each of several panels."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    middles = (2.0 * np.arange(PANELS) + 1.0) / PANELS - 1.0
    return (middles[:, None] + nodes / PANELS).ravel(), np.tile(weights / PANELS, PANELS)


def _integral(function: Callable[[Array], Array], breaks: Array) -> float:
    """Integrate between breakpoints; the sine takes the roots at the ends of arcs out."""
    nodes, weights = _panels()
    angles = 0.5 * math.pi * nodes
    total = 0.0
    breaks = np.unique(breaks)
    for low, high in pairwise(breaks):
        half = 0.5 * (high - low)
        v = 0.5 * (low + high) + half * np.sin(angles)
        total += float(np.sum(function(v) * np.cos(angles) * weights) * half * 0.5 * math.pi)
    return total
