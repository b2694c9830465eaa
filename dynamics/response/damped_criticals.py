"""Critical speeds with damping: where an order alone makes a quantity largest, and the mode responsible."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, ComplexArray, Flags, checked_range
from crankbase.errors import InputError
from crankbase.frames import Row
from crankbase.quantity import RPM
from crankbase.results import Internal, Number, Part, Quantity, Result, result
from dynamics.chains.varying import over_amplitude
from dynamics.critical import meetings
from dynamics.indices import within
from dynamics.response.complex_modes import ComplexModes, complex_modes, modes_at
from dynamics.response.forced import ForcedResponse
from dynamics.response.harmonic import harmonic_response
from dynamics.response.loads import LinearQuantities, load_quantities, motion_rows, pushing
from dynamics.response.order_excitation import OverSpeed
from dynamics.response.resonance import LEAST_RATIO, speeds_about

# Maxima below this share of the largest one are round-off of orders that nothing excites.
LEAST_SHARE = 1e-9
# Share of a mode's largest magnifier down to which a peak is that of the mode: 1.7 half bandwidths.
BAND = 0.5
# Share of the bend of a peak that its modes make with constant forces, so that it is theirs; otherwise forces
# make it, as those of a torsional resonance do in the axial chain.
MODAL = 0.5
# Maxima of several places within a half bandwidth, at most this share of the speed, are one critical speed.
NEARLY = 0.05
# A place may stand for a critical speed if its share of its own largest peak is this part of the best one.
LARGE = 0.25
# A mode makes a peak too if it bends the curve at least this share of what the main one does.
SEVERAL = 0.25
# Peaks below this share of the largest one of their place are not worth a row of a table.
LEAST_PEAK = 0.05
# A peak is that of a mode that makes at least this part of the amplitude.
LEAST_PART = 0.05
# Where springs vary, each order is calculated at so many times the response's speeds.
VARYING = 8
# Shares of a bracket that are tried at once, and rounds, each of which leaves a quarter of it. Then a peak is
# a parabola to a millionth of the bracket, and still rises well above round-off.
TRIED, ROUNDS = np.arange(1, 8) / 8.0, 3


# There may be no such speed, frequency or share: NaN.
PeakSpeed: TypeAlias = Annotated[float, Quantity("rad/s", exported="1/min", missing=float("nan"))]
Share: TypeAlias = Annotated[float, Quantity("1", missing=float("nan"))]


@result(
    *("order", "mode", "has_peak", "speed_rpm [1/min]", "amplitude", "place", "damping_ratio"),
    "undamped_speed",
    eq=True,
)
class DampedCritical(Result):
    """The speed at which one order alone makes a quantity largest, and the mode responsible.

    Parameters
    ----------
    order : float
        In cycles per crankshaft revolution.
    mode : int
        Number of the elastic mode that makes the peak, 1 the lowest; 0 for an overdamped motion.
    speed : float
        Speed of the maximum amplitude [rad/s]; NaN if there is none near this mode's
        frequencies: too much damping, or forces that cancel on the mode.
    amplitude : float
        Of this order there, all modes together [N m or N, rad or m]; inf where undamped, NaN without a
        maximum.
    place : str
        Its element or node, see `damped_criticals`; empty without a maximum.
    mode_share : float
        Part of the amplitude from this mode; others may counteract it.
    in_band : bool
        Whether the mode's magnifier at the peak is half of its largest or more, the mode makes a twentieth
        of the amplitude or more, and modes make half of the peak's bend or more. If not, the exciting forces
        have a peak, as axial ones have where torsional vibration is large, or the mode is a ripple on them.
    mode_frequency : float
        Damped natural frequency of the mode [Hz]; NaN for an overdamped one.
    damping_ratio : float
        Share of critical damping of the mode; NaN for an overdamped one.
    undamped_speed : float
        Speed at which the order meets the undamped frequency, the ring of a viscous damper free [rad/s].
    locked_speed : float
        The same with that ring locked to its housing [rad/s]; NaN without one.
    severity : float
        Amplitude over the largest bounded one of its place by any order, at that of the places peaking there
        where this share is largest; 1 for an unbounded one, 0 without a maximum.
    kind : {"major", "minor"}
        Whether all cylinders act in phase at this order, if known.
    in_running_range : bool
        Whether the engine runs at that speed, if known; limits may apply at higher speeds too.
    of_load : bool
        Whether the amplitude is that of an element's load, or else of a node's motion.
    first_amplitude : float
        Of the motion of the first node, a crankshaft's free end, by this order at this speed [rad or m].
    others : tuple of str
        Further places whose own peaks are at nearly this speed.
    spread : tuple of two floats or None
        Lowest and highest speed of the peaks of all these places [rad/s]; None without a maximum.
    modes : tuple of int
        All modes that make the peak at any of the places, the main one first; none for a peak of the forces.
    unit : str
        Of the amplitude, "N m", "N", "rad" or "m"; "SI" if the kind of the chain is not known.
    limit_used : float
        Share of a limit that the order alone uses at this speed, the largest of all places, of the limit for
        passing where the speed is only passed on starting; NaN where no limit is stated.
    """

    order: Number
    mode: int
    speed: PeakSpeed
    amplitude: Annotated[float, Quantity(".unit", key="value", missing=float("nan"))]
    place: str
    mode_share: Share
    in_band: bool
    mode_frequency: Annotated[float, Quantity("Hz", missing=float("nan"))]
    damping_ratio: Share
    undamped_speed: Annotated[
        float, Quantity("rad/s", exported="1/min", key="undamped_rpm", missing=float("nan"))
    ]
    locked_speed: Annotated[
        float, Quantity("rad/s", exported="1/min", key="locked_rpm", missing=float("nan"))
    ]
    severity: Number
    kind: Literal["major", "minor"] = "minor"
    in_running_range: bool = True
    of_load: Internal[bool] = False
    first_amplitude: Annotated[
        float, Quantity(".motion_unit", key="amplitude", missing=float("nan"))
    ] = float("nan")
    others: tuple[str, ...] = ()
    spread: Annotated[tuple[float, float] | None, Quantity("rad/s", exported="1/min")] = None
    modes: Annotated[tuple[int, ...], Quantity("1")] = ()
    unit: str = "SI"
    limit_used: Share = float("nan")

    @property
    def motion_unit(self) -> str:
        """That of the first node's motion."""
        return {"N m": "rad", "rad": "rad", "SI": "rad or m"}.get(self.unit, "m")

    @cached_property
    def unbounded(self) -> Part[bool]:
        """Whether it is undamped."""
        return bool(np.isinf(self.amplitude))

    @property
    def has_peak(self) -> bool:
        """Whether the order has a maximum there."""
        return not np.isnan(self.speed)

    @property
    def frequency(self) -> Annotated[float, Quantity("Hz", missing=float("nan"))]:
        """Frequency of the order at the peak [Hz]; that of the mode without a peak."""
        peak = self.order * self.speed / (2.0 * np.pi)
        return peak if self.has_peak else self.mode_frequency

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""
        return self.speed * RPM

    @property
    def sentence(self) -> str:
        """Position of the peak relative to the speeds without damping."""
        if not self.mode:
            return f"Order {self.order:g}: peak at {self.speed_rpm:.4g} 1/min, of no mode's own."
        beside = f"{self.undamped_speed * RPM:.4g} 1/min undamped"
        if not np.isnan(self.locked_speed):
            beside = (
                f"{self.undamped_speed * RPM:.4g} 1/min with the damper's ring free, "
                f"{self.locked_speed * RPM:.4g} 1/min with it locked"
            )
        peak = f"peak at {self.speed_rpm:.4g} 1/min in {self.place}"
        where = peak if self.has_peak else "no peak"
        if self.has_peak and not self.in_band:
            where += ", where its forces are largest"
        return f"Order {self.order:g}, mode {self.mode}: {where} ({beside})."

    def row(self) -> Row:
        """Return the columns of a table of critical speeds, each value with its unit; see `table_of`."""
        return super().row() | {"others": (len(self.others), "1")}


