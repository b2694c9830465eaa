"""Run a study from a file: designs, fits and the compliance model in one call."""

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.choices import check_choice, check_not_given, is_whole_within
from crankbase.diagrams import draw_diagram, legend_inside, new_axes, write_title
from crankbase.errors import InputError, MeshError, visible
from crankbase.frames import Axes
from crankbase.outputs import atomic_file, check_output, is_listed, write_errors
from crankbase.results import Result, result
from crankbase.summaries import frozen
from crankfem.analyses.study.fit_plots import (
    draw_fit_elasticities,
    draw_fit_sobol,
    factor_diagram,
    parity_diagrams,
    parity_title,
)
from crankfem.analyses.study.fit_records import compliance_model
from crankfem.analyses.study.nominal_throw import sensitivities
from crankfem.analyses.study.response_fits import (
    ResponseFits,
    fit_scale,
    fit_study,
    needed_dimensions,
    run_slopes,
)
from crankfem.files.engine.throw_file import load_study
from crankfem.files.reading.toml_file import TomlFile
from geometry.mesher import mesh_isolated
from geometry.solid_files import SOLID_ENDINGS, write_mesh, write_step
from geometry.throw import CrankThrow
from regression.fits.fits import JudgedEquation, worst_places
from regression.models.compliance_model import ComplianceModel
from regression.plans.designs import (
    draw_feasible_points,
    sobol_points,
    values_at,
    with_points_at_ends,
)
from regression.plans.plan import PlannedDesign, PlannedStudy, StudyPlan
from regression.plots import factor_text
from regression.records import content_key
from regression.runs.exchange import Column, columns, write_csv
from regression.runs.study import Progress, add_runs, run_plan
from regression.runs.study_table import StudyTable, study_table

MOST_ADDED = 1000
# Places among which further runs are chosen; the stream of random numbers that they are drawn from.
PLACES, GROWTH_STREAM = 1000, 2


def run_grown(
    plan: StudyPlan,
    store: str | Path,
    workers: int = 2,
    progress: Progress | None = None,
    *,
    more: int = 0,
    **options: Any,
) -> StudyTable:
    """Compute what a study still lacks, then further runs where its equations are worst.

    Parameters
    ----------
    plan, store, workers, progress, **options
        As of `run_plan`.
    more : int
        Number of further runs beyond the plan, at most 1000. The store records the added runs:
        the same number again adds none, a larger one the difference, chosen where the equations,
        fitted to all runs so far, are worst. By default no run is added.
    """
    if not is_whole_within(more, 0, MOST_ADDED):
        raise InputError(
            f"more: given {more!r}; allowed is 0 to {MOST_ADDED} further designs, as a whole number."
        )
    table = run_plan(plan, store, workers, progress, **options)
    if more <= table.added:
        return table
    add_runs(plan, store, worst_designs(table, fit_study(table), more - table.added))
    grown = run_plan(plan, store, workers, progress, **options)
    return replace(grown, computed=table.computed + grown.computed)


