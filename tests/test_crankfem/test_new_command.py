"""The template of an engine file is valid as it is, and so is everything that it has in comments."""

import math
import re

import pytest

from comparing import close
from crankfem.files.engine.engine_file import SECTIONS, load_engine
from crankfem.files.engine.file_kinds import FIRING_ORDERS, engine_template
from crankfem.files.reading.data_files import input_path

TEMPLATE = engine_template()
OPTIONAL = re.compile(r"(?m)^#: ")


def optional_examples(text: str) -> list[str]:
    """Return what stands in comments to be used, each example on its own: a section, or single fields.

    Sections that only continue another, such as ``[study.factors]``, belong to it.
    """
    found: list[list[str]] = []
    before = ""
    for line in text.splitlines():
        if OPTIONAL.match(line):
            if OPTIONAL.match(before):
                found[-1].append(line)
            else:
                found.append([line])
        before = line
    return ["\n".join(lines) for lines in found]


def with_example(text: str, example: str) -> str:
    """Return the text with one of its examples put to use."""
    return text.replace(example, OPTIONAL.sub("", example))


EXAMPLES = {one.splitlines()[0].removeprefix("#: "): one for one in optional_examples(TEMPLATE)}


def test_a_template_is_written_and_valid(call, tmp_path):
    answer = call("new", "mine.toml")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.rstrip().endswith("crankfem run mine.toml")
    read = load_engine(tmp_path / "mine.toml")
    # All that stands for an engine is assumed; names, numbers of cylinders and choices are not.
    given = {record.field for record in read.records if not record.assumed}
    assert given == {
        "engine.name",
        "engine.cylinders",
        "engine.strokes",
        "vibration.axial_source",
        "vibration.torsional_source",
        "vibration.highest_order",
        "vibration.reciprocating",
    }
    assert read.gas is not None


def test_the_template_explains_every_section():
    # Hinged rods and chains behind the flywheel start from a shipped file, which it names; throws by name
    # cannot stand beside the one throw, not even in an example.
    for section in set(SECTIONS) - {"hinged_rods", "shaft_line", "throws"}:
        assert f"\n[{section}]" in TEMPLATE or f"\n#: [{section}]" in TEMPLATE, section
    assert "[shaft_line]" in TEMPLATE
    assert "[throws.a]" in TEMPLATE
    assert "--from 8chn13-14" in TEMPLATE


@pytest.mark.parametrize("example", [one for one in EXAMPLES if one != "[study]"])
def test_what_stands_in_comments_is_valid(tmp_path, example):
    text = with_example(TEMPLATE, EXAMPLES[example])
    assert text != TEMPLATE
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    load_engine(tmp_path / "mine.toml")


def test_a_study_stands_in_comments(call, tmp_path):
    text = with_example(TEMPLATE, EXAMPLES["[study]"])
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    assert "doe" in call("check", "mine.toml", "--json").json()["commands"]


@pytest.mark.parametrize("strokes", FIRING_ORDERS)
def test_cylinders_fire_evenly(tmp_path, strokes):
    for cylinders in FIRING_ORDERS[strokes]:
        path = tmp_path / f"{cylinders}.toml"
        path.write_text(engine_template(path.name, cylinders, strokes), encoding="utf-8")
        angles = sorted(load_engine(path).engine.firing_angles)
        cycle = math.pi * strokes
        expected = [place * cycle / cylinders for place in range(cylinders)]
        # Angles of seven cylinders stand in the file with ten digits.
        assert angles == close(expected, abs=1e-8)


def test_hinges_and_chains_are_copied(call, tmp_path):
    answer = call("new", "hinge.toml", "--from", "crosshead-30-100")
    assert answer.code == 0
    assert "crankfem hinge hinge.toml" in answer.out
    assert (tmp_path / "hinge.toml").read_bytes() == input_path(
        "crosshead-30-100", "hinge"
    ).read_bytes()
    record = call("new", "chain.toml", "--from", "mwm-six", "--json").json()
    assert record["next"] == "crankfem vibration chain.toml"
    assert call("new", "v.toml", "--from", "buick-3800", "--json").json()["kind"] == "mechanism"


def test_the_list_of_what_is_shipped(call, tmp_path):
    shipped = call("new", "--list", "--json").json()["shipped"]
    kinds = {one["name"]: one["kind"] for one in shipped}
    assert kinds["6chn25-34"] == "engine"
    assert kinds["2ch85-110"] == "throw"
    assert (kinds["crosshead-30-100"], kinds["mwm-six"]) == ("hinge", "chain")
    assert all(one["about"] for one in shipped)
    out = call("new", "--list").out
    assert all(one["name"] in out for one in shipped)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        ((), "new: given no file"),
        (("a.toml", "--list"), "--list: given with a file"),
        (("a.toml", "--cylinders", "9"), "--cylinders: given 9; allowed is 1 to 8"),
        (("a.toml", "--strokes", "3"), "--strokes: given 3; allowed are 2 and 4"),
        (("a.toml", "--from", "vw-tdi", "--cylinders", "4"), "--cylinders: given 4 with --from"),
        (("a.toml", "--from", "nobody"), "--from: given 'nobody'; allowed are 12chn18-20"),
        (("nowhere/a.toml",), "cannot be written; there is no folder nowhere"),
    ],
)
def test_new_refuses(call, tmp_path, arguments, fragment):
    answer = call("new", *arguments)
    assert (answer.code, answer.out) == (2, "")
    assert fragment in answer.err
    assert list(tmp_path.iterdir()) == []


def test_a_copy_is_the_shipped_file(call, tmp_path):
    assert call("new", "mine.toml", "--from", "6chn25-34").code == 0
    assert (tmp_path / "mine.toml").read_bytes() == input_path("6chn25-34").read_bytes()
