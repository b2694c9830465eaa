"""Diagrams on paper."""

from crankbase.diagrams import new_axes, write_title


def test_a_long_title_stays_in_the_picture():
    axes = new_axes(None)
    write_title(
        axes,
        "Caterpillar 3116 (6ChN 10.5/12.7): orders at free end, measured (dots) and calculated (lines)",
    )
    drawn = axes.figure
    drawn.canvas.draw()
    (title,) = [text for text in axes.get_children() if text is axes._left_title]
    assert title.get_window_extent().x1 < drawn.bbox.x1
