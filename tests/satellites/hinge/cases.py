"""What the core's tests of every command, file and result do with the elastic hinge."""

import math
from functools import cache

import numpy as np

from crankfem.files.reading.data_files import input_path
from crankfem.satellites.hinge.crosshead import CrossheadEngine
from crankfem.satellites.hinge.file import load_hinge
from crankfem.satellites.hinge.moment import hinge_moment
from crankfem.satellites.hinge.profile import hinge_profile
from crankfem.satellites.hinge.run import run_hinge
from crankfem.satellites.hinge.spring import GasSpring
from crankfem.satellites.hinge.turning import SteadyHingeTurn
from dynamics.engine.rods import ConnectingRod

SHIPPED = "crosshead-30-100"
calculated = cache(lambda: run_hinge(load_hinge(SHIPPED)))
# What takes long, and what is put in its place.
CALCULATED_ONCE = {run_hinge: lambda *_: calculated()}
# What takes a file of a kind from its path to all results.
OF_A_FILE = {"hinge": lambda path: run_hinge(load_hinge(path))}
# Of a command line the words in its last lines; the least count of numbers that it prints.
ANSWERS = {"hinge": "The hinge leaves"}
PRINTED_NUMBERS = {"hinge": 25}
# Of a snapshot the lines whose printed text it keeps.
SNAPSHOTS = {"hinge": (f"hinge {SHIPPED}", f"hinge {SHIPPED} --full")}
# Of each line that writes: the file that it reads, its words, a file that it writes, perhaps the last one.
FILE = input_path(SHIPPED, "hinge")
WRITES = {
    "hinge": (FILE, ("hinge", "{mine}", "--csv", "out.csv"), "out.csv"),
    "hinge pictures": (FILE, ("hinge", "{mine}", "--pictures", "p"), "p/hinge_speed.svg"),
}
LAST_FILES = {"hinge pictures": "p/hinge_guides.svg"}

RPM = 30.0 / math.pi
ANGLES = np.radians(np.arange(0.0, 720.0, 30.0))


@cache
def moment():
    engine = CrossheadEngine(
        0.3, 0.5, 80.0, 0.2, 30.0, ConnectingRod(1.55, 150.0, 0.8, 50.0), 150.0, 200.0, 110.0
    )
    return hinge_moment(
        engine, lambda a: 5e5 * np.exp(4.0 * (np.cos(a - 0.3) - 1.0)), 9.32, samples=72
    )


@cache
def profile():
    return hinge_profile(moment(), GasSpring(0.031, 1.0, 5e6), 0.8)


def closed(values):
    return np.append(values, values[0])


def over_turn(degrees, values):
    """Degrees and values with the closing sample, which the object leaves out."""
    return np.append(degrees, degrees[-1] + degrees[1] - degrees[0]), closed(values)


# Of each result: the object, options of plot(), and by label a line that must be there: x and y as drawn.
PLOTS = {
    "HingeMoment": (
        moment,
        {},
        lambda o: {"hinge": over_turn(o.angles_deg, 1e-3 * o.moment)},
    ),
    "HingeProfile": (
        profile,
        {},
        lambda o: {"guide": (closed(1e3 * o.guide().real), closed(1e3 * o.guide().imag))},
    ),
    "HingeProfile, moment": (
        profile,
        {"show": "moment"},
        lambda o: {"moment": over_turn(o.angles_deg, 1e-3 * o.moment)},
    ),
    "SteadyHingeTurn": (
        lambda: SteadyHingeTurn(ANGLES[:12], 9.0 + np.sin(ANGLES[:12]), 9.0, 0.0, 0.0),
        {},
        lambda o: {"speed": over_turn(o.angles_deg, RPM * o.speed)},
    ),
}
WRONG_OPTIONS = {"HingeProfile": (profile, {"show": ["heat"]})}
# The object, and some columns of its table with their unit and part of the object.
TABLES = {
    "HingeMoment": (moment, {"hinge_moment": ("N m", "moment")}),
    "HingeProfile": (profile, {"normal_force": ("N", "normal_force")}),
    "SteadyHingeTurn": (
        lambda: SteadyHingeTurn(ANGLES, 1.0 + np.arange(24.0), 9.0, 0.0, 0.0),
        {"speed": ("rad/s", "speed")},
    ),
}
