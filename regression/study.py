"""A study: designs over ranges of throw dimensions, computed, stored, and read back as a table."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.material import STEEL, Material
from geometry.errors import InputError
from geometry.model import field_extra
from geometry.throw import CrankThrow
from regression.designs import full_factorial, latin_hypercube
from regression.store import Outcome, ResultStore, content_key
from regression.workers import TIME_LIMIT, run_designs

# Raise when a change of the model changes results: stored results of older versions are then not used.
MODEL_VERSION = 3
RUN, HELD_OUT = "run", "held out"
# The dimensions of a throw that can vary: the numbers among its fields.
FACTORS = tuple(
    n for n, info in CrankThrow.model_fields.items() if field_extra(info, "unit") == "m"
)


@dataclass(frozen=True)
class StudyPlan:
    """What to compute: a base throw, levels of some of its dimensions, and held-out designs.

    Attributes
    ----------
    throw : CrankThrow
        Supplies all dimensions that are not factors.
    levels : mapping
        Levels [SI] by throw field; all combinations are run and fitted.
    held_out : int
        Number of further designs, spread over the box by a Latin hypercube, that are run and kept
        out of the fit: the fit is judged by them.
    seed : int
        Of the Latin hypercube.
    material : Material
    accuracy : float
        Relative accuracy of each design's axial compliance.
    """

    throw: CrankThrow
    levels: Mapping[str, tuple[float, ...]]
    held_out: int = 8
    seed: int = 1
    material: Material = STEEL
    accuracy: float = 0.01

    def __post_init__(self) -> None:
        for name, levels in self.levels.items():
            if name not in FACTORS:
                raise InputError(
                    f"study.factors.{name}: unknown throw dimension; allowed are {', '.join(FACTORS)}."
                )
            if len(set(levels)) < 2:
                raise InputError(
                    f"study.factors.{name}: given {len(set(levels))} level; allowed are two or more "
                    "different ones, three for a quadratic equation."
                )
        if not self.levels:
            raise InputError("study.factors: none given; at least one throw dimension must vary.")
        if self.held_out < 1:
            raise InputError(
                f"study.held_out: given {self.held_out}; allowed is 1 or more, because the error between "
                "the levels cannot be seen without held-out designs."
            )

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of the varied dimensions."""
        return tuple(self.levels)

    def as_record(self) -> dict[str, Any]:
        """Everything that identifies the study, as JSON content in SI units."""
        return {
            "throw": self.throw.model_dump(mode="json"),
            "material": self.material.model_dump(),
            # A list, because the order of the factors decides which designs are held out.
            "levels": [[name, list(levels)] for name, levels in self.levels.items()],
            "held_out": self.held_out,
            "seed": self.seed,
            "accuracy": self.accuracy,
            "model_version": MODEL_VERSION,
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "StudyPlan":
        """Rebuild a plan from `as_record`."""
        return cls(
            throw=CrankThrow(**record["throw"]),
            levels={name: tuple(levels) for name, levels in record["levels"]},
            held_out=record["held_out"],
            seed=record["seed"],
            material=Material(**record["material"]),
            accuracy=record["accuracy"],
        )

    @property
    def key(self) -> str:
        """Key of the study: changes with anything that changes its results."""
        return content_key(self.as_record())


@dataclass(frozen=True)
class PlannedDesign:
    """One design of a study: its role, the values of the factors, its inputs and their key."""

    role: str
    values: tuple[float, ...]
    inputs: dict[str, Any]
    key: str


def plan_designs(plan: StudyPlan) -> tuple[PlannedDesign, ...]:
    """List the designs of a study: the runs, then the held-out ones.

    Raises
    ------
    InputError
        If a combination of levels is no throw that can be built; the message names it.
    """
    ranges = {name: (min(levels), max(levels)) for name, levels in plan.levels.items()}
    runs = full_factorial(plan.levels).runs
    held_out = latin_hypercube(ranges, plan.held_out, plan.seed).runs
    return tuple(
        _planned(plan, role, values)
        for role, table in ((RUN, runs), (HELD_OUT, held_out))
        for values in table
    )


def _planned(plan: StudyPlan, role: str, values: NDArray[np.float64]) -> PlannedDesign:
    changes = {name: float(value) for name, value in zip(plan.factors, values, strict=True)}
    try:
        throw = CrankThrow(**(plan.throw.model_dump(mode="json") | changes))
    except InputError as error:
        raise InputError(f"study.factors: one of the designs cannot be built: {error}") from None
    inputs = {
        "throw": throw.model_dump(mode="json"),
        "material": plan.material.model_dump(),
        "accuracy": plan.accuracy,
    }
    return PlannedDesign(
        role,
        tuple(changes.values()),
        inputs,
        content_key(inputs | {"model_version": MODEL_VERSION}),
    )


@dataclass(frozen=True)
class StudyTable:
    """Results of a study as arrays.

    Attributes
    ----------
    plan : StudyPlan
    values : (n, k) array
        Factor values [SI] of the designs that have a result.
    held_out : (n,) array of bool
        Which of them are kept out of fits.
    responses : dict
        Response name to (n,) array [SI].
    failures : tuple of (role, values, reason)
        Designs without a result.
    computed : int
        Designs computed now, not taken from the store.
    """

    plan: StudyPlan
    values: NDArray[np.float64]
    held_out: NDArray[np.bool_]
    responses: dict[str, NDArray[np.float64]]
    failures: tuple[tuple[str, tuple[float, ...], str], ...]
    computed: int


Progress = Callable[[int, int, Outcome | None], None]


def check_workers(workers: int) -> None:
    """Refuse an impossible number of worker processes.

    Raises
    ------
    InputError
    """
    if not 1 <= workers <= 256:
        raise InputError(f"workers: given {workers}; allowed is 1 to 256 processes.")


def run_plan(
    plan: StudyPlan,
    store: str | Path,
    workers: int = 2,
    progress: Progress | None = None,
) -> StudyTable:
    """Compute what a study still lacks, and return all of it.

    Parameters
    ----------
    plan : StudyPlan
    store : path
        SQLite file. Finished designs found there are not computed again; each new one is on disk as
        soon as it arrives, so an interrupted study continues where it stopped.
    workers : int
        Worker processes.
    progress : callable, optional
        Called with (finished, total, newest outcome or None).

    Raises
    ------
    InputError
        If the plan, the store or the number of workers is unusable.
    """
    check_workers(workers)
    designs = plan_designs(plan)
    unique = {design.key: design.inputs for design in designs}
    with ResultStore(store) as results:
        results.register_study(plan.key, plan.as_record(), [(d.role, d.key) for d in designs])
        known = {k: found for k, found in results.outcomes(unique).items() if not found.lost}
        finished = len(known)
        if progress:
            progress(finished, len(unique), None)

        def keep(outcome: Outcome) -> None:
            nonlocal finished
            results.record(outcome)
            finished += 1
            if progress:
                progress(finished, len(unique), outcome)

        missing = [(key, inputs) for key, inputs in unique.items() if key not in known]
        # A finer mesh may take longer before its worker counts as hanging.
        run_designs(missing, keep, workers, TIME_LIMIT * max(1.0, 0.01 / plan.accuracy))
        return _table(plan, designs, results.outcomes(unique), len(missing))


def read_study(store: str | Path, study: str | None = None) -> StudyTable:
    """Read a study's results from its store without computing anything.

    Parameters
    ----------
    store : path
    study : str, optional
        Its key or the first characters of it; needed only if the store holds several studies.

    Raises
    ------
    InputError
        If the store is missing or empty, or holds several studies and none is named.
    """
    if not Path(store).is_file():
        raise InputError(f"store: given {str(store)!r}; there is no such file.")
    with ResultStore(store, readonly=True) as results:
        plans = {k: p for k, p in results.studies().items() if k.startswith(study or "")}
        if len(plans) != 1:
            named = "none named" if study is None else f"given {study!r}"
            held = f"{len(plans)} such studies ({', '.join(plans)})" if plans else "no such study"
            raise InputError(
                f"study: {named}; {store} holds {held}; name one by the first characters of its key."
            )
        plan = StudyPlan.from_record(next(iter(plans.values())))
        designs = plan_designs(plan)
        return _table(plan, designs, results.outcomes({d.key for d in designs}), 0)


def _table(
    plan: StudyPlan,
    designs: Iterable[PlannedDesign],
    outcomes: Mapping[str, Outcome],
    computed: int,
) -> StudyTable:
    good, failures = [], []
    for design in designs:
        outcome = outcomes.get(design.key)
        if outcome is not None and outcome.responses is not None:
            good.append((design, outcome.responses))
        else:
            reason = "not computed yet" if outcome is None else str(outcome.reason)
            failures.append((design.role, design.values, reason))
    names = good[0][1].keys() if good else ()
    return StudyTable(
        plan=plan,
        values=np.array([design.values for design, _ in good]).reshape(
            len(good), len(plan.factors)
        ),
        held_out=np.array([design.role == HELD_OUT for design, _ in good], dtype=bool),
        responses={name: np.array([found[name] for _, found in good]) for name in names},
        failures=tuple(failures),
        computed=computed,
    )
