"""True errors of the axial compliance beside their estimates, on 60 random throws of mixed features.

Run by hand: ``python tests/campaigns/compliance_errors.py [COUNT] [STORE.json]`` (about half an hour);
its table stands in docs/accuracy.md. Throws are those of random_throws.py that can be solved as quarter
or half, from seed 1001 on. What is finished is kept in the store, and a second run goes on from there.

The reference value of a throw comes from two meshes far finer than those that are judged, one with all
elements 1.4 times smaller than in the other: the difference of their compliances, divided by how much
the error has shrunk from one to the other, is what is missing still. By how much it has shrunk is told by
the error estimates of the two, of which only the ratio is used; the size of the missing part comes
from the compliances. The three numbers at the end of the output are those that are asked for.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from random_throws import random_throw

import crankfem as cf
from crankbase.errors import InputError, MeshError
from crankbase.stopwatch import Stopwatch
from fem.accuracy import MOST_UNKNOWNS, Problem, solve_level
from fem.refinement import refined_sizes
from geometry.mesher import mesh_isolated

COUNT = 60
FIRST_SEED = 1001
ACCURACY = 0.01
# A stricter accuracy for the first throws whose reference is known well enough.
STRICT, STRICT_COUNT, WELL_KNOWN = 0.002, 10, 0.001
# Error energies that the meshes of the reference aim at, and the most unknowns of the last two.
TARGETS = (0.006, 0.0015, 0.0006)
COARSER_UNKNOWNS, FINER_UNKNOWNS, SHRINK = 90_000, 240_000, 1.4


def reference(throw):
    """e_n from finer meshes: the value, how much of it is extrapolated, and the meshes."""
    problem = Problem(cf.STEEL, "auto", "rigid", Stopwatch())
    level = solve_level(mesh_isolated(throw, 2.0), problem)
    for target in TARGETS:
        sizes = refined_sizes(level.mesh, level.errors, target)
        factor = max(1.0, (sizes.expected_unknowns() / COARSER_UNKNOWNS) ** (1.0 / 3.0))
        level = solve_level(mesh_isolated(throw, factor, "auto", sizes), problem)
    finer_factor = max(factor / SHRINK, (sizes.expected_unknowns() / FINER_UNKNOWNS) ** (1.0 / 3.0))
    finer = solve_level(mesh_isolated(throw, finer_factor, "auto", sizes), problem)
    shrunk = level.errors.relative / finer.errors.relative
    missing = (finer.axial - level.axial) / (shrunk - 1.0)
    return {
        "value": finer.axial + missing,
        "extrapolated": missing / finer.axial,
        "unknowns": [level.mesh.unknowns, finer.mesh.unknowns],
    }


def judged(throw, accuracy, truth):
    """An analysis at this accuracy against the truth."""
    begin = time.perf_counter()
    found = cf.compliance.analyze_axial(throw, accuracy=accuracy)
    return {
        "seconds": time.perf_counter() - begin,
        "unknowns": found.mesh.unknowns,
        "error": 1.0 - found.axial_compliance() / truth,
        "estimate": found.error_estimate,
    }


def described(throw):
    """Name the features of a throw in a word each."""
    words = ["filleted" if throw.filleted else "sharp"]
    words += ["bores"] * bool(throw.main_journal_bore or throw.pin_bore)
    words += ["unequal webs"] * bool(throw.left_web or throw.right_web)
    words += ["counterweights"] * bool(throw.counterweight)
    words += [f"{1 + len(throw.further_pins)} pins"] * bool(throw.further_pins)
    words += ["rectangular"] * (throw.web_outline == "rectangle")
    return ", ".join(words)


def run(count, store):
    """Solve what is missing in the store; return all rows."""
    rows = json.loads(store.read_text()) if store.exists() else {}
    seed, found, strict = FIRST_SEED - 1, 0, 0
    while found < count:
        seed += 1
        row = rows.get(str(seed), {})
        if row is None:
            continue
        row = solved(seed, row, strict < STRICT_COUNT)
        rows[str(seed)] = row
        store.write_text(json.dumps(rows))
        if row is not None:
            found += 1
            strict += "strict" in row
            print(line(row), flush=True)
    return [row for row in rows.values() if row is not None]


def solved(seed, row, strict):
    """All that is kept of one throw; None if it cannot be built or has no symmetry."""
    try:
        throw = random_throw(seed)
        if throw.symmetry == "full":
            return None
        known = row.get("reference") or reference(throw)
        truth = known["value"]
        found = {
            "seed": seed,
            "part": throw.symmetry,
            "features": described(throw),
            "reference": known,
            "usual": row.get("usual") or judged(throw, ACCURACY, truth),
        }
        if strict and known["extrapolated"] < WELL_KNOWN:
            found["strict"] = row.get("strict") or judged(throw, STRICT, truth)
    except (InputError, MeshError) as error:
        print(f"seed {seed}: {error}")
        return None
    return found


def line(row):
    found, known = row["usual"], row["reference"]
    text = (
        f"| {row['seed']} | {row['part']} | {row['features']} | {known['value'] * 1e9:.4f} "
        f"| {known['extrapolated']:.2%} | {found['unknowns']} | {found['error']:.2%} "
        f"| {found['estimate']:.2%} |"
    )
    if "strict" in row:
        text += f" {row['strict']['error']:.3%} of {row['strict']['estimate']:.3%}"
    return text


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    store = Path(sys.argv[2]) if len(sys.argv) > 2 else Path("compliance-errors.json")
    assert 1.3 * FINER_UNKNOWNS < MOST_UNKNOWNS
    rows = run(count, store)
    errors = np.array([row["usual"]["error"] for row in rows])
    estimates = np.array([row["usual"]["estimate"] for row in rows])
    ratios = estimates / errors
    print(f"{len(rows)} throws; estimate / true error: median {np.median(ratios):.2f}, "
          f"{ratios.min():.2f} to {ratios.max():.2f}")  # fmt: skip
    print(f"true error below 1.5 times the estimate: {np.sum(errors < 1.5 * estimates)}")
    print(f"estimate below 5 times the true error: {np.sum(estimates < 5.0 * errors)}")
    print(f"accuracy {ACCURACY} met by the estimate: {np.sum(estimates <= ACCURACY)}, "
          f"by the true error: {np.sum(errors <= ACCURACY)}")  # fmt: skip
    strict = [row["strict"] for row in rows if "strict" in row]
    met = sum(row["error"] <= STRICT and row["estimate"] <= STRICT for row in strict)
    print(f"accuracy {STRICT} met: {met} of {len(strict)}")


if __name__ == "__main__":
    main()
