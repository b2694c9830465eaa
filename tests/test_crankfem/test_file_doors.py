"""Every value of an input file changes an answer, is refused, or is named as not used."""

import contextlib
import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from crankbase.errors import InputError
from crankbase.model import part_kind
from crankfem.analyses.engine_mechanism import engine_inputs
from crankfem.files.chain.chain_build import KINDS
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.throw_file import load_throw, unused_throws
from crankfem.files.engine.used_values import ALL, USES, command_use, not_used, not_used_of
from crankfem.files.reading.data_files import data_folder
from crankfem.files.reading.toml_file import read_toml
from crankfem.files.sections.crank_throws import NamedThrow
from dynamics.chains.varying import Variation
from dynamics.gas.pressure import read_pressure_table
from dynamics.harmonics import read_torque_table
from fem.material import STEEL
from file_doors import (
    CHANGED,
    DOORS,
    LEFT,
    NAMED,
    REFUSED,
    SHARE,
    WRONG,
    Answer,
    beside,
    command,
    leaves,
    look,
    shipped_content,
)
from file_fields import fields
from fitted_models import known_model
from regression.models.compliance_model import ComplianceModel
from satellite_cases import of_satellites

DATA = Path(__file__).parents[1] / "data"
EVERY_USE = {**USES, **of_satellites("USES")}
# Files that together have every field.
FULL = {path.stem: path for path in sorted(DATA.rglob("full-*.toml"))}
# Sections with the fields of another one, which are read by its model.
LIKE = {"driver": "driven"}
# Fields that no file can have, and why.
REFUSED_EVERYWHERE = {
    **dict.fromkeys(
        (f"{part}.variation.amplitude" for part in ("torsional_damper", "driven", "bearings")),
        "natural frequencies and the verdict know no amplitude",
    ),
    "torsional_damper.variation.damping": "rubber is damped by its loss factor alone",
}
MODELS = {name: section.model for name, section in SECTIONS.items()} | {
    "chain": KINDS["torsional"].section
}
# By door, cheap ones first, files that it reads; of a chain one with damping to ground.
CHEAP = {
    "lookup law": ("yamz-5340", "full-propeller", "full-set"),
    "two-mass": ("yamz-5340", "full-vee"),
    "plan": ("yamz-5340", "full-vee", "full-split", "full-throw", "full-motor"),
    "chain": ("mwm-six",),
    "mechanism": ("yamz-5340", "full-vee", "full-split"),
    "harmonics": ("yamz-5340", "full-vee", "full-split"),
}
SLOWER = ("mechanism", "harmonics")


@pytest.mark.parametrize(
    ("name", "file"),
    [
        pytest.param(name, file, marks=pytest.mark.further if name in SLOWER else pytest.mark.slow)
        for name, files in CHEAP.items()
        for file in files
    ],
)
def test_no_value_of_a_file_is_dropped_unsaid(name, file, tmp_path):
    kind, *doors = DOORS[name]
    given = str(FULL.get(file, file))
    beside(given, kind, tmp_path)
    found = list(look(doors, kind, shipped_content(kind, given), tmp_path))
    wrong = [(change.field, change.value) for change, told in found if told in (LEFT, WRONG)]
    assert wrong == []
    outcomes = [told for _, told in found]
    assert CHANGED in outcomes
    assert NAMED in outcomes or file == "full-throw"  # which is a plan and no more
    assert {*outcomes} <= {CHANGED, NAMED, REFUSED}


