"""A dimensioned drawing of a crank throw to scale: side view, and view from its left end.

The views are arranged as in first-angle projection: the view from the left to the right of the side view,
at the same heights. Seen from the left, +x points to the left.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from crankbase.diagrams import REPRODUCIBLE, plain_text
from crankbase.errors import InputError
from crankbase.outputs import atomic_file, write_errors
from geometry.plots.dimension_lines import (
    CENTER,
    EDGE,
    INK,
    Point,
    View,
    circle,
    millimeters,
    silhouette,
    text_size,
)
from geometry.plots.views import draw_end, draw_side
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from matplotlib.figure import Figure


POINT_ON_PAPER = 0.0254 / 72.0  # [m]
BLOCK_HEIGHT = 46.0  # [points]
BOLD = 1.2  # bold text is at most so much wider


def block_texts(
    throw: CrankThrow, title: str, scale: float, lettered: bool
) -> tuple[str, str, str]:
    """Texts of the title block: name, scale, quantities that follow from the dimensions."""
    ratio = f"1 : {scale:g}" if scale >= 1.0 else f"{1.0 / scale:g} : 1"
    drawn = f"{'fields of [throw]' if lettered else 'lengths in mm'}\nscale {ratio}"
    overlap = f"overlap {millimeters(throw.overlap)} mm" if throw.overlap > 0.0 else "no overlap"
    derived = f"{overlap}\nvolume {1e3 * throw.volume:.4g} dm³"
    plain = plain_text(" ".join(title.split()))  # one line
    return (plain or "Crank throw", drawn, derived)


def draw_block(sheet: View, size: Point, texts: tuple[str, str, str], scale: float) -> None:
    """Draw the frame and the title block, in points."""
    frame = {"color": INK, "linewidth": 0.9}
    inset, right = 5.0, size[0] - 5.0
    sheet.stroke(
        [(inset, inset), (right, inset), (right, size[1] - inset), (inset, size[1] - inset)],
        frame,
        closed=True,
    )
    sheet.stroke([(inset, BLOCK_HEIGHT), (right, BLOCK_HEIGHT)], frame)
    title, drawn, derived = texts
    middle = 0.5 * (inset + BLOCK_HEIGHT)
    x = right
    for text in (derived, drawn):
        width = text_size(text)[0] + 20.0
        x -= width
        sheet.write(text, (x + 10.0, middle, "left"))
        sheet.stroke([(x, inset), (x, BLOCK_HEIGHT)], {**frame, "linewidth": 0.6})
    x = _draw_bar(sheet, x, middle, scale)
    x = _draw_projection_sign(sheet, x, middle)
    room = x - inset - 20.0
    size_of_title = min(12.0, 12.0 * room / (BOLD * text_size(title, 12.0)[0]))
    sheet.write(title, (inset + 10.0, middle, "left"), fontsize=size_of_title, fontweight="bold")


def _draw_bar(sheet: View, right: float, middle: float, scale: float) -> float:
    """Draw a bar that stays valid when the picture is scaled; return its cell's left edge."""
    target = 80.0 * scale * POINT_ON_PAPER
    power = 10.0 ** math.floor(math.log10(target))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= target)
    long = length / (scale * POINT_ON_PAPER)
    left = right - long - 30.0
    x, y = left + 15.0, middle - 6.0
    sheet.surface([(x, y), (x + 0.5 * long, y), (x + 0.5 * long, y + 3.0), (x, y + 3.0)], INK)
    sheet.stroke(
        [(x, y), (x + long, y), (x + long, y + 3.0), (x, y + 3.0)],
        {**EDGE, "linewidth": 0.8},
        closed=True,
    )
    sheet.write(f"{millimeters(length)} mm", (x + 0.5 * long, y + 11.0, "center"))
    sheet.stroke([(left, 5.0), (left, BLOCK_HEIGHT)], EDGE)
    return left


def _draw_projection_sign(sheet: View, right: float, middle: float) -> float:
    """Draw the sign of first-angle projection, a cone's two views; return its cell's left edge."""
    left = right - 66.0
    x, y = left + 12.0, middle
    cone = [(x, y - 5.0), (x + 18.0, y - 9.0), (x + 18.0, y + 9.0), (x, y + 5.0)]
    sheet.stroke(cone, {**EDGE, "linewidth": 0.9}, closed=True)
    for radius in (5.0, 9.0):
        sheet.stroke(circle((x + 32.0, y), radius), {**EDGE, "linewidth": 0.9})
    sheet.stroke([(x - 4.0, y), (x + 44.0, y)], {**CENTER, "linewidth": 0.5})
    sheet.stroke([(x + 32.0, y - 12.0), (x + 32.0, y + 12.0)], {**CENTER, "linewidth": 0.5})
    sheet.stroke([(left, 5.0), (left, BLOCK_HEIGHT)], EDGE)
    return left


