"""Every throw of an engine on two supports, under the forces of its rods at rated speed."""

import numpy as np

from crankfem.analyses.vibration.engine_load import pressures_of_cylinders
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile, mechanism_of
from dynamics.engine.forces import mechanism_forces
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.strength.nominal import SupportedThrow
from dynamics.torque.cycle_samples import DEFAULT_SAMPLES, samples_and_gas


def supported_throws(
    engine: EngineFile, *, mechanism: MechanismFile | None = None
) -> tuple[SupportedThrow, ...]:
    """Return each single throw of an engine, with the forces of its rods over a cycle at rated speed.

    Parameters
    ----------
    engine : EngineFile
        With gas pressure.
    mechanism : MechanismFile, optional
        Of the same engine, if available.

    Returns
    -------
    tuple of SupportedThrow
        From the free end. A hinged rod acts through the main rod that carries it.

    Raises
    ------
    InputError
        If the pressure cannot be reached.
    """
    known = mechanism_of(engine) if mechanism is None else mechanism
    layout, speed, starts = known.layout, known.rated_speed, known.bearing_positions
    (pressure,) = pressures_of_cylinders(engine, known, np.array([speed]))
    angles, gas = samples_and_gas(layout, pressure, DEFAULT_SAMPLES, ATMOSPHERE)
    forces = mechanism_forces(layout, speed, gas, shaft_angles_deg=np.degrees(angles))
    found = []
    for place, throw in enumerate(engine.crank_throws):
        rods = [number for number, own in enumerate(engine.throws) if own == place]
        at = [layout.cylinders[number].position - starts[place] for number in rods]
        radial, tangential = forces.radial[rods], forces.tangential[rods]
        found.append(SupportedThrow(throw.length, at, radial, tangential))
    return tuple(found)
