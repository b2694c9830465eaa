"""The sheet of a drawing: frame, title block, scale bar, projection sign."""

import math

from crankbase.drawing.legends import plain_text
from geometry.plots.dimension_lines import CENTER, EDGE, INK, View, text_size
from geometry.plots.dimension_texts import millimeters
from geometry.plots.throw_shapes import Point, circle
from geometry.throw import CrankThrow

POINT_ON_PAPER = 0.0254 / 72.0  # [m]
BLOCK_HEIGHT = 46.0  # [points]
BOLD = 1.2  # bold text is at most so much wider


def block_texts(throw: CrankThrow, title: str, scale: float) -> tuple[str, str, str]:
    """Texts of the title block: name, scale, quantities that follow from the dimensions."""
    ratio = f"1 : {scale:g}" if scale >= 1.0 else f"{1.0 / scale:g} : 1"
    drawn = f"lengths in mm\nscale {ratio}"
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
