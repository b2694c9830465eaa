"""Dampers sized by optimization: the smallest one that keeps a chosen limit at all speeds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar

from crankbase.array_checks import Array, positive_number
from crankbase.choices import check_choice
from crankbase.diagrams import BLUE, RED, legend_inside, new_axes, with_gaps, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM, percent
from crankbase.results import result
from crankbase.sentences import amount
from dynamics.assessment.limits import AmplitudeCurve, VibrationLimit, positive_range, usage
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import AxialDamper, RubberDamper, TorsionalDamper, ViscousDamper
from dynamics.plots.curves import draw_named_curves, in_unit

Ranges = Sequence[tuple[float, float]]
# Points of the first look at the range of a setting, of later ones about the last best setting, and
# the factor by which these go beyond it.
FIRST_SCAN, LATER_SCAN, WIDER = 11, 5, 2.0
# A search ends when the logarithms of its variables are known to this; the least peak is flat or has
# a kink there, so that it is known to about the same share.
CLOSE = 5e-4
# The share of a limit that the smallest size is made to use, so that it is not met from above.
AIM = 1.0 - CLOSE
MOST_TRIALS = 100
# Share of the logarithm of a range that counts as its end.
AT_END = 1e-2


@dataclass(frozen=True, eq=False)
class TrialSize:
    """A trial size of a damper.

    Parameters
    ----------
    settings : ndarray of shape (d,)
        The best settings found for it.
    used : float
        Largest share of the permitted amplitude with them; inf if unbounded.
    """

    size: float
    settings: Array
    used: float


def smallest_sufficient(tried: Sequence[TrialSize]) -> TrialSize:
    """Return the smallest size that keeps the limit; if none does, the one of least usage."""
    kept = [trial for trial in tried if trial.used <= 1.0]
    if kept:
        return min(kept, key=lambda trial: trial.size)
    return min(tried, key=lambda trial: (trial.used, trial.size))


def without_close_sizes(tried: Sequence[TrialSize]) -> tuple[TrialSize, ...]:
    """Drop ascending sizes within a hundredth of the range of another, such as those at a search's end.

    The first, the last and the selected one stay.
    """
    places = np.log([trial.size for trial in tried])
    close = AT_END * float(places[-1] - places[0])
    kept = {0, len(tried) - 1, tried.index(smallest_sufficient(tried))}
    for place in range(len(tried)):
        if all(abs(places[place] - places[other]) > close for other in kept):
            kept.add(place)
    return tuple(tried[place] for place in sorted(kept))


def search_sizes(
    at: Callable[[float, TrialSize | None], TrialSize], low: float, high: float, points: int
) -> tuple[TrialSize, ...]:
    """Search for the smallest size that keeps a limit, and return all sizes tried, ascending.

    `at` maps a size, and the nearest size tried before (None at first), to the best result for it. A scan
    of `points` sizes is followed by a search for the least use if no size keeps the limit, or for the size
    at which the limit is met if one does.
    """
    tried: dict[float, TrialSize] = {}

    def used(logarithm: float) -> float:
        size = min(max(float(np.exp(logarithm)), low), high)
        if size not in tried:
            nearest = min(
                tried.values(), key=lambda trial: abs(np.log(trial.size / size)), default=None
            )
            tried[size] = at(size, nearest)
        return tried[size].used

    if low == high:
        return (at(low, None),)
    places = np.linspace(np.log(high), np.log(low), points)
    values = [used(float(place)) for place in places]
    best = int(np.argmin([finite(value) for value in values]))
    if values[best] > 1.0 and 0 < best < points - 1:
        _brent(used, float(places[best + 1]), float(places[best - 1]))
    kept = smallest_sufficient(list(tried.values()))
    smaller = [trial.size for trial in tried.values() if trial.size < kept.size]
    if kept.used <= AIM and smaller:
        brentq(
            lambda place: finite(used(place)) - finite(AIM),
            np.log(max(smaller)),
            np.log(kept.size),
            xtol=0.1 * CLOSE,
        )
    return tuple(tried[size] for size in sorted(tried))


def minimize_usage(
    used: Callable[[Array], float], ranges: Ranges, last: Array | None
) -> tuple[Array, float]:
    """Find the settings (d,) of least usage of a limit, and this usage.

    At most two settings are free; equal ends of a range fix one. The best settings of a neighboring size,
    if known, are searched about, and the whole ranges only if the best ones are at an end of that interval.
    """
    whole = np.log(np.array(ranges, dtype=np.float64))
    if last is not None:
        near = np.log(np.clip(last, np.exp(whole[:, 0]), np.exp(whole[:, 1])))
        wide = np.log(WIDER)
        about = np.column_stack(
            (np.maximum(near - wide, whole[:, 0]), np.minimum(near + wide, whole[:, 1]))
        )
        best, value = _minimum_usage(used, about, LATER_SCAN)
        cut = np.any((np.abs(best[:, np.newaxis] - about) <= AT_END) & (about != whole))
        if not cut:
            return np.exp(best), value
    best, value = _minimum_usage(used, whole, FIRST_SCAN)
    return np.exp(best), value


def range_end_remark(name: str, value: float, low: float, high: float) -> str:
    """State that a best value is at an end of its range; empty if it is not."""
    if not low < high:
        return ""
    for end, word in ((low, "least"), (high, "largest")):
        if abs(np.log(value / end)) <= AT_END * np.log(high / low):
            return f"; the {name} is the {word} allowed"
    return ""


def finite(used: float) -> float:
    """Return an increasing function of the use that stays finite where the vibration is unbounded."""
    return 1.0 if np.isinf(used) else used / (1.0 + used)


def _minimum_usage(used: Callable[[Array], float], ends: Array, points: int) -> tuple[Array, float]:
    """Find the least usage within ranges of logarithms, and where it occurs."""
    free = np.flatnonzero(ends[:, 1] > ends[:, 0])

    def at(values: Array) -> float:
        return used(np.exp(placed(values)))

    def placed(values: Array) -> Array:
        whole = ends[:, 0].copy()
        whole[free] = values
        return whole

    if free.size == 0:
        return ends[:, 0].copy(), at(np.empty(0))
    axes = [np.linspace(low, high, points) for low, high in ends[free].tolist()]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, free.size)
    values = [at(point) for point in grid]
    place = int(np.argmin([finite(value) for value in values]))
    first, least = grid[place], values[place]
    if free.size == 1:
        low, high = max(place - 1, 0), min(place + 1, points - 1)
        least_at = _brent(lambda x: at(np.array([x])), float(axes[0][low]), float(axes[0][high]))
        best = np.array([least_at])
    else:
        steps = 0.5 * np.diag([axis[1] - axis[0] for axis in axes])
        simplex = np.vstack((first, first + steps))

        def objective(x: Array, /) -> float:
            return finite(at(x))

        minimum = minimize(
            objective,
            simplex[0].copy(),
            method="Nelder-Mead",
            bounds=ends[free].tolist(),
            options={
                "initial_simplex": np.clip(simplex, *ends[free].T),
                "xatol": CLOSE,
                "fatol": 0.1 * CLOSE,
                "maxfev": MOST_TRIALS,
            },
        )
        best = np.asarray(minimum.x, dtype=np.float64)
    value = at(best)
    return (placed(best), value) if value <= least else (placed(first), least)


def _brent(used: Callable[[float], float], low: float, high: float) -> float:
    minimum = minimize_scalar(
        lambda x: finite(used(float(x))),
        bounds=(low, high),
        method="bounded",
        options={"xatol": CLOSE},
    )
    return float(minimum.x)


Damper = TorsionalDamper | AxialDamper


@result("damper", "used", "used_without", "reached", "sizes")
class SizedDamper:
    """Result of the optimization of a damper.

    Parameters
    ----------
    damper : ViscousDamper, RubberDamper or AxialDamper
        The smallest one that keeps the limit; if none does, the one with the least excess.
    chain : Chain
        Chain with this damper.
    reached : bool
        Whether the limit is kept.
    curve, without : AmplitudeCurve
        The limited quantity with the damper and without one.
    used, used_without : float
        Largest share of the permitted amplitude over the speeds; infinite at an undamped resonance.
    sizes : ndarray of shape (m,)
        Sizes tried, ascending, without those at the end of the search that nearly equal the best: ring
        inertia [kg m^2] or damping of an axial damper [N s/m].
    used_at_best : ndarray of shape (m,)
        Least share of the permitted amplitude found for each of them.
    sentence : str
        The result, or why no damper keeps the limit.
    """

    damper: Damper
    chain: Chain
    reached: bool
    limit: VibrationLimit
    curve: AmplitudeCurve
    without: AmplitudeCurve
    used: float
    used_without: float
    sizes: Array
    used_at_best: Array
    sentence: str

    def plot(
        self, axes: Axes | None = None, *, show: Literal["amplitude", "sizes"] = "amplitude"
    ) -> Axes:
        """Draw the amplitude with and without the damper, or the best result of each size.

        Parameters
        ----------
        show : {"amplitude", "sizes"}, optional
            Amplitude over the speed, or the best result of each size.

        Returns
        -------
        matplotlib.axes.Axes
            The dashed line is the permitted value.

        Raises
        ------
        InputError
            If it is neither.
        """
        check_choice("show", show, ("amplitude", "sizes"), "these show what a damper does")
        axes = new_axes(axes)
        if show == "sizes":
            unit = "N s/m" if isinstance(self.damper, AxialDamper) else "kg m$^2$"
            axes.plot(
                self.sizes, with_gaps(100.0 * self.used_at_best), "o-", color=BLUE, markersize=4
            )
            axes.axhline(100.0, color=RED, linestyle="--", linewidth=1.2)
            axes.set_xlabel(f"size of the damper [{unit}]")
            axes.set_ylabel("used of the permitted amplitude [%]")
            axes.set_ylim(bottom=0.0)
            write_title(axes, "Dampers of each size at their best")
            return axes
        drawn = in_unit(self.limit.unit)
        curves = {
            "with the damper": drawn.factor * self.curve.values,
            "without": drawn.factor * self.without.values,
        }
        draw_named_curves(axes, self.curve.speeds, curves, drawn.label)
        permitted = drawn.factor * self.limit.continuous.at(self.curve.speeds)
        rpm = RPM * self.curve.speeds
        axes.plot(rpm, with_gaps(permitted), "--", color=RED, label="permitted")
        write_title(axes, self.limit.name)
        legend_inside(axes)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each size, with the least share of the permitted amplitude found.

        Units and errors are those of `crankbase.frames.table`.
        """
        unit = "N s/m" if isinstance(self.damper, AxialDamper) else "kg m^2"
        return table({"size": (self.sizes, unit), "used": (self.used_at_best, "1")})


