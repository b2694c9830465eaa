"""What the core's tests of every command, file and result do with measured vibration."""

import numpy as np

from crankfem.satellites.measured.measured_orders import MeasuredOrders
from crankfem.satellites.measured.overlay import OrderPair, Overlay


def two_speeds():
    return MeasuredOrders(
        orders=[0.5, 3.0],
        speed=[100.0, 120.0],
        amplitude=np.array([[1e-3, 2e-3j], [3e-3, 1e-3]]),
        scatter=np.full((2, 2), 1e-5),
        place="damper",
        quantity="angle",
        correlation=np.eye(2),
        ramp=[0.0, 0.0],
        wheel_constant=[False, True],
        cycle=2,
        zero_known=True,
    )


# The object, and some columns of its table with their unit and part of the object.
TABLES = {
    "MeasuredOrders": (
        two_speeds,
        {"amplitude": ("rad", lambda o: np.abs(o.amplitude).ravel())},
    )
}


def laid_over():
    pairs = (OrderPair(0.5, 3e-3, 120.0, 1e-5, 2e-3, 120.0, "rad"),)
    calculated = two_speeds().amplitude / 1.5
    return Overlay("an engine", "damper", two_speeds(), calculated, "steady", 0.0, 0.3, pairs, ())


# Of each result: the object, options of plot(), and by label a line that must be there: x and y as drawn.
PLOTS = {
    "Overlay": (
        laid_over,
        {},
        lambda o: {
            "order 0.5": (
                30.0 / np.pi * o.measured.speed,
                np.degrees(np.abs(o.calculated[:, 0])),
            ),
            "order 0.5 measured": (
                30.0 / np.pi * o.measured.speed,
                np.degrees(np.abs(o.measured.amplitude[:, 0])),
            ),
        },
    )
}


# Of commands that read files: a line of each. Their JSON is looked at here.
READS = {
    "calibrate": ("calibrate", "6chn105-130", "PATH", "--at", "free end"),
    "measured": ("measured", "PATH", "--teeth", "60-2"),
}
