"""The table of critical speeds, from the stored results of a run."""

import json
from pathlib import Path

import pytest

from crankfem.analyses.vibration.tables import (
    mode_table,
    resonance_table,
    source_table,
    speed_table,
)

STORED = Path(__file__).with_name("report_results.json")


@pytest.fixture
def results():
    return json.loads(STORED.read_text(encoding="utf-8"))


def test_a_critical_speed_stands_once_with_all_that_is_known_of_it(results):
    vibration = results["vibration"]
    table = speed_table(vibration)
    names = [column.name for column in table.columns]
    kinds, orders, modes = (
        [row[names.index(name)] for row in table.rows] for name in ("vibration", "order", "mode")
    )
    assert len(set(zip(kinds, orders, modes, strict=True))) == len(table.rows)
    one = next(
        row for row in table.rows if row[0] == "torsional" and row[names.index("order")] == 12
    )
    peak = next(p for p in vibration["forced"]["torsional"]["resonances"] if p["order"] == 12.0)
    limits = vibration["assessment"]["uncertainty"]["torsional"]["critical"]
    own = next(p for p in limits if p["order"] == 12.0)
    shown = table.texts()[table.rows.index(one)]
    assert shown[names.index("speed")] == f"{peak['speed_rpm']:.1f}"
    assert shown[names.index("lowest")] == f"{own['low_rpm']:.1f}"
    assert shown[names.index("amplitude")] == "1.42 mrad"


def test_each_of_two_peaks_of_one_mode_has_a_row(results):
    vibration = results["vibration"]
    peaks = vibration["forced"]["torsional"]["resonances"]
    first = next(one for one in peaks if one["order"] == 12.0)
    peaks.append({**first, "speed_rpm": 0.9 * first["speed_rpm"], "amplitude": 0.5e-3})
    table = speed_table(vibration, most=99)
    names = [column.name for column in table.columns]
    rows = [
        dict(zip(names, texts, strict=True))
        for texts in table.texts()
        if texts[0] == "torsional" and texts[names.index("order")] == "12"
    ]
    assert [row["amplitude"] for row in rows] == ["0.5 mrad", "1.42 mrad"]
    # Bounds belong to the peak they are about.
    assert (rows[0]["lowest"], rows[1]["lowest"] != "-") == ("-", True)


def test_no_critical_speed_is_both_inside_and_outside_the_running_range(results):
    vibration = results["vibration"]
    high = 520.0
    vibration["assessment"]["running_rpm"] = [300.0, high]
    peak = next(
        one for one in vibration["forced"]["torsional"]["resonances"] if one["order"] == 12.0
    )
    peak |= {"speed_rpm": 1.01 * high, "in_running_range": False}
    bounds = vibration["assessment"]["uncertainty"]["torsional"]["critical"]
    own = next(one for one in bounds if one["order"] == 12.0)
    own |= {"speed_rpm": 1.01 * high, "low_rpm": 0.99 * high, "margin": 0.0}
    # An order that has no peak at speeds calculated, just above the running range too.
    bounds.append({**own, "order": 30.0})
    table = speed_table(vibration, most=99, major=(30.0,))
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, texts, strict=True)) for texts in table.texts()]
    one, other = (
        next(row for row in rows if (row["vibration"], row["order"]) == ("torsional", order))
        for order in ("12", "30")
    )
    assert (one["margin"], one["kind"]) == ("0.0", "major, outside")
    assert (other["margin"], other["kind"]) == ("0.0", "major, outside")
    assert not any(row["margin"] == "inside" and "outside" in row["kind"] for row in rows)


def test_an_order_without_a_peak_is_not_called_unbounded(results):
    vibration = results["vibration"]
    one = vibration["forced"]["axial"]["resonances"][0]
    one |= {"speed_rpm": None, "amplitude": None, "unbounded": False}
    table = speed_table(vibration, most=99)
    (row,) = (texts for texts in table.texts() if "no peak" in texts)
    assert row[[column.name for column in table.columns].index("amplitude")] == "-"
    assert not any("unbounded" in text for text in row)


def test_a_mode_that_makes_no_peak_has_no_critical_speed_outside(results):
    """Nor a margin to one, of an order beyond the speeds calculated."""
    vibration = results["vibration"]
    peaks = vibration["forced"]["axial"]["resonances"]
    damped = {"mode": 7, "order": 12.0, "speed_rpm": None, "severity": 0.0}
    peaks.append({**peaks[0], **damped, "in_running_range": False})
    bounds = {"mode": 7, "order": 11.0, "margin": 0.0, "speed_rpm": 650.0}
    critical = vibration["assessment"]["uncertainty"]["axial"]["critical"]
    critical.append(bounds | {"low_rpm": 30.0, "high_rpm": 660.0})
    met = vibration["axial"]["criticals"]
    met.append({**met[0], "mode": 7, "order": 12.0, "in_running_range": False})

    def modes():
        table = speed_table(vibration, most=99)
        place = [column.name for column in table.columns].index("mode")
        return {texts[place] for texts in table.texts() if texts[0] == "axial"}

    assert "7" not in modes()
    peaks[-1]["in_running_range"] = True
    assert "7" in modes()


def test_every_peak_is_in_the_table_or_told_to_be_left_out(results):
    """A branch's peak counts by its own largest one, small peaks and those of the forces in a sentence."""
    vibration = results["vibration"]
    record = vibration["forced"]["torsional"]
    one = next(own for own in record["resonances"] if own["order"] == 12.0)
    new = {"place": "pump shaft", "value": 294.0, "unit": "N m", "others": [], "modes": [2]}
    new |= {"mode": 2, "in_band": True, "spread_rpm": [440.0, 440.0], "in_running_range": True}
    at = enumerate((1.0, 0.6, 0.06, 0.04, 0.01))
    record["resonances"] = [
        one | new | {"speed_rpm": 440.0 + place, "order": 4.0 + place, "severity": share}
        for place, share in at
    ]
    record["resonances"].append(record["resonances"][0] | {"in_band": False, "order": 20.0})
    table = speed_table(vibration, most=2)
    rows = [texts for texts in table.texts() if texts[0] == "torsional"]
    assert len(rows) == 2
    assert all("pump shaft" in texts and "294 N m" in texts for texts in rows)
    assert "1 critical speed, up to 6 % of the largest peak at a place" in table.note
    assert "2 peaks below 5 % of the largest one at every place" in table.note
    assert "1 peak of the exciting forces" in table.note
    shown = resonance_table(record)
    assert len(shown.rows) == 3
    assert "critical speed" not in shown.note
    assert "2 peaks below 5 %" in shown.note


def test_sources_show_modes_that_depend_on_them_and_all_points_have_names(results):
    record = results["vibration"]["torsional"]
    one = record["sources"][0]
    one |= {"first_mode": 2, "first_frequencies": [7.3, 49.2, 129.1]}
    one |= {"crankshaft_frequencies": [49.2, 129.1, 207.6]}
    table = source_table(record)
    assert "of the crankshaft, from mode 2 on" in table.title
    assert table.rows[0][2] == [49.2, 129.1, 207.6]
    note = mode_table(record).note
    last = len(record["nodes"]) - 1
    assert f"0 free end, 1 to 6 cylinder 1 to cylinder 6, {last} flywheel" in note
