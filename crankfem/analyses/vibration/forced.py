"""Forced vibration of an engine's chains over its speeds, under the forces of its cylinders."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice, check_not_given
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table_of
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.vibration.chain_answers import (
    Answers,
    ChainAnswer,
    EngineChains,
    crank_element_count,
    first_places,
)
from crankfem.analyses.vibration.engine_excitation import (
    Frequencies,
    calculated_speeds,
    compared_axial_forces,
    excitation_remarks,
    forces_over_speeds,
    merged_speeds,
)
from crankfem.analyses.vibration.engine_limits import (
    assessment_end_speeds,
    engine_limits,
    limit_findings,
    limited_series,
)
from crankfem.analyses.vibration.modes import Vibration
from crankfem.analyses.vibration.resonances import resonances_of
from crankfem.files.engine.engine_file import EngineFile
from dynamics.assessment.barred_ranges import limit_end_speed
from dynamics.assessment.limits import usage
from dynamics.assessment.response_curves import refined_maxima
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.axial_forces import AxialForceComparison
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics
from dynamics.indices import at_most, within
from dynamics.plots.quantities import Quantity
from dynamics.response.complex_modes import ComplexModes, complex_modes
from dynamics.response.damped_criticals import LEAST_PEAK, DampedCritical
from dynamics.response.forced import ForcedResponse
from dynamics.response.linear_system import DampedChain
from dynamics.response.loads import ElementLoads, PowerBalance, checked_power_balance
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import OrderSeries
from fem.shaft import ShaftCompliances

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Forced = Literal["amplitude", "load", "stress", "power", "axial forces"]
FORCED: tuple[Forced, ...] = ("amplitude", "load", "stress", "power", "axial forces")


@summarized("kind", "response.orders", "response.speeds [rad/s]", "resonances", "remarks")
@dataclass(frozen=True, eq=False)
class ForcedVibration:
    """One kind of forced vibration (axial or torsional) of an engine.

    Attributes
    ----------
    kind : str
    engine_chain : EngineChain
    damping : tuple of str
        Sources of damping, one sentence each.
    remarks : tuple of str
        Parts left out, a sentence each.
    forces : CylinderForces
        Of the cylinders on their pins.
    response : ForcedResponse
    loads : ElementLoads
        Torque [N m] or force [N] in each element.
    stress : OrderSeries or None
        Nominal torsional stress of the crankshaft's elements [Pa]; None in the axial direction.
    power : PowerBalance
    resonances : tuple of DampedCritical
        Peaks of each single order at any element or node, with all damping, ascending in speed, at
        all speeds assessed: the running range, and above it as far as a limit applies. Peaks of the forces
        are among them, not `in_band`. Orders that meet a mode without a peak have no speed and come last.
    by_torque : OrderExcitation or None
        Of axial vibration, the part of its excitation due to torques in the shaft.
    axial_forces : AxialForceComparison or None
        Exciting force of each throw by its own coefficient and by the assembled shaft.
    running_range, judged_range : tuple of two floats
        Speeds at which the engine runs, and at which vibration is assessed: above as far as a limit applies
        and speeds were calculated [rad/s].
    """

    kind: str
    engine_chain: EngineChain
    damping: tuple[str, ...]
    remarks: tuple[str, ...]
    forces: CylinderForces
    response: ForcedResponse
    loads: ElementLoads
    stress: OrderSeries | None
    power: PowerBalance
    resonances: tuple[DampedCritical, ...]
    by_torque: OrderExcitation | None
    axial_forces: AxialForceComparison | None
    running_range: tuple[float, float]
    judged_range: tuple[float, float]

    @cached_property
    def modes(self) -> ComplexModes:
        """The damped modes of the chain."""
        return complex_modes(self.response)

    @property
    def frequencies(self) -> FloatArray:
        """Damped natural frequencies [Hz] by the number of the mode; undamped for an overdamped mode."""
        found = self.modes.undamped.copy()
        numbered = self.modes.numbers > 0
        found[self.modes.numbers[numbered] - 1] = self.modes.frequencies[numbered]
        return found

    def damped_shifts(self, mode: int, order: float) -> tuple[float, ...]:
        """Return the critical speeds of an order and a mode with damping over those without, peak by peak.

        Beyond the assessed speeds this is the ratio of the mode's frequencies.
        """
        undamped = float(self.modes.undamped[mode - 1])
        met = [
            one for one in self.resonances if one.order == order and mode in (one.mode, *one.modes)
        ]
        if not met:
            return (float(self.frequencies[mode - 1]) / undamped,)
        return tuple(one.frequency / undamped for one in met if one.has_peak and mode in one.modes)

    @property
    def peaks(self) -> tuple[DampedCritical, ...]:
        """The resonances that have a speed and `LEAST_PEAK` of a place's largest peak, or more."""
        return tuple(
            one
            for one in self.resonances
            if one.has_peak and one.in_band and one.severity >= LEAST_PEAK
        )

    @property
    def free_end(self) -> OrderSeries:
        """Motion of the free end [rad or m], relative to that of the rigid body, one location."""
        return first_places(self.response.elastic, 1)

    @property
    def crank_elements(self) -> OrderSeries:
        """Torque or force in the elements of the crankshaft itself, from the free end."""
        return first_places(self.loads.elements, crank_element_count(self.engine_chain))

    @property
    def speed_parts(self) -> dict[str, NDArray[np.bool_]]:
        """Which speeds are "running", "below", and "above" as far as assessed."""
        speeds = self.response.speeds
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
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        show : {"amplitude", "load", "stress", "power", "axial forces"}
            Motion of the free end; torque or force in the crankshaft's element with the largest load at
            running speeds; nominal stress in the element with the largest one; power in and out; the
            exciting axial force of the first throw.
        limits : mapping of str to (S,) array_like, optional
            Limits over the response's speeds by their name [SI], not applicable to power and axial forces.
        barred : sequence of (low, high), optional
            Speed ranges to shade [rad/s], not applicable to power and axial forces.

        Returns
        -------
        matplotlib.axes.Axes

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
        axial = self.kind == "axial"
        if show == "stress":
            if self.stress is None:
                raise self._missing(show)
            return self.stress.plot(
                axes,
                self.largest_place(self.stress),
                quantity="stress",
                limits=limits,
                barred=barred,
                running=self.running_range,
            )
        if show == "load":
            series = self.crank_elements
            quantity: Quantity = "force" if axial else "torque"
            return series.plot(
                axes,
                self.largest_place(series),
                quantity=quantity,
                limits=limits,
                barred=barred,
                running=self.running_range,
            )
        moved = MOTION[self.kind].quantity
        axes = self.free_end.plot(
            axes, 0, quantity=moved, limits=limits, barred=barred, running=self.running_range
        )
        write_title(axes, f"{self.kind.capitalize()} vibration of the free end")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the resonances at the speeds assessed.

        With the amplitude of the free end, and the value in SI at the place of the peak.

        A resonance without a peak has no speed (NaN).

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        names = {"amplitude": "value", "first_amplitude": "amplitude"}
        frame = table_of(self.resonances).rename(columns=names)
        units = frame.attrs["units"]
        frame.attrs["units"] = {names.get(name, name): unit for name, unit in units.items()}
        frame.attrs["units"]["amplitude"] = MOTION[self.kind].si
        return frame

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
    speeds: FloatArray | None = None,
    limits_alone: bool = False,
) -> tuple[ForcedVibration, ForcedVibration]:
    """Calculate the forced vibration of an engine's chains over its speeds.

    Parameters
    ----------
    engine_file : EngineFile
    harmonics : CylinderHarmonics
        From `engine_harmonics`.
    axial, torsional : Vibration
        Modes of the chains with the chosen compliances.
    shaft : ShaftCompliances
        Of the throws in the shaft.
    analysis : ThrowAnalysis or mapping
        Of the engine's throw, or of each throw by its name.
    further : (m,) array, optional
        Further natural frequencies to be resolved by the speeds [Hz].
    speeds : (S,) array, optional
        Ascending, to calculate at these alone [rad/s]: neither worst speeds between
        them nor resonances are then searched for.
    limits_alone : bool, optional
        Whether to omit resonances and the comparison of axial forces, which have no limits.

    Returns
    -------
    axial, torsional : ForcedVibration
        On one grid of speeds, that of `calculated_speeds` and the speeds with the largest use of each limit.
        Axial vibration is excited by the radial forces and by the torques of the torsional
        vibration.
    """
    chains = EngineChains.of(engine_file, axial, torsional, shaft)

    def answers(speeds: FloatArray) -> Answers:
        return chains.answers(forces_over_speeds(engine_file, harmonics, speeds))

    if speeds is not None:
        return _vibrations(chains, forces_over_speeds(engine_file, harmonics, speeds))
    # The worst speeds are looked for among those of the chains alone, so that what else is to be
    # calculated has no part in them.
    own = calculated_speeds(engine_file, harmonics.orders, chains.damped)
    worst = _worst_speeds(engine_file, answers, own)
    speeds = (
        calculated_speeds(engine_file, harmonics.orders, chains.damped, further)
        if len(further)
        else own
    )
    forces = forces_over_speeds(engine_file, harmonics, merged_speeds(speeds, worst))
    if limits_alone:
        return _vibrations(chains, forces)
    compliances = chains.pulled.compliances
    compared = compared_axial_forces(engine_file, forces, compliances, shaft, analysis)
    lengthened, twisted = _vibrations(chains, forces)
    lengthened = replace(lengthened, axial_forces=compared)
    limited = [
        name
        for limit in engine_limits(engine_file)[0]
        for name in limited_series(limit, engine_file, lengthened, twisted).names
    ]
    return (
        replace(lengthened, resonances=resonances_of(engine_file, lengthened, limited)),
        replace(twisted, resonances=resonances_of(engine_file, twisted, limited)),
    )


