"""Designs against published tables, what each kind promises, and their quality."""

import itertools
import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist, pdist

from comparing import close
from refusals import refusals, refusals_of, refused
from regression.plans.designs import (
    LOADING_PAYS,
    SPACE_FILLING,
    DesignChoice,
    DesignKind,
    aliased_effects,
    check_ranges,
    corner_fraction,
    corners_by_generators,
    design_quality,
    distances_between,
    draw_feasible_points,
    fixed_design,
    full_factorial,
    latin_hypercube_points,
    resolution_of,
    smallest_distance,
    sobol_points,
    space_filling_points,
    space_filling_statement,
    values_at,
    well_spaced_subset,
    without_repeats,
)
from regression.plans.factors import Factor

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}


def unit_factors(count):
    return tuple(Factor(name, "", -1.0, 1.0) for name in "ABCDEFGHJK"[:count])


OUTLINE = Factor.of_labels("web_outline", ("obround", "rectangle"))
THREE_LABELS = Factor.of_labels("kind", ("x", "y", "z"))


def hypercube(ranges, runs, seed):
    factors = [Factor(name, "", *ends) for name, ends in ranges.items()]
    return values_at(factors, space_filling_points(factors, "latin hypercube", runs, [seed]))


def rows(table):
    return {tuple(row) for row in np.asarray(table).tolist()}


# ------------------------------------------------------------------------------------------ factorial


# 2^(4-1) with D = ABC, in standard order.
HALF_OF_FOUR = [
    (-1, -1, -1, -1),
    (1, -1, -1, 1),
    (-1, 1, -1, 1),
    (1, 1, -1, -1),
    (-1, -1, 1, 1),
    (1, -1, 1, -1),
    (-1, 1, 1, -1),
    (1, 1, 1, 1),
]
# 2^(5-2) with D = AB, E = AC.
QUARTER_OF_FIVE = [
    (-1, -1, -1, 1, 1),
    (1, -1, -1, -1, -1),
    (-1, 1, -1, -1, 1),
    (1, 1, -1, 1, -1),
    (-1, -1, 1, 1, -1),
    (1, -1, 1, -1, 1),
    (-1, 1, 1, -1, -1),
    (1, 1, 1, 1, 1),
]


@pytest.mark.parametrize(
    ("choice", "table", "told"),
    [
        ({}, HALF_OF_FOUR, "2^(4-1), resolution IV"),
        ({"resolution": 3}, QUARTER_OF_FIVE, "2^(5-2), resolution III"),
        ({"generators": "a b c ab ac"}, QUARTER_OF_FIVE, "2^(5-2), resolution III"),
    ],
)
def test_published_fractions(choice, table, told):
    choice = DesignChoice("fractional factorial", **choice)
    design = fixed_design(unit_factors(len(table[0])), choice)
    assert rows(design.runs) == rows(table)
    assert told in design.statement


def test_what_the_published_fractions_confuse():
    names = tuple("ABCDE")
    assert set(aliased_effects(np.array(HALF_OF_FOUR), names)) == {
        "A x B = C x D",
        "A x C = B x D",
        "A x D = B x C",
    }
    assert set(aliased_effects(np.array(QUARTER_OF_FIVE), names)) == {
        "A = B x D = C x E",
        "B = A x D",
        "C = A x E",
        "D = A x B",
        "E = A x C",
        "B x C = D x E",
        "B x E = C x D",
    }
    design = fixed_design(unit_factors(4), DesignChoice("fractional factorial"))
    assert len(design.remarks) == 1
    # An effect and the negative of another are as little apart.
    assert "A = B x D" in aliased_effects(corners_by_generators("a b c -ab", 4), names)


# Smallest published fraction of each resolution: (factors, resolution) -> runs.
@pytest.mark.parametrize(
    ("factors", "resolution", "runs"),
    [
        *((3, 3, 4), (4, 4, 8), (5, 3, 8), (5, 5, 16), (6, 3, 8), (6, 4, 16), (6, 6, 32)),
        *((7, 3, 8), (7, 4, 16), (7, 7, 64), (8, 4, 16), (8, 5, 64), (9, 3, 16), (9, 4, 32)),
        *((9, 6, 128), (10, 3, 16), (10, 4, 32), (10, 5, 128), (11, 5, 128)),
    ],
)
def test_sizes_of_published_fractions(factors, resolution, runs):
    design = corner_fraction(factors, resolution)
    assert design.shape == (runs, factors)
    assert resolution_of(design) == resolution
    # Balanced and orthogonal.
    assert np.array_equal(design.T @ design, runs * np.eye(factors))
    assert not design.sum(axis=0).any()


