"""Labels of diagrams: they touch neither lines nor each other."""

import numpy as np

from comparing import close
from dynamics.plots.campbell import LABEL_ROOM, campbell_frame
from dynamics.plots.load_diagrams import LABEL_HALF, label_spots, square_round


def test_labels_of_a_polar_curve_touch_neither_it_nor_each_other():
    """A curve with loops: a circle of 1 with one of 0.55 three times as fast."""
    turns = 2.0 * np.pi * np.arange(720) / 720
    curve = np.exp(1j * turns) + 0.55 * np.exp(4j * turns)
    points = curve[::30]
    low, high = square_round([curve])
    width = high[0] - low[0]
    half = np.array(LABEL_HALF) * width
    spots = [spot for spot in label_spots(curve, points, width) if spot is not None]
    assert len(spots) > 15
    fine = np.interp(np.arange(0.0, 720.0, 0.05), np.arange(721), np.append(curve, curve[0]))
    for number, spot in enumerate(spots):
        gap = fine - spot
        # Samples of the curve are half a label's height apart.
        assert not np.any((np.abs(gap.real) < 0.8 * half[0]) & (np.abs(gap.imag) < 0.6 * half[1]))
        for other in spots[:number]:
            apart = np.abs([(other - spot).real, (other - spot).imag]) / half
            assert max(apart) >= 2.0 * (1.0 - 1e-12)
        assert low[0] < spot.real - half[0] < spot.real + half[0] < high[0]
        assert low[1] < spot.imag - half[1] < spot.imag + half[1] < high[1]


def test_a_label_goes_outwards_where_nothing_is_in_the_way():
    curve = np.exp(2j * np.pi * np.arange(360) / 360)
    (spot,) = label_spots(curve, curve[60:61], 2.32)
    step = spot - curve[60]
    half = 2.32 * np.array(LABEL_HALF)
    # An ellipse of the label's own shape, in the direction away from the middle.
    assert np.degrees(np.arctan2(step.imag / half[1], step.real / half[0])) == close(60.0)
    assert abs(spot) > 1.0
    # Along a line that fills the square there is no room.
    comb = np.ravel([[x + 0j, x + 1j, x + 0.01 + 1j, x + 0.01] for x in np.arange(0.0, 1.0, 0.02)])
    assert label_spots(comb, comb[40:41] + 0.5j, 1.16) == [None]


def test_orders_of_a_campbell_diagram_are_labeled_where_there_is_room():
    frame = campbell_frame(np.array([6.3]), np.arange(1.0, 13.0), (3.6, 15.0), ())
    labeled = frame.labeled([*range(1, 13), 1.5])
    assert {1, 2, 3, 4, 5} <= {*labeled} < {*range(1, 13)}
    left, right = frame.ends
    along = sorted(frame.line_end(order)[0] for order in labeled if frame.line_end(order)[2])
    assert min(np.diff(along)) >= LABEL_ROOM * (right - left) * (1.0 - 1e-12)