Result = Callable[[Chain], AmplitudeCurve]
Range = float | tuple[float, float]
# Ranges searched if none are given. A ring's damping: c / (2 I w_1), w_1 the chain's first elastic
# frequency; a rubber ring's own frequency over w_1; a loss factor from stiff to very soft rubber.
DAMPING_RATIOS = (0.02, 5.0)
TUNINGS = (0.4, 2.5)
LOSS_FACTORS = (0.05, 1.0)
# Sizes of rings looked at before the search; of axial dampers, which can be too large.
RING_SCAN, AXIAL_SCAN = 5, 11


def size_viscous_damper(
    chain: Chain,
    node: int | str,
    result: Result,
    limit: VibrationLimit,
    *,
    ring_inertia: Range,
    damping: Range | None = None,
    hub_inertia: float = 0.0,
) -> SizedDamper:
    """Find the viscous damper with the smallest ring that keeps a limit.

    Parameters
    ----------
    chain : Chain
        Torsional, without the damper.
    node : int or str
        Number (from 0) or name of the node with the damper.
    result : callable
        Maps a chain, with a damper and its ring as the last node, to the limited quantity over the speed.
    ring_inertia : float or tuple of two floats
        Of the ring, or the range to search [kg m^2]; for a single value only the damping with the least
        vibration is found.
    damping : float or tuple of two floats, optional
        Of the damper, or the range to search [N m s/rad]; by default c / (2 I w_1) from 0.02 to 5.
    hub_inertia : float
        Of the housing, which turns with the shaft [kg m^2].

    Raises
    ------
    InputError
        If a range is not above zero and ascending, or the node does not exist.

    Notes
    -----
    For each size a scan and Brent's method on the logarithm find the damping with the least peak. A scan
    over the sizes and a bracketed search find the size at which the limit is met. If the limit is kept
    only between two sizes of the scan, the search misses it.
    """
    sizes = _checked_range("ring_inertia", ring_inertia, "kg m^2")
    per_size = 2.0 * _first_frequency(chain)
    dampings = None if damping is None else _checked_range("damping", damping, "N m s/rad")

    def ranges(size: float) -> Ranges:
        if dampings is None:
            return [DAMPING_RATIOS]
        return [(dampings[0] / (per_size * size), dampings[1] / (per_size * size))]

    def make(size: float, settings: Array) -> Damper:
        damping = float(settings[0]) * per_size * size
        return ViscousDamper(ring_inertia=size, damping=damping, hub_inertia=hub_inertia)

    rings = _Sizing(chain, node, result, limit, make, ranges)
    return rings.sized("ring inertia", "kg m^2", sizes, RING_SCAN, ("damping",))


