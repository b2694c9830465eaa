"""Whether a model's band holds: 100 fresh random throws against the bands of two studies' models.

Run by hand: ``python tests/campaigns/model_coverage.py STORE.sqlite [WORKERS]`` (20 minutes with an empty
store on two cores; it continues where it was stopped). The model is made of the study alone; the throws
are drawn uniformly over the study's ranges and constraints, and computed with the study's accuracy.

Counted is how many values by finite elements lie in the band told, and in the part of it that is the
equation's error alone. The latter is the harder one: what discretization leaves is alike for the throws of
a study and the fresh ones, so that the part for it is room to spare here. It is what the band needs to hold
the truth: some of the throws are computed again, four times as accurate.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array
from crankfem import load_throw
from crankfem.analyses.study.studies import StudyResult, fitted
from regression.models.response_query import ErrorBand, error_band
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.runs.study import run_plan
from regression.runs.study_table import StudyTable

FRESH, FINER = 100, 20
SEEDS = (20_261, 4)
ACCURACY = 0.02


def paper_box() -> StudyPlan:
    """The paper's box with four levels of h: 36 runs of the throw of 6 ChN 25/34."""
    factors = (
        Factor.spread("web_width", "m", 0.270, 0.330, 3, "even"),
        Factor.spread("web_thickness", "m", 0.038, 0.098, 4, "log chebyshev"),
        Factor.spread("pin_length", "m", 0.120, 0.158, 3, "even"),
    )
    return StudyPlan(load_throw("6chn25-34")[0], factors, held_out=8, accuracy=ACCURACY)


def six_factors() -> StudyPlan:
    """Six dimensions of the throw of YaMZ-5340 in a Latin hypercube of 80 runs, with a constraint."""
    ranges = {
        "web_width": (0.090, 0.115),
        "web_thickness": (0.020, 0.032),
        "pin_length": (0.032, 0.042),
        "main_journal_length": (0.028, 0.040),
        "main_journal_diameter": (0.072, 0.086),
        "pin_diameter": (0.064, 0.076),
    }
    return StudyPlan(
        load_throw("yamz-5340")[0],
        tuple(Factor(name, "m", *ends) for name, ends in ranges.items()),
        DesignChoice("latin hypercube", runs=80),
        constraints=("web_thickness >= 0.32 * pin_diameter",),
        held_out=12,
        accuracy=ACCURACY,
    )


def fresh(plan: StudyPlan, seed: int, count: int = FRESH, finer: float = 1.0) -> StudyPlan:
    """The same study with random runs that can be built and break no constraint."""
    draw = np.random.default_rng(seed)
    ends = np.array([(factor.lowest, factor.highest) for factor in plan.factors])
    values = draw.uniform(*ends.T, (10 * FRESH, len(ends)))
    made = plan.variants().at(values)
    possible = [tuple(row) for row, one in zip(values.tolist(), made, strict=True) if one.throw]
    runs = DesignChoice("file", rows=tuple(possible[:count]))
    return replace(plan, design=runs, held_out=1, accuracy=plan.accuracy / finer)


def ratios(study: StudyResult, table: StudyTable, name: str) -> Array:
    """Finite elements by equation, of one response at the table's runs."""
    runs = ~table.held_out
    asked = {factor: table.values[runs, i] for i, factor in enumerate(table.plan.names)}
    truth = table.responses[study.fits[name].column][runs]
    return truth / np.asarray(study.model.value(name, strict=True, **asked))


def kept(band: ErrorBand, ratio: Array) -> int:
    """How many values lie in a band."""
    return int(np.sum((band.lower <= ratio) & (ratio <= (band.upper or np.inf))))


def main() -> None:
    store = Path(sys.argv[1])
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 2

    def progress(done: int, total: int, _: object) -> None:
        print(f"\r{done} of {total}", end="", file=sys.stderr, flush=True)

    for plan in (paper_box(), six_factors()):
        study = fitted(run_plan(plan, store, workers, progress))
        tables = [run_plan(fresh(plan, seed), store, workers, progress) for seed in SEEDS]
        plan_finer = fresh(plan, SEEDS[0], FINER, finer=4.0)
        finer = run_plan(plan_finer, store, workers, progress)
        print(f"\n{plan.throw.crank_radius * 1e3:.0f} mm radius; of {FRESH} fresh throws, twice:")
        print("| response | form | equation's part [%] | holds | width [%] | holds | finer |")
        print("|---|---|---|---|---|---|---|")
        for name, response in study.model.responses.items():
            told = error_band(response)
            alone = error_band(response.model_copy(update={"largest_fe_error": 0.0}))
            found = [ratios(study, table, name) for table in tables]
            equations, bands = (
                " and ".join(str(kept(band, ratio)) for ratio in found) for band in (alone, told)
            )
            width = 100.0 * ((told.upper or np.inf) - told.lower)
            part = 100.0 * (1.0 / alone.lower - 1.0)
            print(
                f"| {name} | {response.form} | {part:.3g} | {equations} | {width:.3g} | {bands} "
                f"| {kept(told, ratios(study, finer, name))} |"
            )


if __name__ == "__main__":
    main()