def damped_criticals(
    response: ForcedResponse,
    *,
    elements: Sequence[int | str] | None = None,
    node: int | str | None = None,
    speed_range: tuple[float, float] | None = None,
    modes: ComplexModes | None = None,
    first: Collection[str] = (),
    below: bool = False,
) -> tuple[DampedCritical, ...]:
    """Find the critical speeds of a damped chain: the peaks of each order alone, at every place.

    Parameters
    ----------
    response : ForcedResponse
        Its system and excitation are used; forces between its speeds are interpolated.
    elements : sequence of int or str, optional
        Elements whose loads k d [N m or N] alone are considered; by default the loads of all elements and
        the elastic motions of all nodes [rad or m].
    node : int or str, optional
        Node whose elastic motion alone is considered.
    speed_range : tuple of two floats
        Within the speeds of the response; by default all of them [rad/s].
    modes : ComplexModes, optional
        Of the system, if known.
    first : collection of str, optional
        Places to name before others, such as those with limits.
    below : bool, optional
        Whether peaks at lower speeds of the response, below the range, are returned too; their severity is
        beside the peaks in the range, and at most 1.

    Returns
    -------
    tuple of DampedCritical
        In ascending order, mode and speed. One order may have several peaks with one mode, as where forces
        grow with the speed next to a resonance: each is listed. For a mode that an order meets within
        the range, with ring free, ring locked or damped, there is an entry without a speed if the order
        has no maximum of this mode at any place.

    Raises
    ------
    InputError
        If elements and node are both given, one does not exist, the range is reversed or exceeds
        the speeds of the response, or elements are requested of a system that is not a chain.

    Notes
    -----
    Each order is calculated at the speeds of the response and about each damped frequency, an eighth
    of its half bandwidth apart. Each place's maxima there are placed by a parabola through 1 / amplitude^2,
    which is one near a resonance. Maxima of several places within a half bandwidth (`NEARLY` at most) are
    one critical speed. It is told of one place: among those where it is at least `LARGE` as large a share
    of the place's largest one as anywhere, one of `first`, then of the loads, the one with the largest
    value. There a search finds the speed to a millionth of the distance of the calculated ones.

    A maximum belongs to the mode that bends the curve down most: with the part y_k = r_k / (i w - s_k) of
    each mode, -y_k'' / 2 = y_k / (i w - s_k)^2, taken in phase with the amplitude. A large mode far from
    resonance adds to the amplitude but not to its bend. The peak counts as that mode's own if it is
    `in_band`: forces that have a peak of their own bend it more than the modes do with constant forces.
    """
    if node is not None and elements is not None:
        raise InputError(
            f"node: given {node!r} together with elements; allowed is one of both, because peaks are those "
            "of loads or of a motion."
        )
    if any(over_amplitude(spring.law) for spring in response.system.varying):
        raise InputError(
            "chain: given springs that vary with amplitude; allowed are others for critical speeds with "
            "damping, because amplitudes are known at the speeds of the response alone: its synthesis shows "
            "the peaks."
        )
    if node is not None:
        rows, names = motion_rows(response, [node])
        quantities = LinearQuantities(names, rows, np.zeros(1, dtype=bool))
    elif elements is not None:
        quantities = load_quantities(response, elements)
    else:
        moved, nodes = motion_rows(response)
        quantities = LinearQuantities(nodes, moved, np.zeros(len(nodes), dtype=bool))
        if response.chain is not None:
            loads = load_quantities(response, elements)
            more = ((0, len(nodes)), (0, 0))
            quantities = replace(
                loads,
                direct=None if loads.direct is None else np.pad(loads.direct, more),
                names=(*loads.names, *nodes),
                rows=np.concatenate((loads.rows, moved)),
                loads=np.arange(len(loads.names) + len(nodes)) < len(loads.names),
            )
    return criticals_of(response, quantities, speed_range, modes=modes, first=first, below=below)


