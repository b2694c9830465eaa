"""Free modes against dense solutions of the same matrices, from each part of the throw."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh

from comparing import close
from crankbase.errors import SolveError
from fem.material import STEEL
from fem.modes import (
    ClassModes,
    PartMatrices,
    _lowest_modes,
    class_problem,
    free_modes,
    frequencies_of,
    name_of_motion,
    rigid_count,
)
from fem.solver import symmetric_product
from fem.superelement import blocked_unknowns
from fem.symmetry import SymmetryClass, symmetry_classes
from geometry.mesh import mesh_throw
from refusals import refused

# Finite elements throughout: not for the inner loop.
pytestmark = pytest.mark.slow

COUNT = 12


@pytest.fixture(scope="module")
def coarse(throw):
    """A quarter with few unknowns, for dense solutions and for the mesh of the whole throw."""
    return mesh_throw(throw, 6.0)


@pytest.fixture(scope="module")
def modes(coarse):
    return free_modes(coarse, STEEL, count=COUNT)


def full(upper):
    return upper + sparse.triu(upper, k=1).T


@pytest.mark.parametrize("held_ends", [False, True])
def test_no_mode_is_missed_or_wrong(coarse, held_ends):
    """Against LAPACK on the dense matrices of a class; both leave round-off of the largest value."""
    symmetry = symmetry_classes("quarter")[1]
    matrices = PartMatrices.of_mesh(coarse, STEEL)
    free = np.flatnonzero(~blocked_unknowns(coarse, symmetry, ends=held_ends).ravel())
    dense = [full(each)[free][:, free].toarray() for each in (matrices.stiffness, matrices.mass)]
    expected = eigh(*dense, eigvals_only=True, subset_by_index=[0, 19])
    shift = 0.0 if held_ends else 1e7
    with class_problem(coarse, matrices, symmetry, shift=shift, held_ends=held_ends) as problem:
        found = problem.lowest(20)
        ceiling = float(frequencies_of(expected[12])) * 1.0001
        below = problem.up_to(ceiling)
    largest = 1e4 * expected[-1]
    assert found.squares == close(expected, rel=1e-9, abs=1e-13 * largest)
    assert np.count_nonzero(below.frequencies <= ceiling) == 13
    assert below.frequencies[-1] > ceiling
    assert found.residuals.max() < 1e-9
    modal = found.shapes.reshape(-1, 20)
    products = symmetry.copies * modal.T @ symmetric_product(matrices.mass, modal)
    assert products == close(np.eye(20), abs=1e-8)


def test_six_rigid_motions(modes):
    assert modes.rigid_frequencies.shape == (6,)
    assert modes.rigid_frequencies.max() < 1e-4 * modes.frequencies[0]
    assert modes.frequencies[0] > 100.0
    assert np.all(np.diff(modes.frequencies) > 0.0)
    assert sum(rigid_count(symmetry) for symmetry in symmetry_classes("half")) == 6
    assert [rigid_count(symmetry) for symmetry in symmetry_classes("quarter")] == [1, 2, 2, 1]


def test_frequencies_scale_with_the_material(coarse, modes):
    """By sqrt(E / rho), Poisson's ratio unchanged."""
    other = STEEL.model_copy(update={"youngs_modulus": 7e10, "density": 2700.0})
    found = free_modes(coarse, other, count=3)
    factor = np.sqrt(7e10 / 2.1e11 * 7850.0 / 2700.0)
    assert found.frequencies == close(factor * modes.frequencies[:3], rel=1e-9)


def test_another_solver_gives_the_same(coarse, modes):
    found = free_modes(coarse, STEEL, count=4, solver="superlu")
    assert found.solver == "superlu"
    assert found.frequencies == close(modes.frequencies[:4], rel=1e-9)


def test_name_of_motion():
    twist = np.zeros(12)
    twist[[5, 11]] = -1.0, 1.0
    assert name_of_motion(twist, 0.4) == "torsion across the crank plane, antisymmetric"
    stretch = np.zeros(12)
    stretch[[2, 8]] = -1.0, 1.0
    assert name_of_motion(stretch, 0.4) == "axial in the crank plane, symmetric"
    # Half of the length is what a rotation counts: 5 rad x 0.2 m against 1 m.
    both = stretch.copy()
    both[[3, 9]] = 5.0, -5.0
    assert name_of_motion(0.99 * stretch + 0.01 * both, 0.4).startswith("axial in")
    assert name_of_motion(both + 0.1 * stretch, 0.4).startswith("axial with bending in")
    assert name_of_motion(both - 0.1 * stretch, 0.4).startswith("bending with axial in")
    # One end alone has neither symmetry about the middle; in and across the plane at once, no plane.
    one = np.zeros(12)
    one[[0, 1]] = 1.0
    assert name_of_motion(one, 0.4) == "bending"
    assert name_of_motion(np.zeros(12), 0.4) == "end sections at rest"


