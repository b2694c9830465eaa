"""Designs of experiments by name: which combinations of factor values a study runs."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from crankbase.array_checks import Array, Flags, Integers
from crankbase.errors import InputError
from crankbase.even_points import centered_discrepancy, latin_hypercube, sobol_sequence
from crankbase.results import Number, Quantity, Result, result
from crankbase.sentences import kept
from crankbase.summaries import frozen
from regression.plans.factors import Factor, rounded

# Latin hypercubes tried, of which the one with the largest smallest distance is taken; fewer of large
# ones, which take long and gain little: so many points in all.
TRIES, POINTS_TRIED = 400, 100_000
# Up to so many points, distances are found as scipy finds them, without its tenth of a second of loading;
# from the larger number on, near points are found by a tree: the table of distances grows large.
LOADING_PAYS, FEW_POINTS = 200, 1500
# More points than this are not thinned by distance: the table of distances would not fit.
LARGEST_THINNED = 4000

# Part of a range at each end from which points are moved to it.
OUTER = 0.25

# The search for points that can be used ends at so many for each one wanted, or at this many in all if
# that is less; it never ends before the smallest number.
SEARCHED_EACH, SEARCHED, SEARCHED_AT_LEAST = 50, 100_000, 2000

Points = Array


def hypercube_trials(count: int) -> int:
    """Return how many Latin hypercubes of a number of points are tried."""
    return max(1, min(TRIES, POINTS_TRIED // count))


def latin_hypercube_points(
    count: int, choices: Sequence[int], seed: Sequence[int], tries: int | None = None
) -> Points:
    """Draw a Latin hypercube (n, k) within [0, 1): each column in n strata, one point in each.

    Of `tries` hypercubes (`hypercube_trials` by default) the one is used whose
    nearest two points are farthest apart (maximin). `choices` has the number of choices of each column,
    0 for a continuous one.
    """
    random = np.random.default_rng(list(seed)).spawn(1)[0]
    best = _at_choices(latin_hypercube(count, len(choices), random), choices)
    if count == 1 or len(choices) == 1:
        return best
    best_distance = smallest_distance(best)
    for _ in range((tries or hypercube_trials(count)) - 1):
        candidate = _at_choices(latin_hypercube(count, len(choices), random), choices)
        distance = smallest_distance(candidate)
        if distance > best_distance:
            best, best_distance = candidate, distance
    return best


def with_points_at_ends(points: Points, choices: Sequence[int]) -> Points:
    """Move every second point (n, k) to the ends of those ranges in whose outer quarters it is; choices stay.

    There polynomials have their largest errors, and a space-filling design has no points.
    """
    moved = points.copy()
    outer = points[1::2]
    ends = np.where(outer < OUTER, 0.0, np.where(outer > 1.0 - OUTER, 1.0, outer))
    moved[1::2] = np.where(np.array(choices) > 0, outer, ends)
    return moved


def sobol_points(count: int, choices: Sequence[int], seed: Sequence[int]) -> Points:
    """First points (n, k) of a scrambled Sobol sequence; arguments as of `latin_hypercube_points`."""
    start = np.random.default_rng(list(seed))
    return _at_choices(sobol_sequence(count, len(choices), start), choices)


def _at_choices(points: Points, choices: Sequence[int]) -> Points:
    placed = points.copy()
    for column, number in enumerate(choices):
        if number:
            placed[:, column] = (np.floor(points[:, column] * number) + 0.5) / number
    return placed


def smallest_distance(points: Points) -> float:
    """Return the distance of the two nearest points."""
    if len(points) <= LOADING_PAYS:
        return float(distances_between(points).min())
    from scipy.spatial import cKDTree
    from scipy.spatial.distance import pdist

    if len(points) <= FEW_POINTS:
        return math.sqrt(pdist(points, "sqeuclidean").min())
    distances, _ = cKDTree(points).query(points, k=[2])
    return float(np.min(distances))


def distances_between(points: Points) -> Array:
    """Distances (n, n) between points, infinite to themselves."""
    if len(points) <= LOADING_PAYS:
        squares = np.diag(np.full(len(points), np.inf))
        for column in points.T:
            squares += (column[:, None] - column) ** 2
        return np.sqrt(squares)
    from scipy.spatial.distance import cdist

    distances = cdist(points, points)
    np.fill_diagonal(distances, np.inf)
    return distances


def well_spaced_subset(points: Points, count: int) -> Integers:
    """Indices, ascending, of `count` points (n, k) far apart: the nearest ones are dropped one by one."""
    number = len(points)
    if number > LARGEST_THINNED:
        return np.arange(count)
    distances = distances_between(points)
    staying = np.ones(number, dtype=bool)
    for _ in range(number - count):
        nearest = distances.min(axis=1)
        first = int(np.argmin(nearest))
        second = int(np.argmin(distances[first]))
        # Of the two, the one whose next neighbor is nearer goes.
        others = np.sort(distances[[first, second]], axis=1)[:, 1]
        gone = first if others[0] <= others[1] else second
        distances[gone, :] = distances[:, gone] = np.inf
        staying[gone] = False
    return np.flatnonzero(staying)


def draw_feasible_points(
    draw: Callable[[int], Points],
    possible: Callable[[Points], Flags],
    count: int,
    *,
    in_order: bool,
) -> tuple[Points, Flags, Flags] | None:
    """Draw points (n, k) until `count` of them are possible; None if so few are that the search is abandoned.

    Returns all points drawn, which of them are used, and which are impossible. With `in_order` the
    first possible ones are used (a sequence), not those farthest apart.
    """
    number = count
    most = max(SEARCHED_AT_LEAST, min(SEARCHED, SEARCHED_EACH * count))
    while True:
        points = draw(number)
        usable = possible(points)
        feasible = int(np.count_nonzero(usable))
        if feasible >= count:
            taken = np.zeros(number, dtype=bool)
            indices = np.flatnonzero(usable)
            chosen = np.arange(count) if in_order else well_spaced_subset(points[indices], count)
            taken[indices[chosen]] = True
            return points, taken, ~usable
        if number >= most:
            return None
        share = max(feasible, 0.5) / number
        number = min(most, max(number + 1, math.ceil(1.1 * count / share)))


# Correlations below this are round-off.
NONE = 1e-12


@result("distance", "discrepancy", "correlation")
class DesignQuality(Result):
    """Quality of runs before any has a result, in coordinates 0 to 1 over each range."""

    # Of the two nearest runs; labels of a choice of q are 1/q apart.
    distance: Annotated[float | None, Quantity("1")]
    # Centered L2, squared (Hickernell 1998), of the factors that are numbers, and its mean for as many random
    # points: ((5/4)^k - (13/12)^k) / n.
    discrepancy: Number
    random_discrepancy: Number
    # Largest absolute one of two factors, choices of two labels among them.
    correlation: Annotated[float | None, Quantity("1")]
    correlated: tuple[str, ...]


def design_quality(factors: Sequence[Factor], values: Array) -> DesignQuality:
    """Assess runs (n, k) [SI], of a choice the label's index, by distance, discrepancy and correlation."""
    lowest = np.array([factor.lowest for factor in factors])
    spans = np.array([factor.highest for factor in factors]) - lowest
    points = (values - lowest) / spans
    numbers = [place for place, factor in enumerate(factors) if not factor.labels]
    apart = points.copy()
    for place, factor in enumerate(factors):
        if factor.labels:
            apart[:, place] = values[:, place] / len(factor.labels)
    discrepancy = centered_discrepancy(np.clip(points[:, numbers], 0.0, 1.0))
    count, width = len(values), len(numbers)
    largest, pair = _largest_correlation(factors, points)
    return DesignQuality(
        distance=smallest_distance(apart) if count > 1 else None,
        discrepancy=discrepancy,
        random_discrepancy=((5.0 / 4.0) ** width - (13.0 / 12.0) ** width) / count,
        correlation=largest,
        correlated=pair,
    )