def criticals_of(
    response: ForcedResponse,
    quantities: LinearQuantities,
    speed_range: tuple[float, float] | None = None,
    *,
    modes: ComplexModes | None = None,
    first: Collection[str] = (),
    least: float | None = None,
    below: bool = False,
) -> tuple[DampedCritical, ...]:
    """Find the critical speeds of a system in given quantities; see `damped_criticals`.

    Parameters
    ----------
    least : float, optional
        A place may stand for a critical speed if its share of its own largest peak is this, or as large as
        anywhere, in place of `LARGE`.
    """
    names, loads = quantities.names, quantities.loads
    modes = complex_modes(response) if modes is None else modes
    ends = _checked_ends(response, speed_range)
    # Most points of a whole crankshaft are free of forces.
    acting, expand = response.excitation.acting, response.system.expand
    places = np.flatnonzero(np.any(acting, axis=(0, 1)))
    vibration = _Vibration(
        response,
        modes,
        quantities.under(places),
        OverSpeed.of(response.speeds, acting[:, :, places]),
        np.pad(expand, ((0, acting.shape[2] - len(expand)), (0, 0)))[places],
        pushing(response)[places],
    )
    maxima = vibration.maxima()
    scales = _largest(maxima, np.isfinite(maxima.values), len(names))
    kinds = np.where(loads, *(np.max(scales[loads == kind], initial=0.0) for kind in (True, False)))
    maxima = maxima.chosen(maxima.values > LEAST_SHARE * kinds[maxima.places])
    inside = within(maxima.speeds, *ends)
    scales = _largest(maxima, inside & np.isfinite(maxima.values), len(names))
    preferred = np.isin(names, list(first))
    criticals: list[DampedCritical] = []
    met: set[tuple[float, int]] = set()
    if maxima.speeds.size:
        made = vibration.made(maxima, maxima.speeds)
        # A mode may have its peak beyond the range, or one that is told with another mode's.
        makers = np.append(modes.numbers, 0)[made.mode]
        met = set(zip(response.orders[maxima.orders].tolist(), makers.tolist(), strict=True))
        lower = ~inside & (maxima.speeds < ends[0])
        for some in (inside, lower) if below else (inside,):
            criticals += vibration.peaks(
                maxima.chosen(some), made.chosen(some), scales, kinds, preferred, least
            )
    met |= {(peak.order, number) for peak in criticals for number in peak.modes}
    locked = np.zeros(0) if modes.locked is None else modes.locked
    for order in response.orders.tolist():
        for number in range(1, modes.undamped.size + 1):
            frequencies = (
                *modes.undamped[number - 1 : number],
                *modes.frequencies[modes.numbers == number],
                *locked[number - 1 : number],
            )
            meets = any(within(2.0 * np.pi * known / order, *ends) for known in frequencies)
            if meets and (order, number) not in met:
                criticals.append(_critical(modes, order, number))
    return tuple(
        sorted(criticals, key=lambda critical: (critical.order, critical.mode, critical.speed))
    )


