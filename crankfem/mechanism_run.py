"""Everything about an engine's crank mechanism at one speed: forces, loads, torque, work, balance."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crankfem.gas_pressure import motored_pressures
from crankfem.mechanism_file import MechanismFile, with_throws
from dynamics.balance.balance import Balance, balance
from dynamics.balance.hinged_rods import HingedRodEffects, hinged_rod_effects
from dynamics.engine.forces import MechanismForces, mechanism_forces, pin_groups
from dynamics.engine.gas_forces import gas_forces
from dynamics.engine.layout import EngineLayout
from dynamics.engine.loads import LoadDiagram, crankpin_loads, main_bearing_loads
from dynamics.engine.motions import piston_ends
from dynamics.gas.indicated import indicated_mean_effective_pressure
from dynamics.gas.pressure import GasPressure
from dynamics.mechanism.rods import ROD_MODELS, RodModelName
from dynamics.torque.torque import EngineTorque, engine_torque
from geometry.errors import InputError
from geometry.mass import MassProperties

BALANCE_ORDERS = (1, 2, 4)


@dataclass(frozen=True, eq=False)
class CylinderWork:
    """What the gas does in one cylinder.

    Parameters
    ----------
    peak_pressure, peak_angle : float
        Absolute [Pa], and its angle from the firing top [rad].
    work : float
        Indicated work of one cycle [J].
    mean_effective_pressure : float
        [Pa]
    """

    peak_pressure: float
    peak_angle: float
    work: float
    mean_effective_pressure: float


@dataclass(frozen=True, eq=False)
class MechanismRun:
    """Forces in an engine's mechanism over one cycle at constant speed.

    Parameters
    ----------
    mechanism : MechanismFile
    layout : EngineLayout
        With the unbalance of the throws.
    speed : float
        [rad/s]
    pressure : tuple of GasPressure
    forces : MechanismForces
    torque : EngineTorque
    crankpins, bearings : tuple of LoadDiagram
    works : tuple of CylinderWork
    balance : Balance
    hinged_rods : tuple of HingedRodEffects
        Of the first crankpin with such rods; empty if there is none.
    """

    mechanism: MechanismFile
    layout: EngineLayout
    speed: float
    pressure: tuple[GasPressure, ...]
    forces: MechanismForces
    torque: EngineTorque
    crankpins: tuple[LoadDiagram, ...]
    bearings: tuple[LoadDiagram, ...]
    works: tuple[CylinderWork, ...]
    balance: Balance
    hinged_rods: tuple[HingedRodEffects, ...]


def run_mechanism(
    mechanism: MechanismFile,
    speed: float | None = None,
    model: RodModelName | None = None,
    *,
    motored: bool = False,
    masses: MassProperties | None = None,
) -> MechanismRun:
    """Calculate an engine's mechanism at constant speed.

    Parameters
    ----------
    mechanism : MechanismFile
        From `load_mechanism`.
    speed : float, optional
        [rad/s]; the rated speed by default.
    model : str, optional
        Of the rods' masses; that of the file by default.
    motored : bool, optional
        Turn the engine without combustion.
    masses : MassProperties, optional
        Of one throw; from its solid if not given.

    Raises
    ------
    InputError
        If the file has no gas pressure, or the speed is not above zero.
    MeshError
        If the throw's solid, whose unbalance counts, cannot be built.
    """
    if mechanism.gas is None:
        raise InputError(
            f"{mechanism.path.name}: the section [gas] is missing; give it with peak_pressure, "
            "mean_effective_pressure or pressure_table, because gas loads the mechanism."
        )
    turning = mechanism.rated_speed if speed is None else speed
    rod_model = mechanism.rod_model if model is None else model
    layout = with_throws(mechanism, masses)
    pressure = motored_pressures(mechanism.gas, layout) if motored else mechanism.pressure
    torque = engine_torque(layout, turning, pressure, model=rod_model, throws=mechanism.throws)
    angles = torque.shaft_angles
    gas = gas_forces(layout, angles, pressure)
    forces = mechanism_forces(layout, angles, turning, gas, model=rod_model)
    return MechanismRun(
        mechanism=mechanism,
        layout=layout,
        speed=turning,
        pressure=pressure,
        forces=forces,
        torque=torque,
        crankpins=crankpin_loads(forces),
        bearings=main_bearing_loads(forces, mechanism.bearing_positions, turning),
        works=tuple(_works(torque, pressure)),
        balance=balance(
            layout,
            turning,
            BALANCE_ORDERS,
            about=0.5 * mechanism.bearing_positions[-1],
            model="two-mass" if model == "two-mass" else "rigid",
        ),
        hinged_rods=_hinged_rods(layout, turning),
    )


def _hinged_rods(layout: EngineLayout, speed: float) -> tuple[HingedRodEffects, ...]:
    groups = [group for group in pin_groups(layout) if len(group) > 1]
    return hinged_rod_effects(layout, speed, cylinders=groups[0]) if groups else ()


def _works(torque: EngineTorque, pressures: Sequence[GasPressure]) -> Iterator[CylinderWork]:
    works = torque.indicated_work.tolist()
    for place, (pressure, work) in enumerate(zip(pressures, works, strict=True)):
        low, high = piston_ends(torque.engine, place + 1)
        swept = torque.engine.cylinders[place].area * (high - low)
        yield CylinderWork(
            pressure.peak_pressure,
            pressure.peak_angle,
            work,
            indicated_mean_effective_pressure(work, swept),
        )


@dataclass(frozen=True)
class ModelComparison:
    """How far a rod model's forces are from those of the rigid rod.

    Parameters
    ----------
    model : str
    crankpin : float
        Largest difference of the force on a crankpin, vector to vector, beside its mean size.
    side : float
        Largest difference of the side force N, beside the largest N.
    """

    model: RodModelName
    crankpin: float
    side: float


def compare_rod_models(run: MechanismRun) -> tuple[ModelComparison, ...]:
    """Compare the rod models with the rigid rod, for the same gas and speed."""
    rigid = _with_model(run, "rigid")
    loads = crankpin_loads(rigid)
    found = []
    for name in ROD_MODELS[1:]:
        forces = _with_model(run, name)
        crankpin = max(
            float(np.max(np.abs(own.force - load.force))) / load.mean
            for own, load in zip(crankpin_loads(forces), loads, strict=True)
        )
        side = float(np.max(np.abs(forces.side - rigid.side)) / np.max(np.abs(rigid.side)))
        found.append(ModelComparison(name, crankpin, side))
    return tuple(found)


def _with_model(run: MechanismRun, model: RodModelName) -> MechanismForces:
    return mechanism_forces(
        run.layout, run.forces.shaft_angles, run.speed, run.forces.gas, model=model
    )


def bearing_sizes(mechanism: MechanismFile) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return diameter and length that one rod has on its pin, and of a main bearing [m]."""
    throw = mechanism.throw
    pins = throw.parts.pins
    main = set(range(1, len(mechanism.throws) + 1)) - {
        number
        for number, cylinder in enumerate(mechanism.layout.cylinders, start=1)
        if cylinder.slave_pin is not None
    }
    on_first = sum(mechanism.throws[number - 1] == 0 for number in main)
    rods_a_pin = max(1, math.ceil(on_first / len(pins)))
    return (
        (throw.pin_diameter, throw.pin_length / rods_a_pin),
        (throw.main_journal_diameter, throw.main_journal_length),
    )
