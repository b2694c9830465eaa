"""Engines changed in Python: checked like files, and calculated as changed."""

from dataclasses import replace

import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.assumptions import assumed_values
from crankfem.analyses.file_check import refuse_what_cannot_run
from crankfem.analyses.shaft.chains import engine_throw_inertias
from crankfem.analyses.vibration.engine_limits import engine_limits, rule_of
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.mechanism_file import load_mechanism, mechanism_of
from crankfem.files.reading.data_files import input_path


@pytest.fixture(scope="module")
def engine():
    return load_engine("6chn25-34")


def test_an_unchanged_engine_has_the_files_mechanism(engine):
    read, made = load_mechanism("6chn25-34"), mechanism_of(engine)
    assert made.layout == read.layout
    assert made.remarks == read.remarks
    assert (made.throws, made.throw_angles_deg) == (read.throws, read.throw_angles_deg)
    assert made.attached_inertia == read.attached_inertia
    assert made.pressure[0].pressure.tolist() == read.pressure[0].pressure.tolist()


@pytest.mark.parametrize(
    "way", [lambda e, rod: e.changed(rod=rod), lambda e, rod: replace(e, rod=rod)]
)
def test_a_changed_rod_changes_mechanism_and_inertias(engine, way):
    """Half a rod's rotating mass more at the crank radius, exactly: that is how rods count there."""
    rod = engine.rod.changed(
        rotating_mass=engine.rod.rotating_mass + 2.0, mass=engine.rod.mass + 2.0
    )
    heavier = way(engine, rod)
    own, other = (engine_throw_inertias(one, 1.0) for one in (engine, heavier))
    assert other - own == close(2.0 * engine.throw.crank_radius**2, rel=1e-9)
    assert mechanism_of(heavier).layout.cylinders[0].rod.mass == rod.mass


def test_fields_make_sections(engine):
    damper = {"kind": "viscous", "ring_inertia": 5.0, "damping": 2000.0}
    changed = engine.changed(
        throw={"web_thickness": 0.070}, torsional_damper=damper, two_mass=None, gas=None
    )
    assert changed.throw.web_thickness == 0.070
    assert changed.throw.crank_radius == engine.throw.crank_radius
    assert changed.torsional_damper.ring_inertia == 5.0
    assert changed.gas is None
    assert changed.study.throw == changed.throw
    assert changed.path == engine.path


def test_changed_values_lose_their_sources(engine):
    changed = engine.changed(throw={"crank_radius": 0.1701}, free_end=None)
    before, after = ({r.field: r for r in one.records} for one in (engine, changed))
    radius = after["throw.crank_radius"]
    assert (radius.given, radius.source, radius.assumed) == ("170.1 mm", "changed in Python", False)
    assert changed.provenance["throw.crank_radius"] == ("changed in Python", False)
    assert after.keys() == before.keys() - {"free_end.inertia", "free_end.mass"}
    assert after["throw.web_width"] == before["throw.web_width"]
    assert list(after)[:8] == list(before)[:8]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"rods": {}}, "rods: unknown section; did you mean rod?"),
        ({"rod": None}, "rod: given None; allowed are its fields"),
        ({"rod": 0.7}, "rod: given 0.7; allowed are fields with their values"),
        ({"rod": {"lenght": 0.7}}, "rod.lenght: unknown field; did you mean length?"),
        ({"rod": {"length": 0.2}}, "rod.length: given 200 mm; allowed is more than"),
        (
            {"throw": {"crank_radius": 0.160}},
            "throw.crank_radius: given 160 mm; allowed is half of",
        ),
        ({"thrust_bearing": {"main_bearing": 9}}, "thrust_bearing.main_bearing: given 9; allowed"),
        ({"thrust_bearing": {"bearing": 6}}, "thrust_bearing.bearing: given 6; this field counted"),
        ({"vibration": {"highest_order": 2.2}}, "vibration.highest_order: given 2.2"),
    ],
)
def test_impossible_changes_are_refused(engine, change, text):
    with pytest.raises(InputError) as caught:
        engine.changed(**change)
    assert str(caught.value).startswith(text)


def test_a_mechanism_of_the_engine_before_is_refused(engine):
    longer = engine.changed(rod={"length": engine.rod.length + 0.01})
    with pytest.raises(InputError, match="mechanism: given one with other cylinders"):
        engine_vibration(longer, mechanism=load_mechanism(input_path("6chn25-34")))


@pytest.mark.parametrize("rule", [{}, {"crankshaft_rule": "KR main engine"}])
def test_a_strength_beyond_the_rule_stays_as_given_and_is_told(engine, rule):
    given = {"yield_strength": 550e6, "tensile_strength": 850e6, "alloy": True}
    strong = engine.changed(limits=given | rule)
    refuse_what_cannot_run(strong)
    assert strong.limits.tensile_strength == 850e6
    assert (
        "850 MPa enters the rule as 835 MPa" in engine_limits(strong)[0]["crankshaft_stress"].remark
    )


def test_a_yield_strength_above_the_assumed_steel_is_refused_before_the_run(engine):
    with pytest.raises(InputError, match=r"^limits\.yield_strength: given 550 MPa without tensile"):
        refuse_what_cannot_run(engine.changed(limits={"yield_strength": 550e6}))


@pytest.mark.parametrize(
    ("driven", "rule"), [("generator", "KR generator set"), ("propeller", "KR main engine")]
)
def test_the_rule_that_is_listed_as_assumed_is_the_one_that_is_taken(driven, rule):
    engine = load_engine("6chn25-34").changed(engine={"drives": driven})
    (listed,) = (one for one in assumed_values(engine) if one.field == "limits.crankshaft_rule")
    assert listed.given == rule == rule_of(engine.engine)
