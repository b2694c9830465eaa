"""Axial force of an engine's crankshaft over the cycle, at its thrust bearing and between its ends."""

from functools import cached_property
from typing import Annotated, TypeAlias

import numpy as np

from crankbase.array_checks import Array
from crankbase.quantity import RPM
from crankbase.results import Internal, Part, Quantity, Result, Speed, result
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import forces_over_speeds
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.engine_sections import ThrustBearing
from dynamics import wording
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.cycle import cycle_degrees, even_angles
from dynamics.excitation.chain_excitation import (
    AxialForceOverCycle,
    axial_force_over_cycle,
    tangential_towards_flywheel,
)
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.indices import within
from dynamics.response.order_excitation import at_angles
from dynamics.response.series import extreme_angles

# Orders of a force below this share of its largest one are round-off.
ROUND_OFF = 1e-12
Newtons: TypeAlias = Annotated[float, Quantity("N")]
Degrees: TypeAlias = Annotated[float, Quantity("deg")]


@result("lowest", "highest", eq=True)
class Extremes(Result):
    """Lowest and highest value of a force over the cycle, and their shaft angles."""

    lowest: Newtons
    lowest_angle_deg: Degrees
    highest: Newtons
    highest_angle_deg: Degrees


@result("amplitude", "speed", eq=True)
class LargestForce(Result):
    """Largest amplitude of a force at running speeds."""

    amplitude: Newtons
    speed: Speed


@result("speed", "thrust_bearing", "held")
class AxialForces(Result):
    """Extremes of axial forces over the cycle, and the thrust bearing's largest amplitude.

    Attributes
    ----------
    thrust_bearing : Extremes or None
        With vibration; None where that is unbounded.
    held : Extremes
        On held ends without vibration.
    throws : tuple of Extremes
        With which each throw pushes its ends apart.
    running, running_whole : LargestForce or None
        On the thrust bearing, by the chain and by the whole crankshaft; None where unbounded or unknown.
    mean_left_out : bool
        Whether a propeller's mean thrust is missing.
    """

    speed: Speed
    thrust_bearing: Extremes | None
    held: Extremes
    throws: tuple[Extremes, ...]
    running: LargestForce | None
    running_whole: LargestForce | None
    mean_left_out: Internal[bool]

    @cached_property
    def sentences(self) -> Part[tuple[str, ...]]:
        """What the thrust bearing carries, and held ends would."""
        sentences, forces, held = [], self.thrust_bearing, self.held
        if forces is not None:
            sentences.append(
                wording.force_on_thrust_bearing(
                    self.speed, forces.lowest, forces.highest, self.mean_left_out
                )
            )
        models = {"chain": self.running, "whole crankshaft": self.running_whole}
        largest = {name: (force.amplitude, force.speed) for name, force in models.items() if force}
        if largest:
            sentences.append(wording.largest_thrust(largest))
        return (*sentences, wording.force_on_held_ends(self.speed, held.lowest, held.highest))


def axial_cycle(chains: EngineChains, harmonics: CylinderHarmonics) -> AxialForceOverCycle:
    """Calculate the axial forces over the cycle at rated speed, at every degree of it.

    Parameters
    ----------
    harmonics : CylinderHarmonics
        From `engine_harmonics`; its orders and the mean are summed.

    Returns
    -------
    AxialForceOverCycle
        Between held ends, the torque of the cylinders goes to the flywheel, as in running.
    """
    file, shaft = chains.engine_file, chains.shaft
    forces = forces_over_speeds(file, harmonics, np.array([file.engine.rated_speed]))
    degrees = cycle_degrees(file.engine.strokes)
    angles = even_angles(degrees, int(degrees))
    tangential, radial = forces.at_angle(0, shaft_angle_deg=angles)
    on_pins = np.zeros((len(angles), shaft.influence.shape[1], 2))
    for cylinder, pin in enumerate(file.pins):
        on_pins[:, pin, 0] += radial[:, cylinder]
        on_pins[:, pin, 1] += tangential[:, cylinder]
    # The finite elements count angles as the file does, T is positive as the shaft turns.
    by_torque = file.engine.turning_sense * tangential_towards_flywheel(
        shaft.tangential, shaft.through, file.throw.crank_radius
    )
    influence = np.stack((shaft.influence, by_torque), axis=-1)
    pulled, _ = chains.answers(forces)
    moved, thrust = None, file.required(ThrustBearing)
    if not np.any(pulled.response.unbounded):
        node = pulled.engine_chain.sections[thrust.section_index]
        moved = pulled.response.nodes.at_angle(0, shaft_angle_deg=angles)[:, node]
    return axial_force_over_cycle(
        file.engine.rated_speed,
        on_pins,
        shaft.axial,
        influence,
        None if moved is None else thrust.stiffness * moved,
        shaft_angles_deg=angles,
    )