class _Maxima(NamedTuple):
    """Local maxima (m,): index of order and place, speed, value, calculated speeds beside it.

    Then how each bends down, b in (value / amplitude)^2 = 1 + b (speed - its speed)^2.
    """

    orders: NDArray[np.intp]
    places: NDArray[np.intp]
    speeds: Array
    values: Array
    low: Array
    high: Array
    bends: Array

    def chosen(self, which: Flags | NDArray[np.intp]) -> "_Maxima":
        """Return some of them."""
        return _Maxima._make(column[which] for column in self)

    def together(self, share: Array, near: Array) -> list[NDArray[np.intp]]:
        """Return the indices of the maxima of each critical speed: about one with most others near it.

        Of each place one belongs to it: two maxima of one place are two critical speeds.
        """
        groups = []
        for order in np.unique(self.orders):
            left = np.flatnonzero(self.orders == order)
            left = left[np.argsort(-share[left], kind="stable")]
            apart = np.abs(self.speeds[left] - self.speeds[left, np.newaxis])
            close = apart <= near[left, np.newaxis]
            while left.size:
                middle = int(np.argmax(np.count_nonzero(close, axis=1)))
                members = np.flatnonzero(close[middle])
                members = members[np.argsort(apart[middle, members], kind="stable")]
                _, firsts = np.unique(self.places[left[members]], return_index=True)
                taken = members[firsts]
                groups.append(left[taken])
                kept = np.setdiff1d(np.arange(left.size), taken)
                left, apart, close = (
                    left[kept],
                    apart[np.ix_(kept, kept)],
                    close[np.ix_(kept, kept)],
                )
        return groups