# File endings, and the date that a file of each kind would else be stamped with.
ENDINGS: dict[str, dict[str, None]] = {
    ".svg": {"Date": None},
    ".png": {},
    ".pdf": {"CreationDate": None},
}
# One of these is chosen: one millimeter on paper for so many of the throw.
SCALES = (0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 75, 100)
LARGEST_BODY = (560.0, 340.0)  # both views together, without dimensions [points]
PIXELS_PER_INCH = 150
MARGIN, GAP, SMALLEST_WIDTH = 16.0, 34.0, 560.0  # [points]


def draw_throw(throw: CrankThrow, title: str = "", lettered: bool = False) -> "Figure":
    """Draw a throw to scale with all of its dimensions.

    Parameters
    ----------
    title : str
        Name of the engine or the throw, for the title block.
    lettered : bool
        Write the name of its field at each dimension in place of its value.

    Returns
    -------
    matplotlib.figure.Figure
        Its first axes have the side view over (z, y), its second the view from the left end over
        (-x, y), both in meters. At its own size it is drawn to the scale stated on it.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> draw_throw(throw, "6ChN 25/34").savefig("throw.svg")  # doctest: +SKIP
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    parts = throw.parts
    outlines = np.vstack([silhouette(web) for web in parts.webs if web.end > web.start])
    width, height = np.ptp(outlines, axis=0)
    on_paper = (
        (parts.length + width) / (LARGEST_BODY[0] * POINT_ON_PAPER),
        height / (LARGEST_BODY[1] * POINT_ON_PAPER),
    )
    scale = next((scale for scale in SCALES if scale >= max(on_paper)), max(on_paper))
    point = scale * POINT_ON_PAPER
    figure = Figure(facecolor="white")
    FigureCanvasAgg(figure)
    side, end = (View(figure.add_axes((0.0, 0.0, 1.0, 1.0)), point, lettered) for _ in range(2))
    draw_side(side, parts)
    draw_end(end, parts)
    top = max(side.high[1], end.high[1]) + 14.0 * point
    for view, text in (
        (side, "Side view (z to the right, y up)"),
        (end, "View from the left end (x to the left, y up)"),
    ):
        middle = 0.5 * (view.low[0] + view.high[0])
        view.write(text, (middle, top, "center"), fontsize=8.5, fontstyle="italic")
    _lay_out(figure, (side, end), block_texts(throw, title, scale, lettered), scale)
    return figure


def write_drawing(
    throw: CrankThrow, path: str | Path, title: str = "", lettered: bool = False
) -> Path:
    """Write the drawing of a throw.

    Parameters
    ----------
    throw, title, lettered
        As for `draw_throw`.
    path : path
        A file ending in ``.svg``, ``.png`` or ``.pdf``.

    Returns
    -------
    Path
        The file; identical bit for bit for the same throw.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    """
    import matplotlib as mpl

    path = Path(path)
    metadata = ENDINGS[check_drawing_ending(path)]
    with write_errors(path), mpl.rc_context(REPRODUCIBLE), atomic_file(path, "picture") as part:
        draw_throw(throw, title, lettered).savefig(part, dpi=PIXELS_PER_INCH, metadata=metadata)
    return path


def check_drawing_ending(path: Path) -> str:
    """Return the ending of a file name in lower case.

    Raises
    ------
    InputError
        If drawings cannot be written with it.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed for a drawing are "
            f"{', '.join(ENDINGS)}."
        )
    return ending


def _lay_out(
    figure: "Figure", views: Sequence[View], texts: tuple[str, str, str], scale: float
) -> None:
    """Set the size of the figure and the positions of the views, at one scale and the same heights."""
    point = views[0].point
    low = min(view.low[1] for view in views)
    high = max(view.high[1] for view in views)
    widths = [(view.high[0] - view.low[0]) / point for view in views]
    height = (high - low) / point
    needed = sum(widths) + GAP * (len(views) - 1) + 2.0 * MARGIN
    sheet = (max(needed, SMALLEST_WIDTH), height + BLOCK_HEIGHT + 2.0 * MARGIN)
    figure.set_size_inches(sheet[0] / 72.0, sheet[1] / 72.0)
    left = MARGIN + 0.5 * (sheet[0] - needed)
    for view, width in zip(views, widths, strict=True):
        view.axes.set_position(
            (
                left / sheet[0],
                (BLOCK_HEIGHT + MARGIN) / sheet[1],
                width / sheet[0],
                height / sheet[1],
            )
        )
        view.axes.set_xlim(view.low[0], view.high[0])
        view.axes.set_ylim(low, high)
        view.axes.set_aspect("equal")
        view.axes.set_axis_off()
        left += width + GAP
    block = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    block.set_xlim(0.0, sheet[0])
    block.set_ylim(0.0, sheet[1])
    block.set_axis_off()
    draw_block(View(block, 1.0), sheet, texts, scale)