def axial_forces(
    cycle: AxialForceOverCycle,
    forced: ForcedVibration,
    engine_file: EngineFile,
    coupled: CoupledResponse | None = None,
) -> AxialForces:
    """Return the extremes over the cycle, and the thrust bearing's largest force at running speeds.

    Parameters
    ----------
    coupled : CoupledResponse, optional
        Of the whole crankshaft, if it has the same bodies as the chain.
    """
    thrust, running = engine_file.required(ThrustBearing), forced.running_range
    node = forced.engine_chain.sections[thrust.section_index]
    by_chain = thrust.stiffness * forced.response.synthesis.amplitude[:, node]
    whole = None
    if coupled is not None:
        moved = coupled.split(f"main bearing {thrust.main_bearing} uz").both_sum
        whole = _largest(coupled.speeds, thrust.stiffness * moved, running)
    on_bearing = cycle.thrust_bearing
    return AxialForces(
        speed=cycle.speed,
        thrust_bearing=None if on_bearing is None else _extremes(cycle, on_bearing),
        held=_extremes(cycle, cycle.held),
        throws=tuple(_extremes(cycle, force) for force in cycle.throws.T),
        running=_largest(forced.response.speeds, by_chain, running),
        running_whole=whole,
        mean_left_out=engine_file.propeller_forces is not None,
    )


def axial_cycle_columns(cycle: AxialForceOverCycle) -> tuple[dict[str, Array], str]:
    """Return all forces over the shaft angle, and a description."""
    return cycle.columns(), (
        f"axial forces over the cycle at {cycle.speed * RPM:.10g} 1/min: on the thrust bearing with "
        "vibration, on held ends without vibration, pressing each throw's ends apart"
    )


def _extremes(cycle: AxialForceOverCycle, force: Array) -> Extremes:
    """Return those between the samples too, from which all orders of a force follow."""
    mean, *phasors = np.fft.rfft(force) / force.size
    turns = force.size * (cycle.shaft_angles_deg[1] - cycle.shaft_angles_deg[0]) / 360.0
    orders, waves = np.arange(1, len(phasors) + 1) / turns, 2.0 * np.array(phasors)
    acting = np.abs(waves) > ROUND_OFF * np.max(np.abs(waves))
    if not np.any(acting):
        return Extremes(float(mean.real), 0.0, float(mean.real), 0.0)
    highest, lowest = extreme_angles(orders[acting], waves[acting])
    angles = np.array([lowest, highest])
    values = mean.real + at_angles(orders[acting], waves[acting], angles)
    degrees = np.degrees(angles) % (360.0 * turns)
    return Extremes(*np.column_stack((values, degrees)).reshape(-1).tolist())


def _largest(speeds: Array, amplitude: Array, running: tuple[float, float]) -> LargestForce | None:
    inside = np.flatnonzero(within(speeds, *running))
    worst = int(inside[np.argmax(amplitude[inside])])
    if not np.isfinite(amplitude[worst]):
        return None
    return LargestForce(float(amplitude[worst]), float(speeds[worst]))
