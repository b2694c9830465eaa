"""The words and numbers of a throw's drawing."""

import math
from collections.abc import Callable, Sequence
from typing import TypeVar

from geometry.outline import Arc
from geometry.parts import Cylinder, WebPlate
from geometry.plots.throw_shapes import Point, on_weight

Part = TypeVar("Part", Cylinder, WebPlate)


def millimeters(length: float) -> str:
    """Write a length for a drawing."""
    value = 1e3 * length
    text = f"{value:.{1 if abs(value) >= 100.0 else 2}f}"
    return text.rstrip("0").rstrip(".").replace("-", "−")


def degrees(angle: float) -> str:
    """Write an angle without its sign."""
    return f"{abs(math.degrees(angle)):.1f}".rstrip("0").rstrip(".") + "°"


def symbol(base: str, index: str) -> str:
    """Write a symbol with an index."""
    return rf"${base}_\mathrm{{{index}}}$"


def name_of(part: Cylinder | WebPlate) -> str:
    """Name a part on the drawing."""
    return "pin 1" if part.name == "pin" else part.name


def distinct_values(
    parts: Sequence[Part], value: Callable[[Part], object]
) -> list[tuple[Part, str]]:
    """Return the first part with each distinct value and, if there are several values, who has it."""
    groups: dict[str, list[Part]] = {}
    for part in parts:
        groups.setdefault(str(value(part)), []).append(part)
    return [
        (group[0], " " + ", ".join(name_of(part) for part in group) if len(groups) > 1 else "")
        for group in groups.values()
    ]


def corner_texts(web: WebPlate) -> dict[str, Point]:
    """Texts of the rounded or cut corners of an outline, from the tip on, and points (u, v) on them."""
    pieces = web.outline.pieces[::-1]
    arcs = [piece for piece in pieces if isinstance(piece, Arc)]
    found: dict[str, Point] = {}
    for arc in arcs:
        if _is_plain_end(web, arc):
            continue
        points = arc.points(33)
        seen = points[~on_weight(web, points)]
        u, v = seen[len(seen) // 2] if len(seen) else points[16]
        found.setdefault(f"$r$ {millimeters(arc.radius)}", (float(u), float(v)))
    if not arcs:
        for piece in pieces:
            (u_0, v_0), (u_1, v_1) = piece.start, piece.end
            if math.isclose(abs(u_1 - u_0), abs(v_1 - v_0)):  # others follow from widths and ends
                text = f"{millimeters(abs(u_1 - u_0))} × 45°"
                found.setdefault(text, (0.5 * (u_0 + u_1), 0.5 * (v_0 + v_1)))
    return found


def _is_plain_end(web: WebPlate, arc: Arc) -> bool:
    """Whether an arc is an end of a plain obround, whose radius goes without saying."""
    about_axis = arc.center in ((0.0, 0.0), (0.0, web.distance))
    return about_axis and math.isclose(2.0 * arc.radius, web.outline.width, rel_tol=1e-6)
