"""Findley's criterion: closed forms of proportional stress, invariance, and all planes by brute force."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.strength.fatigue import (
    critical_plane,
    enclosing_radius,
    findley_bound,
    findley_factor,
    findley_limit,
)

K = findley_factor()
CYCLE = np.linspace(0.0, 2.0 * np.pi, 181)[:-1]
# Planes are found to 0.2 degrees, where the criterion is flat: half the square of that angle.
FLAT = 2e-5


def stresses(first, second, between):
    return np.stack(np.broadcast_arrays(first, second, between), axis=-1)


def proportional(bending, torsion):
    wave = np.cos(CYCLE)
    return stresses(bending * wave, 0.0 * wave, torsion * wave)


def test_both_strengths_are_one_limit():
    """k by its own equation, solved apart from the program: sin(arctan k) = 2/sqrt(3) - 1."""
    assert math.tan(math.asin(2.0 / math.sqrt(3.0) - 1.0)) == close(K)
    bending, torsion = 300e6, 300e6 / math.sqrt(3.0)
    limit = findley_limit(bending, K)
    assert critical_plane(proportional(bending, 0.0), K).value == close(limit, FLAT)
    assert critical_plane(proportional(0.0, torsion), K).value == close(limit, FLAT)


@pytest.mark.parametrize(("bending", "torsion"), [(1.0, 0.5), (0.3, 0.8), (1.0, 2.0)])
def test_proportional_bending_and_torsion(bending, torsion):
    """Fully reversed: k s/2 + sqrt(1 + k^2) sqrt(s^2/4 + t^2), the top of Mohr's circle seen aslant."""
    expected = 0.5 * K * bending + math.hypot(1.0, K) * math.hypot(0.5 * bending, torsion)
    found = critical_plane(proportional(bending, torsion), K)
    assert found.value == close(expected, FLAT)
    assert found.value == close(found.shear_amplitude + K * found.normal_stress)


def test_a_mean_stress_counts_by_its_share_on_the_plane():
    """Pulsating tension: range s, s_max = s: s/4 sin 2a + k s/2 (1 + cos 2a) at its largest."""
    history = stresses(0.5 * (1.0 + np.cos(CYCLE)), 0.0, 0.0)
    expected = 0.5 * K + math.hypot(0.25, 0.5 * K)
    assert critical_plane(history, K).value == close(expected, FLAT)


def test_shear_that_turns_has_the_radius_of_its_circle():
    """Torsion a quarter of a cycle behind tension: on the cross section tau alone, else an ellipse."""
    history = stresses(np.cos(CYCLE), 0.0, 0.5 * np.sin(CYCLE))
    found = critical_plane(history, K)
    # Across the axis: shear 0.5, normal 1. No plane is below that.
    assert found.value >= 0.5 + K - 1e-12
    assert found.value <= findley_bound(history, K)


def test_directions_in_the_surface_do_not_matter():
    rng = np.random.default_rng(5)
    history = rng.normal(size=(40, 3))
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    tensors = history[:, [[0, 2], [2, 1]]]
    turned = (turn @ tensors @ turn.T)[:, [0, 1, 0], [0, 1, 1]]
    one, other = critical_plane(history, K), critical_plane(turned, K)
    assert other.value == close(one.value, 1e-4)
    assert one.value == close(critical_plane(3.0 * history, K).value / 3.0)


def test_no_plane_among_many_is_worse():
    """Every moment on planes all over the half sphere, circles by an even search; out-of-phase history."""
    history = stresses(
        80.0 + 100.0 * np.cos(CYCLE),
        30.0 * np.cos(CYCLE + 0.3),
        70.0 * np.sin(CYCLE) + 20.0 * np.cos(3.0 * CYCLE),
    )
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(3000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    tensor = np.zeros((len(CYCLE), 3, 3))
    tensor[:, 0, 0], tensor[:, 1, 1] = history[:, 0], history[:, 1]
    tensor[:, 0, 1] = tensor[:, 1, 0] = history[:, 2]
    traction = np.einsum("mij,pj->pmi", tensor, normals)
    normal = np.einsum("pmi,pi->pm", traction, normals)
    shear = traction - normal[..., None] * normals[:, None]
    aside = np.where(np.abs(normals[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normals, first)
    flat = np.stack([np.einsum("pmi,pi->pm", shear, one) for one in (first, second)], axis=-1)
    brute = enclosing_radius(flat) + K * normal.max(axis=1)
    found = critical_plane(history, K)
    assert found.value >= brute.max() * (1.0 - FLAT)
    assert found.value == close(brute.max(), 0.01)  # 3000 planes are 3.7 degrees apart
    assert found.value <= findley_bound(history, K)


def test_smallest_circles():
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5 * math.sqrt(3.0)], [0.5, 0.3]])
    flat = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, -1.9]])
    assert enclosing_radius([triangle, flat]) == close([1.0 / math.sqrt(3.0), 2.0])
    assert enclosing_radius(np.ones((1, 5, 2))) == close([0.0], abs=1e-15)
    points = np.random.default_rng(1).normal(size=(20, 30, 2))
    radii = enclosing_radius(points)
    # No circle about any place of a fine grid is smaller, and that of the best place hardly larger.
    grid = np.stack(np.meshgrid(*[np.linspace(-1.6, 1.6, 129)] * 2), axis=-1).reshape(-1, 2)
    best = np.linalg.norm(points[:, None] - grid[:, None], axis=-1).max(axis=2).min(axis=1)
    assert np.all(radii <= best + 1e-12)
    assert np.all(best - radii < 0.025)


def test_nothing_acts():
    found = critical_plane(np.zeros((4, 3)), K)
    assert (found.value, found.shear_amplitude) == (0.0, 0.0)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_strengths_that_no_factor_fits_are_refused(share):
    with pytest.raises(InputError, match=f"torsion_share: given {share:g}; allowed is above 0.5"):
        findley_factor(share)


def test_histories_have_three_stresses():
    with pytest.raises(InputError, match=r"history: given an array of shape \(4, 2\)"):
        critical_plane(np.zeros((4, 2)), K)


def test_a_path_repeated_thousands_of_times_is_that_path():
    """In line, so that it has two corners."""
    angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    once = np.outer(np.cos(angles), [0.0, 0.0, 1.7e8])
    found, wanted = (critical_plane(path, 0.16) for path in (np.resize(once, (100_000, 3)), once))
    assert (found.value, found.moment) == (wanted.value, wanted.moment)
