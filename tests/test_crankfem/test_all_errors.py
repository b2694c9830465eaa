"""Every kind of file tells all its wrong fields at once, each by one sentence."""

from pathlib import Path

import pytest

from crankbase.errors import InputError
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.mechanism_file import load_mechanism
from crankfem.files.engine.throw_file import load_throw_file
from crankfem.files.hinge_file import load_hinge
from crankfem.files.reading.data_files import input_path

UNEQUAL = Path(__file__).parents[1] / "data" / "unequal-three.toml"
NODES = """
[chain]
name = "x"
kind = "torsional"
[[chain.nodes]]
name = "a"
inertia = "1 kg m^2"
[[chain.nodes]]
name = "b"
inertia = "1 kg m^2"
[[chain.elements]]
stiffness = "3 N m/rad"
"""


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


IN_THROWS = {
    'pin_diameter = "70 mm"': "pin_diameter = 70",
    'web_width = "100 mm"': 'web_with = "100 mm"',
    'angle = "120 deg"': 'angle = "120 kg"',
}
THROWS_TOLD = [
    *(f"throws.plain.{name}" for name in ("pin_diameter", "web_with", "web_width")),
    "throws.heavy.counterweight.angle",
]


@pytest.mark.parametrize("load", [load_engine, load_mechanism])
def test_throws_by_name_and_sections(told, load):
    changes = IN_THROWS | {'stroke = "128 mm"': 'stroke = "128 K"'}
    found = told(load, UNEQUAL.read_text(encoding="utf-8"), changes)
    # What a throw takes from the other is told of that one, once.
    assert sorted(found) == sorted([*THROWS_TOLD, "engine.stroke"])


def test_throws_of_a_file_without_an_engine(told):
    text = UNEQUAL.read_text(encoding="utf-8")
    throws = text[text.index("[throws.plain]") : text.index("[shaft]")]
    changes = IN_THROWS | {"[throws.plain]": "[shat]\n[throws.plain]"}
    unknown, *found = told(load_throw_file, throws, changes)
    assert unknown.startswith("[shat] is an unknown section; ")
    assert sorted(found) == sorted(THROWS_TOLD)


def test_unknown_and_missing_sections(told):
    text = UNEQUAL.read_text(encoding="utf-8")
    unknown = told(load_engine, text, {"[flywheel]": "[flywhel]", "[free_end]": "[freeend]"})
    assert [line.split(" ")[0] for line in unknown] == ["[flywhel]", "[freeend]"]
    # A missing one may be an unknown one with another name.
    missing = told(load_chain, '[material]\ndensity = "7850"\n', {})
    assert "the section [chain] is missing; required are chain." in missing
    assert "material.density" in missing


def test_sections_nodes_and_elements_of_a_chain(told):
    text = NODES + '[material]\ndensity = 7850\nyoungs_modulus = "200 GPa"\npoisson_ratio = 0.3\n'
    units = {"1 kg m^2": "1", "3 N m/rad": "3 kg", 'name = "x"': 'name = "x"\ndamping = "-"'}
    assert told(load_chain, text, units) == [
        "chain.damping",
        "chain.nodes[0].inertia",
        "chain.nodes[1].inertia",
        "chain.elements[0].stiffness",
        "material.density",
    ]
    assert told(load_chain, text, {"torsional": "bending"}) == ["chain.kind", "material.density"]


def test_what_does_not_fit_within_a_chain(told):
    joined = 'nodes = ["a", "c"]\nstiffness = "3 N m/rad"\n[[chain.elements]]\n'
    gear = '[[chain.gears]]\ndriver = "d"\ndriven = "a"\nratio = 2\n'
    assert told(load_chain, NODES + gear, {'stiffness = "3 N m/rad"\n': joined}) == [
        "chain.elements[0].nodes",
        "chain.elements[1].nodes",
        "chain.gears[0].driver",
    ]


def test_lines_of_a_chain_in_text(told):
    text = "torsional: x\na  60\n  1e6 N\nb  7 kg m^2  grond 3\n"
    found = told(load_chain, text, {}, "mine.txt")
    assert found == ["line 2", "line 3", "line 4"]
    text = "torsional\na  60 kg m^2\n  1 N m/rad  to c\nb  7 kg m^2\n  1 N m/rad\n"
    assert told(load_chain, text, {}, "mine.txt") == ["line 3", "line 5"]


def test_sections_and_running_points_of_a_hinge_file(told):
    text = input_path("crosshead-30-100", "hinge").read_text(encoding="utf-8")
    changes = {
        '"1550 mm"': '"1550"',
        'peak_pressure = { value = "8 MPa"': 'peak_pressure = { value = "8"',
        'height = { value = "400 mm"': 'height = { value = "400"',
    }
    found = told(load_hinge, text, changes)
    assert found[0] == "rod.length"
    assert "comparison.sizes[1].height" in found
    assert any(one.startswith("operation.points[") for one in found)