def test_all_corners_confuse_nothing():
    design = fixed_design(unit_factors(3), DesignChoice("fractional factorial", resolution=4))
    assert (len(design.runs), design.remarks) == (8, ())


def test_choices_in_a_fraction():
    """Two labels are two levels; more are crossed."""
    factors = (*unit_factors(3), OUTLINE, THREE_LABELS)
    design = fixed_design(factors, DesignChoice("fractional factorial"))
    assert len(design.runs) == 24
    for label in range(3):
        chosen = design.runs[design.runs[:, 4] == label][:, :4]
        chosen[:, 3] = 2.0 * chosen[:, 3] - 1.0
        assert rows(chosen) == rows(HALF_OF_FOUR)


@pytest.mark.parametrize(
    "generators", ["a b", "a b ab x", "a b c d ab", "a a b ab", "ab ac bc abc", "1 2 3 4"]
)
def test_generators_that_are_none(generators):
    with refused("study.generators"):
        fixed_design(unit_factors(4), DesignChoice("fractional factorial", generators=generators))


# ------------------------------------------------------------------------------------------ surfaces

# The center, and four corners of each plane through it.
BOX_BEHNKEN_OF_THREE = [
    (0, 0, 0),
    *((a, b, 0) for a in (-1, 1) for b in (-1, 1)),
    *((a, 0, b) for a in (-1, 1) for b in (-1, 1)),
    *((0, a, b) for a in (-1, 1) for b in (-1, 1)),
]


def test_box_behnken_has_its_center_once():
    design = fixed_design(unit_factors(3), DesignChoice("box-behnken"))
    assert len(design.runs) == 13
    assert rows(design.runs) == rows(BOX_BEHNKEN_OF_THREE)


def test_central_composite_on_the_faces():
    design = fixed_design(unit_factors(3), DesignChoice("central composite"))
    corners = set(itertools.product((-1.0, 1.0), repeat=3))
    stars = {tuple(row) for row in np.vstack([np.eye(3), -np.eye(3)]).tolist()}
    assert len(design.runs) == 15
    assert rows(design.runs) == corners | stars | {(0.0, 0.0, 0.0)}


def test_central_composite_with_a_fraction_of_its_corners():
    design = fixed_design(unit_factors(5), DesignChoice("central composite", resolution=5))
    assert len(design.runs) == 16 + 10 + 1


def test_three_given_levels_are_run_where_a_design_has_three():
    factors = (
        Factor.of_levels("a", "", (1.0, 2.0, 4.0)),
        Factor("b", "", 0.0, 1.0),
        Factor.of_levels("c", "", (5.0, 6.0)),
    )
    for kind in ("central composite", "box-behnken"):
        runs = fixed_design(factors, DesignChoice(kind)).runs
        assert [sorted(set(column)) for column in runs.T] == [
            [1.0, 2.0, 4.0],
            [0.0, 0.5, 1.0],
            [5.0, 5.5, 6.0],
        ]


test_too_few_factors = refusals_of(
    lambda kind, factors: fixed_design((*unit_factors(factors), THREE_LABELS), DesignChoice(kind)),
    ("box-behnken", 2, "study.design"),
    ("central composite", 1, "study.design"),
    ("fractional factorial", 2, "study.design"),
)


@pytest.mark.parametrize(
    ("choice", "levels"),
    [
        (DesignChoice("box-behnken"), 4),
        (DesignChoice("central composite"), 4),
        (DesignChoice("central composite", face="inscribed"), 3),
        (DesignChoice("fractional factorial"), 3),
    ],
)
def test_levels_that_a_design_does_not_run(choice, levels):
    odd = Factor.of_levels("odd", "m", np.linspace(0.1, 0.2, levels).tolist())
    with refused("study.factors.odd"):
        fixed_design((*unit_factors(3), odd), choice)


# ------------------------------------------------------------------------------------- space filling


