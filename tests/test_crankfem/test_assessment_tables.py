"""What the command line prints of limits: each limit once, and up to which speed it judges."""

import pytest

from crankbase.tables.output_units import parse_output_units
from crankfem.cli.tables.vibration_tables import print_assessment, print_judgment

STRESS, TWIST = "torsional stress of crankshaft", "torsional amplitude of free end"


@pytest.fixture
def record():
    def check(limit, place, unit, value):
        return {
            "limit": limit,
            "place": place,
            "unit": unit,
            "speed_rpm": 498.0,
            "value": value,
            "permitted": 2e7 if unit == "Pa" else 1e-3,
            "used": None if value is None else 0.5,
            "passed": value is not None,
        }

    return {
        "running_rpm": [200.0, 515.0],
        "uncertainty": {},
        "checks": [
            check(STRESS, "cylinder 4 - cylinder 5", "Pa", 1e7),
            check(TWIST, "free end", "rad", None),
            check(STRESS, "cylinder 1 - cylinder 2", "Pa", 2e6),
        ],
        "limits": [
            {"name": STRESS, "judged_to_rpm": 575.0, "source": "A rule", "assumed": True},
            {"name": TWIST, "judged_to_rpm": 515.0, "source": "The maker", "assumed": False},
        ],
        "remarks": [],
        "barred": [],
        "started_through": [],
        "sentence": "Fine.",
        "decision": {"status": "acceptable", "sentence": ""},
        "beside": [],
    }


def test_each_limit_stands_once_above_its_places(record, capsys):
    print_assessment(record)
    lines = capsys.readouterr().out.splitlines()
    heads = [line.partition(",")[0].strip() for line in lines if ", at the" in line]
    assert heads == [name.capitalize() for name in (STRESS, TWIST)]
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in lines if "│" in line]
    assert rows == [
        ["cylinder 4 - cylinder 5", "498.0", "10 MPa", "20 MPa", "50"],
        ["cylinder 1 - cylinder 2", "498.0", "2 MPa", "20 MPa", "50"],
        ["free end", "498.0", "unbounded", "0.0573 deg", "unbounded"],
    ]


def test_speeds_above_the_running_range_are_explained(record, capsys):
    print_assessment(record, parse_output_units("rpm"))
    lines = capsys.readouterr().out.splitlines()
    assert (
        f"Limit on {STRESS}: A rule, assumed; judged from 200 to 575 rpm, because it also applies above the "
        "highest running speed of 515 rpm." in lines
    )
    assert f"Limit on {TWIST}: The maker; judged from 200 to 515 rpm." in lines


def test_what_decides_stands_before_the_verdict_with_the_values_assumed(record, capsys):
    record["decision"] = {"status": "undecided", "sentence": "acceptable with this: give that"}
    print_judgment(record)
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "Verdict: undecided, acceptable with this: give that.",
        "With the values used: Fine.",
    ]


def test_a_verdict_that_only_its_barred_ranges_hang_on_says_so(record, capsys):
    record["decision"] = {"status": "acceptable", "sentence": "no speeds need be barred with this"}
    print_judgment(record)
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "Verdict: Fine.",
        "It depends on assumed or uncertain values: no speeds need be barred with this.",
    ]
