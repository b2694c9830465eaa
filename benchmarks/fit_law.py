"""Fit the law's networks to the computed throws: ``python benchmarks/fit_law.py FOLDER [--tier plain]``.

Levenberg and Marquardt's steps on the networks' own derivatives, with the weights held back as the
evidence for them tells (D. J. C. MacKay, Neural Computation 4, 1992, 415-447, 448-472).
"""

import argparse
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from fem.supports import STRETCH, TWIST
from geometry.throw import CrankThrow
from law_process import Process
from law_throws import draw
from regression.law.inputs import plain_inputs, real_inputs
from regression.law.networks import FILE, OUTPUTS, Networks
from regression.law.ratios import ratios, throw_dimensions

Array = NDArray[np.float64]
UX, UY, UZ, RX, RY, RZ = range(6)
PINNED = [n for n in range(12) if n not in (UX, UY, 6 + UX, 6 + UY, UZ, RZ)]
HIDDEN = {"plain": (16, 12), "real": (24, 16)}
STEPS = {"plain": 60, "real": 200}
SAMPLES = {"plain": ("plain-train", "plain-held-out")}
# Change of each answer's logarithm with Poisson's ratio: mean over five throws of the real tier, and one and
# a half of its standard deviations, for five are few.
POISSON = {
    "axial_pinned": (-0.37, 0.15),
    "axial_guided": (-0.42, 0.13),
    "tilt_ratio": (-0.73, 0.23),
    "influence_pinned": (-0.34, 0.15),
    "influence_guided": (-0.16, 0.18),
    "torsional_pinned": (0.63, 0.1),
    "torsional_guided": (0.46, 0.11),
    "tilt_in_plane": (-0.39, 0.17),
    "tilt_alike": (-0.28, 0.2),
    "tilt_across": (-0.1, 0.29),
    "tilt_by_force": (-0.03, 0.26),
    "volume": (0.0, 0.0),
}
SAMPLES["real"] = (*SAMPLES["plain"], "wide-train", "first-train", "real-train")
LEAST_NOISE = 2e-4
# What finite elements of 1 % leave of an error, in 95 of 100 throws (docs/accuracy.md).
FE_ERROR = 0.0017
# Throws between those computed that networks of real throws learn from; plain throws that processes do.
POOL, PLAIN_TEACHERS, KERNEL_THROWS = 3000, 200, 900
# Networks that follow processes: squares of weights beside those of errors, and steps of less
# than the least gain that may follow each other.
FREE, LEAST_GAIN, SLOW = 8e-8, 1e-3, 6
UNWEIGHED = 10  # steps before weights are held back as the evidence tells


def read(folder: Path, samples: tuple[str, ...]) -> list[dict[str, Any]]:
    """Finished throws of samples, each once, in the order of their numbers."""
    found: dict[tuple[str, int], dict[str, Any]] = {}
    for sample in samples:
        for file in sorted(folder.glob(f"{sample}-[0-9].jsonl")):
            for line in file.read_text(encoding="utf-8").splitlines():
                try:
                    row = json.loads(line)
                except ValueError:
                    continue
                if "failed" not in row and row["corrected"]:
                    found[sample, row["number"]] = row
    return [found[key] for key in sorted(found)]


def moment(axis: int, other: float) -> Array:
    """Unit moment on the left end about an axis, and another on the right end (12,)."""
    load = np.zeros(12)
    load[[axis, 6 + axis]] = 1.0, other
    return load


def numbers(row: dict[str, Any]) -> list[float]:
    """The law's answers of a throw, by `OUTPUTS`, from its superelement; E and D are 1 there."""
    stiffness, pins = np.array(row["stiffness"]), np.array(row["pin_loads"])
    tilts = [moment(RX, -1.0), moment(RY, 1.0), moment(RX, 1.0), moment(RY, -1.0)]
    loads = np.column_stack([STRETCH, TWIST, *tilts, pins[:, 0], -pins[:, 1]])
    motions = np.zeros_like(loads)
    motions[PINNED] = np.linalg.solve(stiffness[np.ix_(PINNED, PINNED)], loads[PINNED])
    work = loads.T @ motions
    axial, torsional, in_plane, across, alike, bent = np.diag(work)[:6]
    return [
        axial,
        axial - work[0, 2] ** 2 / in_plane,
        in_plane / across,
        work[0, 7],
        work[0, 7] - work[0, 2] * work[2, 7] / in_plane,
        torsional,
        torsional - work[1, 3] ** 2 / across,
        in_plane,
        alike,
        bent,
        work[5, 6],
        row["volume"],
    ]


