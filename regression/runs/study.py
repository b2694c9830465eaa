"""Run a study, or continue it; read one back; import results from elsewhere."""

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any, Unpack

import numpy as np

from crankbase.array_checks import Array
from crankbase.calls import GIGABYTE
from crankbase.choices import is_whole_within
from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankbase.memory import check_memory, free_memory
from crankbase.results import Quantity, Result, result
from crankbase.sentences import kept
from fem.analysis import predicted_unknowns, solving_memory
from geometry.mesh import MESHING_MEMORY
from geometry.mesher import expected_unknowns
from geometry.throw import CrankThrow
from regression.plans.moved_meshes import NEW_MESH
from regression.plans.plan import (
    MODEL_VERSION,
    PlannedDesign,
    PlannedStudy,
    StudyPlan,
    planned_design,
    with_meshes,
)
from regression.records import MEASURED, MOVED, RUN, ExtraRow, Outcome, content_key
from regression.runs.exchange import StoreResults, factor_value, read_rows, read_store
from regression.runs.reference_meshes import ReferenceMeshes
from regression.runs.store import (
    SCHEMA_VERSION,
    Claims,
    ResultStore,
    check_place,
    connect_readonly,
    damaged_rows_warning,
    is_database,
    is_ours,
    missing_parts,
    schema_version,
)
from regression.runs.study_table import DONE, StudyTable, study_table
from regression.runs.workers import AskedLimits, design_limits, run_designs
from regression.throw_values import SAME

# Damaged rows that are told; JSON has all.
MOST_ROWS = 10
# Designs that are looked at, spread over all.
LOOKED_AT = 30
# The finest mesh for stresses at fillets has up to so many times the unknowns of an ordinary one.
STRESS_GROWTH = 4.0
# Of the mesher, which is loaded in the same process [byte].
MESHER = 4e7


