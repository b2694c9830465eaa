"""Effect of uncertain values on a chain's frequencies and amplitudes: bounds and samples."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray
from crankbase.checks.scalars import is_number, whole_number, whole_within
from crankbase.drawing.diagram_style import BLUE, GRAY, RED, new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.errors import InputError, quoted
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from dynamics.assessment.spreads import FIELDS, Spread, scale_factors, scaled_chain, spread_indices
from dynamics.chains.chain import Chain

STIFF = ("stiffness", "ground")
HEAVY = ("inertia", "distributed_inertia")
DEFAULT_SAMPLES, DEFAULT_SEED = 200, 0
# Samples of a result that is calculated for one chain after another.
MOST_CALCULATED = 100_000


@summarized("values", "nominal", "spreads")
@dataclass(frozen=True, eq=False)
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
    factors: FloatArray
    values: FloatArray
    nominal: FloatArray

    def percentile(self, percent: float) -> FloatArray:
        """Return the value that a given percentage of the samples does not exceed, shape (...).

        It is one of the samples, the first that reaches that share, so inf is kept.

        Raises
        ------
        InputError
            If the percentage is out of range.
        """
        if not (is_number(percent) and 0.0 <= percent <= 100.0):
            raise InputError(
                f"percent: given {quoted(percent)}; allowed are 0 to 100, because it is a share."
            )
        return np.asarray(np.percentile(self.values, percent, axis=0, method="inverted_cdf"))

    @property
    def lowest(self) -> FloatArray:
        """Lowest of all samples, shape (...)."""
        return np.asarray(np.min(self.values, axis=0))

    @property
    def highest(self) -> FloatArray:
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
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
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
        own = columns[:, number]
        bounded = own[np.isfinite(own)]
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
        lost = own.size - bounded.size
        write_title(axes, f"{own.size} samples" + (f", {lost} unbounded" if lost else ""))
        legend_inside(axes)
        return axes


def sampled_factors(
    spreads: Sequence[Spread], samples: int = DEFAULT_SAMPLES, seed: int = DEFAULT_SEED
) -> FloatArray:
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

    Raises
    ------
    InputError
        If there is no spread, fewer than two samples, or the seed is negative.
    """
    if not spreads:
        raise InputError(
            "spreads: given none; allowed are one or more, because nothing varies without."
        )
    count = whole_number("samples", samples, 2, "a range has two ends")
    start = whole_number("seed", seed, 0, "random numbers start from one")
    from scipy.stats import qmc  # here: loading it takes a quarter second

    drawn = qmc.LatinHypercube(len(spreads), rng=np.random.default_rng(start)).random(count)
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
    chain : Chain
    spreads : sequence of p Spread
    samples, seed : int
        See `sampled_factors`.

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
) -> tuple[FloatArray, FloatArray]:
    """Find the lowest and highest possible natural frequencies, exactly.

    Parameters
    ----------
    chain : Chain
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
    softer = np.array([_softens(spread) for spread in spreads], dtype=bool)
    lowest = np.where(softer, ends[:, 1], ends[:, 0])
    highest = np.where(softer, ends[:, 0], ends[:, 1])
    corners = np.vstack((lowest, highest))
    found = np.array([_frequencies(own, spreads, corners) for own in (chain, *others)])
    return np.min(found[:, 0], axis=0), np.max(found[:, 1], axis=0)


def frequency_sensitivities(chain: Chain, spreads: Sequence[Spread]) -> FloatArray:
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
    chain : Chain
    spreads : sequence of p Spread
    result : callable
        Chain to a number or an array of the same shape for every chain.
    samples, seed : int
        See `sampled_factors`.

    Returns
    -------
    Samples

    Notes
    -----
    Amplitudes are not monotonic in stiffness and inertia, which shift resonances: the extremes
    of the samples are not bounds of the possible values.
    """
    return function_samples(
        lambda factors: result(scaled_chain(chain, spreads, factors)), spreads, samples, seed
    )


def function_samples(
    result: Callable[[FloatArray], ArrayLike],
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

    Raises
    ------
    InputError
        As `sampled_factors`, and if there are too many samples for individual calculation.
    """
    factors = sampled_factors(spreads, samples, seed)
    if samples > MOST_CALCULATED:
        raise InputError(
            f"samples: given {samples}; allowed is up to {MOST_CALCULATED}, because each is "
            "calculated by itself."
        )
    values = np.array([np.asarray(result(row), dtype=np.float64) for row in factors])
    nominal = np.asarray(result(np.ones(len(spreads))), dtype=np.float64)
    return Samples(tuple(spreads), factors, values, nominal)


def _frequencies(chain: Chain, spreads: Sequence[Spread], factors: FloatArray) -> FloatArray:
    """Return the frequencies [Hz] of each row of factors, (N, q).

    As `elastic_modes`: singular values of C L'^(-1), with K = C' C and M = L L'.
    """
    scales = scale_factors(chain, spreads, factors)
    expand = chain.expansion()
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
    for one, other, weight in (
        (left, left, 2),
        (right, right, 2),
        (left, right, 1),
        (right, left, 1),
    ):
        mass += weight * np.einsum("Ne,ea,eb->Nab", spread_out, one, other)
    root = np.linalg.cholesky(mass)
    rows = np.swapaxes(np.linalg.solve(root, np.swapaxes(springs, 1, 2)), 1, 2)
    singular = np.linalg.svd(rows, compute_uv=False)
    rigid = chain.rigid_motions()[0].shape[1]
    count = expand.shape[1] - rigid
    found = np.zeros((len(factors), expand.shape[1]))
    found[:, rigid:] = singular[:, :count][:, ::-1]
    return found / (2.0 * np.pi)


def _softens(spread: Spread) -> bool:
    """Return whether a larger factor lowers the frequencies."""
    field, power = FIELDS.get(spread.kind, ("", 0))
    return (field in STIFF and power < 0) or field in HEAVY