def table(tier: str, rows: list[dict[str, Any]]) -> tuple[Array, Array]:
    """Inputs (n, d) and logarithms of answers (n, k) of throws."""
    make = plain_inputs if tier == "plain" else real_inputs
    throws = [throw_dimensions(CrankThrow(**row["fields"])) for row in rows]
    inputs = [make(ratios(throw)) for throw in throws]
    return np.array(inputs), np.log(np.array([numbers(row) for row in rows]))


class Network:
    """One network: its weights in a row, and what they give."""

    def __init__(self, inputs: int, hidden: tuple[int, int], seed: int) -> None:
        random, (m, n) = np.random.default_rng(seed), hidden
        self.shapes = [(m, inputs), (m,), (n, m), (n,), (n,), (inputs,), (1,)]
        parts = [
            random.normal(size=(m, inputs)) / np.sqrt(inputs),
            random.uniform(-1.0, 1.0, m),
            random.normal(size=(n, m)) / np.sqrt(m),
            random.uniform(-0.5, 0.5, n),
            0.1 * random.normal(size=n),
            np.zeros(inputs),
            np.zeros(1),
        ]
        self.weights = np.concatenate([part.ravel() for part in parts])
        self.groups = np.repeat(np.arange(7), [part.size for part in parts])
        self.noise = 0.0

    def parts(self, weights: Array | None = None) -> list[Array]:
        """Weights as the arrays of `Networks`, one network's."""
        weights = self.weights if weights is None else weights
        ends = np.cumsum([int(np.prod(shape)) for shape in self.shapes])
        return [
            p.reshape(s) for p, s in zip(np.split(weights, ends[:-1]), self.shapes, strict=True)
        ]

    def values(self, x: Array, weights: Array | None = None) -> Array:
        """Answers (n,) for scaled inputs (n, d)."""
        a, b, c, d, last, direct, constant = self.parts(weights)
        return np.asarray(np.tanh(np.tanh(x @ a.T + b) @ c.T + d) @ last + x @ direct + constant)

    def derivatives(self, x: Array) -> tuple[Array, Array]:
        """Answers (n,), and their derivatives (n, weights)."""
        a, b, c, d, last, direct, constant = self.parts()
        one = np.tanh(x @ a.T + b)
        two = np.tanh(one @ c.T + d)
        by_two = (1.0 - two**2) * last
        by_one = (by_two @ c) * (1.0 - one**2)
        columns = [
            (by_one[:, :, None] * x[:, None, :]).reshape(len(x), -1),
            by_one,
            (by_two[:, :, None] * one[:, None, :]).reshape(len(x), -1),
            by_two,
            two,
            x,
            np.ones((len(x), 1)),
        ]
        return two @ last + x @ direct + constant, np.concatenate(columns, axis=1)

    def train(self, x: Array, y: Array, steps: int) -> None:
        """Minimize squared errors and weights, and weigh the two by the evidence."""
        held = np.full(7, 1e-2)
        held[5:] = 1e-6
        precision, damping = 1.0 / (0.01 * y.var()), 1e-2
        values, slopes = self.derivatives(x)
        for step in range(steps):
            error, pull = y - values, held[self.groups]
            square = slopes.T @ slopes
            cost = 0.5 * precision * error @ error + 0.5 * pull @ self.weights**2
            downhill = precision * (slopes.T @ error) - pull * self.weights
            for _ in range(8):
                matrix = precision * square
                matrix[np.diag_indices_from(matrix)] += pull + damping * precision
                try:
                    change = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), downhill)
                except LinAlgError:
                    damping *= 10.0
                    continue
                weights = self.weights + change
                left = y - self.values(x, weights)
                if 0.5 * precision * left @ left + 0.5 * pull @ weights**2 < cost:
                    break
                damping *= 4.0
            else:
                break
            self.weights, damping = weights, max(damping / 5.0, 1e-10)
            values, slopes = self.derivatives(x)
            if step % 3 == 2 and step >= UNWEIGHED:
                held, precision = self._weighed(y - values, slopes, held, precision)
        self.noise = 1.0 / np.sqrt(precision)

    def follow(self, x: Array, y: Array, steps: int) -> None:
        """Minimize squared errors beside answers without noise; weights are held back as little as can be."""
        held = np.array([FREE] * 5 + [1e-3 * FREE] * 2)[self.groups]
        damping, slow = 0.1, 0
        error = y - self.values(x)
        cost = error @ error + held @ self.weights**2
        for _ in range(steps):
            slopes = self.derivatives(x)[1]
            square = slopes.T @ slopes
            downhill = slopes.T @ error - held * self.weights
            for _ in range(10):
                matrix = square.copy()
                matrix[np.diag_indices_from(matrix)] += held + damping
                weights = self.weights + cho_solve(cho_factor(matrix, lower=True), downhill)
                left = y - self.values(x, weights)
                better = left @ left + held @ weights**2
                if better < cost:
                    break
                damping *= 4.0
            else:
                break
            slow = slow + 1 if better > (1.0 - LEAST_GAIN) * cost else 0
            self.weights, error, cost = weights, left, better
            damping = max(damping / 3.0, 1e-7)
            if slow > SLOW:
                break

    def _weighed(
        self, error: Array, slopes: Array, held: Array, precision: float
    ) -> tuple[Array, float]:
        matrix = precision * (slopes.T @ slopes) + np.diag(held[self.groups])
        spread, held = np.diag(np.linalg.inv(matrix)), held.copy()
        known = 0.0
        for group in range(7):
            of = self.groups == group
            count = of.sum() - held[group] * spread[of].sum()
            known += count
            if group < 5:
                held[group] = np.clip(count / (self.weights[of] @ self.weights[of]), 1e-6, 1e4)
        share = len(error) - min(known, 0.9 * len(error))
        return held, min(share / (error @ error), 1.0 / LEAST_NOISE**2)