def _largest_correlation(
    factors: Sequence[Factor], points: Array
) -> tuple[float | None, tuple[str, ...]]:
    ordered = [
        place
        for place, factor in enumerate(factors)
        if len(factor.labels) <= 2 and np.ptp(points[:, place]) > 0.0
    ]
    if len(ordered) < 2:
        return None, ()
    table = np.abs(np.corrcoef(points[:, ordered].T))
    largest, first, second = max(
        (float(table[i, j]), -i, -j) for i, j in itertools.combinations(range(len(ordered)), 2)
    )
    if largest < NONE:
        return 0.0, ()
    return largest, (factors[ordered[-first]].name, factors[ordered[-second]].name)


ROMAN = {3: "III", 4: "IV", 5: "V", 6: "VI", 7: "VII", 8: "VIII"}
# Products of columns examined for the shortest word of a fraction.
LARGEST_SEARCH = 300_000

Coded = Array


def corner_fraction(factors: int, resolution: int) -> Coded:
    """Regular fraction (n, factors) of the corners of a cube, -1 and 1, of at least a resolution of 3 to 8.

    No product of fewer columns than the resolution is constant. The smallest found by
    `pydoe.fracfact_by_res`; all corners if no fraction is sufficient; `InputError` if none is found.
    """
    from pydoe import ff2n, fracfact_by_res

    if factors < 3:
        return np.asarray(ff2n(factors), dtype=np.float64)
    try:
        return np.asarray(fracfact_by_res(factors, resolution), dtype=np.float64)
    except ValueError as error:
        raise InputError(
            f"study.resolution: given {ROMAN[resolution]} for {factors} factors; allowed is a lower "
            f"resolution or fewer factors, because no such design is known ({error})."
        ) from None


