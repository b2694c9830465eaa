"""Studies with slopes, as tests write them, of functions in place of finite elements."""

import numpy as np
from scipy.stats import qmc

from plans import SHARP
from regression.fits.run_slopes import RunSlopes
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import RUN, Outcome
from regression.runs.study_table import study_table

FACTORS = ("web_width", "web_thickness", "pin_length")
LOW, HIGH = np.array([0.270, 0.038, 0.120]), np.array([0.330, 0.098, 0.158])
HALF = 0.5 * (HIGH - LOW)
NAME = "axial_compliance_pinned"


def box(count, seed):
    return qmc.scale(qmc.LatinHypercube(3, rng=seed).random(count), LOW, HIGH)


def slopes_of(function, x, shift=1e-6):
    """Slopes of a function over its own columns, counted in halves of the ranges."""
    steps = shift * np.diag(HALF)
    ends = [np.array([function(x + sign * step) for step in steps]) for sign in (-1.0, 1.0)]
    values = ((ends[1] - ends[0]) / (2.0 * shift) / function(x)).T
    turned = np.broadcast_to(np.diag(HALF), (len(x), 3, 3))
    return RunSlopes(values, np.ones_like(values), turned)


def plan(kind="latin hypercube", runs=10, **others):
    factors = tuple(Factor(*one) for one in zip(FACTORS, "mmm", LOW, HIGH, strict=True))
    return StudyPlan(SHARP, factors, DesignChoice(kind, runs=runs), slopes=True, **others)


def compliance(throw):
    """Something shaped like a throw's, of its record."""
    h, wide, long = throw["web_thickness"], throw["web_width"], throw["pin_length"]
    size = throw["crank_radius"] ** 3 / throw["pin_diameter"] ** 4
    return 1e-11 * size * (long + 0.3 * h + 0.002 / (wide * h**0.8))


def table_with_slopes(made, change=None):
    """Return the table of a study of `compliance` and its slopes over the fields, changed at the runs."""
    outcomes, runs = {}, 0
    for design in made.planned.designs:
        throw = design.inputs["throw"]
        slopes = {}
        for path in design.inputs.get("slopes", ()):
            ends = [compliance(throw | {path: throw[path] * (1.0 + s)}) for s in (-1e-6, 1e-6)]
            slopes[path] = float(np.log(ends[1] / ends[0]) / 2e-6)
        if design.role == RUN:
            slopes = change(runs, slopes) if change else slopes
            runs += 1
        outcomes[design.key] = Outcome(
            design.key,
            design.inputs,
            {NAME: compliance(throw)},
            None,
            0.0,
            errors={NAME: 0.003},
            slopes={NAME: slopes} if slopes else {},
            slope_errors={NAME: 0.01} if slopes else {},
        )
    return study_table(made, made.planned.designs, outcomes)