def fit(tier: str, x: Array, y: Array, steps: int, ends: tuple[Array, Array]) -> dict[str, Array]:
    """Fit a network to each answer: the arrays of `Networks`, without bands."""
    low, high = ends
    scaled = 2.0 * (x - low) / (high - low) - 1.0
    found: list[list[Array]] = []
    for name in OUTPUTS:
        column = y[:, OUTPUTS.index(name)]
        middle = column.mean()
        best = Network(x.shape[1], HIDDEN[tier], seed=0)
        best.train(scaled, column - middle, steps)
        found.append([*best.parts()[:-1], best.parts()[-1][0] + middle])
        error = column - middle - best.values(scaled)
        print(f"{tier} {name}: rms {100 * error.std():.3f} %, largest {100 * abs(error).max():.2f} %,"
              f" noise {100 * best.noise:.3f} %", flush=True)  # fmt: skip
    return stacked(found, low, high)


def stacked(found: list[list[Array]], low: Array, high: Array) -> dict[str, Array]:
    """Weights of some networks as the arrays of `Networks`."""
    names = ("first", "first_constant", "second", "second_constant", "last", "direct", "constant")
    parts = {name: np.array([one[place] for one in found]) for place, name in enumerate(names)}
    return {"low": low, "high": high, **parts}


def pool(count: int) -> Array:
    """Inputs (n, d) of throws within the ranges of real ones, that are not computed."""
    throws = (fields for _, fields in draw("real-pool", 2 * count))
    return np.array(
        [
            real_inputs(ratios(throw_dimensions(CrankThrow(**fields))))
            for fields in itertools.islice(throws, count)
        ]
    )


def teachers(rows: list[dict[str, Any]]) -> Array:
    """Which throws teach the processes of real ones: all but of plain ones, of which a share."""
    plain = np.array([row["sample"].startswith("plain") for row in rows])
    few = np.random.default_rng(1).choice(np.flatnonzero(plain), PLAIN_TEACHERS, replace=False)
    return np.sort(np.concatenate([np.flatnonzero(~plain), few]))


