import json
import math
from dataclasses import replace

import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.mechanism import balance_records
from crankfem.analyses.mechanism.mechanism_records import acceleration_record
from crankfem.analyses.mechanism.plots import (
    plot_accelerations,
    plot_balance,
    plot_hinged_rods,
)
from crankfem.cli import console
from crankfem.cli.tables import mechanism_tables
from dynamics.balance.balance import balance, hinged_rod_effects
from dynamics.balance.moving_masses import balancing_masses
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod

SPEED = 1000.0 * math.pi / 30.0


def vee():
    """Two throws, cranks opposite, a hinged rod on each main rod."""
    main, hinged = ConnectingRod(0.65, 75.0, 0.17, 4.0), ConnectingRod(0.5, 24.0, 0.23, 1.0)
    cylinders = []
    for throw, crank in enumerate((0.0, math.pi)):
        pin = SlavePin(2 * throw + 1, 0.15, angle_deg=45.0)
        cylinders += [
            EngineCylinder(
                0.26,
                44.1,
                main,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=-22.5,
                position=0.4 * throw,
            ),
            EngineCylinder(
                0.26,
                44.1,
                hinged,
                crank_angle_deg=math.degrees(crank),
                bank_angle_deg=22.5,
                position=0.4 * throw,
                slave_pin=pin,
            ),
        ]
    return EngineLayout(0.13, cylinders, [1, 2, 3, 4])


def test_records_are_json_and_hold_the_numbers():
    found = balance(vee(), SPEED)
    record = json.loads(json.dumps(balance_records.balance_record(found), allow_nan=False))
    first, second = record["orders"][:2]
    assert (first["force_balanced"], first["moment_balanced"]) == (True, False)
    assert (second["force_balanced"], second["moment_balanced"]) == (False, True)
    assert second["force"]["major"] == found.of(2).force.major
    assert second["force"]["angle_deg"] == found.of(2).force.angle_deg
    parts = [second["parts"][name]["force"] for name in ("reciprocating", "rotating", "lateral")]
    for place in (0, 1):
        total = sum(part["forward"][place] for part in parts)
        assert total == close(second["force"]["forward"][place], abs=1e-9)
    assert len(record["masses"]) == 4
    cases = json.loads(
        json.dumps(
            balance_records.hinged_rods_record(hinged_rod_effects(vee(), SPEED, cylinders=[1, 2]))
        )
    )
    assert cases[1]["side_by_side"]["change"] == {"major": 0.0, "minor": 0.0, "turn_deg": 0.0}
    assert cases[1]["kinematics"]["change"]["major"] < -0.1


def test_tables(capsys, monkeypatch):
    monkeypatch.setattr(console.output, "width", 120)
    mechanism_tables.print_balance(balance_records.balance_record(balance(vee(), SPEED)))
    forces, moments = capsys.readouterr().out.split("Inertia moments")
    second = 1e-3 * balance(vee(), SPEED).of(2).force.major
    assert [line.split()[3] for line in forces.splitlines() if "│ 1 " in line] == ["balanced"]
    assert f"{second:.4g}" in forces
    assert "about z = 0.2 m" in moments
    assert moments.count("balanced") == 3  # the second and fourth order, and the note
    effects = hinged_rod_effects(vee(), SPEED, cylinders=[1, 2])
    pistons = acceleration_record(vee(), SPEED, (1, 2))
    mechanism_tables.print_hinged_rods(balance_records.hinged_rods_record(effects), pistons)
    shown = capsys.readouterr().out
    assert "less cylinder 2, at the same alpha: -52.8" in shown
    assert "hinged: movement alone" in shown
    assert "-12.2 %" in shown


@pytest.mark.slow
def test_pictures(tmp_path):
    engine = vee()
    plot_balance(tmp_path / "forces.svg", balance(engine, SPEED), title="V4 at 1000 1/min")
    assert "V4 at 1000 1/min" in (tmp_path / "forces.svg").read_text(encoding="utf-8")
    balanced = replace(engine, rotating=balancing_masses(engine))
    plot_balance(tmp_path / "second.svg", balance(balanced, SPEED, (2,)))
    plot_hinged_rods(tmp_path / "hinged.svg", engine, SPEED, cylinders=[1, 2])
    plot_accelerations(tmp_path / "pistons.svg", engine, SPEED, {1: "main rod", 2: "hinged rod"})
    again = tmp_path / "again.svg"
    plot_hinged_rods(again, engine, SPEED, cylinders=[1, 2])
    assert again.read_bytes() == (tmp_path / "hinged.svg").read_bytes()
    assert all(
        file.read_text(encoding="utf-8").rstrip().endswith("</svg>")
        for file in tmp_path.glob("*.svg")
    )
    with pytest.raises(InputError, match="cylinder: given 7"):
        plot_accelerations(again, engine, SPEED, {7: "none"})
