"""Factors and plans of studies."""

import dataclasses
import json
import math
import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from fem.material import STEEL
from geometry.throw import CrankThrow
from plans import FILLETED, plan_of_levels
from refusals import refused
from regression.plans.designs import SPACE_FILLING, DesignChoice
from regression.plans.factors import Factor, rounded, throw_fields, unknown_field
from regression.plans.plan import StudyPlan, plan_designs
from regression.records import HELD_OUT, RUN
from throws import MEDIUM_SPEED

THROW = FILLETED
HEAVY = CrankThrow(
    **THROW.model_dump(mode="json")
    | {
        "counterweight": {"outer_radius": 0.25, "angle": 2.0},
        "further_pins": ({"angle": 2.0, "web_thickness": 0.06},),
    }
)
# The factors do not stand in alphabetical order: it must not matter.
THREE = {
    "web_width": (0.270, 0.300, 0.330),
    "web_thickness": (0.038, 0.068, 0.098),
    "pin_length": (0.120, 0.139, 0.158),
}
WIDTH, THICKNESS, LENGTH = (
    Factor(name, "m", min(levels), max(levels)) for name, levels in THREE.items()
)
OUTLINE = Factor.of_labels("web_outline", ("obround", "rectangle"))
RATIO = Factor("width_ratio", "", 1.5, 1.8)
HYPERCUBE = DesignChoice("latin hypercube", runs=12)


def of_role(planned, role):
    return [design for design in planned.designs if design.role == role]


def values_of(planned, role):
    return np.array([design.values for design in of_role(planned, role)])


# ----------------------------------------------------------------------------- runs and held-out designs


def test_held_out_designs_lie_between_the_levels_one_in_each_stratum():
    held = values_of(plan_designs(plan_of_levels(THROW, THREE, held_out=8)), HELD_OUT)
    for column, levels in zip(held.T, THREE.values(), strict=True):
        strata = np.floor(8 * (column - min(levels)) / (max(levels) - min(levels)))
        assert sorted(strata) == list(range(8))
        assert not set(column) & set(levels)


def test_the_seed_moves_what_is_drawn_alone():
    first, second = (plan_designs(plan_of_levels(THROW, THREE, seed=seed)) for seed in (1, 2))
    assert of_role(first, RUN) == of_role(second, RUN)
    keys = [{design.key for design in of_role(planned, HELD_OUT)} for planned in (first, second)]
    assert not keys[0] & keys[1]
    assert plan_designs(plan_of_levels(THROW, THREE, seed=1)) == first


def test_a_middle_that_is_calculated_is_the_level_that_is_written():
    """Designs of different studies share their results where they are the same throw."""
    written = plan_designs(plan_of_levels(THROW, THREE))
    halved = plan_designs(StudyPlan(THROW, (WIDTH, THICKNESS, LENGTH), DesignChoice("box-behnken")))
    keys = [{design.key for design in of_role(planned, RUN)} for planned in (written, halved)]
    assert keys[1] < keys[0]


# ------------------------------------------------------------------------------ factors of all kinds


def test_nested_fields_and_fields_that_are_angles():
    factors = (
        Factor("counterweight.angle", "rad", 1.0, 2.5),
        Factor("further_pins.0.web_thickness", "m", 0.05, 0.07),
        Factor("left_web.width", "m", 0.28, 0.30),
    )
    planned = plan_designs(StudyPlan(HEAVY, factors))
    assert len(of_role(planned, RUN)) == 8
    for design in planned.designs:
        throw = CrankThrow(**design.inputs["throw"])
        assert design.values == (
            throw.counterweight.angle,
            throw.further_pins[0].web_thickness,
            throw.left_web.width,
        )


