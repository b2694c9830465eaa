"""Cause of a peak: the contribution of each order, and whether a resonance makes that order large."""

from dataclasses import replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from crankbase.array_checks import ComplexArray
from crankbase.frames import DataFrame, table_of
from crankbase.results import InItsUnit, Internal, Number, Quantity, Result, result
from crankbase.sentences import kept
from dynamics import wording
from dynamics.indices import index_of_name
from dynamics.response.complex_modes import ComplexModes, complex_modes, modes_at
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import named_quantity, pushing
from dynamics.response.order_excitation import OrderExcitation, checked_speed_index
from dynamics.response.series import OrderSeries, extreme_angles

# A mode makes an order's amplitude if it gives more than half of it.
DOMINATES = 0.5
# Of an amplitude D times the static one, (D - 1) / D comes from resonance: half and more from D = 2 on.
AMPLIFIED = 2.0
# At the resonance: within the half-power bandwidth of the mode's peak, and within 5 % of its frequency.
HALF_POWER, AT_RESONANCE = np.sqrt(0.5), 0.05
# Near it: within the usual margin of critical speeds from running speeds, 10 %.
NEAR_RESONANCE = 0.1
# Orders with a part below this share of the peak are told together.
LEAST_PART = 0.02
# So many orders and more are told as "0.5 to 5", and up to so many small ones between them with them.
RUN, BRIDGED = 3, 2

State = Literal["at resonance", "near resonance", "amplified", "forced"]


@result("order", "contribution", "amplitude", "state", "mode", eq=True)
class OrderPart(Result):
    """The contribution of one order to a peak of all orders together.

    Parameters
    ----------
    order : float
        In cycles per crankshaft revolution.
    contribution : float
        Half the difference of the order's values at the two angles at which the sum of all orders is
        highest and lowest: these add up to the peak. Negative if the order reduces the peak.
    amplitude : float
        Of the order alone; the magnitude of the contribution is not larger.
    state : {"at resonance", "near resonance", "amplified", "forced"}
        Whether the order is at a resonance; see `peak_cause`.
    mode : int
        Number of the elastic mode with the largest part of the order's amplitude, 0 for none.
    mode_share : float
        Part of the order's amplitude from this mode.
    magnifier : float
        Dynamic magnifier of this mode at the order's frequency.
    detuning : float
        Frequency of the order over that of the mode, less 1.
    kind : str
        Vibration of the mode, "torsional" or "axial"; may be empty.
    """

    order: Number
    contribution: InItsUnit
    amplitude: InItsUnit
    state: State
    mode: int
    mode_share: Number
    magnifier: Number
    detuning: Number
    kind: str = ""
    unit: Internal[str] = ""


Orders = tuple[OrderPart, ...]


