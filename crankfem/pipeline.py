"""The main job: from an engine file to results, pictures and a report in one folder."""

import json
import math
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from crankfem import results as records
from crankfem.balance_tables import balance_record
from crankfem.engine_file import EngineFile, load_engine
from crankfem.export import write_vtu
from crankfem.fit_records import study_record
from crankfem.formula_records import fe_axial_curve, fe_record, formula_records
from crankfem.input_files import mechanism_inputs
from crankfem.mechanism_file import MechanismFile, load_mechanism
from crankfem.mechanism_run import run_mechanism
from crankfem.mechanism_tables import mechanism_record
from crankfem.pictures import plots
from crankfem.pictures.drawing import write_drawing
from crankfem.pictures.interactive.angles import interactive_angles
from crankfem.pictures.interactive.mechanism import interactive_mechanism
from crankfem.pictures.interactive.study import interactive_study
from crankfem.pictures.interactive.throw_view import throw_view
from crankfem.pictures.interactive.torque import interactive_torque
from crankfem.pictures.interactive.vibration import interactive_vibration
from crankfem.pictures.mechanism_pictures import picture_mechanism
from crankfem.pictures.render import DEFORMED, MESH, Rendering
from crankfem.pictures.surface import stretched_surface
from crankfem.pictures.vibration_pictures import picture_vibration
from crankfem.record import RPM
from crankfem.report.about import about_record, repeat_record
from crankfem.report.checks import run_checks
from crankfem.report.compliances import RESPONSES, regression_record
from crankfem.report.fillets import StressRendering, shown_loads, stresses_or_reason
from crankfem.report.run_pictures import by_stem, picture_angles, picture_study
from crankfem.report.writing import write_report
from crankfem.stress import stress_record
from crankfem.studies import fitted
from crankfem.vibration.records import run_record
from crankfem.vibration.run import engine_vibration
from dynamics.chains.two_mass import two_mass_check
from dynamics.critical import engine_orders, major_orders
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.torque_table import TorqueTable, read_torque_table
from fem.analysis import ThrowAnalysis, analyze_throw
from geometry.errors import InputError, MissingLibraryError
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formulas
from regression.models.compliance_model import ComplianceModel
from regression.records import Outcome
from regression.runs.study import check_workers, run_plan

RESULTS, REPORT, MODEL, STORE = "results.json", "report.html", "model.json", "study.sqlite"
MESH_FILE, DRAWING = "throw.vtu", "drawing.svg"
# Without a gas pressure in the engine file, reactions are given for this radial force.
UNIT_RADIAL_FORCE = 1e5
ANGLES_SHOWN_DEG = np.arange(0.0, 181.0, 5.0)


class Progress(Protocol):
    """What a run tells about itself while it works."""

    def step(self, text: str) -> None:
        """A new step begins."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """A design of the study is finished."""

    def note(self, text: str) -> None:
        """Something the user should know."""


class Silent:
    """Progress that tells nothing."""

    def step(self, text: str) -> None:
        """Ignore a step."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Ignore a design."""

    def note(self, text: str) -> None:
        """Ignore a note."""


