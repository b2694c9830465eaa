"""Fit the law's networks to its throws: ``python benchmarks/fit_law.py [--tier plain] [--only bands]``.

Levenberg and Marquardt's steps on the networks' own derivatives, with the weights held back as the
evidence for them tells (D. J. C. MacKay, Neural Computation 4, 1992, 415-447, 448-472).

``--only bands`` makes the bands of law.npz again, from its networks: coefficients within 2e-5, those of e_n
pinned of plain throws within 0.05. The networks were trained in steps whose
settings changed: the whole script makes others of their kind, not the same weights.
"""

import argparse
import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import minimize

from crankbase.errors import InputError
from geometry.throw import CrankThrow
from law_process import Process
from law_table import throws
from law_throws import DRAWN, FIELDS, Sample, draw
from regression.law.throw_law import (
    FILE,
    OUTPUTS,
    PLAIN,
    RANGES,
    REAL,
    Networks,
    plain_inputs,
    ratios,
    real_inputs,
    throw_dimensions,
)

Array = NDArray[np.float64]
INPUTS = {"plain": plain_inputs, "real": real_inputs}
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
# A longer main journal makes a throw softer, pulled with its ends pinned, by this share of what the longer
# journal gives as a bar: at random throws of so many lengths, the worst of them after each round of steps;
# its weight beside errors, and how the weights found before are held.
RISE, LEVELS, LADDERS, WORST, ROUNDS, LIFTS = 0.4, 7, 12_000, 1400, 4, 20
LIFT_WEIGHT, LIFT_HELD = 300.0, 1.0
# Weights of the slopes of half widths: of real throws the least of 5, 20, 60, 120, 160, 200, 240 and 320 with
# which, for each result of the law, bands fitted to five sixths of the throws that teach are, for nine of ten
# of the others, 0.7 to 2 times twice the rms error of 50 neighbors.
FLAT = {"plain": 60.0, "real": 160.0}
# The share of throws that bands hold: of plain ones more, for those held out are few.
INSIDE = {"plain": 0.97, "real": 0.95}
UNWEIGHED = 10  # steps before weights are held back as the evidence tells


