"""The worst point, speed and case of firing of a fillet or oil hole, by a bound of the criterion first."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankfem.analyses.strength.cycle_loads import CycleLoads
from crankfem.analyses.vibration.firing_check import Cylinders
from dynamics.strength.findley import CriticalPlane, critical_plane, findley_bound
from fem.stress_fields import StressedSite

# Speeds at which nodes are chosen first, how many are followed over all speeds, and how far these are apart
# beside the radius of the fillet or hole.
FIRST_SPEEDS, FOLLOWED, APART = 5, 16, 0.5
# Every so many samples of the cycle are enough to choose nodes, and speeds.
SPARSER, SPARSE = 6, 3
# Highest speeds of each case that are looked at closely, and nodes there: apart, then near the worst.
CLOSELY, NODES = 3, 6


@dataclass(frozen=True)
class Candidate:
    """A speed and case of firing of a site that may be decisive: upper bound of its points, and its loads."""

    bound: float
    speed: float
    cylinders: Cylinders
    angles: FloatArray
    amplitudes: FloatArray  # (m, 12)


def _history(site: StressedSite, nodes: NDArray[np.int64], amplitudes: FloatArray) -> FloatArray:
    """Stresses (nodes, ..., m, 3) of amplitudes (..., m, 12)."""
    stress = site.stress[nodes]
    flat = amplitudes.reshape(-1, amplitudes.shape[-1]) @ np.moveaxis(stress, 1, 0).reshape(
        amplitudes.shape[-1], -1
    )
    return np.moveaxis(flat.reshape(*amplitudes.shape[:-1], len(stress), 3), -2, 0)


def _apart(site: StressedSite, values: FloatArray) -> Iterator[int]:
    """Return nodes of a site with the largest values first, none next to one that came before."""
    left = values.copy()
    while np.any(left > 0.0):
        node = int(np.argmax(left))
        yield node
        distance = np.linalg.norm(site.points - site.points[node], axis=1)
        left[distance < APART * site.radius] = 0.0


def find_candidates(
    site: StressedSite, loads: CycleLoads, throw: int, amplitudes: FloatArray, factor: float
) -> Iterator[Candidate]:
    """Return the speeds at which the bound of a site is highest among its neighbors."""
    count = len(loads.speeds)
    first = np.unique(np.linspace(0, count - 1, FIRST_SPEEDS).astype(int))
    twisting = np.ptp(loads.ends[throw, ..., 11], axis=1).argmax()
    every = np.arange(len(site.points))
    reached = np.zeros(len(every))
    for speed in [*first, twisting]:
        history = _history(site, every, amplitudes[speed, ::SPARSER])
        reached = np.maximum(reached, findley_bound(history, factor))
    nodes = np.array(list(islice(_apart(site, reached), FOLLOWED)))
    history = _history(site, nodes, amplitudes[:, ::SPARSE])
    bounds = findley_bound(history, factor).max(axis=0)
    padded = np.concatenate(([-np.inf], bounds, [-np.inf]))
    tops = np.flatnonzero((bounds >= padded[:-2]) & (bounds >= padded[2:]))
    for top in tops[np.argsort(bounds[tops])[::-1][:CLOSELY]]:
        speed = float(loads.speeds[top])
        yield Candidate(
            float(bounds[top]), speed, loads.cylinders, loads.angles, amplitudes[top].copy()
        )


def worst_point(
    site: StressedSite, candidates: Sequence[Candidate], factor: float
) -> tuple[CriticalPlane, int, Candidate]:
    """Return the critical plane of the worst of a site's nodes, its index, and the loads at that time."""
    best: CriticalPlane | None = None
    where = (0, candidates[0])
    for one in sorted(candidates, key=lambda own: -own.bound):
        if best is not None and one.bound <= best.value:
            break
        history = _history(site, np.arange(len(site.points)), one.amplitudes)
        bounds = findley_bound(history, factor)
        near = np.zeros(len(bounds), dtype=bool)
        for nodes in (islice(_apart(site, bounds), NODES), None):
            if nodes is None:
                # Round the worst of these, if it is of this candidate.
                distance = np.linalg.norm(site.points - site.points[where[0]], axis=1)
                near = (distance < APART * site.radius) & (where[1] is one)
                nodes = iter(np.argsort(np.where(near, bounds, 0.0))[::-1][:NODES].tolist())
            for node in nodes:
                if best is not None and bounds[node] <= best.value:
                    break
                found = critical_plane(history[node], factor)
                if best is None or found.value > best.value:
                    best, where = found, (node, one)
    assert best is not None
    return best, *where
