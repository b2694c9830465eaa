"""The main job: from an engine file to results, pictures and a report in one folder.

In this order: read, compute, record all numbers, draw, and write the report from the records alone.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from crankbase.outputs import protected, recording_run_files
from crankbase.summaries import summarized
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.provenance import repetition
from crankfem.analyses.record import attributes, with_units
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.shaft.throw_analyses import analyze_throws
from crankfem.analyses.strength.cycle_fatigue import fatigue_or_reason
from crankfem.analyses.strength.engine_strength import engine_strength
from crankfem.analyses.study.studies import fitted
from crankfem.analyses.throw.stress import (
    StressRendering,
    shown_loads,
    stress_files,
    stresses_or_reason,
)
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.reading.toml_file import TomlFile
from crankfem.jobs.run_computation import RunComputation, RunInputs, ThrowComputation, read_inputs
from crankfem.jobs.run_drawing import Renderings, draw_run
from crankfem.jobs.run_files import (
    MODEL,
    PICTURES,
    REPORT,
    STORE,
    Progress,
    SilentProgress,
    TimedProgress,
    check_folder,
    make_folders,
    replace_last_run,
    the_only_run,
    write_results,
)
from crankfem.jobs.run_records import run_results
from crankfem.report.writing import write_report
from fem.fillet_stress import FilletMesh
from regression.runs.store import ResultStore
from regression.runs.study import check_workers, run_plan


@summarized("folder", "report", "results")
@dataclass(frozen=True)
class RunResult:
    """Files of a run, and its numbers.

    Attributes
    ----------
    folder : Path
        Holds report, results, model, study store and pictures.
    report : Path
        The HTML report.
    results : RunResults
        The content of results.json.
    """

    folder: Path
    report: Path
    results: RunResults


def run_engine(
    engine: str | Path | TomlFile | RunInputs,
    output: str | Path | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
) -> RunResult:
    """Run the main job on an engine file.

    Everything is computed before the folder is touched: a run that fails or is stopped before that
    leaves what the last one has put there. Then all of it but the store of the study is replaced. Files
    that no run has put there stay, and end the run before it computes where they stand in its way; see
    `replacing_files`.

    Parameters
    ----------
    engine : path
        Engine file, or the name of a shipped engine; or its sections, or what `read_inputs` has
        read of it.
    output : path, optional
        Folder for the results; ``NAME-results`` in the working directory by default. A study found
        there is continued.
    workers : int
        Worker processes of the study.
    progress : Progress, optional
        Receives the progress, and pictures that cannot be drawn, which do not end the run.

    Returns
    -------
    RunResult

    Raises
    ------
    InputError
        If the engine file or the folder cannot be used, or a file in the way was not written by crankfem.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    OSError
        If results, model or report cannot be written.
    """
    reporter = TimedProgress(progress or SilentProgress())
    reporter.step("Reading the engine file")
    check_workers(workers)
    inputs = engine if isinstance(engine, RunInputs) else read_inputs(engine)
    for warning in inputs.warnings:
        reporter.warn(f"{warning.sentence}.")
    path = inputs.engine_file.path
    folder = Path(f"{path.stem}-results" if output is None else output)
    read, study = inputs.paths, inputs.study is not None
    check_folder(folder, study=study, inputs=read)
    if study and (folder / STORE).exists():
        # What is no store is refused before anything is computed.
        ResultStore(folder / STORE).close()
    make_folders(folder, PICTURES)
    with the_only_run(folder), recording_run_files(), protected(*read):
        with Renderings() as renderings:
            computed = _compute(inputs, folder / STORE, workers, reporter, renderings)
            results = run_results(
                computed, repetition(inputs.files, reporter.seconds, inputs.option)
            )
            record = with_units(results)
            replace_last_run(folder, record)
            if computed.study is not None:
                computed.study.model.save(folder / MODEL)

            reporter.step("Drawing pictures")
            drawn = draw_run(folder, computed, results, renderings, reporter.note)
            reporter.stop()
        results = replace(
            results,
            pictures=drawn.static,
            interactive=drawn.interactive,
            picture_note=" ".join(drawn.notes) or None,
            repeat=repetition(inputs.files, reporter.seconds, inputs.option),
        )
        reporter.step("Writing the report")
        # A page shows what is stored, now as when it is written again.
        record |= attributes(results, "pictures", "interactive", "picture_note", "repeat")
        stored = RunResults.from_json(write_results(folder, record).read_bytes())
        report = write_report(stored, folder / PICTURES, folder / REPORT)
        return RunResult(folder, report, results)


def _compute(
    inputs: RunInputs, store: Path, workers: int, reporter: TimedProgress, renderings: Renderings
) -> RunComputation:
    """Compute all numbers of a run; only the store of its study is written to."""
    engine_file = inputs.engine_file
    reporter.step(
        "Analyzing the throw" if len(engine_file.named_throws) == 1 else "Analyzing the throws"
    )
    analyses = analyze_throws(engine_file)
    first, *_ = names = tuple(dict.fromkeys(engine_file.throw_names))

    reporter.step("Calculating stresses at the fillets")
    strength_asked = engine_file.strength
    by_rule = strength_asked is not None and strength_asked.factors == "finite elements"
    mesh: FilletMesh = "m53" if by_rule else "adaptive"
    throws = {}
    for name in names:
        throw = engine_file.named_throws[name]
        stresses, reason = stresses_or_reason(throw, engine_file.material, mesh)
        if stresses is None:
            of_throw = f" of throw {name}" if engine_file.throws_by_name else ""
            reporter.note(f"No stresses at the fillets{of_throw}: {reason}")
        throws[name] = ThrowComputation(analyses[name], stresses, reason)
    stresses = throws[first].stresses
    if stresses is not None:
        shown = shown_loads(stresses)
        renderings.start(
            "picture of the stresses at the fillets",
            stress_files(shown),
            lambda folder: StressRendering(shown, folder),
        )
    along = [analyses[name].masses for name in engine_file.throw_names]
    mechanism = run_mechanism(engine_file, masses=along) if engine_file.pressure else None

    study = None
    if inputs.study is not None:
        reporter.step("Running the study")
        study = fitted(run_plan(inputs.study, store, workers, reporter.design, note=reporter.warn))
    elif engine_file.study is not None:
        reporter.note(
            f"The study is not run: the saved model {inputs.saved_path} is used in its place."
        )
    model = inputs.model if study is None else study.model
    vibration = engine_vibration(
        engine_file,
        analysis=analyses,
        model=model,
        coupled=True,
        step=reporter.step,
    )
    strength = fatigue = fatigue_note = None
    if engine_file.strength is not None:
        reporter.step("Assessing the crankshaft's strength")
        known = {
            name: throw_answer.stresses
            for name, throw_answer in throws.items()
            if throw_answer.stresses is not None
        }
        strength = engine_strength(vibration, stresses=known)
        if strength.warning:
            reporter.note(strength.warning)
        reporter.step("Calculating stresses over the cycle")
        fatigue, fatigue_note = fatigue_or_reason(vibration, strength, known)
    harmonics = None if inputs.torque is None else inputs.torque.harmonics()
    reporter.stop()
    return RunComputation(
        inputs,
        throws,
        mechanism,
        study,
        vibration,
        harmonics,
        model,
        strength,
        fatigue,
        fatigue_note,
    )
