"""Rated power and load of engine files: what is refused, what is told, and what pressure follows."""

from dataclasses import replace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.vibration.engine_excitation import (
    calculated_speeds,
    engine_harmonics,
    engine_load,
    failing_harmonics,
)
from crankfem.analyses.vibration.records import load_record
from crankfem.cli.tables.vibration_tables import print_load
from crankfem.files.engine.mechanism_file import pressures_at
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.cylinder_pressures import LoadSection
from crankfem.files.sections.excitation_sections import GasMap

RPM = np.pi / 30.0
POINTS = [
    {"speed": "200 1/min", "mean_effective_pressure": "3 bar"},
    {"speed": "515 1/min", "mean_effective_pressure": "13 bar"},
]


@pytest.fixture(scope="module")
def engine():
    return cf.load_engine("6chn25-34")


def with_points(*points):
    return LoadSection.from_text({"points": [*POINTS, *points]})


def pointed(**fields):
    """Points of both speeds with further fields in each."""
    return LoadSection.from_text({"points": [point | fields for point in POINTS]})


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ({}, "load.law: given neither it nor points"),
        ({"law": "propeller", "points": POINTS}, "load.law: given both it and points"),
        ({"law": "square"}, "load.law: given 'square'; allowed is"),
        ({"points": POINTS[:1]}, "load.points: given 1 of 1 different speeds"),
        ({"points": [POINTS[0], POINTS[0]]}, "load.points: given 2 of 1 different speeds"),
        (
            {"points": [POINTS[0] | {"peak_pressure": "60 bar"}, POINTS[1]]},
            "load.points: given peak_pressure at 1 of 2 speeds; allowed is all of them or none",
        ),
        (
            {"points": [{"speed": "200 1/min"}, POINTS[1]]},
            r"load.points\[0\].mean_effective_pressure",
        ),
        ({"points": [POINTS[0] | {"speed": "200"}, POINTS[1]]}, r"load.points\[0\].speed: given"),
    ],
)
def test_sections_that_say_too_much_or_too_little(text, fragment):
    with pytest.raises(InputError, match=fragment):
        LoadSection.from_text(text)


def test_sections_that_do_not_fit_each_other(engine):
    propeller = LoadSection(law="propeller")
    with pytest.raises(InputError, match=r"load: given without the section \[gas\]"):
        engine.changed(gas=None, load=propeller)
    table = {"pressure_table": "p.csv", "peak_pressure": None}
    with pytest.raises(
        InputError, match=r"load: given together with gas.pressure_table; allowed are"
    ):
        engine.changed(gas=table, load=propeller)
    short = LoadSection.from_text({"points": [POINTS[0], POINTS[1] | {"speed": "450 1/min"}]})
    with pytest.raises(InputError, match=r"load.points: given speeds from 200 1/min to 450 1/min"):
        engine.changed(load=short)
    mapped = {
        "points": [{"speed": 20.0, "pressure_table": "a"}, {"speed": 60.0, "pressure_table": "b"}]
    }
    with pytest.raises(InputError, match=r"load: given together with the section \[gas_map\]"):
        engine.changed(gas_map=mapped, load=propeller)


def test_a_load_that_the_cycle_cannot_reach(engine):
    changed = engine.changed(load=pointed(peak_pressure="2 bar"))
    with pytest.raises(InputError, match=r"^load: at 200 1/min and load 1: peak_pressure"):
        engine_load(changed, cf.engines.mechanism_of(changed))


@pytest.mark.parametrize(
    ("rated", "consistent"), [(330e3, False), (429e3, True), (550e3, True), (560e3, False)]
)
def test_rated_power_fits_the_gas_or_not(engine, rated, consistent):
    power = cf.engines.mechanism_of(engine.changed(engine={"rated_power": rated})).power
    assert power.consistent is consistent
    assert power.mechanical_efficiency == close(rated / 570.2277e3, 1e-5)
    assert power.sentence.startswith("The file is inconsistent: rated power") is not consistent
    # Friction is the rest of the mean pressure where the two fit, and unknown where they do not.
    rest = power.mean_indicated_pressure * (1.0 - rated / power.indicated)
    assert power.friction_pressure == (close(rest, 1e-9) if consistent else 0.0)


