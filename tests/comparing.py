"""Comparison of numbers, however small they are."""

import numpy as np
import pytest


def close(expected, rel=None, abs=None, nan_ok=False):  # noqa: A002 - as pytest calls it
    """Return what equals numbers that differ from `expected` by no more than is said: by 1e-6 of it.

    pytest's own comparison takes differences below 1e-12 for none, whatever `rel` says: compliances are
    near 1e-9 m/N, and errors of 0.1 % of theirs would pass.

    Parameters
    ----------
    expected : number, sequence, mapping or array
    rel : float, optional
        Deviation allowed, in parts of `expected`.
    abs : float, optional
        Deviation allowed, in the unit of `expected`. Alone, it is the only one; beside `rel`, the larger
        of the two holds.
    nan_ok : bool
        Whether two values that are no numbers are alike.
    """
    if abs is None:
        rel, abs = 1e-6 if rel is None else rel, 0.0  # noqa: A001
    return pytest.approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)  # noqa: TID251


def same_mesh(first, second):
    """Tell whether two meshes have the same points, elements and surfaces."""
    return (
        np.array_equal(first.points, second.points)
        and np.array_equal(first.elements, second.elements)
        and first.surfaces.keys() == second.surfaces.keys()
        and all(
            np.array_equal(first.surfaces[name], second.surfaces[name]) for name in first.surfaces
        )
    )
