"""Answers on moved meshes, scaled to those of their anchors, which are solved on meshes of their own as well.

A coarse mesh that is moved errs by nearly the same share everywhere, or by one that varies smoothly: the
ratio of the ordinary answer to that on the moved mesh, at the anchors, is fitted over the factors' logarithms
and takes the error away. What is left is known from anchors that are left out of the fit in turn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from crankbase.array_checks import Array, Flags, Integers
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
# Terms of what corrects the mesh's own answers, as of `ratio_fit`; how many times steeper a share that is
# left may be than over half of a factor's range.
MOST_DEGREE, STEEP = 3, 2.0

# Answers, others of the same design, and relative errors of the first.
_Answers = tuple[Mapping[str, float], Mapping[str, float], Mapping[str, float]]


@dataclass(frozen=True)
class RatioFit:
    """A ratio of answers to others of the same throws, for one response and class.

    Attributes
    ----------
    logged : (k,) array of bool
        Factors that are taken by their logarithms: those that are positive.
    middle, halves : (k,) array
        By which factors, or their logarithms, are coded.
    powers : (t, k) array of int
        Of the coded factors in each term.
    coefficients : (t,) array
    scatter : float or None
        Of designs left out of the fit in turn; None of a single one.
    precision : float
        Estimated relative error of the answers in the numerator.
    """

    logged: Flags
    middle: Array
    halves: Array
    powers: Integers
    coefficients: Array
    scatter: float | None
    precision: float

    def at(self, values: Array) -> float:
        """Ratio at factor values (k,)."""
        return float(np.prod(self._coded(values) ** self.powers, axis=1) @ self.coefficients)

    def trend(self, values: Array) -> Array:
        """Derivatives (k,) of the logarithm of the ratio over the factors [SI]."""
        coded, slopes = self._coded(values), np.zeros(len(values))
        for place in range(len(values)):
            lowered = self.powers.copy()
            lowered[:, place] = np.maximum(lowered[:, place] - 1, 0)
            terms = self.powers[:, place] * np.prod(coded**lowered, axis=1)
            slopes[place] = terms @ self.coefficients
        sizes = np.where(self.logged, values, 1.0)
        return np.asarray(slopes / (self.halves * sizes) / self.at(values))

    def slope_error(self, left: float) -> float:
        """Error of slopes as shares, d ln(answer) / d ln(factor), if the ratio is off by a share."""
        varied = self.halves[self.powers.any(axis=0)]
        return left * STEEP / float(varied.min()) if len(varied) else np.inf

    def _coded(self, values: Array) -> Array:
        return np.asarray((_turned(values, self.logged) - self.middle) / self.halves)


def _turned(values: Array, logged: Flags) -> Array:
    return np.where(logged, np.log(np.where(logged, values, 1.0)), values)


def ratio_fit(values: Array, ratios: Array, precision: float, degree: int = 1) -> RatioFit:
    """Fit a ratio over factor values (n, k), by as many terms as there are designs for.

    Up to a degree: 0 is the mean, 1 linear, 2 with squares, 3 with products of two factors.
    """
    logged = np.asarray(values.min(axis=0) > 0.0)
    turned = _turned(values, logged)
    middle = 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    halves = np.asarray(0.5 * np.ptp(turned, axis=0), dtype=np.float64)
    varied = np.eye(values.shape[1], dtype=int)[halves > 0.0]
    halves = np.where(halves > 0.0, halves, 1.0)
    products = [first + second for first, second in combinations(varied, 2)]
    steps = varied, 2 * varied, np.reshape(products, (-1, len(halves))).astype(int)
    powers = np.zeros((1, len(halves)), dtype=int)
    for step in steps[:degree]:
        if len(values) >= ANCHORS * (len(powers) + len(step)):
            powers = np.concatenate([powers, step])
    coded = (turned - middle) / halves
    columns = np.prod(coded[:, None] ** powers, axis=2)
    coefficients = np.asarray(np.linalg.lstsq(columns, ratios, rcond=None)[0])
    scatter = None
    if len(values) > 1:
        leverages = np.sum(columns * np.linalg.pinv(columns).T, axis=1)
        left = (ratios - columns @ coefficients) / np.maximum(1.0 - leverages, 1e-3)
        scatter = float(np.sqrt(np.mean(left**2)))
    return RatioFit(logged, middle, halves, powers, coefficients, scatter, precision)


@dataclass(frozen=True)
class ScaledAnswers:
    """Outcomes of a study's designs, those on moved meshes scaled.

    Attributes
    ----------
    outcomes : dict of str to Outcome
        By key of the design.
    trends : dict of str to dict of str to (k,) array
        By key and response: derivative over the factors of the logarithm of what the mesh's own answer was
        multiplied by, which slopes on the moved mesh lack [SI].
    fits : dict of int to dict of str to RatioFit
        By class and response: ordinary answers by those on the moved mesh.
    """

    outcomes: dict[str, Outcome]
    trends: dict[str, dict[str, Array]]
    fits: dict[int, dict[str, RatioFit]]


def scaled_answers(
    designs: Sequence[PlannedDesign], outcomes: Mapping[str, Outcome]
) -> ScaledAnswers:
    """Scale the answers of designs on moved meshes to those of their anchors, as far as these are known.

    With slopes, which are those of the mesh's own answers, these are multiplied by a fit of what corrects
    them, so that answers and slopes are of one function.
    """
    scaled = {design.key: outcomes[design.key] for design in designs if design.key in outcomes}
    trends: dict[str, dict[str, Array]] = {}
    classes: dict[int, list[PlannedDesign]] = {}
    for design in designs:
        if design.mesh_class is not None and is_moved(scaled.get(design.key)):
            classes.setdefault(design.mesh_class, []).append(design)
    fits = {}
    for number, members in classes.items():
        corrections = _corrections(members, scaled)
        for design in members:
            # The mesh's own answers and the fit of what corrects them.
            answer, values = scaled[design.key], np.array(design.values)
            discrete = discrete_answers(answer)
            smooth = {name: discrete[name] * fit.at(values) for name, fit in corrections.items()}
            responses = {**(answer.responses or {}), **smooth}
            scaled[design.key] = replace(answer, responses=responses)
        fits[number] = _class_fits(members, scaled, outcomes)
        for design in members:
            known = scaled[design.key]
            ordinary = outcomes.get(design.ordinary[0]) if design.ordinary else None
            values = np.array(design.values)
            scaled[design.key] = _scaled(known, ordinary, values, fits[number], corrections)
            trends[design.key] = {
                name: sum((fit.trend(values) for fit in both), np.zeros(len(values)))
                for name in known.slopes
                if (both := [by[name] for by in (corrections, fits[number]) if name in by])
            }
    return ScaledAnswers(scaled, trends, fits)


def is_moved(outcome: Outcome | None) -> bool:
    """Whether a design was solved on a moved mesh."""
    return bool(outcome and outcome.responses and outcome.mesh.get("tier", MESHED) != MESHED)


def _corrections(
    members: Sequence[PlannedDesign], moved: Mapping[str, Outcome]
) -> dict[str, RatioFit]:
    """Fit what corrects the mesh's own answers, over the designs of the plan, if some have slopes."""
    if not any(moved[design.key].slopes for design in members):
        return {}
    members = [design for design in members if not design.added] or members
    known = [moved[design.key] for design in members]
    values = np.array([design.values for design in members])
    answers: list[_Answers] = [
        (outcome.responses or {}, discrete_answers(outcome), {}) for outcome in known
    ]
    return _ratio_fits(values, answers, MOST_DEGREE)