def table(tier: str, samples: tuple[str, ...]) -> tuple[Array, Array, Array, Array]:
    """Samples (n,), inputs (n, d), logarithms of answers (n, k), whether throws are in the law's range."""
    names, dimensions, answers = throws()
    some = np.isin(names, samples)
    throw_ratios = ratios({name: values[some] for name, values in dimensions.items()})
    inside = np.ones(some.sum(), dtype=bool)
    for name, (low, high) in RANGES.items():
        inside &= (throw_ratios[name] >= low) & (throw_ratios[name] <= high)
    logs = np.log(np.array([answers[name][some] for name in OUTPUTS]))
    return names[some], INPUTS[tier](throw_ratios).T, logs.T, inside


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
        near = np.tanh(x @ a.T + b)
        two = np.tanh(near @ c.T + d)
        by_two = (1.0 - two**2) * last
        by_one = (by_two @ c) * (1.0 - near**2)
        columns = [
            (by_one[:, :, None] * x[:, None, :]).reshape(len(x), -1),
            by_one,
            (by_two[:, :, None] * near[:, None, :]).reshape(len(x), -1),
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

    def lift(self, x: Array, y: Array, ladders: Array, bars: Array) -> None:
        """Raise the output up the rungs of `ladders` (n, m, d) by a share of `bars` (n, m - 1) or more.

        These are absolute, the output is a logarithm; answers y (n,) at x (n, d) are kept.
        """
        for _ in range(ROUNDS):
            rungs = self.values(ladders.reshape(-1, x.shape[1])).reshape(ladders.shape[:2])
            least = RISE * bars * np.exp(-rungs[:, :1])
            worst = np.argsort((np.diff(rungs, axis=1) / least).min(axis=1))[:WORST]
            self._lift(x, y, ladders[worst], least[worst])

    def _lift(self, x: Array, y: Array, ladders: Array, least: Array) -> None:
        points, shape = ladders.reshape(-1, x.shape[1]), ladders.shape[:2]
        begin, damping = self.weights, 1e-3

        def state(weights: Array) -> tuple[Array, Array, float]:
            rungs = self.values(points, weights).reshape(shape)
            error = y - self.values(x, weights)
            missing = LIFT_WEIGHT * np.maximum(least - np.diff(rungs, axis=1), 0.0)
            moved = weights - begin
            return error, missing, error @ error + np.sum(missing**2) + LIFT_HELD * moved @ moved

        error, missing, cost = state(begin)
        for _ in range(LIFTS):
            slopes = self.derivatives(x)[1]
            rungs = self.derivatives(points)[1].reshape(*shape, -1)
            short = missing > 0.0
            rises = LIFT_WEIGHT * (rungs[:, 1:] - rungs[:, :-1])[short]
            square = slopes.T @ slopes + rises.T @ rises
            downhill = slopes.T @ error + rises.T @ missing[short]
            downhill -= LIFT_HELD * (self.weights - begin)
            for _ in range(8):
                matrix = square.copy()
                matrix[np.diag_indices_from(matrix)] += LIFT_HELD + damping
                weights = self.weights + cho_solve(cho_factor(matrix, lower=True), downhill)
                after = state(weights)
                if after[2] < cost:
                    break
                damping *= 4.0
            else:
                break
            self.weights, damping = weights, max(damping / 4.0, 1e-8)
            error, missing, cost = after

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
    parts: list[list[Array]] = []
    for name in OUTPUTS:
        column = y[:, OUTPUTS.index(name)]
        middle = column.mean()
        best = Network(x.shape[1], HIDDEN[tier], seed=0)
        best.train(scaled, column - middle, steps)
        if name == "axial_pinned":
            points, bars = rungs(tier, ends)
            best.lift(scaled, column - middle, points, bars * np.exp(-middle))
        parts.append([*best.parts()[:-1], best.parts()[-1][0] + middle])
        error = column - middle - best.values(scaled)
        print(f"{tier} {name}: rms {100 * error.std():.3f} %, largest {100 * abs(error).max():.2f} %,"
              f" noise {100 * best.noise:.3f} %", flush=True)  # fmt: skip
    return stacked(parts, low, high)


def stacked(networks: list[list[Array]], low: Array, high: Array) -> dict[str, Array]:
    """Weights of some networks as the arrays of `Networks`."""
    names = ("first", "first_constant", "second", "second_constant", "last", "direct", "constant")
    parts = {
        name: np.array([parts_of[place] for parts_of in networks])
        for place, name in enumerate(names)
    }
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


def rungs(tier: str, ends: tuple[Array, Array]) -> tuple[Array, Array]:
    """Scaled inputs (n, m, d) of random throws with main journals of m lengths; what these give as bars."""
    random, (low, high) = np.random.default_rng(4), ends
    shortest, longest = (PLAIN if tier == "plain" else REAL)["main_journal_length"]
    lengths = np.geomspace(shortest, longest, LEVELS)
    ladders, bars = [], []
    while len(ladders) < LADDERS:
        kind = tier if random.random() < 0.75 or tier == "plain" else "wide"
        try:
            throw = CrankThrow(**FIELDS[kind](Sample(kind, 0), random.random(DRAWN)))
        except InputError:
            continue
        ratios_at = ratios(throw_dimensions(throw) | {"main_journal_length": lengths})
        ladders.append(2.0 * (INPUTS[tier](ratios_at).T - low) / (high - low) - 1.0)
        bars.append(4.0 / np.pi * np.diff(lengths) / (1.0 - ratios_at["main_journal_bore"] ** 2))
    return np.array(ladders), np.array(bars)


def teachers(samples: Array) -> Array:
    """Which throws teach the processes of real ones: all but of plain ones, of which a share."""
    plain = np.char.startswith(samples, "plain")
    few = np.random.default_rng(1).choice(np.flatnonzero(plain), PLAIN_TEACHERS, replace=False)
    return np.sort(np.concatenate([np.flatnonzero(~plain), few]))


def process(x: Array, column: Array) -> Process:
    """A process through all throws, its kernel the likeliest for a share of them."""
    few = np.random.default_rng(2).permutation(len(x))[:KERNEL_THROWS]
    return Process(x, column, logs=Process(x[few], column[few], steps=35).logs)


def fit_real(samples: Array, x: Array, y: Array, steps: int) -> dict[str, Array]:
    """Fit processes to real throws, then networks to these processes at these throws and between them."""
    between = pool(POOL)
    low = np.minimum(x.min(axis=0), between.min(axis=0))
    high = np.maximum(x.max(axis=0), between.max(axis=0))
    chosen = teachers(samples)
    scaled, far = (2.0 * (some - low) / (high - low) - 1.0 for some in (x[chosen], between))
    both = np.concatenate([scaled, far])
    kept: list[list[Array]] = []
    for name, column in zip(OUTPUTS, y[chosen].T[:, :, None], strict=True):
        through = process(scaled, column)
        known = 0.5 * (through.values(scaled) + column)
        taught = np.concatenate([known, through.values(far)])[:, 0]
        middle = taught.mean()
        tries = [Network(both.shape[1], HIDDEN["real"], seed) for seed in (0, 1)]
        for network in tries:
            network.follow(both, taught - middle, steps)
        best = min(tries, key=lambda network: (taught - middle - network.values(both)).std())
        if name == "axial_pinned":
            points, bars = rungs("real", (low, high))
            best.lift(both, taught - middle, points, bars * np.exp(-middle))
        parts = best.parts()
        kept.append([*parts[:-1], parts[-1][0] + middle])
        print(f"{name}: network beside the process {100 * (taught - middle - best.values(both)).std():.2f} %",
              flush=True)  # fmt: skip
    return stacked(kept, low, high)


def fit_plain(samples: Array, x: Array, y: Array, steps: int) -> dict[str, Array]:
    """Fit networks to plain throws, those held out among them."""
    assert set(samples) == set(SAMPLES["plain"])
    return fit("plain", x, y, steps, ends=(x.min(axis=0), x.max(axis=0)))


def plain_bands(made: dict[str, Array], samples: Array, x: Array, y: Array, inside: Array) -> Array:
    """Bands of plain throws, by networks that have not seen those held out."""
    held = (samples == "plain-held-out") & inside
    first = fit("plain", x[samples == "plain-train"], y[samples == "plain-train"], STEPS["plain"],
                ends=(made["low"], made["high"]))  # fmt: skip
    errors, scaled = beside(first, x[held], y[held])
    return np.array([band("plain", scaled, error, scaled, error) for error in errors.T])


def real_bands(made: dict[str, Array], samples: Array, x: Array, y: Array, inside: Array) -> Array:
    """Bands of real throws: sizes of errors by processes without each throw, calibrated on those held out."""
    held = table("real", ("real-held-out",))
    unseen, places = beside(made, held[1], held[2])
    chosen = teachers(samples)
    _, scaled = beside(made, x[chosen], y[chosen])
    judged = inside[chosen] & ~np.char.startswith(samples[chosen], "plain")
    bands = []
    for place, column in enumerate(y[chosen].T[:, :, None]):
        through = process(scaled, column)
        misfit = beside(made, x[chosen], through.values(scaled), place)[0][:, 0]
        errors = np.hypot(through.left[:, 0], misfit)[judged]
        bands.append(band("real", scaled[judged], errors, places, unseen[:, place]))
        print(f"{OUTPUTS[place]}: processes of other throws rms {100 * through.left[judged].std():.2f} %",
              flush=True)  # fmt: skip
    return np.array(bands)


def beside(
    made: dict[str, Array], x: Array, y: Array, place: int | slice = slice(None)
) -> tuple[Array, Array]:
    """Errors (n, k) of networks beside answers (n, k), and scaled inputs (n, d)."""
    size, count = len(made["low"]), len(made["last"])
    rest = {"bands": np.zeros((count, 1 + size)), "poisson": np.zeros((count, 2))}
    some = Networks(**{**made, **rest})
    logs = np.log(some.evaluate(x.T)[0])[place].reshape(-1, len(x)).T
    return logs - y, some.scaled(x.T).T


def band(tier: str, x: Array, errors: Array, places: Array, unseen: Array) -> Array:
    """Logarithm of a half width (1 + d,), linear in scaled inputs, by errors (n,) at x (n, d).

    It holds its share of these and of errors unseen before at other places. Sizes of errors are taken to be
    distributed exponentially, for the largest of them would rule squares.
    """
    design = np.column_stack([np.ones(len(x)), x])
    sizes = np.hypot(errors, 0.5 * FE_ERROR)

    def unlikeliness(weights: Array) -> tuple[float, Array]:
        logs = design @ weights
        shares, held = sizes * np.exp(-logs), FLAT[tier] * np.append(0.0, weights[1:])
        slopes = design.T @ (1.0 - shares) + held
        return float(np.sum(logs + shares) + 0.5 * held @ weights), slopes

    begin = np.append(np.log(sizes.mean()), np.zeros(x.shape[1]))
    weights = np.asarray(minimize(unlikeliness, begin, jac=True, method="L-BFGS-B").x)
    weights[0] += max(
        np.quantile(
            np.log(np.hypot(some, 0.5 * FE_ERROR)) - weights[0] - at @ weights[1:], INSIDE[tier]
        )
        for at, some in ((x, errors), (places, unseen))
    )
    return weights


FITS: dict[str, Any] = {"plain": fit_plain, "real": fit_real}
BANDS: dict[str, Any] = {"plain": plain_bands, "real": real_bands}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tier", choices=FITS, nargs="*", default=list(FITS))
    parser.add_argument("--only", choices=["bands"])
    options = parser.parse_args()
    kept = dict(np.load(FILE)) if FILE.exists() else {}
    for tier in options.tier:
        samples, x, y, inside = table(tier, SAMPLES[tier])
        if options.only:
            made = {name: kept[f"{tier}_{name}"] for name in Networks.__annotations__}
        else:
            made = FITS[tier](samples, x, y, STEPS[tier])
        made["bands"] = BANDS[tier](made, samples, x, y, inside)
        made["poisson"] = np.array([POISSON[name] for name in OUTPUTS])
        kept |= {f"{tier}_{name}": array for name, array in made.items()}
    np.savez_compressed(FILE, **kept)


if __name__ == "__main__":
    main()
