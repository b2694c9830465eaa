import json
import os
import re
import subprocess
import sys
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crankbase.errors import InputError
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.cli import app as cli
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.reading.data_files import input_path
from fem.analysis import analyze_throw
from json_units import numbers_with_units
from parts_in_a_line import crank_throw
from plans import plan_of_levels
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.designs import full_factorial
from regression.plans.plan import MODEL_VERSION, plan_designs
from regression.records import Outcome
from regression.runs.store import ResultStore
from regression.runs.study import run_plan
from stand_ins import analyze_coarsely, draw_nothing, lighten, made_once

ROOT = Path(__file__).resolve().parents[2]
ENTRY = [sys.executable, "-c", "from crankfem.cli.entry import main; main()"]


@dataclass(frozen=True)
class Answer:
    """What a command line call gave."""

    code: int
    out: str
    err: str

    def json(self):
        """Return standard output as strict JSON, in which every number has a unit."""
        content = strict_json(self.out)
        numbers_with_units(content)
        return content


def strict_json(text):
    def refuse(constant):
        raise ValueError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def environment(**extra):
    paths = [str(ROOT), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))} | extra


def spawn_in(folder, *arguments, command=ENTRY, timeout=600, env=None):
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


THROW = crank_throw(0.170, 0.220, 0.180, 0.135, 0.139, 0.285, 0.068)
LEVELS = {"web_width": (0.27, 0.30, 0.33), "web_thickness": (0.038, 0.048, 0.077, 0.098)}
STRENGTH = """
[strength]
tensile_strength = "800 MPa"
manufacture = "free-form forged"
piston = "trunk"
oil_hole_diameter = "15 mm"
"""
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
def told(tmp_path):
    """Load a file with changes, and return the field that each sentence begins with."""

    def fields(load, text, changes, name="mine.toml"):
        for old, new in changes.items():
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError) as raised:
            load(path)
        return [line.removeprefix(f"{name}: ").split(": ")[0] for line in raised.value.sentences]

    return fields


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


@pytest.fixture
def lightly(monkeypatch):
    """Let runs in this process share analyses and coarse stresses of their throws, and render nothing."""
    lighten(monkeypatch)


@pytest.fixture
def unseen(lightly, monkeypatch):
    """The same with empty diagrams."""
    draw_nothing(monkeypatch)


@pytest.fixture
def coarsely(unseen, monkeypatch):
    """The same with throws analyzed as coarsely as may be."""
    analyze_coarsely(monkeypatch)


@cache
def _coarsely_analyzed(name):  # of a process, whichever folder of tests takes the fixture
    engine = load_engine(name)
    return engine, analyze_throw(engine.throw, engine.material, 0.1)


@pytest.fixture(scope="session")
def coarse_throw():
    """Read a shipped engine and analyze its throw as coarsely as may be: (engine file, analysis)."""
    return _coarsely_analyzed


@pytest.fixture(scope="session")
def coupled_vibration(coarse_throw):
    """Vibration of a shipped engine beside its whole crankshaft, with the coarse throw."""

    @cache
    def run(name):
        engine, analysis = coarse_throw(name)
        return engine_vibration(engine, analysis=analysis, coupled=True)

    return run


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
    return input_path("6chn25-34").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def quick_six(six_cylinders):
    """The same with a study of three runs of one dimension, coarsely meshed, and strength judged.

    One cylinder fails, not each in turn: fatigue is looked for at all speeds in each case.
    """
    levels = '["60 mm", "68 mm", "76 mm"]'
    text = edited(six_cylinders, QUICK_STUDY | {"study.factors.web_thickness": levels})
    return f"{text}{STRENGTH}\n[misfire]\ncylinders = [4]\n"


@pytest.fixture(scope="session")
def quick_four():
    """The four-cylinder engine with torque table and two-mass check, and a small study."""
    text = input_path("yamz-5340").read_text(encoding="utf-8")
    levels = '["23 mm", "25 mm", "27 mm"]'
    return edited(text, QUICK_STUDY | {"study.factors.web_thickness": levels})


@pytest.fixture(scope="session")
def least_engine(six_cylinders):
    """The six-cylinder engine with one crank and the least of inputs."""
    gone = ("material", "free_end", "gas", "vibration", "study", "study.factors")
    changes = {f"[{name}]": None for name in gone} | {
        "engine.cylinders": "1",
        "engine.crank_angles": '["0 deg"]',
        "engine.firing_order": "[1]",
        "thrust_bearing.main_bearing": "2",
    }
    return edited(six_cylinders, changes)


@dataclass(frozen=True)
class Run:
    """A finished run from the command line."""

    folder: Path
    answer: Answer
    results: dict


@pytest.fixture(scope="session")
def finished_run(tmp_path_factory, quick_six):
    def run(folder):
        (folder / "quick.toml").write_text(quick_six, encoding="utf-8")
        given = asdict(spawn_in(folder, "run", "quick.toml", "--json"))
        (folder / "answer.json").write_text(json.dumps(given), encoding="utf-8")

    folder = made_once(tmp_path_factory, "finished-run", run)
    answer = Answer(**json.loads((folder / "answer.json").read_text(encoding="utf-8")))
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


@pytest.fixture
def store(tmp_path):
    """A store whose results are calculated, not computed by finite elements."""
    plan = plan_of_levels(THROW, LEVELS, held_out=5)
    path = tmp_path / "runs.sqlite"
    with ResultStore(path) as results:
        for design in plan_designs(plan).designs:
            B, h = (design.inputs["throw"][name] for name in LEVELS)
            e = 1e-9 * (0.2 + 0.3 / B * (0.05 / h) ** 1.5)
            responses = {"axial_compliance_pinned": e, "mass": 2000.0 * B * h + 40.0}
            errors = dict.fromkeys(responses, 0.008)
            outcome = Outcome(design.key, design.inputs, responses, None, 1.0, errors=errors)
            results.record(outcome, MODEL_VERSION)
    run_plan(plan, path)  # computes nothing, but registers the study
    return path
