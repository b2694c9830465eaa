"""Slopes of random throws over all dimensions: their sums, and some against other meshes.

Run by hand: ``python tests/campaigns/slopes.py [COUNT] [FIRST SEED] [ACCURACY] [MESHES]``; with ``remeshed
ACCURACY DIFFERENCED SEED ...`` all slopes of these throws are compared with differences between meshes for
the second accuracy. The figures are in docs/accuracy.md. A throw of f times the size has 1/f of the axial,
1/f^3 of the torsional compliance and f^3 of the mass, and under the same force the same reactions and f
times their moments, so the slopes over all lengths add up to -1, -3, 3, 0 and 1: nothing in their calculation
makes them. Of a throw all of whose lengths have slopes, one is also changed by 3 to 4 % either way, so many
times with other elements, if at all.
"""

import sys
import time
from collections.abc import Sequence

import numpy as np
from random_throws import random_throw

from crankbase.errors import InputError, MeshError
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.sensitivities import sloped_answer
from fem.supports import Neighbors, Support
from geometry.boundary_motion import lengths_of, with_length
from geometry.throw import CrankThrow

NEIGHBORS = Neighbors(120.0, 120.0)
# The power of a throw's size, and what of it varies with the dimensions.
E_N: tuple[str, Support] = ("axial_compliance", "pinned")
ANSWERS: dict[tuple[str, Support], float] = {
    E_N: -1.0,
    ("axial_compliance", NEIGHBORS): -1.0,
    ("torsional_compliance", "pinned"): -3.0,
    ("influence_coefficient", "pinned"): -1.0,
    ("pin_compliance", "guided"): -1.0,
    ("right Fz", "pinned"): 0.0,
    ("right Fz", NEIGHBORS): 0.0,
    ("left Mx", "guided"): 1.0,
    ("mass", "pinned"): 3.0,
    ("inertia", "pinned"): 5.0,
}
# Shares of a dimension either way, and accuracies: each pair has meshes of its own.
STEPS, ACCURACIES = (0.03, 0.035, 0.04), (0.006, 0.005, 0.004)


def between_meshes(
    throw: CrankThrow,
    path: str,
    accuracies: Sequence[float],
    answers: Sequence[tuple[str, Support]],
) -> np.ndarray:
    """Return d ln(answer) / d ln(dimension) between throws on both sides, a row for each accuracy."""
    size = lengths_of(throw)[path]
    slopes = []
    for accuracy, step in zip(accuracies, STEPS, strict=False):
        ends = (with_length(throw, path, size * (1.0 + share)) for share in (-step, step))
        low, high = (analyze_throw(end, accuracy=accuracy) for end in ends)
        ratios = [value(high, *answer) / value(low, *answer) for answer in answers]
        slopes.append(np.log(ratios) / np.log((1.0 + step) / (1.0 - step)))
    return np.array(slopes)


def value(analysis: ThrowAnalysis, quantity: str, support: Support) -> float:
    """Return an answer of a throw."""
    if quantity in ("mass", "inertia"):
        return analysis.mass if quantity == "mass" else analysis.masses.inertia_about_shaft
    return sloped_answer(quantity, support, 0, None)(analysis.superelement)


def remeshed(accuracy: float, differenced: float, seeds: Sequence[int]) -> None:
    """Print every slope of some throws that is not within its error of differences between other meshes.

    Slopes are those of one mesh for an accuracy, differences those between three pairs of about another. What
    two standard errors of the mean difference explain is counted apart.
    """
    answers, accuracies = [*ANSWERS], [share * differenced for share in (1.2, 1.0, 0.8)]
    for seed in seeds:
        throw = random_throw(seed)
        analysis = analyze_throw(throw, accuracy=accuracy)
        slopes = [analysis.sensitivities(*answer) for answer in answers]
        compared = within = explained = 0
        for path in slopes[0].shares:
            try:
                differences = between_meshes(throw, path, accuracies, answers)
            except (InputError, MeshError):
                continue
            means = differences.mean(axis=0)
            scatter = differences.std(axis=0, ddof=1) / np.sqrt(len(differences))
            for answer, slope, mean, spread in zip(answers, slopes, means, scatter, strict=True):
                compared += 1
                apart = abs(slope[path] - mean) - slope.error
                if apart <= 0.0:
                    within += 1
                    continue
                explained += apart <= 2.0 * spread
                name = f"{answer[0]} {answer[1]}, {path}"
                print(f"  {name}: {slope[path]:+.4f} +- {slope.error:.4f}, "
                      f"{mean:+.4f} +- {spread:.4f}", flush=True)  # fmt: skip
        print(
            f"seed {seed}, {analysis.mesh.part}: {within} of {compared} slopes within, {explained} more by "
            "two standard errors", flush=True
        )  # fmt: skip


def main(count: int = 100, first: int = 1, accuracy: float = 0.01, meshes: int = 3) -> None:
    """Print the sums of each throw, one of its slopes both ways, and the worst of all."""
    off: dict[tuple[str, Support], list[float]] = {answer: [] for answer in ANSWERS}
    seed, apart, shares, left_out = first, [], [], 0
    while len(shares) < count:
        seed += 1
        try:
            throw = random_throw(seed)
            analysis = analyze_throw(throw, accuracy=accuracy)
        except (InputError, MeshError):
            continue
        start = time.process_time()
        slopes = {answer: analysis.sensitivities(*answer) for answer in ANSWERS}
        share = (time.process_time() - start) / sum(analysis.seconds.values())
        mass = slopes["mass", "pinned"]
        lengths = [path for path in mass.shares if not path.endswith("angle")]
        sizes = lengths_of(throw)
        if any(sizes[path] for path in mass.left_out):
            left_out += 1
            continue
        shares.append(share)
        for answer, power in ANSWERS.items():
            total = sum(slopes[answer][path] for path in lengths)
            off[answer].append((total - power) / max(1.0, abs(power)))
        text = ", ".join(f"{100.0 * errors[-1]:+.2f}" for errors in off.values())
        print(f"seed {seed}, {analysis.mesh.part}, {len(throw.oil_holes)} holes: {text} %; time {share:.2f}",
              flush=True)  # fmt: skip
        path = lengths[seed % len(lengths)]
        try:
            meshed = between_meshes(throw, path, ACCURACIES[:meshes], [E_N])[:, 0]
        except (InputError, MeshError):
            continue
        if meshed.size:
            slope, scatter = slopes[E_N][path], float(np.std(meshed))
            apart.append(slope - float(np.mean(meshed)))
            print(f"  {path}: {slope:+.4f}, between meshes {np.mean(meshed):+.4f} +- {scatter:.4f}",
                  flush=True)  # fmt: skip
    for (quantity, support), errors in off.items():
        print(f"{quantity} {support}: sums off by {100.0 * np.median(np.abs(errors)):.2f} % (median), "
              f"{100.0 * np.max(np.abs(errors)):.2f} % at most")  # fmt: skip
    print(
        f"{left_out} throws besides have lengths without slopes; time {np.median(shares):.2f} (median)"
    )
    if apart:
        print(f"slopes of e_n apart by {np.median(np.abs(apart)):.4f} (median), "
              f"{np.max(np.abs(apart)):.4f}")  # fmt: skip


if __name__ == "__main__":
    if sys.argv[1:2] == ["remeshed"]:
        accuracies = (float(text) for text in sys.argv[2:4])
        remeshed(*accuracies, [int(text) for text in sys.argv[4:]])
    else:
        kinds = (int, int, float, int)
        main(*(kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)))