def size_rubber_damper(
    chain: Chain,
    node: int | str,
    result: Result,
    limit: VibrationLimit,
    *,
    ring_inertia: Range,
    loss_factor: Range = LOSS_FACTORS,
    tuning: Range | None = None,
    hub_inertia: float = 0.0,
) -> SizedDamper:
    """Find the rubber damper with the smallest ring that keeps a limit.

    Parameters
    ----------
    chain, node, result, limit, ring_inertia, hub_inertia
        As in `size_viscous_damper`.
    loss_factor : float or tuple of two floats
        Of the rubber, or the range to search.
    tuning : float or tuple of two floats, optional
        Angular frequency of the ring with the shaft held, or the range to search [rad/s]; by
        default from 0.4 to 2.5 times the chain's first elastic one. It determines the stiffness.

    Raises
    ------
    InputError
        As `size_viscous_damper`.

    Notes
    -----
    As there, with the Nelder-Mead method on the logarithms if tuning and loss factor are
    both free.
    """
    sizes = _checked_range("ring_inertia", ring_inertia, "kg m^2")
    first = _first_frequency(chain)
    low, high = TUNINGS
    tunings = (
        (low * first, high * first) if tuning is None else _checked_range("tuning", tuning, "rad/s")
    )
    losses = _checked_range("loss_factor", loss_factor, "")

    def make(size: float, settings: Array) -> Damper:
        frequency, loss = settings.tolist()
        return RubberDamper(
            ring_inertia=size,
            stiffness=size * frequency**2,
            loss_factor=loss,
            hub_inertia=hub_inertia,
        )

    rings = _Sizing(chain, node, result, limit, make, lambda _: [tunings, losses])
    return rings.sized("ring inertia", "kg m^2", sizes, RING_SCAN, ("tuning", "loss factor"))


