"""The outline of a throw as a small SVG, drawn in milliseconds, for changes of dimensions by sliders."""

from collections.abc import Callable
from html import escape
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.errors import InputError
from geometry.parts import ThrowParts
from geometry.plots.dimension_lines import INK, OUTLINE, Place, Style, View
from geometry.plots.views import draw_end, draw_side

OutlineView = Literal["side", "front"]
DRAWINGS: dict[str, tuple[Callable[[View, ThrowParts, bool], None], str]] = {
    "side": (draw_side, "Side view of the throw, the shaft from left to right"),
    "front": (draw_end, "Front view of the throw, from its left end"),
}
# A point on paper stands for this share of the throw's length.
POINT = 1.0 / 300.0
MARGIN = 6.0  # points
DIGITS = 5  # of a coordinate, in the thousandth part of a millimeter for a throw of a hundred


class _SvgView(View):
    """A view that is written as SVG at once, without matplotlib; it takes no dimensions."""

    def __init__(self, point: float) -> None:
        nobody: Any = None
        super().__init__(nobody, point)
        self._shapes: list[tuple[float, str]] = []

    def stroke(self, points: ArrayLike, style: Style = OUTLINE, closed: bool = False) -> None:
        path = np.asarray(points, dtype=float)
        dashes = ""
        if "dashes" in style:
            dashes = f' stroke-dasharray="{" ".join(f"{part:g}" for part in style["dashes"])}"'
        self._add(
            path,
            style.get("zorder", 3.0),
            f'fill="none" stroke="{style["color"]}" stroke-width="{style["linewidth"]:g}"{dashes}',
            closed,
        )

    def surface(self, points: ArrayLike, color: str, edge: float = 1.0) -> None:
        stroke = f' stroke="{INK}" stroke-width="{edge * OUTLINE["linewidth"]:g}"' if edge else ""
        self._add(np.asarray(points, dtype=float), 1.0, f'fill="{color}"{stroke}', closed=True)

    def write(
        self,
        text: str,
        *places: Place,
        upright: bool = False,  # noqa: ARG002 - names of pins stand level
        paper: str = "white",  # noqa: ARG002 - and on their pins
        **style: Any,
    ) -> int:
        x, y, _ = places[0]
        size = style.get("fontsize", 8.0) * self.point
        self._shapes.append(
            (
                5.0,
                f'<text x="{x:.{DIGITS}g}" y="{-y:.{DIGITS}g}" font-size="{size:.3g}" '
                f'text-anchor="middle" font-family="sans-serif">{escape(text)}</text>',
            )
        )
        return 0

    def _add(self, path: Any, layer: float, look: str, closed: bool) -> None:
        self._reach(path)
        pieces, drawn = [], False
        for x, y in path.tolist():
            if x != x:  # a gap
                drawn = False
                continue
            pieces.append(f"{'L' if drawn else 'M'}{x:.{DIGITS}g} {0.0 - y:.{DIGITS}g}")
            drawn = True
        end = "Z" if closed else ""
        self._shapes.append(
            (layer, f'<path vector-effect="non-scaling-stroke" d="{"".join(pieces)}{end}" {look}/>')
        )

    def text(self, label: str) -> str:
        margin = MARGIN * self.point
        low, high = self.low - margin, self.high + margin
        width, height = high - low
        # Sorted by layer, else in the order in which they were drawn.
        shapes = "".join(shape for _, shape in sorted(self._shapes, key=lambda one: one[0]))
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
            f'viewBox="{low[0]:.6g} {-high[1]:.6g} {width:.6g} {height:.6g}">'
            f"{shapes}</svg>"
        )


def outline_svg(parts: ThrowParts, view: OutlineView = "side", label: str = "") -> str:
    """Draw one view of a throw to scale, without dimensions.

    Parameters
    ----------
    view : {"side", "front"}
        From the side, z to the right and y up; or from the left end, where x points to the left.
    label : str
        Text for a screen reader instead of the view's name.

    Returns
    -------
    str
        An SVG whose units are meters.

    Raises
    ------
    InputError
        If the view is neither.
    """
    if view not in DRAWINGS:
        raise InputError(
            f"view: given {view!r}; allowed are {', '.join(DRAWINGS)}, because a throw is drawn from "
            "these two."
        )
    draw, name = DRAWINGS[view]
    drawn = _SvgView(POINT * parts.length)
    draw(drawn, parts, False)
    return drawn.text(label or name)
