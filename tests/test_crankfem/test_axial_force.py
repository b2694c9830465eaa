"""Axial force over the cycle: what the command tells of it, and two throws by hand."""

import csv
import json

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.excitation.axial_cycle import axial_force_over_cycle


@pytest.mark.slow
def test_command_tells_and_writes_it(call, tmp_path):
    answer = call("vibration", "vw-tdi", "--csv", "tables", "--pictures", "pictures", "--json")
    record = answer.json()["axial_force"]
    text = (tmp_path / "tables" / "axial_force.csv").read_text(encoding="utf-8").splitlines()
    assert text[0].startswith("# axial forces over the cycle at 4000 1/min")
    rows = list(csv.DictReader(text[1:]))
    assert len(rows) == 720
    assert list(rows[0])[:3] == ["shaft_angle_deg", "thrust_bearing_N", "held_N"]
    for name in ("thrust_bearing", "held"):
        column = np.array([float(row[f"{name}_N"]) for row in rows])
        assert record[name]["lowest"] == close(column.min())
        assert record[name]["highest"] == close(column.max())
        highest = float(rows[int(np.argmax(column))]["shaft_angle_deg"])
        assert record[name]["highest_angle_deg"] == close(highest, abs=1e-9)
    # The worst running speed is at least as bad as the rated one.
    span = record["thrust_bearing"]["highest"] - record["thrust_bearing"]["lowest"]
    assert record["running"]["amplitude"] >= 0.5 * span * (1.0 - 1e-3)
    said = " ".join(record["sentences"])
    for value in (
        record["thrust_bearing"]["lowest"],
        record["thrust_bearing"]["highest"],
        record["running"]["amplitude"],
        record["held"]["lowest"],
        record["held"]["highest"],
    ):
        assert f"{value / 1e3:.3g} kN" in said
    assert (tmp_path / "pictures" / "axial_force.svg").is_file()
    json.dumps(record, allow_nan=False)


def test_two_throws_by_hand():
    # Z on pin 1 lengthens throw 1 by 2 and throw 2 by -1; T on pin 2 both by 1 [nm/N].
    influence = 1e-9 * np.array([[[2.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]]])
    forces = np.array([[[1e3, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1e3]]])
    found = axial_force_over_cycle([0.0, 1.0], 10.0, forces, [1e-9, 3e-9], influence)
    assert found.throws == close(np.array([[2000.0, -1000.0 / 3.0], [1000.0, 1000.0 / 3.0]]))
    assert found.held == close([250.0, 500.0])
    assert found.thrust_bearing is None
    assert list(found.columns()) == ["shaft_angle_deg", "held_N", "throw_1_N", "throw_2_N"]
    with pytest.raises(InputError, match=r"pin_forces: given an array of shape \(1, 2, 2\)"):
        axial_force_over_cycle([0.0, 1.0], 10.0, forces[:1], [1e-9, 3e-9], influence)
