"""Forced vibration of an engine's chains over its speeds, under the forces of its cylinders."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags
from crankbase.choices import check_choice, check_not_given
from crankbase.diagrams import write_title
from crankbase.errors import InputError
from crankbase.frames import table_of
from crankbase.quantity import RPM
from crankbase.results import (
    Flat,
    InItsUnit,
    Internal,
    Number,
    Part,
    Quantity,
    Result,
    Speed,
    result,
)
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.vibration.chain_answers import Answers, ChainAnswer, EngineChains
from crankfem.analyses.vibration.engine_excitation import (
    Frequencies,
    calculated_speeds,
    compared_axial_forces,
    excitation_remarks,
    forces_over_speeds,
    merged_speeds,
)
from crankfem.analyses.vibration.engine_limits import (
    Findings,
    assessment_end_speeds,
    engine_limits,
    limit_findings,
    limited_quantities,
    limited_series,
)
from crankfem.analyses.vibration.modes import Vibration
from crankfem.files.engine.engine_file import EngineFile
from dynamics.assessment.barred_ranges import limit_end_speed
from dynamics.assessment.limits import AmplitudeCurve, VibrationLimit, usage
from dynamics.assessment.response_curves import refined_maxima
from dynamics.critical import major_orders
from dynamics.excitation.chain_excitation import AxialForceComparison
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics
from dynamics.indices import at_most, within
from dynamics.plots.curves import Quantity as Drawn
from dynamics.response.damped_criticals import LEAST_PEAK, DampedCritical, damped_criticals
from dynamics.response.loads import PowerBalance, checked_power_balance
from dynamics.response.series import OrderSeries
from fem.superelement import ShaftCompliances

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Forced = Literal["amplitude", "load", "stress", "power", "axial forces"]
FORCED: tuple[Forced, ...] = ("amplitude", "load", "stress", "power", "axial forces")


# Shares below this are round-off: the cylinders cancel.
ROUND_OFF = 1e-12


@result("peak", "speed", "plain_sum", eq=True)
class Largest(Result):
    """The largest amplitude at some speeds, all orders together, and that of their plain sum."""

    peak: InItsUnit
    speed: Speed
    plain_sum: Annotated[float, Quantity(".unit", key="plain_sum_peak")]

    @classmethod
    def of(cls, series: OrderSeries, place: int, some: Any = slice(None)) -> "Largest":
        """Find it at a location and at some of the speeds."""
        summed = series.synthesis
        amplitude = summed.amplitude[some, place]
        worst = int(np.argmax(amplitude))
        plain_sum = float(np.max(summed.plain_sum[some, place]))
        return cls(float(amplitude[worst]), float(series.speeds[some][worst]), plain_sum)


@result("element", "largest.peak", "largest.speed", eq=True)
class PlacePeak(Result):
    """The largest amplitude of a location: at all speeds, at running ones, below and above."""

    element: str
    unit: str
    largest: Flat[Largest]
    running: Largest | None
    below: Largest | None
    above: Largest | None


@result("order", "amplitude", "speed", eq=True)
class OrderPeak(Result):
    """The largest amplitude of one order."""

    order: Number
    amplitude: InItsUnit
    speed: Speed


@result("node", "peaks")
class FreeEnd(Result):
    """Motion of a crankshaft's free end over the speed."""

    node: str
    unit: str
    synthesis: Annotated[Array, Quantity(".unit", "all orders over the cycle")]
    plain_sum: Annotated[Array, Quantity(".unit", "of the amplitudes of all orders")]
    orders: tuple[OrderPeak, ...]
    peaks: tuple[PlacePeak, ...]


@result("order", "alone", "in_shaft", "difference", eq=True)
class OrderForces(Result):
    """Largest exciting axial force of any throw at the highest speed by one order, by two methods."""

    order: Number
    alone: InItsUnit
    in_shaft: InItsUnit
    difference: Annotated[float, Quantity("1", "largest of any throw, of the largest in the shaft")]
    unit: str = "N"