def worker_memory(designs: Sequence[Mapping[str, Any]]) -> float:
    """Predict the resident memory of a worker that computes designs, by their inputs [byte]."""
    step = max(1, len(designs) // LOOKED_AT)
    most = 0.0
    for inputs in designs[::step]:
        throw = CrankThrow(**inputs["throw"])
        unknowns = predicted_unknowns(throw, inputs["accuracy"])
        most = max(most, solving_memory(throw, unknowns) + MESHING_MEMORY * unknowns)
        if inputs["stresses"]:
            unknowns = STRESS_GROWTH * expected_unknowns(throw, 1.0)
            taken = solving_memory(throw, unknowns, stresses=True) + MESHING_MEMORY * unknowns
            most = max(most, taken)
    return most + MESHER


def check_study_memory(designs: Sequence[Mapping[str, Any]], workers: int) -> None:
    """Refuse workers that would need more memory together than is free (`NotEnoughMemoryError`)."""
    if not designs:
        return
    working = min(workers, len(designs))
    each = worker_memory(designs)
    fit = int(free_memory() // each)
    check_memory(
        working * each,
        f"workers: given {workers}, of which {working} take about {each / GIGABYTE:.2g} GB each, together",
        f"ask for at most {fit}" if fit else "ask for a coarser accuracy, or free memory",
    )


def add_runs(plan: StudyPlan, store: str | Path, values: Array) -> None:
    """Add runs to those of a study in the store; the next run computes them.

    `values` (n, k) are of the factors [SI], of a choice the label's index; throws can be built of them.
    """
    designs = with_meshes(plan, plan.planned.designs, tuple(_added(plan, values)))
    listed = [_as_listed(plan, design) for design in designs if design.added]
    with ResultStore(store) as results:
        results.add_designs(plan.key, listed)


def known_designs(store: str | Path, plan: StudyPlan) -> PlannedStudy:
    """Return a plan's designs with those that were added in a store, if there is one."""
    if not Path(store).is_file():
        return plan.planned
    with ResultStore(store, readonly=True) as results:
        return with_added(results, plan)


def _added(plan: StudyPlan, values: Array) -> list[PlannedDesign]:
    made = plan.variants().at(values)
    return [
        replace(planned_design(plan, RUN, tuple(row), variant.throw), added=True)
        for row, variant in zip(values.tolist(), made, strict=True)
        if variant.throw is not None
    ]


def with_added(results: ResultStore, plan: StudyPlan) -> PlannedStudy:
    """Return a plan's designs, and behind them those that were added in the store."""
    rows = [
        settings
        for shown in results.added_designs(plan.key)
        if (settings := _values(plan, shown)) is not None
    ]
    added = tuple(_added(plan, np.array(rows).reshape(-1, len(plan.factors))))
    if not added:
        return plan.planned
    return replace(plan.planned, designs=with_meshes(plan, plan.planned.designs, added))


def _values(plan: StudyPlan, shown: Mapping[str, Any]) -> tuple[float, ...] | None:
    """Read the factor values of a registered design; None if they are damaged."""
    try:
        return tuple(factor_value(factor, shown[factor.name]) for factor in plan.factors)
    except (KeyError, TypeError, ValueError):
        return None


def _as_listed(
    plan: StudyPlan, design: PlannedDesign
) -> tuple[str, str, Mapping[str, float | str]]:
    """Role, key and factor values of a design, choices by their labels."""
    values = zip(plan.factors, design.values, strict=True)
    return (
        design.role,
        design.key,
        {factor.name: factor.setting(value) for factor, value in values},
    )


def register_designs(results: ResultStore, plan: StudyPlan, planned: PlannedStudy) -> None:
    """Record the designs of a study."""
    listed = [_as_listed(plan, design) for design in planned.designs if not design.added]
    results.register_study(plan.key, plan.as_record(), listed)


def is_list_sound(results: ResultStore, plan: StudyPlan) -> bool:
    """Whether a store lists the designs of a study as they were registered."""
    listed = [_as_listed(plan, design) for design in registered_designs(results, plan).designs]
    return listed == list(results.study_designs(plan.key))


def registered_designs(results: ResultStore, plan: StudyPlan) -> PlannedStudy:
    """Return a study with its designs as stored.

    They are those of the plan and those added to it, unless a later release of numpy or scipy draws
    other points.
    """
    planned = with_added(results, plan)
    registered = results.study_designs(plan.key)
    if not registered or [key for _, key, _ in registered] == [d.key for d in planned.designs]:
        return planned
    values = [_values(plan, shown) for _, _, shown in registered]
    sound = [row for row in values if row is not None]
    if len(sound) < len(values):  # the list is damaged
        return planned
    designs = []
    made = plan.variants().at(np.array(sound))
    first_added = len(registered) - sum(design.added for design in planned.designs)
    for place, (row, variant) in enumerate(zip(sound, made, strict=True)):
        if variant.throw is None:  # it was one when the study was registered
            return planned
        design = planned_design(plan, registered[place][0], row, variant.throw)
        designs.append(replace(design, added=place >= first_added))
    first, last = (tuple(d for d in designs if d.added == added) for added in (False, True))
    # What was excluded of the points drawn then is not known.
    return replace(planned, designs=with_meshes(plan, first, last), excluded=())


Progress = Callable[[int, int, Outcome | None], None]
Note = Callable[[str], None]

# The first version of the finite element model whose results are corrected for discretization.
CORRECTED_SINCE = 5


def check_workers(workers: int) -> None:
    """Refuse an impossible number of worker processes (`InputError`)."""
    if not is_whole_within(workers, 1, 256):
        raise InputError(
            f"workers: given {workers!r}; allowed is 1 to 256 processes, as a whole number."
        )


def run_plan(
    plan: StudyPlan,
    store: str | Path,
    workers: int = 2,
    progress: Progress | None = None,
    *,
    dask: str | None = None,
    note: Note | None = None,
    **asked: Unpack[AskedLimits],
) -> StudyTable:
    """Compute the missing results of a study, and return all of it.

    Parameters
    ----------
    store : path
        SQLite file. Finished designs are not computed again; each new one is on disk as
        soon as it arrives, so an interrupted study continues where it stopped.
    workers : int
        Worker processes on this machine.
    progress : callable, optional
        Called with (finished, total, newest outcome or None).
    dask : str, optional
        Address of a Dask scheduler, whose workers then compute.
    time_limit : float, optional
        Time limit of one design [s]; 300 at 1 % accuracy by default.
    memory_limit : float, optional
        Memory limit of a worker process [bytes]; none by default.
    note : callable, optional
        Called with notes for the user.

    Raises
    ------
    InputError
        If the plan, the store, a limit, the cluster or the number of workers is unusable, or the workers
        would need more memory than is free.
    MissingLibraryError
        If a cluster is used without the required package.
    StudyStoppedError
        If the store can no longer be written, or the cluster is lost; finished designs are kept.
    """
    check_workers(workers)
    note = note or (lambda _: None)
    limits = design_limits(plan.accuracy, **asked)
    if dask is not None:  # refused even if nothing is left to compute
        from regression.runs.cluster import DaskCluster, check_address, run_on_cluster

        check_address(dask)
    drawn = plan.planned  # a study that cannot be planned leaves no store behind
    with ResultStore(store) as results, Claims(results.path) as claims:
        register_designs(results, plan, drawn)
        planned = with_added(results, plan)
        unique = planned.tasks
        known = {k: kept for k, kept in results.outcomes(unique).items() if not kept.lost}
        same = _of_same_meshes(known, unique)
        stale = {key: kept for key, kept in known.items() if key not in same}
        known = same
        if results.damaged:
            note(
                f"{damaged_rows_warning(results.damaged, store)}; their designs are computed again."
            )
        finished, computed, shared = len(known), 0, False
        if progress:
            progress(finished, len(unique), None)

        def count(outcome: Outcome) -> None:
            nonlocal finished
            claims.release(outcome.key)
            finished += 1
            if progress:
                progress(finished, len(unique), outcome)

        def keep(outcome: Outcome) -> None:
            nonlocal computed
            results.record(outcome, MODEL_VERSION)
            computed += 1
            count(outcome)

        def claim(key: str) -> bool | None:
            nonlocal shared
            if not claims.take(key):
                if not shared:
                    note(
                        f"another program computes designs of this study in {store}: they are shared."
                    )
                shared = True
                return False
            stored = results.outcomes([key]).get(key)
            if stored is None or stored.lost or stored == stale.get(key):
                return True
            count(stored)
            return None

        missing = [(key, inputs) for key, inputs in unique.items() if key not in known]
        older = results.older_results(MODEL_VERSION)
        if missing and older:
            note(
                f"{store}: {sum(older.values())} results are of model version "
                f"{', '.join(map(str, older))}, not {MODEL_VERSION} (before {CORRECTED_SINCE} they were not "
                "corrected for discretization); results of different models must not be mixed, so designs "
                "are computed anew, and the old results stay in the file."
            )
        if missing and dask is not None:
            with closing(DaskCluster(dask)) as cluster:
                run_on_cluster(missing, keep, cluster, limits, note, claim)
        else:
            check_study_memory([inputs for _, inputs in missing], workers)
            run_designs(missing, keep, workers, limits, claim)
        table = _table(results, plan, planned, computed)
        if plan.mesh != NEW_MESH:
            rows = zip(planned.designs, table.rows, strict=False)
            results.keep_scaled(
                plan.key,
                {
                    design.key: (row.responses, row.errors)
                    for design, row in rows
                    if row.status == DONE and MOVED in design.inputs
                },
            )
        return table


def read_study(store: str | Path, study: str | None = None) -> StudyTable:
    """Read a study's results from its store without computing anything.

    The study's key, or the first characters of it, is required only if the store has several.

    Raises
    ------
    InputError
        If the store is missing or empty, has results of another model version only, or has
        several studies and none is named.
    """
    with ResultStore(store, readonly=True) as results:
        recorded = results.studies()
        # A study's key is the hash of its plan.
        held = {k: p for k, p in recorded.items() if p is not None and content_key(p) == k}
        broken = [k for k in recorded if k not in held and k.startswith(study or "")]
        named = {k: p for k, p in held.items() if k.startswith(study or "")}
        if broken and not named:
            raise InputError(
                f"study: the plan of {broken[0]} in {results.path} is damaged; allowed is one as it was "
                "written, so run the study again from its file: its finished designs are kept."
            )
        plans = {k: p for k, p in named.items() if p.get("model_version") == MODEL_VERSION}
        if named and not plans:
            raise InputError(
                f"store: given {str(store)!r}, whose studies are of model version "
                f"{next(iter(named.values())).get('model_version')}; allowed is {MODEL_VERSION}, because "
                "results of different models must not be mixed, so run the study again; the old results "
                "stay in the file."
            )
        if len(plans) != 1:
            raise _study_choice_text(results, study, plans or held)
        plan = StudyPlan.from_record(next(iter(plans.values())))
        return _table(results, plan, registered_designs(results, plan), 0)


def _study_choice_text(
    results: ResultStore, study: str | None, plans: Mapping[str, Mapping[str, Any]]
) -> InputError:
    """List the studies of a store, so that one of them can be named."""
    chosen = "none named" if study is None else f"given {study!r}"
    usable = {k: p for k, p in plans.items() if p.get("model_version") == MODEL_VERSION}
    if not usable:
        return InputError(
            f"study: {chosen}; {results.path} holds no study yet; allowed is a store in which one was run."
        )
    digits = next(n for n in range(6, 25) if len({key[:n] for key in usable}) == len(usable))
    described = []
    for key, record in usable.items():
        plan = StudyPlan.from_record(record)
        roles = [role for role, _, _ in results.study_designs(plan.key)]
        factors = [
            f"{factor.name} {' or '.join(factor.labels) or kept(factor.range_text)}"
            for factor in plan.factors
        ]
        runs = f"{plan.design.kind} of {roles.count(RUN)} runs"
        described.append(f"{key[:digits]} ({runs}: {', '.join(factors)})")
    number = "1 study" if len(usable) == 1 else f"{len(usable)} studies"
    return InputError(
        f"study: {chosen}; {results.path} holds {number}: {'; '.join(described)}; name one of "
        "them by the first characters of its key."
    )


@result("designs", "rows", "left_out", eq=True)
class ImportSummary(Result):
    """Result of an import.

    Attributes
    ----------
    designs : int
        Designs of the study that no longer need to be computed.
    rows : int
        New rows in addition to the study's designs.
    left_out : int
        Designs of the other store that do not belong to the study.
    coinciding : int
        Rows at the factor values of the study's own designs, which are computed anyway: the
        study's results have priority, and these rows are not used.
    damaged : str
        Skipped damaged parts of the other store; empty if none.
    """

    file: str
    designs: int
    rows: int
    left_out: int
    coinciding: int
    damaged: str

    def parts(self) -> Iterator[str]:
        """State what was imported."""
        left_out = f"; {self.left_out} do not belong to this study" if self.left_out else ""
        unused = (
            f"; {self.coinciding} at the study's own designs are not used"
            if self.coinciding
            else ""
        )
        yield (
            f"{self.file}: {self.designs} finished designs and {self.rows} further rows imported{left_out}"
            f"{unused}."
        )


def import_results(
    plan: StudyPlan, store: str | Path, file: str | Path, *, alone: bool = False
) -> ImportSummary:
    """Import earlier results or measured values into the store of a study.

    The file is a CSV table, or the store of another study. Designs of that store that are exactly the
    study's own count as computed; its other designs, and the rows of a table, are kept as separate rows
    that never replace a result of the study. `alone`: whether the study will not compute its designs;
    see `read_rows`.

    Raises
    ------
    InputError
        With line and column if the table cannot be used; if nothing in the store fits the study.
    """
    path = Path(file)
    if (entry := not_a_file(path)) is not None:
        raise InputError(f"import: given {str(path)!r}, which {entry}.")
    if not path.is_file():
        raise InputError(f"import: given {str(path)!r}; there is no such file.")
    planned = known_designs(store, plan)
    imported, damaged = StoreResults((), (), 0), ""
    if is_database(path):
        with ResultStore(path, readonly=True) as other:
            imported = read_store(other, plan, planned.tasks)
            damaged = damaged_rows_warning(other.damaged, path) if other.damaged else ""
    else:
        imported = replace(imported, rows=read_rows(path, plan, alone=alone))
    with ResultStore(store) as results:
        register_designs(results, plan, planned)
        known = results.outcomes(design.key for design in imported.finished)
        new = [d for d in imported.finished if d.key not in known or known[d.key].lost]
        for outcome in new:
            results.record(outcome, MODEL_VERSION)
        coinciding = _coinciding(results, planned, imported.rows, alone)
        added = results.add_extra_rows(plan.key, imported.rows)
        return ImportSummary(str(file), len(new), added, imported.left_out, coinciding, damaged)


def _coinciding(
    results: ResultStore, planned: PlannedStudy, rows: Iterable[ExtraRow], alone: bool
) -> int:
    """Count the computed rows at which the study has, or without `alone` will have, its own result."""
    outcomes = results.outcomes(design.key for design in planned.designs)
    status = {key: outcome.status for key, outcome in outcomes.items()}
    others = {"failed", "lost", None} if alone else {"failed"}
    points = np.array([d.values for d in planned.designs if status.get(d.key) not in others])
    points = points.reshape(-1, len(planned.plan.factors))
    return sum(
        bool(np.isclose(points, row.values, rtol=SAME, atol=0.0).all(axis=1).any())
        for row in rows
        if row.role != MEASURED and row.values is not None
    )


def _of_same_meshes(
    known: Mapping[str, Outcome], wanted: Mapping[str, Mapping[str, Any]]
) -> dict[str, Outcome]:
    """Leave out outcomes of a mesh that what is missing of its class would not get: by another mesher."""
    waiting = {content_key(wanted[k][MOVED]) for k in wanted.keys() - known if MOVED in wanted[k]}
    references = ReferenceMeshes()
    return {
        key: outcome
        for key, outcome in known.items()
        if MOVED not in wanted[key]
        or content_key(wanted[key][MOVED]) not in waiting
        or outcome.mesh.get("reference", "") in ("", references.digest(wanted[key]))
    }


def _table(
    results: ResultStore, plan: StudyPlan, planned: PlannedStudy, computed: int
) -> StudyTable:
    outcomes = results.outcomes(planned.tasks)
    extra = results.extra_rows(plan.key)
    return study_table(
        plan, planned.designs, outcomes, extra, planned.excluded, computed, results.damaged
    )


@result("study", "damaged", "designs", "missing", eq=True)
class StudyCheck(Result):
    """One study of a store, by its key, with the damage of its plan or list of designs if any.

    `designs` counts its designs, `missing` those without a result; None if the plan is damaged, or of
    another version of the finite element model.
    """

    study: str
    damaged: str | None = None
    designs: Annotated[int | None, Quantity("1")] = None
    missing: Annotated[int | None, Quantity("1")] = None

    @property
    def sentence(self) -> str:
        """State how many designs it has, or why that is unknown."""
        name = f"Study {self.study[:6]}"
        if self.designs is None:
            return (
                f"{name}: its plan is damaged; run it from its file, and its finished designs are used."
                if self.damaged
                else f"{name}: of another version of the finite element model."
            )
        text = f"{name}: {self.designs} designs, {self.missing} without a result"
        return f"{text}; {self.damaged} is damaged." if self.damaged else f"{text}."


@result("store", "sound", "file_damage", "designs", "studies", eq=True)
class StoreCheck(Result):
    """Result of a check of a store.

    Attributes
    ----------
    file_damage : str or None
        Why the file is unreliable; None if SQLite finds it sound.
    designs : dict
        "done", "failed" and "lost" to the number of sound rows.
    damaged_rows : dict
        Design, or position of an imported row, to the fault of its row.
    """

    store: str
    file_damage: str | None = None
    designs: Annotated[Mapping[str, int], Quantity("1")] = field(default_factory=dict)
    damaged_rows: Mapping[str, str] = field(default_factory=dict)
    studies: tuple[StudyCheck, ...] = ()

    @property
    def sound(self) -> Annotated[bool, Quantity()]:
        """Whether nothing is damaged."""
        return not (self.file_damage or self.damaged_rows or any(s.damaged for s in self.studies))

    def parts(self) -> Iterator[str]:
        """State what the store holds, and what is damaged."""
        if self.file_damage:
            yield f"SQLite cannot trust the file: {self.file_damage}."
            return
        counts = ", ".join(
            f"{number} {status}" for status, number in self.designs.items() if number
        )
        rows = f"{len(self.damaged_rows)} damaged" if self.damaged_rows else "no row damaged"
        yield f"{self.store}: {counts or 'no design computed'}; {rows}."
        for place, why in list(self.damaged_rows.items())[:MOST_ROWS]:
            yield f"- {place}: {why}."
        if len(self.damaged_rows) > MOST_ROWS:
            yield f"... and {len(self.damaged_rows) - MOST_ROWS} more; --json has them all."
        for study in self.studies:
            yield study.sentence
        if not self.studies:
            yield (
                f"It holds no study: run one from its file, crankfem doe STUDY.toml --store {self.store}."
            )


def check_store(path: str | Path) -> StoreCheck:
    """Check a result store: SQLite's integrity check, every row's checksum, every study's plan.

    Raises
    ------
    InputError
        If there is no such file, or it is no result store, or of another layout.
    StudyStoppedError
        If it cannot be opened now.
    """
    file = Path(path)
    check_place(file, readonly=True)
    why = _file_damage(file)
    if why and is_ours(file):
        return StoreCheck(str(path), why)
    with ResultStore(file, readonly=True) as store:
        status = {"done": 0, "failed": 0, "lost": 0}
        for outcome in store.every_outcome():
            status[outcome.status] += 1
        studies = tuple(_check_study(store, *known) for known in store.studies().items())
        store.extra_rows()
        return StoreCheck(str(path), why or None, status, dict(store.damaged), studies)


def _file_damage(path: Path) -> str:
    """State why SQLite finds a file unreliable; empty if it is sound, or not readable for another reason."""
    try:
        with closing(connect_readonly(path)) as connection:
            lines = [text for (text,) in connection.execute("PRAGMA integrity_check")]
            lacking = (
                missing_parts(connection) if schema_version(connection) == SCHEMA_VERSION else []
            )
    except UnicodeDecodeError:  # what SQLite says of it quotes damaged text
        return "the names of its tables cannot be read"
    except sqlite3.DatabaseError as error:
        return "" if isinstance(error, sqlite3.OperationalError) else str(error)
    if lines != ["ok"]:
        first = " ".join(lines[0].replace("*** in database main ***", "").split())
        return first + ("; and others" if len(lines) > 1 else "")
    return f"it has no {lacking[0]}" if lacking else ""


def _check_study(store: ResultStore, key: str, record: Mapping[str, object] | None) -> StudyCheck:
    if record is None or content_key(record) != key:
        return StudyCheck(key, "its plan")
    if record.get("model_version") != MODEL_VERSION:
        return StudyCheck(key)
    plan = StudyPlan.from_record(record)
    keys = {design.key for design in registered_designs(store, plan).designs}
    outcomes = store.outcomes(keys)
    finished = sum(not outcome.lost for outcome in outcomes.values())
    damaged = None if is_list_sound(store, plan) else "its list of designs"
    return StudyCheck(key, damaged, len(keys), len(keys) - finished)
