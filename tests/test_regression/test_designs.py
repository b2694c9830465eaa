import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from geometry.errors import InputError
from regression.designs import full_factorial, latin_hypercube

BOX = {
    "web_width": (0.270, 0.330),
    "web_thickness": (0.038, 0.098),
    "pin_length": (0.120, 0.158),
}


def test_full_factorial_runs_every_combination_once():
    design = full_factorial(
        {"web_width": [0.27, 0.30, 0.33], "web_thickness": [0.038, 0.098], "pin_length": [0.139]}
    )
    assert design.factors == ("web_width", "web_thickness", "pin_length")
    assert design.kind == "full factorial"
    assert design.seed is None
    assert design.runs.tolist() == [
        [0.27, 0.038, 0.139],
        [0.27, 0.098, 0.139],
        [0.30, 0.038, 0.139],
        [0.30, 0.098, 0.139],
        [0.33, 0.038, 0.139],
        [0.33, 0.098, 0.139],
    ]
    assert len(design) == 6
    assert design.as_dicts()[1] == {
        "web_width": 0.27,
        "web_thickness": 0.098,
        "pin_length": 0.139,
    }


@settings(deadline=None, max_examples=25)
@given(runs=st.integers(1, 30), seed=st.integers(0, 2**32))
def test_latin_hypercube_has_one_run_in_each_stratum(runs, seed):
    design = latin_hypercube(BOX, runs, seed)
    low, high = np.array(list(BOX.values())).T
    strata = np.floor((design.runs - low) / (high - low) * runs + 1e-9).astype(int)
    for column in strata.T:
        assert sorted(column) == list(range(runs))
    assert np.all(design.runs >= low)
    assert np.all(design.runs <= high)


def test_latin_hypercube_is_repeatable():
    first, second = latin_hypercube(BOX, 12, 7), latin_hypercube(BOX, 12, 7)
    assert np.array_equal(first.runs, second.runs)
    assert not np.array_equal(first.runs, latin_hypercube(BOX, 12, 8).runs)
    assert first.seed == 7
    assert first.kind == "latin hypercube"


def test_latin_hypercube_is_spread_better_than_nearly_all_random_ones():
    unit = {"a": (0.0, 1.0), "b": (0.0, 1.0), "c": (0.0, 1.0)}
    ours = pdist(latin_hypercube(unit, 20, 3).runs).min()
    generator = np.random.default_rng(11)
    random = []
    for _ in range(100):
        strata = np.column_stack([generator.permutation(20) for _ in range(3)])
        random.append(pdist((strata + generator.random((20, 3))) / 20).min())
    assert ours > np.quantile(random, 0.98)


def test_one_factor_and_one_run():
    assert latin_hypercube({"web_width": (0.27, 0.33)}, 5, 0).runs.shape == (5, 1)
    assert latin_hypercube(BOX, 1, 0).runs.shape == (1, 3)


def test_runs_cannot_be_changed():
    design = full_factorial({"web_width": [0.27, 0.33]})
    with pytest.raises(ValueError, match="read-only"):
        design.runs[0, 0] = 1.0


@pytest.mark.parametrize(
    ("levels", "match"),
    [
        ({}, "factors: given none"),
        ({"web_width": []}, "web_width: given no level"),
        ({"web_width": [0.27, 0.27]}, "web_width: given .* each level may stand once"),
        ({"web_width": [math.nan]}, "web_width: given nan"),
        ({name: list(range(1, 102)) for name in "abc"}, "runs: given 1030301"),
    ],
)
def test_unusable_levels(levels, match):
    with pytest.raises(InputError, match=match):
        full_factorial(levels)


@pytest.mark.parametrize(
    ("ranges", "runs", "seed", "match"),
    [
        ({}, 5, 0, "factors: given none"),
        ({"web_width": (0.33, 0.27)}, 5, 0, "web_width: given the range 0.33 to 0.27"),
        ({"web_width": (0.27, math.inf)}, 5, 0, "web_width: given inf"),
        (BOX, 0, 0, "runs: given 0"),
        (BOX, 2.5, 0, "runs: given 2.5"),
        (BOX, 5, -1, "seed: given -1"),
        (BOX, 5, None, "seed: given None"),
        (BOX, 10**7, 0, "runs: given 10000000"),
    ],
)
def test_unusable_hypercubes(ranges, runs, seed, match):
    with pytest.raises(InputError, match=match):
        latin_hypercube(ranges, runs, seed)