def test_a_saved_model_replaces_that_of_the_file(tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"vibration.model": '"model.json"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    for name, coupled in (("run", {}), ("vibration", {"coupled": True}), ("vibration", {})):
        for model in (None, "other.json"):
            key = command_use(name, {"model": model, **coupled})
            named = not_used_of(str(tmp_path / "mine.toml"), key)
            assert ("vibration.model" in named) == (model is not None)
            assert "study" in named


@pytest.mark.slow
def test_a_value_that_a_deck_has_is_not_named_as_not_used(tmp_path, six_cylinders, edit):
    answers = []
    for density in ("7850 kg/m^3", "7000 kg/m^3"):
        changed = edit(six_cylinders, {"material.density": f'"{density}"'})
        (tmp_path / "mine.toml").write_text(changed, "utf-8")
        answers.append(DOORS["export --calculix"][1](tmp_path / "mine.toml"))
    assert not answers[0].same(answers[1])
    assert "material.density" not in answers[0].named
    assert "rod" in answers[0].named


def _numbers_changed(text):
    """Text with each number of its lines but headings and comments, one changed by 3 %."""
    for number in re.finditer(
        r"(?<![\w.#^])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?= |,|$)", text, re.MULTILINE
    ):
        line = text[text.rfind("\n", 0, number.start()) + 1 : number.start()]
        if not line.startswith("#"):
            value = float(number[0])
            other = value * (1.0 + SHARE) if value else SHARE
            yield text[: number.start()] + repr(other) + text[number.end() :]


TABLES = {
    "torque": (
        (data_folder() / "tables/yamz5340_torque_one_throw.csv").read_text(encoding="utf-8"),
        lambda file: read_torque_table(file, strokes=4).harmonics().cosine.tolist(),
    ),
    "pressure": (
        "crank_angle_deg,absolute_pressure_bar\n"
        + "\n".join(
            f"{5 * k},{20 + 15 * math.cos(math.radians(5 * k)):.6g}" for k in range(0, 72, 2)
        ),
        lambda file: read_pressure_table(file, 2).at(angle_deg=np.arange(0.0, 360.0, 1.0)).tolist(),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", TABLES)
def test_every_cell_of_a_table_changes_what_is_made_of_it(kind, tmp_path):
    text, read = TABLES[kind]
    file = tmp_path / "table.csv"

    def answer(content):
        file.write_text(content, encoding="utf-8")
        try:
            return Answer(read(file))
        except InputError:
            return None

    before = answer(text)
    others = [answer(other) for other in _numbers_changed(text)]
    assert len(others) >= 72
    alike = [place for place, other in enumerate(others) if other and other.same(before)]
    assert alike == []


CHAIN_TEXT = """
torsional chain: two shafts

motor  0.4e-3 kg m^2  ground damping 2 N m s/rad
  10 kN m/rad  loss 0.02  damping 3 N m s/rad
pinion  25e-6 kg m^2
  dashpot 0.5 N m s/rad
  gear -2  to wheel
rotor  0 kg m^2  ground 5 N m/rad
  5000 N m/rad  inertia 2e-4 kg m^2
wheel  1 kg m^2
  6000 N m/rad  from pinion  to motor
"""


@pytest.mark.slow
def test_damping_in_the_text_of_a_chain_is_named_as_not_used(tmp_path):
    """Of 14 numbers four are damping, which natural frequencies do not depend on."""
    file = tmp_path / "chain.txt"
    ask = command("vibration", "FILE")

    def answer(content):
        file.write_text(content, encoding="utf-8")
        return ask(file)

    before = answer(CHAIN_TEXT)
    assert before.named == (
        "chain.elements.damping",
        "chain.elements.loss_factor",
        "chain.nodes.ground_damping",
        "chain.dashpots",
    )
    assert (
        answer(re.sub("  (damping|loss|ground damping) .*|  dashpot.*", "", CHAIN_TEXT)).named == ()
    )
    unlike = [not answer(other).same(before) for other in _numbers_changed(CHAIN_TEXT)]
    # Of the lines in turn; the ratio of the gear stands behind the dashpot.
    damps = [False, True, False, True, True, False, True, *(False,) * 7]
    assert unlike == [not one for one in damps]


def test_no_number_of_a_stored_model_can_be_changed(tmp_path):
    """Its checksum covers all of it."""
    throw = load_engine("yamz-5340").throw.model_copy(update={"web_thickness": 0.06})
    file = tmp_path / "model.json"
    known_model(throw, STEEL, {"axial_compliance": 1e-9}, 0.01).save(file)
    ComplianceModel.load(file)
    others = list(_numbers_changed(file.read_text(encoding="utf-8")))
    assert len(others) > 10
    for other in others:
        file.write_text(other, encoding="utf-8")
        with pytest.raises(InputError, match=r"checksum|version"):
            ComplianceModel.load(file)


def test_a_command_that_takes_no_chain_refuses_one_in_a_sentence():
    for name in ("run", "mechanism", "draw"):
        with pytest.raises(InputError, match="is a chain"):
            command(name, "mwm-six")(Path("mwm-six"))


def test_every_field_stands_in_a_file_whose_values_are_changed():
    """No field of an engine file is forgotten where doors are looked at."""
    there: set[str] = set()
    for path in FULL.values():
        for place, *_ in leaves(tomllib.loads(path.read_text(encoding="utf-8"))):
            names = _declared(place)
            there |= {".".join(names[:depth]) for depth in range(1, len(names) + 1)}
    known = {".".join(_declared(path)) for kind, path, *_ in fields() if kind == "engine"}
    assert known - there == set(REFUSED_EVERYWHERE)


def _declared(place):
    """The path of a field in its section: throws by name have the fields of [throw]."""
    section, *inner = place
    if section == "throws" and len(inner) > 1:
        inner = inner[1:]
        section = section if inner[0] in NamedThrow.model_fields else "throw"
    return (LIKE.get(section, section), *inner)


NO_TABLES = [
    '[throw]\nleft_web = "x"\nright_web = 3\nfurther_pins = 4',
    '[throw]\nleft_web = []\nright_web = {a = 1}\nfurther_pins = ["a"]',
    "[throw]\n[load]\npoints = [3]\n[gas]\nmean_effective_pressure = 1\nintake_pressure = 2",
    '[throws]\na = 3\n[study]\nthrow = ["a"]',
    '[throws.a]\nlike = ["b"]\n[shaft]\nthrows = 3',
    '[throws.a]\nlike = "b"\n[throws.b]\nlike = "a"\n[shaft]\nthrows = [["a"], "b"]',
]


@pytest.mark.parametrize("text", NO_TABLES)
def test_what_is_not_used_of_a_file_with_errors_is_no_error(text, tmp_path):
    """It is named before the command reads the file, which tells what is wrong if this does not."""
    file = tmp_path / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    content = read_toml(file)
    for name in EVERY_USE:
        with contextlib.suppress(InputError):
            assert isinstance(not_used(content, name), tuple)


def test_of_a_throw_that_is_like_another_the_fields_that_it_replaces_are_not_used():
    names = unused_throws(FULL["full-vee"], "rear")
    assert names == ["throws.front.web_thickness"]
    assert unused_throws(FULL["full-vee"], None) == ["throws.rear"]


@pytest.mark.parametrize("overhang", ['"55 mm"', None])
def test_a_flange_tells_at_most_where_the_flywheel_is(tmp_path, edit, overhang):
    text = edit(FULL["full-set"].read_text(encoding="utf-8"), {"flywheel.overhang": overhang})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    names = not_used(read_toml(tmp_path / "mine.toml"), "vibration --coupled")
    assert "shaft_ends.flange_diameter" in names
    assert ("shaft_ends.flange_thickness" in names) is (overhang is not None)
    assert "shaft_ends.free_end_length" not in names


def test_values_in_whose_place_others_stand_are_named():
    names = not_used(read_toml(FULL["full-throw"]), "throw")
    both = ("outline", "tip_thickness", "foot_thickness", "journal_end", "pin_end")
    replaced = {f"throw.web_{kind}" for kind in (*both, "thickness", "width")}
    assert replaced <= {*names}
    assert "throw.web_corner_radius" not in names
    # A study has them in its key.
    assert not replaced & {*not_used(read_toml(FULL["full-throw"]), "plan")}


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({}, True),
        ({"main_journal_bore_offset": '"2 mm"'}, False),
        ({"pin_diameter": '"114 mm"'}, False),
    ],
)
def test_what_is_round_about_the_shaft_has_no_unbalance(changed, named, tmp_path, edit):
    text = FULL["full-set"].read_text(encoding="utf-8")
    values = {f"throw.{name}": value for name, value in changed.items()}
    file = tmp_path / "file.toml"
    file.write_text(edit(text, values), encoding="utf-8")
    names = not_used(read_toml(file), "mechanism")
    assert "throw.main_journal_fillet_radius" in names
    assert ("throw.main_journal_bore" in names) is named


def test_angles_of_throws_stand_for_those_of_cranks_in_a_crankshaft():
    content = read_toml(FULL["full-vee"])
    assert "engine" in not_used(content, "export --shaft")
    assert "engine" not in not_used(read_toml(FULL["full-set"]), "export --shaft")


def test_names_of_throws_along_the_shaft_are_checked(tmp_path):
    text = FULL["full-vee"].read_text(encoding="utf-8")
    file = tmp_path / "vee.toml"
    file.write_text(
        text.replace('throws = ["front", "rear"]', 'throws = ["front", "reer"]'), "utf-8"
    )
    with pytest.raises(InputError, match=r"shaft\.throws: given 'reer'"):
        load_throw(file)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"speed": (1.0, 2.0), "at_torque": 5.0}, "at_torque"),
        ({"speed": (1.0, 2.0), "at_temperature": 300.0}, "at_temperature"),
    ],
)
def test_a_point_of_what_nothing_varies_over_is_refused(given, field):
    with pytest.raises(InputError, match=rf"variation\.{field}: given without"):
        Variation(stiffness=(1.0, 1.1), **given)


