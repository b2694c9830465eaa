"""The command doe with --check or --repair: whether a store is sound, and a sound one made of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands.options import Output
from crankfem.jobs.exit_codes import EXIT_INPUT

if TYPE_CHECKING:
    from crankfem.analyses.record import Record
    from regression.runs.store_check import StoreCheck, StudyCheck
    from regression.runs.store_repair import RebuiltStore

# Damaged rows that are shown; --json has all.
MOST_ROWS = 10
ENGINE_FILE, STORE = ".toml", Path("runs.sqlite")


def check_or_repair(
    given: str, store: Path, out: Output, *, repair: bool, options: dict[str, Any]
) -> None:
    """Check a store, and with `repair` make it sound and compute what is damaged or missing.

    Parameters
    ----------
    given : str
        A store, or a study file whose store is `store`.
    store : Path
    out : Output
    repair : bool
    options : dict
        Of `run_plan`.
    """
    from crankfem.files.engine.throw_file import load_study
    from regression.runs.store_check import check_store

    path, plans = Path(given), []
    if path.is_file() and path.suffix != ENGINE_FILE:
        if store != STORE:
            raise InputError(
                f"--store: given {store} together with the store {path}; allowed is one of them."
            )
    else:
        path, plans = store, [load_study(given)]
    found = check_store(path)
    rebuilt, computed = None, 0
    if repair:
        rebuilt, computed = _repaired(found, plans, out.quiet, options)
        found = check_store(path)
    if out.json:
        console.print_json(_record(found, rebuilt, computed))
    else:
        _print(found, rebuilt, computed, repaired=repair)
    if not found.sound:
        console.exit_by_verdict(
            f"Error: {path} is damaged; crankfem doe --repair {path} computes the damaged designs again.",
            EXIT_INPUT,
        )


def _repaired(
    found: "StoreCheck", plans: list[Any], quiet: bool, options: dict[str, Any]
) -> tuple["RebuiltStore | None", int]:
    """Make a store sound; return what was kept of the damaged one, and how many designs were computed."""
    from regression.runs.store_repair import rebuild_store
    from regression.runs.study import current_plans, run_plan

    rebuilt = None if found.sound else rebuild_store(found.path)
    computed = 0
    for plan in {plan.key: plan for plan in (*plans, *current_plans(found.path))}.values():
        with console.RunProgress(quiet) as progress:
            progress.step(f"Study {plan.key[:6]}")
            computed += run_plan(
                plan, found.path, progress=progress.design, note=progress.warn, **options
            ).computed
            progress.finish()
    return rebuilt, computed


def _record(found: "StoreCheck", rebuilt: "RebuiltStore | None", computed: int) -> "Record":
    return {
        "store": str(found.path),
        "sound": found.sound,
        "file_damage": found.file or None,
        "designs": dict(found.status),
        "damaged_rows": dict(found.damaged),
        "has_checksums": not found.without_checksums,
        "studies": [
            {
                "study": one.study,
                "damaged": one.damaged or None,
                "designs": one.designs,
                "missing": one.missing,
            }
            for one in found.studies
        ],
        "original": None if rebuilt is None else str(rebuilt.original),
        "kept": None if rebuilt is None else rebuilt.designs,
        "computed_now": computed,
    }


def _print(
    found: "StoreCheck", rebuilt: "RebuiltStore | None", computed: int, *, repaired: bool
) -> None:
    if rebuilt is not None:
        console.print_line(
            f"{found.path} was damaged: {rebuilt.designs} sound designs are kept; the damaged file is now "
            f"{rebuilt.original}."
        )
    if repaired:
        console.print_line(f"{computed} {'design' if computed == 1 else 'designs'} computed now.")
    if found.file:
        console.print_line(f"SQLite cannot trust the file: {found.file}.")
        return
    counts = ", ".join(f"{number} {status}" for status, number in found.status.items() if number)
    rows = f"{len(found.damaged)} damaged" if found.damaged else "no row damaged"
    console.print_line(f"{found.path}: {counts or 'no design computed'}; {rows}.")
    if found.without_checksums:
        console.print_line(
            "The store is of a release without checksums: a changed number cannot be detected. The next "
            "run of a study adds checksums."
        )
    for place, why in list(found.damaged.items())[:MOST_ROWS]:
        console.print_line(f"- {place}: {why}.")
    if len(found.damaged) > MOST_ROWS:
        console.print_line(f"... and {len(found.damaged) - MOST_ROWS} more; --json has them all.")
    for study in found.studies:
        console.print_line(_study_text(study))
    if not found.studies:
        console.print_line(
            f"It holds no study: run one from its file, crankfem doe STUDY.toml --store {found.path}."
        )


def _study_text(study: "StudyCheck") -> str:
    name = f"Study {study.study[:6]}"
    if study.designs is None:
        return (
            f"{name}: its plan is damaged; run it from its file, and its finished designs are used."
            if study.damaged
            else f"{name}: of another version of the finite element model."
        )
    text = f"{name}: {study.designs} designs, {study.missing} without a result"
    return f"{text}; {study.damaged} is damaged." if study.damaged else f"{text}."