def test_without_rated_power_nothing_checks(engine):
    power = cf.engines.mechanism_of(engine).power
    assert power.consistent
    assert power.mechanical_efficiency is power.mean_effective_pressure is None
    assert power.sentence == (
        "indicated power 570.2 kW at 500 1/min, mean indicated pressure 1.367 MPa; engine.rated_power is "
        "not given, so the gas pressure is not checked"
    )


def test_two_points_are_met_with_a_straight_line_between(engine):
    points = [
        POINTS[0] | {"peak_pressure": "40 bar", "intake_pressure": "1.1 bar"},
        POINTS[1] | {"peak_pressure": "84 bar", "intake_pressure": "2.0 bar"},
    ]
    changed = engine.changed(load=LoadSection.from_text({"points": points}))
    told = engine_load(changed, cf.engines.mechanism_of(changed))
    assert told.law == "points"
    assert told.speeds / RPM == close([200.0, 250.0, 375.0, 500.0, 515.0])
    share = (told.speeds / RPM - 200.0) / 315.0
    assert told.mean_pressure == close(3e5 + 10e5 * share, 1e-5)
    assert told.peak_pressure == close(40e5 + 44e5 * share + 101325.0, 1e-5)
    assert told.intake_pressure == close(1.1e5 + 0.9e5 * share)


def test_vibration_is_calculated_as_far_as_points_reach(engine):
    changed = engine.changed(load=with_points())
    speeds = calculated_speeds(changed, np.array([0.5]), (), [20.0])
    assert speeds[[0, -1]] / RPM == close([200.0, 515.0])
    with pytest.raises(InputError, match=r"load\.points: given none for 600 1/min"):
        pressures_at(cf.engines.mechanism_of(changed), [600.0 * RPM])


def test_the_boost_goes_with_the_power(engine):
    """Compression in a cylinder without combustion shows it."""
    changed = engine.changed(load={"law": "propeller"})
    mechanism = cf.engines.mechanism_of(changed)
    (half, full) = pressures_at(mechanism, np.array([250.0, 500.0]) * RPM, motored=True)
    told = engine_load(changed, mechanism)
    intake = dict(zip(np.round(told.speeds / RPM), told.intake_pressure, strict=True))
    assert intake[250.0] - 101325.0 == close((intake[500.0] - 101325.0) / 8.0)
    assert half[0].peak_pressure / full[0].peak_pressure == close(intake[250.0] / intake[500.0])


def test_a_cylinder_that_misfires_is_motored_at_its_load(engine):
    changed = engine.changed(load={"law": "propeller"}, misfire={"cylinders": (1,)})
    mechanism = cf.engines.mechanism_of(changed)
    firing = engine_harmonics(changed, mechanism)
    assert firing.one_diagram == ""
    failing = failing_harmonics(changed, mechanism, firing)
    speed = np.array([250.0 * RPM])
    burning, motored = (own.phasors(speed)[0, 0, :, 0].real for own in (firing, failing))
    assert (abs(motored) < 0.1 * burning).all()


def test_a_constant_load_is_what_no_section_says(engine):
    given = engine.changed(load={"law": "constant"})
    found = [engine_load(one, cf.engines.mechanism_of(one)) for one in (engine, given)]
    assert [one.law for one in found] == ["constant", "constant"]
    assert found[0].mean_pressure == close(found[1].mean_pressure)
    assert "the file has no section [load]" in found[0].sentence
    assert "as given in [load]" in found[1].sentence
    assert "intake_pressure" not in load_record(found[0])["speeds"][0]