class Timed:
    """Progress that passes everything on and takes the time of the steps."""

    def __init__(self, told: Progress) -> None:
        self._told = told
        self._began: tuple[str, float] | None = None
        self.seconds: dict[str, float] = {}

    def step(self, text: str) -> None:
        """End one step and begin the next."""
        self.stop()
        self._began = (text, time.perf_counter())
        self._told.step(text)

    def stop(self) -> None:
        """Take the time of the step that has ended."""
        if self._began is not None:
            text, began = self._began
            self.seconds[text] = self.seconds.get(text, 0.0) + time.perf_counter() - began
            self._began = None

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Pass on that a design is finished."""
        self._told.design(finished, total, newest)

    def note(self, text: str) -> None:
        """Pass a note on."""
        self._told.note(text)


@dataclass(frozen=True)
class RunResult:
    """Where a run has put things, and its numbers.

    Attributes
    ----------
    folder : Path
        Holds report, results, model, study store and pictures.
    report : Path
        The HTML report.
    results : dict
        The content of results.json.
    """

    folder: Path
    report: Path
    results: dict[str, Any]


def run_engine(
    engine: str | Path,
    output: str | Path | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
) -> RunResult:
    """Run the main job on an engine file.

    Parameters
    ----------
    engine : path
        Engine file, or the name of a shipped engine.
    output : path, optional
        Folder for the results; ``NAME-results`` in the working directory by default. A study found
        there is continued.
    workers : int
        Worker processes of the study.
    progress : Progress, optional
        Told what goes on.

    Returns
    -------
    RunResult

    Raises
    ------
    InputError
        If the engine file or the folder cannot be used.
    MeshError, SolveError
        If the throw cannot be meshed or solved.
    """
    told = Timed(progress or Silent())
    told.step("Reading the engine file")
    check_workers(workers)
    engine_file = load_engine(engine)
    mechanism = load_mechanism(engine_file.path)
    with_gas = mechanism if mechanism.pressure else None
    torque = _read_torque(engine_file)
    folder = _make_folder(output, engine_file)
    pictures = folder / "pictures"
    pictures.mkdir(exist_ok=True)

    told.step("Analyzing the throw")
    analysis = analyze_throw(engine_file.throw, engine_file.material)
    with ExitStack() as renderings:
        rendering = Rendering(stretched_surface(analysis), pictures)
        renderings.callback(rendering.stop)
        found = _throw_results(engine_file, analysis, with_gas)

        told.step("Calculating stresses at the fillets")
        stresses, found["fillet_note"] = stresses_or_reason(engine_file.throw, engine_file.material)
        stress_rendering = None
        if stresses is None:
            told.note(f"No stresses at the fillets: {found['fillet_note']}")
        else:
            found["fillets"] = stress_record(stresses)
            stress_rendering = StressRendering(shown_loads(stresses), pictures)
            renderings.callback(stress_rendering.stop)
        _add(found, "interactive", [throw_view(pictures, analysis, stresses)])

        if with_gas is not None:
            run = run_mechanism(with_gas, masses=analysis.masses)
            found["mechanism"] = mechanism_record(run) | {"balance": balance_record(run.balance)}
            _add(found, "pictures", picture_mechanism(pictures, run))
            _add(found, "interactive", interactive_mechanism(pictures, run))
        model = None
        if engine_file.study is not None:
            told.step("Running the study")
            table = run_plan(engine_file.study, folder / STORE, workers, told.design)
            study = fitted(table)
            model = study.model
            model.save(folder / MODEL)
            found["study"] = study_record(table, study.fits, model)
            found["formulas"]["regression"] = _regression(found["study"], model, engine_file.throw)
            fits = study.fits["axial_compliance"]
            found["pictures"] |= picture_study(pictures, table, fits)
            _add(found, "interactive", interactive_study(pictures, table, fits))
        else:
            (folder / MODEL).unlink(missing_ok=True)  # of an earlier run with a study

        vibration = engine_vibration(
            engine_file,
            analysis=analysis,
            mechanism=mechanism,
            model=model,
            coupled=True,
            step=told.step,
        )
        found["shaft"] = records.shaft_record(vibration.shaft, analysis)
        found["vibration"] = run_record(vibration)
        _add_torque(engine_file, torque, found, pictures)

        told.step("Drawing pictures")
        write_drawing(engine_file.throw, pictures / DRAWING, engine_file.engine.name)
        found["pictures"]["drawing"] = DRAWING
        _add(found, "pictures", picture_vibration(pictures, vibration))
        _add(found, "interactive", interactive_vibration(pictures, vibration))
        found["pictures"] |= picture_angles(pictures, found)
        _add(found, "interactive", interactive_angles(pictures, found))
        try:
            rendering.wait()
            found["pictures"] |= {"mesh": MESH, "deformed": DEFORMED}
            if stress_rendering is not None:
                stress_rendering.wait()
                found["pictures"] |= stress_rendering.files
        except MissingLibraryError as error:
            found["picture_note"] = str(error)
            told.note(str(error))

    pin = engine_file.throw.parts.pins[0]
    middle = (*pin.axis, 0.5 * (pin.start + pin.end))
    found["checks"] = run_checks(found, engine_file.throw.length, middle)
    told.stop()
    found["repeat"] = repeat_record(
        engine_file.path, _other_inputs(engine_file, mechanism), told.seconds
    )

    told.step("Writing the report")
    write_vtu(analysis, folder / MESH_FILE)
    text = json.dumps(found, indent=1, allow_nan=False)
    (folder / RESULTS).write_text(text + "\n", encoding="utf-8")
    return RunResult(folder, write_report(found, pictures, folder / REPORT), found)


def _throw_results(
    engine_file: EngineFile, analysis: ThrowAnalysis, with_gas: MechanismFile | None
) -> dict[str, Any]:
    """Return the results that follow from the file and the throw alone, and room for the others."""
    fe = fe_record(analysis, 180.0)
    return {
        "about": about_record(),
        "engine": _engine_record(engine_file),
        "inputs": records.input_records(engine_file.records),
        "sources": engine_file.sources,
        "throw": records.throw_record(analysis, _radial_force(engine_file, with_gas)),
        "formulas": formula_records(engine_file.throw, engine_file.material) | {"fe": fe},
        "angle_law": _angle_record(engine_file, analysis) | {"law": fe["angle_law"]},
        "balance": records.balance_record(engine_file),
        "fillets": None,
        "fillet_note": None,
        "mechanism": None,
        "study": None,
        "harmonics": None,
        "two_mass": None,
        "pictures": {},
        "interactive": {},
        "picture_note": None,
    }


def _add(found: dict[str, Any], kind: str, paths: list[Path]) -> None:
    """Name the files of pictures or plots in the results."""
    found[kind] |= by_stem(paths)


def _regression(
    study: dict[str, Any], model: ComplianceModel, throw: CrankThrow
) -> dict[str, Any] | None:
    """What the study's equations say of the engine's throw, if it is one of their family."""
    try:
        values = model.of_throw(throw)
    except InputError:
        return None
    shown = {name: values[name].value for name in RESPONSES.values() if name in values}
    return regression_record(study, shown)


def _other_inputs(engine_file: EngineFile, mechanism: MechanismFile) -> list[Path]:
    """Tables that the engine file names."""
    torque = [] if engine_file.torque_table is None else [engine_file.torque_table]
    return [*mechanism_inputs(mechanism)[1:], *torque]


def _make_folder(output: str | Path | None, engine_file: EngineFile) -> Path:
    folder = Path(output) if output is not None else Path(f"{engine_file.path.stem}-results")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"output: given {str(folder)!r}, which cannot be made ({error.strerror}); "
            "allowed is a folder one may write to."
        ) from None
    return folder


def _read_torque(engine_file: EngineFile) -> TorqueTable | None:
    if engine_file.torque_table is None:
        return None
    return read_torque_table(engine_file.torque_table, strokes=engine_file.engine.strokes)


def _radial_force(engine_file: EngineFile, mechanism: MechanismFile | None) -> float:
    """Radial force at firing top dead center: gas pressure on the piston [N]."""
    if mechanism is None:
        return UNIT_RADIAL_FORCE
    above = max(pressure.peak_pressure for pressure in mechanism.pressure) - ATMOSPHERE
    return above * math.pi / 4.0 * engine_file.engine.bore**2


def _engine_record(engine_file: EngineFile) -> dict[str, Any]:
    engine = engine_file.engine
    return {
        "name": engine.name,
        "file": engine_file.path.name,
        "cylinders": engine.cylinders,
        "v_engine": engine.bank_angles is not None,
        "reciprocating": engine_file.vibration.reciprocating,
        "strokes": engine.strokes,
        "bore": engine.bore,
        "stroke": engine.stroke,
        "crank_angles": list(engine.crank_angles),
        "firing_order": list(engine.firing_order),
        "rated_speed_rpm": engine.rated_speed * RPM,
        "lowest_speed_rpm": engine.lowest_speed * RPM,
        "highest_speed_rpm": engine.highest_speed * RPM,
        "major_orders": major_orders(
            engine_orders(engine.strokes, engine_file.vibration.highest_order), engine.firing_angles
        ).tolist(),
        "highest_order": engine_file.vibration.highest_order,
        "radial_force_from_gas": engine_file.gas is not None,
    }


def _angle_record(engine_file: EngineFile, analysis: ThrowAnalysis) -> dict[str, Any]:
    """FE and formulas over the angle between neighboring cranks."""
    material = engine_file.material
    tables = [
        axial_formulas(
            engine_file.throw,
            float(gamma),
            youngs_modulus=material.youngs_modulus,
            poisson_ratio=material.poisson_ratio,
        )
        for gamma in ANGLES_SHOWN_DEG
    ]
    return {
        "gamma_deg": ANGLES_SHOWN_DEG.tolist(),
        "fe": fe_axial_curve(analysis, ANGLES_SHOWN_DEG.tolist()),
        "formulas": {
            name: [table[name].value if table[name].value > 0.0 else None for table in tables]
            for name in tables[0]
        },
    }


def _add_torque(
    engine_file: EngineFile, torque: TorqueTable | None, found: dict[str, Any], pictures: Path
) -> None:
    harmonics = None
    if torque is not None:
        harmonics = torque.harmonics()
        found["harmonics"] = records.harmonics_record(harmonics) | {"source": torque.source}
        name = "torque.svg"
        plots.plot_torque(pictures / name, torque.torque, harmonics)
        found["pictures"]["torque"] = name
        _add(found, "interactive", interactive_torque(pictures, torque.torque, harmonics))
    if engine_file.two_mass is not None:
        given = engine_file.two_mass
        check = two_mass_check(
            diameter=given.shaft_diameter,
            length=given.shaft_length,
            shear_modulus=given.shear_modulus,
            inertia_1=given.flywheel_inertia,
            inertia_2=given.engine_inertia,
            order=given.order,
            harmonics=harmonics,
        )
        found["two_mass"] = records.two_mass_record(check)