def corners_by_generators(generators: str, factors: int) -> Coded:
    """Fraction that generators such as "a b c abc" describe.

    One word for each factor: single letters a, b, c ... vary freely, longer words are their products,
    with - in front for the opposite sign. `InputError` if they are others, or for another number of
    factors.
    """
    from pydoe import fracfact

    words = generators.split()
    try:
        if len(words) != factors:
            raise ValueError(f"{len(words)} words for {factors} factors of two levels")
        corners = np.asarray(fracfact(" ".join(words)), dtype=np.float64)
    except (ValueError, IndexError) as error:
        raise InputError(
            f"study.generators: given {generators!r}; allowed is one word for each factor, like "
            f'"a b c abc" ({str(error).rstrip(".")}).'
        ) from None
    return corners


def resolution_of(design: Coded) -> int | None:
    """Length of the shortest product of columns (n, k) of -1 and 1 that is constant.

    None for all corners, where nothing is confounded, or if the search up to `LARGEST_SEARCH` products
    finds none.
    """
    columns, everything = _as_bits(design)
    if len(np.unique(design, axis=0)) == 2 ** design.shape[1]:
        return None
    searched = 0
    for length in range(1, len(columns) + 1):
        for chosen in itertools.combinations(columns, length):
            product = 0
            for column in chosen:
                product ^= column
            if product in (0, everything):
                return length
            searched += 1
            if searched > LARGEST_SEARCH:
                return None
    return None


def aliased_effects(design: Coded, names: tuple[str, ...]) -> tuple[str, ...]:
    """List main effects and two-factor interactions confounded in a fraction (n, k) of -1 and 1.

    In groups such as ``"web_width = pin_length x web_thickness"``; groups of one effect are left out.
    """
    columns, everything = _as_bits(design)
    groups: dict[int, list[str]] = {}
    for length in (1, 2):
        for places in itertools.combinations(range(len(columns)), length):
            product = 0
            for place in places:
                product ^= columns[place]
            # An effect and its negative cannot be told apart either; a product of two columns is
            # the complement of the bits' difference.
            key = min(product, product ^ everything)
            groups.setdefault(key, []).append(" x ".join(names[place] for place in places))
    return tuple(" = ".join(group) for group in groups.values() if len(group) > 1)


def _as_bits(design: Coded) -> tuple[list[int], int]:
    """Write each column as an integer, one bit for each run, and the integer of all ones."""
    bits = [int("".join("1" if value > 0.0 else "0" for value in column), 2) for column in design.T]
    return bits, (1 << len(design)) - 1


# A study of more finite element runs than this is a slip of the pen, and planning it takes long.
LARGEST_DESIGN = 20_000

DesignKind = Literal[
    "full factorial",
    "fractional factorial",
    "central composite",
    "box-behnken",
    "latin hypercube",
    "sobol",
    "file",
]
SPACE_FILLING = ("latin hypercube", "sobol")
# What some designs take beside the factors, and which.
TAKERS: Mapping[str, tuple[str, ...]] = {
    "runs": SPACE_FILLING,
    "resolution": ("fractional factorial", "central composite"),
    "generators": ("fractional factorial",),
    "face": ("central composite",),
    "file": ("file",),
}


