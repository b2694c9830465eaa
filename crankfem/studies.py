"""Run a study from a file: designs, fits and the compliance model in one call."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.fitting import ResponseFits, compliance_model, fit_study
from crankfem.throw_file import load_study
from regression.models.compliance_model import ComplianceModel
from regression.runs.study import Progress, StudyTable, run_plan


@dataclass(frozen=True)
class StudyResult:
    """A study's table, its fits by response, and the model made of the chosen ones."""

    table: StudyTable
    fits: dict[str, ResponseFits]
    model: ComplianceModel

    def __repr__(self) -> str:
        """Say in a line what it is; the table alone would fill screens."""
        return (
            f"StudyResult(study {self.table.plan.key[:6]}, {len(self.table.values)} designs, "
            f"equations for {', '.join(self.fits)})"
        )


def run_study(
    study: str | Path,
    store: str | Path = "runs.sqlite",
    workers: int = 2,
    progress: Progress | None = None,
    *,
    dask: str | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
) -> StudyResult:
    """Run, or continue, the study of a file and fit its equations.

    Parameters
    ----------
    study : path
        TOML file with the sections [throw] and [study]; an engine file serves as well.
    store : path
        SQLite file of results. Designs found finished there are not computed again.
    workers : int
        Worker processes on this machine.
    progress : callable, optional
        Called with (finished, total, newest outcome or None).
    dask : str, optional
        Address of a Dask scheduler, whose workers then compute instead.
    time_limit : float, optional
        Seconds that one design may take; 300 at 1 % accuracy by default.
    memory_limit : float, optional
        Bytes that one worker process may take; no limit by default.

    Returns
    -------
    StudyResult

    Raises
    ------
    InputError
        If the file, the store, a limit, the cluster or the number of workers cannot be used, or too few
        designs succeed.
    MissingLibraryError
        If a cluster is asked for without the package for it.
    StudyStoppedError
        If the store cannot be written any more, or the cluster is gone; finished designs are kept.
    """
    table = run_plan(
        load_study(study),
        store,
        workers,
        progress,
        dask=dask,
        time_limit=time_limit,
        memory_limit=memory_limit,
    )
    return fitted(table)


def study_key(path: str | Path) -> str:
    """Return the key under which a store knows the study of a file.

    Raises
    ------
    InputError
        If the file cannot be used or has no study.
    """
    return load_study(path).key


def fitted(table: StudyTable) -> StudyResult:
    """Fit all forms to a study's table and make the model.

    Raises
    ------
    InputError
        If too few designs have results.
    """
    fits = fit_study(table)
    return StudyResult(table, fits, compliance_model(table, fits))
