"""Whether measured orders fit a shaft at all, and the slips that would explain why they do not."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from crankbase.array_checks import ComplexArray
from crankfem.satellites.measured.calibration.fit import Fit, Problem, fit
from crankfem.satellites.measured.measured_orders import MeasuredOrders

# Slips of records: what was done to the amplitudes, by a factor or the sense of rotation.
SLIPS: dict[str, complex] = {
    "degrees for radians": 180.0 / np.pi,
    "radians for degrees": np.pi / 180.0,
    "a thousand for one": 1e3,
    "a thousandth for one": 1e-3,
    "the opposite sign": -1.0,
}
OPPOSITE_SENSE = "the opposite sense of rotation"
# A mark on the crankshaft passes twice in a cycle of two revolutions.
OTHER_REVOLUTION = "an angle of the mark that is 360 deg off"
# A slip is tried if the sizes measured are nearer to it than this factor.
NEAR = 4.0
# A shaft of the engine explains so much of what is measured, with no group further from its prior than this.
LEAST_EXPLAINED, LARGEST_PULL = 0.9, 3.5
# The nominal values, and one from the prior.
STARTS = 2
Agreement = Literal["fits", "fits roughly", "does not fit"]


@dataclass(frozen=True)
class Agreed:
    """How a fit agrees with what was measured.

    Attributes
    ----------
    status : {"fits", "fits roughly", "does not fit"}
        Within the noise told; beyond it, but explaining most with groups near their tolerances; or neither.
    pulled : tuple of str
        Groups further from the maker's value than `LARGEST_PULL` deviations.
    slip : str or None
        What explains the misfit: with it undone the shaft fits.
    size : float
        Median of measured sizes over those calculated with the maker's values.
    """

    status: Agreement
    pulled: tuple[str, ...]
    slip: str | None
    size: float


def agreement(solved: Fit) -> Agreed:
    """Judge a fit, and where it does not fit try the usual slips of records."""
    status, pulled = _status(solved)
    size = _size(solved.problem)
    slip = _slip(solved.problem, size) if status == "does not fit" else None
    return Agreed(status, pulled, slip, size)


def _status(solved: Fit) -> tuple[Agreement, tuple[str, ...]]:
    """Return the status of a fit, and the groups that are pulled."""
    groups = solved.problem.shaft.groups
    pulled = tuple(
        group.name
        for group, pull in zip(groups, solved.parameters, strict=False)
        if abs(pull) > LARGEST_PULL
    )
    if solved.explained < LEAST_EXPLAINED or pulled:
        return "does not fit", pulled
    return "fits" if solved.misfit <= solved.limit else "fits roughly", pulled


def _size(problem: Problem) -> float:
    """Return the median of measured sizes over calculated ones, each weighed by its size."""
    nominal = np.zeros(problem.size)
    ratios, weights = [], []
    for number, each in enumerate(problem.observations):
        y = np.abs(problem.predicted(nominal, number)[0])
        measured = np.abs(each.measured.amplitude)
        some = (y > 0.0) & (measured > 0.0)
        ratios.append(measured[some] / y[some])
        weights.append((y / np.max(y))[some])
    ratio, weight = np.concatenate(ratios), np.concatenate(weights)
    order = np.argsort(ratio)
    half = np.searchsorted(np.cumsum(weight[order]), 0.5 * np.sum(weight))
    return float(ratio[order][half])


def _slip(problem: Problem, size: float) -> str | None:
    """Return the slip that, undone, makes the shaft fit, if one does."""
    tried = [
        name for name, factor in SLIPS.items() if abs(np.log(size / abs(factor))) < np.log(NEAR)
    ]
    if abs(np.log(size)) < np.log(NEAR):
        tried.append(OPPOSITE_SENSE)
        if len(problem.angles) < len(problem.observations):
            tried.append(OTHER_REVOLUTION)
    mended = {name: fit(_undone(problem, name), starts=STARTS) for name in tried}
    fitting = {name: each for name, each in mended.items() if _status(each)[0] != "does not fit"}
    return min(fitting, key=lambda name: fitting[name].misfit) if fitting else None


def _undone(problem: Problem, slip: str) -> Problem:
    """Return the problem without a slip."""

    def mended(each: MeasuredOrders) -> ComplexArray:
        if slip == OPPOSITE_SENSE:
            return np.conj(each.amplitude)
        if slip == OTHER_REVOLUTION:
            turned = np.exp(2j * np.pi * each.orders)
            return each.amplitude * (turned if each.zero_known else 1.0)
        return each.amplitude / SLIPS[slip]

    size = abs(SLIPS.get(slip, 1.0))
    return Problem(
        problem.shaft,
        tuple(
            replace(
                each,
                measured=replace(
                    each.measured,
                    amplitude=mended(each.measured),
                    scatter=each.measured.scatter / size,
                ),
            )
            for each in problem.observations
        ),
    )