@frozen("kind", "runs")
class DesignChoice:
    """A design of experiments with its parameters.

    Parameters
    ----------
    kind : str
        As in `DesignKind`.
    runs : int, optional
        Number of runs of a Latin hypercube or a Sobol sequence, at most `LARGEST_DESIGN`.
    resolution : int, optional
        Of a fractional factorial (4 if neither it nor generators are given), or of the fraction of a
        central composite design's corners (all corners by default); 3 to 8.
    generators : str, optional
        Of a fractional factorial, instead of a resolution: "a b c abc".
    face : str, optional
        Of a central composite design: "faced" (default), "inscribed" or "circumscribed".
    rows : tuple of tuple of float, optional
        Runs of the design "file" [SI], one value for each factor.
    """

    kind: str = "full factorial"
    runs: int | None = None
    resolution: int | None = None
    generators: str | None = None
    face: str | None = None
    rows: tuple[tuple[float, ...], ...] | None = None


FACES = ("faced", "inscribed", "circumscribed")
# pydoe builds these from a list of all pairs; 30 factors make 1741 runs.
MOST_FACTORS = 30


def central_composite(factors: int, face: str, resolution: int | None) -> Array:
    """Corners, stars and the center of a box, (n, factors) within -1 to 1.

    The center stands once, because finite elements repeat exactly. "faced": corners and the middles of
    the faces, three levels. "inscribed": stars in the middles of the faces and corners moved in to 1 /
    alpha, rotatable with alpha = (number of corners)^(1/4), five levels. "circumscribed" has its stars
    outside the corners; scaled down until they are in the box, it is the inscribed design. `resolution`
    is that of the fraction of the corners, None for all. `InputError` if there are too few factors.
    """
    from pydoe import ff2n, star

    if not 2 <= factors <= MOST_FACTORS:
        raise InputError(
            f"study.design: given 'central composite' with {factors} factors that are numbers; allowed "
            f"are 2 to {MOST_FACTORS}."
        )
    corners = (
        np.asarray(ff2n(factors), dtype=np.float64)
        if resolution is None
        else corner_fraction(factors, resolution)
    )
    stars, _ = star(factors)
    if face != "faced":
        corners = corners / len(corners) ** 0.25
    return np.vstack([corners, stars, np.zeros((1, factors))])


def box_behnken(factors: int) -> Array:
    """Middles of the edges in each plane of two factors, and the center: (2 k (k - 1) + 1, k).

    `InputError` if there are fewer than 3 factors.
    """
    from pydoe import bbdesign

    if not 3 <= factors <= MOST_FACTORS:
        raise InputError(
            f"study.design: given 'box-behnken' with {factors} factors that are numbers; allowed are "
            f"3 to {MOST_FACTORS}, because it varies two at a time while others rest in the middle."
        )
    return np.asarray(bbdesign(factors, center=1), dtype=np.float64)


# Streams of random numbers drawn from one seed, so that runs and held-out designs differ.
HELD_OUT_STREAM, RUN_STREAM = 0, 1

Table = Array


@dataclass(frozen=True, eq=False)
class Design:
    """A table of runs (n, k), one a row [SI], labels as their indices, before anything is excluded.

    The statement describes it in a few words; remarks are for the user, one sentence each.
    """

    runs: Table
    statement: str
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        runs = np.array(self.runs, dtype=np.float64)
        runs.flags.writeable = False
        object.__setattr__(self, "runs", runs)


