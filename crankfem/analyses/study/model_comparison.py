"""Two compliance models on the same throws: their differences, and whether their bands explain them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table_of
from regression.models.compliance_model import ComplianceModel
from regression.models.lookup import Lookup
from regression.models.optimum_space import SearchSpace, search_space
from regression.plans.designs_space import sobol_points, with_points_at_ends
from regression.response_kinds import is_positive_response

Array = NDArray[np.float64]

# Throws that are asked for; the seed that they are drawn from.
THROWS, SEED = 256, 1


@dataclass(frozen=True)
class ResponseComparison:
    """One response of two models on the same throws.

    Attributes
    ----------
    response, unit : str
    mean, rms : float
        Of the differences, second minus first, as shares of the first's values; for a response with a
        sign, as shares of the root mean square of these.
    largest : float
        The largest difference, with its sign.
    first, second : float
        The values there [SI].
    place : dict
        Factors of the first model there [SI], choices by their labels.
    by_bands : float or None
        The largest ratio of a difference to the facing parts of both error bands;
        above 1 the bands do not overlap. None where a band is unbounded.
    apart : float or None
        Share of the throws whose bands do not overlap.
    """

    response: str
    unit: str
    mean: float
    rms: float
    largest: float
    first: float
    second: float
    place: dict[str, float | str]
    by_bands: float | None
    apart: float | None

    def row(self) -> dict[str, tuple[Any, str]]:
        """Return columns of a table with their units."""
        shares = ("mean", "rms", "largest", "by_bands", "apart")
        return {"response": (self.response, "")} | {
            name: (getattr(self, name), "1") for name in shares
        }


@summarized("throws", "ranges", "responses: responses", "left_out", keeps_text=True)
@dataclass(frozen=True)
class ModelComparison:
    """Two models on the same throws.

    Attributes
    ----------
    throws : int
        Number of different throws requested.
    ranges : dict
        Numerical factor of the first model to the range common to both [SI].
    choices : dict
        Choice to the labels common to both.
    responses : tuple of ResponseComparison
    left_out : dict
        Response that is not compared, to the reason.
    remarks : tuple of str
    """

    throws: int
    ranges: dict[str, tuple[float, float]]
    choices: dict[str, tuple[str, ...]]
    responses: tuple[ResponseComparison, ...]
    left_out: dict[str, str]
    remarks: tuple[str, ...]

    def to_pandas(self) -> Any:
        """Return a table of the responses: their differences as shares, and by the bands.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.responses)


def compare_models(first: ComplianceModel, second: ComplianceModel) -> ModelComparison:
    """Evaluate two models for the same throws, spread over the ranges common to both.

    Throws follow from the factors and relations of the first model; half of them are at ends of ranges. Those
    that cannot be built, violate a constraint of either, or are outside a range of either are skipped.

    Parameters
    ----------
    first, second : ComplianceModel

    Returns
    -------
    ModelComparison

    Raises
    ------
    InputError
        If there is no such throw, or no common response.
    """
    ranges = {name: _common_range(second, name, ends) for name, ends in first.family.ranges.items()}
    choices = {
        name: _common_labels(second, name, labels)
        for name, labels in first.family.categories.items()
    }
    responses = [name for name in first.responses if name in second.responses]
    if not responses:
        raise InputError(
            f"models: given one of {', '.join(first.responses)} and one of {', '.join(second.responses)}; "
            "allowed are models with a response in common."
        )
    spaces = search_space(first, {}), search_space(second, {})
    answers: dict[str, list[tuple[Mapping[str, Any], Lookup, Lookup]]] = {
        name: [] for name in responses
    }
    reasons: dict[str, str] = {}
    throws = 0
    for factors in _drawn(ranges, choices):
        found = _answers(spaces, factors, responses, reasons)
        throws += bool(found)
        for name, pair in found.items():
            answers[name].append((factors, *pair))
    if not throws:
        raise InputError(
            f"models: given two that have no throw in common ({next(iter(reasons.values()))}); allowed are "
            "models whose ranges overlap."
        )
    return ModelComparison(
        throws=throws,
        ranges=ranges,
        choices=choices,
        responses=tuple(_compared(name, found) for name, found in answers.items() if found),
        left_out=_left_out(first, second)
        | {name: reasons[name] for name, found in answers.items() if not found},
        remarks=_remarks(first, second),
    )


def _common_range(
    model: ComplianceModel, name: str, ends: tuple[float, float]
) -> tuple[float, float]:
    """Intersect a range with another model's range of the same factor; unchanged if it has none."""
    family = model.family
    other = family.ranges.get(name)
    if other is None and name in family.fixed:
        other = (family.fixed[name], family.fixed[name])
    if other is None:  # a ratio, or what follows from others: the throws themselves will tell
        return ends
    low, high = max(ends[0], other[0]), min(ends[1], other[1])
    if low > high:
        raise InputError(
            f"{name}: given {family.format_value(name, ends[0])} to {family.format_value(name, ends[1])} "
            f"in one model and {family.format_value(name, other[0])} to "
            f"{family.format_value(name, other[1])} in the other; allowed are ranges that overlap."
        )
    return low, high


