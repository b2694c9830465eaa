"""Slopes of random throws over all dimensions: their sums, and some against other meshes.

Run by hand: ``python tests/campaigns/slopes.py [COUNT] [FIRST SEED]``; its figures are in docs/accuracy.md.
A throw of f times the size has 1/f of the axial, 1/f^3 of the torsional compliance and f^3 of the mass, so
the slopes over all lengths add up to -1, -3 and 3: nothing in their calculation makes them. Of each throw
one dimension is also changed by 3 % either way, thrice with other elements.
"""

import sys
import time

import numpy as np
from random_throws import random_throw

from crankbase.errors import InputError, MeshError
from fem.analysis import analyze_throw
from geometry.boundary_motion import lengths_of, with_length
from geometry.throw import CrankThrow

QUANTITIES = {"axial_compliance": -1.0, "torsional_compliance": -3.0, "mass": 3.0}
STEP, ACCURACIES = 0.03, (0.006, 0.005, 0.004)


def between_meshes(throw: CrankThrow, path: str) -> list[float]:
    """Return d ln(e_n) / d ln(dimension) between meshes of throws on both sides, for each accuracy."""
    size = lengths_of(throw)[path]
    ends = [with_length(throw, path, size * (1.0 + step)) for step in (-STEP, STEP)]
    slopes = []
    for accuracy in ACCURACIES:
        low, high = (analyze_throw(end, accuracy=accuracy).axial_compliance() for end in ends)
        slopes.append(float(np.log(high / low) / np.log((1.0 + STEP) / (1.0 - STEP))))
    return slopes


def main(count: int = 100, first: int = 1) -> None:
    """Print the sums of each throw, one of its slopes both ways, and the worst of all."""
    off: dict[str, list[float]] = {quantity: [] for quantity in QUANTITIES}
    seed, apart = first, []
    while len(off["mass"]) < count:
        seed += 1
        try:
            throw = random_throw(seed)
            analysis = analyze_throw(throw)
        except (InputError, MeshError):
            continue
        start = time.process_time()
        slopes = {quantity: analysis.sensitivities(quantity) for quantity in QUANTITIES}
        share = (time.process_time() - start) / sum(analysis.seconds.values())
        lengths = [path for path in slopes["mass"].shares if not path.endswith("angle")]
        for quantity, power in QUANTITIES.items():
            total = sum(slopes[quantity][path] for path in lengths)
            off[quantity].append(total / power - 1.0)
        text = ", ".join(f"{name} {100.0 * errors[-1]:+.2f} %" for name, errors in off.items())
        print(
            f"seed {seed}, {analysis.mesh.part}: {text}; time {share:.2f} of the analysis",
            flush=True,
        )
        path = lengths[seed % len(lengths)]
        try:
            meshed = between_meshes(throw, path)
        except (InputError, MeshError):
            continue
        slope, scatter = slopes["axial_compliance"][path], float(np.std(meshed))
        apart.append(slope - float(np.mean(meshed)))
        print(
            f"  {path}: {slope:+.4f}, between meshes {np.mean(meshed):+.4f} +- {scatter:.4f}",
            flush=True,
        )
    for quantity, errors in off.items():
        print(f"{quantity}: sums off by {100.0 * np.median(np.abs(errors)):.2f} % (median), "
              f"{100.0 * np.max(np.abs(errors)):.2f} % at most")  # fmt: skip
    print(
        f"slopes of e_n apart by {np.median(np.abs(apart)):.4f} (median), {np.max(np.abs(apart)):.4f}"
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