def test_a_pressure_map_is_checked_in_place_of_the_gas(engine, tmp_path):
    pressure = cf.engines.mechanism_of(engine).pressure[0]
    rows = zip(pressure.angles_deg, pressure.pressure / 1e5, strict=True)
    for name, share in (("low", 0.5), ("full", 1.0)):
        lines = [f"{angle:.9g},{share * bar:.9g}" for angle, bar in rows]
        text = "\n".join(["crank_angle_deg,absolute_pressure_bar", *lines])
        (tmp_path / f"{name}.csv").write_text(f"{text}\n", encoding="utf-8")
        rows = zip(pressure.angles_deg, pressure.pressure / 1e5, strict=True)
    points = [
        {"speed": "200 1/min", "load": 0.5, "pressure_table": "low.csv"},
        {"speed": "515 1/min", "load": 1.0, "pressure_table": "full.csv"},
    ]
    section = GasMap.from_text({"points": points, "method": "linear"})
    changed = engine.changed(engine={"rated_power": 330e3}, gas=None, gas_map=section)
    changed = replace(changed, files=InputFiles(tmp_path / "engine.toml"))
    told = engine_load(changed, cf.engines.mechanism_of(changed))
    mean = 1.366668e6 * np.interp(told.speeds / RPM, [200.0, 515.0], [0.5, 1.0])
    assert told.law == "map"
    assert told.mean_pressure == close(mean, 1e-4)
    assert told.rated.indicated == close(570.2277e3 * mean[3] / 1.366668e6, 1e-4)
    assert "load in the section [gas_map]" in told.sentence


@pytest.mark.slow
def test_console_tells_power_and_load(call, tmp_path):
    text = cf.engines.mechanism_of(cf.load_engine("6s50mc-c")).path.read_text(encoding="utf-8")
    file = tmp_path / "engine.toml"
    file.write_text(text.replace('"9480 kW"', '"5 MW"'), encoding="utf-8")
    said = "inconsistent: rated power 5000 kW (mean effective pressure 1.003 MPa) is 0.501 of"
    for command in ("check", "mechanism"):
        answer = call(command, str(file))
        assert answer.code == 0
        assert said in " ".join(answer.out.split())
    fine = call("mechanism", "6s50mc-c", "--speed", "63.5 1/min", "--json").json()
    assert fine["rated"]["mechanical_efficiency"] == close(0.9504, 1e-3)
    # Friction of 1 bar beside a quarter of 19 bar.
    assert fine["mean_indicated_pressure"] == close(1.9e6 / 4.0 + 0.1e6, 1e-2)


def test_power_that_does_not_fit_and_the_load_are_told(engine):
    changed = engine.changed(engine={"rated_power": 330e3}, load={"law": "propeller"})
    told = load_record(engine_load(changed, cf.engines.mechanism_of(changed)))
    assert not told["rated"]["consistent"]
    assert told["rated"]["sentence"] == (
        "The file is inconsistent: rated power 330 kW (mean effective pressure 0.7909 MPa) is 0.579 of the "
        "indicated power 570.2 kW at 500 1/min, mean indicated pressure 1.367 MPa; usual mechanical "
        "efficiencies are 0.75 to 0.97, so correct engine.rated_power or the section [gas]"
    )
    assert told["sentence"].startswith(
        "each speed is calculated at the load of a propeller: mean indicated pressure"
    )
    # Rated and indicated power that do not fit tell nothing of friction.
    assert "friction" not in told["sentence"]


def test_the_console_tells_the_load_of_each_speed(engine, capsys):
    changed = engine.changed(engine={"rated_power": 480e3}, load={"law": "propeller"})
    told = load_record(engine_load(changed, cf.engines.mechanism_of(changed)))
    print_load(told)
    out = " ".join(capsys.readouterr().out.split())
    assert "rated power 480 kW (mean effective pressure 1.15 MPa) is 0.842 of it" in out
    assert "power at the flywheel to its cube; friction takes 2.16 bar at every speed" in out
    assert "Load of the engine" in out
    assert out.count("570.2") == 2
