"""Loads on the ends and the pin of every throw over the working cycle, at any speed and firing.

Torque and axial force through the throws are those of the chains, with all vibration. The rods' forces bend
the whole shaft in its elastic main bearings, without inertia. The torque that accelerates a throw's own
inertia acts at its pin, so that the torques at both ends of the throw are the chain's.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError
from crankbase.results import Internal, Quantity, Result, result
from crankbase.sentences import amount
from crankfem.analyses.shaft.throw_analyses import crank_analyses
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, failing_harmonics
from crankfem.analyses.vibration.engine_load import pressures_of_cylinders
from crankfem.analyses.vibration.misfiring import Cylinders, Series, Superposition, misfiring_cases
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from dynamics.engine.forces import mechanism_forces
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.indices import within, within_any
from dynamics.response.order_excitation import at_angles
from dynamics.response.series import OrderSeries, common_order, synthesis
from dynamics.strength.concentration import SupportedThrow
from dynamics.torque import DEFAULT_SAMPLES, samples_and_gas
from fem.superelement import (
    RZ,
    UZ,
    Superelement,
    section_rotation,
    shaft_unknowns,
    sharing_sections,
    solve_shaft,
)

# Highest order that the rule asks for, by strokes.
HIGHEST_ORDER = {2: 15.0, 4: 12.0}


@result("value", "speed", "cylinders", eq=True)
class LargestLoad(Result):
    """The largest alternating load of a throw at the speeds that count.

    Attributes
    ----------
    value : float
        Half of the distance from lowest to highest over the cycle; inf where unbounded.
    cylinders : tuple of int
        Misfiring cylinders; none in normal firing.
    """

    value: Annotated[float, Quantity(".unit", key="alternating_torque")]
    speed: Annotated[float, Quantity("rad/s", exported="1/min", key="torque_speed_rpm")]
    cylinders: Annotated[Cylinders, Quantity("1", key="misfiring")]
    unit: Internal[str] = "N m"


@dataclass(frozen=True, eq=False)
class ShaftLoads:
    """Largest alternating loads of every throw, from the free end.

    Attributes
    ----------
    normal, misfiring : tuple of LargestLoad
        Torque next to each throw; misfiring in the worst case, empty if not calculated.
    axial : tuple of LargestLoad
        Axial force through each throw in normal firing.
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
        return max((loads[throw] for loads in both if loads), key=lambda load: load.value)


def shaft_loads(vibration: EngineVibration) -> ShaftLoads:
    """Find the largest alternating loads at running speeds outside barred ranges.

    Parameters
    ----------
    vibration : EngineVibration
        With forced vibration: its speeds include every resonance, its verdict the barred ranges.

    Notes
    -----
    Orders up to 15 (two-stroke) and 12 (four-stroke) are summed over the cycle. A throw has the larger
    torque of the shaft's elements on its two sides.
    """
    forced = vibration.forced_torsional
    assert forced is not None
    kept, barred = judged_speeds(vibration)
    speeds = forced.response.speeds
    file, added = vibration.engine_file, superposition(vibration)
    cases = () if vibration.misfiring is None else misfiring_cases(file)
    cranks = added.chains.cranks
    ends = cranks.chain.connections[: cranks.crank_elements]
    beside = [[e for e, nodes in enumerate(ends) if node in nodes] for node in cranks.throw_nodes]
    largest = {}
    for case, series in added.at(speeds[kept], [(), *cases]):
        torques = _amplitude(file, series["torsional"])
        # Amplitudes of torque and axial force of each throw (S, n); of the elements next to it the larger.
        larger = [np.max(torques[:, places], axis=1) for places in beside]
        largest[case] = (np.stack(larger, axis=1), _amplitude(file, series["axial"]))
    normal, axial = largest.pop(())
    mean = np.abs(forced.forces.mean_torque[kept])[:, np.newaxis]
    worst: list[LargestLoad] = []
    passed_on = np.max(mean + normal, axis=0)
    for throw in range(normal.shape[1] if largest else 0):
        each = {case: torques[:, throw] for case, (torques, _) in largest.items()}
        worst.append(
            max(
                (_largest(torques, speeds[kept], case) for case, torques in each.items()),
                key=lambda load: load.value,
            )
        )
    for torques, _ in largest.values():
        passed_on = np.maximum(passed_on, np.max(mean + torques, axis=0))
    return ShaftLoads(
        normal=tuple(_largest(torques, speeds[kept], ()) for torques in normal.T),
        misfiring=tuple(worst),
        axial=tuple(replace(_largest(force, speeds[kept], ()), unit="N") for force in axial.T),
        passed_on=tuple(passed_on.tolist()),
        barred=barred,
    )


