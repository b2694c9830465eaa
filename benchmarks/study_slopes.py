"""Error of a study's equation for e_n over the processor time of its designs, with slopes and without.

Run from the root: ``python benchmarks/study_slopes.py [three|five] [SEEDS]``; three factors are those of the
paper. Every design has the same 30 held-out ones, whose time is not counted. Latin hypercubes are drawn
with several seeds; their median is shown. A quarter of an hour on two cores.
"""

import multiprocessing
import os
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.study.response_fits import fit_study
from fem.responses import ThrowResponses
from geometry.mesh import keep_solids
from paper_study import HELD_OUT, THROW
from regression.plans.designs import RUN_STREAM, DesignChoice, space_filling_points, values_at
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import RUN, Outcome
from regression.runs.study_table import study_table
from regression.runs.workers import ONE_THREAD, evaluate_design

RESPONSE = "axial_compliance_pinned"
# Errors for which the cheapest designs are compared.
WANTED = (0.014, 0.007, 0.0035)
BOXES = {
    "three": {
        "web_width": (0.27, 0.33),
        "web_thickness": (0.038, 0.098),
        "pin_length": (0.12, 0.158),
    },
    "five": {
        "web_width": (0.27, 0.33),
        "web_thickness": (0.038, 0.098),
        "pin_length": (0.12, 0.158),
        "crank_radius": (0.155, 0.185),
        "pin_diameter": (0.165, 0.195),
    },
}
# Runs of Latin hypercubes without slopes and with them.
RUNS = {
    "three": ((12, 16, 20, 24, 28), (4, 5, 6, 7, 8, 10)),
    "five": ((48, 56, 64, 72, 80), (8, 10, 12, 14, 18)),
}
# Others: levels of each factor, or "central composite", "box-behnken".
FIXED = {
    "three": {"3 x 3 x 3": (3, 3, 3), "3 x 4 x 3, Chebyshev": (3, 4, 3), "central composite": None,
              "box-behnken": None, "2 x 2 x 2": (2, 2, 2)},
    "five": {"central composite": None, "box-behnken": None},
}  # fmt: skip


def plans(box: str, seeds: int) -> Iterator[tuple[str, StudyPlan]]:
    """Iterate over the plans, with what they are called."""
    ends = BOXES[box]
    ranges = tuple(Factor(name, "m", *end) for name, end in ends.items())
    plain = StudyPlan(THROW, ranges, held_out=HELD_OUT)
    for name, levels in FIXED[box].items():
        if levels is None:
            yield name, replace(plain, design=DesignChoice(name))
            continue
        spacings = ["log chebyshev" if number == 4 else "even" for number in levels]
        factors = [
            Factor.spread(factor, "m", *end, number, spacing)
            for (factor, end), number, spacing in zip(ends.items(), levels, spacings, strict=True)
        ]
        yield name, replace(plain, factors=tuple(factors), slopes=levels == (2, 2, 2))
    for slopes, numbers in zip((False, True), RUNS[box], strict=True):
        for number in numbers:
            for seed in range(1, seeds + 1):
                points = space_filling_points(ranges, "latin hypercube", number, (seed, RUN_STREAM))
                rows = tuple(map(tuple, values_at(ranges, points).tolist()))
                design = DesignChoice("file", rows=rows)
                yield f"Latin hypercube, {number}", replace(plain, design=design, slopes=slopes)


def timed(inputs: dict[str, Any]) -> tuple[ThrowResponses, float]:
    """Evaluate a design, and take the processor's time."""
    start = time.process_time()
    found = evaluate_design(inputs)
    return found, time.process_time() - start


def error_and_seconds(
    plan: StudyPlan, known: dict[str, tuple[ThrowResponses, float]]
) -> tuple[float, float]:
    """Return the largest held-out error of the chosen equation, and the time of its runs [s]."""
    outcomes, seconds = {}, 0.0
    for design in plan.planned.designs:
        found, taken = known[design.key]
        seconds += taken if design.role == RUN else 0.0
        outcomes[design.key] = Outcome(
            design.key,
            design.inputs,
            {RESPONSE: found.values[RESPONSE]},
            None,
            taken,
            errors={RESPONSE: found.errors[RESPONSE]},
            slopes={name: over for name, over in found.slopes.items() if name == RESPONSE},
            slope_errors=found.slope_errors,
        )
    table = study_table(plan, plan.planned.designs, outcomes)
    chosen = fit_study(table)["axial_compliance"].chosen
    assert chosen.largest_heldout_error is not None
    return chosen.largest_heldout_error, seconds


def main(box: str = "three", seeds: str = "3") -> None:
    made = list(plans(box, int(seeds)))
    needed = {design.key: design.inputs for _, plan in made for design in plan.planned.designs}
    print(f"{len(needed)} designs", flush=True)
    os.environ |= ONE_THREAD
    started = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, started, initializer=keep_solids) as pool:
        # In any order, so that a busy machine slows all designs alike.
        order = np.random.default_rng(1).permutation(list(needed)).tolist()
        known = dict(zip(order, pool.map(timed, map(needed.__getitem__, order)), strict=True))
    by_name: dict[tuple[str, bool, int], list[tuple[float, float]]] = {}
    for name, plan in made:
        runs = sum(design.role == RUN for design in plan.planned.designs)
        by_name.setdefault((name, plan.slopes, runs), []).append(error_and_seconds(plan, known))
    print(
        f"{'design':28}{'slopes':>7}{'runs':>6}{'CPU s':>8}{'largest held-out error of e_n in %':>40}"
    )
    medians: dict[bool, list[tuple[float, float]]] = {False: [], True: []}
    for (name, slopes, runs), found in by_name.items():
        errors: NDArray[np.float64] = np.array([error for error, _ in found])
        seconds = float(np.median([taken for _, taken in found]))
        medians[slopes].append((float(np.median(errors)), seconds))
        listed = ", ".join(f"{100.0 * error:.2f}" for error in errors)
        text = f"{100.0 * np.median(errors):.2f} ({listed})"
        print(f"{name:28}{'yes' if slopes else 'no':>7}{runs:6}{seconds:8.1f}{text:>40}")
    each = {
        slopes: np.median(
            [known[key][1] for key, one in needed.items() if ("slopes" in one) == slopes]
        )
        for slopes in (False, True)
    }
    print(f"one design: {each[False]:.2f} s, with slopes {each[True]:.2f} s")
    for wanted in WANTED:
        plain, sloped = (
            min((taken for error, taken in medians[slopes] if error <= wanted), default=np.inf)
            for slopes in (False, True)
        )
        print(
            f"cheapest to {100.0 * wanted:.3g} %: {plain:.1f} s without, {sloped:.1f} s with slopes, "
            f"{plain / sloped:.2f} times"
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