def worst_designs(table: StudyTable, fits: Mapping[str, ResponseFits], count: int) -> Array:
    """Choose runs where the chosen equations of all responses are expected to have the largest errors.

    Held-out designs are not used, so that they remain independent of the equations.

    Parameters
    ----------
    fits : mapping
        As of `fit_study`.

    Returns
    -------
    (count, k) ndarray
        Values of the factors [SI] of throws that can be built and keep the study's constraints.
    """
    plan, factors = table.plan, table.plan.factors
    choices = [len(factor.labels) for factor in factors]

    def draw(number: int) -> Array:
        stream = (plan.seed, GROWTH_STREAM, table.added)
        return with_points_at_ends(sobol_points(number, choices, stream), choices)

    variants = plan.variants()
    present = {row.values for row in table.rows}

    def possible(points: Array) -> Flags:
        values = values_at(factors, points)
        made = [variant.throw is not None for variant in variants.at(values)]
        new = [tuple(row) not in present for row in values.tolist()]
        usable: Flags = np.array(made) & np.array(new)
        return usable

    feasible = None
    for wanted in (max(PLACES, count), count):
        feasible = feasible or draw_feasible_points(draw, possible, wanted, in_order=True)
    if feasible is None:
        raise InputError(
            f"more: given {count} further designs; allowed are as many as there are throws in the study's "
            "ranges that can be built and keep its constraints, of which too few are found."
        )
    points, _, impossible = feasible
    places = np.unique(values_at(factors, points[~impossible]), axis=0)
    equations, runs = [], ~table.held_out
    for response in fits.values():
        fit = response.chosen
        values = table.responses[response.column][runs]
        at_runs = {name: column[runs] for name, column in table.dimensions.items()}
        at_places = needed_dimensions(plan, response, fit, places)
        scale = fit_scale(plan, response.column, fit.basis, at_runs)
        x = response.encodings[fit.basis].columns(plan.factors, places, at_places)
        sizes = np.ones(len(places))
        if not fit.fitted.logarithmic:
            # Where an equation passes through zero, its relative error says nothing.
            sizes = np.maximum(np.abs(fit.predict(x)), np.min(np.abs(values / scale)))
        equations.append(
            JudgedEquation(
                fit=fit,
                runs=response.encodings[fit.basis].columns(
                    plan.factors, table.values[runs], at_runs
                ),
                target=np.log(values / scale) if fit.fitted.logarithmic else values / scale,
                places=x,
                sizes=sizes,
                slopes=run_slopes(
                    table, response.column, response.encodings[fit.basis], response.doubted_slopes
                ),
            )
        )
    return places[worst_places(equations, count)]


Shown = Literal["parity", "response", "effects", "elasticities", "sobol"]
SHOWN: tuple[Shown, ...] = ("parity", "response", "effects", "elasticities", "sobol")
# Diagrams of one equation.
OF_A_FORM: tuple[Shown, ...] = ("parity", "effects")


@frozen("study: table.plan.key", "designs: table.values", "fits")
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
        axes: Axes | None = None,
        *,
        response: str | None = None,
        show: Shown = "parity",
        factor: str | None = None,
        form: str | None = None,
    ) -> Axes:
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
        fits, factors = self.fits[name], self.table.plan.names
        fit = fits.chosen if form is None else fits.fit_named(form)
        if show == "effects":
            return fits.plot(axes, show="effects", form=form)
        along = factors[0] if factor is None else factor
        check_choice("factor", along, factors, "these vary in the study")
        axes = new_axes(axes)
        if show == "parity":
            draw_diagram(axes, parity_diagrams(self.table, fits, fit)[0])
            write_title(axes, parity_title(fits, fit), 9)
            legend_inside(axes)
        elif show == "response":
            draw_diagram(axes, factor_diagram(self.table, fits, factors.index(along)))
            write_title(axes, f"{name.replace('_', ' ')}, {fits.support}".rstrip(", "))
            legend_inside(axes)
        else:
            known = sensitivities(self.table, fits)
            if show == "sobol":
                draw_fit_sobol(axes, list(map(factor_text, factors)), known)
            else:
                draw_fit_elasticities(axes, self.table, fits, known)
            write_title(axes, name.replace("_", " "))
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the designs and their responses; see `StudyTable.to_pandas`."""
        return self.table.to_pandas()


def run_study(
    study: str | Path | TomlFile | Mapping[str, Any] | StudyPlan,
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
    """Run, or continue, a study and fit its equations.

    Parameters
    ----------
    study : path, dict or StudyPlan
        TOML file with the sections [throw] and [study], or an engine file; or its sections, as a dict of
        dicts such as ``{"throw": {"crank_radius": "170 mm", ...}, "study": {...}}``; or the plan itself.
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
        study if isinstance(study, StudyPlan) else load_study(study),
        store,
        workers,
        progress,
        dask=dask,
        time_limit=time_limit,
        memory_limit=memory_limit,
        note=note or (lambda text: print(visible(text), file=sys.stderr, flush=True)),
        more=more,
    )
    return fitted(table)