def discrete_answers(outcome: Outcome) -> Mapping[str, float]:
    """Return the answers of a moved mesh without their correction."""
    answers: Mapping[str, float] = outcome.mesh.get("discrete", {})
    return answers


def _class_fits(
    members: Sequence[PlannedDesign],
    moved: Mapping[str, Outcome],
    outcomes: Mapping[str, Outcome],
) -> dict[str, RatioFit]:
    anchors = [
        (design, outcomes[design.ordinary[0]])
        for design in members
        if design.ordinary and design.ordinary[0] in outcomes
    ]
    anchors = [anchor for anchor in anchors if anchor[1].responses]
    values = np.array([design.values for design, _ in anchors])
    answers = [
        (ordinary.responses or {}, moved[design.key].responses or {}, ordinary.errors)
        for design, ordinary in anchors
    ]
    return _ratio_fits(values, answers, 1)


def _ratio_fits(
    values: Array,
    answers: Sequence[_Answers],
    degree: int,
) -> dict[str, RatioFit]:
    """Fit ratios of answers, by response."""
    fits = {}
    for name in answers[0][1] if answers else ():
        pairs = [(fine.get(name, 0.0), coarse.get(name, 0.0)) for fine, coarse, _ in answers]
        if not all(coarse for _, coarse in pairs):
            continue
        ratios = np.array([fine / coarse for fine, coarse in pairs])
        if np.abs(ratios - 1.0).max() <= MOST_OFF:
            bars = [errors.get(name, 0.0) for _, _, errors in answers]
            fits[name] = ratio_fit(values, ratios, float(np.median(bars)), degree)
    return fits


def _scaled(
    moved: Outcome,
    ordinary: Outcome | None,
    values: Array,
    fits: Mapping[str, RatioFit],
    corrections: Mapping[str, RatioFit],
) -> Outcome:
    """Scale an outcome; an anchor's answers are those on a mesh of its own."""
    responses, errors = dict(moved.responses or {}), dict(moved.errors)
    slope_errors = dict(moved.slope_errors)
    for name, fit in fits.items():
        responses[name] *= fit.at(values)
        left = LEFT_OF_BAR * errors.get(name, 0.0) if fit.scatter is None else BARS * fit.scatter
        errors[name] = float(np.hypot(fit.precision, left))
        if name in corrections and name in slope_errors:
            off = float(np.hypot(left, corrections[name].scatter or 0.0))
            slope_errors[name] = min(slope_errors[name], corrections[name].slope_error(off))
    if ordinary is not None and ordinary.responses:
        responses |= ordinary.responses
        errors |= ordinary.errors
    return replace(moved, responses=responses, errors=errors, slope_errors=slope_errors)
