"""Held-out errors of e_n by a Gaussian process and by the best polynomial, with slopes and without.

Run from the root: ``python benchmarks/gaussian_process.py``. Ranges are so wide that journals and pin overlap
at one end and not at the other. Runs are the first of a Sobol sequence; of the 60 held-out designs, the same
for all, 20 judge the bands, which are then counted at the other 40. Five minutes on two cores.
"""

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from crankfem.analyses.study.fit_records import compliance_model
from crankfem.analyses.study.response_fits import fit_study
from fem.responses import ThrowResponses
from geometry.mesh import keep_solids
from paper_study import THROW
from regression.fits.forms import GAUSSIAN_PROCESS
from regression.plans.designs import RUN_STREAM, DesignChoice, space_filling_points, values_at
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import HELD_OUT, Outcome
from regression.runs.study_table import StudyTable, study_table
from regression.runs.workers import ONE_THREAD, evaluate_design

FACTORS = (
    Factor("crank_radius", "m", 0.13, 0.23),
    Factor("web_thickness", "m", 0.035, 0.1),
    Factor("pin_diameter", "m", 0.15, 0.20),
    Factor("web_width", "m", 0.24, 0.34),
)
RUNS, JUDGES, PROCESS = (12, 16, 24, 32, 64), 20, GAUSSIAN_PROCESS.name
Known = dict[tuple[float, ...], ThrowResponses]


def plan(number: int, slopes: bool = True) -> StudyPlan:
    """Return the study of so many runs; those that cannot be built are left out."""
    points = space_filling_points(FACTORS, "sobol", max(RUNS), (1, RUN_STREAM))[:number]
    design = DesignChoice("file", rows=tuple(map(tuple, values_at(FACTORS, points).tolist())))
    return StudyPlan(THROW, FACTORS, design, held_out=60, slopes=slopes)


def table(made: StudyPlan, known: Known, judges: int) -> StudyTable:
    """Return the results of a plan with some of its held-out designs."""
    held = [one for one in made.planned.designs if one.role == HELD_OUT][:judges]
    designs = [one for one in made.planned.designs if one.role != HELD_OUT] + held
    outcomes = {}
    for one in designs:
        found = known[one.values]
        over: dict[str, Any] = {"slopes": found.slopes, "slope_errors": found.slope_errors}
        outcomes[one.key] = Outcome(
            one.key,
            one.inputs,
            found.values,
            None,
            0.0,
            errors=found.errors,
            **(over if made.slopes else {}),
        )
    return study_table(made, tuple(designs), outcomes)


def shares_in_bands(made: StudyPlan, known: Known) -> list[float]:
    """Return, for each response, the share of designs not used at all that keep the process's own band."""
    fits = fit_study(table(made, known, JUDGES), PROCESS)
    model = compliance_model(table(made, known, JUDGES), fits, PROCESS)
    fresh = [one.values for one in made.planned.designs if one.role == HELD_OUT][JUDGES:]
    at = dict(zip(made.names, np.array(fresh).T, strict=True))
    shares = []
    for name, response in fits.items():
        alone = model.responses[name].model_copy(update={"largest_fe_error": 0.0})
        found = model.model_copy(update={"responses": {name: alone}}).lookups(name, **at)
        y = np.array([known[values].values[response.column] for values in fresh])
        shares.append(float(np.mean((found.lower <= y) & (y <= found.upper))))
    return shares


def main() -> None:
    designs = plan(max(RUNS)).planned.designs
    os.environ |= ONE_THREAD
    started = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, started, initializer=keep_solids) as pool:
        answers = pool.map(evaluate_design, [one.inputs for one in designs])
        known = dict(zip([one.values for one in designs], answers, strict=True))
    for slopes in (True, False):
        for number in RUNS:
            made = plan(number, slopes)
            whole = table(made, known, 60)
            fits = fit_study(whole, PROCESS)["axial_compliance"]
            process = fits.fit_named(PROCESS)
            best = min(
                (fit for fit in fits.fits if fit is not process),
                key=lambda fit: fit.largest_heldout_error or 0.0,
            )
            errors = "; ".join(
                f"{fit.form} {100.0 * (fit.largest_heldout_error or 0.0):.2f} "
                f"({100.0 * (fit.mean_heldout_error or 0.0):.2f}) %"
                for fit in (process, best)
            )
            shares = shares_in_bands(made, known)
            print(
                f"{process.runs} runs {'with' if slopes else 'without'} slopes: {errors}; in the bands "
                f"{100.0 * np.mean(shares):.1f} % of all responses, {100.0 * min(shares):.1f} % of the worst",
                flush=True,
            )


if __name__ == "__main__":
    main()