def _largest(maxima: _Maxima, counted: Flags, places: int) -> Array:
    """Return the largest value of each place among the counted maxima, 0 without one."""
    largest = np.zeros(places)
    np.maximum.at(largest, maxima.places[counted], maxima.values[counted])
    return largest


def _checked_ends(
    response: ForcedResponse, speed_range: tuple[float, float] | None
) -> tuple[float, float]:
    low, high = float(response.speeds[0]), float(response.speeds[-1])
    if low == high:
        raise InputError(
            "response: given one at one speed; allowed is one at two speeds or more, because peaks are "
            "looked for between them."
        )
    if speed_range is None:
        return low, high
    first, last = checked_range("speed_range", speed_range, "rad/s", "peaks are looked for in it")
    if not (within(first, low, high) and within(last, low, high)):
        raise InputError(
            f"speed_range: given {first:g} to {last:g} rad/s; allowed is within {low:g} to {high:g} rad/s, "
            "because the response is known there."
        )
    return first, last


@dataclass(frozen=True, eq=False)
class _Vibration:
    """A response evaluated at pairs of order and speed, and the maxima of quantities."""

    response: ForcedResponse
    modes: ComplexModes
    quantities: LinearQuantities
    forces: OverSpeed
    expand: Array
    pushes: Array

    def answer(
        self, orders: NDArray[np.intp], speeds: Array
    ) -> tuple[ComplexArray, Flags, ComplexArray]:
        """Return motions (m, q), where unbounded (m,), and forces on the loaded nodes (m, n)."""
        forces = self.forces.at(orders, speeds)
        answer = harmonic_response(
            self.response.system,
            self.response.orders[orders] * speeds,
            forces @ self.expand,
            speeds=speeds,
        )
        return answer.motion, answer.unbounded, forces

    def maxima(self) -> _Maxima:
        """Return the local maxima of all orders at all places."""
        known = self.response.speeds
        ends = (float(known[0]), float(known[-1]))
        frequencies, ratios = self.modes.frequencies, self.modes.damping_ratios
        # Speeds about each order's resonances; at all of them together the system is solved once.
        # With a stiffness that varies, peaks are elsewhere than at the constant one.
        even = np.linspace(*ends, VARYING * known.size if self.response.system.varying else 0)
        added = []
        for order in self.response.orders:
            about_peaks = speeds_about(
                meetings(frequencies, np.array([order]), *ends), ratios, ends
            )
            added.append(np.setdiff1d(np.append(about_peaks, even), known))
        counts = [speeds.size for speeds in added]
        about = np.repeat(np.arange(len(added)), counts), np.concatenate(added)
        splits = np.cumsum(counts)[:-1]
        answers = self.answer(*about) if any(counts) else self._none
        parts = [np.split(answer, splits) for answer in answers]
        maxima = map(self._maxima, range(len(added)), added, *parts)
        return _Maxima._make(np.concatenate(column) for column in zip(*maxima, strict=True))

    @property
    def _none(self) -> tuple[ComplexArray, Flags, ComplexArray]:
        """What `answer` returns of no speed."""
        forces = self.forces.at(np.array(0), self.response.speeds)
        return self.response.unknowns[0][:0], self.response.unbounded[0][:0], forces[:0]

    def _maxima(
        self,
        place: int,
        added: Array,
        more: ComplexArray,
        endless: Flags,
        beside: ComplexArray,
    ) -> _Maxima:
        order, known = float(self.response.orders[place]), self.response.speeds
        motion = np.concatenate((self.response.unknowns[place], more))
        forces = np.concatenate((self.forces.at(np.array(place), known), beside))
        unbounded = np.concatenate((self.response.unbounded[place], endless))
        ascending = np.argsort(np.concatenate((known, added)))
        grid = np.concatenate((known, added))[ascending]
        values = np.abs(
            self.quantities.at(order * grid, grid, motion[ascending], forces[ascending])
        )
        values[unbounded[ascending]] = np.inf
        middle = values[1:-1]
        tops, places = np.nonzero((middle > values[:-2]) & (middle >= values[2:]))
        low, at, high = grid[tops], grid[tops + 1], grid[tops + 2]
        value = middle[tops, places]
        bounded = np.isfinite(value)
        # Of 1 / amplitude^2 over that in the middle, 1 there and more beside it.
        with np.errstate(divide="ignore", over="ignore"):
            left, right = (
                np.minimum((np.where(bounded, value, 0.0) / values[tops + step, places]) ** 2, 1e6)
                - 1.0
                for step in (0, 2)
            )
        below, above = at - low, high - at
        bend = (left / below + right / above) / (below + above)
        slope = right / above - bend * above
        flat = ~bounded | ~(bend > 0.0)
        move = np.where(flat, 0.0, -0.5 * slope / np.where(flat, 1.0, bend))
        lowest = 1.0 + 0.5 * slope * move
        value = np.where(lowest > 0.0, value / np.sqrt(np.maximum(lowest, 1e-12)), value)
        # An unbounded one is where it is.
        return _Maxima(
            np.full(tops.size, place),
            places,
            np.clip(at + move, low, high),
            value,
            np.where(bounded, low, at),
            np.where(bounded, high, at),
            np.where(flat, 0.0, bend),
        )

    def made(self, maxima: _Maxima, speeds: Array) -> "_Made":
        """Return what makes maxima, at their speeds as they are known."""
        orders, places = maxima.orders, maxima.places
        motion, unbounded, forces = self.answer(orders, speeds)
        w = self.response.orders[orders] * speeds
        rows = self.quantities.rows_at(places, w, speeds)
        value = self.quantities.each(places, w, speeds, motion, forces)
        # Motions have their static part.
        balanced = self.quantities.loads[places][:, np.newaxis] * (forces @ self.pushes)
        forces = forces @ self.expand
        size = np.where(value == 0.0, 1.0, np.abs(value))[:, np.newaxis]
        phase = np.conj(value[:, np.newaxis] / size)
        *powers, reached = self._contributions(w, speeds, forces, balanced, rows)
        parts, bends = ((power * phase).real for power in powers)
        shares = parts / size
        # Where nothing bounds the amplitude, the mode at its own frequency makes it.
        apart = np.abs(np.append(self.modes.eigenvalues.imag, np.inf) - w[:, np.newaxis])
        alone = (apart == np.min(apart, axis=1, keepdims=True)).astype(np.float64)
        shares, bends = (
            np.where(unbounded[:, np.newaxis], alone, part) for part in (shares, bends)
        )
        in_band = np.column_stack((reached, np.zeros(w.size, dtype=bool)))
        in_band |= unbounded[:, np.newaxis] & (alone > 0.0)
        mode = np.argmax(bends, axis=1)
        each = np.arange(w.size)
        # The amplitude of a mode alone bends half as much as its part in phase does.
        bent = 0.5 * np.abs(value) * maxima.bends / self.response.orders[orders] ** 2
        by_modes = np.sum(np.maximum(bends[:, :-1], 0.0), axis=1) >= 2.0 * MODAL * bent
        in_band &= (by_modes | unbounded)[:, np.newaxis]
        of_mode = in_band[each, mode] & (bends[each, mode] > 0.0)
        ripple = of_mode & (np.abs(shares[each, mode]) < LEAST_PART)
        of_mode &= ~ripple
        first = np.abs(motion @ motion_rows(self.response, [0])[0][0])
        return _Made(
            np.where(unbounded, np.inf, np.abs(value)),
            np.where(unbounded, np.inf, first),
            np.where(of_mode, mode, np.argmax(shares, axis=1)),
            shares,
            of_mode,
            in_band & (bends >= SEVERAL * np.max(bends, axis=1, keepdims=True)) & (bends > 0.0),
            ripple,
        )

    def _contributions(
        self,
        w: Array,
        speeds: Array,
        forces: ComplexArray,
        balanced: ComplexArray,
        rows: Array,
    ) -> tuple[ComplexArray, ComplexArray, Flags]:
        """Return `ComplexModes.contributions` of power 1 and 3, and which modes are in their band.

        What varies is taken as it is there, its modes by the numbers of those of the constant stiffness.
        """

        def of(modes: ComplexModes, some: slice) -> list[NDArray[Any]]:
            exciting = w[some], forces[some], rows[some]
            reached = modes.magnifiers(w[some]) >= BAND * modes.largest_magnifiers
            first = modes.contributions(*exciting, balanced=balanced[some])
            return [first, modes.contributions(*exciting, 3), reached]

        if not self.response.system.varying:
            first, third, reached = of(self.modes, slice(None))
            return first, third, reached
        count = self.modes.numbers.size
        parts, bends = np.zeros((2, w.size, count + 1), dtype=np.complex128)
        in_band = np.zeros((w.size, count), dtype=bool)
        for row in range(w.size):
            modes = modes_at(self.response, float(w[row]), float(speeds[row]))
            columns = [
                int(np.argmax(match)) if np.any(match := self.modes.numbers == number) else count
                for number in modes.numbers
            ]
            first, third, reached = of(modes, slice(row, row + 1))
            np.add.at(parts[row], [*columns, count], first[0])
            np.add.at(bends[row], [*columns, count], third[0])
            in_band[row] = np.bincount(columns, reached[0], count + 1)[:count] > 0.0
        return parts, bends, in_band

    def peaks(
        self,
        maxima: _Maxima,
        made: "_Made",
        scales: Array,
        kinds: Array,
        preferred: Flags,
        least: float | None,
    ) -> list[DampedCritical]:
        """Return the critical speeds of maxima, those of several places taken together."""
        if not maxima.speeds.size:
            return []
        numbers = np.append(self.modes.numbers, 0)
        ratios = np.append(self.modes.damping_ratios, 1.0)
        near = np.clip(ratios[made.mode], LEAST_RATIO, NEARLY) * maxima.speeds
        scale = scales[maxima.places]
        share = np.divide(maxima.values, scale, out=np.ones(scale.size), where=scale > 0.0)
        share = np.minimum(share, 1.0)
        groups = maxima.together(share, near)
        # Values beside the largest of their kind, since loads and motions have different units.
        kind = kinds[maxima.places]
        size = np.divide(maxima.values, kind, out=np.ones(kind.size), where=kind > 0.0)
        ranks = np.lexsort((size, self.quantities.loads[maxima.places], preferred[maxima.places]))
        rank = np.empty(ranks.size)
        rank[ranks] = np.arange(ranks.size)
        main = []
        for group in groups:
            largest = np.max(share[group])
            stands = share[group] >= (LARGE * largest if least is None else min(least, largest))
            ripple = made.ripple[group]
            stands &= ~ripple | np.all(ripple | ~stands)
            main.append(group[np.argmax(np.where(stands, rank[group], -1.0))])
        chosen = maxima.chosen(np.array(main))

        def amplitudes(speeds: Array) -> Array:
            orders, places = (np.tile(each, len(speeds)) for each in (chosen.orders, chosen.places))
            return self._amplitudes(orders, places, speeds.ravel()).reshape(speeds.shape)

        speeds = _highest(amplitudes, chosen.low, chosen.high)
        there = self.made(chosen, speeds)
        near = maxima.speeds.copy()
        near[main] = speeds
        names, places = self.quantities.names, chosen.places.tolist()
        peaks = []
        for row, group in enumerate(groups):
            mode, there_too = (
                there.mode[row],
                there.mode[row : row + 1][there.of_mode[row : row + 1]],
            )
            makers = (there_too, there.makers[row], made.mode[group][made.of_mode[group]])
            each = np.concatenate([numbers[some] for some in makers]).tolist()
            order, speed = float(self.response.orders[chosen.orders[row]]), float(speeds[row])
            varies = self.response.system.varying
            peaks.append(
                _critical(
                    modes_at(self.response, order * speed, speed) if varies else self.modes,
                    order,
                    int(numbers[mode]),
                    speed=speed,
                    amplitude=float(there.value[row]),
                    first_amplitude=float(there.first[row]),
                    place=names[places[row]],
                    of_load=bool(self.quantities.loads[places[row]]),
                    others=tuple(
                        names[other]
                        for other in maxima.places[group].tolist()
                        if other != places[row]
                    ),
                    spread=(float(np.min(near[group])), float(np.max(near[group]))),
                    modes=tuple(dict.fromkeys(number for number in each if number)),
                    mode_share=float(there.shares[row, mode]),
                    in_band=bool(there.of_mode[row]),
                    severity=float(np.max(share[group])),
                )
            )
        return peaks

    def _amplitudes(
        self, orders: NDArray[np.intp], places: NDArray[np.intp], speeds: Array
    ) -> Array:
        motion, unbounded, forces = self.answer(orders, speeds)
        w = self.response.orders[orders] * speeds
        values = self.quantities.each(places, w, speeds, motion, forces)
        return np.where(unbounded, np.inf, np.abs(values))