def _common_labels(model: ComplianceModel, name: str, labels: tuple[str, ...]) -> tuple[str, ...]:
    family = model.family
    fixed = (family.labels[name],) if name in family.labels else labels
    common = tuple(label for label in labels if label in family.categories.get(name, fixed))
    if not common:
        raise InputError(
            f"{name}: given {', '.join(labels)} in one model and none of them in the other; allowed are "
            "models with a choice in common."
        )
    return common


def _drawn(
    ranges: Mapping[str, tuple[float, float]], choices: Mapping[str, tuple[str, ...]]
) -> list[dict[str, Any]]:
    """Draw different factors over ranges and choices, half of them at ends of ranges."""
    counts = [*(0 for _ in ranges), *map(len, choices.values())]
    points = with_points_at_ends(sobol_points(THROWS, counts, (SEED,)), counts)
    drawn = [
        {
            name: low + float(place) * (high - low)
            for (name, (low, high)), place in zip(ranges.items(), row, strict=False)
        }
        | {
            name: labels[int(place * len(labels))]
            for (name, labels), place in zip(choices.items(), row[len(ranges) :], strict=True)
        }
        for row in points
    ]
    return list({tuple(factors.values()): factors for factors in drawn}.values())


def _answers(
    spaces: tuple[SearchSpace, SearchSpace],
    factors: Mapping[str, Any],
    responses: list[str],
    reasons: dict[str, str],
) -> dict[str, tuple[Lookup, Lookup]]:
    """Evaluate both models for a throw; if it does not belong to both, note the reason."""
    asked: list[Mapping[str, Any]] = [factors]
    try:
        throw, why = spaces[0].throw(spaces[0].model.family.completed(factors))
        if why:
            raise InputError(why[0])
        asked.append(factors if throw is None else spaces[1].model.dimensions_of(throw))
    except InputError as error:
        reasons.setdefault("throw", str(error).rstrip("."))
        return {}
    found = {}
    for name in responses:
        try:
            found[name] = (
                spaces[0].model.lookup(name, strict=True, **asked[0]),
                spaces[1].model.lookup(name, strict=True, **asked[1]),
            )
        except InputError as error:
            reasons.setdefault(name, str(error).rstrip("."))
    return found


def _compared(
    name: str, found: list[tuple[Mapping[str, Any], Lookup, Lookup]]
) -> ResponseComparison:
    first = np.array([one.value for _, one, _ in found])
    second = np.array([other.value for _, _, other in found])
    size = np.abs(first) if is_positive_response(name) else np.sqrt(np.mean(first**2))
    differences = (second - first) / size
    largest = int(np.argmax(np.abs(differences)))
    ratios = [_by_bands(one, other) for _, one, other in found]
    closed = [ratio for ratio in ratios if ratio is not None]
    known = len(closed) == len(ratios)
    return ResponseComparison(
        response=name,
        unit=found[0][1].unit,
        mean=float(np.mean(differences)),
        rms=float(np.sqrt(np.mean(differences**2))),
        largest=float(differences[largest]),
        first=float(first[largest]),
        second=float(second[largest]),
        place=dict(found[largest][0]),
        by_bands=max(closed) if known else None,
        apart=float(np.mean(np.array(closed) > 1.0)) if known else None,
    )


def _by_bands(one: Lookup, other: Lookup) -> float | None:
    """Return the distance of two values relative to the facing parts of their bands."""
    low, high = sorted((one, other), key=lambda answer: answer.value)
    if low.upper is None or high.lower is None:
        return None
    reach = (low.upper - low.value) + (high.value - high.lower)
    distance = high.value - low.value
    if reach > 0.0:
        return distance / reach
    return math.inf if distance > 0.0 else 0.0


def _left_out(first: ComplianceModel, second: ComplianceModel) -> dict[str, str]:
    return {
        name: "the second model has none"
        for name in first.responses
        if name not in second.responses
    } | {
        name: "the first model has none" for name in second.responses if name not in first.responses
    }


def _remarks(first: ComplianceModel, second: ComplianceModel) -> tuple[str, ...]:
    materials = dict(first.material), dict(second.material)
    odd = [
        name
        for name in dict.fromkeys((*materials[0], *materials[1]))
        if materials[0].get(name) != materials[1].get(name) and name != "name"
    ]
    remarks = [f"The models are of different materials: {', '.join(odd)} differ."] if odd else []
    if first.uncorrected != second.uncorrected:
        old = "first" if first.uncorrected else "second"
        remarks.append(
            f"The {old} model was fitted to finite elements of an older release, not corrected for "
            "discretization; those of the other model were: compliances differ by the corrected error."
        )
    return tuple(remarks)