def fixed_design(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    """Runs of a design that is not random; `InputError` if the factors do not fit it."""
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

    `InputError` if the design would be larger than `LARGEST_DESIGN`.

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
    """Draw the points (n, k) of a space-filling design in the unit cube; `values_at` maps them to factors.

    Choices are equally frequent, as long as no point is left out.
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


# Values and slopes in designs with slopes, for each coefficient of a cubic equation.
ENOUGH = 1.5


def runs_with_slopes(factors: Sequence[Factor]) -> int:
    """Return the number of runs whose values and slopes are `ENOUGH` for a cubic equation.

    Examples
    --------
    >>> [runs_with_slopes([Factor(f"x{n}", "m", 1.0, 2.0) for n in range(k)]) for k in (2, 3, 5, 7)]
    [5, 8, 14, 23]
    """
    numbers = sum(not factor.labels for factor in factors)
    columns = sum(max(1, len(factor.labels) - 1) for factor in factors)
    return math.ceil(ENOUGH * math.comb(columns + 3, 3) / (1 + numbers))


def check_ranges(factors: Sequence[Factor], kind: str) -> None:
    """Refuse levels between the ends for a design that has values of its own (`InputError`)."""
    for factor in factors:
        if not factor.labels and not _ends_only(factor):
            ends = [kept(factor.format_value(end)) for end in (factor.lowest, factor.highest)]
            raise InputError(
                f"study.factors.{factor.name}: given {len(factor.levels or ())} levels; allowed with "
                f'the design {kind!r} is a range, like {{ from = "{ends[0]}", to = "{ends[1]}" }}, because '
                "it takes its own values there."
            )


def values_at(factors: Sequence[Factor], points: Table) -> Table:
    """Map points of the unit cube to the ranges; for a choice, to the corresponding label.

    Values are rounded to 12 digits and stay in the range.
    """
    columns = []
    for factor, column in zip(factors, points.T, strict=True):
        if factor.labels:
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
        f"A full factorial runs the ends of ranges ({', '.join(ranges)}); without slopes a curved equation "
        "takes three levels or more of a factor."
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
    shortest = resolution_of(coded)
    if shortest is not None and shortest < 3:
        raise InputError(
            f"study.generators: given {choice.generators!r}; allowed are generators in which no two "
            "factors vary together."
        )
    left_out = number - round(math.log2(len(coded)))
    power = f"2^({number}-{left_out})" if left_out else f"2^{number}"
    quality = f"resolution {ROMAN.get(shortest, str(shortest))}" if shortest else "all corners"
    runs = _crossed(factors, two_level, coded)
    groups = aliased_effects(coded, tuple(factor.name for factor in two_level))
    remarks = (f"Confounded effects: {'; '.join(groups)}.",) if groups else ()
    return Design(runs, f"fractional factorial {power}, {quality}, {len(runs)} runs", remarks)


def _central_composite(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    face = choice.face or "faced"
    numbers = [factor for factor in factors if not factor.labels]
    if face != "faced":
        check_ranges(numbers, f"central composite, {face}")
    coded = central_composite(len(numbers), face, choice.resolution)
    levels = None if face != "faced" else [_three_levels(f, choice.kind) for f in numbers]
    values = _crossed(factors, numbers, coded, levels)
    scaled = ", scaled to fit the ranges" if face == "circumscribed" else ""
    corners = (
        "" if choice.resolution is None else f", corners of resolution {ROMAN[choice.resolution]}"
    )
    return Design(values, f"central composite, {face}{scaled}{corners}, {len(values)} runs")


def _box_behnken(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    numbers = [factor for factor in factors if not factor.labels]
    coded = box_behnken(len(numbers))
    levels = [_three_levels(factor, choice.kind) for factor in numbers]
    values = _crossed(factors, numbers, coded, levels)
    return Design(values, f"Box-Behnken, center once, {len(values)} runs")


def _rows(factors: Sequence[Factor], choice: DesignChoice) -> Design:
    assert choice.rows is not None
    for place, row in enumerate(choice.rows, start=1):
        for factor, value in zip(factors, row, strict=True):
            if not factor.lowest <= value <= factor.highest:
                raise InputError(
                    f"study.file: given {factor.name} = {kept(factor.format_value(value))} in row {place}; "
                    f"allowed is the factor's range, {kept(factor.range_text)}."
                )
    _check_size(len(choice.rows))
    return Design(np.array(choice.rows), _file_statement(len(choice.rows)))


def _file_statement(runs: int) -> str:
    return f"design from a file, {runs} run{'' if runs == 1 else 's'}"


def _crossed(
    factors: Sequence[Factor],
    varied: Sequence[Factor],
    coded: Coded,
    levels: Sequence[tuple[float, float, float]] | None = None,
) -> Table:
    """Repeat a design of some factors for every combination of the others' labels.

    `coded` is -1 to 1 in each range, of labels -1 and 1; -1, 0 and 1 mean `levels` if there are any.
    """
    columns: dict[str, Table] = {}
    places = 0.5 + 0.5 * coded
    for number, (factor, place) in enumerate(zip(varied, places.T, strict=True)):
        if factor.labels:
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