def size_axial_damper(
    chain: Chain,
    node: int | str,
    result: Result,
    limit: VibrationLimit,
    *,
    damping: Range,
    stiffness: float = 0.0,
    mass: float = 0.0,
) -> SizedDamper:
    """Find the axial damper with the least damping that keeps a limit.

    Parameters
    ----------
    chain : Chain
        Axial, without the damper.
    node, result, limit
        As in `size_viscous_damper`; the damper adds no node.
    damping : float or tuple of two floats
        The damper's, or the range to search [N s/m].
    stiffness, mass : float
        Of oil and housing to ground [N/m], and of the collar [kg].

    Raises
    ------
    InputError
        As `size_viscous_damper`.

    Notes
    -----
    Too much damping locks the collar, so that only the stiffness to ground acts: the damping with the
    least vibration is found first, then the least damping below it that keeps the limit.
    """
    sizes = _checked_range("damping", damping, "N s/m")

    def make(size: float, _: Array) -> Damper:
        return AxialDamper(damping=size, stiffness=stiffness, mass=mass)

    dampers = _Sizing(chain, node, result, limit, make, lambda _: [])
    return dampers.sized("damping", "N s/m", sizes, AXIAL_SCAN, ())


@dataclass(frozen=True, eq=False)
class _Sizing:
    """Target and construction of a damper, and ranges of settings, which may depend on its size."""

    chain: Chain
    node: int | str
    result: Result
    limit: VibrationLimit
    make: Callable[[float, Array], Damper]
    ranges: Callable[[float], Ranges]

    def used(self, size: float, settings: Array) -> float:
        """Largest share of the permitted amplitude with a damper; inf if unbounded."""
        curve = self.result(self.make(size, settings).attached(self.chain, self.node))
        return float(np.max(usage(self.limit, curve)))

    def optimized(self, size: float, nearest: TrialSize | None) -> TrialSize:
        """Optimize the settings of a damper of one size, if it has some."""
        ranges = self.ranges(size)
        if not ranges:
            return TrialSize(size, np.empty(0), self.used(size, np.empty(0)))
        last = None if nearest is None else nearest.settings
        settings, used = minimize_usage(lambda values: self.used(size, values), ranges, last)
        return TrialSize(size, settings, used)

    def sized(
        self, what: str, unit: str, sizes: tuple[float, float], scan: int, settings: tuple[str, ...]
    ) -> SizedDamper:
        """Find the smallest damper whose best settings keep the limit; `what` names its size."""
        tried = search_sizes(self.optimized, *sizes, scan)
        best = smallest_sufficient(tried)
        searched = zip(settings, best.settings.tolist(), self.ranges(best.size), strict=True)
        remark = range_end_remark(what, best.size, *sizes) + "".join(
            range_end_remark(name, value, *ends) for name, value, ends in searched
        )
        damper = self.make(best.size, best.settings)
        chain = damper.attached(self.chain, self.node)
        curve, without = self.result(chain), self.result(self.chain)
        shares = usage(self.limit, curve)
        before = float(np.max(usage(self.limit, without)))
        place = amount(float(curve.speeds[np.argmax(shares)]), "rad/s", 4)
        numbers = (
            f"{_share(best.used)} of what is permitted is reached at {place}, {_share(before)} "
            "without a damper"
        )
        shown = amount(best.size, unit, 4)
        limit = f"{self.limit.name} ({self.limit.source})"
        shown_sizes = without_close_sizes(tried)
        return SizedDamper(
            damper=damper,
            chain=chain,
            reached=best.used <= 1.0,
            limit=self.limit,
            curve=curve,
            without=without,
            used=best.used,
            used_without=before,
            sizes=np.array([trial.size for trial in shown_sizes]),
            used_at_best=np.array([trial.used for trial in shown_sizes]),
            sentence=(
                f"A {what} of {shown} keeps the limit on {limit}: {numbers}."
                if best.used <= 1.0
                else f"No damper in the ranges searched keeps the limit on {limit}: with a {what} of "
                f"{shown}, the best found, {numbers}{remark}."
            ),
        )


def _share(used: float) -> str:
    return f"{percent(used, 4)} %" if np.isfinite(used) else "all and more (unbounded vibration)"


def _first_frequency(chain: Chain) -> float:
    """Return the chain's first elastic angular frequency [rad/s]."""
    modes = chain.modes()
    if modes.rigid == modes.angular_frequencies.size:
        raise InputError(
            f"chain: given one of {modes.rigid} rigid motions only; allowed is one with an elastic "
            "mode, because nothing else is damped."
        )
    return float(modes.angular_frequencies[modes.rigid])


def _checked_range(name: str, ends: Range, unit: str) -> tuple[float, float]:
    """Return the ends of a range; a single value is both."""
    of = "it is that of a damper"
    if not isinstance(ends, tuple):
        value = positive_number(name, ends, unit, of)
        return value, value
    allowed = "the least and then the largest value, because the search runs between them"
    return positive_range(name, ends, unit, of, allowed)