class _Made(NamedTuple):
    """What makes maxima (m,): value, that of the first node, mode (index; last: overdamped motions).

    Then the shares of all modes in the value (m, modes + 1), whether the maximum is the mode's own, all
    modes that make it (m, modes + 1), and whether a mode in its band is but a ripple on others.
    """

    value: Array
    first: Array
    mode: NDArray[np.intp]
    shares: Array
    of_mode: Flags
    makers: Flags
    ripple: Flags

    def chosen(self, which: Flags) -> "_Made":
        """Return that of some maxima."""
        return _Made._make(column[which] for column in self)


def _highest(at: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Return where functions, of places (t, m), are highest within brackets (m,), each with one maximum."""
    first, last = low, high
    for _ in range(ROUNDS):
        tried = low + (high - low) * TRIED[:, np.newaxis]
        top = np.take_along_axis(tried, np.argmax(at(tried), axis=0)[np.newaxis], axis=0)[0]
        step = TRIED[0] * (high - low)
        low, high = top - step, top + step
    # The vertex of the parabola through the last three; without bounds there is none.
    left, middle, right = np.nan_to_num(at(np.stack((low, top, high))), posinf=0.0)
    bend = 2.0 * middle - left - right
    move = np.divide(right - left, 2.0 * bend, out=np.zeros(top.size), where=bend > 0.0)
    return np.asarray(np.clip(top + np.clip(move, -1.0, 1.0) * step, first, last))


def _critical(known: ComplexModes, order: float, number: int, **peak: Any) -> DampedCritical:
    """Return a critical speed with the frequencies of its mode; no peak by default."""
    none = float("nan")
    places = np.flatnonzero(known.numbers == number)

    def met(frequencies: Array | None) -> float:
        if frequencies is None or not number:
            return none
        return 2.0 * np.pi * float(frequencies[number - 1]) / order

    unknown: dict[str, Any] = {"speed": none, "amplitude": none, "place": "", "mode_share": none}
    return DampedCritical(
        order=order,
        mode=number,
        mode_frequency=float(known.frequencies[places[0]]) if places.size else none,
        damping_ratio=float(known.damping_ratios[places[0]]) if places.size else none,
        undamped_speed=met(known.undamped),
        locked_speed=met(known.locked),
        **(unknown | {"in_band": False, "severity": 0.0} | peak),
    )
