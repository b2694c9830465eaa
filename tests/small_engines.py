"""Engines of few cylinders with smooth gas pressure, of which sums over samples are exact integrals."""

import numpy as np

from dynamics.engine.layout import EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod
from parts_in_a_line import cylinder

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
SLAVE_ROD = ConnectingRod(0.18, 1.2, 0.07, 0.008)


class SmoothPressure:
    """A pressure of few harmonics: with those of the mechanism, which fade, the orders are all."""

    def __init__(self, strokes, size=1.0):
        self.strokes = strokes
        self.size = size

    def at(self, *, angle_deg):
        angle = np.radians(angle_deg)
        part = 2.0 / self.strokes
        waves = 9.0 * np.cos(part * angle - 0.4) + 3.0 * np.cos(2 * part * angle - 0.7)
        return 1e5 * (12.0 + self.size * waves)


def two_stroke_row():
    """Three cylinders in line, whose piston pins have an offset."""
    cylinders = [
        cylinder(0.12, 3.0, ROD, crank, 0.0, place, pin_offset=0.003)
        for crank, place in ((0.0, 0.0), (120.0, 0.2), (240.0, 0.4))
    ]
    return EngineLayout(0.07, cylinders, [1, 3, 2], strokes=2)


def vee(hinged):
    """Two throws of two cylinders, 60 deg between the banks: rods hinged, or side by side."""
    cylinders = []
    for throw, crank in enumerate((0.0, 180.0)):
        place = 0.2 * throw
        pin = SlavePin(2 * throw + 1, 0.06, angle_deg=60.0) if hinged else None
        rod, apart = (SLAVE_ROD, 0.0) if hinged else (ROD, 0.03)
        cylinders.append(cylinder(0.12, 3.0, ROD, crank, -30.0, place))
        cylinders.append(cylinder(0.12, 2.8, rod, crank, 30.0, place + apart, slave_pin=pin))
    return EngineLayout(0.07, cylinders, [1, 2, 3, 4])
