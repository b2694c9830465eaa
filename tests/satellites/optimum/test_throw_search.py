"""The best throw by finite elements and slopes: the search on analytic throws, and real ones."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError, MeshError
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.optimum import throw_search
from crankfem.satellites.optimum.frequencies import engine_frequencies
from crankfem.satellites.optimum.searches import parse_range
from crankfem.satellites.optimum.throw_search import (
    ACTIVE,
    SPARE,
    SearchInterrupted,
    SlopedThrow,
    ThrowFamily,
    ThrowSearch,
    best_throw,
)
from fem.analysis import analyze_throw
from refusals import refused
from regression.optimum import Limit, Problem, search_space

ENGINE = load_engine("6chn25-34")
RANGES = {"web_width": (0.24, 0.36), "web_thickness": (0.05, 0.09)}
ERROR = 0.004


def mass(web_width, web_thickness):
    return 90.0 + 5000.0 * web_width * web_thickness


def axial(web_width, web_thickness):
    """Least mass under a limit of it lies inside the ranges: narrow webs become soft."""
    return 1.1e-9 * (web_thickness / 0.068) ** -1.4 + 0.2e-9 * (web_width / 0.285) ** -4.0


RESPONSES = {"mass": mass, "axial_compliance": axial}


def analytic(factors):
    values = {name: response(**factors) for name, response in RESPONSES.items()}
    slopes = {name: [] for name in RESPONSES}
    for name, dimension in itertools.product(RESPONSES, factors):
        ends = [
            RESPONSES[name](**{**factors, dimension: factors[dimension] * (1.0 + step)})
            for step in (-1e-6, 1e-6)
        ]
        slopes[name].append(math.log(ends[1] / ends[0]) / 2e-6)
    shares = {name: np.array(each) for name, each in slopes.items()}
    return SlopedThrow(factors, values, {"mass": 0.0, "axial_compliance": ERROR}, shares)


def searched(bound, analyze=analytic, refusal=lambda _: "", ranges=RANGES):
    family = ThrowFamily(ENGINE, ranges)
    limits = (Limit(("axial_compliance",), at_most=bound, unit="m/N"),)
    space = search_space(family, {})
    whole = Problem(family, "mass", limits, True, space, spare=SPARE, active=ACTIVE)
    search = ThrowSearch(whole, analyze, refusal, lambda _: None)
    search.follow({name: getattr(ENGINE.throw, name) for name in ranges})
    return search


def least_mass(bound, narrowest=0.0):
    widths, thicknesses = np.meshgrid(*(np.linspace(*ends, 1001) for ends in RANGES.values()))
    kept = (axial(widths, thicknesses) * (1.0 + ERROR) <= bound) & (widths >= narrowest)
    return mass(widths, thicknesses)[kept].min()


@pytest.mark.slow
@pytest.mark.parametrize("bound", [1.1e-9, 1.3e-9, 1.5e-9])
def test_the_search_finds_what_a_fine_grid_finds(bound):
    search = searched(bound)
    found = search.result()
    assert found.value == close(least_mass(bound), rel=2e-3)
    (check,) = found.limits
    assert check.worst <= bound
    assert check.worst == close(axial(**found.factors) * (1.0 + ERROR), rel=1e-12)
    assert len(search.throws) <= 10
    assert found.evaluations == len(search.throws)
    assert any("promise no gain" in remark for remark in found.remarks)


@pytest.mark.slow
def test_it_stops_at_throws_that_cannot_be_built():
    def refusal(factors):
        return "too narrow" if factors["web_width"] < 0.28 else ""

    found = searched(1.3e-9, refusal=refusal).result()
    assert found.factors["web_width"] == close(0.28, rel=1e-4)
    assert found.value == close(least_mass(1.3e-9, narrowest=0.28), rel=2e-3)
    assert any("cannot be built" in remark and "too narrow" in remark for remark in found.remarks)


@pytest.mark.slow
def test_throws_that_cannot_be_meshed_are_passed_by():
    asked = []

    def analyze(factors):
        asked.append(factors)
        if len(asked) == 2:
            raise MeshError("no mesh")
        return analytic(factors)

    search = searched(1.5e-9, analyze)
    assert search.refused == ["no mesh"]
    found = search.result()
    assert found.value == close(least_mass(1.5e-9), rel=2e-3)
    assert "no mesh" in found.remarks[-1]


def test_where_nothing_can_be_gained_one_analysis_is_enough():
    width, thickness = ENGINE.throw.web_width, ENGINE.throw.web_thickness
    ranges = {"web_width": (width, 0.36), "web_thickness": (thickness, 0.09)}
    search = searched(2e-9, ranges=ranges)
    assert len(search.throws) == 1
    assert search.result().at_ends == ("web_width", "web_thickness")


@pytest.mark.slow
def test_limits_that_cannot_be_kept_name_the_nearest_throw():
    search = searched(0.5e-9)
    with pytest.raises(InputError, match=r"web_width 360 mm, web_thickness 90 mm.*comes to"):
        search.result()
    assert len(search.throws) <= 6


@pytest.mark.parametrize(
    ("ranges", "match"),
    [
        ({}, "given no dimension"),
        ({"web_wdth": (0.2, 0.3)}, "did you mean web_width"),
        ({"web_outline": (0.2, 0.3)}, "given 'web_outline'"),
        ({"pin_bore": (0.01, 0.02)}, "given 'pin_bore'"),
        ({"web_width": (0.3, 0.2)}, "from 300 mm to 200 mm"),
        ({"web_width": (0.3, 0.4)}, "around the engine's own 285 mm"),
        ({"web_width": (0.1, 400.0)}, "allowed is"),
    ],
)
def test_impossible_ranges(ranges, match):
    with pytest.raises(InputError, match=match):
        ThrowFamily(ENGINE, ranges)


@pytest.mark.parametrize(
    ("name", "text", "match"),
    [
        ("hue", "1mm..2mm", "given 'hue'"),
        ("web_width", "300mm", "a range with two points"),
        ("web_width", "300..380", "bare number"),
    ],
)
def test_unreadable_ranges(name, text, match):
    with pytest.raises(InputError, match=match):
        parse_range(name, text)


@pytest.mark.parametrize(
    ("minimize", "limit", "match"),
    [
        ("hue", "mass", "minimize: given 'hue'"),
        ("mass", "fillet_stress_factor", "limit on fillet_stress_factor: given"),
    ],
)
def test_unknown_quantities(minimize, limit, match):
    with pytest.raises(InputError, match=match):
        best_throw(ENGINE, RANGES, minimize, [Limit((limit,), at_most=1.0)])


@pytest.mark.parametrize("engine", ["6chn25-34", "mine.toml"])
def test_an_engine_without_a_dimension_is_refused(call, engine):
    answer = call("optimum", engine, "--minimize", "mass")
    assert answer.code == 2
    assert answer.err.startswith(f"Error: {engine}: given without --vary")


@pytest.fixture(scope="module")
def family():
    return ThrowFamily(ENGINE, {"web_width": (0.25, 0.32), "crank_radius": (0.16, 0.18)})


@pytest.fixture(scope="module")
def own(family):
    at = {"web_width": ENGINE.throw.web_width, "crank_radius": ENGINE.throw.crank_radius}
    return family.analyzed(at, 0.01, True)


@pytest.mark.slow
def test_frequencies_are_those_of_the_engine(own):
    engine = engine_frequencies(ENGINE)
    e, e_t = own.values["axial_compliance"], own.values["torsional_compliance"]
    assert own.values["first_axial_frequency"] == close(engine.axial(e), rel=1e-9)
    assert own.values["first_torsional_frequency"] == close(engine.torsional(e_t), rel=1e-9)
    assert own.errors["first_axial_frequency"] < own.errors["axial_compliance"]


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1])
def test_slopes_are_those_of_meshed_throws(family, own, number):
    name = list(family.ranges)[number]
    less, more = (
        family.analyzed({**own.factors, name: own.factors[name] * factor}, 0.01, True)
        for factor in (0.97, 1.03)
    )
    for response in ("first_axial_frequency", "first_torsional_frequency", "axial_compliance"):
        share = math.log(more.values[response] / less.values[response]) / math.log(1.03 / 0.97)
        assert abs(own.slopes[response][number] - share) < 0.03


@pytest.mark.slow
def test_the_best_throw_is_an_analyzed_one():
    limits = [
        Limit(("axial_compliance",), at_most=1.25e-9, unit="m/N"),
        Limit(("first_torsional_frequency",), at_least=84.0, unit="Hz"),
    ]
    steps = []
    found = best_throw(ENGINE, RANGES, "mass", limits, step=steps.append, accuracy=0.02)
    again = analyze_throw(found.throw, ENGINE.material, 0.02)
    assert found.limits[0].value == close(again.axial_compliance("pinned"), rel=1e-9)
    assert found.value == close(again.mass, rel=1e-9)
    assert found.value < analyze_throw(ENGINE.throw, ENGINE.material, 0.02).mass
    assert all(check.limit.excess(check.worst) <= 0.0 for check in found.limits)
    assert found.lookups["mass"].value == found.value
    assert len(steps) == found.evaluations <= 12


@pytest.mark.slow
def test_an_interrupt_brings_the_best_throw_so_far():
    def interrupt(sentence):
        if sentence.startswith("Analysis 2"):
            raise KeyboardInterrupt

    limit = Limit(("axial_compliance",), at_most=1.4e-9, unit="m/N")
    with pytest.raises(SearchInterrupted) as stopped:
        best_throw(ENGINE, RANGES, "mass", [limit], step=interrupt, accuracy=0.05)
    assert stopped.value.best.factors["web_width"] == ENGINE.throw.web_width
    limit = Limit(("axial_compliance",), at_most=1.2e-9, unit="m/N")
    with pytest.raises(SearchInterrupted) as stopped:
        best_throw(ENGINE, RANGES, "mass", [limit], step=interrupt, accuracy=0.05)
    assert stopped.value.best is None


def test_throws_of_several_pins_have_no_angle():
    """Their analyses have no tilt stiffness ratio, from which the law of the angle would follow."""
    analyzed = SimpleNamespace(here=SimpleNamespace(values={"axial_compliance_in_line": 1e-9}))
    with refused("gamma_deg"):
        throw_search._Beside(analyzed, {}).band("axial_compliance", 60.0)
