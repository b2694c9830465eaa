import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.files.sections.limits_sections import LimitsInput, RangesInput


def test_limits_come_with_their_units_and_sources():
    section = LimitsInput.from_text(
        {
            "axial_amplitude": "0.4 mm",
            "coupling_torque": "2 kN m",
            "coupling_torque_passing": "3 kN m",
            "torsional_amplitude": "0.6 deg",
        },
        "limits",
    )
    found = section.limits(
        100.0, strokes=4, provenance={"limits.axial_amplitude": ("drawing 12", True)}
    )
    assert set(found) == {"axial_amplitude", "coupling_torque", "torsional_amplitude"}
    speed = np.array([50.0])
    assert found["axial_amplitude"].continuous.at(speed) == close([4e-4])
    assert found["axial_amplitude"].source == "drawing 12"
    assert found["axial_amplitude"].assumed
    assert found["coupling_torque"].passing.at(speed) == close([3e3])
    assert found["coupling_torque"].source == "given in the engine file"
    assert found["torsional_amplitude"].continuous.at(speed) == close(np.radians([0.6]))


def test_rules_are_picked():
    section = LimitsInput.from_text(
        {
            "crankshaft_rule": "KR main engine",
            "tensile_strength": "660 MPa",
            "yield_strength": "450 MPa",
            "alloy": True,
            "highest_barred": 0.7,
            "shafts": [
                {
                    "element": "flywheel - propeller",
                    "diameter": "500 mm",
                    "tensile_strength": "560 MPa",
                }
            ],
        },
        "limits",
    )
    found = section.limits(100.0, strokes=4)
    speed = np.array([50.0])
    # Worked out by hand in tests/validation/test_limit_rules.py.
    assert found["crankshaft_stress"].continuous.at(speed) == close([52e6])
    shaft = found["shaft: flywheel - propeller"]
    assert shaft.name == "torsional stress of flywheel - propeller"
    assert shaft.continuous.at(speed) == close([61.83e6], abs=5e3)
    assert section.barred_rule(100.0).highest == close(70.0)
    assert section.barred_rule(100.0).highest_by(shaft) == close(70.0)
    assert LimitsInput().barred_rule(100.0).highest_by(shaft) == close(80.0)
    genset = section.model_copy(update={"crankshaft_rule": "KR generator set"})
    found = genset.limits(100.0, strokes=4)["crankshaft_stress"]
    assert found.continuous.at(np.array([100.0])) == close([28e6])  # 21 * 4/3


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"crankshaft_rule": "DNV"}, "limits.crankshaft_rule: given 'DNV'; allowed are KR main"),
        ({"crankshaft_rule": "KR main engine"}, "without tensile_strength and yield_strength"),
        (
            {"crankshaft_rule": "KR main engine", "crankshaft_stress": "30 MPa"},
            "together with crankshaft_stress; allowed is one of them",
        ),
        (
            {"coupling_torque_passing": "3 N m"},
            "is no less than coupling_torque, which must be given",
        ),
        ({"axial_amplitude": 0.4}, "a bare number that could be in any unit"),
        (
            {
                "shafts": [
                    {
                        "element": "a",
                        "diameter": "1 m",
                        "tensile_strength": "5e8 Pa",
                        "feature": "x",
                    }
                ]
            },
            "given 'x'; allowed are integral flange",
        ),
    ],
)
def test_impossible_limits_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        LimitsInput.from_text(values, "limits")


def test_ranges_become_spreads_of_each_chain():
    section = RangesInput.from_text(
        {"axial_compliance": [0.97, 1.05], "thrust_stiffness": [0.5, 2.0], "damping": [0.5, 2.0]},
        "ranges",
    )
    axial = section.axial_spreads()
    assert [(s.kind, s.low, s.high) for s in axial] == [
        ("compliance", 0.97, 1.05),
        ("ground stiffness", 0.5, 2.0),
        ("all damping", 0.5, 2.0),
    ]
    assert [s.name for s in section.torsional_spreads()] == ["damping"]
    assert (section.samples, section.seed, section.separation_margin) == (200, 0, 0.1)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"mass": [1.1, 1.2]},
            "ranges.mass: given .1.1, 1.2.; allowed are a low factor above 0 up to 1",
        ),
        ({"damping": [0.0, 1.2]}, "ranges.damping: given"),
        ({"samples": 1}, "ranges.samples: given 1; allowed is 2 to 100000"),
    ],
)
def test_impossible_ranges_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        RangesInput.from_text(values, "ranges")