def judged_speeds(
    vibration: EngineVibration,
) -> tuple[Flags, tuple[tuple[float, float], ...]]:
    """Return which speeds of the forced vibration are running ones that are not barred, and the ranges."""
    file, forced = vibration.engine_file, vibration.forced_torsional
    assert forced is not None
    assert vibration.assessment is not None  # of an engine with gas pressure
    barred = tuple(vibration.assessment.verdict.ranges_to_bar)
    speeds = forced.response.speeds
    running = within(speeds, file.engine.lowest_speed, file.engine.highest_speed)
    return running & ~within_any(speeds, barred), barred


def superposition(vibration: EngineVibration) -> Superposition:
    """Return the sums of torques and axial forces of throws in normal firing and misfiring."""
    file = vibration.engine_file
    chains = EngineChains.of(file, vibration.axial, vibration.torsional, vibration.shaft)
    firing = engine_harmonics(file)
    failing = firing
    if vibration.misfiring is not None:
        failing = failing_harmonics(file, firing)
    return Superposition(
        chains,
        firing,
        failing,
        lambda _, axial, torsional: {
            "axial": axial.crank_elements,
            "torsional": torsional.loads.elastic,
        },
    )


def _amplitude(file: EngineFile, series: OrderSeries) -> Array:
    """Sum the orders that the rule counts, (S, p)."""
    counted = series.orders <= HIGHEST_ORDER[file.engine.strokes]
    return synthesis(
        series.orders[counted], series.speeds, series.values[counted], series.unbounded[counted]
    ).amplitude


def _largest(values: Array, speeds: Array, case: Cylinders) -> LargestLoad:
    place = int(np.argmax(values))
    return LargestLoad(float(values[place]), float(speeds[place]), case)


def supported_throws(engine: EngineFile) -> tuple[SupportedThrow, ...]:
    """Return each single throw of an engine, with the forces of its rods over a cycle at rated speed.

    Parameters
    ----------
    engine : EngineFile
        With gas pressure.

    Returns
    -------
    tuple of SupportedThrow
        From the free end. A hinged rod acts through the main rod that carries it.

    Raises
    ------
    InputError
        If the pressure cannot be reached.
    """
    layout, speed, starts = engine.layout, engine.engine.rated_speed, engine.bearing_positions
    (pressure,) = pressures_of_cylinders(engine, np.array([speed]))
    angles, gas = samples_and_gas(layout, pressure, DEFAULT_SAMPLES, ATMOSPHERE)
    forces = mechanism_forces(layout, speed, gas, shaft_angles_deg=np.degrees(angles))
    supported = []
    for place, throw in enumerate(engine.crank_throws):
        rods = [number for number, carrying in enumerate(engine.throws) if carrying == place]
        at = [layout.cylinders[number].position - starts[place] for number in rods]
        radial, tangential = forces.radial[rods], forces.tangential[rods]
        supported.append(SupportedThrow(throw.length, at, radial, tangential))
    return tuple(supported)


# Samples over the cycle are so far apart or a little less [deg].
STEP_DEG = 2.0
# Loads on the pin, in the throw frame: Fx Fy Fz Mx My Mz.
FX, FY, MX, MY, MZ = 0, 1, 3, 4, 5