def test_enough_of_each_class_is_sought():
    """All wanted modes in one class, or spread unevenly: the lowest of all are always among them."""
    symmetries = symmetry_classes("quarter")
    rng = np.random.default_rng(4)
    for count in (1, 5, 17):
        ladders = {each: np.sort(rng.uniform(1.0, 9.0, 60)) for each in symmetries}
        ladders[symmetries[2]] = ladders[symmetries[2]] * 1e-3
        asked = []

        def solve(symmetry, elastic, ladders=ladders, asked=asked):
            asked.append(elastic)
            squares = np.concatenate([np.zeros(rigid_count(symmetry)), ladders[symmetry][:elastic]])
            return ClassModes(symmetry, squares, np.zeros((1, 3, len(squares))), squares, "")

        found = _lowest_modes(solve, symmetries, count)
        elastic = np.sort(np.concatenate([m.squares[rigid_count(m.symmetry) :] for m in found]))
        expected = np.sort(np.concatenate(list(ladders.values())))
        assert np.array_equal(elastic[:count], expected[:count])
        assert max(asked) <= count


def test_a_mesh_in_two_pieces_is_refused(coarse):
    """Its modes come in pairs of the same frequency, which Lanczos' method alone would not see."""
    pieces = replace(
        coarse,
        points=np.vstack([coarse.points, coarse.points + np.array([0.0, 1.0, 0.0])]),
        elements=np.vstack([coarse.elements, coarse.elements + len(coarse.points)]),
    )
    with pytest.raises(SolveError, match="has 12 motions without stiffness instead of six"):
        free_modes(pieces, STEEL, count=8)
    matrices = PartMatrices.of_mesh(pieces, STEEL)
    with class_problem(pieces, matrices, SymmetryClass(-1, 1), held_ends=True) as problem:
        squares = problem.lowest(6).squares
    assert squares[::2] == close(squares[1::2], rel=1e-9)
    assert np.all(np.diff(squares[::2]) > 0.1 * squares[0])


def test_a_mode_that_misses_its_equation_is_refused(coarse, monkeypatch):
    monkeypatch.setattr("fem.modes.LARGEST_RESIDUAL", 1e-15)
    with pytest.raises(SolveError, match=r"leaves a relative residual of .* \(allowed 1e-15\):"):
        free_modes(coarse, STEEL, count=1)


@pytest.mark.parametrize(
    ("wish", "field"),
    [
        ({}, "count, highest_frequency"),
        ({"count": 3, "highest_frequency": 1e3}, "count, highest_frequency"),
        ({"count": 0}, "count"),
        ({"count": 501}, "count"),
        ({"count": 2.5}, "count"),
        ({"count": True}, "count"),
        ({"highest_frequency": 0.0}, "highest_frequency"),
        ({"highest_frequency": np.inf}, "highest_frequency"),
        ({"highest_frequency": np.nan}, "highest_frequency"),
    ],
)
def test_wishes_that_make_no_sense(coarse, wish, field):
    with refused(field):
        free_modes(coarse, STEEL, **wish)


def test_more_modes_than_the_mesh_can_show(coarse, monkeypatch):
    monkeypatch.setattr("fem.modes.MOST_MODES", 4)
    matrices = PartMatrices.of_mesh(coarse, STEEL)
    with class_problem(coarse, matrices, SymmetryClass(1, 1), shift=1e7) as problem:
        assert problem.most_modes == 10
        with refused("count"):
            problem.lowest(11)
        with refused("highest_frequency"):
            problem.up_to(1e6)


def test_highest_frequency_gives_the_same(coarse, modes):
    ceiling = 0.5 * (modes.frequencies[6] + modes.frequencies[7])
    found = free_modes(coarse, STEEL, highest_frequency=float(ceiling))
    assert found.frequencies == close(modes.frequencies[:7], rel=1e-9)
    assert found.symmetries == modes.symmetries[:7]
    below_all = free_modes(coarse, STEEL, highest_frequency=1.0)
    assert below_all.shapes.shape == (len(coarse.points), 3, 0)
    assert below_all.names == ()
