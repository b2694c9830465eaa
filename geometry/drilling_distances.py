"""Distances from oil holes as formulas in x, y, z, evaluated by gmsh for the sizes of elements."""

import math

import numpy as np

from geometry.drilling import Drilling


def distance_from_wall(hole: Drilling) -> str:
    """Formula of the distance from a hole's wall, drawn out through a bore that it crosses."""
    middle, (first, second, along) = hole.middle.tolist(), hole.frame.tolist()
    reach = hole.journal_radius / math.cos(hole.tilt)
    start = -reach if hole.through else hole.inner_end
    t, center, half = _along(middle, along), 0.5 * (reach + start), 0.5 * (reach - start)
    beyond = f"0.5*(Abs({t}-({center!r}))-{half!r}+Abs(Abs({t}-({center!r}))-{half!r}))"
    off = f"Sqrt(({_along(middle, first)})^2+({_along(middle, second)})^2)"
    return f"Sqrt(({off}-{hole.radius!r})^2+({beyond})^2)"


def _along(origin: list[float], way: list[float]) -> str:
    """Formula of the coordinate along a unit vector from a point."""
    return "+".join(
        f"({step!r})*({axis}-({start!r}))"
        for axis, start, step in zip("xyz", origin, way, strict=True)
    ).join("()")


def distance_from_exits(hole: Drilling) -> str:
    """Formula of the distance from balls that hold a hole's exits."""
    formulas = []
    for outlet in hole.exits:
        x, y, z = outlet.point.tolist()
        rim = hole.middle + outlet.rim @ hole.frame
        ball = float(np.linalg.norm(rim - outlet.point, axis=1).max())
        off = f"(Sqrt((x-({x!r}))^2+(y-({y!r}))^2+(z-({z!r}))^2)-{ball!r})"
        formulas.append(f"(0.5*({off}+Abs({off})))")
    return formulas[0] if len(formulas) == 1 else f"Min({formulas[0]},{formulas[1]})"