@pytest.mark.slow
@settings(deadline=None, max_examples=15)
@given(runs=st.integers(1, 30), seed=st.integers(0, 2**32))
def test_latin_hypercube_has_one_run_in_each_stratum(runs, seed):
    values = hypercube(BOX, runs, seed)
    low, high = np.array(list(BOX.values())).T
    # Values are rounded to 12 digits, which may carry one over the edge of its stratum.
    strata = np.floor((values - low) / (high - low) * runs + 1e-9).astype(int)
    for column in strata.T:
        assert sorted(column) == list(range(runs))
    assert np.all(values >= low)
    assert np.all(values <= high)


def test_sobol_sequence_is_balanced_and_goes_on():
    points = sobol_points(32, [0] * 4, [5])
    for column in points.T:
        assert sorted(np.floor(32.0 * column)) == list(range(32))
    assert np.array_equal(sobol_points(20, [0] * 4, [5]), points[:20])
    assert sobol_points(1, [0], [5]).shape == (1, 1)


def test_advice_on_powers_of_two():
    assert space_filling_statement("sobol", 32, 1)[1] == ()
    (remark,) = space_filling_statement("sobol", 40, 1)[1]
    assert "32 or 64 runs" in remark


@pytest.mark.parametrize("kind", SPACE_FILLING)
@pytest.mark.parametrize("runs", [32, 50])
def test_choices_come_up_evenly(kind, runs):
    factors = (Factor("a", "", 0.0, 1.0), OUTLINE, THREE_LABELS, Factor("b", "", 0.0, 1.0))
    values = values_at(factors, space_filling_points(factors, kind, runs, [3]))
    for column, labels in ((1, 2), (2, 3)):
        counts = np.bincount(values[:, column].astype(int), minlength=labels)
        # One hypercube stratum more or less; a Sobol sequence cut between powers of two a few more.
        allowed = 1 if kind == "latin hypercube" else 4
        assert len(counts) == labels
        assert np.ptp(counts) <= allowed


def test_one_factor_and_one_run():
    assert hypercube({"web_width": (0.27, 0.33)}, 5, 0).shape == (5, 1)
    assert hypercube(BOX, 1, 0).shape == (1, 3)


def test_thinning_keeps_points_apart():
    points = latin_hypercube_points(60, [0, 0, 0], [4], tries=1)
    kept = well_spaced_subset(points, 40)
    assert len(kept) == 40
    assert list(kept) == sorted(set(kept))
    generator = np.random.default_rng(2)
    random = [pdist(points[generator.choice(60, 40, replace=False)]).min() for _ in range(100)]
    assert pdist(points[kept]).min() >= max(random)
    assert np.array_equal(well_spaced_subset(points, 60), np.arange(60))
    # Of the nearest two, 1.0 and 1.1, the one goes that has the nearer next neighbor.
    for line in ([0.0, 1.0, 1.1, 1.3, 3.0], [0.0, 0.7, 1.0, 1.1, 3.0]):
        assert well_spaced_subset(np.array(line)[:, None], 4).tolist() == [0, 1, 3, 4]


def test_drawing_goes_on_until_enough_points_can_be_used():
    def draw(count):
        return latin_hypercube_points(count, [0, 0], [1], tries=1)

    points, taken, impossible = draw_feasible_points(
        draw, lambda p: p[:, 0] < 0.2, 10, in_order=False
    )
    assert np.count_nonzero(taken) == 10
    assert np.all(points[taken][:, 0] < 0.2)
    assert np.array_equal(impossible, points[:, 0] >= 0.2)
    points, taken, _ = draw_feasible_points(draw, lambda p: p[:, 0] < 0.2, 10, in_order=True)
    assert np.flatnonzero(taken).tolist() == np.flatnonzero(points[:, 0] < 0.2)[:10].tolist()
    assert draw_feasible_points(draw, lambda p: p[:, 0] < 0.0, 10, in_order=False) is None


def test_levels_have_no_place_in_a_space_filling_design():
    with refused("study.factors.odd"):
        check_ranges([Factor.of_levels("odd", "m", (0.1, 0.2, 0.3))], "sobol")
    check_ranges([Factor.of_levels("ends", "m", (0.1, 0.2)), OUTLINE], "sobol")


