"""Designs of experiments by name: which combinations of factor values a study runs."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from regression.plans.design_choice import LARGEST_DESIGN, DesignChoice
from regression.plans.designs_factorial import (
    ROMAN,
    aliased_effects,
    corner_fraction,
    corners_by_generators,
    resolution_of,
)
from regression.plans.designs_space import latin_hypercube_points, sobol_points
from regression.plans.designs_surface import box_behnken, central_composite
from regression.plans.factors import Factor, rounded

# Streams of random numbers drawn from one seed, so that runs and held-out designs differ.
HELD_OUT_STREAM, RUN_STREAM = 0, 1

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Design:
    """A table of runs, before anything is excluded.

    Attributes
    ----------
    runs : (n, k) ndarray
        One run a row [SI], labels as their indices; read-only.
    statement : str
        Its description, in a few words.
    remarks : tuple of str
        Remarks for the user, one sentence each.
    """

    runs: Table
    statement: str
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        runs = np.array(self.runs, dtype=np.float64)
        runs.flags.writeable = False
        object.__setattr__(self, "runs", runs)


def fixed_design(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    """Return the runs of a design that is not random.

    Parameters
    ----------
    factors : sequence of Factor
    choice : DesignChoice
        Of a kind that is not `SPACE_FILLING`.

    Raises
    ------
    InputError
        If the factors do not fit the design.
    """
    makers: dict[str, Callable[[Sequence[Factor], DesignChoice], Design]] = {
        "full factorial": _full_factorial,
        "fractional factorial": _fractional_factorial,
        "central composite": _central_composite,
        "box-behnken": _box_behnken,
        "file": _rows,
    }
    made = makers[choice.kind](factors, choice)
    runs, repeated = without_repeats(made.runs)
    if not repeated:
        return made
    rows = (
        "1 row that repeats another is"
        if repeated == 1
        else f"{repeated} rows that repeat others are"
    )
    remark = f"{rows} left out, because finite element runs that are repeated give the same result."
    statement = _file_statement(len(runs)) if choice.kind == "file" else made.statement
    return Design(runs, statement, (*made.remarks, remark))


def full_factorial(levels: Mapping[str, Sequence[float]]) -> Design:
    """Run every combination of the given levels, the last factor varying fastest.

    Parameters
    ----------
    levels : mapping
        Factor name to its levels.

    Raises
    ------
    InputError
        If the design would be larger than `LARGEST_DESIGN`.

    Examples
    --------
    >>> full_factorial({"web_width": [0.27, 0.33], "pin_length": [0.12, 0.14]}).runs.tolist()
    [[0.27, 0.12], [0.27, 0.14], [0.33, 0.12], [0.33, 0.14]]
    """
    counts = [len(values) for values in levels.values()]
    number = math.prod(counts)
    _check_size(number)
    statement = f"full factorial, {' x '.join(map(str, counts))} = {number} runs"
    runs = np.array(list(itertools.product(*levels.values())), dtype=np.float64)
    return Design(runs, statement)


def space_filling_points(
    factors: Sequence[Factor], kind: str, runs: int, seed: Sequence[int]
) -> Table:
    """Draw the points of a space-filling design in the unit cube; `values_at` maps them to factors.

    Parameters
    ----------
    factors : sequence of Factor
        Choices are equally frequent, as long as no point is left out.
    kind : str
        Of `SPACE_FILLING`.
    runs : int
    seed : sequence of int

    Returns
    -------
    (n, k) ndarray
    """
    draw = latin_hypercube_points if kind == "latin hypercube" else sobol_points
    return draw(runs, [len(factor.labels) for factor in factors], seed)


def space_filling_statement(kind: str, runs: int, seed: int) -> tuple[str, tuple[str, ...]]:
    """Return the statement of a space-filling design, and remarks."""
    if kind == "latin hypercube":
        return f"Latin hypercube (maximin, seed {seed}), {runs} runs", ()
    remarks: tuple[str, ...] = ()
    if runs & (runs - 1):
        lower = 1 << (runs.bit_length() - 1)
        remarks = (
            f"A Sobol sequence is balanced at powers of two: {lower} or {2 * lower} runs fill the box "
            f"more evenly than {runs}.",
        )
    return f"Sobol sequence (scrambled, seed {seed}), {runs} runs", remarks


def check_ranges(factors: Sequence[Factor], kind: str) -> None:
    """Refuse levels between the ends for a design that has values of its own.

    Raises
    ------
    InputError
    """
    for factor in factors:
        if not factor.categorical and not _ends_only(factor):
            raise InputError(
                f"study.factors.{factor.name}: given {len(factor.levels or ())} levels; allowed with "
                f'the design {kind!r} is a range, like {{ from = "{factor.format_value(factor.lowest)}", '
                f'to = "{factor.format_value(factor.highest)}" }}, because it takes its own values there.'
            )


def values_at(factors: Sequence[Factor], points: Table) -> Table:
    """Map points of the unit cube to the ranges; for a choice, to the corresponding label.

    Values are rounded to 12 digits and stay in the range.
    """
    columns = []
    for factor, column in zip(factors, points.T, strict=True):
        if factor.categorical:
            index = np.floor(column * len(factor.labels))
            columns.append(np.clip(index, 0.0, factor.highest))
        else:
            columns.append(_placed(factor, column))
    return np.column_stack(columns)


def _placed(factor: Factor, place: Table) -> Table:
    """Values at positions 0 (lowest) to 1 (highest) of a range; both ends exactly."""
    inner = factor.lowest + place * (factor.highest - factor.lowest)
    values = np.array([rounded(value) for value in inner.tolist()])
    values[place == 0.0], values[place == 1.0] = factor.lowest, factor.highest
    return np.asarray(np.clip(values, factor.lowest, factor.highest))


def without_repeats(values: Table) -> tuple[Table, int]:
    """Return the rows without repeats, in their order, and how many were left out."""
    _, first = np.unique(values, axis=0, return_index=True)
    kept = values[np.sort(first)]
    return kept, len(values) - len(kept)


def _full_factorial(factors: Sequence[Factor], _choice: DesignChoice) -> Design:
    """Every combination of the levels; of a range, its ends."""
    made = full_factorial(
        {factor.name: factor.levels or (factor.lowest, factor.highest) for factor in factors}
    )
    ranges = [factor.name for factor in factors if factor.levels is None]
    if not ranges:
        return made
    remark = (
        f"A full factorial runs the ends of ranges ({', '.join(ranges)}); give a factor three levels or "
        "more for a curved equation."
    )
    return Design(made.runs, made.statement, (remark,))


def _fractional_factorial(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    """A fraction of the corners; choices of more than two labels are crossed with it."""
    check_ranges(factors, choice.kind)
    two_level = [factor for factor in factors if len(factor.labels) <= 2]
    number = len(two_level)
    if number < 3:
        raise InputError(
            f"study.design: given {choice.kind!r} with {number} factors of two levels; allowed are 3 or "
            "more, because there is nothing to leave out of fewer."
        )
    if choice.generators is not None:
        coded = corners_by_generators(choice.generators, number)
    else:
        coded = corner_fraction(number, choice.resolution or 4)
    found = resolution_of(coded)
    if found is not None and found < 3:
        raise InputError(
            f"study.generators: given {choice.generators!r}; allowed are generators in which no two "
            "factors vary together."
        )
    left_out = number - round(math.log2(len(coded)))
    power = f"2^({number}-{left_out})" if left_out else f"2^{number}"
    quality = f"resolution {ROMAN.get(found, str(found))}" if found else "all corners"
    runs = _crossed(factors, two_level, 0.5 + 0.5 * coded)
    groups = aliased_effects(coded, tuple(factor.name for factor in two_level))
    remarks = (f"Confounded effects: {'; '.join(groups)}.",) if groups else ()
    return Design(runs, f"fractional factorial {power}, {quality}, {len(runs)} runs", remarks)


def _central_composite(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    face = choice.face or "faced"
    numbers = [factor for factor in factors if not factor.categorical]
    if face != "faced":
        check_ranges(numbers, f"central composite, {face}")
    coded = central_composite(len(numbers), face, choice.resolution)
    levels = None if face != "faced" else [_three_levels(f, choice.kind) for f in numbers]
    values = _crossed(factors, numbers, 0.5 + 0.5 * coded, levels)
    scaled = ", scaled to fit the ranges" if face == "circumscribed" else ""
    corners = (
        "" if choice.resolution is None else f", corners of resolution {ROMAN[choice.resolution]}"
    )
    return Design(values, f"central composite, {face}{scaled}{corners}, {len(values)} runs")


def _box_behnken(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    numbers = [factor for factor in factors if not factor.categorical]
    coded = box_behnken(len(numbers))
    levels = [_three_levels(factor, choice.kind) for factor in numbers]
    values = _crossed(factors, numbers, 0.5 + 0.5 * coded, levels)
    return Design(values, f"Box-Behnken, center once, {len(values)} runs")


def _rows(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    assert choice.rows is not None
    for place, row in enumerate(choice.rows, start=1):
        for factor, value in zip(factors, row, strict=True):
            if not factor.lowest <= value <= factor.highest:
                raise InputError(
                    f"study.file: given {factor.name} = {factor.format_value(value)} in row {place}; allowed "
                    f"is the factor's range, {factor.range_text}."
                )
    _check_size(len(choice.rows))
    return Design(np.array(choice.rows), _file_statement(len(choice.rows)))


def _file_statement(runs: int) -> str:
    return f"design from a file, {runs} run{'' if runs == 1 else 's'}"


def _crossed(
    factors: Sequence[Factor],
    varied: Sequence[Factor],
    places: Table,
    levels: Sequence[tuple[float, float, float]] | None = None,
) -> Table:
    """Repeat a design of some factors for every combination of the others' labels.

    `places` are 0 to 1 in each range, of labels 0 and 1; if `levels` are given, 0, 0.5 and 1 mean
    these.
    """
    columns: dict[str, Table] = {}
    for number, (factor, place) in enumerate(zip(varied, places.T, strict=True)):
        if factor.categorical:
            columns[factor.name] = np.round(place * factor.highest)
        elif levels is not None:
            columns[factor.name] = np.array(levels[number])[np.round(2.0 * place).astype(int)]
        else:
            columns[factor.name] = _placed(factor, place)
    others = [factor for factor in factors if factor.name not in columns]
    combinations = list(itertools.product(*(factor.levels or () for factor in others)))
    _check_size(len(combinations) * len(places))
    table = np.empty((len(combinations), len(places), len(factors)))
    for column, factor in enumerate(factors):
        if factor.name in columns:
            table[:, :, column] = columns[factor.name]
        else:
            values = [combination[others.index(factor)] for combination in combinations]
            table[:, :, column] = np.array(values)[:, None]
    return table.reshape(-1, len(factors))


def _three_levels(factor: Factor, kind: str) -> tuple[float, float, float]:
    """Ends and middle of a factor: its own three levels, or its range's."""
    if factor.levels is not None and len(factor.levels) == 3:
        low, middle, high = sorted(factor.levels)
        return low, middle, high
    if not _ends_only(factor):
        raise InputError(
            f"study.factors.{factor.name}: given {len(factor.levels or ())} levels; allowed with the "
            f"design {kind!r} are three, or a range, because it runs ends and middle."
        )
    return factor.lowest, rounded(0.5 * (factor.lowest + factor.highest)), factor.highest


def _ends_only(factor: Factor) -> bool:
    """Whether a factor is a range, or two levels that are its ends."""
    return factor.levels is None or set(factor.levels) == {factor.lowest, factor.highest}


def _check_size(number: int) -> None:
    if number > LARGEST_DESIGN:
        raise InputError(
            f"study.design: given {number} runs; allowed are at most {LARGEST_DESIGN}, because each is "
            "a finite element run, and no equation needs more."
        )
