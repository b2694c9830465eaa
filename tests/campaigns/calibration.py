"""Calibration of the six-cylinder chain by simulated records: coverage, null directions, gains.

Run by hand: ``python tests/campaigns/calibration.py coverage|gains [COUNT] [FIRST SEED] [CASE]``. Truth is
drawn from the prior. The figures are in docs/measured.md.
"""

import sys
import time

import numpy as np

from crankfem.satellites.measured.calibration.fit import Problem, fit
from crankfem.satellites.measured.calibration.gains import cylinder_gains, cylinder_groups
from crankfem.satellites.measured.calibration.identifiability import directions
from measured_shafts import CYLINDERS, FLYWHEEL, PULLEY, observed, shaft, usual_groups

CASES = {
    "plain": {},
    "wheel": {"wheel": 1.0},
    "wheel, windows": {"wheel": 1.0, "shared": 0.75},
    "outliers": {"outliers": 0.01},
}


def coverage(count: int, first: int, only: str = "") -> None:
    """Print how many 95 % intervals hold the truth, by group, and how often the null direction is named."""
    of = shaft()
    null = np.array(
        [1.0 / group.deviation if group.name != "loss factor" else 0.0 for group in usual_groups()]
    )
    null /= np.linalg.norm(null)
    for name, sensor in (("pulley", PULLEY), ("flywheel", FLYWHEEL)):
        for case, options in CASES.items():
            if only not in f"{name}, {case}":
                continue
            started, held, named, narrow, lost, misfits = time.process_time(), [], 0, 0, 0, []
            for seed in range(first, first + count):
                rng = np.random.default_rng(seed)
                truth = rng.normal(size=null.size)
                solved = fit(Problem(of, (observed(of, truth, sensor, rng, **options),)))
                held.append(np.abs(solved.parameters - truth) <= 1.96 * solved.deviations)
                untold = [each for each in directions(solved) if each.untold]
                # The part of the null direction that lies in what is named.
                named += bool(sum((each.parts @ null) ** 2 for each in untold) > 0.9)
                narrow += bool(null @ solved.covariance @ null < 0.5)
                lost += solved.lost_starts
                misfits.append(solved.misfit)
            each = ", ".join(f"{100 * share:.1f}" for share in np.mean(held, axis=0))
            print(
                f"{name}, {case}: covered {100 * np.mean(held):.1f} % ({each}); null named {named}, narrow "
                f"{narrow} of {count}; starts lost {lost}; misfit {np.mean(misfits):.3f}; "
                f"{(time.process_time() - started) / count:.2f} s each",
                flush=True,
            )


def gains(count: int, first: int) -> None:
    """Print how often a weak cylinder is named, a healthy one called weak, and nothing can be told."""
    groups = (*usual_groups()[:-1], *cylinder_groups(CYLINDERS))
    of, five = shaft(groups), np.linspace(110.0, 240.0, 5)
    cases = (("pulley, five speeds", PULLEY, five), ("flywheel, one speed", FLYWHEEL, five[1:2]))
    for case, sensor, speed in cases:
        for weak in (True, False):
            right = wrong = untold = 0
            for seed in range(first, first + count):
                rng = np.random.default_rng(seed)
                truth = np.concatenate((rng.normal(size=7), np.zeros(6)))
                which = seed % 6
                truth[7 + which] = weak * np.log(0.8) / groups[-1].deviation
                record = observed(of, truth, sensor, rng, speed=speed, wheel=1.0, floor=True)
                told = cylinder_gains(fit(Problem(of, (record,))), CYLINDERS)
                right += told.weak == (CYLINDERS[which],) * weak
                wrong += bool(set(told.weak) - {CYLINDERS[which]} if weak else told.weak)
                untold += not told.determined
            print(
                f"{case}, {'one weak' if weak else 'healthy'}: right {right}, a healthy one called weak "
                f"{wrong}, cannot be told {untold} of {count}",
                flush=True,
            )


if __name__ == "__main__":
    chosen, number, seed, *case = [*sys.argv[1:], *["coverage", "200", "0"][len(sys.argv) - 1 :]]
    {"coverage": coverage, "gains": gains}[chosen](int(number), int(seed), *case)