def test_relations_follow_the_factors():
    plan = StudyPlan(
        THROW,
        (RATIO, THICKNESS, LENGTH),
        HYPERCUBE,
        relations={
            "main_journal_length": "410 mm - pin_length - 2 * web_thickness",
            "web_width": "width_ratio * pin_diameter",
            "pin_fillet_radius": "main_journal_fillet_radius / 2",
            "main_journal_fillet_radius": "0.08 * pin_diameter",
        },
    )
    for design in plan_designs(plan).designs:
        ratio, thickness, length = design.values
        throw = design.inputs["throw"]
        assert throw["web_width"] == rounded(ratio * 0.18)
        assert throw["main_journal_length"] == rounded(0.41 - length - 2 * thickness)
        assert throw["main_journal_fillet_radius"] == 0.0144
        assert throw["pin_fillet_radius"] == 0.0072
        assert "width_ratio" not in throw
        assert CrankThrow(**throw).length == close(0.41, rel=1e-11)


# ----------------------------------------------------------------------------------------- exclusion


def test_corners_that_break_a_constraint_are_excluded_and_told():
    plan = plan_of_levels(
        THROW, THREE, constraints=("web_thickness >= 0.25 * pin_diameter", "pin_length <= 150 mm")
    )
    planned = plan_designs(plan)
    assert len(of_role(planned, RUN)) == 3 * 2 * 2
    assert len(of_role(planned, HELD_OUT)) == 10
    for design in planned.designs:
        assert design.values[1] >= 0.045
        assert design.values[2] <= 0.150
    excluded = [design for design in planned.excluded if design.role == RUN]
    assert len(excluded) == 15
    thin = [design for design in excluded if design.values[1] == 0.038]
    assert len(thin) == 9
    assert all(design.reason.endswith("38 mm is not >= 45 mm") for design in thin)
    assert "27 runs, 15 of them" in planned.statement


@pytest.mark.parametrize("kind", SPACE_FILLING)
def test_space_filling_designs_keep_their_number(kind):
    plan = StudyPlan(
        THROW,
        (WIDTH, THICKNESS, LENGTH),
        DesignChoice(kind, runs=24),
        constraints=("web_thickness < 0.2 * web_width",),
    )
    planned = plan_designs(plan)
    assert len(of_role(planned, RUN)) == 24
    assert len(of_role(planned, HELD_OUT)) == 10
    for design in planned.designs:
        assert design.values[1] < 0.2 * design.values[0]
    excluded = [design for design in planned.excluded if design.role == RUN]
    assert excluded
    for design in excluded:
        assert design.values[1] >= 0.2 * design.values[0]
    told = re.search(
        r"24 runs of (\d+) points drawn, (\d+) of them excluded(?: and (\d+) not needed)?$",
        planned.statement,
    )
    points, out, spare = (int(number or 0) for number in told.groups())
    assert out == len(excluded)
    assert points == 24 + out + spare


def test_a_relation_without_a_value_excludes_the_design():
    plan = StudyPlan(
        THROW,
        (Factor.of_levels("ratio", "", (0.0, 1.0, 2.0)),),
        relations={"web_width": "300 mm / ratio"},
    )
    planned = plan_designs(plan)
    assert [design.values for design in of_role(planned, RUN)] == [(1.0,)]
    reasons = {design.values: design.reason for design in planned.excluded if design.role == RUN}
    assert all(reasons[(ratio,)] for ratio in (0.0, 2.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "figure"), [(DesignChoice(), "4 designs"), (HYPERCUBE, "12 of the points")]
)
def test_a_study_of_which_nothing_remains(design, figure):
    plan = StudyPlan(THROW, (WIDTH, LENGTH), design, constraints=("web_width < 0.2 m",))
    with pytest.raises(InputError, match=rf"^study\.factors: .*{figure}"):
        plan_designs(plan)


# ------------------------------------------------------------------------------------ what cannot be


COUNTER = Factor("counterweight.angle", "rad", 1.0, 2.0)
LABELS = Factor.of_labels("pin_length", ("short", "long"))
HEXAGON = Factor.of_labels("web_outline", ("obround", "hexagon"))
LEVELS = Factor.of_levels("web_width", "m", (0.27, 0.28, 0.33))


