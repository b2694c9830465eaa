"""What corrected answers are short of, and their error bars, on 120 random throws of mixed features.

Run by hand: ``python tests/campaigns/corrected_answers.py FOLDER [COUNT]`` (about 40 minutes of one core for
120 throws); its tables stand in docs/accuracy.md. Throws are those of random_throws.py from seed 2001 on,
of whole ones every third. What is finished is kept in the folder, and a second run goes on from there.

Each throw is analyzed to several accuracies, and on a mesh with more than four times the unknowns of the
finest of these, whose corrected answers are the reference. On every second throw the effectivity of the
estimated errors is fitted, on the others answers and bars are judged.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from random_throws import random_throw
from scipy.optimize import least_squares

import crankfem as cf
from crankbase.errors import InputError, MeshError
from fem.analysis import Problem, refined_sizes, solve_level, solve_to_accuracy, stiffness_errors
from fem.correction import EFFECTIVITY, error_bars
from fem.solver import Stopwatch
from fem.superelement import Superelement, combine_classes
from fem.supports import support_throw
from fem.symmetry import radial_directions, symmetry_classes
from geometry.mesher import mesh_isolated

COUNT, FIRST_SEED = 120, 2001
# The judged answers; the finest is left out where it would take more unknowns than these.
ACCURACIES, MOST_JUDGED = (0.04, 0.01, 0.004), 60_000
REFERENCE_UNKNOWNS = 4.6
QUANTITIES = tuple(
    f"{name}, {support}"
    for support in ("pinned", "guided")
    for name in ("axial", "torsional", "influence coefficient")
)


# What is computed of a throw.


def described(throw):
    """Name the features of a throw in a word each."""
    words = ["filleted" if throw.filleted else "sharp"]
    words += ["bores"] * bool(throw.main_journal_bore or throw.pin_bore)
    words += ["unequal webs"] * bool(throw.left_web or throw.right_web)
    words += ["counterweights"] * bool(throw.counterweight)
    words += [f"{1 + len(throw.further_pins)} pins"] * bool(throw.further_pins)
    words += ["rectangular"] * (throw.web_outline == "rectangle")
    return ", ".join(words)


def described_level(level, problem, radials):
    """The superelement of the mesh, and what correction adds to it at an effectivity of one."""
    begin = time.process_time()
    classes = level.condense(symmetry_classes(level.mesh.part), problem)
    corrected = combine_classes(classes, radials)
    plain = combine_classes([one.discrete or one for one in classes], radials)
    names = ("stiffness", "pin_loads", "pin_flexibility")
    return {
        "unknowns": level.mesh.unknowns,
        "mended": level.mesh.mended_elements,
        "share": level.errors.relative,
        "corrected": all(one.discrete is not None for one in classes),
        "seconds": time.process_time() - begin,
        "plain": {name: getattr(plain, name).tolist() for name in names},
        "added": {
            name: ((getattr(corrected, name) - getattr(plain, name)) / level.effectivity).tolist()
            for name in names
        },
    }


def solved(throw):
    """Answers at all accuracies, and the reference."""
    problem = Problem(cf.STEEL, "auto", "rigid", Stopwatch())
    radials = radial_directions(throw)
    levels = []
    for accuracy in ACCURACIES:
        level = solve_to_accuracy(throw, accuracy, problem)
        if levels and level.mesh.unknowns > MOST_JUDGED:
            break
        finest = level
        levels.append(
            {"accuracy": accuracy, "met": level.meets(accuracy)}
            | described_level(level, problem, radials)
        )
        level.solver.close()
    most = max(one["unknowns"] for one in levels)
    sizes = refined_sizes(finest.mesh, finest.errors, 0.0015)
    factor = (sizes.expected_unknowns() / (REFERENCE_UNKNOWNS * most)) ** (1.0 / 3.0)
    level = solve_level(mesh_isolated(throw, factor, "auto", sizes), problem)
    reference = described_level(level, problem, radials)
    level.solver.close()
    return {"levels": levels, "reference": reference}


def compute(folder, count):
    """Solve throws until the folder has so many."""
    seed, done = FIRST_SEED, 0
    while done < count:
        path = folder / f"{seed}.json"
        try:
            throw = random_throw(seed)
            if throw.symmetry != "full" or seed % 3 == 0:
                if not path.exists():
                    begin = time.process_time()
                    found = {
                        "seed": seed,
                        "features": described(throw),
                        "part": throw.symmetry,
                        "filleted": throw.filleted,
                        "radials": radial_directions(throw).tolist(),
                    } | solved(throw)
                    partial = path.with_suffix(".partial")
                    partial.write_text(json.dumps(found))
                    partial.rename(path)
                    levels = [*found["levels"], found["reference"]]
                    unknowns = [level["unknowns"] for level in levels]
                    shares = [f"{level['share']:.2%}" for level in levels]
                    seconds = time.process_time() - begin
                    print(seed, throw.symmetry, found["features"], unknowns, shares,
                          f"{seconds:.0f} s", flush=True)  # fmt: skip
                done += 1
        except (InputError, MeshError) as error:
            print(f"{seed}: {error}", flush=True)
        seed += 1


# What is made of it.


def answers(found, level, effectivity):
    """The answers of `QUANTITIES` and the superelement, at an effectivity."""
    parts = {
        name: np.array(plain) + effectivity * np.array(level["added"][name])
        for name, plain in level["plain"].items()
    }
    element = Superelement(radials=np.array(found["radials"]), **parts)
    values = []
    for support in ("pinned", "guided"):
        one = support_throw(element, support)
        values += [one.axial, one.torsional, one.influences[0]]
    return np.array(values), element


def effectivity_of(numbers, share):
    return max(1.0, numbers[0] - numbers[1] * share)


def fitted(throws):
    """Effectivity on the finest meshes and its fall, by the errors beside what was corrected."""

    def residuals(numbers):
        rest = []
        for found in throws:
            reference = found["reference"]
            truth, _ = answers(found, reference, effectivity_of(numbers, reference["share"]))
            for level in found["levels"]:
                plain, _ = answers(found, level, 0.0)
                share = level["share"]
                values, _ = answers(found, level, effectivity_of(numbers, share))
                rest += list((values / truth - 1.0) / (np.abs(1.0 - plain / values) + 0.1 * share))
        return np.array(rest)

    return least_squares(residuals, (1.25, 1.0), loss="soft_l1", f_scale=0.1).x


def judged(throws):
    """True errors and bars of all answers, and the share of stiffness entries within their bars."""
    rows, entries = [], []
    for found in throws:
        numbers = EFFECTIVITY[found["filleted"]]
        reference = found["reference"]
        truth, true = answers(found, reference, effectivity_of(numbers, reference["share"]))
        for level in found["levels"]:
            plain, discrete = answers(found, level, 0.0)
            values, corrected = answers(found, level, effectivity_of(numbers, level["share"]))
            coarse = 1.0 - plain[0] / values[0]
            bars = error_bars(values, plain, coarse) / np.abs(values)
            errors = np.abs(truth / values - 1.0)
            about = (found["filleted"], level["accuracy"], level["met"])
            rows += [(number, *about, errors[number], bars[number]) for number in range(len(bars))]
            bars = stiffness_errors(corrected, discrete)
            off = np.abs(true.stiffness - corrected.stiffness)
            entries.append(np.mean((off < bars)[bars > 0.0]))
    return np.array(rows), float(np.mean(entries))


def tell(throws):
    """Print the fit on one half, and the tables of the other."""
    for filleted in (True, False):
        half = [found for found in throws[::2] if found["filleted"] == filleted]
        print(f"filleted {filleted}: effectivity on {len(half)} throws {fitted(half).round(2)}")
    held_out = throws[1::2]
    rows, entries = judged(held_out)
    number, filleted, accuracy, met, errors, bars = rows.T
    within, narrow = errors < bars, bars < 10.0 * errors
    print(f"\n{len(held_out)} throws held out, {len(rows)} answers; entries of the stiffness within "
          f"their bars: {entries:.1%}\n")  # fmt: skip
    print(
        "| quantity | true error within the bar | bar at most ten times the true error | 95 % error |"
    )
    print("|---|---|---|---|")
    for which, name in [(None, "all"), *enumerate(QUANTITIES)]:
        at = np.full(len(rows), True) if which is None else number == which
        shares = f"{within[at].mean():.1%} | {narrow[at].mean():.1%}"
        print(f"| {name} | {shares} | {np.quantile(errors[at], 0.95):.2%} |")
    print(
        "\n| e_n pinned | asked | met | median error | 95 % error | largest |\n|---|---|---|---|---|---|"
    )
    for kind, name in ((1, "fillets"), (0, "sharp corners")):
        for asked in ACCURACIES:
            at = (number == 0) & (filleted == kind) & (accuracy == asked)
            if at.any():
                middle, most = np.quantile(errors[at], (0.5, 0.95))
                print(f"| {name} | {asked:.1%} | {int(met[at].sum())} of {int(at.sum())} | {middle:.2%} "
                      f"| {most:.2%} | {errors[at].max():.2%} |")  # fmt: skip


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    count = int(sys.argv[2]) if len(sys.argv) > 2 else COUNT
    compute(folder, count)
    tell([json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))[:count]])