@dataclass(frozen=True, eq=False)
class CycleLoads:
    """Loads of all n throws at S speeds and m angles of the shaft, each in its throw frame.

    Attributes
    ----------
    cylinders : tuple of int
        Misfiring cylinders; none in normal firing.
    speeds : (S,) array
        [rad/s]
    angles : (m,) array
        Of the shaft, over the period of the vibration [rad].
    ends : (n, S, m, 12) array
        Forces and moments on both end sections [N, N m].
    pins : (n, S, m, 6) array
        Forces and moments on the pin.
    """

    cylinders: Cylinders
    speeds: Array
    angles: Array
    ends: Array
    pins: Array


@dataclass(frozen=True, eq=False)
class ShaftUnderForces:
    """Loads of every throw of a shaft per unit of each load on the shaft.

    Attributes
    ----------
    throws : tuple of n Superelement
        In their own frames.
    angles : (n,) array
        Of the cranks about +z [rad].
    bearings : float
        Lateral stiffness of each [N/m].
    """

    throws: tuple[Superelement, ...]
    angles: Array
    bearings: float

    def end_loads(self, pins: Array, torques: Array, axial: Array) -> Array:
        """Return the loads on the ends of every throw, in its own frame, (n, ..., 12).

        Parameters
        ----------
        pins : (n, ..., 6) array
            Loads on the pins, each in its throw frame.
        torques : (2, ...) array
            In the shaft before the first throw and behind the last, about +z: positive where the
            part behind turns forwards [N m].
        axial : (n, ...) array
            Tension through each throw [N].

        Notes
        -----
        Pin and end loads have to be in equilibrium about and along the shaft as a whole; the bearings
        carry the rest.
        """
        count, shape = len(self.throws), pins.shape[1:-1]
        turned = sharing_sections(
            [
                throw.turned(angle_deg=float(angle))
                for throw, angle in zip(self.throws, np.degrees(self.angles), strict=True)
            ]
        )
        sections = turned[0].sections
        parts = [shaft_unknowns(place, count, sections.bending) for place in range(count)]
        # Columns: six loads of each pin, then torques at both ends, then tension of each throw.
        loads = np.zeros((sections.count * (count + 1), 7 * count + 2))
        for place, throw in enumerate(turned):
            loads[parts[place], 6 * place : 6 * place + 6] = throw.pin_loads[0]
            loads[[6 * place + UZ, 6 * place + 6 + UZ], 6 * count + 2 + place] = -1.0, 1.0
        loads[RZ, 6 * count], loads[6 * count + RZ, 6 * count + 1] = -1.0, 1.0
        motions = solve_shaft(turned, loads, self.bearings)
        acting = np.concatenate(
            [
                np.moveaxis(pins, -1, 1).reshape(6 * count, -1),
                torques.reshape(2, -1),
                axial.reshape(count, -1),
            ]
        )
        reactions = np.empty((count, 12, acting.shape[1]))
        for place, throw in enumerate(turned):
            forces = throw.stiffness[:12] @ motions[parts[place]]
            forces[:, 6 * place : 6 * place + 6] -= throw.pin_loads[0][:12]
            back = np.kron(np.eye(2), section_rotation(-self.angles[place]))
            reactions[place] = back @ forces @ acting
        return np.moveaxis(reactions, 1, -1).reshape(count, *shape, 12)


def cycle_loads(
    vibration: EngineVibration,
    speeds: Array,
    cases: Iterable[Cylinders],
) -> Iterator[CycleLoads]:
    """Return the loads of every throw over the cycle, for each case of firing.

    Parameters
    ----------
    vibration : EngineVibration
        Of an engine with one pin in each throw.
    speeds : (S,) array
        [rad/s]
    cases : iterable of tuples of int
        Cylinders that misfire; none in normal firing.
    """
    added, shaft = superposition(vibration), shaft_under_forces(vibration)
    for case, series in added.at(speeds, cases):
        yield _case(vibration, shaft, added, case, series)