def fit_real(rows: list[dict[str, Any]], x: Array, y: Array, steps: int) -> dict[str, Array]:
    """Fit processes to real throws, then networks to these processes at these throws and between them."""
    between = pool(POOL)
    low = np.minimum(x.min(axis=0), between.min(axis=0))
    high = np.maximum(x.max(axis=0), between.max(axis=0))
    chosen = teachers(rows)
    scaled, far = (2.0 * (some - low) / (high - low) - 1.0 for some in (x[chosen], between))
    few = np.random.default_rng(2).permutation(len(chosen))[:KERNEL_THROWS]
    judged = np.array([rows[n]["sample"] == "real-train" for n in chosen])
    both = np.concatenate([scaled, far])
    found: list[list[Array]] = []
    errors, misfit = [], []
    for name, column in zip(OUTPUTS, y[chosen].T[:, :, None], strict=True):
        kernel = Process(scaled[few], column[few], steps=35).logs
        process = Process(scaled, column, logs=kernel)
        errors.append(process.left[judged, 0])
        known = 0.5 * (process.values(scaled) + column)
        taught = np.concatenate([known, process.values(far)])[:, 0]
        middle = taught.mean()
        tries = [Network(both.shape[1], HIDDEN["real"], seed) for seed in (0, 1)]
        for one in tries:
            one.follow(both, taught - middle, steps)
        beside = [(taught - middle - one.values(both)).std() for one in tries]
        best = tries[int(np.argmin(beside))].parts()
        found.append([*best[:-1], best[-1][0] + middle])
        misfit.append(min(beside))
        left = 100 * np.abs(errors[-1])
        print(f"{name}: processes of other throws rms {np.sqrt(np.mean(left**2)):.2f} %, largest "
              f"{left.max():.1f} %; network beside them {100 * misfit[-1]:.2f} %", flush=True)  # fmt: skip
    made = stacked(found, low, high)
    made["bands"] = bands(scaled[judged], np.array(errors).T, np.array(misfit))
    return made


def fit_plain(rows: list[dict[str, Any]], x: Array, y: Array, steps: int) -> dict[str, Array]:
    """Fit networks to plain throws; their bands by a first fit without those held out."""
    held = np.array([row["sample"] == "plain-held-out" for row in rows])
    ends = x.min(axis=0), x.max(axis=0)
    first = fit("plain", x[~held], y[~held], steps, ends=ends)
    some = Networks(**first, bands=np.zeros((len(OUTPUTS), 2)), poisson=np.zeros((len(OUTPUTS), 2)))
    errors = y[held] - np.log(some.evaluate(x[held].T)[0]).T
    made = fit("plain", x, y, steps, ends=ends)
    made["bands"] = bands(some.scaled(x[held].T).T, errors, np.zeros(len(OUTPUTS)))
    return made


def bands(x: Array, errors: Array, misfit: Array) -> Array:
    """Half widths (k, 2) that hold 95 of 100 errors (n, k): in the middle, and their gain outward."""
    outward = np.mean(x**4, axis=1)
    found = []
    for sizes, besides in zip(np.abs(errors).T, misfit, strict=True):
        gain, middle = np.polyfit(outward, sizes, 1)
        if gain < 0.0 or middle < 0.0:
            gain, middle = 0.0, sizes.mean()
        share = np.quantile(sizes / (middle + gain * outward), 0.95)
        found.append(
            [np.sqrt((share * middle) ** 2 + FE_ERROR**2 + (2.0 * besides) ** 2), share * gain]
        )
    return np.array(found)


FITS = {"plain": fit_plain, "real": fit_real}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tier", choices=FITS, nargs="*", default=list(FITS))
    given = parser.parse_args()
    kept = dict(np.load(FILE)) if FILE.exists() else {}
    for tier in given.tier:
        rows = read(given.folder, SAMPLES[tier])
        made = FITS[tier](rows, *table(tier, rows), STEPS[tier])
        made["poisson"] = np.array([POISSON[name] for name in OUTPUTS])
        kept |= {f"{tier}_{name}": array for name, array in made.items()}
    np.savez_compressed(FILE, **kept)


if __name__ == "__main__":
    main()
