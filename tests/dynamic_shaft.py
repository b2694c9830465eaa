"""A row of throws as dynamic superelements, and natural modes of the whole shaft: a reference for tests."""

import numpy as np
from scipy.linalg import eigh

from fem.modes import frequencies_of


def assemble_dynamic_shaft(throws):
    """Stiffness and mass (u, u) of throws in a row, each already turned to its crank angle.

    Unknowns are the motions of the n + 1 end sections from the left, as in `fem.superelement.assemble_shaft`,
    then the amplitudes of shapes, throw by throw.
    """
    first = 6 * (len(throws) + 1)
    size = first + sum(len(throw.frequencies) for throw in throws)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for place, throw in enumerate(throws):
        last = first + len(throw.frequencies)
        own = np.r_[6 * place : 6 * place + 12, first:last]
        stiffness[np.ix_(own, own)] += throw.stiffness
        mass[np.ix_(own, own)] += throw.mass
        first = last
    return stiffness, mass


def natural_modes(stiffness, mass, held=()):
    """Frequencies (k,), ascending [Hz], and shapes (u, k) of unit modal mass; `held` stays at zero."""
    free = np.setdiff1d(np.arange(len(stiffness)), np.asarray(held, dtype=int))
    squares, vectors = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
    shapes = np.zeros((len(stiffness), len(free)))
    shapes[free] = vectors
    return frequencies_of(squares), shapes
