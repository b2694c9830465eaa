import importlib
import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crankbase.errors import MissingLibraryError
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.cli import app as cli
from crankfem.files.reading.data_files import engine_path
from fem import fillet_stress
from fem.analysis import analyze_throw
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.designs import full_factorial

ROOT = Path(__file__).resolve().parents[2]
ENTRY = [sys.executable, "-c", "from crankfem.cli.entry import main; main()"]


@dataclass(frozen=True)
class Answer:
    """What a command line call gave."""

    code: int
    out: str
    err: str

    def json(self):
        """Return standard output as strict JSON."""
        return strict_json(self.out)


def strict_json(text):
    def refuse(constant):
        raise ValueError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def environment(**extra):
    paths = [str(ROOT), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))} | extra


def spawn_in(folder, *arguments, command=ENTRY, timeout=180, env=None):
    done = subprocess.run(
        [*command, *map(str, arguments)],
        cwd=folder,
        env=env or environment(),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    return Answer(done.returncode, done.stdout, done.stderr)


def edited(text, changes):
    """Change the text of an engine file.

    ``"throw.pin_length": "139"`` sets (or adds) a field, ``None`` removes it, and
    ``"[rod]": None`` removes a section.
    """
    blocks = re.split(r"(?m)^(?=\[)", text)
    for key, new in changes.items():
        if key.startswith("["):
            kept = [block for block in blocks if not block.startswith(key)]
            assert len(kept) < len(blocks), key
            blocks = kept
            continue
        section, _, name = key.rpartition(".")
        place = next(i for i, block in enumerate(blocks) if block.startswith(f"[{section}]"))
        line = re.compile(rf"(?m)^{re.escape(name)} *=.*\n")
        if line.search(blocks[place]) is None:
            assert new is not None, key
            header = f"[{section}]\n"
            blocks[place] = blocks[place].replace(header, f"{header}{name} = {new}\n", 1)
        else:
            given = "" if new is None else f"{name} = {new}\n"
            blocks[place] = line.sub(lambda _, given=given: given, blocks[place])
    return "".join(blocks)


QUICK_STUDY = {
    "study.held_out": "2",
    "study.accuracy": "0.1",
    "study.factors.web_width": None,
    "study.factors.pin_length": None,
}


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def edit():
    return edited


@pytest.fixture
def call(monkeypatch, capsys):
    """Run the command line in this process."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["crankfem", *map(str, arguments)])
        capsys.readouterr()
        try:
            cli.main()
            code = 0
        except SystemExit as error:
            code = error.code or 0
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return run


analyzed = cache(analyze_throw)
stressed = cache(fillet_stress.fillet_stresses)


class NotRendered:
    """The rendering of a machine without an OpenGL library."""

    def __init__(self, *_):
        self.files = {}

    def wait(self):
        raise MissingLibraryError("there is no OpenGL library")

    def stop(self):
        pass


def put_everywhere(monkeypatch, original, other):
    """Put another function or class in the place of one, in all modules of crankfem that use it."""
    for name, module in list(sys.modules.items()):
        if name.startswith("crankfem.") and vars(module).get(original.__name__) is original:
            monkeypatch.setattr(module, original.__name__, other)


@pytest.fixture
def lightly(monkeypatch, coarse_stresses):
    """Let runs in this process share analyses and coarse stresses of their throws, and render nothing."""
    importlib.import_module("crankfem.jobs.pipeline")  # loads whatever runs use
    put_everywhere(monkeypatch, analyze_throw, analyzed)
    for kind in OffscreenProcess.__subclasses__():
        put_everywhere(monkeypatch, kind, NotRendered)
    for name, value in coarse_stresses.items():
        monkeypatch.setattr(fillet_stress, name, value)
    monkeypatch.setattr(fillet_stress, "fillet_stresses", stressed)


@pytest.fixture
def spawn(tmp_path):
    """Run the command line, or another command, in a process of its own."""

    def run(*arguments, **options):
        return spawn_in(options.pop("folder", tmp_path), *arguments, **options)

    return run


@pytest.fixture(scope="session")
def strict():
    return strict_json


@pytest.fixture(scope="session")
def spawn_environment():
    return environment


@pytest.fixture(scope="session")
def six_cylinders():
    """Text of a shipped engine file."""
    return engine_path("6chn25-34").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def quick_six(six_cylinders):
    """The same with a study of three runs of one dimension, coarsely meshed."""
    levels = '["60 mm", "68 mm", "76 mm"]'
    return edited(six_cylinders, QUICK_STUDY | {"study.factors.web_thickness": levels})


@pytest.fixture(scope="session")
def quick_four():
    """The four-cylinder engine with torque table and two-mass check, and a small study."""
    text = engine_path("yamz-5340").read_text(encoding="utf-8")
    levels = '["23 mm", "25 mm", "27 mm"]'
    return edited(text, QUICK_STUDY | {"study.factors.web_thickness": levels})


@dataclass(frozen=True)
class Run:
    """A finished run from the command line."""

    folder: Path
    answer: Answer
    results: dict


@pytest.fixture(scope="session")
def finished_run(tmp_path_factory, quick_six):
    folder = tmp_path_factory.mktemp("run")
    (folder / "quick.toml").write_text(quick_six, encoding="utf-8")
    answer = spawn_in(folder, "run", "quick.toml", "--json")
    assert answer.code == 0, answer.err
    text = (folder / "quick-results" / "results.json").read_text(encoding="utf-8")
    return Run(folder / "quick-results", answer, strict_json(text))


@pytest.fixture
def model_file(tmp_path):
    """A compliance model of two dimensions with known equations."""
    factors = ("web_width", "web_thickness")
    box = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098)}
    runs = full_factorial({name: np.linspace(*ends, 3).tolist() for name, ends in box.items()}).runs
    held = np.array([[0.278, 0.091], [0.293, 0.045], [0.308, 0.076], [0.323, 0.061]])

    def response(function, symbol, unit):
        fit = fit_form("quadratic", factors, runs, function(runs), held, function(held))
        return ResponseModel.from_fit(fit, symbol=symbol, unit=unit)

    model = ComplianceModel(
        responses={
            "axial_compliance": response(
                lambda x: 1e-9 * (1.0 + 10.0 * (0.3 - x[:, 0]) + 5.0 * (0.068 - x[:, 1])),
                "e_n",
                "m/N",
            ),
            "torsional_compliance": response(
                lambda x: 4e-8 * (1.0 + (0.3 - x[:, 0]) + (0.068 - x[:, 1])), "e_t", "rad/(N m)"
            ),
        },
        fixed={"pin_length": 0.139, "crank_radius": 0.170},
    )
    path = tmp_path / "model.json"
    model.save(path)
    return path