def study_key(study: str | None) -> str | None:
    """Return the key in a store of what is named by its file; a key, or the beginning of one, as it is."""
    return load_study(study).key if study is not None and study.endswith(".toml") else study


def fitted(table: StudyTable) -> StudyResult:
    """Fit all forms to a study's table and make the model."""
    fits = fit_study(table)
    return StudyResult(table, fits, compliance_model(table, fits))


TABLE = "designs.csv"
KINDS = (*(ending.removeprefix(".") for ending in SOLID_ENDINGS), "step")
# What the table of a study says of designs that are computed.
OF_RESULTS = ("status", "source", "seconds", "unknowns", "model_version", "reason")


@result("table", "written", "failures")
class ExportedDesigns(Result):
    """Files of a study's designs.

    Attributes
    ----------
    table : str
        A line for each design: its number, file and role, factors and dimensions. With columns of
        responses added, a study can import it.
    files : tuple of str
        Of the designs in order, whether they exist or not.
    written : int
        Number of files written in this call.
    failures : dict
        File that could not be made to the reason.
    """

    table: str
    files: tuple[str, ...]
    written: int
    failures: Mapping[str, str]

    def parts(self) -> Iterator[str]:
        """State what was written, and why some files were not."""
        present = len(self.files) - len(self.failures)
        yield (
            f"{self.table} written: {len(self.files)} designs, of which {present} have a file in the folder ("
            f"{self.written} written now); lengths in m."
        )
        for file, reason in self.failures.items():
            yield f"Not written: {file}: {reason}"


def export_designs(
    planned: PlannedStudy, folder: Path, kind: str, progress: Callable[[int, int], None]
) -> ExportedDesigns:
    """Write a table of a study's designs, and a mesh or a solid of each.

    A file's name has the key of its throw; existing files of an earlier call are not written again.

    Parameters
    ----------
    kind : str
        One of `KINDS`: the ending of a mesh's file, or "step". Whole throws, lengths in m; the meshes are
        second-order tetrahedra of the usual sizes.
    progress : callable
        Called with (finished, total).
    """
    check_kind(kind)
    files = tuple(
        folder / f"{place:03d}-{content_key(design.inputs['throw'])[:8]}.{kind}"
        for place, design in enumerate(planned.designs, start=1)
    )
    missing = [
        place for place, file in enumerate(files) if not (file.is_file() and is_listed(file))
    ]
    for place in missing:
        check_output(files[place], "solid" if kind == "step" else "mesh")
    table = folder / TABLE
    with write_errors(table), atomic_file(table, "table") as part:
        about = columns(study_table(planned.plan, planned.designs, {}))
        write_csv(
            part,
            [
                Column("design", "", list(range(1, len(files) + 1))),
                Column("file", "", [file.name for file in files]),
                *(column for column in about if column.name not in OF_RESULTS),
            ],
        )
    failures = {}
    done = len(files) - len(missing)
    progress(done, len(files))
    for place in missing:
        try:
            _write(planned.designs[place], files[place])
        except MeshError as error:
            failures[str(files[place])] = str(error)
        done += 1
        progress(done, len(files))
    return ExportedDesigns(
        str(table), tuple(map(str, files)), len(missing) - len(failures), failures
    )


def check_kind(kind: str) -> None:
    """Refuse a kind of file that is not in `KINDS`."""
    if kind not in KINDS:
        raise InputError(f"mesh: given {kind!r}; allowed are {', '.join(KINDS)}.")


def _write(design: PlannedDesign, file: Path) -> None:
    throw = CrankThrow(**design.inputs["throw"])
    if file.suffix == ".step":
        write_step(throw, file)
    else:
        write_mesh(mesh_isolated(throw, part="full"), file)
