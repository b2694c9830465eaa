"""Units in JSON: every number of every command has one, the one in which tables print it."""

import json
import shlex

import pytest
import typer

import crankfem as cf
from crankbase.quantity import POWER_OF_TEN, UNITS
from crankbase.results import units
from crankbase.table import SI, OutputUnit, OutputUnits
from crankfem.analyses.record import with_units
from crankfem.analyses.shaft.chain_vibration import ChainVibration
from crankfem.analyses.vibration.tables import vibration_parts
from crankfem.cli.app import app
from crankfem.cli.console import print_parts
from json_units import numbers_with_units
from satellite_cases import of_satellites
from stand_ins import calculate_satellites_once, stored_results, typed

# Lines whose JSON is looked at, with how many numbers of it are known to be printed with a unit.
QUICK = {
    "check 6chn25-34": 0,
    "mechanism 8chn26-26 --model rigid --model two-mass": 60,
    "harmonics 8chn26-26 --cylinder 1": 250,
    "harmonics yamz5340_torque_one_throw.csv": 40,
    "harmonics yamz5340_torque_one_throw.csv --firing-order 1-3-4-2": 40,
    "two-mass yamz-5340": 1,
    "formulas 6chn25-34 --no-fe --constant k_n=0.4": 0,
    "formulas --published": 0,
    "plan 6chn25-34": 6,
    "vibration mwm-six": 6,
    "new --list": 0,
    "fields throw": 0,
}
MODEL = {
    "fit runs.sqlite --model other.json": 0,
    "results runs.sqlite runs.csv": 0,
    "verify runs.sqlite": 0,
    "lookup model.json web_width=301mm web_thickness=68.3mm": 5,
    **of_satellites("NUMBERS_OF_A_MODEL"),
}
SLOW = {
    **of_satellites("PRINTED_NUMBERS"),
    "throw 6chn25-34 --accuracy 0.1 --modes 2": 15,
    "stress 6chn25-34 --accuracy 0.2": 0,
    "draw 6chn25-34": 0,
    "export 6chn25-34 throw.vtu --size 3 --part quarter": 0,
}
# Commands that leave nothing out, and know no --full.
ALWAYS_WHOLE = ("new", "fields", "results", "verify", "draw", "export")
# Whose JSON other tests make, which look at its units too, or holds no numbers.
ELSEWHERE = {"run", "report", "doe", "designs", "import"} | of_satellites("READS").keys()


@pytest.fixture
def printed(monkeypatch):
    """List (number, unit of SI) of what is printed with a unit of tables."""
    found = []

    def recorded(method):
        def write(self, value, *digits):
            found.append((value, _unit_of_si(self)))
            return method(self, value, *digits)

        return write

    def quantity(self, value, unit, digits=6):
        found.append((value, unit))
        return whole(self, value, unit, digits)

    whole = OutputUnits.quantity
    monkeypatch.setattr(OutputUnits, "quantity", quantity)
    for name in ("number", "fixed"):
        monkeypatch.setattr(OutputUnit, name, recorded(getattr(OutputUnit, name)))
    return found


def _unit_of_si(unit):
    name = unit.name.removeprefix(POWER_OF_TEN)
    scale = 1.0 if name == unit.name else 1e-9
    si, size = UNITS.get(name, ("", 0.0))
    return "1" if unit.name == "%" else si if size * scale == unit.size else ""


def compared(content, printed):
    """Count the numbers of a document that were printed, all with the units that it tells."""
    told = {}
    for path, value, unit in numbers_with_units(content):
        told.setdefault(value, {})[unit] = ".".join(path)
    # A number of many digits is that of the document, not another of the same size.
    found = [
        (value, si)
        for value, si in printed
        if si and value in told and len(f"{float(value)!r}") > 10
    ]
    for value, si in found:
        assert si in told[value], f"{value} is printed in {si}, but {told[value]}"
    return len(set(found))


def check_line(line, call, printed):
    arguments = shlex.split(line)
    answer = call(*arguments, "--json")
    assert answer.code == 0, answer.err
    printed.clear()
    full = () if arguments[0] in ALWAYS_WHOLE else ("--full",)
    assert call(*arguments, *full).code == 0
    return compared(answer.json(), printed)


@pytest.mark.slow
@pytest.mark.parametrize("line", QUICK)
def test_every_number_has_the_unit_in_which_it_is_printed(line, call, printed):
    assert check_line(line, call, printed) >= QUICK[line]


@pytest.mark.slow
@pytest.mark.parametrize("line", MODEL)
def test_so_have_those_of_a_study_and_a_model(line, store, model_file, call, printed):
    assert {store.name, model_file.name} == {"runs.sqlite", "model.json"}
    assert check_line(line, call, printed) >= MODEL[line]


@pytest.mark.further
@pytest.mark.parametrize("line", SLOW)
def test_so_have_numbers_of_finite_elements(line, lightly, call, printed, monkeypatch):
    calculate_satellites_once(monkeypatch)
    assert check_line(line, call, printed) >= SLOW[line]


@pytest.mark.slow
def test_so_have_those_of_vibration(coupled_vibration, printed):
    run = coupled_vibration("6chn25-34")
    content = json.loads(json.dumps(with_units(run)))
    printed.clear()
    print_parts(vibration_parts(run, SI))
    assert compared(content, printed) > 150


@pytest.mark.further
def test_units_take_little_of_a_results_file(finished_run):
    results = finished_run.results
    assert len(numbers_with_units(results)) > 10000
    assert len(json.dumps(results["units"], indent=1)) < 0.03 * len(json.dumps(results, indent=1))


def test_every_command_is_looked_at():
    commands = {
        name
        for name, command in typer.main.get_command(app).commands.items()
        if any(option.name == "json" for option in command.params)
    }
    assert commands == {line.partition(" ")[0] for line in [*QUICK, *MODEL, *SLOW]} | ELSEWHERE


def test_all_numbers_of_stored_results_have_units():
    assert len(numbers_with_units(with_units(typed(stored_results())))) > 1000


def test_documents_without_numbers_have_no_units():
    assert with_units({"file": "a", "ready": True}) == {"file": "a", "ready": True}


@pytest.mark.parametrize(("kind", "inertia"), [("axial", "kg"), ("torsional", "kg m^2")])
def test_a_chain_has_the_units_of_its_kind(kind, inertia):
    told = units(ChainVibration("mine", kind, cf.Chain([0.1, 0.78], [9e5]), {}))
    assert told["inertia"] == told["modes.modal_inertia"] == inertia
    assert told["stiffness"] == told["ground"] == {"axial": "N/m", "torsional": "N m/rad"}[kind]
