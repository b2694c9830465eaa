"""All that reads what people write: for each parser its inputs, and what reads and calculates with them."""

import contextlib
import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

import crankfem as cf
from crankbase.errors import InputError
from crankbase.written_quantity import parse_quantity
from crankfem.files.engine.throw_file import load_study, load_throw_file
from crankfem.files.satellites import at_place, satellite_files
from dynamics.gas.pressure import read_pressure_table
from dynamics.harmonics import read_torque_table
from regression.models.compliance_model import checksum
from regression.plans.relations import (
    calculated,
    constraint_violations,
    read_constraint,
    read_expression,
)
from regression.runs.study import import_results
from satellite_cases import of_satellites
from strategies.files import NUMBERS, ROOT, UNITS, as_bytes, changed_json, changed_texts, texts_of
from strategies.outcomes import Outcome, outcome_of
from throws import MEDIUM_SPEED_TOML

THROW = (
    MEDIUM_SPEED_TOML
    + """fillet_radius = "12 mm"
[throw.counterweight]
outer_radius = "270 mm"
angle = "120 deg"
"""
)
STUDIES = tuple(
    THROW + text
    for text in (
        """
[study]
accuracy = 0.05
held_out = 4
seed = 3
[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
pin_length = { from = "120 mm", to = "158 mm", levels = 4, spacing = "chebyshev" }
web_outline = ["obround", "rectangle"]
""",
        """
[study]
design = "latin hypercube"
runs = 12
constraints = ["web_thickness < 0.6 * pin_diameter"]
[study.factors]
web_thickness = { from = "60 mm", to = "90 mm" }
ratio = { from = 1.5, to = 1.8 }
[study.relations]
web_width = "ratio * pin_diameter"
main_journal_length = "0.5 * web_thickness + 80 mm"
""",
        """
[study]
design = "central composite"
[study.factors]
web_thickness = { from = "60 mm", to = "90 mm" }
fillet_radius = { from = "8 mm", to = "14 mm" }
""",
        """
[study]
design = "file"
file = "designs.csv"
""",
    )
)
DESIGNS = (
    "web_width [mm],web_thickness\n285,68 mm\n300,70 mm\n270,60 mm\n",
    "pin_length;fillet_radius\n139 mm;12 mm\n130 mm;9 mm\n",
)
RESULTS = (
    "web_width [mm],pin_length [mm],axial_compliance_pinned [nm/N],role,source\n"
    "301.5,139,1.42,measured,bench\n285,139,1.5,,x\n",
)
PRESSURES = (
    "# an example\ncrank_angle_deg,absolute_pressure_bar\n"
    + "".join(
        f"{10 * n},{1.0 + 80.0 * max(0.0, 1.0 - abs(n - 1) / 12):.3f}\n" for n in range(-36, 37)
    ),
    "crank_angle_deg,gauge_pressure_MPa\n"
    + "".join(f"{10 * n},{0.05 + 6.0 * max(0.0, 1.0 - abs(n - 1) / 12):.3f}\n" for n in range(36)),
)
CHAIN_TEXTS = (
    """torsional: two disks
flywheel  211.4 kg m^2
  9.775e6 N m/rad  loss 0.02
rotor  8.3 kg m^2  ground damping 3 N m s/rad
  1e6 N m/rad  inertia 0.4 kg m^2  damping 12 N m s/rad
fan  2 kg m^2  ground 100 N m/rad
  gear 2.5
machine  3 kg m^2
""",
    "axial\na  60 kg\n  1e9 N/m\nb  70 kg  ground 5e8 N/m\n  dashpot 100 N s/m\nc  8 kg\n",
)
RELATIONS = (
    "ratio * pin_diameter",
    "0.5 * web_thickness + 80 mm",
    "2 mm ** 2 / (web_width - 3 mm)",
    "ratio ^ -2 * 410 mm",
)
CONSTRAINTS = (
    "web_thickness < 0.6 * pin_diameter",
    "1 mm <= web_width - web_thickness <= 2 m",
    "0.2 <= web_thickness / pin_diameter",
)
UNIT_OF = {"web_width": "m", "web_thickness": "m", "pin_diameter": "m", "ratio": ""}


@dataclass(frozen=True)
class Parser:
    """A reader, how its file is called, and what it is given."""

    inputs: st.SearchStrategy[bytes]
    read: Callable[[Path], Any]
    file: str = "mine.toml"
    # Of the inputs that others are given, where each takes long.
    share: float = 1.0

    def attempt(self, content: bytes, folder: Path) -> Outcome:
        """Write a file into a folder, read it, and tell what came of it."""
        path = folder / self.file
        path.write_bytes(content)
        return outcome_of(lambda: self.read(path))


def lay_out(folder: Path) -> None:
    """Copy into a folder what the files in it name."""
    for line in (ROOT / "tests" / "data" / "engines").glob("line-*.toml"):
        shutil.copy(line, folder)


def _file(reader: Callable[[str], Any]) -> Callable[[Path], Any]:
    """Let what reads text read a file, as far as that is text."""
    return lambda path: reader(path.read_bytes().decode("utf-8", "replace"))


def _chain(read: Callable[[Any], Any], given: Any) -> Any:
    found = read(given)
    return found, found.chain.modes()


def _throw(path: Path) -> Any:
    read = load_throw_file(path)
    return read, [(one.parts, one.volume, one.changed()) for one in read.throws.values()]


def _study(path: Path) -> Any:
    plan = load_study(path)
    return plan, plan.planned


def _designs(path: Path) -> Any:
    study = path.with_name("study.toml")
    study.write_text(STUDIES[-1], encoding="utf-8")
    return _study(study)


