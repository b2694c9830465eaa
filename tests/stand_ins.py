"""Light runs: what takes long and is tested elsewhere is done once, coarsely or not at all."""

import importlib
import json
import os
import sys
import time
from functools import cache
from pathlib import Path
from unittest.mock import Mock

from matplotlib.figure import Figure
from typer.testing import CliRunner

import crankfem as cf
from crankbase.errors import MissingLibraryError
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.vibration.run import engine_vibration
from fem import fillet_stress
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.modes import dynamic_superelement
from satellite_cases import of_satellites

# Constants of fem.fillet_stress with which meshes are as coarse as can be.
COARSE_STRESSES = {"BULK": 2.5, "COARSE": 1.0, "COARSEST": 0.5, "FINE": 1.5, "MOST_MESHES": 2}
PACKAGES = ("crankfem", "geometry", "fem", "regression", "dynamics")

analyzed = cache(analyze_throw)
stressed = cache(fillet_stress.fillet_stresses)
condensed = {}  # by mesh and frequency, beside the mesh, which has no hash
vibrations = {}  # by the engine's file and whether with the whole crankshaft


def analysis_with(**fields):
    """A throw's analysis that has these fields alone."""
    return Mock(spec=ThrowAnalysis, **fields)


def condensed_once(mesh, material, classes, highest_frequency, **options):
    """Return the dynamic superelement of an analysis, the same one whenever it is asked for."""
    key = (id(mesh), material, highest_frequency, *sorted(options.items()))
    if key not in condensed:
        found = dynamic_superelement(mesh, material, classes, highest_frequency, **options)
        condensed[key] = mesh, found
    return condensed[key][1]


class NotRendered:
    """The rendering of a machine without an OpenGL library."""

    def __init__(self, *_):
        self.files = {}

    def wait(self):
        raise MissingLibraryError("there is no OpenGL library")

    def stop(self):
        pass


def save_nothing(figure, path, **_):
    """Write an empty diagram: to lay diagrams out takes half of a run."""
    Path(path).write_text('<svg xmlns="http://www.w3.org/2000/svg"/>', encoding="utf-8")


def put_everywhere(monkeypatch, original, other):
    """Put another function or class in the place of one, in all modules that have imported it."""
    name = original.__name__
    getattr(cf, name, None)  # crankfem keeps what it has once given
    for place, module in list(sys.modules.items()):
        if place.partition(".")[0] in PACKAGES and vars(module).get(name) is original:
            monkeypatch.setattr(module, name, other)


def lighten(monkeypatch):
    """Let runs in this process share analyses and coarse stresses of their throws, and render nothing."""
    importlib.import_module("crankfem.jobs.pipeline")  # loads whatever runs use
    offscreen = importlib.import_module("crankfem.analyses.throw.pictures.offscreen")
    put_everywhere(monkeypatch, analyze_throw, analyzed)
    put_everywhere(monkeypatch, fillet_stress.fillet_stresses, stressed)
    put_everywhere(monkeypatch, dynamic_superelement, condensed_once)
    for kind in offscreen.OffscreenProcess.__subclasses__():
        put_everywhere(monkeypatch, kind, NotRendered)
    stress_coarsely(monkeypatch)


def stress_coarsely(monkeypatch):
    """Let stresses be calculated on meshes as coarse as can be."""
    for name, value in COARSE_STRESSES.items():
        monkeypatch.setattr(fillet_stress, name, value)


def calculate_satellites_once(monkeypatch):
    """Let commands of satellites calculate once what takes them long."""
    for original, calculated in of_satellites("CALCULATED_ONCE").items():
        put_everywhere(monkeypatch, original, calculated)


def calculate_vibration_once(monkeypatch):
    """Let commands that look at the same engine share its vibration."""

    def once(engine, *, coupled=False, **options):
        key = engine.path, coupled
        if key not in vibrations:
            vibrations[key] = engine_vibration(engine, coupled=coupled, **options)
        return vibrations[key]

    put_everywhere(monkeypatch, engine_vibration, once)


def analyze_coarsely(monkeypatch):
    """Let light runs analyze their throws as coarsely as may be."""

    def coarse(throw, material, _accuracy=0.1, **options):
        return analyzed(throw, material, 0.1, **options)

    put_everywhere(monkeypatch, analyzed, coarse)


def draw_nothing(monkeypatch):
    """Leave diagrams empty where nothing depends on what they show."""
    monkeypatch.setattr(Figure, "savefig", save_nothing)


def made_once(tmp_path_factory, name, make):
    """Return a folder that one of the processes that share the tests fills, while the others wait."""
    root = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent
    folder, done = root / name, root / f"{name}-done"
    try:
        folder.mkdir()
    except FileExistsError:
        deadline = time.monotonic() + 600.0
        while not done.exists():
            assert time.monotonic() < deadline
            time.sleep(0.1)
        return folder
    try:
        make(folder)
    finally:
        done.touch()
    return folder


def stored_results():
    """Return the results of a whole run, as a file holds them; its worst check is the first one itself."""
    path = Path(__file__).with_name("test_crankfem") / "report_results.json"
    results = json.loads(path.read_text(encoding="utf-8"))
    assessment = results["vibration"]["assessment"]
    assessment["deciding"] = assessment["checks"][0]
    return results


def typed(content):
    """Return the results that a file of this content holds."""
    return RunResults.from_json(json.dumps(content))


def caller_of(app):
    """A function that calls a Typer app as a command line does, and returns what it prints."""

    def call(*arguments):
        answer = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if answer.exception is not None and not isinstance(answer.exception, SystemExit):
            raise answer.exception
        assert answer.exit_code == 0, answer.output
        return answer.stdout

    return call
