"""Dampers sized by optimization: the smallest one that keeps a chosen limit at all speeds."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity
from dynamics.assessment.damper_search import (
    Ranges,
    TrialSize,
    minimize_usage,
    range_end_remark,
    search_sizes,
    smallest_sufficient,
    without_close_sizes,
)
from dynamics.assessment.limits import AmplitudeCurve, VibrationLimit, positive_range, usage
from dynamics.assessment.sized_damper import Damper, SizedDamper
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import AxialDamper, RubberDamper, ViscousDamper

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
    limit : VibrationLimit
    ring_inertia : float or tuple of two floats
        Of the ring, or the range to search [kg m^2]; for a single value only the damping with the least
        vibration is found.
    damping : float or tuple of two floats, optional
        Of the damper, or the range to search [N m s/rad]; by default c / (2 I w_1) from 0.02 to 5.
    hub_inertia : float
        Of the housing, which turns with the shaft [kg m^2].

    Returns
    -------
    SizedDamper

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
    given = None if damping is None else _checked_range("damping", damping, "N m s/rad")

    def ranges(size: float) -> Ranges:
        if given is None:
            return [DAMPING_RATIOS]
        return [(given[0] / (per_size * size), given[1] / (per_size * size))]

    def make(size: float, settings: FloatArray) -> Damper:
        return ViscousDamper(size, float(settings[0]) * per_size * size, hub_inertia)

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

    Returns
    -------
    SizedDamper

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

    def make(size: float, settings: FloatArray) -> Damper:
        frequency, loss = settings.tolist()
        return RubberDamper(size, size * frequency**2, loss, hub_inertia=hub_inertia)

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

    Returns
    -------
    SizedDamper

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

    def make(size: float, _: FloatArray) -> Damper:
        return AxialDamper(size, stiffness, mass)

    dampers = _Sizing(chain, node, result, limit, make, lambda _: [])
    return dampers.sized("damping", "N s/m", sizes, AXIAL_SCAN, ())


@dataclass(frozen=True, eq=False)
class _Sizing:
    """Target and construction of a damper, and ranges of settings, which may depend on its size."""

    chain: Chain
    node: int | str
    result: Result
    limit: VibrationLimit
    make: Callable[[float, FloatArray], Damper]
    ranges: Callable[[float], Ranges]

    def used(self, size: float, settings: FloatArray) -> float:
        """Largest share of the permitted amplitude with a damper; inf if unbounded."""
        found = self.result(self.make(size, settings).attached(self.chain, self.node))
        return float(np.max(usage(self.limit, found)))

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
        found = zip(settings, best.settings.tolist(), self.ranges(best.size), strict=True)
        remark = range_end_remark(what, best.size, *sizes) + "".join(
            range_end_remark(name, value, *ends) for name, value, ends in found
        )
        damper = self.make(best.size, best.settings)
        chain = damper.attached(self.chain, self.node)
        curve, without = self.result(chain), self.result(self.chain)
        shares = usage(self.limit, curve)
        before = float(np.max(usage(self.limit, without)))
        place = format_quantity(float(curve.speeds[np.argmax(shares)]), "rad/s", 4)
        numbers = (
            f"{_share(best.used)} of what is permitted is reached at {place}, {_share(before)} "
            "without a damper"
        )
        shown = format_quantity(best.size, unit, 4)
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
            sizes=np.array([one.size for one in shown_sizes]),
            used_at_best=np.array([one.used for one in shown_sizes]),
            sentence=(
                f"A {what} of {shown} keeps the limit on {limit}: {numbers}."
                if best.used <= 1.0
                else f"No damper in the ranges searched keeps the limit on {limit}: with a {what} of "
                f"{shown}, the best found, {numbers}{remark}."
            ),
        )


def _share(used: float) -> str:
    return f"{100.0 * used:.4g} %" if np.isfinite(used) else "all and more (unbounded vibration)"


def _first_frequency(chain: Chain) -> float:
    """Return the chain's first elastic angular frequency [rad/s]."""
    modes = chain.modes()
    if modes.rigid == modes.angular_frequencies.size:
        raise InputError(
            f"chain: given one of {modes.rigid} rigid motions only; allowed is one with an elastic "
            "mode, because nothing else is damped."
        )
    return float(modes.angular_frequencies[modes.rigid])


def _checked_range(name: str, given: Range, unit: str) -> tuple[float, float]:
    """Return the ends of a range; a single value is both."""
    of = "it is that of a damper"
    if not isinstance(given, tuple):
        value = positive_number(name, given, unit, of)
        return value, value
    allowed = "the least and then the largest value, because the search runs between them"
    return positive_range(name, given, unit, of, allowed)