def _results(path: Path) -> Any:
    study, store = path.with_name("study.toml"), path.with_name("runs.sqlite")
    store.unlink(missing_ok=True)
    study.write_text(STUDIES[0], encoding="utf-8")
    return import_results(load_study(study), store, path, alone=True)


def _mechanism(path: Path) -> Any:
    mechanism = cf.load_mechanism(path)
    return mechanism, cf.run_mechanism(mechanism)


def _looked_up(path: Path) -> Any:
    """Load a model, and look its responses up in the middle of its ranges."""
    model = cf.ComplianceModel.load(path)
    inside = {name: (low + high) / 2.0 for name, (low, high) in model.family.ranges.items()}
    inside |= {name: labels[0] for name, labels in model.family.categories.items()}
    return [
        model.lookup(name, gamma_deg=120.0 if "neighbors" in name else None, **inside)
        for name in model.responses
    ]


@st.composite
def model_files(draw: st.DrawFn) -> str:
    """Draw a model with something changed, most with a checksum that fits all the same."""
    changed = draw(changed_json(json.loads(draw(st.sampled_from(models())))))
    if draw(st.integers(0, 9)) and isinstance(changed, dict):
        changed.pop("checksum", None)
        inner = {key: one for key, one in changed.items() if key not in ("format", "version")}
        changed["checksum"] = checksum(inner)
    return json.dumps(changed)


def models() -> tuple[str, ...]:
    """Return the texts of two models: a small one, and that of a study of three factors."""
    from fitted_models import known_model

    if not _MODELS:
        throw, material = cf.load_throw("6chn25-34")
        compliances = {"axial_compliance": 1.3e-9, "torsional_compliance": 4e-8}
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "small.json"
            known_model(throw, material, compliances, 0.01).save(path)
            _MODELS.append(path.read_text(encoding="utf-8"))
    return tuple(_MODELS)


_MODELS: list[str] = []


def _toml(*patterns: str, more: tuple[str, ...] = ()) -> st.SearchStrategy[bytes]:
    return as_bytes(changed_texts(texts_of(*patterns) + more))


def _csv(texts: tuple[str, ...]) -> st.SearchStrategy[bytes]:
    return as_bytes(changed_texts(texts))


ENGINES = (
    "data/engines/*.toml",
    "tests/data/unequal-three.toml",
    "tests/data/engines/[58]*.toml",
    "tests/data/engines/v*.toml",
)
CHAINS = ("data/chains/*.toml", "tests/data/engines/line-*.toml")
QUANTITIES = st.one_of(
    st.tuples(
        st.sampled_from(NUMBERS), st.sampled_from((" ", "", "\t")), st.sampled_from(UNITS)
    ).map("".join),
    st.text(max_size=20),
    st.from_regex(
        r"[-+]?[0-9.]{1,6}(e[0-9-]{1,4})? ?[a-zµ]{1,3}([*/ ^][a-z0-9-]{1,3}){0,3}", fullmatch=True
    ),
)


def _quantity(text: str) -> Any:
    found = []
    for unit in ("m", "rad/s", ""):
        with contextlib.suppress(InputError):
            found.append(parse_quantity(text, unit, "field"))
    return found or parse_quantity(text, "m", "field")


def _relation(text: str) -> Any:
    ones = {name: np.array([0.1, 1.0]) for name in UNIT_OF}
    return calculated(read_expression(text, "field", UNIT_OF), ones, UNIT_OF)


def _constraint(text: str) -> Any:
    ones = {name: np.array([0.1, 1.0]) for name in UNIT_OF}
    return constraint_violations(read_constraint(text, "field", UNIT_OF), ones, UNIT_OF, 2)


def parsers() -> dict[str, Parser]:
    """Return all parsers by name."""
    return {
        "engine file": Parser(_toml(*ENGINES), cf.load_engine),
        "mechanism file": Parser(_toml(*ENGINES), cf.load_mechanism),
        "throw file": Parser(_toml(*ENGINES, more=(THROW,)), _throw),
        "crankshaft of a file": Parser(_toml(*ENGINES), cf.load_crankshaft),
        "chain file": Parser(_toml(*CHAINS), partial(_chain, cf.load_chain)),
        "chain as text": Parser(_csv(CHAIN_TEXTS), partial(_chain, cf.load_chain), "mine.txt"),
        **{
            f"{kind} file": Parser(_toml(f"data/{kind}s/*.toml"), at_place(own.reader))
            for kind, own in satellite_files().items()
        },
        "study file": Parser(_csv(STUDIES[:3]), _study),
        "model file": Parser(as_bytes(model_files()), _looked_up, "model.json"),
        "pressure table": Parser(_csv(PRESSURES), read_pressure_table, "mine.csv"),
        "torque table": Parser(
            _csv(texts_of("data/tables/yamz5340_torque*.csv")),
            lambda path: read_torque_table(path).harmonics(),
            "mine.csv",
        ),
        "design table": Parser(_csv(DESIGNS), _designs, "designs.csv"),
        "results table": Parser(_csv(RESULTS), _results, "mine.csv"),
        "quantity": Parser(
            QUANTITIES.map(lambda text: text.encode("utf-8", "replace")), _file(_quantity)
        ),
        "relation": Parser(_csv(RELATIONS), _file(_relation)),
        "constraint": Parser(_csv(CONSTRAINTS), _file(_constraint)),
        "forces of a mechanism": Parser(_toml(*ENGINES), _mechanism, share=0.1),
        **{
            f"{kind} calculated": Parser(_toml(f"data/{kind}s/*.toml"), calculate, share=0.05)
            for kind, calculate in of_satellites("OF_A_FILE").items()
        },
    }


__all__ = ["ROOT", "Parser", "parsers"]