@result("place", "speed [rad/s]", "amplitude", "parts", eq=True)
class PeakCause(Result):
    """Cause of a vibration's amplitude at one speed.

    Parameters
    ----------
    place : str
        Element or node that vibrates.
    kind : str
        Of the vibration, "torsional" or "axial", for the names of modes; may be empty.
    unit : str
        Of the amplitudes, in SI.
    speed : float
        [rad/s].
    amplitude : float
        Half of the range over the cycle, all orders together; inf where unbounded.
    parts : tuple of OrderPart
        Of all orders, ascending; their contributions add up to the amplitude.
    """

    place: Internal[str]
    kind: Internal[str]
    unit: Internal[str]
    speed: Internal[float]
    amplitude: Internal[float]
    parts: Annotated[tuple[OrderPart, ...], Quantity(key="orders")]

    @property
    def resonant(self) -> tuple[OrderPart, ...]:
        """Parts of orders at a resonance, the largest contribution first."""
        parts = [part for part in self.parts if part.state == "at resonance"]
        return tuple(sorted(parts, key=lambda part: -part.contribution))

    def share(self, state: State, mode: int | None = None) -> float:
        """Return the share of the peak from orders of a state, of one mode or of all."""
        chosen = [
            part.contribution
            for part in self.parts
            if part.state == state and mode in (None, part.mode)
        ]
        return sum(chosen) / self.amplitude if self.amplitude else 0.0

    @property
    def sentence(self) -> str:
        """The amplitude, its speed, and the main orders with their shares."""
        peak = wording.peak_text(self.amplitude, self.unit)
        return f"{peak} at {wording.at_speed(self.speed)}: {kept(self.reasons)}."

    @cached_property
    def reasons(self) -> Annotated[str, Quantity(key="sentence")]:
        """The main orders of the amplitude with their shares, the largest first."""
        if np.isinf(self.amplitude):
            return "; ".join(
                wording.undamped_order(part.order, _mode(part))
                for part in self.parts
                if np.isinf(part.amplitude)
            )
        least = LEAST_PART * self.amplitude
        groups = self._main(least)
        named = [part for runs in groups for run in runs for part in run]
        if not named:
            return wording.NO_MAIN_ORDER
        texts = [self._group(runs) for runs in groups]
        rest = self.amplitude - sum(part.contribution for part in named)
        if abs(rest) >= least:
            texts.append(wording.others_contribute(rest, self.unit))
        return "; ".join(texts)

    @property
    def main_shares(self) -> list[tuple[str, float]]:
        """The main orders in words and their shares, the largest first; also of what was read from JSON."""
        whole = sum(part.contribution for part in self.parts)
        shares = []
        for runs in self._main(LEAST_PART * whole):
            main, orders = runs[0][0], [(run[0].order, run[-1].order) for run in runs]
            words = wording.orders_named(orders, main.state, _mode(main) if main.mode else "")
            shares.append((words, _total(runs) / whole))
        return shares

    def to_pandas(self) -> DataFrame:
        """Return a table with a row for each order.

        Units and errors are those of `crankbase.frames.table`.
        """
        return table_of(self.parts)

    def _main(self, least: float) -> list[tuple[Orders, ...]]:
        """Return the main orders, those reported together, the largest contribution first."""
        groups = [self._runs(orders, least) for orders in self._together()]
        return sorted(filter(None, groups), key=lambda runs: -abs(_total(runs)))

    def _together(self) -> list[Orders]:
        """Return the orders reported together: those of one resonance, and all that are forced."""
        groups: dict[tuple[str, str], list[OrderPart]] = {}
        for part in self.parts:
            key = (part.state, "" if part.state == "forced" else _mode(part))
            groups.setdefault(key, []).append(part)
        return [tuple(group) for group in groups.values()]

    def _runs(self, parts: Orders, least: float) -> tuple[Orders, ...]:
        """Return the main orders of those reported together: runs of them, with the small ones between.

        A run has at least three main orders.
        """
        main = [place for place, part in enumerate(parts) if abs(part.contribution) >= least]
        if not main:
            return ()
        # Orders that are told elsewhere end a run too.
        along = [self.parts.index(parts[place]) for place in main]
        apart = np.diff(along)
        gaps = 1 + np.flatnonzero((apart > 1 + BRIDGED) | (apart > np.diff(main)))
        runs: list[Orders] = []
        for run in np.split(np.array(main), gaps):
            if len(run) >= RUN:
                runs.append(parts[run[0] : run[-1] + 1])
            else:
                runs += [(parts[place],) for place in run]
        return tuple(runs)

    def _group(self, runs: tuple[Orders, ...]) -> str:
        total, first = _total(runs), runs[0][0]
        parts = [part for run in runs for part in run]
        most = max(parts, key=lambda part: part.contribution)
        main = len(parts) > 1 and 0.5 * total <= most.contribution <= total
        return wording.orders_contribute(
            [(run[0].order, run[-1].order) for run in runs],
            first.state,
            _mode(first) if first.mode else "",
            total,
            abs(total) / self.amplitude,
            self.unit,
            (most.contribution, most.order) if main else None,
        )