def shaft_under_forces(vibration: EngineVibration) -> ShaftUnderForces:
    """Return the whole shaft in its main bearings."""
    file = vibration.engine_file
    each = crank_analyses(file, vibration.analyses)
    return ShaftUnderForces(
        tuple(analysis.superelement for analysis in each),
        np.asarray(np.radians(file.throw_angles_deg)),
        file.main_bearings.stiffness,
    )


def _case(
    vibration: EngineVibration,
    shaft: ShaftUnderForces,
    added: Superposition,
    case: Cylinders,
    series: Series,
) -> CycleLoads:
    file, sense = vibration.engine_file, vibration.engine_file.engine.turning_sense
    torsional = series["torsional"]
    speeds = torsional.speeds
    for kind, vibrating in series.items():
        endless = np.any(vibrating.unbounded, axis=0)
        if np.any(endless):
            raise InputError(
                f"damping: given none for {kind} vibration that is unbounded at "
                f"{amount(speeds[np.argmax(endless)], 'rad/s', 4)}; allowed is some, because stresses over "
                "the cycle need a steady vibration."
            )
    forces = added.forces(speeds, case)
    _, common = common_order(torsional.orders)
    period = max(2.0 * np.pi / common, np.pi * file.engine.strokes)
    angles = np.arange(0.0, period - 1e-9, np.radians(STEP_DEG))
    count = len(shaft.throws)

    def over_cycle(values: OrderSeries | NDArray[np.complex128], orders: Array) -> Array:
        phasors = values.values if isinstance(values, OrderSeries) else values
        return np.asarray(np.moveaxis(at_angles(orders, phasors, angles), 0, 1))  # (S, m, p)

    tangential = over_cycle(forces.tangential, forces.orders) + forces.mean_tangential[:, None]
    radial = over_cycle(forces.radial, forces.orders) + forces.mean_radial[:, None]
    pins = np.zeros((count, speeds.size, angles.size, 6))
    layout, starts = file.layout, file.bearing_positions
    for cylinder, throw in enumerate(file.throws):
        (pin,) = file.crank_throws[throw].parts.pins
        along = layout.cylinders[cylinder].position - starts[throw]
        arm = along - 0.5 * (pin.start + pin.end)
        across, inward = sense * tangential[..., cylinder], radial[..., cylinder]
        pins[throw, ..., FX] -= across
        pins[throw, ..., FY] -= inward
        pins[throw, ..., MX] += arm * inward
        pins[throw, ..., MY] -= arm * across
    for throw, phasors in enumerate(crank_analyses(file, vibration.analyses)):
        # The throw's own centrifugal force, as if its mass went round with the pin.
        (pin,) = file.crank_throws[throw].parts.pins
        thrown = phasors.masses.mass * np.outer(speeds**2, phasors.masses.center[:2])[:, None]
        pins[throw, ..., [FX, FY]] += np.moveaxis(thrown, -1, 0)
    # Torques beside each throw: what turns the part behind forwards counts positive.
    elastic = sense * over_cycle(torsional, torsional.orders)
    driving = np.zeros((speeds.size, count))
    for cylinder, throw in enumerate(file.throws):
        driving[:, throw] += forces.crank_radius * forces.mean_tangential[:, cylinder]
    mean = -sense * np.cumsum(driving, axis=1)
    before, behind = np.zeros((2, count, speeds.size, angles.size))
    for throw, node in enumerate(added.chains.cranks.throw_nodes):
        if node:
            before[throw] = elastic[..., node - 1]
        if throw:
            before[throw] += mean[:, throw - 1, None]
        behind[throw] = elastic[..., node] + mean[:, throw, None]
        # The rest of the balance about the shaft is the throw's inertia.
        radius = file.crank_throws[throw].crank_radius
        pins[throw, ..., MZ] -= behind[throw] - before[throw] - radius * pins[throw, ..., FX]
    tension = np.moveaxis(over_cycle(series["axial"], series["axial"].orders), -1, 0)
    ends = shaft.end_loads(pins, np.stack([before[0], behind[-1]]), tension)
    return CycleLoads(case, speeds, angles, ends, pins)
