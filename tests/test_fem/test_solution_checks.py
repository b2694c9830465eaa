"""Every check of a solved throw, by breaking what it looks at: each is an error with its figure.

A sound throw leaves 1e-12; what is broken here is broken by a share of 1e-4 or more.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from crankbase.errors import SolveError
from crankbase.stopwatch import Stopwatch
from fem import analysis
from fem.analysis import Problem, solve_level
from fem.assembly import assemble_stiffness
from fem.loads import RADIAL, pin_surfaces, unit_pin_loads
from fem.material import STEEL
from fem.solver import (
    Factorization,
    asymmetry,
    rigid_body_residual,
    strain_energies,
    unbalanced_pin_loads,
)
from fem.superelement import checked_superelement, combine_classes
from fem.symmetry import symmetry_classes


def solved(mesh, degree=2):
    """The superelement of a mesh, as a run makes it."""
    problem = Problem(STEEL, "auto", "rigid", Stopwatch(), degree)
    classes = solve_level(mesh, problem).condense(symmetry_classes(mesh.part), problem)
    return checked_superelement(classes, RADIAL[None], mesh)


def test_a_sound_throw_leaves_round_off(classes, mesh):
    found = combine_classes(classes)
    energies = strain_energies(found.stiffness, mesh.length)
    centers = [pin.center for pin in pin_surfaces(mesh)]
    assert asymmetry(found.stiffness, mesh.length) < 1e-11
    assert rigid_body_residual(found.stiffness, mesh.length) < 1e-11
    assert np.max(np.abs(energies[:6])) < 1e-11
    assert energies[6] > 1e-3
    assert unbalanced_pin_loads(found.pin_loads, mesh.length, centers) < 1e-11


def test_an_inaccurate_solution(mesh, monkeypatch):
    solve, random = Factorization.solve, np.random.default_rng(5)

    def poorly(self, right_sides):
        solution = solve(self, right_sides)
        return solution * (1.0 + 1e-4 * random.standard_normal(solution.shape))

    monkeypatch.setattr(Factorization, "solve", poorly)
    with pytest.raises(SolveError, match=r"Reciprocity .* off by \d\.\de-0\d \(allowed 1e-06\)"):
        solved(mesh)


def test_a_stiffness_that_holds_the_throw_in_space(mesh, monkeypatch):
    def grounded(points, elements, material):
        found = assemble_stiffness(points, elements, material)
        spring = 1e-4 * found.diagonal().max() * (np.arange(found.shape[0]) == 3 * len(points) // 2)
        return (found + sparse.diags_array(spring)).tocsr()

    monkeypatch.setattr(analysis, "assemble_stiffness", grounded)
    with pytest.raises(SolveError, match="Rigid motions of the throw meet forces of"):
        solved(mesh)


def test_a_web_without_stiffness(mesh, monkeypatch):
    def soft(points, elements, material):
        cut = np.abs(points[elements[:, 0], 2] / mesh.length - 0.3) < 0.08
        left, right = (assemble_stiffness(points, elements[own], material) for own in (cut, ~cut))
        return (1e-10 * left + right).tocsr()

    monkeypatch.setattr(analysis, "assemble_stiffness", soft)
    with pytest.raises(SolveError, match="stiffness is not positive definite"):
        solved(mesh)


def test_a_load_of_which_a_node_is_lost(mesh, monkeypatch):
    def dropped(given):
        (load,) = unit_pin_loads(given)
        values = load.values.copy()
        values[:, 0] = 0.0
        return (replace(load, values=values),)

    monkeypatch.setattr(analysis, "unit_pin_loads", dropped)
    with pytest.raises(SolveError, match="leave an unbalanced share of a pin's load of"):
        solved(mesh)


def test_numbers_that_are_none(classes, mesh):
    first, *rest = classes
    spoiled = replace(first, stiffness=np.full_like(first.stiffness, np.nan))
    with pytest.raises(SolveError, match="unsymmetric by nan"):
        checked_superelement([spoiled, *rest], RADIAL[None], mesh)