def _vibrations(
    chains: EngineChains, forces: CylinderForces
) -> tuple[ForcedVibration, ForcedVibration]:
    """Return the axial and the torsional vibration under forces of the cylinders."""
    lengthened, twisted = (
        _vibration(chains.engine_file, forces, damped, answer)
        for damped, answer in zip(chains.damped, chains.answers(forces), strict=True)
    )
    return lengthened, twisted


def _vibration(
    engine_file: EngineFile, forces: CylinderForces, damped: DampedChain, answer: ChainAnswer
) -> ForcedVibration:
    """Return all results of one chain, except its resonances and the comparison of axial forces."""
    engine, ends = engine_file.engine, assessment_end_speeds(engine_file)
    kind, response = answer.engine_chain.kind, answer.response
    return ForcedVibration(
        kind=kind,
        engine_chain=answer.engine_chain,
        damping=damped.record,
        remarks=(*excitation_remarks(engine_file, kind), *answer.remarks),
        forces=forces,
        response=response,
        loads=answer.loads,
        stress=answer.stress,
        power=checked_power_balance(response),
        resonances=(),
        by_torque=answer.by_torque,
        axial_forces=None,
        running_range=(engine.lowest_speed, engine.highest_speed),
        judged_range=(ends[0], min(ends[-1], float(response.speeds[-1]))),
    )


def _worst_speeds(
    engine_file: EngineFile, answers: Callable[[FloatArray], Answers], speeds: FloatArray
) -> FloatArray:
    """Speeds with the largest use of the limits and motion of the free ends, closer than the grid."""
    return refined_maxima(lambda some: _limit_usage(engine_file, answers(some)), speeds, least=1.0)


def _limit_usage(engine_file: EngineFile, answers: Answers) -> FloatArray:
    """Used shares of the limits where they apply, (curves, speeds), and free ends' amplitudes."""
    engine = engine_file.engine
    running = (engine.lowest_speed, engine.highest_speed)
    speeds = answers[0].response.speeds
    used = [
        np.where(speeds <= limit_end_speed(limit, running), usage(limit, curve), 0.0)
        for limit, curve in limit_findings(engine_file, *answers)
    ]
    # Speeds below the running ones are passed on starting: their maxima are for themselves.
    kept = [np.where(within(speeds, *running), own, 0.0) for own in used]
    moved = [own.free_end.synthesis.amplitude[:, 0] for own in answers]
    return np.array([*used, *kept, *moved])