@result("largest", "speed", "error")
class LargestPower(Result):
    """The largest heat of all damping at any speed, and the error of the power balance.

    Attributes
    ----------
    error : float or None
        None where vibration is unbounded at all speeds.
    dampers : mapping of str to float
        Heat of each dashpot then [W].
    """

    error: Annotated[float | None, Quantity("1")]
    largest: InItsUnit
    speed: Speed
    dampers: Annotated[Mapping[str, float], Quantity("W")]
    unit: str = "W"


@result("kind", "orders", "speeds", "resonances", "damping")
class ForcedVibration(ChainAnswer, Result):
    """One kind of forced vibration (axial or torsional) of an engine over its speeds.

    Attributes
    ----------
    damping : tuple of str
        Sources of damping, one sentence each.
    forces : CylinderForces
        Of the cylinders on their pins.
    running_range, judged_range : tuple of two floats
        Speeds at which the engine runs, and at which vibration is assessed: above as far as a limit applies
        and speeds were calculated [rad/s].
    resonances : tuple of DampedCritical
        Peaks of each single order at any element or node, with all damping, ascending in speed, at
        all speeds assessed: the running range, and above it as far as a limit applies. Peaks of the forces
        are among them, not `in_band`. Orders that meet a mode without a peak have no speed and come last.
    started_through : tuple of DampedCritical
        The same below the running range, as far as calculated, which are passed on every start.
    axial_forces : AxialForceComparison or None
        Exciting force of each throw by its own coefficient and by the assembled shaft.
    """

    _: KW_ONLY
    damping: tuple[str, ...]
    forces: Internal[CylinderForces]
    running_range: Annotated[
        tuple[float, float], Quantity("rad/s", exported="1/min", key="running_rpm")
    ]
    judged_range: Annotated[
        tuple[float, float], Quantity("rad/s", exported="1/min", key="judged_rpm")
    ]
    resonances: tuple[DampedCritical, ...] = ()
    started_through: tuple[DampedCritical, ...] = ()
    axial_forces: Internal[AxialForceComparison | None] = None

    @cached_property
    def kind(self) -> Part[str]:
        """Axial or torsional."""
        return self.engine_chain.kind

    @cached_property
    def all_remarks(self) -> Annotated[tuple[str, ...], Quantity(key="remarks")]:
        """Those on the forces that mechanism and load do not have already, and on the excitation."""
        return self.forces.own_remarks + self.remarks

    @cached_property
    def method(self) -> Part[str]:
        """How the equations of motion were solved."""
        return self.response.method

    @cached_property
    def orders(self) -> Annotated[Array, Quantity("1")]:
        """In cycles per crankshaft revolution."""
        return self.response.orders

    @cached_property
    def speeds(self) -> Annotated[Array, Quantity("rad/s", exported="1/min")]:
        """At which vibration is calculated [rad/s]."""
        return self.response.speeds

    @cached_property
    def free_end_motion(self) -> Annotated[FreeEnd, Quantity(key="free_end")]:
        """Motion of the free end over the speed."""
        series, unit = self.free_end, MOTION[self.kind].si
        each = zip(series.orders.tolist(), series.amplitude[:, :, 0], strict=True)
        return FreeEnd(
            node=series.names[0],
            unit=unit,
            synthesis=series.synthesis.amplitude[:, 0],
            plain_sum=series.synthesis.plain_sum[:, 0],
            orders=tuple(
                OrderPeak(order, float(curve.max()), float(series.speeds[curve.argmax()]))
                for order, curve in each
            ),
            peaks=self._peaks(series, unit),
        )

    @cached_property
    def load_peaks(self) -> Annotated[tuple[PlacePeak, ...], Quantity(key="loads")]:
        """Largest torque or force of each element."""
        return self._peaks(self.loads.elements, MOTION[self.kind].load)

    @cached_property
    def stress_peaks(self) -> Annotated[tuple[PlacePeak, ...] | None, Quantity(key="stress")]:
        """Largest nominal stress of each element of the crankshaft; None in the axial direction."""
        return None if self.stress is None else self._peaks(self.stress, "Pa")

    def _peaks(self, series: OrderSeries, unit: str) -> tuple[PlacePeak, ...]:
        parts = [some if np.any(some) else None for some in self.speed_parts.values()]
        return tuple(
            PlacePeak(
                name,
                unit,
                Largest.of(series, place),
                *(None if some is None else Largest.of(series, place, some) for some in parts),
            )
            for place, name in enumerate(series.names)
        )

    @cached_property
    def largest_power(self) -> Annotated[LargestPower, Quantity(key="power")]:
        """Speed with the most heat, and the error of the power balance."""
        power = self.power
        bounded = ~np.any(power.unbounded, axis=0)
        total = power.dissipated.sum(axis=0, where=~power.unbounded)
        worst = int(np.argmax(np.where(bounded, total, -1.0)))
        return LargestPower(
            error=power.error if np.any(bounded) else None,
            largest=float(total[worst]),
            speed=float(self.speeds[worst]),
            dampers={
                name: float(power.dashpots[:, worst, place].sum())
                for place, name in enumerate(power.dashpot_names)
                if bounded[worst]
            },
        )

    @cached_property
    def forces_by_order(
        self,
    ) -> Annotated[tuple[OrderForces, ...] | None, Quantity(key="axial_forces")]:
        """Largest exciting axial force of any throw at the highest speed; None if torsional."""
        compared = self.axial_forces
        if compared is None:
            return None
        alone, in_shaft = (
            np.abs(forces[:, -1]).max(axis=1) for forces in (compared.alone, compared.in_shaft)
        )
        columns = np.array([alone, in_shaft, compared.difference[:, -1]])
        columns[:, alone <= ROUND_OFF * alone.max()] = 0.0
        return tuple(map(OrderForces, self.orders.tolist(), *columns.tolist()))

    @cached_property
    def power(self) -> PowerBalance:
        """Mean power put in by the forces and lost in the dampers, checked against each other."""
        return checked_power_balance(self.response)

    @property
    def frequencies(self) -> Array:
        """Damped natural frequencies [Hz] by the number of the mode; undamped for an overdamped mode."""
        damped = self.modes.undamped.copy()
        numbered = self.modes.numbers > 0
        damped[self.modes.numbers[numbered] - 1] = self.modes.frequencies[numbered]
        return damped

    def damped_shifts(self, mode: int, order: float) -> tuple[float, ...]:
        """Return the critical speeds of an order and a mode with damping over those without, peak by peak.

        Beyond the assessed speeds this is the ratio of the mode's frequencies.
        """
        undamped = float(self.modes.undamped[mode - 1])
        met = [
            resonance
            for resonance in self.resonances
            if resonance.order == order and mode in (resonance.mode, *resonance.modes)
        ]
        if not met:
            return (float(self.frequencies[mode - 1]) / undamped,)
        return tuple(
            peak.frequency / undamped for peak in met if peak.has_peak and mode in peak.modes
        )

    @property
    def peaks(self) -> tuple[DampedCritical, ...]:
        """The resonances that have a speed and `LEAST_PEAK` of a place's largest peak, or more."""
        return tuple(
            resonance
            for resonance in self.resonances
            if resonance.has_peak and resonance.in_band and resonance.severity >= LEAST_PEAK
        )

    @property
    def speed_parts(self) -> dict[str, Flags]:
        """Which speeds are "running", "below", and "above" as far as assessed."""
        speeds = self.speeds
        low, high = self.running_range
        below, running = ~at_most(low, speeds), within(speeds, low, high)
        above = ~at_most(speeds, high) & at_most(speeds, self.judged_range[1])
        return {"running": running, "below": below, "above": above}

    def largest_place(self, series: OrderSeries) -> int:
        """Return the index of the location of a series with the largest amplitude at running speeds."""
        inside = within(series.speeds, *self.running_range)
        return int(np.argmax(np.max(series.synthesis.amplitude[inside], axis=0)))

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        show: Forced = "amplitude",
        limits: Mapping[str, ArrayLike] | None = None,
        barred: Sequence[tuple[float, float]] = (),
    ) -> "Axes":
        """Draw one quantity over the speeds of the engine.

        Parameters
        ----------
        show : {"amplitude", "load", "stress", "power", "axial forces"}
            Motion of the free end; torque or force in the crankshaft's element with the largest load at
            running speeds; nominal stress in the element with the largest one; power in and out; the
            exciting axial force of the first throw.
        limits : mapping of str to (S,) array_like, optional
            Limits over the response's speeds by their name [SI], not applicable to power and axial forces.
        barred : sequence of (low, high), optional
            Speed ranges to shade [rad/s], not applicable to power and axial forces.

        Raises
        ------
        InputError
            If `show` is unknown, this kind of vibration has none, or limits or ranges are
            invalid or not applicable.
        """
        check_choice("show", show, FORCED, "these are drawn over the speed")
        if show in ("power", "axial forces"):
            check_not_given("limits", limits, show, "nothing limits it")
            check_not_given("barred", barred, show, "ranges are shaded beside amplitudes")
        if show == "power":
            return self.power.plot(axes)
        if show == "axial forces":
            if self.axial_forces is None:
                raise self._missing(show)
            return self.axial_forces.plot(axes)
        quantity: Drawn = MOTION[self.kind].quantity
        series = self.free_end
        if show == "stress":
            if self.stress is None:
                raise self._missing(show)
            series, quantity = self.stress, "stress"
        elif show == "load":
            series = self.crank_elements
            quantity = "force" if self.kind == "axial" else "torque"
        place = 0 if show == "amplitude" else self.largest_place(series)
        running = self.running_range
        axes = series.plot(
            axes, place, quantity=quantity, limits=limits, barred=barred, running=running
        )
        if show == "amplitude":
            write_title(axes, f"{self.kind.capitalize()} vibration of the free end")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the resonances at the speeds assessed.

        With the amplitude of the free end, and the value in SI at the place of the peak.

        A resonance without a peak has no speed (NaN).

        Units are in ``frame.attrs["units"]``.
        """
        names = {"amplitude": "value", "first_amplitude": "amplitude"}
        frame = table_of(self.resonances).rename(columns=names)
        units = frame.attrs["units"]
        frame.attrs["units"] = {names.get(name, name): unit for name, unit in units.items()}
        return frame

    def columns(self) -> tuple[dict[str, Array], str]:
        """Return the amplitudes over the speed, of the free end by order and of loads, and a description."""
        free_end, loads = self.free_end, self.loads.elements
        unit = MOTION[self.kind].si
        columns = {
            "speed_rpm": self.speeds * RPM,
            f"free_end_synthesis_{unit}": free_end.synthesis.amplitude[:, 0],
            f"free_end_plain_sum_{unit}": free_end.synthesis.plain_sum[:, 0],
        }
        for place, order in enumerate(free_end.orders.tolist()):
            columns[f"free_end_order_{order:g}_{unit}"] = free_end.amplitude[place, :, 0]
        for place, name in enumerate(loads.names):
            load = MOTION[self.kind].load.replace(" ", "")
            columns[f"{name} [{load}]"] = loads.synthesis.amplitude[:, place]
        return columns, f"{self.kind} vibration, amplitudes; inf is unbounded"

    def to_xarray(self) -> Any:
        """Return the motion of all nodes over orders and speeds; see `ForcedResponse.to_xarray`."""
        return self.response.to_xarray(MOTION[self.kind].quantity)

    def _missing(self, show: str) -> InputError:
        return InputError(
            f"show: given {show!r}; allowed for {self.kind} vibration are the others, because that is "
            "calculated for the other kind only."
        )


def forced_vibrations(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    axial: Vibration,
    torsional: Vibration,
    shaft: ShaftCompliances,
    analysis: Analyses,
    further: Frequencies = (),
) -> tuple[ForcedVibration, ForcedVibration]:
    """Calculate the forced vibration of an engine's chains over its speeds.

    Parameters
    ----------
    axial, torsional : Vibration
        Modes of the chains with the chosen compliances.
    further : (m,) array, optional
        Further natural frequencies to be resolved by the speeds [Hz].

    Returns
    -------
    axial, torsional : ForcedVibration
        On one grid of speeds, that of `calculated_speeds` and the speeds with the largest use of each limit.
        Axial vibration is excited by the radial forces and by the torques of the torsional
        vibration.
    """
    chains = EngineChains.of(engine_file, axial, torsional, shaft)
    # The worst speeds are looked for among those of the chains alone, so that what else is to be
    # calculated has no part in them.
    speeds, _, worst = _searched(chains, harmonics)
    if len(further):
        speeds = calculated_speeds(engine_file, harmonics.orders, chains.damped, further)
    lengthened, twisted = vibrations_at(chains, harmonics, merged_speeds(speeds, worst))
    compared = compared_axial_forces(
        engine_file, lengthened.forces, chains.pulled.compliances, shaft, analysis
    )
    limits, quantities = engine_limits(engine_file)[0], limited_quantities(engine_file)
    limited = [
        (quantities[name].kind, limits[name], series)
        for name, series in limited_series(engine_file, lengthened, twisted).items()
    ]
    lengthened, twisted = (
        replace(
            forced,
            resonances=tuple(peak for peak in peaks if not _is_passed(peak, forced)),
            started_through=tuple(peak for peak in peaks if _is_passed(peak, forced)),
        )
        for forced in (lengthened, twisted)
        for peaks in [resonances_of(engine_file, forced, limited, below=True)]
    )
    return replace(lengthened, axial_forces=compared), twisted


def _is_passed(peak: DampedCritical, forced: ForcedVibration) -> bool:
    return peak.has_peak and not at_most(forced.running_range[0], peak.speed)


def limit_curves(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    vibrations: Sequence[Vibration],
    shaft: ShaftCompliances,
) -> Findings:
    """Return each limit with its curves at the speeds of `forced_vibrations`, and nothing else."""
    axial, torsional = vibrations
    chains = EngineChains.of(engine_file, axial, torsional, shaft)
    grid, answers, worst = _searched(chains, harmonics)
    curves = limit_findings(engine_file, *answers)
    speeds = merged_speeds(grid, worst)
    known, kept = np.isin(speeds, grid), np.isin(grid, speeds)
    if np.all(known):
        return curves
    between = limit_findings(engine_file, *chains.at(harmonics, speeds[~known]))
    merged = []
    for (limit, curve), (_, added) in zip(curves, between, strict=True):
        values = np.empty(speeds.size)
        values[known], values[~known] = curve.values[kept], added.values
        merged.append((limit, AmplitudeCurve(curve.name, speeds, values)))
    return merged


def vibrations_at(
    chains: EngineChains, harmonics: CylinderHarmonics, speeds: Array
) -> tuple[ForcedVibration, ForcedVibration]:
    """Return the axial and the torsional vibration at speeds [rad/s], without resonances."""
    file = chains.engine_file
    forces = forces_over_speeds(file, harmonics, speeds)
    engine, ends = file.engine, assessment_end_speeds(file)
    lengthened, twisted = (
        ForcedVibration(
            engine_chain=answer.engine_chain,
            response=answer.response,
            moduli=answer.moduli,
            by_torque=answer.by_torque,
            remarks=(*excitation_remarks(file, answer.engine_chain.kind), *answer.remarks),
            damping=damped.record,
            forces=forces,
            running_range=(engine.lowest_speed, engine.highest_speed),
            judged_range=(ends[0], min(ends[-1], float(speeds[-1]))),
        )
        for damped, answer in zip(chains.damped, chains.answers(forces), strict=True)
    )
    return lengthened, twisted


def resonances_of(
    engine_file: EngineFile,
    forced: ForcedVibration,
    limited: Sequence[tuple[str, VibrationLimit, OrderSeries]] = (),
    below: bool = False,
) -> tuple[DampedCritical, ...]:
    """Return the peaks of all elements and nodes, ascending in speed, and then modes without a peak.

    `below` includes those below the running range.

    Major orders are those in which all cylinders fire in phase. A peak of the exciting forces
    without a mode near it is not a resonance; it is not `in_band`. `limited` has a kind of vibration, its
    limit, and what that limits; these places are told first.
    """
    response, motion = forced.response, MOTION[forced.kind]
    major = major_orders(response.orders, engine_file.engine.firing_angles)
    criticals = damped_criticals(
        response,
        speed_range=forced.judged_range,
        modes=forced.modes,
        first=[name for _, _, series in limited for name in series.names],
        below=below,
    )
    listed = [
        replace(
            critical,
            kind="major" if np.any(np.isclose(major, critical.order)) else "minor",
            unit=motion.load if critical.of_load else motion.si,
            in_running_range=_speed(critical) <= forced.running_range[1]
            and not _is_passed(critical, forced),
            limit_used=max(
                (
                    _used_alone(forced, critical, limit, series)
                    for kind, limit, series in limited
                    if kind == forced.kind and critical.has_peak
                ),
                default=0.0,
            )
            or np.nan,
        )
        for critical in criticals
    ]
    return tuple(sorted(listed, key=lambda critical: (not critical.has_peak, _speed(critical))))


def _used_alone(
    forced: ForcedVibration, critical: DampedCritical, limit: VibrationLimit, series: OrderSeries
) -> float:
    """Return the share of a limit that the order of a peak alone uses at its speed; 0 without a limit.

    Of a peak that is passed on starting, that of the limit for passing. At the place of the peak the
    amplitude is that of the peak, elsewhere that of the nearest calculated speed.
    """
    curve = limit.passing if _is_passed(critical, forced) else limit.continuous
    if curve is None:
        return 0.0
    order = int(np.argmin(np.abs(series.orders - critical.order)))
    speed = int(np.argmin(np.abs(series.speeds - critical.speed)))
    reached = series.amplitude[order, speed].copy()
    if critical.place in series.names:
        known = forced.loads.elastic if critical.of_load else forced.response.elastic
        near = known.amplitude[order, speed, known.names.index(critical.place)]
        if 0.0 < near < np.inf:
            reached[series.names.index(critical.place)] *= critical.amplitude / near
    return float(np.max(reached) / curve.at(np.array([critical.speed]))[0])


def _speed(critical: DampedCritical) -> float:
    """Speed of a peak; without one that at which the order meets the undamped mode [rad/s]."""
    return critical.speed if critical.has_peak else critical.undamped_speed


def _searched(chains: EngineChains, harmonics: CylinderHarmonics) -> tuple[Array, Answers, Array]:
    """Return the grid of speeds, the answers there, and the worst speeds, closer than the grid.

    Those with the largest use of the limits and motion of the free ends.
    """
    file = chains.engine_file
    grid = calculated_speeds(file, harmonics.orders, chains.damped)
    answers = chains.at(harmonics, grid)

    running = (file.engine.lowest_speed, file.engine.highest_speed)

    def used(speeds: Array) -> Array:
        """Used shares of the limits where they apply, (curves, speeds), and free ends' amplitudes."""
        there = answers if speeds is grid else chains.at(harmonics, speeds)
        shares = [
            np.where(speeds <= limit_end_speed(limit, running), usage(limit, curve), 0.0)
            for limit, curve in limit_findings(file, *there)
        ]
        # Speeds below the running ones are passed on starting: their maxima are for themselves.
        kept = [np.where(within(speeds, *running), share, 0.0) for share in shares]
        moved = [answer.free_end.synthesis.amplitude[:, 0] for answer in there]
        return np.array([*shares, *kept, *moved])

    return grid, answers, refined_maxima(used, grid, least=1.0)
