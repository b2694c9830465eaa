"""Axial force of an engine's crankshaft over the cycle, at its thrust bearing and between its ends."""

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.quantity import RPM
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.engine_excitation import forces_over_speeds
from crankfem.analyses.vibration.forced import EngineChains, ForcedVibration
from crankfem.files.engine.engine_file import EngineFile
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.cycle import cycle_degrees, even_angles
from dynamics.excitation.chain_excitation import (
    AxialForceOverCycle,
    axial_force_over_cycle,
    tangential_towards_flywheel,
)
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.indices import within

MEAN_LEFT_OUT = ", without the propeller's mean thrust"


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
    moved = None
    if not np.any(pulled.response.unbounded):
        node = pulled.engine_chain.sections[file.thrust_bearing.section_index]
        moved = pulled.response.nodes.at_angle(0, shaft_angle_deg=angles)[:, node]
    return axial_force_over_cycle(
        file.engine.rated_speed,
        on_pins,
        shaft.axial,
        influence,
        None if moved is None else file.thrust_bearing.stiffness * moved,
        shaft_angles_deg=angles,
    )


def axial_cycle_record(
    cycle: AxialForceOverCycle,
    forced: ForcedVibration,
    engine_file: EngineFile,
    coupled: CoupledResponse | None = None,
) -> Record:
    """Return the extremes over the cycle, and the thrust bearing's largest force at running speeds [SI].

    Parameters
    ----------
    coupled : CoupledResponse, optional
        Of the whole crankshaft, if it has the same bodies as the chain.
    """
    thrust = engine_file.thrust_bearing
    on_bearing, running = cycle.thrust_bearing, forced.running_range
    node = forced.engine_chain.sections[thrust.section_index]
    by_chain = thrust.stiffness * forced.response.synthesis.amplitude[:, node]
    whole = None
    if coupled is not None:
        moved = coupled.split(f"main bearing {thrust.main_bearing} uz").both_sum
        whole = _largest(coupled.speeds, thrust.stiffness * moved, running)
    record: Record = {
        "speed_rpm": cycle.speed * RPM,
        "thrust_bearing": None if on_bearing is None else _extremes(cycle, on_bearing),
        "held": _extremes(cycle, cycle.held),
        "throws": [_extremes(cycle, own) for own in cycle.throws.T],
        "running": _largest(forced.response.speeds, by_chain, running),
        "running_whole": whole,
    }
    alone = engine_file.propeller_forces is None
    return record | {"sentences": _sentences(record, "" if alone else MEAN_LEFT_OUT)}


def axial_cycle_columns(cycle: AxialForceOverCycle) -> tuple[dict[str, FloatArray], str]:
    """Return all forces over the shaft angle, and a description."""
    return cycle.columns(), (
        f"axial forces over the cycle at {cycle.speed * RPM:.10g} 1/min: on the thrust bearing with "
        "vibration, on held ends without vibration, pressing each throw's ends apart"
    )


def _extremes(cycle: AxialForceOverCycle, force: FloatArray) -> Record:
    """Lowest and highest value of a force [N], and their angles."""
    low, high = int(np.argmin(force)), int(np.argmax(force))
    degrees = cycle.shaft_angles_deg
    return {
        "lowest": float(force[low]),
        "lowest_angle_deg": float(degrees[low]),
        "highest": float(force[high]),
        "highest_angle_deg": float(degrees[high]),
    }


def _largest(
    speeds: FloatArray, amplitude: FloatArray, running: tuple[float, float]
) -> Record | None:
    """Largest amplitude of a force at running speeds [N], and its speed; None where unbounded."""
    inside = np.flatnonzero(within(speeds, *running))
    worst = int(inside[np.argmax(amplitude[inside])])
    if not np.isfinite(amplitude[worst]):
        return None
    return {"amplitude": float(amplitude[worst]), "speed_rpm": float(speeds[worst] * RPM)}


def _sentences(record: Record, left_out: str) -> list[str]:
    sentences = []
    if record["thrust_bearing"] is not None:
        sentences.append(
            f"Axial force on the thrust bearing at {record['speed_rpm']:.4g} 1/min, with vibration: "
            f"{_range(record['thrust_bearing'])} over the cycle by the axial chain, positive towards the "
            f"flywheel{left_out}."
        )
    models = (("running", "by the chain"), ("running_whole", "by the whole crankshaft"))
    largest = [
        f"{_kilo(own['amplitude'])} kN {model}, at {own['speed_rpm']:.4g} 1/min"
        for own, model in ((record[name], model) for name, model in models)
        if own is not None
    ]
    if largest:
        sentences.append(
            "Its largest amplitude at running speeds, for which the bearing is to be checked: "
            f"{'; '.join(largest)}."
        )
    return [
        *sentences,
        "For comparison with static formulas only: with both ends of the crankshaft held and no vibration, "
        f"the ends would carry {_range(record['held'])} over the cycle at {record['speed_rpm']:.4g} 1/min, "
        "positive where the shaft pushes them apart. A single thrust bearing carries none of this force.",
    ]


def _range(record: Record) -> str:
    return f"{_kilo(record['lowest'])} kN to {_kilo(record['highest'])} kN"


def _kilo(force: float) -> str:
    return f"{force / 1e3:.3g}"
