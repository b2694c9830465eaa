"""Uncertain values of a chain, and the bounds and samples of its frequencies and amplitudes."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, positive_vector
from crankbase.choices import (
    check_choice,
    check_one_each,
    check_some,
    is_whole_within,
    number_within,
    whole_number,
    whole_within,
)
from crankbase.diagrams import BLUE, GRAY, RED, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.even_points import latin_hypercube
from crankbase.frames import Axes
from crankbase.results import Internal, Number, Result, result
from dynamics.chains.chain import Chain
from dynamics.chains.editing import find_node

Kind = Literal[
    "compliance",
    "stiffness",
    "inertia",
    "distributed inertia",
    "ground stiffness",
    "damping",
    "loss factor",
    "ground damping",
    "dashpot damping",
    "all damping",
]
# Field of the chain that a kind scales, and the power of the factor that it takes.
FIELDS: dict[str, tuple[str, int]] = {
    "compliance": ("stiffness", -1),
    "stiffness": ("stiffness", 1),
    "inertia": ("inertia", 1),
    "distributed inertia": ("distributed_inertia", 1),
    "ground stiffness": ("ground", 1),
    "damping": ("damping", 1),
    "loss factor": ("loss_factor", 1),
    "ground damping": ("ground_damping", 1),
    "dashpot damping": ("dashpots", 1),
}
ALL_DAMPING = "all damping"
DAMPINGS = ("damping", "loss_factor", "ground_damping", "dashpots")


@result("name", "kind", "low", "high", "places", eq=True)
class Spread(Result):
    """A range of factors on one kind of value, everywhere or at some elements or nodes together.

    Parameters
    ----------
    kind : str
        One of `FIELDS`: compliance, stiffness, damping, loss factor and distributed inertia belong
        to elements, inertia, ground stiffness and ground damping to nodes. Or "all damping", of
        the whole chain.
    low, high : float
        Least and largest factor on the nominal value; 1 is between them.
    places : tuple of int or str, optional
        Elements, nodes or dashpots by number from 0 or by name; all by default.
    name : str
        Its name; the kind by default.

    Raises
    ------
    InputError
        If the kind is unknown or 0 < low <= 1 <= high is not so.
    """

    kind: Kind
    low: Number
    high: Number
    places: Internal[tuple[int | str, ...] | None] = None
    name: str = ""

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, (*FIELDS, ALL_DAMPING), "chains have these")
        if self.kind == ALL_DAMPING and self.places is not None:
            raise InputError(
                f"places: given {self.places} for all damping; allowed are none, because it is that "
                "of all nodes and elements."
            )
        ends = positive_vector(
            f"spread of {self.kind}",
            (self.low, self.high),
            "",
            "it is a factor on a positive value",
        )
        if not ends[0] <= 1.0 <= ends[1]:
            raise InputError(
                f"spread of {self.kind}: given factors {ends[0]:g} to {ends[1]:g}; allowed are a low "
                "one up to 1 and a high one from 1, because the nominal value is possible too."
            )
        if not self.name:
            object.__setattr__(self, "name", self.kind)

    @classmethod
    def within(
        cls, kind: Kind, share: float, places: tuple[int | str, ...] | None = None, name: str = ""
    ) -> "Spread":
        """Make a spread of plus or minus a share, such as 0.05 for 5 %.

        Raises
        ------
        InputError
            If the share is negative, or 1 or more.
        """
        return cls(kind, 1.0 - share, 1.0 + share, places, name)


def scaled_chain(chain: Chain, spreads: Sequence[Spread], factors: ArrayLike) -> Chain:
    """Return a chain with its values multiplied by factors.

    Parameters
    ----------
    spreads : sequence of p Spread
        They state what each factor acts on; a value with two factors gets both.
    factors : array_like of shape (p,)
    """
    sizes = positive_vector("factors", factors, "", "it is a factor on a positive value")
    scales = scale_factors(chain, spreads, sizes[np.newaxis])
    changed = {
        name: getattr(chain, name) * scale[0]
        for name, scale in scales.items()
        if name != "dashpots"
    }
    dashpots = [
        replace(dashpot, damping=dashpot.damping * scale)
        for dashpot, scale in zip(chain.dashpots, scales["dashpots"][0].tolist(), strict=True)
    ]
    return replace(chain, dashpots=tuple(dashpots), **changed)


def scale_factors(chain: Chain, spreads: Sequence[Spread], factors: Array) -> dict[str, Array]:
    """Return for each field of the chain the scale factors of its values, (N, size) each."""
    check_one_each("factors", factors.shape[1], len(spreads), "spreads")
    fields = (*dict.fromkeys(field for field, _ in FIELDS.values()),)
    scales = {field: np.ones((len(factors), len(getattr(chain, field)))) for field in fields}
    for spread, column in zip(spreads, factors.T, strict=True):
        if spread.kind == ALL_DAMPING:
            for field in DAMPINGS:
                scales[field] *= column[:, np.newaxis]
            continue
        field, power = FIELDS[spread.kind]
        scales[field][:, spread_indices(chain, spread)] *= column[:, np.newaxis] ** power
    return scales


def spread_indices(chain: Chain, spread: Spread) -> list[int]:
    """Return the indices of the elements, nodes or dashpots that a spread acts on."""
    field, _ = FIELDS[spread.kind]
    count = len(getattr(chain, field))
    if spread.places is None:
        return list(range(count))
    if field in ("inertia", "ground", "ground_damping"):
        return [find_node(chain, place, f"spread of {spread.name}") for place in spread.places]
    names = chain.elements if field != "dashpots" else ()
    numbers = [names.index(p) if isinstance(p, str) and p in names else p for p in spread.places]
    for number in numbers:
        if not is_whole_within(number, 0, count - 1):
            known = f" and {', '.join(names)}" if names else ""
            raise InputError(
                f"spread of {spread.name}: given {number!r}; allowed are the whole numbers 0 to "
                f"{count - 1}{known}, because the chain has no others."
            )
    return [int(number) for number in numbers]


STIFF = ("stiffness", "ground")
HEAVY = ("inertia", "distributed_inertia")
DEFAULT_SAMPLES, DEFAULT_SEED = 200, 0
# Samples of a result that is calculated for one chain after another.
MOST_CALCULATED = 100_000


@result("values", "nominal", "spreads")
class Samples:
    """Results of many possible systems.

    Parameters
    ----------
    spreads : tuple of p Spread
    factors : ndarray of shape (N, p)
        Of each sample.
    values : ndarray of shape (N, ...)
        Result of each sample; inf where it is unbounded.
    nominal : ndarray of shape (...)
        Result with all factors 1.
    """

    spreads: tuple[Spread, ...]
    factors: Array
    values: Array
    nominal: Array

    def percentile(self, percent: float) -> Array:
        """Return the value that a given percentage of the samples does not exceed, shape (...).

        It is one of the samples, the first that reaches that share, so inf is kept.

        Raises
        ------
        InputError
            If the percentage is out of range.
        """
        number_within("percent", percent, 0.0, 100.0, "", "it is a share")
        return np.asarray(np.percentile(self.values, percent, axis=0, method="inverted_cdf"))

    @property
    def lowest(self) -> Array:
        """Lowest of all samples, shape (...)."""
        return np.asarray(np.min(self.values, axis=0))

    @property
    def highest(self) -> Array:
        """Highest of all samples, shape (...)."""
        return np.asarray(np.max(self.values, axis=0))

    def plot(
        self,
        axes: Axes | None = None,
        place: int = 0,
        *,
        label: str = "result [SI]",
        bins: int = 20,
    ) -> Axes:
        """Draw the distribution of one result, with the nominal value and the middle 90 percent.

        Parameters
        ----------
        place : int, optional
            Which of several results, from 0; several dimensions are counted in rows.
        label : str, optional
            Of the axis, including the unit.
        bins : int, optional
            Number of bars.

        Returns
        -------
        matplotlib.axes.Axes
            Unbounded samples are counted in the title, not drawn.

        Raises
        ------
        InputError
            If there is no such result, no sample of it is bounded, or the number of bars is not 1 or
            more.
        """
        columns = self.values.reshape(len(self.values), -1)
        number = whole_within(
            "place", place, 0, columns.shape[1] - 1, "each sample has that many results"
        )
        bars = whole_number("bins", bins, 1, "samples are counted in bars")
        results = columns[:, number]
        bounded = results[np.isfinite(results)]
        if not bounded.size:
            raise InputError(
                f"place: given {place}, where all samples are unbounded; allowed is one with bounded "
                "samples, because bars show these."
            )
        axes = new_axes(axes)
        axes.hist(bounded, bins=bars, color=BLUE, alpha=0.7, label="samples")
        nominal = float(np.ravel(self.nominal)[number])
        if np.isfinite(nominal):
            axes.axvline(nominal, color=RED, linewidth=1.4, label="nominal")
        low, high = np.percentile(bounded, [5.0, 95.0])
        axes.axvspan(low, high, color=GRAY, alpha=0.15, zorder=0, label="middle 90 %")
        axes.set_xlabel(label)
        axes.set_ylabel("samples [1]")
        lost = results.size - bounded.size
        write_title(axes, f"{results.size} samples" + (f", {lost} unbounded" if lost else ""))
        legend_inside(axes)
        return axes


def sampled_factors(
    spreads: Sequence[Spread], samples: int = DEFAULT_SAMPLES, seed: int = DEFAULT_SEED
) -> Array:
    """Draw factors by a Latin hypercube: each of N equal shares of a spread has one sample.

    Parameters
    ----------
    spreads : sequence of p Spread
    samples : int
        N.
    seed : int
        The same seed draws the same factors.

    Returns
    -------
    ndarray of shape (N, p)
        Uniform over the logarithm, so that a compliance and its reciprocal stiffness have the same
        distribution.
    """
    check_some("spreads", spreads, "nothing varies without")
    count = whole_number("samples", samples, 2, "a range has two ends")
    start = whole_number("seed", seed, 0, "random numbers start from one")
    drawn = latin_hypercube(count, len(spreads), np.random.default_rng(start).spawn(1)[0])
    low, high = np.log([[spread.low, spread.high] for spread in spreads]).T
    return np.asarray(np.exp(low + drawn * (high - low)))


def frequency_samples(
    chain: Chain,
    spreads: Sequence[Spread],
    samples: int = DEFAULT_SAMPLES,
    seed: int = DEFAULT_SEED,
) -> Samples:
    """Find the natural frequencies of many possible chains, all at once.

    Parameters
    ----------
    spreads, samples, seed
        As for `sampled_factors`.

    Returns
    -------
    Samples
        Of frequencies [Hz], (N, q) ascending in each sample: where two modes cross, the index follows
        the frequency, not the shape.
    """
    factors = sampled_factors(spreads, samples, seed)
    both = _frequencies(chain, spreads, np.vstack((np.ones(len(spreads)), factors)))
    return Samples(tuple(spreads), factors, both[1:], both[0])


def frequency_bounds(
    chain: Chain, spreads: Sequence[Spread], others: Sequence[Chain] = ()
) -> tuple[Array, Array]:
    """Find the lowest and highest possible natural frequencies, exactly.

    Parameters
    ----------
    spreads : sequence of Spread
    others : sequence of Chain, optional
        Other possible chains, such as in bearings of other stiffness: with the same nodes and the
        same spreads. The bounds hold for all of them.

    Returns
    -------
    low, high : ndarray of shape (q,)
        [Hz].

    Raises
    ------
    InputError
        If an element or node does not exist.

    Notes
    -----
    Each squared frequency is a minimum over subspaces of a maximum of x' K x / x' M x (Courant and
    Fischer). A stiffness, of an element or to ground, that grows adds k (c' x)^2 to the numerator
    and an inertia that grows adds to the denominator, so the quotient increases with the first and
    decreases with the second for every x, and so does every minimum of maxima. All frequencies are
    therefore lowest with all stiffnesses least and all inertias largest, and highest in the
    opposite case: two corners of the box of factors bound all of it.
    """
    ends = np.array([[spread.low, spread.high] for spread in spreads]).reshape(-1, 2)
    # A larger factor of these lowers the frequencies.
    of_chain = [FIELDS.get(spread.kind, ("", 0)) for spread in spreads]
    softer = np.array(
        [(field in STIFF and power < 0) or field in HEAVY for field, power in of_chain], dtype=bool
    )
    lowest = np.where(softer, ends[:, 1], ends[:, 0])
    highest = np.where(softer, ends[:, 0], ends[:, 1])
    corners = np.vstack((lowest, highest))
    frequencies = np.array(
        [_frequencies(variant, spreads, corners) for variant in (chain, *others)]
    )
    return np.min(frequencies[:, 0], axis=0), np.max(frequencies[:, 1], axis=0)


def frequency_sensitivities(chain: Chain, spreads: Sequence[Spread]) -> Array:
    """Return the relative change of each frequency per relative change of each factor, (p, q).

    Returns
    -------
    ndarray of shape (p, q)
        d ln f / d ln factor at the nominal chain; zero for rigid-body modes and for dampings.

    Raises
    ------
    InputError
        If a place does not exist.

    Notes
    -----
    d ln f = 1/2 (strain share d ln k - kinetic share d ln I): half the share of the scaled springs in
    the mode's strain energy, less half that of the scaled inertias in its kinetic energy. Close
    frequencies that cross exchange their shapes, and sensitivities with them.
    """
    modes = chain.modes()
    elements = len(chain.connections)
    halves = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    ends = np.array(chain.connections, dtype=np.intp).reshape(-1, 2)
    along = np.einsum("eaq,ab,ebq->eq", modes.shapes[ends], halves, modes.shapes[ends])
    elastic = np.arange(modes.angular_frequencies.size) >= modes.rigid
    shares = {
        "stiffness": modes.strain_shares[:elements],
        "ground": modes.strain_shares[elements:],
        "inertia": -chain.inertia[:, np.newaxis] * modes.shapes**2 / modes.modal_inertia,
        "distributed_inertia": -chain.distributed_inertia[:, np.newaxis]
        * along
        / modes.modal_inertia,
    }
    rows = []
    for spread in spreads:
        field, power = FIELDS.get(spread.kind, ("", 0))
        share = np.zeros(elastic.size)
        if field in shares:
            share = shares[field][spread_indices(chain, spread)].sum(axis=0)
        rows.append(0.5 * power * np.where(elastic, share, 0.0))
    return np.array(rows).reshape(len(spreads), elastic.size)


def chain_samples(
    chain: Chain,
    spreads: Sequence[Spread],
    result: Callable[[Chain], ArrayLike],
    samples: int = DEFAULT_SAMPLES,
    seed: int = DEFAULT_SEED,
) -> Samples:
    """Find any result for many possible chains, such as peak amplitudes.

    Parameters
    ----------
    result : callable
        Chain to a number or an array of the same shape for every chain.
    spreads, samples, seed
        As for `sampled_factors`.

    Notes
    -----
    Amplitudes are not monotonic in stiffness and inertia, which shift resonances: the extremes
    of the samples are not bounds of the possible values.
    """
    return function_samples(
        lambda factors: result(scaled_chain(chain, spreads, factors)), spreads, samples, seed
    )


def function_samples(
    result: Callable[[Array], ArrayLike],
    spreads: Sequence[Spread],
    samples: int = DEFAULT_SAMPLES,
    seed: int = DEFAULT_SEED,
) -> Samples:
    """Find any function of the factors for many samples of them.

    Parameters
    ----------
    result : callable
        Factors (p,) to a number or an array of always the same shape.
    spreads : sequence of p Spread
        Kinds and elements are interpreted by the function.
    samples, seed : int
        See `sampled_factors`.
    """
    factors = sampled_factors(spreads, samples, seed)
    whole_within("samples", samples, 2, MOST_CALCULATED, "each is calculated by itself")
    values = np.array([np.asarray(result(row), dtype=np.float64) for row in factors])
    nominal = np.asarray(result(np.ones(len(spreads))), dtype=np.float64)
    return Samples(tuple(spreads), factors, values, nominal)


def _frequencies(chain: Chain, spreads: Sequence[Spread], factors: Array) -> Array:
    """Return the frequencies [Hz] of each row of factors, (N, q).

    As `elastic_modes`: singular values of C L'^(-1), with K = C' C and M = L L'.
    """
    if chain.has_massless_gears:  # they stand elsewhere with each set of springs
        scaled = (scaled_chain(chain, spreads, row) for row in factors)
        return np.array([variant.modes().frequencies for variant in scaled])
    scales, expand = scale_factors(chain, spreads, factors), chain.expansion()
    elongations = chain.elongations() @ expand
    springs = np.concatenate(
        (
            np.sqrt(chain.stiffness * scales["stiffness"])[:, :, np.newaxis] * elongations,
            np.sqrt(chain.ground * scales["ground"])[:, :, np.newaxis] * expand,
        ),
        axis=1,
    )
    ends = np.array(chain.connections, dtype=np.intp).reshape(-1, 2)
    left, right = expand[ends[:, 0]], expand[ends[:, 1]]
    spread_out = chain.distributed_inertia * scales["distributed_inertia"] / 6.0
    mass = np.einsum("Nn,na,nb->Nab", chain.inertia * scales["inertia"], expand, expand)
    for first, second, weight in (
        (left, left, 2),
        (right, right, 2),
        (left, right, 1),
        (right, left, 1),
    ):
        mass += weight * np.einsum("Ne,ea,eb->Nab", spread_out, first, second)
    root = np.linalg.cholesky(mass)
    rows = np.swapaxes(np.linalg.solve(root, np.swapaxes(springs, 1, 2)), 1, 2)
    singular = np.linalg.svd(rows, compute_uv=False)
    rigid = chain.rigid_motions()[0].shape[1]
    count = expand.shape[1] - rigid
    angular = np.zeros((len(factors), expand.shape[1]))
    angular[:, rigid:] = singular[:, :count][:, ::-1]
    return angular / (2.0 * np.pi)
