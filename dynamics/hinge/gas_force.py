"""The gas force on the piston of a crosshead engine, from a pressure or from the cycle model."""

from crankbase.checks.arrays import FloatArray

from dynamics.engine.gas_forces import Pressure, gas_forces, piston_position
from dynamics.gas.cycle_values import usual_gas_cycle
from dynamics.gas.gas_cycle import GasCycleResult, gas_cycle
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.hinge.crosshead import CrossheadEngine
from dynamics.hinge.moment import GasForce


def piston_gas_force(
    engine: CrossheadEngine, pressure: Pressure, pressure_below: float = ATMOSPHERE
) -> GasForce:
    """Return the gas force as a function of the crank angle.

    Parameters
    ----------
    engine : CrossheadEngine
    pressure : GasPressure
        Two-stroke, over the angle from the top.
    pressure_below : float, optional
        Absolute pressure on the lower side of the piston [Pa].

    Returns
    -------
    callable
        Force towards the shaft [N] at crank angles [rad] of shape (m,).
    """
    layout = engine.layout

    def force(angles: FloatArray) -> FloatArray:
        found: FloatArray = gas_forces(layout, angles, pressure, pressure_below)[0]
        return found

    return force


def two_stroke_cycle(
    engine: CrossheadEngine,
    compression_ratio: float,
    *,
    peak_pressure: float,
    mean_effective_pressure: float,
    intake_pressure: float,
    **parameters: float,
) -> GasCycleResult:
    """Calculate the pressure over a two-stroke cycle from three pressures.

    Parameters
    ----------
    engine : CrossheadEngine
    compression_ratio : float
        Largest over smallest volume.
    peak_pressure, mean_effective_pressure, intake_pressure : float
        Highest pressure, absolute; indicated mean pressure; and pressure of the charge, absolute
        [Pa]. The duration of the combustion follows from them.
    **parameters : float
        Any others of `GasCycle`.

    Raises
    ------
    InputError
        As `gas_cycle`.
    """
    cycle = usual_gas_cycle(
        compression_ratio, strokes=2, intake_pressure=intake_pressure, **parameters
    )
    return gas_cycle(
        cycle,
        piston_position(engine.layout, 1),
        engine.area,
        peak_pressure=peak_pressure,
        mean_effective_pressure=mean_effective_pressure,
        solve_for="combustion_duration",
    )