def test_damping_that_varies_over_none_is_refused():
    varying = Variation(speed=(1.0, 2.0), stiffness=(1.0, 1.1), damping=(1.0, 1.2))
    with pytest.raises(InputError, match=r"variation\.damping: "):
        varying.of(1e3, loss_factor=0.1)
    assert varying.of(1e3, damping=2.0).damping == 2.0


@pytest.mark.parametrize("command", EVERY_USE)
def test_what_commands_use_is_there(command):
    """No section or field of the table is one that files do not have."""
    used, without = EVERY_USE[command]
    names = {name.removeprefix("*.").replace("throws.*", "throw") for name in (*used, *without)} - {
        ALL
    }
    assert {name for name in names if not _is_a_place(name)} == set()


def _is_a_place(name):
    section, *path = name.split(".")
    if section not in MODELS:  # of a field in any place
        return any(section in model.model_fields for model in _all_parts(MODELS["chain"]))
    model = MODELS[section]
    for field in path:
        if model is None or field not in model.model_fields:
            return False
        model = part_kind(model.model_fields[field])
    return True


def _all_parts(model):
    yield model
    for info in model.model_fields.values():
        if (part := part_kind(info)) is not None:
            yield from _all_parts(part)


def test_files_of_tables_are_named_however_they_are_read():
    """How a table is read is told in a mapping."""
    names = [file.path.name for file in engine_inputs(load_engine(FULL["full-vee"]))]
    assert names[0] == "full-vee.toml"
    assert set(names[1:]) == {"full-vee.xlsx"}


@pytest.mark.further
def test_a_whole_crankshaft_is_judged_as_far_as_the_gas_is_known(coupled_vibration):
    """The rule of a limit goes to 1.15 of the rated speed, the map of the gas ends before."""
    run = coupled_vibration(FULL["full-propeller"])
    criticals = run.whole_crankshaft.criticals
    speeds = [peak.speed for kind in criticals.values() for peak in kind.peaks]
    assert criticals
    last = max(point.speed for point in run.engine_file.gas_map.points)
    assert all(speed <= last * (1.0 + 1e-9) for speed in speeds)
