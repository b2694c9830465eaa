"""The main job: from an engine file to results, pictures and a report in one folder."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from crankfem import results as records
from crankfem.engine_file import EngineFile, load_engine
from crankfem.export import write_vtu
from crankfem.fit_records import study_record
from crankfem.fitting import ResponseFits
from crankfem.formula_records import fe_axial_curve, fe_record, formula_records
from crankfem.mechanism_file import MechanismFile, load_mechanism
from crankfem.mechanism_report import mechanism_results
from crankfem.pictures import fit_plots, formula_plots, plots
from crankfem.pictures.drawing import write_drawing
from crankfem.pictures.render import DEFORMED, MESH, Rendering
from crankfem.pictures.surface import stretched_surface
from crankfem.pictures.vibration_pictures import picture_vibration
from crankfem.record import RPM
from crankfem.report.writing import write_report
from crankfem.studies import fitted
from crankfem.vibration.records import run_record
from crankfem.vibration.run import engine_vibration
from dynamics.chains.two_mass import two_mass_check
from dynamics.critical import engine_orders, major_orders
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.torque_table import TorqueTable, read_torque_table
from fem.analysis import ThrowAnalysis, analyze_throw
from geometry.errors import InputError, MissingLibraryError
from regression.formulas.angle_factors import ANGLE_FACTORS
from regression.formulas.axial_formulas import axial_formulas
from regression.records import Outcome
from regression.runs.study import check_workers, run_plan
from regression.runs.study_table import StudyTable

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
    told = progress or Silent()
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
    rendering = Rendering(stretched_surface(analysis), pictures)
    try:
        fe = fe_record(analysis, 180.0)
        found: dict[str, Any] = {
            "about": records.about_record(),
            "engine": _engine_record(engine_file),
            "inputs": records.input_records(engine_file.records),
            "sources": engine_file.sources,
            "throw": records.throw_record(analysis, _radial_force(engine_file, with_gas)),
            "formulas": formula_records(engine_file.throw, engine_file.material) | {"fe": fe},
            "angle_law": _angle_record(engine_file, analysis) | {"law": fe["angle_law"]},
            "balance": records.balance_record(engine_file),
            "mechanism": None,
            "study": None,
            "harmonics": None,
            "two_mass": None,
            "pictures": {},
            "picture_note": None,
        }
        if with_gas is not None:
            found["mechanism"], drawn = mechanism_results(with_gas, analysis.masses, pictures)
            found["pictures"] |= drawn
        model = None
        if engine_file.study is not None:
            told.step("Running the study")
            table = run_plan(engine_file.study, folder / STORE, workers, told.design)
            study = fitted(table)
            model = study.model
            model.save(folder / MODEL)
            found["study"] = study_record(table, study.fits, model)
            _plot_study(pictures, found, table, study.fits["axial_compliance"])
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
        drawn_vibration = picture_vibration(pictures, vibration)
        found["pictures"] |= {path.stem: path.name for path in drawn_vibration}
        _plot_angles(pictures, found)
        try:
            rendering.wait()
            found["pictures"] |= {"mesh": MESH, "deformed": DEFORMED}
        except MissingLibraryError as error:
            found["picture_note"] = str(error)
            told.note(str(error))
    finally:
        rendering.stop()

    told.step("Writing the report")
    write_vtu(analysis, folder / MESH_FILE)
    text = json.dumps(found, indent=1, allow_nan=False)
    (folder / RESULTS).write_text(text + "\n", encoding="utf-8")
    return RunResult(folder, write_report(found, pictures, folder / REPORT), found)


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


def _plot_study(
    pictures: Path, found: dict[str, Any], table: StudyTable, fits: ResponseFits
) -> None:
    drawn = {name: f"{name}.svg" for name in ("response", "parity", "effects", "residuals")}
    fit_plots.plot_response(pictures / drawn["response"], table, fits)
    fit_plots.plot_parity(pictures / drawn["parity"], table, fits)
    fit_plots.plot_effects(pictures / drawn["effects"], fits, fits.chosen)
    fit_plots.plot_residuals(pictures / drawn["residuals"], table, fits, fits.chosen)
    found["pictures"] |= drawn


def _plot_angles(pictures: Path, found: dict[str, Any]) -> None:
    law, supports = found["angle_law"], found["throw"]["supports"]

    def values(column: list[float | None]) -> NDArray[np.float64]:
        return np.array([math.nan if value is None else value for value in column])

    formula_plots.plot_formulas(
        pictures / "formulas.svg",
        np.array(law["gamma_deg"]),
        np.array(law["fe"]),
        {name: values(column) for name, column in law["formulas"].items()},
        (supports["guided"]["axial_compliance"], supports["pinned"]["axial_compliance"]),
    )
    found["pictures"]["formulas"] = "formulas.svg"
    if law["law"] is not None:
        gammas, fe = np.array(law["gamma_deg"]), np.array(law["fe"])
        factors = {name: factor(gammas) for name, factor in ANGLE_FACTORS.items()}
        formula_plots.plot_angle_factors(
            pictures / "angles.svg", gammas, fe / fe[-1], law["law"]["rho"], factors
        )
        found["pictures"]["angles"] = "angles.svg"
