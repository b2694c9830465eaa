"""Oil holes in the views of a drawing."""

import math

import numpy as np
from numpy.typing import NDArray

from geometry.drilling import Drilling, DrillingExit
from geometry.parts import ThrowParts
from geometry.plots.dimension_lines import BEYOND, EDGE, HIDDEN, THIN_CENTER, View
from geometry.plots.dimension_texts import degrees, millimeters

Array = NDArray[np.float64]

# Right and up in each view, as rows of x, y, z.
SIDE = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
FROM_LEFT = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# Holes that point to the eye or away from it by this sine or less are drawn as their rims alone.
END_ON = 0.05


def draw_oil_holes(view: View, parts: ThrowParts, axes: Array, hidden: bool) -> None:
    """Draw the holes of a throw: walls dashed, rims that are seen in full.

    Parameters
    ----------
    view : View
    parts : ThrowParts
    axes : (2, 3) array
        Right and up on paper, `SIDE` or `FROM_LEFT`.
    hidden : bool
        Whether something stands before all journals, so that no rim is seen.
    """
    eye = np.cross(axes[0], axes[1])
    for hole in parts.drillings:
        for outlet in hole.exits:
            rim = _on_paper(hole, outlet.rim, axes)
            seen = not hidden and outlet.direction @ eye > END_ON
            view.stroke(rim, {**(EDGE if seen else HIDDEN), "linewidth": 0.6}, closed=True)
            across = np.cross(hole.frame[2], eye)
            sine = float(np.linalg.norm(across))
            if sine > END_ON:
                for sign in (-1.0, 1.0):
                    p, q = sign * hole.radius * (hole.frame[:2] @ across) / sine
                    view.stroke(_line(outlet, p, q, 0.0, axes), HIDDEN)
                view.stroke(_line(outlet, 0.0, 0.0, BEYOND * view.point, axes), THIN_CENTER)


def dimension_oil_holes(view: View, parts: ThrowParts) -> None:
    """Write what each hole measures beside where it comes out, in the side view."""
    for hole in parts.drillings:
        outlet = max(hole.exits, key=lambda one: one.point[1])
        place = hole.middle + np.array([0.0, 0.0, outlet.surface(np.zeros(1), np.zeros(1))[0]]) @ (
            hole.frame
        )
        text = f"⌀ {millimeters(2.0 * hole.radius)}, {_signed(outlet.angle_deg)}"
        if hole.tilt:
            text += f", tilt {_signed(math.degrees(hole.tilt * outlet.side))}"
        if hole.exit_radius:
            text += f", $r$ {millimeters(hole.exit_radius)}"
        tip = axes_point(place)
        view.leader(tip, (-10.0 if hole.number % 2 else 10.0, 14.0), text)


def axes_point(place: Array) -> tuple[float, float]:
    """Place (z, y) in the side view."""
    return (float(place[2]), float(place[1]))


def _signed(angle_deg: float) -> str:
    return ("−" if angle_deg < 0.0 else "") + degrees(math.radians(angle_deg))


def _line(outlet: DrillingExit, p: float, q: float, beyond: float, axes: Array) -> Array:
    """A line along the hole from its inner end to the surface, and so far beyond it."""
    across = np.array([[p, q]])
    ends = outlet.inner(*across.T), outlet.surface(*across.T) + outlet.side * beyond
    places = np.array([[p, q, end[0]] for end in ends])
    return _on_paper(outlet.drilling, places, axes)


def _on_paper(hole: Drilling, places: Array, axes: Array) -> Array:
    """Points (n, 2) on paper of places p, q, t (n, 3)."""
    return np.asarray((hole.middle + places @ hole.frame) @ axes.T)
