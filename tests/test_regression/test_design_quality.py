"""Distance, discrepancy and correlation of designs, in closed form."""

import itertools

import numpy as np
import pytest

from comparing import close
from regression.plans.designs_space import design_quality
from regression.plans.factors import Factor

A, B = Factor("a", "m", 1.0, 3.0), Factor("b", "m", 0.1, 0.2)
TWO, THREE = Factor.of_labels("two", ("x", "y")), Factor.of_labels("three", ("x", "y", "z"))


def test_corners_of_a_square():
    corners = np.array(list(itertools.product((1.0, 3.0), (0.1, 0.2))))
    found = design_quality((A, B), corners)
    assert found.distance == close(1.0)
    assert (found.correlation, found.correlated) == (0.0, ())
    # Centered discrepancy by its definition: corners have |x - 1/2| = 1/2 in both directions, and of the
    # 16 pairs 4 share both coordinates, 8 one, 4 none.
    shared = (1 + 0.25 + 0.25 - 0.0) ** 2, (1 + 0.5) * (1 + 0.5 - 0.5), 1.0
    expected = (13 / 12) ** 2 - 2 / 4 * 4 * (1 + 0.25 - 0.125) ** 2
    expected += (4 * shared[0] + 8 * shared[1] + 4 * shared[2]) / 16
    assert found.discrepancy == close(expected)


def test_random_points_have_the_mean_discrepancy_told():
    """Mean over 400 sets of 20 points; its own standard error is some 2 %."""
    rng = np.random.default_rng(1)
    sets = [design_quality((A, B), _in_box(rng.random((20, 2)))) for _ in range(400)]
    mean = np.mean([found.discrepancy for found in sets])
    assert mean == close(sets[0].random_discrepancy, rel=0.06)


def _in_box(points):
    return np.array([1.0, 0.1]) + points * np.array([2.0, 0.1])


def test_correlation_names_its_factors():
    rng = np.random.default_rng(2)
    points = _in_box(rng.random((30, 2)))
    labels = np.arange(30) % 3
    values = np.column_stack([points, points[:, 0] > 2.0, labels])
    found = design_quality((A, B, TWO, THREE), values)
    assert found.correlated == ("a", "two")
    assert found.correlation == close(abs(np.corrcoef(values[:, 0], values[:, 2])[0, 1]))


def test_labels_of_a_choice_are_their_share_of_the_cube_apart():
    values = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
    assert design_quality((A, THREE), values).distance == close(1 / 3)


def test_a_single_run():
    found = design_quality((A, B), np.array([[2.0, 0.15]]))
    assert (found.distance, found.correlation, found.correlated) == (None, None, ())


@pytest.mark.parametrize("count", [2, 40])
def test_a_hidden_line_is_told(count):
    line = np.linspace(0.0, 1.0, count)
    found = design_quality((A, B), _in_box(np.column_stack([line, 1.0 - line])))
    assert found.correlation == close(1.0)
    assert found.correlated == ("a", "b")
