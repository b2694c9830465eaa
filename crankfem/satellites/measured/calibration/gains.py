"""Gains of an engine's cylinders from its vibration: a weak one named, or told that it cannot be."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Number, Quantity, Result, result
from crankfem.satellites.measured.calibration.fit import NORMAL95, Fit
from crankfem.satellites.measured.calibration.groups import EXCITATION, Group, excitation_group
from crankfem.satellites.measured.calibration.identifiability import Further

# Before the measurement a gain is hardly known: within a factor of four, 95 of 100 times.
GAIN_TOLERANCE = 3.0
# A cylinder this much weaker than the others is to be found, 95 of 100 times.
WEAK = 0.20
# What cylinders differ by in any engine is no weakness.
LEAST_WEAK = 0.08
# In all cylinders together a healthy one is called weak in 2.5 of 100 cases.
FALSE_NAMING, FINDING = 0.025, 1.645


@result("name", "ratio", "low", "high", "weak")
class CylinderGain(Result):
    """Torque of a cylinder's gas over the mean of the others.

    Attributes
    ----------
    low, high : float
        95 % interval.
    detectable : float
        The least weakness, as a share, that would be found 95 of 100 times.
    weak : bool
        Whether it is weaker than chance explains.
    """

    name: str
    ratio: Number
    low: Number
    high: Number
    detectable: Number
    weak: bool

    @property
    def determined(self) -> Annotated[bool, Quantity(key="determined")]:
        """Whether a weakness of `WEAK` would be found."""
        return self.detectable <= WEAK


@dataclass(frozen=True)
class Gains:
    """The cylinders' gains.

    Attributes
    ----------
    cylinders : tuple of CylinderGain
    remedies : tuple of (str, float)
        Further measurements with which every cylinder's weakness is found, and the least found then.
    """

    cylinders: tuple[CylinderGain, ...]
    remedies: tuple[tuple[str, float], ...]

    @property
    def weak(self) -> tuple[str, ...]:
        """Names of weak cylinders."""
        return tuple(each.name for each in self.cylinders if each.weak)

    @property
    def determined(self) -> bool:
        """Whether a weak cylinder would be found, whichever it is."""
        return all(each.determined for each in self.cylinders)


def cylinder_groups(names: Sequence[str]) -> tuple[Group, ...]:
    """Return a group for the gain of each cylinder."""
    return tuple(
        excitation_group(f"gas torque of {name}", len(names), [number], GAIN_TOLERANCE)
        for number, name in enumerate(names)
    )


def cylinder_gains(solved: Fit, names: Sequence[str], further: Sequence[Further] = ()) -> Gains:
    """Return the gains of a fit whose groups have one for each cylinder.

    Parameters
    ----------
    names : sequence of str
        Of the cylinders, in the order of the sources.
    further : sequence of Further
        Measurements that could be made besides.
    """
    from scipy.stats import norm

    groups = solved.problem.shaft.groups
    count = len(names)
    gained = np.zeros((count, len(groups)))
    for number, group in enumerate(groups):
        for field, shares, power in group.acts:
            if field == EXCITATION:
                gained[:, number] += power * group.deviation * shares
    # Logarithm of each gain less the mean of those of the others.
    rows = (np.eye(count) - (1.0 - np.eye(count)) / (count - 1)) @ gained
    limit = float(norm.isf(FALSE_NAMING / count))

    def deviations(covariance: Array) -> Array:
        return np.asarray(np.sqrt(np.einsum("cp,pq,cq->c", rows, covariance, rows)))

    def detectable(deviation: float) -> float:
        named = max(limit * deviation, -np.log1p(-LEAST_WEAK))
        return float(-np.expm1(-named - FINDING * deviation))

    size = len(groups)
    logs = rows @ solved.parameters[:size]
    spread = deviations(solved.covariance[:size, :size])
    cylinders = tuple(
        CylinderGain(
            name=name,
            ratio=float(np.exp(log)),
            low=float(np.exp(log - NORMAL95 * deviation)),
            high=float(np.exp(log + NORMAL95 * deviation)),
            detectable=detectable(float(deviation)),
            weak=bool(log < -limit * deviation and log < np.log1p(-LEAST_WEAK)),
        )
        for name, log, deviation in zip(names, logs, spread, strict=True)
    )
    noise = float(max(solved.misfit, 1.0))
    remedies = []
    for each in further:
        covariance = np.asarray(np.linalg.inv(each.information / noise + np.eye(size)), dtype=float)
        least = detectable(float(np.max(deviations(covariance))))
        if least <= WEAK:
            remedies.append((each.what, least))
    return Gains(cylinders, tuple(sorted(remedies, key=lambda item: item[1])))