def peak_cause(
    response: ForcedResponse,
    series: OrderSeries,
    place: int | str,
    speed_index: int,
    *,
    unit: str = "rad or m",
    kind: str = "",
    modes: ComplexModes | None = None,
    driven: tuple[OrderExcitation, PeakCause] | None = None,
) -> PeakCause:
    """Find the cause of a vibration's amplitude at one speed.

    Parameters
    ----------
    series : OrderSeries
        Motions, loads or stresses of the response, at its orders and speeds.
    place : int or str
        Element or node of the series, by number from 0 or name; one of the response by its name.
    speed_index : int
        Which of the speeds, from 0.
    unit : str, optional
        Of the series, in SI, for the text.
    kind : str, optional
        "torsional" or "axial", for the names of modes in the text.
    modes : ComplexModes, optional
        Of the response's system, if known.
    driven : tuple of OrderExcitation and PeakCause, optional
        The part of the excitation that comes from another vibration, such as the lengthening of a shaft
        by its twist, at the same speeds and at some of the orders, and the cause of
        that vibration at the same speed.

    Raises
    ------
    InputError
        If there is no such location or speed, or the location is not in the response.

    Notes
    -----
    y(phi) = Re sum_k Y_k exp(i k phi) is highest at one angle and lowest at another. Half of the
    difference of order k's values there is its contribution; their sum is the amplitude exactly,
    whatever the phases.

    Each order's Y_k is a sum over the damped modes. The order is amplified by a mode if

    - the mode gives more than half of Y_k, measured in phase with it;
    - its dynamic magnifier D at the order's frequency is 2 or more. Of an amplitude D times the
      static one, the share (D - 1) / D comes from resonance: at least half of it.

    It is at the resonance if, besides, D is at least 1 / sqrt(2) of the largest that the mode's damping
    allows, 1 / (2 d sqrt(1 - d^2)), which is the half-power bandwidth, and its frequency is within 5 % of
    that of the mode's peak, w_0 sqrt(1 - 2 d^2); near the resonance within 10 %, the usual margin of
    critical speeds. Where no mode gives more than half, it is amplified if the modes together, with
    their parts p_k, exceed twice what they give statically, |sum p_k| > 2 |sum p_k / D_k|. Otherwise it
    is forced: its size is that of its forces. Of a load through pushing elements, whose static part is
    none, a mode's part is what its vibration adds to that at rest. If more than half of
    these forces, by their effect, come from another vibration whose order is at a resonance or near
    one, that resonance is named.
    """
    number = index_of_name("place", place, series.names, "the series", "a peak is that of a place")
    index = checked_speed_index(speed_index, series.speeds)
    quantity = named_quantity(response, series.names[number])
    modes = complex_modes(response) if modes is None else modes
    speed = float(series.speeds[index])
    phasors = series.values[:, index, number]
    endless = series.unbounded[:, index]
    highest, lowest = extreme_angles(series.orders, phasors)
    turned = np.exp(1j * highest * series.orders) - np.exp(1j * lowest * series.orders)
    contributions = 0.5 * (phasors * turned).real
    w = series.orders * speed
    speeds = np.full(w.size, speed)
    nodes, pushes = len(response.system.expand), pushing(response)

    def on_unknowns(excitation: OrderExcitation) -> tuple[ComplexArray, ComplexArray | None]:
        """Return all forces, and of a load those that its element or others push with."""
        acting = excitation.acting[:, index]
        balanced = None if quantity.direct is None else acting @ pushes
        return acting[:, :nodes] @ response.system.expand, balanced

    forces, balanced = on_unknowns(response.excitation)
    if response.system.varying:
        # Modes are those at the main order; how springs differ at others acts as forces.
        main = int(np.argmax(contributions))
        modes = modes_at(response, float(w[main]), speed)
        forces = forces - modes.system.varying_forces(w, speeds, response.unknowns[:, index])
    rows = quantity.rows_at(np.zeros(w.size, dtype=np.intp), w, speeds)
    made = modes.contributions(w, forces, rows, balanced=balanced)
    whole = np.sum(made, axis=1, keepdims=True)
    size = np.where(whole == 0.0, 1.0, np.abs(whole))
    shares = (made / size * np.conj(whole / size)).real[:, :-1]
    magnifiers, largest = modes.magnifiers(w), modes.largest_magnifiers
    tops = np.abs(modes.eigenvalues) * np.sqrt(np.maximum(1.0 - 2.0 * modes.damping_ratios**2, 0.0))
    static = np.abs(np.sum(shares / np.where(magnifiers > 0.0, magnifiers, 1.0), axis=1))
    brought = np.zeros(w.size)
    if driven is not None:
        of = np.isin(series.orders, driven[0].orders)
        other, balanced = on_unknowns(driven[0])
        through = modes.contributions(w[of], other, rows[of], balanced=balanced)
        whole_through = np.sum(through, axis=1, keepdims=True)
        brought[of] = (whole_through / size[of] * np.conj(whole[of] / size[of])).real[:, 0]
    parts = []
    for at, order in enumerate(series.orders.tolist()):
        ranked = np.abs(modes.eigenvalues.imag - w[at]) if endless[at] else -shares[at]
        most = int(np.argmin(ranked)) if ranked.size else -1
        part = OrderPart(
            *(order, float(contributions[at]), float(np.abs(phasors[at])), "forced", 0, 0.0),
            *(1.0, 0.0),
            unit=unit,
        )
        if most >= 0 and (endless[at] or shares[at, most] > DOMINATES):
            magnifier = float(magnifiers[at, most])
            detuning = float(w[at] / np.abs(modes.eigenvalues[most])) - 1.0
            part = replace(
                part,
                amplitude=float("inf") if endless[at] else part.amplitude,
                state=_state(magnifier, float(largest[most]), float(w[at] / tops[most]) - 1.0),
                mode=int(modes.numbers[most]),
                mode_share=1.0 if endless[at] else float(shares[at, most]),
                magnifier=magnifier,
                detuning=detuning,
                kind=kind,
            )
        elif most >= 0 and abs(whole[at, 0]) > 0.0 and AMPLIFIED * static[at] < np.sum(shares[at]):
            part = replace(part, state="amplified")
        if driven is not None and part.state == "forced" and brought[at] > DOMINATES:
            # The resonance of that order of the other vibration, if it has one.
            kept = {name: getattr(part, name) for name in ("contribution", "amplitude", "unit")}
            for resonant in driven[1].parts:
                if resonant.order == order and resonant.state != "forced":
                    part = replace(resonant, **kept)
        parts.append(part)
    total = float("inf") if np.any(endless) else float(np.sum(contributions))
    return PeakCause(series.names[number], kind, unit, speed, total, tuple(parts))


def _state(magnifier: float, largest: float, detuning: float) -> State:
    if magnifier < AMPLIFIED:
        return "forced"
    if magnifier >= HALF_POWER * largest and abs(detuning) <= AT_RESONANCE:
        return "at resonance"
    return "near resonance" if abs(detuning) <= NEAR_RESONANCE else "amplified"


def _mode(part: OrderPart) -> str:
    return f"{part.kind} mode {part.mode}".strip()


def _total(runs: tuple[Orders, ...]) -> float:
    return sum(part.contribution for run in runs for part in run)
