"""The sentence with which each door refuses a bad input, as it was last looked at."""

import re
import shlex

import numpy as np
import pytest

import crankfem as cf
from crankbase.errors import InputError
from crankbase.table import parse_output_units
from crankfem.analyses.engine_mechanism import load_any, pressures_at
from crankfem.analyses.file_check import check_file, refuse_what_cannot_run
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.vibration.engine_load import engine_load
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.chain.chain_file import load_chain, write_chain_text
from crankfem.files.engine.engine_file import load_mechanism
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.throw_file import load_study
from crankfem.files.reading.data_files import input_path
from crankfem.files.reading.toml_file import read_toml
from crankfem.files.sections.mechanism_sections import Piston
from fem.material import STEEL, Material
from fitted_models import made_model
from geometry.mesher import mesh_isolated
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight
from regression.formulas.axial_formulas import axial_formulas
from regression.law.throw_law import torsional_law
from snapshots import refusals
from snapshots.refusals import CALLS, CHAINS, COMMANDS, ENGINES, FILES, STUDIES, TEXTS, WARNED
from test_crankfem.conftest import edited
from throws import MEDIUM_SPEED_TOML

# What calls name besides public names, sections and what stands beside them.
NAMED = {
    called.__name__: called
    for called in (
        *(load_any, pressures_at, check_file, refuse_what_cannot_run, run_mechanism, engine_load),
        *(engine_vibration, load_chain, write_chain_text, load_mechanism, Piston, Material),
        *(mesh_isolated, CrankThrow, Counterweight, axial_formulas, torsional_law, input_path),
    )
} | {"np": np, "cf": cf, "STEEL": STEEL}


IMPERIAL = parse_output_units("imperial")
# Words of a person, and a choice of units for them; why a design of a study cannot be built.
CITED = re.compile(r"'[^']*'|\"[^\"]*\"|did you mean [^?]*\?|it cannot be built: .*")
SI_UNIT = re.compile(r"\d (?:mm|m|kN|N|kN m|N m|MPa|Pa|kg|kg m\^2|N/m)(?![\w^/])")


def refused(call, units=None):
    """The sentences of a refusal, each a line that ends; with other units no quantity is left in SI."""
    with pytest.raises(InputError) as raised:
        call()
    for sentence in raised.value.sentences:
        assert sentence.endswith(".")
        if units is not None:
            assert not SI_UNIT.search(CITED.sub("", units.written(sentence, full=True))), sentence
    return "".join(f"    {sentence}\n" for sentence in raised.value.sentences)


def changed(text, changes):
    """Text of a file with fields changed by their names, or words replaced."""
    for old, new in changes.items():
        replaced = new is not None and old in text
        text = text.replace(old, new) if replaced else edited(text, {old: new})
    return text


@pytest.mark.slow
def test_engine_files_are_refused(compare, tmp_path):
    text = ""
    for name, rows in ENGINES.items():
        shipped = input_path(name).read_text(encoding="utf-8")
        for place, changes in enumerate(rows):
            path = tmp_path / f"{place}.toml"
            path.write_text(changed(shipped, changes), encoding="utf-8")
            said = refused(lambda path=path: check_file(str(path)), IMPERIAL)
            said = said.replace(path.name, "mine.toml")
            text += f"{name}: {changes}\n{said}"
    compare("refused-engines", text)


@pytest.mark.further
def test_engine_files_are_warned_of(compare, tmp_path):
    """Warnings and remarks that the shipped file does not have."""
    text = ""
    for name, rows in WARNED.items():
        shipped = input_path(name)
        usual = check_file(str(shipped))
        for changes in rows:
            path = tmp_path / "mine.toml"
            path.write_text(changed(shipped.read_text(encoding="utf-8"), changes), encoding="utf-8")
            found = check_file(str(path))
            said = [f"    Warning: {one}\n" for one in found.warnings if one not in usual.warnings]
            said += [f"    Note: {one}\n" for one in found.remarks if one not in usual.remarks]
            assert said, changes
            text += f"{name}: {changes}\n{''.join(said)}"
    compare("warned-engines", text)


def test_studies_are_refused(compare, tmp_path):
    text, path = "", tmp_path / "mine.toml"
    for content in STUDIES:
        path.write_text(f"{MEDIUM_SPEED_TOML}\n{content}", encoding="utf-8")
        text += f"{content}{refused(lambda: load_study(path).planned)}"
    compare("refused-studies", text)


def test_texts_are_refused(compare, tmp_path):
    text, path = "", tmp_path / "mine.toml"
    for content in TEXTS:
        path.write_text(content, encoding="utf-8")
        text += f"{content!r}\n{refused(lambda: read_toml(path))}"
    compare("refused-texts", text)


def test_chain_files_are_refused(compare, tmp_path):
    text = ""
    for place, content in enumerate(CHAINS):
        path = tmp_path / f"{place}.{'toml' if content.startswith('[') else 'txt'}"
        path.write_text(content, encoding="utf-8")
        said = refused(lambda path=path: load_chain(path)).replace(path.name, f"mine{path.suffix}")
        text += f"{content!r}\n{said}"
    compare("refused-chains", text)


@pytest.mark.slow
def test_command_lines_are_refused(compare, call, tmp_path):
    text = ""
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    made_model().save(tmp_path / "model.json")
    for line in COMMANDS:
        answer = call(*shlex.split(line))
        assert answer.code == 2, line
        text += f"$ crankfem {line}\n{answer.out}{answer.err.lstrip()}"
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, "model.json"}
    compare("refused-commands", text)


@pytest.mark.slow
def test_calls_are_refused(compare, public):
    names = {name.rpartition(".")[2]: one for name, one in public.items()}
    names |= vars(refusals) | NAMED | {"six": cf.load_engine("6chn25-34")}
    names |= {section.model.__name__: section.model for section in SECTIONS.values()}
    compare(
        "refused-calls",
        "".join(f"{code}\n{refused(lambda code=code: eval(code, names))}" for code in CALLS),
    )
