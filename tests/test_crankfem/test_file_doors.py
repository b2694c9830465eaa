"""Every value of an input file changes an answer, is refused, or is named as not used."""

import pytest

from crankbase.model import part_kind
from crankfem.files.chain.chain_file import KINDS
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.used_values import ALL, USES
from file_doors import CHANGED, DOORS, LEFT, NAMED, REFUSED, WRONG, look, shipped_content

MODELS = {name: section.model for name, section in SECTIONS.items()} | {"chain": KINDS["torsional"]}
# The full engine with a check of two masses; a chain with damping to ground.
CHEAP = {
    **dict.fromkeys(("lookup law", "two-mass", "plan"), "yamz-5340"),
    **dict.fromkeys(("mechanism", "harmonics"), "yamz-5340"),
    "chain": "mwm-six",
}
SLOWER = ("mechanism", "harmonics")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.further if name in SLOWER else pytest.mark.slow)
        for name in CHEAP
    ],
)
def test_no_value_of_a_file_is_dropped_unsaid(name, tmp_path):
    kind, door = DOORS[name]
    found = list(look(door, kind, shipped_content(kind, CHEAP[name]), tmp_path))
    wrong = [(change.field, change.value) for change, told in found if told in (LEFT, WRONG)]
    assert wrong == []
    outcomes = [told for _, told in found]
    assert CHANGED in outcomes
    assert NAMED in outcomes
    assert {*outcomes} <= {CHANGED, NAMED, REFUSED}


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


@pytest.mark.parametrize("command", USES)
def test_what_commands_use_is_there(command):
    """No section or field of the table is one that files do not have."""
    used, without = USES[command]
    names = {name.removeprefix("*.") for name in (*used, *without)} - {ALL}
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
