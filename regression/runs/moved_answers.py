"""Answers on moved meshes, scaled to those of their anchors, which are solved on meshes of their own as well.

A coarse mesh that is moved errs by nearly the same share everywhere, or by one that varies smoothly: the
ratio of the ordinary answer to that on the moved mesh, at the anchors, is fitted over the factors and takes
the error away. What is left is known from anchors that are left out of the fit in turn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.array_checks import Array
from regression.plans.moved_meshes import ANCHORS
from regression.plans.plan import PlannedDesign
from regression.records import MESHED, Outcome

# Ratios beyond are of answers that nearly vanish: those are not scaled.
MOST_OFF = 0.3
# The error bar is this many times what is left out: so that 19 of 20 answers are within it.
BARS = 2.0
# With one anchor, whose ratio says nothing of others: the share of the moved mesh's own error bar that is
# left.
LEFT_OF_BAR = 0.4


@dataclass(frozen=True)
class RatioFit:
    """The ratio of ordinary answers to those on a moved mesh, for one response and class.

    Attributes
    ----------
    middle, halves : (k,) array
        By which factors are coded, over the anchors.
    coefficients : (1,) or (1 + k,) array
        Of one, and of the coded factors if there are anchors enough.
    scatter : float or None
        Of anchors left out; None of a single one.
    precision : float
        Estimated relative error of the anchors' ordinary answers.
    """

    middle: Array
    halves: Array
    coefficients: Array
    scatter: float | None
    precision: float

    def at(self, values: Array) -> float:
        """Ratio at factor values (k,)."""
        coded = (values - self.middle) / self.halves
        return float(self.coefficients[0] + coded[: len(self.coefficients) - 1] @ self._steep)

    @property
    def slopes(self) -> Array:
        """Derivatives (k,) of the ratio over the factors."""
        return self._steep / self.halves if len(self._steep) else np.zeros(len(self.middle))

    @property
    def _steep(self) -> Array:
        return self.coefficients[1:]


def ratio_fit(values: Array, ratios: Array, precision: float) -> RatioFit:
    """Fit the ratio over factor values (n, k): linear if there are anchors enough, else its mean."""
    count = len(values)
    middle = 0.5 * (values.min(axis=0) + values.max(axis=0))
    halves = np.asarray(0.5 * np.ptp(values, axis=0), dtype=np.float64)
    varied = halves > 0.0
    halves = np.where(varied, halves, 1.0)
    columns = np.ones((count, 1))
    if count >= ANCHORS * (np.count_nonzero(varied) + 1):
        columns = np.column_stack([columns, (values - middle) / halves])
    coefficients = np.asarray(np.linalg.lstsq(columns, ratios, rcond=None)[0])
    scatter = None
    if count > 1:
        leverages = np.sum(columns * np.linalg.pinv(columns).T, axis=1)
        left = (ratios - columns @ coefficients) / np.maximum(1.0 - leverages, 1e-3)
        scatter = float(np.sqrt(np.mean(left**2)))
    return RatioFit(middle, halves, coefficients, scatter, precision)


@dataclass(frozen=True)
class ScaledAnswers:
    """Outcomes of a study's designs, those on moved meshes scaled.

    Attributes
    ----------
    outcomes : dict of str to Outcome
        By key of the design.
    trends : dict of str to dict of str to (k,) array
        By key and response: d ln(ratio) / d(factor), which slopes on the moved mesh lack [SI].
    fits : dict of int to dict of str to RatioFit
        By class and response.
    """

    outcomes: dict[str, Outcome]
    trends: dict[str, dict[str, Array]]
    fits: dict[int, dict[str, RatioFit]]


def scaled_answers(
    designs: Sequence[PlannedDesign], outcomes: Mapping[str, Outcome]
) -> ScaledAnswers:
    """Scale the answers of designs on moved meshes to those of their anchors, as far as these are known."""
    scaled = {design.key: outcomes[design.key] for design in designs if design.key in outcomes}
    trends: dict[str, dict[str, Array]] = {}
    classes: dict[int, list[PlannedDesign]] = {}
    for design in designs:
        if design.mesh_class is not None and is_moved(scaled.get(design.key)):
            classes.setdefault(design.mesh_class, []).append(design)
    fits = {number: _class_fits(members, scaled, outcomes) for number, members in classes.items()}
    for number, members in classes.items():
        for design in members:
            known = scaled[design.key]
            ordinary = outcomes.get(design.ordinary[0]) if design.ordinary else None
            values = np.array(design.values)
            scaled[design.key] = _scaled(known, ordinary, values, fits[number])
            trends[design.key] = {
                name: fit.slopes / fit.at(values) for name, fit in fits[number].items()
            }
    return ScaledAnswers(scaled, trends, fits)


def is_moved(outcome: Outcome | None) -> bool:
    """Whether a design was solved on a moved mesh."""
    return bool(outcome and outcome.responses and outcome.mesh.get("tier", MESHED) != MESHED)


def _class_fits(
    members: Sequence[PlannedDesign],
    moved: Mapping[str, Outcome],
    outcomes: Mapping[str, Outcome],
) -> dict[str, RatioFit]:
    anchors = [
        (design.values, moved[design.key], outcomes[design.ordinary[0]])
        for design in members
        if design.ordinary and design.ordinary[0] in outcomes
    ]
    anchors = [anchor for anchor in anchors if anchor[2].responses]
    if not anchors:
        return {}
    values = np.array([anchor[0] for anchor in anchors])
    fits = {}
    for name in anchors[0][1].responses or {}:
        pairs = [
            ((ordinary.responses or {}).get(name, 0.0), (coarse.responses or {}).get(name, 0.0))
            for _, coarse, ordinary in anchors
        ]
        if not all(coarse for _, coarse in pairs):
            continue
        ratios = np.array([fine / coarse for fine, coarse in pairs])
        if np.abs(ratios - 1.0).max() > MOST_OFF:
            continue
        bars = [ordinary.errors.get(name, 0.0) for _, _, ordinary in anchors]
        fits[name] = ratio_fit(values, ratios, float(np.median(bars)))
    return fits


def _scaled(
    moved: Outcome, ordinary: Outcome | None, values: Array, fits: Mapping[str, RatioFit]
) -> Outcome:
    """Scale an outcome; an anchor's answers are those on a mesh of its own."""
    responses, errors = dict(moved.responses or {}), dict(moved.errors)
    for name, fit in fits.items():
        responses[name] *= fit.at(values)
        left = LEFT_OF_BAR * errors.get(name, 0.0) if fit.scatter is None else BARS * fit.scatter
        errors[name] = float(np.hypot(fit.precision, left))
    if ordinary is not None and ordinary.responses:
        responses |= ordinary.responses
        errors |= ordinary.errors
    return replace(moved, responses=responses, errors=errors)