@pytest.mark.parametrize(
    ("factors", "options", "field"),
    [
        ((), {}, "factors"),
        ((OUTLINE,), {}, "factors"),
        ((WIDTH, WIDTH), {}, "factors.web_width"),
        ((Factor("web_with", "m", 0.1, 0.2),), {}, "factors.web_with"),
        ((WIDTH, RATIO), {}, "factors.width_ratio"),
        ((Factor("web_width", "rad", 0.1, 0.2),), {}, "factors.web_width"),
        ((WIDTH, HEXAGON), {}, "factors.web_outline"),
        ((WIDTH, LABELS), {}, "factors.pin_length"),
        ((WIDTH, Factor("web_outline", "", 0.0, 1.0)), {}, "factors.web_outline"),
        ((COUNTER,), {}, "factors.counterweight.angle"),
        ((LEVELS,), {"design": HYPERCUBE}, "factors.web_width"),
        ((WIDTH,), {"constraints": ("web_width > 3",)}, "constraints[0]"),
        *(
            ((WIDTH,), {"relations": relations}, field)
            for relations, field in (
                ({"web_width": "2 * pin_diameter"}, "relations.web_width"),
                ({"web_outline": "2 * pin_diameter"}, "relations.web_outline"),
                ({"overlap": "2 * pin_diameter"}, "relations.overlap"),
                ({"pin_length": "web_width ** 2"}, "relations.pin_length"),
                ({"pin_length": "web_tip_thickness"}, "relations.pin_length"),
                ({"pin_length": "web_thickness", "web_thickness": "pin_length"}, "relations"),
            )
        ),
        # The name of a unit.
        (
            (WIDTH, Factor("h", "", 1.0, 2.0)),
            {"relations": {"pin_length": "h * pin_diameter"}},
            "factors.h",
        ),
    ],
)
def test_plans_that_cannot_be(factors, options, field):
    with pytest.raises(InputError, match=rf"^study\.{re.escape(field)}: [^\n]+\.$"):
        StudyPlan(THROW, factors, **options)


# ------------------------------------------------------------------------------------ keys and records

PLAN = StudyPlan(
    THROW,
    (WIDTH, THICKNESS, RATIO),
    DesignChoice("central composite"),
    relations={"pin_length": "0.45 * width_ratio * pin_diameter"},
    constraints=("web_thickness > 30 mm", "pin_length < 1 m"),
)


@pytest.mark.parametrize(
    "change",
    [
        {"throw": THROW.model_copy(update={"fillet_radius": 0.0})},
        {"factors": (THICKNESS, WIDTH, RATIO)},
        {"factors": (WIDTH, THICKNESS, Factor("width_ratio", "", 1.5, 1.81))},
        {"factors": (WIDTH, THICKNESS, Factor.of_levels("width_ratio", "", (1.5, 1.6, 1.8)))},
        {"factors": (WIDTH, THICKNESS, RATIO, OUTLINE)},
        {"design": DesignChoice("central composite", face="inscribed")},
        {"design": DesignChoice("central composite", resolution=5)},
        {"design": DesignChoice("sobol", runs=8)},
        {"design": DesignChoice("sobol", runs=9)},
        {"design": DesignChoice("fractional factorial", generators="a b ab")},
        {"design": DesignChoice("file", rows=((0.3, 0.05, 1.6),))},
        {"relations": {"pin_length": "0.46 * width_ratio * pin_diameter"}},
        {"constraints": ("web_thickness > 30 mm",)},
        {"held_out": 11},
        {"seed": 2},
        {"material": STEEL.model_copy(update={"density": 7800.0})},
        {"accuracy": 0.02},
        {"stresses": True},
    ],
)
def test_plans_that_differ_have_keys_that_differ(change):
    other = dataclasses.replace(PLAN, **change)
    assert other.key != PLAN.key
    assert other != PLAN
    assert StudyPlan.from_record(other.as_record()) == other


