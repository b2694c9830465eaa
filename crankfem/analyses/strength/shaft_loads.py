"""Largest alternating torque and axial force in each throw, in normal firing and with misfiring."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, failing_harmonics
from crankfem.analyses.vibration.forced import ChainAnswer, EngineChains
from crankfem.analyses.vibration.misfiring import Cylinders, Series, Superposition, misfiring_cases
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile
from dynamics.chains.engine_chains import EngineChain
from dynamics.indices import within
from dynamics.response.series import OrderSeries, synthesis

# Highest order that the rule asks for, by strokes.
HIGHEST_ORDER = {2: 15.0, 4: 12.0}


@summarized("value", "speed [rad/s]", "cylinders")
@dataclass(frozen=True)
class LargestLoad:
    """The largest alternating load of a throw at the speeds that count.

    Attributes
    ----------
    value : float
        Half of the distance from lowest to highest over the cycle [N m or N]; inf where unbounded.
    speed : float
        [rad/s]
    cylinders : tuple of int
        Misfiring cylinders; none in normal firing.
    """

    value: float
    speed: float
    cylinders: Cylinders


@dataclass(frozen=True, eq=False)
class ShaftLoads:
    """Largest alternating loads of every throw, from the free end.

    Attributes
    ----------
    normal, misfiring : tuple of LargestLoad
        Torque next to each throw; misfiring in the worst case, empty if not calculated.
    axial : tuple of LargestLoad
        Axial force through each throw in normal firing, without the part of its own pin's lengthening.
    passed_on : tuple of float
        Largest sum of the engine's mean torque and a throw's alternating one [N m].
    barred : tuple of pairs of float
        Excluded ranges [rad/s].
    """

    normal: tuple[LargestLoad, ...]
    misfiring: tuple[LargestLoad, ...]
    axial: tuple[LargestLoad, ...]
    passed_on: tuple[float, ...]
    barred: tuple[tuple[float, float], ...]

    def torque(self, throw: int) -> LargestLoad:
        """Return the largest torque of a throw, from 0, in all cases of firing."""
        both = (self.normal, self.misfiring)
        return max((own[throw] for own in both if own), key=lambda load: load.value)


def shaft_loads(vibration: EngineVibration, mechanism: MechanismFile) -> ShaftLoads:
    """Find the largest alternating loads at running speeds outside barred ranges.

    Parameters
    ----------
    vibration : EngineVibration
        With forced vibration: its speeds include every resonance, its verdict the barred ranges.
    mechanism : MechanismFile
        Of the same engine.

    Notes
    -----
    Orders up to 15 (two-stroke) and 12 (four-stroke) are summed over the cycle. A throw has the larger
    torque of the shaft's elements on its two sides.
    """
    forced = vibration.forced_torsional
    assert forced is not None
    kept, barred = judged_speeds(vibration)
    speeds = forced.response.speeds
    largest = dict(_cases(vibration, mechanism, speeds[kept]))
    normal, axial = largest.pop(())
    mean = np.abs(forced.forces.mean_torque[kept])[:, np.newaxis]
    worst: list[LargestLoad] = []
    passed_on = np.max(mean + normal, axis=0)
    for throw in range(normal.shape[1] if largest else 0):
        each = {case: own[:, throw] for case, (own, _) in largest.items()}
        worst.append(
            max((_largest(own, speeds[kept], case) for case, own in each.items()), key=_value)
        )
    for own, _ in largest.values():
        passed_on = np.maximum(passed_on, np.max(mean + own, axis=0))
    return ShaftLoads(
        normal=tuple(_largest(own, speeds[kept], ()) for own in normal.T),
        misfiring=tuple(worst),
        axial=tuple(_largest(own, speeds[kept], ()) for own in axial.T),
        passed_on=tuple(passed_on.tolist()),
        barred=barred,
    )


def judged_speeds(
    vibration: EngineVibration,
) -> tuple[NDArray[np.bool_], tuple[tuple[float, float], ...]]:
    """Return which speeds of the forced vibration are running ones that are not barred, and the ranges."""
    file, forced = vibration.engine_file, vibration.forced_torsional
    assert forced is not None
    assert vibration.assessment is not None  # of an engine with gas pressure
    barred = tuple(vibration.assessment.verdict.ranges_to_bar)
    speeds = forced.response.speeds
    kept = within(speeds, file.engine.lowest_speed, file.engine.highest_speed)
    for low, high in barred:
        kept &= (speeds <= low) | (speeds >= high)
    return kept, barred


def superposition(vibration: EngineVibration, mechanism: MechanismFile) -> Superposition:
    """Return the sums of torques and axial forces of throws in normal firing and misfiring."""
    file = vibration.engine_file
    chains = EngineChains.of(file, vibration.axial, vibration.torsional, vibration.shaft)
    firing = engine_harmonics(file, mechanism)
    failing = firing
    if vibration.misfiring is not None:
        failing = failing_harmonics(file, mechanism, firing)
    return Superposition(chains, firing, failing, _loads)


def _cases(
    vibration: EngineVibration, mechanism: MechanismFile, speeds: FloatArray
) -> Iterator[tuple[Cylinders, tuple[FloatArray, FloatArray]]]:
    """Return amplitudes of torque and axial force of each throw (S, n) in normal firing and each case."""
    file, added = vibration.engine_file, superposition(vibration, mechanism)
    cases = () if vibration.misfiring is None else misfiring_cases(file)
    for case, series in added.at(speeds, [(), *cases]):
        yield (
            case,
            (
                _beside_throws(_amplitude(file, series["torsional"]), added.chains.cranks),
                _amplitude(file, series["axial"]),
            ),
        )


def _loads(_: EngineFile, axial: ChainAnswer, torsional: ChainAnswer) -> Series:
    return {"axial": _through_throws(axial), "torsional": torsional.loads.elastic}


def _through_throws(axial: ChainAnswer) -> OrderSeries:
    """Return the axial force through each throw.

    In the chain the forces on a throw's pin push its ends apart with P; the spring between them carries P
    even where the ends are free and no force passes through the throw. So P is subtracted.
    """
    throws, elastic = axial.engine_chain.throws, axial.loads.elastic
    before = list(axial.engine_chain.sections[:throws])
    pressing = -np.cumsum(axial.response.excitation.forces[:, :, before], axis=2)
    return replace(
        elastic, values=elastic.values[:, :, :throws] - pressing, names=elastic.names[:throws]
    )


def _amplitude(file: EngineFile, series: OrderSeries) -> FloatArray:
    """Sum the orders that the rule counts, (S, p)."""
    counted = series.orders <= HIGHEST_ORDER[file.engine.strokes]
    return synthesis(
        series.orders[counted], series.speeds, series.values[counted], series.unbounded[counted]
    ).amplitude


def _beside_throws(amplitude: FloatArray, cranks: EngineChain) -> FloatArray:
    """Return the larger amplitude of the elements next to each throw, (S, n), from those of all (S, e)."""
    ends = cranks.chain.connections[: cranks.crank_elements]
    beside = [[e for e, own in enumerate(ends) if node in own] for node in cranks.throw_nodes]
    return np.stack([np.max(amplitude[:, places], axis=1) for places in beside], axis=1)


def _largest(values: FloatArray, speeds: FloatArray, case: Cylinders) -> LargestLoad:
    place = int(np.argmax(values))
    return LargestLoad(float(values[place]), float(speeds[place]), case)


def _value(load: LargestLoad) -> float:
    return load.value