# -------------------------------------------------------------------------------------------- any kind

OF_KIND = {
    "full factorial": {},
    "fractional factorial": {"resolution": 3},
    "central composite": {"face": "inscribed"},
    "box-behnken": {},
    "latin hypercube": {"runs": 17},
    "sobol": {"runs": 17},
}


@settings(deadline=None, max_examples=12)
@given(
    ranges=st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3)), min_size=3, max_size=5),
    kind=st.sampled_from(sorted(OF_KIND)),
)
def test_all_runs_lie_inside_the_box(ranges, kind):
    factors = tuple(
        Factor(name, "", low, low + width)
        for name, (low, width) in zip("abcde", ranges, strict=False)
    )
    if kind in SPACE_FILLING:
        runs = values_at(factors, space_filling_points(factors, kind, 17, [1]))
    else:
        runs = fixed_design(factors, DesignChoice(kind, **OF_KIND[kind])).runs
    for factor, column in zip(factors, runs.T, strict=True):
        assert column.min() >= factor.lowest
        assert column.max() <= factor.highest
    assert without_repeats(runs)[1] == 0


def test_rows_of_ones_own_lose_their_repeats_and_say_so():
    choice = DesignChoice("file", rows=((0.0, 1.0), (0.5, -1.0), (0.0, 1.0)))
    design = fixed_design(unit_factors(2), choice)
    assert design.runs.tolist() == [[0.0, 1.0], [0.5, -1.0]]
    assert len(design.remarks) == 1


test_rows_that_do_not_fit = refusals_of(
    lambda rows_: fixed_design(unit_factors(2), DesignChoice("file", rows=rows_)),
    (((0.0, 0.0), (0.0, 1.5)), "study.file"),
)


def test_every_kind_can_be_chosen():
    assert set(get_args(DesignKind)) == {*OF_KIND, "file"}


@pytest.mark.parametrize("ends", [(0.33, 0.27), (0.27, 0.27), (0.27, math.inf), (math.nan, 1.0)])
def test_unusable_ranges(ends):
    with refused("study.factors.web_width"):
        hypercube({"web_width": ends}, 5, 0)


A, B = Factor("a", "m", 1.0, 3.0), Factor("b", "m", 0.1, 0.2)
TWO, THREE = Factor.of_labels("two", ("x", "y")), Factor.of_labels("three", ("x", "y", "z"))


def test_random_points_have_the_mean_discrepancy_told():
    """Mean over 400 sets of 20 points; its own standard error is some 2 %."""
    rng = np.random.default_rng(1)
    sets = [design_quality((A, B), _in_box(rng.random((20, 2)))) for _ in range(400)]
    mean = np.mean([found.discrepancy for found in sets])
    assert mean == close(sets[0].random_discrepancy, rel=0.06)


def _in_box(points):
    return np.array([1.0, 0.1]) + points * np.array([2.0, 0.1])


def test_labels_of_a_choice_are_their_share_of_the_cube_apart():
    values = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
    assert design_quality((A, THREE), values).distance == close(1 / 3)


@pytest.mark.parametrize("count", [2, 40])
def test_a_hidden_line_is_told(count):
    line = np.linspace(0.0, 1.0, count)
    found = design_quality((A, B), _in_box(np.column_stack([line, 1.0 - line])))
    assert found.correlation == close(1.0)
    assert found.correlated == ("a", "b")


def test_of_pairs_on_one_line_the_first_is_told():
    line = np.array([1.0, 2.0, 3.0])
    factors = [Factor(name, "m", 1.0, 3.0) for name in "abc"]
    assert design_quality(factors, np.column_stack([line] * 3)).correlated == ("a", "b")


@pytest.mark.parametrize("count", [2, 16, LOADING_PAYS, LOADING_PAYS + 1])
def test_distances_of_few_points_are_scipys_to_the_last_bit(count):
    points = np.random.default_rng(count).random((count, 5))
    assert smallest_distance(points) == math.sqrt(pdist(points, "sqeuclidean").min())
    apart = cdist(points, points)[np.triu_indices(count, 1)]
    assert np.array_equal(distances_between(points)[np.triu_indices(count, 1)], apart)


test_refused = refusals(
    ("study.design", lambda: full_factorial({name: list(range(101)) for name in "abc"})),
)
