"""The sentence with which each door refuses a bad input, as it was last looked at."""

import json
import shlex

import pytest

import crankfem as cf
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import pressures_at  # noqa: F401 - of calls
from crankfem.analyses.file_check import check_file, refuse_what_cannot_run  # noqa: F401
from crankfem.analyses.vibration.engine_excitation import engine_load  # noqa: F401
from crankfem.analyses.vibration.run import engine_vibration  # noqa: F401
from crankfem.files.chain.chain_file import load_chain, write_chain_text  # noqa: F401
from crankfem.files.engine.engine_file import load_mechanism  # noqa: F401
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.reading.data_files import input_path
from snapshots import refusals
from snapshots.refusals import CALLS, CHAINS, COMMANDS, ENGINES, FILES
from test_crankfem.conftest import edited


def refused(call, what=""):
    """The sentences of a refusal, each a line that ends."""
    with pytest.raises(InputError) as raised:
        call()
    assert all(sentence.endswith(".") for sentence in raised.value.sentences)
    return "".join(f"    {sentence}\n" for sentence in raised.value.sentences)


def changed(text, changes):
    """Text of a file with fields changed by their names, or words replaced."""
    for old, new in changes.items():
        replaced = new is not None and old in text
        text = text.replace(old, new) if replaced else edited(text, {old: new})
    return text


def test_engine_files_are_refused(compare, tmp_path):
    text = ""
    for name, rows in ENGINES.items():
        shipped = input_path(name).read_text(encoding="utf-8")
        for place, changes in enumerate(rows):
            path = tmp_path / f"{place}.toml"
            path.write_text(changed(shipped, changes), encoding="utf-8")
            said = refused(lambda path=path: check_file(str(path))).replace(path.name, "mine.toml")
            text += f"{name}: {json.dumps(changes, ensure_ascii=False)}\n{said}"
    compare("refused-engines", text)


def test_chain_files_are_refused(compare, tmp_path):
    text = ""
    for place, content in enumerate(CHAINS):
        path = tmp_path / f"{place}.{'toml' if content.startswith('[') else 'txt'}"
        path.write_text(content, encoding="utf-8")
        said = refused(lambda path=path: load_chain(path)).replace(path.name, f"mine{path.suffix}")
        text += f"{json.dumps(content)}\n{said}"
    compare("refused-chains", text)


@pytest.mark.slow
def test_command_lines_are_refused(compare, call, tmp_path):
    text = ""
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    for line in COMMANDS:
        answer = call(*shlex.split(line))
        assert (answer.code, answer.out) == (2, ""), line
        text += f"$ crankfem {line}\n{answer.err}"
    assert {path.name for path in tmp_path.iterdir()} == {*FILES}
    compare("refused-commands", text)


def test_calls_are_refused(compare, public):
    names = {name.rpartition(".")[2]: one for name, one in public.items()}
    names |= vars(refusals) | globals() | {"six": cf.load_engine("6chn25-34")}
    names |= {section.model.__name__: section.model for section in SECTIONS.values()}
    compare(
        "refused-calls",
        "".join(f"{code}\n{refused(lambda code=code: eval(code, names))}" for code in CALLS),
    )
