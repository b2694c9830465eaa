"""Run a study from a file: designs, fits and the compliance model in one call."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from crankbase.checks.choices import check_choice, check_not_given
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.summaries import summarized
from crankfem.analyses.study.fit_diagrams import (
    draw_fit_elasticities,
    draw_fit_parity,
    draw_fit_sobol,
    draw_over_factor,
    fe_axis_label,
)
from crankfem.analyses.study.fitting import fit_study
from crankfem.analyses.study.growth import run_grown
from crankfem.analyses.study.nominal_throw import sensitivities
from crankfem.analyses.study.response_fits import ResponseFits
from crankfem.analyses.study.study_model import compliance_model
from crankfem.files.engine.throw_file import load_study
from crankfem.files.reading.toml_file import TomlFile
from regression.factor_labels import factor_text
from regression.models.compliance_model import ComplianceModel
from regression.plots.factor_axis import response_text
from regression.runs.study import Progress
from regression.runs.study_table import StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Shown = Literal["parity", "response", "effects", "elasticities", "sobol"]
SHOWN: tuple[Shown, ...] = ("parity", "response", "effects", "elasticities", "sobol")
# Diagrams of one equation.
OF_A_FORM: tuple[Shown, ...] = ("parity", "effects")


@summarized("study: table.plan.key", "designs: table.values", "fits", keeps_text=True)
@dataclass(frozen=True)
class StudyResult:
    """A study's table, its fits by response, and the model of the chosen ones."""

    table: StudyTable
    fits: dict[str, ResponseFits]
    model: ComplianceModel

    def __repr__(self) -> str:
        """Summarize the result in a line; the table alone would fill screens."""
        return (
            f"StudyResult(study {self.table.plan.key[:6]}, {len(self.table.values)} designs, "
            f"equations for {', '.join(self.fits)})"
        )

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        response: str | None = None,
        show: Shown = "parity",
        factor: str | None = None,
        form: str | None = None,
    ) -> "Axes":
        """Draw one diagram of one response.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        response : str, optional
            A name in `fits`; the first by default.
        show : str
            "parity": equation over finite elements; "response": equations and designs over one factor;
            "effects": sizes of the equation's terms; "elasticities": % of
            the response per % of each factor; "sobol": the factors' shares of the variance.
        factor : str, optional
            Factor for "response"; by default the first.
        form : str, optional
            Form for "parity" or "effects"; by default the chosen
            one.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If an option is unknown or not applicable, or the form was not fitted.
        """
        check_choice("show", show, SHOWN, "these are diagrams of a study")
        name = next(iter(self.fits)) if response is None else response
        check_choice("response", name, self.fits, "these have equations")
        if show not in OF_A_FORM:
            check_not_given("form", form, show, "it shows no single form")
        if show != "response":
            check_not_given("factor", factor, show, "only a response is drawn over one")
        found, factors = self.fits[name], self.table.plan.names
        fit = found.chosen if form is None else found.fit_named(form)
        if show == "effects":
            return found.plot(axes, show="effects", form=form)
        along = factors[0] if factor is None else factor
        check_choice("factor", along, factors, "these vary in the study")
        axes = new_axes(axes)
        if show == "parity":
            draw_fit_parity(axes, self.table, found, fit)
            axes.set_xlabel(fe_axis_label(found))
            axes.set_ylabel(f"{response_text(found.symbol, found.unit)} by the equation")
            legend_inside(axes)
        elif show == "response":
            draw_over_factor(axes, self.table, found, factors.index(along))
            axes.set_ylabel(response_text(found.symbol, found.unit))
            write_title(axes, f"{name.replace('_', ' ')}, {found.support}".rstrip(", "))
            legend_inside(axes)
        else:
            known = sensitivities(self.table, found)
            if show == "sobol":
                draw_fit_sobol(axes, [factor_text(one) for one in factors], known)
            else:
                draw_fit_elasticities(axes, self.table, found, known)
            write_title(axes, name.replace("_", " "))
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the designs and their responses; see `StudyTable.to_pandas`."""
        return self.table.to_pandas()


def run_study(
    study: str | Path | TomlFile,
    store: str | Path = "runs.sqlite",
    workers: int = 2,
    progress: Progress | None = None,
    *,
    dask: str | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    note: Callable[[str], None] | None = None,
    more: int = 0,
) -> StudyResult:
    """Run, or continue, the study of a file and fit its equations.

    Parameters
    ----------
    study : path
        TOML file with the sections [throw] and [study], or an engine file; or its sections, if already
        read.
    store : path
        SQLite file of results. Finished designs are not computed again.
    workers : int
        Worker processes on this machine.
    progress : callable, optional
        Called with (finished, total, newest outcome or None).
    dask : str, optional
        Address of a Dask scheduler, whose workers then compute.
    time_limit : float, optional
        Time limit of one design [s]; 300 at 1 % accuracy by default.
    memory_limit : float, optional
        Memory limit of one worker process [bytes]; none by default.
    note : callable, optional
        Called with notes, for example that a cluster has no workers
        yet; by default they are written to standard error. ``note=lambda _: None`` suppresses them.
    more : int
        Number of further runs beyond the plan, where the equations are worst, at most
        1000. The store records the added runs: the same number again adds none.

    Returns
    -------
    StudyResult

    Raises
    ------
    InputError
        If the file, the store, a limit, the cluster or the number of workers cannot be used, or too few
        designs succeed.
    MissingLibraryError
        If a cluster is used without the required package.
    StudyStoppedError
        If the store can no longer be written, or the cluster is lost; finished designs are kept.
    """
    table = run_grown(
        load_study(study),
        store,
        workers,
        progress,
        dask=dask,
        time_limit=time_limit,
        memory_limit=memory_limit,
        note=note or _to_stderr,
        more=more,
    )
    return fitted(table)


def _to_stderr(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def study_key(path: str | Path) -> str:
    """Return the key of a file's study in a store.

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