ENDS = st.tuples(st.floats(0.01, 1.0), st.floats(0.001, 1.0)).map(lambda e: (e[0], e[0] + e[1]))


@st.composite
def plans(draw):
    factors = [
        Factor(name, "m", *draw(ENDS))
        for name in draw(st.permutations(["web_width", "pin_length", "web_thickness"]))
    ]
    if draw(st.booleans()):
        low, high = draw(ENDS)
        count = draw(st.integers(2, 5))
        spacing = draw(st.sampled_from(["even", "log", "chebyshev"]))
        factors.append(Factor.spread("pin_bore", "m", low, high, count, spacing))
    if draw(st.booleans()):
        factors.insert(0, OUTLINE)
    return StudyPlan(
        THROW,
        tuple(factors),
        relations=draw(st.sampled_from([{}, {"crank_radius": "1.1 * pin_diameter"}])),
        constraints=draw(st.sampled_from([(), ("pin_length < 2 m",)])),
        held_out=draw(st.integers(1, 100)),
        seed=draw(st.integers(0, 2**31 - 1)),
        accuracy=draw(st.floats(0.001, 0.1)),
        stresses=draw(st.booleans()),
    )


@settings(deadline=None, max_examples=20)
@given(plan=plans())
def test_a_plan_comes_back_from_its_record(plan):
    again = StudyPlan.from_record(json.loads(json.dumps(plan.as_record())))
    assert again == plan
    assert again.key == plan.key
    assert again.names == plan.names


PLAIN = MEDIUM_SPEED | {"fillet_radius": 0.0}
FACTOR_THROW = CrankThrow(**PLAIN)


def test_the_middle_of_a_range_is_what_one_would_write():
    assert Factor.spread("pin_length", "m", 0.120, 0.158, 3, "even").levels[1] == 0.139
    assert rounded(3 * 0.1) == 0.3
    assert 3 * 0.1 != 0.3
    assert rounded(0.0) == 0.0


@pytest.mark.parametrize(
    "make",
    [
        lambda: Factor("a", "m", 0.2, 0.1),
        lambda: Factor("a", "m", 0.1, math.inf),
        lambda: Factor("a", "m", 0.1, 0.2, (0.1, 0.3)),
        *(
            partial(Factor.of_levels, "a", "m", levels)
            for levels in ((), (0.1,), (0.1, 0.1), (0.1, 0.2, 0.1))
        ),
        *(partial(Factor.of_labels, "a", labels) for labels in (("x",), ("x", "y", "x"))),
        partial(Factor.spread, "a", "m", 0.1, 0.2, 1, "even"),
        partial(Factor.spread, "a", "m", 0.1, 0.2, 3, "odd"),
        partial(Factor.spread, "a", "m", 0.0, 0.2, 3, "log"),
        partial(Factor.spread, "a", "m", 0.2, 0.2, 3, "log"),
    ],
)
def test_factors_that_cannot_be(make):
    with pytest.raises(InputError, match=r"^study\.factors\.a[a-z.]*: given [^\n]+\.$"):
        make()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("web_with", "did you mean web_width? "),
        ("counterweight.angle", "the throw has no counterweight to vary; give it in [throw]"),
        ("left_web.counterweight.angle", "the throw has no left_web.counterweight to vary"),
        ("further_pins.0.length", "the throw has no further_pins to vary"),
        ("nonsense.angle", "allowed are crank_radius, "),
    ],
)
def test_unknown_fields(path, message):
    assert unknown_field(path, throw_fields(FACTOR_THROW), FACTOR_THROW).startswith(message)


@pytest.mark.parametrize("count", [0, -1, 2.5])
def test_some_designs_judge_the_fits(count):
    with refused("study.held_out"):
        StudyPlan(THROW, (WIDTH, THICKNESS), HYPERCUBE, held_out=count)
